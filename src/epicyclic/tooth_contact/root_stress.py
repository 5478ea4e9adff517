"""Stress in the tooth roots of both gears of a loaded contact: along the path of contact and over the face.

Every slice of a tooth is a plane tooth with the influence function of `root_influence`; the forces on all teeth act on
it together.  Along the face a force reaches the root as it bends the tooth: with the kernel G of `kernel`, whose
integral is 1, so that an even load has the plane stress.  Derived here:

    stress_jk = sum over teeth j', slices k' of G(k, k') P_j'k' I(place on the fillet; radius_j'k', j' - j)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .kernel import face_coupling
from .lines import PlaneOfAction
from .pair import ContactPair, ElasticTooth
from .root_influence import REACH, RootInfluence, root_influence
from .tooth import ToothCompliance

__all__ = ["RootStress", "pair_influences", "root_stress"]

Array = NDArray[np.float64]

# Numbers held at a time, 32 MB: far below what the compliance of a contact takes.
_HELD = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RootStress:
    """Stress in the roots of one gear: F loads, T phases, J teeth, K slices of the face.

    tension : (F, T, J, K) largest along the fillet below the loaded flank [Pa].  compression : (F, T, J, K) least along
    the fillet of the other flank, compression negative [Pa].  lean : (F,) angle of the tangent of the fillet against
    the middle line of the tooth where the tension is largest [rad].
    """

    tension: Array
    compression: Array
    lean: Array


def pair_influences(pair: ContactPair) -> tuple[RootInfluence, RootInfluence]:
    """Influence functions of both gears of a pair as drawn.

    Raises
    ------
    ModelError : as of `root_influence`.
    """
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    return root_influence(a.gear), root_influence(b.gear)


def root_stress(
    pair: ContactPair, sigma: Array, force: Array, influences: tuple[RootInfluence, RootInfluence]
) -> tuple[RootStress, RootStress]:
    """Stress in the tooth roots of both gears.

    Parameters
    ----------
    sigma : (T, J, K) places on the path of contact of the slices of each tooth pair [base pitches], the pairs in the
        order in which they rise.  force : (F, T, J, K) on them along the normal [N].
    """
    plane = pair.plane
    on = np.clip(sigma, *plane.limits)
    first = _of_gear(plane, pair.tooth_a, plane.face_a, plane.radius_a(on), force, influences[0], 1)
    return first, _of_gear(plane, pair.tooth_b, plane.face_b, plane.radius_b(on), force, influences[1], -1)


def _of_gear(
    plane: PlaneOfAction,
    tooth: ElasticTooth,
    face: tuple[float, float],
    radius: Array,
    force: Array,
    influence: RootInfluence,
    sense: int,
) -> RootStress:
    """Stress of one gear; radius : (T, J, K) of the loads [m]; sense : -1 where the next pair is one tooth behind."""
    coupling = _coupling(plane, tooth, face, force.shape[-1])
    tension, compression = np.empty(force.shape), np.empty(force.shape)
    lean, most = np.zeros(len(force)), np.full(len(force), -np.inf)
    right, left = influence.shape
    for phases in _chunks(radius.shape, right.shape):
        amounts = influence.amounts(radius[phases])
        for i, load in enumerate(force[:, phases]):
            modes = coupling @ _on_teeth(amounts, load, sense)  # (t, J, K, R)
            along = modes @ right.T
            tension[i, phases] = along.max(axis=-1)
            compression[i, phases] = (modes @ left.T).min(axis=-1)
            place = int(along.argmax())
            if along.flat[place] > most[i]:
                most[i], lean[i] = along.flat[place], influence.lean[place % right.shape[0]]
    return RootStress(tension=tension, compression=compression, lean=lean)


def _on_teeth(amounts: Array, load: Array, sense: int) -> Array:
    """Amounts (t, J, K, R) [1/m N] of the modes of every tooth from the loads (t, J, K) [N] on all of them.

    amounts : (t, J, K, 2 REACH + 1, R) per load [1/m].
    """
    J = load.shape[1]
    found = np.zeros((*load.shape, amounts.shape[-1]))
    for moved in range(J):
        for loaded in range(max(0, moved - REACH), min(J, moved + REACH + 1)):
            ahead = REACH + sense * (loaded - moved)
            found[:, moved] += load[:, loaded, :, None] * amounts[:, loaded, :, ahead]
    return found


def _coupling(plane: PlaneOfAction, tooth: ElasticTooth, face: tuple[float, float], slices: int) -> Array:
    """Load per length on each slice per force on another (K, K) [1/m]; along the tooth."""
    slant = math.cos(plane.base_helix)
    span = plane.width / slices
    centre: Array = plane.face[0] + span * (np.arange(slices, dtype=np.float64) + 0.5)
    width = (face[1] - face[0]) / slant
    middle = (centre - 0.5 * (face[0] + face[1])) / slant
    return face_coupling(middle, width, tooth.face_decay(width), np.full(slices, span / slant))


def _chunks(shape: tuple[int, ...], modes: tuple[int, ...]) -> Iterator[slice]:
    """Phases of which the numbers held at a time fit; shape : (T, J, K); modes : (P, R)."""
    each = math.prod(shape[1:]) * max(modes[0], (2 * REACH + 1) * modes[1])
    step = max(1, _HELD // each)
    for start in range(0, shape[0], step):
        yield slice(start, start + step)
