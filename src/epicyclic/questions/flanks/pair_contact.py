"""Loaded tooth contact of one pair of gears alone: transmission error, stiffness, load, stress over the mesh cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...engine.plan import require_memory
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.tooth_pairs import face_loads, first_mesh, mean_force, pair_of, tooth_warnings
from ...teeth.loaded_contact import LoadedContact, all_loaded, all_segments, first_images, harmonics
from ...teeth.path_of_contact import Array, cycle_harmonics, cycle_mean
from ...teeth.root_stress import RootStress
from ...train.deviations import check_contact_errors
from ...train.train import Mesh, Train
from ...warning_codes import CodedText, coded
from . import ContactOptions
from .contact_resolution import (
    LoadedFaces,
    PlacedErrors,
    Resolution,
    check_errors,
    contact_columns,
    contact_coords,
    cycle_weight,
    flank_map,
    insufficient,
    load_levels,
    placed_errors,
    resolution,
    sigma_at,
)

Columns = dict[str, tuple[Any, Array]]
Gears = tuple[RootStress, RootStress]

# mesh orders of the transmission error
_ORDERS = 10
# even places along the path of contact of a flank map and of a tooth root, beside those of the largest values
_PLACES = 161
# numbers of a strip of the face at a phase and a load: 3 or so contact lines with their influence on each other
_STRIP = 10


class PairContact(NamedTuple):
    """One mesh solved at F loads and T phases of its cycle, helix by helix.

    force : operating one of a helix [N].  levels : (F,) loads relative to it [1].  results : one a helix.
    placed : errors of its teeth, and the mesh cycle.
    """

    helices: Sequence[Mesh]
    force: float
    levels: Array
    cut: Resolution
    results: Sequence[LoadedContact]
    placed: PlacedErrors

    @property
    def name(self) -> str:
        """Name of the mesh."""
        return mesh_name(self.helices)

    @property
    def operating(self) -> int:
        """Index of the operating load."""
        return int(np.argmin(np.abs(self.levels - 1.0)))

    @property
    def error(self) -> Array:
        """Loaded transmission error, mean of the helices, (F, T) [m]."""
        return np.asarray(np.mean([result.transmission_error for result in self.results], axis=0))

    @property
    def faces(self) -> LoadedFaces:
        """Loads on the faces of the helices."""
        pairs = [result.segments.pair for result in self.results]
        return LoadedFaces(
            meshes=self.helices,
            pairs=pairs,
            images=first_images(pairs, [result.sigma for result in self.results]),
            levels=self.levels,
            loads=[
                [face for result in self.results for face in face_loads(result.segments, result.force[level])]
                for level in range(len(self.levels))
            ],
            weight=cycle_weight(self.cut.phase, 1.0),
            loaded=np.repeat((self.force * self.levels > 0)[:, None], len(pairs), axis=1),
        )


def solved_pair(
    train: Train,
    helices: Sequence[Mesh],
    options: ContactOptions,
    *,
    cut: Resolution | None = None,
    tangents: bool = True,
) -> PairContact:
    """Loaded tooth contact of one mesh over its mesh cycle.

    Every helix bears the same force, as in gears that are free to find their axial position.

    Parameters
    ----------
    cut : phases and slices as they are, in place of those of the options.
    tangents : compute the tangent stiffness; else it is nan.

    Raises
    ------
    ModelError : no torque, no face width, numbers out of range, and all that `pair_of` refuses.
    """
    force, levels = normal_force(train, helices, options.torque), load_levels(options, zero=True)
    samples, slices = options.samples, options.slices
    if (samples is not None and samples < 3) or (slices is not None and slices < 1):
        raise ModelError("not a number of samples or slices", path="samples, slices", given=(samples, slices))
    _require_room(samples or 1, slices or 1, levels.size)
    check_errors(options)
    lengths = {"pitch_error": options.pitch_error, "profile_error": options.profile_error}
    check_contact_errors(helices[0], train.bodies, misalignment=options.misalignment, errors=lengths)
    pairs = [
        pair_of(
            train,
            helix,
            linear_at=options.linear_at,
            corner=options.corner,
            misalignment=options.misalignment,
            torque_ends=(options.torque_end_a, options.torque_end_b),
        )
        for helix in helices
    ]
    placed = placed_errors(train, helices, pairs, force, options)
    if cut is None:
        cut = resolution(helices, placed.pairs, force, options, start=placed.start)
    _require_room(cut.phase.size, cut.slices, levels.size)
    pairs = [replace(pair, slices=cut.slices) for pair in placed.pairs]
    segments = all_segments(pairs, [sigma_at(helix, cut.phase, placed.start) for helix in helices])
    results = all_loaded(segments, force * levels, tangents=tangents)
    return PairContact(helices=helices, force=force, levels=levels, cut=cut, results=results, placed=placed)


def pair_contact(train: Train, options: ContactOptions, *, cut: Resolution | None = None) -> xr.Dataset:
    """Loaded tooth contact of one mesh alone, both helices, as a Dataset.

    Parameters
    ----------
    options : with a mesh, or the first that torque passes.  cut : as of `solved_pair`.

    Returns
    -------
    Dataset : beside what a train has too, loaded transmission error [m] (torque_factor, mesh_phase); stiffness [N/m]
        and pressure [Pa] (torque_factor, mesh, ...); at the operating load transmission error, share of the tooth
        pairs, load and pressure over the face (mesh, width, mesh_phase) and over the flank (mesh, width, flank_place).
        Loads per length and pressures are means over a length of contact line.  Attributes: mesh, force [N], samples,
        slices, tolerance, estimated_error (of peak to peak, load and pressure, largest; nan where both are given).

    Raises
    ------
    ModelError : no such mesh, and as of `solved_pair`.
    """
    solved = solved_pair(train, helices_of(train, options.mesh), options, cut=cut)
    faces, cut, helices, results = solved.faces, solved.cut, solved.helices, solved.results
    stresses = list(faces.root_stresses())
    of_roots, tooth_place = _root_maps(solved, stresses)
    of_flanks, flank_place = flank_columns(solved)
    levels = solved.force * solved.levels
    messages = [
        text
        for result, helix in zip(results, helices, strict=True)
        for text in tooth_warnings(result.segments.pair, helix)
    ]
    result = dataset(
        {
            **contact_columns(faces, stresses),
            **_load_columns(solved),
            **_phase_columns(solved),
            **of_flanks,
            **of_roots,
            "mesh_load": ("torque_factor", levels),
            "load_torque": ("torque_factor", levels * len(helices) * _lever(helices[0])),
        },
        coords={
            **contact_coords(faces),
            "mesh_phase": cut.phase,
            "flank_place": flank_place,
            "harmonic": np.arange(_ORDERS + 1),
            "end": ["before", "behind"],
            "tooth_place": tooth_place,
        },
        verb="contact",
        options={
            **options.common(),
            "misalignment": options.misalignment,
            "torque_ends": (options.torque_end_a, options.torque_end_b),
        },
        warnings=[
            *train.warnings,
            *dict.fromkeys(messages),
            *solved.placed.warnings,
            *_warnings(solved, options.corner),
            *unresolved(cut, options.tolerance),
        ],
        provenance=train_provenance(train),
    )
    result.attrs |= {
        "mesh": solved.name,
        "force": solved.force,
        "gear_a": helices[0].a.split("/")[1],
        "gear_b": helices[0].b.split("/")[1],
        "samples": cut.samples,
        "slices": cut.slices,
        "tolerance": options.tolerance,
        "estimated_error": float(cut.error.max()),
    }
    result.attrs |= solved.placed.attributes
    return result


def _require_room(samples: int, slices: int, loads: int) -> None:
    """Refuse what memory does not hold."""
    require_memory(
        float(samples) * slices * loads * _STRIP,
        path="samples, slices, loads",
        given=f"{samples} phases of {slices} slices at {loads} loads",
        allowed="fewer of one of them",
    )


def helices_of(train: Train, name: str | None) -> tuple[Mesh, ...]:
    """Helices of one mesh, left to right: by its name, with or without side, or by its pair in the first branch.

    None: the first mesh that torque passes.

    Raises
    ------
    ModelError : no such mesh.
    """
    wanted = first_mesh(train) if name is None else name.strip().strip("/")
    for matching in (
        [m for m in train.meshes if m.name == wanted],
        [m for m in train.meshes if m.side is not None and m.name == f"{wanted}/{m.side}"],
        [m for m in train.meshes if _pair_name(m) == wanted and m.branch in (None, 1)],
        [m for m in train.meshes if _pair_name(m).split("/")[-1] == wanted and m.branch in (None, 1)],
    ):
        if matching and len({m.pair for m in matching}) == 1:
            return tuple(sorted(matching, key=lambda m: m.station))
    raise ModelError("no such mesh", path="mesh", given=name, allowed=", ".join(m.name for m in train.meshes))


def _pair_name(mesh: Mesh) -> str:
    """``main/sun-planet``."""
    _, stage, _, pair = mesh.pair.split(".", 3)
    return f"{stage}/{pair}"


def normal_force(train: Train, helices: Sequence[Mesh], torque: float | None) -> float:
    """Force of one helix along the tooth normal [N], of a torque on the first gear [N m] or of the train.

    Raises
    ------
    ModelError : no torque passes this mesh.
    """
    if torque is None:
        force = mean_force(train, helices[0])
        if not force > 0:
            carrying = dict.fromkeys(_pair_name(mesh) for mesh in train.meshes if mean_force(train, mesh) > 0)
            others = f", or one of the meshes {', '.join(carrying)}" if carrying else ""
            raise ModelError(
                f"no torque passes the mesh {_pair_name(helices[0])}",
                path="operation.torque",
                allowed=f"a torque, here or there{others}",
            )
        return force
    return abs(torque) / (len(helices) * _lever(helices[0]))


def _lever(mesh: Mesh) -> float:
    """Torque on the first gear per normal force [m]: its base radius times the cosine of the base helix angle."""
    return mesh.radius_a * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix)


def _load_columns(solved: PairContact) -> Columns:
    """Variables over the load."""
    whole, cut = solved.error, solved.cut
    orders = cycle_harmonics(whole, cut.phase, _ORDERS) if cut.graded else harmonics(whole, _ORDERS)
    over = ("torque_factor", "mesh")

    def of_helices(values: Callable[[LoadedContact], Array]) -> Array:
        return np.stack([values(result) for result in solved.results], axis=1)

    return {
        "loaded_transmission_error": (("torque_factor", "mesh_phase"), whole),
        "transmission_error_peak_to_peak": ("torque_factor", np.ptp(whole, axis=1)),
        "transmission_error_harmonic": (("torque_factor", "harmonic"), orders),
        "tangent_stiffness": ((*over, "mesh_phase"), of_helices(lambda one: one.tangent)),
        "secant_stiffness": ((*over, "mesh_phase"), of_helices(lambda one: one.secant)),
        "average_stiffness": (over, of_helices(lambda one: cycle_mean(one.tangent, cut.phase))),
        "average_secant_stiffness": (over, of_helices(lambda one: cycle_mean(one.secant, cut.phase))),
        "largest_pressure": (over, of_helices(lambda one: one.largest_pressure)),
        "corner_overlap": ((*over, "end"), of_helices(lambda one: one.corner)),
        "contact_residual": ("torque_factor", of_helices(lambda one: one.residual.max(axis=1)).max(axis=1)),
    }


def _phase_columns(solved: PairContact) -> Columns:
    """Variables over the phase, at the operating load."""
    results, operating = solved.results, solved.operating
    error = np.array([result.transmission_error[operating] for result in results])
    most = max(result.force.shape[2] for result in results)
    share = np.zeros((len(results), most, error.shape[1]))
    for i, result in enumerate(results):
        share[i, : result.force.shape[2]] = result.share[operating].T
    return {
        "transmission_error": ("mesh_phase", error.mean(axis=0)),
        "no_load_transmission_error": ("mesh_phase", np.mean([result.no_load_error for result in results], axis=0)),
        "side_transmission_error": (("mesh", "mesh_phase"), error),
        "pair_share": (("mesh", "tooth_pair", "mesh_phase"), share),
    }


def flank_columns(solved: PairContact) -> tuple[Columns, Array]:
    """Variables over the face and the flank at the operating load, and places (P,) of the flank, 0 to 1."""
    now = solved.operating
    lines = [result.segments.lines for result in solved.results]
    load = [result.mean_load[now] for result in solved.results]
    pressure = [result.mean_pressure[now] for result in solved.results]
    touched = lines[0].sigma[lines[0].length > 0]
    place = _places([line.sigma for line in lines] * 2, [*load, *pressure], float(touched.min()), float(touched.max()))

    def maps(values: Sequence[Array]) -> Array:
        return np.array(
            [flank_map(line.sigma, value, line.length > 0, place) for line, value in zip(lines, values, strict=True)]
        )

    # contact lines of the first phase; nan where they leave the path
    first = np.array([np.where(line.length[0] > 0, line.sigma[0], np.nan) for line in lines])
    over_face, over_flank = ("mesh", "width", "mesh_phase"), ("mesh", "width", "flank_place")
    columns: Columns = {
        "load_per_length": (over_face, np.array([values.max(axis=1).T for values in load])),
        "contact_pressure": (over_face, np.array([values.max(axis=1).T for values in pressure])),
        "flank_load_per_length": (over_flank, maps(load)),
        "flank_pressure": (over_flank, maps(pressure)),
        "path_place": (("mesh", "flank_place"), np.tile(place, (len(lines), 1))),
        "line_place": (("mesh", "line", "width"), first),
    }
    return columns, (place - place[0]) / np.ptp(place)


def _places(at: Sequence[Array], values: Sequence[Array], low: float, high: float) -> Array:
    """Places (P,) of a curve or map [base pitches]: even ones from low to high, and those of the largest values.

    With them the largest value of a map is the largest of all phases.

    Parameters
    ----------
    values : that are drawn, each with its places `at` of the same shape [base pitches].
    """
    largest = [float(place.ravel()[np.argmax(value)]) for place, value in zip(at, values, strict=True)]
    return np.unique(np.concatenate([np.linspace(low, high, _PLACES), largest]))


def unresolved(cut: Resolution, tolerance: float) -> list[CodedText]:
    """Warning where phases and slices are not enough for the tolerance."""
    names = ("peak to peak of the transmission error", "largest load", "largest pressure")
    worst = int(np.argmax(cut.error))
    used = f"{cut.samples} phases and {cut.slices} slices are not enough"
    return insufficient([(float(cut.error[worst]), used, f" of the {names[worst]}")], tolerance)


def mesh_name(helices: Sequence[Mesh]) -> str:
    """Name of a mesh; of both helices without the side."""
    first = helices[0]
    return first.name if first.side is None or len(helices) == 1 else first.name.rsplit("/", 1)[0]


def _warnings(solved: PairContact, corner: bool) -> list[CodedText]:
    lost = sorted({str(text) for result in solved.results for text in result.status.ravel() if text})
    messages = [coded("contact-not-solved", f"contact: {text} at some phases") for text in lost]
    overlap = max(float(result.corner[solved.operating].max()) for result in solved.results)
    if overlap > 0 and not corner:
        text = (
            f"{solved.name}: a tip edge would bear on its mate beyond the path of contact at the operating load: they "
            f"overlap by {overlap * 1e6:.3g} µm; relieve the tips, or solve that corner contact "
            "too (option `corner`)"
        )
        messages.append(coded("corner-contact", text))
    return messages


# stress in the tooth roots --------------------------------------------------------------------------------------------


def _root_maps(solved: PairContact, stresses: Sequence[Gears]) -> tuple[Columns, Array]:
    """Stress in the tooth roots at the operating load, and places (P,) of a tooth [base pitches].

    root_stress_lean (mesh, mesh_gear) [rad]; root_stress, far_root_stress (mesh, mesh_gear, width, tooth_place) [Pa]
    over the face while the tooth moves along the path of contact.
    """
    now = solved.operating
    places = [result.sigma[:, None] - result.segments.lines.pair for result in solved.results]
    # largest tension and compression over the face, (T, J) of each gear [Pa]
    edges = [
        (place, values[now].max(axis=-1))
        for gears, place in zip(stresses, places, strict=True)
        for gear in gears
        for values in (gear.tension, -gear.compression)
    ]
    low, high = min(float(place.min()) for place in places), max(float(place.max()) for place in places)
    at = _places([place for place, _ in edges], [values for _, values in edges], low, high)

    def maps(values: Callable[[RootStress], Array]) -> Array:
        """Values of both gears of each mesh over the face at the places of one tooth, (mesh, gear, K, P)."""
        curves = []
        for gears, place in zip(stresses, places, strict=True):
            order = np.argsort(place, axis=None)
            faces = [values(gear)[now].reshape(place.size, -1)[order].T for gear in gears]
            curves.append([[np.interp(at, place.ravel()[order], row) for row in face] for face in faces])
        return np.array(curves)

    over = ("mesh", "mesh_gear")
    columns: Columns = {
        "root_stress_lean": (over, np.array([[gear.lean[now] for gear in gears] for gears in stresses])),
        "root_stress": ((*over, "width", "tooth_place"), maps(lambda gear: gear.tension)),
        "far_root_stress": ((*over, "width", "tooth_place"), maps(lambda gear: gear.compression)),
    }
    return columns, at
