"""A rolling bearing as its drawing has it, what follows from its geometry alone, and its checks.

Two families: *point* contact (balls in grooves) and *line* contact (rollers).  gamma = D_w cos alpha / D_pw and the
curvatures of the contacts [harris2001, ch. 2]:

    point   sum = (4 - 1/f +- 2 gamma/(1 -+ gamma))/D_w        line   sum = 2/(D_w (1 -+ gamma))

with the upper sign at the inner race and f = r/D_w its groove.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

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
    rating, static_rating : C, C_0 of the catalogue [N]; None: from geometry (`rating_life`).
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
