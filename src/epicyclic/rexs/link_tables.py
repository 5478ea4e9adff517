"""Bearings and couplings of a REXS file as supports, planet bearings and couplings of a model file."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise

from .connections import RIGID, Joint
from .members import GearUnit, StageMember
from .places import along, minus
from .units import Number

__all__ = ["couplings_table", "held_members", "planet_bearings", "support_table"]

Table = dict[str, object]


def held_members(unit: GearUnit) -> list[StageMember]:
    """Central members that do not turn: rigid in the casing, or joined to it by a coupling that holds their turn."""
    found = []
    for member in unit.members:
        if member.kind != "planet" and (unit.held(member) or any(j.holds_turn for j in _to_housing(unit, member))):
            found.append(member)
    return found


def _of(unit: GearUnit, member: StageMember) -> list[Joint]:
    """Joints of a member with anything outside it, the nearest member on a shared shaft taking each."""
    shared = unit.sharing(member)
    found = []
    for joint in unit.joints_at(member.parts):
        inside = [part for part in (joint.inner, joint.outer) if member in unit.at(part)]
        if len(inside) == 1 and _nearest(unit, joint, inside[0], shared) == member:
            found.append(joint)
    return found


def _nearest(unit: GearUnit, joint: Joint, part: int, shared: Sequence[StageMember]) -> StageMember:
    """The member of a shared shaft that is nearest along the axis."""
    if len(shared) == 1:
        return shared[0]
    return min(shared, key=lambda member: abs(_offset(unit, joint, member)))


def _to_housing(unit: GearUnit, member: StageMember) -> list[Joint]:
    """Joints between a member and the casing."""
    return [j for j in _of(unit, member) if any(unit.in_housing(p) for p in (j.inner, j.outer))]


def _offset(unit: GearUnit, joint: Joint, member: StageMember, shaft: int | None = None) -> float:
    """Axial place of a joint from the centre of a member [m]; 0 where the file gives none."""
    place = unit.places.frame(joint.id)
    point = None if place is None else place.place
    if point is None and unit.view.components[joint.inner].type == "shaft":
        point = unit.places.on_shaft(joint.id, joint.inner, "u_coordinate_on_shaft_inner_side")
    if point is None or member.centre is None:
        return 0.0
    return along(minus(point, member.centre), unit.axis)


def support_table(unit: GearUnit, member: StageMember) -> Table | None:
    """Support of a central member; None where nothing is to be said: it is rigid in the casing or on a shared shaft."""
    if unit.held(member):
        return None
    housing = _to_housing(unit, member)
    rest = [joint for joint in _of(unit, member) if joint not in housing]
    carrier = next((m for m in unit.members if (m.stage, m.name) == (member.stage, "carrier")), None)
    inside = [
        j for j in rest if carrier not in (None, member) and any(carrier in unit.at(p) for p in (j.inner, j.outer))
    ]
    planets = {unit.rigid.root(shaft) for m in unit.members if m.kind == "planet" for shaft in m.parts}
    for joint in rest:
        of_planet = {unit.rigid.root(joint.inner), unit.rigid.root(joint.outer)} & planets
        if joint.bearing and joint not in inside and not of_planet:
            unit.view.lose(joint.id, "bearing", f"a bearing of {member.path} in a part that is no member of its stage")
    if not housing and inside:
        return {"to": f"{carrier.stage}.{carrier.name}", **_links(unit, member, inside)} if carrier else None
    for joint in inside if member.name != "carrier" else []:
        unit.view.lose(joint.id, "bearing", f"{member.path} has bearings in the casing too, which count")
    if housing:
        return _links(unit, member, housing)
    return _unsupported(unit, member, rest)


def _unsupported(unit: GearUnit, member: StageMember, rest: Sequence[Joint]) -> Table | None:
    """Support of a member without a bearing: it floats where others of its file have bearings."""
    path = f"{member.path}.support"
    if len(unit.sharing(member)) > 1:
        unit.view.assume(member.parts[0], "bearings", "", f"{path}: on a shaft with another member: held rigidly")
        return None
    if not any(_to_housing(unit, m) for m in unit.members if m.kind != "planet"):
        unit.view.assume(member.parts[0], "bearings", "", f"{path}: no bearing in the file: held rigidly")
        return None
    unit.view.assume(member.parts[0], "bearings", f"{path}.radial", "no bearing in the file: floats radially")
    return {"radial": 0}


def _links(unit: GearUnit, member: StageMember, joints: Sequence[Joint]) -> Table:
    """One joint as a table, several as named tables, each at its place."""
    tables = {_name(joint): _link(unit, joint, member, f"{member.path}.support") for joint in joints}
    if len(tables) == 1:
        return next(iter(tables.values()))
    return dict(tables)


def _name(joint: Joint) -> str:
    return f"{'bearing' if joint.bearing else 'coupling'}{joint.id}"


def _link(unit: GearUnit, joint: Joint, member: StageMember, path: str) -> Table:
    """A joint as the keys of a link."""
    at = _offset(unit, joint, member)
    table: Table = {} if abs(at) < 1e-9 else {"at": f"{at * 1e3:.9g} mm"}
    table["radial"] = _stiff(unit, joint, joint.radial, "radial_stiffness")
    table["z"] = _stiff(unit, joint, joint.axial, "axial_stiffness")
    if joint.tilt is None and joint.bearing:
        unit.view.assume(joint.id, "bending_stiffness", "", "not given: the bearing is free to tilt")
    table["tilt"] = 0 if joint.tilt is None and joint.bearing else _stiff(unit, joint, joint.tilt, "bending_stiffness")
    if not joint.bearing:
        turn = _stiff(unit, joint, joint.turn, "rotational_stiffness")
        if turn != 0:
            table["rz"] = turn
    unit.view.read(joint.id, "stiffness", f"{path}.{_name(joint)}", ", ".join(f"{k} {v}" for k, v in table.items()))
    return table


def _stiff(unit: GearUnit, joint: Joint, number: Number | None, name: str) -> object:
    """A stiffness as a model file writes it: inf where rigid, 0 where it holds nothing."""
    if number is None:
        unit.view.assume(joint.id, name, "", "not given: rigid")
        return math.inf
    if number.si >= RIGID:
        return math.inf
    return number.text if number.si > 0 else 0


def planet_bearings(unit: GearUnit, member: StageMember) -> Table | None:
    """Bearings of a planet on its pin or in the casing; what differs from branch to branch stands as a list.

    None where the file has none: the planet is then rigidly on its pin.
    """
    stage = unit.stage(member)
    rows: list[list[Joint]] = []
    for shaft in member.parts:
        root = unit.rigid.root(shaft)
        found = [
            j
            for j in unit.joints_at([shaft])
            if sum(unit.rigid.root(part) == root for part in (j.inner, j.outer)) == 1 and (j.bearing or not j.rigid)
        ]
        rows.append(sorted(found, key=lambda joint: (round(_offset(unit, joint, member), 9), joint.id)))
    if len({len(row) for row in rows}) > 1:
        given = {branch.shaft: len(row) for branch, row in zip(stage.branches, rows, strict=True)}
        unit.view.assume(
            member.parts[0], "bearings", "", f"planets with different bearings {given}: those of the first"
        )
        rows = [rows[0]] * len(rows)
    if not rows[0]:
        unit.view.assume(member.parts[0], "bearings", "", f"{member.path}: no planet bearing in the file: rigid")
        return None
    tables = {}
    for column in zip(*rows, strict=True):
        links = [_link(unit, joint, member, f"{member.path}.bearing") for joint in column]
        for link in links:
            link.pop("rz", None)
        tables[_name(column[0])] = _merged(unit, column, links)
    return next(iter(tables.values())) if len(tables) == 1 else dict(tables)


def _merged(unit: GearUnit, joints: Sequence[Joint], links: Sequence[Table]) -> Table:
    """One table of the bearings of all branches."""
    merged: Table = {}
    for key in links[0]:
        values = [link.get(key, 0) for link in links]
        if all(value == values[0] for value in values) or key == "at":
            merged[key] = values[0]
        else:
            texts = ["inf" if value == math.inf else str(value) for value in values]
            merged[key] = list(texts)
    return merged


def couplings_table(unit: GearUnit) -> Table:
    """Couplings between members: rigid ones on a shared shaft, elastic ones with their torsional stiffness."""
    table: Table = {}
    done: list[tuple[StageMember, ...]] = []
    for member in unit.members:
        if member.kind == "planet" or unit.held(member):
            continue
        shared = unit.sharing(member)
        if len(shared) > 1 and shared not in done:
            done.append(shared)
            for a, b in pairwise(shared):
                name = f"{a.stage}-{a.name}-{b.stage}-{b.name}"
                table[name] = {"between": [f"{a.stage}.{a.name}", f"{b.stage}.{b.name}"]}
                unit.view.read(a.parts[0], "shaft", f"couplings.{name}", "one shaft")
    for joint in unit.joints:
        if joint.rigid or not joint.holds_turn:
            continue
        ends = [_ends_at(unit, part) for part in (joint.inner, joint.outer)]
        if not ends[0] or not ends[1] or set(ends[0]) & set(ends[1]):
            continue
        name = unit.view.components[joint.id].name
        if not re.fullmatch(r"[a-z][a-z0-9_-]{0,40}", name) or name in table:
            name = f"coupling{joint.id}"
        one: Table = {"between": [ends[0][0], ends[1][0]]}
        turn = _stiff(unit, joint, joint.turn, "rotational_stiffness")
        if turn != math.inf:
            one["rz"] = turn
        table[name] = one
        unit.view.read(joint.id, "rotational_stiffness", f"couplings.{name}.rz", turn)
        if any(number is None or number.si > 0 for number in (joint.radial, joint.axial, joint.tilt)):
            reason = "a coupling of two members joins their turn only"
            unit.view.lose(joint.id, "radial_stiffness, axial_stiffness, bending_stiffness", reason)
    return table


def _ends_at(unit: GearUnit, part: int) -> list[str]:
    """Names of the members and bodies that a part is rigidly joined to; none of what stands in the casing."""
    free = unit.free.get(unit.rigid.root(part))
    members = [f"{m.stage}.{m.name}" for m in unit.at(part) if not unit.held(m)]
    return members if free is None else [free]
