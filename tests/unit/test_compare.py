"""That benchmarks/compare.py sees what it must see, and lets through what it may."""

from __future__ import annotations

import copy
import inspect
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import compare
import numpy as np
import pytest
from compare_cases import CASES, DRIVES, Case, Task, drives_of, tasks_of
from compare_measures import compared, excused
from compare_table import Row, failures, page, summary
from compare_worker import run

import epicyclic
from epicyclic.questions.studies.compare import drawing_differences
from epicyclic.verbs.record import verbs as records

Record = dict[str, Any]
ROOT = Path(__file__).parents[2]
NO_VERBS = {
    *("System", "Train", "ConvergenceError", "ModelError"),
    *("assemble", "load", "load_result", "save_result", "to_json", "write_report"),
    "study",  # of a job file: its verbs are here
    "compare",  # of several models: what it compares is here
    "spectrum",  # of a load history
    *("save_matrices", "read_rexs", "write_rexs", "figure_names", "plot", "explain"),
    *("planetary", "star", "differential"),
}


@pytest.fixture(scope="module")
def modes() -> Record:
    return run("modes", "lin1999-n4", {})


@pytest.fixture(scope="module")
def sweep() -> Record:
    return run("sweep", str(DRIVES / "backlash.toml"), {"points": 4})


@pytest.fixture(scope="module")
def system() -> Record:
    return run("system", str(DRIVES / "backlash.toml"), {})


def _changed(record: Record, name: str, change: Callable[[Any], Any]) -> Record:
    """A copy with the values of one variable changed."""
    result = copy.deepcopy(record)
    dims, values, unit, long_name = result["variables"][name]
    result["variables"][name] = (dims, change(values), unit, long_name)
    return result


def _times(place: tuple[int, ...], factor: float) -> Callable[[Any], Any]:
    def change(values: Any) -> Any:
        values[place] *= factor
        return values

    return change


def test_the_same_passes(modes: Record, sweep: Record, system: Record) -> None:
    for record in (modes, sweep, system):
        assert record["outcome"] == "result"
        found = compared(record, copy.deepcopy(record), 1e-9)
        assert (found.scale, found.entry, found.failures, found.notes) == (0, 0, [], [])


@pytest.mark.parametrize("name", ["mesh_force_rms", "mesh_force_order", "amplitude", "bearing_force_rms"])
def test_a_number_that_moves_is_seen(sweep: Record, name: str) -> None:
    values = sweep["variables"][name][1]
    largest = np.unravel_index(np.argmax(np.abs(values)), values.shape)
    moved = _changed(sweep, name, _times(tuple(int(at) for at in largest), 1 + 1e-6))
    found = compared(sweep, moved, 1e-9)
    assert found.scale == pytest.approx(1e-6, rel=1e-3)
    assert [text.split(":")[0] for text in found.failures] == [name] == [found.where]


def test_a_small_entry_that_moves_is_seen_and_rounding_is_not(sweep: Record) -> None:
    base = _changed(sweep, "mesh_force_rms", lambda values: np.full_like(values, 1e3))
    base = _changed(base, "mesh_force_rms", _times((0, 2), 1e-6))
    assert compared(base, _changed(base, "mesh_force_rms", _times((0, 2), 1 + 1e-5)), 1e-9).failures
    assert not compared(base, _changed(base, "mesh_force_rms", _times((0, 1), 1 + 1e-14)), 1e-9).failures


def test_labels_integers_and_nan_are_exact(modes: Record, sweep: Record) -> None:
    def other(values: Any) -> Any:
        values[0] = "other"
        return values

    assert "first at (0,)" in compared(modes, _changed(modes, "mode_kind", other), 1e-9).failures[0]
    assert compared(modes, _changed(modes, "multiplicity", lambda values: values + 1), 1e-9).failures
    assert "nan" in compared(sweep, _changed(sweep, "mesh_force_rms", lambda v: v * np.nan), 1e-9).failures[0]
    assert compared(sweep, _changed(sweep, "status", other), 1e-9).failures


def test_variables_dims_and_units_are_those_of_before(modes: Record) -> None:
    less = copy.deepcopy(modes)
    del less["variables"]["mode_kind"]
    assert compared(modes, less, 1e-9).failures == ["mode_kind: missing"]
    assert compared(less, modes, 1e-9).failures == ["mode_kind: not there before"]
    assert compared(modes, _changed(modes, "frequency", lambda values: values[:-1]), 1e-9).failures
    dims, values, _, long_name = modes["variables"]["frequency"]
    other = {**modes, "variables": {**modes["variables"], "frequency": (dims, values, "rad/s", "in other words")}}
    found = compared(modes, other, 1e-9)
    assert found.failures == ["frequency: unit 'Hz' -> 'rad/s'"]
    assert found.notes == [f"frequency: long name {long_name!r} -> 'in other words'"]


def test_shapes_are_free_in_sign_and_within_a_repeated_frequency(modes: Record) -> None:
    values = modes["variables"]["multiplicity"][1]
    pair = int(np.flatnonzero(values == 2)[0])

    def turned(shape: Any) -> Any:
        c, s = np.cos(0.3), np.sin(0.3)
        shape[:, pair : pair + 2] = shape[:, pair : pair + 2] @ np.array([[c, -s], [s, c]])
        shape[:, -1] *= -1
        return shape

    found = compared(modes, _changed(modes, "shape", turned), 1e-9)
    assert not found.failures
    assert "another sign, phase or basis" in found.notes[0]
    assert compared(modes, _changed(modes, "shape", _times((0, pair), 1.001)), 1e-9).failures


def test_fields_of_a_system_may_have_new_names_but_not_new_numbers(system: Record) -> None:
    renamed = copy.deepcopy(system)
    variables = renamed["variables"]
    variables["mesh.rows"] = variables.pop("meshes.B")
    found = compared(system, renamed, 1e-9)
    assert not found.failures
    assert found.notes == ["meshes.B is now mesh.rows"]
    assert compared(system, _changed(renamed, "mesh.rows", lambda values: values * (1 + 1e-7)), 1e-9).failures
    del variables["mesh.rows"]
    assert compared(system, renamed, 1e-9).failures == ["meshes.B: missing"]


def test_errors_are_compared_by_type_and_path() -> None:
    error = run("steady", "lin1999-n4", {})
    assert (error["outcome"], error["type"]) == ("error", "ModelError")
    assert compared(error, {**error, "message": "in other words"}, 1e-9).failures == []
    assert compared(error, {**error, "path": "elsewhere"}, 1e-9).failures
    assert compared(error, {**error, "type": "TypeError"}, 1e-9).failures
    fault = {**error, "type": "TypeError"}
    assert compared(fault, fault, 1e-9).failures
    assert compared(error, {"outcome": "crash", "message": "gone"}, 1e-9).failures


def test_attributes_warnings_are_counted_words_are_told(sweep: Record) -> None:
    def with_attribute(**attrs: Any) -> Record:
        return {**sweep, "attrs": {**sweep["attrs"], **attrs}}

    told = json.loads(str(sweep["attrs"]["warnings"]))
    assert not compared(sweep, with_attribute(version="9", package="other"), 1e-9).failures
    assert compared(sweep, with_attribute(title="Another"), 1e-9).failures
    assert compared(sweep, with_attribute(warnings=json.dumps([*told, "more"])), 1e-9).failures
    other = with_attribute(warnings=json.dumps([f"{text}!" for text in told]))
    assert compared(sweep, other, 1e-9).failures == []
    assert compared(with_attribute(number=1.0), with_attribute(number=1 + 1e-6), 1e-9).failures
    assert compared(with_attribute(prose="up to 3 of"), with_attribute(prose="as many as 3 of"), 1e-9).failures == []
    assert compared(with_attribute(prose="up to 3 of"), with_attribute(prose="up to 4 of"), 1e-9).failures


def test_what_rounding_moves_too_may_be_let_through(sweep: Record) -> None:
    def moved(factor: float, name: str = "amplitude") -> Record:
        return _changed(sweep, name, lambda values: values * factor)

    rounding = compared(sweep, moved(1 + 1e-7), 1e-9)
    assert not excused(compared(sweep, moved(1 + 1e-6), 1e-9), rounding).failures
    assert "as rounding does" in excused(compared(sweep, moved(1 + 1e-6), 1e-9), rounding).notes[0]
    assert excused(compared(sweep, moved(1 + 1e-5), 1e-9), rounding).failures
    assert excused(compared(sweep, moved(1 + 1e-6, "mesh_force_rms"), 1e-9), rounding).failures


def test_every_verb_and_every_drive_is_there() -> None:
    verbs = {case.verb for case in CASES}
    assert set(epicyclic.__all__) - NO_VERBS <= verbs | set(records())
    drives = {drive.name for drive in drives_of(ROOT)}
    assert {"ready/ren2021", "good/every-key", "own/slices", "own/links", "own/backlash", "own/dampers"} <= drives
    assert {task.case for task in tasks_of(drives_of(ROOT))} == {case.name for case in CASES}


@pytest.mark.parametrize("case", [case for case in CASES if case.verb in epicyclic.__all__], ids=lambda case: case.name)
def test_options_of_a_case_are_those_of_its_verb(case: Case) -> None:
    keywords = inspect.signature(getattr(epicyclic, case.verb)).parameters
    assert set(case.options) <= set(keywords)
    literal = {name: text for name in case.options if (text := str(keywords[name].annotation)).startswith("Literal[")}
    assert [name for name, text in literal.items() if repr(case.options[name]) not in text] == []


def test_the_table_says_what_moved(sweep: Record) -> None:
    found = compared(sweep, _changed(sweep, "mesh_force_rms", lambda values: values * (1 + 1e-6)), 1e-9)
    rows = [Row(case="sweep", drive="own/backlash", outcome="result", found=found, seconds=(1.0, 2.0))]
    assert "FAIL 1 of 1" in summary(rows)
    assert failures(rows).startswith("sweep | own/backlash: mesh_force_rms: 1.0e-06 of scale")
    assert "| sweep | own/backlash | result  | 1.0e-06" in page(rows, {"old": "a", "new": "b"}, 3.0)


def test_two_checkouts_side_by_side(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = [str(ROOT), str(ROOT), "--drives", "lin1999-n3", "--verbs", "check", "--jobs", "1"]
    assert compare.main([*given, "--keep", str(tmp_path), "-o", str(tmp_path / "table.md")]) == 0
    assert "PASS: 1 results, 0 moved" in capsys.readouterr().out
    assert "## By verb and drive" in (tmp_path / "table.md").read_text("utf-8")


def test_a_crash_is_a_record(tmp_path: Path) -> None:
    task = Task(case="modes", verb="modes", drive="x", source="ren2021", text="", options={}, tolerance=1e-9)
    lost = compare.Checkout(name="new", root=tmp_path, python=sys.executable, folder=tmp_path, versions={})
    records: list[Record] = []
    compare.run_all(
        [compare.Job(checkout=lost, task=task)],
        workers=1,
        seconds=30,
        told=lambda job, record: records.append(record),
    )
    assert [record["outcome"] for record in records] == ["crash"]


def test_a_value_written_as_another_quantity_is_compared_by_what_it_comes_to() -> None:
    same = {"stages.main.sun.inertia": "0.000584401 kg m^2"}  # 0.39 kg (38.71 mm)^2
    assert drawing_differences([epicyclic.load("lin1999-n3"), epicyclic.load("lin1999-n3", overrides=same)]) == ()
    stiff = [{"stages.main.sun.support.rz": text} for text in ("1e8 N/m", "299692.82 N m/rad")]
    (found,) = drawing_differences([epicyclic.load("lin1999-n3", overrides=one) for one in stiff])
    assert found.unit == "N m/rad"
    first, second = found.value
    assert first is not None
    assert second == pytest.approx(2 * first, rel=1e-6)
