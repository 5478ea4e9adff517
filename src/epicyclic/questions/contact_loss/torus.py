"""Contact loss with shaft orders: a balance on the torus of the phases of mesh tones and a few shaft tones [lau1983].

Lattice points are combinations of mesh orders, as of mesh tones alone, with shaft orders |s_1| / H_1 + |s_2| / H_2 + ..
<= 1.  The solution of the mesh orders is the start; harmonics and shaft orders grow until the truncation residual is
small.  Newton's method that fails is helped by continuation in the shaft lines, then in the speed.

Shaft tones are the few frequencies whose small multiples, with mesh orders, are all the shaft lines.  Frequencies are
exact fractions, so every line is a multiple of one very low frequency, of an order that no lattice could hold.  Wanted
is a small set of tones of which each line is a combination with orders up to 4, modulo the mesh frequencies (derived
here).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from ...system.system import Array, Index
from ..response.lattice import Point
from ..response.response import Response
from ..response.spectra import LineExcitation, PlacedLine, Shaft
from .continuation import (
    TOLERANCE,
    WORK,
    NewtonResult,
    TruncatedOrders,
    linear_start,
    newton_step,
    solve,
    truncated_orders,
    truncation_residual,
)
from .problem import Problem, State, dynamic_size, embedded, evaluate, linearised_residual, problem
from .rows import Size, gap_rows_of, order_weight, placed_line, torus_points

# Highest order of a shaft tone that a line may stand on: a lattice of orders up to 4 still holds it.
_ORDER = 4
# Highest order of a mesh tone that a line may have beside its shaft tones; chosen, a group is named by its lowest line.
_MESH_ORDER = 2
# Truncation residual that may be left, relative to the dynamic part: forces then have that error at an instant and
# about its square in their RMS.
TRUNCATION_TOLERANCE = 1e-2
# Truncation residual that a result warns of: what the RMS is right to at worst (docs/theory/contact-shaft-orders.md).
TRUNCATION_NOTED = 2e-3
# Phases in all, at most, by the number of mesh tones: a grid of more is too large.  Samples per shaft order.
_PHASES, _SHAFT_SAMPLES = {1: 4, 2: 3}, 4
# First and last orders of a shaft tone, by the number of them.
_FIRST, _LAST = {1: 4, 2: 3, 3: 2}, {1: 8, 2: 5, 3: 3}
# Truncation residual by a shaft tone that a single speed leaves where links follow laws, and last orders of that: what
# opens and closes over a turn has forces of slow series, right to 1e-4 then.
_OF_LINKS, _LAST_OF_LINKS = 1.5e-4, {1: 32, 2: 8, 3: 3}
# Harmonics: least, most to begin with, most, the last two by the number of mesh tones.
_LEAST, _BEGIN, _MOST = 12, {1: 32, 2: 16, 3: 12}, {1: 64, 2: 24, 3: 16}
# Harmonics begin where they reach beyond the highest mode, by this factor.
_BEYOND_MODES = 1.7
# Order of the combinations of mesh tones: first, step, last by the number of mesh tones.
_CROSS, _CROSS_STEP, _CROSS_LAST = 8, 2, {1: 0, 2: 14, 3: 8}
# Samples of a mesh phase, least and per harmonic: few, whose Jacobian is cheap, and many, which the forces need.
_FEW, _MANY = (64, 4), (192, 16)
# Values of all rows over a grid, at most: 0.13 GB, of which a solution holds some twenty.
_VALUES, _HELD = 2**24, 20
# Factors of the shaft lines in turn where Newton's method fails at once.
_RISING = (0.25, 0.5, 0.75, 1.0)
# Newton steps of one try, which succeed in 3 to 8 or not at all; residual that is enough on the way.
_STEPS, _ON_THE_WAY = 10, 1e-3
# Steps and products of a correction on many samples; those that succeed take 2 to 4 and about 20.
_CORRECTIONS, _CORRECTION_WORK = 8, 60
# Residual at which the truncation is known well enough; the rest is left to the size that is kept.
_ROUGH = 1e-4
# Residual that is enough where forces jump with dampers of meshes, or tangents with the play of links, and Newton's
# method ends among samples on both sides: about what one sample that jumps is worth.
_JUMP = 1e-4
# Speeds, as parts of the one wanted beside it, from which it is approached where that fails too, and mesh orders alone.
_NEARBY, _FAR = (0.05, 0.035, 0.02, 0.01, 0.0), (0.15, 0.11, 0.08, 0.05, 0.03, 0.01, 0.0)


# --- shaft tones ------------------------------------------------------------------------------------------------------


class ShaftTones(NamedTuple):
    """Shaft lines on a lattice of mesh tones and shaft tones.

    tones : exact frequencies [Hz] at the operating speed.  highest : largest order of each that a line stands on.
    lines : placed on (mesh orders, shaft orders).  superposed : groups of lines for which there was no tone left.
    """

    tones: tuple[Fraction, ...]
    highest: tuple[int, ...]
    lines: tuple[PlacedLine, ...]
    superposed: tuple[Shaft, ...]


class _PlacedShaft(NamedTuple):
    """A group whose frequency is mesh . mesh tones + orders . shaft tones."""

    shaft: Shaft
    mesh: Point
    orders: Point


def shaft_tones(ready: Response, groups: Sequence[Shaft], *, most: int) -> ShaftTones:
    """Shaft tones for groups of shaft lines, the strongest first; groups beyond `most` tones are superposed."""
    lines = ready.lines
    tones: list[Fraction] = []
    shafts: list[_PlacedShaft] = []
    superposed: list[Shaft] = []
    for shaft in sorted(groups, key=lambda shaft: -_strength(ready, shaft)):
        placed = _placed(lines, tones, shaft)
        if placed is None:
            divided = _divided(tones, shafts, shaft)
            if divided is not None:
                tones, shafts = divided
            elif len(tones) < most:
                tones.append(shaft.frequency)
            else:
                superposed.append(shaft)
                continue
            placed = _placed(lines, tones, shaft)
        if placed is not None:
            shafts.append(placed)
    width = len(tones)
    shafts = [placed._replace(orders=(*placed.orders, *(0,) * (width - len(placed.orders)))) for placed in shafts]
    placed_lines: list[PlacedLine] = []  # at their points: a . f + base, or a . f - base as its conjugate
    for placed in shafts:
        for orders, minus, line in placed.shaft.members:
            sign = -1 if minus else 1
            mesh = (a + sign * b for a, b in zip(orders, placed.mesh, strict=True))
            placed_lines.append(placed_line((*mesh, *(sign * order for order in placed.orders)), line))
    return ShaftTones(
        tones=tuple(tones),
        highest=tuple(max(abs(placed.orders[i]) for placed in shafts) for i in range(width)),
        lines=tuple(placed_lines),
        superposed=tuple(superposed),
    )


def _strength(ready: Response, shaft: Shaft) -> float:
    """Root of the strain energy that the lines of a group would bring at rest."""
    modal, meshes = ready.modal, ready.system.meshes
    force = sum(
        (line.gap * meshes.stiffness) @ modal.pulls + modal.forces @ line.force.sum(axis=0)
        for _, _, line in shaft.members
    )
    return float(np.linalg.norm(force / np.where(modal.rigid, np.inf, modal.squared)))


def _placed(lines: LineExcitation, tones: list[Fraction], shaft: Shaft) -> _PlacedShaft | None:
    """The combination of least order that has the frequency of a group, None where none of small order has."""
    reach = range(-_ORDER, _ORDER + 1)
    every = sorted(product(reach, repeat=len(tones)), key=lambda orders: (sum(map(abs, orders)), [-a for a in orders]))
    for orders in every:
        rest = shaft.frequency - sum((a * tone for a, tone in zip(orders, tones, strict=True)), Fraction(0))
        mesh = _multiple(lines.tones, rest)
        if mesh is not None and any(orders) and sum(map(abs, orders)) <= _ORDER:
            return _PlacedShaft(shaft, mesh, orders)
    return None


def _multiple(tones: tuple[Fraction, ...], frequency: Fraction) -> Point | None:
    """The multiple of one mesh tone that a frequency is, of orders up to 2, None where it is none."""
    for axis, tone in enumerate(tones):
        order = frequency / tone
        if order.denominator == 1 and abs(order) <= _MESH_ORDER:
            return tuple(int(order) if j == axis else 0 for j in range(len(tones)))
    return None


def _divided(
    tones: list[Fraction], shafts: list[_PlacedShaft], shaft: Shaft
) -> tuple[list[Fraction], list[_PlacedShaft]] | None:
    """A tone divided so that a group becomes a small multiple of it, as all that stand on it already."""
    for i, tone in enumerate(tones):
        ratio = shaft.frequency / tone
        parts, orders = ratio.denominator, [abs(placed.orders[i]) for placed in shafts if len(placed.orders) > i]
        if max(ratio.numerator, parts * max(orders, default=0)) <= _ORDER:
            finer = [value / parts if j == i else value for j, value in enumerate(tones)]
            moved = [
                placed._replace(orders=tuple(a * parts if j == i else a for j, a in enumerate(placed.orders)))
                for placed in shafts
            ]
            return finer, moved
    return None


# --- the torus --------------------------------------------------------------------------------------------------------


class Prepared(NamedTuple):
    """The balance of one size: with few samples, whose Jacobian and first solution are cheap, and with enough.

    truncated_orders : those that the first one drops.
    """

    fine: Problem
    coarse: Problem
    truncated_orders: TruncatedOrders


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Torus:
    """A System ready to be solved with contact loss and shaft orders at any speed.

    shaft_tones : the shaft lines on tones of their own.  shaft_lines : all groups of them that count.
    problems : those made so far, by size.
    fine : whether shaft orders grow until links that follow laws are right to 1e-4.
    """

    ready: Response
    shaft_tones: ShaftTones
    shaft_lines: tuple[Shaft, ...]
    fine: bool = False
    problems: dict[Size, Prepared] = field(default_factory=dict)

    @property
    def mesh_orders_only(self) -> Torus:
        """The mesh tones alone, all shaft lines superposed."""
        return replace(self, shaft_tones=ShaftTones(tones=(), highest=(), lines=(), superposed=self.shaft_lines))

    @property
    def with_fewer_tones(self) -> Torus:
        """The torus with one shaft tone less."""
        fewer = shaft_tones(self.ready, self.shaft_lines, most=len(self.shaft_tones.tones) - 1)
        return replace(self, shaft_tones=fewer, problems={})

    @property
    def mesh_tones(self) -> int:
        """Number of mesh tones."""
        return len(self.ready.lines.tones)

    def excess(self, point: TorusPoint) -> Array:
        """Truncation residual of a point by each kind, per what may be left (kinds,)."""
        allowed = np.full(point.truncation.size, TRUNCATION_TOLERANCE)
        allowed[self.mesh_tones + 1 :] = _OF_LINKS if self.fine else TRUNCATION_TOLERANCE
        return np.asarray(point.truncation / allowed)

    @property
    def tones(self) -> Array:
        """Mesh tones and shaft tones (D,) at the operating speed [rad/s]."""
        return np.concatenate(
            [self.ready.omega, 2 * np.pi * np.array([float(tone) for tone in self.shaft_tones.tones])]
        )

    def prepared(self, size: Size) -> Prepared:
        """The balance of a size, made once."""
        if size not in self.problems:
            few, many = _samples(self, size)
            coarse = _problem(self, size, few)
            self.problems[size] = Prepared(
                fine=coarse if few == many else _problem(self, size, many),
                coarse=coarse,
                truncated_orders=truncated_orders(coarse, self.tones, mesh=self.mesh_tones, orders=size.orders),
            )
        return self.problems[size]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TorusPoint:
    """The motion found at one speed, or where the search for it ended.

    state : the motion, of `problem`.  size : rows kept.  converged : whether Newton's method did.
    residual : of the rows kept.  truncation : (kinds,) of the rows dropped, by each mesh tone, combinations of mesh
        tones and each shaft tone.  Both are relative to the dynamic part.
    """

    problem: Problem
    state: State
    size: Size
    converged: bool
    residual: float
    truncation: Array

    @property
    def truncation_residual(self) -> float:
        """Norm of the rows dropped, all kinds together, per dynamic size."""
        return float(np.linalg.norm(self.truncation))

    @property
    def status(self) -> str:
        """``ok``; ``coarse`` where the truncation residual stays too large; or how the search failed."""
        if not np.isfinite(self.residual):
            return "not finite"
        if not self.converged:
            return "not converged"
        return "ok" if self.truncation_residual <= TRUNCATION_TOLERANCE else "coarse"


def torus_of(ready: Response, *, shaft_orders: bool = True, most: int | None = None, fine: bool = False) -> Torus:
    """Prepare a System for contact loss with shaft orders.

    Parameters
    ----------
    shaft_orders : whether shaft lines count.
    most : shaft tones at most; None: 3 beside one mesh tone, 1 beside two, 0 beside more.  The other lines are in
        ``shaft_tones.superposed``.
    fine : as of `Torus`, where links follow laws.
    """
    tones = len(ready.lines.tones)
    room = max(0, _PHASES.get(tones, tones) - tones) if most is None else most
    every = ready.lines.shaft if shaft_orders else ()
    return Torus(
        ready=ready,
        shaft_tones=shaft_tones(ready, every, most=room),
        shaft_lines=every,
        fine=fine and gap_rows_of(ready).links is not None,
    )


def memory(torus: Torus, speed: float) -> tuple[float, bool]:
    """Memory that a solution at a relative speed begins with [byte], and whether that is too much."""
    values = _values(torus, _first_size(torus, speed))
    return 8.0 * _HELD * values, values > _VALUES


def respond_torus(torus: Torus, speed: float, *, start: tuple[Index, Array] | None = None) -> TorusPoint:
    """The steady motion at one relative speed, all phases of mesh and shaft tones at once.

    Parameters
    ----------
    start : lattice points (J, D) and a motion (2, J, n) to start from, of mesh orders alone or of a whole torus: which
        branch is found where there are several.  None: the solution of the mesh orders next to the linear one.

    Raises
    ------
    Nothing: a speed that fails comes back with its status.
    """
    size = _first_size(torus, speed)
    with np.errstate(all="ignore"):  # a motion that overflows ends as not finite
        points, y = _mesh_orders(torus, size, speed, TOLERANCE) if start is None else start
        point = _solve_size(torus, size, speed, points, y)
        if start is None and not point.converged:
            point = _continued_in_speed(torus, point, speed)
        while point.converged and float(np.linalg.norm(torus.excess(point))) > 1:
            larger = _larger_size(torus, point)
            if larger == point.size or _values(torus, larger) > _VALUES:
                break
            finer = _solve_size(torus, larger, speed, point.problem.grid.points, point.state.y)
            if not finer.converged:
                break  # the coarser solution stands, and says what it dropped
            point = finer
        return _corrected_on_fine_grid(torus, point) if point.converged else point


def _continued_in_speed(torus: Torus, lost: TorusPoint, speed: float) -> TorusPoint:
    """The motion continued from a speed nearby, from above and then from below; the lost point where neither is."""
    for side in (1.0, -1.0):
        points, y = _mesh_orders(torus, lost.size, speed * (1 + side * _NEARBY[0]), _ROUGH)
        for part in _NEARBY:
            point = _solve_size(torus, lost.size, speed * (1 + side * part), points, y, rescue=False)
            if not point.converged:
                break
            points, y = point.problem.grid.points, point.state.y
        if point.converged:
            return point
    return lost


def _mesh_orders(torus: Torus, size: Size, speed: float, tolerance: float) -> tuple[Index, Array]:
    """Points (J, D) and motion (2, J, n) of the mesh orders alone, as far as Newton's method came.

    It starts from the linear motion, then from linear motions at speeds nearby.
    """
    mesh = torus.prepared(size._replace(orders=())).fine
    first = solved = solve(mesh, linear_start(mesh, speed), speed, tolerance=tolerance, step=newton_step())
    for side in (1.0, -1.0):
        if solved.converged:
            break
        y = linear_start(mesh, speed * (1 + side * _FAR[0]))
        for part in _FAR:
            nearby, step = speed * (1 + side * part), newton_step()
            solved = solve(mesh, y, nearby, tolerance=tolerance, steps=_STEPS, step=step)
            if not solved.converged:
                break
            y = solved.state.y
    return mesh.grid.points, (solved if solved.converged else first).state.y


def _solve_size(torus: Torus, size: Size, speed: float, points: Index, y: Array, *, rescue: bool = True) -> TorusPoint:
    """One size from a motion (2, J, n) at points (J, D), else by continuation in the shaft lines."""
    prepared = torus.prepared(size)
    start = embedded(points, y, prepared.coarse)
    if points.shape[1] == torus.mesh_tones and size.orders:
        start = _with_shaft_response(torus, prepared.coarse, start, speed)
    solved = solve(prepared.coarse, start, speed, tolerance=_ROUGH, steps=_STEPS, step=newton_step())
    if not solved.converged and size.orders and rescue:
        # with a part of the shaft lines, then more and more of them
        of_shafts = prepared.coarse.grid.points[:, torus.mesh_tones :].any(axis=1)
        y, used = np.where(of_shafts, _RISING[0], 1.0)[:, None] * start, 0
        for factor in _RISING:
            final = factor == _RISING[-1]
            scaled = prepared.coarse if final else _with_scaled_shaft_lines(torus, prepared.coarse, factor)
            wanted = _ROUGH if final else _ON_THE_WAY
            solved = solve(scaled, y, speed, tolerance=wanted, steps=_STEPS, work=WORK - used, step=newton_step())
            y, used = solved.state.y, used + solved.calls
            if not solved.converged:
                break
        solved = solved._replace(converged=solved.converged and final)
    dynamic = dynamic_size(solved.state.y)
    dropped = truncation_residual(prepared.coarse, solved.state, prepared.truncated_orders)
    return TorusPoint(
        problem=prepared.coarse,
        state=solved.state,
        size=size,
        converged=_accepted(torus, solved),
        residual=solved.state.norm / dynamic,
        truncation=dropped / dynamic,
    )


def _accepted(torus: Torus, solved: NewtonResult) -> bool:
    """Whether Newton's method converged, or to what dampers of meshes and kinks of links allow."""
    jumps = bool(torus.ready.system.meshes.damping.any()) or bool(torus.ready.lawful.groups)
    return solved.converged or (jumps and solved.state.norm <= _JUMP * dynamic_size(solved.state.y))


def _corrected_on_fine_grid(torus: Torus, point: TorusPoint) -> TorusPoint:
    """The residual of many samples corrected with the Jacobian of few, or where that fails with its own."""
    prepared, y, speed = torus.prepared(point.size), point.state.y, point.state.speed
    exact = newton_step()

    def cheap(_: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
        """A Newton step (2, J, n) with the Jacobian of few samples."""
        return exact(prepared.coarse, evaluate(prepared.coarse, at.y, speed), right, target)

    attempt = partial(solve, prepared.fine, y, speed, steps=_CORRECTIONS, work=_CORRECTION_WORK)
    for step in (cheap, exact) if prepared.fine is not prepared.coarse else (exact,):
        solved = attempt(step=step)
        if solved.converged:
            break
    return replace(
        point,
        problem=prepared.fine,
        state=solved.state,
        converged=_accepted(torus, solved),
        residual=solved.state.norm / dynamic_size(solved.state.y),
    )


def _with_shaft_response(torus: Torus, balance: Problem, y: Array, speed: float) -> Array:
    """A motion (2, J, n) of mesh orders, with the linear response to the shaft lines of flanks that touch as in it.

    Errors of low frequency are mostly followed by the bodies: on their own, before these have moved, they would part
    all flanks.
    """
    without = _with_scaled_shaft_lines(torus, balance, 0.0)
    state = evaluate(without, y, speed)
    if balance.rows.parametric:
        state = evaluate(balance, y, speed, touching=state.touching)
        right = state.residual
    else:
        right = linearised_residual(without, state, balance)
    move, _ = newton_step()(balance, state, right, 0.0)
    return y - move


def _with_scaled_shaft_lines(torus: Torus, balance: Problem, factor: float) -> Problem:
    """The balance with a part of the shaft lines."""
    scale = np.where(balance.grid.points[:, torus.mesh_tones :].any(axis=1), factor, 1.0)
    return replace(
        balance, error=np.concatenate([scale, scale])[:, None] * balance.error, force=scale[:, None] * balance.force
    )


def _first_size(torus: Torus, speed: float) -> Size:
    """The size to begin with: harmonics that reach beyond the highest mode, shaft orders that hold every line."""
    lines, shafts, D = torus.ready.lines, torus.shaft_tones, torus.mesh_tones
    highest = float(np.sqrt(torus.ready.modal.squared.max(initial=0.0)))
    with np.errstate(all="ignore"):
        reach = np.nan_to_num(
            np.ceil(_BEYOND_MODES * highest / (abs(speed) * torus.ready.omega)), nan=_LEAST, posinf=1e6
        )
    harmonics = tuple(
        int(max(min(max(_LEAST, count), _BEGIN.get(D, _LEAST)), top + 2))
        for count, top in zip(reach, lines.highest, strict=True)
    )
    placed = [point[:D] for point, _, _ in shafts.lines]
    cross = max((sum(map(abs, point)) for point in placed if np.count_nonzero(point) > 1), default=0)
    count = len(shafts.tones)
    orders = tuple(max(_FIRST.get(count, 2), top + 1) for top in shafts.highest)
    while any(order_weight(point[D:], orders) > 1 for point, _, _ in shafts.lines):
        orders = tuple(order + 1 for order in orders)
    return Size(harmonics, max(_CROSS, cross) if D > 1 else 0, orders)


def _larger_size(torus: Torus, point: TorusPoint) -> Size:
    """More rows of the kinds that drop more than their part."""
    size, D, count = point.size, torus.mesh_tones, len(torus.shaft_tones.tones)
    excess = torus.excess(point)
    poor = excess > 1 / np.sqrt(excess.size)
    most, cross = _MOST.get(D, _LEAST), _CROSS_LAST.get(D, _CROSS)
    last = (_LAST_OF_LINKS if torus.fine else _LAST).get(count, 2)
    return Size(
        tuple(max(H, min(most, H + H // 2)) if poor[j] else H for j, H in enumerate(size.harmonics)),
        max(size.cross, min(cross, size.cross + _CROSS_STEP)) if poor[D] else size.cross,
        tuple(
            max(H, min(last, H + (max(2, H // 3) if far else 1))) if much else H
            for H, much, far in zip(size.orders, poor[D + 1 :], excess[D + 1 :] > 1.5, strict=True)
        ),
    )


def _samples(torus: Torus, size: Size) -> tuple[int, int]:
    """Samples of every mesh phase, few and many: teeth that part make forces of slow series."""
    D, top = torus.mesh_tones, max(size.harmonics)
    few, many = (max(least, per * top) for least, per in (_FEW, _MANY))
    if len(size.orders) > 1:
        many //= 2  # several shaft phases smooth what samples of a mesh phase miss
    if torus.ready.system.meshes.damping.any() and D == 1:
        few, many = 2 * few, 2 * many
    if D > 1:
        few = many = few if size.orders else 2 * few
    return (few, many) if size.orders else (many, many)


def _counts(torus: Torus, size: Size, samples: int) -> tuple[int, ...]:
    """Samples of every phase, so many of each mesh phase."""
    return (samples,) * torus.mesh_tones + tuple(_SHAFT_SAMPLES * order for order in size.orders)


def _values(torus: Torus, size: Size) -> int:
    """Values of all rows over the larger grid of a size."""
    return math.prod(_counts(torus, size, _samples(torus, size)[1])) * len(gap_rows_of(torus.ready).linear)


def _problem(torus: Torus, size: Size, samples: int) -> Problem:
    """The balance of a size with so many samples of every mesh phase."""
    ready, extra = torus.ready, len(size.orders)
    mesh = [((*point, *(0,) * extra), False, line) for point, line in ready.lines.mesh]
    counts, points = _counts(torus, size, samples), torus_points(size)
    lines = [*mesh, *torus.shaft_tones.lines] if extra else mesh
    return problem(ready, points, torus.tones[: points.shape[1]], counts, lines)
