"""Loaded contact of many micro-geometries of one pair at once: they share the compliance, only their gaps differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import hertz
from .pair import ContactPair
from .segments import ContactSegments, with_microgeometry
from .solve import ContactSolution, solve_hertzian, solve_linear, tangent_stiffness

__all__ = ["MicrogeometryContact", "microgeometry_contact"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Matrices of so many entries are solved at once; more only moves memory.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MicrogeometryContact:
    """Contact of S micro-geometries at F loads and T phases.

    approach : (S, F, T) along the normal [m].  tangent : (S, F, T) dF/dd [N/m]; nan where not asked for.
    largest_load : (S, F) force per length, slivers left out as in `PairResult.whole` [N/m].
    residual : (S, F) of the contact conditions [1].  solved : (S, F) whether every phase was.
    """

    approach: Array
    tangent: Array
    largest_load: Array
    residual: Array
    solved: NDArray[np.bool_]


def microgeometry_contact(
    segments: ContactSegments, pairs: Sequence[ContactPair], loads: ArrayLike, *, tangents: bool = False
) -> MicrogeometryContact:
    """Contact of pairs that differ in their gaps alone, at loads that all bear.

    Parameters
    ----------
    segments : of one of them, as `contact_segments` cuts it.  pairs : (S,).
    loads : (F,) forces normal to the tooth, above 0 [N].  tangents : whether their stiffness is asked for.

    Raises
    ------
    ModelError : micro-geometry that does not fit its flank.
    """
    force = np.sort(np.atleast_1d(np.asarray(loads, dtype=float)))
    order = np.argsort(np.argsort(np.atleast_1d(np.asarray(loads, dtype=float)), kind="stable"))
    T, n = segments.gap.shape
    gaps = np.array([with_microgeometry(segments, pair).gap for pair in pairs]).reshape(-1, T, n)
    count = max(1, _AT_ONCE // (T * n * n))
    parts = [_solved(segments, gaps[i : i + count], force, tangents) for i in range(0, len(gaps), count)]
    return MicrogeometryContact(**{name: np.concatenate([part[name] for part in parts])[:, order] for name in parts[0]})


def _solved(segments: ContactSegments, gaps: Array, loads: Array, tangents: bool) -> dict[str, Array]:
    S, T, n = gaps.shape
    compliance = np.broadcast_to(segments.compliance, (S, T, n, n)).reshape(-1, n, n)
    valid = np.broadcast_to(segments.valid, (S, T, n)).reshape(-1, n)
    gap, phase = gaps.reshape(-1, n), np.tile(np.arange(T), S)
    length = np.where(_whole(segments), segments.length, np.inf)[phase]
    own = segments.contact
    line = hertz.LineContact(A=own.A, B=own.B[phase], radius=own.radius[phase])

    def law(u: Array, index: Index) -> tuple[Array, Array]:
        p, slope = hertz.load(hertz.LineContact(A=line.A, B=line.B[index], radius=line.radius[index]), u)
        width = segments.length[phase[index]]
        return p * width, slope * width

    found: list[tuple[ContactSolution, Array]] = []
    start: Array | None = None
    for load in loads:
        wanted = np.full(S * T, load)
        if segments.line is None:
            one = solve_linear(compliance, gap, valid, wanted)
            tangent = tangent_stiffness(compliance, one.active) if tangents else np.full(S * T, np.nan)
        else:
            one = solve_hertzian(compliance, gap, valid, wanted, law, start=start)
            start = one.approach[:, None] - gap - np.matmul(compliance, one.force[:, :, None])[:, :, 0]
            tangent = np.full(S * T, np.nan)
            if tangents:
                tangent = tangent_stiffness(compliance, one.active, law(start, np.arange(S * T))[1])
        found.append((one, tangent))

    def shaped(values: list[Array]) -> Array:
        return np.moveaxis(np.array(values).reshape(len(loads), S, T), 0, 1)

    return {
        "approach": shaped([one.approach for one, _ in found]),
        "tangent": shaped([tangent for _, tangent in found]),
        "largest_load": shaped([(one.force / length).max(axis=1) for one, _ in found]).max(axis=2),
        "residual": shaped([one.residual for one, _ in found]).max(axis=2),
        "solved": shaped([one.status == "" for one, _ in found]).all(axis=2),
    }


def _whole(segments: ContactSegments) -> NDArray[np.bool_]:
    """Segments (T, n) of which at least half is on the path of contact."""
    plane = segments.pair.plane
    full = segments.lines.span / np.cos(plane.base_helix)
    return np.asarray(segments.valid & (segments.length >= 0.5 * full * (1 - 1e-9)))
