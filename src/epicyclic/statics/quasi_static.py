"""Quasi-static states of a train whose teeth have two flanks, over a record, in consecutive pieces.

The loaded flanks are tried alone first.  Where no far flank would press, theirs is the equilibrium: the energy is
convex and a flank that does not press adds nothing to it.  The other instants, and those that nothing holds without
far flanks, are solved with both.  Laws with a memory follow their history.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.gaps import net_force
from ..system.link_laws import Laws
from ..system.system import Array, FarFlanks, System, elastic_rows
from .equilibrium import Compliance, Equilibrium, compliance, compliance_of, equilibrium, require_balance
from .record import Record, RecordExcitation, excitation

# Closing of a far flank by a unit motion that is rounding of the null space; 1e-12 is seen.
_STILL = 1e-9
# Instants that are solved at once.
_CHUNK = 2048
# Parts of the history that are stepped through side by side.
_PARTS = 128
# Sliders at the ends of two parts agree to this part of the slip start: the force then holds to the same part of the
# friction force.
_SLIDER_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldTrain:
    """A train seen from its rows.

    loaded : from the loaded flanks and the rows of groups.  both : from all flanks, None where no backlash is finite.
    far : its far flanks.  laws : of its groups.  system : that it is of.
    """

    loaded: Compliance
    both: Compliance | None
    far: FarFlanks
    laws: Laws
    system: System

    def net_force(self, state: Equilibrium) -> Array:
        """Forces of the mesh rows (T, m) [N], negative on far flanks."""
        far = self.far.mesh[: state.far_force.shape[1]]
        return net_force(np.hstack([state.mesh_force, state.far_force]), far)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordPiece:
    """Consecutive instants of a record.

    state : equilibrium at t instants.  link_deflection : (t, p) of the linear links [m, rad].
    anchor : (t, R) sliders before each step [m].
    """

    state: Equilibrium
    link_deflection: Array
    anchor: Array | None


def held_train(system: System) -> HeldTrain:
    """The train seen from its flanks."""
    loaded, far, laws = compliance_of(system), system.far_flanks, system.laws
    if not far.mesh.size:
        return HeldTrain(loaded=loaded, both=None, far=far, laws=laws, system=system)
    # a motion that the loaded flanks leave free may be stopped by far ones, which then count as closed
    stops = np.max(np.abs(far.B.T @ loaded.free), axis=1, initial=0.0) > _STILL
    k0 = np.where(stops, system.meshes.stiffness[far.mesh], 0.0)
    B = np.hstack([system.meshes.B, far.B, system.group_rows])
    stiffness = np.concatenate([system.meshes.stiffness, k0, laws.row_stiffness])
    both = compliance(elastic_rows(system), B, stiffness)
    return HeldTrain(loaded=loaded, both=both, far=far, laws=laws, system=system)


def balanced(held: HeldTrain, force: Array) -> None:
    """Check that no load (T, n) [N, N m] works on a motion that neither links nor flanks hold.

    Raises
    ------
    ModelError : one does.
    """
    require_balance((held.loaded if held.both is None else held.both).free, force, held.system)


def settled(
    held: HeldTrain, here: RecordExcitation, *, anchor: Array | None = None, start: Array | None = None
) -> Equilibrium:
    """Equilibrium at T instants, as `equilibrium`, with the far flanks where backlash is finite.

    Parameters
    ----------
    anchor : (T, R) sliders before this step [m].  start : (T, m + R) approach to start from [m].

    Raises
    ------
    ModelError : the load drives bodies apart and nothing holds them.  ConvergenceError : no equilibrium.
    """
    if held.both is None:
        return _loaded(held, here, anchor, start)
    assert here.both is not None
    assert here.far_gap is not None
    try:
        require_balance(held.loaded.free, here.force, held.system)
        state = _loaded(held, here, anchor, start)
    except (ModelError, ConvergenceError):
        return _both(held, here, anchor)
    touch = here.both.touch[:, here.stiffness.shape[1] :]
    pressing = np.flatnonzero(np.any(state.displacement @ held.far.B - here.far_gap > touch, axis=1))
    state = replace(state, far_force=np.zeros((len(here.gap), held.far.mesh.size)))
    if pressing.size:
        again = _both(held, here.at(pressing), None if anchor is None else anchor[pressing])
        for field in fields(Equilibrium):
            getattr(state, field.name)[pressing] = getattr(again, field.name)
    return state


def _loaded(held: HeldTrain, here: RecordExcitation, anchor: Array | None, start: Array | None) -> Equilibrium:
    """Equilibrium on the loaded flanks alone."""
    return equilibrium(
        held.loaded,
        stiffness=here.stiffness,
        gap=here.gap,
        force=here.force,
        flanks=here.flanks,
        laws=held.laws,
        anchor=anchor,
        start=start,
    )


def _both(held: HeldTrain, here: RecordExcitation, anchor: Array | None) -> Equilibrium:
    """Equilibrium on loaded and far flanks."""
    assert held.both is not None
    assert here.far_gap is not None
    m = here.stiffness.shape[1]
    return equilibrium(
        held.both,
        stiffness=here.stiffness,
        gap=np.hstack([here.gap[:, :m], here.far_gap, here.gap[:, m:]]),
        force=here.force,
        flanks=here.both,
        laws=held.laws,
        anchor=anchor,
    )


def quasi_static(
    held: HeldTrain, record: Record, progress: Callable[[float], None] | None = None
) -> Iterator[RecordPiece]:
    """Equilibrium at every instant of the record, in order.

    Sliders of laws with a memory start in the middle, one record before the first instant.

    Raises
    ------
    ModelError : a load that nothing balances or holds.  ConvergenceError : no equilibrium was found.
    """
    links, total = held.system.links, record.instants
    anchors, approach = _slider_history(held, record) if held.laws.memory.any() else (None, None)
    for first in range(0, total, _CHUNK):
        index = np.arange(first, min(first + _CHUNK, total), dtype=np.int64)
        here = _balanced_excitation(held, record, index)
        anchor = None if anchors is None else anchors[index]
        start = None if approach is None else approach[index]
        state = settled(held, here, anchor=anchor, start=start)
        deflection = state.displacement @ links.B - here.link_gap
        yield RecordPiece(state=state, link_deflection=deflection, anchor=anchor)
        if progress is not None:
            progress((index[-1] + 1) / total)


def history_note(system: System, record: Record) -> str:
    """How the history of laws with a memory begins, "" where there is none."""
    if not system.laws.memory.any():
        return ""
    return f"sliders start in the middle; warm-up over {record.count} {record.name} before the record"


def _balanced_excitation(held: HeldTrain, record: Record, index: NDArray[np.int64]) -> RecordExcitation:
    """Excitation at the instants `index` (t,), whose loads are checked to balance on free motions."""
    here = excitation(held.system, record.unit, index, record.samples)
    balanced(held, here.force)
    return here


def _slider_history(held: HeldTrain, record: Record) -> tuple[Array, Array]:
    """Sliders before every step (T, R) and approach (T, M) at every instant of the record [m], after one of warm-up.

    Warm-up and record are cut into parts that are stepped through side by side, each from a guess of its first slider.
    The end of a part is the start of the next; parts whose start changes are stepped through again.  When none changes,
    the whole equals sequential stepping.  A part forgets its start as soon as it slides, so few rounds suffice.

    Raises
    ------
    ConvergenceError : starts still change after as many rounds as there are parts.
    """
    total, laws = record.instants, held.laws
    here = _balanced_excitation(held, record, np.arange(-total, total, dtype=np.int64))
    parts = min(_PARTS, 2 * total)
    length = -(-2 * total // parts)
    anchors = np.zeros((2 * total, laws.rows.owner.size))
    approach = np.zeros((2 * total, len(held.loaded.stiffness)))
    begin = np.zeros((parts, laws.rows.owner.size))
    todo = np.arange(parts)
    tolerance = _SLIDER_TOLERANCE * float(np.min(laws.slip_start[laws.memory]))
    for _ in range(parts + 1):
        ends = _step_parts(held, here, begin[todo], todo * length, length, anchors, approach)
        following = todo + 1 < parts
        following_parts = todo[following] + 1
        moved = np.max(np.abs(ends[following] - begin[following_parts]), axis=1, initial=0.0) > tolerance
        begin[following_parts] = ends[following]
        todo = following_parts[moved]
        if not todo.size:
            return anchors[total:], approach[total:]
    raise ConvergenceError("the history of a sliding spline was not found")


def _step_parts(
    held: HeldTrain,
    here: RecordExcitation,
    slider: Array,
    first: NDArray[np.int64],
    length: int,
    anchors: Array,
    approach: Array,
) -> Array:
    """Last sliders (P, R) [m] of parts that begin at instants `first` (P,) with some sliders (P, R) [m].

    The parts are stepped through in place, which fills in sliders and approach (2 T, ..) [m].
    """
    slider = slider.copy()
    start: Array | None = None
    for step in range(length):
        inside = first + step < len(anchors)
        index = (first + step)[inside]
        if not index.size:
            break
        before = slider[inside]
        state = settled(held, here.at(index), anchor=before, start=None if start is None else start[: index.size])
        anchors[index], approach[index] = before, state.approach
        slider[inside] = held.laws.slide(state.group_stretch, before)
        start = state.approach
    return slider
