"""Kinds of stages, and the preselection of a new train: tooth counts, module and face width, what stands beside them.

One table describes every kind: which gears it has, which of them mesh, and what follows from their teeth alone.  Teeth
are a mapping of gears to their numbers, positive, of a ring too; lengths are per module, all gears of a stage having
one.  Tooth counts of a ratio are those of a simple planetary set or of a pair, and each stage has its part of an
overall ratio.

Module and face width from the torque are a size to begin with, no rating of strength.  The load figure
K = F_t/b (1/d_a +- 1/d_b), of sun and planet F_t/(b d_s) (u + 1)/u, stays at or below 4 N/mm^2, about what
case-hardened planetary gears carry, with the face width b = 0.8 d of the pinion and F_t = 1.15 T/(N d/2), 15 % for
unequal sharing.

Bodies, supports, damping, deviations and tolerances of a running model come each by a rule.  Nothing here is known of
the train that is to be built, so every number goes under `[assumed]` with its rule.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from itertools import combinations, product
from typing import Any, NamedTuple

from ..document.schema import KIND_BY_NAME
from ..document.tables import PlainTable, merge, nested
from ..document.writer import quantity_text
from ..errors import ModelError
from ..teeth import geometry
from ..teeth.geometry import in_flank_range, run_out_width

Teeth = Mapping[str, int]


class Gear(NamedTuple):
    """A gear of a layout: its kind in the model file, and the gear on whose shaft it sits.

    plane : 0 or 1, place along the axis; 0.5 reaches over both.
    """

    kind: str
    on: str = ""
    plane: float = 0


class StageLayout(NamedTuple):
    """Gears in the order of their teeth, and the pairs that mesh, of a ring mesh the planet first.

    shafts : members that turn about the axis of the stage or an axis beside it: unless held the first one drives, the
        last one is driven.
    held : members that may be held, the first one unless said otherwise.  example : teeth.
    """

    gears: Mapping[str, Gear]
    pairs: tuple[tuple[str, str], ...]
    shafts: tuple[str, ...]
    held: tuple[str, ...]
    example: str

    @property
    def planets(self) -> tuple[str, ...]:
        """Its planet gears."""
        return tuple(name for name, gear in self.gears.items() if gear.kind == "planet")

    def axis(self, planet: str) -> str:
        """The planet gear at the root of the shaft of one."""
        return self.gears[planet].on or planet

    def ends(self, held: str | None) -> tuple[str, str]:
        """Members that drive and are driven with one held: a reducer's input and output."""
        free = [member for member in self.shafts if member != held]
        return free[0], free[-1]

    def sizes(self, teeth: Teeth) -> dict[tuple[str, str], int]:
        """Pair -> twice its centre distance per transverse module, without shift."""
        return {(a, b): teeth[b] + (-1 if self.gears[b].kind == "ring" else 1) * teeth[a] for a, b in self.pairs}

    def on_axis(self, teeth: Teeth) -> dict[str, dict[tuple[str, str], int]]:
        """`sizes` of the pairs of a planet and a central gear, by the axis of the planet."""
        found: dict[str, dict[tuple[str, str], int]] = {}
        for (a, b), size in self.sizes(teeth).items():
            planets = [name for name in (a, b) if name in self.planets]
            if len(planets) == 1:
                found.setdefault(self.axis(planets[0]), {})[a, b] = size
        return found

    def with_rings(self, teeth: Teeth) -> dict[str, int]:
        """Teeth whose rings have what puts all meshes of an axis at one distance without shift; of the others as given.

        Rings of `teeth` do not count, and need not be there.
        """
        complete = {name: teeth.get(name, 0) for name in self.gears}
        for sizes in self.on_axis(complete).values():
            sun = next(iter(sizes))
            for planet, ring in (pair for pair in sizes if self.gears[pair[1]].kind == "ring"):
                complete[ring] = sizes[sun] + complete[planet]
        return complete


def _layout(gears: str, pairs: str, shafts: str, held: str, example: str) -> StageLayout:
    """StageLayout of words: gears as NAME, NAME:SHAFT and @PLANE behind either, a name being a kind and a number."""
    named = {}
    for word in gears.split():
        shaft, _, plane = word.partition("@")
        name, _, on = shaft.partition(":")
        named[name] = Gear(KIND_BY_NAME[name.rstrip("12")], on, float(plane or 0))
    meshes = tuple((a, b) for a, _, b in (pair.partition("-") for pair in pairs.split()))
    return StageLayout(named, meshes, tuple(shafts.split()), tuple(held.split()), example)


_SIMPLE = ("sun planet ring", "sun-planet planet-ring", "sun ring carrier")
_STEPPED = "sun-planet1 planet1-ring1 planet2-ring2"
_CHAIN = "sun1-planet1 planet1-planet2 sun2-planet2 planet2-ring"
LAYOUTS: Mapping[str, StageLayout] = {
    "planetary": _layout(*_SIMPLE, "ring sun", "21/39/99"),
    "star": _layout(*_SIMPLE, "carrier", "21/39/99"),
    "differential": _layout(*_SIMPLE, "", "21/39/99"),
    "parallel": _layout("pinion wheel", "pinion-wheel", "pinion wheel", "", "24/95"),
    "compound": _layout(
        "sun planet1 planet2:planet1@1 ring@1",
        "sun-planet1 planet2-ring",
        _SIMPLE[2],
        "ring sun carrier",
        "21/60/24/105",
    ),
    "ravigneaux": _layout(
        "sun1 sun2@1 planet1 planet2@0.5 ring@1",
        _CHAIN,
        "sun1 sun2 carrier ring",
        "carrier sun2 sun1",
        "27/33/21/24/81",
    ),
    "wolfrom": _layout(
        "sun planet1 ring1 planet2:planet1@1 ring2@1",
        _STEPPED,
        "sun carrier ring1 ring2",
        "ring1 ring2",
        "18/39/96/36/93",
    ),
}


def said(teeth: Teeth) -> str:
    """Teeth as they are typed, 21/39/99."""
    return "/".join(map(str, teeth.values()))


def tables_of(values: Mapping[str, Any]) -> PlainTable:
    """Values by path as tables inside each other."""
    return reduce(merge, (nested(tuple(path.split(".")), value) for path, value in values.items()), {})


def assembles(teeth: Teeth, planets: int, kind: str = "planetary") -> bool:
    """Whether equally spaced planets, all alike, can be put in: the teeth of every branch meet those of all gears.

    From one branch to the next a planet p rolls by z/(N z_p) of a turn on a sun of z teeth, by -z/(N z_p) on a ring.
    Its teeth meet where all central gears turn its shaft alike but for whole teeth.  Planets that mesh roll against
    each other.  Derived here; for a simple set (z_s + z_r)/N is whole.  The phases of the train (`train.phasing`) say
    the same, so that nothing is proposed that `load` would warn of.
    """
    layout = LAYOUTS[kind]
    rolled = []
    for pairs in layout.on_axis(teeth).values():
        for a, b in pairs:
            planet, central = (a, b) if a in layout.planets else (b, a)
            rolled.append((planet, teeth[central] * (-1 if layout.gears[central].kind == "ring" else 1)))
    for (p, x), (q, y) in combinations(rolled, 2):
        if layout.axis(p) != layout.axis(q):
            miss, unit = x + y, planets
        else:
            miss, unit = x * teeth[q] - y * teeth[p], planets * math.gcd(teeth[p], teeth[q])
        if miss % unit:
            return False
    return True


def neighbour_gap(teeth: Teeth, planets: int, helix_angle: float, kind: str = "planetary") -> float:
    """Least gap between the tip circles of neighbouring planets, 2 a sin(pi/N) - d_a, per normal module [1].

    helix_angle : [rad].  Infinite for one planet.  Without shifts; where these are needed, at the mean of the distances
    that the meshes of an axis have without.
    """
    layout, transverse = LAYOUTS[kind], 1 / math.cos(helix_angle)
    if planets == 1:
        return math.inf
    twice = {axis: sum(sizes.values()) / len(sizes) for axis, sizes in layout.on_axis(teeth).items()}
    pitch = math.sin(math.pi / planets)
    return min(((twice[layout.axis(p)] * pitch - teeth[p]) * transverse - 2 for p in layout.planets), default=math.inf)


def least_gap(module: float | None) -> float:
    """Least gap between neighbouring planets per normal module [1]: one module, and 1 mm; module [m] where known."""
    return 1.0 if not module else max(1.0, 1e-3 / module)


def fits(teeth: Teeth, planets: int, helix_angle: float, module: float | None, kind: str = "planetary") -> bool:
    """Whether planets assemble and have room beside each other."""
    room = neighbour_gap(teeth, planets, helix_angle, kind) >= least_gap(module)
    return room and assembles(teeth, planets, kind)


_REACHES, _MOST_TRIED = (6, 12, 24, 48), 30_000  # teeth that a proposal may differ by; sets that are looked at


def nearest_teeth(blank: Blank) -> Iterator[dict[str, int]]:
    """Teeth near to those of a stage that assemble and fit without shift, within ever more teeth of them.

    Rings follow from the other gears.  The order is the number of teeth that change, then the change of the ratio of
    the last gear to the first.  No gear has fewer than `FEWEST` teeth where the given one has not.
    """
    layout, teeth = blank.layout, blank.teeth
    first, *_, last = layout.gears
    free = [name for name, gear in layout.gears.items() if gear.kind != "ring"]

    def change(other: Teeth) -> tuple[float, float]:
        moved = sum(abs(other[name] - teeth[name]) for name in teeth)
        return moved, abs(other[last] / other[first] - teeth[last] / teeth[first])

    told: list[dict[str, int]] = []
    for reach in (r for r in _REACHES if (2 * r + 1) ** len(free) <= _MOST_TRIED):
        spans = [range(max(teeth[n] - reach, min(FEWEST, teeth[n])), teeth[n] + reach + 1) for n in free]
        near = (layout.with_rings(dict(zip(free, numbers, strict=True))) for numbers in product(*spans))
        found = [one for one in near if blank.takes(one) and one not in told]
        yield from sorted(found, key=change)
        told += found


# tooth counts of a ratio ----------------------------------------------------------------------------------------------

FEWEST = 17  # teeth without profile shift and without undercut, 2/sin^2(20 deg) = 17.1
RATIO_BAND = 0.005  # ratio errors within one band count as equal: half a per cent of speed decides nothing
RATIO_LIMIT = 0.02  # largest ratio error: beyond, another ratio is answered than asked for
_SEVERAL = 3  # sets that are proposed
_LARGE = 180  # teeth of a ring above which fewer are worth more than the absence of common factors
_MOST_SUN, _MOST_RING = 150, 400  # a search ends somewhere; larger gears have a smaller module than load allows


def ratio_of(teeth: Teeth, held: str) -> float:
    """Ratio of a simple planetary set [1], input over output speed of a reducer; the held member decides.

    ring held: sun to carrier, 1 + z_r/z_s; sun held: ring to carrier, 1 + z_s/z_r; carrier held (a star): sun to ring,
    -z_r/z_s.
    """
    if held == "carrier":
        return -teeth["ring"] / teeth["sun"]
    return 1 + (teeth["ring"] / teeth["sun"] if held == "ring" else teeth["sun"] / teeth["ring"])


_PINIONS = range(20, 41)  # teeth of a pinion that is looked for
_SHARE = {"parallel": 0.7}  # part of a kind in the logarithm of an overall ratio, of one planetary set
_WIDEST = {"parallel": 6.0}  # ratio of one stage that is not exceeded
_FULL = 0.93  # part of the largest ratio with so many planets, by their room, that a stage is given


def share_of_ratio(ratio: float, stages: Sequence[tuple[str, int]]) -> float:
    """Ratio of the first of several stages with an overall ratio, in size [1].

    stages : kind and number of planets.  In logarithms a planetary set takes 1 part, a parallel pair 0.7; no stage more
    than its planets have room for, of planetary sets about 2/(1 - sin(pi/N)), nor than 9.

    Raises
    ------
    ModelError : a ratio that the stages cannot have together.
    """
    weights = [_SHARE.get(kind, 1.0) for kind, _ in stages]
    most = [
        math.log(_WIDEST.get(kind) or min(9.0, _FULL * 2 / (1 - math.sin(math.pi / planets))) - (kind == "star"))
        for kind, planets in stages
    ]
    total = math.log(ratio)
    if total > sum(most):
        limit = f"at most {math.exp(sum(most)):.3g} with these stages and planets; else more stages"
        raise ModelError("no ratio of these stages", path="ratio", given=ratio, allowed=limit)
    share = min(total * weights[0] / sum(weights), most[0])
    return math.exp(max(share, total - sum(most[1:])))


def pair_of_ratio(ratio: float) -> dict[str, int]:
    """Teeth of pinion and wheel of a ratio in size [1]: error in bands of 0.25 %, no common factor, the smallest."""

    def rank(teeth: Teeth) -> tuple[int, bool, int]:
        error = abs(teeth["wheel"] / teeth["pinion"] / ratio - 1)
        return int(2 * error / RATIO_BAND), math.gcd(teeth["pinion"], teeth["wheel"]) > 1, teeth["pinion"]

    return min(({"pinion": z, "wheel": round(ratio * z)} for z in _PINIONS), key=rank)


def counts_of_ratio(ratio: float, blank: Blank, band: float) -> tuple[dict[str, int], ...]:
    """Best teeth of a simple set of a ratio, the best first, at most three.

    ratio : as of `ratio_of`; of a star of either sign.  blank : the set without its teeth.
    Preferred in this order: ratio error in bands; a ring of at most 180 teeth, or twice those of
    the smallest one of its band (about a ratio of 4 only rings of some 300 teeth have no common factors, with teeth far
    finer than the load asks for); no common factor of sun and planet, and of planet and ring (every tooth then meets
    every tooth); z_s/N not whole (the sun's meshes then do not all strike at once, which smooths the torque and pulls
    at the sun sideways); the smallest ring.

    Raises
    ------
    ModelError : nothing within 2 %.
    """
    held, planets = str(blank.held), blank.planets
    errors = ((abs(abs(ratio_of(teeth, held) / ratio) - 1), teeth) for teeth in _sets(1))
    bands = [(int(error / band), teeth) for error, teeth in errors if error <= RATIO_LIMIT and blank.takes(teeth)]
    smallest: dict[int, int] = {}
    for number, teeth in bands:
        smallest[number] = min(teeth["ring"], smallest.get(number, teeth["ring"]))

    def rank(found: tuple[int, Teeth]) -> tuple[int, bool, bool, bool, int, int]:
        number, (sun, planet, ring) = found[0], found[1].values()
        common = math.gcd(sun, planet) > 1 or math.gcd(planet, ring) > 1
        return number, ring > max(_LARGE, 2 * smallest[number]), common, sun % planets == 0, ring, sun

    best = tuple(teeth for _, teeth in sorted(bands, key=rank)[:_SEVERAL])
    if not best:
        problem, allowed = f"no teeth give this ratio with {planets} planets", _ratio_range(blank)
        raise ModelError(problem, path="ratio", given=ratio, allowed=allowed)
    return best


def _sets(step: int) -> Iterable[dict[str, int]]:
    """Simple sets without undercut within the search, every `step` teeth of the sun."""
    for z_s in range(FEWEST, _MOST_SUN + 1, step):
        for z_r in range(z_s + 2 * FEWEST, _MOST_RING + 1, max(step, 2)):
            yield {"sun": z_s, "planet": (z_r - z_s) // 2, "ring": z_r}


def _ratio_range(blank: Blank) -> str:
    """Ratios that some set within the search has, in words."""
    least, planets = least_gap(blank.module or None), blank.planets
    fitting = (c for c in _sets(4) if neighbour_gap(c, planets, blank.helix_angle) >= least)
    ratios = [abs(ratio_of(c, str(blank.held))) for c in fitting]
    if not ratios:
        return "fewer planets"
    return f"about {min(ratios):.3g} to {max(ratios):.3g} with {planets} planets; else fewer planets or two stages"


# module and face width ------------------------------------------------------------------------------------------------

PairTorques = Mapping[tuple[str, str], float]
LOAD_FIGURE = 4e6  # [Pa] K of the preselection
_WIDTH_RATIO = 0.8  # face width per sun diameter: wider, and the twist of the sun spoils the load along the face
_SHARING = 1.15  # unequal sharing, as for floating suns
# modules of series I of ISO 54 [m]
_SERIES = tuple(m * 1e-3 for m in (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40, 50))
_WIDTH_STEPS = (1e-3, 5e-3)  # [m] face widths below and above 50 mm are multiples of these
_TOOL = 1e-9  # a quotient this much above a whole number is that number


@dataclass(frozen=True, slots=True, kw_only=True)
class Blank:
    """The gears of a stage as far as they are decided.

    module, face_width : normal module and face width [m], 0 until they are chosen.  Angles [rad].
    centre_distance : given one [m], 0 where it follows.  shifts : given ones, gear -> profile shift [1].
    texts : keyword -> the value as it was given, with its unit.
    """

    name: str = "main"
    kind: str = "planetary"
    teeth: Teeth
    planets: int
    module: float
    face_width: float
    helix_angle: float
    pressure_angle: float
    held: str | None
    centre_distance: float = 0.0
    shifts: Mapping[str, float] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)

    @property
    def layout(self) -> StageLayout:
        """Its gears and their meshes."""
        return LAYOUTS[self.kind]

    @property
    def pinion(self) -> str:
        """The smallest external gear on an axis that stands still: in a simple set the sun."""
        return min((n for n, g in self.layout.gears.items() if g.kind in ("sun", "gear")), key=self.teeth.__getitem__)

    def takes(self, teeth: Teeth) -> bool:
        """Whether its planets assemble, and have room, with other teeth."""
        return fits(teeth, self.planets, self.helix_angle, self.module or None, self.kind)

    def diameter(self, teeth: int) -> float:
        """Reference diameter of a gear [m]."""
        return 2 * geometry.reference_radius(teeth, self.module, self.helix_angle)

    def pressure(self, pair: tuple[str, str], torque: float, pinion: int, diameter: float) -> float:
        """F_t (1/d_a +- 1/d_b) [N/m] of one branch where a gear of `pinion` teeth has a diameter [m]."""
        z_a, z_b = (self.teeth[name] for name in pair)
        curvature = (1 / z_a + (-1 if self.layout.gears[pair[1]].kind == "ring" else 1) / z_b) / z_a
        branches = self.planets if self.layout.planets else 1
        return 2 * (_SHARING if branches > 1 else 1.0) * torque * curvature * (pinion / diameter) ** 2 / branches


def size_of(blank: Blank, torques: PairTorques) -> Blank:
    """The gears with module and face width; given ones stay as they are.

    The module is that of the series nearest to a given centre distance, else the next one with which K stays at its
    limit in the mesh that is loaded most.  torques : see `load_figure`.

    Raises
    ------
    ModelError : a load beyond the largest module of the series.
    """
    module, width = blank.module, blank.face_width
    slant, pinion = math.cos(blank.helix_angle), blank.teeth[blank.pinion]
    if not module and blank.centre_distance:
        size = next(iter(blank.layout.sizes(blank.teeth).values()))
        asked = 2 * blank.centre_distance * slant / size
        module = min(_SERIES, key=lambda m: abs(m - asked))
    if not module:
        # K b d^2 of the pinion with a diameter of 1
        area, pair = max((blank.pressure(pair, torque, pinion, 1.0), pair) for pair, torque in torques.items())
        diameter = (
            (area / LOAD_FIGURE / _WIDTH_RATIO) ** (1 / 3) if not width else math.sqrt(area / LOAD_FIGURE / width)
        )
        least = diameter * slant / pinion
        module = next((m for m in _SERIES if m >= least * (1 - _TOOL)), 0.0)
        if not module:
            problem, given = f"asks for a module of {least * 1e3:.3g} mm", f"{torques[pair]:.4g} N m at the {pair[0]}"
            allowed = "less torque, more planets, or a module of your own"
            raise ModelError(problem, path="torque", given=given, allowed=allowed)
    if not width:
        raw = _WIDTH_RATIO * pinion * module / slant
        step = _WIDTH_STEPS[raw > 50e-3]
        width = round(math.ceil(raw / step * (1 - _TOOL)) * step, 6)
    return replace(blank, module=module, face_width=width)


def load_figure(blank: Blank, torques: PairTorques) -> float:
    """K = F_t/b (1/d_a +- 1/d_b) [Pa] of the mesh that is loaded most, - with a ring.

    torques : of every pair, on its first gear, of all planets together, in size [N m].
    """
    pinion = blank.teeth[blank.pinion]
    diameter = blank.diameter(pinion)
    most = max(blank.pressure(pair, torque, pinion, diameter) for pair, torque in torques.items())
    return most / blank.face_width


# what stands beside them ----------------------------------------------------------------------------------------------

_STEEL = 7850.0  # [kg/m^3] as in the model file
_RIM = 4  # modules of ring beyond its roots: from 3.5 on it carries nearly like a solid body
_PLANET_RIM = 3  # modules of planet under its roots, beside the bore
_LARGEST_BORE = 0.6  # of a planet, per reference diameter
_PLANE_GAP = 2  # modules between gears of two planes
_CHEEK = 0.3  # thickness of a carrier's cheek per face width
DAMPING = 0.03  # of every mode; gear trains have 0.01 to 0.1
_ADDENDUM = 0.9  # of the ring: its tips stay on the involute of the planets
_GRADE = 6  # ISO 1328-1 class of ground planetary gears
_PIN = 20e-6  # [m] what the pin of planet 1 is off, tangentially
_PIN_ZONE = 40e-6  # [m] diameter of the tolerance zone of the pins: the pin above lies on its edge
# Stiffness per face width [N/m^2].  A mesh of steel gears has about 20 N/(mm um) [iso6336].
_MESH = 20e9
_BEARING = 0.5  # per mesh: bearings of planets, carriers and rings that turn
_FLOATING = 0.01  # per mesh: a sun that floats on a toothed coupling
_BOLTED = 2.5  # per mesh: what is held by the housing


def beside(blank: Blank) -> tuple[dict[str, Any], dict[str, str], dict[str, str]]:
    """What stands beside teeth and size: values by path, tolerances, and the reason of every value by path.

    Deviations of a stage that is not alone stand under its name.
    """
    chosen = [
        (f"stages.{blank.name}.{path}", value, reason) for path, value, reason in (*_placed(blank), *_shapes(blank))
    ]
    where = "deviations" if blank.name == "main" else f"deviations.{blank.name}"
    chosen += [(f"{where}.{path}", value, reason) for path, value, reason in _deviations(blank)]
    zone, grade = f"disc({quantity_text(_PIN_ZONE, 'length')})", f"grade(ISO 1328-1:2013 {_GRADE}, 3 sigma)"
    tolerance = {f"{where}.{member}.position": zone for member in blank.layout.planets[:1]}
    graded = [member for member, teeth in blank.teeth.items() if in_flank_range(blank.diameter(teeth), blank.module)]
    tolerance |= {f"{where}.{member}.run_out": grade for member in graded}
    return {path: value for path, value, _ in chosen}, tolerance, {path: reason for path, _, reason in chosen}


def _shapes(blank: Blank) -> Iterator[tuple[str, object, str]]:
    """Path, value and reason of bores, rims, masses and supports."""
    layout = blank.layout
    bores = {name: _planet_bore(blank, name) for name in layout.planets}
    rule = f"{_PLANET_RIM} modules of rim under the roots, at most {_LARGEST_BORE} of the reference diameter"
    for name in bores:
        bore = min(bores[other] for other in bores if layout.axis(other) == layout.axis(name))
        yield f"{name}.bore", quantity_text(bore, "length"), rule
    for name in (name for name, gear in layout.gears.items() if gear.kind == "ring"):
        yield f"{name}.rim", quantity_text(_RIM * blank.module, "length"), f"{_RIM} modules beyond the roots"
        yield f"{name}.addendum", _ADDENDUM, "its tips stay on the involute of the planets"
    if bores:
        mass, inertia = _cheeks(blank, max(bores.values()))
        yield "carrier.mass", quantity_text(mass, "mass"), "two steel cheeks, 0.3 face widths thick, without the pins"
        yield "carrier.inertia", quantity_text(inertia, "inertia"), "of these cheeks"
    for member, share, reason in _supports(blank):
        stiffness = float(f"{share * _MESH * blank.face_width:.2g}")  # of a share of a mesh, to two digits
        yield member, quantity_text(stiffness, "stiffness"), reason


def _placed(blank: Blank) -> Iterator[tuple[str, object, str]]:
    """Path, value and reason of axial places, of a centre distance that the teeth ask for, and of profile shifts."""
    layout, width = blank.layout, blank.face_width
    apart = width + _PLANE_GAP * blank.module
    for name, gear in layout.gears.items():
        if gear.plane:
            place = quantity_text(round(gear.plane * apart, 9), "length")
            yield f"{name}.station", place, f"two planes, {_PLANE_GAP} modules between their faces"
        if gear.plane == 0.5:
            yield f"{name}.face_width", quantity_text(round(width + apart, 9), "length"), "it reaches over both planes"
    sizes = next((by for by in layout.on_axis(blank.teeth).values() if len(set(by.values())) > 1), None)
    twice = blank.module / math.cos(blank.helix_angle)
    distance = blank.centre_distance
    first = next(iter(sizes or layout.sizes(blank.teeth)))
    if not distance and sizes and not set(first) <= set(blank.shifts):
        ends = [size * twice / 2 for size in (min(sizes.values()), max(sizes.values()))]
        distance = round(sum(ends) / 2, 9)
        words = " and ".join(quantity_text(round(end, 9), "length") for end in ends)
        reason = f"half way between {words}, the distances of the meshes without shift"
        pairs = [f"meshes.{a}-{b}." for a, b in sizes] if len(layout.on_axis(blank.teeth)) > 1 else [""]
        yield from ((f"{where}centre_distance", quantity_text(distance, "length"), reason) for where in pairs)
    if distance:
        if not blank.shifts and not math.isnan(_shift_sum(blank, first, distance)):
            half = 50 * _shift_sum(blank, first, distance)
            smaller = blank.teeth[first[0]] <= blank.teeth[first[1]]
            rule = "half of what the centre distance asks for, the smaller gear a little more"
            yield f"{first[0]}.profile_shift", (math.ceil(half) if smaller else math.floor(half)) / 100, rule
    elif blank.shifts:
        yield from ((f"{m}.profile_shift", 0.0, "not given") for m in first if m not in blank.shifts)
    else:
        for member, shift in shifts_of(blank).items():
            yield f"{member}.profile_shift", shift, "against undercut; sun, planet and ring keep the centre distance"


def _shift_sum(blank: Blank, pair: tuple[str, str], distance: float) -> float:
    """Sum of the profile shifts of a pair at a centre distance [1]; nan below its base circles."""
    internal = blank.layout.gears[pair[1]].kind == "ring"
    z_a, z_b = (blank.teeth[name] for name in pair)
    bases = (geometry.base_radius(z, blank.module, blank.pressure_angle, blank.helix_angle) for z in (z_a, z_b))
    angle = geometry.working_pressure_angle_at(distance, *bases, internal=internal)
    slants = blank.pressure_angle, blank.helix_angle
    return geometry.shift_sum(z_a, z_b, *slants, working_pressure_angle=angle, internal=internal)


def shifts_of(blank: Blank) -> dict[str, float]:
    """Profile shifts [1] that keep a pinion from undercut at the same centre distance; nothing where none has.

    Of a simple set and of a pair: x = 1 - z sin^2 alpha_t/(2 cos beta), rounded up to hundredths; the mate has -x, and
    the ring that of the sun.
    """
    if len(blank.layout.on_axis(blank.teeth)) > 1 or any(gear.on for gear in blank.layout.gears.values()):
        return {}
    transverse = geometry.transverse_pressure_angle(blank.pressure_angle, blank.helix_angle)

    def least(teeth: int) -> float:
        return 1 - teeth * math.sin(transverse) ** 2 / (2 * math.cos(blank.helix_angle))

    first, second = blank.layout.pairs[0]
    # what theory asks for below 0.02 no cutter shows: 17 teeth count as free of undercut
    sun, planet = (x if (x := least(blank.teeth[m])) > 0.02 else min(x, 0.0) for m in (first, second))
    shift = sun if sun > 0 else -planet if planet > 0 else 0.0
    if shift == 0.0 or (sun > 0 and planet > 0):
        return {}
    rounded = math.copysign(math.ceil(abs(shift) * 100) / 100, shift)
    rings = [name for name, gear in blank.layout.gears.items() if gear.kind == "ring"]
    return {first: rounded, second: -rounded} | dict.fromkeys(rings, rounded)


def _planet_bore(blank: Blank, gear: str) -> float:
    """Bore of a planet gear [m], a whole number of mm, of 5 mm from 50 mm on."""
    teeth = blank.teeth[gear]
    root = 2 * geometry.root_radius(teeth, blank.module, blank.helix_angle)
    largest = min(_LARGEST_BORE * blank.diameter(teeth), root - 2 * _PLANET_RIM * blank.module)
    step = 5e-3 if largest > 50e-3 else 1e-3 if largest > 5e-3 else 1e-4
    return round(math.floor(largest / step + 1e-9) * step, 6)


def _supports(blank: Blank) -> Iterator[tuple[str, float, str]]:
    """Path of every support, its stiffness per mesh, and its rule."""
    half = "half a mesh of this face width, 20 N/(mm um)"
    rules = {
        "sun": (_FLOATING, "a hundredth of a mesh: the sun floats on a toothed coupling"),
        "ring": (_BEARING, half),
        "gear": (_BEARING, f"its bearings, {half}"),
        "carrier": (_BEARING, f"its bearings, {half}"),
    }
    kinds = {name: gear.kind for name, gear in blank.layout.gears.items() if not gear.on}
    for name, kind in (kinds | ({"carrier": "carrier"} if blank.layout.planets else {})).items():
        if kind == "planet":
            yield f"{name}.bearing.radial", _BEARING, f"pin and bearing in series, {half}"
        elif name == blank.held and kind != "sun":
            yield f"{name}.support.radial", _BOLTED, "2.5 meshes of this face width: bolted to the housing"
        else:
            yield f"{name}.support.radial", *rules[kind]


def _cheeks(blank: Blank, bore: float) -> tuple[float, float]:
    """Mass [kg] and inertia [kg m^2] of the two cheeks of a carrier, to three digits.

    Discs from the tips of the smallest sun to one module beyond the bores of the planets.
    """
    axes = blank.diameter(max(max(by.values()) for by in blank.layout.on_axis(blank.teeth).values())) / 2
    outer, inner = axes + bore / 2 + blank.module, blank.diameter(blank.teeth[blank.pinion]) / 2 + 2 * blank.module
    mass = 2 * _STEEL * math.pi * (outer**2 - inner**2) * _CHEEK * blank.face_width
    return float(f"{mass:.3g}"), float(f"{mass * (outer**2 + inner**2) / 2:.3g}")


def _deviations(blank: Blank) -> Iterator[tuple[str, object, str]]:
    """Path, value and reason of run-outs and of one displaced pin."""
    for member, teeth in blank.teeth.items():
        width = run_out_width(max(blank.diameter(teeth), 5e-3), max(blank.module, 0.5e-3), _GRADE)
        rule = f"half of the run-out F_rT of class {_GRADE} of ISO 1328-1:2013"
        yield f"{member}.run_out", quantity_text(round(width / 2, 7), "length"), rule
    for member in blank.layout.planets[:1]:
        pins = {"y": f"[{_PIN * 1e6:g}{', 0' * (blank.planets - 1)}] um"}
        yield f"{member}.position", pins, "one pin, that of planet 1, stands 20 um off along the circle of pins"
