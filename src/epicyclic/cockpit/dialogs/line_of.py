"""The line of a model text at which a path stands: readers of TOML keep no places."""

from __future__ import annotations

import re

__all__ = ["line_of", "line_of_error"]

_HEADING = re.compile(r"\s*\[{1,2}([^\]]+)\]{1,2}\s*(?:#.*)?$")
_KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
_SAID = re.compile(r"\bline (\d+)")


def line_of(text: str, path: str) -> int | None:
    """Number of the line, from 1, that states a path, or else the table that would hold it; None where neither does."""
    wanted = _words(path)
    best: tuple[int, int] | None = None
    heading: tuple[str, ...] = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if found := _HEADING.match(line):
            own = heading = _words(found[1])
        elif found := _KEY.match(line):
            own = (*heading, *_words(found[1]))
        else:
            continue
        shared = _shared(own, wanted)
        if shared and (best is None or shared > best[0]):
            best = (shared, number)
    return best[1] if best else None


def line_of_error(text: str, message: str, path: str) -> int | None:
    """Line of an error: the one that its message names, else that of its path."""
    if found := _SAID.search(message):
        return int(found[1])
    return line_of(text, path)


def _words(path: str) -> tuple[str, ...]:
    return tuple(word for part in path.split(".") if (word := part.strip().strip("\"'").strip()))


def _shared(own: tuple[str, ...], wanted: tuple[str, ...]) -> int:
    """Words that a line has in common with a path, from the beginning on."""
    return next((i for i, (a, b) in enumerate(zip(own, wanted, strict=False)) if a != b), min(len(own), len(wanted)))
