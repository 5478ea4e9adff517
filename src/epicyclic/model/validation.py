"""Validation of an expanded document: the model in SI, bare numbers with their paths, the quantity at a path."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..errors import ModelError
from .bare_numbers import ASKED, BareNumber, Probe, Reading
from .checks import check
from .names import Names
from .normalise import normalise
from .schema import ModelFile
from .shorthand import expand
from .tables import PlainTable, leaves, merge, nested
from .units import UNKNOWN_UNIT
from .validation_errors import as_model_error, error_of, path_of

__all__ = ["BarePlace", "bare_places", "quantities_at", "quantity_at", "unlisted_paths", "validate"]

LISTED = 2  # the format from which on only units of `unit_patterns` are read


@dataclass(frozen=True, slots=True, kw_only=True)
class BarePlace:
    """A number without a unit: path in the expanded document, and the error that would name it."""

    path: str
    error: BareNumber


def validate(data: PlainTable, names: Names, folder: Path | None) -> tuple[ModelFile, bool]:
    """Return the validated model, and whether a bare number stands in it. Raises one ModelError."""
    context = Reading(listed=_is_listed(data))
    try:
        model = ModelFile.model_validate(normalise(data, names, folder), context=context)
    except ValidationError as error:
        raise as_model_error(error) from None
    try:
        check(model)
    except ModelError as error:  # say what the file says, not its value in SI
        raise _as_written(error, data) from None
    return model, context.found


def bare_places(data: PlainTable, names: Names, folder: Path | None) -> list[BarePlace]:
    """Return every value with a bare number in it, in the order of the schema; other faults are passed over."""
    places = []
    for detail in _faults(data, names, folder, Reading(listed=_is_listed(data), strict=True)):
        if isinstance(error := detail.get("ctx", {}).get("error"), BareNumber):
            places.append(BarePlace(path=path_of(detail["loc"]), error=error))
    return places


def unlisted_paths(data: PlainTable, names: Names) -> list[str]:
    """Return the paths of the texts whose unit is none of `unit_patterns`."""
    faults = _faults(data, names, None, Reading(listed=True))
    errors = ((path_of(detail["loc"]), detail.get("ctx", {}).get("error")) for detail in faults)
    return [path for path, error in errors if isinstance(error, ModelError) and error.problem.startswith(UNKNOWN_UNIT)]


def quantity_at(data: PlainTable, path: str, names: Names, folder: Path | None) -> Probe:
    """Return which quantity may stand at a path of the document.

    Raises ModelError where no number may, or where a number alone is not enough.
    """
    trial = merge(data, expand(nested(tuple(path.split(".")), ASKED), names))
    faults = _faults(trial, names, folder, Reading())
    answers = [detail for detail in faults if isinstance(detail.get("ctx", {}).get("error"), Probe)]
    if answers:
        found: Probe = answers[0]["ctx"]["error"]
        # what the number alone does not make whole: an error that turns with nothing, a load on nothing
        if others := [detail for detail in faults if detail not in answers]:
            raise error_of(others)
        return found
    here = [detail for detail in faults if path_of(detail["loc"]).startswith(path)]
    if any(detail["type"].startswith("int_") for detail in here):  # a count
        return Probe(("ratio",), whole=True)
    raise error_of(here) if here else ModelError("no number stands here", path=path)


def quantities_at(
    data: PlainTable, paths: Iterable[str], names: Names, folder: Path | None
) -> dict[str, Probe | ModelError]:
    """Return what `quantity_at` says of each path, an error in place of one that it raises.

    All are asked for in one validation; where anything else is wrong then, each by itself.
    """
    layers = {path: expand(nested(tuple(path.split(".")), ASKED), names) for path in paths}
    trial = data
    for layer in layers.values():
        trial = merge(trial, layer)
    answers: dict[str, Probe] = {}
    for detail in _faults(trial, names, folder, Reading()):
        error = detail.get("ctx", {}).get("error")
        if not isinstance(error, Probe):
            return {path: _answer(data, path, names, folder) for path in layers}
        answers[path_of(detail["loc"])] = error
    found = {path: next((answers[p] for p, _ in leaves(layer) if p in answers), None) for path, layer in layers.items()}
    return {path: probe or _answer(data, path, names, folder) for path, probe in found.items()}


def _answer(data: PlainTable, path: str, names: Names, folder: Path | None) -> Probe | ModelError:
    """Return what `quantity_at` returns or raises."""
    try:
        return quantity_at(data, path, names, folder)
    except ModelError as error:
        return error


def _faults(data: PlainTable, names: Names, folder: Path | None, context: Reading) -> list[Any]:
    """Return what pydantic finds wrong."""
    try:
        ModelFile.model_validate(normalise(data, names, folder), context=context)
    except ValidationError as error:
        return list(error.errors(include_url=False))
    return []


def _is_listed(data: PlainTable) -> bool:
    version = data.get("format")
    return isinstance(version, int) and version >= LISTED


def _as_written(error: ModelError, data: PlainTable) -> ModelError:
    """Return an error about a value in SI with the value as it stands in the document."""
    here: object = data
    for part in error.path.split("."):
        here = here.get(part) if isinstance(here, dict) else None
    if here is None or isinstance(here, dict):
        return error
    return ModelError(error.problem, path=error.path, given=here, allowed=error.allowed)
