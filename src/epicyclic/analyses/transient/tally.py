"""Extremes of mesh forces, time apart and impacts, tallied over every step of an integration.

An impact lasts a few steps; samples kept at some instants of a mesh cycle pass over it.  Every step is tallied with the
forces at its beginning, which the integrator has worked out anyway; the end of a run is one of its samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...system.system import Array
from .motion import Motion

__all__ = ["APART", "FAR", "IMPACTS", "LEAST", "LEAST_AT", "MOST", "MOST_AT", "TOUCHED", "Tally", "empty_tally", "note"]

# Columns of `Tally.mesh`.
LEAST, LEAST_AT, MOST, MOST_AT, APART, FAR, IMPACTS, TOUCHED = range(8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tally:
    """What the steps of a run have met; both arrays are filled in place.

    mesh : (w, 8) of the w whole meshes: least force [N], when [s], largest force [N], when [s], time in which no flank
        presses [s], time in which a far flank presses [s], how often a flank presses again, and whether one did at the
        last step, -1 before the first.
    flank : (F, 2) largest force of every flank [N], and the time in which it is not above zero [s].

    A flank presses where its law does, also where its damper pulls more than that.
    """

    mesh: Array
    flank: Array

    def copy(self) -> Tally:
        """The same in arrays of its own."""
        return Tally(mesh=self.mesh.copy(), flank=self.flank.copy())

    def flat(self) -> Array:
        """All numbers in a row, (8 w + 2 F,)."""
        return np.concatenate([self.mesh.ravel(), self.flank.ravel()])

    def of(self, flat: Array) -> Tally:
        """A tally of the same shape from its numbers in a row."""
        first = self.mesh.size
        return Tally(mesh=flat[:first].reshape(self.mesh.shape), flank=flat[first:].reshape(self.flank.shape))


def empty_tally(moving: Motion) -> Tally:
    """The tally of a run before its first step."""
    N = moving.numbers
    mesh = np.zeros((int(N.whole.max(initial=-1)) + 1, 8))
    mesh[:, LEAST], mesh[:, MOST], mesh[:, TOUCHED] = np.inf, -np.inf, -1.0
    return Tally(mesh=mesh, flank=np.zeros((N.whole.size, 2)))


def note(moving: Motion, tally: Tally, force: Array, moment: float, span: float) -> None:
    """Add the forces of all flanks (F,) [N] at the beginning of a step, at a moment [s], of a length span [s].

    As `compiled._note`.  Forces that are not finite are left out.
    """
    N, mesh, flank = moving.numbers, tally.mesh, tally.flank
    if not np.isfinite(force).all():
        return
    far, presses = np.arange(force.size) >= N.loaded, force != 0
    total, state = np.zeros(len(mesh)), np.zeros((2, len(mesh)), bool)
    np.add.at(total, N.whole, np.where(far, -force, force))
    np.logical_or.at(state[0], N.whole, presses)
    np.logical_or.at(state[1], N.whole, presses & far)
    flank[:, 0] = np.maximum(flank[:, 0], force)
    flank[:, 1] += np.where(force > 0, 0.0, span)
    less, more = total < mesh[:, LEAST], total > mesh[:, MOST]
    mesh[less, LEAST], mesh[less, LEAST_AT] = total[less], moment
    mesh[more, MOST], mesh[more, MOST_AT] = total[more], moment
    mesh[:, APART] += np.where(state[0], 0.0, span)
    mesh[:, FAR] += np.where(state[1], span, 0.0)
    mesh[:, IMPACTS] += state[0] & (mesh[:, TOUCHED] == 0)
    mesh[:, TOUCHED] = state[0]
