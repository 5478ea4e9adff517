"""The train of each page from the front and from the side, as the report draws it: figures that every page has."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.drawing.painter import train_front, train_section

__all__ = ["schematics_of"]

TURNING: Mapping[str, Any] = {"operation.speed.sun": "1000 rpm"}  # no speed is printed: the senses are shown, no number
# page -> figure -> drawing, drive, overrides
SCHEMATICS: Mapping[str, Mapping[str, tuple[Callable[[Any], go.Figure], str, Mapping[str, Any]]]] = {
    "dong2019": {"front": (train_front, "dong2019", {}), "section": (train_section, "dong2019", {})},
    "encased-differential": {
        "front": (train_front, "encased-differential", {}),
        "section": (train_section, "encased-differential", {}),
    },
    "lin1999": {"front": (train_front, "lin1999-n4", {}), "section": (train_section, "lin1999-n4", {})},
    "ren2021": {"front": (train_front, "ren2021", {}), "section": (train_section, "ren2021", {})},
    "wind-five": {"front": (train_front, "wind-five", {}), "section": (train_section, "wind-five", {})},
    "xu2020": {"front": (train_front, "xu2020", {}), "section": (train_section, "xu2020", {})},
    "yue2014": {
        "front": (train_front, "yue2014-i", TURNING),
        "section-i": (train_section, "yue2014-i", {}),
        "section-ii": (train_section, "yue2014-ii", {}),
        "section-iii": (train_section, "yue2014-iii", {}),
    },
}


def schematics_of(page: str) -> dict[str, Callable[[], go.Figure]]:
    """Figures of a page, name -> function that draws it."""
    return {name: partial(_draw, *what) for name, what in SCHEMATICS.get(page, {}).items()}


def _draw(drawing: Callable[[Any], go.Figure], drive: str, overrides: Mapping[str, Any]) -> go.Figure:
    drawn = drawing(epicyclic.check(drive, overrides=dict(overrides)))
    if overrides is TURNING:
        for note in drawn.layout.annotations:
            note.text = re.sub(r", [\d. ]+ rpm(?= [↺↻])", "", note.text)
    return drawn
