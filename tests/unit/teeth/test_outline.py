"""Outline of teeth: the involute, the fillet a rack leaves, the fillet of a ring, and teeth that cannot be."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tooth_oracles import tip_thickness

from epicyclic.errors import ModelError
from epicyclic.teeth.form import GearForm, Outline, tooth_outline

deg = math.radians
Array = NDArray[np.float64]
M = 1e-3
GEARS = {
    "z19 25 deg": GearForm(teeth=19, module=M, pressure_angle=deg(25), bore=4 * M),
    "z17": GearForm(teeth=17, module=M, pressure_angle=deg(20), bore=4 * M),
    "z40 shifted": GearForm(teeth=40, module=M, pressure_angle=deg(20), profile_shift=0.6, addendum=0.9, bore=9 * M),
    "z12 saved by shift": GearForm(teeth=12, module=M, pressure_angle=deg(20), profile_shift=0.35, bore=2 * M),
    "z30 far out": GearForm(teeth=30, module=M, pressure_angle=deg(20), profile_shift=1.2, addendum=0.8, bore=5 * M),
    "helical": GearForm(teeth=23, module=M, pressure_angle=deg(20), helix_angle=deg(25), bore=5 * M),
}
RINGS = {
    "ring 84": GearForm(teeth=84, module=M, pressure_angle=deg(20), internal=True, bore=50 * M),
    "ring 81, full round": GearForm(teeth=81, module=M, pressure_angle=deg(25), internal=True, bore=50 * M),
    "ring helical": GearForm(
        teeth=57, module=M, pressure_angle=deg(20), helix_angle=deg(25), profile_shift=0.2, internal=True, bore=40 * M
    ),
}


def swept_by_the_rack(gear: GearForm, angles: Array) -> Array:
    """Radius of the gap's floor at angles from the middle of the gap, from the rack itself: the lowest of all places.

    The rounded rack tooth, flank and tip and corner, is set at 6401 places and looked at in the axes of the gear.
    """
    m, alpha, z = gear.module, gear.pressure_angle, gear.virtual_teeth
    rho = (
        0.38
        if gear.pressure_angle < deg(24)
        else (math.pi / 4 - 1.25 * math.tan(alpha)) / ((1 - math.sin(alpha)) / math.cos(alpha))
    )
    width = math.pi / 4 - gear.dedendum * math.tan(alpha) - rho * (1 - math.sin(alpha)) / math.cos(alpha)
    turn = np.linspace(alpha, math.pi / 2, 400)
    corner = np.stack([width + rho * np.cos(turn), rho - gear.dedendum - rho * np.sin(turn)])
    flank_y = np.linspace(corner[1, 0], 2.0, 600)
    flank = np.stack([corner[0, 0] + (flank_y - corner[1, 0]) * math.tan(alpha), flank_y])
    floor = np.stack([np.linspace(0, width, 60), np.full(60, -gear.dedendum)])
    rack = np.concatenate([floor, corner[:, ::-1], flank], axis=1)  # from the middle of the rack's tooth, in modules
    lowest = np.full(len(angles), np.inf)
    for rolled in np.linspace(-4, 4, 6401):
        x, y = rack[0] + rolled, rack[1] + gear.profile_shift + z / 2
        angle = np.arctan2(x, y) - rolled / (z / 2)
        radius = np.hypot(x, y)
        order = np.argsort(angle)
        here = np.interp(angles, angle[order], radius[order], left=np.inf, right=np.inf)
        lowest = np.minimum(lowest, here)
    return lowest * m


def gap_side(shape: Outline) -> tuple[Array, Array]:
    """Angles from the middle of the gap, rising, and radii."""
    return (shape.half_pitch - shape.psi)[::-1], shape.radius[::-1]


@pytest.mark.parametrize("name", [*GEARS])
def test_the_gap_is_what_the_rack_cuts(name: str) -> None:
    gear = GEARS[name]
    shape = tooth_outline(gear)
    angles, radii = gap_side(shape)
    inner = radii < shape.base + 0.8 * (shape.tip - shape.base)
    swept = swept_by_the_rack(gear, angles[inner])
    # distance across the outline; places of the rack stand 1.25e-3 modules apart and its points 2e-3, so that a flank
    # of curvature 1 per module between them is missed by some 1e-6; where it bends more, by up to 3e-5
    run, rise = radii * np.gradient(angles), np.gradient(radii)
    across = (radii[inner] - swept) * (run / np.hypot(run, rise))[inner]
    assert np.abs(across).max() < 5e-5 * gear.module


@pytest.mark.parametrize("gear", [*GEARS.values(), *RINGS.values()], ids=[*GEARS, *RINGS])
def test_flank_and_fillet_join_without_a_corner(gear: GearForm) -> None:
    shape = tooth_outline(gear)
    assert (np.diff(shape.psi) >= -1e-12).all() or name_is_cut(gear)
    # a step of the fillet turns its tangent by 70 deg / 400, one of an involute near its base circle by up to 0.8 deg
    turned = np.abs(np.diff(shape.slope[shape.form - 2 : shape.form + 4]))
    assert turned.max() < deg(1.6 if name_is_cut(gear) else 0.9)
    assert shape.psi[-1] == pytest.approx(shape.half_pitch, rel=1e-12)  # to the middle of the gap, by construction


def name_is_cut(gear: GearForm) -> bool:
    """17 teeth of 20 deg are undercut by 0.005 modules: the fillet leaves the base circle along the radius."""
    return gear.teeth == 17 and not gear.internal


@pytest.mark.parametrize("gear", [g for g in [*GEARS.values(), *RINGS.values()] if not g.helix_angle])
def test_tip_is_as_thick_as_the_geometry_says(gear: GearForm) -> None:
    shape = tooth_outline(gear)
    known = tip_thickness(
        gear.teeth,
        gear.module,
        gear.pressure_angle,
        0.0,
        tip_radius=gear.tip,
        profile_shift=gear.profile_shift,
        internal=gear.internal,
    )
    assert 2 * shape.psi[0] * shape.radius[0] == pytest.approx(known, rel=1e-12)  # the same formula twice: rounding


@pytest.mark.parametrize("name", [*RINGS])
def test_ring_fillet_is_an_arc_that_touches_the_root_circle(name: str) -> None:
    gear = RINGS[name]
    shape = tooth_outline(gear)
    arc = slice(shape.form + 1, shape.form + 390)
    x, y = shape.x[arc], shape.radius[arc] * np.cos(shape.psi[arc])
    matrix = np.column_stack([2 * x, 2 * y, np.ones_like(x)])
    cx, cy, rest = np.linalg.lstsq(matrix, x**2 + y**2, rcond=None)[0]
    rho = math.sqrt(rest + cx**2 + cy**2)
    assert np.hypot(x - cx, y - cy) == pytest.approx(rho, rel=1e-9)  # a least squares fit of numbers near 40 modules
    assert math.hypot(cx, cy) + rho == pytest.approx(shape.root, rel=1e-9)
    full = "full round" in name
    assert (rho < 0.38 * gear.module) if full else rho == pytest.approx(0.38 * gear.module, rel=1e-6)


def test_normal_section_of_a_helical_gear() -> None:
    # z_n = z/(cos^2 beta_b cos beta) by hand: sin beta_b = 0.42261826 * 0.93969262 = 0.39713127,
    # cos^2 beta_b = 0.84228675, times 0.90630779 = 0.76337103; 23/0.76337103 = 30.12952.
    gear = GEARS["helical"]
    assert gear.virtual_teeth == pytest.approx(30.12952, abs=2e-5)
    shape = tooth_outline(gear)
    assert shape.tip - shape.reference == pytest.approx(gear.module, rel=1e-12)  # heights stay


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"teeth": 10, "bore": 2e-3}, "undercuts"),
        ({"teeth": 12, "profile_shift": 0.9}, "pointed"),
        ({"tip_radius": 7e-3}, "no tooth is left"),
        ({"bore": 9e-3}, "no body"),
        ({"tip_rounding": 0.6}, "does not fit the tip of the rack"),
        ({"dedendum": 2.3}, "pointed before"),
    ],
)
def test_teeth_that_cannot_be_are_named(change: dict[str, Any], problem: str) -> None:
    with pytest.raises(ModelError, match=problem) as caught:
        tooth_outline(replace(GEARS["z19 25 deg"], pressure_angle=deg(20), **change), path="stages.main.sun")
    assert caught.value.path == "stages.main.sun"


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"bore": 42e-3}, "no body"),
        ({"tip_radius": 38e-3}, "inside its base circle"),
        ({"tip_rounding": 1.5}, "does not fit the gap"),
    ],
)
def test_rings_that_cannot_be_are_named(change: dict[str, Any], problem: str) -> None:
    with pytest.raises(ModelError, match=problem):
        tooth_outline(replace(RINGS["ring 84"], **change))


def test_the_undercut_message_says_what_would_do() -> None:
    gear = replace(GEARS["z17"], teeth=10, bore=2e-3)
    with pytest.raises(ModelError, match="undercuts") as caught:
        tooth_outline(gear)
    enough = float(caught.value.allowed.split()[4])
    tooth_outline(replace(gear, profile_shift=enough))
