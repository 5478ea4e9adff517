"""Record of a view: how a kind of result is shown.  What a view does not say is shown as of any result.

VIEWS = (ResultView(kind="modes", order=30, tables=tables, sections=sections),)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ResultView:
    """How a kind of result is shown.

    kind : attribute ``verb`` of its Datasets.  order : its place in the report.
    tables : what a terminal shows.  brief : those of one screen, where `tables` are more.
    sections : what the report shows; company: kind -> the first result of it.
    key_figures : what is read first, in both.  findings : first page of the report: what passes, what not, what to
    change.  front : tables and figures of the first page.  headline : what the train is, one sentence.

    Figures are imported inside `sections` and `front`, so that a terminal does not wait for plotly.
    """

    kind: str
    order: int = 900
    tables: Callable[[xr.Dataset], Sequence[Table]] = tables_of_any
    brief: Callable[[xr.Dataset], Sequence[Table]] | None = None
    sections: Callable[[xr.Dataset, Company], Sequence[Section]] = sections_of_any
    key_figures: Callable[[xr.Dataset], Sequence[KeyFigure]] = lambda result: ()
    findings: Callable[[xr.Dataset, Company], Sequence[Finding]] = lambda result, company: ()
    front: Callable[[xr.Dataset, Company], Sequence[Part]] = lambda result, company: ()
    headline: Callable[[xr.Dataset], str] = lambda result: ""


GENERAL = ResultView(kind="")
