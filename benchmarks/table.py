"""The one form of all benchmarks: rows of what, here, target and a remark; MISSED where a target is not met."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence

__all__ = ["HEADER", "Row", "Rows", "judged", "main", "missed", "show"]

Row = tuple[str, str, str, str]
Rows = Callable[[bool], list[Row]]
HEADER: Row = ("what", "here", "target", "")


def judged(what: str, here: str, target: str, met: bool) -> Row:
    """A row that has a target."""
    return what, here, target, "met" if met else "MISSED"


def missed(rows: Sequence[Row]) -> list[str]:
    """What missed its target."""
    return [row[0].strip() for row in rows if "MISSED" in row[3]]


def show(rows: Sequence[Row], header: Row = HEADER) -> None:
    """Print rows in columns."""
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    for row in [header, *rows]:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip(), flush=True)


def main(rows: Rows, about: str | None) -> None:
    """Run one benchmark by itself; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer points, shorter")
    found = rows(parser.parse_args().quick)
    show(found)
    sys.exit(int(bool(missed(found))))
