"""What loaded contact of a pair and of a train have alike: errors of the teeth, loads, resolution, results.

Errors of the teeth are those of the worst mesh cycle.  A pitch error is of teeth that turn: which of them are in mesh
is a matter of the mesh cycle that is looked at.  The gap of a pair of teeth is that of both its flanks, from measured
pitch deviations of the file, or one step between a pair and the one before it.  Errors of a mesh over its phase, of its
profile or turning with a member, open all pairs of teeth in mesh alike: they add to the transmission error and leave
the loads as they are.

Phases and slices are doubled until the printed numbers hold within a tolerance.

Loads on the faces of the meshes at several levels of load, and the Dataset of what follows from them: load along the
faces, face factors, stress in the tooth roots.  Beside it the mesh stiffness that a train has without tooth contact, of
every mesh over one mesh cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import MOST_NUMBERS, require_memory
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.tooth_pairs import FaceLoad
from ...teeth.gear_pair import ContactPair, MeshWave, uniform_along_face
from ...teeth.loaded_contact import all_loaded, all_segments, loaded_contact
from ...teeth.path_of_contact import Array, Index, averaging_length, corner_phases, graded_phases, largest_part_mean
from ...teeth.root_stress import RootStress, pair_influences, root_stress
from ...train.train import Mesh, Train
from ...warning_codes import CodedText, coded
from . import ContactOptions, StiffnessOptions

# The search for the worst cycle: places of its beginning in a mesh cycle, slices of a face that is not even, phases of
# a profile error.  The peak to peak over a cycle changes by a thousandth where its beginning does by one place.
_STARTS, _SLICES_OF_UNEVEN_FACE, _RUN_OUT_ANGLES = 64, 6, 64
# Cycles looked at: the steps between neighbouring pairs are known of all, the contact of the largest few is solved.
_MOST_CYCLES, _SOLVED = 20_000, 6
# Causes of errors that open all pairs in mesh alike.
_COMMON = ("profile", "errors")
# Pairs of teeth beside the pitch point that may be in mesh: of a long face many.
_BESIDE = 8
# Share of the tolerance for the phases; that of the slices, which cost more, is the larger one.
_PHASE_SHARE = 0.25
# Errors of a peak to peak are relative to it, or to this share of the deflection where that is larger: with a default
# tolerance a ten-thousandth of the deflection, which optimal reliefs come near and no tooth is known to.
_LEAST_SWING = 1e-2


# errors of the teeth --------------------------------------------------------------------------------------------------


class PlacedErrors(NamedTuple):
    """Contact pairs with their errors, and the mesh cycle that is analysed.

    start : its beginning [mesh cycles].  attributes : of the result.
    """

    pairs: Sequence[ContactPair]
    start: float
    warnings: list[CodedText]
    attributes: dict[str, Any]


def check_errors(options: ContactOptions) -> None:
    """Refuse a place of errors without errors.

    Raises
    ------
    ModelError : such an option.
    """
    phase, cycle = options.profile_phase, options.cycle
    if phase is not None and not options.profile_error:
        raise ModelError("is of a profile error, and there is none", path="profile_phase", given=phase)
    if cycle is not None and not _with_errors(options):
        raise ModelError("without errors all mesh cycles are alike", path="cycle", given=cycle)


def _with_errors(options: ContactOptions) -> bool:
    return bool(options.pitch_error or options.profile_error or options.deviations)


def placed_errors(
    train: Train, helices: Sequence[Mesh], pairs: Sequence[ContactPair], force: float, options: ContactOptions
) -> PlacedErrors:
    """Contact pairs of the helices with their errors, in the mesh cycle that is chosen, or in the worst.

    force : operating one, at which the worst cycle is looked for [N].
    """
    if not _with_errors(options):
        return PlacedErrors(pairs=pairs, start=0.0, warnings=[], attributes={})
    messages: list[CodedText] = []
    if options.deviations:
        named = {helix.name for helix in helices}
        if not any(error.cause in ("pitch", *_COMMON) and error.mesh in named for error in train.mesh_errors):
            text = "contact: the file has no pitch or profile deviations of this mesh, or no speeds"
            messages.append(coded("errors-not-given", text))
        pairs = [_with_waves(train, helix, pair) for helix, pair in zip(helices, pairs, strict=True)]
    turning = options.deviations or options.pitch_error != 0.0
    start, phase = options.cycle if turning else options.cycle or 0.0, options.profile_phase
    if start is None or (phase is None and options.profile_error):
        worst_start, worst_phase = _worst(train, helices, pairs, force, options)
        start = worst_start if start is None else start
        phase = worst_phase if phase is None else phase
    pairs = [_with_gaps(train, helix, pair, options, start) for helix, pair in zip(helices, pairs, strict=True)]
    if options.profile_error:
        wave = MeshWave(amplitude=options.profile_error, order=1.0, phase=phase or 0.0)
        pairs = [replace(pair, waves=(*pair.waves, wave)) for pair in pairs]
    attributes = {
        "pitch_error": options.pitch_error,
        "profile_error": options.profile_error,
        "profile_phase": phase if options.profile_error and phase is not None else math.nan,
        "deviations": int(options.deviations),
        "cycle": start,
    }
    return PlacedErrors(pairs=pairs, start=start, warnings=messages, attributes=attributes)


def pair_gaps(train: Train, helix: Mesh, numbers: Index) -> Array:
    """Gaps (n,) of pairs of teeth by their numbers (n,), from the pitch deviations of the file [m].

    The lines of the train are those of a gap that is linear from tooth to tooth (`teeth.geometry.pitch_lines`), z of
    them.  At the moment in which a pair is at the pitch point the orders j and z - j are the same: without the factor
    2 sinc^2 of each they add up to the deviation of its teeth, exactly.
    """
    gaps = np.zeros(len(numbers))
    frequency = (train.kinematics.mesh_frequency or {}).get(helix.stage)
    if not frequency:
        return gaps
    at = helix.sense * numbers - float(helix.lead)  # time at which each pair is at the pitch point [mesh cycles]
    for error in train.mesh_errors:
        if error.cause == "pitch" and error.mesh == helix.name:
            order = float(error.frequency / frequency)
            share = 2 * np.sinc(order) ** 2 if order else 1.0
            gaps += (error.amplitude * np.exp(2j * np.pi * order * at)).real / share
    return gaps


def _with_waves(train: Train, helix: Mesh, pair: ContactPair) -> ContactPair:
    """Pair with the errors of the file over the mesh phase: of the profile, and those that turn with a member."""
    frequency = (train.kinematics.mesh_frequency or {}).get(helix.stage)
    waves = []
    for error in train.mesh_errors:
        if error.cause in _COMMON and error.mesh == helix.name and frequency and not error.far:
            order = float(error.frequency / frequency)
            turn = float(np.angle(error.amplitude)) - 2 * math.pi * order * float(helix.lead)
            waves.append(MeshWave(amplitude=abs(error.amplitude), order=order, phase=helix.sense * turn))
    return replace(pair, waves=(*pair.waves, *waves))


def _with_gaps(train: Train, helix: Mesh, pair: ContactPair, options: ContactOptions, start: float) -> ContactPair:
    """Pair with the gaps of the pairs of teeth that may be in mesh within two mesh cycles of a start [mesh cycles]."""
    middle = round(helix.sense * (start + 0.5 + float(helix.lead)))
    numbers = np.arange(middle - _BESIDE, middle + _BESIDE + 1)
    later = helix.sense * numbers >= 0  # later pairs have higher numbers, or lower ones
    gaps = options.pitch_error * later.astype(float)
    if options.deviations:
        gaps = gaps + pair_gaps(train, helix, numbers)
    if not gaps.any():
        return pair
    return replace(pair, pair_gaps=tuple(gaps.tolist()), first_pair=int(numbers[0]))


def _worst(
    train: Train, helices: Sequence[Mesh], pairs: Sequence[ContactPair], force: float, options: ContactOptions
) -> tuple[float, float]:
    """Beginning of the mesh cycle [mesh cycles] and phase of the profile error [rad] with the largest peak to peak."""
    angles = np.arange(_RUN_OUT_ANGLES) * 2 * np.pi / _RUN_OUT_ANGLES
    if options.profile_phase is not None:
        angles = np.array([options.profile_phase])
    slant = math.cos(pairs[0].plane.base_helix)
    most, worst = -1.0, (0.0, 0.0)
    for middle in _candidates(train, helices[0], pairs[0], options):
        time = middle + np.arange(-2 * _STARTS, 2 * _STARTS + 1) / _STARTS
        of_helices = []
        for helix, pair in zip(helices, pairs, strict=True):
            slices = 1 if uniform_along_face(pair) else _SLICES_OF_UNEVEN_FACE
            cut_pair = replace(_with_gaps(train, helix, pair, options, float(time.mean())), slices=slices)
            loaded = loaded_contact(cut_pair, [force], helix.sense * (time + float(helix.lead)))
            of_helices.append(loaded.transmission_error[0])
        error = np.mean(of_helices, axis=0)
        sigma = helices[0].sense * (time + float(helices[0].lead))
        for angle in angles if options.profile_error else angles[:1]:
            whole = error + options.profile_error * np.cos(2 * np.pi * sigma + angle) / slant
            windows = np.lib.stride_tricks.sliding_window_view(whole, _STARTS + 1)[:, :-1]
            swing = np.ptp(windows, axis=1)
            if options.cycle is None:
                at = int(swing.argmax())
            else:
                at = int(np.clip(np.searchsorted(time, options.cycle), 0, len(time) - _STARTS - 1))
            if swing[at] > most * (1 + 1e-9):
                most, worst = float(swing[at]), (float(time[at]), float(angle))
    return worst


def _candidates(train: Train, helix: Mesh, pair: ContactPair, options: ContactOptions) -> list[float]:
    """Times [mesh cycles] about which the worst cycle is looked for: where gaps of neighbouring pairs differ most."""
    if options.cycle is not None:
        return [options.cycle + 1.0]
    if not options.deviations:
        return [-float(helix.lead)]
    numbers = np.arange(_MOST_CYCLES)
    passing = helix.sense * numbers  # at the pitch point
    # of the pitch deviations, and of the waves that open all pairs alike, counted on from cycle to cycle
    parts = [wave.amplitude * np.cos(2 * np.pi * wave.order * passing + wave.phase) for wave in pair.waves]
    common = np.asarray(sum(parts, np.zeros(len(passing))))
    step = np.abs(np.diff(pair_gaps(train, helix, passing) + common))
    largest = np.argsort(-step, kind="stable")[:_SOLVED] + 1
    return [float(numbers[k]) - float(helix.lead) for k in largest] if step.any() else [-float(helix.lead)]


# phases and slices ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Resolution:
    """Discretisation of a mesh.

    phase : (T,) of the mesh cycle.  samples : even ones among them.  slices : of each face.
    graded : whether the corners of contact are among the phases.
    error : (3,) estimated relative errors of the peak to peak of the transmission error (of a hundredth of the
        deflection where that is larger), largest load and largest pressure at the operating load, from what was not
        given; nan where nothing was estimated.
    """

    phase: Array
    samples: int
    slices: int
    graded: bool
    error: Array

    @property
    def even(self) -> NDArray[np.int64]:
        """Indices (S,) of the even phases."""
        wanted = np.arange(self.samples) / self.samples
        return np.asarray(np.abs(self.phase - wanted[:, None]).argmin(axis=1))


def check_tolerance(tolerance: float) -> None:
    """Refuse a tolerance that is no relative error.

    Raises
    ------
    ModelError : not above 0 and below 1.
    """
    if not 0 < tolerance < 1:
        raise ModelError("a relative error", path="tolerance", given=tolerance, allowed="above 0, below 1")


def sigma_at(mesh: Mesh, phase: Array, start: float = 0.0) -> Array:
    """Places sigma (T,) [base pitches] of one pair of teeth of a helix at phases (T,) of the mesh cycle.

    start : beginning of that cycle [mesh cycles], which is whole where it is 0; phases before it are of the next one.
    """
    whole = np.ceil(start - phase) if start else 0.0
    return np.asarray(mesh.sense * (phase + whole + float(mesh.lead)))


def mesh_phases(helices: Sequence[Mesh], pairs: Sequence[ContactPair], samples: int, *, graded: bool = True) -> Array:
    """Even phases of the mesh cycle, (T,); graded : the corners of contact of every helix too."""
    if not graded:
        return np.arange(samples) / samples
    corners = [
        mesh.sense * corner_phases(pair.plane) - float(mesh.lead) for mesh, pair in zip(helices, pairs, strict=True)
    ]
    return graded_phases(np.concatenate(corners), samples)


def resolution(
    helices: Sequence[Mesh], pairs: Sequence[ContactPair], force: float, options: ContactOptions, *, start: float = 0.0
) -> Resolution:
    """Phases and slices with which the operating load is solved within the tolerance of the options; those given stay.

    Parameters
    ----------
    pairs : of the helices, of any number of slices.  force : of a helix [N].  start : as of `sigma_at`.

    Raises
    ------
    ModelError : a tolerance that is not above zero.
    """
    check_tolerance(options.tolerance)
    graded, slices = options.samples is None, options.slices

    def phases(count: int) -> Array:
        return mesh_phases(helices, pairs, count, graded=graded)

    def numbers(count: int, cut: int) -> Array:
        return _numbers(helices, [replace(pair, slices=cut) for pair in pairs], force, phases(count), start)

    few, coarse = options.samples or _LADDER.phases[0], slices or _LADDER.fewest[1]
    if slices is None and all(map(uniform_along_face, pairs)):  # one slice would do
        options = replace(options, slices=_LADDER.fewest[1])
    chosen, cut, error = refined(numbers, _LADDER, options, few=few, coarse=coarse)
    error = np.broadcast_to(error, 3)
    return Resolution(phase=phases(chosen), samples=chosen, slices=cut, graded=graded, error=error)


def _numbers(helices: Sequence[Mesh], pairs: Sequence[ContactPair], force: float, phase: Array, start: float) -> Array:
    """Peak to peak of the transmission error [m], largest load [N/m] and pressure [Pa] under a force [N], and scales.

    Rows : the numbers, and what their errors are relative to, (2, 3); nan where a phase is not solved.
    """
    segments = all_segments(pairs, [sigma_at(mesh, phase, start) for mesh in helices])
    results = all_loaded(segments, [force], tangents=False)
    if any((result.status != "").any() for result in results):
        return np.full((2, 3), np.nan)
    error = np.mean([result.transmission_error[0] for result in results], axis=0)
    no_load = np.mean([result.no_load_error for result in results], axis=0)
    swing, deflection = float(np.ptp(error)), float(np.mean(error - no_load))
    load = max(float(result.largest_load[0]) for result in results)
    pressure = max(float(result.largest_pressure[0]) for result in results)
    return np.array([[swing, load, pressure], [max(swing, _LEAST_SWING * deflection), load, pressure]])


class Ladder(NamedTuple):
    """First and most phases and slices that are tried, and the fewest of both that are kept: curves are drawn through
    them."""

    phases: tuple[int, int]
    slices: tuple[int, int]
    fewest: tuple[int, int]


# The first are as coarse as the estimate of an error bears; the most bound the time of a mesh to a minute and its
# memory to a gigabyte.
_LADDER = Ladder(phases=(32, 1024), slices=(10, 160), fewest=(64, 20))


def refined(
    numbers: Callable[[int, int], Array], ladder: Ladder, options: ContactOptions, *, few: int, coarse: int
) -> tuple[int, int, Array]:
    """Phases and slices with which numbers hold within the tolerance, and their estimated errors (m,) [1].

    What is given stays; the errors are from what is not, nan where that is nothing.

    Parameters
    ----------
    numbers : phases, slices -> as of `doubled`.  few : phases with which slices are doubled.  coarse : slices with
        which phases are, which hardly depend on them.
    """
    chosen, pieces, error = options.samples, options.slices, np.zeros(1)
    if chosen is not None and pieces is not None:
        return chosen, pieces, np.full(1, np.nan)
    if chosen is None:
        share = _PHASE_SHARE * options.tolerance
        reached, missed = doubled(lambda count: numbers(count, coarse), ladder.phases, share)
        chosen, error = max(reached, ladder.fewest[0]), error + missed
    if pieces is None:
        share = (1 - _PHASE_SHARE) * options.tolerance
        reached, missed = doubled(lambda count: numbers(few, count), ladder.slices, share, checked=True)
        pieces, error = max(reached, ladder.fewest[1]), error + missed
    return chosen, pieces, error


def insufficient(judged: Sequence[tuple[float, str, str]], tolerance: float) -> list[CodedText]:
    """Warnings of estimated errors [1] above the tolerance: error, what is not enough, and of which number it is."""
    asked = f"asked {100 * tolerance:.2g} %"
    return [
        coded("resolution-insufficient", f"{used}: estimated error {100 * error:.2g} %{of}, {asked}")
        for error, used, of in judged
        if error > tolerance
    ]


def doubled(
    numbers: Callable[[int], Array], limits: tuple[int, int], tolerance: float, *, checked: bool = False
) -> tuple[int, Array]:
    """Count, doubled until numbers hold, or to a limit, and the estimated errors (m,) of them [1].

    Where there are no numbers at a count, the one before it is kept: finer ones are no better, and cost more.

    Parameters
    ----------
    numbers : count -> the numbers, and what their errors are relative to, (2, m); nan where there are none.
    limits : first and most of counts.
    tolerance : of each number [1].
    checked : a first change that is small may be so by accident, where lead modifications end within a slice; the
    next count then has to confirm it.
    """
    count, tried = limits[0], [numbers(limits[0])]
    error = np.full(tried[0].shape[1], np.nan)
    while np.isfinite(tried[-1]).all():
        following = numbers(2 * count)
        if not np.isfinite(following).all():
            break
        count *= 2
        tried.append(following)
        error = _relative(estimated_error([values for values, _ in tried]), following[1])
        if 2 * count > limits[1]:
            break
        if (error > tolerance).any():
            continue
        if not checked or len(tried) > 2:
            return count, error
        following = numbers(2 * count)
        if not (_relative(np.abs(following[0] - tried[-1][0]), following[1]) > tolerance).any():
            return count, error
    return count, error


def _relative(error: Array, scale: Array) -> Array:
    """Errors (m,) per what they are relative to; those of numbers that are nothing are none."""
    return np.divide(error, scale, out=np.zeros_like(error), where=scale != 0)


def estimated_error(values: Sequence[Array]) -> Array:
    """Error (m,) of the last of values (m,) at counts doubled each time, in their unit.

    Changes that fall by a ratio r at every doubling leave the last change times r/(1 - r): of the ratio seen, but
    neither below the 1/4 of second order nor above the 1/2 of first order, which a first change is taken for.
    """
    last = np.abs(values[-1] - values[-2])
    if len(values) < 3:
        return last
    before = np.abs(values[-2] - values[-3])
    ratio = np.clip(last / np.where(before > 0, before, np.inf), 0.25, 0.5)
    ratio = np.where(before > 0, ratio, 0.5)
    return np.asarray(last * ratio / (1 - ratio))


Columns = dict[str, tuple[Any, Array]]
Stresses = Iterable[tuple[RootStress, RootStress]]

_LOADS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Loads by default, relative to the operating one [1]."""


def load_levels(options: ContactOptions, *, zero: bool) -> Array:
    """Loads (F,) relative to the operating one, which is among them [1], rising; zero : whether 0 is one.

    Raises
    ------
    ModelError : a load that is negative or not finite, or 0.
    """
    given = _LOADS if options.loads is None else options.loads
    levels = np.array(sorted({1.0, *(float(load) for load in given)}))
    if not (np.isfinite(levels).all() and (levels[0] > 0 or (zero and levels[0] == 0))):
        allowed = "0 or more" if zero else "above 0"
        raise ModelError("relative loads", path="loads", given=list(given), allowed=allowed)
    return levels


# loads on faces -------------------------------------------------------------------------------------------------------


class LoadedFaces(NamedTuple):
    """Loads on the faces of w meshes at F levels of load and T instants.

    pairs : of teeth, of each mesh.  images : number of the first mesh that each one mirrors with its loads, or its own.
    levels : (F,) loads per operating load [1].  loads : at each level, by mesh.
    weight : (T,) of the instants in a mean over the record [1].
    loaded : (F, w) meshes that carry load; the others have no factor.
    """

    meshes: Sequence[Mesh]
    pairs: Sequence[ContactPair]
    images: Sequence[int]
    levels: Array
    loads: Sequence[Sequence[FaceLoad]]
    weight: Array
    loaded: NDArray[np.bool_]

    @property
    def operating(self) -> int:
        """Index of the operating load."""
        return int(np.argmin(np.abs(self.levels - 1.0)))

    def columns(self) -> Columns:
        """Variables along the faces of all meshes, over the load."""

        def of_meshes(value: Callable[[FaceLoad], Any]) -> Array:
            return np.array([[value(load) for load in level] for level in self.loads])

        over_time = of_meshes(lambda load: load.force.sum(axis=1)).swapaxes(1, 2)
        slice_load = np.array([np.tensordot(self.weight, level, 1) for level in over_time])
        span = np.array([pair.plane.width / pair.slices for pair in self.pairs])
        with np.errstate(invalid="ignore", divide="ignore"):
            factor = np.where(self.loaded, largest_part_mean(slice_load) / slice_load.mean(axis=2), np.nan)
        solved = of_meshes(lambda load: np.isfinite(load.force).all())
        largest = of_meshes(lambda load: np.nanmax(load.per_length))
        smallest = of_meshes(lambda load: np.min(load.per_length, where=load.whole, initial=np.inf))
        over = ("torque_factor", "mesh")
        return {
            "face_load": ((*over, "width"), slice_load / span[:, None]),
            "face_load_factor": (over, factor),
            "largest_load_per_length": (over, np.where(solved, largest, np.nan)),
            "smallest_load_per_length": (over, smallest),
        }

    def root_stresses(self) -> Iterator[tuple[RootStress, RootStress]]:
        """Stress in the roots of both gears of each mesh, (F, T, J, K); of a mirror image once."""
        influences = cache(pair_influences)
        kept: dict[int, tuple[RootStress, RootStress]] = {}
        for number, (pair, image) in enumerate(zip(self.pairs, self.images, strict=True)):
            if image in kept:
                a, b = (_mirrored(gear) for gear in kept[image])
                yield a, b
                continue
            force = np.array([level[number].force for level in self.loads])
            gears = root_stress(pair, self.loads[0][number].sigma, force, influences(pair))
            if number in self.images[number + 1 :]:
                kept[number] = gears
            yield gears


def _mirrored(gear: RootStress) -> RootStress:
    return RootStress(tension=gear.tension[..., ::-1], compression=gear.compression[..., ::-1], lean=gear.lean)


def cycle_weight(times: Array, length: float) -> Array:
    """Weights (T,) of instants in the mean over a length, which repeats, of values linear between them [1]."""
    order = np.argsort(times)
    apart = np.diff(times[order], append=times[order[0]] + length) / length
    weight = np.empty(len(times))
    weight[order] = 0.5 * (apart + np.roll(apart, 1))
    return weight


def flank_map(sigma: Array, values: Array, loaded: NDArray[np.bool_], place: Array) -> Array:
    """Values of all phases and tooth pairs laid on the flank of one tooth, (K, P); nan where nothing touches.

    Parameters
    ----------
    sigma : (T, J, K) places on the path of contact [base pitches] at T phases, J pairs of teeth, K slices.
    values, loaded : (T, J, K) values there, and which of them count.  place : (P,) places of the map [base pitches].
    """
    flank = np.full((sigma.shape[2], len(place)), np.nan)
    for k in range(len(flank)):
        touching = loaded[:, :, k]
        at, value = sigma[:, :, k][touching], values[:, :, k][touching]
        order = np.argsort(at)
        flank[k] = np.interp(place, at[order], value[order], left=np.nan, right=np.nan)
    return flank


def contact_columns(faces: LoadedFaces, stresses: Stresses) -> Columns:
    """Variables that meshes have alone and in a train; stresses : as of `LoadedFaces.root_stresses`."""
    axes, over = (1, 2, 3), ("torque_factor", "mesh", "mesh_gear")
    extremes = np.array(
        [[(gear.tension.max(axis=axes), gear.compression.min(axis=axes)) for gear in gears] for gears in stresses]
    )  # (mesh, gear, 2, F)
    tension, compression = extremes.transpose(2, 3, 0, 1)
    return {
        **faces.columns(),
        "largest_root_stress": (over, tension),
        "lowest_root_stress": (over, compression),
        "averaging_length": ("mesh", np.array([averaging_length(pair.plane) for pair in faces.pairs])),
        "shared_face": ("mesh", np.array([pair.plane.width for pair in faces.pairs])),
        "side": ("mesh", np.array([mesh.side or "face" for mesh in faces.meshes])),
    }


def contact_coords(faces: LoadedFaces) -> dict[Hashable, Any]:
    """Coordinates of these variables."""
    slices = faces.pairs[0].slices
    return {
        "torque_factor": faces.levels,
        "mesh": [mesh.name for mesh in faces.meshes],
        "mesh_gear": ["a", "b"],
        "width": (np.arange(slices) + 0.5) / slices,
    }


# mesh stiffness without contact ---------------------------------------------------------------------------------------


def stiffness(train: Train, options: StiffnessOptions) -> xr.Dataset:
    """Mesh stiffness of every mesh over one mesh cycle of its stage.

    Returns
    -------
    Dataset : mesh_stiffness (mesh, mesh_phase) and mean_mesh_stiffness (mesh) [N/m] along the tooth normal, phase_lead
        (mesh) [mesh cycles].  mesh_phase is time in mesh cycles and contains the lead: k_i(t) = k_1(t + lead_i T), see
        docs/conventions.md.

    Raises
    ------
    ModelError : more samples than memory holds.
    """
    # values of all meshes, and the terms of one, complex with their angles
    samples = options.samples
    width = len(train.meshes) + 5 * max((len(mesh.variation) for mesh in train.meshes), default=0) + 2
    require_memory(samples * width, path="samples", given=samples, allowed=f"at most {MOST_NUMBERS // width}")
    phase = np.arange(samples) / samples
    return dataset(
        {
            "mesh_stiffness": (
                ("mesh", "mesh_phase"),
                np.array([stiffness_history(mesh, phase) for mesh in train.meshes]).reshape(-1, samples),
            ),
            "mean_mesh_stiffness": ("mesh", np.array([mesh.stiffness for mesh in train.meshes])),
            "phase_lead": ("mesh", np.array([float(mesh.lead) for mesh in train.meshes])),
        },
        coords={"mesh": [mesh.name for mesh in train.meshes], "mesh_phase": phase},
        verb="stiffness",
        options={"samples": samples},
        warnings=train.warnings,
        provenance=train_provenance(train),
    )


def stiffness_history(mesh: Mesh, phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mesh stiffness (T,) [N/m] at times `phase` (T,) [mesh cycles]: Fourier series in sigma = sense (phase + lead)."""
    sigma = mesh.sense * (phase + float(mesh.lead))
    rotation = np.exp(2j * np.pi * np.multiply.outer(sigma, np.arange(1, len(mesh.variation) + 1)))
    return mesh.stiffness * (1 + (rotation @ mesh.variation).real)
