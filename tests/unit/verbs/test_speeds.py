"""Ends of a sweep: mesh frequencies, speeds of the member given, shares of the operating speed."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.engine.source import Drive
from epicyclic.errors import ModelError
from epicyclic.train.train import Train
from epicyclic.verbs.options import mesh_frequency, relative_speed

TONE = 27.3125


@pytest.fixture(scope="module")
def ren() -> Train:
    return epicyclic.load("ren2021")


@pytest.mark.parametrize(
    ("value", "hertz"),
    [
        (20.0, 20.0),
        ("20 Hz", 20.0),
        ("0.6kHz", 600.0),
        (" 2e1 Hz ", 20.0),
        ("100 rpm", TONE),  # what the model gives the sun
        ("50 rpm", TONE / 2),
        ("150 %", 1.5 * TONE),
    ],
)
def test_every_way_to_say_a_speed(ren: Train, value: float | str, hertz: float) -> None:
    assert mesh_frequency(value, path="start", tone=TONE, train=ren) == pytest.approx(hertz, rel=1e-15)


@pytest.mark.parametrize("value", ["", "rpm", "-3 rpm", "0 %", "1.2.3 Hz", "nan Hz", "20 min", "1e400 rpm"])
def test_what_is_no_speed(ren: Train, value: str) -> None:
    with pytest.raises(ModelError, match=r"stop.*rpm"):
        mesh_frequency(value, path="stop", tone=TONE, train=ren)


def test_rpm_needs_a_member_that_turns() -> None:
    with pytest.raises(ModelError, match="which member"):
        mesh_frequency("100 rpm", path="start", tone=TONE, train=None)
    still = epicyclic.load("lin1999-n4")
    with pytest.raises(ModelError, match=r"operation\.speed"):
        mesh_frequency("100 rpm", path="start", tone=TONE, train=still)


def test_a_sweep_in_rpm_is_that_in_hertz(ren: Train) -> None:
    one = epicyclic.sweep(ren, start="50 rpm", stop="200 %", points=3)
    np.testing.assert_allclose(one.speed, [0.5, 1.25, 2.0], rtol=1e-12)
    system = epicyclic.assemble(ren)
    other = epicyclic.sweep(system, start=TONE / 2, stop="200 %", points=3)
    np.testing.assert_array_equal(one.dynamic_factor, other.dynamic_factor)
    with pytest.raises(ModelError, match="which member"):
        epicyclic.sweep(system, start="50 rpm")


def test_one_speed_between_two_ends_is_refused(ren: Train) -> None:
    with pytest.raises(ModelError, match="points = 1: one speed is no range"):
        epicyclic.sweep(ren, start="50 rpm", stop="60 rpm", points=1)
    np.testing.assert_allclose(epicyclic.sweep(ren, start="50 rpm", stop="50 rpm", points=1).speed, [0.5], rtol=1e-12)


@pytest.mark.parametrize(("value", "speed"), [("0.5", 0.5), ("13.65625 Hz", 0.5), ("50 rpm", 0.5), ("50 %", 0.5)])
def test_one_speed_takes_the_same_texts(ren: Train, value: str, speed: float) -> None:
    assert relative_speed(value, "relative_speed", Drive(ren)) == pytest.approx(speed, rel=1e-15)
    said = epicyclic.steady(ren, relative_speed=value)
    xr.testing.assert_allclose(said.mesh_force, epicyclic.steady(ren, relative_speed=speed).mesh_force)


def test_ends_of_a_range_go_without_speeds_of_ones_own(ren: Train) -> None:
    for verb in (epicyclic.sweep, epicyclic.stability):
        with pytest.raises(ModelError, match=r"relative_speed = \[0.5, 1.0\]: goes with neither start nor stop"):
            verb(ren, start="50 rpm", relative_speed=[0.5, 1.0])


def test_what_is_no_relative_speed() -> None:
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    with pytest.raises(ModelError, match=r"a model file or Train in place of a System whose operation\.speed"):
        epicyclic.steady(system, relative_speed="50 rpm")
    with pytest.raises(ModelError, match=r"^relative_speed = 2400 min: not a speed; allowed: .*kHz"):
        epicyclic.steady("ren2021", relative_speed="2400 min")
    with pytest.raises(ModelError, match=r"^operation.speed = 20 Hz: is relative to an operating speed"):
        epicyclic.modes("lin1999-n3", relative_speed="20 Hz")
