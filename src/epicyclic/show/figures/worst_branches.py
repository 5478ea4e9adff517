"""The load of every branch in the worst sample."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, merged, pair_title, pairs, texts
from .style import INK, branch_colour, panels

__all__ = ["worst_branches"]


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
