"""Preselection of a new train: tooth counts, module and face width, and what stands beside them.

Tooth counts of a simple planetary set: which ones assemble, which fit beside each other, which give a ratio.

All gears are without profile shift: the ring has the teeth of the sun and of two planets.

Preselection of module and face width from the torque: a size to begin with, no rating of strength.

The load figure K = F_t/(b d_s) (u + 1)/u stays at or below 4 N/mm^2, about what case-hardened planetary gears carry,
with the face width b = 0.8 d_s and F_t = 1.15 T_s/(N d_s/2), 15 % for unequal sharing.

What a running model needs beside teeth and load: bodies, supports, damping, deviations, tolerances, each by a rule.

Nothing here is known of the train that is to be built, so every number goes under `[assumed]` with its rule.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from ..document.writer import quantity_text
from ..errors import ModelError
from ..teeth import geometry
from ..teeth.geometry import in_flank_range, run_out_width

Held = Literal["ring", "sun", "carrier"]
FEWEST = 17  # teeth without profile shift and without undercut, 2/sin^2(20 deg) = 17.1
RATIO_BAND = 0.005  # ratio errors within one band count as equal: half a per cent of speed decides nothing
RATIO_LIMIT = 0.02  # largest ratio error: beyond, another ratio is answered than asked for
_LARGE = 180  # teeth of a ring above which fewer are worth more than the absence of common factors
_MOST_SUN, _MOST_RING = 150, 400  # a search ends somewhere; larger gears have a smaller module than load allows
_NEAR = 6  # teeth that nearest counts may differ by, on each of sun and planet


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothCounts:
    """Teeth of a simple planetary set, numbers of sun, planet and ring."""

    sun: int
    planet: int
    ring: int

    def __str__(self) -> str:
        return f"{self.sun}/{self.planet}/{self.ring}"


def ratio_of(counts: ToothCounts, held: Held) -> float:
    """Ratio of a set [1], input over output speed of a reducer; the held member decides.

    ring held: sun to carrier, 1 + z_r/z_s; sun held: ring to carrier, 1 + z_s/z_r; carrier held (a star): sun to ring,
    -z_r/z_s.
    """
    if held == "carrier":
        return -counts.ring / counts.sun
    return 1 + (counts.ring / counts.sun if held == "ring" else counts.sun / counts.ring)


def assembles(counts: ToothCounts, planets: int) -> bool:
    """Whether equally spaced planets can be put in: the teeth of every branch meet those of both central gears.

    The phases of the train (`train.phasing`) say the same, so that nothing is proposed that `load` would warn of.
    """
    return (counts.sun + counts.ring) % planets == 0


def neighbour_gap(counts: ToothCounts, planets: int, helix_angle: float) -> float:
    """Gap between the tip circles of neighbouring planets, 2 a sin(pi/N) - d_a, per normal module [1].

    helix_angle : [rad].  Infinite for one planet.
    """
    if planets == 1:
        return math.inf
    transverse = 1 / math.cos(helix_angle)
    axes = (counts.sun + counts.planet) * transverse * math.sin(math.pi / planets)
    return axes - counts.planet * transverse - 2


def least_gap(module: float | None) -> float:
    """Least gap between neighbouring planets per normal module [1]: one module, and 1 mm; module [m] where known."""
    return 1.0 if module is None else max(1.0, 1e-3 / module)


def most_planets(counts: ToothCounts, helix_angle: float, module: float | None = None) -> int:
    """Most equally spaced planets that fit beside each other."""
    planets = 1
    while neighbour_gap(counts, planets + 1, helix_angle) >= least_gap(module):
        planets += 1
    return planets


def counts_of_ratio(
    ratio: float, planets: int, held: Held, *, helix_angle: float = 0.0, module: float | None = None, several: int = 3
) -> tuple[ToothCounts, ...]:
    """Best tooth counts of a ratio, the best first, at most `several`.

    ratio : as of `ratio_of`; of a star of either sign.  planets : number, equally spaced.  helix_angle : [rad].
    Preferred in this order: ratio error in bands of 0.5 %; a ring of at most 180 teeth, or twice those of the smallest
    one of its band (about a ratio of 4 only rings of some 300 teeth have no common factors, with teeth far finer than
    the load asks for); no common factor of sun and planet, and of planet and ring (every tooth then meets every tooth);
    z_s/N not whole (the sun's meshes then do not all strike at once, which smooths the torque and pulls at the sun
    sideways); the smallest ring.

    Raises
    ------
    ModelError : nothing within 2 %.
    """
    least = least_gap(module)
    fitting = {
        counts: int(abs(abs(ratio_of(counts, held)) / abs(ratio) - 1) / RATIO_BAND)  # its band
        for counts in _sets(1)
        if abs(abs(ratio_of(counts, held) / ratio) - 1) <= RATIO_LIMIT
        and assembles(counts, planets)
        and neighbour_gap(counts, planets, helix_angle) >= least
    }
    smallest: dict[int, int] = {}
    for counts, band in fitting.items():
        smallest[band] = min(counts.ring, smallest.get(band, counts.ring))

    def rank(counts: ToothCounts) -> tuple[int, bool, bool, bool, int, int]:
        band, (sun, planet, ring) = fitting[counts], (counts.sun, counts.planet, counts.ring)
        common = math.gcd(sun, planet) > 1 or math.gcd(planet, ring) > 1
        return band, ring > max(_LARGE, 2 * smallest[band]), common, sun % planets == 0, ring, sun

    best = tuple(sorted(fitting, key=rank)[:several])
    if not best:
        raise ModelError(
            f"no teeth give this ratio with {planets} planets",
            path="ratio",
            given=ratio,
            allowed=_ratio_range(planets, held, helix_angle, module),
        )
    return best


def nearest_counts(
    counts: ToothCounts, planets: int, *, helix_angle: float, module: float | None, several: int = 3
) -> list[ToothCounts]:
    """Tooth counts nearest to given ones that assemble and fit, by the change of their ratio; may be empty.

    helix_angle : [rad].  module : normal [m], None where it is to be chosen.
    """
    span = range(-_NEAR, _NEAR + 1)
    near = (
        ToothCounts(sun=z_s, planet=z_p, ring=z_s + 2 * z_p)
        for z_s in (counts.sun + d for d in span)
        for z_p in (counts.planet + d for d in span)
        if z_s >= min(FEWEST, counts.sun) and z_p >= min(FEWEST, counts.planet)
    )

    def change(other: ToothCounts) -> tuple[float, float]:
        teeth = abs(other.sun - counts.sun) + abs(other.planet - counts.planet) + abs(other.ring - counts.ring)
        return teeth, abs(other.ring / other.sun - counts.ring / counts.sun)

    least = least_gap(module)
    fitting = (c for c in near if assembles(c, planets) and neighbour_gap(c, planets, helix_angle) >= least)
    return sorted(fitting, key=change)[:several]


def _sets(step: int) -> Iterable[ToothCounts]:
    """Sets without undercut within the search, every `step` teeth of the sun."""
    for z_s in range(FEWEST, _MOST_SUN + 1, step):
        for z_r in range(z_s + 2 * FEWEST, _MOST_RING + 1, max(step, 2)):
            yield ToothCounts(sun=z_s, planet=(z_r - z_s) // 2, ring=z_r)


def _ratio_range(planets: int, held: Held, helix_angle: float, module: float | None) -> str:
    """Ratios that some set within the search has, in words."""
    least = least_gap(module)
    ratios = [abs(ratio_of(c, held)) for c in _sets(4) if neighbour_gap(c, planets, helix_angle) >= least]
    if not ratios:
        return "fewer planets"
    return f"about {min(ratios):.3g} to {max(ratios):.3g} with {planets} planets; else fewer planets or two stages"


LOAD_FIGURE = 4e6  # [Pa] K of the preselection
_WIDTH_RATIO = 0.8  # face width per sun diameter: wider, and the twist of the sun spoils the load along the face
_SHARING = 1.15  # unequal sharing, as for floating suns
# modules of series I of ISO 54 [m]
_SERIES = tuple(m * 1e-3 for m in (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40, 50))
_WIDTH_STEPS = (1e-3, 5e-3)  # [m] face widths below and above 50 mm are multiples of these
_TOOL = 1e-9  # a quotient this much above a whole number is that number


def size_of(
    counts: ToothCounts,
    planets: int,
    sun_torque: float,
    helix_angle: float,
    *,
    module: float | None,
    width: float | None,
) -> tuple[float, float]:
    """Module and face width of a set [m]; given ones stay as they are.

    sun_torque : [N m], of either sign.  helix_angle : [rad].  module : normal [m].  width : [m].

    Raises
    ------
    ModelError : a load beyond the largest module of the series.
    """
    if module is None:
        # b d^2 with K at its limit
        area = 2 * _SHARING * abs(sun_torque) * _curvature(counts) / (planets * LOAD_FIGURE)
        diameter = (area / _WIDTH_RATIO) ** (1 / 3) if width is None else math.sqrt(area / width)
        least = diameter * math.cos(helix_angle) / counts.sun
        module = next((m for m in _SERIES if m >= least * (1 - _TOOL)), None)
        if module is None:
            raise ModelError(
                f"asks for a module of {least * 1e3:.3g} mm",
                path="torque",
                given=f"{abs(sun_torque):.4g} N m at the sun",
                allowed="less torque, more planets, or a module of your own",
            )
    if width is None:
        raw = _WIDTH_RATIO * counts.sun * module / math.cos(helix_angle)
        step = _WIDTH_STEPS[raw > 50e-3]
        width = round(math.ceil(raw / step * (1 - _TOOL)) * step, 6)
    return module, width


def load_figure(blank: Blank, sun_torque: float) -> float:
    """K = F_t/(b d_s) (u + 1)/u [Pa] of the mesh of sun and planet; sun_torque : [N m], of either sign."""
    diameter = blank.diameter(blank.counts.sun)
    force = _SHARING * abs(sun_torque) / (blank.planets * diameter / 2)
    return force / (blank.face_width * diameter) * _curvature(blank.counts)


def _curvature(counts: ToothCounts) -> float:
    """(u + 1)/u with u = z_p/z_s: the pinion's diameter per that of the curvature of both [1]."""
    u = counts.planet / counts.sun
    return (u + 1) / u


_STEEL = 7850.0  # [kg/m^3] as in the model file
_RIM = 4  # modules of ring beyond its roots: from 3.5 on it carries nearly like a solid body
_PLANET_RIM = 3  # modules of planet under its roots, beside the bore
_LARGEST_BORE = 0.6  # of a planet, per reference diameter
_CHEEK = 0.3  # thickness of a carrier's cheek per face width
_DAMPING = 0.03  # of every mode; gear trains have 0.01 to 0.1
_ADDENDUM = 0.9  # of the ring: its tips stay on the involute of the planets
_GRADE = 6  # ISO 1328-1 class of ground planetary gears
_PIN = 20e-6  # [m] what the pin of planet 1 is off, tangentially
_PIN_ZONE = 40e-6  # [m] diameter of the tolerance zone of the pins: the pin above lies on its edge
# Stiffness per face width [N/m^2].  A mesh of steel gears has about 20 N/(mm um) [iso6336].
_MESH = 20e9
_BEARING = 0.5  # per mesh: bearings of planets, carriers and rings that turn
_FLOATING = 0.01  # per mesh: a sun that floats on a toothed coupling
_BOLTED = 2.5  # per mesh: what is held by the housing


@dataclass(frozen=True, slots=True, kw_only=True)
class Blank:
    """The gears as far as they are decided: normal module [m], face width [m], angles [rad]."""

    counts: ToothCounts
    planets: int
    module: float
    face_width: float
    helix_angle: float
    pressure_angle: float
    held: Held | None

    def diameter(self, teeth: int) -> float:
        """Reference diameter of a gear [m]."""
        return 2 * geometry.reference_radius(teeth, self.module, self.helix_angle)


def beside(blank: Blank) -> tuple[dict[str, Any], dict[str, str]]:
    """Tables of a document beside teeth, size and operation, and the reason of every value by path."""
    stage: dict[str, Any] = {"sun": {}, "planet": {}, "ring": {}, "carrier": {}}
    reasons: dict[str, str] = {}

    def put(member: str, key: str, value: object, reason: str) -> None:
        table, *rest = key.split(".")
        stage[member][table] = {rest[0]: value} if rest else value
        reasons[f"stages.main.{member}.{key}"] = reason

    for member, shift in shifts_of(blank).items():
        put(member, "profile_shift", shift, "against undercut; sun, planet and ring keep the centre distance")
    bore = _planet_bore(blank)
    rule = f"{_PLANET_RIM} modules of rim under the roots, at most {_LARGEST_BORE} of the reference diameter"
    put("planet", "bore", quantity_text(bore, "length"), rule)
    put("ring", "rim", quantity_text(_RIM * blank.module, "length"), f"{_RIM} modules beyond the roots")
    put("ring", "addendum", _ADDENDUM, "its tips stay on the involute of the planets")
    for member, key, share, reason in _supports(blank.held):
        stiffness = float(f"{share * _MESH * blank.face_width:.2g}")  # of a share of a mesh, to two digits
        put(member, key, quantity_text(stiffness, "stiffness"), reason)
    mass, inertia = _cheeks(blank, bore)
    put("carrier", "mass", quantity_text(mass, "mass"), "two steel cheeks, 0.3 face widths thick, without the pins")
    put("carrier", "inertia", quantity_text(inertia, "inertia"), "of these cheeks")
    stage["carrier"] = {k: stage["carrier"][k] for k in ("mass", "inertia", "support")}
    deviations, tolerance, more = _deviations(blank)
    reasons |= {"damping.modal": "a usual value; a response needs damping, 0.01 to 0.1"} | more
    return {
        "damping": {"modal": _DAMPING},
        "stages": {"main": stage},
        "deviations": deviations,
        "tolerance": tolerance,
    }, reasons


def shifts_of(blank: Blank) -> dict[str, float]:
    """Profile shifts [1] that keep sun or planet from undercut at the same centre distance; nothing where none has.

    x = 1 - z sin^2 alpha_t/(2 cos beta), rounded up to hundredths; the mate has -x, and the ring that of the sun.
    """
    transverse = geometry.transverse_pressure_angle(blank.pressure_angle, blank.helix_angle)

    def least(teeth: int) -> float:
        return 1 - teeth * math.sin(transverse) ** 2 / (2 * math.cos(blank.helix_angle))

    # what theory asks for below 0.02 no cutter shows: 17 teeth count as free of undercut
    sun, planet = (x if (x := least(z)) > 0.02 else min(x, 0.0) for z in (blank.counts.sun, blank.counts.planet))
    shift = sun if sun > 0 else -planet if planet > 0 else 0.0
    if shift == 0.0 or (sun > 0 and planet > 0):
        return {}
    rounded = math.copysign(math.ceil(abs(shift) * 100) / 100, shift)
    return {"sun": rounded, "planet": -rounded, "ring": rounded}


def _planet_bore(blank: Blank) -> float:
    """Bore of the planets [m], a whole number of mm, of 5 mm from 50 mm on."""
    root = 2 * geometry.root_radius(blank.counts.planet, blank.module, blank.helix_angle)
    largest = min(_LARGEST_BORE * blank.diameter(blank.counts.planet), root - 2 * _PLANET_RIM * blank.module)
    step = 5e-3 if largest > 50e-3 else 1e-3 if largest > 5e-3 else 1e-4
    return round(math.floor(largest / step + 1e-9) * step, 6)


def _supports(held: Held | None) -> list[tuple[str, str, float, str]]:
    """Member, key, stiffness per mesh, and its rule."""
    bearing = "half a mesh of this face width, 20 N/(mm um)"
    bolted = _BOLTED, "2.5 meshes of this face width: bolted to the housing"
    ring = bolted if held == "ring" else (_BEARING, bearing)
    carrier = bolted if held == "carrier" else (_BEARING, f"its bearings, {bearing}")
    return [
        ("sun", "support.radial", _FLOATING, "a hundredth of a mesh: the sun floats on a toothed coupling"),
        ("planet", "bearing.radial", _BEARING, f"pin and bearing in series, {bearing}"),
        ("ring", "support.radial", *ring),
        ("carrier", "support.radial", *carrier),
    ]


def _cheeks(blank: Blank, bore: float) -> tuple[float, float]:
    """Mass [kg] and inertia [kg m^2] of the two cheeks of a carrier, to three digits.

    Discs from the tips of the sun to one module beyond the bores of the planets.
    """
    axes = (blank.diameter(blank.counts.sun) + blank.diameter(blank.counts.planet)) / 2
    outer, inner = axes + bore / 2 + blank.module, blank.diameter(blank.counts.sun) / 2 + 2 * blank.module
    mass = 2 * _STEEL * math.pi * (outer**2 - inner**2) * _CHEEK * blank.face_width
    return float(f"{mass:.3g}"), float(f"{mass * (outer**2 + inner**2) / 2:.3g}")


def _deviations(blank: Blank) -> tuple[dict[str, Any], dict[str, Any], dict[str, str]]:
    """Tables of deviations and tolerances, and their reasons."""
    deviations: dict[str, Any] = {}
    tolerance: dict[str, Any] = {"deviations.planet.position": f"disc({quantity_text(_PIN_ZONE, 'length')})"}
    reasons: dict[str, str] = {}
    for member in ("sun", "planet", "ring"):
        diameter = blank.diameter(getattr(blank.counts, member))
        width = run_out_width(max(diameter, 5e-3), max(blank.module, 0.5e-3), _GRADE)
        deviations[member] = {"run_out": quantity_text(round(width / 2, 7), "length")}
        reasons[f"deviations.{member}.run_out"] = f"half of the run-out F_rT of class {_GRADE} of ISO 1328-1:2013"
        if in_flank_range(diameter, blank.module):
            tolerance[f"deviations.{member}.run_out"] = f"grade(ISO 1328-1:2013 {_GRADE}, 3 sigma)"
    zeros = ", 0" * (blank.planets - 1)
    deviations["planet"]["position"] = {"y": f"[{_PIN * 1e6:g}{zeros}] um"}
    reasons["deviations.planet.position"] = "one pin, that of planet 1, stands 20 um off along the circle of pins"
    reasons["tolerance"] = "grades and zones as usual, to be replaced by those of the drawing"
    return deviations, tolerance, reasons
