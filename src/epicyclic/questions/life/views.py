"""`life`: lives of bearings and what they follow from, over load cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import largest
from ...show.elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table
from ...show.part_tables import bearing_tables
from ...show.series import engineering, numbers, texts
from ...show.views import ResultView

_HOUR = 3600.0
_LIVES = {
    "basic": "L10 by ISO 281 [h]",
    "reference": "L10r by load zones [h]",
    "modified": "L10mr with the oil [h]",
}


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Lives [h] over all cases; loads of each case; frequencies of defects [Hz]."""
    bearings = texts(result, "bearing")
    columns: dict[str, Any] = {"bearing": bearings}
    for name, heading in _LIVES.items():
        columns[heading] = list(numbers(result, f"bearing_duty_life_{name}", "bearing") / _HOUR)
    if len(texts(result, "case")) > 1:
        columns["most damage in"] = [_most(result, place) for place in range(len(bearings))]
    columns["C [kN]"] = list(numbers(result, "bearing_rating", "bearing") / 1e3)
    columns["C_0 [kN]"] = list(numbers(result, "bearing_static_rating", "bearing") / 1e3)
    lead = (
        "Lives that 90 % of such bearings reach. Moments count with two rows, thrust with a contact angle or on balls."
    )
    lives = Table(title="Life of rolling bearings", columns=columns, lead=lead, digits=4)
    return [lives, *_changes(result), *bearing_tables(result)]


def _changes(result: xr.Dataset) -> list[Table]:
    """What every change that was tried makes of the shortest life [h]."""
    if "change_life" not in result:
        return []
    hours = numbers(result, "change_life", "change") / _HOUR
    columns: dict[str, Any] = {
        "change": texts(result, "change"),
        "shortest L10r [h]": list(hours),
        "times": list(hours / _shortest(result)[2]),
        "fails": texts(result, "change_reason", "change"),
    }
    return [Table(title="Changes, one at a time", columns=columns, digits=4)]


def _most(result: xr.Dataset, place: int) -> str:
    """Case that takes most of the life of a bearing, with its share of the damage."""
    share = result["damage_share"].transpose("bearing", "case").values[place]
    at = largest(share)
    return f"{texts(result, 'case')[at]} {100 * share[at]:.3g} %" if share[at] > 0 else ""


def _shortest(result: xr.Dataset) -> tuple[str, int, float]:
    """Bearing that lives shortest, its number, and its reference life [h]."""
    lives = numbers(result, "bearing_duty_life_reference", "bearing") / _HOUR
    place = largest(-lives)
    return texts(result, "bearing")[place], place, float(lives[place])


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Life of the bearing that lives shortest [h]."""
    name, _, hours = _shortest(result)
    return [(f"{engineering(hours)} h", f"life L10r of {name}, the shortest")] if np.isfinite(hours) else []


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Which bearing lives shortest, which case takes most of it, and which change that was tried helps most."""
    name, place, hours = _shortest(result)
    if not np.isfinite(hours):
        return []
    text = f"{name} lives shortest of the bearings: L10r {engineering(hours)} h"
    if len(texts(result, "case")) > 1:
        text += f", most of its damage in {_most(result, place)}"
    change = ""
    if "change_life" in result and np.isfinite(lives := numbers(result, "change_life", "change")).any():
        most = largest(np.nan_to_num(lives))
        change = f"{texts(result, 'change')[most]} makes it {engineering(lives[most] / _HOUR / hours)} times as long."
    return [Finding(tone="", text=f"{text}.", change=change, anchor="life")]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Load zones, and the tables."""
    from ...show.charts.train import load_zones

    parts: list[Part] = [Drawing(anchor="load-zones", figure=load_zones(result)), *tables(result)]
    return [Section(anchor="life", title="Life of bearings", parts=parts)]


VIEWS = (ResultView("life", 78, tables, sections, key_figures=key_figures, findings=findings),)
