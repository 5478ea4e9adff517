"""One problem in one run, at equal error: scipy's solve_ivp, Exudyn's generalised-alpha, and what is here.

    python benchmarks/peers.py [--quick]

The ready drive ren2021 at mesh orders, linear contact, near its resonance: RMS of the dynamic mesh forces over one
mesh cycle, after a transient of 10 / (zeta omega_1) from the mean equilibrium for everything that integrates.
Reference: the shooting solution, rtol 1e-9.  CPU seconds of one thread; every method at the loosest setting of its
list that meets the limit.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import baseline
import numpy as np
import table
from numpy.typing import NDArray

from epicyclic.machine_code import numba_available
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.transient.equation import Motion, constant, from_modal, motion, to_modal
from epicyclic.questions.transient.integrators import at_equilibrium, instant_terms, integrate, row_force
from epicyclic.questions.transient.transient import mesh_force
from epicyclic.system.system import System

Array = NDArray[np.float64]
FREQUENCY, LIMIT = 160.0, 1e-3
# the same error for all that is drawn from a mesh cycle: as many samples
SAMPLES = 128


def problem() -> System:
    """ren2021 with the lines that are multiples of its mesh frequency."""
    from epicyclic.system.assembly import assemble
    from epicyclic.train.resolution import load

    system = assemble(load("ren2021"))
    tone = system.tones[0]
    return replace(system, lines=tuple(li for li in system.lines if (li.frequency / tone).denominator == 1))


def mean_start(moving: Motion) -> Array:
    """Modal state of the equilibrium at time 0."""
    return to_modal(moving, at_equilibrium(moving))


def exudyn_rms(
    moving: Motion, steps: int, cycles: int, frequency: float, start: Array | None = None
) -> tuple[Array, float]:
    """RMS of the mesh forces (m,) by Exudyn's generalised-alpha, and CPU seconds.

    start : (2, n) q, q'; the mean equilibrium where None.  The matrices are those of the mean system in modal
    coordinates; what varies is a user function in Python, as an engineer would add it.
    """
    import exudyn as exu
    import exudyn.itemInterface as item

    N, n = moving.numbers, moving.numbers.squared.size
    s = float(N.program.speed[0])
    damping = np.diag(N.rate) + (N.damp[0] + s * N.damp[1]).T
    stiffness = np.diag(N.squared) + (s * s * N.stiff[0] + s * N.stiff[1]).T
    begin = mean_start(moving) if start is None else to_modal(moving, start)

    def push(_mbs: Any, t: float, _number: int, q: Any, v: Any) -> Array:
        at, y = instant_terms(moving, t, t), np.asarray(q)
        stretch = y @ N.gaps
        forces = N.linear * stretch - row_force(moving, at, stretch, np.asarray(v) @ N.gaps)
        return np.asarray(at.push + forces @ N.pulls)

    container = exu.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        item.NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=list(begin[0]),
            initialCoordinates_t=list(begin[1]),
            numberOfODE2Coordinates=n,
        )
    )
    system.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=np.eye(n),
            stiffnessMatrix=stiffness,
            dampingMatrix=damping,
            forceUserFunction=push,
        )
    )
    sensor = system.AddSensor(
        item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=exu.OutputVariableType.Coordinates)
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps * cycles
    settings.timeIntegration.endTime = cycles / frequency
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1 / (frequency * min(steps, SAMPLES))
    clock = time.process_time()
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    spent = time.process_time() - clock
    stored = np.asarray(system.GetSensorStoredData(sensor))
    last = stored[-1 - min(steps, SAMPLES) : -1]
    states = np.stack([last[:, 1:], np.zeros_like(last[:, 1:])], axis=1)
    return mesh_force(moving, last[:, 0], from_modal(moving, states)).std(axis=1), spent


def rk4_rms(moving: Motion, steps: int, cycles: int, frequency: float) -> tuple[Array, float]:
    """The same by the compiled fixed steps."""
    keep, begin = max(1, steps // SAMPLES), at_equilibrium(moving)
    clock = time.process_time()
    found = integrate(moving, begin, stop=cycles / frequency, steps=steps * cycles, keep=keep)[0]
    spent = time.process_time() - clock
    count = steps // keep
    times = (np.arange(count) + (cycles - 1) * count) / (count * frequency)
    return mesh_force(moving, times, found[-1 - count : -1]).std(axis=1), spent


def loosest(
    run: Callable[[int], tuple[Array, float]], reference: Array, limit: float, settings: list[int]
) -> tuple[int, float, float] | None:
    """(setting, CPU seconds, error) of the first setting that meets the limit."""
    for setting in settings:
        rms, spent = run(setting)
        error = baseline.relative(rms, reference)
        if error <= limit:
            return setting, spent, error
    return None


def rows(quick: bool) -> list[table.Row]:
    """The table: harmonic balance, compiled Runge-Kutta, DOP853, generalised-alpha."""
    system = problem()
    equation = baseline.equation(system, FREQUENCY)
    reference = baseline.shooting(equation)
    speed = FREQUENCY / float(system.tones[0])
    moving = motion(system, program=constant(speed), contact="linear")
    cycles = int(np.ceil(equation.settle * FREQUENCY)) + 1
    size = len(system.force)
    found: list[table.Row] = [
        (
            f"ren2021, {size} DOF, {FREQUENCY:g} Hz, {cycles} mesh cycles, error <= {LIMIT:g}",
            "CPU",
            "",
            "setting, error",
        )
    ]
    took, rms = _median(lambda: periodic(system, relative_speed=speed, samples=SAMPLES).force.std(axis=1))
    found.append(("  harmonic balance, one speed", f"{1e3 * took:.1f} ms", "", _said("default", rms, reference)))
    if numba_available():
        rk4_rms(moving, 32, 2, FREQUENCY)
        best = loosest(
            lambda n: rk4_rms(moving, n, cycles, FREQUENCY), reference, LIMIT, [48, 64, 96, 128, 192, 256, 512]
        )
        found.append(_row("  Runge-Kutta, compiled here", best, took, "steps a cycle"))
    seconds, error, setting = baseline.fair([equation], [reference], limit=LIMIT)
    found.append(
        ("  scipy solve_ivp DOP853", f"{seconds[0]:.2f} s", f"{seconds[0] / took:.0f}x", f"{setting}, {error:.1e}")
    )
    found.append(_exudyn(moving, cycles, reference, took, [128, 256] if quick else [64, 96, 128, 192, 256, 384, 512]))
    return found


def _exudyn(moving: Motion, cycles: int, reference: Array, took: float, settings: list[int]) -> table.Row:
    name = "  Exudyn generalised-alpha, user force in Python"
    try:
        import exudyn  # noqa: F401
    except ImportError:
        return name, "skipped", "", "exudyn is not installed (pip install 'epicyclic[peers]')"
    best = loosest(lambda n: exudyn_rms(moving, n, cycles, FREQUENCY), reference, LIMIT, settings)
    if best is None:
        rms, spent = exudyn_rms(moving, settings[-1], cycles, FREQUENCY)
        return name, f"{spent:.2f} s", f"{spent / took:.0f}x", _said(f"{settings[-1]} steps a cycle", rms, reference)
    return _row(name, best, took, "steps a cycle")


def _row(name: str, best: tuple[int, float, float] | None, took: float, unit: str) -> table.Row:
    if best is None:
        return name, "not met", "", "at any setting tried"
    setting, spent, error = best
    return name, f"{spent:.3f} s", f"{spent / took:.0f}x", f"{setting} {unit}, {error:.1e}"


def _said(setting: str, rms: Array, reference: Array) -> str:
    return f"{setting}, {baseline.relative(rms, reference):.1e}"


def _median(run: Callable[[], Array]) -> tuple[float, Array]:
    run()
    spent = []
    for _ in range(7):
        clock = time.process_time()
        value = run()
        spent.append(time.process_time() - clock)
    return statistics.median(spent), value


if __name__ == "__main__":
    table.main(rows, __doc__)
