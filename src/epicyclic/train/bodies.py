"""Bodies of a train and what joins them.

Rigid bodies and the frames of their coordinates (docs/conventions.md, Axes).

Connections: meshes, and links (bearings, pins, supports, couplings, necks, shafts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..teeth.mesh_stiffness import ContactTable, ForceCurve, ToothPair

Direction = Literal["x", "y", "z", "rx", "ry", "rz"]
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
class GearData:
    """The toothed part of a body, as resolved; lengths [m], angles [rad].

    teeth : number of teeth (positive, also of a ring); internal : a ring's teeth.
    module, pressure_angle : normal module and normal pressure angle.
    helix_angle : magnitude; hand : +1 right, -1 left (of the left helix of a herringbone gear), 0 spur.
    face_width : of one helix, None where not given; gap : between the helices of one body.
    herringbone : this body carries both helices.
    base_radius, tip_radius, root_radius, reference_radius : radii [m].
    profile_shift, addendum, dedendum : coefficients [1].
    """

    teeth: int
    internal: bool
    module: float
    pressure_angle: float
    helix_angle: float
    hand: int
    face_width: float | None
    gap: float
    herringbone: bool
    base_radius: float
    tip_radius: float
    root_radius: float
    reference_radius: float
    profile_shift: float = 0.0
    addendum: float = 1.0
    dedendum: float = 1.25


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """One rigid body with up to six degrees of freedom.

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
    """

    name: str
    path: str
    kind: str
    first: str
    second: str | None
    centre: tuple[float, float] = (0.0, 0.0)
    station: float = 0.0
    angle: float = 0.0
    stiffness: tuple[float, float, float, float, float, float]
    damping: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    clearance: float = 0.0
    exponent: float = 1.0
    load: float = 0.0
    friction: tuple[tuple[str, float | str], ...] = ()
    curves: tuple[tuple[int, ForceCurve], ...] = ()

    def __repr__(self) -> str:
        """One line: name, kind, bodies and the six stiffnesses."""
        values = " ".join(f"{value:.4g}" for value in self.stiffness)
        return f"Link({self.name!r}, {self.kind}, {self.first} - {self.second or 'frame'}, stiffness {values})"
