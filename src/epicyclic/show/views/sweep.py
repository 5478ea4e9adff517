"""`sweep`: steady vibration over speed with closed teeth: mesh forces, bearing forces, accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..elements import Company, Drawing, KeyFigure, Part, Section, Table, number
from ..figures.series import engineering, unbroken
from ..rows import largest_over_speed, loaded, status_table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ORDER", "key_figures", "sections", "tables"]

ORDER = 80


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Largest values over the speeds, and where: mesh forces [N], lateral bearing forces [N], accelerations [m/s2]."""
    frequency = result.mesh_frequency.values.ravel()
    title = f"Dynamic mesh forces, {len(frequency)} speeds, {number(frequency.min())} to {number(frequency.max())} Hz"
    meshes = largest_over_speed(result, "mesh", "mesh_force_rms", "largest rms [N]")
    meshes["largest force [N]"] = largest_over_speed(result, "mesh", "mesh_force_peak", "force")["force"]
    meshes |= largest_over_speed(result, "mesh", "dynamic_factor", "largest K_v", at="K_v at [Hz]")
    found = [Table(title=title, columns=meshes)]
    if "bearing_force_peak" in result:
        bearings = largest_over_speed(result, "bearing", "bearing_force_peak", "largest [N]")
        bearings["largest dynamic rms [N]"] = largest_over_speed(result, "bearing", "bearing_force_rms", "rms")["rms"]
        title = "Radial forces in bearings, supports and couplings"
        found.append(Table(title=title, columns=loaded(bearings, "largest [N]")))
    if "body_acceleration_rms" in result:
        bodies = largest_over_speed(result, "body", "body_acceleration_rms", "largest rms [m/s2]")
        title = "Accelerations of the bodies' centres"
        found.append(Table(title=title, columns=loaded(bodies, "largest rms [m/s2]")))
    return [*found, status_table(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces, their order spectrum and bearing forces over speed, natural frequencies of `modes` behind them."""
    from ..figures.bearing_forces import bearing_forces
    from ..figures.speed_sweep import speed_sweep
    from ..figures.waterfall import waterfall

    modes = company.get("modes")
    words = "Dotted: natural frequencies in the colour of their kind."
    parts: list[Part] = [Drawing(anchor="sweep", figure=speed_sweep(result, modes), caption=words)]
    if "mesh_force_order" in result.variables:
        words = (
            "The largest amplitude of all meshes; a resonance is where a line crosses a natural frequency and glows."
        )
        parts.append(Drawing(anchor="waterfall", figure=waterfall(result, modes), caption=words))
    if "bearing_force_peak" in result.variables:
        words = "Length of the lateral force of a link; links that carry the same share a curve."
        parts.append(Drawing(anchor="bearings", figure=bearing_forces(result, modes), caption=words))
    return [Section(anchor="sweep", title="Speed sweep", parts=parts)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The largest RMS of a mesh force [kN], which mesh, and at which mesh frequency [Hz]."""
    rms = result["mesh_force_rms"].transpose("mesh", "speed").values
    if not np.isfinite(rms).any():
        return []
    mesh, at = np.unravel_index(int(np.nanargmax(rms)), rms.shape)
    hertz = float(np.ravel(result["mesh_frequency"].values)[at]) if "mesh_frequency" in result.variables else np.nan
    words = f"largest RMS mesh force: {unbroken(str(result['mesh'].values[mesh]))}, {engineering(hertz)} Hz"
    return [(f"{engineering(float(rms[mesh, at]) / 1e3)} kN", words)]
