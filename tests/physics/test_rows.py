"""Rows of meshes and pins against the written-out table, rigid motions, mirror images, the helicoid itself."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.system.assembly import assemble
from epicyclic.system.structure import structure_of
from epicyclic.system.system import System
from epicyclic.train.resolution import load
from epicyclic.train.train import Train

Array = NDArray[np.float64]
Maker = Callable[..., Train]

# Rows are a handful of products of numbers of order one: rounding only.
EXACT = 1e-15


def written_out(
    d: int, h: int, alpha: float, helix: float, zeta: float, radii: tuple[float, float], ring: bool
) -> Array:
    """The two 6-vectors of a sun-planet or planet-ring row in branch axes; d and h of the sun."""
    S, C, c, s = math.sin(alpha), math.cos(alpha), math.cos(helix), math.sin(helix)
    ra, rb = radii
    if not ring:
        first = [c * S, d * c * C, -h * d * s, -zeta * d * c * C, zeta * c * S + ra * h * d * s, d * ra * C * c]
        second = [-c * S, -d * c * C, h * d * s, zeta * d * c * C, -zeta * c * S + rb * h * d * s, d * rb * C * c]
    else:
        first = [c * S, -d * c * C, -h * d * s, zeta * d * c * C, zeta * c * S + ra * h * d * s, -d * ra * C * c]
        second = [-c * S, d * c * C, h * d * s, -zeta * d * c * C, -zeta * c * S - rb * h * d * s, d * rb * C * c]
    return np.array([first, second])


def turned(row: Array, angle: float) -> Array:
    """Branch axes -> frame axes."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z, rx, ry, rz = row
    return np.array([c * x - s * y, s * x + c * y, z, c * rx - s * ry, s * rx + c * ry, rz])


@pytest.mark.parametrize("flank", [1, -1])
@pytest.mark.parametrize("hand", [1, -1])
def test_rows_equal_the_written_out_table(hand_built: Maker, flank: int, hand: int) -> None:
    train = hand_built(flank=flank, hand=hand, angles=(0.3, 2.0, 4.4), stations=(0.017,))
    structure = structure_of(train)
    for row, mesh in zip(structure.mesh, train.meshes, strict=True):
        radii = mesh.radius_a, mesh.radius_b
        expected = written_out(flank, hand, mesh.pressure_angle, mesh.base_helix, mesh.station, radii, mesh.internal)
        a, b = structure.index[mesh.a], structure.index[mesh.b]
        row_a, row_b = row[6 * a : 6 * a + 6], row[6 * b : 6 * b + 6]
        central = expected[1 if mesh.internal else 0]
        planet = expected[0 if mesh.internal else 1]
        assert (row_b if mesh.internal else row_a) == pytest.approx(turned(central, mesh.direction), abs=EXACT)
        assert (row_a if mesh.internal else row_b) == pytest.approx(planet, abs=EXACT)


def test_moment_arm_is_the_base_radius_in_the_plane_of_action(hand_built: Maker) -> None:
    train = hand_built()
    structure = structure_of(train)
    for row, mesh in zip(structure.mesh, train.meshes, strict=True):
        for name, radius in ((mesh.a, mesh.radius_a), (mesh.b, mesh.radius_b)):
            base = radius * math.cos(mesh.pressure_angle)
            rz = row[6 * structure.index[name] + 5]
            assert abs(rz) == pytest.approx(base * math.cos(mesh.base_helix), abs=EXACT)


def rigid_motion(train: Train, motion: Array) -> Array:
    """Displacement of every body, in its own axes, under one small rigid motion (x y z rx ry rz) of the whole set."""
    parts = []
    for body in train.bodies:
        origin = np.array([*body.centre, body.station])
        move = motion[:3] + np.cross(motion[3:], origin)
        c, s = math.cos(body.angle), math.sin(body.angle)
        turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        parts.append(np.concatenate([turn @ move, turn @ motion[3:]]))
    return np.concatenate(parts)


@pytest.mark.parametrize("direction", range(6))
@pytest.mark.parametrize("flank", [1, -1])
def test_rigid_motions_leave_no_gap_in_meshes_and_pins(hand_built: Maker, direction: int, flank: int) -> None:
    train = hand_built(flank=flank, angles=(0.1, 1.9, 3.6, 5.0), stations=(-0.03, 0.02), pin_station=0.011)
    structure = structure_of(train)
    q = rigid_motion(train, np.eye(6)[direction])
    assert np.abs(structure.mesh @ q).max() < EXACT
    pins = [i for i, row in enumerate(structure.links) if row.second >= 0]
    assert len(pins) == 4 * 5
    assert np.abs(structure.link[pins] @ q).max() < EXACT


def test_swapping_the_two_gears_of_an_external_mesh_gives_the_same_row(hand_built: Maker) -> None:
    train = hand_built(angles=(0.7, 2.8))
    external = tuple(m for m in train.meshes if not m.internal)
    swapped = tuple(
        dataclasses.replace(
            m, a=m.b, b=m.a, direction=m.direction + math.pi, hand=-m.hand, radius_a=m.radius_b, radius_b=m.radius_a
        )
        for m in external
    )
    here = structure_of(dataclasses.replace(train, meshes=external)).mesh
    there = structure_of(dataclasses.replace(train, meshes=swapped)).mesh
    assert np.abs(here - there).max() < EXACT


def test_the_other_flank_turns_all_but_the_radial_part(hand_built: Maker) -> None:
    rows = {d: structure_of(hand_built(flank=d)).mesh for d in (1, -1)}
    sun = slice(0, 6)
    drive, coast = rows[1][0, sun], rows[-1][0, sun]
    assert drive[0] == pytest.approx(coast[0], abs=EXACT)
    assert drive[[1, 2, 5]] == pytest.approx(-coast[[1, 2, 5]], abs=EXACT)
    twice = structure_of(hand_built(flank=-1 * -1)).mesh
    assert np.abs(twice - rows[1]).max() == 0.0


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize("flank", [1, -1])
def test_normal_is_that_of_the_involute_helicoid(hand: int, flank: int, hand_built: Maker) -> None:
    """Differences on the flank surface of gear A: r_b involute turned along z by h tan(beta)/r (base helix)."""
    train = hand_built(hand=hand, flank=flank, angles=(0.0, 2.0), stations=(0.0,))
    mesh = train.meshes[0]
    alpha, helix = mesh.pressure_angle, mesh.base_helix
    base = mesh.radius_a * math.cos(alpha)
    per_length = hand * math.tan(helix) / base  # turn of the tooth trace per axial length

    def flank_point(roll: float, zeta: float) -> Array:
        # Flank that pushes along d t: material lies on the -d side; involute unwinding in the sense of -d.
        turn = -flank * roll + start + per_length * zeta
        radial = np.array([math.cos(turn), math.sin(turn)])
        tangent = np.array([-radial[1], radial[0]])
        xy = base * (radial + flank * roll * tangent)
        return np.array([*xy, zeta])

    roll = math.tan(alpha)
    start = 0.0
    at_pitch = flank_point(roll, 0.0)
    start = -math.atan2(at_pitch[1], at_pitch[0])  # bring the contact to the pitch point on e = x
    assert flank_point(roll, 0.0) == pytest.approx([mesh.radius_a, 0, 0], abs=1e-15)
    step = 1e-6
    along = (flank_point(roll + step, 0.0) - flank_point(roll - step, 0.0)) / (2 * step)
    axial = (flank_point(roll, step) - flank_point(roll, -step)) / (2 * step)
    normal = np.cross(along, axial)
    normal /= np.linalg.norm(normal)
    row = structure_of(train).mesh[0, :3]
    normal *= np.sign(normal @ row)
    # central differences of a smooth curve with step 1e-6: 1e-9 covers truncation and rounding
    assert row == pytest.approx(normal, abs=1e-9)


@pytest.mark.parametrize("ends", [("carrier", "sun"), ("sun", "carrier"), ("carrier", "ring"), ("ring", "sun")])
def test_a_coupling_acts_between_its_ends_in_either_order(ends: tuple[str, str]) -> None:
    """Also where its second end is the first body of the train: a common rotation leaves it unstrained."""
    changes = {"couplings.c": {"between": [f"main.{end}" for end in ends], "rz": "1e5 N m/rad"}}
    train = load("lin1999-n3", changes)
    with_it, without = assemble(train), assemble(load("lin1999-n3"))
    names = with_it.dofs.names
    row = np.zeros(len(names))
    for end, sign in zip(ends, (1.0, -1.0), strict=True):
        row[names.index(f"main/{end}/rz")] = sign
    np.testing.assert_allclose(with_it.K - without.K, 1e5 * np.outer(row, row), atol=1e-6)
    assert train.bodies[0].name == "main/sun"


@pytest.mark.parametrize("flank", [1, -1])
def test_mean_mesh_forces_press_the_teeth(hand_built: Maker, flank: int) -> None:
    train = hand_built(flank=flank, stations=(0.0,))
    system = assemble(train)
    q = np.linalg.lstsq(system.mean_stiffness, system.force, rcond=None)[0]
    force = system.meshes.stiffness * (system.meshes.B.T @ q)
    expected = 100.0 / (3 * 0.05 * math.cos(0.3))
    sun = np.array([not m.internal for m in train.meshes])
    assert force.min() > 0
    # the linear solve of a system of condition 1e9 leaves about 1e-7
    assert force[sun].mean() == pytest.approx(expected, rel=1e-6)


def test_mirror_image_has_the_same_spectrum_and_forces(hand_built: Maker) -> None:
    angles = (0.0, 1.3, 4.0)
    speeds = {"frame_speed": Fraction(500), "sun_speed": Fraction(2000), "planet_speed": Fraction(-900)}
    here = assemble(hand_built(angles=angles, hand=1, flank=1, stations=(0.02,), **speeds))
    mirrored = {key: -value for key, value in speeds.items()}
    there = assemble(hand_built(angles=tuple(-a for a in angles), hand=-1, flank=-1, stations=(0.02,), **mirrored))

    def spectrum(system: System) -> Array:
        n = here.M.shape[0]
        K = system.mean_stiffness + system.Kg
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(here.M, K), -np.linalg.solve(here.M, system.G)]])
        values: Array = np.sort(np.linalg.eigvals(A).imag)
        return values

    def forces(system: System) -> Array:
        q = np.linalg.lstsq(system.mean_stiffness, system.force, rcond=None)[0]
        result: Array = system.meshes.stiffness * (system.meshes.B.T @ q)
        return result

    # eigenvalues up to 1e5 rad/s of a non-symmetric matrix: 1e-9 relative is rounding
    assert spectrum(here) == pytest.approx(spectrum(there), abs=1e-4)
    assert forces(here) == pytest.approx(forces(there), rel=1e-6)
