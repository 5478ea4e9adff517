"""From a model file to the resolved Train: reading, and everything that follows from the document; and back.

Written back, every value stands in the file; resolving that gives the same train.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..arguments import checked
from ..document.document import Document, read
from ..document.schema import ModelFile
from ..errors import ModelError
from .bodies import DIRECTIONS
from .centres import shape_stage
from .deviation_sizes import check_sizes
from .deviations import deviations_of, misaligned_bodies
from .kinematics import tones
from .links import couplings, links_of_bodies, links_of_stage
from .mesh_laws import contact_errors
from .meshes import meshes_of_stage
from .power import planet_arms, power_flow
from .stage_bodies import bodies_of_stage, coaxial, frames_of, free_bodies, tilt_groups
from .stage_checks import body_torques, check_stage, external_loads, gearings_of, gravity_of, kinematics_of, ties_of
from .stages import plan_stages
from .tolerances import check_tolerances
from .train import Damping, Derived, ResolutionLog, Train

_GEAR = (
    *("teeth", "base_radius", "module", "pressure_angle", "helix_angle", "hand", "profile_shift", "herringbone"),
    *("split", "gap", "face_width", "tip_diameter", "root_diameter", "mass", "inertia", "tilt_inertia", "pin_radius"),
)
_MESH = ("pressure_angle", "stiffness", "phase", "variation", "slices")
_BODY = ("mass", "inertia", "tilt_inertia", "station")


def resolved_document(train: Train) -> dict[str, Any]:
    """Model file with every resolved value in it, as nested tables of plain values in SI.

    Resolving it again gives the same train; `document.tables.to_toml` writes it as text.
    """
    data: dict[str, Any] = copy.deepcopy(dict(train.document))
    for value in train.values:
        if _is_key(value, train, data):
            table, path = data, value.path.split(".")
            for name in path[:-1]:
                table = table.setdefault(name, {})
            table[path[-1]] = _plain(value.value)
    _set_directions(data)
    _keep_contact(data)
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


def _keep_contact(data: Mapping[str, Any]) -> None:
    """Meshes of loaded contact stay so: their tangent alone would be another law."""
    for stage in data["stages"].values():
        for mesh in stage.get("meshes", {}).values():
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                if table.get("variation", mesh.get("variation")) == "contact" and "stiffness" in table:
                    table["stiffness"] = "contact"
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                if table.get("variation") == "contact":
                    del table["variation"]


def _set_directions(data: Mapping[str, Any]) -> None:
    """Stiffnesses are written along the tooth normal, tables of force as they are given."""
    for stage in data["stages"].values():
        for mesh in stage.get("meshes", {}).values():
            direction = mesh.get("direction")
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                stated = table.get("direction", direction)
                if stated is not None and (table is mesh or "stiffness" in table or "direction" in table):
                    tabulated = isinstance(table.get("stiffness", mesh.get("stiffness")), dict)
                    table["direction"] = stated if tabulated else "normal"


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
        if not document.hints:
            raise
        allowed = "; ".join(filter(None, (error.allowed, *document.hints)))
        raise ModelError(error.problem, path=error.path, given=error.given, allowed=allowed) from None


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
    kinematics = kinematics_of(model, plans, log)
    named = tones(gearings_of(plans), kinematics.ratio)
    tilting = tilt_groups(bodies, links, misaligned_bodies(model, bodies))
    meshes = [mesh for shape in shapes for mesh in meshes_of_stage(shape, model, kinematics, named, tilting, log)]
    check_sizes(document, bodies, meshes, log)
    check_tolerances(document, bodies, meshes)
    planets = {plan.name: len(plan.angles) for plan in plans}  # one branch on fixed axes
    deviated = deviations_of(
        model, bodies=bodies, meshes=meshes, links=links, kinematics=kinematics, planets=planets, log=log
    )
    return Train(
        title=model.title,
        frames=frames_of(plans),
        bodies=tuple(bodies),
        meshes=tuple(meshes),
        links=tuple(links),
        kinematics=kinematics,
        planets=planets,
        torques=body_torques(model, kinematics, bodies),
        power_paths=power_flow(
            kinematics,
            gearings_of(plans),
            ties_of(model, plans),
            planets={f"{plan.name}.{gear}" for plan in plans for gear in plan.gears if not plan.central(gear)},
            arms=planet_arms(meshes, bodies),
        ),
        displacements=tuple(deviated.displacements),
        mesh_errors=(*deviated.mesh_errors, *contact_errors(meshes, kinematics)),
        loads=(*external_loads(model, bodies), *deviated.loads),
        gravity=gravity_of(model, log),
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
    stated = model.damping
    for key, unit in (("modal", ""), ("mass", "1/s"), ("stiffness", "s"), ("mesh", "")):
        value = getattr(stated, key)
        if value is not None:
            log.note(f"damping.{key}", value, unit)
    return Damping(modal=stated.modal, mass=stated.mass, stiffness=stated.stiffness, mesh=stated.mesh)
