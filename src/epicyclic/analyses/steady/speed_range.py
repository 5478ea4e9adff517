"""Speeds of a sweep: those asked for, or a range about operation or up to the modes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...questions.modes.basis import Modal
from ...questions.modes.campbell import OPERATION, mesh_crossings
from ...system.system import Array
from .response import Response

__all__ = ["SpeedRange", "range_ends", "speeds_of"]

SpeedRange = Literal["operation", "modes"]
"""``operation``: 5 to 130 % of the operating speed.  ``modes``: until the first mesh order has passed every mode."""

# Speeds of a range where nobody says how many: 200 are a smooth curve on a screen; from three mesh frequencies on each
# costs half a second and more.
_POINTS, _POINTS_OF_MANY_TONES = 200, 100
# Speeds closer than this per operating speed are one.
_SAME = 1e-9


def speeds_of(
    ready: Response,
    *,
    mesh_frequency: ArrayLike | None,
    relative_speed: ArrayLike | None,
    speed_range: SpeedRange | None,
    points: int | None,
) -> Array:
    """Relative speeds (P,) [1] of the mesh frequencies of the first mesh [Hz] or relative speeds asked for, else of a
    range.

    Parameters
    ----------
    speed_range : None: ``operation`` where no speeds are given.  points : speeds of the range; None: 200, about
        operation with three mesh frequencies and more 100.

    Raises
    ------
    ModelError : mesh frequencies and relative speeds are given, or a range or points beside either; an unknown range.
    """
    if mesh_frequency is not None and relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    if mesh_frequency is not None or relative_speed is not None:
        for path, given in (("speed_range", speed_range), ("points", points)):
            if given is not None:
                raise ModelError("goes without speeds of one's own", path=path, given=given)
        if relative_speed is not None:
            return np.atleast_1d(np.asarray(relative_speed, dtype=float))
        return np.atleast_1d(np.asarray(mesh_frequency, dtype=float)) / float(ready.lines.tone)
    natural = np.sqrt(ready.modal.squared[~ready.modal.rigid]) / (2 * np.pi)
    tone, tones = float(ready.lines.tone), [float(tone) for tone in ready.lines.tones]
    low, high = range_ends(speed_range or "operation", tone, natural)
    if speed_range != "modes":
        many = len(tones) > 2
        return _about_operation(ready.modal, tones, points or (_POINTS_OF_MANY_TONES if many else _POINTS))
    if not natural.size:
        return np.array([1.0])
    return np.linspace(low, high, points or _POINTS) / tone


def range_ends(speed_range: SpeedRange, tone: float, natural: Array) -> tuple[float, float]:
    """Lowest and highest mesh frequency of a range [Hz].

    Parameters
    ----------
    tone : mesh frequency of the first mesh at the operating speed [Hz].  natural : natural frequencies above zero,
        rising [Hz].

    Raises
    ------
    ModelError : an unknown range.
    """
    if speed_range == "operation":
        return OPERATION[0] * tone, OPERATION[1] * tone
    if speed_range != "modes":
        raise ModelError("unknown choice", path="range", given=speed_range, allowed="operation, modes")
    known = [tone, *natural.tolist()]
    return 0.2 * min(known), 1.2 * max(known)


def _about_operation(modal: Modal, tones: list[float], points: int) -> Array:
    """Relative speeds (points,) [1] about operation: up to half of them where mesh orders meet the modes.

    First the operating speed, then the crossings, low orders first, then the half-power speeds either side of each;
    the others are evenly spaced.
    """
    low, high = OPERATION
    omega = np.sqrt(np.where(modal.rigid, 0.0, modal.squared))
    found = mesh_crossings(omega / (2 * np.pi), tones, low=low, high=high)
    by_order = np.argsort(found.order, kind="stable")
    speed, mode = found.relative_speed[by_order], found.mode[by_order]
    flank = speed * modal.damping[mode] / (2 * omega[mode])
    flanks = np.stack([speed - flank, speed + flank], axis=1).ravel()
    wanted = [1.0, *speed.tolist(), *flanks[(low < flanks) & (flanks < high)].tolist()]
    if points == 1:
        return np.ones(1)
    chosen = wanted[: points // 2]
    speeds = _distinct([*chosen, *np.linspace(low, high, points - len(chosen)).tolist()])
    while len(speeds) < points:  # two of them were one
        widest = int(np.argmax(np.diff(speeds)))
        speeds = np.insert(speeds, widest + 1, (speeds[widest] + speeds[widest + 1]) / 2)
    return speeds


def _distinct(speeds: list[float]) -> Array:
    """Speeds, rising, of those within `_SAME` the first alone."""
    found: dict[int, float] = {}
    for one in speeds:
        found.setdefault(round(one / _SAME), one)
    return np.sort(list(found.values()))
