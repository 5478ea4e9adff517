"""Rows of a train before its reduction, and the isotropy of those that turn.

Isotropy of supports: equal in all lateral directions, as required where they turn against the frame.

Gap rows of a train in unreduced coordinates, six a body in its own axes (docs/conventions.md, The mesh row).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..train.bodies import Link, Mesh
from ..train.train import Train

Array = NDArray[np.float64]

# Angles and stiffnesses of a drawing carry 1e-12 of rounding; a support anisotropic by less than this is isotropic.
_ROUND = 1e-9
# Singular values below this share of the largest are those of dependent rows.
_SAME = 1e-9


def check_isotropy(rows: Array, stiffness: Array, damping: Array, links: Sequence[Link]) -> None:
    """Check the isotropy of the rows between one body and a body that turns against its frame, all links together.

    Parameters
    ----------
    rows : (r, 6) of the coordinates of the body.  stiffness (inf = rigid) [N/m], damping [N s/m] : (r,).
    links : (r,) of each row.

    Raises
    ------
    ModelError : their sum is anisotropic; names the first link that is anisotropic by itself.
    """
    if isotropic(rows, stiffness, damping):
        return
    names = np.array([link.name for link in links])
    mine = [names == link.name for link in links]
    alone = [isotropic(rows[one], stiffness[one], damping[one]) for one in mine]
    link = links[alone.index(False) if False in alone else 0]
    turning = "the frame turns" if link.second is None else "it turns in the frame"
    raise ModelError(
        f"differs between x and y (or rx and ry) although {turning}: its stiffness would vary in time",
        path=link.path,
        given=list(link.stiffness),
        allowed="equal x and y, equal rx and ry, three or more equal bolts evenly spaced, or a frame that stands still",
    )


def isotropic(rows: Array, stiffness: Array, damping: Array) -> bool:
    """Whether springs, dampers and the space of rigid rows are invariant under any rotation about z.

    rows : (r, 6).  stiffness [N/m], damping [N s/m] : (r,).
    """
    rigid = np.isinf(stiffness)
    springs = (rows.T * np.where(rigid, 0.0, stiffness)) @ rows
    dampers = (rows.T * damping) @ rows
    if not rigid.any():
        return _round(springs) and _round(dampers)
    _, size, right = np.linalg.svd(rows[rigid], full_matrices=False)
    span = right[size > _SAME * size.max(initial=0.0)]
    return _round(springs) and _round(dampers) and _round(span.T @ span + np.eye(6))  # a projector has rounding of 1


def _round(matrix: Array) -> bool:
    """Whether a symmetric (6, 6) matrix commutes with rotations about z; entries on the scale of their diagonals."""
    turn = np.zeros((6, 6))
    for i in (0, 3):
        turn[i, i + 1], turn[i + 1, i] = -1.0, 1.0
    diagonal = np.sqrt(np.diag(matrix))
    for i in (0, 3):
        diagonal[i : i + 2] = diagonal[i : i + 2].max()
    return bool(np.all(np.abs(matrix @ turn - turn @ matrix) <= _ROUND * np.outer(diagonal, diagonal)))


LATERAL = (0, 1, 3, 4)


class LinkRow(NamedTuple):
    """One direction of one link.  first, second : body indices, -1 = the frame.  law : it follows a law, see `gaps`."""

    link: str
    path: str
    direction: int
    first: int
    second: int
    stiffness: float
    damping: float
    to_housing: bool
    law: bool


class MeshRow(NamedTuple):
    """One mesh row.  whole : name of its mesh.  number : of the slice, 0 = the whole mesh.  mesh : data of the row."""

    whole: str
    number: int
    mesh: Mesh


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Structure:
    """Rows of every mesh and link, (.., 6 nb), and speeds of the bodies.

    index : body name -> number.  frame_speed, spin : (nb,) of frame and body [rad/s].  frame_turn, spin_turn : (nb,)
    the same, exact [rev/s].
    mesh : (m, 6 nb), of the rows `meshes`, slices counted one by one; mesh_ends : (m, 2) body indices.
    far : (c, 6 nb), of the far flanks of the mesh rows far_of (c,), those with a finite backlash.
    link, links : (p, 6 nb) elastic rows and their data, those with a law among them.  rigid, rigids, pivots : rows
        (r, 6 nb) of rigid directions, their data, and the coordinate (r,) to eliminate.
    """

    index: dict[str, int]
    frame_speed: Array
    spin: Array
    frame_turn: tuple[Fraction, ...]
    spin_turn: tuple[Fraction, ...]
    meshes: tuple[MeshRow, ...]
    mesh: Array
    mesh_ends: NDArray[np.int64]
    far: Array
    far_of: NDArray[np.int64]
    link: Array
    links: tuple[LinkRow, ...]
    rigid: Array
    rigids: tuple[LinkRow, ...]
    pivots: NDArray[np.int64]


def own_centres(train: Train) -> Array:
    """Centre of every body in its own axes, (nb, 2) [m]."""
    own = [complex(*body.centre) * np.exp(-1j * body.angle) for body in train.bodies]
    return np.array([(place.real, place.imag) for place in own])


def structure_of(train: Train) -> Structure:
    """Rows of all meshes and links of the train.

    Raises
    ------
    ModelError : a link joins frames of different speed laterally, is not isotropic in a turning frame, or has a law
        (play, friction, exponent) on rows that cannot follow it.
    """
    index = {body.name: i for i, body in enumerate(train.bodies)}
    frames = {frame.name: i for i, frame in enumerate(train.frames)}
    frame_turns = tuple(_turn(train.kinematics.frame_speed, frame.name) for frame in train.frames)
    frame_turn = tuple(frame_turns[frames[b.frame]] if b.frame in frames else Fraction(0) for b in train.bodies)
    spins = {member: _turn(train.kinematics.speed, member) for member in {body.member for body in train.bodies}}
    spin_turn = tuple(spins[body.member] for body in train.bodies)
    rows: list[LinkRow] = []
    owners: list[Link] = []
    for link in train.links:
        _check_link(link, index, frame_turn, train)
        lawful = _law_directions(link)
        for direction, (k, c) in enumerate(zip(link.stiffness, link.damping, strict=True)):
            if k != 0.0 or c != 0.0:
                second = -1 if link.second is None else index[link.second]
                place = link.name, link.path, direction, index[link.first], second
                rows.append(LinkRow(*place, k, c, link.second is None, direction in lawful))
                owners.append(link)
    places = np.array([(*body.centre, body.station) for body in train.bodies])
    meshes = mesh_rows(train.meshes)
    ends = np.array([(index[row.mesh.a], index[row.mesh.b]) for row in meshes], np.int64).reshape(-1, 2)
    far_of = np.flatnonzero([math.isfinite(row.mesh.backlash) for row in meshes])
    flanks = [row.mesh for row in meshes] + [replace(meshes[i].mesh, flank=-meshes[i].mesh.flank) for i in far_of]
    parts = _link_ends(rows, owners, places)
    parts += _mesh_ends(flanks, np.concatenate([ends, ends[far_of]]), places, len(rows))
    matrix = _matrix(len(rows) + len(flanks), parts, np.array([body.angle for body in train.bodies]))
    matrix, mesh, far = np.split(matrix, [len(rows), len(rows) + len(meshes)])
    _check_frames(rows, owners, matrix, (frame_turn, spin_turn))
    rigid = np.array([math.isinf(row.stiffness) for row in rows], bool)
    rigids = tuple(row for row, hard in zip(rows, rigid, strict=True) if hard)
    return Structure(
        index=index,
        frame_speed=np.array([2 * math.pi * float(turn) for turn in frame_turn]),
        spin=np.array([2 * math.pi * float(turn) for turn in spin_turn]),
        frame_turn=frame_turn,
        spin_turn=spin_turn,
        meshes=meshes,
        mesh=mesh,
        mesh_ends=ends,
        far=far,
        far_of=far_of,
        link=matrix[~rigid],
        links=tuple(row for row, hard in zip(rows, rigid, strict=True) if not hard),
        rigid=matrix[rigid],
        rigids=rigids,
        pivots=np.array([6 * (r.first if r.second < 0 else r.second) + r.direction for r in rigids], np.int64),
    )


def _turn(speeds: Mapping[str, Fraction] | None, name: str) -> Fraction:
    """Speed of a member or frame [rev/s], 0 where no speeds are known."""
    return Fraction(0) if speeds is None else Fraction(speeds.get(name, 0)) / 60


def _law_directions(link: Link) -> tuple[int, ...]:
    """Directions that follow a law: those of tables; x and y, or z where it alone is stiff; none of a linear link.

    Friction without a clearance cannot slide, so that the link stays linear.

    Raises
    ------
    ModelError : no direction, a rigid one, or x and y of different stiffness.
    """
    tables = tuple(direction for direction, _ in link.curves)
    if not link.clearance and link.exponent == 1.0:
        return tables
    x, y, z = link.stiffness[:3]
    found = tuple(i for i, k in ((0, x), (1, y)) if k) or ((2,) if z else ())
    values = {link.stiffness[i] for i in found}
    if len(values) != 1 or math.isinf(*values):
        raise ModelError(
            "clearance, exponent and friction need one finite stiffness",
            path=link.path,
            given=f"x, y, z = {x:g}, {y:g}, {z:g} N/m",
            allowed="radial (x and y alike), x or y alone, or z alone",
        )
    return found + tables


def _check_link(link: Link, index: dict[str, int], frame_turn: tuple[Fraction, ...], train: Train) -> None:
    first = frame_turn[index[link.first]]
    lateral = [link.stiffness[i] for i in LATERAL]
    if link.second is not None and any(lateral) and frame_turn[index[link.second]] != first:
        raise ModelError(
            "joins bodies whose frames turn at different speeds: x, y, rx, ry would vary in time there",
            path=link.path,
            allowed="z and rz between such bodies",
        )


def _check_frames(
    rows: list[LinkRow], owners: list[Link], matrix: Array, turns: tuple[tuple[Fraction, ...], tuple[Fraction, ...]]
) -> None:
    """Check the isotropy of every link whose own axes turn against the frame of its body.

    matrix : (p, 6 nb) of the rows.  turns : speeds of the frames and of the bodies [rev/s].
    The axes of a support are those of the housing or of what it stands on, of a bearing those of what carries, of a
    coupling those of what it joins.
    """
    frame_turn, spin_turn = turns
    if not any(frame_turn) and not any(spin_turn):
        return
    turning: dict[tuple[int, int], list[int]] = {}
    for i, (row, link) in enumerate(zip(rows, owners, strict=True)):
        seat = row.first if link.kind == "bearing" else row.second
        if (Fraction(0) if row.second < 0 else spin_turn[seat]) != frame_turn[row.first]:
            turning.setdefault((row.first, row.second), []).append(i)
    for (body, _), mine in turning.items():
        check_isotropy(
            matrix[mine, 6 * body : 6 * body + 6],
            np.array([rows[i].stiffness for i in mine]),
            np.array([rows[i].damping for i in mine]),
            [owners[i] for i in mine],
        )


class _Ends(NamedTuple):
    """Ends of R rows at their bodies: row and body (R,), sign, unit vector and point (R, 3) [m] in frame axes, and
    whether the row is an angle (R,)."""

    row: NDArray[np.int64]
    body: NDArray[np.int64]
    sign: float
    normal: Array
    point: Array
    rotation: NDArray[np.bool_]


def _link_ends(rows: list[LinkRow], owners: list[Link], places: Array) -> list[_Ends]:
    """Ends of link rows; places : (nb, 3) of the origins of the bodies [m]."""
    if not rows:
        return []
    angle = np.array([link.angle for link in owners])
    direction = np.array([row.direction for row in rows])
    axis = direction % 3
    normal = np.zeros((len(rows), 3))
    c, s = np.cos(angle), np.sin(angle)
    normal[:, 0] = np.where(axis == 0, c, np.where(axis == 1, -s, 0.0))
    normal[:, 1] = np.where(axis == 0, s, np.where(axis == 1, c, 0.0))
    normal[:, 2] = axis == 2
    point = np.array([(*link.centre, link.station) for link in owners])
    first = np.array([row.first for row in rows])
    second = np.array([row.second for row in rows])
    has = np.flatnonzero(second >= 0)
    other, rotation = second[has], direction >= 3
    return [
        _Ends(np.arange(len(rows)), first, 1.0, normal, point - places[first], rotation),
        _Ends(has, other, -1.0, normal[has], point[has] - places[other], rotation[has]),
    ]


def _mesh_ends(meshes: Sequence[Mesh], ends: NDArray[np.int64], places: Array, start: int) -> list[_Ends]:
    """Ends of mesh rows from number `start` on (docs/conventions.md, The mesh row).

    ends : (m, 2) indices of the bodies a and b.  places : (nb, 3) of the origins of the bodies [m].
    """
    if not meshes:
        return []
    value = np.array(
        [
            (
                m.direction,
                m.pressure_angle,
                m.base_helix,
                m.hand,
                m.flank,
                m.station,
                m.radius_a,
                m.radius_b,
                m.internal,
                m.along,
            )
            for m in meshes
        ]
    )
    direction, alpha, helix, hand, flank, station, radius_a, radius_b, internal, along = value.T
    e = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    t = np.stack([-e[:, 1], e[:, 0]], axis=1)
    across = np.sin(alpha)[:, None] * e + (flank * np.cos(alpha))[:, None] * t
    normal = np.empty((len(meshes), 3))
    normal[:, :2] = np.cos(helix)[:, None] * across
    normal[:, 2] = -hand * flank * np.sin(helix)
    # Each body keeps its own lever r_b / cos(alpha) along e: the pitch point of a consistent geometry, and the best
    # meaning of given radii that fit no single centre distance.
    outward = np.where(internal > 0, radius_b, -radius_b)
    row, flat = start + np.arange(len(meshes)), np.zeros(len(meshes), bool)

    def end(which: int, lever: Array, sign: float) -> _Ends:
        body = ends[:, which]
        place = lever[:, None] * e + along[:, None] * across
        point = np.concatenate([place, (station - places[body, 2])[:, None]], axis=1)
        return _Ends(row, body, sign, normal, point, flat)

    return [end(0, radius_a, 1.0), end(1, outward, -1.0)]


def _matrix(count: int, ends: list[_Ends], axes: Array) -> Array:
    """Rows (count, 6 nb): sign * [n, r x n] of each end in the columns of its body; axes : (nb,) [rad]."""
    matrix = np.zeros((count, 6 * axes.size))
    if ends:
        row, body = np.concatenate([end.row for end in ends]), np.concatenate([end.body for end in ends])
        sign = np.repeat([end.sign for end in ends], [end.row.size for end in ends])
        rotation = np.concatenate([end.rotation for end in ends])
        normal, point = np.concatenate([end.normal for end in ends]), np.concatenate([end.point for end in ends])
        block = sign[:, None] * gap_rows(normal, point, axes[body], rotation=rotation)
        matrix[row[:, None], 6 * body[:, None] + np.arange(6)] = block
    return matrix


# mesh rows and columns of the bodies ----------------------------------------------------------------------------------


def mesh_rows(meshes: Sequence[Mesh]) -> tuple[MeshRow, ...]:
    """All rows of the meshes, in order; a slice has its share of stiffness and damping, and its own place and phase."""
    return tuple(row for mesh in meshes for row in _rows(mesh))


def _rows(mesh: Mesh) -> list[MeshRow]:
    if not mesh.slices:
        return [MeshRow(mesh.name, 0, mesh)]
    count = len(mesh.slices)
    return [
        MeshRow(
            mesh.name,
            number,
            replace(
                mesh,
                name=f"{mesh.name}/{number}",
                station=piece.station,
                along=piece.along,
                lead=piece.lead,
                variation=piece.variation,
                stiffness=mesh.stiffness / count,
                damping=mesh.damping / count,
            ),
        )
        for number, piece in enumerate(mesh.slices, start=1)
    ]


def gap_rows(normal: Array, point: Array, axes: Array, *, rotation: NDArray[np.bool_]) -> Array:
    """Six coefficients of R gap rows in their bodies (docs/conventions.md, The mesh row).

    A force along the unit vector n at the point r of a body does the work n . (u + theta x r), hence the row
    [n, r x n]; a moment along n has the row [0, n].

    Parameters
    ----------
    normal : (R, 3) unit vectors in frame axes.
    point : (R, 3) from the body's origin, in frame axes [m].
    axes : (R,) polar angle of the body's own x axis in frame axes [rad].
    rotation : (R,) True where the row is an angle (rx, ry, rz), not a displacement.

    Returns
    -------
    (R, 6) in the body's own axes, order x y z rx ry rz.
    """
    moment = np.empty_like(normal)
    moment[:, 0] = point[:, 1] * normal[:, 2] - point[:, 2] * normal[:, 1]
    moment[:, 1] = point[:, 2] * normal[:, 0] - point[:, 0] * normal[:, 2]
    moment[:, 2] = point[:, 0] * normal[:, 1] - point[:, 1] * normal[:, 0]
    turned = rotation[:, None]
    rows = np.hstack([np.where(turned, 0.0, normal), np.where(turned, normal, moment)])
    c, s = np.cos(axes), np.sin(axes)
    for i in (0, 3):
        x, y = rows[:, i].copy(), rows[:, i + 1].copy()
        rows[:, i], rows[:, i + 1] = c * x + s * y, c * y - s * x
    return rows
