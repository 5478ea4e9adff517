"""Life under steady vibration: slow it is that at rest, an amplified force by hand; turns through all phases."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from tests.unit.questions.rating.test_life import PARTS, RPM, TEETH, drum, train

import epicyclic

HEAVY = {"mass": "300 kg", "inertia": "3 kg m^2"}


def mean_power(force: Any, p: float = 10 / 3) -> float:
    """P = (mean F^p)^(1/p)."""
    return float(np.mean(np.asarray(force) ** p) ** (1 / p))


def slowed(model: dict[str, Any]) -> dict[str, Any]:
    """The model at a thousandth of its speed."""
    model["operation"]["speed"] = {"carrier": f"{RPM / 1000} rpm"}
    return model


def test_slow_vibration_is_the_state_at_rest() -> None:
    """Run-outs, weight and the mesh cycle on linear bearings: the same loads at a thousandth of the speed."""
    model = slowed(train(radial="2e8 N/m"))
    model["stages"]["main"]["planet"] |= HEAVY
    model["operation"]["gravity"] = True
    of_teeth = {"turns_with": "ring", "amplitude": "[3, 0, 0] um", "order": TEETH[2]}
    model["deviations"] = {
        "planet": {"run_out": ["30 um", 0, 0]},
        "meshes": {"planet-ring": {"errors": {"one": of_teeth}}},
    }
    still, moved = (epicyclic.life(model, forces=one, instants=32) for one in ("static", "steady"))
    np.testing.assert_allclose(moved.bearing_load, still.bearing_load, rtol=1e-4)
    np.testing.assert_allclose(moved.bearing_force_peak, still.bearing_force_peak, rtol=1e-3)
    np.testing.assert_allclose(moved.bearing_life_reference, still.bearing_life_reference, rtol=1e-3)
    assert np.ptp(still.bearing_load.values) > 0.01 * float(still.bearing_load.max())


@pytest.mark.parametrize("bearing", ["table", "five rows"])
def test_forces_of_laws_stand_along_their_own_rows(bearing: str) -> None:
    """Tangents have axes of their own; under equal planets without errors the forces are those of the laws at rest."""
    more = {} if bearing == "table" else {"type": "tapered roller", "contact_angle": "14 deg", "rows": 2}
    model = slowed(train(**more, internal_clearance=0))
    model["stages"]["main"]["helix_angle"] = "12 deg" if more else 0
    if more:  # off the middle, or elements of both rows bear most alike
        model["stages"]["main"]["planet"]["bearing"]["at"] = "3 mm"
    still, moved = (epicyclic.life(model, forces=one, instants=8) for one in ("static", "steady"))
    np.testing.assert_allclose(moved.element_load, still.element_load, rtol=1e-3, atol=1e-3 * still.element_load.max())
    np.testing.assert_allclose(moved.bearing_life_reference, still.bearing_life_reference, rtol=1e-3)


def test_an_amplified_force_that_turns_beside_a_weight_by_hand() -> None:
    """At half of its natural frequency a pull that turns with the drum grows by 4/3; F^2 = W^2 + A^2 + 2 W A cos."""
    stiffness = 50 * (2 * pi * 2 * RPM / 60) ** 2
    model = drum(loads={"pull": {"on": "drum", "force": {"x": "500 N"}, "frame": "member"}})
    model["bodies"]["drum"]["support"] = {**PARTS, "radial": f"{stiffness} N/m"}
    model["operation"]["gravity"] = True
    model["damping"]["modal"] = 1e-4
    angle, weight = 2 * pi * np.arange(1000) / 1000, 50 * 9.80665
    for pull, options in ((500.0, {}), (500.0 / 0.75, {"forces": "steady"})):
        found = epicyclic.life(model, **options, instants=64).sel(bearing="drum/support")  # type: ignore[arg-type]
        by_hand = mean_power(np.sqrt(weight**2 + pull**2 + 2 * weight * pull * np.cos(angle)))
        assert found.bearing_load.item() == pytest.approx(by_hand, rel=1e-3)


def test_run_outs_and_weight_meet_at_all_phases() -> None:
    """A planet turns 14 times in 5 turns of the carrier: P is that of all five, at 67 instants spread over them."""
    model = train()
    model["stages"]["main"]["planet"] |= HEAVY
    model["operation"]["gravity"] = True
    model["deviations"] = {"planet": {"run_out": ["60 um", 0, 0]}}
    whole = epicyclic.static(model, turns=5, of="main/carrier", samples=112)
    force = np.hypot(*(whole.group_row_force.sel(group_row=f"main/planet/1/bearing/{axis}").values for axis in "xy"))
    one_turn, five = mean_power(force[:112]), mean_power(force)
    assert abs(one_turn / five - 1) > 5e-3
    found = epicyclic.life(model, instants=64).sel(bearing="main/planet/1/bearing")
    assert found.bearing_load.item() == pytest.approx(five, rel=2e-3)


def test_an_order_that_divides_the_instants_shows_its_whole_cycle() -> None:
    """64 waves in a turn of the carrier at 32 instants would stand at one phase; a prime number passes all."""
    model = train(radial="2e8 N/m")
    waves = {"turns_with": "ring", "amplitude": "[15, 0, 0] um", "order": 64}
    model["deviations"] = {"meshes": {"planet-ring": {"errors": {"one": waves}}}}
    found = epicyclic.life(model, instants=32).sel(bearing="main/planet/1/bearing")
    static = epicyclic.static(model, turns=1, of="main/carrier", samples=640)
    force = np.hypot(*(static.link_force.sel(link_row=f"main/planet/1/bearing/{axis}").values for axis in "xy"))
    assert force.max() > 1.05 * force.min()
    assert found.bearing_load.item() == pytest.approx(mean_power(force), rel=1e-4)
