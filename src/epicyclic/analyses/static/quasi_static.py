"""The static state over a record, piece by piece; where a law has a memory, with its history."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError
from ...system.laws import groups as law
from ...system.laws.groups import Laws
from ...system.system import Array, System
from .equilibrium import Compliance, Equilibrium, equilibrium, require_balance
from .record import Excitation, Record, excitation

__all__ = ["Piece", "history_note", "trace"]

_CHUNK = 2048
# Parts of the history that are stepped through side by side.
_PARTS = 128
# Sliders that meet to this part of the slip start meet: the force then holds to the same part of the friction force.
_MET = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Piece:
    """Consecutive instants of a record.

    state : equilibrium.  link_deflection : (t, p) of the linear links [m, rad].
    anchor : (t, R) sliders before each step.
    """

    state: Equilibrium
    link_deflection: Array
    anchor: Array | None


def trace(
    system: System, flexible: Compliance, record: Record, progress: Callable[[float], None] | None = None
) -> Iterator[Piece]:
    """Equilibrium at every instant of the record, in order.

    Sliders of laws with a memory start in the middle, one record before the first instant.

    Raises
    ------
    ModelError : a load that nothing balances or holds.  ConvergenceError : no equilibrium was found.
    """
    laws, links, total = system.laws, system.links, record.instants
    anchors, approach = _history(system, flexible, record) if laws.memory.any() else (None, None)
    for first in range(0, total, _CHUNK):
        index = np.arange(first, min(first + _CHUNK, total), dtype=np.int64)
        here = _excited(system, flexible, record, index)
        anchor = None if anchors is None else anchors[index]
        start = None if approach is None else approach[index]
        state = _solved(flexible, here, laws, anchor=anchor, start=start)
        deflection = state.displacement @ links.B - here.link_gap
        yield Piece(state=state, link_deflection=deflection, anchor=anchor)
        if progress is not None:
            progress((index[-1] + 1) / total)


def history_note(system: System, record: Record) -> str:
    """How the history of laws with a memory begins, "" where there is none."""
    if not system.laws.memory.any():
        return ""
    return f"sliders start in the middle; warm-up over {record.count} {record.name} before the record"


def _excited(system: System, flexible: Compliance, record: Record, index: NDArray[np.int64]) -> Excitation:
    here = excitation(system, record.unit, index, record.samples)
    require_balance(flexible.free, here.force, system.dofs.names)
    return here


def _solved(
    flexible: Compliance, here: Excitation, laws: Laws, *, anchor: Array | None, start: Array | None
) -> Equilibrium:
    return equilibrium(
        flexible,
        stiffness=here.stiffness,
        gap=here.gap,
        force=here.force,
        curves=here.curves,
        laws=laws,
        anchor=anchor,
        start=start,
    )


def _history(system: System, flexible: Compliance, record: Record) -> tuple[Array, Array]:
    """Sliders before every step (T, R) and approach (T, M) at every instant of the record, after one record of warm-up.

    Warm-up and record are cut into parts that are stepped through side by side, each from a guess of its first slider.
    The end of a part is the start of the next; parts whose start that changes are stepped through again.  When none
    changes the whole is what one long walk gives; a part forgets its start as soon as it slides, so few rounds do.
    """
    total, laws = record.instants, system.laws
    here = _excited(system, flexible, record, np.arange(-total, total, dtype=np.int64))
    parts = min(_PARTS, 2 * total)
    length = -(-2 * total // parts)
    anchors = np.zeros((2 * total, laws.owner.size))
    approach = np.zeros((2 * total, len(flexible.stiffness)))
    begin = np.zeros((parts, laws.owner.size))
    todo = np.arange(parts)
    tolerance = _MET * float(np.min(laws.slip_start[laws.memory]))
    for _ in range(parts + 1):
        ends = _walk(flexible, here, laws, (begin, todo, length), (anchors, approach))
        following = todo + 1 < parts
        nexts = todo[following] + 1
        moved = np.max(np.abs(ends[following] - begin[nexts]), axis=1, initial=0.0) > tolerance
        begin[nexts] = ends[following]
        todo = nexts[moved]
        if not todo.size:
            return anchors[total:], approach[total:]
    raise ConvergenceError("the history of a sliding spline was not found")


def _walk(
    flexible: Compliance,
    here: Excitation,
    laws: Laws,
    parts: tuple[Array, NDArray[np.int64], int],
    found: tuple[Array, Array],
) -> Array:
    """Step through some parts, filling in sliders and approach; their last sliders, (parts, R)."""
    begin, todo, length = parts
    anchors, approach = found
    slider, place = begin[todo].copy(), todo * length
    start: Array | None = None
    for step in range(length):
        inside = place + step < len(anchors)
        index = (place + step)[inside]
        if not index.size:
            break
        now = here.at(index)
        before = slider[inside]
        state = _solved(flexible, now, laws, anchor=before, start=None if start is None else start[: index.size])
        anchors[index], approach[index] = before, state.approach
        slider[inside] = law.slide(laws, state.group_stretch, before)
        start = state.approach
    return slider
