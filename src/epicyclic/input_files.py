"""Files of the user, read whole: regular files up to a size, never a device, a pipe or a folder, nor the output."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from .errors import ModelError

_TOO_LARGE = "too large"
# Bytes that are read at once.
_PIECE = 1 << 20
# files that the block of `outputs_apart` has read and will write; None outside of one
_USED: ContextVar[tuple[list[Path], list[Path]] | None] = ContextVar("used", default=None)


@contextmanager
def outputs_apart() -> Iterator[None]:
    """In the block no file is source and output, whatever it is called: the second use of it is refused."""
    token = _USED.set(([], []))
    try:
        yield
    finally:
        _USED.reset(token)


def as_input(file: str | Path) -> None:
    """Count a file among the sources.

    Raises
    ------
    ModelError : it is an output of the same block of `outputs_apart`.
    """
    if used := _USED.get():
        used[0].append(Path(file))
        for output in used[1]:
            _require_apart(Path(file), output)


def as_output(file: Path) -> None:
    """Count a file among the outputs, before the work.

    Raises
    ------
    ModelError : it has been read in the same block of `outputs_apart`.
    """
    if used := _USED.get():
        used[1].append(file)
        for source in used[0]:
            _require_apart(source, file)


def _require_apart(source: Path, output: Path) -> None:
    try:
        same = os.path.samefile(source, output)  # links are followed, and two names of one file are the same
    except (OSError, ValueError):  # one is not there, or a zero byte in the name
        return
    if same:
        problem = f"is {source}, which is read"
        raise ModelError(problem, path="--output", given=str(output), allowed="another file")


def read_bytes(file: str | Path, *, most: int, path: str = "", given: str = "", allowed: str = "") -> bytes:
    """The bytes of a regular file.

    Parameters
    ----------
    file : the file.  most : bytes it may have.
    path : where it is named, for an error; the file itself where empty.  given : how it is named there.
    allowed : what may stand there.

    Raises
    ------
    ModelError : no such file, no regular file (a device or a pipe may never end), too large, it cannot be read, or it
        is the output (`outputs_apart`).
    """

    as_input(file)
    raw, problem = b"", ""
    try:
        # asked before it is opened: opening a pipe waits, opening a device may do something
        problem = _unfit(os.stat(file), most)
        if not problem:
            with open(file, "rb") as opened:
                problem = _unfit(os.fstat(opened.fileno()), most)
                raw = b"" if problem else _read(opened, most)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        problem = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    if len(raw) > most:
        problem = _TOO_LARGE
    if problem:
        raise _refused(problem, given or file, path, f"at most {most} bytes" if problem == _TOO_LARGE else allowed)
    return raw


def _read(opened: BinaryIO, most: int) -> bytes:
    """At most one byte more than may be: a file of the system says no size, another may grow.

    In pieces: `read` of a number sets that many bytes aside first, which a limit of memory may refuse.
    """
    raw = bytearray()
    while len(raw) <= most and (piece := opened.read(min(_PIECE, most + 1 - len(raw)))):
        raw += piece
    return bytes(raw)


def _unfit(found: os.stat_result, most: int) -> str:
    """What is wrong with a file before it is read; nothing where it may be."""
    if stat.S_ISDIR(found.st_mode):
        return "cannot be read: is a folder"
    if not stat.S_ISREG(found.st_mode):
        return "cannot be read: is no regular file"
    return _TOO_LARGE if found.st_size > most else ""


def _refused(problem: str, file: str | Path, path: str, allowed: str) -> ModelError:
    if path:
        return ModelError(problem, path=path, given=str(file), allowed=allowed)
    return ModelError(problem, path=str(file), allowed=allowed)


def read_text(file: str | Path, *, most: int, path: str = "", given: str = "", allowed: str = "") -> str:
    """The text of a regular file in UTF-8, with or without byte order mark; parameters as of `read_bytes`.

    Raises
    ------
    ModelError : as of `read_bytes`, or no UTF-8.
    """
    raw = read_bytes(file, most=most, path=path, given=given, allowed=allowed)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise _refused(f"is not a text file (UTF-8), line {line}", given or file, path, allowed) from None
