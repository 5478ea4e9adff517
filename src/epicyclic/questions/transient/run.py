"""A run in pieces with checkpoints: bounded memory, whole segments on disk, resumed to the same bits.

Its folder keeps the numbers that it was begun with, and whole segments of its states.  A state is flat here: modal
y, y' and the sliders of Coulomb friction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...engine.plain import read_plain, write_plain
from ...engine.run_folder import MODEL_FILE, open_folder, read_numbers, segment_path, with_numbers, write_numbers
from ...errors import ModelError
from ...system.system import Array
from .equation import Motion
from .integrators import Tally, adaptive_states, empty_tally, rk4_states
from .program import Steps

Method = Literal["rk4", "dop853", "radau"]
METHODS = ("rk4", "dop853", "radau")
# Steps between two looks at Ctrl-C and the progress bar: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes], and pieces of a segment on disk.
_NUMBERS, _PIECES = 500_000, 8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Begun:
    """All numbers a run depends on: equation, start (2, n) modal and sliders (R,), and lengths of its plan."""

    moving: Motion
    state: Array
    slider: Array
    step: float
    steps: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """Samples 0 .. count of a run: sample i at i keep step [s].

    step : of fixed-step integration [s].  keep : steps from sample to sample.  count : samples after the first.
    """

    method: Method
    step: float
    keep: int
    count: int

    def times(self, first: int, last: int) -> Array:
        """Times of samples first .. last, (last - first + 1,) [s]."""
        times: Array = np.arange(first, last + 1, dtype=np.float64) * (self.keep * self.step)
        return times


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunRecord:
    """What a run has found.

    moving, plan : as they were run, from the folder where the run was taken up again.
    states : (count + 1, 2, n) modal, and sliders : (count + 1, R) [m]; nan from where the motion is no longer finite.
    tally : of all its steps.
    """

    moving: Motion
    plan: RunPlan
    states: Array
    sliders: Array
    tally: Tally


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
    ModelError : as of `open_folder`, `_kept_numbers` and `_segments`.
    """
    begun = Begun(moving=moving, state=state, slider=slider, step=plan.step, steps=np.array([plan.keep, plan.count]))
    if folder is None:
        return _run(begun, plan, None, progress)
    options = {"method": plan.method, **(asked or {})}
    with open_folder(folder, verb="transient", model=moving.system, options=options, resume=resume):
        return _run(begun, plan, folder, progress)


def _run(begun: Begun, plan: RunPlan, folder: Path | None, progress: Callable[[float], None] | None) -> RunRecord:
    """`run` from its beginning, or from where its folder ends; what is done is written however it ends."""
    segments, tally = list[tuple[Array, Array]](), empty_tally(begun.moving)
    if folder is not None:
        begun = _kept_numbers(folder, begun)
        keep, count = map(int, begun.steps)
        plan = replace(plan, step=begun.step, keep=keep, count=count)
        width = begun.state.size + begun.slider.size
        segments = _segments(folder, width=width, most=plan.count, tallied=tally.flat().size)
    begin = np.concatenate([begun.state.ravel(), begun.slider])
    out = np.full((plan.count + 1, begin.size), np.nan)
    out[0], done = begin, 0
    for states, flat in segments:
        out[done + 1 : done + 1 + len(states)] = states
        done, tally = done + len(states), tally.of(flat)
    # integrators of variable step begin anew at the end of a piece, wherever a run was cut
    size = max(1, min(_STEPS // plan.keep, _NUMBERS // begin.size))
    written, number, pieces = done, len(segments), 0
    try:
        while done < plan.count and np.isfinite(out[done]).all():
            last, longer = min(plan.count, (done // size + 1) * size), tally.copy()
            out[done + 1 : last + 1] = _piece(begun.moving, plan, out[done], done, last, longer)
            done, tally, pieces = last, longer, pieces + 1
            if folder is not None and pieces == _PIECES:
                write_plain(segment_path(folder, number), (out[written + 1 : done + 1], tally.flat()))
                written, number, pieces = done, number + 1, 0
            if progress is not None:
                progress(done / plan.count)
    finally:
        if folder is not None and done > written:
            write_plain(segment_path(folder, number), (out[written + 1 : done + 1], tally.flat()))
    n = begun.state.shape[1]
    states, sliders = out[:, : 2 * n].reshape(-1, 2, n), out[:, 2 * n :]
    return RunRecord(moving=begun.moving, plan=plan, states=states, sliders=sliders, tally=tally)


def _piece(moving: Motion, plan: RunPlan, flat: Array, done: int, last: int, tally: Tally) -> Array:
    """Flat states (last - done, 2 n + R) of samples done + 1 .. last, from that of sample `done` (2 n + R,)."""
    n = moving.numbers.squared.size
    state, slider = flat[: 2 * n].reshape(2, n), flat[2 * n :]
    if plan.method == "rk4":
        states, sliders = _fixed_steps(moving, plan, state, slider, done, last, tally)
    else:
        times = plan.times(done, last)
        states, sliders = adaptive_states(moving, state, times, slider=slider, method=plan.method, tally=tally)
    return np.concatenate([states.reshape(-1, 2 * n), sliders], axis=1)


def _fixed_steps(
    moving: Motion, plan: RunPlan, state: Array, slider: Array, done: int, last: int, tally: Tally
) -> tuple[Array, Array]:
    """Modal states (last - done, 2, n) and sliders (last - done, R) of samples done + 1 .. last, as of `rk4_states`.

    Ctrl-C is heard between calls: where a sample alone has more steps than a piece, so is it within the sample.
    """
    steps = Steps(begin=0.0, step=plan.step, first=done * plan.keep, keep=plan.keep, samples=last - done)
    if plan.keep <= _STEPS:
        return rk4_states(moving, state, slider, steps, tally)
    states, sliders = np.full((last - done, *state.shape), np.nan), np.full((last - done, slider.size), np.nan)
    for sample in range(last - done):
        for passed in range(0, plan.keep, _STEPS):
            first = steps.first + sample * plan.keep + passed
            few = steps._replace(first=first, keep=min(_STEPS, plan.keep - passed), samples=1)
            (state,), (slider,) = rk4_states(moving, state, slider, few, tally)
            if not np.isfinite(state).all():
                return states, sliders
        states[sample], sliders[sample] = state, slider
    return states, sliders


# --- what a run keeps in its folder ----------------------------------------------------------------------------------


def _kept_numbers(folder: Path, begun: Begun) -> Begun:
    """The numbers a run was begun with: those kept in its folder, else the given ones, which are written there.

    Raises
    ------
    ModelError : the kept ones are of another model, or cannot be read.
    """
    path = folder / MODEL_FILE
    if path.is_file():
        return with_numbers(begun, read_numbers(path), compared=".moving.system.", path=path)
    if segment_path(folder, 0).is_file():
        raise ModelError("not a run that can be continued", path=str(path))
    write_numbers(path, begun)
    return begun


def _segments(folder: Path, *, width: int, most: int, tallied: int) -> list[tuple[Array, Array]]:
    """The segments that are there without a gap: flat states (K, 2 n + R) and the flat tally at their end, each.

    Parameters
    ----------
    width : numbers of a state.  most : states of all segments together.  tallied : numbers of a flat tally.

    Raises
    ------
    ModelError : one of them cannot be read, is damaged, or is of another run.
    """
    segments: list[tuple[Array, Array]] = []
    while (path := segment_path(folder, len(segments))).is_file():
        match read_plain(path):
            case (np.ndarray() as states, np.ndarray() as tally):
                shapes = states.shape[1:] == (width,) and tally.shape == (tallied,)
                known = shapes and len(states) <= most and states.dtype == tally.dtype == np.float64
            case _:
                known = False
        if not known:
            raise ModelError("not a segment of this run", path=str(path))
        most -= len(states)
        segments.append((states, tally))
    return segments
