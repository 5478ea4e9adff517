"""`epicyclic new`: flags, questions in a pseudo-terminal, files that are not overwritten."""

from __future__ import annotations

import math
import os
import pty
import select
import subprocess
import sys
import time
import tomllib
from importlib import resources
from pathlib import Path

import pytest
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app

BOX = ["--teeth", "21/39/99", "--module", "10 mm", "--helix", "7.5 deg", "--face-width", "200 mm"]
END = "\x04"  # Ctrl-D
LOAD = ["--power", "750 kW", "--speed", "1000 rpm"]


def test_flags_write_a_file_that_runs(tmp_path: Path) -> None:
    path = tmp_path / "box.toml"
    result = CliRunner().invoke(app, ["new", str(path), *BOX, *LOAD])
    assert result.exit_code == 0, result.output
    assert "ratio 5.7143" in result.output
    assert f"epicyclic check {path}" in result.output
    text = path.read_text(encoding="utf-8")
    assert "mesh frequency 288.75 Hz" in text
    head = " ".join(line.removeprefix("# ") for line in text.split("format")[0].splitlines())
    assert "--teeth 21/39/99" in head  # in a comment of lines
    assert epicyclic.load(path).warnings == ()
    document = epicyclic.planetary(
        teeth="21/39/99",
        module="10 mm",
        helix_angle="7.5 deg",
        face_width="200 mm",
        power="750 kW",
        speed="1000 rpm",
    )
    assert tomllib.loads(text) == document


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    path = tmp_path / "box.toml"
    path.write_text("mine", encoding="utf-8")
    result = CliRunner().invoke(app, ["new", str(path), *BOX, *LOAD])
    assert result.exit_code == 2
    assert "--force" in result.output
    assert path.read_text(encoding="utf-8") == "mine"
    assert CliRunner().invoke(app, ["new", str(path), *BOX, *LOAD, "--force"]).exit_code == 0
    assert path.read_text(encoding="utf-8") != "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--teeth", "21/39/99"], "--speed: is missing"),
        (LOAD, "--teeth: is missing"),
        (["--teeth", "22/39/100", *LOAD], "--teeth = 22/39/100"),
        (["--teeth", "21/39/99", *LOAD, "--helix", "7.5"], "--helix = 7.5"),
        (["--kind", "differential", "--teeth", "21/39/99", *LOAD], "--speed 'sun=1000 rpm' --speed 'ring=1000 rpm'"),
    ],
)
def test_without_a_terminal_errors_name_the_flag(tmp_path: Path, words: list[str], said: str) -> None:
    result = CliRunner().invoke(app, ["new", str(tmp_path / "x.toml"), *words])
    assert result.exit_code == 2
    assert said in result.output
    assert list(tmp_path.iterdir()) == []


def test_no_file_of_another_kind(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["new", str(tmp_path / "x.txt"), *BOX, *LOAD])
    assert result.exit_code == 2
    assert ".toml" in result.output


def _in_terminal(arguments: list[str], answers: list[str], folder: Path) -> tuple[int, str]:
    """Status and screen of a command whose questions are answered one after the other."""
    leader, follower = pty.openpty()
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "TERM": "dumb"}
    command = [sys.executable, "-m", "epicyclic", "new", *arguments]
    process = subprocess.Popen(
        command, stdin=follower, stdout=follower, stderr=follower, cwd=folder, env=environment, close_fds=True
    )
    os.close(follower)
    screen, waiting = "", list(answers)
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        if not select.select([leader], [], [], 1.0)[0]:
            continue
        try:
            screen += os.read(leader, 4096).decode()
        except OSError:  # the other end is closed
            break
        if waiting and screen.endswith(": "):
            answer = waiting.pop(0)
            os.write(leader, answer.encode() + (b"" if answer == END else b"\n"))
    os.close(leader)
    try:
        return process.wait(timeout=10), screen
    finally:
        process.kill()


def test_a_terminal_is_asked_and_a_wrong_answer_asked_again(tmp_path: Path) -> None:
    # kind, teeth, planets, held, speed, load, module, face width, helix; then the teeth again
    answers = ["", "22/39/100", "", "", "1000 rpm", "750 kW", "10 mm", "200 mm", "7.5 deg", "21/39/99"]
    status, screen = _in_terminal(["box.toml"], answers, tmp_path)
    assert status == 0, screen
    assert "[planetary]" in screen
    assert "[by load]" in screen
    assert "cannot be assembled" in screen
    main = tomllib.loads((tmp_path / "box.toml").read_text(encoding="utf-8"))["stages"]["main"]
    assert (main["sun"]["teeth"], main["module"], main["face_width"]) == (21, "10 mm", "200 mm")


def test_an_end_at_a_question_leaves_nothing(tmp_path: Path) -> None:
    status, screen = _in_terminal(["box.toml", *LOAD], ["", END], tmp_path)
    assert status == 130, screen
    assert "stopped" in screen
    assert list(tmp_path.iterdir()) == []


def test_systems_prints_and_copies_the_file_of_a_drive(tmp_path: Path) -> None:
    shipped = (resources.files("epicyclic.systems") / "wind-stage.toml").read_text(encoding="utf-8")
    result = CliRunner().invoke(app, ["systems", "wind-stage"])
    assert result.exit_code == 0
    assert result.output == shipped
    path = tmp_path / "mine.toml"
    assert CliRunner().invoke(app, ["systems", "wind-stage", "-o", str(path)]).exit_code == 0
    assert path.read_text(encoding="utf-8") == shipped
    again = CliRunner().invoke(app, ["systems", "industrial-stage", "-o", str(path)])
    assert again.exit_code == 2
    assert path.read_text(encoding="utf-8") == shipped
    missing = CliRunner().invoke(app, ["systems", "wind-stag"])
    assert missing.exit_code == 2
    assert "did you mean 'wind-stage'" in missing.output
    assert "industrial-stage" in CliRunner().invoke(app, ["systems"]).output


@pytest.mark.parametrize(("drive", "ratio", "torque"), [("industrial-stage", 5.1, 160e3 / (1480 * math.tau / 60))])
def test_the_industrial_stage_is_what_its_comments_say(drive: str, ratio: float, torque: float) -> None:
    train = epicyclic.load(drive)
    assert train.warnings == ()
    assert train.kinematics.torque is not None
    assert train.kinematics.torque["main.carrier"] == pytest.approx(-ratio * torque)
    assert "5265 N m" in CliRunner().invoke(app, ["systems", drive]).output
    assert float(ratio * torque) == pytest.approx(5265, abs=0.5)


def test_the_wind_stage_carries_the_loads_of_the_rotor() -> None:
    train = epicyclic.load("wind-stage")
    assert train.warnings == ()
    assert train.gravity == (0.0, -9.81, 0.0)
    assert any(load.path == "loads.rotor" and load.force == (20e3, -120e3, 0.0) for load in train.loads)
    assert train.kinematics.torque is not None
    assert train.kinematics.torque["main.sun"] == pytest.approx(-1.9e6 / (1 + 119 / 25))
