"""Flanks: micro-geometry and what shapes the teeth of both gears of a mesh, for tooth contact."""

from __future__ import annotations

from itertools import pairwise

from ..document.schema import ModelFile, ProfileTable, ReliefTable, WaveTable
from ..errors import ModelError
from ..teeth import geometry
from ..teeth.contact_lines import PlaneOfAction
from ..teeth.flank import PLAIN, Flank, Relief, Wave, amounts, check_flank
from ..teeth.mesh_stiffness import ToothPair
from ..warning_codes import coded
from .bodies import half_station
from .centres import StageShape
from .gears import width_of
from .inheritance import Stated, stated, subtables
from .plan import GearPair, Plan
from .resolution_log import ResolutionLog
from .tooth_forms import tooth_form

__all__ = ["tooth_pair"]

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
    places = half_station(plan, p.a, side), half_station(plan, p.b, side)
    apart = (places[0] - places[1]) / 2
    teeth = ToothPair(
        form_a=tooth_form(shape, p.a, model, unnoted),
        form_b=tooth_form(shape, p.b, model, unnoted),
        base_a=a.nominal_base,
        base_b=b.nominal_base,
        pressure_angle=meshing.tooth_angle,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        limits=meshing.limits,
        face_a=(apart - widths[0] / 2, apart + widths[0] / 2),
        face_b=(-apart - widths[1] / 2, -apart + widths[1] / 2),
        flank_a=flanks[0],
        flank_b=flanks[1],
        paths=(_path(plan, p.a, side), _path(plan, p.b, side)),
    )
    _check(teeth, p.internal)
    for flank, path in zip(flanks, teeth.paths, strict=True):
        for name, size in amounts(flank):
            if abs(size) > _DOUBTFUL * a.module:
                words = f"more than a tenth of a module ({a.module * 1e3:.4g} mm); is the unit right?"
                log.warn(coded("modification-large", f"{path}.{name} = {size * 1e3:.4g} mm is {words}"))
    return teeth


def _check(teeth: ToothPair, internal: bool) -> None:
    """Raise ModelError for micro-geometry that does not fit the height and the width of its flank."""
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
        (teeth.flank_a, plane.radius_a, teeth.face_a, teeth.form_a, teeth.paths[0]),
        (teeth.flank_b, plane.radius_b, teeth.face_b, teeth.form_b, teeth.paths[1]),
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
        found = entry(key)
        if found is not None:
            log.note(found.path, found.value, "m")
        return 0.0 if found is None else float(found.value)

    def relief(key: str) -> Relief | None:
        """One relief, None where it is not stated."""
        found = entry(key)
        return None if found is None else _relief(found.value, found.path, log)

    crown, slope = length("crown"), length("slope")
    profile, wave = entry("profile"), entry("wave")
    return Flank(
        tip_relief=relief("tip_relief"),
        root_relief=relief("root_relief"),
        end_relief=relief("end_relief"),
        crown=crown,
        slope=slope,
        profile=() if profile is None else _profile(profile.value, profile.path),
        waves=() if wave is None else (_wave(wave.value),),
    )


def _path(plan: Plan, name: str, side: str | None) -> str:
    """Path of the flank of a gear in the file, of a side where it has its own."""
    found = stated(plan.member_levels(name, side), "flank")
    return f"{plan.member_path(name)}.flank" if found is None else found.path


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


def _wave(table: WaveTable) -> Wave:
    """Wave along the profile: amplitude [m], order [1], phase [rad]."""
    return Wave(amplitude=table.amplitude, order=table.order, phase=table.phase)
