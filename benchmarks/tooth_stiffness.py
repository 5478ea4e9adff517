"""What tooth compliance and energy stiffness take, and how far they are from finer quadrature."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
import table

from epicyclic.teeth import geometry
from epicyclic.teeth.compliance import face_coupling, tooth_compliance
from epicyclic.teeth.form import GearForm
from epicyclic.teeth.gear_pair import MeshedTeeth, energy_series, section_stiffness

REPEATS = 9


def rows(quick: bool) -> list[table.Row]:
    """Rows of the table; CPU medians of one thread.  quick : fewer repeats."""
    repeats = 3 if quick else REPEATS
    forms = [GearForm(teeth=z, module=4e-3, pressure_angle=math.radians(20), bore=z * 1e-3) for z in (25, 40)]
    base = [geometry.base_radius(form.teeth, 4e-3, math.radians(20), 0.0) for form in forms]
    limits = geometry.contact_limits(
        base[0],
        forms[0].tip,
        base[1],
        forms[1].tip,
        working_pressure_angle=math.radians(20),
        base_pitch=geometry.base_pitch(4e-3, math.radians(20), 0.0),
    )
    a, b = (tooth_compliance(form) for form in forms)
    mesh = MeshedTeeth(a=a, b=b, working_angle=math.radians(20), limits=limits)
    mean = energy_series(mesh, 2e5)[0]
    even = section_stiffness(mesh, (np.arange(200_000) + 0.5) / 200_000, 2e5).mean()
    zeta = np.linspace(-0.5, 0.5, 41)[:-1] + 0.0125
    took = {
        "compliance of one gear's teeth, body and neighbours": _median(lambda: tooth_compliance(forms[0]), repeats),
        "energy stiffness of a pair, mean and 12 harmonics": _median(lambda: energy_series(mesh, 2e5), repeats),
        "coupling of 40 slices": _median(lambda: face_coupling(zeta, 1.0, 0.1, np.full(40, 0.025)), repeats),
    }
    found = [(name, f"{1e3 * seconds:.2f} ms", "", "") for name, seconds in took.items()]
    return [*found, ("energy stiffness, mean against 200 000 places", f"{abs(mean / even - 1):.0e}", "", "")]


def _median(work: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


if __name__ == "__main__":
    table.main(rows, __doc__)
