"""Material of a gear or a coupling: of its own table, else the stage, else the file, else steel."""

from __future__ import annotations

from ..document.schema import ModelFile
from ..teeth.mesh_stiffness import STEEL_MODULUS
from .inheritance import Level, Levels, stated_value, subtables
from .plan import Plan

__all__ = ["density_of", "elastic_constants", "file_material", "member_material"]

STEEL_DENSITY = 7850.0  # [kg/m^3]
STEEL_POISSON = 0.3


def file_material(model: ModelFile) -> Levels:
    """The `material` table of the file."""
    return subtables((Level("file", "", model),), "material")


def member_material(plan: Plan, member: str, model: ModelFile) -> Levels:
    """The `material` tables of a member, its stage and the file, nearest first."""
    return (*subtables(plan.levels(member), "material"), *file_material(model))


def density_of(material: Levels) -> float:
    """Density [kg/m^3]."""
    return float(stated_value(material, "density", STEEL_DENSITY))


def elastic_constants(material: Levels) -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson's ratio [1]."""
    modulus = stated_value(material, "youngs_modulus", STEEL_MODULUS)
    return float(modulus), float(stated_value(material, "poisson_ratio", STEEL_POISSON))
