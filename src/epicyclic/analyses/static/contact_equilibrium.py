"""Static equilibrium with full contact in every mesh: the least energy over the motions of the train, by Newton steps.

    E(q) = q'Kq/2 - F'q + sum_m Phi_m(B_m'q - e) + sum_g phi_g(B_g'q - e)

Phi_m is the convex potential of the contact of a mesh over its three rows (`system.contact`), phi_g that of a bearing
with play or a spline.  E is convex, so the state is one, from whatever start; steps are halved until E falls.  Motions
that nothing holds, as the turning of the whole train, are left alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...system.laws import groups as law
from ...system.laws.face import ROWS, Contact, Pressed
from ...system.system import Array, System
from .equilibrium import Compliance

__all__ = ["Problem", "Touching", "touching"]

Index = NDArray[np.int64]

# Residual per coordinate, of the sum of sizes of its terms; where nothing loads one, of the largest scaled sum.
_TOLERANCE, _FLOOR = 1e-12, 1e-13
# Stiffness that open meshes keep in the Newton matrix, of the closed train: below any support.
_OPEN = 1e-9
_STEPS, _HALVINGS = 80, 40
# Fall of the energy, of what the slope promises, that lets a step stand; fall of the residual that does.
_FALL, _DROP = 1e-4, 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem:
    """A train whose meshes stand as three rows each, at T instants.

    system; flexible : its compliance with closed rows.  contacts : of (g,) meshes each, and which they are.
    gap : (T, M) e of mesh rows and rows of groups [m].  force : (T, n) load.
    """

    system: System
    flexible: Compliance
    contacts: Sequence[tuple[Contact, Index]]
    gap: Array
    force: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Touching:
    """Static state at T instants.

    displacement : (T, n).  row_force : (T, 3 w) of all meshes [N].  approach : (T, 3 w) of their rows less errors [m].
    states : of each contact, (T, g, n).  group_force, group_stretch : (T, R).  steps : (T,) Newton steps.
    balance : (T,) residual of the coordinates, of the sum of sizes of their terms [1].  contact : (T,) of the contact
    conditions [1].
    """

    displacement: Array
    row_force: Array
    approach: Array
    states: tuple[Array, ...]
    group_force: Array
    group_stretch: Array
    steps: Index
    balance: Array
    contact: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Point:
    """A motion (t, n), what it does, and how far it is from equilibrium."""

    q: Array
    rows: Array
    pressed: tuple[Pressed, ...]
    energy: Array
    residual: Array
    balance: Array

    def put(self, at: Index, other: _Point) -> None:
        """Take the instants `at` from another point."""
        for name in ("q", "rows", "energy", "residual", "balance"):
            getattr(self, name)[at] = getattr(other, name)
        for mine, theirs in zip(self.pressed, other.pressed, strict=True):
            for name in ("force", "tangent", "energy", "residual", "state"):
                getattr(mine, name)[at] = getattr(theirs, name)


def touching(given: Problem, start: Array) -> Touching:
    """Equilibrium from a motion (T, n), such as that of the train with springs for meshes.

    Raises
    ------
    ConvergenceError : not found.  ModelError : the load drives meshing bodies apart and nothing holds them.
    """
    scale, free = _scaling(given)
    everything = np.arange(len(start), dtype=np.int64)
    point = _at(given, everything, start.copy(), None)
    steps = np.zeros(len(start), np.int64)
    todo = everything
    for _ in range(_STEPS):
        todo = todo[point.balance[todo] > 1.0]
        if not todo.size:
            return _finished(given, point, steps)
        _advance(given, point, todo, _directions(given, point, todo, scale, free))
        steps[todo] += 1
    raise ConvergenceError(f"no static equilibrium with full contact after {_STEPS} steps at {todo.size} instants")


def _scaling(given: Problem) -> tuple[Array, Array]:
    """Scale (n,) that gives the closed train a unit diagonal, and its free motions in it, orthonormal (n, r)."""
    diagonal = np.diag(given.system.mean_stiffness).copy()
    groups = given.system.group_rows
    diagonal += ((groups * given.system.laws.row_stiffness) * groups).sum(axis=1)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    free, _ = np.linalg.qr(given.flexible.free / scale[:, None])
    return scale, np.asarray(free)


def _at(given: Problem, instants: Index, q: Array, states: Sequence[Array] | None) -> _Point:
    system, laws = given.system, given.system.laws
    m = system.meshes.B.shape[1]
    gap, load = given.gap[instants], given.force[instants]
    rows = q @ system.meshes.B - gap[:, :m]
    pressed = tuple(
        contact.press(_of(rows, meshes), instants, None if states is None else states[i])
        for i, (contact, meshes) in enumerate(given.contacts)
    )
    force = np.zeros_like(rows)
    for (_, meshes), found in zip(given.contacts, pressed, strict=True):
        force.reshape(len(q), -1, ROWS)[:, meshes] = found.force
    elastic = q @ system.K
    pull = force @ system.meshes.B.T
    sizes = np.abs(q) @ np.abs(system.K) + np.abs(force) @ np.abs(system.meshes.B.T) + np.abs(load)
    energy = 0.5 * (elastic * q).sum(axis=1) - (load * q).sum(axis=1) + sum(p.energy.sum(axis=1) for p in pressed)
    residual = elastic + pull - load
    if system.groups:
        stretch = q @ system.group_rows - gap[:, m:]
        resisting = law.force(laws, stretch)
        residual = residual + resisting @ system.group_rows.T
        sizes += np.abs(resisting) @ np.abs(system.group_rows.T)
        energy = energy + law.potential(laws, stretch).sum(axis=1)
    return _Point(
        q=q, rows=rows, pressed=pressed, energy=energy, residual=residual, balance=_missed(given, residual, sizes)
    )


def _of(rows: Array, meshes: Index) -> Array:
    """Rows (t, 3 w) of some meshes, (t, g, 3)."""
    return rows.reshape(len(rows), -1, ROWS)[:, meshes]


def _missed(given: Problem, residual: Array, sizes: Array) -> Array:
    """Largest residual (t,) over what may stay of it."""
    stiff = np.sqrt(np.maximum(np.diag(given.system.mean_stiffness), np.finfo(float).tiny))
    floor = _FLOOR * np.max(sizes / stiff, axis=1)[:, None] * stiff
    allowed = np.maximum(_TOLERANCE * sizes, floor)
    missed: Array = np.max(np.abs(residual) / np.where(allowed > 0, allowed, 1.0), axis=1, initial=0.0)
    return missed


def _directions(given: Problem, point: _Point, todo: Index, scale: Array, free: Array) -> Array:
    """Newton steps (t, n)."""
    system = given.system
    n = len(scale)
    B = system.meshes.B
    matrix = np.broadcast_to(system.K + _OPEN * system.mean_stiffness, (len(todo), n, n)).copy()
    for (_, meshes), found in zip(given.contacts, point.pressed, strict=True):
        for j, mesh in enumerate(meshes.tolist()):
            rows = B[:, ROWS * mesh : ROWS * mesh + ROWS]
            matrix += rows @ found.tangent[todo, j] @ rows.T
    if system.groups:
        stretch = point.q[todo] @ system.group_rows - given.gap[todo][:, B.shape[1] :]
        groups = system.group_rows
        matrix += groups @ law.tangent(system.laws, stretch) @ groups.T
        matrix += _OPEN * (groups * system.laws.row_stiffness) @ groups.T
    scaled = scale[:, None] * matrix * scale + free @ free.T
    step = np.linalg.solve(scaled, (scale * point.residual[todo])[:, :, None])[:, :, 0]
    step -= (step @ free) @ free.T
    return -scale * step


def _advance(given: Problem, point: _Point, todo: Index, direction: Array) -> None:
    """Move every instant along its step, halved until the energy or the residual falls."""
    slope = (direction * point.residual[todo]).sum(axis=1)
    length = np.ones(len(todo))
    waiting = np.arange(len(todo))
    for _ in range(_HALVINGS):
        at = todo[waiting]
        q = point.q[at] + length[waiting, None] * direction[waiting]
        trial = _at(given, at, q, [found.state[at] for found in point.pressed])
        fallen = trial.energy <= point.energy[at] + _FALL * length[waiting] * slope[waiting]
        good = fallen | (trial.balance <= _DROP * point.balance[at])
        taken = np.flatnonzero(good)
        point.put(at[taken], _taken(trial, taken))
        waiting = waiting[~good]
        if not waiting.size:
            return
        length[waiting] /= 2
    # rounding of the energy hides what is left to gain: take the step as it is, and let the balance judge
    at = todo[waiting]
    point.put(at, _at(given, at, point.q[at] + direction[waiting], [found.state[at] for found in point.pressed]))


def _taken(point: _Point, keep: NDArray[np.intp]) -> _Point:
    pressed = tuple(
        Pressed(
            force=p.force[keep],
            tangent=p.tangent[keep],
            energy=p.energy[keep],
            residual=p.residual[keep],
            state=p.state[keep],
        )
        for p in point.pressed
    )
    return _Point(
        q=point.q[keep],
        rows=point.rows[keep],
        pressed=pressed,
        energy=point.energy[keep],
        residual=point.residual[keep],
        balance=point.balance[keep],
    )


def _finished(given: Problem, point: _Point, steps: Index) -> Touching:
    system, m = given.system, given.system.meshes.B.shape[1]
    force = np.zeros_like(point.rows)
    for (_, meshes), found in zip(given.contacts, point.pressed, strict=True):
        force.reshape(len(force), -1, ROWS)[:, meshes] = found.force
    if not np.isfinite(force).all():
        raise ModelError("the load drives meshing bodies apart and nothing holds them", path="operation.torque")
    stretch = point.q @ system.group_rows - given.gap[:, m:]
    return Touching(
        displacement=point.q,
        row_force=force,
        approach=point.rows,
        states=tuple(found.state for found in point.pressed),
        group_force=law.force(system.laws, stretch) if system.groups else stretch,
        group_stretch=stretch,
        steps=steps,
        balance=point.balance * _TOLERANCE,
        contact=np.max([found.residual.max(axis=1) for found in point.pressed], axis=0),
    )
