"""Quasi-static equilibrium over the record, meshes carrying pressure only, as a labelled Dataset.

A record is taken in consecutive pieces.  Loaded and far flanks are solved together: the energy is convex, and a flank
that does not press adds nothing to it.  Laws with a memory follow their history.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError
from ..system.gaps import flanks, groups_past_the_end, linear_flanks, net_force, past_the_end
from ..system.link_laws import STATES, Laws
from ..system.system import Array, Faces, System, elastic_rows, faces
from ..warning_codes import CodedText, coded
from . import StaticOptions
from .equilibrium import Compliance, Equilibrium, compliance, compliance_of, equilibrium, require_balance, thrust_named
from .record import Record, RecordExcitation, excitation, idle_warnings, loaded_meshes, parallel_meshes, record_of
from .signals import Columns, record_errors, record_sensors

if TYPE_CHECKING:
    import xarray as xr

# Closing of a far flank by a unit motion that is rounding of the null space; 1e-12 is seen.
_STILL = 1e-9
# Instants that are solved at once.
_CHUNK = 2048
# Parts of the history that are stepped through side by side.
_PARTS = 128
# Sliders at the ends of two parts agree to this part of the slip start: the force then holds to the same part of the
# friction force.
_SLIDER_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldTrain:
    """A train seen from its rows.

    loaded : from the loaded flanks and the rows of groups.  whole : from all flanks that there are.
    laws : of its groups.  system : that it is of.
    touch : (n,) displacement of a locked train at first touch of its loaded flanks [m, rad]; zero where they do not
        touch together, and of a train that turns, which counts from there.
    """

    loaded: Compliance
    whole: Compliance
    laws: Laws
    system: System
    touch: Array

    def net_force(self, state: Equilibrium) -> Array:
        """Forces of the mesh rows (T, m) [N], negative on far flanks."""
        far = self.system.far_flanks.mesh[: state.far_force.shape[1]]
        return net_force(np.hstack([state.mesh_force, state.far_force]), far)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordPiece:
    """Consecutive instants of a record.

    state : equilibrium at t instants.  link_deflection : (t, p) of the linear links [m, rad].
    anchor : (t, R) sliders before each step [m].
    """

    state: Equilibrium
    link_deflection: Array
    anchor: Array | None


@lru_cache(maxsize=4)  # one analysis after the other asks of the same train
def held_train(system: System) -> HeldTrain:
    """The train seen from its flanks."""
    loaded, far, laws = compliance_of(system), system.far_flanks, system.laws
    if not far.mesh.size:
        return HeldTrain(loaded=loaded, whole=loaded, laws=laws, system=system, touch=np.zeros(len(system.force)))
    # a motion that the loaded flanks leave free may be stopped by far ones, which then count as closed
    stops = np.max(np.abs(far.B.T @ loaded.free), axis=1, initial=0.0) > _STILL
    k0 = np.where(stops, system.meshes.stiffness[far.mesh], 0.0)
    B = np.hstack([system.meshes.B, far.B, system.group_rows])
    stiffness = np.concatenate([system.meshes.stiffness, k0, laws.row_stiffness])
    whole = compliance(elastic_rows(system), B, stiffness)
    return HeldTrain(loaded=loaded, whole=whole, laws=laws, system=system, touch=_first_touch(system))


def _first_touch(system: System) -> Array:
    """Displacement (n,) [m, rad] that closes what loaded flanks are open by and strains no link; zero without one."""
    opening = system.flank_opening[: len(system.meshes.name)]
    if not opening.any():
        return np.zeros(len(system.force))
    flexible = [elastic_rows(system), system.group_rows * np.sqrt(system.laws.row_stiffness)]
    weight = np.sqrt(system.meshes.stiffness)
    rows = np.hstack([system.meshes.B * weight, *flexible])
    right = np.pad(opening * weight, (0, rows.shape[1] - weight.size))
    touch = np.asarray(np.linalg.lstsq(rows.T, right, rcond=None)[0], float)
    together = np.max(np.abs(touch @ rows - right)) <= _STILL * np.max(right)
    return touch if together else np.zeros_like(touch)


def balanced(held: HeldTrain, force: Array) -> None:
    """Check that no load (T, n) [N, N m] works on a motion that neither links nor flanks hold.

    Raises
    ------
    ModelError : one does.
    """
    require_balance(held.whole.free, force, held.system)


def settled(
    held: HeldTrain, here: RecordExcitation, *, anchor: Array | None = None, start: Array | None = None
) -> Equilibrium:
    """Equilibrium at T instants, as `equilibrium`, with the far flanks where backlash is finite.

    Parameters
    ----------
    anchor : (T, R) sliders before this step [m].  start : (T, M) approach to start from [m].

    Raises
    ------
    ModelError : the load drives bodies apart and nothing holds them.  ConvergenceError : no equilibrium.
    """
    m = here.stiffness.shape[1]
    gap = np.hstack([here.gap[:, :m], here.far_gap, here.gap[:, m:]])
    # from first touch on: half a backlash beside a small torque would be a loss of digits
    to_touch = held.whole.rows.T @ held.touch
    gap -= to_touch
    gap[np.abs(gap) < _STILL * np.max(np.abs(to_touch), initial=0.0)] = 0.0
    if start is not None:
        start = start - to_touch
    elif held.system.locked is not None and not held.system.force.any():
        start = np.tile(-to_touch, (len(gap), 1))  # no torque takes it out of mid-backlash
    if held.system.meshes.laws:
        contact = flanks(held.system).at(here.phases)
    else:
        contact = linear_flanks(np.hstack([here.stiffness, here.far_stiffness]))
    with thrust_named(held.system):
        state = equilibrium(
            held.whole,
            stiffness=here.stiffness,
            gap=gap,
            force=here.force,
            flanks=contact,
            laws=held.laws,
            anchor=anchor,
            start=start,
        )
    return replace(state, displacement=state.displacement + held.touch, approach=state.approach + to_touch)


def quasi_static(
    held: HeldTrain, record: Record, progress: Callable[[float], None] | None = None
) -> Iterator[RecordPiece]:
    """Equilibrium at every instant of the record, in order.

    Sliders of laws with a memory start in the middle, one record before the first instant; such a record is in a row.

    Raises
    ------
    ModelError : a load that nothing balances or holds.  ConvergenceError : no equilibrium was found.
    """
    links, total, instants = held.system.links, record.instants, record.index
    anchors, approach = _slider_history(held, record) if held.laws.memory.any() else (None, None)
    for first in range(0, total, _CHUNK):
        chunk = slice(first, first + _CHUNK)
        here = _balanced_excitation(held, record, instants[chunk])
        anchor = None if anchors is None else anchors[chunk]
        start = _near_states(held, here) if approach is None else approach[chunk]
        state = settled(held, here, anchor=anchor, start=start)
        deflection = state.displacement @ links.B - here.link_gap
        yield RecordPiece(state=state, link_deflection=deflection, anchor=anchor)
        if progress is not None:
            progress(min(chunk.stop, total) / total)


def _near_states(held: HeldTrain, here: RecordExcitation) -> Array | None:
    """Approach (T, M) [m] to start from, between the states at every `_APART`-th of the instants.

    The steps in which laws of links find their contacts are then taken at few.  None where there are no such laws.
    """
    count = len(here.force)
    if not held.system.groups or count < 2 * _APART:
        return None
    few = here.at(np.arange(0, count, _APART))
    known = settled(held, few, start=_near_states(held, few)).approach
    low, share = np.divmod(np.arange(count)[:, None] / _APART, 1.0)
    before = low[:, 0].astype(np.int64)
    return (1 - share) * known[before] + share * known[np.minimum(before + 1, len(known) - 1)]


def _balanced_excitation(held: HeldTrain, record: Record, index: NDArray[np.int64]) -> RecordExcitation:
    """Excitation at the instants `index` (t,), whose loads are checked to balance on free motions."""
    here = excitation(held.system, record.unit, index, record.samples)
    balanced(held, here.force)
    return here


def _slider_history(held: HeldTrain, record: Record) -> tuple[Array, Array]:
    """Sliders before every step (T, R) and approach (T, M) at every instant of the record [m], after one of warm-up.

    Warm-up and record are cut into parts that are stepped through side by side, each from a guess of its first slider.
    The end of a part is the start of the next; parts whose start changes are stepped through again.  When none changes,
    the whole equals sequential stepping.  A part forgets its start as soon as it slides, so few rounds suffice.

    Raises
    ------
    ConvergenceError : starts still change after as many rounds as there are parts.
    """
    total, laws = record.instants, held.laws
    here = _balanced_excitation(held, record, np.arange(-total, total, dtype=np.int64))
    parts = min(_PARTS, 2 * total)
    length = -(-2 * total // parts)
    anchors = np.zeros((2 * total, laws.rows.owner.size))
    approach = np.zeros((2 * total, len(held.whole.stiffness)))
    begin = np.zeros((parts, laws.rows.owner.size))
    todo = np.arange(parts)
    tolerance = _SLIDER_TOLERANCE * float(np.min(laws.slip_start[laws.memory]))
    for _ in range(parts + 1):
        ends = begin[todo]
        start: Array | None = None
        for step in range(length):
            inside = todo * length + step < len(anchors)
            index = (todo * length + step)[inside]
            if not index.size:
                break
            before = ends[inside]
            state = settled(held, here.at(index), anchor=before, start=None if start is None else start[: index.size])
            anchors[index], approach[index] = before, state.approach
            ends[inside] = laws.slide(state.group_stretch, before)
            start = state.approach
        following = todo + 1 < parts
        following_parts = todo[following] + 1
        moved = np.max(np.abs(ends[following] - begin[following_parts]), axis=1, initial=0.0) > tolerance
        begin[following_parts] = ends[following]
        todo = following_parts[moved]
        if not todo.size:
            return anchors[total:], approach[total:]
    raise ConvergenceError("the history of a sliding spline was not found")


# A mesh force below this part of the largest is an open mesh: of two that open together one may just touch, with a
# force that is rounding (1e-16 times mesh per support stiffness, 1e7).
OPEN_RATIO = 1e-7
# Force per mesh stiffness below which a force is rounding of displacements in micrometres, far below any load [m].
_ROUNDING = 1e-15
# Instants of a chunk from one that is solved from all meshes closed to the next; those between start from both.
_APART = 16
# A record of this many mesh cycles is drawn in full; longer ones are asked for with `cycles` or `turns`.
_CYCLES = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlankContact:
    """Contact of the flanks over T instants.

    force : (T, m) of every mesh row, on its far flank negative [N].  loaded : (T, m) whether the loaded flank of each
    row touches.  far : (T, m) the same of its far flank.  largest : (F,) force of every flank met, as of `flanks` [N].
    """

    force: Array
    loaded: NDArray[np.bool_]
    far: NDArray[np.bool_]
    largest: Array


def static(system: System, options: StaticOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Static state at every instant of a record, with meshes that open and all errors, shaft orders included.

    Loads at rest count (torques, gravity, forces, link errors times stiffness); inertia does not.  Where backlash is
    finite, teeth that are driven apart meet their far flank; ``mesh_force`` is negative there, and ``far_share`` is the
    share of time of it.  Displacements leave out motions without stiffness (the turning of the whole train).  The
    twist of a neck or shaft is the ``link_deflection`` of its rz row [rad], first body less second: of a neck, left
    less right.  Time runs at the operating speed; without speeds it is counted in mesh cycles.
    Links with a law (play, rolling elements, spline) follow it; attributes ``laws`` and ``history`` say which.  Meshes
    with a table follow it on both flanks.

    A locked train has ``torque``, ``angle`` and ``play`` of every body that can turn: displacements then count from
    mid-backlash, and its mesh cycles are the places at which it may be locked.

    The record is the common period of all lines, at most 64 mesh cycles of the first mesh, where none is given; of a
    body alone the common period in its turns, at most 2048 instants; 32 instants per mesh cycle or turn.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, or a load that nothing balances or holds.
    ConvergenceError : the equilibrium was not found.
    """
    samples, of = options.samples or 32, options.of
    most = _CYCLES * (samples if of is None else 32)
    record = record_of(system, cycles=options.cycles, turns=options.turns, of=of, samples=samples, most=most)
    train = held_train(system)
    pieces = list(quasi_static(train, record, progress))
    contact = flank_contact(system, [(piece.state.mesh_force, piece.state.far_force) for piece in pieces])
    warnings = [
        *system.warnings,
        *free_position_warnings(system, train.loaded.free),
        *zero_warnings(system),
        *contact_warnings(system, contact),
    ]
    return _dataset(train, record, pieces, contact, warnings)


def rounding_of(system: System) -> float:
    """A mesh force [N] that is rounding of displacements, as all are without any load."""
    return _ROUNDING * float(np.max(system.meshes.stiffness, initial=0.0))


def flank_contact(system: System, forces: Sequence[tuple[Array, Array]]) -> FlankContact:
    """Which flanks touch over the record.

    Parameters
    ----------
    forces : of consecutive pieces of t instants, on the loaded flanks (t, m) and on the far ones (t, c) [N].
    """
    on_loaded, behind = (np.concatenate(part) for part in zip(*forces, strict=True))
    largest = OPEN_RATIO * max(np.max(on_loaded, initial=0.0), np.max(behind, initial=0.0))
    least = max(largest, rounding_of(system))  # without any load none presses
    far = np.zeros(on_loaded.shape, bool)
    far[:, system.far_flanks.mesh] = behind > least
    return FlankContact(
        force=net_force(np.hstack([on_loaded, behind]), system.far_flanks.mesh[: behind.shape[1]]),
        loaded=on_loaded > least,
        far=far,
        largest=np.concatenate([on_loaded.max(axis=0, initial=0.0), behind.max(axis=0, initial=0.0)]),
    )


def contact_warnings(system: System, contact: FlankContact) -> Iterator[CodedText]:
    """Warnings of rows without any contact at some instant, of those on their far flank, and of the ends of tables.

    Meshes without load beside loaded ones are told as such, and not of those that open.
    """
    names, face = np.array(system.meshes.name, dtype=object), faces(system.meshes)
    net, groups, rounding = face.total(contact.force, axis=1), parallel_meshes(system.meshes), rounding_of(system)
    mean, most = net.mean(axis=0), np.abs(net).max(axis=0)
    loaded = loaded_meshes(mean, groups, most=most, rounding=rounding)
    loaded |= loaded_meshes(-mean, groups, most=most, rounding=rounding)  # on the far flanks
    if loaded.any():
        yield from idle_warnings(face.name, loaded, "contact that holds a body")
    apart = ~np.all(contact.loaded | contact.far, axis=0) & (loaded[face.row] | ~loaded.any())
    if apart.any():
        open_ = ", ".join(names[apart])
        yield coded("contact-lost", f"meshes open: {open_}; bodies held by them alone have no unique position")
    behind = contact.far.any(axis=0)
    if behind.any():
        text = f"meshes on their far flank, where their force is negative: {', '.join(names[behind])}"
        yield coded("far-flank-loaded", text)
    yield from past_the_end(system, flanks(system), contact.largest)


def zero_warnings(system: System) -> list[CodedText]:
    """A warning where backlash is finite: the other sense of the torque has another zero, that far away.

    The angles of a locked train count from mid-backlash: there, of meshes without it.
    """
    meshes = system.meshes
    if system.locked is not None:
        pairs = zip(meshes.pair, meshes.backlash, strict=True)
        endless = dict.fromkeys(pair.removeprefix("stages.") for pair, gap in pairs if np.isinf(gap))
        text = (
            f"no backlash is given in {', '.join(endless)}: no play, and angles from first touch of the loaded flanks"
        )
        return [coded("no-backlash", text)] if endless else []
    play = {meshes.pair[i]: 1e6 * float(meshes.backlash[i]) for i in system.far_flanks.mesh.tolist()}
    if not play:
        return []
    listed = ", ".join(f"{pair.removeprefix('stages.')} {size:.4g} µm" for pair, size in play.items())
    text = "displacements count from first touch of the loaded flanks; a reversed torque starts at the far ones, behind"
    return [coded("zero-at-loaded-flank", f"{text} the backlash: {listed}")]


# Elastic approach of the flanks at which the play of a locked train is taken, per backlash, and the least of it [m].
_TOUCH, _LEAST_TOUCH = 1e-4, 1e-10


def locked_columns(held: HeldTrain, displacement: Array) -> Columns:
    """Torque [N m], angle (body, time) and play (body) [rad] of the bodies of a locked train; nothing of another.

    Angles count from the middle of the play; where backlash is not known, there is no play, and they count from first
    touch.  Bodies that nothing lets turn are left out.

    Parameters
    ----------
    displacement : (T, n) [m, rad].
    """
    system = held.system
    if system.locked is None:
        return {}
    turn = system.dofs.rigid[5::6]
    moving = np.flatnonzero(np.any(turn != 0, axis=1))
    names, turn = [system.dofs.bodies[i] for i in moving], turn[moving]
    angle = turn @ displacement.T
    play: Columns = {}
    if np.isfinite(system.meshes.backlash).all():
        ends = ends_of_travel(held, turn)
        angle -= ends.mean(axis=1, keepdims=True)
        play["play"] = ("body", ends[:, 0] - ends[:, 1])
    return {
        "body": ("body", np.array(names, dtype=object)),
        "torque": ("body", np.array([system.locked.get(name, 0.0) for name in names])),
        "angle": (("body", "time"), angle),
        **play,
    }


def ends_of_travel(held: HeldTrain, turn: Array) -> Array:
    """Angles (b, 2) [rad] at which flanks stop bodies that a torque turns forwards and back, as it goes to zero.

    Each body by itself, without other loads, displaced seats as they are: a(0) = 2 a(T) - a(2 T) of a small torque T,
    exact for linear laws.

    Parameters
    ----------
    turn : (b, n) angle of each body per displacement [rad].
    """
    meshes = held.system.meshes
    arm = np.abs(meshes.B[[direction == "rz" for direction in held.system.dofs.direction]]).max()
    torque = max(_TOUCH * float(meshes.backlash.max()), _LEAST_TOUCH) * float(meshes.stiffness.mean()) * arm
    factors = np.array([1.0, 2.0, -1.0, -2.0])
    here = excitation(held.system, Fraction(1), np.zeros(4 * len(turn), np.int64), 1)
    probe = (torque * factors[:, None] * turn[:, None]).reshape(-1, turn.shape[1])
    links = held.system.links
    state = settled(held, here._replace(force=probe + (links.stiffness * here.link_gap) @ links.B.T))
    angle = np.einsum("bn,bfn->bf", turn, state.displacement.reshape(len(turn), 4, -1))
    return np.asarray(2 * angle[:, ::2] - angle[:, 1::2])


def law_attributes(system: System, record: Record) -> dict[str, str]:
    """Attributes of a result about its laws.

    Kind and numbers of each, but the contacts of a set, the derived slip start, and how the history begins.
    """
    if not system.groups:
        return {}
    laws = {
        group.name: {
            "kind": group.law.kind,
            **{each.name: getattr(group.law, each.name) for each in fields(group.law) if each.repr},
            "slip_start": group.law.slip_start,
        }
        for group in system.groups
    }
    history = f"sliders start in the middle; warm-up over {record.count} {record.name} before the record"
    return {"laws": json.dumps(laws), "history": history if system.laws.memory.any() else ""}


def free_position_warnings(system: System, free: Array) -> list[CodedText]:
    """A warning where a body's place is not unique: a free motion (n, r) moves more than the turning of the train does.

    Turning leaves the lateral place of central bodies and the z, rx, ry of all bodies alone.
    """
    dofs = system.dofs
    # columns are unit vectors: 1e-9 is rounding of the null space
    moved = np.any(np.abs(free) > 1e-9, axis=1)
    bodies: list[str] = []
    for body, direction, moves in zip(dofs.body, dofs.direction, moved, strict=True):
        central = not re.match(r"[^/]+/[^/]+/\d+", body)
        if moves and (direction in ("z", "rx", "ry") or (direction in ("x", "y") and central)):
            bodies.append(body)
    if not bodies:
        return []
    listed = ", ".join(dict.fromkeys(bodies))
    return [coded("position-not-unique", f"position of {listed} is not unique: no support holds it; mesh forces are")]


def _dataset(
    held: HeldTrain, record: Record, pieces: list[RecordPiece], contact: FlankContact, warnings: list[CodedText]
) -> xr.Dataset:
    """The labelled result."""
    from ..results.dataset import dataset

    system = held.system
    displacement = np.concatenate([piece.state.displacement for piece in pieces])
    deflection = np.concatenate([piece.link_deflection for piece in pieces])
    force, face = contact.force, faces(system.meshes)
    mesh_force, link_force = face.total(force.T), (system.links.stiffness * deflection).T
    every = np.vstack([mesh_force, link_force])
    group_force = [system.laws.rows.size(piece.state.group_force).max(axis=0) for piece in pieces]
    lost = ~np.all(contact.loaded, axis=0)
    coords: dict[Hashable, np.ndarray] = {
        "mesh": np.array(face.name, dtype=object),
        **({"mesh_slice": np.array(system.meshes.name, dtype=object)[face.cut]} if face.cut.any() else {}),
        "dof": np.array(system.dofs.names, dtype=object),
        "link_row": np.array(system.links.name, dtype=object),
        "time": np.arange(record.instants) / record.samples / float(record.unit),
    }
    angles = locked_columns(held, displacement)
    if angles:
        coords["body"] = angles.pop("body")[1]
    errors, error_labels = record_errors(system, displacement, record)
    sensors, sensor_names = record_sensors(system, record, displacement, force, link_force)
    coords |= error_labels | sensor_names
    if system.groups:
        coords["group"] = np.array([group.name for group in system.groups], dtype=object)
        coords["group_row"] = np.array(list(rows := group_row_forces(system, pieces)), dtype=object)
        angles["group_row_force"] = (("group_row", "time"), np.array(list(rows.values())))
    result = dataset(
        {
            "mesh_force": (("mesh", "time"), mesh_force),
            "displacement": (("dof", "time"), (displacement * system.dofs.radius).T),
            "link_force": (("link_row", "time"), link_force),
            "link_deflection": (("link_row", "time"), deflection.T),
            "mesh_contact": (("mesh", "time"), mesh_contact(face, contact).T),
            "contact_lost": ("mesh", face.any(lost)),
            **contact_shares(system, face, contact),
            **_slice_columns(face, force, lost),
            **angles,
            **errors,
            **sensors,
            **group_columns(system, pieces),
        },
        coords,
        verb="static",
        options=record.options,
        provenance={**system.provenance, **law_attributes(system, record)},
        warnings=[
            *warnings,
            *record.warnings(every.min(axis=1), every.max(axis=1)),
            *groups_past_the_end(system, np.max(group_force, axis=0)),
        ],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    return result


def mesh_contact(face: Faces, contact: FlankContact) -> NDArray[np.bool_]:
    """Whether all slices of each mesh touch, (T, w), on either flank."""
    return np.asarray(np.logical_and.reduceat(contact.loaded | contact.far, face.first, axis=1))


def contact_shares(system: System, face: Faces, contact: FlankContact) -> Columns:
    """Share of time in which no flank of each mesh touches; where backlash is finite that of its far flank, any slice.

    As of contact loss and transient.
    """
    touching = np.logical_or.reduceat(contact.loaded | contact.far, face.first, axis=1)
    shares: Columns = {"open_share": ("mesh", 1.0 - touching.mean(axis=0))}
    if system.far_flanks.mesh.size:
        shares["far_share"] = ("mesh", np.logical_or.reduceat(contact.far, face.first, axis=1).mean(axis=0))
    return shares


def _slice_columns(face: Faces, force: Array, lost: np.ndarray) -> Columns:
    """Forces of the slices of meshes, from the rows' (T, m) [N]; nothing where no mesh is cut.

    The face-load factor is n times the largest mean force of a slice per sum of all n: largest over mean load per
    width, as K_H beta of gear standards, with each slice's load taken as even; nan of a mesh in one piece.  A mesh
    whose mean load is on its far flank is seen from there.
    """
    if not face.cut.any():
        return {}
    mean = force.mean(axis=0)
    mean *= np.where(face.total(mean) < 0, -1.0, 1.0)[face.row]
    return {
        "face_load_factor": ("mesh", face.load_factor(-face.least(-mean), face.total(mean))),
        "slice_force": (("mesh_slice", "time"), force.T[face.cut]),
        "slice_contact_lost": ("mesh_slice", lost[face.cut]),
    }


def group_row_forces(system: System, pieces: Sequence[RecordPiece]) -> dict[str, Array]:
    """Force (T,) [N, N m] of every row of the links that follow a law, by its name."""
    rows = [row for group in system.groups for row in group.rows]
    force = np.concatenate([piece.state.group_force for piece in pieces])
    return dict(zip(rows, force.T, strict=True))


def group_columns(system: System, pieces: list[RecordPiece]) -> dict[str, tuple[tuple[str, str], np.ndarray]]:
    """Force [N], stretch [m] and state of every group over time, (group, time); nothing without groups."""
    if not system.groups:
        return {}
    laws, states = system.laws, np.array(STATES, dtype=object)
    values = {
        "group_force": [laws.rows.size(piece.state.group_force) for piece in pieces],
        "group_stretch": [laws.rows.size(piece.state.group_stretch) for piece in pieces],
        "group_state": [states[laws.state(piece.state.group_stretch, piece.anchor)] for piece in pieces],
    }
    return {name: (("group", "time"), np.concatenate(column).T) for name, column in values.items()}
