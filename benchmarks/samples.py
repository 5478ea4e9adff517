"""Many samples at one speed: errors by one linear map, stiffnesses exactly solved, against separate full solutions.

    python benchmarks/samples.py [--quick]

CPU seconds of one thread in a fresh process, the map included; memory is its largest resident set.  Error: largest over
meshes and the samples checked of |RMS - reference| / largest RMS, the reference a sweep of a train built for that one
sample at tolerance 1e-11.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import table
from known import TONE, bench56
from numpy.typing import NDArray

from epicyclic.analyses.samples.error_map import error_map, mesh_error_lines
from epicyclic.analyses.samples.errors import error_samples
from epicyclic.analyses.samples.stiffness import stiffness_samples
from epicyclic.analyses.steady.sweep import sweep

Array = NDArray[np.float64]
FREQUENCIES = (600.0, 1646.0, 3500.0)
CHECKED = 3
PIECE = 20_000


def rows(quick: bool) -> list[table.Row]:
    """Both kinds of samples at a speed below, at and above the main resonance."""
    try:
        bench56()
    except FileNotFoundError as absent:
        return [("samples, 56 DOF", "skipped", "", f"{absent}")]
    part = 10 if quick else 1
    found: list[table.Row] = []
    for kind, count, seconds in (("stiffness", 10_000 // part, 8.0), ("error", 1_000_000 // part, 15.0)):
        for frequency in FREQUENCIES[1:2] if quick else FREQUENCIES:
            took, megabytes, error = _run(kind, count, frequency)
            limit = seconds / part
            met = took <= limit and megabytes <= 1024
            found += [
                (
                    f"{count} {kind} samples, 56 DOF, {frequency:g} Hz",
                    f"{took:.2f} s",
                    f"<= {limit:g} s, 1 GB",
                    f"{'met' if met else 'MISSED'}, {megabytes:.0f} MB",
                ),
                table.judged("  error, full solutions as reference", f"{error:.1e}", "<= 1e-05", error <= 1e-5),
            ]
    return found


def _run(kind: str, count: int, frequency: float) -> tuple[float, float, float]:
    command = [sys.executable, __file__, "--one", kind, str(count), str(frequency)]
    took, megabytes, error = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return float(took), float(megabytes), float(error)


def _stiffness(count: int, speed: float) -> tuple[float, float]:
    """10 % of scatter on each of the 16 mean mesh stiffnesses."""
    system = bench56()
    factors = np.abs(1 + 0.1 * np.random.default_rng(1).standard_normal((count, len(system.meshes.name))))
    clock = time.process_time()
    found = stiffness_samples(system, factors, relative_speed=speed).values
    took = time.process_time() - clock
    built = [
        replace(system, meshes=replace(system.meshes, stiffness=system.meshes.stiffness * factor))
        for factor in factors[:CHECKED]
    ]
    return took, _error(found, built, speed)


def _errors(count: int, speed: float) -> tuple[float, float]:
    """Errors of every mesh in three orders, 4 um RMS and any phase, drawn piece by piece; drawing them counts."""
    system = bench56()
    clock = time.process_time()
    columns = mesh_error_lines(system)
    found = error_samples(error_map(system, columns, relative_speed=speed), _drawn(count, len(columns)))
    took = time.process_time() - clock
    first = next(_drawn(count, len(columns)))[:CHECKED]
    built = [
        replace(
            system,
            lines=(
                *system.lines,
                *(replace(line, gap=z * line.gap) for z, line in zip(factor, columns, strict=True)),
            ),
        )
        for factor in first
    ]
    return took, _error(found, built, speed)


def _drawn(count: int, columns: int) -> Iterator[NDArray[np.complex128]]:
    random = np.random.default_rng(2)
    for first in range(0, count, PIECE):
        shape = (min(PIECE, count - first), columns)
        yield 4e-6 * (random.standard_normal(shape) + 1j * random.standard_normal(shape))


def _error(found: Array, built: list[Any], speed: float) -> float:
    full = [sweep(system, relative_speed=[speed], tolerance=1e-11).mesh_force_rms.values[:, 0] for system in built]
    return max(float(np.abs(found[:, i] - rms).max() / rms.max()) for i, rms in enumerate(full))


def main() -> int:
    """Print the rows; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a tenth of the samples, one speed")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        kind, count, frequency = given.one
        run = _stiffness if kind == "stiffness" else _errors
        took, error = run(int(count), float(frequency) / TONE)
        print(took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, error)
        return 0
    found = rows(given.quick)
    table.show(found)
    return int(bool(table.missed(found)))


if __name__ == "__main__":
    sys.exit(main())
