"""What the kinematic solve refuses, and how its answers are named."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest

from epicyclic.errors import ModelError
from epicyclic.train.kinematics import Gearing, Kinematics, Tie, solve_kinematics, tones


def mesh(a: str, b: str, za: int, zb: int, internal: bool = False, carrier: str | None = "carrier") -> Gearing:
    return Gearing(
        pair=f"stages.main.meshes.{a}-{b}",
        stage="main",
        a=a,
        b=b,
        teeth_a=za,
        teeth_b=zb,
        internal=internal,
        carrier=carrier,
    )


SIMPLE: dict[str, Any] = {
    "members": ("sun", "planet", "ring", "carrier"),
    "gearings": (mesh("sun", "planet", 23, 17), mesh("planet", "ring", 17, 57, internal=True)),
    "ends": ("sun", "ring", "carrier"),
}


def simple(**changes: Any) -> Kinematics:
    return solve_kinematics(**{**SIMPLE, "held": ("ring",), **changes})


def refusal(**changes: Any) -> ModelError:
    with pytest.raises(ModelError) as caught:
        simple(**changes)
    return caught.value


def test_without_speeds_there_are_ratios_only() -> None:
    found = simple()
    assert found.freedoms == ("sun",)
    assert found.speed is found.torque is found.power is found.mesh_frequency is found.frame_speed is None
    assert found.ratio["carrier"]["sun"] == Fraction(23, 80)
    assert found.mesh_order == {"main": Fraction(23 * 57, 80)}
    assert found.held == ("ring",)


def test_the_first_end_is_the_freedom_unless_a_speed_is_given() -> None:
    assert simple(held=()).freedoms == ("sun", "ring")
    assert simple(speeds={"carrier": Fraction(7)}).freedoms == ("carrier",)
    assert simple(held=(), speeds={"carrier": Fraction(7), "planet": Fraction(1)}).freedoms == ("carrier", "planet")


def test_locked() -> None:
    error = refusal(held=("ring", "sun"))
    assert error.path == "operation.held"
    assert "locked" in str(error)
    assert "sun" in str(error)
    looped = (*SIMPLE["gearings"], mesh("sun", "ring", 23, 50))  # a wrong second path from sun to ring
    assert "locked" in str(refusal(gearings=looped))


def test_locked_on_purpose() -> None:
    found = simple(held=("ring", "carrier"), torques={"sun": 23.0})
    assert found.locked
    assert set((found.speed or {}).values()) == {0}
    assert found.mesh_frequency == {"main": Fraction(0)}
    assert found.torque == {"sun": 23.0, "planet": 0.0, "ring": 57.0, "carrier": -80.0}
    assert found.mesh_torque == {"stages.main.meshes.sun-planet": -17.0, "stages.main.meshes.planet-ring": -57.0}
    assert "locked, held ring, carrier" in repr(found)
    assert not simple().locked
    # teeth that lock each other are none, whatever loads them
    fixed = (mesh("sun", "ring", 23, 50, carrier=None), mesh("sun", "ring", 23, 51, carrier=None))
    bare = {"members": ("sun", "ring"), "gearings": fixed, "ends": ("sun", "ring")}
    assert "agree around every loop" in refusal(**bare, held=(), torques={"sun": 23.0}).allowed


def test_a_missing_carrier_is_named_where_it_locks_the_train() -> None:
    still = (mesh("sun", "planet", 23, 17, carrier=None), mesh("planet", "ring", 17, 57, internal=True, carrier=None))
    bare = {"members": ("sun", "planet", "ring"), "gearings": still, "ends": ("sun", "ring")}
    error = refusal(**bare)  # the ring is held, the planets turn about axes at rest
    assert error.path == "stages.main.carrier"
    assert "without a carrier table" in str(error)
    assert "[stages.main.carrier]" in error.allowed
    assert simple(**bare, held=()).ratio["ring"]["sun"] == Fraction(-23, 57)  # a star gear needs none
    assert refusal(**bare, held=("sun", "ring")).path == "operation.held"  # a carrier would not free it
    fixed = refusal(members=("a", "b"), gearings=(mesh("a", "b", 20, 30, carrier=None),), ends=("a", "b"), held=("a",))
    assert fixed.path == "operation.held"  # no planets: no carrier is missing


@pytest.mark.parametrize(
    ("changes", "path", "words"),
    [
        ({"speeds": {"ring": Fraction(5)}}, "operation.speed.ring", "held"),
        ({"speeds": {"sun": Fraction(80), "carrier": Fraction(24)}}, "operation.speed.carrier", "23 rpm"),
        ({"held": (), "speeds": {"sun": Fraction(80)}}, "operation.speed", "also the speed of ring"),
        ({"torques": {"ring": 1.0}}, "operation.torque.ring", "held"),
        ({"powers": {"sun": 1.0}}, "operation.power.sun", "not known"),
        ({"powers": {"ring": 1.0}, "speeds": {"sun": Fraction(1)}}, "operation.power.ring", "held"),
        (
            {"powers": {"sun": 1.0}, "torques": {"sun": 1.0}, "speeds": {"sun": Fraction(1)}},
            "operation.power.sun",
            "one of the two",
        ),
        ({"torques": {"sun": 23.0, "carrier": -70.0}}, "operation.torque", "need further -2.875 N m at sun"),
        ({"torques": {"sun": 23.0}, "ends": ()}, "operation.torque", "need further -80 N m at carrier"),
    ],
)
def test_refusals_name_path_and_cure(changes: dict[str, Any], path: str, words: str) -> None:
    error = refusal(**changes)
    assert error.path == path
    assert words in str(error)


def test_power_at_a_member_that_stands() -> None:
    tied = {"ties": (Tie(name="brake", a="ring", b="drum"),), "members": (*SIMPLE["members"], "drum")}
    error = refusal(**tied, held=("drum",), speeds={"sun": Fraction(1)}, powers={"ring": 5.0})
    assert error.path == "operation.power.ring"
    assert "does not turn" in str(error)


def test_several_ends_might_balance() -> None:
    shafts = {
        "members": (*SIMPLE["members"], "left", "right"),
        "ties": (Tie(name="l", a="carrier", b="left"), Tie(name="r", a="carrier", b="right")),
        "ends": ("sun", "ring", "carrier", "left", "right"),
        "torques": {"sun": 23.0},
    }
    error = refusal(**shafts)
    assert error.path == "operation.torque"
    assert "carrier, left, right" in str(error)
    assert "need further -23 N m at sun" in str(error)
    found = simple(**shafts, balance=("right",))
    assert found.torque is not None
    assert found.torque["right"] == -80.0
    assert found.torque["left"] == found.torque["carrier"] == 0.0


def test_messages_use_the_words_of_the_file() -> None:
    error = refusal(torques={"sun": 23.0, "carrier": -70.0})
    assert "at sun" in str(error)
    assert refusal(speeds={"sun": 1, "carrier": 1}).path == "operation.speed.carrier"


def test_torques_rounded_on_the_drawing_balance_exactly_in_the_end() -> None:
    found = simple(torques={"sun": 100e3, "carrier": -347826.0})  # exact: -347826.087
    assert found.torque is not None
    total = sum(found.torque.values())
    assert abs(total) < 1e-9  # [N m] rounding of 1e5-sized numbers
    assert found.torque["carrier"] == pytest.approx(-347826.0, rel=1e-6)  # the spread stays below what was rounded
    assert refusal(torques={"sun": 100e3, "carrier": -347800.0}).path == "operation.torque"


def test_torques_that_balance_leave_nothing_to_an_idle_end() -> None:
    members = {"members": (*SIMPLE["members"], "fan"), "ends": ("sun", "ring", "carrier", "fan")}
    found = simple(**members, ties=(Tie(name="t", a="carrier", b="fan"),), torques={"sun": 23.0, "carrier": -80.0})
    assert found.torque is not None
    assert found.torque["fan"] == 0.0
    assert found.torque["ring"] == 57.0


def test_doubly_held_members_share_by_least_norm() -> None:
    found = simple(
        members=(*SIMPLE["members"], "drum"),
        ties=(Tie(name="t", a="ring", b="drum"),),
        held=("ring", "drum"),
        torques={"sun": 23.0},
    )
    assert found.torque is not None
    assert found.torque["ring"] == found.torque["drum"] == 28.5


def test_a_stepped_shaft_gives_the_stage_a_second_tone() -> None:
    gearings = (
        mesh("sun", "star1", 24, 22, carrier=None),
        mesh("star2", "ring", 31, 99, internal=True, carrier=None),
    )
    found = solve_kinematics(
        members=("sun", "star1", "star2", "ring"),
        gearings=gearings,
        ties=(Tie(name="shaft", a="star1", b="star2"),),
        ends=("sun", "ring"),
        carriers={"main": None},
        speeds={"sun": Fraction(60)},
    )
    assert tones(gearings, found.ratio) == {
        "stages.main.meshes.sun-star1": "main",
        "stages.main.meshes.star2-ring": "main/star2-ring",
    }
    assert found.mesh_frequency == {"main": Fraction(24), "main/star2-ring": Fraction(24 * 31, 22)}
    assert found.mesh_order == found.mesh_frequency
    assert found.frame_speed == {"main": Fraction(0), "housing": Fraction(0)}
