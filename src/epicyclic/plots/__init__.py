"""Dataset -> plotly Figure, one file a kind of figure; one palette and one template (`style`).

Depends on: results (the names of variables).  Importing this room imports plotly.
"""

from .campbell import campbell
from .contact import contact_curves, contact_map
from .curves import curves, study
from .energy import energy_shares
from .frequencies import frequencies
from .front import train_front
from .members import members
from .modulation import modulation
from .phases import orders, phases
from .section import train_section
from .shapes import mode_shapes
from .sharing import load_history, load_sharing, mesh_forces
from .stability import stability_map, stability_over_speed
from .stiffness import mesh_stiffness
from .sweep import speed_sweep
from .train_contact import face_loads, load_factors

__all__ = [
    "campbell",
    "contact_curves",
    "contact_map",
    "curves",
    "energy_shares",
    "face_loads",
    "frequencies",
    "load_factors",
    "load_history",
    "load_sharing",
    "members",
    "mesh_forces",
    "mesh_stiffness",
    "mode_shapes",
    "modulation",
    "orders",
    "phases",
    "speed_sweep",
    "stability_map",
    "stability_over_speed",
    "study",
    "train_front",
    "train_section",
]
