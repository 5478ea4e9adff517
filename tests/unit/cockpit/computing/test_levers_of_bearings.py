"""Levers of rolling bearings that are stated by their parts, and the tab of bearings at their moved values."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.unit.questions.rating.test_life import train

import epicyclic
from epicyclic.bearings.rolling_bearing import dynamic_rating
from epicyclic.cockpit.computing import levers
from epicyclic.cockpit.computing.job_kinds import JOBS
from epicyclic.cockpit.computing.levers import Lever, levers_of
from epicyclic.show.series import zones_of

CLEARANCE, RATING = (f"stages.main.planet.bearing.{key}" for key in ("internal_clearance", "rating"))


def found(model: dict[str, Any]) -> dict[str, Lever]:
    return {lever.path: lever for lever in levers_of(model, {})}


def with_pin(model: dict[str, Any]) -> dict[str, Any]:
    """The train with a pin error: a clearance then moves K_gamma."""
    return {**model, "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}}}


def test_clearance_and_rating_have_levers_in_reach_of_their_values() -> None:
    model = with_pin(train())
    (link, *_) = [one for one in epicyclic.load(model).links if one.rolling is not None]
    assert link.rolling is not None
    shown = found(model)
    clearance, rating = shown[CLEARANCE], shown[RATING]
    assert (clearance.value, clearance.unit, clearance.least, clearance.most) == (30, "um", 0, 120)
    assert "K_gamma" in clearance.why
    assert rating.unit == "kN"
    assert rating.value == pytest.approx(dynamic_rating(link.rolling) / 1e3, rel=1e-8)
    assert rating.least < rating.value < rating.most
    assert "power" in rating.why
    assert clearance.label == "bearing of the planets, internal clearance"
    for lever in (clearance, rating):
        for value in (lever.least, lever.most):
            epicyclic.load(model, {lever.path: f"{value:.6g} {lever.unit}"})


def test_they_take_no_place_of_the_seven_others(monkeypatch: pytest.MonkeyPatch) -> None:
    by_hand = with_pin(train())
    stiff = copy.deepcopy(by_hand)
    stiff["stages"]["main"]["planet"]["bearing"] = {"radial": "4e8 N/m"}
    monkeypatch.setattr(levers, "_TRIALS", 0)
    others = [path for path in found(by_hand) if path not in (CLEARANCE, RATING)]
    assert set(found(stiff)) - {"stages.main.planet.bearing.radial"} <= set(others)
    assert len(others) <= 7


def test_a_preloaded_bearing_stands_within_its_slider(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(levers, "_TRIALS", 0)
    lever = found(train(internal_clearance="-5 um"))[CLEARANCE]
    assert (lever.least, lever.value) == (-20, -5)


def test_a_clearance_by_group_stands_at_that_in_operation(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mean of C3 of a bore of 50 mm, 65 um, less 12 um 50/58 by the fit."""
    monkeypatch.setattr(levers, "_TRIALS", 0)
    fitted = {"group": "C3", "bore": "50 mm", "inner_fit": "12 um"}
    lever = found(train(internal_clearance=fitted))[CLEARANCE]
    assert lever.value == pytest.approx(65 - 12 * 50 / 58, rel=1e-3)
    moved = epicyclic.load(train(internal_clearance=fitted), {CLEARANCE: "40 um"})
    assert {link.rolling.clearance for link in moved.links if link.rolling} == {40e-6}


def test_a_named_bearing_of_a_support_is_told_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(levers, "_TRIALS", 0)
    model = train()
    parts = model["stages"]["main"]["planet"].pop("bearing")
    model["stages"]["main"]["carrier"]["support"] = {
        "front": {**parts, "rows": 2, "at": "-50 mm", "rating": "150 kN"},
        "rear": {"radial": "1e9 N/m", "at": "50 mm"},
    }
    rating = found(model)["stages.main.carrier.support.front.rating"]
    assert (rating.value, rating.unit, rating.least, rating.most) == (150, "kN", 74, 300)  # whole steps of 2
    assert rating.label == "support front of the carrier, rating"


@pytest.fixture(scope="module")
def moved() -> dict[str, tuple[Any, xr.Dataset]]:
    """Job of the tab at values of the levers: frame, and result of the verb at the same value."""
    values = {"": "", CLEARANCE: "90 um", RATING: "60 kN"}
    done = {}
    for path, value in values.items():
        over = {path: value} if path else {}
        options = {"instants": 16, "show": "load zones"} if path == CLEARANCE else {"instants": 16}
        frame, _ = JOBS["life"].run(train(), over, options, lambda *_: None)
        done[path] = frame, epicyclic.life(train(), overrides=over or None, instants=16)
    return done


def test_the_tab_of_bearings_follows_a_moved_clearance_and_rating(moved: dict[str, tuple[Any, xr.Dataset]]) -> None:
    (before, _), (after, result) = moved[""], moved[RATING]
    np.testing.assert_allclose(after.arrays["job/bar"], result.bearing_duty_life_reference / 3600, rtol=1e-6)
    assert not np.allclose(after.arrays["job/bar"], before.arrays["job/bar"], rtol=0.1)
    assert ">60</td>" in after.head["job"]["tables"]


def test_the_tab_draws_load_zones(moved: dict[str, tuple[Any, xr.Dataset]]) -> None:
    """A larger clearance loads the first element more; loads of elements stand at their angles."""
    (_, before), (frame, result) = moved[""], moved[CLEARANCE]
    job = frame.head["job"]["lines"]
    assert [curve["label"] for curve in job["curves"]] == [f"main/planet/{i}/bearing" for i in (1, 2, 3)]
    angle, drawn = frame.arrays["job/x"], frame.arrays["job/y"][0]
    at, load = zones_of(result)["main/planet/1/bearing"]
    np.testing.assert_allclose(np.interp(at, angle, drawn), load, atol=0.02 * load.max())
    assert drawn.max() == pytest.approx(float(result.element_load.max()) / 1e3, rel=1e-5)
    assert drawn.max() > 1.05 * float(before.element_load.max()) / 1e3
