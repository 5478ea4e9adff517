"""Laws of link groups, each from one convex potential: radial laws (`laws.radial`), friction with a memory
(`laws.slider`).

A group is the rows of one link (x and y of a bearing or spline, or one row) with the stretch delta (r,), rho = |delta|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .radial import Profile, RadialLaw
from .rows import GroupRows
from .slider import AT_STOP, Slider

__all__ = ["STATES", "LawGroup", "Laws", "stacked"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STATES = ("play", "stick", "slip", "stop")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawGroup:
    """Rows of one link that follow one law.

    name : of the link, ``main/sun/support``.  kind : of the link: support, bearing, coupling, ...
    rows : (r,) ``main/sun/support/x``.  B : (n, r).  law.
    damping : (r,) of its dampers, in C already [N s/m].  lag : damping per tangent stiffness, not in C [s].
    """

    name: str
    kind: str
    rows: tuple[str, ...]
    B: Array
    law: RadialLaw
    damping: Array
    lag: float = 0.0

    def __repr__(self) -> str:
        """One line: name, law and number of rows."""
        return f"LawGroup({self.name!r}, {self.law.kind}, {len(self.rows)} rows, {self.law.stiffness:.4g} N/m)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Laws:
    """Laws of G groups over R rows as arrays.

    rows : which rows each group has.  profiles : radial laws of one class each and the numbers (g,) of their groups.
    stiffness, stiffest [N/m], friction [N], slip_start, clearance [m], memory : (G,) of `RadialLaw`.
    """

    rows: GroupRows
    profiles: tuple[tuple[Profile, Index], ...]
    stiffness: Array
    stiffest: Array
    friction: Array
    slip_start: Array
    clearance: Array
    memory: NDArray[np.bool_]

    @property
    def count(self) -> int:
        """Number R of rows."""
        return int(self.rows.owner.size)

    @property
    def row_stiffness(self) -> Array:
        """k of every row, (R,) [N/m]."""
        return self.rows.spread(self.stiffness)

    @property
    def row_memory(self) -> NDArray[np.bool_]:
        """Whether the group of each row has a memory, (R,)."""
        return self.rows.spread(self.memory)

    @property
    def slider(self) -> Slider:
        """Sliders of the groups with a memory."""
        return Slider(
            rows=self.rows,
            memory=self.memory,
            stiffness=self.stiffness,
            friction=self.friction,
            clearance=self.clearance,
            slip_start=self.slip_start,
        )

    def radial(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., G) [N] and slope f' (..., G) [N/m] of the radial laws at rho (..., G) [m]."""
        if len(self.profiles) == 1:
            return self.profiles[0][0].parts(rho)
        value, slope = np.zeros_like(rho), np.zeros_like(rho)
        for profile, mine in self.profiles:
            value[..., mine], slope[..., mine] = profile.parts(rho[..., mine])
        return value, slope

    def potential(self, delta: Array, anchor: Array | None = None) -> Array:
        """Energy of each group (..., G) [J] at delta (..., R) [m]; with a memory that of one step from the slider
        `anchor` (..., R) [m]."""
        rho = self.rows.size(delta)
        energy = np.zeros_like(rho)
        for profile, mine in self.profiles:
            energy[..., mine] = profile.energy(rho[..., mine])
        if anchor is None or not self.memory.any():
            return energy
        slider = self.slide(delta, anchor)
        step = self.stiffness * self.rows.size(delta - slider) ** 2 / 2
        step += self.friction * self.rows.size(slider - anchor)
        return np.where(self.memory, step, energy)

    def force(self, delta: Array, anchor: Array | None = None) -> Array:
        """Force along every row (..., R) [N], the gradient of the potential; delta, anchor : (..., R) [m]."""
        rho = self.rows.size(delta)
        value, slope = self.radial(rho)
        secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
        result: Array = self.rows.spread(secant) * delta
        if anchor is None or not self.memory.any():
            return result
        spring = self.row_stiffness * (delta - self.slide(delta, anchor))
        return np.where(self.row_memory, spring, result)

    def tangent(self, delta: Array, anchor: Array | None = None) -> Array:
        """Derivative of the force (..., R, R) [N/m], symmetric, block by block; delta, anchor : (..., R) [m]."""
        rho = self.rows.size(delta)
        value, slope = self.radial(rho)
        secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
        unit = delta / self.rows.spread(np.where(rho > 0, rho, 1.0))
        result = self.rows.blocks(unit, along=slope, across=secant)
        if anchor is None or not self.memory.any():
            return result
        return np.where(self.row_memory[:, None], self.slider.tangent(delta, anchor), result)

    def slide(self, delta: Array, anchor: Array) -> Array:
        """Sliders (..., R) [m] after a step to delta (..., R) from sliders at `anchor` (..., R); 0 without a memory."""
        return self.slider.slide(delta, anchor)

    def kinks(self, delta: Array, step: Array, anchor: Array | None = None) -> Array:
        """Step lengths a (T, 5 G) [1] at which delta + a step crosses S_1 or S_2 of a group, or is nearest to its
        centre.

        delta, step, anchor : (T, R) [m].  nan or negative where it does not.  With a memory S_1 counts from the slider.
        """
        start = self.slip_start
        around = np.where(self.row_memory, 0.0 if anchor is None else anchor, 0.0)
        square = self.rows.size(step) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            nearest = -self.rows.dot(delta, step) / square
            first = self._crossings(delta - around, step, start)
            second = self._crossings(delta, step, start + self.clearance)
        return np.concatenate([nearest, *first, *second], axis=-1)

    def _crossings(self, delta: Array, step: Array, radius: Array) -> tuple[Array, Array]:
        """Both step lengths a (..., G) with |delta + a step| = radius; delta, step : (..., R), radius : (G,) [m]."""
        square = self.rows.size(step) ** 2
        middle = -self.rows.dot(delta, step) / square
        half = np.sqrt(middle**2 - (self.rows.size(delta) ** 2 - radius**2) / square)
        return middle - half, middle + half

    def state(self, delta: Array, anchor: Array | None = None) -> Index:
        """State of each group (..., G), an index into `STATES`; delta, anchor : (..., R) [m].

        play : inside the clearance, no force.  stick : elastic before the slip start.  slip : sliding at the friction
        force.  stop : beyond the clearance, on the elements or the teeth.
        """
        rho = self.rows.size(delta)
        before = np.where(self.friction > 0, np.where(rho < self.slip_start, 1, 2), 0)
        found = np.where(rho >= self.slip_start + self.clearance, 3, before)
        if anchor is None or not self.memory.any():
            return found
        slider = self.slide(delta, anchor)
        moved = self.rows.size(slider - anchor) > 0
        stopped = self.rows.size(slider) >= self.clearance * (1 - AT_STOP)
        return np.where(self.memory, np.where(stopped, 3, np.where(moved, 2, 1)), found)


def stacked(groups: Sequence[LawGroup]) -> Laws:
    """Laws of the groups as arrays, rows in order."""
    counts = np.array([len(group.rows) for group in groups], dtype=np.int64)
    laws = [group.law for group in groups]
    kinds = dict.fromkeys(type(law) for law in laws)
    places = [(kind, [i for i, law in enumerate(laws) if type(law) is kind]) for kind in kinds]

    def values(name: str) -> Array:
        return np.array([getattr(law, name) for law in laws], dtype=float)

    return Laws(
        rows=GroupRows(
            first=np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)[: len(groups)],
            owner=np.repeat(np.arange(len(groups)), counts),
        ),
        profiles=tuple((kind.profile([laws[i] for i in mine]), np.array(mine, np.int64)) for kind, mine in places),
        stiffness=values("stiffness"),
        stiffest=values("stiffest"),
        friction=values("friction"),
        slip_start=values("slip_start"),
        clearance=values("clearance"),
        memory=np.array([law.memory and law.friction > 0 for law in laws], dtype=bool),
    )
