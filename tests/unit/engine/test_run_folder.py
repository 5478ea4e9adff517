"""Folders of runs: what lies there is never written over, what has come is written soon, and another run is told."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from epicyclic.engine import run_folder as room
from epicyclic.engine import workers
from epicyclic.engine.run_folder import RunFolder, begun, open_folder, run_folder, segment_path
from epicyclic.errors import ModelError


def test_a_damaged_segment_is_not_written_over(tmp_path: Path) -> None:
    first = RunFolder(folder=tmp_path)
    for place in range(3):
        first.add("points", place, float(place))
        first.write()
    damaged = segment_path(tmp_path, 1)
    damaged.write_bytes(damaged.read_bytes()[:-1])
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    again = RunFolder(folder=tmp_path)
    again.add("points", 3, 3.0)
    for _ in range(2):  # at the result, and at the end of the run
        with pytest.raises(ModelError):
            again.write()
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_without_one_of_its_segments_is_refused(tmp_path: Path) -> None:
    first = RunFolder(folder=tmp_path)
    for place in range(3):
        first.add("points", place, float(place))
        first.write()
    segment_path(tmp_path, 1).unlink()
    before = sorted(path.name for path in tmp_path.iterdir())
    again = RunFolder(folder=tmp_path)
    with pytest.raises(ModelError, match=r"000001.kept: not a run that can be continued: a segment is missing"):
        again.part("points").known.get(0)
    again.add("points", 3, 3.0)
    with pytest.raises(ModelError, match="a segment is missing"):
        again.write()
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_a_value_is_made_once_and_the_latest_stands(tmp_path: Path) -> None:
    for calls in ([1], []):
        seen = list[int]()
        kept = RunFolder(folder=tmp_path)
        assert kept.made("whole", lambda seen=seen: (seen.append(1), 7.5)[1]) == 7.5  # type: ignore[misc]
        assert seen == calls
        assert kept.value("begin") == (None if calls else 2)
        kept.keep_value("begin", 1)
        kept.write()
        kept.keep_value("begin", 2)
        kept.write()


@pytest.mark.parametrize(("every", "begin"), [(0, 1), (1e18, None)])
def test_what_replaces_itself_is_written_with_a_result_now_and_then(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, every: float, begin: int | None
) -> None:
    monkeypatch.setattr(room, "_EVERY", 1e-9)  # s
    monkeypatch.setattr(room, "_LATEST", every)
    kept = RunFolder(folder=tmp_path)
    kept.keep_value("begin", 1)
    kept.add("points", 0, 2.0)
    killed = RunFolder(folder=tmp_path)
    assert (dict(killed.part("points").known), killed.value("begin")) == ({0: 2.0}, begin)


def test_without_a_folder_nothing_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(room, "_EVERY", 0.0)
    with run_folder(None, (1.0,), verb="any", options={}, resume=False) as (model, kept):
        part = kept.part("points", ["a"])
        part.add(0, 1.0)
        kept.keep_value("begin", 1)
        assert kept.made("whole", lambda: 2.0) == 2.0
        assert (model, dict(part.known), kept.value("begin")) == ((1.0,), {}, None)
        assert (kept.pending, kept.latest) == ([], {})  # nor held
    assert not list(tmp_path.iterdir())


def test_a_dataset_is_kept_as_it_is(tmp_path: Path) -> None:
    whole = xr.Dataset(
        {
            "force": (("mesh", "time"), np.arange(6.0).reshape(2, 3), {"units": "N"}),
            "line": ("time", np.array([1 + 2j, np.nan, 0])),
            "status": ("mesh", np.array(["ok", ""], dtype=object)),
            "open": ("mesh", np.array([True, False])),
            "count": ((), np.int64(3)),
        },
        coords={"mesh": ["a", "b"], "time": [0.0, 0.5, 1.0], "speed": ("time", [1.0, 2.0, 3.0], {"units": "1"})},
        attrs={"verb": "any", "points": 3, "warnings": "[]"},
    )
    first = RunFolder(folder=tmp_path)
    first.part("sections", ["one"]).add(0, whole)
    first.write()
    again = RunFolder(folder=tmp_path).part("sections", ["none", "one"]).known[1]
    xr.testing.assert_identical(again, whole)
    assert {name: one.dtype for name, one in again.variables.items()} == {
        name: one.dtype for name, one in whole.variables.items()
    }


def test_another_run_is_told_with_both_values(tmp_path: Path) -> None:
    record: dict[str, object] = {
        "verb": "sweep",
        "versions": {"numpy": "1"},
        "model": np.arange(2.0),
        "options": {"points": 3, "orders": 12},
    }
    with open_folder(tmp_path, record, resume=False):
        RunFolder(folder=tmp_path).made("whole", lambda: 1)
    changes: list[tuple[dict[str, object], str]] = [
        ({"verb": "stability"}, r"verb = stability: .* has another verb; allowed: verb = sweep, or delete the folder"),
        ({"versions": {"numpy": "2"}}, r"versions.numpy = 2: .* has another version; allowed: versions.numpy = 1, or"),
        (
            {"options": {"points": 4}},
            r"points = 4, orders = \(nothing\): .* other options \(points, orders\); .*3, orders",
        ),
        ({"model": np.arange(3.0)}, r"another model; allowed: the command it was begun with, or"),
    ]
    for change, said in changes:
        with pytest.raises(ModelError, match=said), open_folder(tmp_path, record | change, resume=True):
            pass
    with open_folder(tmp_path, record, resume=True):
        assert begun(tmp_path)


def _seen(folder: Path, item: str) -> bool:
    """Whether the results of the others lie on disk; waited for where the item is the last one."""
    until = time.monotonic() + 20
    while item == "last" and time.monotonic() < until:
        if set(RunFolder(folder=folder).part("points").known) == {0, 1, 2}:
            return True
        time.sleep(0.05)
    return False


def test_what_workers_have_sent_is_written_while_another_is_at_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    monkeypatch.setattr(workers, "_WORTH", {"fork": 0.0, "spawn": 0.0})
    monkeypatch.setattr(room, "_EVERY", 1e9)  # not by the next result
    kept = RunFolder(folder=tmp_path).part("points")
    assert workers.each(partial(_seen, tmp_path), ["first", "next", "next", "last"], kept=kept)[3]
