"""The levers: real paths, ranges that load, and what they say they do."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

import pytest

from epicyclic.cockpit.computing import levers
from epicyclic.cockpit.computing.levers import Lever, levers_of
from epicyclic.cockpit.page.page import entries_of, number_in, with_entry
from epicyclic.cockpit.state.state import opened, request_of, with_value
from epicyclic.document.document import drive_text, ready_drives
from epicyclic.document.units import factor
from epicyclic.errors import ModelError
from epicyclic.questions.sharing.verbs import sharing
from epicyclic.train.resolution import load


@pytest.fixture(autouse=True)
def trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every candidate is tried."""
    monkeypatch.setattr(levers, "_TRIALS", 1000)


def tables_of(drive: str) -> dict[str, Any]:
    return tomllib.loads(drive_text(drive))


@cache
def levers_at(drive: str) -> tuple[Lever, ...]:
    """Levers of a ready drive as it is, every candidate tried."""
    return tuple(levers_of(tables_of(drive), {}))


def written(lever: Lever, value: float, others: tuple[float, ...] = ()) -> object:
    """The override that the page writes for a value of a lever."""
    if lever.entry is not None and lever.count is not None:
        values = [*(others or (0.0,) * lever.count)]
        values[lever.entry] = value
        return f"[{', '.join(f'{one:.6g}' for one in values)}] {lever.unit}"
    return f"{value:.6g} {lever.unit}" if lever.unit else value


# lin1999-n4 and yue2014-i stand for their alikes
ALIKE = ("lin1999-n3", "lin1999-n5", "yue2014-ii", "yue2014-iii")


@pytest.mark.parametrize("drive", sorted(set(ready_drives()) - set(ALIKE)))
def test_every_lever_loads_from_end_to_end(drive: str) -> None:
    found = levers_at(drive)
    assert 4 <= len(found) <= 7
    assert len({lever.path for lever in found}) == len({lever.label for lever in found}) == len(found)
    state = opened(drive)
    for lever in found:
        assert lever.least < lever.most
        assert lever.least <= lever.value <= lever.most
        for value in (lever.least, (lever.least + lever.most) / 2, lever.most):
            changed = with_value(state, lever.path, written(lever, value))
            source, overrides = request_of(changed)
            problem = refused(source, overrides)
            if problem is not None:
                assert problem.path, (lever, value)
                assert value in (lever.least, lever.most), f"{lever.label} fails in the middle: {problem}"


def refused(source: Any, overrides: dict[str, object]) -> ModelError | None:
    """Why a model does not load."""
    try:
        load(source, overrides)
    except ModelError as error:
        return error
    return None


@pytest.mark.parametrize("drive", ["ren2021", "wind-stage", "encased-differential"])
def test_a_lever_at_its_value_changes_nothing(drive: str) -> None:
    tables = tables_of(drive)
    before = load(tables)
    for lever in levers_at(drive):
        others = (35.0, 0.0, 0.0) if lever.entry is not None and drive == "wind-stage" else ()
        after = load(tables, {lever.path: written(lever, lever.value, others)})
        mine, same = ({v.path: v.value for v in train.values} for train in (after, before))
        assert {path for path in same if repr(mine.get(path)) != repr(same[path])} == set()


def test_the_levers_of_a_loaded_stage_are_spread_over_kinds() -> None:
    found = {lever.path: lever for lever in levers_at("wind-stage")}
    assert {"operation.torque.carrier", "operation.speed.carrier", "stages.main.sun.support.radial"} <= set(found)
    pin = found["deviations.planet.position.y"]
    assert (pin.entry, pin.count, pin.value, pin.unit, pin.least) == (0, 3, 35.0, "um", 0.0)
    assert found["stages.main.sun.support.radial"].log
    assert not found["operation.torque.carrier"].log
    assert found["operation.torque.carrier"].unit == "MN m"


def test_a_lever_follows_what_is_laid_over_the_file() -> None:
    overrides = {"deviations.planet.position.y": "[0, 12, 0] um", "operation.torque.sun": "80 kN m"}
    found = {lever.path: lever for lever in levers_of(tables_of("ren2021"), overrides)}
    assert found["operation.torque.sun"].value == 80.0
    pin = found["deviations.planet.position.y"]
    assert (pin.entry, pin.value, pin.label) == (1, 12.0, "pin of planet 2, tangential")
    full = "deviations.main.planet.position.y"
    assert full in {lever.path for lever in levers_of(tables_of("ren2021"), {full: "[0, 12, 0] um"})}


def test_the_lever_of_pins_is_that_of_the_one_farthest_off() -> None:
    overrides = {"deviations.planet.position.y": "[10, -30, 20] um"}
    found = {lever.path: lever for lever in levers_of(tables_of("ren2021"), overrides)}
    pin = found["deviations.planet.position.y"]
    assert (pin.entry, pin.value, pin.others) == (1, -30.0, (10.0, -30.0, 20.0))


def test_a_lever_of_another_spelling_keeps_it() -> None:
    tables = tables_of("ren2021")
    tables["deviations"] = {"main": {"carrier": {"run_out": {"amplitude": "15 um"}}}}
    found = {lever.path: lever for lever in levers_of(tables, {})}
    assert found["deviations.main.carrier.run_out.amplitude"].value == 15.0


def test_a_sun_that_floats_or_is_rigid_has_its_lever() -> None:
    path = "stages.main.sun.support.radial"
    floating = {lever.path: lever for lever in levers_of(tables_of("ren2021"), {path: 0})}[path]
    assert floating.value == 0 or floating.value == floating.least
    assert floating.why.startswith("the sun floats now")
    rigid = {lever.path: lever for lever in levers_of(tables_of("ren2021"), {path: "inf"})}[path]
    assert rigid.value == rigid.most
    assert rigid.why.startswith("rigid now")


def test_a_train_without_load_has_no_levers_of_errors() -> None:
    assert not [lever for lever in levers_at("lin1999-n4") if lever.path.startswith("deviations")]


def test_a_lever_says_what_sharing_says() -> None:
    lever = next(one for one in levers_at("ren2021") if one.path == "deviations.carrier.run_out")
    result = sharing("ren2021", overrides={lever.path: "40 um"}, method="static")
    then = float(result["load_sharing"].sel(definition="mean-load").max())
    assert lever.why.startswith(f"at 40 um: K_gamma 1.034 → {then:.3f}")


def test_steps_are_round_numbers() -> None:
    for lever in levers_at("wind-stage"):
        if not lever.log:
            assert f"{lever.step:e}"[0] in "125"
            assert lever.most / lever.step == pytest.approx(round(lever.most / lever.step))


def test_a_candidate_writes_its_entry() -> None:
    one = Lever(kind="pin", path="p", label="", value=3.0, unit="um", entry=1, count=3, others=(1.0, 2.0, 4.0))
    assert one.written() == "[1.0, 3.0, 4.0] um"
    assert one.scaled(1e-6) == pytest.approx(1 / (factor("um", "m") or 0) * 1e-6)


def test_an_entry_is_read_and_written_in_its_list() -> None:
    assert entries_of("[1, 2.5, 0] um", "um", 3) == (1.0, 2.5, 0.0)
    assert entries_of("[1, 2, 3] mm", "um", 3) == (1000.0, 2000.0, 3000.0)
    assert entries_of("[0.01 mm, 5 um, 0]", "um", 3) == (10.0, 5.0, 0.0)  # each with its own unit
    assert entries_of(["2e-6 m", 0, 1e-6], "um", 3) == (2.0, 0.0, 1.0)  # a bare number is SI
    assert entries_of(None, "um", 2) == (0.0, 0.0)
    assert entries_of("4 um", "um", 2) == (4.0, 4.0)
    assert entries_of("[12.3456789012345, 0] um", "um", 2) == (12.3456789012345, 0.0)
    for wrong in ("[1, 2] um", "inf", "1e999", "[1, x, 3] um", "[1, 2, 3] kg", "[] um", True):
        assert entries_of(wrong, "um", 3) is None, wrong
    assert number_in("0.04 mm", "um") == number_in("4e-5 m", "um") == number_in("40um", "um") == 40.0
    assert number_in("[1] um", "um") is None
    assert number_in("1 t", "kg") == 1000.0
    assert with_entry((1.0, 2.0, 3.0), "um", 1, 7.5) == "[1.0, 7.5, 3.0] um"


def test_without_trials_the_levers_are_those_of_each_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(levers, "_TRIALS", 0)
    found = levers_of(tables_of("ren2021"), {})
    assert [one.path for one in found][:3] == [
        "deviations.planet.position.y",
        "deviations.sun.run_out",
        "stages.main.sun.support.radial",
    ]
    assert {one.why for one in found if not one.path.startswith(("operation", "damping"))} == {""}


def test_a_negative_torque_has_a_lever_from_its_most_to_its_least() -> None:
    """As `new --output-torque` writes it: what leaves is negative."""
    tables = tables_of("ren2021")
    del tables["tolerance"], tables["assumed"], tables["operation"]["torque"]
    driven = levers_of(tables, {"operation.torque.carrier": "-100 kN m"})
    (torque,) = [lever for lever in driven if lever.path == "operation.torque.carrier"]
    assert torque.least < torque.value < torque.most < 0
    assert torque.step > 0
