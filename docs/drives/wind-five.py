"""Figures of the page on `wind-five`: the drawings of the train alone, which schematics.py adds."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import plotly.graph_objects as go

__all__ = ["FIGURES"]

FIGURES: Mapping[str, Callable[[], go.Figure]] = {}
