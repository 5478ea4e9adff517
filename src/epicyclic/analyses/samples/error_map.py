"""Linear map from error factors to mesh forces at one speed: with linear contact exact for any number of samples.

    force = base + sum_c Re(z_c) column_c + Im(z_c) column'_c

A stiffness that varies in time couples an order to its mirror image, so that a factor z on a line counts as two real
numbers; with these the map is exact, for all errors together (derived here).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import ComplexArray, Line, System, faces
from ..static.tangent import linear
from ..steady.balance import HarmonicSolution
from ..steady.excitation import mesh_order_excitation, shaft_order_excitation
from ..steady.lattice import Point
from ..steady.periodic import checked_speed
from ..steady.response import Response, Truncation, response
from ..steady.waveform import Spectrum, force_spectrum
from .columns import UnitLoads, column_block, solve_columns, solve_refined

__all__ = ["ColumnSpectrum", "ErrorMap", "error_map", "mesh_error_lines"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColumnSpectrum:
    """Mesh orders, or one shaft group.

    use : (P,) index among the numbers [1, Re z (C), Im z (C)] of each column.
    spectrum : force amplitudes of whole meshes, (w, P, 1, K) [N].
    """

    use: Index
    spectrum: Spectrum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorMap:
    """Mesh forces at one speed as a linear function of factors z (C,) on error lines.

    mesh : (w,) names of the whole meshes, as in every result.  columns : (C,) the lines, factor 1 as given.
    parts : mesh orders, then every shaft group.
    truncation : harmonics and cross order.  residual : largest of any column, relative to its own dynamic part.
    """

    mesh: tuple[str, ...]
    columns: tuple[Line, ...]
    relative_speed: float
    ready: Response
    parts: tuple[ColumnSpectrum, ...]
    truncation: Truncation
    residual: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Group:
    """Lines of one harmonic solution.

    members : (column, below 0 of a line that does not vary; lattice point; whether conjugate; line).
    shaft : index of the shaft group, None of mesh orders.
    """

    members: tuple[tuple[int, Point, bool, Line], ...]
    shaft: int | None


def mesh_error_lines(system: System, orders: Iterable[int] = (1, 2, 3)) -> tuple[Line, ...]:
    """One line for each mesh and order of its mesh frequency, an error of 1 m at phase 0: columns to vary one by one.

    A factor a exp(i b) is an error a cos(2 pi l f t + b) of that mesh alone, l the order; its slices share it.

    Raises
    ------
    ModelError : an order below 0; no speed is given.
    """
    wanted = list(orders)
    if any(order < 0 for order in wanted):
        raise ModelError("below zero", path="orders", given=wanted, allowed="0 or more")
    if not system.tones:
        raise ModelError("no mesh frequency", path="operation.speed", allowed="the speed of one member")
    face = faces(system.meshes)
    return tuple(
        Line(
            frequency=system.tones[system.meshes.tone[face.first[place]]] * order,
            gap=(face.row == place).astype(complex),
            link_gap=np.zeros(len(system.links.name), complex),
            force=np.zeros((3, len(system.force)), complex),
            causes=(f"error of {name}",),
        )
        for place, name in enumerate(face.name)
        for order in wanted
    )


def error_map(
    system: System, columns: Iterable[Line] | None = None, *, relative_speed: float = 1.0, tolerance: float = 1e-8
) -> ErrorMap:
    """Solve every column once.

    Parameters
    ----------
    columns : lines whose factors will vary; None takes those of the System.  Lines of the System that are not among
        them stay as they are, with the mean load.
    relative_speed : speed per operating speed, above zero.  tolerance : of every column, as of `periodic`.

    Raises
    ------
    ModelError : as of `response`, or an option out of range.
    """
    speed = checked_speed(relative_speed)
    varied = system.lines if columns is None else tuple(columns)
    static = tuple(line for line in system.lines if not any(line is other for other in varied))
    # copies, so that a line that stands twice is two columns
    ready = response(linear(replace(system, lines=tuple(replace(line) for line in (*static, *varied)))))
    groups, count = _groups(ready, len(static)), len(varied)

    def find(truncation: Truncation) -> list[HarmonicSolution]:
        units = [_unit(ready, truncation, speed, group) for group in groups]
        return [solve_columns(ready, truncation, speed, unit, tolerance=tolerance) for unit in units]

    truncation, solved = solve_refined(ready, speed, find, tolerance=tolerance)
    return ErrorMap(
        mesh=faces(system.meshes).name,
        columns=varied,
        relative_speed=speed,
        ready=ready,
        parts=tuple(_part(ready, truncation, speed, *pair, count=count) for pair in zip(groups, solved, strict=True)),
        truncation=truncation,
        residual=float(max(each.residual.max(initial=0.0) for each in solved)),
    )


def _groups(ready: Response, static: int) -> list[_Group]:
    """Mesh orders, then each shaft group; the first `static` lines of the System do not vary."""
    number = {id(line): place - static for place, line in enumerate(ready.system.lines)}
    mesh = tuple((number[id(line)], point, False, line) for point, line in ready.lines.mesh)
    shafts = [
        tuple((number[id(line)], point, conjugate, line) for point, conjugate, line in shaft.members)
        for shaft in ready.lines.shaft
    ]
    return [_Group(members=mesh, shaft=None), *(_Group(members=part, shaft=s) for s, part in enumerate(shafts))]


def _columns(group: _Group) -> Iterator[tuple[int, tuple[tuple[int, Point, bool, Line], ...]]]:
    """(index of a column, its members): the fixed lines first, then real and imaginary unit of each line that
    varies.
    """
    yield -1, tuple(member for member in group.members if member[0] < 0)
    for column, point, conjugate, line in group.members:
        if column >= 0:
            for unit in (1.0, 1j):
                yield column, ((column, point, conjugate, replace(line, gap=unit * line.gap, force=unit * line.force)),)


def _unit(ready: Response, truncation: Truncation, speed: float, group: _Group) -> UnitLoads:
    """Excitation of all columns of a group at a relative speed."""
    lattice = ready.kernel(truncation, shifted=group.shaft is not None).lattice
    quiet = replace(ready.system, force=np.zeros(len(ready.system.force)))
    rows: list[tuple[ComplexArray, ComplexArray]] = []
    for column, members in _columns(group):
        if group.shaft is None:
            lines = replace(ready.lines, mesh=tuple((point, line) for _, point, _, line in members), shaft=())
            rows.append(mesh_order_excitation(ready.system if column < 0 else quiet, lines, np.array([speed]), lattice))
        else:
            shaft = replace(ready.lines.shaft[group.shaft], members=tuple(member[1:] for member in members))
            lines = replace(ready.lines, mesh=(), shaft=(shaft,))
            rows.append(shaft_order_excitation(quiet, lines, np.array([speed]), lattice))
    return UnitLoads(
        error=np.concatenate([error for error, _ in rows], axis=1),
        force=np.concatenate([force for _, force in rows]),
        shaft=group.shaft,
    )


def _part(
    ready: Response, truncation: Truncation, speed: float, group: _Group, solved: HarmonicSolution, *, count: int
) -> ColumnSpectrum:
    """Force spectra of the columns of a group, solved; count : number of columns C."""
    shifted = group.shaft is not None
    rows = force_spectrum(ready, column_block(truncation, speed, solved, shifted=shifted), shifted=shifted)
    use = [0]
    for column in (column for column, *_ in group.members if column >= 0):
        use += [1 + column, 1 + count + column]
    total = faces(ready.system.meshes).total(rows.amplitude)
    return ColumnSpectrum(use=np.array(use), spectrum=replace(rows, amplitude=total))
