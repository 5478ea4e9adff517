"""A run in pieces with checkpoints: bounded memory, whole segments on disk, resumed to the same bits.

Every segment is written aside and renamed, so that none is ever partly there.  A state is flat here: modal y, y' and
the sliders of Coulomb friction.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...results.whole_file import whole_file, write_text
from ...system.system import Array
from .integrators import adaptive_states, modal_scale, rk4_states
from .kept import question, read_numbers, with_numbers, write_numbers
from .motion import Motion

__all__ = ["METHODS", "Method", "RunPlan", "RunRecord", "run"]

Method = Literal["rk4", "dop853", "radau"]
METHODS = ("rk4", "dop853", "radau")
# Steps between two looks at Ctrl-C and the progress bar: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes], and pieces of a segment on disk.
_NUMBERS, _PIECES = 500_000, 8
_ABOUT, _EQUATION = "run.json", "equation.npz"


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunRecord:
    """What a run has found.

    moving, plan : as they were run, from the folder where the run was taken up again.
    states : (count + 1, 2, n) modal, and sliders : (count + 1, R) [m]; nan from where the motion is no longer finite.
    """

    moving: Motion
    plan: RunPlan
    states: Array
    sliders: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Begun:
    """All numbers a run depends on: equation, start (2, n) modal and sliders (R,), and lengths of its plan."""

    moving: Motion
    state: Array
    slider: Array
    step: float
    steps: NDArray[np.int64]


def run(
    moving: Motion,
    plan: RunPlan,
    state: Array,
    slider: Array,
    *,
    folder: Path | None = None,
    asked: Mapping[str, object] | None = None,
    resume: bool = False,
    progress: Callable[[float], None] | None = None,
) -> RunRecord:
    """A run from a modal state (2, n) and sliders (R,).

    Parameters
    ----------
    folder : keeps whole segments there; what was done stays when the run is stopped, by whatever it is.
    asked : options that, with the System, say which run it is.
    resume : go on from the last of them.  progress : called with the share done; an exception in it ends the run.

    Raises
    ------
    ModelError : as of `open_store` and `kept.with_numbers`.
    """
    begun = _Begun(moving=moving, state=state, slider=slider, step=plan.step, steps=np.array([plan.keep, plan.count]))
    store, parts = None, list[Array]()
    if folder is not None:
        store = open_store(folder, question(moving.system, {"method": plan.method, **(asked or {})}), resume=resume)
        begun, parts = store.begun(begun), store.segments()
        keep, count = map(int, begun.steps)
        moving, plan = begun.moving, replace(plan, step=begun.step, keep=keep, count=count)
    begin = np.concatenate([begun.state.ravel(), begun.slider])
    size = max(1, min(plan.piece, _NUMBERS // begin.size))
    out = np.full((plan.count + 1, begin.size), np.nan)
    out[0] = begin
    done = 0
    for part in parts:
        out[done + 1 : done + 1 + len(part)] = part
        done += len(part)
    _run_pieces(_pieces(moving, plan, out, done, size), out, store, len(parts), done, plan.count, progress)
    n = begun.state.shape[1]
    return RunRecord(moving=moving, plan=plan, states=out[:, : 2 * n].reshape(-1, 2, n), sliders=out[:, 2 * n :])


def _pieces(moving: Motion, plan: RunPlan, out: Array, done: int, size: int) -> Iterator[int]:
    """Fill in out (count + 1, 2 n + R) piece after piece of `size` samples; yields the samples done."""
    n = moving.numbers.squared.size
    scale = modal_scale(moving) if plan.method != "rk4" else None
    while done < plan.count and np.isfinite(out[done]).all():
        last = min(plan.count, (done // size + 1) * size)
        state, slider = out[done, : 2 * n].reshape(2, n), out[done, 2 * n :]
        if plan.method == "rk4" or scale is None:
            found, sliders = _fixed_steps(moving, plan, state, slider, done, last)
        else:
            found, sliders = adaptive_states(
                moving, state, plan.times(done, last), slider=slider, method=plan.method, scale=scale
            )
        out[done + 1 : last + 1, : 2 * n] = found.reshape(-1, 2 * n)
        out[done + 1 : last + 1, 2 * n :] = sliders
        done = last
        yield done


def _fixed_steps(
    moving: Motion, plan: RunPlan, state: Array, slider: Array, done: int, last: int
) -> tuple[Array, Array]:
    """Modal states (last - done, 2, n) and sliders (last - done, R) of samples done + 1 .. last, as of `rk4_states`.

    Ctrl-C is heard between calls: where a sample alone has more steps than a piece, so is it within the sample.
    """
    first = done * plan.keep
    if plan.keep <= _STEPS:
        return rk4_states(
            moving, state, slider=slider, first=first, begin=0.0, step=plan.step, keep=plan.keep, samples=last - done
        )
    found, sliders = np.full((last - done, *state.shape), np.nan), np.full((last - done, slider.size), np.nan)
    for sample in range(last - done):
        for begun in range(0, plan.keep, _STEPS):
            steps = min(_STEPS, plan.keep - begun)
            at = first + sample * plan.keep + begun
            parts = rk4_states(moving, state, slider=slider, first=at, begin=0.0, step=plan.step, keep=steps, samples=1)
            state, slider = parts[0][0], parts[1][0]
            if not np.isfinite(state).all():
                return found, sliders
        found[sample], sliders[sample] = state, slider
    return found, sliders


def _run_pieces(
    pieces: Iterator[int],
    out: Array,
    store: Store | None,
    number: int,
    done: int,
    count: int,
    progress: Callable[[float], None] | None,
) -> None:
    """Run the pieces of out (count + 1, 2 n + R) and write a segment of several at a time.

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
    """A folder with the numbers of a run and its segments 000000.npy, 000001.npy, ... of flat states (K, 2 n + R)."""

    folder: Path

    def begun(self, given: _Begun) -> _Begun:
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

    def segments(self) -> list[Array]:
        """The segments that are there, (K, 2 n + R) each, without a gap.

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
        """Write a segment (K, 2 n + R) whole or not at all."""
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
            (folder / _EQUATION).unlink(missing_ok=True)  # of a run that has not come to its first segment
            write_text(about, json.dumps({"run": run}))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
    return Store(folder=folder)
