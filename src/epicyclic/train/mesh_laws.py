"""Teeth of a mesh and the law of their force: form, micro-geometry, stiffness, damping and backlash.

Teeth have a form, what shapes the flanks of both gears, and the load they are meant for, that of the operation.  Their
stiffness has a mean and a variation over the place of contact: by a standard, from the shape of the teeth, as given, or
of loaded tooth contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from ..document.schema import ModelFile, ProfileTable, ReliefTable, VariationTable
from ..document.schema_fields import MeshForceTable
from ..document.units import Quantity
from ..errors import ModelError, in_mm
from ..teeth import geometry
from ..teeth import mesh_stiffness as teeth_stiffness
from ..teeth.form import Flank, GearForm, Relief, Wave, amounts, check_flanks
from ..teeth.mesh_stiffness import (
    STEEL_MODULUS,
    ComplexArray,
    ContactTable,
    ToothPair,
    force_curve,
    fourier_series,
    given_table,
    series_in_time,
    table_series,
)
from ..warning_codes import CodedText, placed
from .centres import MeshShape, StageShape
from .gears import half_station, width_of
from .kinematics import Kinematics
from .stages import GearPair, Levels, Plan, Stated, elastic_constants, member_material, stated, stated_value, subtables
from .train import Mesh, MeshError, ResolutionLog, per_branch

RING_ORDERS = 12  # of a ring that bends
# what the form of teeth has as the gear has it
_ALIKE = ("teeth", "module", "pressure_angle", "helix_angle", "profile_shift", "addendum", "tip_radius", "internal")
# Where the file states no thickness of the body: a hub of half the root diameter; a rim of 3.5 modules, which the
# standard holds for as good as solid.
_HUB, _RIM = 0.5, 3.5
_LOAD = 100e3  # per length of contact line where nothing is loaded [N/m]: the least for which ISO 6336-1 holds


@dataclass(frozen=True, slots=True)
class MeshSide:
    """One side of a pair of a stage, None of one in one piece, and what its stiffness is taken from.

    torque : of each pair [N m], as `Kinematics.mesh_torque`.
    """

    shape: StageShape
    pair: GearPair
    side: str | None
    model: ModelFile
    torque: Mapping[str, float] | None
    log: ResolutionLog

    @property
    def meshing(self) -> MeshShape:
        """The pair at its working place."""
        return self.shape.meshes[self.pair.name]

    @property
    def base_helix(self) -> float:
        """Base helix angle, magnitude [rad]."""
        return self.shape.gear(self.pair.a).base_helix

    @property
    def width(self) -> float:
        """Common face width [m]; nan where it is not stated."""
        return self.meshing.width[self.side]

    def needed_width(self, path: str) -> float:
        """Common face width [m]. Raises ModelError where it is not stated; path : of the stiffness that needs it."""
        if math.isnan(self.width):
            problem = "is missing: the mesh stiffness needs it"
            allowed = f"a face width of the stage or of {self.pair.a} and {self.pair.b}, or {path} in N/m"
            raise ModelError(problem, path=f"{self.shape.plan.path}.face_width", allowed=allowed)
        return self.width

    @property
    def overlap(self) -> float:
        """Overlap ratio of one helix [1]."""
        first = next(iter(self.meshing.width.values()))
        if self.width == first or not self.shape.gear(self.pair.a).helix_angle:
            return self.meshing.overlap_ratio
        return self.meshing.overlap_ratio * self.width / first

    @property
    def passed_torque(self) -> float:
        """Size of the torque of the operation on gear b, evenly over branches and sides [N m]."""
        count = self.shape.plan.branches_of(self.pair) * len(self.meshing.width)
        return abs((self.torque or {}).get(self.pair.path, 0.0)) / count

    @property
    def operating_load(self) -> float | None:
        """Mean force of the operation along the normal of one helix [N]; None without."""
        load = self.passed_torque / (self.shape.gear(self.pair.b).base_radius * math.cos(self.base_helix))
        return load if load > 0 and math.isfinite(load) else None

    def stated(self, key: str) -> Stated | None:
        """Value of a key of the mesh where the file states it."""
        return stated(self.pair.levels(self.side), key)

    def value(self, key: str, default: Any) -> Any:
        """Value of a key of the mesh, else `default`."""
        return stated_value(self.pair.levels(self.side), key, default)

    def elasticity(self, gear: str) -> float:
        """Young's modulus of a gear [Pa]."""
        return elastic_constants(member_material(self.shape.plan, gear, self.model))[0]


def tooth_form(shape: StageShape, gear: str, model: ModelFile, log: ResolutionLog) -> GearForm:
    """Form of the teeth of a gear and of its body [m, Pa]; a default body is noted in the log."""
    data = shape.gear(gear)
    E, nu = elastic_constants(member_material(shape.plan, gear, model))
    # a given root diameter is a dedendum
    depth = data.root_radius - data.reference_radius if data.internal else data.reference_radius - data.root_radius
    return GearForm(
        **{key: getattr(data, key) for key in _ALIKE},
        dedendum=depth / data.module + data.profile_shift,
        tip_rounding=stated_value(shape.plan.levels(gear), "tip_rounding", None),
        bore=_held(shape, gear, log),
        bends=0 if (elastic := shape.plan.gears[gear].elastic) is None else elastic.modes or RING_ORDERS,
        youngs_modulus=E,
        poisson=nu,
    )


def _held(shape: StageShape, gear: str, log: ResolutionLog) -> float:
    """Radius at which the body of the gear is held [m]."""
    member, data = shape.plan.gears[gear], shape.gear(gear)
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


def nominal_load(at: MeshSide, width: float) -> float:
    """Load per length of contact line at the operation [N/m]; width : face width of one helix [m]."""
    # F = T/(r_b cos beta_b) over a mean length of eps_alpha b / cos beta_b
    load = at.passed_torque / (at.shape.gear(at.pair.b).base_radius * at.meshing.contact_ratio * width)
    return load if load > 0 and math.isfinite(load) else _LOAD


def tooth_law(at: MeshSide, method: str, path: str) -> tuple[float, ComplexArray]:
    """Mean stiffness of one helix along the tooth normal [N/m], and the relative series of a narrow slice of it.

    method : by strain energy under the load of the operation, or Ishikawa's tooth, which knows no load.
    path : of the stiffness that needs it.

    Raises
    ------
    ModelError : no face width, teeth that cannot be, that interfere, that part between pairs.
    """
    from ..teeth.compliance import tooth_compliance
    from ..teeth.gear_pair import MeshedTeeth, cycle_series, energy_series, interference_warnings, ishikawa_stiffness

    p, log, width, meshing = at.pair, at.log, at.needed_width(path), at.meshing
    a, b = (
        tooth_compliance(tooth_form(at.shape, name, at.model, log), path=at.shape.plan.member_path(name))
        for name in (p.a, p.b)
    )
    mesh = MeshedTeeth(a=a, b=b, working_angle=meshing.tooth_angle, limits=meshing.limits)
    if method == "ishikawa":
        mean, series = cycle_series(mesh, partial(ishikawa_stiffness, mesh), path=p.path)
    else:
        load = nominal_load(at, width)
        log.note(f"{p.path}.load_per_length", load, "N/m", "operation" if at.torque else "default")
        mean, series = energy_series(mesh, load, path=p.path)
    for text in interference_warnings(mesh, path=p.path, names=(p.a, p.b)):
        log.warn(placed(p.path, text))
    return mean * width / math.cos(mesh.base_helix), series


# Part of a module above which micro-geometry is more often a slip in the unit: reliefs are a hundredth of it.
_DOUBTFUL = 0.1


def tooth_pair(at: MeshSide) -> ToothPair | None:
    """The teeth of one side of a pair; None without a face width of either gear.

    Raises
    ------
    ModelError : micro-geometry that is not complete or does not fit the flank.
    """
    shape, plan, p, side, log = at.shape, at.shape.plan, at.pair, at.side, at.log
    widths = width_of(plan, p.a, side), width_of(plan, p.b, side)
    flanks = _flank(plan, p.a, side, log), _flank(plan, p.b, side, log)
    if widths[0] is None or widths[1] is None:
        return None
    a, b, meshing = shape.gear(p.a), shape.gear(p.b), at.meshing
    unnoted = ResolutionLog(assumed={})  # the default body is noted where a stiffness needs it
    at_a, at_b = (half_station(plan, name, side) - meshing.station[side] for name in (p.a, p.b))
    teeth = ToothPair(
        form_a=tooth_form(shape, p.a, at.model, unnoted),
        form_b=tooth_form(shape, p.b, at.model, unnoted),
        base_a=a.nominal_base,
        base_b=b.nominal_base,
        pressure_angle=meshing.tooth_angle,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        limits=meshing.limits,
        face_a=(at_a - widths[0] / 2, at_a + widths[0] / 2),
        face_b=(at_b - widths[1] / 2, at_b + widths[1] / 2),
        flank_a=flanks[0],
        flank_b=flanks[1],
        paths=(
            _flank_path(plan, p.a, plan.member_levels(p.a, side)),  # what is laid over it does not go to the stage
            _flank_path(plan, p.b, plan.member_levels(p.b, side)),
        ),
    )
    stating_a, stating_b = (_flank_path(plan, name, plan.levels(name, side)) for name in (p.a, p.b))
    numbers = teeth.form_a.teeth, teeth.form_b.teeth
    check_flanks(teeth.plane(), flanks, numbers, (stating_a, stating_b))
    for gear, flank in zip((p.a, p.b), flanks, strict=True):
        for name, size in amounts(flank):
            if abs(size) > _DOUBTFUL * a.module:
                key, *within = name.split(".")
                stating = stated(subtables(plan.levels(gear, side), "flank"), key)
                path = ".".join([stating.path if stating else key, *within])
                words = f"more than a tenth of a module ({in_mm(a.module, 4)}); is the unit right?"
                log.coded("modification-large", f"{path} = {in_mm(size, 4)} is {words}")
    return teeth


# micro-geometry ------------------------------------------------------------------------------------------------------


def _flank(plan: Plan, name: str, side: str | None, log: ResolutionLog) -> Flank:
    """Micro-geometry of one helix of a gear: every entry of its side, else the gear, else the stage."""
    levels = subtables(plan.levels(name, side), "flank")

    def length(key: str) -> float:
        """Crown or slope [m], 0 where it is not stated."""
        statement = stated(levels, key)
        if statement is not None:
            log.note(statement.path, statement.value, "m")
        return 0.0 if statement is None else float(statement.value)

    def relief(key: str) -> Relief | None:
        """One relief, None where it is not stated. Raises ModelError where its amount or length is missing."""
        if (statement := stated(levels, key)) is None:
            return None
        table: ReliefTable = statement.value
        for name in ("amount", "length"):
            if getattr(table, name) is None:
                raise ModelError("is missing", path=f"{statement.path}.{name}", allowed="a length")
            log.note(f"{statement.path}.{name}", getattr(table, name), "m")
        log.note(f"{statement.path}.shape", table.shape)
        return Relief(amount=table.amount or 0.0, length=table.length or 0.0, shape=table.shape)

    crown, slope = length("crown"), length("slope")
    profile, wave = stated(levels, "profile"), stated(levels, "wave")
    return Flank(
        tip_relief=relief("tip_relief"),
        root_relief=relief("root_relief"),
        end_relief=relief("end_relief"),
        crown=crown,
        slope=slope,
        profile=() if profile is None else _profile(profile.value, profile.path),
        waves=() if wave is None else (Wave(**wave.value.model_dump()),),
    )


def _flank_path(plan: Plan, name: str, levels: Levels) -> str:
    """Path at which the file states the flank of a gear, at the nearest of some levels; else that of the gear."""
    statement = stated(levels, "flank")
    return f"{plan.member_path(name)}.flank" if statement is None else statement.path


def _profile(table: ProfileTable, path: str) -> tuple[tuple[float, float], ...]:
    """Measured profile: heights below the tip, missing material [m]. Raises ModelError unless heights rise."""
    if len(table.below_tip) != len(table.missing) or any(b <= a for a, b in pairwise(table.below_tip)):
        problem = "heights must rise, one for each deviation"
        raise ModelError(problem, path=path, given=f"{len(table.below_tip)}, {len(table.missing)}")
    return tuple(zip(table.below_tip, table.missing, strict=True))


# stiffness and its variation ------------------------------------------------------------------------------------------

STEEL_GRADES = 0.1  # steels differ by less in Young's modulus
NORMAL_RANGE = (10e9, 30e9)  # stiffness per face width of steel teeth, transverse [N/m^2]
# Methods that give mean and variation from the shape of the teeth.
_BY_SHAPE = ("energy", "ishikawa")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshLaw:
    """Stiffness of one side of a pair: per branch along the tooth normal [N/m], and its relative series over sigma.

    narrow : the series of a slice without width, where the helix brings slices into mesh one after the other; None
        where all follow the whole.  table : force of loaded tooth contact, which then gives stiffness and variation.
    """

    stiffness: tuple[float, ...]
    variation: ComplexArray
    narrow: ComplexArray | None
    table: ContactTable | None = None


def mesh_law(at: MeshSide, *, teeth: ToothPair | None, lean: int) -> MeshLaw:
    """Stiffness [N/m] of one side of a pair, and its variation.

    teeth : of the mesh.  lean : d h of its first gear.

    Raises
    ------
    ModelError : a stiffness that needs a face width without one, teeth that cannot touch.
    """
    shape, p, side, log = at.shape, at.pair, at.side, at.log
    statement = at.stated("stiffness")
    value = "iso6336" if statement is None else statement.value
    for gear in (p.a, p.b):
        member, apart = shape.plan.gears[gear], value in ("energy", "contact")
        if member.reduced is not None or (member.elastic is not None and not apart):
            text = f"{p.path}.stiffness: {shape.plan.member_path(gear)} bends by coordinates of its own"
            log.coded("rim-in-stiffness", f"{text}; what the stiffness has of its rim or body counts twice")
    if statement is not None and isinstance(value, MeshForceTable):
        return _given_law(at, statement)
    path = f"{p.path}.stiffness" if statement is None else statement.path
    count, computed = len(shape.plan.angles), not isinstance(value, Quantity)
    form = _form(at, str(value) if computed else "")
    loaded = None
    if value == "contact":
        at.needed_width(path)
        if teeth is None:
            problem = "is missing: loaded contact needs the face of either gear"
            allowed = f"a face width of the stage, or of {p.a} and of {p.b}"
            raise ModelError(problem, path=f"{shape.plan.path}.face_width", allowed=allowed)
        loaded = _contact_law(at, teeth, lean)
    # where mean and variation are of two methods, the series is that of the variation
    by_shape = {method: tooth_law(at, method, path) for method in _BY_SHAPE if method in (value, form)}
    if isinstance(value, Quantity):
        stiffness = per_branch(_normal(at, value, path), count)
    elif value in by_shape:
        stiffness = (by_shape[value][0],) * count
    else:
        stiffness = (_standard(at, path) if loaded is None else loaded.stiffness,) * count
    note = stiffness[0] if len(set(stiffness)) == 1 else list(stiffness)
    by_side = len(set(at.meshing.width.values())) > 1 or (statement is not None and statement.level == "side")
    where = f"{p.path}.{side}.stiffness" if side and by_side else f"{p.path}.stiffness"
    log.note(where, note, "N/m", f"{value or 'iso6336'}" if computed else "given")
    _check_range(at, stiffness)
    if loaded is not None and form == "contact":
        log.note(f"{p.path}.variation", form, "", "default")
        return MeshLaw(stiffness=stiffness, variation=loaded.variation, narrow=None, table=loaded)
    variation, narrow = _variation(at, form, by_shape[form][1] if form in by_shape else None)
    return MeshLaw(stiffness=stiffness, variation=variation, narrow=narrow)


def _normal(at: MeshSide, given: Quantity, path: str) -> float | tuple[float, ...]:
    """A given stiffness along the tooth normal of one helix [N/m]."""
    factor = at.needed_width(path) if given.unit == "N/m^2" else 1.0
    factor /= _transverse_cosine(at) ** 2
    if isinstance(given.value, tuple):
        return tuple(value * factor for value in given.value)
    return given.value * factor


def _transverse_cosine(at: MeshSide) -> float:
    """cos beta_b [1] where the stiffness is given along the transverse line of action, else 1."""
    return math.cos(at.base_helix) if at.value("direction", "normal") == "transverse" else 1.0


def _standard(at: MeshSide, path: str) -> float:
    """Mean stiffness along the tooth normal of one helix by ISO 6336-1 [N/m]."""
    width, p = at.needed_width(path), at.pair
    a, b = at.shape.gear(p.a), at.shape.gear(p.b)
    single, limits = teeth_stiffness.iso6336_single_stiffness(
        a.teeth,
        b.teeth,
        a.pressure_angle,
        a.helix_angle,
        internal=p.internal,
        shift_a=a.profile_shift,
        shift_b=b.profile_shift,
        dedendum_a=a.dedendum,
        dedendum_b=b.dedendum,
        youngs_modulus_a=at.elasticity(p.a),
        youngs_modulus_b=at.elasticity(p.b),
    )
    mean, more = teeth_stiffness.iso6336_mesh_stiffness(single, at.meshing.contact_ratio)
    for text in (*limits, *more):
        at.log.warn(placed(path, text))
    return teeth_stiffness.normal_from_transverse(mean * width, a.base_helix)


def _check_range(at: MeshSide, stiffness: Sequence[float]) -> None:
    """Warn of a stiffness [N/m] per face width outside the range of teeth of these materials.

    Two teeth in series of moduli E_a and E_b are softer than steel by 2 E_a E_b/(E_a + E_b)/E_steel [iso6336].
    """
    if math.isnan(at.width):
        return
    a, b = at.elasticity(at.pair.a), at.elasticity(at.pair.b)
    softer = 2 * a * b / (a + b) / STEEL_MODULUS
    steel = abs(softer - 1) < STEEL_GRADES
    least, most = (edge * (1.0 if steel else softer) for edge in NORMAL_RANGE)
    for value in sorted(set(stiffness)):
        per_width = value * math.cos(at.base_helix) ** 2 / at.width
        if not least <= per_width <= most:
            kind = "steel teeth" if steel else "teeth of these materials"
            text = f"{at.pair.path}.stiffness: {per_width / 1e9:.3g} N/(mm um) of face width, {kind} have"
            at.log.coded("stiffness-unusual", f"{text} {least / 1e9:.3g} .. {most / 1e9:.3g}")


def _form(at: MeshSide, method: str) -> str:
    """Form of the variation of the stiffness: stated, else that of its method."""
    variation: VariationTable | None = at.value("variation", None)
    if variation is not None:
        return variation.form
    if method in ("contact", *_BY_SHAPE):
        return method
    return "contact-lines" if method else "none"


def _variation(at: MeshSide, form: str, by_shape: ComplexArray | None) -> tuple[ComplexArray, ComplexArray | None]:
    """Relative Fourier coefficients (L,) over sigma [1], and those of a narrow slice where the helix shifts slices.

    by_shape : series (L,) of a narrow slice by the shape of the teeth.
    """
    path, statement = f"{at.pair.path}.variation", at.stated("variation")
    if form in ("none", "contact-lines", *_BY_SHAPE):
        at.log.note(path, form, "", "default" if statement is None else "given")
    if form in ("contact-lines", *_BY_SHAPE):
        if math.isnan(at.overlap):
            at.needed_width(f"{at.pair.path}.stiffness")
        if at.meshing.contact_ratio <= 0:
            raise ModelError("the teeth do not touch: contact ratio below 0", path=at.pair.path)
        lines = teeth_stiffness.contact_line_series(at.meshing.limits, 0.0)
        narrow = lines if by_shape is None or form == "contact-lines" else by_shape
        return teeth_stiffness.face_average(narrow, at.overlap), narrow
    if statement is None or form == "none":
        return np.zeros(0, complex), None
    table: VariationTable = statement.value
    values = table_series(table.values)[1] if form == "values" else fourier_series(table.cosine, table.sine)
    _check_positive(values, statement.path)
    return values, None


def _check_positive(series: ComplexArray, path: str) -> None:
    """Raise ModelError where a stiffness that varies by a series (L,) is not above 0 over the whole mesh cycle."""
    if not series.size:
        return
    # 64 points a wave of the highest order: the least value between them is missed by a thousandth of its amplitude
    count = 64 * series.size
    spectrum = np.concatenate([[1.0], 0.5 * series, np.zeros(count // 2 - series.size, complex)])
    least = float(np.fft.irfft(spectrum * count, count).min())
    if not least > 0.0:
        problem = "the mesh stiffness does not stay above 0"
        allowed = "a variation above -1 of the mean over the whole mesh cycle"
        raise ModelError(problem, path=path, given=f"{least:.3g} of its mean at the least", allowed=allowed)


# given tables ---------------------------------------------------------------------------------------------------------


def _given_law(at: MeshSide, statement: Stated) -> MeshLaw:
    """Law of one side of a pair by the table of force over deflection that the file states.

    Raises
    ------
    ModelError : a variation beside the table.
    """
    given: MeshForceTable = statement.value
    log = at.log
    if (beside := at.stated("variation")) is not None:
        problem = f"stands beside a table of force in {statement.path}, which holds it"
        allowed = "forces of several phases of the mesh cycle, or no variation"
        raise ModelError(problem, path=beside.path, given=beside.value.form, allowed=allowed)
    cosine = _transverse_cosine(at)
    # F_n = F_t / cos beta_b, d_n = d_t cos beta_b
    curves = tuple(force_curve(*curve).scaled(deflection=cosine, force=1 / cosine) for curve in given.curves)
    load, origin = at.operating_load, "operation"
    middle = max(curve.force[-1] for curve in curves) / 2
    if given.load is not None:
        load, origin = given.load / cosine, "given"
    elif load is None:
        load, origin = middle, "half of the last force"
        _warn_assumed_load(at, load, "half of the last force of its table")
    table = given_table(curves, load)
    transverse = cosine != 1.0
    log.note(f"{statement.path}.load", load * cosine, "N", f"{origin}, transverse" if transverse else origin)
    if transverse:
        log.note(f"{statement.path}.normal_load", load, "N", "along the tooth normal")
    tangent = "table, along the tooth normal" if transverse else "table"
    log.note(f"{statement.path}.tangent", table.stiffness, "N/m", tangent)
    if load > table.last:
        text = f"{statement.path}: the load {load:.4g} N lies behind the last force of the table, {table.last:.4g} N"
        log.coded("table-exceeded", f"{text} along the normal; there the law goes on along its last tangent")
    _check_range(at, (table.stiffness,))
    return MeshLaw(
        stiffness=(table.stiffness,) * len(at.shape.plan.angles),
        variation=table.variation,
        narrow=None,
        table=table,
    )


def _warn_assumed_load(at: MeshSide, force: float, why: str) -> None:
    """Warn of a tangent at a normal force [N] that is not of the operation."""
    text = f"{at.pair.path}: no torque passes this mesh: verbs that take the tangent of its force take it at"
    at.log.coded("tangent-load-assumed", f"{text} {force / 1e3:.4g} kN, {why}")


# loaded tooth contact -------------------------------------------------------------------------------------------------


def _contact_law(at: MeshSide, teeth: ToothPair, lean: int) -> ContactTable:
    """Table of one helix around the mean force of the operation; lean : d h of gear a.

    Raises
    ------
    ModelError : what loaded contact refuses, see `gear_pair.check_pair`.
    """
    p, log = at.pair, at.log
    width = min(teeth.face_a[1], teeth.face_b[1]) - max(teeth.face_a[0], teeth.face_b[0])
    load = nominal_load(at, width)
    passed = at.operating_load is not None
    log.note(f"{p.path}.load_per_length", load, "N/m", "operation" if passed else "default")
    force = load * at.meshing.contact_ratio * width / math.cos(at.base_helix)
    if not passed:
        _warn_assumed_load(at, force, f"{load / 1e3:.4g} N/mm")
    table, messages = _table_of_pair(teeth, at.base_helix, lean, force, p.path, (p.a, p.b))
    for text in messages:
        log.warn(placed(p.path, text))
    return table


@lru_cache(maxsize=64)
def _table_of_pair(
    teeth: ToothPair, base_helix: float, lean: int, force: float, path: str, names: tuple[str, str]
) -> tuple[ContactTable, tuple[CodedText, ...]]:
    """Table of one pair around a normal force [N], and its warnings; kept, because sides and branches share it."""
    # heavy, and needed by loaded contact alone
    from ..teeth.gear_pair import check_pair, drawn_pair, interference_warnings, meshed_teeth
    from ..teeth.loaded_contact import contact_table

    pair = drawn_pair(teeth, base_helix=base_helix, lean=lean)
    check_pair(pair, path=path, paths=teeth.paths)
    table = contact_table(pair, force)
    return table, interference_warnings(meshed_teeth(pair), path=path, names=names)


def contact_errors(meshes: Sequence[Mesh], kinematics: Kinematics) -> Iterator[MeshError]:
    """What the flanks of tabulated meshes add to the gap of a linear model: a mean, and orders of the mesh frequency.

    Without speeds the mean alone.
    """
    for mesh in meshes:
        if mesh.table is None:
            continue
        series = series_in_time(mesh.table.error[1:], lead=mesh.lead, sense=mesh.sense)
        frequency = (kinematics.mesh_frequency or {}).get(mesh.stage)
        error = MeshError(
            path=f"{mesh.pair}.stiffness",
            cause="contact",
            mesh=mesh.name,
            amplitude=complex(mesh.table.error[0].real),
            frequency=Fraction(0),
        )
        lines = [(order * frequency, value) for order, value in enumerate(series.tolist(), start=1) if frequency]
        every = (error, *(replace(error, amplitude=value, frequency=line) for line, value in lines))
        yield from (one for one in every if one.amplitude)
