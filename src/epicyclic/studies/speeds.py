"""Ends of a range of speeds: as a mesh frequency, as the speed of the member that is given, or relative."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..errors import ModelError

if TYPE_CHECKING:
    from ..train.train import Train

__all__ = ["mesh_frequency"]

_ALLOWED = 'a positive mesh frequency, speed or share of the operating speed: "20 Hz", "0.6 kHz", "100 rpm", "50 %"'


def mesh_frequency(value: float | str, *, path: str, tone: float, train: Train | None) -> float:
    """A mesh frequency [Hz] from a number [Hz], or a text with its unit Hz, kHz, rpm or %.

    Parameters
    ----------
    path : what to call it in an error.  tone : mesh frequency at the operating speed [Hz].
    train : says which member rpm means: the first that `operation.speed` gives, and that turns.

    Raises
    ------
    ModelError : no such text, or rpm without a train or a member that turns.
    """
    if not isinstance(value, str):
        return float(value)
    found = re.fullmatch(r"\s*(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)\s*(Hz|kHz|rpm|%)\s*", value)
    if found is None or not 0 < float(found[1]) < 1e9:
        raise ModelError("not a speed", path=path, given=value, allowed=_ALLOWED)
    number, unit = float(found[1]), found[2]
    if unit == "rpm":
        return number / _given_speed(train, path, value) * tone
    return number * {"Hz": 1.0, "kHz": 1e3, "%": tone / 100}[unit]


def _given_speed(train: Train | None, path: str, value: str) -> float:
    """Size of the speed of the first member given that turns [rpm]."""
    speed = {} if train is None else train.kinematics.speed or {}
    operation: Any = None if train is None else train.document.get("operation")
    for member in _members((operation or {}).get("speed") or {}):
        if speed.get(member):
            return abs(float(speed[member]))
    raise ModelError(
        "nothing says which member that is the speed of",
        path=path,
        given=value,
        allowed="a model whose operation.speed gives a member that turns, or Hz, %",
    )


def _members(given: Mapping[str, Any], before: str = "") -> list[str]:
    """Names of the members in the order of the file, ``main.sun``."""
    names: list[str] = []
    for key, value in given.items():
        names += _members(value, f"{before}{key}.") if isinstance(value, Mapping) else [f"{before}{key}"]
    return names
