"""Geometry and frequencies of a bearing by hand and by rolling velocities; numbers that do not fit together."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from tests.unit.bearings.bearing_examples import ALL, ANGULAR, CYLINDRICAL, DEEP_GROOVE, DOUBLE, SPHERICAL, TAPERED

from epicyclic.bearings.checks import checked
from epicyclic.bearings.rolling_bearing import RollingBearing, element_law, passing_frequencies, rated_element_load
from epicyclic.errors import ModelError


def test_frequencies_of_a_6205_are_those_of_catalogues() -> None:
    """Multiples of the speed of the inner race that are printed for this bearing everywhere."""
    found = passing_frequencies(DEEP_GROOVE, 1.0, 0.0)
    assert found == pytest.approx((0.3983, 3.585, 5.415, 2.357), abs=5e-4)


@pytest.mark.parametrize(("inner", "outer"), [(30.0, 0.0), (0.0, -12.0), (25.0, -40.0), (7.0, 9.0)])
def test_frequencies_follow_from_velocities_of_rolling(inner: float, outer: float) -> None:
    d_i, d_e = (
        ANGULAR.pitch_diameter + sign * ANGULAR.element_diameter * math.cos(ANGULAR.contact_angle) for sign in (-1, 1)
    )
    v_i, v_e = inner * d_i / 2, outer * d_e / 2
    cage = (v_i + v_e) / 2 / (ANGULAR.pitch_diameter / 2)
    # about its own axis, seen from the cage, an element rolls on the outer race, which passes below it
    element = abs((outer - cage) * d_e / ANGULAR.element_diameter)
    by_hand = (cage, 14 * abs(cage - outer), 14 * abs(inner - cage), element)
    assert passing_frequencies(ANGULAR, inner, outer) == pytest.approx(by_hand, rel=1e-12)


def test_races_that_turn_together_pass_nothing() -> None:
    assert passing_frequencies(TAPERED, 11.0, 11.0) == pytest.approx((11.0, 0.0, 0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("race", ["inner", "outer"])
def test_curvatures_are_those_of_the_principal_radii(race: Any) -> None:
    side = 1 if race == "inner" else -1
    cos, size = math.cos(ANGULAR.contact_angle), ANGULAR.element_diameter
    around = side / ((ANGULAR.pitch_diameter / 2) / cos - side * size / 2)
    across = -1 / (ANGULAR.groove[0 if race == "inner" else 1] * size)
    total = 4 / size + around + across
    assert ANGULAR.curvature(race) == pytest.approx((total, (around - across) / total), rel=1e-12)
    around = side / (CYLINDRICAL.pitch_diameter / 2 - side * CYLINDRICAL.element_diameter / 2)
    total = 2 / CYLINDRICAL.element_diameter + around
    assert CYLINDRICAL.curvature(race) == pytest.approx((total, 1.0), rel=1e-12)


@pytest.mark.parametrize(("arrangement", "outside"), [("O", True), ("X", False)])
def test_contact_lines_meet_the_axis_where_the_arrangement_says(arrangement: Any, outside: bool) -> None:
    bearing = replace(DOUBLE, arrangement=arrangement)
    meets = [z - bearing.pitch_diameter / 2 * math.tan(alpha) for z, alpha in bearing.row_places]
    assert meets[0] == pytest.approx(-meets[1])
    assert (meets[0] < bearing.row_places[0][0] == -10e-3) is outside
    assert [z - SPHERICAL.pitch_diameter / 2 * math.tan(alpha) for z, alpha in SPHERICAL.row_places] == pytest.approx(
        [0, 0], abs=1e-15
    )


@pytest.mark.parametrize("bearing", ALL.values(), ids=ALL.keys())
def test_bearings_that_fit_pass(bearing: RollingBearing) -> None:
    assert checked(bearing, "main.bearing") is bearing
    assert checked(replace(bearing, clearance=2e-5), "main.bearing").clearance == 2e-5


BAD: list[tuple[RollingBearing, dict[str, Any], str, str]] = [
    (DEEP_GROOVE, {"contact_angle": 0.3}, "contact_angle", "type deep groove ball"),
    (ANGULAR, {"contact_angle": 0.0}, "contact_angle", "type angular contact ball"),
    (TAPERED, {"contact_angle": math.radians(50)}, "contact_angle", "type tapered roller"),
    (DEEP_GROOVE, {"elements": 16}, "element_diameter", "overlap"),
    (CYLINDRICAL, {"element_length": 0.3}, "element_length", "does not fit"),
    (DOUBLE, {"rows": 3}, "rows", "more than two"),
    (DOUBLE, {"row_distance": 5e-3}, "row_distance", "overlap"),
    (DOUBLE, {"contact_angle": -DOUBLE.contact_angle}, "contact_angle", "both senses"),
    (CYLINDRICAL, {"row_distance": 5e-3}, "row_distance", "follows"),
    (SPHERICAL, {"row_distance": 20e-3}, "row_distance", "follows"),
    (CYLINDRICAL, {"preload": 1e-6}, "preload", "contact angle"),
    (ANGULAR, {"preload": 1e-3}, "preload", "limit"),
    (CYLINDRICAL, {"clearance": -1e-3}, "clearance", "too hard"),
    (CYLINDRICAL, {"clearance": 1e-3}, "clearance", "too large"),
    (DEEP_GROOVE, {"clearance": 5e-4}, "clearance", "too large"),
    (DEEP_GROOVE, {"rating": 14.0}, "rating", "wrong size"),
    (DEEP_GROOVE, {"static_rating": 30e3}, "static_rating", "wrong size"),
]


@pytest.mark.parametrize(("bearing", "change", "key", "words"), BAD, ids=lambda value: str(value)[:40])
def test_numbers_that_do_not_fit_are_named(
    bearing: RollingBearing, change: dict[str, Any], key: str, words: str
) -> None:
    with pytest.raises(ModelError, match=words) as caught:
        checked(replace(bearing, **change), "main.bearing")
    assert caught.value.path == f"main.bearing.{key}"


@pytest.mark.parametrize(
    ("bearing", "change", "text"),
    [
        (TAPERED, {"contact_angle": math.radians(95)}, "b.contact_angle = 95 deg: .*; allowed: 5 to 45 deg$"),
        (DEEP_GROOVE, {"contact_angle": 0.1}, "; allowed: 0$"),
        (CYLINDRICAL, {"element_length": 0.3}, "b.element_length = 300 mm: .*; allowed: [0-9.]+ to [0-9.]+ mm$"),
        (CYLINDRICAL, {"clearance": -1e-3}, "b.clearance = -1000 um: .*; allowed: -[0-9.]+ um or more$"),
        (DEEP_GROOVE, {"rating": 14.0}, "b.rating = 14 N: .* N of the geometry$"),
        (
            DOUBLE,
            {"row_distance": 5e-3},
            "b.row_distance = 5 mm: rows overlap, with element_.* = .* mm; .* mm or more$",
        ),
    ],
)
def test_what_was_given_has_the_unit_of_what_is_allowed(
    bearing: RollingBearing, change: dict[str, Any], text: str
) -> None:
    with pytest.raises(ModelError, match=text):
        checked(replace(bearing, **change), "b")


def test_the_limit_of_the_preload_is_the_static_load_of_an_element() -> None:
    stiffness, exponent = element_law(ANGULAR)
    limit = (rated_element_load(ANGULAR) / stiffness) ** (1 / exponent) / math.sin(ANGULAR.contact_angle)
    assert checked(replace(ANGULAR, preload=0.999 * limit), "b").preload > 0
    with pytest.raises(ModelError, match="static rating"):
        checked(replace(ANGULAR, preload=1.001 * limit), "b")
