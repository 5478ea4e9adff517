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
from dataclasses import dataclass, replace
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...limits import KGammaLimit, k_gamma_limit, limit_columns
from ...statics.equilibrium import Compliance, Values, closed_approach, closed_force, require_balance, require_forces
from ...statics.load_map import MEAN_LOADS
from ...statics.record import MeshGroup, idle_warnings, loaded_meshes, mesh_stiffness, parallel_meshes, turn_fraction
from ...statics.sample_loads import mean_loads
from ...statics.static import HeldTrain
from ...system.gaps import flanks
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded

if TYPE_CHECKING:
    import xarray as xr

    from ..response.measures import Periodic

DEFINITIONS = ("cycle-peak", "simultaneous", "record-peak", "signed-overload", "worst-case", *MEAN_LOADS)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
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
    ratio = cycle_peak_ratio(peaks, members)
    together = np.empty(force.shape[1])
    for group in members:
        together[group] = instant_ratio(force[:, group]).max(axis=(0, 2))
    return Extremes(
        ratio_high=ratio.max(axis=0),
        ratio_low=ratio.min(axis=0),
        simultaneous=np.where(np.isnan(together), np.inf, together),
        peak=peaks.max(axis=0),
        least=force.min(axis=(0, 2)),
    )


def merge_extremes(a: Extremes, b: Extremes) -> Extremes:
    """Extremes of two pieces together, (m,) each."""
    return Extremes(
        ratio_high=np.maximum(a.ratio_high, b.ratio_high),
        ratio_low=np.minimum(a.ratio_low, b.ratio_low),
        simultaneous=np.maximum(a.simultaneous, b.simultaneous),
        peak=np.maximum(a.peak, b.peak),
        least=np.minimum(a.least, b.least),
    )


def cycle_peak_ratio(peaks: Array, members: Sequence[MeshGroup]) -> Array:
    """b = N P_i / sum P of each cycle, (cycles, m) [1]; peaks (cycles, m) [N] [ren2021, eq. 21-24].

    Peaks that sum to nothing or less (a linear model pulled open) have no ratio: inf.
    """
    ratio = np.empty_like(peaks)
    for group in members:
        total = peaks[:, group].sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio[:, group] = np.where(total > 0, len(group) * peaks[:, group] / total, np.inf)
    return ratio


def instant_ratio(force: Array) -> Array:
    """N F_i / sum_j F_j at every instant of one group, (..., N, samples) [1]; nan where the sum is not positive."""
    total = force.sum(axis=-2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = np.where(total > 0, force.shape[-2] * force / total, np.nan)
    return shares


def coefficients(record: Extremes, worst: Array, mean_load: Array, members: Sequence[MeshGroup]) -> Array:
    """Load-sharing coefficients, (definition, m) [1] in the order of `DEFINITIONS`.

    Parameters
    ----------
    worst : (m,) of the worst case.  mean_load : (2, m) by `MEAN_LOADS`.
    """
    record_peak = cycle_peak_ratio(record.peak[None], members)[0]
    return np.array([record.cycle_peak, record.simultaneous, record_peak, record.ratio_high, worst, *mean_load])


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


def sharing_warnings(meshes: tuple[str, ...], open_: NDArray[np.bool_], loaded: NDArray[np.bool_]) -> list[CodedText]:
    """Warnings of meshes with load that open, (m,), and of those without load, (m,)."""
    parted = mesh_names(meshes, open_ & loaded)
    notes = [coded("contact-lost", f"meshes open: {parted}")] if parted else []
    return notes + idle_warnings(meshes, loaded, "load sharing")


def mesh_names(meshes: tuple[str, ...], chosen: NDArray[np.bool_]) -> str:
    """Names of the chosen meshes (m,)."""
    return ", ".join(name for name, yes in zip(meshes, chosen, strict=True) if yes)


def far_warnings(meshes: tuple[str, ...], far: NDArray[np.bool_]) -> list[CodedText]:
    """A warning of the meshes whose far flank presses at some instant, (m,)."""
    names = mesh_names(meshes, far)
    text = f"meshes on their far flank, where their force is negative: {names}"
    return [coded("far-flank-loaded", text)] if names else []


def bound_warnings(meshes: Sequence[str], bound: Array, why: Sequence[str]) -> list[CodedText]:
    """A warning where the largest force over all phases, (m,) [N], is not known, with the reason of each mesh (m,)."""
    missing: dict[str, list[str]] = {}
    for name, value, reason in zip(meshes, bound, why, strict=True):
        if np.isnan(value) and reason:
            missing.setdefault(reason, []).append(name)
    alone = len(missing) == 1 and len(next(iter(missing.values()))) == len(meshes)
    reasons = [reason if alone else f"{reason} ({', '.join(names)})" for reason, names in missing.items()]
    text = f"mesh_force_bound, the largest force over all phases, is not known: {'; '.join(reasons)}"
    return [coded("force-bound-unknown", text)] if reasons else []


def _undefined(meshes: tuple[str, ...], coefficients: Array, method: str) -> list[CodedText]:
    """Warning of coefficients (definition, m) that are infinite: there the forces of a group sum to nothing or less."""
    infinite = [
        f"{name} of {mesh_names(meshes, row)}"
        for name, row in zip(DEFINITIONS, np.isinf(coefficients), strict=True)
        if row.any()
    ]
    if not infinite:
        return []
    cure = "" if method == "static" else "; with method static the teeth part"
    problem = "load sharing undefined where a mesh carries nothing and the forces of its group sum to 0 or less"
    return [coded("load-sharing-undefined", f"{problem}: {'; '.join(infinite)}{cure}")]


def force_columns(mean: Array, most: Array, least: Array) -> dict[str, tuple[str, Array]]:
    """Variables of mean, largest and least mesh force (m,) [N] over the whole record, of which a part is kept."""
    return {
        "mesh_force_mean": ("mesh", mean),
        "mesh_force_peak": ("mesh", most),
        "mesh_force_minimum": ("mesh", least),
    }


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


def labelled(
    system: System,
    *,
    coefficients: Array,
    ratio: Array,
    force: Array,
    bound: Array,
    columns: Mapping[str, Any],
    time: Array,
    options: Mapping[str, object],
    provenance: Mapping[str, str],
    warnings: Sequence[CodedText],
    limit: float | str | None,
) -> xr.Dataset:
    """The result of `sharing`.

    Parameters
    ----------
    coefficients : (definition, m) [1].  ratio : (m, T) simultaneous ratio [1].  force : (m, T) [N].  bound : (m,) [N].
    columns : further variables.  time : (T,) [s], or mesh cycles where the train has no speed.
    options : attributes of the result as well.  limit : as of `k_gamma_limit`.
    """
    from ...results.dataset import dataset

    names = faces(system.meshes).name
    coords: dict[Hashable, Any] = {
        "definition": np.array(DEFINITIONS, dtype=object),
        "mesh": np.array(names, dtype=object),
        "time": time,
    }
    if "group_force" in columns:
        coords["group"] = np.array([group.name for group in system.groups], dtype=object)
    result = dataset(
        {
            "load_sharing": (("definition", "mesh"), coefficients),
            "system_load_sharing": ("definition", train_coefficient(coefficients)),
            "load_sharing_history": (("mesh", "time"), ratio),
            "mesh_force": (("mesh", "time"), force),
            "mesh_force_bound": ("mesh", bound),
            **limit_columns("mesh", mesh_limits(system, limit)),
            **columns,
        },
        coords,
        verb="sharing",
        options=options,
        provenance=provenance,
        warnings=[*system.warnings, *warnings, *_undefined(names, coefficients, str(options.get("method", "")))],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    # a netCDF attribute holds 64 bits
    result.attrs.update({name: str(v) if isinstance(v, int) and v >= 2**63 else v for name, v in options.items()})
    result.attrs["groups"] = json.dumps([[names[i] for i in group] for group in parallel_meshes(system.meshes)])
    return result


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
    m, Nt = solution.force.shape
    amplitude = np.zeros((len(ratios), m, Nt), dtype=complex)
    for s, (ratio, line) in enumerate(zip(ratios, solution.lines, strict=True)):
        amplitude[s] = line.force * np.exp(2j * np.pi * float(ratio) * solution.theta)
    return Waves(mean=np.asarray(solution.force), ratios=ratios, amplitude=amplitude)


def static_waves(system: System, flexible: Compliance, tone: Fraction, samples: int) -> Waves:
    """Waves (m, Nt) [N] of the static solution with all meshes closed: at each phase it is linear in the lines.

    Raises
    ------
    ModelError : a load works on a free motion.
    ConvergenceError : forces on a body do not balance.
    """
    k = mesh_stiffness(system, tone, np.arange(samples), samples)
    require_balance(flexible.free, system.force[None], system)
    for line in system.lines:
        require_balance(flexible.free, np.array([line.force[0].real, line.force[0].imag]), system)

    left, size = np.zeros(samples), np.zeros(samples)

    def solved(gap: Values, load: Values) -> Values:
        """Forces (Nt, m) [N] under errors (Nt, m) [m] and loads (Nt, n) [N, N m]."""
        force, missed, largest = closed_force(flexible, k, gap, load)
        np.add(left, missed, out=left)
        if load.any():
            np.maximum(size, largest, out=size)
        return force

    waves = _summed(system, tone, samples, solved, [line.gap for line in system.lines], np.zeros(k.shape[1]))
    if size.any():
        require_forces(left, size)
    return waves


def far_waves(system: System, held: HeldTrain, tone: Fraction, samples: int) -> Waves | None:
    """Waves of how far the far flanks reach beyond first touch with all loaded flanks closed, (c, Nt) [m].

    None where there are none, or where none touches at any phases of the lines.
    """
    far = system.far_flanks
    c, m = far.mesh.size, len(system.meshes.name)
    if held.both is None:
        return None
    k = np.hstack([mesh_stiffness(system, tone, np.arange(samples), samples), np.zeros((samples, c))])
    flexible = held.both
    phases = np.zeros((samples, max(1, len(system.tones))))
    if tone in system.tones:
        phases[:, system.tones.index(tone)] = np.arange(samples) / samples
    touch = flanks(system).at(phases).touch[:, m:]

    def solved(gap: Values, load: Values) -> Values:
        """Gaps (Nt, c) [m] of the far flanks under errors (Nt, m + c) [m] and loads (Nt, n) [N, N m]."""
        reach: Values = closed_approach(flexible, k, gap, load @ flexible.gap_of_force.T)[:, m:] - gap[:, m:]
        return reach

    opening = np.concatenate([np.zeros(m), system.meshes.backlash[far.mesh]])
    gaps = _summed(system, tone, samples, solved, [system.flank_gaps(line) for line in system.lines], opening)
    reach = replace(gaps, mean=gaps.mean - touch.T)
    return reach if np.any(force_bound(reach) > 0) else None


def _summed(
    system: System,
    tone: Fraction,
    samples: int,
    solved: Callable[[Values, Values], Values],
    gaps: Sequence[ComplexArray],
    still: Array,
) -> Waves:
    """Waves of what is linear in errors and loads: solved (errors (Nt, r), loads (Nt, n)) -> (Nt, ..).

    Parameters
    ----------
    gaps : errors (r,) of every line [m].  still : (r,) further constant errors [m].
    """
    theta = np.arange(samples) / samples
    mean = solved(np.tile(still, (samples, 1)), np.tile(system.force, (samples, 1)))
    ratios, amplitude = [], []
    for line, gap in zip(system.lines, gaps, strict=True):
        ratio = line.frequency / tone
        turning = np.exp(2j * np.pi * float(ratio) * theta)[:, None]
        value = solved(turning * gap, turning * line.force[0])
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
    return (turning @ np.vstack([flat.real, flat.imag])).reshape(-1, m, Nt) + waves.mean


def line_phases(ratios: Sequence[Fraction], cycles: NDArray[np.int64]) -> Array:
    """Phase of each line at the start of each cycle, (cycles, L) [turns], exact."""
    return np.array([turn_fraction(ratio, cycles) for ratio in ratios]).reshape(len(ratios), len(cycles)).T


def force_bound(waves: Waves) -> Array:
    """Upper bound of the mesh forces over all shaft phases: max over the cycle of mean + sum |A|, (m,) [N].

    Phases are discrete and may be tied by common factors of tooth numbers, so it need not be reached.
    """
    largest: Array = np.max(waves.mean + np.sum(np.abs(waves.amplitude), axis=0), axis=1)
    return largest


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
    coefficient: Array = 1.0 + np.abs(cycle_peak_ratio(np.concatenate(pieces), members) - 1.0)
    return coefficient


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
