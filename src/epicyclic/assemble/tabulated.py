"""Mesh rows of a System from loaded contact: the linear force k(t) (delta - e(t)) about the mean load of the teeth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..system.system import Line, System
from ..teeth.loaded_contact import harmonics
from ..teeth.mesh_stiffness import ComplexArray, mesh_phasor, series_in_time, table_series
from ..train.connections import Mesh
from ..train.train import Train

__all__ = ["ContactHistory", "with_contact_tangent"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactHistory:
    """Loaded contact of one mesh at times 0, 1/T, ... of its own mesh cycle.

    force : along the normal [N].  approach : (T,) of the teeth along the normal under that force [m].
    tangent : (T,) dF/dd there [N/m].
    """

    force: float
    approach: Array
    tangent: Array


def with_contact_tangent(train: Train, system: System, histories: Mapping[str, ContactHistory]) -> System:
    """System whose meshes have the tangent stiffness of loaded contact and the error that belongs to its load.

    The slices of a mesh share its tangent equally and have its error, in step: the history is that of the whole mesh.

        f = F + k(t) (delta - d_F(t)) = k(t) (delta - e(t)),    e(t) = d_F(t) - F/k(t)

    At vanishing speed the train has the displacement d_F, the loaded transmission error, and no dynamic force.
    Derived here.  Laws of meshes are left out: their tables are of other flanks.

    Parameters
    ----------
    histories : name of a mesh -> its contact, used for the same pair and side in all branches, each at its own phase.

    Raises
    ------
    ModelError : no mesh frequency, a tangent that is not above zero.
    """
    if not system.tones:
        raise ModelError("the dynamic force needs a speed", path="operation.speed", allowed="the speed of one member")
    given = {(mesh.pair, mesh.side): (mesh, histories[mesh.name]) for mesh in train.meshes if mesh.name in histories}
    stiffness, variation = system.meshes.stiffness.copy(), [*system.meshes.variation]
    gaps: dict[Fraction, ComplexArray] = {}
    row = 0
    for mesh in train.meshes:
        rows = slice(row, row + max(len(mesh.slices), 1))
        row = rows.stop
        if (mesh.pair, mesh.side) not in given:
            continue
        first, history = given[mesh.pair, mesh.side]
        mean, series, errors = _series(history)
        stiffness[rows] = mean / (rows.stop - rows.start)
        variation[rows] = [_moved(series, first, mesh)] * (rows.stop - rows.start)
        tone = system.tones[int(system.meshes.tone[rows.start])]
        for order, error in enumerate([errors[0], *_moved(errors[1:], first, mesh)]):
            gaps.setdefault(tone * order, np.zeros(len(variation), complex))[rows] += error
    L = max(len(own) for own in variation)
    padded = np.array([np.pad(own, (0, L - len(own))) for own in variation])
    meshes = replace(system.meshes, stiffness=stiffness, variation=padded, laws=())
    return replace(system, meshes=meshes, lines=_lines(system, gaps))


def _series(history: ContactHistory) -> tuple[float, ComplexArray, ComplexArray]:
    """Mean stiffness [N/m], relative series (L,) and error of orders 0 .. L [m], over mesh time."""
    if not (np.isfinite(history.tangent).all() and (history.tangent > 0).all()):
        raise ModelError("the teeth do not keep contact over the mesh cycle", given=float(np.min(history.tangent)))
    T = len(history.tangent)
    count = (T - 1) // 2
    mean, series = table_series(history.tangent)
    return mean, series[:count], harmonics(history.approach - history.force / history.tangent, count)


def _moved(series: ComplexArray, first: Mesh, mesh: Mesh) -> ComplexArray:
    """Series (L,) over the time of the mesh `first`, moved to the time of `mesh` through sigma, in the same unit."""
    back = np.array([mesh_phasor(order, -first.lead) for order in range(1, len(series) + 1)], dtype=np.complex128)
    own = series * back
    return series_in_time(own if first.sense > 0 else own.conj(), lead=mesh.lead, sense=mesh.sense)


def _lines(system: System, gaps: Mapping[Fraction, ComplexArray]) -> tuple[Line, ...]:
    """Excitation lines with the errors `gaps` (m,) [m] of each frequency [Hz] added, frequencies rising."""
    lines = {line.frequency: line for line in system.lines}
    n, p, rows = len(system.force), len(system.links.name), sum(group.B.shape[1] for group in system.groups)
    for frequency, gap in gaps.items():
        old = lines.get(frequency)
        lines[frequency] = (
            replace(old, gap=old.gap + gap, causes=tuple(sorted({*old.causes, "contact"})))
            if old is not None
            else Line(
                frequency=frequency,
                gap=gap,
                link_gap=np.zeros(p, complex),
                force=np.zeros((3, n), complex),
                causes=("contact",),
                group_gap=np.zeros(rows, complex),
            )
        )
    return tuple(lines[frequency] for frequency in sorted(lines))
