"""Unit texts of REXS files: every spelling against pint, and the errors."""

from __future__ import annotations

import math
import re
from typing import Any

import pint
import pytest

from epicyclic.document.units import Bounds, is_unit_of, read_quantity
from epicyclic.errors import ModelError
from epicyclic.rexs.file import _SI, _UNITS, Attribute, Component, Number, number_of


def number(value: object, unit: str, kind: str) -> Number | None:
    attributes = {"x": Attribute("x", value, unit)}  # type: ignore[arg-type]
    return number_of(Component(7, "shaft", "", attributes), "x", kind)


@pytest.mark.parametrize(
    ("unit", "kind", "si"),
    [
        ("mm", "length", 1e-3),
        ("mum", "length", 1e-6),
        ("\u00b5m", "length", 1e-6),  # micro sign
        ("\u03bcm", "length", 1e-6),  # Greek mu
        ("\u00b0", "angle", math.pi / 180),
        ("deg", "angle", math.pi / 180),
        ("1 / min", "speed", 2 * math.pi / 60),
        ("1/min", "speed", 2 * math.pi / 60),
        ("1 / s", "speed", 2 * math.pi),  # revolutions: "rotations per second" of the standard
        ("rad / s", "speed", 1.0),
        ("N m", "torque", 1.0),
        ("N mm / rad", "torsional_stiffness", 1e-3),
        ("N / m", "stiffness", 1.0),
        ("N / (mm mum)", "stiffness_per_width", 1e9),
        ("N/(mm \u00b5m)", "stiffness_per_width", 1e9),
        ("kg / dm^3", "density", 1e3),
        ("kg/dm\u00b3", "density", 1e3),
        ("N / mm^2", "pressure", 1e6),
        ("kW", "power", 1e3),
        ("kg m^2", "inertia", 1.0),
        ("none", "ratio", 1.0),
        ("%", "ratio", 0.01),
        ("", "ratio", 1.0),
    ],
)
def test_units_of_the_standard(unit: str, kind: str, si: float) -> None:
    read = number(1.0, unit, kind)
    assert read is not None
    assert read.si == pytest.approx(si, rel=1e-15)


# spelled for pint: blanks between units that the table, which has none, writes together
_PINT = {
    "Nm": "N m", "Nmm": "N mm", "kNm": "kN m", "MNm": "MN m", "kNmm": "kN mm", "Ncm": "N cm", "mum": "um",
    "N/mum": "N/um", "kN/mum": "kN/um", "N/(mmmum)": "N/(mm um)", "N/(mmum)": "N/(mm um)", "N/mm/mum": "N/mm/um",
    "N/(mummm)": "N/(um mm)", "N/(mumm)": "N/(um m)", "N/(mmm)": "N/(m mm)", "Nmm/rad": "N mm/rad",
    "Nm/rad": "N m/rad", "kNm/rad": "kN m/rad", "MNm/rad": "MN m/rad", "Nm/deg": "N m/deg", "Nmm/deg": "N mm/deg",
    "Nmm/mrad": "N mm/mrad", "Nm/mrad": "N m/mrad", "kgm^2": "kg m^2", "kgmm^2": "kg mm^2", "gmm^2": "g mm^2",
    "tm^2": "t m^2", "PS": "metric_horsepower",
}  # fmt: skip
_KNOWN = ("\u00b0", "\u00ba", "Grad", "min^-1", "min-1", "U/min", "1/Min", "s^-1", "U/s", "none", "-", "1", "")
_REVOLUTIONS = ("1/min", "1/s", "Hz")


def test_every_factor_is_that_of_pint() -> None:
    registry: Any = pint.UnitRegistry()
    registry.define("@alias revolution = rev")
    compared = 0
    for kind, units in _UNITS.items():
        for unit, (factor, _) in units.items():
            if unit in _KNOWN or "\u00b0" in unit or (unit in ("Nm", "Nmm", "kNmm") and kind == "torsional_stiffness"):
                continue
            text = unit.replace("1/", "rev/").replace("Hz", "rev/s") if unit in _REVOLUTIONS else _PINT.get(unit, unit)
            text = re.sub(r"\bU/", "rev/", text)
            target = _SI[kind] or "dimensionless"
            expected = registry.Quantity(1.0, registry.parse_units(text)).to(target).magnitude
            assert factor == pytest.approx(expected, rel=1e-12), (kind, unit)
            compared += 1
    assert compared > 80


def test_the_text_is_one_of_a_model_file_with_the_same_value() -> None:
    for kind, units in _UNITS.items():
        if kind == "ratio":
            continue
        for unit, (factor, text) in units.items():
            read = number(0.00025, unit, kind)
            assert read is not None
            spelled = read.text.partition(" ")[2]
            assert is_unit_of(spelled, kind), (kind, unit, text)
            value = read_quantity(read.text, (kind,), Bounds(), listed=True)
            assert value == pytest.approx(0.00025 * factor, rel=1e-14), (kind, unit)


@pytest.mark.parametrize(
    ("value", "unit", "kind", "says"),
    [
        (1.0, "furlong", "length", "unit not known"),
        (1.0, "N m", "length", "unit not known"),
        (1.0, "none", "length", "unit not known"),
        ("wide", "mm", "length", "not a number"),
        (True, "mm", "length", "not a number"),
        ((1.0, 2.0), "mm", "length", "not a number"),
        ("nan", "mm", "length", "not a number"),
        (1e300, "mm", "length", "out of range"),
        (10**200, "mm", "length", "out of range"),
    ],
)
def test_wrong_values_name_component_and_attribute(value: object, unit: str, kind: str, says: str) -> None:
    with pytest.raises(ModelError, match=says) as caught:
        number(value, unit, kind)
    assert caught.value.path == "component 7 (shaft), x"


@pytest.mark.parametrize(
    ("value", "text"), [(4.0, "4 mm"), (-0.0, "0 mm"), (0.25, "0.25 mm"), (4.1e8, "4.1e8 mm"), (1500, "1500 mm")]
)
def test_numbers_are_written_short(value: float, text: str) -> None:
    read = number(value, "mm", "length")
    assert read is not None
    assert read.text == text


def test_a_missing_or_empty_value_is_none() -> None:
    assert number(None, "mm", "length") is None
    assert number_of(Component(7, "shaft"), "x", "length") is None


def test_negative_and_magnitude() -> None:
    read = number(-15.0, "deg", "angle")
    assert read is not None
    assert (-read).text == abs(read).text == "15 deg"
    opposite = -read
    assert -opposite == read
