"""The flanks that can touch: every mesh row pressed on its loaded flank, and where backlash is finite on the far one.

All follow one law: f = k(theta) delta + c delta' where delta > 0, else nothing.  The mean system holds k0 and c of the
loaded flanks; a far flank is a row of its own (its normal is not the opposite of the loaded one), open by the backlash.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from ..steady.response import Response

__all__ = ["Flanks", "flanks"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flanks:
    """R flanks: those of the m mesh rows, then the far ones.

    gaps, pulls : (R, n) as of `Modal`.  linear, drag : (R,) stiffness [N/m] and damping [N s/m] in the mean system.
    stiffness, damping : (R,) mean of the law.  variation : (R, L) complex, as of `MeshRows`.  axis : (R,) the tone.
    mesh : (R,) row of the mesh.  sense : (R,) +1 loaded, -1 far flank.  opening : (R,) backlash of a far flank [m].
    """

    gaps: Array
    pulls: Array
    linear: Array
    drag: Array
    stiffness: Array
    damping: Array
    variation: ComplexArray
    axis: NDArray[np.int64]
    mesh: NDArray[np.int64]
    sense: Array
    opening: Array


def flanks(ready: Response) -> Flanks:
    """The flanks of a System ready for its response."""
    modal, meshes, far = ready.modal, ready.system.meshes, ready.system.far_flanks
    m, own = len(meshes.name), far.mesh
    gaps, pulls = far.B.T @ modal.shapes, (modal.forces @ far.B).T
    gaps[:, modal.rigid] = pulls[:, modal.rigid] = 0.0
    nothing = np.zeros(own.size)
    return Flanks(
        gaps=np.concatenate([modal.gaps, gaps]),
        pulls=np.concatenate([modal.pulls, pulls]),
        linear=np.concatenate([meshes.stiffness, nothing]),
        drag=np.concatenate([meshes.damping, nothing]),
        stiffness=np.concatenate([meshes.stiffness, meshes.stiffness[own]]),
        damping=np.concatenate([meshes.damping, meshes.damping[own]]),
        variation=np.concatenate([meshes.variation, far.variation]),
        axis=np.concatenate([ready.lines.axis, ready.lines.axis[own]]),
        mesh=np.concatenate([np.arange(m), own]),
        sense=np.concatenate([np.ones(m), -np.ones(own.size)]),
        opening=np.concatenate([np.zeros(m), meshes.backlash[own]]),
    )
