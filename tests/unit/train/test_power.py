"""Power paths against textbook splits: a plain set, two parallel ways, and a circle of power."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest

from epicyclic.train import power
from epicyclic.train.kinematics import Gearing, Kinematics, Tie, solve_kinematics
from epicyclic.train.power import PowerPath, power_flow


def pair(stage: str, a: str, b: str, za: int, zb: int, *, internal: bool = False, carrier: bool = True) -> Gearing:
    return Gearing(
        pair=f"stages.{stage}.meshes.{a}-{b}",
        stage=stage,
        a=f"{stage}.{a}",
        b=f"{stage}.{b}",
        teeth_a=za,
        teeth_b=zb,
        internal=internal,
        carrier=f"{stage}.carrier" if carrier else None,
    )


MAIN = (pair("main", "sun", "planet", 20, 20), pair("main", "planet", "ring", 20, 60, internal=True))
MEMBERS = ("main.sun", "main.planet", "main.ring", "main.carrier")


def flow(gearings: tuple[Gearing, ...], ties: tuple[Tie, ...], **given: Any) -> tuple[Kinematics, dict[str, PowerPath]]:
    found = solve_kinematics(gearings=gearings, ties=ties, **given)
    return found, {path.path: path for path in power_flow(found, gearings, ties)}


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
    # planet: -(1000 - 250) rpm relative to the carrier at 250 rpm, torque -100 N m
    assert paths["stages.main.meshes.sun-planet"].power == pytest.approx(100 * 0.5 * omega, rel=1e-12)
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
    assert not paths["stages.main.meshes.sun-planet"].circulating


def test_a_stage_passes_on_what_it_takes() -> None:
    found, _ = flow(
        MAIN,
        (),
        members=MEMBERS,
        speeds={"main.carrier": Fraction(300), "main.ring": Fraction(100)},
        torques={"main.carrier": 80.0},
        balance=("main.sun", "main.ring"),
    )
    assert found.mesh_torque is not None
    assert found.speed is not None
    assert found.power is not None
    given = power._stage_flows(MAIN, found.mesh_torque, found.speed)
    scale = 80 * 300 * math.tau / 60
    assert sum(given.values()) == pytest.approx(0, abs=1e-12 * scale)  # rounding
    for member in MEMBERS:
        # what the stage gives to a member leaves it at the other end
        assert given["stages/main", member] == pytest.approx(-found.power[member], abs=1e-12 * scale)


def test_nothing_without_speed_or_torque() -> None:
    for speeds in ({}, {"main.sun": Fraction(10)}):
        found = solve_kinematics(members=MEMBERS, gearings=MAIN, held=("main.ring",), speeds=speeds)
        assert power_flow(found, MAIN, ()) == ()
