"""What may be chosen of a job before it starts: one list each, the first entry as the job itself would take it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["OPTIONS", "JobChoice", "JobOption"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JobChoice:
    """One entry: its words, and the options that it means."""

    label: str
    options: Mapping[str, int | float | str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class JobOption:
    """A list of choices with its name."""

    label: str
    choices: tuple[JobChoice, ...]


OPTIONS: Mapping[str, JobOption] = {
    "contact": JobOption(
        label="Show",
        choices=(
            JobChoice(label="transmission error"),
            JobChoice(label="load along the face", options={"show": "load"}),
        ),
    ),
    "relief": JobOption(
        label="Search",
        # three times the candidates and generations: two optima of nearly the same error are told apart
        choices=(JobChoice(label="quick"), JobChoice(label="thorough", options={"population": 36, "generations": 24})),
    ),
    "tolerance": JobOption(
        label="Trains",
        choices=(JobChoice(label="16 384"), JobChoice(label="131 072", options={"samples": 131_072})),
    ),
    "contact_loss": JobOption(
        label="Speeds",
        choices=(
            JobChoice(label="60"),
            JobChoice(label="200", options={"points": 200}),
            JobChoice(label="60 with shaft orders", options={"shaft_orders": True}),
        ),
    ),
    "transient": JobOption(
        label="Mesh cycles",
        choices=(JobChoice(label="50"), JobChoice(label="300", options={"cycles": 300.0})),
    ),
    "sensitivity": JobOption(
        label="Of",
        choices=(JobChoice(label="lowest frequency"), JobChoice(label="mesh force", options={"of": "force"})),
    ),
}
"""Job -> what may be chosen of it; a job that is missing has nothing to choose."""
