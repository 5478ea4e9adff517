"""Lost motion of many trains of one drawing: tolerances drawn, each train locked and solved with flanks and play."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...engine.plan import sampling_plan, scramble_uniforms
from ...engine.points import attempt
from ...statics.record import excitation_of
from ...system.system import Array
from ..tolerance.tolerance_map import tolerance_map
from .hysteresis import both_senses, loop_at, rated_of

if TYPE_CHECKING:
    from ...train.train import Train
    from ...warning_codes import CodedText

_AT_ONCE = 512  # trains whose torques are solved at once
PROBABILITIES = (0.5, 0.95, 0.99)
"""Of the quantiles of a distribution."""


def sampled_lost_motion(
    train: Train, shares: Sequence[float], samples: int, seed: int
) -> tuple[Array, tuple[CodedText, ...]]:
    """Lost motion (S,) of S locked trains at the first share of the rated torque [rad], and warnings.

    nan of one without equilibrium.  At mean mesh stiffness; stiffnesses of links stay at their mean.

    train : locked, with the rated torque at the shaft.  shares : torques that are solved.
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
    torque = both_senses(abs(rated_of(system)) * np.unique([*shares, 1.0]))
    pieces = np.array_split(np.arange(len(u)), -(-len(u) // _AT_ONCE))

    def lost(piece: NDArray[np.int64]) -> Array:
        """Lost motion of a piece; a sample without equilibrium does not stop the others."""
        found = attempt(lambda at: loop_at(held, here.at(at), torque).lost_motion(shares[0]), piece)
        if found.value is not None or piece.size == 1:
            return np.full(1, np.nan) if found.value is None else found.value
        return np.concatenate([lost(half) for half in np.array_split(piece, 2)])

    return np.concatenate([lost(piece) for piece in pieces]), drawn.warnings
