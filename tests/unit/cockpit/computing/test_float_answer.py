"""What a floating sun changes: both K_gamma with their signs and the resonance, as the command line says them."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from epicyclic.cli.main import app
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.state.frames import Request, number
from epicyclic.document.document import drive_text

RADIAL = "stages.main.sun.support.radial"
FLOAT = f"{RADIAL}=0"


def answer_of(drive: str, kind: Literal["live", "full"], changes: Mapping[str, object] | None = None) -> dict[str, Any]:
    """The last answer on the floating sun of a state."""
    *_, last = compute(Request(rev=1, kind=kind, source=tomllib.loads(drive_text(drive)), overrides=changes or {}))
    return next(answer for answer in last.head["answers"] if answer["key"] == "float")


@lru_cache
def told(*words: str) -> xr.Dataset:
    """What a command prints with --json."""
    ran = CliRunner().invoke(app, [*words, "--json"])
    assert ran.exit_code == 0, ran.output
    return xr.Dataset.from_dict(json.loads(ran.stdout))


def k_gammas(drive: str, *options: str) -> list[float]:
    """K_gamma in the mean and while turning, from the command line."""
    shares = told("sharing", drive, "--method", "static", *options)["load_sharing"]
    return [float(shares.sel(definition=name).max()) for name in ("mean-load", "mean-load-turning")]


def changed(name: str, now: float, then: float) -> str:
    digits = 4 if max(now, then) < 1.01 else 3
    return f"{name} K_gamma {'rises' if then > now else 'falls'} from {now:.{digits}f} to {then:.{digits}f}"


@pytest.mark.parametrize("drive", ["wind-stage", "ren2021"])
def test_both_k_gamma_are_told_with_their_signs_as_the_command_line_gives_them(drive: str) -> None:
    text = answer_of(drive, "live")["text"]
    change = ", ".join(map(changed, ("mean-load", "turning"), k_gammas(drive), k_gammas(drive, "--set", FLOAT)))
    assert text.startswith(f"With a floating sun: {change}. Nothing to do as drawn: K_gamma ")


def test_the_wind_stage_is_told_that_its_turning_k_gamma_rises() -> None:
    answer = answer_of("wind-stage", "live")
    assert (answer["figure"], answer["then"]) == ("1.0018", "1.0000")
    change = "mean-load K_gamma falls from 1.0018 to 1.0000, turning K_gamma rises from 1.0048 to 1.0084"
    assert answer["text"].startswith(f"With a floating sun: {change}. ")


def strongest(drive: str, *options: str) -> tuple[str, str]:
    """Order, and speed and distance, of the strongest resonance, from the command line."""
    result = told("modes", drive, "--band", "0.2", *options)
    place = int(np.nan_to_num(result["resonance_force_ratio"].values, nan=-1.0).argmax())
    speed = float(result["resonance_speed"][place])
    rpm = {"ren2021": 100.0, "wind-stage": 15.0, "xu2020": 17.3}[drive] * speed
    away = f"{100 * abs(speed - 1):.{0 if abs(speed - 1) >= 0.1 else 1}f} %"
    at = f"{number(rpm, 4)} rpm, {'−' if speed < 1 else '+'}{away}"
    order = int(result["resonance_order"][place])
    return f"{order}th order" if order > 3 else f"{order}{'st nd rd'.split()[order - 1]} order", at


@pytest.mark.parametrize(
    ("drive", "said"),
    [
        ("wind-stage", "Resonance, {order}: {now} → {then}."),
        ("ren2021", "A new resonance within 20 %: {order}, {then}; the mode's force is "),
    ],
)
def test_what_becomes_of_the_resonance_is_told_as_the_command_line_tells_it(drive: str, said: str) -> None:
    answer = answer_of(drive, "full")
    _, now = strongest(drive)
    order, then = strongest(drive, "--set", FLOAT)
    assert said.format(now=now, order=order, then=then) in answer["text"]
    assert "esonance" not in answer_of(drive, "live")["text"]  # its modes cost more than a lever may wait


def test_without_deviations_the_resonance_is_told_alone() -> None:
    text = answer_of("xu2020", "full")["text"]
    assert text.startswith("Nothing yet in load sharing: without deviations the planets share equally")
    assert re.search(
        r"A new resonance within 20 %: 3rd order, 19\.03 rpm, \+10\.0 %; the mode's force is 0\.35 %", text
    )


def test_a_sun_that_floats_is_told_what_a_rigid_support_changes() -> None:
    text = answer_of("wind-stage", "full", {RADIAL: 0})["text"]
    before, after = k_gammas("wind-stage", "--set", FLOAT), k_gammas("wind-stage", "--set", f"{RADIAL}=inf")
    change = ", ".join(map(changed, ("mean-load", "turning"), before, after))
    assert text.startswith(f"The sun floats already. With a rigid support: {change}. ")
    order, then = strongest("wind-stage", "--set", f"{RADIAL}=inf")
    assert f"resonance within 20 %: {order}, {then}; the mode's force is " in text


def test_no_resonance_either_way_is_an_answer() -> None:
    assert (
        answer_of("dong2019", "full")["text"]
        .partition(" Nothing to do")[0]
        .endswith("No resonance within 20 % either way.")
    )
