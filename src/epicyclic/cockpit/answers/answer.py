"""One answer of the page, and the words that answers share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Level = Literal["good", "warn", "bad", "none"]

QUESTIONS: Mapping[str, str] = {
    "resonance": "Does a mesh order meet a mode near operation?",
    "planet": "Which planet carries most?",
    "float": "What does a floating sun buy?",
    "error": "Which error hurts most?",
    "relief": "What tip relief to grind?",
}
"""Key of an answer -> its question, in the order of the page."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """One line of the page.

    key, question : of `QUESTIONS`.  text : one sentence or two.  figure : the number to remember, "" without one.
    level : how it stands.  apply : overrides by path that act on it, None without.  apply_label : what they do.
    evidence : what shows why: sweep, sharing, errors, relief or modes.  job : that says more, None without.
    stale : whether it belongs to an earlier state.  mode : number of the mode that it is about, None without one.
    speed : that it is about, on the axis of the sweep [rpm], None without one.
    """

    key: str
    question: str
    text: str
    figure: str = ""
    level: Level = "none"
    apply: Mapping[str, object] | None = None
    apply_label: str = ""
    evidence: str = ""
    job: str | None = None
    stale: bool = False
    mode: int | None = None
    speed: float | None = None


def answer(
    key: str,
    text: str,
    *,
    figure: str = "",
    level: Level = "none",
    apply: Mapping[str, object] | None = None,
    apply_label: str = "",
    evidence: str = "",
    job: str | None = None,
    mode: int | None = None,
    speed: float | None = None,
) -> Answer:
    """An answer to the question of a key."""
    return Answer(
        key=key,
        question=QUESTIONS[key],
        text=text,
        figure=figure,
        level=level,
        apply=dict(apply) if apply else None,
        apply_label=apply_label if apply else "",
        evidence=evidence,
        job=job,
        mode=mode,
        speed=speed,
    )


def number(value: float, digits: int = 3) -> str:
    """A number of so many digits, without an exponent where people write none."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.10g}" if "e" in text and 1e-4 <= abs(value) < 1e9 else text


def per_cent(share: float, digits: int = 2) -> str:
    """A share [1] in per cent, to a tenth at most."""
    value = 100 * share
    return f"{value:.0f} %" if abs(value) >= 10 ** (digits - 1) else f"{value:.1f} %"


def larger_part(value: float, other: float) -> float:
    """Relative change of a value to another [1]; 0 where the first is 0."""
    return other / value - 1 if value else 0.0
