"""The look of every figure: one colour-blind safe palette, one template, titles of axes with their units."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from ...limits import RESONANCE_BAND

# Okabe and Ito's colour-blind safe set, its yellow (unreadable on white) replaced by violet and grey.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#5B3F8C", "#7A7A7A")
# Of branches.  As of bodies below and loads in `flanks`, none is blue, which on the page is what can be clicked; three
# to one on white; the first four apart for eyes without red or green too, by their lightness (CIE76 21 at the least).
BRANCHES = ("#D55E00", "#00855F", "#D669A3", "#6A1B55", "#7C838A", "#9A7B00", "#8C1D18", "#3F5A00")
DASHES = ("solid", "dash", "dot", "dashdot")
INK, PALE, GRID, WARNING = "#1F2933", "#66727F", "#E3E7EB", "#B42318"
FONT = "'Segoe UI', 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif"
KIND_COLOURS = {
    "sun": "#B07A00",
    "planet": "#A8527F",
    "ring": "#009E73",
    "carrier": "#7A7A7A",
    "gear": "#7A7F1A",
    "body": "#8A5A3C",
}
MODE_COLOURS = {
    "rigid": "#7A7A7A",
    "rotational": "#D55E00",
    "translational": "#0072B2",
    "planet": "#009E73",
    "ring": "#B07A00",
    "mixed": "#5B3F8C",
}
_SYMBOLS = ("x", "circle", "diamond", "square", "hexagon", "star")
MODE_SYMBOLS = dict(zip(MODE_COLOURS, _SYMBOLS, strict=True))

SPEED_TITLE = f"speed (shaded: operation ± {100 * RESONANCE_BAND:.0f} %) [% of the operating speed]"
# A name to the right of the plot.
BESIDE = {"xref": "paper", "x": 1.005, "xanchor": "left", "yanchor": "middle"}
# Of bars: their numbers stand behind them, also beyond the axes.
OUTSIDE = {"textposition": "outside", "cliponaxis": False}

_AXIS = {
    "showgrid": True,
    "gridcolor": GRID,
    "zeroline": False,
    "linecolor": "#9AA5B1",
    "showline": True,
    "ticks": "outside",
    "ticklen": 5,
    "tickcolor": "#9AA5B1",
    "automargin": True,
    "exponentformat": "none",
    "separatethousands": True,
    "title": {"standoff": 10, "font": {"size": 13}},
    "tickfont": {"size": 12},
}


@cache
def template() -> go.layout.Template:
    """The one template of all figures; each takes a copy."""
    layout = {
        "font": {"family": FONT, "size": 13, "color": INK},
        "title": {
            **{"x": 0, "xref": "container", "xanchor": "left", "y": 1, "yref": "container", "yanchor": "top"},
            **{"pad": {"l": 12, "t": 14}, "font": {"size": 16}},
        },
        "separators": ".\u2009",
        "colorway": list(PALETTE),
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "margin": {"l": 64, "r": 24, "t": 56, "b": 56},
        "legend": {"x": 1.02, "xanchor": "left", "y": 1, "yanchor": "top", "font": {"size": 12}},
        "hoverlabel": {"font": {"family": FONT, "size": 12}, "bgcolor": "white", "bordercolor": "#9AA5B1"},
        "xaxis": _AXIS,
        "yaxis": _AXIS,
        "annotationdefaults": {"font": {"size": 12, "color": INK}},
    }
    return go.layout.Template(layout=layout)


def figure(title: str, *, x: str = "", y: str = "", height: int = 420) -> go.Figure:
    """An empty figure in the house style.

    Parameters
    ----------
    title : what the figure shows.  x, y : titles of the axes, with units.  height : [px].
    """
    axes = {name: {"title": {"text": text}} for name, text in (("xaxis", x), ("yaxis", y)) if text}
    return go.Figure(layout={"template": template(), "title": {"text": title}, "height": height, **axes})


def panels(title: str, names: Sequence[str], *, height: int, columns: int = 1, **options: Any) -> go.Figure:
    """An empty figure of several panels, named.

    Parameters
    ----------
    title : what the figure shows.  names : one per panel, row by row.  height : [px].  columns : panels side by side.
    options : as of plotly's `make_subplots`.
    """
    rows = -(-len(names) // columns)
    drawn = make_subplots(rows=rows, cols=columns, subplot_titles=list(names), **options)
    drawn.update_layout(template=template(), title={"text": title}, height=height)
    drawn.update_annotations(font={"size": 13, "color": PALE})
    return drawn


def level_legend(y: float, *, x: float = 0, **look: Any) -> dict[str, Any]:
    """A legend in a row below the plot (y < 0) or above it, at its left end (x = 0) or at its right one (1)."""
    anchors = {"xanchor": "right" if x else "left", "yanchor": "top" if y < 0 else "bottom"}
    return {"orientation": "h", "x": x, "y": y, **anchors, **look}


def note(drawn: go.Figure, text: str, **where: Any) -> None:
    """Write a plain text without an arrow into the figure; `where` as of a plotly annotation."""
    drawn.add_annotation({"text": text, "showarrow": False, "font": {"size": 12, "color": PALE}, **where})


def wide_height(across: float, tall: float) -> int:
    """Height [px] of a drawing to scale that takes the whole width of the page."""
    return round(min(640.0, max(380.0, 900.0 * tall / across + 170.0)))


def beside(letters: int) -> int:
    """Right margin [px] for names of so many letters of 12 px beside a plot."""
    return round(24 + 7.4 * letters)


def kind_colour(kind: str) -> str:
    """Colour of a kind of body."""
    return KIND_COLOURS.get(kind, KIND_COLOURS["body"])


def mode_colour(kind: str) -> str:
    """Colour of a kind of mode; kinds not known by name share that of mixed modes."""
    return MODE_COLOURS.get(_mode_key(kind), MODE_COLOURS["mixed"])


def mode_symbol(kind: str) -> str:
    """Marker of a kind of mode."""
    return MODE_SYMBOLS.get(_mode_key(kind), MODE_SYMBOLS["mixed"])


def branch_colour(branch: int) -> str:
    """Colour of a branch, 1 the first; meshes without a branch have the last colour."""
    return BRANCHES[(branch - 1) % len(BRANCHES)]


def translucent(colour: str, alpha: float) -> str:
    """``#rrggbb`` with an opacity, as CSS."""
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},{alpha:g})"


def tint(colour: str, white: float) -> str:
    """``#rrggbb`` mixed with so much white (0..1), opaque."""
    mixed = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
    return "#" + "".join(f"{round(value + (255 - value) * white):02x}" for value in mixed)


def _mode_key(kind: str) -> str:
    return next((key for key in MODE_COLOURS if kind.startswith(key)), "mixed")
