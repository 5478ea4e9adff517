"""Rows of gaps of the harmonic balance with contact loss, in modal coordinates, and their laws over a grid of phases.

The alternating frequency/time method goes between amplitudes at lattice points and values on the grid.  A real signal
of D phases is x(theta) = Re sum_a X_a exp(2 pi i a . theta) over lattice points a [cameron1989; krack2019].  Amplitudes
stand as real rows (2 J, c): real parts of J points, then imaginary parts, the mean first.  Values stand as (N, c) over
the samples of the grid, the last phase fastest.

Edges of contact are samples of a cycle about an instant at which a flank meets or leaves its mate.  Between the samples
before and after, the gap changes by d- and d+.  About a sample it runs through a width w around its value delta above
first touch: the flank is closed for the part a = 1/2 + delta / w of it, all or none beyond, with the mean penetration
d = a w / 2, delta where it is closed throughout:

    f = a f(d) - k w B(delta / w) / 24,    w^2 = (d-^2 + d+^2) / 2

Taken at samples alone, the force would have a corner in the motion wherever first touch passes a sample, and a damper a
jump; so its derivative is continuous, also where a gap only grazes first touch.  The means over the width of all
samples sum to k w^2 / 24 more than the integral of a force of tangent k at first touch: that is taken off again, in
parts B, the quadratic B-spline, over the three samples nearest to first touch.  Away from edges the force is that of
the sample (derived here).

Rows of a balance are the F flanks (`system.gaps`), then the rows of link groups with a law, then one diagonal row a
pair of rows of a group.  A tangent of a group, a symmetric block, is a sum over its rows and diagonals, of two rows
with d = x + y

    K = (kxx - kxy) x x' + (kyy - kxy) y y' + kxy d d'

and of more with d = h_i x_i + h_j x_j for every pair, k_ij / (h_i h_j) in place of kxy.  So tangents of all rows are
numbers (derived here); h, the root of the nominal stiffness of a row per that of the first one, gives moments the size
of forces.  The mean system holds the stiffness `linear` of every row.  Friction with a memory sticks in small vibration
and stays in the mean system.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...statics.record import group_gap
from ...statics.tangent import mean_stretch, small_motion_tangent
from ...system.flank_laws import eased
from ...system.gaps import Flanks, FlanksAt, Rows, contiguous, flanks
from ...system.link_laws import Laws, stacked
from ...system.system import Array, ComplexArray, Index, Line, System
from ...warning_codes import CodedText, coded
from ..response.lattice import Point, kept_points, leads
from ..response.response import Response
from ..response.spectra import PlacedLine

# Phases in one product with the lattice points: bounds the memory of a (phases, 2 J) matrix.
_BATCH = 2048
# Half the support of the spline B, in widths.
_REACH = 1.5


# --- lattice points ---------------------------------------------------------------------------------------------------


class Size(NamedTuple):
    """Rows of a torus: harmonics of each mesh tone, order of their combinations, highest order of each shaft tone."""

    harmonics: tuple[int, ...]
    cross: int
    orders: tuple[int, ...]


def mesh_points(size: Size) -> Index:
    """Lattice points (J, D) of the D mesh tones alone."""
    return torus_points(size._replace(orders=()))


def torus_points(size: Size) -> Index:
    """Lattice points (J, D) of mesh and shaft tones, one of a and -a, the origin first.

    Mesh points as of `kept_points`, each with all shaft orders |s_1| / H_1 + |s_2| / H_2 + .. <= 1 (derived here).
    """
    mesh = kept_points(size.harmonics, size.cross, mirrored=False).points.tolist()
    reach = product(*(range(-order, order + 1) for order in size.orders))
    of_shafts = [orders for orders in reach if order_weight(orders, size.orders) <= 1]
    return half_lattice([(*a, *s) for a in mesh for s in of_shafts])


def order_weight(point: tuple[int, ...], orders: tuple[int, ...]) -> float:
    """|s_1| / H_1 + |s_2| / H_2 + .. of shaft orders (S,) and their highest (S,), without its rounding."""
    return round(sum(abs(s) / order for s, order in zip(point, orders, strict=True)), 9)


def half_lattice(points: Sequence[Point]) -> Index:
    """The points (J, D) of a lattice that stand for a real signal: one of a and -a, the origin first."""
    leading = [point for point in points if leads(point)]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def placed_line(point: Point, line: Line) -> PlacedLine:
    """A line at the point a, or as its conjugate at -a, whichever half of the lattice holds."""
    return (point, False, line) if leads(point) else (tuple(-a for a in point), True, line)


# --- transforms -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Transforms of phases: one matrix along the first phase, one along all others together.

    points : (J, D) orders, the first one never below 0, the origin first.  counts : (D,) samples of each phase, more
    than twice the highest order.
    take : (J,) place of each point in a box of S rests (orders of the other phases) times H + 1 first orders.
    turn : (2 Ns, 2 S), unturn : (2 S, 2 Ns) between rests and the Ns samples of the other phases, re and im apart.
    wave : (N_1, 2 H + 2), back : (2 H + 2, N_1) along the first phase; of one phase, (N, 2 J) and (2 J, N), at its
    points, between rows and values.
    """

    points: Index
    counts: tuple[int, ...]
    take: Index
    turn: Array
    unturn: Array
    wave: Array
    back: Array

    def values(self, rows: Array) -> Array:
        """Values (N, c) of rows (2 J, c)."""
        if len(self.counts) == 1:
            return self.wave @ rows
        orders, columns = self.wave.shape[1] // 2, rows.shape[1]
        if not columns:
            return np.zeros((len(self.wave) * len(self.turn) // 2, 0))
        box = np.zeros((2, len(self.unturn) // 2 * orders, columns))
        box[:, self.take] = rows.reshape(2, -1, columns)
        turned = self.turn @ box.reshape(self.turn.shape[1], -1)
        folded = turned.reshape(-1, 2, orders, columns).transpose(1, 2, 0, 3).reshape(2 * orders, -1)
        return (self.wave @ folded).reshape(-1, columns)

    def rows(self, values: Array) -> Array:
        """Rows (2 J, c) of values (N, c); orders that are no lattice points are dropped."""
        if len(self.counts) == 1:
            return self.back @ values
        orders, columns = self.wave.shape[1] // 2, values.shape[1]
        if not columns:
            return np.zeros((2 * len(self.points), 0))
        along = self.back @ values.reshape(len(self.wave), -1)
        turned = along.reshape(2, orders, -1, columns).transpose(2, 0, 1, 3).reshape(self.turn.shape[0], -1)
        box = (self.unturn @ turned).reshape(2, -1, columns)
        projected: Array = box[:, self.take]
        projected[0, 0] /= 2
        projected[1, 0] = 0
        return projected.reshape(-1, columns)

    def at(self, phases: Array, rows: Array) -> Array:
        """Values (T, c) of rows (2 J, c) at any phases (T, D) [cycles]."""
        batches = list[Array]()
        for part in np.array_split(phases, -(-len(phases) // _BATCH)):
            wave = np.ones((len(part), len(self.points)), complex)
            for phase, orders in zip(part.T, self.points.T, strict=True):
                # one exponential an order of a tone, not one a lattice point
                of_tone, place = np.unique(orders, return_inverse=True)
                wave *= np.exp(2j * np.pi * np.outer(phase, of_tone))[:, place]
            batches.append(np.concatenate([wave.real, -wave.imag], axis=1) @ rows)
        return np.concatenate(batches)


def grid(points: Index, counts: tuple[int, ...]) -> Grid:
    """Transforms of lattice points (J, D) on a grid of (D,) samples."""
    rests, which = np.unique(points[:, 1:], axis=0, return_inverse=True)
    first = points[:, 0] if len(counts) == 1 else np.arange(int(points[:, 0].max(initial=0)) + 1)
    angle = 2 * np.pi * phases_of(counts[1:]) @ rests.T
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.stack([np.hstack([cos, -sin]), np.hstack([sin, cos])], axis=1).reshape(2 * len(angle), -1)
    fast = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], first)
    wave = np.concatenate([np.cos(fast), -np.sin(fast)], axis=1)
    back = np.ascontiguousarray(wave.T) * (2 / (counts[0] * len(angle)))
    if len(counts) == 1:  # half of the mean, and no imaginary part of it
        back[0] /= 2
        back[first.size] = 0
    return Grid(
        points=points,
        counts=counts,
        take=which.ravel() * first.size + points[:, 0],
        turn=turn,
        unturn=np.ascontiguousarray(turn.T),
        wave=wave,
        back=back,
    )


def phases_of(counts: tuple[int, ...]) -> Array:
    """Phases (N, D) of the samples of a grid [cycles], the last one fastest."""
    return np.asarray(np.indices(counts).reshape(len(counts), math.prod(counts)).T / np.array(counts))


# --- edges of contact -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WidthTangents:
    """How forces at the edges depend on the gaps of three samples by the width.

    at : (E,) sample and (E,) row of each edge.  samples : (3, E) before, at and after it.  tangent : (3, E) [N/m].
    """

    at: tuple[Index, Index]
    samples: Index
    tangent: Array

    def forces(self, gap: Array) -> Array:
        """Changes of the forces at the edges (E,) [N] with gaps (N, R) [m]."""
        return np.asarray((self.tangent * gap[self.samples, self.at[1]]).sum(axis=0))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """Edges among the samples of some flanks.

    at : (E,) sample and (E,) column.  samples : (3, E) before, at and after it.  width : w (E,) [m].
    place : delta / w (E,).  share : a (E,).  inside : (E,) whether first touch is within the width.
    turn : (3, E) change of the width with the gaps of the samples.  spline, slope : (E,) B and its derivative.
    """

    at: tuple[Index, Index]
    samples: Index
    width: Array
    place: Array
    share: Array
    inside: NDArray[np.bool_]
    turn: Array
    spline: Array
    slope: Array

    def enter_penetration(self, delta: Array, closed: Array) -> None:
        """Enter the mean penetration into gaps (N, c) [m]; closed : (N, c) above first touch."""
        rise = self.width * self.share / 2 - closed[self.at]
        delta[self.at] += np.where(self.inside, rise, 0.0)

    def enter_means(self, force: Array, tangent: Array, first: Array) -> Array:
        """Enter mean forces [N] and tangents [N/m] into those at the mean penetration (N, c).

        first : (N, c) tangents at first touch [N/m].  Returns the change of the forces with the width (E,) [N/m].
        """
        f, k, a, w, excess = force[self.at], tangent[self.at], self.share, self.width, first[self.at] / 24
        force[self.at] = a * f - excess * w * self.spline
        tangent[self.at] = np.where(self.inside, f / w + a * k / 2, k) - excess * self.slope
        by_width = np.where(self.inside, a * k / 4 - (a - 0.5) * f / w, 0.0)
        return by_width - excess * (self.spline - self.place * self.slope)

    def tangents(self, change: Array, rows: Index) -> WidthTangents:
        """Tangents by the width, from the change of forces with it (E,) [N/m]; rows : (c,) of the columns."""
        return WidthTangents(at=(self.at[0], rows[self.at[1]]), samples=self.samples, tangent=change * self.turn)


def edges(closed: Array, counts: tuple[int, ...], axis: Index) -> Edges | None:
    """Edges of gaps above first touch (N, c) [m] over a grid, the last phase fastest; None where there is none.

    Parameters
    ----------
    counts : (D,) samples of each phase.  axis : (c,) phase that each column follows.
    """
    flat_before, flat_after = _beside(counts, tuple(axis.tolist()))
    fall, rise = closed - closed.take(flat_before), closed.take(flat_after) - closed
    flat = np.flatnonzero(fall * fall + rise * rise > 2 / _REACH**2 * closed * closed)
    if not flat.size:
        return None
    sample, column = np.divmod(flat, closed.shape[1])
    middle, fall, rise = (values.take(flat) for values in (closed, fall, rise))
    before, after = flat_before.take(flat), flat_after.take(flat)
    width = np.sqrt((fall * fall + rise * rise) / 2)
    fall, rise = fall / (2 * width), rise / (2 * width)
    place = middle / width
    inside = np.abs(place) < 0.5
    outer = np.abs(place) - _REACH
    return Edges(
        at=(sample, column),
        samples=np.stack([before // closed.shape[1], sample, after // closed.shape[1]]),
        width=width,
        place=place,
        share=np.clip(0.5 + place, 0.0, 1.0),
        inside=inside,
        turn=np.stack([-fall, fall - rise, rise]),
        spline=np.where(inside, 0.75 - place * place, outer * outer / 2),
        slope=np.where(inside, -2 * place, np.sign(place) * outer),
    )


@lru_cache(maxsize=64)
def _beside(counts: tuple[int, ...], axis: tuple[int, ...]) -> tuple[Index, Index]:
    """Flat places in (N, c) of the samples before and after each, along the phase of each column."""
    samples, c = np.arange(int(np.prod(counts))).reshape(counts), len(axis)
    both = np.empty((2, samples.size, c), np.int64)
    for column, phase in enumerate(axis):
        for place, shift in enumerate((1, -1)):
            both[place, :, column] = np.roll(samples, shift, axis=phase).ravel() * c + column
    return both[0], both[1]


# Penetration that is a touch and no more [m].
_JUST = 1e-12

NO_TORQUE = "no torque presses the teeth together (operation.torque or operation.power)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinkRowLaws:
    """Laws of the L rows of link groups, friction with a memory left out.

    laws : of their groups.  rows : (L,) among all rows of groups of the System.  pairs : (P, 2) every two rows, among
    the L, of one group.  diagonals : (L, P) h of these two, 0 of others.
    tangent : (L, L) at the mean load [N/m].  offset : (L,) force less tangent times stretch there [N].
    part : of the laws; the rest follows that tangent.
    """

    laws: Laws
    rows: Index
    pairs: Index
    diagonals: Array
    tangent: Array
    offset: Array
    part: float = 1.0

    def tangents(self, block: Array) -> Array:
        """Tangents (..., L + P) [N/m] along rows and diagonals of blocks (..., L, L)."""
        x, y = self.pairs.T
        columns = np.arange(x.size)
        across = block[..., x, y] / (self.diagonals[x, columns] * self.diagonals[y, columns])
        along = np.diagonal(block, axis1=-2, axis2=-1) - across @ (self.diagonals**2).T
        return np.concatenate([along, across], axis=-1)

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force (N, L) [N] and tangents (N, L + P) [N/m] at stretches (N, L) [m]."""
        force, block = self.force(delta), self.laws.tangent(delta)
        if self.part < 1:
            block = self.part * block + (1 - self.part) * self.tangent
        return force, self.tangents(block)

    def force(self, delta: Array) -> Array:
        """Force (N, L) [N] at stretches (N, L) [m]."""
        force = self.laws.force(delta)
        if self.part < 1:
            force = self.part * force + (1 - self.part) * (delta @ self.tangent + self.offset)
        return force


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GapRows:
    """The R rows of a balance: F flanks, L rows of link groups, P diagonal rows.

    flanks : rows of flanks with their laws.  links : laws of the link rows, None without.
    gaps, pulls : (R, n) as of `Modal`.  linear : (R,) stiffness in the mean system [N/m].
    damping : (F,) of the flanks, where they press, and drag : (F,) in the mean system [N s/m].
    lag : (R,) damper per tangent of link rows [s], 0 of flanks.
    axis : (F,) phase of each flank.  phases : (T,) phase of every mesh tone of the System.
    """

    flanks: Flanks
    links: LinkRowLaws | None
    gaps: Array
    pulls: Array
    linear: Array
    damping: Array
    drag: Array
    lag: Array
    axis: Index
    phases: Index

    @property
    def count(self) -> int:
        """Number F of flanks."""
        return int(self.flanks.mesh.size)

    @property
    def parametric(self) -> bool:
        """Whether a motion that keeps its contact is that of a linear system with parametric stiffness."""
        return self.links is None and self.flanks.parametric

    def at(self, phases: Array) -> FlanksAt:
        """Laws of the flanks at phases (P, D) of the tones of the balance [cycles]."""
        return self.flanks.at(phases[:, self.phases])


@lru_cache(maxsize=4)
def gap_rows_of(ready: Response) -> GapRows:
    """The rows of a System ready for its response, made once: every problem of it has them."""
    modal, system = ready.modal, ready.system
    table = flanks(ready.lawful)
    links = _link_rows(ready.lawful)
    m, far = len(system.meshes.name), table.mesh[len(system.meshes.name) :]
    B, linear, lag = table.B[:, m:], table.linear, np.zeros(table.mesh.size)
    if links is not None:
        groups, columns = ready.lawful.groups, ready.lawful.group_rows[:, links.rows]
        B = np.concatenate([B, columns, columns @ links.diagonals], axis=1)
        lags = np.repeat([group.lag for group in groups], [len(group.rows) for group in groups])[links.rows]
        linear, lag = (
            np.append(linear, links.tangents(links.tangent)),
            np.concatenate([lag, lags, lags[links.pairs[:, 0]]]),
        )
    gaps, pulls = B.T @ modal.shapes, (modal.forces @ B).T
    gaps[:, modal.rigid] = pulls[:, modal.rigid] = 0.0
    tones = list(ready.lines.tones)
    return GapRows(
        flanks=table,
        links=links,
        gaps=np.concatenate([modal.gaps, gaps]),
        pulls=np.concatenate([modal.pulls, pulls]),
        linear=linear,
        damping=table.damping,
        drag=np.where(table.sense > 0, table.damping, 0.0),
        lag=lag,
        axis=np.concatenate([ready.lines.axis, ready.lines.axis[far]]),
        phases=np.array([tones.index(tone) if tone in tones else 0 for tone in system.tones], np.int64),
    )


def _link_rows(system: System) -> LinkRowLaws | None:
    """Laws of the link groups without a memory; None where there are none."""
    every = system.laws
    groups = [group for group, memory in zip(system.groups, every.memory, strict=True) if not memory]
    if not groups:
        return None
    rows, laws = np.flatnonzero(~every.row_memory), stacked(groups)
    owner, stiffness = laws.rows.owner, laws.row_stiffness
    pairs = np.argwhere(np.triu(owner[:, None] == owner, 1))
    size = np.sqrt(stiffness / stiffness[laws.rows.first][owner])
    diagonals = np.zeros((owner.size, len(pairs)))
    diagonals[pairs, np.arange(len(pairs))[:, None]] = size[pairs]
    stretch = mean_stretch(system)
    tangent = small_motion_tangent(every, stretch, floating=True)
    return LinkRowLaws(
        laws=laws,
        rows=rows,
        pairs=pairs,
        diagonals=diagonals,
        tangent=tangent[np.ix_(rows, rows)],
        offset=(every.force(stretch) - tangent @ stretch)[rows],
    )


def law_warnings(ready: Response, rows: GapRows) -> list[CodedText]:
    """Warnings of the System as it is prepared for its laws (`statics.tangent`)."""
    held = rows.links is None or bool(rows.gaps[rows.count :].any())
    loose = coded("floats-in-clearance", "no link row moves: the bodies float in their clearance under the mean load")
    notes = [*ready.system.warnings, *([] if held else [loose])]
    if not ready.system.force.any():
        notes.append(coded("no-torque", f"{NO_TORQUE}: contact is that of teeth without a load"))
    return notes


def largest_link_forces(system: System, rows: GapRows, force: Array) -> Array:
    """Largest force of every link group (G,) [N, N m], of forces of all rows (N, R); 0 of those with a memory."""
    result = np.zeros(len(system.groups))
    if rows.links is not None:
        of_links = force[:, rows.count : rows.count + rows.links.rows.size]
        result[~system.laws.memory] = rows.links.laws.rows.size(of_links).max(axis=0)
    return result


def with_diagonals(rows: GapRows, force: ComplexArray | Array) -> Any:
    """Forces of flanks and link rows (N, F + L) [N], those of diagonal rows (N, R) put on their pairs."""
    last = rows.count + (0 if rows.links is None else rows.links.rows.size)
    result, diagonal = force[:, :last].copy(), force[:, last:]
    if rows.links is not None:
        result[:, rows.count :] += diagonal @ rows.links.diagonals.T
    return result


@lru_cache(maxsize=4)
def reported_links(ready: Response) -> tuple[System, Index]:
    """The linear System with link rows named as in results, and which (L,) of them are the link rows of the balance.

    Rows of groups that follow their laws have their own names, along x and y; those with a memory are linear.
    """
    system, lawful = ready.system, ready.lawful
    names, follows, at = list(system.links.name), list[int](), len(lawful.links.name)
    for group, memory in zip(lawful.groups, lawful.laws.memory, strict=True):
        rows = range(at, at := at + len(group.rows))
        if not memory:
            names[rows.start : rows.stop] = group.rows
            follows += rows
    return replace(system, links=replace(system.links, name=tuple(names))), np.array(follows, dtype=np.int64)


def line_gaps(ready: Response, rows: GapRows, line: Line) -> ComplexArray:
    """Errors (R,) [m] of a line in every row, without the opening of far flanks."""
    of_flanks = ready.system.flank_gaps(line)
    if rows.links is None:
        return of_flanks
    lawful = next((each for each in ready.lawful.lines if each.frequency == line.frequency), None)
    size = ready.lawful.group_rows.shape[1]
    error = np.zeros(size, complex) if lawful is None else group_gap(lawful, size)
    error = error[rows.links.rows]
    return np.concatenate([of_flanks, error, error @ rows.links.diagonals])


# --- laws over a grid -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class GridLaws:
    """Laws of F flanks over N samples of a grid, the last phase fastest; none is spread over the other phases.

    parts : of each phase that flanks follow the laws at its samples, which of the F columns they are, and the phase.
    counts : (D,) samples of each phase.  count : F.  made : laws of some of the flanks.
    """

    parts: tuple[tuple[FlanksAt, Rows, int], ...]
    counts: tuple[int, ...]
    count: int
    made: dict[bytes, GridLaws] = field(default_factory=dict)

    @cached_property
    def touches(self) -> tuple[Array, ...]:
        """First touch of the flanks of each part at its samples (P, c) [m]."""
        return tuple(laws.touch for laws, _, _ in self.parts)

    @cached_property
    def least_touch(self) -> Array:
        """Least gap at which each flank touches (F,) [m]."""
        return np.asarray(-self.opening(np.zeros((math.prod(self.counts), self.count))).max(axis=0))

    def of(self, chosen: NDArray[np.bool_]) -> GridLaws:
        """The laws of some of the flanks (F,), which become the columns."""
        key, place = chosen.tobytes(), np.cumsum(chosen) - 1
        if key not in self.made:
            kept = [(laws.rows(chosen[at]), contiguous(place[at][chosen[at]]), axis) for laws, at, axis in self.parts]
            self.made[key] = replace(self, parts=tuple(kept), count=int(chosen.sum()), made={})
        return self.made[key]

    @cached_property
    def first_tangent(self) -> Array:
        """Tangent of each flank where it has just touched (N, F) [N/m]."""
        return self.evaluate(_JUST - self.opening(np.zeros((math.prod(self.counts), self.count))))[1]

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] of all flanks at gaps (N, F) [m], each (N, F)."""
        force, tangent = np.empty_like(delta), np.empty_like(delta)
        for laws, columns, axis in self.parts:
            of_part = laws.evaluate(self._own(delta[:, columns], axis))
            force[:, columns], tangent[:, columns] = (self._back(values, axis) for values in of_part)
        return force, tangent

    def opening(self, delta: Array) -> Array:
        """delta less first touch (N, F) [m]: a flank presses where it is above zero."""
        result = np.empty_like(delta)
        for touch, (_, columns, axis) in zip(self.touches, self.parts, strict=True):
            result[:, columns] = self._back(self._own(delta[:, columns], axis) - touch, axis)
        return result

    def constant(self, low: Array, high: Array) -> bool:
        """Whether every tangent keeps one value at each phase over the gaps low .. high (F,) [m]."""
        return all(bool(laws.constant(low[columns], high[columns]).all()) for laws, columns, _ in self.parts)

    def eased(self, mean: Array, part: float) -> GridLaws:
        """The laws with a part of their variation and curvature, the rest linear with the mean stiffness (F,) [N/m]."""
        parts = []
        for laws, columns, axis in self.parts:
            own = tuple((eased(law, mean[columns][rows], part), rows) for law, rows in laws.parts)
            parts.append((replace(laws, parts=own), columns, axis))
        return replace(self, parts=tuple(parts), made={})

    def _own(self, values: Array, axis: int) -> Array:
        """Values (N, c) with the own phase next to the last axis, (..., P, c)."""
        return values if len(self.counts) == 1 else np.moveaxis(values.reshape(*self.counts, -1), axis, -2)

    def _back(self, values: Array, axis: int) -> Array:
        """Values (..., P, c) as (N, c) again."""
        return values if len(self.counts) == 1 else np.moveaxis(values, -2, axis).reshape(-1, values.shape[-1])


def grid_laws(rows: GapRows, counts: tuple[int, ...], *, cycles: int) -> GridLaws:
    """Laws of the flanks at the samples of a grid; cycles : mesh cycles in a period of its phases."""
    parts = []
    for axis in np.unique(rows.axis).tolist():
        columns = contiguous(rows.axis == axis)
        phases = np.zeros((counts[axis], len(counts)))
        phases[:, axis] = cycles * np.arange(counts[axis]) / counts[axis]
        parts.append((rows.at(phases).rows(columns), columns, axis))
    return GridLaws(parts=tuple(parts), counts=counts, count=rows.count)
