"""Micro-geometry in model files: read, inherited, listed, refused by path."""

from __future__ import annotations

import math
from typing import Any

import pytest

import epicyclic
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError
from epicyclic.teeth.form import PLAIN, Flank, Relief, Wave
from epicyclic.teeth.mesh_stiffness import ToothPair
from epicyclic.train.resolution import resolved_document
from epicyclic.train.train import Mesh, Train

STAGE = "stages.main"


def teeth(train: Train, name: str) -> ToothPair:
    mesh: Mesh = next(m for m in train.meshes if m.name == name)
    assert mesh.teeth is not None
    return mesh.teeth


def load(**overrides: Any) -> Train:
    return epicyclic.load("ren2021", overrides={f"{STAGE}.{k.replace('__', '.')}": v for k, v in overrides.items()})


def test_no_flank_is_a_plain_one() -> None:
    train = load()
    found = teeth(train, "main/sun-planet/1/left")
    assert found.flank_a == found.flank_b == PLAIN
    sun = next(b for b in train.bodies if b.name == "main/sun").gear
    assert sun is not None
    assert found.form_a.teeth == sun.teeth
    assert found.form_a.root == pytest.approx(sun.root_radius, rel=1e-12)
    assert found.form_a.tip == pytest.approx(sun.tip_radius, rel=1e-12)
    assert found.face_a[1] - found.face_a[0] == pytest.approx(sun.face_width or 0.0)


def test_every_entry_is_read() -> None:
    train = load(
        sun__flank={
            "tip_relief": {"amount": "20 um", "length": "3 mm", "shape": "parabolic"},
            "root_relief": {"amount": "5 um", "length": "1 mm"},
            "end_relief": {"amount": "6 um", "length": "10 mm"},
            "crown": "8 um",
            "slope": "-4 um",
            "profile": {"below_tip": [0, 0.002], "missing": [1e-6, -1e-6]},
            "wave": {"amplitude": "1 um", "order": 3, "phase": "90 deg"},
        }
    )
    assert teeth(train, "main/sun-planet/2/right").flank_a == Flank(
        tip_relief=Relief(amount=20e-6, length=3e-3, shape="parabolic"),
        root_relief=Relief(amount=5e-6, length=1e-3),
        end_relief=Relief(amount=6e-6, length=10e-3),
        crown=8e-6,
        slope=-4e-6,
        profile=((0.0, 1e-6), (2e-3, -1e-6)),
        waves=(Wave(amplitude=1e-6, order=3, phase=math.pi / 2),),
    )
    assert teeth(train, "main/planet-ring/1/left").flank_a == PLAIN


def test_nearest_wins_entry_by_entry() -> None:
    train = load(
        flank={"crown": "3 um", "slope": "2 um"}, sun__flank={"crown": "8 um"}, sun__left={"flank": {"crown": "9 um"}}
    )
    left, right = (teeth(train, f"main/sun-planet/1/{side}") for side in ("left", "right"))
    assert (left.flank_a.crown, right.flank_a.crown) == (9e-6, 8e-6)
    assert (left.flank_a.slope, left.flank_b.crown) == (2e-6, 3e-6)
    origin = {value.path: value for value in train.values}
    assert origin[f"{STAGE}.sun.left.flank.crown"].value == 9e-6
    assert origin[f"{STAGE}.sun.left.flank.crown"].origin == "set"
    assert origin[f"{STAGE}.flank.slope"].unit == "m"


def test_an_override_changes_one_entry() -> None:
    given = {"tip_relief": {"amount": "20 um", "length": "3 mm"}}
    first = load(sun__flank=given)
    again = epicyclic.load(dict(first.document), overrides={f"{STAGE}.sun.flank.tip_relief.amount": "12 um"})
    assert teeth(again, "main/sun-planet/1/left").flank_a.tip_relief == Relief(amount=12e-6, length=3e-3)


def test_the_resolved_file_keeps_the_flanks() -> None:
    train = load(sun__flank={"tip_relief": {"amount": "20 um", "length": "3 mm"}, "crown": "5 um"})
    import tomllib

    again = epicyclic.load(tomllib.loads(model_text(resolved_document(train))))
    for one, other in zip(train.meshes, again.meshes, strict=True):
        assert one.teeth is not None
        assert other.teeth is not None
        assert other.teeth.flank_a == one.teeth.flank_a
        assert other.teeth.limits == pytest.approx(one.teeth.limits, rel=1e-12)


@pytest.mark.parametrize(
    ("key", "value", "path", "words"),
    [
        ("sun__flank", {"tip_relief": {"amount": "20 um"}}, "sun.flank.tip_relief.length", "is missing"),
        ("sun__flank", {"tip_relief": {"length": "2 mm"}}, "sun.flank.tip_relief.amount", "is missing"),
        ("sun__flank", {"tip_relief": {"amount": "20 um", "length": "90 mm"}}, "sun.flank.tip_relief.length", "fit"),
        ("planet__flank", {"root_relief": {"amount": "2 um", "length": "90 mm"}}, "planet.flank.root_relief", "fit"),
        ("ring__flank", {"end_relief": {"amount": "2 um", "length": "120 mm"}}, "ring.flank.end_relief", "fit"),
        ("sun__flank", {"tip_relief": {"amount": "-2 um", "length": "1 mm"}}, "sun.flank.tip_relief.amount", "0"),
        ("sun__flank", {"tip_relief": {"amount": "2 kg", "length": "1 mm"}}, "sun.flank.tip_relief.amount", "kg"),
        ("sun__flank", {"tip_releif": {}}, "sun.flank.tip_releif", "tip_relief"),
        ("sun__flank", {"profile": {"below_tip": [0, 1], "missing": [0]}}, "sun.flank.profile", "heights"),
        ("sun__flank", {"profile": {"below_tip": [1, 0], "missing": [0, 0]}}, "sun.flank.profile", "heights"),
    ],
)
def test_wrong_flanks_are_refused_by_path(key: str, value: Any, path: str, words: str) -> None:
    with pytest.raises(ModelError) as error:
        load(**{key: value})
    assert f"{STAGE}.{path}" in str(error.value)
    assert words in str(error.value)
