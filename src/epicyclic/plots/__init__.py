"""Dataset -> plotly Figure, one file a kind of figure; one palette and one template (`style`).

Depends on: results (the names of variables).  Importing this room imports plotly.
"""

from .campbell import campbell
from .curves import curves, study
from .energy import energy_shares
from .envelope import force_envelopes
from .frequencies import frequencies
from .front import train_front
from .members import members
from .phases import orders, phases
from .section import train_section
from .shapes import mode_shapes
from .sharing import load_history, load_sharing, mesh_forces
from .stiffness import mesh_stiffness
from .sweep import speed_sweep

__all__ = [
    "campbell",
    "curves",
    "energy_shares",
    "force_envelopes",
    "frequencies",
    "load_history",
    "load_sharing",
    "members",
    "mesh_forces",
    "mesh_stiffness",
    "mode_shapes",
    "orders",
    "phases",
    "speed_sweep",
    "study",
    "train_front",
    "train_section",
]
