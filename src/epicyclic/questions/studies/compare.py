"""Several trains or saved results beside each other, as a Dataset of kind `compare`: what differs, and what it does.

Of trains what differs in the drawings, paths of their model files and the values there, and what it does; of saved
results the largest difference of every variable that all have.

Modes of two trains are paired by their shapes where the coordinates are the same, else by kind and order.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.tables import leaves
from ...document.units import KINDS, factor
from ...engine.points import along, attempt, columns
from ...engine.source import StudyAxis, train_of
from ...errors import ModelError
from ...limits import SAME_SHAPE
from ...results.dataset import EQUAL, SUFFIXES, dataset, largest, load_result
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.resolution import load
from ...train.train import Train
from ...user_input import checked
from ...warning_codes import CodedText, coded, placed
from ..modes.campbell import modal_assurance
from ..modes.eigen import classify_modes, mean_modes, repeated_roots
from ..sharing import SharingOptions
from ..sharing.sharing import sharing
from .sensitivity import named_leaves

_WORDS = ("format", "title", "doi", "notes", "assumed")  # tables of words, which no result follows
# Relative difference of the same quantity written in two units: six digits are written.
_WRITTEN = 5e-6
_NUMBER = re.compile(r"\s*([+-]?(?:[0-9.]+(?:[eE][+-]?[0-9]+)?|inf))\s*(\S.*)?")
# Trains beside each other at most: more columns than that nobody reads.
MOST = 12

Source = Any
_Variables = dict[str, tuple[tuple[str, ...] | str, Any]]


# --- drawings --------------------------------------------------------------------------------------------------------


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
    differences = {}
    for path in dict.fromkeys(path for table in tables for path in table):
        difference = _difference(path, tables, trains)
        if difference is not None:
            differences[path] = difference
    names = named_leaves({path: difference.text for path, difference in differences.items()})
    return tuple(replace(differences[first], path=name) for name, (first, *_) in names.items())


def _difference(path: str, tables: Sequence[Mapping[str, object]], trains: Sequence[Train]) -> Difference | None:
    """The difference at one path, None where all are the same."""
    read = [_read(table.get(path), path, train) for table, train in zip(tables, trains, strict=True)]
    texts, values, units = ([entry[i] for entry in read] for i in range(3))
    units = [unit for unit in units if unit]
    if len(set(units)) > 1:  # written as other quantities, J/r^2 and J: what they come to has one unit
        return _resolved(path, tuple(map(str, texts)), trains)
    unit = str(units[0]) if units else ""
    known = [(unit_of or unit, value) if value is not None else text for text, value, unit_of in read]
    if all(entry == known[0] for entry in known[1:]):
        return None
    return Difference(path=path, text=tuple(map(str, texts)), value=tuple(values), unit=unit)  # type: ignore[arg-type]


def _resolved(path: str, texts: tuple[str, ...], trains: Sequence[Train]) -> Difference | None:
    """The difference of values in several units, by what they are resolved to; without numbers where that is none."""
    derived = [next((entry for entry in train.values if entry.path == path), None) for train in trains]
    values = [float(entry.value) for entry in derived if entry is not None and isinstance(entry.value, int | float)]
    units = {entry.unit for entry in derived if entry is not None}
    if len(values) < len(trains) or len(units) > 1:
        return Difference(path=path, text=texts, value=(None,) * len(trains), unit="")
    if all(math.isclose(value, values[0], rel_tol=_WRITTEN) for value in values[1:]):
        return None
    return Difference(path=path, text=texts, value=tuple(values), unit=units.pop())


def _read(value: object, path: str, train: Train) -> tuple[str, float | None, str]:
    """Text, SI number or None, and SI unit of what stands at a path, or of what follows where nothing stands."""
    if value is None:
        derived = next((entry for entry in train.values if entry.path == path), None)
        if derived is None or not isinstance(derived.value, int | float | str):
            return "", None, ""
        number = float(derived.value) if isinstance(derived.value, int | float) else None
        shown = f"{number:.6g}" if number is not None else str(derived.value)
        return f"{shown} {derived.unit}".rstrip() + f" ({derived.origin})", number, derived.unit
    if isinstance(value, bool | dict | list | tuple):
        return _plain(value), None, ""
    if isinstance(value, int | float):
        return f"{value:.6g}", float(value), ""
    text = str(value)
    number_and_unit = _NUMBER.fullmatch(text)
    if number_and_unit is None:
        return text, None, ""
    digits, unit = number_and_unit.groups()
    if not unit:
        return text, float(digits), ""
    for kind in KINDS.values():
        if kind.unit and (scale := factor(unit, kind.unit)) is not None:
            return text, float(f"{float(digits) * scale:.15g}"), kind.unit
    return text, None, ""


def _plain(value: object) -> str:
    """A value that is no number as TOML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_plain, value))}]"
    return str(value)


# --- saved results ---------------------------------------------------------------------------------------------------


class VariableDifference(NamedTuple):
    """Largest difference of one variable between the first result and each other one.

    rows : of each result, the first one's own nan and "": difference, the values of the first and of the other there,
        labels of the place.  points : how many values are compared.
    """

    name: str
    unit: str
    meaning: str
    rows: Sequence[tuple[float, float, float, str]]
    points: int


def variable_differences(results: Sequence[xr.Dataset]) -> tuple[VariableDifference, ...]:
    """Differences of all numbers that every result has, the largest for its size first.

    Values are compared where the labels of their dims agree; of complex numbers the difference is that of the complex
    values.  Variables of different dims, or without any label in common, are left out.
    """
    entries = []
    for name in results[0].data_vars:
        if "bin" in results[0][name].dims:  # counts of a histogram: its quantiles say what moved
            continue
        if all(name in result.data_vars and result[name].dims == results[0][name].dims for result in results):
            entry = _differences(str(name), [result[name] for result in results])
            if entry is not None:
                entries.append(entry)
    return tuple(sorted(entries, key=lambda entry: -_relative(entry)))


def _differences(name: str, variables: Sequence[xr.DataArray]) -> VariableDifference | None:
    """Differences of one variable; None where there are no numbers to compare."""
    if any(variable.dtype.kind not in "ifcub" for variable in variables):
        return None
    rows: list[tuple[float, float, float, str]] = [(math.nan, math.nan, math.nan, "")]
    points = 0
    for other in variables[1:]:
        try:
            a, b = xr.align(variables[0], other, join="inner")
        except ValueError:  # dims without labels, of another length; labels that stand twice
            return None
        if a.shape != b.shape or not a.size:
            return None
        first, second = (np.asarray(values).astype(complex) for values in (a.values, b.values))
        with np.errstate(invalid="ignore"):  # both infinite: no difference is known
            size = np.abs(second - first)
        if not np.isfinite(size).any():
            return None
        place = np.unravel_index(largest(np.where(np.isfinite(size), size, np.nan), equal=EQUAL), size.shape)
        rows.append((float(size[place]), _shown(first[place]), _shown(second[place]), _label(a, place)))
        points = int(np.isfinite(size).sum())
    unit, meaning = (str(variables[0].attrs.get(name, "")) for name in ("units", "long_name"))
    return VariableDifference(name=name, unit=unit, meaning=meaning, rows=rows, points=points)


def _shown(value: complex) -> float:
    """A real number as it is, the size of a complex one."""
    return float(value.real) if value.imag == 0 else float(abs(value))


def _label(values: xr.DataArray, place: Sequence[np.integer]) -> str:
    """Labels of one place, or its number where a dim has none."""
    parts = []
    for dim, at in zip(values.dims, place, strict=True):
        label = values[dim].values[at] if dim in values.coords else int(at)
        parts.append(f"{dim} {label:.6g}" if isinstance(label, float) else f"{dim} {label}")
    return ", ".join(parts)


def _relative(entry: VariableDifference) -> float:
    """Largest difference per largest value there [1]."""
    return max(d / max(abs(a), abs(b), 1e-300) if d else 0.0 for d, a, b, _ in entry.rows[1:])


# --- the verb --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Compared:
    """One of what is compared: name, its Train if it has a model, its result if it is one."""

    name: str
    train: Train | None
    result: xr.Dataset | None


@checked
def compare(
    *sources: str | Path | Mapping[str, Any] | Train | System | xr.Dataset,
    overrides: Mapping[str, Any] | None = None,
    variants: Sequence[Mapping[str, Any]] = (),
) -> xr.Dataset:
    """What differs between the drawings of several trains, and what it does to modes, load sharing and forces.

    Parameters
    ----------
    sources : model files, ready drives, dicts, Trains; or saved results (.nc, .json) and Datasets of results.  The
        first is what the others are compared with.  Results alone are compared variable by variable.
    overrides : path -> value, laid over every model.
    variants : path -> value, laid over the first model: one more train each.

    Returns
    -------
    Dataset of kind `compare` along `train`: difference_text, difference_value (difference, train); transmission_ratio,
    k_gamma, worst_mesh (train); speed (member, train) [rpm]; frequency, mode_kind, modal_assurance (mode, train), modes
    paired as `mode_pairing` says; mean_load_sharing, mesh_force_mean, mesh_force_peak (mesh, train) [N] at operation.

    Raises
    ------
    ModelError : fewer than two to compare, a wrong model or result.
    """
    count = len(sources) + len(variants)
    if not 2 <= count <= MOST:
        raise ModelError("not a number of trains to compare", path="sources", given=count, allowed=f"2 to {MOST}")
    first: Any = sources[0]
    if variants and (isinstance(first, Train | System | xr.Dataset) or _is_result(first)):
        raise ModelError("varies a model alone", path="variants", allowed="a model file or ready drive first")
    compared = [_compared(source, overrides) for source in sources]
    for changes in variants:
        name = "; ".join(f"{path}={value}" for path, value in changes.items()) or "as drawn"
        compared.append(replace(_compared(first, {**(overrides or {}), **changes}), name=name))
    names = distinct_names([entry.name for entry in compared])
    trains = [entry.train for entry in compared if entry.train is not None]
    results = [entry.result for entry in compared if entry.result is not None]
    variables: _Variables = {}
    coords: dict[Any, Any] = {"train": names}
    said: list[CodedText] = []
    if len(trains) == count:
        _add_drawing(variables, coords, drawing_differences(trains))
    if len(results) == count:
        _add_variables(variables, coords, variable_differences(results))
    elif len(trains) < count:
        missing = next(name for name, entry in zip(names, compared, strict=True) if entry.train is None)
        allowed = "results alone, or models"
        raise ModelError("a result without its model", path="sources", given=missing, allowed=allowed)
    else:
        changes_of = (*({} for _ in sources), *variants)
        said = _add_effects(variables, coords, trains, StudyAxis(name="train", changes=changes_of, labels={}))
    return dataset(
        variables,
        coords,
        verb="compare",
        options={"overrides": dict(overrides or {}), "variants": [dict(changes) for changes in variants]},
        provenance={"title": f"{names[0]} beside {', '.join(names[1:])}"},
        warnings=said,
    )


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
        try:
            of_result = load(model) if model else None
        except ModelError:  # of a model that this version refuses
            of_result = None
        return _Compared(name=name, train=of_result, result=result)
    train = train_of(source, overrides=None if isinstance(source, Train) else overrides)
    if isinstance(source, str | Path):
        path = Path(source)
        return _Compared(name=path.stem if path.suffix else str(source), train=train, result=None)
    return _Compared(name=train.title, train=train, result=None)


def distinct_names(names: Sequence[str]) -> list[str]:
    """Names with a number behind those that stand before already, by themselves or so numbered."""
    distinct: list[str] = []
    for name in names:
        label, number = name, 1
        while label in distinct:
            number += 1
            label = f"{name} ({number})"
        distinct.append(label)
    return distinct


# --- variables of the result -----------------------------------------------------------------------------------------


def _add_drawing(variables: _Variables, coords: dict[Any, Any], differences: Sequence[Difference]) -> None:
    count = len(coords["train"])
    coords["difference"] = _texts(entry.path for entry in differences)
    texts = np.array([entry.text for entry in differences], dtype=object)
    values = [[math.nan if value is None else value for value in entry.value] for entry in differences]
    variables["difference_text"] = (("difference", "train"), texts.reshape(-1, count))
    variables["difference_value"] = (("difference", "train"), np.array(values, dtype=float).reshape(-1, count))
    variables["difference_unit"] = ("difference", _texts(entry.unit for entry in differences))


def _add_variables(variables: _Variables, coords: dict[Any, Any], entries: Sequence[VariableDifference]) -> None:
    count = len(coords["train"])
    coords["variable"] = _texts(entry.name for entry in entries)
    variables["variable_unit"] = ("variable", _texts(entry.unit for entry in entries))
    variables["variable_meaning"] = ("variable", _texts(entry.meaning for entry in entries))
    for i, name in enumerate(("largest_difference", "first_value", "other_value", "difference_place")):
        values = np.array([[row[i] for row in entry.rows] for entry in entries], object).reshape(-1, count)
        variables[name] = (("variable", "train"), values if name == "difference_place" else values.astype(float))
    variables["compared_values"] = ("variable", np.array([entry.points for entry in entries], dtype=np.int64))


def _add_effects(
    variables: _Variables, coords: dict[Any, Any], trains: Sequence[Train], axis: StudyAxis
) -> list[CodedText]:
    """Add speeds, modes, sharing and forces; returns the warnings, those of single trains with their names."""
    names, effects = coords["train"], [effects_of(train) for train in trains]
    if len({str(of_train.figures.force_method.values) for of_train in effects} - {""}) > 1:  # like with like
        effects = [effects_of(train, methods=("static",)) for train in trains]
    first = effects[0].modes
    figures = [
        table if first is None or modes is None else table.merge(_paired(first, modes)) for table, modes, _ in effects
    ]
    # labels stand as they first come, not sorted
    labels = {
        dim: list(dict.fromkeys(name for table in figures if dim in table.dims for name in table[dim].values))
        for dim in figures[0].dims
    }
    whole = along((axis,), figures).reindex(labels).transpose(..., "train")
    variables |= columns(whole)
    coords |= {dim: whole[dim].values.astype(figures[0][dim].dtype) for dim in labels}
    said: list[CodedText] = []
    # warnings of all trains once, those of some with their names
    for text in dict.fromkeys(text for of_train in effects for text in of_train.warnings):
        where = [name for name, of_train in zip(names, effects, strict=True) if text in of_train.warnings]
        said.append(text if len(where) == len(names) else placed(", ".join(where), text))
    if first is None:
        return said
    least = [np.nanmin(criterion, initial=1.0) for criterion in whole.modal_assurance.values.T]
    return said + [
        coded("shapes-changed", f"{name}: some mode shapes have changed so much that their pairs are doubtful")
        for name, assurance in zip(names, least, strict=True)
        if assurance < SAME_SHAPE
    ]


def _paired(first: TrainModes, modes: TrainModes) -> xr.Dataset:
    """Natural frequencies (mode) of a train beside those of the first, and how modes are paired."""
    place, criterion, pairing = mode_pairs(first, modes)
    kinds = np.array(modes.kind, dtype=object)
    return xr.Dataset(
        {
            "frequency": ("mode", np.where(place >= 0, modes.frequency[place], np.nan)),
            "mode_kind": ("mode", np.where(place >= 0, kinds[place], "")),
            "modal_assurance": ("mode", criterion),
            "mode_pairing": ((), np.array(pairing, dtype=object)),
        },
        coords={"mode": np.arange(1, place.size + 1)},
    )


def _texts(values: Any) -> Any:
    return np.array(list(values), dtype=object)


BY_SHAPE, BY_KIND = "mode shapes (MAC)", "kind and order"
_ALIKE = 0.1  # of two shapes of another criterion nobody would say that they are one mode
Of = TypeVar("Of")
Result = TypeVar("Result")
Method = Literal["steady", "static"]
_RIGID = "rigid"
# Coefficients of meshes this close are equal but for rounding of the linear solves: no mesh is the worst.
_SAME = 1e-6


# --- modes of two trains ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrainModes:
    """Modes of the undamped mean system of one train, rising.

    squared : (n,) omega^2 [rad^2/s^2].  vectors : (n, n), Phi^T M Phi = 1.  mass : M (n, n).  kind : (n,).
    dofs : (n,) names of the coordinates.
    """

    squared: Array
    vectors: Array
    mass: Array
    kind: tuple[str, ...]
    dofs: tuple[str, ...]

    @property
    def frequency(self) -> Array:
        """Natural frequencies (n,) [Hz]."""
        return np.asarray(np.sqrt(self.squared) / (2 * np.pi))


def mode_pairs(a: TrainModes, b: TrainModes) -> tuple[NDArray[np.int64], Array, str]:
    """Mode of b that each mode of a corresponds to.

    Returns
    -------
    (place in b (n,), -1 without one; modal assurance criterion (n,) [1], nan where modes are paired by kind; which of
    `BY_SHAPE` and `BY_KIND`).
    """
    from scipy.optimize import linear_sum_assignment  # a third of a second where no train is compared

    same_bodies = {name.rpartition("/")[0] for name in a.dofs} == {name.rpartition("/")[0] for name in b.dofs}
    if same_bodies and (set(a.dofs) <= set(b.dofs) or set(b.dofs) < set(a.dofs)):
        # the largest sum of modal assurance criteria [allemang1982] of the eigenspaces, weighted by both M; further
        # coordinates of one train, as of a ring that bends, are at rest in the shapes of the other
        names = max(a.dofs, b.dofs, key=len)
        # coordinates of each among those of both, (n, own)
        of_a, of_b = ((np.array(names)[:, None] == np.array(own.dofs)).astype(float) for own in (a, b))
        mass = (of_a @ a.mass @ of_a.T + of_b @ b.mass @ of_b.T) / 2
        roots = repeated_roots(a.squared), repeated_roots(b.squared)
        _, criterion = modal_assurance(of_a @ a.vectors, of_b @ b.vectors, mass, roots)
        rows, pairs = linear_sum_assignment(criterion, maximize=True)
        place, found = np.full(len(criterion), -1), np.full(len(criterion), np.nan)
        alike = criterion[rows, pairs] >= _ALIKE
        place[rows[alike]], found[rows[alike]] = pairs[alike], criterion[rows, pairs][alike]
        return place, found, BY_SHAPE
    # the k-th mode of a kind to the k-th of the same kind
    ranks, of_b = ([(kind, kinds[:i].count(kind)) for i, kind in enumerate(kinds)] for kinds in (a.kind, b.kind))
    place = np.array([of_b.index(rank) if rank in of_b else -1 for rank in ranks], dtype=np.int64)
    return place, np.full(place.size, np.nan), BY_KIND


# --- effects of one train --------------------------------------------------------------------------------------------


class Effects(NamedTuple):
    """What a train does; what is not known is empty or nan.

    figures : transmission_ratio, speed of the driving member per speed of the driven one [1]; k_gamma, `mean-load` of
        the train [1], and worst_mesh, which it is of, empty where all are alike; force_method of the mesh forces;
        speed (member) [rpm]; mesh_frequency (stage) [Hz]; mean_load_sharing, coefficient `mean-load` [1],
        mesh_force_mean and mesh_force_peak (mesh) [N] of whole meshes.
    modes : of the mean system.
    """

    figures: xr.Dataset
    modes: TrainModes | None
    warnings: Sequence[CodedText]


def effects_of(train: Train, *, methods: Sequence[Method] = ("steady", "static")) -> Effects:
    """Effects of one train; an analysis that its model does not allow is left out, and a warning says why.

    methods : of the mesh forces, the first that the model allows counts.
    """
    said: list[CodedText] = list(train.warnings)
    system = _tried("equations", assemble, train, said)
    modes = None if system is None else _tried("natural frequencies", modes_of, system, said)
    k_gamma, worst, used, mesh, forces = math.nan, "", "", _texts(()), np.zeros((3, 0))
    refused: list[CodedText] = []
    for method in methods if system is not None else ():
        shared = partial(sharing, options=SharingOptions(method=method))
        result = _tried(f"mesh forces by {method}", shared, system, refused)
        if result is not None:
            said += [*refused, *json.loads(result.attrs["warnings"])]
            by_mean = result.sel(definition="mean-load")
            used, mesh, k_gamma = method, _texts(map(str, result.mesh.values)), float(by_mean.system_load_sharing)
            forces = np.array([by_mean.load_sharing, result.mesh_force_mean, result.mesh_force_peak])
            known = forces[0][np.isfinite(forces[0])]
            worst = mesh[largest(forces[0])] if known.size and np.ptp(known) > _SAME else ""
            break
    else:
        said += refused[-1:]
    speed, tone = train.kinematics.speed or {}, train.kinematics.mesh_frequency or {}
    figures = xr.Dataset(
        {
            "transmission_ratio": transmission_ratio(train),
            "k_gamma": k_gamma,
            "worst_mesh": ((), np.array(worst, dtype=object)),
            "force_method": ((), np.array(used, dtype=object)),
            "speed": ("member", np.array([float(value) for value in speed.values()])),
            "mesh_frequency": ("stage", np.array([float(value) for value in tone.values()])),
            "mean_load_sharing": ("mesh", forces[0]),
            "mesh_force_mean": ("mesh", forces[1]),
            "mesh_force_peak": ("mesh", forces[2]),
        },
        coords={"member": _texts(speed), "stage": _texts(tone), "mesh": mesh},
    )
    return Effects(figures, modes, tuple(dict.fromkeys(said)))


def _tried(what: str, work: Callable[[Of], Result], of: Of, said: list[CodedText]) -> Result | None:
    """What a function gives; None and a warning where the model does not allow it."""
    outcome = attempt(work, of)
    if outcome.error is not None:
        said.append(coded("section-left-out", f"no {what}: {outcome.reason}"))
    return outcome.value


def transmission_ratio(train: Train) -> float:
    """Speed of the member that takes in most power per speed of the one that gives off most."""
    power, speed = train.kinematics.power or {}, train.kinematics.speed or {}
    if not power or max(power.values()) <= 0 or min(power.values()) >= 0:
        return math.nan
    driving, driven = max(power, key=lambda name: power[name]), min(power, key=lambda name: power[name])
    return float(speed[driving] / speed[driven]) if speed.get(driven) else math.nan


def modes_of(system: System) -> TrainModes:
    """Modes of the mean system of a train."""
    tangent = linear(system)
    squared, vectors = mean_modes(tangent)
    kinds = classify_modes(tangent, squared, vectors)
    return TrainModes(
        squared=squared,
        vectors=np.real(kinds.vectors),
        mass=tangent.M,
        kind=tuple(_RIGID if value == 0 else kind for kind, value in zip(kinds.kind, squared, strict=True)),
        dofs=tuple(tangent.dofs.names),
    )
