"""What a run keeps in its folder: the numbers it was begun with, and whole segments of its states."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...engine.plain import read_plain, write_plain
from ...engine.run_folder import MODEL_FILE, read_numbers, segment_path, with_numbers, write_numbers
from ...errors import ModelError
from ...system.system import Array
from .motion import Motion

__all__ = ["Begun", "Store"]


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
    """The open folder of a run with its numbers and segments: flat states (K, 2 n + R) and the tally at their end."""

    folder: Path

    def begun(self, given: Begun) -> Begun:
        """The numbers the run was begun with: those kept in the folder, else the given ones, which are written there.

        Raises
        ------
        ModelError : the kept ones are of another model, or cannot be read.
        """
        path = self.folder / MODEL_FILE
        if path.is_file():
            return with_numbers(given, read_numbers(path), compared=".moving.system.", path=path)
        if segment_path(self.folder, 0).is_file():
            raise ModelError("not a run that can be continued", path=str(path))
        write_numbers(path, given)
        return given

    def segments(self, *, width: int, most: int, tallied: int) -> list[tuple[Array, Array]]:
        """The segments that are there without a gap: states (K, 2 n + R) and the flat tally each.

        Parameters
        ----------
        width : numbers of a state.  most : states of all segments together.  tallied : numbers of a flat tally.

        Raises
        ------
        ModelError : one of them cannot be read, is damaged, or is of another run.
        """
        found: list[tuple[Array, Array]] = []
        while (path := segment_path(self.folder, len(found))).is_file():
            parts = read_plain(path)
            if not _is_segment(parts, width, most, tallied):
                raise ModelError("not a segment of this run", path=str(path))
            states, tally = parts
            most -= len(states)
            found.append((states, tally))
        return found

    def add(self, number: int, states: Array, tally: Array) -> None:
        """Write a segment of states (K, 2 n + R) and the flat tally whole or not at all."""
        write_plain(segment_path(self.folder, number), (states, tally))


def _is_segment(parts: object, width: int, most: int, tallied: int) -> bool:
    """Whether what a file holds are at most so many states of a width, and a tally of so many numbers."""
    if not (isinstance(parts, tuple) and len(parts) == 2 and all(isinstance(part, np.ndarray) for part in parts)):
        return False
    states, tally = parts
    shapes = states.ndim == 2 and states.shape[1] == width and len(states) <= most and tally.shape == (tallied,)
    return shapes and states.dtype == tally.dtype == np.float64
