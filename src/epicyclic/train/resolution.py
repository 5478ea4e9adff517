"""From a model file to the resolved Train: reading, and everything that follows from the document; and back.

Checked is what a stage cannot be, and what is doubtful about it: room for the planets, one centre distance for all
meshes.  What turns and loads the train follows: kinematics, torques on bodies, loads, gravity.  Tolerances get the
sizes that their grades apply to, and the checks that only the resolved train allows.  Written back, every value stands
in the file; resolving that gives the same train.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np

from ..document.cases import of_another_point
from ..document.deviations import Distribution, StandardGrade
from ..document.document import Document, read
from ..document.schema import SIDES, ModelFile, collect
from ..document.tables import TOLERANCE_TABLES
from ..document.tolerances import Correlations, Grade, Tolerance, Width, read_correlations, tolerances
from ..errors import ModelError, in_mm
from ..teeth import geometry
from ..teeth.geometry import FLANK_GRADES, SIZE_GRADES, in_flank_range, profile_width, run_out_width, size_width
from ..user_input import checked
from .centres import StageShape, shape_stage
from .deviations import DeviationScope, check_sizes, misaligned_bodies, module_of, resolve_deviations
from .elastic_bodies import log_rings, with_reduced
from .gears import half_station, width_of
from .kinematics import Gearing, Kinematics, Tie, solve_kinematics
from .links import couplings, links_of_bodies, links_of_stage
from .mesh_laws import contact_errors
from .phasing import disc_gaps
from .power import planet_arms, power_flow
from .ripple import resolve_ripples
from .sensors import resolve_sensors
from .shafts import bent_shafts, moved_loads, warn_of_spans
from .stage_bodies import bodies_of_stage, coaxial, frames_of, free_bodies, member_centre, meshes_of_stage, tilt_groups
from .stages import GearPair, Plan, gear_below, plan_stages
from .train import DIRECTIONS, Body, Damping, Derived, Load, Mesh, ResolutionLog, Train, bodies_named, stage_axis

# Tooth heights of rim outside the root circle.  From there on the rim-thickness factor of [iso6336], part 3, is 1 for
# external teeth: the rim then carries like a solid body.  Quoted from memory; for internal teeth the same part sets the
# limit at 3.5 modules as far as remembered, 1.6 tooth heights, so what is warned of here is thin by either.
THIN_RIM = 1.2
ONE_DISTANCE = 1e-6  # relative; distances computed twice agree to rounding, printed radii do not
Tell = Callable[[str, ModelError], None]
"""Raises an error, or warns by a code where stated radii allow what teeth and module do not."""


def check_stage(shape: StageShape, log: ResolutionLog) -> None:
    """Check one stage: gears that overlap, rings, and whether the distances of all meshes agree.

    Raises
    ------
    ModelError : planets collide, gears in one plane overlap without meshing, a ring smaller than what turns in it;
        warnings instead where radii are given.
    """
    given = any(m.base_radius is not None or m.pin_radius is not None for m in shape.plan.stage.members.values())

    def tell_overlap(code: str, error: ModelError) -> None:
        if not given:
            raise error
        log.coded(code, f"{error.path}: {error.problem} ({error.given})")

    for p in shape.plan.pairs:
        if p.internal:
            _check_ring(shape, p, tell_overlap, log)
    _check_rims(shape, log)
    _check_neighbours(shape, tell_overlap, log)
    _check_distances(shape, log)


def _check_ring(shape: StageShape, p: GearPair, tell_overlap: Tell, log: ResolutionLog) -> None:
    """Check that a planet has room in its ring: roots clear of tips."""
    planet, ring = (shape.gear(name) for name in (p.a, p.b))
    room = geometry.radial_clearance(_axes(shape, p), planet.tip_radius, ring.root_radius, internal=True)
    if room < -planet.module:
        problem, path = f"the ring is smaller than {p.a}, which turns in it", f"{shape.plan.member_path(p.b)}.teeth"
        allowed = f"a root radius above {in_mm(ring.root_radius - room, 4)}; it is {in_mm(ring.root_radius, 4)}"
        tell_overlap("ring-too-small", ModelError(problem, path=path, given=str(ring.teeth), allowed=allowed))
    elif room < 0:
        log.coded("tips-in-roots", f"{p.path}: the tips of {p.a} reach {in_mm(-room, 3)} into the roots of {p.b}")


def _check_rims(shape: StageShape, log: ResolutionLog) -> None:
    """Warn of a ring that is too thin to keep its shape."""
    for name, member in shape.plan.gears.items():
        gear = shape.gear(name)
        height = gear.root_radius - gear.tip_radius
        rim = member.rim if member.outer_diameter is None else member.outer_diameter / 2 - gear.root_radius
        if rim is not None and rim < THIN_RIM * height and member.elastic is None:
            key = "rim" if member.outer_diameter is None else "outer_diameter"
            log.coded(
                "thin-rim",
                f"{shape.plan.member_path(name)}.{key}: the rim is {max(rim, 0.0) / height:.3g} tooth heights "
                f"thick, below {THIN_RIM:g} it bends between the planets; it is computed as rigid",
            )


def _axes(shape: StageShape, p: GearPair) -> float:
    """Distance between the axes of a pair [m]."""
    return math.dist(shape.place(p.a, 0), shape.place(p.b, 0))


def _check_neighbours(shape: StageShape, tell_overlap: Tell, log: ResolutionLog) -> None:
    """Tip circles of external gears that neither mesh nor share a shaft must not overlap in one plane.

    Gears of one plane: the file states where one of them stands along the axis and their faces overlap, or both are
    planet gears that lie beside each other.  Where no axial place is stated, two suns of a chain of meshes show that
    it has several planes (Ravigneaux), and a chain behind a stepped shaft lies in another one; else a doubt is said.
    """
    plan = shape.plan
    external = [name for name, member in plan.gears.items() if member.kind != "ring"]
    gears = [(name, i) for name in external for i in range(1 if plan.central(name) else plan.branches)]
    tips = [shape.gear(name).tip_radius for name, _ in gears]
    gaps = disc_gaps(np.array([shape.place(name, i) for name, i in gears]).reshape(-1, 2), np.array(tips))
    told: set[tuple[str, str]] = set()
    for (i, (a, branch_a)), (j, (b, branch_b)) in combinations(enumerate(gears), 2):
        same = branch_a == branch_b or plan.central(a) or plan.central(b)
        joined = plan.axis[a] == plan.axis[b] or any({p.a, p.b} == {a, b} for p in plan.pairs)
        if gaps[i, j] >= 0 or (a, b) in told or (same and joined) or _apart(plan, a, b):
            continue
        told.add((a, b))
        beside = not plan.central(a) and not plan.central(b) and (a == b or (plan.axis[a], plan.axis[b]) == (a, b))
        both = f"{_numbered(plan, a, branch_a)} and {_numbered(plan, b, branch_b)}"
        text = f"{both} overlap by {in_mm(-gaps[i, j], 4)}"
        if beside:
            path = f"{plan.path}.planets" if plan.stage.planet_angles is None else f"{plan.path}.planet_angles"
            words, allowed = f"{plan.branches}; {text}", "fewer planets, or smaller ones"
            tell_overlap("planets-collide", ModelError("planets collide", path=path, given=words, allowed=allowed))
            return
        _say_overlap(plan, (a, b), text, tell_overlap, log)


def _numbered(plan: Plan, gear: str, branch: int) -> str:
    return gear if plan.central(gear) else f"{gear} {branch + 1}"


def _apart(plan: Plan, a: str, b: str) -> bool:
    """Whether the stated axial places keep two gears in different planes."""

    def faces(gear: str) -> list[tuple[float, float]]:
        """Axial ends of its faces [m]; a width that is not stated is none."""
        sides = SIDES if plan.two_sided(gear) else (None,)
        places = [(half_station(plan, gear, side), (width_of(plan, gear, side) or 0.0) / 2) for side in sides]
        return [(at - half, at + half) for at, half in places]

    pairs = list(product(faces(a), faces(b)))
    return all(x != y and (x[1] <= y[0] or y[1] <= x[0]) for x, y in pairs)


def _say_overlap(plan: Plan, pair: tuple[str, str], text: str, tell_overlap: Tell, log: ResolutionLog) -> None:
    """Refuse two gears that overlap in one plane; warn where the file does not say that it is one."""
    stated = [name for name in pair if plan.stage.members[name].station is not None]
    suns = [name for name, m in plan.gears.items() if m.kind == "sun" and plan.chains[name] == plan.chains[pair[0]]]
    if stated:
        path, allowed = (
            f"{plan.member_path(stated[0])}.station",
            "axial places that keep their faces apart, or other teeth",
        )
        tell_overlap(
            "gears-overlap", ModelError("gears overlap without meshing", path=path, given=text, allowed=allowed)
        )
    elif plan.chains[pair[0]] == plan.chains[pair[1]] and len(suns) < 2:
        doubt = "without meshing; station of each says whether they stand in different planes"
        log.coded("gears-overlap", f"{plan.path}: {text} {doubt}")


def _check_distances(shape: StageShape, log: ResolutionLog) -> None:
    """Warn where the radii and working angles of the meshes fit no single place of the axes."""
    plan, differs, texts = shape.plan, False, []
    for p in plan.pairs:
        a, b = shape.gear(p.a).base_radius, shape.gear(p.b).base_radius
        by_teeth = (b - a if p.internal else b + a) / math.cos(shape.meshes[p.name].working_angle)
        between = _axes(shape, p)
        differs |= abs(by_teeth - between) > ONE_DISTANCE * between
        texts.append(f"{p.name} {in_mm(by_teeth)} (axes {in_mm(between)})")
    if differs:
        text = f"{plan.path}: centre distances differ, base radii and working angles fit no single one:"
        log.coded("centre-distances-differ", f"{text} {', '.join(texts)}; turning as a whole then stresses the teeth")


# what turns and loads the train ---------------------------------------------------------------------------------------


def member_of(reference: str) -> str:
    """Member of a reference without its side."""
    return ".".join(reference.split(".")[:2])


def gearings_of(plans: Sequence[Plan]) -> tuple[Gearing, ...]:
    """Every pair of members that mesh, for the kinematics."""
    return tuple(
        Gearing(
            pair=p.path,
            stage=plan.name,
            a=f"{plan.name}.{p.a}",
            b=f"{plan.name}.{p.b}",
            teeth_a=plan.gears[p.a].teeth or 0,
            teeth_b=plan.gears[p.b].teeth or 0,
            internal=p.internal,
            carrier=_carrier(plan) if not (plan.central(p.a) and plan.central(p.b)) else None,
        )
        for plan in plans
        for p in plan.pairs
    )


def kinematics_of(model: ModelFile, plans: Sequence[Plan], log: ResolutionLog) -> Kinematics:
    """Solve speeds and torques.

    Raises
    ------
    ModelError : speeds or torques that are too few, too many or contradicting.
    """
    operation = model.operation
    members = [f"{plan.name}.{name}" for plan in plans for name in plan.stage.members] + list(model.bodies)
    planets = {f"{plan.name}.{name}" for plan in plans for name in plan.gears if not plan.central(name)}
    torques: dict[str, float] = {}
    balance: list[str] = []
    for name, value in operation.torque.items():
        member = member_of(name)
        log.note(f"{model.operation_path('torque')}.torque.{name}", value, "N m")
        if isinstance(value, str):
            balance.append(member)
        else:
            torques[member] = torques.get(member, 0.0) + value
    powers: dict[str, float] = {}
    for name, power in operation.power.items():
        member = member_of(name)
        powers[member] = powers.get(member, 0.0) + power
        log.note(f"{model.operation_path('power')}.power.{name}", power, "W")
    speeds: dict[str, Fraction] = {}  # exact, in revolutions per minute
    for name, speed in operation.speed.items():
        speeds[member_of(name)] = Fraction(speed * 30 / math.pi).limit_denominator(10**6)
        log.note(f"{model.operation_path('speed')}.speed.{name}", speed, "rad/s")
    return solve_kinematics(
        members=members,
        gearings=gearings_of(plans),
        ties=ties_of(model, plans),
        held=list(dict.fromkeys(member_of(name) for name in operation.held)),
        speeds=speeds,
        torques=torques,
        powers=powers,
        balance=balance,
        carriers={plan.name: _carrier(plan) for plan in plans},
        ends=[name for name in members if name not in planets],
    )


def _carrier(plan: Plan) -> str | None:
    """Full path of the carrier of a stage, None where the axes stand in the housing."""
    return None if plan.carrier is None else f"{plan.name}.{plan.carrier}"


def ties_of(model: ModelFile, plans: Sequence[Plan]) -> tuple[Tie, ...]:
    """Every coupling and shaft that makes two members turn together, for the kinematics."""
    shafts = [
        Tie(name=f"{plan.name}.{name}", a=f"{plan.name}.{below}", b=f"{plan.name}.{name}")
        for plan in plans
        for name, member in plan.gears.items()
        if (below := gear_below(member)) is not None
    ]
    joined = [
        Tie(name=name, a=member_of(table.between[0]), b=member_of(table.between[1]))
        for name, table in model.couplings.items()
        if table.rz is None or table.rz.value != 0.0
    ]
    return (*shafts, *(tie for tie in joined if tie.a != tie.b))


def body_torques(model: ModelFile, kinematics: Kinematics, bodies: Sequence[Body]) -> Iterator[tuple[str, float]]:
    """External torque on each body that carries one [N m]: on a split member half each, unless a side is named."""
    for member, torque in (kinematics.torque or {}).items():
        pieces = [body for body in bodies if body.member == member]
        if member in kinematics.held or not pieces:
            continue
        shares = _sided_torques(member, model, kinematics)
        if shares and pieces[0].side is None:
            key = "torque" if any(f"{member}.{side}" in model.operation.torque for side in SIDES) else "power"
            problem = "names a side of a member in one piece"
            raise ModelError(problem, path=f"operation.{key}.{member}", allowed="the member, or split")
        for body in pieces:
            value = shares.get(body.side, 0.0) if shares else torque / len(pieces)
            if value:
                yield body.name, value


def _sided_torques(member: str, model: ModelFile, kinematics: Kinematics) -> dict[str | None, float]:
    """Torque of each half [N m] where the file names sides: as stated, the rest at the balancing half or halved."""
    operation = model.operation
    torques = {s: operation.torque[f"{member}.{s}"] for s in SIDES if f"{member}.{s}" in operation.torque}
    powers = {s: operation.power[f"{member}.{s}"] for s in SIDES if f"{member}.{s}" in operation.power}
    if not torques and not powers:
        return {}
    halves: dict[str | None, float] = {s: v for s, v in torques.items() if isinstance(v, float)}
    omega = float((kinematics.speed or {}).get(member, 0)) * math.pi / 30
    halves |= {s: power / omega for s, power in powers.items() if omega}
    takers = [s for s in torques if s not in halves]
    rest = (kinematics.torque or {})[member] - sum(halves.values())
    takers = takers or (["left", "right"] if member in operation.torque else [])
    for side in takers:
        halves[side] = halves.get(side, 0.0) + rest / len(takers)
    return halves


def external_loads(model: ModelFile, bodies: Sequence[Body]) -> Iterator[Load]:
    """The file's loads: on a split member half on each half, on a planet gear the same on every planet."""
    for name, table in model.loads.items():
        pieces = bodies_named(table.on, bodies)
        share = 0.5 if len({b.side for b in pieces}) > 1 else 1.0
        force, moment = ((v.x * share, v.y * share, v.z * share) for v in (table.force, table.moment))
        for body in pieces:
            yield Load(
                path=f"loads.{name}",
                body=body.name,
                force=force,
                moment=moment,
                station=member_centre(body, model) + table.at,
                turns=table.frame == "member",
            )


# tolerances -----------------------------------------------------------------------------------------------------------


def tolerances_of(train: Train) -> tuple[Tolerance, ...]:
    """Return the entries of `[tolerance]` of a train, grades with their widths.  Raises ModelError.

    Those of the operation or a case are of it where this is what is computed, and states the number.
    """
    entries = tolerances(train.document, _width_of(train.bodies, train.meshes))
    return tuple(entry for entry in entries if not of_another_point(train.document, entry.path))


def costs_of(train: Train) -> dict[str, tuple[Grade, ...]]:
    """Return the grades that `[tolerance.cost]` of a train prices, by the path of their entry.  Raises ModelError."""
    return {entry.path: entry.grades for entry in tolerances_of(train) if entry.grades}


def _width_of(bodies: Sequence[Body], meshes: Sequence[Mesh]) -> Width:
    """Return the function that gives the width [m] of a grade at a path.

    Run-out of a gear: F_rT of its reference diameter and normal module. Profile error of a mesh: root of the sum of the
    squares of F_alphaT of both gears, whose errors add and know nothing of each other. Position of a planet: the
    standard tolerance of its distance from the axis of the stage, as the diameter of the zone.
    """

    def width(path: str, grade: StandardGrade, vector: bool) -> float:
        table, *segments = path.split(".")
        kind = next((name for name in segments if name in ("run_out", "position", "profile")), None)
        if table != "deviations" or (segments[-1] != kind and segments[-1] not in ("amplitude", "x", "y")):
            kind = None
        if grade.standard == "ISO 286-1":
            return _size(grade, bodies, _gear(bodies, segments) if kind == "position" else None)
        if kind == "run_out":
            return _flank(grade, run_out_width, [_gear(bodies, segments)])
        pair = f"stages.{'.'.join(segments[:3])}"
        mesh = next((mesh for mesh in meshes if mesh.pair == pair), None) if kind == "profile" else None
        mates = [] if mesh is None else [body for body in bodies if body.name in (mesh.a, mesh.b)]
        return _flank(grade, profile_width, mates)

    return width


def _size(grade: StandardGrade, bodies: Sequence[Body], gear: Body | None) -> float:
    """Return the width [m] of a grade of a size: the distance of a planet from the axis. Raises ModelError."""
    carried = gear is not None and gear.branch is not None
    radius = math.dist(gear.centre, stage_axis(gear.frame, bodies)) if gear is not None and carried else 0.0
    if radius == 0:
        allowed = "position of a planet, from its distance to the axis"
        raise ModelError("a grade of a size has no size here", allowed=allowed)
    try:
        return size_width(radius, grade.grade)
    except ValueError as error:
        allowed = f"IT{SIZE_GRADES.start} to IT{SIZE_GRADES.stop - 1}, of sizes up to 3150 mm"
        raise ModelError(str(error), allowed=allowed) from None


def _flank(grade: StandardGrade, formula: Callable[[float, float, int], float], bodies: Iterable[Body | None]) -> float:
    """Return the width [m] of a grade of teeth, of a pair that of both. Raises ModelError."""
    gears = [body.gear for body in bodies if body is not None and body.gear is not None]
    if not gears:
        allowed = "run_out of a gear, profile of a mesh"
        raise ModelError("a grade of teeth has no formula here", allowed=allowed)
    if grade.grade not in FLANK_GRADES:
        raise ModelError(f"no grade {grade.grade}", allowed="grades 1 to 11 of ISO 1328-1:2013")
    for gear in gears:
        if not in_flank_range(2 * gear.reference_radius, gear.module):
            size = f"d = {2e3 * gear.reference_radius:.5g} mm, m_n = {1e3 * gear.module:.5g} mm"
            allowed = "d of 5 to 15000 mm, m_n of 0.5 to 70 mm"
            raise ModelError(f"{size} is beyond ISO 1328-1:2013", allowed=allowed)
    return math.hypot(*(formula(2 * gear.reference_radius, gear.module, grade.grade) for gear in gears))


def _gear(bodies: Sequence[Body], segments: Sequence[str]) -> Body | None:
    """Return the first body of the member that a path of deviations names, None where it has no teeth."""
    member = ".".join(segments[:2])
    return next((body for body in bodies if body.member == member and body.gear is not None), None)


def correlations_of(train: Train) -> tuple[Correlations, ...]:
    """Return the groups of entries of `[tolerance]` whose own draws are correlated.  Raises ModelError."""
    table = _table(train.document).get("correlation", {})
    drawn = {entry.path for entry in tolerances_of(train)}
    entries = {entry.path: entry for entry in tolerances(train.document, _width_of(train.bodies, train.meshes))}
    found = []
    for group in read_correlations(table, entries, collect(dict(train.document))):
        at = [place for place, path in enumerate(group.paths) if path in drawn]  # the marginal of those that are drawn
        paths = tuple(group.paths[place] for place in at)
        found += [replace(group, paths=paths, matrix=group.matrix[np.ix_(at, at)])] if len(at) > 1 else []
    return tuple(found)


def check_tolerances(document: Document, bodies: Sequence[Body], meshes: Sequence[Mesh]) -> None:
    """Check what only the resolved train can tell of `[tolerance]`.

    Raises
    ------
    ModelError : a grade that has no size or formula at its path; a mesh or side that the train has not; a spread above
        a module; correlations that are not positive definite.
    """
    table = _table(document.data)
    if not table:
        return
    entries = tolerances(document, _width_of(bodies, meshes))
    for entry in entries:
        _check_place(entry.path, table[entry.path], bodies, meshes)
        for own in (entry.own, entry.common):
            if own is not None:
                _check_size(entry, own, f"tolerance.{entry.path}", bodies)
        for grade in entry.grades:
            _check_size(entry, grade.distribution, f"tolerance.cost.{entry.path}", bodies)
    if "correlation" in table:
        names = collect(document.data)
        read_correlations(table["correlation"], {entry.path: entry for entry in entries}, names)


def _table(document: Mapping[str, object]) -> Mapping[str, Any]:
    """Return `[tolerance]` of the tables of a document."""
    table = document.get("tolerance", {})
    return table if isinstance(table, Mapping) else {}


def _check_place(path: str, given: object, bodies: Sequence[Body], meshes: Sequence[Mesh]) -> None:
    """Raise ModelError for a mesh, or for a side of a mesh or of a deviated member, that the train has not."""
    table, *segments = path.split(".")
    if table in ("deviations", "stages") and segments[1] == "meshes":
        places = [(mesh.pair.removeprefix("stages."), mesh.side) for mesh in meshes]
        depth = 3
    elif table == "deviations":
        places = [(body.member, body.side) for body in bodies]
        depth = 2 if segments[0] in {body.frame for body in bodies} else 1
    else:
        return
    known = {place for place, _ in places} | {f"{place}.{side}" for place, side in places if side}
    sided = depth + (len(segments) > depth and segments[depth] in SIDES)
    if (place := ".".join(segments[:sided])) not in known:
        problem = f"no such path (the train has no {place})"
        raise ModelError(problem, path=f"tolerance.{path}", given=given, allowed=f"one of {', '.join(sorted(known))}")


def _check_size(entry: Tolerance, read: Distribution, where: str, bodies: Sequence[Body]) -> None:
    """Raise ModelError for a deviation in length whose usual size is beyond a module: no tolerance of a gear."""
    table, *segments = entry.path.split(".")
    if table != "deviations" or entry.unit != "m" or segments[-1] == "z":
        return
    pair = segments[2].split("-") if segments[1] == "meshes" else [segments[1]]
    module = min(module_of(f"{segments[0]}.{name}", bodies) for name in pair)
    if abs(read.mean) + read.std > module:
        problem, allowed = "wider than a module: no tolerance of a gear", f"at most a module, {1e3 * module:.4g} mm"
        raise ModelError(problem, path=where, given=read.text, allowed=allowed)


# back to a file -------------------------------------------------------------------------------------------------------

_GEAR = (
    *("teeth", "base_radius", "module", "pressure_angle", "helix_angle", "hand", "profile_shift", "herringbone"),
    *("split", "gap", "face_width", "tip_diameter", "root_diameter", "mass", "inertia", "tilt_inertia", "pin_radius"),
)
_MESH = ("pressure_angle", "stiffness", "phase", "variation", "slices")
_BODY = ("mass", "inertia", "tilt_inertia", "station")


def resolved_document(train: Train) -> dict[str, Any]:
    """Model file with every resolved value in it, as nested tables of plain values in SI.

    Resolving it again gives the same train; `document.writer.model_text` writes it as text.
    """
    data: dict[str, Any] = copy.deepcopy(dict(train.document))
    for value in train.values:
        if _is_key(value, train, data):
            table, path = data, value.path.split(".")
            for name in path[:-1]:
                table = table.setdefault(name, {})
            table[path[-1]] = _plain(value.value)
    _keep_laws(data)
    return data


def _is_key(value: Derived, train: Train, data: Mapping[str, Any]) -> bool:
    """Whether a value may stand in a file, beside what the file states already."""
    parts = value.path.split(".")
    if isinstance(value.value, float) and math.isnan(value.value):
        return False
    if parts[0] == "bodies" and len(parts) == 3:
        return parts[-1] in _BODY
    if parts[0] in ("bodies", "couplings"):
        return parts[-1] in DIRECTIONS
    if parts[0] != "stages" or len(parts) < 4:
        return False
    if parts[2] == "meshes":
        if parts[-2:] == ["stiffness", "load"]:  # of a table of force
            return True
        if parts[-1] != "centre_distance":
            return parts[-1] in _MESH
        # a distance that follows from no pin radius: of two planet gears, or of two gears on fixed axes
        kinds = {b.member.split(".")[-1]: b.kind for b in train.bodies if b.member.startswith(f"{parts[1]}.")}
        return len({kinds[name] == "planet" for name in parts[3].split("-")}) == 1
    if parts[-1] == "module":
        table = data["stages"][parts[1]].get(parts[2], {})
        return value.origin != "base radii" and "transverse_module" not in table
    return parts[-1] in DIRECTIONS or parts[-1] in _GEAR


def _plain(value: object) -> object:
    """A value as a file states it: infinity as a word, a list of one as its entry."""
    if isinstance(value, (list, tuple)):
        entries = [_plain(entry) for entry in value]
        return entries[0] if len(entries) == 1 else entries
    return "inf" if value == math.inf else value


def _keep_laws(data: Mapping[str, Any]) -> None:
    """Stiffnesses of meshes are written along the tooth normal, tables of force as they are given.

    Meshes of loaded contact stay so: their tangent alone would be another law.
    """
    for stage in data["stages"].values():
        for mesh in stage.get("meshes", {}).values():
            direction, tables = mesh.get("direction"), (mesh, mesh.get("left", {}), mesh.get("right", {}))
            for table in tables:
                stated = table.get("direction", direction)
                if stated is not None and (table is mesh or "stiffness" in table or "direction" in table):
                    tabulated = isinstance(table.get("stiffness", mesh.get("stiffness")), dict)
                    table["direction"] = stated if tabulated else "normal"
            for table in tables:
                if table.get("variation", mesh.get("variation")) == "contact" and "stiffness" in table:
                    table["stiffness"] = "contact"
            for table in tables:
                if table.get("variation") == "contact":
                    del table["variation"]


# reading --------------------------------------------------------------------------------------------------------------


@checked
def load(source: str | Path | Mapping[str, object], overrides: Mapping[str, object] | None = None) -> Train:
    """Read and resolve a train.

    Parameters
    ----------
    source : path of a model file, name of a ready drive, or the same as nested tables.
    overrides : values by path, ``{"stages.main.sun.mass": "750 kg"}``; None removes the key.

    Raises
    ------
    ModelError : whatever is wrong, with its path, what was given and what is allowed.
    """
    document = read(source, overrides)
    try:
        return resolve(document)
    except ModelError as error:
        allowed, path = (
            "; ".join(filter(None, (error.allowed, *document.hints))),
            path_at_case(document.data, error.path),
        )
        raise ModelError(error.problem, path=path, given=error.given, allowed=allowed) from None


def path_at_case(data: Mapping[str, object], path: str) -> str:
    """A path of the operation where a document states it: in the case that is computed, or as it is; others stay."""
    stands = path.startswith("operation.") and of_another_point(data, path)
    return f"cases.{data['case']}{path.removeprefix('operation')}" if stands else path


def resolve(document: Document) -> Train:
    """Resolve a document: geometry, meshes and phases, masses, links, kinematics, torques, deviations.

    Raises
    ------
    ModelError : what the file says cannot be built, does not turn or does not balance.
    """
    model = document.model
    overridden = frozenset(path for path, origin in document.origin.items() if origin == "set")
    log = ResolutionLog(assumed=model.assumed, overridden=overridden, warnings=list(document.warnings))
    plans = plan_stages(model, log)
    shapes = tuple(shape_stage(plan, log) for plan in plans)
    for shape in shapes:
        check_stage(shape, log)
    of_stages = [body for shape in shapes for body in bodies_of_stage(shape, model, log)]
    bodies = coaxial([*of_stages, *free_bodies(model, log)], model)
    by_name = {body.name: body for body in bodies}
    links = [link for shape in shapes for link in links_of_stage(shape, model, by_name, log)]
    links += [*links_of_bodies(model, by_name, log), *couplings(model, by_name, log)]
    shafts = bent_shafts(bodies, links, plans, model, log)
    kinematics = kinematics_of(model, plans, log)
    warn_of_spans(shafts.spans, [float(rate) for rate in (kinematics.mesh_frequency or {}).values()], log)
    if kinematics.torque is not None and (ties := kinematics.undetermined):
        text = (
            f"statics alone does not tell the torques of {', '.join(ties)}: the least ones are shown, static has those"
        )
        log.coded("torque-undetermined", f"{text} that follow from the stiffnesses")
    tilting = tilt_groups(shafts.bodies, shafts.links, misaligned_bodies(model, bodies))
    meshes = [mesh for shape in shapes for mesh in meshes_of_stage(shape, model, kinematics, tilting, log)]
    bent = with_reduced(shafts.bodies, shafts.links, meshes, model, kinematics, log)
    log_rings(bent, shafts.links, meshes, kinematics, log)
    check_sizes(document, bodies, meshes, log)
    check_tolerances(document, bodies, meshes)
    others = [path for path in _table(document.data) if path not in TOLERANCE_TABLES]
    if model.case and (left := [path for path in others if of_another_point(document.data, path)]):
        text = f"case {model.case} states its own: not drawn are {', '.join(left)}"
        log.coded("tolerance-of-another-case", text)
    planets = {plan.name: len(plan.angles) for plan in plans}  # one branch on fixed axes
    deviated = DeviationScope(
        bodies=bodies, meshes=meshes, links=links, kinematics=kinematics, planets=planets, log=log
    )
    resolve_deviations(model, deviated)
    ripples, prescribed = resolve_ripples(model, bodies, kinematics, log)
    displaced = {link for one in deviated.displacements for link in one.links}
    sensors = tuple(resolve_sensors(model, bent, shafts.links, displaced, log))
    gravity = model.operation.gravity or (0.0, 0.0, 0.0)
    if model.operation.gravity is not None:
        log.note(f"{model.operation_path('gravity')}.gravity", list(gravity), "m/s^2")
    return Train(
        title=model.title,
        frames=frames_of(plans),
        bodies=tuple(bent),
        meshes=tuple(meshes),
        links=(*shafts.links, *prescribed),
        kinematics=kinematics,
        planets=planets,
        torques=dict(body_torques(model, kinematics, bodies)),
        power_paths=power_flow(
            kinematics,
            planets={f"{plan.name}.{gear}" for plan in plans for gear in plan.gears if not plan.central(gear)},
            arms=planet_arms(meshes, bodies),
        ),
        displacements=tuple(deviated.displacements),
        mesh_errors=(*deviated.mesh_errors, *contact_errors(meshes, kinematics)),
        loads=(*moved_loads(external_loads(model, bodies), bent), *deviated.loads),
        sensors=sensors,
        spans=tuple(shafts.spans),
        ripples=tuple(ripples),
        gravity=gravity,
        damping=_damping(model, log),
        warnings=tuple(log.warnings),
        values=tuple(log.values.values()),
        assumed=dict(model.assumed),
        document=document.data,
        doi=model.doi,
        notes=model.notes,
    )


def _damping(model: ModelFile, log: ResolutionLog) -> Damping:
    """Damping stated of the whole train."""
    stated = model.damping.model_dump(exclude_none=True)
    for key, value in stated.items():
        log.note(f"damping.{key}", value, {"mass": "1/s", "stiffness": "s"}.get(key, ""))
    return Damping(**stated)
