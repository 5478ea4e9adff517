"""Draw the figure of the page on tooth stiffness, docs/theory/teeth.md: python docs/theory/teeth/make.py

The finite elements stand in elements.json (see tests/peers/plane/tabulate.py); the curves are computed here.
"""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go

from epicyclic.show.charts.renderers import INK, PALETTE, panels

HERE = Path(__file__).parent
ROOT = HERE.parent.parent.parent


def transmission_error() -> go.Figure:
    """Approach of two gears over a mesh cycle: curves ours, points by finite elements."""
    sys.path.insert(0, str(ROOT))
    from tests.peers.plane.pair import by_energy, spur_pair

    table: dict[str, Any] = json.loads((HERE / "elements.json").read_text(encoding="utf-8"))
    drawn = panels(
        "Loaded transmission error of perfect spur teeth: two pairs, one pair, two pairs",
        [f"teeth {name}" for name in table],
        height=300 * len(table),
        vertical_spacing=0.16,
    )
    for row, given in enumerate(table.values(), start=1):
        mesh = spur_pair(tuple(given["teeth"]), given["module"], given["angle"])
        low, high = mesh.limits
        sigma = np.unique(
            np.concatenate([np.linspace(low + 1e-6, low + 1 - 1e-6, 121), high - 1 + np.array([-1e-6, 1e-6])])
        )
        ours = [1e6 * by_energy(mesh, place, given["load"])[0] for place in sigma]
        shown = row == 1
        line = {"color": PALETTE[0], "width": 2.5}
        drawn.add_scatter(x=sigma, y=ours, name="energy, ring, Weber", line=line, showlegend=shown, row=row, col=1)
        drawn.add_scatter(
            x=given["sigma"],
            y=1e6 * np.array(given["approach"]),
            name="finite elements (CalculiX)",
            mode="markers",
            marker={"color": "white", "size": 8, "line": {"color": INK, "width": 1.8}},
            showlegend=shown,
            row=row,
            col=1,
        )
        drawn.update_yaxes(title_text="approach [µm]", rangemode="tozero", row=row, col=1)
    drawn.update_xaxes(title_text="place of the contact from the pitch point [base pitches]", row=len(table), col=1)
    return drawn


if __name__ == "__main__":
    spec = importlib.util.spec_from_file_location("drives_make", HERE.parent.parent / "papers" / "make.py")
    assert spec is not None
    assert spec.loader is not None
    drives = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(drives)
    with drives.renderer() as to_svg:
        (HERE / "transmission-error.svg").write_text(to_svg(transmission_error(), "teeth"), encoding="utf-8")
