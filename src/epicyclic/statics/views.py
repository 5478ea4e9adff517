"""`static`: mesh forces at rest, what links carry across and along the axis, and what twists under a torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..show.elements import Company, Drawing, KeyFigure, Section, Table, error_tables, force_table, sensor_tables
from ..show.part_tables import bearing_tables, deflection_tables, deflections
from ..show.series import ARCMIN, engineering, numbers, texts
from ..show.views import ResultView

if TYPE_CHECKING:
    import xarray as xr


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Mesh forces [N]; forces of the links [N]; torque [N m] and twist [µrad] of those that carry a torque."""
    force = result.link_force.transpose("link_row", "time").values
    twist = result.link_deflection.transpose("link_row", "time").values
    largest = float(np.abs(force).max(initial=0.0))
    rows = [i for i, name in enumerate(result.link_row.values) if str(name).endswith("/rz")]
    # a torque below 1e-9 of the largest force is rounding
    torsion = [i for i in rows if np.abs(force[i]).max() > 1e-9 * largest]
    columns: dict[str, Any] = {
        "link": [str(result.link_row.values[i]).removesuffix("/rz") for i in torsion],
        "mean torque [N m]": [float(force[i].mean()) for i in torsion],
        "mean twist [µrad]": [float(twist[i].mean()) * 1e6 for i in torsion],
        "most [µrad]": [float(np.abs(twist[i]).max()) * 1e6 for i in torsion],
    }
    title = "Torsion of supports, necks, shafts and couplings"
    twisted = [Table(title=title, columns=columns)] if torsion else []
    first = [*_angles(result), force_table(result), *error_tables(result), *sensor_tables(result)]
    return [*first, *_link_forces(result), *twisted, *deflection_tables(result), *bearing_tables(result)]


def _stiffness(result: xr.Dataset) -> NDArray[np.float64]:
    """Torsional stiffness (body,) [N m/rad] of a locked train: torque per angle beyond the play; nan without."""
    torque, angle = result["torque"].values, result["angle"].mean("time").values
    elastic = angle - np.sign(torque) * (result["play"].values / 2 if "play" in result.variables else 0.0)
    loaded = (torque != 0) & (elastic != 0)
    return np.asarray(np.divide(torque, elastic, where=loaded, out=np.full(torque.shape, np.nan)))


def _angles(result: xr.Dataset) -> list[Table]:
    """Angle and play [arcmin] of the bodies of a locked train, and stiffness [N m/arcmin] of those that are loaded."""
    if "angle" not in result.variables:
        return []
    columns: dict[str, Any] = {
        "body": texts(result, "body"),
        "torque [N m]": list(result["torque"].values),
        "mean angle [arcmin]": list(ARCMIN * result["angle"].mean("time").values),
        "play [arcmin]": list(ARCMIN * numbers(result, "play", "body")),
        "stiffness [N m/arcmin]": list(_stiffness(result) / ARCMIN),
    }
    zero = "mid-backlash, so that half of the play is in them" if "play" in result.variables else "first touch"
    lead = "The stiffness is a secant, the torque per angle beyond the play; errors that close flanks in turn lower it."
    return [Table(title=f"Locked train: angles from {zero}", columns=columns, lead=lead)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Torsional stiffness [N m/arcmin] and play [arcmin] of a locked train at the bodies that are loaded."""
    if "angle" not in result.variables:
        return []
    found: list[KeyFigure] = []
    for place in np.flatnonzero(result["torque"].values):
        name, stiffness = str(result["body"].values[place]), _stiffness(result)[place] / ARCMIN
        found.append((f"{engineering(stiffness)} N m/arcmin", f"torsional stiffness at {name}"))
        if "play" in result.variables:
            found.append((f"{engineering(ARCMIN * result['play'].values[place])} arcmin", f"play at {name}"))
    return found


def _link_forces(result: xr.Dataset) -> list[Table]:
    """Forces of every link that carries one, across the axis and, where any holds it, along the axis [N]."""
    force = dict(zip(result.link_row.values, result.link_force.transpose("link_row", "time").values, strict=True))
    if "group_row" in result.dims:
        force |= dict(zip(result.group_row.values, result.group_row_force.values, strict=True))
    links = dict.fromkeys(str(name).rsplit("/", 1)[0] for name in force if str(name).endswith(("/x", "/y", "/z")))
    still = np.zeros(result.sizes["time"])
    parts = {link: [np.asarray(force.get(f"{link}/{axis}", still)) for axis in "xyz"] for link in links}
    least = 1e-9 * max((np.abs(part).max() for part in parts.values()), default=0.0)  # rounding
    parts = {link: part for link, part in parts.items() if np.abs(part).max() > least}
    across = [np.hypot(x, y) for x, y, _ in parts.values()]
    columns: dict[str, Any] = {
        "link": list(parts),
        "mean across [N]": [float(one.mean()) for one in across],
        "most across [N]": [float(one.max()) for one in across],
    }
    if any(np.abs(z).max() > least for _, _, z in parts.values()):
        columns["mean along z [N]"] = [float(z.mean()) for _, _, z in parts.values()]
        columns["most along z [N]"] = [float(np.abs(z).max()) for _, _, z in parts.values()]
    return [Table(title="Forces of supports, bearings and couplings", columns=columns)] if parts else []


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Angles of a locked train; mesh forces over the record."""
    from ..show.charts.over_time import mesh_forces, sensors, transmission_errors
    from ..show.charts.train import load_zones, ring_deflections

    parts = [Drawing(anchor="static-forces", figure=mesh_forces(result))] if "mesh_force" in result.variables else []
    if "transmission_error_rotation" in result.variables:
        parts.append(Drawing(anchor="static-errors", figure=transmission_errors(result)))
    if "sensor" in result.dims:
        parts.append(Drawing(anchor="sensors", figure=sensors(result)))
    tables = [*deflection_tables(result), *bearing_tables(result)]
    if deflections(result):
        caption = "Line: mean; band: over the record; dotted: the meshes. Beside the mean motion of the ring."
        drawn = ring_deflections(result, company.get("check"))
        parts.append(Drawing(anchor="ring-bending", figure=drawn, caption=caption))
    if "element_load" in result:
        parts.append(Drawing(anchor="load-zones", figure=load_zones(result)))
    return [Section(anchor="static", title="Static forces", parts=[*_angles(result), *parts, *tables])]


VIEWS = (ResultView("static", 50, tables, sections, key_figures=key_figures),)
