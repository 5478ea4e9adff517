"""What the measures of a sweep cost beside its solution, in time and size."""

from __future__ import annotations

import statistics
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import table

from epicyclic.analyses.steady.response import respond, response
from epicyclic.analyses.steady.sweep import sweep
from epicyclic.results.dataset import to_json
from epicyclic.system.system import System


def rows(quick: bool) -> list[table.Row]:
    """Time of the whole sweep and of its solution alone, memory and size of the result; CPU seconds of one thread."""
    from epicyclic.assemble import assemble
    from epicyclic.resolve import load

    system = assemble(load("ren2021"))
    frequency = np.linspace(20, 600, 200)
    repeats = 3 if quick else 7
    whole = _median(lambda: sweep(system, mesh_frequency=frequency), repeats)
    solution = _median(lambda: _solved(system, frequency), repeats)
    tracemalloc.start()
    result = sweep(system, mesh_frequency=frequency)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    megabytes = result.nbytes / 1e6
    return [
        ("ren2021 with shaft orders, 200 speeds: sweep", f"{whole:.3f} s", "", ""),
        (
            "  of that the solution, the rest are its measures",
            f"{solution:.3f} s",
            "",
            f"{1 - solution / whole:.0%} measures",
        ),
        ("  memory, peak above the start", f"{peak / 1e6:.1f} MB", "<= 60 MB", "met" if peak <= 60e6 else "MISSED"),
        ("  result; as JSON", f"{megabytes:.1f} MB", "", f"{len(to_json(result)) / 1e6:.1f} MB"),
    ]


def _solved(system: System, frequency: np.ndarray) -> None:
    ready = response(system)
    for _ in respond(ready, frequency / float(ready.lines.tone), tolerance=1e-6):
        pass


def _median(run: Callable[[], object], repeats: int) -> float:
    run()
    spent = []
    for _ in range(repeats):
        clock = time.process_time()
        run()
        spent.append(time.process_time() - clock)
    return statistics.median(spent)


if __name__ == "__main__":
    table.main(rows, __doc__)
