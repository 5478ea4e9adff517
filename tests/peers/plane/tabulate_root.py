"""Solve the teeth of the table on stress in the roots: python -m tests.peers.plane.tabulate_root

Writes docs/theory/teeth/root.json; three minutes.  Needs CalculiX.  Each entry holds, for three radii of the load [m],
the largest tension and compression along the fillets per load per length [1/m], the lean of the fillet where the
tension is [deg], and the tension by the notch factor of ISO 6336-3 for comparison.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from epicyclic.teeth.form import GearForm, tooth_outline

from .roots import GEARS, fillet_stress, root_form, root_radii

__all__ = ["TARGET", "notch_stress", "root_form", "solved"]

TARGET = Path(__file__).parents[3] / "docs" / "theory" / "teeth" / "root.json"


def notch_stress(gear: GearForm, radius: float) -> float:
    """Tension in the root per load per length [1/m]: bending less compression times Y_S of ISO 6336-3, method B.

    In the section where the tangent of the fillet is at 30 degrees to the middle line, of a ring at 60.
    """
    shape = tooth_outline(gear)
    lean = math.radians(60 if gear.internal else 30)
    at = shape.form + int(np.searchsorted(shape.slope[shape.form :], lean))
    x, y = shape.x, shape.radius * np.cos(shape.psi)
    run = np.hypot(np.gradient(x), np.gradient(y))
    curvature = float(run[at] / np.abs(np.gradient(np.unwrap(shape.slope)))[at])
    psi, gamma = (float(v[0]) for v in shape.flank_angle(np.array([radius + gear.to_virtual])))
    virtual = radius + gear.to_virtual
    down = 1.0 if gear.internal else -1.0
    crossing = virtual * (math.cos(psi) + down * math.sin(psi) * math.tan(gamma))
    arm, thick = abs(crossing - y[at]), 2 * x[at]
    slender, notch = thick / arm, thick / (2 * curvature)
    factor = (1.2 + 0.13 * slender) * notch ** (1 / (1.21 + 2.3 / slender))
    return float(factor * (6 * arm * math.cos(gamma) / thick**2 - math.sin(gamma) / thick))


def solved(name: str) -> list[dict[str, Any]]:
    """Entry of one gear."""
    gear = root_form(name)
    found = []
    for radius in root_radii(gear):
        one = fillet_stress(gear, radius)
        found.append(
            {
                "radius": round(radius, 7),
                "tension": round(1e3 * one.tension, 1),
                "compression": round(1e3 * one.compression, 1),
                "lean": round(one.lean, 1),
                "notch": round(notch_stress(gear, radius), 1),
            }
        )
    return found


def _main() -> None:
    table = {}
    for name in GEARS:
        table[name] = solved(name)
        print(name, *table[name], sep="\n  ")
    TARGET.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _main()
