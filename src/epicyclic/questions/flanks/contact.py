"""Loaded tooth contact, of one pair of gears alone or of all meshes of a train: what both have alike.

Loads on the faces of the meshes at several levels of load, and the Dataset of what follows from them: load
along the faces, face factors, stress in the tooth roots.  Beside it the mesh stiffness that a train has without tooth
contact, of every mesh over one mesh cycle.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import MOST_NUMBERS, require_memory
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.tooth_pairs import FaceLoad
from ...teeth.gear_pair import ContactPair
from ...teeth.path_of_contact import averaging_length, largest_part_mean
from ...teeth.root_stress import RootStress, pair_influences, root_stress
from ...train.train import Mesh, Train
from . import ContactOptions, StiffnessOptions

Array = NDArray[np.float64]
Columns = dict[str, tuple[Any, Array]]
Stresses = Iterable[tuple[RootStress, RootStress]]

_LOADS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Loads by default, relative to the operating one [1]."""


def load_levels(options: ContactOptions, *, zero: bool) -> Array:
    """Loads (F,) relative to the operating one, which is among them [1], rising; zero : whether 0 is one.

    Raises
    ------
    ModelError : a load that is negative or not finite, or 0.
    """
    given = _LOADS if options.loads is None else options.loads
    levels = np.array(sorted({1.0, *(float(load) for load in given)}))
    if not (np.isfinite(levels).all() and (levels[0] > 0 or (zero and levels[0] == 0))):
        allowed = "0 or more" if zero else "above 0"
        raise ModelError("relative loads", path="loads", given=list(given), allowed=allowed)
    return levels


# loads on faces -------------------------------------------------------------------------------------------------------


class LoadedFaces(NamedTuple):
    """Loads on the faces of w meshes at F levels of load and T instants.

    pairs : of teeth, of each mesh.  images : number of the first mesh that each one mirrors with its loads, or its own.
    levels : (F,) loads per operating load [1].  loads : at each level, by mesh.
    weight : (T,) of the instants in a mean over the record [1].
    loaded : (F, w) meshes that carry load; the others have no factor.
    """

    meshes: Sequence[Mesh]
    pairs: Sequence[ContactPair]
    images: Sequence[int]
    levels: Array
    loads: Sequence[Sequence[FaceLoad]]
    weight: Array
    loaded: NDArray[np.bool_]

    @property
    def operating(self) -> int:
        """Index of the operating load."""
        return int(np.argmin(np.abs(self.levels - 1.0)))

    def columns(self) -> Columns:
        """Variables along the faces of all meshes, over the load."""

        def of_meshes(value: Callable[[FaceLoad], Any]) -> Array:
            return np.array([[value(load) for load in level] for level in self.loads])

        over_time = of_meshes(lambda load: load.force.sum(axis=1)).swapaxes(1, 2)
        slice_load = np.array([np.tensordot(self.weight, level, 1) for level in over_time])
        span = np.array([pair.plane.width / pair.slices for pair in self.pairs])
        with np.errstate(invalid="ignore", divide="ignore"):
            factor = np.where(self.loaded, largest_part_mean(slice_load) / slice_load.mean(axis=2), np.nan)
        solved = of_meshes(lambda load: np.isfinite(load.force).all())
        largest = of_meshes(lambda load: np.nanmax(load.per_length))
        smallest = of_meshes(lambda load: np.min(load.per_length, where=load.whole, initial=np.inf))
        over = ("torque_factor", "mesh")
        return {
            "face_load": ((*over, "width"), slice_load / span[:, None]),
            "face_load_factor": (over, factor),
            "largest_load_per_length": (over, np.where(solved, largest, np.nan)),
            "smallest_load_per_length": (over, smallest),
        }

    def root_stresses(self) -> Iterator[tuple[RootStress, RootStress]]:
        """Stress in the roots of both gears of each mesh, (F, T, J, K); of a mirror image once."""
        influences = cache(pair_influences)
        kept: dict[int, tuple[RootStress, RootStress]] = {}
        for number, (pair, image) in enumerate(zip(self.pairs, self.images, strict=True)):
            if image in kept:
                a, b = (_mirrored(gear) for gear in kept[image])
                yield a, b
                continue
            force = np.array([level[number].force for level in self.loads])
            gears = root_stress(pair, self.loads[0][number].sigma, force, influences(pair))
            if number in self.images[number + 1 :]:
                kept[number] = gears
            yield gears


def _mirrored(gear: RootStress) -> RootStress:
    return RootStress(tension=gear.tension[..., ::-1], compression=gear.compression[..., ::-1], lean=gear.lean)


def cycle_weight(times: Array, length: float) -> Array:
    """Weights (T,) of instants in the mean over a length, which repeats, of values linear between them [1]."""
    order = np.argsort(times)
    apart = np.diff(times[order], append=times[order[0]] + length) / length
    weight = np.empty(len(times))
    weight[order] = 0.5 * (apart + np.roll(apart, 1))
    return weight


def flank_map(sigma: Array, values: Array, loaded: NDArray[np.bool_], place: Array) -> Array:
    """Values of all phases and tooth pairs laid on the flank of one tooth, (K, P); nan where nothing touches.

    Parameters
    ----------
    sigma : (T, J, K) places on the path of contact [base pitches] at T phases, J pairs of teeth, K slices.
    values, loaded : (T, J, K) values there, and which of them count.  place : (P,) places of the map [base pitches].
    """
    flank = np.full((sigma.shape[2], len(place)), np.nan)
    for k in range(len(flank)):
        touching = loaded[:, :, k]
        at, value = sigma[:, :, k][touching], values[:, :, k][touching]
        order = np.argsort(at)
        flank[k] = np.interp(place, at[order], value[order], left=np.nan, right=np.nan)
    return flank


def contact_columns(faces: LoadedFaces, stresses: Stresses) -> Columns:
    """Variables that meshes have alone and in a train; stresses : as of `LoadedFaces.root_stresses`."""
    axes, over = (1, 2, 3), ("torque_factor", "mesh", "mesh_gear")
    extremes = np.array(
        [[(gear.tension.max(axis=axes), gear.compression.min(axis=axes)) for gear in gears] for gears in stresses]
    )  # (mesh, gear, 2, F)
    tension, compression = extremes.transpose(2, 3, 0, 1)
    return {
        **faces.columns(),
        "largest_root_stress": (over, tension),
        "lowest_root_stress": (over, compression),
        "averaging_length": ("mesh", np.array([averaging_length(pair.plane) for pair in faces.pairs])),
        "shared_face": ("mesh", np.array([pair.plane.width for pair in faces.pairs])),
        "side": ("mesh", np.array([mesh.side or "face" for mesh in faces.meshes])),
    }


def contact_coords(faces: LoadedFaces) -> dict[Hashable, Any]:
    """Coordinates of these variables."""
    slices = faces.pairs[0].slices
    return {
        "torque_factor": faces.levels,
        "mesh": [mesh.name for mesh in faces.meshes],
        "mesh_gear": ["a", "b"],
        "width": (np.arange(slices) + 0.5) / slices,
    }


# mesh stiffness without contact ---------------------------------------------------------------------------------------


def stiffness(train: Train, options: StiffnessOptions) -> xr.Dataset:
    """Mesh stiffness of every mesh over one mesh cycle of its stage.

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
    samples = options.samples
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
