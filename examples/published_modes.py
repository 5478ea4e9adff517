"""Natural frequencies of a published planetary set, and where the energy of each mode sits."""

import sys
from pathlib import Path

import plotly.graph_objects as go

import epicyclic

modes = epicyclic.modes("lin1999-n4")

by_kind = modes.frequency.groupby(modes.mode_kind).count()
elastic = modes.sel(mode=modes.frequency > 0)
PINNED = float(elastic.frequency[0])  # Hz; Lin and Parker print 727.0 for the lowest translational pair


def figure() -> go.Figure:
    """Draw strain-energy shares over the modes."""
    share = elastic.strain_energy_share
    bars = [
        go.Bar(name=str(name), x=elastic.frequency.values, y=share.sel(connection=name).values)
        for name in share.connection.values
    ]
    drawn = go.Figure(bars)
    return drawn.update_layout(barmode="stack", xaxis_title="frequency [Hz]", yaxis_title="share of strain energy")


if __name__ == "__main__":
    print(by_kind.to_series().to_string())
    for frequency, kind, count in zip(
        modes.frequency.values, modes.mode_kind.values, modes.multiplicity.values, strict=True
    ):
        print(f"{frequency:10.1f} Hz  {kind}  x{count}")
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "published_modes.html")
