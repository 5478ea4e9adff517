"""The teeth of a stage: what a chain shares, hands, widths, radii; given distances, and the shifts that follow."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from operator import mul
from typing import NamedTuple

from ..document.writer import quantity_text
from ..errors import ModelError, in_mm
from ..teeth import geometry
from .kinematics import spread
from .stages import GearPair, Plan, origin_of, sides_of, stated, stated_value
from .train import GearData, ResolutionLog, Teeth, same

DEFAULTS = {"pressure_angle": math.radians(20.0), "helix_angle": 0.0}
HANDS = {"right": 1, "left": -1}
_HELIX = math.radians(1e-3)  # below it a face is as long as 50 000 modules before a tooth overlaps the next
FAR_RADIUS = 0.01  # given base radii of rounded print agree with teeth and module to a few per mille
# Three printed digits are off by up to half of the last one: 0.005 of the 1.00 where that weighs most.
ROUNDED_RADIUS = 0.005


def teeth_of_stage(plan: Plan, log: ResolutionLog) -> dict[str, Teeth]:
    """Module, angles, hands and base radii of all gears of a stage.

    Raises
    ------
    ModelError : a module, angle or hand that contradicts its chain, no module and no base radius.
    """
    teeth: dict[str, Teeth] = {}
    for number in dict.fromkeys(plan.chains[name] for name in plan.gears):
        teeth |= _chain_teeth(plan, tuple(name for name in plan.gears if plan.chains[name] == number), log)
    return {name: teeth[name] for name in plan.gears}


def _chain_teeth(plan: Plan, chain: tuple[str, ...], log: ResolutionLog) -> Iterator[tuple[str, Teeth]]:
    """Teeth of the gears of one chain, which share module, pressure angle and helix angle. Raises ModelError."""
    helix = _shared(plan, chain, "helix_angle", log)
    if 0 < helix < _HELIX:
        stating = (plan.member_path(name) for name in chain if plan.gears[name].helix_angle is not None)
        path, given = f"{next(stating, plan.path)}.helix_angle", f"{math.degrees(helix):.3g} deg"
        raise ModelError("is no helix", path=path, given=given, allowed=f"0, or from {math.degrees(_HELIX):g} deg on")
    normal = _shared(plan, chain, "pressure_angle", log)
    module, from_module = _module(plan, chain, (normal, helix), log)
    hands = _hands(plan, chain, helix, log)
    by_teeth = {n: geometry.base_radius(plan.gears[n].teeth or 0, module, normal, helix) for n in chain}
    scaled = _scaled_to_teeth(plan, by_teeth, from_module, log)
    for name, nominal in by_teeth.items():
        member = plan.gears[name]
        base = member.base_radius if member.base_radius is not None and name not in scaled else nominal
        origin = "geometry" if member.base_radius is None or name in scaled else "given"
        log.note(f"{plan.member_path(name)}.base_radius", base, "m", origin)
        teeth = Teeth(
            teeth=member.teeth or 0,
            internal=member.kind == "ring",
            module=module,
            pressure_angle=normal,
            helix_angle=helix,
            hand=hands[name],
            nominal_base=nominal,
            base_radius=base,
        )
        yield name, teeth


def _scaled_to_teeth(plan: Plan, by_teeth: Mapping[str, float], from_module: bool, log: ResolutionLog) -> set[str]:
    """Gears of a chain under load whose stated base radii give way to those by the teeth, with a warning.

    Speeds and torques follow from teeth: on radii in another ratio a train that turns as it must stresses its teeth,
    and no torque balances.  Without a load nothing needs that balance, and radii stay as stated; so do radii that are
    further off than rounding in print: they are another drawing than the teeth.
    by_teeth : base radii by teeth and module [m].  from_module : the module is stated.
    """
    stated = {name: radius for name in by_teeth if (radius := plan.gears[name].base_radius) is not None}
    missed = {name: radius for name, radius in stated.items() if not same(radius, by_teeth[name])}
    share = {name: abs(radius / by_teeth[name] - 1) for name, radius in missed.items()}
    rounded = all(value <= ROUNDED_RADIUS for value in share.values())
    for name, radius in missed.items():
        if (from_module and share[name] > FAR_RADIUS) or (plan.loaded and share[name] > ROUNDED_RADIUS):
            text = f"{plan.member_path(name)}.base_radius = {in_mm(radius, 4)} is far from teeth and module,"
            log.coded("base-radius-far", f"{text} which give {in_mm(by_teeth[name], 4)}")
    if not plan.loaded or not missed or not rounded:
        return set()
    texts = [f"{name} {radius * 1e3:.6g} to {by_teeth[name] * 1e3:.6g} mm" for name, radius in missed.items()]
    text = f"{plan.path}: base radii are scaled to the ratios of the teeth, without which no torque balances:"
    log.coded("base-radius-scaled", f"{text} {', '.join(texts)}")
    return set(missed)


def _stated_in_chain(plan: Plan, chain: tuple[str, ...], key: str) -> dict[str, float]:
    """Values that the gears of a chain state themselves, by gear. Raises ModelError where two differ."""
    given: dict[str, float] = {name: value for name in chain if (value := getattr(plan.gears[name], key)) is not None}
    first, kind = next(iter(given), ""), "angle" if key.endswith("angle") else "length"
    for name, value in given.items():
        if not same(value, given[first]):
            problem = f"contradicts its chain: {first} has {quantity_text(given[first], kind)}"
            path, allowed = f"{plan.member_path(name)}.{key}", "one value along a chain of meshing gears"
            raise ModelError(problem, path=path, given=quantity_text(value, kind), allowed=allowed)
    return given


def _shared(plan: Plan, chain: tuple[str, ...], key: str, log: ResolutionLog) -> float:
    """Pressure or helix angle of a chain of meshing gears [rad]: of a gear, else the stage, else the default."""
    given = _stated_in_chain(plan, chain, key)
    stage = getattr(plan.stage, key)
    value, origin = DEFAULTS[key], "default"
    if given:
        first = next(iter(given))
        value, origin = given[first], f"as {first}"
    elif stage is not None:
        value, origin = float(stage), "stage"
        log.note(f"{plan.path}.{key}", value, "rad")
    for name in chain:
        log.note(f"{plan.member_path(name)}.{key}", value, "rad", "given" if name in given else origin)
    return value


def _module(plan: Plan, chain: tuple[str, ...], angles: tuple[float, float], log: ResolutionLog) -> tuple[float, bool]:
    """Normal module of a chain [m], and whether it is stated; else it follows from the stated base radii.

    angles : normal pressure angle and helix angle [rad].
    """
    slant = math.cos(angles[1])
    given = _stated_in_chain(plan, chain, "module")
    tilted = {name: value * slant for name, value in _stated_in_chain(plan, chain, "transverse_module").items()}
    both, stage = given | tilted, plan.stage
    if both:
        first = next(iter(both))
        for name, value in both.items():
            if not same(value, both[first]):
                key = "module" if name in given else "transverse_module"
                raise ModelError(
                    f"contradicts its chain: {first} has a normal module of {quantity_text(both[first], 'length')}",
                    path=f"{plan.member_path(name)}.{key}",
                    given=quantity_text(getattr(plan.gears[name], key), "length"),
                    allowed="one module along a chain of meshing gears",
                )
        value, origin = both[first], f"as {first}"
    elif stage.module is not None or stage.transverse_module is not None:
        value = stage.module if stage.module is not None else (stage.transverse_module or 0.0) * slant
        origin = "stage"
        log.note(f"{plan.path}.module", value, "m", "given" if stage.module is not None else "geometry")
    else:
        radii = [(m.base_radius, m.teeth) for name in chain if (m := plan.gears[name]).base_radius is not None]
        if len(radii) < len(chain):
            raise ModelError(
                "is missing",
                path=f"{plan.member_path(chain[0])}.module",
                allowed="module or transverse_module of the stage or of a gear of the chain, "
                "or base_radius of every gear",
            )
        # the mean over the gears
        units = [base / geometry.base_radius(teeth or 1, 1.0, *angles) for base, teeth in radii if base is not None]
        value, origin = math.fsum(units) / len(units), "base radii"
    for name in chain:
        log.note(f"{plan.member_path(name)}.module", value, "m", "given" if name in given else origin)
    return value, origin != "base radii"


def _hands(plan: Plan, chain: tuple[str, ...], helix: float, log: ResolutionLog) -> dict[str, int]:
    """Hand of every gear of a chain, +1 right, -1 left, 0 spur: one is stated, the others follow, default right."""
    pairs = [(p, 1 if p.internal else -1) for p in plan.pairs if p.a in chain]
    relative = spread({chain[0]: 1}, [(*ends, sign) for p, sign in pairs for ends in ((p.a, p.b), (p.b, p.a))], mul)
    for p, sign in pairs:
        if helix and relative[p.b] != relative[p.a] * sign:
            raise ModelError("these hands cannot mesh all the way round", path=p.path, given=f"{p.a}, {p.b}")
    given = {n: HANDS[word] for n in chain if (word := plan.gears[n].hand) is not None}
    first = next(iter(given), chain[0])
    base = given.get(first, 1) * relative[first]
    for name, hand in given.items():
        if hand != base * relative[name]:
            problem, path = f"contradicts its chain: it follows from {first}", f"{plan.member_path(name)}.hand"
            raise ModelError(problem, path=path, given=plan.gears[name].hand, allowed="left" if hand > 0 else "right")
    if helix == 0.0:
        return dict.fromkeys(chain, 0)
    for name in chain:
        origin = "given" if name in given else f"as {first}" if given or name != first else "default"
        log.note(f"{plan.member_path(name)}.hand", "right" if base * relative[name] > 0 else "left", "", origin)
    return {name: base * relative[name] for name in chain}


def width_of(plan: Plan, name: str, side: str | None = None) -> float | None:
    """Face width of one helix [m]: of the side, the gear, the stage; None where none states it."""
    width: float | None = stated_value(plan.levels(name, side), "face_width", None)
    return width


def gap_of(plan: Plan, name: str) -> float:
    """Gap between the two helices [m]."""
    return float(stated_value(plan.levels(name), "gap", 0.0))


def half_station(plan: Plan, member: str, side: str | None) -> float:
    """Axial place of a body or helix [m]: of a half, half a width and half the gap from the member's centre."""
    table = plan.stage.members[member]
    centre = table.station or 0.0
    if side is None:
        return centre
    if table.kind == "carrier":
        planet = next((name for name in plan.gears if not plan.central(name)), None)
        if planet is None:
            return centre
        return centre + half_station(plan, planet, side) - (plan.stage.members[planet].station or 0.0)
    offset = ((width_of(plan, member, side) or 0.0) + gap_of(plan, member)) / 2
    return centre + (offset if side == "right" else -offset)


def finish_gear(
    plan: Plan, name: str, teeth: Teeth, shift: tuple[float, str], log: ResolutionLog
) -> dict[str | None, GearData]:
    """Toothed part of every half of a gear, by side, with tip and root radii [m].

    shift : profile shift [1] and its origin.

    Raises
    ------
    ModelError : a shift that leaves no tooth.
    """
    member, path = plan.gears[name], plan.member_path(name)
    log.note(f"{path}.profile_shift", shift[0], "", shift[1])
    levels = plan.levels(name)
    log.note(f"{path}.herringbone", plan.herringbone(name), "", origin_of(stated(levels, "herringbone")))
    log.note(f"{path}.split", plan.split(name), "", origin_of(stated(levels, "split")))
    log.note(f"{path}.gap", gap_of(plan, name), "m", origin_of(stated(levels, "gap")))
    toothed = {side: _gear_data(plan, name, teeth, shift[0], side) for side in sides_of(plan, name)}
    first = next(iter(toothed.values()))
    width = width_of(plan, name)
    if width is not None:
        log.note(f"{path}.face_width", width, "m", origin_of(stated(levels, "face_width")))
    for key, radius in (("tip_diameter", first.tip_radius), ("root_diameter", first.root_radius)):
        log.note(f"{path}.{key}", 2 * radius, "m", "geometry" if getattr(member, key) is None else "given")
    if first.tip_radius <= 0 or (first.root_radius <= 0 and not teeth.internal):
        raise ModelError("leaves no tooth", path=f"{path}.profile_shift", given=shift[0])
    if (first.root_radius >= first.tip_radius) is not teeth.internal:
        key, radius = ("root", first.root_radius) if member.root_diameter is not None else ("tip", first.tip_radius)
        problem = "the tip lies beyond the root: no tooth is left"
        raise ModelError(problem, path=f"{path}.{key}_diameter", given=f"{2e3 * radius:.4g} mm")
    return toothed


def _gear_data(plan: Plan, name: str, teeth: Teeth, shift: float, side: str | None) -> GearData:
    """Geometry of one half of a gear [m, rad]; tip and root stated, else from the shift [iso21771]."""
    member = plan.gears[name]
    addendum = float(stated_value(plan.levels(name, side), "addendum", 1.0))
    dedendum = float(stated_value(plan.levels(name, side), "dedendum", 1.25))
    size = teeth.teeth, teeth.module, teeth.helix_angle
    tip = geometry.tip_radius(*size, internal=teeth.internal, profile_shift=shift, addendum=addendum)
    root = geometry.root_radius(*size, internal=teeth.internal, profile_shift=shift, dedendum=dedendum)
    return GearData(
        **asdict(replace(teeth, hand=-teeth.hand) if side == "right" else teeth),
        face_width=width_of(plan, name, side),
        gap=gap_of(plan, name),
        herringbone=plan.herringbone(name) and side is None,
        tip_radius=tip if member.tip_diameter is None else member.tip_diameter / 2,
        root_radius=root if member.root_diameter is None else member.root_diameter / 2,
        reference_radius=geometry.reference_radius(*size),
        profile_shift=shift,
        addendum=addendum,
        dedendum=dedendum,
    )


# distances and shifts -------------------------------------------------------------------------------------------------

LARGEST_SHIFT = 5.0  # as in the file format; far beyond any tooth


class GivenLength(NamedTuple):
    """A centre distance or pin radius that the file states: where, and its value [m]."""

    path: str
    value: float


def given_distances(plan: Plan, log: ResolutionLog) -> Iterator[tuple[str, GivenLength]]:
    """Given centre distance of every pair that has one; two that differ are a warning, the nearest one counts."""
    radii = {axis: given_radius(plan, axis, log) for axis in dict.fromkeys(plan.axis.values())}
    for p in plan.pairs:
        stated = [(f"{p.path}.centre_distance", p.keys.centre_distance)]
        planets = [name for name in (p.a, p.b) if not plan.central(name)]
        if len(planets) == 1:
            radius = radii[plan.axis[planets[0]]]
            stated += [] if radius is None else [radius]
        elif not planets:
            stated.append((f"{plan.path}.centre_distance", plan.stage.centre_distance))
        value = _first(stated, log)
        if value is not None:
            yield p.name, value


def given_radius(plan: Plan, axis: str, log: ResolutionLog) -> GivenLength | None:
    """Given radius of one planet axis."""
    if plan.central(axis):
        return None
    on_axis = [name for name in plan.gears if plan.axis[name] == axis]
    stated = [(f"{plan.member_path(name)}.pin_radius", plan.gears[name].pin_radius) for name in on_axis]
    axes = list(dict.fromkeys(plan.axis[name] for name in plan.gears if not plan.central(name)))
    if plan.carrier is not None and axis == axes[0]:
        member = plan.stage.members[plan.carrier]
        stated.append((f"{plan.member_path(plan.carrier)}.pin_radius", member.pin_radius))
    meets = {q for p in plan.pairs for q in (p.a, p.b) if plan.central(p.a) or plan.central(p.b)}
    if any(name in meets for name in on_axis):
        stated.append((f"{plan.path}.centre_distance", plan.stage.centre_distance))
    return _first(stated, log)


def _first(stated: Sequence[tuple[str, float | None]], log: ResolutionLog) -> GivenLength | None:
    """First stated centre distance, with a warning for each one that differs."""
    given = [GivenLength(path, value) for path, value in stated if value is not None]
    for path, value in given[1:]:
        if not same(value, given[0].value, 1e-6):
            text = f"centre distances differ: {given[0].path} {in_mm(given[0].value)},"
            log.coded("centre-distances-differ", f"{text} {path} {in_mm(value)}; the first one counts")
    return given[0] if given else None


def profile_shifts(
    plan: Plan, teeth: Mapping[str, Teeth], given: Mapping[str, GivenLength]
) -> dict[str, tuple[float, str]]:
    """Profile shift of every gear and where it comes from; what a centre distance fixes follows, the rest is 0.

    Raises
    ------
    ModelError : a centre distance that no shift of a tooth can serve.
    """
    known = {n: (float(x), "given") for n, m in plan.gears.items() if (x := m.profile_shift) is not None}
    distance = {pair: length.value for pair, length in given.items()}
    distance |= _distances_from_shifts(plan, teeth, known, given)
    for p in plan.pairs:
        if p.name not in distance or (p.a in known and p.b in known):
            continue
        total = _shift_sum(p, teeth, distance[p.name])
        if total is None:
            continue
        # one of the two is known, else that of a is 0
        one, other = (p.b, p.a) if p.b in known else (p.a, p.b)
        known[other] = (total - known.setdefault(one, (0.0, "default"))[0], "geometry")
    for name, (shift, _) in known.items():
        if abs(shift) > LARGEST_SHIFT:
            problem = f"the centre distance asks for a profile shift of {shift:.3g}, no tooth is left"
            path = f"{plan.member_path(name)}.profile_shift"
            allowed = f"a centre distance nearer to that of teeth and module, shifts within +-{LARGEST_SHIFT:g}"
            raise ModelError(problem, path=path, given="(from the centre distance)", allowed=allowed)
    return {name: known.get(name, (0.0, "default")) for name in plan.gears}


def _distances_from_shifts(
    plan: Plan, teeth: Mapping[str, Teeth], known: Mapping[str, tuple[float, str]], given: Collection[str]
) -> dict[str, float]:
    """Centre distance [m] of pairs on an axis that has a central mesh with two stated shifts.

    given : pairs whose distance the file states.
    """
    distances: dict[str, float] = {}
    for p in plan.pairs:
        planet = next((n for n in (p.a, p.b) if not plan.central(n)), None)
        if planet is None or plan.central(p.a) == plan.central(p.b) or not (p.a in known and p.b in known):
            continue
        for q in plan.pairs:
            on_axis = any(plan.axis[n] == plan.axis[planet] for n in (q.a, q.b) if not plan.central(n))
            if on_axis and plan.central(q.a) != plan.central(q.b) and q.name not in given:
                distances.setdefault(q.name, distance_from_shifts(p, teeth, known[p.a][0], known[p.b][0])[1])
    return distances


def _shift_sum(p: GearPair, teeth: Mapping[str, Teeth], distance: float) -> float | None:
    """Sum of shifts with which a pair works at a distance; None where its base circles do not allow it."""
    a, b = teeth[p.a], teeth[p.b]
    if not (a.nominal and b.nominal):
        return None
    angle = geometry.working_pressure_angle_at(distance, a.base_radius, b.base_radius, internal=p.internal)
    if math.isnan(angle):
        return None
    total = geometry.shift_sum(
        a.teeth, b.teeth, a.pressure_angle, a.helix_angle, working_pressure_angle=angle, internal=p.internal
    )
    return 0.0 if abs(total) < 1e-9 else total


def distance_from_shifts(
    p: GearPair, teeth: Mapping[str, Teeth], shift_a: float, shift_b: float
) -> tuple[float, float]:
    """Working angle [rad] and centre distance [m] of a pair by its teeth and shifts."""
    a, b = teeth[p.a], teeth[p.b]
    angle = geometry.working_pressure_angle(
        a.teeth, b.teeth, a.pressure_angle, a.helix_angle, shift_a=shift_a, shift_b=shift_b, internal=p.internal
    )
    distance = geometry.centre_distance(
        a.teeth,
        b.teeth,
        a.module,
        a.helix_angle,
        pressure_angle=a.pressure_angle,
        working_pressure_angle=angle,
        internal=p.internal,
    )
    return angle, distance
