"""A ring of steel by finite elements: what the reader, the reduction and D make of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import reduced_ring
import scipy.linalg

from epicyclic.bodies.files import read_body
from epicyclic.bodies.joined_body import axisymmetric, turning_with_frame
from epicyclic.bodies.reduced_body import Array, BodyFacts, ReducedBody, checked, elastic_modes

Checked = tuple[ReducedBody, BodyFacts]
IN_PLANE = [316.7216, 892.9311, 1704.2639, 2740.2215, 3992.3191]  # n = 2 to 6 [Hz], by an independent solution


def frequencies(body: ReducedBody) -> Array:
    """All frequencies [Hz] of dense matrices."""
    squares = scipy.linalg.eigh(body.K, body.M, eigvals_only=True)
    return np.asarray(np.sqrt(np.abs(squares)) / (2 * math.pi))


def in_plane(body: ReducedBody, facts: BodyFacts, count: int) -> tuple[Array, Array]:
    """Frequencies [Hz] and modes of the elastic ones that hardly move along z."""
    squares, modes = elastic_modes(body, facts.rigid, count, "ring")
    axial = np.sum(modes[body.dof_dir == 3] ** 2, axis=0) / np.sum(modes[body.dof_dir > 0] ** 2, axis=0)
    return np.sqrt(squares[axial < 0.01]) / (2 * math.pi), modes[:, axial < 0.01]


def test_the_kept_ring(kept: Checked) -> None:
    body, facts = kept
    assert body.M.shape == (84, 84)
    assert reduced_ring.KEPT.stat().st_size < 100_000
    assert facts.mass == pytest.approx(2.349999, abs=1e-6)
    # of a ring with rectangular section, but for the chords of the elements
    polar = reduced_ring.MASS * (reduced_ring.RADIUS**2 + reduced_ring.HEIGHT**2 / 4)
    assert facts.inertia[2, 2] == pytest.approx(polar, rel=1e-5)
    assert np.abs(facts.centre).max() < 1e-12
    assert np.sum(frequencies(body) < 1) == 6
    assert facts.remarks == ()
    for want in IN_PLANE:  # what 60 modes leave
        assert np.min(np.abs(frequencies(body) / want - 1)) < 1.7e-3
    assert facts.frequencies[0] == pytest.approx(IN_PLANE[0], rel=1e-4)


def test_calculix_from_mesh_to_reduced_ring(calculix: tuple[Path, Checked], kept: Checked) -> None:
    _, (body, facts) = calculix
    assert body.M.shape == (1728, 1728)
    assert facts.mass == pytest.approx(2.349999, abs=1e-6)
    assert facts.remarks == ()
    found, _ = in_plane(body, facts, 24)
    assert found[0:10:2] == pytest.approx(IN_PLANE, abs=1e-3)
    whole = np.sqrt(elastic_modes(body, facts.rigid, 20, "ring")[0]) / (2 * math.pi)
    for modes, worst in ((10, 0.588), (30, 0.0369), (60, 0.00166)):
        reduced = reduced_ring.reduced_ring(body, modes)
        assert np.max(frequencies(reduced)[6:26] / whole - 1) == pytest.approx(worst, rel=5e-3)
    assert frequencies(reduced)[6:] == pytest.approx(frequencies(kept[0])[6:], rel=1e-8)


def test_hollow_elements_are_said(tmp_path: Path, calculix: tuple[Path, Checked]) -> None:
    body, facts = read_body(reduced_ring.solved(tmp_path, "C3D20R"), units="kg m s")
    assert facts.remarks == (
        f"{body.source}: M: 588 of 1728 motions have no mass: lumped rotations, or hollow elements",
    )


def test_coriolis_terms_of_a_ring_that_turns_with_its_frame(calculix: tuple[Path, Checked]) -> None:
    _, (body, facts) = calculix
    turning = turning_with_frame(body, "ring")
    _, modes = in_plane(body, facts, 24)
    half = [abs(modes[:, k] @ (turning.G1 @ modes[:, k + 1])) / 2 for k in (0, 2, 4, 6)]
    assert half == pytest.approx([0.79879, 0.59722, 0.46646, 0.37934], abs=5e-6)  # 2n/(n^2+1) of a thin ring


def test_the_pattern_of_a_held_ring(calculix: tuple[Path, Checked]) -> None:
    _, (ring, _) = calculix
    nodes = ring.node_id[np.hypot(ring.node_xyz[:, 0], ring.node_xyz[:, 1]) < reduced_ring.RADIUS - 1e-3]
    body, facts = checked(axisymmetric(ring, 48, 46, tuple(nodes.tolist()), "ring"), "ring")
    assert len(body.M) == 46
    assert facts.mass == pytest.approx(2.349999, abs=1e-6)
    assert body.D is not None
    waves, pattern = np.linalg.eigh(1j * body.D)
    assert np.abs(waves - np.round(waves)).max() < 1e-10
    assert set(np.abs(np.round(waves)).astype(int)) == set(range(11))
    # held, seen from a frame of 40 Hz: each wave is moved by its number
    nu, stiffness, zero = -2 * math.pi * 40, pattern.conj().T @ body.K @ pattern, np.zeros_like(body.K)
    own = np.concatenate(
        [
            np.abs(sign * np.sqrt(np.abs(np.linalg.eigvalsh(stiffness[np.ix_(same, same)]))) / (2 * math.pi) + 40 * n)
            for n in range(-10, 11)
            for same in [np.flatnonzero(np.round(waves) == n)]
            for sign in (-1, 1)
        ]
    )
    first_order = np.block(
        [[zero, np.eye(46)], [-(body.K + nu**2 * body.D @ body.D), -2 * nu * body.D]],
    )
    seen = np.abs(np.linalg.eigvals(first_order).imag) / (2 * math.pi)
    elastic = np.sort(own) > 100  # rigid motions are defective roots
    assert np.sort(seen)[elastic] == pytest.approx(np.sort(own)[elastic], abs=1e-9)
    assert_moves_along(body, ring, sectors=7)


def assert_moves_along(body: ReducedBody, ring: ReducedBody, *, sectors: int) -> None:
    """The motion of a point some sectors ahead by D is that of the node there."""
    assert body.shape is not None
    assert body.shape_node is not None
    assert body.D is not None
    angle = 2 * math.pi * sectors / 48
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    places = body.places(body.shape_node[::3])
    here = body.shape[0:3]
    ahead = int(np.argmin(np.linalg.norm(places - turn @ places[0], axis=1)))
    there = turn.T @ body.shape[3 * ahead : 3 * ahead + 3]
    assert np.abs(here @ scipy.linalg.expm(angle * body.D) - there).max() < 1e-9 * np.abs(there).max()
    assert np.abs(here - there).max() > 0.1 * np.abs(there).max()
