"""Bodies of a train that bend: rings, and bodies by the matrices of a finite-element program.

Of a rectangular rim of height h, width b and mean radius R, E I is E int y^2/(1 + y/R) dA = E b R^2 (R ln(r_o/r_i) - h)
(Winkler), the shear stiffness 5/6 G A.  Beside plane elasticity (plane stress) the free ring has its natural
frequencies to 1.1 % up to h/R = 0.3 and n = 8.  What the orders of a ring leave out is told; bolts that turn about it
pass at evenly spaced places.

Matrices are read, reduced, and joined to what stands at their interfaces.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bodies.elastic_body import ElasticBody, ThinRing, about_z, order_compliances
from ..document.schema import ModelFile
from ..document.schema_fields import MATRIX_FILES, ElasticTable, ReducedTable
from ..errors import ModelError
from ..warning_codes import coded
from .kinematics import Kinematics
from .mesh_laws import RING_ORDERS
from .stages import Levels, density_of, elastic_constants
from .train import MASS_UNITS, Body, GearData, Link, Mesh, ResolutionLog

if TYPE_CHECKING:
    from ..bodies.joined_body import Interface, InterfaceShape
    from ..bodies.reduced_body import BodyFacts, ReducedBody

_SHEAR = 5 / 6
THICK = 0.3  # height per mean radius, beyond which it is no thin ring
_APART = 3.0  # mesh frequencies below the natural frequencies of orders that are left out
_ALL = 60
_REACH = 0.8, 1.3  # of its centre line and of its outer radius, within which bolts hold a ring
_MANY = 8  # orders of a tone of links that pass, beyond which a speed of the response takes seconds
_EVEN = 1e-9  # angles of bolts carry rounding


def ring_of(
    table: ElasticTable,
    path: str,
    gear: GearData,
    rim: tuple[float, float],
    mass: float,
    material: Levels,
    log: ResolutionLog,
) -> ThinRing:
    """The ring that a table describes.

    rim : outer radius and width of the body [m], nan where they are not known.  mass : of the body [kg].

    Raises
    ------
    ModelError : neither a section nor a rim from which it follows.
    """
    (outer, width), inner = rim, gear.root_radius
    E, nu = elastic_constants(material)
    height, middle = outer - inner, (outer + inner) / 2
    radius = middle if table.radius is None else table.radius
    area = width * height if table.area is None else table.area
    curved = E * width * _second_moment(middle, height)
    bending = curved if table.bending is None else table.bending
    axial = math.inf if table.axial is None else E * area if table.axial == "area" else float(table.axial)
    needed = {"radius": radius, "bending": bending, "area": 1.0 if table.axial != "area" else area}
    if missing := [key for key, value in needed.items() if not math.isfinite(value)]:
        allowed = f"rim or outer_diameter, and face_width; or {', '.join(missing)} in the table"
        raise ModelError("no section of the ring is known", path=path, allowed=allowed)
    if radius > outer or (table.radius is None and height <= 0):
        raise ModelError("the centre line is outside the ring", path=path, given=radius, allowed=f"up to {outer:g} m")
    known = math.isfinite(area)
    line_mass = mass / (math.tau * radius) if math.isfinite(mass) else density_of(material) * area
    held = table.foundation
    ring = ThinRing(
        radius=radius,
        line_mass=line_mass,
        bending=bending,
        axial=axial,
        shear=_SHEAR * E / (2 * (1 + nu)) * area if known else math.inf,
        line_inertia=density_of(material) * bending / E if known else 0.0,
        orders=table.modes or RING_ORDERS,
        foundation=(0.0, 0.0) if held is None else (held.radial or 0.0, held.tangential or 0.0),
    )
    values = {"radius": (radius, "m"), "area": (area, "m^2"), "bending": (bending, "N m^2"), "axial": (axial, "N")}
    for key, (value, unit) in values.items():
        if math.isfinite(value):
            stated = getattr(table, key)
            log.note(f"{path}.{key}", value, unit, "geometry" if stated in (None, "area") else "given")
    log.note(f"{path}.modes", ring.orders, "", "default" if table.modes is None else "given")
    log.note(f"{path}.line_mass", line_mass, "kg/m", "geometry")
    thick = math.sqrt(12 * bending / (E * area)) if known else height
    if thick > THICK * radius:
        text = f"{path}: the rim is {thick / radius:.2g} of its mean radius high"
        log.coded("thick-ring", f"{text}; a curved beam is right to 1.1 % up to {THICK:g}")
    return ring


def _second_moment(radius: float, height: float) -> float:
    """int y^2/(1 + y/R) dy over the height of a rim [m^3], by quadrature, as the logarithm of a thin one cancels."""
    x, weight = np.polynomial.legendre.leggauss(20)
    y = height / 2 * x
    return float(height / 2 * weight @ (y**2 / (1 + y / radius)))


def log_rings(
    bodies: Sequence[Body], links: Sequence[Link], meshes: Sequence[Mesh], kinematics: Kinematics, log: ResolutionLog
) -> None:
    """Log what the orders of a ring leave out: compliance beside that of a mesh, and natural frequencies; and bolts.

    The stiffness of a mesh holds the former where it is that of teeth on their body.

    Raises
    ------
    ModelError : bolts in the housing that hold a body along a circle on which it turns.
    """
    members, speed = {body.name: body.member for body in bodies}, kinematics.speed or {}
    for link in links:
        if "/bolts/" in link.name and link.second is None and link.stiffness[1] and speed.get(members[link.first]):
            problem, given = (
                "bolts in the housing hold a body that turns",
                f"{float(speed[members[link.first]]):.6g} rpm",
            )
            raise ModelError(problem, path=link.path, given=given, allowed="a body that stands, or tangential = 0")
    rate = max(map(float, (kinematics.mesh_frequency or {}).values()), default=0.0)
    for body in bodies:
        if body.elastic is None:
            continue
        path, orders = f"stages.{body.member}.elastic", body.elastic.orders
        beyond = body.elastic.frequency(orders + 1)
        log.note(f"{path}.left_out", _left_out(body, meshes), "", "geometry")
        log.note(f"{path}.lowest_left_out", beyond, "Hz", "geometry")
        if beyond <= _APART * rate:
            text = f"{path}: orders beyond {orders} begin at {beyond:.4g} Hz"
            log.coded("ring-orders", f"{text}, the mesh frequency is {rate:.4g} Hz")
        if (planets := len({mesh.branch for mesh in meshes if mesh.b == body.name})) > orders:
            text = f"{path}: {planets} planets drive the orders {planets}, {2 * planets}, ..; orders end at {orders}"
            log.coded("ring-orders", text)
        outer = body.outer_radius or body.elastic.radius
        seats = {link.path: math.hypot(*link.centre) for link in links if link.first == body.name}
        for seat, radius in seats.items():
            if radius and not _REACH[0] * body.elastic.radius <= radius <= _REACH[1] * outer:
                text = f"{seat}.radius: {1e3 * radius:.4g} mm"
                text += f"; the ring has its centre line at {1e3 * body.elastic.radius:.4g} mm"
                log.coded("bolts-off-ring", text)
    for passing in passing_links(links, bodies, kinematics):
        one, count = passing.links[0], len(passing.links)
        text = f"{one.path}: {count} bolt{'s pass' if count > 1 else ' passes'}"
        text += f" the axes of the stage, a tone of {float(passing.tone):.4g} Hz with {passing.series.shape[1]} orders"
        text += " for response, stability and transient; all else takes the mean over the turn"
        if one.second is None:
            text += f", of the stiffness up to {passing.varying:.2g} varies; forces are those of one bolt at"
            text += f" {passing.places} places that it passes, and in static sensors of force have all bolts alike"
            ring = next(body.elastic for body in bodies if body.name == one.first)
            if isinstance(ring, ThinRing) and ring.orders < count:
                text += f"; with {ring.orders} orders the force of a bolt is not whole, from {count} on it is"
        else:
            text += ", which joins only motions along and about the axis"
        if passing.series.shape[1] > _MANY:
            text += "; of fewer modes of the ring they are fewer, and the response is faster"
        log.coded("bolts-averaged", text)


def _left_out(body: Body, meshes: Sequence[Mesh]) -> float:
    """Compliance of the orders of a ring that are left out, along a mesh, per compliance of the stiffest mesh."""
    assert body.elastic is not None
    left, more = [0.0], replace(body.elastic, orders=_ALL)
    for mesh in meshes:
        if mesh.b == body.name:
            normal = (math.sin(mesh.pressure_angle), math.cos(mesh.pressure_angle))
            beyond = order_compliances(more, normal, mesh.radius_b)[body.elastic.orders + 1 :].sum()
            left.append(mesh.stiffness * math.cos(mesh.base_helix) ** 2 * float(beyond))
    return max(left)


def passes(link: Link, body: Body, bodies: Sequence[Body], kinematics: Kinematics) -> bool:
    """Whether what is on the other side of a link of a body turns against the frame of the body."""
    return _passing_speed(link, body, bodies, kinematics) != 0


def _passing_speed(link: Link, body: Body, bodies: Sequence[Body], kinematics: Kinematics) -> Fraction:
    """Speed [rpm] of what is on the other side of a link of a body, against the frame of the body."""
    other = link.second if link.first == body.name else link.first
    return kinematics.against(next((b.member for b in bodies if b.name == other), None), body.frame)


class PassingLinks(NamedTuple):
    """Links that pass a body, whose stiffness on it varies with their passing.

    The product of two rows of an axisymmetric body is a trigonometric polynomial of the angle, of order 2 W where W is
    its highest number of waves.  So P > 2 W + m evenly spaced places interpolate it exactly between m-th multiples of
    the turn: n links stand for k_j(t) = n k/P (1 + Re sum_l series[j, l-1] exp(2 pi i l tone t)) at each place j.
    Derived here.

    Of links between two bodies, whose places on the other body differ, each stands for k_j(t) with n = 1.

    links : of one stiffness.  second : whether the body is the second one of the links.
    tone : exact [rev/s].  series : (P, L) relative [1].
    varying : largest Fourier part K_l of the stiffness on mean motion and waves of the body, per its mean K_0
        (Frobenius norms), 1 of links to another body [1].
    """

    links: list[Link]
    second: bool
    tone: Fraction
    series: NDArray[np.complex128]
    varying: float

    @property
    def places(self) -> int:
        """P."""
        return len(self.series)


def passing_links(links: Sequence[Link], bodies: Sequence[Body], kinematics: Kinematics) -> list[PassingLinks]:
    """Bolts that pass axisymmetric bodies that bend, and links between bodies of two frames of which one bends.

    Not those whose stiffness is constant: more even bolts in the housing than twice the waves, links along z and about
    it.  Others beside rigid bodies are none of them: they are refused.

    Raises
    ------
    ModelError : links that are rigid, follow a law or hold a body that turns against its frame, where they pass.
    """
    groups: dict[tuple[str, str], list[Link]] = {}
    by_name = {body.name: body for body in bodies}
    for link in links:
        if (passed := _passed(link, by_name, bodies, kinematics)) is not None:
            groups.setdefault((link.path, passed.name), []).append(link)
    found = []
    for (_, name), passing in groups.items():
        body = by_name[name]
        one, bending, rate = passing[0], body.bending, _passing_speed(passing[0], body, bodies, kinematics) / 60
        _require_linear(one)
        waves = 1 if bending is None else bending.waves or 1
        turns = np.exp(1j * (np.array([link.angle for link in passing]) - one.angle))
        sums = {m: 1.0 + 0j if one.second else complex((turns**m).mean()) for m in range(1, 2 * waves + 1)}
        orders = [m for m, value in sums.items() if abs(value) > _EVEN]
        varying = 1.0
        if one.second is None and bending is not None:
            varying = _varying_share(bending, waves, passing, one.station - body.station)
        if varying <= _EVEN:
            continue
        places, step = 2 * waves + max(orders) + 1, math.gcd(*orders)
        series = np.zeros((places, max(orders) // step), complex)
        for m in orders:
            wave = 2 * sums[m] * np.exp(-2j * np.pi * m * np.arange(places) / places)
            series[:, m // step - 1] = wave if rate > 0 else wave.conj()
        found.append(PassingLinks(passing, one.second == body.name, abs(rate) * step, series, varying))
    return found


def _passed(link: Link, by_name: Mapping[str, Body], bodies: Sequence[Body], kinematics: Kinematics) -> Body | None:
    """The axisymmetric body that a link passes; None where its stiffness is constant, or no body of it bends."""
    ends = [by_name[name] for name in (link.first, link.second) if name is not None]
    lateral = any(link.stiffness[d] for d in (0, 1, 3, 4))
    if not lateral or all(body.bending is None for body in ends) or (len(ends) == 1 and "/bolts/" not in link.name):
        return None
    for body, other in zip(ends, ends[::-1] if len(ends) == 2 else [None], strict=True):
        bending = body.bending
        axisymmetric = body.branch is None if bending is None else bending.waves is not None
        # the axes of the link are those of the other body, which has to stand still in its frame
        still = other is None or not kinematics.against(other.member, other.frame)
        if axisymmetric and still and passes(link, body, bodies, kinematics):
            return body
    return None


def _require_linear(link: Link) -> None:
    """Refuse a link that passes a body and has no constant finite stiffness of its own."""
    law = link.curves or link.contacts or link.clearance or link.exponent != 1.0 or link.friction
    if law or not all(map(math.isfinite, link.stiffness)):
        problem = "turn against the axes of the stage and are rigid, or follow a law"
        allowed = (
            "finite stiffnesses in all directions, without clearance, exponent, friction and table; or rigid bodies"
        )
        raise ModelError(problem, path=link.path, allowed=allowed)
    if link.second is not None and any(link.damping):
        problem = "has dampers between bodies of different frames, whose stiffness varies with their passing"
        raise ModelError(problem, path=link.path, allowed="damping of the train, or of other links")


def _varying_share(body: ElasticBody, waves: int, bolts: Sequence[Link], z: float) -> float:
    """`PassingLinks.varying` of bolts at a place z along the axis from the centre of the body [m]."""
    steps = 4 * waves + 1
    angle = np.add.outer(math.tau * np.arange(steps) / steps, [bolt.angle for bolt in bolts]).ravel()
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    along = np.stack([-out[:, 1], out[:, 0], out[:, 2]], axis=1)
    radius = math.hypot(*bolts[0].centre)
    points = radius * out + [0.0, 0.0, z]
    moved, total = body.shape(points)[:, :3], np.zeros((steps, 6 + len(body.names), 6 + len(body.names)))
    axes = out, along, np.broadcast_to([0.0, 0.0, 1.0], out.shape)
    for direction, k in zip(axes, bolts[0].stiffness[:3], strict=True):
        # of the mean motion too, rotations by the displacement on the circle
        bent, mean = np.einsum("ra,rae->re", direction, moved), np.cross(points, direction) / radius
        rows = np.hstack([direction, mean, bent]).reshape(steps, len(bolts), -1)
        total += k * np.einsum("sbe,sbf->sef", rows, rows)
    size = np.linalg.norm(np.fft.fft(total, axis=0), axis=(1, 2))
    return float(size[1:].max() / size[0]) if size[0] else 0.0


# bodies by matrices ---------------------------------------------------------------------------------------------------

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
    from ..bodies.files import read_body
    from ..bodies.joined_body import axisymmetric, joined_body, reduced, turning_with_frame

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
    from ..bodies.joined_body import Interface

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
    if joined.waves is not None:
        return
    if kinematics.against(body.member, body.frame):
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
