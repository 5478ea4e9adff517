"""Bolts or pins on a pitch circle: each becomes a link of its own at its place."""

from __future__ import annotations

import math
from dataclasses import replace

from ..model import schema_links as tables
from ..train.connections import Link
from .ledger import Ledger

__all__ = ["bolted"]


def bolted(seat: Link, table: tables.Link, ledger: Ledger) -> list[Link]:
    """A link and its bolts; the link itself only where it holds anything beside them.

    A bolt stands on the circle at its own angle, its x axis radial and its y axis tangential: with stiffness k_r, k_t,
    k_z of one, n >= 3 equal bolts evenly spaced on the radius r hold a member with x and y n (k_r + k_t)/2, rz
    n k_t r^2, z n k_z, rx and ry n k_z r^2/2.  A direction of a bolt that is not named is rigid.
    """
    bolts = table.bolts
    if bolts is None:
        return [seat]
    path = f"{seat.path}.bolts"
    ledger.note(f"{path}.radius", bolts.radius, "m")
    radial, tangential, z = (_stiffness(bolts, key, path, ledger) for key in ("radial", "tangential", "z"))
    angles = bolts.angles
    if angles is None:
        angles = tuple(math.tau * i / (bolts.count or 1) for i in range(bolts.count or 1))
    found = [seat] if any(seat.stiffness) or any(seat.damping) else []
    for number, angle in enumerate(angles, start=1):
        centre = (
            seat.centre[0] + bolts.radius * math.cos(angle),
            seat.centre[1] + bolts.radius * math.sin(angle),
        )
        name = f"{seat.name}/bolts/{number}"
        found.append(
            replace(
                _plain(seat),
                name=name,
                path=path,
                centre=centre,
                angle=angle,
                stiffness=(radial, tangential, z, 0.0, 0.0, 0.0),
            )
        )
    return found


def _plain(seat: Link) -> Link:
    """The place of a link without dampers and laws, which are the seat's own."""
    return Link(
        name=seat.name,
        path=seat.path,
        kind=seat.kind,
        first=seat.first,
        second=seat.second,
        centre=seat.centre,
        station=seat.station,
        stiffness=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        to_housing=seat.to_housing,
    )


def _stiffness(bolts: tables.Bolts, key: str, path: str, ledger: Ledger) -> float:
    value: float | None = getattr(bolts, key)
    ledger.note(f"{path}.{key}", math.inf if value is None else value, "N/m", "default" if value is None else "given")
    return math.inf if value is None else value
