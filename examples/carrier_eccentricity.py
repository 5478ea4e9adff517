"""Load sharing over the eccentricity of the carrier, with and without floating members (ren2021, figure 9, in kind)."""

import sys
from pathlib import Path

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

ECCENTRICITY = [0.0, 20e-6, 40e-6, 60e-6, 80e-6]  # m
TORQUE = {"operation.torque.sun": "28.75 kN m"}  # the torque read as the carrier's
STIFF, SOFT = "1e10 N/m", "1e8 N/m"
FLOATING = {
    "no member": {"sun": STIFF, "carrier": STIFF},
    "sun": {"sun": SOFT, "carrier": STIFF},
    "sun and carrier": {"sun": SOFT, "carrier": SOFT},
}


def static_sharing(system: epicyclic.System) -> float:
    """Return the load-sharing coefficient of the train by cycle peaks over 23 mesh cycles."""
    result = epicyclic.sharing(system, method="static", cycles=23)
    return float(result.system_load_sharing.sel(definition="cycle-peak"))


CURVES = {
    name: epicyclic.vary(
        "ren2021",
        {"deviations.carrier.run_out": ECCENTRICITY},
        quantity=static_sharing,
        overrides={**TORQUE, **{f"stages.main.{member}.support.radial": value for member, value in supports.items()}},
    ).quantity.values
    for name, supports in FLOATING.items()
}
PINNED = float(CURVES["no member"][-1])


def figure() -> go.Figure:
    """Draw the curves."""
    held, floating = (CURVES[name][-1] for name in ("no member", "sun and carrier"))
    title = f"80 µm off centre: a held train loads one planet {held:.2f}-fold, a floating one {floating:.2f}-fold"
    drawn = renderers.figure(title, x="carrier eccentricity [µm]", y="load-sharing coefficient [1]")
    micrometres = [1e6 * value for value in ECCENTRICITY]
    for name, curve in CURVES.items():
        drawn.add_scatter(name=f"floating: {name}", x=micrometres, y=curve)
    return drawn


if __name__ == "__main__":
    for name, curve in CURVES.items():
        print(f"floating: {name:16s}", "  ".join(f"{value:.3f}" for value in curve))
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "carrier_eccentricity.html")
