"""What `check` says that verbs still need is what they refuse: every verb is run on trains that lack something."""

from __future__ import annotations

import copy
import json
import warnings
from collections.abc import Mapping
from typing import Any

import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.check.views import check_tables
from epicyclic.verbs.record import verbs

pytestmark = pytest.mark.usefixtures("few_turning_trains")

BEARING = {
    "radial": "4e8 N/m",
    "type": "cylindrical roller",
    "elements": 14,
    "element_diameter": "12 mm",
    "element_length": "16 mm",
    "pitch_diameter": "70 mm",
}
BASE: dict[str, Any] = {
    "format": 2,
    "title": "a good reducer",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "helix_angle": "15 deg",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "mass": "3 kg", "inertia": "4e-3 kg m^2", "support": {"radial": "5e7 N/m"}},
            "planet": {"teeth": 30, "mass": "4 kg", "inertia": "9e-3 kg m^2", "bearing": BEARING},
            "ring": {"teeth": 84, "mass": "14 kg", "inertia": "0.5 kg m^2", "addendum": 0.9, "rim": "25 mm"},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
            "meshes": {"sun-planet": {"stiffness": "9e8 N/m"}, "planet-ring": {"stiffness": "1.1e9 N/m"}},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
    "tolerance": {
        "deviations.main.planet.position.y": "normal(0 um, 10 um)",
        "cost": {"deviations.main.planet.position.y": {"normal(0 um, 10 um)": 1}},
    },
}
MOTOR = {
    "bodies": {"motor": {"mass": "50 kg", "inertia": "0.4 kg m^2"}},
    "couplings": {"shaft": {"between": ["main.sun", "motor"], "rz": "1e6 N m/rad", "radial": "1e7 N/m"}},
}


def changed(path: str, value: object) -> dict[str, Any]:
    """BASE with a value at a path; None takes it away."""
    model = copy.deepcopy(BASE)
    *above, key = path.split(".")
    table = model
    for name in above:
        table = table.setdefault(name, {})
    if value is None:
        table.pop(key)
    else:
        table[key] = value
    return model


RESPONSES = {"load_factors", "modulation", "sharing", "steady", "sweep"}
DYNAMIC = RESPONSES | {"campbell", "matrices", "detune", "modes", "sensitivity", "stability", "track", "transient"}
# model, path of the message, verbs that need it
LACKING = {
    "damping": (changed("damping", None), "damping", RESPONSES),
    "speed": (
        changed("operation.speed", None),
        "operation.speed",
        RESPONSES | {"campbell", "detune", "efficiency", "life", "stability", "transient"},
    ),
    "torque": (
        changed("operation.torque", None),
        "operation.torque",
        {"allocate", "contact", "efficiency", "load_factors", "output", "relief", "sharing", "tolerance"},
    ),
    "tolerance": (changed("tolerance", None), "tolerance", {"allocate", "tolerance"}),
    "prices": (changed("tolerance.cost", None), "tolerance.cost", {"allocate"}),
    "face width": (
        changed("stages.main.face_width", None),
        "stages.main.face_width",
        {"contact", "efficiency", "relief"},
    ),
    "tilt inertia": (
        changed("stages.main.carrier.support", {"radial": "1e9 N/m", "tilt": "1e8 N m/rad"}),
        "stages.main.carrier.tilt_inertia",
        DYNAMIC,
    ),
    "no inertia": (changed("stages.main.carrier.inertia", 0), "stages.main.carrier.inertia", DYNAMIC),
    "thrust": (
        changed("stages.main.sun.support.z", 0),
        "stages.main.sun.support.z",
        RESPONSES | {"allocate", "contact", "life", "static", "tolerance", "transient"},
    ),
    "coupling": (
        {**BASE, **MOTOR},
        "couplings.shaft",
        DYNAMIC | {"allocate", "contact", "life", "static", "tolerance"},
    ),
    "rolling": (changed("stages.main.planet.bearing", {"radial": "4e8 N/m"}), "stages.*.planet.bearing.type", {"life"}),
}
SHORT: Mapping[str, Mapping[str, Any]] = {
    "allocate": {"target": 3.0, "samples": 2048, "fresh_samples": 2048},
    "contact": {"samples": 2, "slices": 2, "loads": (1.0,)},
    "life": {"instants": 8},
    "output": {"points": 4, "phases": 1, "samples": 256},
    "relief": {
        "vary": {"tip_relief.amount": "0..20 um", "tip_relief.length": "1..2 mm"},
        "population": 4,
        "generations": 1,
        "samples": 4,
        "slices": 2,
    },
    "sharing": {"cycles": 1, "samples": 16},
    "stability": {"points": 2},
    "static": {"cycles": 1, "samples": 4},
    "sweep": {"points": 2},
    "tolerance": {"samples": 256, "effects": "none"},
    "track": {"over": "stages.main.sun.support.radial", "points": 3},
    "transient": {"duration": 0.005},
}


def refusal(verb: str, model: Any) -> str | None:
    """Path that a verb names when it refuses a model; None where it gives a result."""
    try:
        verbs()[verb].run(model, **SHORT.get(verb, {}))
    except ModelError as error:
        return error.path
    return None


def lacking(model: Any) -> dict[str, list[str]]:
    found = epicyclic.check(model)
    rows = zip(found.verb_name.values.tolist(), found.verb_needs.values.tolist(), strict=True)
    return {verb: text.split("\n") if text else [] for verb, text in rows}


def test_every_verb_has_its_needs() -> None:
    assert lacking(BASE).keys() == verbs().keys() - {"check"}


@pytest.mark.parametrize("verb", sorted(verbs().keys() - {"check"}))
def test_a_train_that_lacks_nothing_is_ready(verb: str) -> None:
    assert lacking(BASE)[verb] == []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert refusal(verb, BASE) is None


@pytest.mark.parametrize("what", LACKING)
def test_verbs_refuse_what_check_says(what: str) -> None:
    model, path, expected = LACKING[what]
    needs = lacking(model)
    assert {verb for verb, texts in needs.items() if texts} == expected
    for verb in expected:
        assert all(text.startswith(path) for text in needs[verb])
        assert refusal(verb, model) == path, verb


@pytest.mark.parametrize("what", ["torque", "coupling"])
def test_other_verbs_run(what: str) -> None:
    model, _, expected = LACKING[what]
    for verb in verbs().keys() - {"check"} - expected:
        assert refusal(verb, model) is None, verb


def test_the_table_names_every_message_once() -> None:
    model, *_ = LACKING["coupling"]
    assert json.loads(epicyclic.check(model).attrs["warnings"])[-1].startswith("couplings.shaft: joins bodies")
    (table,) = (one for one in check_tables(epicyclic.check(model)) if one.title.startswith("What each verb"))
    rows = dict(zip(table.columns["verb"], map(str, table.columns["state"]), strict=True))
    assert rows["modes"] == "needs 1"
    assert rows["stiffness"] == "ready"
    assert len(table.notes) == 1
    assert table.notes[0].startswith("couplings.shaft: joins bodies whose frames turn at different speeds")


def test_clearance_backlash_and_the_load_of_a_tangent() -> None:
    model = copy.deepcopy(BASE)
    stage = model["stages"]["main"]
    stage["planet"]["bearing"]["clearance"] = "12 um"
    table = {"deflection": "[0, 10, 20] um", "force": "[0, 4, 10] kN", "load": "5 kN"}
    stage["meshes"]["sun-planet"] = {"stiffness": table, "direction": "transverse", "backlash": "0.2 mm"}
    found = epicyclic.check(model)
    assert found.link_clearance.sel(link="main/planet/1/bearing") == 12e-6
    assert found.link_clearance.sel(link="main/sun/support") == 0
    assert found.backlash.sel(mesh="main/sun-planet/1") == pytest.approx(0.2e-3)
    values = {path: (value, unit, origin) for path, value, unit, origin in json.loads(found.attrs["values"])}
    where = "stages.main.meshes.sun-planet.stiffness"
    load = float(found.tangent_load.sel(mesh="main/sun-planet/1"))
    # cos beta_b of the normal plane: sin beta_b = sin beta cos alpha_n
    cosine = (1 - (0.2588190451 * 0.9396926208) ** 2) ** 0.5
    assert load == pytest.approx(5000 / cosine, rel=1e-9)
    assert values[f"{where}.load"] == (pytest.approx(5000), "N", "given, transverse")
    assert values[f"{where}.normal_load"] == (pytest.approx(load), "N", "along the tooth normal")
    assert values[f"{where}.tangent"][2] == "table, along the tooth normal"
    shown = {heading for one in check_tables(found) for heading in one.columns}
    assert {"clearance [µm]", "backlash [µm]", "tangent at a force of [N]"} <= shown
