"""Derivatives of a System along parameters of its model file: central differences of the assembly, extrapolated.

The map from the file to the matrices is smooth and exact to rounding.  Richardson extrapolation of differences with
steps h and h/2, h = 1e-3 of the value, therefore gives its derivative to about 1e-10.  Where a value may not go to both
sides, one-sided differences of third order take their place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction

import numpy as np

from ..analyses.sensitivity.numbers import SystemNumbers, combined, numbers, with_lines
from ..errors import ConvergenceError, ModelError
from ..statics.tangent import linear
from ..system.assembly import assemble
from ..system.system import Array, System
from ..train.resolution import load
from ..train.train import Train
from .parameters import Parameter

__all__ = ["ParameterDerivative", "SystemDerivatives", "system_derivatives"]

_STEP = 1e-3
# step of a value of 0, in the unit it is written in
_STEP_AT_ZERO = {"": 1e-3, "um": 1.0, "mm": 1e-3, "m": 1e-6, "deg": 1e-2, "rad": 1e-4, "N/m": 1e4, "N m/rad": 1e4}
# Quotients of steps h and h/2 differ by h^2 f'''/8.  A larger relative difference means that the map is not smooth.
_SMOOTH = 1e-3
# relative rounding of an assembled array
_ROUNDING = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterDerivative:
    """Derivative of a System's numbers per unit of one parameter, or why there is none.

    change : derivatives, per unit of the parameter as written; None where there is none.  problem : "" or the reason.
    """

    parameter: Parameter
    change: SystemNumbers | None
    problem: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SystemDerivatives:
    """A linearised System and its derivatives along parameters.

    system : with an empty line at every frequency that a parameter would excite.  along : one entry a parameter.
    """

    system: System
    along: tuple[ParameterDerivative, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Stencil:
    """Systems at steps of one parameter, and weights of two difference quotients of them of one order.

    coarse, fine : weights of the quotients with steps h and h/2, per unit of the parameter.
    order : of their error.  here : index of the unchanged System.  step : h, in the unit of the parameter.
    """

    systems: tuple[System, ...]
    coarse: tuple[float, ...]
    fine: tuple[float, ...]
    order: int
    here: int
    step: float


def system_derivatives(
    train: Train, parameters: Sequence[Parameter], *, progress: Callable[[float], None] | None = None
) -> SystemDerivatives:
    """Derivatives of the linearised assembly along each parameter; derived here.

    A parameter without derivative holds the reason in place of the derivative.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError, ConvergenceError : the train itself cannot be assembled or linearised.
    """
    base = linear(assemble(train))
    # tolerances, and reasons for what may be removed, move no number of the System but take time to check
    document = {name: table for name, table in train.document.items() if name not in ("tolerance", "assumed")}
    stencils: list[_Stencil | str] = []
    for place, parameter in enumerate(parameters):
        try:
            stencils.append(_stencil(document, base, parameter))
        except (ModelError, ConvergenceError) as error:
            stencils.append(getattr(error, "problem", None) or str(error))
        if progress is not None:
            progress((place + 1) / len(parameters))
    frequencies = [
        line.frequency
        for stencil in stencils
        if isinstance(stencil, _Stencil)
        for system in stencil.systems
        if system.tones == base.tones
        for line in system.lines
    ]
    whole = with_lines(base, tuple(dict.fromkeys(frequencies)))
    return SystemDerivatives(
        system=whole,
        along=tuple(
            _derivative(base, whole, parameter, stencil)
            for parameter, stencil in zip(parameters, stencils, strict=True)
        ),
    )


def _stencil(document: Mapping[str, object], base: System, parameter: Parameter) -> _Stencil:
    """Central differences of second order, else one-sided ones of third order.

    Raises
    ------
    ModelError : the model can go to neither side, or has other degrees of freedom there.
    """
    step = _STEP * abs(parameter.value) or _STEP_AT_ZERO.get(parameter.unit, 1e-3)

    def at(share: float) -> System:
        there = load(document, overrides=parameter.at(parameter.value + share * step))
        system = linear(assemble(there), asks_laws=True)  # its numbers alone: the base has the warnings
        if system.dofs.names != base.dofs.names or system.meshes.name != base.meshes.name:
            raise ModelError("another number of motions beside this value: no derivative")
        return system

    try:
        return _Stencil(
            systems=(at(-1), at(-0.5), base, at(0.5), at(1)),
            coarse=tuple(w / (2 * step) for w in (-1, 0, 0, 0, 1)),
            fine=tuple(w / step for w in (0, -1, 0, 1, 0)),
            order=2,
            here=2,
            step=step,
        )
    except ModelError:
        return _one_sided_stencil(at, base, step)


def _one_sided_stencil(at: Callable[[float], System], base: System, step: float) -> _Stencil:
    """One-sided quotients of third order, (-11 f0 + 18 f1 - 9 f2 + 2 f3) / 6 d, d an eighth and a quarter of the step.

    The side is above the value, or below it where the model cannot go above.
    """
    shares = (0.125, 0.25, 0.375, 0.5, 0.75)
    try:
        side, systems = 1, tuple(at(share) for share in shares)
    except ModelError:
        side, systems = -1, tuple(at(-share) for share in shares)
    d = side * step / 8
    return _Stencil(
        systems=(base, *systems),
        coarse=tuple(w / (12 * d) for w in (-11, 0, 18, 0, -9, 2)),
        fine=tuple(w / (6 * d) for w in (-11, 18, -9, 2, 0, 0)),
        order=3,
        here=0,
        step=abs(d),
    )


def _derivative(base: System, whole: System, parameter: Parameter, stencil: _Stencil | str) -> ParameterDerivative:
    """Richardson extrapolation of the two quotients, refused where they do not agree."""
    if isinstance(stencil, str):
        return ParameterDerivative(parameter=parameter, change=None, problem=stencil)
    try:
        values = [_aligned(system, base, whole) for system in stencil.systems]
        # differences to the value first: an array that does not change has a derivative of exactly zero
        differences = [combined([1.0, -1.0], [value, values[stencil.here]]) for value in values]
        soft = _soft_link_changes(stencil)
        if soft is not None:
            differences = [replace(one, K=K) for one, K in zip(differences, soft, strict=True)]
        coarse, fine = combined(stencil.coarse, differences), combined(stencil.fine, differences)
    except ModelError as error:
        return ParameterDerivative(parameter=parameter, change=None, problem=error.problem)
    power = 2**stencil.order
    change = combined([power / (power - 1), -1 / (power - 1)], [fine, coarse])
    rounded = _without_rounding(change, values[stencil.here], stencil.step)
    change = rounded if soft is None else replace(rounded, K=change.K)
    if any(_differ(name, coarse, change) for name in _NAMES) or _kinked(stencil, values):
        return ParameterDerivative(parameter=parameter, change=None, problem="not smooth at this value: no derivative")
    return ParameterDerivative(parameter=parameter, change=change)


def _soft_link_changes(stencil: _Stencil) -> list[Array] | None:
    """Changes of K (n, n) [N/m] of each system against the unchanged one, from its links; None where K has them.

    A step of a link far softer than the stiffest part is rounding of their sum K, and no rounding of its own rows.
    """
    here = stencil.systems[stencil.here]
    rounding = _ROUNDING * float(np.abs(here.K).max(initial=0.0))
    found = []
    for system in stencil.systems:
        if system.links.name != here.links.name or not np.array_equal(system.links.B, here.links.B):
            return None
        with np.errstate(invalid="ignore"):  # rigid in both
            step = np.nan_to_num(system.links.stiffness - here.links.stiffness)
        change: Array = (here.links.B * step) @ here.links.B.T
        if np.abs(system.K - here.K - change).max(initial=0.0) > rounding:
            return None  # something else changes K too
        found.append(change)
    largest = max(float(np.abs(change).max(initial=0.0)) for change in found)
    return found if 0 < largest and rounding > _SMOOTH * largest else None


def _without_rounding(change: SystemNumbers, value: SystemNumbers, step: float) -> SystemNumbers:
    """Derivatives with zeros for arrays that are rounding of the quotient, below 1e-13 of the value over the step."""
    zeros = {}
    for name in _NAMES:
        array, limit = getattr(change, name), _ROUNDING * float(np.abs(getattr(value, name)).max(initial=0.0)) / step
        if 0 < float(np.abs(array).max(initial=0.0)) <= limit:
            zeros[name] = np.zeros_like(array)
    return replace(change, **zeros)


_NAMES = tuple(field.name for field in fields(SystemNumbers))


def _differ(name: str, coarse: SystemNumbers, change: SystemNumbers) -> bool:
    """Whether coarse quotient and derivative of one array differ by more than those of a smooth function."""
    size = float(np.abs(getattr(change, name)).max(initial=0.0))
    off = float(np.abs(getattr(coarse, name) - getattr(change, name)).max(initial=0.0))
    return size > 0 and off > _SMOOTH * size


def _kinked(stencil: _Stencil, values: Sequence[SystemNumbers]) -> bool:
    """Whether the second difference of an array shrinks with the step, as at a kink, and not with its square."""
    if stencil.order == 3:
        return False
    for name in _NAMES:
        low, below, here, above, high = (getattr(value, name) for value in values)
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
    known = {line.frequency: here for line, here in zip(base.lines, system.lines, strict=True)}
    share = system.tones[0] / base.tones[0] if base.tones[0] else Fraction(1)
    empty = numbers(with_lines(replace(system, lines=()), [line.frequency * share for line in whole.lines]))
    here = numbers(system)
    rows = [place for place, line in enumerate(whole.lines) if line.frequency in known]
    arrays = {name: getattr(empty, name).copy() for name in ("line_frequency", "line_gap", "line_force")}
    for name, array in arrays.items():
        array[rows] = getattr(here, name)
    return replace(empty, **arrays)
