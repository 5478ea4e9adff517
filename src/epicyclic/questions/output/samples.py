"""Lost motion and kinematic error of many trains of one drawing, tolerances drawn.

Locked trains are solved together, with flanks and play; trains that turn one by one, so that they are few.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...engine.plan import sampling_plan, scramble_uniforms
from ...engine.points import attempt
from ...engine.workers import each
from ...statics.record import excitation_of
from ...system.system import Array
from ...train.resolution import load
from ..tolerance.tolerance_map import tolerance_map
from .hysteresis import RANGE, both_senses, loop_at, rated_of
from .kinematic_error import error_range

if TYPE_CHECKING:
    from ...train.train import Train
    from ...warning_codes import CodedText
    from .locked_train import OutputShaft

_AT_ONCE = 512  # trains whose torques are solved at once
_TURNING, _INSTANTS = 64, 2**11  # trains that turn, and instants of each unless a turn has more
PROBABILITIES = (0.5, 0.95, 0.99)
"""Of the quantiles of a distribution."""


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
    u = np.concatenate([scramble_uniforms(plan, scramble, d) for scramble in range(plan.scrambles)])
    factors, varied = drawn.factors(u, np.ones(len(drawn.entries)).tolist())
    values, _ = drawn.laws.excitation.values(factors)
    stiffness = np.tile(system.meshes.stiffness, (len(u), 1))
    of_mesh = drawn.rows < stiffness.shape[1]
    stiffness[:, drawn.rows[of_mesh]] = varied[:, of_mesh]
    here = excitation_of(system, values, np.zeros((len(u), max(1, len(system.tones)))), stiffness=stiffness)
    torque, sense = both_senses(abs(rated_of(system)) * np.unique([*shares, *RANGE])), np.sign(rated_of(system))
    pieces = np.array_split(np.arange(len(u)), -(-len(u) // _AT_ONCE))

    def lost(piece: NDArray[np.int64]) -> Array:
        """Numbers of a piece; a sample without equilibrium does not stop the others."""
        found = attempt(lambda at: loop_at(held, here.at(at), torque), piece)
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
    d = drawn.dimension_entry.size
    u = np.concatenate([scramble_uniforms(plan, scramble, d) for scramble in range(plan.scrambles)])[:_TURNING]
    return np.array(each(partial(_error_of_one, train, shaft, share), [drawn.overrides(row) for row in u]))


def _error_of_one(train: Train, shaft: OutputShaft, share: float, overrides: dict[str, object]) -> float:
    """Range of the kinematic error of the train that overrides make [rad]."""
    made = load(dict(train.document), overrides=overrides)
    found = attempt(lambda one: error_range(one, shaft, share, _INSTANTS), made)
    return np.nan if found.value is None else found.value
