"""Folders of runs: what lies there is never written over."""

from __future__ import annotations

from pathlib import Path

import pytest

from epicyclic.engine.run_folder import RunFolder, segment_path
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
