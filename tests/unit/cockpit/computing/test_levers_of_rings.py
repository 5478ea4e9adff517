"""The rim of a ring that bends is a lever, and the form of the page knows what makes it bend."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

import epicyclic
from epicyclic.cockpit.computing.levers import levers_of
from epicyclic.cockpit.state.model_file import group_at, typed_value

STAGE = Path(epicyclic.__file__).parent / "systems" / "wind-stage.toml"


def stage(elastic: object = None) -> dict[str, Any]:
    tables = tomllib.loads(STAGE.read_text(encoding="utf-8"))
    if elastic is not None:
        tables["stages"]["main"]["ring"]["elastic"] = elastic
    return tables


def test_the_rim_of_a_ring_that_bends_is_a_lever_beside_the_others() -> None:
    bent, rigid = (levers_of(stage(elastic), {}) for elastic in ({"modes": 4}, None))
    (rim,) = (lever for lever in bent if lever.kind == "rim")
    assert (rim.path, rim.value, rim.unit, rim.least, rim.most) == ("stages.main.ring.rim", 130.0, "mm", 65.0, 260.0)
    assert "moves a mode of" in rim.why
    assert len(bent) == len(rigid) + 1
    # where the file says how stiff it is, the rim does not
    stated = levers_of(stage({"modes": 4, "bending": "1.5e7 N m^2"}), {})
    assert "rim" not in [lever.kind for lever in stated]


@pytest.mark.parametrize(("elastic", "text"), [(None, ""), (True, "true")])
def test_the_form_has_a_field_that_takes_true_or_a_table(elastic: object, text: str) -> None:
    (field,) = (field for field in group_at(stage(elastic), "stages.main.ring").fields if field.key == "elastic")
    assert field.text == text
    for typed in ("true", "{ modes = 6 }"):
        value = typed_value(field.path, typed)
        assert any(body.elastic for body in epicyclic.load(stage(), {field.path: value}).bodies)


def test_the_form_opens_a_stated_table() -> None:
    tables = stage({"modes": 6, "foundation": {"radial": "1e9 N/m^2"}})
    assert "elastic" in group_at(tables, "stages.main.ring").stated
    inner = group_at(tables, "stages.main.ring.elastic")
    assert {field.key: field.text for field in inner.fields if field.text} == {"modes": "6"}
    assert inner.stated == {"foundation"}
