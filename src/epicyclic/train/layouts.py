"""Kinds of stages: which gears each one has, which of them mesh, and what follows from their teeth alone.

One table describes every kind.  Teeth are a mapping of gears to their numbers, positive, of a ring too; lengths are per
module, all gears of a stage having one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import combinations, product
from typing import Any, NamedTuple

from ..document.schema import KIND_BY_NAME
from ..document.tables import PlainTable, merge, nested

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


def nearest_teeth(
    teeth: Teeth, planets: int, kind: str = "planetary", *, helix_angle: float, module: float | None, fewest: int
) -> Iterator[dict[str, int]]:
    """Teeth near to given ones that assemble and fit without shift, within ever more teeth of them.

    Rings follow from the other gears.  The order is the number of teeth that change, then the change of the ratio of
    the last gear to the first.  helix_angle : [rad].  module : normal [m], None where it is to be chosen.
    fewest : teeth of a gear, where the given one has no fewer.
    """
    layout = LAYOUTS[kind]
    first, *_, last = layout.gears
    free = [name for name, gear in layout.gears.items() if gear.kind != "ring"]

    def change(other: Teeth) -> tuple[float, float]:
        moved = sum(abs(other[name] - teeth[name]) for name in teeth)
        return moved, abs(other[last] / other[first] - teeth[last] / teeth[first])

    told: list[dict[str, int]] = []
    for reach in (r for r in _REACHES if (2 * r + 1) ** len(free) <= _MOST_TRIED):
        spans = [range(max(teeth[n] - reach, min(fewest, teeth[n])), teeth[n] + reach + 1) for n in free]
        near = (layout.with_rings(dict(zip(free, numbers, strict=True))) for numbers in product(*spans))
        found = [one for one in near if fits(one, planets, helix_angle, module, kind) and one not in told]
        yield from sorted(found, key=change)
        told += found
