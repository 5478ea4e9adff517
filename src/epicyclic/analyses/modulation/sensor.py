"""Position of the sensor, and the meshes that pass it at which angles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, System, faces

__all__ = ["HOUSING", "SensorPosition", "mesh_stages", "sensor_position"]

HOUSING = "housing"
# Planets count as evenly spaced within this angle [turns]: angles go through degrees and radians.
_EVEN = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorPosition:
    """A sensor and the meshes that pass it.

    stage : of the meshes.  bodies : indices of the bodies under the sensor, none on the housing.
    turn : speed of the stage's axes, exact [rev/s at s = 1].  angle : of the sensor, seen from the housing [rad].
    meshes : (p,) whole meshes in the window.  share : (p,) of their force [1].  contact : (p,) angle in the stage axes
        [rad].
    branches : (N,) of these meshes.  spacing : (N,) angles of the branches [rad].
    teeth : of the ring, with the sign of the direction in which they pass the planets; None where they do not, or are
        no whole number.  others : the same of all central gears at the same mesh frequency, where they are.
    """

    stage: str
    bodies: tuple[int, ...]
    turn: Fraction
    angle: float
    meshes: NDArray[np.int64]
    share: Array
    contact: Array
    branches: tuple[int, ...]
    spacing: Array
    teeth: int | None
    others: tuple[int, ...] = ()

    @property
    def even(self) -> bool:
        """Whether the planets are evenly spaced, and in step with all central gears as they are with the ring."""
        count = len(self.spacing)
        gaps = np.diff(np.sort(self.spacing / (2 * math.pi) % 1.0))
        if self.teeth is not None and any((one - self.teeth) % count for one in self.others):
            return False
        return bool(np.all(np.abs(gaps - 1 / count) < _EVEN))


def sensor_position(
    system: System, *, stage: str | None, body: str | None, angle: float, through_planet: float = 0.0
) -> SensorPosition:
    """Find the meshes of a stage that pass a sensor.

    Parameters
    ----------
    stage : None: the first one whose ring stands still.  body : under the sensor, a body or member of the stage
        that does not turn, or ``housing``; None: the ring.  angle : in the axes of the housing, which are those of the
        stage at t = 0 [rad].  through_planet : share of the other meshes of a branch that its planet passes on [1].

    Raises
    ------
    ModelError : no speeds; no such stage or body; no ring; a body that turns; a number out of range.
    """
    if not math.isfinite(angle):
        raise ModelError("not a finite angle", path="sensor", given=angle)
    if not (math.isfinite(through_planet) and through_planet >= 0):
        raise ModelError("out of range", path="through_planet", given=through_planet, allowed="0 or more")
    if not system.body_turns or not system.meshes.ends:
        raise ModelError(
            "what passes a sensor needs a speed", path="operation.speed", allowed="the speed of one member"
        )
    stage = _stage(system, stage)
    first = faces(system.meshes).first
    homes = mesh_stages(system)
    rings = [w for w, row in enumerate(first) if homes[row] == stage and system.meshes.internal[row]]
    if not rings:
        raise ModelError("this stage has no ring for its planets to pass along", path="stage", given=stage)
    bodies = _bodies(system, stage, body, [system.meshes.ends[first[w]][1] for w in rings])
    own = [w for w in rings if system.meshes.ends[first[w]][1] in bodies] or rings
    angles = {system.meshes.branch[first[w]]: float(system.meshes.direction[first[w]]) for w in own}
    others = _others(system, stage, first, rings, angles) if through_planet else []
    meshes = np.array([*own, *others], np.int64)
    return SensorPosition(
        stage=stage,
        bodies=tuple(system.dofs.bodies.index(name) for name in bodies),
        turn=system.stage_turns[stage],
        angle=angle,
        meshes=meshes,
        share=np.array([1.0] * len(own) + [through_planet] * len(others)),
        contact=np.array([angles[system.meshes.branch[first[w]]] for w in meshes]),
        branches=tuple(angles),
        spacing=np.array(list(angles.values())),
        teeth=_teeth(system, int(first[own[0]]), 1),
        others=_central(system, stage, int(first[own[0]])),
    )


def mesh_stages(system: System) -> tuple[str, ...]:
    """Stage of each mesh row; a stage whose gears turn at two mesh frequencies has two labels in `MeshRows`."""
    return tuple(name.split("/")[0] for name in system.meshes.name)


def _stage(system: System, stage: str | None) -> str:
    """Name of the stage.

    Raises
    ------
    ModelError : no such stage.
    """
    homes = mesh_stages(system)
    known = tuple(dict.fromkeys(homes))
    if stage is not None:
        if stage not in known:
            raise ModelError("no such stage", path="stage", given=stage, allowed=", ".join(known))
        return stage
    turns = _body_turns(system)
    rows = zip(homes, system.meshes.internal, system.meshes.ends, strict=True)
    return next((name for name, internal, ends in rows if internal and turns[ends[1]] == 0), known[0])


def _body_turns(system: System) -> dict[str, Fraction]:
    """Absolute speed of every body, exact [rev/s at s = 1]."""
    return dict(zip(system.dofs.bodies, system.body_turns, strict=True))


def _others(
    system: System, stage: str, first: NDArray[np.int64], rings: list[int], angles: dict[int, float]
) -> list[int]:
    """Whole meshes of the branches that are no ring meshes.  first : (w,) first row of each whole mesh."""
    meshes, homes = system.meshes, mesh_stages(system)
    return [w for w, row in enumerate(first) if w not in rings and homes[row] == stage and meshes.branch[row] in angles]


def _bodies(system: System, stage: str, body: str | None, rings: list[str]) -> tuple[str, ...]:
    """Names of the bodies under the sensor; both halves of a member that is split.

    Raises
    ------
    ModelError : no such central body, or it turns.
    """
    if body == HOUSING:
        return ()
    central = [name for name in system.dofs.bodies if name.split("/")[0] == stage and not _branched(name)]
    wanted = tuple(dict.fromkeys(rings)) if body is None else _named(body, central)
    turns = _body_turns(system)
    still = [name for name in central if turns[name] == 0]
    if not wanted:
        raise ModelError("no such central body", path="body", given=body, allowed=", ".join([*still, HOUSING]))
    if any(turns[name] for name in wanted):
        raise ModelError(
            f"{wanted[0]} turns at {float(60 * turns[wanted[0]]):.6g} rpm: no accelerometer stands still on it",
            path="body",
            given=body or wanted[0],
            allowed=", ".join([*still, HOUSING]),
        )
    return wanted


def _named(body: str, central: list[str]) -> tuple[str, ...]:
    """Bodies of a name, or of a member of that name."""
    return tuple(name for name in central if name == body or name.startswith(f"{body}/"))


def _branched(name: str) -> bool:
    """Whether a body belongs to a branch."""
    return any(part.isdigit() for part in name.split("/"))


def _teeth(system: System, row: int, end: int) -> int | None:
    """Teeth of one end of a mesh from its mesh frequency, negative where they pass the planets clockwise."""
    turns = _body_turns(system)
    passing = turns[system.meshes.ends[row][end]] - system.stage_turns[mesh_stages(system)[row]]
    teeth = system.tones[system.meshes.tone[row]] / passing if passing and system.tones else Fraction(1, 2)
    return int(teeth) if teeth.denominator == 1 else None


def _central(system: System, stage: str, ring: int) -> tuple[int, ...]:
    """Teeth of every central gear of a stage that turns at the mesh frequency of a ring mesh."""
    meshes, homes = system.meshes, mesh_stages(system)
    found = [
        _teeth(system, row, end)
        for row, ends in enumerate(meshes.ends)
        for end, name in enumerate(ends)
        if homes[row] == stage and meshes.tone[row] == meshes.tone[ring] and not _branched(name)
    ]
    return tuple(dict.fromkeys(teeth for teeth in found if teeth is not None))
