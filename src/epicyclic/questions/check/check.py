"""What a train is, and what its model file leaves open.

Derived data are speeds, torques, power, geometry, mesh phases, orders, the origin of every value, and the errors that
the deviations show in the meshes, one by one.  Left open are choices that matter, and what each verb still lacks.
Choices are what it says, or leaves to a default, of tilt and of loads along the face.  What a verb lacks is told by the
same checks that the verb makes, made once, without its work.
"""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.tolerances import Tolerance
from ...errors import ConvergenceError, ModelError
from ...limits import k_gamma_limit, limit_columns
from ...results.dataset import dataset
from ...statics.equilibrium import compliance_of, require_balance
from ...statics.record import standing_load, unheld_warnings
from ...statics.tangent import linear
from ...system.assembly import assemble, train_provenance
from ...system.structure import structure_of
from ...system.system import Array, System
from ...system.tooth_pairs import loaded_mesh, mean_force, pair_of, tooth_warnings
from ...train.power import require_contact, require_flow
from ...train.resolution import tolerances_of
from ...train.stage_bodies import link_row, tilt_groups
from ...train.train import DIRECTIONS, Body, Displacement, Link, Mesh, Train, bodies_named
from ...warning_codes import CodedText, coded
from ..modes.eigen import mean_modes
from ..rating.bearing_state import with_bearings
from ..response.spectra import mesh_tones, require_damping

# Pitch deviations have a line for every order of their gear, and loaded contact is no deviation.
_UNLISTED = ("pitch", "contact")
_ROUNDING = 1e-12  # of the displacement: the component of a vector across the normal
Columns = dict[str, tuple[str, NDArray[np.generic]]]
_NAN = float("nan")


# --- errors in the meshes --------------------------------------------------------------------------------------------


class MeshDeviation(NamedTuple):
    """One deviation in one mesh: e(t) = amplitude cos(2 pi frequency t + phase), positive opens the gap.

    path : of the deviation in the model file.  mesh : name.  amplitude [m].  phase [rad], in (-pi, pi].
    frequency : exact, in the frame of the stage [Hz], 0 where it stands still.
    """

    path: str
    mesh: str
    amplitude: float
    phase: float
    frequency: Fraction


def mesh_deviations(train: Train) -> list[MeshDeviation]:
    """Displaced features projected on the loaded flanks, then errors stated of the meshes.

    A displaced seat (position, bearing run-out, run-out of a carrier's pins) shows as it would if its bodies followed
    it: the meshes open by as much where the bodies do not move.  Pitch deviations and tilt are left out.
    """
    errors = [error for item in train.displacements for error in _displaced(train, item)]
    listed = (error for error in train.mesh_errors if error.cause not in _UNLISTED and not error.far)
    stated = sorted(listed, key=lambda error: error.path)
    errors += [_listed(error.path, error.mesh, error.amplitude, error.frequency) for error in stated]
    largest: dict[str, float] = {}
    for error in errors:
        largest[error.path] = max(largest.get(error.path, 0.0), error.amplitude)
    # a deviation that is 0 everywhere is listed: the file states it
    return [error for error in errors if error.amplitude >= _ROUNDING * largest[error.path]]


def _displaced(train: Train, item: Displacement) -> list[MeshDeviation]:
    """What a displaced feature opens the meshes by: of a gear its own, of a carrier those of the bodies it carries."""
    body = next(b for b in train.bodies if b.name == item.body)
    if item.rows != "mesh" and not item.links:
        return []
    moved = [body] if body.gear is not None else [b for b in train.bodies if b.carried_by == body.name]
    # a bearing off its body by E holds the body off its place by -E
    sense = -1.0 if item.cause == "bearing_run_out" else 1.0
    errors = []
    for gear in moved:
        for mesh in train.meshes:
            if gear.name in (mesh.a, mesh.b):
                error = -sense * complex(_normal(mesh, gear, body.angle) @ item.vector[:3])
                if abs(error) > _ROUNDING * np.abs(item.vector).max():
                    errors.append(_listed(item.path, mesh.name, error, item.frequency))
    return errors


def _listed(path: str, mesh: str, amplitude: complex, frequency: Fraction) -> MeshDeviation:
    """The entry of Re(amplitude exp(2 pi i frequency t)), with a frequency that is not negative."""
    value = amplitude.conjugate() if frequency < 0 else amplitude
    if frequency == 0:
        value = complex(value.real if abs(value.real) > _ROUNDING * abs(value) else 0.0)
    return MeshDeviation(path, mesh, abs(value), cmath.phase(value), abs(frequency))


def _normal(mesh: Mesh, body: Body, angle: float) -> NDArray[np.float64]:
    """First three coefficients (3,) of the row of a mesh for a body, in axes at an angle [rad] (docs/conventions.md,
    The mesh row).
    """
    turn = mesh.direction - angle
    across = math.sin(mesh.pressure_angle), mesh.flank * math.cos(mesh.pressure_angle)
    x = across[0] * math.cos(turn) - across[1] * math.sin(turn)
    y = across[0] * math.sin(turn) + across[1] * math.cos(turn)
    helix = mesh.base_helix
    normal = np.array([math.cos(helix) * x, math.cos(helix) * y, -mesh.hand * mesh.flank * math.sin(helix)])
    return normal if body.name == mesh.a else -normal


# --- the verb --------------------------------------------------------------------------------------------------------


def check(train: Train, needed: Mapping[str, Sequence[str]]) -> xr.Dataset:
    """Derived data of a train as one Dataset over bodies, gears, meshes, stages, links, orders and power paths.

    Parameters
    ----------
    train : resolved train.  needed : of every verb what a train must have, methods of `Readiness`.

    Returns
    -------
    Dataset : speed [rpm], torque [N m] and power [W] of every body (external torque, held members included), power
        through every coupling, shaft and pair (from the first to the second member, seen from the housing), geometry
        [m, rad] of every gear, lead [mesh cycles], contact ratio and backlash [m] of every mesh, and the force at which
        its stiffness is the tangent of a table [N], axial place [m], stiffness [N/m, N m/rad] and clearance [m] of
        every link; nan where the model gives no value.  Choices that matter (see `choices`), with their origin and
        effect.  Of every entry of `[tolerance]` distribution, mean and standard deviation [SI] and number of draws, own
        and common part apart; without a table none of these variables.  What every verb still needs; "" where it is
        ready.  Attributes ``values`` (path, value, unit, origin of each resolved value) and ``assumed``.
    """
    columns = {
        **_body_columns(train),
        **_gear_columns(train),
        **_mesh_columns(train),
        **_stage_columns(train),
        **_span_columns(train),
        **_order_columns(train),
        **_path_columns(train),
        **_deviation_columns(train),
        **_tolerance_columns(train),
    }
    variables = {name: column for name, column in columns.items() if name != column[0]}
    coords: dict[Hashable, object] = {name: column for name, column in columns.items() if name == column[0]}
    ready = Readiness(train)
    lacking, chosen = ready.lacking(needed), choices(train)
    result = dataset(
        {
            **variables,
            **_link_columns(train),
            **_ring_columns(train),
            **_fields("choice", chosen, _texts, choice_value="value", choice_origin="origin", choice_effect="effect"),
            "verb_needs": ("verb_name", _texts("\n".join(texts) for texts in lacking.values())),
        },
        coords={
            **coords,
            "link": ("link", _texts(link.name for link in train.links)),
            "direction": list(DIRECTIONS),
            "choice": ("choice", _texts(choice.path for choice in chosen)),
            "verb_name": ("verb_name", _texts(lacking)),
        },
        verb="check",
        warnings=list(dict.fromkeys([*train.warnings, *_circulation(train), *ready.teeth_said, *_equations(ready)])),
        provenance=train_provenance(train),
    )
    if not ready.problem("equations"):
        result = with_bearings(result, train, nominal_forces(train))
    values = [[value.path, value.value, value.unit, value.origin] for value in train.values]
    locked = train.kinematics.held if train.kinematics.locked else ()
    return result.assign_attrs(values=json.dumps(values, default=str), locked=json.dumps(locked))


def drawing(train: Train) -> xr.Dataset:
    """What the drawings of a train read of the Dataset of `check`: its columns over bodies, gears, meshes and links."""
    columns = {**_body_columns(train), **_gear_columns(train), **_mesh_columns(train)}
    links = {"link": ("link", _texts(link.name for link in train.links)), **_link_columns(train)}
    return xr.Dataset({**columns, **links}, coords={"direction": list(DIRECTIONS)})


def _texts(values: Iterable[str | None]) -> NDArray[np.generic]:
    return np.array([value or "" for value in values], dtype=str)


def _numbers(values: Iterable[float | Fraction | None]) -> NDArray[np.generic]:
    return np.array([_NAN if value is None else float(value) for value in values])


def _whole(values: Iterable[int | None]) -> NDArray[np.generic]:
    return np.array([value or 0 for value in values], dtype=np.int64)


def _truths(values: Iterable[bool]) -> NDArray[np.generic]:
    return np.array(list(values), dtype=bool)


def _fields(
    dim: str, rows: Iterable[object], read: Callable[[Iterable[Any]], NDArray[np.generic]], *same: str, **fields: str
) -> Columns:
    """Columns of fields of the rows: variables of the `same` name, then each variable=field."""
    fields = {name: name for name in same} | fields
    return {name: (dim, read([getattr(row, field) for row in rows])) for name, field in fields.items()}


def _body_columns(train: Train) -> Columns:
    bodies = [body for body in train.bodies if body.shaft_of is None]
    speed = np.array([_member_speed(train, body) for body in bodies])
    torque = np.array([_torque(train, body) for body in bodies])
    return {
        **_fields("body", bodies, _texts, body="name", kind="kind", member="member", body_stage="frame"),
        **_fields("body", bodies, _whole, "branch"),
        **_fields("body", bodies, _texts, "side", "carried_by"),
        "speed": ("body", speed),
        "torque": ("body", torque),
        "power": ("body", torque * speed * math.pi / 30),
        "centre_x": ("body", _numbers(body.centre[0] for body in bodies)),
        "centre_y": ("body", _numbers(body.centre[1] for body in bodies)),
        **_fields("body", bodies, _numbers, "station", axes_angle="angle"),
        **_fields("body", bodies, _numbers, "mass", "inertia", "tilt_inertia"),
        "outer_radius": ("body", _numbers(_outer_radius(train, body) for body in bodies)),
    }


def _member_speed(train: Train, body: Body) -> float:
    speeds = train.kinematics.speed
    return _NAN if speeds is None or body.member not in speeds else float(speeds[body.member])


def _torque(train: Train, body: Body) -> float:
    """External torque [N m]: given on this body, else an equal share of the rest of its member."""
    torques = train.kinematics.torque
    if torques is None:
        return _NAN
    if body.name in train.torques:
        return train.torques[body.name]
    same = [other.name for other in bodies_named(body.member, train.bodies)]
    rest = torques.get(body.member, 0.0) - sum(train.torques.get(name, 0.0) for name in same)
    return rest / sum(name not in train.torques for name in same)


def _outer_radius(train: Train, body: Body) -> float:
    """Outer radius for a drawing [m]: tip circle, rim of a ring, reach of a carrier's pins, else disc of inertia.

    A ring whose rim is not given is drawn with two modules beyond its roots.
    """
    if body.outer_radius is not None:
        return body.outer_radius
    if body.gear is not None:
        gear = body.gear
        return max(gear.root_radius, gear.tip_radius) + 2 * gear.module if gear.internal else gear.tip_radius
    carried = [other for other in train.bodies if other.carried_by == body.name and other.gear is not None]
    reach = [math.hypot(*other.centre) + 0.4 * other.gear.reference_radius for other in carried if other.gear]
    if reach:
        return max(reach)
    return math.sqrt(2 * body.inertia / body.mass) if body.mass > 0 and body.inertia > 0 else _NAN


def _gear_columns(train: Train) -> Columns:
    bodies = [body for body in train.bodies if body.gear is not None]
    gears = [body.gear for body in bodies]
    radii = ("base_radius", "tip_radius", "root_radius", "reference_radius")
    others = ("face_width", "gap", "helix_angle", "profile_shift", "module", "pressure_angle")
    return {
        **_fields("gear", bodies, _texts, gear="name"),
        **_fields("gear", gears, _whole, "teeth", "hand"),
        **_fields("gear", gears, _truths, "internal", "herringbone"),
        **_fields("gear", gears, _numbers, *radii, *others),
    }


def _mesh_columns(train: Train) -> Columns:
    meshes = train.meshes
    working = {"working_pressure_angle": "pressure_angle", "working_radius": "radius_a"}
    return {
        **_fields("mesh", meshes, _texts, mesh="name", gear_a="a", gear_b="b", mesh_stage="stage"),
        **_fields("mesh", meshes, _whole, mesh_branch="branch"),
        **_fields("mesh", meshes, _texts, mesh_side="side", mesh_pair="pair"),
        **_fields("mesh", meshes, _whole, "flank"),
        **_fields("mesh", meshes, _numbers, phase_lead="lead"),
        **_fields(
            "mesh", meshes, _numbers, "contact_ratio", "overlap_ratio", **working, mean_mesh_stiffness="stiffness"
        ),
        "tangent_load": ("mesh", _numbers(None if mesh.table is None else mesh.table.load for mesh in meshes)),
        **_fields("mesh", meshes, _numbers, "backlash"),
        "mesh_slices": ("mesh", _whole(max(len(mesh.slices), 1) for mesh in meshes)),
        **_fields("mesh", meshes, _numbers, mesh_station="station", mesh_direction="direction"),
    }


def _link_columns(train: Train) -> dict[str, tuple[str | tuple[str, str], NDArray[np.generic]]]:
    links, whose = train.links, {body.name: body.shaft_of or body.name for body in train.bodies}
    return {
        "link_first": ("link", _texts(whose[link.first] for link in links)),
        "link_second": ("link", _texts(whose.get(link.second or "") for link in links)),
        **_fields("link", links, _texts, link_kind="kind"),
        **_fields("link", links, _numbers, link_station="station"),
        "link_stiffness": (("link", "direction"), np.array([link.stiffness for link in links]).reshape(-1, 6)),
        **_fields("link", links, _numbers, link_clearance="clearance"),
    }


def _ring_columns(train: Train) -> dict[str, tuple[str | tuple[str, str], NDArray[np.generic]]]:
    """Section, orders and free natural frequencies of rings that bend; nothing without one."""
    bent = {body.name: (body.member, body.elastic) for body in train.bodies if body.elastic is not None}
    if not bent:
        return {}
    rings, stated = [ring for _, ring in bent.values()], {value.path: str(value.value) for value in train.values}
    orders = range(2, max(ring.orders for ring in rings) + 1)
    frequency = np.array([[ring.frequency(n) if n <= ring.orders else _NAN for n in orders] for ring in rings])
    left_out = [float(stated[f"stages.{member}.elastic.left_out"]) for member, _ in bent.values()]
    section = {"ring_radius": "radius", "ring_bending": "bending", "ring_line_mass": "line_mass", "ring_axial": "axial"}
    return {
        "elastic_ring": ("elastic_ring", _texts(bent)),
        "ring_order": ("ring_order", np.array(orders)),
        **_fields("elastic_ring", rings, _numbers, **section),
        **_fields("elastic_ring", rings, _whole, ring_orders="orders"),
        "ring_left_out": ("elastic_ring", _numbers(left_out)),
        "ring_frequency": (("elastic_ring", "ring_order"), frequency),
    }


def _span_columns(train: Train) -> Columns:
    """Places, mass and lowest bending mode of the spans of shafts that bend; nothing without one."""
    if not train.spans:
        return {}
    highest = max((train.kinematics.mesh_frequency or {}).values(), default=0)
    modes = np.array([span.frequency for span in train.spans])
    return {
        **_fields("span", train.spans, _texts, span="name"),
        **_fields("span", train.spans, _numbers, span_start="start", span_end="end", span_mass="mass"),
        "span_frequency": ("span", modes),
        "span_frequency_ratio": ("span", modes / float(highest) if highest else np.full(len(modes), _NAN)),
    }


def _stage_columns(train: Train) -> Columns:
    stages = list(train.planets)
    tones = train.kinematics.mesh_frequency or {}
    return {
        "stage": ("stage", _texts(stages)),
        "planets": ("stage", _whole(train.planets[stage] for stage in stages)),
        "mesh_frequency": ("stage", _numbers(tones.get(stage) for stage in stages)),
        "hunting_period": ("stage", _numbers(_hunting_period(train, stage) for stage in stages)),
        "centre_distance": ("stage", _numbers(_centre_distance(train, stage) for stage in stages)),
        **limit_columns(
            "stage", [k_gamma_limit(train.document, stage, max(1, train.planets[stage])) for stage in stages]
        ),
    }


def _hunting_period(train: Train, stage: str) -> int | None:
    """Hunting period [mesh cycles]: every gear of the stage, also of stepped shafts, makes whole turns in its frame.

    None of a locked train.
    """
    if train.kinematics.locked:
        return None
    carrier = next((frame.carrier for frame in train.frames if frame.name == stage), None)
    teeth = {body.member: body.gear.teeth for body in train.bodies if body.frame == stage and body.gear is not None}
    gear = next((mesh.a for mesh in train.meshes if mesh.stage == stage), None)
    first = next((body.member for body in train.bodies if body.name == gear), "")
    ratio = train.kinematics.ratio
    for end in train.kinematics.freedoms:
        still = ratio[carrier][end] if carrier is not None else Fraction(0)
        cycle = teeth.get(first, 0) * (ratio[first][end] - still) if first else Fraction(0)
        if cycle:
            return math.lcm(*(((ratio[member][end] - still) / cycle).denominator for member in teeth))
    return math.lcm(*teeth.values())


def _centre_distance(train: Train, stage: str) -> float | None:
    centres = {body.name: body.centre for body in train.bodies}
    mesh = next((mesh for mesh in train.meshes if mesh.stage == stage), None)
    return None if mesh is None else math.dist(centres[mesh.a], centres[mesh.b])


def _order_columns(train: Train) -> Columns:
    """Mesh frequency of each stage and rotation of each member, in its frame and absolute [Hz; mesh orders]."""
    lines = _shaft_lines(train)
    return {
        "order_name": ("order_name", _texts(name for name, _, _ in lines)),
        "order_frequency": ("order_name", _numbers(frequency for _, frequency, _ in lines)),
        "order": ("order_name", _numbers(frequency / tone for _, frequency, tone in lines)),
    }


def _shaft_lines(train: Train) -> list[tuple[str, Fraction, Fraction]]:
    """Name, frequency [Hz] and mesh frequency of the stage [Hz] of every mesh and rotation; exact."""
    kinematics = train.kinematics
    if kinematics.speed is None or kinematics.mesh_frequency is None:
        return []
    frames = kinematics.frame_speed or {}
    lines: list[tuple[str, Fraction, Fraction]] = []
    for stage, tone in kinematics.mesh_frequency.items():
        if tone == 0:
            continue
        lines.append((f"{stage} mesh", tone, tone))
        frame = frames.get(stage, Fraction(0))
        members = dict.fromkeys(body.member for body in train.bodies if body.frame == stage)
        for member in members:
            speed = kinematics.speed.get(member, Fraction(0))
            if speed != 0:
                lines.append((f"{member} turning", abs(speed) / 60, tone))
            if frame != 0 and speed != frame:
                lines.append((f"{member} in the carrier's frame", abs(speed - frame) / 60, tone))
    return lines


def _path_columns(train: Train) -> Columns:
    """Torque [N m] and power [W] of every power path, and its share [1] of the input power."""
    paths = train.power_paths
    power = np.array([path.power for path in paths])
    driving = sum(value for value in (train.kinematics.power or {}).values() if value > 0)
    return {
        **_fields("path", paths, _texts, path="path", path_from="first", path_to="second"),
        **_fields("path", paths, _numbers, path_torque="torque"),
        "path_power": ("path", power),
        "path_share": ("path", power / driving if driving else np.full(len(paths), _NAN)),
        **_fields("path", paths, _numbers, path_rolling_power="rolling"),
        **_fields("path", paths, _truths, path_circulating="circulating"),
    }


def _deviation_columns(train: Train) -> Columns:
    """Amplitude [m], phase [rad] and frequency [Hz] of what each deviation shows in each mesh."""
    errors = mesh_deviations(train)
    return {
        "mesh_deviation": ("mesh_deviation", _texts(f"{error.path} in {error.mesh}" for error in errors)),
        **_fields("mesh_deviation", errors, _texts, deviation_path="path", deviation_mesh="mesh"),
        **_fields("mesh_deviation", errors, _numbers, deviation_amplitude="amplitude", deviation_phase="phase"),
        **_fields("mesh_deviation", errors, _numbers, deviation_frequency="frequency"),
    }


def _tolerance_columns(train: Train) -> Columns:
    """Distribution, moments [SI] and number of draws of each entry of `[tolerance]`; nothing without one."""
    parts = [
        (entry, part, drawn)
        for entry in tolerances_of(train)
        for part, drawn in (("own", entry.own), ("common", entry.common))
        if drawn is not None
    ]
    if not parts:
        return {}
    return {
        "toleranced": ("toleranced", _texts(f"{entry.path} {part}" for entry, part, _ in parts)),
        "tolerance_path": ("toleranced", _texts(entry.path for entry, _, _ in parts)),
        "tolerance_part": ("toleranced", _texts(_part(entry, part) for entry, part, _ in parts)),
        "tolerance_distribution": ("toleranced", _texts(drawn.text for _, _, drawn in parts)),
        "tolerance_mean": ("toleranced", _numbers(drawn.mean.real for _, _, drawn in parts)),
        "tolerance_std": ("toleranced", _numbers(drawn.std for _, _, drawn in parts)),
        "tolerance_unit": ("toleranced", _texts(entry.unit for entry, _, _ in parts)),
        "tolerance_draws": ("toleranced", _whole(entry.count if part == "own" else 1 for entry, part, _ in parts)),
    }


def _part(entry: Tolerance, part: str) -> str:
    """What an own or a common distribution is, in words."""
    if part == "common":
        return "common to all"
    marked = ", teeth marked" if entry.phase == "marked" else ""
    vector = "vector" if entry.vector else "number"
    return f"{vector} of each{marked}" if entry.count > 1 else vector


def _circulation(train: Train) -> list[CodedText]:
    """Warning of circulating power: the least of its paths, and the largest share of the input power."""
    circulating = [path for path in train.power_paths if path.circulating]
    if not circulating:
        return []
    powers = [abs(path.power) for path in circulating]
    driving = sum(value for value in (train.kinematics.power or {}).values() if value > 0)
    share = f"; up to {max(powers) / driving:.3g} times the input power" if driving else ""
    through = ", ".join(path.path for path in circulating)
    text = f"power circulates: {min(powers) / 1e3:.6g} kW through {through}{share}"
    return [coded("power-circulates", text)]


def _equations(ready: Readiness) -> list[CodedText]:
    """Warning of what forbids the equations of the train, or of a load along a motion that nothing holds."""
    if problem := ready.problem("equations"):
        return [coded("not-solvable", problem)]
    return unheld_warnings(ready.system, compliance_of(ready.system).free)


# --- bearings by their parts -----------------------------------------------------------------------------------------


def nominal_forces(train: Train) -> dict[str, Array]:
    """Force (1,) [N, N m] of every row of the links under the nominal torques, shared evenly by the meshes.

    The forces of the meshes at their places balance with those of the links, turning apart.  Where several links could
    carry a load, they are the ones of least squares, as of equal springs (moments count at the pitch radius of the
    bearing) on rigid bodies: shafts and necks carry what balance asks and count in no square.  Weights and inertia are
    left out.  nan without torques.
    """
    made, whole = structure_of(train), {mesh.name: mesh for mesh in train.meshes}
    each = np.array([mean_force(train, whole[row.whole]) / max(1, len(whole[row.whole].slices)) for row in made.meshes])
    rigid, rows = 6 * len(train.bodies), (*made.links, *made.rigids)
    load = -(each @ made.mesh)[:rigid].reshape(-1, 6)[:, :5].ravel()
    matrix = np.vstack([made.link, made.rigid])[:, :rigid].reshape(len(rows), -1, 6)[..., :5].reshape(len(rows), -1)
    radius = np.array([row.link.rolling.pitch_diameter / 2 if row.link.rolling else 1.0 for row in rows])
    size = np.where([row.direction < 3 for row in rows], 1.0, radius) * [row.stiffness > 0 for row in rows]
    size[[row.link.kind in ("neck", "shaft") for row in rows]] *= _STIFFER
    known = np.isfinite(load).all()
    force = size * np.linalg.lstsq(matrix.T * size, load, rcond=None)[0] if known else np.full(len(rows), _NAN)
    return {row.name: force[i : i + 1] for i, row in enumerate(rows)}


_TILTS = ("rx", "ry")
_STIFFER = 1e4  # than bearings are shafts and necks where loads are shared as by equal springs: 1e-8 of them is left
_NO_LEVER = 1e-12  # [m, or 1 of an angle] rounding of cosines, a lever of no rigid direction


# --- choices ---------------------------------------------------------------------------------------------------------


class Choice(NamedTuple):
    """One choice.  path : its key in the file.  origin : given, default, ...  effect : what it does."""

    path: str
    value: str
    origin: str
    effect: str


def choices(train: Train) -> list[Choice]:
    """Of every member what holds its tilt, and of every pair the slices of its meshes, in the order of the file."""
    origins = {value.path: value.origin for value in train.values}
    group = tilt_groups(train.bodies, train.links)
    members: dict[str, Body] = {}
    for body in train.bodies:
        members.setdefault(body.member, body)
    pairs: dict[str, Mesh] = {}
    for mesh in train.meshes:
        pairs.setdefault(mesh.pair, mesh)
    tilts = [_tilt(train, body, group, origins) for body in members.values()]
    askew = {item.body for item in train.displacements if item.cause == "tilt"}
    apart = tilt_groups(train.bodies, train.links, askew)
    return tilts + [_slices(mesh, apart, origins) for mesh in pairs.values()]


def _tilt(train: Train, body: Body, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """What holds the tilt of one body, the first of its member: links to what carries it, about its own centre."""
    links = [link for link in train.links if body.name in (link.first, link.second)]
    spans = {span.name for span in train.spans}
    if path := next((link.path for link in links if link.name in spans), ""):
        return Choice(path, "bends", "given", f"{body.member} tilts as its shaft bends between its supports")
    seats = [link for link in links if link.kind in ("support", "bearing") and _holds(link, body)] or links
    path = f"{seats[0].path.rsplit('.bolts', 1)[0]}.tilt" if seats else f"{body.member}.tilt"
    stated = [origins.get(f"{link.path}.{name}", "default") for link in seats for name in _TILTS]
    origin = next((source for source in stated if source not in ("default", "geometry")), "default")
    base = next((link.first if link.first != body.name else link.second for link in seats), None)
    where = base or "its frame"
    if seats and group[body.name] == group[base or ""]:
        return Choice(path, "rigid", origin, f"{body.member} follows {where} in tilt: no degree of freedom")
    about = [sum(_tilt_stiffness(link, body)[i] for link in seats) for i in range(len(_TILTS))]
    value = ", ".join(f"{name} {number:.4g} N m/rad" for name, number in zip(_TILTS, about, strict=True))
    places = [link.name.rsplit("/", 1)[-1] for link in seats]
    if not any(about):
        return Choice(path, "free", origin, f"only its meshes, necks and shafts hold {body.member} in tilt")
    if any(any(link.stiffness[3:5]) for link in seats):
        return Choice(path, value, origin, f"{body.member} tilts against {where} on the stiffness of {_and(places)}")
    effect = f"{body.member} tilts against {where}; {_and(places)} hold it by their distance, sum k z^2"
    return Choice(path, value, origin, effect)


def _holds(link: Link, body: Body) -> bool:
    """Whether a support or bearing is the body's own seat, not that of what it carries."""
    return body.name == (link.second if link.kind == "bearing" and link.second is not None else link.first)


def _tilt_stiffness(link: Link, body: Body) -> tuple[float, float]:
    """Stiffness of one link against tilts of the body about the axes rx and ry of its centre [N m/rad]."""
    centre, about = (*body.centre, body.station), [0.0, 0.0]
    cosine, sine = math.cos(body.angle), math.sin(body.angle)
    for direction, stiffness in enumerate(link.stiffness):
        _, _, _, x, y, _ = link_row(link, direction, centre)
        for i, lever in enumerate((cosine * x + sine * y, cosine * y - sine * x)):
            if stiffness and abs(lever) > _NO_LEVER:
                about[i] += stiffness * lever**2
    return about[0], about[1]


def _and(names: Sequence[str]) -> str:
    """Names in a sentence, each once."""
    once = list(dict.fromkeys(names))
    return once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"


def _slices(mesh: Mesh, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """Slices of one pair of gears, and what they leave of its tilt stiffness."""
    path, count = f"{mesh.pair}.slices", max(len(mesh.slices), 1)
    origin = origins.get(path, "default")
    if group[mesh.a] == group[mesh.b]:
        effect = "the gears cannot tilt against each other: the load along the face is even"
    elif count == 1:
        effect = "no stiffness of the mesh against tilt, no load along the face"
    else:
        width = count * (mesh.slices[1].station - mesh.slices[0].station)
        tilt = mesh.stiffness * math.cos(mesh.base_helix) ** 2 * width**2 / 12 * (1 - count**-2)
        effect = f"tilt stiffness of the mesh {tilt:.4g} N m/rad in its transverse plane of action"
        effect += f", {1e2 / count**2:.2g} % low"
    return Choice(path, str(count), origin, effect)


# --- what a verb lacks -----------------------------------------------------------------------------------------------

# Needs that ask the assembled train: without it they say the same as `equations`.
_ASSEMBLED = ("inertia", "damping", "balance")


class Readiness:
    """What one train lacks; every check is made once.

    train : resolved.
    """

    def __init__(self, train: Train) -> None:
        self.train = train
        self._problems: dict[str, str] = {}

    def lacking(self, needed: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
        """Verb -> what it still needs, messages with their paths; none where it is ready.

        needed : of every verb the names of methods; options may need less (``sharing --method static``) or more.
        """
        lacking: dict[str, list[str]] = {}
        for verb, needs in needed.items():
            asked = needs if not self.problem("equations") else [need for need in needs if need not in _ASSEMBLED]
            lacking[verb] = list(dict.fromkeys(text for need in asked if (text := self.problem(need))))
        return lacking

    def problem(self, need: str) -> str:
        """Message of one need that is not met, else ""."""
        if need not in self._problems:
            check: Callable[[], object] = getattr(self, need)
            self._problems[need] = ""
            try:
                check()
            except (ModelError, ConvergenceError) as error:
                self._problems[need] = str(error)
        return self._problems[need]

    @cached_property
    def system(self) -> System:
        """The assembled train.  Raises ModelError where its equations cannot be written."""
        return assemble(self.train)

    @cached_property
    def teeth_said(self) -> tuple[CodedText, ...]:
        """Warnings of tooth contact of the first mesh of every pair that has teeth, and why a pair has no contact."""
        said: list[CodedText] = []
        for pair in dict.fromkeys(mesh.pair for mesh in self.train.meshes):
            mesh = next(mesh for mesh in self.train.meshes if mesh.pair == pair)
            if mesh.teeth is None:
                continue
            try:
                said += tooth_warnings(pair_of(self.train, mesh), mesh)
            except ModelError as error:
                said.append(coded("no-tooth-contact", str(error)))
        return tuple(dict.fromkeys(said))

    def equations(self) -> object:
        """Check that the train can be assembled."""
        return self.system

    def inertia(self) -> object:
        """Check that every free coordinate has mass, and that the mean system has modes."""
        self.system.require_inertia()
        return mean_modes(linear(self.system))

    def damping(self) -> None:
        """Check that something damps."""
        require_damping(self.system)

    def speed(self) -> object:
        """Check that the meshes have a frequency."""
        if self.train.kinematics.speed is None:
            raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
        return None if self.problem("equations") else mesh_tones(self.system)

    def torque(self) -> None:
        """Check that torque passes a mesh."""
        if not mean_force(self.train, loaded_mesh(self.train)) > 0:
            raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")

    def tolerances(self) -> None:
        """Check that a number of the file has a tolerance."""
        if not self.train.document.get("tolerance"):
            raise ModelError("no tolerance is given", path="tolerance", allowed='"PATH" = "normal(mean, deviation)"')

    def rolling(self) -> None:
        """Check that a bearing is stated by its parts."""
        if not any(link.rolling for link in self.train.links):
            allowed = '"cylindrical roller" or another, and its parts'
            raise ModelError("no bearing is stated by its parts", path="stages.*.planet.bearing.type", allowed=allowed)

    def prices(self) -> None:
        """Check that a tolerance has grades with prices."""
        table = self.train.document.get("tolerance")
        if not (isinstance(table, Mapping) and table.get("cost")):
            raise ModelError("no grade has a price", path="tolerance.cost", allowed='"GRADE or distribution" = PRICE')

    def flow(self) -> None:
        """Check that power flows."""
        require_flow(self.train.kinematics)

    def contact_lines(self) -> None:
        """Check that the contact lines of every pair are known and touch."""
        for mesh in self.train.meshes:
            require_contact(mesh)

    def balance(self) -> None:
        """Check that the mean load works on no motion without stiffness."""
        require_balance(compliance_of(self.system).free, standing_load(self.system)[None], self.system)

    def ring(self) -> None:
        """Check that a stage has a ring for a sensor."""
        if not any(mesh.internal for mesh in self.train.meshes):
            raise ModelError("no stage has a ring for its planets to pass along", path="stages", allowed="a ring")

    def any_teeth(self) -> object:
        """Check that some mesh has teeth that can bear."""
        return pair_of(self.train, next((m for m in self.train.meshes if m.teeth is not None), self.train.meshes[0]))

    def teeth(self) -> None:
        """Check that every pair has teeth that can bear."""
        for mesh in {mesh.pair: mesh for mesh in reversed(self.train.meshes)}.values():
            pair_of(self.train, mesh)
