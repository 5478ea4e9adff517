"""Meshes of a train as cylindrical stages of a REXS file: places, stiffness per face width, K_gamma, backlash."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...analyses.sharing.outputs import known_mean_loads
from ...errors import ConvergenceError, ModelError
from ...system.assembly import assemble
from ...system.system import faces
from ...train.bodies import Body, Mesh
from ...train.train import Train
from .draft import Attributes, Draft, in_unit
from .gears import DEG
from .parts import Key

__all__ = ["add_meshes", "mesh_load_factors"]

_FACTOR = "mesh_load_factor_iso_6336_2019"
_STIFFNESS = "mean_mesh_stiffness_for_transverse_load_iso_6336_2019"


def mesh_load_factors(train: Train, draft: Draft) -> dict[str, float]:
    """K_gamma of each mesh: the largest of its pair and side, by the definition `mean-load` (docs/theory/sharing.md).

    The definition is that of ISO 6336: mean load of the heaviest branch over the nominal one, without vibration.  It is
    that of the deviations the model states; where it states none, or it has no value, nothing is returned and the
    reason is noted.
    """
    stated = bool(train.displacements) or any(error.cause != "contact" for error in train.mesh_errors)
    if not stated or not train.torques:
        why = "deviations" if not stated else "torque"
        draft.drop("K_gamma", f"the model states no {why}: {_FACTOR} is not written")
        return {}
    try:
        system = assemble(train)
        values, notes = known_mean_loads(system)
        names = [str(name) for name in faces(system.meshes).name]
    except (ModelError, ConvergenceError) as error:
        draft.drop("K_gamma", f"{_FACTOR} is not written: {error}")
        return {}
    for note in notes:
        draft.drop("K_gamma", f"{_FACTOR} is not written: {note}")
    found = dict(zip(names, (float(v) for v in values[0]), strict=True))
    groups: dict[tuple[str, str | None], list[str]] = {}
    for mesh in train.meshes:
        groups.setdefault((mesh.pair, mesh.side), []).append(mesh.name)
    factors: dict[str, float] = {}
    for members in groups.values():
        largest = float(np.max([found.get(name, math.nan) for name in members]))
        if math.isfinite(largest):
            factors |= dict.fromkeys(members, largest)
    return factors


def add_meshes(
    train: Train,
    draft: Draft,
    stages: Mapping[str, int],
    unit: int,
    gears: Mapping[Key, int],
    factors: Mapping[str, float],
) -> None:
    """Add each mesh as a cylindrical stage of its planetary stage, or of the unit, with the data of its gears in it.

    stages : stage -> id of the planetary stage.  unit : id of the gear unit.  gears : ids of the helices.
    factors : K_gamma by mesh.
    """
    bodies = {body.name: body for body in train.bodies}
    for mesh in train.meshes:
        a, b = bodies[mesh.a], bodies[mesh.b]
        ends = [_helix(gears, mesh.a, mesh.side), _helix(gears, mesh.b, mesh.side)]
        found = draft.add("cylindrical_stage", mesh.name, _attributes(draft, mesh, a, b, factors))
        draft.relate("assembly", assembly=stages.get(a.member.split(".")[0], unit), part=found)
        draft.relate("stage", stage=found, gear_1=ends[0], gear_2=ends[1])
        driving = _driver(train, mesh, a, b)
        for end, drives in zip(ends, (driving == "a", driving == "b"), strict=True):
            attributes: Attributes = {"is_driving_gear": (drives, "none")} if driving else {}
            data = draft.add("cylindrical_stage_gear_data", f"{mesh.name} gear {end}", attributes)
            draft.relate("stage_gear_data", stage=found, gear=end, stage_gear_data=data)


def _helix(gears: Mapping[Key, int], body: str, side: str | None) -> int:
    """Id of the helix of a body on a side."""
    return gears[(body, side)] if (body, side) in gears else gears[(body, None)]


def _attributes(draft: Draft, mesh: Mesh, a: Body, b: Body, factors: Mapping[str, float]) -> Attributes:
    """Attributes of a mesh."""
    distance = math.hypot(b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    planet = a if a.branch is not None else b
    polar = math.degrees(math.atan2(planet.centre[1], planet.centre[0]))
    # about -u, from the axis of the first gear to the second: out to the planet, or back from beyond it to the ring
    turned = ((180.0 if mesh.internal else 0.0) - polar) % 360
    attributes: Attributes = {
        "center_distance": (in_unit(distance, 1e-3), "mm"),
        "rotating_angle_around_neg_u_axis": (in_unit(turned, 1.0), "deg"),
        "working_transverse_pressure_angle": (in_unit(mesh.pressure_angle, DEG), "deg"),
    }
    if math.isfinite(mesh.contact_ratio):
        attributes = {**attributes, "transverse_contact_ratio": (mesh.contact_ratio, "none")}
    if math.isfinite(mesh.overlap_ratio):
        attributes = {**attributes, "overlap_ratio": (mesh.overlap_ratio, "none")}
    if math.isfinite(mesh.width):
        # along the normal -> in the transverse plane (docs/conventions.md), per width
        per_width = mesh.stiffness * math.cos(mesh.base_helix) ** 2 / mesh.width
        attributes = {
            **attributes,
            "common_face_width": (in_unit(mesh.width, 1e-3), "mm"),
            _STIFFNESS: (in_unit(per_width, 1e9), "N / (mm mum)"),
        }
        if mesh.table is not None:
            draft.drop(
                f"{mesh.pair}.stiffness", "a table over the load: its mean tangent at the operating load is written"
            )
    else:
        draft.drop(f"{mesh.pair}.stiffness", f"{_STIFFNESS} is per face width, which the model does not give")
    if math.isfinite(mesh.backlash):
        gap = in_unit(mesh.backlash, 1e-3)
        limits: Attributes = {"minimum_normal_backlash": (gap, "mm"), "maximum_normal_backlash": (gap, "mm")}
        attributes = {**attributes, **limits}
    if mesh.name in factors:
        attributes = {**attributes, _FACTOR: (factors[mesh.name], "none")}
    return attributes


def _driver(train: Train, mesh: Mesh, a: Body, b: Body) -> str:
    """Which gear drives, "a" or "b", by the power through the mesh seen from the carrier; "" where there is none."""
    kinematics = train.kinematics
    if kinematics.speed is None or kinematics.mesh_torque is None or kinematics.frame_speed is None:
        return ""
    torque = kinematics.mesh_torque.get(mesh.pair, 0.0)
    power = torque * float(kinematics.speed[b.member] - kinematics.frame_speed[b.frame])
    return "" if power == 0 or not math.isfinite(power) else "a" if power > 0 else "b"
