"""Datasets -> one self-contained HTML page that opens offline: the engineer's page first, the rest folded behind it.

Several trains stand side by side: key figures with their differences, resonances and sections that match.
"""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
import xarray as xr

from ..results.files import write_text
from ..user_input import checked
from .charts.operating_range import operating_range
from .elements import Drawing, Part, Section, Table
from .page import Page, finding_list, html_warning, packed, plotly_blob, printed, resource
from .series import engineering
from .tables import provenance
from .views import Each, company_of, findings_of, front_of, headline_of, key_figures_of, sections_of

Datasets = Mapping[str, xr.Dataset]
Variants = Mapping[str, Datasets]

VARIANTS = "variants"
"""Class of what stands side by side."""
_NUMBER = re.compile(r"^(-?[0-9.]+(?:e[+-]?[0-9]+)?)\s*(.*)$")


def difference_table(variants: Variants) -> Table:
    """Key figures of all trains, a row each, and how far the last is from the first [%].

    Rows match by what they are, not by where: a largest force in another mesh is the same row.
    """
    rows: dict[str, dict[str, tuple[str, str]]] = {}
    for name, datasets in variants.items():
        seen: dict[str, int] = {}
        for value, words in key_figures_of(datasets):
            what, _, where = _split(words)
            seen[what] = seen.get(what, 0) + 1
            key = what if seen[what] == 1 else f"{what} ({seen[what]})"
            rows.setdefault(key, {})[name] = (value, where)
    columns: dict[str, Any] = {"": list(rows)}
    for name in variants:
        columns[name] = [own.get(name, ("", ""))[0] for own in rows.values()]
    first, last = next(iter(variants)), list(variants)[-1]
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


def section_titles(every: Iterable[Iterable[Section]]) -> list[tuple[str, str]]:
    """Anchor and title of the sections of all trains, each once, in order."""
    return list(dict.fromkeys((one.anchor, one.title) for sections in every for one in sections if one.parts))


def _split(words: str) -> tuple[str, str, str]:
    """What a key figure is, and where: ``largest K_v at the operating speed: sun-planet 3``."""
    place = min((at for at in (words.find(mark) for mark in (":", ";")) if at >= 0), default=len(words))
    return words[:place], words[place : place + 1], words[place + 1 :].strip()


def _change(own: Mapping[str, tuple[str, str]], first: str, last: str) -> str:
    """``+3.1 %`` or ``-0.2`` from first to last; empty where either is no number or in another unit."""
    found = [_NUMBER.match(own.get(name, ("", ""))[0]) for name in (first, last)]
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
    further = [Drawing(anchor="study", figure=one) for one in (figures or {}).values()]
    sections = [
        *_drawn(datasets, each),
        Section(anchor="studies", title="Studies", parts=further),
        provenance(datasets),
    ]
    doi = _attribute(datasets, "doi")
    headline = headline_of(datasets)
    said = [f'<p class="headline">{escape(headline)}</p>' if headline else ""]
    said += [f"<p>Source: doi {escape(doi)}</p>" if doi else ""]
    folded = [one for one in _joined(sections) if one.parts]
    front = page.html(front_of(datasets))
    findings = finding_list(findings_of(datasets), ["warnings", *(one.anchor for one in folded)])
    first = f"{findings}{front}{_keys(datasets)}{_warnings(datasets)}{_left_out(datasets)}"
    return _html(name, "".join(said), first, folded, page)


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


def _drawn(datasets: Datasets, each: Each | None) -> list[Section]:
    """Sections of all results, their figures as text where `each` may draw them in another process."""
    if each is None:
        return sections_of(datasets)
    return sections_of(datasets, each=lambda work, items: each(lambda item: list(map(printed, work(item))), items))


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
    folded = [Section(anchor=anchor, title=words, parts=[]) for anchor, words in section_titles(every.values())]
    bodies = {}
    for one in folded:
        cells = []
        for variant, sections in every.items():
            parts = [part for own in _joined(sections) if own.title == one.title for part in own.parts]
            cells.append(f"<div><h3>{escape(variant)}</h3>{page.html(parts) or '<p>Not there.</p>'}</div>")
        bodies[one.title] = f'<div class="{VARIANTS}">{"".join(cells)}</div>'
    return _html(name, heads, f'{first}<div class="{VARIANTS}">{columns}</div>', folded, page, bodies)


def write_variants_report(
    path: str | Path, variants: Variants, *, title: str = "", compared: xr.Dataset | None = None
) -> Path:
    """Write the page of `variants_report`; the file appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_text(path, variants_report(variants, title=title, compared=compared))
    return Path(path)


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
        for at, text in (("plotly-packed", plotly_blob()), ("figures-packed", packed(page.figure_text())))
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
    items = "".join(f"<li>{html_warning(text)}</li>" for text in found)
    if len(found) <= _WARNINGS:
        return f'<div class="warnings" role="alert"{named}><b>Warnings</b><ul>{items}</ul></div>'
    return (
        f'<div class="warnings" role="alert"{named}><details class="fold">'
        f"<summary><b>{len(found)} warnings</b></summary><ul>{items}</ul></details></div>"
    )


def _left_out(datasets: Datasets) -> str:
    """What the model did not allow, and why."""
    found = [text for data in datasets.values() for text in _listed(data, "not_run")]
    items = "".join(f"<li>{html_warning(text)}</li>" for text in found)
    return f"<details><summary>Left out: {len(found)}</summary><ul>{items}</ul></details>" if found else ""


def _keys(datasets: Datasets) -> str:
    """The figures one looks for first."""
    cards = "".join(
        f'<div class="key"><b>{escape(value)}</b><span>{escape(words)}</span></div>'
        for value, words in key_figures_of(datasets)
    )
    return f'<div class="keys">{cards}</div>' if cards else ""
