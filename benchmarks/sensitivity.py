"""What derivatives of mesh forces cost beside the solution itself, and how exact they are.

    python benchmarks/sensitivity.py [--quick]

CPU seconds of one thread, medians of runs in this process; errors against five-point differences.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import table
from known import bench56
from numpy.typing import NDArray
from timing import cpu_seconds

from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.steady import sweep
from epicyclic.questions.studies.adjoint import SystemNumbers, adjoint_form, adjoint_parts, combined, measure, numbers
from epicyclic.questions.studies.gradient import Gradient, basis_of, force_derivatives, gradient
from epicyclic.system.system import System

TOLERANCE = 1e-8


def rows(quick: bool) -> list[table.Row]:
    """The rows of the table."""
    try:
        system = bench56()
    except FileNotFoundError as error:
        return [("derivatives of mesh forces, 56 DOF", "skipped", "", f"{error}")]
    found: list[table.Row] = []
    for hertz in ([1646.0], list(np.linspace(300, 5000, 10 if quick else 40))):
        found += _cost(system, np.array(hertz) / float(system.tones[0]))
    off = _error(system, 0.93)
    label = "  all 16 RMS by all 16 stiffnesses at 930 Hz, largest error"
    found.append(table.judged(label, f"{off:.1e}", "<= 1e-07", off <= 1e-7))
    return [*found, *_drawing()]


def _cost(system: System, speed: NDArray[np.float64]) -> list[table.Row]:
    """Solutions, then with the derivatives of one mesh, then of all."""
    repeats = 15 if speed.size == 1 else 3

    def alone() -> object:
        return list(respond(response(system), speed, tolerance=TOLERANCE))

    def by_all(meshes: NDArray[np.int64]) -> Callable[[], object]:
        return lambda: _gradients(system, speed, meshes)

    every_mesh = np.arange(len(system.meshes.name))

    runs = (alone, by_all(every_mesh[:1]), by_all(every_mesh))
    once, first, every = (cpu_seconds(run, repeats=repeats)[0] for run in runs)
    many = f"{speed.size} speeds" if speed.size > 1 else "one speed"
    return [
        (f"56 DOF, {many}: solution alone", f"{1e3 * once:.1f} ms", "", f"{1e3 * once / speed.size:.2f} ms a speed"),
        (
            "  one mesh RMS by all stiffnesses, dampers, masses, errors, speed",
            f"+{100 * (first / once - 1):.0f} %",
            "<= 100 %" if speed.size == 1 else "",
            ("met" if first <= 2 * once else "MISSED") if speed.size == 1 else "",
        ),
        (
            "  all 16 mesh RMS by all of them",
            f"+{100 * (every / once - 1):.0f} %",
            "",
            f"+{100 * (every / once - 1) / 16:.0f} % a mesh; differences by 16 stiffnesses: +{100 * 32:.0f} %",
        ),
    ]


def _gradients(system: System, speed: NDArray[np.float64], meshes: NDArray[np.int64]) -> list[Gradient]:
    """RMS of the meshes, derived by every number of the System at once."""
    ready = response(system)
    basis, adjoint_modal = basis_of(ready), adjoint_form(ready.modal)
    return [
        gradient(ready, basis, block, parts)
        for block in respond(ready, speed, tolerance=TOLERANCE)
        for _, parts in adjoint_parts(
            ready, adjoint_modal, block, measure(ready, block, harmonic=None), meshes=meshes, tolerance=100 * TOLERANCE
        )
    ]


def _stiffness_changes(system: System) -> list[SystemNumbers]:
    """One change for each mesh: its mean stiffness by 1 N/m; the variation is a share of it and follows."""
    blank = combined([0.0], [numbers(system)])
    return [blank._replace(stiffness=row) for row in np.eye(len(system.meshes.name))]


def _error(system: System, speed: float) -> float:
    """Largest difference to five-point differences, per the largest derivative."""
    found = force_derivatives(system, _stiffness_changes(system), relative_speed=[speed], tolerance=1e-10).derivative
    meshes, h = system.meshes, 1e-4
    worst = 0.0
    for j in range(len(meshes.name)):

        def rms(share: float, j: int = j) -> NDArray[np.float64]:
            stiffness = meshes.stiffness.copy()
            stiffness[j] *= 1 + share
            moved = replace(system, meshes=replace(meshes, stiffness=stiffness))
            return np.asarray(
                sweep(moved, SweepOptions(relative_speed=[speed], tolerance=1e-11)).mesh_force_rms.values[:, 0]
            )

        wanted = (8 * (rms(h) - rms(-h)) - (rms(2 * h) - rms(-2 * h))) / (12 * h * meshes.stiffness[j])
        worst = max(worst, float(np.abs(found[j, :, 0] - wanted).max()))
    return worst / float(np.abs(found).max())


def _drawing() -> list[table.Row]:
    """All numbers of a model file at once."""
    import epicyclic

    train = epicyclic.load("ren2021")
    both = []
    for of in ("frequency", "force"):
        took, _ = cpu_seconds(partial(epicyclic.sensitivity, train, of=of), repeats=3)
        count = epicyclic.sensitivity(train, of=of).sizes["path"]
        both.append((f"ren2021: {of} by every number of the file ({count} paths)", f"{took:.2f} s", "", ""))
    return both


if __name__ == "__main__":
    table.main(rows, __doc__)
