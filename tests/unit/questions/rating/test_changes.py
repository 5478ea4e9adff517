"""What changes would make of the shortest life: as overrides by hand, with load cases, where one fails."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.unit.questions.rating.test_life import PARTS, train

import epicyclic
from epicyclic.questions.rating.life import changes_of
from epicyclic.questions.rating.views import life_findings as findings
from epicyclic.questions.rating.views import life_tables as tables
from epicyclic.train.resolution import load

BEARING = "stages.main.planet.bearing"


def held() -> dict[str, Any]:
    """Three planets, one pin off its place, a sun on a support, two load cases."""
    model = train()
    model["stages"]["main"]["sun"]["support"] = {"radial": "1e9 N/m"}
    model["deviations"] = {"planet": {"position": {"y": ["15 um", 0, 0]}}}
    model["cases"] = {"low": {"share": 0.7, "torque": {"carrier": "2000 N m"}}, "high": {"share": 0.3}}
    return model


@pytest.fixture(scope="module")
def changed() -> Any:
    return epicyclic.life(held(), overrides={"case": "all"}, instants=8, changes=True)


def test_changes_are_overrides_of_the_file(changed: Any) -> None:
    """Twice the clearance, a tenth more rating, a floating sun: each is the life of a file that says so."""
    now = float(changed.bearing_duty_life_reference.min())
    plain = epicyclic.life(held(), overrides={"case": "all"}, instants=8)
    assert "change_life" not in plain
    assert now == pytest.approx(float(plain.bearing_duty_life_reference.min()), rel=1e-12)
    rating = 1.1 * float(changed.bearing_rating[0])
    tried: list[tuple[str, dict[str, Any]]] = [
        (f"{BEARING}.internal_clearance = 60 um", {f"{BEARING}.internal_clearance": "60 um"}),
        (f"{BEARING}.rating = {rating / 1e3:.4g} kN", {f"{BEARING}.rating": rating}),
        ("stages.main.sun.support.radial = 0", {"stages.main.sun.support.radial": 0}),
    ]
    assert changed.change.values.tolist() == [label for label, _ in tried]
    for found, (_, change) in zip(changed.change_life.values, tried, strict=True):
        by_hand = epicyclic.life(held(), overrides={"case": "all", **change}, instants=8).bearing_duty_life_reference
        assert found == pytest.approx(float(by_hand.min()), rel=1e-9)
    more_play, more_rating, floating = changed.change_life.values / now
    assert more_play < 1 < floating
    assert more_rating == pytest.approx(1.1**4, rel=1e-6)  # of rollers, as the standard has the load zones


def test_the_change_that_helps_most_is_told(changed: Any) -> None:
    (finding,) = findings(changed, {})
    best = int(changed.change_life.values.argmax())
    assert changed.change.values[best] in finding.change
    table = next(one for one in tables(changed) if one.title == "Changes, one at a time")
    assert table.columns["times"] == pytest.approx(
        changed.change_life.values / float(changed.bearing_duty_life_reference.min())
    )


def test_a_change_that_fails_says_why_and_the_others_go_on() -> None:
    """A sun on a support with play needs a stiffness; a small clearance grows by 20 um; a Train is changed too."""
    model = train(internal_clearance="5 um")
    model["stages"]["main"]["sun"]["support"] = {"radial": "1e9 N/m", "clearance": "10 um"}
    found = epicyclic.life(load(model), instants=8, changes=True)
    assert found.change.values[0].endswith("internal_clearance = 25 um")
    assert np.isfinite(found.change_life.values).tolist() == [True, True, False]
    assert "stages.main.sun.support" in found.change_reason.values[2]
    assert found.change_reason.values[:2].tolist() == ["", ""]


def test_a_floating_sun_is_not_floated() -> None:
    model = train()
    model["stages"]["main"]["sun"]["support"] = {"radial": 0}
    assert epicyclic.life(model, instants=8, changes=True).sizes["change"] == 2


def test_what_is_changed_is_the_bearing_that_lives_shortest() -> None:
    """Not the one of the sun, which equal planets hardly load."""
    model = train()
    model["stages"]["main"]["sun"]["support"] = PARTS
    result = epicyclic.life(model, instants=8)
    assert result.bearing_duty_life_reference.sel(bearing="main/sun/support") > result.bearing_duty_life_reference.min()
    assert list(changes_of(result).changes[0]) == [f"{BEARING}.internal_clearance"]
