"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ..errors import ModelError

__all__ = ["require_writable", "whole_file", "write_text"]

# letters of the name that stand in that of the temporary file: 40 of four bytes each leave room below 255 bytes
_LETTERS = 40


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that takes the place of `path` when the block ends without an error.

    The content is written to a temporary file of a name of its own in the same folder, synchronised to disk, and
    renamed: two writers of one file leave the content of one of them.  A symbolic link is followed, so that its target
    is replaced.  An error or interruption in the block leaves `path` as it was and no temporary file; a writer that is
    killed leaves its temporary file ``.NAME.xxxxxxxxxxxx.part``, which no other writer ever takes.

    Parameters
    ----------
    path : the file to write.

    Raises
    ------
    ModelError : the file cannot be written; what lies there is a folder, a device, a pipe or write-protected.
    """
    try:
        target = _target(path)
        partial = _temporary(target)
        try:
            # exclusive creation: nobody else's file is opened, whatever its name
            with partial.open("xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            if target.is_file():
                partial.chmod(stat.S_IMODE(target.stat().st_mode))
            os.replace(partial, target)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error


def require_writable(path: str | Path) -> None:
    """Make sure, before the work, that a file can be written: a temporary one is made beside it and removed.

    Raises
    ------
    ModelError : as of `whole_file`.
    """
    try:
        partial = _temporary(_target(path))
        partial.open("xb").close()
        partial.unlink()
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error


def _target(path: str | Path) -> Path:
    """The file itself, links followed.

    Raises
    ------
    ModelError : what lies there is no file that may be replaced.  OSError : it cannot be asked.
    """
    try:
        target = Path(os.path.realpath(path))
        found = os.lstat(target)
    except FileNotFoundError:
        return target
    except ValueError as error:  # a zero byte in the name
        raise ModelError(f"cannot be written: {error}", path=str(path)) from None
    if stat.S_ISREG(found.st_mode):
        if not os.access(target, os.W_OK):
            raise ModelError("cannot be written: is write-protected", path=str(path), allowed="a file of another name")
        return target
    kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISLNK, "a link to itself"))
    what = next((name for of_kind, name in kinds if of_kind(found.st_mode)), "no regular file")
    raise ModelError(f"cannot be written: is {what}", path=str(path), allowed="a file")


def _temporary(target: Path) -> Path:
    return target.with_name(f".{target.name[:_LETTERS]}.{secrets.token_hex(6)}.part")


def write_text(path: str | Path, text: str) -> None:
    """Write a text file (UTF-8) that appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    with whole_file(path) as file:
        file.write(text.encode("utf-8"))
