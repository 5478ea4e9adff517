"""A new train: from teeth or ratio, load and speed to a whole document, with what follows from it as comments.

What a person says of it is read into SI, checked for contradictions, and kept as it was typed.

`epicyclic.planetary`, `star` and `differential`: a train in Python from the words of a drawing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

from ..document.schema import nearest
from ..document.units import Bounds, stated
from ..document.writer import commented_text, quantity_text
from ..errors import ModelError
from ..teeth.geometry import overlap_ratio
from ..user_input import checked
from . import ByMember, Kind, Member, NewTrainOptions, Number
from .preselection import (
    FEWEST,
    LOAD_FIGURE,
    RATIO_LIMIT,
    Blank,
    Held,
    ToothCounts,
    assembles,
    beside,
    counts_of_ratio,
    least_gap,
    load_figure,
    most_planets,
    nearest_counts,
    neighbour_gap,
    ratio_of,
    shifts_of,
    size_of,
)
from .resolution import load
from .train import Train

_Given = Mapping[str, Number | Mapping[str, Number] | None]  # speed, torque and power, as the keywords have them
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
    """Speed and load.

    stated : speed, torque and power as in `[operation]`: member -> text with its unit.
    sun_torque : size of the torque at the sun [N m].  derived : path below `operation` -> what it follows from.
    """

    stated: Mapping[str, Mapping[str, str]]
    driver: Member | None
    sun_torque: float
    derived: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What is to be built.

    blank : its gears, what was not given chosen.  texts : keyword -> the value as it was given, with its unit.
    others : further tooth counts of a ratio that was given.
    """

    blank: Blank
    others: tuple[ToothCounts, ...]
    load: DrivenLoad
    texts: Mapping[str, str]
    title: str

    @property
    def load_figure(self) -> str:
        """K of the preselection [N/mm^2]."""
        return f"K = {load_figure(self.blank, self.load.sun_torque) / 1e6:.2g} N/mm^2"


def read_wishes(options: NewTrainOptions) -> Wishes:
    """Read what a person says, and size the gears.

    Raises
    ------
    ModelError : what contradicts, cannot be assembled or does not fit: the keyword, what was given and what is allowed.
    """
    kind, planets, held = options.kind, options.planets, options.held
    _one_of(kind, KINDS, "kind")
    if isinstance(planets, bool) or not isinstance(planets, int) or not 1 <= planets <= _MOST_PLANETS:
        raise ModelError("no number of planets", path="planets", given=planets, allowed=f"1 to {_MOST_PLANETS}")
    allowed = HELD[kind]
    if held is not None and held not in allowed:
        if not allowed:
            raise ModelError("nothing is held in a differential", path="held", given=held, allowed="leave it out")
        hint = "; with the carrier held it is a star" if kind == "planetary" and held == "carrier" else ""
        raise ModelError(f"cannot be held in a {kind} set{hint}", path="held", given=held, allowed=" or ".join(allowed))
    fixed = next((name for name in allowed if held in (None, name)), None)
    texts: dict[str, str] = {}
    normal = _read(options.module, "length", "module", _MODULE, texts)
    width = _read(options.face_width, "length", "face_width", _WIDTH, texts)
    helix = _read(options.helix_angle, "angle", "helix_angle", _SLANT, texts) or 0.0
    pressure = _read(options.pressure_angle, "angle", "pressure_angle", _SLANT, texts)
    counts, *others = _counts(options.teeth, options.ratio, planets, fixed, helix, normal)
    given = {"speed": options.speed, "torque": options.torque, "power": options.power}
    load = _load(fixed, counts, options.driver, {path: _said_by_member(value) for path, value in given.items()})
    _check_counts(counts, planets, helix, normal)
    normal, width = size_of(counts, planets, load.sun_torque, helix, module=normal, width=width)
    blank = Blank(
        counts=counts,
        planets=planets,
        module=normal,
        face_width=width,
        helix_angle=helix,
        pressure_angle=pressure or _NORMAL_ANGLE,
        held=fixed,
    )
    title = options.title or f"{kind.capitalize()} set {counts} with {planets} planet{'s' * (planets > 1)}"
    return Wishes(blank=blank, others=tuple(others), load=load, texts=texts, title=title)


def _said_by_member(value: ByMember) -> Number | Mapping[str, Number] | None:
    """One value as it is; texts ``MEMBER=VALUE`` as a table."""
    if value is None or isinstance(value, float | int | str | Mapping):
        return value
    pairs = [text.partition("=") for text in value]
    if len(pairs) == 1 and not pairs[0][1]:
        return value[0]
    return {name.strip(): number.strip() for name, _, number in pairs}


def _one_of(value: object, allowed: Sequence[str], path: str) -> None:
    """Raise ModelError for a word that is none of those allowed."""
    if value not in allowed:
        word = nearest(value, allowed)
        raise ModelError(f"not one of them{word}", path=path, given=value, allowed=" or ".join(allowed))


def _read(value: Number | None, kind: str, path: str, bounds: Bounds, texts: dict[str, str]) -> float | None:
    """Value of a keyword in SI; its text goes into `texts`. Raises ModelError."""
    if value is None:
        return None
    number = stated(value, kind, path, bounds=bounds)
    if number not in bounds:
        words = " to ".join(quantity_text(end, kind) for end in (bounds.low, bounds.high) if end is not None)
        raise ModelError("out of range", path=path, given=value, allowed=f"{'above ' * (bounds.high is None)}{words}")
    texts[path] = value.strip() if isinstance(value, str) else quantity_text(float(value), kind)
    return number


# teeth ----------------------------------------------------------------------------------------------------------------


def _counts(
    teeth: str | Sequence[int] | None,
    ratio: float | None,
    planets: int,
    held: Held | None,
    helix_angle: float,
    module: float | None,
) -> tuple[ToothCounts, ...]:
    """Tooth counts, given or those of a ratio, the best first. Raises ModelError where both disagree.

    held : None of a differential alone.
    """
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
    if held is None:
        raise ModelError("is missing", path="teeth", allowed="sun/planet/ring, 21/39/99; a ratio says nothing of it")
    if ratio is None:
        raise ModelError("is missing", path="teeth", allowed="sun/planet/ring, 21/39/99, or a ratio")
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


def _load(held: Held | None, counts: ToothCounts, driver: str | None, given: _Given) -> DrivenLoad:
    """Speed and load, `given` in the order of `_EXAMPLE`. Raises ModelError for what is missing or contradicts."""
    if held is None:
        return _differential_load(counts, driver, given)
    ends = tuple(m for m in MEMBERS if m != held)
    if driver is not None:
        _one_of(driver, ends, "driver")
    first: Member = next(m for m in ends if m == (driver or _DRIVER[held]))
    texts: dict[str, str] = {}
    driven: dict[str, float | None] = {}
    for path, value in given.items():
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
    return DrivenLoad(
        stated={path: {str(first): texts[path]} if path in texts else {} for path in _EXAMPLE},
        driver=first,
        sun_torque=moment * _share_of_sun(counts, first),
        derived=derived,
    )


_EXAMPLE = {"speed": "1000 rpm", "torque": "7.2 kN m", "power": "750 kW"}


def _differential_load(counts: ToothCounts, driver: str | None, given: _Given) -> DrivenLoad:
    """Speeds of two members and the load of one, each by its name. Raises ModelError."""
    if driver is not None:
        raise ModelError("a differential names its members", path="driver", given=driver, allowed="leave it out")
    speeds, torque, power = _by_member(given["speed"], "speed", 2), given["torque"], given["power"]
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
    stated_load = {"torque": {member: text}, "power": {}} if power is None else {"torque": {}, "power": {member: text}}
    return DrivenLoad(
        stated={"speed": {m: said for m, (_, said) in speeds.items()}, **stated_load},
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
    return dict(new_train(kind="planetary", **locals()).document)


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
    return dict(new_train(kind="star", **locals()).document)


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
    return dict(new_train(kind="differential", **locals()).document)


_NORMAL_ANGLE = math.radians(20)  # the file format's default
_UNDERCUT = 12  # fewer teeth no profile shift saves from undercut or a pointed tip


@dataclass(frozen=True, slots=True, kw_only=True)
class NewTrain:
    """A new train.

    document : what `load` takes, reasons of all that was chosen under ``assumed``.
    comments : what follows from it, by path.  remarks : what a person should know of the choice.
    """

    document: Mapping[str, Any]
    comments: Mapping[str, str]
    remarks: tuple[str, ...]

    def text(self, head: tuple[str, ...] = ()) -> str:
        """The commented model file; head : lines of comment ahead of all."""
        return commented_text(self.document, head=(*head, *self.remarks), comments=self.comments)


def new_train(**keywords: Any) -> NewTrain:
    """A train from the fields of `NewTrainOptions`.

    Raises
    ------
    ModelError : what contradicts, cannot be assembled or does not fit; names the keyword.
    """
    wishes = read_wishes(NewTrainOptions(**keywords))
    document = _document(wishes)
    return NewTrain(document=document, comments=_comments(wishes, load(document)), remarks=_remarks(wishes))


def _check_counts(counts: ToothCounts, planets: int, helix_angle: float, module: float | None) -> None:
    """Raise ModelError for teeth that do not assemble, have no room, or cannot be cut."""
    if min(counts.sun, counts.planet) < _UNDERCUT:
        raise ModelError("too few teeth", path="teeth", given=str(counts), allowed=f"{_UNDERCUT} or more on each gear")
    least = least_gap(module)
    if neighbour_gap(counts, planets, helix_angle) < least:
        most = most_planets(counts, helix_angle, module)
        raise ModelError(
            f"the tips of neighbouring planets of {counts} come nearer than one module",
            path="planets",
            given=planets,
            allowed=f"at most {most} with these teeth",
        )
    if not assembles(counts, planets):
        near = nearest_counts(counts, planets, helix_angle=helix_angle, module=module)
        fitting = [n for n in range(2, planets + 4) if assembles(counts, n) and n != planets]
        fitting = [n for n in fitting if neighbour_gap(counts, n, helix_angle) >= least]
        ways = [" or ".join(map(str, near))] if near else []
        ways += [f"these teeth with {' or '.join(map(str, fitting))} planets"] if fitting else []
        raise ModelError(
            f"{planets} equally spaced planets cannot be assembled, the teeth do not meet",
            path="teeth",
            given=str(counts),
            allowed="; ".join(ways) or "other teeth",
        )


# the document ---------------------------------------------------------------------------------------------------------


def _document(wishes: Wishes) -> dict[str, Any]:
    """The whole document, reasons of what was chosen under `assumed`."""
    blank, texts, load_ = wishes.blank, wishes.texts, wishes.load
    tables, reasons = beside(blank)
    figure = f"preselection, no strength rating: {wishes.load_figure}, at most {LOAD_FIGURE / 1e6:g}"
    chosen = {}
    if "module" not in texts:
        chosen["stages.main.module"] = f"{figure}; series I of ISO 54"
    if "face_width" not in texts:
        chosen["stages.main.face_width"] = (
            "0.8 of the sun's diameter" if "module" not in texts else f"{figure}; 0.8 d_s"
        )
    common: dict[str, Any] = {
        "planets": blank.planets,
        "module": texts.get("module", quantity_text(blank.module, "length")),
    }
    common |= {key: texts[key] for key in ("pressure_angle", "helix_angle") if key in texts}
    common["face_width"] = texts.get("face_width", quantity_text(blank.face_width, "length"))
    stage = tables["stages"]["main"]
    teeth = {"sun": blank.counts.sun, "planet": blank.counts.planet, "ring": blank.counts.ring}
    members = {m: ({"teeth": teeth[m]} if m in teeth else {}) | stage[m] for m in (*teeth, "carrier")}
    operation: dict[str, Any] = {} if blank.held is None else {"held": [blank.held]}
    operation |= {path: dict(values) for path, values in load_.stated.items() if values}
    chosen |= {f"operation.{path}.{load_.driver}": reason for path, reason in load_.derived.items()}
    return {
        "format": 2,
        "title": wishes.title,
        "damping": tables["damping"],
        "stages": {"main": common | members},
        "operation": operation,
        "deviations": tables["deviations"],
        "tolerance": tables["tolerance"],
        "assumed": chosen | reasons,
    }


# what follows ---------------------------------------------------------------------------------------------------------


def _comments(wishes: Wishes, train: Train) -> dict[str, str]:
    """Derived values by the path they stand at."""
    mesh = {m.pair.rpartition(".")[2]: m for m in train.meshes}
    gears = {b.member.rpartition(".")[2]: b.gear for b in train.bodies if b.gear is not None}
    first = mesh["sun-planet"]
    centre = first.radius_a + first.radius_b
    of_stage = [f"centre distance {_mm(centre)}"]
    if (held := wishes.blank.held) is not None:
        a, b = {"ring": ("sun", "carrier"), "sun": ("ring", "carrier"), "carrier": ("sun", "ring")}[held]
        of_stage.insert(0, f"ratio {ratio_of(wishes.blank.counts, held):.5g}, {a} to {b}")
    if (rate := (train.kinematics.mesh_frequency or {}).get("main")) is not None:
        of_stage.append(f"mesh frequency {float(rate):.6g} Hz")
    overlap = ""
    if wishes.blank.helix_angle and not math.isnan(first.overlap_ratio):
        overlap = f", overlap {first.overlap_ratio:.2f}"
    comments = {
        "stages.main": "; ".join(of_stage),
        "stages.main.carrier": f"pins on a circle of {_mm(centre)} radius",
        # "contact" takes seconds of computing, and a train without relief does not need it
        "stages.main.face_width": 'of each gear; tip relief would count with meshes.*.stiffness = "contact"',
        "operation": "without weights; gravity = true counts them",
        "deviations": "what manufacturing leaves over",
        "tolerance": "what the drawing allows, from one train to the next",
        "assumed": "chosen, not given: every value here wants yours",
    }
    contact = {
        "sun": f"contact ratio with a planet {first.contact_ratio:.2f}{overlap}",
        "ring": f"contact ratio with a planet {mesh['planet-ring'].contact_ratio:.2f}{overlap}",
    }
    for member, gear in gears.items():
        said = f"reference diameter {_mm(2 * gear.reference_radius)}"
        comments[f"stages.main.{member}"] = "; ".join(filter(None, (said, contact.get(member, ""))))
    return comments | _operation_comments(wishes, train)


def _operation_comments(wishes: Wishes, train: Train) -> dict[str, str]:
    """Speeds, torques and power of the members that the operation does not state."""
    motion, driver, load_ = train.kinematics, wishes.load.driver, wishes.load.stated
    comments: dict[str, str] = {}
    if motion.speed:
        others = [m for m in (*MEMBERS, "planet") if m not in load_["speed"] and m != wishes.blank.held]
        speeds = {m: motion.speed.get(f"main.{m}") for m in others}
        said = [f"{m} {float(speed):.6g} rpm" for m, speed in speeds.items() if speed is not None]
        comments[f"operation.speed.{list(load_['speed'])[-1]}"] = ", ".join(said)
    if motion.torque:
        loaded = [*load_["torque"], *load_["power"]]
        said = [
            f"{m} {quantity_text(float(f'{moment:.5g}'), 'torque')}"
            for m in MEMBERS
            if m not in load_["torque"] and (moment := motion.torque.get(f"main.{m}"))
        ]
        driven = (motion.power or {}).get(f"main.{driver}") if load_["torque"] else None
        said += [f"power {quantity_text(float(f'{driven:.5g}'), 'power')}"] if driven else []
        where = f"operation.{'torque' if load_['torque'] else 'power'}.{loaded[0]}"
        comments[where] = f"{', '.join(said)}; counter-clockwise positive"
    return comments


def _remarks(wishes: Wishes) -> tuple[str, ...]:
    """What a person should know of what was chosen."""
    blank, (counts, planets) = wishes.blank, (wishes.blank.counts, wishes.blank.planets)
    said = []
    if wishes.others and blank.held is not None:  # found by a ratio
        first, *others = (f"{c} ({ratio_of(c, blank.held):.5g})" for c in (counts, *wishes.others))
        said.append(f"Teeth {first}; as well: {', '.join(others)}.")
    if "module" not in wishes.texts or "face_width" not in wishes.texts:
        said.append(f"Module and face width: preselection by {wishes.load_figure}, no strength rating.")
    elif load_figure(blank, wishes.load.sun_torque) > LOAD_FIGURE:
        said.append(f"{wishes.load_figure} is above 4: rate the strength of these gears.")
    said += [_phasing_words(counts.sun, planets)] if planets > 2 else []
    low = [m for m, z in (("sun", counts.sun), ("planet", counts.planet)) if z < FEWEST]
    if low and not shifts_of(blank):
        said.append(f"The {' and the '.join(low)} may be undercut: fewer than {FEWEST} teeth and no profile shift.")
    if blank.helix_angle and overlap_ratio(blank.face_width, blank.helix_angle, blank.module) < 1:
        said.append("The overlap ratio is below 1: not at every moment does a whole helix carry.")
    return tuple(said)


def _phasing_words(sun: int, planets: int) -> str:
    """What the meshes with the sun do together at the mesh frequency: the sum over exp(2 pi i z_s k/N) [parker2004]."""
    if sun % planets == 0:
        return "z_s/N is whole: at the mesh frequency the planets pull at the sun alike, torque adds up, forces cancel."
    if (sun + 1) % planets == 0 or (sun - 1) % planets == 0:
        return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, forces across its axis add up."
    return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, and so do forces across its axis."


def _mm(length: float) -> str:
    return f"{length * 1e3:.6g} mm"
