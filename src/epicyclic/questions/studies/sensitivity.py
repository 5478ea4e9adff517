"""Sensitivity of natural frequencies and mesh forces to the numbers of a model file: derivatives by any path, ranked.

The assembly is differenced along each parameter (`system_derivatives`); derivatives of frequencies follow in closed
form and those of mesh forces by one adjoint solution (`adjoint`).
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.schema import nearest
from ...errors import ModelError
from ...options import Progress
from ...results.dataset import dataset, largest, ranked
from ...statics.tangent import linear
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System, faces
from ...train.train import Train
from ..modes.eigen import classify_modes, eigen, repeated_roots, whirl
from ..response.response import response
from . import SensitivityOptions
from .adjoint import SystemNumbers
from .derivatives import Parameter, all_parameters, parameter_at, system_derivatives
from .gradient import force_derivatives, frequency_derivatives, whirl_derivatives

# Sensitivity below which a parameter has no effect [percent per percent]: rounding of the difference quotients
_NEGLIGIBLE = 1e-9


def sensitivity(train: Train, options: SensitivityOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Derivatives of natural frequencies, or of mesh-force RMS, with respect to numbers of the model file, ranked.

    The speed of the forces follows a speed in the file.  Frequencies take a relative speed alone, for gyroscopic terms;
    they are undamped, and at standstill without one.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : ``derivative`` [Hz or N per unit as written] and ``sensitivity`` [percent per percent, nan for a value of
        0] (path, mode or mesh), status, parameter_value, parameter_unit (path), ranked_by (mode or mesh).  Derivatives
        of a repeated root are those of the roots into which it splits; they belong to the group.

    Raises
    ------
    ModelError : a path that is not there, no number or not smooth; a mode or mesh that is not there; options that do
        not go together; of forces no damping or no speed.
    """
    of, mode, mesh, harmonic, paths = options.of, options.mode, options.mesh, options.harmonic, options.paths
    mesh_frequency, relative_speed = options.mesh_frequency, options.relative_speed
    if of == "frequency" and (mesh is not None or harmonic is not None or mesh_frequency is not None):
        raise ModelError("a mesh, its order or frequency goes with forces", path="of", given=of, allowed="force")
    if of == "force" and mode is not None:
        raise ModelError("a mode goes with frequencies", path="of", given=of, allowed="frequency")
    candidates = all_parameters(train) if paths is None else [parameter_at(train, path) for path in paths]
    if not candidates:
        raise ModelError("no path given", path="paths", allowed="paths of the model file, or none for all")
    if mesh_frequency is not None and relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    base = linear(assemble(train))
    # before any number is differentiated
    if mode is not None and not 1 <= mode <= len(base.M):
        raise ModelError("no such mode", path="mode", given=mode, allowed=f"1 .. {len(base.M)}")
    names = faces(base.meshes).name
    if mesh is not None and mesh not in names:
        allowed = f"{names[0]} .. {names[-1]}"
        raise ModelError(f"no such mesh{nearest(mesh, names)}", path="mesh", given=mesh, allowed=allowed)
    system, derivatives = system_derivatives(train, base, candidates, progress=progress)
    parameters: list[Parameter] = []
    changes: list[SystemNumbers] = []
    left_out: dict[str, str] = {}  # path of a parameter that is not listed -> reason
    for parameter, along in zip(candidates, derivatives, strict=True):
        if along.value is None and paths is not None:
            raise ModelError(along.problem, path=parameter.path, given=parameter.value)
        if along.value is not None and (paths is not None or any(array.any() for array in along.value)):
            parameters.append(parameter)
            changes.append(along.value)
        else:
            left_out[parameter.path] = along.problem or "moves nothing"
    if of == "frequency":
        quantity = _frequencies(system, changes, relative_speed or 0.0, mode)
    else:
        speed = 1.0 if relative_speed is None else relative_speed
        if mesh_frequency is not None:
            speed = mesh_frequency / float(response(system).lines.tone)
        quantity = _forces(system, changes, speed, harmonic, mesh)
    return _labelled(train, system, parameters, quantity, left_out, only_effective=paths is None)


class _Derivatives(NamedTuple):
    """A differentiated quantity: t frequencies or mesh forces, c parameters.

    dim : mode or mesh.  unit : of the quantity.  value : (t,).  derivative : (c, t) per unit of the parameter.
    target : (t,) entries whose sensitivity ranks the paths.  problem : (c,) why a derivative is missing, else "".
    subject : the targets in words.
    """

    dim: str
    unit: str
    value: Array
    derivative: Array
    target: NDArray[np.bool_]
    problem: tuple[str, ...]
    variables: dict[str, tuple[str, Any]]
    coords: dict[Hashable, Any]
    options: dict[str, Any]
    subject: str


def _frequencies(
    system: System, changes: Sequence[SystemNumbers], relative_speed: float, mode: int | None
) -> _Derivatives:
    """Natural frequencies [Hz] and their derivatives [fox1968], at standstill undamped, else with gyroscopic terms."""
    modes = eigen(system)
    if relative_speed == 0:
        squared: NDArray[np.inexact] = modes.omega_squared
        kinds, hertz = classify_modes(system, squared, modes.vectors), modes.omega / (2 * np.pi)
        derivative = frequency_derivatives(system, modes, changes)
    else:
        turning = whirl(system, relative_speed=relative_speed, modes=modes)
        kinds, hertz = classify_modes(system, turning.mu, turning.vectors), turning.mu.imag / (2 * np.pi)
        squared = turning.mu
        derivative = whirl_derivatives(system, turning, changes, relative_speed=relative_speed)
    elastic = np.flatnonzero(hertz > 0)
    if not elastic.size:
        raise ModelError("no mode is elastic: nothing to differentiate", path="stages")
    first = int(elastic[0]) if mode is None else mode - 1
    target = np.zeros(hertz.size, bool)
    group = next(group for group in repeated_roots(squared) if group.start <= first < group.stop)
    target[group] = True
    several = group.stop - group.start > 1
    named = f"modes {group.start + 1} to {group.stop}, one root" if several else f"mode {group.stop}"
    return _Derivatives(
        dim="mode",
        unit="Hz",
        value=hertz,
        derivative=derivative,
        target=target,
        problem=("",) * len(changes),
        variables={
            "frequency": ("mode", hertz),
            "mode_kind": ("mode", np.array(kinds.kind, object)),
            "multiplicity": ("mode", kinds.multiplicity),
        },
        coords={"mode": np.arange(1, hertz.size + 1)},
        options={"of": "frequency", "mode": first + 1, "relative_speed": relative_speed},
        subject=f"{named}, {hertz[first]:.6g} Hz, {kinds.kind[first]}",
    )


def _forces(
    system: System, changes: Sequence[SystemNumbers], speed: float, harmonic: int | None, mesh: str | None
) -> _Derivatives:
    """RMS of the dynamic mesh forces, or amplitudes of a mesh order [N], and their derivatives at a relative speed."""
    names = faces(system.meshes).name
    forces = force_derivatives(system, changes, relative_speed=speed, harmonic=harmonic)
    value = forces.value[:, 0]
    first = names.index(mesh) if mesh is not None else largest(value)
    hertz = speed * float(system.tones[system.meshes.tone[0]])
    words = "the RMS of the dynamic mesh force" if harmonic is None else f"mesh order {harmonic} of the mesh force"
    held = "takes hold of a motion that is free (radii that fit no one centre distance do this)"
    return _Derivatives(
        dim="mesh",
        unit="N",
        value=value,
        derivative=forces.derivative[:, :, 0],
        target=np.arange(len(names)) == first,
        problem=tuple(held if constrained else "" for constrained in forces.constrained),
        variables={"mesh_force_rms" if harmonic is None else "mesh_force_amplitude": ("mesh", value)},
        coords={"mesh": list(names)},
        options={
            "of": "force",
            "mesh": names[first],
            "relative_speed": speed,
            "mesh_frequency": hertz,
            "harmonic": harmonic,
        },
        subject=f"{words} of {names[first]}, {value[first]:.5g} N at a mesh frequency of {hertz:.5g} Hz",
    )


def _labelled(
    train: Train,
    system: System,
    parameters: Sequence[Parameter],
    quantity: _Derivatives,
    left_out: dict[str, str],
    *,
    only_effective: bool,
) -> xr.Dataset:
    """Dataset of the paths by falling sensitivity; only_effective : leave out paths without effect."""
    at = np.array([parameter.value for parameter in parameters])
    scale = np.where(quantity.value > 0, quantity.value, np.nan)
    relative = np.where(at[:, None] != 0, at[:, None] * quantity.derivative / scale, np.nan)
    negligible = np.abs(relative) < _NEGLIGIBLE
    relative, derivative = (np.where(negligible, 0.0, values) for values in (relative, quantity.derivative))
    with np.errstate(invalid="ignore"):
        size = np.nanmax(np.where(quantity.target, np.abs(relative), -1.0), axis=1, initial=-1.0)
    rank = ranked(size).tolist()
    if only_effective:
        ineffective = np.all(derivative == 0, axis=1)
        left_out = left_out | {parameters[i].path: "moves nothing" for i in np.flatnonzero(ineffective).tolist()}
        rank = [i for i in rank if not ineffective[i]]
    result = dataset(
        {
            **quantity.variables,
            "derivative": (("path", quantity.dim), derivative[rank]),
            "sensitivity": (("path", quantity.dim), relative[rank]),
            "parameter_value": ("path", at[rank]),
            "parameter_unit": ("path", np.array([parameters[i].unit for i in rank], object)),
            "status": ("path", np.array([quantity.problem[i] or "ok" for i in rank], object)),
            "ranked_by": (quantity.dim, quantity.target),
        },
        {"path": [parameters[i].path for i in rank], **quantity.coords},
        verb="sensitivity",
        options=quantity.options,
        provenance=train_provenance(train),
        warnings=system.warnings,
        units={"derivative": f"{quantity.unit} per unit of the value"},
    )
    return result.assign_attrs(subject=quantity.subject, left_out=json.dumps(left_out))
