"""Stress in the root of spur teeth over the face, in three dimensions: python -m tests.peers.plane.root_face

Prints what docs/theory/contact.md says of it; five minutes.  Needs CalculiX.  The strain along the fillet is taken at
Gauss' points of its edges, that along the axis by differences between the layers.
"""

from __future__ import annotations

import json
import math

import numpy as np
from numpy.typing import NDArray

from epicyclic.teeth.compliance import face_coupling, tooth_compliance
from epicyclic.teeth.root_stress import fillet_stress, root_influence

from .solid import SolidMesh, spur_motion
from .tabulate_face import TARGET, form_of

__all__ = ["root_spread"]

Array = NDArray[np.float64]

_MESH = SolidMesh(layers=8, above=2, below=8, columns=6, gap=3, body=6, rest=8)


def root_spread(name: str) -> tuple[Array, Array, float, float]:
    """Tension in the root between the layers of the face (layers + 1,), under 1 N on each layer (layers,), over that of
    an even load in the middle of the face: elements, then the kernel; the stress of that even load per load per length
    [1/mm], elements and plane.
    """
    entry = json.loads(TARGET.read_text(encoding="utf-8"))[name]
    gear, width, radius = form_of(entry["gear"]), float(entry["width"]), float(entry["radius"])
    points, moved = spur_motion(gear, width, radius, mesh=_MESH)
    points, moved = points[::2], moved[:, ::2]
    stress = np.array([_along(points, u, gear.youngs_modulus / 1e6, gear.poisson) for u in moved])  # (load, place, z)
    both = np.concatenate([stress, stress[::-1, :, ::-1]]).transpose(1, 2, 0)
    even = both.sum(axis=2) * width * 1e3 / _MESH.layers
    place, middle = int(even[:, _MESH.layers // 2].argmax()), _MESH.layers // 2
    found = both[place] * width * 1e3 / even[place, middle]
    plane = float(fillet_stress(root_influence(gear), radius)[0].max()) * 1e-3
    return found, _kernel(tooth_compliance(gear).face_decay(width), width), float(even[place, middle]), plane


def _along(points: Array, moved: Array, modulus: float, poisson: float) -> Array:
    """Stress along the fillet at Gauss' points, (places, z) [MPa], from nodes (z, n, 3) and their motion [mm].

    At both ends of the face no stress acts along the axis.
    """
    found = []
    for first in range(2, points.shape[1] - 2, 2):
        for t in (-1 / math.sqrt(3), 1 / math.sqrt(3)):
            slope, value = (
                np.array([t - 0.5, -2 * t, t + 0.5]),
                np.array([0.5 * t * (t - 1), 1 - t**2, 0.5 * t * (t + 1)]),
            )
            edge, motion = points[:, first : first + 3], moved[:, first : first + 3]
            tangent, stretched = (np.einsum("a,zax->zx", slope, part) for part in (edge, motion))
            strain = np.sum(tangent * stretched, axis=1) / np.sum(tangent**2, axis=1)
            axial = np.gradient(np.einsum("a,za->z", value, motion[..., 2]), points[:, first, 2], edge_order=2)
            stress = modulus / (1 - poisson**2) * (strain + poisson * axial)
            stress[[0, -1]] = modulus * strain[[0, -1]]
            found.append(stress)
    return np.array(found)


def _kernel(decay: float, width: float, fine: int = 20) -> Array:
    """The same ratio (layers + 1, layers) by the coupling along the face."""
    count = _MESH.layers * fine
    lengths = np.full(count, width / count)
    zeta = (np.arange(count) + 0.5) * lengths - width / 2
    whole = face_coupling(zeta, width, decay, lengths).reshape(count, _MESH.layers, fine).mean(axis=2) * width
    between = 0.5 * (whole[fine - 1 : -1 : fine] + whole[fine::fine])
    return np.concatenate([whole[:1], between, whole[-1:]])


def _main() -> None:
    for name in ("spur 25", "spur 60, deep body"):
        elements, kernel, even, plane = root_spread(name)
        print(f"{name}: even load, middle of the face {even:.3f}, plane {plane:.3f} 1/mm")
        print("  even load, end over middle", (elements.sum(axis=1)[0] / _MESH.layers).round(2))
        for load in (0, _MESH.layers // 2 - 1):
            print(f"  load on layer {load}: elements {elements[:, load].round(2)}, kernel {kernel[:, load].round(2)}")


if __name__ == "__main__":
    _main()
