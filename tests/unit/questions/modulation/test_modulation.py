"""The verb and command `modulation`: units, tables from files, table in the terminal, JSON, netCDF."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.cli.main import app
from epicyclic.errors import ModelError
from epicyclic.questions.modulation.verbs import read_transfer, read_window
from epicyclic.results.dataset import load_result, save_result


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return epicyclic.modulation("xu2020", sensor="90 deg", floor=1e-3)


def test_the_sensor_has_units(result: xr.Dataset) -> None:
    same = epicyclic.modulation("xu2020", sensor=math.pi / 2, floor=1e-3)
    assert same.signal_amplitude.values.tolist() == result.signal_amplitude.values.tolist()
    first = result.passage.values
    # planets at 0, 90, 180, 270 deg turn forwards: the second stands under the sensor at the start
    assert first * result.attrs["carrier_frequency"] == pytest.approx([0.25, 0.0, 0.75, 0.5], abs=1e-12)


def test_every_variable_says_what_it_is(result: xr.Dataset) -> None:
    for name, values in result.variables.items():
        assert "long_name" in values.attrs or name in ("line", "planet"), name
    assert result.signal.attrs["units"] == "N"
    assert result.sensor_acceleration.attrs["units"] == "m/s2"


def test_saved_and_reopened(result: xr.Dataset, tmp_path: Path) -> None:
    again = load_result(save_result(result, tmp_path / "modulation.nc"))
    xr.testing.assert_identical(again, result)


def test_tables_from_files(tmp_path: Path) -> None:
    (tmp_path / "window.csv").write_text("angle [deg], gain\n-60, 0\n0, 1\n\n60, 0.5\n")
    window = read_window(tmp_path / "window.csv")
    assert window.at(np.radians([0.0, 60.0])) == pytest.approx([1.0, 0.5], abs=5e-3)  # corners converge as 1/K
    (tmp_path / "path.csv").write_text("Frequency [kHz],Accelerance [m/s^2/N],phase [deg]\n0,0.001,0\n2,0.003,-90\n")
    path = read_transfer(tmp_path / "path.csv")
    assert path.unit == "m/s2/N"
    assert path.at(np.array([1000.0]))[0] == pytest.approx(0.002 * np.exp(-0.25j * math.pi))
    moved = epicyclic.modulation("xu2020", transfer=tmp_path / "path.csv", window=tmp_path / "window.csv")
    assert moved.signal.attrs["units"] == "m/s2"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "holds no line"),
        ("gain\n1\n", "first line"),
        ("angle [deg], gain\n", "empty"),
        ("angle [deg], gain\n0, 1, 2\n", "line 2.*another number"),
        ("angle [deg], gain\n0, one\n", "line 2.*not a finite"),
        ("angle [deg], gain\n0,\n", "line 2.*no value"),
        ("angle [mm], gain\n0, 1\n", "unit"),
        ("angle, gain\n0, 1\n", "unit"),
        ("angle [deg], gain\n0, -1\n", "not negative"),
        ("angle [deg], gain\n0, nan\n", "not a finite"),
        ("angle [deg], gain, gain\n0, 1, 1\n", "first line"),
    ],
)
def test_window_files_that_are_none(text: str, problem: str, tmp_path: Path) -> None:
    (tmp_path / "window.csv").write_text(text)
    with pytest.raises(ModelError, match=problem):
        read_window(tmp_path / "window.csv")


@pytest.mark.parametrize(
    ("options", "path"),
    [
        ({"sensor": "90"}, "sensor"),
        ({"sensor": "90 mm"}, "sensor"),
        ({"sensor": "nan"}, "sensor"),
        ({"sensor": "left"}, "sensor"),
        ({"width": "20"}, "width"),
        ({"radius": "300 deg"}, "radius"),
        ({"window": "nosuch.csv"}, "nosuch.csv"),
        ({"transfer": "nosuch.csv"}, "nosuch.csv"),
    ],
)
def test_texts_that_are_none(options: dict[str, Any], path: str) -> None:
    with pytest.raises(ModelError, match=path):
        epicyclic.modulation("xu2020", **options)


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stop:
        app(list(arguments), prog_name="epicyclic")
    return int(stop.value.code or 0)


def test_the_command_prints_lines_and_families(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        run("modulation", "xu2020", "--sensor", "90deg", "--floor", "1e-3", "--set", "deviations.sun.run_out=30 um")
        == 0
    )
    shown = capsys.readouterr().out
    for text in (
        "planets pass at 1.15333 Hz",
        "1 x mesh + 1 x carrier",
        "sun run-out + 1 x carrier",
        "main.sun.run_out",
    ):
        assert text in shown
    assert "1 x mesh  " not in shown  # the mesh line itself vanishes


def test_the_command_gives_json(capsys: pytest.CaptureFixture[str], result: xr.Dataset) -> None:
    assert run("modulation", "xu2020", "--sensor", "90 deg", "--floor", "1e-3", "--json") == 0
    again = xr.Dataset.from_dict(json.loads(capsys.readouterr().out))
    assert again.exact_frequency.values.tolist() == result.exact_frequency.values.tolist()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--sensor", "90"), "sensor"),
        (("--stage", "second"), "stage"),
        (("--window", "boxcar"), "window"),
        (("--body", "main/sun"), "turns at"),
        (("--transfer", "nosuch.csv"), "nosuch.csv"),
    ],
)
def test_wrong_input_is_status_2_and_named(
    arguments: tuple[str, ...], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("modulation", "xu2020", *arguments) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert named in streams.err.splitlines()[-1]


def test_a_star_drive_prints_without_passages(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("modulation", "dong2019", "--body", "housing", "--floor", "1e-2") == 0
    shown = capsys.readouterr().out
    assert "no planet passes" in shown
    assert "carrier" not in shown.split("Signal beside", 1)[1]
