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

__all__ = ["is_left_over", "locked_folder"]

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
        if handle is not None:
            with suppress(OSError):
                fcntl.flock(handle, fcntl.LOCK_UN)  # also that of forked workers, which have the handle too
            with suppress(OSError):
                os.close(handle)


def _locked(folder: Path) -> int | None:
    """Handle of the folder, whose lock goes with it; None where there are no locks."""
    for _ in range(_TRIES):
        try:
            folder.mkdir(exist_ok=True)
            if fcntl is None:
                return None
            handle = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        except FileExistsError:
            raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder") from None
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
        try:
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


def is_left_over(path: Path) -> bool:
    """Whether a file is the temporary one of a killed writer; asked of a locked folder, where no writer is alive."""
    return path.name.startswith(".") and path.name.endswith(".part")
