"""Where the energy of a mode sits: strain energy by connection, kinetic energy by body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...system.faces import faces
from ...system.system import Array, System

__all__ = ["connections", "kinetic_energy_share", "strain_energy_share"]


def connections(system: System) -> tuple[str, ...]:
    """Names of the meshes (slices together), then of the links, in order."""
    return (*faces(system.meshes).name, *dict.fromkeys(system.links.link))


def strain_energy_share(system: System, vectors: NDArray[np.inexact], rigid: NDArray[np.bool_]) -> Array:
    """Share of the strain energy in each mesh and link; of a complex mode the mean over its cycle.

    Parameters
    ----------
    vectors : (n, modes).  rigid : (modes,) modes without strain energy, where the share is nan.

    Returns
    -------
    (connections, modes), each elastic column with sum 1.
    """
    meshes, links = system.meshes, system.links
    mesh = meshes.stiffness[:, None] * np.abs(meshes.B.T @ vectors) ** 2
    stiffness = np.where(np.isfinite(links.stiffness), links.stiffness, 0.0)
    rows = stiffness[:, None] * np.abs(links.B.T @ vectors) ** 2
    names = {name: i for i, name in enumerate(dict.fromkeys(links.link))}
    link = np.zeros((len(names), vectors.shape[1]))
    np.add.at(link, [names[name] for name in links.link], rows)
    return _shares(np.vstack([faces(meshes).total(mesh), link]), rigid)


def kinetic_energy_share(system: System, vectors: NDArray[np.inexact]) -> Array:
    """Share of the kinetic energy in each body, slaved directions included, (nb, modes); sum 1.

    nan where `System.body_mass` is not given.
    """
    nb = len(system.dofs.bodies)
    if system.body_mass.shape != (nb, 6):
        return np.full((nb, vectors.shape[1]), np.nan)
    full = np.abs(system.dofs.expand @ vectors).reshape(nb, 6, -1)
    energy = np.einsum("bd,bdm->bm", system.body_mass, full**2)
    return _shares(energy, np.zeros(vectors.shape[1], dtype=bool))


def _shares(energy: Array, empty: NDArray[np.bool_]) -> Array:
    total = energy.sum(axis=0)
    empty = empty | ~(total > 0)
    return np.where(empty, np.nan, energy / np.where(empty, 1.0, total))
