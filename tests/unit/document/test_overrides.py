"""Overrides: settings as text, values laid over the file, removed and traced."""

from __future__ import annotations

from typing import Any

import pytest

from epicyclic.document.document import read
from epicyclic.document.overrides import parse_setting
from epicyclic.errors import ModelError


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a.b=3", 3),
        ("a.b = 3.5", 3.5),
        ("a.b=750 kg", "750 kg"),
        ("a.b=true", True),
        ("a.b=inf", float("inf")),
        ("a.b=[0, 1]", [0, 1]),
        ("a.b=[0, 121.5, 238.5] deg", "[0, 121.5, 238.5] deg"),
        ('a.b="3"', "3"),
        ("a.b={x = 1}", {"x": 1}),
        ("a.b=x=1", "x=1"),
        ("a.b=", None),
        ("a.b=3\nc=4", "3\nc=4"),
        ("a.b=iso6336", "iso6336"),
    ],
)
def test_setting(text: str, value: object) -> None:
    assert parse_setting(text) == ("a.b", value)


@pytest.mark.parametrize("text", ["a.b", "=3", ""])
def test_no_setting(text: str) -> None:
    with pytest.raises(ModelError, match="PATH=VALUE"):
        parse_setting(text)


def test_override_of_one_direction_leaves_the_other() -> None:
    document = read("ren2021", {"stages.main.planet.bearing.x": 0})
    bearing = document.model.stages["main"].members["planet"].bearing
    assert bearing is not None
    assert (bearing.x, bearing.y, bearing.z) == (0.0, 1e9, 1e9)
    sets = {path for path, origin in document.origin.items() if origin == "set"}
    assert sets == {"stages.main.planet.bearing.x"}


def test_quantity_replaces_whatever_kind_it_was() -> None:
    member = read("ren2021", {"stages.main.sun.inertia": "12 kg m^2"}).model.stages["main"].members["sun"]
    assert member.inertia is not None
    assert (member.inertia.value, member.inertia.unit) == (12.0, "kg m^2")


def test_later_alternative_replaces() -> None:
    document = read("ren2021", {"stages.main.planet_angles": "[0, 121.5, 238.5] deg", "operation.power.sun": "1 MW"})
    stage = document.model.stages["main"]
    assert stage.planets is None
    assert stage.branches == 3
    assert document.model.operation.torque == {}
    assert document.model.operation.power == {"main.sun": 1e6}
    # an assumption about a value that is gone goes with it
    assert set(document.model.assumed) == {"damping.modal", "stages.main.module", "tolerance"}


@pytest.mark.parametrize("nothing", [None, ""])
def test_empty_removes(nothing: object) -> None:
    document = read("ren2021", {"deviations.planet.run_out": nothing, "stages.main.sun.support.radial": nothing})
    assert "main.planet" not in {k for k, v in document.model.deviations.members.items() if v.run_out}
    support = document.model.stages["main"].members["sun"].support
    assert support is not None
    assert (support.x, support.y, support.z) == (None, None, 1e9)
    assert not any(path.startswith("deviations.main.planet.run_out") for path in document.origin)


def test_a_table_is_emptied_and_filled_anew() -> None:
    document = read("ren2021", {"deviations": "", "deviations.sun.run_out": "6 um"})
    members = document.model.deviations.members
    assert set(members) == {"main.sun"}
    assert members["main.sun"].run_out is not None
    assert members["main.sun"].run_out.amplitude == 6e-6
    assert not document.model.deviations.meshes
    assert document.origin["deviations.main.sun.run_out.amplitude"] == "set"
    again = read("ren2021", {"deviations.sun.run_out": "6 um", "deviations": None})  # whichever is said first
    assert again.data == document.data


def test_overridden_assumption_is_none() -> None:
    assert "damping.modal" in read("ren2021").model.assumed
    assert "damping.modal" not in read("ren2021", {"damping.modal": 0.05}).model.assumed
    both = read("ren2021", {"damping.modal": 0.05, "assumed.damping.modal": "measured"})
    assert both.model.assumed["damping.modal"] == "measured"


def test_stage_may_be_left_out_and_tables_added() -> None:
    document = read("ren2021", {"bodies.brake": {"inertia": "3 kg m^2"}, "deviations.brake.unbalance": "1 kg m"})
    assert document.model.bodies["brake"].inertia == 3.0
    assert document.model.deviations.members["brake"].unbalance is not None


def test_what_an_alternative_replaces_may_be_removed_too() -> None:
    power = {"operation.torque": "", "operation.power.sun": "10 kW", "operation.speed.sun": "1000 rpm"}
    model = read("ren2021", power).data
    for overrides in (
        {"operation.torque.sun": "5 N m"},
        {"operation.torque.sun": "5 N m", "operation.power.sun": ""},
    ):
        operation = read(model, overrides).model.operation
        assert operation.torque
        assert not operation.power


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"stages.mian.sun.mass": 3}, "no 'mian' in stages; did you mean 'main'"),
        ({"stages.main.snu.mass": 3}, "did you mean 'sun'"),
        ({"stages.main.sun.mas": 3}, "stages.main.sun.mas = 3: unknown key; did you mean 'mass'"),
        ({"stages.main.backlash": 1e-4}, "allowed: stages.main.meshes.A-B.backlash, with A-B such as sun-planet"),
        ({"stages.main.sun.backlash": 1e-4}, "allowed: stages.main.meshes.A-B.backlash, with A-B such as sun-planet"),
        ({"stages.main.meshes.backlash": 1e-4}, "a key of a mesh stands in its table, meshes.A-B.KEY"),
        ({"operatoin.held": []}, "unknown key; did you mean 'operation'"),
        ({"bodies.g1.mass": 3}, "bodies.g1.mass"),
        ({"doi.x": None}, "nothing there to remove"),
        ({"notes": None}, "notes: nothing there to remove"),
        (
            {"stages.main.sun": {}},
            r"stages.main.sun = {}: an empty table changes nothing; allowed: stages.main.sun= removes",
        ),
        ({"operation.torque.main.ring": None}, "nothing there to remove"),
        ({"stages.main.planets": 3, "stages.main.planet_angles": [0, 1, 2]}, "says the same"),
        ({"stages.main.sun.support.radial": 1, "stages.main.sun.support.x": 2}, "stands beside"),
        ({"": 3}, "not a path"),
        ({"a..b": 3}, "not a path"),
        ({"stages.main.sun.mass": object()}, "cannot stand here"),
        ({"format": None}, "format"),
        ({"stages.main.ring": None}, "operation.held = main.ring: no such member"),
        (
            {"couplings.c": {"betwen": ["sun", "ring"]}},
            "couplings.c.betwen = ['sun', 'ring']: unknown key; did you mean",
        ),
        ({"stages.main": None}, "no such member"),
        ({"stages.main.sun": {"support": {"x": {}}}}, "stages.main.sun.support.x"),
    ],
)
def test_refused(overrides: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError) as error:
        read("ren2021", overrides)
    assert message in str(error.value)


@pytest.mark.parametrize(
    "paths",
    [
        ("deviations", "deviations.sun"),
        ("deviations.sun", "deviations", "deviations.sun.run_out"),
        ("stages.main.sun.support", "stages.main.sun.support.radial"),
        ("deviations.sun.run_out", "deviations.main.sun.run_out"),
    ],
)
def test_removals_within_each_other_are_one_step(paths: tuple[str, ...]) -> None:
    """The outermost decides; what a person types at once has no order."""
    together = read("ren2021", dict.fromkeys(paths)).data
    assert together == read("ren2021", {min(paths, key=len): None}).data


def test_a_removal_within_another_names_what_is_there() -> None:
    with pytest.raises(ModelError, match=r"deviations\.main\.sun\.rn_out: nothing there to remove"):
        read("ren2021", {"deviations.sun": None, "deviations.sun.rn_out": None})


def test_a_table_emptied_twice_may_be_filled() -> None:
    size = {"deviations.sun.run_out": "6 um"}
    found = read("ren2021", {"deviations": None, "deviations.sun": None, **size}).data
    assert found == read("ren2021", {"deviations": None, **size}).data


@pytest.mark.parametrize("empty", [None, "", " "])
def test_a_table_removes_as_a_path_does(empty: object) -> None:
    mass, inertia = "stages.main.carrier.mass", "stages.main.carrier.inertia"
    plain = read("ren2021", {mass: None, inertia: "400 kg m^2"})
    assert mass not in plain.origin
    for overrides in (
        {"stages.main.carrier": {"mass": empty, "inertia": "400 kg m^2"}},
        {"stages": {"main": {"carrier": {"mass": empty}}}, inertia: "400 kg m^2"},
    ):
        found = read("ren2021", overrides)
        assert found.data == plain.data
        assert found.origin == plain.origin
    assert read("ren2021", {"stages.main.carrier": {"mass": empty}}).data == read("ren2021", {mass: None}).data
    with pytest.raises(ModelError, match=r"stages\.main\.carrier\.split: nothing there to remove"):
        read("ren2021", {"stages.main.carrier": {"split": empty}})
    with pytest.raises(ModelError, match=r"stages\.main\.carrier\.mass = .*: given twice"):
        read("ren2021", {"stages.main.carrier": {"mass": empty}, mass: "5 t"})


@pytest.mark.parametrize("value", ["1e400", "-1e999", "[0, 1e400]", "{ x = 1e400 }"])
def test_a_number_that_is_too_large_is_not_infinite(value: str) -> None:
    with pytest.raises(
        ModelError, match=r"^stages\.main\.sun\.support\.radial = .*: too large; allowed: a number"
    ) as error:
        parse_setting(f"stages.main.sun.support.radial={value}")
    assert error.value.given == value
