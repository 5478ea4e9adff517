"""Power paths against textbook splits: a plain set, two parallel ways, and a circle of power."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.train.gearings import pair

from epicyclic.train.kinematics import Gearing, Kinematics, Tie, solve_kinematics
from epicyclic.train.power import PowerPath, power_flow

MAIN = (pair("main", "sun", "planet", 20, 20), pair("main", "planet", "ring", 20, 60, internal=True))
SUNS = {"main.sun": 100, "main.two": 100, "main.planet": -100, "main.second": -100, "main.carrier": 0}
MEMBERS = ("main.sun", "main.planet", "main.ring", "main.carrier")


def flow(gearings: tuple[Gearing, ...], ties: tuple[Tie, ...], **given: Any) -> tuple[Kinematics, dict[str, PowerPath]]:
    found = solve_kinematics(gearings=gearings, ties=ties, **given)
    return found, {path.path: path for path in power_flow(found, planets={"main.planet"})}


def test_a_plain_set_passes_its_power_from_mesh_to_mesh() -> None:
    found, paths = flow(
        MAIN,
        (),
        members=MEMBERS,
        held=("main.ring",),
        speeds={"main.sun": Fraction(1000)},
        torques={"main.sun": 100.0},
        balance=("main.carrier",),
    )
    omega = 1000 * math.tau / 60
    # the sun turns about an axis at rest: all it takes goes through its teeth, and on through the pins
    assert paths["stages.main.meshes.sun-planet"].power == pytest.approx(100 * omega, rel=1e-12)
    assert paths["stages.main.planet.bearing"].power == pytest.approx(100 * omega, rel=1e-12)
    assert paths["stages.main.planet.bearing"].torque == pytest.approx(400, rel=1e-12)
    # sun at 1000 rpm and carrier at 250 rpm: the teeth roll with 3/4 of the power
    for mesh in ("sun-planet", "planet-ring"):
        assert paths[f"stages.main.meshes.{mesh}"].rolling == pytest.approx(0.75 * 100 * omega, rel=1e-12)
    # the ring is pushed backwards; what holds it pushes forwards
    assert paths["stages.main.meshes.planet-ring"].torque == pytest.approx(-300, rel=1e-12)
    assert paths["stages.main.meshes.planet-ring"].power == 0  # the ring stands
    assert not any(path.circulating for path in paths.values())
    assert found.power is not None


def closed(ratio: int) -> dict[str, PowerPath]:
    """Carrier drives; ring is the output; the sun is geared back to the output: ring : sun = 1 : ratio."""
    side = pair("side", "x", "y", 60, 60 // abs(ratio), internal=ratio > 0, carrier=False)
    ties = (
        Tie(name="ring-out", a="main.ring", b="out"),
        Tie(name="out-x", a="out", b="side.x"),
        Tie(name="y-sun", a="side.y", b="main.sun"),
    )
    return flow(
        (*MAIN, side),
        ties,
        members=(*MEMBERS, "side.x", "side.y", "out"),
        speeds={"main.carrier": Fraction(300)},
        torques={"main.carrier": 80.0},
        balance=("out",),
    )[1]


def test_two_ways_in_parallel() -> None:
    """ring = 80 / (60 + 20 r) of the carrier's speed: the ring's way carries 3/4 of the torque at that speed."""
    paths = closed(2)
    driven, ring = 80 * 300 * math.tau / 60, 80 / (60 + 20 * 2)
    assert paths["couplings.ring-out"].power == pytest.approx(0.75 * ring * driven, rel=1e-12)
    # the sun drives y, y drives x, x drives the output: against the order in which they are written
    assert paths["couplings.y-sun"].power == pytest.approx(-0.25 * 2 * ring * driven, rel=1e-12)
    assert paths["couplings.out-x"].power == pytest.approx(-0.25 * 2 * ring * driven, rel=1e-12)
    assert not any(path.circulating for path in paths.values())


def test_a_circle_of_power() -> None:
    """With the sun turning backwards the ring carries more than the input, and the sun brings the excess back."""
    paths = closed(-1)
    driven, ring = 80 * 300 * math.tau / 60, 80 / (60 - 20)
    assert paths["couplings.ring-out"].power == pytest.approx(1.5 * driven, rel=1e-12)
    assert ring == 2
    for way in ("couplings.out-x", "couplings.y-sun"):
        assert paths[way].power == pytest.approx(0.5 * driven, rel=1e-12)
        assert paths[way].circulating
    assert paths["couplings.ring-out"].circulating
    assert paths["stages.side.meshes.x-y"].circulating
    # the sun gives to the planets what comes back; the ring takes it from them again with the input
    assert paths["stages.main.meshes.sun-planet"].circulating
    assert paths["stages.main.meshes.sun-planet"].power == pytest.approx(0.5 * driven, rel=1e-12)
    assert paths["stages.main.meshes.planet-ring"].circulating
    assert not paths["stages.main.planet.bearing"].circulating  # the way in


def test_power_that_returns_through_two_suns_of_one_stage() -> None:
    """Two suns on one shaft, two planets on another, braced against each other: power goes round inside one stage."""
    gearings = (pair("main", "sun", "planet", 20, 20), pair("main", "two", "second", 20, 20))
    ties = (
        Tie(name="main.second", a="main.planet", b="main.second"),
        Tie(name="suns", a="main.sun", b="main.two"),
    )
    found = Kinematics(
        freedoms=("main.sun",),
        ratio={},
        speed={name: Fraction(value) for name, value in SUNS.items()},
        mesh_torque={gearings[0].pair: 50.0, gearings[1].pair: -50.0},
        tie_torque={"main.second": 50.0, "suns": 50.0},
        power={name: 0.0 for name in SUNS} | {"main.sun": 1.0},
        gearings=gearings,
        ties=ties,
    )
    flows = power_flow(found, planets={"main.planet", "main.second"})
    assert {path.path for path in flows if path.circulating} == {
        "stages.main.second",
        "couplings.suns",
        *(g.pair for g in gearings),
    }


@given(st.integers(-9, 9).filter(lambda ratio: ratio not in (0, -3)))
def test_what_exceeds_the_input_circulates(ratio: int) -> None:
    """Every closed train: a path between members of more power than the input is on a closed path; sums are zero."""
    driven = 80 * 300 * math.tau / 60
    for path in closed(ratio).values():
        if abs(path.power) > driven * (1 + 1e-9):  # rounding
            assert path.circulating


def test_nothing_without_speed_or_torque() -> None:
    for speeds in ({}, {"main.sun": Fraction(10)}):
        found = solve_kinematics(members=MEMBERS, gearings=MAIN, held=("main.ring",), speeds=speeds)
        assert power_flow(found) == ()
