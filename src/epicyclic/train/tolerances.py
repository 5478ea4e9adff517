"""Tolerances of a train, and deviations held against the size of the teeth.

Deviations against the size of the teeth: what is larger than a module is no deviation of a gear.

Tolerances of a resolved train: grades with the sizes that they apply to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..document.correlation import Correlations, read_correlations
from ..document.deviations import MemberDeviationsTable, MeshDeviationsTable
from ..document.distributions import Distribution, StandardGrade
from ..document.document import Document
from ..document.schema import SIDES, collect
from ..document.tables import value_at
from ..document.tolerances import Grade, Tolerance, Width, costs, tolerances, tolerances_and_costs
from ..errors import ModelError
from ..teeth.geometry import FLANK_GRADES, SIZE_GRADES, in_flank_range, profile_width, run_out_width, size_width
from ..warning_codes import coded
from .bodies import Body, GearData, Mesh
from .train import ResolutionLog, Train, stage_axis

# A gear displaced by its module has left its mates (working depth: two modules).  A tenth of a module is about ten
# times the run-out that grade 8 of ISO 1328 allows: such gears exist, but it is more often a slip in the unit.
_LARGEST, _DOUBTFUL = 1.0, 0.1


def check_sizes(document: Document, bodies: Sequence[Body], meshes: Sequence[Mesh], log: ResolutionLog) -> None:
    """Compare every deviation in length, and every backlash, with the module of the gear.

    A carrier or body without teeth is compared with the smallest module of its stage, or of the train.

    Raises
    ------
    ModelError : a deviation or backlash above a module; above a tenth of it a deviation is a warning.
    """
    deviations = document.model.deviations
    for member, table in deviations.members.items():
        module = module_of(member, bodies)
        for path, size in _of_member(table, f"deviations.{member}", _reach(member, bodies)):
            _check(path, size, module, document.data, log)
    for name, mesh_table in deviations.meshes.items():
        stage, _, pair, *_ = name.split(".")
        module = min((module_of(f"{stage}.{gear}", bodies) for gear in pair.split("-")), default=math.nan)
        for path, size in _of_mesh(mesh_table, f"deviations.{name}"):
            _check(path, size, module, document.data, log)
    for mesh in meshes:
        _check_backlash(mesh, bodies, document.data)


def _of_member(table: MemberDeviationsTable, path: str, reach: float) -> Iterator[tuple[str, float]]:
    """Yield path and largest size [m] of what displaces teeth; a slide along the axis does not.

    reach : from the middle of the teeth to their end [m], which a tilt displaces.
    """
    for key, lever in (("run_out", 1.0), ("bearing_run_out", 1.0), ("position", 1.0), ("tilt", reach)):
        vector = getattr(table, key)
        for name in ("amplitude", "x", "y"):
            if vector is not None and (value := getattr(vector, name)) is not None:
                yield f"{path}.{key}.{name}", _largest(value) * lever
    if table.pitch is not None:
        yield f"{path}.pitch", max(max(teeth) - min(teeth) for teeth in table.pitch)


def _of_mesh(table: MeshDeviationsTable, path: str) -> Iterator[tuple[str, float]]:
    """Yield path and largest size [m] of the errors of a mesh."""
    if table.profile is not None:
        yield f"{path}.profile.amplitude", _largest(table.profile.amplitude)
    if table.gap is not None:
        yield f"{path}.gap", _largest(table.gap)
    for name, error in table.errors.items():
        yield f"{path}.errors.{name}.amplitude", _largest(error.amplitude)


def _largest(value: float | tuple[float, ...]) -> float:
    return max(map(abs, value)) if isinstance(value, tuple) else abs(value)


def module_of(member: str, bodies: Sequence[Body]) -> float:
    """Smallest module [m] of a member, of its stage where it has no teeth, of the train where it is in none."""
    stage, _, name = member.partition(".")
    pieces = [b for b in bodies if b.member == f"{stage}.{name.partition('.')[0]}"]
    for group in (pieces, [b for b in bodies if b.frame == stage], bodies):
        if modules := [b.gear.module for b in group if b.gear is not None]:
            return min(modules)
    return math.nan


def _reach(member: str, bodies: Sequence[Body]) -> float:
    """Half the width over all teeth of a member [m]; 0 where it has none or no width is given."""
    gears = [b.gear for b in bodies if b.gear is not None and (b.member == member or member.startswith(f"{b.member}."))]
    halves = [
        gear.face_width + gear.gap / 2 if gear.herringbone else gear.face_width / 2
        for gear in gears
        if gear.face_width is not None
    ]
    return max(halves, default=0.0)


def _check(path: str, size: float, module: float, data: Mapping[str, Any], log: ResolutionLog) -> None:
    """Raise ModelError, or warn, of one deviation [m] of a gear of a module [m]."""
    words = "moves the ends of the teeth by" if ".tilt." in path else "is"
    if size > _LARGEST * module:
        raise ModelError(
            f"{words} more than a module: no deviation of a gear",
            path=path,
            given=_written(data, path, size),
            allowed=f"at most a module, {_millimetres(module)}",
        )
    if size > _DOUBTFUL * module:
        more = f"{words} more than a tenth of a module ({_millimetres(module)}); is the unit right?"
        log.warn(coded("deviation-large", f"{path} = {_written(data, path, size)}: {more}"))


def check_contact_errors(
    mesh: Mesh, bodies: Sequence[Body], *, misalignment: float, errors: Mapping[str, float]
) -> None:
    """Compare errors of one tooth contact with the module, as deviations of the file.

    Parameters
    ----------
    misalignment : of the flanks [rad], which counts at the ends of the common face.  errors : by keyword [m].

    Raises
    ------
    ModelError : one above a module, by its keyword.
    """
    module = min(gear.module for gear in _gears_of(mesh, bodies))
    width = mesh.width if math.isfinite(mesh.width) else 0.0
    for path, size in {"misalignment": misalignment * width / 2, **errors}.items():
        if abs(size) > _LARGEST * module:
            problem = f"moves teeth by {_millimetres(abs(size))}, more than a module"
            raise ModelError(
                problem, path=path, allowed=f"at most a module, {_millimetres(module)}; is the unit right?"
            )


def _gears_of(mesh: Mesh, bodies: Sequence[Body]) -> list[GearData]:
    """Both gears of a mesh."""
    return [b.gear for b in bodies if b.name in (mesh.a, mesh.b) and b.gear is not None]


def _check_backlash(mesh: Mesh, bodies: Sequence[Body], data: Mapping[str, Any]) -> None:
    """Raise ModelError for a backlash in which a tooth is lost."""
    module = min(gear.module for gear in _gears_of(mesh, bodies))
    if math.isfinite(mesh.backlash) and mesh.backlash > _LARGEST * module:
        sided = f"{mesh.pair}.{mesh.side}.backlash"
        raise ModelError(
            "larger than a module: no backlash of teeth",
            path=f"{mesh.pair}.backlash" if value_at(data, sided.split(".")) is None else sided,
            given=_millimetres(mesh.backlash),
            allowed=f"at most a module, {_millimetres(module)}; leave it out where the far flank never touches",
        )


def _written(data: Mapping[str, Any], path: str, size: float) -> object:
    """Value as it stands in the document, else its size."""
    value = value_at(data, path.split("."))
    return _millimetres(size) if value is None or isinstance(value, float) else value


def _millimetres(length: float) -> str:
    return f"{length * 1e3:.4g} mm"


def tolerances_of(train: Train) -> tuple[Tolerance, ...]:
    """Return the entries of `[tolerance]` of a train, grades with their widths.  Raises ModelError."""
    return tolerances(train.document, _width_of(train.bodies, train.meshes))


def costs_of(train: Train) -> dict[str, tuple[Grade, ...]]:
    """Return the grades that `[tolerance.cost]` of a train prices, by the path of their entry.  Raises ModelError."""
    return costs(train.document, _width_of(train.bodies, train.meshes))


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
    entries = {entry.path: entry for entry in tolerances_of(train)}
    return read_correlations(table, entries, collect(dict(train.document)))


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
    width = _width_of(bodies, meshes)
    entries, priced = tolerances_and_costs(document, width)
    for entry in entries:
        _check_place(entry.path, table[entry.path], bodies, meshes)
        for own in (entry.own, entry.common):
            if own is not None:
                _check_size(entry, own, f"tolerance.{entry.path}", bodies)
        for grade in priced.get(entry.path, ()):
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
