"""A model of one's own, as a dict: what follows, and what a pin position error does to three and to four planets."""

import sys
from pathlib import Path
from typing import Any

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

MODEL: dict[str, Any] = {
    "format": 2,
    "title": "A planetary reducer with a floating sun",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"radial": 0}},
            "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": "25 mm"},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
    "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}},
}

derived = epicyclic.check(MODEL)
FOUR = {"stages.main.planets": 4, "deviations.planet.position.y": "[20, 0, 0, 0] um"}
LOADED = {
    "3 planets": epicyclic.sharing(MODEL, method="static"),
    "4 planets": epicyclic.sharing(MODEL, overrides=FOUR, method="static"),
}
SHARING = {
    planets: float(result.system_load_sharing.sel(definition="simultaneous")) for planets, result in LOADED.items()
}
PINNED = SHARING["3 planets"]  # a floating sun shares equally among three planets, whatever the errors


def figure() -> go.Figure:
    """Draw the share of every planet."""
    title = f"A floating sun loads three planets alike; of four, one takes {SHARING['4 planets'] - 1:.0%} more"
    drawn = renderers.figure(title, x="planet", y="largest share of the load over the equal one [1]")
    for planets, result in LOADED.items():
        share = result.load_sharing.sel(definition="simultaneous")
        meshes = [mesh for mesh in share.mesh.values if "sun-planet" in mesh]
        drawn.add_bar(name=planets, x=list(range(1, len(meshes) + 1)), y=share.sel(mesh=meshes).values)
    return drawn.update_xaxes(dtick=1)


if __name__ == "__main__":
    print(derived[["speed", "torque", "power"]].to_dataframe().to_string())
    for planets, value in SHARING.items():
        print(f"{planets}: largest share of a planet {value:.3f}")
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "own_model.html")
