"""Runs that are stopped keep what is done and go on to the same bits, or say why they cannot."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.cli.main import app
from epicyclic.engine import run_folder
from epicyclic.engine.run_folder import locked_folder
from epicyclic.errors import ModelError
from epicyclic.questions.contact_loss import sweep as contact_module
from epicyclic.questions.response import steady
from epicyclic.show.report import report
from epicyclic.verbs.record import run_report

# A resonance at which teeth part, a branch folds and both directions jump.
PARTING: dict[str, Any] = {
    "overrides": {"damping.modal": 0.005},
    "contact_loss": True,
    "relative_speed": np.linspace(15.0, 17.0, 6),
}
Run = Callable[..., xr.Dataset]
NAMES = (
    "sweep",
    "contact loss",
    "contact loss reported",
    "integrated",
    "shaft orders",
    "stability",
    "stability map",
)


@pytest.fixture(scope="module")
def document(torsional_set: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    return torsional_set(modal=0.03, sun_planet={"variation": {"cosine": [0.3, 0.1]}})


@pytest.fixture(scope="module")
def runs(document: dict[str, Any]) -> dict[str, Run]:
    """Every kind of run that keeps its results, by name."""
    found: dict[str, Run] = {
        "sweep": lambda **more: epicyclic.sweep(document, points=30, range="modes", **more),
        "contact loss": lambda **more: epicyclic.sweep(document, **PARTING, **more),
        "contact loss reported": lambda **more: epicyclic.sweep(document, **PARTING, unstable="report", **more),
        "integrated": lambda **more: epicyclic.sweep(
            "ren2021", contact_loss=True, start=1080.0, stop=1170.0, points=4, **more
        ),
        "shaft orders": lambda **more: epicyclic.sweep(
            "ren2021", contact_loss=True, relative_speed=np.linspace(1.0, 2.0, 3), **more
        ),
        "stability": lambda **more: epicyclic.stability(document, points=20, **more),
        "stability map": lambda **more: epicyclic.stability(
            document, points=6, over="damping.modal", values=(0.01, 0.02, 0.03), **more
        ),
    }
    assert tuple(found) == NAMES
    return found


class Stop:
    """A progress callback that stops a run at its n-th call."""

    def __init__(self, after: int) -> None:
        self.left, self.seen = after, list[tuple[float, float]]()

    def __call__(self, done: float, of: float = 1) -> None:
        self.seen.append((done, of))
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt


Whole = Callable[[str], tuple[xr.Dataset, Stop]]


@pytest.fixture(scope="module")
def whole(runs: dict[str, Run]) -> Whole:
    """Runs that nothing stops, and the calls of their progress."""
    found: dict[str, tuple[xr.Dataset, Stop]] = {}

    def run(name: str) -> tuple[xr.Dataset, Stop]:
        if name not in found:
            calls = Stop(0)
            found[name] = runs[name](progress=calls), calls
        return found[name]

    return run


# Segments written with every result, or one at the end.
EVERY = [(name, 0.0) for name in NAMES] + [(name, 1e9) for name in ("sweep", "stability map", "shaft orders")]


@pytest.mark.parametrize(("name", "every"), EVERY)
def test_a_stopped_run_goes_on_to_the_same_bits(
    name: str, every: float, tmp_path: Path, whole: Whole, monkeypatch: pytest.MonkeyPatch, runs: dict[str, Run]
) -> None:
    monkeypatch.setattr(run_folder, "_EVERY", every)
    folder, (expected, calls) = tmp_path / "run", whole(name)
    at = int(np.random.default_rng(sum(map(ord, name))).integers(1, len(calls.seen)))
    with pytest.raises(KeyboardInterrupt):
        runs[name](folder=folder, progress=Stop(at))
    with pytest.raises(ModelError, match="an interrupted run lies there"):
        runs[name](folder=folder)
    second = Stop(at + 1)
    with pytest.raises(KeyboardInterrupt):  # stopped again, later
        runs[name](folder=folder, resume=True, progress=second)
    third = Stop(0)
    again = runs[name](folder=folder, resume=True, progress=third)
    xr.testing.assert_identical(again, expected)
    assert third.seen[-1] == calls.seen[-1]


def test_the_runs_have_what_can_go_wrong(whole: Whole) -> None:
    parting, _ = whole("contact loss")
    assert parting.contact_open.max() > 0.5
    assert parting.jumped.any()
    reported = whole("contact loss reported")[0]
    assert (reported.status == "not converged").any()
    assert (reported.branch_instability == "fold").any()
    assert (whole("integrated")[0].motion == "integrated").all()
    assert "superposed_error" in whole("shaft orders")[0]


@pytest.mark.parametrize("name", ["sweep", "stability", "stability map"])
def test_what_is_done_is_not_computed_again(
    name: str, tmp_path: Path, whole: Whole, monkeypatch: pytest.MonkeyPatch, runs: dict[str, Run]
) -> None:
    from epicyclic.questions.stability import stability

    expected, _ = whole(name)
    runs[name](folder=tmp_path / "run")

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(steady, "_measured", refused)
    monkeypatch.setattr(stability, "_point_or_reason", refused)
    xr.testing.assert_identical(runs[name](folder=tmp_path / "run", resume=True), expected)


def test_the_branch_set_is_not_followed_again(
    tmp_path: Path, whole: Whole, monkeypatch: pytest.MonkeyPatch, runs: dict[str, Run]
) -> None:
    expected, _ = whole("contact loss")
    with pytest.raises(KeyboardInterrupt):
        runs["contact loss"](folder=tmp_path / "run", progress=Stop(6))

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("followed again")

    monkeypatch.setattr(contact_module, "branch_set", refused)
    monkeypatch.setattr(contact_module, "_stability", refused)
    # points of the direction that was at work, too
    seen: list[int] = []
    before = contact_module._filled

    def counted(*given: Any) -> Any:
        seen.append(1)
        return before(*given)

    monkeypatch.setattr(contact_module, "_filled", counted)
    xr.testing.assert_identical(runs["contact loss"](folder=tmp_path / "run", resume=True), expected)
    assert len(seen) < 2 * 6 - 2


def test_another_run_is_refused(tmp_path: Path, document: dict[str, Any]) -> None:
    folder = tmp_path / "run"
    options: dict[str, Any] = {"folder": folder, "mesh_frequency": np.array([100.0, 200.0])}
    epicyclic.sweep(document, **options)
    options["resume"] = True
    with pytest.raises(ModelError, match=r"another model: .*meshes.stiffness differs"):
        epicyclic.sweep(document, overrides={"stages.main.meshes.sun-planet.stiffness": 3.01e8}, **options)
    with pytest.raises(ModelError, match="has another model; allowed"):
        epicyclic.sweep(document, overrides={"stages.main.planets": 4}, **options)
    with pytest.raises(ModelError, match=r"other options \(mesh_frequency, orders\)"):
        epicyclic.sweep(document, orders=3, **{**options, "mesh_frequency": np.array([100.0, 201.0])})
    with pytest.raises(ModelError, match="another verb"):
        epicyclic.stability(document, **options)
    with pytest.raises(ModelError, match="needs the file of the run"):
        epicyclic.sweep(document, resume=True)
    (folder / "000000.kept").write_bytes(b"{}\n")
    with pytest.raises(ModelError, match="not a segment of a run"):
        epicyclic.sweep(document, **options)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("")
    with pytest.raises(ModelError, match="is no folder of a run"):
        epicyclic.sweep(document, folder=tmp_path / "mine")


@pytest.mark.parametrize("name", ["sweep", "contact loss", "stability", "stability map", "relief", "report"])
def test_one_run_at_a_time_has_a_folder(
    name: str, tmp_path: Path, runs: dict[str, Run], document: dict[str, Any]
) -> None:
    relief: dict[str, Any] = {
        "mesh": "sun-planet",
        "vary": {"tip_relief.amount": "0..40 um", "tip_relief.length": "3 mm"},
    }
    begin = runs | {
        "relief": lambda **more: epicyclic.relief("ren2021", **relief, **more),
        "report": lambda **more: run_report(document, **more),
    }
    folder = tmp_path / "run"
    with locked_folder(folder), pytest.raises(ModelError, match="another run writes there"):
        begin[name](folder=folder)
    assert not list(folder.iterdir())


def test_only_files_of_a_run_are_deleted(tmp_path: Path, runs: dict[str, Run]) -> None:
    folder = tmp_path / "run"
    runs["sweep"](folder=folder)
    (folder / "mine.nc").touch()
    (folder / "notes").mkdir()
    with locked_folder(folder):  # another run has it
        run_folder.remove_folder(folder)
        run_folder.remove_folder(folder, with_results=False)
    assert sorted(path.name for path in folder.iterdir()) == [
        "000000.kept",
        "mine.nc",
        "model.numbers",
        "notes",
        "run.json",
    ]
    run_folder.remove_folder(folder)
    assert sorted(path.name for path in folder.iterdir()) == ["mine.nc", "notes"]


def test_a_report_goes_on_to_the_same_page(
    tmp_path: Path, document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(name: str) -> None:
        if name == "support stiffness":
            raise KeyboardInterrupt

    folder, some = tmp_path / "run", ("modes", "sweep", "support-stiffness", "run-out")
    with pytest.raises(KeyboardInterrupt):
        run_report(document, sections=some, folder=folder, progress=stop)
    expected = report(run_report(document, sections=some))

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(steady, "sweep", refused)  # a section that is whole
    assert report(run_report(document, sections=some, folder=folder, resume=True)) == expected


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    with pytest.raises(SystemExit) as stop:
        app(list(words), prog_name="epicyclic")
    return int(stop.value.code or 0), capsys.readouterr().err


def test_the_command_line_names_what_goes_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "a b.nc"
    words = ["sweep", "ren2021", "--points", "40", "-o", str(target)]
    monkeypatch.setattr(sys, "argv", ["epicyclic", *words])
    before, calls = steady._measured, list[int]()

    def stopping(*given: Any, **more: Any) -> Any:
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return before(*given, **more)

    monkeypatch.setattr(steady, "_measured", stopping)
    monkeypatch.setenv("EPICYCLIC_JOBS", "1")
    status, err = run(capsys, *words)
    assert status == 130
    assert f"epicyclic sweep ren2021 --points 40 -o '{target}' --resume" in err
    assert err.splitlines()[-1] == "stopped"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a b.nc.parts"]
    assert "an interrupted run lies there" in run(capsys, *words)[1]
    assert run(capsys, *words, "--resume")[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a b.nc"]
    calls[:] = [1]
    status, err = run(capsys, *words[:4])
    assert status == 130
    assert "nothing is kept without -o FILE" in err
    calls[:] = [1]
    status, err = run(capsys, *words[:4], "-o", str(tmp_path / "none.nc"))
    assert status == 130
    assert "nothing was done yet that could be kept" in err
    assert not (tmp_path / "none.nc.parts").exists()  # nothing was done: nothing is left


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to another process")
def test_control_c_is_heard_at_once(tmp_path: Path, slowness: float) -> None:
    """One real SIGINT, of a run with workers; the run that goes on is the run."""
    # segments are written often, so that a short run has one before its end
    often = "from epicyclic.engine import run_folder as f; f._EVERY = 0.05; from epicyclic.__main__ import main; main()"
    command = [sys.executable, "-c", often, "sweep", "ren2021", "--points", "300", "-o", str(tmp_path / "a.nc")]
    parts, spent = tmp_path / "a.nc.parts", list[float]()
    for _ in range(2):  # the second time for a machine that was busy
        with subprocess.Popen(
            [*command, *(["--resume"] if spent else [])],
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as process:
            until, known = time.monotonic() + 120, len(list(parts.glob("*.kept")))
            while len(list(parts.glob("*.kept"))) == known and time.monotonic() < until and process.poll() is None:
                time.sleep(0.01)
            start = time.monotonic()
            os.killpg(process.pid, signal.SIGINT)
            err = process.communicate(timeout=60)[1]
            spent.append(time.monotonic() - start)
        assert process.returncode == 130, err
        assert "--resume" in err
        if spent[-1] < 2 * slowness:
            break
    assert min(spent) < 2 * slowness
    subprocess.run([*command, "--resume"], check=True, stderr=subprocess.PIPE)
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    xr.testing.assert_identical(epicyclic.load_result(tmp_path / "a.nc"), epicyclic.sweep("ren2021", points=300))


def test_a_folder_of_a_run_that_had_not_begun_goes(tmp_path: Path) -> None:
    empty, other = tmp_path / "a.parts", tmp_path / "b.parts"
    for folder in (empty, other):
        folder.mkdir()
        (folder / ".run.json.0123.part").write_text("")
    (other / "letter.txt").write_text("")
    for folder in (empty, other):
        run_folder.remove_folder(folder, with_results=False)
    assert not empty.exists()
    assert [path.name for path in other.iterdir()] == ["letter.txt"]


@pytest.mark.parametrize("files", [(), ("run.json",), ("run.json", "model.numbers")])
def test_a_folder_that_another_run_has_just_made_stays(files: tuple[str, ...], tmp_path: Path) -> None:
    folder = tmp_path / "a.parts"
    folder.mkdir()
    for name in files:
        (folder / name).touch()
    with locked_folder(folder):
        run_folder.remove_folder(folder, with_results=False)
        assert sorted(path.name for path in folder.iterdir()) == sorted(files)
    run_folder.remove_folder(folder, with_results=False)
    assert not folder.exists()
