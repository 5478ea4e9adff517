"""The page: self-contained, complete, escaped, written whole."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr
from plotly.offline import get_plotlyjs

from epicyclic.errors import ModelError
from epicyclic.show.elements import Table
from epicyclic.show.report import html_table, report, write_report
from epicyclic.show.views.modes import tables

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


def test_everything_has_its_section_and_its_link(ren: Datasets) -> None:
    page = read(report(ren))
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
    assert page.links == [f"#{name}" for name in page.sections]


@pytest.mark.parametrize(
    "name", ["check", "modes", "campbell", "stiffness", "sharing", "sweep", "tolerance", "allocate"]
)
def test_one_dataset_alone_makes_a_page(ren: Datasets, name: str) -> None:
    page = read(report({name: ren[name]}))
    assert page.sections[-1] == "model"
    assert len(page.sections) == (4 if name == "check" else 2)


def test_the_page_asks_for_nothing_outside(ren: Datasets) -> None:
    html = report(ren)
    assert read(html).outside == []
    # plotly.js itself is there once; what is left has no address but the source's doi
    assert html.count(get_plotlyjs()) == 1
    rest = html.replace(get_plotlyjs(), "")
    assert rest.count("Plotly.newPlot(") == 22
    assert re.findall(r"(?:https?:)?//[a-z]+\.[a-z]+", rest.replace("https://plot.ly", "")) == []
    assert len(html) < 8e6


def test_warnings_key_figures_and_tables_are_there(ren: Datasets) -> None:
    words = read(report(ren)).words
    assert words.index("cannot be assembled at equal spacing") < words.index("mesh frequency, main")
    assert words.index("27.3125 Hz") < words.index("Stages")
    for text in ("1047 kW", "86.68 Hz", "22287", "damping.modal", "not printed", "window: 23 mesh cycles", "0.1.0"):
        assert text in words
    coefficient = float(ren["sharing"].load_sharing.sel(definition="simultaneous").max())
    assert f"{coefficient:.4f}" in words


def test_text_of_the_model_is_escaped(ren: Datasets) -> None:
    bad = "</script><script>alert(1)</script>"
    check = ren["check"].assign_attrs(title=bad, warnings=json.dumps([bad]), assumed=json.dumps({bad: bad}))
    html = report({**ren, "check": check}, title=bad)
    assert "alert(1)</script>" not in html
    assert read(html).words.count("alert(1)") == 5  # title, heading, warning, path and reason of an assumption


def test_studies_and_further_figures_have_a_section(ren: Datasets, synthetic: ModuleType) -> None:
    study = synthetic.dataset(
        {"load_sharing": ("k", np.array([1.0, 1.1]))}, coords={"k": np.array([1e8, 1e9])}, verb="vary"
    )
    html = report({"float": study}, figures={"more": go.Figure(go.Scatter(y=[1, 2]))})
    assert read(html).sections == ["studies", "model"]
    assert html.replace(get_plotlyjs(), "").count("Plotly.newPlot(") == 2


def test_a_table_drops_empty_columns_and_escapes() -> None:
    html = html_table(Table(title="", columns={"a": ["<x>", "y"], "b": ["", float("nan")], "c": [1, 2]}))
    assert "<th" in html
    assert ">b<" not in html
    assert "&lt;x&gt;" in html


def test_the_mode_table_names_what_holds_the_energy(ren: Datasets) -> None:
    (table,) = tables(ren["modes"])
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
    assert report(lin) == report(lin)
