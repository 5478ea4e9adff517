"""Tabulated law of links: force over the length rho of the stretch by cubics through given points.

Zero up to the first point, the play; behind the last one it goes on along its last tangent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .radial import Law

__all__ = ["RadialTable", "TableProfile"]

Array = NDArray[np.float64]

# Slopes that differ by less than this of the largest are one: rounding of a straight line.
_STRAIGHT = 1e-9


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
        if np.ptp(slopes) > _STRAIGHT * slopes.max():
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
        for table, mine in self._places():
            (f0, f1), (k0, k1), h, t, beyond, _ = _cells(table, rho[..., mine])
            rest = 1 - t
            force = f0 * (1 + 2 * t) * rest**2 + f1 * t**2 * (3 - 2 * t) + h * (k0 * t * rest**2 - k1 * t**2 * rest)
            rate = 6 * t * rest * (f1 - f0) / h + k0 * rest * (1 - 3 * t) + k1 * t * (3 * t - 2)
            pressed = rho[..., mine] >= table.deflection[0]
            value[..., mine] = force + beyond * table.slope[-1]
            slope[..., mine] = np.where(pressed, rate, 0.0)
        return value, slope

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J], at rho (..., g) [m]."""
        energy = np.zeros_like(rho)
        for table, mine in self._places():
            (f0, f1), (k0, k1), h, t, beyond, before = _cells(table, rho[..., mine])
            part = f0 * (t - t**3 + t**4 / 2) + f1 * (t**3 - t**4 / 2)
            part += h * (k0 * (t**2 / 2 - 2 * t**3 / 3 + t**4 / 4) + k1 * (t**4 / 4 - t**3 / 3))
            energy[..., mine] = before + h * part + beyond * (table.force[-1] + beyond * table.slope[-1] / 2)
        return energy

    def _places(self) -> list[tuple[RadialTable, NDArray[np.int64]]]:
        """Each table and the numbers of its groups."""
        return [(table, np.flatnonzero(self.number == i)) for i, table in enumerate(self.tables)]


def _cells(
    table: RadialTable, rho: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array], Array, Array, Array, Array]:
    """Cell of each stretch [m]: forces and slopes at its ends, width, place 0 .. 1 in it, what is behind the last point
    [m], and the energy up to its start [J]."""
    x, f, k = (np.array(values) for values in (table.deflection, table.force, table.slope))
    width = np.diff(x)
    whole = width * (f[:-1] + f[1:]) / 2 + width**2 * (k[:-1] - k[1:]) / 12
    before = np.concatenate([[0.0], np.cumsum(whole)])
    cell = np.clip(np.searchsorted(x, rho, side="right") - 1, 0, len(x) - 2)
    h = width[cell]
    t = np.clip((rho - x[cell]) / h, 0.0, 1.0)
    ends = (f[cell], f[cell + 1]), (k[cell], k[cell + 1])
    return *ends, h, t, np.maximum(rho - x[-1], 0.0), before[cell]
