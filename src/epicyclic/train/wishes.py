"""What a person says of a new train: read into SI, checked for contradictions, and kept as it was typed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from ..document.schema import nearest
from ..document.units import Bounds, stated
from ..document.writer import quantity_text
from ..errors import ModelError
from .preselection import RATIO_LIMIT, Held, ToothCounts, counts_of_ratio, nearest_counts, ratio_of

Kind = Literal["planetary", "star", "differential"]
Member = Literal["sun", "ring", "carrier"]
Number = float | str
"""A text with its unit, "10 mm", or a float in SI."""
KINDS: tuple[Kind, ...] = get_args(Kind)
MEMBERS: tuple[Member, ...] = get_args(Member)
HELD: Mapping[Kind, tuple[Held, ...]] = {"planetary": ("ring", "sun"), "star": ("carrier",), "differential": ()}
"""Members that may be held, by kind; the first one is held unless said otherwise."""
_DRIVER: Mapping[str, Member] = {"ring": "sun", "sun": "ring", "carrier": "sun"}  # by what is held: a reducer's input
_POWER_GAP = 0.01  # power, torque and speed agree within the rounding of a data sheet
_MOST_PLANETS = 12  # more do not fit around any sun that a search finds
_ABOVE_ZERO = Bounds(low=0, above=True)
_MODULE = Bounds(low=5e-5, high=0.1)  # ISO 54 ends at 50 mm
_WIDTH = Bounds(low=1e-4, high=5.0)
_SLANT = Bounds(low=0, high=math.radians(45))


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenLoad:
    """Speed and load, spelled as in `[operation]`: member -> text with its unit.

    sun_torque : size of the torque at the sun [N m].  derived : path below `operation` -> what it follows from.
    """

    speed: Mapping[str, str]
    torque: Mapping[str, str]
    power: Mapping[str, str]
    driver: Member | None
    sun_torque: float
    derived: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What is to be built; lengths [m], angles [rad]; None where it is to be chosen.

    texts : keyword -> the value as it was given, with its unit.  others : further tooth counts of the same ratio.
    searched : the teeth were found from a ratio.
    """

    kind: Kind
    planets: int
    held: Held | None
    counts: ToothCounts
    others: tuple[ToothCounts, ...]
    ratio: float | None
    module: float | None
    face_width: float | None
    helix_angle: float
    pressure_angle: float | None
    load: DrivenLoad
    texts: Mapping[str, str]
    title: str


def read_wishes(
    kind: Kind,
    *,
    planets: int = 3,
    teeth: str | Sequence[int] | None = None,
    ratio: float | None = None,
    speed: Number | Mapping[str, Number] | None = None,
    torque: Number | Mapping[str, Number] | None = None,
    power: Number | Mapping[str, Number] | None = None,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    held: str | None = None,
    driver: str | None = None,
    title: str | None = None,
) -> Wishes:
    """Read the keywords of `new_train`. Raises ModelError with the keyword, what was given and what is allowed."""
    _one_of(kind, KINDS, "kind")
    if isinstance(planets, bool) or not isinstance(planets, int) or not 1 <= planets <= _MOST_PLANETS:
        raise ModelError("no number of planets", path="planets", given=planets, allowed=f"1 to {_MOST_PLANETS}")
    fixed = _held(kind, held)
    texts: dict[str, str] = {}
    normal = _read(module, "length", "module", _MODULE, texts)
    width = _read(face_width, "length", "face_width", _WIDTH, texts)
    helix = _read(helix_angle, "angle", "helix_angle", _SLANT, texts)
    pressure = _read(pressure_angle, "angle", "pressure_angle", _SLANT, texts)
    best = _counts(kind, teeth, ratio, planets, fixed, helix or 0.0, normal)
    load = _load(kind, fixed, best[0], driver, speed=speed, torque=torque, power=power)
    words = {"planetary": "Planetary set", "star": "Star set", "differential": "Differential set"}[kind]
    return Wishes(
        kind=kind,
        planets=planets,
        held=fixed,
        counts=best[0],
        others=best[1:],
        ratio=ratio,
        module=normal,
        face_width=width,
        helix_angle=helix or 0.0,
        pressure_angle=pressure,
        load=load,
        texts=texts,
        title=title or f"{words} {best[0]} with {planets} planet{'s' * (planets > 1)}",
    )


def _one_of(value: object, allowed: Sequence[str], path: str) -> None:
    """Raise ModelError for a word that is none of those allowed."""
    if value not in allowed:
        word = nearest(value, allowed)
        raise ModelError(f"not one of them{word}", path=path, given=value, allowed=" or ".join(allowed))


def _held(kind: Kind, held: str | None) -> Held | None:
    """The member that is held."""
    allowed = HELD[kind]
    if held is None:
        return allowed[0] if allowed else None
    if not allowed:
        raise ModelError("nothing is held in a differential", path="held", given=held, allowed="leave it out")
    if held not in allowed:
        hint = "; with the carrier held it is a star" if kind == "planetary" and held == "carrier" else ""
        raise ModelError(f"cannot be held in a {kind} set{hint}", path="held", given=held, allowed=" or ".join(allowed))
    return next(name for name in allowed if name == held)


def _read(value: Number | None, kind: str, path: str, bounds: Bounds, texts: dict[str, str]) -> float | None:
    """Value of a keyword in SI; its text goes into `texts`. Raises ModelError."""
    if value is None:
        return None
    number = stated(value, kind, path, bounds=bounds)
    low, high = bounds.low, bounds.high
    if (low is not None and (number < low or (bounds.above and number == low))) or (high is not None and number > high):
        words = " to ".join(quantity_text(end, kind) for end in (low, high) if end is not None)
        raise ModelError("out of range", path=path, given=value, allowed=f"{'above ' * (high is None)}{words}")
    texts[path] = value.strip() if isinstance(value, str) else quantity_text(float(value), kind)
    return number


# teeth ----------------------------------------------------------------------------------------------------------------


def _counts(
    kind: Kind,
    teeth: str | Sequence[int] | None,
    ratio: float | None,
    planets: int,
    held: Held | None,
    helix_angle: float,
    module: float | None,
) -> tuple[ToothCounts, ...]:
    """Tooth counts, given or those of a ratio, the best first. Raises ModelError where both disagree."""
    if ratio is not None and (isinstance(ratio, bool) or not isinstance(ratio, (int, float)) or not abs(ratio) < 1e3):
        raise ModelError("not a ratio", path="ratio", given=ratio, allowed="a number below 1000 in size, 5.7")
    if teeth is not None:
        counts = _given_counts(teeth, planets, helix_angle, module)
        if ratio is not None and held is None:
            raise ModelError("says nothing of a differential", path="ratio", given=ratio, allowed="leave it out")
        if ratio is not None and held is not None:
            of_teeth = ratio_of(counts, held)
            asked = -abs(ratio) if held == "carrier" else ratio  # of a star of either sign
            if not abs(asked / of_teeth - 1) <= RATIO_LIMIT:
                raise ModelError(
                    f"the teeth {counts} have {of_teeth:.5g} with the {held} held",
                    path="ratio",
                    given=ratio,
                    allowed="one of teeth and ratio, or both within 2 %",
                )
        return (counts,)
    if kind == "differential":
        raise ModelError("is missing", path="teeth", allowed="sun/planet/ring, 21/39/99; a ratio says nothing of it")
    if ratio is None:
        raise ModelError("is missing", path="teeth", allowed="sun/planet/ring, 21/39/99, or a ratio")
    assert held is not None
    least = 2.0 if held == "ring" else 1.0
    if not abs(ratio) > least or (ratio < 0 and held != "carrier"):
        raise ModelError("no ratio of such a set", path="ratio", given=ratio, allowed=f"above {least:g}")
    return counts_of_ratio(ratio, planets, held, helix_angle=helix_angle, module=module)


def _given_counts(teeth: str | Sequence[int], planets: int, helix_angle: float, module: float | None) -> ToothCounts:
    """Tooth counts as typed, sun/planet/ring or sun/planet. Raises ModelError."""
    allowed = "sun/planet/ring, 21/39/99"
    parts = teeth.split("/") if isinstance(teeth, str) else list(teeth)
    try:
        numbers = [int(str(part).strip()) for part in parts]
    except ValueError:
        raise ModelError("not numbers of teeth", path="teeth", given=teeth, allowed=allowed) from None
    if len(numbers) not in (2, 3):
        raise ModelError(f"{len(numbers)} numbers", path="teeth", given=teeth, allowed=allowed)
    if min(numbers[:2]) < 3 or max(numbers) > 5000:
        raise ModelError("no number of teeth", path="teeth", given=teeth, allowed="3 to 5000 on each gear")
    sun, planet = numbers[:2]
    ring = numbers[2] if len(numbers) == 3 else sun + 2 * planet
    counts = ToothCounts(sun=sun, planet=planet, ring=ring)
    if ring != sun + 2 * planet:
        near = nearest_counts(counts, planets, helix_angle=helix_angle, module=module)
        raise ModelError(
            f"{sun} + 2 x {planet} teeth make a ring of {sun + 2 * planet} without profile shift",
            path="teeth",
            given=teeth,
            allowed=f"{' or '.join(map(str, near)) or allowed}; others with shifts of your own in the file",
        )
    return counts


# speed and load -------------------------------------------------------------------------------------------------------


def _load(
    kind: Kind,
    held: Held | None,
    counts: ToothCounts,
    driver: str | None,
    *,
    speed: Number | Mapping[str, Number] | None,
    torque: Number | Mapping[str, Number] | None,
    power: Number | Mapping[str, Number] | None,
) -> DrivenLoad:
    """Speed and load. Raises ModelError for what is missing or contradicts."""
    if kind == "differential":
        return _differential_load(counts, driver, speed=speed, torque=torque, power=power)
    assert held is not None
    ends = tuple(m for m in MEMBERS if m != held)
    if driver is not None:
        _one_of(driver, ends, "driver")
    first: Member = next(m for m in ends if m == (driver or _DRIVER[held]))
    texts: dict[str, str] = {}
    driven: dict[str, float | None] = {}
    for path, value in (("speed", speed), ("torque", torque), ("power", power)):
        if isinstance(value, Mapping):
            raise ModelError(
                "one value: that of the driving member",
                path=path,
                given=dict(value),
                allowed=f'a text such as "{_EXAMPLE[path]}", and driver = {" or ".join(ends)}',
            )
        driven[path] = _read(value, path, path, _ABOVE_ZERO, texts)
    omega, moment, watts = driven["speed"], driven["torque"], driven["power"]
    derived: dict[str, str] = {}
    if watts is not None and moment is not None and omega is not None:
        if abs(moment * omega / watts - 1) > _POWER_GAP:
            problem = f"torque x speed is {quantity_text(float(f'{moment * omega:.6g}'), 'power')}"
            raise ModelError(problem, path="power", given=texts["power"], allowed="two of power, torque and speed")
        del texts["power"]
    elif watts is not None and moment is not None:
        omega = watts / moment
        texts["speed"] = quantity_text(float(f"{omega / math.tau * 60:.6g}") * math.tau / 60, "speed")
        derived["speed"] = f"{texts.pop('power')} / {texts['torque']}"
    for path, value in (("speed", omega), ("torque", watts if moment is None else moment)):
        if value is None:
            more = ", or power" if path == "torque" else ", or both torque and power"
            raise ModelError("is missing", path=path, allowed=f'that of the {first}, "{_EXAMPLE[path]}"{more}')
    assert omega is not None
    if moment is None:
        assert watts is not None
        moment = watts / omega
    said = {path: {str(first): texts[path]} if path in texts else {} for path in _EXAMPLE}
    return DrivenLoad(
        speed=said["speed"],
        torque=said["torque"],
        power=said["power"],
        driver=first,
        sun_torque=moment * _share_of_sun(counts, first),
        derived=derived,
    )


_EXAMPLE = {"speed": "1000 rpm", "torque": "7.2 kN m", "power": "750 kW"}


def _differential_load(
    counts: ToothCounts,
    driver: str | None,
    *,
    speed: Number | Mapping[str, Number] | None,
    torque: Number | Mapping[str, Number] | None,
    power: Number | Mapping[str, Number] | None,
) -> DrivenLoad:
    """Speeds of two members and the load of one, each by its name. Raises ModelError."""
    if driver is not None:
        raise ModelError("a differential names its members", path="driver", given=driver, allowed="leave it out")
    speeds = _by_member(speed, "speed", 2)
    if (torque is None) == (power is None):
        raise ModelError(
            "one of torque and power" if torque is not None else "is missing",
            path="torque",
            allowed='torque = {"sun": "500 N m"} or power, of one member',
        )
    loads = _by_member(torque if power is None else power, "torque" if power is None else "power", 1)
    ((member, (value, text)),) = loads.items()
    moment = value
    if power is not None:
        if member not in speeds or speeds[member][0] == 0:
            turning = " or ".join(m for m, (omega, _) in speeds.items() if omega)
            allowed = f"that of {turning}, whose speed is given" if turning else "speeds of which one is not zero"
            raise ModelError("of a member without speed", path="power", given=member, allowed=allowed)
        moment = value / speeds[member][0]
    return DrivenLoad(
        speed={m: said for m, (_, said) in speeds.items()},
        torque={member: text} if power is None else {},
        power={member: text} if power is not None else {},
        driver=None,
        sun_torque=abs(moment) * _share_of_sun(counts, member),
        derived={},
    )


def _by_member(value: object, path: str, count: int) -> dict[str, tuple[float, str]]:
    """Number in SI and text by member. Raises ModelError unless it names `count` of them."""
    example = ", ".join(f'"{m}": "{_EXAMPLE[path]}"' for m in MEMBERS[:count])
    allowed = f"{{{example}}}: {'two' if count == 2 else 'one'} of {', '.join(MEMBERS)}"
    if value is None:
        raise ModelError("is missing", path=path, allowed=allowed)
    if not isinstance(value, Mapping) or len(value) != count:
        given = dict(value) if isinstance(value, Mapping) else value
        raise ModelError(f"a differential needs that of {count}", path=path, given=given, allowed=allowed)
    numbers = {}
    for member, number in value.items():
        _one_of(member, MEMBERS, path)
        texts: dict[str, str] = {}
        read = _read(number, path, path, Bounds(), texts)
        assert read is not None
        numbers[str(member)] = (read, texts[path])
    return numbers


def _share_of_sun(counts: ToothCounts, member: str) -> float:
    """Torque at the sun per torque at a member, without losses, in size [1]."""
    if member == "sun":
        return 1.0
    return counts.sun / (counts.ring if member == "ring" else counts.sun + counts.ring)
