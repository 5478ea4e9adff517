"""Teeth set over a drive that states radii and masses: those follow, each named; unchanged teeth move nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.document.document import read, ready_drives


def _teeth(data: Any) -> dict[str, int]:
    return {
        f"stages.{stage}.{member}.teeth": table["teeth"]
        for stage, tables in data["stages"].items()
        for member, table in tables.items()
        if isinstance(table, dict) and "teeth" in table
    }


@pytest.mark.parametrize("drive", ready_drives())
def test_the_same_teeth_move_no_number(drive: str) -> None:
    plain = read(drive)
    again = read(drive, _teeth(plain.data))
    silent: dict[str, Any] = {"assumed": {}}  # a reason why these teeth were assumed goes with the override
    assert again.model.model_copy(update=silent) == plain.model.model_copy(update=silent)
    assert again.data | silent == plain.data | silent
    assert again.warnings == plain.warnings


def test_radii_without_a_module_keep_their_module_and_fit_the_axes() -> None:
    """lin1999 prints radii and no module: other teeth have that module."""
    before = epicyclic.load("lin1999-n4")
    overrides = {"stages.main.sun.teeth": 30, "stages.main.ring.teeth": 98}
    after = epicyclic.load("lin1999-n4", overrides=overrides)
    old, new = ({b.member: b for b in train.bodies} for train in (before, after))
    for member, ratio in (("sun", 30 / 26), ("ring", 98 / 94), ("planet", 1.0)):
        a, b = old[f"main.{member}"], new[f"main.{member}"]
        assert a.gear is not None
        assert b.gear is not None
        assert b.gear.base_radius == pytest.approx(a.gear.base_radius * ratio, rel=1e-12)
        assert b.gear.module == pytest.approx(a.gear.module, rel=1e-12)
        assert b.mass == pytest.approx(a.mass * (ratio if member == "ring" else ratio**2), rel=1e-12)
        power = 3 if member == "ring" else 4  # J/r^2 is stated: r^2 comes on top
        assert b.inertia == pytest.approx(a.inertia * ratio**power, rel=1e-12)
    assert np.hypot(*new["main.planet"].centre) == pytest.approx(88.4e-3 * (30 + 34) / (26 + 34))
    told = next(text for text in after.warnings if "other teeth" in text)
    for name in ("sun.base_radius", "sun.mass", "sun.inertia", "ring.mass", "carrier.pin_radius"):
        assert name in told
    assert "planet.mass" not in told


def test_what_is_set_beside_the_teeth_stays() -> None:
    overrides = {"stages.main.sun.teeth": 24, "stages.main.sun.mass": "750 kg"}
    train = epicyclic.load("ren2021", overrides=overrides)
    sun = next(b for b in train.bodies if b.member == "main.sun")
    assert sun.mass == 750
    told = next(text for text in train.warnings if "other teeth" in text)
    assert "sun.inertia" in told
    assert "sun.mass" not in told
    assert any("set stages.main.ring.teeth = 58 too" in text for text in train.warnings)


def test_a_derived_gear_gives_the_masses_of_its_solid_either_way() -> None:
    """Independent route: a solid gear without bore whose mass is stated scales to what its solid weighs."""
    model: dict[str, Any] = {
        "format": 2,
        "title": "pair",
        "stages": {"main": {"planets": 3, "module": 0.004, "face_width": 0.05}},
    }
    members = {"sun": {"teeth": 24}, "planet": {"teeth": 30}, "ring": {"teeth": 84, "rim": 0.02}, "carrier": {}}
    model["stages"]["main"] |= members
    solid = next(b for b in epicyclic.load(model).bodies if b.member == "main.sun")
    overrides = {"stages.main.sun.teeth": 27, "stages.main.ring.teeth": 87}
    target = next(b for b in epicyclic.load(model, overrides=overrides).bodies if b.member == "main.sun")
    model["stages"]["main"]["sun"] = {"teeth": 24, "mass": solid.mass, "inertia": f"{solid.inertia!r} kg m^2"}
    stated = next(b for b in epicyclic.load(model, overrides=overrides).bodies if b.member == "main.sun")
    assert stated.mass == pytest.approx(target.mass, rel=1e-12)
    assert stated.inertia == pytest.approx(target.inertia, rel=1e-12)


def test_a_stated_tip_follows_from_the_teeth() -> None:
    overrides = {"stages.main.sun.tip_diameter": "520 mm"}
    document = read("wind-five", overrides)
    again = read(document.data, {"stages.main.sun.teeth": 36})
    assert "tip_diameter" not in again.data["stages"]["main"]["sun"]
    assert any("sun.tip_diameter follows from the teeth (was 520 mm)" in text for text in again.warnings)


def test_modes_of_a_printed_set_with_other_teeth() -> None:
    overrides = {"stages.main.sun.teeth": 30, "stages.main.ring.teeth": 98}
    result = epicyclic.modes("lin1999-n4", overrides=overrides)
    assert np.isfinite(result.frequency.values).all()


def test_teeth_beyond_all_bounds_are_refused_by_name() -> None:
    with pytest.raises(epicyclic.ModelError, match=r"stages\.main\.sun\.teeth = 1000.*: out of range"):
        epicyclic.load("lin1999-n4", overrides={"stages.main.sun.teeth": 10**100})


def test_an_error_says_which_other_teeth_to_set() -> None:
    with pytest.raises(epicyclic.ModelError, match=r"set stages\.main\.ring\.teeth = 64 too"):
        epicyclic.load("ren2021", overrides={"stages.main.sun.teeth": 30})
    assert epicyclic.load("ren2021", overrides={"stages.main.sun.teeth": 30, "stages.main.ring.teeth": 64})


def test_a_unit_that_no_file_may_have_is_refused_with_other_teeth_too() -> None:
    data = read("ren2021", {"stages.main.sun.mass": None}).data
    data["stages"]["main"]["sun"]["mass"] = "100 stone"
    with pytest.raises(epicyclic.ModelError, match=r"sun\.mass = 100 stone: unit not known"):
        read(data, {"stages.main.sun.teeth": 22})
