"""Views: found by the kind of a result, one source of tables and key figures for terminal and report."""

from __future__ import annotations

import io
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

import epicyclic
from epicyclic.audits.views import tally
from epicyclic.show import charts, drawing, views
from epicyclic.show.console import show
from epicyclic.show.elements import Section, Styled, Table, number, shown_columns
from epicyclic.show.report import html_table, report
from epicyclic.show.views import (
    GENERAL,
    ResultView,
    brief_of,
    findings_of,
    front_of,
    has_view,
    key_figures_of,
    kind_of,
    sections_of,
    tables_of,
    view_of,
)

FIGURES = [path for room in (charts, drawing) for path in sorted(Path(room.__path__[0]).glob("[a-z]*.py"))]
DRAWS = r"^def ([a-z]\w*)\([^)]*\) -> go\.Figure:"
PACKAGE = Path(epicyclic.__file__).parent
HOMES = sorted(path for path in PACKAGE.rglob("views.py") if path.parent.name != "show")
VIEWS = [
    view
    for path in HOMES
    for view in import_module(".".join(("epicyclic", *path.relative_to(PACKAGE).parts))[:-3]).VIEWS
]
MANY = xr.Dataset({"mesh_force_rms": ("point", [1.0, 2.0])}, {"point": [1.0, 2.0]}, {"verb": "never_seen"})


def printed(result: xr.Dataset, *, whole: bool = False) -> str:
    stream = io.StringIO()
    show(result, Console(file=stream, width=200), whole=whole)
    return stream.getvalue()


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("home", "name"), [(path, name) for path in FIGURES for name in re.findall(DRAWS, read(path), re.MULTILINE)]
)
def test_every_figure_is_shown_by_a_view_or_drawn_by_another_figure(home: Path, name: str) -> None:
    others = [*HOMES, PACKAGE / "show" / "views.py", *(path for path in FIGURES if path != home)]
    imported = rf"from \.+(?:show\.)?(?:charts\.|drawing\.)?{home.stem} import (?:\([^)]*|.*)\b{name}\b"
    called = len(re.findall(rf"\b{name}\(", read(home))) > 1  # beside its definition
    assert called or any(re.search(imported, read(path)) for path in others)


def test_every_view_has_its_own_place() -> None:
    order = [view.order for view in (*VIEWS, GENERAL)]
    assert len(set(order)) == len(order)
    assert max(order) == GENERAL.order


def test_every_view_is_found_by_its_kind() -> None:
    for view in VIEWS:
        assert has_view(view.kind)
        assert view_of(view.kind) is view
    assert len({view.kind for view in VIEWS}) == len(VIEWS) == len(views._HOME)


def test_a_kind_with_a_view_is_shown_by_it_and_has_no_more_than_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    def seen(result: xr.Dataset) -> list[Table]:
        return [Table(title="seen", columns={"a": [1.0]})]

    def sections(result: xr.Dataset, company: object) -> list[Section]:
        return [Section(anchor="seen", title="Seen", parts=seen(result))]

    figures = [("7 Hz", "seen first")]
    view = ResultView("never_seen", 5, seen, sections, key_figures=lambda result: figures)
    assert tables_of(MANY)[0].title == "Variables"
    assert [one.title for one in sections_of({"x": MANY})] == ["Studies"]
    monkeypatch.setattr(views, "view_of", lambda kind: view if kind == "never_seen" else view_of(kind))
    assert brief_of(MANY) == tables_of(MANY)
    assert tables_of(MANY)[0].title == "seen"
    assert key_figures_of({"x": MANY}) == figures
    assert findings_of({"x": MANY}) == []
    assert front_of({"x": MANY}) == []
    page = report({"x": MANY})
    assert page.index('<section id="seen">') < page.index('<section id="model">')
    assert "7 Hz" in page


def test_the_kind_is_the_verb_not_the_name(lin: dict[str, xr.Dataset]) -> None:
    assert kind_of(lin["modes"], "soft") == "modes"
    assert kind_of(lin["modes"].drop_attrs(), "modes") == "modes"
    assert [one.title for one in sections_of({"soft": lin["modes"]})] == ["Vibration modes"]


def test_a_kind_that_comes_twice_is_named_and_has_ids_of_its_own(lin: dict[str, xr.Dataset]) -> None:
    both = {"soft": lin["modes"], "stiff": lin["modes"]}
    assert [one.title for one in sections_of(both)] == ["Vibration modes: soft", "Vibration modes: stiff"]
    ids = re.findall(r'\bid="((?:figure-|modes)[a-z0-9-]*)"', report(both))
    assert len(ids) == len(set(ids))
    assert {"modes", "modes-2", "figure-frequencies", "figure-frequencies-2"} <= set(ids)


def test_sections_keep_their_order_whatever_comes_first(ren: dict[str, xr.Dataset]) -> None:
    few = {**ren, "modes": ren["modes"].isel(mode=slice(0, 4))}
    titles = [one.title for one in sections_of(dict(reversed(few.items())))]
    assert titles == [one.title for one in sections_of(few)]
    assert titles[:3] == ["Train", "Speeds and torques", "Meshes"]


def test_terminal_and_report_say_the_same_of_every_mode(ren: dict[str, xr.Dataset]) -> None:
    (table,) = tables_of(ren["modes"])
    text, html = printed(ren["modes"]), html_table(table)
    for heading, _, cells in shown_columns(table, number):
        assert all(word in text for word in heading.split())
        assert f">{heading}</th>" in html
        if "energy" in heading:
            assert all(words in text and words in html for words, _ in cells)


@pytest.mark.parametrize("name", ["check", "modes", "stiffness", "campbell", "sharing", "tolerance", "allocate"])
def test_every_made_up_result_prints(ren: dict[str, xr.Dataset], name: str) -> None:
    text = printed(ren[name], whole=True)
    assert all(table.title.split(",")[0] in text for table in tables_of(ren[name]))
    assert "nan" not in text


def test_key_figures_are_values_with_words(ren: dict[str, xr.Dataset], lin: dict[str, xr.Dataset]) -> None:
    found = {words: value for value, words in key_figures_of(ren)}
    assert found["mesh frequency, main"] == "27.3125 Hz"
    assert found["speed of main.sun: 10.472 rad/s"] == "100 rpm"
    assert found["meshes whose teeth part at the operating point"] == "none of 12"
    assert key_figures_of({"study": MANY}) == []
    assert len(key_figures_of(lin)) < len(found)  # no speeds


def test_a_table_for_terminal_and_page() -> None:
    columns: dict[str, Any] = {
        "[x]": ["<a>", Styled(text="[b]", tone="bad")],
        "empty": [np.nan, np.nan],
        "y": [1.23456789, 2e7],
    }
    table = Table(title="t", columns=columns, lead="lead", notes=("n",), digits=3)
    assert [heading for heading, *_ in shown_columns(table, number)] == ["[x]", "y"]
    html = html_table(table)
    assert "&lt;a&gt;" in html
    assert '<span class="bad">[b]</span>' in html
    assert ">1.23<" in html
    assert "<li>n</li>" in html
    assert ">1.2346<" in html_table(Table(title="", columns=columns, decimals=4))


def audited() -> xr.Dataset:
    rows = {
        "quantity": ["f1", "f2", "f3"],
        "place": ["Table 1"] * 3,
        "published_text": ["1", "2", "3"],
        "published_unit": ["Hz", "1", "Hz"],
        "ours": [1.0, 2.5, np.nan],
        "difference": [0.0, 0.123456, np.nan],
        "verdict": ["reproduced", "under a reading", "not reproducible"],
        "outcome": ["holds", "does not hold", "holds"],
        "fitted": [False, True, False],
        "reading": ["", "as a mean", ""],
        "reason": ["", "", "not printed"],
        "because": ["print", "print", ""],
        "drive": ["one", "one", "two"],
    }
    attrs = {"verb": "audit", "sources": '{"one": "A", "two": "B"}', "notes": '{"one": "a  note", "two": ""}'}
    return xr.Dataset({name: ("row", np.array(cells, dtype=object)) for name, cells in rows.items()}, attrs=attrs)


def test_an_audit_is_a_table_a_drive_and_the_verdicts() -> None:
    first, second, verdicts = tables_of(audited())
    assert (first.title, first.lead, second.title) == ("one: A", "a note", "two: B")
    assert first.notes == ("tolerance: print", "reading: as a mean")
    assert first.columns["remark"] == ["1", "2 1"]
    assert [cell.tone for cell in first.columns["verdict"]] == ["good", "bad"]
    assert "fitted (contradicted)" in str(first.columns["verdict"][1])
    assert first.columns["difference"][1] == 0.12
    assert verdicts.columns["contradicted"] == [1, 0]
    assert tally(audited())["one"] == (
        "1 reproduced, 0 under a reading, 0 not reproducible, 0 not compared, 1 contradicted"
    )
    assert "Published numbers beside ours" in report({"audit": audited()})
    assert "1  tolerance: print" in printed(audited())


def test_load_factors_of_two_stages_are_apart() -> None:
    """Equal names of pairs in two stages: one column each."""
    from epicyclic.questions.flanks.views import contact_tables

    pairs = ["stages.low.meshes.sun-planet", "stages.high.meshes.sun-planet"]
    shape = (("torque_factor", "mesh"), np.ones((1, 2)))
    names = ("face_load_factor", "side_share", "largest_load_per_length", "smallest_load_per_length")
    result = xr.Dataset(
        {
            **dict.fromkeys(names, shape),
            "largest_root_stress": (("torque_factor", "mesh", "mesh_gear"), np.ones((1, 2, 2))),
            "averaging_length": ("mesh", [1e-3, 1e-3]),
            "mesh_force": (("torque_factor", "mesh", "time"), np.ones((1, 2, 1))),
            "branch_load_factor": (("torque_factor", "mesh_pair"), [[1.15, 1.01]]),
        },
        {
            **{"torque_factor": [1.0], "mesh": ["low/sun-planet/1", "high/sun-planet/1"]},
            **{"mesh_gear": ["a", "b"], "mesh_pair": pairs},
        },
        {"samples": 1, "slices": 1, "estimated_error": np.nan},
    )
    columns = contact_tables(result)[1].columns
    assert columns["K_gamma low: sun-planet"] == [1.15]
    assert columns["K_gamma high: sun-planet"] == [1.01]


def test_a_verdict_of_stability_counts_what_was_judged() -> None:
    found = epicyclic.stability("ren2021", mesh_frequency=[100.0, 125.0, 150.0])
    found["instability"][1] = ""  # a speed that has no multipliers
    words = printed(found)
    assert "Stable at 2 speeds judged, not known at 1" in words
    assert "everywhere" not in words
    assert "Stability not known at any of 1 speeds" in printed(found.isel(speed=[1]))


def test_titles_and_notes_wrap_at_the_terminal() -> None:
    title, note = "A title that is wider than its table of one narrow column", "a remark of several words " * 5
    stream = io.StringIO()
    for line in rich_lines(Table(title=title, columns={"x": [1.0]}, notes=(note, "short")), stream):
        assert len(line) <= 60
    lines = stream.getvalue().splitlines()
    assert title in lines
    begin = next(line.index("a remark") for line in lines if "a remark" in line)
    wrapped = [line for line in lines if "several" in line or "words" in line]
    assert len(wrapped) > 1
    # lines of a note begin below each other
    assert all(line[:begin].strip() in ("", "1") for line in wrapped)


def rich_lines(table: Table, stream: io.StringIO) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("epicyclic.show.console.brief_of", lambda _: [table])
        show(MANY, Console(file=stream, width=60))
    return stream.getvalue().splitlines()
