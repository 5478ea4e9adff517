"""Loads along motions that nothing holds are named by member, direction and amount, against closed forms."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.statics.equilibrium import compliance_of
from epicyclic.statics.record import unheld

TORQUE = 3000.0
HELIX = math.radians(12)
MODEL: dict[str, Any] = {
    "format": 2,
    "title": "a sun that slides on its spline",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "helix_angle": "12 deg",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"radial": 0, "z": 0}},
            "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": "25 mm", "addendum": 0.8},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": TORQUE}},
}
THRUST = TORQUE / (24 * 0.004 / math.cos(HELIX) / 2) * math.tan(HELIX)


def changed(**changes: Any) -> dict[str, Any]:
    """The model with values at paths, dots written as two underscores."""
    model = copy.deepcopy(MODEL)
    for path, value in changes.items():
        *above, key = path.split("__")
        table = model
        for name in above:
            table = table.setdefault(name, {})
        table[key] = value
    return model


@pytest.mark.parametrize(
    "verb",
    [
        epicyclic.static,
        epicyclic.sharing,
        lambda model: epicyclic.sharing(model, method="static"),
        epicyclic.steady,
        lambda model: epicyclic.transient(model, duration=0.01),
        lambda model: epicyclic.contact(model, samples=2, slices=2, loads=(1.0,)),
    ],
)
def test_verbs_name_the_thrust_and_its_key(verb: Callable[[Any], object]) -> None:
    with pytest.raises(ModelError) as refused:
        verb(MODEL)
    assert refused.value.path == "stages.main.sun.support.z"
    assert f"nothing takes the thrust of {THRUST / 1e3:.4g} kN on main/sun" in str(refused.value)
    assert "radii" not in str(refused.value)


@pytest.mark.parametrize("verb", [epicyclic.modes, epicyclic.check])
def test_verbs_that_need_no_load_warn(verb: Callable[[Any], Any]) -> None:
    (said,) = json.loads(verb(MODEL).attrs["warnings"])
    assert f"nothing takes the thrust of {THRUST / 1e3:.4g} kN on main/sun" in said
    for held in ("inf", "1e8 N/m"):
        assert json.loads(verb(changed(stages__main__sun__support__z=held)).attrs["warnings"]) == []


def found(model: dict[str, Any], force: Any = None) -> dict[str, float]:
    system = epicyclic.assemble(epicyclic.load(model))
    load = system.force + sum(line.force[0].real for line in system.lines if line.frequency == 0)
    given = load if force is None else force(system, load)
    return {one.name: one.load for one in unheld(compliance_of(system).free, given, system.dofs.names)}


def test_several_at_once() -> None:
    """Sun, carrier and ring slide, and a force pulls at the carrier: three reactions, of which two are thrusts."""
    model = changed(
        stages__main__carrier__support={"z": 0},
        stages__main__ring__support={"z": 0},
        loads__pull={"on": "main.carrier", "force": {"z": "700 N"}},
    )
    assert {name: abs(load) for name, load in found(model).items()} == pytest.approx(
        {"main/sun/z": THRUST, "main/ring/z": THRUST, "main/carrier/z": 700.0},
        rel=1e-9,  # of a null space
    )


def test_bearings_of_planets_are_named_by_their_key() -> None:
    """Axial forces of sun and ring cancel on a planet; a pull at each of them has nothing to hold it."""
    model = changed(
        stages__main__sun__support__z="inf",
        stages__main__planet__bearing__z=0,
        loads__pull={"on": "main.planet", "force": {"z": "50 N"}},
    )
    assert found(model) == pytest.approx({f"main/planet/{i}/z": 50.0 for i in (1, 2, 3)}, rel=1e-9)
    with pytest.raises(ModelError) as refused:
        epicyclic.static(model)
    assert refused.value.path == "stages.main.planet.bearing.z"


def test_of_several_bearings_the_keys_and_the_rule_are_named() -> None:
    """A direction that one names is 0 in the others; where none names it the first holds it rigidly."""
    seats: dict[str, dict[str, Any]] = {
        name: {"at": at, "radial": "4e8 N/m"} for name, at in (("front", "-40 mm"), ("rear", "40 mm"))
    }
    (held,) = [link for link in epicyclic.load(changed(stages__main__sun__support=seats)).links if "front" in link.name]
    assert held.stiffness[2] == math.inf
    seats["rear"]["z"] = 0
    with pytest.raises(ModelError, match=r"is 0 in those that do not name it") as refused:
        epicyclic.static(changed(stages__main__sun__support=seats))
    assert refused.value.path == "stages.main.sun.support"
    assert "stages.main.sun.support.front.z, stages.main.sun.support.rear.z" in refused.value.allowed
    (said,) = json.loads(epicyclic.modes(changed(stages__main__sun__support=seats)).attrs["warnings"])
    assert said.startswith(str(refused.value))


def test_torques_out_of_balance_are_no_matter_of_supports() -> None:
    def unbalanced(system: Any, load: Any) -> Any:
        return load + 100.0 * np.array([name == "main/sun/rz" for name in system.dofs.names])

    assert found(changed(stages__main__sun__support__z="inf"), unbalanced) == {}
    assert found(changed(stages__main__sun__support__z="inf")) == {}
    assert found(MODEL, lambda system, load: 0 * load) == {}
