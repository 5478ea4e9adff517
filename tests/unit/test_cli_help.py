"""Help of the program: every command below a question, in one line, on one screen."""

from __future__ import annotations

import typer.main
from typer.testing import CliRunner

from epicyclic.cli.main import app
from epicyclic.cli.panels import PANELS, panel_of


def commands() -> dict[str, object]:
    group = typer.main.get_command(app)
    return {name: one for name, one in group.commands.items() if not one.hidden}  # type: ignore[attr-defined]


def test_every_command_stands_below_one_question() -> None:
    listed = [name for names in PANELS.values() for name in names]
    assert len(listed) == len(set(listed))
    assert set(commands()) - set(listed) == set()
    assert panel_of("modes") == "How does it vibrate?"
    assert panel_of("nosuch") == ""


def test_help_is_one_screen() -> None:
    shown = CliRunner().invoke(app, ["--help"])
    assert shown.exit_code == 0
    lines = shown.output.splitlines()
    # a line for each command and question, and a few for usage and options
    assert len(lines) <= len(commands()) + len(PANELS) + 8 <= 50
    assert max(map(len, lines)) <= 96
    for name in commands():
        assert sum(line.split()[:1] == [name] for line in lines) == 1
    assert "\x1b" not in shown.output


def test_lines_of_the_panels_are_short() -> None:
    for names in PANELS.values():
        for words in names.values():
            assert len(words) <= 76
            assert words.endswith(".")
