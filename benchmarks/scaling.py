"""How the linear sweep grows with degrees of freedom and meshes, in time, memory and error.

    python benchmarks/scaling.py [--quick]

The trains are planetary stages of 4 to 20 planets built from a model dict, a chain of bodies on the carrier filling up
to 30, 56, 100 and 200 degrees of freedom.  CPU seconds of one thread, medians; memory, in a fresh process, is the most
that numpy held at once during the sweep, and the largest resident set, libraries included.  Error as in bench.py,
against shooting (30 and 56) and, where that would take minutes, against the same solver at tolerance 1e-11.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import resource
import statistics
import subprocess
import sys
import time
import tracemalloc
from itertools import pairwise
from pathlib import Path
from typing import Any

import baseline
import numpy as np
import table

from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.steady import sweep
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

# degrees of freedom: planets (two meshes each), bodies on the carrier, directions
CASES = {30: (4, 3, "xy"), 56: (8, 3, "xyz"), 100: (12, 10, "xyz"), 200: (20, 27, "xyz")}
TEETH = {"sun": 221, "planet": 19, "ring": 259}
SPEEDS = np.linspace(300, 3000, 40)
# speeds at which the error is measured
CHECKED = [300.0, 900.0, 2100.0]
SHOT = 56


def chain(size: int) -> System:
    """A planetary stage with so many degrees of freedom, from a model dict."""
    planets, count, directions = CASES[size]
    axes = dict.fromkeys(directions, "2e8 N/m")
    shafts = [f"shaft{i}" for i in range(1, count + 1)]
    ends = ["main.carrier", *shafts]
    model: dict[str, Any] = {
        "format": 2,
        "title": f"{size} degrees of freedom",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": planets,
                "module": "2 mm",
                "helix_angle": "12 deg" if "z" in directions else "0 deg",
                "face_width": "40 mm",
                "sun": {"teeth": TEETH["sun"], "mass": "20 kg", "inertia": "10 kg", "support": axes},
                "planet": {"teeth": TEETH["planet"], "mass": "0.4 kg", "inertia": "0.3 kg", "bearing": axes},
                "ring": {
                    "teeth": TEETH["ring"],
                    "mass": "30 kg",
                    "inertia": "25 kg",
                    "support": {**axes, "rz": "1e9 N/m"},
                },
                "carrier": {"mass": "25 kg", "inertia": "15 kg", "support": axes},
                "meshes": {
                    pair: {"stiffness": "4e8 N/m", "variation": {"cosine": [0.12, 0.05, 0.02, 0.01]}}
                    for pair in ("sun-planet", "planet-ring")
                },
            }
        },
        "bodies": {
            name: {"mass": "3 kg", "inertia": "0.02 kg m^2", "support": axes, "frame": "main"} for name in shafts
        },
        "couplings": {
            f"tie{i}": {"between": list(pair), "rz": "2e6 N m/rad", **dict.fromkeys(directions, "1e8 N/m")}
            for i, pair in enumerate(pairwise(ends), 1)
        },
        "operation": {"held": ["ring"], "speed": {"sun": "300 rpm"}, "torque": {"sun": "2 kN m", ends[-1]: "balance"}},
        "deviations": {
            "meshes": {pair: {"profile": "4 um"} for pair in ("sun-planet", "planet-ring")},
        },
    }
    system = assemble(load(model))
    if len(system.force) != size:
        raise ValueError(f"{len(system.force)} degrees of freedom instead of {size}")
    return system


def rows(quick: bool) -> list[table.Row]:
    """Time a speed, memory and error of every case."""
    found: list[table.Row] = []
    for size in [30, 56] if quick else list(CASES):
        system = chain(size)
        took, limit = _each(system), 4e-3 if size == 200 else None
        label = f"{size} DOF, {len(system.meshes.name)} meshes, {SPEEDS.size} speeds: a speed"
        target, verdict = ("<= 4 ms", "met" if took <= limit else "MISSED") if limit else ("", "")
        arrays, peak = _memory(size)
        note = f"{verdict} arrays {arrays:.1f} MB, process {peak:.0f} MB"
        found.append((label, f"{1e3 * took:.2f} ms", target, note.strip()))
        error, reference = _error(system)
        found.append(table.judged(f"  error, {reference}", f"{error:.1e}", "<= 1e-04", error <= 1e-4))
    return found


def _each(system: System) -> float:
    """Median CPU seconds a speed."""
    spent = []
    for _ in range(4):
        clock = time.process_time()
        sweep(system, SweepOptions(mesh_frequency=SPEEDS))
        spent.append(time.process_time() - clock)
    return statistics.median(spent[1:]) / SPEEDS.size


def _memory(size: int) -> tuple[float, float]:
    """Most that arrays took during the sweep, and the largest resident set, of a fresh process, MB."""
    command = [sys.executable, __file__, "--memory", str(size)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return float(answer[0]), float(answer[1])


def _print_memory(size: int) -> None:
    system = chain(size)
    # once before tracing, which has a price of its own
    sweep(system, SweepOptions(mesh_frequency=SPEEDS))
    peak = _largest_set()
    tracemalloc.start()
    sweep(system, SweepOptions(mesh_frequency=SPEEDS))
    print(tracemalloc.get_traced_memory()[1] / 2**20, peak)


def _largest_set() -> float:
    """Largest resident set so far, MB; what `getrusage` says of a child may be that of its parent."""
    status = Path("/proc/self/status")
    if status.is_file():
        return float(status.read_text(encoding="ascii").split("VmHWM:")[1].split()[0]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _error(system: System) -> tuple[float, str]:
    rms = sweep(system, SweepOptions(mesh_frequency=CHECKED)).mesh_force_rms.values
    if len(system.force) > SHOT:
        fine = sweep(system, SweepOptions(mesh_frequency=CHECKED, tolerance=1e-11)).mesh_force_rms.values
        return max(baseline.relative(a, b) for a, b in zip(rms.T, fine.T, strict=True)), "tolerance 1e-11 as reference"
    shot = [baseline.shooting(baseline.equation(system, frequency)) for frequency in CHECKED]
    return max(baseline.relative(a, b) for a, b in zip(rms.T, shot, strict=True)), "shooting as reference"


def main() -> int:
    """Print the rows; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the two smallest trains")
    parser.add_argument("--memory", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.memory:
        _print_memory(given.memory)
        return 0
    found = rows(given.quick)
    table.show(found)
    return int(bool(table.missed(found)))


if __name__ == "__main__":
    sys.exit(main())
