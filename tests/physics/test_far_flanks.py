"""Far flanks: the rows, errors and phases of the tooth side that carries no mean load."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.statics.static import OPEN_RATIO
from epicyclic.system.system import System
from epicyclic.train.resolution import load
from epicyclic.train.train import Mesh, Train

TEETH = {"sun": 22, "planet": 23, "ring": 68}
SHIFTS = {"sun": 0.2, "planet": 0.15}


def document(*, torque: float = 900.0, shifted: bool = False, helix: float = 12.0, slices: int = 1) -> Any:
    """A ring-held set of 22/23/68 teeth; all six directions; equal contact ratios on both flanks come by themselves."""
    mesh: dict[str, Any] = {"backlash": "0.08 mm", "stiffness": "8e8 N/m", "variation": "contact-lines"}
    mesh["slices"] = slices
    stage: dict[str, Any] = {
        "planets": 3,
        "module": "4 mm",
        "helix_angle": f"{helix} deg",
        "face_width": "50 mm",
        "sun": {"teeth": 22, "support": {"radial": 1e8, "z": 1e8, "tilt": 1e6}},
        "planet": {"teeth": 23, "bearing": {"radial": 2e8, "z": 3e8, "tilt": 2e6}},
        "ring": {"teeth": 68, "rim": "30 mm", "support": {"radial": 1e9, "z": 1e9, "tilt": 1e7}},
        "carrier": {
            "mass": 20.0,
            "inertia": 0.2,
            "tilt_inertia": 0.1,
            "support": {"radial": 3e8, "z": 1e8, "tilt": 1e7},
        },
        "meshes": {"sun-planet": dict(mesh), "planet-ring": dict(mesh)},
    }
    if shifted:
        for member, x in SHIFTS.items():
            stage[member]["profile_shift"] = x
    return {
        "format": 2,
        "title": "far flanks",
        "damping": {"modal": "3 %"},
        "stages": {"main": stage},
        "operation": {"held": ["ring"], "speed": {"sun": "900 rpm"}, "torque": {"sun": f"{torque} N m"}},
        "deviations": {"sun": {"run_out": "10 um"}, "planet": {"position": {"y": ["8 um", 0.0, 0.0]}}},
    }


def assembled(**options: Any) -> tuple[Train, System]:
    train = load(document(**options))
    return train, epicyclic.assemble(train)


def test_none_without_backlash() -> None:
    system = epicyclic.assemble(load("ren2021"))
    assert system.far is None
    assert system.far_flanks.mesh.size == 0


@pytest.mark.parametrize("slices", [1, 3])
def test_rows_are_those_of_the_reversed_torque(slices: int) -> None:
    _, system = assembled(slices=slices)
    _, turned = assembled(torque=-900.0, slices=slices)
    np.testing.assert_array_equal(system.far_flanks.mesh, np.arange(len(system.meshes.name)))
    np.testing.assert_allclose(system.far_flanks.B, turned.meshes.B, atol=1e-15)  # the same formula with -d


def test_only_the_radial_part_is_kept() -> None:
    """n turns in all but the radial part: its row is not the opposite of the loaded one."""
    _, system = assembled(helix=0.0)
    names = list(system.dofs.names)
    planet = [names.index(f"main/planet/1/{d}") for d in ("x", "y", "rz")]
    mesh = system.meshes.name.index("main/sun-planet/1")
    near, far = system.meshes.B[planet, mesh], system.far_flanks.B[planet, mesh]
    np.testing.assert_allclose(far, near * [1, -1, -1], atol=1e-15)
    assert abs(near[0]) > 0.1  # the radial part is there


def test_rigid_motion_closes_no_flank() -> None:
    """The train turning as a whole, sun and planets in their ratios and the ring still: a far flank sees nothing."""
    _, system = assembled()
    squared, shapes = np.linalg.eigh(system.mean_stiffness)
    free = shapes[:, squared < 1e-9 * squared.max()]
    assert free.shape[1] == 1
    assert np.abs(system.far_flanks.B.T @ free).max() < 1e-12


def test_a_displaced_gear_enters_by_its_own_normal() -> None:
    """e = -n . E with the far normal, at the same line; the errors of the reversed train are ours."""
    _, system = assembled()
    _, turned = assembled(torque=-900.0)
    there = {line.frequency: line for line in turned.lines}
    assert len(system.lines) >= 2
    for line in system.lines:
        np.testing.assert_allclose(line.far_gap, there[line.frequency].gap, atol=1e-20)
    assert max(np.abs(line.far_gap).max() for line in system.lines) > 1e-6


def sigma_from_teeth(mesh: Mesh, tooth: float, flank: int) -> float:
    """d z_A / (2 pi) [theta_A + d (psi_b,A - inv alpha) - psi_P], psi_b = (pi/2 + 2 x tan alpha_n)/z + inv alpha_t."""
    member = mesh.pair.rpartition(".")[2].split("-")[0]
    z, x = TEETH[member], SHIFTS[member] if mesh.tooth_shift else 0.0
    normal, helix = math.radians(20), math.radians(12)
    transverse = math.atan(math.tan(normal) / math.cos(helix))

    def inv(angle: float) -> float:
        return math.tan(angle) - angle

    half = (math.pi / 2 + 2 * x * math.tan(normal)) / z + inv(transverse)
    return flank * z / math.tau * (tooth + flank * (half - inv(mesh.pressure_angle)) - mesh.direction)


@pytest.mark.parametrize("shifted", [False, True])
def test_phase_by_the_tooth(shifted: bool) -> None:
    """One tooth of gear a has two flanks: where its loaded one is tells where its far one is."""
    train, system = assembled(shifted=shifted)
    far = system.far_flanks
    time = np.linspace(0, 1, 7)
    for i, mesh in enumerate(train.meshes):
        sigma = mesh.sense * float(mesh.lead)  # at t = 0
        zero = sigma_from_teeth(mesh, 0.0, mesh.flank)
        z = TEETH[mesh.pair.rpartition(".")[2].split("-")[0]]
        tooth = (sigma - zero) * math.tau / (mesh.flank * z)
        assert sigma_from_teeth(mesh, tooth, mesh.flank) == pytest.approx(sigma, abs=1e-12)
        mirrored = sigma_from_teeth(mesh, tooth, -mesh.flank)
        place = mirrored - mesh.sense * time
        series = mesh.variation
        wanted = (np.exp(2j * np.pi * np.outer(place, np.arange(1, series.size + 1))) @ series).real
        found = (np.exp(2j * np.pi * np.outer(time, np.arange(1, series.size + 1))) @ far.variation[i]).real
        np.testing.assert_allclose(found, wanted, atol=1e-10)


def test_shift_matters() -> None:
    """Without 2 c the far flank would be out of phase by some degrees."""
    train, _ = assembled(shifted=True)
    assert {round(mesh.tooth_shift, 3) for mesh in train.meshes} != {0.0}
    plain = [replace(mesh, tooth_shift=0.0) for mesh in train.meshes]
    wrong = epicyclic.assemble(replace(train, meshes=tuple(plain)))
    right = epicyclic.assemble(train)
    first, other = right.far_flanks.variation[:, 0], wrong.far_flanks.variation[:, 0]
    assert np.abs(np.angle(first / other)).max() > 0.04  # [rad] of the mesh cycle


def test_leads_are_exact_without_shift() -> None:
    train, _ = assembled()
    assert all(isinstance(mesh.lead, Fraction) and mesh.tooth_shift == 0.0 for mesh in train.meshes)


def at_rest(system: System, *, opened: float = 0.0) -> System:
    """Mean stiffness, so that phases do not matter, and a constant error of all meshes [m]."""
    none = np.zeros((len(system.meshes.name), 0), complex)
    lines = tuple(replace(line, gap=line.gap + opened * (line.frequency == 0)) for line in system.lines)
    assert opened == 0 or any(line.frequency == 0 for line in lines)
    far = None if system.far is None else replace(system.far, variation=none)
    return replace(system, meshes=replace(system.meshes, variation=none), far=far, lines=lines)


@pytest.mark.parametrize("slices", [1, 3])
def test_static_under_reversed_torque_is_that_of_the_train_assembled_for_it(slices: int) -> None:
    """Far flanks of one train, and the loaded flanks of another that is open by the backlash: all six directions."""
    _, system = assembled(slices=slices)
    _, turned = assembled(torque=-900.0, slices=slices)
    np.testing.assert_allclose(turned.force, -system.force, rtol=1e-12)
    ours = epicyclic.static(at_rest(replace(system, force=-system.force)), cycles=5, samples=4)
    closed = at_rest(replace(turned, far=None), opened=8e-5)
    theirs = epicyclic.static(closed, cycles=5, samples=4)
    # two condensations; the load is carried by loops of forces some ten times as large
    np.testing.assert_allclose(ours.mesh_force, -theirs.mesh_force, rtol=1e-7)
    np.testing.assert_allclose(
        ours.link_force, theirs.link_force, rtol=1e-5, atol=1e-6 * np.abs(theirs.link_force).max()
    )
    assert ours.mesh_force.values.max() < 0
    assert (ours.far_share.values == 1).all()
    assert ours.mesh_contact.values.all()
    assert ours.contact_lost.values.all()
    if slices > 1:
        np.testing.assert_allclose(ours.slice_force, -theirs.slice_force, rtol=1e-6)
        np.testing.assert_allclose(ours.face_load_factor, theirs.face_load_factor, rtol=1e-7)
    shared = epicyclic.sharing(at_rest(replace(system, force=-system.force)), method="static", cycles=5, samples=4)
    other = epicyclic.sharing(closed, method="static", cycles=5, samples=4)
    for definition in ("cycle-peak", "simultaneous", "record-peak"):
        np.testing.assert_allclose(
            shared.load_sharing.sel(definition=definition), other.load_sharing.sel(definition=definition), rtol=1e-6
        )


def test_a_slice_may_rest_on_its_far_flank() -> None:
    """A planet that is ahead on its pin and tilted by its helix: some slices push back, others carry or are open."""
    _, system = assembled(slices=3)
    pushed = np.zeros(len(system.meshes.name))
    pushed[:3] = 7e-4  # what both backlashes of the planet and the float of the sun leave, and a little more
    lines = tuple(
        replace(line, gap=line.gap + pushed, far_gap=line.far_gap - pushed) if line.frequency == 0 else line
        for line in system.lines
    )
    result = epicyclic.static(replace(system, lines=lines), cycles=5, samples=8)
    assert 0 < result.far_share.values[0] < 1
    # slices of a planet that floats between both flanks just touch, with forces that are rounding
    on_far = result.slice_force.values[:3] < -OPEN_RATIO * result.slice_force.values.max()
    assert on_far.any()
    np.testing.assert_allclose(result.far_share.values[0], on_far.any(axis=0).mean())
    np.testing.assert_allclose(result.slice_force.values[:3].sum(axis=0), result.mesh_force.values[0], rtol=1e-12)
