"""Load ratings of a bearing from its geometry, and the life of it under a distribution of loads.

Basic dynamic rating [iso281], N and mm, with the factor f_c by its formula [harris2001, ch. 18], not by the table:

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
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from .element_loads import LAMINAE, PLACES, LoadZone, contact_set, race_contact
from .rolling_bearing import RollingBearing

Array = NDArray[np.float64]
Race = Literal["inner", "outer"]

_LARGE_BALL = 25.4  # mm
_STATIC_PRESSURE = 4.2e9  # of balls [Pa]
_STRIBECK = 5.0  # load of the most loaded element over the mean radial one, with usual clearance
_KAPPA = (0.1, 4.0)
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

    Raises
    ------
    ModelError : kappa or e_C outside of their range.
    """
    if not kappa >= _KAPPA[0]:
        raise ModelError("too little lubrication for a_ISO", path="kappa", given=kappa, allowed="0.1 or more")
    if not 0 < contamination <= 1:
        raise ModelError("no factor of contamination", path="contamination", given=contamination, allowed="0 to 1")
    kappa = min(kappa, _KAPPA[1])
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
