"""Laws of flanks: force over one gap at a phase of the mesh cycle; linear, tabulated, blended, or along the face.

A flank law holds c rows of one kind.  `at` fixes the phases, which is the expensive part and is kept by the caller;
`evaluate` is then asked for forces at gaps, once a Newton step or integrator stage.  A law only pushes: at gaps up to
`touch` its force is zero.

Linear with parametric stiffness: f = k(t) <delta> of a flank, k periodic in its mesh tone [kahraman1990].

    k(theta) = k0 (1 + Re sum_l v_l exp(2 pi i l theta)),    theta the phase of the tone [cycles]

A truncated series may dip below zero where the true stiffness is small: k stays above 1e-6 k0.

Tabulated: gaps of equal force and slopes are monotone cubics of the phase [fritsch1980]; between forces a rising cubic
has the tabulated slopes: the derivatives are continuous.  Beyond the last force the law continues along its tangent.

Blended, f = (1 - share) k <delta> + share f_law(delta): the homotopy by which a solver comes from the one to the other.

Along the face each mesh is one convex potential of three rows.  Its teeth stay straight against each other, so that the
approach of any place of the plane of action is

    w(zeta, s) = c1 w1 + c2 w2 + c3 w3,   c1 + c2 + c3 = 1

of its rows at both ends of the face, and at one place off the pitch point along the line of action.  The distribution
of load in between is internal to the law, which returns the force of each row, its derivative and the energy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .link_laws import STRAIGHT, Array, Index, cubic, cubic_energy, energy_before

# Least stiffness of a closed flank per its mean: below any support, and the energy stays convex.
LEAST = 1e-6
# Phases beyond both ends of a cycle from which the cubics of its ends are made: a slope needs two neighbours.
_AROUND = 3


class FlankAt(Protocol):
    """Laws of c rows at P phases.  Gaps delta are (..., P, c) [m]: leading axes are other phases, speeds or cases."""

    @property
    def touch(self) -> Array:
        """Gap at which the force begins (P, c) [m]; a row presses where delta > touch."""

    @property
    def kinks(self) -> Array:
        """Gaps at which the tangent jumps (P, c, K) [m]."""

    def instants(self, chosen: Any) -> FlankAt:
        """The same at the chosen ones of the P phases."""

    def rows(self, chosen: Any) -> FlankAt:
        """The same of the chosen ones of the c rows."""

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m], each (..., P, c)."""

    def energy(self, delta: Array) -> Array:
        """Energy (..., P, c) [J] at gaps delta [m], zero at `touch`; its slope is the force."""

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether the tangent of each row keeps one value at every phase (c,) over the gaps low .. high (c,) [m]."""


class FlankLaw(Protocol):
    """Law of c rows; row j follows the phase of mesh tone `tone[j]`."""

    @property
    def stiffest(self) -> Array:
        """Bound of the tangent (c,) [N/m], for step lengths and line searches."""

    @property
    def end(self) -> Array:
        """Largest force (c,) [N] that the data of the law hold, inf where they are a formula; behind it the law goes on
        along its last tangent."""

    @property
    def load(self) -> Array:
        """Force (c,) [N] at which the tangents that linear analyses use were taken, nan where it is not known."""

    def rows(self, chosen: Any) -> FlankLaw:
        """The law of the chosen ones of the c rows."""

    def at(self, phases: Array) -> FlankAt:
        """The law at P phases; phases : (P, D) of all mesh tones [cycles]."""

    def lower(self) -> FlankLaw | None:
        """The same law as one that compiled integrators know (linear, tabulated), None where there is none.

        A law without one is integrated with NumPy.
        """


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawRows:
    """A law and the numbers (c,) of its rows among all."""

    law: FlankLaw
    rows: Index

    def __repr__(self) -> str:
        """One line: the law and how many rows follow it."""
        return f"LawRows({self.law!r} of {len(self.rows)} rows)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearLaw:
    """Linear flanks.

    stiffness : (c,) mean k0 [N/m].  variation : (c, L) complex, per mean, over the phase of the tone, leads contained.
    tone : (c,) mesh tone of each.
    """

    stiffness: Array
    variation: NDArray[np.complex128]
    tone: Index

    def __repr__(self) -> str:
        """One line: number of rows and orders."""
        return f"LinearLaw({len(self.stiffness)} rows, {self.variation.shape[1]} orders)"

    @property
    def stiffest(self) -> Array:
        """Bound of the stiffness (c,) [N/m]: all orders in phase."""
        return np.asarray(self.stiffness * (1 + np.abs(self.variation).sum(axis=1)))

    @property
    def end(self) -> Array:
        """No end (c,): inf [N]."""
        return np.full(self.stiffness.size, np.inf)

    @property
    def load(self) -> Array:
        """Not known (c,): nan [N]; the tangent is the same at every load."""
        return np.full(self.stiffness.size, np.nan)

    def rows(self, chosen: Any) -> LinearLaw:
        """The law of the chosen rows."""
        return replace(self, stiffness=self.stiffness[chosen], variation=self.variation[chosen], tone=self.tone[chosen])

    def at(self, phases: Array) -> LinearAt:
        """Stiffness at phases (P, D) [cycles]."""
        result = np.empty((len(phases), self.stiffness.size))
        orders = np.arange(1, self.variation.shape[1] + 1)
        for tone in set(self.tone.tolist()):
            rows = self.tone == tone
            wave = np.exp(2j * np.pi * np.outer(phases[:, tone], orders))
            relative = 1 + (wave @ self.variation[rows].T).real
            result[:, rows] = self.stiffness[rows] * np.maximum(relative, LEAST)
        return LinearAt(stiffness=result)

    def lower(self) -> LinearLaw:
        """Itself."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearAt:
    """Linear flanks of stiffness (P, c) [N/m] at P phases."""

    stiffness: Array

    @property
    def touch(self) -> Array:
        """Zero (P, c) [m]."""
        return np.zeros_like(self.stiffness)

    @property
    def kinks(self) -> Array:
        """First touch (P, c, 1) [m]."""
        return self.touch[:, :, None]

    def instants(self, chosen: Any) -> LinearAt:
        """The same at the chosen phases."""
        return LinearAt(stiffness=self.stiffness[chosen])

    def rows(self, chosen: Any) -> LinearAt:
        """The same of the chosen rows."""
        return LinearAt(stiffness=self.stiffness[:, chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m]."""
        return self.stiffness * np.maximum(delta, 0.0), np.where(delta > 0, self.stiffness, 0.0)

    def energy(self, delta: Array) -> Array:
        """k <delta>^2 / 2, (..., P, c) [J]."""
        return np.asarray(self.stiffness * np.maximum(delta, 0.0) ** 2 / 2)

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether a row stays closed, or open, over the gaps low .. high (c,) [m]."""
        return (low > 0) | (high <= 0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TabulatedLaw:
    """Flanks of one table, which differ in their phases alone.

    tone : (c,) mesh tone of each row.  lead, sense : (c,) sigma = sense (cycles + lead).
    force : (L,) from zero up [N].  gap : (S, L) delta at sigma = 0, 1/S, ... [m].  slope : (S, L) [N/m].
    load : (c,) at which the tangent of a row was taken [N]; nan where it is not known.
    last : force up to which all phases have data, where less than the last one [N].
    """

    tone: Index
    lead: Array
    sense: Array
    force: Array
    gap: Array
    slope: Array
    load: Array
    last: float = np.inf

    def __repr__(self) -> str:
        """One line: number of rows, size of the table and largest force."""
        phases, loads = self.gap.shape
        return f"TabulatedLaw({len(self.lead)} rows, {phases} phases x {loads} loads up to {self.force[-1]:.4g} N)"

    @property
    def stiffest(self) -> Array:
        """Largest tangent (c,) [N/m] at the tabulated phases.

        The tangent of a cubic is a parabola over its cell, with the slopes at both ends and the secant as its mean.
        """
        secant = np.diff(self.force) / np.diff(self.gap, axis=1)
        first, last = self.slope[:, :-1], self.slope[:, 1:]
        bend, rise = 3 * (first + last - 2 * secant), 2 * (3 * secant - 2 * first - last)
        with np.errstate(divide="ignore", invalid="ignore"):
            crest = -rise / (2 * bend)
            top = np.where((bend < 0) & (crest > 0) & (crest < 1), first - rise**2 / (4 * bend), 0.0)
        return np.full(len(self.lead), max(float(self.slope.max()), float(top.max())))

    @property
    def end(self) -> Array:
        """Last force of the table (c,) [N]."""
        return np.full(len(self.lead), min(self.force[-1], self.last))

    def rows(self, chosen: Any) -> TabulatedLaw:
        """The law of the chosen rows."""
        return replace(
            self,
            tone=self.tone[chosen],
            lead=self.lead[chosen],
            sense=self.sense[chosen],
            load=self.load[chosen],
        )

    def at(self, phases: Array) -> TabulatedAt:
        """Curves at phases (P, D) [cycles]."""
        sigma = np.mod(self.sense * (phases[:, self.tone] + self.lead), 1.0)
        cubics, S, L = _cubics(self), len(self.gap), len(self.force)
        cell = np.minimum((S * sigma).astype(np.int64), S - 1)
        since = (sigma - cell / S)[..., None]
        steps = cubics[0][cell]
        for power in cubics[1:]:
            steps = steps * since + power[cell]
        gap = np.cumsum(steps[..., :L], axis=-1)
        return TabulatedAt(gap=gap, force=np.broadcast_to(self.force, gap.shape), slope=steps[..., L:])

    def lower(self) -> TabulatedLaw:
        """Itself."""
        return self


def phase_cubics(law: TabulatedLaw) -> Array:
    """Cubics (S, 2 L, 4) of a table over the phase, the highest power first [m, N/m].

    In the cell sigma = (i + u) / S, 0 <= u < 1, they give in powers of u / S: first touch, the increments of the gap
    from force to force, and the slopes.
    """
    return np.ascontiguousarray(np.moveaxis(_cubics(law), 0, -1))


@lru_cache(maxsize=64)
def _cubics(law: TabulatedLaw) -> Array:
    """`phase_cubics` power by power (4, S, 2 L), kept with the law: an integrator asks it at every stage."""
    from scipy.interpolate import PchipInterpolator  # half a second, for tables alone

    # increments that are positive stay positive between phases
    steps = np.hstack([law.gap[:, :1], np.diff(law.gap, axis=1), law.slope])
    S = len(steps)
    around = np.arange(-_AROUND, S + _AROUND + 1)
    cubics = PchipInterpolator(around / S, steps[around % S]).c
    return np.ascontiguousarray(cubics[:, _AROUND : _AROUND + S])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TabulatedAt:
    """Tabulated flanks at P phases: gap [m], force [N] and slope [N/m] at the knots, (P, c, L) each."""

    gap: Array
    force: Array
    slope: Array

    @property
    def touch(self) -> Array:
        """First touch (P, c) [m]."""
        return self.gap[:, :, 0]

    @property
    def kinks(self) -> Array:
        """First touch (P, c, 1) [m]; between knots and beyond the last one the tangent is continuous."""
        return self.gap[:, :, :1]

    def instants(self, chosen: Any) -> TabulatedAt:
        """The same at the chosen phases."""
        return TabulatedAt(gap=self.gap[chosen], force=self.force[chosen], slope=self.slope[chosen])

    def rows(self, chosen: Any) -> TabulatedAt:
        """The same of the chosen rows."""
        return TabulatedAt(gap=self.gap[:, chosen], force=self.force[:, chosen], slope=self.slope[:, chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m]."""
        force, slope, width, t, _ = self._cells(delta)
        value, rate = cubic(force, slope, width, t)
        beyond = np.maximum(delta - self.gap[:, :, -1], 0.0)
        open_ = delta <= self.gap[:, :, 0]
        return np.where(open_, 0.0, value + beyond * self.slope[:, :, -1]), np.where(open_, 0.0, rate)

    def energy(self, delta: Array) -> Array:
        """Integral of the force from first touch, (..., P, c) [J]."""
        force, slope, width, t, cell = self._cells(delta)
        before = energy_before(self.gap, self.force, self.slope)
        energy = before.ravel().take(self._flat(cell)) + cubic_energy(force, slope, width, t)
        beyond = np.maximum(delta - self.gap[:, :, -1], 0.0)
        energy += beyond * (self.force[:, :, -1] + beyond * self.slope[:, :, -1] / 2)
        return np.where(delta <= self.gap[:, :, 0], 0.0, energy)

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether a row stays open, or on a straight part of the table, over the gaps low .. high (c,) [m]."""
        first, last = self.gap[:, :, :-1], self.gap[:, :, 1:]
        used = (last > low[:, None]) & (first < high[:, None])
        used[:, :, -1] |= high > self.gap[:, :, -1]
        secant = np.diff(self.force, axis=2) / (last - first)
        ends = np.stack([secant, self.slope[..., :-1], self.slope[..., 1:]])
        most = np.where(used, ends.max(axis=0), -np.inf).max(axis=2)
        least = np.where(used, ends.min(axis=0), np.inf).min(axis=2)
        straight = (low > self.touch) & (most - least <= STRAIGHT * np.maximum(most, 0.0))
        return np.asarray(((high <= self.touch) | straight).all(axis=0))

    def _cells(self, delta: Array) -> tuple[tuple[Array, Array], tuple[Array, Array], Array, Array, Index]:
        """Forces and slopes at both ends of the cell of each gap (..., P, c), width, place in it, and number of it."""
        cell = np.clip((delta[..., None] >= self.gap).sum(axis=-1) - 1, 0, self.gap.shape[2] - 2)
        first = self._flat(cell)

        def ends(values: Array) -> tuple[Array, Array]:
            flat = values.ravel()
            return flat.take(first), flat.take(first + 1)

        (x0, x1), force, slope = ends(self.gap), ends(self.force), ends(self.slope)
        width = x1 - x0
        return force, slope, width, np.clip((delta - x0) / width, 0.0, 1.0), cell

    def _flat(self, cell: Index) -> Index:
        """Places of cells (..., P, c) in the flattened knots (P, c, L)."""
        P, c, L = self.gap.shape
        return np.asarray(cell + L * np.arange(P * c).reshape(P, c))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Blended:
    """A share [0 .. 1] of a law, the rest linear, at P phases."""

    linear: LinearAt
    law: FlankAt
    share: float

    @property
    def touch(self) -> Array:
        """The earlier of both first touches (P, c) [m]."""
        return np.minimum(self.linear.touch, self.law.touch)

    @property
    def kinks(self) -> Array:
        """Kinks of both (P, c, K) [m]."""
        return np.concatenate([self.linear.kinks, self.law.kinks], axis=2)

    def instants(self, chosen: Any) -> Blended:
        """The same at the chosen phases."""
        return replace(self, linear=self.linear.instants(chosen), law=self.law.instants(chosen))

    def rows(self, chosen: Any) -> Blended:
        """The same of the chosen rows."""
        return replace(self, linear=self.linear.rows(chosen), law=self.law.rows(chosen))

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m]."""
        linear_force, linear_tangent = self.linear.evaluate(delta)
        law_force, law_tangent = self.law.evaluate(delta)
        force = (1 - self.share) * linear_force + self.share * law_force
        return force, (1 - self.share) * linear_tangent + self.share * law_tangent

    def energy(self, delta: Array) -> Array:
        """Energy (..., P, c) [J] at gaps delta [m]."""
        return (1 - self.share) * self.linear.energy(delta) + self.share * self.law.energy(delta)

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether both tangents keep one value over the gaps low .. high (c,) [m]."""
        return self.linear.constant(low, high) & self.law.constant(low, high)


def eased(law: FlankAt, mean: Array, share: float) -> FlankAt:
    """A law with a share of its variation and curvature, the rest linear with the mean stiffness (c,) [N/m]."""
    if isinstance(law, LinearAt):
        return LinearAt(stiffness=mean + share * (law.stiffness - mean))
    return Blended(linear=LinearAt(stiffness=np.broadcast_to(mean, law.touch.shape)), law=law, share=share)


# along the face -------------------------------------------------------------------------------------------------------

# rows of a mesh
ROWS = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceForce:
    """Forces of g meshes at t instants.

    force : (t, g, 3) of the rows [N].  tangent : (t, g, 3, 3) its derivative [N/m], symmetric.  energy : (t, g) [J].
    residual : (t, g) of the contact conditions [1].  state : (t, g, n) start of a later call [m].
    """

    force: Array
    tangent: Array
    energy: Array
    residual: Array
    state: Array


class FaceContact(Protocol):
    """Tooth contact of some meshes at T instants."""

    def press(self, rows: Array, instants: Index, start: Array | None) -> FaceForce:
        """Forces at given approaches.

        rows : (t, g, 3) approach of every row, positive closes it [m].  instants : (t,) among the T.
        start : state of a near call, at the same instants.
        """
