"""The train as the page draws it from the front and in axial section, turning; its operation in numbers; and its load
sharing: coefficients, the hunting period, the twin whose sun floats, each deviation.

What a deviation costs is K_gamma of the train without it; all of them come from one linear map.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import OrderedDict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...limits import KGammaLimit, nearest_verdict
from ...questions.check.check import drawing
from ...questions.sharing.definitions import mesh_limits
from ...questions.sharing.sharing import SpreadSharing, spread_sharing
from ...show.drawing.bodies import Mating, Part, Stroke, bounds, drawn_train, pitch_radius, plain, polygon
from ...show.drawing.front import front_centres, front_parts, front_shapes
from ...show.drawing.section import section_shapes
from ...show.drawing.section_layout import layout_of
from ...statics.load_map import law_map, load_map
from ...statics.record import least_load
from ...statics.sample_loads import mean_loads, sample_loads
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...system.excitation import unit_lines
from ...system.system import Array, System
from ...train.train import Body, Displacement, MeshError, Train
from ..state.frames import as_overridden, largest_known, member_name, member_words, number

Shown = tuple[Any, Mapping[str, NDArray[Any]]]
"""One part as the page takes it: a table, of the modes rows; and arrays by their names within the part."""

# Torques below this part of the largest are rounding of a member that carries none.
_NO_TORQUE = 1e-9


def operation_head(train: Train, *, relative_speed: float = 1.0) -> dict[str, Any]:
    """``head["state"]`` without its time: ratio of the fastest to the slowest port, speeds [rpm] and torques [kN m].

    Parameters
    ----------
    relative_speed : speed per operating speed [1], which the speeds follow.
    """
    speed, torque = train.kinematics.speed or {}, train.kinematics.torque or {}
    carried = {body.member for body in train.bodies if body.branch is not None}
    shown = {body.member for body in train.bodies if body.kind != "body"} - carried
    largest = max((abs(value) for value in torque.values()), default=0.0)
    loaded = {member: value for member, value in torque.items() if abs(value) > _NO_TORQUE * largest}
    unit, scale = ("kN m", 1e-3) if largest >= 1e3 else ("N m", 1.0)
    ports = [abs(float(speed[member])) for member in loaded if speed.get(member)]
    return {
        "ratio": max(ports) / min(ports) if len(ports) > 1 and math.isfinite(max(ports)) else None,
        "speeds": [
            [member_name(train, member), relative_speed * float(value), "rpm"]
            for member, value in speed.items()
            if member in shown
        ],
        "torques": [[member_name(train, member), scale * value, unit] for member, value in loaded.items()],
        "relative_speed": relative_speed,
        "case": train.document.get("case", ""),
        "cases": list(cases) if isinstance(cases := train.document.get("cases"), Mapping) else [],
    }


# Drawings of the last trains that were asked for: the geometry stays while most levers move, and takes some 10 ms.
_KEPT = 8
# A radial support below this is none [N/m]; the softest gear coupling is a hundred thousand times stiffer.
_FLOATS = 1.0


class _Drawing(NamedTuple):
    """The drawing of a train: its bodies and meshes, those drawn below the axis of the section, its display lists."""

    part: Mapping[str, Part]
    meshes: Sequence[Mating]
    below: Collection[str]
    lists: Mapping[str, str]


_drawings: OrderedDict[str, _Drawing] = OrderedDict()


def train_head(
    train: Train, labels: Mapping[str, str], mesh_labels: Mapping[str, str], *, relative_speed: float = 1.0
) -> dict[str, Any]:
    """``head["train"]``: bodies and meshes with what is told of them, and the display lists that the page paints.

    Lengths in [mm], speeds in [rad/s].  ``drawing`` has the lists of ``front`` and ``section`` with their ``bounds``,
    each as the text of its JSON, which is made once, and a ``key`` that is another one where they are.

    Parameters
    ----------
    labels : of the bodies.  mesh_labels : of the meshes.  relative_speed : speed per operating speed [1].
    """
    drawn = _drawing(train)
    number = {body.name: i for i, body in enumerate(train.bodies)}
    alike = list(dict.fromkeys((mesh.pair, mesh.side) for mesh in train.meshes))
    return {
        "title": train.title,
        "bodies": [_body(train, body, drawn, labels[body.name], relative_speed) for body in train.bodies],
        "meshes": [
            {
                "name": mesh.name,
                "label": mesh_labels[mesh.name],
                "bodies": [number[mesh.a], number[mesh.b]],
                # its colour in every chart: a hue a branch, as of the figures, darker by pair of gears and side
                "hue": (mesh.branch or 0) - 1,
                "shade": alike.index((mesh.pair, mesh.side)) / len(alike),
            }
            for mesh in train.meshes
        ],
        "drawing": drawn.lists,
    }


def _drawing(train: Train) -> _Drawing:
    """The drawing of a train, kept while its geometry stays."""
    floating = {body.name for body in train.bodies if _floats(train, body)}
    geometry = repr((_geometry(train), sorted(floating)))
    if geometry in _drawings:
        _drawings.move_to_end(geometry)
        return _drawings[geometry]
    table = drawing(train)
    drawn = drawn_train(table)
    found, layout = front_parts(drawn, behind=True), layout_of(table, drawn)
    bodies = {body.name: i for i, body in enumerate(train.bodies)}
    meshes = {mesh.name: i for i, mesh in enumerate(train.meshes)}
    front = [*front_shapes(drawn, found), *front_centres(found, floating)]
    section = section_shapes(drawn, layout)
    ends = bounds(section)
    section.append(Stroke(role="axis", contours=(polygon(*ends[:2]),)))
    _drawings[geometry] = _Drawing(
        part={part.name: part for part in drawn.parts},
        meshes=drawn.meshes,
        below={body.name for one in layout.columns for group in one.groups if group.half < 0 for body in group.bodies},
        lists={
            "key": hashlib.blake2b(geometry.encode(), digest_size=8).hexdigest(),
            "front": json.dumps({**plain(front, bodies, meshes), "bounds": bounds(front)}),
            "section": json.dumps({**plain(section, bodies, meshes), "bounds": ends}),
        },
    )
    while len(_drawings) > _KEPT:
        _drawings.popitem(last=False)
    return _drawings[geometry]


def _floats(train: Train, body: Body) -> bool:
    """Whether nothing but meshes holds a gear on the axis radially."""
    supports = [link for link in train.links if link.kind == "support" and link.first == body.name]
    central = body.gear is not None and body.branch is None
    return central and bool(supports) and all(max(link.stiffness[:2]) <= _FLOATS for link in supports)


def _geometry(train: Train) -> str:
    """What the drawing of a train depends on, as a text: numbers that are not given are equal to each other there."""
    speed, torque = train.kinematics.speed or {}, train.kinematics.torque or {}
    bodies = [
        (
            *(body.name, body.member, body.kind, body.frame, body.carried_by, body.branch, body.side, body.centre),
            *(body.station, body.angle, body.outer_radius, body.gear),
            *(_sign(float(speed.get(body.member, math.nan))), _sign(torque.get(body.member, 0.0))),
            # the size of a plain body is that of an equal disc
            body.inertia / body.mass if body.gear is None and body.mass else 0.0,
        )
        for body in train.bodies
    ]
    meshes = [
        (mesh.name, mesh.a, mesh.b, mesh.direction, mesh.pressure_angle, mesh.flank, mesh.lead) for mesh in train.meshes
    ]
    links = [
        (
            *(link.name, link.kind, link.first, link.second, link.station),
            *(_sign(k) + math.isinf(k) for k in link.stiffness),
        )
        for link in train.links
    ]
    return repr((bodies, meshes, links))


def _sign(value: float) -> int:
    """-1, 0 or 1; 2 of what is not a number."""
    return 2 if math.isnan(value) else (value > 0) - (value < 0)


def _mm(value: float) -> float:
    """A length in [mm], rounded to what a screen shows."""
    return round(1e3 * value, 4)


def _body(train: Train, body: Body, drawn: _Drawing, label: str, relative_speed: float) -> dict[str, Any]:
    """What is told of a body, and how it moves: about its own axis, with its carrier, in the plane of the section."""
    part, kinematics = drawn.part[body.shaft_of or body.name], train.kinematics
    rpm = (kinematics.speed or {}).get(body.member)
    carrier_rpm = (kinematics.frame_speed or {}).get(body.frame) if body.carried_by else None
    mesh = next((one for one in drawn.meshes if body.name in (one.a, one.b)), None)
    pins = [other for other in drawn.part.values() if other.carried_by == body.name]
    beside = [other for other in drawn.part.values() if other.stage == part.stage and other.branch]
    plane = next((math.atan2(one.y, one.x) for one in (part, *beside) if one.branch), math.pi / 2)
    bends = body.elastic or body.reduced
    return {
        "name": body.name,
        "label": label,
        "teeth": part.form.teeth if part.form else None,
        "pitch": _mm(pitch_radius(part, mesh)) if part.form else None,
        "speed": 0.0 if rpm is None else relative_speed * float(rpm) * math.pi / 30,
        # of the centre of a carried body about the axis of its stage, and where that stands
        "orbit": 0.0 if carrier_rpm is None else relative_speed * (float(carrier_rpm) * math.pi / 30),
        "axis": _mm(part.offset),
        "floating": _floats(train, body),
        "held": body.member in kinematics.held,
        # of a mode shape: radius that turns its arcs into angles, angle of the plane that the section shows
        "arc": _mm(pitch_radius(part, mesh) if part.form else pins[0].radius if pins else part.outer) or 1.0,
        "plane": round(plane + (math.pi if body.name in drawn.below else 0.0), 6),
        # names of the coordinates by which it bends
        **({} if bends is None else {"bends": list(bends.names)}),
    }


# load sharing ---------------------------------------------------------------------------------------------------------

# What is shown of a list that nobody reads to its end.
_MOST = 12
# Above 1 a K_gamma this close to it is 1; a share below the second is rounding of it.
_NONE, _ROUNDING = 1e-9, 1e-6
# Causes of deviations in words, where these are others.
_WORDS = {"run_out": "run-out", "bearing_run_out": "bearing run-out", "errors": "turning error"}


def error_view(train: Train, system: System, overrides: Mapping[str, object]) -> Shown | None:
    """``head["errors"]`` and its arrays, the deviations that cost most first; None without deviations that count.

    ``share`` (row,) of what K_gamma is above 1 that goes with the deviation [%], ``turning`` the same of the largest
    over the hunting period [%], ``without`` (row,) K_gamma without it [1].  What follows the mesh frequency, at a
    multiple of it above zero, is no part of K_gamma.  overrides : whose spelling of a path counts.

    Raises
    ------
    ModelError, ConvergenceError : no load, or a load without equilibrium.
    """
    groups: dict[str, list[Displacement | MeshError]] = {}
    deviations: list[Displacement | MeshError] = [*train.displacements, *train.mesh_errors]
    for item in deviations:
        at_mesh_order = any((item.frequency / tone).denominator == 1 for tone in set(system.tones) if item.frequency)
        size = abs(item.amplitude) if isinstance(item, MeshError) else np.abs(item.vector).max(initial=0.0)
        if item.cause != "contact" and not at_mesh_order and size > 0:
            groups.setdefault(item.path, []).append(item)
    if not groups:
        return None
    items = [item for group in groups.values() for item in group]
    columns = unit_lines(train, items)
    train_map = load_map(linear(system), columns)
    laws = law_map(system, columns) if system.groups else None
    factors = np.zeros((1 + len(groups), len(items)))
    factors[
        np.repeat(1 + np.arange(len(groups)), [len(group) for group in groups.values()]), np.arange(len(items))
    ] = -1
    loads = sample_loads(train_map, factors, laws=laws)
    k, k_turning = np.array([[largest_known(values) for values in sample] for sample in loads.k]).T
    is_turning = not k[0] > 1 + _NONE  # nothing stands still that would part the load: the turning K_gamma ranks
    ranked = k_turning if is_turning else k
    share, turning = _share(ranked), _share(k_turning)
    order = np.lexsort((-turning, -share))[:_MOST]
    arrays = {"share": share[order], "turning": turning[order], "without": ranked[1:][order]}
    rows = []
    for row, path in enumerate(np.array(list(groups))[order].tolist()):
        said = {"label": _label(train, groups[path]), "path": as_overridden(path, overrides)}
        rows.append({**said, **{name: float(values[row]) for name, values in arrays.items()}})
    of = "K_gamma while turning" if is_turning else "mean-load K_gamma"
    return {"rows": rows, "of": of, "k_gamma": float(ranked[0])}, arrays


def _label(train: Train, group: Sequence[Displacement | MeshError]) -> str:
    """A deviation in words with its size: ``pin position of planet 1, 20 um``."""
    first = group[0]
    word = _WORDS.get(first.cause, first.cause.replace("_", " "))
    unit = "um"
    if isinstance(first, MeshError):
        mesh = next(mesh for mesh in train.meshes if mesh.name == first.mesh)
        stage = f"{mesh.stage} " if len(train.planets) > 1 else ""
        whose = f"{word} of {stage}{mesh.pair.rpartition('.')[2]}"
    else:
        bodies = {body.name: body for body in train.bodies}
        bearers = [bodies[item.body] for item in group if isinstance(item, Displacement)]
        branches = sorted({body.branch for body in bearers if body.branch is not None})
        pin = "pin " if bearers[0].kind == "planet" and first.cause == "position" else ""
        member = member_words(train, bearers[0].member, branches)
        # all of a member are "the planets", some of them "planets 1, 2"
        whose = f"{pin}{word} of {'' if member[-1].isdigit() else 'the '}{member}"
        if np.any(first.vector[3:]) and not np.any(first.vector[:3]):
            unit = "urad"
    sizes = sorted({float(number(_length(item))) for item in group})
    size = " to ".join(number(value) for value in dict.fromkeys((sizes[0], sizes[-1])))
    return f"{whose}, {size} {unit}"


def _length(item: Displacement | MeshError) -> float:
    """Length of a deviation [um, urad]: radius of what turns, length of what stands still."""
    if isinstance(item, MeshError):
        return 1e6 * abs(item.amplitude)
    vector = item.vector[:3] if np.any(item.vector[:3]) else item.vector[3:]
    # of a turning vector (1, -i) r the radius is that of either component
    length = np.abs(vector).max() if item.frequency != 0 else float(np.linalg.norm(vector))
    return 1e6 * float(length)


def _share(k: Array) -> Array:
    """Share of K_gamma above 1 that goes with each deviation, (E,) [%]; 0 where there is none.

    k : (1 + E,) K_gamma of the train as it is, then without each [1].
    """
    above = k[0] - 1
    share = np.nan_to_num((k[0] - k[1:]) / above) if above > _NONE else np.zeros(len(k) - 1)
    return np.where(np.abs(share) < _ROUNDING, 0.0, 100 * share)


# Parts of the hunting period that are drawn, each by the largest ratio in it: a strip is some 500 pixels wide.
_PARTS = 256
# Support of a sun below this part of its stiffest mesh is a float.
_SOFT = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class SharingView:
    """Load sharing of w whole meshes.

    coefficient, turning : (w,) N F_i / sum F without mesh-frequency content, and the largest of that over the hunting
        period [1], nan of meshes without load.
    over_period : (w, parts) largest ratio b in each part of the hunting period [1].  load : (w,) mean force over the
        mean of its parallel meshes [1].  limits : (w,) of K_gamma.  spread : cycles that it comes from.
    whole : whether no longer record follows.
    """

    spread: SpreadSharing
    limits: tuple[KGammaLimit, ...]
    coefficient: Array
    turning: Array
    over_period: Array
    load: Array
    whole: bool = False


class Twin(NamedTuple):
    """The same train with the radial support of a sun taken away, or, where it floats, made rigid.

    head : ``head["sharing"]["twin"]``: ``label`` in words, ``stage`` whose sun, ``path`` and ``value`` of the override
    that makes the model so, ``k_gamma`` and ``k_gamma_turning``.  train, system : of it.  coefficient : (w,) as of
    `SharingView` [1].
    """

    head: Mapping[str, Any]
    train: Train
    system: System
    coefficient: Array


def live_sharing(system: System, *, patience: float = 0.1) -> SharingView:
    """Load sharing at rest from spread mesh cycles; patience : as of `spread_sharing` [s].

    Raises
    ------
    ModelError : no load, or what the static method raises.  ConvergenceError : no equilibrium.
    """
    spread = spread_sharing(system, patience=patience)
    coefficient, turning = spread.mean_load[0], spread.mean_load[1]
    parts = int(np.clip(min(spread.ratio.shape[1] // 4, spread.period), 1, _PARTS))  # as many as have some cycles each
    # the mean over the hunting period is exact, that of a few cycles stands in where it is not known
    load, least = np.array(coefficient), float(least_load(spread.mean, most=spread.mean, rounding=0.0))
    for group in spread.groups:
        total = float(spread.mean[group].mean())
        if total > least:
            load[group] = np.where(np.isnan(coefficient[group]), spread.mean[group] / total, coefficient[group])
    limits, over_period = tuple(mesh_limits(system, None)), spread.over_period(parts)
    return SharingView(spread, limits, coefficient, turning, over_period, load)


def sharing_head(view: SharingView, twin: Twin | None, train: Train, labels: Mapping[str, str]) -> Shown:
    """``head["sharing"]``, and its arrays ``coefficient``, ``turning``, ``over_period`` and ``twin``.

    labels : of the meshes.
    """
    pair = {mesh.name: mesh.pair.rpartition(".")[2] for mesh in train.meshes}
    verdict = nearest_verdict(view.spread.mesh, view.coefficient.tolist(), view.limits, assumed=train.assumed)
    head = {
        "definition": "mean-load",
        "stage": "whole" if view.whole else "at rest",
        "rows": [
            {"label": labels.get(name, name), "mesh": row, "pair": pair.get(name, "")}
            for row, name in enumerate(view.spread.mesh)
        ],
        "k_gamma": largest_known(view.coefficient),
        "k_gamma_turning": largest_known(view.turning),
        "verdict": None if verdict is None else {**verdict._asdict(), "passes": verdict.passes},
        "cycles": view.spread.period,
        "twin": None if twin is None else twin.head,
    }
    arrays = {name: getattr(view, name) for name in ("coefficient", "turning", "over_period")}
    return head, arrays if twin is None else {**arrays, "twin": twin.coefficient}


def twin_of(train: Train, view: SharingView) -> Twin | None:
    """The twin of a train: with a floating sun, or, where it floats, with a rigid support of it.

    The sun is that of the stage with the largest coefficient that has one.  None without a sun, and where the twin has
    no equilibrium, as of a sun that only its support holds.
    """
    suns = {body.frame: body.member for body in reversed(train.bodies) if body.kind == "sun" and body.gear is not None}
    stage_of = {mesh.name: mesh.stage for mesh in train.meshes}
    loaded = [
        (value, stage_of[name])
        for name, value in zip(view.spread.mesh, view.coefficient, strict=True)
        if stage_of.get(name) in suns and value > 0
    ]
    if not loaded:
        return None
    stage = max(loaded, key=lambda pair: pair[0])[1]
    changed, floats = twin_train(train, stage)
    if changed is None:
        return None
    try:
        system = assemble(changed)
        coefficient, turning = np.where(np.isnan(view.coefficient), np.nan, mean_loads(system))
    except (ModelError, ConvergenceError):
        return None
    where = f" of {stage}" if len(train.planets) > 1 else ""
    head = {
        "label": f"with a {'supported' if floats else 'floating'} sun{where}",
        "k_gamma": largest_known(coefficient),
        "k_gamma_turning": largest_known(turning),
        "stage": stage,
        "path": f"stages.{suns[stage]}.support.radial",
        "value": "inf" if floats else 0,
    }
    return Twin(head=head, train=changed, system=system, coefficient=coefficient)


def twin_train(train: Train, stage: str) -> tuple[Train | None, bool]:
    """A train whose sun of a stage has no radial support, or a rigid one where it has none; and whether it has none.

    None where nothing but a shaft or coupling could be taken away.
    """
    suns = {body.name for body in train.bodies if body.frame == stage and body.kind == "sun"}
    supports = {link.name: link for link in train.links if link.kind == "support" and link.first in suns}
    if not supports:
        return None, False
    stiffest = max((mesh.stiffness for mesh in train.meshes if mesh.stage == stage), default=1.0)
    floats = all(max(link.stiffness[:2]) <= _SOFT * stiffest for link in supports.values())
    radial = float("inf") if floats else 0.0
    for name, link in supports.items():  # free or rigid, hence without a law or a damper there
        supports[name] = replace(
            link,
            stiffness=(radial, radial, *link.stiffness[2:]),
            damping=(0.0, 0.0, *link.damping[2:]),
            clearance=0.0,
            exponent=1.0,
            curves=tuple(curve for curve in link.curves if curve[0] > 1),
        )
    return replace(train, links=tuple(supports.get(link.name, link) for link in train.links)), floats
