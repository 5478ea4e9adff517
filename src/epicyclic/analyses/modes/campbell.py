"""Natural frequencies over speed: the Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import System
from .classification import classify_modes
from .eigen import Whirl, eigen, whirl

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["campbell"]

# Share of the largest |mu| within which modes are repeated.
_REPEATED = 1e-9


def campbell(
    system: System,
    *,
    relative_speeds: ArrayLike,
    damped: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Whirl frequencies at each speed, modes tracked over speed by modal correlation [allemang1982].

    Parameters
    ----------
    relative_speeds : (s,) speeds per operating speed [1], in the order of tracking.
    damped : with damping.  progress : called with the share done, 0..1.

    Returns
    -------
    Dataset with ``whirl_frequency`` (relative_speed, mode) [Hz], ``mode_kind`` (mode) at the last speed and
    ``mesh_frequency`` (stage, relative_speed) [Hz].

    Raises
    ------
    ModelError : no speeds, a speed that is not finite, or what `whirl` raises.
    """
    speeds = np.atleast_1d(np.asarray(relative_speeds, dtype=float))
    if not speeds.size or not np.all(np.isfinite(speeds)):
        raise ModelError("speeds must be finite numbers", given=relative_speeds, path="relative_speeds")
    system = linear(system)
    modes = eigen(system)
    tracked: list[Whirl] = []
    alike = np.zeros(0, dtype=int)
    for i, speed in enumerate(speeds):
        here = whirl(system, relative_speed=float(speed), damped=damped, modes=modes)
        tracked.append(_tracked(tracked[-1], here, system, alike) if tracked else here)
        alike = _repeated(tracked[-1].mu, alike if i else np.zeros(here.mu.size, dtype=int))
        if progress is not None:
            progress((i + 1) / speeds.size)
    return _dataset(system, speeds, tracked, damped)


def _tracked(before: Whirl, here: Whirl, system: System, alike: np.ndarray) -> Whirl:
    """Modes of `here` in the order of `before`: the assignment of largest M-weighted modal correlation, (n, n) [1].

    alike : (n,) labels of modes of `before` that were repeated at every speed so far.  The base of their eigenspace is
    arbitrary, so correlation does not tell which of them leads to which: of the branches the lower one is the first.
    """
    correlation = np.abs(before.vectors.conj().T @ system.M @ here.vectors) ** 2
    _, order = scipy.optimize.linear_sum_assignment(correlation, maximize=True)
    for label in np.unique(alike):
        rows = np.flatnonzero(alike == label)
        order[rows] = order[rows][np.argsort(here.mu.imag[order[rows]], kind="stable")]
    return Whirl(mu=here.mu[order], vectors=here.vectors[:, order])


def _repeated(mu: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """Labels (n,) of modes that are alike so far and whose mu (n,) [rad/s] are equal here but for rounding."""
    rank = np.lexsort((mu.imag, alike))
    apart = np.abs(np.diff(mu[rank])) > _REPEATED * np.abs(mu).max()
    found = np.zeros_like(alike)
    found[rank[1:]] = np.cumsum(apart | (np.diff(alike[rank]) != 0))
    return found


def _dataset(system: System, speeds: np.ndarray, tracked: list[Whirl], damped: bool) -> xr.Dataset:
    """The labelled result; mode kinds are those of the last speed.  speeds : (s,) per operating speed [1]."""
    from ...results.dataset import dataset

    last = tracked[-1]
    rank = np.lexsort((np.abs(last.mu.real), last.mu.imag))
    kinds = np.empty(len(rank), dtype=object)
    kinds[rank] = classify_modes(system, last.mu[rank], last.vectors[:, rank]).kind
    stages = {stage: tone for stage, tone in zip(system.meshes.stage, system.meshes.tone, strict=True)}
    tones = np.array([float(system.tones[tone]) if system.tones else np.nan for tone in stages.values()])
    return dataset(
        {
            "whirl_frequency": (("relative_speed", "mode"), np.array([w.mu.imag for w in tracked]) / (2 * np.pi)),
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
