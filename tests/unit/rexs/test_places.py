"""Masses and inertias of sections against closed forms of solids."""

from __future__ import annotations

import math

import pytest

from epicyclic.rexs.members import SolidSection, inertia_of

RHO = 7850.0


def test_a_hollow_cylinder() -> None:
    outer, inner, length = 0.2, 0.12, 0.3
    found = inertia_of([SolidSection(-length / 2, length, (outer, outer), (inner, inner), RHO)])
    mass = RHO * math.pi / 4 * (outer**2 - inner**2) * length
    assert found.mass == pytest.approx(mass, rel=1e-14)
    assert found.polar == pytest.approx(mass * (outer**2 + inner**2) / 8, rel=1e-14)
    assert found.tilt == pytest.approx(mass * (3 * (outer**2 + inner**2) / 4 + length**2) / 12, rel=1e-14)


def test_a_cone_about_its_apex() -> None:
    base, height = 0.3, 0.4  # diameter, height: 3/10 m r^2 and 3/5 m (r^2/4 + h^2) about the apex
    found = inertia_of([SolidSection(0.0, height, (0.0, base), (0.0, 0.0), RHO)])
    mass = RHO * math.pi * base**2 / 12 * height
    assert found.mass == pytest.approx(mass, rel=1e-14)
    assert found.polar == pytest.approx(0.3 * mass * base**2 / 4, rel=1e-14)
    assert found.tilt == pytest.approx(0.6 * mass * (base**2 / 16 + height**2), rel=1e-14)


def test_pins_around_an_axis() -> None:
    d, length, radius = 0.04, 0.1, 0.15
    pins = [SolidSection(0.0, length, (d, d), (0.0, 0.0), RHO, radius)] * 3
    found = inertia_of(pins)
    mass = RHO * math.pi / 4 * d**2 * length
    assert found.mass == pytest.approx(3 * mass, rel=1e-14)
    assert found.polar == pytest.approx(3 * mass * (d**2 / 8 + radius**2), rel=1e-14)
    # each pin about x: its own, Steiner along z to its middle, Steiner across by radius^2 sin^2 of 0, 120, 240 deg
    own = mass * (d**2 / 16 + length**2 / 12) + mass * (length / 2) ** 2
    across = sum(mass * (radius * math.sin(math.radians(angle))) ** 2 for angle in (0, 120, 240))
    assert found.tilt == pytest.approx(3 * own + across, rel=1e-12)
