"""A gearbox at one of its shafts, the others locked: stiffness over torque, hysteresis, lost motion, reflected inertia.

Stiffnesses and lost motion are read from the middle line of the loop of `hysteresis`: the tangent dT/dphi at every
torque; between 50 and 100 % of the rated torque the secant, and the slope of least squares.  Lost motion is the angle
at +share less that at -share of the rated torque, the backlash the same at a share so small that hardly anything
yields.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from ...engine.points import attempt
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics.static import zero_warnings
from ...statics.transmission_error import Columns
from ...system.assembly import assemble, train_provenance
from ...system.system import Array
from ...warning_codes import coded
from . import OutputOptions
from .hysteresis import RANGE, Loop, hysteresis, relative_torques
from .kinematic_error import kinematic_error
from .locked_train import locked_train, output_shaft, ports
from .samples import PROBABILITIES, sampled_kinematic_error, sampled_loops
from .shafts import reflected_inertia, starting_torque

if TYPE_CHECKING:
    import xarray as xr

    from ...train.train import Train

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
