"""The page: self-contained, complete, escaped, written whole."""

from __future__ import annotations

import json
import pickle
import re
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr
from plotly.offline import get_plotlyjs
from tests.unit.packed_page import unpacked

from epicyclic.errors import ModelError
from epicyclic.questions.modes.views import modes_tables
from epicyclic.show.elements import Finding, Table
from epicyclic.show.report import (
    difference_table,
    finding_list,
    html_table,
    html_warning,
    report,
    variants_report,
    write_report,
)

Datasets = dict[str, xr.Dataset]


class Page(HTMLParser):
    """Sections, links, outside references and the words outside scripts of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.sections: list[str] = []
        self.links: list[str] = []
        self.outside: list[str] = []
        self.words = ""
        self._quiet = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {name: value or "" for name, value in attrs}
        self._quiet += tag in ("script", "style")
        if tag == "section":
            self.sections.append(named["id"])
        if tag == "a":
            self.links.append(named["href"])
        loads = [named.get(name, "") for name in ("src", "srcset")]
        loads += [named.get("href", "")] if tag == "link" else []
        self.outside += [one for one in loads if one and not one.startswith("data:")]

    def handle_endtag(self, tag: str) -> None:
        self._quiet -= tag in ("script", "style")

    def handle_data(self, data: str) -> None:
        self.words += "" if self._quiet else data


def read(html: str) -> Page:
    page = Page()
    page.feed(html)
    return page


def figures(html: str) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = json.loads(unpacked(html)["figures-packed"])["figures"]
    return found


@pytest.fixture(scope="module")
def whole(ren: Datasets) -> str:
    """The page of all of them."""
    return report(ren)


def some(datasets: Datasets, *names: str) -> Datasets:
    return {name: datasets[name] for name in names}


def test_everything_has_its_section_and_its_link(whole: str) -> None:
    page = read(whole)
    assert page.sections == [
        "train",
        "operation",
        "meshes",
        "modes",
        "sharing",
        "tolerances",
        "sweep",
        "allocation",
        "model",
    ]
    assert page.links[: len(page.sections)] == [f"#{name}" for name in page.sections]
    # further links are those of findings, to what is there
    assert set(page.links) <= {f"#{name}" for name in [*page.sections, "warnings"]}
    assert len(page.links) > len(page.sections)


@pytest.mark.parametrize(
    "name", ["check", "modes", "campbell", "stiffness", "sharing", "sweep", "tolerance", "allocate"]
)
def test_one_dataset_alone_makes_a_page(ren: Datasets, name: str) -> None:
    page = read(report({name: ren[name]}))
    assert page.sections[-1] == "model"
    assert len(page.sections) == (4 if name == "check" else 2)


def test_the_page_asks_for_nothing_outside(whole: str) -> None:
    html = whole
    assert read(html).outside == []
    assert unpacked(html)["plotly-packed"] == get_plotlyjs()
    drawn = figures(html)
    assert len(drawn) == 23
    assert set(re.findall(r'<div id="(figure-[a-z0-9-]+)" class="plotly-graph-div"', html)) == set(drawn)
    rest = re.sub(r'(<script type="text/plain"[^>]*>)[^<]*', r"\1", html) + json.dumps(drawn)
    assert re.findall(r"(?:https?:)?//[a-z]+\.[a-z]+", rest) == []
    assert len(html) < 3e6


def test_sections_drawn_in_other_processes_make_the_same_page(ren: Datasets, whole: str) -> None:
    items: list[str] = []

    def elsewhere(work: Any, given: Any) -> Any:
        items.extend(name for name, _ in given)
        return [pickle.loads(pickle.dumps(work(item))) for item in given]

    assert report(ren, each=elsewhere) == whole
    assert set(items) == set(ren)


def test_warnings_key_figures_and_tables_are_there(ren: Datasets, whole: str) -> None:
    words = read(whole).words
    assert words.index("cannot be assembled at equal spacing") < words.index("mesh frequency, main")
    assert words.index("27.3125 Hz") < words.index("Stages")
    for text in (
        "1047 kW",
        "86.68 Hz",
        "22287",
        "damping.modal",
        "not printed",
        "window: 23 mesh cycles",
        version("epicyclic"),
    ):
        assert text in words
    coefficient = float(ren["sharing"].load_sharing.sel(definition="simultaneous").max())
    assert f"{coefficient:.4f}" in words


def test_text_of_the_model_is_escaped(ren: Datasets) -> None:
    bad = "</script><script>alert(1)</script>"
    check = ren["check"].assign_attrs(title=bad, warnings=json.dumps([bad]), assumed=json.dumps({bad: bad}))
    html = report({"check": check, "sharing": ren["sharing"]}, title=bad)
    assert "alert(1)</script>" not in html
    assert read(html).words.count("alert(1)") == 5  # title, heading, warning, path and reason of an assumption


def test_studies_and_further_figures_have_a_section(ren: Datasets, synthetic: ModuleType) -> None:
    study = synthetic.dataset(
        {"load_sharing": ("k", np.array([1.0, 1.1]))}, coords={"k": np.array([1e8, 1e9])}, verb="vary"
    )
    html = report({"float": study}, figures={"more": go.Figure(go.Scatter(y=[1, 2]))})
    assert read(html).sections == ["studies", "model"]
    assert list(figures(html)) == ["figure-study", "figure-study-2"]


def test_a_table_drops_empty_columns_and_escapes() -> None:
    html = html_table(Table(title="", columns={"a": ["<x>", "y"], "b": ["", float("nan")], "c": [1, 2]}))
    assert "<th" in html
    assert ">b<" not in html
    assert "&lt;x&gt;" in html


def test_the_mode_table_names_what_holds_the_energy(ren: Datasets) -> None:
    (table,) = modes_tables(ren["modes"])
    html = html_table(table)
    shares = ren["modes"].kinetic_energy_share.isel(mode=3)
    member = [str(name).split("/")[1] for name in shares.body.values]
    total = shares.groupby(xr.DataArray(member, dims="body", name="member")).sum()
    assert f"{total.idxmax().item()} {100 * float(total.max()):.0f} %" in html


def test_the_file_is_whole_or_not_there(ren: Datasets, tmp_path: Path) -> None:
    target = write_report(tmp_path / "page.html", {"check": ren["check"]})
    assert target.read_text(encoding="utf-8").endswith("</html>")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]
    with pytest.raises(ModelError, match="cannot be written"):
        write_report(tmp_path / "missing" / "page.html", {"check": ren["check"]})


def test_the_same_datasets_make_the_same_page(lin: Datasets) -> None:
    few = {**lin, "modes": lin["modes"].isel(mode=slice(0, 4))}
    assert report(few) == report(few)


def test_the_first_page_says_what_passes_and_what_does_not(ren: Datasets, whole: str) -> None:
    """Before every section, what fails first; each finding has its number in the Dataset it came from."""
    lost = ren["sharing"].contact_lost.copy(data=np.arange(ren["sharing"].sizes["mesh"]) < 2)
    html = report({**some(ren, "check", "tolerance"), "sharing": ren["sharing"].assign(contact_lost=lost)})
    first = read(html[: html.index("<section")]).words
    assert f"Teeth part at the operating point in 2 of {lost.size} meshes" in first
    assert first.index("fails") < first.index("look at") < first.index("note")
    assert "Teeth stay in contact in all 12 meshes at the operating point" in read(whole).words
    named = ren["sharing"].assign_coords(definition=["mean-load", *ren["sharing"].definition.values[1:]])
    value = float(named.load_sharing.sel(definition="mean-load").max())
    assert value > 1.001
    limits = {"k_gamma_limit": ("mesh", [1.05] * lost.size), "k_gamma_limit_source": ("mesh", ["limit"] * lost.size)}
    said = read(report({"sharing": named.assign(limits)})).words
    assert f"K_gamma {value:.3f} as drawn; limit 1.05 (limit): FAILS" in said
    assert re.search(r"Ratio [0-9.]+; 1047 kW; sun \(100 rpm\) drives carrier \(28.75 rpm\)", first)


def test_a_finding_links_only_where_there_is_something() -> None:
    found = [Finding(tone="bad", text="<1>", change="do & so", anchor="there"), Finding(tone="", text="2", anchor="no")]
    html = finding_list(found, ["there"])
    assert html.count("<a ") == 1
    assert "&lt;1&gt;" in html
    assert "do &amp; so" in html
    assert html.count("fails") == 2  # the word and the tooltip of the mark
    assert finding_list([], []) == ""


def test_the_code_of_a_warning_is_set_apart() -> None:
    assert html_warning("teeth [a] part [contact-lost]").startswith("teeth [a] part <code title=")
    assert html_warning("a length [mm") == "a length [mm"
    assert html_warning("a <b> [contact-lost]").startswith("a &lt;b&gt; <code title=")


def test_variants_stand_side_by_side_with_their_differences(ren: Datasets) -> None:
    check = ren["check"]
    one = {**some(ren, "check", "sweep"), "modes": ren["modes"].isel(mode=slice(0, 4))}
    other = {**one, "check": check.assign(power=1.1 * check["power"])}
    table = difference_table({"a": one, "b": other})
    row = table.columns[""].index("power through the train")
    assert table.columns["b against a"][row] == "+10 %"
    rows = zip(table.columns[""], table.columns["b against a"], strict=True)
    assert {change for name, change in rows if "frequency" in name} == {"="}
    html = variants_report({"a": one, "b": other})
    page, alone = read(html), report(one)
    assert page.outside == []
    assert page.sections == read(alone).sections
    assert len(figures(html)) == 2 * (len(figures(alone)) - 1) + 1  # the range of speeds of both is one figure
    assert html.count('class="variants"') == 1 + len(page.sections)
