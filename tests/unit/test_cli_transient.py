"""The command `transient`: options, files, stopping and going on."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import epicyclic
from epicyclic.cli.main import app


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        app(["transient", *words], prog_name="epicyclic")
    captured = capsys.readouterr()
    return int(stop.value.code or 0), captured.out, captured.err


def test_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "ren2021", "--cycles", "2", "--torque-step", "1.5@20 ms")
    assert status == 0
    assert "main/sun-planet/1/left" in out
    assert "mean, last" in out  # its heading stands in two lines
    assert "fifth [N]" in out
    assert "status ok" in out


def test_json_and_a_file_and_going_on_from_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    first, second = tmp_path / "first.nc", tmp_path / "second.nc"
    assert run(capsys, "ren2021", "--cycles", "2", "--start", "20 Hz", "--stop", "0.03 kHz", "-o", str(first))[0] == 0
    assert (
        run(capsys, "ren2021", "--cycles", "2", "--start", "30 Hz", "--initial", str(first), "-o", str(second))[0] == 0
    )
    one, two = epicyclic.load_result(first), epicyclic.load_result(second)
    assert float(one.mesh_frequency[-1]) == pytest.approx(30, rel=1e-12)
    assert abs(one.displacement[:, -1] - two.displacement[:, 0]).max() < 1e-12 * abs(one.displacement).max() + 1e-18
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first.nc", "second.nc"]  # nothing else is left
    status, out, _ = run(capsys, "ren2021", "--cycles", "1", "--json")
    assert status == 0
    assert json.loads(out)["attrs"]["verb"] == "transient"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--duration", "-1 s"], "--duration = -1 s: out of range"),
        (["--duration", "soon"], "--duration = soon: not a number with a unit"),
        (["--duration", "0 s"], "--duration = 0 s: out of range"),
        (["--stop", "20 Hz"], "--stop = 20 Hz: needs the frequency at the beginning too"),
        (["--start", "-3 Hz"], "--start = -3 Hz: not a frequency"),
        (["--start", "-3"], '--start = -3: a number without a unit: "-3 Hz"?'),
        (["--torque-step", "1.5"], "--torque-step = 1.5: not a torque step"),
        (["--torque-step", "x@1"], "not a torque step"),
        (["--torque-step", "1.5.5@1"], "not a torque step"),
        (["--torque-step", "2@1 kg"], "--torque-step = 1 kg: unit not known"),
        (["--torque", "none.csv"], "none.csv: cannot be read"),
        (["--resume"], "--resume: needs the file of the run"),
        (["--initial", "none.nc"], "none.nc: no such file"),
        (["--initial", "moon"], "--initial = moon: no such"),
        (["--duration", "1 s", "--cycles", "3"], "not both"),
    ],
)
def test_wrong_options(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    status, out, err = run(capsys, "ren2021", *words)
    assert status == 2
    assert out == ""
    assert said in err


def test_control_c_keeps_what_is_done(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("numba")
    target = tmp_path / "long.nc"
    words = ["transient", "ren2021", "--cycles", "4000", "--decimate", "32", "-o", str(target)]
    parts = tmp_path / "long.nc.parts"
    command = [sys.executable, "-m", "epicyclic", *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        until = time.monotonic() + 60
        while not (parts / "000000.kept").is_file() and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.1)  # into the pieces of a further segment
        process.send_signal(signal.SIGINT)
        err = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "this command continues it" in err
    assert "--resume" in err.splitlines()[-2]
    assert not target.exists()
    assert len(list(parts.glob("*.kept"))) >= 1
    status, _, err = run(capsys, *words[1:])
    assert status == 2
    assert "an interrupted run lies there" in err
