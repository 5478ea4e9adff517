"""Quasi-static stretch of every contact as a linear function of deviations, at mean mesh stiffness.

    g(theta) = torque g_T + g_0 + sum_c x_c Re(column_c exp(i theta_c)),    force of a closed row = k g

Rows are the loaded flanks of the mesh rows, the far flanks where backlash is finite, and links whose stiffness varies
between samples.  The stretch g = B'q - e of a row is that of the train with all loaded flanks closed; a row whose
stiffness is kappa instead of k0, open ones with kappa = 0, has y = (k0 - kappa) g and g = g_closed + S y, with S of
`analyses.static.equilibrium`.  This is exact and needs the rows alone that differ; derived here.  Lines at mesh orders
are left out: their phase is that of the mesh cycle, whose mean this is.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...system.elimination import elastic_rows
from ...system.system import Array, ComplexArray, Faces, Line, System, faces
from ..static.both_flanks import held_train
from ..static.equilibrium import Compliance, Values, compliance, imbalance, require_balance
from ..static.record import MeshGroup, parallel_meshes

__all__ = ["LineMap", "LoadMap", "at_mesh_order", "group_names", "line_map", "load_map", "turning_frequencies"]

# Columns of a line that is left out, of one that stands still, and from 0 on of the turning frequencies.
LEFT_OUT, STILL = -2, -1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineMap:
    """Q numbers that follow the lines of a System and columns beside them, in the unit of the numbers.

    still, torque : (Q,) what stands still without the torques, and what they add.
    frequency : (G,) of what turns, exact [Hz].  turning : (G, Q) amplitudes that the System holds.
    column : (C, Q) complex, per unit of each column.  column_line : (C,) place of its frequency in `frequency`,
        -1 where it stands still, -2 where it is at a mesh order and left out.
    """

    still: Array
    torque: Array
    frequency: tuple[Fraction, ...]
    turning: ComplexArray
    column: ComplexArray
    column_line: NDArray[np.int64]

    def values(self, factors: Array, torque: float | Array = 1.0) -> tuple[Array, ComplexArray]:
        """What stands still (S, Q) and amplitudes of what turns (G, S, Q) of samples.

        Parameters
        ----------
        factors : (S, C) on the columns.  torque : factor on the torques, one or (S,).
        """
        S = len(factors)
        standing = self.column_line == STILL
        still = self.still + np.multiply.outer(np.broadcast_to(torque, S), self.torque)
        still += factors[:, standing] @ self.column[standing].real
        turning = np.empty((len(self.frequency), S, self.still.size), complex)
        for place in range(len(self.frequency)):
            own = self.column_line == place
            x = factors[:, own]
            turning[place].real = x @ self.column[own].real
            turning[place].imag = x @ self.column[own].imag
            turning[place] += self.turning[place]
        return still, turning


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadMap:
    """Stretches of M rows: m loaded flanks, c far flanks, l links whose stiffness varies.

    flexible : the train seen from these rows, loaded flanks and links closed.
    mesh_count, far : m; (c,) mesh row of each far flank.  far_stiffness : (c,) of one that presses [N/m].
    stretch : of the M rows [m].  left : (1,) largest force on a body that these leave [N], of sizes of factors.
    face, group, pair : whole meshes (w,), groups of them that share a load (g,) and their names.
    """

    flexible: Compliance
    mesh_count: int
    far: NDArray[np.int64]
    far_stiffness: Array
    stretch: LineMap
    left: LineMap
    face: Faces
    group: tuple[MeshGroup, ...]
    pair: tuple[str, ...]


def line_map(
    system: System,
    columns: Sequence[Line],
    value: Callable[[Line], ComplexArray],
    *,
    constant: Array,
    torque: Array,
) -> LineMap:
    """Numbers (Q,) that are linear in lines, of the lines of a System and of columns.

    Parameters
    ----------
    value : line -> (Q,).  constant : (Q,) without any line or torque.  torque : (Q,) of the torques.
    """
    lines = (*system.lines, *columns)
    frequency = turning_frequencies(system, lines)
    place = {f: i for i, f in enumerate(frequency)}
    found = np.array([value(line) for line in lines], complex).reshape(len(lines), constant.size)
    kind = np.array([STILL if not line.frequency else place.get(line.frequency, LEFT_OUT) for line in lines], np.int64)
    base = len(system.lines)
    turning = np.zeros((len(frequency), constant.size), complex)
    for line, values in zip(kind[:base].tolist(), found[:base], strict=True):
        if line >= 0:
            turning[line] += values
    return LineMap(
        still=constant + found[:base][kind[:base] == STILL].real.sum(axis=0),
        torque=torque,
        frequency=frequency,
        turning=turning,
        column=found[base:],
        column_line=kind[base:],
    )


def group_names(system: System) -> tuple[str, ...]:
    """Names of the groups of `parallel_meshes`: pair without ``stages.``, and side where it has one."""
    face, found = faces(system.meshes), []
    for group in parallel_meshes(system.meshes):
        row = int(face.first[group[0]])
        side = system.meshes.side[row]
        pair = system.meshes.pair[row].removeprefix("stages.")
        found.append(f"{pair}.{side}" if side else pair)
    return tuple(found)


def turning_frequencies(system: System, lines: Sequence[Line]) -> tuple[Fraction, ...]:
    """Frequencies [Hz] of lines that neither stand still nor are at a mesh order, rising."""
    found = {line.frequency for line in lines if line.frequency and not at_mesh_order(system, line)}
    return tuple(sorted(found))


def load_map(system: System, columns: Sequence[Line] = (), *, links: NDArray[np.int64] | None = None) -> LoadMap:
    """The map of a System without laws, whose own lines and torques are the base.

    Parameters
    ----------
    columns : lines per unit of what varies between samples.
    links : rows of `System.links` whose stiffness varies between samples.

    Raises
    ------
    ModelError : a load that nothing balances.
    """
    own = np.zeros(0, np.int64) if links is None else links
    meshes, far = system.meshes, system.far_flanks
    m, c = len(meshes.name), far.mesh.size
    flexible = _flexible(system, own)
    require_balance(flexible.free, system.force[None], system)
    opening = np.zeros(flexible.stiffness.size)
    opening[m : m + c] = meshes.backlash[far.mesh]
    constant = _closed(flexible, opening, np.zeros_like(system.force))
    torque = _closed(flexible, np.zeros_like(opening), system.force)

    @functools.cache
    def solved(line: Line) -> tuple[ComplexArray, ComplexArray]:
        """Stretch and what it leaves of one line."""
        return _closed(flexible, *_gap_and_force(system, flexible, own, line))

    return LoadMap(
        flexible=flexible,
        mesh_count=m,
        far=far.mesh,
        far_stiffness=meshes.stiffness[far.mesh],
        stretch=line_map(system, columns, lambda line: solved(line)[0], constant=constant[0], torque=torque[0]),
        left=line_map(system, columns, lambda line: solved(line)[1], constant=constant[1], torque=torque[1]),
        face=faces(meshes),
        group=tuple(parallel_meshes(meshes)),
        pair=group_names(system),
    )


def at_mesh_order(system: System, line: Line) -> bool:
    """Whether a line is at a multiple of any mesh frequency."""
    return any((line.frequency / tone).denominator == 1 for tone in system.tones)


def _flexible(system: System, links: NDArray[np.int64]) -> Compliance:
    """The train seen from its flanks and the links that vary, which are then rows and no part of K."""
    meshes, far = system.meshes, system.far_flanks
    L, k = system.links.B[:, links], system.links.stiffness[links]
    train = held_train(system)
    behind = (train.both or train.loaded).stiffness[len(meshes.name) : len(meshes.name) + far.mesh.size]
    rows = np.hstack([meshes.B, far.B, L])
    return compliance(elastic_rows(system, links), rows, np.concatenate([meshes.stiffness, behind, k]))


def _gap_and_force(
    system: System, flexible: Compliance, links: NDArray[np.int64], line: Line
) -> tuple[ComplexArray, ComplexArray]:
    """Complex errors of every row (M,) [m] and force (n,) [N, N m] of one line.

    Raises
    ------
    ModelError : a load that nothing balances.
    """
    own = line.link_gap[links]
    # errors of links that vary are gaps of rows here, no forces
    require_balance(flexible.free, np.array([line.force[0].real, line.force[0].imag]), system)
    force = line.force[0] - system.links.B[:, links] @ (system.links.stiffness[links] * own)
    flanks = system.flank_gaps(line)[: len(system.meshes.name) + system.far_flanks.mesh.size]
    return np.concatenate([flanks, own]), force


def _closed(flexible: Compliance, gap: Values, force: Values) -> tuple[Values, Values]:
    """Stretch (M,) [m] of all rows where each has its stiffness of `flexible`, and the force it leaves on a body (1,).

    gap : (M,) [m].  force : (n,) [N, N m].
    """
    pull = flexible.stiffness * gap
    stretch: Values = flexible.gap_of_force @ force + flexible.to_mesh @ pull - gap
    return stretch, imbalance(flexible, force[None], pull[None], (flexible.stiffness * stretch)[None])[0]
