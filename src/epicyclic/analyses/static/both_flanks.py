"""Static equilibrium of a train whose teeth have two flanks.

The loaded flanks are tried alone first.  Where no far flank would press, theirs is the equilibrium: the energy is
convex and a flank that does not press adds nothing to it.  The other instants, and those that nothing holds without
far flanks, are solved with both.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...system.elimination import elastic_rows
from ...system.group_laws import Laws
from ...system.system import Array, FarFlanks, System
from .equilibrium import Compliance, Equilibrium, compliance, compliance_of, equilibrium, require_balance
from .record import RecordExcitation

__all__ = ["HeldTrain", "balanced", "held_train", "settled"]

# Closing of a far flank by a unit motion that is rounding of the null space; 1e-12 is seen.
_STILL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldTrain:
    """A train seen from its rows.

    loaded : from the loaded flanks and the rows of groups.  both : from all flanks, None where no backlash is finite.
    far : its far flanks.  system : that it is of.
    """

    loaded: Compliance
    both: Compliance | None
    far: FarFlanks
    system: System


def held_train(system: System) -> HeldTrain:
    """The train seen from its flanks."""
    loaded, far = compliance_of(system), system.far_flanks
    if not far.mesh.size:
        return HeldTrain(loaded=loaded, both=None, far=far, system=system)
    # a motion that the loaded flanks leave free may be stopped by far ones, which then count as closed
    stops = np.max(np.abs(far.B.T @ loaded.free), axis=1, initial=0.0) > _STILL
    k0 = np.where(stops, system.meshes.stiffness[far.mesh], 0.0)
    B = np.hstack([system.meshes.B, far.B, system.group_rows])
    stiffness = np.concatenate([system.meshes.stiffness, k0, system.laws.row_stiffness])
    return HeldTrain(loaded=loaded, both=compliance(elastic_rows(system), B, stiffness), far=far, system=system)


def balanced(train: HeldTrain, force: Array) -> None:
    """Check that no load (T, n) [N, N m] works on a motion that neither links nor flanks hold.

    Raises
    ------
    ModelError : one does.
    """
    require_balance((train.loaded if train.both is None else train.both).free, force, train.system)


def settled(
    train: HeldTrain, here: RecordExcitation, laws: Laws, *, anchor: Array | None = None, start: Array | None = None
) -> Equilibrium:
    """Equilibrium at T instants, as `equilibrium`, with the far flanks where backlash is finite.

    Parameters
    ----------
    anchor : (T, R) sliders before this step [m].  start : (T, m + R) approach to start from [m].

    Raises
    ------
    ModelError : the load drives bodies apart and nothing holds them.  ConvergenceError : no equilibrium.
    """
    if train.both is None:
        return _loaded(train, here, laws, anchor, start)
    try:
        require_balance(train.loaded.free, here.force, train.system)
        found = _loaded(train, here, laws, anchor, start)
        pressing = np.flatnonzero(_presses(train, here, found.displacement))
    except (ModelError, ConvergenceError):
        return _both(train.both, here, laws, anchor)
    found = replace(found, far_force=np.zeros((len(here.gap), train.far.mesh.size)))
    if pressing.size:
        again = _both(train.both, here.at(pressing), laws, None if anchor is None else anchor[pressing])
        for each in fields(Equilibrium):
            getattr(found, each.name)[pressing] = getattr(again, each.name)
    return found


def _loaded(
    train: HeldTrain, here: RecordExcitation, laws: Laws, anchor: Array | None, start: Array | None
) -> Equilibrium:
    """Equilibrium on the loaded flanks alone."""
    return equilibrium(
        train.loaded,
        stiffness=here.stiffness,
        gap=here.gap,
        force=here.force,
        flanks=here.flanks,
        laws=laws,
        anchor=anchor,
        start=start,
    )


def _both(flexible: Compliance, here: RecordExcitation, laws: Laws, anchor: Array | None) -> Equilibrium:
    """Equilibrium on loaded and far flanks."""
    assert here.both is not None
    assert here.far_gap is not None
    m = here.stiffness.shape[1]
    return equilibrium(
        flexible,
        stiffness=here.stiffness,
        gap=np.hstack([here.gap[:, :m], here.far_gap, here.gap[:, m:]]),
        force=here.force,
        flanks=here.both,
        laws=laws,
        anchor=anchor,
    )


def _presses(train: HeldTrain, here: RecordExcitation, displacement: Array) -> NDArray[np.bool_]:
    """Instants (T,) at which any far flank would press, at displacements (T, n) [m, rad]."""
    assert here.both is not None
    assert here.far_gap is not None
    touch = here.both.touch[:, here.stiffness.shape[1] :]
    pressing: NDArray[np.bool_] = np.any(displacement @ train.far.B - here.far_gap > touch, axis=1)
    return pressing
