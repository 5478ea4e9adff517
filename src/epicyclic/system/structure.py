"""Rows of a train before its reduction: gaps of meshes and links, six coordinates a body in its own axes; their laws.

A force along the unit vector n at the point r of a body does the work n . (u + theta x r), hence the row [n, r x n]; a
moment along n has the row [0, n] (docs/conventions.md, The mesh row).  Links that turn against the frame of their body
are isotropic, or their stiffness would vary in time.

Laws that gaps follow: links with play, rolling elements or friction, meshes of tabulated contact.  The laws themselves
are those of `system.flank_laws` and `system.link_laws`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.form import PLAIN
from ..train.elastic_bodies import passing_links
from ..train.train import DIRECTIONS, ContactSet, Link, Mesh, Train, bodies_named
from ..warning_codes import CodedText, coded
from .flank_laws import LawRows, TabulatedLaw
from .link_laws import ContactSetLaw, Law, LawGroup, RadialLaw, RadialTable
from .link_rows import ElasticPart, LinkRow, PassingRow, body_rows, link_matrix, passing_rows
from .system import Array

# Angles and stiffnesses of a drawing carry 1e-12 of rounding; a support anisotropic by less than this is isotropic.
_ROUND = 1e-9
# Singular values below this share of the largest are those of dependent rows.
_SAME = 1e-9


class MeshRow(NamedTuple):
    """One mesh row.  whole : name of its mesh.  number : of the slice, 0 = the whole mesh.  mesh : data of the row."""

    whole: str
    number: int
    mesh: Mesh


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Structure:
    """Rows of every mesh and link, (.., N), and speeds of the bodies.

    Of the N coordinates the first 6 nb are those of all bodies as rigid ones, in order; then come those by which bodies
    bend, `elastic`.

    index : body name -> number.  frame_speed, spin : (nb,) of frame and body [rad/s].  frame_turn, spin_turn : (nb,)
    the same, exact [rev/s].
    mesh : (m, N), of the rows `meshes`, slices counted one by one.
    far : (c, N), of the far flanks of the mesh rows far_of (c,), those with a finite backlash.
    link, links : (p, N) elastic rows and their data, those with a law among them, and the springs of bodies that bend.
    passing, passings : (q, N) rows whose stiffness varies as links pass a body, and their data.
    rigid, rigids, pivots : rows (r, N) of rigid directions, their data, and the coordinate (r,) to eliminate.
    """

    index: dict[str, int]
    frame_speed: Array
    spin: Array
    frame_turn: tuple[Fraction, ...]
    spin_turn: tuple[Fraction, ...]
    meshes: tuple[MeshRow, ...]
    mesh: Array
    far: Array
    far_of: NDArray[np.int64]
    link: Array
    links: tuple[LinkRow, ...]
    rigid: Array
    rigids: tuple[LinkRow, ...]
    pivots: NDArray[np.int64]
    passing: Array
    passings: tuple[PassingRow, ...]
    elastic: tuple[ElasticPart, ...] = ()

    @property
    def size(self) -> int:
        """N, the number of all coordinates."""
        return int(self.link.shape[1])

    @property
    def lawful(self) -> NDArray[np.bool_]:
        """Elastic rows that follow a law (p,)."""
        return np.array([row.law for row in self.links], dtype=bool)

    @property
    def linear_stiffness(self) -> Array:
        """Stiffness of elastic rows (p,) [N/m, N m/rad], 0 of those with a law."""
        return np.array([0.0 if row.law else row.stiffness for row in self.links])


@lru_cache(maxsize=2)  # for the matrices, and for the lines of a train
def structure_of(train: Train) -> Structure:
    """Rows of all meshes and links of the train.

    Raises
    ------
    ModelError : a link joins frames of different speed laterally, is not isotropic in a turning frame, or has a law
        (play, friction, exponent) on rows that cannot follow it.
    """
    index = {body.name: i for i, body in enumerate(train.bodies)}
    frames = {frame.name: _turn(train.kinematics.frame_speed, frame.name) for frame in train.frames}
    frame_turn = tuple(frames.get(body.frame, Fraction(0)) for body in train.bodies)
    spin_turn = tuple(_turn(train.kinematics.speed, body.member) for body in train.bodies)
    origins = np.array([(*body.centre, body.station) for body in train.bodies])
    axes = np.array([body.angle for body in train.bodies])

    elastic = _elastic_parts(train)
    groups = passing_links(train.links, train.bodies, train.kinematics)
    rows = list(_link_rows(train, index, frame_turn, {link.name for group in groups for link in group.links}))
    link = link_matrix(rows, origins, axes, elastic)
    _check_isotropy(rows, link, frame_turn, spin_turn)
    rigid = np.array([math.isinf(row.stiffness) for row in rows], bool)
    rigids = tuple(row for row in rows if math.isinf(row.stiffness))

    meshes = tuple(mesh_rows(train.meshes))
    ends = np.array([(index[row.mesh.a], index[row.mesh.b]) for row in meshes], np.int64).reshape(-1, 2)
    far_of = np.flatnonzero([math.isfinite(row.mesh.backlash) for row in meshes])
    flanks = [row.mesh for row in meshes] + [replace(meshes[i].mesh, flank=-meshes[i].mesh.flank) for i in far_of]
    mesh_matrix = _mesh_matrix(flanks, np.concatenate([ends, ends[far_of]]), origins, axes, elastic)
    mesh, far = np.split(mesh_matrix, [len(meshes)])
    springs, bent = _springs(train, elastic, link.shape[1])
    seats, seat, passings, passing = passing_rows(groups, index, origins, axes, elastic)
    return Structure(
        index=index,
        frame_speed=np.array([2 * math.pi * float(turn) for turn in frame_turn]),
        spin=np.array([2 * math.pi * float(turn) for turn in spin_turn]),
        frame_turn=frame_turn,
        spin_turn=spin_turn,
        meshes=meshes,
        mesh=mesh,
        far=far,
        far_of=far_of,
        link=np.concatenate([link[~rigid], seat, bent]),
        links=(*(row for row in rows if not math.isinf(row.stiffness)), *seats, *springs),
        rigid=link[rigid],
        rigids=rigids,
        pivots=np.array([6 * (r.first if r.second < 0 else r.second) + r.direction for r in rigids], np.int64),
        elastic=elastic,
        passing=passing,
        passings=passings,
    )


def _elastic_parts(train: Train) -> tuple[ElasticPart, ...]:
    """Bodies that bend, with their coordinates behind those of all bodies as rigid ones."""
    parts, first = [], 6 * len(train.bodies)
    for i, body in enumerate(train.bodies):
        if (bending := body.bending) is not None:
            parts.append(ElasticPart(i, slice(first, first + len(bending.names)), bending))
            first += len(bending.names)
    return tuple(parts)


def _springs(train: Train, parts: Sequence[ElasticPart], size: int) -> tuple[list[LinkRow], Array]:
    """Springs of bodies that bend, and of the foundations that hold them, with their rows (p, size)."""
    springs, rows = [], [np.zeros((0, size))]
    for part in parts:
        body = train.bodies[part.body]
        path = f"{'stages' if '.' in body.member else 'bodies'}.{body.member}.elastic"
        bent, held = part.elastic.springs, part.elastic.foundation
        for what, second, own in (("elastic", part.body, bent), ("foundation", -1, held)):
            name, still = f"{body.name}/{what}", (0.0,) * 6
            link = Link(name=name, path=path, kind="elastic", first=body.name, second=None, stiffness=still)
            named = zip(own.names, own.stiffness.tolist(), strict=True)
            springs += [LinkRow(link, 0, part.body, second, False, one) for one in named]
            rows.append(np.zeros((len(own.rows), size)))
            rows[-1][:, part.all_columns] = own.rows
    return springs, np.concatenate(rows)


def own_centres(train: Train) -> Array:
    """Centre of every body in its own axes, (nb, 2) [m]."""
    centres = [complex(*body.centre) * np.exp(-1j * body.angle) for body in train.bodies]
    return np.array([(centre.real, centre.imag) for centre in centres])


def _turn(speeds: Mapping[str, Fraction] | None, name: str) -> Fraction:
    """Speed of a member or frame [rev/s], 0 where no speeds are known."""
    return Fraction(0) if speeds is None else Fraction(speeds.get(name, 0)) / 60


# links ----------------------------------------------------------------------------------------------------------------


def _link_rows(
    train: Train, index: dict[str, int], frame_turn: tuple[Fraction, ...], passing: set[str]
) -> Iterator[LinkRow]:
    """Rows of all directions in which a link is stiff or damps, but of those that pass; frame_turn : (nb,) [rev/s]."""
    for link in train.links:
        if link.name in passing:
            continue
        first, second = index[link.first], -1 if link.second is None else index[link.second]
        lawful = _law_directions(link)
        lateral = any(link.stiffness[d] or d in lawful for d in (0, 1, 3, 4))
        if second >= 0 and lateral and frame_turn[second] != frame_turn[first]:
            raise ModelError(
                "joins bodies whose frames turn at different speeds: x, y, rx, ry would vary in time there",
                path=link.path,
                allowed="z and rz between such bodies; or one of them bends and is axisymmetric",
            )
        for direction, (k, c) in enumerate(zip(link.stiffness, link.damping, strict=True)):
            if k != 0.0 or c != 0.0 or direction in lawful:
                yield LinkRow(link, direction, first, second, direction in lawful, None, link.name)


def _law_directions(link: Link) -> tuple[int, ...]:
    """Directions that follow a law: those of tables; x and y, or z where it alone is stiff; none of a linear link.

    Of a contact set those in which a contact acts.  Friction without a clearance cannot slide,
    so that the link stays linear.

    Raises
    ------
    ModelError : no direction, a rigid one, or x and y of different stiffness; contacts beside another law, or not
        evenly spread.
    """
    if link.contacts is not None:
        return _contact_directions(link, link.contacts)
    tables = tuple(direction for direction, _ in link.curves)
    if not link.clearance and link.exponent == 1.0:
        return tables
    x, y, z = link.stiffness[:3]
    directions = tuple(i for i, k in ((0, x), (1, y)) if k) or ((2,) if z else ())
    values = {link.stiffness[i] for i in directions}
    if len(values) != 1 or math.isinf(*values):
        raise ModelError(
            "clearance, exponent and friction need one finite stiffness",
            path=link.path,
            given=f"x, y, z = {x:g}, {y:g}, {z:g} N/m",
            allowed="radial (x and y alike), x or y alone, or z alone",
        )
    return directions + tables


def _contact_directions(link: Link, contacts: ContactSet) -> tuple[int, ...]:
    """`_law_directions` of a contact set."""
    if link.clearance or link.exponent != 1.0 or any(direction < 5 for direction, _ in link.curves):
        raise ModelError("has contacts beside another law", path=link.path, allowed="contacts alone")
    if not _round(np.pad(_contact_law(contacts, range(5)).nominal, (0, 1))):
        raise ModelError(
            "its contacts are not evenly spread about the axis", path=link.path, given=f"{len(contacts.gap)} contacts"
        )
    return (*np.flatnonzero(np.any(contacts.normals, axis=0)).tolist(), *(direction for direction, _ in link.curves))


def _contact_law(contacts: ContactSet, directions: Sequence[int]) -> ContactSetLaw:
    """Law of contacts in some of the directions, where the others stand still."""
    return ContactSetLaw(
        normals=tuple(tuple(normal[d] for d in directions) for normal in contacts.normals),
        gap=contacts.gap,
        coefficient=contacts.coefficient,
        exponent=contacts.exponent,
        load=contacts.load,
    )


def _check_isotropy(
    rows: list[LinkRow], matrix: Array, frame_turn: tuple[Fraction, ...], spin_turn: tuple[Fraction, ...]
) -> None:
    """Check the rows between one body and another, of all links together, whose axes turn against the body's frame.

    matrix : (p, 6 nb) of the rows.  frame_turn, spin_turn : (nb,) speeds of frames and bodies [rev/s].
    The axes of a support are those of the housing or of what it stands on, of a bearing those of what carries, of a
    coupling those of what it joins.

    Raises
    ------
    ModelError : their sum is anisotropic; names the first link that is anisotropic by itself.
    """
    joints: dict[tuple[int, int], list[int]] = {}
    for i, row in enumerate(rows):
        seat = row.first if row.link.kind == "bearing" else row.second
        if (Fraction(0) if row.second < 0 else spin_turn[seat]) != frame_turn[row.first]:
            joints.setdefault((row.first, row.second), []).append(i)
    for (body, _), joint in joints.items():
        columns = matrix[:, 6 * body : 6 * body + 6]
        if _isotropic(columns[joint], [rows[i] for i in joint]):
            continue
        of_links: dict[str, list[int]] = {}
        for i in joint:
            of_links.setdefault(rows[i].link.name, []).append(i)
        uneven = [alone for alone in of_links.values() if not _isotropic(columns[alone], [rows[i] for i in alone])]
        link = rows[(uneven or [joint])[0][0]].link
        turning = "the frame turns" if link.second is None else "it turns in the frame"
        raise ModelError(
            f"differs between x and y (or rx and ry) although {turning}: its stiffness would vary in time",
            path=link.path,
            given=list(link.stiffness),
            allowed="equal x and y, equal rx and ry, three or more equal bolts evenly spaced, "
            "or a frame that stands still",
        )


def _isotropic(matrix: Array, rows: list[LinkRow]) -> bool:
    """Whether springs, dampers and the space of rigid rows (r, 6) are invariant under any rotation about z."""
    stiffness, damping = np.array([row.stiffness for row in rows]), np.array([row.damping for row in rows])
    rigid = np.isinf(stiffness)
    springs = (matrix.T * np.where(rigid, 0.0, stiffness)) @ matrix
    even = _round(springs) and (not damping.any() or _round((matrix.T * damping) @ matrix))
    if not rigid.any():
        return even
    _, size, right = np.linalg.svd(matrix[rigid], full_matrices=False)
    span = right[size > _SAME * size.max(initial=0.0)]
    return even and _round(span.T @ span + np.eye(6))  # a projector has rounding of 1


def _round(matrix: Array) -> bool:
    """Whether a symmetric (6, 6) matrix commutes with rotations about z; entries on the scale of their diagonals."""
    turn, diagonal = np.zeros((6, 6)), np.sqrt(np.diag(matrix))
    for i in (0, 3):
        turn[i, i + 1], turn[i + 1, i] = -1.0, 1.0
        diagonal[i : i + 2] = diagonal[i : i + 2].max()
    return bool(np.all(np.abs(matrix @ turn - turn @ matrix) <= _ROUND * np.outer(diagonal, diagonal)))


# meshes ---------------------------------------------------------------------------------------------------------------


def mesh_rows(meshes: Sequence[Mesh]) -> Iterator[MeshRow]:
    """All rows of the meshes, in order; a slice has its share of stiffness and damping, and its own place and phase."""
    for mesh in meshes:
        if not mesh.slices:
            yield MeshRow(mesh.name, 0, mesh)
        for number, piece in enumerate(mesh.slices, start=1):
            share = replace(
                mesh,
                name=f"{mesh.name}/{number}",
                station=piece.station,
                along=piece.along,
                lead=piece.lead,
                variation=piece.variation,
                stiffness=mesh.stiffness / len(mesh.slices),
                damping=mesh.damping / len(mesh.slices),
            )
            yield MeshRow(mesh.name, number, share)


def _mesh_matrix(
    meshes: Sequence[Mesh], ends: NDArray[np.int64], origins: Array, axes: Array, elastic: Sequence[ElasticPart]
) -> Array:
    """Rows (m, N) of meshes; ends : (m, 2) indices of the bodies a and b; origins, axes as of `_link_matrix`."""

    def values(name: str) -> Array:
        return np.array([getattr(mesh, name) for mesh in meshes], dtype=float)

    direction, alpha, helix = values("direction"), values("pressure_angle"), values("base_helix")
    hand, flank, along = values("hand"), values("flank"), values("along")
    e = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    t = np.stack([-e[:, 1], e[:, 0]], axis=1)
    across = np.sin(alpha)[:, None] * e + (flank * np.cos(alpha))[:, None] * t
    normal = np.empty((len(meshes), 3))
    normal[:, :2] = np.cos(helix)[:, None] * across
    normal[:, 2] = -hand * flank * np.sin(helix)
    # Each body keeps its own lever r_b / cos(alpha) along e: the pitch point of a consistent geometry, and the best
    # meaning of given radii that fit no single centre distance.
    radius_b = values("radius_b")
    levers = values("radius_a"), np.where(values("internal") > 0, radius_b, -radius_b)
    sides = []
    for body, lever in zip(ends.T, levers, strict=True):
        place = lever[:, None] * e + along[:, None] * across
        point = np.concatenate([place, (values("station") - origins[body, 2])[:, None]], axis=1)
        sides.append(body_rows(body, normal, point, axes, elastic, np.zeros(len(meshes), bool)))
    return sides[0] - sides[1]


def law_groups(train: Train, structure: Structure, L: Array) -> Iterator[LawGroup]:
    """One group for every link whose rows follow a law; one for each law where directions have tables of their own.

    L : (p, n) coefficients of the elastic rows on the reduced coordinates.

    Raises
    ------
    ModelError : a friction coefficient in a link without a known torque.
    """
    rows = structure.links
    together: dict[tuple[str, str], list[int]] = {}
    for i, row in enumerate(rows):
        if row.law:
            together.setdefault((row.link.name, _sense(row.link, row.direction)), []).append(i)
    count = Counter(name for name, _ in together)
    for (name, sense), index in together.items():
        row, link = rows[index[0]], rows[index[0]].link
        curve, friction = dict(link.curves).get(row.direction), dict(link.friction)
        law: RadialLaw | ContactSetLaw
        if sense == "contacts" and link.contacts is not None:
            law = _contact_law(link.contacts, [rows[i].direction for i in index])
        elif curve is not None:
            law = RadialTable(
                deflection=curve.deflection, force=curve.force, slope=curve.slope, stiffness=row.stiffness
            )
        else:
            law = Law(
                stiffness=row.stiffness,
                clearance=link.clearance,
                exponent=link.exponent,
                load=link.load,
                friction=_friction_force(link, train) if friction else 0.0,
                memory=friction.get("law") == "coulomb",
            )
        yield LawGroup(
            name=f"{name}/{sense}" if count[name] > 1 else name,
            kind=link.kind,
            rows=tuple(rows[i].name for i in index),
            B=L[index].T,
            law=law,
            damping=np.array([rows[i].damping for i in index]),
            lag=train.damping.stiffness or 0.0,
            turn=structure.frame_turn[row.first] if row.to_housing else Fraction(0),
        )


def _sense(link: Link, direction: int) -> str:
    """Name of the rows that follow one law together with this one: x and y, rx and ry of one table are one law."""
    curves = dict(link.curves)
    if link.contacts is not None and direction < 5:
        return "contacts"
    if direction not in curves:
        return "z" if direction == 2 else "radial"
    for pair, name in (((0, 1), "radial"), ((3, 4), "tilt")):
        if direction in pair and curves.get(pair[0]) == curves.get(pair[1]):
            return name
    return DIRECTIONS[direction]


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
    return through / len(bodies_named(member, train.bodies))


# meshes ---------------------------------------------------------------------------------------------------------------


def flank_laws(rows: Sequence[MeshRow], tone: NDArray[np.int64], *, far: bool = False) -> Iterator[LawRows]:
    """Laws of the tabulated ones of some mesh rows (c,), those of one table together; a slice has its share of force.

    tone : (c,) of each row.  far : of far flanks, whose gap holds no error of the linear model; a table whose teeth
    have no other flank of that form is left to the linear law.
    """
    alike: dict[tuple[int, int], list[int]] = {}
    count = Counter(row.whole for row in rows)
    for i, row in enumerate(rows):
        if row.mesh.table is not None and not (far and _one_sided(row.mesh)):
            alike.setdefault((id(row.mesh.table), count[row.whole]), []).append(i)
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
        yield LawRows(law=law, rows=index)


def _one_sided(mesh: Mesh) -> bool:
    """Whether the far flank of a mesh cannot have the form of the loaded one: a slope, waves or pitches have a hand."""
    teeth = mesh.teeth
    return teeth is not None and any(
        flank.slope != 0 or bool(flank.waves) or bool(flank.pitch) for flank in (teeth.flank_a, teeth.flank_b)
    )


def law_warnings(train: Train) -> list[CodedText]:
    """Warnings of what a law leaves out: friction that cannot slide, far flanks that are linear, micro-geometry that
    linear stiffness does not know."""
    paths = dict.fromkeys(link.path for link in train.links if link.friction and not link.clearance)
    warnings = [
        coded("friction-without-clearance", f"{path}.friction has no effect: there is no clearance to slide in")
        for path in paths
    ]
    pairs = dict.fromkeys(
        mesh.pair
        for mesh in train.meshes
        if mesh.table is not None and math.isfinite(mesh.backlash) and _one_sided(mesh)
    )
    warnings += [
        coded(
            "far-flank-linear",
            f"{pair}: slope, waves or pitch deviations are of the loaded flank; its far flank is a linear spring",
        )
        for pair in pairs
    ]
    if ignored := pairs_without_flanks(train):
        keys = ", ".join(f"{pair}.stiffness" for pair in ignored)
        text = f'relief, crown and slope of the flanks are ignored by {keys}; they count with "contact" there'
        warnings.append(coded("flank-without-effect", text))
    return warnings


def pairs_without_flanks(train: Train) -> list[str]:
    """Pairs of gears whose stiffness knows nothing of the relief, crown and slope that their flanks have."""
    ignored = []
    for mesh in train.meshes:
        flanks = () if mesh.teeth is None else (mesh.teeth.flank_a, mesh.teeth.flank_b)
        # micro-geometry of the drawing: measured waves and pitches aside
        if mesh.table is None and any(replace(flank, waves=(), pitch=()) != PLAIN for flank in flanks):
            ignored.append(mesh.pair)
    return list(dict.fromkeys(ignored))
