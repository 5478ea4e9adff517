"""Bearings, couplings and operation of a REXS file as tables of a model file.

Bearings and couplings become supports, planet bearings and couplings; speeds and loads the operation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .file import Number, RexsRow
from .members import BODY_NAME, GearUnit, StageMember
from .stages import RIGID, STIFFNESSES, Joint, Parts, Table, Vector, grouped

_FORCES = ("force_", "torque_around_v", "torque_around_w", "torque_around_the")
_BALANCE = 1e-3  # power and torque times speed that differ by more are told


class _Load(NamedTuple):
    """A torque or power of an external load, or the speed of a shaft.

    defines : whether it is marked as the one that counts.  id : of its component.  key : ``torque``, ``power`` or
    ``speed``.  end : name of the member or body that it acts on.
    """

    defines: bool
    id: int
    key: str
    end: str
    number: Number


# supports -------------------------------------------------------------------------------------------------------------


def _outer_joints(unit: GearUnit, member: StageMember) -> Iterator[Joint]:
    """Joints of a member with anything outside it, the nearest member on a shared shaft taking each."""
    shared = unit.sharing(member)
    for joint in unit.joints_at(member.parts):
        inside = [part for part in joint.ends if member in unit.at(part)]
        if len(inside) != 1:
            continue
        offsets = [abs(_offset(unit, joint, other)) for other in shared] if len(shared) > 1 else [0.0]
        if shared[offsets.index(min(offsets))] == member:
            yield joint


def _to_housing(unit: GearUnit, member: StageMember) -> list[Joint]:
    """Joints between a member and the casing."""
    return [joint for joint in _outer_joints(unit, member) if unit.in_housing(joint.ends)]


def _offset(unit: GearUnit, joint: Joint, member: StageMember) -> float:
    """Axial place of a joint from the centre of a member [m]; 0 where the file gives none."""
    point = unit.view.place(joint.id)
    if point is None and unit.view.components[joint.ends[0]].type == "shaft":
        point = unit.view.on_shaft(joint.id, joint.ends[0], "u_coordinate_on_shaft_inner_side")
    if point is None or member.centre is None:
        return 0.0
    return float((point - member.centre) @ unit.axis)


def support_table(unit: GearUnit, member: StageMember) -> Table | None:
    """Support of a central member; None where nothing is to be said: it is rigid in the casing or on a shared shaft."""
    if unit.held(member):
        return None
    housing = _to_housing(unit, member)
    rest = [joint for joint in _outer_joints(unit, member) if joint not in housing]
    carrier = next((m for m in unit.central if m.path == f"stages.{member.stage.name}.carrier" and m != member), None)
    inside = [joint for joint in rest if any(carrier in unit.at(part) for part in joint.ends)]
    planets = {unit.rigid.root(shaft) for m in unit.members if m.kind == "planet" for shaft in m.parts}
    for joint in rest:
        of_planet = {unit.rigid.root(part) for part in joint.ends} & planets
        if joint.bearing and joint not in inside and not of_planet:
            unit.view.lose(joint.id, "bearing", f"a bearing of {member.path} in a part that is no member of its stage")
    if housing:
        for joint in inside:
            unit.view.lose(joint.id, "bearing", f"{member.path} has bearings in the casing too, which count")
    path = f"{member.path}.support"
    links = _one_or_all({_name(joint): _link(unit, joint, member, path) for joint in housing or inside})
    if housing or (inside and carrier is not None):
        return links if housing or carrier is None else {"to": carrier.full_name, **links}
    # without a bearing it floats where others of its file have bearings
    if len(unit.sharing(member)) > 1:
        unit.view.assume(member.parts[0], "bearings", "", f"{path}: on a shaft with another member: held rigidly")
        return None
    if not any(_to_housing(unit, m) for m in unit.central):
        unit.view.assume(member.parts[0], "bearings", "", f"{path}: no bearing in the file: held rigidly")
        return None
    unit.view.assume(member.parts[0], "bearings", f"{path}.radial", "no bearing in the file: floats radially")
    return {"radial": 0}


def _one_or_all(tables: Mapping[str, Table]) -> Table:
    """The table of a single joint, else the tables of all by name."""
    return next(iter(tables.values())) if len(tables) == 1 else dict(tables)


def _name(joint: Joint) -> str:
    return f"{'bearing' if joint.bearing else 'coupling'}{joint.id}"


def _link(unit: GearUnit, joint: Joint, member: StageMember, path: str) -> Table:
    """A joint as the keys of a link."""
    at = _offset(unit, joint, member)
    table: Table = {} if abs(at) < 1e-9 else {"at": f"{at * 1e3:.9g} mm"}
    for row in STIFFNESSES:
        if row.key == "tilt" and joint.bearing and joint.stiffness[row.key] is None:
            unit.view.assume(joint.id, row.id, "", "not given: the bearing is free to tilt")
            table[row.key] = 0
        elif row.key != "rz":
            table[row.key] = _stiff(unit, joint, row)
        elif not joint.bearing and (turn := _stiff(unit, joint, row)) != 0:
            table[row.key] = turn
    unit.view.read(joint.id, "stiffness", f"{path}.{_name(joint)}", ", ".join(f"{k} {v}" for k, v in table.items()))
    return table


def _stiff(unit: GearUnit, joint: Joint, row: RexsRow) -> object:
    """A stiffness as a model file writes it: inf where rigid, 0 where it holds nothing."""
    number = joint.stiffness[row.key]
    if number is None:
        unit.view.assume(joint.id, row.id, "", "not given: rigid")
    if number is None or number.si >= RIGID:
        return math.inf
    return number.text if number.si > 0 else 0


def planet_bearings(unit: GearUnit, member: StageMember) -> Table | None:
    """Bearings of a planet on its pin or in the casing; what differs from branch to branch stands as a list.

    None where the file has none: the planet is then rigidly on its pin.
    """
    rows: list[list[Joint]] = []
    for shaft in member.parts:
        # a joint of the shaft to itself holds nothing
        ends = ((j, {unit.rigid.root(part) for part in j.ends}) for j in unit.joints_at([shaft]))
        joints = [joint for joint, roots in ends if len(roots) == 2 and (joint.bearing or not joint.rigid)]
        rows.append(sorted(joints, key=lambda joint: (round(_offset(unit, joint, member), 9), joint.id)))
    if len({len(row) for row in rows}) > 1:
        counts = {shaft: len(row) for shaft, row in zip(member.parts, rows, strict=True)}
        reason = f"planets with different bearings {counts}: those of the first"
        unit.view.assume(member.parts[0], "bearings", "", reason)
        rows = [rows[0]] * len(rows)
    if not rows[0]:
        unit.view.assume(member.parts[0], "bearings", "", f"{member.path}: no planet bearing in the file: rigid")
        return None
    tables = {}
    for column in zip(*rows, strict=True):
        links = [_link(unit, joint, member, f"{member.path}.bearing") for joint in column]
        merged: Table = {}
        for key in links[0]:
            values = [link.get(key, 0) for link in links]
            if all(value == values[0] for value in values) or key == "at":
                merged[key] = values[0]
            else:
                merged[key] = ["inf" if value == math.inf else str(value) for value in values]
        merged.pop("rz", None)
        tables[_name(column[0])] = merged
    return _one_or_all(tables)


def couplings_table(unit: GearUnit) -> Table:
    """Couplings between members: rigid ones on a shared shaft, elastic ones with their torsional stiffness."""
    table: Table = {}
    done: list[tuple[StageMember, ...]] = []
    for member in unit.central:
        shared = unit.sharing(member)
        if not unit.held(member) and len(shared) > 1 and shared not in done:
            done.append(shared)
            for a, b in pairwise(shared):
                name = f"{a.stage.name}-{a.name}-{b.stage.name}-{b.name}"
                table[name] = {"between": [a.full_name, b.full_name]}
                unit.view.read(a.parts[0], "shaft", f"couplings.{name}", "one shaft")
    for joint in unit.joints:
        if joint.rigid or not joint.holds_turn:
            continue
        inner, outer = (_ends_at(unit, part) for part in joint.ends)
        if not inner or not outer or set(inner) & set(outer):
            continue
        name = unit.view.components[joint.id].name
        if not BODY_NAME.fullmatch(name) or name in table:
            name = f"coupling{joint.id}"
        coupling: Table = {"between": [inner[0], outer[0]]}
        *others, row = STIFFNESSES
        turn = _stiff(unit, joint, row)
        if turn != math.inf:
            coupling[row.key] = turn
        table[name] = coupling
        unit.view.read(joint.id, row.id, f"couplings.{name}.{row.key}", turn)
        if any((number := joint.stiffness[other.key]) is None or number.si > 0 for other in others):
            reason = "a coupling of two members joins their turn only"
            unit.view.lose(joint.id, ", ".join(other.id for other in others), reason)
    return table


def _ends_at(unit: GearUnit, part: int) -> list[str]:
    """Names of the members and bodies that a part is rigidly joined to; none of what stands in the casing."""
    free = unit.free.get(unit.rigid.root(part))
    return [m.full_name for m in unit.at(part) if not unit.held(m)] if free is None else [free]


# operation ------------------------------------------------------------------------------------------------------------


def operation_table(unit: GearUnit) -> Table:
    """What is held, speeds, torques and powers by member.

    Held are members rigid in the casing, or joined to it by a coupling that holds their turn.
    """
    table: Table = {}
    held = [m for m in unit.central if unit.held(m) or any(joint.holds_turn for joint in _to_housing(unit, m))]
    if held:
        table["held"] = [_short(unit, member) for member in held]
        for member in held:
            unit.view.read(member.parts[0], "held", "operation.held", "joined to the casing so that it does not turn")
    ends = dict(_ends(unit, held))
    speeds = _speeds(unit, ends)
    if speeds:
        table["speed"] = {name: number.text for name, number in speeds.items()}
    return table | _loads(unit, held, ends, speeds)


def _short(unit: GearUnit, member: StageMember) -> str:
    return member.name if len(unit.stages) == 1 else member.full_name


def _ends(unit: GearUnit, held: list[StageMember]) -> Iterator[tuple[int, str]]:
    """Part, and name of the body or member that turns with it, of those that turn and are in a planetary stage.

    The member that a part is rigidly joined to comes before others.
    """
    turning = Parts[int]()  # at one speed: rigidly joined, or by a coupling of any stiffness
    for number in unit.view.components:
        turning.join([number, unit.rigid.root(number)])
    for joint in unit.joints:
        if joint.holds_turn:
            turning.join(joint.ends)
    turned = grouped((turning.root(part), member) for member in unit.central for part in member.parts)
    for part in unit.view.components:
        members = unit.at(part) or turned.get(turning.root(part), ())
        if (free := unit.free.get(unit.rigid.root(part))) is not None:
            yield part, free
        elif members and members[0] not in held:
            yield part, _short(unit, members[0])


def _signed(unit: GearUnit, number: Number, part: int) -> Number:
    """A number about the u axis of a part as one about z."""
    frame = unit.view.frame(part)
    return number if frame is None or frame.u @ unit.axis >= 0 else -number


def _speeds(unit: GearUnit, ends: Mapping[int, str]) -> dict[str, Number]:
    """Speeds of members: those of shafts that define a speed, else the first given."""
    stated: list[_Load] = []
    for shaft in unit.view.of_type("shaft"):
        number = unit.view.number(shaft.id, "rotational_speed")
        defines = unit.view.value(shaft.id, "defines_speed") is True
        end = ends.get(shaft.id)
        if number is not None and end is not None:
            stated.append(_Load(defines, shaft.id, "speed", end, _signed(unit, number, shaft.id)))
    flagged = [speed for speed in stated if speed.defines]
    speeds: dict[str, Number] = {}
    for speed in stated:
        if speed not in (flagged or stated[:1]):
            reason = f"{speed.number.text}: follows from the speeds that are defined"
            unit.view.lose(speed.id, "rotational_speed", reason)
        elif speed.end not in speeds:
            speeds[speed.end] = speed.number
            unit.view.read(speed.id, "rotational_speed", f"operation.speed.{speed.end}", speed.number.text)
    if stated and not flagged:
        path = f"operation.speed.{stated[0].end}"
        unit.view.assume(stated[0].id, "defines_speed", path, "no shaft defines the speed: the first one")
    return speeds


def _loads(unit: GearUnit, held: list[StageMember], ends: Mapping[int, str], speeds: dict[str, Number]) -> Table:
    """Torques, or powers where the file gives no torque, of the external loads."""
    loads: list[_Load] = []
    ports: set[str] = set()
    for shaft, load in unit.view.related.get("assembly", ()):
        if shaft is None or load is None or unit.view.components[load].type != "external_load":
            continue
        torque = unit.view.number(load, "torque_around_u_axis")
        power = unit.view.number(load, "power")
        end = ends.get(shaft)
        for name, attribute in unit.view.components[load].attributes.items():
            if name.startswith(_FORCES) and attribute.value not in (0, None):
                unit.view.lose(load, name, "forces and bending moments on shafts are not carried")
        if end is None:
            if torque is not None or power is not None:
                unit.view.lose(load, "torque_around_u_axis", "a load on a part that is held, or in no planetary stage")
                # what gears of no planetary stage take passes through the bodies that carry them
                ports.update(unit.free.values())
            continue
        ports.add(end)
        defines = unit.view.value(load, "defines_torque") is True
        if torque is not None:
            signed = _signed(unit, torque, shaft)
            if power is not None and end in speeds:
                turned = signed.si * speeds[end].si
                if abs(power.si - turned) > _BALANCE * max(abs(power.si), abs(turned)):
                    unit.view.assume(load, "power", "", f"{power.text} is not torque times speed: the torque counts")
                else:
                    unit.view.read(load, "power", "", f"{power.text}, torque times speed")
            loads.append(_Load(defines, load, "torque", end, signed))
        elif power is not None:
            loads.append(_Load(defines, load, "power", end, power))
    return _balanced(unit, held, loads, ports)


def _balanced(unit: GearUnit, held: list[StageMember], loads: list[_Load], ports: set[str]) -> Table:
    """Loads without the one that balances them: of a train with n free ends at most n - 1 are stated."""
    flagged = [load for load in loads if load.defines]
    kept = flagged or loads
    # members through which power may enter or leave: neither held nor joined to another one
    free = [member for member in unit.central if member not in held and len(unit.sharing(member)) == 1]
    most = max(len(free or ports), 2) - 1
    if len({load.end for load in kept}) > most:
        for load in kept[most:]:
            unit.view.assume(load.id, load.key, "", f"{load.number.text} of {load.end}: left out, it takes the balance")
        kept = kept[:most]
    elif not flagged and loads:
        first = loads[0]
        path = f"operation.{first.key}.{first.end}"
        unit.view.assume(first.id, "defines_torque", path, "no load defines the torque: those given")
    for load in loads:
        if load not in kept and not load.defines and flagged:
            reason = f"{load.number.text} of {load.end}: follows from the loads that are defined"
            unit.view.lose(load.id, load.key, reason)
    quantities: dict[str, dict[str, str]] = {}
    for load in kept:
        quantities.setdefault(load.key, {})[load.end] = load.number.text
        attribute = "torque_around_u_axis" if load.key == "torque" else "power"
        unit.view.read(load.id, attribute, f"operation.{load.key}.{load.end}", load.number.text)
    stated = {load.end for load in kept}
    left_out = {load.end for load in loads} - stated  # its value is told above: it is the balance before a silent end
    silent = sorted(left_out or ports - stated)
    if len(silent) == 1 and kept and (unit.free or len(unit.stages) > 1):  # of one stage alone the other end is clear
        quantities.setdefault("torque", {})[silent[0]] = "balance"
    return dict(quantities)


def tell_gravity(unit: GearUnit, x_axis: Vector | None) -> None:
    """Tell gravity that the gear unit accounts for, in the axes of the model: it is left out.

    It loads the meshes round by round, which most files switch on and few gear units are rated by; with it the mean
    load sharing of floating members is not defined.
    """
    units = unit.view.of_type("gear_unit")
    if not units or unit.view.value(units[0].id, "account_for_gravity") is not True:
        return
    parts = [unit.view.number(units[0].id, f"direction_vector_gravity_{axis}") for axis in "uvw"]
    strength = unit.view.si(units[0].id, "gravitational_acceleration", 9.81)
    frame = unit.view.frame(units[0].id)
    if any(part is None for part in parts) or frame is None or x_axis is None:
        return
    u, v, w = (part.si for part in parts if part is not None)
    down = frame.turned(np.array([u, v, w]))
    if not (length := np.linalg.norm(down)) > 1e-30:
        return
    axes = np.array([x_axis, np.cross(unit.axis, x_axis), unit.axis])
    vector = np.round(strength / length * (axes @ down), 9) + 0.0
    line = f'operation.gravity = "[{", ".join(f"{c:.9g}" for c in vector)}] m/s^2"'
    unit.view.lose(units[0].id, "account_for_gravity", f"gravity is left out; {line} adds it")
