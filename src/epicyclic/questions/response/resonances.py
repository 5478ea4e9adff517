"""Table of resonances: where mesh orders meet the modes about operation, where the energy sits, the force there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...results.ties import first_largest, largest
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, System, faces
from ..modes.campbell import MESH_ORDERS, OPERATION, MeshCrossings, mesh_crossings, tones_of_meshes

if TYPE_CHECKING:
    import xarray as xr

# A mode with less than a hundredth of the amplitude of an order, at its own frequency, is not excited by it: what moves
# is the other modes.
_EXCITED = 1e-4
# Resonances this close to operation are marked: half-power widths are 2 zeta, at most a tenth for usual damping, and
# natural frequencies of a drawing are known to some 10 %.
BAND = 0.2
_SIDES = ("left", "right")


_Forces = dict[str, NDArray[Any]]
"""Forces (c,) at the crossings from the sweep with linear contact; nan and "" where not computed.

dynamic_factor : largest of any mesh [1], mesh : which.  amplitude : largest amplitude of the order that meets the mode,
of the meshes that have its mesh frequency [N].  own_force : of that the amplitude that the mode itself makes [N],
share : energy of the mode per energy of the motion at that order [1].
"""


def with_resonances(
    result: xr.Dataset, system: System, *, band: float | None = None, hertz: tuple[float, float] | None = None
) -> xr.Dataset:
    """A result of `modal` with its resonances: speeds f_n / (h f_m) per operating speed, rising.

    Derived here.  Without a speed the result is returned as it is.

    Parameters
    ----------
    result : frequencies, kinds and energy shares of the modes; repeated modes are one resonance, with the mean of their
        shares, which no choice of their basis changes.
    system : gives mesh frequencies, and the forces where it has torque and damping.
    band : resonances at most this share [1] from the operating speed alone, but from 5 % up; None: 5 to 130 %, those
        within 20 % marked.  hertz : least and largest natural frequency [Hz].

    Returns
    -------
    Dataset with variables ``resonance_*`` over the dimension ``resonance``; docs/theory/modes.md defines each.

    Raises
    ------
    ModelError : a band that is not above zero.
    """
    from ...results.variables import VARIABLES

    if band is not None and not (np.isfinite(band) and band > 0):
        raise ModelError("not a share of the operating speed", path="band", given=band, allowed='above 0, e.g. "20 %"')
    tones = tones_of_meshes(system)
    if not tones:
        return result
    frequency = np.asarray(result["frequency"].values, dtype=float)
    low, high = OPERATION if band is None else (max(1 - band, OPERATION[0]), 1 + band)
    crossings = mesh_crossings(frequency, [float(tone) for tone in tones], low=low, high=high)
    if hertz is not None:
        crossings = crossings.chosen((hertz[0] <= frequency[crossings.mode]) & (frequency[crossings.mode] <= hertz[1]))
    # shapes in the coordinates of the System [m, rad], of modes with u = R rz
    radius = dict(zip(result["body"].values.tolist(), result["reference_radius"].values.tolist(), strict=True))
    dofs = [str(name).rpartition("/") for name in result["dof"].values]
    scale = np.array([radius[body] if direction == "rz" else 1.0 for body, _, direction in dofs])
    shapes = result["shape"].transpose("dof", "mode").values / scale[:, None]
    forces, note = _forces(linear(system), crossings, tuple(tones), shapes)
    connection, connection_share = _largest_share(result, "strain_energy_share", "connection", crossings)
    body, body_share = _largest_share(result, "kinetic_energy_share", "body", crossings)
    stage = np.array([", ".join(stages) for stages in tones.values()], dtype=object)[crossings.tone]
    columns = {
        "mode": crossings.mode + 1,
        "multiplicity": crossings.count,
        "frequency": frequency[crossings.mode],
        "kind": result["mode_kind"].values[crossings.mode],
        "order": crossings.order,
        "stage": stage,
        "speed": crossings.relative_speed,
        "near": np.abs(crossings.relative_speed - 1) <= (BAND if band is None else band),
        "connection": connection,
        "connection_share": connection_share,
        "body": body,
        "body_share": body_share,
        **forces,
        "excited": _excited(forces["share"]),
    }
    wider = result.copy()
    for short, values in columns.items():
        name = f"resonance_{short}"
        unit, meaning = VARIABLES[name]
        wider[name] = ("resonance", values, {"units": unit, "long_name": meaning})
    wider.attrs["resonance_note"] = note
    for name, value in (("band", band), ("hertz", hertz)):
        if value is not None:
            wider.attrs["options"] = json.dumps({**json.loads(wider.attrs["options"]), name: value})
    return wider


def excited_modes(
    system: System, crossings: MeshCrossings, shapes: Array, *, compiled: bool | None = None
) -> NDArray[np.object_]:
    """``resonance_excited`` of crossings (c,) alone: "yes", "no", "" where it is not known.

    Parameters
    ----------
    shapes : (n, modes) in the coordinates of the System [m, rad].  compiled : as of `sweep`.
    """
    # shaft orders are lines of their own: the motion at the mesh orders is the same without them
    how = {"shaft_orders": False, "compiled": compiled}
    forces, _ = _forces(linear(system), crossings, tuple(tones_of_meshes(system)), shapes, how)
    return _excited(forces["share"])


def _excited(share: Array) -> NDArray[np.object_]:
    """Words of the shares (c,) of modes in the energy of the motion [1]."""
    return np.where(np.isnan(share), "", np.where(share >= _EXCITED, "yes", "no")).astype(object)


def _largest_share(
    result: xr.Dataset, name: str, dim: str, crossings: MeshCrossings
) -> tuple[NDArray[np.object_], Array]:
    """Connection or body with most of the energy at every crossing (c,), branches and sides together, and its share."""
    keys = [
        "/".join(word for word in str(label).split("/") if not word.isdigit() and word not in _SIDES)
        for label in result[dim].values
    ]
    groups = list(dict.fromkeys(keys))
    shares = result[name].transpose(dim, "mode").values
    pairs = zip(crossings.mode, crossings.count, strict=True)
    of_mode = [shares[:, first : first + count].mean(axis=1) for first, count in pairs]
    member = np.array([[key == group for key in keys] for group in groups], dtype=float)
    total = np.array(of_mode).reshape(len(of_mode), len(keys)) @ member.T
    if not groups:
        return np.full(len(of_mode), "", dtype=object), np.full(len(of_mode), np.nan)
    most = np.array([largest(row) for row in total], dtype=int)
    share = total[np.arange(len(most)), most]
    return np.where(np.isfinite(share), np.array(groups, dtype=object)[most], ""), share


def _forces(
    system: System,
    crossings: MeshCrossings,
    tones: tuple[Fraction, ...],
    shapes: Array,
    how: Mapping[str, Any] | None = None,
) -> tuple[_Forces, str]:
    """Forces of the linear response at the crossings (c,), and what is missing of them, and why.

    Of several mesh frequencies with one of them at a time.

    how : options of `sweep`; None: its own, shaft orders where there is one mesh frequency.
    """
    count = len(crossings.relative_speed)
    forces: _Forces = {
        "dynamic_factor": np.full(count, np.nan),
        "mesh": np.full(count, "", dtype=object),
        "amplitude": np.full(count, np.nan),
        "own_force": np.full(count, np.nan),
        "share": np.full(count, np.nan),
    }
    how, pulled = how or {"shaft_orders": len(tones) == 1}, 0
    try:
        for tone in np.unique(crossings.tone):
            pulled += _enter_forces(forces, system, crossings, int(tone), tones, shapes, how)
    except ModelError as error:
        return forces, f"no forces: {error}"
    notes = ["K_v: the mesh orders of one stage at a time, without shaft orders"] if count and len(tones) > 1 else []
    if pulled:
        notes.append(
            f"At {pulled} of {count} speeds the linear model pulls on teeth that would part: "
            "K_v with contact loss is that of sweep --contact-loss"
        )
    return forces, "; ".join(notes)


def _enter_forces(
    forces: _Forces,
    system: System,
    crossings: MeshCrossings,
    number: int,
    tones: tuple[Fraction, ...],
    shapes: Array,
    how: Mapping[str, Any],
) -> int:
    """Enter the forces at the crossings of one mesh frequency, that of a number.

    Returns at how many of them teeth are pulled.
    """
    from .steady import SweepOptions, sweep

    tone, meshes = tones[number], system.meshes
    entries = np.flatnonzero(crossings.tone == number)
    speeds, column = np.unique(crossings.relative_speed[entries], return_inverse=True)
    driven = np.array([system.tones[i] == tone for i in meshes.tone])
    excited = system if len(tones) == 1 else of_one_tone(system, tone, driven)
    swept = sweep(excited, SweepOptions(relative_speed=speeds, orders=MESH_ORDERS, forces_alone=True, **how))
    factors = swept["dynamic_factor"].transpose("mesh", "speed").values
    lowest = swept["mesh_force_minimum"].transpose("mesh", "speed").values
    whole = driven[faces(meshes).first]
    amplitude = swept["mesh_force_order"].transpose("order", "mesh", "speed").values[:, whole]
    motion = swept["displacement_harmonic"].transpose("order", "speed", "dof").values / system.dofs.radius
    pulled = 0
    for entry, speed in zip(entries, column, strict=True):
        factor, order = factors[:, speed], crossings.order[entry] - 1
        loaded = np.isfinite(factor)
        pulled += bool((lowest[loaded, speed] < 0).any())
        force = amplitude[order, :, speed]
        forces["amplitude"][entry] = np.max(force) if np.isfinite(force).all() else np.nan
        if loaded.any():
            # of equal branches the first: rounding does not choose
            (most,) = first_largest(factor)
            forces["dynamic_factor"][entry] = np.nanmax(factor)
            forces["mesh"][entry] = str(swept["mesh"].values[most])
        space = shapes[:, crossings.mode[entry] : crossings.mode[entry] + crossings.count[entry]]
        forces["share"][entry], made = _mode_part(system, space, motion[order, speed])
        forces["own_force"][entry] = np.max(made[whole])
    return pulled


def _mode_part(system: System, space: Array, motion: ComplexArray) -> tuple[float, Array]:
    """What modes of one frequency have of a motion: their share of its energy [1], and of the mesh forces (w,) [N].

    With the modal coordinates c of the motion q, X' M X c = X' M q, the share is that of X c in q' M q, whatever basis
    X has; the forces are those of X c in the mean stiffness.  Derived here.

    Parameters
    ----------
    space : (n, k) shapes X.  motion : (n,) complex harmonic q [m, rad].
    """
    meshes = system.meshes
    whole = float((motion.conj() @ system.M @ motion).real)
    if not np.isfinite(whole):
        return np.nan, np.full(len(faces(meshes).name), np.nan)
    left = space.conj().T @ system.M
    part = space @ np.linalg.solve(left @ space, left @ motion)
    made: Array = np.abs(faces(meshes).total(meshes.stiffness * (meshes.B.T @ part)))
    return float((part.conj() @ system.M @ part).real) / whole if whole > 0 else 0.0, made


def of_one_tone(system: System, tone: Fraction, driven: NDArray[np.bool_]) -> System:
    """A System of one mesh frequency: the meshes (m,) that are not driven by it keep their mean stiffness."""
    meshes = system.meshes
    variation = np.where(driven[:, None], meshes.variation, 0)
    return replace(system, tones=(tone,), meshes=replace(meshes, tone=np.zeros_like(meshes.tone), variation=variation))
