"""A body that only the play of its support holds: its stop acts although the mean system has no stiffness there."""

from __future__ import annotations

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ConvergenceError

MODEL = """
format = 2
title = "Sun floats, ring hangs in its play"
damping.modal = 0.04
[stages.main]
planets = 3
module = "4 mm"
face_width = "50 mm"
sun = { teeth = 24, support = { radial = "0 N/m" } }
planet = { teeth = 30, bore = "60 mm", bearing = { radial = "4e8 N/m" } }
ring = { teeth = 84, rim = "25 mm", support = { radial = "2e8 N/m", clearance = "15 um" } }
carrier = { mass = "40 kg", inertia = "0.5 kg m^2" }
[stages.main.meshes]
sun-planet = { stiffness = "5e8 N/m", variation = { cosine = [0.2] } }
planet-ring = { stiffness = "7e8 N/m" }
[operation]
held = ["ring"]
speed.sun = "1500 rpm"
torque.sun = "800 N m"
[deviations]
planet.position.y = "[20, 0, 0] um"
"""
SIDE = {"loads.side": {"on": "ring", "force": {"x": "1 kN"}}}


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("floating") / "floating.toml"
    path.write_text(MODEL)
    return str(path)


@pytest.mark.parametrize("overrides", [{}, SIDE], ids=["at rest", "pushed"])
def test_the_stop_holds_in_time_as_it_does_at_rest(model: str, overrides: dict[str, object]) -> None:
    still = epicyclic.static(model, overrides=overrides, cycles=1, samples=16)
    moving = epicyclic.transient(model, overrides=overrides, cycles=60)
    assert float(moving.mesh_force.max()) == pytest.approx(float(still.mesh_force.max()), rel=0.02)
    assert float(moving.mesh_force.min()) > 0.9 * float(still.mesh_force.min())
    ring = np.abs(moving.displacement.sel(dof="main/ring/x").values).max()
    # 15 um of play, and 1 kN on 2e8 N/m
    assert ring < 21e-6
    if overrides:
        assert ring == pytest.approx(20e-6, rel=0.01)


def test_contact_loss_stays_sane_or_says_that_it_does_not_know(model: str) -> None:
    found = epicyclic.sweep(model, contact_loss=True, start="440 Hz", stop="480 Hz", points=2, unstable="report")
    assert float(found.mesh_force_rms.max()) < 500
    with pytest.raises(ConvergenceError, match="superposed on the laws of links"):
        epicyclic.steady(model, overrides=SIDE, contact_loss=True)
