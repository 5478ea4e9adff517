"""Matrix products whose sums have one order, whatever number of threads BLAS takes.

A run that is continued elsewhere comes to the same bits only so.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["per_instant", "times"]

T = TypeVar("T", np.float64, np.complex128)
# Products a BLAS leaves to one thread: OpenBLAS shares out matrix products from 2.6e5 multiplications on.
_ONE_THREAD = 100_000


def per_instant(values: NDArray[T], matrix: NDArray[T]) -> NDArray[T]:
    """Products (.., k, c) of values (.., k, n) and a matrix (n, c), real or complex, instant by instant.

    NumPy asks BLAS for each of the small products; large ones do without it.
    """
    if values.shape[-2] * matrix.size > _ONE_THREAD:
        result: NDArray[T] = np.einsum("...kn,nc->...kc", values, matrix)
        return result
    result = values @ matrix
    return result


def times(vector: Array, matrix: Array) -> Array:
    """Product (c,) of a vector (n,) and a matrix (n, c), without BLAS: it shares out vector products from 1e4 on."""
    result: Array = np.einsum("n,nc->c", vector, matrix)
    return result
