"""`transient`: motion in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Section, Table, number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ORDER", "sections", "tables"]

ORDER = 130

# The end of a run, for what it settles to.
_LAST = 0.2


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Forces over the run and over its last fifth, when they are largest, and which meshes part."""
    force = result.mesh_force.transpose("mesh", "time").values
    time, frequency = result.time.values, result.mesh_frequency.values
    late = time >= time[-1] - _LAST * (time[-1] - time[0])
    most = [int(np.nanargmax(row)) if np.isfinite(row).any() else 0 for row in force]
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "least [N]": list(np.nanmin(force, axis=1)),
        "most [N]": list(np.nanmax(force, axis=1)),
        "at [s]": [float(time[at]) for at in most],
        "mesh frequency there [Hz]": [float(frequency[at]) for at in most],
        "mean, last fifth [N]": list(force[:, late].mean(axis=1)),
        "rms, last fifth [N]": list(force[:, late].std(axis=1)),
        "contact lost": ["yes" if lost else "no" for lost in result.contact_lost.values],
    }
    title = f"{number(float(time[-1]))} s, {len(time)} instants, status {result.status.item()}"
    return [Table(title=f"Mesh forces along the tooth normal, {title}", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces over time, and over a speed ramp the spectrum of the one that swings most."""
    from ..figures.spectrogram import spectrogram
    from ..figures.summaries import ramps
    from ..figures.transient_forces import transient_forces

    words = "Left and right drawn once where they coincide."
    parts = [Drawing(anchor="transient", figure=transient_forces(result), caption=words)]
    if ramps(result):
        words = "Dotted: multiples of the mesh frequency; where one is dark it passes a natural frequency."
        parts.append(Drawing(anchor="spectrogram", figure=spectrogram(result), caption=words))
    return [Section(anchor="transient", title="Motion over time", parts=parts)]
