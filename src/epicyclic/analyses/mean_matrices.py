"""The mean linear system as matrices, for other programs: what modes and harmonic superposition stand on.

    M q'' + (C + G) q' + K q = F u + B (k e + c e') + f        gaps  B^T q - e,  mesh forces  k gap + c gap'

at one speed; k and c the mean stiffness and damping of the meshes, contained in K and C (docs/design.md, The one idea).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..statics.tangent import linear
from ..system.system import Array, ComplexArray, System
from .modes.basis import mean_modes

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["mean_matrices"]

_LENGTHS = ("x", "y", "z")


def mean_matrices(system: System, *, relative_speed: float = 1.0) -> xr.Dataset:
    """Matrices of the mean linear system at a relative speed s; laws by their tangents at the mean load.

    Returns
    -------
    Of n coordinates, m mesh rows, p link rows, nb bodies, u ports, h lines of excitation:

    ``M, C, G, K`` (n, n) : mass, damping (dampers, meshes, modal damping), gyroscopic and stiffness matrix (links, mean
        meshes, s^2 Kg, s Cskew).  Entry (i, j) has the unit of the load on i per unit of coordinate j (of its rate, its
        second derivative): N/m, N/rad, N m/m, N m/rad; ``coordinate_unit``, ``load_unit`` (n,).
    ``B`` (n, m) : mesh rows [1 on lengths, m on angles]; ``mesh_stiffness``, ``mesh_damping`` (m,) [N/m, N s/m].
    ``L`` (n, p) : link rows; ``link_stiffness``, ``link_damping`` (p,) [N/m, N m/rad; with s].
    ``T`` (6 nb, n) : x y z rx ry rz of every body [m, rad] = T q; a load on them acts as T^T load.
    ``F`` (n, u) : loads of one newton metre on the members that turn; ``port_torque`` (u,) those of the operating point
        [N m], ``load`` (n,) all steady external loads [N, N m].
    ``gap_error`` (m, h), ``excitation`` (n, h) : complex amplitudes of e [m] and of all that stands on the right side
        (mesh errors k e + c e', link errors, unbalance, gravity) [N, N m], Re(a exp(2 pi i t f));
        ``excitation_frequency`` (h,) [Hz].

    Raises
    ------
    ModelError : a mass or inertia is missing; as of `linear`.
    """
    from ..results.dataset import dataset

    system = linear(system)
    names, meshes, links = list(system.dofs.names), system.meshes, system.links
    ports = _ports(system)
    F = np.zeros((len(names), len(ports)))
    F[ports, np.arange(len(ports))] = 1.0
    error, load = _excitation(system, relative_speed)
    lengths = [direction in _LENGTHS for direction in system.dofs.direction]
    square = ("equation", "dof")
    variables: dict[str, Any] = {
        "M": (square, system.M),
        "C": (square, _damping(system)),
        "G": (square, relative_speed * system.G),
        "K": (square, system.mean_stiffness + relative_speed**2 * system.Kg + relative_speed * system.Cskew),
        "B": (("equation", "mesh_row"), meshes.B),
        "L": (("equation", "link_row"), links.B),
        "T": (("full_coordinate", "dof"), system.dofs.expand),
        "F": (("equation", "port"), F),
        "mesh_stiffness": ("mesh_row", meshes.stiffness),
        "mesh_damping": ("mesh_row", meshes.damping),
        "link_stiffness": ("link_row", links.stiffness),
        "link_damping": ("link_row", links.damping),
        "load": ("equation", system.force),
        "port_torque": ("port", system.force[ports]),
        "excitation": (("equation", "line"), load),
        "gap_error": (("mesh_row", "line"), error),
        "excitation_frequency": ("line", np.array([relative_speed * float(one.frequency) for one in system.lines])),
        "coordinate_body": ("dof", list(system.dofs.body)),
        "coordinate_direction": ("dof", list(system.dofs.direction)),
        "coordinate_unit": ("dof", ["m" if length else "rad" for length in lengths]),
        "load_unit": ("equation", ["N" if length else "N m" for length in lengths]),
    }
    if system.body_turns:
        turns = np.array([float(turn) for turn in system.body_turns])
        variables["speed"] = ("body", 60 * relative_speed * turns)
    return dataset(
        variables,
        {
            "dof": names,
            "equation": names,
            "mesh_row": list(meshes.name),
            "link_row": list(links.name),
            "port": [names[place] for place in ports],
            "body": list(system.dofs.bodies),
            "full_coordinate": [
                f"{body}/{way}" for body in system.dofs.bodies for way in ("x", "y", "z", *"rx ry rz".split())
            ],
            "line": ["; ".join(one.causes) for one in system.lines],
        },
        verb="matrices",
        options={"relative_speed": relative_speed},
        provenance=system.provenance,
        warnings=system.warnings,
    )


def _ports(system: System) -> list[int]:
    """Coordinates rz of the members that no carrier carries round, and of all with an external torque."""
    turning = [place for place, way in enumerate(system.dofs.direction) if way == "rz"]
    return [
        place
        for place in turning
        if system.force[place] or not any(part.isdigit() for part in system.dofs.body[place].split("/"))
    ]


def _damping(system: System) -> Array:
    """Dampers, meshes, and modal damping as the matrix that damps every elastic mode by zeta, (n, n)."""
    B = system.meshes.B
    total: Array = system.C + (B * system.meshes.damping) @ B.T
    squared, shapes = mean_modes(system)
    if system.zeta:
        momenta = system.M @ shapes
        total = total + (momenta * (2 * system.zeta * np.sqrt(squared))) @ momenta.T
    return total


def _excitation(system: System, s: float) -> tuple[ComplexArray, ComplexArray]:
    """Errors of the mesh rows (m, h) [m] and loads of all causes (n, h) [N, N m] of every line."""
    meshes, n = system.meshes, len(system.force)
    error, load = np.zeros((len(meshes.name), len(system.lines)), complex), np.zeros((n, len(system.lines)), complex)
    for place, line in enumerate(system.lines):
        omega = 2 * np.pi * s * float(line.frequency)
        error[:, place] = line.gap
        load[:, place] = line.force[0] + s * line.force[1] + s**2 * line.force[2]
        load[:, place] += meshes.B @ ((meshes.stiffness + 1j * omega * meshes.damping) * line.gap)
    return error, load
