"""Results: labelled Datasets with units, long names and provenance; saved to and reopened from netCDF.

One table says what every variable means; analyses only hand over arrays.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .errors import ModelError

__all__ = ["VARIABLES", "dataset", "load_result", "save_result", "to_json"]

# name: (unit, long name)
VARIABLES: dict[str, tuple[str, str]] = {
    # check
    "speed": ("rpm", "absolute speed, counter-clockwise positive"),
    "torque": ("N m", "external torque, counter-clockwise positive"),
    "power": ("W", "external power, into the train positive"),
    "speed_ratio": ("1", "speed per speed of the first free member"),
    "mesh_frequency": ("Hz", "mesh frequency"),
    "hunting_period": ("1", "mesh cycles after which the same teeth meet in all meshes"),
    "phase_lead": ("1", "phase lead of the contact, mesh cycles"),
    "base_radius": ("m", "base circle radius"),
    "working_radius": ("m", "working pitch radius of the first gear of the mesh"),
    "tip_radius": ("m", "tip circle radius"),
    "root_radius": ("m", "root circle radius"),
    "working_pressure_angle": ("rad", "working transverse pressure angle"),
    "centre_distance": ("m", "centre distance"),
    "contact_ratio": ("1", "transverse contact ratio"),
    "overlap_ratio": ("1", "overlap ratio"),
    "mass": ("kg", "mass"),
    "inertia": ("kg m2", "moment of inertia about the axis"),
    "tilt_inertia": ("kg m2", "moment of inertia about a diameter"),
    "branch_angle": ("rad", "polar angle of the branch"),
    # check: what the train is made of (texts "" and numbers nan where there is none)
    "kind": ("", "kind of body: sun, planet, ring, carrier, gear, body"),
    "member": ("", "what the model file calls the body"),
    "body_stage": ("", "frame the body's coordinates are written in: its stage, or housing"),
    "branch": ("1", "branch, 0 for a central body"),
    "side": ("", "left, right, or nothing"),
    "carried_by": ("", "body that carries it"),
    "centre_x": ("m", "centre along the stage's x axis"),
    "centre_y": ("m", "centre along the stage's y axis"),
    "station": ("m", "axial place of the centre"),
    "axes_angle": ("rad", "polar angle of the body's own x axis"),
    "outer_radius": ("m", "outer radius as drawn"),
    "teeth": ("1", "number of teeth"),
    "internal": ("", "whether the teeth are inside"),
    "reference_radius": ("m", "reference circle radius"),
    "face_width": ("m", "face width of one helix"),
    "gap": ("m", "gap between the helices"),
    "herringbone": ("", "whether the body carries both helices"),
    "helix_angle": ("rad", "helix angle at the reference circle"),
    "hand": ("1", "hand of the (left) helix, 1 right, -1 left, 0 spur"),
    "profile_shift": ("1", "profile shift coefficient"),
    "module": ("m", "normal module"),
    "pressure_angle": ("rad", "normal pressure angle"),
    "flank": ("1", "loaded flank, 1 where the first gear pushes the second counter-clockwise"),
    "gear_a": ("", "first gear of the mesh"),
    "gear_b": ("", "second gear of the mesh"),
    "mesh_stage": ("", "stage of the mesh"),
    "mesh_branch": ("1", "branch of the mesh, 0 for none"),
    "mesh_side": ("", "helix side of the mesh"),
    "mesh_pair": ("", "table of the mesh in the model file"),
    "mesh_station": ("m", "axial place of mid-face"),
    "mesh_direction": ("rad", "polar angle from the first gear's centre to the pitch point"),
    "planets": ("1", "number of branches"),
    "link_first": ("", "first body of the link"),
    "link_second": ("", "second body of the link, nothing for the frame or housing"),
    "link_stiffness": ("N/m, N m/rad for rx ry rz", "stiffness of the link, infinite where rigid"),
    "order_frequency": ("Hz", "shaft and mesh frequencies"),
    "order": ("1", "frequency in orders of the mesh frequency"),
    # modes
    "frequency": ("Hz", "natural frequency"),
    "angular_frequency": ("rad/s", "natural angular frequency"),
    "mode_kind": ("", "kind of mode"),
    "multiplicity": ("1", "number of modes at this frequency"),
    "shape": ("m", "mode shape, torsion as base-circle displacement, largest component 1"),
    "full_shape": ("m", "mode shape of all six coordinates of every body, torsion as base-circle displacement"),
    "strain_energy_share": ("1", "share of the strain energy"),
    "kinetic_energy_share": ("1", "share of the kinetic energy"),
    "damping_ratio": ("1", "damping ratio"),
    "whirl_frequency": ("Hz", "natural frequency with gyroscopic terms at each speed"),
    # stiffness
    "mesh_stiffness": ("N/m", "mesh stiffness along the tooth normal"),
    "mean_mesh_stiffness": ("N/m", "mean mesh stiffness along the tooth normal"),
    # sharing
    "load_sharing": ("1", "load-sharing coefficient of each mesh"),
    "load_sharing_history": ("1", "simultaneous load-sharing ratio"),
    "system_load_sharing": ("1", "load-sharing coefficient of the train"),
    "mesh_force": ("N", "mesh force along the tooth normal, pressing positive"),
    "mesh_force_bound": ("N", "largest mesh force over all shaft phases"),
    "contact_lost": ("", "whether the mesh force falls to zero or below"),
    "displacement": ("m", "displacement, torsion as base-circle displacement"),
    "mesh_contact": ("", "whether the teeth touch"),
    "group_force": ("N", "force in a bearing or spline with a law"),
    "group_stretch": ("m", "displacement in a bearing or spline with a law"),
    "group_state": ("", "what a bearing or spline does: play, stick, slip, stop"),
    "link_force": ("N", "force or moment in a bearing, support or coupling"),
    # steady
    "mesh_phase": ("1", "time in mesh cycles"),
    "harmonic": ("1", "mesh order"),
    "mesh_force_harmonic": ("N", "complex harmonics of the mesh force, one-sided"),
    "displacement_harmonic": ("m", "complex harmonics of the displacement, one-sided"),
    "line_frequency": ("Hz", "frequency of the line"),
    "line_force": ("N", "complex envelope of the mesh force of the line over the mesh phase"),
    "line_amplitude": ("N", "largest mesh force of the line"),
    # sweep
    "mesh_force_rms": ("N", "RMS of the dynamic mesh force"),
    "mesh_force_peak": ("N", "largest mesh force"),
    "mesh_force_minimum": ("N", "smallest mesh force"),
    "amplitude": ("m", "half peak-to-peak displacement, torsion as base-circle displacement"),
    "status": ("", "what became of the point"),
    "harmonics": ("1", "harmonics of the mesh frequency kept"),
    "residual": ("1", "relative residual with the harmonics dropped"),
    "sample_time": ("s", "time"),
    # one-parameter studies
    "quantity": ("", "quantity studied"),
    "support_stiffness": ("N/m", "lateral support stiffness"),
    "run_out": ("um", "run-out"),
    # audit; numbers are in the unit of their row
    "drive": ("", "drive audited"),
    "place": ("", "place in the source"),
    "published": ("", "published value"),
    "published_text": ("", "published value as it stands"),
    "published_unit": ("", "unit of the numbers of the row"),
    "ours": ("", "our value"),
    "difference": ("", "our value less the published"),
    "tolerance": ("", "difference allowed"),
    "verdict": ("", "what is claimed of the published value"),
    "outcome": ("", "whether our value bears out the verdict"),
    "because": ("", "reason of the tolerance"),
    "reading": ("", "reading of the source"),
    "reason": ("", "erratum or missing datum"),
    "fitted": ("", "whether a parameter was fitted"),
}


def dataset(
    variables: Mapping[str, tuple[Sequence[str] | str, Any]],
    coords: Mapping[Hashable, Any] | None = None,
    *,
    verb: str,
    options: Mapping[str, Any] | None = None,
    provenance: Mapping[str, str] | None = None,
    warnings: Sequence[str] = (),
    units: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Make a Dataset whose variables carry unit and long name from `VARIABLES`.

    Parameters
    ----------
    variables : name -> (dims, values).  coords : as of xarray; known names get their unit too.
    verb : the analysis.  options : its options, stored as JSON.  provenance : attributes of the System.
    warnings : physical warnings, stored as JSON in the attribute ``warnings``.
    units : unit of a variable where it differs from the table (an rz row in a mixed array, say).

    Raises
    ------
    KeyError : a variable is missing from the table.
    """
    result = xr.Dataset(dict(variables), coords=dict(coords or {}))
    for name in result.variables:
        entry = VARIABLES.get(str(name))
        if entry is None and name in variables:
            raise KeyError(f"{name} has no entry in results.VARIABLES")
        if entry is not None:
            unit = (units or {}).get(str(name), entry[0])
            result[name].attrs.update({"units": unit, "long_name": entry[1]})
    result.attrs.update(
        {
            "verb": verb,
            "package": "epicyclic",
            "version": _version(),
            "options": json.dumps(dict(options or {}), default=str),
            "warnings": json.dumps(list(warnings)),
            **dict(provenance or {}),
        }
    )
    return result


def to_json(result: xr.Dataset) -> str:
    """`Dataset.to_dict()` as JSON; read back with ``xarray.Dataset.from_dict(json.loads(text))``.

    Complex variables have a trailing ``part`` dimension (real, imaginary), as in a saved file.
    """
    return json.dumps(_real(result).to_dict(), default=_plain)


def save_result(result: xr.Dataset, path: str | Path) -> Path:
    """Write a Dataset to a netCDF-4 file; complex variables become a trailing ``part`` dimension (real, imaginary).

    The file appears whole or not at all.
    """
    target = Path(path)
    flat = _real(result)
    for name in list(flat.variables):
        values = flat[name]
        if values.dtype == bool:
            flat[name] = (values.dims, values.values.astype(np.int8), {**values.attrs, "boolean": "1"})
    partial = target.with_name(target.name + ".part")
    try:
        flat.to_netcdf(partial, engine="h5netcdf")
        partial.replace(target)
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(target)) from error
    finally:
        partial.unlink(missing_ok=True)
    return target


def _real(result: xr.Dataset) -> xr.Dataset:
    """A copy without complex numbers: real and imaginary part along a trailing dimension ``part``."""
    flat = result.copy()
    for name in list(flat.variables):
        values = flat[name]
        if np.iscomplexobj(values.values):
            split = np.stack([values.values.real, values.values.imag], axis=-1)
            flat[name] = ((*values.dims, "part"), split, {**values.attrs, "complex": "1"})
    return flat


def load_result(path: str | Path) -> xr.Dataset:
    """Reopen what `save_result` wrote, equal to the Dataset that was saved."""
    if not Path(path).is_file():
        raise ModelError("no such file", path=str(path))
    try:
        with xr.open_dataset(path, engine="h5netcdf") as file:
            flat = file.load()
    except (OSError, ValueError) as error:
        raise ModelError(f"not a result file: {error}", path=str(path)) from error
    result = flat.copy()
    for name in list(flat.variables):
        attrs = dict(flat[name].attrs)
        if attrs.pop("complex", None):
            values = flat[name].values
            result[name] = (flat[name].dims[:-1], values[..., 0] + 1j * values[..., 1], attrs)
        elif attrs.pop("boolean", None):
            result[name] = (flat[name].dims, flat[name].values.astype(bool), attrs)
    return result


def _version() -> str:
    try:
        return version("epicyclic")
    except PackageNotFoundError:
        return "unknown"


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    return str(value)
