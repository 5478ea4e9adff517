"""Errors that the deviations of a train show in its meshes, one by one, as the verb `check` lists them."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..train.bodies import Body, Mesh
from ..train.train import Displacement, Train

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
    """Displaced features projected on the loaded flanks, then errors stated of the meshes.

    A displaced seat (position, bearing run-out, run-out of a carrier's pins) shows as it would if its bodies followed
    it: the meshes open by as much where the bodies do not move.  Pitch deviations and tilt are left out.
    """
    found = [one for item in train.displacements for one in _displaced(train, item)]
    listed = (error for error in train.mesh_errors if error.cause not in _UNLISTED and not error.far)
    stated = sorted(listed, key=lambda error: error.path)
    found += [_listed(error.path, error.mesh, error.amplitude, error.frequency) for error in stated]
    largest: dict[str, float] = {}
    for one in found:
        largest[one.path] = max(largest.get(one.path, 0.0), one.amplitude)
    # a deviation that is 0 everywhere is listed: the file states it
    return [one for one in found if one.amplitude >= _ROUNDING * largest[one.path]]


def _displaced(train: Train, item: Displacement) -> list[MeshDeviation]:
    """What a displaced feature opens the meshes by: of a gear its own, of a carrier those of the bodies it carries."""
    body = next(b for b in train.bodies if b.name == item.body)
    if item.rows != "mesh" and not item.links:
        return []
    moved = [body] if body.gear is not None else [b for b in train.bodies if b.carried_by == body.name]
    # a bearing off its body by E holds the body off its place by -E
    sense = -1.0 if item.cause == "bearing_run_out" else 1.0
    found = []
    for one in moved:
        for mesh in train.meshes:
            if one.name in (mesh.a, mesh.b):
                error = -sense * complex(_normal(mesh, one, body.angle) @ item.vector[:3])
                if abs(error) > _ROUNDING * np.abs(item.vector).max():
                    found.append(_listed(item.path, mesh.name, error, item.frequency))
    return found


def _listed(path: str, mesh: str, amplitude: complex, frequency: Fraction) -> MeshDeviation:
    """The entry of Re(amplitude exp(2 pi i frequency t)), with a frequency that is not negative."""
    value = amplitude.conjugate() if frequency < 0 else amplitude
    if frequency == 0:
        value = complex(value.real if abs(value.real) > _ROUNDING * abs(value) else 0.0)
    return MeshDeviation(path, mesh, abs(value), cmath.phase(value), abs(frequency))


def _normal(mesh: Mesh, body: Body, angle: float) -> NDArray[np.float64]:
    """First three coefficients (3,) of the row of a mesh for a body, in axes at an angle [rad] (docs/conventions.md,
    The mesh row).
    """
    turn = mesh.direction - angle
    across = math.sin(mesh.pressure_angle), mesh.flank * math.cos(mesh.pressure_angle)
    x = across[0] * math.cos(turn) - across[1] * math.sin(turn)
    y = across[0] * math.sin(turn) + across[1] * math.cos(turn)
    helix = mesh.base_helix
    normal = np.array([math.cos(helix) * x, math.cos(helix) * y, -mesh.hand * mesh.flank * math.sin(helix)])
    return normal if body.name == mesh.a else -normal
