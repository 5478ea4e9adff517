"""What a terminal shows: words whole at every width, long tables cut, `check` on one screen, warnings as a list."""

from __future__ import annotations

import io
import re
from functools import cache

import numpy as np
import pytest
import xarray as xr
from rich.console import Console
from tests.unit.example_results import PLACES, example_result

import epicyclic
from epicyclic.document.document import drive_titles
from epicyclic.show.brief_check import phasing
from epicyclic.show.console import laid_out, show, show_table, show_warnings, wrapped
from epicyclic.show.elements import Styled, Table, number, shown_columns
from epicyclic.show.views import brief_of, tables_of

pytestmark = pytest.mark.usefixtures("few_turning_trains")

DRIVES = ("encased-differential", "dong2019", "xu2020")
QUICK = ("check", "modes", "campbell", "static", "stiffness", "sharing", "efficiency")
# verbs whose examples take seconds; their tables are drawn from made-up results where there are such
SLOW = ("allocate", "tolerance", "transient")
WIDTHS = (80, 100, 160)
# a number and its unit, as no line may part them
UNIT = re.compile(r"\d (?:N m|N|kN|mm|µm|um|Hz|rpm|deg|%|kW|N/mm|N/m|kg|s)(?=[\s,;.)]|$)")


@cache
def result_of(drive: str, verb: str) -> xr.Dataset:
    found: xr.Dataset = getattr(epicyclic, verb)(drive)
    return found


def drawn(table: Table, width: int, *, terminal: bool = True, whole: bool = True) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=width, force_terminal=terminal, color_system=None, highlight=False)
    show_table(table, console, whole=whole)
    return stream.getvalue()


def pieces_of(table: Table) -> set[str]:
    """Words of every heading and cell, units in brackets, and numbers with their units."""
    found: set[str] = set()
    for heading, numeric, cells in shown_columns(table, number):
        texts = [text for text, _ in cells]
        found |= set(re.findall(r"\[[^\[\]]+\]", heading))
        found |= set(re.sub(r"\[[^\[\]]+\]", " ", heading).split())
        for text in texts:
            found |= {text} if numeric or len(text) <= 30 else set(text.split()) | set(UNIT.findall(text))
    return found


def assert_whole(table: Table, width: int) -> None:
    text = drawn(table, width)
    lines = [line.rstrip() for line in text.splitlines()]
    assert all(len(line) <= width for line in lines), max(lines, key=len)
    broken = {piece for piece in pieces_of(table) if piece not in "\n".join(lines)}
    assert not broken, (table.title, broken)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("drive", DRIVES)
def test_no_word_is_broken(drive: str, width: int) -> None:
    for verb in QUICK:
        result = result_of(drive, verb)
        for table in (*tables_of(result), *brief_of(result)):
            assert_whole(table, width)


@pytest.mark.parametrize(("verb", "place"), [one for one in PLACES if one[0] not in SLOW])
def test_no_word_of_any_verb_is_broken(verb: str, place: int) -> None:
    if verb == "relief":
        pytest.importorskip("pymoo")
    for table in tables_of(example_result(verb, place)):
        for width in WIDTHS:
            assert_whole(table, width)


@pytest.mark.parametrize("kind", ["allocate", "tolerance"])
def test_no_word_of_a_slow_verb_is_broken(ren: dict[str, xr.Dataset], kind: str) -> None:
    for table in tables_of(ren[kind]):
        for width in WIDTHS:
            assert_whole(table, width)


def test_wide_tables_repeat_the_names_of_their_rows() -> None:
    names = [f"main/planet-ring/{branch}" for branch in range(1, 4)]
    columns = {"mesh": names} | {f"quantity {place} [N]": [1.0, 2.0, 3.0] for place in range(12)}
    found = laid_out(Table(title="wide", columns=columns), 60)
    assert len(found.parts) > 1
    for part in found.parts:
        assert [lines[0] for lines, _ in part[0].cells] == names
    headings = [" ".join(one.heading) for part in found.parts for one in part[1:]]
    assert headings == [name for name in columns if name != "mesh"]
    assert found.more == []


def test_rows_that_no_name_tells_apart_are_counted() -> None:
    columns = {"what": ["a", "a"]} | {f"long heading {place} [N]": [1.0, 1.0] for place in range(12)}
    first = [part[0] for part in laid_out(Table(title="", columns=columns), 60).parts]
    assert all(one.heading == ["row"] for one in first)
    assert all([lines for lines, _ in one.cells] == [["1"], ["2"]] for one in first)


def test_far_too_wide_tables_say_what_they_leave_out() -> None:
    columns = {"mesh": ["a", "b"]} | {f"number{place}_of_many": [1.0, 2.0] for place in range(40)}
    found = laid_out(Table(title="", columns=columns), 60)
    (said,) = found.more
    shown = sum(len(part) - 1 for part in found.parts)
    assert said.startswith(f"... {40 - shown} more columns (number{shown}_of_many, ")
    assert said.endswith(": --json or -o file.csv")


def test_long_tables_keep_the_head_the_largest_and_what_is_bad() -> None:
    force = np.arange(200.0) % 7
    force[150] = 99.0
    verdict = [Styled(text="bad", tone="bad") if row == 120 else "good" for row in range(200)]
    table = Table(title="", columns={"n": [f"r{row}" for row in range(200)], "force": list(force), "is": verdict})
    cells = [lines[0] for lines, _ in laid_out(table, 100).parts[0][0].cells]
    assert cells == [f"r{row}" for row in (*range(30), 120, 150)]
    assert f"... {200 - len(cells)} more: --json or -o file.csv" in drawn(table, 100, whole=False)
    # a pipe has every row, as --all has
    for text in (drawn(table, 100, terminal=False, whole=False), drawn(table, 100)):
        assert "r199" in text
        assert "more:" not in text
    short = Table(title="", columns={"n": [f"r{row}" for row in range(60)]})
    assert "more" not in drawn(short, 100, whole=False)


@pytest.mark.parametrize("drive", drive_titles())
def test_check_is_one_screen(drive: str) -> None:
    stream = io.StringIO()
    show(result_of(drive, "check"), Console(file=stream, width=100, force_terminal=True, color_system=None))
    lines = stream.getvalue().splitlines()
    # a train of several shafts has the table of its couplings more
    assert len(lines) <= (61 if any("Couplings" in line for line in lines) else 45)
    assert max(map(len, lines)) <= 100


def test_check_says_the_ratio_in_both_senses() -> None:
    assert "Ratio main.sun to main.carrier 3.47826 (" in printed("ren2021")  # 1 + 57/23
    assert "Ratio main.carrier to main.sun 1 : 3.87097 (" in printed("wind-five")  # 1 + 89/31
    assert "CANNOT be assembled" in printed("ren2021")
    assert "5 branches, equally spaced: can be assembled" in printed("wind-five")


def printed(drive: str) -> str:
    stream = io.StringIO()
    show(result_of(drive, "check"), Console(file=stream, width=160))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("leads", "words"),
    [
        ([0.25], ""),
        ([0.25, 0.25, 0.25], "together"),
        ([0, 1 / 3, 2 / 3], "in turn, 1/3 cycle earlier"),
        ([0.5, 1 / 6, 5 / 6], "in turn, 1/3 cycle later"),
        ([0, 0.5, 0, 0.5], "in opposite pairs"),
        ([0, 0.5], "in opposite pairs"),
        ([0, 0.1, 0.3], "0, 1/10, 3/10 cycle ahead"),
        ([0, float("nan")], ""),
    ],
)
def test_phasing_in_words(leads: list[float], words: str) -> None:
    assert phasing(leads) == words


def test_warnings_are_a_list() -> None:
    said = ["main/sun: " + "a word and another " * 8 + "[contact-lost]", "short [contact-lost]"]
    stream = io.StringIO()
    show_warnings(said, Console(file=stream, width=60, force_terminal=True, color_system=None))
    first, *lines = stream.getvalue().splitlines()
    assert first == "2 warnings:"
    assert [line for line in lines if line.startswith("  - ")] == [lines[0], "  - short [contact-lost]"]
    assert all(line.startswith("    ") for line in lines[1:-1])
    assert all(len(line) <= 60 for line in lines)
    pipe = io.StringIO()
    show_warnings(said, Console(file=pipe, width=60))
    assert pipe.getvalue().splitlines() == ["2 warnings:", *(f"  - {text}" for text in said)]
    colour = io.StringIO()
    show_warnings(said[1:], Console(file=colour, width=60, force_terminal=True, color_system="standard"))
    assert "\x1b[2m[contact-lost]" in colour.getvalue()
    assert "1 warning:" in colour.getvalue()


def test_a_result_without_warnings_has_no_list() -> None:
    stream = io.StringIO()
    show(xr.Dataset({"x": ("n", np.zeros(1))}), Console(file=stream, width=80))
    assert "warning" not in stream.getvalue()


@pytest.mark.parametrize("width", range(12, 60))
def test_prose_keeps_numbers_at_their_units(width: int) -> None:
    text = "the tips reach 0.252 mm below 12 N m and 3.5 kN, 20 % of 10 N/(mm um) at 50 rpm [1e6 N/m] here"
    lines = wrapped(text, width, first="- ", later="  ")
    assert " ".join(line[2:] for line in lines) == text
    for whole in ("0.252 mm", "12 N m", "3.5 kN", "20 %", "50 rpm", "[1e6 N/m]"):
        assert any(whole in line for line in lines)
