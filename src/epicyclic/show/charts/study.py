"""Plain curves: one quantity of a Dataset over one parameter, the figure of every kind without one of its own."""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import ArrayLike

from ..series import Array, compact, readable, short_names
from .style import DASHES, INK, PALETTE, figure


def curves(
    x: ArrayLike,
    ys: Mapping[str, ArrayLike],
    *,
    title: str,
    x_title: str,
    y_title: str,
    log_x: bool = False,
    reference: float | None = None,
) -> go.Figure:
    """Curves over one parameter.

    Parameters
    ----------
    x : (k,).  ys : label -> (k,).  x_title, y_title : with units.  log_x : logarithmic axis.
    reference : a value of y that has a meaning (1 for equal load sharing), drawn as a line.
    """
    drawn = figure(title, x=x_title, y=y_title, height=400)
    at = compact(np.asarray(x, dtype=np.float64), digits=7)
    for place, (name, y) in enumerate(ys.items()):
        look = {"color": PALETTE[place % len(PALETTE)], "dash": DASHES[place // len(PALETTE) % 4], "width": 2}
        values = compact(np.asarray(y, dtype=np.float64), digits=6)
        mode = "lines+markers" if len(at) <= 60 else "lines"
        drawn.add_trace(go.Scatter(x=at, y=values, mode=mode, name=name, line=look, marker={"size": 6}))
    if reference is not None:
        drawn.add_hline(y=reference, line={"color": INK, "width": 1.2, "dash": "dash"})
    if log_x:
        drawn.update_xaxes(type="log", dtick=1, exponentformat="power", separatethousands=False)
    drawn.update_layout(showlegend=True)
    return drawn


def study(result: xr.Dataset, name: str | None = None) -> go.Figure:
    """Curves of one variable over one parameter, and at most over names besides; unit and long name stand on the axes.

    Parameters
    ----------
    result : Dataset of any kind with a variable of numbers of one or two dims; attribute ``study`` is the title.
    name : the variable, the first of numbers where not said.
    """
    values = result[name or _first(result)]
    along = next((dim for dim in values.dims if _abscissa(result, dim) is not None), values.dims[0])
    others = [dim for dim in values.dims if dim != along]
    table = values.transpose(*others, along).values.reshape(-1, values.sizes[along])
    x, x_title = _abscissa(result, along) or (np.arange(values.sizes[along], dtype=np.float64), str(along))
    ys = dict(zip(_labels(result, others), table, strict=True)) if others else {_quantity(values): table[0]}
    drawn = curves(
        x,
        ys,
        title=str(result.attrs.get("study", "")) or _quantity(values),
        x_title=x_title,
        y_title=_quantity(values, _definition(result, str(values.name))),
        log_x=len(x) > 2 and bool((x > 0).all()) and float(x.max() / x.min()) >= 100,
        reference=1.0 if "load_sharing" in str(values.name) else None,
    )
    return drawn.update_layout(showlegend=bool(others))


def drawable(result: xr.Dataset) -> bool:
    """Whether `study` has something to draw."""
    return any(result[name].dtype.kind == "f" and 1 <= result[name].ndim <= 2 for name in result.data_vars)


def _first(result: xr.Dataset) -> str:
    named = [str(name) for name in result.data_vars if result[name].dtype.kind == "f" and 1 <= result[name].ndim <= 2]
    return named[0]


def _abscissa(result: xr.Dataset, dim: Hashable) -> tuple[Array, str] | None:
    """Numbers along a dimension and their title: a coordinate besides its index first, quantities as text too."""
    names = [name for name in result.coords if result[name].dims == (dim,)]
    for name in sorted(names, key=lambda one: one == dim):
        values = result[name]
        if values.dtype.kind in "fiu":
            return np.asarray(values.values, dtype=np.float64), _quantity(values)
        split = [str(text).split(" ", 1) for text in values.values]
        try:
            x = np.array([float(parts[0]) for parts in split])
        except ValueError:
            continue
        units = {parts[1] for parts in split if len(parts) > 1}
        if len(units) <= 1:
            return x, f"{readable(str(name))} [{_shown(units.pop())}]" if units else readable(str(name))
    return None


def _labels(result: xr.Dataset, dims: Sequence[Hashable]) -> list[str]:
    names = [""]
    for dim in dims:
        words = [str(value) for value in result[dim].values] if dim in result.variables else []
        words = words or [f"{dim} {place + 1}" for place in range(result.sizes[dim])]
        names = [f"{name}, {word}".lstrip(", ") for name in names for word in short_names(words)]
    return names


def _definition(result: xr.Dataset, name: str) -> str:
    """Definition of a load-sharing coefficient, ", worst case", as the options have it; "" of anything else."""
    options = json.loads(str(result.attrs.get("options", "{}")))
    found = options.get("definition") if "load_sharing" in name else None
    return f",<br>{readable(str(found))}" if found else ""


def _quantity(values: xr.DataArray, more: str = "") -> str:
    """Long name of a variable with its unit [1 as -]; more : after the name."""
    name = str(values.attrs.get("long_name", "") or readable(str(values.name))) + more
    unit = str(values.attrs.get("units", ""))
    return f"{name} [{_shown(unit)}]" if unit else name


def _shown(unit: str) -> str:
    """A unit as figures have it."""
    return {"1": "-", "um": "µm", "urad": "µrad"}.get(unit, unit)
