"""Speeds at which the mean system is unstable: against eigenvalues written out, and over trains of several stages."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import epicyclic
from epicyclic.errors import ConvergenceError
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.response import critical_speed, response, unstable_speeds
from epicyclic.questions.response.steady import steady, sweep
from epicyclic.system.system import System

SPEEDS = np.linspace(0.5, 14.0, 28)


def growth(case: Any, system: System, speed: float) -> float:
    """Largest real part of the eigenvalues of the mean system at a speed [1/s], free rotation left out."""
    n, B = len(system.M), system.meshes.B
    K = system.mean_stiffness + speed**2 * system.Kg + speed * system.Cskew
    C = case.damping(system) + (B * system.meshes.damping) @ B.T + speed * system.G
    inverse = np.linalg.inv(system.M)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ C]])
    return float(np.max(np.linalg.eigvals(state).real))


@pytest.mark.parametrize("drag", [0.0, 1.0, 40.0])
def test_where_a_vibration_of_the_mean_system_grows(case: Any, drag: float) -> None:
    """Dampers that turn drive the whirl above the critical speed; dampers to the housing hold it for a while."""
    pair: System = case.pair(free=False)
    housing = np.diag([1.0, 1.0, 0.0, 1.0, 1.0, 0.0])
    turn = np.kron(np.eye(2), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    system = replace(pair, C=pair.C + 100 * drag * housing, Cskew=100 * 100 * drag * turn)
    ready = response(system)
    expected = np.array([growth(case, system, speed) > 1e-3 for speed in SPEEDS])
    np.testing.assert_array_equal(unstable_speeds(ready, SPEEDS), expected & (SPEEDS >= critical_speed(ready)[0]))
    assert expected.any()
    assert not expected[SPEEDS < critical_speed(ready)[0]].any()


def test_the_critical_speed_is_where_the_stiffness_is_singular(case: Any) -> None:
    system = case.pair(free=False)
    values = scipy.linalg.eigh(-system.Kg, system.mean_stiffness, eigvals_only=True)
    speed, name = critical_speed(response(system))
    assert speed == pytest.approx(1 / np.sqrt(values[-1]), rel=1e-9)
    assert name in system.dofs.names
    assert critical_speed(response(case.pair(turning=0.0))) == (np.inf, "")


def test_an_unstable_speed_holds_nan_and_a_warning_says_from_where_on(case: Any) -> None:
    system = case.pair(free=False)
    critical = critical_speed(response(system))[0]
    found = sweep(system, SweepOptions(relative_speed=[0.5 * critical, 1.1 * critical], shaft_orders=False))
    assert list(found.status.values) == ["ok", "mean system unstable"]
    assert np.isnan(found.mesh_force_mean.values[:, 1]).all()
    assert np.isfinite(found.mesh_force_mean.values[:, 0]).all()
    assert f"above {critical * 137:.6g} Hz the centripetal terms exceed" in str(found.attrs["warnings"])
    with pytest.raises(ConvergenceError, match="the mean system is unstable"):
        steady(system, SteadyOptions(relative_speed=1.1 * critical))
    still = sweep(system, SweepOptions(relative_speed=[1.1 * critical], shaft_orders=False, frame_speed="operating"))
    assert list(still.status.values) == ["ok"]


def two_stages(module: float, sun: str, coupling: str) -> str:
    """A planetary stage that drives the carrier of a second, the modules as 3 to 2."""
    stage = """
[stages.{name}]
planets = 3
module = "{module} mm"
face_width = "{width} mm"
sun = {{ teeth = 24, support.radial = "{sun}" }}
planet = {{ teeth = 30, bore = "{bore} mm", bearing.radial = "5e8 N/m" }}
ring = {{ teeth = 84, rim = "30 mm" }}
carrier = {{ mass = "80 kg", inertia = "1 kg m^2", support.radial = "1e9 N/m" }}
"""
    stages = "".join(
        stage.format(name=name, module=m, width=13 * m, bore=15 * m, sun=sun)
        for name, m in (("low", module), ("high", module / 1.5))
    )
    return f"""
format = 2
title = "Two planetary stages in series"
damping.modal = 0.03
{stages}
[couplings.mid]
between = ["low.sun", "high.carrier"]
rz = "{coupling}"
[operation]
held = ["low.ring", "high.ring"]
speed.high.sun = "1500 rpm"
torque.high.sun = "800 N m"
[deviations]
low.planet.position.y = "[20, 0, 0] um"
"""


@pytest.mark.parametrize(
    ("module", "sun", "coupling"), [(6.0, "1e7 N/m", "1e6 N m/rad"), (4.5, "3e7 N/m", "3e5 N m/rad")]
)
def test_mean_forces_of_a_stage_add_up_to_its_torque_over_the_whole_range(
    tmp_path: Any, module: float, sun: str, coupling: str
) -> None:
    """The mean of the three meshes together is fixed by power flow wherever there is a steady motion.

    Shares of them go to a pole at the critical speed: the residual is a part of these.
    """
    path = tmp_path / "two.toml"
    path.write_text(two_stages(module, sun, coupling))
    system = epicyclic.assemble(epicyclic.load(path))
    ready = response(system)
    critical = critical_speed(ready)[0]
    speeds = np.array([0.3 * critical, 0.97 * critical, 1.03 * critical])
    found = sweep(system, SweepOptions(relative_speed=speeds, shaft_orders=False))
    assert list(found.status.values) == ["ok", "ok", "mean system unstable"]
    for pair in ("low/sun-planet", "low/planet-ring", "high/sun-planet", "high/planet-ring"):
        rows = [name.startswith(pair) for name in found.mesh.values]
        total = found.mesh_force_mean.values[rows][:, :2].sum(axis=0)
        np.testing.assert_allclose(total[1], total[0], rtol=1e-6)
