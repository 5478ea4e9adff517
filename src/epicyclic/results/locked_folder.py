"""A folder that one run at a time writes to."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import ModelError

try:
    import fcntl
except ImportError:  # not on Windows: there two runs of one folder are not kept apart
    fcntl = None  # type: ignore[assignment]

__all__ = ["is_left_over", "locked_folder", "remove_folder"]

# a folder that another run removes between making and locking is made again
_TRIES = 5


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """A folder, made if need be, that no other run may lock while the block runs; a run that is killed lets go of it.

    Raises
    ------
    ModelError : another run has it, or it cannot be made or opened.
    """
    handle = _locked(folder)
    try:
        yield
    finally:
        with suppress(OSError):
            os.close(handle)


def _locked(folder: Path) -> int:
    """Handle of the folder, whose lock goes with it."""
    for _ in range(_TRIES):
        try:
            folder.mkdir(exist_ok=True)
            handle = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        except FileExistsError:
            raise ModelError("is no folder", path=str(folder), allowed="a new or empty folder") from None
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
        try:
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(handle), os.stat(folder)):
                return handle
        except BlockingIOError:
            os.close(handle)
            break
        except OSError:
            pass
        os.close(handle)
    raise ModelError("another run writes there", path=str(folder), allowed="another output, or wait for its end")


def remove_folder(folder: Path, files: str) -> None:
    """Remove a folder with its own files; it stays where another run has it, or where something else lies in it.

    Parameters
    ----------
    files : glob patterns of its own files, blanks between; the temporary ones of killed writers go too.
    """
    if not folder.is_dir():
        return
    with suppress(ModelError, OSError), locked_folder(folder):
        own = [path for pattern in files.split() for path in folder.glob(pattern)]
        for path in (*own, *filter(is_left_over, folder.iterdir())):
            path.unlink(missing_ok=True)
        folder.rmdir()


def is_left_over(path: Path) -> bool:
    """Whether a file is the temporary one of a killed writer; asked of a locked folder, where no writer is alive."""
    return path.name.startswith(".") and path.name.endswith(".part")
