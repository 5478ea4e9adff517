"""Stiffness of a cylindrical shaft or neck, as springs at its middle."""

from __future__ import annotations

import math

from ..document.schema_fields import SolidTable

__all__ = ["shaft_stiffness", "shear_coefficient", "solid_stiffness"]


def shaft_stiffness(
    diameter: float, bore: float, length: float, youngs_modulus: float, poisson_ratio: float
) -> dict[str, float]:
    """Stiffness of a hollow cylinder between its two ends, seen at its middle, where all six directions uncouple.

    A beam with shear has the stiffness matrix of six springs at mid-length: axial E A/l, lateral
    12 E I/(l^3 (1 + Phi)), torsional G J/l, bending E I/l; Phi = 12 E I/(kappa G A l^2) with kappa of
    `shear_coefficient`.

    diameter, bore, length [m]; youngs_modulus [Pa]; poisson_ratio [1].  Returns x y z [N/m], rx ry rz [N m/rad].
    """
    shear_modulus = youngs_modulus / (2 * (1 + poisson_ratio))
    area = math.pi / 4 * (diameter**2 - bore**2)
    second_moment = math.pi / 64 * (diameter**4 - bore**4)
    kappa = shear_coefficient(bore / diameter, poisson_ratio)
    shear = 12 * youngs_modulus * second_moment / (kappa * shear_modulus * area * length**2)
    lateral = 12 * youngs_modulus * second_moment / (length**3 * (1 + shear))
    bending = youngs_modulus * second_moment / length
    return {
        "x": lateral,
        "y": lateral,
        "z": youngs_modulus * area / length,
        "rx": bending,
        "ry": bending,
        "rz": shear_modulus * 2 * second_moment / length,
    }


def shear_coefficient(bore_ratio: float, poisson_ratio: float) -> float:
    """Shear coefficient kappa of a hollow circular section [1], that of a solid one at bore_ratio 0 [cowper1966].

    bore_ratio : inner per outer diameter m, 0 <= m < 1 [1].  poisson_ratio : nu [1].

    kappa = 6 (1 + nu) (1 + m^2)^2 / [(7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2].
    """
    wide = (1 + bore_ratio**2) ** 2
    return 6 * (1 + poisson_ratio) * wide / ((7 + 6 * poisson_ratio) * wide + (20 + 12 * poisson_ratio) * bore_ratio**2)


def solid_stiffness(table: SolidTable, length: float, material: tuple[float, float]) -> dict[str, float]:
    """Stiffness of a neck, shaft or coupling by its shape, x y z [N/m], rx ry rz [N m/rad]; rz alone from G J_p.

    length [m]; material : Young's modulus [Pa], Poisson's ratio.
    """
    if length <= 0:
        return {}
    found: dict[str, float] = {}
    if table.diameter is not None:
        found = shaft_stiffness(table.diameter, table.bore or 0.0, length, *material)
    if table.torsional_rigidity is not None:
        found["rz"] = table.torsional_rigidity / length
    return found
