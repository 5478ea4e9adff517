"""Helices that are mirror images of one another, in the plane normal to the axis: one contact serves both.

The two helices of a herringbone gear with equal flanks lean to opposite sides.  Mirrored, the contact lines of one are
those of the other at every phase, and so are compliance, gaps and loads, from the other end of the face (derived here).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..gears.flank import Flank
from .lines import PlaneOfAction
from .loaded_contact import LoadedContact, loaded_segments
from .pair import ContactPair, Torsion
from .segments import ContactSegments, contact_segments

__all__ = ["all_loaded", "all_segments", "first_images", "mirrored"]

Array = NDArray[np.float64]


def mirrored(pair: ContactPair) -> ContactPair:
    """Contact pair as a mirror normal to the axis shows it: left and right exchanged."""
    return replace(
        pair,
        plane=_mirrored_plane(pair.plane),
        flank_a=_mirrored_flank(pair.flank_a),
        flank_b=_mirrored_flank(pair.flank_b),
        misalignment=-pair.misalignment,
        gap=tuple((-zeta, gap) for zeta, gap in reversed(pair.gap)),
        torsion_a=_mirrored_torsion(pair.torsion_a),
        torsion_b=_mirrored_torsion(pair.torsion_b),
    )


def first_images(pairs: Sequence[ContactPair], sigma: Sequence[Array]) -> list[int]:
    """Of every pair the number of the first one that it mirrors, at the same places sigma (T,), or its own number."""
    found: list[int] = []
    for i, pair in enumerate(pairs):
        image = mirrored(pair)
        same = (j for j in range(i) if np.array_equal(sigma[i], sigma[j]) and _equal(image, pairs[j]))
        found.append(next(same, i))
    return found


def all_segments(pairs: Sequence[ContactPair], sigma: Sequence[Array]) -> list[ContactSegments]:
    """`contact_segments` of every pair at its places sigma (T,) [base pitches]; mirror images share their compliance.

    Raises
    ------
    ModelError : as of `contact_segments`.
    """
    found: list[ContactSegments] = []
    for i, first in enumerate(first_images(pairs, sigma)):
        pair = pairs[i]
        found.append(contact_segments(pair, sigma[i]) if first == i else _mirrored_segments(found[first], pair))
    return found


def all_loaded(segments: Sequence[ContactSegments], loads: ArrayLike, *, tangents: bool) -> list[LoadedContact]:
    """`loaded_segments` of all segments at the same loads (F,) [N]; mirror images are solved once."""
    images = first_images([one.pair for one in segments], [one.sigma for one in segments])
    found: list[LoadedContact] = []
    for one, first in zip(segments, images, strict=True):
        if first == len(found):
            found.append(loaded_segments(one, loads, tangents=tangents))
        else:
            found.append(replace(found[first], segments=one, force=found[first].force[..., ::-1]))
    return found


def _equal(one: ContactPair, other: ContactPair) -> bool:
    """Whether two pairs are the same in every field; teeth are the same objects."""
    return all(getattr(one, name) == getattr(other, name) for name in one.__dataclass_fields__)


def _mirrored_plane(plane: PlaneOfAction) -> PlaneOfAction:
    a, b = ((-face[1], -face[0]) for face in (plane.face_a, plane.face_b))
    return replace(plane, lean=-plane.lean, face_a=a, face_b=b)


def _mirrored_flank(flank: Flank) -> Flank:
    return replace(flank, slope=-flank.slope)


def _mirrored_torsion(torsion: Torsion | None) -> Torsion | None:
    return None if torsion is None else replace(torsion, end="right" if torsion.end == "left" else "left")


def _mirrored_segments(segments: ContactSegments, pair: ContactPair) -> ContactSegments:
    """Segments of a pair that is the mirror image of that of `segments`, each at the same place among the (T, n)."""
    lines = segments.lines
    tooth, place = np.divmod(segments.index, lines.length.shape[2])
    return replace(
        segments,
        pair=pair,
        lines=replace(
            lines,
            zeta=-lines.zeta[..., ::-1],
            sigma=lines.sigma[..., ::-1],
            length=lines.length[..., ::-1],
            centre=-lines.centre[::-1],
        ),
        index=tooth * lines.length.shape[2] + lines.length.shape[2] - 1 - place,
        zeta=-segments.zeta,
    )
