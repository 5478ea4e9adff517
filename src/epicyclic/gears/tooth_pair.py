"""The teeth of one pair of gears as drawn: what tooth contact starts from."""

from __future__ import annotations

from dataclasses import dataclass

from .flank import PLAIN, Flank
from .outline import GearForm

__all__ = ["ToothPair"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothPair:
    """The teeth of one mesh as tooth contact needs them, of one helix.

    form_a, form_b : what shapes teeth and body of the gears.  base_a, base_b : base radii of the teeth themselves [m].
    pressure_angle : working transverse angle of the teeth [rad].  base_pitch : transverse [m].
    limits : (sigma_min, sigma_max) of the path of contact [base pitches].
    face_a, face_b : ends (left, right) of the faces along the axis, from the mesh's station [m].
    flank_a, flank_b : micro-geometry.  paths : of both flanks in the file.
    """

    form_a: GearForm
    form_b: GearForm
    base_a: float
    base_b: float
    pressure_angle: float
    base_pitch: float
    limits: tuple[float, float]
    face_a: tuple[float, float]
    face_b: tuple[float, float]
    flank_a: Flank = PLAIN
    flank_b: Flank = PLAIN
    paths: tuple[str, str] = ("", "")
