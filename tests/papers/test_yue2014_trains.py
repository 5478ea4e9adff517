"""Yue 2014, meshed double planets: geometry, assembly and kinematics of the three ready drives.  [yue2014]"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

import pytest

from epicyclic.train.resolution import load
from epicyclic.train.train import Train

CASES = ("i", "ii", "iii")
FREE: dict[str, object] = {"operation.held": []}


def test_the_cases_differ_in_what_is_held_alone() -> None:
    def rest(case: str) -> Mapping[str, object]:
        return {
            key: value for key, value in load(f"yue2014-{case}").document.items() if key not in ("title", "operation")
        }

    assert rest("i") == rest("ii") == rest("iii")


@pytest.mark.parametrize("case", CASES)
def test_geometry(case: str) -> None:
    train = load(f"yue2014-{case}")
    bodies = {body.name: body for body in train.bodies}
    p, d = bodies["main/p/1"], bodies["main/d/1"]
    assert math.hypot(*p.centre) == pytest.approx(0.102, rel=1e-14)  # rounding, as below
    assert math.hypot(*d.centre) == pytest.approx(0.114, rel=1e-14)
    assert math.dist(p.centre, d.centre) == pytest.approx(0.078, rel=1e-13)
    cosine = (102**2 + 114**2 - 78**2) / (2 * 102 * 114)
    assert math.degrees(d.angle) == pytest.approx(math.degrees(math.acos(cosine)), rel=1e-13)
    assert math.degrees(d.angle) == pytest.approx(41.8768, abs=5e-5)  # the digits given
    ratios = {mesh.pair.rpartition(".")[2]: mesh.contact_ratio for mesh in train.meshes}
    assert ratios["p-d"] == pytest.approx(1.40581, abs=5e-6)  # the digits given
    assert {mesh.flank for mesh in train.meshes if mesh.pair.endswith("p-d")} == {-1}
    assert {mesh.flank for mesh in train.meshes if not mesh.pair.endswith("p-d")} == {1}


def test_assembly_takes_a_whole_number_of_teeth() -> None:
    """(z_r - z_s)/N is whole: sun and ring turn the same way, so the difference counts, not the sum."""
    assert Fraction(77 - 32, 3) == 15
    for planets in (2, 3, 4, 5, 6, 9):
        train = load("yue2014-i", {"stages.main.planets": planets})
        assert any("cannot be assembled" in text for text in train.warnings) == ((77 - 32) % planets != 0)


def ratio(train: Train, driven: str, driver: str) -> Fraction:
    (freedom,) = train.kinematics.freedoms
    speed = train.kinematics.ratio
    return speed[f"main.{driven}"][freedom] / speed[f"main.{driver}"][freedom]


def test_ratios_of_the_three_cases() -> None:
    assert ratio(load("yue2014-i"), "ring", "sun") == Fraction(32, 77)
    assert ratio(load("yue2014-ii"), "carrier", "sun") == Fraction(-32, 45)
    assert ratio(load("yue2014-iii"), "carrier", "ring") == Fraction(77, 45)
    assert len(load("yue2014-i", FREE).kinematics.freedoms) == 2
