"""`epicyclic app`: what it refuses before there is a server, its port, its address, its end."""

from __future__ import annotations

import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from epicyclic.cli.main import app
from epicyclic.cockpit.server import PORT, _bound
from epicyclic.errors import ModelError


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(
        "epicyclic.cli.commands.find_spec", lambda name: None if name in ("nicegui", "tomlkit") else found(name)
    )
    result = CliRunner().invoke(app, ["app"])
    assert result.exit_code == 2
    assert "needs nicegui and tomlkit" in result.output
    assert "pip install 'epicyclic[app]'" in result.output


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no such"),
        ("format = [", "not TOML"),
        ('[stages.main]\nkind = "planetry"\n', "allowed"),
    ],
)
def test_a_wrong_model_is_told_before_there_is_a_server(tmp_path: Path, text: str | None, words: str) -> None:
    pytest.importorskip("tomlkit")
    path = tmp_path / "box.toml"
    if text is not None:
        path.write_text(text)
    result = CliRunner().invoke(app, ["app", str(path), "--no-browser"])
    assert result.exit_code == 2, result.output
    assert words in result.output
    assert "is open at" not in result.output


def test_a_port_that_is_taken() -> None:
    with _bound(None) as first, _bound(None) as second:
        assert PORT <= first.getsockname()[1] < second.getsockname()[1]
        assert second.getsockname()[0] == "127.0.0.1"
        with pytest.raises(ModelError, match=f"--port = {first.getsockname()[1]}: cannot be listened on") as error:
            _bound(first.getsockname()[1])
        assert "a port that is free" in str(error.value)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


# what raises the signal again at the end of the server, swallowed
SWALLOWED = (
    "import runpy, signal; signal.raise_signal = lambda _: None; runpy.run_module('epicyclic', None, '__main__')"
)


@pytest.mark.skipif(os.name != "posix", reason="process groups of POSIX")
@pytest.mark.parametrize("start", [("-m", "epicyclic"), ("-c", SWALLOWED)], ids=["plain", "swallowed"])
def test_ctrl_c_leaves_no_process(start: tuple[str, str], tmp_path: Path) -> None:
    pytest.importorskip("nicegui")
    psutil = pytest.importorskip("psutil")
    port = free_port()
    command = [sys.executable, *start, "app", "lin1999-n3", "--no-browser", "--port", str(port)]
    environment = {**os.environ, "XDG_STATE_HOME": str(tmp_path)}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment, start_new_session=True) as run:
        assert run.stderr is not None
        assert f"http://127.0.0.1:{port}/?token=" in run.stderr.readline()
        time.sleep(0.3)  # the warm process is on its way
        children = psutil.Process(run.pid).children(recursive=True)
        os.killpg(run.pid, signal.SIGINT)  # as a terminal does: to all of the group
        assert run.wait(timeout=15) == 130
        left = run.stderr.read()
    assert left.strip().splitlines()[-1] == "stopped"
    assert "Traceback" not in left
    _, alive = psutil.wait_procs(children, timeout=3)
    assert alive == []
