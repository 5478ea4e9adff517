"""Contradictions between tables of a document; resolution checks geometry, kinematics and statics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pydantic.fields import FieldInfo

from ..errors import ModelError
from .deviations import MemberDeviationsTable, TurningErrorTable, kind_of
from .names import SIDES, check_label, nearest
from .schema import KIND_BY_NAME, BodyTable, MemberTable, ModelFile, SideTable, StageTable
from .schema_fields import Unit, metadata_of
from .schema_links import CouplingTable, LinkTable, SupportTable
from .units import Quantity

__all__ = ["check"]

_COMMON = {"kind", "mass", "inertia", "tilt_inertia", "split", "neck", "left", "right", "station", "material"}
_GEAR = (
    set(MemberTable.model_fields) - {"bearing", "support", "pin_radius", "ahead", "direction", "rim", "outer_diameter"}
) | (_COMMON)
_ALLOWED: dict[str, set[str]] = {
    "sun": _GEAR | {"support"},
    "ring": _GEAR - {"bore"} | {"support", "rim", "outer_diameter"},
    "gear": _GEAR | {"support", "direction"},
    "planet": _GEAR | {"bearing", "pin_radius", "ahead"},
    "carrier": _COMMON | {"support", "pin_radius"},
}

# 50 stages take a second; 500 bodies have 3000 coordinates, matrices of 72 MB and minutes for their modes
_MOST_STAGES, _MOST_BODIES, _MOST_ROWS = 50, 500, 20_000


def check(model: ModelFile) -> None:
    """Raise ModelError for the first contradiction between tables."""
    if not model.stages:
        raise ModelError("missing", path="stages", allowed="at least one stage, [stages.NAME]")
    _check_size(model)
    for name, stage in model.stages.items():
        _check_stage(name, stage)
    for name, body in model.bodies.items():
        _check_body(f"bodies.{name}", body)
        if body.frame is not None and body.frame not in model.stages:
            near = nearest(body.frame, model.stages)
            allowed = f"one of {', '.join(model.stages)}, or nothing for the housing"
            raise ModelError(f"no such stage{near}", path=f"bodies.{name}.frame", given=body.frame, allowed=allowed)
    for name, coupling in model.couplings.items():
        _check_coupling(f"couplings.{name}", coupling)
    _check_operation(model)
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
    if bodies > _MOST_BODIES:
        problem = f"{bodies} bodies, whose matrices need {size:.2g} GB each"
        raise ModelError(problem, path="stages", allowed=f"at most {_MOST_BODIES} bodies")
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
        for where, value in _values(keys, f"{path}.meshes.{mesh}"):
            _check_count(where, value, count)


def _check_member(path: str, stage_name: str, member: MemberTable, stage: StageTable) -> None:
    """Check one member against its name, its kind and its stage."""
    named = KIND_BY_NAME.get(path.rpartition(".")[2], member.kind)
    if member.kind != named:
        raise ModelError(
            "contradicts the name", path=f"{path}.kind", given=member.kind, allowed=f"{named}, or another name"
        )
    for key in sorted(member.model_fields_set - _ALLOWED[member.kind]):
        allowed = f"one of {', '.join(sorted(_ALLOWED[member.kind]))}"
        near = {"support": "; a planet has a bearing", "bearing": f"; a {member.kind} has a support"}.get(key, "")
        raise ModelError(f"no key of a {member.kind}{near}", path=f"{path}.{key}", allowed=allowed)
    if member.kind != "carrier" and member.teeth is None:
        raise ModelError("missing", path=f"{path}.teeth", allowed="number of teeth, positive also of a ring")
    if member.on is not None:
        _check_shaft(path, stage_name, member.on, stage)
    for key in ("shaft", "clocking"):
        if getattr(member, key) is not None and member.on is None:
            raise ModelError("without `on`", path=f"{path}.{key}", allowed="on = the member whose shaft it sits on")
    for key in ("bearing", "neck", "shaft"):
        _check_bolts(f"{path}.{key}", getattr(member, key))
    _check_sides(path, member)
    for where, value in _values(member, path):
        _check_count(where, value, stage.branches if member.kind == "planet" else 0)


def _check_sides(path: str, member: MemberTable) -> None:
    """Check the keys of the sides against the member's kind."""
    for side in SIDES:
        table: SideTable | None = getattr(member, side)
        _check_bolts(f"{path}.{side}.bearing", None if table is None else table.bearing)
        for key in sorted(table.model_fields_set - _ALLOWED[member.kind] if table else ()):
            allowed = ", ".join(sorted(set(SideTable.model_fields) & _ALLOWED[member.kind]))
            raise ModelError(f"no key of a {member.kind}", path=f"{path}.{side}.{key}", allowed=f"one of {allowed}")


def _check_shaft(path: str, stage_name: str, on: str, stage: StageTable) -> None:
    """Check that a gear sits on another gear of its stage."""
    first, _, other = on.partition(".")
    own = path.rpartition(".")[2]
    if first != stage_name or other == own or other not in stage.members or stage.members[other].kind == "carrier":
        known = [m for m, table in stage.members.items() if m != own and table.kind != "carrier"]
        near = nearest(other, known)
        raise ModelError(f"no other gear of this stage{near}", path=f"{path}.on", given=on, allowed=", ".join(known))


def _check_body(path: str, body: BodyTable) -> None:
    """Check a body's support: it has no radius, and no geometry to take a transverse inertia from."""
    for where, value in _values(body, path):
        _check_count(where, value, 0)
    for link in _links(body.support):
        if link.rz is not None and link.rz.unit == "N/m":
            raise ModelError("rz in N/m without radius", path=f"{path}.support.rz", allowed="rz in N m/rad")
        if (link.rx is not None or link.ry is not None) and body.tilt_inertia is None:
            raise ModelError(
                "missing", path=f"{path}.tilt_inertia", allowed="inertia about x and y of a body that tilts"
            )


def _check_coupling(path: str, coupling: CouplingTable) -> None:
    """Check that an rz in N/m has a radius, and that two different things are joined."""
    if coupling.rz is not None and coupling.rz.unit == "N/m" and coupling.radius is None:
        raise ModelError("in N/m, but no radius is given", path=f"{path}.rz", allowed="rz in N m/rad, or a radius")
    if coupling.between[0] == coupling.between[1]:
        raise ModelError("joins a thing with itself", path=f"{path}.between", allowed="two members or bodies")
    for where, value in _values(coupling, path, skip=("between",)):
        _check_count(where, value, 0)


def _check_bolts(path: str, link: LinkTable | None) -> None:
    """Check that bolts stand only where a pitch circle is: in supports and couplings."""
    for name, table in {"": link, **getattr(link, "bearings", {})}.items():
        if table is not None and table.bolts is not None:
            where = f"{path}.{name}.bolts" if name else f"{path}.bolts"
            raise ModelError("no bolts here", path=where, given=table.bolts.radius, allowed="in supports and couplings")


def _links(support: SupportTable | None) -> tuple[LinkTable, ...]:
    """Return the links of a support."""
    return () if support is None else (support, *support.bearings.values())


def _check_operation(model: ModelFile) -> None:
    """Check that held members are named once and given no speed, and that one member takes the balance."""
    operation = model.operation
    for i, member in enumerate(operation.held):
        if member in operation.held[:i]:
            raise ModelError("held twice", path="operation.held", given=member, allowed="each member once")
        if operation.speed.get(member, 0.0) != 0.0:
            path = f"operation.speed.{member}"
            raise ModelError("is held", path=path, given=operation.speed[member], allowed="no speed of a held member")
    balance = [m for m, torque in operation.torque.items() if torque == "balance"]
    if len(balance) > 1:
        path = f"operation.torque.{balance[1]}"
        raise ModelError(f"{balance[0]} takes it already", path=path, given="balance", allowed="one balance")


def _check_deviations(model: ModelFile) -> None:
    """Check lists per planet, and kinds of deviation with a check of their own."""
    for path, table in model.deviations.members.items():
        stage_name, _, rest = path.partition(".")
        member = model.stages[stage_name].members[rest.partition(".")[0]] if rest else None
        count = model.stages[stage_name].branches if member and member.kind == "planet" else 0
        own = {k: check for k in MemberDeviationsTable.model_fields if (check := kind_of(type(table), k).check)}
        for where, value in _values(table, f"deviations.{path}"):
            _check_count(where, value, count)
        for name, check in own.items():
            if (value := getattr(table, name)) is not None:
                check(f"deviations.{path}.{name}", value, member.teeth if member else None, count)
    for path, mesh in model.deviations.meshes.items():
        stage = model.stages[path.partition(".")[0]]
        gears = path.split(".")[2].split("-")
        planets = any(stage.members[g].kind == "planet" for g in gears)
        for where, value in _values(mesh, f"deviations.{path}"):
            _check_count(where, value, stage.branches if planets else 0)
        for name, error in mesh.errors.items():
            _check_turning(f"deviations.{path}.errors.{name}", name, error, path.partition(".")[0], gears, stage)


def _check_turning(
    path: str, name: str, error: TurningErrorTable, stage_name: str, gears: Sequence[str], stage: StageTable
) -> None:
    """Check the name of an error of a mesh, and that it turns with a gear of the mesh or with the carrier."""
    check_label(name, path)
    carriers = [member for member, table in stage.members.items() if table.kind == "carrier"]
    known = [f"{stage_name}.{member}" for member in (*gears, *carriers)]
    if error.turns_with not in known:
        given = error.turns_with
        raise ModelError(
            "turns with no part of this mesh", path=f"{path}.turns_with", given=given, allowed=", ".join(known)
        )
    both = all(stage.members[gear].kind == "planet" for gear in gears)
    if error.from_ == "normal" and both and error.turns_with not in known[: len(gears)]:
        raise ModelError("the carrier carries both gears", path=f"{path}.from", given="normal", allowed='"pitch-point"')


def _values(table: object, path: str, skip: tuple[str, ...] = ()) -> Iterator[tuple[str, object]]:
    """Yield path and value of every number or per-planet tuple in a table and those in it."""
    fields = getattr(type(table), "model_fields", {})
    for name, field in fields.items():
        value = getattr(table, name)
        where = path if name in ("members", "bearings") else f"{path}.{name}"
        if name in skip or value is None or (isinstance(value, tuple) and _is_list(field)):
            continue
        if isinstance(value, dict):
            for entry, below in value.items():
                yield from _values(below, f"{where}.{entry}")
        elif hasattr(type(value), "model_fields"):
            yield from _values(value, where)
        else:
            yield where, value.value if isinstance(value, Quantity) else value


def _is_list(field: FieldInfo) -> bool:
    """Return whether a key takes a list of its own, which is not one value per planet."""
    return any(isinstance(m, Unit) and m.lists for m in metadata_of(field))


def _check_count(path: str, value: object, count: int) -> None:
    """Raise ModelError for a list of numbers that has not one entry per planet (count 0: no planets here)."""
    lists = isinstance(value, tuple) and any(isinstance(entry, tuple) for entry in value)  # as of `pitch`
    if isinstance(value, tuple) and not lists and len(value) != count:
        given = list(value)
        if not count:
            raise ModelError("a list where one number stands", path=path, given=given, allowed="one number")
        allowed = f"one number, or {count}, one per planet; with other planets, set it beside them"
        raise ModelError(f"a list of {len(value)}", path=path, given=given, allowed=allowed)
