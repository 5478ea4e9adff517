"""Floquet multipliers of the 56-degree-of-freedom set: time a speed, and error against the integrated monodromy.

    python benchmarks/stability.py

The reference is the monodromy of the same equation in physical coordinates, DOP853 with rtol 1e-9 on all 112 columns.
Errors: of the largest multiplier's magnitude, and of the whole set of multipliers matched as well as can be.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import statistics
import time
from collections.abc import Callable

import numpy as np
import table
from known import bench56
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import linear_sum_assignment

from epicyclic.questions.stability.stability import floquet_scan, parametric_system, predicted_combinations
from epicyclic.system.system import System

_LIMIT, _SPEEDS = 30.0, (600.0, 1646.0, 3500.0)


def rows(quick: bool) -> list[table.Row]:
    """Rows of the benchmark's table: what, here, target, whether it is met."""
    try:
        system = bench56()
    except FileNotFoundError as error:
        return [("stability, 56 DOF, 200 speeds", "skipped", "", f"{error}")]
    frequencies = np.linspace(300, 5000, 200)
    ready = parametric_system(system)
    each = [1e3 * _spent(lambda: floquet_scan(ready, frequencies)) / frequencies.size for _ in range(1 if quick else 3)]
    light = parametric_system(system, damping=0.3)
    ahead = _spent(lambda: predicted_combinations(light, frequencies))
    found = floquet_scan(ready, np.array(_SPEEDS))
    largest, whole, spent = [], [], []
    for frequency, mu in zip(_SPEEDS, found.multipliers, strict=True):
        clock = time.process_time()
        reference = np.linalg.eigvals(_monodromy(system, frequency))
        spent.append(time.process_time() - clock)
        largest.append(abs(np.abs(mu).max() - np.abs(reference).max()))
        distance = np.abs(mu[:, None] - reference[None])
        whole.append(float(distance[linear_sum_assignment(distance)].max()))
    took = statistics.median(each)
    listed = ", ".join(f"{frequency:g}" for frequency in _SPEEDS)
    return [
        (
            "stability, 56 DOF, 200 speeds 300..5000 Hz: a speed",
            f"{took:.1f} ms",
            f"<= {_LIMIT:g} ms",
            "met" if took <= _LIMIT else "MISSED",
        ),
        (f"  error of the largest |mu| at {listed} Hz", f"{max(largest):.1e}", "", "DOP853 monodromy as reference"),
        ("  error of all 112 multipliers", f"{max(whole):.1e}", "", f"{min(found.steps)}..{max(found.steps)} steps"),
        ("  the monodromy by DOP853, rtol 1e-9, at each of them", ", ".join(f"{s:.2f}" for s in spent) + " s", "", ""),
        ("  boundaries by averaging, 30 % of the damping", f"{1e3 * ahead:.0f} ms", "", "all speeds"),
    ]


def _spent(run: Callable[[], object]) -> float:
    clock = time.process_time()
    run()
    return time.process_time() - clock


def _monodromy(system: System, frequency: float) -> NDArray[np.float64]:
    n, s = len(system.M), frequency / float(system.tones[0])
    meshes, B = system.meshes, system.meshes.B
    inverse = np.linalg.inv(system.M)
    K, C = system.K + s**2 * system.Kg, system.C + s * system.G
    orders = np.arange(1, meshes.variation.shape[1] + 1)

    def slope(t: float, flat: NDArray[np.float64]) -> NDArray[np.float64]:
        z = flat.reshape(2 * n, -1)
        k = meshes.stiffness * (1 + (meshes.variation @ np.exp(2j * np.pi * frequency * t * orders)).real)
        push = K @ z[:n] + C @ z[n:] + (B * k) @ (B.T @ z[:n])
        return np.concatenate([z[n:], -inverse @ push]).ravel()

    found = solve_ivp(slope, (0, 1 / frequency), np.eye(2 * n).ravel(), method="DOP853", rtol=1e-9, atol=1e-12)
    return np.asarray(found.y[:, -1].reshape(2 * n, 2 * n))


if __name__ == "__main__":
    table.main(rows, __doc__)
