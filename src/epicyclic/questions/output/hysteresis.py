"""Torque over angle of a locked train through both flanks: one cycle of the torque at several places of the mesh cycle.

The torque goes 0, +T, -T, +T in steps at each of which the train is in equilibrium, with far flanks, play and laws.
Where a law has a memory the steps follow each other, else each stands by itself and both branches are one.  What a
cycle dissipates is the work of the sliders, F_m |ds| summed: the area of the loop without the error of its steps.

Zero torque is left out: with play the angle is not unique there.  Angles count from mid-backlash.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ...errors import ModelError
from ...statics.record import RecordExcitation, excitation
from ...statics.static import HeldTrain, balanced, ends_of_travel, held_train, settled
from ...system.system import Array, System

# Torques between the least one and the first of the even steps, and the least per least share that is read.
_FINE, _LEAST = 6, 0.25
_DIGITS = 12  # of relative torques: two that differ by rounding are one
RANGE = (0.5, 1.0)
"""Torques per rated torque between which secant and least squares are taken."""
_STILL = 1e-12  # turning per unit of the shaft's coordinate that is none


class Loop(NamedTuple):
    """Torque over angle at P places of the mesh cycle.

    torque : (m,) rising from -rated to rated, without zero [N m].  rising, falling : (P, m) angle [rad].
    energy : (P,) of a cycle [J].  play : free travel of the shaft [rad]; nan where no backlash is known.
    """

    torque: Array
    rising: Array
    falling: Array
    energy: Array
    play: float

    @property
    def middle(self) -> Array:
        """Middle line of both branches (P, m) [rad]."""
        return np.asarray((self.rising + self.falling) / 2)

    def lost_motion(self, share: float) -> Array:
        """Angle at a share of the rated torque less that at its negative, on the middle line, (P,) [rad].

        nan where no backlash is known: senses then have zeros of their own.
        """
        ends = share * self.torque[-1] * np.array([-1.0, 1.0])
        return np.array([np.diff(np.interp(ends, self.torque, line))[0] for line in self.middle]) + 0.0 * self.play

    def stiffness(self, low: float, high: float, sense: float) -> tuple[Array, Array]:
        """Secant and least squares between two shares of the rated torque, both solved, in one sense (P,) [N m/rad]."""
        share = sense * self.torque / self.torque[-1]
        inside = (share >= low * (1 - _STILL)) & (share <= high * (1 + _STILL))
        torque, angle = self.torque[inside], self.middle[:, inside]
        secant = np.ptp(torque) / (angle[:, -1] - angle[:, 0])
        return secant, np.asarray(1 / np.polynomial.polynomial.polyfit(torque, angle.T, 1)[1])

    def tangent(self) -> Array:
        """Stiffness dT/dphi of the middle line at every torque, by differences on its own side of zero (P, m)."""
        half = self.torque.size // 2
        sides = (slice(0, half), slice(half, None))
        slopes = [np.gradient(self.middle[:, side], self.torque[side], axis=1) for side in sides]
        return np.asarray(1 / np.concatenate(slopes, axis=1))


def relative_torques(points: int, shares: Sequence[float]) -> Array:
    """Torques per rated torque, rising to 1: even steps, shares at which angles are read, and fine ones below."""
    even = np.arange(1, points + 1) / points
    fine = np.geomspace(_LEAST * min(shares), even[0], _FINE)
    return np.unique(np.round(np.concatenate([fine, even, shares, [0.5]]), _DIGITS))


def hysteresis(system: System, reverse: System | None, phases: int, relative: Array) -> Loop:
    """Torque over angle of a locked train whose one loaded shaft takes a cycle of its torque.

    Parameters
    ----------
    system : with the rated torque at its shaft.  reverse : with its negative, where a mesh has no backlash and so no
        far flank: angles then count from first touch in each sense.  phases : P places.
    relative : (k,) torques per rated torque, as of `relative_torques`.

    Raises
    ------
    ModelError : the shaft cannot turn; a load that nothing holds; a law with a memory beside a mesh without backlash.
    ConvergenceError : no equilibrium.
    """

    def at(train: System, torque: Array) -> Loop:
        return loop_at(held_train(train), excitation(train, Fraction(1), np.arange(phases), phases), torque)

    size = abs(rated_of(system)) * relative
    if reverse is None:
        return at(system, both_senses(size))
    if system.laws.memory.any():
        pair = system.meshes.pair[int(np.argmax(np.isinf(system.meshes.backlash)))]
        allowed = "a length; friction with a history goes through both flanks"
        raise ModelError("is missing", path=f"{pair}.backlash", allowed=allowed)
    back, ahead = (reverse, system) if rated_of(system) > 0 else (system, reverse)
    low, high = at(back, -size[::-1]), at(ahead, size)
    angle = np.concatenate([low.rising, high.rising], axis=1)
    return Loop(torque=both_senses(size), rising=angle, falling=angle, energy=low.energy, play=np.nan)


def loop_at(held: HeldTrain, here: RecordExcitation, torque: Array) -> Loop:
    """Torque over angle at P instants whose excitation has the rated torque, at torques (m,) [N m]; errors as above."""
    shaft = _shaft_turn(held.system)
    base = here._replace(force=here.force - rated_of(held.system) * shaft)
    balanced(held, base.force + torque[-1] * shaft)
    solve = _with_memory if held.laws.memory.any() else _each_by_itself
    displacement, energy = solve(held, base, shaft, torque)
    angle, play = (displacement @ shaft).swapaxes(1, 2), np.nan
    if np.isfinite(held.system.meshes.backlash).all():
        ahead, back = ends_of_travel(held, shaft[None])[0]
        angle, play = angle - (ahead + back) / 2, ahead - back
    return Loop(torque=torque, rising=angle[-1], falling=angle[0], energy=energy, play=play)


def both_senses(size: Array) -> Array:
    """Torques of both senses, rising, of sizes (k,)."""
    return np.concatenate([-size[::-1], size])


def rated_of(system: System) -> float:
    """Torque at the loaded shaft [N m]."""
    return float(sum((system.locked or {}).values()))


def _shaft_turn(system: System) -> Array:
    """Angle of the loaded shaft per displacement, (n,): also the force of a unit torque on it.

    Raises
    ------
    ModelError : it cannot turn.
    """
    torque = np.array([(system.locked or {}).get(name, 0.0) for name in system.dofs.bodies])
    turn: Array = torque / torque.sum() @ system.dofs.rigid[5::6]
    if not np.abs(turn).max() > _STILL:
        raise ModelError(
            "cannot turn: it is rigid with what is held", path="shaft", given=", ".join(system.locked or ())
        )
    return turn


def _each_by_itself(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array]:
    """Displacements (1, m, P, n) of both branches, which are one, and no energy (P,)."""
    phases = len(base.force)
    here = base.at(np.tile(np.arange(phases), grid.size))
    state = settled(held, here._replace(force=here.force + np.repeat(grid, phases)[:, None] * shaft))
    return state.displacement.reshape(1, grid.size, phases, -1), np.zeros(phases)


def _with_memory(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array]:
    """Displacements (2, m, P, n) of the falling and the rising branch, and what the sliders dissipate (P,) [J]."""
    laws, half = held.laws, grid.size // 2
    slider, start = np.zeros((len(base.force), laws.rows.owner.size)), None
    friction = np.where(laws.memory, laws.friction, 0.0)
    displacement, work = list[Array](), list[Array]()
    for torque in np.concatenate([grid[half:], grid[-2::-1], grid[1:]]):
        state = settled(held, base._replace(force=base.force + torque * shaft), anchor=slider, start=start)
        after = laws.slide(state.group_stretch, slider)
        displacement.append(state.displacement)
        work.append(laws.rows.size(after - slider) @ friction)
        slider, start = after, state.approach
    end = half - 1 + grid.size  # of the falling branch, the first of the rising one
    return np.array([displacement[half - 1 : end][::-1], displacement[end - 1 :]]), np.sum(work[half:], axis=0)
