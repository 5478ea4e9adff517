"""Verbs over all cases: each case as it is alone, one that fails, files, terminal and report."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic import ModelError
from epicyclic.cli.main import app
from epicyclic.results.dataset import cases_of
from epicyclic.show.report import difference_table
from epicyclic.show.views import findings_of, tables_of
from epicyclic.verbs.cases import over_cases

SPEEDS = {"low": "700 rpm", "high": "1100 rpm"}
MODEL: dict[str, Any] = {
    "format": 2,
    "title": "Cases",
    "damping": {"modal": 0.06},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"x": "5e7 N/m", "y": "5e7 N/m"}},
            "planet": {"teeth": 30, "bearing": {"x": "4e8 N/m", "y": "4e8 N/m"}},
            "ring": {"teeth": 84},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
    "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}},
    "cases": {
        "low": {"speed": {"sun": SPEEDS["low"]}, "torque": {"sun": "300 N m"}, "duration": "30 h"},
        "high": {"speed": {"sun": SPEEDS["high"]}, "duration": "10 h"},
    },
}
UNDETERMINED = {**MODEL["cases"], "loose": {"held": [], "duration": "0 h"}}


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    if "error_line" in other.dims:  # lines of either case stand in both
        one = one.sel(error_line=other["error_line"].values)
    assert set(one.variables) == set(other.variables)
    for name, array in other.variables.items():
        assert one[name].dims == array.dims, name
        assert one[name].dtype.kind == array.dtype.kind or array.dtype.kind in "OU", name
        if array.dtype.kind in "fcib":
            np.testing.assert_array_equal(one[name].values, array.values, err_msg=str(name))
        else:
            assert list(map(str, one[name].values.ravel())) == list(map(str, array.values.ravel())), name


@cache
def result_of(verb: str, case: str, **options: Any) -> xr.Dataset:
    """What a verb finds of the model in a case, or in all; tests share it and none changes it."""
    result: xr.Dataset = getattr(epicyclic, verb)(MODEL, overrides={"case": case}, **options)
    return result


@pytest.mark.parametrize(
    ("verb", "options"), [("check", {}), ("modes", {}), ("sharing", {}), ("steady", {}), ("sweep", {"points": 7})]
)
def test_each_case_is_as_it_is_alone(verb: str, options: dict[str, Any]) -> None:
    whole = result_of(verb, "all", **options)
    assert whole.attrs["verb"] == "cases"
    assert list(whole["case"].values) == ["low", "high"]
    assert "case" not in json.loads(whole.attrs["model"])
    assert whole["case_duration"].values.tolist() == [108000, 36000]
    assert whole["case_share"].values.tolist() == [0.75, 0.25]
    cases = cases_of(whole)
    for name in SPEEDS:
        alone = result_of(verb, name, **options)
        same(cases[name], alone)
        shared = {"title", "doi", "model", "assumed"}
        assert {k: v for k, v in cases[name].attrs.items() if k not in shared} == {
            k: v for k, v in alone.attrs.items() if k not in shared
        }


def test_a_case_that_is_not_determined_is_named_and_the_others_go_on() -> None:
    whole = epicyclic.modes({**MODEL, "cases": UNDETERMINED}, overrides={"case": "all"})
    assert whole["case_status"].values.tolist() == ["ok", "ok", "wrong input"]
    (said,) = [text for text in json.loads(whole.attrs["warnings"]) if "has no result" in text]
    assert said.startswith("loose has no result: operation.speed = ['main.sun']: the train has 2 freedoms")
    assert list(cases_of(whole)) == ["low", "high"]
    assert "2 freedoms" in str(tables_of(whole)[0].columns["modes"][2])
    with pytest.raises(ModelError, match=r"case = all: every case fails, loose with: operation\.speed"):
        epicyclic.modes({**MODEL, "cases": {"loose": UNDETERMINED["loose"]}}, overrides={"case": "all"})


@pytest.mark.parametrize(
    ("source", "options", "words"),
    [
        ("ren2021", {}, r"case = all: the model has no cases; allowed: tables \[cases.NAME\]"),
        (epicyclic.load("ren2021"), {}, "case = all: cases belong to a model file"),
        (
            MODEL,
            {"vary": {"sun.tip_relief.amount": ["5 um"]}, "folder": "somewhere"},
            "folder = somewhere: goes with one case",
        ),
    ],
)
def test_refusals(source: Any, options: dict[str, Any], words: str) -> None:
    verb = epicyclic.relief if options else epicyclic.modes
    with pytest.raises(ModelError, match=words):
        verb(source, overrides={"case": "all"}, **options)


def test_progress_runs_once_over_all_cases() -> None:
    said: list[float] = []

    def step(done: int, of: int) -> None:
        said.append(done / of)

    epicyclic.sweep(MODEL, overrides={"case": "all"}, points=5, progress=step)
    assert said == sorted(said)
    assert said[-1] == 1
    assert 0 < min(said) <= 0.5


def test_exceedance_over_the_duty_is_weighted_by_the_time() -> None:
    model = {**MODEL, "tolerance": {"deviations.planet.position.y": "normal(0, 5 um)"}, "deviations": {}}
    options: dict[str, Any] = {"samples": 512, "seed": 3}
    whole = epicyclic.tolerance(model, overrides={"case": "all"}, **options)
    alone = {name: epicyclic.tolerance(model, overrides={"case": name}, **options) for name in SPEEDS}
    above = {name: float(one["system_exceedance"].values[0, 0]) for name, one in alone.items()}
    assert 0 < above["high"] < above["low"] < 1
    table = next(one for one in tables_of(whole) if one.title.startswith("K_gamma"))
    assert table.columns["above it [%]"] == pytest.approx([100 * above["low"], 100 * above["high"]])
    weighted = 0.75 * above["low"] + 0.25 * above["high"]  # 30 h and 10 h
    said = re.search(r"above its limit in ([\d.]+) % of the time", table.lead)
    assert said is not None
    assert float(said[1]) == pytest.approx(100 * weighted, rel=5e-3)


def test_the_torque_of_a_case_is_its_own_where_that_of_the_operation_is_toleranced() -> None:
    law = {"deviations.planet.position.y": "normal(0, 5 um)"}
    plain, drawn = (
        {**MODEL, "deviations": {}, "tolerance": table}
        for table in (law, {**law, "operation.torque.sun": "normal(800 N m, 40 N m)"})
    )
    options: dict[str, Any] = {"samples": 512, "seed": 3, "effects": "none"}
    of_low, with_torque = (epicyclic.tolerance(one, overrides={"case": "low"}, **options) for one in (plain, drawn))
    without, quantiles = (one["system_k_gamma_quantile"].values for one in (of_low, with_torque))
    np.testing.assert_allclose(quantiles, without, rtol=1e-12)
    assert any("[tolerance-of-another-case]" in text for text in json.loads(with_torque.attrs["warnings"]))
    nominal = epicyclic.tolerance(drawn, **options)["system_k_gamma_quantile"].values
    assert (nominal < quantiles).all()  # 800 N m for 300 N m: the same errors part less


def test_findings_say_what_fails_how_long_and_what_has_the_least_margin() -> None:
    model = {**MODEL, "tolerance": {"deviations.planet.position.y": "normal(0, 5 um)"}, "deviations": {}}
    model["limits"] = {"k_gamma": 1.1}
    whole = epicyclic.tolerance(model, overrides={"case": "all"}, samples=512, seed=3)
    alone = {
        name: findings_of({"": epicyclic.tolerance(model, overrides={"case": name}, samples=512, seed=3)})
        for name in SPEEDS
    }
    tones = {name: next(one.tone for one in own if one.limit == 1.1) for name, own in alone.items()}
    assert tones == {"low": "bad", "high": "caution"}
    value = {name: next(one.value for one in own if one.limit == 1.1) for name, own in alone.items()}
    first, second = findings_of({"": whole})
    assert (first.tone, first.text) == ("bad", "Fails in low, 75 % of the time.")
    own = next(one.text for one in alone["low"] if one.limit == 1.1)
    assert second.text == f"Least margin in low, 75 % of the time, {100 * value['low'] / 1.1:.3g} % of its limit: {own}"
    assert (second.value, second.limit) == (value["low"], 1.1)


def test_progress_of_shares_runs_once_over_all_cases() -> None:
    said: list[float] = []

    def run(source: object, overrides: dict[str, object], progress: Any) -> xr.Dataset:
        for share in (0.5, 1.0):
            progress(share)
        return epicyclic.static(source, overrides=overrides)  # type: ignore[arg-type]

    over_cases(run, MODEL, {"case": "all"}, {"progress": said.append})
    assert said == [0.25, 0.5, 0.75, 1.0]


def test_numbers_of_the_cases_stand_beside_each_other() -> None:
    def table(verb: str, title: str) -> dict[str, Any]:
        whole = result_of(verb, "all")
        return dict(next(one for one in tables_of(whole) if one.title.startswith(title)).columns)

    forces = table("static", "Mesh forces")["largest mesh force [kN]"]
    assert forces == pytest.approx([float(result_of("static", name).mesh_force.max()) / 1e3 for name in SPEEDS])
    assert forces[1] > 2 * forces[0]
    shares = table("sharing", "K_gamma")
    for at, name in enumerate(SPEEDS):
        own = result_of("sharing", name).system_load_sharing
        assert shares["K_gamma"][at] == pytest.approx(float(own.sel(definition="mean-load")))
        assert shares["while turning"][at] == pytest.approx(float(own.sel(definition="mean-load-turning")))
    nearest = table("modes", "Nearest resonance")
    assert nearest["case"] == list(SPEEDS)
    weaker_nearer = []
    for at, name in enumerate(SPEEDS):
        own = result_of("modes", name)
        strong = own.resonance_near.values & (own.resonance_force_ratio.values >= 0.05)
        away = np.abs(own.resonance_speed.values - 1)
        assert 100 * abs(nearest["at [% of its speed]"][at] / 100 - 1) == pytest.approx(100 * away[strong].min())
        weaker_nearer.append(away[own.resonance_near.values].min() < away[strong].min())
    assert any(weaker_nearer)


def test_a_warning_of_several_cases_is_said_once() -> None:
    whole = result_of("check", "all")
    said = json.loads(whole.attrs["warnings"])
    assert sum("tips of ring reach" in text for text in said) == 1
    assert any(text.startswith("every case: stages.main.meshes.planet-ring: the tips of ring") for text in said)


def toml(folder: Path, cases: dict[str, Any] = UNDETERMINED) -> str:
    from epicyclic.document.writer import model_text

    path = folder / "cases.toml"
    path.write_text(model_text({**MODEL, "cases": cases}), encoding="utf-8")
    return str(path)


def test_terminal_and_file(tmp_path: Path) -> None:
    model, saved = toml(tmp_path), tmp_path / "cases.nc"
    done = CliRunner().invoke(app, ["modes", model, "--case", "all", "-o", str(saved)])
    assert done.exit_code == 0, done.output
    assert "resonances within" in done.output
    again = CliRunner().invoke(app, ["show", str(saved)])
    assert again.exit_code == 0, again.output
    assert "Load cases" in again.output
    assert "loose" in again.output
    check = CliRunner().invoke(app, ["check", model, "--case", "all"]).output
    for text in ("main.carrier", "75", "155.556", "244.444", "-1350", "-3600"):
        assert text in check.split(), text
    efficiency = float(epicyclic.efficiency(MODEL, overrides={"case": "low"})["train_efficiency"])
    assert f"{100 * efficiency:.6g}" in check.split()
    alone = CliRunner().invoke(app, ["check", model, "--case", "low"]).output
    assert "700 rpm to 155.556 rpm" in alone
    wrong = CliRunner().invoke(app, ["check", model, "--case", "lo"])
    assert wrong.exit_code == 2
    assert "--case = lo: no such case; did you mean 'low'?" in wrong.output


def test_a_verb_that_keeps_its_run_writes_all_cases_and_a_figure_is_of_one(tmp_path: Path) -> None:
    model, saved = toml(tmp_path, MODEL["cases"]), tmp_path / "swept.nc"
    done = CliRunner().invoke(app, ["sweep", model, "--case", "all", "--points", "3", "-o", str(saved)])
    assert done.exit_code == 0, done.output
    assert saved.is_file()
    refused = CliRunner().invoke(app, ["modes", model, "--case", "all", "--figure", "frequencies", "-o", "x.svg"])
    assert refused.exit_code == 2
    assert "--figure = frequencies: is of one case; allowed: --case with its name" in refused.output


def test_a_report_has_the_cases_side_by_side(tmp_path: Path) -> None:
    page = tmp_path / "cases.html"
    words = ["report", toml(tmp_path), "--case", "all", "--sections", "modes", "-o", str(page)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "left out: case loose: operation.speed" in done.output
    text = page.read_text(encoding="utf-8")
    assert "<h1>Cases: load cases</h1>" in text
    assert text.count("low") > 3
    assert text.count("high") > 3
    again = [word if word != "--case" else "--set" for word in words]
    again[again.index("all")] = "case=all"
    assert CliRunner().invoke(app, again).exit_code == 0
    assert page.read_text(encoding="utf-8").count("high") == text.count("high")


def test_of_more_than_two_none_is_set_against_another() -> None:
    own = {"check": epicyclic.check(MODEL)}
    assert list(difference_table({"a": own, "b": own}).columns) == ["", "a", "b", "b against a"]
    assert list(difference_table({"a": own, "b": own, "c": own}).columns) == ["", "a", "b", "c"]


def test_a_case_without_weight_beside_others_is_told_and_nothing_is_weighed() -> None:
    model = {**MODEL, "cases": {**MODEL["cases"], "free": {"speed": {"sun": "500 rpm"}}}}
    whole = epicyclic.sharing(model, overrides={"case": "all"}, method="static")
    assert np.isnan(whole["case_share"].values).all()
    assert "neither duration nor share of free [cases-not-weighed]" in whole.attrs["warnings"]
    assert "of the time" not in " ".join(one.text for one in findings_of({"": whole}))
    assert (
        "cases-not-weighed"
        not in epicyclic.sharing(MODEL, overrides={"case": "all"}, method="static").attrs["warnings"]
    )


def test_a_resonance_at_which_no_motion_is_found_does_not_count_beside_others() -> None:
    whole = result_of("modes", "all")
    (table,) = [one for one in tables_of(whole) if one.title.startswith("Nearest resonance")]
    (name, *_), at = table.columns["case"], float(table.columns["at [% of its speed]"][0])
    speed = whole["resonance_speed"].sel(case=name).values
    place = np.isclose(100 * speed, at)

    def nearest(others: float) -> dict[str, float]:
        """The table where no motion is found at that resonance, and the others make so much force."""
        lost, ratio = whole.copy(deep=True), np.full(speed.size, others)
        ratio[place] = np.nan
        lost["resonance_force_ratio"].loc[{"case": name}] = ratio
        lost["resonance_near"].loc[{"case": name}] = np.abs(speed - 1) < 0.5
        lost["resonance_excited"].loc[{"case": name}] = "yes"
        found = [one for one in tables_of(lost) if one.title.startswith("Nearest resonance")]
        return (
            {}
            if not found
            else dict(zip(found[0].columns["case"], found[0].columns["at [% of its speed]"], strict=True))
        )

    assert name not in nearest(0.01)  # too little, or not known
    assert nearest(0.5)[name] != at
    assert nearest(np.nan)[name] == at  # of none is anything known
