"""Sensors of the file on the bodies and links of a train.

Strain gauges and accelerometers are glued to material: their angle counts from the x axis of the body and turns with
it.  On a held ring it stands still in the housing, whose planets pass by.  So do bolts, whose springs tell their force.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..document.schema import ModelFile, SensorTable
from ..errors import ModelError
from .stage_bodies import member_centre
from .train import Body, Link, ResolutionLog, Sensor, bodies_named

DIRECTIONS = ("radial", "tangential", "axial")


def resolve_sensors(
    model: ModelFile, bodies: Sequence[Body], links: Sequence[Link], displaced: set[str], log: ResolutionLog
) -> Iterator[Sensor]:
    """Sensors of a file, one on each body of a member; the torque of a member is that of all its halves.

    displaced : names of links whose seat is.

    Raises
    ------
    ModelError : strain of what does not bend, an unknown radius; torque of what drives no teeth; a link that is not
        there, or without a torque of its own; force of what is no bolt in the housing, or of one with a displaced seat.
    """
    by_name = {body.name: body for body in bodies}
    for name, table in model.sensors.items():
        path = f"sensors.{name}"
        if table.kind == "force":
            yield from _of_bolts(name, table, by_name, links, displaced)
            continue
        if table.link is not None:
            found = _links_named(table.link, links, f"{path}.link")
            held = [by_name[link.second or link.first] for link in found]
            yield from [
                Sensor(name=f"{name}{end}", kind=table.kind, link=link.name)
                for link, end in zip(found, _endings(held), strict=True)
            ]
            continue
        assert table.on is not None
        of = bodies_named(table.on, bodies)
        if not of:
            problem, allowed = "no such body: the member is in one piece", table.on.rpartition(".")[0]
            raise ModelError(problem, path=f"{path}.on", given=table.on, allowed=allowed)
        if table.kind == "torque":
            carrying = {body.carried_by for body in bodies}
            if not any(body.gear is not None or body.name in carrying for body in of):
                problem, allowed = "no teeth on it, nor on what it carries", "a gear or carrier, or a link (link)"
                raise ModelError(problem, path=f"{path}.on", given=table.on, allowed=allowed)
            branches = {body.branch: [one.name for one in of if one.branch == body.branch] for body in of}
            yield from [
                Sensor(name=name if branch is None else f"{name}/{branch}", kind=table.kind, bodies=tuple(names))
                for branch, names in branches.items()
            ]
            continue
        for body, end in zip(of, _endings(of), strict=True):
            yield Sensor(
                name=f"{name}{end}",
                kind=table.kind,
                direction=table.direction,
                bodies=(body.name,),
                angle=table.angle,
                radius=0.0 if table.kind == "angle" else _radius(table, body, path, log),
                z=0.0 if table.z is None else member_centre(body, model) + table.z - body.station,
            )


def _of_bolts(
    name: str, table: SensorTable, bodies: Mapping[str, Body], links: Sequence[Link], displaced: set[str]
) -> Iterator[Sensor]:
    """Forces of the bolts of a support, ``main.ring.support.bolts``, or of one, ``main.ring.support.bolts.3``.

    Raises
    ------
    ModelError : no such bolts; bolts to another body, without a linear spring in the direction, or out of place.
    """
    which, of = DIRECTIONS.index(table.direction), dict[str, Any](path=f"sensors.{name}.link", given=table.link)
    bolts = {link.name.replace("/", "."): link for link in links if "/bolts/" in link.name}
    found = {key: bolt for key, bolt in bolts.items() if table.link in (key, key.rpartition(".")[0])}
    if joined := {bolt.second for bolt in found.values() if bolt.second is not None}:
        allowed = "bolts in the housing; forces in the support of that body are in the tables"
        raise ModelError(f"the bolts join {', '.join(joined)}", **of, allowed=allowed)
    if not found:
        counts = Counter(key.rpartition(".")[0] for key, bolt in bolts.items() if bolt.second is None)
        allowed = ", ".join(f"{key}, or one of them, {key}.1 to .{n}" for key, n in counts.items())
        raise ModelError("no such bolts in the housing", **of, allowed=allowed or "bolts of a support")
    for key, bolt in found.items():
        body, k = bodies[bolt.first], bolt.stiffness[which]
        if bolt.curves or bolt.contacts or bolt.clearance or bolt.exponent != 1.0 or not 0 < k < math.inf:
            raise ModelError(f"no linear {table.direction} spring", **of, allowed="bolts of a finite stiffness, no law")
        if bolt.name in displaced:
            raise ModelError(
                "the seat of the bolts is displaced", **of, allowed="bolts without deviations of their seat"
            )
        yield Sensor(
            name=name if len(found) == 1 else f"{name}/{key.rpartition('.')[2]}",
            kind=table.kind,
            direction=table.direction,
            bodies=(bolt.first,),
            link=bolt.name,
            angle=bolt.angle - body.angle,
            radius=math.hypot(*bolt.centre),
            z=bolt.station - body.station,
            stiffness=k,
        )


def _radius(table: SensorTable, body: Body, path: str, log: ResolutionLog) -> float:
    """Radius of a gauge or accelerometer [m]: as stated, the outer one of a ring, else the reference radius, or 0.

    Raises
    ------
    ModelError : strain of a rigid body, or of a ring whose outer radius is not known; acceleration of a reduced body.
    """
    of: dict[str, Any] = {"path": f"{path}.on", "given": table.on}
    if table.kind == "strain" and body.elastic is None:
        raise ModelError(f"{body.name} is rigid: it has no strain", **of, allowed="a ring with elastic")
    if table.kind == "acceleration" and body.reduced is not None:
        problem = f"{body.name} is a body of matrices, whose motion is known at its interfaces alone"
        raise ModelError(problem, **of, allowed="a rigid body, or a ring with elastic")
    radius = table.radius or body.outer_radius
    if table.kind == "strain" and radius is None:
        allowed = "a radius, or rim or outer_diameter of the ring"
        raise ModelError("the outer radius of the ring is not known", path=f"{path}.radius", allowed=allowed)
    if table.kind == "strain" and body.gear is not None and body.outer_radius is not None:
        tip, outer = body.gear.tip_radius, body.outer_radius
        if radius is not None and not tip <= radius <= outer * (1 + 1e-9):
            allowed = f"{1e3 * tip:.5g} to {1e3 * outer:.5g} mm, from the tips to the outside"
            raise ModelError("not on the ring", path=f"{path}.radius", given=radius, allowed=allowed)
    radius = radius or (0.0 if body.kind == "body" else body.reference_radius)
    log.note(f"{path}.radius", radius, "m", "geometry" if table.radius is None else "given")
    if table.kind == "strain" and body.elastic is not None and math.isinf(body.elastic.axial):
        text = f"{path}: {body.name} does not stretch: its hoop strain is that of bending alone"
        log.coded("strain-without-stretch", text)
    return radius


def _links_named(name: str, links: Sequence[Link], path: str) -> list[Link]:
    """Links of a table of the file, ``damper`` of a coupling or ``main.sun.neck``, one a branch.

    Raises
    ------
    ModelError : there is none, or none that twists: free or rigid about z, or by a table.
    """
    found = [link for link in links if link.path.partition(".")[2] == name]
    twisting = dict.fromkeys(link.path.partition(".")[2] for link in links if _twists(link))
    if not found:
        raise ModelError("no such link", path=path, given=name, allowed=", ".join(twisting) or "a link with rz")
    if not all(map(_twists, found)):
        k = found[0].stiffness[5]
        why = "rigid about z" if math.isinf(k) else "free about z" if k == 0 else "of a table about z"
        allowed = ", ".join([*twisting, "a member (on), for the torque of its teeth"])
        raise ModelError(f"the link is {why}: no spring tells its torque", path=path, given=name, allowed=allowed)
    return found


def _twists(link: Link) -> bool:
    """Whether a link has a linear spring about z."""
    return 0 < link.stiffness[5] < math.inf and all(direction != 5 for direction, _ in link.curves)


def _endings(bodies: Sequence[Body]) -> list[str]:
    """What follows the name of the sensor on each of several bodies: branch and side."""
    if len(bodies) < 2:
        return [""] * len(bodies)
    return ["".join(f"/{part}" for part in (body.branch, body.side) if part is not None) for body in bodies]
