"""Rigid bodies and the frames of their coordinates (docs/conventions.md, Axes)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

__all__ = ["DIRECTIONS", "HOUSING", "Body", "Direction", "Frame", "GearData"]

Direction = Literal["x", "y", "z", "rx", "ry", "rz"]
DIRECTIONS: tuple[Direction, ...] = ("x", "y", "z", "rx", "ry", "rz")
HOUSING = "housing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Axes in which the coordinates of the bodies of a stage are written.

    name : stage name, or ``housing``.
    carrier : member with which the frame turns (``main.carrier``), None for a frame at rest.
    """

    name: str
    carrier: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class GearData:
    """The toothed part of a body, as resolved; lengths [m], angles [rad].

    teeth : number of teeth (positive, also of a ring); internal : a ring's teeth.
    module, pressure_angle : normal module and normal pressure angle.
    helix_angle : magnitude; hand : +1 right, -1 left (of the left helix of a herringbone gear), 0 spur.
    face_width : of one helix, None where not given; gap : between the helices of one body.
    herringbone : this body carries both helices.
    base_radius, tip_radius, root_radius, reference_radius : radii [m].
    profile_shift, addendum, dedendum : coefficients [1].
    """

    teeth: int
    internal: bool
    module: float
    pressure_angle: float
    helix_angle: float
    hand: int
    face_width: float | None
    gap: float
    herringbone: bool
    base_radius: float
    tip_radius: float
    root_radius: float
    reference_radius: float
    profile_shift: float = 0.0
    addendum: float = 1.0
    dedendum: float = 1.25


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """One rigid body with up to six degrees of freedom.

    name : ``stage/member[/branch][/side]``, e.g. ``main/planet/2``, ``main/ring/left``; ``[bodies]`` by their own name.
    member : name in the model file, ``main.planet``; all bodies of one member turn at one mean speed.
    kind : sun, planet, ring, carrier, gear or body.
    frame : name of its Frame.  carried_by : body that carries it (of a planet the carrier), None for a central body.
    branch : 1..N of a body on a branch, else None.  side : left, right or None.
    centre : (x, y) place of its origin in frame axes [m].  station : axial place of its origin [m].
    angle : polar angle of its own x axis in frame axes [rad]: 0 for a central body, the polar angle of
        its centre for a body on a branch.
    mass [kg], inertia about z [kg m^2], tilt_inertia about x and y [kg m^2].
    reference_radius : R of the reported base-circle displacement u = R rz [m].
    outer_radius : of a ring whose rim or outer diameter is given [m], else None.
    """

    name: str
    member: str
    kind: str
    frame: str
    carried_by: str | None = None
    branch: int | None = None
    side: str | None = None
    centre: tuple[float, float] = (0.0, 0.0)
    station: float = 0.0
    angle: float = 0.0
    mass: float = 0.0
    inertia: float = 0.0
    tilt_inertia: float = 0.0
    reference_radius: float = 1.0
    outer_radius: float | None = None
    gear: GearData | None = None

    def __repr__(self) -> str:
        """One line: name, kind, teeth and mass."""
        teeth = "" if self.gear is None else f", {self.gear.teeth} teeth"
        mass = f", {self.mass:.4g} kg" if math.isfinite(self.mass) else ""
        return f"Body({self.name!r}, {self.kind}{teeth}{mass})"
