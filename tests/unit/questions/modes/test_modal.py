"""Modes: published tables, closed forms, kinds from the symmetry, energy shares, the quadratic problem."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.questions.modes.campbell import campbell
from epicyclic.questions.modes.eigen import classify_modes, damping_ratios, eigen, neutral_basis, repeated_roots, whirl
from epicyclic.questions.modes.modal import modal
from epicyclic.results.dataset import load_result, save_result
from epicyclic.system.system import System

# Lin & Parker 1999: natural frequencies [Hz]
TABLE = {
    3: {
        "rotational": [0, 1475.7, 1930.3, 2658.3, 7462.8, 11775.3],
        "translational": [743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9],
        "planet": [],
    },
    4: {
        "rotational": [0, 1536.6, 1970.6, 2625.7, 7773.6, 13071.1],
        "translational": [727.0, 1091.0, 1892.8, 2342.5, 7189.9, 10437.6],
        "planet": [1808.2, 5963.8, 6981.7],
    },
    5: {
        "rotational": [0, 1567.4, 2006.1, 2614.8, 8065.4, 14253.1],
        "translational": [710.0, 1072.0, 1888.1, 2425.3, 7382.4, 11172.3],
        "planet": [1808.2, 5963.8, 6981.7],
    },
}
# The print has five figures; for N = 4 two of its values are off by 4e-4 of what the data give.
TOLERANCE = {3: 1e-4, 4: 4e-4, 5: 1e-4}


@pytest.mark.parametrize("N", [3, 4, 5])
def test_lin_parker_frequencies(build: Any, N: int) -> None:
    result = modal(build.planar(N=N).system())
    fold = {"rotational": 1, "translational": 2, "planet": N - 3}
    for kind, printed in TABLE[N].items():
        found = result.frequency.values[result.mode_kind.values == kind]
        np.testing.assert_allclose(found, np.repeat(printed, fold[kind]), rtol=TOLERANCE[N])
    assert result.frequency.values[0] == 0.0


@pytest.mark.parametrize("N", [2, 3, 4, 5, 6, 7, 8])
def test_kinds_and_multiplicities(build: Any, N: int) -> None:
    result = modal(build.planar(N=N).system())
    counted = Counter(zip(result.mode_kind.values, result.multiplicity.values.tolist(), strict=True))
    expected: dict[tuple[str, int], int] = {("rotational", 1): 6, ("translational", 2): 12}
    if N == 2:
        # R = -1 on the lateral coordinates: no pair, each direction for itself
        expected = {("rotational", 1): 6, ("translational", 1): 9}
    if N > 3:
        expected[("planet", N - 3)] = 3 * (N - 3)
    assert counted == expected


def test_without_symmetry_modes_are_mixed(build: Any) -> None:
    result = modal(build.planar(N=3, angles=(0.0, 2.0, 4.1)).system())
    assert set(result.mode_kind.values) == {"mixed"}
    assert set(result.multiplicity.values.tolist()) == {1}


def test_rotational_needs_every_stage_symmetric(build: Any) -> None:
    system: System = build.planar(N=3).system()
    second = replace(system.meshes, stage=("other",) * 3 + ("main",) * 3)
    assert set(modal(replace(system, meshes=second)).mode_kind.values) == {"mixed", "translational"}


def test_two_stages_take_both_operators(build: Any) -> None:
    """Two uncoupled stages: each keeps its own kinds, although the other's operator leaves its modes alone."""
    one, two = build.planar(N=4).system(), build.planar(N=5, mesh=(4e8, 6e8)).system()
    both = build.side_by_side(one, two)
    kinds = Counter(modal(both).mode_kind.values)
    assert kinds == {"rotational": 12, "translational": 24, "planet": 3 + 6}


def test_accidental_coincidence_is_parted(build: Any) -> None:
    """Nothing supported: rotational and translational rigid modes share the frequency 0.

    Each symmetry class of N = 4 has six coordinates a copy (planet class: three) and four rows, two of meshes and
    two of pins: two free motions in the rotational class, two in each direction of the translational one, no others.
    """
    system = build.planar(N=4, lateral=(0.0, 0.0, 0.0, 1e8), torsion=(0.0, 0.0, 0.0)).system()
    result = modal(system)
    rigid = result.frequency.values == 0
    counted = Counter(zip(result.mode_kind.values[rigid], result.multiplicity.values[rigid].tolist(), strict=True))
    assert counted == {("rotational", 2): 2, ("translational", 4): 4}
    R = system.symmetries[0].operator
    turning = result.shape.values[:, :2] / system.dofs.radius[:, None]
    # shapes are normalised to 1, R is exact: rounding
    np.testing.assert_allclose(R @ turning, turning, atol=1e-9 * np.abs(turning).max())


def test_basis_does_not_depend_on_the_solver(build: Any) -> None:
    """Any orthogonal turn of repeated eigenvectors leads to the same basis."""
    system = build.planar(N=5).system()
    modes = eigen(system)
    turned = modes.vectors.copy()
    rng = np.random.default_rng(1)
    for run in repeated_roots(modes.omega_squared):
        size = run.stop - run.start
        turned[:, run] = turned[:, run] @ np.linalg.qr(rng.normal(size=(size, size)))[0]
    first = classify_modes(system, modes.omega_squared, modes.vectors).vectors
    second = classify_modes(system, modes.omega_squared, turned).vectors
    sign = np.sign(np.sum(first * (system.M @ second), axis=0))
    # roots that differ by 5e-4 mix at 1e-12: far below
    np.testing.assert_allclose(first, second * sign, atol=1e-8 * np.abs(first).max())


def test_shapes_have_a_largest_component_of_one(build: Any) -> None:
    result = modal(build.planar(N=4).system())
    shape = result["shape"].values
    # the first of equal components is made exactly 1, others may exceed it by the tie tolerance
    np.testing.assert_allclose(np.max(shape, axis=0), 1.0, atol=1e-6)
    assert np.abs(shape).max() <= 1 + 2e-6
    sun = result.full_shape.sel(body="main/sun", direction="rz").values
    np.testing.assert_array_equal(sun, result["shape"].sel(dof="main/sun/rz").values)


def test_energy_shares(build: Any) -> None:
    system = build.planar(N=4).system()
    result = modal(system)
    strain = result.strain_energy_share.values
    assert np.all(np.isnan(strain[:, 0]))
    # sums and a quotient of doubles
    np.testing.assert_allclose(strain[:, 1:].sum(axis=0), 1.0, rtol=1e-12)
    np.testing.assert_allclose(result.kinetic_energy_share.sum("body").values, 1.0, rtol=1e-12)
    modes = eigen(system)
    rotational = int(np.flatnonzero(result.multiplicity.values == 1)[1])
    phi = modes.vectors[:, rotational]
    share = system.meshes.stiffness[2] * (system.meshes.B[:, 2] @ phi) ** 2 / modes.omega_squared[rotational]
    np.testing.assert_allclose(strain[2, rotational], share, rtol=1e-9)  # eigen solver's rounding
    planet = result.mode_kind.values == "planet"
    central = result.kinetic_energy_share.sel(body=["main/sun", "main/ring", "main/carrier"]).values[:, planet]
    assert np.max(central) < 1e-20  # squares of rounding


def _kahraman(n: int, k1: float, k2: float, mp: float, mc: float, ms: float) -> NDArray[np.float64]:
    """Kahraman 1994: squared frequencies of the torsional set with the ring held, m = I/r^2."""
    L1 = mp * mc * ms
    L2 = -(n * k2 * mp * mc + (k1 + k2) * mc * ms + n * (k1 + k2) * mp * ms)
    L3 = n * k1 * k2 * (n * mp + mc + 4 * ms)
    root = np.sqrt(L2**2 - 4 * L1 * L3)
    # L3 / ... for the lower root: no cancellation
    high = (-L2 + root) / (2 * L1)
    return np.sort(np.array([0.0, *[(k1 + k2) / mp] * (n - 1), high, L3 / L1 / high]))


positive = st.floats(0.2, 5.0)


@settings(max_examples=40, deadline=None)
@given(
    n=st.integers(2, 7),
    k=st.tuples(positive, positive),
    masses=st.tuples(positive, positive, positive),
    radii=st.tuples(positive, positive),
)
def test_kahraman_closed_form(
    build: Any, n: int, k: tuple[float, float], masses: tuple[float, float, float], radii: tuple[float, float]
) -> None:
    """Planets slaved to the carrier in x and y; carrier radius r_bs + r_bp = (pin radius) cos alpha."""
    rs, rp = radii
    alpha = 0.4
    pin = (rs + rp) / np.cos(alpha)
    system = build.planar(
        N=n,
        mass=(1.0, 1.0, 1.0, 0.7),
        inertia=(masses[0], 1.0, masses[1], masses[2]),
        radius=(rs, rs + 2 * rp, pin, rp),
        mesh=(1e8 * k[0], 1e8 * k[1]),
        pressure_angle=alpha,
    ).system()
    T = np.zeros((len(system.M), n + 2))
    T[2, 0] = T[8, 1] = 1.0
    for i in range(n):
        T[9 + 3 * i + 1, 1] = pin
        T[9 + 3 * i + 2, 2 + i] = 1.0
    names = ("main/sun/rz", "main/carrier/rz", *(f"main/planet/{i + 1}/rz" for i in range(n)))
    radius = np.array([rs, rs + rp, *[rp] * n])
    result = modal(build.reduced(system, T, names, radius))
    carrier = (masses[1] * pin**2 + n * 0.7 * pin**2) / (rs + rp) ** 2
    exact = _kahraman(n, 1e8 * k[1], 1e8 * k[0], masses[2], carrier, masses[0])
    # the eigenvalues of a well-conditioned matrix to rounding, relative to the largest
    np.testing.assert_allclose(result.angular_frequency.values**2, exact, rtol=1e-10, atol=1e-12 * exact[-1])


def test_damping_ratio_of_modes(build: Any) -> None:
    system = build.planar(N=3).system()
    assert np.all(np.isnan(modal(system).damping_ratio.values))
    ratio = modal(replace(system, zeta=0.03)).damping_ratio.values
    assert np.isnan(ratio[0])
    np.testing.assert_array_equal(ratio[1:], 0.03)
    # damping proportional to stiffness, meshes included: beta omega / 2
    beta = 2e-6
    proportional = replace(
        system, C=beta * system.K, meshes=replace(system.meshes, damping=beta * system.meshes.stiffness)
    )
    modes = eigen(system)
    expected = beta * modes.omega / 2
    np.testing.assert_allclose(damping_ratios(proportional, modes)[1:], expected[1:], rtol=1e-9)  # eigensolver
    # such damping keeps the real modes: the quadratic problem has exactly these ratios
    damped = modal(proportional, damped=True)
    np.testing.assert_allclose(damped.damping_ratio.values[1:], expected[1:], rtol=1e-7)  # state matrix, 2n
    np.testing.assert_allclose(
        damped.angular_frequency.values[1:], modes.omega[1:] * np.sqrt(1 - expected[1:] ** 2), rtol=1e-9
    )
    assert damped.frequency.values[0] == 0.0
    assert list(damped.mode_kind.values) == list(modal(system).mode_kind.values)


def _turning(system: System, N: int, mass: tuple[float, ...], pin: float, Omega: float) -> System:
    """Gyroscopic and centripetal matrices of the planar set in axes turning at Omega."""
    G, Kg = np.zeros_like(system.M), np.zeros_like(system.M)
    for body in range(N + 3):
        m, i = mass[min(body, 3)], 3 * body
        G[i, i + 1], G[i + 1, i] = -2 * m * Omega, 2 * m * Omega
        Kg[i, i] = Kg[i + 1, i + 1] = -m * Omega**2
        if body > 2:
            # (y - pin rz_carrier)^2: with the centrifugal preload of the pin
            Kg[i + 1, 8] += m * Omega**2 * pin
            Kg[8, i + 1] += m * Omega**2 * pin
            Kg[8, 8] -= m * Omega**2 * pin**2
    return replace(system, G=G, Kg=Kg)


def _companion(system: System, s: float, C: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Eigenvalues of the plain linearisation, upper half plane, by increasing frequency."""
    n = len(system.M)
    K = system.mean_stiffness + s**2 * system.Kg
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-K, -(C + s * system.G)]])
    E = scipy.linalg.block_diag(np.eye(n), system.M)
    mu = scipy.linalg.eigvals(A, E)
    above = mu[mu.imag > 1.0]
    return np.asarray(above[np.argsort(above.imag)], dtype=complex)


def test_gyroscopic_modes(build: Any) -> None:
    planar = build.planar(N=3)
    system = _turning(planar.system(), 3, planar.mass, planar.radius[2], Omega=900.0)
    result = modal(system, relative_speed=1.5)
    # turning the whole train is neutral in turning axes too
    assert result.frequency.values[0] == 0.0
    expected = _companion(system, 1.5, np.zeros_like(system.M))
    # rounding of the badly scaled plain matrix, 1e-10 of the largest frequency
    np.testing.assert_allclose(result.angular_frequency.values[1:], expected.imag, rtol=1e-6)
    # the double roots split, rotational modes stay single
    assert Counter(result.mode_kind.values) == {"rotational": 6, "translational": 12}
    assert set(result.multiplicity.values.tolist()) == {1}
    assert json_warnings(result.attrs["warnings"]) == []


def json_warnings(text: str) -> list[str]:
    import json

    return list(json.loads(text))


def test_neutral_motions_leave_the_state(build: Any) -> None:
    """Turning the whole train is kept apart, so that its double zero is no defective root; so is a differential's."""
    planar = build.planar(N=3)
    for torsion, expected in (((0.0, 1e9, 0.0), 1), ((0.0, 0.0, 0.0), 2)):
        still = build.planar(N=3, torsion=torsion).system()
        system = _turning(still, 3, planar.mass, planar.radius[2], Omega=900.0)
        modes = eigen(system)
        K = np.diag(modes.omega_squared) + modes.vectors.T @ system.Kg @ modes.vectors
        Q, count = neutral_basis(K, np.flatnonzero(modes.omega_squared == 0))
        assert count == expected
        assert np.abs(K @ Q[:, :count]).max() < 1e-9 * 900.0**2  # rounding of the centrifugal terms
        np.testing.assert_allclose(Q.T @ Q, np.eye(len(K)), atol=1e-14)


def test_unsupported_body_in_turning_axes(build: Any) -> None:
    """A free lateral motion is seen at the frame's own frequency: a defective root, kept without failure."""
    planar = build.planar(N=3, lateral=(0.0, 0.0, 0.0, 1e8))
    system = _turning(planar.system(), 3, planar.mass, planar.radius[2], Omega=900.0)
    result = modal(system, relative_speed=1.0)
    away = np.sort(np.abs(result.angular_frequency.values - 900.0))
    # the square root of rounding, times the largest frequency 8e4 rad/s
    assert np.all(away[:2] < 0.5)


def test_damped_gyroscopic_modes(build: Any) -> None:
    planar = build.planar(N=4)
    system = replace(_turning(planar.system(), 4, planar.mass, planar.radius[2], Omega=700.0), zeta=0.02)
    result = whirl(system, relative_speed=1.0, damped=True)
    modes = eigen(system)
    M, V = system.M, modes.vectors
    C = M @ V @ np.diag(2 * 0.02 * modes.omega) @ V.T @ M
    expected = _companion(system, 1.0, C)
    np.testing.assert_allclose(result.mu[1:], expected, rtol=1e-6)  # as above
    assert result.mu[0] == 0
    norm = np.einsum("im,ij,jm->m", result.vectors.conj(), M, result.vectors)
    np.testing.assert_allclose(norm, 1.0, rtol=1e-10)
    residual = (
        (M @ result.vectors) * result.mu**2
        + (C + system.G) @ result.vectors * result.mu
        + (system.mean_stiffness + system.Kg) @ result.vectors
    )
    assert np.abs(residual).max() < 1e-7 * np.abs(system.mean_stiffness @ result.vectors).max()


def test_overdamped_and_unstable_modes(build: Any) -> None:
    system = build.planar(N=3).system()
    heavy = modal(replace(system, zeta=1.2), damped=True)
    np.testing.assert_array_equal(heavy.frequency.values, 0.0)
    np.testing.assert_array_equal(heavy.damping_ratio.values[1:], 1.0)
    growing = modal(replace(system, C=-1e-7 * system.mean_stiffness), damped=True)
    assert np.all(growing.damping_ratio.values[1:] < 0)
    assert "grows" in json_warnings(growing.attrs["warnings"])[0]


def test_campbell(build: Any) -> None:
    from fractions import Fraction

    planar = build.planar(N=3)
    system = _turning(planar.system(), 3, planar.mass, planar.radius[2], Omega=900.0)
    system = replace(system, tones=(Fraction(200),))
    done: list[float] = []
    result = campbell(system, relative_speeds=[0.0, 0.5, 1.0], progress=done.append)
    standstill = modal(system).frequency.values
    np.testing.assert_allclose(result.whirl_frequency.values[0], standstill, rtol=1e-9, atol=1e-6)  # two solvers
    np.testing.assert_allclose(
        np.sort(result.whirl_frequency.values[2]), modal(system, relative_speed=1.0).frequency.values, rtol=1e-9
    )
    np.testing.assert_array_equal(result.mesh_frequency.values, [[0.0, 100.0, 200.0]])
    assert Counter(result.mode_kind.values) == {"rotational": 6, "translational": 12}
    assert done[-1] == 1.0
    with pytest.raises(ModelError, match="finite"):
        campbell(system, relative_speeds=[np.nan])


def test_result_survives_a_file(build: Any, tmp_path: Any) -> None:
    pytest.importorskip("h5py", reason="h5netcdf writes through h5py")
    result = modal(replace(build.planar(N=3).system(), zeta=0.03), damped=True)
    reopened = load_result(save_result(result, tmp_path / "modes.nc"))
    np.testing.assert_array_equal(reopened["shape"].values, result["shape"].values)
    assert reopened.attrs["relative_speed"] == 0.0


def test_errors(build: Any) -> None:
    system = build.planar(N=3).system()
    with pytest.raises(ModelError, match="damping"):
        modal(system, damped=True)
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.inertia"):
        modal(replace(system, missing_inertia=("stages.main.sun.inertia",)))


def test_branches_of_a_repeated_mode_are_in_order_of_frequency(monkeypatch: pytest.MonkeyPatch) -> None:
    """At rest any base of the space of a repeated mode is right: branches that part from it do not hang on the base."""
    import importlib

    import epicyclic
    from epicyclic.questions.modes.eigen import Whirl

    room = importlib.import_module("epicyclic.questions.modes.campbell")
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    speeds = np.linspace(0, 2, 9)
    plain = room.campbell(system, relative_speeds=speeds).whirl_frequency.values
    whirl = room.whirl

    def turned(*arguments: Any, relative_speed: float, **options: Any) -> Whirl:
        here: Whirl = whirl(*arguments, relative_speed=relative_speed, **options)
        pairs = np.flatnonzero(np.abs(np.diff(here.mu.imag)) < 1e-9 * np.abs(here.mu).max())
        if relative_speed:
            return here
        assert pairs.size > 3
        vectors = here.vectors.copy()
        for i in pairs[np.diff(pairs, prepend=-2) > 1]:  # the two exchanged
            vectors[:, [i, i + 1]] = vectors[:, [i + 1, i]]
        return Whirl(mu=here.mu, vectors=vectors)

    monkeypatch.setattr(room, "whirl", turned)
    assert room.campbell(system, relative_speeds=speeds).whirl_frequency.values == pytest.approx(plain, rel=1e-9)
