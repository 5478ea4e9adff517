"""A train whose planets cannot be equally spaced: the nearest buildable angles, and what they cost in load sharing."""

import json
import sys
from pathlib import Path

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

BUILDABLE = "[0, 121.5, 238.5] deg"
NO_ERRORS = {"deviations": None}

warnings = json.loads(epicyclic.check("ren2021").attrs["warnings"])
SPACED = {
    "equal spacing": epicyclic.sharing("ren2021", overrides=NO_ERRORS),
    f"at {BUILDABLE}": epicyclic.sharing("ren2021", overrides={**NO_ERRORS, "stages.main.planet_angles": BUILDABLE}),
}
SHARING = {name: float(result.system_load_sharing.sel(definition="simultaneous")) for name, result in SPACED.items()}
PINNED = SHARING[f"at {BUILDABLE}"]


def figure() -> go.Figure:
    """Draw the mean load of every sun-planet mesh."""
    title = f"Angles that can be built load one planet by {PINNED - 1:.1%} more, without any error"
    drawn = renderers.figure(title, x="mesh", y="load-sharing coefficient [1]")
    for name, result in SPACED.items():
        share = result.load_sharing.sel(definition="simultaneous")
        meshes = [mesh for mesh in share.mesh.values if "sun-planet" in mesh]
        drawn.add_scatter(name=name, x=meshes, y=share.sel(mesh=meshes).values, mode="markers", marker_size=12)
    return drawn.add_hline(1.0, line_dash="dot")


if __name__ == "__main__":
    for warning in warnings:
        print("warning:", warning)
    for name, value in SHARING.items():
        print(f"{name}: {value:.4f} without any error")
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "planet_spacing.html")
