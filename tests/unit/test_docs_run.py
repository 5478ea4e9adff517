"""Every command and every block of Python of the documentation runs, and prints what the page shows."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.unit.doc_blocks import Session, blocks_of, missing_lines, run_block

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
RUN = [page for page in PAGES if any(block.language in ("sh", "python") or block.file for block in blocks_of(page))]


def identifier(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", RUN, ids=identifier)
def test_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")  # pages name them from the root of the checkout
    monkeypatch.setenv("COLUMNS", "200")  # tables whole, as the words of a line are looked for
    session = Session()
    for block in blocks_of(page):
        if block.not_run:
            continue
        if block.file or block.language in ("sh", "python"):
            run_block(block, session)
        elif block.language == "text" and session.printed:
            assert missing_lines(block.text, session.printed) == []


def test_a_line_that_is_not_printed_is_found() -> None:
    printed = "main/sun   0.5   1.25\nwhole train 3"
    assert missing_lines("main/sun 1.25\nwhole train 3\n", printed) == []
    assert missing_lines("main/sun 1.26\n3 whole\n", printed) == ["main/sun 1.26", "3 whole"]


def test_a_mark_before_no_block_is_refused(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- not run: slow -->\n\ntext\n\n```sh\nepicyclic systems\n```\n")
    with pytest.raises(AssertionError, match="before no block"):
        blocks_of(page)


def test_a_command_that_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text("```sh\nepicyclic check none.toml\n```\n")
    (block,) = blocks_of(page)
    with pytest.raises(AssertionError, match="exit status 2"):
        run_block(block, Session())
