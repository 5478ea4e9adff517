"""`output`: stiffness and lost motion of a gearbox at one of its shafts, torque over angle, inertia of every shaft."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...show.elements import Company, Drawing, Finding, KeyFigure, Section, Table, columns_of
from ...show.series import ARCMIN, engineering, texts
from ...show.views import ResultView

_ORDERS = 6  # of the kinematic error, in the table
_NONE = 1e-9  # arcmin, N m/arcmin or J that is rounding
_ROWS = {
    "shaft_secant_stiffness": ("torsional stiffness, secant 50 to 100 %", "N m/arcmin", 1 / ARCMIN),
    "shaft_fitted_stiffness": ("torsional stiffness, least squares 50 to 100 %", "N m/arcmin", 1 / ARCMIN),
    "lost_motion": ("lost motion", "arcmin", ARCMIN),
    "shaft_backlash": ("backlash", "arcmin", ARCMIN),
    "shaft_play": ("play", "arcmin", ARCMIN),
    "kinematic_error_peak_to_peak": ("kinematic error, peak to peak", "arcmin", ARCMIN),
    "hysteresis_energy": ("energy of a cycle", "J", 1.0),
}
_OF_SHAFTS = {
    "reflected_inertia": ("reflected inertia [kg m^2]", 1.0),
    "starting_torque": ("starting torque, teeth under load [N m]", 1.0),
}


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Stiffness [N m/arcmin], lost motion and backlash [arcmin], energy of a cycle [J]; inertia of the shafts."""
    rows, attrs = [name for name in _ROWS if name in result.variables], result.attrs
    columns: dict[str, Any] = {"": [_ROWS[name][0] for name in rows], "unit": [_ROWS[name][1] for name in rows]}
    columns |= {one: [_value(result, name, one) for name in rows] for one in texts(result, "over_phases")}
    lost, play = (100 * json.loads(attrs["options"])[name] for name in ("share", "backlash_share"))
    rated = f"rated torque {engineering(float(result.rated_torque))} N m"
    lead = f"Stiffness in the sense of the rated torque, {attrs['rated_sense']}. "
    lead += f"Lost motion at {lost:.3g} %, backlash at {play:.3g} % of the rated torque, in both senses. "
    lead += "Friction of the teeth is not in it."
    lead += " No rated torque is given: it is the torque of operation." if attrs["rated_by"] == "operation" else ""
    reasons = {what: attrs[f"{what.replace(' ', '_')}_reason"] for what in ("starting torque", "kinematic error")}
    missing = " ".join(f"No {what}: {reason}." for what, reason in reasons.items() if reason)
    title = f"At {attrs['shaft']}, locked {attrs['locked_shafts']}; {rated}"
    return [
        Table(title=title, columns=columns, lead=lead),
        *_distribution(result),
        *_orders(result),
        Table(title="Seen from every shaft", columns=columns_of(result, "port", _OF_SHAFTS), lead=missing),
    ]


def _distribution(result: xr.Dataset) -> list[Table]:
    """Numbers over the trains that the tolerances of the drawing allow."""
    known = {name.removesuffix("_peak_to_peak"): row for name, row in _ROWS.items()}
    rows = {name: row for name, row in known.items() if f"{name}_mean" in result.variables}
    columns: dict[str, Any] = {"": [row[0] for row in rows.values()], "unit": [row[1] for row in rows.values()]}
    columns["mean"] = [row[2] * float(result[f"{name}_mean"]) for name, row in rows.items()]
    for part in result.probability.values:
        quantiles = {name: float(result[f"{name}_quantile"].sel(probability=part)) for name in rows}
        columns[f"{100 * part:.3g} % at most"] = [row[2] * quantiles[name] for name, row in rows.items()]
    words = "The tolerances take the place of the deviations of the file."
    words += " Kinematic error: of 64 trains." if "kinematic_error" in rows else ""
    return [Table(title="Over the trains that the tolerances allow", columns=columns, lead=words)] if rows else []


def _orders(result: xr.Dataset) -> list[Table]:
    """Largest orders of the kinematic error [arcmin] and their causes."""
    if not result.sizes.get("shaft_order"):
        return []
    largest = result.isel(shaft_order=np.argsort(-result.kinematic_error_order.values, kind="stable")[:_ORDERS])
    columns: dict[str, Any] = {
        "order of the shaft": list(largest.shaft_order.values),
        "amplitude [arcmin]": list(ARCMIN * largest.kinematic_error_order.values),
        "cause": texts(largest, "shaft_order_cause"),
    }
    return [Table(title="Kinematic error, largest orders", columns=columns)]


def _value(result: xr.Dataset, name: str, of: str) -> float:
    """Number of a row in its unit."""
    values = result[name]
    if "over_phases" in values.dims:
        values = values.sel(over_phases=of)
    elif of != "mean":
        return np.nan
    value = _ROWS[name][2] * float(values)
    return value if not abs(value) < _NONE else 0.0


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Torsional stiffness [N m/arcmin] and lost motion [arcmin]."""
    mean = result.sel(over_phases="mean")
    lost = float(mean.lost_motion) * ARCMIN
    stiffness = f"{engineering(float(mean.shaft_secant_stiffness) / ARCMIN)} N m/arcmin"
    figures = [(stiffness, f"torsional stiffness at {result.attrs['shaft']}")]
    return figures if np.isnan(lost) else [*figures, (f"{engineering(lost)} arcmin", "lost motion")]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Torque over angle, and the tables."""
    from ...show.charts.train import kinematic_error, torque_over_angle

    drawings = [Drawing(anchor="torque-angle", figure=torque_over_angle(result))]
    if "kinematic_error" in result.variables:
        drawings.append(Drawing(anchor="kinematic-error", figure=kinematic_error(result)))
    return [Section(anchor="output", title="Output", parts=[*drawings, *tables(result)])]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Lost motion and stiffness: plain numbers, as nothing limits them."""
    text = ", ".join(f"{what} {value}" for value, what in key_figures(result))
    return [Finding(tone="", text=f"{text[:1].upper()}{text[1:]}.", anchor="output")]


VIEWS = (ResultView("output", 55, tables, sections, key_figures=key_figures, findings=findings),)
