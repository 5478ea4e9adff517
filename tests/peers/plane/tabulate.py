"""Solve the pairs of the page on tooth stiffness over a mesh cycle: python -m tests.peers.plane.tabulate

Writes docs/theory/teeth/elements.json, from which docs/theory/teeth/make.py draws; some minutes.  Needs CalculiX.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from .pair import by_elements, elements, spur_pair

TARGET = Path(__file__).parents[3] / "docs" / "theory" / "teeth" / "elements.json"
# teeth, module [m], pressure angle [deg], load per face width [N/m]
PAIRS = {
    "19/20, m 4 mm, 25°, 125 N/mm": ((19, 20), 4e-3, 25.0, 124860.0),
    "27/35, m 3.25 mm, 20°, 200 N/mm": ((27, 35), 3.25e-3, 20.0, 200e3),
}
PLACES = 24


def table() -> dict[str, Any]:
    """Approach over one mesh cycle from the first contact of a pair on, for every pair."""
    found: dict[str, Any] = {}
    for name, (teeth, module, angle, load) in PAIRS.items():
        mesh = spur_pair(teeth, module, angle)
        low, high = mesh.limits
        sigma = np.unique(
            np.concatenate([low + (np.arange(PLACES) + 0.5) / PLACES, [high - 1 - 2e-3, high - 1 + 2e-3]])
        )
        approach = [by_elements(elements(mesh, place, load), load)[0] for place in sigma]
        found[name] = {"teeth": teeth, "module": module, "angle": angle, "load": load}
        found[name] |= {"sigma": np.round(sigma, 6).tolist(), "approach": [float(f"{d:.6g}") for d in approach]}
    return found


if __name__ == "__main__":
    TARGET.write_text(json.dumps(table(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
