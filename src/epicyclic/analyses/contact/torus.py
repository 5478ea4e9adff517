"""Contact loss with shaft orders: a balance on the torus of the mesh phases and a few slow phases.

Points are combinations of mesh orders, as of mesh tones alone, with slow orders |s_1| / H_1 + |s_2| / H_2 + .. <= 1.
The solution of the mesh orders is where it starts; harmonics and slow orders grow until what is dropped is small.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...system.faces import Faces, faces
from ...system.system import Array
from ..harmonic.excitation import Shaft
from ..harmonic.lattice import kept_points
from ..harmonic.response import Response
from .balance import Problem, State, evaluate, problem, unknowns
from .beyond import Beyond, beyond, dropped
from .newton import TOLERANCE, Found, dynamic_size, linear_start, solve
from .precondition import preconditioned
from .slow import SlowTones, slow_tones

__all__ = ["DROPPED", "Size", "Torus", "TorusPoint", "embedded", "mesh_points", "respond_torus", "torus"]

Index = NDArray[np.int64]

# What may be dropped of the motion, relative to its dynamic part: forces then have that error at an instant and about
# its square in their RMS.
DROPPED = 1e-2
# Most phases in all, by the number of mesh tones; samples of a mesh phase, at least and per harmonic, by the same; per
# slow order.  Twice as many without slow phases, and where dampers of meshes make forces jump.
_PHASES, _FEWEST, _FINE, _FINE_SLOW = {1: 4, 2: 3}, {1: 96}, {1: 8}, 4
# First and last orders of a slow tone, by the number of them.
_FIRST, _LAST = {1: 4, 2: 3, 3: 2}, {1: 8, 2: 5, 3: 3}
# Harmonics: least, most to begin with, most, the last two by the number of mesh tones; cross order: first, step, last.
_LEAST, _BEGIN, _MOST = 12, {1: 32, 2: 16, 3: 12}, {1: 64, 2: 24, 3: 16}
_CROSS, _STEP, _CROSS_LAST = 8, 2, {1: 0, 2: 14, 3: 8}
# Factors of the shaft lines on the way to them where Newton's method fails at once.
_RISING = (0.25, 0.5, 0.75, 1.0)
# Newton steps of one try, which succeed in 3 to 8 or not at all; residual that is enough on the way.
_STEPS, _ON_THE_WAY = 10, 1e-3
# Residual that is enough where dampers of meshes make forces jump: about what one sample that jumps is worth.
_JUMP = 1e-4
# Speeds, as parts of the one wanted beside it, from which it is approached where that fails too, and mesh orders alone.
_NEARBY, _FAR = (0.05, 0.035, 0.02, 0.01, 0.0), (0.15, 0.11, 0.08, 0.05, 0.03, 0.01, 0.0)


class Size(NamedTuple):
    """Harmonics of each mesh tone, cross order of their combinations, highest order of each slow tone."""

    harmonics: tuple[int, ...]
    cross: int
    orders: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Torus:
    """A System ready to be solved with contact loss and shaft orders at any speed.

    slow : the shaft lines as slow tones.  every : all groups of shaft lines that count.  face : whole meshes.
    problems : those made so far, by size.
    """

    ready: Response
    slow: SlowTones
    every: tuple[Shaft, ...]
    face: Faces
    problems: dict[Size, tuple[Problem, Beyond]] = field(default_factory=dict)

    @property
    def flat(self) -> Torus:
        """The mesh tones alone, all shaft lines left."""
        return replace(self, slow=SlowTones(tones=(), highest=(), lines=(), left=self.every))

    @property
    def fewer(self) -> Torus:
        """One slow tone less."""
        slow = slow_tones(self.ready, self.every, most=len(self.slow.tones) - 1)
        return replace(self, slow=slow, problems={})

    @property
    def mesh_tones(self) -> int:
        """Number of mesh tones."""
        return len(self.ready.lines.tones)

    @property
    def tones(self) -> Array:
        """Mesh tones and slow tones at the operating speed, (D,) [rad/s]."""
        return np.concatenate([self.ready.omega, 2 * np.pi * np.array([float(tone) for tone in self.slow.tones])])

    def problem(self, size: Size) -> tuple[Problem, Beyond]:
        """The balance with so many rows and what it drops, made once."""
        if size not in self.problems:
            made = _problem(self, size)
            self.problems[size] = made, beyond(made, self.tones, mesh=self.mesh_tones, orders=size.orders)
        return self.problems[size]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TorusPoint:
    """What became of one speed.

    state : the motion, of `problem`.  size : rows kept.  converged : whether Newton's method did.
    residual : of the rows kept; dropped : of the rows dropped, by kind (each mesh tone, combinations of mesh tones,
    each slow tone); both relative to the dynamic part.  calls : products with the derivative.
    """

    problem: Problem
    state: State
    size: Size
    converged: bool
    residual: float
    dropped: Array
    calls: int

    @property
    def status(self) -> str:
        """``ok``; ``coarse`` where more is dropped than wanted although no more may be kept; or what went wrong."""
        if not np.isfinite(self.residual):
            return "not finite"
        if not self.converged:
            return "not converged"
        return "ok" if float(np.linalg.norm(self.dropped)) <= DROPPED else "coarse"


def torus(ready: Response, *, shaft_orders: bool = True, most: int | None = None) -> Torus:
    """Prepare a System for contact loss with shaft orders.

    Parameters
    ----------
    shaft_orders : whether shaft lines count.
    most : slow tones at most; None: 3 beside one mesh tone, 1 beside two, 0 beside more.  The rest is in
        ``slow.left``.
    """
    tones = len(ready.lines.tones)
    room = max(0, _PHASES.get(tones, tones) - tones) if most is None else most
    every = ready.lines.shaft if shaft_orders else ()
    return Torus(ready=ready, slow=slow_tones(ready, every, most=room), every=every, face=faces(ready.system.meshes))


def respond_torus(
    given: Torus, speed: float, *, start: tuple[Index, Array] | None = None, tolerance: float = TOLERANCE
) -> TorusPoint:
    """The steady motion at one relative speed, all phases of mesh and slow tones at once.

    Parameters
    ----------
    start : lattice points (J, D) and a motion (2, J, n) to start from, of mesh orders alone or of a whole torus: which
        branch is found where there are several.  None: the solution of the mesh orders next to the linear one.
    tolerance : relative residual of the rows kept.

    Raises
    ------
    Nothing: a speed that fails comes back with its status.
    """
    size = _start(given, speed)
    with np.errstate(all="ignore"):  # a motion that overflows ends as not finite
        points, y = _mesh_orders(given, size, speed, tolerance) if start is None else start
        point = _solved(given, size, speed, points, y, tolerance)
        if start is None and not point.converged:
            point = _approached(given, point, speed, tolerance)
        while point.converged and float(np.linalg.norm(point.dropped)) > DROPPED:
            larger = _larger(given, point)
            if larger == point.size:
                break
            finer = _solved(given, larger, speed, point.problem.grid.points, point.state.y, tolerance)
            finer = replace(finer, calls=finer.calls + point.calls)
            if not finer.converged:
                break  # the coarser solution stands, and says what it dropped
            point = finer
    return point


def _approached(given: Torus, lost: TorusPoint, speed: float, tolerance: float) -> TorusPoint:
    """The motion reached from a speed nearby, from above and then from below; the lost point where neither is."""
    calls = lost.calls
    for side in (1.0, -1.0):
        points, y = _mesh_orders(given, lost.size, speed * (1 + side * _NEARBY[0]), tolerance)
        for part in _NEARBY:
            here = speed * (1 + side * part)
            point = _solved(given, lost.size, here, points, y, tolerance, rescue=False)
            calls += point.calls
            if not point.converged:
                break
            points, y = point.problem.grid.points, point.state.y
        if point.converged:
            return replace(point, calls=calls)
    return replace(lost, calls=calls)


def _mesh_orders(given: Torus, size: Size, speed: float, tolerance: float) -> tuple[Index, Array]:
    """The motion of the mesh orders alone, as far as Newton's method came: from the linear one, or from near speeds."""
    mesh, _ = given.problem(size._replace(orders=()))
    first = found = solve(mesh, linear_start(mesh, speed), speed, tolerance=tolerance, step=preconditioned(given.face))
    for side in (1.0, -1.0):
        if found.converged:
            break
        y = linear_start(mesh, speed * (1 + side * _FAR[0]))
        for part in _FAR:
            step = preconditioned(given.face)
            found = solve(mesh, y, speed * (1 + side * part), tolerance=tolerance, steps=_STEPS, step=step)
            if not found.converged:
                break
            y = found.state.y
    return mesh.grid.points, (found if found.converged else first).state.y


def _solved(
    given: Torus, size: Size, speed: float, points: Index, y: Array, tolerance: float, *, rescue: bool = True
) -> TorusPoint:
    """One size: from the motion given, else with shaft lines that rise from a quarter."""
    made, outside = given.problem(size)
    step, start = preconditioned(given.face), embedded(made, points, y)
    if points.shape[1] == given.mesh_tones and size.orders:
        start = _with_lines(given, made, start, speed)
    found = solve(made, start, speed, tolerance=tolerance, steps=_STEPS, step=step)
    calls = found.calls
    if not found.converged and size.orders and rescue:
        found = _risen(given, made, start, speed, tolerance)
        calls += found.calls
    scale = dynamic_size(found.state.y)
    enough = given.ready.system.meshes.damping.any() and found.state.norm <= _JUMP * scale
    return TorusPoint(
        problem=made,
        state=found.state,
        size=size,
        converged=found.converged or bool(enough),
        residual=found.state.norm / scale,
        dropped=dropped(made, found.state, outside) / scale,
        calls=calls,
    )


def _with_lines(given: Torus, made: Problem, y: Array, speed: float) -> Array:
    """A motion of mesh orders and the linear response to the shaft lines of flanks that touch when they do in it.

    Slow errors are mostly followed by the bodies: on their own, before these have moved, they would part all flanks.
    """
    touching = evaluate(_dimmed(given, made, 0.0), y, speed).touching
    state = evaluate(made, y, speed, touching=touching)
    move, _ = preconditioned(given.face)(made, state, state.residual, 0.0)
    return y - move


def _dimmed(given: Torus, made: Problem, factor: float) -> Problem:
    """The same with a part of the shaft lines."""
    scale = np.where(made.grid.points[:, given.mesh_tones :].any(axis=1), factor, 1.0)
    return replace(made, error=np.concatenate([scale, scale])[:, None] * made.error, force=scale[:, None] * made.force)


def _risen(given: Torus, made: Problem, start: Array, speed: float, tolerance: float) -> Found:
    """Newton's method with a part of the shaft lines, and then with more and more of them."""
    slow = made.grid.points[:, given.mesh_tones :].any(axis=1)
    scale = np.where(slow, _RISING[0], 1.0)[:, None]
    y, calls = scale * start, 0
    for factor in _RISING:
        final = factor == _RISING[-1]
        dimmed, wanted = (made, tolerance) if final else (_dimmed(given, made, factor), _ON_THE_WAY)
        found = solve(dimmed, y, speed, tolerance=wanted, steps=_STEPS, step=preconditioned(given.face))
        y, calls = found.state.y, calls + found.calls
        if not found.converged:
            break
    return replace(found, converged=found.converged and final, calls=calls)


def embedded(given: Problem, points: Index, y: Array) -> Array:
    """A motion on other lattice points, of fewer phases too; rows it has not are 0, those it has not here are left."""
    D = given.grid.points.shape[1]
    place = {tuple(point): i for i, point in enumerate(given.grid.points.tolist())}
    at = np.array([place.get((*point, *(0,) * (D - len(point))), -1) for point in points.tolist()])
    result = np.zeros(unknowns(given))
    result[:, at[at >= 0]] = y[:, at >= 0]
    return result


def _start(given: Torus, speed: float) -> Size:
    """Rows to begin with: harmonics that reach beyond the highest mode, slow orders that hold every line."""
    lines, slow, D = given.ready.lines, given.slow, given.mesh_tones
    highest = float(np.sqrt(given.ready.modal.squared.max(initial=0.0)))
    with np.errstate(all="ignore"):
        reach = np.nan_to_num(np.ceil(1.7 * highest / (abs(speed) * given.ready.omega)), nan=_LEAST, posinf=1e6)
    harmonics = tuple(
        int(max(min(max(_LEAST, wanted), _BEGIN.get(D, _LEAST)), top + 2))
        for wanted, top in zip(reach, lines.highest, strict=True)
    )
    placed = [point[:D] for point, _, _ in slow.lines]
    cross = max((sum(map(abs, point)) for point in placed if np.count_nonzero(point) > 1), default=0)
    count = len(slow.tones)
    orders = tuple(max(_FIRST.get(count, 2), top + 1) for top in slow.highest)
    while any(_weight(point[D:], orders) > 1 for point, _, _ in slow.lines):
        orders = tuple(order + 1 for order in orders)
    return Size(harmonics, max(_CROSS, cross) if D > 1 else 0, orders)


def _larger(given: Torus, point: TorusPoint) -> Size:
    """More rows of the kinds that drop more than their part."""
    size, D, count = point.size, given.mesh_tones, len(given.slow.tones)
    poor = point.dropped > DROPPED / np.sqrt(point.dropped.size)
    most, last, cross = _MOST.get(D, _LEAST), _LAST.get(count, 2), _CROSS_LAST.get(D, _CROSS)
    return Size(
        tuple(max(H, min(most, H + H // 2)) if poor[j] else H for j, H in enumerate(size.harmonics)),
        max(size.cross, min(cross, size.cross + _STEP)) if poor[D] else size.cross,
        tuple(
            max(H, min(last, H + (2 if far else 1))) if much else H
            for H, much, far in zip(size.orders, poor[D + 1 :], point.dropped[D + 1 :] > 1.5 * DROPPED, strict=True)
        ),
    )


def _problem(given: Torus, size: Size) -> Problem:
    ready, extra = given.ready, len(size.orders)
    mesh = [((*point, *(0,) * extra), False, line) for point, line in ready.lines.mesh]
    D, damped = given.mesh_tones, bool(ready.system.meshes.damping.any())
    # averages over slow phases smooth what samples of a mesh phase miss of teeth that part
    doubled = not extra or (damped and D == 1)
    samples = max(_FEWEST.get(D, 64), _FINE.get(D, 4) * max(size.harmonics)) * (2 if doubled else 1)
    counts = (samples,) * D + tuple(_FINE_SLOW * order for order in size.orders)
    points = _points(size)
    lines = [*mesh, *given.slow.lines] if extra else mesh
    return problem(ready, points, given.tones[: points.shape[1]], counts, lines)


def mesh_points(size: Size) -> Index:
    """Points of the mesh tones alone."""
    return _points(size._replace(orders=()))


def _points(size: Size) -> Index:
    """Points kept, (J, D): one of a and -a, the first order of none below 0, the origin first."""
    mesh = kept_points(size.harmonics, size.cross, mirrored=False).points.tolist()
    reach = product(*(range(-order, order + 1) for order in size.orders))
    slow = [orders for orders in reach if _weight(orders, size.orders) <= 1]
    every = [(*a, *s) for a in mesh for s in slow]
    leading = [point for point in every if next((a for a in point if a), 1) > 0]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def _weight(slow: tuple[int, ...], orders: tuple[int, ...]) -> float:
    """|s_1| / H_1 + |s_2| / H_2 + .., without its rounding."""
    return round(sum(abs(s) / order for s, order in zip(slow, orders, strict=True)), 9)
