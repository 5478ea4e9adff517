"""Torque over angle of a locked train through both flanks: one cycle of the torque at several places of the mesh cycle.

The torque goes 0, +T, -T, +T in steps at each of which the train is in equilibrium, with far flanks, play and laws.
Where a law has a memory the steps follow each other, else each stands by itself and both branches are one.  What a
cycle dissipates is the work of the sliders, F_m |ds| summed: the area of the loop without the error of its steps.

Zero torque is left out: with play the angle is not unique there.  Angles count from mid-backlash.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ...errors import ModelError
from ...statics.record import RecordExcitation, excitation
from ...statics.static import HeldTrain, balanced, held_train, locked_columns, settled
from ...system.system import Array, System

# Torques between the least one and the first of the even steps, and the least per least share that is read.
_FINE, _LEAST = 6, 0.25
_AT_ONCE = 512  # trains whose torques are solved at once
_DIGITS = 12  # of relative torques: two that differ by rounding are one
_STILL = 1e-12  # turning per unit of the shaft's coordinate that is none


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
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
        line: Array = (self.rising + self.falling) / 2
        return line

    def lost_motion(self, share: float) -> Array:
        """Angle at a share of the rated torque less that at its negative, on the middle line, (P,) [rad].

        nan where no backlash is known: senses then have zeros of their own.
        """
        if np.isnan(self.play):
            return np.full(len(self.rising), np.nan)
        most = self.torque[-1]
        ends = [self._at(sense * share * most) for sense in (1.0, -1.0)]
        return ends[0] - ends[1]

    def secant(self, low: float, high: float, sense: float) -> Array:
        """Torque per angle between two shares of the rated torque, in one sense, (P,) [N m/rad]."""
        most = sense * self.torque[-1]
        slope: Array = most * (high - low) / (self._at(high * most) - self._at(low * most))
        return slope

    def fitted(self, low: float, high: float, sense: float) -> Array:
        """Stiffness of the least squares of the angle over the torque between two shares, (P,) [N m/rad]."""
        share = sense * self.torque / self.torque[-1]
        inside = (share >= low * (1 - _STILL)) & (share <= high * (1 + _STILL))
        slope = np.polynomial.polynomial.polyfit(self.torque[inside], self.middle[:, inside].T, 1)[1]
        return np.asarray(1 / slope)

    def tangent(self) -> Array:
        """Stiffness dT/dphi of the middle line at every torque, by differences on its own side of zero (P, m)."""
        half = self.torque.size // 2
        sides = (slice(0, half), slice(half, None))
        slopes = [np.gradient(self.middle[:, side], self.torque[side], axis=1) for side in sides]
        return np.asarray(1 / np.concatenate(slopes, axis=1))

    def _at(self, torque: float) -> Array:
        """Middle line at a torque, (P,) [rad]."""
        return np.array([np.interp(torque, self.torque, line) for line in self.middle])


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
    rated = _rated(system)
    size = abs(rated) * relative
    grid = np.concatenate([-size[::-1], size])
    if reverse is None:
        falling, rising, energy, play = _both_branches(system, phases, grid)
        return Loop(torque=grid, rising=rising, falling=falling, energy=energy, play=play)
    if held_train(system).laws.memory.any():
        pair = system.meshes.pair[int(np.argmax(np.isinf(system.meshes.backlash)))]
        allowed = "a length; friction with a history goes through both flanks"
        raise ModelError("is missing", path=f"{pair}.backlash", allowed=allowed)
    back, ahead = (reverse, system) if rated > 0 else (system, reverse)
    halves = [_both_branches(back, phases, -size[::-1]), _both_branches(ahead, phases, size)]
    angle = np.concatenate([half[0] for half in halves], axis=1)
    return Loop(torque=grid, rising=angle, falling=angle, energy=np.zeros(phases), play=np.nan)


def _both_branches(system: System, phases: int, grid: Array) -> tuple[Array, Array, Array, float]:
    """Falling and rising angle (P, m) [rad] at torques (m,), energy (P,) [J] and play [rad]."""
    base = excitation(system, Fraction(1), np.arange(phases), phases)
    return _branches_at(held_train(system), base._replace(force=base.force - shaft_load(system)), grid)


def _branches_at(held: HeldTrain, base: RecordExcitation, grid: Array) -> tuple[Array, Array, Array, float]:
    """The same at P instants whose excitation has no torque at the shaft."""
    shaft = _shaft_turn(held.system)
    balanced(held, base.force + grid[-1] * shaft)
    solve = _with_memory if held.laws.memory.any() else _each_by_itself
    *displacements, energy = solve(held, base, shaft, grid)
    angle, play = _angles(held, np.concatenate(displacements).reshape(-1, shaft.size))
    falling, rising = angle.reshape(2, grid.size, -1).transpose(0, 2, 1)
    return falling, rising, energy, play


def loop_of_samples(held: HeldTrain, base: RecordExcitation, shares: Sequence[float]) -> Loop:
    """Torque over angle of S trains of one drawing, as of `hysteresis`, at shares of the rated torque and at that.

    base : S instants, whose excitation has no torque at the shaft.

    Raises
    ------
    ConvergenceError : no equilibrium.
    """
    size = abs(_rated(held.system)) * np.unique([*shares, 1.0])
    grid = np.concatenate([-size[::-1], size])
    pieces = [
        _branches_at(held, base.at(np.arange(first, min(first + _AT_ONCE, len(base.force)))), grid)
        for first in range(0, len(base.force), _AT_ONCE)
    ]
    falling, rising, energy = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    return Loop(torque=grid, rising=rising, falling=falling, energy=energy, play=pieces[0][3])


def shaft_load(system: System) -> Array:
    """The rated torque as a force (n,) [N, N m]."""
    return _rated(system) * _shaft_turn(system)


def _rated(system: System) -> float:
    """Torque at the loaded shaft [N m]."""
    return float(sum((system.locked or {}).values()))


def _weights(system: System, names: Sequence[str]) -> Array:
    """Part of the torque on each of the named bodies of the loaded shaft, (b,) [1]."""
    torque = system.locked or {}
    part = np.array([torque.get(name, 0.0) for name in names])
    return np.asarray(part / sum(torque.values()))


def _shaft_turn(system: System) -> Array:
    """Angle of the loaded shaft per displacement, (n,): also the force of a unit torque on it.

    Raises
    ------
    ModelError : it cannot turn.
    """
    turn: Array = _weights(system, system.dofs.bodies) @ system.dofs.expand[5::6]
    if not np.abs(turn).max() > _STILL:
        raise ModelError(
            "cannot turn: it is rigid with what is held", path="shaft", given=", ".join(system.locked or ())
        )
    return turn


def _angles(held: HeldTrain, displacement: Array) -> tuple[Array, float]:
    """Angle of the loaded shaft (T,) of displacements (T, n), and its play [rad], nan where no backlash is known."""
    columns = locked_columns(held, displacement)
    weight = _weights(held.system, columns["body"][1])
    play = float(weight @ columns["play"][1]) if "play" in columns else np.nan
    return np.asarray(weight @ columns["angle"][1]), play


def _each_by_itself(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array, Array]:
    """Displacements (m, P, n) of both branches, which are one, and no energy (P,)."""
    phases = len(base.force)
    here = base.at(np.tile(np.arange(phases), grid.size))
    state = settled(held, here._replace(force=here.force + np.repeat(grid, phases)[:, None] * shaft))
    displacement = state.displacement.reshape(grid.size, phases, -1)
    return displacement, displacement, np.zeros(phases)


def _with_memory(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array, Array]:
    """Displacements (m, P, n) of the falling and the rising branch, and what the sliders dissipate in both (P,) [J]."""
    laws, half = held.laws, grid.size // 2
    slider, start = np.zeros((len(base.force), laws.rows.owner.size)), None
    path = np.concatenate([grid[half:], grid[-2::-1], grid[1:]])
    friction = np.where(laws.memory, laws.friction, 0.0)
    displacement, work = list[Array](), list[Array]()
    for torque in path:
        state = settled(held, base._replace(force=base.force + torque * shaft), anchor=slider, start=start)
        after = laws.slide(state.group_stretch, slider)
        displacement.append(state.displacement)
        work.append(laws.rows.size(after - slider) @ friction)
        slider, start = after, state.approach
    falling = np.array(displacement[half - 1 : half - 1 + grid.size])[::-1]
    rising = np.array(displacement[half - 2 + grid.size :])
    return falling, rising, np.sum(work[half:], axis=0)
