"""Contact lines against counting, circles and curvature; separation beyond the path against drawn involutes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar
from tooth_oracles import contact_line_length

from epicyclic.teeth import geometry
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.path_of_contact import PlaneOfAction, contact_lines, corner_reach, tip_separation

Build = Callable[..., ContactPair]
KINDS: list[dict[str, Any]] = [
    {},
    {"helix": 12.0},
    {"helix": 25.0, "width": 80e-3},
    {"teeth_b": 89, "internal": True, "helix": 10.0},
]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("slices", [1, 7, 40])
def test_length_is_exact_at_every_phase(pair_of: Build, kind: dict[str, Any], slices: int) -> None:
    plane = pair_of(**kind).plane
    sigma = np.linspace(-3.3, 2.9, 97) + 1e-4  # no phase on the end of a path: spur lines begin there at once
    ours = contact_lines(plane, sigma, slices).length.sum(axis=(1, 2))
    overlap = plane.width * abs(plane.per_pitch)
    counted = contact_line_length(
        sigma, plane.limits, overlap, face_width=plane.width, base_helix_angle=plane.base_helix
    )
    assert ours == pytest.approx(counted, rel=1e-12)  # both are exact: rounding


@pytest.mark.parametrize("kind", KINDS)
def test_mean_length(pair_of: Build, kind: dict[str, Any]) -> None:
    plane = pair_of(**kind).plane
    sigma = (np.arange(4000) + 0.5) / 4000
    ours = contact_lines(plane, sigma, 5).length.sum(axis=(1, 2)).mean()
    mean = geometry.transverse_contact_ratio(plane.limits) * plane.width / math.cos(plane.base_helix)
    # midpoints of a piecewise constant (spur) length miss each of its steps by at most half an interval
    assert ours == pytest.approx(mean, rel=1 / 4000)


def test_pieces_follow_the_helix(pair_of: Build) -> None:
    plane = pair_of(helix=15.0).plane
    lines = contact_lines(plane, [0.2], 9)
    axial_pitch = math.pi * 5e-3 / math.sin(math.radians(15.0))  # p_x = pi m_n/sin beta
    j = int(np.argmax(lines.pair[0] == 0))  # the pair that stands at 0.2
    assert lines.sigma[0, j] == pytest.approx(0.2 + lines.zeta[0, j] / axial_pitch, rel=1e-12)
    turned = contact_lines(replace(plane, lean=-1), [0.2], 9)
    assert turned.length[0].sum(axis=1) == pytest.approx(lines.length[0].sum(axis=1), rel=1e-12)
    assert turned.length[0] == pytest.approx(lines.length[0, :, ::-1], rel=1e-12)


def test_pairs_keep_their_numbers(pair_of: Build) -> None:
    lines = contact_lines(pair_of().plane, np.array([0.1, 1.1, 2.1]), 1)
    for t in range(3):  # the pair at sigma is number 0 all the way, those behind it follow
        at = lines.sigma[t, :, 0][lines.length[t, :, 0] > 0]
        number = lines.pair[t][lines.length[t, :, 0] > 0]
        assert at == pytest.approx(0.1 + t - number, abs=1e-12)


def test_radii_at_the_ends_are_those_of_the_tips(pair_of: Build) -> None:
    for internal, teeth in ((False, 37), (True, 89)):
        plane = pair_of(teeth_b=teeth, internal=internal).plane
        tip_a = geometry.tip_radius(21, 5e-3, 0.0)
        tip_b = geometry.tip_radius(teeth, 5e-3, 0.0, internal=internal)
        assert float(plane.radius_a(plane.limits[1])) == pytest.approx(tip_a, rel=1e-12)
        assert float(plane.radius_b(plane.limits[0])) == pytest.approx(tip_b, rel=1e-12)
        pitch_point = plane.base_a / math.cos(plane.pressure_angle)
        assert float(plane.radius_a(0.0)) == pytest.approx(pitch_point, rel=1e-12)


def test_curvature_of_spur_and_helical_flanks(pair_of: Build) -> None:
    spur = pair_of().plane
    sine = math.sin(spur.pressure_angle)
    a, b = (base / math.cos(spur.pressure_angle) * sine for base in (spur.base_a, spur.base_b))
    assert float(spur.curvature_radius(0.0)) == pytest.approx(a * b / (a + b), rel=1e-12)
    slanted = replace(spur, base_helix=0.3)
    assert float(slanted.curvature_radius(0.0)) == pytest.approx(a * b / (a + b) / math.cos(0.3), rel=1e-12)
    ring = pair_of(teeth_b=89, internal=True).plane
    b = ring.base_b * math.tan(ring.pressure_angle)
    assert float(ring.curvature_radius(0.0)) == pytest.approx(a * b / (b - a), rel=1e-12)


def test_a_slide_takes_from_the_overlap(pair_of: Build) -> None:
    plane = replace(pair_of().plane, face_a=(-14e-3, 16e-3))
    assert plane.face == (-14e-3, 15e-3)
    assert contact_lines(plane, [0.05], 6).centre[0] == pytest.approx(-14e-3 + 29e-3 / 12)


def drawn_gap(p: PlaneOfAction, past: float) -> float:
    """Turn of gear a, times its base radius, that brings its flank to the tip of external gear b before the path."""
    alpha, ra, rb = p.pressure_angle, p.base_a, p.base_b
    pitch, low = p.base_pitch, p.limits[0]
    centre = (ra + rb) / math.cos(alpha)
    at_end = np.array([ra / math.cos(alpha) + low * pitch * math.sin(alpha), low * pitch * math.cos(alpha)])
    turn = past * pitch / rb  # b turns clockwise as sigma rises: back is counter-clockwise
    c, s = math.cos(turn), math.sin(turn)
    x, y = at_end - np.array([centre, 0.0])
    tip = np.array([centre + c * x - s * y, s * x + c * y])

    def flank(u: float, turned: float) -> NDArray[np.float64]:
        # involute as the end of a thread of length ra u that comes off the base circle at angle w
        w = math.tan(alpha) - alpha + (low - past) * pitch / ra + turned - u
        return ra * np.array([math.cos(w) - u * math.sin(w), math.sin(w) + u * math.cos(w)])

    def side(turned: float) -> float:
        radius = math.hypot(*tip)
        u = math.sqrt(radius**2 / ra**2 - 1)
        point = flank(u, turned)
        return math.atan2(tip[1], tip[0]) - math.atan2(point[1], point[0])

    return ra * float(brentq(side, -0.2, 0.2, xtol=1e-15))


@pytest.mark.parametrize("past", [0.01, 0.05, 0.2])
def test_separation_before_the_path_is_that_of_drawn_flanks(pair_of: Build, past: float) -> None:
    plane = pair_of().plane
    found = float(tip_separation(plane, plane.limits[0] - past))
    assert found == pytest.approx(drawn_gap(plane, past), rel=1e-8)  # both subtract angles of order 1 from each other
    assert found > 0


def test_separation_is_symmetric_and_quadratic(pair_of: Build) -> None:
    plane = pair_of(21, 21).plane
    past = np.array([1e-4, 2e-4, 4e-4])
    before, behind = tip_separation(plane, plane.limits[0] - past), tip_separation(plane, plane.limits[1] + past)
    assert before == pytest.approx(behind, rel=1e-6)  # angles of order 1 subtracted, 1e-16 over 1e-9 rad
    assert np.diff(np.log2(before)) == pytest.approx(2.0, abs=0.02)
    assert (tip_separation(plane, np.linspace(*plane.limits, 5)) == 0).all()
    ring = pair_of(teeth_b=89, internal=True).plane
    for out in (tip_separation(ring, ring.limits[0] - past), tip_separation(ring, ring.limits[1] + past)):
        assert np.diff(np.log2(out)) == pytest.approx(2.0, abs=0.02)
        assert (out > 0).all()


def test_reach_is_where_the_separation_is_what_was_asked(pair_of: Build) -> None:
    plane = pair_of().plane
    before, behind = corner_reach(plane, 20e-6)
    assert float(tip_separation(plane, plane.limits[0] - before)) == pytest.approx(20e-6, rel=1e-6)
    assert float(tip_separation(plane, plane.limits[1] + behind)) == pytest.approx(20e-6, rel=1e-6)
    nearest = minimize_scalar(
        lambda s: (float(tip_separation(plane, s)) - 20e-6) ** 2, bounds=(0.7, 1.2), method="bounded"
    )
    assert plane.limits[1] + behind == pytest.approx(nearest.x, abs=1e-3)
