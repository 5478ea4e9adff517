"""A run in pieces with checkpoints: bounded memory, whole segments on disk, resumed to the same bits.

Every segment is written aside and renamed, so that none is ever partly there.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ...errors import ModelError
from ...results.whole_file import whole_file, write_text
from ...system.system import Array
from .integrators import adaptive_states, modal_scale, rk4_states
from .motion import Motion, to_modal

__all__ = ["METHODS", "Method", "RunPlan", "run"]

Method = Literal["rk4", "dop853", "radau"]
METHODS = ("rk4", "dop853", "radau")
# Steps between two looks at Ctrl-C and the progress bar: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes], and pieces of a segment on disk.
_NUMBERS, _PIECES = 500_000, 8
_ABOUT = "run.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
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
        """Times of samples first .. last, (last - first + 1,) [s]."""
        times: Array = np.arange(first, last + 1, dtype=np.float64) * (self.keep * self.step)
        return times


def run(
    moving: Motion,
    plan: RunPlan,
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
        store = open_store(folder, _run_fingerprint(moving, plan, begin), resume=resume)
        for part in store.segments():
            out[done + 1 : done + 1 + len(part)] = part
            done, number = done + len(part), number + 1
    pieces = _pieces(moving, plan, out, done, size)
    _run_pieces(pieces, out, store, number, done, plan.count, progress)
    return out


def _run_fingerprint(moving: Motion, plan: RunPlan, begin: Array) -> str:
    """Digest of the equation, the plan and the start (2, n): equal where the runs are, bit by bit."""
    numbers = [np.asarray(value) for value in moving.numbers]
    return fingerprint([*numbers, moving.shapes, begin, plan.step, plan.keep, plan.count, plan.method])


def _pieces(moving: Motion, plan: RunPlan, out: Array, done: int, size: int) -> Iterator[int]:
    """Fill in out (count + 1, 2, n) piece after piece of `size` samples; yields the samples done."""
    N = moving.numbers
    scale = modal_scale(moving) if plan.method != "rk4" else None
    while done < plan.count and np.isfinite(out[done]).all():
        last = min(plan.count, (done // size + 1) * size)
        if plan.method == "rk4" or scale is None:
            found = rk4_states(
                N, out[done], first=done * plan.keep, begin=0.0, step=plan.step, keep=plan.keep, samples=last - done
            )
        else:
            found = adaptive_states(N, out[done], plan.times(done, last), method=plan.method, scale=scale)
        out[done + 1 : last + 1] = found
        done = last
        yield done


def _run_pieces(
    pieces: Iterator[int],
    out: Array,
    store: Store | None,
    number: int,
    done: int,
    count: int,
    progress: Callable[[float], None] | None,
) -> None:
    """Run the pieces of out (count + 1, 2, n) and write a segment of several at a time.

    And the rest however the run ends.
    """
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Store:
    """A folder with segments 000000.npy, 000001.npy, ...

    Of modal states (K, 2, n), and the fingerprint of their run.
    """

    folder: Path

    def segments(self) -> list[Array]:
        """The segments that are there, (K, 2, n) each, without a gap.

        Raises
        ------
        ModelError : one of them cannot be read.
        """
        found: list[Array] = []
        while (path := self._path(len(found))).is_file():
            try:
                found.append(np.load(path, allow_pickle=False))
            except (OSError, ValueError, EOFError) as error:
                raise ModelError(f"not a segment of a run: {error}", path=str(path)) from error
        return found

    def add(self, number: int, states: Array) -> None:
        """Write a segment (K, 2, n) whole or not at all."""
        with whole_file(self._path(number)) as file:
            np.save(file, states, allow_pickle=False)

    def remove(self) -> None:
        """Delete the folder and what is in it."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:06d}.npy"


def open_store(folder: Path, run: str, *, resume: bool) -> Store:
    """The store of a run, made or taken up again.

    Parameters
    ----------
    run : `fingerprint` of the run.  resume : whether segments that lie there are wanted.

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
            known = json.loads(about.read_text(encoding="utf-8"))["run"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ModelError("not a run that can be continued", path=str(about)) from error
        if known != run:
            raise ModelError(
                "the run that lies there has another model, other options or another start",
                path=str(folder),
                allowed="the command it was begun with, or delete the folder",
            )
    elif folder.exists() and not about.is_file() and (not folder.is_dir() or any(folder.iterdir())):
        raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
    else:
        try:
            folder.mkdir(exist_ok=True)
            write_text(about, json.dumps({"run": run}))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
    return Store(folder=folder)


def fingerprint(values: Iterable[object]) -> str:
    """A digest of numbers and arrays, equal where every bit is."""
    digest = hashlib.sha256()
    for value in values:
        array = np.ascontiguousarray(value)
        digest.update(f"{array.dtype}{array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
