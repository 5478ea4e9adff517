"""Weight and rotor moment on the carrier of a wind turbine's first stage.

The carrier and the main shaft are one body, held by the main bearing 5 m in front of the planets.  A carrier bearing
behind the planets may be open, closed, or close during the turn.

The table is that of Guo, Keller, LaCava, *Planetary gear load sharing of wind turbine drivetrains subjected to
non-torque loads*, Wind Energy 18 (4), 757-768, 2015, eq. (9), solved for three planets whose carrier bearing is open:

    F_i = T/(3 d_c) + (2/3) [(W - M_y/L_p) cos theta_i - (M_z/L_p) sin theta_i]
    W = g' (m_c L_c/L_p + (m_s/2) L_s/L_p + (3/2) m_p),   g' = g cos^2(5 deg)
    theta_i = angle of the carrier + 2 pi (i - 1)/3

F_i is the tangential force on a planet: of its sun mesh and its ring mesh together.  Frames: theta counts from the x
axis of the file, the torque is positive, the weight acts along +y, (M_y, M_z) are the moments (x, y) of the file.  The
centre of the shaft is at half of L_s.  The equation takes the weight of a planet along its tangent alone; over three
planets that is (3/2) m_p along the weight.  The whole weight reaches the carrier through the pins, see the second test.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.system.system import System

Array = NDArray[np.float64]

WEIGHT = 9.81 * math.cos(math.radians(5.0)) ** 2  # m/s^2, along y
CARRIER, SHAFT, PLANET = 5800.0, 18000.0, 1500.0  # kg
TO_CARRIER, SHAFT_LENGTH, TO_PLANETS = 4.25, 3.22, 5.0  # m from the main bearing
RADIUS, TORQUE = 0.863, 4.18e6  # m, N m
PRESSURE = math.radians(20.0)

# F1, F2, F3 [kN] at carrier angles of 0 and 30 deg by (My, Mz) [MN m]
TABLE = {
    (0.0, 0.0): ([1698.741, 1572.414, 1572.414], [1687.458, 1541.588, 1614.523]),
    (1.0, 0.0): ([1565.408, 1639.080, 1639.080], [1571.988, 1657.058, 1614.523]),
    (-1.0, 0.0): ([1832.075, 1505.747, 1505.747], [1802.928, 1426.118, 1614.523]),
    (0.0, 1.0): ([1698.741, 1456.944, 1687.884], [1620.792, 1474.921, 1747.856]),
}


def weights(planets: float) -> dict[str, Any]:
    """Weight of carrier, shaft and a part of the planets as loads on the carrier, places from the planets [m]."""
    parts = {
        "carrier": (CARRIER, TO_CARRIER),
        "shaft": (SHAFT, SHAFT_LENGTH / 2),
        "planets": (planets * PLANET, TO_PLANETS),
    }
    return {
        name: {"on": "carrier", "force": {"y": mass * WEIGHT}, "at": place - TO_PLANETS}
        for name, (mass, place) in parts.items()
        if mass
    }


def stage(moment: tuple[float, float] = (0.0, 0.0), **changes: Any) -> dict[str, Any]:
    """The stage with weight and a rotor moment [MN m]; a bearing of the carrier behind the planets where given."""
    loads = changes.get("loads", weights(1.5))
    if any(moment):
        loads = loads | {"rotor": {"on": "carrier", "moment": {"x": 1e6 * moment[0], "y": 1e6 * moment[1]}}}
    support = {"main": {"radial": 5e9, "tilt": 0.0, "at": -TO_PLANETS}}
    if "bearing" in changes:
        support["gearbox"] = {"radial": 1e9, "at": BEHIND, **changes["bearing"]}
    mesh = {"variation": "none", "slices": 1}
    return {
        "format": 2,
        "title": "first stage of a wind turbine",
        "damping": {"modal": 0.05},
        "stages": {
            "main": {
                "planets": 3,
                "module": 2 * RADIUS / 60,
                "face_width": 0.5,
                "sun": {"teeth": 24, **changes.get("sun", {})},
                "planet": {"teeth": 36, "mass": PLANET, "inertia": 300.0, "bearing": {"radial": 2e9}},
                "ring": {"teeth": 96, "rim": 0.2},
                "carrier": {"mass": CARRIER, "inertia": 3000.0, "tilt_inertia": 5e4, "support": support},
                "meshes": {
                    "sun-planet": {"stiffness": 6e9, **mesh},
                    "planet-ring": {"stiffness": 7e9, **mesh},
                },
            }
        },
        "operation": {
            "held": ["ring"],
            "speed": {"carrier": 1.2},
            "torque": {"carrier": TORQUE},
            **changes.get("operation", {}),
        },
        "loads": loads,
        "deviations": changes.get("deviations", {}),
    }


BEHIND = 0.6  # m, of the carrier bearing behind the planets


def assembled(*args: Any, **changes: Any) -> System:
    return epicyclic.assemble(epicyclic.load(stage(*args, **changes)))


def pin_forces(system: System) -> Array:
    """Tangential force on every planet at carrier angles of 0, 30, .. deg, (3, 12) [N]."""
    result = epicyclic.static(system, turns=1, of="main/carrier", samples=12)
    pins = np.array([result["link_force"].sel(link_row=f"main/planet/{i}/bearing/y").values for i in (1, 2, 3)])
    mesh = result["mesh_force"].values
    np.testing.assert_allclose((mesh[:3] + mesh[3:]) * math.cos(PRESSURE), pins, rtol=1e-9)
    return pins


def theta() -> Array:
    """Angle of every planet at carrier angles of 0, 30, .. deg, (3, 12) [rad]."""
    angles: Array = np.radians(np.add.outer([0.0, 120.0, 240.0], 30.0 * np.arange(12)))
    return angles


@pytest.mark.parametrize("moment", TABLE)
def test_planet_forces_are_those_of_the_published_equation(moment: tuple[float, float]) -> None:
    forces = pin_forces(assembled(moment))
    np.testing.assert_allclose(forces[:, :2].T / 1e3, TABLE[moment], rtol=1e-6)


def test_the_whole_weight_of_planets_goes_through_their_pins() -> None:
    """By gravity, not as a load: 3 m_p, twice what the equation of the table counts; masses at their own places."""
    loads = weights(0.0)
    loads["carrier"] = {"on": "carrier", "moment": {"x": CARRIER * WEIGHT * (TO_PLANETS - TO_CARRIER)}}
    system = assembled(loads=loads, operation={"gravity": [0.0, WEIGHT, 0.0]})
    lever = CARRIER * TO_CARRIER + SHAFT * SHAFT_LENGTH / 2 + 3 * PLANET * TO_PLANETS
    along = np.cos(theta())
    # on the planet: what its meshes give, and of its own weight the part along the tangent
    meshes = TORQUE / (3 * RADIUS) + 2 / 3 * WEIGHT * lever / TO_PLANETS * along
    result = epicyclic.static(system, turns=1, of="main/carrier", samples=12)
    force = result["mesh_force"].values
    np.testing.assert_allclose((force[:3] + force[3:]) * math.cos(PRESSURE), meshes, rtol=1e-9)
    pins = np.array([result["link_force"].sel(link_row=f"main/planet/{i}/bearing/y").values for i in (1, 2, 3)])
    np.testing.assert_allclose(pins, meshes - PLANET * WEIGHT * along, rtol=1e-9)


def test_a_free_sun_leaves_moment_and_weight_to_the_carrier_bearing() -> None:
    system = assembled((-1.0, 0.3), sun={"support": {"radial": 0.0}}, bearing={})
    forces = pin_forces(system)
    np.testing.assert_allclose(forces, TORQUE / (3 * RADIUS), rtol=1e-9)
    result = epicyclic.static(system, turns=1, of="main/carrier", samples=12)
    bearing = result["link_force"].sel(link_row=[f"main/carrier/support/gearbox/{d}" for d in "xy"]).values
    lever = WEIGHT * (CARRIER * TO_CARRIER + SHAFT * SHAFT_LENGTH / 2 + 1.5 * PLANET * TO_PLANETS)
    expected = math.hypot(lever + 1e6, 0.3e6) / (TO_PLANETS + BEHIND)
    np.testing.assert_allclose(np.hypot(*bearing), expected, rtol=1e-9)
