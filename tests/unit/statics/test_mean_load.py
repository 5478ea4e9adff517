"""Slow phases, and load sharing without mesh-frequency content: against dense grids and whole hunting periods."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from epicyclic.document.document import ready_drives
from epicyclic.errors import ModelError
from epicyclic.questions.sharing import SharingOptions, definitions
from epicyclic.questions.sharing.definitions import DEFINITIONS
from epicyclic.questions.sharing.sharing import sharing
from epicyclic.statics.load_map import (
    MEAN_LOADS,
    closed_loads,
    largest_sum,
    load_map,
    phase_points,
    slow_phases,
    units_of_largest,
)
from epicyclic.statics.sample_loads import mean_loads, net_forces, nominal_signs
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

RNG = np.random.default_rng(4)


def waves(*shape: int) -> Any:
    return RNG.normal(size=shape) + 1j * RNG.normal(size=shape)


# slow phases ----------------------------------------------------------------------------------------------------------


def test_small_integers_are_tied() -> None:
    assert slow_phases((Fraction(3), Fraction(6), Fraction(7, 1000))) == (((0, 1), (1, 2)), ((2, 1),))
    # shafts of 23, 17 and 57 teeth: independent
    shafts = slow_phases((Fraction(1, 57), Fraction(1, 23), Fraction(1, 17)))
    assert shafts == (((0, 1),), ((1, 1),), ((2, 1),))
    # of 25, 30 and 85 teeth: one common phase
    assert slow_phases((Fraction(1, 85), Fraction(1, 30), Fraction(1, 25))) == (((0, 30), (1, 85), (2, 102)),)


@pytest.mark.parametrize("orders", [(1, 2), (3, 4, 5), (30, 85, 102)])
def test_tied_waves_reach_the_largest_sum_of_a_dense_grid(orders: tuple[int, ...]) -> None:
    phases = slow_phases([Fraction(n) for n in orders])
    a = waves(len(orders), 40)
    t = 2 * np.pi * np.arange(40_000) / 40_000
    dense = (np.exp(1j * np.multiply.outer(t, orders)) @ a).real.max(axis=0)
    found = largest_sum(phases, a)
    # a wrong peak loses little, and a common phase reaches less than independent ones
    assert np.all(found >= dense * (1 - 2e-3))
    assert np.all(found <= dense * (1 + 2e-4))
    assert np.any(found < np.abs(a).sum(axis=0) * 0.99)
    np.testing.assert_allclose((a * units_of_largest(phases, a)).real.sum(axis=0), found, rtol=1e-12)


def test_independent_waves_add_their_amplitudes() -> None:
    phases = slow_phases((Fraction(1, 57), Fraction(1, 23)))
    a = waves(2, 5)
    np.testing.assert_allclose(largest_sum(phases, a), np.abs(a).sum(axis=0), rtol=1e-14)
    # as the hunting period of these tooth numbers does, but for less than 1 %
    t = 2 * np.pi * np.arange(57 * 23 * 8) / 8
    reached = (np.exp(1j * np.multiply.outer(t, (1 / 57, 1 / 23))) @ a).real.max(axis=0)
    assert np.all(reached <= largest_sum(phases, a))
    assert np.all(reached > largest_sum(phases, a) * 0.99)


@pytest.mark.parametrize("frequencies", [(1,), (Fraction(1, 57), Fraction(1, 23)), (1, 2, Fraction(1, 997))])
def test_phase_points_fill_the_phases(frequencies: tuple[Any, ...]) -> None:
    unit = phase_points(slow_phases([Fraction(f) for f in frequencies]), 64)
    assert unit.shape == (64, len(frequencies))
    np.testing.assert_allclose(np.abs(unit), 1, rtol=1e-12)
    assert np.abs(unit.mean(axis=0)).max() < 0.03  # of 64 random ones 0.1
    if len(frequencies) == 3:
        np.testing.assert_allclose(unit[:, 1], unit[:, 0] ** 2, atol=1e-12)


# shares with a sum that turns -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("tied", [False, True])
def test_the_largest_share_where_the_sum_turns_too(tied: bool) -> None:
    frequency = (Fraction(1), Fraction(2)) if tied else (Fraction(1, 57), Fraction(1, 23))
    phases, group = slow_phases(frequency), [np.arange(3)]
    force, wave = 10 + RNG.random((6, 3)), waves(2, 6, 3)
    loads = closed_loads(force, wave, group, phases)
    np.testing.assert_allclose(loads[0], 3 * force / force.sum(axis=1, keepdims=True), rtol=1e-14)
    one = np.exp(2j * np.pi * np.arange(720) / 720)
    grid = np.array([one, one**2]) if tied else np.array([x.ravel() for x in np.meshgrid(one, one)])
    at = force[None] + np.einsum("gt,gsm->tsm", grid, wave).real
    dense = (3 * at / at.sum(axis=2, keepdims=True)).max(axis=0)
    np.testing.assert_allclose(loads[1], dense, rtol=3e-5)
    assert np.all(loads[1] >= dense * (1 - 1e-6))
    # shares of largest force and mean sum would be another number
    assert np.abs(3 * (force + largest_sum(phases, wave)) / force.sum(axis=1, keepdims=True) - dense).max() > 0.01


def test_a_sum_that_reaches_zero_has_no_share() -> None:
    phases = slow_phases((Fraction(1),))
    loads = closed_loads(np.ones((1, 2)), np.full((1, 1, 2), 1.5 + 0j), [np.arange(2)], phases)
    assert np.isinf(loads[1]).all()
    np.testing.assert_array_equal(loads[0], 1)


# of whole trains ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("drive", ready_drives())
def test_error_free_drives_share_equally(drive: str) -> None:
    uneven = ("deviations", "tolerance", "loads")  # loads across the axis press on one planet after the other
    model: dict[str, Any] = {k: v for k, v in load(drive).document.items() if k not in uneven}
    if "operation" in model:
        model["operation"] = {k: v for k, v in model["operation"].items() if k != "gravity"}
    del model["assumed"]
    found = mean_loads(assemble(load(model)))
    if not np.isnan(found).all():  # a drive without torque
        np.testing.assert_allclose(found, 1, rtol=1e-9)


def test_they_are_those_of_the_whole_hunting_period() -> None:
    """ren2021 at its mean stiffness, without errors at mesh orders: 22287 mesh cycles, instant by instant."""
    system = assemble(load("ren2021"))
    lines = tuple(line for line in system.lines if line.frequency not in system.tones)
    meshes = replace(system.meshes, variation=np.zeros_like(system.meshes.variation))
    even = replace(system, meshes=meshes, lines=lines)
    found = sharing(even, SharingOptions(method="static", samples=3))
    assert found.attrs["cycles"] == 22287
    mean = found.mesh_force_mean.values.reshape(2, 3, 2)
    share = 3 * mean / mean.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(found.load_sharing.sel(definition="mean-load"), share.ravel(), rtol=1e-9)
    turning = found.load_sharing.sel(definition="mean-load-turning").values
    reached = found.load_sharing.sel(definition="simultaneous").values
    assert np.all(turning >= reached * (1 - 1e-9))
    np.testing.assert_allclose(turning, reached, rtol=1e-4)
    # and those of the train with its varying stiffness and its profile errors, by every method
    for method in ("static", "superposition", "steady"):
        other = sharing(system, SharingOptions(method=method, cycles=2)).load_sharing.sel(definition=list(MEAN_LOADS))
        np.testing.assert_array_equal(other, found.load_sharing.sel(definition=list(MEAN_LOADS)))


def test_contact_that_opens_is_averaged_over_the_phases() -> None:
    """Four planets at a light load: against the mean and the largest of a dense set of instants."""
    model: dict[str, Any] = {
        "format": 2,
        "title": "four planets",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 4,
                "module": "4 mm",
                "face_width": "40 mm",
                "sun": {"teeth": 23, "support": {"radial": "1e7 N/m"}},
                "planet": {"teeth": 25, "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": 73},
                "carrier": {},
                "meshes": {"sun-planet": {"stiffness": "8e8 N/m"}, "planet-ring": {"stiffness": "9e8 N/m"}},
            }
        },
        "operation": {"held": ["ring"], "torque": {"sun": "120 N m"}, "speed": {"sun": "1500 rpm"}},
        "deviations": {
            "sun": {"run_out": "15 um"},
            "planet": {"run_out": {"amplitude": "[20, 10, 15, 0] um"}, "position": {"y": "[12, -4, 0, 0] um"}},
        },
    }
    system = assemble(load(model))
    found = sharing(system, SharingOptions(method="static", samples=4))
    assert found.contact_lost.values.any()
    mean = found.mesh_force_mean.values.reshape(2, 4)
    share = (4 * mean / mean.sum(axis=1, keepdims=True)).ravel()
    own = found.load_sharing.sel(definition="mean-load").values
    np.testing.assert_allclose(own, share, atol=4e-3)
    closed = load_map(replace(system, meshes=replace(system.meshes)))
    force = closed.flexible.stiffness * (closed.stretch.still + closed.stretch.torque)
    assert np.abs(4 * force[:4] / force[:4].sum() - share[:4]).max() > 0.02  # opening moves the mean
    reached = found.load_sharing.sel(definition="simultaneous").values
    np.testing.assert_allclose(found.load_sharing.sel(definition="mean-load-turning"), reached, rtol=5e-3)


def test_open_contact_reaches_what_any_phases_reach() -> None:
    """Five planets 19/16/51, three independent shafts: against 20 000 random phases of every train."""
    radial = {"sun": "1e7 N/m", "planet": "4e8 N/m"}
    model: dict[str, Any] = {
        "format": 2,
        "title": "five planets",
        "stages": {
            "main": {
                "planets": 5,
                "module": "4 mm",
                "sun": {"teeth": 19, "mass": "1 kg", "inertia": "1 kg", "support": {"radial": radial["sun"]}},
                "planet": {"teeth": 16, "mass": "1 kg", "inertia": "1 kg", "bearing": {"radial": radial["planet"]}},
                "ring": {"teeth": 51, "mass": "1 kg", "inertia": "1 kg"},
                "carrier": {"mass": "1 kg", "inertia": "1 kg"},
                "meshes": {"sun-planet": {"stiffness": "4e8 N/m"}, "planet-ring": {"stiffness": "5e8 N/m"}},
            }
        },
        "operation": {"held": ["ring"], "torque": {"sun": "80 N m"}, "speed": {"sun": "1500 rpm"}},
    }
    rng = np.random.default_rng(5)
    for _ in range(4):
        sizes = {name: rng.uniform(0, 15, 5 if name == "planet" else 1) for name in ("sun", "planet", "ring")}
        texts = {name: str(values.round(3).tolist()).strip("[]") for name, values in sizes.items()}
        pins = rng.normal(0, 25, 5).round(3).tolist()
        model["deviations"] = {name: {"run_out": f"{text} um"} for name, text in texts.items() if name != "planet"}
        model["deviations"]["planet"] = {"run_out": f"[{texts['planet']}] um", "position": {"y": f"{pins} um"}}
        system = assemble(load(model))
        found = mean_loads(system)[1]
        given = load_map(system)
        frequency = given.stretch.frequency
        assert all(len(part) == 1 for part in slow_phases(frequency))
        unit = np.exp(2j * np.pi * rng.random((20_000, len(frequency))))
        still, turning = given.stretch.still + given.stretch.torque, given.stretch.turning
        net, known = net_forces(given, still + (unit @ turning).real)
        assert known.all()
        force = given.face.total(net, axis=1) * nominal_signs(given)[0]
        assert (force[:, :5] <= 0).any()
        share = (5 * force[:, :5] / force[:, :5].sum(axis=1, keepdims=True)).max(axis=0)
        assert found[:5].max() >= share.max() - 3e-3  # what the search leaves; the lattice alone leaves 7e-3
        # forces at some phases are none above the largest: that of a planet which carries all
        assert found.max() <= 5


def test_where_they_are_not_known_the_others_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(system: System) -> Any:
        raise ModelError("nothing takes the load at rest")

    system = assemble(load("ren2021"))
    before = sharing(system, SharingOptions(cycles=2))
    monkeypatch.setattr(definitions, "mean_loads", none)
    found = sharing(system, SharingOptions(cycles=2))
    others = found.load_sharing.sel(definition=list(DEFINITIONS[:5]))
    np.testing.assert_array_equal(others, before.load_sharing.sel(definition=list(DEFINITIONS[:5])))
    assert np.isnan(found.load_sharing.sel(definition=list(MEAN_LOADS))).all()
    assert np.isnan(found.system_load_sharing.sel(definition="mean-load"))
    assert any("mean-load-turning are not known: nothing takes" in text for text in json.loads(found.attrs["warnings"]))


def test_their_names_come_behind_the_five() -> None:
    assert DEFINITIONS[5:] == MEAN_LOADS == ("mean-load", "mean-load-turning")
