"""Load sharing: the ratio of each branch over time, coefficients of the meshes as bars about 1, the worst sample."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import Array, Series, compact, merged, pair_title, pairs, readable, texts
from .over_time import over_time
from .style import INK, branch_colour, note, panels

# Ratios that differ from 1 by less are one line at 1, which says so: they would be drawn over a range of nothing.
_EVEN, _AROUND = 1e-5, 0.01


def load_history(sharing: xr.Dataset) -> go.Figure:
    """Simultaneous load-sharing ratio of each branch [1] over time, a panel a pair of gears.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing_history (mesh, time) [1].
    """
    drawn = over_time(sharing, "load_sharing_history", "Load sharing over time", "ratio [-]", 1.0)
    for row in range(1, len(drawn.layout.annotations) + 1):
        drawn.add_hline(y=1, line={"color": INK, "width": 1.2}, layer="below", row=row, col=1)
        axis = "y" if row == 1 else f"y{row}"
        values = [value for trace in drawn.data if trace.yaxis == axis for value in trace.y if value is not None]
        if values and max(abs(value - 1) for value in values) < _EVEN:
            drawn.update_yaxes(range=[1 - _AROUND, 1 + _AROUND], row=row, col=1)
            where = {"xref": "x domain" if row == 1 else f"x{row} domain", "yref": f"{axis} domain"}
            note(drawn, "every branch carries its share", x=0.5, y=0.85, xanchor="center", **where)
    return drawn


def load_sharing(sharing: xr.Dataset) -> go.Figure:
    """Load-sharing coefficient of each mesh [1] by every definition, as bars about 1.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing (definition, mesh) [1].
    """
    values = sharing["load_sharing"].transpose("mesh", "definition").values
    definitions = [readable(name) for name in texts(sharing, "definition")]
    series = merged(texts(sharing, "mesh"), values)
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    names = [pair_title(pair, several) for pair in groups]
    gap = 0.3 / max(2, len(groups))
    drawn = panels("Load-sharing coefficients", names, height=120 + 230 * len(groups), vertical_spacing=gap)
    # more numbers than this do not fit on the bars; the table has them
    numbered = len(definitions) * len({one.label for one in series}) <= 21
    low, high = _limits(values)
    shown: set[str] = set()
    for row, pair in enumerate(groups, start=1):
        for one in series:
            if (one.stage, one.pair) == pair:
                drawn.add_trace(_bars(one, definitions, one.label not in shown, numbered), row=row, col=1)
                shown.add(one.label)
        drawn.add_hline(y=1, line={"color": INK, "width": 1.5}, row=row, col=1)
        drawn.update_yaxes(title_text="coefficient [-]", range=[low, high], row=row, col=1)
    drawn.update_layout(barmode="group", bargap=0.25, bargroupgap=0.08)
    drawn.update_xaxes(showgrid=False)
    return drawn


def _limits(values: Array) -> tuple[float, float]:
    """Range of the axis of coefficients (m, definitions) [1]: 1 in it, room for numbers on the bars."""
    finite = values[np.isfinite(values)]
    low, high = min(1.0, float(finite.min(initial=1.0))), max(1.0, float(finite.max(initial=1.0)))
    span = max(high - low, 0.02)
    return low - 0.25 * span, high + 0.3 * span


def _bars(one: Series, definitions: list[str], legend: bool, numbered: bool) -> go.Bar:
    return go.Bar(
        x=definitions,
        y=[value - 1 if value is not None else None for value in compact(one.values, digits=6)],
        base=1,
        name=one.label,
        legendgroup=one.label,
        showlegend=legend,
        marker={
            "color": branch_colour(one.branch),
            "pattern": {"shape": "/" if one.side == "right" else "", "fgcolor": "white", "size": 5},
        },
        text=[f"{value:.3f}" if np.isfinite(value) else "" for value in one.values],
        textposition="outside" if numbered else "none",
        textangle=0,
        textfont={"size": 11},
        cliponaxis=False,
        hovertemplate=f"{one.label}<br>%{{x}}: %{{text}}<extra></extra>",
    )


def worst_branches(result: xr.Dataset) -> go.Figure:
    """Load of every branch over its equal share [1] in the sample with the largest K_gamma, a panel a pair.

    Parameters
    ----------
    result : Dataset of `tolerance`: worst_load_sharing (worst, mesh), worst_k_gamma (worst) [1].
    """
    values = result["worst_load_sharing"].transpose("worst", "mesh").values[0]
    series = merged(texts(result, "mesh"), values[:, None])
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    largest = float(result["worst_k_gamma"].values[0])
    title = f"The worst of {int(result.attrs.get('done', 0)):,} trains: Kγ = {largest:.3f}".replace(",", "\u2009")
    names = [pair_title(pair, several) for pair in groups]
    drawn = panels(title, names, height=400, columns=len(groups), shared_yaxes=True, horizontal_spacing=0.05)
    for column, pair in enumerate(groups, start=1):
        own = [one for one in series if (one.stage, one.pair) == pair]
        drawn.add_trace(
            go.Bar(
                x=[one.label.removeprefix("branch ") for one in own],
                y=compact(np.array([one.values[0] for one in own])),
                marker={"color": [branch_colour(one.branch) for one in own]},
                text=[f"{one.values[0]:.2f}" for one in own],
                textposition="outside",
                cliponaxis=False,
                showlegend=False,
                hovertemplate=f"{pair[1]}, branch %{{x}}: %{{y:.3f}}<extra></extra>",
            ),
            row=1,
            col=column,
        )
        drawn.add_hline(y=1, line={"color": INK, "width": 1.5, "dash": "dash"}, row=1, col=column)
        drawn.update_xaxes(title_text="branch [-]", showgrid=False, type="category", row=1, col=column)
    drawn.update_yaxes(title_text="load over its equal share [-]", row=1, col=1)
    drawn.update_yaxes(range=[min(0.0, 1.1 * float(values.min())), 1.15 * float(values.max())])
    return drawn
