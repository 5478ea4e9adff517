"""Loaded tooth contact of all meshes of a train at once, in the static equilibrium of the train."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import require_memory
from ...errors import ModelError
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
    positive_count,
    record_of,
    reference_tone,
    turn_fraction,
)
from ...statics.static import free_position_warnings, law_attributes, rounding_of
from ...system.assembly import assemble
from ...system.system import System, faces
from ...system.tooth_pairs import FaceLoad, MeshFaceLaw, face_laws, tooth_warnings, with_three_rows
from ...teeth.path_of_contact import averaging_length, corner_phases, largest_part_mean
from ...train.train import Train
from ...warning_codes import CodedText, code_of, coded
from .contact import GEARS, TOLERANCE, flank_map, largest_root_stresses
from .contact_resolution import PHASE_SHARE, check_tolerance, doubled, estimated_error

Array = NDArray[np.float64]

TORQUES = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Torques by default, relative to the operating ones [1]."""
# places along the path of contact of a flank map
_PLACES = 81
# mesh force per largest one below which a mesh is open: rounding of the equilibrium is far below
_OPEN_RATIO = 1e-7
# First and most instants of a mesh cycle, slices of each face.  The corners of contact of all meshes are among the
# instants, of 12 meshes some 40, so that few others are enough; the most bound a torque to a minute.
_PHASES, _SLICES = (16, 256), (10, 80)
# Fewest that are kept: forces over the cycle and loads over the face are drawn through them.
_FEWEST = (32, 20)
# Instants nearer than this are one [mesh cycles]: a tenth of the distance of the two sides of a jump.
_SAME = 1e-10


def train_contact(
    train: Train,
    *,
    factors: Sequence[float] = TORQUES,
    cycles: int | None = 1,
    turns: int | None = None,
    of: str | None = None,
    samples: int | None = None,
    slices: int | None = None,
    tolerance: float = TOLERANCE,
    linear_at: float | None = None,
    corner: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Loaded contact of every mesh over a record: branches, sides and flanks share the load as the train lets them.

    Misalignment follows from tilt and twist of the bodies, of pins and carrier, and from deviations.  Mesh stiffnesses
    of the model have no part in the result.

    Parameters
    ----------
    factors : torques beside the operating ones, relative to them [1]; weight and other loads stay.
    cycles, turns, of : the record, as of `static`; one mesh cycle by default.
    samples, slices : instants per mesh cycle or turn, segments of each face; None: doubled until the numbers of the
        operating torque hold over the first mesh cycle, with the corners of contact beside the instants.
    tolerance : relative, of the largest load of every mesh and of K_gamma [1].
    linear_at : load per length [N/m] at which the contact of the flanks is linearised; None: Hertz.
    corner : solve corner contact, tips that bear beyond the path of contact.
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
    ModelError : no torque, no face width, options out of range, and all that `static` and `contact` refuse.
    ConvergenceError : no equilibrium.
    """
    check_tolerance(tolerance)
    levels = _levels(train, factors)
    length = _Length(cycles=None if turns or of else cycles, turns=turns, of=of)
    teeth: dict[str, Any] = {"linear_at": linear_at, "corner": corner}
    cut = _resolved(train, length, teeth, tolerance=tolerance, samples=samples, slices=slices)
    laws = face_laws(train, slices=cut.slices, **teeth)
    case = _case(train, laws, length, samples=cut.samples, graded=samples is None)
    states: list[ContactEquilibrium] = []
    for i, level in enumerate(levels):
        states.append(_equilibrium(case, float(level)))
        if progress is not None:
            progress((i + 1) / len(levels))
    loads = [_face_loads(case, state) for state in states]
    operating = int(np.argmin(np.abs(levels - 1.0)))
    force = np.array([_mesh_force(state) for state in states])
    lengths = [np.full(len(law.meshes), averaging_length(law.pair.plane)) for law in laws]
    instants, links = case.record.instants, case.system.links
    motion = states[operating].displacement[:instants]
    deflection = motion @ links.B - case.acting.link_gap[:instants]
    result = dataset(
        {
            **_force_columns(case, force[..., :instants]),
            **_face_columns(case, loads, _loaded(case.system, force)),
            "flank_load_per_length": (
                ("mesh", "width", "flank_place"),
                _gathered(laws, [_flank_maps(load) for load in loads[operating]]),
            ),
            **_root_columns(laws, loads),
            "displacement": (("dof", "time"), (motion * case.system.dofs.radius).T),
            "link_force": (("link_row", "time"), (links.stiffness * deflection).T),
            "link_deflection": (("link_row", "time"), deflection.T),
            "averaging_length": ("mesh", _gathered(laws, lengths)),
            "contact_residual": ("torque_factor", np.array([state.contact_residual.max() for state in states])),
            "balance_residual": ("torque_factor", np.array([state.force_residual.max() for state in states])),
        },
        coords={
            "torque_factor": levels,
            "mesh": [mesh.name for mesh in train.meshes],
            "mesh_pair": list(dict.fromkeys(mesh.pair for mesh in train.meshes)),
            "mesh_gear": list(GEARS),
            "width": (np.arange(cut.slices) + 0.5) / cut.slices,
            "flank_place": np.linspace(0.0, 1.0, _PLACES),
            "dof": list(case.system.dofs.names),
            "link_row": list(case.system.links.name),
            "time": np.arange(instants) / case.record.samples / float(case.record.unit),
        },
        verb="train_contact",
        options={"samples": samples, "slices": slices, "tolerance": tolerance, **teeth},
        warnings=[*_warnings(train, case, force[operating]), *_unresolved(cut, tolerance)],
        provenance={**case.system.provenance, **law_attributes(case.system, case.record)},
    )
    result["time"].attrs.update({"units": "s" if case.system.tones else "mesh cycles", "long_name": "time"})
    result.attrs |= {
        "torques": json.dumps(dict(train.torques)),
        "samples": cut.samples,
        "slices": cut.slices,
        "tolerance": tolerance,
        "estimated_error": max(cut.error),
        "estimated_face_error": cut.face_error,
    }
    return result


class _Length(NamedTuple):
    """Length of the record: mesh cycles, or turns of a body, as of `static`."""

    cycles: int | None
    turns: int | None
    of: str | None


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
    acting : stiffness, errors and loads at the instants.
    weight : (T,) of the instants in a mean over the record, of values linear between them [1].
    """

    laws: Sequence[MeshFaceLaw]
    contacts: Sequence[tuple[Any, NDArray[np.int64]]]
    system: System
    flexible: Compliance
    record: Record
    acting: RecordExcitation
    weight: Array


def _levels(train: Train, factors: Sequence[float]) -> Array:
    """Torque factors (F,) [1] rising, the operating one among them."""
    levels = np.array(sorted({1.0, *(float(factor) for factor in factors)}))
    if not (np.isfinite(levels).all() and (levels > 0).all()):
        raise ModelError("relative torques", path="loads", given=list(factors), allowed="above 0")
    if not any(train.torques.values()):
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    return levels


def _case(train: Train, laws: Sequence[MeshFaceLaw], length: _Length, *, samples: int, graded: bool) -> _Case:
    """Train, loads and contact over a record; graded : at the corners of contact too."""
    system = assemble(with_three_rows(train))
    over = record_of(system, cycles=length.cycles, turns=length.turns, of=length.of, samples=samples, most=64 * samples)
    index = np.arange(over.instants, dtype=np.int64)
    tones = system.tones or (over.unit,)
    phases = np.array([turn_fraction(tone / over.unit / over.samples, index) for tone in tones]).T
    flexible = compliance_of(system)
    acting = excitation(system, over.unit, index, over.samples)
    require_balance(flexible.free, acting.force, system)
    of_mesh = system.meshes.tone[faces(system.meshes).first]
    times = index / over.samples
    if graded:
        rate = np.array([float(tone / over.unit) for tone in tones])
        corners = _corner_times(laws, over, rate[of_mesh])
        turned = np.mod(corners[:, None] * rate, 1.0)
        lines = np.array([float(line.frequency / over.unit) for line in system.lines])
        waves = np.exp(2j * np.pi * np.mod(corners[:, None] * lines, 1.0))
        there = excitation_at(system, waves, turned if system.tones else np.zeros((len(corners), 1)))
        acting = RecordExcitation(
            stiffness=np.concatenate([acting.stiffness, there.stiffness]),
            gap=np.concatenate([acting.gap, there.gap]),
            link_gap=np.concatenate([acting.link_gap, there.link_gap]),
            force=np.concatenate([acting.force, there.force]),
        )
        phases, times = np.concatenate([phases, turned]), np.concatenate([times, corners])
    _require_room(len(times), laws)
    cycles = phases[:, of_mesh]
    # weights of instants in the mean over a length, which repeats, of values linear between them
    order, length_of_record = np.argsort(times), float(over.count)
    apart = np.diff(times[order], append=times[order[0]] + length_of_record) / length_of_record
    weight = np.empty(len(times))
    weight[order] = 0.5 * (apart + np.roll(apart, 1))
    return _Case(
        laws=laws,
        contacts=[(law.at(cycles[:, list(law.meshes)]), np.array(law.meshes, np.int64)) for law in laws],
        system=system,
        flexible=flexible,
        record=over,
        acting=acting,
        weight=weight,
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


def _resolved(
    train: Train,
    length: _Length,
    teeth: Mapping[str, Any],
    *,
    tolerance: float,
    samples: int | None,
    slices: int | None,
) -> _Cut:
    """Instants and slices with which the operating torque is solved within a tolerance over the first mesh cycle.

    Of the two, those given are kept.  In a record of turns the instants chosen are those of all their mesh cycles.

    Raises
    ------
    ModelError : instants or slices out of range.
    """
    samples = None if samples is None else positive_count("samples", samples, 1)
    slices = None if slices is None else positive_count("slices", slices, 1)
    if samples is not None and slices is not None:
        return _Cut(samples=samples, slices=slices)
    one_cycle = _Length(cycles=1, turns=None, of=None)

    @cache
    def numbers(count: int, pieces: int) -> tuple[Array, Array]:
        laws = face_laws(train, slices=pieces, **teeth)
        return _numbers(train, _case(train, laws, one_cycle, samples=count, graded=samples is None))

    error = np.zeros(len(train.meshes) + len({mesh.pair for mesh in train.meshes}))
    chosen, pieces, face_error = samples, slices, 0.0
    if chosen is None:
        # what the instants miss hardly depends on the slices
        coarse = _SLICES[0] if slices is None else min(slices, _SLICES[0])
        reached, missed = doubled(lambda count: numbers(count, coarse)[0], _PHASES, PHASE_SHARE * tolerance)
        chosen, error = max(reached, _FEWEST[0]) * _cycles_a_unit(train, length), error + missed
    if pieces is None:
        # in a record of turns the instants given say nothing of a mesh cycle
        few = _PHASES[0] if samples is None or length.of or length.turns else samples
        tried: dict[int, Array] = {}

        def cut(count: int) -> Array:
            held, tried[count] = numbers(few, count)
            return held

        reached, missed = doubled(cut, _SLICES, (1 - PHASE_SHARE) * tolerance, checked=True)
        pieces, error = max(reached, _FEWEST[1]), error + missed
        finest = tried[max(tried)]
        left = estimated_error(list(tried.values())) + np.abs(finest - tried[pieces])
        face_error = float(np.nanmax(left / finest, initial=0.0))
    w = len(train.meshes)
    return _Cut(
        samples=chosen,
        slices=pieces,
        error=(float(error[:w].max()), float(error[w:].max())),
        face_error=face_error,
    )


def _cycles_a_unit(train: Train, length: _Length) -> int:
    """Whole mesh cycles that a unit of the record is not longer than: 1, or those of a turn."""
    if not length.of and not length.turns:
        return 1
    system = assemble(train)
    unit = record_of(system, cycles=None, turns=1, of=length.of, samples=1, most=1).unit
    return max(1, math.ceil(reference_tone(system) / unit))


def _numbers(train: Train, case: _Case) -> tuple[Array, Array]:
    """Largest loads of the meshes [N/m] and K_gamma of the pairs [1] at the operating torque with what their errors are
    relative to, (2, w + p), and K_Hbeta of the meshes (w,) [1].

    The error of a load is relative to the largest of its pair: a branch may carry next to nothing.  Meshes of a pair
    that carries nothing are counted by the largest of the train.
    """
    state = _equilibrium(case, 1.0)
    force = _mesh_force(state)[None, :, : case.record.instants]
    loaded = _loaded(case.system, force)
    columns = _face_columns(case, [_face_loads(case, state)], loaded)
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


def _require_room(instants: int, laws: Sequence[MeshFaceLaw]) -> None:
    """Refuse what memory does not hold: the compliance between the segments of every mesh at every instant."""
    numbers = 0.0
    for law in laws:
        low, high = law.pair.plane.limits  # as far apart as contact lines stand on the whole face in the mean
        numbers += instants * len(law.meshes) * (law.pair.slices * (high - low)) ** 2
    require_memory(
        numbers,
        path="cycles, samples, slices",
        given=f"{instants} instants of {laws[0].pair.slices} slices",
        allowed="fewer of one of them",
    )


def _unresolved(cut: _Cut, tolerance: float) -> list[CodedText]:
    """Warnings where instants and slices are not enough for the tolerance."""
    used = f"{cut.samples} instants and {cut.slices} slices are not enough"
    judged = (
        (cut.error[0], used, " of the largest load"),
        (cut.error[1], used, " of K_gamma"),
        (cut.face_error, f"{cut.slices} slices are not enough for K_Hbeta", ""),
    )
    asked = f"asked {100 * tolerance:.2g} %"
    return [
        coded("resolution-insufficient", f"{problem}: estimated error {100 * error:.2g} %{number}, {asked}")
        for error, problem, number in judged
        if error > tolerance
    ]


def _equilibrium(case: _Case, factor: float) -> ContactEquilibrium:
    """Equilibrium at a multiple of the torques; Newton starts from that of the train with springs for meshes."""
    acting = replace(case.acting, force=case.acting.force + (factor - 1.0) * case.system.force)
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


def _face_loads(case: _Case, state: ContactEquilibrium) -> list[FaceLoad]:
    """Load along the faces of the meshes of each law."""
    rows = state.approach.reshape(len(state.approach), -1, 3)
    return [
        at.face(rows[:, list(law.meshes)], start)
        for law, (at, _), start in zip(case.laws, case.contacts, state.states, strict=True)
    ]


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


def _gathered(laws: Sequence[MeshFaceLaw], parts: Sequence[Array]) -> Array:
    """Values (g, ...) of the meshes of each law as one array (w, ...) in the order of the meshes."""
    return np.concatenate(parts)[np.argsort([mesh for law in laws for mesh in law.meshes])]


def _face_columns(case: _Case, loads: Sequence[Sequence[FaceLoad]], loaded: NDArray[np.bool_]) -> dict[str, Any]:
    """Variables along the faces of all meshes.

    loads : at each torque, by law.  loaded : (F, w) meshes that carry load, the others have no factor.
    """
    laws = case.laws
    mean, largest, smallest = [], [], []
    for level in loads:
        mean.append(_gathered(laws, [np.tensordot(case.weight, load.force.sum(axis=2), 1) for load in level]))
        largest.append(_gathered(laws, [np.nanmax(load.per_length, axis=(0, 2, 3)) for load in level]))
        least = [np.where(load.whole, load.per_length, np.inf).min(axis=(0, 2, 3)) for load in level]
        smallest.append(_gathered(laws, least))
    slice_load = np.array(mean)
    span = _gathered(laws, [np.full(len(law.meshes), law.pair.plane.width / law.pair.slices) for law in laws])
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = np.where(loaded, largest_part_mean(slice_load) / slice_load.mean(axis=2), np.nan)
    return {
        "face_load": (("torque_factor", "mesh", "width"), slice_load / span[:, None]),
        "face_load_factor": (("torque_factor", "mesh"), factor),
        "largest_load_per_length": (("torque_factor", "mesh"), np.array(largest)),
        "smallest_load_per_length": (("torque_factor", "mesh"), np.array(smallest)),
    }


def _root_columns(laws: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]]) -> dict[str, Any]:
    """Largest stresses in the tooth roots of both gears of every mesh [Pa]; loads : at each torque, by law."""
    over = ("torque_factor", "mesh", "mesh_gear")
    names = ("largest_root_stress", "lowest_root_stress")
    stresses = zip(*largest_root_stresses(laws, loads), strict=True)
    return {
        name: (over, _gathered(laws, of_laws).transpose(1, 0, 2)) for name, of_laws in zip(names, stresses, strict=True)
    }


def _flank_maps(load: FaceLoad) -> Array:
    """Load per length of all instants laid on the flank of one tooth, (g, K, P) [N/m] from end to end of the path."""
    maps = []
    for mesh in range(load.per_length.shape[1]):
        sigma, value = load.sigma[:, mesh], load.per_length[:, mesh]
        loaded = np.isfinite(value)
        # stretch of the path that every slice of the face reaches
        slices = range(value.shape[2])
        low = max(sigma[:, :, k][loaded[:, :, k]].min() for k in slices)
        high = min(sigma[:, :, k][loaded[:, :, k]].max() for k in slices)
        maps.append(flank_map(sigma, value, loaded, np.linspace(low, high, _PLACES)))
    return np.array(maps)


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
