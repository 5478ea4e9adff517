"""Laws of link groups, each from one convex potential: radial laws (`radial_laws`), and friction with a memory.

A group is the rows of one link (x and y of a bearing or spline, or one row) with the stretch delta (r,), rho = |delta|.
Groups stand side by side.

Coulomb friction with a memory is a slider in series with the spring of a spline, force = k (delta - s).  At each step
(derived here)

    s = argmin  k |delta - s|^2 / 2 + F_m |s - s_before|    over  |s| <= clearance

Along a first straight pull it equals the radial law; on reversal it sticks, where the radial law slides back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .radial_laws import Array, Profile, RadialLaw

Index = NDArray[np.int64]
_T = TypeVar("_T", bound=np.generic)

STATES = ("play", "stick", "slip", "stop")
# A slider within this share of the clearance is at the stop: rounding of its steps.
_AT_STOP = 1e-12
# Newton steps or halvings until its angle there is found to rounding [rad].
_SEARCH, _ANGLE = 60, 1e-15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroupRows:
    """R rows of G groups: first (G,) row of each group, owner (R,) group of each row."""

    first: NDArray[np.int64]
    owner: NDArray[np.int64]

    @property
    def pair(self) -> NDArray[np.bool_]:
        """Whether a group has two rows (G,); else one."""
        two: NDArray[np.bool_] = np.diff(np.append(self.first, self.owner.size)) == 2
        return two

    def spread(self, values: NDArray[_T]) -> NDArray[_T]:
        """Values of groups (..., G) at each row (..., R)."""
        result: NDArray[_T] = values[..., self.owner]
        return result

    def dot(self, a: Array, b: Array) -> Array:
        """Scalar products (..., G) of the parts of each group in a and b (..., R)."""
        return np.add.reduceat(a * b, self.first, axis=-1) if self.first.size else a[..., :0]

    def size(self, rows: Array) -> Array:
        """Euclidean length (..., G) of the part of each group in rows (..., R), in their unit."""
        return np.sqrt(self.dot(rows, rows))

    def blocks(self, unit: Array, *, along: Array, across: Array) -> Array:
        """Blocks along n n' + across (1 - n n') (..., R, R) [N/m], unit vectors n (..., R); along, across (..., G)."""
        same = self.owner[:, None] == self.owner
        dyad = self.spread(along - across)[..., :, None] * unit[..., :, None] * unit[..., None, :]
        result: Array = np.where(same, dyad, 0.0)
        rows = np.arange(self.owner.size)
        result[..., rows, rows] += self.spread(across)
        return result


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

    A group with a `memory` has a slider.

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
    def row_stiffness(self) -> Array:
        """k of every row, (R,) [N/m]."""
        return self.rows.spread(self.stiffness)

    @property
    def row_memory(self) -> NDArray[np.bool_]:
        """Whether the group of each row has a memory, (R,)."""
        return self.rows.spread(self.memory)

    def radial(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., G) [N] and slope f' (..., G) [N/m] of the radial laws at rho (..., G) [m]."""
        if len(self.profiles) == 1:
            return self.profiles[0][0].parts(rho)
        force, slope = np.zeros_like(rho), np.zeros_like(rho)
        for profile, groups in self.profiles:
            force[..., groups], slope[..., groups] = profile.parts(rho[..., groups])
        return force, slope

    def potential(self, delta: Array, anchor: Array | None = None) -> Array:
        """Energy of each group (..., G) [J] at delta (..., R) [m]; with a memory that of one step from the slider
        `anchor` (..., R) [m]."""
        rho = self.rows.size(delta)
        energy = np.zeros_like(rho)
        for profile, groups in self.profiles:
            energy[..., groups] = profile.energy(rho[..., groups])
        if anchor is None or not self.memory.any():
            return energy
        slider = self.slide(delta, anchor)
        step = self.stiffness * self.rows.size(delta - slider) ** 2 / 2
        step += self.friction * self.rows.size(slider - anchor)
        return np.where(self.memory, step, energy)

    def force(self, delta: Array, anchor: Array | None = None) -> Array:
        """Force along every row (..., R) [N], the gradient of the potential; delta, anchor : (..., R) [m]."""
        secant, _ = self._secant(self.rows.size(delta))
        radial: Array = self.rows.spread(secant) * delta
        if anchor is None or not self.memory.any():
            return radial
        spring = self.row_stiffness * (delta - self.slide(delta, anchor))
        return np.where(self.row_memory, spring, radial)

    def tangent(self, delta: Array, anchor: Array | None = None) -> Array:
        """Derivative of the force (..., R, R) [N/m], symmetric, block by block; delta, anchor : (..., R) [m]."""
        rho = self.rows.size(delta)
        secant, slope = self._secant(rho)
        unit = delta / self.rows.spread(_or_one(rho))
        radial = self.rows.blocks(unit, along=slope, across=secant)
        if anchor is None or not self.memory.any():
            return radial
        return np.where(self.row_memory[:, None], self._slider_tangent(delta, anchor), radial)

    def slide(self, delta: Array, anchor: Array) -> Array:
        """Sliders (..., R) [m] after a step to delta (..., R) from sliders at `anchor` (..., R); 0 without a memory."""
        slider, _ = self._slid(delta, anchor)
        return np.where(self.row_memory, slider, 0.0)

    def state(self, delta: Array, anchor: Array | None = None) -> Index:
        """State of each group (..., G), an index into `STATES`; delta, anchor : (..., R) [m].

        play : inside the clearance, no force.  stick : elastic before the slip start.  slip : sliding at the friction
        force.  stop : beyond the clearance, on the elements or the teeth.
        """
        rho = self.rows.size(delta)
        before = np.where(self.friction > 0, np.where(rho < self.slip_start, 1, 2), 0)
        radial = np.where(rho >= self.slip_start + self.clearance, 3, before)
        if anchor is None or not self.memory.any():
            return radial
        slider = self.slide(delta, anchor)
        moved = self.rows.size(slider - anchor) > 0
        stopped = self.rows.size(slider) >= self.clearance * (1 - _AT_STOP)
        return np.where(self.memory, np.where(stopped, 3, np.where(moved, 2, 1)), radial)

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

    def _secant(self, rho: Array) -> tuple[Array, Array]:
        """Secant f / rho, at 0 the slope, and slope f' (..., G) [N/m] of the radial laws at rho (..., G) [m]."""
        force, slope = self.radial(rho)
        return np.where(rho > 0, force / _or_one(rho), slope), slope

    def _slid(self, delta: Array, anchor: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Slider (..., R) [m], and whether it is at its stop (..., G).

        Away from the stop it is anchor + w <1 - S_1 / |w|> with w = delta - anchor.
        """
        pull = delta - anchor
        length = self.rows.size(pull)
        factor = np.where(length > self.slip_start, 1.0 - self.slip_start / _or_one(length), 0.0)
        slider: Array = anchor + self.rows.spread(factor) * pull
        out = self.memory & (self.rows.size(slider) > self.clearance * (1 + _AT_STOP))
        if out.any():
            slider = np.where(self.rows.spread(out), self._at_stop(delta, anchor, out), slider)
        return slider, out

    def _at_stop(self, delta: Array, anchor: Array, out: NDArray[np.bool_]) -> Array:
        """Slider (..., R) [m] on the circle of the clearance, between the directions of delta and the anchor.

        Of a group of one row it is on the side of delta.  At the angle theta from delta and psi from the anchor the
        slope of the energy along the circle, k |delta| sin theta - F_m |anchor| sin psi / |slip|, is zero.  Safeguarded
        Newton steps on the whole array find it: the groups of all instants at once, in every step of a static history.
        """
        first, pair = self.rows.first, self.rows.pair
        second = first + pair
        dx, dy = delta[..., first], np.where(pair, delta[..., second], 0.0)
        px, py = anchor[..., first], np.where(pair, anchor[..., second], 0.0)
        reach, radius, c = np.hypot(dx, dy), np.hypot(px, py), self.clearance
        cross = dx * py - dy * px
        side = np.where(cross < 0, -1.0, 1.0)
        end = np.where(out & pair, np.arctan2(np.abs(cross), dx * px + dy * py), 0.0)
        # a slider at the stop already and pressed on may be held there by friction
        stuck = (radius >= c * (1 - _AT_STOP)) & (reach * np.cos(end) >= c)
        stuck &= self.stiffness * reach * np.sin(end) <= self.friction
        low, high = np.where(stuck, end, 0.0), end
        theta = (low + high) / 2
        for _ in range(_SEARCH):
            psi = end - theta
            slip = np.sqrt(np.maximum((c - radius) ** 2 + 4 * c * radius * np.sin(psi / 2) ** 2, np.finfo(float).tiny))
            drag, lean = self.friction * radius / slip, np.sin(psi)
            slope = self.stiffness * reach * np.sin(theta) - drag * lean
            bend = self.stiffness * reach * np.cos(theta) + drag * (np.cos(psi) - c * radius * (lean / slip) ** 2)
            low, high = np.where(slope < 0, theta, low), np.where(slope < 0, high, theta)
            trial = theta - slope / _or_one(bend)
            trial = np.where((bend > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
            change, theta = np.abs(trial - theta), trial
            if np.all(change <= _ANGLE):
                break
        along, across = c * np.cos(theta), side * c * np.sin(theta)
        slider = np.empty_like(delta)
        slider[..., second] = (along * dy + across * dx) / _or_one(reach)
        slider[..., first] = (along * dx - across * dy) / _or_one(reach)
        return slider

    def _slider_tangent(self, delta: Array, anchor: Array) -> Array:
        """Derivative (..., R, R) [N/m] of k (delta - s): k in stick, F_m / |delta - anchor| across the slip in slip.

        At the stop the slider moves along the circle only, by k / D of the motion of delta along it, with
        D = (k delta - F_m n) . s / |s|^2 + F_m (n . s / |s|)^2 / |s - anchor| and n the direction of the slip.
        """
        k, friction = self.stiffness, self.friction
        slider, stopped = self._slid(delta, anchor)
        moved, pull = self.rows.size(slider - anchor), self.rows.size(delta - anchor)
        slips = moved > 0
        unit = (delta - anchor) / self.rows.spread(_or_one(pull))
        across = np.where(slips, friction / _or_one(pull), k)
        free = self.rows.blocks(unit, along=np.where(slips, 0.0, k), across=across)
        if not stopped.any():
            return free
        outward = slider / self.rows.spread(_or_one(self.rows.size(slider)))
        step = (slider - anchor) / self.rows.spread(_or_one(moved))
        cosine = self.rows.dot(step, outward)
        D = (k * self.rows.dot(delta, outward) - friction * cosine) / np.where(stopped, self.clearance, 1.0)
        D += friction * cosine**2 / np.where(slips, moved, np.inf)
        across = np.where(slips & (D > 0), k - k**2 / _or_one(D), k)
        held = self.rows.blocks(outward, along=k * np.ones_like(across), across=across)
        return np.where(self.rows.spread(stopped)[..., :, None], held, free)


def _or_one(values: Array) -> Array:
    """Values where they are above zero, else 1: divisors."""
    return np.where(values > 0, values, 1.0)


def stacked(groups: Sequence[LawGroup]) -> Laws:
    """Laws of the groups as arrays, rows in order."""
    counts = np.array([len(group.rows) for group in groups], dtype=np.int64)
    laws = [group.law for group in groups]
    profiles = []
    for kind in dict.fromkeys(type(law) for law in laws):
        numbers = [i for i, law in enumerate(laws) if type(law) is kind]
        profiles.append((kind.profile([laws[i] for i in numbers]), np.array(numbers, np.int64)))

    def values(name: str) -> Array:
        return np.array([getattr(law, name) for law in laws], dtype=float)

    return Laws(
        rows=GroupRows(
            first=np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)[: len(groups)],
            owner=np.repeat(np.arange(len(groups)), counts),
        ),
        profiles=tuple(profiles),
        stiffness=values("stiffness"),
        stiffest=values("stiffest"),
        friction=values("friction"),
        slip_start=values("slip_start"),
        clearance=values("clearance"),
        memory=np.array([law.memory and law.friction > 0 for law in laws], dtype=bool),
    )
