"""`epicyclic.planetary`, `star` and `differential`: a train in Python from the words of a drawing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ...arguments import checked
from .new_train import new_train
from .wishes import Number

__all__ = ["differential", "planetary", "star"]


@checked
def planetary(
    *,
    teeth: str | Sequence[int] | None = None,
    ratio: float | None = None,
    planets: int = 3,
    speed: Number | None = None,
    torque: Number | None = None,
    power: Number | None = None,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    held: Literal["ring", "sun"] = "ring",
    driver: Literal["sun", "ring", "carrier"] | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A planetary set, its carrier turning: a model document, which `load` and every verb take as a source.

    Quantities are texts with a unit, ``"10 mm"``, or floats in SI.  What is not given is chosen, and listed with its
    reason under ``assumed``; what is given stays.

    Parameters
    ----------
    teeth : sun, planet and ring, ``(21, 39, 99)`` or ``"21/39/99"``; else they are searched for from the ratio.
    ratio : speed of sun per carrier with the ring held, of ring per carrier with the sun held [1]; within 2 %.
    planets : number, equally spaced.
    speed, torque, power : of the driving member, two of the three [rad/s, N m, W].
    module, face_width : normal module and face width [m]; else a preselection from the torque, no strength rating.
    helix_angle, pressure_angle : at the reference circle, normal; [rad], 0 and 20 deg unless given.
    held : the member that does not turn.
    driver : the member that drives; unless given the sun, with the sun held the ring.

    Raises
    ------
    ModelError : a keyword that is missing or contradicts another, teeth that do not assemble (with the nearest that
        do), planets without room.
    """
    given = dict(locals())
    return dict(new_train(kind="planetary", **given).document)


@checked
def star(
    *,
    teeth: str | Sequence[int] | None = None,
    ratio: float | None = None,
    planets: int = 3,
    speed: Number | None = None,
    torque: Number | None = None,
    power: Number | None = None,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    driver: Literal["sun", "ring"] | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A star set, its carrier held: a model document, which `load` and every verb take as a source.

    Keywords, units and errors as of `planetary`; ratio : size of the speed of the sun per ring [1], of either sign.
    """
    given = dict(locals())
    return dict(new_train(kind="star", **given).document)


@checked
def differential(
    *,
    teeth: str | Sequence[int],
    speed: Mapping[str, Number],
    torque: Mapping[str, Number] | None = None,
    power: Mapping[str, Number] | None = None,
    planets: int = 3,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A differential set, no member held: a model document, which `load` and every verb take as a source.

    Keywords, units and errors as of `planetary`, but members are named: speed : of two of sun, ring and carrier
    [rad/s], ``{"sun": "1000 rpm", "carrier": "100 rpm"}``; torque or power : of one of them [N m, W].
    """
    given = dict(locals())
    return dict(new_train(kind="differential", **given).document)
