"""A mesh cut into slices along its face: where they lie, and when each of them meshes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears.stiffness import over_face
from ..train.connections import Mesh, MeshSlice

__all__ = ["require_width", "slices_of"]


def require_width(width: float, count: int, path: str) -> None:
    """Raise ModelError where a mesh is to be cut whose face width [m] is not known; path of the stage."""
    if count > 1 and math.isnan(width):
        raise ModelError(
            "is missing: slices of a mesh need it", path=f"{path}.face_width", given=f"slices = {count}", allowed="m"
        )


def slices_of(mesh: Mesh, count: int, width: float, narrow: NDArray[np.complex128] | None) -> tuple[MeshSlice, ...]:
    """The slices of a mesh, left to right; none for a count of 1.

    The helix brings a slice at zeta from mid-face into contact at sigma + d h zeta/p_x, and zeta/p_x is zeta times the
    overlap ratio per face width.  A series computed from the teeth adds up to the whole exactly, because
    sinc(l eps/n) times the sum of their phases is n sinc(l eps).  A series that the file gives is that of the whole
    mesh: every slice follows it in step, since shifted it would no longer add up to what is given.

    width : of the helix [m].  narrow : the series of a slice without width, as computed; None: a given one.
    """
    if count == 1:
        return ()
    place = (np.arange(count) + 0.5) / count - 0.5
    shift = np.zeros(count)
    variation: NDArray[np.complex128] = mesh.variation
    if narrow is not None and mesh.hand:
        shift = mesh.sense * mesh.flank * mesh.hand * mesh.overlap_ratio * place
        variation = over_face(narrow, mesh.overlap_ratio / count)
    return tuple(
        MeshSlice(station=mesh.station + width * z, lead=mesh.lead + turn if turn else mesh.lead, variation=variation)
        for z, turn in zip(place.tolist(), shift.tolist(), strict=True)
    )
