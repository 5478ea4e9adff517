"""Force over deflection: curves through given points, and the table of a mesh made of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from epicyclic.system.flank_laws import TabulatedLaw
from epicyclic.teeth.mesh_stiffness import ContactTable, ForceCurve, force_curve, given_table

Array = NDArray[np.float64]
UM, KN = 1e-6, 1e3
DEFLECTION = np.array([0.0, 2, 5, 9, 14, 20]) * UM


def phase_curves(count: int) -> tuple[ForceCurve, ...]:
    """Curves at common deflections whose first touch, stiffness and bend differ from phase to phase."""
    found = []
    for phase in np.arange(count) / count:
        pressed = np.maximum(DEFLECTION - (2 + 2 * np.cos(2 * np.pi * phase)) * UM, 0.0)
        force = 4e8 * (1 + 0.2 * np.sin(2 * np.pi * phase)) * pressed * (1 + 0.3 * pressed / (20 * UM))
        found.append(force_curve(DEFLECTION.tolist(), force.tolist()))
    return tuple(found)


def law_of(table: ContactTable) -> TabulatedLaw:
    """The law of one row whose phase is sigma itself."""
    one = np.ones(1)
    return TabulatedLaw(
        tone=np.zeros(1, np.int64),
        lead=np.zeros(1),
        sense=one,
        force=table.force,
        gap=table.approach,
        slope=table.slope,
        load=np.full(1, np.nan),
        last=table.last,
    )


@pytest.mark.parametrize("points", [2, 3, 6])
def test_a_straight_table_is_the_linear_law(points: int) -> None:
    k, last = 5e8, 10 * UM
    x = np.linspace(0, last, points) ** 2 / last  # uneven
    table = given_table((force_curve(x.tolist(), (k * x).tolist()),), 3 * KN)
    assert table.stiffness == pytest.approx(k, rel=1e-14)
    assert table.variation.size == 0
    assert not table.error.any()
    at = law_of(table).at(np.zeros((1, 1)))
    delta = np.linspace(-last, 3 * last, 41)[:, None, None]
    force, tangent = at.evaluate(delta)
    np.testing.assert_allclose(force, k * np.maximum(delta, 0), rtol=1e-13, atol=1e-12 * k * last)
    np.testing.assert_allclose(tangent, np.where(delta > 0, k, 0.0), rtol=1e-13)  # the slope k from first touch on
    assert bool(at.constant(np.array([last / 9]), np.array([3 * last]))[0])


def test_curves_of_common_deflections_are_kept_by_the_table_to_its_accuracy() -> None:
    curves = phase_curves(24)
    table = given_table(curves, 2.5 * KN)
    at = law_of(table).at(np.arange(24)[:, None] / 24)
    largest, worst = max(curve.force[-1] for curve in curves), 0.0
    for phase, curve in enumerate(curves):
        delta = np.linspace(curve.deflection[0], curve.deflection[-1], 999)
        # the library's interpolant, not the cubics of the module
        expected = PchipInterpolator(curve.deflection, curve.force)(delta)
        found = at.instants([phase]).evaluate(delta[:, None, None])[0].ravel()
        worst = max(worst, float(np.abs(found - expected).max()) / largest)
    assert len(table.force) < 40  # of 109 forces that differ
    assert 1e-9 < worst < 1e-4


def test_few_points_make_an_exact_table() -> None:
    curves = phase_curves(3)
    table = given_table(curves, 2.5 * KN)
    at = law_of(table).at(np.arange(3)[:, None] / 3)
    for phase, curve in enumerate(curves):
        delta = np.linspace(curve.deflection[0], curve.deflection[-1], 999)
        found = at.instants([phase]).evaluate(delta[:, None, None])[0].ravel()
        expected = PchipInterpolator(curve.deflection, curve.force)(delta)
        np.testing.assert_allclose(found, expected, atol=1e-12 * table.force[-1])


def test_behind_the_weakest_phase_there_is_no_data() -> None:
    curves = phase_curves(4)
    table = given_table(curves, 2.5 * KN)
    assert table.force[-1] == max(curve.force[-1] for curve in curves)
    assert law_of(table).end == min(curve.force[-1] for curve in curves) < table.force[-1]
    weakest = min(range(4), key=lambda i: curves[i].force[-1])
    curve = curves[weakest]
    beyond = curve.deflection[-1] + np.array([0.0, 1, 2]) * UM
    force = law_of(table).at(np.array([[weakest / 4]])).evaluate(beyond[:, None, None])[0].ravel()
    np.testing.assert_allclose(np.diff(force) / UM, curve.slope[-1], rtol=1e-9)  # along its last tangent


def test_the_linear_model_has_tangent_and_approach_of_the_load() -> None:
    curves, load = phase_curves(7), 2.5 * KN
    table = given_table(curves, load)
    sigma = np.arange(7) / 7
    at = law_of(table).at(sigma[:, None])
    place = np.array([curve.inverse([load])[0][0] for curve in curves])
    h = 1e-10
    up, down = (at.evaluate(place[:, None] + step)[0].ravel() for step in (h, -h))
    orders = np.arange(1, len(table.variation) + 1)
    tangent = table.stiffness * (1 + (np.exp(2j * np.pi * np.outer(sigma, orders)) @ table.variation).real)
    np.testing.assert_allclose((up - down) / (2 * h), tangent, rtol=1e-6)  # second differences over 1e-10 m
    error = (np.exp(2j * np.pi * np.outer(sigma, np.arange(len(table.error)))) @ table.error).real
    np.testing.assert_allclose(tangent * (place - error), load, rtol=1e-12)  # k (delta - e) = F at its approach


def test_first_touch_is_the_last_zero() -> None:
    curve = force_curve([0.0, 1e-6, 2e-6, 3e-6], [0.0, 0.0, 0.0, 10.0])
    assert curve.deflection == (2e-6, 3e-6)
    assert curve.force == (0.0, 10.0)


def test_data_that_flatten_go_on_rising() -> None:
    curve = force_curve([0.0, 1e-6, 2e-6], [0.0, 100.0, 101.0])
    assert PchipInterpolator([0, 1, 2], [0, 100, 101]).derivative()(2.0) == 0
    assert curve.slope[-1] == pytest.approx(0.5 * 1e6)


@given(
    st.lists(st.tuples(st.floats(0.01, 10), st.floats(0.01, 10)), min_size=1, max_size=8),
    st.lists(st.floats(0, 1.5), min_size=1, max_size=5),
)
def test_the_inverse_leads_back(steps: list[tuple[float, float]], parts: list[float]) -> None:
    x, f = (np.concatenate([[0.0], np.cumsum(values)]) for values in zip(*steps, strict=True))
    curve = force_curve(x.tolist(), f.tolist())
    force = np.array(parts) * f[-1]
    place, slope = curve.inverse(force)
    inside = force <= f[-1]
    if len(x) > 2:  # the last slope may differ from the library's
        inside &= force <= f[-2]
    np.testing.assert_allclose(PchipInterpolator(x, f)(place[inside]), force[inside], rtol=1e-9, atol=1e-12)
    assert (slope[force > 0] > 0).all()
