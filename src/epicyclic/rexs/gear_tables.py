"""Gears of a REXS file as tables of a model file: teeth, geometry, flanks, material."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ModelError
from .file import Component
from .view import Number, View

Table = dict[str, object]
_TOOLS = ("rack_shaped_tool", "cutter_wheel_tool")
_SHAPES = {"linear": "linear", "parabolic": "parabolic", "quadratic": "parabolic"}


@dataclass(frozen=True, slots=True)
class GearFacts:
    """What other parts need to know of a gear.

    id : of the component.  teeth : positive.  module : normal [m].  helix : signed, right positive [rad].
    width : face width [m], nan where not given.  tip : tip diameter [m], nan where not given.  internal : a ring.
    """

    id: int
    teeth: int
    module: float
    helix: float
    width: float
    tip: float
    internal: bool

    @property
    def reference(self) -> float:
        """Reference diameter [m]."""
        return self.module * self.teeth / math.cos(self.helix)


def gear_facts(view: View, gear: int) -> GearFacts:
    """What a gear is. Raises ModelError where teeth or module are missing or none that a gear has."""
    component = view.components[gear]
    where = f"component {view.label(gear)}"
    teeth = view.value(gear, "number_of_teeth")
    if isinstance(teeth, bool) or not isinstance(teeth, (int, float)) or not 3 <= abs(teeth) <= 5000 or teeth % 1:
        problem = "missing" if teeth is None else "not a number of teeth"
        raise ModelError(problem, path=f"{where}, number_of_teeth", given=teeth, allowed="a whole number, 3 to 5000")
    if teeth < 0 and component.type != "ring_gear":  # a sign that some programs give internal teeth, and no others
        allowed = "a positive number, or a component of type ring_gear"
        raise ModelError("negative, of external teeth", path=f"{where}, number_of_teeth", given=teeth, allowed=allowed)
    module = _module(view, gear)
    helix = view.number(gear, "helix_angle_reference_diameter", "angle")
    width = view.number(gear, "face_width", "length")
    tip = view.number(gear, "tip_diameter", "length")
    if helix is not None and not abs(helix.si) < math.pi / 3:
        path = f"{where}, helix_angle_reference_diameter"
        raise ModelError("out of range", path=path, given=helix.text, allowed="-60 deg to 60 deg")
    return GearFacts(
        gear,
        abs(int(teeth)),
        module.si,
        helix.si if helix is not None else 0.0,
        width.si if width is not None else math.nan,
        abs(tip.si) if tip is not None else math.nan,
        component.type == "ring_gear",
    )


def _module(view: View, gear: int) -> Number:
    """Normal module of a gear, from the transverse one where only that is given."""
    normal = view.number(gear, "normal_module", "length")
    path = f"component {view.label(gear)}, normal_module"
    if normal is None:
        transverse = view.number(gear, "transverse_module", "length")
        helix = view.number(gear, "helix_angle_reference_diameter", "angle")
        if transverse is None:
            raise ModelError("missing", path=path, allowed="a module in mm")
        value = transverse.si * math.cos(helix.si if helix is not None else 0.0)
        normal = Number(value, f"{value!r} m")
    if not 1e-5 <= normal.si <= 10:
        raise ModelError("out of range", path=path, given=normal.text, allowed="0.01 mm to 10 m")
    return normal


def gear_table(view: View, gears: Sequence[int], path: str, stage_table: Table) -> Table:
    """The table of a gear member: the first of its gears (of planets, the one of branch 1), the others being alike.

    What all gears of the stage share (`stage_table`) is left out.
    """
    gear, facts = gears[0], gear_facts(view, gears[0])
    table: Table = {"teeth": facts.teeth}
    view.read(gear, "number_of_teeth", f"{path}.teeth", facts.teeth)
    module = _module(view, gear)
    if stage_table.get("module") != module.text:
        table["module"] = module.text
        view.read(gear, "normal_module", f"{path}.module", module.text)
    helix = view.number(gear, "helix_angle_reference_diameter", "angle")
    slant = abs(helix).text if helix is not None and helix.si else None
    if slant is not None and stage_table.get("helix_angle") != slant:
        table["helix_angle"] = slant
        view.read(gear, "helix_angle_reference_diameter", f"{path}.helix_angle", slant)
    width = view.number(gear, "face_width", "length")
    if width is not None and stage_table.get("face_width") != width.text:
        table["face_width"] = width.text
        view.read(gear, "face_width", f"{path}.face_width", width.text)
    for name, key in (("tip_diameter", "tip_diameter"), ("root_diameter", "root_diameter")):
        number = view.number(gear, name, "length")
        if number is not None:
            table[key] = abs(number).text
            view.read(gear, name, f"{path}.{key}", abs(number).text)
    table |= _coefficients(view, gear, path, facts)
    flanks = view.flanks_of(gear)
    table |= _profile(view, flanks, path, stage_table)
    modified = _modifications(view, flanks, facts, path)
    if modified:
        table["flank"] = modified
    for other in gears[1:]:
        _mark_alike(view, gear, other)
    return table


def _mark_alike(view: View, gear: int, other: int) -> None:
    """Note the attributes of a planet gear that are those of the first as read, and what differs as lost."""
    pairs = [(gear, other)]
    pairs += list(zip((f.id for f in view.flanks_of(gear)), (f.id for f in view.flanks_of(other)), strict=False))
    for a, b in pairs:
        for name in list(view.asked.get(a, ())):
            mine, theirs = view.components[a].attributes.get(name), view.value(b, name)
            if name in ("support_vector", "u_axis_vector", "w_axis_vector", "reference_component_for_position"):
                continue
            if theirs is not None and (mine is None or mine.value != theirs):
                view.lose(b, name, f"differs from that of component {a}, which counts for all planets")


def _coefficients(view: View, gear: int, path: str, facts: GearFacts) -> Table:
    """Addendum of the gear; dedendum and rounding from the tool that cuts it."""
    table: Table = {}
    addendum = view.number(gear, "addendum_coefficient_basic_profile", "ratio")
    if addendum is not None and "tip_diameter" not in view.components[gear].attributes:
        table["addendum"] = addendum.si
        view.read(gear, "addendum_coefficient_basic_profile", f"{path}.addendum", addendum.text)
    elif math.isnan(facts.tip):
        view.assume(gear, "tip_diameter", "", "tip diameter not given: addendum 1 module")
    for tool in _tools(view, gear):
        root = view.number(tool.id, "addendum_coefficient_reference_profile", "ratio")
        if root is not None and "root_diameter" not in view.components[gear].attributes and 0.2 < root.si < 5:
            table["dedendum"] = root.si
            view.read(tool.id, "addendum_coefficient_reference_profile", f"{path}.dedendum", root.text)
        if tool.type == "rack_shaped_tool":
            rounding = view.number(tool.id, "tip_radius_factor", "ratio")
            if rounding is not None and 0 <= rounding.si <= 1:
                table["tip_rounding"] = rounding.si
                view.read(tool.id, "tip_radius_factor", f"{path}.tip_rounding", rounding.text)
        break
    return table


def _tools(view: View, gear: int) -> list[Component]:
    """Tools of a gear: those it refers to, or that work on its flanks, in their order."""
    found = [component for component in view.referenced(gear) if component.type in _TOOLS]
    flanks = {flank.id for flank in view.flanks_of(gear)}
    for relation in view.relations("manufacturing_step"):
        tool = relation.part("tool")
        if relation.part("workpiece") in flanks and tool is not None and view.components[tool].type in _TOOLS:
            found.append(view.components[tool])
    return found


def _profile(view: View, flanks: Sequence[Component], path: str, stage_table: Table) -> Table:
    """Pressure angle and profile shift, from the flanks."""
    table: Table = {}
    for flank in reversed(flanks):  # the left one last: it counts where they differ
        angle = view.number(flank.id, "normal_pressure_angle", "angle")
        if angle is not None and stage_table.get("pressure_angle") != angle.text:
            table["pressure_angle"] = angle.text
            view.read(flank.id, "normal_pressure_angle", f"{path}.pressure_angle", angle.text)
        for name in ("addendum_modification_coefficient", "profile_shift_coefficient"):
            shift = view.number(flank.id, name, "ratio")
            if shift is not None:
                if table.get("profile_shift", shift.si) != shift.si:
                    view.lose(flank.id, name, "differs from that of the left flank, which counts")
                table["profile_shift"] = shift.si
                view.read(flank.id, name, f"{path}.profile_shift", shift.text)
    return table


def _modifications(view: View, flanks: Sequence[Component], facts: GearFacts, path: str) -> Table:
    """Flank modifications that a model file has: reliefs and crowning, of both flanks or those of the left one."""
    tables = [_flank_table(view, flank, facts, f"{path}.flank") for flank in flanks]
    if len(tables) == 2 and tables[0] != tables[1]:
        reason = "left and right flank differ: that of the left flank is taken for the loaded one"
        view.assume(flanks[0].id, "flank", f"{path}.flank" if tables[0] else "", reason)
    return tables[0] if tables else {}


def _flank_table(view: View, flank: Component, facts: GearFacts, path: str) -> Table:
    """Modifications of one flank."""
    table: Table = {}
    for part in view.referenced(flank.id):
        if part.type in ("tip_relief", "root_relief"):
            relief = _relief(view, part, facts)
            if relief:
                table[part.type] = relief
                view.read(part.id, f"{part.type}_depth", f"{path}.{part.type}", relief["amount"])
        elif part.type == "helix_crowning":
            ends = [view.number(part.id, f"helix_crowning_amount_{e}_face", "length") for e in ("datum", "non_datum")]
            given = [number for number in ends if number is not None]
            if given and all(number.si == given[0].si for number in given) and given[0].si >= 0:
                table["crown"] = given[0].text
                view.read(part.id, "helix_crowning_amount_datum_face", f"{path}.crown", given[0].text)
            elif given:
                view.lose(part.id, "helix_crowning_amount", "crowning that differs at both ends of the face")
    return table


def _relief(view: View, part: Component, facts: GearFacts) -> Table:
    """Tip or root relief: its amount, and its length as a height of the tooth."""
    kind = part.type
    amount = view.number(part.id, f"{kind}_depth", "length") or view.number(part.id, f"{kind}_amount", "length")
    start = view.number(part.id, f"{kind}_datum_diameter", "length")
    if amount is None or start is None or kind != "tip_relief" or math.isnan(facts.tip) or amount.si < 0:
        reason = "without amount, datum diameter or tip diameter its height on the tooth is not known"
        view.lose(part.id, kind, reason if kind == "tip_relief" else "the lowest point of contact is not in the file")
        return {}
    height = abs(facts.tip - abs(start.si)) / 2
    table: Table = {"amount": amount.text, "length": f"{height * 1e3:.9g} mm"}
    shape = view.value(part.id, "shape_of_relief")
    if isinstance(shape, str) and shape in _SHAPES:
        table["shape"] = _SHAPES[shape]
    elif shape not in (None, False):
        view.lose(part.id, "shape_of_relief", f"{shape}: taken as linear")
    return table


def material_of(view: View, component: int) -> Component | None:
    """Material of a component, None where it refers to none."""
    return next((one for one in view.referenced(component) if one.type == "material"), None)
