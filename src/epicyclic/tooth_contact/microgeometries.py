"""Loaded contact of many micro-geometries of one pair at once: one compliance, many initial gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .line_load import line_windows
from .pair import ContactPair
from .positive import products
from .segments import ContactSegments, with_microgeometry
from .solve import ContactSolution, solve_hertzian, solve_linear, tangent_stiffness

__all__ = ["MicrogeometryContact", "microgeometry_contact"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Most matrix entries solved at once; a larger batch is bound by memory.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MicrogeometryContact:
    """Loaded contact of S micro-geometries at F loads and T phases.

    approach : (S, F, T) along the normal [m].  tangent : (S, F, T) dF/dd [N/m]; nan where not requested.
    largest_load : (S, F) force per length [N/m], means over a length as of `LoadedContact.largest_load`.
    residual : (S, F) of the contact conditions [1].  solved : (S, F) whether every phase converged.
    """

    approach: Array
    tangent: Array
    largest_load: Array
    residual: Array
    solved: NDArray[np.bool_]


def microgeometry_contact(
    segments: ContactSegments, pairs: Sequence[ContactPair], loads: ArrayLike, *, tangents: bool = False
) -> MicrogeometryContact:
    """Loaded contact of pairs that differ in their initial gaps alone, at loads common to all.

    Parameters
    ----------
    segments : of one of them, by `contact_segments`.  pairs : (S,).
    loads : (F,) forces normal to the tooth, above 0 [N].  tangents : compute the tangent stiffness too.

    Raises
    ------
    ModelError : micro-geometry that does not fit its flank.
    """
    force = np.sort(np.atleast_1d(np.asarray(loads, dtype=float)))
    order = np.argsort(np.argsort(np.atleast_1d(np.asarray(loads, dtype=float)), kind="stable"))
    T, n = segments.gap.shape
    gaps = np.array([with_microgeometry(segments, pair).gap for pair in pairs]).reshape(-1, T, n)
    count = max(1, _AT_ONCE // (T * n * n))
    parts: list[dict[str, Array]] = []
    near: list[Array] = []
    for i in range(0, len(gaps), count):
        part, near = _solution(segments, gaps[i : i + count], force, tangents, near)
        parts.append(part)
    return MicrogeometryContact(**{name: np.concatenate([part[name] for part in parts])[:, order] for name in parts[0]})


def _solution(
    segments: ContactSegments, gaps: Array, loads: Array, tangents: bool, near: list[Array]
) -> tuple[dict[str, Array], list[Array]]:
    """Fields of `MicrogeometryContact` of initial gaps (S, T, n) [m] at rising loads (F,) [N].

    near : own approaches (T, n) [m] at each load of another micro-geometry, to start from, or none; those of the last
    one here are returned.
    """
    S, T, n = gaps.shape
    compliance = segments.compliance
    valid = np.broadcast_to(segments.valid, (S, T, n)).reshape(-1, n)
    gap, phase = gaps.reshape(-1, n), np.tile(np.arange(T), S)
    windows = line_windows(segments.pair.plane, segments.lines)

    def law(u: Array, index: Index) -> tuple[Array, Array]:
        return segments.law(u, phase[index])

    def inverse(force: Array) -> Array:
        return segments.own_approach(force, phase)

    found: list[tuple[ContactSolution, Array]] = []
    start: Array | None = None
    states: list[Array] = []
    for place, load in enumerate(loads):
        if near:
            start = np.tile(near[place], (S, 1))
        wanted = np.full(S * T, load)
        if segments.line is None:
            one = solve_linear(compliance, gap, valid, wanted, phase=phase)
            tangent = tangent_stiffness(compliance, one.active, phase=phase) if tangents else np.full(S * T, np.nan)
        else:
            one = solve_hertzian(compliance, gap, valid, wanted, law, start=start, inverse=inverse, phase=phase)
            start = one.approach[:, None] - gap - products(compliance, phase, one.force)
            tangent = np.full(S * T, np.nan)
            if tangents:
                tangent = tangent_stiffness(compliance, one.active, law(start, np.arange(S * T))[1], phase=phase)
            if not one.status.any():
                states.append(start[-T:])
        found.append((one, tangent))

    def shaped(values: list[Array]) -> Array:
        return np.moveaxis(np.array(values).reshape(len(loads), S, T), 0, 1)

    def largest(force: Array) -> Array:
        """Largest load per length (S T,) [N/m] of forces (S T, n) [N]."""
        return np.asarray(windows.mean(segments.spread(force.reshape(S, T, n))).max(axis=(2, 3)).ravel())

    fields = {
        "approach": shaped([one.approach for one, _ in found]),
        "tangent": shaped([tangent for _, tangent in found]),
        "largest_load": shaped([largest(one.force) for one, _ in found]).max(axis=2),
        "residual": shaped([one.residual for one, _ in found]).max(axis=2),
        "solved": shaped([one.status == "" for one, _ in found]).all(axis=2),
    }
    return fields, states if len(states) == len(loads) else []
