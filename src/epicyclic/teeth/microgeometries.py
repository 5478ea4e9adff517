"""Loaded contact of many micro-geometries of one pair at once: one compliance, many initial gaps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .contact_lines import line_windows
from .contact_solver import ContactSolution, products, solve_hertzian, solve_linear, tangent_stiffness
from .gear_pair import ContactPair
from .segments import ContactSegments, microgeometry_gaps

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Most matrix entries solved at once; a larger batch is bound by memory.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MicrogeometryContact:
    """Loaded contact of S micro-geometries at F loads and T phases.

    approach : (S, F, T) along the normal [m].  tangent : (S, F, T) dF/dd [N/m]; nan where not requested.
    largest_load : (S, F) force per length [N/m], means over a length as of `LoadedContact.largest_load`; nan where not
    requested.  residual : (S, F) of the contact conditions [1].  solved : (S, F) whether every phase converged.
    """

    approach: Array
    tangent: Array
    largest_load: Array
    residual: Array
    solved: NDArray[np.bool_]


def microgeometry_contact(
    segments: ContactSegments,
    pairs: Sequence[ContactPair],
    loads: ArrayLike,
    *,
    tangents: bool = False,
    largest: bool = True,
) -> MicrogeometryContact:
    """Loaded contact of pairs that differ in their initial gaps alone, at loads common to all.

    Parameters
    ----------
    segments : of one of them, by `contact_segments`.  pairs : (S,).
    loads : (F,) forces normal to the tooth, above 0 [N].  tangents : compute the tangent stiffness too.
    largest : compute the largest load per length too.

    Raises
    ------
    ModelError : micro-geometry that does not fit its flank.
    """
    force = np.sort(np.atleast_1d(np.asarray(loads, dtype=float)))
    order = np.argsort(np.argsort(np.atleast_1d(np.asarray(loads, dtype=float)), kind="stable"))
    T, n = segments.gap.shape
    gaps = microgeometry_gaps(segments, pairs)
    first = _spread_out(gaps, round(math.sqrt(len(gaps))))
    rest = np.setdiff1d(np.arange(len(gaps)), first)
    count = max(1, _AT_ONCE // (T * n * n))
    parts: list[MicrogeometryContact] = []
    heads: list[Array] = []
    for members in (first, rest):
        # own approaches (H, F, T, n) of the first, from the nearest of which the rest start; nan where not solved
        near = np.concatenate(heads) if heads else np.zeros((0, len(force), T, n))
        reached = np.flatnonzero(np.isfinite(near[:, 0, 0, 0]))
        for i in range(0, len(members), count):
            at = members[i : i + count]
            start: Array | None = None
            if reached.size:
                apart = np.array([_distance(gaps[at], gaps[k]) for k in first[reached]])
                start = near[reached[apart.argmin(axis=0)]]
            part, own = _solution(segments, gaps[at], force, start, tangents, largest)
            parts.append(part)
            if members is first and segments.line is not None:
                whole = np.asarray(part.solved.all(axis=1))
                heads.append(np.where(whole[:, None, None, None], own, np.nan))
    back = np.argsort(np.concatenate([first, rest]), kind="stable")

    def gathered(values: Sequence[Array]) -> Array:
        return np.concatenate(values)[back][:, order]

    return MicrogeometryContact(
        approach=gathered([part.approach for part in parts]),
        tangent=gathered([part.tangent for part in parts]),
        largest_load=gathered([part.largest_load for part in parts]),
        residual=gathered([part.residual for part in parts]),
        solved=np.concatenate([part.solved for part in parts])[back][:, order],
    )


def _spread_out(gaps: Array, count: int) -> Index:
    """Indices (count,) of micro-geometries of gaps (S, T, n) [m], each the farthest from those before."""
    chosen = np.zeros(count, np.int64)
    nearest = np.full(len(gaps), np.inf)
    for k in range(1, count):
        nearest = np.minimum(nearest, _distance(gaps, gaps[chosen[k - 1]]))
        chosen[k] = np.argmax(nearest)
    return np.unique(chosen)


def _distance(gaps: Array, other: Array) -> Array:
    """Distance (S,) [m] of gaps (S, T, n) from others (T, n), beside a shift that is common to all."""
    apart = (gaps - other).reshape(len(gaps), -1)
    return np.asarray(apart.std(axis=1))


def _solution(
    segments: ContactSegments, gaps: Array, loads: Array, near: Array | None, tangents: bool, largest: bool
) -> tuple[MicrogeometryContact, Array]:
    """Contact of initial gaps (S, T, n) [m] at rising loads (F,) [N], and own approaches (S, F, T, n) [m].

    near : own approaches (S, F, T, n) [m] to start from.  tangents, largest : as of `microgeometry_contact`.  With a
    linear law there are no own approaches.
    """
    S, T, n = gaps.shape
    compliance = segments.compliance
    valid = np.broadcast_to(segments.valid, (S, T, n)).reshape(-1, n)
    gap, phase = gaps.reshape(-1, n), np.tile(np.arange(T), S)
    found: list[tuple[ContactSolution, Array, Array]] = []
    own: Array | None = None
    for place, load in enumerate(loads):
        tangent = np.full(S * T, np.nan)
        if segments.line is None:
            one = solve_linear(compliance, gap, valid, np.full(S * T, load), phase=phase)
            tangent = tangent_stiffness(compliance, one.active, phase=phase) if tangents else tangent
            found.append((one, tangent, np.zeros((0, n))))
            continue
        one = _hertzian(segments, gap, phase, load, own if near is None else near[:, place].reshape(-1, n))
        own = one.approach[:, None] - gap - products(compliance, phase, one.force)
        if tangents:
            tangent = tangent_stiffness(compliance, one.active, segments.law(own, phase)[1], phase=phase)
        found.append((one, tangent, own))

    def shaped(values: list[Array]) -> Array:
        return np.moveaxis(np.array(values).reshape(len(loads), S, -1), 0, 1)

    most = np.full((S, len(loads)), np.nan)
    if largest:
        windows = line_windows(segments.pair.plane, segments.lines)
        for place, (one, _, _) in enumerate(found):
            spread = segments.spread(one.force.reshape(S, T, n))
            most[:, place] = windows.mean(spread).max(axis=(1, 2, 3))
    part = MicrogeometryContact(
        approach=shaped([one.approach for one, _, _ in found]),
        tangent=shaped([tangent for _, tangent, _ in found]),
        largest_load=most,
        residual=shaped([one.residual for one, _, _ in found]).max(axis=2),
        solved=np.asarray(shaped([one.status == "" for one, _, _ in found]).all(axis=2)),
    )
    return part, shaped([own for _, _, own in found]).reshape(S, len(loads), -1, n)


def _hertzian(segments: ContactSegments, gap: Array, phase: Index, load: float, start: Array | None) -> ContactSolution:
    """Contact of initial gaps (t, n) [m] at phases (t,) under a load [N].

    start : own approaches (t, n) [m] of a near state.  Where Newton's method does not come from there to the solution,
    it starts from its own first estimate.
    """

    def solve(rows: Index, begin: Array | None) -> ContactSolution:
        at = phase[rows]
        return solve_hertzian(
            segments.compliance,
            gap[rows],
            segments.valid[at],
            np.full(len(rows), load),
            lambda u, index: segments.law(u, at[index]),
            start=begin,
            inverse=lambda force: segments.own_approach(force, at),
            phase=at,
        )

    found = solve(np.arange(len(gap)), start)
    missed = np.flatnonzero(found.status == "not converged")
    if start is None or not missed.size:
        return found
    again = solve(missed, None)
    for name in found.__dataclass_fields__:
        getattr(found, name)[missed] = getattr(again, name)
    return found
