"""Excitation of a train: errors, displaced features, loads, gravity, unbalance, as lines of exact frequency.

Each is added in unreduced rows to its line; a line is then reduced as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from ..errors import ModelError
from ..train.train import Body, Displacement, Load, MeshError, Ripple, Train
from .structure import Structure, own_centres, structure_of
from .system import Array, ComplexArray, Line, eliminate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullModel:
    """Unreduced matrices of bodies and links.

    T : (N, n).  S : (N, c).  mass : (nb, 6) of rigid bodies [kg, kg m^2].  G, Kg, euler, and bent_mass, what bodies
    that bend have beside that : (N, N); bent_damping, bent_skew : their material damping at rest and at s = 1.
    mass_damping : [1/s].  link_stiffness : (p,) [N/m], 0 in rows with a law, whose force is not on the right side.
    link_damping : (p,) [N s/m].  turning : (p, p) of dampers to the housing, as of `LinkRows.skew` [N/m].
    """

    T: Array
    S: Array
    mass: Array
    bent_mass: Array
    bent_damping: Array
    bent_skew: Array
    G: Array
    Kg: Array
    euler: Array
    mass_damping: float
    link_stiffness: Array
    link_damping: Array
    turning: Array

    @property
    def diagonal(self) -> Array:
        """Mass and inertia of every rigid coordinate, 0 of others, (N,)."""
        return np.concatenate([self.mass.ravel(), np.zeros(len(self.T) - self.mass.size)])


@dataclass(slots=True)
class _FullLine:
    """Amplitudes at one frequency, in unreduced rows.  An error of a mesh itself is on one of its flanks.

    mesh (m,), far (c,), link (p,), rigid (r,), passing (q,) : errors of the rows [m].  force : (3, N) by power of s and
    ramp : (N,) per s' [N, N m].  ripple : (N,) torques beside them [N m].
    """

    mesh: ComplexArray
    far: ComplexArray
    link: ComplexArray
    rigid: ComplexArray
    passing: ComplexArray
    force: ComplexArray
    ramp: ComplexArray
    ripple: ComplexArray
    causes: list[str] = field(default_factory=list)


class _Lines:
    """Unreduced lines of a structure, by frequency [Hz]."""

    def __init__(self, structure: Structure, bodies: Sequence[Body]) -> None:
        self.structure = structure
        self.bodies = bodies
        self.by_frequency: dict[Fraction, _FullLine] = {}

    def at(self, frequency: Fraction, vector: ComplexArray, *causes: str) -> tuple[_FullLine, ComplexArray]:
        """Line of |frequency|, and the amplitude (...) of the positive frequency, conjugated for a negative one."""
        if frequency < 0:
            frequency, vector = -frequency, vector.conj()
        elif frequency == 0:
            vector = vector.real.astype(complex)
        if frequency not in self.by_frequency:
            rows, size = self.structure, self.structure.mesh.shape[1]
            kinds = (rows.mesh, rows.far, rows.link, rows.rigid, rows.passing)
            mesh, far, link, rigid, passing = (np.zeros(len(kind), complex) for kind in kinds)
            force, ramp, ripple = np.zeros((3, size), complex), *np.zeros((2, size), complex)
            self.by_frequency[frequency] = _FullLine(mesh, far, link, rigid, passing, force, ramp, ripple)
        full = self.by_frequency[frequency]
        full.causes += [cause for cause in causes if cause not in full.causes]
        return full, vector

    def displace(self, feature: Displacement) -> None:
        """Add e = -(row of the displaced body) . E to every row that the feature enters (docs/conventions.md, errors).

        A displaced seat has the opposite sign: the row of the other side is minus that of the body at the same point.
        """
        structure = self.structure
        full, vector = self.at(feature.frequency, feature.vector, feature.path)
        body = structure.index[feature.body]
        columns = slice(6 * body, 6 * body + 6)
        if feature.rows == "mesh":
            full.mesh -= structure.mesh[:, columns] @ vector
            full.far -= structure.far[:, columns] @ vector
            return
        sign = -1.0 if feature.rows == "own" else 1.0
        moved = [(columns, vector)]
        for i, place in enumerate(self.bodies):
            if place.shaft_of == feature.body:  # on its shaft, which a tilt about the centre of the body displaces
                lever = place.station - self.bodies[body].station
                off = lever * np.array([vector[4], -vector[3], 0, 0, 0, 0])
                moved.append((slice(6 * i, 6 * i + 6), vector + off))
        links = set(feature.links)
        for matrix, drawn, target in (
            (structure.link, [row.drawn for row in structure.links], full.link),
            (structure.rigid, [row.drawn for row in structure.rigids], full.rigid),
            (structure.passing, [row.drawn for row in structure.passings], full.passing),
        ):
            for i, name in enumerate(drawn):
                if name in links:
                    target[i] += sign * sum(matrix[i, columns] @ motion for columns, motion in moved)

    def mesh_error(self, error: MeshError) -> None:
        """Add the error of a mesh to the rows of one of its flanks."""
        full, amplitude = self.at(error.frequency, np.array(error.amplitude), error.path)
        rows = np.array([row.whole == error.mesh for row in self.structure.meshes], bool)
        if error.far:
            full.far[rows[self.structure.far_of]] += complex(amplitude)
        else:
            full.mesh[rows] += complex(amplitude)

    def ripple(self, ripple: Ripple) -> None:
        """Add a torque about z of a body, or the angle that its rigid link prescribes."""
        full, amplitude = self.at(ripple.frequency, np.array(ripple.amplitude), ripple.path)
        if not ripple.link:
            full.ripple[6 * self.structure.index[ripple.body] + 5] += complex(amplitude)
        for i, row in enumerate(self.structure.rigids):
            if row.link.name == ripple.link:
                full.rigid[i] += complex(amplitude)

    def push(
        self, body: int, wrench: tuple[Array, Array], motion: tuple[Fraction, int, float], power: int | None, cause: str
    ) -> None:
        """Add a force and moment, (3,) each [N, N m], by a power of the speed, or its rate of change (None).

        motion : frequency [Hz], sense and phase [rad] of the rotation.
        """
        frequency, sense, phase = motion
        force, moment = wrench
        across, along = np.zeros(6, complex), np.zeros(6, complex)
        if force[:2].any() or moment[:2].any():
            turn = np.exp(1j * phase)
            across[:2] = _rotating_amplitude(force, sense) * turn
            across[3:5] = _rotating_amplitude(moment, sense) * turn
        along[2], along[5] = force[2], moment[2]
        for vector, tone in ((across, frequency), (along, Fraction(0))):
            if vector.any():
                full, amplitude = self.at(tone, vector, cause)
                target = full.ramp if power is None else full.force[power]
                target[6 * body : 6 * body + 6] += amplitude


def _rotating_amplitude(vector: Array, sense: int) -> ComplexArray:
    """Amplitude (2,) of the lateral part of a vector (3,) that rotates by phi (sense +1) or -phi (sense -1).

    Re(result exp(i phi)) is (vx cos phi - vy sin phi, vx sin phi + vy cos phi) for sense +1, in the unit of the vector.
    """
    x, y = vector[0], vector[1]
    return np.array([x + 1j * sense * y, y - 1j * sense * x])


def excitation_lines(train: Train, structure: Structure, model: FullModel) -> tuple[Line, ...]:
    """Every line of the excitation, frequencies rising, amplitudes of one frequency added.

    Raises
    ------
    ModelError : a displacement that rigid connections do not admit.
    """
    lines = _Lines(structure, train.bodies)
    for displacement in train.displacements:
        lines.displace(displacement)
    for error in train.mesh_errors:
        lines.mesh_error(error)
    for load in train.loads:
        _add_load(lines, load, train)
    for ripple in train.ripples:
        lines.ripple(ripple)
    _add_passing(lines, model)
    gravity, masses = np.array(train.gravity), model.mass[:, 0]
    if any(train.gravity):
        for i, body in enumerate(train.bodies):
            fixed = structure.frame_turn[i], -1, body.angle
            lines.push(i, (masses[i] * gravity, np.zeros(3)), fixed, 0, "operation.gravity")
    # m Omega^2 r_c of every body whose centre is off the axis of its turning frame: what its bearing holds
    for i, (body, centre) in enumerate(zip(train.bodies, own_centres(train), strict=True)):
        outward = masses[i] * structure.frame_speed[i] ** 2 * np.append(centre, 0.0)
        at_rest = Fraction(0), 1, 0.0
        lines.push(i, (outward, np.zeros(3)), at_rest, 2, f"stages.{body.member}.mass")
    for part in structure.elastic:
        load = structure.spin[part.body] ** 2 * part.elastic.spin_load[6:]
        if load.any():
            full, spun = lines.at(Fraction(0), load, f"stages.{train.bodies[part.body].member}.elastic")
            full.force[2][part.columns] += spun
    return tuple(_line(frequency, full, structure, model) for frequency, full in sorted(lines.by_frequency.items()))


def _add_passing(lines: _Lines, model: FullModel) -> None:
    """Add the forces of errors of links that pass a body: those at multiples of their tone beside each line."""
    structure = lines.structure
    for frequency, full in list(lines.by_frequency.items()) if structure.passings else ():
        error = full.passing - structure.passing @ (model.S @ full.rigid)
        forces: dict[Fraction, ComplexArray] = {}
        for i in np.flatnonzero(error).tolist():
            row = structure.passings[i]
            for order, wave in enumerate(row.wave.tolist(), start=1):
                for amplitude, sense in ((error[i], 1), (error[i].conjugate(), -1)):
                    at = order * row.tone + sense * frequency
                    force = wave * amplitude / 2 * structure.passing[i]
                    forces[at] = forces.get(at, np.zeros(structure.size, complex)) + force
        for at, force in forces.items():
            beside, amplitudes = lines.at(at, force, *full.causes)
            beside.force[0] += amplitudes


def unit_lines(train: Train, deviations: Sequence[Displacement | MeshError]) -> tuple[Line, ...]:
    """One line for each deviation, in order: gaps and the force at rest (``force[0]``); no part that grows with speed.

    They are columns of maps that are linear in the deviations, with the rows and coordinates of ``assemble(train)``.

    Raises
    ------
    ModelError : as of `assemble`.
    """
    structure = structure_of(train)
    T, S, _ = eliminate(structure.rigid, structure.pivots)
    terms = ("bent_mass", "bent_damping", "bent_skew", "G", "Kg", "euler")
    model = FullModel(
        T=T,
        S=S,
        mass=np.zeros((len(train.bodies), 6)),
        **dict.fromkeys(terms, np.zeros((structure.size, structure.size))),
        mass_damping=0.0,
        link_stiffness=structure.linear_stiffness,
        link_damping=np.zeros(len(structure.links)),
        turning=np.zeros((len(structure.links), len(structure.links))),
    )
    units = []
    for deviation in deviations:
        lines = _Lines(structure, train.bodies)
        if isinstance(deviation, Displacement):
            lines.displace(deviation)
        else:
            lines.mesh_error(deviation)
        ((frequency, full),) = lines.by_frequency.items()
        units.append(_line(frequency, full, structure, model))
    return tuple(units)


def _add_load(lines: _Lines, load: Load, train: Train) -> None:
    """Add a load that turns with its body, given in the body's own axes, or is fixed in space, in the housing's."""
    structure = lines.structure
    body = structure.index[load.body]
    force, moment = np.array(load.force), np.array(load.moment)
    arm = load.station - train.bodies[body].station
    moment = moment + np.array([-arm * force[1], arm * force[0], 0.0])
    if load.turns:
        motion = structure.spin_turn[body] - structure.frame_turn[body], 1, load.phase
    else:
        motion = structure.frame_turn[body], -1, train.bodies[body].angle
    lines.push(body, (force, moment), motion, int(load.speed_squared) * 2, load.path)
    spin = structure.spin[body]
    if load.speed_squared and spin:
        # an eccentric mass lags its own acceleration: m e w' stands a quarter turn behind m e w^2
        behind = np.array([force[1], -force[0], 0.0]) / spin, np.array([moment[1], -moment[0], 0.0]) / spin
        lines.push(body, behind, motion, None, load.path)


def _line(frequency: Fraction, full: _FullLine, structure: Structure, model: FullModel) -> Line:
    """Reduced line: displaced rigid connections move the bodies, which enters every other row and the inertia."""
    omega = 2 * math.pi * float(frequency)
    shift = model.S @ full.rigid
    mesh = full.mesh - structure.mesh @ shift
    link = full.link - structure.link @ shift
    force, ramp = full.force.copy(), full.ramp
    force[0] += full.ripple
    force[0] += structure.link.T @ (model.link_stiffness * link)
    force[1] += structure.link.T @ (1j * omega * model.link_damping * link + model.turning @ link)
    if full.rigid.any():
        miss = np.abs(structure.rigid @ shift - full.rigid).max()
        if miss > 1e-9 * np.abs(full.rigid).max():
            raise ModelError(
                "rigid connections do not admit this displacement", path=full.causes[0], allowed="an elastic support"
            )
        momentum = model.diagonal * shift + model.bent_mass @ shift
        force[1] -= 1j * omega * (model.mass_damping * momentum + model.bent_damping @ shift) + model.bent_skew @ shift
        force[2] += omega**2 * momentum - 1j * omega * (model.G @ shift) - model.Kg @ shift
        # the acceleration of a displaced body has a part in s' too, and so has the frame that accelerates with it
        ramp = ramp - 1j * omega * momentum - model.euler @ shift
    law = structure.lawful
    return Line(
        frequency=frequency,
        gap=mesh,
        link_gap=link[~law],
        force=force @ model.T,
        causes=tuple(sorted(full.causes)),
        group_gap=link[law],
        ramp_force=ramp @ model.T,
        ripple=full.ripple @ model.T if full.ripple.any() else np.zeros(0, complex),
        far_gap=full.far - structure.far @ shift,
    )
