"""Preselection of module and face width from the torque: a size to begin with, no rating of strength.

The load figure K = F_t/(b d_s) (u + 1)/u stays at or below 4 N/mm^2, about what case-hardened planetary gears carry,
with the face width b = 0.8 d_s and F_t = 1.15 T_s/(N d_s/2), 15 % for unequal sharing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...errors import ModelError
from .tooth_counts import ToothCounts

__all__ = ["LOAD_FIGURE", "GearSize", "load_figure", "size_of"]

LOAD_FIGURE = 4e6  # [Pa] K of the preselection
_WIDTH_RATIO = 0.8  # face width per sun diameter: wider, and the twist of the sun spoils the load along the face
_SHARING = 1.15  # unequal sharing, as for floating suns
# modules of series I of ISO 54 [m]
_SERIES = tuple(m * 1e-3 for m in (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40, 50))
_WIDTH_STEPS = (1e-3, 5e-3)  # [m] face widths below and above 50 mm are multiples of these
_TOOL = 1e-9  # a quotient this much above a whole number is that number


@dataclass(frozen=True, slots=True, kw_only=True)
class GearSize:
    """Normal module [m], face width [m], and the load figure K [Pa] they give."""

    module: float
    face_width: float
    load_figure: float


def size_of(
    counts: ToothCounts,
    planets: int,
    sun_torque: float,
    helix_angle: float,
    *,
    module: float | None,
    width: float | None,
) -> GearSize:
    """Module and face width of a set; given ones stay as they are.

    sun_torque : [N m], of either sign.  helix_angle : [rad].  module : normal [m].  width : [m].

    Raises
    ------
    ModelError : a load beyond the largest module of the series.
    """
    if module is None:
        least = _least_diameter(counts, planets, abs(sun_torque), width) * math.cos(helix_angle) / counts.sun
        module = next((m for m in _SERIES if m >= least * (1 - _TOOL)), None)
        if module is None:
            raise ModelError(
                f"asks for a module of {least * 1e3:.3g} mm",
                path="torque",
                given=f"{abs(sun_torque):.4g} N m at the sun",
                allowed="less torque, more planets, or a module of your own",
            )
    diameter = counts.sun * module / math.cos(helix_angle)
    if width is None:
        raw = _WIDTH_RATIO * diameter
        step = _WIDTH_STEPS[raw > 50e-3]
        width = round(math.ceil(raw / step * (1 - _TOOL)) * step, 6)
    return GearSize(
        module=module,
        face_width=width,
        load_figure=load_figure(counts, planets, sun_torque, diameter=diameter, width=width),
    )


def load_figure(counts: ToothCounts, planets: int, sun_torque: float, *, diameter: float, width: float) -> float:
    """K = F_t/(b d_s) (u + 1)/u [Pa] of the mesh of sun and planet; diameter of the sun and face width [m]."""
    force = _SHARING * abs(sun_torque) / (planets * diameter / 2)
    return force / (width * diameter) * _curvature(counts)


def _curvature(counts: ToothCounts) -> float:
    """(u + 1)/u with u = z_p/z_s: the pinion's diameter per that of the curvature of both [1]."""
    u = counts.planet / counts.sun
    return (u + 1) / u


def _least_diameter(counts: ToothCounts, planets: int, torque: float, width: float | None) -> float:
    """Least diameter of the sun [m] with which K stays below its limit; torque [N m], face width [m] where given."""
    area = 2 * _SHARING * torque * _curvature(counts) / (planets * LOAD_FIGURE)  # b d^2
    return (area / _WIDTH_RATIO) ** (1 / 3) if width is None else math.sqrt(area / width)
