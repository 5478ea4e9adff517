"""`transient`: motion in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import largest
from ...show.elements import (
    Company,
    Drawing,
    Finding,
    Part,
    Section,
    Table,
    error_tables,
    number,
    sensor_tables,
    torque_tables,
)
from ...show.series import engineering, of_first_stage, own_tones, short_names, texts
from ...show.views import ResultView

_NO_FORCE = 1e-6  # rounding of a train without load [N]
# The end of a run, for what it settles to.
_LAST = 0.2


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Forces over all steps of the run, when they are extreme, over its last fifth, and which meshes part."""
    force = result.mesh_force.transpose("mesh", "time").values
    time, frequency = result.time.values, result.mesh_frequency.values
    late = time >= time[-1] - _LAST * (time[-1] - time[0])
    whole = "mesh_force_peak_time" in result.variables
    with np.errstate(over="ignore", invalid="ignore"):  # of a motion that grows without bound
        mean, rms = force[:, late].mean(axis=1), force[:, late].std(axis=1)
        least = result.mesh_force_minimum.values if whole else force.min(axis=1)
        most = result.mesh_force_peak.values if whole else force.max(axis=1)
    at = result.mesh_force_peak_time.values if whole else time[force.argmax(axis=1)]
    # a result of an earlier version does not know that of every stage
    first = of_first_stage(result)
    of = first if "mesh_tone" not in result.variables else first and " of its stage"
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "least [N]": list(least),
        "most [N]": list(most),
        "at [s]": list(at),
        f"mesh frequency{of} there [Hz]": list(np.interp(at, time, frequency) * own_tones(result)),
        "mean, last fifth [N]": list(mean),
        "rms, last fifth [N]": list(rms),
        "contact lost": ["yes" if lost else "no" for lost in result.contact_lost.values],
    }
    if "impacts" in result and result.impacts.values.any():
        columns["apart, share of time"] = list(result.open_share.values)
        columns["on the far flank, share of time"] = list(result.far_share.values)
        columns["impacts"] = list(map(int, result.impacts.values))
    title = f"{number(float(time[-1]))} s, {len(time)} samples kept, status {result.status.item()}"
    words = "Least, most and contact over every step of the integration; the last fifth over the samples kept."
    if not whole:  # a result of an earlier version
        words = "Over the samples kept: between them forces may be larger."
    return [
        Table(title=f"Mesh forces along the tooth normal, {title}", columns=columns, lead=words),
        *torque_tables(result),
        *error_tables(result),
        *sensor_tables(result),
    ]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces over time, and over a speed ramp the spectrum of the one that swings most."""
    from ...show.charts.over_time import sensors, spectrogram, transient_forces
    from ...show.series import ramps

    words = "Samples kept; the table has what lies between them. Left and right drawn once where they coincide."
    parts: list[Part] = [Drawing(anchor="transient", figure=transient_forces(result), caption=words)]
    if ramps(result):
        words = "Dotted: multiples of the mesh frequency; where one is dark it passes a natural frequency."
        parts.append(Drawing(anchor="spectrogram", figure=spectrogram(result), caption=words))
    if "sensor" in result.dims:
        parts.append(Drawing(anchor="sensors", figure=sensors(result)))
    return [Section(anchor="transient", title="Motion over time", parts=[*parts, *tables(result)])]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The largest force and when, and how many meshes lose contact."""
    if "mesh_force_peak_time" not in result.variables:
        return []
    peak, names = result["mesh_force_peak"].values, short_names(texts(result, "mesh"))
    if not np.nanmax(peak, initial=0.0) > _NO_FORCE:
        return [Finding(tone="", text="No load presses the teeth.", anchor="transient")]
    at, lost = largest(peak), int(result["contact_lost"].values.sum())
    when = engineering(1e3 * float(result["mesh_force_peak_time"].values[at]))
    apart = f"{lost} of {len(names)} meshes lose contact" if lost else "no mesh loses contact"
    text = f"Largest force {engineering(float(peak[at]) / 1e3)} kN in {names[at]} after {when} ms; {apart}."
    return [Finding(tone="caution" if lost else "good", text=text, anchor="transient")]


VIEWS = (ResultView("transient", 130, tables, sections, findings=findings),)
