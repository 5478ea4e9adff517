"""Closed form of load sharing for n equal planets round a floating sun, with the interface of a tolerance map.

Gap e_i of each mesh is Gaussian; F = F0 - k (I - D D+) e with rows D = [1, cos psi_i, sin psi_i]: what the sun can turn
and shift away loads no mesh.  Contact is closed: forces below zero pull.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from epicyclic.statics.sample_loads import SampleLoads

__all__ = ["FloatingSun"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FloatingSun:
    """count : planets.  spread : sigma k / F0 of each gap.  together : whether all gaps are one drawing entry."""

    count: int
    spread: float | tuple[float, ...] = 1.0
    together: bool = True
    force: float = 1.0

    @property
    def correlations(self) -> tuple[Any, ...]:
        """None."""
        return ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """None."""
        return ()

    @property
    def entries(self) -> tuple[Any, ...]:
        """Drawing entries."""
        spreads = np.broadcast_to(self.spread, self.count).tolist()
        if self.together:
            return (SimpleNamespace(path="pin", own=SimpleNamespace(std=spreads[0]), common=None, unit="m"),)
        return tuple(
            SimpleNamespace(path=f"pin[{i}]", own=SimpleNamespace(std=one), common=None, unit="m")
            for i, one in enumerate(spreads)
        )

    @property
    def dimension_entry(self) -> NDArray[np.int64]:
        """Entry of every uniform."""
        return np.zeros(self.count, np.int64) if self.together else np.arange(self.count)

    @property
    def mesh(self) -> tuple[str, ...]:
        """Names of the meshes."""
        return tuple(f"sun-planet/{i + 1}" for i in range(self.count))

    @property
    def pair(self) -> tuple[str, ...]:
        """Names of the groups."""
        return ("sun-planet",)

    def forces(self, u: Array, *, scale: Array | None = None, torque: float = 1.0) -> Array:
        """Mesh forces of (S, n) uniforms, (S, n)."""
        angle = 2 * np.pi * np.arange(self.count) / self.count
        rows = np.stack([np.ones(self.count), np.cos(angle), np.sin(angle)], axis=1)
        project = np.eye(self.count) - rows @ np.linalg.pinv(rows)
        factor = np.ones(len(self.entries)) if scale is None else scale
        gap = ndtri(u) * np.broadcast_to(self.spread, self.count) * factor[self.dimension_entry] * self.force
        return np.asarray(self.force * torque - gap @ project)

    def evaluate(
        self, u: Array, *, scale: Array | None = None, torque: float = 1.0, method: str = "auto"
    ) -> SampleLoads:
        """Values of (S, n) uniforms."""
        force = self.forces(u, scale=scale, torque=torque)
        share = self.count * force / force.sum(axis=1, keepdims=True)
        load = np.stack([share, share], axis=1)
        return SampleLoads(
            k=load.max(axis=2, keepdims=True),
            load=load,
            least=force,
            open=np.asarray((force <= 0).any(axis=1)),
            failed=np.zeros(len(u), bool),
        )

    def overrides(self, u_row: Array, *, scale: Array | None = None) -> dict[str, object]:
        """Gaps of a sample."""
        return {f"pin[{i}]": float(one) for i, one in enumerate(ndtri(u_row))}
