"""Supports, bearings and couplings of a train as bearings and couplings of a REXS file."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...train.bodies import Link
from ...train.train import Train
from .draft import RIGID, Attributes, Draft, in_unit, place
from .parts import ShaftPart

__all__ = ["add_joints"]

_LEFT_OUT = (
    ("clearance", lambda link: link.clearance > 0, "play"),
    ("exponent", lambda link: link.exponent != 1, "the stiffness at its load is written, not its law"),
    ("friction", lambda link: bool(link.friction), "friction"),
    ("damping", lambda link: any(link.damping), "damping"),
    ("table", lambda link: bool(link.curves), "the nominal stiffness is written, not the table"),
)


def add_joints(
    train: Train, draft: Draft, shafts: Mapping[str, tuple[ShaftPart, int]], pins: Mapping[str, int], casing: int
) -> None:
    """Add a bearing or coupling for each link of a train.

    shafts : body -> its shaft and the id of that.  pins : planet body -> id of its pin.  casing : id of the casing.
    """
    supported: set[str] = set()
    turned: set[str] = set()
    for link in train.links:
        first, number = shafts[link.first]
        second = casing if link.second is None else shafts[link.second][1]
        if number == second:
            continue
        for key, present, text in _LEFT_OUT:
            if present(link):
                draft.drop(f"{link.path}.{key}", text)
        if link.kind == "coupling":
            _joint(draft, link, inner=number, outer=second, turn=link.stiffness[5])
            continue
        carried = first if link.second is None or link.kind == "support" else shafts[link.second][0]
        supported.add(carried.name)
        if link.kind == "bearing":
            at = casing if link.second is None else pins[link.second]
            inner, outer = (number, at) if link.second is None else (at, second)
            _joint(draft, link, inner=inner, outer=outer, turn=0.0)
            continue
        held = first.first.member in train.kinematics.held
        turn = link.stiffness[5]
        if turn > 0 and not held:
            draft.drop(
                f"{link.path}.rz", "would hold the member in the file, and the model does not hold it: left free"
            )
            turn = 0.0
        if turn > 0:
            turned.add(first.name)
        if first.first.centre != link.centre:
            draft.drop(f"{link.path}.radius", "a support off the axis: written there, read back as one on the axis")
        _joint(draft, link, inner=number, outer=second, turn=turn)
    _missing(train, draft, shafts, supported, turned, casing)


def _missing(
    train: Train,
    draft: Draft,
    shafts: Mapping[str, tuple[ShaftPart, int]],
    supported: set[str],
    turned: set[str],
    casing: int,
) -> None:
    """Add rigid bearings of central members without a support, and rigid couplings of held ones that none holds."""
    done: set[int] = set()
    for shaft, number in shafts.values():
        member = shaft.first.member
        if number in done or shaft.first.branch is not None:
            continue
        done.add(number)
        held = member in train.kinematics.held and shaft.name not in turned
        if held or shaft.name not in supported:
            along = 0.0 if shaft.name in supported else math.inf
            stiffness = (along, along, along, along, along, math.inf if held else 0.0)
            link = Link(
                name=f"{member} {'held' if held else 'bearing'}", path=f"stages.{member}.support", kind="support",
                first=shaft.first.name, second=None, station=shaft.station, stiffness=stiffness,
            )  # fmt: skip
            _joint(draft, link, inner=number, outer=casing, turn=stiffness[5])


def _joint(draft: Draft, link: Link, *, inner: int, outer: int, turn: float) -> None:
    """Add one joint: a bearing where it turns freely, else a coupling."""
    radial = _mean(draft, link, 0, 1, "x and y")
    tilt = _mean(draft, link, 3, 4, "rx and ry")
    axial = link.stiffness[2]
    bearing = turn == 0 and link.kind != "coupling"
    attributes: dict[str, tuple[object, str]] = {
        **place(link.station, *link.centre),
        "radial_stiffness": (_stiff(radial, 1.0), "N / m"),
        "axial_stiffness": (_stiff(axial, 1.0), "N / m"),
        "bending_stiffness": (_stiff(tilt, 1e-3), "N mm / rad"),
    }
    if bearing:
        attributes["radial_force_absorption"] = (radial > 0, "none")
        attributes["axial_force_absorption"] = ("both_directions" if axial > 0 else "no_direction", "none")
    else:
        attributes["rotational_stiffness"] = (_stiff(turn, 1e-3), "N mm / rad")
    joint = draft.add("concept_bearing" if bearing else "coupling", link.name, _typed(attributes))
    draft.relate("side", assembly=joint, inner_part=inner, outer_part=outer)


def _typed(attributes: Mapping[str, tuple[object, str]]) -> Attributes:
    """Attributes whose values are those of a file."""
    return attributes  # type: ignore[return-value]


def _mean(draft: Draft, link: Link, a: int, b: int, names: str) -> float:
    """Stiffness across both directions, the mean where they differ: the file has one."""
    first, second = link.stiffness[a], link.stiffness[b]
    if first == second:
        return first
    draft.drop(link.path, f"{names} differ ({first:.6g}, {second:.6g} in SI): the file has one, their mean")
    return (first + second) / 2


def _stiff(value: float, factor: float) -> float:
    """A stiffness in its unit, infinite as programs write rigid."""
    return RIGID if math.isinf(value) else in_unit(value, factor)
