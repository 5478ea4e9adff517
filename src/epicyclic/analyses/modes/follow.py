"""Modes followed along a parameter by the likeness of their shapes, eigenspace by eigenspace; where two meet.

Loci of modes that have nothing to do with each other cross.  Loci that are coupled come near, turn away and swap their
shapes: they veer.  What tells them apart is the coupling phi_i^T (K' - w^2 M') phi_j [perkins1986; lin2001].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from ...system.system import Array
from .kinds import clusters

__all__ = ["Event", "Locus", "State", "events", "follow", "groups_of", "matched"]

# A mode is known again where so much of its energy lies in one eigenspace of the next state.
_SURE = 0.8
# Meeting loci are looked at again until the difference of their omega^2 is this part of it.
_MET = 1e-9
_LOOKS = 30
# A gap is least where it grows to both sides by so much.
_RISE = 1.25
# Of a veering at least so much of the turning of the shapes is an exchange between the two.
_EXCHANGED = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """Modes at one value of the parameter.  squared : (n,) omega^2.  vectors : (n, n), unit in M.  M : (n, n)."""

    value: float
    squared: Array
    vectors: Array
    M: Array


Locus = NDArray[np.int64]
"""Numbers of the loci of one root, one for a simple mode, two for a double one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Two loci meet.

    kind : crossing or veering.  value : of the parameter.  squared : mean omega^2 there.
    first, second : groups of loci.
    gap : smallest difference of omega^2.  coupling : of the two shapes [rad^2/s^2 per unit].
    index : 0 of loci that have nothing to do with each other, 1 of two that exchange their shapes with no other taking
        part [dubois2011].
    """

    kind: str
    value: float
    squared: float
    first: tuple[int, ...]
    second: tuple[int, ...]
    gap: float
    coupling: float
    index: float


def follow(at: Callable[[float], State], values: Sequence[float], *, depth: int = 10) -> list[State]:
    """States in the order of their loci, those of the first value rising; more values where shapes change quickly.

    Parameters
    ----------
    at : modes at a value, rising.  values : in the order to follow.  depth : how often a step may be halved.
    """
    path = [at(values[0])]
    todo = [float(value) for value in values[:0:-1]]
    smallest = abs(values[-1] - values[0]) / (len(values) - 1) / 2**depth
    while todo:
        state, likeness = matched(path[-1], at(todo[-1]))
        if likeness < _SURE and abs(todo[-1] - path[-1].value) > smallest:
            todo.append((todo[-1] + path[-1].value) / 2)
        else:
            path.append(state)
            todo.pop()
    return _refined(at, path)


def matched(before: State, here: State) -> tuple[State, float]:
    """`here` in the order of the loci of `before`, repeated eigenspaces turned to them, and the least likeness.

    Likeness of a mode is the share of its kinetic energy in the eigenspace it is found in.
    """
    overlap = before.vectors.T @ ((before.M + here.M) / 2) @ here.vectors
    rising = np.argsort(here.squared, kind="stable")
    spaces = [rising[run] for run in clusters(here.squared[rising])]
    energy = np.empty_like(overlap)
    for space in spaces:
        energy[:, space] = (overlap[:, space] ** 2).sum(axis=1, keepdims=True)
    _, column = scipy.optimize.linear_sum_assignment(energy, maximize=True)
    vectors, squared = np.empty_like(here.vectors), np.empty_like(here.squared)
    for space in spaces:
        mine = np.flatnonzero(np.isin(column, space))
        left, _, right = np.linalg.svd(overlap[np.ix_(mine, space)].T)
        vectors[:, mine] = here.vectors[:, space] @ (left @ right)
        squared[mine] = here.squared[space].mean() if space.size > 1 else here.squared[space]
    likeness = float(energy[np.arange(column.size), column].min(initial=1.0))
    return State(value=here.value, squared=squared, vectors=vectors, M=here.M), likeness


def _refined(at: Callable[[float], State], path: list[State]) -> list[State]:
    """The same path with more values where loci cross or come closest, until that place is known."""
    for _ in range(_LOOKS):
        wanted = _places(path)
        if not wanted:
            break
        for value in wanted:
            path = _inserted(at, path, value)
    return path


def _inserted(at: Callable[[float], State], path: list[State], value: float) -> list[State]:
    """The path with one more value; what comes after is named anew where the new state shows it was mistaken."""
    side = 1.0 if path[-1].value >= path[0].value else -1.0
    place = int(np.searchsorted([side * state.value for state in path], side * value))
    new, rest = matched(path[place - 1], at(value))[0], path[place:]
    if np.allclose(matched(new, rest[0])[0].squared, rest[0].squared, rtol=_MET, atol=0.0):
        return [*path[:place], new, *rest]
    path = [*path[:place], new]
    for state in rest:
        path.append(matched(path[-1], state)[0])
    return path


def _places(path: list[State]) -> list[float]:
    """Values to look at next: where the chord of a difference meets 0, or its parabola is least."""
    x = np.array([state.value for state in path])
    squared = np.array([state.squared for state in path])
    groups = groups_of(squared)
    mean = _means(squared, groups)
    found: dict[float, None] = {}
    for first, second in _neighbours(mean):
        d, size = mean[first] - mean[second], _MET * (mean[first] + mean[second])
        near = np.abs(d) <= size
        for k in np.flatnonzero((d[:-1] * d[1:] < 0) & ~near[:-1] & ~near[1:]).tolist():
            # the chord finds a crossing in a few steps; halves close in on two loci that only seem to change places
            found[float(x[k] - d[k] * (x[k + 1] - x[k]) / (d[k + 1] - d[k]))] = None
            found[float(x[k] + x[k + 1]) / 2] = None
        for k in _least(d):
            value = _vertex(x[k - 1 : k + 2], d[k - 1 : k + 2] ** 2)
            if abs(value - x[k]) > 1e-3 * min(abs(x[k] - x[k - 1]), abs(x[k + 1] - x[k])) and not near[k]:
                found[value] = None
    apart = 1e-9 * float(np.ptp(x))
    return [value for value in found if np.abs(x - value).min() > apart]


def _means(squared: Array, groups: Sequence[tuple[int, ...]]) -> Array:
    """omega^2 of each group at every value, (groups, values)."""
    return np.array([squared[:, list(group)].mean(axis=1) for group in groups])


def _neighbours(mean: Array) -> list[tuple[int, int]]:
    """Pairs of groups that stand beside each other somewhere."""
    order = np.argsort(mean, axis=0, kind="stable").T
    return sorted({(min(p), max(p)) for row in order for p in zip(row[:-1].tolist(), row[1:].tolist(), strict=True)})


def _least(d: Array) -> list[int]:
    """Places inside where a difference that keeps its sign is smallest and from which it grows to both sides."""
    size, found = np.abs(d), []
    for k in np.flatnonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])) + 1:
        left, right = (np.flatnonzero(side > _RISE * size[k]) for side in (size[:k], size[k:]))
        if left.size and right.size:
            dip = slice(int(left[-1]) + 1, int(k + right[0]))
            if int(np.argmin(size[dip])) + dip.start == k and np.all(d[dip] * d[k] > 0):
                found.append(int(k))
    return found


def _vertex(x: Array, y: Array) -> float:
    """Where the parabola through three points is least; the square of a gap is one near a veering."""
    (a, b, c), (u, v, w) = x, y
    slope, other = (v - u) / (b - a), (w - v) / (c - b)
    bend = (other - slope) / (c - a)
    place = (a + b) / 2 - slope / (2 * bend) if bend != 0 else b
    return float(np.clip(place, min(a, c), max(a, c)))


def groups_of(squared: Array) -> list[tuple[int, ...]]:
    """Loci (values, n) that are one repeated root at every value."""
    n = squared.shape[1]
    same = np.ones((n, n), bool)
    for row in squared:
        rising = np.argsort(row, kind="stable")
        here = np.zeros((n, n), bool)
        for run in clusters(row[rising]):
            here[np.ix_(rising[run], rising[run])] = True
        same &= here
    return list(dict.fromkeys(tuple(np.flatnonzero(row).tolist()) for row in same))


def events(path: list[State], slope: Callable[[float], tuple[Array, Array]]) -> list[Event]:
    """Crossings and veerings along a path of `follow`, in its order.

    A veering counts where the gap grows by a quarter to both sides within the path and the two shapes exchange mostly
    with each other.

    Parameters
    ----------
    slope : dK/dp, dM/dp (n, n) at a value.
    """
    squared = np.array([state.squared for state in path])
    groups = groups_of(squared)
    mean = _means(squared, groups)
    found: list[tuple[int, Event]] = []
    for pair in _neighbours(mean):
        d = mean[pair[0]] - mean[pair[1]]
        size = _MET * (mean[pair[0]] + mean[pair[1]])
        found += [(k, _event("crossing", path[k], groups, pair, slope)) for k in _zeros(d, size)]
        for k in _least(d):
            event = _event("veering", path[k], groups, pair, slope)
            if abs(d[k]) > size[k] and event.index > _EXCHANGED:
                found.append((k, event))
    return [event for _, event in sorted(found, key=lambda one: one[0])]


def _zeros(d: Array, size: Array) -> list[int]:
    """Places where a difference changes its sign, the smaller of the two or the one between them that is 0."""
    found = []
    for k, after in pairwise(np.flatnonzero(np.abs(d) > size)):
        if d[k] * d[after] < 0:
            run = np.arange(k, after + 1)
            found.append(int(run[np.argmin(np.abs(d[run]))]))
    return found


def _event(
    kind: str,
    state: State,
    groups: list[tuple[int, ...]],
    pair: tuple[int, int],
    slope: Callable[[float], tuple[Array, Array]],
) -> Event:
    first, second = (list(groups[number]) for number in pair)
    low, high = float(state.squared[first].mean()), float(state.squared[second].mean())
    dK, dM = slope(state.value)
    middle = (low + high) / 2
    form = state.vectors.T @ (dK - middle * dM) @ state.vectors
    block = form[np.ix_(first, second)]
    coupling = float(np.linalg.norm(block, 2))
    mine, other = (float(np.trace(form[np.ix_(one, one)])) / len(one) for one in (first, second))
    half = ((mine - other) / 2) ** 2
    cross = coupling**2 / (half + coupling**2) if coupling > 0 else 0.0
    share = 0.0
    if kind == "veering":
        share = _share(form, state, first, second) * _share(form, state, second, first)
    return Event(
        kind=kind,
        value=state.value,
        squared=middle,
        first=groups[pair[0]],
        second=groups[pair[1]],
        gap=abs(high - low),
        coupling=coupling,
        index=cross * share if kind == "veering" else cross,
    )


def _share(form: Array, state: State, mine: list[int], other: list[int]) -> float:
    """How much of the turning of some shapes goes into certain others, 0..1."""
    own = float(state.squared[mine].mean())
    rest = np.setdiff1d(np.arange(len(form)), mine)
    away = state.squared[rest] - own
    safe = np.abs(away) > 0
    turning = np.where(
        safe, (form[np.ix_(np.array(mine), rest)] ** 2).sum(axis=0) / np.where(safe, away, 1.0) ** 2, 0.0
    )
    total = float(turning.sum())
    return float(turning[np.isin(rest, other)].sum()) / total if total > 0 else 0.0
