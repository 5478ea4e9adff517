"""Rows of gaps in modal coordinates, and their laws over a grid of phases.

Rows of a balance are the F flanks (`system.gaps`), then the rows of link groups with a law, then one diagonal row a
group of two.  A tangent of a group, a symmetric block of two rows, is a sum over three directions x, y, d = (x + y),

    K = (kxx - kxy) x x' + (kyy - kxy) y y' + kxy d d'

so that tangents of all rows are numbers (derived here).  The mean system holds the stiffness `linear` of every row.
Friction with a memory sticks in small vibration and stays in the mean system.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...statics.record import group_gap
from ...statics.tangent import mean_stretch, small_motion_tangent
from ...system.flank_laws import eased
from ...system.gaps import Flanks, FlanksAt, flanks
from ...system.link_laws import Laws, stacked
from ...system.system import Array, ComplexArray, Line, System
from ...warning_codes import CodedText, coded
from ..response.response import Response
from .transforms import contiguous

Index = NDArray[np.int64]

# Penetration that is a touch and no more [m].
_JUST = 1e-12

NO_TORQUE = "no torque presses the teeth together (operation.torque or operation.power)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinkRowLaws:
    """Laws of the L rows of link groups, friction with a memory left out.

    laws : of their groups.  rows : (L,) among all rows of groups of the System.  pairs : (P, 2) rows x and y, among the
    L, of the groups of two.
    tangent : (L, L) at the mean load [N/m].  offset : (L,) force less tangent times stretch there [N].
    part : of the laws; the rest follows that tangent.
    """

    laws: Laws
    rows: Index
    pairs: Index
    tangent: Array
    offset: Array
    part: float = 1.0

    def tangents(self, block: Array) -> Array:
        """Tangents (..., L + P) [N/m] along x, y and d of blocks (..., L, L)."""
        x, y = self.pairs.T
        result = np.concatenate([np.diagonal(block, axis1=-2, axis2=-1), block[..., x, y]], axis=-1)
        result[..., x] -= block[..., x, y]
        result[..., y] -= block[..., x, y]
        return result

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
    def sense(self) -> Array:
        """+1 of a loaded, -1 of a far flank, (F,)."""
        return self.flanks.sense

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
        groups, (x, y) = ready.lawful.groups, links.pairs.T
        columns = ready.lawful.group_rows[:, links.rows]
        B = np.concatenate([B, columns, columns[:, x] + columns[:, y]], axis=1)
        lags = np.repeat([group.lag for group in groups], [len(group.rows) for group in groups])[links.rows]
        linear, lag = np.append(linear, links.tangents(links.tangent)), np.concatenate([lag, lags, lags[x]])
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
    first = laws.rows.first[laws.rows.pair]
    stretch = mean_stretch(system)
    tangent = small_motion_tangent(every, stretch, floating=True)
    return LinkRowLaws(
        laws=laws,
        rows=rows,
        pairs=np.stack([first, first + 1], axis=1),
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


def line_gaps(ready: Response, rows: GapRows, line: Line) -> ComplexArray:
    """Errors (R,) [m] of a line in every row, without the opening of far flanks."""
    of_flanks = ready.system.flank_gaps(line)
    if rows.links is None:
        return of_flanks
    lawful = next((each for each in ready.lawful.lines if each.frequency == line.frequency), None)
    size = ready.lawful.group_rows.shape[1]
    error = np.zeros(size, complex) if lawful is None else group_gap(lawful, size)
    error = error[rows.links.rows]
    x, y = rows.links.pairs.T
    return np.concatenate([of_flanks, error, error[x] + error[y]])


# --- laws over a grid -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _AxisLaws:
    """Laws of some flanks that follow one phase, at its samples.

    columns : (c,) which of the F.  axis : the phase.  touch : (P, c) first touch [m]; None where all are zero.
    """

    laws: FlanksAt
    columns: Index
    axis: int
    touch: Array | None

    def chosen(self, columns: Index) -> _AxisLaws:
        """The same of some of the F columns."""
        places = np.flatnonzero(np.isin(self.columns, columns))
        if places.size == self.columns.size:
            return self
        pick = contiguous(places)
        return _AxisLaws(
            laws=self.laws.rows(pick),
            columns=self.columns[places],
            axis=self.axis,
            touch=None if self.touch is None else self.touch[:, pick],
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridLaws:
    """Laws of F flanks over N samples of a grid, the last phase fastest; none is spread over the other phases.

    counts : (D,) samples of each phase.  chosen : laws of some flanks, by their numbers, made on first use.
    made : `first_tangent`, made on first use.
    """

    parts: tuple[_AxisLaws, ...]
    counts: tuple[int, ...]
    count: int
    chosen: dict[bytes, GridLaws] = field(default_factory=dict)
    made: list[Array] = field(default_factory=list)

    @property
    def first_tangent(self) -> Array:
        """Tangent of each flank where it has just touched (N, F) [N/m]."""
        if not self.made:
            touched = _JUST - self.opening(np.zeros((math.prod(self.counts), self.count)))
            self.made.append(self.evaluate(touched)[1])
        return self.made[0]

    @property
    def least_touch(self) -> Array:
        """Least gap at which each flank touches (F,) [m]."""
        result = np.zeros(self.count)
        for part in self.parts:
            if part.touch is not None:
                result[part.columns] = part.touch.min(axis=0)
        return result

    def of(self, columns: Index) -> GridLaws:
        """The laws of some flanks (c,), rising numbers, which become the columns."""
        if columns.size == self.count:
            return self
        key = columns.tobytes()
        if key not in self.chosen:
            place = np.full(self.count, -1)
            place[columns] = np.arange(columns.size)
            kept = [part.chosen(columns) for part in self.parts]
            parts = tuple(replace(p, columns=place[p.columns]) for p in kept if p.columns.size)
            self.chosen[key] = GridLaws(parts=parts, counts=self.counts, count=columns.size)
        return self.chosen[key]

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] of all flanks at gaps (N, F) [m], each (N, F)."""
        if len(self.parts) == 1 and self.parts[0].columns.size == self.count:
            force, tangent = self.parts[0].laws.evaluate(self._own(delta, self.parts[0].axis))
            return self._back(force, self.parts[0].axis), self._back(tangent, self.parts[0].axis)
        force, tangent = np.zeros_like(delta), np.zeros_like(delta)
        for part in self.parts:
            of_part = part.laws.evaluate(self._own(delta[:, part.columns], part.axis))
            for values, along in zip((force, tangent), of_part, strict=True):
                values[:, part.columns] = self._back(along, part.axis)
        return force, tangent

    def opening(self, delta: Array) -> Array:
        """delta less first touch (N, F) [m]: a flank presses where it is above zero."""
        if all(part.touch is None for part in self.parts):
            return delta
        result = delta.copy()
        for part in self.parts:
            if part.touch is not None:
                opened = self._own(delta[:, part.columns], part.axis) - part.touch
                result[:, part.columns] = self._back(opened, part.axis)
        return result

    def constant(self, low: Array, high: Array) -> bool:
        """Whether every tangent keeps one value at each phase over the gaps low .. high (F,) [m]."""
        return all(bool(p.laws.constant(low[p.columns], high[p.columns]).all()) for p in self.parts)

    def eased(self, mean: Array, part: float) -> GridLaws:
        """The laws with a part of their variation and curvature, the rest linear with the mean stiffness (F,) [N/m]."""
        parts = []
        for p in self.parts:
            stiffness = mean[p.columns]
            laws = tuple((eased(law, stiffness[rows], part), rows) for law, rows in p.laws.parts)
            touch = None if p.touch is None else np.minimum(p.touch, 0.0)
            parts.append(replace(p, laws=replace(p.laws, parts=laws), touch=touch))
        return replace(self, parts=tuple(parts), chosen={}, made=[])

    def _own(self, values: Array, axis: int) -> Array:
        """Values (N, c) with the own phase next to the last axis, (..., P, c)."""
        if len(self.counts) == 1:
            return values
        return np.moveaxis(values.reshape(*self.counts, -1), axis, -2)

    def _back(self, values: Array, axis: int) -> Array:
        """Values (..., P, c) as (N, c) again."""
        if len(self.counts) == 1:
            return values
        return np.moveaxis(values, -2, axis).reshape(-1, values.shape[-1])


def grid_laws(rows: GapRows, counts: tuple[int, ...], *, cycles: int) -> GridLaws:
    """Laws of the flanks at the samples of a grid; cycles : mesh cycles in a period of its phases."""
    parts = []
    for axis in np.unique(rows.axis).tolist():
        columns = np.flatnonzero(rows.axis == axis)
        phases = np.zeros((counts[axis], len(counts)))
        phases[:, axis] = cycles * np.arange(counts[axis]) / counts[axis]
        every = columns.size == rows.count
        laws = rows.at(phases) if every else rows.at(phases).rows(columns)
        touch = laws.touch if laws.touch.any() else None
        parts.append(_AxisLaws(laws=laws, columns=columns, axis=axis, touch=touch))
    return GridLaws(parts=tuple(parts), counts=counts, count=rows.count)
