"""Objectives of micro-geometry: loaded transmission error, load per length of contact line, dynamic mesh force.

Transmission error and load follow from the loaded contact of each mesh alone.  The dynamic mesh force follows from the
linear sweep of the train, with the tangent stiffness of that contact in its meshes (docs/how-to/relief.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...questions.response.steady import sweep
from ...statics.record import reference_tone
from ...system.system import System
from ...system.tooth_pairs import ContactHistory, pair_of, with_contact_tangent
from ...teeth.gear_pair import ContactPair, uniform_along_face
from ...teeth.loaded_contact import all_segments, first_images
from ...teeth.microgeometries import MicrogeometryContact, microgeometry_contact
from ...teeth.segments import ContactSegments
from ...train.bodies import Mesh
from ...train.train import Train
from ..contact_resolution import Resolution, mesh_phases, sigma_at
from .variables import DesignVariable, FlankSettings, modified_flank, settings_of, varies_along_face

__all__ = [
    "DYNAMIC",
    "OBJECTIVES",
    "ContactSettings",
    "HelixContact",
    "ReliefProblem",
    "coarse_resolution",
    "contact_histories",
    "force_curves",
    "helix_contacts",
    "objectives_of",
    "relative_speeds",
    "with_resolution",
]

Array = NDArray[np.float64]

# Phases and slices of a search where none are given.  With the corners of contact among the phases, and parts of slices
# coupled as parts, objectives are then known to some per cent; the best candidates are solved again (`verification`).
_PHASES, _SLICES = 64, 10

OBJECTIVES = {
    "lte": ("m", "peak to peak of the loaded transmission error, largest over the loads, mean over the meshes"),
    "load": ("N/m", "largest force per length of contact line over the mesh cycle, loads and meshes"),
    "force_rms": ("N", "RMS of the dynamic mesh force, largest over the speeds and meshes"),
    "force_peak": ("N", "mesh force, largest over the speeds and meshes"),
}
"""Objective -> its unit, and the quantity that is minimised."""

DYNAMIC = {"force_rms": "mesh_force_rms", "force_peak": "mesh_force_peak"}
"""Objective of the train in motion -> the variable of `sweep` it is the maximum of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSettings:
    """Discretisation and misalignment of the loaded contact, as of `contact`.

    samples : phases of a mesh cycle.  slices : segments of the face.  None: chosen.  corner : solve corner contact.
    misalignment : of the flanks, in the plane of action [rad].
    """

    samples: int | None
    slices: int | None
    corner: bool
    misalignment: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HelixContact:
    """One helix of a mesh: its place in the train, its contact segments as drawn, its operating load [N]."""

    mesh: Mesh
    segments: ContactSegments
    force: float

    def modified_pair(self, settings: Mapping[str, FlankSettings]) -> ContactPair:
        """Contact pair with the settings of its two flanks applied."""
        pair, teeth = self.segments.pair, self.mesh.teeth
        assert teeth is not None
        a, b = (settings.get(path, {}) for path in teeth.paths)
        return replace(pair, flank_a=modified_flank(pair.flank_a, a), flank_b=modified_flank(pair.flank_b, b))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReliefProblem:
    """Data of the optimisation: o objectives of v design variables, over M meshes and F relative loads.

    objectives : names, of `OBJECTIVES`.  variables : (v,).  fixed : settings that do not vary, by path of the flank.
    meshes : the helices of each mesh.  factors : (F,) loads relative to the operating one [1].
    resolution : phases and slices of these contacts.
    train, system, speeds : the train, and for dynamic objectives its System and (P,) relative speeds [1], else None.
    """

    objectives: tuple[str, ...]
    variables: tuple[DesignVariable, ...]
    fixed: Mapping[str, FlankSettings]
    meshes: tuple[tuple[HelixContact, ...], ...]
    factors: Array
    resolution: Resolution
    train: Train
    system: System | None
    speeds: Array | None

    def __call__(self, candidates: Array) -> Array:
        """Objectives (P, o) of candidates (P, v) in the unit cube; nan where one could not be computed."""
        return objectives_of(self, [settings_of(self.variables, self.fixed, candidate) for candidate in candidates])


def coarse_resolution(
    train: Train, meshes: Sequence[Sequence[tuple[Mesh, float]]], contact: ContactSettings
) -> Resolution:
    """Phases and slices of a search: those given, else few, since the best candidates are solved again."""
    samples = _PHASES if contact.samples is None else contact.samples
    helices = [mesh for one in meshes for mesh, _ in one]
    return Resolution(
        phase=_phases(helices, [pair_of(train, mesh) for mesh in helices], samples, contact),
        samples=samples,
        slices=_SLICES if contact.slices is None else contact.slices,
        graded=contact.samples is None,
        error=np.full(3, np.nan),
    )


def _phases(helices: Sequence[Mesh], pairs: Sequence[ContactPair], samples: int, contact: ContactSettings) -> Array:
    """Phases (T,) of all meshes: even ones where their number is given, else the corners of all of them too."""
    return mesh_phases(helices, pairs, samples) if contact.samples is None else np.arange(samples) / samples


def helix_contacts(
    train: Train,
    meshes: Sequence[Sequence[tuple[Mesh, float]]],
    contact: ContactSettings,
    cut: Resolution,
    *,
    variables: Sequence[DesignVariable],
    fixed: Mapping[str, FlankSettings],
) -> tuple[tuple[HelixContact, ...], ...]:
    """Helices of every mesh cut into contact segments; a face that stays uniform is one segment.

    Parameters
    ----------
    meshes : helices of each mesh with their operating loads [N].  cut : phases and slices.

    Raises
    ------
    ModelError : as of `pair_of`; a relief that does not fit a flank at the bounds.
    """
    result = []
    for helices in meshes:
        pairs = [_cut_pair(train, mesh, contact, cut, variables=variables, fixed=fixed) for mesh, _ in helices]
        segments = all_segments(pairs, [sigma_at(mesh, cut.phase) for mesh, _ in helices])
        result.append(
            tuple(
                HelixContact(mesh=mesh, segments=one, force=force)
                for (mesh, force), one in zip(helices, segments, strict=True)
            )
        )
    return tuple(result)


def _cut_pair(
    train: Train,
    mesh: Mesh,
    contact: ContactSettings,
    cut: Resolution,
    *,
    variables: Sequence[DesignVariable],
    fixed: Mapping[str, FlankSettings],
) -> ContactPair:
    """Contact pair of a helix in slices, or in one where the face stays uniform."""
    pair = pair_of(train, mesh, slices=cut.slices, corner=contact.corner, misalignment=contact.misalignment)
    even = uniform_along_face(pair) and not varies_along_face(variables, fixed)
    return replace(pair, slices=1) if even else pair


def with_resolution(problem: ReliefProblem, contact: ContactSettings, cut: Resolution) -> ReliefProblem:
    """Problem with other phases and slices; of `cut` the numbers of both count, the phases are those of all meshes."""
    helices = [helix for one in problem.meshes for helix in one]
    pairs = [helix.segments.pair for helix in helices]
    common = replace(cut, phase=_phases([helix.mesh for helix in helices], pairs, cut.samples, contact))
    meshes = [[(helix.mesh, helix.force) for helix in one] for one in problem.meshes]
    parts = helix_contacts(problem.train, meshes, contact, common, variables=problem.variables, fixed=problem.fixed)
    return replace(problem, meshes=parts, resolution=common)


def relative_speeds(system: System, mesh_frequencies: tuple[float, float] | None, points: int) -> Array:
    """Relative speeds (P,) [1], evenly spaced between two mesh frequencies of the first mesh [Hz].

    mesh_frequencies : None is 0.2 and 1.2 times the operating one.

    Raises
    ------
    ModelError : no speed, an empty range.
    """
    tone = float(reference_tone(system))
    low, high = (0.2 * tone, 1.2 * tone) if mesh_frequencies is None else mesh_frequencies
    if not (0 < low <= high < math.inf) or points < 1:
        raise ModelError("the range is empty", path="start, stop", given=f"{low:g} Hz to {high:g} Hz, {points} points")
    return np.linspace(low, high, points) / tone


def objectives_of(problem: ReliefProblem, settings: Sequence[Mapping[str, FlankSettings]]) -> Array:
    """Objectives (S, o) of S sets of flank settings, in the units of `OBJECTIVES`; nan where contact is not solved."""
    contacts = _loaded_contacts(problem, settings)
    values = np.full((len(settings), len(problem.objectives)), np.nan)
    static = slice(0, len(problem.factors))
    for column, name in enumerate(problem.objectives):
        if name == "lte":
            ranges = [_peak_to_peak(problem, i, helices, static) for i, helices in enumerate(contacts)]
            values[:, column] = np.mean(ranges, axis=0)
        elif name == "load":
            largest = [one.largest_load[:, static] for helices in contacts for one in helices]
            values[:, column] = np.max(largest, axis=(0, 2))
    solved = np.all([one.solved.all(axis=1) for helices in contacts for one in helices], axis=0)
    if problem.system is not None:
        dynamic = [name for name in problem.objectives if name in DYNAMIC]
        columns = [problem.objectives.index(name) for name in dynamic]
        for i in np.flatnonzero(solved):
            curves = force_curves(problem, _histories(problem, contacts, int(i)))
            values[i, columns] = [float(curves[name].max()) for name in dynamic]
    values[~solved] = np.nan
    return values


def _loaded_contacts(
    problem: ReliefProblem, settings: Sequence[Mapping[str, FlankSettings]]
) -> list[list[MicrogeometryContact]]:
    """Loaded contact of every helix of every mesh; dynamic objectives append the operating load, with its tangents."""
    dynamic = problem.system is not None
    loads = np.append(problem.factors, 1.0) if dynamic else problem.factors
    largest = "load" in problem.objectives
    return [_of_helices(helices, settings, loads, tangents=dynamic, largest=largest) for helices in problem.meshes]


def _of_helices(
    helices: Sequence[HelixContact],
    settings: Sequence[Mapping[str, FlankSettings]],
    loads: Array,
    *,
    tangents: bool,
    largest: bool,
) -> list[MicrogeometryContact]:
    """Loaded contact of the helices of a mesh; one that mirrors another for all settings has the numbers of that."""
    pairs = [[helix.modified_pair(one) for one in settings] for helix in helices]
    sigma = [helix.segments.sigma for helix in helices]
    images = [first_images(column, sigma) for column in zip(*pairs, strict=True)]
    found: list[MicrogeometryContact] = []
    for i, helix in enumerate(helices):
        first = {image[i] for image in images}
        if first != {i} and len(first) == 1:
            found.append(found[first.pop()])
        else:
            found.append(
                microgeometry_contact(helix.segments, pairs[i], helix.force * loads, tangents=tangents, largest=largest)
            )
    return found


def _peak_to_peak(problem: ReliefProblem, mesh: int, helices: Sequence[MicrogeometryContact], loads: slice) -> Array:
    """Largest peak to peak over the loads of the transmission error, mean of the helices, (S,) [m]."""
    planes = [helix.segments.pair.plane for helix in problem.meshes[mesh]]
    error = np.mean(
        [one.approach[:, loads] / math.cos(plane.base_helix) for one, plane in zip(helices, planes, strict=True)],
        axis=0,
    )
    return np.asarray(np.ptp(error, axis=2).max(axis=1))


def contact_histories(problem: ReliefProblem, settings: Mapping[str, FlankSettings]) -> dict[str, ContactHistory]:
    """Loaded contact of every mesh over its mesh cycle at the operating load, for one set of flank settings."""
    return _histories(problem, _loaded_contacts(problem, [settings]), 0)


def _histories(
    problem: ReliefProblem, contacts: Sequence[Sequence[MicrogeometryContact]], i: int
) -> dict[str, ContactHistory]:
    """Name of each helix -> its contact history at the last load and the even phases, of the i-th set of settings."""
    even = problem.resolution.even
    return {
        helix.mesh.name: ContactHistory(
            force=helix.force, approach=one.approach[i, -1, even], tangent=one.tangent[i, -1, even]
        )
        for helices, solved in zip(problem.meshes, contacts, strict=True)
        for helix, one in zip(helices, solved, strict=True)
    }


def force_curves(problem: ReliefProblem, histories: Mapping[str, ContactHistory]) -> dict[str, Array]:
    """Dynamic objective -> largest RMS or peak of the mesh forces at each speed, (P,) [N]; nan where a speed failed."""
    assert problem.system is not None
    assert problem.speeds is not None
    system = with_contact_tangent(problem.train, problem.system, histories)
    result = sweep(system, relative_speed=problem.speeds)
    pairs = {helix.mesh.pair for helices in problem.meshes for helix in helices}
    names = [mesh.name for mesh in problem.train.meshes if mesh.pair in pairs]
    kept = result.sel(mesh=names)
    return {name: kept[DYNAMIC[name]].values.max(axis=0) for name in DYNAMIC}
