"""Units of format 2: what the reader takes and what the JSON Schema takes is the same, and pint agrees."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from itertools import islice, product
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from epicyclic.document.units import (
    COMMON,
    KINDS,
    Bounds,
    factor,
    is_unit_of,
    list_pattern,
    number_pattern,
    read_quantity,
)
from epicyclic.document.writer import json_schema
from epicyclic.errors import ModelError

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import sre_parse  # the parsed form of a regular expression, to write out what it matches

SCHEMA = json_schema()["$defs"]


def spellings(pattern: str) -> Iterator[str]:
    """Every text a pattern matches, a repetition without end taken as often as it must be."""
    return written_out([*sre_parse.parse(pattern)])  # type: ignore[misc]


def written_out(parts: Any) -> Iterator[str]:
    if not parts:
        yield ""
        return
    (name, value), *rest = parts
    for text, tail in product(forms(str(name), value), list(written_out(rest))):
        yield text + tail


def forms(name: str, value: Any) -> list[str]:
    if name == "LITERAL":
        return [chr(value)]
    if name == "IN":
        return [chr(code) for _, code in value]
    if name == "BRANCH":
        return [text for branch in value[1] for text in written_out(list(branch))]
    if name == "SUBPATTERN":
        return list(written_out(list(value[3])))
    assert name == "MAX_REPEAT", name
    least, most, inner = value
    once = list(written_out(list(inner)))
    return (["", *once] if least == 0 and most == 1 else [""] if least == 0 else once) if least < 2 else []


def several(kind: str) -> list[str]:
    """At most 200 of the spellings of a kind, from all over them."""
    every = list(islice(spellings(KINDS[kind].pattern), 50_000))
    return every[:: max(len(every) // 200, 1)]


def accepted(text: str, kind: str, *, many: bool = False, inf: bool = False, large: bool = True) -> bool:
    """Whether a text is read; large : too, where a number is beyond what may be."""
    try:
        read_quantity(text, (kind,), Bounds(inf=inf), many=many, listed=True)
    except ModelError as error:
        return large and error.problem in ("out of range", "too large")  # the size is no matter of the pattern
    return True


def fits(text: str, name: str) -> bool:
    return re.search(SCHEMA[name]["pattern"], text) is not None


@pytest.mark.parametrize("kind", [kind for kind in KINDS if KINDS[kind].pattern])
def test_every_unit_of_a_pattern_has_that_dimension(kind: str) -> None:
    for unit in several(kind):
        assert is_unit_of(unit, kind)
        assert factor(unit, KINDS[kind].unit) is not None, unit
        assert accepted(f"2 {unit}", kind), unit
        assert re.search(number_pattern(kind, inf=False), f"2 {unit}"), unit


def test_every_unit_of_the_table_stands_in_a_pattern() -> None:
    for unit, (_, base) in COMMON.items():
        kinds = [kind for kind in KINDS if KINDS[kind].unit == base]
        assert any(is_unit_of(unit, kind) for kind in kinds), unit
    for kind, entry in KINDS.items():
        assert all(is_unit_of(unit.strip(), kind) for unit in entry.spellings.split(",") if unit)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if KINDS[kind].unit])
def test_a_unit_of_another_dimension_fits_neither(kind: str) -> None:
    for other in KINDS:
        for unit in several(other)[::7] if KINDS[other].pattern else ():
            same = KINDS[other].unit == KINDS[kind].unit or is_unit_of(unit, kind)
            assert accepted(f"2 {unit}", kind) == is_unit_of(unit, kind), (kind, unit)
            assert (re.search(number_pattern(kind, inf=False), f"2 {unit}") is not None) <= same
    assert not accepted("2", kind)
    assert not re.search(number_pattern(kind, inf=True), "2")


TEXTS = [
    *("4 mm", "4mm", " 4  mm ", "4 mm\n", "4\u00a0mm", "-3e-2 m", ".5 um", "5. um", "0", "0.0", "+0", "-.0e5", "0 mm"),
    *("4", "4e3", "mm", "", "4 kg", "4 mm mm", "4 m^2", "4 N/m", "nan mm", "1_0 mm", "٤ mm", "4 mm # note", "0x4 mm"),
    *("inf", "+inf", "inf m", "-inf", "1 Inf", "4 MM", "4 Mm", "4 in", '4 "', "1,5 mm", "4 mm 5"),
    *("[1, 2] mm", "[1 mm, 2 um]", "[0, 0]", "[0, 2 mm]", "[1, 2]", "[] mm", "[1,] mm", "[1, 2 mm] mm", "[[1]] mm"),
    *("[1, 2", "1, 2 mm", "[ 1 ,2 ]mm", "[inf, 1] mm", "[inf, 1 mm]", "[1, 2] kg"),
]


@pytest.mark.parametrize("text", TEXTS)
def test_reader_and_schema_say_the_same(text: str) -> None:
    for inf in (False, True):
        one = re.search(number_pattern("length", inf=inf), text) is not None
        many = re.search(list_pattern("length", inf=inf), text) is not None
        read = accepted(text, "length", many=True, inf=inf)
        bare = "mm" not in text and re.search(r"[1-9]", text) is not None  # read, but refused by the rule of units
        assert (one or many) == (read and not (bare and "[" in text)), (text, inf)


@settings(deadline=None)  # pint is imported by the first
@example("1e311")
@example(".e0")
@example("1e311A")
@example("[600e3, 0mm]°")
@given(st.from_regex(r"\[? ?-?[0-9.]{1,3}(e[0-9])?(, [0-9] ?(mm|um)?)?\]? ?[a-zA-Zµ°%/^*() 1-4]{0,8}", fullmatch=True))
def test_what_is_read_fits_the_schema(text: str) -> None:
    from epicyclic.document.units import bare_in

    for kind in ("length", "force", "stiffness", "angle", "speed"):
        # what stands behind a number that is too large has not been read
        if accepted(text, kind, many=True, large=False) and not bare_in(text, (kind,)):
            assert (
                fits(text, kind)
                if kind in SCHEMA and "[" not in text
                else re.search(list_pattern(kind, inf=False) if "[" in text else number_pattern(kind, inf=False), text)
            )


def test_the_schema_uses_the_patterns() -> None:
    assert fits("10 mm", "length")
    assert not fits("10 kg", "length")
    assert not fits("10", "length")
    module = SCHEMA["Stage"]["properties"]["module"]
    assert module["$ref"] == "#/$defs/length"
    support = SCHEMA["Support"]["properties"]["x"]["anyOf"]
    assert {"$ref": "#/$defs/stiffness_or_inf"} in support
    assert {"enum": [0]} in support
    assert {"type": "number"} not in support
    ratio = SCHEMA["Member"]["properties"]["profile_shift"]["anyOf"]
    assert {"type": "number"} in ratio


@pytest.mark.parametrize("unit", ["kg/s^2", "J", "N.m", "yd", "furlong", "m m", "N m rad", "1/m", "Hz"])
def test_units_beside_the_patterns_are_refused(unit: str) -> None:
    for kind in set(KINDS) - ({"frequency"} if unit == "Hz" else set()):
        assert not is_unit_of(unit, kind)
    import epicyclic.document.document as document

    data: dict[str, Any] = {"title": "x", "stages": {"main": {"module": "1 yd", "sun": {"teeth": 30}}}}
    with pytest.raises(ModelError, match="unit not known"):
        document.read({"format": 2, **data})
