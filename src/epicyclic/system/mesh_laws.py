"""Laws that the gaps of a train follow: links with play, rolling elements or friction, meshes of tabulated contact.

The laws themselves are those of `system.flank_laws` and `system.radial_laws`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.form import PLAIN
from ..train.train import DIRECTIONS, Link, Mesh, Train
from ..warning_codes import CodedText, coded
from .flank_laws import LawRows, TabulatedLaw
from .group_laws import LawGroup
from .radial_laws import Law, RadialLaw, RadialTable
from .structure import LinkRow, MeshRow
from .system import Array


def law_groups(train: Train, rows: Sequence[LinkRow], L: Array, *, lag: float) -> tuple[LawGroup, ...]:
    """One group for every link whose rows follow a law; one for each law where directions have tables of their own.

    Parameters
    ----------
    rows : (p,) elastic rows.  L : (p, n) their coefficients on the reduced coordinates.
    lag : damping per stiffness of the whole train [s].

    Raises
    ------
    ModelError : a friction coefficient in a link without a known torque.
    """
    together: dict[tuple[str, str], list[int]] = {}
    for i, row in enumerate(rows):
        if row.law:
            together.setdefault((row.link.name, _sense(row.link, row.direction)), []).append(i)
    laws = Counter(name for name, _ in together)
    return tuple(
        LawGroup(
            name=f"{name}/{sense}" if laws[name] > 1 else name,
            kind=rows[index[0]].link.kind,
            rows=tuple(f"{name}/{DIRECTIONS[rows[i].direction]}" for i in index),
            B=L[index].T,
            law=_law(rows[index[0]], train),
            damping=np.array([rows[i].damping for i in index]),
            lag=lag,
        )
        for (name, sense), index in together.items()
    )


def _sense(link: Link, direction: int) -> str:
    """Name of the rows that follow one law together with this one: x and y, rx and ry of one table are one law."""
    curves = dict(link.curves)
    if direction not in curves:
        return "z" if direction == 2 else "radial"
    for pair, name in (((0, 1), "radial"), ((3, 4), "tilt")):
        if direction in pair and curves.get(pair[0]) == curves.get(pair[1]):
            return name
    return DIRECTIONS[direction]


def _law(row: LinkRow, train: Train) -> RadialLaw:
    """Law of the rows of a link to which this one belongs."""
    link = row.link
    curve = dict(link.curves).get(row.direction)
    if curve is not None:
        return RadialTable(deflection=curve.deflection, force=curve.force, slope=curve.slope, stiffness=row.stiffness)
    friction = dict(link.friction)
    return Law(
        stiffness=row.stiffness,
        clearance=link.clearance,
        exponent=link.exponent,
        load=link.load,
        friction=_friction_force(link, train) if friction else 0.0,
        memory=friction.get("law") == "coulomb",
    )


def _friction_force(link: Link, train: Train) -> float:
    """Friction force F_m [N]: as given, else coefficient times torque per radius [dong2019]."""
    friction = {key: value for key, value in link.friction if not isinstance(value, str)}
    if "force" in friction:
        return friction["force"]
    torque = _torque_through(link, train)
    if not torque:
        raise ModelError(
            "no torque is known to pass through this link",
            path=f"{link.path}.friction.coefficient",
            given=friction["coefficient"],
            allowed="friction.force, or operation.torque",
        )
    return friction["coefficient"] * torque / friction["radius"]


def _torque_through(link: Link, train: Train) -> float:
    """Torque through a coupling, or through the member that a support holds, per body of the member [N m].

    Through a member: half the sum of the magnitudes of all torques on it, external, of couplings and of meshes.
    """
    ties = train.kinematics.tie_torque or {}
    if link.kind == "coupling":
        return abs(ties.get(link.name, 0.0))
    bodies = {body.name: body.member for body in train.bodies}
    member = bodies[link.second if link.kind == "bearing" and link.second is not None else link.first]
    torques = [(train.kinematics.torque or {}).get(member, 0.0)]
    for tie in train.links:
        if tie.kind == "coupling" and tie.second is not None:
            torque = ties.get(tie.name, 0.0)
            torques += [-torque] * (bodies[tie.first] == member) + [torque] * (bodies[tie.second] == member)
    through = (sum(abs(torque) for torque in torques) + abs(sum(torques))) / 2
    return through / sum(name == member for name in bodies.values())


def idle_friction(train: Train) -> list[CodedText]:
    """A warning for every table whose friction has no clearance to slide in."""
    paths = dict.fromkeys(link.path for link in train.links if link.friction and not link.clearance)
    return [
        coded("friction-without-clearance", f"{path}.friction has no effect: there is no clearance to slide in")
        for path in paths
    ]


# meshes ---------------------------------------------------------------------------------------------------------------


def flank_laws(rows: Sequence[MeshRow], tone: NDArray[np.int64], *, far: bool = False) -> tuple[LawRows, ...]:
    """Laws of the tabulated ones of some mesh rows (c,), those of one table together; a slice has its share of force.

    tone : (c,) of each row.  far : of far flanks, whose gap holds no error of the linear model; a table whose teeth
    have no other flank of that form is left to the linear law.
    """
    alike: dict[tuple[int, int], list[int]] = {}
    count = Counter(row.whole for row in rows)
    for i, row in enumerate(rows):
        if row.mesh.table is not None and not (far and _one_sided(row.mesh)):
            alike.setdefault((id(row.mesh.table), count[row.whole]), []).append(i)
    laws = []
    for (_, slices), numbers in alike.items():
        table = rows[numbers[0]].mesh.table
        assert table is not None
        index = np.array(numbers, np.int64)
        law = TabulatedLaw(
            tone=tone[index],
            lead=np.array([float(rows[i].mesh.lead) for i in numbers]),
            sense=np.array([float(rows[i].mesh.sense) for i in numbers]),
            force=table.force / slices,
            gap=table.approach if far else table.gap,
            slope=table.slope / slices,
            load=np.full(index.size, table.load / slices),
            last=table.last / slices,
        )
        laws.append(LawRows(law=law, rows=index))
    return tuple(laws)


def _one_sided(mesh: Mesh) -> bool:
    """Whether the far flank of a mesh cannot have the form of the loaded one: a slope, waves or pitches have a hand."""
    teeth = mesh.teeth
    return teeth is not None and any(
        flank.slope != 0 or bool(flank.waves) or bool(flank.pitch) for flank in (teeth.flank_a, teeth.flank_b)
    )


def flanks_ignored(train: Train) -> list[CodedText]:
    """One warning of all pairs with micro-geometry whose stiffness is linear and does not know it."""
    pairs = []
    for mesh in train.meshes:
        flanks = () if mesh.teeth is None else (mesh.teeth.flank_a, mesh.teeth.flank_b)
        # micro-geometry of the drawing: measured waves and pitches aside
        modified = any(replace(flank, waves=(), pitch=()) != PLAIN for flank in flanks)
        if mesh.table is None and modified:
            pairs.append(mesh.pair)
    if not pairs:
        return []
    keys = ", ".join(f"{pair}.stiffness" for pair in dict.fromkeys(pairs))
    text = f'relief, crown and slope of the flanks are ignored by {keys}; they count with "contact" there'
    return [coded("flank-without-effect", text)]


def one_sided_flanks(train: Train) -> list[CodedText]:
    """A warning for every pair whose far flank is linear because its teeth have no other flank of one form."""
    pairs = dict.fromkeys(
        mesh.pair
        for mesh in train.meshes
        if mesh.table is not None and math.isfinite(mesh.backlash) and _one_sided(mesh)
    )
    return [
        coded(
            "far-flank-linear",
            f"{pair}: slope, waves or pitch deviations are of the loaded flank; its far flank is a linear spring",
        )
        for pair in pairs
    ]
