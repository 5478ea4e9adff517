"""Derivatives of mesh-force measures of the steady response, by one adjoint solution a mesh and speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.faces import faces
from ...system.system import Array, System
from ..steady.response import Block, FrameSpeed, Response, respond, response
from .adjoint import adjoint_form, adjoint_parts, measure
from .gradient import Basis, Gradient, basis_of, gradient, rigid_mode_imbalance
from .numbers import Numbers

__all__ = ["ForceDerivatives", "StiffnessGradient", "force_derivatives", "stiffness_gradient"]

Index = NDArray[np.int64]
# Relative residual asked for: what may be dropped is 30 times that, and a derivative feels it some 10 times more.
_TOLERANCE = 1e-10
# Of the adjoint solution nothing is dropped, and its residual counts once.
_ADJOINT = 100.0
# A change leaves rounding and the error of its own difference quotient on a free motion; a spring on it leaves 1e-3.
_FREE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceDerivatives:
    """Values and derivatives of one measure of the mesh forces.

    mesh : (w,) whole meshes.  speed : (P,) relative.  value : (w, P) [N].
    derivative : (changes, w, P) [N per unit]; nan where the value is 0, or where `constrained`.
    held : (changes,) whether the change takes hold of a motion that is free, so that there is no derivative.
    """

    mesh: tuple[str, ...]
    speed: Array
    value: Array
    derivative: Array
    constrained: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StiffnessGradient:
    """Derivatives of the measure of every whole mesh with respect to single numbers of the System.

    mesh : (w,).  speed : (P,).  value : (w, P) [N].
    stiffness : (w, P, m) of mean mesh stiffness [N per N/m].  variation : (w, P, m) of a factor on all harmonics [N].
    mesh_damping : (w, P, m).  link_stiffness, link_damping : (w, P, p) of each link row.
    mass : (w, P, n) of each diagonal entry of M.  zeta : (w, P).  speed_factor : (w, P) of a factor on all tones and
    shaft frequencies, terms of the turning frame held [N].  error : (w, P, R) of a factor on each line.
    """

    mesh: tuple[str, ...]
    speed: Array
    value: Array
    stiffness: Array
    variation: Array
    mesh_damping: Array
    link_stiffness: Array
    link_damping: Array
    mass: Array
    zeta: Array
    speed_factor: Array
    error: Array


def force_derivatives(
    system: System,
    changes: Sequence[Numbers],
    *,
    relative_speed: ArrayLike = 1.0,
    harmonic: int | None = None,
    meshes: Sequence[int] | None = None,
    shaft_orders: bool = True,
    frame_speed: FrameSpeed = "kinematic",
    tolerance: float = _TOLERANCE,
) -> ForceDerivatives:
    """RMS of the dynamic mesh force, or the amplitude of one mesh order, and its derivatives along changes.

    Parameters
    ----------
    system : without laws of links (`linear.linearised`), as the changes are.
    changes : derivatives of the System's numbers along each parameter.
    relative_speed : (P,) speeds per operating speed, held while the parameters change.
    harmonic : amplitude of this mesh order instead of the RMS of all that moves.
    meshes : numbers of the whole meshes wanted, all where None.

    Raises
    ------
    ModelError : no damping, no mesh frequency, a speed not above zero, frequencies that part from each other.
    ConvergenceError : an adjoint solution does not converge.
    """
    ready = response(system, frame_speed=frame_speed)
    wanted, speed = _wanted(ready, meshes), _speeds(relative_speed)
    names = tuple(np.array(faces(ready.system.meshes).name, object)[wanted])
    value = np.full((wanted.size, speed.size), np.nan)
    derivative = np.full((len(changes), wanted.size, speed.size), np.nan)
    constrained = np.zeros(len(changes), bool)
    basis = basis_of(ready)
    for block, rows, square, found in _gradients(
        ready, basis, speed, wanted, harmonic=harmonic, shaft_orders=shaft_orders, tolerance=tolerance
    ):
        size, slope = _roots(square, harmonic)
        value[np.ix_(rows, block.index)] = size
        for place, change in enumerate(changes):
            _check_frequencies(ready, block, change)
            constrained[place] |= bool(np.any(rigid_mode_imbalance(ready, basis, block, change) > _FREE))
            derivative[place][np.ix_(rows, block.index)] = slope * found.along(ready, basis, change)
    derivative[constrained] = np.nan
    return ForceDerivatives(mesh=names, speed=speed, value=value, derivative=derivative, constrained=constrained)


def stiffness_gradient(
    system: System,
    *,
    relative_speed: ArrayLike = 1.0,
    harmonic: int | None = None,
    meshes: Sequence[int] | None = None,
    shaft_orders: bool = True,
    frame_speed: FrameSpeed = "kinematic",
    tolerance: float = _TOLERANCE,
) -> StiffnessGradient:
    """The same measure's derivatives with respect to single stiffnesses, dampers, masses, errors and the speed.

    Options and errors are those of `force_derivatives`.
    """
    ready = response(system, frame_speed=frame_speed)
    wanted, speed, basis = _wanted(ready, meshes), _speeds(relative_speed), basis_of(ready)
    found: dict[str, Array] = {}
    for block, rows, square, one in _gradients(
        ready, basis, speed, wanted, harmonic=harmonic, shaft_orders=shaft_orders, tolerance=tolerance
    ):
        size, slope = _roots(square, harmonic)
        parts = {"value": size} | {name: (values.T * slope.T).T for name, values in _singles(ready, basis, one).items()}
        for name, values in parts.items():
            table = found.setdefault(name, np.full((wanted.size, speed.size, *values.shape[2:]), np.nan))
            table[np.ix_(rows, block.index)] = values
    names = tuple(np.array(faces(ready.system.meshes).name, object)[wanted])
    return StiffnessGradient(mesh=names, speed=speed, **found)


def _gradients(
    ready: Response,
    basis: Basis,
    speed: Array,
    wanted: Index,
    *,
    harmonic: int | None,
    shaft_orders: bool,
    tolerance: float,
) -> Iterator[tuple[Block, Index, Array, Gradient]]:
    """Block, rows of the wanted meshes, their Q (O, P) and its gradient, as they come out."""
    turned = adjoint_form(ready.modal)
    for block in respond(ready, speed, tolerance=tolerance, shaft_orders=shaft_orders and harmonic is None):
        known = measure(ready, block, harmonic=harmonic)
        for some, parts in adjoint_parts(ready, turned, block, known, meshes=wanted, tolerance=_ADJOINT * tolerance):
            rows = np.flatnonzero(np.isin(wanted, some))
            yield block, rows, known.square[some], gradient(ready, basis, block, parts)


def _roots(square: Array, harmonic: int | None) -> tuple[Array, Array]:
    """RMS = sqrt(Q) or amplitude = sqrt(2 Q), and its slope over Q, nan where Q is 0."""
    factor = 1.0 if harmonic is None else 2.0
    size = np.sqrt(factor * square)
    return size, np.where(size > 0, factor / (2 * np.where(size > 0, size, 1.0)), np.nan)


def _singles(ready: Response, basis: Basis, one: Gradient) -> dict[str, Array]:
    system, Phi = ready.system, basis.shapes
    links, B = Phi.T @ system.links.B, Phi.T @ system.meshes.B
    mean = np.einsum("im,opij,jm->opm", B, one.mean, B)
    tones = np.array([float(tone) for tone in system.tones])
    lines = np.array([float(line.frequency) for line in system.lines])
    gaps = np.array([line.gap for line in system.lines]).reshape(len(lines), -1)
    pushes = np.array([line.force for line in system.lines]).reshape(len(lines), 3, -1) @ Phi
    error = np.einsum("oprm,rm->opr", one.line_gap.conj(), gaps).real
    error += np.einsum("oprkn,rkn->opr", one.line_force.conj(), pushes).real
    return {
        "stiffness": one.stiffness + mean,
        "variation": np.einsum("opml,ml->opm", one.variation.conj(), system.meshes.variation).real,
        "mesh_damping": one.damping,
        "link_stiffness": np.einsum("ik,opij,jk->opk", links, one.K + one.mean, links),
        "link_damping": np.einsum("ik,opij,jk->opk", links, one.C, links),
        "mass": np.einsum("ri,opij,rj->opr", Phi, one.M, Phi),
        "zeta": one.zeta,
        "speed_factor": one.tones @ tones + one.lines @ lines,
        "error": error,
    }


def _wanted(ready: Response, meshes: Sequence[int] | None) -> Index:
    count = len(faces(ready.system.meshes).name)
    return np.arange(count) if meshes is None else np.asarray(meshes, np.int64)


def _speeds(relative_speed: ArrayLike) -> Array:
    speed = np.atleast_1d(np.asarray(relative_speed, dtype=float))
    if not speed.size or not np.all(np.isfinite(speed) & (speed > 0)):
        raise ModelError("speeds must be finite and above zero", path="relative_speed", given=relative_speed)
    return speed


def _check_frequencies(ready: Response, block: Block, change: Numbers) -> None:
    """Raise where lines that the solution adds up, or solves together, do not stay together as the speed changes."""
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
            change.line_frequency[place[id(line)]] - np.dot(point, axes) + (base if turned else -base)
            for point, turned, line in shaft.members
        ]
    merged = ready.line_frequencies(block.truncation, shafts=block.shaft is not None, truncated=True).coincident
    if merged or np.abs(off).max(initial=0.0) > limit * float(known.max(initial=0.0)):
        raise ModelError("frequencies that meet at this speed part when it changes: no derivative")
