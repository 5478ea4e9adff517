"""Lost motion of many trains of one drawing: tolerances drawn, each train locked and solved with flanks and play."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...engine.plan import sampling_plan, scramble_uniforms
from ...statics.record import excitation_of
from ..tolerance.tolerance_map import tolerance_map
from .hysteresis import Loop, loop_of_samples, shaft_load

if TYPE_CHECKING:
    from ...train.train import Train
    from ...warning_codes import CodedText

PROBABILITIES = (0.5, 0.95, 0.99)
"""Of the quantiles of a distribution."""


def sampled_loops(
    train: Train, shares: Sequence[float], samples: int, seed: int
) -> tuple[Loop, tuple[CodedText, ...]] | None:
    """Torque over angle of S locked trains at mean mesh stiffness, and warnings; None of a train without tolerances.

    Stiffnesses of links stay at their mean.

    train : locked, with the rated torque at the shaft.  samples : at least so many, a power of two.

    Raises
    ------
    ModelError : a tolerance that is refused.  ConvergenceError : no equilibrium of a sample.
    """
    if not train.document.get("tolerance"):
        return None
    drawn = tolerance_map(train, laws=True)
    assert drawn.laws is not None
    held, plan = drawn.laws.held, sampling_plan(samples, seed=seed)
    system, m = held.system, len(held.system.meshes.name)
    d = drawn.dimension_entry.size
    u = np.concatenate([scramble_uniforms(plan, scramble, d) for scramble in range(plan.scrambles)])
    factors, varied = drawn.factors(u, np.ones(len(drawn.entries)).tolist())
    values, _ = drawn.laws.excitation.values(factors, 0.0)
    values[:, -len(system.force) :] += system.force - shaft_load(system)
    stiffness = np.tile(system.meshes.stiffness, (len(u), 1))
    of_mesh = drawn.rows < m
    stiffness[:, drawn.rows[of_mesh]] = varied[:, of_mesh]
    tones = max(1, len(system.tones))
    base = excitation_of(system, values, np.zeros((len(u), tones)), stiffness=stiffness)
    return loop_of_samples(held, base, shares), drawn.warnings
