"""What a run keeps in its folder: the numbers it was begun with, and whole segments of its states.

A run in pieces with checkpoints: bounded memory, whole segments on disk, resumed to the same bits.

A state is flat here: modal y, y' and the sliders of Coulomb friction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
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
from .integrators import Tally, adaptive_states, empty_tally, modal_scale, rk4_states


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
    ModelError : as of `open_folder`, `with_numbers` and `Store.segments`.
    """
    begun = Begun(moving=moving, state=state, slider=slider, step=plan.step, steps=np.array([plan.keep, plan.count]))
    if folder is None:
        return _run(begun, plan, None, progress)
    options = {"method": plan.method, **(asked or {})}
    with open_folder(folder, verb="transient", model=moving.system, options=options, resume=resume):
        return _run(begun, plan, Store(folder=folder), progress)


def _run(begun: Begun, plan: RunPlan, store: Store | None, progress: Callable[[float], None] | None) -> RunRecord:
    """`run` from its beginning, or from where its store ends."""
    moving, parts = begun.moving, list[tuple[Array, Array]]()
    if store is not None:
        begun = store.begun(begun)
        keep, count = map(int, begun.steps)
        moving, plan = begun.moving, replace(plan, step=begun.step, keep=keep, count=count)
    done, tally = 0, empty_tally(moving)
    if store is not None:
        width, tallied = begun.state.size + begun.slider.size, tally.flat().size
        parts = store.segments(width=width, most=plan.count, tallied=tallied)
    begin = np.concatenate([begun.state.ravel(), begun.slider])
    size = max(1, min(plan.piece, _NUMBERS // begin.size))
    out = np.full((plan.count + 1, begin.size), np.nan)
    out[0] = begin
    for part, seen in parts:
        out[done + 1 : done + 1 + len(part)] = part
        done, tally = done + len(part), tally.of(seen)
    begun_at = _Piece(done=done, tally=tally)
    last = _run_pieces(_pieces(moving, plan, out, begun_at, size), out, store, len(parts), begun_at, progress)
    n = begun.state.shape[1]
    return RunRecord(
        moving=moving,
        plan=plan,
        states=out[:, : 2 * n].reshape(-1, 2, n),
        sliders=out[:, 2 * n :],
        tally=last.tally,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Piece:
    """How far a run has come: samples done, and the tally of all steps up to there."""

    done: int
    tally: Tally


def _pieces(moving: Motion, plan: RunPlan, out: Array, begun_at: _Piece, size: int) -> Iterator[_Piece]:
    """Fill in out (count + 1, 2 n + R) piece after piece of `size` samples."""
    done, tally = begun_at.done, begun_at.tally
    n = moving.numbers.squared.size
    scale = modal_scale(moving) if plan.method != "rk4" else None
    while done < plan.count and np.isfinite(out[done]).all():
        last, tally = min(plan.count, (done // size + 1) * size), tally.copy()
        state, slider = out[done, : 2 * n].reshape(2, n), out[done, 2 * n :]
        if plan.method == "rk4" or scale is None:
            found, sliders = _fixed_steps(moving, plan, state, slider, done, last, tally)
        else:
            found, sliders = adaptive_states(
                moving, state, plan.times(done, last), slider=slider, method=plan.method, scale=scale, tally=tally
            )
        out[done + 1 : last + 1, : 2 * n] = found.reshape(-1, 2 * n)
        out[done + 1 : last + 1, 2 * n :] = sliders
        done = last
        yield _Piece(done=done, tally=tally)


def _fixed_steps(
    moving: Motion, plan: RunPlan, state: Array, slider: Array, done: int, last: int, tally: Tally
) -> tuple[Array, Array]:
    """Modal states (last - done, 2, n) and sliders (last - done, R) of samples done + 1 .. last, as of `rk4_states`.

    Ctrl-C is heard between calls: where a sample alone has more steps than a piece, so is it within the sample.
    """
    first = done * plan.keep
    if plan.keep <= _STEPS:
        return rk4_states(
            moving,
            state,
            slider=slider,
            first=first,
            begin=0.0,
            step=plan.step,
            keep=plan.keep,
            samples=last - done,
            tally=tally,
        )
    found, sliders = np.full((last - done, *state.shape), np.nan), np.full((last - done, slider.size), np.nan)
    for sample in range(last - done):
        for begun in range(0, plan.keep, _STEPS):
            steps = min(_STEPS, plan.keep - begun)
            at = first + sample * plan.keep + begun
            states, slid = rk4_states(
                moving, state, slider=slider, first=at, begin=0.0, step=plan.step, keep=steps, samples=1, tally=tally
            )
            state, slider = states[0], slid[0]
            if not np.isfinite(state).all():
                return found, sliders
        found[sample], sliders[sample] = state, slider
    return found, sliders


def _run_pieces(
    pieces: Iterator[_Piece],
    out: Array,
    store: Store | None,
    number: int,
    begun_at: _Piece,
    progress: Callable[[float], None] | None,
) -> _Piece:
    """Run the pieces of out (count + 1, 2 n + R) and write a segment of several at a time; the last of them.

    And the rest however the run ends.
    """
    written, waiting, piece = begun_at.done, 0, begun_at
    try:
        for piece in pieces:
            waiting += 1
            if store is not None and waiting == _PIECES:
                store.add(number, out[written + 1 : piece.done + 1], piece.tally.flat())
                written, number, waiting = piece.done, number + 1, 0
            if progress is not None:
                progress(piece.done / (len(out) - 1))
    finally:
        if store is not None and piece.done > written:
            store.add(number, out[written + 1 : piece.done + 1], piece.tally.flat())
    return piece
