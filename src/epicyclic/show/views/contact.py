"""`contact`: loaded tooth contact of one mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Finding, Section, Table, number

if TYPE_CHECKING:
    import xarray as xr

ORDER = 140


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Both helices at the operating load, stress in the tooth roots there, then all loads."""
    return [_sides(result), *_roots(result), _loads(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Load over the flank; transmission error over mesh cycle and load, and stiffness."""
    from ..charts.flanks import contact_curves, contact_map, root_stress

    parts = [
        Drawing(anchor="flanks", figure=contact_map(result), caption=_which(result)),
        Drawing(anchor="contact", figure=contact_curves(result)),
    ]
    if "root_stress" in result:
        parts.append(Drawing(anchor="roots", figure=root_stress(result)))
    return [Section(anchor="contact", title="Teeth in contact", parts=parts)]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Whether tip edges bear at the operating load, and the face-load factor there."""
    at = result.isel(mesh_load=int(np.argmin(np.abs(result.mesh_load.values - float(result.attrs["force"])))))
    overlap, mesh = float(np.nanmax(at.corner_overlap.values, initial=0.0)), result.attrs["mesh"]
    pressure = f"largest pressure {float(np.nanmax(at.largest_pressure.values)) / 1e6:.0f} MPa"
    face = f"K_H beta {float(np.nanmax(at.face_factor.values)):.2f}"
    if overlap <= 0:
        return [Finding(tone="good", text=f"No tip edge bears in {mesh}; {pressure}, {face}.", anchor="contact")]
    text = (
        f"A tip edge bears in {mesh}: tips overlap by {1e6 * overlap:.1f} µm at the operating load; {pressure}, {face}."
    )
    change = (
        "Relieve the tips by about that much: epicyclic relief searches the relief. "
        'Dynamic forces count it where the mesh has stiffness = "contact".'
    )
    return [Finding(tone="caution", text=text, change=change, anchor="contact")]


def _which(result: xr.Dataset) -> str:
    """Which mesh is shown, and how others are."""
    return (
        f"One mesh of the train, {result.attrs['mesh']}. Others: epicyclic contact MODEL --mesh PAIR, "
        f"for instance planet-ring or {str(result.attrs['mesh']).split('/')[0]}/planet-ring/1."
    )


def _sides(result: xr.Dataset) -> Table:
    force = float(result.attrs["force"])
    now = int(np.argmin(np.abs(result.mesh_load.values - force)))
    at = result.isel(mesh_load=now)
    title = (
        f"Mesh {result.attrs['mesh']}, {number(force)} N a helix, {number(float(at.load_torque))} N m on its first gear"
    )
    columns: dict[str, Any] = {
        "side": [str(side) for side in result.side.values],
        "shared face [mm]": list(result.shared_face.values * 1e3),
        "largest load [N/mm]": list(at.largest_load_per_length.values / 1e3),
        "largest pressure [MPa]": list(at.largest_pressure.values / 1e6),
        "largest over mean across the face": list(at.face_factor.values),
        "stiffness, tangent [N/µm]": list(at.average_stiffness.values / 1e6),
        "stiffness, secant [N/µm]": list(at.average_secant_stiffness.values / 1e6),
        "tip overlap before [µm]": list(at.corner_overlap.sel(end="before").values * 1e6),
        "tip overlap behind [µm]": list(at.corner_overlap.sel(end="behind").values * 1e6),
    }
    return Table(title=title, columns=columns, lead=_resolution(result))


def _roots(result: xr.Dataset) -> list[Table]:
    """Largest stresses in the roots of both gears at the operating load; of a result without them nothing."""
    if "root_stress" not in result:
        return []
    at = result.isel(mesh_load=int(np.argmin(np.abs(result.mesh_load.values - float(result.attrs["force"])))))
    rows = [(i, j) for i in range(result.sizes["side"]) for j in range(result.sizes["mesh_gear"])]
    stress = result.root_stress.max("width").values
    columns: dict[str, Any] = {
        "side": [str(result.side.values[i]) for i, _ in rows],
        "gear": [str(result.attrs[f"gear_{result.mesh_gear.values[j]}"]) for _, j in rows],
        "tension [MPa]": [float(at.largest_root_stress.values[row]) / 1e6 for row in rows],
        "at a place of its contact [base pitches]": [
            float(result.tooth_place.values[int(stress[row].argmax())]) for row in rows
        ],
        "at a lean of the fillet of [deg]": [float(np.degrees(result.root_stress_lean.values[row])) for row in rows],
        "compression [MPa]": [float(at.lowest_root_stress.values[row]) / 1e6 for row in rows],
    }
    return [Table(title="Stress in the tooth roots", columns=columns)]


def _resolution(result: xr.Dataset) -> str:
    """Phases and slices, and the error they leave; empty of a result of an earlier version."""
    attrs = result.attrs
    if "averaging_length" not in attrs:
        return ""
    error = float(attrs["estimated_error"])
    left = "" if np.isnan(error) else f", estimated error {100 * error:.2g} %"
    return (
        f"{attrs['samples']} phases and {attrs['slices']} slices{left}; loads and pressures are means over "
        f"{1e3 * float(attrs['averaging_length']):.3g} mm of contact line.{_errors(result)}"
    )


def _errors(result: xr.Dataset) -> str:
    """Pitch and profile errors, and the mesh cycle they are shown in; empty without them."""
    attrs = result.attrs
    if "cycle" not in attrs:
        return ""
    parts = [f"pitch error {1e6 * float(attrs['pitch_error']):.4g} µm"] if attrs["pitch_error"] else []
    if attrs["profile_error"]:
        phase = np.degrees(float(attrs["profile_phase"]))
        parts.append(f"profile error {1e6 * float(attrs['profile_error']):.4g} µm at {phase:.4g} deg")
    parts += ["deviations of the file"] if attrs["deviations"] else []
    return f" With {', '.join(parts)}; the mesh cycle begins at {float(attrs['cycle']):.4g}."


def _loads(result: xr.Dataset) -> Table:
    error = result.transmission_error_harmonic.values
    columns: dict[str, Any] = {
        "force of a helix [N]": list(result.mesh_load.values),
        "torque [N m]": list(result.load_torque.values),
        "mean error [µm]": list(error[:, 0].real * 1e6),
        "peak to peak [µm]": list(result.transmission_error_peak_to_peak.values * 1e6),
        **{f"order {k} [µm]": list(np.abs(error[:, k]) * 1e6) for k in (1, 2, 3)},
        "stiffness, tangent [N/µm]": list(result.average_stiffness.values.mean(axis=0) / 1e6),
        "largest load [N/mm]": list(result.largest_load_per_length.values.max(axis=0) / 1e3),
        "largest pressure [MPa]": list(result.largest_pressure.values.max(axis=0) / 1e6),
    }
    return Table(title="Loaded transmission error", columns=columns)
