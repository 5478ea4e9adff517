"""Natural frequencies of a published planetary set, and where the energy of each mode sits."""

import sys
from pathlib import Path

import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

modes = epicyclic.modes("lin1999-n4")

by_kind = modes.frequency.groupby(modes.mode_kind).count()
elastic = modes.sel(mode=modes.frequency > 0)
LABELS = [
    f"{value:.0f}, mode {mode}" for value, mode in zip(elastic.frequency.values, elastic.mode.values, strict=True)
]
PINNED = float(elastic.frequency[0])  # Hz; Lin and Parker print 727.0 for the lowest translational pair


def figure() -> go.Figure:
    """Draw the share of strain energy in meshes and in bearings and supports, mode by mode."""
    share = elastic.strain_energy_share
    pairs = {part: [name for name in share.connection.values if part in name] for part in ("sun-planet", "planet-ring")}
    pairs["bearings and supports"] = [name for name in share.connection.values if "-" not in name]
    title = f"The lowest modes live in bearings and supports; published {PINNED:.0f} Hz is a translational pair"
    drawn = renderers.figure(title, x="natural frequency [Hz]", y="share of strain energy [1]")
    for part, names in pairs.items():
        drawn.add_bar(name=part, x=LABELS, y=share.sel(connection=names).sum("connection").values)
    return drawn.update_layout(barmode="stack")


if __name__ == "__main__":
    print(by_kind.to_series().to_string())
    for frequency, kind, count in zip(
        modes.frequency.values, modes.mode_kind.values, modes.multiplicity.values, strict=True
    ):
        print(f"{frequency:10.1f} Hz  {kind}  x{count}")
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "published_modes.html")
