"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ..errors import ModelError

__all__ = ["whole_file", "write_text"]


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that takes the place of `path` when the block ends without an error.

    The content is written to a temporary file of a name of its own in the same folder, synchronised to disk, and
    renamed: two writers of one file leave the content of one of them.  A symbolic link is followed, so that its target
    is replaced.  An error or interruption in the block leaves `path` as it was and no temporary file.

    Parameters
    ----------
    path : the file to write.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    target = Path(os.path.realpath(path))
    partial = target.with_name(f".{target.name}.{secrets.token_hex(6)}.part")
    try:
        # exclusive creation: nobody else's file is opened, whatever its name
        with partial.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, target)
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file (UTF-8) that appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    with whole_file(path) as file:
        file.write(text.encode("utf-8"))
