"""Kinematics and torque balance of published trains, exact where they are rational, and their invariants."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.train.kinematics import Gearing, Kinematics, Tie, solve_kinematics

ROUNDED = 1e-12  # relative: one conversion of an exact number to float and one product


def external(stage: str, a: str, b: str, teeth: tuple[int, int], carrier: str | None) -> Gearing:
    pair = f"stages.{stage}.meshes.{a}-{b}"
    a, b = f"{stage}.{a}", f"{stage}.{b}"
    return Gearing(
        pair=pair, stage=stage, a=a, b=b, teeth_a=teeth[0], teeth_b=teeth[1], internal=False, carrier=carrier
    )


def ring_mesh(stage: str, a: str, b: str, teeth: tuple[int, int], carrier: str | None) -> Gearing:
    pair = f"stages.{stage}.meshes.{a}-{b}"
    a, b = f"{stage}.{a}", f"{stage}.{b}"
    return Gearing(pair=pair, stage=stage, a=a, b=b, teeth_a=teeth[0], teeth_b=teeth[1], internal=True, carrier=carrier)


def planetary(stage: str, sun: int, planet: int, ring: int, *, star: bool = False) -> tuple[Gearing, Gearing]:
    carrier = None if star else f"{stage}.carrier"
    return (
        external(stage, "sun", "planet", (sun, planet), carrier),
        ring_mesh(stage, "planet", "ring", (planet, ring), carrier),
    )


def members_of(gearings: tuple[Gearing, ...], *more: str) -> list[str]:
    names = [name for g in gearings for name in (g.a, g.b, g.carrier) if name is not None]
    return list(dict.fromkeys([*names, *more]))


def watts_in(found: Kinematics) -> float:
    assert found.power is not None
    return sum(value for value in found.power.values() if value > 0)


def test_ring_held_at_100_rpm_and_100_kn_m() -> None:
    gearings = planetary("main", 23, 17, 57)
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        held=("main.ring",),
        speeds={"main.sun": Fraction(100)},
        torques={"main.sun": 100e3},
        ends=("main.sun", "main.ring", "main.carrier"),
    )
    assert found.speed is not None
    assert found.speed["main.carrier"] == Fraction(115, 4)
    radians = [float(found.speed[f"main.{m}"]) * math.tau / 60 for m in ("sun", "carrier", "planet")]
    assert radians == pytest.approx([10.472, 3.0107, -7.0840], abs=5e-5)  # printed to four decimals
    assert found.mesh_frequency == {"main": Fraction(437, 16)}
    assert float(found.mesh_frequency["main"]) == 27.3125
    assert found.frame_speed == {"main": Fraction(115, 4), "housing": Fraction(0)}
    assert found.torque is not None
    assert found.torque["main.carrier"] == pytest.approx(-(1 + 57 / 23) * 100e3, rel=ROUNDED)
    assert found.torque["main.ring"] == pytest.approx(57 / 23 * 100e3, rel=ROUNDED)
    assert found.torque["main.planet"] == 0.0
    assert found.mesh_torque is not None
    # The sun pushes the planets clockwise, they pull the held ring clockwise.
    assert found.mesh_torque["stages.main.meshes.sun-planet"] == pytest.approx(-17 / 23 * 100e3, rel=ROUNDED)
    assert found.mesh_torque["stages.main.meshes.planet-ring"] == pytest.approx(-57 / 23 * 100e3, rel=ROUNDED)
    assert found.power is not None
    assert sum(found.power.values()) == pytest.approx(0.0, abs=1e-12 * watts_in(found))


DIFFERENTIAL = planetary("differential", 37, 56, 149)
ENCASED = planetary("encased", 71, 39, 149, star=True)
COUPLINGS = (
    ("differential.ring", "g1"),
    ("g1", "f1"),
    ("f1", "encased.sun"),
    ("encased.ring", "g2"),
    ("g2", "f2"),
    ("f2", "output"),
    ("differential.carrier", "output"),
)


def encased(**load: float) -> Kinematics:
    gearings = (*DIFFERENTIAL, *ENCASED)
    return solve_kinematics(
        members=members_of(gearings, "g1", "f1", "g2", "f2", "output"),
        gearings=gearings,
        ties=tuple(Tie(name=f"{a}-{b}", a=a, b=b) for a, b in COUPLINGS),
        speeds={"differential.sun": Fraction(3000)},
        powers={"differential.sun": load["power"]} if load else None,
        balance=("output",) if load else (),
        carriers={"differential": "differential.carrier", "encased": None},
        ends=("differential.sun", "output", "g1", "f1", "g2", "f2"),
    )


def test_encased_differential_speeds() -> None:
    found = encased()
    assert found.freedoms == ("differential.sun",)
    ratio = 1 + Fraction(149, 37) * (1 + Fraction(149, 71))
    assert found.speed is not None
    assert found.speed["output"] == 3000 / ratio
    assert float(ratio) == pytest.approx(13.47811, abs=5e-6)  # five decimals printed
    assert float(found.speed["output"]) == pytest.approx(222.583, abs=5e-4)  # three decimals printed
    assert found.speed["encased.sun"] == found.speed["f1"] == Fraction(-149, 71) * found.speed["output"]
    assert float(found.speed["encased.sun"]) == pytest.approx(-467.111, abs=5e-4)  # three decimals printed
    assert found.mesh_frequency is not None
    assert found.mesh_frequency["differential"] / found.mesh_frequency["encased"] == Fraction(220, 71)
    assert float(found.mesh_frequency["differential"]) == pytest.approx(1712.740, abs=5e-4)  # three decimals printed
    assert float(found.mesh_frequency["encased"]) == pytest.approx(552.748, abs=5e-4)  # three decimals printed
    assert found.frame_speed == {
        "differential": found.speed["output"],
        "encased": Fraction(0),
        "housing": Fraction(0),
    }


def test_encased_differential_torques_and_power_split() -> None:
    found = encased(power=20e6)
    assert found.torque is not None
    assert found.mesh_torque is not None
    assert found.speed is not None
    given = found.torque["differential.sun"]
    assert given == pytest.approx(63.662e3, abs=0.5)  # [N m] printed in kN m with three decimals
    assert found.torque["output"] == pytest.approx(-858.043e3, abs=0.5)  # as above
    ring = -found.mesh_torque["stages.differential.meshes.planet-ring"]
    assert ring == pytest.approx(256.369e3, abs=0.5)  # as above
    assert found.mesh_torque["stages.encased.meshes.planet-ring"] == pytest.approx(538.013e3, abs=0.5)  # as above
    turn = math.tau / 60
    encased_path = -ring * float(found.speed["differential.ring"]) * turn
    carrier_path = (given + ring) * float(found.speed["output"]) * turn
    assert encased_path / 20e6 == pytest.approx(0.62702, abs=5e-6)  # per cent with three decimals
    assert carrier_path / 20e6 == pytest.approx(0.37298, abs=5e-6)  # as above
    assert found.power is not None
    assert sum(found.power.values()) == pytest.approx(0.0, abs=1e-12 * 20e6)


def meshed_double(held: str) -> Kinematics:
    stage, carrier = "main", "main.carrier"
    gearings = (
        external(stage, "sun", "p", (32, 19), carrier),
        external(stage, "p", "d", (19, 20), carrier),
        ring_mesh(stage, "d", "ring", (20, 77), carrier),
    )
    return solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        held=(f"main.{held}",),
        torques={"main.sun" if held != "sun" else "main.ring": 43.0},
        ends=("main.sun", "main.ring", "main.carrier"),
    )


def test_meshed_double_planets_in_three_cases() -> None:
    first, second, third = (meshed_double(held) for held in ("carrier", "ring", "sun"))
    assert first.ratio["main.ring"]["main.sun"] == Fraction(32, 77)
    assert second.ratio["main.carrier"]["main.sun"] == Fraction(32, 32 - 77)
    assert third.ratio["main.carrier"]["main.ring"] == Fraction(77, 77 - 32)
    for found in (first, second, third):
        assert found.torque is not None
        assert sum(found.torque.values()) == pytest.approx(0.0, abs=43 * ROUNDED)
        assert found.torque["main.ring"] == pytest.approx(-77 / 32 * found.torque["main.sun"], rel=ROUNDED)
        assert found.torque["main.p"] == found.torque["main.d"] == 0.0


def test_stepped_stars() -> None:
    gearings = (
        external("main", "sun", "star1", (24, 22), None),
        ring_mesh("main", "star2", "ring", (31, 99), None),
    )
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        ties=(Tie(name="shaft", a="main.star1", b="main.star2"),),
        speeds={"main.sun": Fraction(6800)},
        powers={"main.sun": 220e3},
        ends=("main.sun", "main.ring"),
    )
    ratio = found.ratio["main.ring"]["main.sun"]
    assert ratio == Fraction(-124, 363)
    assert float(-1 / ratio) == pytest.approx(2.9274, abs=5e-5)  # four decimals printed
    assert found.torque is not None
    assert found.torque["main.sun"] == pytest.approx(308.9, abs=0.06)  # one decimal printed, cut off not rounded
    assert found.torque["main.ring"] == pytest.approx(904.42, abs=0.005)  # two decimals printed
    assert sum(found.torque.values()) > 1000  # the housing that carries the stars takes the rest


def test_wind_gearbox_in_three_stages() -> None:
    low, middle = planetary("low", 19, 17, 56), planetary("middle", 18, 36, 93)
    gearings = (*low, *middle, external("high", "wheel", "pinion", (95, 24), None))
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        ties=(
            Tie(name="low-middle", a="low.sun", b="middle.carrier"),
            Tie(name="middle-high", a="middle.sun", b="high.wheel"),
        ),
        held=("low.ring", "middle.ring"),
        torques={"low.carrier": 4e6},
        ends=("low.carrier", "low.sun", "middle.carrier", "middle.sun", "high.wheel", "high.pinion"),
    )
    assert found.ratio["high.pinion"]["low.carrier"] == Fraction(-4625, 48)
    assert found.torque is not None
    assert found.torque["high.pinion"] == pytest.approx(4e6 * 48 / 4625, rel=ROUNDED)
    assert found.torque["low.sun"] == 0.0
    assert set(found.mesh_order) == {"low", "middle", "high"}
    assert found.mesh_order["high"] == Fraction(95 * 925, 38)
    assert found.mesh_order["low"] == 56  # the carrier passes the held ring


def test_two_freedoms_take_two_speeds() -> None:
    gearings = planetary("main", 23, 17, 57)
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        speeds={"main.ring": Fraction(-20), "main.sun": Fraction(100)},
        torques={"main.sun": 23.0},
        ends=("main.sun", "main.ring", "main.carrier"),
    )
    assert found.freedoms == ("main.ring", "main.sun")
    assert found.speed is not None
    assert found.speed["main.carrier"] == Fraction(23 * 100 - 57 * 20, 80)
    assert found.mesh_frequency == {"main": 23 * (100 - found.speed["main.carrier"]) / 60}
    assert found.mesh_order == {}
    assert found.torque is not None
    assert (found.torque["main.ring"], found.torque["main.carrier"]) == (57.0, -80.0)
    assert found.power is not None
    assert sum(found.power.values()) == pytest.approx(0.0, abs=1e-12 * watts_in(found))


def test_a_redundant_second_path_is_shared_by_least_norm() -> None:
    # Two equal pinions between the same two shafts.
    gearings = tuple(external("main", "wheel", pinion, (40, 20), None) for pinion in ("p1", "p2"))
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        ties=(Tie(name="t", a="main.p1", b="main.p2"),),
        torques={"main.wheel": 40.0},
        balance=("main.p1",),
    )
    assert found.mesh_torque is not None
    parts = list(found.mesh_torque.values())
    assert sum(parts) == pytest.approx(-20.0, rel=ROUNDED)
    assert min(parts) < max(parts) < 0  # the tie is a link of the loop too, p1 is nearer the load


TEETH = st.integers(12, 120)


@given(TEETH, TEETH, TEETH, st.integers(-3000, 3000), st.integers(-3000, 3000), st.integers(-500, 500))
@settings(max_examples=60, deadline=None)
def test_willis_and_equilibrium_for_any_teeth(zs: int, zp: int, zr: int, ns: int, nr: int, torque: int) -> None:
    gearings = planetary("main", zs, zp, zr)
    found = solve_kinematics(
        members=members_of(gearings),
        gearings=gearings,
        speeds={"main.sun": Fraction(ns), "main.ring": Fraction(nr)},
        torques={"main.sun": float(torque)},
        ends=("main.sun", "main.ring", "main.carrier"),
    )
    assert found.speed is not None
    assert found.torque is not None
    carrier = found.speed["main.carrier"]
    assert zs * (ns - carrier) == -zr * (nr - carrier)
    assert zp * (found.speed["main.planet"] - carrier) == zr * (nr - carrier)
    # Exact before the conversion to float, so one rounding each.
    assert sum(found.torque.values()) == pytest.approx(0.0, abs=1e-12 * (1 + abs(torque) * zr))
    assert found.torque["main.ring"] == pytest.approx(torque * zr / zs, rel=ROUNDED)
