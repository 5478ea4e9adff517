"""Clearance in operation: groups of ISO 5753, fits by Lamé's equations solved apart, temperature; in the model file."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from tests.unit.questions.rating.test_life import train

import epicyclic
from epicyclic.bearings.checks import GROUPS, group_range, operating_clearance
from epicyclic.errors import ModelError
from epicyclic.train.resolution import load

RACES = (58e-3, 82e-3)
MODULUS, POISSON = 2.07e11, 0.3


def ring(inner: float, outer: float, pressures: tuple[float, float], at: float) -> float:
    """Growth of a diameter of a ring [m] under pressures inside and outside [Pa], by Lamé's two constants."""
    a, b = inner / 2, outer / 2
    constant = (pressures[0] * a**2 - pressures[1] * b**2) / (b**2 - a**2)
    factor = (pressures[0] - pressures[1]) * a**2 * b**2 / (b**2 - a**2)
    return at / MODULUS * ((1 - POISSON) * constant + (1 + POISSON) * factor / (at / 2) ** 2)


@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_fits_take_what_thick_rings_grow_and_shrink(fit: str) -> None:
    """The pressure that closes the interference, then the growth of the raceway under it."""
    if fit == "inner":
        bore, tight = 50e-3, 20e-6
        shaft, seat = ring(1e-9, bore, (0, 1.0), bore), ring(bore, RACES[0], (1.0, 0), bore)
        pressure = tight / (seat - shaft)
        takes = ring(bore, RACES[0], (pressure, 0), RACES[0])
        found, _ = operating_clearance("", RACES, initial=60e-6, bore=bore, inner_fit=tight)
    else:
        outside, tight = 90e-3, 15e-6
        housing, seat = ring(outside, 1e3, (1.0, 0), outside), ring(RACES[1], outside, (0, 1.0), outside)
        pressure = tight / (housing - seat)
        takes = -ring(RACES[1], outside, (0, pressure), RACES[1])
        found, _ = operating_clearance("", RACES, initial=60e-6, outside_diameter=outside, outer_fit=tight)
    assert 60e-6 - found == pytest.approx(takes, rel=1e-6)
    assert 0.8 < takes / tight < 1


def test_a_warmer_inner_ring_takes_clearance() -> None:
    found, words = operating_clearance("", RACES, initial=60e-6, temperature_difference=10.0)
    assert found == pytest.approx(60e-6 - 12e-6 * 10 * 70e-3, rel=1e-12)
    assert "8.4 um by heat" in words


def test_groups_are_those_of_catalogues() -> None:
    """Entries that every catalogue prints: 6205 (bore 25 mm) and NU 210 (50 mm), at a bound of the bores."""
    known = {
        ("deep groove ball", 25e-3): [(1, 11), (5, 20), (13, 28), (23, 41)],
        ("cylindrical roller", 50e-3): [(5, 35), (30, 60), (50, 80), (70, 100)],
        ("cylindrical roller", 50.1e-3): [(10, 40), (40, 70), (60, 90), (80, 110)],
    }
    for (kind, bore), ranges in known.items():
        for group, span in zip(GROUPS, ranges, strict=True):
            assert group_range(kind, group, bore) == pytest.approx([1e-6 * one for one in span])


@pytest.mark.parametrize(("kind", "bores"), [("deep groove ball", (7, 200)), ("cylindrical roller", (11, 1000))])
def test_groups_follow_each_other_and_grow_with_the_bore(kind: str, bores: tuple[int, int]) -> None:
    spans = np.array([[group_range(kind, group, d / 1e3) for group in GROUPS] for d in range(bores[0], bores[1] + 1)])
    assert (np.diff(spans, axis=2) > 0).all()  # least and most
    assert (np.diff(spans, axis=1) > 0).all()  # C2, CN, C3, C4
    assert (spans[:, 1:, 0] <= spans[:, :-1, 1]).all()  # no gap between two groups
    assert (np.diff(spans, axis=0) >= 0).all()


FITTED: dict[str, Any] = {
    "group": "C3",
    "bore": "50 mm",
    "inner_fit": "12 um",
    "outside_diameter": "90 mm",
    "outer_fit": "9 um",
    "temperature_difference": "5 K",
}


def test_the_model_file_takes_a_group_and_check_says_what_became_of_it() -> None:
    """The clearance of all that follows is that in operation; a number is that number."""
    made = load(train(internal_clearance=FITTED))
    (bearing,) = [one.rolling for one in made.links if one.name == "main/planet/2/bearing"]
    assert bearing is not None
    by_hand = 65e-6 - 12e-6 * 50 / 58 - 9e-6 * 82 / 90 - 12e-6 * 5 * 70e-3
    assert bearing.clearance == pytest.approx(by_hand, rel=1e-12)
    check = epicyclic.check(made)
    assert check.clearance_origin.values[0].startswith("C3: 50 to 80 um, 65 um taken, less 18.54 um by fits and 4.2 um")
    np.testing.assert_allclose(check.bearing_clearance, by_hand)
    number = epicyclic.check(train(internal_clearance=f"{by_hand!r} m"))
    np.testing.assert_allclose(check.element_load, number.element_load)
    assert set(number.clearance_origin.values) == {""}
    over = load(train(internal_clearance=FITTED), overrides={"stages.main.planet.bearing.internal_clearance": "20 um"})
    assert next(one.rolling for one in over.links if one.rolling).clearance == pytest.approx(20e-6)


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "both": (
        {"initial": "30 um"},
        r"internal_clearance\.initial: not a clearance before mounting; allowed: initial, or",
    ),
    "neither": ({"group": None}, r"internal_clearance\.initial: not a clearance"),
    "no bore": ({"bore": None}, r"internal_clearance\.bore = 0 mm: no bore of an inner ring; allowed: up to 58 mm"),
    "wide bore": ({"bore": "60 mm"}, r"internal_clearance\.bore = 60 mm: no bore"),
    "no outside": ({"outside_diameter": None}, r"internal_clearance\.outside_diameter = 0 mm: no outer ring"),
    "outside": ({"outside_diameter": "80 mm"}, r"outside_diameter = 80 mm: no outer ring; allowed: 82 mm or more"),
    "small": (
        {"bore": "8 mm"},
        r"internal_clearance\.bore = 8 mm: outside of the table of groups; allowed: above",
    ),
    "group": ({"group": "C6"}, r"internal_clearance\.group"),
    "unit": ({"temperature_difference": "5 m"}, r"temperature_difference"),
    "heat": (
        {"temperature_difference": "500 K"},
        r"internal_clearance = -373\.54.* um: presses the elements too hard, in operation: C3: .* 65 um taken, less "
        r"18\.54 um by fits and 420 um by heat; allowed: -[0-9.]+ um or more",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_clearance_that_does_not_follow_is_refused(name: str) -> None:
    changes, words = BAD[name]
    stated = {key: value for key, value in {**FITTED, **changes}.items() if value is not None}
    with pytest.raises(ModelError, match=words):
        load(train(internal_clearance=stated))


@pytest.mark.parametrize("key", ["element_diameter", "pitch_diameter"])
def test_parts_are_checked_before_the_clearance_that_they_make(key: str) -> None:
    """Larger elements leave no inner ring, a larger circle no outer one: the part is named, not the clearance."""
    size = {"element_diameter": "25 mm", "pitch_diameter": "110 mm"}[key]
    with pytest.raises(ModelError, match=rf"planet\.bearing\.{key} = {size}: "):
        load(train(internal_clearance=FITTED, **{key: size}))


def test_fits_that_take_more_than_the_clearance_are_told() -> None:
    """A bearing that is pressed on purpose, by its number or that of the new bearing, is none of them."""

    def said(**changes: Any) -> list[str]:
        table = {key: value for key, value in {**FITTED, **changes}.items() if value is not None}
        return [text for text in load(train(internal_clearance=table)).warnings if "[bearing-preloaded]" in text]

    assert not said()
    (text,) = said(inner_fit="75 um")
    assert text.startswith("stages.main.planet.bearing.internal_clearance: -12.0")
    assert "72.86 um by fits and 4.2 um by heat" in text
    loose = {"group": None, "inner_fit": None, "outer_fit": None, "temperature_difference": None}
    assert not said(initial="-5 um", **loose)


def test_a_type_without_groups_takes_a_number() -> None:
    tapered = {"type": "tapered roller", "contact_angle": f"{14 * pi / 180} rad"}
    with pytest.raises(ModelError, match=r"group = C3: no range is known of a tapered roller bearing"):
        load(train(**tapered, internal_clearance={"group": "C3", "bore": "50 mm"}))
    load(train(**tapered, internal_clearance={"initial": "40 um"}))
