"""The folder of a run: the numbers it was begun with, and whole segments of its states.

Every file is written aside and renamed, so that none is ever partly there, and bears a digest.
"""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...input_files import read_bytes, read_text
from ...results.locked_folder import is_left_over
from ...results.whole_file import whole_file, write_text
from ...system.system import Array
from .kept import read_numbers, with_numbers, write_numbers
from .motion import Motion

__all__ = ["Begun", "Store", "open_store"]

_ABOUT, _EQUATION = "run.json", "equation.npz"
# bytes: run.json holds a digest; a segment is of some four million numbers
_MAX_ABOUT, _MAX_SEGMENT = 10_000, 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Begun:
    """All numbers a run depends on: equation, start (2, n) modal and sliders (R,), and lengths of its plan."""

    moving: Motion
    state: Array
    slider: Array
    step: float
    steps: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Store:
    """A folder with the numbers of a run and its segments 000000.npy, 000001.npy, ... of flat states (K, 2 n + R)."""

    folder: Path

    def begun(self, given: Begun) -> Begun:
        """The numbers the run was begun with: those kept in the folder, else the given ones, which are written there.

        Raises
        ------
        ModelError : the kept ones are of another model, or cannot be read.
        """
        path = self.folder / _EQUATION
        if path.is_file():
            return with_numbers(given, read_numbers(path), compared=".moving.system.", path=path)
        if self._path(0).is_file():
            raise ModelError("not a run that can be continued", path=str(path))
        write_numbers(path, given)
        return given

    def segments(self, *, width: int, most: int) -> list[Array]:
        """The segments that are there, (K, 2 n + R) each, without a gap.

        Parameters
        ----------
        width : numbers of a state.  most : states of all segments together.

        Raises
        ------
        ModelError : one of them cannot be read, is damaged, or is of another run.
        """
        found: list[Array] = []
        while (path := self._path(len(found))).is_file():
            states = _segment(path)
            most -= len(states)
            if states.shape[1] != width or most < 0:
                raise ModelError("not a segment of this run", path=str(path))
            found.append(states)
        return found

    def add(self, number: int, states: Array) -> None:
        """Write a segment (K, 2 n + R) and its digest, whole or not at all.

        Raises
        ------
        ModelError : the file cannot be written.
        """
        image = io.BytesIO()
        np.save(image, states, allow_pickle=False)
        with whole_file(self._path(number)) as file:
            file.write(image.getbuffer())
            file.write(hashlib.sha256(image.getbuffer()).digest())

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:06d}.npy"


def open_store(folder: Path, run: str, *, resume: bool) -> Store:
    """The store of a run in a locked folder, made or taken up again.

    Parameters
    ----------
    run : `kept.question` of the run.  resume : whether segments that lie there are wanted.

    Raises
    ------
    ModelError : segments lie there and are not asked for, or are of another run; or the folder cannot be written.
    """
    about = folder / _ABOUT
    begun = (folder / f"{0:06d}.npy").is_file()
    if about.is_file() and (begun or resume):
        if not resume:
            raise ModelError("an interrupted run lies there", path=str(folder), allowed="resume, or delete the folder")
        try:
            known = json.loads(read_text(about, most=_MAX_ABOUT))["run"]
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ModelError("not a run that can be continued", path=str(about)) from error
        if known != run:
            raise ModelError(
                "the run that lies there has another model, other options or another start",
                path=str(folder),
                allowed="the command it was begun with, or delete the folder",
            )
    elif not about.is_file() and not all(is_left_over(path) for path in folder.iterdir()):
        raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
    else:
        try:
            (folder / _EQUATION).unlink(missing_ok=True)  # of a run that has not come to its first segment
            write_text(about, json.dumps({"run": run}))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
    return Store(folder=folder)


def _segment(path: Path) -> Array:
    """States (K, 2 n + R) of a segment.

    Raises
    ------
    ModelError : it cannot be read, or its bytes are others than were written.
    """
    raw = read_bytes(path, most=_MAX_SEGMENT)
    stream = io.BytesIO(raw)
    # segments of an earlier version have no digest: whatever a damaged one raises is its own fault, MemoryError too
    try:
        states = np.load(stream, allow_pickle=False)
    except Exception as error:
        raise ModelError(f"not a segment of a run: {error}", path=str(path)) from error
    digest = raw[stream.tell() :]
    if digest and digest != hashlib.sha256(raw[: stream.tell()]).digest():
        raise ModelError("not a segment of a run: damaged, its bytes are others than were written", path=str(path))
    if not isinstance(states, np.ndarray) or states.ndim != 2 or states.dtype != np.float64:
        raise ModelError("not a segment of a run: no states", path=str(path))
    return states
