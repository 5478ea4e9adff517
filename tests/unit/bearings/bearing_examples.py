"""Bearings that several tests ask: sizes of usual catalogues, and one of each type."""

from __future__ import annotations

import math

from epicyclic.bearings.rolling_bearing import RollingBearing

DEEP_GROOVE = RollingBearing(  # 6205
    type="deep groove ball", elements=9, element_diameter=7.938e-3, pitch_diameter=39.04e-3
)
ANGULAR = RollingBearing(
    type="angular contact ball",
    elements=14,
    element_diameter=12.7e-3,
    pitch_diameter=70e-3,
    contact_angle=math.radians(40),
)
DOUBLE = RollingBearing(
    type="angular contact ball",
    rows=2,
    row_distance=20e-3,
    elements=14,
    element_diameter=12.7e-3,
    pitch_diameter=70e-3,
    contact_angle=math.radians(30),
)
CYLINDRICAL = RollingBearing(
    type="cylindrical roller", elements=17, element_diameter=15e-3, element_length=14e-3, pitch_diameter=100e-3
)
TAPERED = RollingBearing(
    type="tapered roller",
    elements=17,
    element_diameter=15e-3,
    element_length=20e-3,
    pitch_diameter=100e-3,
    contact_angle=math.radians(15),
)
SPHERICAL = RollingBearing(
    type="spherical roller",
    rows=2,
    elements=17,
    element_diameter=15e-3,
    element_length=14e-3,
    pitch_diameter=100e-3,
    contact_angle=math.radians(10),
)
ALL = {
    "deep groove": DEEP_GROOVE,
    "angular": ANGULAR,
    "double": DOUBLE,
    "cylindrical": CYLINDRICAL,
    "tapered": TAPERED,
    "spherical": SPHERICAL,
}
