"""`steady`: mesh and bearing forces of the periodic motion at one speed, with or without contact loss."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..elements import Company, Drawing, Section, Table
from ..tables import force_table, largest_heading, loaded

if TYPE_CHECKING:
    import xarray as xr

ORDER = 60


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Mesh forces, radial forces in bearings [N], shaft frequencies [Hz] with their largest amplitude [N]."""
    found = [force_table(result)]
    if "bearing_force_peak" in result:
        heading = largest_heading(result)
        bearings: dict[str, Any] = {
            "bearing": list(map(str, result.bearing.values)),
            "mean [N]": list(result.bearing_force_mean.values),
            "dynamic rms [N]": list(result.bearing_force_rms.values),
            heading: list(result.bearing_force_peak.values),
        }
        title = "Radial forces in bearings, supports and couplings"
        found.append(Table(title=title, columns=loaded(bearings, heading)))
    if result.sizes.get("line"):
        columns: dict[str, Any] = {
            "cause": list(map(str, result.line.values)),
            "frequency [Hz]": list(result.line_frequency.values),
            "largest amplitude of a mesh force [N]": list(result.line_amplitude.max("mesh").values),
        }
        found.append(Table(title="Shaft frequencies", columns=columns))
    return found


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces over the mesh cycle; with contact loss also their range over all shaft phases."""
    from ..charts.over_time import force_envelopes, mesh_forces

    parts = []
    if "mesh_force" in result.variables:
        parts.append(Drawing(anchor="steady-forces", figure=mesh_forces(result)))
        if "mesh_force_most" in result.variables:
            parts.append(Drawing(anchor="steady-range", figure=force_envelopes(result)))
    return [Section(anchor="steady", title="Steady response", parts=parts)]
