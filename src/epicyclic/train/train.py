"""The resolved train, frozen data with nothing left implicit: bodies and what joins them, errors, loads, damping.

Rigid bodies stand in the frames of their coordinates (docs/conventions.md, Axes); connections are meshes, and links
(bearings, pins, supports, couplings, necks, shafts).  The log of a resolution has every resolved value with its origin
and every warning.  A notebook shows the front view of every stage by pitch circles, to scale, and key numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from html import escape
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..bearings.rolling_bearing import RollingBearing
from ..bodies.elastic_body import ElasticBody, ThinRing, elastic_ring
from ..teeth import geometry
from ..teeth.mesh_stiffness import ContactTable, ForceCurve, ToothPair
from ..warning_codes import CodedText, coded
from .kinematics import Kinematics
from .power import PowerPath

Direction = Literal["x", "y", "z", "rx", "ry", "rz"]
MASS_UNITS = {"mass": "kg", "inertia": "kg m^2", "tilt_inertia": "kg m^2"}
DIRECTIONS: tuple[Direction, ...] = ("x", "y", "z", "rx", "ry", "rz")
HOUSING = "housing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Axes in which the coordinates of the bodies of a stage are written.

    name : stage name, or ``housing``.
    carrier : member with which the frame turns (``main.carrier``), None for a frame at rest.
    """

    name: str
    carrier: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Teeth:
    """The teeth of one gear, before profile shifts are known; lengths [m], angles [rad].

    teeth : number of teeth (positive, also of a ring); internal : a ring's teeth.
    module, pressure_angle : normal module and normal pressure angle.
    helix_angle : magnitude; hand : +1 right, -1 left (of the left helix of a herringbone gear), 0 spur.
    nominal_base : base radius by teeth and module; base_radius : the one used, given or nominal.
    """

    teeth: int
    internal: bool
    module: float
    pressure_angle: float
    helix_angle: float
    hand: int
    nominal_base: float
    base_radius: float

    @property
    def nominal(self) -> bool:
        """Whether the base radius is that of teeth and module."""
        return same(self.base_radius, self.nominal_base)

    @property
    def transverse_angle(self) -> float:
        """Transverse pressure angle of the tool [rad]."""
        return geometry.transverse_pressure_angle(self.pressure_angle, self.helix_angle)

    @property
    def base_helix(self) -> float:
        """Base helix angle, magnitude [rad]."""
        return geometry.base_helix_angle(self.pressure_angle, self.helix_angle)


@dataclass(frozen=True, slots=True, kw_only=True)
class GearData(Teeth):
    """The toothed part of a body, as resolved; lengths [m].

    face_width : of one helix, None where not given; gap : between the helices of one body.
    herringbone : this body carries both helices.
    tip_radius, root_radius, reference_radius : radii [m].
    profile_shift, addendum, dedendum : coefficients [1].
    """

    face_width: float | None
    gap: float
    herringbone: bool
    tip_radius: float
    root_radius: float
    reference_radius: float
    profile_shift: float
    addendum: float
    dedendum: float

    @property
    def whole_width(self) -> float:
        """Width over both helices of this body and the gap between them, or of its one [m]; nan where not given."""
        width = NAN if self.face_width is None else self.face_width
        return 2 * width + self.gap if self.herringbone else width


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """One body with up to six degrees of freedom, and those by which it bends.

    name : ``stage/member[/branch][/side]``, e.g. ``main/planet/2``, ``main/ring/left``; ``[bodies]`` by their own name.
    member : name in the model file, ``main.planet``; all bodies of one member turn at one mean speed.
    kind : sun, planet, ring, carrier, gear or body.
    frame : name of its Frame.  carried_by : body that carries it (of a planet the carrier), None for a central body.
    branch : 1..N of a body on a branch, else None.  side : left, right or None.
    centre : (x, y) place of its origin in frame axes [m].  station : axial place of its origin [m].
    angle : polar angle of its own x axis in frame axes [rad]: 0 for a central body, the polar angle of
        its centre for a body on a branch.
    mass [kg], inertia about z [kg m^2], tilt_inertia about x and y [kg m^2].
    reference_radius : R of the reported base-circle displacement u = R rz [m].
    outer_radius : of a ring whose rim or outer diameter is given [m], else None.
    shaft_of : of a place on a shaft that bends (`ShaftSpan`) the body whose shaft it is, with member, kind and branch
        of that; ``main/sun/shaft/front`` by name.  None of all others.
    elastic : the ring that it is, None of another body.  reduced : how it bends by the matrices of a finite-element
        program.
    """

    name: str
    member: str
    kind: str
    frame: str
    carried_by: str | None = None
    branch: int | None = None
    side: str | None = None
    centre: tuple[float, float] = (0.0, 0.0)
    station: float = 0.0
    angle: float = 0.0
    mass: float = 0.0
    inertia: float = 0.0
    tilt_inertia: float = 0.0
    reference_radius: float = 1.0
    outer_radius: float | None = None
    gear: GearData | None = None
    shaft_of: str | None = None
    elastic: ThinRing | None = None
    reduced: ElasticBody | None = None

    @property
    def bending(self) -> ElasticBody | None:
        """Coordinates by which it bends, None of a rigid body."""
        return self.reduced if self.elastic is None else elastic_ring(self.elastic)

    def __repr__(self) -> str:
        """One line: name, kind, teeth and mass."""
        teeth = "" if self.gear is None else f", {self.gear.teeth} teeth"
        mass = f", {self.mass:.4g} kg" if math.isfinite(self.mass) else ""
        return f"Body({self.name!r}, {self.kind}{teeth}{mass})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshSlice:
    """One of the equal slices of a mesh along its face, with an equal share of stiffness and damping.

    station : axial place of its middle in the train [m].  lead : of its own contact [mesh cycles].
    variation : (L,) relative series of its own stiffness over its own sigma [1].
    along : place of its row on the line of action, from the pitch point [m].
    """

    station: float
    lead: Fraction | float
    variation: NDArray[np.complex128]
    along: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """One tooth mesh of one helix.

    name : ``main/sun-planet/2/left``; pair : its table in the file, ``stages.main.meshes.sun-planet``.
    stage : whose mesh frequency it follows.  branch, side : as of a body.
    a, b : body names; `a` is the gear nearer the sun along the power path, in a ring mesh the planet.
    internal : b is a ring.
    direction : polar angle, in frame axes, of e: from a's centre to the pitch point [rad].
    pressure_angle : working transverse [rad].  base_helix : beta_b, magnitude [rad].
    hand : hand of gear a on this side, +1 right, -1 left, 0 spur.
    flank : d of docs/conventions.md, +1 where the teeth of a push b along z cross e, else -1.
    station : axial place of the middle of the common face in the train [m].  width : of the common face [m], nan where
        no gear states one.
    along : place of the row on the line of action, from the pitch
        point in the sense of n_t [m].
    radius_a, radius_b : working pitch radii r_b / cos(pressure_angle) [m].
    stiffness : mean, along the tooth normal [N/m].
    variation : (L,) complex; k(sigma)/stiffness = 1 + Re sum_l variation[l-1] exp(2 pi i l sigma).
    lead : gamma, phase lead of the contact in mesh cycles, in [0, 1) (exact Fraction where it is rational).
    sense : D; sigma(t) = sense * (f_mesh t + lead).
    damping : along the normal [N s/m].  backlash : normal [m], inf = the far flank never touches.
    tooth_shift : 2 c of gear a, how far its tooth is thicker or thinner there than half a pitch [pitches].
    contact_ratio, overlap_ratio : transverse and overlap contact ratio [1], nan where the data are not given.
    limits : (sigma_min, sigma_max) of the path of contact [base pitches], nan where the data are not given.
    slices : along the face from left to right; empty where the mesh is one row.  Stiffness, variation, lead and damping
        above are those of the whole mesh, the sum of the slices.
    teeth : data of tooth contact; None where the model file has no face width.
    table : force over gap and place of the contact, where the stiffness is that of loaded contact or a given table.
    """

    name: str
    pair: str
    stage: str
    branch: int | None
    side: str | None
    a: str
    b: str
    internal: bool
    direction: float
    pressure_angle: float
    base_helix: float
    hand: int
    flank: int
    station: float
    radius_a: float
    radius_b: float
    stiffness: float
    variation: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))
    lead: Fraction | float = Fraction(0)
    sense: int = 1
    damping: float = 0.0
    backlash: float = float("inf")
    tooth_shift: float = 0.0
    contact_ratio: float = float("nan")
    overlap_ratio: float = float("nan")
    width: float = float("nan")
    limits: tuple[float, float] = (float("nan"), float("nan"))
    slices: tuple[MeshSlice, ...] = ()
    teeth: ToothPair | None = None
    along: float = 0.0
    table: ContactTable | None = None

    def __repr__(self) -> str:
        """One line: name, bodies, mean stiffness, lead, slices, and whether its force is tabulated."""
        cut = f", {len(self.slices)} slices" if self.slices else ""
        law = ", tabulated" if self.table is not None else ""
        ends = f"{self.a} - {self.b}"
        return f"Mesh({self.name!r}, {ends}, {self.stiffness:.4g} N/m, lead {float(self.lead):.4g}{cut}{law})"


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSet:
    """Contacts between the rings of a bearing, evenly spread about its axis, in the axes of its link.

    The force on the rings at the motion q of the first body of the link against the second is
    sum_j c_j <n_j . q - g_j>^p n_j, its moments about the place of the link.

    normals : E tuples n of what x, y, z [1] and rx, ry [m] add to the approach.
    gap : g (E,) [m].  coefficient : c (E,) [N/m^p].  exponent : p, 1 or more.
    load : sum of the contact forces at which the stiffness of all, equally pressed, is the nominal one [N].
    """

    normals: tuple[tuple[float, ...], ...]
    gap: tuple[float, ...]
    coefficient: tuple[float, ...]
    exponent: float
    load: float

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Nominal stiffness of x, y, z [N/m], rx, ry [N m/rad]; of one that no contact acts in 0."""
        p, whole = self.exponent, sum(self.coefficient)
        slope = p * (self.load / whole) ** (1 - 1 / p)
        return tuple((slope * (np.array(self.coefficient) @ np.array(self.normals) ** 2)).tolist())

    def __repr__(self) -> str:
        """One line: number of contacts, exponent and load."""
        return f"ContactSet({len(self.gap)} contacts, exponent {self.exponent:.4g}, load {self.load:.4g} N)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Link:
    """One bearing, pin, support, coupling, neck or shaft between two bodies at one point.

    name : ``main/sun/support``, ``main/planet/2/bearing``, ``main/sun/support/front``, ``main/ring/support/bolts/3``,
        ``main/sun/neck``, or a coupling's name.
    path : its table in the file, e.g. ``stages.main.sun.support``.
    kind : support, bearing, neck, shaft or coupling.
    first, second : body names; second None = the frame of the first (which is the housing where it does not turn).
        Of a bearing the first is the carrying body (the carrier), the second the carried one (the planet);
        of a support the first is the supported body; the bearing of a planet without a carrier is (planet, None).
    centre : (x, y) place of the point in frame axes [m]; station : axial place [m].
    angle : polar angle of the link's x axis in frame axes [rad] (of a pin the branch's).
    stiffness : x y z [N/m], rx ry rz [N m/rad]; 0 = free, inf = rigid (the direction is eliminated).
    damping : the same six [N s/m, N m s/rad].
    clearance [m], exponent [1], friction (coefficient or force) : laws, see docs/reference/model-file.md.
    load : force at which `stiffness` is the tangent, where the exponent is not 1 [N].
    curves : (direction 0 .. 5, force over deflection) of those that follow a table; `stiffness` is its nominal one.
    rolling : the parts of a rolling bearing, None where none are stated.
    lubrication : its viscosity ratio kappa and contamination factor e_C, where both are [1].
    contacts : law of x, y, z, rx, ry together, but of rigid ones; their `stiffness` is nominal, and no other law.
    """

    name: str
    path: str
    kind: str
    first: str
    second: str | None
    centre: tuple[float, float] = (0.0, 0.0)
    station: float = 0.0
    angle: float = 0.0
    stiffness: tuple[float, ...]
    damping: tuple[float, ...] = (0.0,) * 6
    clearance: float = 0.0
    exponent: float = 1.0
    load: float = 0.0
    friction: tuple[tuple[str, float | str], ...] = ()
    curves: tuple[tuple[int, ForceCurve], ...] = ()
    rolling: RollingBearing | None = None
    lubrication: tuple[float, float] | None = None
    contacts: ContactSet | None = None

    def __repr__(self) -> str:
        """One line: name, kind, bodies and the six stiffnesses."""
        values = " ".join(f"{value:.4g}" for value in self.stiffness)
        return f"Link({self.name!r}, {self.kind}, {self.first} - {self.second or 'frame'}, stiffness {values})"


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftSpan:
    """A shaft between two neighbouring places: what it carries, and each of its supports.

    name : of its link, which stands at its elastic centre.  start, end : its places along the axis [m].
    mass : of its sections [kg].  frequency : of its lowest bending mode with both ends clamped [Hz].
    """

    name: str
    start: float
    end: float
    mass: float
    frequency: float


# notebooks ------------------------------------------------------------------------------------------------------------

_WIDTH, _HEIGHT, _LABEL = 680.0, 300.0, 11  # of the drawing and of its letters [px]
_FILL = {"sun": "#f2b134", "planet": "#6ea8d8", "ring": "none"}


def driving_member(train: Train) -> str | None:
    """Member that the most power enters by; without power the first freedom, None where nothing can turn."""
    kinematics = train.kinematics
    power = {name: value for name, value in (kinematics.power or {}).items() if value > 0}
    if power:
        return max(power, key=lambda name: power[name])
    return next(iter(kinematics.freedoms), None)


def stage_axis(stage: str, bodies: Sequence[Body]) -> tuple[float, float]:
    """Place (x, y) of the axis of a stage [m]: of sun, ring or carrier; of gears on fixed axes that of the first."""
    members = [body for body in bodies if body.frame == stage]
    return next((body.centre for body in members if body.kind in ("sun", "ring", "carrier")), members[0].centre)


def bodies_named(reference: str, bodies: Iterable[Body]) -> list[Body]:
    """Bodies of the member or half that a reference of the document names, ``main.sun``, ``main.sun.right``, ``g1``."""
    parts = reference.split(".")
    of_member = [body for body in bodies if body.member == ".".join(parts[:2]) and body.shaft_of is None]
    return [body for body in of_member if len(parts) < 3 or body.side == parts[2]]


def _members(train: Train) -> list[list[str]]:
    """One row a member: teeth, speed [rpm], external torque [N m] and power [kW], empty where not known."""
    kinematics, teeth = train.kinematics, {b.member: b.gear.teeth for b in train.bodies if b.gear is not None}
    speed, torque, power = kinematics.speed or {}, kinematics.torque or {}, kinematics.power or {}
    return [
        [
            member + (" (held)" if member in kinematics.held else ""),
            str(teeth.get(member, "")),
            _number(speed.get(member)),
            _number(torque.get(member) or None),
            _number(1e-3 * power[member] if power.get(member) else None),
        ]
        for member in dict.fromkeys(body.member for body in train.bodies)
    ]


def _number(value: float | Fraction | None) -> str:
    """Four digits; empty for what is not known or not finite."""
    return f"{float(f'{float(value):.5g}'):.10g}" if value is not None and math.isfinite(value) else ""


def _table(head: list[str], rows: list[list[str]]) -> str:
    if not rows:
        return ""
    cells = [f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return f"<table><tr>{''.join(f'<th>{escape(cell)}</th>' for cell in head)}</tr>{''.join(cells)}</table>"


# front views ---------------------------------------------------------------------------------------------------------


def _front_views(train: Train) -> str:
    """One SVG with a view of every stage from the right end, side by side, all to one scale."""
    radius = _pitch_radii(train)
    stages = {stage: [b for b in train.bodies if b.frame == stage and b.name in radius] for stage in train.planets}
    reach = {
        stage: max(math.dist(b.centre, stage_axis(stage, train.bodies)) + radius[b.name] for b in gears)
        for stage, gears in stages.items()
        if gears
    }
    if not reach:
        return ""
    scale = min(_WIDTH / (2.1 * sum(reach.values())), _HEIGHT / (2 * max(reach.values())))
    height = 2 * scale * max(reach.values()) + 5 * _LABEL
    drawn, left = [], 4.0
    for stage, size in reach.items():
        middle = left + scale * size, 0.5 * height - _LABEL
        drawn.append(_stage(train, stage, stages[stage], radius, middle, scale))
        left += 2.1 * scale * size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + 4:.0f}" height="{height:.0f}" '
        f'font-family="sans-serif" font-size="{_LABEL}" text-anchor="middle" stroke="currentColor" '
        f'fill="none">{"".join(drawn)}</svg>'
    )


def _pitch_radii(train: Train) -> dict[str, float]:
    """Working pitch radius of every gear in its first mesh, else its reference radius [m]."""
    radii = {body.name: body.gear.reference_radius for body in train.bodies if body.gear is not None}
    for mesh in reversed(train.meshes):
        radii |= {mesh.a: mesh.radius_a, mesh.b: mesh.radius_b}
    return {name: radius for name, radius in radii.items() if math.isfinite(radius)}


def _stage(
    train: Train, stage: str, gears: list[Body], radius: dict[str, float], middle: tuple[float, float], scale: float
) -> str:
    """Pitch circles of a stage about its axis at `middle` [px], largest first; scale [px/m]."""
    parts, texts, seen, labels = list[str](), list[str](), set[tuple[str, int | None]](), dict[tuple[int, int], int]()
    axis = stage_axis(stage, train.bodies)
    for body in sorted(gears, key=lambda gear: -radius[gear.name]):
        if (body.member, body.branch) in seen:  # the halves of a herringbone gear stand behind each other
            continue
        seen.add((body.member, body.branch))
        x, y = middle[0] + scale * (body.centre[0] - axis[0]), middle[1] - scale * (body.centre[1] - axis[1])
        r = scale * radius[body.name]
        internal = body.gear is not None and body.gear.internal
        teeth = "" if body.gear is None else f", {body.gear.teeth} teeth"
        turns = _number((train.kinematics.speed or {}).get(body.member))
        told = f"{body.name}{teeth}, pitch radius {radius[body.name] * 1e3:.5g} mm{f', {turns} rpm' if turns else ''}"
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{_FILL.get(body.kind, "#9bc49b")}" '
            f'fill-opacity="0.35"><title>{escape(told)}</title></circle>'
        )
        below = labels.get((round(x), round(y)), 0) if not internal else 0
        if not internal:
            labels[round(x), round(y)] = below + 1
        texts.append(_text(_label(body, r), x, y - r - 3 if internal else y + 4 + below * (_LABEL + 1)))
    pins = {math.dist(body.centre, axis) for body in gears if body.branch is not None}
    parts += [
        f'<circle cx="{middle[0]:.1f}" cy="{middle[1]:.1f}" r="{scale * pin:.1f}" stroke-dasharray="4 3" '
        f'stroke-opacity="0.5"><title>pin circle, radius {pin * 1e3:.5g} mm</title></circle>'
        for pin in sorted(pins)
        if pin > 0
    ]
    bottom = middle[1] + scale * max(math.dist(b.centre, axis) + radius[b.name] for b in gears) + 1.5 * _LABEL
    return "".join([*parts, *texts, _text(stage, middle[0], bottom)])


def _label(body: Body, size: float) -> str:
    """Member and branch; of a small circle [px] the branch alone."""
    member = body.member.rpartition(".")[2]
    if body.branch is None:
        return member
    return f"{member} {body.branch}" if 2 * size > 0.6 * _LABEL * (len(member) + 2) else str(body.branch)


def _text(text: str, x: float, y: float) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="currentColor" stroke="none">{escape(text)}</text>'


# what acts on it ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Displacement:
    """A displaced feature of one body: run-out, pin position, bearing eccentricity, tilt.

    path : of its entry in the model file.  cause : its kind of deviation, a key of `deviations`.
    body : the body that the file names.
    rows : which gaps the feature enters, and through which body (docs/conventions.md, Forces, stiffness, errors):
        ``mesh``  every mesh row of `body`, through `body`'s columns (run-out of a gear);
        ``own``   the rows of the links in `links`, through `body`'s columns (bearing run-out; of a carrier: its pins);
        ``seat``  the rows of the links in `links`, through the columns of the other body, or of the frame
                  (position and tilt: the seat of `body` is displaced).
    links : names of those links.
    vector : (6,) complex, E(t) = Re(vector exp(2 pi i frequency t)) in the axes of `body`; x y z [m], rx ry rz [rad].
    frequency : exact, signed, in the frame of `body` [Hz at the operating speed]; 0 = at rest there.
    """

    path: str
    cause: str
    body: str
    rows: Literal["mesh", "own", "seat"]
    links: tuple[str, ...] = ()
    vector: NDArray[np.complex128]
    frequency: Fraction

    def __repr__(self) -> str:
        """One line: place in the file, body, largest amplitude and frequency."""
        size = float(np.abs(self.vector).max(initial=0.0))
        return f"Displacement({self.path!r} of {self.body!r}, {size:.4g} at {float(self.frequency):.5g} Hz)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshError:
    """A scalar error of one mesh, along the tooth normal: profile, gap, turning error, a harmonic of a pitch deviation.

    e(t) = Re(amplitude exp(2 pi i frequency t)) [m], positive = material missing.  cause : profile, gap, errors, pitch;
    contact where it is that of loaded contact (`Mesh.table`).  far : on the far flank, which a mesh without backlash
    has not.
    """

    path: str
    cause: str
    mesh: str
    amplitude: complex
    frequency: Fraction
    far: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Load:
    """An external force and moment on one body at one axial place.

    force [N], moment [N m] : (3,) real, in housing axes (``turns`` False: fixed in space) or in the axes of the
    body turning with it (``turns`` True).  station : axial place of the point in the train [m].
    Unbalance is a Load with ``speed_squared`` True: force holds amount * w^2 at the operating speed.
    """

    path: str
    body: str
    force: tuple[float, float, float]
    moment: tuple[float, float, float]
    station: float
    turns: bool
    phase: float = 0.0
    speed_squared: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Ripple:
    """A component of the ripple of a shaft: an external torque about z, or the angle that a rigid link prescribes.

    Re(amplitude exp(2 pi i frequency t)) [N m, rad]; frequency : exact, signed [Hz at the operating speed].
    link : of the prescribed angle, its name; "" of a torque.  follows : whether the frequency follows the speed.
    """

    path: str
    body: str
    link: str
    amplitude: complex
    frequency: Fraction
    follows: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A sensor on the material of one body, or in a link.

    name : as of the file, with the branch or side behind it where the member has several bodies.
    kind : strain, acceleration, angle, torque, force.  direction : of an acceleration or force, radial, tangential
        or axial.
    bodies : names; of a torque all of the member and branch, of others one.  link : name of that of a torque or force.
    angle : from the own x axis of the body at t = 0 [rad].  radius, z : from the centre of the body [m].
    stiffness : of the bolt of a force [N/m].
    """

    name: str
    kind: str
    direction: str = "radial"
    bodies: tuple[str, ...] = ()
    link: str = ""
    angle: float = 0.0
    radius: float = 0.0
    z: float = 0.0
    stiffness: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Damping of the whole train.  modal : ratio of every elastic mode [1].  mass [1/s], stiffness [s] : proportional.
    mesh : ratio of every mesh [1].  None = not given."""

    modal: float | None = None
    mass: float | None = None
    stiffness: float | None = None
    mesh: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Derived:
    """One resolved value and its origin: given, stage, as <gear>, geometry, default, assumed, set."""

    path: str
    value: object
    unit: str
    origin: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Train:
    """A whole train, resolved.

    torques : external torque on each body that carries one, held members and balancing ends left out
        (their reaction follows) unless they are free ends [N m], by body name.
    gravity : (3,) acceleration in housing axes [m/s^2].
    values : every resolved value with its origin, in file order.
    document : the file with overrides laid over it, shorthands expanded (provenance).
    planets : number of branches of each stage.
    power_paths : power through every coupling, shaft and pair that meshes; empty without speeds and torques.
    spans : of shafts that bend, with their links among `links` and their places among `bodies`.
    """

    title: str
    frames: tuple[Frame, ...]
    bodies: tuple[Body, ...]
    meshes: tuple[Mesh, ...]
    links: tuple[Link, ...]
    kinematics: Kinematics
    planets: Mapping[str, int]
    torques: Mapping[str, float] = field(default_factory=dict)
    power_paths: tuple[PowerPath, ...] = ()
    spans: tuple[ShaftSpan, ...] = ()
    displacements: tuple[Displacement, ...] = ()
    mesh_errors: tuple[MeshError, ...] = ()
    loads: tuple[Load, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    ripples: tuple[Ripple, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    damping: Damping = Damping()
    warnings: tuple[CodedText, ...] = ()
    values: tuple[Derived, ...] = ()
    assumed: Mapping[str, str] = field(default_factory=dict)
    document: Mapping[str, object] = field(default_factory=dict)
    doi: str = ""
    notes: str = ""

    def __repr__(self) -> str:
        """One line: title, stages with their planets, counts, and the driving member with speed and torque."""
        stages = ", ".join(f"{stage} ({count} planets)" for stage, count in self.planets.items())
        counts = f"{len(self.bodies)} bodies, {len(self.meshes)} meshes, {len(self.links)} links"
        driver, kinematics = driving_member(self), self.kinematics
        turns = None if kinematics.speed is None or driver is None else kinematics.speed[driver]
        torque = None if kinematics.torque is None or driver is None else kinematics.torque[driver]
        numbers = ([] if turns is None else [f"{float(turns):.5g} rpm"]) + ([f"{torque:.5g} N m"] if torque else [])
        driven = f"; {driver} {', '.join(numbers)}" if numbers else ""
        return f"Train({self.title!r}: {stages}; {counts}{driven})"

    def _repr_html_(self) -> str:
        """Front views and tables, for notebooks: one well-formed element, without scripts and outside references."""
        rate, order = self.kinematics.mesh_frequency or {}, self.kinematics.mesh_order
        per_turn = f"per turn of {next(iter(self.kinematics.freedoms), '')}"
        tones = dict.fromkeys([*rate, *order])
        frequencies = [[tone, _number(rate.get(tone)), _number(order.get(tone))] for tone in tones]
        slices = sum(len(mesh.slices) for mesh in self.meshes)
        cut = f" ({slices} slices)" if slices else ""
        return (
            f"<div><p><b>{escape(self.title)}</b></p>{_front_views(self)}"
            f"{_table(['member', 'teeth', 'speed [rpm]', 'torque [N m]', 'power [kW]'], _members(self))}"
            f"{_table(['mesh frequency', '[Hz]', per_turn], frequencies)}"
            f"<p>{len(self.bodies)} bodies, {len(self.meshes)} meshes{cut}, {len(self.links)} links</p></div>"
        )


# resolved values ------------------------------------------------------------------------------------------------------

Number = Fraction | float
NAN = float("nan")
EXACT_ANGLE = 1e-12  # [turns] an angle this near to a fraction of few digits is that fraction


@dataclass(slots=True, kw_only=True)
class ResolutionLog:
    """Collects resolved values, in order, and warnings.

    assumed : path -> reason, of the file.  overridden : full paths that overrides set.
    """

    assumed: Mapping[str, str]
    overridden: frozenset[str] = frozenset()
    values: dict[str, Derived] = field(default_factory=dict)
    warnings: list[CodedText] = field(default_factory=list)

    def note(self, path: str, value: object, unit: str = "", origin: str = "given") -> None:
        """Record one value; `given` becomes `set` by an override of the path, `assumed` by the file's `assumed`."""
        self.values[path] = Derived(path=path, value=value, unit=unit, origin=self.origin(path, origin))

    def origin(self, path: str, origin: str = "given") -> str:
        """Where a value at this path comes from."""
        if origin != "given":
            return origin
        if any(path == p or path.startswith(f"{p}.") for p in self.overridden):
            return "set"
        return "assumed" if path in self.assumed else "given"

    def coded(self, code: str, text: str) -> None:
        """Record a warning once, by its code and its text."""
        self.warn(coded(code, text))

    def warn(self, text: CodedText) -> None:
        """Record a warning once."""
        if text not in self.warnings:
            self.warnings.append(text)


def per_branch(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    """One value per branch, (count,); a single value holds for all, a list is that of the file, one per planet."""
    return value if isinstance(value, tuple) else (value,) * count


def of_branch(value: float | tuple[float, ...] | None, branch: int | None) -> float:
    """Value of one branch (1 ..), or of what is on none; None is 0.  A list stands only where there are planets."""
    return per_branch(0.0 if value is None else value, branch or 1)[(branch or 1) - 1]


def same(a: float, b: float, tolerance: float = 1e-9) -> bool:
    """Whether two values are equal to a relative tolerance [1]: one value computed twice."""
    return math.isclose(a, b, rel_tol=tolerance, abs_tol=1e-15)


def turns_of(angle: float) -> Number:
    """An angle [rad] in turns, as a Fraction where it is a round number of degrees."""
    turns = angle / math.tau
    exact = Fraction(turns * 360).limit_denominator(10**6) / 360
    return exact if abs(float(exact) - turns) < EXACT_ANGLE else turns
