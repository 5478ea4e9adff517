"""`epicyclic efficiency` on the command line: what is printed, and flags in refusals."""

from __future__ import annotations

import json

import pytest

from epicyclic.cli.main import app


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        app(["efficiency", *words], prog_name="epicyclic")
    streams = capsys.readouterr()
    return int(stop.value.code or 0), streams.out, streams.err


def test_tables_of_losses_and_torques(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "encased-differential", "--friction", "0.04")
    assert status == 0
    for words in (
        "coefficient of friction 0.04",
        "bearings, seals and oil take more",
        "encased sun-planet left",
        "H_V",
    ):
        assert words in out


def test_json_is_the_dataset(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "ren2021", "--json")
    assert status == 0
    assert json.loads(out)["data_vars"]["train_efficiency"]["data"] == pytest.approx(0.98752, abs=1e-5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("ren2021", "--friction", "-0.1"), "--friction"),
        (("ren2021", "--friction", "1.1"), "--friction = 1.1: out of range; allowed: 0 to 1"),
        (("ren2021", "--friction", "nan"), "--friction = nan: out of range; allowed: 0 to 1"),
        (("ren2021", "--friction", "much"), "'much' is no number"),
        (
            ("ren2021", "--viscosity", "20 mPa s", "--roughness", "inf um"),
            "--roughness = inf um: must be finite; allowed: length (m, mm, um), >= 1e-08 and <= 0.0001 m",
        ),
        (("ren2021", "-o", ""), "an empty name"),
        (("ren2021", "--viscosity", "20 mPa s"), "--roughness"),
        (
            ("ren2021", "--viscosity", "20", "--roughness", "1 um"),
            '--viscosity = 20: a number without a unit: "20 mPa s"',
        ),
        (("ren2021", "--viscosity", "1 mPa s", "--roughness", "1 um", "--friction", "0.1"), "--friction = 0.1"),
        (("yue2014-i",), "operation.speed"),
        (("yue2014-i", "--set", "operation.speed.sun=100 rpm"), "operation.torque"),
    ],
)
def test_refusals_name_the_flag_or_the_path(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert said in err
    assert "Traceback" not in err
