"""Teeth of a mesh: their form, what shapes their flanks, and the load they are meant for.

Tooth forms of a mesh, the nominal load in operation, and mesh stiffness from the shape of the teeth.

Flanks: micro-geometry and what shapes the teeth of both gears of a mesh, for tooth contact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Literal

from ..document.schema import ModelFile, ProfileTable, ReliefTable
from ..errors import ModelError
from ..teeth import geometry
from ..teeth.form import PLAIN, Flank, GearForm, Relief, Wave, amounts, check_flank
from ..teeth.mesh_stiffness import ComplexArray, ToothPair
from ..teeth.path_of_contact import PlaneOfAction
from ..warning_codes import coded, placed
from .centres import StageShape
from .gears import half_station, width_of
from .stages import GearPair, Plan, Stated, elastic_constants, member_material, stated, stated_value, subtables
from .train import ResolutionLog

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
    count = shape.plan.branches_of(p) * len(meshing.width)
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
    from ..teeth.gear_pair import MeshedTeeth, energy_series, interference_warnings, ishikawa_series

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


# Part of a module above which micro-geometry is more often a slip in the unit: reliefs are a hundredth of it.
_DOUBTFUL = 0.1


def tooth_pair(
    shape: StageShape, p: GearPair, side: str | None, model: ModelFile, log: ResolutionLog
) -> ToothPair | None:
    """The teeth of one side of a pair; None without a face width of either gear.

    Raises
    ------
    ModelError : micro-geometry that is not complete or does not fit the flank.
    """
    plan = shape.plan
    widths = width_of(plan, p.a, side), width_of(plan, p.b, side)
    flanks = _flank(plan, p.a, side, log), _flank(plan, p.b, side, log)
    if widths[0] is None or widths[1] is None:
        return None
    a, b, meshing = shape.teeth[p.a], shape.teeth[p.b], shape.meshes[p.name]
    unnoted = ResolutionLog(assumed={})  # the default body is noted where a stiffness needs it
    at_a, at_b = (half_station(plan, name, side) - meshing.station[side] for name in (p.a, p.b))
    teeth = ToothPair(
        form_a=tooth_form(shape, p.a, model, unnoted),
        form_b=tooth_form(shape, p.b, model, unnoted),
        base_a=a.nominal_base,
        base_b=b.nominal_base,
        pressure_angle=meshing.tooth_angle,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        limits=meshing.limits,
        face_a=(at_a - widths[0] / 2, at_a + widths[0] / 2),
        face_b=(at_b - widths[1] / 2, at_b + widths[1] / 2),
        flank_a=flanks[0],
        flank_b=flanks[1],
        paths=(_path(plan, p.a, side), _path(plan, p.b, side)),
    )
    _check(teeth, p.internal, paths=(_stating_path(plan, p.a, side), _stating_path(plan, p.b, side)))
    for gear, flank in zip((p.a, p.b), flanks, strict=True):
        for name, size in amounts(flank):
            if abs(size) > _DOUBTFUL * a.module:
                key, *within = name.split(".")
                stating = stated(subtables(plan.levels(gear, side), "flank"), key)
                path = ".".join([stating.path if stating else key, *within])
                words = f"more than a tenth of a module ({a.module * 1e3:.4g} mm); is the unit right?"
                log.warn(coded("modification-large", f"{path} = {size * 1e3:.4g} mm is {words}"))
    return teeth


def _check(teeth: ToothPair, internal: bool, *, paths: tuple[str, str]) -> None:
    """Raise ModelError for micro-geometry that does not fit the height and the width of its flank.

    paths : where the file states the flanks of both gears.
    """
    plane = PlaneOfAction(
        base_a=teeth.base_a,
        base_b=teeth.base_b,
        internal=internal,
        pressure_angle=teeth.pressure_angle,
        base_pitch=teeth.base_pitch,
        limits=teeth.limits,
        face_a=teeth.face_a,
        face_b=teeth.face_b,
    )
    for flank, radius, face, form, path in (
        (teeth.flank_a, plane.radius_a, teeth.face_a, teeth.form_a, paths[0]),
        (teeth.flank_b, plane.radius_b, teeth.face_b, teeth.form_b, paths[1]),
    ):
        if flank != PLAIN:
            height = abs(float(radius(teeth.limits[1]) - radius(teeth.limits[0])))
            check_flank(flank, height=height, width=face[1] - face[0], teeth=form.teeth, path=path)


# micro-geometry ------------------------------------------------------------------------------------------------------


def _flank(plan: Plan, name: str, side: str | None, log: ResolutionLog) -> Flank:
    """Micro-geometry of one helix of a gear: every entry of its side, else the gear, else the stage."""
    levels = subtables(plan.levels(name, side), "flank")

    def entry(key: str) -> Stated | None:
        """Nearest statement of one entry of the micro-geometry."""
        return stated(levels, key)

    def length(key: str) -> float:
        """Crown or slope [m], 0 where it is not stated."""
        statement = entry(key)
        if statement is not None:
            log.note(statement.path, statement.value, "m")
        return 0.0 if statement is None else float(statement.value)

    def relief(key: str) -> Relief | None:
        """One relief, None where it is not stated."""
        statement = entry(key)
        return None if statement is None else _relief(statement.value, statement.path, log)

    crown, slope = length("crown"), length("slope")
    profile, wave = entry("profile"), entry("wave")
    return Flank(
        tip_relief=relief("tip_relief"),
        root_relief=relief("root_relief"),
        end_relief=relief("end_relief"),
        crown=crown,
        slope=slope,
        profile=() if profile is None else _profile(profile.value, profile.path),
        waves=(
            ()
            if wave is None
            else (Wave(amplitude=wave.value.amplitude, order=wave.value.order, phase=wave.value.phase),)
        ),
    )


def _path(plan: Plan, name: str, side: str | None) -> str:
    """Path of the flank of a gear in the file, of a side where it has its own: what is laid over it goes there."""
    statement = stated(plan.member_levels(name, side), "flank")
    return f"{plan.member_path(name)}.flank" if statement is None else statement.path


def _stating_path(plan: Plan, name: str, side: str | None) -> str:
    """Path at which the file states the flank of a gear: of the side, else the gear, else the stage."""
    statement = stated(plan.levels(name, side), "flank")
    return f"{plan.member_path(name)}.flank" if statement is None else statement.path


def _relief(table: ReliefTable, path: str, log: ResolutionLog) -> Relief:
    """Amount and length [m] and shape of a relief. Raises ModelError where amount or length is missing."""
    for key in ("amount", "length"):
        if getattr(table, key) is None:
            raise ModelError("is missing", path=f"{path}.{key}", allowed="a length")
        log.note(f"{path}.{key}", getattr(table, key), "m")
    log.note(f"{path}.shape", table.shape)
    return Relief(amount=table.amount or 0.0, length=table.length or 0.0, shape=table.shape)


def _profile(table: ProfileTable, path: str) -> tuple[tuple[float, float], ...]:
    """Measured profile: heights below the tip, missing material [m]. Raises ModelError unless heights rise."""
    if len(table.below_tip) != len(table.missing) or any(b <= a for a, b in pairwise(table.below_tip)):
        raise ModelError(
            "heights must rise, one for each deviation",
            path=path,
            given=f"{len(table.below_tip)}, {len(table.missing)}",
        )
    return tuple(zip(table.below_tip, table.missing, strict=True))
