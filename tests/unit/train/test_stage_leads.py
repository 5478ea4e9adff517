"""Leads of known stages, assembly, neighbours; and what is refused."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from epicyclic.errors import ModelError
from epicyclic.teeth.geometry import Phase
from epicyclic.train.phasing import (
    StagePhases,
    ToothedGear,
    ToothMesh,
    chain_signs,
    disc_gaps,
    flank_of_torque,
    stage_leads,
    staggered,
)

F = Fraction


def equal(count: int) -> tuple[Fraction, ...]:
    return tuple(F(i, count) for i in range(count))


def fractions(text: str) -> tuple[Fraction, ...]:
    return tuple(F(part) for part in text.split())


def simple(
    sun: int, planet: int, ring: int, angles: tuple[Fraction, ...], sense: int = 1, flank: int = 1
) -> StagePhases:
    gears = (
        ToothedGear(name="sun", teeth=sun, central=True),
        ToothedGear(name="planet", teeth=planet),
        ToothedGear(name="ring", teeth=ring, central=True, internal=True),
    )
    meshes = (
        ToothMesh(pair="sun-planet", a="sun", b="planet", directions=angles, flank=flank),
        ToothMesh(pair="planet-ring", a="planet", b="ring", directions=angles, flank=-flank),
    )
    return stage_leads(gears, meshes, sense=sense)


@pytest.mark.parametrize("flank", [1, -1])
@pytest.mark.parametrize(
    ("teeth", "count", "sense", "leads"),
    [
        ((21, 37, 95), 4, 1, "0 3/4 1/2 1/4"),
        ((21, 37, 95), 4, -1, "0 1/4 1/2 3/4"),
        ((23, 17, 57), 3, 1, "0 1/3 2/3"),
        ((23, 17, 57), 3, -1, "0 2/3 1/3"),
        ((37, 56, 149), 3, 1, "0 2/3 1/3"),
        ((37, 56, 149), 3, -1, "0 1/3 2/3"),
        ((71, 39, 149), 5, 1, "0 4/5 3/5 2/5 1/5"),
        ((71, 39, 149), 5, -1, "0 1/5 2/5 3/5 4/5"),
    ],
)
def test_leads_of_the_sun_meshes(teeth: tuple[int, int, int], count: int, sense: int, leads: str, flank: int) -> None:
    found = simple(*teeth, equal(count), sense, flank)
    assert found.lead["sun-planet"] == fractions(leads)
    assert found.sense == {"sun-planet": flank * sense, "planet-ring": flank * sense}


def test_ring_meshes_lead_by_half_a_cycle_for_even_planets() -> None:
    even, odd = simple(37, 56, 149, equal(3)), simple(71, 39, 149, equal(5))
    assert even.assembles
    assert odd.assembles
    for i in range(3):
        assert (even.lead["planet-ring"][i] - even.lead["sun-planet"][i]) % 1 == F(1, 2)
    assert odd.lead["planet-ring"] == odd.lead["sun-planet"]


def test_three_equal_planets_that_cannot_be_assembled() -> None:
    found = simple(23, 17, 57, equal(3))
    assert not found.assembles
    assert found.mismatch == (0, F(1, 3), F(-1, 3))
    assert found.lead["planet-ring"] == (0, 0, 0)  # of the ring gear as it stands
    assert found.step == F(1, 80)
    assert found.nearest_angles == (0, F(243, 720), F(477, 720))
    built = simple(23, 17, 57, fractions("0 27/80 53/80"))
    assert built.assembles
    assert built.mismatch == (0, 0, 0)
    assert built.nearest_angles == fractions("0 27/80 53/80")


def test_opposite_planets_stay_opposite_where_two_angles_are_as_near() -> None:
    found = simple(21, 37, 61, equal(4))  # 82 teeth over four planets
    assert found.nearest_angles == fractions("0 20/82 41/82 61/82")


def test_angles_given_with_few_decimals_are_exact_and_assemble() -> None:
    written = (F(0), F("121.5001") / 360, F("238.4999") / 360)
    found = simple(23, 17, 57, written)
    assert found.assembles
    assert found.mismatch[1] == F(-80, 3600000)
    floats = stage_leads(
        (ToothedGear(name="s", teeth=23, central=True), ToothedGear(name="p", teeth=17)),
        (ToothMesh(pair="s-p", a="s", b="p", directions=(0.0, 1 / 3, 2 / 3), flank=1),),
        sense=1,
    )
    assert floats.lead["s-p"] == pytest.approx((0, 1 / 3, 2 / 3), abs=1e-13)  # rounding of 23/3
    assert floats.step is None
    assert floats.nearest_angles == (0.0, 1 / 3, 2 / 3)


AHEAD = math.degrees(math.acos((102**2 + 114**2 - 78**2) / (2 * 102 * 114))) / 360


def meshed_double(count: int, sun: int = 32) -> StagePhases:
    gears = (
        ToothedGear(name="sun", teeth=sun, central=True),
        ToothedGear(name="p", teeth=19),
        ToothedGear(name="d", teeth=20),
        ToothedGear(name="ring", teeth=77, central=True, internal=True),
    )
    flanks = chain_signs(gears, (("sun", "p"), ("p", "d"), ("d", "ring")), 1)
    assert flanks == (1, -1, 1)
    at = [Phase(angle) for angle in equal(count)]
    across = [angle + 0.3217 for angle in at]  # any direction of the line of centres p-d
    meshes = (
        ToothMesh(pair="sun-p", a="sun", b="p", directions=tuple(at), flank=1),
        ToothMesh(pair="p-d", a="p", b="d", directions=tuple(across), flank=-1),
        ToothMesh(pair="d-ring", a="d", b="ring", directions=tuple(a + AHEAD for a in at), flank=1),
    )
    return stage_leads(gears, meshes, sense=1)


def test_meshed_double_planets() -> None:
    assert AHEAD * 360 == pytest.approx(41.8768, abs=5e-5)  # four decimals printed
    found = meshed_double(3)
    assert found.sense == {"sun-p": 1, "p-d": 1, "d-ring": 1}
    assert found.assembles
    assert found.mismatch == (0, 0, 0)  # exact, although p-d and d-ring themselves are not rational
    assert found.step == F(1, 45)
    assert found.lead["sun-p"] == fractions("0 1/3 2/3")
    for i, angle in enumerate(equal(3)):
        ring, across = found.lead["d-ring"], found.lead["p-d"]
        # Rounding of phases of order 100.
        assert math.remainder(ring[i] - ring[0] + float(77 * angle), 1) == pytest.approx(0, abs=1e-12)
        assert math.remainder(across[i] - across[0] + float(32 * angle), 1) == pytest.approx(0, abs=1e-12)
    assert meshed_double(2).mismatch == (0, F(-1, 2))


def stepped(clocking: tuple[Fraction, ...] | None, angles: tuple[Fraction, ...]) -> StagePhases:
    gears = (
        ToothedGear(name="sun", teeth=24, central=True),
        ToothedGear(name="star1", teeth=22),
        ToothedGear(name="star2", teeth=31, on="star1", clocking=clocking),
        ToothedGear(name="ring", teeth=99, central=True, internal=True),
    )
    meshes = (
        ToothMesh(pair="sun-star1", a="sun", b="star1", directions=angles, flank=1),
        ToothMesh(pair="star2-ring", a="star2", b="ring", directions=angles, flank=-1),
    )
    return stage_leads(gears, meshes, sense=1)


def test_stepped_shafts_fit_each_place_or_are_alike() -> None:
    fitted = stepped(None, equal(5))
    assert fitted.assembles
    assert fitted.step is None
    assert fitted.lead["sun-star1"] == tuple(-24 * a % 1 for a in equal(5))
    assert fitted.lead["star2-ring"] == tuple(99 * a % 1 for a in equal(5))
    alike = stepped((F(0),) * 5, equal(5))
    assert alike.step == F(1, 24 * 31 + 99 * 22) == F(1, 2922)
    assert not stepped((F(0),) * 3, (*equal(5)[:2], F(1, 2922))).assembles
    assert stepped((F(0),) * 3, fractions("0 584/2922 1169/2922")).mismatch == (0, 0, 0)
    # 2922/5 is no whole number: a shaft misses by a fifth or two of 1/22 pitch, the finest step of 31 teeth on 22.
    assert sorted(abs(F(miss)) * 22 for miss in alike.mismatch) == [0, F(1, 5), F(1, 5), F(2, 5), F(2, 5)]


def test_fitted_clocking_is_told() -> None:
    """Given as it is told every branch assembles; the least angle between teeth of 22 and of 31 is below 1/682 turn."""
    told = stepped(None, equal(5)).clocking["star2"]
    assert all(0 <= angle < F(1, 22 * 31) for angle in told)
    assert len(set(told)) == 5
    given = stepped(tuple(F(angle) for angle in told), equal(5))
    assert given.mismatch == (0, 0, 0, 0, 0)
    assert given.clocking["star2"] == told
    # 584/2922 of a turn is a place for a shaft like the first
    alike = stepped(None, fractions("0 584/2922 1169/2922")).clocking["star2"]
    assert len(set(alike)) == 1


def test_clocking_that_was_fitted_assembles() -> None:
    """Turn every shaft's second gear by what its place misses: now all branches assemble."""
    alike = stepped((F(0),) * 5, equal(5))
    # d_A = -1: star2 must turn so that its contact moves by the mismatch.
    clocking = tuple(F(miss) / 31 for miss in alike.mismatch)
    assert stepped(clocking, equal(5)).mismatch == (0, 0, 0, 0, 0)


def test_a_wheel_with_two_pinions_and_two_suns_in_one_stage() -> None:
    gears = (ToothedGear(name="wheel", teeth=95, central=True), ToothedGear(name="pinion", teeth=24))
    pair = ToothMesh(pair="wheel-pinion", a="wheel", b="pinion", directions=(F(0), F(1, 3)), flank=1)
    assert stage_leads(gears, (pair,), sense=1).lead["wheel-pinion"] == (0, F(1, 3))
    # Ravigneaux: the long planet d meets a second sun and the ring, two conditions at once.
    ravigneaux = (
        ToothedGear(name="small", teeth=30, central=True),
        ToothedGear(name="p", teeth=18),
        ToothedGear(name="d", teeth=21),
        ToothedGear(name="large", teeth=38, central=True),
        ToothedGear(name="ring", teeth=80, central=True, internal=True),
    )
    at = equal(3)
    names = (("small", "p"), ("p", "d"), ("d", "ring"), ("large", "d"))
    meshes = tuple(
        ToothMesh(pair=f"{a}-{b}", a=a, b=b, directions=at, flank=flank)
        for (a, b), flank in zip(names, chain_signs(ravigneaux, names, 1), strict=True)
    )
    found = stage_leads(ravigneaux, meshes, sense=1)
    # (80 - 30) and (30 + 38) must both be met: multiples of 1/50 and of 1/68, so of 1/2.
    assert found.step == F(1, 2)
    assert not found.assembles


def test_flank_follows_the_torque_on_the_mate() -> None:
    assert flank_of_torque(-5.0, internal=False) == 1  # the sun pushes its planet clockwise: along +t
    assert flank_of_torque(5.0, internal=False) == -1
    assert flank_of_torque(5.0, internal=True) == 1
    assert flank_of_torque(-5.0, internal=True) == -1
    assert flank_of_torque(0.0, internal=True) == flank_of_torque(0.0, internal=False) == 1


def test_stagger_moves_the_right_half_in_its_sense() -> None:
    assert staggered(F(3, 4), F(1, 2), 1) == F(1, 4)
    assert staggered(F(1, 4), F(1, 3), -1) == F(11, 12)
    assert staggered(F(1, 4), 0.5, -1) == 0.75


def test_gaps_between_neighbours() -> None:
    gaps = disc_gaps(np.array([[2.0, 0.0], [0.0, 2.0], [-2.0, 0.0]]), np.ones(3))
    # Rounding of a square root of order 1.
    np.testing.assert_allclose(gaps.min(axis=1), [math.sqrt(8) - 2] * 3, rtol=0, atol=1e-14)
    assert disc_gaps(np.zeros((1, 2)), np.ones(1)).tolist() == [[np.inf]]
    mixed = disc_gaps(np.array([[0.0, 0.0], [3.0, 4.0]]), np.array([1.0, 5.0]))
    assert mixed.tolist() == [[np.inf, -1.0], [-1.0, np.inf]]


def test_refusals() -> None:
    gears = (ToothedGear(name="s", teeth=23, central=True), ToothedGear(name="p", teeth=17))
    good = ToothMesh(pair="s-p", a="s", b="p", directions=(F(0),), flank=1)
    apart = (*gears, ToothedGear(name="x", teeth=9), ToothedGear(name="y", teeth=9))
    with pytest.raises(ModelError, match="no chain"):
        stage_leads(apart, (good, ToothMesh(pair="x-y", a="x", b="y", directions=(F(0),), flank=1)), sense=1)
