"""The kernel along the face: symmetric, positive, whole; its operator, its limits, its decay length."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Legendre, Polynomial
from numpy.typing import NDArray

from epicyclic.teeth.compliance import face_coupling, face_decay

Array = NDArray[np.float64]

BENDING = 0.6  # kappa of the kernel


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


def by_ritz(zeta: Array, width: float, decay: float, lengths: Array, count: int = 60) -> Array:
    """Means (n, n) [1/m] of Green's function of kappa^4 l^4 D^4 - l^2 D^2 + 1 by Legendre polynomials.

    The energy, u^2, l^2 times the square of the slope and kappa^4 l^4 times that of the curvature, has free ends as its
    natural conditions.
    """
    x, weight = np.polynomial.legendre.leggauss(count)
    shapes = [Legendre.basis(n, domain=[-width / 2, width / 2]) for n in range(count)]
    energy = np.zeros((count, count))
    for order, scale in ((0, 1.0), (1, decay**2), (2, (BENDING * decay) ** 4)):
        values = np.array([(f.deriv(order) if order else f)(0.5 * width * x) for f in shapes])
        energy += scale * (values * weight * 0.5 * width) @ values.T
    whole = [f.integ() for f in shapes]
    means = np.array([(f(zeta + lengths / 2) - f(zeta - lengths / 2)) / lengths for f in whole])
    return np.asarray(means.T @ np.linalg.solve(energy, means))


@pytest.mark.parametrize("decay", [3e-3, 7e-3, 40e-3, 190e-3])
def test_against_the_energy(decay: float) -> None:
    # both routes share the operator and nothing else; 60 polynomials are converged to 1e-5 of the largest entry
    zeta, lengths = np.array([-16e-3, 2e-3, 12e-3, 19.5e-3]), np.array([2e-3, 6e-3, 3e-3, 1e-3])
    ritz = by_ritz(zeta, 40e-3, decay, lengths)
    np.testing.assert_allclose(face_coupling(zeta, 40e-3, decay, lengths), ritz, rtol=0, atol=1e-5 * ritz.max())


def test_narrow_face_is_rigid() -> None:
    # a block that only tilts, u = a + b zeta under the energy of u^2 and lambda^2 b^2; below a fifth lambda is limited
    zeta, lengths = segments(1e-3, 6)
    for decay in (4e-3, 6e-3, 1.0):
        limited = min(decay, 5e-3)
        tilt = 12 / (1e-9 * (1 + 12 * (limited / 1e-3) ** 2))
        block = 1e3 + tilt * np.outer(zeta, zeta)
        np.testing.assert_allclose(face_coupling(zeta, 1e-3, decay, lengths), block, rtol=2e-4)


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
    np.testing.assert_allclose(points, small, rtol=1e-7)  # the kernel is smooth: second order in the length
    long = face_coupling(zeta, 30e-3, 1e-5, lengths)  # nothing reaches the neighbour, and nothing overflows
    np.testing.assert_allclose(np.diag(long) * lengths, 1.0, atol=0.012)  # 1 - lambda/l inside


def test_own_mean_falls_with_the_length() -> None:
    # across the length at which a series takes over; a jump would show as a rise
    places = np.geomspace(1e-7, 1e-3, 41)
    values = [float(face_coupling(np.zeros(1), 30e-3, 6e-3, np.array([x]))[0, 0]) for x in places]
    assert np.all(np.diff(values) < 1e-12 * values[0])


def test_decay_of_a_thin_plate() -> None:
    # Energy of a cantilever plate that deflects over its height like a beam under an end load, w = phi(x) u(z): the
    # squares of w_xx, w_zz, 2 (1 - nu) that of w_xz, and 2 nu w_xx w_zz.
    phi, poisson = Polynomial([0, 0, 1.5, -0.5]), 0.3

    def over_height(f: Polynomial) -> float:
        return float(f.integ()(1.0))

    bending = over_height(phi.deriv(2) ** 2)
    twist = 2 * (1 - poisson) * over_height(phi.deriv() ** 2) - 2 * poisson * over_height(phi * phi.deriv(2))
    decay = math.sqrt(twist / bending)
    assert decay == pytest.approx(0.71, abs=0.005)
    assert (over_height(phi**2) / bending) ** 0.25 / decay == pytest.approx(0.75, abs=0.005)
    # a tooth as thick as high, on a body as deep: not far from the plate
    assert face_decay(8e-3, 8e-3, 8e-3, 1.0) == pytest.approx(decay * 8e-3, rel=0.1)


@pytest.mark.parametrize(("ratio", "share"), [(1.0, 0.141), (2.0, 0.229), (5.0, 0.291), (10.0, 0.312)])
def test_decay_goes_with_the_torsion_of_a_bar(ratio: float, share: float) -> None:
    # J = share b t^3 of a rectangle, as tabulated in any book on strength of materials
    wide, here = (face_decay(8e-3, 6e-3, 10e-3, width) for width in (6e3, 6e-3 * ratio))
    assert (here / wide) ** 2 == pytest.approx(3 * share, rel=3e-3)
    # of a face narrower than thick the sides change places
    assert face_decay(8e-3, 6e-3, 10e-3, 6e-3 / ratio) == pytest.approx(here / ratio, rel=1e-12)
