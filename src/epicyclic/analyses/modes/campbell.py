"""Natural frequencies over speed: the Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...system.system import System
from ..static.tangent import linearised
from .eigen import Whirl, eigen, whirl
from .kinds import sort_modes

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["campbell"]


def campbell(
    system: System,
    *,
    relative_speeds: ArrayLike,
    damped: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Natural frequencies at each speed, each mode followed from one speed to the next by the likeness of its shapes.

    Parameters
    ----------
    relative_speeds : (s,) speeds per operating speed [1], in the order to follow.
    damped : with damping.  progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : no speeds, a speed that is not finite, or what `whirl` raises.
    """
    speeds = np.atleast_1d(np.asarray(relative_speeds, dtype=float))
    if not speeds.size or not np.all(np.isfinite(speeds)):
        raise ModelError("speeds must be finite numbers", given=relative_speeds, path="relative_speeds")
    system = linearised(system)
    modes = eigen(system)
    followed: list[Whirl] = []
    for i, speed in enumerate(speeds):
        here = whirl(system, relative_speed=float(speed), damped=damped, modes=modes)
        followed.append(_follow(followed[-1], here, system) if followed else here)
        if progress is not None:
            progress((i + 1) / speeds.size)
    return _dataset(system, speeds, followed, damped)


def _follow(before: Whirl, here: Whirl, system: System) -> Whirl:
    """The modes of `here` in the order of those of `before` they are most alike (M-weighted correlation)."""
    likeness = np.abs(before.vectors.conj().T @ system.M @ here.vectors) ** 2
    _, order = scipy.optimize.linear_sum_assignment(likeness, maximize=True)
    return Whirl(mu=here.mu[order], vectors=here.vectors[:, order])


def _dataset(system: System, speeds: np.ndarray, followed: list[Whirl], damped: bool) -> xr.Dataset:
    from ...results.dataset import dataset

    last = followed[-1]
    rank = np.lexsort((np.abs(last.mu.real), last.mu.imag))
    kinds = np.empty(len(rank), dtype=object)
    kinds[rank] = sort_modes(system, last.mu[rank], last.vectors[:, rank]).kind
    stages = {stage: tone for stage, tone in zip(system.meshes.stage, system.meshes.tone, strict=True)}
    tones = np.array([float(system.tones[tone]) if system.tones else np.nan for tone in stages.values()])
    return dataset(
        {
            "whirl_frequency": (("relative_speed", "mode"), np.array([w.mu.imag for w in followed]) / (2 * np.pi)),
            "mode_kind": ("mode", kinds),
            "mesh_frequency": (("stage", "relative_speed"), np.outer(tones, np.abs(speeds))),
        },
        {
            "relative_speed": speeds,
            "mode": np.arange(1, len(rank) + 1),
            "stage": np.array(list(stages), dtype=object),
        },
        verb="campbell",
        options={"damped": damped},
        provenance=system.provenance,
        warnings=system.warnings,
    )
