"""Draw the figures of the pages of this folder, and the picture of the README: python docs/learn/make.py

The model is the one printed on the page first-train.md.  Needs a headless Chromium, as docs/papers/make.py says.
"""

from __future__ import annotations

import importlib.util
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts.over_speed import speed_sweep
from epicyclic.show.drawing.painter import train_front

HERE = Path(__file__).parent
PAGE = HERE / "first-train.md"
LIMIT = 1.3
SAMPLES = 16384  # as on the page
TRAINS: dict[str, dict[str, Any]] = {
    "four planets, pins in 30 µm": {},
    "four planets, pins in 15 µm": {"tolerance": {"deviations.planet.position": "disc(15 um)"}},
}


@cache
def gearbox() -> dict[str, Any]:
    """The model file of the page."""
    (text,) = re.findall(r"<!-- file: gearbox.toml -->\n```toml\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)
    return tomllib.loads(text)


def front() -> go.Figure:
    """The train from the front."""
    return train_front(epicyclic.check(gearbox())).update_layout(title=None)


def decision() -> go.Figure:
    """Share of the trains above K_gamma, of both tolerances."""
    drawn = go.Figure()
    for (name, overrides), dash in zip(TRAINS.items(), ("solid", "dash"), strict=True):
        found = epicyclic.tolerance(gearbox(), overrides=overrides, samples=SAMPLES, effects="none")
        counts = found.system_histogram.sel(definition="mean-load").values
        edges = found.bin_edge.values
        above = 100 * (1 - counts.cumsum() / counts.sum())
        drawn.add_scatter(x=edges[1:], y=above, name=name, mode="lines", line={"width": 3, "dash": dash})
    drawn.add_vline(x=LIMIT, line={"color": "#666", "dash": "dot"}, annotation={"text": f" rated with {LIMIT}"})
    drawn.add_hline(y=1, line={"color": "#666", "dash": "dot"})
    drawn.add_annotation(x=1.8, y=0.05, xanchor="right", yanchor="bottom", text="1 of 100 trains", showarrow=False)
    drawn.update_layout(template="plotly_white", legend={"x": 0.55, "y": 0.95}, margin={"t": 30, "r": 20})
    drawn.update_xaxes(title="mesh-load factor K_gamma [-]", range=[1, 1.8])
    drawn.update_yaxes(title="share of the trains above it [%]", type="log", range=[-1, 2], dtick=1)
    return drawn


def sweep() -> go.Figure:
    """Dynamic factors over speed."""
    return speed_sweep(epicyclic.sweep(gearbox()))


FIGURES = {"front": front, "sweep": sweep, "decision": decision}


def picture(left: str, right: str) -> str:
    """Two drawings beside each other, as one SVG."""
    sizes = [re.search(r'<svg[^>]*?width="([\d.]+)"[^>]*?height="([\d.]+)"', text) for text in (left, right)]
    (w1, h1), (w2, h2) = [(float(one[1]), float(one[2])) for one in sizes if one is not None]
    height = 420
    parts, x = [], 0.0
    cut = 0.14 * w1, 0.64 * w1  # the drawing without its margins
    for text, start, w, h in ((left, cut[0], cut[1], h1), (right, 0, w2, h2)):
        width = w * height / h
        inner = re.sub(r"<svg([^>]*?) width=\"[\d.]+\" height=\"[\d.]+\"", r"<svg\1", text, count=1)
        inner = re.sub(r' viewBox="[^"]*"', "", inner, count=1)
        inner = inner.replace("<svg", f'<svg viewBox="{start:g} 0 {w:g} {h:g}"', 1)
        parts.append(inner.replace("<svg", f'<svg x="{x:.0f}" y="0" width="{width:.0f}" height="{height}"', 1))
        x += width
    body = "\n".join(parts)
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {x:.0f} {height}">\n{body}\n</svg>\n'


def _papers() -> Any:
    spec = importlib.util.spec_from_file_location("papers_make", HERE.parent / "papers" / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    with _papers().renderer() as to_svg:
        made = {name: to_svg(build(), f"first-train-{name}") for name, build in FIGURES.items()}
    for name, text in made.items():
        (HERE / "figures" / f"first-train-{name}.svg").write_text(text, encoding="utf-8")
    (HERE / "figures" / "picture.svg").write_text(picture(made["front"], made["decision"]), encoding="utf-8")
