"""Mesh stiffness by potential energy in a model file: what is assumed, what follows, what is refused."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError
from epicyclic.teeth.compliance import tooth_compliance
from epicyclic.teeth.form import GearForm
from epicyclic.teeth.gear_pair import MeshedTeeth, section_stiffness
from epicyclic.teeth.geometry import contact_limits
from epicyclic.train.resolution import resolved_document
from epicyclic.train.train import Train

MESHES = "stages.main.meshes"
ENERGY = {f"{MESHES}.sun-planet.stiffness": "energy", f"{MESHES}.planet-ring.stiffness": "energy"}


def drive(**changes: Any) -> Train:
    return epicyclic.load("ren2021", overrides={**ENERGY, **{k.replace("__", "."): v for k, v in changes.items()}})


def noted(train: Train) -> Mapping[str, tuple[object, str]]:
    return {value.path: (value.value, value.origin) for value in train.values}


def test_energy_stands_near_the_standard() -> None:
    ours, standard = drive(), epicyclic.load("ren2021")
    for a, b in zip(ours.meshes, standard.meshes, strict=True):
        assert a.stiffness == pytest.approx(b.stiffness, rel=0.15)  # see test_energy: the band of the standard
        assert np.abs(a.variation).max() > 0.02  # and its own variation
        assert not np.allclose(a.variation, b.variation)


def test_the_whole_is_its_plane_sections_along_the_lines() -> None:
    # Spur teeth and teeth of 25 deg with the same normal section differ by the length of the lines: b/cos beta_b.
    train = drive()
    mesh = train.meshes[0]
    load = noted(train)[f"{mesh.pair}.load_per_length"][0]
    assert isinstance(load, float)
    a, b = (next(body.gear for body in train.bodies if body.name == name) for name in (mesh.a, mesh.b))
    assert a is not None
    assert b is not None
    teeth = [
        tooth_compliance(
            GearForm(
                teeth=gear.teeth,
                module=gear.module,
                pressure_angle=gear.pressure_angle,
                helix_angle=gear.helix_angle,
                profile_shift=gear.profile_shift,
                bore=0.5 * gear.root_radius,
            )
        )
        for gear in (a, b)
    ]
    limits = contact_limits(
        a.base_radius,
        a.tip_radius,
        b.base_radius,
        b.tip_radius,
        working_pressure_angle=mesh.pressure_angle,
        base_pitch=math.tau * a.base_radius / a.teeth,
    )
    meshing = MeshedTeeth(a=teeth[0], b=teeth[1], working_angle=mesh.pressure_angle, limits=limits)
    sections = section_stiffness(meshing, (np.arange(4000) + 0.5) / 4000, load)
    assert a.face_width is not None
    slope = math.sin(a.helix_angle) * math.cos(a.pressure_angle)
    whole = sections.mean() * a.face_width / math.sqrt(1 - slope**2)
    assert mesh.stiffness == pytest.approx(whole, rel=5e-4)  # two steps, each found to 1/4000


def test_what_is_assumed_is_noted() -> None:
    values = noted(drive())
    bore, origin = values["stages.main.sun.bore"]
    root = values["stages.main.sun.root_diameter"][0]
    assert isinstance(bore, float)
    assert isinstance(root, float)
    assert bore == pytest.approx(root / 2, rel=1e-12)
    assert origin == "for the stiffness of the teeth"
    assert values[f"{MESHES}.sun-planet.variation"] == ("energy", "default")
    # F_bt of a branch and side over the mean length of the lines, eps_alpha b/cos beta_b; F_n = F_bt/cos beta_b
    load, origin = values[f"{MESHES}.sun-planet.load_per_length"]
    train = drive()
    torque = abs((train.kinematics.mesh_torque or {})[f"{MESHES}.sun-planet"])
    mesh = next(m for m in train.meshes if m.pair == f"{MESHES}.sun-planet")
    planet = next(b for b in train.bodies if b.name == mesh.b)
    assert planet.gear is not None
    assert planet.gear.face_width is not None
    branches = sum(m.pair == mesh.pair for m in train.meshes)
    normal = torque / branches / planet.gear.base_radius / math.cos(mesh.base_helix)
    length = mesh.contact_ratio * planet.gear.face_width / math.cos(mesh.base_helix)
    assert load == pytest.approx(normal / length, rel=1e-9)
    assert origin == "operation"


def test_a_given_body_counts() -> None:
    # The sun is held at half its root diameter, 366 mm, where nothing is said: a hub of 120 mm winds more, 700 mm less.
    values = [drive(stages__main__sun__bore=bore).meshes[0].stiffness for bore in ("120 mm", "366.043 mm", "700 mm")]
    assert values[0] < values[1] < values[2]
    assert values[1] == pytest.approx(drive().meshes[0].stiffness, rel=1e-5)  # the bore as typed
    soft = drive(stages__main__ring__rim="40 mm").meshes[-1]
    assert soft.stiffness != drive().meshes[-1].stiffness


def test_slices_add_up_to_the_whole() -> None:
    train = drive(**{f"{MESHES}.sun-planet.slices": 5})
    mesh = next(m for m in train.meshes if m.slices)
    order = np.arange(1, len(mesh.variation) + 1)
    lead = np.array([float(piece.lead - mesh.lead) for piece in mesh.slices])
    turned = np.exp(2j * np.pi * mesh.sense * np.outer(order, lead))
    total = sum(piece.variation * turned[:, k] for k, piece in enumerate(mesh.slices)) / len(mesh.slices)
    np.testing.assert_allclose(total, mesh.variation, rtol=0, atol=1e-12)  # rounding


def test_variation_by_energy_of_a_given_mean() -> None:
    train = drive(**{f"{MESHES}.sun-planet.stiffness": "3e9 N/m", f"{MESHES}.sun-planet.variation": "energy"})
    mesh = next(m for m in train.meshes if m.pair == f"{MESHES}.sun-planet")
    assert mesh.stiffness == 3e9
    whole = next(m for m in drive().meshes if m.name == mesh.name)
    np.testing.assert_array_equal(mesh.variation, whole.variation)
    lines = drive(**{f"{MESHES}.sun-planet.variation": "contact-lines"})
    counted = next(m for m in lines.meshes if m.name == mesh.name)
    assert counted.stiffness == whole.stiffness
    np.testing.assert_array_equal(counted.variation, epicyclic.load("ren2021").meshes[0].variation)


def test_written_out_it_is_the_same_train(tmp_path: Any) -> None:
    train = drive(**{f"{MESHES}.sun-planet.slices": 3})
    file = tmp_path / "resolved.toml"
    file.write_text(model_text(resolved_document(train)), encoding="utf-8")
    again = epicyclic.load(str(file))
    for a, b in zip(train.meshes, again.meshes, strict=True):
        assert a.stiffness == pytest.approx(b.stiffness, rel=1e-12)
        np.testing.assert_allclose(a.variation, b.variation, rtol=0, atol=1e-9)
        assert len(a.slices) == len(b.slices)


@pytest.mark.parametrize(
    ("changes", "path", "problem"),
    [
        ({"stages.main.sun.profile_shift": 0.9, "stages.main.planet.profile_shift": -0.9}, ".planet", "undercuts"),
        ({"stages.main.sun.dedendum": 2.2}, ".sun", "pointed before"),
        ({"stages.main.sun.bore": "740 mm"}, ".sun", "no body"),
        ({"stages.main.sun.tip_diameter": "800 mm"}, ".meshes.sun-planet", "contact is lost"),
    ],
)
def test_teeth_that_cannot_be_are_refused(changes: dict[str, Any], path: str, problem: str) -> None:
    with pytest.raises(ModelError, match=problem) as caught:
        epicyclic.load("ren2021", overrides={**ENERGY, **changes})
    assert caught.value.path == f"stages.main{path}"


def test_without_torque_a_usual_load_stands() -> None:
    train = epicyclic.load(
        "lin1999-n4",
        overrides={f"{MESHES}.sun-planet.stiffness": "energy", "stages.main.face_width": "50 mm"},
    )
    assert noted(train)[f"{MESHES}.sun-planet.load_per_length"] == (100e3, "default")


def test_a_resolved_file_keeps_loaded_contact() -> None:
    """Its tangent alone would be another law, and `variation = "contact"` is no key of a file."""
    from epicyclic.train.resolution import load, resolved_document

    train = load("ren2021", overrides={"stages.main.meshes.sun-planet.stiffness": "contact"})
    document = resolved_document(train)
    mesh = document["stages"]["main"]["meshes"]["sun-planet"]
    assert mesh["stiffness"] == "contact"
    assert "variation" not in mesh
    again = load(document)
    assert [m.table is not None for m in again.meshes] == [m.table is not None for m in train.meshes]
    assert any(m.table is not None for m in again.meshes)
