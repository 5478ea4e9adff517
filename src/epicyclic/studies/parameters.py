"""The numbers of a model file that can be turned a little: which there are, what they say, how to say them changed."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ..errors import ModelError
from ..model.names import collect, nearest
from ..model.shorthand import expand_path
from ..model.tables import leaves
from ..model.written import Written, written
from ..train.train import Train

__all__ = ["Parameter", "all_parameters", "parameter_at"]

_COUNTS = ("teeth", "planets", "slices", "count", "order", "seed")
_TEXTS = ("format", "title", "doi", "notes", "assumed", "tolerance")
_TABLES = ("pitch", "values")  # long lists: an entry of them is asked for by name
_DERIVED = ("mass", "inertia", "tilt_inertia", "stiffness")
_PAIRS = {"x": ("y", "radial"), "rx": ("ry", "tilt")}
_INDEXED = re.compile(r"(.*)\[(\d{1,4})\]\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One number of the file.

    path : as it is named, ``PATH[2]`` for the second of a list.  leaves : the full paths it stands at.
    value : in `unit`, as written; a bare number is SI.  number : what stands there.  index : of a list, from 0.
    beside : what has to be said with it, so that nothing else changes where the file does not say it.
    """

    path: str
    leaves: tuple[str, ...]
    value: float
    unit: str
    number: Written
    index: int = 0
    beside: tuple[tuple[str, object], ...] = ()

    def at(self, value: float) -> dict[str, object]:
        """Overrides that put another value, in `unit`, in its place."""
        values = (*self.number.values[: self.index], value, *self.number.values[self.index + 1 :])
        return {**dict(self.beside), **dict.fromkeys(self.leaves, self.number.text(values))}


def all_parameters(train: Train) -> list[Parameter]:
    """Every number the file says, entries of lists one by one, and what of masses and stiffnesses follows from it.

    Counts are left out; stiffnesses alike in x and y are one parameter, `radial`, in rx and ry `tilt`.
    """
    said = dict(leaves(dict(train.document)))
    found: list[Parameter] = []
    for path, at in _alike(said).items():
        parts, number = path.split("."), written(said[at[0]])
        if number is not None and parts[0] not in _TEXTS and parts[-1] not in (*_COUNTS, *_TABLES):
            found += _entries(path, at, number)
    return [*found, *(one for one in _following(train) if not _said(one.path, said))]


def parameter_at(train: Train, text: str) -> Parameter:
    """The parameter at a path, shorthands allowed; ``PATH[2]`` is an entry of a list, or one planet's of all.

    Raises
    ------
    ModelError : no such path (the nearest is named), no number, a count, a rigid connection, a list without an index.
    """
    path, index = (found[1], int(found[2])) if (found := _INDEXED.fullmatch(text)) else (text.strip(), 0)
    said = dict(leaves(dict(train.document)))
    at = expand_path(path, collect(dict(train.document)), path="path")
    numbers = [_number_at(leaf, said, train, text) for leaf in at]
    number = numbers[0]
    if any(other != number for other in numbers):
        raise ModelError("stands at values that differ", path=text, given=", ".join(at), allowed="one of these paths")
    if at[0].rpartition(".")[2] in _COUNTS or (number.whole and at[0].rpartition(".")[2] in _TABLES):
        raise ModelError("a whole number: nothing between two of them, so no derivative", path=text)
    if number.many and not index:
        raise ModelError("a list", path=text, allowed=f"one of its entries, {path}[1] .. {path}[{len(number.values)}]")
    if index:
        number = _spread(number, at[0], train, text, index)
    name = f"{path}[{index}]" if index else path
    entry = max(index - 1, 0)
    return Parameter(
        path=name,
        leaves=at,
        value=number.values[entry],
        unit=number.unit,
        number=number,
        index=entry,
        beside=_beside(train, at[0], said),
    )


def _alike(said: Mapping[str, object]) -> dict[str, tuple[str, ...]]:
    """Name of every parameter and the paths it stands at; x and y of one value are `radial`."""
    result: dict[str, tuple[str, ...]] = {}
    for path, value in said.items():
        head, _, last = path.rpartition(".")
        second, name = _PAIRS.get(last, ("", ""))
        twin = {"y": "x", "ry": "rx"}.get(last, "")
        stiff = path.split(".")[0] in ("stages", "bodies", "couplings")
        if stiff and second and said.get(f"{head}.{second}") == value:
            result[f"{head}.{name}"] = (path, f"{head}.{second}")
        elif not (stiff and twin and said.get(f"{head}.{twin}") == value):
            result[path] = (path,)
    return result


def _entries(path: str, at: tuple[str, ...], number: Written) -> Iterator[Parameter]:
    for index, value in enumerate(number.values):
        name = f"{path}[{index + 1}]" if number.many else path
        yield Parameter(path=name, leaves=at, value=value, unit=number.unit, number=number, index=index)


def _following(train: Train) -> Iterator[Parameter]:
    """Masses, inertias and mesh stiffnesses that follow from the rest, and a default pressure angle of the tool."""
    tools: dict[str, set[float]] = {}
    said = dict(leaves(dict(train.document)))
    for value in train.values:
        parts = value.path.split(".")
        if not isinstance(value.value, float) or not math.isfinite(value.value):
            continue
        if parts[-1] in _DERIVED:
            yield _bare(value.path, value.value, value.unit, _beside(train, value.path, said))
        elif parts[-1] == "pressure_angle" and "meshes" not in parts and value.origin == "default":
            tools.setdefault(f"stages.{parts[1]}.pressure_angle", set()).add(value.value)
    # as drawings say it
    yield from (_bare(path, math.degrees(angles.pop()), "deg") for path, angles in tools.items() if len(angles) == 1)


def _said(path: str, said: Mapping[str, object]) -> bool:
    """Whether the file says this itself, or says more than this of it (a list, a side)."""
    head, _, last = path.rpartition(".")
    return any(p == path or (p.startswith(f"{head}.") and p.endswith(f".{last}")) for p in said if written(said[p]))


def _beside(train: Train, path: str, said: Mapping[str, object]) -> tuple[tuple[str, object], ...]:
    """The variation of a mesh whose mean stiffness the file does not say: a given stiffness would not vary."""
    head, _, last = path.rpartition(".")
    if (
        last != "stiffness"
        or written(said.get(path)) is not None
        or any(p.startswith(f"{head}.variation") for p in said)
    ):
        return ()
    return tuple((v.path, v.value) for v in train.values if v.path == f"{head}.variation" and isinstance(v.value, str))


def _bare(path: str, value: float, unit: str, beside: tuple[tuple[str, object], ...] = ()) -> Parameter:
    said = "" if unit == "cycles" else unit
    number = Written(values=(value,), unit=said, many=False)
    return Parameter(path=path, leaves=(path,), value=value, unit=said, number=number, beside=beside)


def _number_at(leaf: str, said: Mapping[str, object], train: Train, text: str) -> Written:
    """What stands at one full path: in the file, or derived from it."""
    number = written(said[leaf]) if leaf in said else None
    if number is not None:
        return number
    tools = {one.path: one.number for one in _following(train)}
    if leaf in tools:
        return tools[leaf]
    known = {value.path: value for value in train.values}
    following = known.get(leaf)
    derived = None if following is None else written(following.value)
    if following is not None and derived is not None and all(map(math.isfinite, derived.values)):
        return replace(derived, unit="" if following.unit == "cycles" else following.unit)
    value = said.get(leaf, None if following is None else following.value)
    if value is None or isinstance(value, dict):
        every = [one.path for one in all_parameters(train)]
        raise ModelError(
            f"no number at this path{nearest(text, [*every, *known, *said])}",
            path=text,
            allowed="a number the model has; give it a value first, --set PATH=VALUE",
        )
    rigid = value in ("inf", math.inf)
    raise ModelError("rigid: no derivative" if rigid else "not a number: no derivative", path=text, given=value)


def _spread(number: Written, leaf: str, train: Train, text: str, index: int) -> Written:
    """A list with one entry for each planet where a common value stands."""
    stage = next((part for part in leaf.split(".")[1:2] if part in train.planets), None)
    if not number.many and stage is not None and train.planets[stage] > 1:
        number = Written(values=number.values * train.planets[stage], unit=number.unit, many=True)
    if not 1 <= index <= len(number.values) or not number.many:
        raise ModelError("no such entry", path=text, given=index, allowed=f"1 .. {len(number.values)}")
    return number
