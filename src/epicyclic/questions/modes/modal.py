"""Modes of a train and the matrices of its mean linear system, as labelled Datasets.

Modes have natural frequencies, kinds, shapes and shares of strain and kinetic energy.  The matrices, for other
programs, are what modes and harmonic superposition stand on,

    M q'' + (C + G) q' + K q = F u + B (k e + c e') + f        gaps  B^T q - e,  mesh forces  k gap + c gap'

at one speed; k and c the mean stiffness and damping of the meshes, contained in K and C (docs/design.md, The one idea).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...statics.record import unheld_warnings
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded
from .eigen import (
    ClassifiedModes,
    classify_modes,
    damping_ratios,
    eigen,
    mean_modes,
    normalisation,
    spread_warnings,
    whirl,
)

if TYPE_CHECKING:
    import xarray as xr

_LENGTHS = ("x", "y", "z")
_DIRECTIONS = (*_LENGTHS, "rx", "ry", "rz")


def modal(system: System, *, relative_speed: float = 0.0, damped: bool = False) -> xr.Dataset:
    """Natural frequencies and modes of the mean system, all repeated roots included.

    At standstill and undamped the shapes are real; otherwise they are complex: the motion of a coordinate is
    Re(shape exp(2 pi i frequency t)), decaying with the damping ratio.  Shapes have their largest component at 1
    (torsion as u = R rz).  Modes of one frequency have a fixed basis, see `eigen.canonical_basis`.  A rigid
    mode has frequency exactly 0 and no strain energy (share nan).

    Parameters
    ----------
    system : where links have laws, their tangents at the mean load stand for them (`statics.tangent.linear`).
    relative_speed : speed per operating speed [1]; other than 0 brings in the gyroscopic and centripetal terms.
    damped : solve the damped problem.  Undamped, damping ratios are the modal projection at standstill (nan without
        damping) and nan at speed.

    Raises
    ------
    ModelError : mass or inertia missing, an unstable mean system, or no damping where it is asked for.
    """
    system = linear(system)
    modes = eigen(system)
    if relative_speed == 0 and not damped:
        values: NDArray[np.inexact] = modes.omega_squared
        angular, growth = modes.omega, np.zeros(len(values))
        ratios = damping_ratios(system, modes)
        vectors: NDArray[np.inexact] = modes.vectors
    else:
        turning = whirl(system, relative_speed=relative_speed, damped=damped, modes=modes)
        values, vectors, angular, growth = turning.mu, turning.vectors, turning.mu.imag, turning.mu.real
        size = np.abs(values)
        ratios = np.full(len(size), np.nan)
        if damped:  # nan for rigid modes
            ratios = np.where(size > 0, -growth / np.where(size > 0, size, 1.0), np.nan)
    options = {"relative_speed": float(relative_speed), "damped": bool(damped)}
    kinds = classify_modes(system, values, vectors)
    warnings = unheld_warnings(system, modes.vectors[:, modes.omega_squared == 0])
    worst = float(np.max(growth, initial=0.0))
    # 1e-6 of the largest frequency is rounding of a defective root
    if worst > 1e-6 * float(np.max(angular, initial=0.0)):
        warnings.append(coded("mode-grows", f"a mode grows at {worst:.4g} 1/s: the train is unstable at this speed"))
    warnings += spread_warnings(modes.omega_squared)
    return _dataset(system, angular, ratios, kinds, np.abs(values) == 0, options, warnings)


def _dataset(
    system: System,
    angular: Array,
    ratios: Array,
    kinds: ClassifiedModes,
    rigid: NDArray[np.bool_],
    options: dict[str, float | bool],
    warnings: Sequence[CodedText],
) -> xr.Dataset:
    """The labelled result; angular (n,) [rad/s], ratios (n,) [1], rigid (n,).

    Shapes scaled to a largest component of 1.
    """
    from ...results.dataset import dataset

    dofs = system.dofs
    vectors = kinds.vectors * normalisation(kinds.vectors, dofs.radius)
    turning = {b: R for b, d, R in zip(dofs.body, dofs.direction, dofs.radius, strict=True) if d == "rz"}
    # R of each body's u = R rz; 1 where rz is not a coordinate of its own
    radius = np.array([turning.get(body, 1.0) for body in dofs.bodies])
    full = (dofs.rigid @ vectors).reshape(len(dofs.bodies), 6, -1)
    full[:, 5] *= radius[:, None]
    result = dataset(
        {
            "frequency": ("mode", angular / (2 * np.pi)),
            "angular_frequency": ("mode", angular),
            "mode_kind": ("mode", np.array(kinds.kind, dtype=object)),
            "multiplicity": ("mode", kinds.multiplicity),
            "shape": (("dof", "mode"), vectors * dofs.radius[:, None]),
            "full_shape": (("body", "direction", "mode"), full),
            "strain_energy_share": (("connection", "mode"), _strain_energy_share(system, vectors, rigid)),
            "kinetic_energy_share": (("body", "mode"), _kinetic_energy_share(system, vectors)),
            "damping_ratio": ("mode", ratios),
        },
        {
            "mode": np.arange(1, len(angular) + 1),
            "dof": np.array(dofs.names, dtype=object),
            "body": np.array(dofs.bodies, dtype=object),
            "direction": np.array(_DIRECTIONS, dtype=object),
            "connection": np.array([*faces(system.meshes).name, *dict.fromkeys(system.links.link)], dtype=object),
            "reference_radius": ("body", radius),
        },
        verb="modes",
        options=options,
        provenance=system.provenance,
        warnings=(*system.warnings, *warnings),
    )
    result["reference_radius"].attrs.update({"units": "m", "long_name": "reference radius R of u = R rz"})
    result.attrs["relative_speed"] = float(options["relative_speed"])
    return result


def _strain_energy_share(system: System, vectors: NDArray[np.inexact], rigid: NDArray[np.bool_]) -> Array:
    """Share of the strain energy in each mesh (slices together) and link; of a complex mode the mean over its cycle.

    Parameters
    ----------
    vectors : (n, modes).  rigid : (modes,) modes without strain energy, where the share is nan.

    Returns
    -------
    (connections, modes) [1], each elastic column with sum 1.
    """
    meshes, links = system.meshes, system.links
    mesh = meshes.stiffness[:, None] * np.abs(meshes.B.T @ vectors) ** 2
    stiffness = np.where(np.isfinite(links.stiffness), links.stiffness, 0.0)
    rows = stiffness[:, None] * np.abs(links.B.T @ vectors) ** 2
    names = {name: i for i, name in enumerate(dict.fromkeys(links.link))}
    link = np.zeros((len(names), vectors.shape[1]))
    np.add.at(link, [names[name] for name in links.link], rows)
    return _normalised_energy(np.vstack([faces(meshes).total(mesh), link]), rigid)


def _kinetic_energy_share(system: System, vectors: NDArray[np.inexact]) -> Array:
    """Share of the kinetic energy in each body, slaved directions included, (bodies, modes) [1]; sum 1.

    nan where `System.body_mass` is not given.
    """
    nb = len(system.dofs.bodies)
    if system.body_mass.shape != (nb, 6):
        return np.full((nb, vectors.shape[1]), np.nan)
    full = np.abs(system.dofs.rigid @ vectors).reshape(nb, 6, -1)
    energy = np.einsum("bd,bdm->bm", system.body_mass, full**2)
    for body, bent in bending_energy(system, vectors).items():
        energy[body] += bent
    return _normalised_energy(energy, np.zeros(vectors.shape[1], dtype=bool))


def bending_energy(system: System, vectors: NDArray[np.inexact]) -> dict[int, Array]:
    """Twice the kinetic energy that a body has beside that of a rigid one, by its index, (modes,), per squared rate."""
    full, first = system.dofs.expand @ vectors, system.dofs.rigid.shape[0]
    energies = {}
    for body, names in system.dofs.elastic:
        at = np.r_[6 * body : 6 * body + 6, first : first + len(names)]
        first += len(names)
        energies[body] = np.einsum("im,ij,jm->m", full[at].conj(), system.bent_mass[np.ix_(at, at)], full[at]).real
    return energies


def _normalised_energy(energy: Array, empty: NDArray[np.bool_]) -> Array:
    """Energies (rows, modes) per column sum [1]; nan in `empty` columns (modes,) and in those that sum to zero."""
    total = energy.sum(axis=0)
    empty = empty | ~(total > 0)
    return np.where(empty, np.nan, energy / np.where(empty, 1.0, total))


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
    from ...results.dataset import dataset

    system = linear(system)
    names, meshes, links = list(system.dofs.names), system.meshes, system.links
    # rz of the members that no carrier carries round, and of all with an external torque
    carried = [any(word.isdigit() for word in body.split("/")) for body in system.dofs.body]
    turning = [i for i, direction in enumerate(system.dofs.direction) if direction == "rz"]
    ports = [i for i in turning if system.force[i] or not carried[i]]
    error, load = _excitation(system, relative_speed)
    lengths = [direction not in _DIRECTIONS[3:] for direction in system.dofs.direction]
    square = ("equation", "dof")
    variables: dict[str, Any] = {
        "M": (square, system.M),
        "C": (square, _damping(system)),
        "G": (square, relative_speed * system.G),
        "K": (square, system.mean_stiffness + relative_speed**2 * system.Kg + relative_speed * system.Cskew),
        "B": (("equation", "mesh_row"), meshes.B),
        "L": (("equation", "link_row"), links.B),
        "T": (("full_coordinate", "dof"), system.dofs.expand),
        "F": (("equation", "port"), np.eye(len(names))[:, ports]),
        "mesh_stiffness": ("mesh_row", meshes.stiffness),
        "mesh_damping": ("mesh_row", meshes.damping),
        "link_stiffness": ("link_row", links.stiffness),
        "link_damping": ("link_row", links.damping),
        "load": ("equation", system.force),
        "port_torque": ("port", system.force[ports]),
        "excitation": (("equation", "line"), load),
        "gap_error": (("mesh_row", "line"), error),
        "excitation_frequency": ("line", np.array([relative_speed * float(line.frequency) for line in system.lines])),
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
            "port": [names[port] for port in ports],
            "body": list(system.dofs.bodies),
            "full_coordinate": [f"{body}/{direction}" for body in system.dofs.bodies for direction in _DIRECTIONS]
            + [f"{system.dofs.bodies[body]}/{name}" for body, names in system.dofs.elastic for name in names],
            "line": ["; ".join(line.causes) for line in system.lines],
        },
        verb="matrices",
        options={"relative_speed": relative_speed},
        provenance=system.provenance,
        warnings=system.warnings,
    )


def _damping(system: System) -> Array:
    """Dampers, meshes, and modal damping as the matrix that damps every elastic mode by zeta, (n, n)."""
    total = system.mean_damping
    squared, shapes = mean_modes(system)
    if system.zeta:
        momenta = system.M @ shapes
        total = total + (momenta * (2 * system.zeta * np.sqrt(squared))) @ momenta.T
    return total


def _excitation(system: System, s: float) -> tuple[ComplexArray, ComplexArray]:
    """Errors of the mesh rows (m, h) [m] and loads of all causes (n, h) [N, N m] of every line."""
    meshes, count = system.meshes, len(system.lines)
    error, load = np.zeros((len(meshes.name), count), complex), np.zeros((len(system.force), count), complex)
    for column, line in enumerate(system.lines):
        omega = 2 * np.pi * s * float(line.frequency)
        error[:, column] = line.gap
        load[:, column] = line.force[0] + s * line.force[1] + s**2 * line.force[2]
        load[:, column] += meshes.B @ ((meshes.stiffness + 1j * omega * meshes.damping) * line.gap)
    return error, load
