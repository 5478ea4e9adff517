"""Loaded tooth contact of all meshes of a train at once, in the static equilibrium of the train."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import require_memory
from ...errors import ModelError
from ...options import Progress
from ...results.dataset import dataset
from ...statics.contact_equilibrium import ContactEquilibrium, ContactProblem, contact_equilibrium
from ...statics.equilibrium import Compliance, compliance_of, equilibrium, require_balance
from ...statics.record import (
    Record,
    RecordExcitation,
    excitation,
    excitation_at,
    idle_warnings,
    loaded_meshes,
    parallel_meshes,
    record_of,
    reference_tone,
    turn_fraction,
)
from ...statics.static import free_position_warnings, law_attributes, rounding_of
from ...system.assembly import assemble
from ...system.system import Array, System, faces
from ...system.tooth_pairs import FaceLoad, MeshFaceLaw, face_laws, tooth_warnings, with_three_rows
from ...teeth.path_of_contact import corner_phases
from ...train.train import Train
from ...warning_codes import CodedText, code_of, coded
from . import ContactOptions
from .contact_resolution import (
    Ladder,
    LoadedFaces,
    check_tolerance,
    contact_columns,
    contact_coords,
    cycle_weight,
    estimated_error,
    flank_map,
    insufficient,
    load_levels,
    refined,
)

# places along the path of contact of a flank map
_PLACES = 81
# mesh force per largest one below which a mesh is open: rounding of the equilibrium is far below
_OPEN_RATIO = 1e-7
# The corners of contact of all meshes are among the instants of a mesh cycle, of 12 meshes some 40, so that few others
# are enough; the most bound a torque to a minute.
_LADDER = Ladder(phases=(16, 256), slices=(10, 80), fewest=(32, 20))
# Instants nearer than this are one [mesh cycles]: a tenth of the distance of the two sides of a jump.
_SAME = 1e-10


def train_contact(train: Train, options: ContactOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Loaded contact of every mesh over a record: branches, sides and flanks share the load as the train lets them.

    Misalignment follows from tilt and twist of the bodies, of pins and carrier, and from deviations.  Mesh stiffnesses
    of the model have no part in the result.  Loads beside the operating one are torques; weight and other loads stay.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : mesh_force [N] (torque_factor, mesh, time), face_load [N/m] (torque_factor, mesh, width), factors of face,
        side and branch (torque_factor, mesh or mesh_pair), flank_load_per_length [N/m] (mesh, width, flank_place),
        displacement [m, rad] (dof, time), link_force and link_deflection (link_row, time), relative residuals
        (torque_factor).  Loads per length are means over a length of contact line, averaging_length [m]
        (mesh), largest_root_stress and lowest_root_stress [Pa] (torque_factor, mesh, mesh_gear).  Attributes: samples,
        slices, tolerance, estimated_error (of largest load and K_gamma, largest; nan where both are given),
        estimated_face_error (of K_Hbeta).

    Raises
    ------
    ModelError : no torque, no face width, options out of range, and all that `static` and `pair_of` refuse.
    ConvergenceError : no equilibrium.
    """
    check_tolerance(options.tolerance)
    levels = load_levels(options, zero=False)
    if not any(train.torques.values()):
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    cut = _resolved(train, options)
    case = _case(train, options, samples=cut.samples, slices=cut.slices)
    states: list[ContactEquilibrium] = []
    for i, level in enumerate(levels):
        states.append(_equilibrium(case, float(level)))
        if progress is not None:
            progress((i + 1) / len(levels))
    force = np.array([_mesh_force(state) for state in states])
    faces = _faces(train, case, levels, states, _loaded(case.system, force))
    now, instants, links = faces.operating, case.record.instants, case.system.links
    motion = states[now].displacement[:instants]
    deflection = motion @ links.B - case.acting.link_gap[:instants]
    maps, places = zip(*map(_flank, faces.loads[now]), strict=True)
    used = f"{cut.samples} instants and {cut.slices} slices are not enough"
    judged = (
        (cut.error[0], used, " of the largest load"),
        (cut.error[1], used, " of K_gamma"),
        (cut.face_error, f"{cut.slices} slices are not enough for K_Hbeta", ""),
    )
    result = dataset(
        {
            **contact_columns(faces, faces.root_stresses()),
            **_force_columns(case, force[..., :instants]),
            "flank_load_per_length": (("mesh", "width", "flank_place"), np.array(maps)),
            "path_place": (("mesh", "flank_place"), np.array(places)),
            "displacement": (("dof", "time"), (motion * case.system.dofs.radius).T),
            "link_force": (("link_row", "time"), (links.stiffness * deflection).T),
            "link_deflection": (("link_row", "time"), deflection.T),
            "contact_residual": ("torque_factor", np.array([state.contact_residual.max() for state in states])),
            "balance_residual": ("torque_factor", np.array([state.force_residual.max() for state in states])),
        },
        coords={
            **contact_coords(faces),
            "mesh_pair": list(dict.fromkeys(mesh.pair for mesh in train.meshes)),
            "flank_place": np.linspace(0.0, 1.0, _PLACES),
            "dof": list(case.system.dofs.names),
            "link_row": list(case.system.links.name),
            "time": np.arange(instants) / case.record.samples / float(case.record.unit),
        },
        verb="contact",
        options=options.common(),
        warnings=[*_warnings(train, case, force[now]), *insufficient(judged, options.tolerance)],
        provenance={**case.system.provenance, **law_attributes(case.system, case.record)},
    )
    result["time"].attrs.update({"units": "s" if case.system.tones else "mesh cycles", "long_name": "time"})
    result.attrs |= {
        "torques": json.dumps(dict(train.torques)),
        "samples": cut.samples,
        "slices": cut.slices,
        "tolerance": options.tolerance,
        "estimated_error": max(cut.error),
        "estimated_face_error": cut.face_error,
    }
    return result


class _Cut(NamedTuple):
    """Discretisation: instants of a mesh cycle or turn, slices of each face.

    error : estimated, of the largest load and of K_gamma [1]; face_error : of K_Hbeta; nan where nothing was estimated.
    """

    samples: int
    slices: int
    error: tuple[float, float] = (math.nan, math.nan)
    face_error: float = math.nan


class _Case(NamedTuple):
    """A train with three rows a mesh at T instants: those of a record, then the corners of contact.

    laws : contact of the meshes, those of equal pairs together.  contacts : of each at all instants, and its meshes.
    flexible : its compliance without meshes.  record : its instants are the first of the T.
    acting : stiffness, errors and loads at the instants.  times : (T,) of them, in the unit of the record.
    """

    laws: Sequence[MeshFaceLaw]
    contacts: Sequence[tuple[Any, NDArray[np.int64]]]
    system: System
    flexible: Compliance
    record: Record
    acting: RecordExcitation
    times: Array


def _case(train: Train, options: ContactOptions, *, samples: int, slices: int) -> _Case:
    """Train, loads and contact over a record, at the corners of contact too unless the options have the instants."""
    laws = face_laws(train, slices=slices, linear_at=options.linear_at, corner=options.corner)
    system = assemble(with_three_rows(train))
    # one mesh cycle where the record has no length
    length = 1 if options.turns is None and options.of is None and options.cycles is None else options.cycles
    over = record_of(system, cycles=length, turns=options.turns, of=options.of, samples=samples, most=64 * samples)
    index = np.arange(over.instants, dtype=np.int64)
    tones = system.tones or (over.unit,)
    phases = np.array([turn_fraction(tone / over.unit / over.samples, index) for tone in tones]).T
    flexible = compliance_of(system)
    acting = excitation(system, over.unit, index, over.samples)
    require_balance(flexible.free, acting.force, system)
    of_mesh = system.meshes.tone[faces(system.meshes).first]
    times = index / over.samples
    if options.samples is None:
        rate = np.array([float(tone / over.unit) for tone in tones])
        corners = _corner_times(laws, over, rate[of_mesh])
        turned = np.mod(corners[:, None] * rate, 1.0)
        lines = np.array([float(line.frequency / over.unit) for line in system.lines])
        waves = np.exp(2j * np.pi * np.mod(corners[:, None] * lines, 1.0))
        there = excitation_at(system, waves, turned if system.tones else np.zeros((len(corners), 1)))
        acting = RecordExcitation(*map(np.concatenate, zip(acting, there, strict=True)))
        phases, times = np.concatenate([phases, turned]), np.concatenate([times, corners])
    # memory holds the compliance between the segments of every mesh at every instant
    numbers = 0.0
    for law in laws:
        low, high = law.pair.plane.limits  # as far apart as contact lines stand on the whole face in the mean
        numbers += len(times) * len(law.meshes) * (law.pair.slices * (high - low)) ** 2
    given = f"{len(times)} instants of {laws[0].pair.slices} slices"
    require_memory(numbers, path="cycles, samples, slices", given=given, allowed="fewer of one of them")
    cycles = phases[:, of_mesh]
    return _Case(
        laws=laws,
        contacts=[(law.at(cycles[:, list(law.meshes)]), np.array(law.meshes, np.int64)) for law in laws],
        system=system,
        flexible=flexible,
        record=over,
        acting=acting,
        times=times,
    )


def _corner_times(laws: Sequence[MeshFaceLaw], record: Record, rate: Array) -> Array:
    """Times (C,) within the record at which a contact line of a mesh passes a corner of its flank [its units].

    rate : (w,) mesh cycles of each mesh in a unit.  Times that are equal, or those of the record, count once.
    """
    passed = [np.zeros(0)]
    for law in laws:
        corner = corner_phases(law.pair.plane)
        for i, lead, sense in zip(law.meshes, law.lead, law.sense, strict=True):
            if not rate[i]:  # a mesh at rest in a train that turns
                continue
            first = np.mod(sense * corner - lead, 1.0)
            whole = np.arange(math.ceil(record.count * rate[i]) + 1)
            passed.append(((first + whole[:, None]) / rate[i]).ravel())
    times = np.unique(np.concatenate(passed))
    times = times[times < record.count]
    even = np.abs(times - np.round(times * record.samples) / record.samples)
    apart = np.diff(times, prepend=-np.inf)
    same = _SAME / max(1.0, float(rate.max()))
    return np.asarray(times[(even > same) & (apart > same)])


def _resolved(train: Train, options: ContactOptions) -> _Cut:
    """Instants and slices with which the operating torque is solved within a tolerance over the first mesh cycle.

    Of the two, those given are kept.  In a record of turns the instants chosen are those of all their mesh cycles.

    Raises
    ------
    ModelError : instants or slices out of range.
    """
    samples, slices = options.samples, options.slices
    if samples is not None and slices is not None:
        return _Cut(samples=samples, slices=slices)
    one_cycle = replace(options, cycles=1, turns=None, of=None)
    turns = options.of is not None or options.turns is not None
    # in a record of turns the instants given say nothing of a mesh cycle
    few = _LADDER.phases[0] if samples is None or turns else samples
    factors: dict[int, Array] = {}  # K_Hbeta by slices

    @cache
    def numbers(count: int, pieces: int) -> Array:
        held, factor = _numbers(train, _case(train, one_cycle, samples=count, slices=pieces))
        if count == few:
            factors[pieces] = factor
        return held

    coarse = _LADDER.slices[0] if slices is None else min(slices, _LADDER.slices[0])
    chosen, pieces, error = refined(numbers, _LADDER, options, few=few, coarse=coarse)
    face_error = 0.0
    if slices is None:
        finest = factors[max(factors)]
        left = estimated_error(list(factors.values())) + np.abs(finest - factors[pieces])
        face_error = float(np.nanmax(left / finest, initial=0.0))
    if samples is None and turns:  # whole mesh cycles that a turn is not longer than
        system = assemble(train)
        unit = record_of(system, cycles=None, turns=1, of=options.of, samples=1, most=1).unit
        chosen *= max(1, math.ceil(reference_tone(system) / unit))
    w = len(train.meshes)
    return _Cut(
        samples=chosen,
        slices=pieces,
        error=(float(error[:w].max()), float(error[w:].max())),
        face_error=face_error,
    )


def _numbers(train: Train, case: _Case) -> tuple[Array, Array]:
    """Largest loads of the meshes [N/m] and K_gamma of the pairs [1] at the operating torque with what their errors are
    relative to, (2, w + p), and K_Hbeta of the meshes (w,) [1].

    The error of a load is relative to the largest of its pair: a branch may carry next to nothing.  Meshes of a pair
    that carries nothing are counted by the largest of the train.
    """
    state = _equilibrium(case, 1.0)
    force = _mesh_force(state)[None, :, : case.record.instants]
    loaded = _loaded(case.system, force)
    columns = _faces(train, case, np.ones(1), [state], loaded).columns()
    load = columns["largest_load_per_length"][1][0]
    pair = np.array([mesh.pair for mesh in train.meshes])
    scale = np.array([load[pair == name].max() for name in pair])
    branch = _force_columns(case, force)["branch_load_factor"][1][0]
    # pairs without load have no numbers to resolve
    scale, branch = np.where(loaded[0], scale, load.max()), np.where(np.isfinite(branch), branch, 1.0)
    held = np.array([np.concatenate([load, branch]), np.concatenate([scale, branch])])
    return held, np.where(loaded[0], columns["face_load_factor"][1][0], 1.0)


def _loaded(system: System, force: Array) -> NDArray[np.bool_]:
    """Meshes (F, w) of pairs that carry load in the mean, of forces (F, w, T) [N]."""
    groups, rounding = parallel_meshes(system.meshes), rounding_of(system)
    mean, most = force.mean(axis=2).T, force.max(axis=2).T
    return np.asarray(loaded_meshes(mean, groups, most=most, rounding=rounding).T)


def _equilibrium(case: _Case, factor: float) -> ContactEquilibrium:
    """Equilibrium at a multiple of the torques; Newton starts from that of the train with springs for meshes."""
    acting = case.acting._replace(force=case.acting.force + (factor - 1.0) * case.system.force)
    springs = equilibrium(
        case.flexible, stiffness=acting.stiffness, gap=acting.gap, force=acting.force, laws=case.system.laws
    )
    problem = ContactProblem(
        system=case.system, flexible=case.flexible, contacts=case.contacts, gap=acting.gap, force=acting.force
    )
    return contact_equilibrium(problem, springs.displacement)


def _mesh_force(state: ContactEquilibrium) -> Array:
    """Forces of the meshes along the tooth normal, (w, T) [N]."""
    return np.asarray(state.row_force.reshape(len(state.row_force), -1, 3).sum(axis=2).T)


def _faces(
    train: Train, case: _Case, levels: Array, states: Sequence[ContactEquilibrium], loaded: NDArray[np.bool_]
) -> LoadedFaces:
    """Loads on the faces of all meshes at levels (F,) of the torques; loaded : (F, w) meshes that carry load."""
    order = np.argsort([number for law in case.laws for number in law.meshes])
    pairs, loads = [law.pair for law in case.laws for _ in law.meshes], []
    for state in states:
        rows = state.approach.reshape(len(state.approach), -1, 3)
        parts = [
            at.faces(rows[:, list(law.meshes)], start)
            for law, (at, _), start in zip(case.laws, case.contacts, state.states, strict=True)
        ]
        loads.append([[*chain(*parts)][i] for i in order])
    return LoadedFaces(
        meshes=train.meshes,
        pairs=[pairs[i] for i in order],
        images=range(len(pairs)),
        levels=levels,
        loads=loads,
        weight=cycle_weight(case.times, float(case.record.count)),
        loaded=loaded,
    )


def _force_columns(case: _Case, force: Array) -> dict[str, Any]:
    """Mesh forces (F, w, T) [N], and how branches and sides share them [1]."""
    system, record = case.system, case.record
    face = faces(system.meshes)
    pair = np.array(system.meshes.pair, dtype=object)[face.first]
    branch = np.array(system.meshes.branch)[face.first]
    cycle = force.reshape(*force.shape[:2], record.count, record.samples).mean(axis=3)
    loaded = _loaded(system, force)
    factor = np.full((len(force), len(dict.fromkeys(pair))), np.nan)
    share = np.full(force.shape[:2], np.nan)
    for column, name in enumerate(dict.fromkeys(pair)):
        branches = [np.flatnonzero((pair == name) & (branch == b)) for b in np.unique(branch[pair == name])]
        at = loaded[:, pair == name].any(axis=1)
        each = np.array([cycle[at][:, meshes].sum(axis=1) for meshes in branches])
        factor[at, column] = (len(branches) * each / each.sum(axis=0)).max(axis=(0, 2))
        for meshes in branches:
            mean = force[:, meshes].mean(axis=2)
            whole = mean.sum(axis=1, keepdims=True)
            # a branch that carries nothing at a small torque has no share
            carries = loaded[:, meshes].any(axis=1, keepdims=True) & (whole > 0)
            share[:, meshes] = np.where(carries, mean / np.where(carries, whole, 1.0), np.nan)
    return {
        "mesh_force": (("torque_factor", "mesh", "time"), force),
        "branch_load_factor": (("torque_factor", "mesh_pair"), factor),
        "side_share": (("torque_factor", "mesh"), share),
    }


def _flank(load: FaceLoad) -> tuple[Array, Array]:
    """Load per length of all instants laid on the flank of one tooth, (K, P) [N/m], and the places (P,) of this map
    from end to end of the path [base pitches]."""
    loaded = np.isfinite(load.per_length)
    # stretch of the path that every slice of the face reaches
    reached = [load.sigma[..., k][loaded[..., k]] for k in range(load.sigma.shape[2])]
    low, high = max(places.min() for places in reached), min(places.max() for places in reached)
    place = np.linspace(low, high, _PLACES)
    return flank_map(load.sigma, load.per_length, loaded, place), place


def _warnings(train: Train, case: _Case, force: Array) -> list[CodedText]:
    """Warnings of train, teeth and record, and the meshes that open; force : (w, T) of the meshes [N]."""
    system = case.system
    messages = [text for law in case.laws for text in tooth_warnings(law.pair, train.meshes[law.meshes[0]])]
    loaded = _loaded(system, force[None])[0]
    parted = (force <= _OPEN_RATIO * force.max(initial=0.0)).any(axis=1) & loaded
    messages += idle_warnings(faces(system.meshes).name, loaded, "load factor")
    if names := [name for name, lost in zip(faces(system.meshes).name, parted, strict=True) if lost]:
        messages.append(coded("contact-lost", f"meshes open at some instants: {', '.join(names)}"))
    if system.laws.memory.any():
        text = "friction of splines has no history here: they follow their first pull"
        messages.append(coded("friction-without-history", text))
    return [
        # the flanks count here: teeth in contact replace the stiffness of the train
        *(text for text in system.warnings if code_of(text) != "flank-without-effect"),
        *dict.fromkeys(messages),
        *free_position_warnings(system, case.flexible.free),
        *case.record.warnings(force.min(axis=1), force.max(axis=1)),
    ]
