"""Tooth counts of a simple planetary set: which ones assemble, which fit beside each other, which give a ratio.

Whether teeth meet is asked of the phases of the train (`train.phasing`), so that nothing is proposed here that `load`
would warn of.  All gears are without profile shift: the ring has the teeth of the sun and of two planets.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import Literal

from ...errors import ModelError
from ...train.phasing import ToothedGear, ToothMesh, stage_leads

__all__ = [
    "FEWEST",
    "RATIO_LIMIT",
    "Held",
    "ToothCounts",
    "assembles",
    "counts_of_ratio",
    "least_gap",
    "most_planets",
    "nearest_counts",
    "neighbour_gap",
    "ratio_of",
]

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
    """Whether equally spaced planets can be put in: the teeth of every branch meet those of both central gears."""
    gears = (
        ToothedGear(name="sun", teeth=counts.sun, central=True),
        ToothedGear(name="planet", teeth=counts.planet),
        ToothedGear(name="ring", teeth=counts.ring, central=True, internal=True),
    )
    angles = tuple(Fraction(i, planets) for i in range(planets))
    meshes = (
        ToothMesh(pair="sun-planet", a="sun", b="planet", directions=angles, flank=1),
        ToothMesh(pair="planet-ring", a="planet", b="ring", directions=angles, flank=-1),
    )
    return stage_leads(gears, meshes, sense=1).assembles


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
    found = [counts for counts in _candidates(abs(ratio), held)]
    fitting = [c for c in found if neighbour_gap(c, planets, helix_angle) >= least_gap(module)]
    bands: dict[int, list[ToothCounts]] = {}
    for counts in sorted(fitting, key=lambda counts: counts.ring):
        bands.setdefault(_band(counts, abs(ratio), held), []).append(counts)
    # every band in its order is asked only as far as sets are wanted
    best = tuple(islice((c for _, band in sorted(bands.items()) for c in _ordered(band, planets)), several))
    if not best:
        raise ModelError(
            f"no teeth give this ratio with {planets} planets",
            path="ratio",
            given=ratio,
            allowed=_ratio_range(planets, held, helix_angle, module),
        )
    return best


def nearest_counts(counts: ToothCounts, planets: int, *, helix_angle: float, several: int = 3) -> list[ToothCounts]:
    """Tooth counts nearest to given ones that assemble and fit, by the change of their ratio; may be empty."""
    span = range(-_NEAR, _NEAR + 1)
    near = [
        ToothCounts(sun=z_s, planet=z_p, ring=z_s + 2 * z_p)
        for z_s in (counts.sun + d for d in span)
        for z_p in (counts.planet + d for d in span)
        if z_s >= min(FEWEST, counts.sun) and z_p >= min(FEWEST, counts.planet)
    ]

    def change(other: ToothCounts) -> tuple[float, float]:
        teeth = abs(other.sun - counts.sun) + abs(other.planet - counts.planet) + abs(other.ring - counts.ring)
        return teeth, abs(other.ring / other.sun - counts.ring / counts.sun)

    fitting = (c for c in sorted(near, key=change) if neighbour_gap(c, planets, helix_angle) >= 1)
    return list(islice((c for c in fitting if assembles(c, planets)), several))


def _candidates(ratio: float, held: Held) -> Iterable[ToothCounts]:
    """Sets without undercut whose ratio is near enough."""
    for z_s in range(FEWEST, _MOST_SUN + 1):
        for z_r in range(z_s + 2 * FEWEST, _MOST_RING + 1, 2):
            counts = ToothCounts(sun=z_s, planet=(z_r - z_s) // 2, ring=z_r)
            if abs(abs(ratio_of(counts, held)) / ratio - 1) <= RATIO_LIMIT:
                yield counts


def _band(counts: ToothCounts, ratio: float, held: Held) -> int:
    """Error of the ratio in steps of `RATIO_BAND`."""
    return int(abs(abs(ratio_of(counts, held)) / ratio - 1) / RATIO_BAND)


def _ordered(band: list[ToothCounts], planets: int) -> Iterable[ToothCounts]:
    """Sets of a band that assemble, rings rising there, in the order of `counts_of_ratio`."""
    smallest = next((counts.ring for counts in band if assembles(counts, planets)), 0)

    def rank(counts: ToothCounts) -> tuple[bool, bool, bool, int, int]:
        common = math.gcd(counts.sun, counts.planet) > 1 or math.gcd(counts.planet, counts.ring) > 1
        return counts.ring > max(_LARGE, 2 * smallest), common, counts.sun % planets == 0, counts.ring, counts.sun

    return (counts for counts in sorted(band, key=rank) if assembles(counts, planets))


def _ratio_range(planets: int, held: Held, helix_angle: float, module: float | None) -> str:
    """Ratios that some set within the search has, in words."""
    ratios = [
        abs(ratio_of(counts, held))
        for z_s in range(FEWEST, _MOST_SUN + 1, 4)
        for z_r in range(z_s + 2 * FEWEST, _MOST_RING + 1, 4)
        if neighbour_gap(counts := ToothCounts(sun=z_s, planet=(z_r - z_s) // 2, ring=z_r), planets, helix_angle)
        >= least_gap(module)
    ]
    if not ratios:
        return "fewer planets"
    return f"about {min(ratios):.3g} to {max(ratios):.3g} with {planets} planets; else fewer planets or two stages"
