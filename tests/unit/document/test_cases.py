"""Load cases of a model file: what they state, what they leave to the operation, and overrides of both."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from epicyclic import ModelError, load
from epicyclic.document.document import read
from epicyclic.document.units import Bounds, read_quantity
from epicyclic.document.writer import model_text
from epicyclic.train.resolution import correlations_of, resolved_document, tolerances_of
from epicyclic.warning_codes import CodedText

TEXT = """
format = 2
title = "Cases"
[stages.main]
planets = 3
module = "4 mm"
face_width = "50 mm"
sun.teeth = 24
planet.teeth = 30
ring.teeth = 84
carrier.mass = "40 kg"
carrier.inertia = "0.5 kg m^2"
[bodies.motor]
mass = "5 kg"
inertia = "0.02 kg m^2"
[couplings.clutch]
between = ["motor", "sun"]
rz = "1e5 N m/rad"
[operation]
held = ["ring"]
speed.motor = "1500 rpm"
torque.motor = "800 N m"
torque.carrier = "balance"
[loads.push]
on = "carrier"
force.x = "1 kN"
[cases.low]
speed.motor = "700 rpm"
torque.motor = "300 N m"
torque.carrier = "balance"
duration = "2 h"
[cases.driven]
power.carrier = "10 kW"
torque.motor = "balance"
loads.push = { on = "carrier", force = { x = "2 kN" } }
loads.lift = { on = "sun", force = { y = "3 kN" } }
duration = "30 min"
[cases.apart]
open = ["clutch"]
speed.sun = "10 rpm"
speed.motor = "20 rpm"
torque = { sun = "50 N m", carrier = "balance" }
"""
TABLES: dict[str, Any] = tomllib.loads(TEXT)


def solved(**overrides: object) -> tuple[dict[str, float], dict[str, float]]:
    train = load(TABLES, {path.replace("__", "."): value for path, value in overrides.items()}).kinematics
    assert train.speed is not None
    assert train.torque is not None
    return {name: float(value) for name, value in train.speed.items()}, dict(train.torque)


def test_a_case_replaces_what_it_states_and_leaves_the_rest() -> None:
    speed, torque = solved()
    assert (speed["motor"], torque["motor"]) == (1500, 800)
    speed, torque = solved(case="low")
    assert [speed["motor"], speed["main.carrier"]] == pytest.approx([700, 700 * 24 / 108])
    assert torque["main.carrier"] == pytest.approx(-300 * 108 / 24)
    assert speed["main.ring"] == 0  # held as in the operation


def test_a_power_of_a_case_stands_in_place_of_torques() -> None:
    _, torque = solved(case="driven")
    omega = 1500 * 24 / 108 * 2 * 3.141592653589793 / 60
    assert torque["main.carrier"] == pytest.approx(10e3 / omega)
    assert torque["motor"] == pytest.approx(-10e3 / omega * 24 / 108)


def test_loads_of_a_case_stand_beside_those_of_the_file_or_in_their_place() -> None:
    def forces(**overrides: object) -> dict[str, tuple[float, ...]]:
        return {one.path: one.force for one in load(TABLES, overrides).loads}

    assert forces() == {"loads.push": (1e3, 0.0, 0.0)}
    assert forces(case="low") == forces()
    assert forces(case="driven") == {"loads.push": (2e3, 0.0, 0.0), "loads.lift": (0.0, 3e3, 0.0)}
    assert forces(case="driven", **{"loads.push.force.x": "5 kN"})["loads.push"] == (5e3, 0.0, 0.0)


def test_an_open_coupling_carries_no_torque_and_its_ends_turn_apart() -> None:
    speed, torque = solved(case="apart")
    assert (speed["motor"], speed["main.sun"]) == (20, 10)
    assert (torque["motor"], torque["main.sun"]) == (0, 50)
    assert load(TABLES, {"case": "apart"}).links[-1].stiffness[5] == 0
    assert load(TABLES).links[-1].stiffness[5] == 1e5


def test_an_override_of_the_operation_changes_the_case_that_states_it() -> None:
    document = read(TABLES, {"case": "low", "operation.torque.motor": "111 N m"})
    assert document.data["cases"]["low"]["torque"]["motor"] == "111 N m"
    assert document.data["operation"]["torque"]["motor"] == "800 N m"
    assert document.origin["cases.low.torque.motor"] == "set"
    _, torque = solved(case="low", operation__torque__motor="111 N m")
    assert torque["motor"] == 111
    _, torque = solved(case="low", operation__power__motor="10 kW")  # in place of its torque
    assert torque["motor"] == pytest.approx(10e3 / (700 * 3.141592653589793 / 30))
    speed, _ = solved(case="driven", operation__speed__motor="600 rpm")  # which this case leaves to the operation
    assert speed["motor"] == 600


def test_what_is_removed_from_the_operation_is_removed_from_its_case() -> None:
    assert load(TABLES, {"case": "low", "operation.torque": None}).kinematics.torque is None


def test_the_text_of_a_document_reads_as_the_same_case() -> None:
    train = load(TABLES, {"case": "low", "operation.torque.motor": "111 N m"})
    again = load(tomllib.loads(model_text(resolved_document(train))))
    assert again.kinematics.torque == train.kinematics.torque
    assert again.kinematics.speed == train.kinematics.speed
    back = load(train.document, {"case": "driven"})
    assert back.kinematics.torque == load(TABLES, {"case": "driven"}).kinematics.torque


def test_durations_are_times() -> None:
    model = read(TABLES).model
    assert model.cases["low"].duration == read_quantity("2 h", ("time",), Bounds()) == 7200
    assert model.cases["driven"].duration == 1800


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"case": "lo"}, r"case = lo: no such case; did you mean 'low'\?; allowed: one of low, driven, apart"),
        ({"case": "all"}, "case = all: stands for every case, which a verb computes one by one"),
        ({"cases.all.duration": "1 h"}, "cases.all: stands for every case; allowed: another name"),
        ({"case": "low", "cases.low.speed.motor": "7 kN"}, r"cases.low.speed.motor = 7 kN"),
        ({"case": "low", "cases.low.speed.moter": "7 rpm"}, "cases.low.speed.main.moter = 7 rpm: no such member"),
        ({"cases.low.spede.motor": "7 rpm"}, r"cases.low.spede.*'speed'"),
        ({"cases.low.duration": "-1 h"}, r"cases.low.duration.*>= 0"),
        ({"cases.apart.share": 0.2}, "cases.low.duration.*beside shares.*cases.apart"),
        ({"cases.low.share": 0.2}, "cases.low.*duration"),
        (
            {"case": "apart", "cases.apart.open": ["clutsh"]},
            r"cases.apart.open = .'clutsh'.: no such coupling.*'clutch'",
        ),
        ({"case": "apart", "cases.apart.open": ["clutch", "clutch"]}, "cases.apart.open.*open twice"),
        (
            {"case": "apart", "couplings": None},
            r"cases.apart.open = .'clutch'.*a name of \[couplings\], which has none",
        ),
        ({"case": "low", "cases.low.held": ["ring", "motor"]}, "cases.low.speed.motor.*is held"),
        ({"case": "low", "cases.low.held": []}, "cases.low.speed"),
        ({"case": "low", "cases.low.torque.main.sun": "balance"}, r"cases.low.torque.*takes it already"),
        ({"case": "driven", "cases.driven.loads.lift.on": "snu"}, r"cases.driven.loads.lift.on.*'sun'"),
    ],
)
def test_errors_name_the_key_of_the_case(overrides: dict[str, object], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        load(TABLES, overrides)


def test_shares_are_the_whole_at_most() -> None:
    shares = {f"cases.{name}": {"share": share} for name, share in (("a", 0.7), ("b", 0.4))}
    with pytest.raises(ModelError, match=r"cases.b.share = 0.4: the shares of all cases add up to 1.1"):
        load({**TABLES, "cases": {}}, shares)


def test_a_coupling_with_bolts_does_not_open() -> None:
    bolts = {"count": 6, "radius": "40 mm", "tangential": "1e8 N/m"}
    tables = {**TABLES, "couplings": {"clutch": {"between": ["motor", "sun"], "bolts": bolts}}}
    with pytest.raises(ModelError, match=r"cases.apart.open = .'clutch'.: a coupling with bolts does not open"):
        load(tables, {"case": "apart"})


def test_a_tolerance_of_the_operation_is_not_drawn_in_a_case_that_states_its_own() -> None:
    law = "normal(800 N m, 40 N m)"
    tables = {
        **TABLES,
        "tolerance": {"operation.torque.motor": law, "cases.low.torque.motor": "normal(300 N m, 9 N m)"},
    }

    def drawn(case: str) -> tuple[list[str], list[CodedText]]:
        train = load(tables, {"case": case} if case else {})
        left = [text for text in train.warnings if "[tolerance-of-another-case]" in text]
        return [entry.path for entry in tolerances_of(train)], left

    assert drawn("") == (["operation.torque.motor"], [])
    assert drawn("driven")[0] == []  # a power of its own
    paths, (left,) = drawn("low")
    assert paths == ["cases.low.torque.motor"]
    assert left.startswith("case low states its own: not drawn are operation.torque.motor ")


def test_correlations_of_what_is_not_drawn_leave_those_of_the_others() -> None:
    entries = {name: f"deviations.planet.position.{name}" for name in "xy"}
    tables = {
        **TABLES,
        "tolerance": {
            **dict.fromkeys(entries.values(), "normal(0, 5 um)"),
            "operation.torque.motor": "normal(800 N m, 40 N m)",
            "correlation": {entries["x"]: {entries["y"]: 0.5}},
        },
    }
    (nominal,), (low,) = (correlations_of(load(tables, case)) for case in ({}, {"case": "low"}))
    assert nominal.paths == low.paths
    assert nominal.matrix.tolist() == low.matrix.tolist()
    assert low.matrix[0, 1] == 0.5
