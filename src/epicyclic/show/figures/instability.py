"""Kinds of instability and the labels of resonances: what both figures of stability share."""

from __future__ import annotations

import numpy as np

from .series import Array
from .style import PALETTE

__all__ = ["KINDS", "LABELS", "apart"]

# kind of instability: colour and what it means
KINDS = {
    "quasi-periodic": (PALETTE[1], "quasi-periodic: two modes together"),
    "period doubling": (PALETTE[3], "period doubling: half mesh orders"),
    "divergence": (PALETTE[6], "divergence: mesh orders"),
}
LABELS = 8


def apart(order: np.ndarray, centre: Array, distance: float, x: Array) -> list[int]:
    """The first few places in order (r,) whose centres (r,) stand `distance` apart within x (P,), all [Hz]."""
    kept: list[int] = []
    for place in order:
        inside = x.min() <= centre[place] <= x.max()
        if inside and all(abs(centre[place] - centre[other]) > distance for other in kept):
            kept.append(int(place))
    return kept[:LABELS]
