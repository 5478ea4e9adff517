"""The solver: conditions of contact, convex programs solved otherwise, no phase that fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

from epicyclic.teeth import contact_solver
from epicyclic.teeth.contact_solver import principal_pivoting
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.teeth.segments import ContactSegments, contact_segments

Build = Callable[..., ContactPair]
Array = NDArray[np.float64]
PHASES = np.arange(25) / 25 + 1e-3


def crowned(pair_of: Build, linear_at: float | None) -> ContactSegments:
    from epicyclic.teeth.form import Flank, Relief

    a = Flank(crown=12e-6, tip_relief=Relief(amount=15e-6, length=1.5e-3))
    pair = pair_of(helix=15.0, slices=9, flank_a=a, misalignment=5e-4, linear_at=linear_at)
    return contact_segments(pair, PHASES)


def random_contacts(count: int, n: int) -> tuple[Array, Array]:
    """Compliances that are not those of teeth: any symmetric positive definite ones, badly conditioned."""
    rng = np.random.default_rng(3)
    root = rng.normal(size=(count, n, n)) * rng.uniform(0.02, 1, size=(count, 1, n))
    return np.matmul(root, np.swapaxes(root, 1, 2)) + 1e-4 * np.eye(n), rng.normal(size=(count, n))


def test_no_random_contact_fails() -> None:
    compliance, gap = random_contacts(3000, 7)
    valid = np.ones(gap.shape, dtype=bool)
    found = contact_solver.solve_linear(compliance, gap, valid, np.full(len(gap), 0.7))
    assert set(found.status) == {""}
    assert found.force.min() >= 0
    # conditions up to 1e6: rounding of the solution of the worst
    assert found.residual.max() < 1e-9


def test_sets_that_go_round_are_left_to_pivots(monkeypatch: pytest.MonkeyPatch, pair_of: Build) -> None:
    segments = crowned(pair_of, 3e5)
    args = segments.compliance, segments.gap, segments.valid
    by_sets = contact_solver.solve_linear(*args, np.full(25, 9e3))
    monkeypatch.setattr(contact_solver, "_SWEEPS", 0)
    by_pivots = contact_solver.solve_linear(*args, np.full(25, 9e3))
    assert by_pivots.residual.max() < 1e-12  # NUMERICS: KKT
    assert by_pivots.force == pytest.approx(by_sets.force, rel=1e-9, abs=1e-8)
    held = contact_solver.solve_linear(*args, None, approach=by_sets.approach)
    assert held.force.sum(axis=1) == pytest.approx(9e3, rel=1e-10)


def test_linear_contact_is_the_quadratic_program_of_nnls(pair_of: Build) -> None:
    segments = crowned(pair_of, 3e5)
    found = contact_solver.solve_linear(segments.compliance, segments.gap, segments.valid, np.full(25, 9e3))
    for t in range(0, 25, 4):
        have = segments.valid[t]
        C, g = segments.compliance[t][np.ix_(have, have)], segments.gap[t, have]
        lower = np.linalg.cholesky(C)
        heavy = 1e3 * np.abs(lower).max()
        matrix = np.vstack([lower.T, heavy * np.ones(have.sum())])
        right = np.append(-np.linalg.solve(lower, g), heavy * 9e3)
        force, _ = nnls(matrix, right)
        # the heavy row holds the sum to 1/heavy^2 of the curvature, 1e-6
        assert found.force[t, have] == pytest.approx(force, rel=2e-4, abs=0.02)


def test_hertzian_contact_is_the_least_of_its_energy(pair_of: Build) -> None:
    segments = contact_segments(pair_of(slices=3, misalignment=6e-4), [0.02])
    load = 12e3
    found = contact_solver.solve_hertzian(
        segments.compliance,
        segments.gap,
        segments.valid,
        np.array([load]),
        segments.law,
        inverse=lambda force: segments.own_approach(force, np.arange(len(force))),
    )
    n = int(segments.valid.sum())
    C, g = segments.compliance[0, :n, :n], segments.gap[0, :n]
    A, B, length = segments.contact.A, segments.contact.B[0, :n], segments.length[0, :n]

    def energy(share: Array) -> float:  # u = A p (B - ln p), so its integral is A p^2 (B/2 - ln(p)/2 + 1/4)
        force = share * load
        p = np.maximum(force / length, 1e-30)
        own = (length * A * p**2 * (B / 2 - np.log(p) / 2 + 0.25)).sum()
        return float((0.5 * force @ C @ force + own + g @ force) * 1e3)

    best = minimize(
        energy,
        np.full(n, 1 / n),
        method="SLSQP",
        bounds=[(0, 1)] * n,
        constraints={"type": "eq", "fun": lambda share: share.sum() - 1},
        options={"ftol": 1e-15, "maxiter": 500},
    )
    # a minimum is flat: the argument is known to the root of the energy's rounding
    assert found.force[0, :n] / load == pytest.approx(best.x, abs=2e-5)


@pytest.mark.parametrize("linear_at", [None, 3e5])
def test_load_and_approach_are_two_ways_to_ask(pair_of: Build, linear_at: float | None) -> None:
    segments = crowned(pair_of, linear_at)
    args = segments.compliance, segments.gap, segments.valid
    load = np.full(25, 9e3)
    if linear_at is None:
        by_load = contact_solver.solve_hertzian(
            *args, load, segments.law, inverse=lambda force: segments.own_approach(force, np.arange(len(force)))
        )
        back = contact_solver.solve_hertzian(*args, None, segments.law, approach=by_load.approach)
    else:
        by_load = contact_solver.solve_linear(*args, load)
        back = contact_solver.solve_linear(*args, None, approach=by_load.approach)
    assert by_load.residual.max() < 1e-12
    assert back.residual.max() < 1e-12
    assert back.force == pytest.approx(
        by_load.force, rel=1e-8, abs=1e-6
    )  # stiffness times the rounding of the approach


def test_approach_short_of_touch_bears_nothing(pair_of: Build) -> None:
    segments = crowned(pair_of, None)
    short = segments.no_load - 1e-6
    found = contact_solver.solve_hertzian(
        segments.compliance, segments.gap, segments.valid, None, segments.law, approach=short
    )
    assert (found.force == 0).all()
    assert set(found.status) == {""}
    assert (
        contact_solver.solve_linear(segments.compliance, segments.gap, segments.valid, None, approach=short).force == 0
    ).all()


def test_pivots_meet_every_load_on_the_way(pair_of: Build) -> None:
    segments = crowned(pair_of, 3e5)
    n = int(segments.valid[0].sum())
    loads = np.linspace(0, 2e4, 9)
    force, approach = principal_pivoting(segments.compliance[0, :n, :n], segments.gap[0, :n], loads, np.full(9, np.nan))
    for i, load in enumerate(loads):
        one = contact_solver.solve_linear(
            segments.compliance[:1], segments.gap[:1], segments.valid[:1], np.array([load])
        )
        assert force[i] == pytest.approx(one.force[0, :n], rel=1e-10, abs=1e-8)
        assert approach[i] == pytest.approx(one.approach[0], rel=1e-12)


def test_warm_and_cold_starts_agree(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, slices=9, misalignment=5e-4)
    many = loaded_contact(pair, [2e3, 5e3, 9e3], PHASES)
    alone = loaded_contact(pair, [9e3], PHASES)
    assert many.force[2] == pytest.approx(alone.force[0], rel=1e-8, abs=1e-6)
    assert many.residual.max() < 1e-12


def test_load_on_a_small_piece_of_the_face(pair_of: Build) -> None:
    """The linear estimate there lies beyond the largest approach of the law, which no Newton step left."""
    segments = contact_segments(pair_of(slices=40, misalignment=0.05), PHASES)
    load = np.full(25, 40e3)
    found = contact_solver.solve_hertzian(
        segments.compliance,
        segments.gap,
        segments.valid,
        load,
        segments.law,
        inverse=lambda force: segments.own_approach(force, np.arange(25)),
    )
    assert set(found.status) == {""}
    assert found.residual.max() < 1e-12
    assert (found.force > 0).sum(axis=1).max() <= 8  # of 80


def test_a_load_beyond_the_line_contact_is_given_up_soon(pair_of: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    segments = contact_segments(pair_of(slices=40, misalignment=0.05), PHASES)
    taken: list[int] = []
    step = contact_solver._newton_step

    def counted(*args: Any) -> Any:
        taken.append(1)
        return step(*args)

    monkeypatch.setattr(contact_solver, "_newton_step", counted)
    found = contact_solver.solve_hertzian(
        segments.compliance,
        segments.gap,
        segments.valid,
        np.full(25, 1e9),
        segments.law,
        inverse=lambda force: segments.own_approach(force, np.arange(25)),
    )
    assert set(found.status) == {"not converged"}
    assert len(taken) < 30
