"""Load-sharing coefficients of the meshes as bars about 1."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, pair_title, pairs, texts
from .style import INK, branch_colour, panels
from .summaries import readable

__all__ = ["load_sharing"]


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
    drawn = panels("Load-sharing coefficients", names, height=120 + 230 * len(groups), vertical_spacing=_gap(groups))
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


def _gap(groups: Sequence[object]) -> float:
    return 0.3 / max(2, len(groups))


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
