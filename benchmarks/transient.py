"""What a simulated mesh cycle costs: compiled Runge-Kutta and DOP853 at equal error, and the memory of a long run.

    python benchmarks/transient.py [--quick]

CPU seconds of one thread for the transient of 10 / (zeta omega_1) and one cycle, per cycle; RMS error of the dynamic
mesh forces against harmonic balance (1e-8), the loosest step that meets the limit.  Compilation is not counted.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import subprocess
import sys
import time
from functools import partial

import baseline
import numpy as np
import table
from known import bench56

from epicyclic.machine_code import numba_available
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.transient.equation import constant, motion
from epicyclic.questions.transient.integrators import at_equilibrium, integrate, steps_for
from epicyclic.system.system import System
from peers import loosest, problem, rk4_rms

LIMIT = 1e-4
STEPS = [32, 48, 64, 96, 128, 192, 256, 384, 512, 768]

MEMORY = """
import resource, sys
import epicyclic
cycles = int(sys.argv[1])
epicyclic.transient("ren2021", cycles=8, decimate=8)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
epicyclic.transient("ren2021", cycles=cycles, decimate=cycles // 8)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def rows(quick: bool) -> list[table.Row]:
    """The table."""
    if not numba_available():
        return [("time per simulated mesh cycle", "skipped", "", "numba is not installed")]
    found = _cycles("ren2021", problem(), [160.0] if quick else [30.0, 160.0])
    try:
        found += _cycles("bench56", bench56(), [1646.0] if quick else [600.0, 1646.0, 3500.0])
    except FileNotFoundError as error:
        found.append(("bench56", "skipped", "", str(error)))
    return [*found, *_memory(quick)]


def _cycles(name: str, system: System, frequencies: list[float]) -> list[table.Row]:
    found: list[table.Row] = []
    for frequency in frequencies:
        equation = baseline.equation(system, frequency)
        cycles = int(np.ceil(equation.settle * frequency)) + 1
        speed = frequency / float(system.tones[0])
        reference = periodic(system, relative_speed=speed, samples=128).force.std(axis=1)
        linear = motion(system, program=constant(speed), contact="linear")
        rk4_rms(linear, 32, 2, frequency)
        best = loosest(partial(rk4_rms, linear, cycles=cycles, frequency=frequency), reference, LIMIT, STEPS)
        label = f"{name}, {frequency:g} Hz, {cycles} cycles, error <= {LIMIT:g}: a mesh cycle"
        if best is None:
            found.append((label, "not met", "", f"up to {STEPS[-1]} steps a cycle"))
            continue
        steps, spent, error = best
        found.append((f"{label}, Runge-Kutta", f"{1e3 * spent / cycles:.2f} ms", "", f"{steps} steps, {error:.1e}"))
        found.append(_apart(system, speed, frequency))
        seconds, error, setting = baseline.fair([equation], [reference], limit=LIMIT)
        each = seconds[0] / cycles
        found.append(("  DOP853", f"{1e3 * each:.2f} ms", f"{each * cycles / spent:.0f}x", f"{setting}, {error:.1e}"))
    return found


def _apart(system: System, speed: float, frequency: float) -> table.Row:
    """The default step with teeth that may part."""
    moving = motion(system, program=constant(speed))
    steps, cycles = steps_for(moving, 1 / frequency), 50
    begin = at_equilibrium(moving)
    integrate(moving, begin, stop=1 / frequency, steps=steps)[0]
    clock = time.process_time()
    integrate(moving, begin, stop=cycles / frequency, steps=steps * cycles, keep=steps)[0]
    each = (time.process_time() - clock) / cycles
    return "  contact that opens, default step", f"{1e3 * each:.2f} ms", "", f"{steps} steps"


def _memory(quick: bool) -> list[table.Row]:
    """Growth of the process while a run goes, decimated to the same size of result."""
    found: list[table.Row] = []
    for cycles in (80, 800) if quick else (80, 800, 8000):
        done = subprocess.run([sys.executable, "-c", MEMORY, str(cycles)], capture_output=True, text=True, check=True)
        found.append(
            (f"memory of a run of {cycles} cycles, 256 samples kept", f"{int(done.stdout) / 1024:.1f} MB", "", "")
        )
    return found


if __name__ == "__main__":
    table.main(rows, __doc__)
