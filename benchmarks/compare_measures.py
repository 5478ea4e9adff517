"""How far two records of `compare_worker.py` are apart, and whether that is a difference.

Floats have two measures, since one number cannot serve both a curve and the small entries beside it:

- of scale: |a - b| over the largest |a| of what belongs together.  Along dims that carry names (meshes, coordinates,
  links) and along modes each entry has its own scale, but no less than 1e-4 of the largest one, so that a coordinate
  that only symmetry makes zero is not judged by its rounding.  Where the entries of a dim have units of their own
  (paths, objectives, rows of an audit) each stands alone.  Along time, speed and phase the scale is shared.
  Allowed: the tolerance.
- of entry: |a - b| over the larger of |a| and |b|, and over no less than 1e-6 of the scale.  A small entry that moves
  is seen, rounding is not.  Allowed: 1000 times the tolerance.

A residual is rounding itself: it is measured against 1, or against the largest of its kind where that is more.

Integers, booleans, texts, dims, units and the places of nan and infinity are equal or different.  Mode shapes are free
in sign, phase and, among modes of one frequency, basis: the sine of the largest angle between the spaces is taken.
Floquet multipliers are a set, and so are the curves of modes over speed or a parameter, of which two of one frequency
may begin in either order: they are paired where their order differs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth, subspace_angles
from scipy.optimize import linear_sum_assignment

__all__ = ["Finding", "compared", "excused"]

LEAST_SCALE, LEAST_ENTRY, ENTRY_FACTOR, ROUNDING_FACTOR = 1e-4, 1e-6, 1e3, 30.0
_SHAPES = ("shape", "full_shape")
_SETS = {
    "floquet_multiplier": "multiplier",
    "path_multiplier": "multiplier",
    "whirl_frequency": "mode",
    "frequency": "mode",
}
_OWN_UNIT = {"path", "variable", "objective", "row", "parameter", "solution"}
_COUNTED = {"mode"}
_IGNORED = {"version", "package", "options"}
_PROSE = {"reason", "because", "reading"}
_PROSE_FIELDS = ("warnings", "provenance")  # of a System
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

Record = Mapping[str, Any]
Values = NDArray[Any]


@dataclass(slots=True)
class Finding:
    """What two records differ in: failures with their places, wording and the like as notes.

    scale, entry : largest of both measures.  where : the variable that has the largest one in its tolerance.
    moved : what failed -> how many times its tolerance; infinite where it had to be equal.
    """

    scale: float = 0.0
    entry: float = 0.0
    where: str = ""
    failures: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    moved: dict[str, float] = field(default_factory=dict)
    _share: float = 0.0

    def fail(self, name: str, text: str, share: float = np.inf) -> None:
        """Something is different."""
        self.moved[name] = max(share, self.moved.get(name, 0.0))
        self.failures.append(f"{name}: {text}")

    def measure(self, name: str, scale: float, entry: float, tolerance: float) -> None:
        """Take one variable into account."""
        self.scale, self.entry = max(self.scale, scale), max(self.entry, entry)
        share = max(scale / tolerance, entry / (ENTRY_FACTOR * tolerance))
        if share > self._share:
            self._share, self.where = share, name
        if share > 1:
            self.fail(name, f"{scale:.1e} of scale, {entry:.1e} of entry", share)


def compared(old: Record, new: Record, tolerance: float) -> Finding:
    """Everything two records differ in."""
    found = Finding()
    if old["outcome"] != new["outcome"] or old["outcome"] in ("crash", "timeout"):
        found.fail("outcome", f"{_said(old)} -> {_said(new)}")
    elif old["outcome"] == "error":
        if new["type"] not in ("ModelError", "ConvergenceError"):  # alike on both sides, a case that computes nothing
            found.fail("fault", _said(new))
        for key in ("type", "path"):
            if old[key] != new[key]:
                found.fail(f"{key} of the error", f"{old[key]!r} -> {new[key]!r} ({new['message']})")
        if old["message"] != new["message"]:
            found.notes.append(f"message: {old['message']!r} -> {new['message']!r}")
    else:
        renamed = _renamed(old, new, found) if _is_tree(old) else {}
        _variables(old["variables"], new["variables"], renamed, tolerance, found)
        _attributes(old["attrs"], new["attrs"], tolerance, found)
    _caught(old.get("caught", []), new.get("caught", []), found)
    return found


def excused(found: Finding, rounding: Finding) -> Finding:
    """What is left of the failures once those are notes that rounding alone brings about, to a thirtieth at least."""
    left = Finding(scale=found.scale, entry=found.entry, where=found.where, notes=list(found.notes))
    for text in found.failures:
        name = next(name for name in found.moved if text.startswith(f"{name}: "))
        if rounding.moved.get(name, 0.0) * ROUNDING_FACTOR >= found.moved[name]:
            left.notes.append(f"as rounding does: {text}")
        else:
            left.failures.append(text)
            left.moved[name] = found.moved[name]
    return left


def _said(record: Record) -> str:
    if record["outcome"] == "error":
        return f"{record['type']} at {record['path']!r}: {record['message']}"
    return f"{record['outcome']} {record.get('message', '')}".strip()


def _is_tree(record: Record) -> bool:
    """Whether the record is of an assembled System, whose fields may be renamed, and no Dataset."""
    return not record["attrs"]


def _variables(old: Record, new: Record, renamed: Mapping[str, str], tolerance: float, found: Finding) -> None:
    labels = {name for name, entry in old.items() if entry[0] == (name,) and entry[1].dtype.kind in "OU"}
    groups = _mode_groups(old)
    for name, (dims, values, unit, long_name) in old.items():
        other = new.get(renamed.get(name, name))
        if other is None:
            found.fail(name, "missing")
            continue
        if other[0] != dims or np.shape(other[1]) != np.shape(values):
            found.fail(name, f"{dims} {np.shape(values)} -> {other[0]} {np.shape(other[1])}")
            continue
        if other[2] != unit:
            found.fail(name, f"unit {unit!r} -> {other[2]!r}")
        if other[3] != long_name:
            found.notes.append(f"{name}: long name {long_name!r} -> {other[3]!r}")
        _variable(name, values, other[1], (dims, labels, groups), tolerance, found)
    taken = set(old) | set(renamed.values())
    for name in new:
        if name not in taken:
            found.fail(name, "not there before")


def _variable(
    name: str,
    old: Values,
    new: Values,
    about: tuple[tuple[str, ...], set[str], list[NDArray[np.intp]]],
    tolerance: float,
    found: Finding,
) -> None:
    dims, labels, groups = about
    if old.dtype.kind not in "fc" or new.dtype.kind not in "fc":
        _exact(name, old, new, found)
        return
    if not _same_gaps(old, new):
        found.fail(name, "nan or infinity elsewhere")
        return
    old, new = (np.where(np.isfinite(values), values, 0) for values in (old, new))
    own = [axis for axis, dim in enumerate(dims) if dim in labels | _COUNTED | _OWN_UNIT]
    alone = any(dim in _OWN_UNIT for dim in dims)
    scale, entry = measures(old, new, own, alone=alone, least=1.0 if "residual" in name else 0.0)
    if scale > 0 and name in _SHAPES and groups and dims[-1:] == ("mode",):
        count = old.shape[-1]
        moved = _turned(old.reshape(-1, count), new.reshape(-1, count), groups)
        if moved < scale:
            found.notes.append(f"{name}: another sign, phase or basis in a group of modes ({scale:.1e})")
            scale = entry = moved
    elif scale > tolerance and dims[-1:] == ("mode",) and groups:
        sums = [np.stack([values[..., group].sum(-1) for group in groups], -1) for values in (old, new)]
        scale, entry = measures(sums[0], sums[1], [axis for axis in own if axis < old.ndim - 1], alone=alone)
        found.notes.append(f"{name}: differs inside groups of modes; their sums are compared")
    elif scale > tolerance and name in _SETS and _SETS[name] in dims:
        scale, entry = measures(old, _paired(old, new, dims.index(_SETS[name]), whole="mode" in dims), own, alone=alone)
    found.measure(name, scale, entry, tolerance)


def measures(
    old: Values, new: Values, own: Sequence[int], *, alone: bool = False, least: float = 0.0
) -> tuple[float, float]:
    """Differences of scale and of entry; axes in `own` have a scale of each entry, `alone` without a least one.

    least : scale below which none is taken, in the unit of the values.
    """
    if old.size == 0:
        return 0.0, 0.0
    size, apart = np.abs(old), np.abs(np.asarray(new) - old)
    if not apart.any():
        return 0.0, 0.0
    shared = tuple(axis for axis in range(old.ndim) if axis not in own)
    scale = size.max(axis=shared, keepdims=True) if shared else size
    scale = np.maximum(scale, max(least, 0.0 if alone else LEAST_SCALE * float(size.max())))
    floor = np.maximum(np.maximum(size, np.abs(new)), LEAST_ENTRY * scale)
    with np.errstate(divide="ignore", invalid="ignore"):
        of_scale = np.where(apart > 0, apart / scale, 0.0)
        of_entry = np.where(apart > 0, apart / np.maximum(floor, least), 0.0)
    return float(of_scale.max()), float(of_entry.max())


def _exact(name: str, old: Values, new: Values, found: Finding) -> None:
    """Labels, integers and booleans; prose may be reworded."""
    kinds = {"U": "text", "O": "text", "i": "integer", "u": "integer"}
    if kinds.get(old.dtype.kind, old.dtype.kind) != kinds.get(new.dtype.kind, new.dtype.kind):
        found.fail(name, f"type {old.dtype} -> {new.dtype}")
        return
    differ = np.atleast_1d(np.array(old.astype(object) != new.astype(object), dtype=bool))
    if not differ.any():
        return
    first = tuple(int(place) for place in np.argwhere(differ)[0])
    pair = f"{np.atleast_1d(old)[first]!r} -> {np.atleast_1d(new)[first]!r}"
    told = f"{int(differ.sum())} of {differ.size} differ, first at {first}: {pair}"
    if name in _PROSE or name.startswith(_PROSE_FIELDS):
        found.notes.append(f"{name}: {told}")
    else:
        found.fail(name, told)


def _same_gaps(old: Values, new: Values) -> bool:
    bad_old, bad_new = ~np.isfinite(old), ~np.isfinite(new)
    return bool(np.array_equal(bad_old, bad_new)) and bool(np.array_equal(old[bad_old], new[bad_new], equal_nan=True))


def _mode_groups(old: Record) -> list[NDArray[np.intp]]:
    """Numbers of the modes of equal frequency, for a result of `modes`."""
    if "shape" not in old or "frequency" not in old or old["frequency"][0] != ("mode",):
        return []
    frequency = np.asarray(old["frequency"][1], float)
    steps = np.abs(np.diff(frequency)) > 1e-6 * np.abs(frequency).max(initial=0.0)
    return np.split(np.arange(frequency.size), np.flatnonzero(steps) + 1)


def _turned(old: Values, new: Values, groups: Sequence[NDArray[np.intp]]) -> float:
    """Sine of the largest angle between the spaces of each group."""
    worst = 0.0
    for group in groups:
        a, b = orth(old[:, group]), orth(new[:, group])
        if a.shape != b.shape:
            return np.inf
        worst = max([worst, *(float(angle) for angle in np.sin(subspace_angles(a, b)))])
    return worst


def _paired(old: Values, new: Values, axis: int, *, whole: bool) -> Values:
    """The entries of `new` along an axis, put next to those of `old`: whole curves, or at each place by itself."""
    before, after = np.moveaxis(old, axis, -1), np.moveaxis(new, axis, -1).copy()
    if whole:
        flat = [values.reshape(-1, values.shape[-1]) for values in (before, after)]
        apart = np.abs(flat[0][:, :, None] - flat[1][:, None, :]).max(axis=0)
        return np.moveaxis(after[..., linear_sum_assignment(apart)[1]], -1, axis)
    for place in np.ndindex(*before.shape[:-1]):
        chosen = linear_sum_assignment(np.abs(before[place][:, None] - after[place][None, :]))[1]
        after[place] = after[place][chosen]
    return np.moveaxis(after, -1, axis)


def _renamed(old: Record, new: Record, found: Finding) -> dict[str, str]:
    """Fields of a System that are not there by name -> fields with other names that hold the same.

    Of the new ones with the same kind and shape the nearest is taken; it is a difference if it is not near enough.
    """
    before, after = old["variables"], new["variables"]
    free = [name for name in after if name not in before]
    result: dict[str, str] = {}
    for name in [name for name in before if name not in after]:
        values = before[name][1]
        near = sorted((gap, at) for at, other in enumerate(free) if (gap := _apart(values, after[other][1])) < 1e-3)
        if near:
            result[name] = free.pop(near[0][1])
            found.notes.append(f"{name} is now {result[name]}")
    return result


def _apart(old: Values, new: Values) -> float:
    if np.shape(old) != np.shape(new) or old.dtype.kind != new.dtype.kind:
        return np.inf
    if old.dtype.kind not in "fc":
        return 0.0 if np.array_equal(old, new) else np.inf
    return measures(old, new, [])[0] if _same_gaps(old, new) else np.inf


def _attributes(old: Record, new: Record, tolerance: float, found: Finding) -> None:
    for key in sorted(set(old) | set(new)):
        if key not in new and key not in _IGNORED:
            found.fail(f"attribute {key}", "missing")
        elif key not in old or key not in new:
            found.notes.append(f"attribute {key}: {'missing' if key in old else 'not there before'}")
        elif key == "warnings":
            _warnings(str(old[key]), str(new[key]), found)
        elif key == "options" and old[key] != new[key]:
            found.notes.append(f"options: {old[key]} -> {new[key]}")
        elif key not in _IGNORED:
            _attribute(f"attribute {key}", _parsed(old[key]), _parsed(new[key]), tolerance, found)


def _parsed(value: Any) -> Any:
    if isinstance(value, str) and value[:1] in "[{":
        try:
            return json.loads(value)
        except ValueError:
            return value
    return value


def _attribute(name: str, old: Any, new: Any, tolerance: float, found: Finding) -> None:
    """Numbers by the tolerance, words of a single one exactly, the numbers in longer texts exactly, their words not."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in sorted(set(old) | set(new)):
            _attribute(f"{name}.{key}", old.get(key), new.get(key), tolerance, found)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for at, (one, other) in enumerate(zip(old, new, strict=True)):
            _attribute(f"{name}[{at}]", one, other, tolerance, found)
    elif isinstance(old, str) and isinstance(new, str):
        if old == new:
            return
        wording = " " in old and name.split()[-1] not in ("title", "verb")
        same = _NUMBER.findall(old) == _NUMBER.findall(new)
        if wording and same:
            found.notes.append(f"{name}: {old!r} -> {new!r}")
        else:
            found.fail(name, f"{old!r} -> {new!r}")
    elif _is_number(old) and _is_number(new):
        pair = np.atleast_1d(np.asarray(old, float)), np.atleast_1d(np.asarray(new, float))
        if pair[0].shape != pair[1].shape or not _same_gaps(*pair):
            found.fail(name, f"{old} -> {new}")
        else:
            finite = [np.where(np.isfinite(values), values, 0.0) for values in pair]
            found.measure(
                name, *measures(finite[0], finite[1], [], least=1.0 if "residual" in name else 0.0), tolerance
            )
    elif old != new:
        found.fail(name, f"{old!r} -> {new!r}")


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number, np.ndarray)) and not isinstance(value, bool)


def _warnings(old: str, new: str, found: Finding) -> None:
    before, after = json.loads(old), json.loads(new)
    if len(before) != len(after):
        found.fail("warnings", f"{len(before)} -> {len(after)}: {before} -> {after}")
    elif before != after:
        found.notes.append(f"warnings: {before} -> {after}")


def _caught(old: Sequence[Sequence[str]], new: Sequence[Sequence[str]], found: Finding) -> None:
    """Warnings of Python, by their categories."""
    kinds = [sorted(entry[0] for entry in told) for told in (old, new)]
    if kinds[0] != kinds[1]:
        found.fail("Python warnings", f"{kinds[0]} -> {kinds[1]}: {list(old)} -> {list(new)}")
    elif list(old) != list(new):
        found.notes.append(f"Python warnings: {list(old)} -> {list(new)}")
