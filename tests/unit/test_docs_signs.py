"""The drawings of the signs: what they show is what is assembled."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.assemble.structure import structure_of

FOLDER = Path(__file__).parents[2] / "docs" / "theory" / "signs"


def load_script() -> Any:
    spec = importlib.util.spec_from_file_location("signs_make", FOLDER / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SIGNS = load_script()


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("which", [0, 1], ids=["sun", "ring"])
def test_the_row_of_the_drawing_is_the_assembled_one(which: int, sense: int) -> None:
    train = epicyclic.load(SIGNS.DRIVE, overrides={"operation.torque.sun": f"{7 * sense} kN m"})
    drawn, found = SIGNS.meshes_of(sense)[which], structure_of(train)
    (row,) = (i for i, one in enumerate(found.meshes) if one.mesh.name == drawn.name)
    mesh = found.meshes[row].mesh
    assert (mesh.a, mesh.b, mesh.flank, mesh.hand) == (drawn.a, drawn.b, drawn.d, drawn.hand)
    expected = np.zeros_like(found.mesh[row])
    for body, part in zip((drawn.a, drawn.b), drawn.row, strict=True):
        expected[6 * found.index[body] :][:6] = part
    np.testing.assert_allclose(found.mesh[row], expected, rtol=0, atol=1e-12)


def test_the_leads_of_the_drawing_are_the_resolved_ones() -> None:
    found = [mesh.lead for mesh in epicyclic.load(SIGNS.DRIVE).meshes if "sun-planet" in mesh.name]
    np.testing.assert_allclose([float(one) for one in found], SIGNS.leads(), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["mesh", "axes", "phases"])
def test_the_pictures_are_those_of_the_script(name: str) -> None:
    assert (FOLDER / f"{name}.svg").read_text(encoding="utf-8") == SIGNS.drawings()[name], (
        "run python docs/theory/signs/make.py"
    )
