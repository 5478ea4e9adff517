"""Which number on the drawing moves a frequency or a mesh force most: derivatives by any path of a model file."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..analyses.modes.classification import classify_modes, repeated_roots
from ..analyses.modes.eigen import eigen, whirl
from ..analyses.sensitivity.forces import force_derivatives
from ..analyses.sensitivity.frequencies import frequency_derivatives, whirl_derivatives
from ..analyses.sensitivity.numbers import Numbers, is_nonzero
from ..analyses.steady.response import response
from ..errors import ModelError
from ..model.names import nearest
from ..results.dataset import dataset
from ..system.faces import faces
from ..system.system import System
from ..train.train import Train
from .check import train_provenance
from .parameters import Parameter, all_parameters, parameter_at
from .tangents import Tangents, tangents

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Quantity", "sensitivity"]

Array = NDArray[np.float64]
Progress = Callable[[float], None] | None
Quantity = Literal["frequency", "force"]
# Below this, percent per percent, a number does not move anything: rounding of the difference quotients.
_NOTHING = 1e-9


def sensitivity(
    train: Train,
    *,
    of: Quantity = "frequency",
    mode: int | None = None,
    mesh: str | None = None,
    paths: Sequence[str] | None = None,
    mesh_frequency: float | None = None,
    relative_speed: float | None = None,
    harmonic: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Derivatives of natural frequencies, or of mesh-force RMS, with respect to numbers of the model file, ranked.

    Parameters
    ----------
    of : ``frequency``, of all modes, or ``force``, RMS of the dynamic force of every mesh.
    mode : by which the paths are ranked, from 1; the lowest elastic one where None.  mesh : likewise; the one with the
        largest force where None.
    paths : paths of the file, ``PATH[2]`` for one entry; every number that moves something where None.
    mesh_frequency : of the first mesh [Hz], or relative_speed : speed per operating speed [1].  Of forces, where it is
        looked at, 1 where neither is given; a speed in the file moves it along.  Frequencies stand still, undamped,
        unless a relative speed brings in gyroscopic terms.
    harmonic : amplitude of this mesh order in place of the RMS.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : ``derivative`` [per unit as written] and ``sensitivity`` [percent per percent, nan for a value of 0] over
        (path, mode or mesh), paths ranked by the largest sensitivity of what was asked for.  Of a repeated root the
        derivatives are the set into which it splits; they belong to the group.

    Raises
    ------
    ModelError : a path that is not there, no number or not smooth; a mode or mesh that is not there; options that do
        not go together; of forces no damping or no speed.
    """
    _check(of, mode=mode, mesh=mesh, harmonic=harmonic, mesh_frequency=mesh_frequency)
    asked = all_parameters(train) if paths is None else [parameter_at(train, path) for path in paths]
    if not asked:
        raise ModelError("no path given", path="paths", allowed="paths of the model file, or none for all")
    found = tangents(train, asked, progress=progress)
    kept = _usable(found, given=paths is not None)
    parameters = [found.along[place].parameter for place in kept]
    changes = [change for place in kept if (change := found.along[place].change) is not None]
    if of == "frequency":
        answer = _frequencies(found.system, changes, relative_speed or 0.0, mode)
    else:
        speed = _speed(found.system, mesh_frequency, relative_speed)
        answer = _forces(found.system, changes, speed, harmonic, mesh)
    return _labelled(train, found.system, parameters, answer, _left(found, kept), everything=paths is None)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Answer:
    """What was asked for.

    dim : mode or mesh.  unit : of the values.  value : (t,).  derivative : (changes, t).  target : (t,) those the
    ranking is by.  problem : (changes,) why a derivative is missing.
    subject : what the ranking is by, in words.
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


def _check(of: str, *, mode: int | None, mesh: str | None, harmonic: int | None, mesh_frequency: float | None) -> None:
    if of not in ("frequency", "force"):
        raise ModelError("unknown choice", path="of", given=of, allowed="frequency, force")
    if of == "frequency" and (mesh is not None or harmonic is not None or mesh_frequency is not None):
        raise ModelError("a mesh, its order or frequency goes with forces", path="of", given=of, allowed="force")
    if of == "force" and mode is not None:
        raise ModelError("a mode goes with frequencies", path="of", given=of, allowed="frequency")
    if harmonic is not None and harmonic < 1:
        raise ModelError("no mesh order that moves", path="harmonic", given=harmonic, allowed="1 or more")


def _usable(found: Tangents, *, given: bool) -> list[int]:
    """Numbers of the parameters with a derivative that is not nothing.

    Raises
    ------
    ModelError : one that was asked for by name has no derivative.
    """
    if given:
        for one in found.along:
            if one.change is None:
                raise ModelError(one.problem, path=one.parameter.path, given=one.parameter.value)
        return list(range(len(found.along)))
    return [i for i, one in enumerate(found.along) if one.change is not None and is_nonzero(one.change)]


def _left(found: Tangents, kept: Sequence[int]) -> dict[str, str]:
    """Paths that could have been listed and are not, and why."""
    return {
        one.parameter.path: one.problem or "moves nothing" for i, one in enumerate(found.along) if i not in set(kept)
    }


def _frequencies(system: System, changes: Sequence[Numbers], relative_speed: float, mode: int | None) -> _Answer:
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
    if mode is not None and not 1 <= mode <= hertz.size:
        raise ModelError("no such mode", path="mode", given=mode, allowed=f"1 .. {hertz.size}")
    if not elastic.size:
        raise ModelError("no mode is elastic: nothing to differentiate", path="stages")
    first = int(elastic[0]) if mode is None else mode - 1
    target = np.zeros(hertz.size, bool)
    target[next(group for group in repeated_roots(squared) if group.start <= first < group.stop)] = True
    return _Answer(
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
        subject=_mode_words(target, float(hertz[first]), kinds.kind[first]),
    )


def _mode_words(target: NDArray[np.bool_], hertz: float, kind: str) -> str:
    """``modes 4 to 5, one root, 1091.16 Hz, translational``."""
    low, high = (int(place) + 1 for place in np.flatnonzero(target)[[0, -1]])
    modes = f"mode {low}" if low == high else f"modes {low} to {high}, one root"
    return f"{modes}, {hertz:.6g} Hz, {kind}"


def _speed(system: System, mesh_frequency: float | None, relative_speed: float | None) -> float:
    if mesh_frequency is not None and relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    if mesh_frequency is None:
        return 1.0 if relative_speed is None else relative_speed
    return mesh_frequency / float(response(system).lines.tone)


def _forces(
    system: System, changes: Sequence[Numbers], speed: float, harmonic: int | None, mesh: str | None
) -> _Answer:
    names = faces(system.meshes).name
    if mesh is not None and mesh not in names:
        raise ModelError(
            f"no such mesh{nearest(mesh, names)}", path="mesh", given=mesh, allowed=f"{names[0]} .. {names[-1]}"
        )
    found = force_derivatives(system, changes, relative_speed=speed, harmonic=harmonic)
    value = found.value[:, 0]
    first = names.index(mesh) if mesh is not None else int(np.argmax(np.nan_to_num(value)))
    hertz = speed * float(system.tones[system.meshes.tone[0]])
    words = "the RMS of the dynamic mesh force" if harmonic is None else f"mesh order {harmonic} of the mesh force"
    held = "takes hold of a motion that is free (radii that fit no one centre distance do this)"
    return _Answer(
        dim="mesh",
        unit="N",
        value=value,
        derivative=found.derivative[:, :, 0],
        target=np.arange(len(names)) == first,
        problem=tuple(held if taken else "" for taken in found.constrained),
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
    answer: _Answer,
    left: dict[str, str],
    *,
    everything: bool,
) -> xr.Dataset:
    at = np.array([parameter.value for parameter in parameters])
    scale = np.where(answer.value > 0, answer.value, np.nan)
    relative = np.where(at[:, None] != 0, at[:, None] * answer.derivative / scale, np.nan)
    still = np.abs(relative) < _NOTHING
    relative, derivative = (np.where(still, 0.0, values) for values in (relative, answer.derivative))
    with np.errstate(invalid="ignore"):
        size = np.nanmax(np.where(answer.target, np.abs(relative), -1.0), axis=1, initial=-1.0)
    rank = np.argsort(-size, kind="stable").tolist()
    if everything:
        idle = np.all(derivative == 0, axis=1)
        left = left | {parameters[i].path: "moves nothing" for i in np.flatnonzero(idle).tolist()}
        rank = [i for i in rank if not idle[i]]
    result = dataset(
        {
            **answer.variables,
            "derivative": (("path", answer.dim), derivative[rank]),
            "sensitivity": (("path", answer.dim), relative[rank]),
            "parameter_value": ("path", at[rank]),
            "parameter_unit": ("path", np.array([parameters[i].unit for i in rank], object)),
            "status": ("path", np.array([answer.problem[i] or "ok" for i in rank], object)),
            "ranked_by": (answer.dim, answer.target),
        },
        {"path": [parameters[i].path for i in rank], **answer.coords},
        verb="sensitivity",
        options=answer.options,
        provenance=train_provenance(train),
        warnings=system.warnings,
        units={"derivative": f"{answer.unit} per unit of the value"},
    )
    return result.assign_attrs(subject=answer.subject, left_out=json.dumps(left))
