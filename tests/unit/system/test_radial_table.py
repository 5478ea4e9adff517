"""Tabulated laws of links: against their potential, against formulas they are sampled from, and among other laws."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.system.link_laws import Law, LawGroup, Laws, RadialLaw, RadialTable, stacked
from epicyclic.teeth.mesh_stiffness import force_curve

Array = NDArray[np.float64]
UM = 1e-6


def table(deflection: Array, force: Array) -> RadialTable:
    curve = force_curve(deflection.tolist(), force.tolist())
    return RadialTable(deflection=curve.deflection, force=curve.force, slope=curve.slope, stiffness=curve.stiffness)


BENT = table(np.array([0, 2, 5, 9, 20]) * UM, np.array([0, 30, 200, 900, 3000.0]))
WITH_PLAY = table(np.array([0, 8, 12, 30]) * UM, np.array([0, 0, 100, 1000.0]))


def groups(*members: tuple[RadialLaw, int]) -> Laws:
    return stacked(
        [
            LawGroup(name="g", kind="support", rows=("x", "y")[:r], B=np.eye(2)[:, :r], law=law, damping=np.zeros(r))
            for law, r in members
        ]
    )


@pytest.mark.parametrize("rows", [1, 2])
@pytest.mark.parametrize("law", [BENT, WITH_PLAY], ids=["bent", "play"])
def test_force_is_the_slope_of_the_potential_and_tangent_that_of_the_force(law: RadialTable, rows: int) -> None:
    rng = np.random.default_rng(2)
    many = groups((law, rows), (Law(stiffness=1e7, clearance=1e-5), 2), (BENT, 1), (law, rows))
    R = many.rows.owner.size
    delta = rng.normal(size=(400, R)) * 10 ** rng.uniform(-6, -4.3, size=(400, 1))
    force, tangent = many.force(delta), many.tangent(delta)
    h = 1e-11
    for j, step in enumerate(h * np.eye(R)):
        energy = (many.potential(delta + step) - many.potential(delta - step)).sum(axis=1)
        # second order of h = 1e-11 on 1e-6 m, and 1e-16 of 1e-2 J over h
        np.testing.assert_allclose(energy / (2 * h), force[:, j], rtol=1e-5, atol=1e-3)
        slope = (many.force(delta + step) - many.force(delta - step)) / (2 * h)
        np.testing.assert_allclose(slope, tangent[:, :, j], atol=1e-4 * np.abs(tangent).max())


@pytest.mark.parametrize("law", [BENT, WITH_PLAY], ids=["bent", "play"])
def test_energy_is_the_integral_of_the_force(law: RadialTable) -> None:
    rho = np.linspace(0, 40 * UM, 4001)[:, None]
    many = groups((law, 1))
    force = many.radial(rho)[0][:, 0]
    steps = np.diff(rho[:, 0]) * (force[1:] + force[:-1]) / 2
    energy = many.potential(rho)[:, 0]
    np.testing.assert_allclose(energy[1:], np.cumsum(steps), atol=1e-5 * energy[-1])  # trapezoids of 10 nm


def test_tables_sampled_from_rolling_elements_and_play_are_those_laws() -> None:
    rolling = Law(stiffness=4e8, exponent=10 / 9, load=5000.0)
    rho = np.linspace(0, 60, 601)[1:, None] * UM
    sampled = np.linspace(0, 1, 25) ** 2 * 60 * UM  # dense at first touch, where the exponent bends the curve
    force, slope = groups((rolling, 1)).radial(rho)
    found, tangent = groups((table(sampled, groups((rolling, 1)).radial(sampled[:, None])[0][:, 0]), 1)).radial(rho)
    assert np.abs(found - force).max() < 1e-4 * force.max()
    assert np.abs(tangent - slope)[rho > 5 * UM].max() < 2e-3 * slope.max()
    play = Law(stiffness=1e8, clearance=10 * UM)
    straight = table(np.array([0, 10, 30]) * UM, np.array([0, 0, 2000.0]))
    for mine, other in zip(groups((straight, 1)).radial(rho), groups((play, 1)).radial(rho), strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-12, atol=1e-9 * float(np.abs(other).max()))
    assert straight.kind == "table with play"


def test_a_straight_table_has_a_compiled_form_and_others_none() -> None:
    straight = table(np.array([0, 10, 30]) * UM, np.array([0, 0, 2000.0]))
    lowered = straight.lower()
    assert lowered is not None
    assert (lowered.stiffness, lowered.clearance) == pytest.approx((1e8, 1e-5), rel=1e-12)
    assert BENT.lower() is None


def test_it_goes_on_along_its_last_tangent_and_knows_its_end() -> None:
    rho = np.array([20.0, 25, 40])[:, None] * UM
    force, slope = groups((BENT, 1)).radial(rho)
    np.testing.assert_allclose(force[:, 0], 3000 + BENT.slope[-1] * (rho[:, 0] - 20 * UM), rtol=1e-12)
    np.testing.assert_allclose(slope, BENT.slope[-1], rtol=1e-12)
    assert BENT.end == 3000
    assert np.isinf(Law(stiffness=1.0).end)


@pytest.mark.parametrize("law", [BENT, WITH_PLAY], ids=["bent", "play"])
def test_stiffest_bounds_the_tangent(law: RadialTable) -> None:
    slope = groups((law, 1)).radial(np.linspace(0, 50 * UM, 5001)[:, None])[1]
    # 3 / 2 of a secant is not idle: the slope of a rising cubic reaches its secant
    assert slope.max() <= law.stiffest * (1 + 1e-12) <= 1.5 * slope.max() * (1 + 1e-9)
