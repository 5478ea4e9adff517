"""The table of `compare.py`: by verb, by verb and drive, what moved, and what is told beside it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from compare_measures import Finding

__all__ = ["Row", "failures", "notes", "page", "summary"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One verb of one drive: what came of it, how far the two are apart, seconds of the old and of the new."""

    case: str
    drive: str
    outcome: str
    found: Finding
    seconds: tuple[float, float]

    @property
    def failed(self) -> bool:
        return bool(self.found.failures)

    @property
    def verdict(self) -> str:
        return "FAIL" if self.failed else "PASS"


def summary(rows: Sequence[Row]) -> str:
    """One line a verb, over all drives."""
    head = ("verb", "results", "errors", "of scale", "of entry", "largest in", "old s", "new s", "verdict")
    lines = [_case(name, [row for row in rows if row.case == name]) for name in dict.fromkeys(row.case for row in rows)]
    return _table([head, *lines, _case("all", rows)])


def _case(name: str, rows: Sequence[Row]) -> tuple[str, ...]:
    worst = max(rows, key=lambda row: row.found.scale)
    place = f"{worst.drive}: {worst.found.where}" if worst.found.scale else ""
    failed = sum(row.failed for row in rows)
    done = sum(row.outcome == "result" for row in rows)
    return (
        name,
        str(done),
        str(len(rows) - done),
        _number(worst.found.scale),
        _number(max(row.found.entry for row in rows)),
        place,
        f"{sum(row.seconds[0] for row in rows):.1f}",
        f"{sum(row.seconds[1] for row in rows):.1f}",
        f"FAIL {failed} of {len(rows)}" if failed else "PASS",
    )


def failures(rows: Sequence[Row], *, most: int | None = None) -> str:
    """What moved, a line each."""
    lines = [f"{row.case} | {row.drive}: {text}" for row in rows for text in row.found.failures]
    return _cut(lines, most)


def notes(rows: Sequence[Row], *, most: int | None = None) -> str:
    """Wording and new names; the same text of several results once."""
    counted = Counter(text for row in rows for text in row.found.notes)
    first = {text: f"{row.case} | {row.drive}" for row in reversed(rows) for text in row.found.notes}
    return _cut([f"{first[text]} and {n - 1} more: {text}" for text, n in counted.items()], most)


def _cut(lines: list[str], most: int | None) -> str:
    shown = [line if len(line) <= 400 else line[:397] + "..." for line in lines[:most]]
    return "\n".join(shown + ([f"... and {len(lines) - len(shown)} more"] if len(shown) < len(lines) else []))


def page(rows: Sequence[Row], heads: Mapping[str, str], wall: float) -> str:
    """The whole as Markdown."""
    head = ("verb", "drive", "outcome", "of scale", "of entry", "largest in", "old s", "new s", "verdict")
    lines = [
        (
            row.case,
            row.drive,
            row.outcome,
            _number(row.found.scale),
            _number(row.found.entry),
            row.found.where,
            f"{row.seconds[0]:.2f}",
            f"{row.seconds[1]:.2f}",
            row.verdict,
        )
        for row in rows
    ]
    moved = sum(row.failed for row in rows)
    bullets = [f"- {line}" for line in failures(rows).splitlines()] or ["Nothing."]
    told = [f"- {line}" for line in notes(rows).splitlines()] or ["Nothing."]
    parts = [
        "# Two checkouts compared",
        f"Old {heads['old']}, new {heads['new']}: {len(rows)} results, {moved} moved; {wall:.0f} s.",
        "## By verb",
        summary(rows),
        "## What moved",
        "\n".join(bullets),
        "## Wording and names, no difference",
        "\n".join(told),
        "## By verb and drive",
        _table([head, *lines]),
    ]
    return "\n\n".join(parts) + "\n"


def _number(value: float) -> str:
    return "0" if value == 0 else f"{value:.1e}"


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Rows as a Markdown table in columns; the first is the head."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = [
        "| " + " | ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) + " |" for row in rows
    ]
    return "\n".join([lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]])
