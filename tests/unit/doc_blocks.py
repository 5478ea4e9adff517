"""Blocks of a page of the documentation, and how they are run.

    <!-- not run: REASON -->     before a block that only must be right to read
    <!-- file: NAME -->          before a block that is written to a file of that name

A `text` block behind a block that ran is what it prints: the words of each line stand in order in one printed line.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

__all__ = ["Block", "Session", "blocks_of", "commands_of", "missing_lines", "run_block"]

_BLOCK = re.compile(
    r"^(?:<!-- (?P<mark>not run|file): (?P<word>.+?) -->\n+)?```(?P<language>\w*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
_MARK = re.compile(r"^<!-- (not run|file): ", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block: its language, text, and the mark before it."""

    language: str
    text: str
    not_run: str = ""
    file: str = ""


@dataclass(slots=True)
class Session:
    """What blocks of one page share: names of Python, what the last block printed."""

    names: dict[str, Any] = field(default_factory=dict)
    printed: str = ""


def blocks_of(page: Path) -> list[Block]:
    """Blocks of a page in order.  A mark that stands before no block is a mistake of the page."""
    text = page.read_text(encoding="utf-8")
    found = list(_BLOCK.finditer(text))
    assert len(_MARK.findall(text)) == sum(1 for one in found if one["mark"]), f"{page}: a mark before no block"
    return [
        Block(
            language=one["language"],
            text=one["text"],
            not_run=one["word"] if one["mark"] == "not run" else "",
            file=one["word"] if one["mark"] == "file" else "",
        )
        for one in found
    ]


def commands_of(text: str) -> Iterator[tuple[list[str], str]]:
    """Words of every command of a shell block, and the file its output goes to."""
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            cut = words.index(">") if ">" in words else len(words)
            yield words[:cut], "".join(words[cut + 1 :])


def run_block(block: Block, session: Session) -> None:
    """Run a block in the working folder; an `AssertionError` says which command failed."""
    if block.file:
        Path(block.file).write_text(block.text, encoding="utf-8")
    elif block.language == "python":
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(block.text, "block", "exec"), session.names)
        session.printed = printed.getvalue()
    elif block.language == "sh":
        session.printed = ""
        for words, target in commands_of(block.text):
            printed_here = _printed(tuple(words))
            if target:
                Path(target).write_text(printed_here, encoding="utf-8")
            session.printed += printed_here


def _printed(words: tuple[str, ...]) -> str:
    """What a command prints; one that reads and writes no file of its page is run once for all pages."""
    from epicyclic.document.document import drive_titles

    alone = len(words) > 2 and words[2] in drive_titles() and not {"-o", "--worst"} & set(words)
    return _command(words) if alone else _command.__wrapped__(words)


@cache
def _command(words: tuple[str, ...]) -> str:
    """Standard output and error of one command line of the package, run in this process."""
    from epicyclic.cli.main import app

    assert words[0] == "epicyclic", f"{' '.join(words)}: only commands of the package run here; mark the block"
    out, err, status = _stream(), _stream(), 0  # with bytes below, which some commands write
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            app(list(words[1:]))
        except SystemExit as stop:
            status = int(stop.code or 0)
    printed, told = (one.detach().getvalue().decode("utf-8") for one in (out, err))
    assert status == 0, f"{' '.join(words)}: exit status {status}\n{told[-2000:]}"
    return printed + told


def _stream() -> io.TextIOWrapper[io.BytesIO]:
    return io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)


def missing_lines(shown: str, printed: str) -> list[str]:
    """Lines shown whose words are not, in order, in one printed line."""
    lines = [line.split() for line in printed.splitlines()]
    return [
        line for line in shown.splitlines() if line.strip() and not any(_within(line.split(), one) for one in lines)
    ]


def _within(words: Sequence[str], line: Sequence[str]) -> bool:
    rest = iter(line)
    return all(word in rest for word in words)
