"""Load factors: each as of the verb that computes it, flanks by hand, the product beside the contact of the train."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic import ModelError
from epicyclic.cli.main import app
from epicyclic.document.writer import model_text
from epicyclic.show.views import findings_of, tables_of

TORQUE, SPEED = 800.0, 1500.0  # of the sun [N m], [rpm]
SUN_TEETH, PLANET_TEETH, RING_TEETH = 24, 30, 84
RELATIVE = SPEED * RING_TEETH / (SUN_TEETH + RING_TEETH)  # of the sun to the carrier [rpm]
HOURS = {"full": 900.0, "part": 9000.0, "reverse": 100.0}
SUN = "stages.main.meshes.sun-planet"
STAGE: dict[str, Any] = {
    "planets": 3,
    "module": "4 mm",
    "face_width": "50 mm",
    "sun": {"teeth": SUN_TEETH, "support": {"radial": "5e7 N/m"}},
    "planet": {"teeth": PLANET_TEETH, "bearing": {"radial": "4e8 N/m"}},
    "ring": {"teeth": RING_TEETH, "rim": "25 mm", "addendum": 0.9},
    "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
}
MODEL: dict[str, Any] = {
    "format": 2,
    "title": "A planetary reducer with load cases",
    "damping": {"modal": 0.03},
    "stages": {"main": STAGE},
    "operation": {"held": ["ring"], "speed": {"sun": f"{SPEED} rpm"}, "torque": {"sun": f"{TORQUE} N m"}},
    "cases": {
        "full": {"duration": "900 h"},
        "part": {"speed": {"sun": "700 rpm"}, "torque": {"sun": "300 N m"}, "duration": "9000 h"},
        "reverse": {"torque": {"sun": "-400 N m"}, "duration": "100 h"},
    },
}
PIN = {"deviations": {"planet": {"position": {"y": "[30, 0, 0] um"}}}}
ALL = {"case": "all"}


def two_stages() -> dict[str, Any]:
    """Two stages in series on rigid bearings, a pin error in the first; the second case is reversed."""
    meshes = {pair: {"variation": {"cosine": [0.2, 0.05]}} for pair in ("sun-planet", "planet-ring")}
    first = {**STAGE, "sun": {"teeth": SUN_TEETH}, "planet": {"teeth": PLANET_TEETH}, "meshes": meshes}
    second = {**first, "module": "6 mm", "face_width": "90 mm"}
    return {
        "format": 2,
        "title": "two stages",
        "damping": {"modal": 0.1},
        "stages": {"first": first, "second": second},
        "couplings": {"shaft": {"between": ["first.carrier", "second.sun"], "rz": "5e7 N m/rad"}},
        "operation": {
            "held": ["first.ring", "second.ring"],
            "speed": {"first": {"sun": "600 rpm"}},
            "torque": {"first": {"sun": "500 N m"}, "second": {"carrier": "balance"}},
        },
        "deviations": {"first": {"planet": {"position": {"y": "[5, 0, 0] um"}}}},
        "cases": {"ahead": {"share": 0.75}, "back": {"torque": {"first": {"sun": "-300 N m"}}, "share": 0.25}},
    }


def alone(model: dict[str, Any]) -> dict[str, Any]:
    """The model without its cases."""
    return {name: table for name, table in model.items() if name != "cases"}


def check_against_verbs(source: Any, found: xr.Dataset, overrides: dict[str, Any]) -> None:
    """K_gamma is that of `sharing`, K_v that of `steady`."""
    shared = epicyclic.sharing(source, overrides=overrides, method="static", cycles=1, samples=16)
    mean = shared.load_sharing.sel(definition="mean-load").values
    np.testing.assert_allclose(found.branch_load.values, mean, rtol=1e-9)
    names = [str(name) for name in found.mesh.values]
    for group in json.loads(shared.attrs["groups"]):
        places = [names.index(name) for name in group]
        np.testing.assert_allclose(found.k_gamma.values[places], mean[places].max(), rtol=1e-9)
    moved = epicyclic.steady(source, overrides=overrides)
    np.testing.assert_allclose(found.dynamic_factor.values, moved.dynamic_factor.values, rtol=1e-9)


@pytest.mark.parametrize("drive", ["ren2021", "wind-five", "industrial-stage"])
def test_factors_are_those_of_sharing_and_steady(drive: str) -> None:
    found = epicyclic.load_factors(drive).squeeze("case")
    check_against_verbs(drive, found, {})
    product = found.k_gamma * found.dynamic_factor * found.face_load_factor
    np.testing.assert_allclose(found.load_factor_product, product, rtol=1e-12)


def test_factors_of_two_stages_are_those_of_each_case() -> None:
    model = two_stages()
    found = epicyclic.load_factors(model, overrides=ALL)
    for case in model["cases"]:
        check_against_verbs(model, found.sel(case=case), {"case": case})
    assert float(found.k_gamma.sel(case="ahead").max()) > 1.02
    assert found.flank.values.tolist() == [[1, -1, 1, -1], [-1, 1, -1, 1]]


def test_a_mirrored_case_fills_the_other_flank_with_the_same_numbers() -> None:
    mirror = {"speed": {"sun": f"{-SPEED} rpm"}, "torque": {"sun": f"{-TORQUE} N m"}, "duration": "900 h"}
    model = MODEL | {"cases": {"full": MODEL["cases"]["full"], "mirror": mirror}}
    found = epicyclic.load_factors(model, overrides=ALL, flanks="contact", tolerance=0.1)
    full, other = (found.sel(case=case) for case in ("full", "mirror"))
    assert full.flank.values.tolist() == [1, -1]
    assert other.flank.values.tolist() == [-1, 1]
    np.testing.assert_allclose(other.pair_torque, -full.pair_torque, rtol=1e-12)
    for name in ("k_gamma", "dynamic_factor", "load_factor_product", "largest_root_stress", "largest_pressure"):
        np.testing.assert_allclose(other[name], full[name], rtol=1e-6, err_msg=name)
    one, two = (found.sel(loaded_flank=flank) for flank in (1, -1))
    assert (one.flank_cycles > 0).all()
    np.testing.assert_allclose(one.flank_cycles, two.flank_cycles, rtol=1e-12)
    np.testing.assert_allclose(one.flank_equivalent_torque, two.flank_equivalent_torque, rtol=1e-12)


def test_cycles_and_torques_of_three_planets_by_hand() -> None:
    found = epicyclic.load_factors(MODEL, overrides=ALL)
    turns = {case: RELATIVE * 60 * hours for case, hours in HOURS.items()}
    turns["part"] *= 700 / SPEED
    planet, ring = SUN_TEETH / PLANET_TEETH, SUN_TEETH / RING_TEETH
    for case, relative in turns.items():  # the sun meets three planets a turn, a planet each of its mates once
        by_hand = relative * np.array([[3, planet], [planet, 3 * ring]])
        np.testing.assert_allclose(found.load_cycles.sel(case=case), by_hand, rtol=1e-12)
    on_planet = -TORQUE / 3 * PLANET_TEETH / SUN_TEETH
    torque = [[-TORQUE / 3, on_planet], [-on_planet, on_planet * RING_TEETH / PLANET_TEETH]]
    np.testing.assert_allclose(found.pair_torque.sel(case="full"), torque, rtol=1e-12)
    ahead = found.sel(mesh_pair=SUN, mesh_gear="a", loaded_flank=1)
    assert float(ahead.flank_cycles) == pytest.approx(3 * (turns["full"] + turns["part"]), rel=1e-12)
    sums = turns["full"] * 800**6.61 + turns["part"] * 300**6.61
    whole = (sums / (turns["full"] + turns["part"])) ** (1 / 6.61) / 3
    assert float(ahead.flank_equivalent_torque) == pytest.approx(whole, rel=1e-12)
    back = found.sel(mesh_pair=SUN, mesh_gear="a", loaded_flank=-1)
    assert float(back.flank_cycles) == pytest.approx(3 * turns["reverse"], rel=1e-12)
    assert float(back.flank_equivalent_torque) == pytest.approx(400 / 3, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "exponent"),
    [
        ({"material": "nitrided"}, 5.709),
        ({"material": "nitrocarburised"}, 15.715),
        ({"material": "nitrided", "exponent": 3.0}, 3.0),
    ],
)
def test_the_exponent_is_that_of_the_material_or_given(options: dict[str, Any], exponent: float) -> None:
    found = epicyclic.load_factors(MODEL, overrides=ALL, **options)
    weight = np.array([9.0, 90.0 * 700 / SPEED])
    mean = (weight @ np.array([800.0, 300.0]) ** exponent / weight.sum()) ** (1 / exponent) / 3
    one = found.flank_equivalent_torque.sel(mesh_pair=SUN, mesh_gear="a", loaded_flank=1)
    assert float(one) == pytest.approx(mean, rel=1e-12)


def test_shares_and_a_life_take_the_place_of_durations() -> None:
    model = deepcopy(MODEL)
    for case, hours in HOURS.items():
        del model["cases"][case]["duration"]
        model["cases"][case]["share"] = hours / 10_000
    timed = epicyclic.load_factors(MODEL, overrides=ALL)
    shared = epicyclic.load_factors(model, overrides=ALL)
    assert np.isnan(shared.load_cycles).all()
    np.testing.assert_allclose(shared.flank_equivalent_torque, timed.flank_equivalent_torque, rtol=1e-12)
    lived = epicyclic.load_factors(model, overrides=ALL, life="20000 h")
    np.testing.assert_allclose(lived.load_cycles, 2 * timed.load_cycles, rtol=1e-12)
    one = epicyclic.load_factors(MODEL, overrides={"case": "part"})
    assert one.case.values.tolist() == ["part"]
    np.testing.assert_allclose(one.load_cycles, timed.load_cycles.sel(case=["part"]), rtol=1e-12)


def test_a_case_without_time_leaves_the_sums_open() -> None:
    model = deepcopy(MODEL)
    del model["cases"]["part"]["duration"]
    found = epicyclic.load_factors(model, overrides=ALL)
    assert np.isnan(found.flank_equivalent_torque.sel(loaded_flank=1, mesh_pair=SUN)).all()
    assert np.isfinite(found.load_cycles.sel(case="full")).all()
    assert any("cases-not-weighed" in text for text in json.loads(found.attrs["warnings"]))


def test_the_product_is_what_the_contact_of_the_train_gives_directly() -> None:
    model = MODEL | PIN
    found = epicyclic.load_factors(model, flanks="contact").squeeze("case")
    whole = epicyclic.contact(model, loads=(1.0,)).sel(torque_factor=1.0)
    load = whole.largest_load_per_length.values
    np.testing.assert_allclose(found.largest_load_per_length, load, rtol=1e-9)
    np.testing.assert_allclose(found.largest_root_stress, whole.largest_root_stress, rtol=1e-9)
    single = epicyclic.contact(model, mesh="sun-planet", loads=(1.0,))
    ratio = epicyclic.check(model).contact_ratio.values
    share = found.transverse_load_factor.values  # of spur teeth one pair carries all
    np.testing.assert_allclose(share[:3], ratio[:3] * float(single.pair_share.max()), rtol=1e-6)
    # by hand: a third of the torque on the base radius, on as many lines as the contact ratio has
    base = 0.004 * SUN_TEETH / 2 * np.cos(np.radians(20))
    nominal = TORQUE / 3 / base / 0.05 / ratio
    np.testing.assert_allclose(found.nominal_load_per_length, nominal, rtol=1e-3)
    direct = found.dynamic_factor.values * load / nominal
    np.testing.assert_allclose(found.direct_load_factor, direct, rtol=1e-3)
    # spur and parallel: worst place and worst phase meet, and a branch has its own load in place of the largest
    assert float(found.k_gamma.max()) > 1.02
    np.testing.assert_allclose(found.coincidence_factor, 1.0, atol=0.02)
    explained = found.load_factor_product * found.branch_load / found.k_gamma
    np.testing.assert_allclose(found.direct_load_factor, explained, rtol=0.02)
    # a line contact: pressure goes as the root of the load per length
    pressure = float(single.largest_pressure[0, 0]) * np.sqrt(load / float(single.largest_load_per_length[0, 0]))
    np.testing.assert_allclose(found.largest_pressure[:3], pressure[:3], rtol=1e-6)


def test_every_stage_passes_a_whole_mesh_cycle_in_the_contact() -> None:
    """The mesh cycle of the second stage is 4.5 times that of the first: a shorter record misses its single contact."""
    model = alone(two_stages())
    del model["deviations"]
    found = epicyclic.load_factors(model, flanks="contact", tolerance=0.1).squeeze("case")
    np.testing.assert_allclose(found.coincidence_factor, 1.0, atol=0.02)


def test_pitch_deviations_are_what_accurate_teeth_have_not() -> None:
    plain = alone(MODEL) | {"stages": {"main": STAGE | {"helix_angle": "20 deg", "face_width": "70 mm"}}}
    accurate = epicyclic.load_factors(plain, flanks="contact", tolerance=0.3)
    np.testing.assert_array_equal(accurate.accuracy_load_factor, 1.0)
    steps = ", ".join(["0"] * 12 + ["15"] * 12)
    model = plain | {"deviations": {"sun": {"pitch": f"[{steps}] um"}}}
    found = epicyclic.load_factors(model, flanks="contact", tolerance=0.3).squeeze("case")
    options: dict[str, Any] = {"mesh": "main/sun-planet/1", "loads": (1.0,), "tolerance": 0.3}
    real, drawn = (float(epicyclic.contact(model, deviations=on, **options).pair_share.max()) for on in (True, False))
    assert real > 1.02 * drawn
    assert float(found.accuracy_load_factor[0]) == pytest.approx(real / drawn, rel=1e-6)
    np.testing.assert_array_equal(found.accuracy_load_factor[3:], 1.0)


def test_slices_give_k_h_beta_and_what_has_none_is_said() -> None:
    sun = STAGE["sun"] | {"support": {"radial": "5e7 N/m", "tilt": "2e5 N m/rad"}}
    model = alone(MODEL) | {"stages": {"main": STAGE | {"sun": sun, "helix_angle": "20 deg"}}, **PIN}
    result = epicyclic.load_factors(model)
    found = result.squeeze("case")
    factor = epicyclic.static(model).face_load_factor.values
    assert np.isnan(factor[3:]).all()
    np.testing.assert_allclose(found.face_load_factor, [*factor[:3], 1, 1, 1], rtol=1e-9)
    assert float(found.face_load_factor.max()) > 1.001
    assert found.face_load_basis.values.tolist() == ["slices"] * 3 + ["not known without slices"] * 3
    lead = tables_of(result)[0].lead
    assert "counts as 1: main/planet-ring/1, main/planet-ring/2, main/planet-ring/3." in lead


def test_tables_name_case_pair_and_flank() -> None:
    found = epicyclic.load_factors(MODEL, overrides=ALL)
    factors, flanks = tables_of(found)
    assert list(factors.columns["case"]) == ["full", "full", "part", "part", "reverse", "reverse"]
    assert list(factors.columns["flank"]) == [1, -1, 1, -1, -1, 1]
    assert list(flanks.columns["pair"]) == ["main/sun-planet"] * 2 + ["main/planet-ring"] * 2
    assert flanks.columns["torque a [N m]"][1] == pytest.approx(400 / 3)
    (finding,) = findings_of({"load_factors": found})
    assert "main/planet-ring/1 in case full" in finding.text


def test_tables_show_the_branch_that_carries_most() -> None:
    """K_v is about a mesh's own mean: of the branch that carries least it is the largest, and says the least."""
    found = epicyclic.load_factors(MODEL | PIN, overrides={"case": "full"})
    lead, heavy = found.isel(case=0, mesh=0), found.isel(case=0, mesh=1)
    assert float(lead.branch_load) < 0.9 < float(heavy.branch_load)
    assert float(lead.dynamic_factor) > float(heavy.dynamic_factor)
    assert tables_of(found)[0].columns["K_v"][0] == pytest.approx(float(heavy.dynamic_factor), rel=1e-3)
    assert tables_of(found)[0].columns["branch load"][0] == pytest.approx(float(found.k_gamma[0, 0]))


def test_csv_and_excel_hold_the_numbers_of_the_result(tmp_path: Path) -> None:
    model = tmp_path / "duty.toml"
    model.write_text(model_text(MODEL), encoding="utf-8")
    found = epicyclic.load_factors(str(model), overrides=ALL)
    for suffix in (".csv", ".xlsx"):
        saved = tmp_path / f"table{suffix}"
        done = CliRunner().invoke(app, ["load-factors", str(model), "--case", "all", "-o", str(saved)])
        assert done.exit_code == 0, done.output
        assert "main/sun-planet" in done.output
    long = pd.read_csv(tmp_path / "table.csv", low_memory=False)
    book = openpyxl.load_workbook(tmp_path / "table.xlsx")
    for name, sheet in (
        ("load_factor_product", "case x mesh"),
        ("pair_torque", "case x mesh_pair x mesh_gear"),
        ("load_cycles", "case x mesh_pair x mesh_gear"),
    ):
        expected = found[name].values.ravel()
        np.testing.assert_allclose(long.loc[long["variable"] == name, "value"].astype(float), expected, rtol=1e-12)
        head, *rows = book[sheet].iter_rows(values_only=True)
        column = next(i for i, cell in enumerate(head) if str(cell).split(" ")[0] == name)
        np.testing.assert_allclose([row[column] for row in rows], expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"exponent": 0.0}, "exponent = 0.0: out of range"),
        ({"flanks": "both"}, "flanks = 'both': not one of them; allowed: 'slices' or 'contact'"),
        ({"material": "wood"}, "material = 'wood'"),
        ({"life": "0 h"}, "life = 0"),
    ],
)
def test_wrong_options_are_told(options: dict[str, Any], problem: str) -> None:
    with pytest.raises(ModelError, match=problem):
        epicyclic.load_factors(MODEL, **options)


def test_trains_without_load_or_motion_are_told() -> None:
    idle = alone(MODEL) | {"operation": MODEL["operation"] | {"torque": {}}}
    with pytest.raises(ModelError, match="no torque loads the teeth"):
        epicyclic.load_factors(idle)
    locked = alone(MODEL) | {"operation": {"held": ["ring", "carrier"], "torque": {"sun": "800 N m"}}}
    with pytest.raises(ModelError, match="the train is locked"):
        epicyclic.load_factors(locked)
    with pytest.raises(ModelError, match="the model has no cases"):
        epicyclic.load_factors("ren2021", overrides=ALL)


def test_a_case_that_fails_leaves_the_others() -> None:
    cases = MODEL["cases"] | {"loose": {"held": [], "duration": "1 h"}}
    found = epicyclic.load_factors(MODEL | {"cases": cases}, overrides=ALL)
    assert found.case_status.values.tolist() == ["ok", "ok", "ok", "wrong input"]
    assert np.isfinite(found.load_factor_product.values[:3]).all()
    assert np.isnan(found.flank_equivalent_torque).all()
