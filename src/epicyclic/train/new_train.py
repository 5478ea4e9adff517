"""A new train: from teeth or ratio, load and speed to a whole document, with what follows from it as comments.

What a person says of it is read into SI, checked for contradictions, and kept as it was typed.  `epicyclic.planetary`,
`star` and `differential` say it in Python, in the words of a drawing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, Literal, cast, get_args

from ..document.document import read
from ..document.schema import KIND_BY_NAME, nearest
from ..document.units import Bounds, read_quantity, stated
from ..document.writer import commented_text, quantity_text
from ..errors import ModelError, in_mm
from ..teeth import geometry
from ..user_input import checked
from ..warning_codes import code_of
from . import ByMember, Member, NewTrainOptions, Number, layouts
from .kinematics import Kinematics
from .layouts import (
    FEWEST,
    LAYOUTS,
    LOAD_FIGURE,
    RATIO_BAND,
    RATIO_LIMIT,
    Blank,
    Teeth,
    assembles,
    beside,
    counts_of_ratio,
    least_gap,
    nearest_teeth,
    neighbour_gap,
    said,
    tables_of,
)
from .resolution import kinematics_of, load
from .stages import plan_stages
from .train import ResolutionLog, Train

MEMBERS: tuple[Member, ...] = get_args(Member)
HELD: Mapping[str, tuple[str, ...]] = {kind: LAYOUTS[kind].held for kind in ("planetary", "star", "differential")}
"""Members of simple sets that may be held, by kind; the first one is held unless said otherwise."""
KINDS = tuple(HELD)
_POWER_GAP = 0.01  # power, torque and speed agree within the rounding of a data sheet
_MOST_PLANETS = 12  # more do not fit around any sun that a search finds
_MOST_STAGES = 6
_SPREAD = 3  # teeth by which the meshes of an axis may differ: shifts serve 1.5 modules of centre distance
_SHIFTS = Bounds(low=-2, high=2)  # of a gear that is given: beyond it no tooth is left
_ABOVE_ZERO = Bounds(low=0, above=True)
_SLANT = Bounds(low=0, high=math.radians(45))
_SIZES: Mapping[str, tuple[str, Bounds]] = {
    "module": ("length", Bounds(low=5e-5, high=0.1)),  # ISO 54 ends at 50 mm
    "face_width": ("length", Bounds(low=1e-4, high=5.0)),
    "helix_angle": ("angle", _SLANT),
    "pressure_angle": ("angle", _SLANT),
    "centre_distance": ("length", Bounds(low=1e-3, high=10.0)),
}
_PLAY = Bounds(low=0, high=math.radians(5), above=True)


@dataclass(frozen=True, slots=True)
class Wishes:
    """What is to be built.

    blanks : its stages, what was not given chosen.  others : further tooth counts of a ratio, of a single stage.
    path : members where the power enters and leaves every stage, ``main.sun``; none of a differential.
    operation : what stands under `[operation]` by path, ``speed.sun``; derived : those that follow, and from what.
    motion : speeds, torques and mesh torques of this operation.  backlash : at the output [rad], and as it was given.
    """

    blanks: tuple[Blank, ...]
    others: tuple[Teeth, ...]
    path: tuple[tuple[str, str], ...]
    operation: Mapping[str, Any]
    derived: Mapping[str, str]
    motion: Kinematics
    title: str
    backlash: tuple[float, str] | None


def read_wishes(options: NewTrainOptions) -> Wishes:
    """Read what a person says, and size the gears.

    Raises
    ------
    ModelError : what contradicts, cannot be assembled or does not fit: the keyword, what was given and what is allowed.
    """
    kinds = [word.strip() for word in str(options.kind).split(",")]
    for kind in kinds:
        _one_of(kind, tuple(LAYOUTS), "kind")
    if len(kinds) > _MOST_STAGES or (len(kinds) > 1 and "differential" in kinds):
        allowed = f"at most {_MOST_STAGES} stages, a differential alone"
        raise ModelError("not a train of these stages", path="kind", given=options.kind, allowed=allowed)
    names = ["main"] if len(kinds) == 1 else [f"stage{i + 1}" for i in range(len(kinds))]
    given = {key: _by_stage(getattr(options, key), len(kinds), key) for key in ("teeth", "planets", "held", *_SIZES)}
    given["kind"] = list(kinds)
    shifts = _shifts(options.profile_shift, dict(zip(names, kinds, strict=True)))
    of_stages = [dict(zip(given, values, strict=True)) for values in zip(*given.values(), strict=True)]
    drafts = [_draft(name, own, shifts[name]) for name, own in zip(names, of_stages, strict=True)]
    blanks, others = _with_teeth(drafts, options.ratio)
    path = () if kinds == ["differential"] else _through(blanks, options.driver)
    operation, derived = _operation(blanks, path, options) if path else (_differential(options), {})
    for blank in blanks:
        _check_teeth(blank)
    held = [_spoken(f"{blank.name}.{blank.held}") for blank in blanks if blank.held]
    operation = {**({"held": held} if held else {}), **operation}
    motion = _motion(blanks, operation, path)
    blanks = [layouts.size_of(blank, _torques(blank, motion)) for blank in blanks]
    play: dict[str, str] = {}
    backlash = _read(options.backlash, "angle", "backlash", _PLAY, play)
    if backlash is not None and not path:
        raise ModelError("a differential has no one output", path="backlash", given=play["backlash"], allowed="none")
    title = options.title or ", ".join(map(_titled, blanks))
    wanted = None if backlash is None else (backlash, play["backlash"])
    return Wishes(tuple(blanks), others, path, operation, derived, motion, title[0].upper() + title[1:], wanted)


def _titled(blank: Blank) -> str:
    planets = f" with {blank.planets} planet{'s' * (blank.planets > 1)}" if blank.layout.planets else ""
    return f"{blank.kind} {'set' if planets else 'pair'} {said(blank.teeth)}{planets}"


def _by_stage(value: Any, count: int, path: str) -> list[Any]:
    """Value of every stage: one for all, or a text with one a stage, empty for a choice. Raises ModelError."""
    if count == 1 or not isinstance(value, str) or "," not in value:
        return [value] * count
    entries = [entry.strip() or None for entry in value.split(",")]
    if len(entries) != count:
        problem, allowed = f"{len(entries)} entries of {count} stages", "one for all, or one a stage between commas"
        raise ModelError(problem, path=path, given=value, allowed=allowed)
    return entries


def _draft(name: str, given: Mapping[str, Any], shifts: Mapping[str, float]) -> Blank:
    """A stage before its size, and before its teeth where a ratio asks for them. Raises ModelError."""
    kind, planets, held = given["kind"], given["planets"], given["held"]
    layout = LAYOUTS[kind]
    planets = 3 if planets is None else int(planets) if isinstance(planets, str) and planets.isdecimal() else planets
    if isinstance(planets, bool) or not isinstance(planets, int) or not 1 <= planets <= _MOST_PLANETS:
        raise ModelError("no number of planets", path="planets", given=planets, allowed=f"1 to {_MOST_PLANETS}")
    if held is not None and held not in layout.held:
        if not layout.held:
            raise ModelError(f"nothing is held in a {kind} stage", path="held", given=held, allowed="leave it out")
        hint = "; with the carrier held it is a star" if kind == "planetary" and held == "carrier" else ""
        allowed = " or ".join(layout.held)
        raise ModelError(f"cannot be held in a {kind} set{hint}", path="held", given=held, allowed=allowed)
    texts: dict[str, str] = {}
    sizes = {key: _read(given[key], unit, key, bounds, texts) or 0.0 for key, (unit, bounds) in _SIZES.items()}
    sizes["pressure_angle"] = sizes["pressure_angle"] or _NORMAL_ANGLE
    several = len({layout.axis(planet) for planet in layout.planets}) > 1
    if sizes["centre_distance"] and (several or any(set(pair) <= set(shifts) for pair in layout.pairs)):
        problem = "its planets have several axes" if several else "the shifts of a pair say it already"
        allowed = "profile shifts, or a distance and one shift less"
        raise ModelError(problem, path="centre_distance", given=texts["centre_distance"], allowed=allowed)
    held = held or next(iter(layout.held), None)
    blank = Blank(name=name, kind=kind, teeth={}, planets=planets, held=held, shifts=shifts, texts=texts, **sizes)
    return blank if given["teeth"] is None else replace(blank, teeth=_given_teeth(given["teeth"], blank))


def _shifts(value: ByMember, kinds: Mapping[str, str]) -> dict[str, dict[str, float]]:
    """Given profile shifts by stage and gear; of several stages a gear has its stage before it. Raises ModelError."""
    shifts: dict[str, dict[str, float]] = {name: {} for name in kinds}
    gears = {_spoken(f"{name}.{gear}"): (name, gear) for name in kinds for gear in LAYOUTS[kinds[name]].gears}
    entries = _said_by_member(value) if value is not None else {}
    for word, shift in entries.items() if isinstance(entries, Mapping) else [(str(entries), "")]:
        _one_of(word, tuple(gears), "profile_shift")
        name, gear = gears[word]
        number = float(shift) if isinstance(shift, Real) and not isinstance(shift, bool) else shift
        try:
            shifts[name][gear] = cast(float, read_quantity(number, ("ratio",), _SHIFTS))
        except ModelError:
            allowed = f"a number within +-{_SHIFTS.high:g}"
            raise ModelError(
                "no profile shift", path="profile_shift", given=f"{word}={shift}", allowed=allowed
            ) from None
    return shifts


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
    texts[path] = value.strip() if isinstance(value, str) else quantity_text(float(value), kind)
    return number


# teeth ----------------------------------------------------------------------------------------------------------------


def _with_teeth(blanks: list[Blank], ratio: float | None) -> tuple[list[Blank], tuple[Teeth, ...]]:
    """Stages with their teeth, given or those of a ratio, and further teeth of that ratio, of a single stage.

    Raises
    ------
    ModelError : no teeth and no ratio, both in disagreement, a ratio that no such teeth have.
    """
    if ratio is not None and (isinstance(ratio, bool) or not isinstance(ratio, (int, float)) or not abs(ratio) < 1e5):
        raise ModelError("not a ratio", path="ratio", given=ratio, allowed="a number below 100 000 in size, 5.7")
    if ratio is not None and blanks[0].kind == "differential" and blanks[0].teeth:
        raise ModelError("says nothing of a differential", path="ratio", given=ratio, allowed="leave it out")
    if any(not blank.teeth for blank in blanks):
        return _searched(blanks, ratio)
    if ratio is not None:
        of_teeth = math.prod(_ratio(blank) for blank in blanks)
        asked = -abs(ratio) if of_teeth < 0 else ratio  # of what turns backwards of either sign
        if not abs(asked / of_teeth - 1) <= RATIO_LIMIT:
            held = f" with the {blanks[0].held} held" if len(blanks) == 1 and blanks[0].held else ""
            problem = f"the teeth {', '.join(said(blank.teeth) for blank in blanks)} have {of_teeth:.5g}{held}"
            allowed = "one of teeth and ratio, or both within 2 %"
            raise ModelError(problem, path="ratio", given=ratio, allowed=allowed)
    return blanks, ()


def _searched(blanks: list[Blank], ratio: float | None) -> tuple[list[Blank], tuple[Teeth, ...]]:
    """Stages with teeth looked for where there are none; each takes its part of what the others leave of the ratio."""
    alone = len(blanks) == 1
    found, others = list(blanks), tuple[Teeth, ...]()
    open_ = [i for i, blank in enumerate(blanks) if not blank.teeth]
    for blank in (blanks[i] for i in open_):
        known = blank.kind in ("star", "parallel") or (blank.kind == "planetary" and (alone or blank.held == "ring"))
        if not known or ratio is None:
            words = f"{'/'.join(blank.layout.gears)}, {blank.layout.example}"
            more = ", or a ratio" if known else "; a ratio says nothing of it"
            raise ModelError("is missing", path="teeth", allowed=words + more)
    assert ratio is not None
    least = 2.0 if alone and blanks[0].held == "ring" else 1.0
    backwards = not alone or blanks[0].kind != "planetary"
    rest = abs(ratio) / math.prod(abs(_ratio(blank)) for blank in blanks if blank.teeth)
    if not rest > least or (ratio < 0 and not backwards):
        raise ModelError("no ratio of such a set", path="ratio", given=ratio, allowed=f"above {least:g}")
    for i in open_:
        blank = found[i]
        target = (
            rest
            if alone
            else layouts.share_of_ratio(rest, [(found[k].kind, found[k].planets) for k in open_ if k >= i])
        )
        if blank.kind == "parallel":
            found[i] = replace(blank, teeth=layouts.pair_of_ratio(target))
        else:
            band = RATIO_BAND if i == open_[-1] else RATIO_LIMIT  # what follows takes up the rest
            try:
                best, *further = counts_of_ratio(target, blank, band)
            except ModelError as error:
                if alone:
                    raise
                problem, allowed = f"{target:.4g} is left for {blank.name}: {error.problem}", "another ratio, or stages"
                raise ModelError(problem, path="ratio", given=ratio, allowed=allowed) from None
            found[i], others = replace(blank, teeth=best), tuple(further) if alone else ()
        rest /= abs(_ratio(found[i]))
    if ratio < 0 < math.prod(map(_ratio, found)):
        problem, allowed = "the output of these stages turns with the input", f"{abs(ratio):g}, or a star among them"
        raise ModelError(problem, path="ratio", given=ratio, allowed=allowed)
    return found, others


def _given_teeth(teeth: str | Sequence[int], blank: Blank) -> dict[str, int]:
    """Teeth as typed, of all gears or of all but rings. Raises ModelError."""
    gears = blank.layout.gears
    allowed = f"{'/'.join(gears)}, {blank.layout.example}"
    parts = teeth.split("/") if isinstance(teeth, str) else list(teeth)
    try:
        numbers = [int(str(part).strip()) for part in parts]
    except ValueError:
        raise ModelError("not numbers of teeth", path="teeth", given=teeth, allowed=allowed) from None
    free = [name for name, gear in gears.items() if gear.kind != "ring"]
    if len(numbers) not in (len(gears), len(free)):
        raise ModelError(f"{len(numbers)} numbers", path="teeth", given=teeth, allowed=allowed)
    if min(numbers) < 3 or max(numbers) > 5000:
        raise ModelError("no number of teeth", path="teeth", given=teeth, allowed="3 to 5000 on each gear")
    if len(numbers) < len(gears):
        return blank.layout.with_rings(dict(zip(free, numbers, strict=True)))
    return dict(zip(gears, numbers, strict=True))


def _ratio(blank: Blank) -> float:
    """Speed of what drives a stage as a reducer per speed of what is driven [1]. Raises ModelError.

    Of a differential that with the ring held.
    """
    motion = _motion([blank], {"held": [f"{blank.name}.{blank.held or 'ring'}"] if blank.layout.planets else []})
    fast, slow = (motion.ratio[f"{blank.name}.{end}"][motion.freedoms[0]] for end in blank.layout.ends(blank.held))
    if not slow:
        problem = f"with these teeth the {blank.layout.ends(blank.held)[1]} does not turn"
        raise ModelError(problem, path="teeth", given=said(blank.teeth), allowed="other teeth")
    return float(fast / slow)


def _motion(blanks: Sequence[Blank], operation: Mapping[str, Any], path: Sequence[tuple[str, str]] = ()) -> Kinematics:
    """Speeds and torques of stages of one operation, by teeth alone. Raises ModelError at the keyword."""
    stages = {b.name: _members(replace(b, shifts={})) | {"module": "1 mm"} for b in blanks}
    couplings = {name: {"between": list(ends)} for name, ends in _joints(path).items()}
    document = {"format": 2, "title": "-", "stages": stages, "couplings": couplings, "operation": tables_of(operation)}
    model, log = read(document).model, ResolutionLog(assumed={})
    try:
        return kinematics_of(model, plan_stages(model, log), log)
    except ModelError as error:
        raise error.at(error.path.removeprefix("operation.").split(".")[0]) from None


def _joints(path: Sequence[tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Members that turn together where a stage hands over to the next, by the name of their coupling."""
    return {f"{a.split('.')[0]}-{b.split('.')[0]}": (a, b) for (_, a), (b, _) in itertools.pairwise(path)}


def _torques(blank: Blank, motion: Kinematics) -> dict[tuple[str, str], float]:
    """Torque of every pair of a stage on its first gear, of all branches together, in size [N m]."""
    teeth, of_pair = blank.teeth, motion.mesh_torque or {}
    paths = {(a, b): f"stages.{blank.name}.meshes.{a}-{b}" for a, b in blank.layout.pairs}
    return {(a, b): abs(of_pair[path]) * teeth[a] / teeth[b] for (a, b), path in paths.items()}


# speed and load -------------------------------------------------------------------------------------------------------


def _through(blanks: Sequence[Blank], driver: str | None) -> tuple[tuple[str, str], ...]:
    """Members where the power enters and leaves every stage, all of which reduce or all increase the speed."""
    first = blanks[0]
    fast, slow = first.layout.ends(first.held)
    if driver is not None:
        _one_of(driver, tuple(m for m in first.layout.shafts if m != first.held), "driver")
    into = driver or fast
    path = [(into, fast if into == slow else slow)]
    for fast_, slow_ in (blank.layout.ends(blank.held) for blank in blanks[1:]):
        path.append((slow_, fast_) if into == slow else (fast_, slow_))
    return tuple((f"{b.name}.{a}", f"{b.name}.{z}") for b, (a, z) in zip(blanks, path, strict=True))


def _operation(
    blanks: Sequence[Blank], path: Sequence[tuple[str, str]], options: NewTrainOptions
) -> tuple[dict[str, Any], dict[str, str]]:
    """Speed and load by path, and what follows from which. Raises ModelError for what is missing or contradicts."""
    begin, end = _spoken(path[0][0]), _spoken(path[-1][1])
    texts: dict[str, str] = {}
    driven: dict[str, float | None] = {}
    for key, example in _EXAMPLE.items():
        value = _said_by_member(getattr(options, key))
        if isinstance(value, Mapping):
            ends = " or ".join(m for m in blanks[0].layout.shafts if m != blanks[0].held)
            allowed = f'a text such as "{example}", and driver = {ends}'
            raise ModelError("one value: that of the driving member", path=key, given=dict(value), allowed=allowed)
        driven[key] = _read(value, key, key, _ABOVE_ZERO, texts)
    omega, moment, watts = driven["speed"], driven["torque"], driven["power"]
    derived: dict[str, str] = {}
    behind = _read(options.output_torque, "torque", "output_torque", _ABOVE_ZERO, texts)
    if behind is not None and (moment is not None or watts is not None):
        allowed = "one of torque, power and output_torque"
        raise ModelError("the load is given twice", path="output_torque", given=texts["output_torque"], allowed=allowed)
    if watts is not None and moment is not None and omega is not None:
        if abs(moment * omega / watts - 1) > _POWER_GAP:
            problem = f"torque x speed is {quantity_text(float(f'{moment * omega:.6g}'), 'power')}"
            raise ModelError(problem, path="power", given=texts["power"], allowed="two of power, torque and speed")
        del texts["power"]
    elif watts is not None and moment is not None:
        omega = watts / moment
        texts["speed"] = quantity_text(float(f"{omega / math.tau * 60:.6g}") * math.tau / 60, "speed")
        derived[f"speed.{begin}"] = f"{texts.pop('power')} / {texts['torque']}"
    for key, known in (("speed", omega), ("torque", watts or moment or behind)):
        if known is None:
            more = ", or power" if key == "torque" else ", or both torque and power"
            raise ModelError("is missing", path=key, allowed=f'that of the {begin}, "{_EXAMPLE[key]}"{more}')
    stated_ = {f"{key}.{begin}": texts[key] for key in _EXAMPLE if key in texts}
    if behind is not None:  # the load turns against what drives it
        sign = "-" if math.prod(map(_ratio, blanks)) > 0 else ""
        stated_[f"torque.{end}"] = sign + texts["output_torque"]
    if len(blanks) > 1 or len(blanks[0].layout.shafts) > 3:  # more than two free ends
        stated_[f"torque.{end if behind is None else begin}"] = "balance"
    return stated_, derived


def _spoken(member: str) -> str:
    """A member as the file has it: the only stage is not said."""
    return member.removeprefix("main.")


_EXAMPLE = {"speed": "1000 rpm", "torque": "7.2 kN m", "power": "750 kW"}


def _differential(options: NewTrainOptions) -> dict[str, Any]:
    """Speeds of two members and the load of one by path, each by its name. Raises ModelError."""
    for key in ("driver", "output_torque"):
        if (value := getattr(options, key)) is not None:
            raise ModelError("a differential names its members", path=key, given=value, allowed="leave it out")
    given = {key: _said_by_member(getattr(options, key)) for key in _EXAMPLE}
    if (given["torque"] is None) == (given["power"] is None):
        problem = "one of torque and power" if given["torque"] is not None else "is missing"
        raise ModelError(problem, path="torque", allowed='torque = {"sun": "500 N m"} or power, of one member')
    counts = {"speed": 2, "torque" if given["power"] is None else "power": 1}
    return {
        f"{key}.{member}": text
        for key, count in counts.items()
        for member, text in _by_member(given[key], key, count).items()
    }


def _by_member(value: object, path: str, count: int) -> dict[str, str]:
    """Text by member. Raises ModelError unless it names `count` of them."""
    example = ", ".join(f'"{m}": "{_EXAMPLE[path]}"' for m in MEMBERS[:count])
    allowed = f"{{{example}}}: {'two' if count == 2 else 'one'} of {', '.join(MEMBERS)}"
    if value is None:
        raise ModelError("is missing", path=path, allowed=allowed)
    if not isinstance(value, Mapping) or len(value) != count:
        given = dict(value) if isinstance(value, Mapping) else value
        raise ModelError(f"a differential needs that of {count}", path=path, given=given, allowed=allowed)
    texts: dict[str, str] = {}
    for member, number in value.items():
        _one_of(member, MEMBERS, path)
        _read(number, path, path, Bounds(), texts)
        texts[str(member)] = texts.pop(path)
    return texts


# a new train in Python ------------------------------------------------------------------------------------------------


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


# the train and its checks ---------------------------------------------------------------------------------------------

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
    train = _loaded(document, wishes)
    return NewTrain(document=document, comments=_comments(wishes, train), remarks=_remarks(wishes, train))


def _check_teeth(blank: Blank) -> None:
    """Raise ModelError for teeth that do not assemble, have no room, are too few, or that no shift brings together."""
    teeth, planets, kind, layout = blank.teeth, blank.planets, blank.kind, blank.layout
    if min(teeth[name] for name, gear in layout.gears.items() if gear.kind != "ring") < _UNDERCUT:
        raise ModelError("too few teeth", path="teeth", given=said(teeth), allowed=f"{_UNDERCUT} or more on each gear")
    _ratio(blank)  # that it turns
    spread = max(
        (max(sizes) - min(sizes) for by in layout.on_axis(teeth).values() if (sizes := by.values())), default=0
    )
    room = neighbour_gap(teeth, planets, blank.helix_angle, kind) >= least_gap(blank.module or None)
    if room and spread <= _SPREAD and assembles(teeth, planets, kind):
        return
    near = " or ".join(map(said, _near(blank)))
    if not room:
        problem = f"the tips of neighbouring planets of {said(teeth)} come nearer than one module"
        most = f"at most {next((n for n in range(planets - 1, 0, -1) if _takes(blank, n)), 1)} with these teeth"
        allowed = f"{most}; teeth that take {planets}: {near}" if near else most
        raise ModelError(problem, path="planets", given=planets, allowed=allowed)
    plain = layout.with_rings(teeth)
    rings = " and ".join(f"a {name} of {plain[name]}" for name in teeth if plain[name] != teeth[name])
    fitting = [n for n in range(2, planets + 4) if n != planets and _takes(blank, n)]
    if spread > _SPREAD:
        problem, more = "no profile shift brings the meshes to one centre distance", f"rings within {_SPREAD} teeth"
    else:
        problem = f"{planets} equally spaced planets cannot be assembled, the teeth do not meet"
        more = f"these teeth with {' or '.join(map(str, fitting))} planets" if fitting else ""
    problem += f"; the other gears make {rings} without profile shift" if rings else ""
    allowed = "; ".join(filter(None, (near, more))) or "other teeth"
    raise ModelError(problem, path="teeth", given=said(teeth), allowed=allowed)


def _near(blank: Blank) -> list[Teeth]:
    """Teeth nearest to those of a stage that take its planets, at most three."""
    tried = (replace(blank, teeth=teeth) for teeth in itertools.islice(nearest_teeth(blank), _MOST_TRIED))
    return [other.teeth for other in itertools.islice((one for one in tried if _takes(one, one.planets)), 3)]


def _takes(blank: Blank, planets: int) -> bool:
    """Whether the gears of a stage turn, and so many planets stand beside each other without a doubt."""
    module = blank.module or _TRIAL
    if not replace(blank, planets=planets).takes(blank.teeth):
        return False
    sized = replace(blank, module=module, face_width=10 * module, planets=planets, centre_distance=0.0, shifts={})
    size = {"module": module, "face_width": 10 * module, "helix_angle": blank.helix_angle}
    stage = {f"stages.{blank.name}": _members(sized) | size}
    try:
        _ratio(sized)
        train = load(tables_of({"format": 2, "title": "trial", **stage, **beside(sized)[0]}))
    except ModelError:
        return False
    return not {code_of(text) for text in train.warnings} & _DOUBTS


_TRIAL, _MOST_TRIED = 5e-3, 60  # [m] module, and number, of teeth that are tried
_DOUBTS = {"not-assembled", "shafts-not-alike", "gears-overlap", "planets-collide", "centre-distances-differ"}


def _loaded(document: Mapping[str, Any], wishes: Wishes) -> Train:
    """The train of the document. Raises ModelError for planets that collide and shifts that fit no one distance."""
    try:
        train = load(document)
    except ModelError as error:
        key = error.path.rpartition(".")[2]
        if key not in ("planets", "centre_distance", "profile_shift"):
            raise
        blank = next(b for b in wishes.blanks if error.path.startswith(f"stages.{b.name}."))
        near = " or ".join(map(said, _near(blank))) if key == "planets" else ""
        allowed = f"{error.allowed}; teeth that take {blank.planets}: {near}" if near else error.allowed
        if key == "profile_shift" and not blank.shifts:  # which the distance asks for
            problem, given_ = f"asks for a profile shift of {error.given}", blank.texts["centre_distance"]
            raise ModelError(
                problem, path="centre_distance", given=given_, allowed="one nearer to that without"
            ) from None
        raise ModelError(error.problem, path=key, given=error.given, allowed=allowed) from None
    given = ", ".join(f"{gear}={shift:g}" for blank in wishes.blanks for gear, shift in blank.shifts.items())
    if any(code_of(text) == "centre-distances-differ" for text in train.warnings):
        problem = "these put the meshes of an axis at different centre distances"
        raise ModelError(problem, path="profile_shift", given=given, allowed="one less of them: it follows")
    return train


# the document ---------------------------------------------------------------------------------------------------------


def _document(wishes: Wishes) -> dict[str, Any]:
    """The whole document, reasons of what was chosen under `assumed`."""
    values: dict[str, Any] = {"format": 2, "title": wishes.title, "damping.modal": layouts.DAMPING}
    tolerance: dict[str, Any] = {}
    assumed = {f"operation.{path}": reason for path, reason in wishes.derived.items()}
    for blank in wishes.blanks:
        found, zones, reasons = beside(blank)
        sizes, chosen = _sizes(blank, wishes)
        values |= {f"stages.{blank.name}": _members(blank) | sizes, **found}
        tolerance |= zones
        assumed |= {**chosen, **reasons}
    if wishes.backlash is not None:
        play = _play(wishes, wishes.backlash[0])
        out = _spoken(wishes.path[-1][1])
        values |= play
        assumed |= dict.fromkeys(
            play, f"{wishes.backlash[1]} at {out} with the input at rest, all meshes alike by module"
        )
    couplings = {f"couplings.{name}": _shaft(wishes, name, ends) for name, ends in _joints(wishes.path).items()}
    shaft = f"a steel shaft with {_TORSION / 1e6:g} N/mm^2 of torsion, {_SLENDER} diameters long"
    assumed |= {f"{path}.rz": shaft for path in couplings}
    assumed["damping.modal"] = "a usual value; a response needs damping, 0.01 to 0.1"
    assumed["tolerance"] = "grades and zones as usual, to be replaced by those of the drawing"
    tables = tables_of(values | couplings | {f"operation.{path}": value for path, value in wishes.operation.items()})
    return {**tables, "tolerance": tolerance, "assumed": assumed}


def _sizes(blank: Blank, wishes: Wishes) -> tuple[dict[str, Any], dict[str, str]]:
    """What the table of a stage says of its size, given or chosen, and the reasons of what was chosen."""
    texts, path, width = blank.texts, f"stages.{blank.name}", f"0.8 d of the {blank.pinion}"
    figure = f"preselection, no strength rating: {_k(wishes, blank)}, at most {LOAD_FIGURE / 1e6:g}"
    reasons = {}
    if "module" not in texts:
        near = "that of series I of ISO 54 nearest to the centre distance"
        reasons[f"{path}.module"] = near if blank.centre_distance else f"{figure}; series I of ISO 54"
    if "face_width" not in texts:
        reasons[f"{path}.face_width"] = width if "module" not in texts else f"{figure}; {width}"
    sizes = {**{key: quantity_text(getattr(blank, key), "length") for key in ("module", "face_width")}, **texts}
    order = ("module", "pressure_angle", "helix_angle", "face_width", "centre_distance")
    return {key: sizes[key] for key in order if key in sizes}, reasons


def _members(blank: Blank) -> dict[str, Any]:
    """Tables of the members of a stage, and of its meshes where these do not go without saying."""
    layout, table = blank.layout, dict[str, Any]({"planets": blank.planets} if blank.layout.planets else {})
    for name, (kind, on, _) in layout.gears.items():
        gear = {} if name in KIND_BY_NAME else {"kind": kind}
        shift = {"profile_shift": blank.shifts[name]} if name in blank.shifts else {}
        table[name] = {**gear, "teeth": blank.teeth[name], **({"on": on} if on else {}), **shift}
    table |= {"carrier": {}} if layout.planets else {}
    return table | ({"meshes": {f"{a}-{b}": {} for a, b in layout.pairs}} if len(layout.gears) > 3 else {})


def _play(wishes: Wishes, backlash: float) -> dict[str, str]:
    """Normal backlash of every mesh by path, in proportion to its module, for one at the output [rad].

    With the input at rest the output turns by sum_k |M_k/T_out| j_k/(r_bk cos beta_b), M_k the torque of a mesh on a
    gear of base radius r_bk under the torque T_out: virtual work of the gaps.
    """
    output, per_module = (wishes.motion.torque or {})[wishes.path[-1][1]], 0.0
    for blank in wishes.blanks:
        slant = math.cos(geometry.base_helix_angle(blank.pressure_angle, blank.helix_angle))
        for (a, _), torque in _torques(blank, wishes.motion).items():
            base = geometry.base_radius(blank.teeth[a], blank.module, blank.pressure_angle, blank.helix_angle)
            per_module += abs(torque / output) * blank.module / (base * slant)
    share = backlash / per_module
    return {
        f"stages.{blank.name}.meshes.{a}-{b}.backlash": quantity_text(float(f"{share * blank.module:.6g}"), "length")
        for blank in wishes.blanks
        for a, b in blank.layout.pairs
    }


_TORSION, _SLENDER, _SHEAR = 40e6, 4, 8.08e10  # [Pa] of a shaft between stages; lengths per diameter; [Pa] steel


def _shaft(wishes: Wishes, name: str, ends: tuple[str, str]) -> dict[str, Any]:
    """Coupling of two members of different stages: the shaft between them."""
    torque = abs((wishes.motion.tie_torque or {})[name])
    diameter = (16 * torque / (math.pi * _TORSION)) ** (1 / 3)
    stiffness = float(f"{_SHEAR * math.pi * diameter**3 / (32 * _SLENDER):.2g}")
    return {"between": list(ends), "rz": quantity_text(stiffness, "torsional_stiffness")}


# what follows ---------------------------------------------------------------------------------------------------------


def _comments(wishes: Wishes, train: Train) -> dict[str, str]:
    """Derived values by the path they stand at."""
    comments = {
        "operation": "without weights; gravity = true counts them",
        "deviations": "what manufacturing leaves over",
        "tolerance": "what the drawing allows, from one train to the next",
        "assumed": "chosen, not given: every value here wants yours",
    }
    for blank in wishes.blanks:
        comments |= _stage_comments(blank, train)
    return comments | dict(_operation_comments(wishes, train))


def _stage_comments(blank: Blank, train: Train) -> dict[str, str]:
    """Derived values of a stage by path."""
    path, layout = f"stages.{blank.name}", blank.layout
    mesh = {tuple(m.pair.split(".")[-1].split("-")): m for m in train.meshes if m.pair.startswith(f"{path}.")}
    gears = {body.member: gear for body in train.bodies if (gear := body.gear) is not None}
    first = mesh[layout.pairs[0]]
    centre = in_mm(first.radius_a + first.radius_b)
    of_stage = [f"ratio {_ratio(blank):.5g}, {' to '.join(layout.ends(blank.held))}"] * (blank.kind != "differential")
    of_stage.append(f"centre distance {centre}")
    if (rate := (train.kinematics.mesh_frequency or {}).get(blank.name)) is not None:
        of_stage.append(f"mesh frequency {float(rate):.6g} Hz")
    # "contact" takes seconds of computing, and a train without relief does not need it
    relief = 'of each gear; tip relief would count with meshes.*.stiffness = "contact"'
    comments = {path: "; ".join(of_stage), f"{path}.face_width": relief}
    if layout.planets:
        comments[f"{path}.carrier"] = f"pins on a circle of {centre} radius"
    for member in layout.gears:
        gear = gears[f"{blank.name}.{member}"]
        words = [f"reference diameter {in_mm(2 * gear.reference_radius)}"]
        if gear.profile_shift and member not in blank.shifts:
            words.append(f"profile shift {gear.profile_shift:.4g}")
        for pair in layout.pairs if member not in layout.planets else ():
            if member in pair:
                mate = pair[member == pair[0]]
                words.append(f"contact ratio with {'a ' * (mate == 'planet')}{mate} {mesh[pair].contact_ratio:.2f}")
                if member == pair[0] and blank.helix_angle:
                    words[-1] += f", overlap {mesh[pair].overlap_ratio:.2f}"
        comments[f"{path}.{member}"] = "; ".join(words)
    return comments


def _operation_comments(wishes: Wishes, train: Train) -> Iterator[tuple[str, str]]:
    """Speeds, torques and power of the members that the operation does not state."""
    motion, stated_ = train.kinematics, [path for path, text in wishes.operation.items() if text != "balance"]
    shafts = [f"{b.name}.{m}" for b in wishes.blanks for m in b.layout.shafts]
    turning = [m for m in shafts if _spoken(m) not in wishes.operation.get("held", ())]
    turning += [f"{b.name}.{p}" for b in wishes.blanks for p in b.layout.planets if not b.layout.gears[p].on]
    if motion.speed:
        *_, last = (path for path in stated_ if path.startswith("speed."))
        free = [m for m in turning if f"speed.{_spoken(m)}" not in stated_]
        yield f"operation.{last}", ", ".join(f"{_spoken(m)} {float(motion.speed[m]):.6g} rpm" for m in free)
    if motion.torque:
        loaded = next(path for path in stated_ if path.startswith(("torque.", "power.")))
        torques = {_spoken(m): motion.torque[m] for m in shafts if f"torque.{_spoken(m)}" not in stated_}
        words = [f"{m} {quantity_text(float(f'{t:.5g}'), 'torque')}" for m, t in torques.items() if t]
        first = wishes.path[0][0] if wishes.path and loaded.startswith("torque.") else ""
        if driven := (motion.power or {}).get(first):
            words.append(f"power {quantity_text(float(f'{driven:.5g}'), 'power')}")
        yield f"operation.{loaded}", f"{', '.join(words)}; counter-clockwise positive"


def _remarks(wishes: Wishes, train: Train) -> tuple[str, ...]:
    """What a person should know of what was chosen."""
    words, several = [], len(wishes.blanks) > 1
    if several:
        ratios = [abs(_ratio(blank)) for blank in wishes.blanks]
        words.append(f"Ratio {math.prod(ratios):.5g} = {' x '.join(f'{r:.5g}' for r in ratios)}.")
    for blank in wishes.blanks:
        words += [f"{blank.name}: " * several + text for text in _stage_remarks(blank, wishes)]
    return *words, *(f"{text}." for text in train.warnings)


def _stage_remarks(blank: Blank, wishes: Wishes) -> Iterator[str]:
    """What a person should know of what was chosen of a stage."""
    gears = blank.layout.gears
    if wishes.others:  # found by a ratio
        first, *others = (f"{said(t)} ({_ratio(replace(blank, teeth=t)):.5g})" for t in (blank.teeth, *wishes.others))
        yield f"Teeth {first}; as well: {', '.join(others)}."
    if not {"module", "face_width"} <= set(blank.texts):
        yield f"Module and face width: preselection by {_k(wishes, blank)}, no strength rating."
    if layouts.load_figure(blank, _torques(blank, wishes.motion)) > LOAD_FIGURE * 1.000001:
        yield f"{_k(wishes, blank)} is above {LOAD_FIGURE / 1e6:g}: rate the strength of these gears."
    sun = next((blank.teeth[name] for name, gear in gears.items() if gear.kind == "sun"), None)
    if sun is not None and blank.planets > 2:
        yield _phasing_words(sun, blank.planets)
    low = [name for name, gear in gears.items() if gear.kind != "ring" and blank.teeth[name] < FEWEST]
    if low and not layouts.shifts_of(blank):
        yield f"The {' and the '.join(low)} may be undercut: fewer than {FEWEST} teeth and no profile shift."
    if blank.helix_angle and geometry.overlap_ratio(blank.face_width, blank.helix_angle, blank.module) < 1:
        yield "The overlap ratio is below 1: not at every moment does a whole helix carry."


def _k(wishes: Wishes, blank: Blank) -> str:
    return f"K = {layouts.load_figure(blank, _torques(blank, wishes.motion)) / 1e6:.2g} N/mm^2"


def _phasing_words(sun: int, planets: int) -> str:
    """What the meshes with the sun do together at the mesh frequency: the sum over exp(2 pi i z_s k/N) [parker2004]."""
    if sun % planets == 0:
        return "z_s/N is whole: at the mesh frequency the planets pull at the sun alike, torque adds up, forces cancel."
    if (sun + 1) % planets == 0 or (sun - 1) % planets == 0:
        return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, forces across its axis add up."
    return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, and so do forces across its axis."
