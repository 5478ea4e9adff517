"""Stress along the fillets of a spur gear in plane strain by finite elements, solved with CalculiX.

The whole gear is meshed, every tooth of it, in eight-noded cells with reduced integration, the loaded tooth finely down
to the middle of its spaces (`gear`).  The stress is that of the solver, extrapolated from the Gauss points and averaged
at the nodes, taken along the fillet.  Units are those of the solver: mm, N, MPa, thickness 1 mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from epicyclic.teeth import geometry
from epicyclic.teeth.form import GearForm, tooth_outline

from .gear import Fineness, Load, calculix, gear_mesh, held_nodes, pressed

__all__ = ["GEARS", "FilletStress", "fillet_stress", "root_form", "root_radii"]

Array = NDArray[np.float64]

# teeth, module [mm], pressure angle [deg], internal, profile shift, fillet radius [modules]
GEARS: dict[str, tuple[int, float, float, bool, float, float | None]] = {
    "19 teeth, 25 deg": (19, 4.0, 25.0, False, 0.0, None),
    "27 teeth, 20 deg": (27, 3.25, 20.0, False, 0.0, None),
    "35 teeth, shift 0.4": (35, 3.25, 20.0, False, 0.4, None),
    "60 teeth, sharp fillet": (60, 3.0, 20.0, False, 0.0, 0.2),
    "ring 99": (99, 3.25, 20.0, True, 0.0, None),
    "ring 77, 25 deg": (77, 4.0, 25.0, True, 0.0, None),
}
# A mesh two thirds as fine gives the largest tension within 1 %.
_FINE = Fineness(tooth=(48, 24, 24), body=24, first=0.12)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilletStress:
    """Largest tension of the fillet below the loaded flank and largest compression of the other, per load [1/mm], with
    the lean of the fillet where the tension is [deg]."""

    tension: float
    lean: float
    compression: float


def root_form(name: str) -> GearForm:
    """Gear with a hub of half the root diameter, or a rim of 3.5 modules."""
    teeth, module, angle, internal, shift, rounding = GEARS[name]
    m = module * 1e-3
    root = geometry.root_radius(teeth, m, 0.0, internal=internal, profile_shift=shift)
    return GearForm(
        teeth=teeth,
        module=m,
        pressure_angle=math.radians(angle),
        internal=internal,
        profile_shift=shift,
        tip_rounding=rounding,
        bore=root + 3.5 * m if internal else 0.5 * root,
    )


def root_radii(gear: GearForm) -> tuple[float, float, float]:
    """Three radii of the load [m]: a quarter of the way from the fillet to the tip, half of it, 95 %."""
    shape = tooth_outline(gear)
    start, end = shape.form_radius - gear.to_virtual, gear.tip
    low, middle, high = (start + part * (end - start) for part in (0.25, 0.5, 0.95))
    return low, middle, high


def fillet_stress(gear: GearForm, radius: float, *, fine: Fineness = _FINE) -> FilletStress:
    """Stress per load at a radius [m]; its pressure is elliptic over a fifth of a module.

    Raises
    ------
    FileNotFoundError : no solver on this machine.
    """
    shape = tooth_outline(gear)
    load = Load(tooth=0, radius=1e3 * radius, half_width=1e2 * gear.module)
    points, cells, places = gear_mesh(gear, shape, [load], fine)
    force = pressed(points, places[0], shape, load)
    (stress,) = calculix(points, cells, held_nodes(points, gear), [force], gear, stresses=True)
    line = np.column_stack([shape.x, shape.radius * np.cos(shape.psi)])[shape.form :] * 1e3
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    even = np.linspace(0.0, along[-1], 8001)
    line = np.column_stack([np.interp(even, along, line[:, axis]) for axis in (0, 1)])
    found = []
    for side in (1.0, -1.0):
        fillet = line * [side, 1.0]
        apart, at = cKDTree(fillet).query(points)
        on = np.flatnonzero(apart < 1e-3 * gear.module * 1e3)  # on the polygon of the outline, or beside its chords
        tangent = np.gradient(fillet, even, axis=0)[at[on]]
        x, y = (tangent / np.hypot(*tangent.T)[:, None]).T
        own = stress[on, 0] * x**2 + stress[on, 1] * y**2 + 2 * stress[on, 2] * x * y
        found.append((own, np.degrees(np.arctan2(np.abs(x), np.abs(y)))))
    (right, lean), (left, _) = found
    return FilletStress(tension=float(right.max()), lean=float(lean[right.argmax()]), compression=float(left.min()))
