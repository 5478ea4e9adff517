"""Stress in the tooth roots as variables of the results of tooth contact.

Loaded tooth contact of one mesh of a train: load distribution, transmission error, mesh stiffness.

Mesh stiffness of every mesh over one mesh cycle.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.written_numbers import stated
from ...engine.cost import MOST_NUMBERS, require_memory
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.face_contact import FaceLoad, MeshFaceLaw
from ...system.tooth_pairs import End, loaded_mesh, mean_force, pair_of, tooth_warnings
from ...teeth.contact_lines import averaging_length, cycle_harmonics, cycle_mean
from ...teeth.loaded_contact import LoadedContact, all_loaded, all_segments, first_images, harmonics
from ...teeth.root_stress import RootStress, pair_influences, root_stress
from ...teeth.segments import ContactSegments, with_microgeometry
from ...train.bodies import Mesh
from ...train.tolerances import check_contact_errors
from ...train.train import Train
from ...warning_codes import CodedText, coded
from .contact_resolution import NO_ERRORS, Resolution, ToothErrors, placed_errors, resolution, sigma_at

Array = NDArray[np.float64]

GEARS = ("a", "b")
"""Both gears of a mesh, first and second."""
# Even places of a tooth along the path of contact, beside those of the largest stresses.
_ROOT_PLACES = 161


@dataclass(frozen=True, slots=True, kw_only=True)
class RootColumns:
    """Variables and coordinates of a Dataset."""

    variables: dict[str, tuple[Any, Array]] = field(default_factory=dict)
    coords: dict[Hashable, Any] = field(default_factory=dict)


def root_columns(results: Sequence[LoadedContact], operating: int) -> RootColumns:
    """Stress in the tooth roots of loaded contacts, one a helix.

    largest_root_stress, lowest_root_stress (side, mesh_gear, mesh_load) [Pa], root_stress_lean (side, mesh_gear) [rad],
    and at the load of index `operating` root_stress, far_root_stress (side, mesh_gear, width, tooth_place) [Pa] over
    the face while the tooth moves along the path of contact.
    """
    images = first_images([one.segments.pair for one in results], [one.sigma for one in results])
    found: list[tuple[RootStress, RootStress]] = []
    for one, first in zip(results, images, strict=True):
        if first < len(found):
            mirrored = [_mirrored(gear) for gear in found[first]]
            found.append((mirrored[0], mirrored[1]))
            continue
        pair = one.segments.pair
        found.append(root_stress(pair, one.segments.lines.sigma, one.force, pair_influences(pair)))
    places = [one.sigma[:, None] - one.segments.lines.pair for one in results]
    at = _tooth_places(found, places, operating)
    sided = ("side", "mesh_gear")
    over = (*sided, "width", "tooth_place")

    def maps(name: str) -> Array:
        return np.array(
            [
                [_over_place(getattr(gear, name)[operating], place, at) for gear in gears]
                for gears, place in zip(found, places, strict=True)
            ]
        )

    return RootColumns(
        variables={
            "largest_root_stress": (
                (*sided, "mesh_load"),
                np.array([[gear.tension.max(axis=(1, 2, 3)) for gear in gears] for gears in found]),
            ),
            "lowest_root_stress": (
                (*sided, "mesh_load"),
                np.array([[gear.compression.min(axis=(1, 2, 3)) for gear in gears] for gears in found]),
            ),
            "root_stress_lean": (sided, np.array([[gear.lean[operating] for gear in gears] for gears in found])),
            "root_stress": (over, maps("tension")),
            "far_root_stress": (over, maps("compression")),
        },
        coords={"mesh_gear": list(GEARS), "tooth_place": at},
    )


def largest_root_stresses(
    laws: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]]
) -> list[tuple[Array, Array]]:
    """Largest tension and compression in the tooth roots of the meshes of each law, (g, levels, 2) each [Pa].

    loads : at each level of load, by law.  Last axis: gears a and b.
    """
    found = []
    for number, law in enumerate(laws):
        at = [one[number] for one in loads]
        T, g, J, K = at[0].sigma.shape
        force = np.array([one.force.reshape(T * g, J, K) for one in at])
        gears = root_stress(law.pair, at[0].sigma.reshape(T * g, J, K), force, pair_influences(law.pair))
        shape = (len(at), T, g, J * K)
        tension = [gear.tension.reshape(shape).max(axis=(1, 3)).T for gear in gears]
        compression = [gear.compression.reshape(shape).min(axis=(1, 3)).T for gear in gears]
        found.append((np.stack(tension, axis=-1), np.stack(compression, axis=-1)))
    return found


def _mirrored(stress: RootStress) -> RootStress:
    """Stress of the mirror image of a helix, from the other end of the face."""
    return RootStress(tension=stress.tension[..., ::-1], compression=stress.compression[..., ::-1], lean=stress.lean)


def _tooth_places(found: Sequence[Sequence[RootStress]], places: Sequence[Array], operating: int) -> Array:
    """Places (P,) of a tooth at mid-face [base pitches]: even ones, and those of the largest stresses.

    places : (T, J) of the teeth of each helix [base pitches].
    """
    even = np.linspace(min(one.min() for one in places), max(one.max() for one in places), _ROOT_PLACES)
    largest = [
        place.ravel()[int(values.max(axis=-1).argmax())]
        for gears, place in zip(found, places, strict=True)
        for gear in gears
        for values in (gear.tension[operating], -gear.compression[operating])
    ]
    return np.unique(np.concatenate([even, largest]))


def _over_place(values: Array, place: Array, at: Array) -> Array:
    """Values (T, J, K) of teeth at places (T, J) of those, at places (P,) of one tooth, (K, P), in their unit."""
    order = np.argsort(place, axis=None)
    flat = values.reshape(-1, values.shape[-1])[order]
    return np.array([np.interp(at, place.ravel()[order], column) for column in flat.T])


ComplexArray = NDArray[np.complex128]

FACTORS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Loads by default, relative to the operating one [1]."""
TOLERANCE = 0.01
"""Relative error by default: far below what models of teeth differ by."""
# mesh orders of the transmission error, and places along the path of contact of a flank map
_ORDERS, _PLACES = 10, 161
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
        length and pressures are means over a length of contact line.  Stress in the tooth roots [Pa] (`root_columns`).
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
    angle = in_radians(misalignment)
    lengths = {"pitch_error": errors.pitch, "profile_error": errors.profile}
    check_contact_errors(helices[0], train.bodies, misalignment=angle, errors=lengths)
    ends = _face_end(torque_ends[0]), _face_end(torque_ends[1])
    more: dict[str, Any] = {"linear_at": linear_at, "corner": corner, "misalignment": angle, "torque_ends": ends}
    pairs = [pair_of(train, one, **more) for one in helices]
    placed = placed_errors(train, helices, pairs, force, errors)
    pairs = list(placed.pairs)
    if cut is None:
        cut = resolution(helices, pairs, force, tolerance=tolerance, samples=samples, slices=slices, start=placed.start)
    _require_room(cut.phase.size, cut.slices, loads.size)
    pairs = [replace(pair, slices=cut.slices) for pair in pairs]
    if segments is None:
        segments = all_segments(pairs, [sigma_at(one, cut.phase, placed.start) for one in helices])
    else:
        segments = [with_microgeometry(one, pair) for one, pair in zip(segments, pairs, strict=True)]
    results = all_loaded(segments, loads, tangents=tangents)
    operating = int(np.argmin(np.abs(loads - force)))
    messages = [text for pair, one in zip(pairs, helices, strict=True) for text in tooth_warnings(pair, one)]
    place = _path_places(results, operating)
    stresses = root_columns(results, operating) if roots else RootColumns()
    result = dataset(
        {
            **stresses.variables,
            **_load_columns(results, cut),
            **_phase_columns(results, operating),
            **_face_columns(results, operating, place),
            **_mesh_columns(helices, results, loads),
        },
        coords={
            "side": [one.side or "face" for one in helices],
            "mesh_load": loads,
            "mesh_phase": cut.phase,
            "width": (np.arange(cut.slices) + 0.5) / cut.slices,
            "path_place": place,
            "harmonic": np.arange(_ORDERS + 1),
            "end": ["before", "behind"],
            **stresses.coords,
        },
        verb="contact",
        options={"samples": samples, "slices": slices, "tolerance": tolerance, **more, "torque_ends": torque_ends},
        warnings=[
            *train.warnings,
            *dict.fromkeys(messages),
            *placed.warnings,
            *_warnings(results, _mesh_name(helices), operating, corner),
            *unresolved(cut, tolerance),
        ],
        provenance=train_provenance(train),
    )
    gears = (body.split("/")[1] for body in (helices[0].a, helices[0].b))
    result.attrs |= {"mesh": _mesh_name(helices), "force": force, **dict(zip(("gear_a", "gear_b"), gears, strict=True))}
    result.attrs |= {
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


def in_radians(angle: float | str) -> float:
    """Angle [rad] from a number [rad], or a text with its unit.

    Raises
    ------
    ModelError : a text without a unit of angle.
    """
    return stated(angle, "angle", "misalignment")


def _face_end(name: str | None) -> End | None:
    if name is None:
        return None
    if name not in ("left", "right"):
        raise ModelError("no end of a face", path="torque_end", given=name, allowed="left or right")
    return "left" if name == "left" else "right"


def _load_columns(results: Sequence[LoadedContact], cut: Resolution) -> dict[str, tuple[Any, Array]]:
    """Variables over side and load; results : one a helix."""
    orders = cycle_harmonics if cut.graded else _even_harmonics

    def average(values: Array) -> Array:
        return cycle_mean(values, cut.phase)

    whole = np.mean([one.transmission_error for one in results], axis=0)
    sided = ("side", "mesh_load")
    return {
        "loaded_transmission_error": (("mesh_load", "mesh_phase"), whole),
        "transmission_error_peak_to_peak": ("mesh_load", np.ptp(whole, axis=1)),
        "transmission_error_harmonic": (("mesh_load", "harmonic"), orders(whole, cut.phase, _ORDERS)),
        "tangent_stiffness": ((*sided, "mesh_phase"), np.array([one.tangent for one in results])),
        "secant_stiffness": ((*sided, "mesh_phase"), np.array([one.secant for one in results])),
        "average_stiffness": (sided, np.array([average(one.tangent) for one in results])),
        "average_secant_stiffness": (sided, np.array([average(one.secant) for one in results])),
        "largest_load_per_length": (sided, np.array([one.largest_load for one in results])),
        "largest_pressure": (sided, np.array([one.largest_pressure for one in results])),
        "face_factor": (sided, np.array([_face_factor(one, cut.phase) for one in results])),
        "corner_overlap": ((*sided, "end"), np.array([one.corner for one in results])),
        "contact_residual": (sided, np.array([one.residual.max(axis=1) for one in results])),
    }


def _even_harmonics(values: Array, phase: Array, count: int) -> ComplexArray:
    return harmonics(values, count)


def _face_factor(result: LoadedContact, phase: Array) -> Array:
    """Largest over mean load per width, loads averaged over the phases (T,), (F,) [1]; nan without load."""
    over = cycle_mean(np.moveaxis(result.force.sum(axis=2), 1, 2), phase)
    mean = over.mean(axis=1)
    return np.where(mean > 0, over.max(axis=1) / np.where(mean > 0, mean, 1.0), np.nan)


def _phase_columns(results: Sequence[LoadedContact], operating: int) -> dict[str, tuple[Any, Array]]:
    """Variables over the phase; operating : index of the operating load."""
    sided = np.array([one.transmission_error[operating] for one in results])
    most = max(one.force.shape[2] for one in results)
    share = np.zeros((len(results), most, sided.shape[1]))
    for i, one in enumerate(results):
        share[i, : one.force.shape[2]] = one.share[operating].T
    return {
        "transmission_error": ("mesh_phase", sided.mean(axis=0)),
        "no_load_transmission_error": ("mesh_phase", np.mean([one.no_load_error for one in results], axis=0)),
        "side_transmission_error": (("side", "mesh_phase"), sided),
        "pair_share": (("side", "tooth_pair", "mesh_phase"), share),
    }


def _face_columns(results: Sequence[LoadedContact], operating: int, place: Array) -> dict[str, tuple[Any, Array]]:
    """Variables over the face and the flank; operating : index of the operating load; place : (P,) [base pitches]."""
    load = [one.mean_load[operating] for one in results]
    stress = [one.mean_pressure[operating] for one in results]
    sided = ("side", "width", "mesh_phase")

    def maps(values: Sequence[Array]) -> Array:
        """Values of every helix on the flank of one tooth, (side, width, path_place)."""
        lines = [one.segments.lines for one in results]
        return np.array([flank_map(one.sigma, p, one.length > 0, place) for one, p in zip(lines, values, strict=True)])

    return {
        "load_per_length": (sided, np.array([p.max(axis=1).T for p in load])),
        "contact_pressure": (sided, np.array([p.max(axis=1).T for p in stress])),
        "flank_load_per_length": (("side", "width", "path_place"), maps(load)),
        "flank_pressure": (("side", "width", "path_place"), maps(stress)),
        "line_place": (("side", "line", "width"), np.array([_first_lines(one) for one in results])),
    }


def _path_places(results: Sequence[LoadedContact], operating: int) -> Array:
    """Places along the path of contact of a flank map, (P,) [base pitches]: even ones, and those of the largest values.

    With them the largest value of a map is the largest of all phases.
    """
    lines = results[0].segments.lines
    touched = lines.sigma[lines.length > 0]
    even = np.linspace(float(touched.min()), float(touched.max()), _PLACES)
    largest = [
        float(one.segments.lines.sigma.ravel()[np.argmax(values[operating])])
        for one in results
        for values in (one.mean_load, one.mean_pressure)
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


def _first_lines(result: LoadedContact) -> Array:
    """Contact lines of the first phase, (J, K) [base pitches]; nan where they leave the path."""
    lines = result.segments.lines
    return np.where(lines.length[0] > 0, lines.sigma[0], np.nan)


def _mesh_columns(
    helices: Sequence[Mesh], results: Sequence[LoadedContact], loads: Array
) -> dict[str, tuple[Any, Array]]:
    """Torque on the first gear [N m] at each load (F,) [N], and face width [m] of each side."""
    return {
        "load_torque": ("mesh_load", loads * len(helices) * _lever(helices[0])),
        "shared_face": ("side", np.array([result.segments.pair.plane.width for result in results])),
    }


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


def _mesh_name(helices: Sequence[Mesh]) -> str:
    """Name of a mesh; of both helices without the side."""
    first = helices[0]
    return first.name if first.side is None or len(helices) == 1 else first.name.rsplit("/", 1)[0]


def _warnings(results: Sequence[LoadedContact], mesh: str, operating: int, corner: bool) -> list[CodedText]:
    lost = sorted({str(text) for one in results for text in one.status.ravel() if text})
    messages = [coded("contact-not-solved", f"contact: {text} at some phases") for text in lost]
    overlap = max(float(one.corner[operating].max()) for one in results)
    if overlap > 0 and not corner:
        messages.append(
            coded(
                "corner-contact",
                f"{mesh}: a tip edge would bear on its mate beyond the path of contact at the operating load: they "
                f"overlap by {overlap * 1e6:.3g} µm; relieve the tips, or solve that corner contact "
                "too (option `corner`)",
            )
        )
    return messages


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
