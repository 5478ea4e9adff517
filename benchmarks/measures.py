"""What the measures of a sweep cost beside its solution, in time and size."""

from __future__ import annotations

import tracemalloc

import numpy as np
import table
from timing import cpu_seconds

from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.steady import sweep
from epicyclic.results.dataset import to_json
from epicyclic.system.system import System


def rows(quick: bool) -> list[table.Row]:
    """Time of the whole sweep and of its solution alone, memory and size of the result; CPU seconds of one thread."""
    from epicyclic.system.assembly import assemble
    from epicyclic.train.resolution import load

    system = assemble(load("ren2021"))
    frequency = np.linspace(20, 600, 200)
    repeats = 3 if quick else 7
    whole = cpu_seconds(lambda: sweep(system, SweepOptions(mesh_frequency=frequency)), repeats=repeats)[0]
    solution = cpu_seconds(lambda: _solve(system, frequency), repeats=repeats)[0]
    tracemalloc.start()
    result = sweep(system, SweepOptions(mesh_frequency=frequency))
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
        table.judged("  memory, peak above the start", f"{peak / 1e6:.1f} MB", "<= 60 MB", peak <= 60e6),
        ("  result; as JSON", f"{megabytes:.1f} MB", "", f"{len(to_json(result)) / 1e6:.1f} MB"),
    ]


def _solve(system: System, frequency: np.ndarray) -> None:
    ready = response(system)
    for _ in respond(ready, frequency / float(ready.lines.tone), tolerance=1e-6):
        pass


if __name__ == "__main__":
    table.main(rows, __doc__)
