"""Laws of flanks: energy, force and tangent, constant tangents, chosen rows and instants, of one law and of several."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.system.flank_laws import FlankAt, FlankLaw, LawRows, LinearLaw, TabulatedLaw, phase_cubics
from epicyclic.system.gaps import Flanks, FlanksAt, contiguous, flanks, past_the_end
from epicyclic.system.system import MeshRows, System

Array = NDArray[np.float64]
TONES = 2
LOADS = np.array([0.0, 200.0, 900.0, 2500.0, 6000.0])


def linear(rows: int = 3, *, seed: int = 1) -> LinearLaw:
    rng = np.random.default_rng(seed)
    series = np.asarray(0.1 * (rng.normal(size=(rows, 3)) + 1j * rng.normal(size=(rows, 3))), complex)
    return LinearLaw(
        stiffness=rng.uniform(3e8, 6e8, rows), variation=series, tone=rng.integers(0, TONES, rows).astype(np.int64)
    )


def table(rows: int = 2, *, seed: int = 2, phases: int = 12) -> TabulatedLaw:
    """A table whose gaps and slopes vary with the phase; the force rises ever more steeply."""
    rng = np.random.default_rng(seed)
    sigma = np.arange(phases) / phases
    soft = 1 + 0.2 * np.sin(2 * np.pi * sigma + seed)
    gap = (2e-6 * np.cos(2 * np.pi * sigma))[:, None] + soft[:, None] * 1e-5 * (LOADS / LOADS[-1]) ** 0.8
    secant = np.diff(LOADS) / np.diff(gap, axis=1)
    slope = np.hstack([secant[:, :1], (secant[:, :-1] + secant[:, 1:]) / 2, secant[:, -1:]])
    return TabulatedLaw(
        tone=rng.integers(0, TONES, rows).astype(np.int64),
        lead=rng.random(rows),
        sense=rng.choice([-1.0, 1.0], rows),
        force=LOADS,
        gap=gap,
        slope=slope,
        load=np.full(rows, np.nan),
    )


def composite() -> Flanks:
    """Seven rows: three linear ones, and two tables whose rows stand between them and each other."""
    laws = (
        LawRows(law=linear(), rows=np.array([0, 4, 6])),
        LawRows(law=table(), rows=np.array([1, 5])),
        LawRows(law=table(seed=3), rows=np.array([3, 2])),
    )
    F = 7
    return Flanks(
        B=np.eye(F),
        mesh=np.arange(F),
        tone=np.zeros(F, np.int64),
        sense=np.ones(F),
        opening=np.zeros(F),
        damping=np.zeros(F),
        linear=np.full(F, 1e8),
        stiffness=np.full(F, 1e8),
        variation=np.zeros((F, 0), complex),
        laws=laws,
    )


LAWS: dict[str, Any] = {"linear": linear(), "table": table(), "composite": composite()}
PHASES = np.random.default_rng(7).random((11, TONES)) * 3 - 1


def places(law: FlankAt | FlanksAt, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Array:
    """Gaps around touch, within tables and beyond their end; none within 1e-9 m of a kink."""
    delta = rng.uniform(-8e-6, 2.5e-5, (*shape, *law.touch.shape))
    near = np.min(np.abs(delta[..., None] - law.kinks), axis=-1) < 1e-9
    return np.asarray(delta + 2e-9 * near)


@pytest.mark.parametrize("name", LAWS)
def test_force_is_the_slope_of_the_energy_and_the_tangent_that_of_the_force(name: str) -> None:
    law = LAWS[name].at(PHASES)
    delta = places(law, np.random.default_rng(3), (40,))
    force, tangent = law.evaluate(delta)
    h = 2e-10
    np.testing.assert_allclose(
        (law.energy(delta + h) - law.energy(delta - h)) / (2 * h),
        force,
        # rounding of 0.1 J over h, and h^2 of the third derivative
        atol=1e-3,
        rtol=1e-6,
    )
    slope = (law.evaluate(delta + h)[0] - law.evaluate(delta - h)[0]) / (2 * h)
    away = np.ones(delta.shape, bool)
    for part in getattr(LAWS[name], "laws", [LawRows(law=LAWS[name], rows=np.arange(delta.shape[-1]))]):
        if isinstance(part.law, TabulatedLaw):  # at the knots of a table the tangent bends
            knots = part.law.at(PHASES).gap
            away[..., part.rows] = np.min(np.abs(delta[..., part.rows, None] - knots), axis=-1) > 2 * h
    np.testing.assert_allclose(slope[away], tangent[away], rtol=1e-5, atol=1e-5 * tangent.max())
    opened = delta <= law.touch
    assert opened.any()
    for value in (force, tangent, law.energy(delta)):
        assert not value[opened].any()
        assert np.all(value[~opened] > 0)


@pytest.mark.parametrize("name", LAWS)
def test_energy_is_the_integral_of_the_force_from_touch(name: str) -> None:
    """Across all knots of a table and beyond its end: Simpson's rule over small steps."""
    law = LAWS[name].at(PHASES)
    steps = 4000
    end = law.touch + 3e-5
    way = law.touch + np.linspace(0, 1, 2 * steps + 1)[:, None, None] * (end - law.touch)
    force, _ = law.evaluate(way)
    weight = np.tile([2.0, 4.0], steps + 1)[: 2 * steps + 1]
    weight[[0, -1]] = 1.0
    integral = np.tensordot(weight, force, axes=1) * (end - law.touch) / (6 * steps)
    np.testing.assert_allclose(law.energy(end), integral, rtol=1e-8)


@pytest.mark.parametrize("name", LAWS)
def test_the_bound_of_the_tangent_holds_and_is_not_idle(name: str) -> None:
    law = LAWS[name]
    at = law.at(np.random.default_rng(1).random((400, TONES)))
    _, tangent = at.evaluate(places(at, np.random.default_rng(4), (50,)))
    largest = tangent.max(axis=(0, 1))
    assert np.all(largest <= law.stiffest * (1 + 1e-12))
    assert np.all(largest > 0.4 * law.stiffest)


@pytest.mark.parametrize("name", LAWS)
def test_constant_against_sampled_tangents(name: str) -> None:
    """Where a law says that no tangent changes, none does; both answers are given, the second with reason."""
    law = LAWS[name].at(PHASES)
    rng = np.random.default_rng(5)
    said = {True: 0, False: 0}
    for _ in range(150):
        low = rng.uniform(-1.5e-5, 3e-5, law.touch.shape[1])
        high = low + rng.uniform(0, 2e-5, low.size)
        found = law.constant(low, high)
        assert found.shape == low.shape
        way = np.linspace(low, high, 81)[:, None, :] * np.ones((1, len(PHASES), 1))
        _, tangent = law.evaluate(way)
        # straight parts of a table hold to 1e-9 of their tangent
        changes = np.any(np.ptp(tangent, axis=0) > 1e-8 * tangent.max(), axis=0)
        assert not np.any(found & changes)
        if name == "linear":
            np.testing.assert_array_equal(found, ~changes)
        said[True] += int(found.sum())
        said[False] += int((~found & changes).sum())
    assert min(said.values()) > 30


@pytest.mark.parametrize("name", LAWS)
def test_chosen_rows_and_instants_are_those_of_all(name: str) -> None:
    whole = LAWS[name].at(PHASES)
    delta = places(whole, np.random.default_rng(6))
    some, rows = np.array([7, 0, 3, 3]), np.arange(delta.shape[1])[::-2]

    def check(found: Any, expected: Array, gaps: Array) -> None:
        force, tangent = found.evaluate(gaps)
        value, slope = whole.evaluate(delta)
        np.testing.assert_array_equal(force, expected_of(value))
        np.testing.assert_array_equal(tangent, expected_of(slope))
        np.testing.assert_array_equal(found.energy(gaps), expected_of(whole.energy(delta)))
        np.testing.assert_array_equal(found.touch, expected_of(whole.touch))
        np.testing.assert_array_equal(found.kinks[..., 0], expected_of(whole.kinks[..., 0]))
        assert expected.shape == force.shape

    def expected_of(values: Array) -> Array:
        return values[picked]

    for picked, found in (
        (np.ix_(some, np.arange(delta.shape[1])), whole.instants(some)),
        (np.ix_(np.arange(len(PHASES)), rows), whole.rows(rows)),
        (np.ix_(np.arange(len(PHASES)), np.arange(delta.shape[1])[1:]), whole.rows(slice(1, None))),
        (np.ix_(some, rows), whole.rows(rows).instants(some)),
    ):
        check(found, delta[picked], delta[picked])
    low, high = delta.min(axis=0), delta.max(axis=0)
    np.testing.assert_array_equal(whole.rows(rows).constant(low[rows], high[rows]), whole.constant(low, high)[rows])


def test_a_composite_is_each_of_its_laws_at_its_rows() -> None:
    """Rows of two tables and of linear flanks, interleaved and out of order, each against its own law alone."""
    whole = LAWS["composite"]
    at = whole.at(PHASES)
    delta = places(at, np.random.default_rng(8), (5,))
    force, tangent = at.evaluate(delta)
    seen = []
    for part in whole.laws:
        for j, row in enumerate(part.rows.tolist()):
            alone = part.law.rows([j])
            one = alone.at(PHASES)
            value, slope = one.evaluate(delta[..., [row]])
            # sums over the orders of a series round with the number of rows
            np.testing.assert_allclose(force[..., row], value[..., 0], rtol=1e-14)
            np.testing.assert_allclose(tangent[..., row], slope[..., 0], rtol=1e-14)
            np.testing.assert_allclose(at.energy(delta)[..., row], one.energy(delta[..., [row]])[..., 0], rtol=1e-13)
            np.testing.assert_array_equal(at.touch[:, row], one.touch[:, 0])
            assert whole.stiffest[row] == alone.stiffest[0]
            assert whole.end[row] == alone.end[0]
            seen.append(row)
    assert sorted(seen) == list(range(7))


def test_a_straight_table_is_the_linear_law() -> None:
    k = 4e8
    law = TabulatedLaw(
        tone=np.zeros(2, np.int64),
        lead=np.array([0.1, 0.6]),
        sense=np.array([1.0, -1.0]),
        force=LOADS,
        gap=np.tile(LOADS / k, (8, 1)),
        slope=np.full((8, LOADS.size), k),
        load=np.full(2, np.nan),
    )
    same = LinearLaw(stiffness=np.full(2, k), variation=np.zeros((2, 0), complex), tone=np.zeros(2, np.int64))
    straight, spring = law.at(PHASES), same.at(PHASES)
    delta = places(spring, np.random.default_rng(9), (60,))
    for ours, theirs in zip(straight.evaluate(delta), spring.evaluate(delta), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    np.testing.assert_allclose(straight.energy(delta), spring.energy(delta), rtol=1e-12)
    low, high = np.array([1e-6, -1e-6]), np.array([9e-5, 1e-6])
    assert straight.constant(low, high).tolist() == spring.constant(low, high).tolist() == [True, False]


def test_a_table_depends_on_the_phase_of_its_own_tone_alone_and_repeats() -> None:
    law = table()
    law = replace(law, tone=np.array([0, 1]))
    one = law.at(PHASES)
    for shift in ([1.0, 0.0], [-3.0, 2.0]):
        np.testing.assert_allclose(law.at(PHASES + shift).gap, one.gap, atol=1e-18)
    moved = law.at(PHASES + np.array([0.0, 0.3]))
    np.testing.assert_array_equal(moved.gap[:, 0], one.gap[:, 0])
    assert np.abs(moved.gap[:, 1] - one.gap[:, 1]).max() > 1e-7
    # at its own phases the table is what was given; a row of sense -1 goes through it backwards
    S = len(law.gap)
    grid = np.arange(S) / S
    phases = np.stack([law.sense[0] * grid - law.lead[0], law.sense[1] * grid - law.lead[1]], axis=1)
    np.testing.assert_allclose(law.at(phases).gap, np.stack([law.gap, law.gap], axis=1), atol=1e-18)


def test_the_cubics_of_a_table_are_its_curves() -> None:
    """What compiled integrators take, put together by hand."""
    law = table(rows=1)
    sigma = np.mod(law.sense * (PHASES[:, law.tone] + law.lead), 1.0)[:, 0]
    cubics, S = phase_cubics(law), len(law.gap)
    cell = np.floor(sigma * S).astype(int)
    u = sigma - cell / S
    values = np.array(
        [[np.polyval(cubics[i, j], x) for j in range(cubics.shape[1])] for i, x in zip(cell, u, strict=True)]
    )
    at = law.at(PHASES)
    np.testing.assert_allclose(np.cumsum(values[:, : LOADS.size], axis=1), at.gap[:, 0], atol=1e-17)
    np.testing.assert_allclose(values[:, LOADS.size :], at.slope[:, 0], rtol=1e-12)


def test_rows_one_after_the_other_are_a_slice() -> None:
    assert contiguous(np.array([3, 4, 5])) == contiguous(np.isin(np.arange(8), (3, 4, 5))) == slice(3, 6)
    for apart in ([0, 2, 1, 3], [4, 3], [1, 3], []):
        np.testing.assert_array_equal(contiguous(np.array(apart, np.int64)), apart)


def test_kinks_of_laws_with_one_and_with_two_stand_side_by_side() -> None:
    class Two:
        touch = np.zeros((11, 1))
        kinks = np.tile([0.0, 3e-6], (11, 1, 1))

    one = linear(2).at(PHASES)
    both = FlanksAt(parts=((one, np.array([2, 0])), (Two(), np.array([1]))), count=3)  # type: ignore[arg-type]
    assert both.kinks.shape == (11, 3, 2)
    np.testing.assert_array_equal(both.kinks[:, 1], Two.kinks[:, 0])
    np.testing.assert_array_equal(both.kinks[:, [0, 2]], np.tile([0.0, np.nan], (11, 2, 1)))


def system_of(laws: tuple[LawRows, ...], m: int = 3) -> System:
    zeros = np.zeros((1, 1))
    meshes = MeshRows(
        name=tuple(f"main/{i}" for i in range(m)),
        pair=("a", "b", "a"),
        stage=("main",) * m,
        branch=tuple(range(1, m + 1)),
        side=("",) * m,
        B=np.ones((1, m)),
        stiffness=np.full(m, 5e8),
        variation=np.full((m, 1), 0.1, complex),
        tone=np.array([0, 1, 0]),
        damping=np.zeros(m),
        backlash=np.full(m, np.inf),
        cos_base_helix=np.ones(m),
        laws=laws,
    )
    none: Any = None
    return System(
        dofs=none,
        M=zeros,
        C=zeros,
        G=zeros,
        K=zeros,
        Kg=zeros,
        Cskew=zeros,
        meshes=meshes,
        links=none,
        force=np.zeros(1),
        tones=(Fraction(50), Fraction(70)),
    )


def test_rows_without_a_law_of_their_own_are_linear() -> None:
    law: FlankLaw = table(rows=1)
    given = flanks(system_of((LawRows(law=law, rows=np.array([1])),)))
    delta = np.random.default_rng(2).uniform(-5e-6, 2e-5, (11, 3))
    force, _ = given.at(PHASES).evaluate(delta)
    k = 5e8 * (1 + 0.1 * np.cos(2 * np.pi * PHASES[:, [0, 0]]))
    np.testing.assert_allclose(force[:, [0, 2]], k * np.maximum(delta[:, [0, 2]], 0.0), rtol=1e-12)
    np.testing.assert_array_equal(force[:, [1]], law.at(PHASES).evaluate(delta[:, [1]])[0])
    assert not given.parametric
    assert flanks(system_of(())).parametric


def test_what_passes_the_end_of_a_table_is_said_by_pair() -> None:
    system = system_of((LawRows(law=table(rows=2), rows=np.array([1, 2])),))
    given = flanks(system)
    assert past_the_end(system, given, np.array([1e9, LOADS[-1], LOADS[-1]])) == []
    (text,) = past_the_end(system, given, np.array([1e9, 0.0, 1.5 * LOADS[-1]]))
    assert text.startswith("a: forces reach 1.5 times")
    assert "6000 N" in text
