"""The thin ring against closed forms, published references and energies by quadrature."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from epicyclic.bodies.elastic_body import Array, ElasticBody, ThinRing, elastic_ring, order_compliances

# the ring of Lin and Parker's set: mass, polar radius, width; its height from the mass of steel
RADIUS = 0.13752 * math.sqrt(3 / 2.35)
LINE_MASS = 2.35 / (math.tau * RADIUS)
WIDTH, DENSITY, MODULUS = 0.0254, 7850.0, 2.07e11
HEIGHT = LINE_MASS / DENSITY / WIDTH
RING = ThinRing(radius=RADIUS, line_mass=LINE_MASS, bending=MODULUS * WIDTH * HEIGHT**3 / 12, orders=6)
STRETCHED = replace(RING, axial=MODULUS * WIDTH * HEIGHT)


def matrices(body: ElasticBody, *, frame: float = 0.0, spin: float = 0.0, mass: float = 2.35) -> list[Array]:
    """M, G, K of a free ring on x, y, rz and its own coordinates; frame, spin [rad/s]."""
    kept = np.r_[0, 1, 5 : 6 + len(body.names)]
    M = body.mass.copy()
    M[[0, 1], [0, 1]], M[5, 5] = mass, mass * RADIUS**2
    K = sum((own.rows.T * own.stiffness) @ own.rows for own in (body.springs, body.foundation))
    G, Kg = body.gyroscopic(frame, spin), body.centrifugal(frame, spin)
    # of a rigid body in a turning frame (docs/conventions.md)
    G[0, 1], G[1, 0] = -2 * mass * frame, 2 * mass * frame
    Kg[[0, 1], [0, 1]] = -mass * frame**2
    return [matrix[np.ix_(kept, kept)] for matrix in (M, G, K + Kg)]


def frequencies(body: ElasticBody, **motion: float) -> Array:
    """Natural frequencies [Hz], rising, all roots; of a turning frame the positive ones of the elastic coordinates."""
    M, G, K = matrices(body, **motion)
    if not motion:
        return np.asarray(np.sqrt(np.abs(scipy.linalg.eigvalsh(K, M))) / math.tau)
    M, G, K = (matrix[3:, 3:] for matrix in (M, G, K))
    state = np.block([[np.zeros_like(M), np.eye(len(M))], [-np.linalg.solve(M, K), -np.linalg.solve(M, G)]])
    found = np.linalg.eigvals(state).imag / math.tau
    return np.sort(found[found > 0])


def test_free_ring_has_the_frequencies_of_the_closed_form() -> None:
    orders = np.arange(2, 7)
    by_hand = orders * (orders**2 - 1) / np.sqrt(orders**2 + 1) * math.sqrt(RING.bending / (LINE_MASS * RADIUS**4))
    found = frequencies(elastic_ring(RING))[3:]
    np.testing.assert_allclose(found, np.repeat(by_hand / math.tau, 2), rtol=1e-12)
    np.testing.assert_allclose(np.array([RING.frequency(int(n)) for n in orders]), by_hand / math.tau, rtol=1e-12)
    printed = [316.557818, 895.360715, 1716.775803, 2776.395718, 4072.913873]  # BODIES, inextensible
    np.testing.assert_allclose(by_hand / math.tau, printed, atol=1e-6)


def test_stretched_ring_breathes_and_is_softer() -> None:
    found = frequencies(elastic_ring(STRETCHED))[3:]
    expected = [316.354030, 894.629817, 1715.238198, 2773.788840, 4068.976505]
    np.testing.assert_allclose(found[:10:2], expected, atol=1e-6)
    breathing = math.sqrt(STRETCHED.axial / LINE_MASS) / RADIUS / math.tau
    assert np.abs(found - breathing).min() < 1e-9 * breathing
    assert breathing == pytest.approx(5259.905190, abs=1e-6)


@pytest.mark.parametrize(
    ("radius", "section", "second_moment", "modulus", "density", "printed"),
    [  # NAFEMS free vibration test 6; Code_Aster SDLS109
        (1.0, math.pi * 0.05**2, math.pi * 0.05**4 / 4, 2e11, 8000.0, [53.382, 150.99, 289.51]),
        (0.369, 0.048 * 0.05, 0.05 * 0.048**3 / 12, 185e9, 7800.0, [211.65, 598.64]),
    ],
)
def test_published_rings(
    radius: Any, section: Any, second_moment: Any, modulus: Any, density: Any, printed: Any
) -> None:
    ring = ThinRing(radius=radius, line_mass=density * section, bending=modulus * second_moment)
    found = [ring.frequency(n) for n in range(2, 2 + len(printed))]
    digits = [len(str(value).partition(".")[2]) for value in printed]
    assert [round(value, places) for value, places in zip(found, digits, strict=True)] == printed


def test_held_ring_from_a_turning_frame_is_shifted_by_its_orders() -> None:
    free = np.array([RING.frequency(n) for n in (2, 3, 4)])
    found = frequencies(elastic_ring(replace(RING, orders=4)), frame=math.tau * 40)
    expected = np.sort(np.concatenate([free - 40 * np.arange(2, 5), free + 40 * np.arange(2, 5)]))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_turning_ring_splits_as_endo_found() -> None:
    spin, frame = 55.0, 40.0
    found = frequencies(elastic_ring(replace(RING, orders=4)), frame=math.tau * frame, spin=math.tau * spin)
    expected = []
    for n in (2, 3, 4):
        w = math.tau * spin
        still = RING.frequency(n) * math.tau
        # waves in the material of a ring that spins (Endo et al. 1984)
        root = math.sqrt(still**2 + (n * (n**2 - 1) / (n**2 + 1)) ** 2 * w**2)
        for sign in (1, -1):
            material = (sign * 2 * n / (n**2 + 1) * w + root) / math.tau
            expected.append(material - sign * n * (spin - frame))
    np.testing.assert_allclose(found, np.sort(expected), atol=1e-9)
    np.testing.assert_allclose(found[:4], [309.364889, 337.364889, 893.038569, 917.038569], atol=1e-6)


def test_matrices_are_those_of_the_energies_by_quadrature() -> None:
    """M, G and K in a frame that turns against the ring, from velocities and strains at points of the centre line."""
    ring, frame, spin = replace(STRETCHED, orders=4, foundation=(3e8, 1e8)), 70.0, 110.0
    body, nu = elastic_ring(ring), spin - frame
    psi = math.tau * np.arange(64) / 64
    weight = math.tau / 64
    columns: dict[str, list[Array]] = {name: [] for name in ("x", "y", "rz", *body.names)}
    zero = np.zeros_like(psi)
    for name in columns:
        n = int(name[1:]) if name[1:].isdigit() else 1
        c, s = np.cos(n * psi), np.sin(n * psi)
        # w, w', w'' and v, v'
        fields = {
            "x": (c, -s, -c, -s, -c),
            "y": (s, c, -s, c, -s),
            "rz": (zero, zero, zero, RADIUS + zero, zero),
            "a": (c, -n * s, -(n**2) * c, -s / max(n, 1), -c * bool(n)),
            "b": (s, n * c, -(n**2) * s, c / max(n, 1), -s),
            "c": (zero, zero, zero, -s, -n * c) if n > 1 else (c, -s, -c, s, c),
            "d": (zero, zero, zero, c, -n * s) if n > 1 else (s, c, -s, -c, s),
        }
        columns[name] = list(fields[name if name in ("x", "y", "rz") else name[0]])
        if name == "a0":
            columns[name] = [1 + zero, zero, zero, zero, zero]
    w, dw, ddw, v, dv = (np.array([columns[name][i] for name in columns]) for i in range(5))
    scale = LINE_MASS * RADIUS * weight

    def product(a: Array, b: Array) -> Array:
        return a @ b.T

    # the velocity is q' + A q: radial w' nu - w_r v, tangential v' nu + w_r w
    radial, tangential = nu * dw - spin * v, nu * dv + spin * w
    M = scale * (product(w, w) + product(v, v))
    coriolis = scale * (product(w, radial) + product(v, tangential))
    stretch, slope, curvature = (dv + w), (dw - v), (dv - ddw)
    tension = LINE_MASS * RADIUS**2 * spin**2
    K = (
        -scale * (product(radial, radial) + product(tangential, tangential))
        + tension / RADIUS * weight * (product(stretch, stretch) + product(slope, slope))
        + ring.axial / RADIUS * weight * product(stretch, stretch)
        + ring.bending / RADIUS**3 * weight * product(curvature, curvature)
        + RADIUS * weight * (3e8 * product(w, w) + 1e8 * product(v, v))
    )
    ours = matrices(body, frame=frame, spin=spin)
    for found, expected in zip(ours, (M, coriolis - coriolis.T, K), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())


def test_foundation_of_an_extensible_and_an_inextensible_ring() -> None:
    held = replace(RING, foundation=(3e8, 1e8), orders=5)
    found = frequencies(elastic_ring(held))
    expected = [1450.733, 1684.109, 1936.013, 2445.497, 3283.956]
    np.testing.assert_allclose(sorted(set(np.round(found, 3)))[1:], expected, atol=1.1e-3)
    breathing = frequencies(elastic_ring(replace(held, axial=STRETCHED.axial)))
    assert np.abs(frequencies(elastic_ring(held)) - 1025.823).min() < 1e-3  # rotation on the tangential springs
    assert np.abs(breathing - math.sqrt((STRETCHED.axial / RADIUS**2 + 3e8) / LINE_MASS) / math.tau).min() < 1e-6


@pytest.mark.parametrize(("count", "printed"), [(2, 0.0743892), (3, 0.0159386), (4, 0.0060793)])
def test_ring_under_equal_radial_loads_has_the_deflection_of_the_tables(count: Any, printed: Any) -> None:
    a = math.pi / count
    closed = ((a + math.sin(a) * math.cos(a)) / (2 * math.sin(a) ** 2) - 1 / a) / 2
    assert closed == pytest.approx(printed, abs=1e-7)
    ring = replace(RING, orders=60)
    # orders that are multiples of the number of loads; each load deflects every place of a load alike
    compliance = order_compliances(ring, (1.0, 0.0), RADIUS)[count::count]
    found = count * compliance.sum() * ring.bending / RADIUS**3
    assert found == pytest.approx(closed, rel=1e-3)
    errors = [
        abs(
            count
            * order_compliances(replace(RING, orders=n), (1.0, 0.0), RADIUS)[count::count].sum()
            * RING.bending
            / RADIUS**3
            / closed
            - 1
        )
        for n in (15, 30, 60)
    ]
    assert all(later < earlier / 6 for earlier, later in pairwise(errors))  # with the third power of the orders


def test_thicker_ring_has_the_frequencies_of_plane_elasticity() -> None:
    """The curved beam is within 1.1 % of plane stress up to h/R = 0.3, with a centre line that stretches or does not.

    Without the joint terms of stretch and bending, and of the static moment, it is off by 0.3, 0.7 and 2.1 %.
    """
    modulus, nu, density, width, radius = 2.07e11, 0.3, 7850.0, 0.02, 0.15
    for ratio, limit in ((0.08, 2e-3), (0.15, 5.5e-3), (0.3, 1.1e-2)):
        height = ratio * radius
        outer, inner = radius + height / 2, radius - height / 2
        area = width * height
        bending = modulus * width * radius**2 * (radius * math.log(outer / inner) - height)
        thick = ThinRing(
            radius=radius,
            line_mass=density * area,
            bending=bending,
            shear=5 / 6 * modulus / (2 * (1 + nu)) * area,
            line_inertia=density * bending / modulus,
        )
        for n in (2, 4, 8):
            exact = plane_annulus(inner, outer, n, modulus, nu, density)
            assert thick.frequency(n) == pytest.approx(exact, rel=limit)
            assert stretching_frequency(replace(thick, axial=modulus * area), n) == pytest.approx(exact, rel=limit)
    assert replace(thick, shear=math.inf, line_inertia=0.0).frequency(8) > 1.5 * exact


def stretching_frequency(ring: ThinRing, n: int) -> float:
    """Lowest natural frequency of order n >= 2 of the free ring [Hz]."""
    body = elastic_ring(ring)
    at = np.ix_(*2 * [[6 + i for i, name in enumerate(body.names) if name[1:] == str(n)]])
    K = np.einsum("pi,p,pj->ij", body.springs.rows, body.springs.stiffness, body.springs.rows)
    return float(math.sqrt(scipy.linalg.eigh(K[at], body.mass[at], eigvals_only=True)[0])) / math.tau


def plane_annulus(inner: float, outer: float, n: int, modulus: float, nu: float, density: float) -> float:
    """Lowest natural frequency of order n of a free annulus in plane stress, by polynomials over the radius."""
    x, weight = np.polynomial.legendre.leggauss(20)
    half = (outer - inner) / 2
    r = (inner + outer) / 2 + half * x
    P = np.polynomial.legendre.legvander(x, 10)
    slope = np.stack([np.polynomial.legendre.legval(x, np.polynomial.legendre.legder(row)) for row in np.eye(11)], 1)
    slope, zero, over = slope / half, np.zeros_like(P), P / r[:, None]
    strain = np.stack([np.hstack([slope, zero]), np.hstack([over, n * over]), np.hstack([-n * over, slope - over])], 1)
    law = modulus / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    motion = np.stack([np.hstack([P, zero]), np.hstack([zero, P])], 1)
    K = np.einsum("q,qia,ij,qjb->ab", weight * half * r, strain, law, strain)
    M = density * np.einsum("q,qia,qib->ab", weight * half * r, motion, motion)
    return math.sqrt(scipy.linalg.eigvalsh(K, M)[0]) / math.tau  # an order of 2 or more has no rigid motion
