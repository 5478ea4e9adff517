"""Loaded contact of many micro-geometries of one pair at once: they share the compliance, only their gaps differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..gears.flank import Flank
from . import hertz
from .pieces import Pair, Pieces, reshaped
from .solve import Loaded, hertzian, linear, tangent_stiffness

__all__ = ["Shapes", "even_across", "shapes_loaded"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Matrices of so many entries are solved at once; more only moves memory.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shapes:
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


def even_across(pair: Pair) -> bool:
    """Whether nothing differs along the face, so that one piece is as good as many."""
    plane = pair.plane
    even = all(flank.crown == 0 and flank.slope == 0 and flank.end_relief is None for flank in _flanks(pair))
    same = plane.base_helix == 0 and plane.face_a == plane.face_b
    stiff = pair.torsion_a is None and pair.torsion_b is None
    return even and same and stiff and pair.misalignment == 0 and not pair.gap


def _flanks(pair: Pair) -> tuple[Flank, Flank]:
    return pair.flank_a, pair.flank_b


def shapes_loaded(pieces: Pieces, pairs: Sequence[Pair], loads: ArrayLike, *, tangents: bool = False) -> Shapes:
    """Contact of pairs that differ in their gaps alone, at loads that all bear.

    Parameters
    ----------
    pieces : of one of them, as `pieces_of` cuts it.  pairs : (S,).
    loads : (F,) forces normal to the tooth, above 0 [N].  tangents : whether their stiffness is asked for.

    Raises
    ------
    ModelError : micro-geometry that does not fit its flank.
    """
    force = np.sort(np.atleast_1d(np.asarray(loads, dtype=float)))
    order = np.argsort(np.argsort(np.atleast_1d(np.asarray(loads, dtype=float)), kind="stable"))
    T, n = pieces.gap.shape
    gaps = np.array([reshaped(pieces, pair).gap for pair in pairs]).reshape(-1, T, n)
    count = max(1, _AT_ONCE // (T * n * n))
    parts = [_solved(pieces, gaps[i : i + count], force, tangents) for i in range(0, len(gaps), count)]
    return Shapes(**{name: np.concatenate([part[name] for part in parts])[:, order] for name in parts[0]})


def _solved(pieces: Pieces, gaps: Array, loads: Array, tangents: bool) -> dict[str, Array]:
    S, T, n = gaps.shape
    compliance = np.broadcast_to(pieces.compliance, (S, T, n, n)).reshape(-1, n, n)
    valid = np.broadcast_to(pieces.valid, (S, T, n)).reshape(-1, n)
    gap, phase = gaps.reshape(-1, n), np.tile(np.arange(T), S)
    length = np.where(_whole(pieces), pieces.length, np.inf)[phase]
    own = pieces.contact
    line = hertz.Line(A=own.A, B=own.B[phase], radius=own.radius[phase])

    def law(u: Array, index: Index) -> tuple[Array, Array]:
        p, slope = hertz.load(hertz.Line(A=line.A, B=line.B[index], radius=line.radius[index]), u)
        width = pieces.length[phase[index]]
        return p * width, slope * width

    found: list[tuple[Loaded, Array]] = []
    start: Array | None = None
    for load in loads:
        wanted = np.full(S * T, load)
        if pieces.line is None:
            one = linear(compliance, gap, valid, wanted)
            tangent = tangent_stiffness(compliance, one.active) if tangents else np.full(S * T, np.nan)
        else:
            one = hertzian(compliance, gap, valid, wanted, law, start=start)
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


def _whole(pieces: Pieces) -> NDArray[np.bool_]:
    """Pieces (T, n) of which at least half is on the path of contact."""
    plane = pieces.pair.plane
    full = pieces.lines.span / np.cos(plane.base_helix)
    return np.asarray(pieces.valid & (pieces.length >= 0.5 * full * (1 - 1e-9)))
