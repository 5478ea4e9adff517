"""Rings that bend: their section from the drawing, what their orders leave out, and bolts that turn about them.

Of a rectangular rim of height h, width b and mean radius R, E I is E int y^2/(1 + y/R) dA = E b R^2 (R ln(r_o/r_i) - h)
(Winkler), the shear stiffness 5/6 G A.  Beside plane elasticity (plane stress) the free ring has its natural
frequencies to 1.5 % up to h/R = 0.3 and n = 8.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..bodies.thin_ring import ThinRing, elastic_ring, order_compliances
from ..document.schema_fields import ElasticTable
from ..errors import ModelError
from .kinematics import Kinematics
from .mesh_laws import RING_ORDERS
from .stages import Levels, density_of, elastic_constants
from .train import Body, GearData, Link, Mesh, ResolutionLog

_SHEAR = 5 / 6
THICK = 0.3  # height per mean radius, beyond which it is no thin ring
_APART = 3.0  # mesh frequencies below the natural frequencies of orders that are left out
_ALL = 60
_REACH = 0.8, 1.3  # of its centre line and of its outer radius, within which bolts hold a ring
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
    # of a thin rim the logarithm cancels; its series is 1 + 3 h^2/(20 R^2)
    slender = height < 1e-2 * middle
    curved = (
        E
        * width
        * (
            height**3 / 12 * (1 + 0.15 * (height / middle) ** 2)
            if slender
            else middle**2 * (middle * math.log(outer / inner) - height)
        )
    )
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
        log.coded("thick-ring", f"{text}; a curved beam is right to 1.5 % up to {THICK:g}")
    return ring


def log_rings(
    bodies: Sequence[Body], links: Sequence[Link], meshes: Sequence[Mesh], kinematics: Kinematics, log: ResolutionLog
) -> None:
    """Log what the orders of a ring leave out: compliance beside that of a mesh, and natural frequencies; bolts off it.

    The stiffness of a mesh holds the former where it is that of teeth on their body.
    """
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
        outer = body.outer_radius or body.elastic.radius
        seats = {link.path: math.hypot(*link.centre) for link in links if link.first == body.name}
        for seat, radius in seats.items():
            if radius and not _REACH[0] * body.elastic.radius <= radius <= _REACH[1] * outer:
                text = f"{seat}.radius: {1e3 * radius:.4g} mm"
                log.coded(
                    "bolts-off-ring", f"{text}; the ring has its centre line at {1e3 * body.elastic.radius:.4g} mm"
                )


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


def standing_bolts(
    links: Sequence[Link], bodies: Sequence[Body], kinematics: Kinematics, log: ResolutionLog
) -> list[Link]:
    """Links, with bolts that turn against the frame of a ring that bends by their mean over the turn.

    Seen from the frame, bolts pass by.  Of N_b equal ones evenly spaced the stiffness is constant where N_b > 2 N, with
    the highest order N.  Else its mean is that of enough bolts of the same sum; a warning says how large
    the rest is.

    Raises
    ------
    ModelError : bolts that are rigid, or follow a table of force, where they turn.
    """
    rings = {body.name: body for body in bodies if body.elastic is not None}
    speed, frames = kinematics.speed or {}, kinematics.frame_speed or {}
    members = {body.name: body.member for body in bodies}
    groups: dict[tuple[str, str], list[Link]] = {}
    for link in links:
        if link.first in rings and "/bolts/" in link.name:
            seat = 0 if link.second is None else speed.get(members[link.second], 0)
            if Fraction(seat) != Fraction(frames.get(rings[link.first].frame, 0)):
                groups.setdefault((link.path, link.first), []).append(link)
    replaced = {link.name for bolts in groups.values() for link in bolts}
    found = [link for link in links if link.name not in replaced]
    for (path, name), bolts in groups.items():
        ring = rings[name].elastic
        assert ring is not None
        if bolts[0].curves or not all(map(math.isfinite, bolts[0].stiffness)):
            problem = "turn against the axes of the stage and are rigid, or follow a table"
            allowed = "radial, tangential and z as finite stiffnesses, or a rigid ring"
            raise ModelError(problem, path=path, allowed=allowed)
        varying = _varying_share(ring, bolts)
        turns = np.exp(1j * np.array([bolt.angle for bolt in bolts]))
        uneven = len(bolts) < 3 or max(abs((turns**n).sum()) for n in (1, 2)) > _EVEN * len(bolts)
        if varying < _EVEN or uneven:  # uneven ones are refused as beside a rigid ring
            found += bolts
            continue
        count = 2 * ring.orders + 1
        radius = math.hypot(*bolts[0].centre)
        text = f"{path}: {len(bolts)} bolts pass the axes of the stage and their mean over the turn is taken"
        text += f", forces are those of one bolt at {count} places that it passes"
        log.coded("bolts-averaged", f"{text}; of the stiffness on the waves up to {varying:.2g} varies")
        found += [
            replace(
                bolts[0],
                name=f"{bolts[0].name.rpartition('/')[0]}/{round(math.degrees(angle), 1):g} deg",
                centre=(radius * math.cos(angle), radius * math.sin(angle)),
                angle=angle,
                share=len(bolts) / count,
            )
            for angle in (math.tau * np.arange(count) / count).tolist()
        ]
    return found


def _varying_share(ring: ThinRing, bolts: Sequence[Link]) -> float:
    """Largest Fourier part K_l of the stiffness of bolts on the orders of a ring as they turn, per its mean K_0 [1]."""
    steps = 4 * ring.orders + 1
    angle = np.add.outer(math.tau * np.arange(steps) / steps, [bolt.angle for bolt in bolts]).ravel()
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    along = np.stack([-out[:, 1], out[:, 0], out[:, 2]], axis=1)
    moved = elastic_ring(ring).shape(math.hypot(*bolts[0].centre) * out)
    total: NDArray[np.float64] = np.zeros((steps, moved.shape[2], moved.shape[2]))
    for direction, k in zip((out, along), bolts[0].stiffness[:2], strict=True):
        rows = np.einsum("ra,rae->re", direction, moved[:, :3]).reshape(steps, len(bolts), -1)
        total += k * np.einsum("sbe,sbf->sef", rows, rows)
    size = np.linalg.norm(np.fft.fft(total, axis=0), axis=(1, 2))
    return float(size[1:].max() / size[0]) if size[0] else 0.0
