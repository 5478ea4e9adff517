"""Laws of links, each from one convex potential: contact sets of bearings, radial laws, friction with a memory.

A contact set is the law of a bearing that carries axial load or tilt: contacts between its rings, each a power of its
own approach. With the motion q (r,) of the inner ring against the outer one, at most x, y, z [m], rx, ry [rad], contact
j of normal n_j, gap g_j and coefficient c_j has the energy c_j <n_j . q - g_j>^(p + 1) / (p + 1), convex in q, so that

    F(q) = sum_j c_j <n_j . q - g_j>^p n_j        K(q) = sum_j p c_j <n_j . q - g_j>^(p - 1) n_j n_j'

K is symmetric and has no negative eigenvalue.  The contacts are fixed in the frame of the link and evenly spread about
its axis: an integral over rolling elements, without what varies as these pass by.

A radial law, by a formula or by a table, is force = f(rho) delta / rho with rho = |delta|. Play, rolling elements and
splines:

    f(rho) = min(k rho, F_m) + C <rho - S_2>^n        S_1 = F_m / k,  S_2 = S_1 + clearance

Without friction (F_m = 0) that is play and then a power law; with friction it is a spline [dong2019, eq. 27]: elastic
up to the slip start S_1, sliding at F_m over the clearance, elastic again.  S_1 is derived: any other value makes the
force discontinuous.  C follows from k, the tangent stiffness at the given load F: k = n C^(1/n) F^((n - 1)/n).

A table has cubics through its points, zero up to the first one, the play; behind the last one it goes on along its last
tangent.

A group is the rows of one link with the stretch delta (r,): x and y of a bearing or spline, or one row, of a radial law
with rho = |delta|; up to five of a contact set.  Groups stand side by side.

Coulomb friction with a memory is a slider in series with the spring of a spline, force = k (delta - s).  At each step
(derived here)

    s = argmin  k |delta - s|^2 / 2 + F_m |s - s_before|    over  |s| <= clearance

Along a first straight pull it equals the radial law; on reversal it sticks, where the radial law slides back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contacts:
    """E contacts over r rows as arrays.

    normals : n (E, r) [1, m].  gap : g (E,) [m].  coefficient : c (E,) [N/m^p].  exponent : p, 1 or more.
    """

    normals: Array
    gap: Array
    coefficient: Array
    exponent: float

    def approach(self, q: Array) -> Array:
        """How far each contact is pressed (..., E) [m], negative where it is open, at motions q (..., r) [m, rad]."""
        return q @ self.normals.T - self.gap

    def energy(self, q: Array) -> Array:
        """(...) [J] at motions q (..., r) [m, rad]."""
        p = self.exponent
        return np.maximum(self.approach(q), 0.0) ** (p + 1) @ self.coefficient / (p + 1)

    def force(self, q: Array) -> Array:
        """(..., r) [N, N m] at motions q (..., r) [m, rad], the gradient of the energy."""
        return (self.coefficient * np.maximum(self.approach(q), 0.0) ** self.exponent) @ self.normals

    def tangent(self, q: Array) -> Array:
        """Derivative of the force (..., r, r) [N/m, N/rad, N m/rad] at motions q (..., r) [m, rad]."""
        approach, p = self.approach(q), self.exponent
        slope = np.where(approach >= 0, p * self.coefficient * np.maximum(approach, 0.0) ** (p - 1), 0.0)
        return self.summed(slope)

    def summed(self, slope: Array) -> Array:
        """Sum of slopes (..., E) [N/m] times n n' (..., r, r)."""
        r = self.normals.shape[1]
        dyads = (self.normals[:, :, None] * self.normals[:, None, :]).reshape(-1, r * r)
        return (slope @ dyads).reshape(*slope.shape[:-1], r, r)


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSetLaw:
    """Contacts of one link as its law, over r rows.

    normals : E tuples n (r,) [1, m].  gap : g (E,) [m].  coefficient : c (E,) [N/m^p].  exponent : p, 1 or more.
    load : sum of the contact forces at which all contacts, equally pressed, have the nominal stiffness [N].
    """

    normals: tuple[tuple[float, ...], ...] = field(repr=False)
    gap: tuple[float, ...] = field(repr=False)
    coefficient: tuple[float, ...] = field(repr=False)
    exponent: float
    load: float
    # the same of every set, and so no fields
    kind = "contact set"
    slip_start = 0.0
    friction = 0.0
    memory = False
    end = math.inf

    @property
    def contacts(self) -> Contacts:
        """The contacts as arrays."""
        return Contacts(
            normals=np.array(self.normals),
            gap=np.array(self.gap),
            coefficient=np.array(self.coefficient),
            exponent=self.exponent,
        )

    @property
    def nominal(self) -> Array:
        """Tangent (r, r) [N/m, N/rad, N m/rad] of all contacts, equally pressed to forces of the sum `load`."""
        contacts, p = self.contacts, self.exponent
        approach = (self.load / contacts.coefficient.sum()) ** (1 / p)
        return contacts.summed(p * contacts.coefficient * approach ** (p - 1))

    @property
    def stiffness(self) -> Array:
        """Of each row in the mean system before it is linearised, (r,) [N/m, N m/rad]."""
        return np.diag(self.nominal)

    @property
    def stiffest(self) -> Array:
        """Slopes of the rows for step lengths, (r,) [N/m, N m/rad].

        Forces of one sum are stiffest, summed over directions, where they are equal: slopes are concave in the force.
        """
        return self.stiffness

    @property
    def clearance(self) -> float:
        """Least gap [m], 0 where a contact is pressed at rest."""
        return max(0.0, min(self.gap))

    def lower(self) -> ContactSetLaw:
        """Itself: compiled integrators know it."""
        return self


Index = NDArray[np.int64]


class Profile(Protocol):
    """Radial laws of g groups of one kind: force over the length rho of the stretch."""

    def parts(self, rho: Array) -> tuple[Array, Array]:
        """Force f [N] and slope f' [N/m] at rho (..., g) [m], each (..., g)."""

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J]."""


class RadialLaw(Protocol):
    """Law of one group of rows: a frozen dataclass of numbers, which results list."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def kind(self) -> str:
        """Name of the law in results."""

    @property
    def stiffness(self) -> float:
        """k, stiffness of the mean system before it is linearised [N/m]."""

    @property
    def stiffest(self) -> float:
        """Bound of the slope near the loads met, for step lengths [N/m]."""

    @property
    def slip_start(self) -> float:
        """S_1, radius at which sliding begins, the first kink [m]."""

    @property
    def clearance(self) -> float:
        """Radial play [m]: the second kink is at S_2 = S_1 + clearance."""

    @property
    def friction(self) -> float:
        """F_m, friction force, 0 without [N]."""

    @property
    def memory(self) -> bool:
        """Whether friction has a history (a slider, `Laws.slide`)."""

    @property
    def end(self) -> float:
        """Largest force [N] that the data of the law hold, inf where they are a formula."""

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> Profile:
        """Laws of this class, all at once."""

    def lower(self) -> Law | None:
        """The same law as one that compiled integrators know (`Law`), None where there is none."""


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
    end = math.inf  # of a formula, and so no field

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

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> PowerProfile:
        """These laws, all at once."""
        return PowerProfile(**_values(laws, *PowerProfile.__dataclass_fields__))

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
        return dry + self.coefficient * pressed ** (n + 1) / (n + 1)


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
    """Force over the length of the stretch; nothing slides, and there is no history.

    deflection : (L,) rising [m, rad].  force : (L,) rising, 0 first [N, N m].  slope : (L,) [N/m, N m/rad].
    stiffness : k, nominal [N/m, N m/rad].
    """

    deflection: tuple[float, ...]
    force: tuple[float, ...]
    slope: tuple[float, ...]
    stiffness: float
    # the same of every table, and so no fields
    slip_start = 0.0
    friction = 0.0
    memory = False

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
        return max(*self.slope, 1.5 * float((np.diff(self.force) / np.diff(self.deflection)).max()))

    @property
    def clearance(self) -> float:
        """Deflection of the first point, up to which there is no force [m]."""
        return self.deflection[0]

    @property
    def end(self) -> float:
        """Last force [N]."""
        return self.force[-1]

    @classmethod
    def profile(cls, laws: Sequence[Any]) -> TableProfile:
        """These laws, all at once."""
        from scipy.interpolate import CubicHermiteSpline

        distinct = list(dict.fromkeys(laws))
        curves = tuple(CubicHermiteSpline(law.deflection, law.force, law.slope) for law in distinct)
        number = np.array([distinct.index(law) for law in laws], np.int64)
        return TableProfile(tables=tuple(distinct), curves=curves, number=number)

    def lower(self) -> Law | None:
        """Play and a spring where the table is straight, else None."""
        secant = np.diff(self.force) / np.diff(self.deflection)
        slopes = np.concatenate([secant, self.slope])
        if np.ptp(slopes) > STRAIGHT * slopes.max():
            return None
        return Law(stiffness=self.stiffness, clearance=self.clearance)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TableProfile:
    """Laws of g groups: number (g,) of the table of each among `tables`.  curves : the cubics of the tables."""

    tables: tuple[RadialTable, ...]
    curves: tuple[CubicHermiteSpline, ...]
    number: NDArray[np.int64]

    def parts(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., g) [N] and slope f' (..., g) [N/m] at rho (..., g) [m]."""
        value, slope = np.zeros_like(rho), np.zeros_like(rho)
        for table, curve, groups in self._groups():
            stretch = rho[..., groups]
            inside = np.clip(stretch, table.deflection[0], table.deflection[-1])
            value[..., groups] = curve(inside) + np.maximum(stretch - inside, 0.0) * table.slope[-1]
            slope[..., groups] = np.where(stretch >= table.deflection[0], curve(inside, 1), 0.0)
        return value, slope

    def energy(self, rho: Array) -> Array:
        """Integral of the force from zero, (..., g) [J], at rho (..., g) [m]."""
        energy = np.zeros_like(rho)
        for table, curve, groups in self._groups():
            inside = np.clip(rho[..., groups], table.deflection[0], table.deflection[-1])
            beyond = np.maximum(rho[..., groups] - inside, 0.0)
            tail = beyond * (table.force[-1] + beyond * table.slope[-1] / 2)
            energy[..., groups] = curve.antiderivative()(inside) + tail
        return energy

    def _groups(self) -> list[tuple[RadialTable, CubicHermiteSpline, Index]]:
        """Each table, its curve and the numbers of its groups."""
        curved = enumerate(zip(self.tables, self.curves, strict=True))
        return [(table, curve, np.flatnonzero(self.number == i)) for i, (table, curve) in curved]


_T = TypeVar("_T", bound=np.generic)

STATES = ("play", "stick", "slip", "stop")
# A slider within this share of the clearance is at the stop: rounding of its steps.
_AT_STOP = 1e-12
# Newton steps or halvings until its angle there is found to rounding [rad].
_SEARCH, _ANGLE, _TINY = 60, 1e-15, np.finfo(float).tiny


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroupRows:
    """R rows of G groups: first (G,) row of each group, owner (R,) group of each row.

    counts : (R,) 1, or 0 of moments beside forces, which no length of a group has a part of.
    """

    first: NDArray[np.int64]
    owner: NDArray[np.int64]
    counts: Array

    @property
    def pair(self) -> NDArray[np.bool_]:
        """Whether a group has two rows (G,); else one."""
        return np.asarray(np.diff(np.append(self.first, self.owner.size)) == 2)

    def spread(self, values: NDArray[_T]) -> NDArray[_T]:
        """Values of groups (..., G) at each row (..., R)."""
        return values[..., self.owner]

    def dot(self, a: Array, b: Array) -> Array:
        """Scalar products (..., G) of the parts of each group in a and b (..., R), moments beside forces left out."""
        return np.add.reduceat(a * b * self.counts, self.first, axis=-1) if self.first.size else a[..., :0]

    def size(self, rows: Array) -> Array:
        """Euclidean length (..., G) of the part of each group in rows (..., R), in their unit, as of `dot`."""
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
    turn : of its frame against the housing that holds it, exact [rev/s], 0 of a link between bodies.
    """

    name: str
    kind: str
    rows: tuple[str, ...]
    B: Array
    law: RadialLaw | ContactSetLaw
    damping: Array
    lag: float = 0.0
    turn: Fraction = field(default_factory=Fraction)

    def __repr__(self) -> str:
        """One line: name, law and number of rows."""
        stiffness = float(np.max(self.law.stiffness))
        return f"LawGroup({self.name!r}, {self.law.kind}, {len(self.rows)} rows, {stiffness:.4g} N/m)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Laws:
    """Laws of G groups over R rows as arrays.

    A group with a `memory` has a slider.

    rows : which rows each group has.  profiles : radial laws of one class each and the numbers (g,) of their groups.
    sets : contact sets, the numbers (g,) of the groups that follow each, and their rows (g, r).
    row_stiffness, row_stiffest : k and bound of the slope of every row, (R,) [N/m, N m/rad].
    stiffness [N/m], friction [N], slip_start, clearance [m], memory : (G,) of `RadialLaw`.
    """

    rows: GroupRows
    profiles: tuple[tuple[Profile, Index], ...]
    sets: tuple[tuple[Contacts, Index, Index], ...]
    row_stiffness: Array
    row_stiffest: Array
    stiffness: Array
    friction: Array
    slip_start: Array
    clearance: Array
    memory: NDArray[np.bool_]

    @property
    def row_memory(self) -> NDArray[np.bool_]:
        """Whether the group of each row has a memory, (R,)."""
        return self.rows.spread(self.memory)

    def radial(self, rho: Array) -> tuple[Array, Array]:
        """Force f (..., G) [N] and slope f' (..., G) [N/m] of radial laws at rho (..., G) [m], 0 of contact sets."""
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
        for contacts, groups, rows in self.sets:
            energy[..., groups] = contacts.energy(delta[..., rows])
        if anchor is None or not self.memory.any():
            return energy
        slider = self.slide(delta, anchor)
        step = self.stiffness * self.rows.size(delta - slider) ** 2 / 2
        step += self.friction * self.rows.size(slider - anchor)
        return np.where(self.memory, step, energy)

    def force(self, delta: Array, anchor: Array | None = None) -> Array:
        """Force along every row (..., R) [N], the gradient of the potential; delta, anchor : (..., R) [m]."""
        secant, _ = self._secant(self.rows.size(delta))
        force: Array = self.rows.spread(secant) * delta
        for contacts, _, rows in self.sets:
            force[..., rows] = contacts.force(delta[..., rows])
        if anchor is None or not self.memory.any():
            return force
        spring = self.row_stiffness * (delta - self.slide(delta, anchor))
        return np.where(self.row_memory, spring, force)

    def tangent(self, delta: Array, anchor: Array | None = None) -> Array:
        """Derivative of the force (..., R, R) [N/m], symmetric, block by block; delta, anchor : (..., R) [m]."""
        rho = self.rows.size(delta)
        secant, slope = self._secant(rho)
        unit = delta / self.rows.spread(_or_one(rho))
        tangent = self.rows.blocks(unit, along=slope, across=secant)
        for contacts, _, rows in self.sets:
            tangent[..., rows[:, :, None], rows[:, None, :]] = contacts.tangent(delta[..., rows])
        if anchor is None or not self.memory.any():
            return tangent
        return np.where(self.row_memory[:, None], self._slider_tangent(delta, anchor), tangent)

    def slide(self, delta: Array, anchor: Array) -> Array:
        """Sliders (..., R) [m] after a step to delta (..., R) from sliders at `anchor` (..., R); 0 without a memory."""
        slider, _ = self._slid(delta, anchor)
        return np.where(self.row_memory, slider, 0.0)

    def state(self, delta: Array, anchor: Array | None = None) -> Index:
        """State of each group (..., G), an index into `STATES`; delta, anchor : (..., R) [m].

        play : inside the clearance, no force.  stick : elastic before the slip start.  slip : sliding at the friction
        force.  stop : beyond the clearance, on the elements or the teeth; any contact of a set is pressed.
        """
        rho = self.rows.size(delta)
        before = np.where(self.friction > 0, np.where(rho < self.slip_start, 1, 2), 0)
        state = np.where(rho >= self.slip_start + self.clearance, 3, before)
        for contacts, groups, rows in self.sets:
            state[..., groups] = np.where(np.any(contacts.approach(delta[..., rows]) > 0, axis=-1), 3, 0)
        if anchor is None or not self.memory.any():
            return state
        slider = self.slide(delta, anchor)
        moved = self.rows.size(slider - anchor) > 0
        stopped = self.rows.size(slider) >= self.clearance * (1 - _AT_STOP)
        return np.where(self.memory, np.where(stopped, 3, np.where(moved, 2, 1)), state)

    def kinks(self, delta: Array, step: Array, anchor: Array | None = None) -> Array:
        """Step lengths a (T, 5 G) [1] at which delta + a step crosses S_1 or S_2 of a group, or is nearest to its
        centre.

        delta, step, anchor : (T, R) [m].  nan or negative where it does not.  With a memory S_1 counts from the slider.
        Contacts of a set add none: their forces have no corner.
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
            slip = np.sqrt(np.maximum((c - radius) ** 2 + 4 * c * radius * np.sin(psi / 2) ** 2, _TINY))
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


def _values(laws: Sequence[Any], *names: str) -> dict[str, Array]:
    """Numbers (g,) of the laws, by name."""
    return {name: np.array([getattr(law, name) for law in laws], dtype=float) for name in names}


def _of_rows(groups: Sequence[LawGroup], name: str) -> Array:
    """A number of the laws at every row (R,)."""
    values = [np.broadcast_to(getattr(group.law, name), len(group.rows)) for group in groups]
    return np.concatenate([np.zeros(0), *values])


def stacked(groups: Sequence[LawGroup]) -> Laws:
    """Laws of the groups as arrays, rows in order."""
    counts = np.array([len(group.rows) for group in groups], dtype=np.int64)
    laws = [group.law for group in groups]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)[: len(groups)]
    profiles, sets = [], []
    # contact sets are told apart by their numbers, radial laws by their class
    kinds = [law if isinstance(law, ContactSetLaw) else type(law) for law in laws]
    for kind in dict.fromkeys(kinds):
        numbers = np.array([i for i, each in enumerate(kinds) if each == kind], np.int64)
        if isinstance(kind, ContactSetLaw):
            sets.append((kind.contacts, numbers, first[numbers][:, None] + np.arange(counts[numbers[0]])))
        else:
            profiles.append((kind.profile([laws[i] for i in numbers]), numbers))
    forces = ("/x", "/y", "/z")
    beside = [not row.endswith(forces) and group.rows[0].endswith(forces) for group in groups for row in group.rows]
    return Laws(
        rows=GroupRows(
            first=first,
            owner=np.repeat(np.arange(len(groups)), counts),
            counts=1.0 - np.array(beside, dtype=float),
        ),
        profiles=tuple(profiles),
        sets=tuple(sets),
        row_stiffness=_of_rows(groups, "stiffness"),
        row_stiffest=_of_rows(groups, "stiffest"),
        stiffness=np.array([np.max(law.stiffness) for law in laws], dtype=float),
        **_values(laws, "friction", "slip_start", "clearance"),
        memory=np.array([law.memory and law.friction > 0 for law in laws], dtype=bool),
    )
