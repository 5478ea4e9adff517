"""Stress in the tooth roots as variables of the results of tooth contact."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..system.face_contact import FaceLoad, MeshFaceLaw
from ..teeth.loaded_contact import LoadedContact, first_images
from ..teeth.root_stress import RootStress, pair_influences, root_stress

__all__ = ["GEARS", "RootColumns", "largest_root_stresses", "root_columns"]

Array = NDArray[np.float64]

GEARS = ("a", "b")
"""Both gears of a mesh, first and second."""
# Even places of a tooth along the path of contact, beside those of the largest stresses.
_ROOT_PLACES = 161


@dataclass(frozen=True, slots=True, kw_only=True)
class RootColumns:
    """Variables and coordinates of a Dataset."""

    variables: dict[str, tuple[Any, Array]] = field(default_factory=dict)
    coords: dict[Hashable, Any] = field(default_factory=dict)


def root_columns(results: Sequence[LoadedContact], operating: int) -> RootColumns:
    """Stress in the tooth roots of loaded contacts, one a helix.

    largest_root_stress, lowest_root_stress (side, mesh_gear, mesh_load) [Pa], root_stress_lean (side, mesh_gear) [rad],
    and at the load of index `operating` root_stress, far_root_stress (side, mesh_gear, width, tooth_place) [Pa] over
    the face while the tooth moves along the path of contact.
    """
    images = first_images([one.segments.pair for one in results], [one.sigma for one in results])
    found: list[tuple[RootStress, RootStress]] = []
    for one, first in zip(results, images, strict=True):
        if first < len(found):
            mirrored = [_mirrored(gear) for gear in found[first]]
            found.append((mirrored[0], mirrored[1]))
            continue
        pair = one.segments.pair
        found.append(root_stress(pair, one.segments.lines.sigma, one.force, pair_influences(pair)))
    places = [one.sigma[:, None] - one.segments.lines.pair for one in results]
    at = _tooth_places(found, places, operating)
    sided = ("side", "mesh_gear")
    over = (*sided, "width", "tooth_place")

    def maps(name: str) -> Array:
        return np.array(
            [
                [_over_place(getattr(gear, name)[operating], place, at) for gear in gears]
                for gears, place in zip(found, places, strict=True)
            ]
        )

    return RootColumns(
        variables={
            "largest_root_stress": (
                (*sided, "mesh_load"),
                np.array([[gear.tension.max(axis=(1, 2, 3)) for gear in gears] for gears in found]),
            ),
            "lowest_root_stress": (
                (*sided, "mesh_load"),
                np.array([[gear.compression.min(axis=(1, 2, 3)) for gear in gears] for gears in found]),
            ),
            "root_stress_lean": (sided, np.array([[gear.lean[operating] for gear in gears] for gears in found])),
            "root_stress": (over, maps("tension")),
            "far_root_stress": (over, maps("compression")),
        },
        coords={"mesh_gear": list(GEARS), "tooth_place": at},
    )


def largest_root_stresses(
    laws: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]]
) -> list[tuple[Array, Array]]:
    """Largest tension and compression in the tooth roots of the meshes of each law, (g, levels, 2) each [Pa].

    loads : at each level of load, by law.  Last axis: gears a and b.
    """
    found = []
    for number, law in enumerate(laws):
        at = [one[number] for one in loads]
        T, g, J, K = at[0].sigma.shape
        force = np.array([one.force.reshape(T * g, J, K) for one in at])
        gears = root_stress(law.pair, at[0].sigma.reshape(T * g, J, K), force, pair_influences(law.pair))
        shape = (len(at), T, g, J * K)
        tension = [gear.tension.reshape(shape).max(axis=(1, 3)).T for gear in gears]
        compression = [gear.compression.reshape(shape).min(axis=(1, 3)).T for gear in gears]
        found.append((np.stack(tension, axis=-1), np.stack(compression, axis=-1)))
    return found


def _mirrored(stress: RootStress) -> RootStress:
    """Stress of the mirror image of a helix, from the other end of the face."""
    return RootStress(tension=stress.tension[..., ::-1], compression=stress.compression[..., ::-1], lean=stress.lean)


def _tooth_places(found: Sequence[Sequence[RootStress]], places: Sequence[Array], operating: int) -> Array:
    """Places (P,) of a tooth at mid-face [base pitches]: even ones, and those of the largest stresses.

    places : (T, J) of the teeth of each helix [base pitches].
    """
    even = np.linspace(min(one.min() for one in places), max(one.max() for one in places), _ROOT_PLACES)
    largest = [
        place.ravel()[int(values.max(axis=-1).argmax())]
        for gears, place in zip(found, places, strict=True)
        for gear in gears
        for values in (gear.tension[operating], -gear.compression[operating])
    ]
    return np.unique(np.concatenate([even, largest]))


def _over_place(values: Array, place: Array, at: Array) -> Array:
    """Values (T, J, K) of teeth at places (T, J) of those, at places (P,) of one tooth, (K, P), in their unit."""
    order = np.argsort(place, axis=None)
    flat = values.reshape(-1, values.shape[-1])[order]
    return np.array([np.interp(at, place.ravel()[order], column) for column in flat.T])
