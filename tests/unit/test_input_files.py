"""Files of the user are read in pieces."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

from epicyclic.errors import ModelError
from epicyclic.user_input import read_bytes


def test_a_large_limit_sets_no_memory_aside(tmp_path: Path) -> None:
    content = bytes(range(256)) * 20_000  # several pieces
    (tmp_path / "file").write_bytes(content)
    tracemalloc.start()
    try:
        assert read_bytes(tmp_path / "file", most=4_000_000_000) == content
        assert tracemalloc.get_traced_memory()[1] < 4 * len(content)
    finally:
        tracemalloc.stop()


def test_a_file_up_to_its_limit(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"12345")
    assert read_bytes(tmp_path / "file", most=5) == b"12345"
    with pytest.raises(ModelError, match="too large"):
        read_bytes(tmp_path / "file", most=4)
