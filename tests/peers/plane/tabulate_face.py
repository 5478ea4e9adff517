"""Solve the teeth of the table on coupling along the face: python -m tests.peers.plane.tabulate_face

Writes docs/theory/teeth/face.json; a quarter of an hour.  Needs CalculiX.  Each entry holds the gear (lengths in m,
angles in degrees), the width of the face, the radius of the load, the compliance under an even load without the
winding of the body (m^2/N), and the coupling between the layers of the face, whose mean is 1.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from epicyclic.teeth import geometry
from epicyclic.teeth.compliance import tooth_compliance
from epicyclic.teeth.form import GearForm

from .solid import SolidMesh, face_compliance

__all__ = ["CASES", "TARGET", "face_case", "form_of", "measured", "solved", "written"]

Array = NDArray[np.float64]

TARGET = Path(__file__).parents[3] / "docs" / "theory" / "teeth" / "face.json"
# name: gear; width per height of the tooth; where on the flank, 0 start of the involute, 1 tip; layers.  `body` is the
# depth of the gear body per root radius, of a ring per module.  `oblique`: the load follows the contact line.
CASES: dict[str, tuple[dict[str, Any], float, float, int]] = {
    "spur 25, narrow": ({"teeth": 25, "module": 4e-3, "body": 0.5}, 1.1, 0.75, 6),
    "spur 25": ({"teeth": 25, "module": 4e-3, "body": 0.5}, 2.4, 0.75, 8),
    "spur 25, load at the root": ({"teeth": 25, "module": 4e-3, "body": 0.5}, 2.4, 0.25, 8),
    "spur 25, wide": ({"teeth": 25, "module": 4e-3, "body": 0.5}, 4.4, 0.75, 12),
    "spur 19, 25 deg, thin hub": (
        {"teeth": 19, "module": 4e-3, "pressure_angle": 25.0, "body": 0.25},
        2.0,
        0.75,
        8,
    ),
    "spur 60, deep body": ({"teeth": 60, "module": 3e-3, "body": 0.7}, 4.0, 0.75, 12),
    "spur 17, shifted, wide": ({"teeth": 17, "module": 5e-3, "profile_shift": 0.4, "body": 0.5}, 6.0, 0.75, 12),
    "helical 25, 20 deg": ({"teeth": 25, "module": 4e-3, "helix_angle": 20.0, "body": 0.5}, 3.0, 0.5, 10),
    "helical 23, 25 deg": (
        {"teeth": 23, "module": 32e-3, "helix_angle": 25.0, "tip_rounding": 0.3, "body": 0.5},
        2.5,
        0.5,
        10,
    ),
    "helical 25, contact line": (
        {"teeth": 25, "module": 4e-3, "helix_angle": 20.0, "body": 0.5, "oblique": True},
        2.0,
        0.5,
        8,
    ),
    "ring 99": ({"teeth": 99, "module": 3.25e-3, "internal": True, "body": 3.5}, 3.0, 0.75, 10),
    "ring 70, thin rim": ({"teeth": 70, "module": 4e-3, "internal": True, "body": 1.5}, 3.0, 0.75, 10),
    "helical ring 99, 15 deg": (
        {"teeth": 99, "module": 3.25e-3, "helix_angle": 15.0, "internal": True, "body": 3.5},
        3.0,
        0.5,
        10,
    ),
}


def face_case(name: str) -> dict[str, Any]:
    """Entry of the table without the elements."""
    given, ratio, share, layers = CASES[name]
    gear: dict[str, Any] = {"pressure_angle": 20.0, "helix_angle": 0.0, "internal": False, "profile_shift": 0.0}
    gear |= {key: value for key, value in given.items() if key not in ("body", "oblique")}
    root = geometry.root_radius(
        gear["teeth"],
        gear["module"],
        math.radians(gear["helix_angle"]),
        internal=gear["internal"],
        profile_shift=gear["profile_shift"],
    )
    gear["bore"] = root + given["body"] * gear["module"] if gear["internal"] else root * (1 - given["body"])
    tooth = tooth_compliance(form_of(gear))
    low, high = tooth.limits[::-1] if gear["internal"] else tooth.limits
    return {
        "gear": gear,
        "width": ratio * tooth.height,
        "radius": low + share * (high - low),
        "oblique": given.get("oblique", False),
        "layers": layers,
    }


def form_of(gear: dict[str, Any]) -> GearForm:
    """Gear of an entry, angles in degrees."""
    angles = {key: math.radians(gear[key]) for key in ("pressure_angle", "helix_angle")}
    return GearForm(**gear | angles)


def measured(entry: dict[str, Any], matrix: Array) -> dict[str, Any]:
    """Entry with the compliance (n, n) [m/N] of its layers by the elements."""
    form = form_of(entry["gear"])
    slant = math.cos(geometry.base_helix_angle(form.pressure_angle, form.helix_angle))
    length = entry["width"] / slant
    own = 0.5 * (matrix + matrix.T) - tooth_compliance(form).shared / length
    mean = own.mean()
    rows = [[float(f"{value:.4g}") for value in row] for row in own / mean]
    return entry | {"even": float(f"{mean * length:.4g}"), "coupling": rows}


def solved(name: str) -> dict[str, Any]:
    """Entry of the table by the elements."""
    entry = face_case(name)
    mesh = SolidMesh(layers=entry["layers"])
    gear = form_of(entry["gear"])
    found = face_compliance(gear, entry["width"], entry["radius"], mesh=mesh, oblique=entry["oblique"])
    return measured(entry, found.matrix * 1e-3)


def written(entries: dict[str, Any]) -> str:
    """Entries as text, one row of a matrix a line."""
    text = json.dumps(entries, indent=1)
    return re.sub(r"\[[^\[\]]*\]", lambda row: " ".join(row[0].split()), text) + "\n"


if __name__ == "__main__":
    TARGET.write_text(written({name: solved(name) for name in CASES}), encoding="utf-8")
