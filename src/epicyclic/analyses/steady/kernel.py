"""Products of mesh stiffness and gap as exact convolutions of harmonics, along the axis of each mesh's tone.

Harmonics of P points are held as (m, P, 2 J): real and imaginary parts of J lattice points.  With one tone a product
is one small matrix a mesh; with several tones, one for the multiples of the tone and one for all other lines along
its axis.  Derived here: no aliasing, since no product is sampled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray, System
from .lattice import Bundle, Lattice, Point, bundle, kept_points

__all__ = ["Axis", "Gather", "Kernel", "kernel", "product", "to_complex", "to_real", "truncated_product"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gather:
    """Reordering of columns (..., C), some with the sign of their mirror image; column C reads 0.

    place : (...) column read.  sign : (...) +1 or -1.  mirrors : whether any sign is -1.
    """

    place: Index
    sign: Array
    mirrors: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """Convolution matrices of the meshes of one tone.

    meshes : (m_j,) mesh rows of this tone.
    own, lines : gap harmonics (2 J) to the multiples of the tone (2 Jo) and to the other lines (lines, 2 W).
    own_product (m_j, 2 Jo, 2 Jo), line_product (m_j, 2 W, 2 W) : those harmonics @ them = harmonics of the force [N/m].
    back : multiples and lines, one after the other, to harmonics (2 J).
    every, own_tail, line_tail, tail_back : the same towards the T truncated points, lines of one point included.
    """

    meshes: Index
    own: Gather
    lines: Gather
    own_product: Array
    line_product: Array
    back: Gather
    every: Gather
    own_tail: Array
    line_tail: Array
    tail_back: Gather


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Kernel:
    """Products with k_m(t) - k0_m for the harmonics of a lattice.

    lattice : points kept.  truncated : (T, D) points that a product reaches beyond them.
    truncated_kind : (T,) the axis of a truncated point that is a multiple of one tone, D of a combination.
    axes : one a tone.  joined : the same for sums of mesh rows that one gap and one push serve; their `meshes` count
        the rows `distinct` (r,) of all meshes, one of each such sum.
    """

    lattice: Lattice
    truncated: Index
    truncated_kind: Index
    axes: tuple[Axis, ...]
    joined: tuple[Axis, ...]
    distinct: Index


def kernel(system: System, tone: Index, harmonics: tuple[int, ...], cross: int, *, mirrored: bool) -> Kernel:
    """Convolution matrices of the mesh stiffness variation.

    Parameters
    ----------
    tone : (m,) axis of each mesh.  harmonics : of each tone (D,).  cross : largest |a_1| + .. + |a_D| of a combination.
    mirrored : harmonics of a real signal, at a . f; else around a shaft frequency.
    """
    lattice = kept_points(harmonics, cross, mirrored=mirrored)
    D = lattice.tones
    bundles = [bundle(lattice, j) for j in range(D)]
    lengths = [_length(system, tone == j) for j in range(D)]
    truncated = _truncated_points(lattice, bundles, lengths)
    axes = tuple(
        _axis(system, np.flatnonzero(tone == j), lengths[j], lattice, bundles[j], truncated, j) for j in range(D)
    )
    several = np.count_nonzero(truncated, axis=1) != 1
    truncated_kind = (
        np.where(several, D, np.argmax(truncated != 0, axis=1)) if truncated.size else np.zeros(0, np.int64)
    )
    distinct, owner = _distinct_rows(system.meshes.B, tone)
    return Kernel(
        lattice=lattice,
        truncated=truncated,
        truncated_kind=truncated_kind,
        axes=axes,
        joined=tuple(_joined(axis, owner) for axis in axes) if len(distinct) < len(owner) else axes,
        distinct=distinct,
    )


def _distinct_rows(B: Array, tone: Index) -> tuple[Index, Index]:
    """Mesh rows with a column of B (n, m) and a tone (m,) of their own, (r,), and for each mesh which of them, (m,).

    Both sides of a herringbone mesh are one where nothing tilts.
    """
    columns = np.vstack([tone, B]).T + 0.0  # -0 is 0
    found: dict[bytes, int] = {}
    owner = [found.setdefault(column.tobytes(), len(found)) for column in columns]
    first = [owner.index(place) for place in range(len(found))]
    return np.array(first, np.int64), np.array(owner, np.int64)


def _joined(axis: Axis, owner: Index) -> Axis:
    """An axis whose rows are sums of the meshes with one owner (m,)."""
    mine, place = np.unique(owner[axis.meshes], return_inverse=True)

    def total(matrices: Array) -> Array:
        result = np.zeros((mine.size, *matrices.shape[1:]))
        np.add.at(result, place, matrices)
        return result

    return replace(
        axis,
        meshes=mine,
        own_product=total(axis.own_product),
        line_product=total(axis.line_product),
        own_tail=total(axis.own_tail),
        line_tail=total(axis.line_tail),
    )


def _length(system: System, mine: NDArray[np.bool_]) -> int:
    """Number of harmonics of the stiffness of the meshes marked in `mine` (m,)."""
    used = np.flatnonzero(np.any(system.meshes.variation[mine] != 0, axis=0))
    return int(used[-1]) + 1 if used.size else 0


def _truncated_points(lattice: Lattice, bundles: Sequence[Bundle], lengths: Sequence[int]) -> Index:
    """Points (T, D) that some product reaches and that are not kept, one of a and -a of a real signal."""
    kept = {tuple(point) for point in lattice.points.tolist()}
    found: dict[Point, None] = {}
    for axis, (lines, L) in enumerate(zip(bundles, lengths, strict=True)):
        top = len(lattice.own[axis]) - 1 if lattice.mirrored else len(lattice.own[axis]) // 2
        ends = [top + step for step in range(1, L + 1)]
        origin = (0,) * lattice.tones
        reached = [_along(origin, axis, a) for a in ([] if lattice.mirrored else [-a for a in ends[::-1]]) + ends]
        half = lines.take.shape[1] // 2
        for rest, take in zip(lines.rests.tolist(), lines.take, strict=True):
            at = np.flatnonzero(take < len(lattice.points)) - half
            reached += [_along(rest, axis, a) for a in range(at[0] - L, at[-1] + L + 1)]
        for point in reached:
            opposite = tuple(-a for a in point)
            if point not in kept and not (lattice.mirrored and (opposite in kept or opposite in found)):
                found[point] = None
    return np.array(list(found), dtype=np.int64).reshape(-1, lattice.tones)


def _along(rest: Sequence[int], axis: int, order: int) -> Point:
    """The point `rest` with another order along one axis."""
    return (*rest[:axis], order, *rest[axis + 1 :])


def _axis(system: System, meshes: Index, L: int, lattice: Lattice, lines: Bundle, truncated: Index, j: int) -> Axis:
    """Convolution matrices of the meshes (m_j,) of axis j, towards the points kept and the truncated ones (T, D).

    L : harmonics of their stiffness.
    """
    H, half = (len(lattice.own[j]) - 1) // (1 if lattice.mirrored else 2), lines.take.shape[1] // 2
    series = _series(system, meshes, L, reach=2 * max(H, half) + L)
    upper = np.arange(H + 1, H + L + 1)
    own = np.arange(0 if lattice.mirrored else -H, H + 1)
    own_truncated = upper if lattice.mirrored else np.concatenate([-upper[::-1], upper])
    width, wide = np.arange(-half, half + 1), np.arange(-half - L, half + L + 1)
    J = len(lattice.points)
    take, mirror = lines.take[: lines.several], lines.mirror[: lines.several]
    out = [(tuple(np.zeros(lattice.tones, int)), own), *((tuple(rest), width) for rest in lines.rests[: lines.several])]
    truncated_lines = [
        (tuple(np.zeros(lattice.tones, int)), own_truncated),
        *((tuple(rest), wide) for rest in lines.rests),
    ]
    return Axis(
        meshes=meshes,
        own=_parts(lattice.own[j], np.ones(own.size), J),
        lines=_parts(take, mirror, J),
        own_product=_convolution(series, own, own, mirrored=lattice.mirrored),
        line_product=_convolution(series, width, width, mirrored=False),
        back=_back(lattice.points, out, j, mirrored=lattice.mirrored),
        every=_parts(lines.take, lines.mirror, J),
        own_tail=_convolution(series, own, own_truncated, mirrored=lattice.mirrored),
        line_tail=_convolution(series, width, wide, mirrored=False),
        tail_back=_back(truncated, truncated_lines, j, mirrored=lattice.mirrored),
    )


def _series(system: System, meshes: Index, L: int, *, reach: int) -> ComplexArray:
    """Two-sided harmonics -reach .. reach of k - k0, (m_j, 2 reach + 1) [N/m]."""
    half = system.meshes.stiffness[meshes, None] * system.meshes.variation[meshes, :L] / 2
    series = np.zeros((len(meshes), 2 * reach + 1), complex)
    series[:, reach + 1 : reach + 1 + L] = half
    series[:, reach - L : reach] = half[:, ::-1].conj()
    return series


def _parts(take: Index, mirror: Array | Index, J: int) -> Gather:
    """Gather of real and imaginary parts, side by side, of points `take` (..., W); J marks a point not kept."""
    imaginary = np.where(take < J, take + J, 2 * J)
    real = np.where(take < J, take, 2 * J)
    sign = np.concatenate([np.ones(mirror.shape), mirror], axis=-1)
    return _gather(np.concatenate([real, imaginary], axis=-1), sign)


def _gather(place: Index, sign: Array) -> Gather:
    """A gather of columns `place` with signs, both (...)."""
    return Gather(place=place, sign=sign, mirrors=bool(np.any(sign < 0)))


def _back(points: Index, lines: Sequence[tuple[Point, Index]], axis: int, *, mirrored: bool) -> Gather:
    """Gather of given points (T, D) from lines (rest, orders), each line written as its real, then imaginary parts."""
    slots: dict[Point, tuple[int, int]] = {}
    first = 0
    for rest, orders in lines:
        for i, a in enumerate(orders.tolist()):
            slots[_along(rest, axis, a)] = (first + i, first + i + orders.size)
        first += 2 * orders.size
    place, sign = np.full((2, len(points)), first, dtype=np.int64), np.ones((2, len(points)))
    for i, point in enumerate(points.tolist()):
        if (found := slots.get(tuple(point))) is not None:
            place[:, i] = found
        elif mirrored and (found := slots.get(tuple(-a for a in point))) is not None:
            place[:, i], sign[1, i] = found, -1.0
    return _gather(place.ravel(), sign.ravel())


def _convolution(series: ComplexArray, given: Index, wanted: Index, *, mirrored: bool) -> Array:
    """Real form (m, 2 J_given, 2 J_wanted) of p_h = sum_j kappa_(h-j) d_j + kappa_(h+j) conj(d_j) [N/m].

    series : (m, 2 reach + 1) kappa, two-sided.  Of a real signal (`mirrored`) harmonic 0 is half of that and real.
    """
    centre = series.shape[1] // 2
    direct = series[:, centre + wanted[None, :] - given[:, None]]
    folded = series[:, centre + wanted[None, :] + given[:, None]] if mirrored else np.zeros_like(direct)
    real = np.concatenate([direct.real + folded.real, folded.imag - direct.imag], axis=1)
    imag = np.concatenate([direct.imag + folded.imag, direct.real - folded.real], axis=1)
    if mirrored:
        real[:, :, wanted == 0] /= 2
        imag[:, :, wanted == 0] = 0
        imag[:, given.size + np.flatnonzero(given == 0)] = real[:, given.size + np.flatnonzero(given == 0)] = 0
    return np.ascontiguousarray(np.concatenate([real, imag], axis=2))


def product(kernel: Kernel, gap: Array, *, joined: bool = False) -> Array:
    """(k(t) - k0) gap(t) at the points kept: gap (m, P, 2 J) [m] to (m, P, 2 J) [N].

    joined : of the `distinct` gaps (r, P, 2 J) to the sums of the forces of their rows.
    """
    axes = kernel.joined if joined else kernel.axes
    if len(axes) == 1:
        only: Array = np.matmul(gap, axes[0].own_product)
        return only
    out = np.empty_like(gap)
    for axis in axes:
        mine = _padded(gap, axis.meshes)
        parts = (axis.own, axis.own_product), (axis.lines, axis.line_product)
        out[axis.meshes] = _gathered(_times(mine, parts), axis.back)
    return out


def truncated_product(kernel: Kernel, gap: Array) -> Array:
    """(k(t) - k0) gap(t) at the truncated points: gap (m, P, 2 J) [m] to (m, P, 2 T) [N]."""
    if len(kernel.axes) == 1:
        only: Array = np.matmul(gap, kernel.axes[0].own_tail)
        return only
    out = np.empty((*gap.shape[:2], 2 * len(kernel.truncated)))
    for axis in kernel.axes:
        mine = _padded(gap, axis.meshes)
        parts = (axis.own, axis.own_tail), (axis.every, axis.line_tail)
        out[axis.meshes] = _gathered(_times(mine, parts), axis.tail_back)
    return out


def to_real(values: ComplexArray) -> Array:
    """Real and imaginary parts side by side: (..., J) complex to (..., 2 J)."""
    return np.concatenate([values.real, values.imag], axis=-1)


def to_complex(parts: Array) -> ComplexArray:
    """Inverse of `to_real`: (..., 2 J) to (..., J) complex."""
    half = parts.shape[-1] // 2
    value: ComplexArray = parts[..., :half] + 1j * parts[..., half:]
    return value


def _padded(rows: Array, mine: Index) -> Array:
    """Some rows of (m, P, C), with a column of zeros at the end."""
    padded = np.empty((mine.size, rows.shape[1], rows.shape[2] + 1))
    padded[:, :, :-1] = rows[mine]
    padded[:, :, -1] = 0.0
    return padded


def _gathered(rows: Array, gather: Gather) -> Array:
    """Columns of (m, P, C) in the order and with the signs of a gather."""
    picked: Array = np.take(rows, gather.place, axis=2)
    if gather.mirrors:
        picked *= gather.sign
    return picked


def _times(rows: Array, parts: Sequence[tuple[Gather, Array]]) -> Array:
    """Gathered columns times one matrix a mesh, lines one after the other, part by part, then a column of zeros.

    rows : (m, P, C).  parts : gather and matrices (m, W, W') of each.
    """
    m, P = rows.shape[:2]
    lines = [gather.place.size // matrix.shape[1] for gather, matrix in parts]
    sizes = [count * matrix.shape[2] for count, (_, matrix) in zip(lines, parts, strict=True)]
    result, first = np.empty((m, P, sum(sizes) + 1)), 0
    for count, size, (gather, matrix) in zip(lines, sizes, parts, strict=True):
        picked = _gathered(rows, gather).reshape(m, P, count, matrix.shape[1])
        out = result[:, :, first : first + size].reshape(m, P, count, matrix.shape[2])
        np.matmul(picked, matrix[:, None], out=out)
        first += size
    result[:, :, -1] = 0.0
    return result
