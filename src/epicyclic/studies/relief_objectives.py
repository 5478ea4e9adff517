"""What micro-geometry is judged by: transmission error, load per length, dynamic mesh force of the train."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..analyses.static.record import reference_tone
from ..analyses.steady.sweep import sweep
from ..assemble.tabulated import ContactHistory, with_contact_tangent
from ..assemble.tooth_pairs import pair_of
from ..errors import ModelError
from ..system.system import System
from ..tooth_contact.microgeometries import MicrogeometryContact, microgeometry_contact
from ..tooth_contact.pair import ContactPair, uniform_along_face
from ..tooth_contact.segments import ContactSegments, contact_segments
from ..train.connections import Mesh
from ..train.train import Train
from .relief_variables import Setting, Variable, applied, lead_varies, settings_of

__all__ = ["DYNAMIC", "OBJECTIVES", "Cut", "Helix", "Judge", "helices", "histories", "judged", "run_up", "speed_curves"]

Array = NDArray[np.float64]

OBJECTIVES = {
    "lte": ("m", "peak to peak of the loaded transmission error, largest over the loads, mean over the meshes"),
    "load": ("N/m", "largest force per length of contact line over the mesh cycle, loads and meshes"),
    "force_rms": ("N", "RMS of the dynamic mesh force, largest over the speeds and meshes"),
    "force_peak": ("N", "mesh force, largest over the speeds and meshes"),
}
"""Objectives: unit, and what is made least."""

DYNAMIC = {"force_rms": "mesh_force_rms", "force_peak": "mesh_force_peak"}
"""Objectives that need the train in motion, and the variable of a sweep they are taken from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """How contact is computed, as of `contact`: phases, pieces, tips beyond the path, misalignment [rad]."""

    samples: int
    slices: int
    corner: bool
    misalignment: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Helix:
    """One helix of a mesh: where it is in the train, its pieces as drawn, its load in operation [N]."""

    mesh: Mesh
    pieces: ContactSegments
    force: float

    def shaped(self, settings: Mapping[str, Setting]) -> ContactPair:
        """The pair with what is set on its flanks."""
        pair, teeth = self.pieces.pair, self.mesh.teeth
        assert teeth is not None
        a, b = (settings.get(path, {}) for path in teeth.paths)
        return replace(pair, flank_a=applied(pair.flank_a, a), flank_b=applied(pair.flank_b, b))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judge:
    """All that an evaluation needs.

    meshes : the helices of every mesh looked at.  factors : loads beside the operating one.
    train, system, speeds : (P,) relative, of the dynamic objectives; None without them.
    """

    objectives: tuple[str, ...]
    variables: tuple[Variable, ...]
    fixed: Mapping[str, Setting]
    meshes: tuple[tuple[Helix, ...], ...]
    factors: Array
    train: Train
    system: System | None
    speeds: Array | None

    def __call__(self, places: Array) -> Array:
        """Objectives (P, o) at places (P, v) in the unit cube; nan where one could not be computed."""
        return judged(self, [settings_of(self.variables, self.fixed, place) for place in places])


def helices(
    train: Train,
    meshes: Sequence[Sequence[tuple[Mesh, float]]],
    cut: Cut,
    *,
    variables: Sequence[Variable],
    fixed: Mapping[str, Setting],
) -> tuple[tuple[Helix, ...], ...]:
    """Helices with their forces, cut into pieces: one piece across the face where nothing differs along it.

    Raises
    ------
    ModelError : as of `pair_of`; a relief that does not fit a flank at the bounds.
    """
    phase = np.arange(cut.samples) / cut.samples
    found = []
    for sides in meshes:
        own = []
        for mesh, force in sides:
            pair = pair_of(train, mesh, slices=cut.slices, corner=cut.corner, misalignment=cut.misalignment)
            if uniform_along_face(pair) and not lead_varies(variables, fixed):
                pair = replace(pair, slices=1)
            pieces = contact_segments(pair, mesh.sense * (phase + float(mesh.lead)))
            own.append(Helix(mesh=mesh, pieces=pieces, force=force))
        found.append(tuple(own))
    return tuple(found)


def run_up(system: System, speeds: tuple[float, float] | None, points: int) -> Array:
    """Relative speeds (P,) between two mesh frequencies of the first mesh [Hz]; None: 0.2 .. 1.2 times the operating.

    Raises
    ------
    ModelError : no speed, an empty range.
    """
    tone = float(reference_tone(system))
    low, high = (0.2 * tone, 1.2 * tone) if speeds is None else speeds
    if not (0 < low <= high < math.inf) or points < 1:
        raise ModelError("the range is empty", path="start, stop", given=f"{low:g} Hz to {high:g} Hz, {points} points")
    return np.linspace(low, high, points) / tone


def judged(judge: Judge, settings: Sequence[Mapping[str, Setting]]) -> Array:
    """Objectives (S, o) of what is set on the flanks."""
    dynamic = judge.system is not None
    found = _contacts(judge, settings)
    values = np.full((len(settings), len(judge.objectives)), np.nan)
    static = slice(0, len(judge.factors))
    for column, name in enumerate(judge.objectives):
        if name == "lte":
            values[:, column] = np.mean([_swing(judge, i, sides, static) for i, sides in enumerate(found)], axis=0)
        elif name == "load":
            values[:, column] = np.max([one.largest_load[:, static] for sides in found for one in sides], axis=(0, 2))
    solved = np.all([one.solved.all(axis=1) for sides in found for one in sides], axis=0)
    if dynamic:
        wanted = [name for name in judge.objectives if name in DYNAMIC]
        columns = [judge.objectives.index(name) for name in wanted]
        for i in np.flatnonzero(solved):
            curves = speed_curves(judge, _histories(judge, found, int(i)))
            values[i, columns] = [float(curves[name].max()) for name in wanted]
    values[~solved] = np.nan
    return values


def _contacts(judge: Judge, settings: Sequence[Mapping[str, Setting]]) -> list[list[MicrogeometryContact]]:
    """Contact of every helix; with a dynamic objective the operating load comes last, with its tangents."""
    dynamic = judge.system is not None
    loads = np.append(judge.factors, 1.0) if dynamic else judge.factors
    return [
        [
            microgeometry_contact(
                one.pieces, [one.shaped(setting) for setting in settings], one.force * loads, tangents=dynamic
            )
            for one in sides
        ]
        for sides in judge.meshes
    ]


def _swing(judge: Judge, mesh: int, sides: Sequence[MicrogeometryContact], loads: slice) -> Array:
    """Largest peak to peak over the loads, both helices together, (S,) [m]."""
    planes = [one.pieces.pair.plane for one in judge.meshes[mesh]]
    error = np.mean(
        [one.approach[:, loads] / math.cos(plane.base_helix) for one, plane in zip(sides, planes, strict=True)], axis=0
    )
    return np.asarray(np.ptp(error, axis=2).max(axis=1))


def histories(judge: Judge, settings: Mapping[str, Setting]) -> dict[str, ContactHistory]:
    """Contact of every mesh looked at, at the operating load, with what is set on the flanks."""
    return _histories(judge, _contacts(judge, [settings]), 0)


def _histories(judge: Judge, found: Sequence[Sequence[MicrogeometryContact]], i: int) -> dict[str, ContactHistory]:
    return {
        helix.mesh.name: ContactHistory(force=helix.force, approach=one.approach[i, -1], tangent=one.tangent[i, -1])
        for sides, own in zip(judge.meshes, found, strict=True)
        for helix, one in zip(sides, own, strict=True)
    }


def speed_curves(judge: Judge, histories: Mapping[str, ContactHistory]) -> dict[str, Array]:
    """Largest of the meshes looked at over the speeds, (P,) [N]: RMS and peak; nan where a speed failed."""
    assert judge.system is not None
    assert judge.speeds is not None
    system = with_contact_tangent(judge.train, judge.system, histories)
    result = sweep(system, relative_speed=judge.speeds)
    pairs = {helix.mesh.pair for sides in judge.meshes for helix in sides}
    mine = [mesh.name for mesh in judge.train.meshes if mesh.pair in pairs]
    kept = result.sel(mesh=mine)
    return {name: kept[DYNAMIC[name]].values.max(axis=0) for name in DYNAMIC}
