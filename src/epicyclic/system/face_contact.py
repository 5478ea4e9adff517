"""All meshes of a train in tooth contact along the face: the train with three rows a mesh, and their laws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..teeth.gear_pair import ContactPair
from ..teeth.path_of_contact import averaging_length, line_windows
from ..teeth.segments import ContactSegments, RowStations, contact_segments, row_response, row_weights
from ..train.train import MeshSlice, Train
from .flank_laws import ROWS, FaceForce, Index
from .system import Array
from .tooth_pairs import axial_offsets, pair_of


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceLoad:
    """Load on g meshes at T instants, K slices of the face, J lines.

    force : (T, g, J, K) along the normal [N].  per_length : (T, g, J, K) of contact line [N/m], means over a length
    about each slice as of `LineWindows`, nan out of contact.  whole : (T, g, J, K) where that length is on the contact
    line.  sigma : (T, g, J, K) places on the path of contact [base pitches].
    """

    force: Array
    per_length: Array
    whole: NDArray[np.bool_]
    sigma: Array


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

    def face(self, rows: Array, start: Array) -> FaceLoad:
        """Load along the face at approaches (T, g, 3) [m] of a solved state `start` (T, g, n) [m]."""
        T, g = rows.shape[:2]
        flat, begin = rows.reshape(T * g, ROWS), start.reshape(T * g, -1)
        response = row_response(self.segments, self.weight, flat, np.arange(T * g), start=begin)
        force = self.segments.spread(response.segment)
        lines, plane = self.segments.lines, self.segments.pair.plane
        touched = lines.length > 0
        mean = np.where(touched, line_windows(plane, lines).mean(force), np.nan)
        long = lines.length.sum(axis=2, keepdims=True) >= averaging_length(plane) * (1 - 1e-9)
        shape = (T, g, *force.shape[1:])
        return FaceLoad(
            force=force.reshape(shape),
            per_length=mean.reshape(shape),
            whole=(touched & long).reshape(shape),
            sigma=lines.sigma.reshape(shape),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshFaceLaw:
    """Face law of equal meshes: one pair of gears, side and place of the faces, different phases.

    meshes : their numbers.  pair : contact pair.  lead [mesh cycles], sense : (g,) of each.
    """

    meshes: tuple[int, ...]
    pair: ContactPair
    lead: Array
    sense: Array

    def at(self, cycles: Array) -> _At:
        """Contact at times (T, g) [mesh cycles], as of `system.flank_laws.FaceLaw`."""
        sigma = self.sense * (cycles + self.lead)
        segments = contact_segments(self.pair, sigma.ravel())
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
    laws = []
    for numbers in alike.values():
        meshes = [train.meshes[i] for i in numbers]
        law = MeshFaceLaw(
            meshes=tuple(numbers),
            pair=pair_of(train, meshes[0], slices=slices, linear_at=linear_at, corner=corner),
            lead=np.array([float(mesh.lead) for mesh in meshes]),
            sense=np.array([float(mesh.sense) for mesh in meshes]),
        )
        laws.append(law)
    return tuple(laws)
