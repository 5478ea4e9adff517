"""Parameters of a model file: every number that may be differentiated, its value, and its overrides.

Written numbers and derived ones (masses, inertias, mean mesh stiffnesses) are parameters; counts and texts are not.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ..document.schema import collect, nearest
from ..document.shorthand import expand_path
from ..document.tables import leaves
from ..document.written_numbers import Written, written
from ..errors import ModelError
from ..train.train import Train

__all__ = ["Parameter", "all_parameters", "parameter_at"]

_COUNTS = ("teeth", "planets", "slices", "count", "order", "seed")
_TEXTS = ("format", "title", "doi", "notes", "assumed", "tolerance")
# long lists, whose entries are parameters only where a path names them
_TABLES = ("pitch", "values", "deflection")
_DERIVED = ("mass", "inertia", "tilt_inertia", "stiffness")
_PAIRS = {"x": ("y", "radial"), "rx": ("ry", "tilt")}
_INDEXED = re.compile(r"(.*)\[(\d{1,4})\]\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One number of the model file.

    path : its name, ``PATH[2]`` for the second entry of a list.  leaves : full paths that hold it.
    value : in `unit` as written; a bare number is SI.  number : number or list as written.  index : of a list, from 0.
    companions : overrides that keep a derived value which an override of this number would replace.
    """

    path: str
    leaves: tuple[str, ...]
    value: float
    unit: str
    number: Written
    index: int = 0
    companions: tuple[tuple[str, object], ...] = ()

    def at(self, value: float) -> dict[str, object]:
        """Overrides that set another value, in `unit`."""
        values = (*self.number.values[: self.index], value, *self.number.values[self.index + 1 :])
        return {**dict(self.companions), **dict.fromkeys(self.leaves, self.number.text(values))}


def all_parameters(train: Train) -> list[Parameter]:
    """Every written number without counts, entries of lists one by one, and derived masses and stiffnesses.

    Equal stiffnesses in x and y are one parameter, `radial`; in rx and ry `tilt`.
    """
    document = dict(leaves(dict(train.document)))
    parameters: list[Parameter] = []
    for path, at in _named_leaves(document).items():
        parts, number = path.split("."), written(document[at[0]])
        tabulated = number is not None and number.many and parts[-1] == "force"
        if number is not None and parts[0] not in _TEXTS and parts[-1] not in (*_COUNTS, *_TABLES) and not tabulated:
            parameters += _entries(path, at, number)
    return [*parameters, *(one for one in _derived(train) if not _is_written(one.path, document))]


def parameter_at(train: Train, text: str) -> Parameter:
    """Parameter at a path, shorthands allowed; ``PATH[2]`` is an entry of a list, or one planet's of a common value.

    Raises
    ------
    ModelError : no such path (the nearest is named), no number, a count, a rigid connection, a list without an index.
    """
    path, index = (match[1], int(match[2])) if (match := _INDEXED.fullmatch(text)) else (text.strip(), 0)
    document = dict(leaves(dict(train.document)))
    at = expand_path(path, collect(dict(train.document)), path="path")
    numbers = [_number_at(leaf, document, train, text) for leaf in at]
    number = numbers[0]
    if any(other != number for other in numbers):
        raise ModelError("stands at values that differ", path=text, given=", ".join(at), allowed="one of these paths")
    if at[0].rpartition(".")[2] in _COUNTS or (number.whole and at[0].rpartition(".")[2] in _TABLES):
        raise ModelError("a whole number: nothing between two of them, so no derivative", path=text)
    if number.many and not index:
        raise ModelError("a list", path=text, allowed=f"one of its entries, {path}[1] .. {path}[{len(number.values)}]")
    if index:
        number = _listed(number, at[0], train, text, index)
    name = f"{path}[{index}]" if index else path
    entry = max(index - 1, 0)
    return Parameter(
        path=name,
        leaves=at,
        value=number.values[entry],
        unit=number.unit,
        number=number,
        index=entry,
        companions=_companions(train, at[0], document),
    )


def _named_leaves(document: Mapping[str, object]) -> dict[str, tuple[str, ...]]:
    """Name of a parameter -> paths that hold it; equal stiffnesses in x and y are `radial`, in rx and ry `tilt`.

    document : full path -> value, as below.
    """
    result: dict[str, tuple[str, ...]] = {}
    for path, value in document.items():
        head, _, last = path.rpartition(".")
        second, name = _PAIRS.get(last, ("", ""))
        twin = {"y": "x", "ry": "rx"}.get(last, "")
        stiff = path.split(".")[0] in ("stages", "bodies", "couplings")
        if stiff and second and document.get(f"{head}.{second}") == value:
            result[f"{head}.{name}"] = (path, f"{head}.{second}")
        elif not (stiff and twin and document.get(f"{head}.{twin}") == value):
            result[path] = (path,)
    return result


def _entries(path: str, at: tuple[str, ...], number: Written) -> Iterator[Parameter]:
    for index, value in enumerate(number.values):
        name = f"{path}[{index + 1}]" if number.many else path
        yield Parameter(path=name, leaves=at, value=value, unit=number.unit, number=number, index=index)


def _derived(train: Train) -> Iterator[Parameter]:
    """Derived masses, inertias and mesh stiffnesses, and the pressure angle of the tool where it is the default."""
    tools: dict[str, set[float]] = {}
    document = dict(leaves(dict(train.document)))
    for value in train.values:
        parts = value.path.split(".")
        if not isinstance(value.value, float) or not math.isfinite(value.value):
            continue
        if parts[-1] in _DERIVED:
            yield _parameter(value.path, value.value, value.unit, _companions(train, value.path, document))
        elif parts[-1] == "pressure_angle" and "meshes" not in parts and value.origin == "default":
            tools.setdefault(f"stages.{parts[1]}.pressure_angle", set()).add(value.value)
    # degrees, as on drawings
    yield from (
        _parameter(path, math.degrees(angles.pop()), "deg") for path, angles in tools.items() if len(angles) == 1
    )


def _is_written(path: str, document: Mapping[str, object]) -> bool:
    """Whether the file holds a number at this path, or more special ones (of a side) below its head."""
    head, _, last = path.rpartition(".")
    return any(
        p == path or (p.startswith(f"{head}.") and p.endswith(f".{last}")) for p in document if written(document[p])
    )


def _companions(train: Train, path: str, document: Mapping[str, object]) -> tuple[tuple[str, object], ...]:
    """Derived variation of a mesh whose mean stiffness is derived too: with a given stiffness it would not vary."""
    head, _, last = path.rpartition(".")
    if (
        last != "stiffness"
        or written(document.get(path)) is not None
        or any(p.startswith(f"{head}.variation") for p in document)
    ):
        return ()
    return tuple((v.path, v.value) for v in train.values if v.path == f"{head}.variation" and isinstance(v.value, str))


def _parameter(path: str, value: float, unit: str, companions: tuple[tuple[str, object], ...] = ()) -> Parameter:
    """Parameter of a derived value that no list holds."""
    written_unit = "" if unit == "cycles" else unit
    number = Written(values=(value,), unit=written_unit, many=False)
    return Parameter(path=path, leaves=(path,), value=value, unit=written_unit, number=number, companions=companions)


def _number_at(leaf: str, document: Mapping[str, object], train: Train, text: str) -> Written:
    """Number at one full path, written or derived.

    Raises
    ------
    ModelError : no number there, or a rigid connection.
    """
    number = written(document[leaf]) if leaf in document else None
    if number is not None:
        return number
    derived = {one.path: one.number for one in _derived(train)}
    if leaf in derived:
        return derived[leaf]
    resolved = {value.path: value for value in train.values}
    known = resolved.get(leaf)
    number = None if known is None else written(known.value)
    if known is not None and number is not None and all(map(math.isfinite, number.values)):
        return replace(number, unit="" if known.unit == "cycles" else known.unit)
    value = document.get(leaf, None if known is None else known.value)
    if value is None or isinstance(value, dict):
        every = [one.path for one in all_parameters(train)]
        raise ModelError(
            f"no number at this path{nearest(text, [*every, *resolved, *document])}",
            path=text,
            allowed="a number the model has; give it a value first, --set PATH=VALUE",
        )
    rigid = value in ("inf", math.inf)
    raise ModelError("rigid: no derivative" if rigid else "not a number: no derivative", path=text, given=value)


def _listed(number: Written, leaf: str, train: Train, text: str, index: int) -> Written:
    """Number as a list: one entry for each planet where a common value is written.

    Raises
    ------
    ModelError : no such entry.
    """
    stage = next((part for part in leaf.split(".")[1:2] if part in train.planets), None)
    if not number.many and stage is not None and train.planets[stage] > 1:
        number = Written(values=number.values * train.planets[stage], unit=number.unit, many=True)
    if not 1 <= index <= len(number.values) or not number.many:
        raise ModelError("no such entry", path=text, given=index, allowed=f"1 .. {len(number.values)}")
    return number
