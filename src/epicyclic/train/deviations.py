"""Deviations from nominal: what each kind does to the train, with exact signed frequencies.

One function a kind, listed in `MEMBER_KINDS` or `MESH_KINDS` under the key of `document/deviations.py`. A deviation
becomes a displaced feature, an error of a mesh or a load (docs/conventions.md, errors).  Its size is held against that
of the teeth: what is larger than a module is no deviation of a gear.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..document.deviations import (
    DisplacementTable,
    MemberDeviationsTable,
    MeshDeviationsTable,
    ProfileErrorTable,
    TurningErrorTable,
    UnbalanceTable,
)
from ..document.document import Document
from ..document.schema import SIDES, ModelFile
from ..document.tables import value_at
from ..errors import ModelError, in_mm
from ..teeth.geometry import pitch_lines, profile_amplitude, random_phases, tooth_phase
from .kinematics import Kinematics
from .stage_bodies import link_row, seated
from .stages import Level, Levels, stated, subtables
from .train import DIRECTIONS, Body, Displacement, GearData, Link, Load, Mesh, MeshError, ResolutionLog, of_branch

NEGLIGIBLE = 1e-9  # of the largest pitch harmonic


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviationScope:
    """The train so far, which deviations act on, and what they become.

    planets : number of branches, by stage.  displacements, mesh_errors, loads : collected here by the kinds.
    left_out : paths of deviations that turn in a train without speeds.
    """

    bodies: Sequence[Body]
    meshes: Sequence[Mesh]
    links: Sequence[Link]
    kinematics: Kinematics
    planets: Mapping[str, int]
    log: ResolutionLog
    displacements: list[Displacement] = field(default_factory=list)
    mesh_errors: list[MeshError] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)

    def relative(self, body: Body) -> Fraction | None:
        """Turns per second of a body in its frame, None without speeds."""
        return None if self.kinematics.speed is None else self.kinematics.against(body.member, body.frame) / 60

    def seat_turn(self, body: Body, seats: Sequence[Link]) -> Fraction | None:
        """Turns per second, in the frame of a body, of what carries it; None for a shaft without speeds."""
        if any(link.kind == "shaft" for link in seats):
            return self.relative(body)
        if self.kinematics.speed is None or body.branch is not None:
            return Fraction(0)
        carrier = next((link.second for link in seats if link.second is not None), None)
        member = next((b.member for b in self.bodies if b.name == carrier), None)
        return self.kinematics.against(member, body.frame) / 60

    def seats(self, body: Body) -> list[Link]:
        """The supports or bearings that carry a body; of a gear that has none, the shaft it sits on."""
        seats = [link for link in self.links if seated(link) == body.name]
        return [link for link in seats if link.kind != "shaft"] or seats

    def pins(self, body: Body) -> list[Link]:
        """The bearings of what a body carries."""
        return [link for link in self.links if link.kind == "bearing" and link.first == body.name and link.second]

    def add_error(
        self, cause: str, mesh: Mesh, path: str, amplitude: complex, frequency: Fraction, *, far: bool = False
    ) -> None:
        """Add an error of a mesh; fields as of `MeshError`."""
        error = MeshError(path=path, cause=cause, mesh=mesh.name, amplitude=amplitude, frequency=frequency, far=far)
        self.mesh_errors.append(error)


def resolve_deviations(model: ModelFile, scope: DeviationScope) -> None:
    """Collect what all deviations do; those that turn are left out with a warning where the file gives no speeds.

    Raises
    ------
    ModelError : deviations of a pair that does not mesh, or of a side that is none.
    """
    for body in scope.bodies:
        levels = _levels(model.deviations.members, body.member, body.side)
        for key, resolve_member in MEMBER_KINDS.items():
            if (statement := stated(levels, key)) is not None:
                resolve_member(scope, body, statement.path, statement.value)
    for mesh in scope.meshes:
        levels = _levels(model.deviations.meshes, mesh.pair.removeprefix("stages."), mesh.side)
        for key, resolve_mesh in MESH_KINDS.items():
            for path, value in _statements(levels, key):
                resolve_mesh(scope, mesh, path, value)
    _check_meshed(model, scope.meshes)
    _check_bodies(model, scope.bodies)
    if scope.left_out:
        names = ", ".join(dict.fromkeys(scope.left_out))
        scope.log.coded(
            "deviation-without-speed", f"no speed is given (operation.speed): left out, because they turn: {names}"
        )


def _check_meshed(model: ModelFile, meshes: Sequence[Mesh]) -> None:
    """Raise ModelError for deviations of a pair that does not mesh, or of a side that its meshes have not."""
    pairs = dict.fromkeys(mesh.pair.removeprefix("stages.") for mesh in meshes)
    sides = dict.fromkeys(f"{mesh.pair.removeprefix('stages.')}.{mesh.side}" for mesh in meshes if mesh.side)
    for name in model.deviations.meshes:
        if name not in pairs and name not in sides:
            allowed = ", ".join((*pairs, *sides)) or "no mesh"
            raise ModelError("no such mesh", path=f"deviations.{name}", allowed=allowed)


def _check_bodies(model: ModelFile, bodies: Sequence[Body]) -> None:
    """Raise ModelError for deviations of a side of a member in one piece."""
    halves = {f"{body.member}.{body.side}" for body in bodies if body.side}
    for name in model.deviations.members:
        member, _, side = name.rpartition(".")
        if side in SIDES and name not in halves and any(body.member == member for body in bodies):
            problem, allowed = "is a side of a member in one piece", f"{member}, or split"
            raise ModelError(problem, path=f"deviations.{name}", allowed=allowed)


def misaligned_bodies(model: ModelFile, bodies: Sequence[Body]) -> frozenset[str]:
    """Names of the bodies whose seat the file tilts: they stand askew even where no freedom lets them tilt."""
    members = model.deviations.members
    return frozenset(b.name for b in bodies if stated(_levels(members, b.member, b.side), "tilt") is not None)


def _levels(tables: Mapping[str, object], name: str, side: str | None) -> Levels:
    """The tables that may state a deviation of a member or mesh, nearest first."""
    of_side = (Level("side", f"deviations.{name}.{side}", tables.get(f"{name}.{side}")),) if side else ()
    return (*of_side, Level("member", f"deviations.{name}", tables.get(name)))


def _statements(levels: Levels, key: str) -> Iterable[tuple[str, Any]]:
    """Path and value of a kind in the nearest table that states it; of named errors the nearest of each name."""
    statement = stated(levels, key)
    if statement is None or not isinstance(statement.value, dict):
        return [] if statement is None else [(statement.path, statement.value)]
    named: dict[str, tuple[str, Any]] = {}
    for level in reversed(subtables(levels, key)):
        named |= {name: (f"{level.path}.{name}", table) for name, table in (level.table or {}).items()}  # type: ignore[attr-defined]
    return named.values()


# displaced features --------------------------------------------------------------------------------------------------


def _run_out(scope: DeviationScope, body: Body, path: str, table: DisplacementTable) -> None:
    """Run-out of the teeth, which turns with the body and enters its meshes; of a carrier the run-out of its pins."""
    if body.gear is not None:
        _displace(scope, body, path, table, cause="run_out", rows="mesh", links=[], frequency=scope.relative(body))
        return
    pins = scope.pins(body)
    if not pins:
        scope.log.coded(
            "deviation-without-effect", f"{path}: {body.name} has neither teeth nor pins, its run-out moves nothing"
        )
        return
    _displace(scope, body, path, table, cause="run_out", rows="own", links=pins, frequency=Fraction(0))


def _seat_error(cause: str, scope: DeviationScope, body: Body, path: str, table: DisplacementTable) -> None:
    """Kind of a displaced seat: run-out turns with the body and enters the links that carry it; position and
    misalignment stand still in what carries the body."""
    seats = scope.seats(body)
    # a doubt where nothing holds the member (or the half that `path` names) in the direction of the displacement
    whole, same = f".{body.side}." not in path, (body.member, body.branch)
    halves = [b for b in scope.bodies if b is body or (whole and (b.member, b.branch) == same)]
    rows = [_held_rows(link, b) for b in halves for link in scope.seats(b)]
    first = 3 if cause == "tilt" else 0
    for value, directions in zip(_components(body, table), ((first, first + 1), (first + 2,)), strict=True):
        if value and not any(row[i] for row in rows for i in directions):
            names = " and ".join(DIRECTIONS[i] for i in directions)
            text = f"{path} has no effect: no support or bearing holds {body.member} in {names}"
            scope.log.coded("deviation-without-effect", text)
    turns = cause == "bearing_run_out"
    frequency = scope.relative(body) if turns else scope.seat_turn(body, seats)
    entered: Literal["own", "seat"] = "own" if turns else "seat"
    _displace(scope, body, path, table, cause=cause, rows=entered, links=seats, frequency=frequency)


def _displace(
    scope: DeviationScope,
    body: Body,
    path: str,
    table: DisplacementTable,
    *,
    cause: str,
    rows: Literal["mesh", "own", "seat"],
    links: Sequence[Link],
    frequency: Fraction | None,
) -> None:
    """Add the displaced feature: its components across the axis turn at `frequency` [Hz], that along z stands still.

    A kind whose axial component turns adds its `Displacement` itself.

    cause, rows, links : as in `Displacement`.  frequency : None where it turns and no speed is given.
    """
    across, along = _components(body, table)
    if across and frequency is None:
        scope.left_out.append(path)
    # E(t) = Re(vector exp(i w t)) turns (x, y) by w t; at w = 0 it is (x, y) itself.  Derived here.
    turned = np.array([across, -1j * across, 0.0])
    for three, turns in ((turned if frequency else turned.real, frequency), (np.array([0.0, 0.0, along]), Fraction(0))):
        if three.any() and turns is not None:
            vector = np.zeros((2, 3), complex)  # x y z [m], rx ry rz [rad]
            vector[int(cause == "tilt")] = three
            scope.displacements.append(
                Displacement(
                    path=path,
                    cause=cause,
                    body=body.name,
                    rows=rows,
                    links=tuple(link.name for link in links),
                    vector=vector.ravel(),
                    frequency=turns,
                )
            )


def _held_rows(link: Link, body: Body) -> NDArray[np.bool_]:
    """Which of the six motions of a body about its centre a link resists, (6,): off its centre also tilt."""
    origin = (*body.centre, body.station)
    rows = [link_row(link, direction, origin) for direction in range(6) if link.stiffness[direction]]
    # rounding of cosines is no lever; a lever is in m, or 1 of an angle
    return np.asarray(np.any(np.abs(np.array(rows).reshape(-1, 6)) > 1e-12, axis=0))


def _components(body: Body, table: DisplacementTable) -> tuple[complex, complex]:
    """Component across the axis, x + i y in the body's own axes at t = 0, and along it [m], of a tilt [rad]."""
    if table.amplitude is not None:
        phase = of_branch(table.phase, body.branch)
        across = of_branch(table.amplitude, body.branch) * cmath.exp(1j * phase)
    else:
        x, y = (of_branch(getattr(table, key), body.branch) for key in ("x", "y"))
        across = complex(x, y)
    if table.from_ == "stage":
        across *= cmath.exp(-1j * body.angle)
    return across, complex(of_branch(table.z, body.branch))


# forces --------------------------------------------------------------------------------------------------------------


def _unbalance(scope: DeviationScope, body: Body, path: str, table: UnbalanceTable) -> None:
    """A force that turns with the body, amount [kg m] times the square of its absolute speed."""
    speed = scope.kinematics.speed
    if speed is None:
        scope.left_out.append(path)
        return
    omega = float(speed[body.member]) * math.pi / 30
    force = of_branch(table.amount, body.branch) * omega**2
    if force:
        scope.loads.append(
            Load(
                path=path,
                body=body.name,
                force=(force, 0.0, 0.0),
                moment=(0.0, 0.0, 0.0),
                station=body.station,
                turns=True,
                phase=of_branch(table.phase, body.branch),
                speed_squared=True,
            )
        )


# errors of meshes ----------------------------------------------------------------------------------------------------


def _pitch(scope: DeviationScope, body: Body, path: str, lists: tuple[tuple[float, ...], ...]) -> None:
    """Measured pitch deviations [m]: in every mesh of the gear a line at each order of its turning in the frame."""
    relative = scope.relative(body)
    if relative is None:
        scope.left_out.append(path)
        return
    samples = lists[(body.branch or 1) - 1] if len(lists) > 1 else lists[0]
    orders, coefficients = pitch_lines(samples)
    floor = NEGLIGIBLE * float(np.abs(coefficients).max(initial=0.0))
    for mesh in scope.meshes:
        if body.name not in (mesh.a, mesh.b):
            continue
        seen_from = mesh.direction if body.name == mesh.a or mesh.internal else mesh.direction + math.pi
        start = tooth_phase(len(samples), seen_from, body.angle) / len(samples)
        for order, coefficient in zip(orders.tolist(), coefficients.tolist(), strict=True):
            if abs(coefficient) > floor:
                amplitude = coefficient * cmath.exp(2j * math.pi * order * start)
                scope.add_error("pitch", mesh, path, amplitude, -order * relative)


def _profile(scope: DeviationScope, mesh: Mesh, path: str, table: ProfileErrorTable) -> None:
    """Profile error: a cosine at one order of the mesh frequency."""
    amplitude = of_branch(table.amplitude, mesh.branch)
    if amplitude == 0.0:
        return
    frequency = scope.kinematics.mesh_frequency
    if frequency is None:
        scope.left_out.append(path)
        return
    if table.phase == "identical":
        value = profile_amplitude(amplitude, table.order, lead=mesh.lead)
    elif table.phase == "random":
        count = 1 if mesh.branch is None else scope.planets[mesh.pair.split(".")[1]]
        phase = float(random_phases(count, table.seed or 0)[(mesh.branch or 1) - 1])
        value = profile_amplitude(amplitude, table.order, phase)
    else:
        assert not isinstance(table.phase, str)  # the schema leaves numbers
        value = profile_amplitude(amplitude, table.order, of_branch(table.phase, mesh.branch))
    scope.add_error("profile", mesh, path, value, table.order * frequency[mesh.stage])


def _gap(scope: DeviationScope, mesh: Mesh, path: str, gap: float | tuple[float, ...]) -> None:
    """Tooth thickness error: a constant opening of the gap [m]."""
    size = of_branch(gap, mesh.branch)
    if size:
        scope.add_error("gap", mesh, path, complex(size), Fraction(0))


def _turning_error(scope: DeviationScope, mesh: Mesh, path: str, table: TurningErrorTable) -> None:
    """Error that turns with a gear of the mesh or with the carrier: A cos(order theta + phase).

    theta : angle that the x axis of the member has turned past the direction of `from`, counter-clockwise.
    Derived here.
    """
    gears = [next(b for b in scope.bodies if b.name == name) for name in (mesh.a, mesh.b)]
    # of a split carrier the half of the side of the mesh
    carriers = [body for body in scope.bodies if body.kind == "carrier" and body.frame == gears[0].frame]
    nearest = sorted(carriers, key=lambda body: body.side != mesh.side)
    body = next(body for body in (*gears, *nearest) if body.member == table.turns_with)
    amplitude = of_branch(table.amplitude, mesh.branch)
    if amplitude == 0.0:
        return
    # in the frame, which turns with the carrier, that stands still whether a speed is given or not
    turns = Fraction(0) if body.kind == "carrier" else scope.relative(body)
    if turns is None:
        scope.left_out.append(path)
        return
    size = amplitude * (math.cos(mesh.base_helix) if table.direction == "transverse" else 1.0)
    phase = of_branch(table.phase, mesh.branch)
    for far in (False, True) if table.flanks == "both" else (False,):
        if table.from_ == "pitch-point":
            x = gears[0].centre[0] + mesh.radius_a * math.cos(mesh.direction) - body.centre[0]
            y = gears[0].centre[1] + mesh.radius_a * math.sin(mesh.direction) - body.centre[1]
            origin = math.atan2(y, x)
        else:
            origin = _force_angle(mesh, gears, body, far=far)
        wave = cmath.rect(size, table.order * (body.angle - origin) + phase)
        amplitude_at = -wave if table.sense == "closes" else wave
        scope.add_error("errors", mesh, path, amplitude_at, table.order * turns, far=far)


def _force_angle(mesh: Mesh, gears: Sequence[Body], body: Body, *, far: bool) -> float:
    """Polar angle of the transverse tooth force of the loaded or the far flank on a body [rad].

    The force on gear a is -n, on gear b it is +n (docs/conventions.md, The mesh row); on the carrier it is that on the
    planet of the mesh.
    """
    a, b = gears
    flank = -mesh.flank if far else mesh.flank
    normal = mesh.direction + flank * (math.pi / 2 - mesh.pressure_angle)
    on_a = body is a or (body is not b and a.branch is not None)
    return normal + math.pi if on_a else normal


# (scope, body or mesh, path in the file, value of the schema); displacements and errors are added in this order
MEMBER_KINDS: dict[str, Callable[[DeviationScope, Body, str, Any], None]] = {
    "run_out": _run_out,
    "bearing_run_out": partial(_seat_error, "bearing_run_out"),
    "position": partial(_seat_error, "position"),
    "tilt": partial(_seat_error, "tilt"),
    "unbalance": _unbalance,
    "pitch": _pitch,
}
MESH_KINDS: dict[str, Callable[[DeviationScope, Mesh, str, Any], None]] = {
    "profile": _profile,
    "gap": _gap,
    "errors": _turning_error,
}


# sizes beside the module ----------------------------------------------------------------------------------------------

# A gear displaced by its module has left its mates (working depth: two modules).  A tenth of a module is about ten
# times the run-out that grade 8 of ISO 1328 allows: such gears exist, but it is more often a slip in the unit.
_LARGEST, _DOUBTFUL = 1.0, 0.1


def check_sizes(document: Document, bodies: Sequence[Body], meshes: Sequence[Mesh], log: ResolutionLog) -> None:
    """Compare every deviation in length, and every backlash, with the module of the gear.

    A carrier or body without teeth is compared with the smallest module of its stage, or of the train.

    Raises
    ------
    ModelError : a deviation or backlash above a module; above a tenth of it a deviation is a warning.
    """
    deviations = document.model.deviations
    for member, table in deviations.members.items():
        module = module_of(member, bodies)
        for path, size in _of_member(table, f"deviations.{member}", _reach(member, bodies)):
            _check(path, size, module, document.data, log)
    for name, mesh_table in deviations.meshes.items():
        stage, _, pair, *_ = name.split(".")
        module = min((module_of(f"{stage}.{gear}", bodies) for gear in pair.split("-")), default=math.nan)
        for path, size in _of_mesh(mesh_table, f"deviations.{name}"):
            _check(path, size, module, document.data, log)
    for mesh in meshes:
        # a backlash in which a tooth is lost
        module = min(gear.module for gear in _gears_of(mesh, bodies))
        if math.isfinite(mesh.backlash) and mesh.backlash > _LARGEST * module:
            sided = f"{mesh.pair}.{mesh.side}.backlash"
            raise ModelError(
                "larger than a module: no backlash of teeth",
                path=f"{mesh.pair}.backlash" if value_at(document.data, sided.split(".")) is None else sided,
                given=in_mm(mesh.backlash, 4),
                allowed=f"at most a module, {in_mm(module, 4)}; leave it out where the far flank never touches",
            )


def _of_member(table: MemberDeviationsTable, path: str, reach: float) -> Iterator[tuple[str, float]]:
    """Yield path and largest size [m] of what displaces teeth; a slide along the axis does not.

    reach : from the middle of the teeth to their end [m], which a tilt displaces.
    """
    for key, lever in (("run_out", 1.0), ("bearing_run_out", 1.0), ("position", 1.0), ("tilt", reach)):
        vector = getattr(table, key)
        for name in ("amplitude", "x", "y"):
            if vector is not None and (value := getattr(vector, name)) is not None:
                yield f"{path}.{key}.{name}", _largest(value) * lever
    if table.pitch is not None:
        yield f"{path}.pitch", max(max(teeth) - min(teeth) for teeth in table.pitch)


def _of_mesh(table: MeshDeviationsTable, path: str) -> Iterator[tuple[str, float]]:
    """Yield path and largest size [m] of the errors of a mesh."""
    if table.profile is not None:
        yield f"{path}.profile.amplitude", _largest(table.profile.amplitude)
    if table.gap is not None:
        yield f"{path}.gap", _largest(table.gap)
    for name, error in table.errors.items():
        yield f"{path}.errors.{name}.amplitude", _largest(error.amplitude)


def _largest(value: float | tuple[float, ...]) -> float:
    return max(map(abs, value)) if isinstance(value, tuple) else abs(value)


def module_of(member: str, bodies: Sequence[Body]) -> float:
    """Smallest module [m] of a member, of its stage where it has no teeth, of the train where it is in none."""
    stage, _, name = member.partition(".")
    pieces = [b for b in bodies if b.member == f"{stage}.{name.partition('.')[0]}"]
    groups = (pieces, [b for b in bodies if b.frame == stage], bodies)
    return min(next(filter(None, ([b.gear.module for b in group if b.gear is not None] for group in groups))))


def _reach(member: str, bodies: Sequence[Body]) -> float:
    """Half the width over all teeth of a member [m]; 0 where it has none or no width is given."""
    gears = [b.gear for b in bodies if b.gear is not None and (b.member == member or member.startswith(f"{b.member}."))]
    return max((gear.whole_width / 2 for gear in gears if gear.face_width is not None), default=0.0)


def _check(path: str, size: float, module: float, data: Mapping[str, Any], log: ResolutionLog) -> None:
    """Raise ModelError, or warn, of one deviation [m] of a gear of a module [m]."""
    words = "moves the ends of the teeth by" if ".tilt." in path else "is"
    if size > _LARGEST * module:
        problem, given = f"{words} more than a module: no deviation of a gear", _written(data, path, size)
        raise ModelError(problem, path=path, given=given, allowed=f"at most a module, {in_mm(module, 4)}")
    if size > _DOUBTFUL * module:
        more = f"{words} more than a tenth of a module ({in_mm(module, 4)}); is the unit right?"
        log.coded("deviation-large", f"{path} = {_written(data, path, size)}: {more}")


def check_contact_errors(
    mesh: Mesh, bodies: Sequence[Body], *, misalignment: float, errors: Mapping[str, float]
) -> None:
    """Compare errors of one tooth contact with the module, as deviations of the file.

    Parameters
    ----------
    misalignment : of the flanks [rad], which counts at the ends of the common face.  errors : by keyword [m].

    Raises
    ------
    ModelError : one above a module, by its keyword.
    """
    module = min(gear.module for gear in _gears_of(mesh, bodies))
    width = mesh.width if math.isfinite(mesh.width) else 0.0
    for path, size in {"misalignment": misalignment * width / 2, **errors}.items():
        if abs(size) > _LARGEST * module:
            problem = f"moves teeth by {in_mm(abs(size), 4)}, more than a module"
            raise ModelError(problem, path=path, allowed=f"at most a module, {in_mm(module, 4)}; is the unit right?")


def _gears_of(mesh: Mesh, bodies: Sequence[Body]) -> list[GearData]:
    """Both gears of a mesh."""
    return [b.gear for b in bodies if b.name in (mesh.a, mesh.b) and b.gear is not None]


def _written(data: Mapping[str, Any], path: str, size: float) -> object:
    """Value as it stands in the document, else its size."""
    value = value_at(data, path.split("."))
    return in_mm(size, 4) if value is None or isinstance(value, float) else value
