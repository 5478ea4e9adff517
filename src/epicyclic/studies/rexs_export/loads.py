"""Speeds and external torques of a train on the shafts of a REXS file."""

from __future__ import annotations

from collections.abc import Mapping

from ...train.train import Train
from .draft import Attributes, Draft, in_unit
from .parts import ShaftPart

__all__ = ["add_loads", "gravity_of", "speed_of"]


def speed_of(train: Train, shaft: ShaftPart) -> Attributes:
    """Speed of a central shaft, with whether the model states it."""
    speeds, member = train.kinematics.speed, shaft.first.member
    if speeds is None or shaft.first.branch is not None or member not in speeds:
        return {}
    operation = train.document.get("operation")
    stated = operation.get("speed") if isinstance(operation, Mapping) else None
    defines = stated is not None and _stands(stated, member)
    return {"rotational_speed": (float(speeds[member]), "1 / min"), "defines_speed": (defines, "none")}


def _stands(table: object, member: str) -> bool:
    """Whether there is a value for a member in nested tables."""
    for part in member.split("."):
        if not isinstance(table, Mapping) or part not in table:
            return False
        table = table[part]
    return True


def add_loads(train: Train, draft: Draft, shafts: Mapping[str, tuple[ShaftPart, int]]) -> None:
    """Add the external torques of members that are not held: those stated define, those that balance follow."""
    kinematics = train.kinematics
    if kinematics.torque is None:
        return
    done: set[str] = set()
    for shaft, number in shafts.values():
        member = shaft.first.member
        if member in done or member in kinematics.held or shaft.first.branch is not None:
            continue
        done.add(member)
        if member not in kinematics.stated and member not in kinematics.reacting:
            continue
        attributes: Attributes = {
            "torque_around_u_axis": (float(kinematics.torque[member]), "N m"),
            "transmits_torque": (True, "none"),
            "defines_torque": (member in kinematics.stated, "none"),
            "u_coordinate_on_shaft": (in_unit(shaft.station - shaft.start, 1e-3), "mm"),
        }
        load = draft.add("external_load", f"{member} torque", attributes)
        draft.relate("assembly", assembly=number, part=load)


def gravity_of(train: Train) -> Attributes:
    """Gravity in the axes of the gear unit: u is z, v is -y, w is x."""
    x, y, z = train.gravity
    size = (x * x + y * y + z * z) ** 0.5
    if size == 0:
        return {"account_for_gravity": (False, "none")}
    return {
        "account_for_gravity": (True, "none"),
        "gravitational_acceleration": (size, "m / s^2"),
        "direction_vector_gravity_u": (z / size, "none"),
        "direction_vector_gravity_v": (-y / size + 0.0, "none"),
        "direction_vector_gravity_w": (x / size, "none"),
    }
