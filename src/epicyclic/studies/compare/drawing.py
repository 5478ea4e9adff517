"""What differs between the drawings of several trains: paths of their model files and the values there."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...document.tables import leaves
from ...document.units import KINDS, factor
from ...train.train import Train

__all__ = ["Difference", "drawing_differences"]

_WORDS = ("format", "title", "doi", "notes", "assumed")  # tables of words, which no result follows
# Relative difference of the same quantity written in two units: six digits are written.
_WRITTEN = 5e-6
_NUMBER = re.compile(r"\s*([+-]?(?:[0-9.]+(?:[eE][+-]?[0-9]+)?|inf))\s*(\S.*)?")
_LINK = re.compile(r"\.(support|bearing|neck|shaft|damping)(\.[\w-]+)?\.(x|rx)$|^couplings\.[\w-]+\.(x|rx)$")
_ALIKE = {"x": ("y", "radial"), "rx": ("ry", "tilt")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One path whose value is not the same in all trains.

    text : the value in each, as written or derived, "" where there is none.  value : in SI, None of what is no number.
    unit : SI unit of the values.
    """

    path: str
    text: tuple[str, ...]
    value: tuple[float | None, ...]
    unit: str


def drawing_differences(trains: Sequence[Train]) -> tuple[Difference, ...]:
    """Paths at which the model files say different things, in the order of the files.

    Values that are written otherwise and mean the same do not differ.  Where one file is silent its derived value
    stands, with where it comes from.  x and y (rx and ry) of a link that differ alike are one path, radial (tilt).
    """
    tables = [{p: v for p, v in leaves(dict(t.document)) if p.split(".")[0] not in _WORDS} for t in trains]
    found = {}
    for path in dict.fromkeys(path for table in tables for path in table):
        one = _difference(path, tables, trains)
        if one is not None:
            found[path] = one
    return tuple(_folded(found).values())


def _difference(path: str, tables: Sequence[Mapping[str, object]], trains: Sequence[Train]) -> Difference | None:
    """The difference at one path, None where all are the same."""
    read = [_read(table.get(path), path, train) for table, train in zip(tables, trains, strict=True)]
    texts, values, units = ([entry[i] for entry in read] for i in range(3))
    units = [unit for unit in units if unit]
    if len(set(units)) > 1:  # written as other quantities, J/r^2 and J: what they come to has one unit
        return _resolved(path, tuple(map(str, texts)), trains)
    unit = str(units[0]) if units else ""
    known = [(unit_of or unit, value) if value is not None else text for text, value, unit_of in read]
    if all(one == known[0] for one in known[1:]):
        return None
    return Difference(path=path, text=tuple(map(str, texts)), value=tuple(values), unit=unit)  # type: ignore[arg-type]


def _resolved(path: str, texts: tuple[str, ...], trains: Sequence[Train]) -> Difference | None:
    """The difference of values in several units, by what they are resolved to; without numbers where that is none."""
    found = [next((one for one in train.values if one.path == path), None) for train in trains]
    values = [float(one.value) for one in found if one is not None and isinstance(one.value, int | float)]
    units = {one.unit for one in found if one is not None}
    if len(values) < len(trains) or len(units) > 1:
        return Difference(path=path, text=texts, value=(None,) * len(trains), unit="")
    if all(math.isclose(value, values[0], rel_tol=_WRITTEN) for value in values[1:]):
        return None
    return Difference(path=path, text=texts, value=tuple(values), unit=units.pop())


def _read(value: object, path: str, train: Train) -> tuple[str, float | None, str]:
    """Text, SI number or None, and SI unit of what stands at a path, or of what follows where nothing stands."""
    if value is None:
        derived = next((one for one in train.values if one.path == path), None)
        if derived is None or not isinstance(derived.value, int | float | str):
            return "", None, ""
        number = float(derived.value) if isinstance(derived.value, int | float) else None
        shown = f"{number:.6g}" if number is not None else str(derived.value)
        return f"{shown} {derived.unit}".rstrip() + f" ({derived.origin})", number, derived.unit
    if isinstance(value, bool | dict | list | tuple):
        return _plain(value), None, ""
    if isinstance(value, int | float):
        return f"{value:.6g}", float(value), ""
    found = _NUMBER.fullmatch(str(value))
    if found is None:
        return str(value), None, ""
    if not found[2]:
        return str(value), float(found[1]), ""
    for kind in KINDS.values():
        if kind.unit and (scale := factor(found[2], kind.unit)) is not None:
            return str(value), float(f"{float(found[1]) * scale:.15g}"), kind.unit
    return str(value), None, ""


def _plain(value: object) -> str:
    """A value that is no number as TOML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_plain, value))}]"
    return str(value)


def _folded(found: dict[str, Difference]) -> dict[str, Difference]:
    """Paths of x and y of one link as one where they differ alike."""
    folded: dict[str, Difference] = {}
    for path, one in found.items():
        head, _, last = path.rpartition(".")
        match = _LINK.search(path)
        if match is not None and (twin := found.get(f"{head}.{_ALIKE[last][0]}")) is not None and twin.text == one.text:
            name = f"{head}.{_ALIKE[last][1]}"
            folded[name] = Difference(path=name, text=one.text, value=one.value, unit=one.unit)
        elif last in ("y", "ry") and f"{head}.{'radial' if last == 'y' else 'tilt'}" in folded:
            continue
        else:
            folded[path] = one
    return folded
