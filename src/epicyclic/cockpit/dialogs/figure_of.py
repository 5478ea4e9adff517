"""A figure of the report, made in a process of its own from the results that it needs."""

from __future__ import annotations

import json
from typing import Any

from ...show.plot import companions, figure_names, plot
from ...train.resolution import load
from ...verbs.record import verbs
from .compared_states import Loadable

__all__ = ["VERBS", "figure_of", "figures"]

VERBS: tuple[str, ...] = ("check", "modes", "sharing", "static", "steady", "sweep", "stiffness", "efficiency")
"""Verbs of a train alone that take seconds; longer ones are jobs, and stand in the report."""


def figures() -> dict[str, tuple[str, ...]]:
    """Verb -> names of its figures, of `VERBS`."""
    return {verb: names for verb in VERBS if (names := figure_names(verb))}


def figure_of(model: Loadable, verb: str, name: str) -> dict[str, Any]:
    """A figure as plain JSON of plotly.

    Raises
    ------
    ModelError : the model lacks what the verb needs, or the result has nothing to draw there.
    """
    source, overrides = model
    train = load(source, overrides=overrides)
    results = [verbs()[one].run(train) for one in (verb, *companions(verb, name))]
    drawn: dict[str, Any] = json.loads(plot(name, *results).to_json(validate=False))
    return drawn
