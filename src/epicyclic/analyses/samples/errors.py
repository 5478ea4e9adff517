"""Measures of the mesh forces of many samples of errors: one matrix product a chunk of samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array
from ..steady.measures import phase_grid, torus_maximum
from ..steady.waveform import mesh_axis, torus_waveform
from .error_map import ColumnSpectrum, ErrorMap

__all__ = ["MEASURES", "Factors", "Measure", "error_samples"]

Scalar = TypeVar("Scalar", bound=np.inexact)
Factors = NDArray[np.inexact[Any]]
Measure = Literal["rms", "peak", "minimum", "mean"]
MEASURES: tuple[Measure, ...] = get_args(Measure)
Evaluate = Callable[[Array], Array]
# Doubles that one product makes: small enough to stay in the cache until they are summed.
_CHUNK = 500_000
# Singular values below this share of the largest add nothing to the root of a sum of squares.
_NEGLIGIBLE = 1e-14


def error_samples(linear: ErrorMap, factors: Factors | Iterable[Factors], measure: Measure = "rms") -> Array:
    """Measure of every mesh force for every sample of errors, (w, S) [N].

    Parameters
    ----------
    factors : (S, C) real or complex factors on the columns, or an iterable of such arrays, so that a million samples
        need not be in memory at once.
    measure : ``rms`` of all time without the mean; ``peak`` and ``minimum`` over the mesh phases with all shaft lines
        at their worst, the bounds of a sweep; ``mean``.

    Raises
    ------
    ModelError : no such measure, or factors of another shape.
    """
    kinds: dict[str, Callable[[ErrorMap], tuple[Evaluate, int]]] = {
        "rms": _rms,
        "peak": lambda given: _extreme(given, 1.0),
        "minimum": lambda given: _extreme(given, -1.0),
        "mean": _mean,
    }
    if measure not in kinds:
        raise ModelError("no such measure", path="measure", given=measure, allowed=", ".join(kinds))
    find, size = kinds[measure](linear)
    found = [find(numbers) for numbers in _real_factors(linear, factors, max(1, _CHUNK // size))]
    return np.concatenate([np.zeros((len(linear.mesh), 0)), *found], axis=1)


def _real_factors(linear: ErrorMap, factors: Factors | Iterable[Factors], chunk: int) -> Iterator[Array]:
    """[1, Re z, Im z] of `chunk` samples at a time, (s, 1 + 2 C)."""
    count = len(linear.columns)
    for given in [factors] if isinstance(factors, np.ndarray) else factors:
        z = np.asarray(given)
        if z.ndim != 2 or z.shape[1] != count:
            raise ModelError("wrong shape", path="factors", given=z.shape, allowed=f"(samples, {count})")
        for first in range(0, len(z), chunk):
            part = z[first : first + chunk]
            numbers = np.zeros((len(part), 1 + 2 * count))
            numbers[:, 0], numbers[:, 1 : count + 1] = 1.0, part.real
            if np.iscomplexobj(part):
                numbers[:, count + 1 :] = part.imag
            yield numbers


def _by_number(linear: ErrorMap, part: ColumnSpectrum, values: NDArray[Scalar]) -> NDArray[Scalar]:
    """Values of the columns (w, P, ...) of a part by real factor, (1 + 2 C, w, ...)."""
    result = np.zeros((1 + 2 * len(linear.columns), len(linear.mesh), *values.shape[2:]), values.dtype)
    result[part.use] = values.swapaxes(0, 1)
    return result


def _rms(linear: ErrorMap) -> tuple[Evaluate, int]:
    """RMS by Parseval's theorem, as `mean_square`; of each mesh only as many squares as the map has independent
    rows.
    """
    parts = [_by_number(linear, part, part.spectrum.amplitude[:, :, 0]) for part in linear.parts]
    lines = np.concatenate(parts, axis=2)
    line_frequencies = linear.ready.line_frequencies(linear.truncation, shafts=len(parts) > 1, truncated=True)
    moving = ~line_frequencies.constant
    if line_frequencies.coincident:
        lines, moving = line_frequencies.merged(lines), line_frequencies.distinct != 0
    both = np.concatenate([lines.real, lines.imag], axis=2) * np.sqrt(np.tile(moving.astype(float), 2) / 2)
    left, size, _ = np.linalg.svd(both.swapaxes(0, 1), full_matrices=False)
    rank = max(1, int((size > _NEGLIGIBLE * size.max(initial=0.0)).sum(axis=1).max(initial=1)))
    matrix = (left * size[:, None])[:, :, :rank].swapaxes(0, 1)
    flat = np.ascontiguousarray(matrix.reshape(len(matrix), -1))

    def find(numbers: Array) -> Array:
        """RMS (w, s) [N] of real factors (s, 1 + 2 C)."""
        values = (numbers @ flat).reshape(len(numbers), -1, rank)
        result: Array = np.sqrt(np.einsum("swk,swk->ws", values, values))
        return result

    return find, flat.shape[1]


def _mean(linear: ErrorMap) -> tuple[Evaluate, int]:
    """Mean forces (w, s) [N], and the size of the product a sample."""
    part = linear.parts[0]
    origin = int(np.flatnonzero(~part.spectrum.points.any(axis=1))[0])
    matrix = _by_number(linear, part, part.spectrum.amplitude[:, :, 0, origin].real)
    return lambda numbers: (numbers @ matrix).T, matrix.shape[1]


def _extreme(linear: ErrorMap, sign: float) -> tuple[Evaluate, int]:
    """sign times the largest of sign f0 + sum |A_s| over the phases of the tones [N], as `force_extremes`."""
    counts, w = phase_grid(linear.parts[0].spectrum), len(linear.mesh)
    waves = [
        _by_number(linear, p, torus_waveform(p.spectrum, counts, linear.truncation[-1])[:, :, 0]) for p in linear.parts
    ]
    # (1 + 2 C, w N) of mesh orders; real and imaginary parts of shaft lines
    value, *lines = (wave.reshape(len(wave), -1) for wave in waves)
    pairs = [tuple(np.ascontiguousarray(each) for each in (line.real, line.imag)) for line in lines]
    axis = mesh_axis(linear.ready)

    def find(numbers: Array) -> Array:
        """Bound (w, s) [N] of real factors (s, 1 + 2 C)."""
        total = sign * (numbers @ value)
        for real, imag in pairs:
            total += np.hypot(numbers @ real, numbers @ imag)
        shaped = total.reshape(len(numbers), w, *counts).swapaxes(0, 1)
        highest: Array = sign * torus_maximum(axis, shaped)
        return highest

    return find, value.shape[1]
