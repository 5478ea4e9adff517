"""Micro-geometry that the mesh stiffness ignores: every verb of the equation says so, and with which key it counts."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

import epicyclic

CODE = "[flank-without-effect]"
RELIEF = {"stages.main.planet.flank.tip_relief": {"amount": "30 um", "length": "1.5 mm"}}
COUNTS = {f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")}
SMALL: dict[str, Any] = {"relative_speed": 1.0, "samples": 16}


def _steady(overrides: dict[str, Any]) -> Any:
    return epicyclic.steady("wind-five", overrides=overrides, **SMALL)


def test_relief_that_no_stiffness_knows_is_said_by_every_verb() -> None:
    plain, relieved = _steady({}), _steady(RELIEF)
    # without effect to all digits that the solver has
    np.testing.assert_allclose(relieved.dynamic_factor, plain.dynamic_factor, rtol=1e-9)
    verbs: tuple[Callable[..., Any], ...] = (epicyclic.modes, epicyclic.matrices)
    for result in (relieved, *(verb("wind-five", overrides=RELIEF) for verb in verbs)):
        (said,) = [text for text in json.loads(result.attrs["warnings"]) if CODE in text]  # one for all pairs
        assert "stages.main.meshes.sun-planet.stiffness, stages.main.meshes.planet-ring.stiffness" in said
    assert CODE not in str(plain.attrs)


def test_relief_that_the_stiffness_counts_has_an_effect_and_no_warning() -> None:
    plain, relieved = _steady(COUNTS), _steady(RELIEF | COUNTS)
    assert CODE not in str(relieved.attrs)
    assert np.abs(relieved.dynamic_factor / plain.dynamic_factor - 1).max() > 1e-4
