"""Two stages with different mesh frequencies at low speed: combinations near resonance, where D^-1 alone stalls."""

from __future__ import annotations

from typing import Any

import numpy as np

import epicyclic
from epicyclic.questions.response.balance import Batch, solve
from epicyclic.questions.response.response import response
from epicyclic.questions.response.spectra import line_excitation

STAGE = """
[stages.{name}]
planets = 3
module = "{module} mm"
face_width = "{width} mm"
sun = {{ teeth = 24, support.radial = "5e7 N/m" }}
planet = {{ teeth = 30, bore = "{bore} mm", bearing.radial = "{bearing} N/m" }}
ring = {{ teeth = 84, rim = "{rim} mm" }}
carrier = {{ mass = "{mass} kg", inertia = "{inertia} kg m^2", support.radial = "1e9 N/m" }}
"""
LOW = {"module": 6, "width": 80, "bore": 90, "bearing": 8e8, "rim": 35, "mass": 120, "inertia": 3}
HIGH = {"module": 4, "width": 50, "bore": 60, "bearing": 4e8, "rim": 25, "mass": 40, "inertia": 0.5}
TRAIN = """
[couplings.mid]
between = ["low.sun", "high.carrier"]
rz = "1e6 N m/rad"
[operation]
held = ["low.ring", "high.ring"]
speed.high.sun = "1500 rpm"
torque.high.sun = "800 N m"
"""


def test_an_ordinary_train_of_two_stages_converges(tmp_path: Any) -> None:
    path = tmp_path / "two.toml"
    stages = STAGE.format(name="low", **LOW) + STAGE.format(name="high", **HIGH)
    path.write_text('format = 2\ntitle = "Two planetary stages"\ndamping.modal = 0.03\n' + stages + TRAIN)
    ready = response(epicyclic.assemble(epicyclic.load(path)))
    truncation, speed, tolerance = (18, 18, 14), np.array([1.0]), 1e-8
    made = ready.kernel(truncation, shifted=False)
    error, force = line_excitation(ready.system, ready.lines, speed, made.lattice)
    frequency, truncated = ready.frequency(truncation, shifted=False)
    batch = Batch(frequency=frequency, truncated_frequency=truncated, frame=speed, error=error, force=force)
    found = solve(ready.system, ready.modal, made, batch, tolerance=tolerance)
    assert found.residual[0] <= tolerance
    assert found.calls < 300
