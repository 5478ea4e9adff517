"""Modes of two trains paired: by their shapes where the coordinates are the same, else by kind and order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from ...questions.modes.eigen import repeated_roots

__all__ = ["BY_KIND", "BY_SHAPE", "TrainModes", "mode_pairs"]

Array = NDArray[np.float64]
BY_SHAPE, BY_KIND = "mode shapes (MAC)", "kind and order"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrainModes:
    """Modes of the undamped mean system of one train, rising.

    squared : (n,) omega^2 [rad^2/s^2].  vectors : (n, n), Phi^T M Phi = 1.  mass : M (n, n).  kind : (n,).
    dofs : (n,) names of the coordinates.
    """

    squared: Array
    vectors: Array
    mass: Array
    kind: tuple[str, ...]
    dofs: tuple[str, ...]

    @property
    def frequency(self) -> Array:
        """Natural frequencies (n,) [Hz]."""
        return np.asarray(np.sqrt(self.squared) / (2 * np.pi))


def mode_pairs(a: TrainModes, b: TrainModes) -> tuple[NDArray[np.int64], Array, str]:
    """Mode of b that each mode of a corresponds to.

    Returns
    -------
    (place in b (n,), -1 without one; modal assurance criterion (n,) [1], nan where modes are paired by kind; which of
    `BY_SHAPE` and `BY_KIND`).
    """
    if a.dofs == b.dofs:
        return *_by_shape(a, b), BY_SHAPE
    place = _by_kind(a.kind, b.kind)
    return place, np.full(place.size, np.nan), BY_KIND


def _by_shape(a: TrainModes, b: TrainModes) -> tuple[NDArray[np.int64], Array]:
    """Pairs of the largest sum of modal assurance criteria [allemang1982] with the mean of both M as weight.

    Of repeated roots the shapes are any basis of an eigenspace: the criterion is that of the eigenspaces, the share of
    the smaller one that lies in the other.
    """
    mass = (a.mass + b.mass) / 2
    left, right = (one.vectors / np.sqrt(np.einsum("ij,ik,kj->j", one.vectors, mass, one.vectors)) for one in (a, b))
    overlap = (left.T @ mass @ right) ** 2
    criterion = np.empty_like(overlap)
    for mine in repeated_roots(a.squared):
        for other in repeated_roots(b.squared):
            block = overlap[mine, other]
            criterion[mine, other] = block.sum() / min(block.shape)
    criterion = np.clip(criterion, 0.0, 1.0)
    _, place = scipy.optimize.linear_sum_assignment(criterion, maximize=True)
    return np.asarray(place, dtype=np.int64), criterion[np.arange(place.size), place]


def _by_kind(a: Sequence[str], b: Sequence[str]) -> NDArray[np.int64]:
    """The k-th mode of a kind to the k-th of the same kind."""
    ranks = [(kind, list(b[:i]).count(kind)) for i, kind in enumerate(b)]
    place = {rank: i for i, rank in enumerate(ranks)}
    return np.array([place.get((kind, list(a[:i]).count(kind)), -1) for i, kind in enumerate(a)], dtype=np.int64)
