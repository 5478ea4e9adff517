"""Instants and slices of `contact` of a train follow its tolerance, as those of a mesh; what is left is said."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.flanks.contact_resolution import Ladder
from epicyclic.questions.flanks.train_contact import _corner_times
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.path_of_contact import corner_phases, largest_part_mean

# one helical pair between stiff supports: its mesh force is that of the torque at every instant
PAIR: dict[str, Any] = {
    "format": 2,
    "title": "one pair",
    "stages": {
        "main": {
            "module": "4 mm",
            "helix_angle": "18 deg",
            "face_width": "40 mm",
            "pinion": {"kind": "gear", "teeth": 23, "support": {"radial": "inf", "z": "inf"}},
            "wheel": {"kind": "gear", "teeth": 41, "support": {"radial": "inf", "z": "inf"}},
            "meshes": {"pinion-wheel": {"stiffness": "400 N/um"}},
        }
    },
    "operation": {"speed": {"pinion": "1000 rpm"}, "torque": {"pinion": "400 N m"}},
}


@pytest.mark.parametrize("flank", [{}, {"crown": "12 um"}])
def test_a_pair_in_a_train_has_the_largest_load_of_the_pair_alone(flank: dict[str, str]) -> None:
    model = json.loads(json.dumps(PAIR))
    model["stages"]["main"]["pinion"]["flank"] = flank
    alone = epicyclic.contact(model, mesh="pinion-wheel", loads=[])
    train = epicyclic.contact(model, loads=[])
    largest = train.largest_load_per_length.values.item()
    assert largest == pytest.approx(alone.largest_load_per_length.values.item(), rel=0.01)
    assert train.averaging_length.values.item() == pytest.approx(alone.averaging_length.values.item(), rel=1e-12)
    assert 0 < train.attrs["estimated_error"] <= train.attrs["tolerance"] == 0.01
    assert train.attrs["slices"] >= 20
    assert train.attrs["samples"] == 32  # the fewest that are kept: the corners are among the instants
    even = epicyclic.contact(model, loads=[], samples=5, slices=train.attrs["slices"])
    if not flank:  # even instants miss the corner at which the load of plain flanks is largest
        assert even.largest_load_per_length.values.item() < 0.98 * largest
    assert math.isnan(even.attrs["estimated_error"])
    assert (even.attrs["samples"], even.sizes["time"]) == (5, 5)


def test_a_corner_at_an_even_instant_is_no_instant_of_its_own() -> None:
    train = epicyclic.load(PAIR)
    pair = pair_of(train, train.meshes[0], slices=4)
    corner = corner_phases(pair.plane)
    law: Any = SimpleNamespace(pair=pair, meshes=(0,), lead=(corner[0] - 0.25,), sense=(1.0,))
    record: Any = SimpleNamespace(count=1, samples=4)
    times = _corner_times([law], record, np.ones(1))
    assert times.size == np.unique(np.round(corner, 9)).size - 1
    assert np.abs(times - 0.25).min() > 1e-9


def test_means_do_not_take_the_corners_for_even_instants() -> None:
    """The force of the mesh is constant, and so is the load of its face; its parts vary."""
    found = epicyclic.contact(PAIR, loads=[])
    force = found.mesh_force.values[0, 0]
    np.testing.assert_allclose(force, force[0], rtol=1e-9)
    np.testing.assert_allclose(found.face_load.mean("width").values * 0.04, force[:1, None], rtol=1e-9)
    fine = epicyclic.contact(PAIR, loads=[], samples=256, slices=found.attrs["slices"])
    # 256 even instants, or 32 and six corners: the second order of 1/32
    np.testing.assert_allclose(found.face_load, fine.face_load, rtol=5e-3)


def test_what_does_not_hold_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    module = "epicyclic.questions.flanks.train_contact"
    monkeypatch.setattr(f"{module}._LADDER", Ladder(phases=(3, 6), slices=(2, 4), fewest=(3, 2)))
    model = json.loads(json.dumps(PAIR))
    model["stages"]["main"]["pinion"]["flank"] = {"crown": "12 um"}
    found = epicyclic.contact(model, loads=[], tolerance=1e-6)
    said = json.loads(found.attrs["warnings"])
    assert any(text.startswith("6 instants and 4 slices are not enough: estimated error") for text in said)
    assert any(text.startswith("4 slices are not enough for K_Hbeta: estimated error") for text in said)
    assert found.attrs["estimated_error"] > 1e-6
    assert found.attrs["estimated_face_error"] > 1e-6
    fixed = epicyclic.contact(model, loads=[], samples=6, slices=4, tolerance=1e-6)
    assert not [text for text in json.loads(fixed.attrs["warnings"]) if "slices" in text]


@pytest.mark.parametrize("helix", ["18 deg", "0 deg"])
def test_a_turn_has_the_instants_of_its_mesh_cycles(helix: str) -> None:
    """Spur teeth too, whose loads jump at a corner."""
    model = json.loads(json.dumps(PAIR))
    model["stages"]["main"]["helix_angle"] = helix
    model["stages"]["main"]["pinion"]["teeth"] = 17
    cycle = epicyclic.contact(model, loads=[])
    turn = epicyclic.contact(model, loads=[], turns=1, of="main/pinion")
    assert turn.attrs["samples"] == 17 * cycle.attrs["samples"]
    np.testing.assert_allclose(turn.largest_load_per_length, cycle.largest_load_per_length, rtol=1e-9)
    np.testing.assert_allclose(turn.face_load, cycle.face_load, rtol=1e-9)


@pytest.mark.parametrize("name", ["samples", "slices", "tolerance"])
def test_no_discretisation_is_refused(name: str) -> None:
    with pytest.raises(ModelError, match=name):
        epicyclic.contact(PAIR, loads=[], **{name: 0})  # type: ignore[arg-type]


def test_more_than_memory_holds_is_refused() -> None:
    with pytest.raises(ModelError, match="GB"):
        epicyclic.contact(PAIR, loads=[], samples=90_000, slices=900)


def test_the_load_at_the_end_of_a_face_converges_over_a_tenth_of_it() -> None:
    """The largest slice goes on from 1.031 at 20 slices to 1.043 at 40 and 1.051 at 80."""
    found = [epicyclic.contact("ren2021", loads=[], samples=8, slices=count) for count in (20, 40)]
    factor, other = (one.face_load_factor.values[0] for one in found)
    np.testing.assert_allclose(factor, other, rtol=2e-3)
    load = [one.face_load.values[0] for one in found]
    largest, finer = (one.max(axis=1) / one.mean(axis=1) for one in load)
    assert (finer - largest).max() > 0.01
    assert json.loads(found[0].attrs["warnings"]) == json.loads(found[1].attrs["warnings"])


@pytest.mark.parametrize("count", [4, 10, 11, 40, 200])
def test_the_largest_tenth_of_a_face(count: int) -> None:
    """Of a linear load, and of a peak anywhere, by a search over the beginnings of a tenth."""
    place = (np.arange(count) + 0.5) / count
    found = largest_part_mean(1 + 0.6 * (2 * place - 1))
    assert found == pytest.approx(1 + 0.6 * (1 - max(0.1, 1 / count)), rel=0.01 if count == 11 else 1e-12)
    force = np.random.default_rng(5).uniform(size=(3, count)) ** 4
    begin = np.linspace(0, 0.9, 40_001)
    edges, summed = np.arange(count + 1) / count, np.pad(np.cumsum(force, axis=1), ((0, 0), (1, 0)))
    means = [np.interp(begin + 0.1, edges, one) - np.interp(begin, edges, one) for one in summed]
    assert largest_part_mean(force) == pytest.approx(np.max(means, axis=1) / (0.1 * count), rel=1e-3)
