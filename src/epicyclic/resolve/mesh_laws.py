"""Laws of meshes: mean stiffness and its variation over the place of the contact, damping, backlash."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears import stiffness as teeth_stiffness
from ..gears.force_table import ContactTable
from ..gears.series import fourier_series, table_series
from ..gears.tooth_pair import ToothPair
from ..model.schema import MeshSide, ModelFile, Variation
from ..model.units import Quantity
from .centres import MeshShape, StageShape
from .contact_law import contact_law
from .ledger import Ledger, per_branch
from .plan import Pair
from .tooth_forms import elastic, energy_law

__all__ = ["MeshLaw", "mesh_law", "overlap_of", "said_by"]

NORMAL_RANGE = (10e9, 30e9)  # stiffness per face width of steel teeth, transverse [N/m^2]
Series = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshLaw:
    """Stiffness of one side of a pair: per branch along the tooth normal [N/m], and its relative series over sigma.

    narrow : the series of a slice without width, where the helix brings slices into mesh one after the other; None
        where all follow the whole.  table : where loaded contact says stiffness and variation.
    """

    stiffness: tuple[float, ...]
    variation: Series
    narrow: Series | None
    damping: float
    backlash: float
    table: ContactTable | None = None


def said_by(p: Pair, side: str | None, key: str) -> MeshSide | None:
    """The table that says `key` of a side of a pair: the side's, else the mesh's, else None."""
    tables: Sequence[MeshSide | None] = (getattr(p.keys, side) if side else None, p.keys)
    return next((t for t in tables if t is not None and getattr(t, key) is not None), None)


def mesh_law(
    shape: StageShape,
    p: Pair,
    side: str | None,
    model: ModelFile,
    torque: Mapping[str, float] | None,
    ledger: Ledger,
    *,
    teeth: ToothPair | None,
    lean: int,
) -> MeshLaw:
    """Law of one side of a pair.

    torque : of each pair, as `Kinematics.mesh_torque`.  teeth : of the mesh.  lean : d h of its first gear.
    """
    plan, width = shape.plan, shape.meshes[p.name].width[side]
    table = said_by(p, side, "stiffness")
    value = "iso6336" if table is None else table.stiffness
    path = f"{p.path}.{side}.stiffness" if table is not None and table is not p.keys else f"{p.path}.stiffness"
    count, computed = len(plan.angles), not isinstance(value, Quantity)
    form = _form(p, side, str(value) if computed else "")
    own, loaded = None, None
    if value == "contact":
        _needed_width(shape, p, side, path)
        assert teeth is not None  # both faces have a width
        loaded = contact_law(shape, p, teeth, lean, torque, ledger)
    if "energy" in (value, form):
        _needed_width(shape, p, side, path)
        own = energy_law(shape, p, side, model, torque, ledger)
    if isinstance(value, Quantity):
        stiffness = per_branch(_normal(shape, p, side, value, path), count, path)
    elif value == "energy" and own is not None:
        stiffness = (own[0],) * count
    elif loaded is not None:
        stiffness = (loaded.stiffness,) * count
    else:
        stiffness = (_standard(shape, p, width, path, model, ledger),) * count
    note = stiffness[0] if len(set(stiffness)) == 1 else list(stiffness)
    by_side = len(set(shape.meshes[p.name].width.values())) > 1 or table not in (None, p.keys)
    where = f"{p.path}.{side}.stiffness" if side and by_side else f"{p.path}.stiffness"
    ledger.note(where, note, "N/m", f"{value or 'iso6336'}" if computed else "given")
    _check_range(shape, p, width, stiffness, ledger)
    damping, backlash = said_by(p, side, "damping"), said_by(p, side, "backlash")
    loaded = loaded if form == "contact" else None
    if loaded is not None:
        ledger.note(f"{p.path}.variation", form, "", "default")
        variation, narrow = loaded.variation, None
    else:
        variation, narrow = _variation(shape, p, side, form, None if own is None else own[1], ledger)
    return MeshLaw(
        stiffness=stiffness,
        variation=variation,
        narrow=narrow,
        damping=damping.damping or 0.0 if damping is not None else 0.0,
        backlash=math.inf if backlash is None or backlash.backlash is None else backlash.backlash,
        table=loaded,
    )


def _normal(shape: StageShape, p: Pair, side: str | None, given: Quantity, path: str) -> float | tuple[float, ...]:
    """A given stiffness along the tooth normal of one helix [N/m]."""
    factor = 1.0
    if given.unit == "N/m^2":
        factor = _needed_width(shape, p, side, path)
    direction = said_by(p, side, "direction")
    if direction is not None and direction.direction == "transverse":
        factor /= math.cos(shape.teeth[p.a].base_helix) ** 2
    if isinstance(given.value, tuple):
        return tuple(value * factor for value in given.value)
    return given.value * factor


def _needed_width(shape: StageShape, p: Pair, side: str | None, path: str) -> float:
    width = shape.meshes[p.name].width[side]
    if math.isnan(width):
        raise ModelError(
            "is missing: the mesh stiffness needs it",
            path=f"{shape.plan.path}.face_width",
            allowed=f"a face width of the stage or of {p.a} and {p.b}, or {path} in N/m",
        )
    return width


def _standard(shape: StageShape, p: Pair, width: float, path: str, model: ModelFile, ledger: Ledger) -> float:
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
        youngs_modulus_a=elastic(shape.plan, p.a, model)[0],
        youngs_modulus_b=elastic(shape.plan, p.b, model)[0],
    )
    mean, more = teeth_stiffness.iso6336_mesh_stiffness(single, shape.meshes[p.name].contact_ratio)
    for text in (*limits, *more):
        ledger.warn(f"{path}: {text}")
    return teeth_stiffness.normal_from_transverse(mean * width, a.base_helix)


def _check_range(shape: StageShape, p: Pair, width: float, stiffness: Sequence[float], ledger: Ledger) -> None:
    if math.isnan(width):
        return
    for value in sorted(set(stiffness)):
        per_width = value * math.cos(shape.teeth[p.a].base_helix) ** 2 / width
        if not NORMAL_RANGE[0] <= per_width <= NORMAL_RANGE[1]:
            ledger.warn(f"{p.path}.stiffness: {per_width / 1e9:.3g} N/(mm um) of face width, steel teeth have 10 .. 30")


def _form(p: Pair, side: str | None, method: str) -> str:
    """How the stiffness varies: as said, else as its method has it."""
    table = said_by(p, side, "variation")
    if table is not None and table.variation is not None:
        return table.variation.form
    return {"": "none", "energy": "energy", "contact": "contact"}.get(method, "contact-lines")


def _variation(
    shape: StageShape, p: Pair, side: str | None, form: str, own: Series | None, ledger: Ledger
) -> tuple[Series, Series | None]:
    """Relative Fourier coefficients over sigma, (L,), and those of a narrow slice where the helix shifts slices.

    own : series of a narrow slice by energy.
    """
    table, meshing = said_by(p, side, "variation"), shape.meshes[p.name]
    said: Variation | None = None if table is None else table.variation
    if form in ("none", "contact-lines", "energy"):
        ledger.note(f"{p.path}.variation", form, "", "default" if said is None else "given")
    if form in ("contact-lines", "energy"):
        overlap = overlap_of(meshing, shape, p, meshing.width[side])
        if math.isnan(overlap):
            _needed_width(shape, p, side, f"{p.path}.stiffness")
        if meshing.contact_ratio <= 0:
            raise ModelError("the teeth do not touch: contact ratio below 0", path=p.path)
        lines = teeth_stiffness.contact_line_series(meshing.limits, 0.0)
        narrow = lines if own is None or form == "contact-lines" else own
        return teeth_stiffness.over_face(narrow, overlap), narrow
    if said is None or form == "none":
        return np.zeros(0, complex), None
    if form == "values":
        return table_series(said.values)[1], None
    return fourier_series(said.cosine, said.sine), None


def overlap_of(meshing: MeshShape, shape: StageShape, p: Pair, width: float) -> float:
    first = next(iter(meshing.width.values()))
    return (
        meshing.overlap_ratio
        if width == first or not shape.teeth[p.a].helix_angle
        else (meshing.overlap_ratio * width / first)
    )
