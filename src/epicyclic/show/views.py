"""Views of results by their kind, and what they show of several results together: terminal, report, first page.

VIEWS = (ResultView("modes", 30, tables, sections, key_figures=key_figures),)

A kind without a view is shown as any result.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
import xarray as xr

from ..results.dataset import cases_of, largest
from .elements import Company, Drawing, Finding, KeyFigure, Part, Section, Styled, Table, force_table, named_columns
from .plot import KINDS
from .series import texts


def tables_of_any(result: xr.Dataset) -> Sequence[Table]:
    """Mesh forces where there are any, else least and most of every variable of numbers, of complex ones their size."""
    if "mesh_force" in result:
        return [force_table(result)]
    sizes = {str(name): abs(one) if one.dtype.kind == "c" else one for name, one in result.data_vars.items()}
    names = [name for name, values in sizes.items() if values.dtype.kind == "f"]
    columns: dict[str, Any] = {
        "variable": names,
        "unit": [str(result[name].attrs.get("units", "")) for name in names],
        "least": [float(sizes[name].min()) for name in names],
        "most": [float(sizes[name].max()) for name in names],
    }
    return [Table(title="Variables", columns=columns)]


def sections_of_any(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The first variable with one or two dims over its parameter; all general results share one section."""
    from .charts.effects import drawable, study

    parts = [Drawing(anchor="study", figure=study(result))] if drawable(result) else []
    return [Section(anchor="studies", title="Studies", parts=parts)]


Datasets = Mapping[str, "xr.Dataset"]


@dataclass(frozen=True, slots=True)
class ResultView:
    """How a kind of result is shown.

    kind : attribute ``verb`` of its Datasets.  order : its place in the report.
    tables : what a terminal shows.  sections : what the report shows; company: kind -> the first result of it.
    brief : tables of one screen, where `tables` are more.
    key_figures : what is read first, in both.  findings : first page of the report: what passes, what not, what to
    change.  front : tables and figures of the first page.  headline : what the train is, one sentence.
    over_cases : tables that set the load cases of a model beside each other, a row a case; of the whole,
    and case -> its result.

    Figures are imported inside `sections` and `front`, so that a terminal does not wait for plotly.
    """

    kind: str
    order: int
    tables: Callable[[xr.Dataset], Sequence[Table]]
    sections: Callable[[xr.Dataset, Company], Sequence[Section]]
    _: KW_ONLY
    brief: Callable[[xr.Dataset], Sequence[Table]] | None = None
    key_figures: Callable[[xr.Dataset], Sequence[KeyFigure]] = lambda result: ()
    findings: Callable[[xr.Dataset, Company], Sequence[Finding]] = lambda result, company: ()
    front: Callable[[xr.Dataset, Company], Sequence[Part]] = lambda result, company: ()
    headline: Callable[[xr.Dataset], str] = lambda result: ""
    over_cases: Callable[[xr.Dataset, Datasets], Sequence[Table]] = lambda result, cases: ()


GENERAL = ResultView("", 900, tables_of_any, sections_of_any)
Each = Callable[[Callable[[tuple[str, "xr.Dataset"]], Sequence[Section]], Sequence[tuple[str, "xr.Dataset"]]], Any]
# a module `views` is imported when one of its kinds is shown
_HOME = {kind: room for room, kinds in KINDS.items() if room for kind in kinds}
_TONES = ("bad", "caution", "good", "")  # of findings, in the order in which they are read


def in_section(
    anchor: str, title: str, tables: Callable[[xr.Dataset], Sequence[Table]]
) -> Callable[[xr.Dataset, Company], Sequence[Section]]:
    """`ResultView.sections` of a result that shows its tables in a report too, and nothing beside."""
    return lambda result, company: [Section(anchor=anchor, title=title, parts=list(tables(result)))]


def kind_of(result: xr.Dataset, name: str = "") -> str:
    """Kind of a result: its attribute ``verb``, or the name it goes by where it has none."""
    return str(result.attrs.get("verb") or name)


def tables_of(result: xr.Dataset) -> Sequence[Table]:
    """Tables of one result for a terminal."""
    return view_of(kind_of(result)).tables(result)


def brief_of(result: xr.Dataset) -> Sequence[Table]:
    """Tables of one result for one screen of a terminal; all of them where the view has no brief ones."""
    view = view_of(kind_of(result))
    return (view.brief or view.tables)(result)


def sections_of(results: Datasets, *, each: Each | None = None) -> list[Section]:
    """Sections of a report, in the order of their views; of one kind and title each with its name.

    Parameters
    ----------
    results : name -> Dataset.  each : each(work, items) gives work(item) of every item in order, perhaps elsewhere.
    """
    company = company_of(results)

    def sections(item: tuple[str, xr.Dataset]) -> Sequence[Section]:
        return view_of(kind_of(item[1], item[0])).sections(item[1], company)

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
    return [pair for name, result in _ordered(results) for pair in view_of(kind_of(result, name)).key_figures(result)]


def findings_of(results: Datasets) -> list[Finding]:
    """What passes, what does not, what to change: what fails first, else in the order of the views."""
    company = company_of(results)
    found: list[Finding] = []
    for name, result in _ordered(results):
        found += view_of(kind_of(result, name)).findings(result, company)
    return sorted(found, key=lambda one: _TONES.index(one.tone))


def front_of(results: Datasets) -> list[Part]:
    """Tables and figures of the first page of a report, in the order of the views."""
    company = company_of(results)
    return [
        part for name, result in _ordered(results) for part in view_of(kind_of(result, name)).front(result, company)
    ]


def headline_of(results: Datasets) -> str:
    """What the train is, in one sentence; empty where no result says it."""
    said = (view_of(kind_of(result, name)).headline(result) for name, result in _ordered(results))
    return next((text for text in said if text), "")


def has_view(kind: str) -> bool:
    """Whether a kind of result has a view of its own."""
    return kind in _HOME


def view_of(kind: str) -> ResultView:
    """The view of a kind of result; of one without its own the general one."""
    if kind == CASES.kind:
        return CASES
    if not has_view(kind):
        return GENERAL
    views: tuple[ResultView, ...] = import_module(f"..{_HOME[kind]}.views", __package__).VIEWS
    return next(view for view in views if view.kind == kind)


# --- load cases ------------------------------------------------------------------------------------------------------


def cases_tables(result: xr.Dataset) -> list[Table]:
    """Weight and worst finding of every case, and what the kind of the results sets beside each other."""
    said = _findings_by_case(result)
    names, reasons = texts(result, "case"), texts(result, "case_reason", "case")
    verdicts: list[Any] = []
    for name, reason in zip(names, reasons, strict=True):
        worst = next(iter(said.get(name, ())), None)
        text, tone = (reason, "bad") if reason else (worst.text, worst.tone) if worst else ("", "")
        verdicts.append(Styled(text=text, tone=tone) if text else "")
    columns = {
        "case": names,
        "duration [h]": list(result["case_duration"].values / 3600),
        "share [%]": list(100 * result["case_share"].values),
        str(result.attrs["of"]): verdicts,
    }
    found = cases_of(result)
    own = view_of(str(result.attrs["of"])).over_cases(result, found) or _forces_over_cases(found)
    return [Table(title="Load cases", columns=columns), *own]


def _forces_over_cases(cases: Datasets) -> list[Table]:
    """Largest mesh force of every case and its mesh; none of results without mesh forces."""
    rows = []
    for name, result in cases.items():
        kind = next((kind for kind in ("mesh_force_peak", "mesh_force") if kind in result), None)
        if kind is not None:
            most = result[kind].max([dim for dim in result[kind].dims if dim != "mesh"])
            at = largest(most.values)
            rows.append((name, float(most.values[at]) / 1e3, str(result["mesh"].values[at])))
    columns = named_columns(("case", "largest mesh force [kN]", "mesh"), rows)
    return [Table(title="Mesh forces over the load cases", columns=columns)] if rows else []


def cases_findings(result: xr.Dataset, company: Company) -> list[Finding]:
    """In which cases something fails, and which comes nearest to its limit, each with the time that it lasts."""
    said, anchor = _findings_by_case(result), f"cases-{result.attrs['of']}"
    failing = [name for name, own in said.items() if any(one.tone == "bad" for one in own)]
    found = []
    if failing:
        text = f"Fails in {', '.join(failing)}{_lasting(result, failing)}."
        found.append(Finding(tone="bad", text=text, anchor=anchor))
    limited = [
        (one.value / one.limit, name, one) for name, own in said.items() for one in own if one.value / one.limit > 0
    ]
    if limited:
        most, name, one = max(limited, key=lambda entry: entry[0])
        text = f"Least margin in {name}{_lasting(result, [name])}, {100 * most:.3g} % of its limit: {one.text}"
        found.append(Finding(tone=one.tone, text=text, anchor=anchor, value=one.value, limit=one.limit))
    return found


def _findings_by_case(result: xr.Dataset) -> dict[str, list[Finding]]:
    kind = str(result.attrs["of"])
    return {name: findings_of({kind: one}) for name, one in cases_of(result).items()}


def _lasting(result: xr.Dataset, names: Sequence[str]) -> str:
    """`, 38 % of the time`; nothing where the cases have no durations."""
    share = float(result["case_share"].sel(case=list(names)).sum(skipna=False))
    return "" if np.isnan(share) else f", {100 * share:.3g} % of the time"


def cases_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The tables, with the kind of the results in the title."""
    kind = str(result.attrs["of"])
    return [Section(anchor=f"cases-{kind}", title=f"Load cases: {kind}", parts=cases_tables(result))]


CASES = ResultView("cases", 15, cases_tables, cases_sections, findings=cases_findings)


def _ordered(results: Datasets) -> list[tuple[str, xr.Dataset]]:
    return sorted(results.items(), key=lambda item: view_of(kind_of(item[1], item[0])).order)


def company_of(results: Datasets) -> Company:
    """The first result of each kind."""
    found: dict[str, xr.Dataset] = {}
    for name, result in results.items():
        found.setdefault(kind_of(result, name), result)
    return found
