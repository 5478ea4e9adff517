"""Radial laws of links: play, rolling elements and splines, force = f(rho) delta / rho with rho = |delta|.

    f(rho) = min(k rho, F_m) + C <rho - S_2>^n        S_1 = F_m / k,  S_2 = S_1 + clearance

Without friction (F_m = 0) that is play and then a power law; with friction it is a spline [dong2019, eq. 27]: elastic
up to the slip start S_1, sliding at F_m over the clearance, elastic again.  S_1 is derived: any other value makes the
force discontinuous.  C follows from k, the tangent stiffness at the given load F: k = n C^(1/n) F^((n - 1)/n).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Law", "PowerProfile", "Profile", "RadialLaw"]

Array = NDArray[np.float64]


class Profile(Protocol):
    """Radial laws of g groups of one kind: force over the length rho of the stretch."""

    def parts(self, rho: Array) -> tuple[Array, Array]:
        """Force f [N] and slope f' [N/m] at rho (..., g) [m], each (..., g)."""
        ...

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J]."""
        ...


class RadialLaw(Protocol):
    """Law of one group of rows: a frozen dataclass of numbers, which results list."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def kind(self) -> str:
        """Name of the law in results."""
        ...

    @property
    def stiffness(self) -> float:
        """k, stiffness of the mean system before it is linearised [N/m]."""
        ...

    @property
    def stiffest(self) -> float:
        """Bound of the slope near the loads met, for step lengths [N/m]."""
        ...

    @property
    def slip_start(self) -> float:
        """S_1, radius at which sliding begins, the first kink [m]."""
        ...

    @property
    def clearance(self) -> float:
        """Radial play [m]: the second kink is at S_2 = S_1 + clearance."""
        ...

    @property
    def friction(self) -> float:
        """F_m, friction force, 0 without [N]."""
        ...

    @property
    def memory(self) -> bool:
        """Whether friction has a history (`laws.slider`)."""
        ...

    @property
    def end(self) -> float:
        """Largest force [N] that the data of the law hold, inf where they are a formula."""
        ...

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> Profile:
        """Laws of this class, all at once."""
        ...

    def lower(self) -> Law | None:
        """The same law as one that compiled integrators know (`Law`), None where there is none."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """Play, rolling elements or spline.

    stiffness : k, tangent at `load` where the exponent is not 1 [N/m].  clearance : radial [m].  exponent : n [1].
    load : [N].  friction : F_m [N], 0 without.  memory : Coulomb friction with a history; else holonomic.
    """

    stiffness: float
    clearance: float = 0.0
    exponent: float = 1.0
    load: float = 0.0
    friction: float = 0.0
    memory: bool = False

    @property
    def slip_start(self) -> float:
        """S_1 = F_m / k [m]."""
        return self.friction / self.stiffness

    @property
    def coefficient(self) -> float:
        """C of the force C <rho - S_2>^n [N/m^n]."""
        n = self.exponent
        return self.stiffness if n == 1.0 else float((self.stiffness / (n * self.load ** ((n - 1) / n))) ** n)

    @property
    def stiffest(self) -> float:
        """k [N/m]."""
        return self.stiffness

    @property
    def kind(self) -> str:
        """Name of the law in results."""
        if self.friction:
            return "coulomb spline" if self.memory else "holonomic spline"
        if self.exponent != 1.0:
            return "rolling elements with play" if self.clearance else "rolling elements"
        return "play" if self.clearance else "linear"

    @property
    def end(self) -> float:
        """No end: inf [N]."""
        return math.inf

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> PowerProfile:
        """These laws, all at once."""

        def values(name: str) -> Array:
            return np.array([getattr(law, name) for law in laws], dtype=float)

        return PowerProfile(
            stiffness=values("stiffness"),
            friction=values("friction"),
            slip_start=values("friction") / values("stiffness"),
            clearance=values("clearance"),
            coefficient=values("coefficient"),
            exponent=values("exponent"),
        )

    def lower(self) -> Law:
        """Itself."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PowerProfile:
    """The numbers (g,) of `Law`."""

    stiffness: Array
    friction: Array
    slip_start: Array
    clearance: Array
    coefficient: Array
    exponent: Array

    def parts(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., g) [N] and slope f' (..., g) [N/m] at rho (..., g) [m]."""
        beyond = rho - (self.slip_start + self.clearance)
        pressed = np.maximum(beyond, 0.0)
        n = self.exponent
        value = np.minimum(self.stiffness * rho, self.friction) + self.coefficient * pressed**n
        slope = np.where(beyond >= 0, self.coefficient * n * pressed ** (n - 1), 0.0)
        slope += np.where(rho < self.slip_start, self.stiffness, 0.0)
        return value, slope

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J], at rho (..., g) [m]."""
        start, n = self.slip_start, self.exponent
        pressed = np.maximum(rho - (start + self.clearance), 0.0)
        stuck = self.stiffness * rho**2 / 2
        with np.errstate(invalid="ignore"):
            dry = np.where(rho <= start, stuck, self.friction * (rho - start / 2))
        energy: Array = dry + self.coefficient * pressed ** (n + 1) / (n + 1)
        return energy
