"""Excitation of a train: errors, displaced features, loads, gravity, unbalance, as lines of exact frequency.

Lines at rest of single deviations, one by one: columns of maps that are linear in the deviations.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..train.train import Displacement, Load, MeshError, Train
from .elimination import eliminate
from .structure import Structure, own_centres, structure_of
from .system import Line


def unit_lines(train: Train, deviations: Sequence[Displacement | MeshError]) -> tuple[Line, ...]:
    """One line for each deviation: gaps and the force at rest (``force[0]``); no part that grows with speed.

    Their arrays have the rows and coordinates of ``assemble(train)``.

    Raises
    ------
    ModelError : as of `assemble`.
    """
    structure = structure_of(train)
    T, S, _ = eliminate(structure.rigid, structure.pivots)
    six = 6 * len(train.bodies)
    still, none = np.zeros((six, six)), np.zeros(len(structure.links))
    model = FullModel(
        T=T,
        S=S,
        mass=np.zeros((len(train.bodies), 6)),
        G=still,
        Kg=still,
        euler=still,
        mass_damping=0.0,
        link_stiffness=np.array([0.0 if row.law else row.stiffness for row in structure.links]),
        link_damping=none,
        skew=still,
    )
    return separate_lines(deviations, structure, model)


Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullModel:
    """Unreduced matrices that the excitation needs.

    T : (6 nb, n).  S : (6 nb, c).  mass : (nb, 6) [kg, kg m^2].  G, Kg, euler, skew : (6 nb, 6 nb).
    mass_damping : [1/s].  link_stiffness : (p,) [N/m], 0 in rows with a law, whose force is not on the right side.
    link_damping : (p,) [N s/m].
    """

    T: Array
    S: Array
    mass: Array
    G: Array
    Kg: Array
    euler: Array
    mass_damping: float
    link_stiffness: Array
    link_damping: Array
    skew: Array


@dataclass(slots=True)
class _LineParts:
    """Amplitudes at one frequency, in unreduced rows.  An error of a mesh itself is on one of its flanks.

    mesh (m,), far (c,), link (p,), rigid (r,) : errors of the rows [m].  force : (3, 6 nb) by power of s and
    ramp : (6 nb,) per s' [N, N m].
    """

    mesh: ComplexArray
    far: ComplexArray
    link: ComplexArray
    rigid: ComplexArray
    force: ComplexArray
    ramp: ComplexArray
    causes: list[str] = field(default_factory=list)


def excitation_lines(train: Train, structure: Structure, model: FullModel) -> tuple[Line, ...]:
    """Every line of the excitation, frequencies rising, amplitudes of one frequency added.

    Raises
    ------
    ModelError : a displacement that rigid connections do not admit.
    """
    lines: dict[Fraction, _LineParts] = {}
    for displacement in train.displacements:
        _add_displacement(lines, displacement, structure)
    names = np.array([row.whole for row in structure.meshes])
    for error in train.mesh_errors:
        _add_mesh_error(lines, error, names, structure)
    for load in train.loads:
        _add_load(lines, load, structure, train)
    if any(train.gravity):
        _add_gravity(lines, structure, train, model)
    _add_centrifugal(lines, structure, train, model)
    return tuple(_line(f, parts, structure, model) for f, parts in sorted(lines.items()))


def separate_lines(
    deviations: Sequence[Displacement | MeshError], structure: Structure, model: FullModel
) -> tuple[Line, ...]:
    """A line of its own for each deviation, in their order.

    Raises
    ------
    ModelError : a displacement that rigid connections do not admit.
    """
    names = np.array([row.whole for row in structure.meshes])
    result = []
    for item in deviations:
        lines: dict[Fraction, _LineParts] = {}
        if isinstance(item, Displacement):
            _add_displacement(lines, item, structure)
        else:
            _add_mesh_error(lines, item, names, structure)
        ((frequency, parts),) = lines.items()
        result.append(_line(frequency, parts, structure, model))
    return tuple(result)


def _line_at(
    lines: dict[Fraction, _LineParts], frequency: Fraction, vector: ComplexArray, cause: str, structure: Structure
) -> tuple[_LineParts, ComplexArray]:
    """Line of |frequency|, and the amplitude (...) of the positive frequency, conjugated for a negative one."""
    if frequency < 0:
        frequency, vector = -frequency, vector.conj()
    elif frequency == 0:
        vector = vector.real.astype(complex)
    if frequency not in lines:
        lines[frequency] = _LineParts(
            mesh=np.zeros(len(structure.mesh), complex),
            far=np.zeros(len(structure.far), complex),
            link=np.zeros(len(structure.link), complex),
            rigid=np.zeros(len(structure.rigid), complex),
            force=np.zeros((3, structure.mesh.shape[1]), complex),
            ramp=np.zeros(structure.mesh.shape[1], complex),
        )
    parts = lines[frequency]
    if cause not in parts.causes:
        parts.causes.append(cause)
    return parts, vector


def _add_displacement(lines: dict[Fraction, _LineParts], item: Displacement, structure: Structure) -> None:
    """Add e = -(row of the displaced body) . E to every row that the feature enters (docs/conventions.md, errors).

    A displaced seat has the opposite sign: the row of the other side is minus that of the body at the same point.
    """
    parts, vector = _line_at(lines, item.frequency, item.vector, item.path, structure)
    body = structure.index[item.body]
    columns = slice(6 * body, 6 * body + 6)
    if item.rows == "mesh":
        parts.mesh -= structure.mesh[:, columns] @ vector
        parts.far -= structure.far[:, columns] @ vector
        return
    sign = -1.0 if item.rows == "own" else 1.0
    wanted = set(item.links)
    for matrix, rows, target in (
        (structure.link, structure.links, parts.link),
        (structure.rigid, structure.rigids, parts.rigid),
    ):
        for i, row in enumerate(rows):
            if row.link in wanted:
                target[i] += sign * (matrix[i, columns] @ vector)


def _add_mesh_error(
    lines: dict[Fraction, _LineParts], error: MeshError, names: NDArray[np.str_], structure: Structure
) -> None:
    """Add the error of a mesh to the rows of one of its flanks; names : (m,) whole mesh of each row."""
    parts, amplitude = _line_at(lines, error.frequency, np.array(error.amplitude), error.path, structure)
    if error.far:
        parts.far[names[structure.far_of] == error.mesh] += complex(amplitude)
    else:
        parts.mesh[names == error.mesh] += complex(amplitude)


def _rotating_amplitude(vector: Array, sense: int) -> ComplexArray:
    """Amplitude (2,) of the lateral part of a vector (3,) that rotates by phi (sense +1) or -phi (sense -1).

    Re(result exp(i phi)) is (vx cos phi - vy sin phi, vx sin phi + vy cos phi) for sense +1, in the unit of the vector.
    """
    x, y = vector[0], vector[1]
    return np.array([x + 1j * sense * y, y - 1j * sense * x])


def _across_and_along(force: Array, moment: Array) -> Iterator[tuple[Array, Array, bool]]:
    """Lateral and axial parts of a force (3,) [N] and a moment (3,) [N m], and whether the part is lateral."""
    across = np.array([1.0, 1.0, 0.0])
    yield force * across, moment * across, True
    yield force * (1 - across), moment * (1 - across), False


def _add_load(lines: dict[Fraction, _LineParts], load: Load, structure: Structure, train: Train) -> None:
    body = structure.index[load.body]
    item = train.bodies[body]
    force, moment = np.array(load.force), np.array(load.moment)
    arm = load.station - item.station
    moment = moment + np.array([-arm * force[1], arm * force[0], 0.0])
    relative = structure.spin_turn[body] - structure.frame_turn[body]
    frequency, sense = (relative, 1) if load.turns else (structure.frame_turn[body], -1)
    # A load turning with the body is given in the body's own axes; one fixed in space in the housing's.
    phase = load.phase if load.turns else item.angle
    motion = frequency, sense, phase
    _add_force(lines, load.path, body, (force, moment), motion, structure, int(load.speed_squared) * 2)
    spin = structure.spin[body]
    if load.speed_squared and spin:
        # an eccentric mass lags its own acceleration: m e w' stands a quarter turn behind m e w^2
        behind = np.array([force[1], -force[0], 0.0]) / spin, np.array([moment[1], -moment[0], 0.0]) / spin
        _add_force(lines, load.path, body, behind, motion, structure, None)


def _add_force(
    lines: dict[Fraction, _LineParts],
    path: str,
    body: int,
    wrench: tuple[Array, Array],
    motion: tuple[Fraction, int, float],
    structure: Structure,
    power: int | None,
) -> None:
    """Add a force and moment, (3,) each [N, N m], that scales with a power of the speed, or its rate of change (None).

    motion : frequency [Hz], sense and phase [rad] of the rotation.
    """
    frequency, sense, phase = motion
    for force, moment, across in _across_and_along(*wrench):
        if not (force.any() or moment.any()):
            continue
        vector = np.zeros(6, complex)
        if across:
            turn = np.exp(1j * phase)
            vector[:2], vector[3:5] = (
                _rotating_amplitude(force, sense) * turn,
                _rotating_amplitude(moment, sense) * turn,
            )
        else:
            vector[2], vector[5] = force[2], moment[2]
        parts, amplitude = _line_at(lines, frequency if across else Fraction(0), vector, path, structure)
        target = parts.ramp if power is None else parts.force[power]
        target[6 * body : 6 * body + 6] += amplitude


def _add_gravity(lines: dict[Fraction, _LineParts], structure: Structure, train: Train, model: FullModel) -> None:
    gravity = np.array(train.gravity)
    for i, body in enumerate(train.bodies):
        wrench = model.mass[i, 0] * gravity, np.zeros(3)
        _add_force(lines, "operation.gravity", i, wrench, (structure.frame_turn[i], -1, body.angle), structure, 0)


def _add_centrifugal(lines: dict[Fraction, _LineParts], structure: Structure, train: Train, model: FullModel) -> None:
    """Add m Omega^2 r_c of every body whose centre is off the axis of its turning frame: what its bearing holds."""
    for i, (body, centre) in enumerate(zip(train.bodies, own_centres(train), strict=True)):
        outward = model.mass[i, 0] * structure.frame_speed[i] ** 2 * np.append(centre, 0.0)
        standing = Fraction(0), 1, 0.0
        _add_force(lines, f"stages.{body.member}.mass", i, (outward, np.zeros(3)), standing, structure, 2)


def _line(frequency: Fraction, parts: _LineParts, structure: Structure, model: FullModel) -> Line:
    """Reduced line: displaced rigid connections move the bodies, which enters every other row and the inertia."""
    omega = 2 * math.pi * float(frequency)
    shift = model.S @ parts.rigid
    if parts.rigid.any():
        miss = np.abs(structure.rigid @ shift - parts.rigid).max()
        if miss > 1e-9 * np.abs(parts.rigid).max():
            raise ModelError(
                "rigid connections do not admit this displacement", path=parts.causes[0], allowed="an elastic support"
            )
    mesh = parts.mesh - structure.mesh @ shift
    link = parts.link - structure.link @ shift
    force = parts.force.copy()
    force[0] += structure.link.T @ (model.link_stiffness * link)
    force[1] += structure.link.T @ (1j * omega * model.link_damping * link) - model.skew @ shift
    inertia = model.mass.ravel()
    force[1] -= 1j * omega * model.mass_damping * inertia * shift
    force[2] += omega**2 * inertia * shift - 1j * omega * (model.G @ shift) - model.Kg @ shift
    # the acceleration of a displaced body has a part in s' too, and so has the frame that accelerates with it
    ramp = parts.ramp - 1j * omega * inertia * shift - model.euler @ shift
    law = np.array([row.law for row in structure.links], dtype=bool)
    return Line(
        frequency=frequency,
        gap=mesh,
        link_gap=link[~law],
        force=force @ model.T,
        causes=tuple(sorted(parts.causes)),
        group_gap=link[law],
        ramp_force=ramp @ model.T,
        far_gap=parts.far - structure.far @ shift,
    )
