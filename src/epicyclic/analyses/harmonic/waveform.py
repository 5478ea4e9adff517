"""From solved rows to what happens in time: spectra of mesh forces and displacements, waves over the mesh phases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...system.faces import Faces, faces
from ...system.system import Array, ComplexArray
from .balance import Solved
from .kernel import product, tail
from .lattice import Lattice, bundle
from .response import Block, Response

__all__ = [
    "Envelopes",
    "Spectrum",
    "envelopes",
    "force_spectrum",
    "mean_square",
    "mesh_axis",
    "motion_spectrum",
    "on_torus",
    "own_waves",
    "peak",
    "samples_needed",
    "valley",
    "whole",
]

Index = NDArray[np.int64]
Values = NDArray[Any]  # real or complex


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrum:
    """One-sided amplitudes: value = Re sum_s exp(i w_s t) sum_a amplitude[..., s, a] exp(2 pi i a . theta).

    amplitude : (rows, P, S, K) complex; S = 1 without a shaft frequency.
    points : (K, D) a.  mirrored : a real signal, one of a and -a.
    """

    amplitude: ComplexArray
    points: Index
    mirrored: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Envelopes:
    """Everything but the multiples of one tone, gathered modulo that tone.

    rests : (R, D) orders of the other tones.  shaft : (R,) number of the shaft line, -1 of mesh orders.
    values : (rows, P, R, Nt) complex over the phase of the tone.
    """

    rests: Index
    shaft: Index
    values: ComplexArray


def force_spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    """Mesh force k(t) (B^T q - e) + c d/dt(...) [N], rows dropped included."""
    solved = _solved(block, shifted)
    made, meshes = ready.kernel(block.kept, shifted=shifted), ready.system.meshes
    gap = solved.gap
    force = _complex(product(made, gap) + meshes.stiffness[:, None, None] * gap)
    if meshes.damping.any():
        force += 1j * meshes.damping[:, None, None] * solved.frequency * _complex(gap)
    return Spectrum(
        amplitude=_by_speed(np.concatenate([force, _complex(tail(made, gap))], axis=2), block),
        points=np.concatenate([made.lattice.points, made.dropped]),
        mirrored=not shifted,
    )


def whole(rows: Spectrum, face: Faces) -> Spectrum:
    """Forces of whole meshes from those of their slices."""
    return replace(rows, amplitude=face.total(rows.amplitude))


def mesh_axis(ready: Response) -> Index:
    """The tone each whole mesh follows, (w,)."""
    axis: Index = ready.lines.axis[faces(ready.system.meshes).first]
    return axis


def motion_spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    """Coordinates [m, rad]."""
    P, _, J, n = _solved(block, shifted).y.shape
    q = (ready.modal.shapes @ _solved(block, shifted).y.reshape(-1, n).T).reshape(n, P, 2 * J)
    points = ready.kernel(block.kept, shifted=shifted).lattice.points
    return Spectrum(amplitude=_by_speed(_complex(q), block), points=points, mirrored=not shifted)


def _solved(block: Block, shifted: bool) -> Solved:
    solved = block.shaft if shifted else block.mesh
    if solved is None:
        raise ValueError("no shaft lines were solved")
    return solved


def _complex(both: Array) -> ComplexArray:
    half = both.shape[-1] // 2
    value: ComplexArray = both[..., :half] + 1j * both[..., half:]
    return value


def _by_speed(values: ComplexArray, block: Block) -> ComplexArray:
    return values.reshape(values.shape[0], block.speed.size, -1, values.shape[-1])


def mean_square(ready: Response, block: Block, spectra: Sequence[Spectrum]) -> Array:
    """Mean square of mesh forces over all time without the mean, (m, P), by Parseval.

    spectra : of mesh orders, and of shaft orders where they count.  Amplitudes of exactly equal frequency are one line.
    """
    rows, P = spectra[0].amplitude.shape[:2]
    values = np.concatenate([spectrum.amplitude.reshape(rows, P, -1) for spectrum in spectra], axis=2)
    fold = ready.fold(block.kept, shafts=len(spectra) > 1)
    if fold.merged:
        values[:, :, fold.backwards] = values[:, :, fold.backwards].conj()
        lines = np.zeros((rows, P, fold.moving.size), complex)
        np.add.at(lines.transpose(2, 0, 1), fold.line, values.transpose(2, 0, 1))
        values = lines
    square: Array = (values.real**2 + values.imag**2) @ fold.moving / 2
    return square


def own_waves(spectrum: Spectrum, axis: int, theta: Array, *, mean: bool = True) -> Values:
    """The multiples of one tone alone, over its phase theta (Nt,): (rows, P, S, Nt), real of a real signal.

    mean : whether order 0 is one of them.
    """
    own = np.count_nonzero(np.delete(spectrum.points, axis, axis=1), axis=1) == 0
    if not mean:
        own &= spectrum.points[:, axis] != 0
    amplitude = spectrum.amplitude if own.all() else spectrum.amplitude[..., own]
    return _wave(amplitude, spectrum.points[own, axis], theta, real=spectrum.mirrored)


def _wave(amplitude: ComplexArray, orders: Index, theta: Array, *, real: bool) -> Values:
    """sum_a amplitude_a exp(2 pi i a theta), (..., Nt), its real part where `real`."""
    angle = 2 * np.pi * np.outer(orders, theta)
    if not real:
        whole: Values = amplitude @ np.exp(1j * angle)
        return whole
    turns = np.stack([np.cos(angle), -np.sin(angle)], axis=1).reshape(-1, theta.size)
    # real and imaginary parts side by side as they lie in memory: one product of many rows
    both = np.ascontiguousarray(amplitude).view(float).reshape(-1, len(turns))
    part: Values = (both @ turns).reshape(*amplitude.shape[:-1], theta.size)
    return part


def on_torus(spectrum: Spectrum, counts: Sequence[int], cross: int) -> Values:
    """Values over a grid of all tone phases, (rows, P, S, N_1, .., N_D), real of a real signal.

    cross : combinations beyond that cross order, which are below what a solution may drop, are left out.
    """
    D = len(counts)
    phases = [np.arange(count) / count for count in counts]
    if D == 1:
        return own_waves(spectrum, 0, phases[0])
    combined = (np.count_nonzero(spectrum.points, axis=1) > 1) & (np.abs(spectrum.points).sum(axis=1) <= cross)
    total = _box(spectrum.amplitude[..., combined], spectrum.points[combined], phases, real=spectrum.mirrored)
    for axis, theta in enumerate(phases):
        own = own_waves(spectrum, axis, theta, mean=axis == 0)  # the origin stands on every axis
        total += own.reshape(*own.shape[:3], *(theta.size if j == axis else 1 for j in range(D)))
    return total


def _box(amplitude: ComplexArray, points: Index, phases: Sequence[Array], *, real: bool) -> Values:
    """Combinations of tones on the grid: a sum over one axis after another."""
    low, high = points.min(axis=0, initial=0), points.max(axis=0, initial=0)
    box = np.zeros((*amplitude.shape[:3], *(high - low + 1)), complex)
    box[(..., *(points - low).T)] = amplitude
    for axis in range(len(phases) - 1, -1, -1):
        moved = np.moveaxis(box, 3 + axis, -1)
        values = _wave(moved, np.arange(low[axis], high[axis] + 1), phases[axis], real=real and axis == 0)
        box = np.moveaxis(values, -1, 3 + axis)
    return box


def envelopes(spectrum: Spectrum, axis: int, theta: Array) -> Envelopes:
    """All that is no multiple of one tone, modulo that tone, over its phase theta (Nt,)."""
    points, D = spectrum.points, spectrum.points.shape[1]
    lattice = Lattice(points=points, mirrored=spectrum.mirrored, own=())
    lines = bundle(lattice, axis)
    half = lines.take.shape[1] // 2
    padded = np.concatenate([spectrum.amplitude, np.zeros((*spectrum.amplitude.shape[:3], 1))], axis=3)
    picked = padded[..., lines.take]
    picked.imag *= lines.mirror
    values = _wave(picked, np.arange(-half, half + 1), theta, real=False)
    rests = lines.rests
    if not spectrum.mirrored:
        values = np.concatenate([own_waves(spectrum, axis, theta)[:, :, :, None], values], axis=3)
        rests = np.concatenate([np.zeros((1, D), np.int64), rests])
    S, R = values.shape[2:4]
    return Envelopes(
        rests=np.tile(rests, (S, 1)),
        shaft=np.repeat(np.full(1, -1) if spectrum.mirrored else np.arange(S), R),
        values=values.reshape(*values.shape[:2], S * R, theta.size),
    )


def samples_needed(ready: Response, kept: int) -> int:
    """Samples of a mesh cycle that hold so many harmonics of the force and their square without aliasing."""
    return 2 * (kept + int(ready.system.meshes.variation.shape[1])) + 1


def peak(values: Array) -> Array:
    """Largest value of a periodic signal (..., Nt) -> (...), with a parabola through the largest sample."""
    return _vertex(values, np.argmax(values, axis=-1))


def valley(values: Array) -> Array:
    """Smallest value of a periodic signal, as `peak`."""
    return _vertex(values, np.argmin(values, axis=-1))


def _vertex(values: Array, place: Index) -> Array:
    """Top or bottom of the parabola through an extreme sample and its neighbours."""
    count = values.shape[-1]
    flat, at = values.reshape(-1), np.arange(0, values.size, count).reshape(place.shape)
    before, top, after = (flat[at + (place + step) % count] for step in (-1, 0, 1))
    bend = 2 * top - before - after
    with np.errstate(all="ignore"):
        rise = np.where(bend != 0, (after - before) ** 2 / (8 * bend), 0.0)
    result: Array = top + rise
    return result
