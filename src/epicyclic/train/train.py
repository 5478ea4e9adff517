"""The resolved train: frozen data with nothing left implicit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..warning_codes import CodedText
from .bodies import Body, Frame
from .connections import Link, Mesh
from .display import driving_member, train_html
from .kinematics import Kinematics
from .power import PowerPath

__all__ = ["Damping", "Derived", "Displacement", "Load", "MeshError", "Train"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Displacement:
    """A displaced feature of one body: run-out, pin position, bearing eccentricity, tilt.

    path : of its entry in the model file.  cause : its kind of deviation, a key of `deviations`.
    body : the body that the file names.
    rows : which gaps the feature enters, and through which body (docs/conventions.md, Forces, stiffness, errors):
        ``mesh``  every mesh row of `body`, through `body`'s columns (run-out of a gear);
        ``own``   the rows of the links in `links`, through `body`'s columns (bearing run-out; of a carrier: its pins);
        ``seat``  the rows of the links in `links`, through the columns of the other body, or of the frame
                  (position and tilt: the seat of `body` is displaced).
    links : names of those links.
    vector : (6,) complex, E(t) = Re(vector exp(2 pi i frequency t)) in the axes of `body`; x y z [m], rx ry rz [rad].
    frequency : exact, signed, in the frame of `body` [Hz at the operating speed]; 0 = at rest there.
    """

    path: str
    cause: str
    body: str
    rows: Literal["mesh", "own", "seat"]
    links: tuple[str, ...] = ()
    vector: NDArray[np.complex128]
    frequency: Fraction

    def __repr__(self) -> str:
        """One line: place in the file, body, largest amplitude and frequency."""
        size = float(np.abs(self.vector).max(initial=0.0))
        return f"Displacement({self.path!r} of {self.body!r}, {size:.4g} at {float(self.frequency):.5g} Hz)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshError:
    """A scalar error of one mesh, along the tooth normal: profile, gap, turning error, a harmonic of a pitch deviation.

    e(t) = Re(amplitude exp(2 pi i frequency t)) [m], positive = material missing.  cause : profile, gap, errors, pitch;
    contact where it is that of loaded contact (`Mesh.table`).  far : on the far flank, which a mesh without backlash
    has not.
    """

    path: str
    cause: str
    mesh: str
    amplitude: complex
    frequency: Fraction
    far: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Load:
    """An external force and moment on one body at one axial place.

    force [N], moment [N m] : (3,) real, in housing axes (``turns`` False: fixed in space) or in the axes of the
    body turning with it (``turns`` True).  station : axial place of the point in the train [m].
    Unbalance is a Load with ``speed_squared`` True: force holds amount * w^2 at the operating speed.
    """

    path: str
    body: str
    force: tuple[float, float, float]
    moment: tuple[float, float, float]
    station: float
    turns: bool
    phase: float = 0.0
    speed_squared: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Damping of the whole train.  modal : ratio of every elastic mode [1].  mass [1/s], stiffness [s] : proportional.
    mesh : ratio of every mesh [1].  None = not given."""

    modal: float | None = None
    mass: float | None = None
    stiffness: float | None = None
    mesh: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Derived:
    """One resolved value and its origin: given, stage, as <gear>, geometry, default, assumed, set."""

    path: str
    value: object
    unit: str
    origin: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Train:
    """A whole train, resolved.

    torques : external torque on each body that carries one, held members and balancing ends left out
        (their reaction follows) unless they are free ends [N m], by body name.
    gravity : (3,) acceleration in housing axes [m/s^2].
    values : every resolved value with its origin, in file order.
    document : the file with overrides laid over it, shorthands expanded (provenance).
    planets : number of branches of each stage.
    power_paths : power through every coupling, shaft and pair that meshes; empty without speeds and torques.
    """

    title: str
    frames: tuple[Frame, ...]
    bodies: tuple[Body, ...]
    meshes: tuple[Mesh, ...]
    links: tuple[Link, ...]
    kinematics: Kinematics
    planets: Mapping[str, int]
    torques: Mapping[str, float] = field(default_factory=dict)
    power_paths: tuple[PowerPath, ...] = ()
    displacements: tuple[Displacement, ...] = ()
    mesh_errors: tuple[MeshError, ...] = ()
    loads: tuple[Load, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    damping: Damping = Damping()
    warnings: tuple[CodedText, ...] = ()
    values: tuple[Derived, ...] = ()
    assumed: Mapping[str, str] = field(default_factory=dict)
    document: Mapping[str, object] = field(default_factory=dict)
    doi: str = ""
    notes: str = ""

    def __repr__(self) -> str:
        """One line: title, stages with their planets, counts, and the driving member with speed and torque."""
        stages = ", ".join(f"{stage} ({count} planets)" for stage, count in self.planets.items())
        counts = f"{len(self.bodies)} bodies, {len(self.meshes)} meshes, {len(self.links)} links"
        driver, kinematics = driving_member(self), self.kinematics
        turns = None if kinematics.speed is None or driver is None else kinematics.speed[driver]
        torque = None if kinematics.torque is None or driver is None else kinematics.torque[driver]
        numbers = ([] if turns is None else [f"{float(turns):.5g} rpm"]) + ([f"{torque:.5g} N m"] if torque else [])
        driven = f"; {driver} {', '.join(numbers)}" if numbers else ""
        return f"Train({self.title!r}: {stages}; {counts}{driven})"

    def _repr_html_(self) -> str:
        """Front views and key numbers, for notebooks."""
        return train_html(self)
