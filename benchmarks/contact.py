"""Contact loss: whole branches in many step settings, points with their stability, what replaces unstable motions."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import table
from known import bench56, with_backlash

import epicyclic
from epicyclic.questions.contact_loss.branch_set import force_level
from epicyclic.questions.contact_loss.continuation import (
    ArclengthUnit,
    PathPoint,
    Stepping,
    arclength_unit,
    branch,
    folds_of_speed,
    linear_start,
    peak_of,
    solve,
)
from epicyclic.questions.contact_loss.problem import Problem, State
from epicyclic.questions.contact_loss.solutions import Refinement, Solution, floquet_stability, solution, with_stability
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.contact_loss.sweep_direction import period_doubled_motions, symmetry_broken_motions
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import response
from epicyclic.system.system import Dofs, FarFlanks, Line, LinkRows, MeshRows, System

HARMONICS = 16
# torque of the arrays [N m] and of the known case; what is known of it: folds [Hz], highest RMS [N]
TORQUE, KNOWN_TORQUE, BACKLASH = 2000.0, 700.0, 1e-4
FOLDS, PEAK = (1361.6, 1357.4), 1715.0
# the ready herringbone set held axially; rigidity of the neck [N m^2] and slide of the sun [m]
HELD = {"stages.main.sun.support.z": "inf", "stages.main.planet.bearing.z": "inf"}
NECK, NECKS, SLIDES = "stages.main.sun.neck", (5.2e7, 4.9e7, 4.6e7, 4.3e7, 4.0e7), (0.0, 0.5e-3, 1e-3)
# first and longest step, and what both units of length are multiplied with: motion, speed
LENGTHS = [
    (0.25, 0.5),
    (0.25, 6.0),
    (0.5, 2.0),
    (1.0, 2.0),
    (1.0, 6.0),
    (1.0, 12.0),
    (2.0, 2.0),
    (2.0, 6.0),
    (2.0, 12.0),
]
UNITS = [(1.0, 1.0), (0.25, 0.25), (0.25, 1.0), (1.0, 0.25)]


def rows(quick: bool) -> list[table.Row]:
    """The table of contact loss."""
    redrawn = _redraw(quick)
    try:
        system = with_backlash(bench56(), backlash=BACKLASH, load=KNOWN_TORQUE / TORQUE)
    except FileNotFoundError as error:
        return [redrawn, ("contact loss, 56 DOF", "skipped", "", f"{error}")]
    return [redrawn, *_branches(system, quick), *_points(system, quick), *_symmetry(system), *_half_order()]


def _redraw(quick: bool) -> table.Row:
    """Figures 9 and 10 of xu2020 in one process: run-up, coast-down, branches and the stability of every point."""
    necks = [{**HELD, f"{NECK}.torsional_rigidity": value} for value in NECKS]
    slides = [{**HELD, "deviations.sun.position.z": value} for value in SLIDES]
    points, lost = 40 if quick else 200, 0
    started, wall = time.process_time(), time.perf_counter()
    for overrides in (*necks, *slides):
        result = epicyclic.sweep(
            "xu2020", overrides=overrides, start=27, stop=5000, points=points, contact_loss=True, unstable="report"
        )
        lost += int((result.status != "ok").sum())
    spent, took = time.process_time() - started, time.perf_counter() - wall
    label = f"xu2020, five necks and three slides, {points} speeds each, up and down, judged"
    here = f"{took:.0f} s ({spent:.0f} s CPU), {lost} lost"
    return _row(label, here, "<= 60 s", took <= 60 and not lost)


def _branches(system: System, quick: bool) -> list[table.Row]:
    """The branch from 1000 to 2400 Hz in many step settings, with and without the guard."""
    refinement = Refinement(ready=response(system))
    settings = [(length, unit) for unit in UNITS for length in (LENGTHS[::4] if quick else LENGTHS)]
    guarded = [_branch(system, refinement, length, unit, guarded=True) for length, unit in settings]
    free = [_branch(system, refinement, length, unit, guarded=False) for length, unit in settings]
    each = [1e3 * took / len(points) for points, took in guarded]
    kept, lost = (sum(_kept(system, points) for points, _ in some) for some in (guarded, free))
    without = sum(not folds_of_speed([point.state.speed for point in points]) for points, _ in free)
    peaks = [_level(system)(points[_top(system, points)].state, points[0].path.balance) for points, _ in guarded]
    turns = np.array([folds_of_speed([1e3 * point.state.speed for point in points])[:2] for points, _ in guarded])
    middle, count = statistics.median(each), len(settings)
    say = f"{turns[:, 0].min():.2f}..{turns[:, 0].max():.2f} and {turns[:, 1].min():.2f}..{turns[:, 1].max():.2f} Hz"
    return [
        _row(f"contact loss, 56 DOF, {count} step settings: a point", f"{middle:.1f} ms", "<= 20 ms", middle <= 20),
        _row(
            "  settings that keep both folds and the peak", f"{kept} of {count}", f"{count} of {count}", kept == count
        ),
        ("  folds", say, "", "known 1361.6 and 1357.4; 48 harmonics, 768 samples: 1361.72 and 1357.23"),
        ("  peak RMS", f"{min(peaks):.1f}..{max(peaks):.1f} N", "", f"known {PEAK:g}"),
        ("  without the guard", f"{lost} of {count}", "", f"{without} have no fold at all"),
    ]


def _branch(
    system: System, refinement: Refinement, length: tuple[float, float], unit: tuple[float, float], *, guarded: bool
) -> tuple[list[PathPoint], float]:
    given = refinement.problem(HARMONICS)
    start = solve(given, linear_start(given, 1.0), 1.0).state
    own = arclength_unit(1.0, 2.4, start.y)
    started = time.process_time()
    points = branch(
        given,
        start,
        low=1.0,
        high=2.4,
        unit=ArclengthUnit(motion=unit[0] * own.motion, speed=unit[1] * own.speed),
        stepping=Stepping(first=length[0], longest=length[1], guarded=guarded),
        score=_level(system),
    )
    return points, time.process_time() - started


def _level(system: System) -> Callable[[State, Problem], float]:
    return lambda state, given: float(force_level(system, given, state).max())


def _top(system: System, points: list[PathPoint]) -> int:
    return peak_of(points, _level(system))


def _kept(system: System, points: list[PathPoint]) -> bool:
    """Whether the branch gets through with both folds within 0.2 Hz and the peak within 0.2 %."""
    turns = folds_of_speed([1e3 * point.state.speed for point in points])
    top = points[_top(system, points)]
    near = len(turns) == 2 and all(abs(a - b) < 0.2 for a, b in zip(turns, FOLDS, strict=True))
    return near and points[-1].state.speed > 2.4 and abs(_level(system)(top.state, top.path.balance) / PEAK - 1) < 2e-3


def _points(system: System, quick: bool) -> list[table.Row]:
    """A sweep with 16 harmonics, and the stability of the points of a branch."""
    frequencies = np.linspace(1000, 2400, 36 if quick else 141)
    started = time.process_time()
    swept = contact_sweep(system, SweepOptions(mesh_frequency=frequencies, harmonics=HARMONICS, unstable="ignore"))
    each = 1e3 * (time.process_time() - started) / frequencies.size
    failed = int((swept.status != "ok").sum())
    refinement = Refinement(ready=response(system))
    points, _ = _branch(system, refinement, (0.25, 0.5), (1.0, 1.0), guarded=True)
    spent = []
    for point in points[:: 8 if quick else 2]:
        started = time.process_time()
        floquet_stability(
            refinement, Solution(balance=point.path.balance, harmonics=HARMONICS, state=point.state, residual=3e-4)
        )
        spent.append(1e3 * (time.process_time() - started))
    median = statistics.median(spent)
    return [
        _row(f"  sweep up and down, {frequencies.size} speeds: a speed", f"{each:.1f} ms", "<= 20 ms", each <= 20),
        _row("  points that failed", f"{failed}", "0", failed == 0),
        _row("  stability of a point", f"{median:.0f} ms", "<= 50 ms", median <= 50),
    ]


def _symmetry(system: System) -> list[table.Row]:
    refinement = Refinement(ready=response(system))
    at = _from_closed(refinement, 2.11)
    started = time.process_time()
    other = next(symmetry_broken_motions(refinement, at), None)
    took = 1e3 * (time.process_time() - started)
    here = _level(system)(at.state, at.balance)
    found = 0.0 if other is None else _level(system)(other.state, other.balance)
    kind = at.stability.kind if at.stability else ""
    good = abs(found / 1129 - 1) < 2e-3 and kind == "symmetry breaking"
    return [
        _row(
            f"  2110 Hz: {here:.0f} N, left by {kind}; stable instead ({took:.0f} ms)",
            f"{found:.0f} N",
            "1129 N, not 963",
            good,
        )
    ]


def _half_order() -> list[table.Row]:
    """One pair at twice its natural frequency: the small motion is left for one of two cycles."""
    system = pair()
    refinement = Refinement(ready=response(system))
    at = _from_closed(refinement, 2.0)
    other = next(period_doubled_motions(refinement, at), None)
    here = _level(system)(at.state, at.balance)
    found = 0.0 if other is None else _level(system)(other.state, other.balance)
    kind = at.stability.kind if at.stability else ""
    good = found > 10 * here and kind == "period doubling"
    return [_row(f"  one pair at 2 f_n: {here:.0f} N, left by {kind}; period 2", f"{found:.0f} N", "> 10 times", good)]


def pair() -> System:
    """A gear pair of 1 kHz, damping ratio 0.8 %, stiffness variation 4.5 %, under 1130 N."""
    nothing, one = np.zeros((1, 1)), np.ones((1, 1))
    swing = np.full((1, 1), 0.045 + 0j)
    return System(
        dofs=Dofs(
            names=("pair/rz",),
            body=("pair",),
            direction=("rz",),
            radius=np.ones(1),
            bodies=("pair",),
            expand=np.zeros((6, 1)),
        ),
        M=one * 2e8 / (2 * np.pi * 1000) ** 2,
        C=nothing,
        G=nothing,
        K=nothing,
        Kg=nothing,
        Cskew=nothing,
        meshes=MeshRows(
            name=("main/pair",),
            pair=("pair",),
            stage=("main",),
            branch=(0,),
            side=("",),
            B=one,
            stiffness=np.full(1, 2e8),
            variation=swing,
            tone=np.zeros(1, np.int64),
            damping=np.zeros(1),
            backlash=np.full(1, 5e-5),
            cos_base_helix=np.ones(1),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((1, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.full(1, 1130.0),
        tones=(Fraction(1000),),
        lines=(
            Line(
                frequency=Fraction(0),
                gap=np.zeros(1, complex),
                link_gap=np.zeros(0, complex),
                force=np.zeros((3, 1), complex),
            ),
        ),
        zeta=0.008,
        far=FarFlanks(mesh=np.zeros(1, np.int64), B=-one, variation=swing),
    )


def _from_closed(refinement: Refinement, speed: float) -> Solution:
    given = refinement.problem(HARMONICS)
    found = solution(refinement, linear_start(given, speed), speed, balance=given, harmonics=HARMONICS, fixed=True)
    if found is None:
        raise RuntimeError(f"no solution from closed teeth at {speed}")
    return with_stability(refinement, found)


def _row(label: str, here: str, target: str, reached: bool) -> table.Row:
    return label, here, target, "" if reached else "MISSED"


if __name__ == "__main__":
    table.main(rows, __doc__)
