"""Static equilibrium with full tooth contact in every mesh: the least energy over the motions of the train.

    E(q) = q'Kq/2 - F'q + sum_m Phi_m(B_m'q - e) + sum_g phi_g(B_g'q - e)

Phi_m is the convex potential of the contact of a mesh over its three rows (`system.flank_laws`), phi_g that of a
bearing with play or a spline.  E is convex, so the state is unique, from whatever start.  Newton steps are halved until
E falls [nocedal2006, sec. 3.1].  Motions that nothing holds, as the turning of the whole train, are left alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ConvergenceError, ModelError
from ..system.flank_laws import ROWS, FaceContact, FaceForce
from ..system.system import Array, Index, System
from .equilibrium import Compliance

# Residual per coordinate, of the sum of sizes of its terms; where nothing loads one, of the largest scaled sum.
_TOLERANCE, _FLOOR = 1e-12, 1e-13
# Stiffness that open meshes keep in the Newton matrix, of the closed train: below any support.
_OPEN = 1e-9
_STEPS, _HALVINGS = 80, 40
# Sufficient decrease of the energy, per what the slope predicts [nocedal2006, sec. 3.1]; drop of the residual that
# accepts a step as well.
_DECREASE, _DROP = 1e-4, 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactProblem:
    """A train whose meshes stand as three rows each, at T instants.

    system; flexible : its compliance with closed rows.  contacts : of (g,) meshes each, and which they are.
    gap : (T, M) e of mesh rows and rows of groups [m].  force : (T, n) load [N, N m].
    """

    system: System
    flexible: Compliance
    contacts: Sequence[tuple[FaceContact, Index]]
    gap: Array
    force: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactEquilibrium:
    """Static state at T instants.

    displacement : (T, n) [m, rad].  row_force : (T, 3 w) of all meshes [N].  approach : (T, 3 w) of rows less errors
        [m].
    states : of each contact, (T, g, n).  group_force, group_stretch : (T, R) [N], [m].  steps : (T,) Newton steps.
    force_residual : (T,) of the coordinates, of the sum of sizes of their terms [1].
    contact_residual : (T,) of the contact conditions [1].
    """

    displacement: Array
    row_force: Array
    approach: Array
    states: tuple[Array, ...]
    group_force: Array
    group_stretch: Array
    steps: Index
    force_residual: Array
    contact_residual: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Point:
    """A motion q (t, n) [m, rad], contact forces and energy there, and its distance from equilibrium."""

    q: Array
    rows: Array
    row_force: Array
    contact_states: tuple[FaceForce, ...]
    energy: Array
    residual: Array
    force_residual: Array

    def assign(self, at: Index, other: _Point, chosen: Index | slice) -> None:
        """Overwrite the instants `at` (t,) by those `chosen` of another point."""
        for name in ("q", "rows", "row_force", "energy", "residual", "force_residual"):
            getattr(self, name)[at] = getattr(other, name)[chosen]
        for contact, trial in zip(self.contact_states, other.contact_states, strict=True):
            for name in ("force", "tangent", "energy", "residual", "state"):
                getattr(contact, name)[at] = getattr(trial, name)[chosen]


def contact_equilibrium(problem: ContactProblem, start: Array) -> ContactEquilibrium:
    """Equilibrium from a start (T, n) [m, rad], such as that of the train with springs for meshes.

    Raises
    ------
    ConvergenceError : not found.  ModelError : the load drives meshing bodies apart and nothing holds them.
    """
    scale = problem.flexible.scale
    free, _ = np.linalg.qr(problem.flexible.free / scale[:, None])
    todo = np.arange(len(start), dtype=np.int64)
    point = _evaluated(problem, todo, start.copy(), None)
    steps = np.zeros(len(start), np.int64)
    for _ in range(_STEPS):
        todo = todo[point.force_residual[todo] > 1.0]
        if not todo.size:
            return _result(problem, point, steps)
        _backtracked(problem, point, todo, _newton_steps(problem, point, todo, scale, free))
        steps[todo] += 1
    raise ConvergenceError(f"no static equilibrium with full contact after {_STEPS} steps at {todo.size} instants")


def _evaluated(problem: ContactProblem, instants: Index, q: Array, states: Sequence[Array] | None) -> _Point:
    """Rows, contact forces, energy and residual of motions q (t, n) [m, rad] at the chosen instants."""
    system, laws = problem.system, problem.system.laws
    m = system.meshes.B.shape[1]
    gap, load = problem.gap[instants], problem.force[instants]
    rows = q @ system.meshes.B - gap[:, :m]
    contact_states = tuple(
        contact.press(rows.reshape(len(q), -1, ROWS)[:, meshes], instants, None if states is None else states[i])
        for i, (contact, meshes) in enumerate(problem.contacts)
    )
    force = np.zeros_like(rows)
    for (_, meshes), pressed in zip(problem.contacts, contact_states, strict=True):
        force.reshape(len(q), -1, ROWS)[:, meshes] = pressed.force
    elastic = q @ system.K
    pull = force @ system.meshes.B.T
    sizes = np.abs(q) @ np.abs(system.K) + np.abs(force) @ np.abs(system.meshes.B.T) + np.abs(load)
    energy = (
        0.5 * (elastic * q).sum(axis=1) - (load * q).sum(axis=1) + sum(p.energy.sum(axis=1) for p in contact_states)
    )
    stretch = q @ system.group_rows - gap[:, m:]
    resisting = laws.force(stretch)
    residual = elastic + pull - load + resisting @ system.group_rows.T
    sizes += np.abs(resisting) @ np.abs(system.group_rows.T)
    energy = energy + laws.potential(stretch).sum(axis=1)
    # largest residual over its convergence limit, which follows the sizes of the terms
    stiff = np.sqrt(np.maximum(np.diag(system.mean_stiffness), np.finfo(float).tiny))
    allowed = np.maximum(_TOLERANCE * sizes, _FLOOR * np.max(sizes / stiff, axis=1)[:, None] * stiff)
    relative = np.abs(residual) / np.where(allowed > 0, allowed, 1.0)
    return _Point(
        q=q,
        rows=rows,
        row_force=force,
        contact_states=contact_states,
        energy=energy,
        residual=residual,
        force_residual=np.asarray(np.max(relative, axis=1, initial=0.0)),
    )


def _newton_steps(problem: ContactProblem, point: _Point, todo: Index, scale: Array, free: Array) -> Array:
    """Newton steps (t, n) [m, rad] without any part along the free motions."""
    system = problem.system
    n = len(scale)
    B = system.meshes.B
    matrix = np.broadcast_to(system.K + _OPEN * system.mean_stiffness, (len(todo), n, n)).copy()
    for (_, meshes), pressed in zip(problem.contacts, point.contact_states, strict=True):
        for j, mesh in enumerate(meshes.tolist()):
            rows = B[:, ROWS * mesh : ROWS * mesh + ROWS]
            matrix += rows @ pressed.tangent[todo, j] @ rows.T
    groups, laws = system.group_rows, system.laws
    stretch = point.q[todo] @ groups - problem.gap[todo][:, B.shape[1] :]
    matrix += groups @ laws.tangent(stretch) @ groups.T
    matrix += _OPEN * (groups * laws.row_stiffness) @ groups.T
    scaled = scale[:, None] * matrix * scale + free @ free.T
    step = np.linalg.solve(scaled, (scale * point.residual[todo])[:, :, None])[:, :, 0]
    step -= (step @ free) @ free.T
    return -scale * step


def _backtracked(problem: ContactProblem, point: _Point, todo: Index, direction: Array) -> None:
    """Move every instant along its step, halved until the energy or the residual falls [nocedal2006, sec. 3.1].

    Halving stands in a batch: every instant keeps its own length, and the contact of all waiting ones is solved at
    once.
    """

    def tried(waiting: Index, length: Array | float) -> _Point:
        """The point that steps of some of the waiting instants reach, from the contact they have."""
        at = todo[waiting]
        q = point.q[at] + length * direction[waiting]
        return _evaluated(problem, at, q, [pressed.state[at] for pressed in point.contact_states])

    slope = (direction * point.residual[todo]).sum(axis=1)
    length = np.ones(len(todo))
    waiting = np.arange(len(todo))
    for _ in range(_HALVINGS):
        at = todo[waiting]
        trial = tried(waiting, length[waiting, None])
        descends = trial.energy <= point.energy[at] + _DECREASE * length[waiting] * slope[waiting]
        accept = descends | (trial.force_residual <= _DROP * point.force_residual[at])
        accepted = np.flatnonzero(accept)
        point.assign(at[accepted], trial, accepted)
        waiting = waiting[~accept]
        if not waiting.size:
            return
        length[waiting] /= 2
    # rounding of the energy hides what is left to gain: the full step is taken, and the residual decides
    point.assign(todo[waiting], tried(waiting, 1.0), slice(None))


def _result(problem: ContactProblem, point: _Point, steps: Index) -> ContactEquilibrium:
    """The state (T, ..) of a converged point.

    Raises
    ------
    ModelError : forces are not finite.
    """
    system, m = problem.system, problem.system.meshes.B.shape[1]
    if not np.isfinite(point.row_force).all():
        raise ModelError("the load drives meshing bodies apart and nothing holds them", path="operation.torque")
    stretch = point.q @ system.group_rows - problem.gap[:, m:]
    return ContactEquilibrium(
        displacement=point.q,
        row_force=point.row_force,
        approach=point.rows,
        states=tuple(pressed.state for pressed in point.contact_states),
        group_force=system.laws.force(stretch) if system.groups else stretch,
        group_stretch=stretch,
        steps=steps,
        force_residual=point.force_residual * _TOLERANCE,
        contact_residual=np.max([pressed.residual.max(axis=1) for pressed in point.contact_states], axis=0),
    )
