"""What a load history of a million rows takes: read from a CSV file, sorted into bins, its cycles counted."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
import table

import epicyclic


def rows(quick: bool) -> list[table.Row]:
    """Time of the whole and of columns that need no file; CPU seconds of one thread, one run."""
    count = 100_000 if quick else 1_000_000
    draw = np.random.default_rng(1)
    torque = 1e3 * np.sin(np.arange(count) / 70) + draw.normal(0, 50, count)
    values = np.column_stack([0.1 * np.arange(count), torque, draw.normal(12, 1, count)])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "history.csv"
        np.savetxt(path, values, fmt="%.7g", delimiter=",", header="time [s], torque [kN m], speed [rpm]", comments="")
        clock = time.process_time()
        result = epicyclic.spectrum(path)
        spent = time.process_time() - clock
    words = f"{result.sizes['cycle']} cycles, {result.sizes['case']} load cases"
    least = 10.0 * count / 1e6
    return [
        table.judged(f"history of {count} rows: spectrum", f"{spent:.2f} s", f"<= {least:g} s", spent <= least),
        ("  of that", words, "", ""),
    ]


if __name__ == "__main__":
    table.main(rows, __doc__)
