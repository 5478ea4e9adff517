"""From a model file to the resolved Train: reading, and everything that follows from the document."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..arguments import checked
from ..document.document import Document, read
from ..document.schema import ModelFile
from ..errors import ModelError
from ..train.bodies import Body
from ..train.connections import Link
from ..train.kinematics import tones
from ..train.power import planet_arms, power_flow
from ..train.train import Damping, Train
from .bodies import bodies_of_stage, coaxial, frames_of, free_bodies
from .centres import StageShape, shape_stage
from .deviation_sizes import check_sizes
from .deviations import deviations_of, misaligned_bodies
from .links import couplings, links_of_bodies, links_of_stage
from .mesh_laws import contact_errors
from .meshes import meshes_of_stage
from .operation import body_torques, external_loads, gearings_of, gravity_of, kinematics_of, ties_of
from .plan import plan_stages
from .resolution_log import ResolutionLog
from .stage_checks import check_stage
from .tilt import tilt_groups
from .tolerances import check_tolerances

__all__ = ["load", "resolve"]


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
    bodies = _bodies(shapes, model, log)
    links = _links(shapes, model, bodies, log)
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


def _bodies(shapes: tuple[StageShape, ...], model: ModelFile, log: ResolutionLog) -> list[Body]:
    """Bodies of the stages and of the file, coupled ones on one axis."""
    bodies = [body for shape in shapes for body in bodies_of_stage(shape, model, log)]
    return coaxial([*bodies, *free_bodies(model, log)], model)


def _links(shapes: tuple[StageShape, ...], model: ModelFile, bodies: list[Body], log: ResolutionLog) -> list[Link]:
    """Links of stages, bodies and couplings."""
    by_name = {body.name: body for body in bodies}
    links = [link for shape in shapes for link in links_of_stage(shape, model, by_name, log)]
    return [*links, *links_of_bodies(model, by_name, log), *couplings(model, by_name, log)]


def _damping(model: ModelFile, log: ResolutionLog) -> Damping:
    """Damping stated of the whole train."""
    stated = model.damping
    for key, unit in (("modal", ""), ("mass", "1/s"), ("stiffness", "s"), ("mesh", "")):
        value = getattr(stated, key)
        if value is not None:
            log.note(f"damping.{key}", value, unit)
    return Damping(modal=stated.modal, mass=stated.mass, stiffness=stated.stiffness, mesh=stated.mesh)
