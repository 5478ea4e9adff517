"""A run in pieces with checkpoints: bounded memory, whole segments on disk, resumed to the same bits.

A state is flat here: modal y, y' and
the sliders of Coulomb friction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from ...results.locked_folder import locked_folder
from ...system.system import Array
from .integrators import adaptive_states, modal_scale, rk4_states
from .kept import question
from .motion import Motion
from .store import Begun, Store, open_store

__all__ = ["METHODS", "Method", "RunPlan", "RunRecord", "run"]

Method = Literal["rk4", "dop853", "radau"]
METHODS = ("rk4", "dop853", "radau")
# Steps between two looks at Ctrl-C and the progress bar: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes], and pieces of a segment on disk.
_NUMBERS, _PIECES = 500_000, 8


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
    ModelError : another run writes to the folder; as of `store.open_store` and `kept.with_numbers`.
    """
    with nullcontext() if folder is None else locked_folder(folder):
        return _run(moving, plan, state, slider, folder=folder, asked=asked, resume=resume, progress=progress)


def _run(
    moving: Motion,
    plan: RunPlan,
    state: Array,
    slider: Array,
    *,
    folder: Path | None,
    asked: Mapping[str, object] | None,
    resume: bool,
    progress: Callable[[float], None] | None,
) -> RunRecord:
    """`run` of a folder that is locked."""
    begun = Begun(moving=moving, state=state, slider=slider, step=plan.step, steps=np.array([plan.keep, plan.count]))
    store, parts = None, list[Array]()
    if folder is not None:
        store = open_store(folder, question(moving.system, {"method": plan.method, **(asked or {})}), resume=resume)
        begun = store.begun(begun)
        keep, count = map(int, begun.steps)
        parts = store.segments(width=begun.state.size + begun.slider.size, most=count)
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
