"""A run in pieces: bounded memory while it goes, segments on disk, stopped and taken up again bit by bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ...system.system import Array
from .integrators import march, scale_of, stride
from .motion import Motion, to_modal
from .run import Store, fingerprint, open_store

__all__ = ["METHODS", "Method", "Plan", "run"]

Method = Literal["rk4", "dop853", "radau"]
METHODS = ("rk4", "dop853", "radau")
# Steps between two looks at Ctrl-C and the progress bar: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes], and pieces of a segment on disk.
_NUMBERS, _PIECES = 500_000, 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Samples 0 .. count of a run: sample i at i keep step [s].

    step : of fixed-step integration [s].  keep : steps from sample to sample.  count : samples after the first.
    """

    method: Method
    step: float
    keep: int
    count: int

    @property
    def piece(self) -> int:
        """Samples integrated at a time; integrators of variable step begin anew there, cut or not."""
        return max(1, _STEPS // self.keep)

    def times(self, first: int, last: int) -> Array:
        """Times of samples first .. last [s]."""
        times: Array = np.arange(first, last + 1, dtype=np.float64) * (self.keep * self.step)
        return times


def run(
    moving: Motion,
    plan: Plan,
    state: Array,
    *,
    folder: Path | None = None,
    resume: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Array:
    """Modal states (count + 1, 2, n) from a state (2, n) q, q'; nan from where the motion is no longer finite.

    Parameters
    ----------
    folder : keeps whole segments there; what was done stays when the run is stopped, by whatever it is.
    resume : go on from the last of them.  progress : called with the share done; an exception in it ends the run.

    Raises
    ------
    ModelError : as of `open_store`.
    """
    begin = to_modal(moving, state)
    size = max(1, min(plan.piece, _NUMBERS // begin.size))
    out = np.full((plan.count + 1, *begin.shape), np.nan)
    out[0] = begin
    done = number = 0
    store = None
    if folder is not None:
        store = open_store(folder, _identity(moving, plan, begin), resume=resume)
        for part in store.segments():
            out[done + 1 : done + 1 + len(part)] = part
            done, number = done + len(part), number + 1
    pieces = _pieces(moving, plan, out, done, size)
    _keep(pieces, out, store, number, done, plan.count, progress)
    return out


def _identity(moving: Motion, plan: Plan, begin: Array) -> str:
    numbers = [np.asarray(value) for value in moving.numbers]
    return fingerprint([*numbers, moving.shapes, begin, plan.step, plan.keep, plan.count, plan.method])


def _pieces(moving: Motion, plan: Plan, out: Array, done: int, size: int) -> Iterator[int]:
    """Fill in piece after piece; yields the samples done."""
    N = moving.numbers
    scale = scale_of(moving) if plan.method != "rk4" else None
    while done < plan.count and np.isfinite(out[done]).all():
        last = min(plan.count, (done // size + 1) * size)
        if plan.method == "rk4" or scale is None:
            found = march(
                N, out[done], first=done * plan.keep, begin=0.0, step=plan.step, keep=plan.keep, samples=last - done
            )
        else:
            found = stride(N, out[done], plan.times(done, last), method=plan.method, scale=scale)
        out[done + 1 : last + 1] = found
        done = last
        yield done


def _keep(
    pieces: Iterator[int],
    out: Array,
    store: Store | None,
    number: int,
    done: int,
    count: int,
    progress: Callable[[float], None] | None,
) -> None:
    """Run the pieces; write a segment of several at a time, and what is done at the end of whatever kind."""
    written, waiting = done, 0
    try:
        for done in pieces:
            waiting += 1
            if store is not None and waiting == _PIECES:
                store.add(number, out[written + 1 : done + 1])
                written, number, waiting = done, number + 1, 0
            if progress is not None:
                progress(done / count)
    finally:
        if store is not None and done > written:
            store.add(number, out[written + 1 : done + 1])
