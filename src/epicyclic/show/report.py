"""Datasets -> one self-contained HTML page that opens offline: warnings, key figures, sections, provenance."""

from __future__ import annotations

import json
import logging
from collections import Counter
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from plotly.offline import get_plotlyjs

from ..results.whole_file import write_text
from .elements import Details, Drawing, Part, Section, Table, number, shown_columns
from .figures.series import engineering
from .provenance import provenance
from .views import key_figures_of, sections_of

__all__ = ["html_table", "report", "write_report"]

_LOG = logging.getLogger(__name__)
Datasets = Mapping[str, xr.Dataset]


def report(datasets: Datasets, *, title: str = "", figures: Mapping[str, go.Figure] | None = None) -> str:
    """One HTML page with everything that the Datasets say; needs nothing from outside.

    Parameters
    ----------
    datasets : name -> result of a verb or a study.  The kind of each, its attribute ``verb``, says how it is shown
        (`views`); a kind without a view of its own is drawn over its parameter.
    title : of the page, that of the train where not said.  figures : further figures, by title.
    """
    name = title or _attribute(datasets, "title") or "Epicyclic gear train"
    further = [Drawing(anchor="study", figure=one) for one in (figures or {}).values()]
    sections = [*sections_of(datasets), Section(anchor="studies", title="Studies", parts=further), provenance(datasets)]
    page = _Page()
    bodies = [(one, page.anchor(one.anchor), page.html(one.parts)) for one in _joined(sections) if one.parts]
    links = "".join(f'<a href="#{anchor}">{escape(one.title)}</a>' for one, anchor, _ in bodies)
    parts = "".join(f'<section id="{at}"><h2>{escape(one.title)}</h2>{body}</section>' for one, at, body in bodies)
    doi = _attribute(datasets, "doi")
    source = f"<p>Source: doi {escape(doi)}</p>" if doi else ""
    head = (
        f'<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(name)}</title><link rel="icon" href="data:,"><style>{_style()}</style>'
        f"<script>{get_plotlyjs()}</script>"
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>'
        f'<nav aria-label="Contents"><strong>epicyclic</strong>{links}</nav>'
        f"<main><header><h1>{escape(name)}</h1>{source}</header>{_warnings(datasets)}{_keys(datasets)}{parts}</main>"
        "</body></html>"
    )


def write_report(
    path: str | Path, datasets: Datasets, *, title: str = "", figures: Mapping[str, go.Figure] | None = None
) -> Path:
    """Write the page of `report`; the file appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_text(path, report(datasets, title=title, figures=figures))
    return Path(path)


def _style() -> str:
    return files(__package__).joinpath("report.css").read_text(encoding="utf-8")


def _attribute(datasets: Datasets, name: str) -> str:
    return next((str(data.attrs[name]) for data in datasets.values() if data.attrs.get(name)), "")


def _joined(sections: Iterable[Section]) -> list[Section]:
    """Sections of one anchor and title as one, where the first of them stands."""
    found: dict[tuple[str, str], list[Part]] = {}
    for one in sections:
        found.setdefault((one.anchor, one.title), []).extend(one.parts)
    return [Section(anchor=anchor, title=title, parts=parts) for (anchor, title), parts in found.items()]


class _Page:
    """Parts of sections as HTML; an anchor that comes again gets a number."""

    def __init__(self) -> None:
        self._seen: Counter[str] = Counter()

    def anchor(self, name: str) -> str:
        self._seen[name] += 1
        return name if self._seen[name] == 1 else f"{name}-{self._seen[name]}"

    def html(self, parts: Iterable[Part]) -> str:
        return "".join(map(self._part, parts))

    def _part(self, part: Part) -> str:
        if isinstance(part, Table):
            return html_table(part)
        if isinstance(part, Drawing):
            return _figure(self.anchor(f"figure-{part.anchor}"), part)
        if isinstance(part, Details):
            return f"<details><summary>{escape(part.summary)}</summary>{self.html(part.parts)}</details>"
        return f"<pre>{escape(part.text)}</pre>"


def _figure(anchor: str, part: Drawing) -> str:
    """A figure as HTML that draws itself with the page's own plotly.js."""
    html = part.figure.to_html(
        full_html=False,
        include_plotlyjs=False,
        div_id=anchor,
        auto_play=False,
        default_width="100%",
        default_height=f"{part.figure.layout.height or 420}px",
        config={"responsive": True, "displaylogo": False},
    )
    words = f"<figcaption>{escape(part.caption)}</figcaption>" if part.caption else ""
    return f"<figure>{html}{words}</figure>"


def html_table(table: Table) -> str:
    """A table as HTML: the heading of a column of numbers and its cells to the right."""
    columns = shown_columns(table, lambda value: _cell(value, table))
    heads = "".join(f'<th scope="col"{_numeric(numeric)}>{escape(name)}</th>' for name, numeric, _ in columns)
    kinds = [_numeric(numeric) for _, numeric, _ in columns]
    rows = zip(*(cells for _, _, cells in columns), strict=True)
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{_toned(*cell)}</td>" for kind, cell in zip(kinds, row, strict=True)) + "</tr>"
        for row in rows
    )
    title = f"<caption>{escape(table.title)}</caption>" if table.title else ""
    lead = f"<p>{escape(table.lead)}</p>" if table.lead else ""
    notes = "".join(f"<li>{escape(text)}</li>" for text in table.notes)
    return (
        f'{lead}<div class="table"><table>{title}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table></div>'
        + (f"<ol>{notes}</ol>" if notes else "")
    )


def _cell(value: object, table: Table) -> str:
    """A cell that is no text: a number as the table wants it, else as in a terminal."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return number(value)
    if table.decimals is not None:
        return f"{value:.{table.decimals}f}" if np.isfinite(value) else ""
    return engineering(float(value), table.digits)


def _numeric(numeric: bool) -> str:
    return ' class="number"' if numeric else ""


def _toned(text: str, tone: str) -> str:
    return f'<span class="{tone}">{escape(text)}</span>' if tone else escape(text)


def _listed(data: xr.Dataset, name: str) -> list[str]:
    try:
        found = json.loads(str(data.attrs.get(name, "[]")))
    except json.JSONDecodeError:
        _LOG.warning("attribute %s is not JSON", name)
        return []
    return [str(one) for one in found]


def _warnings(datasets: Datasets) -> str:
    found = dict.fromkeys(text for data in datasets.values() for text in _listed(data, "warnings"))
    if not found:
        return '<div class="warnings calm" role="note">No warnings.</div>'
    items = "".join(f"<li>{escape(text)}</li>" for text in found)
    return f'<div class="warnings" role="alert"><b>Warnings</b><ul>{items}</ul></div>'


def _keys(datasets: Datasets) -> str:
    """The figures one looks for first."""
    cards = "".join(
        f'<div class="key"><b>{escape(value)}</b><span>{escape(words)}</span></div>'
        for value, words in key_figures_of(datasets)
    )
    return f'<div class="keys">{cards}</div>' if cards else ""
