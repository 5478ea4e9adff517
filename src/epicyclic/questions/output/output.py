"""A gearbox at one of its shafts, the others locked: stiffness over torque, hysteresis, lost motion, reflected inertia.

Stiffnesses and lost motion are read from the middle line of the loop of `hysteresis`: the tangent dT/dphi at every
torque; between 50 and 100 % of the rated torque the secant, and the slope of least squares.  Lost motion is the angle
at +share less that at -share of the rated torque, the backlash the same at a share so small that hardly anything
yields.

Of a drawing with tolerances the same of many trains: locked ones are solved together, with flanks and play; trains that
turn one by one, so that they are few.

Every shaft of a train that turns feels the whole: the kinetic energy of the rigid motion of the operation, E = sum (J
w^2 + m r_c^2 w_c^2) / 2 with the speeds of Willis, is that of the inertia 2 E / w^2 on a shaft that turns with w.
Derived here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import all_uniforms, sampling_plan
from ...engine.points import attempt
from ...engine.workers import each
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics.record import excitation_of
from ...statics.static import zero_warnings
from ...statics.transmission_error import Columns
from ...system.assembly import assemble, train_provenance
from ...system.system import Array
from ...train.resolution import load
from ...train.train import Train, stage_axis
from ...warning_codes import CodedText, coded
from ..tolerance.tolerance_map import tolerance_map
from . import OutputOptions
from .hysteresis import RANGE, Loop, both_senses, hysteresis, loop_at, rated_of, relative_torques
from .kinematic_error import error_range, kinematic_error
from .locked_train import OutputShaft, locked_train, output_shaft, ports

_AT_ONCE = 512  # trains whose torques are solved at once
_TURNING, _INSTANTS = 64, 2**11  # trains that turn, and instants of each unless a turn has more
PROBABILITIES = (0.5, 0.95, 0.99)
"""Of the quantiles of a distribution."""
STATISTICS = ("mean", "least", "most")
"""Over the places of the mesh cycle at which a train may be locked."""


def output(train: Train, options: OutputOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """What a user of a gearbox measures at one of its shafts.

    Friction of the teeth is not in the loop.

    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : angle_rising, angle_falling (mesh_phase, shaft_torque) [rad]; shaft_tangent_stiffness (over_phases,
        shaft_torque), shaft_secant_stiffness, shaft_fitted_stiffness (over_phases) [N m/rad]; lost_motion,
        shaft_backlash (over_phases) [rad], nan where a mesh has no backlash; hysteresis_energy (over_phases) [J];
        rated_torque [N m] and shaft_play [rad] (); reflected_inertia [kg m^2] and starting_torque [N m] (port).  Of a
        drawing with tolerances NAME_mean () and NAME_quantile (probability) of lost_motion, shaft_backlash,
        shaft_secant_stiffness and the range of kinematic_error, this of 64 trains over a turn or some; of a train that
        turns kinematic_error (shaft_turn), kinematic_error_peak_to_peak (), kinematic_error_order (shaft_order) [rad].
        Attributes ``shaft``, ``locked_shafts``.

    Raises
    ------
    ModelError : as of `output_shaft`; a load that nothing holds; shares of which that of the backlash is the larger.
    ConvergenceError : no equilibrium.
    """
    shares = (options.share, options.backlash_share)
    if options.backlash_share >= options.share:
        allowed = f"below share, {options.share:g}"
        raise ModelError("out of range", path="backlash_share", given=options.backlash_share, allowed=allowed)
    shaft = output_shaft(train, options.shaft, options.held, options.rated)
    locked = locked_train(train, shaft)
    system, shafts = assemble(locked), list(dict.fromkeys([shaft.name, *ports(train)]))
    endless = bool(np.isinf(system.meshes.backlash).any())
    reverse = assemble(locked_train(train, replace(shaft, torque=-shaft.torque))) if endless else None
    tell = progress or (lambda _: None)
    loop = hysteresis(system, reverse, options.phases, relative_torques(options.points, shares))
    columns = _loop_columns(loop, options, np.sign(shaft.torque))
    warnings = [*system.warnings, *zero_warnings(system)]
    tell(0.3)
    turning = attempt(lambda share: kinematic_error(train, shaft, share), options.share)
    turned, cut_short = turning.value or ({}, [])
    drawn = dict[str, Array]()
    if locked.document.get("tolerance") and not endless:
        values, said = sampled_loops(locked, shares, options.samples, options.seed)
        names = ("lost_motion", "shaft_backlash", "shaft_secant_stiffness")
        drawn, warnings = dict(zip(names, values.T, strict=True)), [*warnings, *said]
    if locked.document.get("tolerance") and turned:
        drawn["kinematic_error"] = sampled_kinematic_error(train, shaft, options.share, options.seed)
    tell(0.95)
    for name, values in drawn.items():
        columns[f"{name}_mean"] = ((), np.nanmean(values))
        columns[f"{name}_quantile"] = ("probability", np.nanquantile(values, PROBABILITIES))
        if failed := int(np.isnan(values).sum()):
            text = f"{failed} of {values.size} trains of the tolerances have no equilibrium, and count nowhere"
            warnings.append(coded("points-failed", text))
    start = attempt(lambda friction: starting_torque(train, shafts, friction), options.friction)
    columns |= turned | {
        "rated_torque": ((), abs(shaft.torque)),
        "reflected_inertia": ("port", reflected_inertia(train, shafts)),
        "starting_torque": ("port", np.full(len(shafts), np.nan) if start.value is None else start.value),
    }
    return dataset(
        columns,
        {"over_phases": list(STATISTICS), "port": shafts, "probability": list(PROBABILITIES)},
        verb="output",
        options=asdict(options),
        provenance={
            **train_provenance(train),
            "shaft": shaft.name,
            "locked_shafts": ", ".join(shaft.held),
            "rated_by": shaft.rated_by,
            "rated_sense": "negative" if shaft.torque < 0 else "positive",
            "starting_torque_reason": start.reason,
            "kinematic_error_reason": turning.reason,
        },
        warnings=list(dict.fromkeys([*warnings, *cut_short])),
    )


def _loop_columns(loop: Loop, options: OutputOptions, sense: float) -> Columns:
    """Columns of torque over angle; sense : of the rated torque."""
    secant, fitted = loop.stiffness(*RANGE, sense)
    each = {
        "shaft_secant_stiffness": secant,
        "shaft_fitted_stiffness": fitted,
        "lost_motion": loop.lost_motion(options.share),
        "shaft_backlash": loop.lost_motion(options.backlash_share),
        "hysteresis_energy": loop.energy,
    }
    curve = ("mesh_phase", "shaft_torque")
    return {
        "shaft_torque": ("shaft_torque", loop.torque),
        "mesh_phase": ("mesh_phase", np.arange(options.phases) / options.phases),
        "angle_rising": (curve, loop.rising),
        "angle_falling": (curve, loop.falling),
        "shaft_tangent_stiffness": (("over_phases", "shaft_torque"), over_phases(loop.tangent())),
        **{name: ("over_phases", over_phases(values)) for name, values in each.items()},
        "shaft_play": ((), loop.play),
    }


def over_phases(values: Array) -> Array:
    """Mean, least and most (3, ...) of values (P, ...)."""
    return np.stack([values.mean(axis=0), values.min(axis=0), values.max(axis=0)])


# --- many trains of one drawing ---------------------------------------------------------------------------------------


def sampled_loops(
    train: Train, shares: Sequence[float], samples: int, seed: int
) -> tuple[Array, tuple[CodedText, ...]]:
    """Lost motion at shares of the rated torque [rad] and secant stiffness [N m/rad] of S locked trains, (S, k + 1).

    With them warnings.  nan of one without equilibrium.  At mean mesh stiffness; stiffnesses of links stay at their
    mean.

    train : locked, with the rated torque at the shaft.  shares : (k,).
    samples : at least so many, a power of two.

    Raises
    ------
    ModelError : a tolerance that is refused.
    """
    drawn = tolerance_map(train, laws=True)
    assert drawn.laws is not None
    held, plan = drawn.laws.held, sampling_plan(samples, seed=seed)
    system, d = held.system, drawn.dimension_entry.size
    u = all_uniforms(plan, d)
    factors, varied = drawn.factors(u, np.ones(len(drawn.entries)).tolist())
    values, _ = drawn.laws.excitation.values(factors)
    stiffness = np.tile(system.meshes.stiffness, (len(u), 1))
    of_mesh = drawn.rows < stiffness.shape[1]
    stiffness[:, drawn.rows[of_mesh]] = varied[:, of_mesh]
    here = excitation_of(system, values, np.zeros((len(u), max(1, len(system.tones)))), stiffness=stiffness)
    torque, sense = both_senses(abs(rated_of(system)) * np.unique([*shares, *RANGE])), np.sign(rated_of(system))
    own = drawn.own_trains(u, drawn.laws, np.ones(len(drawn.entries)).tolist())
    pieces = np.array_split(np.arange(len(u)), len(u) if own else -(-len(u) // _AT_ONCE))

    def loops(at: NDArray[np.int64]) -> Loop:
        """Loops of samples; of one by itself where each has laws of its own."""
        train = own(int(at[0])) if own else held
        if train is None:
            raise ModelError("clearances that are drawn are not allowed", path="tolerance")
        return loop_at(train, here.at(at), torque)

    def lost(piece: NDArray[np.int64]) -> Array:
        """Numbers of a piece; a sample without equilibrium does not stop the others."""
        found = attempt(loops, piece)
        if found.value is not None or piece.size == 1:
            if (loop := found.value) is None:
                return np.full((1, len(shares) + 1), np.nan)
            return np.array([*(loop.lost_motion(share) for share in shares), loop.stiffness(*RANGE, sense)[0]]).T
        return np.concatenate([lost(half) for half in np.array_split(piece, 2)])

    return np.concatenate([lost(piece) for piece in pieces]), drawn.warnings


def sampled_kinematic_error(train: Train, shaft: OutputShaft, share: float, seed: int) -> Array:
    """Largest range within a turn of the kinematic error of 64 trains (S,) [rad]; nan of one without equilibrium.

    Raises
    ------
    ModelError : a tolerance that is refused.
    """
    drawn, plan = tolerance_map(train), sampling_plan(_TURNING, seed=seed)
    u = all_uniforms(plan, drawn.dimension_entry.size)[:_TURNING]
    return np.array(each(partial(_error_of_one, train, shaft, share), [drawn.overrides(row) for row in u]))


def _error_of_one(train: Train, shaft: OutputShaft, share: float, overrides: dict[str, object]) -> float:
    """Range of the kinematic error of the train that overrides make [rad]."""
    made = load(dict(train.document), overrides=overrides)
    found = attempt(lambda one: error_range(one, shaft, share, _INSTANTS), made)
    return np.nan if found.value is None else found.value


# --- shafts of a train that turns -------------------------------------------------------------------------------------


def reflected_inertia(train: Train, shafts: Sequence[str]) -> Array:
    """Inertia of the whole train on each shaft (s,) [kg m^2], nan of one that stands, and where the motion is open.

    The motion is that of the operation; without speeds that of a train with one freedom.
    """
    speed = _speeds(train)
    twice = math.fsum(_inertia_times_square(train, speed)) if speed else math.nan
    return np.array([twice / speed[name] ** 2 if speed.get(name) else math.nan for name in shafts])


def _speeds(train: Train) -> Mapping[str, float]:
    """Speed of every member, of any size; none where nothing turns, or several freedoms have no speeds."""
    kinematics = train.kinematics
    if kinematics.speed is not None and any(kinematics.speed.values()):
        return {name: float(value) for name, value in kinematics.speed.items()}
    if len(kinematics.freedoms) != 1:
        return {}
    return {name: float(row[kinematics.freedoms[0]]) for name, row in kinematics.ratio.items()}


def _inertia_times_square(train: Train, speed: Mapping[str, float]) -> Iterator[float]:
    """Twice the kinetic energy of every body, speeds in their unit."""
    member = {body.name: body.member for body in train.bodies}
    for body in train.bodies:
        if spin := speed[body.member]:
            yield body.inertia * spin**2
        if body.carried_by is not None and (orbit := speed[member[body.carried_by]]):
            radius = math.dist(body.centre, stage_axis(body.frame, train.bodies))
            yield body.mass * (radius * orbit) ** 2


def starting_torque(train: Train, shafts: Sequence[str], friction: float | None) -> Array:
    """Torque at each shaft (s,) that overcomes the friction of the teeth at the operation [N m]; nan of one at rest.

    It is the loss that `efficiency` finds per speed of the shaft.  friction : coefficient.

    Raises
    ------
    ModelError : no friction; a train of which `efficiency` has no loss.
    """
    if friction is None:
        raise ModelError("no friction of the teeth is given")
    from ..flanks import EfficiencyOptions
    from ..flanks.efficiency import efficiency

    loss = float(efficiency(train, EfficiencyOptions(friction=friction)).power_loss)
    speed = np.array([abs(float((train.kinematics.speed or {})[name])) * math.tau / 60 for name in shafts])
    return np.asarray(np.divide(loss, speed, where=speed > 0, out=np.full(len(shafts), math.nan)))
