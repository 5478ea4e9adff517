"""Dynamic mesh force over speed: where the train resonates, and what carries the energy there."""

import sys
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts import renderers

system = epicyclic.assemble(epicyclic.load("ren2021"))
sweep = epicyclic.sweep(system, start=20.0, stop=600.0, points=117)

worst = sweep.mesh_force_rms.max("mesh")
at = int(worst.values.argmax())
RESONANCE = float(sweep.mesh_frequency.values.ravel()[at])  # Hz
modes = epicyclic.modes(system)
nearest = modes.isel(mode=int(np.abs(modes.frequency.values - RESONANCE).argmin()))
OPERATION = float(epicyclic.check("ren2021").mesh_frequency[0])  # Hz
PINNED = RESONANCE


def figure() -> go.Figure:
    """Draw the largest RMS dynamic force of all meshes, and where the train operates."""
    title = f"Resonance at {RESONANCE:.0f} Hz: {float(worst[at]) / 1e3:.0f} kN in the worst mesh"
    drawn = renderers.figure(title, x="mesh frequency [Hz]", y="RMS dynamic force of the worst mesh [kN]")
    drawn.add_scatter(x=sweep.mesh_frequency.values.ravel(), y=worst.values / 1e3, showlegend=False)
    drawn.add_vline(OPERATION, line_dash="dot", annotation_text="operation")
    return drawn.add_vline(float(nearest.frequency), line_dash="dash", annotation_text="natural frequency")


if __name__ == "__main__":
    share = nearest.strain_energy_share
    top = share.connection.values[int(share.values.argmax())]
    print(
        f"largest dynamic force at {RESONANCE:.1f} Hz; the nearest mode, at {float(nearest.frequency):.1f} Hz, "
        f"strains {top} most"
    )
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "speed_sweep.html")
