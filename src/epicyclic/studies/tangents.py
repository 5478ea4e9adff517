"""Derivatives of a System along numbers of its model file: central differences of the assembly, extrapolated.

The way from the file to the matrices is smooth and exact to rounding, so that differences with steps h and h/2
(h = 1e-3 of the value) give its derivative to about 1e-10.  Where a value may not go to both sides, differences to one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction

import numpy as np

from ..analyses.sensitivity.numbers import Numbers, combined, numbers, with_lines
from ..analyses.static.tangent import linearised
from ..assemble import assemble
from ..errors import ConvergenceError, ModelError
from ..resolve import load
from ..system.system import System
from ..train.train import Train
from .parameters import Parameter

__all__ = ["Tangent", "Tangents", "tangents"]

_STEP = 1e-3
# a step for a value of 0, in the unit it is written in
_FROM_ZERO = {"": 1e-3, "um": 1.0, "mm": 1e-3, "m": 1e-6, "deg": 1e-2, "rad": 1e-4, "N/m": 1e4, "N m/rad": 1e4}
# Quotients of steps h and h/2 differ by h^2 f'''/8: where they differ by more than this the number is not smooth there.
_SMOOTH = 1e-3
_ROUNDING = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tangent:
    """The derivative of a System's numbers per unit of one parameter, or why there is none.

    change : None where there is none.  problem : "" or the reason.
    """

    parameter: Parameter
    change: Numbers | None
    problem: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tangents:
    """A System without laws of links, with an empty line wherever a parameter would put one, and its tangents."""

    system: System
    along: tuple[Tangent, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Stencil:
    """Systems at some steps of one parameter, and the weights of two difference quotients of them, of one order;
    here : which is the value itself."""

    systems: tuple[System, ...]
    coarse: tuple[float, ...]
    fine: tuple[float, ...]
    order: int
    here: int
    step: float


def tangents(
    train: Train, parameters: Sequence[Parameter], *, progress: Callable[[float], None] | None = None
) -> Tangents:
    """Differentiate the assembly along each parameter.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError, ConvergenceError : the train itself cannot be assembled or linearised.
    """
    base = linearised(assemble(train))
    stencils: list[_Stencil | str] = []
    for place, parameter in enumerate(parameters):
        try:
            stencils.append(_stencil(train.document, base, parameter))
        except (ModelError, ConvergenceError) as error:
            stencils.append(getattr(error, "problem", None) or str(error))
        if progress is not None:
            progress((place + 1) / len(parameters))
    added = [
        line.frequency
        for stencil in stencils
        if isinstance(stencil, _Stencil)
        for system in stencil.systems
        if system.tones == base.tones
        for line in system.lines
    ]
    whole = with_lines(base, tuple(dict.fromkeys(added)))
    return Tangents(
        system=whole,
        along=tuple(
            _tangent(base, whole, parameter, stencil) for parameter, stencil in zip(parameters, stencils, strict=True)
        ),
    )


def _stencil(document: Mapping[str, object], base: System, parameter: Parameter) -> _Stencil:
    step = _STEP * abs(parameter.value) or _FROM_ZERO.get(parameter.unit, 1e-3)

    def at(share: float) -> System:
        system = linearised(assemble(load(document, overrides=parameter.at(parameter.value + share * step))))
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
        return _to_one_side(at, base, step)


def _to_one_side(at: Callable[[float], System], base: System, step: float) -> _Stencil:
    """Quotients of third order, (-11 f0 + 18 f1 - 9 f2 + 2 f3) / 6 d, with d an eighth and a quarter of the step."""
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


def _tangent(base: System, whole: System, parameter: Parameter, stencil: _Stencil | str) -> Tangent:
    """Extrapolate the two quotients, and see whether they agree."""
    if isinstance(stencil, str):
        return Tangent(parameter=parameter, change=None, problem=stencil)
    try:
        values = [_aligned(system, base, whole) for system in stencil.systems]
        # what does not change is to leave nothing behind, so the value itself goes first
        moved = [combined([1.0, -1.0], [value, values[stencil.here]]) for value in values]
        coarse, fine = combined(stencil.coarse, moved), combined(stencil.fine, moved)
    except ModelError as error:
        return Tangent(parameter=parameter, change=None, problem=error.problem)
    power = 2**stencil.order
    change = combined([power / (power - 1), -1 / (power - 1)], [fine, coarse])
    change = _without_rounding(change, values[stencil.here], stencil.step)
    if any(_differ(name, coarse, change) for name in _NAMES) or _kinked(stencil, values):
        return Tangent(parameter=parameter, change=None, problem="not smooth at this value: no derivative")
    return Tangent(parameter=parameter, change=change)


def _without_rounding(change: Numbers, value: Numbers, step: float) -> Numbers:
    """Arrays whose derivative is rounding of the quotient, 1e-13 of the value over the step, as exact zeros."""
    gone = {}
    for name in _NAMES:
        array, limit = getattr(change, name), _ROUNDING * float(np.abs(getattr(value, name)).max(initial=0.0)) / step
        if 0 < float(np.abs(array).max(initial=0.0)) <= limit:
            gone[name] = np.zeros_like(array)
    return replace(change, **gone)


_NAMES = tuple(field.name for field in fields(Numbers))


def _differ(name: str, coarse: Numbers, change: Numbers) -> bool:
    """Whether the quotients of one array differ by more than those of a smooth function do."""
    size = float(np.abs(getattr(change, name)).max(initial=0.0))
    off = float(np.abs(getattr(coarse, name) - getattr(change, name)).max(initial=0.0))
    return size > 0 and off > _SMOOTH * size


def _kinked(stencil: _Stencil, values: Sequence[Numbers]) -> bool:
    """Whether the second difference shrinks like a kink's, with the step, instead of with its square."""
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


def _aligned(system: System, base: System, whole: System) -> Numbers:
    """Numbers of a system with a line for each of those of `whole`: of the same frequency, or where the speeds differ
    of the same place in the order.

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
