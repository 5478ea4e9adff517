"""Dynamic mesh force over speed: where the train resonates, and what carries the energy there."""

import sys
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import epicyclic

system = epicyclic.assemble(epicyclic.load("ren2021"))
sweep = epicyclic.sweep(system, start=20.0, stop=600.0, points=117)

worst = sweep.mesh_force_rms.max("mesh")
at = int(worst.values.argmax())
RESONANCE = float(sweep.mesh_frequency.values.ravel()[at])  # Hz
modes = epicyclic.modes(system)
nearest = modes.isel(mode=int(np.abs(modes.frequency.values - RESONANCE).argmin()))
PINNED = RESONANCE


def figure() -> go.Figure:
    """Draw the RMS of the dynamic force of every mesh."""
    frequency = sweep.mesh_frequency.values.ravel()
    lines = [go.Scatter(name=str(m), x=frequency, y=sweep.mesh_force_rms.sel(mesh=m).values) for m in sweep.mesh.values]
    return go.Figure(lines).update_layout(xaxis_title="mesh frequency [Hz]", yaxis_title="RMS dynamic mesh force [N]")


if __name__ == "__main__":
    share = nearest.strain_energy_share
    top = share.connection.values[int(share.values.argmax())]
    print(
        f"largest dynamic force at {RESONANCE:.1f} Hz; the nearest mode, at {float(nearest.frequency):.1f} Hz, "
        f"strains {top} most"
    )
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "speed_sweep.html")
