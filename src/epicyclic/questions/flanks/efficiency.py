"""Mesh power loss and efficiency of a train: loss factors from the path of contact, losses from the power flow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...errors import ConvergenceError, ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...system.tooth_pairs import mean_force
from ...teeth import geometry
from ...teeth.path_of_contact import (
    Array,
    PlaneOfAction,
    Rolling,
    cycle_mean,
    loss_factor,
    mean_friction,
    path_load,
    sliding_distance,
)
from ...train.kinematics import Gearing
from ...train.power import LossyFlow, MeshPower, lossy_flow, require_contact, require_flow
from ...train.train import Mesh, Train
from ...warning_codes import CodedText, coded, placed
from . import ContactOptions, EfficiencyOptions
from .contact_resolution import flank_map
from .pair_contact import solved_pair, unresolved

FRICTION = 0.05
"""Coefficient of friction by default: that of [yue2014, section 3.2], in the usual range of lubricated steel teeth."""
# places along the path of contact: the steps of spur teeth within half a per cent of the path
_PLACES = 201
# The ends of the path are asked for this far inside [base pitches]: phases of contact stand on both sides of them.
_INSIDE = 1e-8
# loads per face width [N/m] and pitch-line speeds [m/s] that the formula of friction is meant for [iso14179]
_LEAST_LOAD, _MOST_SPEED = 150e3, 50.0
# power of a member below this share of the largest is rounding
_NONE = 1e-9


def efficiency(train: Train, options: EfficiencyOptions) -> xr.Dataset:
    """Mesh power loss and efficiency of a train at its operating point.  Branches and sides share the load equally.

    Losses of bearings, seals and oil are none of the meshes and not here.

    Load along the contact lines is uniform, or that of loaded tooth contact at the lossless load.

    Returns
    -------
    Dataset : train_efficiency and power_loss [W] (); loss_factor [1], mesh_power_loss and mesh_rolling_power [W] and
        driving_gear (mesh); friction_coefficient (mesh_pair) [1]; stage_power_loss [W] (stage); torque [N m] and power
        [W] of every loaded member with losses and without (member); sliding_speed [m/s], specific sliding [1] and
        path_load [1] along the path of contact (mesh_pair, flank_place).  Torques, power and losses are nan where the
        train is self-locking as stated.

    Raises
    ------
    ModelError : no speed, no torque, no power; friction so high that nothing is left; helical teeth without face width;
        teeth that do not keep contact; with contact what `contact` refuses.
    ConvergenceError : loaded contact is not solved at a phase.
    """
    given = {"viscosity": options.viscosity, "roughness": options.roughness}
    oil = {name: value for name, value in given.items() if value is not None}
    if oil and options.friction is not None:
        raise ModelError("a number and an oil", path="friction", given=options.friction, allowed="one of the two")
    for name in given.keys() - oil.keys() if oil else ():
        raise ModelError("is missing: friction by oil needs both", path=name, allowed="viscosity and roughness")
    friction = FRICTION if options.friction is None else options.friction
    require_flow(train.kinematics)
    said: list[CodedText] = []
    teeth = {gearing.pair: _teeth(train, gearing, options.sharing, said) for gearing in train.kinematics.gearings}
    mu = {pair: _oiled(train, mates, oil, said) if oil else friction for pair, mates in teeth.items()}
    share = {pair: mu[pair] * float(np.mean(mates.factors)) for pair, mates in teeth.items()}
    for pair, value in share.items():
        if value >= 1:
            raise ModelError(
                f"takes all power of {pair}", path="friction", given=mu[pair], allowed=f"below {mu[pair] / value:.4g}"
            )
    known = lossy_flow(train.kinematics, share)
    flow = known
    if flow is None:  # a train that locks itself: torques and powers are not known
        nothing = dict.fromkeys(train.kinematics.torque or {}, math.nan)
        none = MeshPower(driver="", rolling=math.nan, loss=math.nan, torque=math.nan)
        meshes = dict.fromkeys(teeth, none)
        flow = LossyFlow(torque=nothing, power=nothing, meshes=meshes, kept=(), released=(), indeterminate=False)
    of_stages = [[g.pair for g in train.kinematics.gearings if g.stage == stage] for stage in train.planets]
    return dataset(
        {
            **_totals(train, flow),
            **_mesh_columns(train, teeth, flow),
            "friction_coefficient": ("mesh_pair", np.array([mu[pair] for pair in teeth])),
            "stage_power_loss": (
                "stage",
                np.array([math.fsum(flow.meshes[p].loss for p in pairs) for pairs in of_stages]),
            ),
            **_member_columns(train, flow),
            **_path_columns(list(teeth.values())),
        },
        coords={
            "mesh": [mesh.name for mesh in train.meshes],
            "mesh_pair": list(teeth),
            "stage": list(train.planets),
            "member": _loaded(train, flow),
            "flank_place": np.linspace(0.0, 1.0, _PLACES),
        },
        verb="efficiency",
        options={"sharing": options.sharing, **(oil or {"friction": friction})},
        warnings=[*train.warnings, *_said(train, known), *dict.fromkeys(said)],
        provenance=train_provenance(train),
    )


# friction of the teeth ------------------------------------------------------------------------------------------------


class _Teeth(NamedTuple):
    """Friction of one pair: helices of one branch, loss factor H_V [1] of each and load along the path of the first.

    plane : of action, without its faces.  base_speed : of the base circles in the frame of the carrier [m/s].
    width : of the common face [m].
    """

    helices: tuple[Mesh, ...]
    plane: PlaneOfAction
    base_speed: float
    width: float
    factors: tuple[float, ...]
    sigma: Array
    load: Array


def _teeth(train: Train, gearing: Gearing, sharing: str, said: list[CodedText]) -> _Teeth:
    """Friction data of a pair, load uniform or as of loaded contact; `said` takes what that leaves unresolved.

    Raises
    ------
    ModelError : helical teeth without face width, teeth that do not keep contact.
    ConvergenceError : loaded contact is not solved.
    """
    meshes = [mesh for mesh in train.meshes if mesh.pair == gearing.pair]
    helices = tuple(mesh for mesh in meshes if mesh.branch == meshes[0].branch)
    for mesh in helices:
        require_contact(mesh)
    first, bodies = helices[0], {body.name: body for body in train.bodies}
    a, b = bodies[first.a].gear, bodies[first.b].gear
    assert a is not None
    assert b is not None
    speed = train.kinematics.speed or {}
    frame = speed[gearing.carrier] if gearing.carrier is not None else 0
    relative = abs(float(speed[gearing.a] - frame)) * math.tau / 60
    cosine = math.cos(first.pressure_angle)
    plane = PlaneOfAction(
        base_a=first.radius_a * cosine,
        base_b=first.radius_b * cosine,
        internal=first.internal,
        pressure_angle=first.pressure_angle,
        base_helix=first.base_helix,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        limits=first.limits,
        face_a=(0.0, 0.0),
        face_b=(0.0, 0.0),
    )
    sigma = np.linspace(*first.limits, _PLACES)
    if sharing == "contact" and (train.kinematics.mesh_torque or {})[gearing.pair]:
        distance, load = _of_contact(train, helices, sigma, said)
    else:
        distance = tuple(sliding_distance(mesh.limits, mesh.overlap_ratio) for mesh in helices)
        load = path_load(first.limits, first.overlap_ratio, sigma)
    return _Teeth(
        helices=helices,
        plane=plane,
        base_speed=relative * plane.base_a,
        width=first.width,
        factors=tuple(
            loss_factor(a.teeth, b.teeth, first.base_helix, away, internal=first.internal) for away in distance
        ),
        sigma=sigma,
        load=load,
    )


def _of_contact(
    train: Train, helices: Sequence[Mesh], sigma: Array, said: list[CodedText]
) -> tuple[tuple[float, ...], Array]:
    """Distances <|sigma|> of all helices of a branch under load, and load along the path of the first (n,) [1].

    Raises
    ------
    ConvergenceError : a phase is not solved.
    """
    from scipy.integrate import trapezoid

    options = ContactOptions(loads=())
    solved = solved_pair(train, helices, options, tangents=False)
    cut, results, name = solved.cut, solved.results, solved.name
    missed = np.any([result.status[0] != "" for result in results], axis=0)
    if missed.any():
        raise ConvergenceError(
            f"loaded contact of {name} is not solved at {missed.sum()} of {missed.size} phases, {solved.force:.4g} N "
            "on a small part of the face; smaller lead modifications (flank.slope, flank.crown), or uniform sharing"
        )
    said += [placed(name, text) for text in unresolved(cut, options.tolerance)]
    distance = []
    for result in results:
        force = result.force[0]
        # mean distance of the load from the pitch point at every phase (T,) [base pitches]
        away = (force * np.abs(result.segments.lines.sigma)).sum(axis=(1, 2)) / force.sum(axis=(1, 2))
        distance.append(float(cycle_mean(away, cut.phase)))
    lines, share = results[0].segments.lines, results[0].force[0] / results[0].load[0][:, None, None]
    inside = np.clip(sigma, helices[0].limits[0] + _INSIDE, helices[0].limits[1] - _INSIDE)
    load = np.nan_to_num(flank_map(lines.sigma, share, lines.length > 0, inside)).sum(axis=0)
    # interpolation loses a per cent at pieces of the face that the ends of the path cut
    return tuple(distance), load / trapezoid(load, sigma)


def _oiled(train: Train, teeth: _Teeth, oil: Mapping[str, float], said: list[CodedText]) -> float:
    """Mean coefficient of friction of a pair [1] by oil, load and speed; `said` takes what leaves the formula's range.

    0 without motion or load.  oil : viscosity, dynamic, at the temperature in the mesh [Pa s]; roughness, mean Ra of
    both flanks [m].

    Raises
    ------
    ModelError : no face width.
    """
    mesh = teeth.helices[0]
    if math.isnan(teeth.width):
        raise ModelError(
            "is missing: friction by oil needs the load per width",
            path=f"stages.{mesh.name.split('/')[0]}.face_width",
            allowed="of one helix [m], or a number for friction",
        )
    force = mean_force(train, mesh) * math.cos(mesh.base_helix)
    line = teeth.base_speed / math.cos(mesh.pressure_angle)
    if 0 < force / teeth.width < _LEAST_LOAD:
        load = f"{force / teeth.width * 1e-3:.3g} N/mm"
        text = f"{mesh.pair}: {load}, friction by oil is meant for 150 N/mm and more"
        said.append(coded("friction-outside-limits", text))
    if line > _MOST_SPEED:
        text = f"{mesh.pair}: {line:.3g} m/s at the pitch circles, friction by oil is meant for up to 50 m/s"
        said.append(coded("friction-outside-limits", text))
    pitch = Rolling.of(teeth.plane, 0.0, teeth.base_speed)
    speed, radius = abs(float(pitch.speed_a + pitch.speed_b)), float(teeth.plane.curvature_radius(0.0))
    if not speed or not force:
        return 0.0
    return mean_friction(force / teeth.width, speed, radius, **oil)


# columns --------------------------------------------------------------------------------------------------------------


def _totals(train: Train, flow: LossyFlow) -> dict[str, Any]:
    """Efficiency [1], power in, out and lost [W]; in and out by what drives without losses."""
    before = train.kinematics.power or {}
    least = _NONE * max(abs(value) for value in before.values())
    into = math.fsum(flow.power[name] for name, value in before.items() if value > least)
    out = -math.fsum(flow.power[name] for name, value in before.items() if value < -least)
    return {
        "train_efficiency": ((), out / into),
        "power_in": ((), into),
        "power_out": ((), out),
        "power_loss": ((), math.fsum(mesh.loss for mesh in flow.meshes.values())),
    }


def _mesh_columns(train: Train, teeth: Mapping[str, _Teeth], flow: LossyFlow) -> dict[str, Any]:
    """Loss factor [1], rolling power and loss [W], driving gear of every mesh; meshes of a pair share its power."""
    count = {pair: sum(mesh.pair == pair for mesh in train.meshes) for pair in teeth}
    factor, rolling, loss, driver = [], [], [], []
    for mesh in train.meshes:
        mates = teeth[mesh.pair]
        factors = mates.factors
        factor.append(factors[[helix.side for helix in mates.helices].index(mesh.side)])
        power = flow.meshes[mesh.pair]
        rolling.append(power.rolling / count[mesh.pair])
        loss.append(power.loss / count[mesh.pair] * (factor[-1] / sum(factors) * len(factors)))
        driving = (body.name for body in train.bodies if body.member == power.driver)
        driver.append(next((name for name in driving if name in (mesh.a, mesh.b)), ""))
    return {
        "loss_factor": ("mesh", np.array(factor)),
        "mesh_rolling_power": ("mesh", np.array(rolling)),
        "mesh_power_loss": ("mesh", np.array(loss)),
        "driving_gear": ("mesh", np.array(driver, dtype=str)),
    }


def _loaded(train: Train, flow: LossyFlow) -> list[str]:
    """Members with an external torque, with losses or without."""
    lossless = train.kinematics.torque or {}
    least = _NONE * max(abs(value) for value in lossless.values())
    return [name for name, value in lossless.items() if abs(value) > least or abs(flow.torque.get(name, 0.0)) > least]


def _member_columns(train: Train, flow: LossyFlow) -> dict[str, Any]:
    """External torque [N m] and power [W] of every loaded member, with losses and without."""
    names, kinematics = _loaded(train, flow), train.kinematics
    lossy = {"torque": flow.torque, "power": flow.power}
    columns = lossy | {"lossless_torque": kinematics.torque or {}, "lossless_power": kinematics.power or {}}
    return {name: ("member", np.array([values[member] for member in names])) for name, values in columns.items()}


def _path_columns(teeth: Sequence[_Teeth]) -> dict[str, Any]:
    """Place [base pitches], load [1], sliding speed [m/s] and specific sliding [1] along the path of every pair."""
    dims = ("mesh_pair", "flank_place")
    rolling = [Rolling.of(mates.plane, mates.sigma, mates.base_speed) for mates in teeth]
    return {
        "contact_place": (dims, np.array([mates.sigma for mates in teeth])),
        "path_load": (dims, np.array([mates.load for mates in teeth])),
        "sliding_speed": (dims, np.array([motion.sliding for motion in rolling])),
        "specific_sliding_a": (dims, np.array([motion.specific_a for motion in rolling])),
        "specific_sliding_b": (dims, np.array([motion.specific_b for motion in rolling])),
    }


def _said(train: Train, flow: LossyFlow | None) -> list[CodedText]:
    """What the losses change beside the numbers: self-locking, stated torques that follow, an open balance."""
    power = train.kinematics.power or {}
    driving = ", ".join(name for name, value in power.items() if value > 0)
    if flow is None:
        return [
            coded(
                "self-locking",
                f"self-locking: with these torques friction in the meshes holds the train, {driving} cannot turn it",
            )
        ]
    least = _NONE * max(abs(value) for value in power.values())
    said = [
        coded(
            "self-locking",
            f"self-locking: friction takes more than {driving} brings; {name}, which takes power off without losses, "
            "must drive too",
        )
        for name, value in power.items()
        if value < -least and flow.power[name] > -_NONE * least
    ]
    if flow.released:
        text = f"the torques stated of {', '.join(flow.released)} balance without losses; here they follow"
        said.append(coded("torques-released", text))
    if flow.indeterminate:
        text = "the balance leaves torques in a closed loop open: taken nearest to those without losses"
        said.append(coded("loop-torques-open", text))
    return said
