"""Teeth that part: what a slow run-up and a slow coast-down meet, and where one jumps to the other."""

import sys
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import epicyclic
from epicyclic.show.charts.over_speed import contact_sweep

MODEL = {
    "format": 2,
    "title": "A spur planetary reducer, lightly loaded",
    "damping": {"modal": 0.02},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
            "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": "25 mm"},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
            "meshes": {"sun-planet": {"backlash": "0.1 mm"}, "planet-ring": {"backlash": "0.1 mm"}},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
}

sweep = epicyclic.sweep(MODEL, contact_loss=True, start=2000.0, stop=2440.0, points=23)
rms = sweep.mesh_force_rms.max("mesh")
apart = np.abs(rms.sel(direction="up") - rms.sel(direction="down")).values
frequency = sweep.mesh_frequency.values
between = frequency[apart > 0.1 * rms.values.max()]
PINNED = float(sweep.fold_frequency.max())  # Hz, where a run-up has to jump


def figure() -> go.Figure:
    """Draw run-up and coast-down."""
    title = f"Between {between.min():.0f} and {between.max():.0f} Hz teeth part or not, as the speed rises or falls"
    return contact_sweep(sweep).update_layout(title_text=title)


if __name__ == "__main__":
    print(f"from {between.min():.0f} to {between.max():.0f} Hz the force depends on where one comes from,")
    print(f"by up to {apart.max():.0f} N RMS; the branch turns back at {PINNED:.1f} Hz")
    if len(sys.argv) > 1:
        figure().write_html(Path(sys.argv[1]) / "contact_loss.html")
