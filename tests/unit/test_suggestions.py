"""Nearest names of commands, options and words, and completion in the shell."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from epicyclic.cli.command import model_names
from epicyclic.cli.main import app


def said(*words: str) -> tuple[int, str]:
    """Exit status and the message of a command, on one line."""
    found = CliRunner().invoke(app, list(words), env={"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"})
    return found.exit_code, " ".join(found.output.replace("│", " ").split())


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("modes", "ren2021", "--dampd"), "no such option --dampd; did you mean '--damped'?"),
        (("modes", "ren2021", "-damped"), "no such option -damped; did you mean '--damped'?"),
        (("sweep", "ren2021", "--contact_loss"), "no such option --contact_loss; did you mean '--contact-loss'?"),
        (("sweep", "ren2021", "--contact_loss=yes"), "no such option --contact_loss; did you mean '--contact-loss'?"),
        (("systems", "--jsn"), "no such option --jsn; did you mean '--json'?"),
        (("--versoin",), "no such option --versoin; did you mean '--version'?"),
        (("--json", "check", "ren2021"), "--json stands behind the command: epicyclic check ... --json"),
        (("swep", "ren2021"), "no such command 'swep'; did you mean 'sweep'?"),
        (("train-contact", "ren2021"), "no such command 'train-contact'; did you mean 'contact'?"),
        (("ren2021",), "a model stands behind the command: epicyclic check ren2021"),
        (("sharing", "ren2021", "--method", "stedy"), "'stedy' is not one of 'steady'"),
        (("sharing", "ren2021", "--method", "stedy"), "; did you mean 'steady'?"),
    ],
)
def test_the_nearest_name_is_told(words: tuple[str, ...], meant: str) -> None:
    status, text = said(*words)
    assert status == 2
    assert meant in text


@pytest.mark.parametrize("words", [("zzzz",), ("modes", "ren2021", "--qqqq")])
def test_nothing_is_told_where_nothing_is_near(words: tuple[str, ...]) -> None:
    status, text = said(*words)
    assert status == 2
    assert "did you mean" not in text.lower()
    assert "no such" in text


# completion ----------------------------------------------------------------------------------------------------------


def test_models_are_drives_and_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("reducer.toml", "gear.rexs", "notes.txt", ".hidden.toml", "deep/other.toml", "deep/text.md"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    assert model_names("re") == ["ren2021", "reducer.toml"]
    assert model_names("g") == ["gear.rexs"]
    assert model_names("no") == []
    assert model_names("de") == ["deep/"]
    assert model_names("deep/") == ["deep/other.toml"]
    assert model_names("lin") == ["lin1999-n3", "lin1999-n4", "lin1999-n5"]
    assert ".hidden.toml" not in model_names("")
    assert model_names(".h") == [".hidden.toml"]


@pytest.mark.parametrize("word", ["/no/such/folder/x", "\0", "~nobody/", "x" * 5000, "deep//\udcff"])
def test_completion_never_raises(word: str) -> None:
    assert model_names(word) == []


def completed(shell: str, line: str) -> tuple[str, str, float]:
    """What a shell is offered for a line whose last word is completed; stderr; and seconds."""
    words = line.split(" ")
    env = {
        **os.environ,
        "_EPICYCLIC_COMPLETE": f"complete_{shell}",
        "_TYPER_COMPLETE_ARGS": line,
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    code = "import sys; sys.argv[0] = 'epicyclic'; from epicyclic.__main__ import main; main()"
    begin = time.perf_counter()
    found = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, timeout=60)
    return found.stdout, found.stderr, time.perf_counter() - begin


LINES = (
    ("epicyclic swe", "sweep"),
    ("epicyclic modes ren20", "ren2021"),
    ("epicyclic modes ren2021 --dam", "--damped"),
    ("epicyclic sharing ren2021 --method st", "static"),
)


# what is offered is the same in each shell; how it is asked for and written is not
@pytest.mark.parametrize(("shell", "lines"), [("bash", LINES), ("zsh", LINES[:2]), ("fish", LINES[2:])])
def test_verbs_options_models_and_words_are_completed(shell: str, lines: tuple[tuple[str, str], ...]) -> None:
    for line, offered in lines:
        out, err, _ = completed(shell, line)
        assert offered in out, (line, out, err)
        assert err == ""


def test_completion_imports_nothing_heavy() -> None:
    code = (
        "import sys, os; sys.argv[0] = 'epicyclic'; from epicyclic.cli.main import app\n"
        "from epicyclic.cli.command import model_names; model_names('r')\n"
        "print([name for name in ('numpy', 'xarray', 'pydantic', 'plotly', 'scipy', 'pandas') if name in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert found.stdout.strip() == "[]", found.stdout + found.stderr
