"""Files appear whole or not at all, whoever else writes beside."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from epicyclic.errors import ModelError
from epicyclic.results.files import whole_file, write_text


def interrupted(path: Path) -> None:
    with whole_file(path) as file:
        file.write(b"half of")
        raise KeyboardInterrupt


def test_an_interrupted_file_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "result.txt"
    write_text(path, "before")
    with pytest.raises(KeyboardInterrupt):
        interrupted(path)
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_two_writers_leave_the_content_of_one(tmp_path: Path) -> None:
    path = tmp_path / "result.txt"
    texts = [f"{number}" * 100_000 for number in range(8)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda text: write_text(path, text), texts * 8))
    assert path.read_text() in texts
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_of_the_user_named_part_is_not_touched(tmp_path: Path) -> None:
    mine = tmp_path / "result.txt.part"
    mine.write_text("mine")
    write_text(tmp_path / "result.txt", "new")
    assert mine.read_text() == "mine"


def test_a_symbolic_link_is_followed(tmp_path: Path) -> None:
    target, link = tmp_path / "target.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="cannot be written"):
        write_text(tmp_path / "missing" / "result.txt", "text")


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    plain = tmp_path / "plain.txt"
    plain.touch()
    write_text(tmp_path / "result.txt", "text")
    assert (tmp_path / "result.txt").stat().st_mode == plain.stat().st_mode
