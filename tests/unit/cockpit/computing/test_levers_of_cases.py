"""Levers and loads of the case that is computed."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from epicyclic import load
from epicyclic.cockpit.computing.answers import assumed_of
from epicyclic.cockpit.computing.levers import levers_at
from epicyclic.cockpit.computing.train_view import live_sharing
from epicyclic.system.assembly import assemble

MODELS = Path(__file__).parents[4] / "examples" / "models"


def tables(name: str) -> dict[str, Any]:
    return tomllib.loads((MODELS / f"{name}.toml").read_text(encoding="utf-8"))


def test_levers_of_the_operation_are_those_that_the_case_states() -> None:
    def of_operation(overrides: dict[str, object]) -> dict[str, float]:
        kinds = ("load", "speed")
        return {one.path: one.value for one in levers_at(tables("hybrid"), overrides) if one.kind in kinds}

    assert of_operation({}) == {"operation.torque.engine": 140, "operation.speed.engine": 1800}
    assert of_operation({"case": "electric"}) == {
        "cases.electric.torque.range.sun": 80,
        "cases.electric.speed.output": 500,
    }
    # which leaves its torques to the operation
    assert list(of_operation({"case": "compound_split"})) == [
        "operation.torque.engine",
        "cases.compound_split.speed.engine",
    ]


def test_an_idle_mesh_has_no_load_in_the_drawing() -> None:
    view = live_sharing(assemble(load(MODELS / "ravigneaux.toml", {"case": "third"})))
    idle = np.array([name.startswith("main/large-long") for name in view.spread.mesh])
    assert np.isnan(view.load[idle]).all()
    assert np.allclose(view.load[~idle], 1)


def test_answers_rest_on_what_is_assumed_of_the_point_that_is_computed() -> None:
    paths = ("operation.torque.range.sun", "cases.electric.torque.range.sun", "cases.compound_split.speed.engine")
    model = {**tables("hybrid"), "assumed": dict.fromkeys(paths, "a guess")}

    def assumed(case: str, key: str) -> list[str]:
        return list(assumed_of(load(model, {"case": case} if case else {}), key))

    assert assumed("", "planet") == [paths[0]]
    assert assumed("electric", "planet") == [paths[1]]
    assert assumed("compound_split", "planet") == [paths[0]]  # which states no torques
    assert assumed("compound_split", "resonance") == [paths[2]]
