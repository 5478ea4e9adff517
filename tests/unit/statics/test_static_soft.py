"""Static equilibrium on soft or absent supports, against exact enumeration of the branches that carry load."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ConvergenceError
from epicyclic.statics.equilibrium import Equilibrium, compliance, equilibrium

Array = NDArray[np.float64]

TORQUE = 1000.0


def solved_exactly(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction] | None:
    """Solution by Gauss-Jordan elimination without rounding; None of a singular matrix."""
    n = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(n):
        pivot = next((j for j in range(i, n) if rows[j][i] != 0), None)
        if pivot is None:
            return None
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for j in range(n):
            if j != i:
                rows[j] = [a - rows[j][i] * b for a, b in zip(rows[j], rows[i], strict=True)]
    return [row[n] for row in rows]


def branch_forces(arms: Array, stiffness: Array, gap: Array, support: float, load: Array) -> list[float]:
    """Forces (N,) [N] of branches on a sun (x, y, u): two meshes in series are one spring, open below zero.

    Every set of closed branches is solved without rounding; the energy is convex, so one alone contradicts nothing.

    arms : (N, 3).  stiffness, gap : (N, 2) of both meshes [N/m], [m].  support : of x and y [N/m].  load : (3,) [N].
    """
    b = [[Fraction(x) for x in row] for row in arms.tolist()]
    k = [1 / (1 / Fraction(i) + 1 / Fraction(j)) for i, j in stiffness.tolist()]
    e = [Fraction(i) + Fraction(j) for i, j in gap.tolist()]
    held = [Fraction(support), Fraction(support), Fraction(0)]
    for closed in product((True, False), repeat=len(k)):
        on = [i for i, yes in enumerate(closed) if yes]
        matrix = [
            [sum((k[i] * b[i][r] * b[i][c] for i in on), held[r] if r == c else Fraction(0)) for c in range(3)]
            for r in range(3)
        ]
        right = [sum((k[i] * e[i] * b[i][r] for i in on), Fraction(load[r])) for r in range(3)]
        q = solved_exactly(matrix, right)
        if q is None:
            continue
        force = [k[i] * (sum(x * y for x, y in zip(b[i], q, strict=True)) - e[i]) for i in range(len(k))]
        if all((f >= 0) == yes for f, yes in zip(force, closed, strict=True)):
            return [max(0.0, float(f)) for f in force]
    raise AssertionError("no set of branches is in equilibrium")


def star_forces(arms: Array, stiffness: Array, gap: Array, support: float, load: Array) -> Equilibrium:
    """The same of the package: planets that nothing but their two meshes holds, against a ring at rest."""
    N = len(arms)
    B = np.zeros((3 + N, 2 * N))
    B[:3, :N] = arms.T
    B[3:, :N], B[3:, N:] = -np.eye(N), np.eye(N)
    elastic = np.zeros((3 + N, 2))
    elastic[[0, 1], [0, 1]] = np.sqrt(support)
    force = np.concatenate([load, np.zeros(N)])
    k, e = stiffness.T.ravel(), gap.T.ravel()
    return equilibrium(compliance(elastic, B, k), stiffness=k[None], gap=e[None], force=force[None])


@st.composite
def sets(draw: st.DrawFn) -> tuple[Array, Array, Array, float, Array]:
    """Arms, stiffnesses, gaps, support and load of a set of three to five branches, up to two of them 1 mm off."""
    N = draw(st.integers(3, 5))
    angle = 2 * np.pi * np.arange(N) / N + draw(st.floats(0, 1))
    arms = np.stack([np.cos(angle), np.sin(angle), np.ones(N)], axis=1)
    power = st.floats(6, 9)
    stiffness = 10.0 ** np.array(draw(st.lists(power, min_size=2 * N, max_size=2 * N))).reshape(N, 2)
    small = st.floats(-50e-6, 50e-6)
    gap = np.array(draw(st.lists(small, min_size=2 * N, max_size=2 * N))).reshape(N, 2)
    gap[draw(st.lists(st.integers(0, N - 1), max_size=2, unique=True)), 0] += 1e-3
    support = draw(st.one_of(st.just(0.0), st.floats(0, 9).map(lambda x: 10.0**x)))
    side = draw(st.floats(-200, 200)) if support else 0.0
    return arms, stiffness, gap, support, np.array([side, 0.0, TORQUE])


@settings(max_examples=60, deadline=None)
@given(case=sets())
def test_forces_of_random_sets_on_soft_supports(case: tuple[Array, Array, Array, float, Array]) -> None:
    """Branches lost, supports from 1 to 1e9 N/m beside meshes up to 1e9 N/m, or none."""
    expected, N = branch_forces(*case), len(case[0])
    found = star_forces(*case).mesh_force[0]
    np.testing.assert_allclose(found[:N], expected, rtol=0, atol=1e-10 * TORQUE)
    np.testing.assert_allclose(found[N:], expected, rtol=0, atol=1e-10 * TORQUE)


def test_forces_that_double_precision_does_not_balance_are_refused() -> None:
    """A metre of error on meshes of 1e15 N/m: rounding of the gap alone is a tenth of a newton."""
    angle = 2 * np.pi * np.arange(3) / 3
    arms = np.stack([np.cos(angle), np.sin(angle), np.ones(3)], axis=1)
    gap = np.zeros((3, 2))
    gap[0, 0] = 1.0 / 3.0
    with pytest.raises(ConvergenceError, match="do not balance"):
        star_forces(arms, np.full((3, 2), 1e15), gap, 1e9, np.array([0.0, 0.0, TORQUE]))


@pytest.mark.parametrize("torque", ["1 N m", "0.01 N m"])
def test_what_statics_refuse_for_balance_no_verb_answers(torque: str) -> None:
    """Run-out of 3 mm in meshes of 1e15 N/m: rounding of the gap is some 1e-4 N, which no planet balances."""
    stage: dict[str, Any] = {
        "planets": 3,
        "module": "4 mm",
        "face_width": "40 mm",
        "sun": {"teeth": 24, "support": {"radial": 0}},
        "planet": {"teeth": 24, "bearing": {"radial": "1e6 N/m"}},
        "ring": {"teeth": 72},
        "carrier": {},
        "meshes": {"sun-planet": {"stiffness": "1e15 N/m"}, "planet-ring": {"stiffness": "1e15 N/m"}},
    }
    model: dict[str, Any] = {
        "format": 2,
        "title": "stiff meshes",
        "damping": {"modal": 0.03},
        "stages": {"main": stage},
        "operation": {"held": ["ring"], "speed": {"sun": "1000 rpm"}, "torque": {"sun": torque}},
        "deviations": {"sun": {"run_out": "3 mm"}},
        "tolerance": {"deviations.planet.position.y": "normal(0 um, 0.001 um)"},
    }
    with pytest.raises(ConvergenceError, match="do not balance"):
        epicyclic.static(model, cycles=8)
    with pytest.raises(ConvergenceError, match="do not balance"):
        epicyclic.sharing(model, method="static", cycles=8)
    drawn = epicyclic.tolerance(model, samples=64)
    assert drawn.attrs["failed"] == drawn.attrs["samples"]
    soft = {f"stages.main.meshes.{mesh}.stiffness": "1e9 N/m" for mesh in ("sun-planet", "planet-ring")}
    bearing = {"stages.main.planet.bearing.radial": "1e9 N/m", "operation.torque.sun": "1 kN m"}
    assert epicyclic.tolerance(model, samples=64, overrides=soft | bearing).attrs["failed"] == 0


@pytest.mark.parametrize("support", ["0 N/m", "1e3 N/m", "1e4 N/m", "1e5 N/m"])
def test_a_star_off_its_place_between_soft_supports(support: str) -> None:
    """The sun passes no force to a support that is soft beside meshes: branch forces tend to those without any."""
    at: dict[str, object] = {"deviations.meshes.sun-star1.gap": "[0, 0, 0, 6, 0] um"}
    soft = {f"stages.main.{member}.support.radial": support for member in ("sun", "ring")}
    free = {f"stages.main.{member}.support.radial": "1 N/m" for member in ("sun", "ring")}
    found = epicyclic.static("dong2019", overrides={**at, **soft}, samples=64).mesh_force.values
    without = epicyclic.static("dong2019", overrides={**at, **free}, samples=64).mesh_force.values
    # supports deflect with the motion of the floating members, some 0.1 mm
    stiffness = float(support.split()[0])
    np.testing.assert_allclose(found, without, rtol=0, atol=1e-6 * found.max() + 1e-4 * stiffness)


def test_the_force_on_a_train_that_one_support_holds_is_that_of_statics() -> None:
    """Sun and carrier float: the forces do not depend on the stiffness of the support of the ring."""

    def largest(stiffness: float) -> float:
        support = {f"stages.main.{member}.support.radial": 0 for member in ("sun", "carrier")}
        overrides = {**support, "stages.main.ring.support.radial": stiffness}
        result = epicyclic.sharing("xu2020", method="static", cycles=2, overrides=overrides)
        return float(result.mesh_force.max())

    reference = largest(1e10)
    for stiffness in (1.0, 1.2e6, 3e6, 5e6, 1e8):
        assert largest(stiffness) == pytest.approx(reference, rel=1e-9)


def test_a_step_behind_the_solution_is_kept_only_where_it_is_better(monkeypatch: pytest.MonkeyPatch) -> None:
    """Teeth that just touch under loads of 20 kN on the planets: a Newton step from the solution crosses the kink."""
    from epicyclic.questions.transient import integrators

    found: list[Equilibrium] = []

    def recorded(*arguments: Any, **options: Any) -> Equilibrium:
        found.append(equilibrium(*arguments, **options))
        return found[-1]

    monkeypatch.setattr(integrators, "equilibrium", recorded)
    epicyclic.transient("ren2021", torque_ramp="0.5 s", duration="0.01 s")
    assert np.abs(found[0].displacement).max() > 1e-5
    assert found[0].mesh_force.max() < 1e-12 * 6e4
