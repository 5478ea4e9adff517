"""Tolerances of clearances: each sample has laws of its own, and is what the same train gives by itself."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.unit.questions.rating.test_life import train

import epicyclic
from epicyclic.engine.plan import SamplingPlan
from epicyclic.errors import ModelError
from epicyclic.questions.output import output as outputs
from epicyclic.questions.output.output import locked_train, output_shaft
from epicyclic.questions.tolerance import effects
from epicyclic.questions.tolerance import tolerance as lots
from epicyclic.questions.tolerance.tolerance_map import tolerance_map

CLEARANCE = "stages.main.planet.bearing.internal_clearance"
PLAY = "stages.main.planet.bearing.clearance"
TWO_ROWS = {"rows": 2, "row_distance": "20 mm"}


def drawn(model: dict[str, Any], tolerance: dict[str, Any]) -> dict[str, Any]:
    """A train whose pins stand apart by 20 um, with tolerances."""
    return {**model, "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}}, "tolerance": tolerance}


def with_play() -> dict[str, Any]:
    model = train()
    model["stages"]["main"]["planet"]["bearing"] = {"radial": "3e8 N/m", "clearance": "15 um"}
    return model


def alone(model: dict[str, Any], overrides: dict[str, object]) -> np.ndarray[Any, Any]:
    """N F_i / sum F of every mesh of one train, by `sharing` [1]."""
    bare = {name: table for name, table in model.items() if name != "tolerance"}
    shared = epicyclic.sharing(bare, overrides=overrides, method="static", cycles=1, samples=16)
    return np.asarray(shared.load_sharing.sel(definition="mean-load").values)


@pytest.mark.parametrize(
    ("model", "path"),
    [(train(), CLEARANCE), (train(**TWO_ROWS), CLEARANCE), (with_play(), PLAY)],
    ids=["curve", "contact set", "play"],
)
def test_a_sample_is_the_train_with_its_clearances(model: dict[str, Any], path: str) -> None:
    whole = drawn(model, {path: "uniform(10 um, 60 um)", "deviations.planet.position.y": "normal(0, 10 um)"})
    lot = tolerance_map(epicyclic.load(whole))
    u = np.random.default_rng(3).uniform(0.05, 0.95, (2, lot.dimension_entry.size))
    found = lot.evaluate(u)
    for row, load in zip(u, found.load[:, 0], strict=True):
        overrides = lot.overrides(row)
        own = [float(text) * 1e6 for text in str(overrides[path]).strip("[] m").split(",")]
        assert len({round(one, 3) for one in own}) == 3  # every planet has its own
        assert all(10 < one < 60 for one in own)
        np.testing.assert_allclose(load, alone(whole, overrides), rtol=1e-5)
    # at the mean of all alike, which no planet has as one draw
    same = lot.evaluate(u, scale=[0.0, 1.0]).load[0, 0]
    position = {name: one for name, one in lot.overrides(u[0]).items() if name != path}
    np.testing.assert_allclose(same, alone(whole, {path: "35 um", **position}), rtol=1e-5)


FEW = SamplingPlan(samples=16, scrambles=16, rows=1, seed=1, sampler="sobol")


def test_the_distribution_of_k_gamma_follows_the_clearances(monkeypatch: pytest.MonkeyPatch) -> None:
    """A play of every planet of its own parts the load as pins do; one of all planets alike turns all of them."""
    monkeypatch.setattr(lots, "sampling_plan", lambda *_, **__: FEW)
    monkeypatch.setattr(effects, "_TOLD", 2)

    def lot(tolerance: str | dict[str, str]) -> xr.Dataset:
        made = drawn(with_play(), {PLAY: tolerance})
        return epicyclic.tolerance(made, samples=16, effects="none").sel(definition="mean-load")

    own, common = lot("uniform(5 um, 40 um)"), lot({"common": "uniform(5 um, 40 um)"})
    assert float(own.system_k_gamma_std) > 0.05
    assert float(common.system_k_gamma_std) < 1e-6
    worst = json.loads(str(own.worst_overrides.values[0]))
    np.testing.assert_allclose(float(own.worst_k_gamma[0]), alone(drawn(with_play(), {}), worst).max(), rtol=1e-5)
    assert [any("has no effect" in text for text in json.loads(one.warnings)) for one in (own, common)] == [False, True]


def test_a_clearance_that_is_not_allowed_is_a_sample_that_failed() -> None:
    lot = tolerance_map(epicyclic.load(drawn(with_play(), {PLAY: "normal(10 um, 20 um)"})))
    found = lot.evaluate(np.array([[0.05, 0.5, 0.5], [0.6, 0.5, 0.5]]))
    assert found.failed.tolist() == [True, False]
    tally: Any = SimpleNamespace(plan=replace(FEW, samples=2), failed=1, done=2, open=0)
    (said,) = lots._warnings(tally, 2, 0.0)
    assert "a clearance that its link cannot have" in said


def test_tangents_do_not_know_a_clearance() -> None:
    lot = tolerance_map(epicyclic.load(drawn(with_play(), {PLAY: "uniform(10 um, 60 um)"})))
    with pytest.raises(ModelError, match=r"clearances are drawn.*auto or static"):
        lot.evaluate(np.full((1, 3), 0.5), method="linear")


def test_a_clearance_that_no_law_follows_is_refused() -> None:
    model = drawn(train(radial="3e8 N/m"), {CLEARANCE: "uniform(10 um, 60 um)"})
    with pytest.raises(
        ModelError, match=r"tolerance\.stages.*internal_clearance: no law follows it.*without a stiffness"
    ):
        tolerance_map(epicyclic.load(model))


def test_a_mean_that_is_not_allowed_is_told_at_its_tolerance_as_it_is_given() -> None:
    model = drawn(train(), {CLEARANCE: "uniform(-100 um, 3 mm)"})
    with pytest.raises(
        ModelError, match=r"its mean 0\.00145 m: too large for the elements; allowed: up to "
    ) as refused:
        tolerance_map(epicyclic.load(model))
    assert (refused.value.path, refused.value.given) == (f"tolerance.{CLEARANCE}", "uniform(-100 um, 3 mm)")


def test_a_part_of_a_clearance_is_refused_by_its_name() -> None:
    model = drawn(train(internal_clearance={"initial": "60 um"}), {f"{CLEARANCE}.initial": "normal(60 um, 5 um)"})
    with pytest.raises(ModelError, match=rf'a part of a clearance is not drawn; allowed: "{CLEARANCE}"') as refused:
        tolerance_map(epicyclic.load(model))
    assert (refused.value.path, refused.value.given) == (f"tolerance.{CLEARANCE}.initial", "normal(60 um, 5 um)")


def test_a_mean_of_more_than_half_the_largest_clearance_is_drawn() -> None:
    """The rollers of 12 mm allow 0.24 mm."""
    lot = tolerance_map(epicyclic.load(drawn(train(), {CLEARANCE: "uniform(0.15 mm, 0.2 mm)"})))
    assert not lot.evaluate(np.full((1, lot.dimension_entry.size), 0.5)).failed.any()


def test_lost_motion_of_an_output_follows_the_clearance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outputs, "sampling_plan", lambda *_, **__: replace(FEW, samples=4, scrambles=4))
    model = with_play()
    for mesh in model["stages"]["main"]["meshes"].values():
        mesh["backlash"] = "0.1 mm"
    model["operation"]["torque"] = {"sun": "600 N m"}

    def lost(play: str, tolerance: str = "") -> Any:
        """Lost motion at 3 % of the rated torque [rad], of the samples or of the one train."""
        changes = {"tolerance": {PLAY: {"common": tolerance or "uniform(10 um, 40 um)"}}}
        made = epicyclic.load({**model, **changes}, {PLAY: play})
        locked = locked_train(made, output_shaft(made, "carrier", None, None))
        return outputs.sampled_loops(locked, [0.03], 4, 1)[0][:, 0]

    found = lost("20 um")
    (least, *_), (most, *_) = (lost("20 um", f"uniform({one} um, {one + 1e-6} um)") for one in (10, 40))
    assert len(set(found.round(9))) == 4
    assert least < found.min() < found.max() < most
