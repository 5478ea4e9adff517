"""What every shaft of a train that turns feels of the whole: inertia reflected to it, torque that overcomes friction.

The kinetic energy of the rigid motion of the operation, E = sum (J w^2 + m r_c^2 w_c^2) / 2 with the speeds of Willis,
is that of the inertia 2 E / w^2 on a shaft that turns with w.  Derived here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...errors import ModelError
from ...system.system import Array
from ...train.train import Train, stage_axis


def reflected_inertia(train: Train, shafts: Sequence[str]) -> Array:
    """Inertia of the whole train on each shaft (s,) [kg m^2], nan of one that stands, and where the motion is open.

    The motion is that of the operation; without speeds that of a train with one freedom.
    """
    speed = _speeds(train)
    twice = math.fsum(_inertia_times_square(train, speed)) if speed else math.nan
    return np.array([twice / speed[name] ** 2 if speed.get(name) else math.nan for name in shafts])


def _speeds(train: Train) -> Mapping[str, float]:
    """Speed of every member, of any size; none where nothing turns, or several freedoms have no speeds."""
    kinematics = train.kinematics
    if kinematics.speed is not None and any(kinematics.speed.values()):
        return {name: float(value) for name, value in kinematics.speed.items()}
    if len(kinematics.freedoms) != 1:
        return {}
    return {name: float(row[kinematics.freedoms[0]]) for name, row in kinematics.ratio.items()}


def _inertia_times_square(train: Train, speed: Mapping[str, float]) -> Iterator[float]:
    """Twice the kinetic energy of every body, speeds in their unit."""
    member = {body.name: body.member for body in train.bodies}
    for body in train.bodies:
        if spin := speed[body.member]:
            yield body.inertia * spin**2
        if body.carried_by is not None and (orbit := speed[member[body.carried_by]]):
            radius = math.dist(body.centre, stage_axis(body.frame, train.bodies))
            yield body.mass * (radius * orbit) ** 2


def starting_torque(train: Train, shafts: Sequence[str], friction: float | None) -> Array:
    """Torque at each shaft (s,) that overcomes the friction of the teeth at the operation [N m]; nan of one at rest.

    It is the loss that `efficiency` finds per speed of the shaft.  friction : coefficient.

    Raises
    ------
    ModelError : no friction; a train of which `efficiency` has no loss.
    """
    if friction is None:
        raise ModelError("no friction of the teeth is given")
    from ..flanks import EfficiencyOptions
    from ..flanks.efficiency import efficiency

    loss = float(efficiency(train, EfficiencyOptions(friction=friction)).power_loss)
    speed = np.array([abs(float((train.kinematics.speed or {})[name])) * math.tau / 60 for name in shafts])
    return np.asarray(np.divide(loss, speed, where=speed > 0, out=np.full(len(shafts), math.nan)))
