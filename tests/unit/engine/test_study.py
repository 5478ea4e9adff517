"""Studies: a verb over many points equals the verb run at each of them; job files that are wrong say where."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.engine.plain_data import plain_bytes, plain_value
from epicyclic.engine.points import run_study, stacked
from epicyclic.errors import ModelError

Tables = dict[str, Any]

MODEL = """
format = 2
title = "A planetary set"

[stages.main]
planets = 3
module = "4 mm"
face_width = "50 mm"
sun = { teeth = 24, support.radial = "5e7 N/m" }
planet = { teeth = 30, bore = "60 mm", bearing.radial = "4e8 N/m" }
ring = { teeth = 84, rim = "25 mm" }
carrier = { mass = "40 kg", inertia = "0.5 kg m^2" }

[operation]
held = ["ring"]
speed.sun = "1500 rpm"
torque.sun = "800 N m"

[deviations]
planet.run_out = "15 um"
"""

JOB = """
verb = "modes"
model = "set.toml"
options.damped = false
overrides."stages.main.sun.support.radial" = "1e8 N/m"

[grid]
"stages.main.planet.bearing.radial" = { from = "1e8 N/m", to = "9e8 N/m", points = 3, scale = "log" }
stages.main.planets = [3, 4]
options.relative_speed = [0.0, 0.5]
"""
BEARING = "stages.main.planet.bearing.radial"
SHORT = JOB.replace("options.relative_speed = [0.0, 0.5]\n", "")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "set.toml").write_text(MODEL)
    (tmp_path / "jobs" / "job.toml").write_text(JOB)
    (tmp_path / "jobs" / "short.toml").write_text(SHORT)
    return tmp_path / "jobs"


@pytest.fixture
def torsional(torsional_set: Callable[..., Tables]) -> Tables:
    """A set that is solved in a few ms."""
    return torsional_set(modal=0.02)


def test_every_point_is_what_the_verb_gives(folder: Path) -> None:
    shares = list[float]()
    result = epicyclic.study(folder / "job.toml", progress=shares.append)
    assert result.frequency.dims == (BEARING, "stages.main.planets", "options.relative_speed", "mode")
    assert (result.status == "ok").all()
    assert shares == [k / 12 for k in range(13)]
    np.testing.assert_allclose(result[BEARING], [1e8, 3e8, 9e8], rtol=1e-15)
    assert result[BEARING].attrs["units"] == "N/m"
    assert result["stages.main.planets"].values.tolist() == [3, 4]
    for bearing, text in ((0, 1e8), (2, "9e8 N/m")):
        for planets in (3, 4):
            single = epicyclic.modes(
                folder / "set.toml",
                overrides={
                    **{"stages.main.sun.support.radial": "1e8 N/m", BEARING: text},
                    "stages.main.planets": planets,
                },
                relative_speed=0.5,
            )
            point = result.isel({BEARING: bearing}).sel({"stages.main.planets": planets, "options.relative_speed": 0.5})
            modes = single.sizes["mode"]
            assert point.frequency.values[:modes].tobytes() == single.frequency.values.tobytes()
            assert np.isnan(point.frequency.values[modes:]).all()
            assert point.mode_kind.values.tolist() == [
                *single.mode_kind.values.tolist(),
                *[""] * (point.sizes["mode"] - modes),
            ]
            # a set of three planets has no fourth, so nothing stands there
            shares_of = point.kinetic_energy_share.sel(body=single.body).values[:, :modes]
            assert shares_of.tobytes() == single.kinetic_energy_share.values.tobytes()
    assert result.sizes["mode"] > modes - 1
    assert json.loads(result.attrs["options"])["verb"] == "modes"


def test_a_result_is_saved_and_reopened(folder: Path) -> None:
    result = epicyclic.study(folder / "short.toml")
    epicyclic.save_result(result, folder / "out.nc")
    assert epicyclic.load_result(folder / "out.nc").identical(result)
    assert json.loads(epicyclic.to_json(result))["attrs"]["studied"] == "modes"


def test_a_point_that_fails_holds_nothing_and_its_reason(torsional: Tables) -> None:
    result = epicyclic.study(
        {"verb": "modes", "model": torsional, "list": {"stages.main.sun.inertia": [0.002, -1.0, 0.004]}}
    )
    assert result.status.values.tolist() == ["ok", "wrong input", "ok"]
    assert "stages.main.sun.inertia = -1.0" in str(result.reason.values[1])
    assert np.isnan(result.frequency.values[1]).all()
    assert np.isfinite(result.frequency.values[[0, 2]]).all()
    assert any(
        "1 of 3 points failed, the first with: stages.main.sun.inertia = -1.0" in text
        for text in json.loads(result.attrs["warnings"])
    )
    with pytest.raises(ModelError, match=r"every point fails, the first with: stages.main.ring.teeth = 30"):
        epicyclic.study({"verb": "modes", "model": torsional, "list": {"stages.main.ring.teeth": [30, 31]}})


def test_warnings_of_points_keep_their_order() -> None:
    said = [f"{letter} [points-rounded]" for letter in "fbdaec"]
    point = xr.Dataset({"mass": ((), 1.0)}, attrs={"verb": "check", "warnings": json.dumps(said)})
    job = {"verb": "check", "model": "ren2021", "list": {"options.speed": [1, 2]}}
    result = run_study(job, lambda verb: lambda model, overrides, options: point, {"check": ("speed",)})
    assert json.loads(result.attrs["warnings"]) == said


def test_a_warning_of_every_point_that_does_not_fail_has_no_place() -> None:
    every, one = "every [points-rounded]", "one [points-rounded]"

    def point(speed: object) -> xr.Dataset:
        if speed == 2:
            raise ModelError("no load")
        said = [every, one] if speed == 3 else [every]
        return xr.Dataset({"mass": ((), 1.0)}, attrs={"verb": "check", "warnings": json.dumps(said)})

    job = {"verb": "check", "model": "ren2021", "list": {"options.speed": [1, 2, 3]}}
    result = run_study(
        job, lambda verb: lambda model, overrides, options: point(options["speed"]), {"check": ("speed",)}
    )
    _, *told = json.loads(result.attrs["warnings"])
    assert told == [every, f"at 1 of 3 points: {one}"]


def test_one_process_workers_and_a_resumed_run_agree(folder: Path) -> None:
    pytest.importorskip("zarr")
    pytest.importorskip("distributed")
    whole = epicyclic.study(folder / "short.toml")

    class Stop(Exception):
        pass

    def stop(share: float) -> None:
        if share > 0.4:
            raise Stop

    with pytest.raises(Stop):
        epicyclic.study(folder / "short.toml", store=folder / "store", progress=stop)
    assert len(list((folder / "store" / "done").glob("c.*"))) == 3
    resumed = epicyclic.study(folder / "short.toml", store=folder / "store", resume=True)
    assert resumed.identical(whole)
    assert epicyclic.study(folder / "short.toml", store=folder / "other", workers=2).identical(whole)
    files = {path.relative_to(folder / "store") for path in (folder / "store").rglob("*") if path.is_file()}
    assert all((folder / "store" / name).read_bytes() == (folder / "other" / name).read_bytes() for name in files)
    (folder / "short.toml").write_text(SHORT.replace("3, 4", "3, 5"))
    with pytest.raises(ModelError, match=r"other options \(points\)"):
        epicyclic.study(folder / "short.toml", store=folder / "store", resume=True)


@pytest.mark.parametrize("sampler", ["random", "sobol"])
def test_draws_follow_their_distributions(sampler: str, torsional: Tables) -> None:
    sun, ring = (f"stages.main.meshes.{pair}.stiffness" for pair in ("sun-planet", "planet-ring"))
    job = {
        "verb": "stiffness",
        "model": torsional,
        "keep": ["mesh_stiffness"],
        "seed": 3,
        sampler: {
            "points": 64,
            sun: "uniform(1e8 N/m, 3e8 N/m)",
            ring: {"from": "1e8 N/m", "to": "1e10 N/m", "scale": "log"},
            "options.samples": [16, 32],
        },
    }
    result = epicyclic.study(job)
    # four standard errors of 64 samples, relative to the standard deviation; those of Sobol are far less
    off = {"random": 4.0 / 8, "sobol": 0.08}[sampler]
    assert abs(result[sun].values.mean() - 2e8) < off * 1e8 / np.sqrt(3)
    assert result[sun].values.min() > 1e8
    assert result[sun].values.max() < 3e8
    assert abs(np.log10(result[ring].values).mean() - 9) < off / np.sqrt(3)
    assert set(result["options.samples"].values) == {16.0, 32.0}
    assert abs((result["options.samples"].values == 16).mean() - 0.5) < off / 2
    assert list(result.data_vars) == ["mesh_stiffness", "mesh_phase_of_point", "status", "reason"]
    place = int(np.flatnonzero(result["options.samples"].values == 32)[0])
    overrides = {path: float(result[path].values[place]) for path in (sun, ring)}
    single = epicyclic.stiffness(torsional, overrides=overrides, samples=32)
    assert single.mesh_stiffness.values.tobytes() == result.mesh_stiffness.values[place].tobytes()
    few = {**job, sampler: {**job[sampler], "points": 4}}  # type: ignore[dict-item]
    assert epicyclic.study(few).identical(epicyclic.study(few))
    assert not epicyclic.study({**few, "seed": 4})[sun].equals(epicyclic.study(few)[sun])


def test_a_vector_is_drawn_as_two_components(folder: Path) -> None:
    result = epicyclic.study(
        {
            **{"verb": "stiffness", "model": str(folder / "set.toml"), "keep": ["mesh_stiffness"]},
            "sobol": {"points": 100, "deviations.main.planet.run_out": "rayleigh(5 um)"},
        }
    )
    x, y = (result[f"deviations.main.planet.run_out.{axis}"].values for axis in "xy")
    assert result.sizes["point"] == 128
    assert (
        json.loads(result.attrs["warnings"])[0]
        == "sobol.points = 100: rounded up to 128, a power of two [points-rounded]"
    )
    assert abs(x.std() - 5e-6) < 0.1e-6
    assert abs(y.std() - 5e-6) < 0.1e-6
    assert abs(np.mean(x * y)) < 0.1 * 25e-12
    assert (result.status == "ok").all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"verb": "mods"}, r"verb = mods: no such verb; did you mean 'modes'\?"),
        ({"verb": None}, r"verb: missing"),
        ({"model": "nowhere.toml"}, r"model = nowhere.toml: no such file"),
        ({"model": 3}, r"model = 3: not a model"),
        ({"grids": {}}, r"grids = .*: no such key; did you mean 'grid'\?; allowed: verb, model"),
        ({"options": {"dampd": True}}, r"options.dampd = True: no option of modes; did you mean 'damped'"),
        ({"grid": {"options.dampd": [True]}}, r"options.dampd.*: no option of modes"),
        ({"grid": {}}, "nothing varies"),
        ({"grid": {"stages.main.sun.inertia": []}}, r"grid.stages.main.sun.inertia = \[\]: not values"),
        ({"grid": {"stages.main.sun.inertia": 3}}, r"grid.stages.main.sun.inertia = 3: not values"),
        ({"grid": {"stages.main.sn.inertia": [1e-3]}}, r"grid.stages.main.sn.inertia = 0.001: "),
        ({"grid": {"stages.main.sun.inertia": ["3 mm"]}}, r"grid.stages.main.sun.inertia = 3 mm: .*kg m\^2"),
        ({"grid": {"stages.main.sun.inertia": {"from": 1, "points": 3}}}, r"grid.stages.main.sun.inertia.to: missing"),
        ({"grid": {"stages.main.sun.inertia": {"from": 1, "to": 2}}}, r"inertia.points = None: not a number of points"),
        (
            {"grid": {"stages.main.sun.support.radial": {"from": 1e6, "to": float("inf"), "points": 3}}},
            r"radial.to = inf: no end of a range",
        ),
        (
            {"grid": {"stages.main.sun.inertia": {"from": 0, "to": 2, "points": 3, "scale": "log"}}},
            r"a log scale to zero or below",
        ),
        (
            {"grid": {"stages.main.sun.inertia": {"from": 1, "to": 2, "points": 3, "scale": "cubic"}}},
            r"scale = cubic: no such scale; allowed: linear or log",
        ),
        (
            {"grid": {"stages.main.sun.inertia": {"from": "1 mm", "to": 2, "points": 3}}},
            r"grid.stages.main.sun.inertia.from = 1 mm: ",
        ),
        (
            {"grid": {"stages.main.sun.inertia": {"from": 1e-3, "to": 2e-3, "points": 10**7}}},
            r"points = 10000000: not a number of points",
        ),
        (
            {"list": {"stages.main.sun.inertia": [1e-3], "stages.main.ring.inertia": [1e-3, 2e-3]}},
            r"list.stages.main.sun.inertia, list.stages.main.ring.inertia = 1, 2: vary together",
        ),
        ({"random": {"stages.main.sun.inertia": "normal(1, 2)"}}, r"random.points = 0: not a whole number"),
        (
            {"random": {"points": 3, "stages.main.sun.inertia": "normle(1, 2)"}},
            r"random.stages.main.sun.inertia = normle\(1, 2\): not a distribution",
        ),
        ({"sobol": {"points": 3}}, r"sobol: nothing varies"),
        (
            {"random": {"points": 3, "options.damped": "normal(1, 2)"}},
            r"random.options.damped = normal\(1, 2\): not a distribution",
        ),
        ({"overrides": {"stages.main.sun.inertia": 1e-3}}, r"stages.main.sun.inertia: stated twice"),
        ({"overrides": {"stages.main.sun.inertja": 1e-3}}, r"overrides.stages.main.sun.inertja"),
        ({"keep": "frequency"}, r"keep = frequency: not names"),
        ({"keep": ["frequenzy"]}, r"keep = frequenzy: modes gives no such variable; allowed: frequency, "),
        ({"seed": -1}, r"seed = -1: not a whole number"),
    ],
)
def test_a_wrong_job_says_where(change: Tables, words: str, torsional: Tables) -> None:
    job = {"verb": "modes", "model": torsional, "grid": {"stages.main.sun.inertia": [1e-3, 2e-3]}, **change}
    with pytest.raises(ModelError, match=words):
        epicyclic.study({key: value for key, value in job.items() if value is not None})


def test_numbers_of_a_job_file_state_their_units(folder: Path) -> None:
    for entry in ("[1e8]", "{ from = 1e8, to = 2e8, points = 2 }"):
        (folder / "bare.toml").write_text(f'verb = "modes"\nmodel = "set.toml"\n[grid]\n{BEARING} = {entry}\n')
        with pytest.raises(ModelError, match=rf"grid.{BEARING}.* = 100000000.0: a number without a unit"):
            epicyclic.study(folder / "bare.toml")


@pytest.mark.parametrize("text", ["verb = ", "a.b" + ".c" * 1000 + " = 1", "\x00"])
def test_a_file_that_is_no_job(text: str, tmp_path: Path) -> None:
    (tmp_path / "job.toml").write_text(text)
    with pytest.raises(ModelError, match=r"job.toml"):
        epicyclic.study(tmp_path / "job.toml")


def test_results_are_joined_on_their_labels() -> None:
    def result(meshes: list[str], times: list[float], more: bool = False) -> xr.Dataset:
        size = len(meshes)
        found = xr.Dataset(
            {
                "force": (("mesh", "time"), np.arange(size * len(times), dtype=float).reshape(size, -1)),
                "lost": ("mesh", [True] * size),
                "count": ("mesh", np.arange(size)),
                "word": ("mesh", [f"{name}!" for name in meshes]),
                "wave": ("row", np.ones(size, complex)),
            },
            coords={"mesh": meshes, "time": times, "radius": ("mesh", np.ones(size))},
        )
        return found.assign(extra=3.0) if more else found

    whole = stacked([result(["a", "b"], [0.0, 0.1]), None, result(["b", "c", "d"], [0.0, 0.2, 0.3], more=True)])
    assert whole.mesh.values.tolist() == ["a", "b", "c", "d"]
    np.testing.assert_array_equal(whole.force.sel(mesh="b").values, [[2, 3, np.nan], [np.nan] * 3, [0, 1, 2]])
    np.testing.assert_array_equal(whole.time_of_point.values, [[0, 0.1, np.nan], [np.nan] * 3, [0, 0.2, 0.3]])
    np.testing.assert_array_equal(whole.lost.values[0], [1, 1, np.nan, np.nan])
    assert whole.lost.dtype == whole["count"].dtype == float
    assert whole.word.values.tolist() == [["a!", "b!", "", ""], [""] * 4, ["", "b!", "c!", "d!"]]
    assert np.isnan(whole.wave.values[1]).all()
    assert whole.wave.dtype == complex
    np.testing.assert_array_equal(whole.extra.values, [np.nan, np.nan, 3.0])
    assert "radius" in whole.coords
    same = stacked([result(["a"], [0.0, 0.1])] * 2)
    assert same.lost.dtype == bool
    assert same["count"].dtype.kind == "i"
    assert same.time.values.tolist() == [0.0, 0.1]


def test_too_much_for_one_result_is_refused(monkeypatch: pytest.MonkeyPatch, torsional: Tables) -> None:
    monkeypatch.setattr("epicyclic.engine.points.MOST_NUMBERS", 100)
    job = {"verb": "modes", "model": torsional, "grid": {"stages.main.sun.inertia": [1e-3, 2e-3]}}
    with pytest.raises(ModelError, match=r"keep = [0-9]+: too many numbers .*at most 100"):
        epicyclic.study(job)


def test_plain_bytes_come_back() -> None:
    value = [{"a": np.arange(6.0).reshape(2, 3).T, "b": (1, "x", None), "c": np.array(["u", "vw"], object)}]
    (found,) = plain_value(plain_bytes(value))
    assert found["a"].tobytes() == value[0]["a"].tobytes()  # type: ignore[attr-defined]
    assert found["b"] == (1, "x", None)
    assert found["c"].tolist() == ["u", "vw"]
    assert plain_bytes([found]) == plain_bytes(value)


def test_the_command(folder: Path) -> None:
    pytest.importorskip("zarr")
    run = CliRunner()
    done = run.invoke(app, ["study", str(folder / "short.toml"), "--store", "kept", "-o", "out.nc"])
    assert done.exit_code == 0
    assert epicyclic.load_result("out.nc").attrs["studied"] == "modes"
    again = run.invoke(app, ["study", str(folder / "short.toml"), "--store", "kept", "--json"])
    assert again.exit_code == 2
    assert "an interrupted run lies there; allowed: resume" in again.stderr
    shown = run.invoke(app, ["study", str(folder / "short.toml"), "--store", "kept", "--resume"])
    assert shown.exit_code == 0
    assert "frequency" in shown.stdout
    refused = run.invoke(app, ["study", str(folder / "short.toml"), "--resume"])
    assert refused.exit_code == 2
    assert "--resume: needs the store" in refused.stderr


def test_the_example_of_the_page_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "study.md").read_text(encoding="utf-8")
    (job,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "job.toml").write_text(job)
    result = epicyclic.study(tmp_path / "job.toml")
    assert dict(result.sizes) == {
        **{"stages.main.sun.support.radial": 5, "options.relative_speed": 2, "mode": result.sizes["mode"]},
    }
    assert list(result.data_vars) == ["frequency", "mode_kind", "status", "reason"]
    assert (result.status == "ok").all()
    exec(compile(code, "study.md", "exec"), {})
    assert "stages.main.sun.support.radial" in capsys.readouterr().out


def test_labels_stand_in_the_unit_that_was_written(torsional: Tables) -> None:
    job = {
        "verb": "modes",
        "model": torsional,
        "grid": {"stages.main.planet.mass": {"from": "300 g", "to": "700 g", "points": 3}},
        "list": {"operation.speed.sun": ["1000 rpm", "2500 rpm"], "stages.main.sun.mass": ["1 kg", "900 g"]},
    }
    result = epicyclic.study(job)
    for path, unit, values in (
        ("stages.main.planet.mass", "g", [300, 500, 700]),
        ("operation.speed.sun", "rpm", [1000, 2500]),
        ("stages.main.sun.mass", "kg", [1, 0.9]),  # written in two units: SI
    ):
        assert result[path].attrs["units"] == unit
        assert result[path].values.tolist() == values
    single = epicyclic.modes(torsional, overrides={"stages.main.planet.mass": "500 g", "stages.main.sun.mass": "900 g"})
    np.testing.assert_array_almost_equal_nulp(result.frequency[1, 1].values, single.frequency.values, 4096)


def test_a_list_in_a_job_is_labelled_as_the_text_of_the_same_list(torsional: Tables) -> None:
    path = "deviations.planet.position.y"
    given = [["20 um", "0 um", "0 um"], "[20, 0, 0] um", ["20 um", "0 mm", "0 mm"]]
    result = epicyclic.study({"verb": "matrices", "model": torsional, "list": {path: given}})
    assert result[path].values.tolist() == ["[20, 0, 0] um", "[20, 0, 0] um", "[20 um, 0 mm, 0 mm]"]
    assert result["status"].values.tolist() == ["ok"] * 3
