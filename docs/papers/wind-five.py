"""Figures of the page on `wind-five`: what its tolerances do, which of them matters, what its grades cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import plotly.graph_objects as go
import xarray as xr

import epicyclic
from epicyclic.show.charts.sharing import (
    grade_prices,
    k_gamma_by_design,
    k_gamma_by_tolerance,
    k_gamma_histogram,
    tolerance_shares,
    worst_branches,
)

__all__ = ["FIGURES"]


@cache
def _tolerance() -> xr.Dataset:
    return epicyclic.tolerance("wind-five")


FIGURES: Mapping[str, Callable[[], go.Figure]] = {
    "k-gamma": lambda: k_gamma_histogram(_tolerance()),
    "shares": lambda: tolerance_shares(_tolerance()),
    "by-tolerance": lambda: k_gamma_by_tolerance(_tolerance()),
    "by-design": lambda: k_gamma_by_design(_tolerance()),
    "worst": lambda: worst_branches(_tolerance()),
    "grades": lambda: grade_prices(epicyclic.allocate("wind-five", target=1.1)),
}
