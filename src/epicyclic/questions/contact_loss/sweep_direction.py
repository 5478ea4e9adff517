"""Sweep direction: the motions that a slow run-up and a slow coast-down reach, each begun where the last one was.

A motion goes on along its branch while that is stable.  Where the branch turns back or loses its stability, the next
motion follows from how it was left: by branch switching, or as the attractor of integration in time.  A record of
integration goes on as long as it settles on no branch, also beside motions that are stable.  With two mesh tones no
branch is switched to: the nearest stable motion of the branch set takes its place, else the attractor.

Branch switching [seydel2010]: which branch is looked for follows from how the motion is left, one with less symmetry or
one of two mesh cycles.  Each search is a few solutions of the same balance, and what comes back has been found stable.
Where none is found, the attractor of a start is found by integration in time, and the balance polishes what it
approaches.

A direction that was stopped goes on from what it reached last, which stands for all that was before.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from ...statics.signals import peaks_to_peaks
from ...system.system import Array
from ..response import Unstable
from ..response.measures import record_link_measures
from ..response.response import Response
from ..response.spectra import lateral_pairs
from ..transient.equation import Motion, constant, in_modes_of_its_speed, motion
from ..transient.integrators import integrate, steps_for
from ..transient.transient import flank_force, group_stretch, link_force
from .branch_set import BranchSet, Crossing, Measures, record_measures
from .continuation import linear_start, solve
from .problem import Problem, gap_rows, prolonged
from .rows import reported_links
from .solutions import (
    Kind,
    ProblemSize,
    Refinement,
    Solution,
    distance,
    distinct,
    floquet_vector,
    solution,
    symmetry_is_broken,
    with_stability,
)

# A small error of every pitch at the lowest orders, as part of the dynamic gap; removed in these parts, so many draws.
_PITCH, _ORDERS, _PARTS, _SEEDS = 0.2, 2, (1.0, 0.5, 0.2, 0.05, 0.0), 3
# Kicks along the most unstable disturbance, per the whole size of the motion: what parts teeth is as large as the load.
_KICKS = (1.0, 2.0, 0.5, 4.0, 0.25)
# Least and largest of random kicks, per the whole size of the motion.
_RANDOM_KICKS = (0.3, 3.0)
# Mesh cycles run before each look at where the motion is: from any start, and from the end of a record at the speed
# before, whose transient is over but for the small change of speed.  The last ones are measured.
_CYCLES = 60
_LOOKS, _LOOKS_ON = (_CYCLES,) * 6, (20, _CYCLES)
# Samples of a mesh cycle per harmonic of the motion that the integration is compared with: half as many again as its
# amplitudes need.
_SAMPLES = 3
# Step times highest rate: the phase of the highest mode is right to 0.7^4 / 120 = 2e-3 and its damping ratio to
# 0.7^5 / 144 = 1.2e-3, of one at half of that to 1.3e-4 and 4e-5; what is periodic is then solved by the balance.
_STEP_RATE = 0.7
# Part of the largest singular value below which amplitudes of a record are not told apart: points of two tones whose
# frequencies nearly meet.
_RANK = 1e-6
# A motion of the balance is the one that was run to when it is this near to the record, per what varies of that.
_SAME_BRANCH = 0.1
# Perturbation of every coordinate, per its own size, from which an unstable motion is left: one that grows 1 % a cycle
# is left within the cycles run.
_PERTURBATION = 0.05
# Change of speed, as a part of it, that leaves hardly a transient of a motion over time.
_NEAR = 0.02
# Harmonics of the attractor of a motion that is not periodic where no branch goes on, of one mesh tone and of each of
# two.
_HARMONICS = {1: 16, 2: 8}


class IntegratedMotion(NamedTuple):
    """A motion over time that approaches none of one or two mesh cycles, nor one of two mesh tones.

    speed : relative.  last : (2, n) q and q' at its end, a whole number of cycles after the start.
    measures : of its last cycles.  unchanging : whether contact does not change in them.
    """

    speed: float
    last: Array
    measures: Measures
    unchanging: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reached:
    """What is reached at one speed.

    motion : None where nothing was found.  part : of the branch set it lies on, or stands in for, else None.
    instability : how the periodic motion of the branch is left there, empty where it is stable or there is none.
    jumped : whether the branch of the speed before had ended.
    """

    motion: Solution | IntegratedMotion | None
    part: int | None
    instability: str = ""
    jumped: bool = False


def sweep_direction(
    refinement: Refinement,
    branches: BranchSet,
    indices: Sequence[int] | None = None,
    before: Reached | None = None,
    *,
    upward: bool,
    unstable: Unstable = "replace",
) -> Iterator[tuple[int, Reached]]:
    """The speeds of a branch set in turn, rising or falling, by index, and what is reached at each.

    indices : of the speeds that are left, None for all.  before : what was reached before them.
    """
    reached = before or Reached(motion=None, part=None)
    for index in range(len(branches.crossings))[:: 1 if upward else -1] if indices is None else indices:
        speed, choices = float(branches.speeds[index]), branches.crossings[index]
        reached = _reached_at(refinement, speed, reached, choices if upward else choices[::-1], unstable)
        at = reached.motion
        if isinstance(at, Solution) and at.kind == "periodic" and symmetry_is_broken(refinement, at):
            reached = replace(reached, motion=replace(at, kind="symmetry broken"))
        yield index, reached


def _reached_at(
    refinement: Refinement, speed: float, before: Reached, choices: list[Crossing], unstable: Unstable
) -> Reached:
    """What is reached at a speed after what was reached before; `choices` are the crossings there."""
    last = before.motion
    if unstable == "replace" and isinstance(last, IntegratedMotion):
        return _run_on(refinement, speed, before, last, choices)
    if unstable == "replace" and len(refinement.ready.lines.tones) > 1:
        return _of_two_tones(refinement, speed, before, choices)
    if last is None and not choices:
        return _begun(refinement, speed) if unstable == "replace" else Reached(motion=None, part=None)
    if last is None:
        return _on_branch(refinement, speed, None, choices[0], unstable)
    assert isinstance(last, Solution)
    ahead = next((crossing for crossing in choices if crossing.part == before.part), None)
    if ahead is not None:
        return _on_branch(refinement, speed, last, ahead, unstable)
    if unstable != "replace" and not choices:
        return Reached(motion=None, part=None)
    if unstable != "replace":
        # the solution most like the last one, of stable ones if there are: no branch switching
        candidates = [(_stability_unless_ignored(refinement, at.solution, unstable), at.part) for at in choices]
        near, part = min(candidates, key=lambda candidate: (not candidate[0].stable, distance(candidate[0], last)))
        return Reached(motion=near, part=part, instability=_instability(near), jumped=True)
    # the branch has ended before this speed, or was left: the attractor of a start from the last motion
    at = _continued(refinement, speed, last) if before.part is None else None
    if at is not None:
        return _on_branch_set(refinement, at, choices, jumped=False)
    motion = attractor(refinement, initial_state(last), speed, harmonics=last.harmonics)
    return _on_branch_set(refinement, motion, choices, jumped=True)


def _begun(refinement: Refinement, speed: float) -> Reached:
    """The attractor of a start on the linear motion of closed teeth, where the branch set has nothing yet."""
    harmonics = _HARMONICS[len(refinement.ready.lines.tones)]
    balance = refinement.problem(harmonics)
    start = state_at_start(balance, linear_start(balance, speed), speed)
    return Reached(motion=attractor(refinement, start, speed, harmonics=harmonics), part=None)


def _run_on(
    refinement: Refinement, speed: float, before: Reached, last: IntegratedMotion, choices: list[Crossing]
) -> Reached:
    """The attractor from the end of a record at the speed before; instability is that of the branch it stands in for.

    A slow sweep stays on its attractor: a motion of the branch set that is stable beside it is not jumped to.
    """
    ahead = next((crossing for crossing in choices if crossing.part == before.part), None)
    branch = None if ahead is None else with_stability(refinement, ahead.solution)
    harmonics = branch.harmonics if branch is not None else _HARMONICS[len(refinement.ready.lines.tones)]
    settled = abs(last.speed - speed) < _NEAR * speed
    motion = attractor(refinement, last.last, speed, harmonics=harmonics, settled=settled)
    if branch is not None and branch.stable and branch.state.unchanging and branch.balance.rows.parametric:
        if isinstance(motion, IntegratedMotion) and motion.unchanging:
            # the record has not yet come to the one stable motion of a linear system
            motion = branch
    reached = _on_branch_set(refinement, motion, choices, jumped=branch is None and before.part is not None)
    if branch is None or reached.part is not None:
        return reached
    instability = _instability(branch)
    return replace(reached, motion=_named(motion, instability), part=before.part, instability=instability)


def _of_two_tones(refinement: Refinement, speed: float, before: Reached, choices: list[Crossing]) -> Reached:
    """What replaces an unstable motion of two mesh tones, and the end of a branch.

    The nearest stable motion of the branch set, else the attractor of a start a little off the motion at hand.
    """
    last = before.motion
    assert not isinstance(last, IntegratedMotion)
    judged = [replace(crossing, solution=with_stability(refinement, crossing.solution)) for crossing in choices]
    ahead = next((crossing for crossing in judged if last is None or crossing.part == before.part), None)
    if ahead is not None and ahead.solution.stable:
        return Reached(motion=ahead.solution, part=ahead.part)
    instability = "" if ahead is None else _instability(ahead.solution)
    jumped = ahead is None and last is not None
    stable = [crossing for crossing in judged if crossing.solution.stable]
    if stable:
        near = last or (ahead.solution if ahead is not None else None)
        best = stable[0] if near is None else min(stable, key=lambda crossing: distance(crossing.solution, near))
        return Reached(motion=best.solution, part=best.part, instability=instability, jumped=jumped)
    at = ahead.solution if ahead is not None else last
    if at is None:
        return _begun(refinement, speed)
    motion = attractor(refinement, _perturbed(initial_state(at)), speed, harmonics=at.harmonics)
    return Reached(motion=motion, part=None if ahead is None else ahead.part, instability=instability, jumped=jumped)


def _instability(at: Solution) -> str:
    """How a motion is left, empty where it is stable or that is not known."""
    return at.stability.kind if at.stability else ""


def _on_branch(
    refinement: Refinement, speed: float, last: Solution | None, at: Crossing, unstable: Unstable
) -> Reached:
    """The branch goes on: its motion where it is stable, else what takes its place."""
    branch = _stability_unless_ignored(refinement, at.solution, unstable)
    instability = _instability(branch)
    if unstable != "replace":
        return Reached(motion=branch, part=at.part, instability=instability)
    if last is not None and last.kind != "periodic":
        # the motion that had taken the branch's place goes on while distinct and stable
        beside = _continued(refinement, speed, last)
        if beside is not None and distinct(beside, branch):
            return Reached(motion=beside, part=at.part, instability=instability)
    if branch.stability is None or branch.stable:
        return Reached(motion=branch, part=at.part, instability=instability)
    other: Solution | IntegratedMotion | None = switched(refinement, branch)
    if other is None:
        other = attractor(refinement, _perturbed(initial_state(branch)), speed, harmonics=branch.harmonics)
        other = _named(other, instability)
    return Reached(motion=other, part=at.part, instability=instability)


def _named(motion: Solution | IntegratedMotion, instability: str) -> Solution | IntegratedMotion:
    """An attractor, named after how the motion is left that it takes the place of."""
    if isinstance(motion, Solution) and motion.kind == "periodic" and instability == "symmetry breaking":
        return replace(motion, kind="symmetry broken")
    return motion


def _continued(refinement: Refinement, speed: float, last: Solution) -> Solution | None:
    """The stable motion that Newton's method reaches at a speed from the one before."""
    at = solution(refinement, last.state.y, speed, balance=last.balance, harmonics=last.harmonics, kind=last.kind)
    at = None if at is None else with_stability(refinement, at)
    return at if at is not None and at.stable else None


def switched(refinement: Refinement, at: Solution) -> Solution | None:
    """The stable motion of the balance that takes the place of an unstable one, None where none is found."""
    search = {"symmetry breaking": symmetry_broken_motions, "period doubling": period_doubled_motions}
    instability = _instability(at)
    return next(search[instability](refinement, at), None) if instability in search else None


def _on_branch_set(
    refinement: Refinement, motion: Solution | IntegratedMotion, choices: list[Crossing], *, jumped: bool
) -> Reached:
    """A motion, on the part of the branch set that holds it."""
    if isinstance(motion, Solution):
        for crossing in choices:
            if not distinct(crossing.solution, motion):
                return Reached(motion=with_stability(refinement, crossing.solution), part=crossing.part, jumped=jumped)
    return Reached(motion=motion, part=None, jumped=jumped)


def _stability_unless_ignored(refinement: Refinement, at: Solution, unstable: Unstable) -> Solution:
    """The same with its Floquet stability, unless that is ignored."""
    return at if unstable == "ignore" else with_stability(refinement, at)


def _perturbed(start: Array) -> Array:
    """A state (2, n) a little off a start, reproducibly."""
    noise = np.random.default_rng(0).standard_normal(start.shape)
    return start * (1 + _PERTURBATION * noise)


# --- branch switching -------------------------------------------------------------------------------------------------


def symmetry_broken_motions(refinement: Refinement, at: Solution) -> Iterator[Solution]:
    """Stable motions with less symmetry: a random pitch error of either sign, removed again by homotopy (derived here).

    Where that finds none, kicks along the growing disturbance are tried.
    """
    known = list[Solution]()
    yield from _new_stable(refinement, at, _without_pitch_error(at.balance, at), at.balance, known, "symmetry broken")
    if known:
        return
    kick = _kick(refinement, at, at.balance)
    starts = (at.state.y + size * kick for size in (*_KICKS, *(-size for size in _KICKS)))
    yield from _new_stable(refinement, at, starts, at.balance, known, "symmetry broken")


def _without_pitch_error(balance: Problem, at: Solution) -> Iterator[Array]:
    """Motions (2, J, n) that are left when a random pitch error of either sign has been taken away."""
    J, F = len(balance.omega), balance.rows.count
    rows = np.r_[1 : 1 + _ORDERS, J + 1 : J + 1 + _ORDERS]
    gap = gap_rows(balance, at.state.y)
    size = _PITCH * float(np.abs(gap[np.r_[1:J, J + 1 : 2 * J], :F]).max(initial=0.0))
    for seed in range(_SEEDS):
        # random amplitudes of the errors of all flanks at the lowest orders [m]
        pitch = np.zeros_like(balance.error)
        pitch[rows, :F] = size * np.random.default_rng(seed).standard_normal((rows.size, F))
        for sign in (1.0, -1.0):
            y, converged = at.state.y, True
            for part in _PARTS:
                trial = solve(replace(balance, error=balance.error + sign * part * pitch), y, at.state.speed)
                y, converged = trial.state.y, trial.converged
                if not converged:
                    break
            if converged:
                yield y


def period_doubled_motions(refinement: Refinement, at: Solution) -> Iterator[Solution]:
    """Stable motions of two mesh cycles, from kicks at half orders along the growing disturbance."""
    balance = refinement.problem(at.harmonics, cycles=2 * at.balance.cycles)
    y, kick = prolonged(at.balance, balance, at.state.y), _kick(refinement, at, balance)
    yield from _new_stable(refinement, at, (y + size * kick for size in _KICKS), balance, [], "period 2")


def _kick(refinement: Refinement, at: Solution, balance: Problem) -> Array:
    """The growing disturbance as a motion (2, J, n) at the lowest order of a problem, as large as the motion."""
    position, rate = floquet_vector(refinement, at)
    kick = np.zeros((2, len(balance.omega), position.size))
    kick[0, 1], kick[1, 1] = position, -rate / (at.state.speed * float(balance.omega[1]))
    return kick * float(np.linalg.norm(at.state.y) / np.linalg.norm(kick))


def isolated_motions(
    refinement: Refinement, at: Solution, *, cycles: int = 1, tries: int = 20, seed: int = 0
) -> list[Solution]:
    """Stable motions other than the given one, reached from random kicks; isolated branches are found only so.

    Parameters
    ----------
    cycles : mesh cycles of a period, 1 or 2.  tries : number of kicks, of the size of the motion.
    """
    random = np.random.default_rng(seed)
    balance = refinement.problem(at.harmonics, cycles=cycles)
    y = prolonged(at.balance, balance, at.state.y)
    size = float(np.linalg.norm(y))

    def kicked() -> Iterator[Array]:
        """The motion (2, J, n) with a random kick at the lowest orders."""
        for _ in range(tries):
            kick = np.zeros_like(y)
            kick[:, : 2 * cycles + 1] = random.standard_normal(kick[:, : 2 * cycles + 1].shape)
            kick[1, 0] = 0.0
            kick *= size * random.uniform(*_RANDOM_KICKS) / float(np.linalg.norm(kick))
            yield y + kick

    return list(_new_stable(refinement, at, kicked(), balance, [], "period 2" if cycles > 1 else "periodic"))


def _new_stable(
    refinement: Refinement, at: Solution, starts: Iterable[Array], balance: Problem, known: list[Solution], kind: Kind
) -> Iterator[Solution]:
    """The motions that Newton's method reaches from starts (2, J, n), each stable and entered among those known."""
    for start in starts:
        other = solution(refinement, start, at.state.speed, balance=balance, harmonics=at.harmonics, kind=kind)
        if other is None or not all(distinct(motion, other) for motion in (at, *known)):
            continue
        other = with_stability(refinement, other)
        if other.stable:
            known.append(other)
            yield other


# --- attractors of integration in time --------------------------------------------------------------------------------


def initial_state(at: Solution) -> Array:
    """q and q' (2, n) [m, m/s] of a solution where a cycle begins."""
    return state_at_start(at.balance, at.state.y, at.state.speed)


def state_at_start(balance: Problem, y: Array, speed: float) -> Array:
    """q and q' (2, n) [m, m/s] of a motion y (2, J, n) at a relative speed where a cycle begins."""
    both = np.stack([y[0].sum(axis=0), -(speed * balance.omega @ y[1])])
    return both @ balance.modal.shapes.T


def attractor(
    refinement: Refinement, start: Array, speed: float, *, harmonics: int, settled: bool = False
) -> Solution | IntegratedMotion:
    """The stable motion of one or two cycles that a start (2, n) approaches, or a record of what it does instead.

    With two mesh tones that is the stable motion of both.  A start on an unstable motion leaves it only as fast as
    rounding grows: give it a perturbation first.

    Parameters
    ----------
    settled : whether the start is the end of a record at the speed before.
    """
    # mesh orders only, and a frame that turns as the balance has it
    ready = refinement.ready
    system, orders = ready.lawful, {line.frequency for _, line in ready.lines.mesh}
    system = replace(system, lines=tuple(line for line in system.lines if line.frequency in orders))
    if ready.frame_speed != "kinematic":
        system = replace(system, G=system.G / speed, Kg=system.Kg / speed**2, Cskew=system.Cskew / speed)
    moving = in_modes_of_its_speed(motion(system, program=constant(speed)))
    cycle = 1.0 / (speed * float(ready.lines.tone))
    samples = _SAMPLES * harmonics
    steps = -(-steps_for(moving, cycle, rate=_STEP_RATE) // samples) * samples
    state, record = start, np.zeros((0, 2, len(start[0])))
    begin, done, two_tones = 0.0, 0, len(ready.lines.tones) > 1
    for count in _LOOKS_ON if settled else _LOOKS:
        # one tone has its first phase again after whole cycles, a second tone has not
        begin, done = done * cycle if two_tones else 0.0, done + count
        record = integrate(
            moving, state, start=begin, stop=begin + count * cycle, steps=count * steps, keep=steps // samples
        )[0]
        if not np.isfinite(record).all():
            break
        state = record[-1]
        times = begin + cycle * np.arange(len(record)) / samples
        for cycles in (1,) if two_tones else (1, 2):
            # all of the record where no period holds both tones, else the last two periods
            some = slice(1 if two_tones else -2 * cycles * samples, None)
            at = _solution_beside(refinement, record[some, 0], times[some], speed, cycles, harmonics)
            if at is not None:
                return at
    times = begin + cycle * np.arange(len(record)) / samples
    force = flank_force(moving, times, record).T
    measures = record_measures(system, force, record[:, 0])
    return IntegratedMotion(
        speed=speed,
        last=state,
        measures=replace(measures, links=_record_links(ready, speed, moving, times, record)),
        unchanging=bool(np.all((force != 0) == (force[0] != 0))),
    )


def _record_links(ready: Response, speed: float, moving: Motion, times: Array, record: Array) -> dict[str, Array]:
    """Measures of links over a record (T, 2, n) [m, m/s] of mesh orders: linear rows, and groups by their laws.

    With them the ranges of transmission errors.
    """
    system, follows = reported_links(ready)
    orders, links = {line.frequency for line in moving.system.lines}, system.links
    if ready.frame_speed != "kinematic":
        links = replace(links, skew=links.skew / speed)
    lines = tuple(line for line in system.lines if line.frequency in orders)
    force = link_force(replace(moving, system=replace(system, lines=lines, links=links)), times, record)
    if follows.size:
        laws = ready.lawful.laws
        force[follows] = laws.force(group_stretch(moving, times, record))[:, ~laws.row_memory].T

    errors = peaks_to_peaks(system.errors, np.ptp(record[:, 0] @ system.error_rows, axis=0))
    measures = record_link_measures(force, lateral_pairs(system), system.links.turn)
    return measures | {name: values for name, (_, values) in errors.items()}


def _solution_beside(
    refinement: Refinement, q: Array, times: Array, speed: float, cycles: int, harmonics: int
) -> Solution | None:
    """The stable solution of so many mesh cycles next to a record q (N, n) [m] at times (N,) [s], None without one.

    Amplitudes at the lattice points are those of least squares over the record.
    """
    balance = refinement.problem(harmonics, cycles=cycles)
    y, rigid = q @ np.linalg.inv(balance.modal.shapes).T, balance.modal.rigid
    y[:, rigid] = 0.0  # what turns freely drifts
    angle = speed * np.outer(times, balance.omega)
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    start = np.linalg.lstsq(wave, y, rcond=_RANK)[0].reshape(2, len(balance.omega), -1)
    start[1, 0] = 0.0
    size = _SAME_BRANCH * float(np.linalg.norm(y - y.mean(axis=0)))
    if np.linalg.norm(y - wave @ start.reshape(-1, y.shape[1])) > size:
        return None
    kind: Kind = "period 2" if cycles == 2 else "periodic"
    at = solution(refinement, start, speed, balance=balance, harmonics=harmonics, kind=kind)
    if at is None:
        return None
    solved = prolonged(at.balance, balance, at.state.y)
    solved[:, :, rigid] = 0.0
    if np.linalg.norm(y - wave @ solved.reshape(-1, y.shape[1])) > size:
        return None
    at = with_stability(refinement, at)
    return at if at.stable else None


# --- where a direction that was stopped goes on -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Begin:
    """A speed of a sweep direction behind which it goes on, by its index.

    reached : there; of a motion of the balance the fields stand in `motion`, with its balance by its size.
    """

    index: int
    reached: Reached
    motion: dict[str, Any] | None = None
    size: ProblemSize | None = None


def begin_of(refinement: Refinement, index: int, reached: Reached) -> Begin:
    """Where a direction goes on behind what was reached, without the balance, which every process has."""
    motion = reached.motion
    if not isinstance(motion, Solution):
        return Begin(index=index, reached=reached)
    known = {field.name: getattr(motion, field.name) for field in fields(Solution) if field.name != "balance"}
    size = refinement.size_of(motion.balance)
    return Begin(index=index, reached=replace(reached, motion=None), motion=known, size=size)


def resumed(refinement: Refinement, begin: Begin) -> Reached:
    """What was reached where a direction goes on."""
    if begin.motion is None or begin.size is None:
        return begin.reached
    return replace(begin.reached, motion=Solution(balance=refinement.lattice(*begin.size), **begin.motion))
