"""Tooth contact as data of a train: the teeth of one pair of gears as drawn, and the table of their force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .flank import PLAIN, Flank
from .outline import GearForm
from .series import ComplexArray

__all__ = ["ContactTable", "ToothPair"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothPair:
    """Teeth of one mesh of one helix, as tooth contact needs them.

    form_a, form_b : form of teeth and body of the gears.  base_a, base_b : base radii of the teeth themselves [m].
    pressure_angle : working transverse pressure angle of the teeth [rad].  base_pitch : transverse [m].
    limits : (sigma_min, sigma_max) of the path of contact [base pitches].
    face_a, face_b : ends (left, right) of the faces along the axis, from the station of the mesh [m].
    flank_a, flank_b : micro-geometry.  paths : of both flanks in the model file.
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

    def __repr__(self) -> str:
        """One line: teeth and contact ratio."""
        ring = " ring" if self.form_b.internal else ""
        ratio = self.limits[1] - self.limits[0]
        return f"ToothPair({self.form_a.teeth}/{self.form_b.teeth}{ring}, contact ratio {ratio:.4g})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactTable:
    """Tabulated contact of a helix at S phases of a mesh cycle and L loads, the first of them zero.

    load : operating load [N].  stiffness : mean tangent stiffness there [N/m].  variation : (H,) relative series
    of the tangent over sigma [1].  error : complex one-sided amplitudes of the error e over sigma, at most H orders,
    the mean first [m].  force : (L,) [N].  gap : (S, L) d - e at sigma = 0, 1/S, ... [m]; the first column is first
    touch.  slope : (S, L) dF/dd [N/m].  last : force up to which all phases have data, where less than the largest [N].
    """

    load: float
    stiffness: float
    variation: ComplexArray
    error: ComplexArray
    force: Array
    gap: Array
    slope: Array
    last: float = np.inf

    @property
    def approach(self) -> Array:
        """d (S, L) [m]: the gap without the error of the linear model taken off."""
        S = len(self.gap)
        wave = np.exp(2j * np.pi * np.outer(np.arange(S) / S, np.arange(len(self.error))))
        approach: Array = self.gap + (wave @ self.error).real[:, None]
        return approach

    def __repr__(self) -> str:
        """One line: size of the table, operating load and mean tangent."""
        phases, loads = self.gap.shape
        return f"ContactTable({phases} phases x {loads} loads, {self.load:.4g} N, {self.stiffness:.4g} N/m)"
