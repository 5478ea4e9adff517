"""Which meshes carry load in the mean: where they do not, load sharing and dynamic factor are not defined."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ...warning_codes import CodedText, coded
from .record import MeshGroup

__all__ = ["idle_warnings", "least_load", "loaded_meshes"]

# A mean force below this part of the largest force is none: responses are solved to a relative residual of 1e-6, so
# that what is left of the balance of an idle gear is not known to be above zero.
_NONE = 1e-6


def loaded_meshes(mean: Array, members: Sequence[MeshGroup], *, most: Array, rounding: float) -> NDArray[np.bool_]:
    """Meshes of groups that carry load in the mean, (m, ..), from mean forces (m, ..) [N].

    The meshes of a pair are asked together: those of an idle gear may be pressed against each other.

    Parameters
    ----------
    members : meshes of one pair and side.  most : (m, ..) largest forces [N].  rounding : a force that is none [N].
    """
    least = least_load(mean, most=most, rounding=rounding)
    loaded = np.zeros(mean.shape, dtype=bool)
    for group in members:
        loaded[group] = mean[group].sum(axis=0) > least
    return loaded


def least_load(mean: Array, *, most: Array, rounding: float) -> Array:
    """Mean force (..) [N] from which on a mesh carries load; arguments as of `loaded_meshes`.

    An idle group beside loaded ones, or one that only swings, carries rounding.
    """
    largest = np.max(np.nan_to_num(np.abs([mean, most])), axis=(0, 1), initial=0.0)
    least: Array = np.maximum(_NONE * largest, rounding)
    return least


def idle_warnings(meshes: Sequence[str], loaded: NDArray[np.bool_], what: str) -> list[CodedText]:
    """A warning of the meshes without load, (m,), and `what` is not defined there."""
    names = ", ".join(name for name, yes in zip(meshes, loaded, strict=True) if not yes)
    return [coded("mesh-without-load", f"no load, hence no {what}, in {names}")] if names else []
