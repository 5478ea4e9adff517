"""Life of rolling bearings: loads of their elements under the forces of statics, rating life, Miner's sum over cases.

Forces are those along x and y of the link of a bearing, at rest or in steady vibration with linear contact, at instants
spread over the common period of the train: with the weight as the carrier turns, run-outs at their own orders, the mesh
cycle.  The life of a case is Miner's sum over its instants, 1/L = mean 1/L(t), by the
loads of elements and laminae [iso16281]; beside it L = (C/P)^p with P = (mean F^p)^(1/p) [iso281].  Forces along the
axis and moments count where the bearing follows the law of five rows.

Which race turns against the load follows from the motion: of the force as each race sees it, the one with the larger
mean over its sizes stands.  On a planet's pin the load goes round with the carrier, and the outer race turns.

What other clearances, ratings and floating suns would make of the bearing that lives shortest is computed by the same.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from ...bearings.rolling_bearing import (
    LAMINAE,
    RollingBearing,
    basic_life,
    displacement,
    distributed_life,
    dynamic_rating,
    equivalent_load,
    life_exponent,
    life_modification,
    static_rating,
)
from ...engine.points import outcomes
from ...engine.source import Drive, Duty, StudyAxis
from ...errors import ModelError
from ...results.dataset import dataset, largest
from ...statics.record import Record, record_of
from ...statics.static import group_row_forces, held_train, quasi_static
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...train.resolution import load, path_at_case
from ...train.train import Link, Train
from ...warning_codes import CodedText, coded
from ..response import SteadyOptions
from ..response.steady import link_row_forces, steady
from . import LifeOptions
from .bearing_state import (
    NO_LOAD,
    State,
    bearing_coords,
    bearing_state,
    body_turns,
    dented,
    force_rows,
    inner_first,
    inner_force,
    rolling_links,
    state_columns,
)

# Places of a row, and radial loads at which a life is computed; between them log L is linear in log F.
_PLACES, _LOADS = 48, 12
_STANDS = 1e-9  # speed of a race against the other per the fastest body that is none


def life(source: Train | Duty, options: LifeOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Lives of all bearings that are stated by their parts.

    Parameters
    ----------
    source : one train, or the load cases of one drawing with their shares of the time; one that fails is left out.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : of each case (bearing, case) bearing_load [N], bearing_life_basic, bearing_life_reference,
        bearing_life_modified [s], race_speed [rad/s], turning_race, element_load (.., element) [N], element_pressure
        [Pa], load_zone_extent [1], bearing_stiffness [N/m], static_safety [1], cage_frequency, outer_race_frequency,
        inner_race_frequency, element_frequency [Hz], damage_share [1]; of all (bearing) bearing_duty_life_basic,
        bearing_duty_life_reference, bearing_duty_life_modified [s], bearing_rating, bearing_static_rating [N].

    Raises
    ------
    ModelError : no such bearing, a train that does not turn; of load cases where none is left.
    ConvergenceError : no equilibrium.
    """
    cases: Mapping[str, tuple[Train | Drive, float]]
    cases = {"operation": (source, 1.0)} if isinstance(source, Train) else source.cases
    outcome = outcomes(
        partial(_bearings, options), [given for given, _ in cases.values()], long=True, progress=progress
    )
    found, good, warnings = dict[tuple[str, str], State](), list[str](), list[CodedText]()
    for case, one in zip(cases, outcome, strict=True):
        if one.value is None:
            text = f"{case} is left out, its share of the time is without load: {one.reason}"
            warnings.append(coded("case-failed", text))
            continue
        good.append(case)
        found |= {(name, case): state for name, state in one.value[0].items()}
        warnings += one.value[1]
    if not good:
        assert outcome[0].error is not None
        raise outcome[0].error
    given = cases[good[0]][0]
    first = given if isinstance(given, Train) else given.train
    links = rolling_links(first)
    warnings += [
        *_standing(found),
        *dented({" in ".join(key): one for key, one in found.items()}),
        *_not_counted(first, links),
    ]
    columns = _columns(found, links, good, np.array([cases[case][1] for case in good]))
    return dataset(
        columns,
        bearing_coords(links, columns) | {"case": good},
        verb="life",
        options=asdict(options),
        provenance=train_provenance(first),
        warnings=list(dict.fromkeys(warnings)),
    )


def _bearings(options: LifeOptions, given: Train | Drive) -> tuple[dict[str, State], Sequence[CodedText]]:
    """Bearings of a train at one operating point by their names, and warnings of the train."""
    train = given if isinstance(given, Train) else given.train
    if not (rolling := rolling_links(train)):
        allowed = '"cylindrical roller" or another, and its parts'
        raise ModelError("no bearing is stated by its parts", path="stages.*.planet.bearing.type", allowed=allowed)
    if train.kinematics.speed is None:
        raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
    system = assemble(train)
    system.require_turning()
    if not any(system.body_turns):
        problem = "nothing turns, and no race against the other"
        where = path_at_case(train.document, "operation.speed")
        raise ModelError(problem, path=where, allowed="a speed above 0")
    record, said = _record(system, options), system.warnings
    if options.forces == "steady":
        rows, said = link_row_forces(system, record), json.loads(steady(system, SteadyOptions(samples=1)).warnings)
    else:
        rows = _row_forces(system, record)
    turns, time = body_turns(train), record.index / float(record.unit * record.samples)
    return {link.name: _in_case(link, inner_force(link, rows), system, time, turns) for link in rolling}, said


def _record(system: System, options: LifeOptions) -> Record:
    """Instants that divide the common period evenly, in turns of the slowest body.

    Their number is prime and divides neither the period nor a number of teeth: at the k-th of n instants a line of m
    cycles in the period is at the phase k m/n, and so passes n phases (a lattice rule).  A law with a memory follows
    one turn.
    """
    turns = {name: abs(turn) for name, turn in zip(system.dofs.bodies, system.body_turns, strict=True) if turn}
    of = min(turns, key=lambda name: turns[name])
    turn = record_of(system, cycles=None, turns=1, of=of, samples=options.instants, most=options.instants)
    if system.laws.memory.any():
        return turn
    primes = (n for n in itertools.count(options.instants) if all(n % d for d in range(2, math.isqrt(n) + 1)))
    count = next(n for n in primes if turn.period % n)
    return replace(turn, unit=turn.unit * Fraction(count, turn.period), samples=1, count=count, period=count)


def _row_forces(system: System, record: Record) -> dict[str, Array]:
    """Force (T,) [N] of every row of the links, those of laws too, by its name."""
    pieces = list(quasi_static(held_train(system), record))
    linear = np.concatenate([system.links.stiffness * piece.link_deflection for piece in pieces])
    return dict(zip(system.links.name, linear.T, strict=True)) | group_row_forces(system, pieces)


def _in_case(link: Link, force: Array, system: System, time: Array, turns: Mapping[str, float]) -> State:
    """A bearing under forces as of `inner_force` at times (T,) [s]."""
    bearing = link.rolling
    assert bearing is not None
    first, second = turns[link.first], turns[link.second] if link.second is not None else 0.0
    axes = first if link.kind == "bearing" and link.second is not None else _frame(link, system)
    size, wave = np.hypot(*force.T[:2]), force[:, 0] + 1j * force[:, 1]
    steady = [abs(np.mean(wave * np.exp(-2j * np.pi * (race - axes) * time))) for race in (first, second)]
    turning = "outer" if (steady[0] >= steady[1]) == inner_first(link) else "inner"
    p, quiet = life_exponent(bearing), NO_LOAD * static_rating(bearing)
    load = float(np.mean(size**p) ** (1 / p))
    reference = _life(bearing, force, turning) if max(load, abs(force).max()) > quiet else np.inf
    basic = float(basic_life(bearing, load)) if load > quiet else np.inf
    if bearing.contact_angle or force.shape[1] == 3:  # without X and Y of ISO 281: the radial load of the same life
        load, basic = float(equivalent_load(bearing, reference)), np.nan
    modified = np.nan
    if link.lubrication and np.isfinite(reference):
        kappa, contamination = link.lubrication
        stands_for = equivalent_load(bearing, reference)
        modified = reference * float(life_modification(bearing, stands_for, kappa=kappa, contamination=contamination))
    state = bearing_state(link, force, turns) | {"bearing_load": load, "turning_race": turning}
    turn = 1e6 * 2 * np.pi / state["race_speed"] if state["race_speed"] > _STANDS else np.inf  # of a million [s]
    lives = {"basic": basic, "reference": reference, "modified": modified}
    return state | {f"bearing_life_{name}": life * turn for name, life in lives.items()}


def _frame(link: Link, system: System) -> float:
    """Speed of the frame in which a link has its axes [rev/s]."""
    return float(system.stage_turns.get(link.first.partition("/")[0], 0))


def _life(bearing: RollingBearing, force: Array, turning: Any) -> float:
    """Life [10^6 revolutions] by Miner's sum over forces as of `inner_force`."""
    options: dict[str, Any] = {"places": _PLACES, "laminae": LAMINAE}
    size = loads = np.hypot(*force.T[:2])
    low, high = max(size.min(), 1e-3 * size.max()), size.max()
    if force.shape[1] == 2:
        loads = np.geomspace(low, high, _LOADS) if high > (1 + 1e-6) * low else np.array([high])
    q = displacement(bearing, force if force.shape[1] > 2 else loads[:, None], **options)
    lives = distributed_life(bearing, q, turning=turning, **options)
    if force.shape[1] == 2:
        lives = np.exp(np.interp(np.log(np.maximum(size, low)), np.log(loads), np.log(lives)))
    return float(1 / np.mean(1 / lives))


def _standing(found: Mapping[tuple[str, str], State]) -> list[CodedText]:
    """Warnings of loaded bearings whose races stand against each other."""
    stand = (name for (name, _), one in found.items() if one["race_speed"] <= _STANDS and one["element_pressure"] > 0)
    text = "the races of {} do not turn against each other under load: false brinelling, no life"
    return [coded("races-stand", text.format(name)) for name in dict.fromkeys(stand)]


def _not_counted(train: Train, links: Sequence[Link]) -> list[CodedText]:
    """A warning of bearings beside helical teeth that hold a thrust or a tilting moment rigidly, or by a stiffness of
    its own beside their law, which is in no life.

    The thrusts of a planet in its two meshes cancel.
    """
    helical = {body for mesh in train.meshes if mesh.base_helix and not mesh.side for body in (mesh.a, mesh.b)}
    planets = {body.name for body in train.bodies if body.branch is not None}
    whose = {body.name: body.shaft_of or body.name for body in train.bodies}
    held = [
        link.name
        for link in links
        if (loaded := helical & {whose[link.first], whose.get(link.second or "")})
        and any(
            np.isinf(stiffness) or (stiffness and row >= force_rows(link))
            for row, stiffness in enumerate(link.stiffness[:5])
            if row >= (3 if loaded <= planets else 2)
        )
    ]
    if not held:
        return []
    text = "helical teeth push or tilt what z, rx or ry hold rigidly or beside the law; that load is in no life"
    return [coded("thrust-not-counted", f"{', '.join(held)}: {text}")]


def _columns(
    found: Mapping[tuple[str, str], State], links: list[Link], cases: list[str], shares: Array
) -> dict[str, tuple[Any, Any]]:
    """Variables of all bearings in all cases; shares : of the time (c,)."""
    each = ("bearing", "case")
    of_cases = [[found[link.name, case] for case in cases] for link in links]
    columns = state_columns(links, of_cases, each)
    with np.errstate(divide="ignore", invalid="ignore"):
        damage = {name: shares / columns[f"bearing_life_{name}"][1] for name in ("basic", "reference", "modified")}
        share = damage["reference"] / damage["reference"].sum(axis=1, keepdims=True)
        duty = {name: 1 / one.sum(axis=1) for name, one in damage.items()}
    return columns | {
        **{f"bearing_duty_life_{name}": ("bearing", one) for name, one in duty.items()},
        "damage_share": (each, np.nan_to_num(share)),
        "turning_race": (each, columns["turning_race"][1].astype(object)),
        "case_share": ("case", shares),
    }


# changes --------------------------------------------------------------------------------------------------------------

# One frozen list of changes, each one more run: twice the clearance, or 20 um more where that is larger, a tenth more
# rating, and every sun that is held in x and y floating.
_MORE_CLEARANCE, _MORE_RATING = 20e-6, 1.1


def changes_of(result: xr.Dataset) -> StudyAxis:
    """The changes of a result of `life`, as overrides of its model file."""
    train = load(json.loads(result.attrs["model"]))
    shortest = result["bearing"].values[largest(-result["bearing_duty_life_reference"].values)]
    link = next(one for one in rolling_links(train) if one.name == shortest)
    assert link.rolling is not None
    clearance = link.rolling.clearance + max(link.rolling.clearance, _MORE_CLEARANCE)
    rating = _MORE_RATING * dynamic_rating(link.rolling)
    suns = {body.name for body in train.bodies if body.kind == "sun"}
    held = [one.path for one in train.links if one.kind == "support" and one.first in suns and any(one.stiffness[:2])]
    tried: dict[str, dict[str, Any]] = {
        f"{link.path}.internal_clearance = {1e6 * clearance:.4g} um": {f"{link.path}.internal_clearance": clearance},
        f"{link.path}.rating = {1e-3 * rating:.4g} kN": {f"{link.path}.rating": rating},
        **{f"{path}.radial = 0": {f"{path}.radial": 0} for path in held},
    }
    label = np.array(list(tried), dtype=object), {"long_name": "change of the model file"}
    return StudyAxis(name="change", changes=tuple(tried.values()), labels={"change": label})


def with_changes(
    result: xr.Dataset, run: Callable[[Mapping[str, Any]], xr.Dataset], progress: Callable[[float], None] | None
) -> xr.Dataset:
    """A result of `life` with change_life [s] and change_reason of every change; run : the lives with one.

    The life is that of the bearing that then lives shortest, nan where there is none, with the reason.
    """
    axis = changes_of(result)
    found = outcomes(run, axis.changes, progress=progress)
    shortest = [one.then(lambda lives: float(lives["bearing_duty_life_reference"].min())) for one in found]
    columns = {
        "change_life": ("change", [np.nan if one.value is None else one.value for one in shortest]),
        "change_reason": ("change", [one.reason for one in shortest]),
    }
    made = dataset(columns, {"change": axis.labels["change"][0]}, verb="life")
    return result.assign_coords(made.coords).assign(made.data_vars)
