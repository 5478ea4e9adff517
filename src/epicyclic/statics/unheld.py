"""Loads along motions that nothing holds: which member, in which direction, and how much.  Derived here.

The motions without stiffness are the null space N of the mean stiffness; a load F works on them with w = N'F.  Holding
the coordinates D takes the reactions with N_D' reactions = w, if there are any.  A turning train is such a motion too,
but torques in equilibrium do not work on it; a helical gear that can slide along its axis is another, a screw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..system.system import Array, System
from ..warning_codes import CodedText, code_of, coded

# Part of the work that reactions may leave: the null space has an error of 1e-10, radii that are printed one of 1e-4.
_WORK_LEFT = 1e-6
# Load that counts, per the largest: torques written with six digits leave 1e-6 of themselves.
_SMALL = 1e-5


@dataclass(frozen=True, slots=True, kw_only=True)
class Unheld:
    """A coordinate that nothing holds against a load.

    name : of the coordinate, ``main/sun/z``.  load : along it [N, N m].
    """

    name: str
    load: float

    @property
    def key(self) -> str:
        """Path of the key of the model file that holds it: ``stages.main.sun.support.z``."""
        *body, direction = self.name.split("/")
        group = {"x": "radial", "y": "radial", "z": "z"}.get(direction, "tilt")
        if len(body) == 1:
            return f"bodies.{body[0]}.support.{group}"
        carried = any(part.isdigit() for part in body)
        return f"stages.{body[0]}.{body[1]}.{'bearing' if carried else 'support'}.{group}"

    def __str__(self) -> str:
        """Body, direction and load in words."""
        body, _, direction = self.name.rpartition("/")
        if direction == "z":
            return f"the thrust of {abs(self.load) / 1e3:.4g} kN on {body}"
        if direction in ("x", "y"):
            return f"the force of {abs(self.load) / 1e3:.4g} kN along {direction} on {body}"
        return f"the moment of {abs(self.load):.4g} N m about {direction[1:]} on {body}"


def unheld(free: Array, force: Array, names: Sequence[str]) -> tuple[Unheld, ...]:
    """Coordinates whose holding would take the load along free motions, as few as possible.

    Parameters
    ----------
    free : (n, r) motions without stiffness.  force : (n,) load [N, N m].  names : of the n coordinates.

    Returns
    -------
    Coordinates with their loads; none where the load balances, and where it is a torque about the axes that does not.
    """
    work = free.T @ force
    size = float(np.max(np.abs(force), initial=0.0))
    if not free.size or not np.linalg.norm(work) > _SMALL * size * float(np.max(np.abs(free))):
        return ()
    turns = np.array([name.endswith("/rz") for name in names])
    carried = np.array([any(part.isdigit() for part in name.split("/")) for name in names])
    if _reactions(free, work, turns, most=1):
        return ()
    reactions = _reactions(free, work, ~turns & ~carried) or _reactions(free, work, ~turns)
    return tuple(Unheld(name=names[i], load=load) for i, load in reactions.items())


def unheld_error(coordinates: Sequence[Unheld]) -> ModelError:
    """What to raise where coordinates are not held against the load; there is at least one."""
    keys = list(dict.fromkeys(coordinate.key for coordinate in coordinates))
    return ModelError(
        f"nothing takes {', '.join(map(str, coordinates))}",
        path=keys[0],
        given=0,
        allowed=f"a stiffness in {', '.join(keys)}, or no such key: a direction that is not named is rigid",
    )


def contradicting_radii(system: System) -> str:
    """What the train says of base radii that miss the teeth, "" where they do not: no torque balances on such radii."""
    return "; ".join(text for text in system.warnings if code_of(text) == "base-radius-far")


def standing_load(system: System) -> Array:
    """Load (n,) [N, N m] that stands still in the frame of its stage: torques, gravity and lines that do not turn."""
    still = (line.force[0].real for line in system.lines if line.frequency == 0)
    force: Array = system.force + sum(still, np.zeros(len(system.force)))
    return force


def unheld_warnings(system: System, free: Array) -> list[CodedText]:
    """Warning of a mean load that works on motions without stiffness (n, r), one text at most."""
    force = standing_load(system)
    if not force.any():
        return []
    coordinates = unheld(free, force, system.dofs.names)
    return [coded("load-not-held", str(unheld_error(coordinates)))] if coordinates else []


def _reactions(free: Array, work: Array, offered: NDArray[np.bool_], most: int | None = None) -> dict[int, float]:
    """Reaction of each coordinate, out of those offered (n,), that together take the work (r,); empty without any.

    One coordinate after the other, that which the rest of the work is closest to in direction.
    """
    length = np.linalg.norm(free, axis=1)
    usable = np.flatnonzero(offered & (length > _WORK_LEFT * float(np.max(length, initial=0.0))))
    chosen: list[int] = []
    rest = np.asarray(work)
    while usable.size and len(chosen) < (most or free.shape[1]):
        along = np.abs(free[usable] @ rest) / length[usable]
        chosen.append(int(usable[int(np.argmax(along))]))
        reaction = np.linalg.lstsq(free[chosen].T, work, rcond=None)[0]
        rest = np.asarray(work - free[chosen].T @ reaction)
        if np.linalg.norm(rest) <= _WORK_LEFT * np.linalg.norm(work):
            return dict(zip(chosen, map(float, reaction), strict=True))
        usable = usable[~np.isin(usable, chosen)]
    return {}
