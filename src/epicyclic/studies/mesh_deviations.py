"""Errors that the deviations of a train show in its meshes, one by one, as the verb `check` lists them."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..train.bodies import Body
from ..train.connections import Mesh
from ..train.train import Train

__all__ = ["MeshDeviation", "mesh_deviations"]

# Pitch deviations have a line for every order of their gear, and loaded contact is no deviation.
_UNLISTED = ("pitch", "contact")
_ROUNDING = 1e-12  # of the displacement: the component of a vector across the normal


class MeshDeviation(NamedTuple):
    """One deviation in one mesh: e(t) = amplitude cos(2 pi frequency t + phase), positive opens the gap.

    path : of the deviation in the model file.  mesh : name.  amplitude [m].  phase [rad], in (-pi, pi].
    frequency : exact, in the frame of the stage [Hz], 0 where it stands still.
    """

    path: str
    mesh: str
    amplitude: float
    phase: float
    frequency: Fraction


def mesh_deviations(train: Train) -> list[MeshDeviation]:
    """Run-outs projected on the loaded flanks, then errors stated of the meshes; pitch deviations are left out.

    A displaced seat is not listed: it shows in the meshes by the motion of the bodies.
    """
    found: list[MeshDeviation] = []
    for item in train.displacements:
        body = next(b for b in train.bodies if b.name == item.body)
        for mesh in train.meshes if item.rows == "mesh" else ():
            if body.name in (mesh.a, mesh.b):
                error = -complex(_normal(mesh, body) @ item.vector[:3])
                if abs(error) > _ROUNDING * np.abs(item.vector).max():
                    found.append(_listed(item.path, mesh.name, error, item.frequency))
    listed = (error for error in train.mesh_errors if error.cause not in _UNLISTED and not error.far)
    stated = sorted(listed, key=lambda error: error.path)
    return found + [_listed(error.path, error.mesh, error.amplitude, error.frequency) for error in stated]


def _listed(path: str, mesh: str, amplitude: complex, frequency: Fraction) -> MeshDeviation:
    """The entry of Re(amplitude exp(2 pi i frequency t)), with a frequency that is not negative."""
    value = amplitude.conjugate() if frequency < 0 else amplitude
    if frequency == 0:
        value = complex(value.real)
    return MeshDeviation(path, mesh, abs(value), cmath.phase(value), abs(frequency))


def _normal(mesh: Mesh, body: Body) -> NDArray[np.float64]:
    """First three coefficients (3,) of the row of a mesh in the axes of a body (docs/conventions.md, The mesh row)."""
    turn = mesh.direction - body.angle
    across = math.sin(mesh.pressure_angle), mesh.flank * math.cos(mesh.pressure_angle)
    x = across[0] * math.cos(turn) - across[1] * math.sin(turn)
    y = across[0] * math.sin(turn) + across[1] * math.cos(turn)
    helix = mesh.base_helix
    normal = np.array([math.cos(helix) * x, math.cos(helix) * y, -mesh.hand * mesh.flank * math.sin(helix)])
    return normal if body.name == mesh.a else -normal
