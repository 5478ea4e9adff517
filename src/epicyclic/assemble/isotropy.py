"""Isotropy of supports: equal in all lateral directions, as required where they turn against the frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..train.connections import Link

__all__ = ["check_isotropy", "isotropic"]

Array = NDArray[np.float64]

# Angles and stiffnesses of a drawing carry 1e-12 of rounding; a support anisotropic by less than this is isotropic.
_ROUND = 1e-9
# Singular values below this share of the largest are those of dependent rows.
_SAME = 1e-9


def check_isotropy(rows: Array, stiffness: Array, damping: Array, links: Sequence[Link]) -> None:
    """Check the isotropy of the rows between one body and a body that turns against its frame, all links together.

    Parameters
    ----------
    rows : (r, 6) of the coordinates of the body.  stiffness (inf = rigid) [N/m], damping [N s/m] : (r,).
    links : (r,) of each row.

    Raises
    ------
    ModelError : their sum is anisotropic; names the first link that is anisotropic by itself.
    """
    if isotropic(rows, stiffness, damping):
        return
    names = np.array([link.name for link in links])
    mine = [names == link.name for link in links]
    alone = [isotropic(rows[one], stiffness[one], damping[one]) for one in mine]
    link = links[alone.index(False) if False in alone else 0]
    turning = "the frame turns" if link.second is None else "it turns in the frame"
    raise ModelError(
        f"differs between x and y (or rx and ry) although {turning}: its stiffness would vary in time",
        path=link.path,
        given=list(link.stiffness),
        allowed="equal x and y, equal rx and ry, three or more equal bolts evenly spaced, or a frame that stands still",
    )


def isotropic(rows: Array, stiffness: Array, damping: Array) -> bool:
    """Whether springs, dampers and the space of rigid rows are invariant under any rotation about z.

    rows : (r, 6).  stiffness [N/m], damping [N s/m] : (r,).
    """
    rigid = np.isinf(stiffness)
    springs = (rows.T * np.where(rigid, 0.0, stiffness)) @ rows
    dampers = (rows.T * damping) @ rows
    if not rigid.any():
        return _round(springs) and _round(dampers)
    _, size, right = np.linalg.svd(rows[rigid], full_matrices=False)
    span = right[size > _SAME * size.max(initial=0.0)]
    return _round(springs) and _round(dampers) and _round(span.T @ span + np.eye(6))  # a projector has rounding of 1


def _round(matrix: Array) -> bool:
    """Whether a symmetric (6, 6) matrix commutes with rotations about z; entries on the scale of their diagonals."""
    turn = np.zeros((6, 6))
    for i in (0, 3):
        turn[i, i + 1], turn[i + 1, i] = -1.0, 1.0
    diagonal = np.sqrt(np.diag(matrix))
    for i in (0, 3):
        diagonal[i : i + 2] = diagonal[i : i + 2].max()
    return bool(np.all(np.abs(matrix @ turn - turn @ matrix) <= _ROUND * np.outer(diagonal, diagonal)))
