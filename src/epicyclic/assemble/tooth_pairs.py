"""Contact pair of one mesh of a train, and the mean force of the mesh."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from ..errors import ModelError
from ..teeth.compliance import ToothCompliance
from ..teeth.energy_stiffness import MeshedTeeth, interference_warnings
from ..teeth.gear_pair import ContactPair, Torsion, check_pair, drawn_pair
from ..teeth.outline import GearForm
from ..train.connections import Mesh
from ..train.train import Train
from ..warning_codes import CodedText, placed

__all__ = [
    "End",
    "axial_offsets",
    "loaded_mesh",
    "mean_force",
    "pair_of",
    "tooth_warnings",
]


End = Literal["left", "right"]


def pair_of(
    train: Train,
    mesh: Mesh,
    *,
    slices: int = 20,
    linear_at: float | None = None,
    corner: bool = False,
    misalignment: float = 0.0,
    torque_ends: tuple[End | None, End | None] = (None, None),
) -> ContactPair:
    """Contact pair of one mesh as drawn, on its loaded flank; deviations `position.z` offset the faces.

    Parameters
    ----------
    slices, linear_at, corner, misalignment : as of `ContactPair`.
    torque_ends : end of the face at which the torque leaves gear a, and b: their bodies, solid from the held radius to
        the root circle, twist along the face.  None: rigid.

    Raises
    ------
    ModelError : no face width; a pair that does not mesh or interferes, pointed or undercut teeth, no body under them.
    """
    teeth = mesh.teeth
    if teeth is None:
        raise ModelError(
            "is missing: tooth contact needs it", path=f"stages.{mesh.stage}.face_width", allowed="of both gears [m]"
        )
    plain = drawn_pair(
        teeth,
        internal=mesh.internal,
        base_helix=mesh.base_helix,
        lean=mesh.flank * mesh.hand,
        slides=axial_offsets(train, mesh),
    )
    pair = replace(
        plain,
        misalignment=misalignment,
        torsion_a=_torsion(teeth.form_a, torque_ends[0]),
        torsion_b=_torsion(teeth.form_b, torque_ends[1]),
        slices=slices,
        linear_at=linear_at,
        corner=corner,
    )
    check_pair(pair, path=mesh.pair, paths=teeth.paths)
    interference_warnings(_meshing(pair), path=mesh.pair, names=_gears(mesh))
    return pair


def _meshing(pair: ContactPair) -> MeshedTeeth:
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    return MeshedTeeth(a=a, b=b, working_angle=pair.plane.pressure_angle, limits=pair.plane.limits)


def axial_offsets(train: Train, mesh: Mesh) -> tuple[float, float]:
    """Axial offsets of both gears of a mesh from the drawing, by deviations at rest [m]."""
    return _slide(train, mesh.a), _slide(train, mesh.b)


def _torsion(form: GearForm, end: End | None) -> Torsion | None:
    """Torsional rigidity of the body of a gear, G pi/2 |r_f^4 - r_i^4| [N m^2]."""
    if end is None:
        return None
    modulus = form.youngs_modulus / (2 * (1 + form.poisson))
    return Torsion(rigidity=modulus * math.pi / 2 * abs(form.root**4 - form.bore**4), end=end)


def _slide(train: Train, body: str) -> float:
    """Axial offset of a body from the drawing, by deviations at rest [m]."""
    still = (d for d in train.displacements if d.body == body and d.cause == "position" and d.frequency == 0)
    return math.fsum(float(d.vector[2].real) for d in still)


def mean_force(train: Train, mesh: Mesh) -> float:
    """Mean force of one mesh along the tooth normal under equal load sharing [N]; nan without torques."""
    torques = train.kinematics.mesh_torque
    if torques is None or mesh.pair not in torques:
        return math.nan
    alike = sum(other.pair == mesh.pair for other in train.meshes)
    lever = mesh.radius_b * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix)
    return abs(torques[mesh.pair]) / (alike * lever)


def loaded_mesh(train: Train) -> Mesh:
    """The first mesh that torque passes, the first of all where none does."""
    return next((mesh for mesh in train.meshes if mean_force(train, mesh) > 0), train.meshes[0])


def tooth_warnings(pair: ContactPair, mesh: Mesh) -> tuple[CodedText, ...]:
    """Warnings of a pair of `pair_of`: formulas of the teeth outside their limits, and tips that interfere.

    mesh : that the pair is of; its table in the model file stands before each warning.
    """
    meshing = _meshing(pair)
    said = (*meshing.a.warnings, *meshing.b.warnings, *interference_warnings(meshing, names=_gears(mesh)))
    return tuple(dict.fromkeys(placed(mesh.pair, text) for text in said))


def _gears(mesh: Mesh) -> tuple[str, str]:
    """Names of the gears of a mesh within their stage."""
    return mesh.a.split("/")[1], mesh.b.split("/")[1]
