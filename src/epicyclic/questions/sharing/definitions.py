"""Load-sharing coefficients by name, gathered over a record piece by piece.

A group is the meshes of one pair and one side, N of them, one per branch; the slices of a mesh are added up first.

    cycle-peak       P_i = peak of mesh i in a mesh cycle, b_i = N P_i / sum_j P_j, coefficient 1 + max |b_i - 1|
                     over the cycles [ren2021, eq. 21-24, with the sum of the peaks as divisor]
    signed-overload  the same without the absolute value: the largest b_i
    simultaneous     largest N F_i(t) / sum_j F_j(t) over the record
    record-peak      N max_t F_i / sum_j max_t F_j
    worst-case       cycle-peak over the whole hunting period
    mean-load, mean-load-turning
                     without mesh-frequency content, of the quasi-static forces at mean mesh stiffness whatever the
                     record (`statics.load_map`); the first is K_gamma

Beside them the labelled result, and the checks and warnings that both kinds of record have.

Mesh forces over a record as a mesh-order part and a few slow shaft lines, exact at every instant; derived here.

    F_m(c, theta) = mean_m(theta) + Re sum_s A_ms(theta) exp(2 pi i ratio_s c),    t = (c + theta) / f_mesh

with the cycle number c and the phase theta in the cycle.  A record of many cycles is then one matrix product.

The worst cycle-peak coefficient over the hunting period is found without evaluating every cycle of it; derived here.
Lines whose denominators (tooth numbers, mostly) share no factor take all combinations of their phases, by the Chinese
remainder theorem; the period is the product of such blocks.  A grid over the blocks, refined by a pattern search at
each mesh's best point, evaluates phases that do occur and nothing else.  Within a block of tied lines no phase moves
alone: the search goes by the numbers of cycles after which all phases of the block recur most closely, and by their
multiples.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...limits import KGammaLimit, k_gamma_limit, limit_columns
from ...statics.equilibrium import Compliance, Values, closed_state, require_balance, require_forces
from ...statics.load_map import MEAN_LOADS
from ...statics.record import (
    MeshGroup,
    Record,
    force_at_rest,
    idle_warnings,
    line_excitation,
    loaded_meshes,
    mesh_phases,
    parallel_meshes,
    shares,
    stiffness_at,
    still_excitation,
    turn_fraction,
)
from ...statics.sample_loads import mean_loads
from ...statics.static import HeldTrain
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded

if TYPE_CHECKING:
    import xarray as xr

    from ..response.measures import Periodic

DEFINITIONS = ("cycle-peak", "simultaneous", "record-peak", "signed-overload", "worst-case", *MEAN_LOADS)


class Extremes(NamedTuple):
    """Extremes over a piece of record, (m,) each.

    ratio_high, ratio_low : largest and smallest cycle-peak ratio b [1].  simultaneous : largest ratio at one instant
        [1].
    peak, least : largest and smallest force [N].  A ratio to forces that sum to nothing or less is inf.
    """

    ratio_high: Array
    ratio_low: Array
    simultaneous: Array
    peak: Array
    least: Array

    @property
    def cycle_peak(self) -> Array:
        """Coefficient 1 + max |b - 1| over the cycles, (m,) [1] [ren2021, eq. 21-24]."""
        return np.asarray(1.0 + np.maximum(self.ratio_high - 1.0, 1.0 - self.ratio_low))


def extremes(force: Array, members: Sequence[MeshGroup]) -> Extremes:
    """Extremes of a piece of record; force (cycles, m, samples) [N], members : groups of the m meshes."""
    peaks = force.max(axis=2)
    ratio = shares(peaks, members)
    # along one axis after the other, which takes a quarter of the time of both at once
    together = shares(force.swapaxes(1, 2), members).max(axis=0).max(axis=0)
    least = force.min(axis=0).min(axis=1)
    return Extremes(ratio.max(axis=0), ratio.min(axis=0), together, peaks.max(axis=0), least)


def merge_extremes(a: Extremes, b: Extremes) -> Extremes:
    """Extremes of two pieces together, (m,) each."""
    outer = (np.maximum, np.minimum, np.maximum, np.maximum, np.minimum)
    return Extremes(*(of_both(x, y) for of_both, x, y in zip(outer, a, b, strict=True)))


def known_mean_loads(system: System) -> tuple[Array, list[CodedText]]:
    """Coefficients (2, w) without mesh-frequency content [1], and a warning where they are not known, nan then.

    A train that vibrates may have no equilibrium at rest: a load that only inertia takes.
    """
    try:
        return mean_loads(system), []
    except (ModelError, ConvergenceError) as error:
        why = getattr(error, "problem", None) or str(error)
        unknown = np.full((len(MEAN_LOADS), len(faces(system.meshes).name)), np.nan)
        return unknown, [coded("mean-load-unknown", f"{' and '.join(MEAN_LOADS)} are not known: {why}")]


def require_speed(relative_speed: float) -> None:
    """Raise ModelError where the speed per operating speed [1] is not above zero."""
    if not relative_speed > 0:
        raise ModelError("must be above zero", path="relative_speed", given=relative_speed, allowed="> 0")


def meshes_with_load(mean: Array, members: Sequence[MeshGroup], *, most: Array, rounding: float) -> NDArray[np.bool_]:
    """Meshes (m,) that carry load; arguments as of `loaded_meshes`.  ModelError where none does."""
    loaded = loaded_meshes(mean, members, most=most, rounding=rounding)
    if not loaded.any():
        problem = "load sharing needs a load, and no mesh carries any"
        raise ModelError(problem, path="operation.torque", allowed="a torque")
    return loaded


def sharing_meshes(loaded: NDArray[np.bool_], mean_load: Array) -> NDArray[np.bool_]:
    """Meshes (w,) that share a load: of those that carry any the ones with a mean-load coefficient, where known.

    mean_load : (2, w) by `MEAN_LOADS` [1].
    """
    known = np.isfinite(mean_load[0])
    return loaded & known if known.any() else loaded


def mesh_limits(system: System, stated: float | str | None) -> list[KGammaLimit]:
    """Limit of K_gamma of every whole mesh, by its stage and the branches that share the load of its pair and side.

    stated : as of `k_gamma_limit`.
    """
    names, model = faces(system.meshes).name, json.loads(system.provenance.get("model", "{}"))
    planets = {int(i): len(group) for group in parallel_meshes(system.meshes) for i in group}
    return [k_gamma_limit(model, name.split("/")[0], planets[i], stated=stated) for i, name in enumerate(names)]


def train_coefficient(values: Array) -> Array:
    """Coefficient of the train, the largest of its meshes: (definition, m) -> (definition,) [1]; nan where unknown."""
    known = np.isfinite(values).any(axis=1) | np.isinf(values).any(axis=1)
    return np.where(known, np.max(np.where(np.isnan(values), -np.inf, values), axis=1), np.nan)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceRecord:
    """Forces of the w whole meshes over a record, positive on the flank that carries the mean load of their group.

    record : its instants.  over : extremes (w,).  worst : (w,) cycle-peak over the hunting period [1], nan if unknown.
    mean, sign : (w,) mean force [N], and -1 where it is on the far flank.  loaded : (w,) whether a mesh carries any.
    lost : (w,) whether a slice leaves its loaded flank at some instant.  parted, far : (w,) whether one leaves both, or
        its far flank presses.
    bound, unknown : (w,) largest force at any phases of the lines [N], nan where not known, and why.
    history : (w, T) forces at the first T instants [N].
    options, notes, columns, provenance : what else the result says of the record, warns of and holds.
    """

    record: Record
    over: Extremes
    worst: Array
    mean: Array
    sign: Array
    loaded: NDArray[np.bool_]
    lost: NDArray[np.bool_]
    parted: NDArray[np.bool_]
    far: NDArray[np.bool_]
    bound: Array
    unknown: Sequence[str]
    history: Array
    options: Mapping[str, object]
    notes: Sequence[CodedText]
    columns: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, str] = field(default_factory=dict)

    def coefficients(self, mean_load: Array, members: Sequence[MeshGroup]) -> Array:
        """Load-sharing coefficients, (definition, w) [1] in the order of `DEFINITIONS`, nan of meshes without load.

        mean_load : (2, w) by `MEAN_LOADS`.
        """
        over, record_peak = self.over, shares(self.over.peak, members)
        values = [over.cycle_peak, over.simultaneous, record_peak, over.ratio_high, self.worst, *mean_load]
        return np.where(self.loaded, values, np.nan)


def labelled(
    system: System,
    forces: ForceRecord,
    mean_load: tuple[Array, list[CodedText]],
    *,
    method: str,
    relative_speed: float,
    limit: float | str | None,
) -> xr.Dataset:
    """The result of `sharing`.

    Parameters
    ----------
    mean_load : as of `known_mean_loads`.  method, limit : as of `sharing`.
    relative_speed : of the time [1], which is counted in mesh cycles where the train has no speed.
    """
    from ...results.dataset import dataset

    names, members, record = faces(system.meshes).name, parallel_meshes(system.meshes), forces.record
    forces = replace(forces, loaded=sharing_meshes(forces.loaded, mean_load[0]))
    values = forces.coefficients(mean_load[0], members)
    ratio = shares(forces.history.T, members).T
    sign, most, least = forces.sign, forces.over.peak, forces.over.least
    coords: dict[Hashable, Any] = {
        "definition": np.array(DEFINITIONS, dtype=object),
        "mesh": np.array(names, dtype=object),
        "time": np.arange(forces.history.shape[1]) / record.samples / (float(record.unit) * relative_speed),
    }
    if "group_force" in forces.columns:
        coords["group"] = np.array([group.name for group in system.groups], dtype=object)
    options = {"method": method, **record.options, "relative_speed": relative_speed, **forces.options}
    notes = [*forces.notes, *mean_load[1], *record.warnings(least, most)]
    result = dataset(
        {
            "load_sharing": (("definition", "mesh"), values),
            "system_load_sharing": ("definition", train_coefficient(values)),
            "load_sharing_history": (("mesh", "time"), np.where(np.isinf(ratio), np.nan, ratio)),
            "mesh_force": (("mesh", "time"), sign[:, None] * forces.history),
            "mesh_force_bound": ("mesh", forces.bound),
            **limit_columns("mesh", mesh_limits(system, limit)),
            "contact_lost": ("mesh", forces.lost),
            "mesh_force_mean": ("mesh", sign * forces.mean),
            "mesh_force_peak": ("mesh", np.where(sign < 0, -least, most)),
            "mesh_force_minimum": ("mesh", np.where(sign < 0, -most, least)),
            **forces.columns,
        },
        coords,
        verb="sharing",
        options=options,
        provenance={**system.provenance, **forces.provenance},
        warnings=[*system.warnings, *notes, *_warnings(names, forces, values, method)],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    # a netCDF attribute holds 64 bits
    result.attrs.update({name: str(v) if isinstance(v, int) and v >= 2**63 else v for name, v in options.items()})
    result.attrs["groups"] = json.dumps([[names[i] for i in group] for group in members])
    return result


def _warnings(names: Sequence[str], forces: ForceRecord, coefficients: Array, method: str) -> list[CodedText]:
    """Warnings of meshes that open or press on their far flank, of those without load, and of what is not known.

    coefficients : (definition, w) [1].
    """

    def chosen(meshes: NDArray[np.bool_]) -> str:
        """Names of the chosen meshes (w,)."""
        return ", ".join(name for name, yes in zip(names, meshes, strict=True) if yes)

    notes: list[CodedText] = []
    if parted := chosen(forces.parted & forces.loaded):
        text = f"meshes open: {parted}"
        if method != "static":
            text = (
                f"linear model invalid: mesh force falls below zero in {parted}; "
                "teeth may part at rest with --method static, in vibration with steady --contact-loss"
            )
        notes.append(coded("contact-lost", text) if method == "static" else coded("tension-in-teeth", text))
    notes += idle_warnings(names, forces.loaded, "load sharing")
    if far := chosen(forces.far):
        notes.append(coded("far-flank-loaded", f"meshes on their far flank, where their force is negative: {far}"))
    missing: dict[str, list[str]] = {}
    for name, value, reason in zip(names, forces.bound, forces.unknown, strict=True):
        if np.isnan(value) and reason:
            missing.setdefault(reason, []).append(name)
    alone = [len(meshes) for meshes in missing.values()] == [len(names)]
    if reasons := [reason if alone else f"{reason} ({', '.join(meshes)})" for reason, meshes in missing.items()]:
        text = f"mesh_force_bound, the largest force over all phases, is not known: {'; '.join(reasons)}"
        notes.append(coded("force-bound-unknown", text))
    # there the forces of a group sum to nothing or less
    by_name = zip(DEFINITIONS, np.isinf(coefficients), strict=True)
    if infinite := [f"{name} of {chosen(meshes)}" for name, meshes in by_name if meshes.any()]:
        cure = "" if method == "static" else "; with method static the teeth part"
        problem = "load sharing undefined where a mesh carries nothing and the forces of its group sum to 0 or less"
        notes.append(coded("load-sharing-undefined", f"{problem}: {'; '.join(infinite)}{cure}"))
    return notes


Source = Callable[[Array], Array]
"""Line phases (cycles, L) [turns] -> mesh forces (cycles, m, samples) [N]."""

# Cycles evaluated at once.
_CHUNK = 256
# Cycles of a block among which close recurrences are looked for, and how many are taken for each of its lines.
_LOOKED, _RECURRENCES = 200_000, 3
# Farthest that a phase moves in one step of the search [turns].
_FAR = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waves:
    """Mesh forces of a whole record.

    mean : (m, Nt) [N].  ratios : (L,) line frequency per mesh frequency, exact.
    amplitude : (L, m, Nt) complex [N], the turning of the line within the cycle included.
    """

    mean: Array
    ratios: tuple[Fraction, ...]
    amplitude: ComplexArray

    @property
    def samples(self) -> int:
        """Instants per mesh cycle."""
        return int(self.mean.shape[1])

    def subset(self, meshes: NDArray[np.int64]) -> Waves:
        """The same of some of the meshes (m_j,)."""
        return replace(self, mean=self.mean[meshes], amplitude=self.amplitude[:, meshes])


def periodic_waves(solution: Periodic) -> Waves:
    """Waves of the periodic response, forces (m, Nt) [N]; lines off the mesh orders keep their exact frequency."""
    ratios = tuple(line.frequency / solution.tone for line in solution.lines)
    turns = (np.exp(2j * np.pi * float(ratio) * solution.theta) for ratio in ratios)
    amplitude = [line.force * turn for line, turn in zip(solution.lines, turns, strict=True)]
    shape = (len(ratios), *solution.force.shape)
    return Waves(mean=solution.force, ratios=ratios, amplitude=np.array(amplitude, complex).reshape(shape))


def static_waves(system: System, flexible: Compliance, tone: Fraction, samples: int) -> Waves:
    """Waves (m, Nt) [N] of the static solution with all meshes closed: at each phase it is linear in the lines.

    Raises
    ------
    ModelError : a load works on a free motion.
    ConvergenceError : forces on a body do not balance.
    """
    k = stiffness_at(system, mesh_phases(system, tone, np.arange(samples), samples))[0]
    require_balance(flexible.free, system.force[None], system)
    for line in system.lines:
        force = force_at_rest(system, line)
        require_balance(flexible.free, np.array([force.real, force.imag]), system)

    left, size = np.zeros(samples), np.zeros(samples)

    def solved(gap: Values, load: Values) -> Values:
        """Forces (Nt, m) [N] under errors (Nt, m + c) [m] and loads (Nt, n) [N, N m]."""
        _, force, missed, largest = closed_state(flexible, k, gap[:, : k.shape[1]], load)
        np.add(left, missed, out=left)
        if load.any():
            np.maximum(size, largest, out=size)
        return force

    waves = _summed(system, tone, samples, solved)
    if size.any():
        require_forces(left, size)
    return waves


def far_waves(system: System, held: HeldTrain, tone: Fraction, samples: int) -> Waves | None:
    """Waves of how far the far flanks reach beyond first touch with all loaded flanks closed, (c, Nt) [m].

    None where there are none, or where none touches at any phases of the lines.
    """
    c = system.far_flanks.mesh.size
    if not c:
        return None
    loaded, far = stiffness_at(system, mesh_phases(system, tone, np.arange(samples), samples))
    k = np.hstack([loaded, np.zeros_like(far)])
    reach = _summed(system, tone, samples, lambda gap, load: closed_state(held.whole, k, gap, load)[0][:, -c:])
    return reach if np.any(force_bound(reach) > 0) else None


def _summed(system: System, tone: Fraction, samples: int, solved: Callable[[Values, Values], Values]) -> Waves:
    """Waves of what is linear in errors and loads: solved (errors of flanks (Nt, m + c), loads (Nt, n)) -> (Nt, ..)."""
    theta, n = np.arange(samples) / samples, len(system.force)
    still = np.tile(still_excitation(system), (samples, 1))
    mean = solved(still[:, :-n], still[:, -n:])
    ratios, amplitude = [], []
    for line in system.lines:
        ratio = line.frequency / tone
        turning = np.exp(2j * np.pi * float(ratio) * theta)[:, None] * line_excitation(system, line)
        value = solved(turning[:, :-n], turning[:, -n:])
        if ratio.denominator == 1:
            mean = mean + value.real
        else:
            ratios.append(ratio)
            amplitude.append(value.T)
    shape = (len(ratios), *mean.T.shape)
    return Waves(mean=mean.T, ratios=tuple(ratios), amplitude=np.array(amplitude, dtype=complex).reshape(shape))


def cycle_forces(waves: Waves, phases: Array) -> Array:
    """Mesh forces (cycles, m, Nt) [N] in cycles that start with given line phases (cycles, L) [turns]."""
    m, Nt = waves.mean.shape
    flat = waves.amplitude.reshape(len(waves.ratios), m * Nt)
    angle = 2 * np.pi * phases
    turning = np.hstack([np.cos(angle), -np.sin(angle)])
    force: Array = (turning @ np.vstack([flat.real, flat.imag])).reshape(-1, m, Nt)
    force += waves.mean  # in place: another array takes longer to be given than to be filled
    return force


def line_phases(ratios: Sequence[Fraction], cycles: NDArray[np.int64]) -> Array:
    """Phase of each line at the start of each cycle, (cycles, L) [turns], exact."""
    return np.array([turn_fraction(ratio, cycles) for ratio in ratios]).reshape(len(ratios), len(cycles)).T


def force_bound(waves: Waves) -> Array:
    """Upper bound of the mesh forces over all shaft phases: max over the cycle of mean + sum |A|, (m,) [N].

    Phases are discrete and may be tied by common factors of tooth numbers, so it need not be reached.
    """
    return np.asarray(np.max(waves.mean + np.sum(np.abs(waves.amplitude), axis=0), axis=1))


# --- worst case over the hunting period ------------------------------------------------------------------------------


def worst_case(
    source: Source, ratios: Sequence[Fraction], members: Sequence[MeshGroup], *, meshes: int, points: int = 4096
) -> tuple[Array, bool]:
    """Largest 1 + |b - 1| of each mesh over the hunting period.

    Parameters
    ----------
    source : mesh forces (cycles, m, samples) [N] of cycles with given line phases (cycles, L) [turns].
    ratios : (L,) of the lines, exact.  members : groups of the m meshes.  meshes : m.  points : size of the grid.

    Returns
    -------
    ((m,) coefficients [1], whether every cycle of the period was evaluated).
    """
    parts = independent_blocks(ratios)
    sizes = [lcm(*(ratios[i].denominator for i in part)) for part in parts]
    counts = _grid_counts(sizes, points)
    axes = [
        np.array([i * size // count for i in range(count)], dtype=object)
        for size, count in zip(sizes, counts, strict=True)
    ]
    grid = np.array(np.meshgrid(*axes, indexing="ij"), dtype=object).reshape(len(sizes), -1).T

    def score(places: NDArray[np.object_]) -> Array:
        """Coefficients at places (points, blocks) of the phases, (points, m) [1]."""
        return _coefficient_of(source, _phases_at(ratios, parts, sizes, places), members)

    values = score(grid) if len(sizes) else _coefficient_of(source, np.zeros((1, len(ratios))), members)
    best = values.max(axis=0)
    if counts == sizes:
        return best, True
    here = grid[values.argmax(axis=0)]
    single = [max(1, size // count // 2) for size, count in zip(sizes, counts, strict=True)]
    levels = _levels([_recurrences(ratios, part, size) for part, size in zip(parts, sizes, strict=True)], single)
    return _pattern_search(score, here, best, levels, meshes), False


def independent_blocks(ratios: Sequence[Fraction]) -> list[list[int]]:
    """Indices of lines tied by common factors of their denominators; blocks are independent of each other."""
    result: list[tuple[int, list[int]]] = []
    for i, ratio in enumerate(ratios):
        if ratio.denominator == 1:
            continue
        size, members = ratio.denominator, [i]
        free = []
        for other, indices in result:
            if gcd(other, ratio.denominator) > 1:
                size, members = lcm(size, other), indices + members
            else:
                free.append((other, indices))
        result = [*free, (size, members)]
    return [members for _, members in result]


def _grid_counts(sizes: Sequence[int], points: int) -> list[int]:
    """Grid points of each block: all of it where the product stays within `points`, the large ones thinned first."""
    counts = list(sizes)
    room = points
    order = sorted(range(len(sizes)), key=lambda i: sizes[i])
    for done, i in enumerate(order):
        share = max(2, int(room ** (1.0 / (len(order) - done)) + 1e-9))
        counts[i] = min(sizes[i], share)
        room = max(1, room // counts[i])
    return counts


def _stride(ratios: Sequence[Fraction], part: Sequence[int], size: int) -> int:
    """Cycles in which the finest line of a block advances by its smallest phase, 1 where there is no such number."""
    finest = max((ratios[i] for i in part), key=lambda ratio: ratio.denominator)
    return pow(finest.numerator, -1, size) if gcd(finest.numerator, size) == 1 else 1


def _recurrences(ratios: Sequence[Fraction], part: Sequence[int], size: int) -> list[tuple[int, float]]:
    """Steps along a block after which the phases of its tied lines recur most closely, and by how much [turns]."""
    alike = {ratios[i].denominator for i in part}
    if len(alike) == 1 or size > _LOOKED:
        return [(1, 1 / max(alike))]
    steps = np.arange(1, size // 2 + 1)
    cycles = steps.astype(object) * _stride(ratios, part, size) % size
    moved = np.zeros(len(steps))
    for i in part:
        turns = turn_fraction(ratios[i], (cycles % ratios[i].denominator).astype(np.int64))
        moved = np.maximum(moved, np.abs(turns - np.rint(turns)))
    nearest = np.argsort(moved, kind="stable")[: _RECURRENCES * len(alike)]
    return [(int(steps[i]), float(moved[i])) for i in nearest]


def _levels(recurrences: Sequence[Sequence[tuple[int, float]]], first: Sequence[int]) -> list[NDArray[np.object_]]:
    """Moves (K, blocks) of the pattern search, each way, the longest first.

    recurrences : of each block.  first : longest step of a block of one line.
    """
    blocks = len(recurrences)
    steps = [
        (block, step, longest if len(own) == 1 else max(1, int(_FAR / moved)))
        for block, (own, longest) in enumerate(zip(recurrences, first, strict=True))
        for step, moved in own
    ]
    found = []
    for level in range(max(far for _, _, far in steps).bit_length())[::-1]:
        moves = np.zeros((2 * len(steps), blocks), dtype=object)
        for row, (block, step, far) in enumerate(steps):
            moves[2 * row, block] = step * min(2**level, far)
            moves[2 * row + 1, block] = -moves[2 * row, block]
        found.append(moves)
    return found


def _phases_at(
    ratios: Sequence[Fraction], parts: Sequence[Sequence[int]], sizes: Sequence[int], places: NDArray[np.object_]
) -> Array:
    """Line phases (points, L) [turns] at places (points, blocks) along each block.

    Counted in phases of its finest line.
    """
    result = np.zeros((len(places), len(ratios)))
    for column, (part, size) in enumerate(zip(parts, sizes, strict=True)):
        cycles = (places[:, column] * _stride(ratios, part, size)) % size
        for i in part:
            p, q = ratios[i].numerator, ratios[i].denominator
            if q < 2**31:
                result[:, i] = turn_fraction(ratios[i], (cycles % q).astype(np.int64))
            else:  # products beyond int64, in Python's integers
                result[:, i] = [int(cycle) * p % q / q for cycle in cycles]
    return result


def _coefficient_of(source: Source, phases: Array, members: Sequence[MeshGroup]) -> Array:
    """Coefficients 1 + |b - 1| of cycles with given phases (points, L) [turns], (points, m) [1]."""
    pieces = [source(phases[i : i + _CHUNK]).max(axis=2) for i in range(0, len(phases), _CHUNK)]
    return 1.0 + np.abs(shares(np.concatenate(pieces), members) - 1.0)


def _pattern_search(
    score: Callable[[NDArray[np.object_]], Array],
    here: NDArray[np.object_],
    best: Array,
    levels: Sequence[NDArray[np.object_]],
    meshes: int,
) -> Array:
    """Largest coefficients (m,) [1] by pattern search from each mesh's best grid point (m, blocks).

    The best neighbour is taken while one is better, then the next level of moves (K, blocks).  Places are integers: no
    continuous optimiser applies.
    """
    best, blocks = best.copy(), here.shape[1]
    every = np.arange(meshes)
    for moves in levels:
        while True:
            places = here[:, None, :] + moves[None]
            values = score(places.reshape(-1, blocks)).reshape(meshes, len(moves), meshes)[every, :, every]
            choice = values.argmax(axis=1)
            better = values[every, choice] > best * (1 + 1e-12)
            here[better] = places[every, choice][better]
            best = np.where(better, values[every, choice], best)
            if not better.any():
                break
    return best
