"""Parameters of a model file, every number that may be differentiated, and derivatives of a System along them.

Written numbers and derived ones (masses, inertias, mean mesh stiffnesses) are parameters; counts and texts are not.

The map from the file to the matrices is smooth and exact to rounding.  Richardson extrapolation of central differences
with steps h and h/2, h = 1e-3 of the value, therefore gives its derivative to about 1e-10.  Where a value may not go to
both sides, one-sided differences of third order take their place.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from ...document.schema import collect, nearest
from ...document.tables import expand_path, leaves
from ...document.units import Written, written
from ...engine.points import Outcome, outcomes
from ...errors import ModelError
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.resolution import load
from ...train.train import Train
from .adjoint import SystemNumbers, combined, numbers, with_lines

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
    whole = with_lines(base, tuple(frequencies))
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
        return numbers(with_lines(system, [line.frequency for line in whole.lines]))
    if len(system.lines) != len(base.lines) or len(system.tones) != len(base.tones):
        raise ModelError("frequencies meet or part beside this speed: no derivative")
    known = {line.frequency for line in base.lines}
    share = system.tones[0] / base.tones[0] if base.tones[0] else Fraction(1)
    empty = numbers(with_lines(replace(system, lines=()), [line.frequency * share for line in whole.lines]))
    values = numbers(system)
    rows = [row for row, line in enumerate(whole.lines) if line.frequency in known]
    arrays = {name: getattr(empty, name).copy() for name in ("line_frequency", "line_gap", "line_force")}
    for name, array in arrays.items():
        array[rows] = getattr(values, name)
    return empty._replace(**arrays)
