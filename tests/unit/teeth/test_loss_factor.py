"""Loss factors against closed forms and sums over instants, sliding against two turning gears, friction by hand."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.teeth import geometry
from epicyclic.teeth.path_of_contact import (
    PlaneOfAction,
    Rolling,
    loss_factor,
    mean_friction,
    path_load,
    sliding_distance,
    touches_always,
)

ANGLE = math.radians(20)


def limits_of(z1: int, z2: int, x1: float, x2: float, helix: float, *, internal: bool = False) -> tuple[float, float]:
    working = geometry.working_pressure_angle(z1, z2, ANGLE, helix, shift_a=x1, shift_b=x2, internal=internal)
    return geometry.contact_limits(
        geometry.base_radius(z1, 1.0, ANGLE, helix),
        geometry.tip_radius(z1, 1.0, helix, profile_shift=x1),
        geometry.base_radius(z2, 1.0, ANGLE, helix),
        geometry.tip_radius(z2, 1.0, helix, profile_shift=x2, internal=internal, addendum=0.8 if internal else 1.0),
        working_pressure_angle=working,
        base_pitch=geometry.base_pitch(1.0, ANGLE, helix),
        internal=internal,
    )


def by_instants(limits: tuple[float, float], overlap: float, count: int = 1000) -> float:
    """Mean of |sigma| over instants, every contact line cut into pieces of equal load."""
    pieces = (np.arange(count) + 0.5) / count * overlap if overlap else np.zeros(1)
    found = []
    for phase in (np.arange(count) + 0.5) / count:
        sigma = phase + np.arange(-6, 9)[:, None] - pieces
        on = (sigma >= limits[0]) & (sigma <= limits[1])
        found.append(np.abs(sigma[on]).mean())
    return float(np.mean(found))


@pytest.mark.parametrize(("z1", "z2", "x1", "x2"), [(20, 60, 0.0, 0.0), (17, 40, 0.3, -0.2), (32, 19, 0.1, 0.2)])
def test_spur_pair_has_the_closed_form(z1: int, z2: int, x1: float, x2: float) -> None:
    limits = limits_of(z1, z2, x1, x2, 0.0)
    e2, e1, u = -limits[0], limits[1], z2 / z1
    assert 1 < e1 + e2 < 2
    assert max(e1, e2) < 1
    closed = math.pi * (u + 1) / (z1 * u) * (1 - e1 - e2 + e1**2 + e2**2)
    assert loss_factor(z1, z2, 0.0, sliding_distance(limits)) == pytest.approx(closed, rel=1e-13)


def test_ring_has_the_closed_form_of_the_difference() -> None:
    limits = limits_of(30, 84, 0.0, 0.0, 0.0, internal=True)
    e2, e1, u = -limits[0], limits[1], 84 / 30
    assert 1 < e1 + e2 < 2
    closed = math.pi * (u - 1) / (30 * u) * (1 - e1 - e2 + e1**2 + e2**2)
    assert loss_factor(30, 84, 0.0, sliding_distance(limits), internal=True) == pytest.approx(closed, rel=1e-13)


@pytest.mark.parametrize("overlap", [1.0, 2.0])
def test_helical_pair_of_whole_overlap_bears_evenly_along_the_path(overlap: float) -> None:
    """The contact lines then have one length at every instant: <|sigma|> is that of an even load on the path."""
    helix = math.radians(15)
    limits = limits_of(23, 61, 0.1, 0.0, helix)
    e2, e1, u = -limits[0], limits[1], 61 / 23
    base = geometry.base_helix_angle(ANGLE, helix)
    closed = math.pi * (u + 1) / (23 * u * math.cos(base)) * (e1**2 + e2**2) / (e1 + e2)
    assert loss_factor(23, 61, base, sliding_distance(limits, overlap)) == pytest.approx(closed, rel=1e-12)
    assert path_load(limits, overlap, np.linspace(*limits, 11)) == pytest.approx(1 / (e1 + e2), rel=1e-12)


@pytest.mark.parametrize("limits", [(-0.8, 0.75), (-1.1, 1.2), (-1.4, 0.9), (-0.2, 1.1), (0.1, 1.3)])
@pytest.mark.parametrize("overlap", [0.0, 0.07, 0.6, 1.4])
def test_mean_is_that_of_many_instants(limits: tuple[float, float], overlap: float) -> None:
    """Also contact ratios beyond 2, and a pitch point off the path."""
    assert sliding_distance(limits, overlap) == pytest.approx(by_instants(limits, overlap), rel=2e-3)  # of 1500 steps


@pytest.mark.parametrize("overlap", [0.07, 0.35, 1.4])
def test_mean_over_instants_is_the_mean_along_the_path(overlap: float) -> None:
    """Exactly: at each instant along the contact lines, or at each place over all instants, another integral."""
    limits = (-0.83, 0.71)
    bends = [0.0, *(end + shift for end in limits for shift in (overlap, 0.0, -overlap))]
    ends = sorted({*limits, *(bend + whole for bend in bends for whole in range(-3, 4) if -0.83 < bend + whole < 0.71)})
    at, weight = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for low, high in itertools.pairwise(ends):
        sigma = (low + high) / 2 + (high - low) / 2 * at
        total += (high - low) / 2 * float(weight @ (np.abs(sigma) * path_load(limits, overlap, sigma)))
    assert sliding_distance(limits, overlap) == pytest.approx(total, rel=1e-12)


def test_spur_teeth_are_the_limit_of_a_small_overlap() -> None:
    assert sliding_distance((-0.8, 0.75), 1e-6) == pytest.approx(sliding_distance((-0.8, 0.75)), rel=1e-5)


@settings(max_examples=60, deadline=None)
@given(st.floats(-1.5, 0.2), st.floats(0.0, 1.0), st.one_of(st.just(0.0), st.floats(1e-3, 3.0)))
def test_load_along_the_path_gives_the_whole_force_and_the_mean_distance(
    low: float, more: float, overlap: float
) -> None:
    limits = (low, low + 1.02 + more)
    edges = np.linspace(*limits, 20001)
    middle, step = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
    load = path_load(limits, overlap, middle)
    assert step * load.sum() == pytest.approx(1, abs=2e-4)  # a jump of spur teeth lies within one step
    assert step * (load @ np.abs(middle)) == pytest.approx(sliding_distance(limits, overlap), abs=4e-4)


def test_contact_that_is_lost_is_seen() -> None:
    assert touches_always((-0.5, 0.5), 0.0)
    assert not touches_always((-0.5, 0.499), 0.0)
    assert touches_always((-0.3, 0.3), 0.5)
    assert not touches_always((-0.3, 0.3), 0.39)


def plane(base_a: float, base_b: float, pitch: float, angle: float = ANGLE, *, internal: bool = False) -> PlaneOfAction:
    return PlaneOfAction(
        base_a=base_a,
        base_b=base_b,
        internal=internal,
        pressure_angle=angle,
        base_pitch=pitch,
        limits=(-1.0, 1.0),
        face_a=(0.0, 0.0),
        face_b=(0.0, 0.0),
    )


@pytest.mark.parametrize("internal", [False, True])
def test_flanks_slide_as_two_turning_gears_do(internal: bool) -> None:
    """Velocities at the contact, from the turning of both gears, against the speeds along the path."""
    z1, z2, turning = 24, 84, 12.0
    r1, r2 = (geometry.base_radius(z, 4e-3, ANGLE, 0.0) for z in (z1, z2))
    pitch = geometry.base_pitch(4e-3, ANGLE, 0.0)
    sigma = np.array([-0.6, 0.0, 0.5])
    rolling = Rolling.of(plane(r1, r2, pitch, internal=internal), sigma, turning * r1)
    # a pushes along the line of action, at ANGLE from the common tangent; the centre of b lies on the x axis
    along = np.array([math.sin(ANGLE), math.cos(ANGLE)])
    across = np.array([math.cos(ANGLE), -math.sin(ANGLE)])
    w1, w2 = turning, turning * z1 / z2 * (1 if internal else -1)
    distance = (r2 - r1 if internal else r1 + r2) / math.cos(ANGLE)
    centre = np.array([-distance if internal else distance, 0.0])
    for i, place in enumerate(sigma):
        at = np.array([r1 / math.cos(ANGLE), 0.0]) + place * pitch * along
        v1 = w1 * np.array([-at[1], at[0]])
        v2 = w2 * np.array([-(at - centre)[1], (at - centre)[0]])
        assert v1 @ along == pytest.approx(v2 @ along, rel=1e-12)  # they keep contact
        assert abs(v1 @ across - v2 @ across) == pytest.approx(abs(rolling.sliding[i]), abs=1e-12)
        assert rolling.specific_a[i] == pytest.approx((v1 - v2) @ across / (v1 @ across), abs=1e-12)
        assert rolling.specific_b[i] == pytest.approx((v2 - v1) @ across / (v2 @ across), abs=1e-12)


@pytest.mark.parametrize("internal", [False, True])
def test_loss_factor_is_friction_power_along_the_path(internal: bool) -> None:
    """Force times sliding speed, summed over the path, per power: a second way to H_V through speeds in m/s."""
    z1, z2, helix = 24, 84, math.radians(12)
    limits = limits_of(z1, z2, 0.0, 0.0, helix, internal=internal)
    base = geometry.base_helix_angle(ANGLE, helix)
    edges = np.linspace(*limits, 40001)
    middle, step = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
    base_a, base_b = (geometry.base_radius(z, 1.0, ANGLE, helix) for z in (z1, z2))
    pitch, angle = geometry.base_pitch(1.0, ANGLE, helix), geometry.transverse_pressure_angle(ANGLE, helix)
    rolling = Rolling.of(plane(base_a, base_b, pitch, angle, internal=internal), middle, 3.0)
    force = 500.0  # normal to the tooth; any
    lost = force * step * (path_load(limits, 0.7, middle) @ np.abs(rolling.sliding))
    found = loss_factor(z1, z2, base, sliding_distance(limits, 0.7), internal=internal)
    assert found == pytest.approx(lost / (force * math.cos(base) * 3.0), rel=1e-7)  # steps of the sum


def test_specific_sliding_has_no_bound_at_a_base_tangent_point() -> None:
    r1, pitch = geometry.base_radius(20, 1.0, ANGLE, 0.0), geometry.base_pitch(1.0, ANGLE, 0.0)
    tangent = -r1 * math.tan(ANGLE) / pitch
    rolling = Rolling.of(plane(r1, 2 * r1, pitch), [tangent], 1.0)
    assert abs(rolling.specific_a[0]) > 1e12
    assert rolling.specific_b[0] == pytest.approx(1.0)


def test_friction_by_hand() -> None:
    """300 N/mm at 4 m/s and 15 mm, 20 mPa s, 0.6 um: load term 5 N s/(mm m mm)."""
    # logarithms: ln 0.048 + 0.2 ln 5 - 0.05 ln 20 + 0.25 ln 0.6 = -3.036554 + 0.321888 - 0.149787 - 0.127706
    by_hand = math.exp(-2.992159)
    assert mean_friction(300e3, 4.0, 15e-3, 20e-3, 0.6e-6) == pytest.approx(by_hand, rel=2e-6)
