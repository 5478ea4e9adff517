"""What a change moves: as bars about zero, most at the top, or as plain curves.

A tornado: what one percent of each number moves a frequency or a mesh force by.  Trains beside each other: how much
every quantity differs from that of the first.  One quantity of a Dataset over one parameter is the figure of every kind
without one of its own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Hashable, Sequence

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..elements import ComparedRow, compared_rows, letters, percent, shown
from ..series import Array, engineering, numbers, readable, short_names, texts
from .renderers import PALETTE, Bars, Curve, Layer, Mark, Panel, Trace, chart, cycled, level_bars, level_legend

_UP, _DOWN = "#D55E00", "#0072B2"
# Rows of the figure: what stands below moves less than those.
_MOST_ROWS = 14
# A frequency that moves by less than this share of what moves most is a bar of no visible length.
_NOTABLE = 0.01


def tornado(data: xr.Dataset) -> go.Figure:
    """Change of a frequency or force per 1 % more of each number [%], the strongest first, as bars about zero.

    A bar between two values is a repeated root that splits.

    Parameters
    ----------
    data : Dataset of `sensitivity`: sensitivity (path, mode or mesh) [1], ranked_by (mode or mesh), parameter_value,
        parameter_unit (path).
        Numbers below a thousandth of the strongest are left out, and those behind the first 20.
    """
    dim = "mode" if "mode" in data.sizes else "mesh"
    chosen = np.flatnonzero(data["ranked_by"].values.astype(bool))
    values = data["sensitivity"].transpose("path", dim).values[:, chosen]
    low, high = values.min(axis=1), values.max(axis=1)
    size = np.maximum(np.abs(low), np.abs(high))
    strong: list[int] = np.flatnonzero(size > 1e-3 * float(np.nanmax(size, initial=0.0)))[:20].tolist()
    names = {i: _name(data, i) for i in strong}
    bars = []
    for colour, words, positive in ((_UP, "raises it", True), (_DOWN, "lowers it", False)):
        rows = [i for i in strong if (high[i] + low[i] >= 0) == positive]
        single = np.isclose(low[rows], high[rows], rtol=1e-6, atol=0)
        base = np.where(single, 0.0, low[rows])
        text = [
            f"{'+' if b > 0 else '−'}{engineering(abs(b))}" if alone else f"{engineering(a)} … {engineering(b)}"
            for a, b, alone in zip(low[rows], high[rows], single, strict=True)
        ]
        said: Trace = {"name": words, "colour": colour, "text": text, "hover": "%{y}: %{text} % per 1 %"}
        at, values = [names[i] for i in rows], (high[rows] - base).tolist()
        bars += [Bars(at, values, base=base.tolist(), level=True, **said)] if rows else []
    panel = Panel(bars, x="change of it per 1 % more of the number [%]")
    title, labels = f"What moves {data.attrs.get('subject', 'it')}", [*names.values()]
    look: Trace = {"row": 26, "barmode": "overlay", "nothing": "nothing moves it"}
    return level_bars(title, labels, panel, **look, legend=level_legend(1.0, x=1), margin={"t": 84})


def _name(data: xr.Dataset, place: int) -> str:
    """The path without its table, and its value: ``main.sun.mass = 750 kg``."""
    path = texts(data, "path")[place]
    head, _, rest = path.partition(".")
    short = rest if head in ("stages", "bodies") else path
    value = engineering(float(numbers(data, "parameter_value")[place]))
    return f"{short} = {value} {texts(data, 'parameter_unit')[place]}".rstrip()


def compared(data: xr.Dataset) -> go.Figure:
    """Change of ratio, natural frequencies, load sharing and mesh forces from the first train [%], as bars about it.

    Parameters
    ----------
    data : Dataset of `compare`; quantities that do not change are left out.
    """
    rows = _strongest(compared_rows(data))
    names, signs = texts(data, "train"), letters(data)
    labels = [f"{row.name}<br>A = {shown(row.value[0], row.unit)}" for row in rows]
    title = "Nothing changes"
    if rows:
        change = rows[0].change
        place = max(range(1, len(names)), key=lambda i: abs(change[i]) if math.isfinite(change[i]) else -1.0)
        title = f"{signs[place]}: {rows[0].name} {percent(change[place])}, the largest change from A"
    bars = []
    for place in range(len(names) - 1, 0, -1):  # plotly draws the first trace of a group lowest
        short = names[place].replace("stages.", "")
        words = f"{signs[place]}  {short if len(short) <= 60 else f'{short[:57]}...'}"
        values = [row.change[place] if math.isfinite(row.change[place]) else None for row in rows]
        text = [f"{percent(row.change[place])}  {shown(row.value[place], row.unit)}".strip() for row in rows]
        colour = PALETTE[(place - 1) % len(PALETTE)]
        bars.append(Bars(labels, values, level=True, name=words, colour=colour, text=text))
    legend = level_legend(0, xref="container", yref="container", traceorder="reversed")
    margin = {"t": 64, "b": 92 + 18 * (len(names) // 4)}
    panel = Panel(bars, x=f"change from {signs[0]} [%]")
    layout: Trace = {"showlegend": True, "legend": legend, "margin": margin, "height": 170 + 34 * max(len(rows), 1)}
    return level_bars(title, labels, panel, barmode="group", nothing="nothing changes", **layout)


def _strongest(rows: list[ComparedRow]) -> list[ComparedRow]:
    """Rows that change, most at the top; of many frequencies or variables those with a notable part of the largest."""
    changed = sorted((row for row in rows if row.largest), key=lambda row: -row.largest)
    least = _NOTABLE * (changed[0].largest if changed else 0.0)
    return [row for row in changed if row.group not in ("modes", "variable") or row.largest >= least][:_MOST_ROWS]


def study(result: xr.Dataset) -> go.Figure:
    """Curves of the first variable of numbers over one parameter, and at most over names besides, with units.

    Parameters
    ----------
    result : Dataset of any kind with a variable of numbers of one or two dims; attribute ``study`` is the title.
    """
    values = result[drawable(result)[0]]
    along = next((dim for dim in values.dims if _abscissa(result, dim) is not None), values.dims[0])
    others = [dim for dim in values.dims if dim != along]
    table = values.transpose(*others, along).values.reshape(-1, values.sizes[along])
    x, x_title = _abscissa(result, along) or (np.arange(values.sizes[along], dtype=np.float64), str(along))
    ys = dict(zip(_labels(result, others), table, strict=True)) if others else {_quantity(values): table[0]}
    look: Trace = {"points": 6 if len(x) <= 60 else 0, "width": 2, "digits": (7, 6)}
    layers: list[Layer] = [Curve(x, y, name=name, **cycled(i), **look) for i, (name, y) in enumerate(ys.items())]
    layers += [Mark(y=1, dash="dash")] if "load_sharing" in str(values.name) else []  # equal load sharing
    wide = len(x) > 2 and bool((x > 0).all()) and float(x.max() / x.min()) >= 100
    log = {"type": "log", "dtick": 1, "exponentformat": "power", "separatethousands": False} if wide else {}
    panel = Panel(layers, y=_quantity(values, _definition(result, str(values.name))), x_axis=log)
    title = str(result.attrs.get("study", "")) or _quantity(values)
    return chart(title, panel, x=x_title, height=400, showlegend=bool(others))


def drawable(result: xr.Dataset) -> list[str]:
    """Names of the variables that `study` can draw."""
    return [str(name) for name, one in result.data_vars.items() if one.dtype.kind == "f" and 1 <= one.ndim <= 2]


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
