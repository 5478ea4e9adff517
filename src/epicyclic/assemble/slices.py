"""The rows of the meshes: one of each, or one of each slice along its face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..train.connections import Mesh

__all__ = ["MeshRow", "mesh_rows"]


class MeshRow(NamedTuple):
    """One row.  whole : the mesh it belongs to; number : of the slice, 0 = the whole; mesh : what is in the row."""

    whole: str
    number: int
    mesh: Mesh


def mesh_rows(meshes: Sequence[Mesh]) -> tuple[MeshRow, ...]:
    """Every row of the meshes, in order; a slice has its part of stiffness and damping, and its own place and phase."""
    return tuple(row for mesh in meshes for row in _rows(mesh))


def _rows(mesh: Mesh) -> list[MeshRow]:
    if not mesh.slices:
        return [MeshRow(mesh.name, 0, mesh)]
    count = len(mesh.slices)
    return [
        MeshRow(
            mesh.name,
            number,
            replace(
                mesh,
                name=f"{mesh.name}/{number}",
                station=piece.station,
                along=piece.along,
                lead=piece.lead,
                variation=piece.variation,
                stiffness=mesh.stiffness / count,
                damping=mesh.damping / count,
            ),
        )
        for number, piece in enumerate(mesh.slices, start=1)
    ]
