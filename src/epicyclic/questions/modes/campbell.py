"""Campbell diagram: natural frequencies over speed, and the speeds at which mesh orders meet them.

Mode tracking along a parameter: modal correlation by eigenspace [allemang1982], crossings and veerings of the loci.

Uncoupled loci cross.  Coupled loci approach each other, turn away and exchange their shapes: they veer.  The coupling
phi_i^T (K' - w^2 M') phi_j tells them apart [perkins1986; lin2001].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import Array, System
from .eigen import Whirl, classify_modes, eigen, repeated_roots, whirl

if TYPE_CHECKING:
    import xarray as xr

# Range about operation, per operating speed: a run-up passes everything above standstill, where mesh orders meet modes
# without end and without force; 130 % has the overspeed of usual acceptance tests (110 to 120 %) in it.
OPERATION = (0.05, 1.3)
# Mesh orders that count; as many as a sweep reports.  The stiffness of a mesh falls off faster than 1/order.
MESH_ORDERS = 12
# Share of the largest |mu| within which modes are repeated.
_REPEATED = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshCrossings:
    """Mesh orders that meet natural frequencies, speeds rising.

    mode : (c,) place of the first mode of the frequency, from 0.  count : (c,) modes of that frequency.
    tone : (c,) index into the tones.  order : (c,) mesh order.  relative_speed : (c,) per operating speed [1].
    """

    mode: NDArray[np.int64]
    count: NDArray[np.int64]
    tone: NDArray[np.int64]
    order: NDArray[np.int64]
    relative_speed: Array

    def chosen(self, kept: NDArray[np.bool_]) -> MeshCrossings:
        """Those of a mask (c,)."""
        return MeshCrossings(**{field.name: getattr(self, field.name)[kept] for field in fields(self)})


def mesh_crossings(
    frequency: Array,
    tones: Sequence[float],
    *,
    orders: int = MESH_ORDERS,
    low: float = OPERATION[0],
    high: float = OPERATION[1],
) -> MeshCrossings:
    """Speeds f_n / (h f_m) at which order h of a mesh frequency f_m meets a natural frequency f_n, from low to high.

    Derived here.

    Parameters
    ----------
    frequency : (n,) natural frequencies [Hz], rising; rigid ones 0, which no order meets.  Repeated ones count once.
    tones : (D,) mesh frequencies at the operating speed [Hz].  orders : highest mesh order.
    low, high : range of the speed per operating speed [1].
    """
    runs = [run for run in repeated_roots(frequency**2) if frequency[run.start] > 0]
    first = np.array([run.start for run in runs], dtype=np.int64)
    count = np.array([run.stop - run.start for run in runs], dtype=np.int64)
    order = np.arange(1, orders + 1)
    speed = frequency[first][:, None, None] / (np.asarray(tones, dtype=float)[:, None] * order)
    mode, tone, column = np.nonzero((low <= speed) & (speed <= high))
    met = speed[mode, tone, column]
    rank = np.lexsort((order[column], tone, mode, met))
    return MeshCrossings(
        mode=first[mode][rank],
        count=count[mode][rank],
        tone=tone[rank].astype(np.int64),
        order=order[column][rank],
        relative_speed=met[rank],
    )


def tones_of_meshes(system: System) -> dict[Fraction, list[str]]:
    """Mesh frequencies above zero at the operating speed [Hz], that of the first mesh first: stages that have each."""
    stages_of: dict[Fraction, dict[str, None]] = {}
    for stage, tone in zip(system.meshes.stage, system.meshes.tone.tolist(), strict=True):
        if system.tones and system.tones[tone] > 0:
            stages_of.setdefault(system.tones[tone], {})[stage] = None
    return {tone: list(stages) for tone, stages in stages_of.items()}


def campbell(
    system: System,
    *,
    relative_speeds: ArrayLike,
    damped: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Whirl frequencies at each speed, modes tracked over speed by modal correlation [allemang1982].

    Parameters
    ----------
    relative_speeds : (s,) speeds per operating speed [1], in the order of tracking.
    damped : with damping.  progress : called with the share done, 0..1.

    Returns
    -------
    Dataset with ``whirl_frequency`` (relative_speed, mode) [Hz], ``mode_kind`` (mode) at the last speed and
    ``mesh_frequency`` (stage, relative_speed) [Hz].

    Raises
    ------
    ModelError : no speeds, a speed that is not finite, or what `whirl` raises.
    """
    from ...results.dataset import dataset

    speeds = np.atleast_1d(np.asarray(relative_speeds, dtype=float))
    if not speeds.size or not np.all(np.isfinite(speeds)):
        raise ModelError("speeds must be finite numbers", given=relative_speeds, path="relative_speeds")
    system = linear(system)
    modes = eigen(system)
    tracked: list[Whirl] = []
    alike = np.zeros(len(modes.omega_squared), dtype=int)
    for i, speed in enumerate(speeds):
        turning = whirl(system, relative_speed=float(speed), damped=damped, modes=modes)
        tracked.append(_tracked(tracked[-1], turning, system, alike) if tracked else turning)
        alike = _repeated(tracked[-1].mu, alike)
        if progress is not None:
            progress((i + 1) / speeds.size)
    last = tracked[-1]
    rank = np.lexsort((np.abs(last.mu.real), last.mu.imag))
    kinds = np.empty(len(rank), dtype=object)
    kinds[rank] = classify_modes(system, last.mu[rank], last.vectors[:, rank]).kind
    stages = dict(zip(system.meshes.stage, system.meshes.tone, strict=True))
    tones = np.array([float(system.tones[tone]) if system.tones else np.nan for tone in stages.values()])
    return dataset(
        {
            "whirl_frequency": (("relative_speed", "mode"), np.array([w.mu.imag for w in tracked]) / (2 * np.pi)),
            "mode_kind": ("mode", kinds),
            "mesh_frequency": (("stage", "relative_speed"), np.outer(tones, np.abs(speeds))),
        },
        {
            "relative_speed": speeds,
            "mode": np.arange(1, len(rank) + 1),
            "stage": np.array(list(stages), dtype=object),
        },
        verb="campbell",
        options={"damped": damped},
        provenance=system.provenance,
        warnings=system.warnings,
    )


def _tracked(before: Whirl, after: Whirl, system: System, alike: np.ndarray) -> Whirl:
    """Modes of `after` in the order of `before`: the assignment of largest M-weighted modal correlation, (n, n) [1].

    alike : (n,) labels of modes of `before` that were repeated at every speed so far.  The base of their eigenspace is
    arbitrary, so correlation does not tell which of them leads to which: of the branches the lower one is the first.
    """
    from scipy.optimize import linear_sum_assignment  # a third of a second that no sweep needs

    correlation = np.abs(before.vectors.conj().T @ system.M @ after.vectors) ** 2
    _, order = linear_sum_assignment(correlation, maximize=True)
    for label in np.unique(alike):
        rows = np.flatnonzero(alike == label)
        order[rows] = order[rows][np.argsort(after.mu.imag[order[rows]], kind="stable")]
    return Whirl(mu=after.mu[order], vectors=after.vectors[:, order])


def _repeated(mu: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """Labels (n,) of modes that are alike so far and whose mu (n,) [rad/s] are equal but for rounding."""
    rank = np.lexsort((mu.imag, alike))
    apart = np.abs(np.diff(mu[rank])) > _REPEATED * np.abs(mu).max()
    labels = np.zeros_like(alike)
    labels[rank[1:]] = np.cumsum(apart | (np.diff(alike[rank]) != 0))
    return labels


# Least modal correlation, the share of a mode's kinetic energy in one eigenspace of the next set, that identifies it.
_RELIABLE = 0.8
# Loci are refined until the difference of their omega^2 is this part of their sum; rounds of refinement.
_EQUAL = 1e-9
_REFINEMENTS = 30
# A gap counts as a local minimum where it grows to both sides by this factor.
_GAP_GROWTH = 1.25
# Least share of the rotation of the two shapes that a veering has as an exchange between them.
_EXCHANGED = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModeSet:
    """Modes at one value of the parameter.

    omega_squared : (n,) [rad^2/s^2].  vectors : (n, n), unit in M.  M : (n, n).
    """

    value: float
    omega_squared: Array
    vectors: Array
    M: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class LocusEvent:
    """A crossing or a veering of two loci.

    kind : crossing or veering.  value : of the parameter.  omega_squared : mean of the two there [rad^2/s^2].
    first, second : numbers of the loci; several of a repeated root.
    gap : smallest difference of omega^2 [rad^2/s^2].  coupling : of the two shapes [rad^2/s^2 per unit].
    index : veering index, 0 of uncoupled loci, 1 of two that exchange their shapes with no other taking part
        [dubois2011].
    """

    kind: str
    value: float
    omega_squared: float
    first: tuple[int, ...]
    second: tuple[int, ...]
    gap: float
    coupling: float
    index: float


def track_modes(at: Callable[[float], ModeSet], values: Sequence[float]) -> list[ModeSet]:
    """Mode sets in the order of their loci, those of the first value rising.

    Steps are halved where shapes change quickly, ten times at most.

    Parameters
    ----------
    at : modes at a value, omega^2 rising.  values : in the order of tracking.
    """
    path = [at(values[0])]
    todo = [float(value) for value in values[:0:-1]]
    smallest = abs(values[-1] - values[0]) / (len(values) - 1) / 2**10
    while todo:
        state, correlation = match_modes(path[-1], at(todo[-1]))
        if correlation < _RELIABLE and abs(todo[-1] - path[-1].value) > smallest:
            todo.append((todo[-1] + path[-1].value) / 2)
        else:
            path.append(state)
            todo.pop()
    # more values, until crossings and closest approaches are located
    for _ in range(_REFINEMENTS):
        wanted = _refinement_values(path)
        if not wanted:
            break
        for value in wanted:
            path = _insert(at, path, value)
    return path


def match_modes(before: ModeSet, after: ModeSet) -> tuple[ModeSet, float]:
    """`after` in the order of the loci of `before`, repeated eigenspaces rotated to them; least modal correlation.

    Correlation of a mode is the share of its kinetic energy in the eigenspace assigned to it, 0..1: the modal assurance
    criterion [allemang1982] with M as weight, summed over the eigenspace.
    """
    overlap = before.vectors.T @ ((before.M + after.M) / 2) @ after.vectors
    rising = np.argsort(after.omega_squared, kind="stable")
    spaces = [rising[run] for run in repeated_roots(after.omega_squared[rising])]
    energy = np.empty_like(overlap)
    for space in spaces:
        energy[:, space] = (overlap[:, space] ** 2).sum(axis=1, keepdims=True)
    from scipy.optimize import linear_sum_assignment

    _, column = linear_sum_assignment(energy, maximize=True)
    locus = np.argsort(column)
    vectors, squared = np.empty_like(after.vectors), np.empty_like(after.omega_squared)
    for space in spaces:
        loci = np.sort(locus[space])
        left, _, right = np.linalg.svd(overlap[np.ix_(loci, space)].T)
        vectors[:, loci] = after.vectors[:, space] @ (left @ right)
        squared[loci] = after.omega_squared[space].mean() if space.size > 1 else after.omega_squared[space]
    correlation = float(energy[np.arange(column.size), column].min(initial=1.0))
    return ModeSet(value=after.value, omega_squared=squared, vectors=vectors, M=after.M), correlation


def modal_assurance(a: Array, b: Array, M: Array, runs: tuple[Sequence[slice], Sequence[slice]]) -> tuple[Array, Array]:
    """Modal assurance criterion of each pair of shapes (p, q), and of the eigenspaces they lie in (p, q) [1]
    [allemang1982].

    Of repeated roots the shapes are any basis of an eigenspace: the criterion is that of the eigenspaces, the share of
    the smaller one that lies in the other.

    Parameters
    ----------
    a, b : shapes (n, p) and (n, q) of two trains.  M : (n, n) weight.  runs : places of the shapes of each eigenspace.
    """
    left, right = (phi / np.sqrt(np.einsum("ij,ij->j", phi, M @ phi)) for phi in (a, b))
    alone = (left.T @ M @ right) ** 2
    starts = [np.array([run.start for run in own], dtype=int) for own in runs]
    sizes = [np.diff([*own, count]) for own, count in zip(starts, alone.shape, strict=True)]
    blocks = np.add.reduceat(np.add.reduceat(alone, starts[0], axis=0), starts[1], axis=1)
    blocks /= np.minimum.outer(*sizes)
    spaces = np.repeat(np.repeat(blocks, sizes[0], axis=0), sizes[1], axis=1)
    return np.clip(alone, 0.0, 1.0), np.clip(spaces, 0.0, 1.0)


def _insert(at: Callable[[float], ModeSet], path: list[ModeSet], value: float) -> list[ModeSet]:
    """The path with one more value; later sets are matched anew where the new set shows that a match was mistaken."""
    side = 1.0 if path[-1].value >= path[0].value else -1.0
    number = int(np.searchsorted([side * state.value for state in path], side * value))
    new, rest = match_modes(path[number - 1], at(value))[0], path[number:]
    if np.allclose(match_modes(new, rest[0])[0].omega_squared, rest[0].omega_squared, rtol=_EQUAL, atol=0.0):
        return [*path[:number], new, *rest]
    path = [*path[:number], new]
    for state in rest:
        path.append(match_modes(path[-1], state)[0])
    return path


def _refinement_values(path: list[ModeSet]) -> list[float]:
    """Values to evaluate next: where the chord of a difference of two roots is zero, or its parabola is least."""
    x = np.array([state.value for state in path])
    squared = np.array([state.omega_squared for state in path])
    groups = repeated_loci(squared)
    mean = _mean_roots(squared, groups)
    wanted: dict[float, None] = {}
    for first, second in _adjacent_pairs(mean):
        d, size = mean[first] - mean[second], _EQUAL * (mean[first] + mean[second])
        near = np.abs(d) <= size
        for k in np.flatnonzero((d[:-1] * d[1:] < 0) & ~near[:-1] & ~near[1:]).tolist():
            # the chord finds a crossing in a few steps; halves close in on two loci that only seem to change places
            wanted[float(x[k] - d[k] * (x[k + 1] - x[k]) / (d[k + 1] - d[k]))] = None
            wanted[float(x[k] + x[k + 1]) / 2] = None
        for k in _local_minima(d):
            value = _parabola_vertex(x[k - 1 : k + 2], d[k - 1 : k + 2] ** 2)
            if abs(value - x[k]) > 1e-3 * min(abs(x[k] - x[k - 1]), abs(x[k + 1] - x[k])) and not near[k]:
                wanted[value] = None
    apart = 1e-9 * float(np.ptp(x))
    return [value for value in wanted if np.abs(x - value).min() > apart]


def _mean_roots(squared: Array, groups: Sequence[tuple[int, ...]]) -> Array:
    """omega^2 of each group of loci at every value, (groups, values) [rad^2/s^2], from `squared` (values, n)."""
    return np.array([squared[:, list(group)].mean(axis=1) for group in groups])


def _adjacent_pairs(mean: Array) -> list[tuple[int, int]]:
    """Pairs of groups that are neighbours in frequency at some value; mean : (groups, values) [rad^2/s^2]."""
    order = np.argsort(mean, axis=0, kind="stable").T
    return sorted({(min(p), max(p)) for row in order for p in zip(row[:-1].tolist(), row[1:].tolist(), strict=True)})


def _local_minima(d: Array) -> list[int]:
    """Indices of inner minima of |d|, d (values,) of one sign, from which it grows to both sides by `_GAP_GROWTH`."""
    size, minima = np.abs(d), []
    for k in np.flatnonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])) + 1:
        left, right = (np.flatnonzero(side > _GAP_GROWTH * size[k]) for side in (size[:k], size[k:]))
        if left.size and right.size:
            dip = slice(int(left[-1]) + 1, int(k + right[0]))
            if int(np.argmin(size[dip])) + dip.start == k and np.all(d[dip] * d[k] > 0):
                minima.append(int(k))
    return minima


def _parabola_vertex(x: Array, y: Array) -> float:
    """Where the parabola through three points x (3,), y (3,) is least; the square of a gap is one near a veering."""
    (a, b, c), (u, v, w) = x, y
    slope, other = (v - u) / (b - a), (w - v) / (c - b)
    bend = (other - slope) / (c - a)
    vertex = (a + b) / 2 - slope / (2 * bend) if bend != 0 else b
    return float(np.clip(vertex, min(a, c), max(a, c)))


def repeated_loci(squared: Array) -> list[tuple[int, ...]]:
    """Groups of loci that are one repeated root at every value; squared : (values, n) [rad^2/s^2]."""
    root_of, groups = np.empty(squared.shape, np.int64), dict[bytes, list[int]]()
    for roots, row in zip(root_of, squared, strict=True):
        rising = np.argsort(row, kind="stable")
        for number, run in enumerate(repeated_roots(row[rising])):
            roots[rising[run]] = number
    for locus, roots in enumerate(root_of.T):
        groups.setdefault(roots.tobytes(), []).append(locus)
    return [tuple(group) for group in groups.values()]


def locus_events(path: list[ModeSet], slope: Callable[[float], tuple[Array, Array]]) -> list[LocusEvent]:
    """Crossings and veerings along a path of `track_modes`, in its order.

    A veering counts where the gap grows by a quarter to both sides within the path, and where the two shapes exchange
    mostly with each other.

    Parameters
    ----------
    slope : dK/dp [N/m per unit], dM/dp [kg per unit], (n, n) each, at a value.
    """
    squared = np.array([state.omega_squared for state in path])
    groups = repeated_loci(squared)
    mean = _mean_roots(squared, groups)
    events: list[tuple[int, LocusEvent]] = []
    for pair in _adjacent_pairs(mean):
        d = mean[pair[0]] - mean[pair[1]]
        size = _EQUAL * (mean[pair[0]] + mean[pair[1]])
        # a crossing is where the difference changes sign, at its smallest size
        for k, after in pairwise(np.flatnonzero(np.abs(d) > size).tolist()):
            if d[k] * d[after] < 0:
                least = k + int(np.argmin(np.abs(d[k : after + 1])))
                events.append((least, _locus_event("crossing", path[least], groups, pair, slope)))
        for k in _local_minima(d):
            event = _locus_event("veering", path[k], groups, pair, slope)
            if abs(d[k]) > size[k] and event.index > _EXCHANGED:
                events.append((k, event))
    return [event for _, event in sorted(events, key=lambda item: item[0])]


def _locus_event(
    kind: str,
    state: ModeSet,
    groups: list[tuple[int, ...]],
    pair: tuple[int, int],
    slope: Callable[[float], tuple[Array, Array]],
) -> LocusEvent:
    """The event of two groups of loci at one mode set: coupling [perkins1986; lin2001], veering index [dubois2011]."""
    first, second = (list(groups[number]) for number in pair)
    low, high = float(state.omega_squared[first].mean()), float(state.omega_squared[second].mean())
    dK, dM = slope(state.value)
    middle = (low + high) / 2
    form = state.vectors.T @ (dK - middle * dM) @ state.vectors
    block = form[np.ix_(first, second)]
    coupling = float(np.linalg.norm(block, 2))
    slopes = [float(np.trace(form[np.ix_(loci, loci)])) / len(loci) for loci in (first, second)]
    half = ((slopes[0] - slopes[1]) / 2) ** 2
    index = coupling**2 / (half + coupling**2) if coupling > 0 else 0.0
    if kind == "veering":
        index *= _rotation_share(form, state, first, second) * _rotation_share(form, state, second, first)
    return LocusEvent(
        kind=kind,
        value=state.value,
        omega_squared=middle,
        first=groups[pair[0]],
        second=groups[pair[1]],
        gap=abs(high - low),
        coupling=coupling,
        index=index,
    )


def _rotation_share(form: Array, state: ModeSet, loci: list[int], other: list[int]) -> float:
    """Share 0..1 of the rotation of the shapes of some loci that goes into the shapes of others.

    form : (n, n) phi^T (K' - w^2 M') phi.
    """
    root = float(state.omega_squared[loci].mean())
    rest = np.setdiff1d(np.arange(len(form)), loci)
    away = state.omega_squared[rest] - root
    safe = np.abs(away) > 0
    strength = (form[np.ix_(np.array(loci), rest)] ** 2).sum(axis=0)
    turning = np.where(safe, strength / np.where(safe, away, 1.0) ** 2, 0.0)
    total = float(turning.sum())
    return float(turning[np.isin(rest, other)].sum()) / total if total > 0 else 0.0
