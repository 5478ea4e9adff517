"""Laws of groups: force is the slope of the potential, tangent that of the force, the slider where energy is least."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from epicyclic.system.link_laws import STATES, Law, LawGroup, Laws, stacked

Array = NDArray[np.float64]
K, CLEARANCE, FRICTION = 1e7, 2e-5, 60.0
PLAY = Law(stiffness=K, clearance=CLEARANCE)
ROLLING = Law(stiffness=K, clearance=CLEARANCE, exponent=10 / 9, load=500.0)
TIGHT = Law(stiffness=K, exponent=1.5, load=500.0)
SPLINE = Law(stiffness=K, clearance=CLEARANCE, friction=FRICTION)
COULOMB = Law(stiffness=K, clearance=CLEARANCE, friction=FRICTION, memory=True)
ALL = (PLAY, ROLLING, TIGHT, SPLINE, COULOMB)


def groups(*members: tuple[Law, int]) -> Laws:
    return stacked(
        [
            LawGroup(name="g", kind="support", rows=("x", "y")[:r], B=np.eye(2)[:, :r], law=law, damping=np.zeros(r))
            for law, r in members
        ]
    )


def places(rng: np.random.Generator, count: int, rows: int) -> Array:
    return np.asarray(rng.normal(size=(count, rows)) * 10 ** rng.uniform(-6, -4, size=(count, 1)))


def anchors(rng: np.random.Generator, count: int, many: Laws) -> Array:
    """Sliders inside the clearance, a third of them at the stop."""
    found = rng.normal(size=(count, many.rows.owner.size))
    reach = np.where(rng.random((count, many.rows.first.size)) < 1 / 3, 1.0, rng.random((count, many.rows.first.size)))
    result: Array = found * many.rows.spread(reach * CLEARANCE / many.rows.size(found))
    return result


@pytest.mark.parametrize("rows", [1, 2])
@pytest.mark.parametrize("law", ALL, ids=lambda law: law.kind)
def test_force_is_the_slope_of_the_potential_and_tangent_that_of_the_force(law: Law, rows: int) -> None:
    rng = np.random.default_rng(2)
    many = groups((law, rows), (PLAY, 2), (law, rows))
    delta, anchor = places(rng, 400, many.rows.owner.size), anchors(rng, 400, many)
    force, tangent = many.force(delta, anchor), many.tangent(delta, anchor)
    h = 1e-11
    for j, step in enumerate(h * np.eye(many.rows.owner.size)):
        energy = many.potential(delta + step, anchor) - many.potential(delta - step, anchor)
        # second order of h = 1e-11 on 1e-6 m, and 1e-16 of 1e-2 J over h
        np.testing.assert_allclose(energy.sum(axis=1) / (2 * h), force[:, j], rtol=1e-5, atol=1e-3)
        slope = (many.force(delta + step, anchor) - many.force(delta - step, anchor)) / (2 * h)
        np.testing.assert_allclose(slope, tangent[:, :, j], atol=1e-4 * np.abs(tangent).max())
    np.testing.assert_allclose(tangent, np.swapaxes(tangent, 1, 2), atol=1e-9 * K)


@pytest.mark.parametrize("law", ALL, ids=lambda law: law.kind)
def test_potential_is_convex(law: Law) -> None:
    rng = np.random.default_rng(4)
    many = groups((law, 2))
    a, b, anchor = places(rng, 500, 2), places(rng, 500, 2), anchors(rng, 500, many)
    middle = many.potential((a + b) / 2, anchor)
    ends = (many.potential(a, anchor) + many.potential(b, anchor)) / 2
    assert np.all(middle <= ends + 1e-18)  # rounding of 1e-2 J


def test_radial_pieces_of_the_spline() -> None:
    """dong2019, eq. (27): K R; F_m; F_m + K (R - S_2), continuous because S_1 = F_m / K."""
    many, start = groups((SPLINE, 2)), FRICTION / K
    assert SPLINE.slip_start == start
    for rho, expected, state in (
        (0.5 * start, 0.5 * FRICTION, "stick"),
        (start + 0.5 * CLEARANCE, FRICTION, "slip"),
        (start + CLEARANCE + 3e-6, FRICTION + 3e-6 * K, "stop"),
    ):
        delta = rho * np.array([0.6, -0.8])
        # a product of three numbers
        np.testing.assert_allclose(many.force(delta), expected * np.array([0.6, -0.8]), rtol=1e-13)
        assert STATES[int(many.state(delta)[0])] == state
    for law in (PLAY, ROLLING):
        assert STATES[int(groups((law, 2)).state(np.array([1e-5, 0.0]))[0])] == "play"
        assert not groups((law, 2)).force(np.array([1e-5, 1e-5])).any()


@given(st.floats(1.0, 3.0), st.floats(1.0, 1e6), st.floats(1e5, 1e10))
def test_stiffness_is_the_tangent_at_the_load(exponent: float, load: float, stiffness: float) -> None:
    law = Law(stiffness=stiffness, exponent=exponent, load=load, clearance=1e-5)
    many = groups((law, 1))
    delta = np.array([(load / law.coefficient) ** (1 / exponent) + 1e-5])
    stretch = delta[0] - 1e-5
    # where the stretch is small beside the clearance its difference has lost digits
    lost = 1e-12 + 4e-16 * exponent * 1e-5 / stretch
    np.testing.assert_allclose(many.force(delta), [load], rtol=lost)
    np.testing.assert_allclose(many.tangent(delta), [[stiffness]], rtol=lost)


def test_limits_of_friction() -> None:
    """None: play; without end: the spring alone."""
    delta = places(np.random.default_rng(6), 50, 2)
    none = groups((Law(stiffness=K, clearance=CLEARANCE, friction=1e-12), 2))
    np.testing.assert_allclose(none.force(delta), groups((PLAY, 2)).force(delta), atol=2e-12)
    endless = groups((Law(stiffness=K, clearance=CLEARANCE, friction=np.inf), 2))
    np.testing.assert_allclose(endless.force(delta), K * delta, rtol=1e-15)
    np.testing.assert_allclose(endless.tangent(delta), np.tile(K * np.eye(2), (50, 1, 1)), atol=1e-8 * K)
    assert np.all(np.isfinite(endless.potential(delta)))


@pytest.mark.parametrize("rows", [1, 2])
def test_slider_is_where_its_energy_is_least(rows: int) -> None:
    rng = np.random.default_rng(8)
    many = groups((COULOMB, rows))
    delta, anchor = places(rng, 2000, rows), anchors(rng, 2000, many)
    slider = many.slide(delta, anchor)
    assert np.all(many.rows.size(slider) <= CLEARANCE * (1 + 2e-12))

    def energy(s: Array) -> Array:
        spring = K / 2 * np.sum((delta - s) ** 2, axis=1)
        return np.asarray(spring + FRICTION * np.linalg.norm(s - anchor, axis=1))

    for _ in range(20):
        trial = slider + rng.normal(size=slider.shape) * 10 ** rng.uniform(-12, -5, size=(2000, 1))
        trial *= np.minimum(1.0, CLEARANCE / np.linalg.norm(trial, axis=1))[:, None]
        assert np.all(energy(slider) <= energy(trial) * (1 + 1e-13))  # rounding of the sums
    states = set(many.state(delta, anchor).ravel().tolist())
    assert states == {1, 2, 3}  # stick, slip and stop all occur


def test_coulomb_follows_the_radial_law_on_the_way_out_and_sticks_on_the_way_back() -> None:
    many, plain = groups((COULOMB, 2)), groups((SPLINE, 2))
    way = np.outer(np.linspace(0, 4e-5, 41), [0.6, 0.8])
    slider = np.zeros(2)
    for here in way[1:]:
        np.testing.assert_allclose(many.force(here, slider), plain.force(here), atol=1e-9 * FRICTION)
        slider = many.slide(here, slider)
    back = way[-1] - 1e-6 * np.array([0.6, 0.8])
    pulled = plain.force(way[-1]) - K * 1e-6 * np.array([0.6, 0.8])
    np.testing.assert_allclose(many.force(back, slider), pulled, rtol=1e-12)
    home = many.force(np.zeros(2), slider)
    np.testing.assert_allclose(np.linalg.norm(home), FRICTION, rtol=1e-12)  # held back by friction where the law has 0


def test_names_of_laws() -> None:
    assert [law.kind for law in ALL] == [
        "play",
        "rolling elements with play",
        "rolling elements",
        "holonomic spline",
        "coulomb spline",
    ]
    assert Law(stiffness=K).kind == "linear"
