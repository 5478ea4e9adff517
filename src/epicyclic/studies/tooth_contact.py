"""Loaded tooth contact of one mesh of a train: what carries the load where, transmission error, stiffness."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..assemble.tooth_pairs import End, mean_force, pair_of, tooth_warnings
from ..errors import ModelError
from ..results.dataset import dataset
from ..tooth_contact.loaded_contact import LoadedContact, harmonics, loaded_contact
from ..train.connections import Mesh
from ..train.train import Train
from .check import train_provenance

__all__ = ["contact", "helices_of", "in_radians", "normal_force"]

Array = NDArray[np.float64]

FACTORS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
_ORDERS, _PLACES = 10, 161


def contact(
    train: Train,
    *,
    mesh: str | None = None,
    torque: float | str | None = None,
    factors: Sequence[float] = FACTORS,
    samples: int = 64,
    slices: int = 20,
    linear_at: float | None = None,
    corner: bool = False,
    misalignment: float | str = 0.0,
    torque_ends: tuple[str | None, str | None] = (None, None),
) -> xr.Dataset:
    """Loaded tooth contact over a mesh cycle, both helices.

    Every helix of the mesh bears the same force, as gears do that find their place along the axis by themselves.

    Parameters
    ----------
    train : the resolved train.  mesh : its name, ``main/sun-planet/2``, or its pair, ``sun-planet``; the first of all.
    torque : that the mesh puts on its first gear [N m], or a text with its unit; None: that of the train.
    factors : loads beside the operating one, relative to it.  samples : phases of a mesh cycle.
    slices : pieces of each face.  linear_at : load per length [N/m] at which the contact of the flanks is made linear;
        None: Hertz.  corner : let tips bear beyond the path of contact.
    misalignment : of the flanks, in the plane of action [rad], or a text with its unit; positive opens the right end.
    torque_ends : end of the face, left or right, at which the torque leaves the first and the second gear; their
        bodies then twist along the face.

    Raises
    ------
    ModelError : no such mesh, no torque, no face width, and all that `epicyclic.assemble.tooth_pairs.pair_of` refuses.
    """
    sides = helices_of(train, mesh)
    force = normal_force(train, sides, torque)
    loads = force * np.array(sorted({1.0, *(float(f) for f in factors)}))
    if samples < 3 or slices < 1 or not (np.isfinite(loads).all() and (loads >= 0).all()):
        raise ModelError("not a number of samples, slices or factors", path="contact", given=(samples, slices, factors))
    phase = np.arange(samples) / samples
    turn = in_radians(misalignment)
    ends = _end(torque_ends[0]), _end(torque_ends[1])
    how = {"slices": slices, "corner": corner, "misalignment": turn}
    pairs = [
        pair_of(
            train,
            one,
            slices=slices,
            linear_at=linear_at,
            corner=corner,
            misalignment=turn,
            torque_ends=ends,
        )
        for one in sides
    ]
    found = [
        loaded_contact(pair, loads, one.sense * (phase + float(one.lead)))
        for pair, one in zip(pairs, sides, strict=True)
    ]
    now = int(np.argmin(np.abs(loads - force)))
    messages = [text for pair in pairs for text in tooth_warnings(pair)]
    result = dataset(
        {**_over_loads(found), **_curves(found, now), **_over_faces(found, now), **_facts(sides, found, loads)},
        coords={
            "side": [one.side or "face" for one in sides],
            "mesh_load": loads,
            "mesh_phase": phase,
            "width": (np.arange(slices) + 0.5) / slices,
            "path_place": _places(found),
            "harmonic": np.arange(_ORDERS + 1),
            "end": ["before", "behind"],
        },
        verb="contact",
        options={"samples": samples, "linear_at": linear_at, "torque_ends": torque_ends, **how},
        warnings=[*train.warnings, *dict.fromkeys(messages), *_warnings(found, now, corner)],
        provenance=train_provenance(train),
    )
    name = sides[0].name if sides[0].side is None or len(sides) == 1 else sides[0].name.rsplit("/", 1)[0]
    gears = (body.split("/")[1] for body in (sides[0].a, sides[0].b))
    result.attrs |= {"mesh": name, "force": force, **dict(zip(("gear_a", "gear_b"), gears, strict=True))}
    return result


def helices_of(train: Train, name: str | None) -> tuple[Mesh, ...]:
    """The helices of one mesh, left to right: by its name, with or without side, or by its pair in the first branch.

    Raises
    ------
    ModelError : no such mesh.
    """
    wanted = train.meshes[0].name if name is None else name.strip().strip("/")
    if name is None and train.meshes[0].side is not None:
        wanted = wanted.rsplit("/", 1)[0]
    for tries in (
        [m for m in train.meshes if m.name == wanted],
        [m for m in train.meshes if m.side is not None and m.name == f"{wanted}/{m.side}"],
        [m for m in train.meshes if _pair_name(m) == wanted and m.branch in (None, 1)],
        [m for m in train.meshes if _pair_name(m).split("/")[-1] == wanted and m.branch in (None, 1)],
    ):
        if tries and len({m.pair for m in tries}) == 1:
            return tuple(sorted(tries, key=lambda m: m.station))
    raise ModelError("no such mesh", path="mesh", given=name, allowed=", ".join(m.name for m in train.meshes))


def _pair_name(mesh: Mesh) -> str:
    _, stage, _, pair = mesh.pair.split(".", 3)
    return f"{stage}/{pair}"


def normal_force(train: Train, sides: Sequence[Mesh], torque: float | str | None) -> float:
    """Force of one helix [N]."""
    if torque is None:
        force = mean_force(train, sides[0])
        if not force > 0:
            raise ModelError(
                "no torque passes this mesh", path="operation.torque", given=force, allowed="a torque, here or there"
            )
        return force
    value = _newton_metres(torque)
    one = sides[0]
    lever = one.radius_a * math.cos(one.pressure_angle) * math.cos(one.base_helix)
    return abs(value) / (len(sides) * lever)


def _newton_metres(torque: float | str) -> float:
    return _in_si(torque, "torque", "torque", "850 N m")


def in_radians(angle: float | str) -> float:
    return _in_si(angle, "angle", "misalignment", "0.1 mrad")


def _in_si(given: float | str, kind: str, option: str, example: str) -> float:
    """A number in SI; a text must say its unit."""
    if not isinstance(given, str):
        return float(given)
    from ..model.units import Bounds, read_quantity

    if not re.search(r"[A-Za-z]", given):
        raise ModelError(f'needs a number and its unit, e.g. "{example}"', path=option, given=given)
    try:
        value = read_quantity(given, (kind,), Bounds())
    except ModelError as error:
        raise ModelError(str(error), path=option) from None
    assert isinstance(value, float)
    return value


def _end(name: str | None) -> End | None:
    if name is None:
        return None
    if name not in ("left", "right"):
        raise ModelError("no end of a face", path="torque_end", given=name, allowed="left or right")
    return "left" if name == "left" else "right"


def _over_loads(found: Sequence[LoadedContact]) -> dict[str, tuple[Any, Array]]:
    """Variables over side and load."""
    whole = np.mean([one.transmission_error for one in found], axis=0)
    sided = ("side", "mesh_load")
    return {
        "loaded_transmission_error": (("mesh_load", "mesh_phase"), whole),
        "transmission_error_peak_to_peak": ("mesh_load", np.ptp(whole, axis=1)),
        "transmission_error_harmonic": (("mesh_load", "harmonic"), harmonics(whole, _ORDERS)),
        "tangent_stiffness": ((*sided, "mesh_phase"), np.array([one.tangent for one in found])),
        "secant_stiffness": ((*sided, "mesh_phase"), np.array([one.secant for one in found])),
        "average_stiffness": (sided, np.array([one.mean_stiffness for one in found])),
        "average_secant_stiffness": (sided, np.array([one.secant.mean(axis=1) for one in found])),
        "largest_load_per_length": (sided, np.array([one.largest_load for one in found])),
        "largest_pressure": (sided, np.array([one.largest_pressure for one in found])),
        "face_factor": (sided, np.array([_face_factor(one) for one in found])),
        "corner_overlap": ((*sided, "end"), np.array([one.corner for one in found])),
        "contact_residual": (sided, np.array([one.residual.max(axis=1) for one in found])),
    }


def _face_factor(one: LoadedContact) -> Array:
    """Largest over mean load per width, loads averaged over the phases, (F,); nan without load."""
    over = one.force.sum(axis=2).mean(axis=1)
    mean = over.mean(axis=1)
    return np.where(mean > 0, over.max(axis=1) / np.where(mean > 0, mean, 1.0), np.nan)


def _curves(found: Sequence[LoadedContact], now: int) -> dict[str, tuple[Any, Array]]:
    """Variables over the phase, at the operating load."""
    sided = np.array([one.transmission_error[now] for one in found])
    most = max(one.force.shape[2] for one in found)
    share = np.zeros((len(found), most, sided.shape[1]))
    for i, one in enumerate(found):
        share[i, : one.force.shape[2]] = one.share[now].T
    return {
        "transmission_error": ("mesh_phase", sided.mean(axis=0)),
        "no_load_transmission_error": ("mesh_phase", np.mean([one.no_load_error for one in found], axis=0)),
        "side_transmission_error": (("side", "mesh_phase"), sided),
        "pair_share": (("side", "tooth_pair", "mesh_phase"), share),
    }


def _over_faces(found: Sequence[LoadedContact], now: int) -> dict[str, tuple[Any, Array]]:
    """Variables over the face, at the operating load."""
    load = [np.where(one.whole, one.load_per_length()[now], 0.0) for one in found]
    stress = [np.where(one.whole, one.pressure()[now], 0.0) for one in found]
    place = _places(found)
    sided = ("side", "width", "mesh_phase")
    return {
        "load_per_length": (sided, np.array([p.max(axis=1).T for p in load])),
        "contact_pressure": (sided, np.array([p.max(axis=1).T for p in stress])),
        "flank_load_per_length": (
            ("side", "width", "path_place"),
            np.array([_on_flank(one, p, place) for one, p in zip(found, load, strict=True)]),
        ),
        "flank_pressure": (
            ("side", "width", "path_place"),
            np.array([_on_flank(one, p, place) for one, p in zip(found, stress, strict=True)]),
        ),
        "line_place": (("side", "line", "width"), np.array([_first_lines(one) for one in found])),
    }


def _places(found: Sequence[LoadedContact]) -> Array:
    """Places along the path of contact on which flanks are shown, (places,) [base pitches]."""
    lines = found[0].segments.lines
    touched = lines.sigma[lines.length > 0]
    return np.linspace(float(touched.min()), float(touched.max()), _PLACES)


def _on_flank(one: LoadedContact, values: Array, place: Array) -> Array:
    """Values (T, J, K) of all phases, laid on the flank of one tooth, (K, places); nan where nothing touches."""
    lines = one.segments.lines
    flank = np.full((lines.length.shape[2], len(place)), np.nan)
    for k in range(len(flank)):
        touched = one.whole[:, :, k]
        at, value = lines.sigma[:, :, k][touched], values[:, :, k][touched]
        order = np.argsort(at)
        flank[k] = np.interp(place, at[order], value[order], left=np.nan, right=np.nan)
    return flank


def _first_lines(one: LoadedContact) -> Array:
    """Contact lines of the first phase, (lines, K) [base pitches]; nan where they leave the path."""
    lines = one.segments.lines
    return np.where(lines.length[0] > 0, lines.sigma[0], np.nan)


def _facts(sides: Sequence[Mesh], found: Sequence[LoadedContact], loads: Array) -> dict[str, tuple[Any, Array]]:
    one = sides[0]
    lever = one.radius_a * math.cos(one.pressure_angle) * math.cos(one.base_helix)
    return {
        "load_torque": ("mesh_load", loads * len(sides) * lever),
        "shared_face": ("side", np.array([result.segments.pair.plane.width for result in found])),
    }


def _warnings(found: Sequence[LoadedContact], now: int, corner: bool) -> list[str]:
    lost = sorted({str(text) for one in found for text in one.status.ravel() if text})
    said = [f"contact: {text} at some phases" for text in lost]
    overlap = max(float(one.corner[now].max()) for one in found)
    if overlap > 0 and not corner:
        said.append(
            f"tips would bear outside the path of contact at the operating load: they overlap by "
            f"{overlap * 1e6:.3g} um; relieve them, or let them bear (corner)"
        )
    return said
