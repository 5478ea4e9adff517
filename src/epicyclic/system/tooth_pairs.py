"""Tooth contact of the meshes of a train: the pair of teeth of a mesh, linear rows about its loaded contact; and all
meshes in contact along the face, a train with three rows a mesh, and their laws.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.form import GearForm
from ..teeth.gear_pair import ContactPair, Torsion, check_pair, drawn_pair, interference_warnings, meshed_teeth
from ..teeth.geometry import mesh_phasor
from ..teeth.loaded_contact import harmonics
from ..teeth.mesh_stiffness import series_in_time, table_series
from ..teeth.path_of_contact import averaging_length, line_windows
from ..teeth.segments import ContactSegments, RowStations, contact_segments, row_response, row_weights
from ..train.train import Mesh, MeshSlice, Train
from ..warning_codes import CodedText, placed
from .flank_laws import ROWS, FaceForce
from .system import Array, ComplexArray, Index, Line, System

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
    slides = axial_offsets(train, mesh)
    plain = drawn_pair(teeth, base_helix=mesh.base_helix, lean=mesh.flank * mesh.hand, slides=slides)
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
    interference_warnings(meshed_teeth(pair), path=mesh.pair, names=_gears(mesh))
    return pair


def _torsion(form: GearForm, end: End | None) -> Torsion | None:
    """Torsional rigidity of the body of a gear, G pi/2 |r_f^4 - r_i^4| [N m^2]."""
    if end is None:
        return None
    modulus = form.youngs_modulus / (2 * (1 + form.poisson))
    return Torsion(rigidity=modulus * math.pi / 2 * abs(form.root**4 - form.bore**4), end=end)


def axial_offsets(train: Train, mesh: Mesh) -> tuple[float, float]:
    """Axial offsets of both gears of a mesh from the drawing, by deviations at rest [m]."""
    still = [one for one in train.displacements if one.cause == "position" and one.frequency == 0]
    a, b = (math.fsum(one.vector[2].real for one in still if one.body == body) for body in (mesh.a, mesh.b))
    return a, b


def tooth_warnings(pair: ContactPair, mesh: Mesh) -> tuple[CodedText, ...]:
    """Warnings of a pair of `pair_of`: tips that interfere.

    mesh : that the pair is of; its table in the model file stands before each warning.
    """
    texts = interference_warnings(meshed_teeth(pair), names=_gears(mesh))
    return tuple(placed(mesh.pair, text) for text in texts)


def _gears(mesh: Mesh) -> tuple[str, str]:
    """Names of the gears of a mesh within their stage."""
    return mesh.a.split("/")[1], mesh.b.split("/")[1]


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


def first_mesh(train: Train) -> str:
    """Name of the first mesh that torque passes, of both helices: without the side."""
    mesh = loaded_mesh(train)
    return mesh.name if mesh.side is None else mesh.name.rsplit("/", 1)[0]


# linear rows ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactHistory:
    """Loaded contact of one mesh at times 0, 1/T, ... of its own mesh cycle.

    force : along the normal [N].  approach : (T,) of the teeth along the normal under that force [m].
    tangent : (T,) dF/dd there [N/m].
    """

    force: float
    approach: Array
    tangent: Array


def with_contact_tangent(train: Train, system: System, histories: Mapping[str, ContactHistory]) -> System:
    """System whose meshes have the tangent stiffness of loaded contact and the error that belongs to its load.

    The slices of a mesh share its tangent equally and have its error, in step: the history is that of the whole mesh.

        f = F + k(t) (delta - d_F(t)) = k(t) (delta - e(t)),    e(t) = d_F(t) - F/k(t)

    At vanishing speed the train has the displacement d_F, the loaded transmission error, and no dynamic force.
    Derived here.  Laws of meshes are left out: their tables are of other flanks.

    Parameters
    ----------
    histories : name of a mesh -> its contact, used for the same pair and side in all branches, each at its own phase.

    Raises
    ------
    ModelError : no mesh frequency, a tangent that is not above zero.
    """
    if not system.tones:
        raise ModelError("the dynamic force needs a speed", path="operation.speed", allowed="the speed of one member")
    contacts = {(mesh.pair, mesh.side): (mesh, histories[mesh.name]) for mesh in train.meshes if mesh.name in histories}
    stiffness, variation = system.meshes.stiffness.copy(), [*system.meshes.variation]
    gaps: dict[Fraction, ComplexArray] = {}
    row = 0
    for mesh in train.meshes:
        count = max(len(mesh.slices), 1)
        rows = slice(row, row + count)
        row += count
        if (mesh.pair, mesh.side) not in contacts:
            continue
        first, history = contacts[mesh.pair, mesh.side]
        mean, series, errors = _series(history)
        stiffness[rows] = mean / count
        variation[rows] = [_moved(series, first, mesh)] * count
        tone = system.tones[int(system.meshes.tone[rows.start])]
        for order, error in enumerate([errors[0], *_moved(errors[1:], first, mesh)]):
            gaps.setdefault(tone * order, np.zeros(len(variation), complex))[rows] += error
    L = max(len(series) for series in variation)
    padded = np.array([np.pad(series, (0, L - len(series))) for series in variation])
    meshes = replace(system.meshes, stiffness=stiffness, variation=padded, laws=())
    lines = tuple(_with_gap(line, gaps.get(line.frequency)) for line in system.with_lines(gaps).lines)
    return replace(system, meshes=meshes, lines=lines)


def _series(history: ContactHistory) -> tuple[float, ComplexArray, ComplexArray]:
    """Mean stiffness [N/m], relative series (L,) and error of orders 0 .. L [m], over mesh time."""
    if not (np.isfinite(history.tangent).all() and (history.tangent > 0).all()):
        raise ModelError("the teeth do not keep contact over the mesh cycle", given=float(np.min(history.tangent)))
    count = (len(history.tangent) - 1) // 2
    mean, series = table_series(history.tangent)
    return mean, series[:count], harmonics(history.approach - history.force / history.tangent, count)


def _moved(series: ComplexArray, first: Mesh, mesh: Mesh) -> ComplexArray:
    """Series (L,) over the time of the mesh `first`, moved to the time of `mesh` through sigma, in the same unit."""
    back = np.array([mesh_phasor(order, -first.lead) for order in range(1, len(series) + 1)], dtype=np.complex128)
    over_sigma = series * back
    return series_in_time(over_sigma if first.sense > 0 else over_sigma.conj(), lead=mesh.lead, sense=mesh.sense)


def _with_gap(line: Line, gap: ComplexArray | None) -> Line:
    """A line with the errors `gap` (m,) [m] of contact added."""
    return line if gap is None else replace(line, gap=line.gap + gap, causes=tuple(sorted({*line.causes, "contact"})))


def with_three_rows(train: Train) -> Train:
    """The train with three rows a mesh as of `system.flank_laws`: both ends of the face, and one along the path.

    Raises
    ------
    ModelError : no face width.
    """
    none = np.zeros(0, complex)
    meshes = []
    for mesh in train.meshes:
        at = _stations(pair_of(train, mesh))
        rows = tuple(
            MeshSlice(station=mesh.station + zeta, lead=mesh.lead, variation=none, along=along)
            for zeta, along in ((at.left, 0.0), (at.right, 0.0), (0.0, at.along))
        )
        meshes.append(replace(mesh, slices=rows, variation=none, table=None))
    # the error of a linearised loaded contact is contained in the contact of the flanks
    errors = tuple(error for error in train.mesh_errors if error.cause != "contact")
    return replace(train, meshes=tuple(meshes), mesh_errors=errors)


def _stations(pair: ContactPair) -> RowStations:
    left, right = pair.plane.face
    return RowStations(left=left, right=right, along=pair.plane.base_pitch)


class FaceLoad(NamedTuple):
    """Load on a mesh at T instants, K slices of the face, J lines.

    force : (T, J, K) along the normal [N].  per_length : (T, J, K) of contact line [N/m], means over a length about
    each slice as of `LineWindows`, nan out of contact.  whole : (T, J, K) where that length is on the contact line.
    sigma : (T, J, K) places on the path of contact [base pitches].
    """

    force: Array
    per_length: Array
    whole: NDArray[np.bool_]
    sigma: Array


def face_loads(segments: ContactSegments, force: Array, count: int = 1) -> list[FaceLoad]:
    """Loads on equal meshes from forces (T g, J, K) on their segments [N], instant by instant; count : g of them."""
    lines, plane = segments.lines, segments.pair.plane
    touched = lines.length > 0
    mean = np.where(touched, line_windows(plane, lines).mean(force), np.nan)
    long = lines.length.sum(axis=2, keepdims=True) >= averaging_length(plane) * (1 - 1e-9)
    each = [slice(mesh, None, count) for mesh in range(count)]
    return [FaceLoad(force[own], mean[own], (touched & long)[own], lines.sigma[own]) for own in each]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _At:
    """Equal meshes at T instants: segments of all T g of them, instant by instant."""

    segments: ContactSegments
    weight: Array

    def press(self, rows: Array, instants: Index, start: Array | None) -> FaceForce:
        """Forces of rows (t, g, 3) [m] at instants (t,), as of `system.flank_laws.FaceContact`."""
        t, g = rows.shape[:2]
        phases = (instants[:, None] * g + np.arange(g)).ravel()
        begin = None if start is None else start.reshape(t * g, -1)
        response = row_response(self.segments, self.weight, rows.reshape(t * g, ROWS), phases, start=begin)
        return FaceForce(
            force=response.force.reshape(t, g, ROWS),
            tangent=response.tangent.reshape(t, g, ROWS, ROWS),
            energy=response.energy.reshape(t, g),
            residual=response.residual.reshape(t, g),
            state=response.own.reshape(t, g, -1),
        )

    def faces(self, rows: Array, start: Array) -> list[FaceLoad]:
        """Loads along the faces at approaches (T, g, 3) [m] of a solved state `start` (T, g, n) [m]."""
        T, g = rows.shape[:2]
        flat, begin = rows.reshape(T * g, ROWS), start.reshape(T * g, -1)
        response = row_response(self.segments, self.weight, flat, np.arange(T * g), start=begin)
        return face_loads(self.segments, self.segments.spread(response.segment), g)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshFaceLaw:
    """Face law of equal meshes: one pair of gears, side and place of the faces, different phases.

    meshes : their numbers (g,) among the whole meshes of the System, which have three rows each.  pair : contact pair.
    lead [mesh cycles], sense : (g,) of each.
    """

    meshes: tuple[int, ...]
    pair: ContactPair
    lead: Array
    sense: Array

    def at(self, cycles: Array) -> _At:
        """Contact at times (T, g) counted in cycles of each mesh [mesh cycles]."""
        segments = contact_segments(self.pair, (self.sense * (cycles + self.lead)).ravel())
        return _At(segments=segments, weight=row_weights(segments, _stations(self.pair)))


def face_laws(
    train: Train, *, slices: int = 20, linear_at: float | None = None, corner: bool = False
) -> tuple[MeshFaceLaw, ...]:
    """Face laws of all meshes of a train, equal meshes together.

    slices, linear_at, corner : as of `ContactPair`.

    Raises
    ------
    ModelError : as of `pair_of`.
    """
    alike: dict[object, list[int]] = {}
    for number, mesh in enumerate(train.meshes):
        alike.setdefault((mesh.pair, mesh.side, axial_offsets(train, mesh)), []).append(number)
    return tuple(
        MeshFaceLaw(
            meshes=tuple(numbers),
            pair=pair_of(train, train.meshes[numbers[0]], slices=slices, linear_at=linear_at, corner=corner),
            lead=np.array([float(train.meshes[i].lead) for i in numbers]),
            sense=np.array([float(train.meshes[i].sense) for i in numbers]),
        )
        for numbers in alike.values()
    )
