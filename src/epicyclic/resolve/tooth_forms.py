"""Tooth forms of a mesh, the nominal load in operation, and mesh stiffness from the shape of the teeth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from ..document.schema import ModelFile
from ..teeth.mesh_stiffness import ComplexArray
from ..teeth.outline import GearForm
from ..warning_codes import placed
from .centres import StageShape
from .inheritance import stated_value
from .materials import elastic_constants, member_material
from .plan import GearPair
from .resolution_log import ResolutionLog

__all__ = ["nominal_load", "tooth_form", "tooth_law"]

# Where the file states no thickness of the body: a hub of half the root diameter; a rim of 3.5 modules, which the
# standard holds for as good as solid.
_HUB, _RIM = 0.5, 3.5
_LOAD = 100e3  # per length of contact line where nothing is loaded [N/m]: the least for which ISO 6336-1 holds


def tooth_form(shape: StageShape, gear: str, model: ModelFile, log: ResolutionLog) -> GearForm:
    """Form of the teeth of a gear and of its body [m, Pa]; a default body is noted in the log."""
    data = next(iter(shape.gears[gear].values()))
    E, nu = elastic_constants(member_material(shape.plan, gear, model))
    # a given root diameter is a dedendum
    depth = data.root_radius - data.reference_radius if data.internal else data.reference_radius - data.root_radius
    return GearForm(
        teeth=data.teeth,
        module=data.module,
        pressure_angle=data.pressure_angle,
        helix_angle=data.helix_angle,
        profile_shift=data.profile_shift,
        addendum=data.addendum,
        dedendum=depth / data.module + data.profile_shift,
        tip_rounding=stated_value(shape.plan.levels(gear), "tip_rounding", None),
        tip_radius=data.tip_radius,
        internal=data.internal,
        bore=_held(shape, gear, log),
        youngs_modulus=E,
        poisson=nu,
    )


def _held(shape: StageShape, gear: str, log: ResolutionLog) -> float:
    """Radius at which the body of the gear is held [m]."""
    member, data = shape.plan.gears[gear], next(iter(shape.gears[gear].values()))
    path = shape.plan.member_path(gear)
    if data.internal:
        if member.outer_diameter is not None:
            return member.outer_diameter / 2
        if member.rim is None:
            log.note(f"{path}.rim", _RIM * data.module, "m", "default")
        return data.root_radius + (_RIM * data.module if member.rim is None else member.rim)
    if not member.bore:
        log.note(f"{path}.bore", 2 * _HUB * data.root_radius, "m", "for the stiffness of the teeth")
        return _HUB * data.root_radius
    return member.bore / 2


def nominal_load(shape: StageShape, p: GearPair, torque: Mapping[str, float] | None, width: float) -> float:
    """Load per length of contact line at the operation, evenly over branches and sides [N/m].

    torque : of each pair, as `Kinematics.mesh_torque`.  width : face width of one helix [m].
    """
    meshing = shape.meshes[p.name]
    count = len(shape.plan.angles) * len(meshing.width)
    passed = abs((torque or {}).get(p.path, 0.0)) / count
    # F = T/(r_b cos beta_b) over a mean length of eps_alpha b / cos beta_b
    load = passed / (shape.teeth[p.b].base_radius * meshing.contact_ratio * width)
    return load if load > 0 and math.isfinite(load) else _LOAD


def tooth_law(
    shape: StageShape,
    p: GearPair,
    side: str | None,
    model: ModelFile,
    torque: Mapping[str, float] | None,
    log: ResolutionLog,
    *,
    method: Literal["energy", "ishikawa"],
) -> tuple[float, ComplexArray]:
    """Mean stiffness of one helix along the tooth normal [N/m], and the relative series of a narrow slice of it.

    torque : of each pair, as `Kinematics.mesh_torque`.  method : by strain energy under the load of the operation, or
    Ishikawa's tooth, which knows no load.

    Raises
    ------
    ModelError : teeth that cannot be, that interfere, that part between pairs.
    """
    from ..teeth.compliance import tooth_compliance
    from ..teeth.energy_stiffness import MeshedTeeth, energy_series, interference_warnings, ishikawa_series

    meshing = shape.meshes[p.name]
    width = meshing.width[side]
    a, b = (
        tooth_compliance(tooth_form(shape, name, model, log), path=shape.plan.member_path(name)) for name in (p.a, p.b)
    )
    mesh = MeshedTeeth(a=a, b=b, working_angle=meshing.tooth_angle, limits=meshing.limits)
    if method == "ishikawa":
        mean, series = ishikawa_series(mesh, path=p.path)
    else:
        load = nominal_load(shape, p, torque, width)
        log.note(f"{p.path}.load_per_length", load, "N/m", "operation" if torque else "default")
        mean, series = energy_series(mesh, load, path=p.path)
    for text in (*a.warnings, *b.warnings, *interference_warnings(mesh, path=p.path, names=(p.a, p.b))):
        log.warn(placed(p.path, text))
    return mean * width / math.cos(mesh.base_helix), series
