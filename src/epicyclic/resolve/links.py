"""Links of a stage and between stages: supports, bearings, necks, shafts, couplings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..document import schema_fields as tables
from ..document.schema import ModelFile
from ..errors import ModelError
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link
from .bodies import body_name, member_bodies
from .centres import StageShape
from .gears import gap_of, width_of
from .inheritance import overlaid
from .link_sites import STIFF, LinkSite, bolted, link_at
from .materials import elastic_constants, file_material, member_material
from .plan import Plan, gear_below, sides_of
from .resolution_log import ResolutionLog
from .shaft_stiffness import solid_stiffness
from .tilt import held_by_distance

__all__ = ["couplings", "links_of_bodies", "links_of_stage"]


def links_of_stage(shape: StageShape, model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog) -> list[Link]:
    """All links of a stage.

    Raises
    ------
    ModelError : halves that nothing holds together, a member that carries nothing it could carry.
    """
    plan = shape.plan
    found: list[Link] = []
    for name, member in plan.stage.members.items():
        planet = not plan.central(name)
        for branch in range(plan.branches) if planet else (None,):
            number = None if branch is None else branch + 1
            names = member_bodies(plan, name, number)
            for side, body in names.items():
                if member.on is None or (member.bearing if planet else member.support) is not None:
                    held = f"{plan.name}.{name}" in model.operation.held
                    found += _support(shape, name, side, bodies[body], branch, bodies, held, log)
            found += _joints(shape, name, branch, bodies, model, log)
        if plan.split(name) and member.neck is None:
            _check_halves(plan, name, model)
    return found


def links_of_bodies(model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog) -> list[Link]:
    """Supports of the file's `[bodies]`."""
    found: list[Link] = []
    for name, body in model.bodies.items():
        path = f"bodies.{name}.support"
        held = name in model.operation.held
        second = _carrying(body.support, bodies, None, path)
        site = LinkSite(path=path, name=f"{name}/support", kind="support", first=bodies[name], second=second, turn=0.0)
        found += _bearings(site, body.support, STIFF if held else 0.0, log)
    return found


# supports and bearings -----------------------------------------------------------------------------------------------


def _support(
    shape: StageShape,
    name: str,
    side: str | None,
    body: Body,
    branch: int | None,
    bodies: Mapping[str, Body],
    held: bool,
    log: ResolutionLog,
) -> list[Link]:
    """Support of a central body or bearing of a planet, every named bearing a link."""
    plan = shape.plan
    key = "support" if branch is None else "bearing"
    table, path = overlaid(plan.member_levels(name, side), key)
    carriers = _carriers(plan, side) if branch is not None and (table is None or table.to is None) else ()
    seconds: Sequence[str | None] = carriers or (_carrying(table, bodies, side, path),)
    if body.name in seconds and table is not None:
        raise ModelError(
            "holds a body on itself", path=f"{path}.to", given=table.to, allowed="housing, or another body"
        )
    found: list[Link] = []
    for second in seconds:
        plate = second.rsplit("/", 1)[-1] if second is not None and len(seconds) > 1 else None
        site = LinkSite(
            path=path,
            name=f"{body.name}/{key}",
            kind=key,
            first=body,
            second=second,
            turn=body.angle,
            branch=branch or 0,
            count=plan.branches if branch is not None else 1,
            radius=body.reference_radius,
            to_housing=second is None and branch is None and plan.carrier is not None,
            plate=plate,
        )
        found += _bearings(site, table, STIFF if held else 0.0, log)
    return found


def _carriers(plan: Plan, side: str | None) -> tuple[str, ...]:
    """Bodies that carry a planet: the carrier, of a split one the half of this side, both for a planet in one piece."""
    if plan.carrier is None:
        return ()
    sides = sides_of(plan, plan.carrier)
    if side is not None and side in sides:
        sides = (side,)
    return tuple(body_name(plan.name, plan.carrier, None, s) for s in sides)


def _carrying(table: tables.SupportTable | None, bodies: Mapping[str, Body], side: str | None, path: str) -> str | None:
    """Body that `to` names, None = the frame."""
    if table is None or table.to is None or table.to == "housing":
        return None
    return body_of(table.to, bodies, f"{path}.to", side)


def body_of(reference: str, bodies: Mapping[str, Body], path: str, side: str | None = None) -> str:
    """Body of a reference such as ``main.sun.right``; of a split member the half of the same side.

    Raises
    ------
    ModelError : a planet, which there is several of, or a split member without a side.
    """
    parts = reference.split(".")
    found = [
        body.name
        for body in bodies.values()
        if body.member == ".".join(parts[:2]) and (len(parts) < 3 or body.side == parts[2]) and body.branch is None
    ]
    same_side = [name for name in found if bodies[name].side == side] if len(found) > 1 else found
    if len(same_side) != 1:
        split = len(found) > 1
        raise ModelError(
            "names a split member" if split else "names no single body",
            path=path,
            given=reference,
            allowed=f"{reference}.left or {reference}.right" if split else "a central member or a body",
        )
    return same_side[0]


def _bearings(site: LinkSite, support: tables.SupportTable | None, rz: float, log: ResolutionLog) -> list[Link]:
    """One link for every bearing; a direction that none names is rigid (rz: `rz` [N m/rad]), in the first one.

    Tilt that none names is rigid too, but where two bearings at a distance hold it by their own stiffness.
    Bolts hold in every direction, so that beside them no other direction is rigid unless named.  Of two carrier plates
    a bearing sits in the one on its side of the planet's centre, in the middle half in each.
    """
    listed: list[tuple[str, tables.LinkTable]] = []
    if support is None or not support.bearings or support.directions():
        listed.append(("", support if support is not None else tables.LinkTable()))
    if support is not None:
        listed += list(support.bearings.items())
    named = {d for _, link in listed for d in link.directions()}
    if any(link.bolts is not None for _, link in listed):
        named = set(DIRECTIONS)
    named |= held_by_distance([link for _, link in listed], site.branch)
    found: list[Link] = []
    for i, (name, link) in enumerate(listed):
        rest: dict[str, float] = {d: 0.0 if d in named or i else (rz if d == "rz" else STIFF) for d in DIRECTIONS}
        if site.plate is None or not link.at:
            half = site if site.plate is None else replace(site, name=f"{site.name}/{site.plate}", share=0.5)
            found += bolted(link_at(half, name, link, rest, log), link, log)
        elif (site.plate == "left") == (link.at < 0):
            found += bolted(link_at(site, name, link, rest, log), link, log)
    return found


# necks, shafts, couplings --------------------------------------------------------------------------------------------


def _joints(
    shape: StageShape,
    name: str,
    branch: int | None,
    bodies: Mapping[str, Body],
    model: ModelFile,
    log: ResolutionLog,
) -> list[Link]:
    """Neck between the halves of a member, and shaft to the member it sits on."""
    plan, member = shape.plan, shape.plan.stage.members[name]
    number = None if branch is None else branch + 1
    own = member_bodies(plan, name, number)
    material = elastic_constants(member_material(plan, name, model))
    found = []
    if member.neck is not None:
        length = member.neck.length or (width_of(plan, name) or 0.0) + gap_of(plan, name)
        left, right = bodies[own["left"]], bodies[own["right"]]
        where = f"{plan.member_path(name)}.neck", f"{body_name(plan.name, name, number)}/neck", "neck"
        found.append(_joint(plan, where, left, right, member.neck, branch, length, material, log))
    if (below := gear_below(member)) is not None:
        base = member_bodies(plan, below, number)
        for side, body in own.items():
            first, second = bodies[base.get(side, next(iter(base.values())))], bodies[body]
            where = f"{plan.member_path(name)}.shaft", f"{body}/shaft", "shaft"
            table = member.shaft or tables.SolidTable()
            length = table.length or abs(second.station - first.station)
            found.append(_joint(plan, where, first, second, table, branch, length, material, log))
    return found


def _joint(
    plan: Plan,
    where: tuple[str, str, str],
    first: Body,
    second: Body,
    table: tables.SolidTable,
    branch: int | None,
    length: float,
    material: tuple[float, float],
    log: ResolutionLog,
) -> Link:
    """Link of a solid between two bodies of one axis; directions its shape does not give are rigid.

    where : path in the file, name and kind.  length [m].  material : Young's modulus [Pa], Poisson's ratio [1].

    Raises
    ------
    ModelError : a diameter without length.
    """
    path, name, kind = where
    if table.diameter is not None and length <= 0:
        raise ModelError("is missing", path=f"{path}.length", allowed="length of the shaft [m]")
    rest: dict[str, float] = {d: STIFF for d in DIRECTIONS} | solid_stiffness(table, length, material)
    site = LinkSite(
        path=path,
        name=name,
        kind=kind,
        first=first,
        second=second.name,
        turn=first.angle,
        branch=branch or 0,
        count=plan.branches if branch is not None else 1,
        radius=first.reference_radius,
    )
    link = link_at(site, "", table, rest, log)
    middle = (first.station + second.station) / 2
    return replace(link, station=middle if table.at is None else middle + table.at)


def couplings(model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog) -> list[Link]:
    """All couplings.

    Raises
    ------
    ModelError : an end that is no single body, an rz in N/m without radius, a fixed shaft without its shape.
    """
    material = elastic_constants(file_material(model))
    found: list[Link] = []
    for name, table in model.couplings.items():
        path = f"couplings.{name}"
        first, second = (bodies[body_of(end, bodies, f"{path}.between")] for end in table.between)
        shape = solid_stiffness(table, table.length or 0.0, material)
        if (table.diameter is not None or table.torsional_rigidity is not None) and table.length is None:
            raise ModelError("is missing", path=f"{path}.length", allowed="length of the shaft [m]")
        if table.ends == "fixed" and not {"x", "rz"} <= {*shape, *table.directions()}:
            raise ModelError(
                "is missing", path=f"{path}.diameter", allowed="diameter and length of a shaft with fixed ends"
            )
        rest: dict[str, float] = dict.fromkeys(("x", "y", "z", "rx", "ry"), 0.0)
        rest["rz"] = shape.get("rz", STIFF if table.bolts is None else 0.0)
        if table.ends == "fixed":
            rest |= shape
        site = LinkSite(
            path=path, name=name, kind="coupling", first=first, second=second.name, turn=0.0, radius=table.radius or 1.0
        )
        middle = (first.station + second.station) / 2
        link = replace(link_at(site, "", table, rest, log), station=middle + (table.at or 0.0))
        found += bolted(link, table, log)
    return found


def _check_halves(plan: Plan, name: str, model: ModelFile) -> None:
    """Halves without a neck need something else that keeps each of them from turning away."""
    if not plan.central(name):
        return
    key = f"{plan.name}.{name}"
    if key in model.operation.held:
        return
    ends = {end for table in model.couplings.values() for end in table.between}
    for side in ("left", "right"):
        table, _ = overlaid(plan.member_levels(name, side), "support")
        links = [] if table is None else [table, *table.bearings.values()]
        sprung = any(link.rz is not None and link.rz.value != 0.0 for link in links)
        if not sprung and f"{key}.{side}" not in ends:
            raise ModelError(
                f"nothing holds the {side} half: neither neck nor hold",
                path=plan.member_path(name),
                given="split = true",
                allowed="a neck, a held member, support.rz, or a coupling at each half",
            )
