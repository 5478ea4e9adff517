"""Operation of a train in numbers: ratio, speeds, torques."""

from __future__ import annotations

import math
from typing import Any

from ...train.train import Train

__all__ = ["operation_head"]

# Torques below this part of the largest are rounding of a member that carries none.
_NONE = 1e-9


def operation_head(train: Train, *, relative_speed: float = 1.0) -> dict[str, Any]:
    """``head["state"]`` without its time: ratio of the fastest to the slowest port, speeds [rpm] and torques [kN m].

    Parameters
    ----------
    relative_speed : speed per operating speed [1], which the speeds follow.
    """
    speed, torque = train.kinematics.speed or {}, train.kinematics.torque or {}
    several = len(train.planets) > 1
    carried = {body.member for body in train.bodies if body.branch is not None}

    def name(member: str) -> str:
        stage, _, word = member.rpartition(".")
        return f"{stage} {word}" if several and stage else word

    largest = max((abs(value) for value in torque.values()), default=0.0)
    loaded = {member: value for member, value in torque.items() if abs(value) > _NONE * largest}
    unit, scale = ("kN m", 1e-3) if largest >= 1e3 else ("N m", 1.0)
    ports = [abs(float(speed[member])) for member in loaded if speed.get(member)]
    return {
        "ratio": max(ports) / min(ports) if len(ports) > 1 and math.isfinite(max(ports)) else None,
        "speeds": [
            [name(member), relative_speed * float(value), "rpm"]
            for member, value in speed.items()
            if member not in carried and member in {body.member for body in train.bodies if body.kind != "body"}
        ],
        "torques": [[name(member), scale * value, unit] for member, value in loaded.items()],
        "relative_speed": relative_speed,
    }
