"""The kernel along the face: symmetric, positive, whole; and its decay against a plate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from epicyclic.tooth_contact.kernel import PLATE_DECAY, face_coupling

Array = NDArray[np.float64]


def segments(width: float, count: int, seed: int = 0) -> tuple[Array, Array]:
    """Middles and lengths of uneven segments that cover a face."""
    lengths = np.random.default_rng(seed).uniform(0.2, 2.0, count)
    lengths *= width / lengths.sum()
    return np.cumsum(lengths) - lengths / 2 - width / 2, lengths


@given(st.floats(1e-3, 1.0), st.floats(1e-3, 1.0), st.integers(2, 30), st.integers(0, 99))
def test_symmetric_positive_and_whole(width: float, decay: float, count: int, seed: int) -> None:
    zeta, lengths = segments(width, count, seed)
    K = face_coupling(zeta, width, decay, lengths)
    assert np.array_equal(K, K.T)
    np.testing.assert_allclose(K @ lengths, 1.0, rtol=0, atol=1e-10)  # uniform load gives the plane value: rounding
    # of unit loads, not of unit forces: eigenvalues lie between 1 (uniform) and those of the finest wave
    scaled = np.sqrt(lengths)[:, None] * K * np.sqrt(lengths)
    values = np.linalg.eigvalsh(scaled)
    assert values[0] > 0
    assert values[-1] == pytest.approx(1.0, abs=1e-9)  # the mean; nothing gives more


def test_against_the_differential_equation() -> None:
    # -lambda^2 u'' + u = p with u' = 0 at the ends, by finite differences on 4000 cells: second order, 1e-6.
    width, decay, cells = 40e-3, 7e-3, 4000
    h = width / cells
    bands = np.full((3, cells), -((decay / h) ** 2))
    bands[1] = 1 + 2 * (decay / h) ** 2
    bands[1, [0, -1]] -= (decay / h) ** 2
    place = (np.arange(cells) + 0.5) * h - width / 2
    zeta, lengths = np.array([-16e-3, 2e-3, 12e-3]), np.array([2e-3, 6e-3, 3e-3])
    on = np.abs(place - zeta[:, None]) < lengths[:, None] / 2
    moved = solve_banded((1, 1), bands, (on / lengths[:, None]).T)
    means = (on / on.sum(axis=1)[:, None]) @ moved
    np.testing.assert_allclose(face_coupling(zeta, width, decay, lengths), means, rtol=2e-6)


def test_refinement_is_of_second_order() -> None:
    # Deflection at mid-face of a parabolic load: the mean over a segment against the place itself.
    width, decay = 50e-3, 8e-3

    def middle(count: int) -> float:
        lengths = np.full(count, width / count)
        zeta = (np.arange(count) + 0.5) * lengths - width / 2
        load = 1 - (2 * zeta / width) ** 2
        return float((face_coupling(zeta, width, decay, lengths) @ (load * lengths))[count // 2])

    fine = middle(2187)
    errors = [abs(middle(count) - fine) for count in (9, 27, 81)]
    orders = np.log(np.array(errors[:-1]) / np.array(errors[1:])) / np.log(3)
    np.testing.assert_allclose(orders, 2.0, atol=0.2)


def test_points_are_the_limit_of_pieces() -> None:
    zeta, lengths = segments(30e-3, 7)
    points = face_coupling(zeta, 30e-3, 6e-3, 0 * lengths)
    small = face_coupling(zeta, 30e-3, 6e-3, 1e-4 * lengths)
    np.testing.assert_allclose(points, small, rtol=1e-4)  # the kernel has a kink: first order in the length
    long = face_coupling(zeta, 30e-3, 1e-5, lengths)  # nothing reaches the neighbour, and nothing overflows
    np.testing.assert_allclose(np.diag(long) * lengths, 1.0, atol=0.012)  # 1 - lambda/l inside


def deflections_of_a_plate(poisson: float) -> tuple[float, float]:
    """w D / (P c^2) under a point load at the free edge of a long cantilever plate, and w D/(p c^3) of a line load.

    Every wave k along the edge is a beam problem of its own, w'''' - 2 k^2 w'' + k^4 w = 0, clamped at 0, no moment and
    a unit shear at 1; the point load is the mean of all waves.
    """

    def wave(k: float) -> float:
        # shapes: exp(k(x - 1)) and exp(-k x), each times 1 and x
        def shape(x: float) -> Array:
            a, b = np.exp(k * (x - 1)), np.exp(-k * x)
            values = [a, x * a, b, x * b]
            first = [k * a, (1 + k * x) * a, -k * b, (1 - k * x) * b]
            second = [k**2 * a, (2 * k + k**2 * x) * a, k**2 * b, (-2 * k + k**2 * x) * b]
            third = [k**3 * a, (3 * k**2 + k**3 * x) * a, -(k**3) * b, (3 * k**2 - k**3 * x) * b]
            return np.array([values, first, second, third])

        clamped, free = shape(0.0), shape(1.0)
        moment = free[2] - poisson * k**2 * free[0]
        shear = -(free[3] - (2 - poisson) * k**2 * free[1])
        found = np.linalg.solve(np.stack([clamped[0], clamped[1], moment, shear]), [0.0, 0.0, 0.0, 1.0])
        return float(free[0] @ found)

    k = np.concatenate([np.linspace(1e-3, 40, 8001)])
    values = np.array([wave(v) for v in k])
    # beyond 40 a wave feels no clamp: 2/((3 - 2 nu - nu^2) k^3), whose integral is 1e-3 of the whole
    tail = 1 / ((3 - 2 * poisson - poisson**2) * k[-1] ** 2)
    return float((np.trapezoid(values, k) + 1e-3 * values[0] + tail) / np.pi), float(values[0])


def test_decay_follows_from_a_cantilever_plate() -> None:
    point, line = deflections_of_a_plate(0.3)
    assert line == pytest.approx(1 / 3, rel=1e-4)  # a plain cantilever; k = 1e-3 is not quite 0
    assert point == pytest.approx(0.16654, rel=1e-4)  # by a finer quadrature of the same waves
    assert point == pytest.approx(0.168, rel=0.01)  # as printed [timoshenko1959], one per cent off
    # G(0) = 1/(2 lambda) of a long face
    assert line / (2 * point) == pytest.approx(PLATE_DECAY, rel=5e-4)
    assert face_coupling(np.array([0.0]), 1.0, 1e-2, np.array([0.0]))[0, 0] == pytest.approx(50.0, rel=1e-12)
