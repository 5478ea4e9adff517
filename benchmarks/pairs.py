"""Two checkouts timed against each other: `bench.py` of both, in alternating pairs, and the median ratio of every row.

    python benchmarks/pairs.py OLD NEW [--pairs 10] [--quick] [--limit 1.05] [PART ...]

OLD, NEW : folders of checkouts; both run on the interpreter that runs this script, each from its own ``src``.
One part of `bench.py` after the other: both checkouts run it at the same time, one on each core, and change cores with
each pair, so that whatever else the machine does meets both alike.  On one core they run in turns, and which of them
comes first alternates.  A row is compared where both print a time for it; exit status 1 where a median ratio NEW / OLD
is above the limit.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

from bench import PARTS
from table import Row, show

_TIME = re.compile(r"(?:^|[^\w.])(\d+(?:\.\d+)?)\s(ms|us|s)\b")
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
Times = dict[str, float]


def times_of(text: str) -> Times:
    """Label -> time [s] of the rows that `bench.py` printed; a label that comes again is counted."""
    found: Times = {}
    for line in text.splitlines()[1:]:
        cells = re.split(r"\s{2,}", line.strip())
        hit = _TIME.search(cells[1]) if len(cells) > 1 else None
        if hit is None or line.startswith("["):
            continue
        label = cells[0]
        while label in found:
            label += " again"
        found[label] = float(hit[1]) * _SECONDS[hit[2]]
    return found


def started(checkout: Path, part: str, quick: bool, core: int | None) -> subprocess.Popen[str]:
    """One part of the benchmarks of one checkout, pinned to a core."""
    command = [sys.executable, "benchmarks/bench.py", part, *(["--quick"] if quick else [])]
    pinned = [] if core is None else ["taskset", "-c", str(core)]
    return subprocess.Popen(
        [*pinned, *command],
        cwd=checkout,
        env={**os.environ, "PYTHONPATH": str(checkout / "src"), "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def pair(checkouts: tuple[Path, Path], part: str, quick: bool, turn: int) -> tuple[Times, Times]:
    """Times of both checkouts in one pair."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if len(cores) >= 2:
        both = [started(one, part, quick, cores[(place + turn) % 2]) for place, one in enumerate(checkouts)]
        old, new = (times_of(process.communicate()[0]) for process in both)
        return old, new
    order = checkouts if turn % 2 == 0 else checkouts[::-1]
    found = [times_of(started(one, part, quick, None).communicate()[0]) for one in order]
    old, new = found if turn % 2 == 0 else found[::-1]
    return old, new


def ratios(pairs: list[tuple[Times, Times]]) -> list[tuple[str, float, float, float, int]]:
    """Label, median old and new [s], median ratio, pairs, of every row that both print."""
    labels = [label for label in pairs[0][0] if all(label in old and label in new for old, new in pairs)]
    rows = []
    for label in labels:
        old, new = [one[label] for one, _ in pairs], [one[label] for _, one in pairs]
        ratio = statistics.median(b / a for a, b in zip(old, new, strict=True) if a > 0)
        rows.append((label, statistics.median(old), statistics.median(new), ratio, len(pairs)))
    return rows


def main() -> int:
    """Print the table; exit status 1 where a row became slower than the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--limit", type=float, default=1.05)
    parser.add_argument("parts", nargs="*", metavar="PART", default=list(PARTS))
    given = parser.parse_intermixed_args()
    checkouts = given.old.resolve(), given.new.resolve()
    table: list[Row] = []
    slower = 0
    for part in given.parts:
        pairs = [pair(checkouts, part, given.quick, turn) for turn in range(given.pairs)]
        table.append((f"[{part}]", "", "", ""))
        for label, old, new, ratio, count in ratios(pairs):
            above = ratio > given.limit
            slower += above
            mark = "SLOWER" if above else ""
            table.append((label, f"{old:.4g} -> {new:.4g} s", f"{ratio:.3f}", f"{count} pairs {mark}".strip()))
        print(f"{part} done", file=sys.stderr, flush=True)
    show(table, ("what", "medians old -> new", "median of new / old", ""))
    return int(slower > 0)


if __name__ == "__main__":
    sys.exit(main())
