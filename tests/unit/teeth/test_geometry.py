"""Geometry of gears and pairs, against closed forms and published drives."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tooth_oracles import tip_thickness

from epicyclic.teeth import geometry as g

deg = math.radians


def _contact(
    teeth_a: int, teeth_b: int, module: float, pressure_angle: float, helix_angle: float, *, internal: bool
) -> tuple[float, float]:
    # Contact limits of an unshifted pair at its reference centre distance.
    base = [g.base_radius(z, module, pressure_angle, helix_angle) for z in (teeth_a, teeth_b)]
    return g.contact_limits(
        base[0],
        g.tip_radius(teeth_a, module, helix_angle),
        base[1],
        g.tip_radius(teeth_b, module, helix_angle, internal=internal),
        working_pressure_angle=g.transverse_pressure_angle(pressure_angle, helix_angle),
        base_pitch=g.base_pitch(module, pressure_angle, helix_angle),
        internal=internal,
    )


def test_angles_of_ren2021() -> None:
    # [ren2021]: alpha_t 21.880, beta_b 23.399 deg, carrier radius 706.2 mm; printed digits.
    assert math.degrees(g.transverse_pressure_angle(deg(20), deg(25))) == pytest.approx(21.880, abs=5e-4)
    assert math.degrees(g.base_helix_angle(deg(20), deg(25))) == pytest.approx(23.399, abs=5e-4)
    assert g.reference_centre_distance(23, 17, 32e-3, deg(25)) == pytest.approx(0.7062, abs=5e-5)


def test_base_helix_of_xu2020() -> None:
    # [xu2020]: beta_b 7.246 deg, centre distance 439.275 mm from either mesh; printed digits.
    assert math.degrees(g.base_helix_angle(deg(25), deg(8))) == pytest.approx(7.246, abs=5e-4)
    for teeth, internal in (((21, 37), False), ((37, 95), True)):
        distance = g.reference_centre_distance(*teeth, 15e-3, deg(8), internal=internal)
        assert distance == pytest.approx(439.275e-3, abs=5e-7)


@given(st.floats(0.2, 0.6), st.floats(0.0, 0.7))
def test_base_helix_agrees_with_its_other_closed_form(pressure: float, helix: float) -> None:
    # tan beta_b = tan beta cos alpha_t, the same angle by another route; rounding only.
    transverse = g.transverse_pressure_angle(pressure, helix)
    other = math.atan(math.tan(helix) * math.cos(transverse))
    assert g.base_helix_angle(pressure, helix) == pytest.approx(other, abs=1e-14)


def test_radii_of_one_tooth_form() -> None:
    # Spur gear, m = 4 mm, z = 19, 25 deg: reference 38 mm; base 34.44 mm is printed as exact in [yue2014].
    assert g.reference_radius(19, 4e-3, 0.0) == pytest.approx(38e-3, rel=1e-15)  # one rounding
    assert g.base_radius(19, 4e-3, deg(25), 0.0) == pytest.approx(34.44e-3, abs=5e-6)
    assert g.base_radius(20, 4e-3, deg(25), 0.0) == pytest.approx(36.25e-3, abs=5e-6)
    # z p_bt is the base circle's circumference, by definition.
    turn = 2 * math.pi * g.base_radius(19, 4e-3, deg(20), deg(30))
    assert 19 * g.base_pitch(4e-3, deg(20), deg(30)) == pytest.approx(turn, rel=1e-14)


def test_positive_shift_lengthens_the_addendum_of_a_ring_too() -> None:
    assert g.tip_radius(20, 2e-3, 0.0, profile_shift=0.3) == pytest.approx(22.6e-3, rel=1e-14)  # 20 + 2 (1 + 0.3)
    assert g.root_radius(20, 2e-3, 0.0, profile_shift=0.3) == pytest.approx(18.1e-3, rel=1e-14)  # 20 - 2 (1.25 - 0.3)
    # The ring: 60 - 2 (1 + 0.3) and 60 + 2 (1.25 - 0.3).
    assert g.tip_radius(60, 2e-3, 0.0, internal=True, profile_shift=0.3) == pytest.approx(57.4e-3, rel=1e-14)
    assert g.root_radius(60, 2e-3, 0.0, internal=True, profile_shift=0.3) == pytest.approx(61.9e-3, rel=1e-14)


def test_fva_stage_has_one_centre_distance() -> None:
    # Teeth 17/22/61, module 4 mm: 78 mm, the figure in the FVA example file.
    assert g.reference_centre_distance(17, 22, 4e-3, 0.0) == pytest.approx(78e-3, rel=1e-15)
    assert g.reference_centre_distance(22, 61, 4e-3, 0.0, internal=True) == pytest.approx(78e-3, rel=1e-15)


# 5 MW reference gearbox [nejad2016]: (teeth a, teeth b, module mm, helix deg, centre distance mm, known shift of a,
# internal, shift of b that follows).  The last column is printed with four decimals.
_WIND = [
    (19, 17, 45, 0, 863, 0.617, False, 0.8021),
    (17, 56, 45, 0, 863, 0.8021, True, -0.5013),
    (18, 36, 21, 0, 584, 0.389, False, 0.5039),
    (36, 93, 21, 0, 584, 0.5039, True, 0.1171),
    (24, 95, 14, 10, 861, 0.480, False, 0.6691),
]


@pytest.mark.parametrize(("a", "b", "module", "helix", "distance", "given_shift", "internal", "expected"), _WIND)
def test_shifts_of_the_wind_gearbox_follow_from_centre_distances(
    a: int, b: int, module: int, helix: int, distance: int, given_shift: float, internal: bool, expected: float
) -> None:
    radii = [g.base_radius(z, module * 1e-3, deg(20), deg(helix)) for z in (a, b)]
    working = g.working_pressure_angle_at(distance * 1e-3, *radii, internal=internal)
    total = g.shift_sum(a, b, deg(20), deg(helix), working_pressure_angle=working, internal=internal)
    # 1e-4: both the table's shift and the one it is taken from are rounded to four decimals.
    assert total - given_shift == pytest.approx(expected, abs=1e-4)


_pairs = st.tuples(
    st.integers(12, 60),
    st.integers(30, 80),
    st.floats(deg(15), deg(28)),
    st.floats(0.0, deg(35)),
    st.floats(-0.2, 0.8),
    st.floats(-0.2, 0.8),
    st.booleans(),
)


@given(_pairs)
def test_shifts_and_centre_distance_round_trip(pair: tuple[int, int, float, float, float, float, bool]) -> None:
    a, more, pressure, helix, shift_a, shift_b, internal = pair
    b = a + more if internal else more
    angle = g.working_pressure_angle(a, b, pressure, helix, shift_a=shift_a, shift_b=shift_b, internal=internal)
    if math.isnan(angle) or angle < 0.05:
        return  # a ring pulled in so far that no angle is left; near zero the shift no longer fixes the angle
    distance = g.centre_distance(
        a, b, 3e-3, helix, pressure_angle=pressure, working_pressure_angle=angle, internal=internal
    )
    radii = [g.base_radius(z, 3e-3, pressure, helix) for z in (a, b)]
    again = g.working_pressure_angle_at(distance, *radii, internal=internal)
    back = g.shift_sum(a, b, pressure, helix, working_pressure_angle=again, internal=internal)
    # acos near 1 loses 1e-16/angle, here at most 2e-15 rad, times (z tan^2)/(2 tan alpha_n) < 60.
    assert back == pytest.approx(shift_a + shift_b, abs=1e-12)


@given(_pairs)
def test_working_tooth_thicknesses_fill_the_pitch(pair: tuple[int, int, float, float, float, float, bool]) -> None:
    # Independent of the shift formula: without backlash the two teeth on the working circles add up to one pitch.
    a, more, pressure, helix, shift_a, shift_b, internal = pair
    b = a + more if internal else more
    angle = g.working_pressure_angle(a, b, pressure, helix, shift_a=shift_a, shift_b=shift_b, internal=internal)
    if math.isnan(angle):
        return
    thick = 0.0
    for teeth, shift, ring in ((a, shift_a, False), (b, shift_b, internal)):
        circle = g.base_radius(teeth, 3e-3, pressure, helix) / math.cos(angle)
        thick += tip_thickness(teeth, 3e-3, pressure, helix, tip_radius=circle, profile_shift=shift, internal=ring)
    pitch = g.base_pitch(3e-3, pressure, helix) / math.cos(angle)
    # 1e-9 relative: at a small working angle acos(r_b/r) inside tip_thickness keeps half the digits only.
    assert thick == pytest.approx(pitch, rel=1e-9)


def test_no_shift_works_at_the_reference_angle_exactly() -> None:
    angle = g.working_pressure_angle(23, 17, deg(20), deg(25), shift_a=0.3, shift_b=-0.3)
    assert angle == g.transverse_pressure_angle(deg(20), deg(25))


def test_working_angle_is_nan_where_there_is_none() -> None:
    assert math.isnan(g.working_pressure_angle(30, 60, deg(20), 0.0, shift_a=1.0, shift_b=1.0, internal=True))
    assert math.isnan(g.working_pressure_angle_at(0.09, 0.05, 0.05))
    assert math.isnan(g.working_pressure_angle_at(0.09, 0.05, 0.04, internal=True))


# (source, teeth, module mm, pressure angle, helix angle, internal, printed, half a unit of its last digit)
_CONTACT_RATIOS = [
    ("ren2021", (23, 17), 32, 20, 25, False, 1.372, 5e-4),
    ("ren2021", (17, 57), 32, 20, 25, True, 1.614, 5e-4),
    ("encased-differential", (37, 56), 7, 20, 22, False, 1.556, 5e-4),
    ("encased-differential", (56, 149), 7, 20, 22, True, 1.699, 5e-4),
    ("encased-differential", (71, 39), 7, 20, 22, False, 1.573, 5e-4),
    ("encased-differential", (39, 149), 7, 20, 22, True, 1.674, 5e-4),
    ("xu2020", (21, 37), 15, 25, 8, False, 1.441, 5e-4),
    ("xu2020", (37, 95), 15, 25, 8, True, 1.602, 5e-4),
    ("yue2014", (19, 20), 4, 25, 0, False, 1.40581, 5e-6),
]


@pytest.mark.parametrize(
    ("source", "teeth", "module", "pressure", "helix", "internal", "printed", "half"), _CONTACT_RATIOS
)
def test_published_contact_ratios(
    source: str,
    teeth: tuple[int, int],
    module: int,
    pressure: int,
    helix: int,
    internal: bool,
    printed: float,
    half: float,
) -> None:
    limits = _contact(*teeth, module * 1e-3, deg(pressure), deg(helix), internal=internal)
    assert g.transverse_contact_ratio(limits) == pytest.approx(printed, abs=half), source


def test_contact_limits_lie_where_the_tips_cross_the_line_of_action() -> None:
    # Walk along n_t from the pitch point by sigma_max base pitches: the tip of a is there, at sigma_min that of b.
    module, pressure, a, b = 4e-3, deg(20), 22, 61
    limits = _contact(a, b, module, pressure, 0.0, internal=True)
    pitch = g.base_pitch(module, pressure, 0.0)
    for sigma, centre, tip in (
        (limits[1], 0.0, g.tip_radius(a, module, 0.0)),
        (
            limits[0],
            g.reference_radius(a, module, 0.0) - g.reference_radius(b, module, 0.0),
            g.tip_radius(b, module, 0.0, internal=True),
        ),
    ):
        x = g.reference_radius(a, module, 0.0) + sigma * pitch * math.sin(pressure)
        y = sigma * pitch * math.cos(pressure)
        assert math.hypot(x - centre, y) == pytest.approx(tip, rel=1e-13)  # rounding of a square root
    assert limits[0] < 0.0 < limits[1]


def test_swapping_an_external_pair_mirrors_the_limits() -> None:
    forward = _contact(21, 37, 15e-3, deg(25), deg(8), internal=False)
    backward = _contact(37, 21, 15e-3, deg(25), deg(8), internal=False)
    assert backward == pytest.approx((-forward[1], -forward[0]), rel=1e-15)


def test_published_overlap_ratios() -> None:
    # Printed with three decimals: ren2021 0.715 (170 mm), xu2020 .517 (175 mm), encased per half 2.855, 2.739.
    assert g.overlap_ratio(170e-3, deg(25), 32e-3) == pytest.approx(0.715, abs=5e-4)
    assert g.overlap_ratio(175e-3, deg(-8), 15e-3) == pytest.approx(0.517, abs=5e-4)
    assert g.overlap_ratio(167.6e-3, deg(22), 7e-3) == pytest.approx(2.855, abs=5e-4)
    assert g.overlap_ratio(160.8e-3, deg(22), 7e-3) == pytest.approx(2.739, abs=5e-4)


def test_tip_thickness_at_the_reference_circle_is_half_the_pitch() -> None:
    for internal in (False, True):
        thick = tip_thickness(30, 2e-3, deg(20), 0.0, tip_radius=30e-3, internal=internal)
        assert thick == pytest.approx(math.pi * 1e-3, rel=1e-13)  # rounding


def test_a_strongly_shifted_small_pinion_is_pointed() -> None:
    # Handbooks: a 20 deg pinion of 12 teeth comes to a point near x = 0.65 with a full addendum.
    thick = [
        tip_thickness(12, 1e-3, deg(20), 0.0, profile_shift=x, tip_radius=g.tip_radius(12, 1e-3, 0.0, profile_shift=x))
        for x in (0.3, 0.9)
    ]
    assert thick[0] > 0.0 > thick[1]


@pytest.mark.parametrize("rack_first", [False, True])
def test_undercut_limit_is_where_the_rack_would_leave_the_involute(rack_first: bool) -> None:
    # A gear against a very large one as rack: interference begins at z = 2/sin^2 alpha = 17.1 teeth [iso21771].
    for teeth, sign in ((17, -1.0), (18, 1.0)):
        pair = (1_000_000, teeth) if rack_first else (teeth, 1_000_000)
        limits = _contact(*pair, 1e-3, deg(20), 0.0, internal=False)
        bases = [g.base_radius(z, 1e-3, deg(20), 0.0) for z in pair]
        pitch = g.base_pitch(1e-3, deg(20), 0.0)
        # from the base tangent points, r_b tan alpha off the pitch point, to the ends of the path of contact
        tangent = [base * math.tan(deg(20)) / pitch for base in bases]
        assert math.copysign(1.0, min(limits[0] + tangent[0], tangent[1] - limits[1])) == sign


def test_clearances_change_sign_where_they_should() -> None:
    # m = 1: tip against root leaves 0.25 m outside and inside, to rounding of the radii.
    ring = {"internal": True}
    outside = g.radial_clearance(20e-3, g.tip_radius(19, 1e-3, 0.0), g.root_radius(21, 1e-3, 0.0))
    assert outside == pytest.approx(0.25e-3, abs=1e-15)
    planet_tip, planet_root = g.tip_radius(20, 1e-3, 0.0), g.root_radius(20, 1e-3, 0.0)
    ring_root = g.root_radius(60, 1e-3, 0.0, **ring)
    ring_tip = g.tip_radius(60, 1e-3, 0.0, **ring)
    assert g.radial_clearance(20e-3, planet_tip, ring_root, **ring) == pytest.approx(0.25e-3, abs=1e-15)
    assert g.radial_clearance(20e-3, planet_root, ring_tip, **ring) == pytest.approx(0.25e-3, abs=1e-15)
    assert g.radial_clearance(20e-3, 30e-3, 25e-3, **ring) < 0.0  # the ring is smaller than what turns in it
