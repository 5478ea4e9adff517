"""Mesh stiffness by loaded contact: the table of a mesh, and the errors its flanks leave to a linear model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

from ..gears.force_table import ContactTable
from ..gears.series import series_in_time
from ..gears.tooth_pair import ToothPair
from ..tooth_contact.drawn import pair_of_teeth
from ..tooth_contact.energy import Meshing, interference
from ..tooth_contact.pieces import check_pair
from ..tooth_contact.table import contact_table
from ..tooth_contact.tooth import ToothCompliance
from ..train.connections import Mesh
from ..train.kinematics import Kinematics
from ..train.train import MeshError
from .centres import StageShape
from .ledger import Ledger
from .plan import Pair
from .tooth_forms import nominal_load

__all__ = ["contact_errors", "contact_law"]


def contact_law(
    shape: StageShape, p: Pair, teeth: ToothPair, lean: int, torque: Mapping[str, float] | None, ledger: Ledger
) -> ContactTable:
    """Table of one helix around the mean force of the operation.

    lean : d h of gear a.  torque : of each pair, as `Kinematics.mesh_torque`.

    Raises
    ------
    ModelError : what loaded contact refuses, see `pieces.check_pair`.
    """
    meshing = shape.meshes[p.name]
    width = min(teeth.face_a[1], teeth.face_b[1]) - max(teeth.face_a[0], teeth.face_b[0])
    load = nominal_load(shape, p, torque, width)
    ledger.note(f"{p.path}.load_per_length", load, "N/m", "operation" if torque else "default")
    helix = shape.teeth[p.a].base_helix
    force = load * meshing.contact_ratio * width / math.cos(helix)
    table, messages = _table(teeth, p.internal, helix, lean, force, p.path)
    for text in messages:
        ledger.warn(f"{p.path}: {text}")
    return table


@lru_cache(maxsize=64)
def _table(
    teeth: ToothPair, internal: bool, base_helix: float, lean: int, force: float, path: str
) -> tuple[ContactTable, tuple[str, ...]]:
    pair = pair_of_teeth(teeth, internal=internal, base_helix=base_helix, lean=lean)
    check_pair(pair, path=path, paths=teeth.paths)
    table = contact_table(pair, force)
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    mesh = Meshing(a=a, b=b, working_angle=pair.plane.pressure_angle, limits=pair.plane.limits)
    return table, tuple(dict.fromkeys((*a.warnings, *b.warnings, *interference(mesh, path=path))))


def contact_errors(meshes: Sequence[Mesh], kinematics: Kinematics) -> list[MeshError]:
    """What the flanks of tabulated meshes add to the gap of a linear model: a mean, and orders of the mesh frequency.

    Without speeds the mean alone.
    """
    found = []
    for mesh in meshes:
        if mesh.table is None:
            continue
        series = series_in_time(mesh.table.missing[1:], lead=mesh.lead, sense=mesh.sense)
        frequency = (kinematics.mesh_frequency or {}).get(mesh.stage)
        error = MeshError(
            path=f"{mesh.pair}.stiffness",
            cause="contact",
            mesh=mesh.name,
            amplitude=complex(mesh.table.missing[0].real),
            frequency=Fraction(0),
        )
        found.append(error)
        if frequency:
            orders = enumerate(series.tolist(), start=1)
            found += [replace(error, amplitude=value, frequency=order * frequency) for order, value in orders]
    return found
