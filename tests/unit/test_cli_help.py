"""Help of the program: every command below a question, in one line, on one screen."""

from __future__ import annotations

import pytest
import typer.main
from typer.testing import CliRunner

from epicyclic.cli.command import panels
from epicyclic.cli.main import app
from epicyclic.cli.output import progress_bar


def commands() -> dict[str, object]:
    group = typer.main.get_command(app)
    return {name: one for name, one in group.commands.items() if not one.hidden}  # type: ignore[attr-defined]


def test_every_command_stands_below_one_question() -> None:
    listed = [name for names in panels().values() for name in names]
    assert len(listed) == len(set(listed))
    assert set(commands()) == set(listed)
    assert "modes" in panels()["How does it vibrate?"]


def test_help_is_one_screen() -> None:
    shown = CliRunner().invoke(app, ["--help"])
    assert shown.exit_code == 0
    lines = shown.output.splitlines()
    # a line for each command and question, and a few for usage and options
    assert len(lines) <= min(len(commands()) + len(panels()) + 8, 50)
    assert max(map(len, lines)) <= 96
    for name in commands():
        assert sum(line.split()[:1] == [name] for line in lines) == 1
    assert "\x1b" not in shown.output


def test_lines_of_the_panels_are_short() -> None:
    for names in panels().values():
        for words in names.values():
            assert len(words) <= 76
            assert words.endswith(".")


def test_a_share_is_told_now_and_then_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter([100.0, 130.0, *[190.0] * 3, 200.0])
    monkeypatch.setattr("epicyclic.cli.output.time.monotonic", lambda: next(clock))
    with progress_bar("sweep ren2021") as step:
        for share in (0.1, 0.25, 0.3):
            step(share)
    assert capsys.readouterr().err.splitlines() == ["sweep ren2021: 25%, 90 s, 270 s left"]
