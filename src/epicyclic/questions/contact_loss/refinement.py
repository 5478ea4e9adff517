"""Refinement of a balance: as many harmonics, samples and cycles as a motion needs, each problem made once.

A solution is refined until the residual seen with twice the harmonics and samples is small [krack2019].  What has been
found of its Floquet stability stands with it.

A motion has the symmetry of its train where, turned by one branch and shifted in time, it is itself (derived here).  A
stage whose branches are alike, their mesh phases whole parts of a cycle apart, is itself when turned by one branch
and shifted by such a part.  Each of its motions then has an image that is a motion too, and a motion with less symmetry
is another one than its image.  Which shift is the train's is decided by the balance: at the wrong one the image is no
motion, and neither is any where the branches differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ...system.system import Array, Symmetry
from ..response.response import Response
from ..stability.floquet import CIRCLE
from .corrector import NewtonResult, linear_start, solve
from .problem import Problem, State, dynamic_size, evaluate, mesh_problem, prolonged
from .stability import Stability, floquet_stability, quasi_periodic_growth

# Numbers of harmonics tried in turn.
HARMONICS = (8, 12, 16, 24, 32, 48)
# Residual seen with twice the harmonics and samples at which there are enough of them: RMS right to about as much.
ACCURACY = 3e-4
# Samples of a mesh cycle per harmonic: of one mesh frequency, and of each of two, whose grid is their product.
_SAMPLES = {1: 16, 2: 4}
# Parts of the varying load in turn, where neither Newton's method nor a start from closed flanks works.
_LOADS = (0.25, 0.5, 0.75, 0.9, 1.0)
# Two motions are the same within this part of their dynamic size: far above what is left of a residual.
_SAME = 1e-3

GROWTH = "growth"
"""How a motion of two mesh tones that is not stable is left: its growth has a size and no angle."""
Kind = Literal["periodic", "symmetry broken", "period 2"]
"""What sort of motion, as the variable ``motion`` of a sweep has it."""

ProblemSize = tuple[tuple[int, ...], int, int, int]
"""Harmonics of each mesh tone, order of the combinations, cycles and samples of a problem."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Refinement:
    """The problems of one System with one or two mesh frequencies.

    cross : order of the combinations kept.  problems : those made so far.
    stability : of states, and whether their branch goes back in speed, as far as asked for.
    """

    ready: Response
    cross: int = 10
    problems: dict[ProblemSize, Problem] = field(default_factory=dict)
    stability: dict[tuple[State, bool], Stability] = field(default_factory=dict)

    def problem(self, harmonics: int, *, cycles: int = 1, samples: int = 0) -> Problem:
        """The balance with so many harmonics of each mesh frequency.

        Parameters
        ----------
        samples : of a mesh cycle, 0 the usual number.
        """
        tones = len(self.ready.lines.tones)
        return self.lattice((harmonics,) * tones, self.cross, cycles, samples or self.samples(harmonics))

    def lattice(self, harmonics: tuple[int, ...], cross: int, cycles: int, samples: int) -> Problem:
        """The balance with so many harmonics of each mesh frequency, combinations and samples."""
        key = (harmonics, cross, cycles, samples)
        if key not in self.problems:
            self.problems[key] = mesh_problem(
                self.ready, harmonics=harmonics, cross=cross, samples=samples, cycles=cycles
            )
        return self.problems[key]

    def size_of(self, value: object) -> ProblemSize | None:
        """Size of a problem of this refinement, None of anything else: how a run that is stopped refers to it."""
        return next((size for size, problem in self.problems.items() if problem is value), None)

    def samples(self, harmonics: int) -> int:
        """The usual number of samples of a mesh cycle."""
        return harmonics * _SAMPLES[len(self.ready.lines.tones)]

    def residual(self, balance: Problem, state: State, harmonics: int) -> float:
        """Residual of a solution seen with twice the harmonics and samples, relative to its dynamic size.

        It holds what is dropped, and what the sampling of contacts that open and close has cost.
        """
        fine = self.problem(2 * harmonics, cycles=balance.cycles)
        seen = evaluate(fine, prolonged(balance, fine, state.y), state.speed)
        return seen.norm / dynamic_size(state.y)


def harmonics_for(harmonics: int) -> int:
    """The least of `HARMONICS` that is at least so many, the last one where none is."""
    return next((count for count in HARMONICS if count >= harmonics), HARMONICS[-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PeriodicMotion:
    """A periodic motion.

    state : with so many harmonics.  residual : with twice as many.  kind : what sort of motion.
    stability : None where not asked for.  backward : whether its branch goes back in speed there.
    """

    harmonics: int
    state: State
    residual: float
    kind: Kind = "periodic"
    stability: Stability | None = None
    backward: bool = False

    @property
    def stable(self) -> bool:
        """Whether it is known to be stable."""
        return self.stability is not None and self.stability.stable


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution(PeriodicMotion):
    """A periodic motion with the balance that it solves."""

    balance: Problem


def solution(
    refinement: Refinement,
    start: Array,
    speed: float,
    *,
    balance: Problem,
    harmonics: int,
    fixed: bool = False,
    kind: Kind = "periodic",
    backward: bool = False,
) -> Solution | None:
    """The motion that Newton's method reaches from a start, refined until it has harmonics enough; None where it fails.

    Parameters
    ----------
    start : (2, J, n) on the points of `balance`, which has so many harmonics.  fixed : keep that number.
    """
    at: Solution | None = None
    for count in (harmonics, *(() if fixed else (finer for finer in HARMONICS if finer > harmonics))):
        if at is not None:
            if at.residual <= ACCURACY:
                break
            balance = refinement.problem(count, cycles=at.balance.cycles)
            start = prolonged(at.balance, balance, at.state.y)
        solved = solve(balance, start, speed)
        if not solved.converged:
            break
        residual = refinement.residual(balance, solved.state, count)
        at = Solution(
            balance=balance, harmonics=count, state=solved.state, residual=residual, kind=kind, backward=backward
        )
    return at


def with_stability(refinement: Refinement, at: Solution) -> Solution:
    """The same with its stability, computed once: by Floquet multipliers, or as growth with two mesh frequencies."""
    if at.stability is not None:
        return at
    key, tones = (at.state, at.backward), refinement.ready.lines.tones
    if key not in refinement.stability and len(tones) == 1:
        refinement.stability[key] = floquet_stability(refinement, at)
    elif key not in refinement.stability:
        growth = quasi_periodic_growth(at.balance, at.state, tones)
        kind = GROWTH if growth.rate > 1 + CIRCLE else ""
        refinement.stability[key] = Stability(
            multiplier=complex(growth.rate), kind=kind, steps=growth.steps, error=growth.error
        )
    return replace(at, stability=refinement.stability[key])


def distinct(first: Solution, second: Solution) -> bool:
    """Whether two motions of one speed differ, also after a shift by whole mesh cycles."""
    return distance(first, second) > _SAME


def distance(first: Solution, second: Solution) -> float:
    """Least difference of two motions over shifts by whole mesh cycles, per dynamic size of the larger one."""
    a, b = (first, second) if len(first.balance.omega) >= len(second.balance.omega) else (second, first)
    y = prolonged(b.balance, a.balance, b.state.y)
    orders = a.balance.grid.points.sum(axis=1)
    distances = []
    for shift in range(a.balance.cycles):
        turn = np.exp(2j * np.pi * orders * shift / a.balance.cycles)[:, None]
        moved = (y[0] + 1j * y[1]) * turn - (a.state.y[0] + 1j * a.state.y[1])
        distances.append(float(np.linalg.norm(moved)))
    return min(distances) / max(dynamic_size(a.state.y), dynamic_size(y))


def load_continuation(refinement: Refinement, speed: float, *, harmonics: int) -> NewtonResult:
    """A solution from closed flanks, or by continuation in the load: the varying load brought up in parts.

    Stiffness variation, errors, dynamic forces and curvature of the laws are scaled together; mean loads stay.
    """
    balance = refinement.problem(harmonics)
    solved = solve(balance, linear_start(balance, speed), speed)
    if solved.converged:
        return solved
    rows, J = balance.rows, len(balance.omega)
    mean = np.concatenate([rows.flanks.stiffness, rows.linear[rows.count :]])
    for part in _LOADS:
        error, force = balance.error.copy(), balance.force.copy()
        error[np.r_[1:J, J + 1 : 2 * J]] *= part
        force[:, :, 1:] *= part
        eased = replace(
            balance,
            rows=rows if rows.links is None else replace(rows, links=replace(rows.links, part=part)),
            error=error,
            force=force,
            laws=balance.laws.eased(rows.flanks.stiffness, part),
            tangent=mean + part * (balance.tangent - mean),
        )
        solved = solve(eased, solved.state.y if part > _LOADS[0] else linear_start(eased, speed), speed)
        if not solved.converged:
            break
    return solved


# --- symmetry ---------------------------------------------------------------------------------------------------------


def with_kind(refinement: Refinement, at: Solution) -> Solution:
    """A motion that repeats every mesh cycle, named after whether it has the symmetry of its train."""
    broken = at.kind == "periodic" and symmetry_is_broken(refinement, at)
    return replace(at, kind="symmetry broken") if broken else at


def symmetry_is_broken(refinement: Refinement, at: Solution) -> bool:
    """Whether a motion of whole mesh cycles has less symmetry than a stage of its train.

    An image counts as a motion where its residual is at most `ACCURACY` above that of the motion, by as much as they
    are known, and as another one where the two are `distinct`, as any two motions.
    """
    for symmetry in refinement.ready.system.symmetries:
        if not symmetry.holds or symmetry.branches < 2:
            continue
        images = list(_images(refinement, at, symmetry))
        if all(distinct(at, image) for image in images) and any(
            refinement.residual(at.balance, image.state, at.harmonics) <= at.residual + ACCURACY for image in images
        ):
            return True
    return False


def _images(refinement: Refinement, at: Solution, symmetry: Symmetry) -> Iterator[Solution]:
    """A motion turned by one branch, at every shift of its stage's tone by a whole part of a cycle.

    Of the states only y is that of the image.
    """
    balance, meshes = at.balance, refinement.ready.system.meshes
    tones = {int(tone) for tone, stage in zip(meshes.tone, meshes.stage, strict=True) if stage == symmetry.stage}
    # turning by one branch, of modal coordinates (n, n)
    shapes = refinement.ready.modal.shapes
    turn = np.asarray(np.linalg.solve(shapes, symmetry.operator @ shapes), np.float64)
    turned = at.state.y @ turn.T
    turned[:, 0, balance.modal.rigid] = 0.0
    for part in range(symmetry.branches):
        cycles = part * balance.grid.points[:, sorted(tones)].sum(axis=1)
        shift = np.exp(2j * np.pi * cycles / symmetry.branches)[:, None]
        moved = (turned[0] + 1j * turned[1]) * shift
        yield replace(at, state=replace(at.state, y=np.stack([moved.real, moved.imag])))
