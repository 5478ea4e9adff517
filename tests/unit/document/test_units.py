"""Numbers with units: the table against pint, forms, ranges, and what is refused."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from epicyclic import load
from epicyclic.document.units import COMMON, KINDS, Bounds, Quantity, factor, read_quantity
from epicyclic.errors import ModelError

ANY = Bounds()


def one(value: object, kind: str, bounds: Bounds = ANY) -> object:
    return read_quantity(value, tuple(kind.split()), bounds)


@pytest.mark.parametrize("unit", sorted(COMMON))
def test_table_equals_pint(unit: str) -> None:
    scale, target = COMMON[unit]
    # one rounding of pint's own factor
    assert factor(unit, target) == pytest.approx(scale, rel=4e-16)


@pytest.mark.parametrize(("name", "kind"), KINDS.items())
def test_every_spelling_proposed_is_understood(name: str, kind: object) -> None:
    for spelling in (s.strip() for s in KINDS[name].spellings.split(",") if s):
        assert isinstance(one(f"2 {spelling}", name), float), spelling


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("20 um", "length", 2e-5),
        ("32mm", "length", 0.032),
        ("0.3 m", "length", 0.3),
        ("20 N/(mm um)", "stiffness_per_width", 2e10),
        ("12.5 GN/m^2", "stiffness_per_width", 1.25e10),
        ("100 kN m", "torque", 1e5),
        ("100 kN*m", "torque", 1e5),
        ("-150 kN·m", "torque", -1.5e5),
        ("60 rpm", "speed", 2 * math.pi),
        ("2 rev/s", "speed", 4 * math.pi),
        ("180 deg", "angle", math.pi),
        ("20 MW", "power", 2e7),
        ("663 kg m²", "inertia", 663.0),
        ("1e-3 kg m^2", "inertia", 1e-3),
        (".5 ms", "time", 5e-4),
        ("5 1/s", "rate", 5.0),
        (0.25, "ratio", 0.25),
        ("0.25", "ratio", 0.25),
        (3, "length", 3.0),
    ],
)
def test_value_in_si(text: object, kind: str, value: float) -> None:
    # two roundings: the number's and the factor's
    assert one(text, kind) == pytest.approx(value, rel=5e-16)


@given(st.floats(1e-3, 1e3), st.sampled_from(["um", "mm", "m"]))
def test_prefix_is_rounded_once(number: float, unit: str) -> None:
    exponent = {"um": "e-06", "mm": "e-03", "m": ""}[unit]
    text = f"{number:.6f}"
    assert one(f"{text} {unit}", "length") == float(text + exponent)


def test_unit_says_which_kind() -> None:
    assert one("663 kg", "inertia mass") == Quantity(value=663.0, unit="kg")
    assert one("2 t m^2", "inertia mass") == Quantity(value=2000.0, unit="kg m^2")
    assert one(5, "inertia mass") == Quantity(value=5.0, unit="kg m^2")
    assert one("1e10 N/m", "torsional_stiffness stiffness") == Quantity(value=1e10, unit="N/m")
    assert one("1 kN m", "torsional_stiffness stiffness") == Quantity(value=1e3, unit="N m/rad")


@pytest.mark.parametrize("value", ["[1, 2.5, -3] mm", ["1 mm", "2500 um", "-0.003 m"], [0.001, 0.0025, -0.003]])
def test_list(value: object) -> None:
    assert read_quantity(value, ("length",), ANY, many=True) == (0.001, 0.0025, -0.003)


def test_list_without_unit_is_si() -> None:
    assert read_quantity("[1, 2]", ("length",), ANY, many=True) == (1.0, 2.0)


def test_infinity_where_it_may_stand() -> None:
    for value in ("inf", math.inf, "inf N/m"):
        assert one(value, "stiffness", Bounds(low=0, inf=True)) == math.inf
        with pytest.raises(ModelError, match="finite"):
            one(value, "stiffness", Bounds(low=0))
    with pytest.raises(ModelError, match="finite"):
        one("-inf", "stiffness", Bounds(inf=True))


def test_words() -> None:
    assert read_quantity("balance", ("torque",), ANY, words=("balance",)) == "balance"


@pytest.mark.parametrize(
    ("value", "kind", "problem"),
    [
        ("3 Hz", "speed", "revolutions or radians"),
        ("3 kHz", "speed", "revolutions or radians"),
        ("3 1/s", "speed", "revolutions or radians"),
        ("abc", "length", "not a number with a unit"),
        ("", "length", "not a number with a unit"),
        ("nan m", "length", "not a number with a unit"),
        (float("nan"), "length", "not a number"),
        ("3", "length", "without a unit"),
        ("3 kg", "length", "another kind"),
        ("7.2 kNm", "torque", "did you mean 'kN m'"),
        ("750 KW", "power", "did you mean 'kW'"),
        ("750 PS", "power", "another kind of quantity; allowed"),
        ("1,5 mm", "length", "a comma"),
        ("1 500 mm", "length", "a space within the number"),
        ("1'500 mm", "length", "an apostrophe"),
        ("-0,5", "ratio", "a comma"),
        ("3 furlongz", "length", "another kind"),
        ("3 degC", "angle", "another kind"),
        ("3 %", "angle", "another kind"),
        ("3 deg", "ratio", "another kind"),
        ("20 N m/rad", "torque", "another kind"),
        ("3 m^99999999", "length", "another kind"),
        ("3 m**9**9**9**9", "length", "another kind"),
        ("3 __import__('os')", "length", "another kind"),
        ("3 " + "m" * 300, "length", "not a number"),
        ("1e999 m", "length", "too large"),
        (10**400, "length", "too large"),
        (1e300, "length", "out of range"),
        (True, "length", "true or false"),
        ([1, 2], "length", "a list where one number stands"),
        ("[1, 2] mm", "length", "a list where one number stands"),
        ({"a": 1}, "length", "a table"),
        (None, "length", "NoneType"),
    ],
)
def test_refused(value: object, kind: str, problem: str) -> None:
    with pytest.raises(ModelError, match=problem) as error:
        one(value, kind)
    assert KINDS[kind].name in str(error.value)


@pytest.mark.parametrize("value", [[], "[] mm", ["1 mm", "1 kg"], ["1 mm", True], [[1], [2]], "[1, 2"])
def test_refused_list(value: object) -> None:
    with pytest.raises(ModelError, match="length"):
        read_quantity(value, ("length",), ANY, many=True)


def test_refused_mixture() -> None:
    with pytest.raises(ModelError, match="mixes"):
        read_quantity(["1 kg", "1 kg m^2"], ("inertia", "mass"), ANY, many=True)


@pytest.mark.parametrize(
    ("value", "bounds"), [(0, Bounds(low=0, above=True)), (-1, Bounds(low=0)), (2, Bounds(high=1))]
)
def test_bounds(value: float, bounds: Bounds) -> None:
    with pytest.raises(ModelError, match="out of range"):
        one(value, "length", bounds)


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    for kind in ("length", "speed", "ratio"):
        try:
            value = one(text, kind)
        except ModelError:
            continue
        assert isinstance(value, float)
        assert math.isfinite(value)


def test_common_units_need_no_pint() -> None:
    code = "import sys; from epicyclic.document.document import read; read('ren2021'); assert 'pint' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("text", ["5 kg", "5 kg m^2", "5 kg mm^2", "5 t"])
def test_common_units_of_a_second_kind_need_no_pint(text: str) -> None:
    code = (
        "import sys; from epicyclic.document.units import Bounds, read_quantity; "
        f"[read_quantity({text!r}, kinds, Bounds()) for kinds in (('inertia', 'mass'), ('mass', 'inertia'))]; "
        "assert 'pint' not in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("path", ["planet.bearing.radial", "sun.support.radial", "face_width"])
def test_a_number_too_small_for_double_precision_is_refused(path: str) -> None:
    with pytest.raises(ModelError, match="out of range, 0 is written as 0"):
        load("wind-stage", {f"stages.main.{path}": 1e-200})


def test_a_text_that_is_no_unit_is_refused_in_time() -> None:
    """No pattern tries a text again and again: 2^50 ways to cut it, or its third power."""
    with pytest.raises(ModelError):
        read_quantity("1 " + "a" * 50 + "!", ("length",), Bounds())
    with pytest.raises(ModelError):
        read_quantity("[1]" + " " * 20_000 + "[", ("length",), Bounds(), many=True)
