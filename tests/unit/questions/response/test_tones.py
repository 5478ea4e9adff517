"""Several mesh frequencies at once: against time integration, one tone told as two, and known forces."""

from __future__ import annotations

import os
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.lattice import bundle, kept_points
from epicyclic.questions.response.measures import Periodic, periodic, periodic_by_tone
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.steady import steady, sweep
from epicyclic.system.system import System

Array = NDArray[np.float64]
SLOW = Fraction(137 * 3, 7)
DATA = Path(os.environ.get("EPICYCLIC_DATA", Path(__file__).parents[5] / "shared" / "data")) / "bench112.npz"


def two_tones(case: Any, *, slow: Fraction = SLOW, swing: float = 0.2, shaft: bool = False, **changes: Any) -> System:
    """The pair of gears whose first mesh follows 137 Hz and whose second `slow`."""
    fast = Fraction(137)
    lines = [
        case.line(Fraction(0), [2e-6, -1e-6]),
        case.line(fast, [3e-6, 2e-6j], push=40),
        case.line(slow, [2e-6, 4e-6j], push=30),
    ]
    if shaft:
        lines.append(case.line(Fraction(137, 14), [4e-6, 3e-6j], push=20, cause="deviations.a"))
    pair = case.pair(swing=swing, lines=tuple(lines), **changes)
    tones = tuple(sorted({fast, slow}))
    tone = np.array([tones.index(fast), tones.index(slow)])
    made: System = replace(pair, tones=tones, meshes=replace(pair.meshes, tone=tone))
    return made


def interpolated(values: NDArray[Any], theta: Array, slope: float = 0.0) -> NDArray[np.complex128]:
    """Samples over a cycle, or (slope = 2 pi f) their time derivative, at phases theta."""
    count = values.shape[-1]
    orders = np.fft.fftfreq(count, 1 / count)
    factor = 1j * slope * orders if slope else 1.0
    return np.asarray((np.fft.fft(values) * factor) / count @ np.exp(2j * np.pi * np.outer(orders, theta)))


def record(found: Periodic, times: Array, what: str) -> Array:
    """The whole signal at `times`."""
    s, tone = found.relative_speed, float(found.tone)
    total = interpolated(getattr(found, what), tone * s * times).real
    for line in found.lines:
        carrier = np.exp(2j * np.pi * s * float(line.frequency) * times)
        total = total + (interpolated(getattr(line, what), tone * s * times) * carrier).real
    return np.asarray(total)


def start(found: Periodic) -> tuple[Array, Array]:
    """Coordinates and velocities at t = 0."""
    omega, zero = 2 * np.pi * float(found.tone) * found.relative_speed, np.zeros(1)
    q = record(found, zero, "displacement")[:, 0]
    v = interpolated(found.displacement, zero, omega)[:, 0].real
    for line in found.lines:
        turn = 2j * np.pi * found.relative_speed * float(line.frequency)
        v = v + (interpolated(line.displacement, zero, omega) + turn * line.displacement[:, :1])[:, 0].real
    return q, v


@pytest.mark.parametrize(("speed", "shaft"), [(1.0, False), (2.0, False), (1.3, True)])
def test_integration_stays_on_the_solution_over_a_whole_period(case: Any, speed: float, shaft: bool) -> None:
    system = two_tones(case, shaft=shaft)
    found = periodic(system, relative_speed=speed, tolerance=1e-10)
    cycles = 14 if shaft else 7  # of the fast tone: then everything repeats
    times = np.arange(40 * cycles + 1) / (40 * 137 * speed)
    q, force = case.motion(system, speed).integrate(times, *start(found), rtol=1e-10)
    expected, moved = record(found, times, "force"), record(found, times, "displacement")
    # rows dropped are below 1e-8, and rtol 1e-10 leaves about 1e-8: 1e-6 of the signal is the accuracy asked for
    assert np.abs(force - expected).max() < 1e-6 * np.abs(expected).max()
    assert np.abs(q - moved).max() < 1e-6 * np.abs(moved).max()
    whole = steady(system, SteadyOptions(relative_speed=speed))
    # over the whole period the RMS is exact, combinations of equal frequency included
    np.testing.assert_allclose(whole.mesh_force_rms, expected[:, :-1].std(axis=1), rtol=1e-6)
    assert np.all(whole.mesh_force_bound >= expected.max(axis=1))
    assert np.all(whole.mesh_force_minimum <= expected.min(axis=1))


def test_every_tone_gives_the_same_signal(case: Any) -> None:
    told = periodic_by_tone(two_tones(case, shaft=True))
    assert [found.tone for found in told] == [Fraction(137), SLOW]
    times = np.linspace(0, 0.3, 501)
    for what in ("force", "displacement"):
        one, other = (record(found, times, what) for found in told)
        # each leaves out lines that add up to its tolerance, 1e-8
        np.testing.assert_allclose(one, other, atol=1e-7 * np.abs(one).max())
    assert {"main mesh", "deviations.a"} == {cause for line in told[0].lines for cause in line.causes}


@pytest.mark.parametrize("ratio", [Fraction(1), Fraction(1, 2)])
def test_a_tone_split_in_two_gives_the_same_response(case: Any, ratio: Fraction) -> None:
    """Frequencies of a ratio as simple as 1/2 coincide at the lowest orders: points stay apart, sums must not."""
    slow = 137 * ratio
    if ratio == 1:
        pair = two_tones(case, slow=Fraction(137))
        several = replace(
            pair, tones=(Fraction(137), Fraction(137)), meshes=replace(pair.meshes, tone=np.array([0, 1]))
        )
        assert len(response(several).lines.tones) == 1  # equal tones are one
        np.testing.assert_allclose(
            steady(several, SteadyOptions()).mesh_force_rms, steady(pair, SteadyOptions()).mesh_force_rms, rtol=1e-12
        )
        return
    several = two_tones(case, slow=slow)
    variation = np.zeros((2, 2 * several.meshes.variation.shape[1]), complex)
    variation[0, 1::2] = several.meshes.variation[0]
    variation[1, : variation.shape[1] // 2] = several.meshes.variation[1]
    meshes = replace(several.meshes, variation=variation, tone=np.zeros(2, np.int64))
    one = replace(several, tones=(slow,), meshes=meshes)
    # amplitudes of one frequency add before they are squared, so what is dropped, 1e-6, may show directly
    np.testing.assert_allclose(
        steady(several, SteadyOptions()).mesh_force_rms, steady(one, SteadyOptions()).mesh_force_rms, rtol=1e-6
    )
    times = np.linspace(0, 0.2, 301)
    a, b = (record(periodic(system, tolerance=1e-10), times, "force") for system in (several, one))
    np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(b).max())


def test_a_sweep_is_one_steady_response_after_another(case: Any) -> None:
    system, speeds = two_tones(case, shaft=True), [0.7, 1.0, 2.2]
    result = sweep(system, SweepOptions(relative_speed=speeds))
    assert set(result.status.values) == {"ok"}
    np.testing.assert_allclose(result.mesh_frequency, 137 * np.array(speeds))
    for i, speed in enumerate(speeds):
        alone = steady(system, SteadyOptions(relative_speed=speed))
        # the sweep drops rows below 1e-4 of the dynamic part, which its RMS feels squared and its peak directly
        np.testing.assert_allclose(result.mesh_force_rms[:, i], alone.mesh_force_rms, rtol=1e-5)
        np.testing.assert_allclose(result.mesh_force_peak[:, i], alone.mesh_force_bound, rtol=1e-3)
    found = periodic(system)
    moved = record(found, np.arange(14 * 60) / (60 * 137), "displacement")
    half = np.ptp(moved, axis=1) / 2 * system.dofs.radius
    assert np.all(result.amplitude[:, 1] >= half * (1 - 1e-6))


def test_combinations_rebuild_the_mesh_force(case: Any) -> None:
    system = two_tones(case)
    result = steady(system, SteadyOptions())
    times = np.linspace(0, 0.1, 201)
    wave = np.exp(2j * np.pi * np.outer(result.combination_frequency, times))
    expected = record(periodic(system), times, "force")
    rebuilt = (result.combination_force.values @ wave).real
    # products beyond the points kept are in the force but not in the table
    np.testing.assert_allclose(rebuilt, expected, atol=1e-5 * np.abs(expected).max())
    assert {"mean", "+1 main", "+1 main -1 main"} <= set(result.combination.values)


def test_combinations_rise_until_little_is_dropped(case: Any) -> None:
    system = two_tones(case, swing=0.45)
    ready = response(system)
    kept = [next(respond(ready, np.ones(1), tolerance=t)).truncation for t in (1e-4, 1e-10)]
    assert kept[1][-1] > kept[0][-1] >= 8
    assert all(more >= fewer for more, fewer in zip(kept[1], kept[0], strict=True))


def test_a_constant_stiffness_has_no_combinations(case: Any) -> None:
    ready = response(two_tones(case, swing=0.0))
    assert next(respond(ready, np.ones(1), tolerance=1e-8)).truncation[-1] == 0


def test_superposition_is_the_limit_of_small_stiffness_fluctuation(case: Any) -> None:
    """Products of fluctuation and dynamic gap are dropped: the difference falls with the square of the fluctuation."""
    swings = np.array([0.08, 0.04, 0.02])
    differences = []
    for swing in swings:
        # without errors the response is of the order of the fluctuation itself
        system = replace(two_tones(case, swing=swing), lines=())
        exact, plain = steady(system, SteadyOptions()), steady(system, SteadyOptions(method="superposition"))
        size = np.abs(exact.mesh_force_harmonic.values[:, 1:9] - plain.mesh_force_harmonic.values[:, 1:9]).max()
        differences.append(size / float(exact.mesh_force.mean()))
        assert size < 0.5 * np.abs(exact.mesh_force_harmonic.values[:, 1:]).max()
    slope = np.polyfit(np.log(swings), np.log(differences), 1)[0]
    assert abs(slope - 2) < 0.2
    assert '"method": "superposition"' in plain.attrs["options"]


def test_superposition_is_exact_without_fluctuation(case: Any) -> None:
    system = two_tones(case, swing=0.0, shaft=True)
    exact, plain = steady(system, SteadyOptions()), steady(system, SteadyOptions(method="superposition"))
    np.testing.assert_allclose(plain.mesh_force_rms, exact.mesh_force_rms, rtol=1e-10)


def test_superposition_by_hand(case: Any) -> None:
    """One harmonic of one mesh: Z(w) X = -dk dbar, with the dense matrix."""
    system = replace(two_tones(case, swing=0.1, free=False), lines=())
    meshes, w = system.meshes, 2 * np.pi * 137
    mean = system.mean_stiffness + system.Kg + system.Cskew
    bar = meshes.B.T @ np.linalg.solve(mean, system.force)
    C = case.damping(system) + (meshes.B * meshes.damping) @ meshes.B.T + system.G
    push = -meshes.B[:, 0] * meshes.stiffness[0] * meshes.variation[0, 0] * bar[0]
    X = np.linalg.solve(mean - w**2 * system.M + 1j * w * C, push)
    expected = (meshes.stiffness + 1j * w * meshes.damping) * (meshes.B.T @ X)
    expected[0] += meshes.stiffness[0] * meshes.variation[0, 0] * bar[0]
    plain = steady(system, SteadyOptions(method="superposition"))
    at = list(plain.combination_frequency.values).index(137.0)
    np.testing.assert_allclose(plain.combination_force.values[:, at], expected, rtol=1e-6)


@pytest.mark.parametrize("mirrored", [True, False])
def test_points_and_lines_of_a_lattice(mirrored: bool) -> None:
    lattice = kept_points((3, 5), 4, mirrored=mirrored)
    points = {tuple(p) for p in lattice.points.tolist()}
    every = {(a, b) for a in range(-5, 6) for b in range(-5, 6) if (a and b and abs(a) + abs(b) <= 4)}
    every |= {(a, 0) for a in range(-3, 4)} | {(0, b) for b in range(-5, 6)}
    assert points | {(-a, -b) for a, b in points} == every
    assert len(points) == (len(every) + 1) // 2 if mirrored else len(points) == len(every)
    for axis in (0, 1):
        lines = bundle(lattice, axis)
        half = lines.take.shape[1] // 2
        for rest, take, mirror in zip(lines.rests, lines.take, lines.mirror, strict=True):
            for a, place, sign in zip(range(-half, half + 1), take, mirror, strict=True):
                point = rest.copy()
                point[axis] = a
                if place == len(points):
                    assert tuple(point) not in every
                else:
                    assert tuple(sign * point) == tuple(lattice.points[place])


# mesh frequency of the first set [Hz]: RMS of the dynamic mesh force of meshes 0, 1, 16, 17 [N]
REFERENCE = {
    930: (647.204, 727.369, 379.794, 444.818),
    1646: (4030.180, 6760.743, 390.972, 449.015),
    3500: (567.812, 632.552, 313.842, 446.775),
}


def test_dynamic_mesh_forces_of_two_coupled_sets(bench112: System) -> None:
    result = sweep(bench112, SweepOptions(mesh_frequency=list(REFERENCE)))
    assert set(result.status.values) == {"ok"}
    # printed to 1e-6, known to some 1e-6
    np.testing.assert_allclose(result.mesh_force_rms[[0, 1, 16, 17]].T, list(REFERENCE.values()), rtol=1e-5)
