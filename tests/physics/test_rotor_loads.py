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

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.system.system import System

Array = NDArray[np.float64]
Law = Callable[[float, Array, Array], Array]

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
                "carrier": {"mass": CARRIER, "inertia": 3e3, "tilt_inertia": 5e4, "support": support},
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


# --- a carrier bearing that closes during the turn --------------------------------------------------------------------

MOMENT, PIN_ERROR = (-1.0, 0.3), 150e-6  # MN m; m, pin of planet 1, tangential
CLEARANCES = (0.0, 20e-6, 40e-6, 100e-6)
MAIN, GEARBOX, PIN, SUN_MESH, RING_MESH = 5e9, 1e9, 2e9, 6e9, 7e9  # N/m


def closing(clearance: float, speed: float = 1.2, **sun: float) -> System:
    """The stage whose carrier bearing closes during the turn: the pin error stands in the frame, the loads turn."""
    deviations = {"planet": {"position": {"y": [PIN_ERROR, 0.0, 0.0]}}}
    bearing, operation = {"clearance": clearance}, {"speed": {"carrier": speed}}
    return assembled(MOMENT, bearing=bearing, deviations=deviations, operation=operation, sun=sun)


@dataclass(frozen=True)
class Springs:
    """The same springs written out, in the frame of the carrier: rows (R, 14) of stretches, stiffness, errors.

    Coordinates: carrier x y rx ry rz, then x y rz of every planet; the sun is held, its torque the reaction.
    """

    rows: Array
    stiffness: Array
    error: Array

    @classmethod
    def of_stage(cls) -> Springs:
        planet_radius = RADIUS * 36 / 60
        rows = [row_of([1, 0, 0, -TO_PLANETS, 0]), row_of([0, 1, TO_PLANETS, 0, 0])]
        s, c = math.sin(PRESSURE), math.cos(PRESSURE)
        for planet in range(3):
            psi = 2 * math.pi * planet / 3
            e, t = [math.cos(psi), math.sin(psi)], [-math.sin(psi), math.cos(psi)]
            # carrier less planet along and across the radius of the pin, in the planet's own axes
            rows += [row_of([*e, 0, 0, 0], planet, [-1, 0, 0]), row_of([*t, 0, 0, RADIUS], planet, [0, -1, 0])]
            # teeth approach where the planet goes on, and towards the ring; of the two meshes it turns between
            rows += [row_of([0] * 5, planet, [sign * s, c, sign * planet_radius * c]) for sign in (-1, 1)]
        error = np.zeros(len(rows))
        error[3] = -PIN_ERROR
        return cls(np.array(rows), np.array([MAIN] * 2 + [PIN, PIN, SUN_MESH, RING_MESH] * 3), error)

    def solve(self, clearance: float, turn: Array, law: Law | None = None) -> tuple[Array, Array, Array]:
        """Meshes (6, T), tangential pins (3, T) and the carrier bearing (2, T) in the carrier's frame [N].

        turn : (T,) of the carrier [rad].  All but the bearing is linear: its displacement is u = u0 - C f(u).
        """
        bearing = np.array([row_of([1, 0, 0, BEHIND, 0]), row_of([0, 1, -BEHIND, 0, 0])])
        weighted = self.rows.T * self.stiffness
        lever = WEIGHT * (CARRIER * TO_CARRIER + SHAFT * SHAFT_LENGTH / 2 + 1.5 * PLANET * TO_PLANETS)
        weight = WEIGHT * (CARRIER + SHAFT + 1.5 * PLANET)
        # about the planets' plane; x + i y, turned into the frame of the carrier
        force = 1j * weight * np.exp(-1j * turn)
        moment = (1e6 * MOMENT[0] - lever + TO_PLANETS * weight + 1j * 1e6 * MOMENT[1]) * np.exp(-1j * turn)
        load = np.zeros((14, turn.size))
        load[:5] = force.real, force.imag, moment.real, moment.imag, np.full(turn.size, TORQUE)
        free = np.linalg.solve(weighted @ self.rows, load + (weighted @ self.error)[:, None])
        compliance = np.linalg.solve(weighted @ self.rows, bearing.T)
        pushes = (law or pressed)(clearance, bearing @ compliance, bearing @ free)
        forces = self.stiffness[:, None] * (self.rows @ (free - compliance @ pushes) - self.error[:, None])
        return np.concatenate([forces[4::4], forces[5::4]]), forces[3::4], pushes


def row_of(carrier: list[float], planet: int = 0, moves: list[float] | None = None) -> Array:
    row = np.zeros(14)
    row[:5] = carrier
    row[5 + 3 * planet : 8 + 3 * planet] = moves or 0.0
    return row


def law_at(clearance: float, u: Array) -> tuple[Array, Array]:
    """Force (2,) [N] and tangent (2, 2) [N/m] of k <|u| - c> along u."""
    rho = float(np.hypot(*u))
    if rho <= clearance:
        return np.zeros(2), np.zeros((2, 2))
    along = np.outer(u, u) / rho**2
    tangent: Array = GEARBOX * (along + (1 - clearance / rho) * (np.eye(2) - along))
    return GEARBOX * (1 - clearance / rho) * u, tangent


def pressed(clearance: float, C: Array, u0: Array) -> Array:
    """Force f (2, T) [N] of the bearing where u = u0 - C f(u) (2, T) [m], by Newton's method."""
    forces = np.zeros_like(u0)
    for i, start in enumerate(u0.T):
        u = start.copy()
        for _ in range(60):
            forces[:, i], tangent = law_at(clearance, u)
            step = np.linalg.solve(np.eye(2) + C @ tangent, u + C @ forces[:, i] - start)
            u -= step
            if np.abs(step).max() < 1e-17:
                break
        forces[:, i] = law_at(clearance, u)[0]
    return forces


def tangential(clearance: float, C: Array, u0: Array) -> Array:
    """The same with the tangent at the mean load, whose part that turns is zero."""
    mean = u0.mean(axis=1, keepdims=True)
    force = pressed(clearance, C, mean)
    at = mean - C @ force
    _, tangent = law_at(clearance, at[:, 0])
    u = np.linalg.solve(np.eye(2) + C @ tangent, u0 - C @ (force - tangent @ at))
    forces: Array = force + tangent @ (u - at)
    return forces


def static_forces(clearance: float, samples: int) -> tuple[Array, Array, Array]:
    """The same by `static`."""
    result = epicyclic.static(closing(clearance), turns=1, of="main/carrier", samples=samples)
    pins = [result["link_force"].sel(link_row=f"main/planet/{i}/bearing/y").values for i in (1, 2, 3)]
    if "group" in result.dims:
        bearing = result["group_force"].values[0]
    else:
        rows = [f"main/carrier/support/gearbox/{direction}" for direction in "xy"]
        bearing = np.hypot(*result["link_force"].sel(link_row=rows).values)
    return result["mesh_force"].values, np.array(pins), bearing


@pytest.mark.parametrize("clearance", CLEARANCES)
def test_static_is_the_equilibrium_of_the_springs(clearance: float) -> None:
    turn = 2 * np.pi * np.arange(48) / 48
    mesh, pins, bearing = Springs.of_stage().solve(clearance, turn)
    found = static_forces(clearance, 48)
    size = np.hypot(*bearing)
    assert (size > 0).any()
    if clearance > 30e-6:
        assert (size == 0).any()  # it opens and closes during the turn
    for other, own in zip(found, (mesh, pins, size), strict=True):
        np.testing.assert_allclose(other, own, rtol=1e-8, atol=1e-8 * mesh.max())


def warned(clearance: float, **options: Any) -> list[str]:
    result = epicyclic.steady(closing(clearance), **options)
    return [text for text in json.loads(result.attrs["warnings"]) if "[law-over-turn]" in text]


@pytest.mark.parametrize("clearance", CLEARANCES[1:])
def test_linear_steady_says_what_its_tangent_misses(clearance: float) -> None:
    """Of one turn at all instants that the warning can have seen."""
    (text,) = warned(clearance)
    turn = 2 * np.pi * np.arange(768) / 768
    mesh, _, bearing = Springs.of_stage().solve(clearance, turn)
    linear, _, bearing_linear = Springs.of_stage().solve(clearance, turn, tangential)
    off, size = np.abs(linear - mesh).max(axis=1), np.hypot(*bearing)
    told = re.findall(r"(main\S+) (\S+) kN by the law, (\S+) kN by the tangent, off by up to (\S+) kN", text)
    (planet, *said), (name, *of_bearing) = ((name, *map(float, values)) for name, *values in told)
    place = ["main/sun-planet/1", "main/sun-planet/2", "main/sun-planet/3"].index(planet)
    assert off[place] == pytest.approx(off.max(), rel=1e-3)
    expected = [mesh[place].max(), linear[place].max(), off[place]]
    assert 1e3 * np.array(said) == pytest.approx(np.array(expected), rel=5e-3)
    assert name == "main/carrier/support/gearbox"
    expected = [size.max(), np.hypot(*bearing_linear).max(), np.abs(np.hypot(*bearing_linear) - size).max()]
    assert 1e3 * np.array(of_bearing) == pytest.approx(np.array(expected), rel=5e-3)


def test_linear_steady_is_silent_where_its_tangent_holds() -> None:
    assert not warned(0.0)
    assert not warned(10e-3)  # open all the way round
    assert not warned(40e-6, contact_loss=True)  # the law is asked


def test_linear_sweep_says_it_too() -> None:
    result = epicyclic.sweep(closing(40e-6), relative_speed=np.array([0.5, 1.0]))
    assert sum("[law-over-turn]" in text for text in json.loads(result.attrs["warnings"])) == 1


def is_the_slow_turn(result: xr.Dataset, clearance: float) -> None:
    """Extremes and means of a result with contact loss against those of the springs over a turn, to 1e-4."""
    mesh, pins, bearing = Springs.of_stage().solve(clearance, 2 * np.pi * np.arange(1200) / 1200)
    size, gearbox = np.hypot(*bearing), "main/carrier/support/gearbox"
    near = {"rtol": 1e-4, "atol": 1e-4 * mesh.max()}
    np.testing.assert_allclose(result["mesh_force_minimum"], mesh.min(axis=1), **near)
    rows = [f"main/planet/{i}/bearing/y" for i in (1, 2, 3)]
    np.testing.assert_allclose(result["link_force_peak"].sel(link_row=rows), pins.max(axis=1), **near)
    np.testing.assert_allclose(result["link_force_mean"].sel(link_row=rows), pins.mean(axis=1), **near)
    np.testing.assert_allclose(result["link_force_rms"].sel(link_row=rows), pins.std(axis=1), rtol=1e-4)
    near["atol"] = 1e-4 * size.max()
    assert float(result["bearing_force_peak"].sel(bearing=gearbox)) == pytest.approx(size.max(), rel=2e-4)
    rows = [f"{gearbox}/{direction}" for direction in "xy"]
    np.testing.assert_allclose(result["link_force_rms"].sel(link_row=rows), bearing.std(axis=1), **near)
    # in the housing what turns against the carrier stands still
    turned = (bearing[0] + 1j * bearing[1]) * np.exp(2j * np.pi * np.arange(1200) / 1200)
    steady, swings = abs(turned.mean()), math.sqrt(float((size**2).mean()) - abs(turned.mean()) ** 2)
    assert float(result["bearing_force_mean"].sel(bearing=gearbox)) == pytest.approx(steady, rel=1e-4)
    assert float(result["bearing_force_rms"].sel(bearing=gearbox)) == pytest.approx(swings, rel=1e-4)


@pytest.mark.parametrize("clearance", CLEARANCES)
def test_slow_steady_motion_with_contact_loss_is_the_equilibrium(clearance: float) -> None:
    result = epicyclic.steady(closing(clearance), contact_loss=True, relative_speed=0.02)
    is_the_slow_turn(result, clearance)
    mesh = Springs.of_stage().solve(clearance, 2 * np.pi * np.arange(1200) / 1200)[0]
    np.testing.assert_allclose(result["mesh_force_bound"], mesh.max(axis=1), rtol=1e-4)


def test_so_it_is_where_the_highest_mode_is_far_too_fast_for_multipliers() -> None:
    result = epicyclic.steady(closing(40e-6, inertia=1e-6), contact_loss=True, relative_speed=0.02)
    (text,) = (text for text in json.loads(result.attrs["warnings"]) if "[stability-unknown]" in text)
    assert float(re.findall(r"would take (\S+) steps", text)[0]) > 1e6
    is_the_slow_turn(result, 40e-6)


@pytest.mark.parametrize("clearance", CLEARANCES)
def test_a_slow_turn_in_time_is_the_equilibrium(clearance: float) -> None:
    speed = 0.8  # rad/s
    result = epicyclic.transient(closing(clearance, speed), cycles=96, samples=4)
    mesh, pins, bearing = Springs.of_stage().solve(clearance, speed * result["time"].values)
    near = {"rtol": 0.0, "atol": 1e-4 * mesh.max()}
    np.testing.assert_allclose(result["mesh_force"], mesh, **near)
    rows = [f"main/planet/{i}/bearing/y" for i in (1, 2, 3)]
    np.testing.assert_allclose(result["link_force"].sel(link_row=rows), pins, **near)
    if clearance:
        force = result["group_force"].values[0]
    else:
        rows = [f"main/carrier/support/gearbox/{direction}" for direction in "xy"]
        force = np.hypot(*result["link_force"].sel(link_row=rows).values)
    np.testing.assert_allclose(force, np.hypot(*bearing), **near)


def test_a_sweep_with_contact_loss_has_the_same_links() -> None:
    """One shaft tone of fewer orders: to what its warning says, here 1 %."""
    swept = epicyclic.sweep(closing(100e-6), contact_loss=True, relative_speed=np.array([0.02]))
    slow = epicyclic.steady(closing(100e-6), contact_loss=True, relative_speed=0.02)
    for name in ("link_force_peak", "link_force_rms", "link_force_mean", "bearing_force_peak", "bearing_force_mean"):
        size = float(slow[name].max())
        assert swept[name].dims == ("direction", *slow[name].dims, "speed")
        for direction in ("up", "down"):
            found = swept[name].sel(direction=direction).isel(speed=0)
            np.testing.assert_allclose(found, slow[name], rtol=1e-2, atol=2e-3 * size, err_msg=name)
