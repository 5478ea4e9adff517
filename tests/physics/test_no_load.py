"""Meshes that follow a table of their contact, and no torque at all: no verb takes rounding for a force."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.sharing.tone_forces import Method

TABLE = {"deflection": "[0, 5, 10, 20] um", "force": "[0, 4, 9, 20] kN"}


def idle(stiffness: object) -> dict[str, Any]:
    mesh = {"stiffness": stiffness, "backlash": "0.1 mm"}
    return {
        "format": 2,
        "title": "idle",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 3,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
                "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": 84, "rim": "25 mm", "addendum": 0.9},
                "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
                "meshes": {"sun-planet": mesh, "planet-ring": mesh},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": 0}},
        "deviations": {"planet": {"run_out": "15 um"}},
    }


@pytest.mark.parametrize(("stiffness", "why"), [(TABLE, "10 kN, half of the last force"), ("contact", "kN, 100 N/mm")])
def test_without_torque_nothing_presses(stiffness: object, why: str) -> None:
    model = idle(stiffness)
    found = epicyclic.static(model, cycles=10, samples=8)
    # forces are rounding of displacements of micrometres, 1e-9 N
    assert np.abs(found.mesh_force).max() < 1e-6
    assert (found.open_share == 1).all()
    assert (found.far_share == 0).all()
    assert not any("far flank" in text for text in json.loads(found.attrs["warnings"]))
    methods: tuple[Method, ...] = ("steady", "superposition", "static")
    for method in methods:
        with pytest.raises(ModelError, match="load sharing needs a load"):
            epicyclic.sharing(model, method=method)
    # linear verbs have a tangent at some load, and say that it is not that of the operation
    warnings = [text for text in json.loads(epicyclic.modes(model).attrs["warnings"]) if "no torque passes" in text]
    assert len(warnings) == 2
    assert all(why in text for text in warnings)
    loaded = {**model, "operation": {**model["operation"], "torque": {"sun": "800 N m"}}}
    assert "no torque passes" not in epicyclic.modes(loaded).attrs["warnings"]


def test_teeth_that_rattle_without_torque_are_named() -> None:
    with pytest.raises(ConvergenceError, match=r"no torque presses the teeth together \(operation\.torque or"):
        epicyclic.steady(idle(TABLE), contact_loss=True)
    # planets that their centrifugal load centres in the backlash: flanks at first touch count alike
    found = epicyclic.steady(idle("iso6336"), contact_loss=True)
    warnings = json.loads(found.attrs["warnings"])
    assert sorted(text.split()[-1] for text in warnings) == ["[lines-superposed]", "[no-torque]"]
    # a flank without preload pushes during half of each turn: sqrt(1/2) of the superposed force is not there
    assert any("off by 0.71 of itself (RMS)" in text for text in warnings)


@pytest.mark.parametrize("torque", ["0 N m", "1 N m"])
def test_contact_loss_names_the_load_that_is_missing(torque: str) -> None:
    given = idle("iso6336")
    del given["deviations"]
    given["operation"]["torque"] = {"sun": torque}
    options: dict[str, Any] = {"contact_loss": True, "shaft_orders": False}
    results = [epicyclic.steady(given, **options), epicyclic.sweep(given, mesh_frequency=[100.0], **options)]
    for found in results:
        notes = [text for text in json.loads(found.attrs["warnings"]) if text.endswith("[no-torque]")]
        assert len(notes) == (torque == "0 N m")
        assert all("operation.torque" in text for text in notes)


def test_contact_without_torque_is_refused() -> None:
    with pytest.raises(ModelError, match=r"operation\.torque"):
        epicyclic.contact(idle("contact"))
