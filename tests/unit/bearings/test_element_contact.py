"""One contact: Hertz against spheres, its own integrals and a fit of the literature; rollers and their profile."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from scipy.integrate import quad
from tests.unit.bearings.bearing_examples import ANGULAR, CYLINDRICAL, DEEP_GROOVE, SPHERICAL, TAPERED

from epicyclic.bearings.rolling_bearing import element_law, point_contact, race_contact, roller_profile

MODULUS = 2.07e11 / (1 - 0.3**2)


def test_spheres_have_the_closed_form() -> None:
    radius, load = 1 / (1 / 4e-3 + 1 / 7e-3), 120.0
    contact = point_contact(2 / radius, 0.0, MODULUS)
    star = MODULUS / 2  # 1/E* = 2 (1 - nu^2)/E
    a = (3 * load * radius / (4 * star)) ** (1 / 3)
    assert contact.long * load ** (1 / 3) == pytest.approx(a, rel=1e-12)
    assert contact.short == contact.long
    assert contact.stiffness * (a**2 / radius) ** 1.5 == pytest.approx(load, rel=1e-12)
    assert contact.pressure(load) == pytest.approx(3 * load / (2 * math.pi * a**2), rel=1e-12)


def test_spheres_are_the_limit_of_ellipses() -> None:
    """Up to the second order in F."""
    near, limit = point_contact(300.0, 1e-3, MODULUS), point_contact(300.0, 0.0, MODULUS)
    assert near.stiffness == pytest.approx(limit.stiffness, rel=1e-5)
    below, above = (point_contact(300.0, 1e-4 + side, MODULUS) for side in (-1e-9, 1e-9))
    assert below.long / below.short == pytest.approx(above.long / above.short, rel=1e-7)
    assert near.long / near.short == pytest.approx(1 + 4 / 3 * 1e-3, abs=1e-5)  # k = 1 + 4/3 F, from F(k) about 1


@pytest.mark.parametrize("k", [1.3, 3.0, 8.0, 20.0])
def test_ellipse_is_that_of_integrals_over_its_pressure(k: float) -> None:
    """Approach and curvatures as integrals of the potential of an ellipsoid of pressure, by quadrature.

    u(x, y) = (3 Q / 4 pi E*) int (1 - x^2/(a^2 + w) - y^2/(b^2 + w)) / sqrt((a^2 + w)(b^2 + w) w) dw.
    """
    a, b, star = k, 1.0, MODULUS / 2

    def integral(*powers: float) -> float:
        def inside(t: float) -> float:  # w = t^2
            return 2 / math.sqrt((a**2 + t**2) * (b**2 + t**2)) / math.prod(one**2 + t**2 for one in powers)

        return float(quad(inside, 0, math.inf, epsabs=0, epsrel=1e-12)[0])

    load = 4 * math.pi * star / 3  # the factor before the integral is 1
    along, across, approach = 2 * integral(a), 2 * integral(b), integral()  # curvatures: twice the coefficients
    contact = point_contact(along + across, (across - along) / (across + along), MODULUS)
    assert contact.long * load ** (1 / 3) == pytest.approx(a, rel=1e-8)
    assert contact.short * load ** (1 / 3) == pytest.approx(b, rel=1e-8)
    assert contact.stiffness * approach**1.5 == pytest.approx(load, rel=1e-8)


@pytest.mark.parametrize("race", ["inner", "outer"])
def test_ellipse_is_near_the_fit_of_brewe_and_hamrock(race: Literal["inner", "outer"]) -> None:
    """k = 1.0339 (R_y/R_x)^0.636, E = 1.0003 + 0.5968 R_x/R_y, K = 1.5277 + 0.6023 ln(R_y/R_x) [brewe1977]."""
    total, difference = DEEP_GROOVE.curvature(race)
    ratio = (1 + difference) / (1 - difference)
    k, second, first = 1.0339 * ratio**0.636, 1.0003 + 0.5968 / ratio, 1.5277 + 0.6023 * math.log(ratio)
    contact = race_contact(DEEP_GROOVE, race)
    assert contact.long / contact.short == pytest.approx(k, rel=0.03)
    stiffness = math.pi * k * DEEP_GROOVE.reduced_modulus * math.sqrt(2 * second / (9 * total * first**3))
    assert contact.stiffness == pytest.approx(stiffness, rel=0.03)


def test_both_races_are_in_series() -> None:
    stiffness, exponent = element_law(ANGULAR)
    load = 700.0
    approach = sum((load / race_contact(ANGULAR, race).stiffness) ** (2 / 3) for race in ("inner", "outer"))
    assert stiffness * approach**exponent == pytest.approx(load, rel=1e-12)


def test_roller_has_the_law_of_the_standard_in_newtons_and_millimetres() -> None:
    stiffness, exponent = element_law(CYLINDRICAL)
    assert exponent == 10 / 9
    assert stiffness * 20e-6**exponent == pytest.approx(35_948 * 14 ** (8 / 9) * 0.02 ** (10 / 9), rel=1e-12)
    soft = replace(CYLINDRICAL, youngs_modulus=2.07e11 / 2)
    assert element_law(soft)[0] == pytest.approx(stiffness / 2, rel=1e-12)


def test_profiles_by_hand() -> None:
    x = np.array([0.0, 3.5e-3, -6.3e-3])
    by_hand = [0.0, 0.00035 * 15e-3 * math.log(1 / 0.75), 0.00035 * 15e-3 * math.log(1 / 0.19)]
    assert roller_profile(CYLINDRICAL, x) == pytest.approx(by_hand, rel=1e-12)
    tapered = 0.00045 * 15e-3 * math.log(1 / (1 - 0.35**2))
    assert roller_profile(TAPERED, x)[1] == pytest.approx(tapered, rel=1e-12)
    long = replace(CYLINDRICAL, element_length=60e-3)  # beyond 2.5 D_w = 37.5 mm: straight over 22.5 mm
    found = roller_profile(long, np.array([11e-3, 25e-3]))
    assert found == pytest.approx([0.0, 0.0005 * 15e-3 * math.log(1 / (1 - (27.5 / 37.5) ** 2))], rel=1e-12)
    radius = 50e-3 / math.cos(SPHERICAL.contact_angle) + 7.5e-3
    sagitta = 0.98 * radius - math.sqrt((0.98 * radius) ** 2 - 5e-3**2)
    race = radius - math.sqrt(radius**2 - 5e-3**2)
    assert roller_profile(SPHERICAL, np.array([5e-3]))[0] == pytest.approx(sagitta - race, rel=0.01)
    assert (roller_profile(ANGULAR, x) == 0).all()
