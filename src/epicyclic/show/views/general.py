"""Any result without a view of its own, among them studies over one parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table
from ..tables import force_table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 900


def tables(result: xr.Dataset) -> Sequence[Table]:
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


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The first variable with one or two dims over its parameter; all general results share one section."""
    from ..charts.study import drawable, study

    parts = [Drawing(anchor="study", figure=study(result))] if drawable(result) else []
    return [Section(anchor="studies", title="Studies", parts=parts)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """None."""
    return []


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """None."""
    return []


def front(result: xr.Dataset, company: Company) -> Sequence[Part]:
    """None."""
    return []


def headline(result: xr.Dataset) -> str:
    """None."""
    return ""
