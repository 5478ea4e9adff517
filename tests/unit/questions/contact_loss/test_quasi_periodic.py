"""Stability of motions of two mesh tones: against one tone, and against the variational equation integrated."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh

from epicyclic.questions.contact_loss.branch_set import BranchSet, Crossing
from epicyclic.questions.contact_loss.problem import State, gap_rows
from epicyclic.questions.contact_loss.solutions import (
    GROWTH,
    Refinement,
    Solution,
    Stability,
    floquet_stability,
    load_continuation,
    quasi_periodic_growth,
    window_cycles,
    with_stability,
)
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.contact_loss.sweep_direction import sweep_direction
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import response
from epicyclic.system.system import System

Array = NDArray[np.float64]


def moved(system: System, speed: float, *, harmonics: int = 12) -> tuple[Refinement, State]:
    """A motion of the balance at a relative speed."""
    refinement = Refinement(ready=response(system))
    found = load_continuation(refinement, speed, harmonics=harmonics)
    assert found.converged
    return refinement, found.state


def growth(system: System, speed: float, *, harmonics: int = 12) -> tuple[Stability, State]:
    """Growth of the disturbances of a motion of two tones."""
    refinement, state = moved(system, speed, harmonics=harmonics)
    return quasi_periodic_growth(refinement.problem(harmonics), state, refinement.ready.lines.tones), state


def multiplier(system: System, speed: float, *, harmonics: int) -> tuple[float, State]:
    """Size of the largest Floquet multiplier of a motion of one tone."""
    refinement, state = moved(system, speed, harmonics=harmonics)
    given = refinement.problem(harmonics)
    found = floquet_stability(refinement, Solution(balance=given, harmonics=harmonics, state=state, residual=3e-4))
    return abs(found.multiplier), state


def parted(state: State) -> float:
    """Part of all samples in which the loaded flanks are apart."""
    return float(1 - state.touching[:, :2].mean())


def with_variation(system: System, variation: NDArray[np.complex128], tone: list[int], tones: int) -> System:
    """The same with another variation (m, L) of both flanks, tones and lines of the first tone alone."""
    meshes = replace(system.meshes, variation=variation, tone=np.array(tone))
    far = system.far
    assert far is not None
    lines = tuple(line for line in system.lines if tones > 1 or line.frequency in (0, system.tones[0]))
    return replace(
        system, meshes=meshes, far=replace(far, variation=variation), tones=system.tones[:tones], lines=lines
    )


@pytest.mark.parametrize("mesh_damping", [0.0, 400.0])
@pytest.mark.parametrize(("zeta", "speed", "ratio"), [(0.01, 1.4, Fraction(89, 55)), (0.01, 1.4, Fraction(2, 3))])
def test_a_second_tone_that_does_nothing(
    train: Any, zeta: float, speed: float, ratio: Fraction, mesh_damping: float
) -> None:
    system = replace(train(ratio=ratio, swing=0.4, load=300.0, mesh_damping=mesh_damping), zeta=zeta)
    still = system.meshes.variation.copy()
    still[1] = 0.0
    quiet = tuple(line for line in system.lines if line.frequency in (0, system.tones[0]))
    both = replace(with_variation(system, still, [0, 1], 2), lines=quiet)
    one = with_variation(system, still, [0, 0], 1)
    ours, state = growth(both, speed)
    theirs, alone = multiplier(one, speed, harmonics=24)
    assert parted(state) == pytest.approx(parted(alone), abs=0.02)
    assert ours.multiplier.real == pytest.approx(theirs, abs=2e-3)


@pytest.mark.parametrize(
    ("speed", "zeta", "mesh_damping"), [(2.0, 0.05, 0.0), (0.7, 0.05, 400.0), (1.4, 0.01, 0.0), (2.0, 0.01, 400.0)]
)
def test_a_tone_twice_the_other_is_also_one_tone(train: Any, speed: float, zeta: float, mesh_damping: float) -> None:
    system = replace(train(ratio=Fraction(2), mesh_damping=mesh_damping, swing=0.3), zeta=zeta)
    ours, _ = growth(system, speed, harmonics=8)
    own = system.meshes.variation
    spread = np.zeros((2, 6), complex)
    spread[0, :3], spread[1, 1::2] = own[0], own[1]
    far = system.far
    assert far is not None
    one = replace(
        system,
        meshes=replace(system.meshes, variation=spread, tone=np.zeros(2, np.int64)),
        far=replace(far, variation=spread),
        tones=system.tones[:1],
    )
    theirs, _ = multiplier(one, speed, harmonics=24)
    assert ours.multiplier.real == pytest.approx(theirs, abs=1e-3)


def fundamental(
    system: System, refinement: Refinement, state: State, speed: float, cycles: int, *, harmonics: int
) -> Array:
    """Sizes of multipliers over cycles of the first tone, by the implicit midpoint rule in the coordinates themselves.

    Nothing of the modal splitting: mass, damping and flanks as the equation has them, 2000 steps a cycle.
    """
    given, n = refinement.problem(harmonics), len(system.force)
    meshes, far = system.meshes, system.far_flanks
    squared, shapes = eigh(system.mean_stiffness, system.M)
    back = system.M @ shapes
    assert system.zeta is not None
    C = system.C + (back * (2 * system.zeta * np.sqrt(np.abs(squared)))) @ back.T
    inverse, B = np.linalg.inv(system.M), np.hstack([meshes.B, far.B])
    opened = (gap_rows(given, state.y) - given.error)[:, : B.shape[1]]
    tone = np.array([float(value) for value in system.tones])[np.r_[meshes.tone, meshes.tone[far.mesh]]]
    swing = np.vstack([meshes.variation, far.variation])
    mean = np.r_[meshes.stiffness, meshes.stiffness[far.mesh]]
    orders, w = np.arange(1, swing.shape[1] + 1), speed * given.omega
    step = 1 / (speed * float(system.tones[0])) / 2000
    scale = np.r_[np.ones(n), np.full(n, 2 * np.pi * 1000)]
    whole, still = np.diag(scale), np.eye(2 * n)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [np.zeros((n, n)), -inverse @ C]])
    t = (np.arange(2000 * cycles) + 0.5)[:, None] * step
    delta = np.hstack([np.cos(w * t), -np.sin(w * t)]) @ opened
    waves = (np.exp(2j * np.pi * speed * order * t * tone) for order in orders)
    k = mean * (1 + sum((part * wave).real for part, wave in zip(swing.T, waves, strict=True)))
    for pressed in np.where(delta > 0, k, 0.0):
        A[n:, :n] = -inverse @ (system.K + (B * pressed) @ B.T)
        whole = np.linalg.solve(still - step / 2 * A, whole + step / 2 * A @ whole)
    return np.sort(np.abs(np.linalg.eigvals(whole / scale)))[::-1]


@pytest.mark.parametrize(("ratio", "speed", "cycles"), [(Fraction(13, 8), 1.4, 8), (Fraction(13, 8), 2.0, 8)])
def test_it_is_the_variational_equation_integrated(train: Any, ratio: Fraction, speed: float, cycles: int) -> None:
    system = replace(train(ratio=ratio, swing=0.3), zeta=0.01)
    refinement, state = moved(system, speed)
    assert parted(state) > 0.02
    ours = quasi_periodic_growth(refinement.problem(12), state, refinement.ready.lines.tones)
    sizes = fundamental(system, refinement, state, speed, cycles, harmonics=12)
    # the train turns freely: its position and its momentum are two multipliers of exactly 1
    free = np.argsort(np.abs(sizes - 1))[:2]
    assert sizes[free] == pytest.approx([1.0, 1.0], abs=1e-6)
    theirs = float(np.delete(sizes, free).max()) ** (1 / cycles)
    assert ours.multiplier.real == pytest.approx(theirs, abs=1e-3)
    assert (ours.multiplier.real > 1) == (speed == 1.4)


def test_what_grows_is_said_to(train: Any) -> None:
    system = replace(train(ratio=Fraction(13, 8), swing=0.3), zeta=0.01)
    refinement, state = moved(system, 1.4)
    given = refinement.problem(12)
    found = with_stability(refinement, Solution(balance=given, harmonics=12, state=state, residual=0.0)).stability
    assert found is not None
    assert found.kind == GROWTH
    assert not found.stable
    assert found.multiplier.imag == 0


def test_a_motion_of_unknown_stability_is_not_stable(train: Any) -> None:
    refinement, state = moved(replace(train(ratio=Fraction(89, 55), swing=0.3), zeta=0.05), 1.4)
    at = Solution(balance=refinement.problem(12), harmonics=12, state=state, residual=0.0)
    assert with_stability(refinement, at).stable
    assert not at.stable


def test_a_state_near_the_circle_is_run_longer(train: Any) -> None:
    system = replace(train(ratio=Fraction(89, 55), swing=0.3), zeta=0.01)
    near, _ = growth(system, 1.4)
    assert abs(near.multiplier.real - 1) < 0.03
    clear, _ = growth(replace(system, zeta=0.05), 1.4)
    assert near.error < clear.error
    assert near.error < 5e-4


def test_windows_bring_both_tones_back() -> None:
    assert window_cycles(Fraction(2)) == (16, True)
    assert window_cycles(Fraction(13, 8)) == (16, True)
    assert window_cycles(Fraction(71, 220)) == (31, False)
    for ratio in (Fraction(89, 55), Fraction(1597, 987), Fraction(71, 220), Fraction(113, 355)):
        cycles, whole = window_cycles(ratio)
        assert 16 <= cycles <= 48 or whole
        assert abs(cycles * ratio - round(cycles * ratio)) < 1 / 48


def test_a_sweep_of_two_tones_has_verdicts(train: Any) -> None:
    result = contact_sweep(train(ratio=Fraction(13, 8)), SweepOptions(relative_speed=[0.4, 0.5], unstable="replace"))
    assert np.all(result.stable)
    assert np.all(result.path_stable)
    assert np.all((result.largest_multiplier > 0.3) & (result.largest_multiplier < 1))
    assert "not judged" not in result.attrs["warnings"]


def test_an_unstable_motion_of_two_tones_is_replaced(train: Any) -> None:
    system = replace(train(ratio=Fraction(13, 8), swing=0.3), zeta=0.01)
    refinement, state = moved(system, 1.4)
    at = Solution(balance=refinement.problem(12), harmonics=12, state=state, residual=0.0)
    branches = BranchSet(speeds=np.array([1.4]), segments=[], crossings=[[Crossing(solution=at, part=0)]], ended=[])
    ((_, reached),) = sweep_direction(refinement, branches, upward=True)
    assert reached.instability == GROWTH
    assert reached.motion is not None
    if isinstance(reached.motion, Solution):
        assert reached.motion.stable
    else:
        assert np.isfinite(reached.motion.measures.rms).all()


@pytest.mark.parametrize("ratio", [Fraction(13, 8), Fraction(89, 55)])
def test_windows_in_parts_are_whole_windows(train: Any, ratio: Fraction, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tangents of a cycle at a time, as of large trains: the mean that kicks are counted from is another one."""
    system = replace(train(ratio=ratio, swing=0.3, mesh_damping=400.0), zeta=0.01)
    refinement, state = moved(system, 1.4)
    given, tones = refinement.problem(12), refinement.ready.lines.tones
    whole = quasi_periodic_growth(given, state, tones)
    monkeypatch.setattr("epicyclic.questions.contact_loss.solutions._VALUES", 1)
    parts = quasi_periodic_growth(given, state, tones)
    assert parts.multiplier.real == pytest.approx(whole.multiplier.real, abs=2e-4)
