"""Stress in the tooth roots against finite elements of whole gears (docs/theory/teeth/root.json, tests/peers/plane)."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.peers.plane.roots import GEARS, root_form

from epicyclic.errors import ModelError
from epicyclic.teeth.root_stress import REACH, fillet_stress, root_influence

DOCS = Path(__file__).parents[3] / "docs" / "theory"
TABLE: dict[str, Any] = json.loads((DOCS / "teeth" / "root.json").read_text(encoding="utf-8"))


def ours(name: str, radius: float) -> tuple[float, float]:
    right, left = fillet_stress(root_influence(root_form(name)), radius)
    return float(right.max()), float(left.min())


def test_all_gears_are_in_the_table() -> None:
    assert set(TABLE) == set(GEARS)


@pytest.mark.parametrize("name", GEARS)
def test_largest_stress(name: str) -> None:
    # 5 % is the bound of the method; tension is found within 0.6 %, compression, on the side where the elements of the
    # table are coarser, within 2.5
    for entry in TABLE[name]:
        tension, compression = ours(name, entry["radius"])
        assert tension == pytest.approx(entry["tension"], rel=0.01)
        assert compression == pytest.approx(entry["compression"], rel=0.03)


@pytest.mark.parametrize("name", GEARS)
def test_page_has_the_table(name: str) -> None:
    cells = [name]
    for entry in TABLE[name]:
        tension, compression = ours(name, entry["radius"])
        cells.append(f"{entry['tension']:.0f}, {tension:.0f}")
        cells.append(f"{entry['compression']:.0f}, {compression:.0f}")
    cells.append(", ".join(f"{100 * (entry['notch'] / entry['tension'] - 1):.0f}" for entry in TABLE[name]))
    assert f"| {' | '.join(cells)} |" in (DOCS / "contact.md").read_text(encoding="utf-8")


def test_twice_the_elements() -> None:
    gear = root_form("27 teeth, 20 deg")
    coarse, fine = root_influence(gear), root_influence(gear, refined=2)
    for radius in np.linspace(*coarse.limits, 4):
        for a, b in zip(fillet_stress(coarse, radius), fillet_stress(fine, radius), strict=True):
            assert np.abs(a).max() == pytest.approx(np.abs(b).max(), rel=5e-3)


def test_module_and_modulus() -> None:
    # stress per load per length goes with 1/m and not with E
    gear = root_form("19 teeth, 25 deg")
    large = replace(gear, module=2 * gear.module, bore=2 * gear.bore, youngs_modulus=70e9)
    low, high = root_influence(gear).limits
    for radius in (low, 0.5 * (low + high), high):
        one = fillet_stress(root_influence(gear), radius)
        np.testing.assert_allclose(2 * fillet_stress(root_influence(large), 2 * radius), one, rtol=1e-6, atol=1e-6)


def test_load_behind_bends_and_load_ahead_presses() -> None:
    # the body between the loaded tooth and the fillet behind it is stretched, the one ahead compressed
    influence = root_influence(root_form("27 teeth, 20 deg"))
    radius = influence.limits[1]
    own, behind, ahead = (fillet_stress(influence, radius, ahead=n)[0] for n in (0, -1, 1))
    assert own.max() > 5 * behind.max() > 5 * abs(ahead.max())
    assert ahead.min() < -0.2 * own.max()
    # and the reach is long enough for what is in contact together
    assert np.abs(fillet_stress(influence, radius, ahead=REACH)[0]).max() < 0.05 * own.max()


def test_a_shorter_arm() -> None:
    # a load near the root has a shorter arm than one at the tip
    influence = root_influence(root_form("60 teeth, sharp fillet"))
    low, high = influence.limits
    assert fillet_stress(influence, high)[0].max() > 1.7 * fillet_stress(influence, low)[0].max()


def test_helical_teeth_are_those_of_the_normal_section() -> None:
    spur = root_form("35 teeth, shift 0.4")
    helical = replace(spur, helix_angle=math.radians(20), bore=spur.bore * 1.06)
    of_spur, of_helical = root_influence(spur), root_influence(helical)
    # 42 virtual teeth in place of 35
    a = fillet_stress(of_spur, of_spur.limits[1])[0].max()
    b = fillet_stress(of_helical, of_helical.limits[1])[0].max()
    assert b == pytest.approx(a, rel=0.05)


def test_pointed_teeth_are_refused() -> None:
    with pytest.raises(ModelError, match="pointed"):
        root_influence(replace(root_form("19 teeth, 25 deg"), profile_shift=1.2), path="stages.main.sun")
