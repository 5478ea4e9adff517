"""Dataset -> plotly Figure, one file a kind of figure; one palette and one template (`style`).

Depends on: results (the names of variables).  Importing this room imports plotly.
"""

from .bearings import bearing_forces
from .campbell import campbell
from .contact import contact_curves, contact_map
from .contact_loss import contact_sweep
from .curves import curves, study
from .energy import energy_shares
from .envelope import force_envelopes
from .frequencies import frequencies
from .front import train_front
from .loci import loci
from .members import members
from .modulation import modulation
from .phases import orders, phases
from .relief import relief_effect, relief_search
from .section import train_section
from .shapes import mode_shapes
from .sharing import load_history, load_sharing, mesh_forces
from .stability import stability_map, stability_over_speed
from .stiffness import mesh_stiffness
from .sweep import speed_sweep
from .tornado import tornado
from .train_contact import face_loads, load_factors
from .transient import spectrogram, transient_forces
from .waterfall import waterfall

__all__ = [
    "bearing_forces",
    "campbell",
    "contact_curves",
    "contact_map",
    "contact_sweep",
    "curves",
    "energy_shares",
    "face_loads",
    "force_envelopes",
    "frequencies",
    "load_factors",
    "load_history",
    "load_sharing",
    "loci",
    "members",
    "mesh_forces",
    "mesh_stiffness",
    "mode_shapes",
    "modulation",
    "orders",
    "phases",
    "relief_effect",
    "relief_search",
    "spectrogram",
    "speed_sweep",
    "stability_map",
    "stability_over_speed",
    "study",
    "tornado",
    "train_front",
    "train_section",
    "transient_forces",
    "waterfall",
]
