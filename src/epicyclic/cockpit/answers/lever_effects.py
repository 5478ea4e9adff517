"""What a number of the model moves: load sharing and natural frequencies, before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...questions.modes.basis import mean_modes
from ...results.ties import largest
from ...statics.sample_loads import mean_loads
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...train.train import Train
from .answer import per_cent

__all__ = ["Effect", "Figures", "effect_of", "figures_of"]

# Natural frequencies that are compared: the lowest, which operation meets.
_MODES = 12
# A change below this is none [1].
_NONE = 5e-4
# Weight of a relative change of a frequency beside one of K_gamma: sharing is what the page is opened for.
_FREQUENCY = 0.3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Figures:
    """Figures of a train.

    k_gamma, k_turning : largest mean-load coefficient, and while turning [1]; nan without load.
    frequency : (n,) lowest elastic natural frequencies [Hz].
    """

    k_gamma: float
    k_turning: float
    frequency: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What a change does, in words, and its size for ranking [1]."""

    words: str
    size: float


def figures_of(train: Train) -> Figures:
    """Figures of a train; what cannot be computed is nan or empty.

    Raises
    ------
    ModelError : the train cannot be assembled.
    """
    system = assemble(train)
    try:
        loads = mean_loads(system)
        k = [_largest(np.asarray(one)) for one in loads[:2]]
    except (ModelError, ConvergenceError):
        k = [float("nan"), float("nan")]
    try:
        squared, _ = mean_modes(linear(system))
        frequency = np.sqrt(squared[squared > 0])[:_MODES] / (2 * np.pi)
    except (ModelError, np.linalg.LinAlgError):
        frequency = np.zeros(0)
    return Figures(
        k_gamma=k[0],
        k_turning=k[1],
        frequency=frequency,
    )


def _largest(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def effect_of(now: Figures, then: Figures, where: str) -> Effect:
    """What a change does; where : the changed value in words."""
    words, size = [], 0.0
    for name, before, after in (
        ("K_gamma", now.k_gamma, then.k_gamma),
        ("K_gamma while turning", now.k_turning, then.k_turning),
    ):
        change = after - before
        if np.isfinite(change) and abs(change) > _NONE:
            words.append(f"{name} {before:.3f} → {after:.3f}")
            size = max(size, abs(change))
    count = min(len(now.frequency), len(then.frequency))
    if count:
        moved = then.frequency[:count] / now.frequency[:count] - 1
        most = largest(np.abs(moved))
        if abs(moved[most]) > _NONE:
            words.append(f"moves a mode of {now.frequency[most]:.0f} Hz by {per_cent(float(moved[most]))}")
            size = max(size, _FREQUENCY * abs(float(moved[most])))
    return Effect(words=f"{where}: {'; '.join(words[:2])}" if words else "", size=size)
