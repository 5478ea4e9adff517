"""Bodies by the matrices of a finite-element program: read, reduced, and joined to what stands at their interfaces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bodies.elastic_body import ElasticBody, about_z
from ..document.schema import ModelFile
from ..document.schema_fields import MATRIX_FILES, ReducedTable
from ..errors import ModelError
from ..warning_codes import coded
from .kinematics import Kinematics
from .rings import passes
from .stage_bodies import MASS_UNITS
from .train import Body, Link, Mesh, ResolutionLog

if TYPE_CHECKING:
    from ..bodies.checks import BodyFacts
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
    found = list(bodies)
    for i, body in enumerate(bodies):
        stage, _, member = body.member.partition(".")
        stated = model.stages[stage].members[member] if member else model.bodies[body.member]
        if stated.reduced is None or body.shaft_of is not None:
            continue
        of = f"{'stages' if member else 'bodies'}.{body.member}"
        path = f"{of}.reduced"
        joined, facts = _read(stated.reduced.model_dump_json(), _stamps(stated.reduced), path)
        for text in facts.remarks:
            log.warn(coded("reduced-mass-off", text))
        polar, across = float(facts.inertia[2, 2]), float(facts.inertia[0, 0] + facts.inertia[1, 1]) / 2
        masses: dict[str, Any] = {"mass": facts.mass, "inertia": polar, "tilt_inertia": across}
        for key, value in masses.items():
            given = getattr(body, key)
            if getattr(stated, key) is not None and abs(given / value - 1) > _MASS:
                allowed = f"{value:.6g}, or nothing: the matrices have it"
                raise ModelError(f"not that of {path}", path=f"{of}.{key}", given=given, allowed=allowed)
            log.note(f"{of}.{key}", value, MASS_UNITS[key], "reduced body")
        found[i] = replace(body, reduced=joined, station=body.station + float(facts.centre[2]), **masses)
        _require_constant(body, joined, links, bodies, kinematics, path)
        _require_interfaces(found[i], joined, links, meshes, path, log)
    return found


def _files(table: ReducedTable) -> dict[str, str]:
    return {key: getattr(table, key) for key in MATRIX_FILES if getattr(table, key) is not None}


def _stamps(table: ReducedTable) -> tuple[tuple[int, int], ...]:
    """What tells whether a file, or one of its name beside it, has changed; none of what is not there."""
    beside = [sorted(file.parent.glob(f"{escape(file.stem)}*")) for file in map(Path, _files(table).values())]
    seen = [one.stat() for files in beside for one in files if one.is_file()]
    return tuple((one.st_mtime_ns, one.st_size) for one in seen)


@lru_cache(maxsize=8)  # a study resolves one file many times
def _read(text: str, stamps: tuple[tuple[int, int], ...], path: str) -> tuple[ElasticBody, BodyFacts]:
    """The body of a table, as JSON, and what its checks found; stamps : of its files."""
    from ..bodies.joined_body import joined_body
    from ..bodies.reading import read_body
    from ..bodies.reduction import reduced
    from ..bodies.turning import axisymmetric, turning_with_frame

    table = ReducedTable.model_validate_json(text)
    files = _files(table)
    body, facts = read_body(files.get("file", files), units=table.units, path=path)
    where = next(iter(files.values()))
    interfaces = _interfaces(table, body, path)
    if table.sectors is not None:
        nodes = tuple(dict.fromkeys(node for one in interfaces for node in one.nodes))
        body = axisymmetric(body, table.sectors, 6 + (table.modes or 40), nodes, where)
    else:
        if body.G1 is None and np.all((body.dof_dir >= 1) & (body.dof_dir <= 3)):
            body = turning_with_frame(body, where)
        if table.modes is not None:
            body, interfaces = reduced(body, interfaces, table.modes, where)
    return joined_body(body, facts, interfaces, where), facts


def _interfaces(table: ReducedTable, body: ReducedBody, path: str) -> tuple[Interface, ...]:
    """The stated interfaces; else each node that has coordinates."""
    from ..bodies.reduction import Interface

    for name, one in table.interfaces.items():
        if unknown := set(one.nodes) - set(body.node_id.tolist()):
            where, given = f"{path}.interfaces.{name}.nodes", min(unknown)
            raise ModelError("no such node in the body", path=where, given=given, allowed="a node of its file")
    if table.interfaces:
        return tuple(Interface(name=n, nodes=one.nodes, spider=one.spider) for n, one in table.interfaces.items())
    nodes = dict.fromkeys(body.dof_node[~body.modal].tolist())
    if body.shape_node is not None:
        nodes |= dict.fromkeys(body.shape_node.tolist())
    return tuple(Interface(name=f"node {node}", nodes=(node,)) for node in nodes)


def _require_constant(
    body: Body, joined: ElasticBody, links: Sequence[Link], bodies: Sequence[Body], kinematics: Kinematics, path: str
) -> None:
    """Refuse a body whose matrices, or those of what holds it, would vary in time in the axes of its stage."""
    speed, frames = kinematics.speed or {}, kinematics.frame_speed or {}
    if joined.waves is not None:
        return
    if Fraction(speed.get(body.member, 0)) != Fraction(frames.get(body.frame, 0)):
        problem = "turns against the axes of its stage: its matrices would vary in time"
        allowed = "a carrier; a body that stands, of a train whose carrier stands; sectors of an axisymmetric body"
        raise ModelError(problem, path=path, allowed=allowed)
    for link in links:
        bolt = "/bolts/" in link.name and body.name in (link.first, link.second)
        if bolt and any(link.stiffness[:2]) and passes(link, body, bodies, kinematics):
            allowed = "radial stiffness at an interface on the axis"
            raise ModelError("bolts that pass a body that is not axisymmetric", path=link.path, allowed=allowed)


def _require_interfaces(
    body: Body, joined: ElasticBody, links: Sequence[Link], meshes: Sequence[Mesh], path: str, log: ResolutionLog
) -> None:
    """Refuse a link or a mesh where the body has no interface, off its axis; on the axis the mean motion is one."""
    shape: InterfaceShape = joined.shape  # type: ignore[assignment]
    for name, off in _points(body, links, meshes):
        point = about_z(off[None], -body.angle)[0]
        i, away, _ = shape.nearest(point)
        if away > shape.reach and math.hypot(point[0], point[1]) <= shape.reach:
            text = f"{path}: {name} joins it on its axis, where it has no interface"
            log.coded("mean-motion-held", f"{text}; its mean motion is taken")
        elif away > shape.reach:
            here, there = (", ".join(f"{1e3 * value:.4g}" for value in place) for place in (point, shape.points[i]))
            given, problem = f"({here}) mm from its centre of mass", f"no interface of the body where {name} joins it"
            allowed = f"one within {1e3 * shape.reach:.3g} mm; the nearest is {shape.names[i]} at ({there}) mm"
            raise ModelError(problem, path=path, given=given, allowed=allowed)


def _points(body: Body, links: Sequence[Link], meshes: Sequence[Mesh]) -> Iterator[tuple[str, np.ndarray]]:
    """Names and places (3,) [m], in the axes of the frame from its centre of mass, of what joins a body."""
    origin = np.array([*body.centre, body.station])
    for link in links:
        if body.name in (link.first, link.second) and (any(link.stiffness) or link.contacts or link.curves):
            yield link.name, np.array([*link.centre, link.station]) - origin
    for mesh in meshes:
        if body.name in (mesh.a, mesh.b):
            e = np.array([math.cos(mesh.direction), math.sin(mesh.direction)])
            radius = mesh.radius_a if body.name == mesh.a else mesh.radius_b if mesh.internal else -mesh.radius_b
            for place in mesh.slices or (mesh,):
                yield mesh.name, np.array([*(radius * e), place.station - body.station])
