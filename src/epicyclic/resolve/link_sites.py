"""One link of a model file at its site, and bolts on a pitch circle, each of which is a link of its own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..document.schema_fields import BoltsTable, ForceTableOf, LinkTable
from ..document.units import Quantity
from ..errors import ModelError
from ..teeth.mesh_stiffness import ForceCurve, force_curve
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link
from .bodies import member_centre
from .resolution_log import ResolutionLog, per_branch

__all__ = ["STIFF", "LinkSite", "bolted", "link_at"]

Six = tuple[float, float, float, float, float, float]
UNITS = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
STIFF = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSite:
    """Where a link sits: path in the file, name in results, bodies, branch (0 ..) of `count`, radius of rz in N/m.

    plate : side of the carrier plate it sits in, where there are two.
    """

    path: str
    name: str
    kind: str
    first: Body
    second: str | None
    turn: float
    branch: int = 0
    count: int = 1
    radius: float = 1.0
    share: float = 1.0
    to_housing: bool = False
    plate: str | None = None


def link_at(site: LinkSite, name: str, table: LinkTable, rest: Mapping[str, float], log: ResolutionLog) -> Link:
    """Link of one table at its site.

    rest : stiffness of the directions the table does not name [N/m, N m/rad].

    Raises
    ------
    ModelError : a list that does not fit the planets, an rz in N/m without radius.
    """
    path = f"{site.path}.{name}" if name else site.path
    carried = site.kind == "bearing" and site.second is not None
    station = site.first.station
    if table.at is not None:
        station = member_centre(site.first) + table.at
    curves = _curves(site, table, path)
    return Link(
        name=f"{site.name}/{name}" if name else site.name,
        path=path,
        kind=site.kind,
        first=site.second if carried and site.second is not None else site.first.name,
        second=site.first.name if carried else site.second,
        centre=site.first.centre,
        station=station,
        angle=site.turn,
        stiffness=_six(site, path, table, rest, curves, log),
        damping=_dampers(table, site.share),
        clearance=per_branch(table.clearance or 0.0, site.count, f"{path}.clearance")[site.branch],
        exponent=table.exponent if table.exponent is not None else 1.0,
        load=(table.load or 0.0) * site.share,
        friction=_friction(table, site.share),
        curves=tuple(curves.items()),
        to_housing=site.to_housing,
    )


def _curves(site: LinkSite, table: LinkTable, path: str) -> dict[int, ForceCurve]:
    """Force over deflection of the directions that state a table; at a shared site the share of the force."""
    found = {}
    for number, direction in enumerate(DIRECTIONS):
        stated = getattr(table, direction)
        if isinstance(stated, ForceTableOf):
            radius = 1.0
            if direction == "rz" and stated.deflection is not None and stated.deflection.unit == "m":
                radius = _known(site.radius, f"{path}.{direction}", "a table in m and N")
            curve = force_curve(*stated.curves[0])
            found[number] = curve.scaled(deflection=1 / radius, force=radius * site.share)
    return found


def _six(
    site: LinkSite,
    path: str,
    table: LinkTable,
    rest: Mapping[str, float],
    curves: Mapping[int, ForceCurve],
    log: ResolutionLog,
) -> Six:
    """Stiffness in x y z [N/m], rx ry rz [N m/rad]; at a shared site the share of finite ones.

    Of a direction that follows a table, the nominal one.
    """
    values = []
    for number, direction in enumerate(DIRECTIONS):
        stated = getattr(table, direction)
        if number in curves:
            values.append(curves[number].stiffness)
            log.note(f"{path}.{direction}.tangent", values[-1] / site.share, UNITS[direction], "half of its last force")
            continue
        if stated is None:
            value, origin = (
                rest[direction],
                "default" if math.isinf(rest[direction]) or not rest[direction] else "geometry",
            )
            log.note(f"{path}.{direction}", value, UNITS[direction], origin)
        else:
            whole = _torsional(stated, site.radius, f"{path}.{direction}") if isinstance(stated, Quantity) else stated
            value = per_branch(whole, site.count, f"{path}.{direction}")[site.branch]
            note = list(whole) if isinstance(whole, tuple) else whole
            log.note(f"{path}.{direction}", note, UNITS[direction])
        values.append(value * site.share if math.isfinite(value) else value)
    x, y, z, rx, ry, rz = values
    return x, y, z, rx, ry, rz


def _torsional(stated: Quantity, radius: float, path: str) -> float | tuple[float, ...]:
    """Torsional stiffness [N m/rad]; one in N/m acts at `radius` [m]. Raises ModelError for an unknown radius."""
    if stated.unit == "N m/rad":
        return stated.value
    radius = _known(radius, path, stated.value)
    if isinstance(stated.value, tuple):
        return tuple(value * radius**2 for value in stated.value)
    return stated.value * radius**2


def _known(radius: float, path: str, given: object) -> float:
    """A radius [m]. Raises ModelError for an unknown one."""
    if not math.isfinite(radius):
        raise ModelError("in N/m, but no radius is known", path=path, given=given, allowed="a value in N m/rad")
    return radius


def _dampers(table: LinkTable, share: float) -> Six:
    """Dampers in x y z [N s/m], rx ry rz [N m s/rad]; at a shared site the share."""
    if table.damping is None:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, rx, ry, rz = ((getattr(table.damping, d) or 0.0) * share for d in DIRECTIONS)
    return x, y, z, rx, ry, rz


def _friction(table: LinkTable, share: float) -> tuple[tuple[str, float | str], ...]:
    """Friction of a link as pairs of key and value: force [N], coefficient [1], radius [m], law."""
    if table.friction is None:
        return ()
    pairs = ((key, getattr(table.friction, key)) for key in ("force", "coefficient", "radius", "law"))
    return tuple((key, value * share if key == "force" else value) for key, value in pairs if value is not None)


# bolts ----------------------------------------------------------------------------------------------------------------


def bolted(site: Link, table: LinkTable, log: ResolutionLog) -> list[Link]:
    """A link and its bolts; the link itself only where it holds anything beside them.

    A bolt stands on the circle at its own angle, its x axis radial and its y axis tangential: with stiffness k_r, k_t,
    k_z of one, n >= 3 equal bolts evenly spaced on the radius r hold a member with x and y n (k_r + k_t)/2, rz
    n k_t r^2, z n k_z, rx and ry n k_z r^2/2.  A direction of a bolt that is not named is rigid.
    """
    bolts = table.bolts
    if bolts is None:
        return [site]
    path = f"{site.path}.bolts"
    log.note(f"{path}.radius", bolts.radius, "m")
    keys = ("radial", "tangential", "z")
    radial, tangential, z = (_stiffness(bolts, key, path, log) for key in keys)
    tables = [(number, getattr(bolts, key)) for number, key in enumerate(keys)]
    curves = tuple((i, force_curve(*one.curves[0])) for i, one in tables if isinstance(one, ForceTableOf))
    angles = bolts.angles
    if angles is None:
        angles = tuple(math.tau * i / (bolts.count or 1) for i in range(bolts.count or 1))
    found = [site] if any(site.stiffness) or any(site.damping) else []
    for number, angle in enumerate(angles, start=1):
        centre = (
            site.centre[0] + bolts.radius * math.cos(angle),
            site.centre[1] + bolts.radius * math.sin(angle),
        )
        name = f"{site.name}/bolts/{number}"
        found.append(
            replace(
                _plain(site),
                name=name,
                path=path,
                centre=centre,
                angle=angle,
                stiffness=(radial, tangential, z, 0.0, 0.0, 0.0),
                curves=curves,
            )
        )
    return found


def _plain(site: Link) -> Link:
    """The place of a link without dampers and laws, which are the site's own."""
    return Link(
        name=site.name,
        path=site.path,
        kind=site.kind,
        first=site.first,
        second=site.second,
        centre=site.centre,
        station=site.station,
        stiffness=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        to_housing=site.to_housing,
    )


def _stiffness(bolts: BoltsTable, key: str, path: str, log: ResolutionLog) -> float:
    """Stiffness of one bolt in one direction [N/m]; rigid where it is not named."""
    value: float | ForceTableOf | None = getattr(bolts, key)
    if isinstance(value, ForceTableOf):
        tangent = force_curve(*value.curves[0]).stiffness
        log.note(f"{path}.{key}.tangent", tangent, "N/m", "half of its last force")
        return tangent
    log.note(f"{path}.{key}", math.inf if value is None else value, "N/m", "default" if value is None else "given")
    return math.inf if value is None else value
