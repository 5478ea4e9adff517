"""What sampling, statistics, shares and curves ask of a map from uniforms to load factors."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from ...statics.sample_loads import ContactMethod
from ...system.system import Array
from ...warning_codes import CodedText

if TYPE_CHECKING:
    from ...document.correlation import Correlations
    from ...document.tolerances import Tolerance

__all__ = ["SampleMap", "SampledValues"]


class SampledValues(Protocol):
    """Values of S samples: D definitions (`MEAN_LOADS`), g groups (pair and side), w meshes; nan of failed ones."""

    @property
    def k(self) -> Array:
        """Load factor of every group, (S, D, g) [1]."""

    @property
    def load(self) -> Array:
        """N F_i / sum F of every mesh, (S, D, w) [1]."""

    @property
    def least(self) -> Array:
        """Least force of every mesh, (S, w) [N]."""

    @property
    def open(self) -> NDArray[np.bool_]:
        """Whether contact opens or a link plays, (S,)."""

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Whether there is no solution, (S,)."""


class SampleMap(Protocol):
    """A map from uniforms to load factors: E drawing entries, d uniforms."""

    @property
    def entries(self) -> tuple[Tolerance, ...]:
        """Drawing entries, (E,)."""

    @property
    def dimension_entry(self) -> NDArray[np.int64]:
        """Entry of every uniform, (d,)."""

    @property
    def mesh(self) -> tuple[str, ...]:
        """Names of the whole meshes, (w,)."""

    @property
    def pair(self) -> tuple[str, ...]:
        """Names of the groups, pair and side, (g,)."""

    @property
    def correlations(self) -> tuple[Correlations, ...]:
        """Groups of entries whose draws are correlated."""

    @property
    def lawful(self) -> bool:
        """Whether links follow laws, each sample of which takes an equilibrium at every phase."""

    @property
    def unmoved(self) -> Collection[str]:
        """Paths of entries that move no column; `warnings` say why."""

    @property
    def warnings(self) -> tuple[CodedText, ...]:
        """What the user should know of the map."""

    def evaluate(
        self,
        u: Array,
        *,
        scale: Array | None = None,
        torque: float = 1.0,
        method: ContactMethod = "auto",
        dense: bool = False,
    ) -> SampledValues:
        """Values of (S, d) uniforms; scale : (E,) factors on the spreads.  torque : factor on the load.

        dense : open contact at many slow phases.
        """

    def overrides(self, u_row: Array, *, scale: Array | None = None) -> Mapping[str, object]:
        """What makes a model file that sample."""
