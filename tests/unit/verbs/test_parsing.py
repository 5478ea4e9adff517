"""Texts of a person: frequencies, times, ranges, loads, settings."""

from __future__ import annotations

import re

import pytest

from epicyclic.document.units import Bounds, read_quantity, stated
from epicyclic.errors import ModelError
from epicyclic.options import Option
from epicyclic.verbs.options import READERS, frequency, loads_of, settings, share, spread, torque_step


def seconds(value: float | str, path: str) -> float:
    return float(READERS["time"](value, path, None, Option("", least=0)))  # type: ignore[arg-type]


def load_per_length(value: float | str, path: str) -> float:
    return float(READERS["load_per_length"](value, path, None, Option("", above=0)))  # type: ignore[arg-type]


@pytest.mark.parametrize(("text", "value"), [("20 Hz", 20.0), ("0.6kHz", 600.0), ("2e1 Hz", 20.0)])
def test_frequency(text: str, value: float) -> None:
    assert frequency(text, "start") == pytest.approx(value, rel=1e-15)  # one rounding


@pytest.mark.parametrize(
    "text", ["", "Hz", "-3", "20", "-3 Hz", "0", "nan", "inf", "20 rpm", "1.2.3", "1e400", "twenty"]
)
def test_not_a_frequency(text: str) -> None:
    with pytest.raises(ModelError, match="start"):
        frequency(text, "start")


def test_times_and_steps() -> None:
    assert [seconds(value, "duration") for value in (2.0, "2 s", "20 ms", "1 min", "0 s", "0")] == [
        2.0,
        2.0,
        0.02,
        60.0,
        0.0,
        0.0,
    ]
    assert torque_step("1.5@20 ms") == torque_step((1.5, 0.02)) == (1.5, 0.02)


@pytest.mark.parametrize("text", ["20", "2e1", "-3", " 20 "])
def test_a_number_without_a_unit_is_refused_with_the_likely_one(text: str) -> None:
    number = f"{float(text):g}"
    for read, unit, shown in ((frequency, "Hz", text.strip()), (seconds, "s", number)):
        with pytest.raises(ModelError, match=re.escape(f'start = {text}: a number without a unit: "{shown} {unit}"?')):
            read(text, "start")
    with pytest.raises(ModelError, match=re.escape(f'"{number} s"?')):
        torque_step(f"1.5@{text}")


def test_shares() -> None:
    assert [share(value, "band") for value in (0.2, "0.2", "20 %", " 20% ")] == [0.2] * 4
    for value in ("0", "-1 %", "much", "20 Hz", 0.0, float("nan")):
        with pytest.raises(ModelError, match=r'band.*allowed: above zero, e\.g\. "20 %" or 0\.2'):
            share(value, "band")
    with pytest.raises(ModelError, match="at most 90 %"):
        share("91 %", "near", 0.9)


def test_a_load_per_length() -> None:
    assert [load_per_length(value, "linear_at") for value in (3e5, "300 N/mm", "0.3 kN/mm")] == [3e5, 3e5, 3e5]
    for text in ("300 N", "0 N/m", "-1 N/m", "much"):
        with pytest.raises(ModelError, match=r"linear_at.*load per length \(N/mm, N/m\), > 0"):
            load_per_length(text, "linear_at")
    with pytest.raises(ModelError, match=r'linear_at = 300: a number without a unit: "300 N/mm"\?'):
        load_per_length("300", "linear_at")


@pytest.mark.parametrize(
    ("text", "kind", "likely"), [("100", "torque", "100 N m"), ("20", "angle", "20 deg"), ("400", "length", "400 mm")]
)
def test_a_text_of_an_option_states_its_unit(text: str, kind: str, likely: str) -> None:
    with pytest.raises(ModelError, match=re.escape(f'torque = {text}: a number without a unit: "{likely}"?')):
        stated(text, kind, "torque")
    assert stated(float(text), kind, "torque") == float(text)
    assert stated(likely, kind, "torque") == read_quantity(likely, (kind,), Bounds())
    with pytest.raises(ModelError, match="another kind of quantity"):
        stated(f"{text} kg", kind, "torque")


@pytest.mark.parametrize("step", ["1e300@0.1 s", "-1001@0 s", (1e300, 0.1), (float("nan"), 0.1)])
def test_a_torque_step_beyond_all_machines_is_refused(step: str | tuple[float, float]) -> None:
    with pytest.raises(ModelError, match=r"torque_step.*from -1000 to 1000"):
        torque_step(step)


def test_settings() -> None:
    assert settings(["tip_relief.amount = 0..40 um", "crown=3 um"], "vary") == {
        "tip_relief.amount": "0..40 um",
        "crown": "3 um",
    }
    assert settings({"crown": "3 um"}, "vary") == {"crown": "3 um"}
    for text in ("crown", "=3 um", "crown="):
        with pytest.raises(ModelError, match="vary"):
            settings([text], "vary")
    with pytest.raises(ModelError, match=r"vary = crown=0\.\.5 um: stated twice"):
        settings(["crown=3 um", "crown = 0..5 um"], "vary")


def test_spread() -> None:
    assert spread("0..2", 3) == [0.0, 1.0, 2.0]
    assert spread("1 % .. 5 %", 3) == ["1 %", "3 %", "5 %"]
    assert spread("1..3 kN/mm", 2) == ["1 kN/mm", "3 kN/mm"]
    assert spread(".5e1 N/m..1e1 N/m", 2) == ["5 N/m", "10 N/m"]
    assert spread("1, 2, 5", 9) == [1.0, 2.0, 5.0]
    assert spread("1, 2 um", 9) == ["1 um", "2 um"]
    for text in ("", "much", "1..much", "a..b", "1,,2", ".."):
        with pytest.raises(ModelError, match="values"):
            spread(text, 3)


def test_loads_are_ranges_or_lists() -> None:
    assert loads_of("0..1", 3, 7) == (0.0, 0.5, 1.0)
    assert loads_of("0..1", None, 2) == (0.0, 1.0)
    assert loads_of("0.5, 2", None, 7) == (0.5, 2.0)
    assert loads_of(None, None, 7) is None
    for text in ("-1..1", "a", "1 kN", "1, 1e300"):
        with pytest.raises(ModelError, match="loads"):
            loads_of(text, None, 7)


@pytest.mark.parametrize("loads", [None, "0.5, 2", (0.5, 2.0)])
def test_a_number_of_loads_without_a_range_is_refused(loads: object) -> None:
    with pytest.raises(ModelError, match="load_points = 3: is the number of loads in a range"):
        loads_of(loads, 3, 7)  # type: ignore[arg-type]
