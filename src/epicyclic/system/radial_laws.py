"""Radial laws of links: force = f(rho) delta / rho with rho = |delta|, by a formula or by a table.

Play, rolling elements and splines:

    f(rho) = min(k rho, F_m) + C <rho - S_2>^n        S_1 = F_m / k,  S_2 = S_1 + clearance

Without friction (F_m = 0) that is play and then a power law; with friction it is a spline [dong2019, eq. 27]: elastic
up to the slip start S_1, sliding at F_m over the clearance, elastic again.  S_1 is derived: any other value makes the
force discontinuous.  C follows from k, the tangent stiffness at the given load F: k = n C^(1/n) F^((n - 1)/n).

A table has cubics through its points, zero up to the first one, the play; behind the last one it goes on along its last
tangent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

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
        """Whether friction has a history (`group_laws`)."""
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


# Slopes that differ by less than this of the largest are one: rounding of a table computed from a straight line.
STRAIGHT = 1e-9


def cubic(force: tuple[Array, Array], slope: tuple[Array, Array], width: Array, t: Array) -> tuple[Array, Array]:
    """Force [N] and slope [N/m] at the place t (0 .. 1) of a cell, from those at both ends of it."""
    (f0, f1), (k0, k1) = force, slope
    rest = 1 - t
    value = f0 * (1 + 2 * t) * rest**2 + f1 * t**2 * (3 - 2 * t) + width * (k0 * t * rest**2 - k1 * t**2 * rest)
    rate = 6 * t * rest * (f1 - f0) / width + k0 * rest * (1 - 3 * t) + k1 * t * (3 * t - 2)
    return value, rate


def cubic_energy(force: tuple[Array, Array], slope: tuple[Array, Array], width: Array, t: Array) -> Array:
    """Integral of the force of `cubic` [J] from the start of the cell."""
    (f0, f1), (k0, k1) = force, slope
    mean = f0 * (t - t**3 + t**4 / 2) + f1 * (t**3 - t**4 / 2)
    mean += width * (k0 * (t**2 / 2 - 2 * t**3 / 3 + t**4 / 4) + k1 * (t**4 / 4 - t**3 / 3))
    return width * mean


def energy_before(deflection: Array, force: Array, slope: Array) -> Array:
    """Energy [J] of cubics up to each of their points (..., L)."""
    width = np.diff(deflection, axis=-1)
    whole = width * (force[..., :-1] + force[..., 1:]) / 2
    whole += width**2 * (slope[..., :-1] - slope[..., 1:]) / 12
    return np.concatenate([np.zeros((*whole.shape[:-1], 1)), np.cumsum(whole, axis=-1)], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialTable:
    """Force over the length of the stretch.

    deflection : (L,) rising [m, rad].  force : (L,) rising, 0 first [N, N m].  slope : (L,) [N/m, N m/rad].
    stiffness : k, nominal [N/m, N m/rad].
    """

    deflection: tuple[float, ...]
    force: tuple[float, ...]
    slope: tuple[float, ...]
    stiffness: float

    def __repr__(self) -> str:
        """One line: points and last force."""
        return f"RadialTable({len(self.force)} points up to {self.force[-1]:.4g} N)"

    @property
    def kind(self) -> str:
        """Name of the law in results."""
        return "table with play" if self.clearance else "table"

    @property
    def stiffest(self) -> float:
        """Largest slope or one and a half times the largest secant, which no rising cubic exceeds [N/m]."""
        secant = np.diff(self.force) / np.diff(self.deflection)
        return max(*self.slope, 1.5 * float(secant.max()))

    @property
    def slip_start(self) -> float:
        """0: nothing slides [m]."""
        return 0.0

    @property
    def clearance(self) -> float:
        """Deflection of the first point, up to which there is no force [m]."""
        return self.deflection[0]

    @property
    def friction(self) -> float:
        """None [N]."""
        return 0.0

    @property
    def memory(self) -> bool:
        """No history."""
        return False

    @property
    def end(self) -> float:
        """Last force [N]."""
        return self.force[-1]

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> TableProfile:
        """These laws, all at once."""
        distinct = list(dict.fromkeys(laws))
        return TableProfile(tables=tuple(distinct), number=np.array([distinct.index(law) for law in laws], np.int64))

    def lower(self) -> Law | None:
        """Play and a spring where the table is straight, else None."""
        secant = np.diff(self.force) / np.diff(self.deflection)
        slopes = np.concatenate([secant, self.slope])
        if np.ptp(slopes) > STRAIGHT * slopes.max():
            return None
        return Law(stiffness=self.stiffness, clearance=self.clearance)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TableProfile:
    """Laws of g groups: number (g,) of the table of each among `tables`."""

    tables: tuple[RadialTable, ...]
    number: NDArray[np.int64]

    def parts(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., g) [N] and slope f' (..., g) [N/m] at rho (..., g) [m]."""
        value, slope = np.zeros_like(rho), np.zeros_like(rho)
        for table, groups in self._groups():
            stretch = rho[..., groups]
            force_at, slope_at, width, t, _ = _cells(table, stretch)
            force, rate = cubic(force_at, slope_at, width, t)
            beyond = np.maximum(stretch - table.deflection[-1], 0.0)
            value[..., groups] = force + beyond * table.slope[-1]
            slope[..., groups] = np.where(stretch >= table.deflection[0], rate, 0.0)
        return value, slope

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J], at rho (..., g) [m]."""
        energy = np.zeros_like(rho)
        for table, groups in self._groups():
            stretch = rho[..., groups]
            force_at, slope_at, width, t, cell = _cells(table, stretch)
            before = energy_before(np.array(table.deflection), np.array(table.force), np.array(table.slope))
            beyond = np.maximum(stretch - table.deflection[-1], 0.0)
            tail = beyond * (table.force[-1] + beyond * table.slope[-1] / 2)
            energy[..., groups] = before[cell] + cubic_energy(force_at, slope_at, width, t) + tail
        return energy

    def _groups(self) -> list[tuple[RadialTable, NDArray[np.int64]]]:
        """Each table and the numbers of its groups."""
        return [(table, np.flatnonzero(self.number == i)) for i, table in enumerate(self.tables)]


def _cells(
    table: RadialTable, rho: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array], Array, Array, NDArray[np.int64]]:
    """Forces and slopes at both ends of the cell of each stretch [m], its width, place 0 .. 1 in it, and its number."""
    x, f, k = (np.array(values) for values in (table.deflection, table.force, table.slope))
    cell = np.clip(np.searchsorted(x, rho, side="right") - 1, 0, len(x) - 2)
    width = np.diff(x)[cell]
    t = np.clip((rho - x[cell]) / width, 0.0, 1.0)
    return (f[cell], f[cell + 1]), (k[cell], k[cell + 1]), width, t, cell
