"""Mesh stiffness of every mesh over one mesh cycle."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..engine.cost import MOST_NUMBERS, require_memory
from ..results.dataset import dataset
from ..system.assembly import train_provenance
from ..train.bodies import Mesh
from ..train.train import Train

__all__ = ["stiffness", "stiffness_history"]


def stiffness(train: Train, *, samples: int = 256) -> xr.Dataset:
    """Mesh stiffness of every mesh over one mesh cycle of its stage.

    Parameters
    ----------
    train : resolved train.  samples : points per mesh cycle.

    Returns
    -------
    Dataset : mesh_stiffness (mesh, mesh_phase) and mean_mesh_stiffness (mesh) [N/m] along the tooth normal, phase_lead
        (mesh) [mesh cycles].  mesh_phase is time in mesh cycles and contains the lead: k_i(t) = k_1(t + lead_i T), see
        docs/conventions.md.

    Raises
    ------
    ModelError : more samples than memory holds.
    """
    # values of all meshes, and the terms of one, complex with their angles
    width = len(train.meshes) + 5 * max((len(mesh.variation) for mesh in train.meshes), default=0) + 2
    require_memory(samples * width, path="samples", given=samples, allowed=f"at most {MOST_NUMBERS // width}")
    phase = np.arange(samples) / samples
    return dataset(
        {
            "mesh_stiffness": (
                ("mesh", "mesh_phase"),
                np.array([stiffness_history(mesh, phase) for mesh in train.meshes]).reshape(-1, samples),
            ),
            "mean_mesh_stiffness": ("mesh", np.array([mesh.stiffness for mesh in train.meshes])),
            "phase_lead": ("mesh", np.array([float(mesh.lead) for mesh in train.meshes])),
        },
        coords={"mesh": [mesh.name for mesh in train.meshes], "mesh_phase": phase},
        verb="stiffness",
        options={"samples": samples},
        warnings=train.warnings,
        provenance=train_provenance(train),
    )


def stiffness_history(mesh: Mesh, phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mesh stiffness (T,) [N/m] at times `phase` (T,) [mesh cycles]: Fourier series in sigma = sense (phase + lead)."""
    sigma = mesh.sense * (phase + float(mesh.lead))
    order = np.arange(1, len(mesh.variation) + 1)
    rotation = np.exp(2j * np.pi * np.multiply.outer(sigma, order))
    return mesh.stiffness * (1 + (rotation @ mesh.variation).real)
