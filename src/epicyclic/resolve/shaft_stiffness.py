"""Stiffness of a cylindrical shaft or neck, as springs at its middle."""

from __future__ import annotations

import math

from ..model.schema_links import SolidTable

__all__ = ["shaft_stiffness", "solid_stiffness"]


def shaft_stiffness(
    diameter: float, bore: float, length: float, youngs_modulus: float, poisson_ratio: float
) -> dict[str, float]:
    """Stiffness of a hollow cylinder between its two ends, seen at its middle, where all six directions uncouple.

    A beam with shear has the stiffness matrix of six springs at mid-length: axial E A/l, lateral
    12 E I/(l^3 (1 + Phi)), torsional G J/l, bending E I/l; Phi = 12 E I/(kappa G A l^2) and
    kappa = 6 (1 + nu)/(7 + 6 nu) of a solid round section [cowper1966].

    diameter, bore, length [m]; youngs_modulus [Pa]; poisson_ratio [1].  Returns x y z [N/m], rx ry rz [N m/rad].
    """
    shear_modulus = youngs_modulus / (2 * (1 + poisson_ratio))
    area = math.pi / 4 * (diameter**2 - bore**2)
    second_moment = math.pi / 64 * (diameter**4 - bore**4)
    kappa = 6 * (1 + poisson_ratio) / (7 + 6 * poisson_ratio)
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
