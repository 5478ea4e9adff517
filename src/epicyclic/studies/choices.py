"""Choices that matter: what a model file says, or leaves to a default, of tilt and of loads along the face."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..train.bodies import Body, Link, Mesh
from ..train.stage_bodies import link_row, tilt_groups
from ..train.train import Train

__all__ = ["Choice", "choices"]

_TILTS = ("rx", "ry")
_NO_LEVER = 1e-12  # [m, or 1 of an angle] rounding of cosines, a lever of no rigid direction


class Choice(NamedTuple):
    """One choice.  path : its key in the file.  origin : given, default, ...  effect : what it does."""

    path: str
    value: str
    origin: str
    effect: str


def choices(train: Train) -> list[Choice]:
    """Of every member what holds its tilt, and of every pair the slices of its meshes, in the order of the file."""
    origins = {value.path: value.origin for value in train.values}
    group = tilt_groups(train.bodies, train.links)
    members: dict[str, Body] = {}
    for body in train.bodies:
        members.setdefault(body.member, body)
    pairs: dict[str, Mesh] = {}
    for mesh in train.meshes:
        pairs.setdefault(mesh.pair, mesh)
    held = [_tilt(train, body, group, origins) for body in members.values()]
    askew = {one.body for one in train.displacements if one.cause == "tilt"}
    apart = tilt_groups(train.bodies, train.links, askew)
    return held + [_slices(mesh, apart, origins) for mesh in pairs.values()]


def _tilt(train: Train, body: Body, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """What holds the tilt of one body, the first of its member: links to what carries it, about its own centre."""
    links = [link for link in train.links if body.name in (link.first, link.second)]
    seats = [link for link in links if link.kind in ("support", "bearing") and _own(link, body)] or links
    path = f"{seats[0].path.rsplit('.bolts', 1)[0]}.tilt" if seats else f"{body.member}.tilt"
    stated = [origins.get(f"{link.path}.{name}", "default") for link in seats for name in _TILTS]
    origin = next((found for found in stated if found not in ("default", "geometry")), "default")
    base = next((other for other in (link.first if link.first != body.name else link.second for link in seats)), None)
    where = base or "its frame"
    if seats and group[body.name] == group[base or ""]:
        return Choice(path, "rigid", origin, f"{body.member} follows {where} in tilt: no degree of freedom")
    about = [sum(_held(link, body)[i] for link in seats) for i in range(len(_TILTS))]
    value = ", ".join(f"{name} {number:.4g} N m/rad" for name, number in zip(_TILTS, about, strict=True))
    places = [link.name.rsplit("/", 1)[-1] for link in seats]
    if not any(about):
        return Choice(path, "free", origin, f"only its meshes, necks and shafts hold {body.member} in tilt")
    if any(any(link.stiffness[3:5]) for link in seats):
        return Choice(path, value, origin, f"{body.member} tilts against {where} on the stiffness of {_and(places)}")
    effect = f"{body.member} tilts against {where}; {_and(places)} hold it by their distance, sum k z^2"
    return Choice(path, value, origin, effect)


def _own(link: Link, body: Body) -> bool:
    """Whether a support or bearing is the body's own seat, not that of what it carries."""
    return body.name == (link.second if link.kind == "bearing" and link.second is not None else link.first)


def _held(link: Link, body: Body) -> tuple[float, float]:
    """Stiffness of one link against tilts of the body about the axes rx and ry of its centre [N m/rad]."""
    place, found = (*body.centre, body.station), [0.0, 0.0]
    cosine, sine = math.cos(body.angle), math.sin(body.angle)
    for direction, stiffness in enumerate(link.stiffness):
        _, _, _, x, y, _ = link_row(link, direction, place)
        for i, lever in enumerate((cosine * x + sine * y, cosine * y - sine * x)):
            if stiffness and abs(lever) > _NO_LEVER:
                found[i] += stiffness * lever**2
    return found[0], found[1]


def _and(names: Sequence[str]) -> str:
    """Names in a sentence, each once."""
    once = list(dict.fromkeys(names))
    return once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"


def _slices(mesh: Mesh, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """Slices of one pair of gears, and what they leave of its tilt stiffness."""
    path, count = f"{mesh.pair}.slices", max(len(mesh.slices), 1)
    origin = origins.get(path, "default")
    if group[mesh.a] == group[mesh.b]:
        return Choice(
            path, str(count), origin, "the gears cannot tilt against each other: the load along the face is even"
        )
    if count == 1:
        return Choice(path, "1", origin, "no stiffness of the mesh against tilt, no load along the face")
    width = count * (mesh.slices[1].station - mesh.slices[0].station)
    tilt = mesh.stiffness * math.cos(mesh.base_helix) ** 2 * width**2 / 12 * (1 - count**-2)
    effect = (
        f"tilt stiffness of the mesh {tilt:.4g} N m/rad in its transverse plane of action, {1e2 / count**2:.2g} % low"
    )
    return Choice(path, str(count), origin, effect)
