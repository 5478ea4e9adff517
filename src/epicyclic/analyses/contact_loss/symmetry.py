"""Whether a motion has the symmetry of its train: turned by one branch and shifted in time it is itself (derived here).

A stage whose branches are alike, their mesh phases whole parts of a cycle apart, is itself when turned by one branch
and shifted by such a part.  Each of its motions then has an image that is a motion too, and a motion with less symmetry
is another one than its image.  Which shift is the train's is decided by the balance: at the wrong one the image is no
motion, and neither is any where the branches differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...system.system import Array, Symmetry
from .refinement import ACCURACY, Refinement, Solution, distinct

__all__ = ["symmetry_is_broken", "with_kind"]


def with_kind(refinement: Refinement, at: Solution) -> Solution:
    """A motion that repeats every mesh cycle, named after whether it has the symmetry of its train."""
    broken = at.kind == "periodic" and symmetry_is_broken(refinement, at)
    return replace(at, kind="symmetry broken") if broken else at


def symmetry_is_broken(refinement: Refinement, at: Solution) -> bool:
    """Whether a motion of whole mesh cycles has less symmetry than a stage of its train.

    An image counts as a motion where its residual is at most `ACCURACY` above that of the motion, by as much as they
    are known, and as another one where the two are `distinct`, as any two motions.
    """
    for symmetry in refinement.ready.system.symmetries:
        if not symmetry.holds or symmetry.branches < 2:
            continue
        images = list(_images(refinement, at, symmetry))
        if all(distinct(at, image) for image in images) and any(
            refinement.residual(at.given, image.state, at.harmonics) <= at.residual + ACCURACY for image in images
        ):
            return True
    return False


def _images(refinement: Refinement, at: Solution, symmetry: Symmetry) -> Iterator[Solution]:
    """A motion turned by one branch, at every shift of its stage's tone by a whole part of a cycle.

    Of the states only y is that of the image.
    """
    given, meshes = at.given, refinement.ready.system.meshes
    tones = {int(tone) for tone, stage in zip(meshes.tone, meshes.stage, strict=True) if stage == symmetry.stage}
    turned = at.state.y @ _of_modes(refinement, symmetry).T
    turned[:, 0, given.modal.rigid] = 0.0
    for part in range(symmetry.branches):
        cycles = part * given.grid.points[:, sorted(tones)].sum(axis=1)
        shift = np.exp(2j * np.pi * cycles / symmetry.branches)[:, None]
        moved = (turned[0] + 1j * turned[1]) * shift
        yield replace(at, state=replace(at.state, y=np.stack([moved.real, moved.imag])))


def _of_modes(refinement: Refinement, symmetry: Symmetry) -> Array:
    """Turning by one branch on modal coordinates, (n, n)."""
    shapes = refinement.ready.modal.shapes
    return np.asarray(np.linalg.solve(shapes, symmetry.operator @ shapes), np.float64)
