"""Validation of an expanded document: the model in SI, and what is wrong in words that name the path.

One readable ModelError comes from whatever pydantic found, another from a contradiction between tables; geometry,
kinematics and statics are checked by the resolution.  The same validation finds bare numbers with their paths, and the
quantity that may stand at a path.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ..errors import ModelError
from .cases import at_case, check_cases
from .deviations import check_pitch
from .schema import (
    KIND_BY_NAME,
    SIDES,
    MemberTable,
    MeshTable,
    ModelFile,
    Names,
    SideTable,
    StageTable,
    check_label,
    nearest,
)
from .schema_fields import LinkDampingTable, LinkTable, Probe, Unit, metadata_of
from .tables import PlainTable, expand, leaves, merge, nested, normalise, value_at
from .units import ASKED, BareNumber, Quantity, Reading

_WORDS = {
    **dict.fromkeys(("int_type", "int_from_float"), "a whole number"),
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type"), "a table"),
    **dict.fromkeys(("tuple_type", "list_type"), "a list"),
    "bool_type": "true or false",
    "string_type": "a text",
    "float_type": "a number",
}
_FAULTS = {
    "missing": ("missing", ""),
    "finite_number": ("not finite", "a finite number"),
    "string_too_short": ("empty", "a text"),
    "float_parsing": ("not a number", "a number"),
    "int_parsing": ("not a whole number", "a whole number"),
    "bool_parsing": ("not true or false", "true or false"),
    "too_short": ("too few", "a longer list"),
    "too_long": ("too many", "a shorter list"),
}
_HIDDEN = {"members", "bearings", "form"}
Loc = tuple[int | str, ...]


def error_of(faults: Sequence[Any]) -> ModelError:
    """Return one ModelError of faults as pydantic lists them: the first, and where the others are."""
    # a misspelt key is also a missing one
    details = sorted(faults, key=lambda fault: fault["type"] != "extra_forbidden")
    first = details[0]
    problem, allowed = _describe(first)
    others = [path_of(detail["loc"]) for detail in details[1:] if detail["loc"] != first["loc"]]
    if others:
        problem += f" (and {len(others)} more, at {', '.join(others[:3])}{', ...' if len(others) > 3 else ''})"
    path = path_of(first["loc"])
    inner = first.get("ctx", {}).get("error")
    if isinstance(inner, ModelError) and inner.path:  # about a part of the value
        return ModelError(problem, path=f"{path}.{inner.path}", given=inner.given, allowed=allowed)
    if first["type"] == "missing":
        return ModelError(problem, path=path, allowed=allowed)
    return ModelError(problem, path=path, given=first["input"], allowed=allowed)


def path_of(loc: Loc) -> str:
    """Return the path in the file of a place in the schema, without the tables only the schema has."""

    def only_schema(i: int, part: int | str) -> bool:
        return (
            (i == 1 and loc[0] == "deviations")
            or (i == 2 and loc[0] == "stages" and part == "members")
            or (i > 2 and part == "bearings")
        )

    return ".".join(str(part).strip() for i, part in enumerate(loc) if not only_schema(i, part))


def _describe(detail: Any) -> tuple[str, str]:
    """Return what is wrong and what is allowed."""
    kind, loc, context = detail["type"], detail["loc"], detail.get("ctx", {})
    if isinstance(context.get("error"), ModelError):
        return context["error"].problem, context["error"].allowed
    if kind == "extra_forbidden":
        known = _keys(loc[:-1])
        in_stage = _table_at(loc[:-1]) in (StageTable, MemberTable)
        if in_stage and loc[-1] in _names(MeshTable) and str(loc[-1]) not in known:
            elsewhere = f"{loc[0]}.{loc[1]}.meshes.A-B.{loc[-1]}, with A-B such as sun-planet"
            return "unknown key here; it stands in the table of a mesh", elsewhere
        near = nearest(loc[-1], known)
        return f"unknown key{near}", "" if near else f"one of {', '.join(known)}"
    if kind == "missing":
        if loc[-1] == "kind":
            names = ", ".join(KIND_BY_NAME)
            allowed = f"kind = sun, planet, ring, carrier or gear, for a table that is none of {names}"
            return f"missing{nearest(loc[-2], _keys(loc[:-3]))}", allowed
        if "shaft_sections" in loc[:-1]:
            return "missing", "a section that the list has, counted from 1; a new one with to and diameter"
        table = _table_at(loc[:-1])
        field = table.model_fields.get(str(loc[-1])) if table else None
        return "missing", field.description or "" if field else ""
    if kind == "dict_type" and loc[-1] == "shaft_sections":
        return "no sections", "a list of one section or more, or no such key"
    return words_of(detail)


def words_of(detail: Any) -> tuple[str, str]:
    """What is wrong and what is allowed, of a fault as pydantic lists it, whatever the schema."""
    kind, context = detail["type"], detail.get("ctx", {})
    if kind == "literal_error":
        return "not a word known here", context["expected"].replace("'", '"')
    if kind in _WORDS:
        return f"not {_WORDS[kind]}", _WORDS[kind]
    if kind in _FAULTS:
        return _FAULTS[kind]
    limits = [f"{sign} {context[name]}" for name, sign in (("ge", ">="), ("le", "<=")) if name in context]
    return ("out of range", limits[0]) if limits else (str(detail["msg"]), "")


def _keys(loc: Loc) -> tuple[str, ...]:
    """Return the keys a table may have, as they are written."""
    table = _table_at(loc)
    if table is None:
        return ()
    names = _names(table)
    names += KIND_BY_NAME if issubclass(table, StageTable) else ()
    names += ["radial", "tilt"] if issubclass(table, LinkTable | LinkDampingTable) else ()
    return tuple(names)


def _names(table: type[BaseModel]) -> list[str]:
    """Return the keys of a table as they are written."""
    return [field.alias or name for name, field in table.model_fields.items() if name not in _HIDDEN]


def _table_at(loc: Loc) -> type[BaseModel] | None:
    """Return the model of the table at a place in the schema."""
    here: Any = ModelFile
    for part in loc:
        if get_origin(here) is dict:
            here = get_args(here)[1]
        elif _is_model(here) and part in here.model_fields:
            here = _unwrap(here.model_fields[str(part)].annotation)
        else:
            return None
    return here if _is_model(here) else None


def _unwrap(annotation: Any) -> Any:
    """Return the model in `X | None` or `Annotated[Quantity | X, ...] | None`, anything else as it is."""
    if get_origin(annotation) is dict:
        return annotation
    parts = (_unwrap(part) for part in get_args(annotation))
    return next((part for part in parts if _is_model(part)), annotation)


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


# contradictions between tables ----------------------------------------------------------------------------------------

_COMMON = set("kind mass inertia tilt_inertia split neck left right station material reduced".split())
_GEAR = (
    set(MemberTable.model_fields)
    - {"bearing", "support", "pin_radius", "ahead", "direction", "rim", "outer_diameter", "elastic"}
) | (_COMMON)
MEMBER_KEYS: dict[str, set[str]] = {
    "sun": _GEAR | {"support"},
    "ring": _GEAR - {"bore"} | {"support", "rim", "outer_diameter", "elastic"},
    "gear": _GEAR | {"support", "direction"},
    "planet": _GEAR | {"bearing", "pin_radius", "ahead"},
    "carrier": _COMMON | {"support", "pin_radius", "shaft_sections"},
}
"""Kind of member -> keys that its table may have."""

# 50 stages take a second; 500 bodies have 3000 coordinates, matrices of 72 MB and minutes for their modes
MOST_BODIES = 500
_MOST_STAGES, _MOST_ROWS = 50, 20_000


def check(model: ModelFile) -> None:
    """Raise ModelError for the first contradiction between tables."""
    if not model.stages:
        raise ModelError("missing", path="stages", allowed="at least one stage, [stages.NAME]")
    _check_size(model)
    for name, stage in model.stages.items():
        _check_stage(name, stage)
    for name, body in model.bodies.items():
        _check_counts(body, f"bodies.{name}", 0)
        # it has no radius, and no geometry to take a transverse inertia from
        for link in () if body.support is None else (body.support, *body.support.bearings.values()):
            if link.rz is not None and link.rz.unit == "N/m":
                path = f"bodies.{name}.support.rz"
                raise ModelError("rz in N/m without radius", path=path, allowed="rz in N m/rad")
            if (link.rx is not None or link.ry is not None) and body.tilt_inertia is None:
                allowed = "inertia about x and y of a body that tilts"
                raise ModelError("missing", path=f"bodies.{name}.tilt_inertia", allowed=allowed)
        if body.frame is not None and body.frame not in model.stages:
            near = nearest(body.frame, model.stages)
            allowed = f"one of {', '.join(model.stages)}, or nothing for the housing"
            raise ModelError(f"no such stage{near}", path=f"bodies.{name}.frame", given=body.frame, allowed=allowed)
    for name, coupling in model.couplings.items():
        path = f"couplings.{name}"
        if coupling.rz is not None and coupling.rz.unit == "N/m" and coupling.radius is None:
            raise ModelError("in N/m, but no radius is given", path=f"{path}.rz", allowed="rz in N m/rad, or a radius")
        if coupling.between[0] == coupling.between[1]:
            raise ModelError("joins a thing with itself", path=f"{path}.between", allowed="two members or bodies")
        _check_counts(coupling, path, 0, skip=("between",))
    for name in model.limits.stages:
        if name not in model.stages:
            problem, allowed = f"no such stage{nearest(name, model.stages)}", f"one of {', '.join(model.stages)}"
            raise ModelError(problem, path=f"limits.stages.{name}", allowed=allowed)
    check_cases(model.cases)
    _check_deviations(model)


def _check_size(model: ModelFile) -> None:
    """Raise ModelError for a train whose matrices no memory holds, or whose exact speeds take minutes."""
    if len(model.stages) > _MOST_STAGES:
        problem = f"{len(model.stages)} stages, whose exact speeds take time as the cube of their number"
        raise ModelError(problem, path="stages", allowed=f"at most {_MOST_STAGES}")
    bodies, rows = len(model.bodies), 0
    for stage in model.stages.values():
        own = sum(max(1, stage.branches) if member.kind == "planet" else 1 for member in stage.members.values())
        bodies += own
        rows += own * max((mesh.slices or 1 for mesh in stage.meshes.values()), default=1)
    size = (6 * bodies) ** 2 * 8e-9
    if bodies > MOST_BODIES:
        problem = f"{bodies} bodies, whose matrices need {size:.2g} GB each"
        raise ModelError(problem, path="stages", allowed=f"at most {MOST_BODIES} bodies")
    if rows > _MOST_ROWS:
        problem = f"some {rows} slices of meshes, whose rows need {rows * 6 * bodies * 8e-9:.2g} GB each time"
        raise ModelError(problem, path="stages", allowed=f"at most {_MOST_ROWS} in all")


def _check_stage(name: str, stage: StageTable) -> None:
    """Check the members, meshes and per-planet values of a stage."""
    path = f"stages.{name}"
    if not any(m.kind != "carrier" for m in stage.members.values()):
        raise ModelError("no gears", path=path, allowed="sun, planet, ring, wheel, pinion, or a table with kind")
    planets = [m for m, member in stage.members.items() if member.kind == "planet"]
    if planets and not stage.branches:
        raise ModelError("missing", path=f"{path}.planets", allowed="number of planets, or planet_angles")
    for member, table in stage.members.items():
        _check_member(f"{path}.{member}", name, table, stage)
    for mesh, keys in stage.meshes.items():
        count = stage.branches if set(mesh.split("-")) & set(planets) else 0
        _check_counts(keys, f"{path}.meshes.{mesh}", count)


def _check_member(path: str, stage_name: str, member: MemberTable, stage: StageTable) -> None:
    """Check one member against its name, its kind and its stage."""
    own = path.rpartition(".")[2]
    named = KIND_BY_NAME.get(own, member.kind)
    if member.kind != named:
        raise ModelError(
            "contradicts the name", path=f"{path}.kind", given=member.kind, allowed=f"{named}, or another name"
        )
    for key in sorted(member.model_fields_set - MEMBER_KEYS[member.kind]):
        allowed = f"one of {', '.join(sorted(MEMBER_KEYS[member.kind]))}"
        near = {"support": "; a planet has a bearing", "bearing": f"; a {member.kind} has a support"}.get(key, "")
        raise ModelError(f"no key of a {member.kind}{near}", path=f"{path}.{key}", allowed=allowed)
    if member.kind != "carrier" and member.teeth is None:
        raise ModelError("missing", path=f"{path}.teeth", allowed="number of teeth, positive also of a ring")
    if member.on is not None:
        # on another gear of its stage
        first, _, other = member.on.partition(".")
        known = [m for m, table in stage.members.items() if m != own and table.kind != "carrier"]
        if first != stage_name or other not in known:
            problem = f"no other gear of this stage{nearest(other, known)}"
            raise ModelError(problem, path=f"{path}.on", given=member.on, allowed=", ".join(known))
    for key in ("shaft", "clocking"):
        if getattr(member, key) is not None and member.on is None:
            raise ModelError("without `on`", path=f"{path}.{key}", allowed="on = the member whose shaft it sits on")
    if member.elastic is not None and member.reduced is not None:
        raise ModelError("elastic beside reduced", path=f"{path}.elastic", allowed="one of them")
    for key in ("bearing", "neck", "shaft"):
        _check_bolts(f"{path}.{key}", getattr(member, key))
    for side in SIDES:
        of_side: SideTable | None = getattr(member, side)
        _check_bolts(f"{path}.{side}.bearing", None if of_side is None else of_side.bearing)
        for key in sorted(of_side.model_fields_set - MEMBER_KEYS[member.kind] if of_side else ()):
            allowed = ", ".join(sorted(set(SideTable.model_fields) & MEMBER_KEYS[member.kind]))
            raise ModelError(f"no key of a {member.kind}", path=f"{path}.{side}.{key}", allowed=f"one of {allowed}")
    _check_counts(member, path, stage.branches if member.kind == "planet" else 0)


def _check_bolts(path: str, link: LinkTable | None) -> None:
    """Check that bolts stand only where a pitch circle is: in supports and couplings."""
    for name, table in {"": link, **getattr(link, "bearings", {})}.items():
        if table is not None and table.bolts is not None:
            where = f"{path}.{name}.bolts" if name else f"{path}.bolts"
            raise ModelError("no bolts here", path=where, given=table.bolts.radius, allowed="in supports and couplings")


def _check_deviations(model: ModelFile) -> None:
    """Check lists per planet, measured pitches, and what errors of a mesh turn with."""
    for path, table in model.deviations.members.items():
        stage_name, _, rest = path.partition(".")
        member = model.stages[stage_name].members[rest.partition(".")[0]] if rest else None
        count = model.stages[stage_name].branches if member and member.kind == "planet" else 0
        _check_counts(table, f"deviations.{path}", count)
        if table.pitch is not None:
            check_pitch(f"deviations.{path}.pitch", table.pitch, member.teeth if member else None, count)
    for path, mesh in model.deviations.meshes.items():
        stage = model.stages[path.partition(".")[0]]
        gears = path.split(".")[2].split("-")
        planets = any(stage.members[g].kind == "planet" for g in gears)
        _check_counts(mesh, f"deviations.{path}", stage.branches if planets else 0)
        carriers = [member for member, of_stage in stage.members.items() if of_stage.kind == "carrier"]
        known = [f"{path.partition('.')[0]}.{member}" for member in (*gears, *carriers)]
        both = all(stage.members[gear].kind == "planet" for gear in gears)
        for name, error in mesh.errors.items():
            where, given = f"deviations.{path}.errors.{name}", error.turns_with
            check_label(name, where)
            if given not in known:
                problem = "turns with no part of this mesh"
                raise ModelError(problem, path=f"{where}.turns_with", given=given, allowed=", ".join(known))
            if error.from_ == "normal" and both and given not in known[: len(gears)]:
                problem = "the carrier carries both gears"
                raise ModelError(problem, path=f"{where}.from", given="normal", allowed='"pitch-point"')


def _check_counts(table: object, path: str, count: int, skip: tuple[str, ...] = ()) -> None:
    """Raise ModelError for a list in a table that has not one number per planet (count 0: no planets here)."""
    for where, value in _values(table, path, skip):
        lists = isinstance(value, tuple) and any(isinstance(entry, tuple) for entry in value)  # as of `pitch`
        if isinstance(value, tuple) and not lists and len(value) != count:
            problem, allowed = "a list where one number stands", "one number"
            if count:
                problem = f"a list of {len(value)}"
                allowed = f"one number, or {count}, one per planet; with other planets, set it beside them"
            raise ModelError(problem, path=where, given=list(value), allowed=allowed)


def _values(table: object, path: str, skip: tuple[str, ...] = ()) -> Iterator[tuple[str, object]]:
    """Yield path and value of every number or per-planet tuple in a table and those in it."""
    fields = getattr(type(table), "model_fields", {})
    for name, field in fields.items():
        value = getattr(table, name)
        where = path if name in ("members", "bearings") else f"{path}.{name}"
        if name in (*skip, "reduced") or value is None:  # numbers of nodes are no list of planets
            continue
        if isinstance(value, tuple) and any(isinstance(m, Unit) and m.lists for m in metadata_of(field)):
            continue  # a list of its own, not one value per planet
        if isinstance(value, dict):
            for entry, below in value.items():
                yield from _values(below, f"{where}.{entry}")
        elif hasattr(type(value), "model_fields"):
            yield from _values(value, where)
        else:
            yield where, value.value if isinstance(value, Quantity) else value


# the whole model ------------------------------------------------------------------------------------------------------


def validate(data: PlainTable, names: Names) -> tuple[ModelFile, bool]:
    """Return the validated model at its case, and whether a bare number stands in it. Raises one ModelError."""
    context = Reading()
    try:
        model = ModelFile.model_validate(normalise(data, names), context=context)
    except ValidationError as error:
        raise error_of(error.errors(include_url=False)) from None
    try:
        check(model)
        model = at_case(model)
    except ModelError as error:  # say what the file says, not its value in SI
        written = value_at(data, error.path.split("."))
        given = error.given if written is None or isinstance(written, dict) else written
        raise ModelError(error.problem, path=error.path, given=given, allowed=error.allowed) from None
    return model, context.found


def bare_numbers(data: PlainTable, names: Names) -> dict[str, BareNumber]:
    """Return the errors that would name the values with a bare number in them, by path in the expanded document.

    They are in the order of the schema; other faults are passed over.
    """
    faults = _faults(data, names, Reading(strict=True))
    errors = ((path_of(fault["loc"]), fault.get("ctx", {}).get("error")) for fault in faults)
    return {path: error for path, error in errors if isinstance(error, BareNumber)}


def quantity_at(data: PlainTable, path: str, names: Names) -> Probe:
    """Return which quantity may stand at a path of the document.

    Raises ModelError where no number may, or where a number alone is not enough.
    """
    faults = _faults(merge(data, expand(nested(tuple(path.split(".")), ASKED), names)), names, Reading())
    answers = [detail for detail in faults if isinstance(detail.get("ctx", {}).get("error"), Probe)]
    if answers:
        found: Probe = answers[0]["ctx"]["error"]
        # what the number alone does not make whole: an error that turns with nothing, a load on nothing
        if others := [detail for detail in faults if detail not in answers]:
            raise error_of(others)
        return found
    here = [detail for detail in faults if path_of(detail["loc"]).startswith(path)]
    if any(detail["type"].startswith("int_") for detail in here):  # a count
        return Probe(None)
    raise error_of(here) if here else ModelError("no number stands here", path=path)


def quantities_at(data: PlainTable, paths: Iterable[str], names: Names) -> dict[str, Probe | ModelError]:
    """Return what `quantity_at` says of each path, an error in place of one that it raises.

    All are asked for in one validation; where anything else is wrong then, each by itself.
    """

    def alone(path: str) -> Probe | ModelError:
        try:
            return quantity_at(data, path, names)
        except ModelError as error:
            return error

    layers = {path: expand(nested(tuple(path.split(".")), ASKED), names) for path in paths}
    try:
        faults = _faults(reduce(merge, layers.values(), data), names, Reading())
    except ModelError:  # a path refers to nothing
        faults = []
    errors = [(path_of(fault["loc"]), fault.get("ctx", {}).get("error")) for fault in faults]
    answers = {path: error for path, error in errors if isinstance(error, Probe)}
    if not answers or len(answers) < len(errors):
        return {path: alone(path) for path in layers}
    first = {path: next((answers[p] for p, _ in leaves(layer) if p in answers), None) for path, layer in layers.items()}
    return {path: probe or alone(path) for path, probe in first.items()}


def _faults(data: PlainTable, names: Names, context: Reading) -> list[Any]:
    """Return what pydantic finds wrong."""
    try:
        ModelFile.model_validate(normalise(data, names), context=context)
    except ValidationError as error:
        return list(error.errors(include_url=False))
    return []
