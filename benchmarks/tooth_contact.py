"""Tooth contact beside plain `scipy.optimize.nnls` per phase: times, force and contact residuals, one process.

    python benchmarks/tooth_contact.py [--quick]

One helical pair (21/37, module 5 mm, 20 deg, crowned, relieved, misaligned), 50 phases, 40 pieces at most in a phase.
nnls solves min |L' p + L^-1 g|^2 with a heavy row for the sum of the forces, C = L L', and knows no Hertz.
"""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
import table
from numpy.typing import NDArray
from scipy.optimize import nnls

from epicyclic.teeth import contact_solver, geometry
from epicyclic.teeth.compliance import tooth_compliance
from epicyclic.teeth.form import Flank, GearForm, Relief
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import loaded_contact, loaded_segments
from epicyclic.teeth.path_of_contact import PlaneOfAction
from epicyclic.teeth.segments import ContactSegments, contact_segments

__all__ = ["rows"]

Array = NDArray[np.float64]
PHASES = np.arange(50) / 50
FORCE = 20e3
LOADS = np.linspace(1e3, FORCE, 20)
_KKT, _SUM = 1e-12, 1e-9


def pair(**more: float) -> ContactPair:
    """The pair that is measured."""
    module, alpha, beta, width = 5e-3, math.radians(20), math.radians(20), 30e-3
    forms = [
        GearForm(teeth=z, module=module, pressure_angle=alpha, helix_angle=beta, bore=0.2 * z * module)
        for z in (21, 37)
    ]
    base = [geometry.base_radius(form.teeth, module, alpha, beta) for form in forms]
    pitch, angle = geometry.base_pitch(module, alpha, beta), geometry.transverse_pressure_angle(alpha, beta)
    limits = geometry.contact_limits(
        base[0], forms[0].tip, base[1], forms[1].tip, working_pressure_angle=angle, base_pitch=pitch
    )
    plane = PlaneOfAction(
        base_a=base[0],
        base_b=base[1],
        pressure_angle=angle,
        base_helix=geometry.base_helix_angle(alpha, beta),
        base_pitch=pitch,
        limits=limits,
        lean=1,
        face_a=(-width / 2, width / 2),
        face_b=(-width / 2, width / 2),
    )
    return ContactPair(
        plane=plane,
        tooth_a=tooth_compliance(forms[0]),
        tooth_b=tooth_compliance(forms[1]),
        teeth=(21, 37),
        flank_a=Flank(crown=10e-6),
        flank_b=Flank(tip_relief=Relief(amount=15e-6, length=1.5e-3)),
        misalignment=2e-4,
        slices=22,
        **more,  # type: ignore[arg-type]
    )


def rows(quick: bool) -> list[table.Row]:
    """Times, residuals, targets.  quick : fewer repeats."""
    times = 3 if quick else 9
    gear_pair, linear = contact_segments(pair(), PHASES), contact_segments(pair(linear_at=5e5), PHASES)
    size = f"50 phases x {linear.valid.sum(axis=1).max()} pieces"
    load = np.full(50, FORCE)
    given = linear.compliance, linear.gap, linear.valid
    found = {
        f"nnls with a heavy row, linear, {size}": (lambda: _nnls(linear), math.inf),
        "active sets, numpy, linear": (lambda: _of(contact_solver.solve_linear(*given, load)), 3e-3),
        "Newton, numpy, Hertz": (
            lambda: _of(
                contact_solver.solve_hertzian(
                    gear_pair.compliance,
                    gear_pair.gap,
                    gear_pair.valid,
                    load,
                    gear_pair.law,
                    inverse=lambda force: gear_pair.own_approach(force, np.arange(len(force))),
                )
            ),
            25e-3,
        ),
    }
    table = [
        _row(name, run, limit, gear_pair if "Hertz" in name else linear, times) for name, (run, limit) in found.items()
    ]
    return [*table, *_table(times)]


def _of(found: contact_solver.ContactSolution) -> tuple[Array, Array]:
    return found.force, found.approach


def _row(
    name: str, run: Callable[[], tuple[Array, Array]], limit: float, pieces: ContactSegments, times: int
) -> table.Row:
    took = _median(run, times)
    force, approach = run()
    own = _own(pieces, force, approach) if pieces.line is not None else None
    checked = contact_solver.with_residuals(
        pieces.compliance, pieces.gap, pieces.valid, np.full(50, FORCE), force, approach, own=own
    )
    short = float(np.abs(force.sum(axis=1) / FORCE - 1).max())
    residual = float(checked.residual.max())
    here = f"{1e3 * took:.2f} ms, contact {residual:.0e}, force {short:.0e}"
    if "nnls" in name:
        return name, here, "", "baseline"
    good = took <= limit and residual <= _KKT and short <= _SUM and not any(checked.status)
    target = f"{1e3 * limit:g} ms, 1e-12, 1e-9" if math.isfinite(limit) else "1e-12, 1e-9"
    return name, here, target, "ok" if good else "MISSED"


def _own(pieces: ContactSegments, force: Array, approach: Array) -> Array:
    """Own approach that the Hertz law has at the forces found."""
    from epicyclic.teeth import gear_pair

    bears = np.asarray(gear_pair.approach(pieces.contact, force / pieces.length))
    level = approach[:, None] - pieces.gap - np.matmul(pieces.compliance, force[:, :, None])[:, :, 0]
    return np.where(force > 0, bears, np.minimum(level, 0.0))


def _nnls(pieces: ContactSegments) -> tuple[Array, Array]:
    force, approach = np.zeros(pieces.gap.shape), np.zeros(50)
    for t in range(50):
        have = pieces.valid[t]
        C, g = pieces.compliance[t][np.ix_(have, have)], pieces.gap[t, have]
        lower = np.linalg.cholesky(C)
        heavy = 1e4 * float(np.abs(lower).max())
        matrix = np.vstack([lower.T, np.full(int(have.sum()), heavy)])
        force[t, have], _ = nnls(matrix, np.append(-np.linalg.solve(lower, g), heavy * FORCE))
        on = force[t, have] > 0
        approach[t] = float((C @ force[t, have] + g)[on].mean())
    return force, approach


def _table(times: int) -> list[table.Row]:
    """Mesh stiffness over 20 loads and 50 phases, from the drawing on, without numba."""
    found = []
    for name, one in (("Hertz", pair()), ("linear", pair(linear_at=5e5))):
        took = _median(lambda one=one: loaded_contact(one, LOADS, PHASES), max(3, times // 3))  # type: ignore[misc]
        worst = float(loaded_segments(contact_segments(one, PHASES), LOADS).residual.max())
        good = took <= 0.5 and worst <= _KKT
        what = f"stiffness table, 20 loads x 50 phases, {name}, numpy"
        found.append((what, f"{1e3 * took:.0f} ms, contact {worst:.0e}", "500 ms, 1e-12", "ok" if good else "MISSED"))
    return found


def _median(run: Callable[[], object], times: int) -> float:
    run()
    took = []
    for _ in range(times):
        start = time.process_time()
        run()
        took.append(time.process_time() - start)
    return statistics.median(took)


if __name__ == "__main__":
    table.main(rows, __doc__)
