"""The rule of units: what a person wrote without one is refused in format 2, and told in format 1, by its path."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ModelError
from ..warning_codes import CodedText, coded
from .bare_numbers import BareNumber, likely_text
from .names import Names
from .schema import ModelFile
from .shorthand import expand
from .tables import PlainTable, leaves, nested
from .tolerances import check_tolerance
from .units import KINDS
from .validation import bare_places, validate

__all__ = ["WrittenLayers", "checked_model"]

# warnings of one file: as many as fit on a screen, or the first few and the count
_MOST, _FEW = 8, 5


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenLayers:
    """Layers that a person wrote, as they stand; empty where built in Python, whose numbers are SI.

    file : tables of the file.  settings : values typed on the command line.  overridden : paths set by any override.
    """

    file: PlainTable
    settings: PlainTable
    overridden: Collection[str]


def checked_model(
    data: PlainTable, names: Names, folder: Path | None, layers: WrittenLayers
) -> tuple[ModelFile, tuple[CodedText, ...]]:
    """Return the validated model, and a warning of each number without a unit in a file of format 1.

    Raises ModelError for whatever is wrong; first for a number without a unit, whose size is not to be believed.
    """
    fault: ModelError | None = None
    try:
        model, found = validate(data, names, folder)
    except ModelError as error:
        fault, found = error, True
    written = _written_bare(data, names, folder, layers) if found and (layers.file or layers.settings) else {}
    if written and data.get("format") != 1:
        raise _refusal(written)
    if fault is not None:
        raise fault
    return model, (*_told(written), *check_tolerance(data, names, folder))


def _written_bare(data: PlainTable, names: Names, folder: Path | None, layers: WrittenLayers) -> dict[str, BareNumber]:
    """Return the bare numbers that a person wrote, by the path as it is written."""
    try:
        places = {place.path: place.error for place in bare_places(data, names, folder)}
    except ModelError:  # a name that is none, which validation tells
        return {}
    found: dict[str, BareNumber] = {}
    for layer, set_there in ((layers.file, False), (layers.settings, True)):
        for path, value in _numbers(layer):
            try:
                stands = [p for p, _ in leaves(expand(nested(path, value), names))]
            except ModelError:
                continue
            mine = [p for p in stands if p in places and (p in layers.overridden) == set_there]
            if mine:
                found[".".join(path)] = places[mine[0]]
    return found


def _numbers(table: PlainTable, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield path and value of everything in which a bare number may stand."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _numbers(value, (*path, name))
        elif isinstance(value, (int, float, list)) or (isinstance(value, str) and "[" in value):
            yield (*path, name), value


def _refusal(written: dict[str, BareNumber]) -> ModelError:
    """Return the error of the first, which names the others."""
    (path, first), *rest = written.items()
    more = (
        f" (and {len(rest)} more, at {', '.join(p for p, _ in rest[:3])}{', ...' if rest[3:] else ''})" if rest else ""
    )
    return ModelError(f"{first.problem}{more}", path=path, given=first.given, allowed=first.allowed)


def _told(written: dict[str, BareNumber]) -> list[CodedText]:
    """Return a warning of each, of very many the first few and their number."""
    texts = [_warning(path, error) for path, error in written.items()]
    if len(texts) <= _MOST:
        return texts
    return [
        *texts[:_FEW],
        coded("no-unit", f"{len(texts)} numbers of the file have no unit, {len(texts) - _FEW} more than these"),
    ]


def _warning(path: str, error: BareNumber) -> CodedText:
    """Return what a bare number was read as, and what was likely meant."""
    unit = KINDS[error.kinds[0]].unit
    read = likely_text(error.given, error.kinds, ((0.0, unit),))
    given = read.removesuffix(unit).strip()
    meant = "write it so, as format = 2 asks" if read == error.likely else f'"{error.likely}"?'
    return coded("no-unit", f'{path} = {given}: no unit, read as "{read}"; {meant}')
