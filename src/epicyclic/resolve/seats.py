"""One link of a model file at its seat: six stiffnesses and dampers, friction, units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..errors import ModelError
from ..model import schema_links as tables
from ..model.units import Quantity
from ..train.bodies import DIRECTIONS, Body
from ..train.connections import Link
from .bodies import member_centre
from .ledger import Ledger, per_branch

__all__ = ["STIFF", "Seat", "link_at"]

Six = tuple[float, float, float, float, float, float]
UNITS = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
STIFF = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Seat:
    """Where a link sits: path in the file, name in results, bodies, branch (0 ..) of `count`, radius of rz in N/m.

    plate : side of the carrier plate it sits in, where there are two.
    """

    path: str
    name: str
    kind: str
    first: Body
    second: str | None
    turn: float
    branch: int = 0
    count: int = 1
    radius: float = 1.0
    share: float = 1.0
    to_housing: bool = False
    plate: str | None = None


def link_at(seat: Seat, name: str, table: tables.Link, rest: Mapping[str, float], ledger: Ledger) -> Link:
    """One link from its table; `rest` is what stands for directions it does not name."""
    path = f"{seat.path}.{name}" if name else seat.path
    carried = seat.kind == "bearing" and seat.second is not None
    station = seat.first.station
    if table.at is not None:
        station = member_centre(seat.first) + table.at
    return Link(
        name=f"{seat.name}/{name}" if name else seat.name,
        path=path,
        kind=seat.kind,
        first=seat.second if carried and seat.second is not None else seat.first.name,
        second=seat.first.name if carried else seat.second,
        centre=seat.first.centre,
        station=station,
        angle=seat.turn,
        stiffness=_six(seat, path, table, rest, ledger),
        damping=_dampers(table, seat.share),
        clearance=per_branch(table.clearance or 0.0, seat.count, f"{path}.clearance")[seat.branch],
        exponent=table.exponent if table.exponent is not None else 1.0,
        load=(table.load or 0.0) * seat.share,
        friction=_friction(table, seat.share),
        to_housing=seat.to_housing,
    )


def _six(seat: Seat, path: str, table: tables.Link, rest: Mapping[str, float], ledger: Ledger) -> Six:
    values = []
    for direction in DIRECTIONS:
        said = getattr(table, direction)
        if said is None:
            value, origin = (
                rest[direction],
                "default" if math.isinf(rest[direction]) or not rest[direction] else "geometry",
            )
            ledger.note(f"{path}.{direction}", value, UNITS[direction], origin)
        else:
            whole = _torsional(said, seat.radius, f"{path}.{direction}") if isinstance(said, Quantity) else said
            value = per_branch(whole, seat.count, f"{path}.{direction}")[seat.branch]
            note = list(whole) if isinstance(whole, tuple) else whole
            ledger.note(f"{path}.{direction}", note, UNITS[direction])
        values.append(value * seat.share if math.isfinite(value) else value)
    x, y, z, rx, ry, rz = values
    return x, y, z, rx, ry, rz


def _torsional(said: Quantity, radius: float, path: str) -> float | tuple[float, ...]:
    """A torsional stiffness in N m/rad; one in N/m acts at a radius."""
    if said.unit == "N m/rad":
        return said.value
    if not math.isfinite(radius):
        raise ModelError("in N/m, but no radius is known", path=path, given=said.value, allowed="a value in N m/rad")
    if isinstance(said.value, tuple):
        return tuple(value * radius**2 for value in said.value)
    return said.value * radius**2


def _dampers(table: tables.Link, share: float) -> Six:
    if table.damping is None:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, rx, ry, rz = ((getattr(table.damping, d) or 0.0) * share for d in DIRECTIONS)
    return x, y, z, rx, ry, rz


def _friction(table: tables.Link, share: float) -> tuple[tuple[str, float | str], ...]:
    if table.friction is None:
        return ()
    pairs = ((key, getattr(table.friction, key)) for key in ("force", "coefficient", "radius", "law"))
    return tuple((key, value * share if key == "force" else value) for key, value in pairs if value is not None)
