"""What a spec becomes: axes with titles, one entry of the legend a name, units under the pointer, lines and bands."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from epicyclic.show.charts import renderers
from epicyclic.show.charts.renderers import (
    DASHES,
    FROM_ZERO,
    PALETTE,
    Bars,
    Curve,
    Heat,
    Layer,
    Mark,
    Panel,
    Stems,
    chart,
    cycled,
    level_bars,
    points,
)
from epicyclic.show.series import has_room, kept_apart, texts

X = [0.0, 1.0, 2.0]


def hover(layer: Layer, **axes: Any) -> Any:
    return chart("", Panel([layer], **axes)).data[0].hovertemplate


def test_units_under_the_pointer_are_those_of_the_axes() -> None:
    curve = Curve(X, X, name="sun")
    assert hover(curve, x="speed [Hz]", y="force [kN]") == "sun: %{y:.4g} kN at %{x:.5g} Hz<extra></extra>"
    assert hover(curve, x="torque [1]", y="Kγ [-]") == "sun: %{y:.4g} at %{x:.5g}<extra></extra>"
    assert hover(Curve(X, X), x="time", y="path [mm]<br>tip above") == "%{y:.4g} mm at %{x:.5g}<extra></extra>"
    assert hover(Curve(X, X, hover="%{text}", text=["a", "b", "c"])) == "%{text}<extra></extra>"
    assert hover(Curve(X, X, hover="%{y}<extra>sun</extra>")) == "%{y}<extra>sun</extra>"
    silent = chart("", Panel([Curve(X, X, hover=None)])).data[0]
    assert (silent.hoverinfo, silent.hovertemplate) == ("skip", None)


def test_the_shared_unit_is_under_the_pointer_of_every_panel() -> None:
    shown = [Panel([Curve(X, X)], title=title, y="force [N]") for title in ("above", "below")]
    drawn = chart("Forces", *shown, x="time [s]")
    assert {trace.hovertemplate for trace in drawn.data} == {"%{y:.4g} N at %{x:.5g} s<extra></extra>"}
    assert (drawn.layout.xaxis.title.text, drawn.layout.xaxis2.title.text) == (None, "time [s]")
    assert drawn.layout.yaxis2.title.text == "force [N]"
    assert drawn.layout.xaxis.matches == "x2"
    beside = chart("Forces", *shown, y="load [N]", columns=2, gap=0.1)
    assert (beside.layout.yaxis.title.text, beside.layout.yaxis2.title.text) == ("force [N]", "force [N]")
    assert beside.layout.yaxis2.matches == "y"


def test_a_name_is_in_the_legend_once_and_shown_and_hidden_together() -> None:
    above = Panel([Curve(X, X, name="sun"), Curve(X, X, name="ring")], title="above")
    below = Panel([Curve(X, X), Curve(X, X, name="sun"), Curve(X, X, name="late")], title="below")
    drawn = chart("", above, below)
    found = [(trace.name, trace.legendgroup, trace.showlegend) for trace in drawn.data]
    assert found == [
        ("sun", "sun", True),
        ("ring", None, True),
        (None, None, False),
        ("sun", "sun", False),
        ("late", None, True),
    ]
    hidden = chart("", Panel([Curve(X, X, name="sun", key=False), Curve(X, X, name="ring", group="others")]))
    assert [(trace.legendgroup, trace.showlegend) for trace in hidden.data] == [(None, False), ("others", True)]


def test_lines_and_points_of_a_curve() -> None:
    layers = [Curve(X, X), Curve(X, X, points=5), points(X, X, 9, symbol="x", outline=2, colour="red")]
    line, both, dots = chart("", Panel(layers)).data
    assert (line.mode, both.mode, dots.mode) == ("lines", "lines+markers", "markers")
    assert (both.line.width, both.marker.size) == (1.8, 5)
    assert (dots.marker.symbol, dots.marker.size, dots.marker.line.width, dots.marker.color) == ("x", 9, 2, "red")
    (band,) = chart("", Panel([Curve(X, X, width=0, look={"fill": "tonexty"})])).data
    assert (band.mode, band.line.width, band.fill) == ("lines", 0, "tonexty")  # plotly fills between lines alone
    gap = chart("", Panel([Curve(X, [1.0, np.nan, 1 / 3], digits=(5, 3))])).data[0]
    assert gap.y == (1.0, None, 0.333)


def test_stems_stand_on_their_foot_and_have_one_entry() -> None:
    strokes, heads = chart("", Panel([Stems([1, 2], [5.0, 6.0], foot=-1, name="mode", points=8)])).data
    assert (strokes.x, strokes.y) == ((1, 1, None, 2, 2, None), (-1, 5.0, None, -1, 6.0, None))
    assert (heads.x, heads.y, heads.marker.size) == ((1, 2), (5.0, 6.0), 8)
    assert [(trace.showlegend, trace.legendgroup) for trace in (strokes, heads)] == [(False, "mode"), (True, "mode")]
    level = chart("", Panel([Stems([5.0], ["a"], foot=1, level=True)])).data[0]
    assert (level.x, level.y) == ((1, 5.0, None), ("a", "a", None))


def test_rows_of_a_heat_map_are_its_ordinates() -> None:
    values = np.array([[1.0, np.nan], [3.0, 4.0], [5.0, 6.0]])
    (drawn,) = chart("", Panel([Heat([0.0, 1.0], ["a", "b", "c"], values)], x="mode")).data
    assert (drawn.x, drawn.y, drawn.z[0]) == ((0.0, 1.0), ("a", "b", "c"), [1.0, None])


def test_marks_are_lines_and_bands_in_their_panel_or_in_all() -> None:
    own = Mark(y=1.0, dash="dash", name="limit", words="limit", where={"x": 0.5, "xref": "paper"})
    band = Mark(x=80, to=120, colour="rgba(0,0,0,0.1)", name="band")
    shown = Panel([Curve(X, X)], title="above"), Panel([Curve(X, X), own], title="below")
    drawn = chart("", *shown, marks=[band, Mark(x=100.0, below=True, words="rated", where={"y": 1})])
    found = [(shape.type, shape.x0, shape.x1, shape.xref, shape.yref, shape.layer) for shape in drawn.layout.shapes]
    assert found == [
        ("rect", 80, 120, "x", "y domain", "below"),
        ("line", 100, 100, "x", "y domain", "below"),
        ("line", 0, 1, "x2 domain", "y2", None),
        ("rect", 80, 120, "x2", "y2 domain", "below"),
        ("line", 100, 100, "x2", "y2 domain", "below"),
    ]
    assert [trace.name for trace in drawn.data[2:]] == ["band", "limit"]  # keys, after what is drawn
    assert [trace.mode for trace in drawn.data[2:]] == ["markers", "lines"]
    notes = {note.text: (note.x, note.y, note.yref) for note in drawn.layout.annotations[2:]}
    assert notes == {"rated": (100.0, 1, "y"), "limit": (0.5, 1.0, "y2")}


def test_axes_take_ends_and_more() -> None:
    panel = Panel([Curve(X, X)], x_ends=(0, 2), x_axis={"dtick": 1}, y_axis=FROM_ZERO)
    layout = chart("Title", panel, height=333.4, showlegend=True).layout
    assert (layout.xaxis.range, layout.xaxis.dtick, layout.yaxis.rangemode) == ((0, 2), 1, "tozero")
    assert (layout.title.text, layout.height, layout.showlegend) == ("Title", 333, True)


def test_level_bars_stand_from_the_top_with_room_for_their_texts() -> None:
    bars = Bars(["a", "b"], [-1.0, 3.0], level=True, text=["-1", "3"])
    alone = Bars(["a"], [2.0], level=True, base=[1.0], text=["3"])
    drawn = level_bars("Title", ["a", "b"], Panel([bars], x="change [%]"), Panel([alone]), row=20, room=0.5)
    assert drawn.layout.yaxis.categoryarray == ("b", "a")
    assert drawn.layout.xaxis.range == (-3.0, 5.0)
    assert drawn.layout.xaxis2.range == (0.0, 4.5)
    assert (drawn.layout.height, [(shape.x0, shape.xref) for shape in drawn.layout.shapes]) == (190, [(0, "x")])
    assert (drawn.data[0].orientation, drawn.data[0].textposition, drawn.data[1].base) == ("h", "outside", (1.0,))
    assert drawn.data[0].hovertemplate == "%{y}: %{text}<extra></extra>"
    empty = level_bars("Title", [], Panel([]), nothing="nothing changes")
    assert [note.text for note in empty.layout.annotations] == ["nothing changes"]


def test_looks_in_turn() -> None:
    count = len(PALETTE)
    assert [cycled(i)["dash"] for i in (0, count - 1, count)] == [DASHES[0], DASHES[0], DASHES[1]]
    assert cycled(1, 1) == {"colour": PALETTE[1], "dash": DASHES[1]}


def test_the_example_of_the_design_draws() -> None:
    page = (Path(__file__).parents[4] / "docs/design.md").read_text(encoding="utf-8")
    found = re.search(r"^    def bearing_loads\(.*?(?=^\S)", page, re.MULTILINE | re.DOTALL)
    assert found
    names: dict[str, Any] = {"go": go, "xr": xr, "texts": texts, **vars(renderers)}
    exec(textwrap.dedent(found[0]), names)
    force = xr.DataArray([[0.0, 1e3], [2e3, 3e3]], dims=("bearing", "time"))
    coords = {"bearing": ["sun", "planet"], "time": [0.0, 1.0]}
    drawn = names["bearing_loads"](xr.Dataset({"bearing_force": force}, coords, {"limit": 4e3}))
    assert [trace.name for trace in drawn.data] == ["sun", "planet", "limit"]
    assert (drawn.data[1].y, drawn.layout.shapes[0].y0) == ((2.0, 3.0), 4.0)
    assert drawn.data[0].hovertemplate == "sun: %{y:.4g} kN at %{x:.5g} s<extra></extra>"


def test_names_that_have_room() -> None:
    assert kept_apart([0.0, 1.0, 5.0, 5.5], [3, 0, 1, 2], 1.0) == [3, 0]
    assert kept_apart([0.0, 2.0, 4.0], [0, 1, 2], 1.0, most=2) == [0, 1]
    taken = [(0.0, 0.0, 2.0, 1.0)]
    assert has_room((2.0, 0.0, 2.0, 1.0), taken)  # side by side
    assert has_room((0.5, 1.0, 2.0, 1.0), taken)  # one above the other
    assert not has_room((1.9, 0.9, 2.0, 1.0), taken)
