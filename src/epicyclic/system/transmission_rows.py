"""Transmission errors of a train as rows of its coordinates, by rotation, by approach, and from shaft to shaft.

Lag of what is driven is positive, as of loaded tooth contact (docs/theory/transmission-error.md):

rotation : r_ba theta_a +- r_bb theta_b of a mesh, its gears seen from the carrier, by rotation alone [m]; the dynamic
    transmission error of the literature [yue2014].
approach : B^T q / cos beta_b of a mesh, its moving centres counted, along the line of action in the transverse plane
    [m].
shaft : sum i_r theta_r - theta_p of a shaft p by the rotations of the shafts r that drive it, in its own sense [rad].

A rigid motion of the whole train makes none of them.  Derived here.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ..train.train import Train, bodies_named, driving_member
from .structure import Structure
from .system import Array, ErrorRows


def error_rows(train: Train, structure: Structure, T: Array) -> ErrorRows:
    """Rows of all transmission errors; T : (6 nb, n) expansion of the coordinates."""
    names = list(dict.fromkeys(row.whole for row in structure.meshes))
    rotation, approach = np.zeros((2, len(names), len(T)))
    for row, gap in zip(structure.meshes, structure.mesh, strict=True):
        mesh, whole = row.mesh, names.index(row.whole)
        along = gap / np.cos(mesh.base_helix) / max(1, len(mesh.slices))
        approach[whole] += along
        ends = [structure.index[mesh.a], structure.index[mesh.b]]
        turns = [6 * end + 5 for end in ends]
        rotation[whole, turns] += along[turns]
        for carrier in {train.bodies[end].carried_by for end in ends} - {None}:
            rotation[whole, 6 * structure.index[str(carrier)] + 5] -= along[turns].sum()
    shafts, turn = _shaft_rows(train)
    shaft = np.zeros((len(shafts), len(T)))
    for row_of, weights in zip(shaft, shafts.values(), strict=True):
        for name, weight in weights.items():
            turns = [6 * structure.index[body.name] + 5 for body in bodies_named(name, train.bodies)]
            row_of[turns] += weight / len(turns)
    return ErrorRows(
        mesh=tuple(names), shaft=tuple(shafts), turn=turn, B=(np.concatenate([rotation, approach, shaft]) @ T).T
    )


def _shaft_rows(train: Train) -> tuple[dict[str, dict[str, float]], dict[str, Fraction]]:
    """Weights of the rotations of shafts in every shaft-to-shaft error, and the speed of all shafts [rev/s].

    Of one freedom every shaft is seen from that which drives, of several from the freedoms.
    """
    kinematics = train.kinematics
    if kinematics.locked:
        return {}, {}
    named = [*kinematics.freedoms, *kinematics.stated, *kinematics.reacting]
    moving = [name for name in dict.fromkeys(named) if any(kinematics.ratio.get(name, {}).values())]
    shafts = [name for name in moving if name not in kinematics.held]
    speed = kinematics.speed or {}
    turn = {name: Fraction(speed.get(name, 0)) / 60 for name in shafts}
    motion, sources = kinematics.ratio, kinematics.freedoms
    driver = driving_member(train)
    if len(sources) == 1 and driver in shafts:
        of_driver = motion[str(driver)][sources[0]]
        motion = {name: {str(driver): motion[name][sources[0]] / of_driver} for name in shafts}
        sources = (str(driver),)
    weights: dict[str, dict[str, float]] = {}
    for name in filter(lambda shaft: shaft not in sources, shafts):
        forward = turn[name] or sum(motion[name].values())
        sense = -1 if forward < 0 else 1
        driven = {source: float(sense * motion[name][source]) for source in sources if motion[name][source]}
        weights[f"{name} by {', '.join(driven)}"] = {**driven, name: -float(sense)}
    return weights, turn
