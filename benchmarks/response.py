"""One table: what the solver takes beside time integration at equal error, all measured in this process.

    python benchmarks/response.py [--quick]

CPU seconds of one thread, medians.  Baseline: `solve_ivp` DOP853 from the mean equilibrium, RMS over one mesh cycle
after a transient of 10 / (zeta omega_1); rtol 1e-4 (less where no atol helps) and the loosest atol of a power of ten
that meets the error limit at every speed measured.  Error: largest over meshes of |RMS - reference| / largest RMS of
the dynamic mesh force; the reference is the shooting solution of the same equation, rtol 1e-9.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import resource
import statistics
import subprocess
import sys
from dataclasses import replace

import baseline
import numpy as np
import table
from known import KNOWN112, MESHES112, bench56, bench112
from timing import cpu_seconds

from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.response.steady import sweep
from epicyclic.system.system import System

LIMIT = 1e-4
REPEATS = 7


def rows(quick: bool) -> list[table.Row]:
    """Sweeps beside time integration, several tones, modes, and a whole process."""
    return [*_ren2021(quick), *_bench56(quick), *_bench112(), *_modes(), *_process()]


def _ren2021(quick: bool) -> list[table.Row]:
    from epicyclic.system.assembly import assemble
    from epicyclic.train.resolution import load

    system = assemble(load("ren2021"))
    speeds = [20.0, 86.0, 212.0, 600.0] if quick else [20.0, 43.0, 86.0, 130.0, 212.0, 300.0, 450.0, 600.0]
    return _compare("ren2021", system, np.linspace(20, 600, 200), speeds=speeds, seconds=0.15, times=800)


def _bench56(quick: bool) -> list[table.Row]:
    try:
        system = bench56()
    except FileNotFoundError as error:
        return [("56 DOF, 200 speeds", "skipped", "", f"{error}")]
    speeds = [300.0, 1646.0, 3500.0] if quick else [300.0, 600.0, 1000.0, 1646.0, 2400.0, 3500.0, 5000.0]
    frequencies = np.linspace(300, 5000, 200)
    found = _compare("56 DOF", system, frequencies, speeds=speeds, seconds=0.2, times=3000)
    return found


def _bench112() -> list[table.Row]:
    """Two mesh frequencies at once: time, RMS against known forces, waveform against a finer solution."""
    try:
        system = bench112()
    except FileNotFoundError as absent:
        return [("two tones, bench112", "skipped", "", f"{absent}")]
    frequencies = np.linspace(600, 5000, 40)
    took, _ = cpu_seconds(lambda: sweep(system, SweepOptions(mesh_frequency=frequencies)), repeats=3)
    each = 1e3 * took / frequencies.size
    known = np.array(list(KNOWN112.values())).T
    rms = sweep(system, SweepOptions(mesh_frequency=list(KNOWN112))).mesh_force_rms.values[MESHES112]
    error = float(np.abs(rms / known - 1).max())
    wave = max(_waveform_error(system, frequency) for frequency in KNOWN112)
    label = f"two tones, bench112, {frequencies.size} speeds {frequencies[0]:g}..{frequencies[-1]:g} Hz"
    return [
        table.judged(f"{label}: a speed", f"{each:.1f} ms", "<= 12 ms", each <= 12),
        table.judged("  RMS, largest relative error of known forces", f"{error:.1e}", "<= 1e-05", error <= 1e-5),
        table.judged("  waveform, residual and tolerance 1e-10 as reference", f"{wave:.1e}", "<= 0.0001", wave <= 1e-4),
    ]


def _waveform_error(system: System, frequency: float) -> float:
    """Largest difference of a mesh force at any time to a finer solution, per the largest RMS, at a sweep's tolerance.

    Both are summed over a super-period of the tones.
    """
    tone = max(system.tones)
    times = np.linspace(0, 220 / frequency, 20_001)[:-1]
    signals = []
    for tolerance in (1e-6, 1e-10):
        found = periodic(system, relative_speed=frequency / float(tone), tolerance=tolerance)
        phase = np.outer(np.fft.fftfreq(found.theta.size, 1 / found.theta.size), times * frequency)
        wave = np.exp(2j * np.pi * phase)
        spectrum = np.fft.fft(found.force) / found.theta.size
        total = (spectrum @ wave).real
        for line in found.lines:
            carrier = np.exp(2j * np.pi * float(line.frequency) * found.relative_speed * times)
            total += (np.fft.fft(line.force) / found.theta.size @ wave * carrier).real
        signals.append(total)
    return float(np.abs(signals[0] - signals[1]).max() / signals[1].std(axis=1).max())


def _compare(
    name: str, system: System, frequencies: np.ndarray, *, speeds: list[float], seconds: float, times: float
) -> list[table.Row]:
    """Sweep against the baseline: time, error, ratio."""
    tone = system.tones[0]
    mesh_orders = replace(system, lines=tuple(li for li in system.lines if (li.frequency / tone).denominator == 1))
    took, _ = cpu_seconds(lambda: sweep(mesh_orders, SweepOptions(mesh_frequency=frequencies)), repeats=REPEATS)
    rms = sweep(mesh_orders, SweepOptions(mesh_frequency=speeds)).mesh_force_rms.values
    motions = [baseline.equation(mesh_orders, frequency) for frequency in speeds]
    references = [baseline.shooting(motion) for motion in motions]
    error = max(baseline.relative(rms[:, i], reference) for i, reference in enumerate(references))
    spent, reached, setting = baseline.fair(motions, references, limit=LIMIT)
    whole = float(np.interp(frequencies, speeds, spent).sum())
    listed = ", ".join(f"{frequency:g}" for frequency in speeds)
    label = f"{name}, {frequencies.size} speeds {frequencies[0]:g}..{frequencies[-1]:g} Hz"
    found = [
        table.judged(f"{label}: sweep", f"{took:.3f} s", f"<= {seconds:g} s", took <= seconds),
        table.judged("  error, shooting as reference", f"{error:.1e}", f"<= {LIMIT:g}", error <= LIMIT),
        (
            f"  DOP853 {setting}, transient {motions[0].settle:.3g} s",
            f"{whole:.0f} s",
            "extrapolated",
            f"from {len(speeds)} speeds ({listed} Hz; {', '.join(f'{s:.2g}' for s in spent)} s), error {reached:.1e}",
        ),
        table.judged("  ratio", f"{whole / took:.0f}x", f">= {times:g}x", whole / took >= times),
    ]
    if len(mesh_orders.lines) < len(system.lines):
        full, _ = cpu_seconds(lambda: sweep(system, SweepOptions(mesh_frequency=frequencies)), repeats=3)
        count = len(system.lines) - len(mesh_orders.lines)
        found.append((f"  the same with its {count} shaft orders", f"{full:.3f} s", "", "no baseline"))
    return found


def _modes() -> list[table.Row]:
    from epicyclic.questions.modes.eigen import eigen
    from epicyclic.questions.modes.modal import modal
    from epicyclic.system.assembly import assemble
    from epicyclic.train.resolution import load

    train = load("lin1999-n4")
    system = assemble(train)
    whole, _ = cpu_seconds(lambda: eigen(assemble(train)), repeats=201)
    only, _ = cpu_seconds(lambda: eigen(system), repeats=201)
    labelled, _ = cpu_seconds(lambda: modal(assemble(train)), repeats=51)
    size = system.force.size
    return [
        table.judged(
            f"modes of a {size}-DOF stage: assemble + solve", f"{1e3 * whole:.2f} ms", "<= 1 ms", whole <= 1e-3
        ),
        ("  of that the solution", f"{1e3 * only:.2f} ms", "", ""),
        ("  with kinds, energy shares and labels (Dataset)", f"{1e3 * labelled:.2f} ms", "", ""),
    ]


def _process() -> list[table.Row]:
    command = [
        sys.executable,
        "-m",
        "epicyclic",
        "sweep",
        "ren2021",
        "--start",
        "20 Hz",
        "--stop",
        "600 Hz",
        "--points",
        "200",
    ]
    spent = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([*command, "--json"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    took = statistics.median(spent)
    return [table.judged("`epicyclic sweep ren2021`, 200 speeds, fresh process", f"{took:.2f} s", "<= 2 s", took <= 2)]


if __name__ == "__main__":
    table.main(rows, __doc__)
