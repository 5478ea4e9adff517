"""Lattice of the mesh frequencies: combinations kept in the balance, their exact frequencies, products on them.

A point a = (a_1 .. a_D) stands for the frequency a . f.  A mesh depends on one tone, so its stiffness couples points
along that one axis: the lattice is a bundle of independent lines.  Points of equal frequency (tones in the ratio 3/7,
say) stay apart: the equation is linear on the torus of the tone phases, and theta = f t is one path on that torus
whatever the ratio.  Sums over time, as an RMS, add amplitudes of equal frequency first; frequencies are compared as
fractions (docs/design.md, exact frequencies).

Products of mesh stiffness and gap are exact convolutions of harmonics, along the axis of each mesh's tone.
Harmonics of P points are held as (m, P, 2 J): real and imaginary parts of J lattice points.  With one tone a product
is one small matrix a mesh; with several tones, one for the multiples of the tone and one for all other lines along
its axis.  Derived here: no aliasing, since no product is sampled.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import product as combinations
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray, Index, VaryingRows

Point = tuple[int, ...]
Integers = NDArray[np.object_]
_TINY = 1e-300
# Part of b b^T that those of other rows leave, below which a row is made of them.
_DEPENDENT = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lattice:
    """Lattice points kept.

    points : (J, D); of a real signal (`mirrored`) one of a and -a only, the origin first.
    own : of each axis (2 H + 1,) or, mirrored, (H + 1,): indices in `points` of the multiples of its tone, rising.
    """

    points: Index
    mirrored: bool
    own: tuple[Index, ...]

    @property
    def tones(self) -> int:
        """Number of tones D."""
        return int(self.points.shape[1])


class Bundle(NamedTuple):
    """Lines of lattice points along one axis that do not pass through the origin.

    rests : (lines, D) orders that the points of a line share, 0 along the axis.
    several : number of lines with more than one point; they come first.
    take : (lines, W) index of the point at -W/2 .. W/2 along the line, J where none is kept.
    mirror : (lines, W) -1 where the point is kept as its conjugate at -a, else 1.
    """

    rests: Index
    several: int
    take: Index
    mirror: Index


def kept_points(harmonics: tuple[int, ...], cross: int, *, mirrored: bool) -> Lattice:
    """Lattice of the multiples of each tone up to its harmonics, and of combinations up to a cross order.

    harmonics : highest multiple of each tone (D,).  cross : largest |a_1| + .. + |a_D| of a combination.
    """
    D = len(harmonics)
    origin, reach = (0,) * D, range(-cross, cross + 1)
    points = [_along(origin, j, a) for j, H in enumerate(harmonics) for a in range(-H, H + 1)]
    points += [p for p in combinations(reach, repeat=D) if sum(map(abs, p)) <= cross and sum(map(bool, p)) > 1]
    if mirrored:
        points = [point for point in points if leads(point)]
    ordered = sorted(set(points), key=lambda p: (any(p) if mirrored else False, p))
    place = {point: i for i, point in enumerate(ordered)}
    own = tuple(
        np.array([place[_along(origin, j, a)] for a in range(0 if mirrored else -H, H + 1)], dtype=np.int64)
        for j, H in enumerate(harmonics)
    )
    return Lattice(points=np.array(ordered, dtype=np.int64).reshape(-1, D), mirrored=mirrored, own=own)


def on_axis(points: Index, axis: int) -> NDArray[np.bool_]:
    """Which lattice points (K, D) are multiples of the tone of one axis alone, the origin included, (K,)."""
    return np.asarray(np.count_nonzero(np.delete(points, axis, axis=1), axis=1) == 0)


def _along(rest: Sequence[int], axis: int, order: int) -> Point:
    """The point `rest` with another order along one axis."""
    return (*rest[:axis], order, *rest[axis + 1 :])


def leads(point: Iterable[int]) -> bool:
    """Whether a point represents itself and its mirror image: its first order that is not 0 is positive."""
    return next((a for a in point if a), 1) > 0


def bundle(lattice: Lattice, axis: int) -> Bundle:
    """Lines of a lattice along an axis, all padded to one odd width W."""
    lines: dict[Point, list[tuple[int, int, int]]] = {}
    for place, point in enumerate(lattice.points if lattice.tones > 1 else ()):
        rest = point.copy()
        rest[axis] = 0
        if rest.any():
            # the mirror image of a line is the line of the mirrored rest: each is counted once
            sign = 1 if not lattice.mirrored or leads(rest) else -1
            lines.setdefault(tuple(sign * rest), []).append((place, int(sign * point[axis]), sign))
    order = sorted(lines, key=lambda rest: (len(lines[rest]) == 1, rest))
    half = max((abs(a) for members in lines.values() for _, a, _ in members), default=0)
    take = np.full((len(order), 2 * half + 1), len(lattice.points), dtype=np.int64)
    mirror = np.ones_like(take)
    for i, rest in enumerate(order):
        for place, a, sign in lines[rest]:
            take[i, half + a], mirror[i, half + a] = place, sign
    return Bundle(
        rests=np.array(order, dtype=np.int64).reshape(-1, lattice.tones),
        several=sum(len(members) > 1 for members in lines.values()),
        take=take,
        mirror=mirror,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineFrequencies:
    """Exact frequencies of R harmonics, of mesh orders and then of every shaft line, at the operating speed.

    omega : (R,) signed [rad/s].  unit : frequencies are whole multiples of 1/unit Hz.
    distinct : (F,) distinct magnitudes in that unit, exact, rising.  line : (R,) index in `distinct` of each harmonic.
    negative : (R,) the frequency is minus that of its line.  first : (F,) the first harmonic of each line.
    shared : (E,) harmonics that share a line with others, line by line; starts : (G,) where each of these lines starts.
    """

    omega: Array
    unit: int
    distinct: Integers
    line: Index
    negative: NDArray[np.bool_]
    first: Index
    shared: Index
    starts: Index

    @property
    def coincident(self) -> bool:
        """Whether several harmonics share a line."""
        return self.shared.size > 0

    @property
    def constant(self) -> NDArray[np.bool_]:
        """Harmonics of frequency 0 (R,), which make up the mean."""
        return np.asarray((self.distinct == 0).astype(bool)[self.line])

    def index_of(self, frequencies: Sequence[Fraction]) -> Index:
        """Index in `distinct` of each frequency [Hz] (L,), -1 where no harmonic has it."""
        wanted = [frequency * self.unit for frequency in frequencies]
        steps = np.array([int(f) for f in wanted], dtype=object)
        index = np.minimum(np.searchsorted(self.distinct, steps), max(self.distinct.size - 1, 0))
        known = [f.denominator == 1 and self.distinct[i] == f for f, i in zip(wanted, index, strict=True)]
        return np.where(np.array(known, dtype=bool), index, -1)

    def merged(self, values: ComplexArray) -> ComplexArray:
        """Amplitudes (..., R) with those of equal frequency added, (..., F): value = Re sum A_f exp(i w_f t)."""
        lines: ComplexArray = values[..., self.first]
        lines.imag *= np.where(self.negative[self.first], -1.0, 1.0)
        if self.coincident:
            lines[..., self.line[self.shared[self.starts]]] = self.merged_shared(values)
        return lines

    def merged_shared(self, values: ComplexArray) -> ComplexArray:
        """`merged` of the lines that several harmonics share alone, (..., R) to (..., G)."""
        shared = values[..., self.shared]
        shared.imag *= np.where(self.negative[self.shared], -1.0, 1.0)
        return np.add.reduceat(shared, self.starts, axis=-1)

    def power(self, values: ComplexArray, weight: Array) -> Array:
        """Sum of |A_f|^2 weight_f over the lines, weight (F,), amplitudes (..., R) of equal frequency added: (...)."""
        own = weight[self.line]
        own[self.shared] = 0.0
        total: Array = (values.real**2 + values.imag**2) @ own
        if self.coincident:
            lines = self.merged_shared(values)
            total += (lines.real**2 + lines.imag**2) @ weight[self.line[self.shared[self.starts]]]
        return total


def line_frequencies(steps: Integers, unit: int) -> LineFrequencies:
    """Lines of harmonics whose frequencies are `steps` (R,), whole multiples of 1/unit Hz."""
    distinct, first, line, count = np.unique(np.abs(steps), return_index=True, return_inverse=True, return_counts=True)
    order = np.argsort(line, kind="stable")
    shared = order[count[line[order]] > 1]
    return LineFrequencies(
        omega=2 * np.pi * (steps / unit).astype(float),
        unit=unit,
        distinct=distinct,
        line=line,
        negative=(steps < 0).astype(bool),
        first=first,
        shared=shared,
        starts=np.flatnonzero(np.diff(line[shared], prepend=-1)),
    )


def integer_frequencies(points: Index, tones: Sequence[Fraction], shifts: Sequence[Fraction], unit: int) -> Integers:
    """Frequencies a . tones + shift of points (K, D): (S, K) whole multiples of 1/unit Hz.

    tones, shifts : (D,) and (S,) [Hz]; one shift of 0 for mesh orders.
    """
    at = points.astype(object) @ np.array([int(tone * unit) for tone in tones], dtype=object)
    return np.asarray(np.add.outer(np.array([int(f * unit) for f in shifts], dtype=object), at))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gather:
    """Reordering of columns (..., C), some with the sign of their mirror image; column C reads 0.

    place : (...) column read.  sign : (...) +1 or -1.  mirrors : whether any sign is -1.
    """

    place: Index
    sign: Array
    mirrors: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Convolution:
    """From gap harmonics (2 J) to harmonics of the force of the meshes (m_j,) of one tone, at some lattice points.

    series : (m_j, 2 reach + 1) harmonics of k - k0, two-sided [N/m].  mirrored : of a real signal.
    own, lines : gap harmonics to the multiples of the tone (2 Jo) and to the other lines (lines, 2 W).
    own_orders, line_orders : orders of those harmonics, and of the harmonics of the force.
    back : multiples and lines, one after the other, to the points.
    """

    series: ComplexArray
    mirrored: bool
    own: Gather
    own_orders: tuple[Index, Index]
    lines: Gather
    line_orders: tuple[Index, Index]
    back: Gather

    @cached_property
    def own_matrix(self) -> Array:
        """(m_j, 2 Jo, 2 Jo') [N/m]: multiples of the tone @ it are those of the force."""
        return _convolution(self.series, *self.own_orders, mirrored=self.mirrored)

    @cached_property
    def line_matrix(self) -> Array:
        """(m_j, 2 W, 2 W') [N/m]: the same of the other lines."""
        return _convolution(self.series, *self.line_orders, mirrored=False)


class Axis(NamedTuple):
    """Convolutions of the meshes (m_j,) of one tone: to the J points kept, and to the T truncated ones.

    Towards these, lines of one point are among the lines.
    """

    meshes: Index
    kept: Convolution
    truncated: Convolution


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


def kernel(rows: VaryingRows, tone: Index, harmonics: tuple[int, ...], cross: int, *, mirrored: bool) -> Kernel:
    """Convolution matrices of the stiffness variation of meshes, and of links that pass a body.

    Parameters
    ----------
    tone : (v,) axis of each row.  harmonics : of each tone (D,).  cross : largest |a_1| + .. + |a_D| of a combination.
    mirrored : harmonics of a real signal, at a . f; else around a shaft frequency.
    """
    lattice = kept_points(harmonics, cross, mirrored=mirrored)
    D = lattice.tones
    bundles = [bundle(lattice, j) for j in range(D)]
    lengths = []  # harmonics of the stiffness of the meshes of each tone
    for j in range(D):
        used = np.flatnonzero(np.any(rows.wave[tone == j] != 0, axis=0))
        lengths.append(int(used[-1]) + 1 if used.size else 0)
    truncated = _truncated_points(lattice, bundles, lengths)
    axes = tuple(
        _axis(rows, np.flatnonzero(tone == j), lengths[j], lattice, bundles[j], truncated, j) for j in range(D)
    )
    several = np.count_nonzero(truncated, axis=1) != 1
    distinct, weight = _distinct_rows(rows.B, tone)
    return Kernel(
        lattice=lattice,
        truncated=truncated,
        truncated_kind=np.where(several, D, np.argmax(truncated != 0, axis=1)),
        axes=axes,
        joined=tuple(_joined(axis, weight) for axis in axes) if len(distinct) < len(tone) else axes,
        distinct=distinct,
    )


def _distinct_rows(B: Array, tone: Index) -> tuple[Index, Array]:
    """Mesh rows (r,) that those of their tone are made of, and weights w (r, m): b_m b_m^T = sum_r w_rm b_r b_r^T.

    So sum_m k_m b_m b_m^T is that of the r rows with sum_m w k_m, for any k_m(t); by pivoted QR of the b b^T.
    Both sides of a herringbone mesh are one where nothing tilts, slices along a face of two rigid bodies three.

    B : (n, m).
    """
    rows = B / np.maximum(np.max(np.abs(B), axis=1, keepdims=True), _TINY)  # moments and forces alike
    size = np.maximum(np.linalg.norm(rows, axis=0), _TINY)
    one, other = np.triu_indices(len(rows))
    dyads = (rows[one] * rows[other] * np.where(one == other, 1.0, np.sqrt(2.0))[:, None]) / size**2
    weight = np.zeros((tone.size, tone.size))
    for number in np.unique(tone):
        of = np.flatnonzero(tone == number)
        triangle, pivot = scipy.linalg.qr(dyads[:, of], mode="r", pivoting=True)
        rank = int(np.count_nonzero(np.abs(np.diag(triangle)) > _DEPENDENT))
        share = scipy.linalg.solve_triangular(triangle[:rank, :rank], triangle[:rank])
        kept, every = of[pivot[:rank]], of[pivot]
        weight[np.ix_(kept, every)] = share * (size[every] / size[kept, None]) ** 2
    distinct = np.flatnonzero(np.any(weight, axis=1))
    return distinct, weight[distinct]


def _joined(axis: Axis, weight: Array) -> Axis:
    """An axis whose rows are sums of the meshes by weights (r, m)."""
    rows = np.flatnonzero(np.any(weight[:, axis.meshes], axis=1))
    series = weight[np.ix_(rows, axis.meshes)] @ axis.kept.series
    return Axis(rows, replace(axis.kept, series=series), replace(axis.truncated, series=series))


def _truncated_points(lattice: Lattice, bundles: Sequence[Bundle], lengths: Sequence[int]) -> Index:
    """Points (T, D) that some product reaches and that are not kept, one of a and -a of a real signal."""
    kept = {tuple(point) for point in lattice.points.tolist()}
    truncated: dict[Point, None] = {}
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
            if point not in kept and not (lattice.mirrored and (opposite in kept or opposite in truncated)):
                truncated[point] = None
    return np.array(list(truncated), dtype=np.int64).reshape(-1, lattice.tones)


def _axis(rows: VaryingRows, meshes: Index, L: int, lattice: Lattice, lines: Bundle, truncated: Index, j: int) -> Axis:
    """Convolution matrices of the meshes (m_j,) of axis j, towards the points kept and the truncated ones (T, D).

    L : harmonics of their stiffness.
    """
    H, half = (len(lattice.own[j]) - 1) // (1 if lattice.mirrored else 2), lines.take.shape[1] // 2
    series = stiffness_series(rows, meshes, L, reach=2 * max(H, half) + L)
    upper = np.arange(H + 1, H + L + 1)
    own = np.arange(0 if lattice.mirrored else -H, H + 1)
    own_truncated = upper if lattice.mirrored else np.concatenate([-upper[::-1], upper])
    width, wide = np.arange(-half, half + 1), np.arange(-half - L, half + L + 1)
    J = len(lattice.points)
    take, mirror = lines.take[: lines.several], lines.mirror[: lines.several]
    origin = (0,) * lattice.tones
    out = [(origin, own), *((tuple(rest), width) for rest in lines.rests[: lines.several])]
    truncated_lines = [(origin, own_truncated), *((tuple(rest), wide) for rest in lines.rests)]
    own_gap = _parts(lattice.own[j], np.ones(own.size), J)
    of_axis = partial(Convolution, series=series, mirrored=lattice.mirrored, own=own_gap)
    kept = of_axis(
        own_orders=(own, own),
        lines=_parts(take, mirror, J),
        line_orders=(width, width),
        back=_back(lattice.points, out, j, mirrored=lattice.mirrored),
    )
    beyond = of_axis(
        own_orders=(own, own_truncated),
        lines=_parts(lines.take, lines.mirror, J),
        line_orders=(width, wide),
        back=_back(truncated, truncated_lines, j, mirrored=lattice.mirrored),
    )
    return Axis(meshes, kept, beyond)


def stiffness_series(rows: VaryingRows, meshes: Index, L: int, *, reach: int) -> ComplexArray:
    """Two-sided harmonics -reach .. reach of k - k0, (m_j, 2 reach + 1) [N/m]."""
    half = rows.wave[meshes, :L] / 2
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
        if (slot := slots.get(tuple(point))) is not None:
            place[:, i] = slot
        elif mirrored and (slot := slots.get(tuple(-a for a in point))) is not None:
            place[:, i], sign[1, i] = slot, -1.0
    return _gather(place.ravel(), sign.ravel())


def _convolution(series: ComplexArray, given: Index, wanted: Index, *, mirrored: bool) -> Array:
    """Real form (m, 2 J_given, 2 J_wanted) of p_h = sum_j kappa_(h-j) d_j + kappa_(h+j) conj(d_j) [N/m].

    series : (m, 2 reach + 1) kappa, two-sided.  Of a real signal (`mirrored`) harmonic 0 is half of that and real.
    """
    centre, m, G, W = series.shape[1] // 2, len(series), given.size, wanted.size
    parts = np.stack([series.real, series.imag])
    real, imag = parts.take(centre + wanted[None, :] - given[:, None], axis=2)
    out = np.empty((m, 2, G, 2, W))
    out[:, 0, :, 0], out[:, 0, :, 1], out[:, 1, :, 0], out[:, 1, :, 1] = real, imag, -imag, real
    if mirrored:
        real, imag = parts.take(centre + wanted[None, :] + given[:, None], axis=2)
        out[:, 0, :, 0] += real
        out[:, 0, :, 1] += imag
        out[:, 1, :, 0] += imag
        out[:, 1, :, 1] -= real
        out[:, :, :, 0, wanted == 0] /= 2
        out[:, :, :, 1, wanted == 0] = 0
        out[:, 1, given == 0] = 0
    return out.reshape(m, 2 * G, 2 * W)


def product(kernel: Kernel, gap: Array, *, joined: bool = False) -> Array:
    """(k(t) - k0) gap(t) at the points kept: gap (m, P, 2 J) [m] to (m, P, 2 J) [N], of the first rows or of all.

    joined : of the `distinct` gaps (r, P, 2 J) to the sums of the forces of their rows.
    """
    axes = kernel.joined if joined else kernel.axes
    return _product([(axis.meshes, axis.kept) for axis in axes], gap, np.empty_like(gap))


def truncated_product(kernel: Kernel, gap: Array, *, joined: bool = False) -> Array:
    """(k(t) - k0) gap(t) at the truncated points: gap (m, P, 2 J) [m] to (m, P, 2 T) [N]; joined : as of `product`."""
    out, axes = np.empty((*gap.shape[:2], 2 * len(kernel.truncated))), kernel.joined if joined else kernel.axes
    return _product([(axis.meshes, axis.truncated) for axis in axes], gap, out)


def _product(parts: Sequence[tuple[Index, Convolution]], gap: Array, out: Array) -> Array:
    """Convolutions of the meshes of every tone, gap (m, P, 2 J) [m] to [N], entered in out where tones are several."""
    if len(parts) == 1:
        return np.asarray(np.matmul(gap, parts[0][1].own_matrix))
    for meshes, through in parts:
        if meshes.size and meshes[-1] < len(gap):
            out[meshes] = _convolved(gap[meshes], through)
    return out


def to_real(values: ComplexArray) -> Array:
    """Real and imaginary parts side by side: (..., J) complex to (..., 2 J)."""
    return np.concatenate([values.real, values.imag], axis=-1)


def to_complex(parts: Array) -> ComplexArray:
    """Inverse of `to_real`: (..., 2 J) to (..., J) complex."""
    half = parts.shape[-1] // 2
    return parts[..., :half] + 1j * parts[..., half:]


def _convolved(rows: Array, through: Convolution) -> Array:
    """Gathered columns of rows (m, P, C), the lines times one matrix a mesh, and gathered again."""
    m, P, C = rows.shape
    padded = np.zeros((m, P, C + 1))  # the last column reads 0
    padded[:, :, :-1] = rows
    picked, (given, wide) = _gathered(padded, through.lines), through.line_matrix.shape[1:]
    own, count = _gathered(padded, through.own) @ through.own_matrix, through.lines.place.size // given
    first = own.shape[2]
    result = np.empty((m, P, first + count * wide + 1))
    result[:, :, :first], result[:, :, -1] = own, 0.0
    out = result[:, :, first:-1].reshape(m, P, count, wide)
    np.matmul(picked.reshape(m, P, count, given), through.line_matrix[:, None], out=out)
    return _gathered(result, through.back)


def _gathered(rows: Array, gather: Gather) -> Array:
    """Columns of (m, P, C) in the order and with the signs of a gather."""
    picked: Array = np.take(rows, gather.place, axis=2)
    if gather.mirrors:
        picked *= gather.sign
    return picked
