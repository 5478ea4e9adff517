"""The validated document -> the frozen Train: everything that follows from what the file says."""

from __future__ import annotations

from ..model.schema import ModelFile
from ..model.toml import Document
from ..train.bodies import Body
from ..train.connections import Link
from ..train.kinematics import tones
from ..train.power import power_flow
from ..train.train import Damping, Train
from .bodies import bodies_of_stage, frames_of, free_bodies
from .centres import StageShape, shape_stage
from .contact_law import contact_errors
from .deviations import deviations_of
from .fits import check_stage
from .ledger import Ledger
from .links import couplings, links_of_bodies, links_of_stage
from .meshes import meshes_of_stage
from .operation import body_torques, external_loads, gearings_of, gravity_of, kinematics_of, ties_of
from .places import coaxial
from .plan import plan_stages

__all__ = ["resolve"]


def resolve(document: Document) -> Train:
    """Resolve a document: geometry, meshes and phases, masses, links, kinematics, torques, deviations.

    Raises
    ------
    ModelError : what the file says cannot be built, does not turn or does not balance.
    """
    model = document.model
    overridden = frozenset(path for path, origin in document.origin.items() if origin == "set")
    ledger = Ledger(assumed=model.assumed, overridden=overridden)
    plans = plan_stages(model, ledger)
    shapes = tuple(shape_stage(plan, ledger) for plan in plans)
    for shape in shapes:
        check_stage(shape, ledger)
    bodies = _bodies(shapes, model, ledger)
    links = _links(shapes, model, bodies, ledger)
    kinematics = kinematics_of(model, plans, ledger)
    named = tones(gearings_of(plans), kinematics.ratio)
    meshes = [mesh for shape in shapes for mesh in meshes_of_stage(shape, model, kinematics, named, ledger)]
    planets = {plan.name: len(plan.angles) for plan in plans}  # one branch on fixed axes
    deviated = deviations_of(
        model, bodies=bodies, meshes=meshes, links=links, kinematics=kinematics, planets=planets, ledger=ledger
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
        power_paths=power_flow(kinematics, gearings_of(plans), ties_of(model, plans)),
        displacements=tuple(deviated.displacements),
        mesh_errors=(*deviated.mesh_errors, *contact_errors(meshes, kinematics)),
        loads=(*external_loads(model, bodies), *deviated.loads),
        gravity=gravity_of(model, ledger),
        damping=_damping(model, ledger),
        warnings=tuple(ledger.warnings),
        values=tuple(ledger.values.values()),
        assumed=dict(model.assumed),
        document=document.data,
        doi=model.doi,
        notes=model.notes,
    )


def _bodies(shapes: tuple[StageShape, ...], model: ModelFile, ledger: Ledger) -> list[Body]:
    bodies = [body for shape in shapes for body in bodies_of_stage(shape, model, ledger)]
    return coaxial([*bodies, *free_bodies(model, ledger)], model)


def _links(shapes: tuple[StageShape, ...], model: ModelFile, bodies: list[Body], ledger: Ledger) -> list[Link]:
    by_name = {body.name: body for body in bodies}
    links = [link for shape in shapes for link in links_of_stage(shape, model, by_name, ledger)]
    return [*links, *links_of_bodies(model, by_name, ledger), *couplings(model, by_name, ledger)]


def _damping(model: ModelFile, ledger: Ledger) -> Damping:
    said = model.damping
    for key, unit in (("modal", ""), ("mass", "1/s"), ("stiffness", "s"), ("mesh", "")):
        value = getattr(said, key)
        if value is not None:
            ledger.note(f"damping.{key}", value, unit)
    return Damping(modal=said.modal, mass=said.mass, stiffness=said.stiffness, mesh=said.mesh)
