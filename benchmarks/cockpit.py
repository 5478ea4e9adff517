"""What an update of the cockpit takes, step by step: wall time of one process [ms], median and 95th percentile.

    python benchmarks/cockpit.py [--moves 50] [--cpu] [--drive NAME ...]

With --cpu the time of the processor is taken instead, which other processes change less.

A lever moves: every run has another stiffness of the planets' bearings, and is then let go, which asks for the whole
set of the same state.  The targets are for an idle machine.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import statistics
import time
import tomllib
from collections.abc import Callable, Iterator
from typing import Any

from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.computing.speed_view import efforts, force_curves, mode_view, speed_model
from epicyclic.cockpit.computing.train_view import error_view, live_sharing, train_head, twin_of
from epicyclic.cockpit.state.frames import Request, body_labels, mesh_labels, pack
from epicyclic.document.document import drive_text
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load

RUN_OUTS: dict[str, object] = {
    "deviations.sun.run_out": "20 um",
    "deviations.planet.run_out": "20 um",
    "deviations.ring.run_out": "20 um",
    "deviations.carrier.run_out": "20 um",
    "deviations.planet.position.y": "[20, 0, 0, 0] um",
}
DRIVES: dict[str, tuple[str, dict[str, object]]] = {
    "ren2021": ("ren2021", {}),
    "xu2020": ("xu2020", {}),
    "xu2020 with run-outs": ("xu2020", RUN_OUTS),
}
LEVER = "stages.main.planet.bearing.radial"
# Median of the live set, and of a full set until its shaft orders [ms].
TARGETS = {
    "ren2021": {"live": 83, "full: shaft orders": 500},
    "xu2020 with run-outs": {"live": 150, "full: shaft orders": 500},
}

Times = dict[str, list[float]]


def main() -> None:
    """Print a table for each drive."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--moves", type=int, default=50, help="moves of the lever")
    parser.add_argument("--drive", nargs="*", default=list(DRIVES), choices=list(DRIVES))
    parser.add_argument("--cpu", action="store_true", help="time of the processor, not of the wall")
    chosen = parser.parse_args()
    clock = time.process_time if chosen.cpu else time.perf_counter
    for name in chosen.drive:
        show(name, measured(*DRIVES[name], moves=chosen.moves, clock=clock))


def measured(drive: str, overrides: dict[str, object], *, moves: int, clock: Callable[[], float]) -> Times:
    """Times of every step over the moves [ms], after three to warm up."""
    source, times = tomllib.loads(drive_text(drive)), Times()
    for move in range(-3, moves):
        moved = {**overrides, LEVER: f"{1e9 * (1 + 0.01 * move):.6g} N/m"}
        for step, spent in run(source, moved, clock=clock):
            if move >= 0:
                times.setdefault(step, []).append(spent)
    return times


def run(
    source: dict[str, Any], overrides: dict[str, object], *, clock: Callable[[], float]
) -> Iterator[tuple[str, float]]:
    """One move: every step by itself, then the live and the full set as the page gets them [ms]."""
    kept: dict[str, Any] = {}

    def timed(step: str, work: Callable[[], object]) -> tuple[str, float]:
        start = clock()
        kept[step] = work()
        return step, 1e3 * (clock() - start)

    yield timed("load", lambda: load(source, overrides))
    train = kept["load"]
    yield timed("assemble", lambda: assemble(train))
    system = kept["assemble"]
    yield timed("train view", lambda: train_head(train, body_labels(train), mesh_labels(train)))
    yield timed("modes", lambda: mode_view(train, system, body_labels(train)))
    yield timed("sharing at rest", lambda: live_sharing(system))
    yield timed("twin", lambda: twin_of(train, kept["sharing at rest"]))
    yield timed("errors", lambda: error_view(train, system, {}))
    yield timed("120 speeds", lambda: force_curves(*ready(system)))
    request = Request(rev=1, kind="live", source=source, overrides=overrides)
    yield timed("live", lambda: list(compute(request)))
    yield timed("pack", lambda: pack(kept["live"][0]))
    start = clock()
    for frame in compute(Request(rev=1, kind="full", source=source, overrides=overrides)):
        stage = frame.head["sweep"]["stage"].removeprefix("with ") if frame.kind == "sweep" else frame.kind
        yield f"full: {stage}", 1e3 * (clock() - start)


def ready(system: Any) -> tuple[Any, Any]:
    """What the curve of the live set is computed of."""
    model = speed_model(system)
    return model, efforts(model)[0]


def show(name: str, times: Times) -> None:
    """A table: steps, median and 95th percentile, targets."""
    print(f"\n{name:24}{'median':>14}{'p95':>8}{'target':>8}")
    for step, spent in times.items():
        ordered = sorted(spent)
        late = ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]
        target = TARGETS.get(name, {}).get(step, "")
        print(f"{step:24}{statistics.median(ordered):14.1f}{late:8.1f}{target:>8}")


if __name__ == "__main__":
    main()
