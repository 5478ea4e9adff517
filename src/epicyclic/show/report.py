"""Datasets -> one self-contained HTML page that opens offline: the engineer's page first, the rest folded behind it.

Several trains stand side by side: key figures with their differences, resonances and sections that match.  Tables,
figures and findings are HTML; figures and plotly.js go into the page compressed.
"""

from __future__ import annotations

import base64
import json
import logging
import re
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from plotly.offline import get_plotlyjs

from ..results.files import write_text
from ..user_input import checked
from .charts.over_speed import operating_range
from .charts.renderers import template
from .elements import Details, Drawing, FigureText, Finding, Part, Section, Table, number, provenance, shown_columns
from .series import engineering
from .views import Each, company_of, findings_of, front_of, headline_of, key_figures_of, sections_of

# of zlib: the largest block, plotly.js, takes 0.15 s, half of level 9, and is half a per cent larger
_LEVEL = 6
# Letters from which the text of a cell is a sentence: names of meshes and energies have fewer.
_SENTENCE = 44
_CODE = re.compile(r"^(.*) \[([a-z][a-z0-9-]*)\]$", re.DOTALL)
_WORDS = {"good": "passes", "caution": "look at", "bad": "fails", "": "note"}
_MARKS = {"good": "✓", "caution": "!", "bad": "✗", "": "·"}


def resource(name: str) -> str:
    """Text of a file beside this module."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def packed(text: str) -> str:
    """A text compressed (zlib), in base64; a page unpacks it by itself, without a server."""
    return base64.b64encode(zlib.compress(text.encode("utf-8"), _LEVEL)).decode("ascii")


class Page:
    """Parts of sections as HTML; an anchor that comes again gets a number.  figures : what the page's script draws."""

    def __init__(self) -> None:
        self.figures: dict[str, Any] = {}
        self._seen: Counter[str] = Counter()

    def anchor(self, name: str) -> str:
        self._seen[name] += 1
        return name if self._seen[name] == 1 else f"{name}-{self._seen[name]}"

    def html(self, parts: Iterable[Part]) -> str:
        return "".join(map(self._part, parts))

    def figure_text(self) -> str:
        """All figures as one JSON text, the template that they share once."""
        figures = ",".join(f"{json.dumps(anchor)}:{text}" for anchor, text in self.figures.items())
        return f'{{"template":{json.dumps(template().to_plotly_json())},"figures":{{{figures}}}}}'

    def _part(self, part: Part) -> str:
        if isinstance(part, Table):
            return html_table(part)
        if isinstance(part, Drawing):
            return self._figure(part)
        if isinstance(part, Details):
            return f"<details><summary>{escape(part.summary)}</summary>{self.html(part.parts)}</details>"
        return f"<pre>{escape(part.text)}</pre>"

    def _figure(self, part: Drawing) -> str:
        """Room for a figure, which the script of the page draws when it is first seen."""
        anchor = self.anchor(f"figure-{part.anchor}")
        figure = part.figure if isinstance(part.figure, FigureText) else _figure_text(part.figure)
        self.figures[anchor] = figure.json
        words = f"<figcaption>{escape(part.caption)}</figcaption>" if part.caption else ""
        style = f"height:{figure.height:g}px"
        return f'<figure><div id="{anchor}" class="plotly-graph-div" style="{style}"></div>{words}</figure>'


def printed(section: Section) -> Section:
    """A section whose figures are text: what a worker sends fast, since figures are checked anew when unpickled."""
    return replace(section, parts=[_printed(part) for part in section.parts])


def _printed(part: Part) -> Part:
    if isinstance(part, Drawing) and not isinstance(part.figure, FigureText):
        return replace(part, figure=_figure_text(part.figure))
    return replace(part, parts=[_printed(one) for one in part.parts]) if isinstance(part, Details) else part


@cache
def _plotly() -> str:
    """The program of plotly, packed: a quarter of the time of a small page."""
    return packed(get_plotlyjs())


def _figure_text(figure: go.Figure) -> FigureText:
    """A figure as JSON, without its template where that is the one of the page."""
    look = figure.layout.template
    height = figure.layout.height or 420
    if look != template():
        return FigureText(json=figure.to_json(validate=False), height=height)
    figure.layout.template = None
    text = figure.to_json(validate=False)
    figure.layout.template = look
    return FigureText(json=text, height=height)


def html_table(table: Table) -> str:
    """A table as HTML: the heading of a column of numbers and its cells to the right."""
    columns = shown_columns(table, lambda value: _cell(value, table))
    number_class = {True: ' class="number"', False: ""}
    heads = "".join(f'<th scope="col"{number_class[numeric]}>{escape(name)}</th>' for name, numeric, _ in columns)
    kinds = [  # a column of sentences may break over lines; one of names may not
        number_class[numeric] or (' class="long"' if any(len(text) > _SENTENCE for text, _ in cells) else "")
        for _, numeric, cells in columns
    ]
    rows = zip(*(cells for _, _, cells in columns), strict=True)
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{_toned(*cell)}</td>" for kind, cell in zip(kinds, row, strict=True)) + "</tr>"
        for row in rows
    )
    title = f"<caption>{escape(table.title)}</caption>" if table.title else ""
    lead = f'<p class="lead">{escape(table.lead)}</p>' if table.lead else ""
    notes = "".join(f"<li>{escape(text)}</li>" for text in table.notes)
    # tabindex: what scrolls must be reached by keyboard
    return (
        f'{lead}<div class="table" tabindex="0"><table>{title}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody>'
        "</table></div>" + (f"<ol>{notes}</ol>" if notes else "")
    )


def finding_list(findings: Iterable[Finding], anchors: Iterable[str]) -> str:
    """What passes, what does not, what to change, as a list; links to those anchors that the page has."""
    known = set(anchors)
    items = []
    for one in findings:
        link = f' <a href="#{escape(one.anchor)}">more</a>' if one.anchor in known else ""
        change = f'<span class="change">{escape(one.change)}</span>' if one.change else ""
        items.append(
            f'<li class="{one.tone or "plain"}"><b class="mark" title="{_WORDS[one.tone]}">{_MARKS[one.tone]}</b>'
            f'<div><span class="verdict">{_WORDS[one.tone]}</span> {escape(one.text)}{link}{change}</div></li>'
        )
    return f'<ul class="findings">{"".join(items)}</ul>' if items else ""


def html_warning(text: str) -> str:
    """A warning; its code, where it ends in one, says how to ask for more."""
    match = _CODE.match(text)
    if match is None:
        return escape(text)
    words, code = match.groups()
    return f'{escape(words)} <code title="epicyclic explain {code}">{code}</code>'


def _cell(value: object, table: Table) -> str:
    """A cell that is no text: a number as the table wants it, else as in a terminal."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return number(value)
    if table.decimals is not None:
        return f"{value:.{table.decimals}f}" if np.isfinite(value) else ""
    return engineering(float(value), table.digits)


def _toned(text: str, tone: str) -> str:
    return f'<span class="{tone}">{escape(text)}</span>' if tone else escape(text)


Datasets = Mapping[str, xr.Dataset]
Variants = Mapping[str, Datasets]

VARIANTS = "variants"
"""Class of what stands side by side."""
_NUMBER = re.compile(r"^(-?[0-9.]+(?:e[+-]?[0-9]+)?)\s*(.*)$")


def difference_table(variants: Variants) -> Table:
    """Key figures of all trains, a row each, and of two how far the second is from the first [%].

    Rows match by what they are, not by where: a largest force in another mesh is the same row.
    """
    rows: dict[str, dict[str, str]] = {}  # what it is -> train -> value
    for name, datasets in variants.items():
        seen = Counter[str]()
        for value, words in key_figures_of(datasets):
            what = re.split("[:;]", words)[0]  # largest K_v at the operating speed: sun-planet 3
            seen[what] += 1
            rows.setdefault(what if seen[what] == 1 else f"{what} ({seen[what]})", {})[name] = value
    columns = {"": list(rows)} | {name: [own.get(name, "") for own in rows.values()] for name in variants}
    if len(variants) == 2:
        first, last = variants
        columns[f"{last} against {first}"] = [_change(own, first, last) for own in rows.values()]
    return Table(title="Key figures", columns=columns)


def variant_parts(variants: Variants, compared: xr.Dataset | None = None) -> list[Part]:
    """What stands first: the differences, and the range of speeds of every train in one figure.

    compared : result of `compare`, whose drawing and table say what differs in the drawings and what that does.
    """
    parts: list[Part] = [difference_table(variants)]
    companies = {name: company_of(datasets) for name, datasets in variants.items()}
    drawn = {
        name: (one.get("modes"), one.get("sweep")) for name, one in companies.items() if one.get("modes") is not None
    }
    figure = operating_range(drawn) if drawn else None
    if figure is not None:
        parts.append(Drawing(anchor="operating-range", figure=figure))
    if compared is not None:
        parts += [part for one in sections_of({"compare": compared}) for part in one.parts]
    return parts


def _change(own: Mapping[str, str], first: str, last: str) -> str:
    """``+3.1 %`` or ``-0.2`` from first to last; empty where either is no number or in another unit."""
    found = [_NUMBER.match(own.get(name, "")) for name in (first, last)]
    if found[0] is None or found[1] is None or found[0][2] != found[1][2]:
        return ""
    before, after = float(found[0][1]), float(found[1][1])
    if before == after:
        return "="
    if found[0][2] == "%":  # a difference of shares is one in per cent points
        return f"{after - before:+.3g} points"
    return f"{100 * (after / before - 1):+.3g} %" if before else f"{engineering(after - before)}"


_LOG = logging.getLogger(__name__)
# Warnings that are read before the rest; more of them are folded away, their number stays to be seen.
_WARNINGS = 3
_BESIDE = ' class="beside"'  # contents above, so that two trains have room


def report(
    datasets: Datasets,
    *,
    title: str = "",
    figures: Mapping[str, go.Figure] | None = None,
    each: Each | None = None,
) -> str:
    """One HTML page with everything that the Datasets say; needs nothing from outside.

    First what the train is, what passes, what does not and what to change; then folded sections.

    Parameters
    ----------
    datasets : name -> result of a verb or a study.  The kind of each, its attribute ``verb``, says how it is shown
        (`views`); a kind without a view of its own is drawn over its parameter.
    title : of the page, that of the train where not said.  figures : further figures, by title.
    each : each(work, items) gives work(item) of every item in order: the sections may be drawn on several cores.
    """
    page = Page()
    name = title or _attribute(datasets, "title") or "Epicyclic gear train"
    # figures as text where `each` may draw them in another process
    drawn = sections_of(
        datasets, each=each and (lambda work, items: each(lambda item: list(map(printed, work(item))), items))
    )
    further = [Drawing(anchor="study", figure=one) for one in (figures or {}).values()]
    sections = [*drawn, Section(anchor="studies", title="Studies", parts=further), provenance(datasets)]
    doi = _attribute(datasets, "doi")
    headline = headline_of(datasets)
    said = f'<p class="headline">{escape(headline)}</p>' if headline else ""
    said += f"<p>Source: doi {escape(doi)}</p>" if doi else ""
    folded = [one for one in _joined(sections) if one.parts]
    front = page.html(front_of(datasets))
    findings = finding_list(findings_of(datasets), ["warnings", *(one.anchor for one in folded)])
    first = f"{findings}{front}{_keys(datasets)}{_warnings(datasets)}{_left_out(datasets)}"
    return _html(name, said, first, folded, page)


@checked
def write_report(
    path: str | Path,
    datasets: Datasets,
    *,
    title: str = "",
    figures: Mapping[str, go.Figure] | None = None,
    each: Each | None = None,
) -> Path:
    """Write the page of `report`; the file appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_text(path, report(datasets, title=title, figures=figures, each=each))
    return Path(path)


def variants_report(variants: Variants, *, title: str = "", compared: xr.Dataset | None = None) -> str:
    """One HTML page with several trains side by side: key figures with differences, findings, figures beside.

    Parameters
    ----------
    variants : name of each -> its Datasets as of `report`.  compared : result of `compare` on the same trains.
    """
    page = Page()
    name = title or " and ".join(variants)
    heads = "".join(
        f"<p><b>{escape(one)}</b>: {escape(_attribute(own, 'title'))}. {escape(headline_of(own))}</p>"
        for one, own in variants.items()
    )
    first = page.html(variant_parts(variants, compared))
    columns = "".join(
        f"<div><h3>{escape(one)}</h3>{finding_list(findings_of(own), ())}{_warnings(own, anchor='')}"
        f"{_left_out(own)}</div>"
        for one, own in variants.items()
    )
    every = {one: [*sections_of(own), provenance(own)] for one, own in variants.items()}
    titles = dict.fromkeys((one.anchor, one.title) for sections in every.values() for one in sections if one.parts)
    folded = [Section(anchor=anchor, title=words, parts=[]) for anchor, words in titles]
    bodies = {}
    for one in folded:
        cells = []
        for variant, sections in every.items():
            parts = [part for own in _joined(sections) if own.title == one.title for part in own.parts]
            cells.append(f"<div><h3>{escape(variant)}</h3>{page.html(parts) or '<p>Not there.</p>'}</div>")
        bodies[one.title] = f'<div class="{VARIANTS}">{"".join(cells)}</div>'
    return _html(name, heads, f'{first}<div class="{VARIANTS}">{columns}</div>', folded, page, bodies)


def _html(
    name: str, said: str, first: str, folded: Iterable[Section], page: Page, bodies: Mapping[str, str] | None = None
) -> str:
    """The whole page.  bodies : of sections by title, where they are not their parts."""
    kept = [
        (one, page.anchor(one.anchor), page.html(one.parts) if bodies is None else bodies[one.title]) for one in folded
    ]
    links = "".join(f'<a href="#{anchor}">{escape(one.title)}</a>' for one, anchor, _ in kept)
    parts = "".join(
        f'<section id="{at}"><details class="fold"><summary><h2>{escape(one.title)}</h2></summary>{body}</details>'
        "</section>"
        for one, at, body in kept
    )
    # text of a script is no HTML: base64 has no character that could end it
    blobs = "".join(
        f'<script type="text/plain" id="{at}">{text}</script>'
        for at, text in (("plotly-packed", _plotly()), ("figures-packed", packed(page.figure_text())))
    )
    head = (
        f'<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark"><title>{escape(name)}</title>'
        f'<link rel="icon" href="data:,"><style>{resource("report.css")}</style>'
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head>{head}</head><body{_BESIDE if bodies else ""}>'
        f'<nav aria-label="Contents"><strong>epicyclic</strong>{links}</nav>'
        f"<main><header><h1>{escape(name)}</h1>{said}</header>{first}"
        '<div class="folds"><button data-folds="open">Open all</button> '
        f'<button data-folds="close">Close all</button></div>{parts}</main>{blobs}'
        f"<script>{resource('report.js')}</script></body></html>"
    )


def _attribute(datasets: Datasets, name: str) -> str:
    return next((str(data.attrs[name]) for data in datasets.values() if data.attrs.get(name)), "")


def _joined(sections: Iterable[Section]) -> list[Section]:
    """Sections of one anchor and title as one, where the first of them stands."""
    found: dict[tuple[str, str], list[Part]] = {}
    for one in sections:
        found.setdefault((one.anchor, one.title), []).extend(one.parts)
    return [Section(anchor=anchor, title=title, parts=parts) for (anchor, title), parts in found.items()]


def _listed(data: xr.Dataset, name: str) -> list[str]:
    try:
        found = json.loads(str(data.attrs.get(name, "[]")))
    except json.JSONDecodeError:
        _LOG.warning("attribute %s is not JSON", name)
        return []
    return [str(one) for one in found]


def _warnings(datasets: Datasets, *, anchor: str = "warnings") -> str:
    """All warnings, each once, and what the model did not allow."""
    found = dict.fromkeys(text for data in datasets.values() for text in _listed(data, "warnings"))
    named = f' id="{anchor}"' if anchor else ""
    if not found:
        return f'<div class="warnings calm" role="note"{named}>No warnings.</div>'
    items = _items(found)
    body = f'<details class="fold"><summary><b>{len(found)} warnings</b></summary>{items}</details>'
    if len(found) <= _WARNINGS:
        body = f"<b>Warnings</b>{items}"
    return f'<div class="warnings" role="alert"{named}>{body}</div>'


def _items(texts: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{html_warning(text)}</li>' for text in texts)}</ul>"


def _left_out(datasets: Datasets) -> str:
    """What the model did not allow, and why."""
    found = [text for data in datasets.values() for text in _listed(data, "not_run")]
    return f"<details><summary>Left out: {len(found)}</summary>{_items(found)}</details>" if found else ""


def _keys(datasets: Datasets) -> str:
    """The figures one looks for first."""
    cards = "".join(
        f'<div class="key"><b>{escape(value)}</b><span>{escape(words)}</span></div>'
        for value, words in key_figures_of(datasets)
    )
    return f'<div class="keys">{cards}</div>' if cards else ""
