"""Readers of options: texts of a person to numbers in SI.

Texts are speeds and their ranges, times, relative loads, torque steps, settings.  Errors carry the keyword of the verb
as path; the command line puts its flag there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from ..document.units import Bounds, read_quantity, stated
from ..errors import ModelError
from ..options import MOST_SPEED, Option

if TYPE_CHECKING:
    from ..engine.source import Drive
    from ..questions.response.sweep_table import SpeedRange
    from ..train.train import Train

_NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
_UNIT = r"([A-Za-z%°µ].*?)"
SPEED_HINT = 'a speed of a member, e.g. speed.sun = "100 rpm"'
_SPEED = 'a positive mesh frequency, speed or share of the operating speed: "20 Hz", "0.6 kHz", "100 rpm", "50 %"'
_MOST_LOAD = 10_000  # per operating load: beyond any drive; squares of much more are no numbers
# short circuits of generators and jammed mills reach some ten times the rated torque; a hundred times that is a slip
_LARGEST_FACTOR = 1000.0
_HERTZ = {"Hz": 1.0, "kHz": 1e3}


def mesh_frequency(value: float | str, *, path: str, tone: float, train: Train | None) -> float:
    """A mesh frequency [Hz] from a number [Hz], or a text with its unit Hz, kHz, rpm or %.

    Parameters
    ----------
    path : keyword, for an error.  tone : mesh frequency at the operating speed [Hz].
    train : says which member rpm means: the first that `operation.speed` gives, and that turns.

    Raises
    ------
    ModelError : no such text, a text without a unit, or rpm without a train or a member that turns.
    """
    if not isinstance(value, str):
        return float(value)
    number, unit = _quantity(value, ("Hz", "kHz", "rpm", "%"), path)
    if not 0 < number < 1e9:
        raise ModelError("not a speed", path=path, given=value, allowed=_SPEED)
    if unit == "rpm":
        return number / _given_speed(train, path, value) * tone
    return number * tone / 100 if unit == "%" else number * _HERTZ[unit]


def _given_speed(train: Train | None, path: str, value: str) -> float:
    """Size of the speed of the first member given that turns [rpm]."""
    from ..document.tables import leaves

    speed = {} if train is None else train.kinematics.speed or {}
    operation: Any = None if train is None else train.document.get("operation")
    for member, _ in leaves((operation or {}).get("speed") or {}):  # in the order of the file, "main.sun"
        if speed.get(member):
            return abs(float(speed[member]))
    kept = "a model file or Train in place of a System" if train is None else "a model"
    raise ModelError(
        "nothing says which member that is the speed of",
        path=path,
        given=value,
        allowed=f"{kept} whose operation.speed gives a member that turns, or Hz, %",
    )


def share(value: float | str, path: str, most: float | None = None) -> float:
    """A share [1] from a number [1], or a text with or without %.

    most : largest one; None without a limit.

    Raises
    ------
    ModelError : no positive number, or one above `most`.
    """
    limit = "" if most is None else f", at most {100 * most:g} %"
    return _positive(value, path, f'above zero{limit}, e.g. "20 %" or 0.2', most)


def _positive(value: float | str, path: str, allowed: str, most: float | None = None) -> float:
    """A number above 0 [1], at most `most`, from a number or a text with or without %. Raises ModelError."""
    try:
        number = value if isinstance(value, str) else float(value)
        return cast(float, read_quantity(number, ("ratio",), Bounds(low=0.0, high=most, above=True)))
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=value, allowed=allowed) from None


def frequency_band(text: str, path: str) -> tuple[float, float]:
    """Least and largest frequency [Hz] of ``500..6000 Hz``; a unit behind the last holds for both.

    Raises
    ------
    ModelError : not two frequencies, the lower one first.
    """
    ends = [end.strip() for end in text.split("..")]
    if len(ends) == 2:
        unit = ends[1].lstrip("0123456789.eE+- ")
        low, high = (frequency(end if end.endswith(unit) else f"{end} {unit}", path) for end in ends)
        if low < high:
            return low, high
    raise ModelError("not a band", path=path, given=text, allowed='"20 %" or "500..6000 Hz"')


def frequency(value: float | str, path: str) -> float:
    """A frequency [Hz] from a number [Hz], or a text with its unit Hz or kHz.

    Raises
    ------
    ModelError : no positive frequency, or a text without a unit.
    """
    if not isinstance(value, str):
        number, unit = float(value), "Hz"
    else:
        number, unit = _quantity(value, tuple(_HERTZ), path)
    if not 0.0 < number < 1e9:
        raise ModelError("not a frequency", path=path, given=value, allowed='a positive frequency, e.g. "20 Hz"')
    return number * _HERTZ[unit]


def torque_step(value: tuple[float, float] | str) -> tuple[float, float]:
    """Factor and time [s] of a torque step, from ``FACTOR@TIME`` where it is a text.

    Raises
    ------
    ModelError : no such text, or a factor beyond 1000.
    """
    if not isinstance(value, str):
        return _real_step(*value, value)
    factor, at, time = value.partition("@")
    found = re.fullmatch(rf"\s*{_NUMBER}\s*", factor)
    if found is None or not at:
        raise ModelError("not a torque step", path="torque_step", given=value, allowed='FACTOR@TIME, e.g. "1.5@0.2 s"')
    return _real_step(float(found[1]), stated(time, "time", "torque_step", bounds=Bounds(low=0.0)), value)


def _real_step(factor: float, time: float, given: object) -> tuple[float, float]:
    """A torque step as it is, refused where no machine has it."""
    if not abs(factor) <= _LARGEST_FACTOR:
        reason = "the worst short circuits are ten times the rated torque"
        allowed = f"a factor from -{_LARGEST_FACTOR:g} to {_LARGEST_FACTOR:g}; {reason}"
        raise ModelError("no torque of a machine", path="torque_step", given=given, allowed=allowed)
    return factor, time


def spread(text: str, points: int, path: str = "values") -> list[Any]:
    """Values of ``a..b`` evenly spaced, or of a list ``a, b, c``; a unit behind the last holds for all.

    Parameters
    ----------
    points : number of values of a range.  path : keyword, for an error.

    Returns
    -------
    numbers, or texts with the unit where there is one.

    Raises
    ------
    ModelError : neither a range nor a list of numbers.
    """
    import numpy as np

    found = re.fullmatch(rf"\s*{_NUMBER}\s*{_UNIT}?\s*\.\.\s*{_NUMBER}\s*{_UNIT}?\s*", text)
    if found:
        first, one, last, other = found.groups()
        numbers = [float(value) for value in np.linspace(float(first), float(last), max(points, 1))]
        unit = other or one
    else:
        parts = [re.fullmatch(rf"\s*{_NUMBER}\s*{_UNIT}?\s*", part) for part in text.split(",")]
        if not all(parts):
            raise ModelError("not values", path=path, given=text, allowed='"0..2", "1 %..5 %" or "1, 2, 5"')
        numbers = [float(part[1]) for part in parts if part]
        unit = next((part[2] for part in parts[::-1] if part and part[2]), None)
    return [f"{value:.12g} {unit}" for value in numbers] if unit else numbers


def loads_of(value: Sequence[float] | str | None, points: int | None, default: int) -> tuple[float, ...] | None:
    """Relative loads [1] from numbers, or from a text ``0..1.5`` or ``0.5, 2``; None stays None.

    Parameters
    ----------
    points : number of loads of a range, `default` where None.

    Raises
    ------
    ModelError : a text that is neither a range nor a list of numbers, or that has negative ones; points without range.
    """
    if points is not None and not (isinstance(value, str) and ".." in value):
        raise ModelError(
            "is the number of loads in a range", path="load_points", given=points, allowed='loads "0..1.5"'
        )
    if value is None:
        return None
    points = default if points is None else points
    if not isinstance(value, str):
        return tuple(value)
    found = spread(value, points, path="loads")
    if any(isinstance(one, str) or not 0 <= one <= _MOST_LOAD for one in found):
        allowed = f'"0..1.5" or "0.5, 2", 0 to {_MOST_LOAD}'
        raise ModelError("relative loads", path="loads", given=value, allowed=allowed)
    return tuple(float(one) for one in found)


def settings(
    value: Mapping[str, Any] | Sequence[str], path: str, example: str = 'tip_relief.amount="0..40 um"'
) -> dict[str, Any]:
    """Name -> text of entries ``NAME=TEXT``; a mapping stays what it is.

    Raises
    ------
    ModelError : no name or no text in an entry, or a name that comes twice.
    """
    if isinstance(value, Mapping):
        return dict(value)
    found: dict[str, object] = {}
    for name, equals, text in (str(entry).rpartition("=") for entry in value):
        if not name.strip() or not text.strip():
            raise ModelError("not a value with a name", path=path, given=f"{name}{equals}{text}", allowed=example)
        if name.strip() in found:
            given = f"{name.strip()}={text.strip()}"
            raise ModelError("stated twice", path=path, given=given, allowed="once")
        found[name.strip()] = text.strip()
    return found


def references(reference: Mapping[str, float] | Sequence[str], path: str) -> dict[str, float]:
    """Name -> value of references.

    Raises
    ------
    ModelError : one is no ``NAME=K``, or K is no number above 0.
    """
    values = settings(reference, path, "NAME=1.35")
    return {str(name): _positive(value, path, "a load factor above 0, 1.15") for name, value in values.items()}


def _quantity(text: str, units: tuple[str, ...], path: str) -> tuple[float, str]:
    """Number and unit of a text; nan where it is no number of these units.

    Raises
    ------
    ModelError : a number other than 0 without a unit.
    """
    number = text.strip()
    if re.fullmatch(_NUMBER, number) and float(number) != 0.0:
        raise ModelError(f'a number without a unit: "{number} {units[0]}"?', path=path, given=text)
    found = re.fullmatch(rf"{_NUMBER}\s*({'|'.join(units)})?", number)
    return (float(found[1]), found[2] or units[0]) if found else (float("nan"), units[0])


def relative_speed(speed: float | str, path: str, drive: Drive) -> float:
    """Speed per operating speed [1] from a number, or a text: a number, or a mesh frequency or speed with its unit.

    Raises
    ------
    ModelError : no such text, a speed out of range, or one with a unit where the model has no speed.
    """
    if not isinstance(speed, str):
        return speed
    try:
        share = float(speed)
    except ValueError:
        share = _of_operation(speed, path, drive)
    if not 0 <= share <= MOST_SPEED:
        allowed = f"0 to {MOST_SPEED} times the operating speed"
        raise ModelError("out of range", path=path, given=speed, allowed=allowed)
    return share


def _of_operation(speed: str, path: str, drive: Drive) -> float:
    """Speed per operating speed [1] of a mesh frequency or speed with its unit."""
    if not drive.system.tones:
        raise ModelError("is relative to an operating speed", path="operation.speed", given=speed, allowed=SPEED_HINT)
    from ..statics.record import reference_tone

    tone = float(reference_tone(drive.system))
    return mesh_frequency(speed, path=path, tone=tone, train=drive.drawing) / tone


def mesh_frequencies(
    drive: Drive,
    start: float | str | None,
    stop: float | str | None,
    points: int,
    speed_range: SpeedRange = "operation",
) -> list[float]:
    """Evenly spaced mesh frequencies of the first mesh (points,) [Hz].

    Parameters
    ----------
    start, stop : ends, numbers [Hz] or texts; None: that of the range, or, where an end lies beyond it, of the modes.
    speed_range : as of `range_ends`.

    Raises
    ------
    ModelError : no speed in the model, an end that is no speed, or an empty range.
    """
    import numpy as np

    from ..questions.modes.eigen import frequencies_of_bodies
    from ..questions.response.sweep_table import range_ends
    from ..statics.record import reference_tone
    from ..statics.tangent import linear

    system = drive.system
    if not system.tones:
        raise ModelError("a sweep needs a speed", path="operation.speed", allowed=SPEED_HINT)
    natural = frequencies_of_bodies(linear(system, asks_laws=True))
    tone = float(reference_tone(system))
    low, high = (
        None if end is None else mesh_frequency(end, path=path, tone=tone, train=drive.drawing)
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


def _quantity_of(kind: str) -> Reader:
    """Reader of a quantity within the bounds of its option: a number in SI, a text must say its unit."""

    def read(value: float | str, path: str, _: Drive, option: Option) -> float:
        low = option.least if option.above is None else option.above
        return stated(value, kind, path, bounds=Bounds(low=low, high=option.most, above=option.above is not None))

    return read


def _bins_of(kind: str) -> Reader:
    """Reader of a number of bins, or of their edges: in SI, or a text with the unit behind the last."""

    def read(value: int | Sequence[float] | str, path: str, *_: Any) -> int | Sequence[float]:
        if not isinstance(value, str):
            return value.tolist() if hasattr(value, "tolist") else value
        return int(value) if value.isdecimal() else [stated(str(one), kind, path) for one in spread(value, 2, path)]

    return read


def _sensor(value: float | str, path: str, drive: Drive, option: Option) -> float | str:
    """Reader of a place: the name of a sensor of the model, or an angle [rad]."""
    names = drive.system.sensors.name
    if isinstance(value, str) and value in names:
        return value
    try:
        return stated(value, "angle", path)
    except ModelError as error:
        allowed = f"{error.allowed}; or a sensor of the model: {', '.join(names) or 'it has none'}"
        raise ModelError(error.problem, path=path, given=value, allowed=allowed) from None


Reader = Callable[[Any, str, "Drive", Option], Any]
"""(what was given, keyword, drive, option) -> value of the field. Raises ModelError."""

READERS: Mapping[str, Reader] = {
    "relative speed": lambda value, path, drive, _: relative_speed(value, path, drive),
    "frequency": lambda value, path, *_: frequency(value, path),
    "share": lambda value, path, _, option: share(value, path, option.most),
    "torque step": lambda value, *_: torque_step(value),
    "torque bins": _bins_of("torque"),
    "speed bins": _bins_of("speed"),
    "sensor": _sensor,
    "settings": lambda value, path, *_: settings(value, path),
    "references": lambda value, path, *_: references(value, path),
    **{kind: _quantity_of(kind) for kind in ("angle", "length", "load_per_length", "time", "torque", "viscosity")},
}
"""Name, as `Option.reads` has it -> reader."""
