"""Trains or saved results beside each other, as a labelled Dataset of kind `compare`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...engine.source import train_of
from ...errors import ModelError
from ...results.dataset import SUFFIXES, dataset, load_result
from ...system.system import System
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import CodedText, coded, placed
from .drawing import Difference, drawing_differences
from .effects import Effects, effects_of
from .mode_pairs import mode_pairs
from .variables import VariableDifference, variable_differences

__all__ = ["MOST", "compare_of"]

# Trains beside each other at most: more columns than that nobody reads.
MOST = 12

Source = Any
_Variables = dict[str, tuple[tuple[str, ...] | str, Any]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Compared:
    """One of what is compared: name, its Train if it has a model, its result if it is one."""

    name: str
    train: Train | None
    result: xr.Dataset | None


def compare_of(
    sources: Sequence[Source],
    *,
    overrides: Mapping[str, Any] | None = None,
    variants: Sequence[Mapping[str, Any]] = (),
) -> xr.Dataset:
    """Compare the first source with every other one, and with variants of the first.

    Parameters
    ----------
    sources : model files, ready drives, dicts, Trains, saved results (.nc, .json) or Datasets of results.
    overrides : path -> value, laid over every model.  variants : overrides of the first model, one train each.

    Returns
    -------
    Dataset along `train`.  Of models: what differs in the drawing, speeds, natural frequencies paired by their mode
    shapes or by kind and order, load sharing and mesh forces.  Of results alone: the variables that all have.

    Raises
    ------
    ModelError : fewer than two or more than `MOST` to compare, a wrong model or result; overrides of a result.
    """
    count = len(sources) + len(variants)
    if not 2 <= count <= MOST:
        raise ModelError("not a number of trains to compare", path="sources", given=count, allowed=f"2 to {MOST}")
    if variants and (isinstance(sources[0], Train | System | xr.Dataset) or _is_result(sources[0])):
        raise ModelError("varies a model alone", path="variants", allowed="a model file or ready drive first")
    compared = [_compared(source, overrides) for source in sources]
    for changes in variants:
        train = load(sources[0], overrides={**(overrides or {}), **changes})
        name = "; ".join(f"{path}={value}" for path, value in changes.items()) or "as drawn"
        compared.append(_Compared(name=name, train=train, result=None))
    names = _distinct([one.name for one in compared])
    trains = [one.train for one in compared if one.train is not None]
    results = [one.result for one in compared if one.result is not None]
    variables: _Variables = {}
    coords: dict[Any, Any] = {"train": names}
    said: list[CodedText] = []
    if len(trains) == count:
        _add_drawing(variables, coords, drawing_differences(trains))
    if len(results) == count:
        _add_variables(variables, coords, variable_differences(results))
    elif len(trains) < count:
        missing = names[next(i for i, one in enumerate(compared) if one.train is None)]
        raise ModelError(
            "a result without its model", path="sources", given=missing, allowed="results alone, or models"
        )
    else:
        said = _add_effects(variables, coords, trains, names)
    return dataset(
        variables,
        coords,
        verb="compare",
        options={"overrides": dict(overrides or {}), "variants": [dict(one) for one in variants]},
        provenance={"title": f"{names[0]} beside {', '.join(names[1:])}"},
        warnings=said,
    )


# sources -------------------------------------------------------------------------------------------------------------


def _is_result(source: Source) -> bool:
    return isinstance(source, str | Path) and Path(source).suffix.lower() in SUFFIXES


def _compared(source: Source, overrides: Mapping[str, Any] | None) -> _Compared:
    """One source, loaded; a result with the Train of the model that it carries."""
    if isinstance(source, System):
        raise ModelError("a System has no drawing left: give the model file or the Train", path="sources")
    if _is_result(source) or isinstance(source, xr.Dataset):
        if overrides:
            raise ModelError("overrides apply to a model file, not to a result", path="overrides")
        result = source if isinstance(source, xr.Dataset) else load_result(source)
        name = str(result.attrs.get("verb", "result")) if isinstance(source, xr.Dataset) else Path(source).stem
        model = json.loads(str(result.attrs.get("model", "{}")))
        return _Compared(name=name, train=_train_of_result(model), result=result)
    train = train_of(source, overrides=None if isinstance(source, Train) else overrides)
    if isinstance(source, str | Path):
        path = Path(source)
        return _Compared(name=path.stem if path.suffix else str(source), train=train, result=None)
    return _Compared(name=train.title, train=train, result=None)


def _train_of_result(model: Mapping[str, Any]) -> Train | None:
    """Train of the model in a result; None without one, or where this version refuses it."""
    try:
        return load(model) if model else None
    except ModelError:
        return None


def _distinct(names: Sequence[str]) -> list[str]:
    """Names with a number behind those that stand before already."""
    found: list[str] = []
    for name in names:
        count = sum(one == name or one.startswith(f"{name} (") for one in found)
        found.append(f"{name} ({count + 1})" if count else name)
    return found


# variables of the result ---------------------------------------------------------------------------------------------


def _add_drawing(variables: _Variables, coords: dict[Any, Any], found: Sequence[Difference]) -> None:
    count = len(coords["train"])
    coords["difference"] = _texts(one.path for one in found)
    variables["difference_text"] = (
        ("difference", "train"),
        np.array([one.text for one in found], dtype=object).reshape(-1, count),
    )
    values = [[math.nan if value is None else value for value in one.value] for one in found]
    variables["difference_value"] = (("difference", "train"), np.array(values, dtype=float).reshape(-1, count))
    variables["difference_unit"] = ("difference", _texts(one.unit for one in found))


def _add_variables(variables: _Variables, coords: dict[Any, Any], found: Sequence[VariableDifference]) -> None:
    count = len(coords["train"])
    coords["variable"] = _texts(one.name for one in found)
    variables["variable_unit"] = ("variable", _texts(one.unit for one in found))
    variables["variable_meaning"] = ("variable", _texts(one.meaning for one in found))
    for name, attribute in (
        ("largest_difference", "difference"),
        ("first_value", "first"),
        ("other_value", "other"),
        ("difference_place", "place"),
    ):
        rows = [getattr(one, attribute) for one in found]
        kind = object if attribute == "place" else float
        variables[name] = (("variable", "train"), np.array(rows, dtype=kind).reshape(-1, count))
    variables["compared_values"] = ("variable", np.array([one.points for one in found], dtype=np.int64))


def _add_effects(
    variables: _Variables, coords: dict[Any, Any], trains: Sequence[Train], names: Sequence[str]
) -> list[CodedText]:
    """Add speeds, modes, sharing and forces; returns the warnings, those of single trains with their names."""
    found = [effects_of(train) for train in trains]
    if len({one.method for one in found} - {""}) > 1:  # like with like
        found = [effects_of(train, methods=("static",)) for train in trains]
    variables["transmission_ratio"] = ("train", np.array([one.ratio for one in found]))
    variables["k_gamma"] = ("train", np.array([one.k_gamma for one in found]))
    variables["worst_mesh"] = ("train", _texts(one.worst_mesh for one in found))
    variables["force_method"] = ("train", _texts(one.method for one in found))
    _add_table(variables, coords, "member", {"speed": [one.speed for one in found]})
    _add_table(variables, coords, "stage", {"mesh_frequency": [one.mesh_frequency for one in found]})
    columns = {
        name: [{mesh: row[i] for mesh, row in one.meshes.items()} for one in found]
        for i, name in enumerate(("mean_load_sharing", "mesh_force_mean", "mesh_force_peak"))
    }
    _add_table(variables, coords, "mesh", columns)
    said = _add_modes(variables, coords, found, names)
    return [*_told(found, names), *said]


def _add_table(
    variables: _Variables, coords: dict[Any, Any], dim: str, columns: Mapping[str, Sequence[Mapping[str, float]]]
) -> None:
    """Add columns of numbers by name along a dim that has the names of all trains; nan where one has none."""
    labels = list(dict.fromkeys(name for rows in columns.values() for row in rows for name in row))
    coords[dim] = _texts(labels)
    for name, rows in columns.items():
        values = np.array([[row.get(label, math.nan) for row in rows] for label in labels], dtype=float)
        variables[name] = ((dim, "train"), values.reshape(len(labels), len(rows)))


def _add_modes(
    variables: _Variables, coords: dict[Any, Any], found: Sequence[Effects], names: Sequence[str]
) -> list[CodedText]:
    """Add the natural frequencies of every train beside those of the first."""
    first, count = found[0].modes, len(found)
    if first is None:
        return []
    n = first.frequency.size
    frequency, criterion = np.full((n, count), np.nan), np.full((n, count), np.nan)
    kind, pairing = np.full((n, count), "", dtype=object), np.full(count, "", dtype=object)
    for column, one in enumerate(found):
        if one.modes is None:
            continue
        place, shared, pairing[column] = mode_pairs(first, one.modes)
        has = place >= 0
        frequency[has, column] = one.modes.frequency[place[has]]
        kind[has, column] = np.array(one.modes.kind, dtype=object)[place[has]]
        criterion[:, column] = shared
    variables["frequency"] = (("mode", "train"), frequency)
    variables["mode_kind"] = (("mode", "train"), kind)
    variables["modal_assurance"] = (("mode", "train"), criterion)
    variables["mode_pairing"] = ("train", pairing)
    coords["mode"] = np.arange(1, n + 1)
    changed = [names[i] for i in range(1, count) if np.nanmin(criterion[:, i], initial=1.0) < _LIKE]
    return [
        coded("shapes-changed", f"{name}: some mode shapes have changed so much that their pairs are doubtful")
        for name in changed
    ]


# Modal assurance below which two shapes are rather different modes: half of the energy is in others.
_LIKE = 0.5


def _told(found: Sequence[Effects], names: Sequence[str]) -> list[CodedText]:
    """Warnings of all trains once, those of some with their names."""
    said: list[CodedText] = []
    for text in dict.fromkeys(text for one in found for text in one.warnings):
        mine = [name for name, one in zip(names, found, strict=True) if text in one.warnings]
        said.append(text if len(mine) == len(names) else placed(", ".join(mine), text))
    return said


def _texts(values: Any) -> Any:
    return np.array(list(values), dtype=object)
