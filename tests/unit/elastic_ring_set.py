"""Lin & Parker's sets with the ring of the paper as a thin ring of steel, 25.4 mm wide, which bends."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import epicyclic
from epicyclic.train.train import Train

RADIUS = 0.13752 * math.sqrt(3 / 2.35)  # I/m of the printed ring [m]
HEIGHT = 2.35 / (2 * math.pi * RADIUS) / 7850 / 0.0254
BENDING = 2.07e11 * 0.0254 * HEIGHT**3 / 12
ELASTIC = {"radius": f"{RADIUS} m", "bending": f"{BENDING} N m^2"}
AXIAL = f"{2.07e11 * 0.0254 * HEIGHT} N"


@cache
def ring_set(planets: int, *, orders: int = 12, stretches: bool = False) -> Train:
    """The set of so many planets; of six with the teeth of that of four."""
    table: dict[str, Any] = ELASTIC | {"modes": orders} | ({"axial": AXIAL} if stretches else {})
    over: dict[str, Any] = {"stages.main.ring.base_radius": "137.52 mm", "stages.main.ring.elastic": table}
    if planets == 6:
        over["stages.main.planets"] = 6
    return epicyclic.load(f"lin1999-n{4 if planets == 6 else planets}", over)
