"""Contact loss with shaft orders, with two mesh frequencies, and with slices: time a speed, errors in the same process.

    python benchmarks/torus.py [--quick]

CPU seconds of one thread, medians over speeds at which teeth part and the motion is stable.  The system is `bench56`
with 100 um of backlash and run-outs of 10 um at orders whose super-period is short; far flanks mirror the loaded ones.
Error: largest over meshes of |RMS - reference| / largest RMS of the dynamic mesh force; the reference is Runge-Kutta
integration (256 steps a mesh cycle) over a super-period, after 250 mesh cycles from the solution, which it would leave
if that were unstable or wrong.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
import table
from known import bench56, bench112, sliced_xu2020, with_backlash
from numpy.typing import NDArray

from epicyclic.questions.contact_loss.shaft_orders import torus_outputs
from epicyclic.questions.contact_loss.torus import Torus, TorusPoint, respond_torus, torus_of
from epicyclic.questions.response.response import response
from epicyclic.system.system import Line, System, faces

Array = NDArray[np.float64]
BACKLASH, RUN_OUT = 100e-6, 10e-6


def rows(quick: bool) -> list[table.Row]:
    """G11 and G14."""
    try:
        one, two = with_run_outs(("1/27",)), with_run_outs(("1/13", "1/17"))
        coupled = with_backlash(bench112(), backlash=BACKLASH)
    except FileNotFoundError as error:
        return [("contact loss with shaft orders", "skipped", "", f"{error}"), *_slices()]
    speeds = [1500.0, 1700.0, 1900.0] if quick else [1500.0, 1700.0, 1750.0, 1800.0, 1850.0, 1900.0]
    found = [
        *_compare("contact loss, one slow tone (f/27)", one, speeds, cycles=27, seconds=0.1),
        *_compare("contact loss, two slow tones (f/13, f/17)", two, speeds, cycles=221, seconds=0.5),
    ]
    if not quick:
        found += _compare("contact loss, two mesh tones, bench112", coupled, [1750.0], cycles=220, seconds=None)
    return [*found, *_slices()]


def with_run_outs(ratios: Sequence[str]) -> System:
    """`bench56` with backlash and run-outs: of the meshes of one side each, 90 degrees from planet to planet."""
    system = bench56()
    lines = list(system.lines)
    for i, ratio in enumerate(ratios):
        gap = np.zeros(len(system.meshes.name), complex)
        gap[8 * i : 8 * (i + 1)] = RUN_OUT * np.exp(0.5j * np.pi * np.arange(8))
        lines.append(_line(system, Fraction(ratio) * system.tones[0], gap))
    ordered = tuple(sorted(lines, key=lambda line: line.frequency))
    return with_backlash(replace(system, lines=ordered), backlash=BACKLASH)


def _line(system: System, frequency: Fraction, gap: NDArray[np.complex128]) -> Line:
    none = np.zeros((3, len(system.force)), complex)
    return Line(frequency=frequency, gap=gap, link_gap=np.zeros(0, complex), force=none, causes=(f"{frequency} Hz",))


def _compare(
    name: str, system: System, speeds: Sequence[float], *, cycles: int, seconds: float | None
) -> list[table.Row]:
    """Time a speed, and the RMS against integration."""
    given = torus_of(response(system))
    tone = float(given.ready.lines.tone)
    took, points = _timed(lambda frequency: respond_torus(given, frequency / tone), speeds)
    errors = [_error(given, point, cycles) for point in points]
    error, settled = max(e for e, _ in errors), max(s for _, s in errors)
    status = ", ".join(dict.fromkeys(point.status for point in points))
    loaded = faces(system.meshes).row.size
    apart = max(float(1.0 - point.state.touching[:, :loaded].mean()) for point in points)
    shown = ", ".join(f"{1e3 * each:.0f}" for each in took)
    middle = statistics.median(took)
    target = "" if seconds is None else f"<= {seconds:g} s"
    return [
        (
            f"{name}: a speed",
            f"{middle:.3f} s",
            target,
            "" if seconds is None else _target(middle <= seconds),
        ),
        (f"  at {', '.join(f'{f:g}' for f in speeds)} Hz", f"{shown} ms", "", f"{status}; apart up to {apart:.1%}"),
        ("  RMS, integration as reference", f"{error:.1e}", "<= 0.0003", _target(error <= 3e-4)),
        ("  what the reference changes over its super-period", f"{settled:.0e}", "", ""),
    ]


def _timed(run: Callable[[float], TorusPoint], speeds: Sequence[float]) -> tuple[list[float], list[TorusPoint]]:
    """CPU seconds at every speed, the second time, and what came out."""
    took, points = [], []
    for speed in speeds:
        run(speed)
        clock = time.process_time()
        points.append(run(speed))
        took.append(time.process_time() - clock)
    return took, points


def _error(given: Torus, point: TorusPoint, cycles: int, steps: int = 256) -> tuple[float, float]:
    """Error of the RMS, and the relative change of the reference over its super-period."""
    from epicyclic.questions.transient.equation import constant, motion
    from epicyclic.questions.transient.integrators import integrate
    from epicyclic.questions.transient.transient import mesh_force

    y, speed = point.state.y, point.state.speed
    w, tone = speed * point.problem.omega, float(given.ready.lines.tone) * speed
    start = np.stack([y[0].sum(axis=0), -(w[:, None] * y[1]).sum(axis=0)]) @ given.ready.modal.shapes.T
    settle = cycles * max(1, 250 // cycles)
    begin, end = settle / tone, (settle + cycles) / tone
    moving = motion(given.ready.system, program=constant(speed))
    settled = integrate(moving, start, stop=begin, steps=settle * steps, keep=settle * steps)[0][-1]
    states = integrate(moving, settled, start=begin, stop=end, steps=cycles * steps, keep=2)[0]
    times = np.linspace(begin, end, len(states))
    force = mesh_force(moving, times[:-1], states[:-1])
    rms = np.sqrt(force.var(axis=1))
    change = float(np.abs(states[-1] - states[0]).max() / np.abs(states).max())
    return float(np.abs(torus_outputs(given, point).measures.rms - rms).max() / rms.max()), change


def _slices() -> list[table.Row]:
    """Mesh orders of 16 harmonics with 8 slices a mesh, and these against 32."""
    from epicyclic.questions.contact_loss.branch_set import mesh_force
    from epicyclic.questions.contact_loss.continuation import linear_start, solve
    from epicyclic.questions.contact_loss.problem import flank_force, mesh_problem

    # downwards, as a sweep goes: each from the motion at the last
    speeds = [2000.0, 1800.0, 1600.0, 1500.0, 1400.0, 1300.0]
    took: list[float] = []
    rms: dict[int, list[Array]] = {8: [], 32: []}
    apart, lost = 0.0, 0
    for slices, values in rms.items():
        system = with_backlash(sliced_xu2020(slices), backlash=BACKLASH)
        ready, face = response(system, frame_speed="operating"), faces(system.meshes)
        made = mesh_problem(ready, harmonics=16)
        y = linear_start(made, speeds[0] / float(ready.lines.tone))
        for frequency in speeds:
            clock = time.process_time()
            found = solve(made, y, frequency / float(ready.lines.tone))
            spent, y = time.process_time() - clock, found.state.y
            values.append(mesh_force(system, flank_force(made, found.state)).std(axis=0))
            if slices == 8:
                took.append(spent)
                apart = max(apart, float(1 - found.state.touching[:, : face.row.size].mean()))
                lost += not found.converged
    middle = statistics.median(took)
    error = max(float(np.abs(few - many).max() / many.max()) for few, many in zip(rms[8], rms[32], strict=True))
    size = len(system.force)
    shown = ", ".join(f"{1e3 * each:.0f}" for each in took)
    return [
        (
            f"slices in dynamics, 8 a mesh, {size} DOF: a point",
            f"{1e3 * middle:.1f} ms",
            "<= 25 ms",
            _target(middle <= 0.025),
        ),
        (f"  at {', '.join(f'{f:g}' for f in speeds)} Hz", f"{shown} ms", "", f"{lost} lost; apart up to {apart:.1%}"),
        ("  RMS of 8 slices against 32", f"{error:.1e}", "<= 0.005", _target(error <= 5e-3)),
    ]


def _target(reached: bool) -> str:
    return "met" if reached else "MISSED"


if __name__ == "__main__":
    table.main(rows, __doc__)
