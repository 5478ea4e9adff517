"""Assembly and phases of any branch against every position that its teeth can take, one after the other."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.teeth.geometry import Phase
from epicyclic.train.phasing import StagePhases, ToothedGear, ToothMesh, stage_leads

F = Fraction
HALF = F(1, 2)
HALF_TURN = 0.5

# central gears, planet gears, rings among the central ones, gear on the shaft of another, pairs along the power path
SETS: Mapping[str, tuple[str, str, str, Mapping[str, str], str]] = {
    "planetary": ("s r", "p", "r", {}, "s-p p-r"),
    "meshed planets": ("s r", "p q", "r", {}, "s-p p-q q-r"),
    "stepped planets": ("s r", "p q", "r", {"q": "p"}, "s-p q-r"),
    "two suns": ("s t r", "p q", "r", {}, "s-p t-q p-q q-r"),
    "two suns on stepped planets": ("s t r", "p q", "r", {"q": "p"}, "s-p t-q q-r"),
    "two rings": ("s u r", "p q", "u r", {"q": "p"}, "s-p p-u q-r"),
    "differential": ("s t", "p q", "", {}, "s-p t-q p-q"),
    "two planets side by side": ("s r", "p q", "r", {}, "s-p s-q p-r q-r"),
    "stepped planets that mesh": ("s t r", "p q o", "r", {"o": "q"}, "s-p p-q t-o o-r"),
}

Stage = tuple[tuple[ToothedGear, ...], tuple[ToothMesh, ...]]


@st.composite
def stages(draw: st.DrawFn) -> Stage:
    central, carried, rings, shafts, pairs = SETS[draw(st.sampled_from(sorted(SETS)))]
    turn = st.integers(0, 59).map(lambda k: F(k, 60))
    angles = [F(0), draw(st.sampled_from([F(1, 2), F(1, 3), F(2, 5)])), draw(turn)]
    alike = draw(st.booleans())
    gears = []
    for name in [*central.split(), *carried.split()]:
        first = draw(turn)
        clocking = (first,) * 3 if alike else (first, draw(turn), draw(turn))
        gears.append(
            ToothedGear(
                name=name,
                teeth=draw(st.integers(2, 6)),
                internal=name in rings.split(),
                central=name in central.split(),
                on=shafts.get(name),
                clocking=clocking if name in shafts else None,
            )
        )
    meshes = []
    for pair in pairs.split():
        a, b = pair.split("-")
        ahead = draw(turn)
        meshes.append(
            ToothMesh(
                pair=pair,
                a=a,
                b=b,
                directions=tuple(angle + ahead for angle in angles),
                flank=draw(st.sampled_from([1, -1])),
            )
        )
    return tuple(gears), tuple(meshes)


# ---------------------------------------------------------------- every position of the teeth


def gap_of(table: Mapping[str, ToothedGear], mesh: ToothMesh, angle: Mapping[str, Fraction]) -> Fraction:
    """How far the teeth of b are from the gaps of a at the pitch point [pitches], 0 where they mesh."""
    a, b, at = table[mesh.a], table[mesh.b], F(mesh.directions[0])  # type: ignore[arg-type]
    tooth = a.teeth * (angle[a.name] - at)
    mate = b.teeth * (angle[b.name] - at - (0 if b.internal else HALF))
    return (tooth + HALF - mate if b.internal else tooth + HALF + mate) % 1


def positions(
    table: Mapping[str, ToothedGear], meshes: tuple[ToothMesh, ...], known: Mapping[str, Fraction]
) -> Iterator[dict[str, Fraction]]:
    """All ways to put the gears of one branch in mesh with a gear that stands, tooth by tooth."""
    todo = [m for m in meshes if m.a not in known or m.b not in known]
    if any(gap_of(table, m, known) for m in meshes if m not in todo):
        return
    if not todo:
        yield dict(known)
        return
    mesh = next(m for m in todo if m.a in known or m.b in known)
    name = mesh.b if mesh.a in known else mesh.a
    teeth = table[name].teeth
    start = gap_of(table, mesh, {**known, name: F(0)})
    sign = 1 if table[mesh.b].internal and name == mesh.b else -1
    for k in range(teeth):
        angle = (sign * start + k) / teeth % 1
        yield from positions(table, meshes, {**known, **solid(table, name, angle)})


def solid(table: Mapping[str, ToothedGear], name: str, angle: Fraction) -> dict[str, Fraction]:
    """A gear at an angle and what sits on its shaft."""
    found = {name: angle}
    for gear in table.values():
        if gear.on is not None and gear.clocking is not None:
            ahead = F(gear.clocking[0])  # type: ignore[arg-type]
            if gear.on == name:
                found[gear.name] = (angle + ahead) % 1
            elif gear.name == name:
                found[gear.on] = (angle - ahead) % 1
    return found


Built = Mapping[tuple[Fraction, ...], set[tuple[Fraction, ...]]]


@lru_cache(maxsize=8)
def counted_branch(gears: tuple[ToothedGear, ...], meshes: tuple[ToothMesh, ...], start: Fraction) -> Built:
    """Of a stage of one branch whose first gear stands: angles of the central gears -> places of contact."""
    table, built = {gear.name: gear for gear in gears}, dict[tuple[Fraction, ...], set[tuple[Fraction, ...]]]()
    for angle in positions(table, meshes, {meshes[0].a: start}):
        centrals = tuple(angle[g.name] % 1 for g in gears if g.central)
        places = tuple(
            (m.flank * table[m.a].teeth * (angle[m.a] - F(m.directions[0])) + F(1, 4)) % 1  # type: ignore[arg-type]
            for m in meshes
        )
        built.setdefault(centrals, set()).add(places)
    return built


def counted(stage: Stage) -> Iterator[Built]:
    """Of every branch: angles of the central gears at which it can be built -> places of contact of its meshes."""
    gears, meshes = stage
    sun = next(gear for gear in gears if gear.name == meshes[0].a)
    # its flank touches at the pitch point of branch 1
    start = F(meshes[0].directions[0]) - F(meshes[0].flank, 4 * sun.teeth)  # type: ignore[arg-type]
    for i in range(3):
        alone = tuple(replace(g, clocking=g.clocking and g.clocking[i : i + 1]) for g in gears)
        yield counted_branch(alone, tuple(replace(m, directions=m.directions[i : i + 1]) for m in meshes), start)


def agrees(found: StagePhases, stage: Stage) -> bool:
    """Whether the leads are those of one way to build all branches on the same central gears."""
    built = list(counted(stage))
    leads = [tuple(F(found.sense[m.pair] * F(found.lead[m.pair][branch])) % 1 for m in stage[1]) for branch in range(3)]
    common = set(built[0]) & set(built[1]) & set(built[2])
    return any(all(leads[i] in built[i][centrals] for i in range(3)) for centrals in common)


def buildable(stage: Stage) -> bool:
    first, *others = counted(stage)
    return any(all(centrals in other for other in others) for centrals in first)


def moved(stage: Stage, angles: tuple[Fraction, ...]) -> Stage:
    """The stage with its branches at other angles of their first mesh."""
    gears, meshes = stage
    first = meshes[0].directions
    return gears, tuple(
        replace(m, directions=tuple(F(d) - F(f) + a for d, f, a in zip(m.directions, first, angles, strict=True)))  # type: ignore[arg-type]
        for m in meshes
    )


@given(stages())
@settings(max_examples=150, deadline=None)
def test_a_stage_assembles_where_some_position_of_its_teeth_meets(stage: Stage) -> None:
    found = stage_leads(*stage, sense=1)
    assert found.assembles == buildable(stage)
    if found.assembles:
        assert found.mismatch == (0, 0, 0)
        assert agrees(found, stage)


@given(stages())
@settings(max_examples=60, deadline=None)
def test_the_nearest_angles_can_be_built_and_none_between_them(stage: Stage) -> None:
    found = stage_leads(*stage, sense=1)
    given_angles = [F(d) for d in stage[1][0].directions]  # type: ignore[arg-type]
    alone = moved(stage, (given_angles[0],) * 3)
    alone = tuple(replace(g, clocking=g.clocking and g.clocking[:1] * 3) for g in alone[0]), alone[1]
    if not buildable(alone):
        assert found.mismatch[0] != 0
        return
    if None in found.nearest_angles:  # shafts of different clocking: no angle of this branch helps
        branch = found.nearest_angles.index(None)
        for k in range(12):
            other = [a + F(k, 12) if i == branch else a for i, a in enumerate(given_angles)]
            assert not buildable(moved(stage, tuple(other)))
        return
    nearest = tuple(F(angle) for angle in found.nearest_angles)  # type: ignore[arg-type]
    assert buildable(moved(stage, nearest))
    if found.step is None:
        assert nearest == tuple(given_angles)
        return
    assert all(abs(n - a) <= found.step / 2 for n, a in zip(nearest, given_angles, strict=True))
    for part in (F(1, 2), F(1, 3), F(1)):
        beside = (nearest[0], nearest[1] + part * found.step, nearest[2])
        assert buildable(moved(stage, beside)) == (part == 1)


@pytest.mark.parametrize(
    ("short", "lead"), [(18, 0.1013), (19, 0.0625), (20, 0.0245), (21, 0.9873), (22, 0.9511), (23, 0.9158)]
)
def test_a_second_sun_changes_no_phase(short: int, lead: float) -> None:
    """Large sun and ring of the set 30 / short / long 18 / 36 / ring 72 of 1.75 mm and 20 deg.

    By hand, branch 1, d = +1 at both suns, pin radii m_t (z_small + z_short)/2 and m_t (z_large + z_long)/2, angle of
    the long planet from the short one from the triangle of the axes: rolling along small-short-long-large.
    """
    a, b, c = (30 + short) / 2, (36 + 18) / 2, (short + 18) / 2
    ahead = math.acos((a * a + b * b - c * c) / (2 * a * b)) / math.tau
    across = cmath.phase(cmath.rect(b, math.tau * ahead) - a) / math.tau
    tooth_short = short * HALF_TURN - 0.25
    tooth_long = (short + 18) * across + 18 * HALF_TURN + 0.5 - tooth_short
    tooth_large = (36 + 18) * ahead + 18 * HALF_TURN + 0.5 - tooth_long
    sigma = tooth_large - 36 * ahead + 0.25
    gears = tuple(
        ToothedGear(name=name, teeth=teeth, central=name in ("small", "large", "ring"), internal=name == "ring")
        for name, teeth in {"small": 30, "large": 36, "short": short, "long": 18, "ring": 72}.items()
    )
    flanks = {"small-short": 1, "large-long": 1, "short-long": -1, "long-ring": 1}
    turned = {"small-short": 0.0, "large-long": ahead, "short-long": across, "long-ring": ahead}
    meshes = tuple(
        ToothMesh(
            pair=pair,
            a=pair.split("-")[0],
            b=pair.split("-")[1],
            directions=tuple(Phase(F(i, 3), turned[pair]) for i in range(3)),
            flank=flank,
        )
        for pair, flank in flanks.items()
    )
    found = stage_leads(gears, meshes, sense=1)
    assert found.assembles == ((72 - 30) % 3 == 0)
    for pair in ("large-long", "long-ring"):  # the large sun turns against its d, the long planet with its own
        for phase in found.lead[pair]:
            assert math.remainder(phase + sigma, 1) == pytest.approx(0, abs=1e-12)  # rounding of order 1e2
    assert found.sense["large-long"] == -found.sense["long-ring"] == -1
    assert -sigma % 1 == pytest.approx(lead, abs=5e-5)  # four decimals
    without = stage_leads([g for g in gears if g.name != "large"], [m for m in meshes if m.a != "large"], sense=1)
    for pair in ("small-short", "short-long", "long-ring"):
        assert without.lead[pair] == pytest.approx(found.lead[pair], abs=1e-12)
