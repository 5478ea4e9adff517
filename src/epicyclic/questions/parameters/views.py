"""`track`: natural frequencies along a number of the model file, crossings and veerings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...show.elements import Company, Drawing, Section, Table
from ...show.views import ResultView

if TYPE_CHECKING:
    import xarray as xr


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Where loci meet, and the frequencies at a few values."""
    options = json.loads(str(result.attrs["options"]))
    over = f"{options['over']} [{options['unit']}]" if options["unit"] else options["over"]
    veers = result.event_kind.values == "veering"
    events: dict[str, Any] = {
        "what": list(map(str, result.event_kind.values)),
        "at": list(result.event_value.values),
        "frequency [Hz]": list(result.event_frequency.values),
        "modes": list(map(str, result.event_first.values)),
        "and modes": list(map(str, result.event_second.values)),
        "gap [Hz]": list(np.where(veers, result.event_gap.values, np.nan)),
        "coupling factor": list(np.where(veers, result.coupling_factor.values, 0.0)),
        "veering index": list(np.where(veers, result.veering_index.values, 0.0)),
    }
    values = result.parameter.values
    picked = np.unique(np.linspace(0, values.size - 1, 5).round().astype(int))
    columns: dict[str, Any] = {
        "mode": list(map(int, result.mode.values)),
        "kind": list(map(str, result.mode_kind.values)),
        "multiplicity": list(map(int, result.multiplicity.values)),
    }
    frequency = result.frequency.transpose("mode", "parameter").values
    for at in picked:
        columns[f"at {values[at]:.4g} [Hz]"] = list(frequency[:, at])
    met = [Table(title=f"Where modes meet along {over}", columns=events)] if result.sizes.get("event") else []
    return [*met, Table(title=f"Natural frequencies over {over}, modes followed from the first value", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The loci with their crossings and veerings."""
    from ...show.charts.modes import loci

    words = "Thick: double roots. Shapes that share nothing cross; coupled ones veer and exchange their motion."
    parts = [Drawing(anchor="track", figure=loci(result), caption=words)]
    return [Section(anchor="track", title="Modes followed", parts=parts)]


VIEWS = (ResultView("track", 100, tables, sections),)
