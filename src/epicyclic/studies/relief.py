"""The best tip and root relief and lead modification of one mesh of a train or of several."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..assemble import assemble
from ..errors import ModelError
from ..resolve import load
from ..results.dataset import dataset
from ..system.system import System
from ..tooth_contact.pair import check_pair
from ..train.connections import Mesh
from ..train.train import Train
from .check import train_provenance
from .relief_objectives import DYNAMIC, OBJECTIVES, Cut, Judge, helices, run_up
from .relief_result import compared, coords, over_speed, said, solutions
from .relief_variables import overrides_of, settings_of, variables_of
from .search import Found, search
from .tooth_contact import force_of, meshes_named, radians_of

if TYPE_CHECKING:
    from .source import Source

__all__ = ["relief", "relief_model"]

Array = NDArray[np.float64]


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
    misalignment: float | str = 0.0,
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
    samples, slices, corner, misalignment : as of `contact`; teeth that are even along the face are one piece.

    Ctrl-C ends the search with the best so far, which the attribute ``stopped`` says.

    Raises
    ------
    ModelError : the model, a name, bounds or a record is wrong; a relief that does not fit its flank; no pymoo.
    """
    from .source import train_of

    train = train_of(source, overrides=overrides)
    cut = Cut(samples=samples, slices=slices, corner=corner, misalignment=radians_of(misalignment))
    _check(objectives, factors, torque, cut)
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
        meshes=helices(train, forces, cut, variables=variables, fixed=fixed),
        factors=np.array(factors, dtype=float),
        train=train,
        system=system,
        speeds=None if system is None else run_up(system, speeds, speed_points),
    )
    _check_bounds(judge)
    options = {
        **{"vary": dict(vary), "mesh": mesh, "torque": torque, "objectives": list(objectives)},
        **{"factors": list(factors), **asdict(cut)},
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
            **solutions(judge, found, answer, flanks),
            **compared(judge, (train, after), torque, cut),
            **(over_speed(judge, settings) if dynamic else {}),
        },
        coords=coords(judge, found),
        verb="relief",
        options=options | search_options,
        warnings=said(train, after, judge, found, generations),
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
    from ..model.toml_writer import to_toml

    return to_toml(json.loads(str(result.attrs["relieved_model"])))


def _changed(source: Source, train: Train, whole: Mapping[str, Any], changes: Mapping[str, Any]) -> Train:
    """The train with other flanks, read from its source where that is not resolved already."""
    if isinstance(source, Train):
        return load(dict(train.document), changes)
    assert not isinstance(source, System)
    return load(source, whole)


# what is looked at ---------------------------------------------------------------------------------------------------


def _check(objectives: Sequence[str], factors: Sequence[float], torque: object, cut: Cut) -> None:
    if cut.samples < 3 or cut.slices < 1:
        given = cut.samples, cut.slices
        raise ModelError("out of range", path="samples, slices", given=given, allowed="3 or more, 1 or more")
    unknown = [name for name in objectives if name not in OBJECTIVES]
    if unknown or not objectives or len(set(objectives)) != len(objectives):
        raise ModelError("objectives", path="objectives", given=list(objectives), allowed=", ".join(OBJECTIVES))
    values = np.asarray(factors, dtype=float)
    if not values.size or not (np.isfinite(values).all() and (values > 0).all()):
        raise ModelError("relative loads", path="loads", given=list(factors), allowed="above 0")
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
