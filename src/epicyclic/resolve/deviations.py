"""Deviations from nominal: displaced features, mesh errors, unbalance, with exact signed frequencies."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..gears.deviations import pitch_lines, profile_amplitude, random_phases, tooth_phase
from ..model import schema_operation as tables
from ..model.schema import ModelFile
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link, Mesh
from ..train.kinematics import Kinematics
from ..train.train import Displacement, Load, MeshError
from .ledger import Ledger, per_branch

__all__ = ["Deviated", "deviations_of"]

NEGLIGIBLE = 1e-9  # of the largest pitch harmonic


@dataclass(slots=True, kw_only=True)
class Deviated:
    """What the deviations of a file become."""

    displacements: list[Displacement] = field(default_factory=list)
    mesh_errors: list[MeshError] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Parts:
    """The train so far."""

    bodies: Sequence[Body]
    meshes: Sequence[Mesh]
    links: Sequence[Link]
    kinematics: Kinematics
    planets: Mapping[str, int]

    def relative(self, body: Body) -> Fraction | None:
        """Turns per second of a body in its frame, None without speeds."""
        speed, frames = self.kinematics.speed, self.kinematics.frame_speed
        if speed is None or frames is None:
            return None
        return (speed[body.member] - frames.get(body.frame, Fraction(0))) / 60

    def standing(self, body: Body, seats: Sequence[Link]) -> Fraction | None:
        """Turns per second, in the frame of a body, of what carries it; None for a shaft without speeds."""
        speed, frames = self.kinematics.speed, self.kinematics.frame_speed
        if any(link.kind == "shaft" for link in seats):
            return self.relative(body)
        if speed is None or frames is None or body.branch is not None:
            return Fraction(0)
        frame = frames.get(body.frame, Fraction(0))
        carrier = next((link.second for link in seats if link.second is not None), None)
        if carrier is None:
            return -frame / 60
        member = next(b.member for b in self.bodies if b.name == carrier)
        return (speed[member] - frame) / 60

    def seats(self, body: Body) -> list[Link]:
        """The supports or bearings that carry a body; of a gear that has none, the shaft it sits on."""
        found = [
            link
            for link in self.links
            if (link.kind == "support" and link.first == body.name)
            or (link.kind == "bearing" and (link.second or link.first) == body.name)
        ]
        return found or [link for link in self.links if link.kind == "shaft" and link.second == body.name]

    def pins(self, body: Body) -> list[Link]:
        """The bearings of what a body carries."""
        return [link for link in self.links if link.kind == "bearing" and link.first == body.name and link.second]


def deviations_of(
    model: ModelFile,
    *,
    bodies: Sequence[Body],
    meshes: Sequence[Mesh],
    links: Sequence[Link],
    kinematics: Kinematics,
    planets: Mapping[str, int],
    ledger: Ledger,
) -> Deviated:
    """All deviations; those that turn are left out with a warning where the file gives no speeds."""
    parts = _Parts(bodies=bodies, meshes=meshes, links=links, kinematics=kinematics, planets=planets)
    found, left_out = Deviated(), list[str]()
    for body in bodies:
        for key in ("run_out", "bearing_run_out", "position", "tilt", "unbalance", "pitch"):
            path, table = _said(model.deviations.members, body.member, body.side, key)
            if table is not None:
                _member_deviation(parts, body, key, path, table, found, left_out, ledger)
    for mesh in meshes:
        stage_name = mesh.pair.split(".")[1]
        member = mesh.pair.removeprefix("stages.")
        for key in ("profile", "gap"):
            path, table = _said(model.deviations.meshes, member, mesh.side, key)
            if table is not None:
                _mesh_deviation(parts, mesh, path, table, found, left_out, planets[stage_name])
    if left_out:
        names = ", ".join(dict.fromkeys(left_out))
        ledger.warn(f"no speed is given (operation.speed): left out, because they turn: {names}")
    return found


def _said(entries: Mapping[str, object], name: str, side: str | None, key: str) -> tuple[str, object]:
    """Path and table of one deviation: of the side, else of the member or mesh."""
    for where in (f"{name}.{side}", name) if side else (name,):
        value = getattr(entries.get(where), key, None)
        if value is not None:
            return f"deviations.{where}.{key}", value
    return "", None


def _member_deviation(
    parts: _Parts,
    body: Body,
    key: str,
    path: str,
    table: object,
    found: Deviated,
    left_out: list[str],
    ledger: Ledger,
) -> None:
    if isinstance(table, tables.Unbalance):
        _unbalance(parts, body, path, table, found, left_out)
    elif isinstance(table, tuple):
        _pitch(parts, body, path, table, found, left_out)
    elif isinstance(table, (tables.Displacement, tables.TiltDeviation)):
        _displaced(parts, body, key, path, table, found, left_out, ledger)


def _own(body: Body, value: float | Sequence[float] | None, parts: _Parts, path: str) -> float:
    """The value of one body out of one or one per planet."""
    count = parts.planets.get(body.frame, 0) if body.branch is not None else 1
    return per_branch(value, max(count, 1), path)[(body.branch or 1) - 1]


# displaced features --------------------------------------------------------------------------------------------------


def _displaced(
    parts: _Parts,
    body: Body,
    key: str,
    path: str,
    table: tables.Displacement | tables.TiltDeviation,
    found: Deviated,
    left_out: list[str],
    ledger: Ledger,
) -> None:
    seats, pins = parts.seats(body), parts.pins(body)
    frequency: Fraction | None
    if key == "run_out" and body.gear is None:
        if not pins:
            ledger.warn(f"{path}: {body.name} has neither teeth nor pins, its run-out moves nothing")
            return
        rows, links, frequency = "own", pins, Fraction(0)
    elif key == "run_out":
        rows, links, frequency = "mesh", [], parts.relative(body)
    elif key == "bearing_run_out":
        rows, links, frequency = "own", seats, parts.relative(body)
    else:
        rows, links, frequency = "seat", seats, parts.standing(body, seats)
    across, along = _vector(parts, body, path, table)
    if links is seats:
        _check_held(parts, body, key, path, (across, along), ledger)
    if across and frequency is None:
        left_out.append(path)
    for size, turns in ((across, frequency), (along, Fraction(0))):
        if size and turns is not None:
            vector = _six(size, along=size is along, tilt=key == "tilt", turning=turns != 0)
            found.displacements.append(
                Displacement(
                    path=path,
                    cause=key,
                    body=body.name,
                    rows=rows,
                    links=tuple(link.name for link in links),
                    vector=vector,
                    frequency=turns,
                )
            )


def _check_held(parts: _Parts, body: Body, key: str, path: str, size: tuple[complex, complex], ledger: Ledger) -> None:
    """Warn where nothing holds a member (or the half that `path` names) in the direction its seat is displaced in."""
    sided = f".{body.side}." in path
    own = [b for b in parts.bodies if b is body or (not sided and (b.member, b.branch) == (body.member, body.branch))]
    held = [link.stiffness for b in own for link in parts.seats(b)]
    first = 3 if key == "tilt" else 0
    for value, directions in zip(size, ((first, first + 1), (first + 2,)), strict=True):
        if value and not any(stiffness[i] for stiffness in held for i in directions):
            names = " and ".join(DIRECTIONS[i] for i in directions)
            ledger.warn(f"{path} has no effect: no support or bearing holds {body.member} in {names}")


def _vector(
    parts: _Parts, body: Body, path: str, table: tables.Displacement | tables.TiltDeviation
) -> tuple[complex, complex]:
    """What lies across the axis, x + i y in the body's own axes at t = 0, and what lies along it."""
    if table.amplitude is not None:
        phase = _own(body, table.phase, parts, f"{path}.phase")
        across = _own(body, table.amplitude, parts, f"{path}.amplitude") * cmath.exp(1j * phase)
    else:
        across = complex(_own(body, table.x, parts, f"{path}.x"), _own(body, table.y, parts, f"{path}.y"))
    if table.from_ == "stage":
        across *= cmath.exp(-1j * body.angle)
    return across, complex(_own(body, table.z, parts, f"{path}.z"))


def _six(size: complex, *, along: bool, tilt: bool, turning: bool) -> NDArray[np.complex128]:
    """(6,) amplitude: E(t) = Re(vector exp(i w t)) turns (x, y) by w t; at w = 0 it is (x, y) itself."""
    vector = np.zeros(6, complex)
    first = 3 if tilt else 0
    if along:
        vector[first + 2] = size.real
    elif turning:
        vector[first : first + 2] = size, -1j * size
    else:
        vector[first : first + 2] = size.real, size.imag
    return vector


# errors of meshes ----------------------------------------------------------------------------------------------------


def _mesh_deviation(
    parts: _Parts, mesh: Mesh, path: str, table: object, found: Deviated, left_out: list[str], planets: int
) -> None:
    count = planets if mesh.branch is not None else 1
    branch = (mesh.branch or 1) - 1
    if not isinstance(table, tables.ProfileDeviation):
        gap = per_branch(table, count, path)[branch]  # type: ignore[arg-type]
        if gap:
            error = MeshError(path=path, cause="gap", mesh=mesh.name, amplitude=complex(gap), frequency=Fraction(0))
            found.mesh_errors.append(error)
        return
    amplitude = per_branch(table.amplitude, count, f"{path}.amplitude")[branch]
    if amplitude == 0.0:
        return
    if parts.kinematics.mesh_frequency is None:
        left_out.append(path)
        return
    if table.phase == "identical":
        value = profile_amplitude(amplitude, table.order, lead=mesh.lead)
    else:
        value = profile_amplitude(amplitude, table.order, _phase(table, count, branch, path))
    frequency = table.order * parts.kinematics.mesh_frequency[mesh.stage]
    found.mesh_errors.append(
        MeshError(path=path, cause="profile", mesh=mesh.name, amplitude=value, frequency=frequency)
    )


def _phase(table: tables.ProfileDeviation, count: int, branch: int, path: str) -> float:
    if table.phase == "random":
        return float(random_phases(count, table.seed or 0)[branch])
    assert not isinstance(table.phase, str)  # the schema leaves numbers
    return per_branch(table.phase, count, f"{path}.phase")[branch]


def _pitch(
    parts: _Parts,
    body: Body,
    path: str,
    lists: tuple[tuple[float, ...], ...],
    found: Deviated,
    left_out: list[str],
) -> None:
    """Measured pitch deviations: in every mesh of the gear a line at each order of its turning in the frame."""
    relative = parts.relative(body)
    if relative is None:
        left_out.append(path)
        return
    samples = lists[(body.branch or 1) - 1] if len(lists) > 1 else lists[0]
    orders, coefficients = pitch_lines(samples)
    floor = NEGLIGIBLE * float(np.abs(coefficients).max(initial=0.0))
    for mesh in parts.meshes:
        if body.name not in (mesh.a, mesh.b):
            continue
        seen_from = mesh.direction if body.name == mesh.a or mesh.internal else mesh.direction + math.pi
        start = tooth_phase(len(samples), seen_from, body.angle) / len(samples)
        for order, coefficient in zip(orders.tolist(), coefficients.tolist(), strict=True):
            if abs(coefficient) > floor:
                found.mesh_errors.append(
                    MeshError(
                        path=path,
                        cause="pitch",
                        mesh=mesh.name,
                        amplitude=coefficient * cmath.exp(2j * math.pi * order * start),
                        frequency=-order * relative,
                    )
                )


def _unbalance(
    parts: _Parts, body: Body, path: str, table: tables.Unbalance, found: Deviated, left_out: list[str]
) -> None:
    """A force that turns with the body, amount times the square of its absolute speed."""
    if parts.kinematics.speed is None:
        left_out.append(path)
        return
    omega = float(parts.kinematics.speed[body.member]) * math.pi / 30
    force = _own(body, table.amount, parts, f"{path}.amount") * omega**2
    if force:
        found.loads.append(
            Load(
                path=path,
                body=body.name,
                force=(force, 0.0, 0.0),
                moment=(0.0, 0.0, 0.0),
                station=body.station,
                turns=True,
                phase=_own(body, table.phase, parts, f"{path}.phase"),
                speed_squared=True,
            )
        )
