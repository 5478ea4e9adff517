"""Tolerances of a train: grades with the sizes that they apply to, and checks that only the resolved train allows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from ..document.deviations import Distribution, StandardGrade
from ..document.document import Document
from ..document.schema import SIDES, collect
from ..document.tolerances import (
    Correlations,
    Grade,
    Tolerance,
    Width,
    costs,
    read_correlations,
    tolerances,
    tolerances_and_costs,
)
from ..errors import ModelError
from ..teeth.grades import FLANK_GRADES, SIZE_GRADES, in_flank_range, profile_width, run_out_width, size_width
from .bodies import Body, Mesh
from .deviation_sizes import module_of
from .train import Train, stage_axis


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
