"""What may be chosen of a job before it starts: one list each, the first entry as the job itself would take it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["OPTIONS", "Choice", "JobOption"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One entry: its words, and the options that it means."""

    label: str
    options: Mapping[str, int | float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class JobOption:
    """A list of choices with its name."""

    label: str
    choices: tuple[Choice, ...]


OPTIONS: Mapping[str, JobOption] = {
    "relief": JobOption(
        label="Search",
        choices=(
            Choice(label="quick"),
            # some 30 times the reliefs of a quick search: both optima of a crown and a tip relief are told apart
            Choice(label="thorough", options={"population": 24, "generations": 20}),
        ),
    ),
    "tolerance": JobOption(
        label="Draws",
        choices=(
            Choice(label="as the model needs"),
            Choice(label="1000", options={"samples": 1000}),
            Choice(label="10 000", options={"samples": 10_000}),
        ),
    ),
    "contact_loss": JobOption(
        label="Speeds",
        choices=(
            Choice(label="60"),
            Choice(label="30, quick", options={"points": 30}),
            Choice(label="200, fine", options={"points": 200}),
        ),
    ),
    "transient": JobOption(
        label="Mesh cycles",
        choices=(
            Choice(label="300"),
            Choice(label="100, quick", options={"cycles": 100}),
            Choice(label="1000, slow run-up", options={"cycles": 1000}),
        ),
    ),
}
"""Job -> what may be chosen of it; a job that is missing has nothing to choose."""
