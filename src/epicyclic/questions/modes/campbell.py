"""Campbell diagram: natural frequencies over speed, and the speeds at which mesh orders meet them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import Array, System
from .eigen import Whirl, classify_modes, eigen, repeated_roots, whirl

if TYPE_CHECKING:
    import xarray as xr

# Range about operation, per operating speed: a run-up passes everything above standstill, where mesh orders meet modes
# without end and without force; 130 % has the overspeed of usual acceptance tests (110 to 120 %) in it.
OPERATION = (0.05, 1.3)
# Mesh orders that count; as many as a sweep reports.  The stiffness of a mesh falls off faster than 1/order.
MESH_ORDERS = 12
# Share of the largest |mu| within which modes are repeated.
_REPEATED = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshCrossings:
    """Mesh orders that meet natural frequencies, speeds rising.

    mode : (c,) place of the first mode of the frequency, from 0.  count : (c,) modes of that frequency.
    tone : (c,) index into the tones.  order : (c,) mesh order.  relative_speed : (c,) per operating speed [1].
    """

    mode: NDArray[np.int64]
    count: NDArray[np.int64]
    tone: NDArray[np.int64]
    order: NDArray[np.int64]
    relative_speed: Array

    def chosen(self, kept: NDArray[np.bool_]) -> MeshCrossings:
        """Those of a mask (c,)."""
        return MeshCrossings(**{field.name: getattr(self, field.name)[kept] for field in fields(self)})


def mesh_crossings(
    frequency: Array,
    tones: Sequence[float],
    *,
    orders: int = MESH_ORDERS,
    low: float = OPERATION[0],
    high: float = OPERATION[1],
) -> MeshCrossings:
    """Speeds f_n / (h f_m) at which order h of a mesh frequency f_m meets a natural frequency f_n, from low to high.

    Derived here.

    Parameters
    ----------
    frequency : (n,) natural frequencies [Hz], rising; rigid ones 0, which no order meets.  Repeated ones count once.
    tones : (D,) mesh frequencies at the operating speed [Hz].  orders : highest mesh order.
    low, high : range of the speed per operating speed [1].
    """
    runs = [run for run in repeated_roots(frequency**2) if frequency[run.start] > 0]
    first = np.array([run.start for run in runs], dtype=np.int64)
    count = np.array([run.stop - run.start for run in runs], dtype=np.int64)
    order = np.arange(1, orders + 1)
    speed = frequency[first][:, None, None] / (np.asarray(tones, dtype=float)[:, None] * order)
    mode, tone, column = np.nonzero((low <= speed) & (speed <= high))
    met = speed[mode, tone, column]
    rank = np.lexsort((order[column], tone, mode, met))
    return MeshCrossings(
        mode=first[mode][rank],
        count=count[mode][rank],
        tone=tone[rank].astype(np.int64),
        order=order[column][rank],
        relative_speed=met[rank],
    )


def tones_of_meshes(system: System) -> dict[Fraction, list[str]]:
    """Mesh frequencies above zero at the operating speed [Hz], that of the first mesh first: stages that have each."""
    stages_of: dict[Fraction, dict[str, None]] = {}
    for stage, tone in zip(system.meshes.stage, system.meshes.tone.tolist(), strict=True):
        if system.tones and system.tones[tone] > 0:
            stages_of.setdefault(system.tones[tone], {})[stage] = None
    return {tone: list(stages) for tone, stages in stages_of.items()}


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
    from ...results.dataset import dataset

    speeds = np.atleast_1d(np.asarray(relative_speeds, dtype=float))
    if not speeds.size or not np.all(np.isfinite(speeds)):
        raise ModelError("speeds must be finite numbers", given=relative_speeds, path="relative_speeds")
    system = linear(system)
    modes = eigen(system)
    tracked: list[Whirl] = []
    alike = np.zeros(len(modes.omega_squared), dtype=int)
    for i, speed in enumerate(speeds):
        turning = whirl(system, relative_speed=float(speed), damped=damped, modes=modes)
        tracked.append(_tracked(tracked[-1], turning, system, alike) if tracked else turning)
        alike = _repeated(tracked[-1].mu, alike)
        if progress is not None:
            progress((i + 1) / speeds.size)
    last = tracked[-1]
    rank = np.lexsort((np.abs(last.mu.real), last.mu.imag))
    kinds = np.empty(len(rank), dtype=object)
    kinds[rank] = classify_modes(system, last.mu[rank], last.vectors[:, rank]).kind
    stages = dict(zip(system.meshes.stage, system.meshes.tone, strict=True))
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


def _tracked(before: Whirl, after: Whirl, system: System, alike: np.ndarray) -> Whirl:
    """Modes of `after` in the order of `before`: the assignment of largest M-weighted modal correlation, (n, n) [1].

    alike : (n,) labels of modes of `before` that were repeated at every speed so far.  The base of their eigenspace is
    arbitrary, so correlation does not tell which of them leads to which: of the branches the lower one is the first.
    """
    from scipy.optimize import linear_sum_assignment  # a third of a second that no sweep needs

    correlation = np.abs(before.vectors.conj().T @ system.M @ after.vectors) ** 2
    _, order = linear_sum_assignment(correlation, maximize=True)
    for label in np.unique(alike):
        rows = np.flatnonzero(alike == label)
        order[rows] = order[rows][np.argsort(after.mu.imag[order[rows]], kind="stable")]
    return Whirl(mu=after.mu[order], vectors=after.vectors[:, order])


def _repeated(mu: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """Labels (n,) of modes that are alike so far and whose mu (n,) [rad/s] are equal but for rounding."""
    rank = np.lexsort((mu.imag, alike))
    apart = np.abs(np.diff(mu[rank])) > _REPEATED * np.abs(mu).max()
    labels = np.zeros_like(alike)
    labels[rank[1:]] = np.cumsum(apart | (np.diff(alike[rank]) != 0))
    return labels
