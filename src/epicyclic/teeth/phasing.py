"""Tooth phases of one pair of gears: position of a tooth, and of its contact on the line of action.

Angles are in turns, phases in tooth pitches (docs/conventions.md, Phases).  tau = teeth x (polar angle of a tooth
centre) is the tooth phase of a gear.  P is the polar angle of e, from the centre of A to the pitch point.  d = +1 where
A pushes B along z cross e.  sigma is the place of the contact from the pitch point along the line of action, in base
pitches.  From the half tooth angle at the base circle, (pi/2 + 2 x tan alpha_n)/z + inv alpha_t, the involute gives

    A                 sigma = d (tau_A - z_A P) + 1/4 + c_A
    external mate B   tau_B = z_B (P + 1/2) - d (sigma + 1/4 + c_B)
    ring B            tau_B = z_B P + d (sigma + 1/4 + c_B)
    c = x tan(alpha_n)/pi + z (inv alpha_t - inv alpha_w)/(2 pi),   z < 0 for a ring

c is zero without profile shift, and all phases are rational: `Phase` keeps the rational part exact.  Derived here, in
agreement with the published mesh phasing relations [parker2004].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

QUARTER = Fraction(1, 4)
HALF = Fraction(1, 2)
SAME_ANGLE = 1e-12  # [rad] working and reference angle this close are one angle computed twice


@dataclass(frozen=True, slots=True)
class Phase:
    """A phase [pitches] or an angle [turns]: a rational part and an irrational rest.

    exact : rational part [1].  rest : irrational part [1]; 0.0 where the whole is rational.
    """

    exact: Fraction = Fraction(0)
    rest: float = 0.0

    @classmethod
    def of(cls, value: Angle) -> Phase:
        """A Phase of a Fraction or an integer (exact) or of a float (not)."""
        if isinstance(value, Phase):
            return value
        return cls(rest=value) if isinstance(value, float) else cls(Fraction(value))

    @property
    def value(self) -> Fraction | float:
        """The number itself, exact where it is rational."""
        return self.exact if self.rest == 0.0 else float(self.exact) + self.rest

    def __add__(self, other: Angle) -> Phase:
        """Sum; rational parts stay exact."""
        that = Phase.of(other)
        return Phase(self.exact + that.exact, self.rest + that.rest)

    def __sub__(self, other: Angle) -> Phase:
        """Difference; equal rests cancel to an exact number."""
        that = Phase.of(other)
        return Phase(self.exact - that.exact, self.rest - that.rest)

    def __neg__(self) -> Phase:
        """The opposite phase."""
        return Phase(-self.exact, -self.rest)

    def __mul__(self, factor: int | Fraction) -> Phase:
        """Scaled by a rational number."""
        return Phase(self.exact * factor, self.rest * float(factor))

    __rmul__ = __mul__

    def __mod__(self, period: int | Fraction) -> Phase:
        """The same phase with its value in [0, period)."""
        if self.rest == 0.0:
            return Phase(self.exact % period)
        turned = Phase(self.exact - period * math.floor(float(self.value) / float(period)), self.rest)
        # A rest smaller than the rounding of the sum must not leave the interval.
        return turned if 0.0 <= float(turned.value) < float(period) else Phase()

    def nearest(self, period: int | Fraction = 1) -> Phase:
        """The same phase with its value in [-period/2, period/2)."""
        half = Fraction(period) / 2
        return (self + half) % period - half


Angle = Phase | Fraction | int | float


def shift_term(
    *,
    teeth: int,
    profile_shift: float,
    normal_angle: float,
    transverse_angle: float,
    working_angle: float,
    internal: bool = False,
) -> float:
    """Phase c of a gear in one mesh from its profile shift and the working pressure angle of the mesh [pitches].

    normal_angle, transverse_angle : pressure angles of the tool [rad].  working_angle : transverse, of this mesh [rad].
    Exactly zero where there is no shift and both angles agree.  The terms of two gears in mesh without backlash cancel.
    """
    turn = 0.0
    if abs(transverse_angle - working_angle) > SAME_ANGLE:
        signed = -teeth if internal else teeth
        turn = signed * (_involute(transverse_angle) - _involute(working_angle)) / math.tau
    return profile_shift * math.tan(normal_angle) / math.pi + turn


def contact_place(tooth: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0) -> Phase:
    """Place sigma of the contact of gear A at its tooth phase `tooth` [pitches], in base pitches.

    direction : P [turns].  flank : d.  shift : `shift_term` of A in this mesh [pitches].
    """
    return flank * (tooth - teeth * direction) + QUARTER + shift


def driver_tooth(place: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0) -> Phase:
    """Tooth phase of gear A [pitches] from the place of its contact [base pitches], inverse of `contact_place`."""
    return teeth * direction + flank * (place - QUARTER - shift)


def mate_tooth(
    place: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0, internal: bool = False
) -> Phase:
    """Tooth phase of gear B [pitches] from the place of its contact [base pitches].

    direction : P [turns].  flank : d of the mesh.  shift : `shift_term` of B in this mesh [pitches].
    internal : B is a ring.
    """
    if internal:
        return teeth * direction + flank * (place + QUARTER + shift)
    return teeth * (direction + HALF) - flank * (place + QUARTER + shift)


def contact_of_mate(
    tooth: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0, internal: bool = False
) -> Phase:
    """Place of the contact of gear B [base pitches] from its tooth phase [pitches], inverse of `mate_tooth`."""
    if internal:
        return flank * (tooth - teeth * direction) - QUARTER - shift
    return flank * (teeth * (direction + HALF) - tooth) - QUARTER - shift


def _involute(angle: float) -> float:
    return math.tan(angle) - angle
