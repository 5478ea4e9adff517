"""Phases and slices that follow a tolerance: what `contact` and `relief` print holds when both are refined."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.flanks import ContactOptions
from epicyclic.questions.flanks.contact_resolution import Resolution, doubled, estimated_error, mesh_phases
from epicyclic.questions.flanks.pair_contact import helices_of, pair_contact
from epicyclic.system.tooth_pairs import pair_of

PAIR: dict[str, Any] = {
    "format": 2,
    "title": "One pair",
    "stages": {
        "main": {
            "module": "4 mm",
            "pressure_angle": "20 deg",
            "face_width": "24 mm",
            "pinion": {"kind": "gear", "teeth": 23, "mass": "1 kg", "inertia": "0.001 kg m^2"},
            "wheel": {"kind": "gear", "teeth": 41, "mass": "3 kg", "inertia": "0.01 kg m^2"},
            "meshes": {"pinion-wheel": {}},
        }
    },
    "operation": {"speed": {"pinion": "3000 rpm"}, "torque": {"pinion": "400 N m"}},
    "damping": {"modal": "5 %"},
}
NUMBERS = ("transmission_error_peak_to_peak", "largest_load_per_length", "largest_pressure")


def pair(kind: str) -> dict[str, Any]:
    document = copy.deepcopy(PAIR)
    stage: Any = document["stages"]["main"]
    if kind == "helical":
        stage["helix_angle"] = "12 deg"
    if kind == "crowned":
        stage["pinion"]["flank"] = {"crown": "10 um", "slope": "6 um"}
    return document


def numbers(result: xr.Dataset) -> np.ndarray:
    return np.array([float(result[name].values.max()) for name in NUMBERS])


@pytest.fixture(scope="module", params=["spur", "helical", "crowned"])
def refined(request: pytest.FixtureRequest) -> tuple[xr.Dataset, ...]:
    """By default, with three times the phases, and with three times the slices."""
    train = epicyclic.load(pair(request.param))
    found = pair_contact(train, ContactOptions(loads=[1.0]))
    helices = helices_of(train, None)
    pairs = [pair_of(train, one) for one in helices]

    def with_more(phases: int, slices: int) -> xr.Dataset:
        more = {"samples": phases * found.attrs["samples"], "slices": slices * found.attrs["slices"]}
        phase = mesh_phases(helices, pairs, more["samples"])
        cut = Resolution(phase=phase, graded=True, error=np.full(3, np.nan), **more)
        return pair_contact(train, ContactOptions(loads=[1.0]), cut=cut)

    # a uniform face is one slice
    return found, with_more(3, 1), *([] if request.param == "spur" else [with_more(1, 3)])


def test_the_default_holds_within_its_tolerance(refined: tuple[xr.Dataset, ...]) -> None:
    found = refined[0]
    assert found.attrs["estimated_error"] < found.attrs["tolerance"] == 0.01
    assert not any("not enough" in text for text in json.loads(found.attrs["warnings"]))
    for finer in refined[1:]:
        assert numbers(found) == pytest.approx(numbers(finer), rel=0.01)
        assert found.average_stiffness.values == pytest.approx(finer.average_stiffness.values, rel=0.01)
        order = np.abs(finer.transmission_error_harmonic.values[0, 1:4])
        assert np.abs(found.transmission_error_harmonic.values[0, 1:4]) == pytest.approx(order, abs=0.02 * order.max())


def test_the_map_has_the_largest_of_the_table(refined: tuple[xr.Dataset, ...]) -> None:
    for result in refined:
        flank = {"largest_load_per_length": "flank_load_per_length", "largest_pressure": "flank_pressure"}
        for table, drawn in flank.items():
            assert float(np.nanmax(result[drawn])) == pytest.approx(float(result[table].max()), rel=1e-12)
        assert float(result.load_per_length.max()) == pytest.approx(float(result.largest_load_per_length.max()))


def test_a_tighter_tolerance_takes_more() -> None:
    wide = pair("helical")
    wide["stages"]["main"]["face_width"] = "40 mm"
    loose, tight = (epicyclic.contact(wide, mesh="pinion-wheel", loads=[], tolerance=one) for one in (0.1, 0.002))
    assert tight.attrs["slices"] > loose.attrs["slices"]
    assert tight.attrs["estimated_error"] < 0.002


def test_given_numbers_are_kept() -> None:
    found = epicyclic.contact(pair("helical"), mesh="pinion-wheel", loads=[], samples=12, slices=5)
    assert found.mesh_phase.values.tolist() == (np.arange(12) / 12).tolist()
    assert found.sizes["width"] == 5
    assert np.isnan(found.attrs["estimated_error"])
    half = epicyclic.contact(pair("helical"), mesh="pinion-wheel", loads=[], samples=12)
    assert half.sizes["mesh_phase"] == 12
    assert half.sizes["width"] == half.attrs["slices"] >= 20


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 1.0, float("nan")])
def test_a_tolerance_is_a_relative_error(tolerance: float) -> None:
    with pytest.raises(ModelError, match="tolerance"):
        epicyclic.contact(pair("spur"), mesh="pinion-wheel", tolerance=tolerance)


def test_errors_from_changes_that_fall() -> None:
    second = [np.array([1 + 1 / n**2]) for n in (8, 16, 32)]
    assert estimated_error(second) == pytest.approx(1 / 32**2)
    first = [np.array([1 + 1 / n]) for n in (8, 16, 32)]
    assert estimated_error(first) == pytest.approx(1 / 32)
    assert estimated_error(first[:2]) == pytest.approx(1 / 16)  # of one change first order is taken


def test_relief_of_one_gear_is_judged_converged() -> None:
    """With 64 even phases the answer was 8.2 % below the flanks as drawn; converged that of the same search is 4 %."""
    pytest.importorskip("pymoo")
    vary = {"p.tip_relief.amount": "0..40 um", "p.tip_relief.length": "0.1..2.6 mm"}
    torque = "43 N m"
    found = epicyclic.relief("yue2014-i", mesh="p-d", torque=torque, vary=vary, population=20, generations=8)
    changes = json.loads(found.attrs["overrides"])
    sets: list[dict[str, Any]] = [{}, changes]
    many = [
        epicyclic.contact("yue2014-i", mesh="p-d", torque=torque, loads=[], samples=1024, slices=1, overrides=overrides)
        for overrides in sets
    ]
    exact = [float(one.transmission_error_peak_to_peak[0]) for one in many]
    ours = [float(found.objective_before[0]), float(found.objective_after[0])]
    assert ours[0] == pytest.approx(exact[0], rel=2e-3)
    # the search may end at another of alike reliefs on another processor: its answer holds the tolerance of the verb
    assert ours[1] == pytest.approx(exact[1], rel=found.attrs["tolerance"])
    assert 0.95 < ours[1] / ours[0] < 0.97


def test_relief_solves_its_best_again() -> None:
    pytest.importorskip("pymoo")
    vary = {"tip_relief.amount": "0..30 um", "tip_relief.length": "2 mm", "pinion.crown": "0..8 um"}
    found = epicyclic.relief(pair("helical"), vary=vary, population=4, generations=1)
    changes = json.loads(found.attrs["overrides"])
    again = epicyclic.contact(pair("helical"), mesh="pinion-wheel", loads=[], overrides=changes)
    swing = float(again.transmission_error_peak_to_peak[0])
    deflection = float(again.transmission_error.mean())
    assert float(found.objective_after[0]) == pytest.approx(swing, abs=0.01 * max(swing, 0.01 * deflection))
    assert found.attrs["estimated_error"] < 0.01
    assert found.attrs["slices"] >= 20


def test_a_small_first_change_of_the_slices_is_confirmed() -> None:
    """From 10 to 20 slices the peak to peak changes by 0.1 %, to 80 by 9 %: the end relief ends within a slice."""
    document = pair("spur")
    stage: Any = document["stages"]["main"]
    stage |= {"helix_angle": "27 deg", "face_width": "60 mm"}
    stage["flank"] = {"crown": "12 um", "end_relief": {"amount": "10 um", "length": "6 mm"}}
    stage["pinion"] |= {"teeth": 21}
    stage["wheel"] |= {"teeth": 55}
    document["operation"]["torque"]["pinion"] = "700 N m"
    train = epicyclic.load(document)
    found = pair_contact(train, ContactOptions(loads=[1.0], samples=32))  # of the slices alone: few phases
    fine = pair_contact(train, ContactOptions(loads=[1.0], samples=32, slices=120))
    assert found.attrs["slices"] > 20
    assert float(found.transmission_error_peak_to_peak[0]) == pytest.approx(
        float(fine.transmission_error_peak_to_peak[0]), rel=0.01
    )


def test_a_count_without_numbers_ends_the_doubling() -> None:
    asked: list[int] = []

    def numbers(count: int) -> Any:
        asked.append(count)
        return np.full((2, 1), np.nan) if count > 20 else np.array([[1 + 1 / count], [1.0]])

    count, error = doubled(numbers, (10, 160), 1e-6)
    assert (count, asked) == (20, [10, 20, 40])
    assert error == pytest.approx([1 / 20])
    count, error = doubled(numbers, (32, 160), 1e-6)
    assert (count, asked[3:]) == (32, [32])
    assert np.isnan(error).all()
