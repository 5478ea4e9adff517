"""All contacts of a bearing: load zones of tables, equilibrium against energies written apart, another program."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize
from tests.unit.bearings.bearing_examples import ALL, ANGULAR, CYLINDRICAL, DEEP_GROOVE, DOUBLE, SPHERICAL, TAPERED

from epicyclic.bearings.rolling_bearing import (
    RollingBearing,
    contact_set,
    displacement,
    element_law,
    load_zone,
    race_contact,
    radial_curve,
    roller_profile,
)
from epicyclic.errors import ConvergenceError

Array = NDArray[np.float64]
EACH = pytest.mark.parametrize("bearing", ALL.values(), ids=ALL.keys())


# load zone -----------------------------------------------------------------------------------------------------------

POINT = {  # extent -> J_r, J_a [harris2001]
    0.2: (0.1590, 0.1707),
    0.5: (0.2288, 0.2782),
    0.7: (0.2505, 0.3374),
    1.0: (0.2546, 0.4244),
    5 / 3: (0.1871, 0.6060),
    5.0: (0.0711, 0.8558),
}
LINE = {0.5: (0.2448, 0.3080), 0.7: (0.2632, 0.3753), 1.0: (0.2525, 0.4798)}


@pytest.mark.parametrize(
    ("bearing", "extent", "integrals"),
    [*((ANGULAR, *one) for one in POINT.items()), *((TAPERED, *one) for one in LINE.items())],
    ids=lambda value: f"{value:.2f}" if isinstance(value, float) else "",
)
def test_load_zone_integrals_are_those_of_the_table(
    bearing: RollingBearing, extent: float, integrals: tuple[float, float]
) -> None:
    """Contact lines that do not turn, and rollers without a profile, as the table has it."""
    contacts = contact_set(bearing, places=3000, laminae=1)
    contacts = replace(contacts, bend=0.0, gap=np.zeros_like(contacts.gap))
    cos, sin = math.cos(bearing.contact_angle), math.sin(bearing.contact_angle)
    most = 10e-6
    radial = most / (2 * extent)
    q = np.array([radial / cos, 0, (most - radial) / sin, 0, 0])
    stiffness, exponent = element_law(bearing)
    whole = bearing.elements * stiffness * most**exponent
    force = contacts.force(q)
    assert force[0] / (whole * cos) == pytest.approx(integrals[0], abs=1e-4)
    assert force[2] / (whole * sin) == pytest.approx(integrals[1], abs=1e-4)
    assert abs(force[1]) < 1e-9 * whole


@pytest.mark.parametrize(("bearing", "share"), [(DEEP_GROOVE, 4.37), (CYLINDRICAL, 4.08)], ids=["ball", "roller"])
def test_most_loaded_element_without_clearance(bearing: RollingBearing, share: float) -> None:
    """Q = 4.37 F/Z of balls, 4.08 F/Z of rollers, for their profile nearly: 1/J_r at half the circumference."""
    load = 5e3 if bearing.is_ball else 9e4
    zone = load_zone(bearing, displacement(bearing, [0.0, load, 0.0]))
    assert zone.angle[0] == pytest.approx(math.pi / 2)
    assert zone.most == (0, 0)
    assert zone.load[zone.most] * bearing.elements / load == pytest.approx(share, rel=2e-3 if bearing.is_ball else 0.03)
    assert zone.extent == pytest.approx(0.5, abs=2e-3)
    assert zone.lamina_load.sum(axis=2) == pytest.approx(zone.load)


def test_extent_says_how_much_of_the_diameter_bears() -> None:
    loose, tight = (replace(CYLINDRICAL, clearance=play) for play in (40e-6, -20e-6))
    for bearing in (loose, tight):
        q = displacement(bearing, [20e3])
        slack = bearing.clearance / 2
        assert load_zone(bearing, q, laminae=1).extent == pytest.approx((q[0] - slack) / (2 * q[0]), rel=1e-9)
    assert (load_zone(tight, displacement(tight, [1e3])).load > 0).all()
    assert math.isinf(load_zone(ANGULAR, displacement(ANGULAR, [0, 0, 1e3])).extent)


def test_pressures_by_hand() -> None:
    zone = load_zone(DEEP_GROOVE, displacement(DEEP_GROOVE, [2e3]))
    contact, load = race_contact(DEEP_GROOVE, "inner"), zone.load.max()
    area = math.pi * contact.long * contact.short * load ** (2 / 3)
    assert zone.pressure == pytest.approx(1.5 * load / area, rel=1e-12)
    zone = load_zone(CYLINDRICAL, displacement(CYLINDRICAL, [20e3, 0, 0, 0, 50.0]))
    line = zone.lamina_load[zone.most].max() / (14e-3 / 30)
    radius = 1 / (2 / 15e-3 + 2 / 85e-3)
    width = math.sqrt(4 * line * radius * 2 * (1 - 0.3**2) / 2.07e11 / math.pi)
    assert zone.pressure == pytest.approx(2 * line / (math.pi * width), rel=1e-12)


# the law of five rows ------------------------------------------------------------------------------------------------


def motions(count: int = 12) -> Array:
    return np.random.default_rng(3).normal(size=(count, 5)) * [2e-5, 2e-5, 2e-5, 4e-4, 4e-4]


@EACH
def test_force_is_the_gradient_and_tangent_the_second_derivative(bearing: RollingBearing) -> None:
    contacts, q = contact_set(bearing, places=40, laminae=6), motions()
    for i, step in enumerate([1e-9, 1e-9, 1e-9, 2e-8, 2e-8]):
        e = step * np.eye(5)[i]
        slope = (contacts.energy(q + e) - contacts.energy(q - e)) / (2 * step)
        assert slope == pytest.approx(contacts.force(q)[:, i], rel=1e-5, abs=1e-4)
        turn = (contacts.force(q + e) - contacts.force(q - e)) / (2 * step)
        tangent = contacts.tangent(q)
        assert np.abs(turn - tangent[:, :, i]).max() <= 2e-4 * np.abs(tangent[:, :, i]).max()


@EACH
def test_the_energy_is_convex(bearing: RollingBearing) -> None:
    contacts, q, other = contact_set(replace(bearing, clearance=1e-5), places=40, laminae=6), motions(), motions()[::-1]
    size = np.array([1, 1, 1, 20.0, 20.0])
    tangent = contacts.tangent(q) * size[:, None] * size
    assert tangent == pytest.approx(np.swapaxes(tangent, 1, 2), rel=1e-12, abs=1e-3)
    assert (np.linalg.eigvalsh(tangent)[:, 0] > -1e-10 * np.abs(tangent).max()).all()
    middle = contacts.energy((q + other) / 2)
    assert (middle <= (contacts.energy(q) + contacts.energy(other)) / 2 * (1 + 1e-12)).all()


def test_a_spherical_roller_bearing_does_not_resist_tilt() -> None:
    contacts = contact_set(SPHERICAL)
    q = np.array([20e-6, 5e-6, 3e-6, 0, 0])
    force = contacts.force(q)
    assert force[0] > 1e4
    assert np.abs(force[3:]).max() < 1e-9 * force[0]
    assert contacts.force([*q[:3], 1e-3, -2e-3]) == pytest.approx(force, rel=1e-9, abs=1e-6)


def test_rows_that_meet_outside_resist_tilt_more() -> None:
    stiff = [contact_set(replace(DOUBLE, arrangement=one, preload=10e-6)).tangent(np.zeros(5)) for one in ("O", "X")]
    assert stiff[0][3, 3] > 3 * stiff[1][3, 3]
    assert stiff[0][:3, :3] == pytest.approx(stiff[1][:3, :3], rel=0.02, abs=1.0)


def test_bearing_is_alike_in_all_directions_of_its_plane() -> None:
    contacts = contact_set(DOUBLE)
    turn = 0.83
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.zeros((5, 5))
    rotation[:2, :2] = rotation[3:, 3:] = [[c, -s], [s, c]]
    rotation[2, 2] = 1
    for q in motions(4):
        assert contacts.force(rotation @ q) == pytest.approx(rotation @ contacts.force(q), rel=1e-4, abs=1e-2)


def test_one_row_carries_the_side_that_its_contact_angle_says() -> None:
    for sign in (1, -1):
        bearing = replace(ANGULAR, contact_angle=sign * ANGULAR.contact_angle)
        assert displacement(bearing, [0, 0, sign * 1e3])[2] * sign > 0
        with pytest.raises(ConvergenceError, match="does not carry"):
            displacement(bearing, [0, 0, -sign * 1e3])
        # without axial force the balls run down their groove, to a contact angle of 0
        low = displacement(bearing, [1e3, 0, 0])
        depth = bearing.groove_distance * math.sin(ANGULAR.contact_angle)
        assert low[2] == pytest.approx(-sign * depth, rel=0.01)


# radial law ----------------------------------------------------------------------------------------------------------


@EACH
@pytest.mark.parametrize("clearance", [0.0, 15e-6, -6e-6])
def test_radial_curve_is_the_law_without_tilt_and_axial_motion(bearing: RollingBearing, clearance: float) -> None:
    bearing = replace(bearing, clearance=clearance)
    deflection, force, slope = radial_curve(bearing, 4e3)
    fine = contact_set(bearing, places=2880)
    q = deflection[:, None] * np.eye(5)[0]
    assert force == pytest.approx(fine.force(q)[:, 0], rel=1e-4, abs=1e-5 * 4e3)
    assert force[-1] == pytest.approx(4 * 4e3, rel=1e-9)
    assert (np.diff(deflection) > 0).all()
    assert (np.diff(force) >= 0).all()
    assert force[0] == pytest.approx(0, abs=1e-6)
    # slopes fit the forces: the trapezoidal rule over the fine half of the table
    half = slice(20, None)
    whole = np.cumsum(np.diff(deflection[half]) * (slope[half][1:] + slope[half][:-1]) / 2)
    assert whole == pytest.approx(np.diff(force[half]).cumsum(), rel=1e-2)


def test_play_is_half_the_clearance_and_has_no_force() -> None:
    for bearing in (DEEP_GROOVE, CYLINDRICAL, TAPERED, DOUBLE):
        deflection, force, _ = radial_curve(replace(bearing, clearance=30e-6), 2e3)
        assert deflection[:2] == pytest.approx([0, 15e-6], rel=0.02)
        assert force[:2] == pytest.approx([0, 0], abs=1e-9)
        assert force[2] > 0
    assert radial_curve(DEEP_GROOVE, 2e3)[0][1] > 0


# equilibrium ---------------------------------------------------------------------------------------------------------


def point(bearing: RollingBearing, angle: float, radius: float, z: float) -> Array:
    return np.array([radius * math.cos(angle), radius * math.sin(angle), z])


def roller_energy(bearing: RollingBearing, q: Array, count: int, laminae: int) -> float:
    """Of a cylindrical roller bearing: every lamina by itself, by the motion of its point of the race."""
    total, length = 0.0, bearing.element_length
    for j in range(count):
        angle = 2 * math.pi * j / count
        outward = point(bearing, angle, 1.0, 0.0)
        for k in range(laminae):
            x = -length / 2 + (k + 0.5) * length / laminae
            moved = q[:3] + np.cross([q[3], q[4], 0.0], point(bearing, angle, bearing.pitch_diameter / 2, x))
            pressed = float(moved @ outward) - bearing.clearance / 2
            pressed -= 2 * 0.00035 * bearing.element_diameter * math.log(1 / (1 - (2 * x / length) ** 2))
            total += 35_948e6 * length ** (8 / 9) / laminae * max(pressed, 0.0) ** (19 / 9) * 9 / 19
    return total


def ball_energy(bearing: RollingBearing, q: Array, count: int) -> float:
    """Of angular contact ball bearings: distance of the centres of the two grooves of every ball."""
    total, size = 0.0, bearing.element_diameter
    stiffness = sum(race_contact(bearing, race).stiffness ** (-2 / 3) for race in ("inner", "outer")) ** -1.5
    for side in (-1, 1):
        z, alpha = side * bearing.row_distance / 2, -side * bearing.contact_angle
        for j in range(count):
            angle = 2 * math.pi * j / count
            outward = point(bearing, angle, math.cos(alpha), math.sin(alpha))
            ball = point(bearing, angle, bearing.pitch_diameter / 2, z)
            inner = ball + (bearing.groove[0] - 0.5) * size * outward
            outer = ball - (bearing.groove[1] - 0.5) * size * outward
            apart = inner + q[:3] + np.cross([q[3], q[4], 0.0], inner) - outer
            plane = (apart @ point(bearing, angle, 1.0, 0.0), apart[2])
            pressed = math.hypot(*plane) - (sum(bearing.groove) - 1) * size
            pressed += bearing.preload * math.sin(bearing.contact_angle)
            total += stiffness * max(pressed, 0.0) ** 2.5 / 2.5
    return total


@pytest.mark.parametrize(
    ("bearing", "force", "energy"),
    [
        (
            replace(CYLINDRICAL, clearance=20e-6),
            [9e3, -4e3, 0.0, 20.0, 35.0],
            lambda bearing, q: roller_energy(bearing, q, 17, 8),
        ),
        (replace(DOUBLE, preload=6e-6), [3e3, 1e3, 2e3, -30.0, 25.0], lambda bearing, q: ball_energy(bearing, q, 14)),
    ],
    ids=["rollers", "balls"],
)
def test_equilibrium_has_the_least_energy(bearing: RollingBearing, force: list[float], energy: Any) -> None:
    size = np.array([1e-5, 1e-5, 1e-5, 3e-4, 3e-4])
    held = np.flatnonzero(np.array(force) == 0)
    free = np.setdiff1d(np.arange(5), held)

    def total(u: Array) -> float:
        q = np.zeros(5)
        q[free] = u * size[free]
        return float(energy(bearing, q) - np.dot(force, q)) * 100

    least = minimize(total, np.full(len(free), 0.5), method="BFGS", jac="3-point", options={"gtol": 1e-9})
    q = displacement(bearing, force, places=bearing.elements, laminae=8)
    assert q[free] / size[free] == pytest.approx(least.x, abs=1e-6 * np.abs(least.x).max())
    assert q[held] == pytest.approx(0, abs=1e-15)


PROGRAM = [  # clearance, force -> radial and axial motion [um]
    (0.0, [1e3, 0, 0, 0, 0], 15.1101, 0.0),
    (0.0, [0, 0, 1e3, 0, 0], 0.0, 133.5381),
    (10e-6, [1e3, 0, 0, 0, 0], 21.223, 0.0),
    (10e-6, [0, 0, 1e3, 0, 0], 0.0, 149.1717),
    (10e-6, [1e3, 0, 1e3, 0, 0], 19.5923, 146.4603),
]
OF_THE_PROGRAM = RollingBearing(
    type="deep groove ball", elements=7, element_diameter=11.5e-3, pitch_diameter=43.5e-3, youngs_modulus=2.1e11
)


@pytest.mark.parametrize(("clearance", "force", "radial", "axial"), PROGRAM)
def test_deep_groove_balls_move_as_a_commercial_program_says(
    clearance: float, force: list[float], radial: float, axial: float
) -> None:
    """Its numbers as the tests of an open implementation of ISO/TS 16281 (minzhun/ISO16281) give them.

    Its contact angle turns under load; the free one follows from the clearance.
    """
    q = displacement(replace(OF_THE_PROGRAM, clearance=clearance), force, places=7)
    assert q[[0, 2]] * 1e6 == pytest.approx([radial, axial], rel=5e-5, abs=1e-6)


def test_deep_groove_balls_find_the_free_contact_angle() -> None:
    """Under a small axial load: cos alpha_0 = 1 - clearance/(2 A), at the axial play A sin alpha_0."""
    bearing = replace(DEEP_GROOVE, clearance=20e-6)
    distance = 0.05 * 7.938e-3
    free = math.acos(1 - 20e-6 / (2 * distance))
    q = displacement(bearing, [0, 0, 1e-3])
    assert q[2] == pytest.approx(distance * math.sin(free), rel=1e-4)


@EACH
def test_forces_of_the_displacement_are_the_load_for_many_cases_at_once(bearing: RollingBearing) -> None:
    bearing = replace(bearing, clearance=12e-6)
    axial = 0.0 if bearing.type == "cylindrical roller" else 1.0
    force = np.array(
        [[[8e3, 0, 8e3 * axial], [3e3, 4e3, 5e3 * axial]], [[1e-5, 0, 1e-5 * axial], [0, -2e4, 3e4 * axial]]]
    )
    q = displacement(bearing, force)
    assert q.shape == (2, 2, 5)
    assert (q[..., 3:] == 0).all()
    held = contact_set(bearing).force(q)
    assert held[..., :3] == pytest.approx(force, rel=1e-8, abs=1e-6)
    assert displacement(bearing, force[1, 1]) == pytest.approx(q[1, 1], rel=1e-6, abs=1e-12)


def test_profile_of_the_set_is_that_of_both_contacts() -> None:
    contacts = contact_set(replace(CYLINDRICAL, clearance=8e-6), places=4, laminae=5)
    x = 14e-3 * (np.arange(5) - 2) / 5
    assert contacts.gap.reshape(contacts.shape)[0, 2] == pytest.approx(4e-6 + 2 * roller_profile(CYLINDRICAL, x))
