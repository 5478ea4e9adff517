"""Sensitivity of natural frequencies and mesh forces to the numbers of a model file: derivatives by any path, ranked.

Written numbers and derived ones (masses, inertias, mean mesh stiffnesses) are parameters; counts and texts are not.
The assembly is differenced along each parameter (`system_derivatives`); derivatives of frequencies follow in closed
form and those of mesh forces by one adjoint solution (`adjoint`).

The map from the file to the matrices is smooth and exact to rounding.  Richardson extrapolation of central differences
with steps h and h/2, h = 1e-3 of the value, therefore gives its derivative to about 1e-10.  Where a value may not go to
both sides, one-sided differences of third order take their place.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.schema import collect, nearest
from ...document.tables import expand_path, leaves
from ...document.units import Written, written
from ...engine.points import Outcome, outcomes
from ...errors import ModelError
from ...options import Progress
from ...results.dataset import dataset, largest, ranked
from ...statics.tangent import linear
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System, faces
from ...train.resolution import load
from ...train.train import Train
from ..modes.eigen import classify_modes, eigen, repeated_roots, whirl
from ..response.response import response
from . import SensitivityOptions
from .adjoint import SystemNumbers, combined, numbers
from .gradient import force_derivatives, frequency_derivatives, whirl_derivatives

_COUNTS = ("teeth", "planets", "slices", "count", "order", "seed", "modes")
_TEXTS = ("format", "title", "doi", "notes", "assumed", "tolerance", "limits")
# Long lists, whose entries are parameters only where a path names them
_TABLES = ("pitch", "values", "deflection")
_DERIVED = ("mass", "inertia", "tilt_inertia", "stiffness")
_PAIRS = {"x": ("y", "radial"), "rx": ("ry", "tilt")}
_INDEXED = re.compile(r"(.*)\[(\d{1,4})\]\s*")
# Step per value.
_STEP = 1e-3
# Step of a value of 0, in the unit it is written in
_STEP_AT_ZERO = {"": 1e-3, "um": 1.0, "mm": 1e-3, "m": 1e-6, "deg": 1e-2, "rad": 1e-4, "N/m": 1e4, "N m/rad": 1e4}
# Quotients of steps h and h/2 differ by h^2 f'''/8.  A larger relative difference means that the map is not smooth.
_SMOOTH = 1e-3
# Relative rounding of an assembled array
_ROUNDING = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One number of the model file.

    path : its name, ``PATH[2]`` for the second entry of a list.  leaves : full paths that hold it.
    value : in `unit` as written; a bare number is SI.  number : number or list as written.  index : of a list, from 0.
    companions : overrides that keep a derived value which an override of this number would replace.
    """

    path: str
    leaves: tuple[str, ...]
    value: float
    unit: str
    number: Written
    index: int = 0
    companions: tuple[tuple[str, object], ...] = ()

    def at(self, value: float) -> dict[str, object]:
        """Overrides that set another value, in `unit`."""
        values = (*self.number.values[: self.index], value, *self.number.values[self.index + 1 :])
        return {**dict(self.companions), **dict.fromkeys(self.leaves, self.number.text(values))}

    def system_at(self, document: Mapping[str, object], value: float) -> System:
        """Linearised System of a model with another value, in `unit`; its numbers alone, without its warnings."""
        return linear(assemble(load(document, overrides=self.at(value))), asks_laws=True)


class _Scheme(NamedTuple):
    """Two difference quotients of one order, with steps h and h/2.

    shares : places of the Systems, in steps.  coarse, fine : weights of the quotients, per step.
    order : of their error.  step : h, in steps.
    """

    shares: tuple[float, ...]
    coarse: tuple[float, ...]
    fine: tuple[float, ...]
    order: int
    step: float


_CENTRAL = _Scheme((-1, -0.5, 0, 0.5, 1), (-0.5, 0, 0, 0, 0.5), (0, -1, 0, 1, 0), 2, 1)
# (-11 f0 + 18 f1 - 9 f2 + 2 f3) / 6 d, d a quarter and an eighth of the step
_ONE_SIDED = _Scheme(
    shares=(0, 0.125, 0.25, 0.375, 0.5, 0.75),
    coarse=tuple(4 * w / 6 for w in (-11, 0, 18, 0, -9, 2)),
    fine=tuple(8 * w / 6 for w in (-11, 18, -9, 2, 0, 0)),
    order=3,
    step=0.125,
)


class _Stencil(NamedTuple):
    """Systems at the places of a scheme along one parameter.

    step : in the unit of the parameter, below zero where they stand below the value.
    """

    systems: tuple[System, ...]
    scheme: _Scheme
    step: float

    @property
    def unchanged(self) -> int:
        """Index of the System as it is."""
        return self.scheme.shares.index(0)


def all_parameters(train: Train) -> list[Parameter]:
    """Every written number without counts, entries of lists one by one, and derived masses and stiffnesses.

    Equal stiffnesses in x and y are one parameter, `radial`; in rx and ry `tilt`.
    """
    document = dict(leaves(dict(train.document)))
    parameters: list[Parameter] = []
    for path, holders in named_leaves(document).items():
        first, last, number = path.split(".")[0], path.rpartition(".")[2], written(document[holders[0]])
        if number is None or first in _TEXTS or last in (*_COUNTS, *_TABLES) or (number.many and last == "force"):
            continue
        for index, value in enumerate(number.values):
            name = f"{path}[{index + 1}]" if number.many else path
            parameters.append(
                Parameter(path=name, leaves=holders, value=value, unit=number.unit, number=number, index=index)
            )
    return [*parameters, *(derived for derived in _derived(train) if not _is_written(derived.path, document))]


def parameter_at(train: Train, text: str) -> Parameter:
    """Parameter at a path, shorthands allowed; ``PATH[2]`` is an entry of a list, or one planet's of a common value.

    Raises
    ------
    ModelError : no such path (the nearest is named), no number, a count, a rigid connection, a list without an index.
    """
    path, index = (match[1], int(match[2])) if (match := _INDEXED.fullmatch(text)) else (text.strip(), 0)
    document = dict(leaves(dict(train.document)))
    holders = expand_path(path, collect(dict(train.document)), path="path")
    number, *others = (_number_at(leaf, document, train, text) for leaf in holders)
    if any(other != number for other in others):
        listed = ", ".join(holders)
        raise ModelError("stands at values that differ", path=text, given=listed, allowed="one of these paths")
    last = holders[0].rpartition(".")[2]
    if last in _COUNTS or (number.whole and last in _TABLES):
        raise ModelError("a whole number: nothing between two of them, so no derivative", path=text)
    if number.many and not index:
        raise ModelError("a list", path=text, allowed=f"one of its entries, {path}[1] .. {path}[{len(number.values)}]")
    if index:
        number = _listed(number, holders[0], train, text, index)
    entry = max(index - 1, 0)
    return Parameter(
        path=f"{path}[{index}]" if index else path,
        leaves=holders,
        value=number.values[entry],
        unit=number.unit,
        number=number,
        index=entry,
        companions=_companions(train, holders[0], document),
    )


def named_leaves(document: Mapping[str, object]) -> dict[str, tuple[str, ...]]:
    """Name of a number -> paths that hold it; equal values of a link in x and y are `radial`, in rx and ry `tilt`.

    document : full path -> value, as below.
    """
    result: dict[str, tuple[str, ...]] = {}
    for path, value in document.items():
        head, _, last = path.rpartition(".")
        second, name = _PAIRS.get(last, ("", ""))
        twin = {"y": "x", "ry": "rx"}.get(last, "")
        stiff = path.split(".")[0] in ("stages", "bodies", "couplings")
        if stiff and second and document.get(f"{head}.{second}") == value:
            result[f"{head}.{name}"] = (path, f"{head}.{second}")
        elif not (stiff and twin and document.get(f"{head}.{twin}") == value):
            result[path] = (path,)
    return result


def _derived(train: Train) -> Iterator[Parameter]:
    """Derived masses, inertias and mesh stiffnesses, and the pressure angle of the tool where it is the default."""
    tools: dict[str, set[float]] = {}
    document = dict(leaves(dict(train.document)))
    for value in train.values:
        parts = value.path.split(".")
        if not isinstance(value.value, float) or not math.isfinite(value.value):
            continue
        if parts[-1] in _DERIVED:
            yield _parameter(value.path, value.value, value.unit, _companions(train, value.path, document))
        elif parts[-1] == "pressure_angle" and "meshes" not in parts and value.origin == "default":
            tools.setdefault(f"stages.{parts[1]}.pressure_angle", set()).add(value.value)
    # degrees, as on drawings
    yield from (
        _parameter(path, math.degrees(angles.pop()), "deg") for path, angles in tools.items() if len(angles) == 1
    )


def _is_written(path: str, document: Mapping[str, object]) -> bool:
    """Whether the file holds a number at this path, or more special ones (of a side) below its head."""
    head, _, last = path.rpartition(".")
    return any(
        p == path or (p.startswith(f"{head}.") and p.endswith(f".{last}")) for p in document if written(document[p])
    )


def _companions(train: Train, path: str, document: Mapping[str, object]) -> tuple[tuple[str, object], ...]:
    """Derived variation of a mesh whose mean stiffness is derived too: with a given stiffness it would not vary."""
    head, _, last = path.rpartition(".")
    given = written(document.get(path)) is not None or any(p.startswith(f"{head}.variation") for p in document)
    if last != "stiffness" or given:
        return ()
    return tuple((v.path, v.value) for v in train.values if v.path == f"{head}.variation" and isinstance(v.value, str))


def _parameter(path: str, value: float, unit: str, companions: tuple[tuple[str, object], ...] = ()) -> Parameter:
    """Parameter of a derived value that no list holds."""
    written_unit = "" if unit == "cycles" else unit
    number = Written(values=(value,), unit=written_unit, many=False)
    return Parameter(path=path, leaves=(path,), value=value, unit=written_unit, number=number, companions=companions)


def _number_at(leaf: str, document: Mapping[str, object], train: Train, text: str) -> Written:
    """Number at one full path, written or derived.

    Raises
    ------
    ModelError : no number there, or a rigid connection.
    """
    number = written(document[leaf]) if leaf in document else None
    if number is not None:
        return number
    derived = {parameter.path: parameter.number for parameter in _derived(train)}
    if leaf in derived:
        return derived[leaf]
    resolved = {value.path: value for value in train.values}
    known = resolved.get(leaf)
    number = None if known is None else written(known.value)
    if known is not None and number is not None and all(map(math.isfinite, number.values)):
        return replace(number, unit="" if known.unit == "cycles" else known.unit)
    value = document.get(leaf, None if known is None else known.value)
    if value is None or isinstance(value, dict):
        every = [parameter.path for parameter in all_parameters(train)]
        raise ModelError(
            f"no number at this path{nearest(text, [*every, *resolved, *document])}",
            path=text,
            allowed="a number the model has; give it a value first, --set PATH=VALUE",
        )
    rigid = value in ("inf", math.inf)
    raise ModelError("rigid: no derivative" if rigid else "not a number: no derivative", path=text, given=value)


def _listed(number: Written, leaf: str, train: Train, text: str, index: int) -> Written:
    """Number as a list: one entry for each planet where a common value is written.

    Raises
    ------
    ModelError : no such entry.
    """
    stage = next((part for part in leaf.split(".")[1:2] if part in train.planets), None)
    if not number.many and stage is not None and train.planets[stage] > 1:
        number = Written(values=number.values * train.planets[stage], unit=number.unit, many=True)
    if not 1 <= index <= len(number.values) or not number.many:
        raise ModelError("no such entry", path=text, given=index, allowed=f"1 .. {len(number.values)}")
    return number


def system_derivatives(
    train: Train, base: System, parameters: Sequence[Parameter], *, progress: Callable[[float], None] | None = None
) -> tuple[System, list[Outcome[SystemNumbers]]]:
    """The linearised assembly of a train, `base`, and its derivatives along each parameter; derived here.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    (the System with an empty line at every frequency that a parameter would excite; of every parameter the derivatives
    of the System's numbers, per unit as written, or why there are none).
    """
    # tolerances, and reasons for what may be removed, move no number of the System but take time to check
    document = {name: table for name, table in train.document.items() if name not in ("tolerance", "assumed")}
    stencils = outcomes(partial(_stencil, document, base), parameters, workers=False, progress=progress)
    systems = [system for stencil in stencils if stencil.value is not None for system in stencil.value.systems]
    # that some parameter excites
    frequencies = dict.fromkeys(line.frequency for s in systems if s.tones == base.tones for line in s.lines)
    whole = base.with_lines(frequencies)
    return whole, [stencil.then(partial(_derivative, base, whole)) for stencil in stencils]


def _stencil(document: Mapping[str, object], base: System, parameter: Parameter) -> _Stencil:
    """Central differences of second order, else one-sided ones of third order, above the value or below it.

    Raises
    ------
    ModelError : the model can go to neither side, or has other degrees of freedom there.
    """
    step = _STEP * abs(parameter.value) or _STEP_AT_ZERO.get(parameter.unit, 1e-3)

    def at(change: float) -> System:
        system = parameter.system_at(document, parameter.value + change)
        if system.dofs.names != base.dofs.names or system.meshes.name != base.meshes.name:
            raise ModelError("another number of motions beside this value: no derivative")
        return system

    def along(scheme: _Scheme, step: float) -> _Stencil:
        return _Stencil(tuple(at(share * step) if share else base for share in scheme.shares), scheme, step)

    for scheme in (_CENTRAL, _ONE_SIDED):
        with suppress(ModelError):
            return along(scheme, step)
    return along(_ONE_SIDED, -step)


def _derivative(base: System, whole: System, stencil: _Stencil) -> SystemNumbers:
    """Richardson extrapolation of the two quotients.

    Raises
    ------
    ModelError : they do not agree, or something appears or vanishes beside the value.
    """
    values = [_aligned(system, base, whole) for system in stencil.systems]
    # differences to the value first: an array that does not change has a derivative of exactly zero
    differences = [combined([1.0, -1.0], [value, values[stencil.unchanged]]) for value in values]
    soft = _soft_link_changes(stencil)
    if soft is not None:
        differences = [change._replace(K=K) for change, K in zip(differences, soft, strict=True)]
    scheme, per = stencil.scheme, 1 / stencil.step
    coarse, fine = (combined([per * w for w in weights], differences) for weights in (scheme.coarse, scheme.fine))
    power = 2**scheme.order
    change = combined([power / (power - 1), -1 / (power - 1)], [fine, coarse])
    rounded = _without_rounding(change, values[stencil.unchanged], scheme.step * abs(stencil.step))
    change = rounded if soft is None else rounded._replace(K=change.K)
    if not _smooth(coarse, change) or _kinked(stencil, values):
        raise ModelError("not smooth at this value: no derivative")
    return change


def _soft_link_changes(stencil: _Stencil) -> list[Array] | None:
    """Changes of K (n, n) [N/m] of each system against the unchanged one, from its links; None where K has them.

    A step of a link far softer than the stiffest part is rounding of their sum K, and no rounding of its own rows.
    """
    base = stencil.systems[stencil.unchanged]
    links = base.links
    rounding = _ROUNDING * float(np.abs(base.K).max(initial=0.0))
    changes = []
    for system in stencil.systems:
        if system.links.name != links.name or not np.array_equal(system.links.B, links.B):
            return None
        with np.errstate(invalid="ignore"):  # rigid in both
            step = np.nan_to_num(system.links.stiffness - links.stiffness)
        change: Array = (links.B * step) @ links.B.T
        if np.abs(system.K - base.K - change).max(initial=0.0) > rounding:
            return None  # something else changes K too
        changes.append(change)
    largest = max(float(np.abs(change).max(initial=0.0)) for change in changes)
    return changes if 0 < largest and rounding > _SMOOTH * largest else None


def _without_rounding(change: SystemNumbers, value: SystemNumbers, step: float) -> SystemNumbers:
    """Derivatives with zeros for arrays that are rounding of the quotient, below 1e-13 of the value over the step."""
    limits = (_ROUNDING * float(np.abs(array).max(initial=0.0)) / step for array in value)
    pairs = zip(change, limits, strict=True)
    return SystemNumbers._make(np.zeros_like(a) if np.abs(a).max(initial=0.0) <= limit else a for a, limit in pairs)


def _smooth(coarse: SystemNumbers, change: SystemNumbers) -> bool:
    """Whether coarse quotient and derivative of every array differ by no more than those of a smooth function."""
    for quotient, derivative in zip(coarse, change, strict=True):
        size = float(np.abs(derivative).max(initial=0.0))
        if size > 0 and float(np.abs(quotient - derivative).max(initial=0.0)) > _SMOOTH * size:
            return False
    return True


def _kinked(stencil: _Stencil, values: Sequence[SystemNumbers]) -> bool:
    """Whether the second difference of an array shrinks with the step, as at a kink, and not with its square."""
    if stencil.scheme.order == 3:
        return False
    for low, below, here, above, high in zip(*values, strict=True):
        wide, near = (float(np.abs(a + b - 2 * here).max(initial=0.0)) for a, b in ((low, high), (below, above)))
        slope = float(np.abs(above - below).max(initial=0.0))
        rounding = _ROUNDING * float(np.abs(here).max(initial=0.0))
        if near > 0.4 * wide and near > _SMOOTH * slope + rounding:
            return True
    return False


def _aligned(system: System, base: System, whole: System) -> SystemNumbers:
    """Numbers of a System with one line for each line of `whole`.

    Lines correspond by frequency, or by their place in the order where the parameter changes the speed.

    Raises
    ------
    ModelError : the speeds differ and so does the number of lines.
    """
    if system.tones == base.tones:
        return numbers(system.with_lines([line.frequency for line in whole.lines]))
    if len(system.lines) != len(base.lines) or len(system.tones) != len(base.tones):
        raise ModelError("frequencies meet or part beside this speed: no derivative")
    known = {line.frequency for line in base.lines}
    share = system.tones[0] / base.tones[0] if base.tones[0] else Fraction(1)
    empty = numbers(replace(system, lines=()).with_lines([line.frequency * share for line in whole.lines]))
    values = numbers(system)
    rows = [row for row, line in enumerate(whole.lines) if line.frequency in known]
    arrays = {name: getattr(empty, name).copy() for name in ("line_frequency", "line_gap", "line_force")}
    for name, array in arrays.items():
        array[rows] = getattr(values, name)
    return empty._replace(**arrays)


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
