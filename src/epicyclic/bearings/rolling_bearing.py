"""Rolling bearings by their parts: the drawing, loads of the elements, ratings and life.

The drawing.  Two families: *point* contact (balls in grooves) and *line* contact (rollers).  gamma = D_w cos alpha /
D_pw and the curvatures of the contacts [harris2001, ch. 2]:

    point   sum = (4 - 1/f +- 2 gamma/(1 -+ gamma))/D_w        line   sum = 2/(D_w (1 -+ gamma))

with the upper sign at the inner race and f = r/D_w its groove.

Loads of the elements: the law of one contact, of all together, their equilibrium.  The five rows q = (x, y, z, rx, ry)
are the motion of the inner race against the outer, about the centre of the bearing. Contact j is stretched by s_j(q),
and the force on the inner race that holds it in place is the gradient of one convex energy,

    V(q) = sum w_j C <s_j - g_j>^(n+1) / (n+1),    F = dV/dq = sum w_j C <s_j - g_j>^n ds_j/dq

Line contacts keep their direction, s = n.q.  In point contact the centres of the two grooves, A apart without load,
move against each other, and the contact line turns with them [iso16281]:

    s = sqrt((A + n.q)^2 + (t.q)^2) - A

with t across n in the plane of the axis.  The distance of two points is convex in their motion, so V is convex too
(derived here).  A race with a contact angle has one shoulder: a contact line turns no further than across the axis, s
is there the radial distance less A, which keeps V convex and smooth.  Elements of a deep groove ball bearing stand at n
radial with A less half the clearance and g half the clearance; under axial load they find the free contact angle,
cos alpha_0 = 1 - clearance/(2 A), by themselves.

A point contact follows Hertz with complete elliptic integrals, Q = K d^(3/2) with inner and outer contact in series
[harris2001, ch. 6].  A line contact follows the law of ISO/TS 16281 for steel, Q = 35 948 l^(8/9) d^(10/9) [N, mm], of
both contacts, spread over laminae; another modulus scales it.  Half the clearance, and twice the profile of a lamina,
open a contact.  Law, profile and their constants are from memory of the standard.

Ratings and life.  Basic dynamic rating [iso281], N and mm, with the factor f_c by its formula [harris2001, ch. 18], not
by the table:

    ball     C = b f_c (i cos a)^0.7 Z^(2/3) D^1.8        beyond 25.4 mm  3.647 D^1.4 in place of D^1.8
    roller   C = b f_c (i L cos a)^(7/9) Z^(3/4) D^(29/27)

b is 1.3 of balls, 1.1 of rollers, 1.15 of spherical rollers.  f_c counts grooves of 0.52 at both races, as the table of
the standard does; it gives that table to 0.3 %.  Constants, exponents and b are from memory of the literature.

The life under a load distribution [iso16281] takes the ratings Q_ci, Q_ce of one contact at each race from C, and the
mean loads Q_ei, Q_ee over the elements.  A place of the race that turns against the load meets every load, one of the
race that stands meets the same load always:

    ball     mean exponents 3 and 10/3,   L = (sum (Q_e/Q_c)^(10/3))^(-9/10)
    roller   mean exponents 4 and 9/2,    L = (sum (q_e/q_c)^(9/2))^(-8/9),    over laminae, q_c = Q_c (1/n)^(7/9)

Sums are over both races and all rows; lives in millions of revolutions of the race that turns, against the load.  At
the ends of cylindrical and tapered rollers loads count more by f = 1 - 0.01/ln(1.985 |2 k - n - 1|/(2 n - 2)), lamina k
of n.  Q_c goes with 1/cos a, so that radial bearings of any contact angle agree with ISO 281 alike (derived here).  All
of it is from memory of the standard.

Without clearance and tilt the life of balls under a radial load is that of ISO 281 (0.999 of it).  That of rollers is
longer: the standard gives each contact 1/0.83 of its share of C, a factor 0.83^-4 = 2.1 of the life, and the life goes
with the fourth power of the load, not with 10/3.  Profile and ends take part of this back; 2.0 to 3.5 is left, over
loads of C/20 to C/2 of three types (measured here).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ConvergenceError

BearingType = Literal[
    "deep groove ball", "angular contact ball", "cylindrical roller", "tapered roller", "spherical roller"
]
# type -> least and largest size of the contact angle [deg]
ANGLES: dict[BearingType, tuple[float, float]] = {
    "deep groove ball": (0.0, 0.0),
    "angular contact ball": (5.0, 45.0),
    "cylindrical roller": (0.0, 0.0),
    "tapered roller": (5.0, 45.0),
    "spherical roller": (0.0, 25.0),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RollingBearing:
    """A radial rolling bearing; SI.

    type : one of `ANGLES`.  rows : 1 or more, of those with a contact angle at most 2.  elements : Z of one row.
    element_diameter : D_w, of tapered rollers at mid-length [m].  element_length : L_we, effective, of rollers [m].
    pitch_diameter : D_pw [m].
    contact_angle : alpha, nominal [rad].  One row with alpha > 0 carries an inner race that is pushed along +z, with
        alpha < 0 one that is pushed along -z.
    clearance : radial internal clearance in operation, the whole play from one side to the other [m]; below 0 the
        elements are pressed.
    preload : approach of the races of each row along z beyond first touch, 0 or more [m]; needs a contact angle.
    row_distance : between the centres of neighbouring rows [m]; 0 of one row, and of spherical rollers, whose rows
        stand where their contact lines meet on the axis.
    arrangement : of two rows with a contact angle; "O": contact lines meet the axis outside of the rows, "X": inside.
    groove : r/D_w of inner and outer race, of balls.
    rating, static_rating : C, C_0 of the catalogue [N]; None: from geometry.
    fatigue_limit : C_u of the catalogue [N]; None: estimated from C_0.
    youngs_modulus [Pa], poisson : of races and elements.
    """

    type: BearingType
    rows: int = 1
    elements: int
    element_diameter: float
    element_length: float = 0.0
    pitch_diameter: float
    contact_angle: float = 0.0
    clearance: float = 0.0
    preload: float = 0.0
    row_distance: float = 0.0
    arrangement: Literal["O", "X"] = "O"
    groove: tuple[float, float] = (0.52, 0.53)
    rating: float | None = None
    static_rating: float | None = None
    fatigue_limit: float | None = None
    youngs_modulus: float = 2.07e11
    poisson: float = 0.3

    @property
    def is_ball(self) -> bool:
        """Whether elements and races touch in points."""
        return self.type.endswith("ball")

    @property
    def gamma(self) -> float:
        """D_w cos alpha / D_pw [1]."""
        return self.element_diameter * math.cos(self.contact_angle) / self.pitch_diameter

    @property
    def reduced_modulus(self) -> float:
        """E / (1 - nu^2) [Pa]."""
        return self.youngs_modulus / (1 - self.poisson**2)

    @property
    def groove_distance(self) -> float:
        """Distance A of the centres of inner and outer groove as a ball touches both without load [m]."""
        return (sum(self.groove) - 1) * self.element_diameter

    @property
    def row_places(self) -> tuple[tuple[float, float], ...]:
        """Axial place of the centre of each row [m] and its contact angle with sign [rad]."""
        angle, middle = self.contact_angle, (self.rows - 1) / 2
        if self.type == "spherical roller" and self.rows == 2:
            apart = self.pitch_diameter / 2 * math.tan(abs(angle))
            return (-apart, -abs(angle)), (apart, abs(angle))
        if self.rows == 2:
            angle = abs(angle) if self.arrangement == "O" else -abs(angle)
        turned = (angle, -angle) if self.rows == 2 else (angle,) * self.rows
        return tuple(((row - middle) * self.row_distance, turned[row]) for row in range(self.rows))

    def curvature(self, race: Literal["inner", "outer"]) -> tuple[float, float]:
        """Curvature sum of element and race [1/m], and relative curvature difference F [1], 1 of a line."""
        bent = self.gamma / (1 - self.gamma) if race == "inner" else -self.gamma / (1 + self.gamma)
        if not self.is_ball:
            return (2 + 2 * bent) / self.element_diameter, 1.0
        across = 1 / self.groove[race == "outer"]
        total = 4 - across + 2 * bent
        return total / self.element_diameter, (across + 2 * bent) / total


class PassingFrequencies(NamedTuple):
    """Frequencies of a bearing, all of the unit of the speeds; `cage` has their sign, the others are sizes.

    cage : turns of the cage.  outer, inner : elements that pass a place of the race.  element : turns of an element
    about itself, against the cage; a defect of it meets each race once a turn.
    """

    cage: float
    outer: float
    inner: float
    element: float


def passing_frequencies(bearing: RollingBearing, inner_speed: float, outer_speed: float) -> PassingFrequencies:
    """Frequencies of pure rolling [harris2001, ch. 8].

    inner_speed, outer_speed : of the races in one frame, signed, in any unit of revolutions a time [Hz].
    """
    gamma, relative = bearing.gamma, abs(inner_speed - outer_speed)
    spin = relative * (1 - gamma**2) * bearing.pitch_diameter / (2 * bearing.element_diameter)
    return PassingFrequencies(
        cage=(inner_speed * (1 - gamma) + outer_speed * (1 + gamma)) / 2,
        outer=bearing.elements * relative * (1 - gamma) / 2,
        inner=bearing.elements * relative * (1 + gamma) / 2,
        element=spin,
    )


Array = NDArray[np.float64]

PLACES, LAMINAE = 180, 30
# N and mm to SI: 1000^(8/9 + 10/9); of steel with E = 207 GPa, nu = 0.3
_LINE, _LINE_MODULUS = 35_948e6, 2.07e11 / (1 - 0.3**2)
_LOGARITHMIC = {"cylindrical roller": 0.00035, "tapered roller": 0.00045}
_LONG, _LONG_PROFILE = 2.5, 0.0005
_OSCULATION = 0.98
_STEPS, _HALVINGS, _TOLERANCE, _ROUNDING, _FAR = 200, 40, 1e-11, 1e-14, 1e3
_CURVE, _CURVE_PLACES = 41, 720
_ALIKE = 1e-9  # loads of elements that are equal


# the law of one contact ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class PointContact:
    """Hertzian contact: Q = stiffness d^(3/2); long semi-axis a = `long` Q^(1/3), short one b = `short` Q^(1/3).

    stiffness [N/m^(3/2)].  long, short [m/N^(1/3)].
    """

    stiffness: float
    long: float
    short: float

    def pressure(self, load: ArrayLike) -> Array:
        """Largest pressure [Pa] of loads [N], each 0 or more."""
        return np.asarray(1.5 * np.cbrt(load) / (math.pi * self.long * self.short))


def point_contact(curvature_sum: float, difference: float, reduced_modulus: float) -> PointContact:
    """Hertzian contact of two bodies of one material, exactly [harris2001, ch. 6].

    With k = a/b, m = 1 - 1/k^2 and the complete elliptic integrals K(m), E(m),

        F = ((k^2 + 1) E - 2 K) / ((k^2 - 1) E)

    curvature_sum [1/m].  difference : F, 0 of spheres or more, below 1.  reduced_modulus : E/(1 - nu^2) [Pa].
    """
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipkm1

    def beyond(log_k: float) -> float:
        square = math.exp(2 * log_k)
        second = ellipe(1 - 1 / square)
        return float(((square + 1) * second - 2 * ellipkm1(1 / square)) / ((square - 1) * second) - difference)

    # near spheres F is a difference of two nearly equal numbers; there k = 1 + 4/3 F
    k = 1 + 4 / 3 * difference if difference < 1e-4 else math.exp(brentq(beyond, 5e-5, 12.0, xtol=1e-14))
    first, second = float(ellipkm1(1 / k**2)), float(ellipe(1 - 1 / k**2))
    short = math.cbrt(6 * second / (math.pi * curvature_sum * reduced_modulus * k))
    stiffness = math.pi * k * reduced_modulus * math.sqrt(2 * second / (9 * curvature_sum * first**3))
    return PointContact(stiffness=stiffness, long=k * short, short=short)


def race_contact(bearing: RollingBearing, race: Literal["inner", "outer"]) -> PointContact:
    """Contact of a ball with one race."""
    return point_contact(*bearing.curvature(race), bearing.reduced_modulus)


def element_law(bearing: RollingBearing) -> tuple[float, float]:
    """Coefficient K [N/m^n] and exponent n of a whole element between both races, Q = K d^n."""
    if not bearing.is_ball:
        stiffness = _LINE * bearing.reduced_modulus / _LINE_MODULUS
        return stiffness * bearing.element_length ** (8 / 9), 10 / 9
    soft = [race_contact(bearing, race).stiffness ** (-2 / 3) for race in ("inner", "outer")]
    return sum(soft) ** -1.5, 1.5


def roller_profile(bearing: RollingBearing, x: Array) -> Array:
    """Drop of the profile P [m] at x (...) from mid-length [m], of one contact; 0 of balls.

    Logarithmic [iso16281]: 0.00035 D_w ln(1/(1 - (2x/L)^2)), of tapered rollers 0.00045 D_w; of cylindrical rollers
    longer than 2.5 D_w the ends alone, 0.0005 D_w.  A spherical roller is an arc whose radius is 0.98 of that of the
    outer race, a usual value that is assumed here: P = x^2 (1/0.98 - 1)/(2 R).
    """
    size, length = bearing.element_diameter, bearing.element_length
    if bearing.is_ball:
        return np.zeros_like(x)
    if bearing.type == "spherical roller":
        radius = bearing.pitch_diameter / (2 * math.cos(bearing.contact_angle)) + size / 2
        return np.asarray(x**2 * (1 / _OSCULATION - 1) / (2 * radius))
    crowned, factor = length, _LOGARITHMIC[bearing.type]
    if bearing.type == "cylindrical roller" and length > _LONG * size:
        crowned, factor = _LONG * size, _LONG_PROFILE
    beyond = np.maximum(2 * np.abs(x) - (length - crowned), 0.0) / crowned
    return np.asarray(-factor * size * np.log1p(-(beyond**2)))


# all contacts together -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElementContacts:
    """Contacts of a bearing for the law of five rows; E = rows x places x laminae, in this order.

    normals : (E, 5) n, stretch of a motion along the contact line [1, m].  across : (E, 5) t.
    gap : (E,) g [m].  bend : 1/A of point contact [1/m]; 0 where contacts keep their direction.
    coefficient : C of one contact [N/m^n].  exponent : n.  weight : elements that a contact stands for.
    shape : (rows, places, laminae).
    """

    normals: Array
    across: Array
    gap: Array
    bend: float
    coefficient: float
    exponent: float
    weight: float
    shape: tuple[int, int, int]

    def approach(self, q: ArrayLike) -> Array:
        """s - g of every contact, (..., E) [m], at q (..., 5) [m, rad]; below 0 where it is open."""
        return self._stretch(np.asarray(q, dtype=float))[0] - self.gap

    def loads(self, q: ArrayLike) -> Array:
        """Load of every contact, of one element, not weighted, (..., E) [N], at q (..., 5)."""
        return np.asarray(self.coefficient * np.maximum(self.approach(q), 0.0) ** self.exponent)

    def energy(self, q: ArrayLike) -> Array:
        """V (...) [J] at q (..., 5)."""
        power = self.exponent + 1
        pressed = np.maximum(self.approach(q), 0.0)
        return np.asarray(self.weight * self.coefficient / power * (pressed**power).sum(axis=-1))

    def force(self, q: ArrayLike) -> Array:
        """Force on the inner race that holds it at q, (..., 5) [N, N m]."""
        stretch, along, aside, _ = self._stretch(np.asarray(q, dtype=float))
        load = self.weight * self.coefficient * _power(stretch - self.gap, self.exponent)
        if not self.bend:
            return np.asarray(load @ self.normals)
        return np.asarray((load * along) @ self.normals + (load * aside) @ self.across)

    def tangent(self, q: ArrayLike) -> Array:
        """dF/dq (..., 5, 5), symmetric and positive semidefinite [N/m, N, N m]."""
        stretch, along, aside, turning = self._stretch(np.asarray(q, dtype=float))
        scale, n = self.weight * self.coefficient, self.exponent
        pressed = np.maximum(stretch - self.gap, 0.0)
        stiffness = scale * n * _power(pressed, n - 1)
        if not self.bend:  # directions are the same at every q
            dyads = (self.normals[:, :, None] * self.normals[:, None, :]).reshape(-1, 25)
            return np.asarray((stiffness @ dyads).reshape(*stiffness.shape[:-1], 5, 5))
        direction = along[..., None] * self.normals + aside[..., None] * self.across
        tangent = np.swapaxes(direction * stiffness[..., None], -1, -2) @ direction
        turned = along[..., None] * self.across - aside[..., None] * self.normals
        tension = scale * pressed**n * turning
        return np.asarray(tangent + np.swapaxes(turned * tension[..., None], -1, -2) @ turned)

    def _stretch(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """s, ds/d(n.q), ds/d(t.q), and how fast a motion across turns the contact line [1/m]; each (..., E)."""
        x = q @ self.normals.T
        if not self.bend:
            one, none = np.broadcast_to(1.0, x.shape), np.broadcast_to(0.0, x.shape)
            return x, one, none, none
        along, aside = 1 + self.bend * x, self.bend * (q @ self.across.T)  # distance of the groove centres over A
        sin, cos = self.normals[:, 2], self.across[:, 2]
        beyond = (along * sin + aside * cos) * sin < 0
        radial = along * cos - aside * sin
        along, aside = np.where(beyond, radial * cos, along), np.where(beyond, -radial * sin, aside)
        distance = np.maximum(np.hypot(along, aside), 1e-6)
        x = np.where(beyond, (along - 1) / self.bend, x)
        stretch = (x * (1 + along) + aside**2 / self.bend) / (1 + distance)  # (distance - 1) A, without cancellation
        return stretch, along / distance, aside / distance, np.where(beyond, 0.0, self.bend / distance)


def _power(approach: Array, exponent: float) -> Array:
    """Approach (..., E) [m] to a power, 0 where a contact is open; there, at most places, nothing is computed."""
    return np.asarray(np.power(approach, exponent, out=np.zeros_like(approach), where=approach > 0))


def contact_set(
    bearing: RollingBearing, *, places: int = PLACES, laminae: int = LAMINAE, first: float = 0.0
) -> ElementContacts:
    """Contacts of a bearing whose elements stand at evenly spread places of each row.

    With many places, each of weight elements/places, sums are the integrals of a bearing whose elements pass unseen;
    with as many places as elements they are the elements.

    places : of each row.  laminae : of a roller; balls have 1.  first : angle of the first place, from x to y [rad].
    """
    laminae = 1 if bearing.is_ball else laminae
    coefficient, exponent = element_law(bearing)
    slack = bearing.clearance / 2
    angle = first + 2 * math.pi * np.arange(places) / places
    x = bearing.element_length * ((np.arange(laminae) + 0.5) / laminae - 0.5)
    beyond = (bearing.groove[0] - 0.5) * bearing.element_diameter if bearing.is_ball else 0.0
    along = 0 * x if bearing.type == "spherical roller" else x  # its rollers tilt with the inner race
    normals, across = [], []
    for place, alpha in bearing.row_places:
        c, s = math.cos(alpha), math.sin(alpha)
        radius = bearing.pitch_diameter / 2 + beyond * c - along * s
        normals.append(_rows(angle, radius, place + beyond * s + along * c, c, s))
        across.append(_rows(angle, radius, place + beyond * s + along * c, -s, c))
    gap = slack * c - bearing.preload * abs(s) + 2 * roller_profile(bearing, x)
    rest = bearing.groove_distance - (slack if bearing.type == "deep groove ball" else 0.0)
    return ElementContacts(
        normals=np.concatenate(normals),
        across=np.concatenate(across),
        gap=np.tile(gap, bearing.rows * places),
        bend=1 / rest if bearing.is_ball else 0.0,
        coefficient=coefficient / laminae,
        exponent=exponent,
        weight=bearing.elements / places,
        shape=(bearing.rows, places, laminae),
    )


def _rows(angle: Array, radius: Array, z: Array, radial: float, axial: float) -> Array:
    """Rows [n, r x n] (P L, 5) of directions (radial, axial) at the points (radius, z) (L,) of every place (P,)."""
    arm = z * radial - radius * axial
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    flat = np.zeros_like(cos * arm)
    parts = (flat + radial * cos, flat + radial * sin, flat + axial, -arm * sin, arm * cos)
    return np.stack(parts, axis=-1).reshape(-1, 5)


# equilibrium ---------------------------------------------------------------------------------------------------------


def displacement(
    bearing: RollingBearing, force: ArrayLike, *, places: int = PLACES, laminae: int = LAMINAE, first: float = 0.0
) -> Array:
    """Motion q (..., 5) of the inner race under a force on it, by Newton's method on the energy.

    force : (..., k) [N, N m] along the first k of the five rows, k = 1, 3 or 5; the other rows are held at 0.
        A row without stiffness (z of cylindrical rollers) stays at 0 unless it is loaded.

    Raises
    ------
    ConvergenceError : the bearing cannot carry such a force.  The contact lines of one row with a contact angle meet
        in a point of the axis, about which the row hardly resists tilt.
    """
    contacts = contact_set(bearing, places=places, laminae=laminae, first=first)
    force = np.asarray(force, dtype=float)
    k = force.shape[-1]
    size = np.array([1.0, 1.0, 1.0, *[2 / bearing.pitch_diameter] * 2])[:k]  # rotations as motions of the pitch circle
    target = (force * size).reshape(-1, k)
    whole = contacts.weight * contacts.coefficient * len(contacts.gap)
    q = np.zeros((len(target), 5))

    def residual(q: Array) -> Array:
        return np.asarray(target - contacts.force(q)[:, :k] * size)

    left = residual(q)
    level = np.maximum(np.abs([target, left]).max(axis=(0, 2)), 1e-300)[:, None]
    # a first step reaches over any play and far beyond the deflection: the search along it brings it back
    softest = level / (_FAR * (level / whole) ** (1 / contacts.exponent) + bearing.element_diameter / 10)
    for _ in range(_STEPS):
        tangent = contacts.tangent(q)[:, :k, :k] * size[:, None] * size
        off = np.abs(left).max(axis=1, keepdims=True) / level
        motion = np.abs(q[:, :k] / size).max(axis=1) + np.abs(contacts.gap).max()
        rounding = _ROUNDING * (np.abs(tangent).max(axis=(1, 2)) * motion)[:, None]
        if (off <= _TOLERANCE + rounding / level).all():
            return q.reshape(*force.shape[:-1], 5)
        # damping that goes with the residual: rows without stiffness stay solvable, the last steps stay quadratic
        tangent += (softest * np.clip(off, 1e-12, 1.0))[..., None] * np.eye(k)
        step = np.linalg.solve(tangent, left[..., None])[..., 0]
        q, left = _searched(q, step, size, residual, left)
    raise ConvergenceError("the bearing does not carry this force; give a force within its rows and contact angle")


def _searched(
    q: Array, step: Array, size: Array, residual: Callable[[Array], Array], left: Array
) -> tuple[Array, Array]:
    """Each q (N, 5) moved along its step (N, k) while the energy falls, or little beyond; what is left there, (N, k).

    size : (k,) of a unit of the step.  left : residual at q.
    """
    share, slope = np.ones((len(q), 1)), (left * step).sum(axis=1)
    for _ in range(_HALVINGS):
        moved = q.copy()
        moved[:, : len(size)] += share * step * size
        left = residual(moved)
        beyond = (left * step).sum(axis=1) < -slope / 2
        if not beyond.any():
            break
        share[beyond] /= 4
    return moved, left


def radial_curve(bearing: RollingBearing, load: float) -> tuple[Array, Array, Array]:
    """Radial law from no force up to four times a load: deflection [m], force [N], slope [N/m], each (P,) and rising.

    Axial motion and tilt are held.  The deflection counts from the centre: it begins with the play, where there is one.

    load : radial, above 0 [N].
    """
    contacts = contact_set(bearing, places=_CURVE_PLACES)
    gap, cos, bend = float(contacts.gap.min()), math.cos(bearing.contact_angle), contacts.bend
    # of point contact: where the distance of the groove centres, sqrt((A + d cos)^2 + (d sin)^2), is A + g
    play = max((math.sqrt(cos**2 + bend * gap * (2 + bend * gap)) - cos) / bend if bend else gap / cos, 0.0)
    most = displacement(bearing, [4 * load], places=_CURVE_PLACES)[0]
    deflection = play + (most - play) * np.linspace(0, 1, _CURVE) ** 2
    deflection = np.concatenate([[0.0], deflection]) if play > 0 else deflection
    q = deflection[:, None] * np.eye(5)[0]
    return deflection, contacts.force(q)[:, 0], contacts.tangent(q)[:, 0, 0]


# load zone -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadZone:
    """Loads of the Z elements of each of R rows, with L laminae.

    angle : (Z,) from x to y, the first along the radial motion [rad].  load : (R, Z) [N].  lamina_load : (R, Z, L) [N].
    extent : epsilon, share of the diameter that is loaded; above 1 all elements bear, inf under axial load alone.
    most : row and element that bear most.  pressure : largest one of this element, at the inner race [Pa].
    """

    angle: Array
    load: Array
    lamina_load: Array
    extent: float
    most: tuple[int, int]
    pressure: float


def load_zone(bearing: RollingBearing, q: ArrayLike, *, laminae: int = LAMINAE) -> LoadZone:
    """Loads of the true elements of a bearing whose inner race stands at q (5,) [m, rad], as from `displacement`."""
    q = np.asarray(q, dtype=float)
    first = math.atan2(q[1], q[0])
    contacts = contact_set(bearing, places=bearing.elements, laminae=laminae, first=first)
    lamina_load = contacts.loads(q).reshape(contacts.shape)
    load = lamina_load.sum(axis=2)
    # of equal ones the first: rows and elements alike are told apart by rounding
    row, element = map(int, np.unravel_index((load >= (1 - _ALIKE) * load.max()).argmax(), load.shape))
    ends = contact_set(bearing, places=2, laminae=1, first=first)
    pressed, opposite = ends.approach(q).reshape(bearing.rows, 2)[row]
    return LoadZone(
        angle=first + 2 * math.pi * np.arange(bearing.elements) / bearing.elements,
        load=load,
        lamina_load=lamina_load,
        extent=float(pressed / (pressed - opposite)) if pressed - opposite > 1e-9 * abs(pressed) else math.inf,
        most=(row, element),
        pressure=largest_pressure(bearing, lamina_load[row, element]),
    )


def largest_pressure(bearing: RollingBearing, lamina_load: Array) -> float:
    """Largest Hertzian pressure at the inner race [Pa] of an element with loads (L,) of its laminae [N].

    Of a roller that of the lamina with the highest load, without what its ends add.
    """
    highest = float(lamina_load.max())
    if bearing.is_ball:
        return float(race_contact(bearing, "inner").pressure(highest))
    line_load = highest * len(lamina_load) / bearing.element_length
    return math.sqrt(line_load * bearing.curvature("inner")[0] * bearing.reduced_modulus / (2 * math.pi))


# ratings --------------------------------------------------------------------------------------------------------------

Race = Literal["inner", "outer"]

_LARGE_BALL = 25.4  # mm
_STATIC_PRESSURE = 4.2e9  # of balls [Pa]
_STRIBECK = 5.0  # load of the most loaded element over the mean radial one, with usual clearance
_KAPPA = 4.0
_MOST = 50.0


def life_exponent(bearing: RollingBearing) -> float:
    """p of L = (C/P)^p."""
    return 3.0 if bearing.is_ball else 10 / 3


def dynamic_rating(bearing: RollingBearing) -> float:
    """C [N]: of the catalogue, else from geometry."""
    return geometric_rating(bearing) if bearing.rating is None else bearing.rating


def static_rating(bearing: RollingBearing) -> float:
    """C_0 [N]: of the catalogue, else from geometry."""
    return geometric_static_rating(bearing) if bearing.static_rating is None else bearing.static_rating


def _race_ratio(gamma: float) -> tuple[float, float]:
    """Rating of the inner contact over that of the outer one, but for its constant, of balls and of rollers."""
    ratio = (1 - gamma) / (1 + gamma)
    return ratio**1.72, ratio ** (143 / 108)


def geometric_rating(bearing: RollingBearing) -> float:
    """C [N] from geometry [iso281]."""
    gamma, rows, number = bearing.gamma, bearing.rows, bearing.elements
    cos, size = math.cos(bearing.contact_angle), bearing.element_diameter * 1e3
    ball, roller = _race_ratio(gamma)
    if bearing.is_ball:
        reduced = 0.90 if bearing.type == "deep groove ball" and rows > 1 else 0.95
        factor = 98.0665 * 0.41 * reduced * (1.04 / 0.04) ** 0.41 * (1 + (1.04 * ball) ** (10 / 3)) ** -0.3
        factor *= gamma**0.3 * (1 - gamma) ** 1.39 / (1 + gamma) ** (1 / 3)
        power = size**1.8 if size <= _LARGE_BALL else 3.647 * size**1.4
        return float(1.3 * factor * (rows * cos) ** 0.7 * number ** (2 / 3) * power)
    factor = 207.9 * 0.83 * (1 + (1.04 * roller) ** 4.5) ** (-2 / 9)
    factor *= gamma ** (2 / 9) * (1 - gamma) ** (29 / 27) / (1 + gamma) ** 0.25
    steel = 1.15 if bearing.type == "spherical roller" else 1.1
    length = rows * bearing.element_length * 1e3 * cos
    return float(steel * factor * length ** (7 / 9) * number**0.75 * size ** (29 / 27))


def rated_element_load(bearing: RollingBearing) -> float:
    """Load of the most loaded element at C_0 [N]: 5 C_0 / (i Z cos alpha) of C_0 from geometry [iso76].

    Balls: 4200 MPa at the race that is pressed harder.  Rollers: 220 (1 - gamma) L D [N, mm], about 4000 MPa.
    """
    if bearing.is_ball:
        hardest = max(float(race_contact(bearing, race).pressure(1.0)) for race in ("inner", "outer"))
        return (_STATIC_PRESSURE / hardest) ** 3
    return 220e6 * (1 - bearing.gamma) * bearing.element_length * bearing.element_diameter


def geometric_static_rating(bearing: RollingBearing) -> float:
    """C_0 [N] from geometry [iso76]."""
    return rated_element_load(bearing) * _radial_elements(bearing) / _STRIBECK


def _radial_elements(bearing: RollingBearing) -> float:
    """i Z cos alpha."""
    return bearing.rows * bearing.elements * math.cos(bearing.contact_angle)


def static_safety(bearing: RollingBearing, zone: LoadZone) -> float:
    """C_0/P_0 with P_0 = i Z cos alpha Q/5 of the most loaded element; inf without load."""
    most = float(zone.load[zone.most])
    return static_rating(bearing) * _STRIBECK / (_radial_elements(bearing) * most) if most > 0 else math.inf


# life ----------------------------------------------------------------------------------------------------------------


def basic_life(bearing: RollingBearing, load: ArrayLike) -> Array:
    """L_10 = (C/P)^p [10^6 revolutions] of equivalent loads P [N]; of a radial load alone P is the load [iso281]."""
    with np.errstate(divide="ignore"):
        return np.asarray((dynamic_rating(bearing) / np.asarray(load, dtype=float)) ** life_exponent(bearing))


def contact_ratings(bearing: RollingBearing) -> tuple[float, float]:
    """Q_ci, Q_ce: dynamic rating of one contact at inner and outer race [N] [iso16281]."""
    ball, roller = _race_ratio(bearing.gamma)
    whole = dynamic_rating(bearing) / (bearing.elements * math.cos(bearing.contact_angle))
    if bearing.is_ball:
        inner, outer = bearing.groove
        ratio = 1.044 * ball * (inner / outer * (2 * outer - 1) / (2 * inner - 1)) ** 0.41
        constants, exponent, of_rows = (0.407, 0.389), 10 / 3, 0.7
    else:
        ratio = 1.038 * roller
        constants, exponent, of_rows = (0.83 * 0.378, 0.83 * 0.364), 9 / 2, 7 / 9
    whole /= bearing.rows**of_rows
    inner, outer = ((1 + ratio**power) ** (1 / exponent) for power in (exponent, -exponent))
    return whole / constants[0] * inner, whole / constants[1] * outer


def edge_factors(bearing: RollingBearing, laminae: int) -> Array:
    """What loads of laminae count more for their place, (L,) [1]; 1 of balls and spherical rollers [iso16281]."""
    if bearing.is_ball or bearing.type == "spherical roller" or laminae == 1:
        return np.ones(laminae)
    off = np.abs(2 * np.arange(1, laminae + 1) - laminae - 1) / (2 * laminae - 2)
    return np.asarray(1 - 0.01 / np.log(1.985 * np.maximum(off, 1e-12)))


def distributed_life(
    bearing: RollingBearing,
    q: ArrayLike,
    *,
    turning: Race = "inner",
    places: int = PLACES,
    laminae: int = LAMINAE,
    first: float = 0.0,
) -> Array:
    """Life (...) [10^6 revolutions] with the inner race at q (..., 5), as from `displacement`; inf without load.

    turning : race that turns against the direction of the load; of a planet bearing on a pin it is the outer one.
    """
    contacts = contact_set(bearing, places=places, laminae=laminae, first=first)
    loads = contacts.loads(q)
    loads = loads.reshape(*loads.shape[:-1], *contacts.shape) * edge_factors(bearing, contacts.shape[2])
    passing, standing, weibull = (3.0, 10 / 3, 10 / 9) if bearing.is_ball else (4.0, 9 / 2, 9 / 8)
    lamina = contacts.shape[2] ** (-7 / 9)
    worn = 0.0
    for race, rating in zip(("inner", "outer"), contact_ratings(bearing), strict=True):
        mean = passing if race == turning else standing
        equivalent = (loads**mean).mean(axis=-2) ** (1 / mean)  # over the places
        worn = worn + ((equivalent / (rating * lamina)) ** standing).sum(axis=(-2, -1))
    with np.errstate(divide="ignore"):
        return np.asarray(np.asarray(worn) ** (-1 / weibull))


def equivalent_load(bearing: RollingBearing, life: ArrayLike) -> Array:
    """P = C L^(-1/p) [N] that a life [10^6 revolutions] stands for; 0 of inf."""
    return np.asarray(dynamic_rating(bearing) * np.asarray(life, dtype=float) ** (-1 / life_exponent(bearing)))


def fatigue_limit(bearing: RollingBearing) -> float:
    """C_u [N]: of the catalogue, else the simple estimate [iso281, annex B], from memory."""
    if bearing.fatigue_limit is not None:
        return bearing.fatigue_limit
    share, power = (22.0, 0.5) if bearing.is_ball else (8.2, 0.3)
    smaller: float = min(0.1 / bearing.pitch_diameter, 1.0) ** power  # of D_pw beyond 100 mm
    return static_rating(bearing) / share * smaller


def life_modification(bearing: RollingBearing, load: ArrayLike, *, kappa: float, contamination: float) -> Array:
    """a_ISO (...) of radial bearings, at most 50, by the formulas of ISO 281, from memory [iso281, 9.3.3].

    load : equivalent loads P (...), above 0 [N].  kappa : viscosity ratio, 0.1 or more; what is above 4 counts as 4.
    contamination : e_C, above 0 and up to 1.
    """
    kappa = min(kappa, _KAPPA)
    band = 0 if kappa < 0.4 else 1 if kappa < 1 else 2
    bend = kappa ** (0.054381, 0.19087, 0.071739)[band]
    relative = contamination * fatigue_limit(bearing) / np.asarray(load, dtype=float)
    if bearing.is_ball:
        film = (2.5671 - (2.2649, 1.9987, 1.9987)[band] / bend) ** 0.83
        base, power = 1 - film * np.cbrt(relative), -9.3
    else:
        film = 1.5859 - (1.3993, 1.2348, 1.2348)[band] / bend
        base, power = 1 - film * relative**0.4, -9.185
    least = (_MOST / 0.1) ** (1 / power)  # of the base, where a_ISO is 50
    return np.asarray(0.1 * np.maximum(base, least) ** power)
