"""Samples of errors: every sample is what a separate full solution gives."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from epicyclic.analyses.samples import errors
from epicyclic.analyses.samples.error_map import ErrorMap, error_map, mesh_error_lines
from epicyclic.analyses.samples.errors import error_samples
from epicyclic.analyses.steady.sweep import sweep
from epicyclic.errors import ModelError
from epicyclic.system.system import Line, System

SPEED = 1.3
CURVES = {"rms": "mesh_force_rms", "peak": "mesh_force_peak", "minimum": "mesh_force_minimum"}


@pytest.fixture(scope="module")
def system(case: Any) -> System:
    """A constant error, a mesh order, two shaft lines of one group, and half an order, its own mirror image."""
    lines = (
        case.line(Fraction(0), [1e-5, -1e-6]),
        case.line(Fraction(274, 7), [5e-6, 4e-6j], push=60, cause="deviations.a"),
        case.line(Fraction(137, 2), [1e-5j, 1e-6], cause="deviations.half"),
        case.line(Fraction(137), [3e-6, 1e-5j], push=40),
        case.line(137 - Fraction(274, 7), [1e-6, 1e-5], cause="deviations.b"),
    )
    made: System = case.pair(lines=lines)
    return made


@pytest.fixture(scope="module")
def linear(system: System) -> ErrorMap:
    return error_map(system, relative_speed=SPEED, tolerance=1e-11)


def draw(count: int, columns: int, seed: int = 3) -> Any:
    rng = np.random.default_rng(seed)
    return rng.standard_normal((count, columns)) + 1j * rng.standard_normal((count, columns))


def scaled(line: Line, z: complex) -> Line:
    return replace(line, gap=z * line.gap, force=z * line.force)


def test_every_sample_is_a_full_solution_of_its_own(system: System, linear: ErrorMap) -> None:
    z = draw(3, 5)
    z[:, 0] = z[:, 0].real
    for i in range(3):
        alone = replace(system, lines=tuple(map(scaled, system.lines, z[i])))
        full = sweep(alone, relative_speed=[SPEED], tolerance=1e-11)
        # harmonics dropped are below 30 x 1e-11 of the dynamic part: squared in an RMS.  A peak between two of 128 or
        # more phases comes from a parabola, and the two keep other phases: (2 pi 8 / 128)^4 / 384 = 6e-5 of the part
        # of the eighth harmonic, which is less than a tenth
        for measure, name, rtol in (("rms", "mesh_force_rms", 1e-9), ("peak", CURVES["peak"], 1e-5)):
            found = error_samples(linear, z[i : i + 1], measure)  # type: ignore[arg-type]
            np.testing.assert_allclose(found[:, 0], full[name].values[:, 0], rtol=rtol)
        lowest = error_samples(linear, z[i : i + 1], "minimum")[:, 0]
        np.testing.assert_allclose(lowest, full.mesh_force_minimum[:, 0], atol=1e-5 * float(full.mesh_force_peak.max()))


def test_a_mean_is_that_of_the_force_over_time(system: System, linear: ErrorMap) -> None:
    from epicyclic.analyses.steady.periodic import periodic

    found = error_samples(linear, np.ones((1, 5)), "mean")[:, 0]
    # both to their tolerances, 1e-11 and 1e-8, of the dynamic part
    np.testing.assert_allclose(found, periodic(system, relative_speed=SPEED).force.mean(axis=1), rtol=1e-7)


def test_lines_that_are_no_columns_stay(system: System) -> None:
    some = error_map(system, [system.lines[3]], relative_speed=SPEED)
    every = error_samples(error_map(system, relative_speed=SPEED), np.array([[1, 1, 1, 0.2j, 1]]))
    # two maps of one train, each to 1e-8
    np.testing.assert_allclose(error_samples(some, np.array([[0.2j]])), every, rtol=1e-7)


def test_mesh_error_columns_are_errors_of_one_mesh_each(case: Any) -> None:
    system = case.pair(lines=())
    columns = mesh_error_lines(system, orders=(1, 2))
    assert [line.causes[0] for line in columns] == [f"error of main/a-b/{i}" for i in (1, 1, 2, 2)]
    z = 1e-6 * draw(1, 4)
    first = case.line(Fraction(137), [z[0, 0], z[0, 2]])
    second = case.line(Fraction(274), [z[0, 1], z[0, 3]])
    full = sweep(replace(system, lines=(first, second)), relative_speed=[SPEED], tolerance=1e-10)
    found = error_samples(error_map(system, columns, relative_speed=SPEED, tolerance=1e-10), z)
    np.testing.assert_allclose(found[:, 0], full.mesh_force_rms.values[:, 0], rtol=1e-8)


def test_a_line_twice_is_two_columns_that_may_cancel(system: System) -> None:
    line = system.lines[1]
    bare = replace(system, lines=())
    twice = error_map(bare, [line, line], relative_speed=SPEED)
    z = np.array([[1 + 2j, -1 - 2j], [0, 0]])
    cancelled, none = error_samples(twice, z).T
    np.testing.assert_allclose(cancelled, none, rtol=1e-12)  # rounding


def test_chunks_and_iterables_change_nothing(linear: ErrorMap, monkeypatch: pytest.MonkeyPatch) -> None:
    z = draw(57, 5)
    whole = error_samples(linear, z)
    np.testing.assert_array_equal(whole, error_samples(linear, z))
    for measure in ("rms", "peak", "mean"):
        once = error_samples(linear, z, measure)
        with monkeypatch.context() as small:
            small.setattr(errors, "_CHUNK", 300)
            pieces = error_samples(linear, (z[i : i + 10] for i in range(0, 57, 10)), measure)
        # a matrix product of another shape sums in another order
        np.testing.assert_allclose(pieces, once, rtol=1e-12)


def test_real_factors_and_no_samples(linear: ErrorMap) -> None:
    np.testing.assert_array_equal(
        error_samples(linear, np.ones((1, 5))), error_samples(linear, np.ones((1, 5), complex))
    )
    assert error_samples(linear, np.ones((0, 5))).shape == (2, 0)


def test_bad_input_is_named(system: System, linear: ErrorMap) -> None:
    with pytest.raises(ModelError, match=r"factors.*\(samples, 5\)"):
        error_samples(linear, np.ones((2, 4)))
    unknown: Any = "mode"
    with pytest.raises(ModelError, match="rms, peak, minimum, mean"):
        error_samples(linear, np.ones((2, 5)), unknown)
    for speed in (0.0, -1.0, np.nan):
        with pytest.raises(ModelError, match="relative_speed"):
            error_map(system, relative_speed=speed)
    with pytest.raises(ModelError, match="orders"):
        mesh_error_lines(system, orders=(-1,))
    with pytest.raises(ModelError, match="no mesh frequency"):
        mesh_error_lines(replace(system, tones=()))
