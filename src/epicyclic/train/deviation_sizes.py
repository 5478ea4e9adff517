"""Deviations of a train against the size of its teeth: what is larger than a module is no deviation of a gear."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..document.deviations import MemberDeviationsTable, MeshDeviationsTable
from ..document.document import Document
from ..document.tables import value_at
from ..errors import ModelError
from ..warning_codes import coded
from .bodies import Body, GearData, Mesh
from .train import ResolutionLog

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
