"""Points of a study: axes of labelled changes are crossed, a point that fails fails alone, results join on labels."""

from __future__ import annotations

import os

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.engine.points import Outcome, along, attempt, crossed, failures, outcomes
from epicyclic.engine.source import StudyAxis, written_labels
from epicyclic.errors import ConvergenceError, ModelError

# cases that a person names: each is any number of changes, none at all too
CASES = StudyAxis(
    name="case",
    changes=(
        {},
        {"stages.main.sun.mass": "900 kg", "stages.main.planet.bearing.radial": "2e9 N/m"},
        {"stages.main.sun.mass": "-1 kg"},
    ),
    labels={"case": (np.array(["drawn", "heavy", "wrong"], dtype=object), {"long_name": "case of load"})},
)
PLANETS = StudyAxis.of_path("stages.main.planets", (3, 4), np.array([3.0, 4.0]), "")


def modes(changes: dict[str, object]) -> xr.Dataset:
    return epicyclic.modes("ren2021", overrides=changes)


def test_named_cases_are_an_axis_beside_the_values_of_a_path() -> None:
    points = crossed((CASES, PLANETS))
    assert points[3] == {**CASES.changes[1], "stages.main.planets": 4}
    found = outcomes(modes, points)
    assert [outcome.status for outcome in found] == ["ok"] * 4 + ["wrong input"] * 2
    assert found[4].reason.startswith("stages.main.sun.mass = -1 kg: out of range; allowed: ")
    whole = along((CASES, PLANETS), [outcome.value for outcome in found])
    assert whole.frequency.dims == ("case", "stages.main.planets", "mode")
    assert whole.case.attrs["long_name"] == "case of load"
    assert whole["stages.main.planets"].attrs["long_name"] == "stages.main.planets, value in the model file"
    heavy = whole.frequency.sel({"case": "heavy", "stages.main.planets": 3}).dropna("mode")
    np.testing.assert_array_equal(heavy, modes(points[2]).frequency)
    assert whole.sel(case="wrong").frequency.isnull().all()


def test_axes_of_one_length_are_one() -> None:
    speeds = StudyAxis.of_path("options.speed", (1, 2), np.array([1.0, 2.0]), "")
    both = StudyAxis.together("point", (PLANETS, speeds))
    assert both.changes == (
        {"stages.main.planets": 3, "options.speed": 1},
        {"stages.main.planets": 4, "options.speed": 2},
    )
    whole = along((both,), [xr.Dataset({"mass": ((), 1.0)}), None])
    assert {name: whole[name].dims for name in whole.coords} == dict.fromkeys(
        ("point", "stages.main.planets", "options.speed"), ("point",)
    )
    assert whole["options.speed"].attrs["long_name"] == "options.speed, option of the verb"


def test_errors_that_are_not_of_the_point_are_raised() -> None:
    def refuse(error: Exception) -> None:
        raise error

    assert attempt(refuse, ConvergenceError("never")).status == "no convergence"
    wrong = attempt(refuse, ModelError("too small", path="stages", given=1))
    assert (wrong.status, wrong.problem, wrong.reason) == ("wrong input", "too small", "stages = 1: too small")
    assert wrong.then(str).error is wrong.error
    with pytest.raises(KeyError):
        attempt(refuse, KeyError("x"))
    assert attempt(refuse, KeyError("x"), failing=(Exception,)).reason == "KeyError: 'x'"
    with pytest.raises(MemoryError):
        attempt(refuse, MemoryError(), failing=(Exception,))
    assert Outcome(value=[1, 2]).then(len).value == 2


def test_failures_are_counted_and_the_first_is_told() -> None:
    assert failures(["", ""]) == []
    (said,) = failures(["", "no load", "no speed"], "values")
    assert said == "2 of 3 values failed, the first with: no load [points-failed]"


def test_points_without_workers_are_computed_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    monkeypatch.setattr("epicyclic.engine.workers._WORTH", {"fork": 0.0, "spawn": 0.0})
    shares = list[float]()
    here = outcomes(lambda _: os.getpid(), range(5), workers=False, progress=shares.append)
    assert {outcome.value for outcome in here} == {os.getpid()}
    assert shares == [0.2, 0.4, 0.6, 0.8, 1.0]


@pytest.mark.parametrize(
    ("values", "labels", "unit"),
    [
        ([1, 2.5], [1.0, 2.5], ""),
        (["1 %", "3 %"], [1.0, 3.0], "%"),
        (["1 %", 0.03], ["1 %", "0.03"], ""),
        (["1 mm", "1 um"], ["1 mm", "1 um"], ""),
        ([[0.0, 0.5], 0.0], ["[0.0, 0.5]", "0.0"], ""),
        ([["20 um", "0 um"]], ["[20, 0] um"], ""),
        ([True, False], ["True", "False"], ""),
    ],
)
def test_values_are_labelled_as_they_are_written(values: list[object], labels: list[object], unit: str) -> None:
    found, of = written_labels(values)
    assert (found.tolist(), of) == (labels, unit)
