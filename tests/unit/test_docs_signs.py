"""The drawings of the signs: what they show is what is assembled."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.system.structure import structure_of

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


@pytest.mark.parametrize("drives", ["sun", "carrier"])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_pin_in_the_sense_of_the_torque_on_the_carrier_takes_more_load(drives: str, sense: int) -> None:
    """Positive `position.y` is counter-clockwise; of five planets one is `sense` in the sense of that torque."""
    power = {"operation.torque": None, f"operation.torque.{drives}": "100 kN m", "operation.speed": None}
    power |= {f"operation.speed.{drives}": "12 rpm", "tolerance": None}  # drives: torque and speed are of one sense
    towards = 1 if drives == "carrier" else -1  # the torque on the carrier of a driving sun is against its rotation
    pins = {"deviations.planet.position.y": f"[{5 * sense * towards}, 0, 0, 0, 0] um"}
    found = epicyclic.sharing("wind-five", method="static", cycles=1, overrides=power | pins)
    carrier = epicyclic.check("wind-five", overrides=power).torque.sel(body="main/carrier")
    assert np.sign(float(carrier)) == towards
    share = found.mesh_force_mean.values[:5] / found.mesh_force_mean.values[:5].mean() - 1
    assert share[0] * sense > 0
    # K_gamma - 1 is X (1 - 3 / n) of a pin that closes its meshes, X (1 + 2 cos(2 pi / n)) / n of one that opens them
    expected = 1.0 if sense > 0 else (1 + 2 * np.cos(2 * np.pi / 5)) / (5 - 3)
    assert share.max() / abs(share[0]) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", ["mesh", "axes", "phases"])
def test_the_pictures_are_those_of_the_script(name: str) -> None:
    assert (FOLDER / f"{name}.svg").read_text(encoding="utf-8") == SIGNS.drawings()[name], (
        "run python docs/theory/signs/make.py"
    )
