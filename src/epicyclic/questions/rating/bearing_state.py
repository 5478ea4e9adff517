"""State of rolling bearings under the forces of their links: load zone, stiffness, safety, frequencies of defects.

`life` has it of every load case, `static` under the forces that it finds, `check` under the nominal torques.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...bearings.rolling_bearing import (
    RollingBearing,
    contact_set,
    displacement,
    dynamic_rating,
    load_zone,
    passing_frequencies,
    static_rating,
    static_safety,
)
from ...errors import ConvergenceError
from ...results.dataset import dataset, largest
from ...system.system import Array
from ...train.train import DIRECTIONS, Link, Train
from ...warning_codes import CodedText, coded

Columns = dict[str, tuple[Any, Any]]
State = dict[str, Any]
"""Value of every variable of one bearing at one operating point."""
NO_LOAD = 1e-4  # force per the static rating that is none
_ZONE = ("element_load", "element_angle", "element_pressure", "load_zone_extent", "static_safety")
_FREQUENCIES = ("cage_frequency", "outer_race_frequency", "inner_race_frequency", "element_frequency")


def rolling_links(train: Train) -> list[Link]:
    """Links that are stated by the parts of a rolling bearing."""
    return [link for link in train.links if link.rolling is not None]


def body_turns(train: Train) -> dict[str, float]:
    """Speed of every body in the housing [rev/s]; none where no speed is known."""
    speed = train.kinematics.speed
    return {} if speed is None else {body.name: float(speed.get(body.member, 0)) / 60 for body in train.bodies}


def inner_first(link: Link) -> bool:
    """Whether the first body of the link is on the inner race: not of a planet on a pin in the housing."""
    return link.kind != "bearing" or link.second is not None


def force_rows(link: Link) -> int:
    """How many of the rows x y z rx ry load the elements: five of a link that follows them, three of balls whose z has
    a stiffness, else two."""
    if link.contacts is not None:
        return 5
    return 3 if link.rolling is not None and link.rolling.is_ball and 0 < link.stiffness[2] < np.inf else 2


def inner_force(link: Link, rows: Mapping[str, Array]) -> Array:
    """Force on the inner race (T, 2, 3 or 5) [N, N m], as many rows as `force_rows` has.

    rows : name -> force (T,) of every row of the links, on the first body.
    """
    still = np.zeros_like(next(iter(rows.values()), np.zeros(1)))
    force = np.stack([rows.get(f"{link.name}/{axis}", still) for axis in DIRECTIONS[: force_rows(link)]], axis=1)
    return force if inner_first(link) else -force


def bearing_state(link: Link, force: Array, turns: Mapping[str, float]) -> State:
    """Variables of a bearing under forces as of `inner_force`, of the elements (Z,).

    The load zone is that under the largest force, the stiffness that at the mean one; nan of what forces or speeds that
    are not known would say.  turns : as of `body_turns`.

    Raises
    ------
    ConvergenceError : the bearing cannot carry such a force.
    """
    bearing = link.rolling
    assert bearing is not None
    first, second = (turns.get(name, np.nan) if name else 0.0 for name in (link.first, link.second))
    races = (first, second) if inner_first(link) else (second, first)
    size = np.hypot(force[:, 0], force[:, 1])
    state = dict.fromkeys(_ZONE, np.nan) | {
        "bearing_force_peak": size.max(),
        "race_speed": 2 * np.pi * abs(second - first),
        "bearing_stiffness": _stiffness(bearing, float(size.mean())),
        **dict(zip(_FREQUENCIES, np.abs(passing_frequencies(bearing, *races)), strict=True)),
    }
    if np.isfinite(force).all():
        most = force[largest(np.abs(force).max(axis=1) if force.shape[1] > 2 else size)]
        zone = load_zone(bearing, displacement(bearing, most if len(most) > 2 else [*most, 0.0]))
        values = zone.load[zone.most[0]], zone.angle, zone.pressure, zone.extent, static_safety(bearing, zone)
        state |= dict(zip(_ZONE, values, strict=True))
    return state


def dented(states: Mapping[str, State]) -> list[CodedText]:
    """A warning of bearings, by what names them, whose static safety is below 1 [iso76]."""
    said = [
        f"{name} (static safety {state['static_safety']:.3g}, {state['element_pressure'] / 1e6:.0f} MPa)"
        for name, state in states.items()
        if state["static_safety"] < 1
    ]
    return [coded("races-dented", f"elements dent their races: {', '.join(said)}")] if said else []


def _stiffness(bearing: RollingBearing, load: float) -> float:
    """Radial stiffness at a load [N/m], nan without."""
    if not load > NO_LOAD * static_rating(bearing):
        return np.nan
    return float(contact_set(bearing).tangent(displacement(bearing, [load]))[0, 0])


def state_columns(links: Sequence[Link], states: Sequence[Any], dims: tuple[str, ...] = ("bearing",)) -> Columns:
    """Variables of the states of bearings (b,), or of each in some cases (b, c), and what is of a bearing alone."""
    every, rolling = np.array(states, dtype=object), [link.rolling for link in links if link.rolling is not None]
    most = max((one.elements for one in rolling), default=0)  # others have nan behind their elements
    columns: Columns = {
        "bearing_clearance": ("bearing", [one.clearance for one in rolling]),
        "bearing_rating": ("bearing", [dynamic_rating(one) for one in rolling]),
        "bearing_static_rating": ("bearing", [static_rating(one) for one in rolling]),
    }
    for name in every.flat[0]:
        more = ("element",) if name in _ZONE[:2] else ()
        values = [
            np.append(one[name], [np.nan] * (most - np.size(one[name]))) if more else one[name] for one in every.flat
        ]
        columns[name] = (*dims, *more), np.array(values).reshape(*every.shape, *[most][: len(more)])
    return columns


def with_bearings(result: xr.Dataset, train: Train, rows: Mapping[str, Array]) -> xr.Dataset:
    """A result with the states of all bearings of its train; one that cannot carry its forces has a warning, and nan.

    rows : forces as of `inner_force`.
    """
    links, turns = rolling_links(train), body_turns(train)
    states, said = list[State](), json.loads(result.attrs["warnings"])
    for link in links:
        force = inner_force(link, rows)
        try:
            states.append(bearing_state(link, force, turns))
        except ConvergenceError as error:
            said.append(coded("bearing-overloaded", f"{link.name}: {error}"))
            states.append(bearing_state(link, np.full_like(force, np.nan), turns))
    if not links:
        return result
    said += dented(dict(zip([link.name for link in links], states, strict=True)))
    columns, origin = state_columns(links, states), {value.path: value.origin for value in train.values}
    columns["clearance_origin"] = "bearing", [origin.get(f"{link.path}.internal_clearance", "") for link in links]
    made = dataset(columns, bearing_coords(links, columns), verb=result.attrs["verb"])
    return result.assign_coords(made.coords).assign(made.data_vars).assign_attrs(warnings=json.dumps(said))


def bearing_coords(links: Sequence[Link], columns: Columns) -> dict[Hashable, Any]:
    """Coordinates of the columns: names of the bearings, numbers of the elements."""
    count = columns["element_load"][1].shape[-1]
    return {"bearing": [link.name for link in links], "element": np.arange(1, 1 + count)}
