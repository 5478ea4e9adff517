"""Mesh stiffness by Ishikawa's tooth: a trapezoid on a rectangle, clamped in the root section [ishikawa1957].

The root section is that of `tooth`, where the fillet leans by 30 degrees (of a ring 60).  The tooth is a rectangle of
its thickness s_F from there to the beginning of the involute, and above it a trapezoid to the chord s_K of the tip; h_i
is the height at which its sides would meet.  A load F per width b under the angle w to the cross line, on the flank at
the height h_x, moves its point along its own line by

    rectangle   12 F cos^2 w/(E b s_F^3) [h_x h_r (h_x - h_r) + h_r^3/3]
    trapezoid   6 F cos^2 w/(E b s_F^3) (h_i - h_r)^3 [u (4 - u) - 2 ln u - 3],   u = (h_i - h_x)/(h_i - h_r)
    shear       2 (1 + nu) F cos^2 w/(E b s_F) [h_r + (h_i - h_r) ln(1/u)]
    root        24 F h_x^2 cos^2 w/(pi E b s_F^2), the tilt of the elastic root
    contact     2 F/(pi b) [(1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b], of a pair

in plane stress.  Every height is along the centre line of the tooth from the middle of the root section; h_x is that of
the point of the flank that touches, not of where the line of the load crosses the centre line; of h_r no more than h_x
counts.  Pairs of teeth are
springs in parallel: the gear bodies do not couple them.  A ring tooth has the same shape, its tip inside.  Helical
teeth: the normal section, per length of contact line, without coupling along the face.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..gears.series import ComplexArray
from ..gears.stiffness import DEFAULT_HARMONICS
from .energy import MeshedTeeth, cycle_series
from .tooth import ToothCompliance

__all__ = ["IshikawaParts", "IshikawaTooth", "ishikawa_series", "ishikawa_stiffness", "ishikawa_tooth"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class IshikawaParts:
    """Compliance of a tooth by cause, each (...) [m^2/N]: displacement along the load per load per length."""

    rectangle: Array
    trapezoid: Array
    shear: Array
    root: Array

    @property
    def whole(self) -> Array:
        """Sum of all parts (...) [m^2/N]."""
        return self.rectangle + self.trapezoid + self.shear + self.root


@dataclass(frozen=True, slots=True, kw_only=True)
class IshikawaTooth:
    """Rectangle and trapezoid; lengths [m].

    thickness : s_F.  tip_thickness : s_K.  rectangle : height h_r.  height : h of the tip above the root section.
    youngs_modulus : [Pa].
    """

    thickness: float
    tip_thickness: float
    rectangle: float
    height: float
    youngs_modulus: float
    poisson: float

    @property
    def apex(self) -> float:
        """Height h_i at which the sides of the trapezoid would meet [m]."""
        s, k = self.thickness, self.tip_thickness
        return (self.height * s - self.rectangle * k) / (s - k)

    def parts(self, height: ArrayLike, angle: ArrayLike) -> IshikawaParts:
        """Compliance under loads at heights h_x (...) above the root section [m], at angles w (...) [rad]."""
        at, across = np.asarray(height, dtype=float), np.cos(angle) ** 2
        E, s, low = self.youngs_modulus, self.thickness, np.minimum(self.rectangle, height)
        over = self.apex - low
        u = (self.apex - at) / over
        return IshikawaParts(
            rectangle=12 * across / (E * s**3) * (at * low * (at - low) + low**3 / 3),
            trapezoid=6 * across / (E * s**3) * over**3 * (u * (4 - u) - 2 * np.log(u) - 3),
            shear=2 * (1 + self.poisson) * across / (E * s) * (low - over * np.log(u)),
            root=24 * at**2 * across / (math.pi * E * s**2),
        )


def ishikawa_tooth(tooth: ToothCompliance) -> IshikawaTooth:
    """Ishikawa's tooth of the normal section of a gear."""
    shape = tooth.outline
    return IshikawaTooth(
        thickness=tooth.thickness,
        tip_thickness=2 * float(shape.x[0]),
        rectangle=tooth.height - float(shape.depth[shape.form]),
        height=tooth.height - float(shape.depth[0]),
        youngs_modulus=tooth.gear.youngs_modulus,
        poisson=tooth.gear.poisson,
    )


def ishikawa_stiffness(mesh: MeshedTeeth, sigma: ArrayLike) -> Array:
    """Stiffness (n,) along the normal per length of contact line of one plane section [N/m^2], pairs in parallel.

    sigma : (n,) [base pitches].  Zero where no pair is in contact.
    """
    low, high = mesh.limits
    place = np.asarray(sigma, dtype=float)
    pairs = np.arange(math.floor(low - float(place.max())), math.ceil(high - float(place.min())) + 1)
    at = place[:, None] + pairs
    on = (at >= low) & (at <= high)
    gears = mesh.a.gear, mesh.b.gear
    contact = 2 / math.pi * sum((1 - gear.poisson**2) / gear.youngs_modulus for gear in gears)
    whole = np.full(at.shape, contact)
    for tooth, radius in zip((mesh.a, mesh.b), mesh.radii(np.clip(at, low, high)), strict=True):
        virtual = radius + tooth.gear.to_virtual
        psi, gamma = tooth.outline.flank_angle(virtual)
        height = tooth.height - np.abs(tooth.outline.tip - virtual * np.cos(psi))
        whole = whole + ishikawa_tooth(tooth).parts(height, gamma).whole
    return np.asarray(np.where(on, 1 / whole, 0.0).sum(axis=1))


def ishikawa_series(
    mesh: MeshedTeeth, *, harmonics: int = DEFAULT_HARMONICS, path: str = ""
) -> tuple[float, ComplexArray]:
    """Mean stiffness of a plane section over a mesh cycle [N/m^2] and its relative series v_l (L,) over sigma [1].

    path : of the mesh in the model file, for the message.

    Raises
    ------
    ModelError : as of `energy.cycle_series`.
    """
    return cycle_series(mesh, lambda sigma: ishikawa_stiffness(mesh, sigma), harmonics=harmonics, path=path)
