"""Ports: coordinates at which torque enters and leaves a train, and torques that balance a load there.

The nominal motion is prescribed: a load may only strain the train.  The work of a load on a free (rigid) motion has to
be given back at the ports, in the ratio of the kinematics: the sum of torque times nominal turn is zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...questions.modes.basis import mean_modes
from ...statics.tangent import linear
from ...system.system import Array, System

__all__ = ["Ports", "balancing_torque", "driving_ports", "member_coordinates", "ports_of", "unit_torque"]

Index = NDArray[np.int64]

# Work that is rounding, per the sum of the sizes of its terms.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ports:
    """Coordinates with torque, and the rigid motions a load must not work on.

    system.  places : coordinates rz with a torque at the operating point.  rigid : (n, r) motions that strain nothing.
    """

    system: System
    places: Index
    rigid: Array


def ports_of(system: System) -> Ports:
    """The ports of a System: where the torques of the operating point act, (p,)."""
    squared, shapes = mean_modes(linear(system, asks_laws=True))
    turns = np.array([direction == "rz" for direction in system.dofs.direction])
    return Ports(system=system, places=np.flatnonzero(turns & (system.force != 0)), rigid=shapes[:, squared == 0])


def driving_ports(ports: Ports) -> Index:
    """The ports (p,) through which power comes in at the operating point; all where no speed is given."""
    system = ports.system
    if not system.body_turns:
        return ports.places
    turn = dict(zip(system.dofs.bodies, system.body_turns, strict=True))
    speed = np.array([float(turn.get(body, 0)) for body in system.dofs.body])
    power = (system.force * speed)[ports.places]
    places: Index = ports.places[power > 0]
    return places


def balancing_torque(ports: Ports, load: Array, places: Index) -> Array | None:
    """Torques (n,) [N m] at some ports that take the work of a load (n,) off every rigid motion.

    None where they cannot.
    """
    rigid = ports.rigid
    result = np.zeros_like(load)
    if not rigid.shape[1]:
        return result
    work = rigid.T @ load
    size = np.abs(rigid.T) @ np.abs(load)
    if places.size:
        result[places] = np.linalg.lstsq(rigid[places].T, -work, rcond=1e-12)[0]
    left = np.abs(work + rigid.T @ result)
    return None if np.any(left > _ROUNDING * size) else result


def member_coordinates(system: System, name: str) -> Index:
    """The rz coordinates (c,) of a member: ``sun``, ``main.sun``, ``main/sun``, or one half, ``main/sun/left``.

    Raises
    ------
    ModelError : no such member, several of that name, or it cannot turn.
    """
    wanted = name.replace(".", "/").split("/")
    found: dict[tuple[str, ...], list[int]] = {}
    bodies: set[str] = set()
    for place, (body, direction) in enumerate(zip(system.dofs.body, system.dofs.direction, strict=True)):
        parts = body.split("/")
        if direction == "rz" and not any(part.isdigit() for part in parts):
            bodies.add("/".join(parts[:2]))
            for depth in (0, 1):
                for end in range(depth + 1, len(parts) + 1):
                    if parts[depth:end] == wanted and end >= min(2, len(parts)):
                        found.setdefault(tuple(parts[:2]), []).append(place)
    if len(found) != 1:
        raise ModelError(
            "no member of that name can turn" if not found else "several members have that name",
            path="torque",
            given=name,
            allowed=", ".join(sorted(bodies)),
        )
    (places,) = found.values()
    return np.array(sorted(set(places)), dtype=np.int64)


def unit_torque(system: System, index: Index) -> Array:
    """One newton metre on a member, (n,) [N m].

    On its halves as the operating torque is, evenly where there is none.
    """
    load = np.zeros(len(system.force))
    total = system.force[index].sum()
    load[index] = system.force[index] / total if total else 1.0 / index.size
    return load
