"""Bodies by the matrices of a finite-element program: read, reduced, and joined to what stands at their interfaces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bodies.elastic_body import ElasticBody
from ..document.schema import ModelFile
from ..document.schema_fields import MATRIX_FILES, ReducedTable
from ..errors import ModelError
from ..warning_codes import coded
from .kinematics import Kinematics
from .train import Body, Link, Mesh, ResolutionLog

if TYPE_CHECKING:
    from ..bodies.joined_body import InterfaceShape
    from ..bodies.reduced_body import ReducedBody
    from ..bodies.reduction import Interface

_MASS = 1e-3  # of a stated mass or inertia from that of the matrices


def with_reduced(
    bodies: Sequence[Body],
    links: Sequence[Link],
    meshes: Sequence[Mesh],
    model: ModelFile,
    kinematics: Kinematics,
    log: ResolutionLog,
) -> list[Body]:
    """Bodies with those that state matrices in them: mass and inertia of these, the place of the centre of mass.

    Raises
    ------
    ModelError : what reading and its checks refuse; a body that turns against its frame and is not axisymmetric; a
        mass stated otherwise; a link or mesh where the body has no interface.
    """
    found = []
    for body in bodies:
        table = _table(body, model)
        if table is None or body.shaft_of is not None:
            found.append(body)
            continue
        path = f"{_path(body)}.reduced"
        joined, mass, inertia, tilt, z = _joined(table, path, log)
        own = replace(body, reduced=joined, station=body.station + z, **_masses(body, model, mass, inertia, tilt, path))
        _require_constant(own, joined, links, bodies, kinematics, path)
        _require_interfaces(own, joined, links, meshes, path, log)
        for key, value, unit in (
            ("mass", mass, "kg"),
            ("inertia", inertia, "kg m^2"),
            ("tilt_inertia", tilt, "kg m^2"),
        ):
            log.note(f"{_path(body)}.{key}", value, unit, "reduced body")
        lowest = (
            math.sqrt(float((joined.springs.stiffness / np.diag(joined.mass)[6:]).min(initial=math.inf))) / math.tau
        )
        log.note(f"{path}.lowest_frequency", lowest, "Hz", "reduced body")
        found.append(own)
    return found


def _path(body: Body) -> str:
    return f"stages.{body.member}" if "." in body.member else f"bodies.{body.member}"


def _table(body: Body, model: ModelFile) -> ReducedTable | None:
    """What the file states of the matrices of a body."""
    stage, _, member = body.member.partition(".")
    return model.stages[stage].members[member].reduced if member else model.bodies[body.member].reduced


def _joined(table: ReducedTable, path: str, log: ResolutionLog) -> tuple[ElasticBody, float, float, float, float]:
    """The body of a table, mass [kg], inertia and tilt inertia [kg m^2], and the place of its centre along z [m]."""
    files = {key: str(getattr(table, key)) for key in MATRIX_FILES if getattr(table, key) is not None}
    stamps = tuple((name, _stamp(name)) for name in files.values())
    joined, mass, inertia, tilt, z, said = _read(table.model_dump_json(), stamps, path)
    for text in said:
        log.warn(coded("reduced-mass-off", text))
    return joined, mass, inertia, tilt, z


def _stamp(name: str) -> tuple[int, int]:
    """What tells whether a file has changed; zeros of one that is not there, which reading names."""
    try:
        seen = Path(name).stat()
    except OSError:
        return 0, 0
    return seen.st_mtime_ns, seen.st_size


@lru_cache(maxsize=8)  # a study resolves one file many times
def _read(
    text: str, stamps: tuple[tuple[str, tuple[int, int]], ...], path: str
) -> tuple[ElasticBody, float, float, float, float, tuple[str, ...]]:
    """`_joined` of the table as JSON; stamps : of its files."""
    from ..bodies.joined_body import joined_body
    from ..bodies.reading import read_body
    from ..bodies.reduction import reduced
    from ..bodies.turning import axisymmetric, turning_with_frame

    table = ReducedTable.model_validate_json(text)
    files: Mapping[str, str] = {key: getattr(table, key) for key in MATRIX_FILES if getattr(table, key) is not None}
    source = files["file"] if "file" in files else files
    body, facts = read_body(source, units=table.units, path=path)
    where = next(iter(files.values()))
    interfaces = _interfaces(table, body, path)
    said = facts.remarks
    if table.sectors is not None:
        nodes = tuple(dict.fromkeys(node for one in interfaces for node in one.nodes))
        body = axisymmetric(body, table.sectors, 6 + (table.modes or 40), nodes, where)
    else:
        if body.G1 is None and np.all((body.dof_dir >= 1) & (body.dof_dir <= 3)):
            body = turning_with_frame(body, where)
        if table.modes is not None:
            body, interfaces = reduced(body, interfaces, table.modes, where)
    joined = joined_body(body, facts, interfaces, where)
    tilt = float(facts.inertia[0, 0] + facts.inertia[1, 1]) / 2
    return joined, facts.mass, float(facts.inertia[2, 2]), tilt, float(facts.centre[2]), said


def _interfaces(table: ReducedTable, body: ReducedBody, path: str) -> tuple[Interface, ...]:
    """The stated interfaces; else each node that has coordinates."""
    from ..bodies.reduction import Interface

    known = set(body.node_id.tolist())
    for name, one in table.interfaces.items():
        for node in one.nodes:
            if node not in known:
                where = f"{path}.interfaces.{name}.nodes"
                raise ModelError("no such node in the body", path=where, given=node, allowed="a node of its file")
    if table.interfaces:
        return tuple(Interface(name=n, nodes=one.nodes, spider=one.spider) for n, one in table.interfaces.items())
    nodes = dict.fromkeys(body.dof_node[~body.modal].tolist())
    if body.shape_node is not None:
        nodes |= dict.fromkeys(body.shape_node.tolist())
    return tuple(Interface(name=f"node {node}", nodes=(node,)) for node in nodes)


def _masses(body: Body, model: ModelFile, mass: float, inertia: float, tilt: float, path: str) -> dict[str, Any]:
    """Mass and inertias of a body by key [kg, kg m^2]; refuses others that the file states."""
    stage, _, member = body.member.partition(".")
    stated = model.stages[stage].members[member] if member else model.bodies[body.member]
    values = {"mass": mass, "inertia": inertia, "tilt_inertia": tilt}
    for key, value in values.items():
        given = getattr(body, key)
        if getattr(stated, key) is not None and abs(given / value - 1) > _MASS:
            where, allowed = f"{_path(body)}.{key}", f"{value:.6g}, or nothing: the matrices have it"
            raise ModelError(f"not that of {path}", path=where, given=given, allowed=allowed)
    return values


def _require_constant(
    body: Body, joined: ElasticBody, links: Sequence[Link], bodies: Sequence[Body], kinematics: Kinematics, path: str
) -> None:
    """Refuse a body whose matrices, or those of what holds it, would vary in time in the axes of its stage."""
    speed, frames = kinematics.speed or {}, kinematics.frame_speed or {}
    frame = Fraction(frames.get(body.frame, 0))
    if joined.axisymmetric:
        return
    if Fraction(speed.get(body.member, 0)) != frame:
        raise ModelError(
            "turns against the axes of its stage: its matrices would vary in time",
            path=path,
            allowed="a carrier; a body of a train whose carrier stands; sectors of an axisymmetric body",
        )
    members = {other.name: other.member for other in bodies}
    for link in links:
        if body.name not in (link.first, link.second):
            continue
        other = link.second if link.first == body.name else link.first
        seat = Fraction(speed.get(members[other], 0)) if other else Fraction(0)
        lateral = any(link.stiffness[d] for d in (0, 1, 3, 4))
        if "/bolts/" in link.name and lateral and seat != frame:
            allowed = "radial stiffness at an interface on the axis"
            raise ModelError("bolts that pass a body that is not axisymmetric", path=link.path, allowed=allowed)


def _require_interfaces(
    body: Body, joined: ElasticBody, links: Sequence[Link], meshes: Sequence[Mesh], path: str, log: ResolutionLog
) -> None:
    """Refuse a link or a mesh where the body has no interface, off its axis; on the axis the mean motion is one."""
    shape: InterfaceShape = joined.shape  # type: ignore[assignment]
    for name, point in _points(body, links, meshes):
        i, away, _ = shape.nearest(point)
        if away > shape.reach and math.hypot(point[0], point[1]) <= shape.reach:
            text = f"{path}: {name} joins it on its axis, where it has no interface"
            log.coded("mean-motion-held", f"{text}; its mean motion is taken")
        elif away > shape.reach:
            text = ", ".join(f"{1e3 * value:.4g}" for value in point)
            nearest = ", ".join(f"{1e3 * value:.4g}" for value in shape.points[i])
            raise ModelError(
                f"no interface of the body where {name} joins it",
                path=path,
                given=f"({text}) mm from its centre of mass",
                allowed=f"one within {1e3 * shape.reach:.3g} mm; the nearest is {shape.names[i]} at ({nearest}) mm",
            )


def _points(body: Body, links: Sequence[Link], meshes: Sequence[Mesh]) -> Iterator[tuple[str, np.ndarray]]:
    """Names and places (3,) [m], in the axes of the body from its centre of mass, of what joins a body."""
    origin = np.array([*body.centre, body.station])
    c, s = math.cos(body.angle), math.sin(body.angle)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    for link in links:
        if body.name in (link.first, link.second) and (any(link.stiffness) or link.contacts or link.curves):
            yield link.name, axes @ (np.array([*link.centre, link.station]) - origin)
    for mesh in meshes:
        if body.name in (mesh.a, mesh.b):
            e = np.array([math.cos(mesh.direction), math.sin(mesh.direction)])
            radius = mesh.radius_a if body.name == mesh.a else mesh.radius_b if mesh.internal else -mesh.radius_b
            yield mesh.name, axes @ np.array([*(radius * e), mesh.station - body.station])
