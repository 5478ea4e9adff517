"""`allocate`: the cheapest grades that meet a target of K_gamma, and what one grade more or less buys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, KeyFigure, Part, Section, Table
from ..series import engineering, texts
from ..tolerance_labels import percent, short_entries

if TYPE_CHECKING:
    import xarray as xr

ORDER = 155
_PROOF = {
    "samples": "no grades that meet the target cost less (proven on the samples of the search)",
    "monotone": "no grades that meet the target cost less, if finer grades never raise K_gamma",
    "open": "cheaper grades may be left: the search ended early",
}


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Grade and price of every entry, its neighbours, the totals."""
    names = texts(result, "tolerance")
    return [_grades(result, names), _neighbours(result, names), _totals(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """K_gamma over the price, and the tables."""
    from ..charts.tolerance import grade_prices

    words = "Points: one entry changed by one grade. Steps: the cheapest grades for other targets."
    names = short_entries(texts(result, "tolerance"))
    parts: list[Part] = [
        Drawing(anchor="grade-prices", figure=grade_prices(result), caption=words),
        _grades(result, names),
        _neighbours(result, names),
        _totals(result),
    ]
    return [Section(anchor="allocation", title="Allocation of tolerances", parts=parts)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Total price, and the K_gamma that it reaches [1]."""
    p = percent(float(result.attrs["probability"]))
    return [
        (engineering(float(result["total_price"])), "price of the cheapest grades"),
        (f"{float(result['reached_k_gamma']):.4f}", f"K_gamma in {p} of the trains with them"),
    ]


def _grades(result: xr.Dataset, names: Sequence[str]) -> Table:
    at = f"K_gamma at {percent(float(result.attrs['probability']))}"
    columns: dict[str, Any] = {
        "tolerance": names,
        "as drawn": texts(result, "drawn_grade"),
        "its price": list(result["drawn_grade_price"].values),
        "found": texts(result, "grade"),
        "price": list(result["price"].values),
    }
    reached, target = float(result["found_k_gamma"]), float(result["target"])
    lead = f"{at}: target {target:g}, {reached:.4f} with these grades, on {result.attrs['samples']} samples."
    return Table(title="The cheapest grades", columns=columns, lead=lead)


def _neighbours(result: xr.Dataset, names: Sequence[str]) -> Table:
    """What the next finer and the next coarser grade of every entry cost or save, and K_gamma with it."""
    columns: dict[str, Any] = {
        "tolerance": names,
        "next finer": texts(result, "finer_grade"),
        "costs": list(result["extra_cost"].values),
        "gives": [_factor(value) for value in result["finer_k_gamma"].values],
        "next coarser": texts(result, "coarser_grade"),
        "saves": list(result["saving"].values),
        "loses": [_factor(value) for value in result["coarser_k_gamma"].values],
    }
    at = percent(float(result.attrs["probability"]))
    lead = f"Gives, loses: K_gamma at {at} with this change alone."
    return Table(title="One grade finer or coarser", columns=columns, lead=lead)


def _factor(value: float) -> str:
    return f"{value:.4f}" if np.isfinite(value) else ""


def _totals(result: xr.Dataset) -> Table:
    at = f"K_gamma at {percent(float(result.attrs['probability']))}"
    low, high = (float(result[f"reached_k_gamma_{end}"]) for end in ("low", "high"))
    fresh = int(result.attrs["fresh_samples"])
    rows = {
        "total price": f"{float(result['total_price']):g}",
        "bound": f"{float(result['price_bound']):g}: {_PROOF[str(result.attrs['proof'])]}",
        f"{at}, fresh run of {fresh} samples": f"{float(result['reached_k_gamma']):.4f} [{low:.4f}, {high:.4f}]",
        f"{at}, as drawn": f"{float(result['drawn_k_gamma']):.4f}",
        "price as drawn": f"{float(result['drawn_price']):g}" if np.isfinite(result["drawn_price"]) else "not stated",
    }
    return Table(title="Totals", columns={"": list(rows), "value": list(rows.values())})
