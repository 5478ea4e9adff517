"""Links of a stage and between stages: supports, bearings, necks, shafts, couplings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ..errors import ModelError
from ..model import schema_links as tables
from ..model.schema import Material, ModelFile
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link
from .bodies import body_name, member_bodies
from .bolts import bolted
from .centres import StageShape
from .gears import gap_of, width_of
from .ledger import Ledger
from .plan import Plan, sides_of
from .seats import STIFF, Seat, link_at
from .shafts import solid_stiffness

__all__ = ["couplings", "links_of_bodies", "links_of_stage"]


def links_of_stage(shape: StageShape, model: ModelFile, bodies: Mapping[str, Body], ledger: Ledger) -> list[Link]:
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
                    found += _support(shape, name, side, bodies[body], branch, bodies, held, ledger)
            found += _joints(shape, name, branch, bodies, model, ledger)
        if plan.split(name) and member.neck is None:
            _check_halves(plan, name, model)
    return found


def links_of_bodies(model: ModelFile, bodies: Mapping[str, Body], ledger: Ledger) -> list[Link]:
    """Supports of the file's `[bodies]`."""
    found: list[Link] = []
    for name, body in model.bodies.items():
        path = f"bodies.{name}.support"
        held = name in model.operation.held
        second = _carrying(body.support, bodies, None, path)
        seat = Seat(path=path, name=f"{name}/support", kind="support", first=bodies[name], second=second, turn=0.0)
        found += _bearings(seat, body.support, STIFF if held else 0.0, ledger)
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
    ledger: Ledger,
) -> list[Link]:
    """Support of a central body or bearing of a planet, every named bearing a link."""
    plan, member = shape.plan, shape.plan.stage.members[name]
    key = "support" if branch is None else "bearing"
    table, path = _sided(member, key, side, plan.member_path(name))
    carriers = _carriers(plan, side) if branch is not None and (table is None or table.to is None) else ()
    seconds: Sequence[str | None] = carriers or (_carrying(table, bodies, side, path),)
    found: list[Link] = []
    for second in seconds:
        plate = second.rsplit("/", 1)[-1] if second is not None and len(seconds) > 1 else None
        seat = Seat(
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
        found += _bearings(seat, table, STIFF if held else 0.0, ledger)
    return found


def _sided(member: object, key: str, side: str | None, path: str) -> tuple[tables.Support | None, str]:
    """A member's support with what its side says differently laid over it."""
    whole: tables.Support | None = getattr(member, key)
    own: tables.Support | None = getattr(getattr(member, side), key) if side and getattr(member, side) else None
    if own is None:
        return whole, f"{path}.{key}"
    where = f"{path}.{side}.{key}"
    if whole is None:
        return own, where
    said = {name: getattr(own, name) for name in own.model_fields_set}
    return whole.model_copy(update=said), where


def _carriers(plan: Plan, side: str | None) -> tuple[str, ...]:
    """Bodies that carry a planet: the carrier, of a split one the half of this side, both for a planet in one piece."""
    if plan.carrier is None:
        return ()
    sides = sides_of(plan, plan.carrier)
    if side is not None and side in sides:
        sides = (side,)
    return tuple(body_name(plan.name, plan.carrier, None, s) for s in sides)


def _carrying(table: tables.Support | None, bodies: Mapping[str, Body], side: str | None, path: str) -> str | None:
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


def _bearings(seat: Seat, support: tables.Support | None, rz: float, ledger: Ledger) -> list[Link]:
    """One link for every bearing; a direction that none names is rigid (rz as given), in the first one.

    Bolts hold in every direction, so that beside them nothing else is rigid that is not said to be.  Of two carrier
    plates a bearing sits in the one on its side of the planet's centre, in the middle half in each.
    """
    listed: list[tuple[str, tables.Link]] = []
    if support is None or not support.bearings or support.directions():
        listed.append(("", support if support is not None else tables.Link()))
    if support is not None:
        listed += list(support.bearings.items())
    named = {d for _, link in listed for d in link.directions()}
    if any(link.bolts is not None for _, link in listed):
        named = set(DIRECTIONS)
    found: list[Link] = []
    for i, (name, link) in enumerate(listed):
        rest: dict[str, float] = {d: 0.0 if d in named or i else (rz if d == "rz" else STIFF) for d in DIRECTIONS}
        if seat.plate is None or not link.at:
            half = seat if seat.plate is None else replace(seat, name=f"{seat.name}/{seat.plate}", share=0.5)
            found += bolted(link_at(half, name, link, rest, ledger), link, ledger)
        elif (seat.plate == "left") == (link.at < 0):
            found += bolted(link_at(seat, name, link, rest, ledger), link, ledger)
    return found


# necks, shafts, couplings --------------------------------------------------------------------------------------------


def _joints(
    shape: StageShape,
    name: str,
    branch: int | None,
    bodies: Mapping[str, Body],
    model: ModelFile,
    ledger: Ledger,
) -> list[Link]:
    """Neck between the halves of a member, and shaft to the member it sits on."""
    plan, member = shape.plan, shape.plan.stage.members[name]
    number = None if branch is None else branch + 1
    own = member_bodies(plan, name, number)
    material = _material(member.material, plan.stage.material, model.material)
    found = []
    if member.neck is not None:
        length = member.neck.length or (width_of(plan, name) or 0.0) + gap_of(plan, name)
        left, right = bodies[own["left"]], bodies[own["right"]]
        where = f"{plan.member_path(name)}.neck", f"{body_name(plan.name, name, number)}/neck", "neck"
        found.append(_joint(plan, where, left, right, member.neck, branch, length, material, ledger))
    if member.on is not None:
        base = member_bodies(plan, member.on.split(".")[-1], number)
        for side, body in own.items():
            first, second = bodies[base.get(side, next(iter(base.values())))], bodies[body]
            where = f"{plan.member_path(name)}.shaft", f"{body}/shaft", "shaft"
            table = member.shaft or tables.Solid()
            length = table.length or abs(second.station - first.station)
            found.append(_joint(plan, where, first, second, table, branch, length, material, ledger))
    return found


def _joint(
    plan: Plan,
    where: tuple[str, str, str],
    first: Body,
    second: Body,
    table: tables.Solid,
    branch: int | None,
    length: float,
    material: tuple[float, float],
    ledger: Ledger,
) -> Link:
    """A solid between two bodies of one axis; what its shape does not say is rigid."""
    path, name, kind = where
    if table.diameter is not None and length <= 0:
        raise ModelError("is missing", path=f"{path}.length", allowed="length of the shaft [m]")
    rest: dict[str, float] = {d: STIFF for d in DIRECTIONS} | solid_stiffness(table, length, material)
    seat = Seat(
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
    link = link_at(seat, "", table, rest, ledger)
    middle = (first.station + second.station) / 2
    return replace(link, station=middle if table.at is None else middle + table.at)


def couplings(model: ModelFile, bodies: Mapping[str, Body], ledger: Ledger) -> list[Link]:
    """All couplings.

    Raises
    ------
    ModelError : an end that is no single body, an rz in N/m without radius, a fixed shaft without its shape.
    """
    material = _material(model.material)
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
        seat = Seat(
            path=path, name=name, kind="coupling", first=first, second=second.name, turn=0.0, radius=table.radius or 1.0
        )
        middle = (first.station + second.station) / 2
        link = replace(link_at(seat, "", table, rest, ledger), station=middle + (table.at or 0.0))
        found += bolted(link, table, ledger)
    return found


def _material(*tables_: Material | None) -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson's ratio, nearest first."""

    def nearest(key: str, default: float) -> float:
        values: Iterable[float | None] = (getattr(t, key) for t in tables_ if t is not None)
        return next((v for v in values if v is not None), default)

    return nearest("youngs_modulus", 206e9), nearest("poisson_ratio", 0.3)


def _check_halves(plan: Plan, name: str, model: ModelFile) -> None:
    """Halves without a neck need something else that keeps each of them from turning away."""
    if not plan.central(name):
        return
    member, key = plan.stage.members[name], f"{plan.name}.{name}"
    if key in model.operation.held:
        return
    ends = {end for table in model.couplings.values() for end in table.between}
    for side in ("left", "right"):
        table, _ = _sided(member, "support", side, "")
        links = [] if table is None else [table, *table.bearings.values()]
        sprung = any(link.rz is not None and link.rz.value != 0.0 for link in links)
        if not sprung and f"{key}.{side}" not in ends:
            raise ModelError(
                f"nothing holds the {side} half: neither neck nor hold",
                path=plan.member_path(name),
                given="split = true",
                allowed="a neck, a held member, support.rz, or a coupling at each half",
            )
