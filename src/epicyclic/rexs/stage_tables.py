"""A planetary stage of a REXS file as a table of a model file: planets, geometry, members, gears, meshes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..errors import ModelError
from .file import HELIX, PLACE, RELIEF_SHAPES, ROW, SHARED, Component, Number, RexsRow, rows_of, shown
from .joint_tables import planet_bearings, support_table
from .members import GearFacts, GearUnit, StageMember, gear_facts, is_lumped, mass_table, normal_module
from .stages import StageParts, Table, Vector, View

_SAME_ANGLE = 0.01  # deg; files state places with 1e-12, angles by hand with a few digits
_SAME_LENGTH = 1e-6  # m
_GEAR = [row for row in rows_of("cylindrical_gear") if row.of and row.key != "teeth"]
_SHARED = [row for row in _GEAR if row.key in SHARED]
_STIFFNESSES = rows_of("cylindrical_stage", "stiffness")
_ADDENDUM = ROW["addendum_coefficient_basic_profile"]
_DEDENDUM = ROW["addendum_coefficient_reference_profile"]
_ROUNDING = ROW["tip_radius_factor"]
_PRESSURE_ANGLE = ROW["normal_pressure_angle"]
_TURNED = "rotating_angle_around_neg_u_axis"


def stage_table(unit: GearUnit, stage: StageParts, origin: Vector | None) -> Table:
    """The table of one stage.

    origin : where station 0 is; None where the file gives no places.

    Raises
    ------
    ModelError : planets on the axis of the stage, gears without teeth or module, a unit that is not known.
    """
    path = f"stages.{stage.name}"
    table: Table = _angles(unit, stage, path)
    distance = _distance(unit, stage, path)
    if distance is not None:
        table["centre_distance"] = distance.text
    table |= _shared(unit, stage, path)
    if stage.twins:
        table |= _herringbone(unit, stage, path)
    if distance is not None:
        pins = distance.si
    else:  # without profile shift
        planet, other = unit.facts[stage.branches[0].gears[0]], unit.facts[next(iter(stage.central.values()))]
        pins = abs(other.reference + (-planet.reference if other.internal else planet.reference)) / 2
    members = {m.name: _member(unit, m, table, pins, origin) for m in unit.members if m.stage == stage}
    _hands(unit, stage, members)
    _shifts(unit, stage, members, distance)
    meshes = {pair: mesh for pair in stage.meshes if (mesh := _mesh(unit, stage, pair))}
    if len(stage.planets) > 1:
        meshes = {pair: meshes.get(pair, {}) for pair in stage.meshes}
    table |= members
    if meshes:
        table["meshes"] = meshes
    return table


def _spokes(unit: GearUnit, stage: StageParts) -> list[Vector] | None:
    """From the axis of the stage to each planet, across the axis; None where a place is missing."""
    middle = unit.view.gear_place(next(iter(stage.central.values())))
    z = unit.axis
    spokes = []
    for branch in stage.branches:
        place = unit.view.gear_place(branch.gears[0], branch.shaft)
        if place is None or middle is None:
            return None
        apart = place - middle
        spokes.append(apart - (apart @ z) * z)
    return spokes


def x_axis_of(unit: GearUnit, stage: StageParts) -> Vector | None:
    """Direction of x, through planet 1; None where the file gives no places."""
    spokes = _spokes(unit, stage)
    if not spokes:
        return None
    radius = np.linalg.norm(spokes[0])
    if not radius > _SAME_LENGTH:
        where = f"component {unit.view.label(stage.branches[0].shaft)}"
        raise ModelError("a planet on the axis of its stage", path=where, allowed="a support_vector off the axis")
    return spokes[0] / radius


def _angles(unit: GearUnit, stage: StageParts, path: str) -> Table:
    """Polar angles of the planets about z from planet 1, in the order of the file: from their places."""
    x = x_axis_of(unit, stage)
    count = len(stage.branches)
    stated = _stated_angles(unit, stage)
    if x is not None:
        y = np.cross(unit.axis, x)
        angles = [_clean(math.degrees(math.atan2(s @ y, s @ x))) for s in _spokes(unit, stage) or []]
        source = "support_vector"
    elif stated is not None:
        angles, source = stated, _TURNED
    else:
        unit.view.assume(stage.id, "support_vector", f"{path}.planets", "no places of the planets: equally spaced")
        return {"planets": count}
    for branch, angle in zip(stage.branches, angles, strict=True):
        unit.view.read(branch.gears[0], source, f"{path}.planet_angles", f"{angle:.9g} deg")
    if x is not None and stated is not None:
        _compare(unit, stage, angles, stated)
    if all(abs(angle - 360 * i / count) < 1e-9 for i, angle in enumerate(angles)):
        return {"planets": count}
    return {"planet_angles": f"[{', '.join(f'{angle:.12g}' for angle in angles)}] deg"}


def _clean(angle: float) -> float:
    """An angle in 0 to 360 deg, without the last digits that a sine of a program leaves."""
    turned = round(angle % 360, 9)
    return 0.0 if turned >= 360 else turned + 0.0


def _stated_angles(unit: GearUnit, stage: StageParts) -> list[float] | None:
    """Angles of the planets about +u from planet 1, by `rotating_angle_around_neg_u_axis` of meshes with a sun."""
    for pair, meshes in stage.meshes.items():
        if pair.startswith("sun") and len(meshes) == len(stage.branches):
            numbers = [unit.view.number(mesh, _TURNED) for mesh in meshes]
            if all(number is not None for number in numbers):
                # about -u: turning by it about +u goes the other way round
                degrees = [-math.degrees(number.si) for number in numbers if number is not None]
                return [_clean(angle - degrees[0]) for angle in degrees]
    return None


def _compare(unit: GearUnit, stage: StageParts, angles: list[float], stated: list[float]) -> None:
    """Tell where places and stated angles differ: the places count."""
    mesh = next(meshes[0] for pair, meshes in stage.meshes.items() if pair.startswith("sun"))
    apart = {
        sense: [(a - sense * b + 180) % 360 - 180 for a, b in zip(angles, stated, strict=True)] for sense in (1, -1)
    }
    same = [sense for sense, differences in apart.items() if all(abs(angle) < _SAME_ANGLE for angle in differences)]
    if 1 in same:
        unit.view.read(mesh, _TURNED, f"stages.{stage.name}.planet_angles", "agrees with the places of the planets")
    else:
        what = "counts the other way round than" if same else "differs from"
        unit.view.assume(mesh, _TURNED, "", f"{what} the places of the planets, which are taken")


def _distance(unit: GearUnit, stage: StageParts, path: str) -> Number | None:
    """Centre distance of all meshes, else the distance of the planets from the axis; None where neither is given."""
    meshes = [mesh for of_pair in stage.meshes.values() for mesh in of_pair]
    numbers = {mesh: unit.view.number(mesh, "center_distance") for mesh in meshes}
    radii = [float(np.linalg.norm(spoke)) for spoke in _spokes(unit, stage) or []]
    given = [(mesh, abs(number)) for mesh, number in numbers.items() if number is not None]
    if given:
        (mesh, first), *others = given
        for other, number in others:
            if abs(number.si - first.si) > _SAME_LENGTH:
                unit.view.lose(other, "center_distance", f"{number.text} differs from {first.text} of component {mesh}")
        if any(abs(radius - first.si) > _SAME_LENGTH for radius in radii):
            unit.view.assume(mesh, "center_distance", "", "differs from the places of the planets: it counts")
        unit.view.read(mesh, "center_distance", f"{path}.centre_distance", first.text)
        return first
    if not radii:
        return None
    number = Number(radii[0], f"{radii[0] * 1e3:.12g} mm")
    unit.view.read(stage.branches[0].gears[0], "support_vector", f"{path}.centre_distance", number.text)
    return number


def _shared(unit: GearUnit, stage: StageParts, path: str) -> Iterator[tuple[str, object]]:
    """What all gears of a stage have in common: module, helix angle, pressure angle, face width."""
    gears = list(stage.gears.values())
    flanks = [flank.id for gear in gears for flank in unit.view.flanks_of(gear)]
    for row, parts, told in (*((row, gears, gears) for row in _SHARED), (_PRESSURE_ANGLE, flanks, gears[:1])):
        entries = {_entry(unit.view, part, row) for part in parts}
        if len(entries) == 1 and (entry := entries.pop()):
            yield row.key, entry
            for gear in told:
                unit.view.read(gear, row.id, f"{path}.{row.key}", entry)
        elif row is _PRESSURE_ANGLE and not entries - {None}:
            unit.view.assume(stage.id, row.id, "", "not given: 20 deg")


def _entry(view: View, part: int, row: RexsRow) -> object:
    """What an attribute of a gear or flank becomes; None where it is not given."""
    return row.entry(normal_module(view, part) if row.key == "module" else view.number(part, row.id))


def _herringbone(unit: GearUnit, stage: StageParts, path: str) -> Table:
    """Keys of a stage of herringbone gears, each two gears of opposite hand in the file."""
    every = [*stage.central.values(), *(gear for branch in stage.branches for gear in branch.gears)]
    if any(gear not in stage.twins for gear in every):
        without = sorted(set(every) - set(stage.twins))
        raise ModelError("a stage with herringbone gears and others", path=f"component {stage.id}", given=without)
    gear = every[0]
    left, right = unit.view.place(gear), unit.view.place(stage.twins[gear])
    table: Table = {"herringbone": True}
    if left is not None and right is not None:
        gap = abs((right - left) @ unit.axis) - unit.facts[gear].width
        if gap > 1e-9:
            table["gap"] = f"{gap * 1e3:.9g} mm"
    unit.view.read(gear, HELIX, f"{path}.herringbone", f"with component {stage.twins[gear]}")
    return table


def _member(unit: GearUnit, member: StageMember, stage_table: Table, pins: float, origin: Vector | None) -> Table:
    """The table of a member."""
    table: Table = {}
    if member.gears:
        table |= gear_table(unit.view, member.gears, member.path, stage_table)
    if member.name not in ("sun", "ring", "planet", "carrier"):
        table["kind"] = member.kind
    if member.name == "planet2":
        table["on"] = "planet"
        if is_lumped(unit, member.parts[0]):
            table |= {"mass": "0 kg", "inertia": "0 kg m^2", "tilt_inertia": "0 kg m^2"}
            reason = "in the mass of their shaft, which stands with the first gear"
            unit.view.assume(member.gears[0], "mass", f"{member.path}.mass", reason)
    else:
        table |= mass_table(unit, member, pins)
    if member.kind != "planet":
        support = support_table(unit, member)
        if support:
            table["support"] = support
    elif member.name == "planet" and (bearing := planet_bearings(unit, member)):
        table["bearing"] = bearing
    if member.centre is not None and origin is not None:
        station = (member.centre - origin) @ unit.axis
        if abs(station) > _SAME_LENGTH:
            table["station"] = f"{station * 1e3:.9g} mm"
    return table


def _hands(unit: GearUnit, stage: StageParts, members: Mapping[str, Table]) -> None:
    """The hand of one gear of each chain in mesh; those of its mates follow, and are told where they do not."""
    for planet in stage.planets:
        chain = {name: stage.gears[name] for name in (*stage.mates(planet), planet)}
        facts = {name: unit.facts[gear] for name, gear in chain.items()}
        # the helix that the planet must have, by each gear that is no ring
        asked = {
            name: f.helix if name == planet else -f.helix for name, f in facts.items() if f.helix and not f.internal
        }
        if not asked:
            continue
        first, counts = next(iter(asked.items()))
        members[first]["hand"] = hand = "right" if facts[first].helix > 0 else "left"
        unit.view.read(chain[first], HELIX, f"stages.{stage.name}.{first}.hand", hand)
        for name, helix in asked.items():
            if helix * counts < 0:
                unit.view.assume(chain[name], HELIX, "", f"its sign does not fit that of {first}, which counts")
        for name, gear in chain.items():
            if facts[name].internal and facts[name].helix * counts < 0:
                reason = f"its sign is that of the other hand: {name} has the hand of its planets"
                unit.view.assume(gear, HELIX, "", reason)


def _shifts(unit: GearUnit, stage: StageParts, members: Mapping[str, Table], distance: Number | None) -> None:
    """Profile shifts that the file does not give: from the centre distance where it says them, else 0."""
    missing = [member for member in stage.gears if "profile_shift" not in members[member]]

    def unshifted(member: str) -> bool:  # a planet where the distance says no more than a sum
        return distance is None or (member in stage.planets and all(mate in missing for mate in stage.mates(member)))

    for member in sorted(missing, key=lambda member: not (member in stage.planets and unshifted(member))):
        name, path = "addendum_modification_coefficient", f"stages.{stage.name}.{member}.profile_shift"
        if unshifted(member):
            members[member]["profile_shift"] = 0.0
            unit.view.assume(stage.gears[member], name, path, "not in the file: 0")
        else:
            unit.view.assume(stage.gears[member], name, "", f"{path} follows from the centre distance")


def _mesh(unit: GearUnit, stage: StageParts, pair: str) -> Table:
    """Keys of a mesh: stiffness and backlash where the file gives them, alike in all branches."""
    table: Table = {}
    first, *others = stage.meshes[pair]
    path, which = f"stages.{stage.name}.meshes.{pair}", "all branches"
    for row in _STIFFNESSES:
        number = _alike(unit.view, first, others, row.id, which)
        if number is None or not number.si > 0:
            continue
        common = unit.view.number(first, "common_face_width")
        widths = [unit.facts[stage.gears[gear]].width for gear in pair.split("-")]
        least = min((width for width in widths if not math.isnan(width)), default=math.nan)
        if common is None or abs(common.si - least) < _SAME_LENGTH:
            stiffness = number.text
        else:
            stiffness = f"{shown(number.si * common.si)} N/m"
        table |= {row.key: stiffness, "direction": "transverse", "variation": "contact-lines"}
        varies = "the file has a mean stiffness: it varies with the length of the contact lines"
        unit.view.assume(first, row.id, f"{path}.variation", varies)
        unit.view.read(first, row.id, f"{path}.{row.key}", stiffness)
        if row.note:
            unit.view.assume(first, row.id, f"{path}.{row.key}", row.note)
        break
    limits = [_alike(unit.view, first, others, f"{end}_normal_backlash", which) for end in ("minimum", "maximum")]
    backlashes = [number.si for number in limits if number is not None]
    if backlashes and min(backlashes) >= 0:
        table["backlash"] = f"{sum(backlashes) / len(backlashes) * 1e3:.9g} mm"
        unit.view.read(first, "normal_backlash", f"{path}.backlash", f"{table['backlash']}, mean of the limits")
    return table


def _alike(view: View, first: int, others: Sequence[int], name: str, which: str) -> Number | None:
    """A number of components alike: that of the first, others told where they differ."""
    number = view.number(first, name)
    for other in others:
        differs = view.number(other, name)
        if (None if differs is None else differs.si) != (None if number is None else number.si):
            view.lose(other, name, f"differs from that of component {first}, which counts for {which}")
    return number


# gears ----------------------------------------------------------------------------------------------------------------

_TOOLS = ("rack_shaped_tool", "cutter_wheel_tool")


def gear_table(view: View, gears: Sequence[int], path: str, stage_table: Table) -> Table:
    """The table of a gear member: the first of its gears (of planets, the one of branch 1), the others being alike.

    What all gears of the stage share (`stage_table`) is left out.
    """
    gear, facts = gears[0], gear_facts(view, gears[0])
    table: Table = {"teeth": facts.teeth}
    view.read(gear, "number_of_teeth", f"{path}.teeth", facts.teeth)
    for row in _GEAR:
        _put(view, gear, row, table, path, stage_table)
    table |= _coefficients(view, gear, path, facts)
    flanks = view.flanks_of(gear)
    for flank in reversed(flanks):  # the left one last: it counts where they differ
        for row in rows_of("cylindrical_gear_flank"):
            entry = _entry(view, flank.id, row)
            if entry is not None and table.get(row.key, entry) != entry:
                view.lose(flanks[-1].id, row.id, "differs from that of the left flank, which counts")
            _put(view, flank.id, row, table, path, stage_table)
    modified = [dict(_flank_table(view, flank, facts, f"{path}.flank")) for flank in flanks]
    if len(modified) == 2 and modified[0] != modified[1]:
        reason = "left and right flank differ: that of the left flank is taken for the loaded one"
        view.assume(flanks[0].id, "flank", f"{path}.flank" if modified[0] else "", reason)
    if modified and modified[0]:
        table["flank"] = modified[0]
    for other in gears[1:]:
        _mark_alike(view, gear, other)
    return table


def _put(view: View, part: int, row: RexsRow, table: Table, path: str, beside: Table | None = None) -> None:
    """Put an attribute into a table, where it is given and not the same as in another."""
    entry = _entry(view, part, row)
    if entry is not None and (beside or {}).get(row.key) != entry:
        table[row.key] = entry
        number = view.number(part, row.id)
        view.read(part, row.id, f"{path}.{row.key}", entry if isinstance(entry, str) or number is None else number.text)


def _mark_alike(view: View, gear: int, other: int) -> None:
    """Note the attributes of a planet gear that are those of the first as read, and what differs as lost."""
    pairs = [(gear, other)]
    pairs += list(zip((f.id for f in view.flanks_of(gear)), (f.id for f in view.flanks_of(other)), strict=False))
    for a, b in pairs:
        for name in list(view.asked.get(a, ())):
            first, second = view.components[a].attributes.get(name), view.value(b, name)
            differs = second is not None and (first is None or first.value != second)
            if differs and name not in PLACE:
                view.lose(b, name, f"differs from that of component {a}, which counts for all planets")


def _coefficients(view: View, gear: int, path: str, facts: GearFacts) -> Table:
    """Addendum of the gear; dedendum and rounding from the tool that cuts it."""
    table: Table = {}
    attributes = view.components[gear].attributes
    if view.number(gear, _ADDENDUM.id) is not None and "tip_diameter" not in attributes:
        _put(view, gear, _ADDENDUM, table, path)
    elif math.isnan(facts.tip):
        view.assume(gear, "tip_diameter", "", "tip diameter not given: addendum 1 module")
    for tool in _tools(view, gear)[:1]:
        if 0.2 < view.si(tool.id, _DEDENDUM.id, math.nan) < 5 and "root_diameter" not in attributes:
            _put(view, tool.id, _DEDENDUM, table, path)
        if tool.type == "rack_shaped_tool" and 0 <= view.si(tool.id, _ROUNDING.id, math.nan) <= 1:
            _put(view, tool.id, _ROUNDING, table, path)
    return table


def _tools(view: View, gear: int) -> list[Component]:
    """Tools of a gear: those it refers to, or that work on its flanks, in their order."""
    flanks = [flank.id for flank in view.flanks_of(gear)]
    steps = view.related.get("manufacturing_step", ())
    working = [view.components[tool] for flank, tool in steps if flank in flanks and tool is not None]
    return [component for component in (*view.referenced(gear), *working) if component.type in _TOOLS]


def _flank_table(view: View, flank: Component, facts: GearFacts, path: str) -> Iterator[tuple[str, object]]:
    """Modifications of one flank."""
    for part in view.referenced(flank.id):
        if part.type in ("tip_relief", "root_relief"):
            relief = _relief(view, part, facts)
            if relief:
                yield part.type, relief
                view.read(part.id, f"{part.type}_depth", f"{path}.{part.type}", relief["amount"])
        elif part.type == "helix_crowning":
            ends = [view.number(part.id, row.id) for row in rows_of("helix_crowning")]
            crownings = [number for number in ends if number is not None]
            if crownings and all(number.si == crownings[0].si for number in crownings) and crownings[0].si >= 0:
                yield "crown", crownings[0].text
                view.read(part.id, "helix_crowning_amount_datum_face", f"{path}.crown", crownings[0].text)
            elif crownings:
                view.lose(part.id, "helix_crowning_amount", "crowning that differs at both ends of the face")


def _relief(view: View, part: Component, facts: GearFacts) -> Table:
    """Tip or root relief: its amount, and its length as a height of the tooth."""
    kind = part.type
    amounts = (view.number(part.id, row.id) for row in rows_of(kind, "amount"))
    amount = next((number for number in amounts if number is not None), None)
    start = view.number(part.id, f"{kind}_datum_diameter")
    if amount is None or start is None or kind != "tip_relief" or math.isnan(facts.tip) or amount.si < 0:
        reason = "without amount, datum diameter or tip diameter its height on the tooth is not known"
        view.lose(part.id, kind, reason if kind == "tip_relief" else "the lowest point of contact is not in the file")
        return {}
    height = abs(facts.tip - abs(start.si)) / 2
    table: Table = {"amount": amount.text, "length": f"{height * 1e3:.9g} mm"}
    shape = view.value(part.id, "shape_of_relief")
    if isinstance(shape, str) and shape in RELIEF_SHAPES:
        table["shape"] = RELIEF_SHAPES[shape]
    elif shape not in (None, False):
        view.lose(part.id, "shape_of_relief", f"{shape}: taken as linear")
    return table
