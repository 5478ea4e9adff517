"""Teeth as drawn: thickness, contact at the pitch point, and no tooth inside another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from epicyclic import check
from epicyclic.show.drawing.bodies import (
    Area,
    Mating,
    Part,
    ToothForm,
    half_angle,
    lines_of,
    matings,
    one_per_place,
    parts,
    pitch_radius,
    rotations,
    tooth_form,
    tooth_path,
)

Array = NDArray[np.float64]


def turns(check: xr.Dataset, found: Sequence[Part]) -> dict[str, float]:
    """Polar angle of one tooth centre of every gear of these bodies."""
    return rotations({part.name: part.form for part in found if part.form is not None}, matings(check))


def outline(form: ToothForm, turn: float, *, points: int = 4) -> tuple[Array, Array]:
    """Outline of a whole gear about its axis, one tooth centred at an angle [mm]."""
    (line,) = lines_of(Area(role="body", turn=turn, contours=(tooth_path(form, points=points),)))
    return line.real, line.imag


def gear(teeth: int, *, internal: bool = False, shift: float = 0.0, module: float = 1.0) -> ToothForm:
    reference, alpha, out = module * teeth / 2, math.radians(20), -1 if internal else 1
    return tooth_form(
        teeth=teeth,
        internal=internal,
        base_radius=reference * math.cos(alpha),
        reference_radius=reference,
        tip_radius=reference + out * module * (1 + out * shift),
        root_radius=reference - out * module * (1.25 - out * shift),
        profile_shift=shift,
        pressure_angle=alpha,
    )


@given(teeth=st.integers(12, 200), shift=st.floats(-0.3, 0.6), internal=st.booleans())
def test_thickness_at_the_reference_circle(teeth: int, shift: float, internal: bool) -> None:
    form = gear(teeth, shift=shift, internal=internal)
    expected = (math.pi / 2 + 2 * shift * math.tan(math.radians(20))) / teeth
    # rounding of a difference of two involutes
    assert half_angle(form, form.reference_radius) == pytest.approx(expected, rel=1e-12)


@given(teeth=st.integers(18, 120), internal=st.booleans())
def test_an_outline_closes_and_stays_between_root_and_tip(teeth: int, internal: bool) -> None:
    form = gear(teeth, internal=internal)
    x, y = outline(form, 0.3)
    radius = np.hypot(x, y)
    assert (x[0], y[0]) == (x[-1], y[-1])
    # the circles are hit by points of the outline, to rounding
    assert radius.min() == pytest.approx(1e3 * min(form.tip_radius, form.root_radius), rel=1e-12)
    assert radius.max() == pytest.approx(1e3 * max(form.tip_radius, form.root_radius), rel=1e-12)
    # a tooth is what lies beyond the middle of its height
    beyond = np.abs(radius - 1e3 * form.root_radius) > 1e3 * abs(form.tip_radius - form.root_radius) / 2
    assert np.sum(np.diff(beyond.astype(int)) == 1) == teeth


def depth(points: tuple[Array, Array], form: ToothForm, turn: float) -> float:
    """How deep points (about the axis of `form`) lie inside its material along the circumference, over the module."""
    x, y = points
    radius = np.hypot(x, y)
    low, high = sorted((form.tip_radius, form.root_radius))
    active = (radius > max(low, form.base_radius)) & (radius < high)
    pitch = 2 * math.pi / form.teeth
    away = np.abs((np.arctan2(y, x) - turn + pitch / 2) % pitch - pitch / 2)
    inside = (half_angle(form, radius) - away) * radius
    return float(inside[active].max()) / (2 * form.reference_radius / form.teeth)


def worst(check: xr.Dataset) -> dict[tuple[str, str], float]:
    found = {part.name: part for part in one_per_place(parts(check))}
    turned = turns(check, list(found.values()))
    result = {}
    for mating in matings(check):
        a, b = found.get(mating.a), found.get(mating.b)
        if a is None or b is None or a.form is None or b.form is None:
            continue
        x, y = outline(a.form, turned[a.name], points=25)
        result[a.name, b.name] = depth((x / 1e3 + a.x - b.x, y / 1e3 + a.y - b.y), b.form, turned[b.name])
    return result


def test_teeth_touch_and_do_not_cut_where_the_train_can_be_assembled(lin: dict[str, xr.Dataset]) -> None:
    depths = worst(lin["check"])
    assert len(depths) == 8
    # gears without backlash touch on both flanks: depth 0; interpolation between 25 points on a flank leaves 1e-3
    assert max(depths.values()) < 2e-3
    assert min(depths.values()) > -2e-3


def test_teeth_do_cut_where_the_train_cannot_be_assembled(ren: dict[str, xr.Dataset]) -> None:
    depths = worst(ren["check"])
    assert depths["main/planet/1", "main/ring/left"] < 2e-3
    # a third of a pitch off: the drawing shows what the warning says
    assert depths["main/planet/2", "main/ring/left"] > 0.3


@given(start=st.floats(-0.5, 0.5), flank=st.sampled_from([1, -1]), ring=st.booleans(), place=st.floats(0, 6.28))
def test_a_gear_is_placed_alike_from_either_end_of_a_chain(start: float, flank: int, ring: bool, place: float) -> None:
    forms = {"a": gear(23), "b": gear(31), "c": gear(97, internal=ring)}
    alpha = math.radians(20)
    first = Mating(a="a", b="b", direction=place, pressure_angle=alpha, flank=flank)
    second = Mating(a="b", b="c", direction=1.0, pressure_angle=alpha, flank=-flank, sigma=start)
    backward = rotations(forms, [second, first])
    # sigma of gear a from its tooth: half the tooth at the pitch circle is pi/2z without shift
    sigma = flank * 23 / (2 * math.pi) * (backward["a"] + flank * math.pi / 46 - place)
    forward = rotations(forms, [replace(first, sigma=sigma), second])
    for name, form in forms.items():
        # whole pitches apart, to rounding
        assert math.sin((forward[name] - backward[name]) * form.teeth / 2) == pytest.approx(0, abs=1e-9)


def test_the_first_contact_moves_with_the_sense_of_driving(ren: dict[str, xr.Dataset]) -> None:
    check = ren["check"].copy(deep=True)
    check["phase_lead"][:] = 0.1
    ahead = turns(check, parts(check))["main/sun"]
    check["speed"] *= -1
    behind = turns(check, parts(check))["main/sun"]
    # a lead of a tenth of a pitch, forward where the sun drives and back where it is driven; rounding
    assert ahead - behind == pytest.approx(2 * 0.1 * 2 * math.pi / 23, rel=1e-9)


@pytest.mark.parametrize("drive", ["lin1999-n4", "dong2019", "ren2021", "yue2014-i"])
def test_pitch_circles_touch_also_where_printed_radii_do_not(drive: str) -> None:
    """Radii that belong to neither the teeth nor the centre distance give way to those."""
    found = check(drive)
    place = {part.name: part for part in parts(found)}
    for one in matings(found):
        a, b = place[one.a], place[one.b]
        assert a.form is not None
        assert b.form is not None
        between = (
            pitch_radius(b, one) - pitch_radius(a, one)
            if b.form.internal
            else pitch_radius(a, one) + pitch_radius(b, one)
        )
        assert between == pytest.approx(math.hypot(a.x - b.x, a.y - b.y), rel=1e-3)
        # the gears keep their teeth, and the proportion of these
        assert 2 < abs(a.form.tip_radius - a.form.root_radius) * a.form.teeth / (2 * a.form.reference_radius) < 2.6
