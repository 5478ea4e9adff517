"""Tables for a terminal, from columns of numbers and names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["columns_of", "listed", "number", "plain", "table"]


def number(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value + 0.0:.6g}"  # + 0.0: no negative zero
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(number, value))}]"
    return str(value)


def listed(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.5g}" for value in values)


def table(title: str, columns: Mapping[str, Iterable[Any]]) -> Table:
    """A table of named columns; columns with nothing in them are left out; numbers to the right."""
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    shown: list[list[str]] = []
    for name, values in columns.items():
        cells = [number(value) for value in values]
        if cells and not any(cells):
            continue
        numeric = not any(isinstance(value, str) for value in values)
        table.add_column(escape(name), justify="right" if numeric else "left", overflow="fold")
        shown.append(cells)
    for row in zip(*shown, strict=True):
        table.add_row(*(escape(cell) for cell in row))
    return table


def columns_of(result: xr.Dataset, dim: str, names: Mapping[str, tuple[str, float]]) -> dict[str, Any]:
    """Columns of a table over `dim`: variable -> (heading, factor from SI to the heading's unit)."""
    columns: dict[str, Any] = {dim: list(map(str, result[dim].values))}
    for name, (heading, factor) in names.items():
        if name in result:
            values = result[name].values
            columns[heading] = list(values * factor) if values.dtype.kind == "f" else [plain(v) for v in values]
    return columns


def plain(value: Any) -> Any:
    return (
        ("yes" if value else "")
        if isinstance(value, (bool, np.bool_))
        else value
        if not isinstance(value, str)
        else str(value)
    )
