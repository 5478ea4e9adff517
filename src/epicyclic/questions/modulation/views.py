"""`modulation`: vibration at a fixed place beside the ring, its lines by family and cause."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import ranked
from ...show.elements import SENSOR_UNITS, Company, Drawing, Section, Table, number
from ...show.views import ResultView

_SHOWN = 30


def tables(result: xr.Dataset) -> Sequence[Table]:
    """The strongest lines, then every family with its largest line and its part of the mean square."""
    unit, scale = SENSOR_UNITS[str(result.signal_amplitude.attrs["units"])]
    size = scale * np.abs(result.signal_amplitude.values)
    rank = ranked(size)
    carrier = float(result.attrs["carrier_frequency"])
    passing = f"planets pass at {number(result.sizes['planet'] * carrier)} Hz" if carrier else "no planet passes"
    where = f"Signal beside {result.attrs['sensor_body']}, {passing}"
    title = f"{where}: {min(_SHOWN, len(size))} of {len(size)} lines"
    lines = _lines(result, size, rank[:_SHOWN], title, (unit, scale))
    return [replace(lines, lead=_difference(result)), _families(result, size, rank, unit)]


def _difference(result: xr.Dataset) -> str:
    """How much the lines of a window differ from those of a sensor of the model; nothing without one."""
    if "window_difference" not in result.variables:
        return ""
    left, window = 100 * float(result["window_difference"]), json.loads(result.attrs["options"])["window"]
    return (
        f"Motion of the ring at the sensor. The mesh forces through the window {window}, scaled to fit, leave "
        f"{left:.3g} % of the RMS."
    )


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Signal over a turn of the carrier, and its lines."""
    from ...show.charts.over_time import modulation

    parts = [Drawing(anchor="modulation", figure=modulation(result), caption=_difference(result))]
    return [Section(anchor="modulation", title="Vibration at the ring", parts=parts)]


def _lines(result: xr.Dataset, size: Any, chosen: Any, title: str, shown: tuple[str, float]) -> Table:
    (unit, scale), largest, turns = shown, float(size.max(initial=0.0)), bool(result.attrs["carrier_frequency"])
    columns: dict[str, Any] = {
        "line": [str(result.line.values[i]) for i in chosen],
        "family": [str(result.family.values[i]) for i in chosen],
        "frequency [Hz]": list(result.line_frequency.values[chosen]),
        "per carrier": list(result.carrier_order.values[chosen]) if turns else [""] * len(chosen),
        "per mesh": list(result.mesh_order.values[chosen]),
        f"amplitude [{unit}]": list(size[chosen]),
        "[dB]": [f"{20 * np.log10(value / largest):.1f}" for value in size[chosen]],
        f"without deviations [{unit}]": list(scale * np.abs(result.fault_free_amplitude.values[chosen])),
    }
    if "window_amplitude" in result.variables:
        columns[f"by the window [{unit}]"] = list(scale * np.abs(result.window_amplitude.values[chosen]))
    return Table(title=title, columns=columns)


def _families(result: xr.Dataset, size: Any, rank: Any, unit: str) -> Table:
    family, causes = (result[name].values.astype(str) for name in ("family", "causes"))
    names, whole = list(dict.fromkeys(family[rank])), float((size**2).sum())
    columns: dict[str, Any] = {
        "family": names,
        "lines": [int((family == name).sum()) for name in names],
        f"largest [{unit}]": [float(size[family == name].max()) for name in names],
        "part of the mean square": [float((size[family == name] ** 2).sum() / whole) for name in names],
        "causes of the largest": [causes[rank[family[rank] == name][0]].replace("deviations.", "") for name in names],
    }
    return Table(title="Families", columns=columns)


VIEWS = (ResultView("modulation", 120, tables, sections),)
