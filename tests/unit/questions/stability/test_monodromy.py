"""The product of many steps in groups, and of parts apart, against steps multiplied one after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.stability import floquet as floquet_module
from epicyclic.questions.stability import stability
from epicyclic.questions.stability.floquet import independent_parts, monodromy

Array = NDArray[np.float64]
STEP = 0.05


def flow_of(n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Generator (2 n, 2 n) of a gyroscopic, damped system in (y, u), and the weight of y (n,)."""
    weight = np.sort(rng.uniform(1.0, 6.0, n))
    spin = rng.standard_normal((n, n)) * 0.3
    generator = np.zeros((2 * n, 2 * n))
    generator[:n, n:] = np.diag(weight)
    generator[n:, :n] = -np.diag(weight)
    generator[n:, n:] = spin - spin.T - 0.05 * np.eye(n)
    return generator, weight


def one_by_one(generator: Array, gaps: Array, rows: Array, stiffness: Array, damping: Array | None) -> Array:
    """Flow after kick, each a matrix of the whole state, one step after the other."""
    N, k = len(generator), gaps.shape[1]
    flow, mass, whole = scipy.linalg.expm(generator * STEP), rows @ rows.T, np.eye(N)
    for j in range(stiffness.shape[1]):
        held = np.diag(stiffness[:, j])
        force = np.hstack([(held - STEP**2 / 12 * held @ mass @ held) @ gaps, np.zeros(rows.shape)])
        if damping is not None:
            drag = np.diag(damping[:, j])
            force[:, k:] = drag @ rows
            force = np.linalg.solve(np.eye(len(mass)) + STEP / 2 * drag @ mass, force)
        kick = np.eye(N)
        kick[k:] -= STEP * rows.T @ force
        whole = flow @ kick @ whole
    return whole


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize(("rank", "count"), [(2, 1), (2, 24), (2, 203), (3, 50), (6, 31)])
def test_groups_of_steps_are_the_steps(rank: int, count: int, damped: bool) -> None:
    """Six mesh rows of any rank, steps that fill their groups or not."""
    rng = np.random.default_rng(rank + count)
    generator, weight = flow_of(7, rng)
    rows = rng.standard_normal((6, rank)) @ rng.standard_normal((rank, 7))
    stiffness = rng.standard_normal((6, count)) * 0.4
    damping = rng.standard_normal((6, count)) * 0.01 if damped else None
    given = generator, rows / weight, rows
    found = monodromy(*given, stiffness=stiffness, damping=damping, step=STEP)
    exact = one_by_one(*given, stiffness, damping)
    assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()


def two_sides(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Generator, rows and weight of two systems that meet each mesh as both sides do: as their sum and difference."""
    (first, w1), (second, w2) = flow_of(3, rng), flow_of(2, rng)
    places = [0, 1, 2, 5, 6, 7], [3, 4, 8, 9]
    generator = np.zeros((10, 10))
    for place, block in zip(places, (first, second), strict=True):
        generator[np.ix_(place, place)] = block
    together, against = rng.standard_normal((2, 3)), rng.standard_normal((2, 2))
    rows = np.vstack([np.hstack([together, against]), np.hstack([together, -against])])
    return generator, rows, np.concatenate([w1, w2])


@pytest.mark.parametrize("which", ["stiffness", "damping"])
def test_sides_in_phase_leave_two_parts_and_sides_out_of_phase_one(which: str) -> None:
    rng = np.random.default_rng(5)
    generator, rows, weight = two_sides(rng)
    wave = rng.standard_normal((2, 40))
    for tail, parts in (
        (wave, [[0, 1, 2], [3, 4]]),
        (wave * (1 + 1e-9), [[0, 1, 2, 3, 4]]),
        (-wave, [[0, 1, 2, 3, 4]]),
    ):
        changes: dict[str, Any] = {"stiffness": np.zeros((4, 40)), "damping": None, which: np.vstack([wave, tail])}
        found = independent_parts(generator, rows, weight, **changes)
        assert [part.tolist() for part in found] == parts
        if len(parts) == 2:
            whole = one_by_one(generator, rows / weight, rows, changes["stiffness"], changes["damping"])
            for part in found:
                states = np.concatenate([part, part + 5])
                block = generator[np.ix_(states, states)]
                mine = monodromy(block, rows[:, part] / weight[part], rows[:, part], **changes, step=STEP)
                assert np.abs(mine - whole[np.ix_(states, states)]).max() < 1e-12


@pytest.mark.parametrize("vectors", [False, True])
def test_a_herringbone_train_by_parts_and_as_a_whole(vectors: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Multipliers and their motions; damping changes too, as where teeth part."""
    ready = stability.parametric_system(epicyclic.assemble(epicyclic.load("xu2020")))
    stiffness = stability._stiffness_change(ready, 48)
    sizes = []
    original = independent_parts

    def counted(*arguments: Any, **options: Any) -> Any:
        found = original(*arguments, **options)
        sizes.append([part.size for part in found])
        return found

    options: dict[str, Any] = {"period": 1 / 1500, "damping": 1e-6 * stiffness, "vectors": vectors}
    monkeypatch.setattr(floquet_module, "independent_parts", counted)
    apart = floquet_module.floquet(ready.modal, stiffness, **options)
    assert sizes == [[28, 28]]
    monkeypatch.setattr(floquet_module, "independent_parts", lambda *_, **__: [np.arange(56)])
    whole = floquet_module.floquet(ready.modal, stiffness, **options)
    nearest = np.abs(apart.multipliers[:, None] - whole.multipliers)
    assert max(nearest.min(axis=0).max(), nearest.min(axis=1).max()) < 1e-10
    if vectors:
        for one in (apart, whole):
            assert one.position is not None
            assert one.rate is not None
        # the simple multipliers alone have one motion each, but for its phase
        for i in np.flatnonzero(np.sort(np.abs(whole.multipliers[:, None] - whole.multipliers), axis=1)[:, 1] > 1e-3):
            j = int(np.argmin(nearest[:, i]))
            a, b = (np.concatenate([one.position[:, p], one.rate[:, p]]) for one, p in ((apart, j), (whole, i)))  # type: ignore[index]
            assert abs(np.vdot(a, b)) == pytest.approx(np.linalg.norm(a) * np.linalg.norm(b), rel=1e-8)
