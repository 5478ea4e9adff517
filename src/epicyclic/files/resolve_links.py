"""Links of a stage and between stages: supports, bearings, necks, shafts, couplings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from ..errors import ModelError
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link
from . import schema_links as tables
from .resolve_bodies import body_name, member_bodies, member_centre
from .resolve_centres import StageShape
from .resolve_gears import gap_of, width_of
from .resolve_ledger import Ledger, per_branch
from .resolve_plan import Plan, sides_of
from .resolve_shafts import solid_stiffness
from .schema import Material, ModelFile, Quantity

__all__ = ["couplings", "links_of_bodies", "links_of_stage"]

Six = tuple[float, float, float, float, float, float]
UNITS = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
STIFF = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seat:
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
        seat = _Seat(path=path, name=f"{name}/support", kind="support", first=bodies[name], second=second, turn=0.0)
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
        seat = _Seat(
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


def _bearings(seat: _Seat, support: tables.Support | None, rz: float, ledger: Ledger) -> list[Link]:
    """One link for every bearing; a direction that none names is rigid (rz as given), in the first one.

    Of two carrier plates a bearing sits in the one on its side of the planet's centre, in the middle half in each.
    """
    listed: list[tuple[str, tables.Link]] = []
    if support is None or not support.bearings or support.directions():
        listed.append(("", support if support is not None else tables.Link()))
    if support is not None:
        listed += list(support.bearings.items())
    named = {d for _, link in listed for d in link.directions()}
    found = []
    for i, (name, link) in enumerate(listed):
        rest: dict[str, float] = {d: 0.0 if d in named or i else (rz if d == "rz" else STIFF) for d in DIRECTIONS}
        if seat.plate is None or not link.at:
            half = seat if seat.plate is None else replace(seat, name=f"{seat.name}/{seat.plate}", share=0.5)
            found.append(_link(half, name, link, rest, ledger))
        elif (seat.plate == "left") == (link.at < 0):
            found.append(_link(seat, name, link, rest, ledger))
    return found


def _link(seat: _Seat, name: str, table: tables.Link, rest: Mapping[str, float], ledger: Ledger) -> Link:
    """One link from its table; `rest` is what stands for directions it does not name."""
    path = f"{seat.path}.{name}" if name else seat.path
    carried = seat.kind == "bearing" and seat.second is not None
    station = seat.first.station
    if table.at is not None:
        station = member_centre(seat.first) + table.at
    return Link(
        name=f"{seat.name}/{name}" if name else seat.name,
        path=path,
        kind=seat.kind,
        first=seat.second if carried and seat.second is not None else seat.first.name,
        second=seat.first.name if carried else seat.second,
        centre=seat.first.centre,
        station=station,
        angle=seat.turn,
        stiffness=_six(seat, path, table, rest, ledger),
        damping=_dampers(table, seat.share),
        clearance=per_branch(table.clearance, seat.count, f"{path}.clearance")[seat.branch],
        exponent=table.exponent if table.exponent is not None else 1.0,
        load=(table.load or 0.0) * seat.share,
        friction=_friction(table, seat.share),
        to_housing=seat.to_housing,
    )


def _six(seat: _Seat, path: str, table: tables.Link, rest: Mapping[str, float], ledger: Ledger) -> Six:
    values = []
    for direction in DIRECTIONS:
        said = getattr(table, direction)
        if said is None:
            value, origin = (
                rest[direction],
                "default" if math.isinf(rest[direction]) or not rest[direction] else "geometry",
            )
            ledger.note(f"{path}.{direction}", value, UNITS[direction], origin)
        else:
            whole = _torsional(said, seat.radius, f"{path}.{direction}") if isinstance(said, Quantity) else said
            value = per_branch(whole, seat.count, f"{path}.{direction}")[seat.branch]
            note = list(whole) if isinstance(whole, tuple) else whole
            ledger.note(f"{path}.{direction}", note, UNITS[direction])
        values.append(value * seat.share if math.isfinite(value) else value)
    x, y, z, rx, ry, rz = values
    return x, y, z, rx, ry, rz


def _torsional(said: Quantity, radius: float, path: str) -> float | tuple[float, ...]:
    """A torsional stiffness in N m/rad; one in N/m acts at a radius."""
    if said.unit == "N m/rad":
        return said.value
    if not math.isfinite(radius):
        raise ModelError("in N/m, but no radius is known", path=path, given=said.value, allowed="a value in N m/rad")
    if isinstance(said.value, tuple):
        return tuple(value * radius**2 for value in said.value)
    return said.value * radius**2


def _dampers(table: tables.Link, share: float) -> Six:
    if table.damping is None:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, rx, ry, rz = ((getattr(table.damping, d) or 0.0) * share for d in DIRECTIONS)
    return x, y, z, rx, ry, rz


def _friction(table: tables.Link, share: float) -> tuple[tuple[str, float | str], ...]:
    if table.friction is None:
        return ()
    pairs = ((key, getattr(table.friction, key)) for key in ("force", "coefficient", "radius", "law"))
    return tuple((key, value * share if key == "force" else value) for key, value in pairs if value is not None)


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
    seat = _Seat(
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
    link = _link(seat, "", table, rest, ledger)
    middle = (first.station + second.station) / 2
    return replace(link, station=middle if table.at is None else middle + table.at)


def couplings(model: ModelFile, bodies: Mapping[str, Body], ledger: Ledger) -> list[Link]:
    """All couplings.

    Raises
    ------
    ModelError : an end that is no single body, an rz in N/m without radius, a fixed shaft without its shape.
    """
    material = _material(model.material)
    found = []
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
        rest["rz"] = shape.get("rz", STIFF)
        if table.ends == "fixed":
            rest |= shape
        seat = _Seat(
            path=path, name=name, kind="coupling", first=first, second=second.name, turn=0.0, radius=table.radius or 1.0
        )
        middle = (first.station + second.station) / 2
        found.append(replace(_link(seat, "", table, rest, ledger), station=middle + (table.at or 0.0)))
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
