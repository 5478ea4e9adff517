"""The display list of a train: plain shapes in [mm] that the report and the page paint alike.  No plotly.

A shape has a role, by which a painter chooses its look, and points x + iy about a place of its own, turned about it: a
painter that moves a body moves and turns the shapes that name it.

Behind the list stand the bodies that drawings read of the Dataset of `check`, stages set side by side.  Teeth
are to scale: involute flanks of a gear, and the turn of each gear at which the teeth really mesh.  All lengths [m],
angles [rad]; a tooth is described by the half angle it takes at each radius, seen from the axis.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..series import numbers, texts

Points = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A line through points (k,) [mm], drawn so many times around its origin; without points a circle of a radius."""

    points: Points
    times: int = 1
    radius: float = 0.0


def polygon(*points: complex, times: int = 1) -> Contour:
    """A contour through points [mm], so many times around its origin."""
    return Contour(np.array(points, dtype=np.complex128), times=times)


def circle(radius: float) -> Contour:
    """A circle about the origin; radius [mm]."""
    return Contour(np.zeros(0, dtype=np.complex128), radius=radius)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnShape:
    """What all shapes have: what it is, and where [mm, rad].

    kind : of its body, for its colour.  body : with which it moves.  meshes : by name, whose force colours it.
    hover : what is said under a pointer.  room : radius in which a symbol or text has to fit [mm].
    """

    role: str
    kind: str = ""
    body: str = ""
    meshes: tuple[str, ...] = ()
    at: complex = 0j
    turn: float = 0.0
    hover: str = ""
    room: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Area(DrawnShape):
    """Filled between its contours, even and odd, each of which is one closed line."""

    contours: tuple[Contour, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stroke(DrawnShape):
    """Lines, one for each time of each contour."""

    contours: tuple[Contour, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symbol(DrawnShape):
    """A symbol of a size on the screen, as its role has it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Text(DrawnShape):
    """A text of so many pixels, at its place by `anchor` (across, up), moved by `shift` [px].

    upright : written upwards.  backing : ``white``, or the kind of body in whose tint it stands.
    """

    text: str
    size: float = 12
    anchor: tuple[str, str] = ("center", "middle")
    shift: tuple[float, float] = (0.0, 0.0)
    upright: bool = False
    backing: str = ""


def lines_of(shape: Area | Stroke) -> list[Points]:
    """Lines of a shape where it stands, each (k,) [mm]; of an area one closed line for each contour."""
    found: list[Points] = []
    for one in shape.contours:
        points = one.points if one.points.size else one.radius * np.exp(1j * np.linspace(0, 2 * math.pi, 121))
        turns = np.exp(1j * (shape.turn + 2 * math.pi * np.arange(one.times) / one.times))
        lines = shape.at + turns[:, None] * points
        found += [np.append(lines, lines[0, 0])] if isinstance(shape, Area) else list(lines)
    return found


def bounds(shapes: Sequence[DrawnShape]) -> list[float]:
    """Ends of a display list without its texts [mm]: x0, x1, y0, y1."""
    symbols = np.array([shape.at for shape in shapes if isinstance(shape, Symbol)], dtype=np.complex128)
    lines = (line for shape in shapes if isinstance(shape, Area | Stroke) for line in lines_of(shape))
    points = np.concatenate([symbols, *lines])
    if not points.size:
        return [-1.0, 1.0, -1.0, 1.0]
    ends = (points.real.min(), points.real.max(), points.imag.min(), points.imag.max())
    return [round(float(end), 3) for end in ends]


def plain(shapes: Iterable[DrawnShape], bodies: Mapping[str, int], meshes: Mapping[str, int]) -> dict[str, Any]:
    """A display list as JSON: ``contours``, each once, and ``shapes``, which name those they are made of by number.

    A contour is ``[times, radius, x, y, x, y, ...]``.

    Parameters
    ----------
    bodies, meshes : number of each by name.
    """
    known: dict[tuple[float, ...], int] = {}
    rows = []
    for shape in shapes:
        row: dict[str, Any] = {"type": type(shape).__name__.lower(), "role": shape.role, "kind": shape.kind}
        row["at"] = [round(shape.at.real, 3), round(shape.at.imag, 3), round(shape.turn, 6)]
        row |= {"body": bodies[shape.body]} if shape.body else {}
        row |= {"meshes": [meshes[name] for name in shape.meshes]} if shape.meshes else {}
        row |= {"room": round(shape.room, 3)} if shape.room else {}
        row |= {"text": shape.text} if isinstance(shape, Text) else {}
        if isinstance(shape, Area | Stroke):
            row["contours"] = [known.setdefault(_numbers(one), len(known)) for one in shape.contours]
        rows.append(row)
    return {"contours": [list(one) for one in known], "shapes": rows}


def _numbers(contour: Contour) -> tuple[float, ...]:
    """A contour as numbers, lengths to a micrometre."""
    ends = [end for point in contour.points.tolist() for end in (point.real, point.imag)]
    return (contour.times, round(contour.radius, 3), *(round(end, 3) + 0.0 for end in ends))  # without -0.0


Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothForm:
    """Radii of a gear and half the angle of a tooth at the base circle (of a ring: what it tends to there)."""

    teeth: int
    internal: bool
    base_radius: float
    reference_radius: float
    tip_radius: float
    root_radius: float
    base_half_angle: float

    @property
    def inward(self) -> int:
        """-1 of a ring, whose teeth point to the axis, else 1."""
        return -1 if self.internal else 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Mating:
    """One mesh as the drawing needs it: gears by name, polar angle of the pitch point, working angle, loaded flank."""

    name: str = ""
    a: str
    b: str
    direction: float
    pressure_angle: float
    flank: int
    sigma: float = 0.0


def tooth_form(
    *,
    teeth: int,
    internal: bool,
    base_radius: float,
    reference_radius: float,
    tip_radius: float,
    root_radius: float,
    profile_shift: float,
    pressure_angle: float,
) -> ToothForm:
    """Tooth form from the data of a gear; tips and roots that are not given are drawn for standard proportions.

    Parameters
    ----------
    radii [m], nan where not given; pressure_angle : normal [rad].
    """
    normal = pressure_angle if np.isfinite(pressure_angle) else math.radians(20)
    reference = reference_radius if np.isfinite(reference_radius) else base_radius / math.cos(normal)
    module, inward = 2 * reference / teeth, -1 if internal else 1
    transverse = math.acos(min(base_radius / reference, 1.0)) if base_radius < reference else normal
    half = (math.pi / 2 + 2 * (profile_shift if np.isfinite(profile_shift) else 0.0) * math.tan(normal)) / teeth
    return ToothForm(
        teeth=teeth,
        internal=internal,
        base_radius=base_radius,
        reference_radius=reference,
        tip_radius=tip_radius if np.isfinite(tip_radius) else reference + inward * module,
        root_radius=root_radius if np.isfinite(root_radius) else reference - inward * 1.25 * module,
        base_half_angle=half + inward * _involute(transverse),
    )


def half_angle(form: ToothForm, radius: Array | float) -> Array:
    """Half the angle of a tooth at a radius: psi_b - inv alpha(r), of a ring psi_b + inv alpha(r).

    Below the base circle there is no involute: the flank is drawn radial.
    """
    alpha = np.arccos(np.minimum(form.base_radius / np.asarray(radius, dtype=np.float64), 1.0))
    half = form.base_half_angle - form.inward * (np.tan(alpha) - alpha)
    return np.clip(half, 0.03 * math.pi / form.teeth, 0.97 * math.pi / form.teeth)


def tooth_path(form: ToothForm, *, points: int = 4) -> Contour:
    """One tooth about the x axis of its gear, with so many points on each flank; the outline is made of all of them."""
    low = form.root_radius if form.internal else max(form.root_radius, min(form.base_radius, form.tip_radius))
    radii = np.linspace(low, form.tip_radius, points)
    if not form.internal and form.root_radius < low:
        radii = np.concatenate([[form.root_radius], radii])
    flank = 1e3 * radii * np.exp(1j * half_angle(form, radii))
    return Contour(np.concatenate([flank.conj(), flank[::-1]]), times=form.teeth)


def rotations(forms: Mapping[str, ToothForm], matings: Sequence[Mating]) -> dict[str, float]:
    """Polar angle of one tooth centre of every gear, such that teeth meet in every mesh that the train can close.

    The first gear of the first mesh is placed by its `sigma` (place of the contact from the pitch point, base
    pitches); every further gear by the mesh through which it is reached.  Gears in no mesh stand at 0.
    """
    placed: dict[str, float] = {}
    waiting = [mating for mating in matings if mating.a in forms and mating.b in forms]
    while waiting:
        mating = next((one for one in waiting if one.a in placed or one.b in placed), waiting[0])
        waiting.remove(mating)
        a, b = forms[mating.a], forms[mating.b]
        if mating.a not in placed and mating.b not in placed:
            placed[mating.a] = _turn_of_a(a, mating, mating.sigma)
        if mating.b not in placed:
            sigma = mating.flank * a.teeth / (2 * math.pi) * (placed[mating.a] - _turn_of_a(a, mating, 0.0))
            placed[mating.b] = _turn_of_b(b, mating, sigma)
        elif mating.a not in placed:
            turn = placed[mating.b] - _turn_of_b(b, mating, 0.0)
            sigma = -b.inward * mating.flank * b.teeth / (2 * math.pi) * turn
            placed[mating.a] = _turn_of_a(a, mating, sigma)
    return {name: placed.get(name, 0.0) for name in forms}


def _involute(angle: float) -> float:
    return math.tan(angle) - angle


def _pitch_half_angle(form: ToothForm, mating: Mating) -> float:
    return form.base_half_angle - form.inward * _involute(mating.pressure_angle)


def _turn_of_a(form: ToothForm, mating: Mating, sigma: float) -> float:
    turned = 2 * math.pi * mating.flank * sigma / form.teeth
    return mating.direction - mating.flank * _pitch_half_angle(form, mating) + turned


def _turn_of_b(form: ToothForm, mating: Mating, sigma: float) -> float:
    half, turned = _pitch_half_angle(form, mating), 2 * math.pi * mating.flank * sigma / form.teeth
    opposite = 0.0 if form.internal else math.pi
    return mating.direction + opposite - form.inward * (mating.flank * half + turned)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One body; lengths [m], angles [rad], speed [rpm], torque [N m]; nan where the model says nothing.

    x, y : centre in frame axes.  offset : what the drawing adds to x so that stages stand side by side.
    angle : polar angle of its own x axis.  outer : outer radius as drawn.  reach : R of u = R rz.
    width : of one helix.  hand : of the left helix.
    """

    name: str
    member: str
    kind: str
    stage: str
    branch: int
    side: str
    carried_by: str
    x: float
    y: float
    station: float
    angle: float
    outer: float
    reach: float
    speed: float
    mass: float
    torque: float = math.nan
    form: ToothForm | None = None
    width: float = math.nan
    gap: float = 0.0
    herringbone: bool = False
    helix_angle: float = 0.0
    hand: int = 0
    offset: float = 0.0

    @property
    def short(self) -> str:
        """``main/planet/2/left`` -> ``planet 2``."""
        word = self.member.split(".")[-1]
        return f"{word} {self.branch}" if self.branch else word

    @property
    def place(self) -> str:
        """What it is drawn with: its stage; a body without teeth that carries nothing stands by itself."""
        return self.name if self.kind == "body" and self.form is None else self.stage

    @property
    def centre(self) -> complex:
        """Place of its centre in the front view, x + iy [mm]."""
        return 1e3 * complex(self.x + self.offset, self.y)

    @property
    def radius(self) -> float:
        """Distance of its centre from the axis of the stage [m]."""
        return math.hypot(self.x, self.y)


class DrawnTrain(NamedTuple):
    """What the drawings read of the Dataset of `check`: bodies, meshes, and the bodies that do not turn by name."""

    parts: Sequence[Part]
    meshes: Sequence[Mating]
    still: frozenset[str]


def drawn_train(check: xr.Dataset) -> DrawnTrain:
    """A train as it is drawn.

    Parameters
    ----------
    check : Dataset of `check`: what `parts` and `matings` read (body), (gear), (mesh); link_first, link_second (link),
        link_stiffness (link, direction) [N/m, N m/rad].
    """
    # without speed, or held by the housing about its axis
    still = {
        name for name, speed in zip(texts(check, "body"), numbers(check, "speed", "body"), strict=True) if speed == 0
    }
    if "link" in check.dims:
        rigid = np.isinf(check["link_stiffness"].sel(direction="rz").values)
        ends = zip(texts(check, "link_first"), texts(check, "link_second"), rigid, strict=True)
        still |= {first for first, second, fixed in ends if fixed and not second}
    return DrawnTrain(parts(check), matings(check), frozenset(still))


def parts(check: xr.Dataset) -> list[Part]:
    """Every body of the train, in order, stages side by side."""
    return _side_by_side(_resolved(_fitted(_bodies(check), matings(check))))


def stages(found: Sequence[Part]) -> list[str]:
    """Stages that have gears, in order."""
    return list(dict.fromkeys(part.stage for part in found if part.form is not None))


def one_per_place(found: Sequence[Part]) -> list[Part]:
    """Bodies without those that lie behind an equal one in a front view (the right half of a split member)."""
    seen: dict[tuple[str, str, int], Part] = {}
    for part in found:
        seen.setdefault((part.stage, part.member, part.branch), part)
    return list(seen.values())


def faces(part: Part) -> list[tuple[float, float, int]]:
    """Axial extent of each helix of a gear and its hand: (from, to, hand), stations [m]."""
    half = part.width / 2
    if not part.herringbone:
        return [(part.station - half, part.station + half, part.hand)]
    middle = (part.width + part.gap) / 2
    left, right = part.station - middle, part.station + middle
    return [(left - half, left + half, part.hand), (right - half, right + half, -part.hand)]


def matings(check: xr.Dataset) -> list[Mating]:
    """Every mesh of the train, with the place of its contact at time zero."""
    if "gear_a" not in check.variables:
        return []
    columns = [numbers(check, name, "mesh").tolist() for name in ("mesh_direction", "working_pressure_angle", "flank")]
    leads, senses = np.nan_to_num(numbers(check, "phase_lead", "mesh")).tolist(), _senses(check)
    names = (texts(check, name, "mesh") for name in ("mesh", "gear_a", "gear_b"))
    rows = zip(*names, *columns, leads, senses, strict=True)
    return [
        Mating(name=name, a=a, b=b, direction=e, pressure_angle=alpha, flank=int(d), sigma=sense * lead)
        for name, a, b, e, alpha, d, lead, sense in rows
    ]


def pitch_radius(part: Part, mating: Mating | None = None) -> float:
    """Working pitch radius of a gear in a mesh; its reference radius without one or its angle [m]."""
    if part.form is None:
        return 0.0
    known = mating is not None and math.isfinite(mating.pressure_angle)
    return part.form.base_radius / math.cos(mating.pressure_angle) if mating and known else part.form.reference_radius


def _senses(check: xr.Dataset) -> list[int]:
    """+1 where the first gear of a mesh drives in its frame, else -1; +1 without speeds."""
    speed = dict(zip(texts(check, "body"), numbers(check, "speed", "body"), strict=True))
    frames = zip(texts(check, "body_stage", "body"), texts(check, "kind", "body"), speed.values(), strict=True)
    carrier = {stage: value for stage, kind, value in frames if kind == "carrier"}
    ends = zip(texts(check, "gear_a"), texts(check, "mesh_stage", "mesh"), numbers(check, "flank", "mesh"), strict=True)
    return [-1 if d * (speed.get(a, math.nan) - carrier.get(stage, 0.0)) < 0 else 1 for a, stage, d in ends]


# Field of a part -> variable over the bodies.
_WORDS = {
    **{"name": "body", "member": "member", "kind": "kind"},
    **{"stage": "body_stage", "side": "side", "carried_by": "carried_by"},
}
_NUMBERS = {
    **{"branch": "branch", "x": "centre_x", "y": "centre_y", "station": "station", "angle": "axes_angle"},
    **{"outer": "outer_radius", "reach": "outer_radius", "speed": "speed", "mass": "mass", "torque": "torque"},
}


def _bodies(check: xr.Dataset) -> list[Part]:
    gears, columns = _gears(check), dict[str, list[Any]]()
    for field, name in _WORDS.items():
        columns[field] = texts(check, name, "body")
    for field, name in _NUMBERS.items():
        columns[field] = numbers(check, name, "body").tolist()
    columns["branch"] = np.nan_to_num(columns["branch"]).astype(int).tolist()
    columns["member"] = [member or name for member, name in zip(columns["member"], columns["name"], strict=True)]
    bodies = [Part(**dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]
    return [_toothed(body, gears[body.name]) if body.name in gears else body for body in bodies]


def _gears(check: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Values of every gear by variable; plain ones, for `check.sel` takes a millisecond a gear."""
    if "gear" not in check.dims:
        return {}
    columns = {str(name): one.values for name, one in check.variables.items() if one.dims == ("gear",)}
    return {str(name): {key: own[i] for key, own in columns.items()} for i, name in enumerate(check["gear"].values)}


def _toothed(body: Part, row: Mapping[str, Any]) -> Part:
    def value(name: str, default: float = math.nan) -> float:
        return float(row[name]) if name in row else default

    given = ("base_radius", "reference_radius", "tip_radius", "root_radius", "pressure_angle", "profile_shift")
    internal = bool(row.get("internal", False))
    form = tooth_form(teeth=int(row["teeth"]), internal=internal, **{name: value(name) for name in given})
    return replace(
        body,
        form=form,
        reach=form.base_radius,
        outer=_outer(form, body.outer),
        width=value("face_width"),
        gap=float(np.nan_to_num(value("gap", 0.0))),
        herringbone=bool(row.get("herringbone", False)),
        helix_angle=float(np.nan_to_num(value("helix_angle", 0.0))),
        hand=int(np.nan_to_num(value("hand", 0.0))),
    )


def _outer(form: ToothForm, given: float) -> float:
    if not form.internal:
        return form.tip_radius
    rim = form.root_radius + 2 * abs(form.root_radius - form.tip_radius) / 2.25
    return given if given > 1.01 * form.root_radius else rim


# Of the centre distance: pitch radii that miss it by more are not those of the teeth that mesh.
_APART = 0.03


def _fitted(found: list[Part], meshes: Sequence[Mating]) -> list[Part]:
    """Gears whose pitch circles do not touch are drawn by their teeth and their centre distance.

    A published train may give tooth counts and a centre distance beside radii that belong to neither.
    """
    place = {part.name: part for part in found}
    factors: dict[str, float] = {}
    for one in meshes:
        a, b = place.get(one.a), place.get(one.b)
        if a is None or b is None or a.form is None or b.form is None:
            continue
        sign = b.form.inward
        distance = math.hypot(a.x - b.x, a.y - b.y)
        if abs(abs(pitch_radius(a, one) + sign * pitch_radius(b, one)) - distance) > _APART * distance > 0:
            per_tooth = distance / abs(a.form.teeth + sign * b.form.teeth)
            for part, form in ((a, a.form), (b, b.form)):
                factors.setdefault(part.name, per_tooth * form.teeth / pitch_radius(part, one))
    return [
        replace(part, form=_scaled(part.form, factor), outer=factor * part.outer)
        if part.form and (factor := factors.get(part.name))
        else part
        for part in found
    ]


def _scaled(form: ToothForm, factor: float) -> ToothForm:
    radii = ("base_radius", "reference_radius", "tip_radius", "root_radius")
    return replace(form, **{name: factor * getattr(form, name) for name in radii})


def _resolved(found: list[Part]) -> list[Part]:
    """Carriers get the pin radius as R and a size that holds their pins; widths not given a drawn one."""
    widths = [part.width for part in found if np.isfinite(part.width)]
    radii = [part.form.reference_radius for part in found if part.form is not None and not part.form.internal]
    drawn = max(widths, default=0.5 * min(radii, default=1.0))
    gears = [part.radius + part.outer for part in found if part.form is not None]
    largest = max(gears or [part.outer for part in found if np.isfinite(part.outer)], default=1.0)
    result = []
    for part in found:
        pins = [other for other in found if other.carried_by == part.name]
        reach = pins[0].radius if pins else part.reach
        sizes = [pin.radius + 0.35 * (pin.form.reference_radius if pin.form else 0.1 * pin.radius) for pin in pins]
        outer = max(sizes, default=part.outer)
        result.append(
            replace(
                part,
                # the size of a plain body is that of an equal disc, so at most a bystander's
                outer=min(outer, 0.4 * largest if part.form is None and not pins else outer)
                if np.isfinite(outer)
                else 0.2 * largest,
                reach=reach if np.isfinite(reach) and reach > 0 else 1.0,
                width=part.width if np.isfinite(part.width) else drawn,
            )
        )
    return result


def _side_by_side(found: list[Part]) -> list[Part]:
    start, offsets = 0.0, dict[str, float]()
    for place in dict.fromkeys(part.place for part in found):
        half = max(part.radius + part.outer for part in found if part.place == place)
        offsets[place] = start + half if offsets else 0.0
        start = offsets[place] + 1.25 * half
    return [replace(part, offset=offsets[part.place]) for part in found]
