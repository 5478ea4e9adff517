"""Prose in lines of a width: words, and numbers with their units, stay whole."""

from __future__ import annotations

import re
import textwrap

__all__ = ["glued", "longest_word", "unglued", "wrapped"]

_GLUE = "\u00a0"  # a space at which no line ends; textwrap breaks at the spaces of ASCII alone
_UNIT = r"(?:%|rpm|deg|(?:[kMGmuµn])?(?:Hz|N|W|m|g|Pa|s|rad|J|V)(?:[/^·*²³][^\s,;]*)?|(?:N|kN|MN) m(?:/rad)?)"
_NUMBER = re.compile(rf"(?<=\d) (?={_UNIT}(?:[\s,;.:)\]]|$))")
_MOMENT = re.compile(r"(?<=\d[ \u00a0]N|[ \u00a0][kM]N) (?=m\b)")
_BRACKET = re.compile(r"\[[^\[\]]{1,24}\]")


def glued(text: str) -> str:
    """Text whose spaces between a number and its unit, and inside a short bracket, end no line."""
    text = _MOMENT.sub(_GLUE, _NUMBER.sub(_GLUE, text))
    return _BRACKET.sub(lambda found: found[0].replace(" ", _GLUE), text)


def unglued(text: str) -> str:
    """The text as it is printed."""
    return text.replace(_GLUE, " ")


def longest_word(text: str) -> int:
    """Letters of the longest piece of a glued text at which no line may end."""
    return max(map(len, text.split(" ")), default=0)


def wrapped(text: str, width: int, *, first: str = "", later: str = "") -> list[str]:
    """Lines of at most a width; a word that is longer stands whole on a line of its own.

    Parameters
    ----------
    width : letters of a line.  first, later : what the first line and the others begin with.
    """
    found: list[str] = []
    for place, line in enumerate(text.splitlines() or [""]):
        begin = later if place else first
        room = max(width, len(begin) + 1)
        lines = textwrap.wrap(
            glued(line),
            room,
            initial_indent=begin,
            subsequent_indent=later,
            break_long_words=False,
            break_on_hyphens=False,
        )
        found += lines or [begin.rstrip()]
    return [unglued(line) for line in found]
