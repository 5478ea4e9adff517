"""The best tip and root relief and lead modification of one mesh of a train or of several."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..assemble import assemble
from ..assemble.contact import check_pair
from ..errors import ModelError
from ..files import load
from ..results import dataset
from ..system.system import System
from ..train.connections import Mesh
from ..train.train import Train
from .check import train_provenance
from .contact import contact, force_of, meshes_named
from .relief_objectives import DYNAMIC, OBJECTIVES, Helix, Judge, helices, histories, judged, run_up, speed_curves
from .relief_variables import Setting, Variable, length_text, overrides_of, settings_of, variables_of
from .search import Found, search

if TYPE_CHECKING:
    from .verbs import Source

__all__ = ["relief", "relief_model"]

Array = NDArray[np.float64]

_SHOWN = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
_ALL = 200_000  # numbers of evaluations kept in a result


def relief(
    source: Source,
    *,
    vary: Mapping[str, object],
    overrides: Mapping[str, Any] | None = None,
    mesh: str | Sequence[str] | None = None,
    torque: float | str | None = None,
    objectives: Sequence[str] = ("lte",),
    factors: Sequence[float] = (1.0,),
    speeds: tuple[float, float] | None = None,
    speed_points: int = 30,
    population: int = 60,
    generations: int = 60,
    seed: int = 1,
    resume: str | Path | None = None,
    pick: int | None = None,
    samples: int = 64,
    slices: int = 20,
    corner: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Search micro-geometry: one objective by a genetic algorithm, several by NSGA-II (their Pareto set).

    Parameters
    ----------
    source, overrides : the model.  mesh : names or pairs as of `contact`, or None: every mesh with face widths.
    vary : ``[GEAR.]KEY`` -> bounds ``"0..40 um"``, one value, or shapes; keys as of `relief_variables.KEYS`.
    torque : on the first gear of the mesh [N m], or a text with its unit; None: that of the train.
    objectives : of `relief_objectives.OBJECTIVES`.  factors : loads of lte and load, relative to the operating one.
    speeds : lowest and highest mesh frequency of the dynamic force [Hz], speed_points of them; None: 0.2 .. 1.2 times
        that in operation.
    population, generations, seed : of the search; the same seed gives the same bits.
    resume : a record of what was evaluated, written after every generation and gone on with where it exists.
    pick : number of the solution taken as the answer, 0 the first; None: the one nearest to the best of each objective.
    samples, slices, corner : as of `contact`; teeth that are even along the face are one piece.

    Ctrl-C ends the search with the best so far, which the attribute ``stopped`` says.

    Raises
    ------
    ModelError : the model, a name, bounds or a record is wrong; a relief that does not fit its flank; no pymoo.
    """
    from .verbs import train_of

    train = train_of(source, overrides=overrides)
    _check(objectives, factors, torque)
    chosen = _chosen(train, mesh)
    flanks = {path: flank for sides in chosen for one in sides for path, flank in _flanks(one)}
    variables, fixed = variables_of(vary, flanks)
    forces = [[(one, force_of(train, sides, torque)) for one in sides] for sides in chosen]
    dynamic = any(name in DYNAMIC for name in objectives)
    system = assemble(train) if dynamic else None
    judge = Judge(
        objectives=tuple(objectives),
        variables=variables,
        fixed=fixed,
        meshes=helices(train, forces, samples=samples, slices=slices, corner=corner, variables=variables, fixed=fixed),
        factors=np.array(factors, dtype=float),
        train=train,
        system=system,
        speeds=None if system is None else run_up(system, speeds, speed_points),
    )
    _check_bounds(judge)
    options = {
        **{"vary": dict(vary), "mesh": mesh, "torque": torque, "objectives": list(objectives)},
        **{"factors": list(factors), "samples": samples, "slices": slices, "corner": corner},
        **({"speeds": speeds, "speed_points": speed_points} if dynamic else {}),
    }
    found = search(
        judge,
        len(variables),
        len(objectives),
        population=population,
        generations=generations,
        seed=seed,
        start=_drawn(judge, flanks),
        record=None if resume is None else Path(resume),
        problem=_fingerprint(train, options),
        progress=progress,
    )
    if not found.best.size:
        raise ModelError("no candidate could be computed", path="vary", given=dict(vary))
    answer = _picked(found, pick)
    settings = settings_of(variables, fixed, found.place[answer])
    changes = overrides_of(settings, flanks)
    after = _changed(source, train, {**(overrides or {}), **changes}, changes)
    search_options = {"population": population, "generations": generations, "seed": seed}
    result = dataset(
        {
            **_solutions(judge, found, answer, flanks),
            **_compared(judge, (train, after), torque, samples, slices, corner),
            **(_speeds(judge, settings) if dynamic else {}),
        },
        coords=_coords(judge, found),
        verb="relief",
        options=options | search_options,
        warnings=_warnings(train, after, judge, found, generations),
        provenance=train_provenance(train),
    )
    result.attrs |= {
        "picked": int(np.flatnonzero(found.best == answer)[0]),
        "overrides": json.dumps(changes),
        "relieved_model": json.dumps(dict(after.document), default=str),
        "stopped": int(found.stopped),
        "method": "GA" if len(objectives) == 1 else "NSGA-II",
    }
    return result


def relief_model(result: xr.Dataset) -> str:
    """The model file of a result of `relief`: that of the source, with the flanks of the answer."""
    from ..files.dump import to_toml

    return to_toml(json.loads(str(result.attrs["relieved_model"])))


def _changed(source: Source, train: Train, whole: Mapping[str, Any], changes: Mapping[str, Any]) -> Train:
    """The train with other flanks, read from its source where that is not resolved already."""
    if isinstance(source, Train):
        return load(dict(train.document), changes)
    assert not isinstance(source, System)
    return load(source, whole)


# what is looked at ---------------------------------------------------------------------------------------------------


def _check(objectives: Sequence[str], factors: Sequence[float], torque: object) -> None:
    unknown = [name for name in objectives if name not in OBJECTIVES]
    if unknown or not objectives or len(set(objectives)) != len(objectives):
        raise ModelError("objectives", path="objective", given=list(objectives), allowed=", ".join(OBJECTIVES))
    values = np.asarray(factors, dtype=float)
    if not values.size or not (np.isfinite(values).all() and (values > 0).all()):
        raise ModelError("relative loads", path="factors", given=list(factors), allowed="above 0")
    if torque is not None and any(name in DYNAMIC for name in objectives):
        raise ModelError(
            "the dynamic force is that of the train at its own torque",
            path="torque",
            given=torque,
            allowed="operation.torque in the model",
        )


def _chosen(train: Train, mesh: str | Sequence[str] | None) -> list[tuple[Mesh, ...]]:
    """Helices of every mesh looked at, branches that are alike once."""
    if mesh is not None:
        names = [mesh] if isinstance(mesh, str) else list(mesh)
        found = [meshes_named(train, name) for name in names]
        without = next((name for name, sides in zip(names, found, strict=True) if sides[0].teeth is None), None)
    else:
        first: dict[str, Mesh] = {}
        for one in train.meshes:
            if one.teeth is not None:
                first.setdefault(one.pair, one)
        found = [
            tuple(m for m in train.meshes if m.pair == one.pair and m.branch == one.branch) for one in first.values()
        ]
        without = None if found else "every mesh"
    if without is not None:
        raise ModelError("has no face width, which tooth contact needs", path="mesh", given=without)
    kept = {sides[0].pair: sides for sides in found}
    return list(kept.values())


def _flanks(mesh: Mesh) -> list[tuple[str, Any]]:
    teeth = mesh.teeth
    assert teeth is not None
    return list(zip(teeth.paths, (teeth.flank_a, teeth.flank_b), strict=True))


def _check_bounds(judge: Judge) -> None:
    """Refuse bounds of which the largest values do not fit a flank."""
    for corner in (np.zeros(len(judge.variables)), np.ones(len(judge.variables))):
        settings = settings_of(judge.variables, judge.fixed, corner)
        for helix in (one for sides in judge.meshes for one in sides):
            assert helix.mesh.teeth is not None
            check_pair(helix.shaped(settings), path=helix.mesh.pair, paths=helix.mesh.teeth.paths)


def _drawn(judge: Judge, flanks: Mapping[str, Any]) -> Array | None:
    """The place of what is drawn, (1, v); None where it is out of bounds or differs between flanks."""
    places = []
    for variable in judge.variables:
        values = {_value(flanks[path], variable.key) for path in variable.paths}
        if len(values) > 1:
            return None
        value = values.pop()
        places.append(0.5 if value is None else variable.place(value))
    inside = np.array([0 <= place <= 1 for place in places])
    return np.array([places]) if inside.all() else None


def _value(flank: Any, key: str) -> float | str | None:
    """Value of a key of a flank; a relief that is not drawn has no amount, and any length and shape: None."""
    table, _, name = key.partition(".")
    value = getattr(flank, table)
    if name and value is None:
        return 0.0 if name == "amount" else None
    if name == "shape":
        return str(value.shape)
    return float(getattr(value, name) if name else value)


def _fingerprint(train: Train, options: Mapping[str, Any]) -> str:
    text = json.dumps([dict(train.document), options], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def _picked(found: Found, pick: int | None) -> int:
    """Position of the answer among the evaluations."""
    values = found.objective[found.best]
    if pick is not None:
        if not 0 <= pick < len(found.best):
            raise ModelError("no such solution", path="pick", given=pick, allowed=f"0 .. {len(found.best) - 1}")
        return int(found.best[pick])
    span = np.ptp(values, axis=0)
    far = (values - values.min(axis=0)) / np.where(span > 0, span, 1.0)
    return int(found.best[np.argmin((far**2).sum(axis=1))])


# what comes out ------------------------------------------------------------------------------------------------------


def _coords(judge: Judge, found: Found) -> dict[Any, Any]:
    return {
        "variable": [one.name for one in judge.variables],
        "objective": list(judge.objectives),
        "solution": np.arange(len(found.best)),
        "state": ["before", "after"],
        "relieved_mesh": [_name(sides) for sides in judge.meshes],
        **({} if judge.speeds is None else {"speed": judge.speeds}),
    }


def _name(sides: Sequence[Helix]) -> str:
    name = sides[0].mesh.name
    return name if len(sides) == 1 else name.rsplit("/", 1)[0]


def _solutions(judge: Judge, found: Found, answer: int, flanks: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    places = found.place[found.best]
    values = [[one.value(at) for one, at in zip(judge.variables, place.tolist(), strict=True)] for place in places]
    numbers = [[one.number(v) for one, v in zip(judge.variables, row, strict=True)] for row in values]
    words = [[_words(one, v) for one, v in zip(judge.variables, row, strict=True)] for row in values]
    drawn = judged(judge, [{path: {} for path in flanks}])[0]
    return {
        "lower_bound": ("variable", np.array([one.low for one in judge.variables])),
        "upper_bound": ("variable", np.array([one.high for one in judge.variables])),
        "solution_value": (("solution", "variable"), np.array(numbers)),
        "solution_text": (("solution", "variable"), np.array(words, dtype=object)),
        "solution_objective": (("solution", "objective"), found.objective[found.best]),
        "objective_before": ("objective", drawn),
        "objective_after": ("objective", found.objective[answer]),
        "objective_meaning": ("objective", np.array([OBJECTIVES[name][1] for name in judge.objectives], dtype=object)),
        "objective_unit": ("objective", np.array([OBJECTIVES[name][0] for name in judge.objectives], dtype=object)),
        "evaluated_place": (("evaluation", "variable"), found.place[:_ALL]),
        "evaluated_objective": (("evaluation", "objective"), found.objective[:_ALL]),
        "evaluated_generation": ("evaluation", found.generation[:_ALL]),
        "best_so_far": (("generation", "objective"), _best_so_far(found)),
    }


def _words(variable: Variable, value: float | str) -> str:
    if isinstance(value, str):
        return value
    return length_text(value, -3 if variable.key.endswith("length") else -6)


def _best_so_far(found: Found) -> Array:
    """Least of each objective up to the end of every generation, (G, o)."""
    count = int(found.generation.max()) + 1
    least = [np.nanmin(np.where(found.generation[:, None] <= g, found.objective, np.nan), axis=0) for g in range(count)]
    return np.array(least)


def _compared(
    judge: Judge, trains: Sequence[Train], torque: float | str | None, samples: int, slices: int, corner: bool
) -> dict[str, tuple[Any, Any]]:
    """Loaded contact before and after, of every mesh at several loads."""
    factors = np.array(sorted({*_SHOWN, *judge.factors.tolist()}))
    runs = [
        [
            contact(
                train,
                mesh=_name(sides),
                torque=torque,
                factors=factors.tolist(),
                samples=samples,
                slices=slices,
                corner=corner,
            )
            for sides in judge.meshes
        ]
        for train in trains
    ]

    def each(take: Callable[[xr.Dataset], Array]) -> Array:
        return np.array([[take(one) for one in meshes] for meshes in runs])

    over = ("state", "relieved_mesh", "load_factor")
    return {
        "load_factor": ("load_factor", factors),
        "mesh_phase": ("mesh_phase", np.arange(samples) / samples),
        "relieved_force": ("relieved_mesh", np.array([float(one.attrs["force"]) for one in runs[0]])),
        "relieved_error": ((*over, "mesh_phase"), each(lambda one: one.loaded_transmission_error.values)),
        "relieved_peak_to_peak": (over, each(lambda one: one.transmission_error_peak_to_peak.values)),
        "relieved_largest_load": (over, each(lambda one: one.largest_load_per_length.values.max(axis=0))),
        "relieved_place": (("relieved_mesh", "path_point"), np.array([one.path_place.values for one in runs[0]])),
        "relieved_load": (
            ("state", "relieved_mesh", "path_point"),
            each(_along_path),
        ),
    }


def _along_path(one: xr.Dataset) -> Array:
    """Largest load per length of both faces at places of the path; 0 where nothing touches."""
    return np.asarray(np.nan_to_num(one.flank_load_per_length.values).max(axis=(0, 1)))


def _speeds(judge: Judge, settings: Mapping[str, Setting]) -> dict[str, tuple[Any, Any]]:
    """Dynamic mesh force over the speed, before and after."""
    plain: dict[str, Setting] = {path: {} for path in settings}
    curves = [speed_curves(judge, histories(judge, one)) for one in (plain, settings)]
    return {DYNAMIC[name]: (("state", "speed"), np.array([one[name] for one in curves])) for name in DYNAMIC}


def _warnings(train: Train, after: Train, judge: Judge, found: Found, generations: int) -> list[str]:
    said = [*train.warnings, *(text for text in after.warnings if text not in train.warnings)]
    done = int(found.generation.max()) + 1
    if found.stopped:
        said.append(f"stopped after {done} of {generations} generations: the best so far")
    failed = int((~np.isfinite(found.objective)).any(axis=1).sum())
    if failed:
        said.append(f"{failed} of {len(found.objective)} candidates could not be computed")
    for column, variable in enumerate(judge.variables):
        at = found.place[found.best, column]
        if not variable.shapes and len(at) == 1 and (at[0] < 1e-3 or at[0] > 1 - 1e-3):
            said.append(f"{variable.name} ends at its {'lower' if at[0] < 0.5 else 'upper'} bound")
    return said
