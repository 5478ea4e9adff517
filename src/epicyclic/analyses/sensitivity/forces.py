"""Derivatives of mesh-force measures of the steady response, by one adjoint solution a mesh and speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...questions.response.response import Block, FrameSpeed, Response, respond, response
from ...system.system import Array, System, faces
from .adjoint import adjoint_form, adjoint_parts, measure
from .gradient import Basis, Gradient, basis_of, gradient, rigid_mode_imbalance
from .numbers import SystemNumbers

__all__ = ["ForceDerivatives", "force_derivatives"]

Index = NDArray[np.int64]
# Relative residual asked for: the truncation may be 30 times that, and errs a derivative by some 10 times more.
_TOLERANCE = 1e-10
# The adjoint solution has no truncation, and its residual counts once.
_ADJOINT = 100.0
# Imbalance on a rigid mode: rounding and the error of the difference quotient of a change; 1e-3 of a spring on it.
_FREE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceDerivatives:
    """Values and derivatives of one measure of the mesh forces.

    mesh : (w,) whole meshes.  speed : (P,) relative.  value : (w, P) [N].
    derivative : (changes, w, P) [N per unit]; nan where the value is 0, or where `constrained`.
    constrained : (changes,) whether the change puts a spring on a rigid mode, so that there is no derivative.
    """

    mesh: tuple[str, ...]
    speed: Array
    value: Array
    derivative: Array
    constrained: NDArray[np.bool_]


def force_derivatives(
    system: System,
    changes: Sequence[SystemNumbers],
    *,
    relative_speed: ArrayLike = 1.0,
    harmonic: int | None = None,
    meshes: Sequence[int] | None = None,
    shaft_orders: bool = True,
    frame_speed: FrameSpeed = "kinematic",
    tolerance: float = _TOLERANCE,
) -> ForceDerivatives:
    """RMS of the dynamic mesh force, or the amplitude of one mesh order, and its derivatives along changes.

    Adjoint of the harmonic balance, derived here (module docstrings of `adjoint` and `gradient`).

    Parameters
    ----------
    system : without laws of links (`statics.tangent.linear`), as the changes are.
    changes : derivatives of the System's numbers along each parameter.
    relative_speed : (P,) speeds per operating speed, held while the parameters change.
    harmonic : amplitude of this mesh order instead of the RMS of all frequencies above 0.
    meshes : indices of the whole meshes wanted, all where None.  tolerance : relative residual [1].

    Raises
    ------
    ModelError : no damping, no mesh frequency, a speed not above zero, frequencies that part from each other.
    ConvergenceError : an adjoint solution does not converge.
    """
    ready = response(system, frame_speed=frame_speed)
    selected, speed = _mesh_indices(ready, meshes), _checked_speeds(relative_speed)
    names = tuple(np.array(faces(ready.system.meshes).name, object)[selected])
    value = np.full((selected.size, speed.size), np.nan)
    derivative = np.full((len(changes), selected.size, speed.size), np.nan)
    constrained = np.zeros(len(changes), bool)
    basis = basis_of(ready)
    for block, rows, square, found in _gradients(
        ready, basis, speed, selected, harmonic=harmonic, shaft_orders=shaft_orders, tolerance=tolerance
    ):
        size, slope = _roots(square, harmonic)
        value[np.ix_(rows, block.index)] = size
        for place, change in enumerate(changes):
            _check_frequencies(ready, block, change)
            constrained[place] |= bool(np.any(rigid_mode_imbalance(ready, basis, block, change) > _FREE))
            derivative[place][np.ix_(rows, block.index)] = slope * found.along(ready, basis, change)
    derivative[constrained] = np.nan
    return ForceDerivatives(mesh=names, speed=speed, value=value, derivative=derivative, constrained=constrained)


def _gradients(
    ready: Response,
    basis: Basis,
    speed: Array,
    selected: Index,
    *,
    harmonic: int | None,
    shaft_orders: bool,
    tolerance: float,
) -> Iterator[tuple[Block, Index, Array, Gradient]]:
    """Block, rows of the wanted meshes (O,), their Q (O, P) [N^2] and its gradient, as they come out."""
    adjoint_modal = adjoint_form(ready.modal)
    for block in respond(ready, speed, tolerance=tolerance, shaft_orders=shaft_orders and harmonic is None):
        known = measure(ready, block, harmonic=harmonic)
        for some, parts in adjoint_parts(
            ready, adjoint_modal, block, known, meshes=selected, tolerance=_ADJOINT * tolerance
        ):
            rows = np.flatnonzero(np.isin(selected, some))
            yield block, rows, known.square[some], gradient(ready, basis, block, parts)


def _roots(square: Array, harmonic: int | None) -> tuple[Array, Array]:
    """RMS = sqrt(Q) or amplitude = sqrt(2 Q) of Q (O, P) [N^2], and its slope over Q, nan where Q is 0."""
    factor = 1.0 if harmonic is None else 2.0
    size = np.sqrt(factor * square)
    return size, np.where(size > 0, factor / (2 * np.where(size > 0, size, 1.0)), np.nan)


def _mesh_indices(ready: Response, meshes: Sequence[int] | None) -> Index:
    """Indices of the wanted whole meshes, (O,)."""
    count = len(faces(ready.system.meshes).name)
    return np.arange(count) if meshes is None else np.asarray(meshes, np.int64)


def _checked_speeds(relative_speed: ArrayLike) -> Array:
    """Relative speeds (P,) [1].

    Raises
    ------
    ModelError : none, or one that is not finite and above zero.
    """
    speed = np.atleast_1d(np.asarray(relative_speed, dtype=float))
    if not speed.size or not np.all(np.isfinite(speed) & (speed > 0)):
        raise ModelError("speeds must be finite and above zero", path="relative_speed", given=relative_speed)
    return speed


def _check_frequencies(ready: Response, block: Block, change: SystemNumbers) -> None:
    """Refuse a change that parts frequencies which the solution adds up, or solves together.

    Raises
    ------
    ModelError : coinciding frequencies part as the speed changes.
    """
    if not change.tones.any() and not change.line_frequency.any():
        return
    system = ready.system
    known = np.array([float(f) for f in (*system.tones, *(line.frequency for line in system.lines))])
    moved = np.concatenate([change.tones, change.line_frequency])
    share = moved[known > 0] / known[known > 0]
    limit = 1e-7 * float(np.abs(share).max(initial=0.0))  # difference quotients of exact frequencies
    if np.ptp(share) <= limit:
        return
    place = {id(line): r for r, line in enumerate(system.lines)}
    axes = np.array([change.tones[system.tones.index(tone)] for tone in ready.lines.tones])
    off = [change.line_frequency[place[id(line)]] - np.dot(point, axes) for point, line in ready.lines.mesh]
    for shaft in ready.lines.shaft:
        base = change.line_frequency[place[id(shaft.members[0][2])]]
        off += [
            change.line_frequency[place[id(line)]] - np.dot(point, axes) + (base if conjugate else -base)
            for point, conjugate, line in shaft.members
        ]
    merged = ready.line_frequencies(block.truncation, shafts=block.shaft is not None, truncated=True).coincident
    if merged or np.abs(off).max(initial=0.0) > limit * float(known.max(initial=0.0)):
        raise ModelError("frequencies that meet at this speed part when it changes: no derivative")
