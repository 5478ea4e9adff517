"""`stability`: Floquet multipliers over speed, and over a second parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import ranked
from ...show.elements import Company, Drawing, Section, Table, named_columns, number, status_table
from ...show.series import equal_runs, stability_verdict
from ...show.views import ResultView

_SHOWN = 30


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Ranges of speed in which vibration grows, as found and as averaging predicts them."""
    frequency = result.mesh_frequency.values
    title = f"{len(frequency)} speeds, {number(frequency.min())} to {number(frequency.max())} Hz"
    if "value" in result.dims:
        return [_values(result, title), status_table(result)]
    rows = _ranges(result)
    headings = ("from [Hz]", "to [Hz]", "speeds", "kind", "largest |mu|", "fastest growth [1/s]", "taking part")
    columns, kind = named_columns(headings, rows), result.instability.values.astype(str)
    if not rows:
        columns = {
            "from [Hz]": [float(frequency.min())],
            "to [Hz]": [float(frequency.max())],
            "speeds": [int(np.sum(kind != ""))],
            "largest |mu|": [_largest(result.largest_multiplier.values)],
            "growth rate [1/s]": [_largest(result.growth_rate.values)],
        }
    return [Table(title=stability_verdict(kind, "speeds"), columns=columns), *_predicted(result), status_table(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Growth rates as found, boundaries as averaging predicts them."""
    from ...show.charts.speed_maps import stability_map, stability_over_speed

    drawn = stability_map(result) if "value" in result.dims else stability_over_speed(result)
    return [Section(anchor="stability", title="Stability", parts=[Drawing(anchor="stability", figure=drawn)])]


def _ranges(result: xr.Dataset) -> list[tuple[Any, ...]]:
    """Runs of unstable speeds of one kind."""
    frequency, kind = result.mesh_frequency.values, result.instability.values.astype(str)
    size, rate, taking = result.largest_multiplier.values, result.growth_rate.values, result.taking_part.values
    unstable = ~np.isin(kind, ("", "stable"))
    rows = []
    for run in equal_runs(kind):
        if unstable[run[0]]:
            words = ", ".join(dict.fromkeys(str(text) for text in taking[run] if text))
            ends, most = frequency[run[[0, -1]]].tolist(), (float(size[run].max()), float(rate[run].max()))
            rows.append((*ends, len(run), str(kind[run[0]]), *most, words))
    return rows


def _predicted(result: xr.Dataset) -> list[Table]:
    """Boundaries by averaging, the fastest first."""
    rate = result.resonance_growth.values
    order = ranked(rate)[:_SHOWN]
    columns = {
        "combination": [str(name) for name in result.resonance.values[order]],
        "from [Hz]": list(result.resonance_low.values[order]),
        "to [Hz]": list(result.resonance_high.values[order]),
        "fastest growth [1/s]": list(rate[order]),
        "opens at a variation of": [f"{value:.3g} times" for value in result.resonance_threshold.values[order]],
    }
    more = f", {_SHOWN} of {len(rate)}" if len(rate) > _SHOWN else ""
    return [Table(title=f"Predicted to first order (averaging){more}", columns=columns)] if len(rate) else []


def _values(result: xr.Dataset, title: str) -> Table:
    kind = result.instability.transpose("value", "speed").values.astype(str)
    unstable = ~np.isin(kind, ("", "stable"))
    rate = result.growth_rate.transpose("value", "speed").values
    unit = str(result.value.attrs.get("units", ""))
    name = str(result.attrs.get("over", "value"))
    low, high = result.resonance_low.values, result.resonance_high.values
    columns: dict[str, Any] = {
        f"{name} [{unit}]" if unit else name: list(result.value.values),
        "unstable speeds": [int(row.sum()) for row in unstable],
        "speeds judged": [int(row.sum()) for row in kind != ""],
        "fastest growth [1/s]": [_largest(row) for row in rate],
        "at mesh frequency [Hz]": [_where(row, result.mesh_frequency.values) for row in rate],
        "predicted ranges": [int(np.isfinite(row).sum()) for row in high - low],
    }
    return Table(title=f"Stability over {name}, {title}", columns=columns)


def _largest(values: Any) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else float("nan")


def _where(values: Any, frequency: Any) -> float:
    return float(frequency[np.nanargmax(values)]) if np.isfinite(values).any() else float("nan")


VIEWS = (ResultView("stability", 115, tables, sections),)
