"""Quasi-static states over a record, in consecutive pieces; laws with a memory follow their history."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError
from ...system.group_laws import Laws
from ...system.system import Array, System
from .both_flanks import HeldTrain, balanced, settled
from .equilibrium import Equilibrium
from .record import Record, RecordExcitation, excitation

__all__ = ["RecordPiece", "history_note", "quasi_static"]

_CHUNK = 2048
# Parts of the history that are stepped through side by side.
_PARTS = 128
# Sliders at the ends of two parts agree to this part of the slip start: the force then holds to the same part of the
# friction force.
_SLIDER_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordPiece:
    """Consecutive instants of a record.

    state : equilibrium at t instants.  link_deflection : (t, p) of the linear links [m, rad].
    anchor : (t, R) sliders before each step [m].
    """

    state: Equilibrium
    link_deflection: Array
    anchor: Array | None


def quasi_static(
    system: System, train: HeldTrain, record: Record, progress: Callable[[float], None] | None = None
) -> Iterator[RecordPiece]:
    """Equilibrium at every instant of the record, in order.

    Sliders of laws with a memory start in the middle, one record before the first instant.

    Raises
    ------
    ModelError : a load that nothing balances or holds.  ConvergenceError : no equilibrium was found.
    """
    laws, links, total = system.laws, system.links, record.instants
    anchors, approach = _slider_history(system, train, record) if laws.memory.any() else (None, None)
    for first in range(0, total, _CHUNK):
        index = np.arange(first, min(first + _CHUNK, total), dtype=np.int64)
        here = _balanced_excitation(system, train, record, index)
        anchor = None if anchors is None else anchors[index]
        start = None if approach is None else approach[index]
        state = settled(train, here, laws, anchor=anchor, start=start)
        deflection = state.displacement @ links.B - here.link_gap
        yield RecordPiece(state=state, link_deflection=deflection, anchor=anchor)
        if progress is not None:
            progress((index[-1] + 1) / total)


def history_note(system: System, record: Record) -> str:
    """How the history of laws with a memory begins, "" where there is none."""
    if not system.laws.memory.any():
        return ""
    return f"sliders start in the middle; warm-up over {record.count} {record.name} before the record"


def _balanced_excitation(
    system: System, train: HeldTrain, record: Record, index: NDArray[np.int64]
) -> RecordExcitation:
    """Excitation at the instants `index` (t,), whose loads are checked to balance on free motions."""
    here = excitation(system, record.unit, index, record.samples)
    balanced(train, here.force)
    return here


def _slider_history(system: System, train: HeldTrain, record: Record) -> tuple[Array, Array]:
    """Sliders before every step (T, R) and approach (T, M) at every instant of the record [m].

    After a record of warm-up.

    Warm-up and record are cut into parts that are stepped through side by side, each from a guess of its first slider.
    The end of a part is the start of the next; parts whose start changes are stepped through again.  When none changes,
    the whole equals sequential stepping.  A part forgets its start as soon as it slides, so few rounds suffice.

    Raises
    ------
    ConvergenceError : starts still change after as many rounds as there are parts.
    """
    total, laws = record.instants, system.laws
    here = _balanced_excitation(system, train, record, np.arange(-total, total, dtype=np.int64))
    parts = min(_PARTS, 2 * total)
    length = -(-2 * total // parts)
    anchors = np.zeros((2 * total, laws.rows.owner.size))
    approach = np.zeros((2 * total, len(train.loaded.stiffness)))
    begin = np.zeros((parts, laws.rows.owner.size))
    todo = np.arange(parts)
    tolerance = _SLIDER_TOLERANCE * float(np.min(laws.slip_start[laws.memory]))
    for _ in range(parts + 1):
        ends = _step_parts(train, here, laws, (begin, todo, length), (anchors, approach))
        following = todo + 1 < parts
        following_parts = todo[following] + 1
        moved = np.max(np.abs(ends[following] - begin[following_parts]), axis=1, initial=0.0) > tolerance
        begin[following_parts] = ends[following]
        todo = following_parts[moved]
        if not todo.size:
            return anchors[total:], approach[total:]
    raise ConvergenceError("the history of a sliding spline was not found")


def _step_parts(
    train: HeldTrain,
    here: RecordExcitation,
    laws: Laws,
    parts: tuple[Array, NDArray[np.int64], int],
    found: tuple[Array, Array],
) -> Array:
    """Step through some parts in place, filling in sliders and approach (2 T, ..) [m].

    Their last sliders (parts, R) [m].
    """
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
        state = settled(train, now, laws, anchor=before, start=None if start is None else start[: index.size])
        anchors[index], approach[index] = before, state.approach
        slider[inside] = laws.slide(state.group_stretch, before)
        start = state.approach
    return slider
