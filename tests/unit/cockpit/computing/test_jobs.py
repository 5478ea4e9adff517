"""The jobs: what they say is what the verbs say; they tell their progress, stop, and refuse what they do not know."""

from __future__ import annotations

import re
import runpy
import shlex
import tomllib
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from epicyclic.cli.main import app
from epicyclic.cockpit.computing.answers import halved_text, halved_tolerance
from epicyclic.cockpit.computing.job_kinds import JOBS, envelope, job_keywords, relief_frame, tolerance_frame
from epicyclic.cockpit.state.frames import PageFrame, pack, speed_axis, unpack
from epicyclic.cockpit.state.state import command_line, opened, request_of, verb_script, with_value
from epicyclic.document.deviations import Distribution, read_distribution
from epicyclic.document.document import drive_text
from epicyclic.errors import ModelError
from epicyclic.questions.check.verbs import check
from epicyclic.questions.flanks.verbs import contact
from epicyclic.questions.rating import EXAMPLE_PARTS
from epicyclic.questions.response.verbs import sweep
from epicyclic.questions.sharing.verbs import sharing
from epicyclic.questions.tolerance.verbs import tolerance
from epicyclic.results.dataset import load_result
from epicyclic.show.views import findings_of, tables_of
from epicyclic.train.resolution import load

pytestmark = pytest.mark.usefixtures("few_turning_trains")

# Less than the defaults, which take a second or two each.
SMALL: dict[str, dict[str, Any]] = {
    "contact": {"samples": 16, "slices": 8},
    "relief": {"population": 4, "generations": 2},
    "stiffness": {"samples": 32},
    "output": {"samples": 256},
    "steady": {},
    "life": {"instants": 32},
    "tolerance": {"samples": 1024},
    "contact_loss": {"points": 6},
    "transient": {"cycles": 2.0},
    "detune": {"changes": 1},
    "cases": {"samples": 32},
    "sensitivity": {"of": "frequency"},
}

# The derivatives of each number of a small train; the other jobs need teeth and a load.
DRIVES = {"sensitivity": "lin1999-n4"}


# Load cases of ren2021: the one of their job has its pin errors and half of the torque.
CASES = """
[cases.whole]
duration = "60 h"

[cases.half]
torque.sun = "50 kN m"
duration   = "40 h"
"""


def text_of(name: str) -> str:
    text = drive_text(DRIVES.get(name, "ren2021"))
    pin = '[deviations]\nplanet.position.y = "[200, 0, 0] um"\n'
    if name == "life":
        parts = ", ".join(f"{key} = {value!r}" for key, value in EXAMPLE_PARTS.items())
        return text.replace('bearing = { radial = "1e9 N/m", z = "1e9 N/m" }', f"bearing = {{ {parts} }}")
    return text.replace("[deviations]\n", pin) + CASES if name == "cases" else text


class Stopped(BaseException):
    """What a cancelled job raises."""


@lru_cache
def done(name: str) -> tuple[PageFrame, Any, tuple[float, ...]]:
    told: list[float] = []
    source = tomllib.loads(text_of(name))
    frame, dataset = JOBS[name].run(source, {}, SMALL[name], lambda *d: told.append(d[0] / (d[1:] or (1,))[0]))
    return frame, dataset, tuple(told)


@pytest.mark.parametrize("name", list(JOBS))
def test_a_job_gives_a_frame_a_dataset_and_its_progress(name: str) -> None:
    frame, dataset, told = done(name)
    job = frame.head["job"]
    assert (frame.kind, job["name"]) == ("job", name)
    assert job["text"].endswith(".")
    assert "nan" not in job["text"]
    assert dataset.attrs["verb"] in (name, "contact_sweep")
    assert ("tables" in job) == (name in ("cases", "life", "output", "steady"))
    assert told
    assert all(0 <= share < 1 for share in told)  # what is left is packed and sent
    assert told[-1] > 0.9
    assert list(told) == sorted(told)
    came = unpack(pack(frame))
    if "lines" in job:
        curves = came.head["job"]["lines"]["curves"]
        assert came.arrays["job/y"].shape == (len(curves), came.arrays["job/x"].size)
        assert 1 <= sum(curve["strong"] for curve in curves) <= 4
    else:
        assert came.arrays["job/bar"].shape == (len(job["bars"]["rows"]),)


@pytest.mark.parametrize("name", list(JOBS))
def test_a_job_stops_where_its_progress_raises(name: str) -> None:
    def stop(*_: float) -> None:
        raise Stopped

    with pytest.raises(Stopped):
        JOBS[name].run(tomllib.loads(text_of(name)), {}, SMALL[name], stop)


@pytest.mark.parametrize("name", list(JOBS))
def test_a_job_refuses_an_option_it_does_not_have(name: str) -> None:
    with pytest.raises(ModelError) as caught:
        JOBS[name].run(tomllib.loads(drive_text("ren2021")), {}, {"folder": "/tmp"}, lambda *_: None)
    assert caught.value.path == f"{name}.folder"


@pytest.mark.parametrize("name", ["contact", "relief", "tolerance", "contact_loss", "transient"])
def test_a_job_says_what_the_model_lacks(name: str) -> None:
    with pytest.raises(ModelError) as caught:
        JOBS[name].run(tomllib.loads(drive_text("lin1999-n4")), {}, {}, lambda *_: None)
    assert caught.value.path


def test_contact_says_what_the_verb_says() -> None:
    frame, _, _ = done("contact")
    result = contact("ren2021", mesh="sun-planet", loads=(1.0,), samples=16, slices=8)
    swing = 1e6 * float(result["transmission_error_peak_to_peak"][0])
    assert f"{swing:.3g} µm peak to peak" in frame.head["job"]["text"]


def answers_of_job(frame: PageFrame) -> dict[str, Any]:
    return {answer["key"]: answer for answer in frame.head["answers"]}


def test_loads_of_contact_are_shares_of_the_load_of_operation() -> None:
    options = {**SMALL["contact"], "loads": (0.5, 0.75, 1.25), "mesh": "sun-planet"}
    result = contact("ren2021", **options)
    shown = JOBS["contact"].shown(result, load("ren2021"), {}).head["job"]["lines"]["curves"]
    assert [curve["label"] for curve in shown] == ["50 % load", "75 % load", "100 % load", "125 % load"]


def test_what_lowers_a_frequency_is_ranked_by_its_size() -> None:
    _, result, _ = done("sensitivity")
    values = np.zeros((result.sizes["path"], result.sizes["mode"]))
    values[2, :2], values[1, :2] = [-0.5, 0.1], [0.0, 0.25]
    ranked_by = ("mode", np.arange(result.sizes["mode"]) < 2)
    one_root = result.assign(sensitivity=(("path", "mode"), values), ranked_by=ranked_by)
    shown = JOBS["sensitivity"].shown(one_root, load("lin1999-n4"), {})
    assert shown.arrays["job/bar"][:2].tolist() == [-0.5, 0.25]


def test_tolerances_are_ranked_as_the_verb_ranks_them() -> None:
    frame, result, _ = done("tolerance")
    printed = tolerance("ren2021", samples=1024, effects="shares")
    for name in ("sobol_total", "system_tenth_less", "tenth_less_place", "system_k_gamma_quantile"):
        np.testing.assert_array_equal(result[name].values, printed[name].values)
    (table,) = [one for one in tables_of(printed) if one.title == "What buys what"]
    bars = frame.head["job"]["bars"]
    count = len(bars["rows"])
    assert 0 < count < result.sizes["tolerance"]
    assert [row.split("  ")[0] for row in bars["rows"]] == table.columns["place"][:count]
    at = {"definition": "mean-load", "probability": 0.99}
    value, low, high = (printed[f"system_tenth_less{end}"].sel(at).values for end in ("", "_low", "_high"))
    order = [list(printed.tolerance.values).index(path) for path in table.columns["tolerance"][:count]]
    for name, ends in (("bar", -value), ("low", -high), ("high", -low)):
        np.testing.assert_allclose(frame.arrays[f"job/{name}"], ends[order], rtol=1e-5)
    assert f"{result.sizes['tolerance'] - count} more take nothing off" in bars["note"]


def test_the_answers_of_the_job_are_the_finding_and_its_limit() -> None:
    frame, result, _ = done("tolerance")
    (finding,) = [one for one in findings_of({"tolerance": result}) if one.anchor == "tolerances"]
    found = answers_of_job(frame)
    quantile = float(result.system_k_gamma_quantile.sel(definition="mean-load", probability=0.99))
    assert (found["planet"]["then"], found["planet"]["limit"]["value"]) == (f"{quantile:.3f} at 99 %", 1.1)
    assert found["planet"]["text"] == finding.text
    assert found["planet"]["limit"]["words"] == "3 planets, table"
    assert found["error"]["text"].startswith(finding.change)
    assert "Shares of the variance overlap" in found["error"]["text"]
    assert frame.head["job"]["bars"]["scale"]["limit"] == 1.1
    assert "tolerance" in found["error"]["assumed"]


def test_below_the_limit_nothing_is_to_be_done_above_it_a_half_is_offered() -> None:
    met, _, _ = done("tolerance")
    found = answers_of_job(met)["error"]
    assert (found["figure"], found["apply"], met.head["job"]["apply"]) == ("nothing to do", None, None)
    assert met.head["job"]["met"]
    over = {"limits.k_gamma": 1.02}
    frame, result = JOBS["tolerance"].run(
        tomllib.loads(drive_text("ren2021")), over, {"samples": 1024}, lambda *_: None
    )
    found = answers_of_job(frame)
    assert (found["planet"]["level"], frame.head["job"]["met"]) == ("bad", False)
    assert found["planet"]["limit"] == {
        "value": 1.02,
        "words": "of the model",
        "source": "limits.k_gamma",
        "path": "limits.k_gamma",
    }
    first = result.tolerance.values[
        int(result.system_tenth_less.sel(definition="mean-load", probability=0.99).values.argmin())
    ]
    ((path, value),) = found["error"]["apply"].items()
    assert str(first).replace(".main.", ".") in path
    table = [check("ren2021", overrides=overrides) for overrides in ({}, {path: value})]
    before, after = (one["tolerance_std"].values[list(one["tolerance_path"].values).index(first)] for one in table)
    assert after == pytest.approx(before / 2)
    # a half that does not lower K_gamma is not offered
    flat = result.assign(k_gamma_by_scale=result.k_gamma_by_scale * 0 + 1.05)
    assert answers_of_job(tolerance_frame(flat, load("ren2021", over)))["error"]["apply"] is None


def test_relief_is_drawn_by_its_apply() -> None:
    frame, dataset, _ = done("relief")
    apply = frame.head["job"]["apply"]
    assert apply
    assert apply == frame.head["answers"][0]["apply"]
    result = contact("ren2021", overrides=apply, loads=(0.75, 1.0), samples=64, slices=40, mesh="sun-planet")
    after = float(dataset["objective_after"].values[0])
    assert float(result["transmission_error_peak_to_peak"].max()) == pytest.approx(after, rel=0.02)
    before, then = (float(one) for one in re.findall(r"from ([\d.]+) µm to ([\d.]+) µm", frame.head["job"]["text"])[0])
    assert then == pytest.approx(1e6 * after, rel=5e-3)
    assert before > then


@pytest.mark.parametrize(("left", "level"), [(0.97, "warn"), (0.99, "good")])
def test_page_and_terminal_judge_one_gain_of_a_relief(left: float, level: str) -> None:
    _, dataset, _ = done("relief")
    changed = dataset.copy()
    changed["objective_after"] = left * changed["objective_before"]
    (finding,) = findings_of({"relief": changed})
    (answer,) = relief_frame(changed, load("ren2021")).head["answers"]
    assert answer["level"] == level
    assert answer["text"] == f"{finding.text} {finding.change}".strip()
    assert finding.value == pytest.approx(1 - left)
    assert finding.limit == 0.02
    assert finding.change.startswith("Grind tip_relief.amount") == bool(answer["apply"]) == (level == "warn")
    assert answer["figure"] in str(finding.change) or level == "good"


@pytest.mark.parametrize(
    ("text", "half"),
    [
        ("normal(0, 12 um)", "normal(0, 6 um)"),
        ("rayleigh(7 um)", "rayleigh(3.5 um)"),
        ("disc(70 um)", "disc(35 um)"),
        ("truncated(1.9 MN m, 0.2 MN m, 1.4 MN m, 2.4 MN m)", "truncated(1.9 MN m, 0.1 MN m, 1.65 MN m, 2.15 MN m)"),
        ("triangular(-6 um, 0, 6 um)", "triangular(-3 um, 0, 3 um)"),
        ("uniform(-0.005 mm, 5 um)", "uniform(-0.0025 mm, 0.0025 mm)"),
        ("uniform(-1 deg, 1 deg)", "uniform(-0.5 deg, 0.5 deg)"),
        ("grade(ISO 1328-1:2013 5, 3 sigma)", "grade(ISO 1328-1:2013 3, 3 sigma)"),
        ("grade(IT8, 3 sigma)", "grade(IT6, 3 sigma)"),
        ("grade(IT6, 3 sigma)", None),  # ISO 286-1 as it is used here begins at IT5
        ("grade(ISO 1328-1:2013 2, 3 sigma)", None),
        ("uniform(-5 um, 5 um)", "uniform(-2.5 um, 2.5 um)"),
        ("uniform(10 um, 20 um)", "uniform(12.5 um, 17.5 um)"),
        ("grade(IT2, 3 sigma)", None),
        ("normal(3 um, 0 um)", None),  # no spread to halve
        ("uniform(5 um, 5 um)", None),
        ("nonsense", None),
    ],
)
def test_half_of_a_distribution(text: str, half: str | None) -> None:
    assert halved_text(text) == half


@pytest.mark.parametrize("text", ["triangular(-5 um, 0, 10 um)", "truncated(0, 12 um, -20 um, 8 um)"])
def test_half_of_a_distribution_is_the_spread_that_tolerance_halves(text: str) -> None:
    def read(text: str) -> Distribution:
        found = read_distribution(text, lambda part: float(part.split()[0]), vector=False, where="here")
        assert isinstance(found, Distribution)
        return found

    half = halved_text(text)
    assert half is not None
    assert read(half).std == pytest.approx(0.5 * read(text).std, rel=1e-5)
    assert read(half).values == pytest.approx(read(text).scaled(0.5).values, rel=1e-5)


def test_own_and_common_parts_are_halved_alone() -> None:
    train = load("ren2021")
    (path,) = halved_tolerance(train, "deviations.main.meshes.sun-planet.gap own")
    assert path == 'tolerance."deviations.meshes.sun-planet.gap"'
    value: Any = halved_tolerance(train, "deviations.main.meshes.sun-planet.gap own")[path]
    assert value == {"own": "normal(0, 3 um)", "common": "normal(0, 10 um)"}
    load("ren2021", {path: value})


def test_transmission_errors_are_drawn_by_their_kinds() -> None:
    frame, result, _ = done("steady")
    train, error = load("ren2021"), result["transmission_error_shaft"]
    shafts = JOBS["steady"].shown(result, train, {"show": "shaft to shaft"})
    (curve,) = shafts.arrays["job/y"]
    np.testing.assert_allclose(curve, error[0].values * 180 / np.pi * 3600, rtol=1e-5)
    assert shafts.head["job"]["lines"]["curves"][0]["label"] == "main.carrier by main.sun"
    assert "[arcsec]" in shafts.head["job"]["lines"]["y_label"]
    assert len(frame.arrays["job/y"]) == result.sizes["mesh"]
    alone = result.drop_vars([name for name in result.variables if "transmission_error_shaft" in str(name)])
    with pytest.raises(ModelError, match=r"no two shafts turn by a ratio.*by rotation or by approach"):
        JOBS["steady"].shown(alone, train, {"show": "shaft to shaft"})


def test_every_job_says_what_it_does_by_default() -> None:
    assert set(JOBS) == {
        "cases",
        "contact",
        "relief",
        "stiffness",
        "output",
        "steady",
        "life",
        "tolerance",
        "contact_loss",
        "transient",
        "detune",
        "sensitivity",
    }
    for name, kind in JOBS.items():
        assert kind.name == name
        assert kind.about.endswith(".")
        assert kind.label
        assert 0 < kind.counted[0] < kind.counted[1] < 1
        assert set(kind.grows) <= set(kind.options)
        assert kind.seconds(0.1, 2) >= kind.seconds(0.1, 1) > 0
        assert kind.work({}) == 1
    assert JOBS["contact_loss"].work({"points": 120, "shaft_orders": True}) == pytest.approx(40)


@pytest.mark.parametrize("name", list(JOBS))
def test_command_line_and_script_of_a_job_give_what_the_page_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    kind, drive = JOBS[name], DRIVES.get(name, "ren2021")
    if name in ("cases", "life"):
        drive = "duty"
        (tmp_path / "duty.toml").write_text(text_of(name), encoding="utf-8")
    model = "duty.toml" if drive == "duty" else drive
    state = with_value(opened(model), "stages.main.sun.support.radial", "0.9 GN/m")
    page, _ = kind.run(*request_of(state), SMALL[name], lambda *_: None)
    keywords = job_keywords(name, *request_of(state), SMALL[name])
    state = replace(state, overrides={**state.overrides, **kind.overrides})
    words = shlex.split(command_line(state, kind.verb, keywords))
    ran = CliRunner().invoke(app, [*words[1:], "-o", "out.nc"], env={"COLUMNS": "1000"})
    assert ran.exit_code == 0, ran.output
    train = load(model, {"stages.main.sun.support.radial": "0.9 GN/m"})
    script = verb_script(state, kind.verb, keywords)
    (tmp_path / "job.py").write_text(script, encoding="utf-8")
    capsys.readouterr()
    runpy.run_path("job.py", run_name="__main__")
    printed = capsys.readouterr().out
    for file in ("out.nc", f"{drive}-{kind.verb}.nc"):
        again = kind.shown(load_result(tmp_path / file), train, SMALL[name])
        assert again.head["job"]["text"] == page.head["job"]["text"]
        for array, values in page.arrays.items():
            np.testing.assert_allclose(again.arrays[array], values, rtol=1e-5, atol=1e-12)
    for number in re.findall(r"\d+\.\d+", page.head["job"]["text"]):
        assert number in printed
        assert number in ran.output


def test_the_load_cases_stand_beside_each_other() -> None:
    frame, _, _ = done("cases")
    job = frame.head["job"]
    assert "Fails in whole, half, 100 % of the time." in job["text"]
    assert "Least margin in half, 40 % of the time" in job["text"]
    assert job["bars"]["rows"] == ["whole", "half"]
    source = tomllib.loads(text_of("cases"))
    for place, case in enumerate(("whole", "half")):
        alone = sharing(source, overrides={"case": case}, method="static", samples=32)
        k = float(alone["system_load_sharing"].sel(definition="mean-load"))
        assert frame.arrays["job/bar"][place] == pytest.approx(k, rel=1e-6)
        assert f'<td class="number">{k:.4g}</td>' in job["tables"]
    for words in ("duration [h]", "K_gamma", "ratio", "limit", "power [kW]"):
        assert f">{words}</th>" in job["tables"]
    # a lever of the operation is of the cases that state it, in every column
    moved, _ = JOBS["cases"].run(source, {"operation.torque.sun": "70 kN m"}, SMALL["cases"], lambda *_: None)
    shown = sharing(source, overrides={"case": "half", "operation.torque.sun": "70 kN m"}, method="static", samples=32)
    k = float(shown["system_load_sharing"].sel(definition="mean-load"))
    assert moved.arrays["job/bar"][1] == pytest.approx(k, rel=1e-6)
    assert moved.head["job"]["tables"].count('<td class="number">70000</td>') == 2
    assert "50000" not in moved.head["job"]["tables"]
    bad = {"held": ["ring", "sun", "carrier"], "duration": "5 h"}
    failing, _ = JOBS["cases"].run(
        {**source, "cases": {**source["cases"], "bad": bad}}, {}, SMALL["cases"], lambda *_: None
    )
    assert ">bad</td>" in failing.head["job"]["tables"]
    assert "bad has no result: " in failing.head["job"]["text"]
    hostile = {**source, "cases": {"<b>x</b>": {"duration": "1 h"}}}
    with pytest.raises(ModelError, match="cases"):
        JOBS["cases"].run(hostile, {}, SMALL["cases"], lambda *_: None)
    with pytest.raises(ModelError, match="has no cases"):
        JOBS["cases"].run(tomllib.loads(drive_text("ren2021")), {}, {}, lambda *_: None)


def test_an_envelope_keeps_every_peak() -> None:
    x = np.arange(100_001.0)
    y = np.sin(x / 300) + 0.1 * np.cos(x * 2.2)
    y[77_777], y[31], y[50_000] = 9.0, -7.0, np.nan
    fewer, (kept, half) = envelope(x, np.array([y, 0.5 * y]), 2000)
    assert len(fewer) == len(kept) <= 2000
    assert (np.diff(fewer) > 0).all()
    assert (np.nanmax(kept), np.nanmin(kept), np.nanmax(half)) == (9.0, -7.0, 4.5)
    assert abs(fewer[np.nanargmax(kept)] - 77_777) <= 100
    for left in range(0, 100_000, 10_000):  # the least and the largest of any part
        part, at = y[left : left + 10_000], (fewer >= left) & (fewer < left + 10_000)
        assert np.nanmax(kept[at]) == pytest.approx(np.nanmax(part), abs=0.02)
    short, (same,) = envelope(x[:50], y[None, :50], 2000)
    np.testing.assert_array_equal(short, x[:50])
    np.testing.assert_array_equal(same, y[:50])


def test_contact_loss_stands_over_the_linear_curve_on_the_axis_of_the_sweep() -> None:
    frame, result, _ = done("contact_loss")
    curves = [curve["label"] for curve in frame.head["job"]["lines"]["curves"]]
    assert curves == ["linear, largest", "run-up, largest", "coast-down, largest", "least of both"]
    assert [curve["pale"] for curve in frame.head["job"]["lines"]["curves"]] == [True, False, False, False]
    axis = speed_axis(load("ren2021"))
    assert axis is not None
    assert frame.head["job"]["lines"]["x_label"] == axis[0]
    np.testing.assert_allclose(frame.arrays["job/x"], axis[1] * result["speed"].values, rtol=1e-6)
    linear = sweep("ren2021", relative_speed=result["speed"].values, shaft_orders=False)
    largest = np.nanmax(linear["mesh_force_peak"].values, axis=0) / 1e3
    np.testing.assert_allclose(frame.arrays["job/y"][0], largest, rtol=1e-5)
    assert frame.head["job"]["lines"]["zero"]
    assert frame.head["job"]["title"].endswith("mesh orders")
    lost = result.copy(deep=True)
    for one in ("mesh_force_peak", "mesh_force_minimum", "contact_open"):
        lost[one][:] = np.nan
    lost.attrs["warnings"] = '["no motion was found at 12 points [no-motion-found]"]'
    said = JOBS["contact_loss"].shown(lost, load("ren2021"), {}).head["job"]["text"]
    assert said == "No motion was found at 12 points."


def test_a_relief_that_is_drawn_keeps_its_numbers_and_the_curve_follows_it_by_contact() -> None:
    frame, result, _ = done("relief")
    drawn, follows = frame.head["kept"]
    assert drawn["overrides"] == frame.head["job"]["apply"]
    before, after = (1e6 * float(result[f"objective_{when}"].values[0]) for when in ("before", "after"))
    force = 1e-3 * float(result["relieved_force"].values[0])
    (answer,) = drawn["answers"]
    assert answer["text"].startswith("is drawn: transmission error")
    assert f"{before:.3g} µm before, {after:.3g} µm after at {0.75 * force:.3g} to {force:.3g} kN" in answer["text"]
    assert answer["apply"] == {
        f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")
    }
    assert follows["overrides"] == {**drawn["overrides"], **answer["apply"]}
    assert follows["answers"][0]["apply"] is None
    # of the stiffness of ISO 6336 the curve does not know the relief, of that of contact it does
    none: dict[str, object] = {}
    plain, relieved, with_contact = (
        sweep("ren2021", overrides=overrides, points=4, shaft_orders=False)["mesh_force_rms"].values
        for overrides in (none, drawn["overrides"], answer["apply"])
    )
    followed = sweep("ren2021", overrides=follows["overrides"], points=4, shaft_orders=False)["mesh_force_rms"].values
    np.testing.assert_array_equal(plain, relieved)
    assert np.abs(followed / with_contact - 1).max() > 0.02  # of the dynamic force
