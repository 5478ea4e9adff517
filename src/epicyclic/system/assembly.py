"""Assembly, Train -> System: matrices of all bodies and connections, and their reduction to the free coordinates.

Every mesh, bearing, pin and support becomes rows of gaps; rigid connections are eliminated; displaced features become
excitation lines of exact frequency.  Frames, rows, signs and phases are those of docs/conventions.md.

Inertia of bodies in a frame that turns has gyroscopic, centrifugal and Coriolis terms, body by body.  All matrices are
of the unreduced coordinates, six a body in its own axes, order x y z rx ry rz.  The terms are those of
docs/conventions.md, Inertia in a turning frame; for x, y and rz they agree with [lin1999].
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.geometry import HALF, Phase
from ..teeth.mesh_stiffness import series_in_time
from ..train.train import DIRECTIONS, Body, Link, Mesh, Train
from ..user_input import checked
from .excitation import FullModel, excitation_lines
from .signal_rows import error_rows, sensor_rows
from .structure import Structure, flank_laws, law_groups, law_warnings, own_centres, structure_of
from .system import (
    Array,
    Dofs,
    FarFlanks,
    LinkRows,
    MeshRows,
    PassingRows,
    Symmetry,
    System,
    commutes,
    eliminate,
    faces,
    reduced_operator,
    turn_operator,
)

# direction of a row -> that across it, and the sense in which a turn by a quarter leads there
_ACROSS = {0: (1, 1), 1: (0, -1), 3: (4, 1), 4: (3, -1)}


@checked
def assemble(train: Train) -> System:
    """Assemble a train at its operating point into matrices, gaps, laws and excitation lines.

    Undeclared directions are slaved (a central body to its frame, a carried body to its carrier), never dropped
    (docs/conventions.md, Directions).

    Parameters
    ----------
    train : as `load` returns it.

    Returns
    -------
    System with G, Kg and the lines at the train's operating speed (zero where no speed is given).

    Raises
    ------
    ModelError : frames of different speed joined laterally, an anisotropic support in a turning frame, a law on rows
        that cannot follow it, no free coordinate, displacements that rigid connections do not admit.
    """
    structure = structure_of(train)
    T, S, kept = eliminate(structure.rigid, structure.pivots)
    if not kept.size:
        raise ModelError("every direction of every body is rigid: nothing can move", path="stages")
    mass, missing = _masses(train, T)
    turning = _turning_dampers(structure, train.damping.stiffness or 0.0)
    model = _full_model(train, structure, T, S, mass, turning)
    M = (T.T * model.diagonal) @ T + T.T @ model.bent_mass @ T
    L = structure.link @ T
    K = (L.T * model.link_stiffness) @ L
    tones = tuple(sorted(set((train.kinematics.mesh_frequency or {}).values()) - {Fraction(0)}))
    meshes = _meshes(train, structure, T, None if missing else M, tones)
    torques = np.zeros(structure.size)
    torques[[6 * structure.index[body] + 5 for body in train.torques]] = list(train.torques.values())
    turns = None if train.kinematics.speed is None else train.kinematics.frame_speed or {}
    following = tuple(ripple for ripple in train.ripples if ripple.follows)
    unscaled = frozenset(ripple.path for ripple in train.ripples if not ripple.follows)
    return System(
        dofs=_dofs(train, structure, T, kept),
        M=M,
        C=(L.T * model.link_damping) @ L + model.mass_damping * M + T.T @ model.bent_damping @ T,
        G=T.T @ model.G @ T,
        K=K,
        Kg=T.T @ model.Kg @ T,
        Cskew=T.T @ (structure.link.T @ turning @ structure.link + model.bent_skew) @ T,
        meshes=meshes,
        links=_links(structure, L, model.link_damping, turning),
        force=torques @ T,
        tones=tones,
        lines=excitation_lines(train, structure, model),
        zeta=train.damping.modal,
        body_mass=mass,
        bent_mass=model.bent_mass if structure.elastic else np.zeros((0, 0)),
        symmetries=tuple(_symmetries(train, structure, T, M, K + (meshes.B * meshes.stiffness) @ meshes.B.T)),
        warnings=(*train.warnings, *law_warnings(train)),
        provenance=train_provenance(train),
        missing_inertia=missing,
        groups=tuple(law_groups(train, structure, L)),
        body_turns=structure.spin_turn if train.kinematics.speed is not None else (),
        euler=T.T @ model.euler @ T,
        spin_up=spin_up_load(mass[:, 0], mass[:, 5], structure.frame_speed, structure.spin, own_centres(train))
        @ T[: mass.size],
        stage_turns={} if turns is None else {s: Fraction(turns.get(s, 0)) / 60 for s in train.planets},
        far=_far_flanks(structure, T, meshes) if structure.far_of.size else None,
        unscaled=unscaled,
        scaled=excitation_lines(replace(train, ripples=following), structure, model) if unscaled else (),
        locked=dict(train.torques) if train.kinematics.locked else None,
        bearings=_named_bearings(train),
        errors=error_rows(train, structure, T),
        sensors=sensor_rows(train, structure, T),
        passing=_passing(structure, T),
    )


def _named_bearings(train: Train) -> dict[str, tuple[str, ...]]:
    """Path of every seat of several named bearings -> their names, in the order of the file."""
    named: dict[str, tuple[str, ...]] = {}
    for path in dict.fromkeys(link.path for link in train.links if link.kind in ("support", "bearing")):
        seat, _, name = path.rpartition(".")
        if name not in ("support", "bearing", "bolts"):
            named[seat] = (*named.get(seat, ()), name)
    return named


def train_provenance(train: Train) -> dict[str, str]:
    """Provenance attributes of a result: title and doi of the train, its whole model and its assumptions as JSON."""
    return {
        "title": train.title,
        "doi": train.doi,
        "model": _model_text(train),
        "assumed": json.dumps(dict(train.assumed)),
    }


@lru_cache(maxsize=4)
def _model_text(train: Train) -> str:
    """Model file of a train as JSON, kept because a study assembles one train many times."""
    return json.dumps(train.document, default=str)


# bodies ---------------------------------------------------------------------------------------------------------------


def _masses(train: Train, T: Array) -> tuple[Array, tuple[str, ...]]:
    """Inertia of every coordinate (nb, 6) [kg, kg m^2], unknown ones 0, and paths of those that T (N, n) needs."""
    values = np.array([(body.mass, body.inertia, body.tilt_inertia) for body in train.bodies])
    moving = np.abs(T[: 6 * len(train.bodies)]).max(axis=1).reshape(-1, 6) > 0
    needed = np.stack([moving[:, :3].any(axis=1), moving[:, 5], moving[:, 3] | moving[:, 4]], axis=1)
    absent = ~np.isfinite(values)
    missing = []
    for i, j in np.argwhere(absent & needed):
        member = train.bodies[i].member
        table = "stages" if "." in member else "bodies"
        missing.append(f"{table}.{member}.{('mass', 'inertia', 'tilt_inertia')[j]}")
    mass, inertia, tilt = np.where(absent, 0.0, values).T
    return mass_diagonal(mass, inertia, tilt), tuple(dict.fromkeys(missing))


def _full_model(train: Train, structure: Structure, T: Array, S: Array, mass: Array, turning: Array) -> FullModel:
    """Matrices of all bodies and links on the unreduced coordinates; mass : (nb, 6) [kg, kg m^2], turning : (p, p)."""
    motion = mass[:, 0], mass[:, 5], mass[:, 3], structure.frame_speed, structure.spin
    G, Kg, euler, bent, damping, skew = np.zeros((6, structure.size, structure.size))
    for matrix, term in ((G, gyroscopic_matrix), (Kg, centrifugal_stiffness), (euler, euler_matrix)):
        matrix[: mass.size, : mass.size] = term(*motion)
    for i, body in enumerate(train.bodies):
        omega = structure.frame_speed[i]
        if body.carried_by is None or omega == 0.0:
            continue
        carrier = structure.index[body.carried_by]
        carried_stiffness(
            Kg,
            body=i,
            carrier=carrier,
            angle=body.angle - train.bodies[carrier].angle,
            preload=mass[i, 0] * omega**2,
            radius=math.hypot(*body.centre),
        )
    for part in structure.elastic:
        at, one = np.ix_(part.all_columns, part.all_columns), part.elastic
        speeds = structure.frame_speed[part.body], structure.spin[part.body]
        bent[at] += one.mass
        G[at] += one.gyroscopic(*speeds)
        Kg[at] += one.centrifugal(*speeds)
        euler[at] += one.euler(*speeds)
        damping[at] += one.damping
        skew[at] += (speeds[1] - speeds[0]) * one.damping @ one.turn
    stiffness = structure.linear_stiffness
    dampers = np.array([row.damping for row in structure.links])
    return FullModel(
        T=T,
        S=S,
        mass=mass,
        bent_mass=bent,
        bent_damping=damping,
        bent_skew=skew,
        G=G,
        Kg=Kg,
        euler=euler,
        mass_damping=train.damping.mass or 0.0,
        link_stiffness=stiffness,
        link_damping=dampers + (train.damping.stiffness or 0.0) * stiffness,
        turning=turning,
    )


def _turning_dampers(structure: Structure, lag: float) -> Array:
    """Stiffness-like terms (p, p) [N/m] between link rows of dampers whose body turns in its frame.

    Dampers to the housing in a turning frame act on the absolute velocity: with c on x' and y' of one support
    K[x,y] = -c Omega, K[y,x] = +c Omega; likewise rx, ry (docs/conventions.md, Inertia in a turning frame).  Those of
    the material of a body that bends, `lag` [s] per stiffness, act on the velocity in the material, C q' + nu C D q.
    """
    turning = np.zeros((len(structure.links), len(structure.links)))
    # across a row stands the other one of its link, or else that of another bearing at its place
    own = {(row.link.name, row.direction): i for i, row in enumerate(structure.links)}
    near = {_direction_at(row.link, row.direction): i for i, row in enumerate(structure.links) if row.to_housing}
    for i, row in enumerate(structure.links):
        if row.to_housing and row.damping and row.direction in _ACROSS and structure.frame_speed[row.first]:
            direction, sense = _ACROSS[row.direction]
            across = own.get((row.link.name, direction), near.get(_direction_at(row.link, direction)))
            if across is None:
                raise ModelError(
                    "a damper to the housing in a turning frame needs a connection across it",
                    path=row.link.path,
                    given=f"{DIRECTIONS[row.direction]} alone",
                    allowed=f"{DIRECTIONS[direction]} too",
                )
            turning[i, across] = -sense * row.damping * structure.frame_speed[row.first]
    for part in structure.elastic if lag else ():
        rows = [i for i, row in enumerate(structure.links) if row.spring and row.first == part.body == row.second]
        L, nu = part.elastic.springs.rows, structure.spin[part.body] - structure.frame_speed[part.body]
        turned = np.linalg.lstsq(L.T, (L @ part.elastic.turn).T, rcond=None)[0].T
        turning[np.ix_(rows, rows)] = nu * lag * part.elastic.springs.stiffness[:, None] * turned
    return turning


def _direction_at(link: Link, direction: int) -> tuple[object, ...]:
    """What tells one direction of a body at one place from others."""
    return link.first, direction, link.centre, link.station, link.angle


def _dofs(train: Train, structure: Structure, T: Array, kept: NDArray[np.int64]) -> Dofs:
    """Names of the reduced coordinates, `kept` (n,) of the N, and their expansion T (N, n)."""
    places: list[tuple[Body, str]] = [(body, direction) for body in train.bodies for direction in DIRECTIONS]
    places += [(train.bodies[part.body], name) for part in structure.elastic for name in part.elastic.names]
    body, direction = [places[k][0] for k in kept], tuple(places[k][1] for k in kept)
    return Dofs(
        names=tuple(f"{b.name}/{d}" for b, d in zip(body, direction, strict=True)),
        body=tuple(b.name for b in body),
        direction=direction,
        radius=np.array([b.reference_radius if d == "rz" else 1.0 for b, d in zip(body, direction, strict=True)]),
        bodies=tuple(b.name for b in train.bodies),
        expand=T,
        elastic=tuple((part.body, part.elastic.names) for part in structure.elastic),
    )


# meshes ---------------------------------------------------------------------------------------------------------------


def _meshes(train: Train, structure: Structure, T: Array, M: Array | None, tones: tuple[Fraction, ...]) -> MeshRows:
    """Mesh rows on the reduced coordinates; T : (N, n), M : (n, n), None where an inertia is missing.

    A damping ratio has no damper then; what needs dampers needs the inertia too.
    """
    meshes = [row.mesh for row in structure.meshes]
    B = (structure.mesh @ T).T
    stiffness = np.array([mesh.stiffness for mesh in meshes])
    frequency = train.kinematics.mesh_frequency or {}
    tone = [tones.index(frequency[m.stage]) if frequency.get(m.stage) in tones else 0 for m in meshes]
    rows = MeshRows(
        name=tuple(m.name for m in meshes),
        pair=tuple(m.pair for m in meshes),
        stage=tuple(m.stage for m in meshes),
        branch=tuple(m.branch or 0 for m in meshes),
        side=tuple(m.side or "" for m in meshes),
        B=B,
        stiffness=stiffness,
        variation=_variations(meshes),
        tone=np.array(tone, np.int64),
        damping=np.array([m.damping for m in meshes]) + (train.damping.stiffness or 0.0) * stiffness,
        backlash=np.array([m.backlash for m in meshes]),
        cos_base_helix=np.cos([m.base_helix for m in meshes]),
        slice=tuple(row.number for row in structure.meshes),
        ends=tuple((m.a, m.b) for m in meshes),
        internal=tuple(m.internal for m in meshes),
        direction=np.array([m.direction for m in meshes]),
        laws=tuple(flank_laws(structure.meshes, np.array(tone, np.int64))),
    )
    if not train.damping.mesh or M is None:
        return rows
    return replace(rows, damping=rows.damping + _relative_damping(train.damping.mesh, rows, M))


def _far_flanks(structure: Structure, T: Array, meshes: MeshRows) -> FarFlanks:
    """Far flanks, those without mean load; T : (N, n).

    Mirrored about the tooth, the contact of gear a is at 1/2 + 2 c_a - sigma, c_a of `teeth.geometry`: the contact of
    the far flank moves in the opposite sense, with a lead less by sense (1/2 + 2 c_a).  Its table is that of the pair
    at the mirrored phase.  Derived here.
    """
    rows = []
    for i in structure.far_of:
        mesh = structure.meshes[i].mesh
        lead = Phase.of(mesh.lead) - mesh.sense * (Phase.of(HALF) + mesh.tooth_shift)
        rows.append(structure.meshes[i]._replace(mesh=replace(mesh, lead=lead.value, sense=-mesh.sense)))
    return FarFlanks(
        mesh=structure.far_of,
        B=(structure.far @ T).T,
        variation=_variations([row.mesh for row in rows], orders=meshes.variation.shape[1]),
        laws=tuple(flank_laws(rows, meshes.tone[structure.far_of], far=True)),
    )


def _relative_damping(ratio: float, meshes: MeshRows, M: Array) -> Array:
    """Dampers (m,) [N s/m] for a damping ratio zeta of every whole mesh, c = 2 zeta sqrt(k m_eff), shared by slices.

    m_eff is the effective mass along the row of the mesh, with slices along the mean of its rows.  M : (n, n).
    """
    whole = faces(meshes)
    rows = whole.total(meshes.B, axis=1) / whole.count
    inverse = np.einsum("nm,nm->m", rows, np.linalg.lstsq(M, rows, rcond=None)[0])
    damping = 2 * ratio * np.sqrt(whole.total(meshes.stiffness) / inverse) / whole.count
    return np.asarray(damping[whole.row])


def _variations(meshes: Sequence[Mesh], *, orders: int = 0) -> NDArray[np.complex128]:
    """Relative stiffness series of every mesh over its mesh time, (m, L) [1], with at least so many orders."""
    most = max((mesh.variation.size for mesh in meshes), default=0)
    result = np.zeros((len(meshes), max(most, orders)), complex)
    for row, mesh in zip(result, meshes, strict=True):
        if mesh.variation.size:
            row[: mesh.variation.size] = series_in_time(mesh.variation, lead=mesh.lead, sense=mesh.sense)
    return result


# links, loads, symmetry -----------------------------------------------------------------------------------------------


def _links(structure: Structure, L: Array, damping: Array, turning: Array) -> LinkRows:
    """Linear link rows; L : (p, n), damping : (p,) [N s/m] and turning : (p, p) [N/m] of all elastic rows."""
    linear = ~structure.lawful
    rows = [row for row in structure.links if not row.law]
    skew = turning[np.ix_(linear, linear)]
    turn = tuple(structure.frame_turn[row.first] if row.to_housing else Fraction(0) for row in rows)
    return LinkRows(
        name=tuple(row.name for row in rows),
        link=tuple(row.link.name for row in rows),
        B=L[linear].T,
        stiffness=np.array([row.stiffness for row in rows]),
        damping=damping[linear],
        skew=skew if skew.any() else np.zeros((0, 0)),
        turn=turn if any(turn) else (),
    )


def _passing(structure: Structure, T: Array) -> PassingRows | None:
    """What varies in the stiffness of links that pass a body; T : (N, n)."""
    rows = structure.passings
    if not rows:
        return None
    tones = list[Fraction]()
    for one in sorted({row.tone for row in rows}):  # multiples of a tone share its axis
        tones += [] if any((one / tone).denominator == 1 for tone in tones) else [one]
    follows = [next(tone for tone in tones if (row.tone / tone).denominator == 1) for row in rows]
    orders = [int(row.tone / tone) for row, tone in zip(rows, follows, strict=True)]
    wave = np.zeros((len(rows), max(len(row.wave) * order for row, order in zip(rows, orders, strict=True))), complex)
    for own, row, order in zip(wave, rows, orders, strict=True):
        own[order - 1 : order * len(row.wave) : order] = row.wave
    return PassingRows(
        link=tuple(row.link for row in rows),
        B=(structure.passing @ T).T,
        wave=wave,
        tones=tuple(tones),
        tone=np.array([tones.index(tone) for tone in follows], np.int64),
    )


def _symmetries(train: Train, structure: Structure, T: Array, M: Array, K: Array) -> Iterator[Symmetry]:
    """Cyclic symmetry of every stage, checked on M and K (n, n), K with the mean meshes; T : (N, n)."""
    for stage, branches in train.planets.items():
        members: dict[tuple[str, str | None, str], dict[int, int]] = {}
        central = []
        for i, body in enumerate(train.bodies):
            if body.branch is None:
                if body.frame == stage or "." not in body.member:
                    central.append(i)
            elif body.member.split(".")[0] == stage:
                place = body.name.removeprefix(body.shaft_of or body.name)
                members.setdefault((body.member, body.side, place), {})[body.branch] = i
        bodies = [(where[b], where[b % branches + 1]) for where in members.values() for b in where]
        angle = 2 * math.pi / branches
        columns = {part.body: part.columns for part in structure.elastic}
        moves = [(slice(6 * i, 6 * i + 6), slice(6 * j, 6 * j + 6)) for i, j in bodies]
        moves += [(columns[i], columns[j]) for i, j in bodies if i in columns and j in columns]
        full = turn_operator(len(T), moves=moves, turned=central, angle=angle)
        for part in structure.elastic:
            if part.body in central and (turned := part.elastic.turned(angle)) is not None:
                full[part.columns, part.columns] = turned
        R = reduced_operator(full, T) if branches > 1 else None
        holds = R is not None and commutes(R, M) and commutes(R, K)
        operator = np.eye(T.shape[1]) if R is None else R
        yield Symmetry(stage=stage, branches=branches, operator=operator, holds=holds)


X, Y, Z, RX, RY, RZ = range(6)


def mass_diagonal(mass: Array, inertia: Array, tilt: Array) -> Array:
    """Mass [kg] and moments of inertia [kg m^2] of every coordinate, (nb, 6), from mass, inertia and tilt (nb,)."""
    return np.stack([mass, mass, mass, tilt, tilt, inertia], axis=1)


def gyroscopic_matrix(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Coriolis and gyroscopic terms G of every body.

    G[x,y] = -2 m Omega, G[y,x] = +2 m Omega; G[rx,ry] = I_p w - 2 I_d Omega, G[ry,rx] = -(same).

    Parameters
    ----------
    mass [kg], inertia (about z), tilt (about a diameter) [kg m^2] : (nb,).
    frame_speed, spin : (nb,) Omega of the frame and absolute speed w of the body [rad/s].

    Returns
    -------
    (6 nb, 6 nb) [kg/s, kg m^2/s].
    """
    return _skew(across=2.0 * mass * frame_speed, tilting=inertia * spin - 2.0 * tilt * frame_speed)


def _skew(*, across: Array, tilting: Array) -> Array:
    """Skew terms of every body, (6 nb, 6 nb): [y,x] = -[x,y] = across (nb,), [rx,ry] = -[ry,rx] = tilting (nb,)."""
    matrix = np.zeros((6 * across.size, 6 * across.size))
    base = 6 * np.arange(across.size)
    matrix[base + X, base + Y], matrix[base + Y, base + X] = -across, across
    matrix[base + RX, base + RY], matrix[base + RY, base + RX] = tilting, -tilting
    return matrix


def centrifugal_stiffness(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Centrifugal and gyroscopic stiffness of every body on its own, (6 nb, 6 nb) [N/m, N m/rad].

    K[x,x] = K[y,y] = -m Omega^2;  K[rx,rx] = K[ry,ry] = I_p w Omega - I_d Omega^2.  Arguments (nb,) as of
    `gyroscopic_matrix`.
    """
    diagonal = np.zeros((mass.size, 6))
    diagonal[:, X] = diagonal[:, Y] = -mass * frame_speed**2
    diagonal[:, RX] = diagonal[:, RY] = (inertia * spin - tilt * frame_speed) * frame_speed
    return np.diag(diagonal.ravel())


def euler_matrix(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Stiffness-like Euler terms of every body while all speeds change, per relative acceleration s'.

    E[x,y] = -m Omega', E[y,x] = +m Omega'; E[rx,ry] = I_p w' - I_d Omega', E[ry,rx] = -(same), with the accelerations
    Omega' = s' Omega, w' = s' w at s' = 1.  These are half the Coriolis terms in x and y, but not in the tilts: the
    moment that accelerates a body has the axis of the frame and not that of the tilted body.  Arguments (nb,) as of
    `gyroscopic_matrix`.

    Returns
    -------
    (6 nb, 6 nb) [kg/s, kg m^2/s]: s' E q is a term of the left side.
    """
    return _skew(across=mass * frame_speed, tilting=inertia * spin - tilt * frame_speed)


def spin_up_load(mass: Array, inertia: Array, frame_speed: Array, spin: Array, centre: Array) -> Array:
    """Inertial load of the nominal motion on every coordinate per relative acceleration s', (6 nb,) [N s, N m s].

    -I_p w' on rz, and -m Omega' z x r_c on a body whose centre is off the axis: -m r_c Omega' on its y.  The other
    arguments (nb,) as of `gyroscopic_matrix`.

    Parameters
    ----------
    centre : (nb, 2) place of each body's centre in its own axes [m].
    """
    load = np.zeros((mass.size, 6))
    load[:, RZ] = -inertia * spin
    load[:, X], load[:, Y] = mass * frame_speed * centre[:, 1], -mass * frame_speed * centre[:, 0]
    return load.ravel()


def carried_stiffness(K: Array, *, body: int, carrier: int, angle: float, preload: float, radius: float) -> None:
    """Add to K the geometric stiffness of the centrifugal preload of a carried body, in place.

    V = m Omega^2 / 2 [2 u_c (y - y_c) - u_c^2 + 2 w_c (z - z_c) - w_c^2] with u_c = r_c rz_c, w_c = -r_c ry_c, the
    motion of the carrier in the axes of the branch; with it a rigid rotation of the set is neutral.  Derived here.

    Parameters
    ----------
    K : (6 nb, 6 nb).  body, carrier : indices of the bodies.
    angle : of the branch axes in the carrier's axes [rad].  preload : m Omega^2 [kg/s^2].  radius : pin radius r_c [m].
    """
    c, s = np.cos(angle), np.sin(angle)
    b, g = 6 * body, 6 * carrier
    index = np.array([b + Y, b + Z, g + X, g + Y, g + Z, g + RX, g + RY, g + RZ])
    y_rel = np.array([1.0, 0.0, s, -c, 0.0, 0.0, 0.0, 0.0])
    z_rel = np.array([0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    u_c = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, radius])
    w_c = -radius * np.array([0.0, 0.0, 0.0, 0.0, 0.0, -s, c, 0.0])
    hessian = np.outer(u_c, y_rel) + np.outer(y_rel, u_c) - np.outer(u_c, u_c)
    hessian += np.outer(w_c, z_rel) + np.outer(z_rel, w_c) - np.outer(w_c, w_c)
    K[np.ix_(index, index)] += preload * hessian
