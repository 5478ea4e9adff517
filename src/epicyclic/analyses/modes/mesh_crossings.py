"""Where mesh orders meet natural frequencies as the speed changes: the resonances of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, System
from .classification import repeated_roots

__all__ = ["MESH_ORDERS", "OPERATION", "MeshCrossings", "mesh_crossings", "tones_of_meshes"]

# Range about operation, per operating speed: a run-up passes everything above standstill, where mesh orders meet modes
# without end and without force; 130 % has the overspeed of usual acceptance tests (110 to 120 %) in it.
OPERATION = (0.05, 1.3)
# Mesh orders that count; as many as a sweep reports.  The stiffness of a mesh falls off faster than 1/order.
MESH_ORDERS = 12


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
    mode, tone, place = np.nonzero((low <= speed) & (speed <= high))
    met = speed[mode, tone, place]
    rank = np.lexsort((order[place], tone, mode, met))
    return MeshCrossings(
        mode=first[mode][rank],
        count=count[mode][rank],
        tone=tone[rank].astype(np.int64),
        order=order[place][rank],
        relative_speed=met[rank],
    )


def tones_of_meshes(system: System) -> dict[Fraction, list[str]]:
    """Mesh frequencies above zero at the operating speed [Hz], that of the first mesh first: stages that have each."""
    found: dict[Fraction, dict[str, None]] = {}
    for stage, tone in zip(system.meshes.stage, system.meshes.tone.tolist(), strict=True):
        if system.tones and system.tones[tone] > 0:
            found.setdefault(system.tones[tone], {})[stage] = None
    return {tone: list(stages) for tone, stages in found.items()}
