"""Mesh stiffness: mean, variation over the place of contact, loaded tooth contact; damping and backlash."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..document.schema import ModelFile, VariationTable
from ..document.schema_fields import MeshForceTable
from ..document.units import Quantity
from ..errors import ModelError
from ..teeth import mesh_stiffness as teeth_stiffness
from ..teeth.mesh_stiffness import (
    STEEL_MODULUS,
    ContactTable,
    ToothPair,
    force_curve,
    fourier_series,
    given_table,
    series_in_time,
    table_series,
)
from ..warning_codes import CodedText, coded, placed
from .bodies import Mesh
from .centres import MeshShape, StageShape
from .flanks import nominal_load, tooth_law
from .kinematics import Kinematics
from .stages import GearPair, Stated, elastic_constants, member_material, stated, stated_value
from .train import MeshError, ResolutionLog, per_branch

STEEL_GRADES = 0.1  # steels differ by less in Young's modulus
NORMAL_RANGE = (10e9, 30e9)  # stiffness per face width of steel teeth, transverse [N/m^2]
Series = NDArray[np.complex128]
# Methods that give mean and variation from the shape of the teeth.
_BY_SHAPE: tuple[Literal["energy", "ishikawa"], ...] = ("energy", "ishikawa")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshLaw:
    """Stiffness of one side of a pair: per branch along the tooth normal [N/m], and its relative series over sigma.

    narrow : the series of a slice without width, where the helix brings slices into mesh one after the other; None
        where all follow the whole.  table : force of loaded tooth contact, which then gives stiffness and variation.
    """

    stiffness: tuple[float, ...]
    variation: Series
    narrow: Series | None
    damping: float
    backlash: float
    table: ContactTable | None = None


def mesh_law(
    shape: StageShape,
    p: GearPair,
    side: str | None,
    model: ModelFile,
    torque: Mapping[str, float] | None,
    log: ResolutionLog,
    *,
    teeth: ToothPair | None,
    lean: int,
) -> MeshLaw:
    """Stiffness [N/m], its variation, damping [N s/m] and backlash [m] of one side of a pair.

    torque : of each pair [N m], as `Kinematics.mesh_torque`.  teeth : of the mesh.  lean : d h of its first gear.

    Raises
    ------
    ModelError : a stiffness that needs a face width without one, teeth that cannot touch.
    """
    plan, width = shape.plan, shape.meshes[p.name].width[side]
    statement = stated(p.levels(side), "stiffness")
    if statement is not None and isinstance(statement.value, MeshForceTable):
        return _given_law(shape, p, side, statement, torque, model, log)
    value = "iso6336" if statement is None else statement.value
    path = f"{p.path}.stiffness" if statement is None else statement.path
    count, computed = len(plan.angles), not isinstance(value, Quantity)
    form = _form(p, side, str(value) if computed else "")
    narrow_series, shaped, loaded = None, None, None
    if value == "contact":
        _needed_width(shape, p, side, path)
        if teeth is None:
            raise ModelError(
                "is missing: loaded contact needs the face of either gear",
                path=f"{shape.plan.path}.face_width",
                allowed=f"a face width of the stage, or of {p.a} and of {p.b}",
            )
        loaded = _contact_law(shape, p, teeth, lean, torque, log)
    for method in _BY_SHAPE:
        # where mean and variation are of two methods, the series is that of the variation
        if method in (value, form):
            _needed_width(shape, p, side, path)
            mean, series = tooth_law(shape, p, side, model, torque, log, method=method)
            shaped = mean if value == method else shaped
            narrow_series = series if form == method else narrow_series
    if isinstance(value, Quantity):
        stiffness = per_branch(_normal(shape, p, side, value, path), count, path)
    elif shaped is not None:
        stiffness = (shaped,) * count
    elif loaded is not None:
        stiffness = (loaded.stiffness,) * count
    else:
        stiffness = (_standard(shape, p, width, path, model, log),) * count
    note = stiffness[0] if len(set(stiffness)) == 1 else list(stiffness)
    by_side = len(set(shape.meshes[p.name].width.values())) > 1 or (statement is not None and statement.level == "side")
    where = f"{p.path}.{side}.stiffness" if side and by_side else f"{p.path}.stiffness"
    log.note(where, note, "N/m", f"{value or 'iso6336'}" if computed else "given")
    _check_range(shape, p, width, stiffness, model, log)
    loaded = loaded if form == "contact" else None
    if loaded is not None:
        log.note(f"{p.path}.variation", form, "", "default")
        variation, narrow = loaded.variation, None
    else:
        variation, narrow = _variation(shape, p, side, form, narrow_series, log)
    return MeshLaw(
        stiffness=stiffness,
        variation=variation,
        narrow=narrow,
        damping=stated_value(p.levels(side), "damping", 0.0),
        backlash=stated_value(p.levels(side), "backlash", math.inf),
        table=loaded,
    )


def _normal(shape: StageShape, p: GearPair, side: str | None, given: Quantity, path: str) -> float | tuple[float, ...]:
    """A given stiffness along the tooth normal of one helix [N/m]."""
    factor = 1.0
    if given.unit == "N/m^2":
        factor = _needed_width(shape, p, side, path)
    factor /= _transverse_cosine(shape, p, side) ** 2
    if isinstance(given.value, tuple):
        return tuple(value * factor for value in given.value)
    return given.value * factor


def _transverse_cosine(shape: StageShape, p: GearPair, side: str | None) -> float:
    """cos beta_b [1] where the stiffness is given along the transverse line of action, else 1."""
    transverse = stated_value(p.levels(side), "direction", "normal") == "transverse"
    return math.cos(shape.teeth[p.a].base_helix) if transverse else 1.0


def _needed_width(shape: StageShape, p: GearPair, side: str | None, path: str) -> float:
    """Common face width [m] of one side of a pair. Raises ModelError where it is not stated."""
    width = shape.meshes[p.name].width[side]
    if math.isnan(width):
        raise ModelError(
            "is missing: the mesh stiffness needs it",
            path=f"{shape.plan.path}.face_width",
            allowed=f"a face width of the stage or of {p.a} and {p.b}, or {path} in N/m",
        )
    return width


def _standard(shape: StageShape, p: GearPair, width: float, path: str, model: ModelFile, log: ResolutionLog) -> float:
    """Mean stiffness along the tooth normal of one helix by ISO 6336-1 [N/m]."""
    if math.isnan(width):
        _needed_width(shape, p, next(iter(shape.meshes[p.name].width)), path)
    a, b = shape.teeth[p.a], shape.teeth[p.b]
    first, second = next(iter(shape.gears[p.a].values())), next(iter(shape.gears[p.b].values()))
    single, limits = teeth_stiffness.iso6336_single_stiffness(
        a.teeth,
        b.teeth,
        a.pressure_angle,
        a.helix_angle,
        internal=p.internal,
        shift_a=first.profile_shift,
        shift_b=second.profile_shift,
        dedendum_a=first.dedendum,
        dedendum_b=second.dedendum,
        youngs_modulus_a=elastic_constants(member_material(shape.plan, p.a, model))[0],
        youngs_modulus_b=elastic_constants(member_material(shape.plan, p.b, model))[0],
    )
    mean, more = teeth_stiffness.iso6336_mesh_stiffness(single, shape.meshes[p.name].contact_ratio)
    for text in (*limits, *more):
        log.warn(placed(path, text))
    return teeth_stiffness.normal_from_transverse(mean * width, a.base_helix)


def _check_range(
    shape: StageShape, p: GearPair, width: float, stiffness: Sequence[float], model: ModelFile, log: ResolutionLog
) -> None:
    """Warn of a stiffness [N/m] per face width [m] outside the range of teeth of these materials.

    Two teeth in series of moduli E_a and E_b are softer than steel by 2 E_a E_b/(E_a + E_b)/E_steel [iso6336].
    """
    if math.isnan(width):
        return
    a, b = (elastic_constants(member_material(shape.plan, name, model))[0] for name in (p.a, p.b))
    softer = 2 * a * b / (a + b) / STEEL_MODULUS
    steel = abs(softer - 1) < STEEL_GRADES
    least, most = (edge * (1.0 if steel else softer) for edge in NORMAL_RANGE)
    for value in sorted(set(stiffness)):
        per_width = value * math.cos(shape.teeth[p.a].base_helix) ** 2 / width
        if not least <= per_width <= most:
            kind = "steel teeth" if steel else "teeth of these materials"
            log.warn(
                coded(
                    "stiffness-unusual",
                    f"{p.path}.stiffness: {per_width / 1e9:.3g} N/(mm um) of face width, {kind} have "
                    f"{least / 1e9:.3g} .. {most / 1e9:.3g}",
                )
            )


def _form(p: GearPair, side: str | None, method: str) -> str:
    """Form of the variation of the stiffness: stated, else that of its method."""
    variation: VariationTable | None = stated_value(p.levels(side), "variation", None)
    if variation is not None:
        return variation.form
    if method in ("contact", *_BY_SHAPE):
        return method
    return "contact-lines" if method else "none"


def _variation(
    shape: StageShape, p: GearPair, side: str | None, form: str, by_shape: Series | None, log: ResolutionLog
) -> tuple[Series, Series | None]:
    """Relative Fourier coefficients (L,) over sigma [1], and those of a narrow slice where the helix shifts slices.

    by_shape : series (L,) of a narrow slice by the shape of the teeth.
    """
    meshing = shape.meshes[p.name]
    series: VariationTable | None = stated_value(p.levels(side), "variation", None)
    if form in ("none", "contact-lines", *_BY_SHAPE):
        log.note(f"{p.path}.variation", form, "", "default" if series is None else "given")
    if form in ("contact-lines", *_BY_SHAPE):
        overlap = overlap_of(meshing, shape, p, meshing.width[side])
        if math.isnan(overlap):
            _needed_width(shape, p, side, f"{p.path}.stiffness")
        if meshing.contact_ratio <= 0:
            raise ModelError("the teeth do not touch: contact ratio below 0", path=p.path)
        lines = teeth_stiffness.contact_line_series(meshing.limits, 0.0)
        narrow = lines if by_shape is None or form == "contact-lines" else by_shape
        return teeth_stiffness.face_average(narrow, overlap), narrow
    if series is None or form == "none":
        return np.zeros(0, complex), None
    values = table_series(series.values)[1] if form == "values" else fourier_series(series.cosine, series.sine)
    statement = stated(p.levels(side), "variation")
    _check_positive(values, f"{p.path}.variation" if statement is None else statement.path)
    return values, None


def _check_positive(series: Series, path: str) -> None:
    """Raise ModelError where a stiffness that varies by a series (L,) is not above 0 over the whole mesh cycle."""
    if not series.size:
        return
    # 64 points a wave of the highest order: the least value between them is missed by a thousandth of its amplitude
    count = 64 * series.size
    spectrum = np.concatenate([[1.0], 0.5 * series, np.zeros(count // 2 - series.size, complex)])
    least = float(np.fft.irfft(spectrum * count, count).min())
    if not least > 0.0:
        raise ModelError(
            "the mesh stiffness does not stay above 0",
            path=path,
            given=f"{least:.3g} of its mean at the least",
            allowed="a variation above -1 of the mean over the whole mesh cycle",
        )


def overlap_of(meshing: MeshShape, shape: StageShape, p: GearPair, width: float) -> float:
    """Overlap ratio [1] of one helix of face width [m]."""
    first = next(iter(meshing.width.values()))
    if width == first or not shape.teeth[p.a].helix_angle:
        return meshing.overlap_ratio
    return meshing.overlap_ratio * width / first


# given tables ---------------------------------------------------------------------------------------------------------


def _given_law(
    shape: StageShape,
    p: GearPair,
    side: str | None,
    statement: Stated,
    torque: Mapping[str, float] | None,
    model: ModelFile,
    log: ResolutionLog,
) -> MeshLaw:
    """Law of one side of a pair by the table of force over deflection that the file states.

    Raises
    ------
    ModelError : a variation beside the table.
    """
    given: MeshForceTable = statement.value
    if (beside := stated(p.levels(side), "variation")) is not None:
        problem = f"stands beside a table of force in {statement.path}, which holds it"
        allowed = "forces of several phases of the mesh cycle, or no variation"
        raise ModelError(problem, path=beside.path, given=beside.value.form, allowed=allowed)
    cosine = _transverse_cosine(shape, p, side)
    # F_n = F_t / cos beta_b, d_n = d_t cos beta_b
    curves = tuple(force_curve(*curve).scaled(deflection=cosine, force=1 / cosine) for curve in given.curves)
    load, origin = _operating_load(shape, p, torque), "operation"
    middle = max(curve.force[-1] for curve in curves) / 2
    if given.load is not None:
        load, origin = given.load / cosine, "given"
    elif load is None:
        load, origin = middle, "half of the last force"
        log.warn(_assumed_load(p, load, "half of the last force of its table"))
    table = given_table(curves, load)
    transverse = cosine != 1.0
    log.note(f"{statement.path}.load", load * cosine, "N", f"{origin}, transverse" if transverse else origin)
    if transverse:
        log.note(f"{statement.path}.normal_load", load, "N", "along the tooth normal")
    tangent = "table, along the tooth normal" if transverse else "table"
    log.note(f"{statement.path}.tangent", table.stiffness, "N/m", tangent)
    if load > table.last:
        log.warn(
            coded(
                "table-exceeded",
                f"{statement.path}: the load {load:.4g} N lies behind the last force of the table, {table.last:.4g} N "
                "along the normal; there the law goes on along its last tangent",
            )
        )
    _check_range(shape, p, shape.meshes[p.name].width[side], (table.stiffness,), model, log)
    return MeshLaw(
        stiffness=(table.stiffness,) * len(shape.plan.angles),
        variation=table.variation,
        narrow=None,
        damping=stated_value(p.levels(side), "damping", 0.0),
        backlash=stated_value(p.levels(side), "backlash", math.inf),
        table=table,
    )


def _assumed_load(p: GearPair, force: float, why: str) -> CodedText:
    """Warning of a tangent at a normal force [N] that is not of the operation."""
    return coded(
        "tangent-load-assumed",
        f"{p.path}: no torque passes this mesh: verbs that take the tangent of its force take it at {force / 1e3:.4g} "
        f"kN, {why}",
    )


def _operating_load(shape: StageShape, p: GearPair, torque: Mapping[str, float] | None) -> float | None:
    """Mean force of the operation along the normal of one helix, evenly over branches and sides [N]; None without."""
    count = shape.plan.branches_of(p) * len(shape.meshes[p.name].width)
    passed = abs((torque or {}).get(p.path, 0.0)) / count
    load = passed / (shape.teeth[p.b].base_radius * math.cos(shape.teeth[p.a].base_helix))
    return load if load > 0 and math.isfinite(load) else None


# loaded tooth contact -------------------------------------------------------------------------------------------------


def _contact_law(
    shape: StageShape, p: GearPair, teeth: ToothPair, lean: int, torque: Mapping[str, float] | None, log: ResolutionLog
) -> ContactTable:
    """Table of one helix around the mean force of the operation.

    lean : d h of gear a.  torque : of each pair, as `Kinematics.mesh_torque`.

    Raises
    ------
    ModelError : what loaded contact refuses, see `gear_pair.check_pair`.
    """
    meshing = shape.meshes[p.name]
    width = min(teeth.face_a[1], teeth.face_b[1]) - max(teeth.face_a[0], teeth.face_b[0])
    load = nominal_load(shape, p, torque, width)
    passed = _operating_load(shape, p, torque) is not None
    log.note(f"{p.path}.load_per_length", load, "N/m", "operation" if passed else "default")
    helix = shape.teeth[p.a].base_helix
    force = load * meshing.contact_ratio * width / math.cos(helix)
    if not passed:
        log.warn(_assumed_load(p, force, f"{load / 1e3:.4g} N/mm"))
    table, messages = _table_of_pair(teeth, p.internal, helix, lean, force, p.path, (p.a, p.b))
    for text in messages:
        log.warn(placed(p.path, text))
    return table


@lru_cache(maxsize=64)
def _table_of_pair(
    teeth: ToothPair, internal: bool, base_helix: float, lean: int, force: float, path: str, names: tuple[str, str]
) -> tuple[ContactTable, tuple[CodedText, ...]]:
    """Table of one pair around a normal force [N], and its warnings; kept, because sides and branches share it."""
    from ..teeth.compliance import ToothCompliance
    from ..teeth.gear_pair import (  # heavy, and needed by loaded contact alone
        MeshedTeeth,
        check_pair,
        drawn_pair,
        interference_warnings,
    )
    from ..teeth.loaded_contact import contact_table

    pair = drawn_pair(teeth, internal=internal, base_helix=base_helix, lean=lean)
    check_pair(pair, path=path, paths=teeth.paths)
    table = contact_table(pair, force)
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    mesh = MeshedTeeth(a=a, b=b, working_angle=pair.plane.pressure_angle, limits=pair.plane.limits)
    return table, tuple(dict.fromkeys((*a.warnings, *b.warnings, *interference_warnings(mesh, path=path, names=names))))


def contact_errors(meshes: Sequence[Mesh], kinematics: Kinematics) -> list[MeshError]:
    """What the flanks of tabulated meshes add to the gap of a linear model: a mean, and orders of the mesh frequency.

    Without speeds the mean alone.
    """
    errors = []
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
        errors.append(error)
        if frequency:
            orders = enumerate(series.tolist(), start=1)
            errors += [replace(error, amplitude=value, frequency=order * frequency) for order, value in orders]
    return [error for error in errors if error.amplitude]
