"""Losses by the power flow against closed forms of Willis and Kreines, and against the balance of power."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.unit.train.gearings import pair

from epicyclic.errors import ModelError
from epicyclic.train.kinematics import Gearing, Kinematics, Tie, solve_kinematics
from epicyclic.train.power import LossyFlow, lossy_flow, require_flow

TIGHT = 1e-12  # rounding of a system of some ten torques


def plain(stage: str = "main", sun: int = 24, planet: int = 30, ring: int = 84) -> tuple[Gearing, ...]:
    return pair(stage, "sun", "planet", sun, planet), pair(stage, "planet", "ring", planet, ring, internal=True)


def meshed(sun: int = 32, ring: int = 77) -> tuple[Gearing, ...]:
    """Two planets to a branch, in mesh with each other: w_sun / w_ring = ring / sun with the carrier held."""
    return (
        pair("main", "sun", "p", sun, 19),
        pair("main", "p", "d", 19, 20),
        pair("main", "d", "ring", 20, ring, internal=True),
    )


def solved(gearings: tuple[Gearing, ...], ties: tuple[Tie, ...] = (), **given: Any) -> Kinematics:
    members = list(dict.fromkeys(m for g in gearings for m in (g.a, g.b, g.carrier) if m is not None))
    members += [name for tie in ties for name in (tie.a, tie.b) if name not in members]
    planets = ("planet", "p", "d", "first", "second")
    ends = [name for name in dict.fromkeys(members) if name.split(".")[-1] not in planets]
    return solve_kinematics(members=list(dict.fromkeys(members)), gearings=gearings, ties=ties, ends=ends, **given)


def driven(gearings: tuple[Gearing, ...], held: str, driver: str) -> Kinematics:
    return solved(
        gearings,
        held=[f"main.{held}"],
        speeds={f"main.{driver}": Fraction(1000)},
        torques={f"main.{driver}": 100.0},
    )


def flow_of(found: Kinematics, share: float | dict[str, float]) -> LossyFlow:
    shares = share if isinstance(share, dict) else {g.pair: share for g in found.gearings}
    flow = lossy_flow(found, shares)
    assert flow is not None
    balanced(found, flow)
    return flow


def balanced(found: Kinematics, flow: LossyFlow) -> None:
    """Power in and out differ by the losses; so do torques of every member balance, by power in any motion."""
    size = max(abs(value) for value in flow.power.values())
    lost = math.fsum(one.loss for one in flow.meshes.values())
    assert math.fsum(flow.power.values()) == pytest.approx(lost, abs=TIGHT * size)
    assert all(one.loss >= 0 for one in flow.meshes.values())
    for name in flow.kept:
        assert found.torque is not None
        assert flow.torque[name] == found.torque[name]


def ratio(flow: LossyFlow) -> float:
    """Power out per power in."""
    values = flow.power.values()
    return -math.fsum(value for value in values if value < 0) / math.fsum(value for value in values if value > 0)


def closed_form(i0: float, e0: float) -> dict[tuple[str, str], float]:
    """Efficiency by (held, driver), of a set whose sun and ring turn against each other, i0 < 0 [mueller1982]."""
    return {
        ("carrier", "sun"): e0,
        ("carrier", "ring"): e0,
        ("ring", "sun"): (1 - i0 * e0) / (1 - i0),
        ("ring", "carrier"): (1 - i0) / (1 - i0 / e0),
        ("sun", "ring"): (i0 - e0) / (i0 - 1),
        ("sun", "carrier"): (i0 - 1) / (i0 - 1 / e0),
    }


def closed_form_meshed(i0: float, e0: float) -> dict[tuple[str, str], float]:
    """The same where they turn one way, i0 > 1: held ring and held sun by the torque ratio T_r = -i0 e0^+-1 T_s."""
    return {
        ("carrier", "sun"): e0,
        ("carrier", "ring"): e0,
        ("ring", "sun"): (i0 * e0 - 1) / (i0 - 1),
        ("ring", "carrier"): (i0 - 1) / (i0 / e0 - 1),
        ("sun", "ring"): (i0 - 1 / e0) / (i0 - 1),
        ("sun", "carrier"): (i0 - 1) / (i0 - e0),
    }


CASES = list(closed_form(-3.0, 1.0))


@pytest.mark.parametrize(("held", "driver"), CASES)
def test_simple_set(held: str, driver: str) -> None:
    shares = {"stages.main.meshes.sun-planet": 0.013, "stages.main.meshes.planet-ring": 0.004}
    flow = flow_of(driven(plain(), held, driver), shares)
    assert ratio(flow) == pytest.approx(closed_form(-84 / 24, 0.987 * 0.996)[held, driver], rel=TIGHT)


@pytest.mark.parametrize(("held", "driver"), CASES)
def test_meshed_planets(held: str, driver: str) -> None:
    flow = flow_of(driven(meshed(), held, driver), 0.01)
    assert ratio(flow) == pytest.approx(closed_form_meshed(77 / 32, 0.99**3)[held, driver], rel=TIGHT)


def test_rolling_power_of_the_driver_takes_the_losses() -> None:
    """Ring held, sun drives: in the frame of the carrier the sun puts in its torque at the speed against it."""
    flow = flow_of(driven(plain(), "ring", "sun"), 0.02)
    sun, ring = (flow.meshes[f"stages.main.meshes.{name}"] for name in ("sun-planet", "planet-ring"))
    relative = 1000 * math.tau / 60 * (1 - 24 / 108)
    assert (sun.driver, ring.driver) == ("main.sun", "main.planet")
    assert sun.rolling == pytest.approx(100 * relative, rel=TIGHT)
    assert sun.loss == pytest.approx(0.02 * sun.rolling, rel=TIGHT)
    assert ring.rolling == pytest.approx(0.98 * sun.rolling, rel=TIGHT)


def test_a_stage_that_turns_as_a_block_loses_nothing() -> None:
    found = solved(
        plain(),
        speeds={"main.sun": Fraction(300), "main.carrier": Fraction(300)},
        torques={"main.sun": 100.0},
        balance=("main.carrier", "main.ring"),
    )
    flow = flow_of(found, 0.05)
    assert flow.torque == pytest.approx(found.torque, rel=TIGHT)
    assert {one.driver for one in flow.meshes.values()} == {""}


def test_what_is_stated_is_kept_and_the_other_end_follows() -> None:
    """The torque of the driven end stated: the driving one brings more."""
    found = solved(plain(), held=["main.ring"], speeds={"main.sun": Fraction(1000)}, torques={"main.carrier": -450.0})
    flow = flow_of(found, 0.02)
    eta = closed_form(-84 / 24, 0.98**2)["ring", "sun"]
    assert flow.torque["main.carrier"] == -450.0
    assert flow.torque["main.sun"] == pytest.approx(100 / eta, rel=TIGHT)


def test_of_torques_that_are_all_stated_the_driving_one_is_kept() -> None:
    found = solved(
        plain(),
        held=["main.ring"],
        speeds={"main.sun": Fraction(1000)},
        torques={"main.carrier": -450.0, "main.sun": 100.0},
    )
    flow = flow_of(found, 0.02)
    assert (flow.kept, flow.released) == (("main.sun",), ("main.carrier",))
    assert ratio(flow) == pytest.approx(closed_form(-84 / 24, 0.98**2)["ring", "sun"], rel=TIGHT)


def test_differential_of_two_inputs() -> None:
    """Sun and ring drive the carrier: sun drives the ring, T_r = i0' T_s with losses, by hand."""
    found = solved(
        plain(),
        speeds={"main.sun": Fraction(1000), "main.ring": Fraction(100)},
        torques={"main.sun": 100.0},
        balance=("main.ring", "main.carrier"),
    )
    assert found.power is not None
    assert found.power["main.sun"] > 0
    assert found.power["main.ring"] > 0
    flow = flow_of(found, 0.02)
    ring = 100 * 84 / 24 * 0.98**2
    assert flow.torque["main.ring"] == pytest.approx(ring, rel=TIGHT)
    assert flow.torque["main.carrier"] == pytest.approx(-100 - ring, rel=TIGHT)


def test_two_stages_in_series_multiply() -> None:
    found = solved(
        (*plain("low"), *plain("high", 30, 24, 78)),
        (Tie(name="shaft", a="low.sun", b="high.carrier"),),
        held=["low.ring", "high.ring"],
        speeds={"low.carrier": Fraction(20)},
        torques={"low.carrier": 5e4},
    )
    first = closed_form(-84 / 24, 0.98**2)["ring", "carrier"]
    second = closed_form(-78 / 30, 0.98**2)["ring", "carrier"]
    assert ratio(flow_of(found, 0.02)) == pytest.approx(first * second, rel=TIGHT)


def test_two_ways_that_join() -> None:
    """Encased differential: sun in, carrier and, through a star set, the ring to the output; each way by hand."""
    gearings = (*plain("diff", 37, 56, 149), *plain("star", 71, 39, 149))
    gearings = tuple(
        Gearing(**{name: getattr(g, name) for name in g.__slots__} | {"carrier": None}) if g.stage == "star" else g
        for g in gearings
    )
    ties = (
        Tie(name="ring-sun", a="diff.ring", b="star.sun"),
        Tie(name="ring-out", a="star.ring", b="out"),
        Tie(name="carrier-out", a="diff.carrier", b="out"),
    )
    found = solved(gearings, ties, speeds={"diff.sun": Fraction(3000)}, torques={"diff.sun": 1000.0}, balance=("out",))
    e0, k, back = 0.98**2, 149 / 37, 149 / 71  # ring and carrier turn in the ratio -back
    speed = 1 + k + k * back  # sun per carrier by Willis
    by_hand = (1 + k * e0 + k * e0 * back * e0) / speed
    assert ratio(flow_of(found, 0.02)) == pytest.approx(by_hand, rel=TIGHT)


def test_power_that_circulates() -> None:
    """Carrier drives, the ring is the output and drives the sun back through a side pair; power of each way by hand."""
    gearings = (*plain("main", 20, 20, 60), pair("side", "x", "y", 60, 60, carrier=False))
    ties = (
        Tie(name="ring-out", a="main.ring", b="out"),
        Tie(name="out-x", a="out", b="side.x"),
        Tie(name="y-sun", a="side.y", b="main.sun"),
    )
    found = solved(
        gearings, ties, speeds={"main.carrier": Fraction(300)}, torques={"main.carrier": 80.0}, balance=("out",)
    )
    flow = flow_of(found, 0.02)
    # the ring turns at 2, the sun at -2 per carrier: against the carrier the sun turns at -3 and drives
    sun = 80 / (1 + 3 * 0.98**2)  # torque on it, against the sense of the carrier
    out = 3 * 0.98**2 * sun * 2 - sun * 2 / 0.98
    assert ratio(flow) == pytest.approx(out / 80, rel=TIGHT)


def test_self_locking_that_needs_both_ends_to_drive() -> None:
    """Meshed planets with i0 = 41/40: losses of 6 % exceed 1/40, so that the sun alone cannot turn the carrier."""
    found = driven(meshed(40, 41), "ring", "sun")
    flow = lossy_flow(found, {g.pair: 0.02 for g in found.gearings})
    assert flow is not None
    balanced(found, flow)
    assert found.power is not None
    assert found.power["main.carrier"] < 0 < flow.power["main.carrier"]
    eta = -flow.power["main.carrier"] / flow.power["main.sun"]
    assert eta == pytest.approx(closed_form_meshed(41 / 40, 0.98**3)["ring", "sun"], rel=1e-10)  # a small difference
    # the other way it turns, badly
    assert ratio(flow_of(driven(meshed(40, 41), "ring", "carrier"), 0.02)) == pytest.approx(
        closed_form_meshed(41 / 40, 0.98**3)["ring", "carrier"], rel=1e-10
    )


def test_self_locking_under_a_stated_load_has_no_solution() -> None:
    found = solved(
        meshed(40, 41), held=["main.ring"], speeds={"main.sun": Fraction(1000)}, torques={"main.carrier": 100.0}
    )
    assert lossy_flow(found, {g.pair: 0.02 for g in found.gearings}) is None
    assert lossy_flow(found, {g.pair: 0.002 for g in found.gearings}) is not None


def test_a_closed_loop_of_equal_ratios_stays_near_the_lossless_torques() -> None:
    """Two equal stages side by side between the same shafts: friction in each supports a range of torques."""
    ties = (
        Tie(name="in", a="one.sun", b="two.sun"),
        Tie(name="out", a="one.carrier", b="two.carrier"),
    )
    found = solved(
        (*plain("one"), *plain("two")),
        ties,
        held=["one.ring", "two.ring"],
        speeds={"one.sun": Fraction(500)},
        torques={"one.sun": 100.0},
        balance=("two.carrier",),
    )
    flow = flow_of(found, 0.02)
    assert flow.indeterminate
    assert ratio(flow) == pytest.approx(closed_form(-84 / 24, 0.98**2)["ring", "sun"], rel=1e-9)
    halves = [flow.meshes[f"stages.{stage}.meshes.sun-planet"].torque for stage in ("one", "two")]
    assert halves[0] == pytest.approx(halves[1], rel=0.03)  # of the size of the losses


@settings(max_examples=60, deadline=None)
@given(
    st.integers(12, 60),
    st.integers(12, 60),
    st.fractions(-9, 9, max_denominator=20),
    st.fractions(-9, 9, max_denominator=20),
    st.floats(0, 0.2),
    st.floats(0, 0.2),
)
def test_losses_are_never_negative_and_balance(
    sun: int, planet: int, one: Fraction, other: Fraction, first: float, second: float
) -> None:
    """Any differential: where a solution exists its power balances, and its directions are those of its own torques."""
    assume(one != other)
    gearings = plain("main", sun, planet, sun + 2 * planet)
    found = solved(
        gearings,
        speeds={"main.sun": 100 * one, "main.carrier": 100 * other},
        torques={"main.sun": 100.0},
        balance=("main.ring", "main.carrier"),
    )
    flow = lossy_flow(found, dict(zip((g.pair for g in gearings), (first, second), strict=True)))
    assert flow is not None  # the torque of the sun says which gear drives
    scale = max(abs(value) for value in flow.power.values()) or 1.0
    lost = math.fsum(mesh.loss for mesh in flow.meshes.values())
    assert math.fsum(flow.power.values()) == pytest.approx(lost, abs=1e-11 * scale)
    sun_drives = one > other
    left = (1 - first) * (1 - second)
    ring = 100 * (sun + 2 * planet) / sun * (left if sun_drives else 1 / left)
    assert flow.torque["main.ring"] == pytest.approx(ring, rel=1e-11)


@pytest.mark.parametrize(
    ("given_keys", "path"), [({}, "operation.speed"), ({"speeds": {"main.sun": Fraction(100)}}, "operation.torque")]
)
def test_a_train_without_operation_is_refused(given_keys: dict[str, Any], path: str) -> None:
    with pytest.raises(ModelError) as refused:
        require_flow(solved(plain(), held=["main.ring"], **given_keys))
    assert refused.value.path == path
