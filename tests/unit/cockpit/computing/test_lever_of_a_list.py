"""The lever of one pin moves that pin alone: of equal pins nothing would part the load."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from epicyclic.cockpit.page.page import LeverControl
from epicyclic.cockpit.state.state import opened, request_of, with_value
from epicyclic.questions.sharing.verbs import sharing

PATH = "deviations.planet.position.y"


def pin_lever(state: Any, *, entry: int) -> Any:
    """The part of a lever that reads and writes, without its element."""
    lever: Any = LeverControl.__new__(LeverControl)
    lever.path, lever._unit = PATH, "um"
    lever._entry, lever._count, lever._session = entry, 3, SimpleNamespace(state=state)
    return lever


def test_one_entry_is_written_and_read() -> None:
    state = opened("wind-stage")
    assert pin_lever(state, entry=0)._read("[35, 0, 0] um") == 35.0
    value = pin_lever(state, entry=1)._written(12.0)
    assert value == "[35.0, 12.0, 0.0] um"


def test_a_list_that_is_missing_begins_with_zeros() -> None:
    state = opened("ren2021")
    changed = with_value(state, PATH, pin_lever(state, entry=0)._written(40.0))
    source, overrides = request_of(changed)
    k = [
        float(sharing(source, overrides=given, method="static")["load_sharing"].sel(definition="mean-load").max())
        for given in ({}, overrides)
    ]
    assert k[1] > k[0] + 0.01
    assert k[1] == pytest.approx(1.061, abs=6e-4)
