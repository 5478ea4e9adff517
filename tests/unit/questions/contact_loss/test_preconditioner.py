"""The preconditioner of the balance: its coupling of lattice points, its exactness, and how long it is kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from epicyclic.questions.contact_loss import continuation as room
from epicyclic.questions.contact_loss.continuation import KeptPreconditioner, linear_start, preconditioner
from epicyclic.questions.contact_loss.problem import Problem, State, evaluate, jacobian, mesh_problem, unknowns
from epicyclic.questions.response.response import response
from epicyclic.system.system import System

Train = Callable[..., System]


def parting(given: Problem, speed: float) -> State:
    """A motion off the solution whose flanks part, without an edge of contact in a sample."""
    y = linear_start(given, speed)
    y[:, 1:] *= 8.0
    at = evaluate(given, y, speed)
    assert 0.05 < at.touching[:, : len(given.face.row)].mean() < 0.95
    return replace(at, width=None)


@pytest.mark.parametrize("ratio", [None, Fraction(5, 13)])
def test_the_coupling_of_points_is_that_of_the_samples(train: Train, ratio: Fraction | None) -> None:
    """Amplitudes of tangent times gap, from the tangent's own against the transforms there and back."""
    given = mesh_problem(response(train(ratio=ratio)), harmonics=5, cross=3)
    random, points = np.random.default_rng(1), np.array([0, 1, 2, 4])
    tangent = random.standard_normal((int(np.prod(given.grid.counts)), 2))
    gap = random.standard_normal((2, len(points), 2))
    gap[1, 0] = 0.0
    whole = np.zeros((2, len(given.omega), 2))
    whole[:, points] = gap
    wanted = given.grid.rows(tangent * given.grid.values(whole.reshape(-1, 2))).reshape(2, -1, 2)[:, points]
    matrix = room._coupling(given, points, tangent, np.zeros((len(points), tangent.shape[1])))
    np.testing.assert_allclose(np.einsum("xapbm,pbm->xam", matrix, gap), wanted, atol=1e-13)


def test_with_all_points_coupled_it_is_the_inverse(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "_SOFT", 0.0)
    monkeypatch.setattr(room, "_MOST", 10**6)
    given = mesh_problem(response(train(backlash=1.0)), harmonics=5)
    at = parting(given, 0.9)
    random = np.random.default_rng(2)
    step = random.standard_normal(unknowns(given))
    step[1, 0] = 0.0
    step[:, 0, given.modal.rigid] = 0.0
    back = preconditioner(given, at)(jacobian(given, at)(step))
    assert np.linalg.norm(back - step) < 1e-9 * np.linalg.norm(step)
    # a mean at every point in its place would leave as much as contact varies
    monkeypatch.setattr(room, "_MOST", 0)
    alone = preconditioner(given, at)(jacobian(given, at)(step))
    assert np.linalg.norm(alone - step) > 1e-2 * np.linalg.norm(step)


@pytest.mark.parametrize("most", [0, 16, 10**6])
def test_of_constant_contact_with_dampers_it_is_the_inverse(
    made: Any, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A flank that never touches has neither stiffness nor damper; what couples modes is left out of both."""
    monkeypatch.setattr(room, "_SOFT", 0.0)
    monkeypatch.setattr(room, "_MOST", most)
    given = mesh_problem(response(made.coupled()), harmonics=5)
    mean = np.broadcast_to(given.tangent.mean(axis=0), given.tangent.shape)
    given = replace(given, tangent=mean, modal=replace(given.modal, coupling={}))
    at = evaluate(given, linear_start(given, 0.9), 0.9, touching=np.array([True, False, False, False]))
    step = np.random.default_rng(3).standard_normal(unknowns(given))
    step[1, 0] = 0.0
    back = preconditioner(given, at)(jacobian(given, at)(step))
    assert np.linalg.norm(back - step) < 1e-9 * np.linalg.norm(step)


def test_it_is_kept_while_it_serves(made: Any) -> None:
    given = mesh_problem(response(made.coupled()), harmonics=4)
    other = mesh_problem(response(made.coupled()), harmonics=5)
    at, kept = parting(given, 0.9), KeptPreconditioner()
    first = kept.at(given, at)
    kept.calls = room._KEPT
    assert kept.at(given, at) is first
    assert kept.at(other, evaluate(other, np.zeros(unknowns(other)), 0.9)) is not first
    again = kept.at(given, at)
    kept.calls = room._KEPT + 1
    assert kept.at(given, at) is not again
