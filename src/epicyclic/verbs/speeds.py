"""System of a source with its Train, and the range of speeds of a sweep: from what a person says to frequencies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import ModelError
from .options import MOST_SPEED
from .parsing import mesh_frequency

if TYPE_CHECKING:
    from ..engine.source import Overrides, Source
    from ..questions.response.sweep_table import SpeedRange
    from ..system.system import System
    from ..train.train import Train

SPEED_HINT = 'a speed of a member, e.g. speed.sun = "100 rpm"'


def train_and_system(source: Source, overrides: Overrides | None) -> tuple[Train | None, System]:
    """The Train of a source, None where it is assembled already, and its System."""
    from ..engine.source import system_of, train_of
    from ..system.system import System

    if isinstance(source, System):
        return None, system_of(source, overrides=overrides)
    train = train_of(source, overrides=overrides)
    return train, system_of(train)


def relative(speed: float | str, system: System, train: Train | None) -> float:
    """Speed per operating speed [1] from a number, or a text: a number, or a mesh frequency or speed with its unit.

    Parameters
    ----------
    train : as of `parsing.mesh_frequency`.

    Raises
    ------
    ModelError : no such text, a speed out of range, or one with a unit where the model has no speed.
    """
    if not isinstance(speed, str):
        return speed
    try:
        share = float(speed)
    except ValueError:
        share = _of_operation(speed, system, train)
    if not 0 <= share <= MOST_SPEED:
        allowed = f"0 to {MOST_SPEED} times the operating speed"
        raise ModelError("out of range", path="relative_speed", given=speed, allowed=allowed)
    return share


def _of_operation(speed: str, system: System, train: Train | None) -> float:
    """Speed per operating speed [1] of a mesh frequency or speed with its unit."""
    if not system.tones:
        raise ModelError("is relative to an operating speed", path="operation.speed", given=speed, allowed=SPEED_HINT)
    from ..statics.record import reference_tone

    tone = float(reference_tone(system))
    return mesh_frequency(speed, path="relative_speed", tone=tone, train=train) / tone


def mesh_frequencies(
    system: System,
    train: Train | None,
    start: float | str | None,
    stop: float | str | None,
    points: int,
    speed_range: SpeedRange = "operation",
) -> list[float]:
    """Evenly spaced mesh frequencies of the first mesh (points,) [Hz].

    Parameters
    ----------
    train : as of `parsing.mesh_frequency`.
    start, stop : ends, numbers [Hz] or texts; None: that of the range, or, where an end lies beyond it, of the modes.
    speed_range : as of `range_ends`.

    Raises
    ------
    ModelError : no speed in the model, an end that is no speed, or an empty range.
    """
    import numpy as np

    from ..questions.modes.eigen import eigen
    from ..questions.response.sweep_table import range_ends
    from ..statics.record import reference_tone

    if not system.tones:
        raise ModelError("a sweep needs a speed", path="operation.speed", allowed=SPEED_HINT)
    omega = eigen(system).omega
    natural = omega[omega > 0] / (2 * np.pi)
    tone = float(reference_tone(system))
    low, high = (
        None if end is None else mesh_frequency(end, path=path, tone=tone, train=train)
        for end, path in ((start, "start"), (stop, "stop"))
    )
    first, last = range_ends(speed_range, tone, natural)
    widest = range_ends("modes", tone, natural)
    if low is None:
        low = first if high is None or first <= high else widest[0]
    if high is None:
        high = last if low <= last else max(widest[1], low)
    if not 0 < low <= high:
        raise ModelError(
            "the range is empty", path="start, stop", given=f"{low:g} Hz to {high:g} Hz", allowed="0 < first <= last"
        )
    if points == 1 and start is not None and stop is not None and low < high:
        raise ModelError(
            "one speed is no range", path="points", given=1, allowed="2 or more; or start and stop the same"
        )
    return [float(frequency) for frequency in np.linspace(low, high, points)]
