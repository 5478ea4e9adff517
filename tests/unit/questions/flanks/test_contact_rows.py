"""Mesh rows from loaded contact: every branch at its own phase, and a slow train without dynamic force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.steady import sweep
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.system.tooth_pairs import ContactHistory, mean_force, pair_of, with_contact_tangent
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.train.train import Mesh, Train

SAMPLES = 24
RELIEF = {"stages.main.planet.flank.tip_relief": {"amount": "12 um", "length": "1 mm"}}


@pytest.fixture(scope="module")
def train() -> Train:
    return epicyclic.load("xu2020", RELIEF)


def history(train: Train, mesh: Mesh) -> ContactHistory:
    phase = np.arange(SAMPLES) / SAMPLES
    force = mean_force(train, mesh)
    one = loaded_contact(pair_of(train, mesh, slices=8), [force], mesh.sense * (phase + float(mesh.lead)))
    return ContactHistory(force=force, approach=one.approach[0], tangent=one.tangent[0])


def series_of(values: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    order = np.arange(1, values.shape[1] + 1)
    phase = np.arange(SAMPLES) / SAMPLES
    turn = np.exp(2j * np.pi * np.outer(order, phase))
    return np.asarray(stiffness[:, None] * (1 + (values @ turn).real))


def gaps(system: System, mesh: int, phase: np.ndarray) -> np.ndarray:
    """Error of one mesh over its cycle."""
    tone = system.tones[0]
    lines = [(line.frequency / tone, line.gap[mesh]) for line in system.lines if "contact" in line.causes]
    assert all(order.denominator == 1 for order, _ in lines)
    return np.asarray(sum((gap * np.exp(2j * np.pi * float(order) * phase)).real for order, gap in lines))


def test_every_branch_has_its_own_phase(train: Train) -> None:
    plain = replace(assemble(train), lines=())
    first = {mesh.name: history(train, mesh) for mesh in train.meshes if mesh.branch == 1}
    system = with_contact_tangent(train, plain, first)
    shown = series_of(system.meshes.variation, system.meshes.stiffness)
    odd = (SAMPLES - 1) // 2
    assert {mesh.sense for mesh in train.meshes} == {-1, 1} or len({mesh.lead for mesh in train.meshes}) > 2
    for i, mesh in enumerate(train.meshes):
        own = history(train, mesh)  # the contact of this branch itself, not that of the first moved to its phase
        error = own.approach - own.force / own.tangent
        for values, mine in ((shown[i], own.tangent), (gaps(system, i, np.arange(SAMPLES) / SAMPLES), error)):
            left, right = (np.fft.rfft(series)[: odd + 1] for series in (values, mine))
            # quarter-cycle leads and 24 samples: the same instants, so the same contact to its tolerance
            np.testing.assert_allclose(left, right, atol=1e-8 * np.abs(right).max())


def test_what_is_not_given_stays_as_it_was(train: Train) -> None:
    plain = assemble(train)
    sun = {m.name: history(train, m) for m in train.meshes if m.branch == 1 and m.pair.endswith("sun-planet")}
    system = with_contact_tangent(train, plain, sun)
    ring = [i for i, mesh in enumerate(train.meshes) if mesh.pair.endswith("planet-ring")]
    np.testing.assert_array_equal(system.meshes.stiffness[ring], plain.meshes.stiffness[ring])
    width = plain.meshes.variation.shape[1]
    np.testing.assert_array_equal(system.meshes.variation[ring][:, :width], plain.meshes.variation[ring])
    assert all(not line.gap[ring].any() for line in system.lines if line.causes == ("contact",))
    frequencies = [line.frequency for line in system.lines]
    assert frequencies == sorted(set(frequencies))


def test_a_slow_pair_has_no_dynamic_force() -> None:
    document = {
        "format": 2,
        "title": "One pair",
        "stages": {
            "main": {
                "module": "4 mm",
                "pressure_angle": "20 deg",
                "face_width": "20 mm",
                "flank": {"tip_relief": {"amount": "12 um", "length": "2 mm"}},
                "pinion": {"kind": "gear", "teeth": 23, "mass": "1 kg", "inertia": "0.001 kg m^2"},
                "wheel": {"kind": "gear", "teeth": 41, "mass": "3 kg", "inertia": "0.01 kg m^2"},
                "meshes": {"pinion-wheel": {}},
            }
        },
        "operation": {"speed": {"pinion": "3000 rpm"}, "torque": {"pinion": "200 N m"}},
        "damping": {"modal": "5 %"},
    }
    train = epicyclic.load(document)
    own = history(train, train.meshes[0])
    system = with_contact_tangent(train, assemble(train), {train.meshes[0].name: own})
    slow = sweep(system, SweepOptions(relative_speed=[2e-4, 4e-4]))
    # what is left is inertia, which falls with the square of the speed but for orders in resonance: none so slow
    assert float(slow.mesh_force_rms.max()) < 1e-4 * own.force
    np.testing.assert_allclose(slow.mesh_force_peak, own.force, rtol=1e-3)
    # the gears move against each other as the loaded transmission error says
    phase = np.arange(2000) / 2000
    order = np.arange(1, system.meshes.variation.shape[1] + 1)
    k = system.meshes.stiffness[0] * (
        1 + (np.exp(2j * np.pi * np.outer(phase, order)) @ system.meshes.variation[0]).real
    )
    way = {"error": np.ptp(own.force / k + gaps(system, 0, phase)), "none": np.ptp(own.force / k)}
    for name, one in (("error", system), ("none", replace(system, lines=()))):
        moved = sweep(one, SweepOptions(relative_speed=[2e-4])).amplitude.sum()
        # torques are constant, so that both gears turn against each other; the solver's grid sees the peaks to 1e-3
        assert 2 * float(moved) == pytest.approx(way[name], rel=2e-3)
    assert abs(way["error"] / way["none"] - 1) > 0.1


def test_what_cannot_be_is_named(train: Train) -> None:
    mesh = train.meshes[0]
    lost = ContactHistory(force=1.0, approach=np.zeros(4), tangent=np.array([1.0, 1.0, 0.0, 1.0]))
    with pytest.raises(ModelError, match="keep contact"):
        with_contact_tangent(train, assemble(train), {mesh.name: lost})
    with pytest.raises(ModelError, match="speed"):
        with_contact_tangent(train, replace(assemble(train), tones=()), {mesh.name: lost})


def test_slices_share_the_tangent_in_step(train: Train) -> None:
    """Summed over the face, the rows of a cut mesh are those of the whole one: nothing of xu2020 tilts."""
    cut = epicyclic.load("xu2020", {"stages.main.meshes.sun-planet.slices": 3})
    whole = epicyclic.load("xu2020")
    history = ContactHistory(
        force=1e3, approach=1e-6 + 1e-7 * np.sin(np.arange(8)), tangent=np.linspace(1e9, 1.07e9, 8)
    )
    own = {whole.meshes[0].name: history, whole.meshes[-1].name: history}
    one, several = (with_contact_tangent(one, assemble(one), own) for one in (whole, cut))
    assert len(several.meshes.name) == len(one.meshes.name) + 2 * 8  # eight meshes of the sun in three rows each
    K = [s.mean_stiffness for s in (one, several)]
    np.testing.assert_allclose(K[1], K[0], atol=1e-12 * np.abs(K[0]).max())
    for order in (0, 3):
        k = [(s.meshes.B * (s.meshes.stiffness * s.meshes.variation[:, order])) @ s.meshes.B.T for s in (one, several)]
        np.testing.assert_allclose(k[1], k[0], atol=1e-12 * np.abs(K[0]).max())
    for before, after in zip(one.lines, several.lines, strict=True):
        forces = [s.meshes.B @ (s.meshes.stiffness * line.gap) for s, line in ((one, before), (several, after))]
        np.testing.assert_allclose(forces[1], forces[0], atol=1e-12 * 1e9)
