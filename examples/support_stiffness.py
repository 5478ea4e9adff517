"""Load sharing over the lateral support stiffness of sun, ring and carrier (ren2021, figure 12, in kind)."""

import sys
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

STIFFNESS = np.array([1e8, 3e8, 1e9, 3e9, 1e10, 1.5e10])  # N/m
# the torque read as the carrier's: 28.75 kN m on the sun; see the notes in the model file
BASE = {"operation.torque.sun": "28.75 kN m"}


def static_sharing(system: epicyclic.System) -> float:
    """Return the load-sharing coefficient of the train by cycle peaks over 23 mesh cycles."""
    result = epicyclic.sharing(system, method="static", cycles=23)
    return float(result.system_load_sharing.sel(definition="cycle-peak"))


CURVES = {
    member: epicyclic.vary(
        "ren2021",
        {f"stages.main.{member}.support.radial": list(map(float, STIFFNESS))},
        quantity=static_sharing,
        overrides=BASE,
    ).quantity.values
    for member in ("sun", "ring", "carrier")
}
PINNED = float(CURVES["carrier"][-1])


def figure() -> go.Figure:
    """Draw the three curves."""
    most = max(CURVES, key=lambda member: CURVES[member][-1])
    title = f"A stiff {most} costs most: load sharing {CURVES[most][0]:.2f} → {CURVES[most][-1]:.2f}"
    drawn = renderers.figure(title, x="support stiffness [N/m]", y="load-sharing coefficient [1]")
    for member, curve in CURVES.items():
        drawn.add_scatter(name=member, x=STIFFNESS, y=curve)
    return drawn.update_xaxes(type="log", dtick=1, exponentformat="power")


if __name__ == "__main__":
    for member, curve in CURVES.items():
        print(f"{member:8s}", "  ".join(f"{value:.3f}" for value in curve))
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "support_stiffness.html")
