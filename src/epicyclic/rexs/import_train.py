"""A REXS file as a document of the model file, with what was read, assumed and dropped.

Values that a writer has lost are found: arrays and texts that stand as `false`, as some programs have written them in
JSON.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import ModelError
from ..options import ALL_CASES
from ..user_input import checked
from ..warning_codes import CodedText, coded
from .encodings import read_rexs_file
from .file import ARRAYS, CASE_NAME, QUANTITIES, LoadCase, RexsFile, number_of, reason_dropped, rows_of
from .joint_tables import couplings_table, operation_table, tell_gravity
from .members import GearUnit, body_tables, material_of, unit_of
from .stage_tables import stage_table, x_axis_of
from .stages import Branch, Entry, StageParts, Table, View, laid_over, view_of

_MATERIAL = rows_of("material")
# attributes whose value is a text by the standard
_TEXTS = re.compile(
    r"^(?:name|kind|.*_designation|.*_name|determination_of_.*|type_of_.*|shape_of_.*|flag_designation_.*"
    r"|axial_force_absorption|datum_face_orientation|helix_evaluation_reference|.*tolerance_series.*"
    r"|.*_type_.*|.*_category_.*|.*_method_.*|lubrication_type.*|loaded_tooth_flank|manufacturer)$"
)


def _check_damage(file: RexsFile) -> None:
    """Refuse a file in which places or the state of couplings stand as false.

    Raises
    ------
    ModelError : names the attributes that are lost, and how often.
    """
    lost: dict[str, list[int]] = {}
    for component in file.components:
        for name in ARRAYS:
            attribute = component.attributes.get(name)
            single = attribute is not None and isinstance(attribute.value, bool)
            # a single truth value of a coupling is clear in XML, which has no types; in JSON the array is lost
            if single and (name != "is_engaged" or file.encoding == "json"):
                lost.setdefault(name, []).append(component.id)
    if lost:
        parts = ", ".join(f"{name} ({len(ids)} times, first in component {ids[0]})" for name, ids in lost.items())
        texts = dict.fromkeys(name for _, name in _false_texts(file))
        also = f"; texts lost too: {', '.join(texts)}" if texts else ""
        problem = f"damaged: true or false stands where arrays belong, they are missing: {parts}{also}"
        raise ModelError(problem, path="components", allowed="the file written again, in XML or by a newer program")


def _false_texts(file: RexsFile) -> list[tuple[int, str]]:
    """Attributes (component, name) that stand as false where a text belongs."""
    return [
        (component.id, attribute.id)
        for component in file.components
        for attribute in component.attributes.values()
        if attribute.value is False and _TEXTS.fullmatch(attribute.id)
    ]


_LABEL = re.compile(r"[A-Za-z0-9_-]{1,60}")  # name of a load case in a model file
_STATED = (("speed",), ("torque", "power"))
# The format has no damping, and a response needs some: the ratio that the ready drives assume too.
_DAMPING = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class RexsImport:
    """What a REXS file became.

    document : nested tables of a model file, units in the texts; its table `assumed` has the reasons by path.
    comments : by path, from which component a value is.
    read, assumed, dropped : entries with the id of their component; together they have every attribute of the file.
    file : the REXS file.  warnings : of stages that are not read.
    """

    document: Mapping[str, object]
    comments: Mapping[str, str]
    read: tuple[Entry, ...]
    assumed: tuple[Entry, ...]
    dropped: tuple[Entry, ...]
    file: RexsFile
    warnings: tuple[CodedText, ...] = ()


@checked
def read_rexs(source: str | Path | bytes, *, load_case: int | None = None) -> RexsImport:
    """Read a REXS file as a model document.

    Parameters
    ----------
    source : path of a REXS file in XML, JSON or a zip of one, or its bytes.
    load_case : id of the load case whose speeds and loads count; the first one where the components have none.

    Raises
    ------
    ModelError : as of `read_rexs_file`; arrays that a writer has lost, named; no planetary stage; a gear without teeth
        or module; a unit that is not known; axes that are not parallel. Names the component and the attribute.
    """
    name = "REXS file" if isinstance(source, bytes) else str(source)
    file = read_rexs_file(source)
    try:
        return import_file(file, load_case=load_case)
    except ModelError as error:
        raise error.at(f"{name}, {error.path}" if error.path else name) from None


def import_file(file: RexsFile, *, load_case: int | None = None) -> RexsImport:
    """The same of a file that is read already. Raises ModelError as of `read_rexs`."""
    _check_damage(file)
    case = load_case
    if case is None and file.load_cases:  # the first one, where the components themselves have neither speed nor load
        stated = {name for component in file.components for name in component.attributes}
        case = None if stated & {"rotational_speed", "torque_around_u_axis", "power"} else file.load_cases[0].id
    view = view_of(file, case)
    unit = unit_of(view)
    name = next((c.name for c in file.components if c.type == "gear_unit" and c.name), "Gear unit")
    writer = f", {file.application} {file.application_version}".rstrip() if file.application else ""
    document: Table = {"format": 2, "title": f"{name} (REXS {file.version}{writer})"}
    materials = {m: _material(unit, m.gears[0]) for m in unit.members if m.gears}
    common = _common_material(unit, list(materials.values()))
    if common:
        document["material"] = common
    document["damping"] = {"modal": _DAMPING}
    reason = "the format has no damping: a usual value, for modes and response only"
    view.assume(None, "damping", "damping.modal", reason)
    stages = {stage.name: stage_table(unit, stage, unit.members[0].centre) for stage in unit.stages}
    document["stages"] = stages
    for member, (number, material) in materials.items() if not common else ():
        if material:
            table = stages[member.stage.name][member.name]
            assert isinstance(table, dict)
            table["material"] = material
            _read_material(unit, number, material, f"{member.path}.material")
    for key, tables in (("bodies", body_tables(unit)), ("couplings", couplings_table(unit))):
        if tables:
            document[key] = tables
    operation = operation_table(unit)
    tell_gravity(unit, x_axis_of(unit, unit.stages[0]))
    if operation:
        document["operation"] = operation
    if cases := _cases_table(unit, operation):
        document["cases"] = cases
    _tell_cases(view, case, chosen=load_case is not None)
    for component, name in _false_texts(file):
        if name in view.asked.get(component, ()):
            view.assume(component, name, "", "stands as false where a text belongs: taken as missing")
    there = set(_paths(document))
    reasons = {
        entry.path: entry.text if entry.component is None else f"{entry.text} (component {entry.component})"
        for entry in view.assumptions
        if entry.path in there
    }
    if reasons:
        document["assumed"] = reasons
    return RexsImport(
        document=document,
        comments=_comments(unit, there),
        read=tuple(view.entries),
        assumed=tuple(view.assumptions),
        dropped=(*view.losses, *_dropped(unit)),
        file=file,
        warnings=_warnings(unit),
    )


def traced(error: ModelError, imported: RexsImport) -> ModelError:
    """An error of the model document, with the component of the REXS file its value is from."""
    # the checks name members by their full path, also where the document, of a single stage, does not
    short = re.sub(r"^(operation\.\w+)\.main\.", r"\1.", error.path)
    entry = next((e for e in imported.read if e.path and f"{short}.".startswith(f"{e.path}.")), None)
    if entry is None or entry.component is None:
        return error
    return error.at(f"{error.path} (component {entry.component}, {entry.attribute})")


def _cases_table(unit: GearUnit, operation: Table) -> Table:
    """Load cases by name: time or share of each, and what of its speeds and loads differs from the operation.

    One without a time that is the operation is no case of its own.  Durations count where some are given, else shares.
    """
    file, table = unit.view.file, dict[str, Table]()
    bare = {component.id: component for component in file.components}
    weighed = next((key for key in ("duration", "share") if any(_time(case, key) for case in file.load_cases)), "")
    for case in file.load_cases:
        view = replace(unit.view, components=laid_over(bare, case), entries={}, assumptions={}, losses={}, asked={})
        stated = operation_table(replace(unit, view=view))
        # a torque or a power stands in place of both
        parts = [{key: one[key] for key in keys if key in one} for keys in _STATED for one in (stated, operation)]
        own = {**(parts[0] if parts[0] != parts[1] else {}), **(parts[2] if parts[2] != parts[3] else {})}
        if (time := _time(case, weighed)) is not None:
            own[weighed] = time
        if own:
            name = _case_name(case, table)
            table[name] = own
            unit.view.read(None, f"load_case {case.id}", f"cases.{name}", ", ".join(own))
    shares = sum(share for own in table.values() if isinstance(share := own.get("share"), float))
    if shares > 1 + 1e-9:
        unit.view.lose(None, "load_spectrum", f"shares of the load cases, which add up to {shares:g}")
        for own in table.values():
            own.pop("share", None)
    return dict(table)


def _time(case: LoadCase, key: str) -> object:
    """Duration or share of a load case as a model file has it; None where it is not given."""
    parts = [part for part in case.components if key and part.type == "gear_unit"]
    found = (number_of(part, row.id, QUANTITIES[row.unit]) for part in parts for row in rows_of("gear_unit", key))
    return next((row.text if key == "duration" else row.si for row in found if row is not None), None)


def _case_name(case: LoadCase, taken: Mapping[str, object]) -> str:
    """Name of a load case in a model file: its own where that is one, else by its id."""
    names = (one.attributes[CASE_NAME].value for one in case.components if CASE_NAME in one.attributes)
    name = str(next(names, ""))
    return name if _LABEL.fullmatch(name) and name not in (ALL_CASES, *taken) else f"case{case.id}"


def _tell_cases(view: View, case: int | None, *, chosen: bool) -> None:
    """Tell which load cases there are and which one counts; chosen : by the caller."""
    file = view.file
    if not file.load_cases:
        return
    if not chosen:
        text = f"load case {case}, the first" if case is not None else "values of the components themselves"
        view.assume(None, "load_case", "", f"{text}; another with --load-case")
    reason = "of load cases, times, speeds and torques are carried: no factors, load cycles and temperatures"
    view.lose(None, "load_spectrum", reason)
    if file.accumulations:
        view.lose(None, "accumulation", "accumulations over a load spectrum are results")


def _material(unit: GearUnit, gear: int) -> tuple[int, Table]:
    """Material of a gear: id of its component (0 where it has none) and its table."""
    material = material_of(unit.view, gear)
    if material is None:
        return 0, {}
    numbers = ((row, unit.view.number(material.id, row.id)) for row in _MATERIAL)
    return material.id, {row.key: row.entry(number) for row, number in numbers if number is not None and number.si > 0}


def _common_material(unit: GearUnit, materials: Sequence[tuple[int, Table]]) -> Table:
    """Material of all gears, where they have the same."""
    first = materials[0][1]
    if not first or any(table != first for _, table in materials):
        if not any(table for _, table in materials):
            unit.view.assume(None, "material", "", "no material in the file: steel")
        return {}
    for number in dict(materials):
        _read_material(unit, number, first, "material")
    return first


def _read_material(unit: GearUnit, number: int, material: Table, path: str) -> None:
    """Note the values of a material as read."""
    for row in _MATERIAL:
        if row.key in material:
            unit.view.read(number, row.id, f"{path}.{row.key}", material[row.key])


def _paths(table: object, path: str = "") -> Iterator[str]:
    """Paths of all that stands in nested tables."""
    for name, value in table.items() if isinstance(table, dict) else ():
        yield f"{path}{name}"
        yield from _paths(value, f"{path}{name}.")


def _comments(unit: GearUnit, paths: Set[str]) -> dict[str, str]:
    """Comments: name and id of the component of each stage and member, bearing and coupling that stands at a path."""
    view = unit.view
    comments = {f"stages.{stage.name}": _called(view, stage.id) for stage in unit.stages}
    for member in unit.members:
        if member.path in paths:
            comments[member.path] = ", ".join(_called(view, part) for part in (member.gears or member.parts)[:8])
    for entry in view.entries:
        joint = re.fullmatch(r"(?:.*\.)?(?:bearing|coupling)\d+", entry.path)
        if entry.component is not None and joint and entry.path in paths:
            comments[entry.path] = _called(view, entry.component)
    return comments


def _called(view: View, component: int) -> str:
    """``Sun gear [53]``, the id where the name does not have it."""
    name = view.components[component].name
    return name if f"[{component}]" in name else f"{name} [{component}]".strip()


def _warnings(unit: GearUnit) -> tuple[CodedText, ...]:
    """One warning of the stages that are not read, and where the train ends for it."""
    unread = unit.view.unread
    if not unread:
        return ()
    ends: dict[str, None] = {}
    for gear in (gear for pair in unread.values() for gear in pair):
        shaft = unit.view.shaft_of(gear)
        root = unit.rigid.root(gear if shaft is None else shaft)
        ends |= dict.fromkeys([unit.free[root]] if root in unit.free else [m.path for m in unit.turning.get(root, ())])
    verb = "s without planets are" if len(unread) > 1 else " without planets is"
    where = f"the train ends at {', '.join(ends)}" if ends else "nothing read is joined to them"
    return (coded("rexs-stages-unread", f"{len(unread)} gear stage{verb} not read: {where}"),)


def _unread(unit: GearUnit) -> set[int]:
    """Ids of what belongs to stages that are not read: gears, flanks, shafts no member has, with what is on them."""
    view = unit.view
    gears = {gear for pair in view.unread.values() for gear in pair}
    shafts = {shaft for gear in gears if (shaft := view.shaft_of(gear)) is not None}
    shafts = {s for s in shafts if not {unit.rigid.root(s)} & (unit.turning.keys() | unit.free.keys())}
    data = (data for stage in view.unread for data in view.joined("stage_gear_data", stage, 0, 2))
    parts = {*view.unread, *data, *gears, *shafts, *(flank.id for gear in gears for flank in view.flanks_of(gear))}
    parts |= {part for shaft in shafts for part in view.parts(shaft)}
    return parts | {joint.id for joint in unit.joints if {*joint.ends} & shafts}


def _counterparts(unit: GearUnit) -> Iterator[tuple[int, int]]:
    """Components of planets 2..n and of their meshes, and the same of planet 1."""
    view = unit.view

    def of(stage: StageParts, branch: Branch) -> Iterator[int]:
        gears = [*branch.gears, *(stage.twins[gear] for gear in branch.gears if gear in stage.twins)]
        flanks = [flank.id for gear in gears for flank in view.flanks_of(gear)]
        yield from (*gears, *flanks, branch.shaft, *view.parts(branch.shaft, "additional_mass", "shaft_section"))
        yield from (part.id for flank in flanks for part in view.referenced(flank))

    for stage in unit.stages:
        first = list(of(stage, stage.branches[0]))
        for branch in stage.branches[1:]:
            yield from ((b, a) for a, b in zip(first, of(stage, branch), strict=False) if a != b)
        yield from ((mesh, meshes[0]) for meshes in stage.meshes.values() for mesh in meshes[1:])


def _dropped(unit: GearUnit) -> Iterator[Entry]:
    """Every attribute that nobody asked for, by component, with the reason."""
    view, unread, firsts = unit.view, _unread(unit), dict(_counterparts(unit))
    for component in sorted(view.file.components, key=lambda c: c.id):
        first = view.components.get(firsts.get(component.id, -1))
        reasons: dict[str, list[str]] = {}
        for name, attribute in component.attributes.items():
            if name in view.asked.get(component.id, ()):
                continue
            if component.id in unread:
                reason = "of no planetary stage"
            elif first is not None and name in view.asked.get(first.id, ()):
                same = first.attributes.get(name) == attribute
                reason = "equal to planet 1" if same else f"component {first.id}, of planet 1, counts for all planets"
            else:
                reason = reason_dropped(component.type)
            reasons.setdefault(reason, []).append(name)
        yield from (Entry(component.id, ", ".join(names), "", reason) for reason, names in reasons.items())
    reason = "a name of the user's own, which the standard leaves to him"
    yield from (Entry(None, note, "", reason) for note in view.file.notes)
