"""The command line: exit statuses, streams, files, speed of starting."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
import xarray as xr

import epicyclic
from epicyclic.cli.main import app
from epicyclic.errors import ConvergenceError
from epicyclic.verbs.record import keywords, verbs


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


Command = Callable[..., Outcome]


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run the command line in this process."""

    def run(*arguments: str) -> Outcome:
        with pytest.raises(SystemExit) as stop:
            app(list(arguments), prog_name="epicyclic")
        streams = capsys.readouterr()
        return Outcome(int(stop.value.code or 0), streams.out, streams.err)

    return run


def process(*arguments: str, **options: object) -> subprocess.Popen[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("EPICYCLIC_DEBUG", None)
    return subprocess.Popen(
        [sys.executable, "-m", "epicyclic", *arguments],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )


def cpu_of(*arguments: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_help_is_quick(slowness: float) -> None:
    # the best of three: the first one may compile, and other processes share the machine's caches
    assert min(cpu_of("-m", "epicyclic", "--help") for _ in range(3)) <= 0.1 * slowness


def test_import_is_quick() -> None:
    assert min(cpu_of("-c", "import epicyclic") for _ in range(3)) <= 1.0
    subprocess.run([sys.executable, "-c", "import epicyclic, sys; assert 'numpy' not in sys.modules"], check=True)


def test_version(command: Command) -> None:
    assert command("--version").out == f"epicyclic {epicyclic.__version__}\n"


def test_warnings_stand_beside_a_written_result(command: Command, tmp_path: Path) -> None:
    _, out, _ = command("check", "ren2021", "-o", str(tmp_path / "check.nc"))
    warnings = json.loads(epicyclic.check("ren2021").attrs["warnings"])
    assert warnings
    assert all(text in out for text in warnings)


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("nosuch",),
        ("modes",),
        ("modes", "lin1999-n4", "--nosuch"),
        ("sharing", "ren2021", "--method", "guess"),
        ("sweep", "ren2021", "--points", "0"),
        ("sweep", "ren2021", "--points", "many"),
    ],
)
def test_wrong_usage_is_status_2(command: Command, arguments: tuple[str, ...]) -> None:
    assert command(*arguments).status == 2


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("check", "nosuch"), "nosuch"),
        (("check", "nosuch.toml"), "nosuch.toml"),
        (("check", "lin1999-n4", "--set", "stages.main.sun.teeth=-3"), "stages.main.sun.teeth"),
        (("check", "lin1999-n4", "--set", "stages.main.sun.tooth=3"), "teeth"),
        (("check", "lin1999-n4", "--set", "nothing"), "PATH=VALUE"),
        (("check", "lin1999-n4", "--set", "stages.main.sun.mass=0.8"), '"0.8 kg"?'),
        (("contact", "ren2021", "--mesh", "sun-planet", "--torque", "100"), '"100 N m"?'),
        (("modes", "lin1999-n4", "-o", "result.txt"), ".nc"),
        (("modes", "lin1999-n4", "-o", "nowhere/result.nc"), "nowhere"),
        (("sharing", "lin1999-n4"), ""),
        (("campbell", "lin1999-n4"), "operation.speed"),
        (("sweep", "lin1999-n4", "--start", "20 Hz"), "operation.speed"),
        (("sweep", "ren2021", "--start", "20 min"), "--start"),
        (("sweep", "ren2021", "--start", "-20 rpm"), "--start"),
        (("sweep", "lin1999-n4", "--start", "20 rpm"), "operation.speed"),
        (("sweep", "ren2021", "--start", "600 Hz", "--stop", "20 Hz"), "600"),
        (("sweep", "ren2021", "--start", "20", "--stop", "600 Hz"), '"20 Hz"?'),
        (("report", "ren2021", "-o", "report.pdf"), ".html"),
        (("schema", "-o", "schema.txt"), ".json"),
    ],
)
def test_wrong_input_is_status_2_and_named(command: Command, arguments: tuple[str, ...], named: str) -> None:
    status, out, err = command(*arguments)
    assert status == 2
    assert out == ""
    assert err.splitlines()[-1].startswith("error: ")
    assert named in err
    assert "Traceback" not in err


@pytest.mark.parametrize("verb", ["check", "modes", "stiffness"])
def test_json_is_the_dataset(command: Command, verb: str) -> None:
    status, out, _ = command(verb, "lin1999-n4", "--json")
    again = xr.Dataset.from_dict(json.loads(out))
    direct = getattr(epicyclic, verb)("lin1999-n4")
    assert status == 0
    assert out == epicyclic.to_json(direct) + "\n"
    xr.testing.assert_allclose(again, direct, rtol=1e-15)  # JSON writes floats so that they read back the same


def test_set_reaches_the_model(command: Command) -> None:
    status, out, _ = command("modes", "lin1999-n4", "--set", "stages.main.sun.mass=0.8 kg", "--json")
    direct = epicyclic.modes("lin1999-n4", overrides={"stages.main.sun.mass": "0.8 kg"})
    nominal = epicyclic.modes("lin1999-n4")
    heavier = xr.Dataset.from_dict(json.loads(out))
    assert status == 0
    assert heavier.frequency.values.tolist() == direct.frequency.values.tolist()
    assert abs(heavier.frequency.values[1] - nominal.frequency.values[1]) > 1.0  # Hz; a doubled sun is felt


@pytest.mark.parametrize("suffix", [".nc", ".json"])
def test_output_file(command: Command, tmp_path: Path, suffix: str) -> None:
    target = tmp_path / f"modes{suffix}"
    status, out, err = command("modes", "lin1999-n3", "-o", str(target))
    assert status == 0
    assert out == command("modes", "lin1999-n3").out
    assert re.search(r"^ +18 +11775\.3 +rotational +1 +sun-planet 99 %", out, re.MULTILINE)
    assert f"written: {target}" in err
    again = (
        epicyclic.load_result(target)
        if suffix == ".nc"
        else xr.Dataset.from_dict(json.loads(target.read_text("utf-8")))
    )
    assert again.frequency.values.tolist() == epicyclic.modes("lin1999-n3").frequency.values.tolist()
    assert [path.name for path in tmp_path.iterdir()] == [target.name]


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (("check", "ren2021"), ("27.3125", "[rpm]", "3.47826", "in turn, 1/3 cycle earlier")),
        (("check", "ren2021", "--all"), ("27.3125", "[rpm]", "phase", "stages.main.sun.mass")),
        (("modes", "lin1999-n4"), ("727.2", "translational", "[Hz]")),
        (("stiffness", "ren2021"), ("[N/µm]",)),
        (("campbell", "ren2021"), ("[Hz]",)),
        (("steady", "ren2021"), ("[N]",)),
        (("static", "ren2021"), ("[N]",)),
        (("static", "xu2020"), ("main/sun/neck", "74945.9", "324.285")),  # half of T_s, and that times l/(G I_p)
        (("sharing", "ren2021", "--method", "static", "--cycles", "23"), ("cycle-peak", "train", "worst-case")),
        (
            ("sharing", "ren2021", "--method", "static", "--turns", "1", "--of", "main/sun", "--samples", "16"),
            ("cycle-peak", "shorter than the common period of"),
        ),
        (("static", "ren2021", "--turns", "1", "--of", "main.sun", "--samples", "4"), ("main/sun-planet/1/left",)),
        (
            ("sweep", "ren2021", "--start", "20 Hz", "--stop", "0.03 kHz", "--points", "3"),
            ("3 speeds, 20 to 30 Hz", "ok"),
        ),
        (
            ("sweep", "ren2021", "--start", "50 rpm", "--stop", "100 %", "--points", "2"),
            ("13.6562 to 27.3125 Hz", "K_v"),
        ),
        (
            ("sweep", "xu2020", "--start", "1560 Hz", "--stop", "1700 Hz", "--points", "3", "--contact-loss"),
            ("with contact loss, 3 speeds, 1560 to 1700 Hz", "down: largest", "What moves", "Points", "ok"),
        ),
        (("steady", "ren2021"), ("K_v", "main/planet/1/bearing")),
    ],
)
def test_tables(command: Command, arguments: tuple[str, ...], shown: tuple[str, ...]) -> None:
    status, out, _ = command(*arguments)
    assert status == 0
    for text in shown:
        assert text in out


def test_warnings_come_first(command: Command) -> None:
    lines = command("check", "ren2021").out.splitlines()
    assert lines[1] == "2 warnings:"
    assert lines[2].startswith("  - stages.main: ")
    assert "121.5" in lines[2]
    assert lines[2].endswith("[not-assembled]")


def test_resolved_model_is_a_model(command: Command, tmp_path: Path) -> None:
    target = tmp_path / "resolved.toml"
    assert command("check", "ren2021", "--resolved", "-o", str(target)).status == 0
    again, first = epicyclic.check(str(target)), epicyclic.check("ren2021")
    for name in ("speed", "phase_lead", "mass", "mean_mesh_stiffness"):
        xr.testing.assert_allclose(again[name], first[name], rtol=1e-12)  # written with all digits


def test_report_says_what_it_leaves_out(command: Command, tmp_path: Path) -> None:
    target = tmp_path / "report.html"
    status, out, _ = command("report", "lin1999-n4", "-o", str(target))
    assert status == 0
    assert "lowest natural frequency" in out
    assert "left out: sharing, as damping: no damping is given" in out
    assert target.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")


def test_report_of_sections_alone(command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "report.html"
    ran: list[str] = []
    write = "epicyclic.show.report.write_report"
    monkeypatch.setattr(write, lambda _, found, **__: ran.extend(found))  # what is drawn of them has its own tests
    assert command("report", "lin1999-n4", "--sections", "modes", "-o", str(target)).status == 0
    assert ran == ["check", "modes"]
    status, _, err = command("report", "lin1999-n4", "--sections", "modes,mods", "-o", str(target))
    assert status == 2
    assert "--sections = mods: no such section; allowed: check, stiffness," in err
    assert "sweep-to-the-modes" in err
    assert "Traceback" not in err


def test_report_of_two_models(command: Command, tmp_path: Path) -> None:
    target = tmp_path / "both.html"
    status, out, _ = command("report", "lin1999-n3", "lin1999-n4", "--sections", "modes", "-o", str(target))
    assert status == 0
    assert "lin1999-n4 against lin1999-n3" in " ".join(out.split())
    page = target.read_text(encoding="utf-8")
    assert page.count("<h1>lin1999-n3 and lin1999-n4</h1>") == 1
    assert 'id="figure-compared"' in page
    assert command("report", "lin1999-n3", "lin1999-n4", "--resume", "-o", str(target)).status == 2
    # the second model is read before the first is computed
    status, out, err = command("report", "lin1999-n3", "missing.toml", "-o", str(target))
    assert status == 2
    assert "missing.toml" in err
    assert "check" not in out + err.replace("epicyclic check", "")


def test_report_prints_key_figures(command: Command, tmp_path: Path) -> None:
    words = ("report", "ren2021", "--sections", "sharing,sweep-to-the-modes", "-o", str(tmp_path / "report.html"))
    status, out, _ = command(*words)
    assert status == 0
    for text in ("27.3125 Hz", "10.472 rad/s", "cycle-peak", "3 warnings:", "written:"):
        assert text in out


def test_schema_and_systems(command: Command) -> None:
    assert "stages" in json.loads(command("schema").out)["properties"]
    titles = json.loads(command("systems", "--json").out)
    assert {"lin1999-n3", "lin1999-n4", "lin1999-n5", "ren2021"} <= set(titles)
    assert all(titles.values())


def test_no_convergence_is_status_3(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.questions.modes.modal.modal", raising(ConvergenceError("lower the load")))
    assert command("modes", "lin1999-n4") == (3, "", "no convergence: lower the load\n")


def test_a_fault_is_one_message(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("EPICYCLIC_DEBUG", raising=False)
    monkeypatch.setattr("epicyclic.questions.modes.modal.modal", raising(IndexError("off by one")))
    status, out, err = command("modes", "lin1999-n4")
    assert (status, out) == (1, "")
    assert "IndexError: off by one" in err
    assert "Traceback" not in err


def test_a_fault_has_a_traceback_on_demand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_DEBUG", "1")
    monkeypatch.setattr("epicyclic.questions.modes.modal.modal", raising(IndexError("off by one")))
    with pytest.raises(IndexError):
        app(["modes", "lin1999-n4"])


def test_stopped_leaves_nothing(command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("epicyclic.results.dataset.save_result", raising(KeyboardInterrupt()))
    status, _, err = command("modes", "lin1999-n4", "-o", str(tmp_path / "modes.nc"))
    assert status == 130
    assert err.splitlines()[-1] == "stopped"
    assert list(tmp_path.iterdir()) == []


def raising(error: BaseException) -> Callable[..., object]:
    def fail(*_: object, **__: object) -> object:
        raise error

    return fail


def test_ctrl_c_inside_an_exec_ends_with_the_same_status(tmp_path: Path) -> None:
    """Dataclasses run texts at import; an interrupt there would end `python -m` by the signal itself."""
    code = """
import sys
import typer
from epicyclic.cli.output import complain, reported
complain("begun")
try:
    with reported():
        exec("raise KeyboardInterrupt")
except typer.Exit as error:
    sys.exit(error.exit_code)
"""
    (tmp_path / "run_as_module.py").write_text(code)
    ended = subprocess.run([sys.executable, "-m", "run_as_module"], cwd=tmp_path, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr.splitlines()[-1]) == (130, "stopped")


def test_ctrl_c(tmp_path: Path) -> None:
    target = tmp_path / "sweep.nc"
    with process("sweep", "ren2021", "--points", "100000", "-o", str(target)) as running:
        begun = time.monotonic()
        while not (tmp_path / "sweep.nc.parts").exists() and time.monotonic() - begun < 90:
            time.sleep(0.1)
        time.sleep(0.3)  # far too short to be done
        running.send_signal(signal.SIGINT)
        _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert err.splitlines()[-1] == "stopped"
    # nothing, or what was done by then, and the command that goes on from there
    left = [path.name for path in tmp_path.iterdir()]
    assert left == (["sweep.nc.parts"] if "--resume" in err else [])
    assert not left or (tmp_path / "sweep.nc.parts" / "000000.kept").is_file()


def test_a_closed_pipe_is_quiet() -> None:
    with process("check", "ren2021") as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert "Traceback" not in running.stderr.read()


@pytest.mark.parametrize("name", list(verbs()))
def test_every_verb_is_a_command_that_explains_its_options(command: Command, name: str) -> None:
    status, out, _ = command(name.replace("_", "-"), "--help")
    assert status == 0
    shown = [option for _, _, option in keywords(verbs()[name].run).values() if option.flag is not None]
    for option in shown:
        first = re.split(r"[^A-Za-z]", option.help)[0]
        assert first in out


def test_errors_name_flags(command: Command) -> None:
    assert (
        "--start, --stop = 600 Hz to 20 Hz" in command("sweep", "ren2021", "--start", "600 Hz", "--stop", "20 Hz").err
    )
    assert "--unstable = ignore: goes with contact loss" in command("sweep", "ren2021", "--unstable", "ignore").err
    assert "--set = nothing" in command("check", "ren2021", "--set", "nothing").err
    # a flag without a value, as it was typed
    assert command("steady", "ren2021", "--no-shaft-orders").err == "error: --no-shaft-orders: goes with contact loss\n"
    assert "error: --resume: needs" in command("sweep", "ren2021", "--resume").err


@pytest.mark.parametrize("value", ["true", "false"])
def test_a_case_that_is_no_text_is_told_with_its_value(command: Command, value: str) -> None:
    told = command("modes", "ren2021", "--set", f"case={value}").err
    assert told.startswith(f"error: --case = {value.capitalize()}: ")
    assert "--no-case" not in told
