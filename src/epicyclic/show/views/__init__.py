"""How each kind of result is shown: one file a kind, named by the attribute ``verb`` of its Datasets.

A view has an ``ORDER``, its place in the report, and of these functions those that it has something for:

    tables(result) -> Sequence[Table]               # what a terminal shows
    brief(result) -> Sequence[Table]                # those of one screen, where `tables` are more
    sections(result, company) -> Sequence[Section]  # what the report shows; company: kind -> the first result of it
    key_figures(result) -> Sequence[KeyFigure]      # what is read first, in both
    findings(result, company) -> Sequence[Finding]  # first page of the report: what passes, what not, what to change
    front(result, company) -> Sequence[Part]        # tables and figures of the first page
    headline(result) -> str                         # what the train is, one sentence

A kind without a view, or a view without a function, is shown by `general`.  Views import figures inside `sections`, so
that a terminal does not wait for plotly.

Depends on: results (as Datasets only).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from ..elements import Company, Finding, KeyFigure, Part, Section, Table

if TYPE_CHECKING:
    import xarray as xr

Datasets = Mapping[str, "xr.Dataset"]
Each = Callable[[Callable[[tuple[str, "xr.Dataset"]], Sequence[Section]], Sequence[tuple[str, "xr.Dataset"]]], Any]
_TONES = ("bad", "caution", "good", "")  # of findings, in the order in which they are read


def kind_of(result: xr.Dataset, name: str = "") -> str:
    """Kind of a result: its attribute ``verb``, or the name it goes by where it has none."""
    return str(result.attrs.get("verb") or name)


def tables_of(result: xr.Dataset) -> Sequence[Table]:
    """Tables of one result for a terminal."""
    found: Sequence[Table] = _function(kind_of(result), "tables")(result)
    return found


def brief_of(result: xr.Dataset) -> Sequence[Table]:
    """Tables of one result for one screen of a terminal; all of them where the view has no brief ones."""
    chosen = getattr(_view(kind_of(result)), "brief", None)
    found: Sequence[Table] = tables_of(result) if chosen is None else chosen(result)
    return found


def sections_of(results: Datasets, *, each: Each | None = None) -> list[Section]:
    """Sections of a report, in the order of their views; of one kind and title each with its name.

    Parameters
    ----------
    results : name -> Dataset.  each : each(work, items) gives work(item) of every item in order, perhaps elsewhere.
    """
    company = company_of(results)

    def sections(item: tuple[str, xr.Dataset]) -> Sequence[Section]:
        own: Sequence[Section] = _function(kind_of(item[1], item[0]), "sections")(item[1], company)
        return own

    ordered = _ordered(results)
    every = [sections(item) for item in ordered] if each is None else each(sections, ordered)
    made = [
        (name, kind_of(result, name), one) for (name, result), own in zip(ordered, every, strict=True) for one in own
    ]
    count = Counter((kind, one.title) for _, kind, one in made)
    return [
        replace(one, title=f"{one.title}: {name}") if count[kind, one.title] > 1 and has_view(kind) else one
        for name, kind, one in made
    ]


def key_figures_of(results: Datasets) -> list[KeyFigure]:
    """Values with their units and what they are, in the order of the views."""
    return [
        pair for name, result in _ordered(results) for pair in _function(kind_of(result, name), "key_figures")(result)
    ]


def findings_of(results: Datasets) -> list[Finding]:
    """What passes, what does not, what to change: what fails first, else in the order of the views."""
    company = company_of(results)
    found: list[Finding] = []
    for name, result in _ordered(results):
        own: Sequence[Finding] = _function(kind_of(result, name), "findings")(result, company)
        found += own
    return sorted(found, key=lambda one: _TONES.index(one.tone))


def front_of(results: Datasets) -> list[Part]:
    """Tables and figures of the first page of a report, in the order of the views."""
    company = company_of(results)
    return [
        part
        for name, result in _ordered(results)
        for part in _function(kind_of(result, name), "front")(result, company)
    ]


def headline_of(results: Datasets) -> str:
    """What the train is, in one sentence; empty where no result says it."""
    said = (_function(kind_of(result, name), "headline")(result) for name, result in _ordered(results))
    return next((text for text in said if text), "")


def has_view(kind: str) -> bool:
    """Whether a kind of result has a view of its own."""
    return kind in {module.name for module in iter_modules(__path__)}


def _view(kind: str) -> Any:
    return import_module(f"{__name__}.{kind if has_view(kind) else 'general'}")


def _function(kind: str, name: str) -> Any:
    return getattr(_view(kind), name, None) or getattr(_view("general"), name)


def _ordered(results: Datasets) -> list[tuple[str, xr.Dataset]]:
    return sorted(results.items(), key=lambda item: _view(kind_of(item[1], item[0])).ORDER)


def company_of(results: Datasets) -> Company:
    """The first result of each kind."""
    found: dict[str, xr.Dataset] = {}
    for name, result in results.items():
        found.setdefault(kind_of(result, name), result)
    return found
