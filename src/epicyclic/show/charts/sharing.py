"""Load sharing: ratio of each branch over time, coefficients of the meshes as bars about 1, K_gamma as a distribution.

Of trains made by the drawing how often which K_gamma occurs, what its scatter comes from, and what grades cost.  Its
quantiles stand over the spread of every drawing entry, and over what is no tolerance (torque, float and number of
planets), side by side at one scale.  Prices are those of the grades found, of one grade finer or coarser in each entry,
and of other targets.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import (
    DRAWN,
    Array,
    banded,
    by_panel,
    compact,
    engineering,
    even_bins,
    has_room,
    merged,
    micrometres,
    numbers,
    of_definition,
    pair_labels,
    percent,
    readable,
    scattering_pair,
    share_of_trains,
    short_entries,
    system_quantiles,
    tenth_less,
    texts,
)
from .over_time import over_time
from .renderers import (
    FROM_ZERO,
    INK,
    PALE,
    PALETTE,
    WARNING,
    Bars,
    Curve,
    Layer,
    Mark,
    Panel,
    Trace,
    branch_colour,
    chart,
    level_bars,
    level_legend,
    note,
    points,
    tint,
)

# Ratios that differ from 1 by less are one line at 1, which says so: they would be drawn over a range of nothing.
_EVEN, _AROUND = 1e-5, 0.01


def load_history(sharing: xr.Dataset) -> go.Figure:
    """Simultaneous load-sharing ratio of each branch [1] over time, a panel a pair of gears.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing_history (mesh, time) [1].
    """
    marks = [Mark(y=1, below=True)]
    drawn = over_time(sharing, "load_sharing_history", "Load sharing over time", "ratio [-]", 1.0, marks=marks)
    for row in range(1, len(drawn.layout.annotations) + 1):
        x, y = ("x", "y") if row == 1 else (f"x{row}", f"y{row}")
        values = [value for trace in drawn.data if trace.yaxis == y for value in trace.y if value is not None]
        if values and max(abs(value - 1) for value in values) < _EVEN:
            drawn.update_yaxes(range=[1 - _AROUND, 1 + _AROUND], row=row, col=1)
            where = {"x": 0.5, "y": 0.85, "xanchor": "center", "xref": f"{x} domain", "yref": f"{y} domain"}
            note(drawn, "every branch carries its share", **where)
    return drawn


def load_sharing(sharing: xr.Dataset) -> go.Figure:
    """Load-sharing coefficient of each mesh [1] by every definition, as bars about 1.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing (definition, mesh) [1].
    """
    values = sharing["load_sharing"].transpose("mesh", "definition").values
    definitions = [readable(name) for name in texts(sharing, "definition")]
    groups = by_panel(merged(texts(sharing, "mesh"), values))
    # more numbers than this do not fit on the bars; the table has them
    numbered = len(definitions) * len({one.label for series in groups.values() for one in series}) <= 21
    finite = values[np.isfinite(values)]
    low, high = min(1.0, float(finite.min(initial=1.0))), max(1.0, float(finite.max(initial=1.0)))
    span = max(high - low, 0.02)  # room for numbers on the bars
    ends, shown = (low - 0.25 * span, high + 0.3 * span), []
    numbers_on = {"textposition": "outside" if numbered else "none", "textangle": 0, "textfont": {"size": 11}}
    for title, series in groups.items():
        bars: list[Layer] = [Mark(y=1, width=1.5)]
        for one in series:
            above = [value - 1 if value is not None else None for value in compact(one.values, digits=6)]
            text = [f"{value:.3f}" if np.isfinite(value) else "" for value in one.values]
            pattern = {"shape": "/" if one.side == "right" else "", "fgcolor": "white", "size": 5}
            look = {"marker": {"color": branch_colour(one.branch), "pattern": pattern}, **numbers_on}
            hover = f"{one.label}<br>%{{x}}: %{{text}}"
            bars.append(Bars(definitions, above, name=one.label, base=1, text=text, hover=hover, look=look))
        shown.append(Panel(bars, title=title, y="coefficient [-]", x_axis={"showgrid": False}, y_ends=ends))
    layout: Trace = {"barmode": "group", "bargap": 0.25, "bargroupgap": 0.08, "height": 120 + 230 * len(groups)}
    return chart("Load-sharing coefficients", *shown, gap=0.3 / max(2, len(groups)), **layout)


def worst_branches(result: xr.Dataset) -> go.Figure:
    """Load of every branch over its equal share [1] in the sample with the largest K_gamma, a panel a pair.

    Parameters
    ----------
    result : Dataset of `tolerance`: worst_load_sharing (worst, mesh), worst_k_gamma (worst) [1].
    """
    values = result["worst_load_sharing"].transpose("worst", "mesh").values[0]
    groups = by_panel(merged(texts(result, "mesh"), values[:, None]))
    largest = float(result["worst_k_gamma"].values[0])
    title = f"The worst of {int(result.attrs.get('done', 0)):,} trains: Kγ = {largest:.3f}".replace(",", "\u2009")
    ends = (min(0.0, 1.1 * float(values.min())), 1.15 * float(values.max()))
    shown = []
    for pair, series in groups.items():
        bars = Bars(
            [one.label.removeprefix("branch ") for one in series],
            compact([one.values[0] for one in series]),
            colour=[branch_colour(one.branch) for one in series],
            text=[f"{one.values[0]:.2f}" for one in series],
            hover=f"{series[0].pair}, branch %{{x}}: %{{y:.3f}}",
        )
        layers = [bars, Mark(y=1, width=1.5, dash="dash")]
        axis = {"showgrid": False, "type": "category"}
        shown.append(Panel(layers, title=pair, x="branch [-]", x_axis=axis, y_ends=ends))
    return chart(title, *shown, y="load over its equal share [-]", height=400, columns=len(groups), gap=0.05)


_TENTH, _TOTAL, _FIRST, _SLOPE = PALETTE[2], tint(PALETTE[0], 0.55), PALETTE[0], PALETTE[1]
_BINS = 90
_TURNING = "mean-load-turning"
# heights above the panel of words on lines, in turn: neighbours do not cover each other
_HEIGHTS = (1.0, 1.075, 1.15)
_ACROSS = 3
"""Panels side by side."""
_COLOURS = dict(zip(DRAWN, (PALETTE[2], PALETTE[0], PALETTE[1]), strict=True))
# ratio of the ends of an axis from which on it is logarithmic
_DECADES = 30
# most tolerances in panels: the others move less
_MOST_PANELS = 9
# share of the largest rise below which a tolerance has no panel
_FLAT = 0.02
# Room for the points on a page of 900 px, and where names may stand against them, nearest first [px].
_WIDE, _TALL, _NEAR = 700.0, 300.0, 15.0
_SHIFTS = (-15.0, 15.0, -30.0, 30.0, -46.0, 46.0, -62.0, 62.0)
_FINER, _COARSER = PALETTE[2], PALETTE[3]


def tolerance_shares(result: xr.Dataset) -> go.Figure:
    """What a tenth less spread of every entry takes off K_gamma [1], shares of the variance [%], slopes [1/um].

    The first at the top, whiskers are 95 % bands.

    Parameters
    ----------
    result : Dataset of `tolerance` with shares.  Shares are of the pair with the largest spread.
    """
    one, ranking = of_definition(result), tenth_less(result)
    pair, at = scattering_pair(one), f"Kγ at {percent(ranking.probability)}"
    order, every = ranking.order[::-1], short_entries(texts(one, "tolerance"))
    names = [every[i] for i in order]
    slopes = one["quantile_slope"].isel(pair=pair).sel(probability=ranking.probability)
    slope = 1e-6 * np.where(micrometres(one), slopes.values, np.nan)
    where = pair_labels(texts(one, "pair"))[pair]
    total, first = (
        [100 * numbers(one.isel(pair=pair), f"{name}{end}") for end in ("", "_low", "_high")]
        for name in ("sobol_total", "sobol_first")
    )
    taken = [-ranking.value, -ranking.high, -ranking.low]
    bars = []
    for (values, *band), colour, words, unit in (
        (taken, _TENTH, "a tenth less spread", ""),
        (total, _TOTAL, "with interactions (total)", "%"),
        (first, _FIRST, "alone (first order)", "%"),
        ([slope], _SLOPE, "slope per µm of standard deviation", "per µm"),
    ):
        look: Trace = {"name": words, "colour": colour}
        text = [_number(float(value)) for value in values[order]]
        hover = f"%{{y}}, {words}: {'%{customdata}' if band else '%{text}'} {unit}"
        if band:
            low, high = (np.nan_to_num(np.abs(end - values))[order] for end in band)
            said = [banded(*row) for row in zip(values[order], *(end[order] for end in band), strict=True)]
            whiskers: Trace = {"type": "data", "array": compact(high), "arrayminus": compact(low), "color": INK}
            whiskers |= {"thickness": 1.2, "width": 3}
            look["look"] = {"error_x": whiskers, "customdata": said, "textposition": "none"}
        bars.append(Bars(names, compact(values[order]), level=True, text=text, hover=hover, **look))
    tops = " or ".join(every[i] for i in ranking.tied_first()[:2])
    return level_bars(
        f"A tenth less {tops} takes most off {at}",
        names[::-1],
        Panel(bars[:1], title="a tenth less spread", x=f"off {at} [-]"),
        Panel(bars[1:3], title=f"share of the variance, {where}", x="share [%]"),
        Panel(bars[3:], title=f"change of {at}", x="per µm of standard deviation [1/µm]"),
        height=190 + 46 * len(names),
        barmode="group",
        legend=level_legend(0.01, x=1, yref="container"),
        margin={"t": 84, "b": 92},
    )


def _number(value: float) -> str:
    """Two digits; nothing of what is not known, 0 of what is less than a hundred thousandth."""
    return "" if np.isnan(value) else "0" if abs(value) < 1e-5 else f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def k_gamma_histogram(result: xr.Dataset) -> go.Figure:
    """Shares of the samples over K_gamma of the train [1], its percentiles, and lines that the user gave.

    Parameters
    ----------
    result : Dataset of `tolerance`: system_histogram (definition, bin), bin_edge (edge), system_k_gamma_quantile
        (definition, probability) [1]; reference_k_gamma (reference) [1] if any.
    """
    quantiles, references = system_quantiles(result), dict[str, float]()
    if "reference_k_gamma" in result:
        references = dict(zip(texts(result, "reference"), numbers(result, "reference_k_gamma").tolist(), strict=True))
    words = " and below ".join(f"{value:.3f} in {percent(p)}" for p, value in quantiles.items() if p > 0.5)
    title = f"Kγ stays below {words} of the trains" if words else "Mesh-load factor Kγ"
    counts = of_definition(result)["system_histogram"].values
    marked = [*quantiles.values(), *references.values()]
    turning = counts
    if _TURNING in texts(result, "definition"):
        turning = of_definition(result, _TURNING)["system_histogram"].values
    lows, highs = zip(*(_range(result, one, marked) for one in (counts, turning)), strict=True)
    low, high = min(lows), max(highs)
    limits = {f"limit {value:g}": value for value in numbers(result, "limit").tolist()}
    for name, value in limits.items():  # an axis that reached so far would squeeze the trains
        title += "" if low < value < high else f"; {name} lies {'above' if value >= high else 'below'}"
    limits = {name: value for name, value in limits.items() if low < value < high}
    x, y = even_bins(numbers(result, "bin_edge"), counts, low, high, _BINS)
    colour = {"color": tint(PALETTE[0], 0.35), "line": {"width": 0}}
    look, hover = {"width": (high - low) / _BINS, "marker": colour}, "Kγ %{x:.3f}: %{y:.2f} %"
    layers: list[Layer] = [Bars(compact(x, digits=6), compact(100 * y), name="Kγ, mean load", hover=hover, look=look)]
    if not np.array_equal(turning, counts):  # the largest over the hunting period, as an outline
        x, y = even_bins(numbers(result, "bin_edge"), turning, low, high, _BINS)
        outline: Trace = {"colour": PALETTE[1], "width": 1.6, "shape": "hvh", "digits": (6, 5)}
        layers.append(Curve(x, 100 * y, name="largest while turning", hover=None, **outline))
    lines = [(value, f"{percent(p)}: {value:.3f}", INK, "solid") for p, value in quantiles.items()]
    lines += [(value, f"{name}: {value:.4g}", WARNING, "dash") for name, value in references.items()]
    lines += [(value, name, WARNING, "dot") for name, value in limits.items()]
    for place, (at, words, ink, dash) in enumerate(sorted(lines)):
        where = {"y": _HEIGHTS[place % len(_HEIGHTS)], "yref": "paper", "yanchor": "bottom"}
        where["font"] = {"size": 12, "color": ink}
        layers.append(Mark(x=at, colour=ink, width=1.6, dash=dash, words=words, where=where))
    axes: Trace = {"x": "mesh-load factor Kγ [-]", "y": "share of the trains per bin [%]", "y_axis": FROM_ZERO}
    layout: Trace = {"legend": level_legend(-0.17, x=1), "showlegend": True, "margin": {"t": 118, "b": 80}}
    return chart(title, Panel(layers, x_ends=(low, high), **axes), height=460, bargap=0, **layout)


def _range(result: xr.Dataset, counts: Array, shown: list[float]) -> tuple[float, float]:
    """Values between which the samples lie but for a thousandth, and what is marked; room at both sides."""
    edges, summed = numbers(result, "bin_edge"), np.cumsum(counts) / max(int(counts.sum()), 1)
    first, last = (int(np.searchsorted(summed, share)) for share in (0.0005, 0.9995))
    low = min([float(edges[first]), *shown])
    high = max([float(edges[min(last + 1, len(edges) - 1)]), *shown])
    room = 0.04 * max(high - low, 1e-6)
    return low - room, high + room


def _probabilities(result: xr.Dataset) -> list[tuple[int, float]]:
    """Place and value of the probabilities that are drawn; all of a result without those."""
    given = numbers(result, "probability")
    found = [(int(i), p) for p in DRAWN for i in np.flatnonzero(np.isclose(given, p))]
    return found or [(i, float(p)) for i, p in enumerate(given)]


def _k_gamma_curves(result: xr.Dataset, x: Array, values: Array, own: float) -> list[Layer]:
    """A curve a probability of K_gamma (k, probability) [1] over x (k,), and a line at the model's own x if any."""
    layers: list[Layer] = []
    for place, (i, p) in enumerate(_probabilities(result)):
        known = np.isfinite(values[:, i])
        look: Trace = {"colour": _COLOURS.get(p, PALETTE[(3 + place) % len(PALETTE)]), "width": 2, "points": 5}
        look |= {"hover": f"{percent(p)}: Kγ %{{y:.3f}} at %{{x}}", "digits": (7, 6)}
        layers.append(Curve(x[known], values[known, i], name=percent(p), **look))
    return layers + ([Mark(x=own, width=1, dash="dot")] if np.isfinite(own) else [])


def _k_gamma_chart(title: str, shown: list[Panel]) -> go.Figure:
    """Panels of K_gamma at one scale, side by side, with numbers on every panel's own axis."""
    columns = min(_ACROSS, max(len(shown), 1))
    rows = -(-len(shown) // columns)
    space = {"vertical_spacing": min(0.3, 90 / (110 + 240 * rows)), "horizontal_spacing": 0.05, "shared_yaxes": "all"}
    legend = level_legend(0.99, x=1, yref="container", yanchor="top")
    layout: Trace = {"columns": columns, "space": space, "showlegend": True, "legend": legend, "margin": {"t": 84}}
    return chart(title, *shown, y="Kγ [-]", height=150 + 240 * rows, **layout).update_xaxes(showticklabels=True)


def k_gamma_by_design(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over torque, stiffness of each support (float) and number of planets, whichever the result has.

    Parameters
    ----------
    result : Dataset of `tolerance`: k_gamma_by_torque (torque_scale, probability), k_gamma_by_support (support,
        support_scale, probability), support_stiffness (support, support_scale) [N/m], k_gamma_by_planets (planets,
        probability) [1].
    """
    shown = []
    for title, words, x, values, own in _curves(result):
        axis: Trace = {"dtick": 1} if words == "planets [-]" else {}
        if len(x) > 1 and x.min() > 0 and x.max() / x.min() >= _DECADES:
            axis = {"type": "log", "dtick": 1, "exponentformat": "power", "tickfont": {"size": 11}}
        shown.append(Panel(_k_gamma_curves(result, x, values, own), title=title, x=words, x_axis=axis))
    return _k_gamma_chart("Kγ over torque, float and planets", shown)


def _curves(result: xr.Dataset) -> Iterator[tuple[str, str, Array, Array, float]]:
    """Title, title of the axis, x (k,), K_gamma (k, probability) and the model's own x, nan where not marked."""
    if "k_gamma_by_torque" in result:
        values = result["k_gamma_by_torque"].transpose("torque_scale", "probability").values
        yield "torque", "torque per operating torque [-]", numbers(result, "torque_scale"), values, 1.0
    if "k_gamma_by_support" in result:
        own = int(np.argmin(np.abs(np.log(numbers(result, "support_scale")))))
        values = result["k_gamma_by_support"].transpose("support", "support_scale", "probability").values
        stiffness = result["support_stiffness"].transpose("support", "support_scale").values
        # stages.main.sun.support.radial -> sun
        entries = short_entries(texts(result, "support"))
        names = [entry.removesuffix(" radial").removesuffix(" support") for entry in entries]
        for name, x, curve in zip(names, stiffness, values, strict=True):
            yield f"support of {name}", "stiffness [N/m]", x, curve, float(x[own])
    if "k_gamma_by_planets" in result:
        values = result["k_gamma_by_planets"].transpose("planets", "probability").values
        known = np.isfinite(values).any(axis=1)
        yield "number of planets", "planets [-]", numbers(result, "planets")[known], values[known], np.nan


def k_gamma_by_tolerance(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over the scale of every tolerance, the steepest first.

    Parameters
    ----------
    result : Dataset of `tolerance`: k_gamma_by_scale (tolerance, scale, probability) [1].
    """
    values = result["k_gamma_by_scale"].transpose("tolerance", "scale", "probability").values
    entries, scale = short_entries(texts(result, "tolerance")), numbers(result, "scale")
    last = _probabilities(result)[-1][0]
    rise = np.nan_to_num(values[:, -1, last] - values[:, 0, last])
    order = np.argsort(-rise, kind="stable")[:_MOST_PANELS].tolist()
    moving = [i for i in order if rise[i] > _FLAT * rise[order[0]]] or order[:1]
    shown = []
    for panel, place in enumerate(moving):
        words = "spread per that drawn [-]" if panel + _ACROSS >= len(moving) else ""
        shown.append(Panel(_k_gamma_curves(result, scale, values[place], 1.0), title=entries[place], x=words))
    drawn = _k_gamma_chart(f"Which tolerance moves Kγ: {entries[order[0]]} most", shown)
    flat = [entry for i, entry in enumerate(entries) if i not in moving]
    if flat:
        where = {"x": 0, "xref": "paper", "y": 0, "yref": "paper", "yanchor": "top", "yshift": -62}
        note(drawn, f"hardly any effect: {', '.join(flat)}", **where)
        drawn.update_layout(margin={"b": 96})
    return drawn


def grade_prices(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over the total price: the grades found, their neighbours, the drawing, the cheapest of other targets.

    Parameters
    ----------
    result : Dataset of `allocate`: target, total_price, found_k_gamma, drawn_k_gamma, drawn_price; grade, finer_grade,
        coarser_grade, extra_cost, saving, finer_k_gamma, coarser_k_gamma (tolerance); front_price, front_k_gamma
        (front) [1].
    """
    price, found, target = (float(result[name]) for name in ("total_price", "found_k_gamma", "target"))
    p = percent(float(result.attrs["probability"]))
    title = f"Kγ ≤ {engineering(target)} in {share_of_trains(result)} for {engineering(price)}"
    layers: list[Layer] = []
    if "front_price" in result:
        x, y = numbers(result, "front_price"), numbers(result, "front_k_gamma")
        look: Trace = {"points": 5, "shape": "hv", "digits": (7, 6)}
        layers.append(Curve(x, y, name="cheapest for other targets", colour=PALE, width=1.5, **look))
    names = short_entries(texts(result, "tolerance"))
    said: list[tuple[float, float, str]] = []
    for words, colour, sign, steps in (
        ("one grade finer", _FINER, "+", ("finer_grade", "extra_cost", "finer_k_gamma")),
        ("one grade coarser", _COARSER, "−", ("coarser_grade", "saving", "coarser_k_gamma")),
    ):
        costs, values, grades = numbers(result, steps[1]), numbers(result, steps[2]), texts(result, steps[0])
        # of entries with another grade that has a price
        kept = np.flatnonzero(np.isfinite(costs) & np.isfinite(values)).tolist()
        prices = price + (1 if sign == "+" else -1) * costs[kept]
        look = {"text": [names[i] for i in kept], "hover": "%{text}, %{customdata}<br>Kγ %{y:.4f}", "digits": (9, 6)}
        look["look"] = {"customdata": [f"{grades[i]}: {sign}{engineering(float(costs[i]))}" for i in kept]}
        layers += [points(prices, values[kept], 9, name=words, colour=colour, **look)] if kept else []
        said += [(float(at), float(values[i]), names[i]) for at, i in zip(prices, kept, strict=True)]
    if "drawn_price" in result and np.isfinite(result["drawn_price"]):
        paid, factor = ([float(result[f"drawn_{name}"])] for name in ("price", "k_gamma"))
        layers.append(points(paid, factor, 12, name="as drawn", symbol="x", colour=INK, digits=(9, 9)))
    star: Trace = {"symbol": "star", "colour": PALETTE[1], "digits": (9, 9)}
    layers.append(points([price], [found], 18, name="the grades found", **star))
    where = {"x": 1, "xref": "paper", "xanchor": "right", "yanchor": "bottom", "font": {"color": WARNING}}
    layers.append(Mark(y=target, colour=WARNING, width=1.5, dash="dash", words="target", where=where))
    panel = Panel(layers, x="total price [-]", y=f"Kγ at {p} [-]")
    layout: Trace = {"showlegend": True, "legend": level_legend(1.0, x=1), "margin": {"t": 96}}
    drawn = chart(title, panel, height=480, **layout)
    _name_points(drawn, said, target)
    return drawn


def _name_points(drawn: go.Figure, said: list[tuple[float, float, str]], target: float) -> None:
    """Names below or above their points, as near as neither the line of the target nor another name or point is met."""
    every = [(float(x), float(y)) for trace in drawn.data for x, y in zip(trace.x, trace.y, strict=True)]
    xs, ys = [x for x, _ in every], [*(y for _, y in every), target]
    right, up = _WIDE / (max(xs) - min(xs) or 1.0), _TALL / (max(ys) - min(ys) or 1.0)  # [px] a price and a factor
    boxes = [(x * right, y * up, 10.0, 10.0) for x, y in every]
    line = (0.5 * (min(xs) + max(xs)) * right, target * up, 4 * _WIDE, 6.0)
    for x, y, name in sorted(said):
        own, taken = (6.2 * len(name), 14.0), [*boxes, line]
        free = (shift for shift in _SHIFTS if has_room((x * right, y * up + shift, *own), taken))
        shift = next(free, _SHIFTS[0])
        boxes.append((x * right, y * up + shift, *own))
        arrow = {"showarrow": abs(shift) > _NEAR, "arrowhead": 0, "arrowwidth": 1, "arrowcolor": PALE, "ax": 0}
        where = {"ay": -shift} if abs(shift) > _NEAR else {"yshift": shift}
        note(drawn, name, x=x, y=y, font={"size": 11, "color": INK}, **arrow, **where)
