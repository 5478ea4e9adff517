"""Micro-geometry: what is missing where, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from epicyclic.errors import ModelError
from epicyclic.teeth.form import (
    PLAIN,
    Flank,
    Relief,
    Wave,
    check_flank,
    lead_modification,
    profile_modification,
)

FACE = (-20e-3, 20e-3)


def profile(flank: Flank, below_tip: float, above_root: float = 1.0, sigma: float = 0.0) -> float:
    return float(profile_modification(flank, below_tip=below_tip, above_root=above_root, sigma=sigma))


def test_reliefs_fade_over_their_height() -> None:
    line = Flank(tip_relief=Relief(amount=20e-6, length=2e-3))
    bow = Flank(tip_relief=Relief(amount=20e-6, length=2e-3, shape="parabolic"))
    assert [profile(line, at) for at in (-1e-3, 0.0, 1e-3, 2e-3, 3e-3)] == pytest.approx([20e-6, 20e-6, 10e-6, 0, 0])
    assert [profile(bow, at) for at in (0.0, 1e-3, 2e-3)] == pytest.approx([20e-6, 5e-6, 0])
    foot = Flank(root_relief=Relief(amount=8e-6, length=1e-3))
    assert [profile(foot, 5e-3, at) for at in (0.0, 0.5e-3, 1e-3)] == pytest.approx([8e-6, 4e-6, 0])


def test_lead_modifications() -> None:
    at = np.array([-20e-3, -10e-3, 0.0, 10e-3, 20e-3])
    assert lead_modification(Flank(crown=8e-6), at, FACE) == pytest.approx([8e-6, 2e-6, 0, 2e-6, 8e-6])
    # positive slope: the right end is missing
    assert lead_modification(Flank(slope=8e-6), at, FACE) == pytest.approx([-4e-6, -2e-6, 0, 2e-6, 4e-6])
    ends = Flank(end_relief=Relief(amount=6e-6, length=20e-3))
    assert lead_modification(ends, at, FACE) == pytest.approx([6e-6, 3e-6, 0, 3e-6, 6e-6])
    # a gear that is slid takes its crown along
    assert lead_modification(Flank(crown=8e-6), 5e-3, (-15e-3, 25e-3)) == pytest.approx(0.0)


def test_tables_and_waves_have_any_sign() -> None:
    table = Flank(profile=((0.0, 4e-6), (2e-3, -2e-6)))
    assert [profile(table, at) for at in (-1e-3, 1e-3, 5e-3)] == pytest.approx([4e-6, 1e-6, -2e-6])
    wave = Flank(waves=(Wave(amplitude=3e-6, order=2, phase=math.pi / 2),))
    sigma = 0.13
    assert profile(wave, 1e-3, sigma=sigma) == pytest.approx(3e-6 * math.cos(4 * math.pi * sigma + math.pi / 2))
    assert profile(PLAIN, 0.0) == 0.0


@pytest.mark.parametrize(
    ("flank", "path", "words"),
    [
        ({"tip_relief": Relief(amount=1e-5, length=5e-3)}, "tip_relief.length", "does not fit the flank"),
        ({"root_relief": Relief(amount=1e-5, length=0.0)}, "root_relief.length", "does not fit the flank"),
        ({"tip_relief": Relief(amount=-1e-6, length=1e-3)}, "tip_relief.amount", "takes material off"),
        ({"tip_relief": Relief(amount=math.inf, length=1e-3)}, "tip_relief.amount", "takes material off"),
        ({"end_relief": Relief(amount=1e-6, length=21e-3)}, "end_relief.length", "does not fit the flank"),
        ({"crown": math.nan}, "crown", "no finite length"),
        ({"crown": 5e-3}, "crown", "more than the height"),
        ({"slope": -5e-3}, "slope", "more than the height"),
        ({"tip_relief": Relief(amount=5e-3, length=1e-3)}, "tip_relief.amount", "more than the height"),
        ({"end_relief": Relief(amount=5e-3, length=1e-3)}, "end_relief.amount", "more than the height"),
        ({"profile": ((0.0, 0.0), (1e-3, -5e-3))}, "profile.missing", "more than the height"),
        ({"waves": (Wave(amplitude=5e-3, order=2, phase=0.0),)}, "wave.amplitude", "more than the height"),
        ({"profile": ((1e-3, 0.0), (0.0, 0.0))}, "profile", "rise"),
        ({"pitch": (0.0, 1e-6)}, "pitch", "one deviation a tooth"),
    ],
)
def test_what_does_not_fit_is_refused(flank: dict[str, Any], path: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as error:
        check_flank(Flank(**flank), height=4e-3, width=40e-3, teeth=21, path="stages.main.sun.flank")
    assert f"stages.main.sun.flank.{path}" in str(error.value)


def test_a_relief_over_the_whole_flank_fits() -> None:
    def check(length: float) -> None:
        check_flank(Flank(tip_relief=Relief(amount=1e-5, length=length)), height=4e-3, width=1e-2, teeth=21)

    check(4e-3)
    with pytest.raises(ModelError, match="does not fit the flank"):
        check(4.001e-3)
