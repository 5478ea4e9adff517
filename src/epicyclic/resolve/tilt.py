"""Tilt of bodies: which are joined rigidly in tilt, what two bearings at a distance hold, and slices a mesh needs."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ..document.schema_fields import ForceTableOf, LinkTable
from ..train.bodies import Body
from ..train.connections import Link

__all__ = ["SLICES", "held_by_distance", "link_row", "tilt_groups"]

# A mesh of stiffness k and face width b in n equal slices, each a row at its middle, has about mid-face the tilt
# stiffness k b^2/12 (1 - 1/n^2): the least n at which it is right to 1 %.
SLICES = 10
_SPRINGS = {"rx": "y", "ry": "x"}  # tilt -> direction of the springs that hold it at a distance


def held_by_distance(tables: Sequence[LinkTable], branch: int) -> set[str]:
    """Tilts (rx, ry) that the bearings of one site hold by their places: two or more with springs at different `at`.

    Springs k_i along y at the places z_i hold rx with sum k_i z_i^2 about z = 0, springs along x hold ry.

    branch : of the site (0 ..), for stiffnesses per planet.
    """
    return {
        tilt
        for tilt, spring in _SPRINGS.items()
        if len({table.at or 0.0 for table in tables if _presses(getattr(table, spring), branch)}) > 1
    }


def _presses(stated: float | tuple[float, ...] | ForceTableOf | None, branch: int) -> bool:
    """Whether a stated stiffness [N/m], of one planet, is not 0; a list of a wrong length is refused elsewhere."""
    if isinstance(stated, tuple):
        return stated[min(branch, len(stated) - 1)] != 0.0
    return stated is not None and stated != 0.0


def tilt_groups(bodies: Sequence[Body], links: Sequence[Link], misaligned: Collection[str] = ()) -> dict[str, str]:
    """Group of every body, by name: bodies of one group cannot tilt against each other; "" is that of the frames.

    Links of the same two bodies count together, so that two rigid bearings at a distance join them in tilt.  Bodies
    that only a loop over further bodies joins rigidly stand apart.

    misaligned : names of bodies whose seats are tilted, which join them to nothing here.
    """
    group = {body.name: body.name for body in bodies} | {"": ""}
    joined: dict[tuple[str, str], list[Link]] = {}
    for link in links:
        if _seated(link) not in misaligned:
            joined.setdefault((link.first, link.second or ""), []).append(link)
    for (first, second), between in joined.items():
        if group[first] != group[second] and _rigid(between):
            low, high = sorted((group[first], group[second]))  # "" sorts first
            group = {name: low if own == high else own for name, own in group.items()}
    return group


def _seated(link: Link) -> str:
    """Body whose seat a link is; "" of a joint between bodies."""
    if link.kind == "bearing":
        return link.second or link.first
    return {"support": link.first, "shaft": link.second or ""}.get(link.kind, "")


def _rigid(links: Sequence[Link]) -> bool:
    """Whether the rigid directions of links between two bodies leave no tilt of one against the other."""
    if any(math.isinf(link.stiffness[3]) and math.isinf(link.stiffness[4]) for link in links):
        return True
    rows = [link_row(link, d, (0.0, 0.0, 0.0)) for link in links for d in range(6) if math.isinf(link.stiffness[d])]
    if len(rows) < 2:
        return False
    tilts = np.eye(6)[3:5]
    return bool(np.linalg.matrix_rank(np.array(rows)) == np.linalg.matrix_rank(np.array([*rows, *tilts])))


def link_row(link: Link, direction: int, origin: tuple[float, float, float]) -> NDArray[np.float64]:
    """Row [n, r x n] of a direction of a link, or [0, n] of an angle, about an origin [m] of its frame, (6,)."""
    cosine, sine = math.cos(link.angle), math.sin(link.angle)
    normal = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])[direction % 3]
    if direction >= 3:
        return np.concatenate([np.zeros(3), normal])
    return np.concatenate([normal, np.cross(np.subtract((*link.centre, link.station), origin), normal)])
