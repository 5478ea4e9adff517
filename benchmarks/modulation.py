"""Lines at a fixed sensor from the response, beside sampling the passing forces over their whole common period."""

from __future__ import annotations

import time

import numpy as np
import table
from timing import cpu_seconds

from epicyclic.questions.modulation import ModulationOptions
from epicyclic.questions.modulation.modulation import modulation
from epicyclic.questions.response.measures import periodic
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

__all__ = ["rows"]

# ren2021 with sun and planet run-out comes back after lcm(23, 17, 57) mesh cycles
_CYCLES, _QUICK, _SAMPLES = 23 * 17 * 57, 23 * 57, 128
_LIMIT = 1e-9


def rows(quick: bool) -> list[table.Row]:
    """The two routes, their times and how far they are apart; quick : without planet run-out, a 17th of the period."""
    changes = {"deviations": None, "deviations.sun.run_out": "20 um", "deviations.meshes.planet-ring.profile": "20 um"}
    if not quick:
        changes["deviations.planet.run_out"] = "20 um"
    system = assemble(load("ren2021", overrides=changes))
    cycles = _QUICK if quick else _CYCLES
    lines = modulation(system, ModulationOptions(window="cos4", floor=0.0, samples=2**15))
    took = cpu_seconds(lambda: modulation(system, ModulationOptions()), repeats=5)[0]
    start = time.process_time()
    spectrum = _sampled(system, cycles)
    sampling = time.process_time() - start
    place = (lines.line_frequency.values * cycles / float(system.tones[0])).round().astype(int)
    exact = np.zeros(spectrum.size, complex)
    np.add.at(exact, place, lines.signal_amplitude.values)
    error = float(np.abs(spectrum - exact).max() / np.abs(exact).max())
    return [
        ("modulation, ren2021, all of it", f"{1e3 * took:.0f} ms", "", f"{lines.sizes['line']} lines"),
        (f"sampled and transformed, {cycles} mesh cycles", f"{sampling:.2f} s", "", f"{sampling / took:.0f} times"),
        table.judged("lines against the transform", f"{error:.1e}", f"<= {_LIMIT:g}", error <= _LIMIT),
    ]


def _sampled(system: System, cycles: int) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    """Spectrum of the forces that pass under a cos^4(phi/2) window."""
    solved = periodic(system, samples=_SAMPLES)
    count = cycles * _SAMPLES
    instant, phase = np.arange(count) / (_SAMPLES * float(solved.tone)), np.arange(count) % _SAMPLES
    turn = 2 * np.pi * float(system.stage_turns["main"]) * instant
    waves = [np.exp(2j * np.pi * float(line.frequency) * instant) for line in solved.lines]
    signal = np.zeros(count)
    for row in np.flatnonzero(system.meshes.internal):
        force = solved.force[row, phase] - solved.force[row].mean()
        for line, wave in zip(solved.lines, waves, strict=True):
            force += (line.force[row, phase] * wave).real
        signal += np.cos((system.meshes.direction[row] + turn) / 2) ** 4 * force
    return np.fft.rfft(signal - signal.mean()) * 2 / count


if __name__ == "__main__":
    table.main(rows, __doc__)
