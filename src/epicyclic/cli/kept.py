"""What a stopped run leaves beside its output, and the command that goes on from there."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import ModelError
from .console import complain

__all__ = ["kept", "kept_store"]


@contextmanager
def kept(output: Path | None, *, keeps: bool, record: str = "") -> Iterator[Path | None]:
    """The folder beside the output that keeps what is done until the run is whole; None without one.

    On Ctrl-C and on a full disk, says what is kept and names the command that goes on.  A folder with nothing to go on
    from is deleted.

    Parameters
    ----------
    keeps : whether the command keeps anything at all.  record : file of the folder that ``--resume`` takes, if any.
    """
    folder = None if output is None or not output.name else output.with_name(output.name + ".parts")
    if folder is not None and not folder.absolute().parent.is_dir():
        folder = None
    if folder is None:
        try:
            yield None
        except KeyboardInterrupt:
            if keeps and "--resume" in sys.argv:
                complain(f"this command continues it:\n  {_command()}")
            elif keeps:
                complain("nothing is kept without -o FILE; with it, --resume goes on from where a run was stopped")
            raise
        return
    from ..engine.run_folder import begun, remove_folder, remove_without_results

    try:
        yield folder
    except (KeyboardInterrupt, ModelError) as error:
        if begun(folder) and (isinstance(error, KeyboardInterrupt) or error.problem.startswith("cannot be written")):
            command = _command(str(folder / record)) if record else _command()
            complain(f"what is done is kept in {folder}; this command continues it:\n  {command}")
        elif keeps and isinstance(error, KeyboardInterrupt):
            complain("nothing was done yet that could be kept")
        raise
    else:
        remove_folder(folder)
    finally:
        remove_without_results(folder)


@contextmanager
def kept_store(store: Path | None) -> Iterator[None]:
    """Say, where a command with blocks is stopped, what its store keeps and how it goes on."""
    try:
        yield
    except (KeyboardInterrupt, ModelError) as error:
        stopped = isinstance(error, KeyboardInterrupt)
        broken = isinstance(error, ModelError) and error.problem.startswith(("cannot be written", "the connection"))
        if store is not None and any((store / "done").glob("c.*")):
            if stopped or broken:
                complain(f"what is done is kept in {store}; this command continues it:\n  {_command()}")
        elif stopped and store is not None:
            complain("nothing was done yet that could be kept")
        elif stopped:
            complain("nothing is kept without --store DIR; with it, --resume goes on from where a run was stopped")
        raise


def _command(*file: str) -> str:
    """The command that goes on; file : that ``--resume`` takes."""
    words = sys.argv[1:]
    return shlex.join(["epicyclic", *words, *([] if "--resume" in words else ["--resume", *file])])
