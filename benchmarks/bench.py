"""All benchmarks in one table and one process: what each analysis takes, its error, and its target.

    python benchmarks/bench.py [--quick] [PART ...]

Each part is a file beside this one and runs by itself too; its first lines say what is measured and against what.
CPU seconds of one thread, medians.  Some rows (fresh process, memory) start a process of their own and say so.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import sys
import time
from importlib import import_module

from table import Row, missed, show

PARTS = (
    "response",
    "scaling",
    "tolerance",
    "sensitivity",
    "stability",
    "contact",
    "torus",
    "transient",
    "measures",
    "load_spectrum",
    "modulation",
    "tooth_stiffness",
    "tooth_contact",
    "teeth_system",
    "relief",
    "peers",
)


def main() -> int:
    """Print the table; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer points, shorter")
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; all of them where none is given"
    )
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    found: list[Row] = []
    for part in given.parts or PARTS:
        clock = time.perf_counter()
        rows = import_module(part).rows(given.quick)
        found += [(f"[{part}]", "", "", f"{time.perf_counter() - clock:.0f} s in all"), *rows, ("", "", "", "")]
        print(f"{part} done", file=sys.stderr, flush=True)
    show(found)
    for what in missed(found):
        print(f"missed: {what}", file=sys.stderr)
    return int(bool(missed(found)))


if __name__ == "__main__":
    sys.exit(main())
