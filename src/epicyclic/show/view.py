"""Record of a view: how a kind of result is shown; and the general view, of results without one of their own.

VIEWS = (ResultView("modes", 30, tables, sections, key_figures=key_figures),)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

from .elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table
from .tables import force_table

if TYPE_CHECKING:
    import xarray as xr


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
    from .charts.study import drawable, study

    parts = [Drawing(anchor="study", figure=study(result))] if drawable(result) else []
    return [Section(anchor="studies", title="Studies", parts=parts)]


@dataclass(frozen=True, slots=True)
class ResultView:
    """How a kind of result is shown.

    kind : attribute ``verb`` of its Datasets.  order : its place in the report.
    tables : what a terminal shows.  sections : what the report shows; company: kind -> the first result of it.
    brief : tables of one screen, where `tables` are more.
    key_figures : what is read first, in both.  findings : first page of the report: what passes, what not, what to
    change.  front : tables and figures of the first page.  headline : what the train is, one sentence.

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


GENERAL = ResultView("", 900, tables_of_any, sections_of_any)
