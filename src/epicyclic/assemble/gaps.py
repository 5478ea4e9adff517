"""Links with play, rolling elements or friction, as groups of rows with one law each (laws: `system.laws.groups`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..system.laws.groups import Law, LawGroup
from ..train.bodies import DIRECTIONS
from ..train.connections import Link
from ..train.train import Train
from .structure import LinkRow

__all__ = ["idle_friction", "law_groups"]

Array = NDArray[np.float64]


def law_groups(train: Train, rows: Sequence[LinkRow], L: Array, *, lag: float) -> tuple[LawGroup, ...]:
    """One group for every link whose rows follow a law.

    Parameters
    ----------
    rows : (p,) elastic rows.  L : (p, n) their coefficients on the reduced coordinates.
    lag : damping per stiffness of the whole train [s].

    Raises
    ------
    ModelError : a friction coefficient in a link without a known torque.
    """
    links = {link.name: link for link in train.links}
    places: dict[str, list[int]] = {}
    for i, row in enumerate(rows):
        if row.law:
            places.setdefault(row.link, []).append(i)
    return tuple(
        LawGroup(
            name=name,
            kind=links[name].kind,
            rows=tuple(f"{name}/{DIRECTIONS[rows[i].direction]}" for i in index),
            B=L[index].T,
            law=_law(links[name], rows[index[0]].stiffness, train),
            damping=np.array([rows[i].damping for i in index]),
            lag=lag,
        )
        for name, index in places.items()
    )


def idle_friction(train: Train) -> list[str]:
    """A warning for every table whose friction has no clearance to slide in."""
    paths = dict.fromkeys(link.path for link in train.links if link.friction and not link.clearance)
    return [f"{path}.friction has no effect: there is no clearance to slide in" for path in paths]


def _law(link: Link, stiffness: float, train: Train) -> Law:
    friction = dict(link.friction)
    return Law(
        stiffness=stiffness,
        clearance=link.clearance,
        exponent=link.exponent,
        load=link.load,
        friction=_friction_force(link, train) if friction else 0.0,
        memory=friction.get("law") == "coulomb",
    )


def _friction_force(link: Link, train: Train) -> float:
    """Friction force F_m [N]: as given, else coefficient times torque per radius [dong2019]."""
    given = {key: value for key, value in link.friction if not isinstance(value, str)}
    if "force" in given:
        return given["force"]
    torque = _torque_through(link, train)
    if not torque:
        raise ModelError(
            "no torque is known to pass through this link",
            path=f"{link.path}.friction.coefficient",
            given=given["coefficient"],
            allowed="friction.force, or operation.torque",
        )
    return given["coefficient"] * torque / given["radius"]


def _torque_through(link: Link, train: Train) -> float:
    """Torque through a coupling, or through the member that a support holds, per body of the member [N m].

    Through a member: half the sum of the magnitudes of all torques on it, external, of couplings and of meshes.
    """
    ties = train.kinematics.tie_torque or {}
    if link.kind == "coupling":
        return abs(ties.get(link.name, 0.0))
    bodies = {body.name: body.member for body in train.bodies}
    member = bodies[link.second if link.kind == "bearing" and link.second is not None else link.first]
    parts = [(train.kinematics.torque or {}).get(member, 0.0)]
    for tie in train.links:
        if tie.kind == "coupling" and tie.second is not None:
            torque = ties.get(tie.name, 0.0)
            parts += [-torque] * (bodies[tie.first] == member) + [torque] * (bodies[tie.second] == member)
    through = (sum(abs(part) for part in parts) + abs(sum(parts))) / 2
    return through / sum(name == member for name in bodies.values())
