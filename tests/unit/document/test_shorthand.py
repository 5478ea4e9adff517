"""Shorthands and alternatives: what they expand to, and in which layer they clash."""

from __future__ import annotations

from typing import Any

import pytest

from epicyclic.document.overrides import check_alternatives, replace_alternatives
from epicyclic.document.schema import collect
from epicyclic.document.tables import REMOVE, expand
from epicyclic.errors import ModelError

Tables = dict[str, Any]
BASE: Tables = {"stages": {"main": {"sun": {}, "planet": {}, "ring": {}, "carrier": {}}}, "bodies": {"g1": {}}}
TWO: Tables = {"stages": {"low": {"sun": {}, "planet": {}}, "high": {"sun": {}}}}


def expanded(layer: Tables, base: Tables = BASE) -> Tables:
    return expand(layer, collect(base, layer))


def sun(table: Tables) -> Tables:
    return {"stages": {"main": {"sun": table}}}


@pytest.mark.parametrize(
    ("short", "long"),
    [
        ({"radial": 1, "z": 2}, {"x": 1, "y": 1, "z": 2}),
        ({"tilt": 3}, {"rx": 3, "ry": 3}),
        ({"damping": 5}, {"damping": {"x": 5, "y": 5, "z": 5}}),
        ({"damping": {"radial": 5, "rz": 1}}, {"damping": {"x": 5, "y": 5, "rz": 1}}),
        ({"front": {"radial": 1, "at": 2}}, {"front": {"x": 1, "y": 1, "at": 2}}),
        ({"to": "carrier"}, {"to": "main.carrier"}),
        ({"radial": REMOVE}, {"x": REMOVE, "y": REMOVE}),
    ],
)
def test_link(short: Tables, long: Tables) -> None:
    assert expanded(sun({"support": short})) == sun({"support": long})
    assert expanded(sun({"left": {"support": short}})) == sun({"left": {"support": long}})
    assert expanded({"bodies": {"g1": {"support": short}}}) == {"bodies": {"g1": {"support": long}}}


@pytest.mark.parametrize("table", [{"radial": 1, "x": 2}, {"x": 2, "radial": 1}, {"tilt": 1, "ry": 0}])
def test_shorthand_beside_what_it_stands_for(table: Tables) -> None:
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.support\..* stands beside"):
        expanded(sun({"support": table}))


@pytest.mark.parametrize(
    ("short", "long"),
    [
        ({"sun": {"run_out": "20 um"}}, {"main": {"sun": {"run_out": {"amplitude": "20 um"}}}}),
        ({"main": {"sun": {"run_out": 1}}}, {"main": {"sun": {"run_out": {"amplitude": 1}}}}),
        ({"sun": {"run_out": {"x": 1}}}, {"main": {"sun": {"run_out": {"x": 1}}}}),
        ({"sun": {"left": {"tilt": 1}}}, {"main": {"sun": {"left": {"tilt": {"amplitude": 1}}}}}),
        ({"sun": {"unbalance": 1}}, {"main": {"sun": {"unbalance": {"amount": 1}}}}),
        ({"g1": {"position": 1}}, {"g1": {"position": {"amplitude": 1}}}),
        ({"sun": {"run_out": REMOVE}}, {"main": {"sun": {"run_out": REMOVE}}}),
        (
            {"meshes": {"sun-planet": {"profile": 1}}},
            {"main": {"meshes": {"sun-planet": {"profile": {"amplitude": 1}}}}},
        ),
        ({"meshes": {"ring-planet": {"gap": 1}}}, {"main": {"meshes": {"planet-ring": {"gap": 1}}}}),
    ],
)
def test_deviations(short: Tables, long: Tables) -> None:
    assert expanded({"deviations": short}) == {"deviations": long}


def test_references_become_full_paths() -> None:
    layer: Tables = {
        "operation": {"held": ["ring"], "speed": {"sun": 1}, "torque": {"sun": {"right": 2}, "g1": "balance"}},
        "loads": {"a": {"on": "sun.left"}},
        "couplings": {"b": {"between": ["main.sun.right", "g1"], "radial": 1}},
        "assumed": {"stages.main.sun.support.radial": "r", "operation": {"speed": {"sun": "s"}}},
    }
    assert expanded(layer) == {
        "operation": {
            "held": ["main.ring"],
            "speed": {"main": {"sun": 1}},
            "torque": {"main": {"sun": {"right": 2}}, "g1": "balance"},
        },
        "loads": {"a": {"on": "main.sun.left"}},
        "couplings": {"b": {"between": ["main.sun.right", "g1"], "x": 1, "y": 1}},
        "assumed": {
            "stages.main.sun.support.x": "r",
            "stages.main.sun.support.y": "r",
            "operation.speed.main.sun": "s",
        },
    }


def test_stage_is_needed_where_there_are_two() -> None:
    with pytest.raises(ModelError, match="no such member; did you mean"):
        expanded({"operation": {"held": ["sun"]}}, TWO)
    assert expanded({"operation": {"held": ["low.sun"]}}, TWO) == {"operation": {"held": ["low.sun"]}}


def test_expanding_twice_changes_nothing() -> None:
    layer: Tables = {
        **sun({"support": {"radial": 1, "damping": 2}}),
        "deviations": {"sun": {"run_out": 1}, "meshes": {"ring-planet": {"profile": 3}}},
    }
    once = expanded(layer)
    assert expanded(once) == once != layer


def test_same_value_in_two_spellings_clashes() -> None:
    with pytest.raises(ModelError, match="given twice"):
        expanded({"deviations": {"sun": {"run_out": 1}, "main": {"sun": {"run_out": 2}}}})
    with pytest.raises(ModelError, match="given twice"):
        expanded({"deviations": {"meshes": {"sun-planet": {"gap": 1}, "planet-sun": {"gap": 1}}}})


PAIRS: list[tuple[Tables, Tables]] = [
    ({"planets": 3}, {"planet_angles": [0, 1, 2]}),
    ({"module": 1}, {"transverse_module": 2}),
    ({"amplitude": 1, "phase": 2}, {"x": 1}),
    ({"amplitude": 1}, {"x": 1, "y": 1}),
    ({"diameter": 1, "bore": 2}, {"torsional_rigidity": 1}),
    ({"force": 1}, {"coefficient": 1, "radius": 1}),
    ({"modal": 1}, {"mass": 1, "stiffness": 2}),
    ({"mesh": 1}, {"modal": 2}),
    ({"cosine": [1], "sine": [2]}, {"values": [3]}),
    ({"rim": 1}, {"outer_diameter": 2}),
]


@pytest.mark.parametrize(("one", "other"), [*PAIRS, *((b, a) for a, b in PAIRS)])
def test_alternatives(one: Tables, other: Tables) -> None:
    kept = {"else": 1, "z": 3}
    with pytest.raises(ModelError, match="says the same"):
        check_alternatives({"a": {**one, **other}})
    check_alternatives({"a": {**one, **dict.fromkeys(other, REMOVE)}})
    assert replace_alternatives({"a": {**one, **kept}}, {"a": other}) == {"a": kept}
    assert replace_alternatives({"a": {**one, **kept}}, {"b": other}) == {"a": {**one, **kept}}


def test_torque_and_power_of_one_member() -> None:
    torque: Tables = {"operation": {"torque": {"main": {"sun": 1, "ring": 2}}}}
    power: Tables = {"operation": {"power": {"main": {"sun": 1}}}}
    with pytest.raises(ModelError, match=r"operation\.power\.main\.sun: says the same"):
        check_alternatives({"operation": {**torque["operation"], **power["operation"]}})
    assert replace_alternatives(torque, power) == {"operation": {"torque": {"main": {"ring": 2}}}}
    assert replace_alternatives(power, torque) == {"operation": {"power": {}}}
