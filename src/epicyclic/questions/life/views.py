"""`life`: lives of bearings and what they follow from, over load cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...results.dataset import largest
from ...show.elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table
from ...show.series import engineering, numbers, texts
from ...show.views import ResultView

if TYPE_CHECKING:
    import xarray as xr

_HOUR = 3600.0
_LIVES = {
    "basic": "L10 by ISO 281 [h]",
    "reference": "L10r by load zones [h]",
    "modified": "L10mr with the oil [h]",
}
_LOADS = {
    "bearing_load": ("equivalent load [kN]", 1e-3),
    "race_speed": ("speed [rpm]", 30 / np.pi),
    "turning_race": ("race that turns", None),
    "element_load": ("most loaded element [kN]", 1e-3),
    "element_pressure": ("pressure [MPa]", 1e-6),
    "load_zone_extent": ("loaded share", 1.0),
    "static_safety": ("static safety", 1.0),
    "bearing_stiffness": ("stiffness [N/µm]", 1e-6),
}
_FREQUENCIES = {
    "cage_frequency": "cage, in the housing [Hz]",
    "outer_race_frequency": "outer race [Hz]",
    "inner_race_frequency": "inner race [Hz]",
    "element_frequency": "element [Hz]",
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
    lead = "Lives that 90 % of such bearings reach. Moments count with two rows, thrust with a contact angle."
    return [
        Table(title="Life of rolling bearings", columns=columns, lead=lead, digits=4),
        Table(title="Loads of bearings", columns=_by_case(result, _LOADS), digits=4),
        Table(
            title="Frequencies of bearings",
            columns=_by_case(result, {name: (words, 1.0) for name, words in _FREQUENCIES.items()}),
        ),
    ]


def _most(result: xr.Dataset, place: int) -> str:
    """Case that takes most of the life of a bearing, with its share of the damage."""
    share = result["damage_share"].transpose("bearing", "case").values[place]
    at = largest(share)
    return f"{texts(result, 'case')[at]} {100 * share[at]:.3g} %" if share[at] > 0 else ""


def _by_case(result: xr.Dataset, rows: dict[str, tuple[str, float | None]]) -> dict[str, Any]:
    """Columns of variables (bearing, case), a row each."""
    cases, bearings = texts(result, "case"), texts(result, "bearing")
    columns: dict[str, Any] = {"bearing": [name for name in bearings for _ in cases]}
    if len(cases) > 1:
        columns["case"] = cases * len(bearings)
    for name, (heading, scale) in rows.items():
        values = result[name].max("element") if "element" in result[name].dims else result[name]
        flat = values.transpose("bearing", "case").values.ravel()
        columns[heading] = list(flat) if scale is None else list(scale * flat.astype(float))
    return columns


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
    """Which bearing lives shortest, and which case takes most of it."""
    name, place, hours = _shortest(result)
    if not np.isfinite(hours):
        return []
    text = f"{name} lives shortest of the bearings: L10r {engineering(hours)} h"
    if len(texts(result, "case")) > 1:
        text += f", most of its damage in {_most(result, place)}"
    return [Finding(tone="", text=f"{text}.", anchor="life")]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Load zones, and the tables."""
    from ...show.charts.train import load_zones

    parts: list[Part] = [Drawing(anchor="load-zones", figure=load_zones(result)), *tables(result)]
    return [Section(anchor="life", title="Life of bearings", parts=parts)]


VIEWS = (ResultView("life", 78, tables, sections, key_figures=key_figures, findings=findings),)
