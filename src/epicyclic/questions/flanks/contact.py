"""Loaded tooth contact of one mesh of a train: load distribution, transmission error, stiffness, stress in the roots.

Beside it the mesh stiffness that a train has without it, of every mesh over one mesh cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.units import stated
from ...engine.plan import MOST_NUMBERS, require_memory
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.tooth_pairs import End, FaceLoad, MeshFaceLaw, loaded_mesh, mean_force, pair_of, tooth_warnings
from ...teeth.loaded_contact import LoadedContact, all_loaded, all_segments, first_images, harmonics
from ...teeth.path_of_contact import averaging_length, cycle_harmonics, cycle_mean
from ...teeth.root_stress import RootStress, pair_influences, root_stress
from ...teeth.segments import ContactSegments, with_microgeometry
from ...train.deviations import check_contact_errors
from ...train.train import Mesh, Train
from ...warning_codes import CodedText, coded
from .contact_resolution import NO_ERRORS, Resolution, ToothErrors, placed_errors, resolution, sigma_at

Array = NDArray[np.float64]
Columns = dict[str, tuple[Any, Array]]

GEARS = ("a", "b")
"""Both gears of a mesh, first and second."""
FACTORS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Loads by default, relative to the operating one [1]."""
TOLERANCE = 0.01
"""Relative error by default: far below what models of teeth differ by."""
# mesh orders of the transmission error
_ORDERS = 10
# even places along the path of contact of a flank map and of a tooth root, beside those of the largest values
_PLACES = 161
# numbers of a strip of the face at a phase and a load: 3 or so contact lines with their influence on each other
_STRIP = 10


def contact(
    train: Train,
    *,
    mesh: str | None = None,
    torque: float | str | None = None,
    factors: Sequence[float] = FACTORS,
    samples: int | None = None,
    slices: int | None = None,
    tolerance: float = TOLERANCE,
    linear_at: float | None = None,
    corner: bool = False,
    misalignment: float | str = 0.0,
    torque_ends: tuple[str | None, str | None] = (None, None),
    errors: ToothErrors = NO_ERRORS,
    cut: Resolution | None = None,
    segments: Sequence[ContactSegments] | None = None,
    tangents: bool = True,
    roots: bool = True,
) -> xr.Dataset:
    """Loaded tooth contact of one mesh over its mesh cycle, both helices.

    Every helix bears the same force, as in gears that are free to find their axial position.

    Parameters
    ----------
    train : resolved train.
    mesh : name, ``main/sun-planet/2``, or pair, ``sun-planet``; None: the first mesh.
    torque : of the mesh on its first gear [N m], or a text with its unit; None: that of the train.
    factors : loads beside the operating one, relative to it [1].
    samples, slices : even phases of a mesh cycle, segments of each face; None: doubled until the numbers of the
        operating load hold within the tolerance, with the corners of contact among the phases.
    tolerance : relative, of the peak to peak of the transmission error, of largest load and largest pressure [1].
    linear_at : load per length [N/m] at which the contact of the flanks is linearised; None: Hertz.
    corner : solve corner contact, tips that bear beyond the path of contact.
    misalignment : of the flanks, in the plane of action [rad], or a text with its unit; positive opens the right end.
    torque_ends : end of the face, left or right, at which the torque leaves the first and the second gear, whose
        bodies then twist along the face; None: rigid.
    errors : pitch and profile errors, and which mesh cycle is analysed.
    cut : phases and slices as they are, in place of samples, slices and tolerance.
    segments : of every helix at these phases and slices, of a pair that differs in its micro-geometry alone; its
        compliance is taken over.
    tangents : compute the tangent stiffness; else it is nan.  roots : compute the stress in the tooth roots.

    Returns
    -------
    Dataset : loaded transmission error [m] (mesh_load, mesh_phase); stiffness [N/m], largest load per length [N/m] and
        pressure [Pa] (side, mesh_load, ...); at the operating load transmission error, share of the tooth pairs, load
        and pressure over the face (side, width, mesh_phase) and over the flank (side, width, path_place).  Loads per
        length and pressures are means over a length of contact line.  Stress in the tooth roots [Pa].
        Attributes: samples, slices, averaging_length [m], tolerance, estimated_error (of the three numbers, largest;
        nan where both are given).

    Raises
    ------
    ModelError : no such mesh, no torque, no face width, numbers out of range, and all that `pair_of` refuses.
    """
    helices = helices_of(train, mesh)
    force = normal_force(train, helices, torque)
    loads = force * np.array(sorted({1.0, *(float(f) for f in factors)}))
    few = (samples is not None and samples < 3) or (slices is not None and slices < 1)
    if few or not (np.isfinite(loads).all() and (loads >= 0).all()):
        raise ModelError("not a number of samples, slices or factors", path="contact", given=(samples, slices, factors))
    _require_room(samples or 1, slices or 1, loads.size)
    angle = stated(misalignment, "angle", "misalignment")
    lengths = {"pitch_error": errors.pitch, "profile_error": errors.profile}
    check_contact_errors(helices[0], train.bodies, misalignment=angle, errors=lengths)
    ends = _face_end(torque_ends[0]), _face_end(torque_ends[1])
    more: dict[str, Any] = {"linear_at": linear_at, "corner": corner, "misalignment": angle, "torque_ends": ends}
    pairs = [pair_of(train, helix, **more) for helix in helices]
    placed = placed_errors(train, helices, pairs, force, errors)
    pairs = list(placed.pairs)
    if cut is None:
        cut = resolution(helices, pairs, force, tolerance=tolerance, samples=samples, slices=slices, start=placed.start)
    _require_room(cut.phase.size, cut.slices, loads.size)
    pairs = [replace(pair, slices=cut.slices) for pair in pairs]
    if segments is None:
        segments = all_segments(pairs, [sigma_at(helix, cut.phase, placed.start) for helix in helices])
    else:
        segments = [with_microgeometry(drawn, pair) for drawn, pair in zip(segments, pairs, strict=True)]
    results = all_loaded(segments, loads, tangents=tangents)
    operating = int(np.argmin(np.abs(loads - force)))
    messages = [text for pair, helix in zip(pairs, helices, strict=True) for text in tooth_warnings(pair, helix)]
    place = _path_places(results, operating)
    root_columns, tooth_place = _root_columns(results, operating) if roots else ({}, None)
    name = mesh_name(helices)
    result = dataset(
        {
            **root_columns,
            **_load_columns(results, cut),
            **_phase_columns(results, operating),
            **_face_columns(results, operating, place),
            "load_torque": ("mesh_load", loads * len(helices) * _lever(helices[0])),
            "shared_face": ("side", np.array([pair.plane.width for pair in pairs])),
        },
        coords={
            "side": [helix.side or "face" for helix in helices],
            "mesh_load": loads,
            "mesh_phase": cut.phase,
            "width": (np.arange(cut.slices) + 0.5) / cut.slices,
            "path_place": place,
            "harmonic": np.arange(_ORDERS + 1),
            "end": ["before", "behind"],
            **({"mesh_gear": list(GEARS), "tooth_place": tooth_place} if roots else {}),
        },
        verb="contact",
        options={"samples": samples, "slices": slices, "tolerance": tolerance, **more, "torque_ends": torque_ends},
        warnings=[
            *train.warnings,
            *dict.fromkeys(messages),
            *placed.warnings,
            *_warnings(results, name, operating, corner),
            *unresolved(cut, tolerance),
        ],
        provenance=train_provenance(train),
    )
    result.attrs |= {
        "mesh": name,
        "force": force,
        "gear_a": helices[0].a.split("/")[1],
        "gear_b": helices[0].b.split("/")[1],
        "samples": cut.samples,
        "slices": cut.slices,
        "averaging_length": averaging_length(pairs[0].plane),
        "tolerance": tolerance,
        "estimated_error": float(cut.error.max()),
    }
    if errors != NO_ERRORS:
        result.attrs |= placed.attributes
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
    first = loaded_mesh(train)
    wanted = first.name if name is None else name.strip().strip("/")
    if name is None and first.side is not None:
        wanted = wanted.rsplit("/", 1)[0]
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


def normal_force(train: Train, helices: Sequence[Mesh], torque: float | str | None) -> float:
    """Force of one helix along the tooth normal [N], of a torque on the first gear [N m] or of the train.

    Raises
    ------
    ModelError : no torque passes this mesh; a text without a unit of torque.
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
    value = stated(torque, "torque", "torque")
    return abs(value) / (len(helices) * _lever(helices[0]))


def _lever(mesh: Mesh) -> float:
    """Torque on the first gear per normal force [m]: its base radius times the cosine of the base helix angle."""
    return mesh.radius_a * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix)


def _face_end(name: str | None) -> End | None:
    if name not in (None, "left", "right"):
        raise ModelError("no end of a face", path="torque_end", given=name, allowed="left or right")
    return cast(End | None, name)


def _load_columns(results: Sequence[LoadedContact], cut: Resolution) -> Columns:
    """Variables over side and load; results : one a helix."""
    whole = np.mean([result.transmission_error for result in results], axis=0)
    orders = cycle_harmonics(whole, cut.phase, _ORDERS) if cut.graded else harmonics(whole, _ORDERS)
    sided = ("side", "mesh_load")

    def of_helices(values: Callable[[LoadedContact], Array]) -> Array:
        return np.array([values(result) for result in results])

    return {
        "loaded_transmission_error": (("mesh_load", "mesh_phase"), whole),
        "transmission_error_peak_to_peak": ("mesh_load", np.ptp(whole, axis=1)),
        "transmission_error_harmonic": (("mesh_load", "harmonic"), orders),
        "tangent_stiffness": ((*sided, "mesh_phase"), of_helices(lambda one: one.tangent)),
        "secant_stiffness": ((*sided, "mesh_phase"), of_helices(lambda one: one.secant)),
        "average_stiffness": (sided, of_helices(lambda one: cycle_mean(one.tangent, cut.phase))),
        "average_secant_stiffness": (sided, of_helices(lambda one: cycle_mean(one.secant, cut.phase))),
        "largest_load_per_length": (sided, of_helices(lambda one: one.largest_load)),
        "largest_pressure": (sided, of_helices(lambda one: one.largest_pressure)),
        "face_factor": (sided, of_helices(lambda one: _face_factor(one, cut.phase))),
        "corner_overlap": ((*sided, "end"), of_helices(lambda one: one.corner)),
        "contact_residual": (sided, of_helices(lambda one: one.residual.max(axis=1))),
    }


def _face_factor(result: LoadedContact, phase: Array) -> Array:
    """Largest over mean load per width, loads averaged over the phases (T,), (F,) [1]; nan without load."""
    over = cycle_mean(np.moveaxis(result.force.sum(axis=2), 1, 2), phase)
    mean = over.mean(axis=1)
    return np.where(mean > 0, over.max(axis=1) / np.where(mean > 0, mean, 1.0), np.nan)


def _phase_columns(results: Sequence[LoadedContact], operating: int) -> Columns:
    """Variables over the phase; operating : index of the operating load."""
    error = np.array([result.transmission_error[operating] for result in results])
    most = max(result.force.shape[2] for result in results)
    share = np.zeros((len(results), most, error.shape[1]))
    for i, result in enumerate(results):
        share[i, : result.force.shape[2]] = result.share[operating].T
    return {
        "transmission_error": ("mesh_phase", error.mean(axis=0)),
        "no_load_transmission_error": ("mesh_phase", np.mean([result.no_load_error for result in results], axis=0)),
        "side_transmission_error": (("side", "mesh_phase"), error),
        "pair_share": (("side", "tooth_pair", "mesh_phase"), share),
    }


def _face_columns(results: Sequence[LoadedContact], operating: int, place: Array) -> Columns:
    """Variables over the face and the flank; operating : index of the operating load; place : (P,) [base pitches]."""
    lines = [result.segments.lines for result in results]
    load = [result.mean_load[operating] for result in results]
    pressure = [result.mean_pressure[operating] for result in results]

    def maps(values: Sequence[Array]) -> Array:
        return np.array(
            [flank_map(line.sigma, value, line.length > 0, place) for line, value in zip(lines, values, strict=True)]
        )

    # contact lines of the first phase; nan where they leave the path
    first = np.array([np.where(line.length[0] > 0, line.sigma[0], np.nan) for line in lines])
    over_face, over_flank = ("side", "width", "mesh_phase"), ("side", "width", "path_place")
    return {
        "load_per_length": (over_face, np.array([values.max(axis=1).T for values in load])),
        "contact_pressure": (over_face, np.array([values.max(axis=1).T for values in pressure])),
        "flank_load_per_length": (over_flank, maps(load)),
        "flank_pressure": (over_flank, maps(pressure)),
        "line_place": (("side", "line", "width"), first),
    }


def _path_places(results: Sequence[LoadedContact], operating: int) -> Array:
    """Places along the path of contact of a flank map, (P,) [base pitches]: even ones, and those of the largest values.

    With them the largest value of a map is the largest of all phases.
    """
    lines = results[0].segments.lines
    touched = lines.sigma[lines.length > 0]
    even = np.linspace(float(touched.min()), float(touched.max()), _PLACES)
    largest = [
        float(result.segments.lines.sigma.ravel()[np.argmax(values[operating])])
        for result in results
        for values in (result.mean_load, result.mean_pressure)
    ]
    return np.unique(np.concatenate([even, largest]))


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


def unresolved(cut: Resolution, tolerance: float) -> list[CodedText]:
    """Warning where phases and slices are not enough for the tolerance."""
    if not (cut.error > tolerance).any():
        return []
    names = ("peak to peak of the transmission error", "largest load", "largest pressure")
    worst = int(np.argmax(cut.error))
    return [
        coded(
            "resolution-insufficient",
            f"{cut.samples} phases and {cut.slices} slices are not enough: estimated error "
            f"{100 * cut.error[worst]:.2g} % of the {names[worst]}, asked {100 * tolerance:.2g} %",
        )
    ]


def mesh_name(helices: Sequence[Mesh]) -> str:
    """Name of a mesh; of both helices without the side."""
    first = helices[0]
    return first.name if first.side is None or len(helices) == 1 else first.name.rsplit("/", 1)[0]


def _warnings(results: Sequence[LoadedContact], mesh: str, operating: int, corner: bool) -> list[CodedText]:
    lost = sorted({str(text) for result in results for text in result.status.ravel() if text})
    messages = [coded("contact-not-solved", f"contact: {text} at some phases") for text in lost]
    overlap = max(float(result.corner[operating].max()) for result in results)
    if overlap > 0 and not corner:
        text = (
            f"{mesh}: a tip edge would bear on its mate beyond the path of contact at the operating load: they "
            f"overlap by {overlap * 1e6:.3g} µm; relieve the tips, or solve that corner contact "
            "too (option `corner`)"
        )
        messages.append(coded("corner-contact", text))
    return messages


# stress in the tooth roots --------------------------------------------------------------------------------------------


def _root_columns(results: Sequence[LoadedContact], operating: int) -> tuple[Columns, Array]:
    """Stress in the tooth roots of loaded contacts, one a helix, and the places (P,) of a tooth [base pitches].

    largest_root_stress, lowest_root_stress (side, mesh_gear, mesh_load) [Pa], root_stress_lean (side, mesh_gear) [rad],
    and at the load of index `operating` root_stress, far_root_stress (side, mesh_gear, width, tooth_place) [Pa] over
    the face while the tooth moves along the path of contact.
    """
    images = first_images([result.segments.pair for result in results], [result.sigma for result in results])
    stresses: list[tuple[RootStress, RootStress]] = []
    for result, first in zip(results, images, strict=True):
        if first < len(stresses):  # the mirror image of another helix, seen from the other end of the face
            a, b = (
                RootStress(tension=gear.tension[..., ::-1], compression=gear.compression[..., ::-1], lean=gear.lean)
                for gear in stresses[first]
            )
            stresses.append((a, b))
            continue
        pair = result.segments.pair
        stresses.append(root_stress(pair, result.segments.lines.sigma, result.force, pair_influences(pair)))
    places = [result.sigma[:, None] - result.segments.lines.pair for result in results]
    at = _tooth_places(stresses, places, operating)

    def of_gears(values: Callable[[RootStress], Array]) -> Array:
        return np.array([[values(gear) for gear in gears] for gears in stresses])

    def maps(values: Callable[[RootStress], Array]) -> Array:
        return np.array(
            [
                [_over_place(values(gear)[operating], place, at) for gear in gears]
                for gears, place in zip(stresses, places, strict=True)
            ]
        )

    sided = ("side", "mesh_gear")
    loaded, over = (*sided, "mesh_load"), (*sided, "width", "tooth_place")
    columns: Columns = {
        "largest_root_stress": (loaded, of_gears(lambda gear: gear.tension.max(axis=(1, 2, 3)))),
        "lowest_root_stress": (loaded, of_gears(lambda gear: gear.compression.min(axis=(1, 2, 3)))),
        "root_stress_lean": (sided, of_gears(lambda gear: gear.lean[operating])),
        "root_stress": (over, maps(lambda gear: gear.tension)),
        "far_root_stress": (over, maps(lambda gear: gear.compression)),
    }
    return columns, at


def largest_root_stresses(
    laws: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]]
) -> list[tuple[Array, Array]]:
    """Largest tension and compression in the tooth roots of the meshes of each law, (g, levels, 2) each [Pa].

    loads : at each level of load, by law.  Last axis: gears a and b.
    """
    stresses = []
    for number, law in enumerate(laws):
        levels = [level[number] for level in loads]
        T, g, J, K = levels[0].sigma.shape
        force = np.array([level.force.reshape(T * g, J, K) for level in levels])
        gears = root_stress(law.pair, levels[0].sigma.reshape(T * g, J, K), force, pair_influences(law.pair))
        shape = (len(levels), T, g, J * K)
        tension = [gear.tension.reshape(shape).max(axis=(1, 3)).T for gear in gears]
        compression = [gear.compression.reshape(shape).min(axis=(1, 3)).T for gear in gears]
        stresses.append((np.stack(tension, axis=-1), np.stack(compression, axis=-1)))
    return stresses


def _tooth_places(stresses: Sequence[Sequence[RootStress]], places: Sequence[Array], operating: int) -> Array:
    """Places (P,) of a tooth at mid-face [base pitches]: even ones, and those of the largest stresses.

    places : (T, J) of the teeth of each helix [base pitches].
    """
    even = np.linspace(min(place.min() for place in places), max(place.max() for place in places), _PLACES)
    largest = [
        place.ravel()[int(values.max(axis=-1).argmax())]
        for gears, place in zip(stresses, places, strict=True)
        for gear in gears
        for values in (gear.tension[operating], -gear.compression[operating])
    ]
    return np.unique(np.concatenate([even, largest]))


def _over_place(values: Array, place: Array, at: Array) -> Array:
    """Values (T, J, K) of teeth at places (T, J) of those, at places (P,) of one tooth, (K, P), in their unit."""
    order = np.argsort(place, axis=None)
    flat = values.reshape(-1, values.shape[-1])[order]
    return np.array([np.interp(at, place.ravel()[order], column) for column in flat.T])


# mesh stiffness without contact ---------------------------------------------------------------------------------------


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
