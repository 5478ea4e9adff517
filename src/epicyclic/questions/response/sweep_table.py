"""Table of a sweep: its speeds, the Dataset filled speed by speed, and resonances, where mesh orders meet modes.

Speeds are those asked for, or a range about operation or up to the modes.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...errors import ModelError
from ...limits import RESONANCE_BAND
from ...results.dataset import first_largest, largest
from ...statics.record import parallel_meshes
from ...statics.signals import sensor_labels
from ...statics.static import rounding_of
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, Index, System, faces
from ...warning_codes import CodedText
from ..modes.campbell import MESH_ORDERS, OPERATION, MeshCrossings, mesh_crossings, tones_of_meshes
from ..modes.eigen import Modal, frequencies_of_bodies
from . import SweepOptions
from .measures import Layout
from .response import Response, response
from .spectra import LineExcitation, lateral_pairs

# A mode with less than a hundredth of the amplitude of an order, at its own frequency, is not excited by it: what moves
# is the other modes.
_EXCITED = 1e-4
_SIDES = ("left", "right")


ResonanceForces = dict[str, NDArray[Any]]
"""Forces (c,) at the crossings from the sweep with linear contact; nan and "" where not computed.

dynamic_factor : largest of any mesh [1], mesh : which.  amplitude : largest amplitude of the order that meets the mode,
of the meshes that have its mesh frequency [N].  own_force : of that the amplitude that the mode itself makes [N],
force_ratio : largest of that per mean force of the same mesh [1].  share : energy of the mode per energy of the motion
at that order [1].  excited : "yes" or "no" by that share, "" where it is not known.
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
    forces, note = _forces(linear(system), crossings, shapes)
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
        "near": np.abs(crossings.relative_speed - 1) <= (RESONANCE_BAND if band is None else band),
        "connection": connection,
        "connection_share": connection_share,
        "body": body,
        "body_share": body_share,
        **forces,
    }
    named = {f"resonance_{short}": values for short, values in columns.items()}
    labels = {name: dict(zip(("units", "long_name"), VARIABLES[name], strict=True)) for name in named}
    wider = result.assign({name: ("resonance", values, labels[name]) for name, values in named.items()})
    wider.attrs["resonance_note"] = note
    for name, value in (("band", band), ("hertz", hertz)):
        if value is not None:
            wider.attrs["options"] = json.dumps({**json.loads(wider.attrs["options"]), name: value})
    return wider


def resonance_forces(
    system: System, crossings: MeshCrossings, shapes: Array, *, tolerance: float = 1e-6
) -> ResonanceForces:
    """Forces at crossings (c,) alone, of the mesh orders.

    Parameters
    ----------
    shapes : (n, modes) in the coordinates of the System [m, rad].  tolerance : as of `SweepOptions`.
    """
    # shaft orders are lines of their own: the motion at the mesh orders is the same without them
    return _forces(linear(system), crossings, shapes, {"shaft_orders": False, "tolerance": tolerance})[0]


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
    system: System, crossings: MeshCrossings, shapes: Array, how: dict[str, Any] | None = None
) -> tuple[ResonanceForces, str]:
    """Forces of the linear response at the crossings (c,), and what is missing of them, and why.

    Of several mesh frequencies with one of them at a time.

    how : options of `sweep`; None: its own, shaft orders where there is one mesh frequency.
    """
    count = len(crossings.relative_speed)
    names = ("dynamic_factor", "mesh", "amplitude", "own_force", "force_ratio", "share", "excited")
    forces: ResonanceForces = {name: np.full(count, np.nan) for name in names}
    forces |= {name: np.full(count, "", dtype=object) for name in ("mesh", "excited")}
    tones, system = tuple(tones_of_meshes(system)), system.scaling
    how, pulled = how or {"shaft_orders": len(tones) == 1}, 0
    try:
        for tone in np.unique(crossings.tone):
            pulled += _enter_forces(forces, system, crossings, int(tone), shapes, how)
    except ModelError as error:
        return forces, f"no forces: {error}"
    notes = ["K_v: the mesh orders of one stage at a time, without shaft orders"] if count and len(tones) > 1 else []
    if lost := int(np.isnan(forces["share"]).sum()):
        notes.append(f"At {lost} of {count} speeds no motion was found: what the mode does there is not known")
    if pulled:
        notes.append(
            f"At {pulled} of {count} speeds the linear model pulls on teeth that would part: "
            "K_v with contact loss is that of sweep --contact-loss"
        )
    return forces, "; ".join(notes)


def _enter_forces(
    forces: ResonanceForces,
    system: System,
    crossings: MeshCrossings,
    number: int,
    shapes: Array,
    how: Mapping[str, Any],
) -> int:
    """Enter the forces at the crossings of one mesh frequency, that of a number.

    Returns at how many of them teeth are pulled.
    """
    from .steady import solved_table

    tones, meshes = tuple(tones_of_meshes(system)), system.meshes
    tone = tones[number]
    entries = np.flatnonzero(crossings.tone == number)
    speeds, column = np.unique(crossings.relative_speed[entries], return_inverse=True)
    driven = np.array([system.tones[i] == tone for i in meshes.tone])
    excited = replace(system, passing=None) if len(tones) == 1 else of_one_tone(system, tone, driven)
    ready, options = response(excited), SweepOptions(orders=MESH_ORDERS, forces_alone=True, **how)
    swept = solved_table(ready, speeds, options).values
    factors, lowest, face = swept["dynamic_factor"], swept["mesh_force_minimum"], faces(meshes)
    whole = driven[face.first]
    mean = np.abs(swept["mesh_force_mean"][whole])
    # (mesh, order, speed), (dof, order, speed)
    amplitude = swept["mesh_force_order"][whole]
    motion = np.asarray(swept["displacement_harmonic"] / system.dofs.radius[:, None, None], complex)
    pulled = 0
    for entry, speed in zip(entries, column, strict=True):
        factor, order = factors[:, speed], crossings.order[entry] - 1
        loaded = np.isfinite(factor)
        pulled += bool((lowest[loaded, speed] < 0).any())
        force = amplitude[:, order, speed]
        forces["amplitude"][entry] = np.max(force) if np.isfinite(force).all() else np.nan
        if loaded.any():
            # of equal branches the first: rounding does not choose
            (most,) = first_largest(factor)
            forces["dynamic_factor"][entry] = np.nanmax(factor)
            forces["mesh"][entry] = face.name[most]
        space = shapes[:, crossings.mode[entry] : crossings.mode[entry] + crossings.count[entry]]
        forces["share"][entry], made = _mode_part(system, space, motion[:, order, speed])
        forces["own_force"][entry] = np.max(made[whole])
        if (carrying := loaded[whole]).any():
            forces["force_ratio"][entry] = np.max(made[whole][carrying] / mean[carrying, speed])
        if np.isfinite(forces["share"][entry]):
            forces["excited"][entry] = "yes" if forces["share"][entry] >= _EXCITED else "no"
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
    meshes = replace(meshes, tone=np.zeros_like(meshes.tone), variation=variation)
    return replace(system, tones=(tone,), meshes=meshes, passing=None)


_BOUND = "bound of the largest radial force in a bearing or support, over all phases of the mesh frequencies"
# Dimensions of every numeric variable besides speed.
ROWS: dict[str, tuple[str, ...]] = {
    "mesh_force_mean": ("mesh",),
    "mesh_force_rms": ("mesh",),
    "mesh_force_peak": ("mesh",),
    "mesh_force_minimum": ("mesh",),
    "mesh_force_peak_to_peak": ("mesh",),
    "dynamic_factor": ("mesh",),
    "mesh_force_order": ("mesh", "order"),
    "displacement_harmonic": ("dof", "order"),
    "mesh_force_line": ("mesh", "line"),
    "amplitude": ("dof",),
    "acceleration_rms": ("dof",),
    "body_acceleration_rms": ("body",),
    "link_force_factor": ("link_row",),
    "link_force_mean": ("link_row",),
    "link_force_rms": ("link_row",),
    "link_force_peak": ("link_row",),
    "link_force_peak_to_peak": ("link_row",),
    "bearing_force_mean": ("bearing",),
    "bearing_force_rms": ("bearing",),
    "bearing_force_peak": ("bearing",),
    **{
        f"transmission_error_{kind}_{name}": (row, *dims)
        for kind, row in (("rotation", "mesh"), ("approach", "mesh"), ("shaft", "shaft"))
        for name, dims in (("peak_to_peak", ()), ("rms", ()), ("order", ("order",)))
    },
    "sensor_mean": ("sensor",),
    "sensor_rms": ("sensor",),
    "sensor_order": ("sensor", "order"),
    "residual": (),
}
_COMPLEX, _ERRORS = ("displacement_harmonic",), tuple(name for name in ROWS if name.startswith("transmission_error"))
# Lines of a kind reported at most: a row of each for every mesh and speed has to stay a small array.
_MAX_LINES = 32
SpeedRange = Literal["operation", "modes"]
"""``operation``: 5 to 130 % of the operating speed with the speeds at which mesh orders meet the modes.  ``modes``: a
fifth of the lowest natural or operating frequency to 1.2 times the highest."""
# Speeds of a range where nobody says how many: 200 are a smooth curve on a screen; from three mesh frequencies on each
# costs half a second and more.
_POINTS, _POINTS_OF_MANY_TONES = 200, 100
# Speeds closer than this per operating speed are one.
_SAME = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SweepTable:
    """Numbers of a sweep over P speeds.

    labels : names along every dimension but speed.  values : arrays by name, speeds last, nan where nothing was found.
    harmonics, cross_order : (P,) 0 where nothing was found.  status : (P,) text.
    minimum_force : (m, P) smallest force of every mesh row, slices apart [N].  layout : rows and lines reported.
    tones : (D,) mesh frequencies in orders of the first mesh's.
    """

    labels: Mapping[str, Sequence[Any]]
    values: Mapping[str, Array]
    harmonics: Index
    cross_order: Index
    status: NDArray[np.object_]
    minimum_force: Array

    layout: Layout
    tones: Array


def empty_table(ready: Response, count: int, *, orders: int, shafts: bool, harmonics: bool = False) -> SweepTable:
    """Empty table for `count` speeds; variables without rows (links, lines) are left out.

    orders, shafts : as of `reported_lines`.
    harmonics : with the complex motion at the orders of the first mesh frequency.
    """
    system, lines = ready.system, ready.lines
    face, dofs = faces(system.meshes), system.dofs
    reported = reported_lines(lines, lines.names(system), orders=orders, shafts=shafts)
    layout = Layout(
        axis=lines.axis[face.first],
        radius=dofs.radius,
        translation=dofs.rigid.reshape(len(dofs.bodies), 6, -1)[:, :3],
        pairs=lateral_pairs(system),
        turn=system.links.turn,
        orders=orders,
        frequencies=tuple(reported),
        groups=parallel_meshes(system.meshes),
        rounding=rounding_of(system),
        errors=system.errors,
    )
    labels: dict[str, Sequence[Any]] = {
        "mesh": face.name,
        "order": range(1, orders + 1),
        "line": tuple(reported.values()),
        "dof": dofs.names,
        "body": dofs.bodies if layout.translation.any() else (),
        "shaft": system.errors.shaft,
        "sensor": system.sensors.name,
        "link_row": system.links.name,
        "bearing": [system.links.link[x] for x in layout.pairs[:, 0]],
    }
    left_out = (*(() if harmonics else _COMPLEX), *(() if system.errors.mesh else _ERRORS))
    kept = {name: dims for name, dims in ROWS.items() if name not in left_out}
    shapes = {name: [len(labels[dim]) for dim in dims] for name, dims in kept.items()}
    return SweepTable(
        labels=labels,
        values={
            name: np.full((*shape, count), np.nan, complex if name in _COMPLEX else float)
            for name, shape in shapes.items()
            if 0 not in shape
        },
        harmonics=np.zeros(count, dtype=np.int64),
        cross_order=np.zeros(count, dtype=np.int64),
        status=np.full(count, "", dtype=object),
        minimum_force=np.full((len(system.meshes.name), count), np.nan),
        layout=layout,
        tones=np.array([float(tone / lines.tone) for tone in lines.tones]),
    )


def sweep_dataset(
    table: SweepTable, ready: Response, speed: Array, options: SweepOptions, warnings: Sequence[CodedText]
) -> xr.Dataset:
    """Dataset of a filled table at relative speeds (P,); warnings : as of `results.dataset`."""
    from ...results.dataset import dataset

    tone = float(ready.lines.tone)

    variables = {name: ((*ROWS[name], "speed"), values) for name, values in table.values.items()}
    used = {dim for dims, _ in variables.values() for dim in dims}
    coords: dict[Hashable, Any] = {dim: list(names) for dim, names in table.labels.items() if dim in used}
    coords["mesh_tone"] = ("mesh", table.tones[table.layout.axis])
    if "line" in used:
        coords["line_order"] = ("line", np.array([float(f) for f in table.layout.frequencies]) / tone)
    further = {"cross_order": ("speed", table.cross_order)} if len(table.tones) > 1 else {}
    result = dataset(
        {
            **variables,
            **(sensor_labels(ready.system.sensors)[0] if "sensor" in used else {}),
            "status": ("speed", table.status),
            "harmonics": ("speed", table.harmonics),
            **further,
        },
        {**coords, "speed": speed, "mesh_frequency": ("speed", speed * tone)},
        verb="sweep",
        options={
            **{name: getattr(options, name) for name in ("frame_speed", "shaft_orders", "orders", "tolerance")},
            **options.range_taken,
        },
        provenance=ready.system.provenance,
        warnings=warnings,
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )
    return with_bounds_named(result, len(table.tones))


def with_bounds_named(result: xr.Dataset, tones: int) -> xr.Dataset:
    """The result, its largest radial forces named a bound where mesh frequencies are several."""
    if tones > 1 and "bearing_force_peak" in result:
        result["bearing_force_peak"].attrs["long_name"] = _BOUND
    return result


def reported_lines(lines: LineExcitation, names: Sequence[str], *, orders: int, shafts: bool) -> dict[Fraction, str]:
    """At most 32 combinations of several mesh frequencies, and at most 32 shaft lines around mesh orders.

    Exact frequency, rising [Hz at the operating speed] -> label: cause, and the mesh orders it is shifted by.

    With one tone its multiples are no combinations.  If the shaft lines alone are more, all of them are reported.
    names : (D,) of the tones.  orders : highest mesh order reported.  shafts : whether shaft lines count.
    """
    labels: dict[Fraction, str] = {}
    if len(lines.tones) > 1:
        labels = _shells_up_to_limit(lines, names, [("", Fraction(0))], range(1, orders + 1))
    if shafts and lines.shaft:
        bases = [("; ".join(shaft.causes), shaft.frequency) for shaft in lines.shaft]
        labels = {**_shells_up_to_limit(lines, names, bases, range(orders + 1)), **labels}
    return dict(sorted(labels.items()))


def _shells_up_to_limit(
    lines: LineExcitation, names: Sequence[str], bases: Sequence[tuple[str, Fraction]], shells: Sequence[int]
) -> dict[Fraction, str]:
    """Labels of lines by frequency, shell after shell of orders, up to the limit; the first with lines is complete.

    A shell holds the lattice points with |a_1| + .. + |a_D| = shell.
    bases : cause and frequency [Hz at the operating speed] that the points shift; of 0 the points above it alone count.
    """
    labels: dict[Fraction, str] = {}
    for shell in shells:
        more = dict(labels)
        for point in product(range(-shell, shell + 1), repeat=len(lines.tones)):
            if sum(map(abs, point)) != shell:
                continue
            tone = sum((a * f for a, f in zip(point, lines.tones, strict=True)), Fraction(0))
            orders = [f"{a:+d} {name}" for a, name in zip(point, names, strict=True) if a]
            for cause, base in bases:
                if base + tone > 0 or (base and base + tone < 0):
                    more.setdefault(abs(base + tone), " ".join(filter(None, [cause, *orders])))
        if labels and len(more) > _MAX_LINES:
            break
        labels = more
    return labels


def speeds_of(ready: Response, options: SweepOptions) -> Array:
    """Relative speeds (P,) [1] of the mesh frequencies or relative speeds asked for, else of a range.

    Raises
    ------
    ModelError : mesh frequencies and relative speeds are given, or a range or points beside either; an unknown range.
    """
    tone, speed_range, points = float(ready.lines.tone), options.range, options.points
    if options.mesh_frequency is not None and options.relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    if not options.range_taken:
        for path, option in (("range", speed_range), ("points", points)):
            if option is not None:
                raise ModelError("goes without speeds of one's own", path=path, given=option)
        if options.relative_speed is not None:
            return np.atleast_1d(np.asarray(options.relative_speed, dtype=float))
        return np.atleast_1d(np.asarray(options.mesh_frequency, dtype=float)) / tone
    natural = frequencies_of_bodies(ready.system)
    low, high = range_ends(speed_range or "operation", tone, natural)
    if speed_range != "modes":
        tones = [float(tone) for tone in ready.lines.mesh_tones]
        return _about_operation(ready.modal, tones, points or (_POINTS_OF_MANY_TONES if len(tones) > 2 else _POINTS))
    if not natural.size:
        return np.array([1.0])
    return np.linspace(low, high, points or _POINTS) / tone


def range_ends(speed_range: SpeedRange, tone: float, natural: Array) -> tuple[float, float]:
    """Lowest and highest mesh frequency of a range [Hz].

    Parameters
    ----------
    tone : mesh frequency of the first mesh at the operating speed [Hz].  natural : as of `frequencies_of_bodies`.
    """
    if speed_range == "operation":
        return OPERATION[0] * tone, OPERATION[1] * tone
    known = [tone, *natural.tolist()]
    return 0.2 * min(known), 1.2 * max(known)


def _about_operation(modal: Modal, tones: list[float], points: int) -> Array:
    """Relative speeds (points,) [1] about operation: up to half of them where mesh orders meet the modes.

    First the operating speed, then the crossings, low orders first, then the half-power speeds either side of each;
    the others are evenly spaced.
    """
    low, high = OPERATION
    omega = np.sqrt(np.where(modal.rigid, 0.0, modal.squared))
    crossings = mesh_crossings(omega / (2 * np.pi), tones, low=low, high=high)
    by_order = np.argsort(crossings.order, kind="stable")
    speed, mode = crossings.relative_speed[by_order], crossings.mode[by_order]
    flank = speed * modal.damping[mode] / (2 * omega[mode])
    flanks = np.stack([speed - flank, speed + flank], axis=1).ravel()
    wanted = [1.0, *speed.tolist(), *flanks[(low < flanks) & (flanks < high)].tolist()]
    if points == 1:
        return np.ones(1)
    chosen = wanted[: points // 2]
    distinct: dict[int, float] = {}  # of those that are one the first alone
    for value in [*chosen, *np.linspace(low, high, points - len(chosen)).tolist()]:
        distinct.setdefault(round(value / _SAME), value)
    speeds = np.sort(list(distinct.values()))
    while len(speeds) < points:  # two of them were one
        widest = int(np.argmax(np.diff(speeds)))
        speeds = np.insert(speeds, widest + 1, (speeds[widest] + speeds[widest + 1]) / 2)
    return speeds
