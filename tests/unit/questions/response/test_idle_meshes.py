"""Meshes of a gear without torque: no load, hence no dynamic factor, in any result and in no headline."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.response.measures import dynamic_factor
from epicyclic.questions.response.views import sweep_findings, sweep_key_figures
from epicyclic.questions.sharing import views as sharing_view
from epicyclic.questions.tolerance.views import tolerance_tables
from epicyclic.show.elements import Table, force_table, number, shown_columns
from epicyclic.statics.record import loaded_meshes
from epicyclic.system.tooth_pairs import first_mesh

# Two suns; the torque goes from the small one to the ring, and the large one turns idle.
TWO_SUNS = """
format = 2
title = "Two suns, one idle"
damping.modal = 0.03
[stages.main]
planets = 3
module = "1.75 mm"
face_width = "25 mm"
[stages.main.meshes]
small-short = {}
short-long = {}
large-long = {}
long-ring = {}
[stages.main.small]
kind = "sun"
teeth = 30
support.radial = 0
[stages.main.large]
kind = "sun"
teeth = 36
support.radial = 0
[stages.main.short]
kind = "planet"
teeth = 20
bearing.radial = "2e8 N/m"
[stages.main.long]
kind = "planet"
teeth = 18
bearing.radial = "2e8 N/m"
[stages.main.ring]
teeth = 72
addendum = 0.9
rim = "8 mm"
[stages.main.carrier]
mass = "2.5 kg"
inertia = "0.004 kg m^2"
[operation]
held = ["carrier"]
speed.small = "3000 rpm"
torque.small = "300 N m"
torque.ring = "balance"
"""
IDLE = slice(3, 6)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> str:
    path: Path = tmp_path_factory.mktemp("idle") / "two-suns.toml"
    path.write_text(TWO_SUNS)
    return str(path)


@pytest.fixture(scope="module")
def swept(model: str) -> xr.Dataset:
    return epicyclic.sweep(model, start="900 Hz", stop="1500 Hz", points=3)


def test_the_idle_pair_alone_has_no_dynamic_factor(model: str, swept: xr.Dataset) -> None:
    one = epicyclic.steady(model, samples=512)
    # by the torques on the gears: 300 N m over three meshes at the base radius of the small sun, none on the large one
    mean = one.mesh_force.mean("mesh_phase").values
    assert mean[0] == pytest.approx(300 / (3 * 0.5 * 1.75e-3 * 30 * np.cos(np.deg2rad(20))), rel=1e-6)
    assert np.abs(mean[IDLE]).max() < 1e-9 * mean[0] < np.ptp(one.mesh_force.values[IDLE])
    expected = one.mesh_force_bound / np.where(np.abs(mean) > 1e-6 * mean[0], mean, np.nan)
    np.testing.assert_allclose(one.dynamic_factor, expected, rtol=1e-6)
    assert np.isnan(swept.dynamic_factor.transpose("mesh", "speed").values[IDLE]).all()
    assert np.isfinite(np.delete(swept.dynamic_factor.transpose("mesh", "speed").values, IDLE, axis=0)).all()
    for result in (one, swept):
        assert "main/large-long/1, main/large-long/2, main/large-long/3 [mesh-without-load]" in str(result.attrs)


@pytest.mark.parametrize("verb", ["static", "sharing", "sharing static", "steady", "sweep"])
def test_of_an_idle_mesh_it_is_said_that_it_has_no_load_and_nothing_else(
    verb: str, model: str, swept: xr.Dataset
) -> None:
    results = {
        "static": lambda: epicyclic.static(model),
        "sharing": lambda: epicyclic.sharing(model, cycles=1),
        "sharing static": lambda: epicyclic.sharing(model, method="static", cycles=1),
        "steady": lambda: epicyclic.steady(model, samples=64),
        "sweep": lambda: swept,
    }
    told = [text for text in json.loads(results[verb]().attrs["warnings"]) if "large-long" in text]
    assert len(told) == 1
    assert told[0].endswith("main/large-long/1, main/large-long/2, main/large-long/3 [mesh-without-load]")


def test_a_train_without_load_still_says_which_meshes_open(model: str) -> None:
    unloaded = {"operation.torque.small": None, "operation.torque.ring": None}
    told = json.loads(epicyclic.static(model, overrides=unloaded).attrs["warnings"])
    assert any("[contact-lost]" in text for text in told)
    assert not any("[mesh-without-load]" in text for text in told)


def test_no_resonance_and_no_headline_counts_it(model: str, swept: xr.Dataset) -> None:
    found = epicyclic.modes(model, band="30 %")
    factor = found.resonance_dynamic_factor.values
    assert 1 < np.nanmax(factor) < 3
    assert not any("large-long" in name for name in found.resonance_mesh.values)
    words = " ".join(value for value, _ in sweep_key_figures(swept))
    assert "e+" not in words
    lines = [one.text for one in sweep_findings(swept, {})]
    assert any(line.startswith("K_v judges nothing in main/large-long/1") for line in lines)
    # teeth without load rattle at every speed; that is no range in which the loaded ones part
    assert not any("would part" in line for line in lines)


def test_a_drag_alone_is_not_judged_by_its_dynamic_factor(model: str) -> None:
    dragged = epicyclic.sweep(model, overrides={"operation.torque.large": "-0.2 N m"}, points=9, range="operation")
    idle = np.array([name.startswith("main/large-long") for name in dragged.mesh.values])
    assert np.nanmax(dragged.dynamic_factor.values[idle]) > 10
    lines = [one.text for one in sweep_findings(dragged, {})]
    assert any(line.startswith("K_v judges nothing in main/large-long/1") for line in lines)
    assert all("large" not in line.split("largest K_v")[1] for line in lines if "largest K_v" in line)
    assert not any("large" in words.replace("largest", "") for _, words in sweep_key_figures(dragged))


@pytest.mark.parametrize("scale", [1e-12, 1e-9, -1e-9, 0.0])
def test_what_is_left_of_a_balance_is_no_load(scale: float) -> None:
    groups = [np.array([0, 1]), np.array([2, 3])]
    mean = np.array([100.0, 100.0, 100 * scale, 100 * scale])[:, None]
    most = np.array([110.0, 110.0, 40.0, 40.0])[:, None]
    np.testing.assert_allclose(dynamic_factor(most, mean, groups, 0.0)[:, 0], [1.1, 1.1, np.nan, np.nan])


def test_teeth_pressed_against_each_other_in_an_idle_gear_carry_no_load() -> None:
    groups = [np.array([0, 1]), np.array([2, 3])]
    mean, most = np.array([100.0, 100.0, 5.0, -5.0])[:, None], np.full((4, 1), 120.0)
    np.testing.assert_allclose(dynamic_factor(most, mean, groups, 0.0)[:, 0], [1.2, 1.2, np.nan, np.nan])


def test_a_tenth_of_the_load_or_a_ten_thousandth_is_a_load() -> None:
    groups = [np.array([i]) for i in range(4)]
    mean = np.array([1.0, 1e-1, 1e-4, 1e-5])
    loaded = loaded_meshes(mean, groups, most=mean, rounding=0.0)
    assert loaded.all()


def test_teeth_without_load_are_not_counted_as_parting(model: str) -> None:
    """They part and touch again at every speed: the verdict is on the nine meshes that carry."""
    result = epicyclic.sharing(model, cycles=2)
    assert result.contact_lost.values[IDLE].all()
    assert ("none of 9", "meshes whose teeth part at the operating point, 3 without load left out") in (
        sharing_view.key_figures(result)
    )
    (first, *_) = sharing_view.findings(result, {})
    assert first.text == "Teeth stay in contact in all 9 meshes that carry a load at the operating point."
    assert "tension-in-teeth" not in str(result.attrs["warnings"])
    (table, *_) = sharing_view.tables(result)
    assert table.columns["contact"][IDLE] == ["no load"] * 3
    rounding = force_table(result).columns["mean [N]"]
    assert abs(rounding[3]) < 1e-9 * rounding[0]
    shown = {heading: cells for heading, _, cells in shown_columns(force_table(result), number)}
    assert [text for text, _ in shown["mean [N]"]][IDLE] == ["0"] * 3


def test_numbers_of_different_units_in_one_column_are_all_shown() -> None:
    """A helix angle of 0.38 rad is no rounding of a modulus of 2e11 Pa."""
    table = Table(title="", columns={"value": [2.1e11, 0.383972], "force [N]": [2.1e11, 0.383972]})
    shown = {heading: [text for text, _ in cells] for heading, _, cells in shown_columns(table, number)}
    assert shown == {"value": ["2.1e+11", "0.383972"], "force [N]": ["2.1e+11", "0"]}


def test_idle_meshes_part_in_no_tolerance_run(model: str) -> None:
    """Errors of the long planets part teeth of the idle sun in every train; those that carry the load stay closed."""
    found = epicyclic.tolerance(
        model,
        overrides={
            "tolerance": {"deviations.main.long.position": "disc(20 um)"},
            "stages.main.large.support.radial": "1e7 N/m",
        },
        samples=256,
        effects="none",
    )
    assert int(found.attrs["open"]) == 256
    assert float(found.system_separation_probability) == 0.0
    idle = [name for name in found.mesh.values if "large-long" in str(name)]
    assert np.isnan(found.worst_load_sharing.sel(mesh=idle)).all()
    (worst,) = [one for one in tolerance_tables(found) if "worst samples" in one.title]
    assert not any("large-long" in name for name in worst.columns["mesh"])
    assert len(worst.columns["mesh"]) == 10  # three loaded pairs of three meshes, and K_gamma


def test_train_contact_resolves_the_meshes_that_carry(model: str) -> None:
    """Idle teeth have no load that slices could resolve: no factor, no loss of contact, no estimated error."""
    found = epicyclic.contact(model, loads=(1.0,))
    idle = np.array(["short-long" not in name and "small" not in name for name in found.mesh.values.astype(str)])
    idle &= np.array(["long-ring" not in name for name in found.mesh.values.astype(str)])
    assert idle.sum() == 3
    assert np.isnan(found.face_load_factor.values[:, idle]).all()
    assert np.isfinite(found.face_load_factor.values[:, ~idle]).all()
    assert found.attrs["estimated_error"] < 0.01
    codes = found.attrs["warnings"]
    assert "mesh-without-load" in codes
    assert "contact-lost" not in codes
    assert "resolution-insufficient" not in codes


def needs(model: str, overrides: Mapping[str, object], verb: str) -> str:
    """What `check` says a verb still needs, empty where it is ready."""
    return str(epicyclic.check(model, overrides=overrides).verb_needs.sel(verb_name=verb).item())


def test_contact_takes_the_first_mesh_that_carries(model: str) -> None:
    turned = {"operation.torque.small": None, "operation.speed.small": None, "operation.speed.large": "3000 rpm"}
    given = {**turned, "operation.torque.large": "300 N m"}
    first = first_mesh(epicyclic.load(model, overrides=given))
    assert "large-long" in first
    assert epicyclic.contact(model, mesh=first, overrides=given).attrs["mesh"] == first
    with pytest.raises(ModelError, match=r"no torque passes the mesh main/small-short; allowed: .*main/large-long"):
        epicyclic.contact(model, mesh="small-short", overrides=given)
    assert not needs(model, given, "contact")
    assert "no torque loads the teeth" in needs(model, {"operation.torque.small": "0 N m"}, "contact")


def test_a_train_that_turns_as_one_says_so(model: str) -> None:
    direct = {"operation.held": [], "operation.speed.carrier": "3000 rpm", "operation.torque.carrier": "420 N m"}
    with pytest.raises(ModelError, match="the members of each stage turn as one; allowed: members that turn against"):
        epicyclic.steady(model, overrides=direct)
    assert "the members of each stage turn as one" in needs(model, direct, "steady")
    with pytest.raises(ModelError, match="allowed: the speed of one member"):
        epicyclic.steady(model, overrides={"operation.speed": None})


def test_relief_counts_in_train_contact(model: str) -> None:
    relieved = {"stages.main.flank.tip_relief": {"amount": "10 um", "length": "0.5 mm"}}
    assert "flank-without-effect" in epicyclic.steady(model, overrides=relieved).attrs["warnings"]
    found = epicyclic.contact(model, loads=(1.0,), samples=16, slices=4, overrides=relieved)
    assert "flank-without-effect" not in found.attrs["warnings"]
