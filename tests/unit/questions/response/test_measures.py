"""Measures of a response: equal to those of its samples in time, and in balance with the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.measures import (
    Periodic,
    dynamic_factor,
    line_harmonics,
    mean,
    mean_square,
    periodic,
    ranges,
    sweep_measures,
)
from epicyclic.questions.response.response import response
from epicyclic.questions.response.spectra import Signal, Spectrum, lateral_pairs, signal_of_samples
from epicyclic.questions.response.steady import steady, sweep
from epicyclic.questions.response.sweep_table import empty_table, sweep_dataset
from epicyclic.questions.response.views import steady_tables, sweep_tables
from epicyclic.results.dataset import load_result, save_result
from epicyclic.system.system import System

Array = NDArray[np.float64]
TONE, SLOW = Fraction(137), Fraction(137 * 3, 7)
# the sweep may drop 30 x tolerance of the dynamic part, which an RMS feels squared and an extreme directly
FINE = 1e-10
EXPAND = np.zeros((12, 6))
EXPAND[[0, 1, 5, 6, 7, 11], range(6)] = 1.0


def linked(case: Any, lines: list[Any], **changes: Any) -> System:
    """The pair of gears with dampers and errors in its supports, and both bodies told."""
    made: System = case.pair(lines=tuple(lines), **changes)
    c, gap = np.array([30.0, 40.0, 0.0, 20.0]), np.array([2e-6, 1e-6j, 0.0, -3e-6 + 1e-6j])
    links = replace(made.links, damping=c)
    told = []
    for line in made.lines:
        error = gap if line.frequency else gap.real.astype(complex)
        force = line.force.copy()
        force[0] += links.B @ (links.stiffness * error)
        force[1] += links.B @ (2j * np.pi * float(line.frequency) * c * error)
        told.append(replace(line, link_gap=error, force=force))
    C = made.C + (links.B * c) @ links.B.T
    return replace(made, links=links, lines=tuple(told), C=C, dofs=replace(made.dofs, expand=EXPAND))


def with_shafts(case: Any) -> System:
    return linked(
        case,
        [
            case.line(Fraction(0), [2e-6, -1e-6]),
            case.line(TONE, [3e-6, 2e-6j], push=40),
            case.line(Fraction(274, 7), [5e-6, 4e-6j], push=60, cause="deviations.a"),
            case.line(Fraction(137 * 5, 7), [2e-6, 1e-6j], cause="deviations.b"),
            case.line(TONE / 2, [2e-6j, 1e-6], cause="deviations.half"),
        ],
    )


def with_two_tones(case: Any) -> System:
    pair = linked(case, [case.line(TONE, [3e-6, 2e-6j], push=40), case.line(SLOW, [2e-6, 4e-6j], push=30)])
    tones = tuple(sorted({TONE, SLOW}))
    tone = np.array([tones.index(TONE), tones.index(SLOW)])
    return replace(pair, tones=tones, meshes=replace(pair.meshes, tone=tone))


def record(found: Periodic, cycles: int, count: int, what: str) -> Array:
    """The whole signal over so many cycles of the tone, count samples each."""
    values: Array = getattr(found, what)
    step = values.shape[1] // count
    pick = np.arange(cycles * count) % count * step
    times = np.arange(cycles * count) / (count * float(found.tone) * found.relative_speed)
    total = values[:, pick]
    for line in found.lines:
        carrier = np.exp(2j * np.pi * found.relative_speed * float(line.frequency) * times)
        total = total + (getattr(line, what)[:, pick] * carrier).real
    return total


def derived(signal: Array, duration: float, order: int) -> Array:
    """Time derivative of a periodic record."""
    slope = (2j * np.pi * np.fft.rfftfreq(signal.shape[1], duration / signal.shape[1])) ** order
    return np.asarray(np.fft.irfft(np.fft.rfft(signal) * slope, signal.shape[1]))


def link_record(system: System, q: Array, duration: float, speed: float) -> Array:
    """k (B^T q - e) + c d/dt(...) of every link row, sample by sample."""
    times = np.arange(q.shape[1]) * duration / q.shape[1]
    error = np.zeros((len(system.links.name), q.shape[1]))
    for line in system.lines:
        error += np.real(np.outer(line.link_gap, np.exp(2j * np.pi * speed * float(line.frequency) * times)))
    stretch = system.links.B.T @ q - error
    rate = derived(stretch, duration, 1)
    return np.asarray(system.links.stiffness[:, None] * stretch + system.links.damping[:, None] * rate)


@pytest.mark.parametrize(
    ("build", "cycles", "speed"), [(with_shafts, 14, 1.0), (with_shafts, 14, 1.7), (with_two_tones, 7, 1.3)]
)
def test_measures_are_those_of_the_record_in_time(
    case: Any, build: Callable[[Any], System], cycles: int, speed: float
) -> None:
    """The record is the whole period, so that means and RMS are exact and extremes lie inside the bounds."""
    system = build(case)
    result = sweep(system, SweepOptions(relative_speed=[speed], tolerance=FINE)).isel(speed=0)
    found = periodic(system, relative_speed=speed, samples=128, tolerance=FINE)
    duration = cycles / (float(TONE) * speed)
    force, q = (record(found, cycles, 128, what) for what in ("force", "displacement"))
    # two solutions of residual 1e-10, rows dropped up to 3e-9; sums over some hundred rows: 1e-7 of the signal
    close: Any = {"rtol": 1e-7}
    np.testing.assert_allclose(result.mesh_force_mean, force.mean(axis=1), **close)
    np.testing.assert_allclose(result.mesh_force_rms, force.std(axis=1), **close)
    assert np.all(result.mesh_force_peak >= force.max(axis=1) * (1 - 1e-7))
    assert np.all(result.mesh_force_peak_to_peak >= np.ptp(force, axis=1) * (1 - 1e-7))
    np.testing.assert_array_equal(result.mesh_force_peak_to_peak, result.mesh_force_peak - result.mesh_force_minimum)
    np.testing.assert_allclose(result.dynamic_factor, result.mesh_force_peak / force.mean(axis=1), **close)
    # a factor of the second derivative's highest orders, 8 times the drive, stands on what is dropped
    np.testing.assert_allclose(result.acceleration_rms, derived(q, duration, 2).std(axis=1), rtol=1e-6)
    centre = derived(np.stack([q[[0, 1]], q[[3, 4]]]).reshape(4, -1), duration, 2).reshape(2, 2, -1)
    np.testing.assert_allclose(result.body_acceleration_rms, np.sqrt((centre**2).sum(axis=1).mean(axis=1)), rtol=1e-6)
    links = link_record(system, q, duration, speed)
    np.testing.assert_allclose(result.link_force_mean, links.mean(axis=1), **close)
    np.testing.assert_allclose(result.link_force_rms, links.std(axis=1), **close)
    radial = np.hypot(links[[0, 2]], links[[1, 3]])
    np.testing.assert_allclose(
        result.bearing_force_rms**2 + result.bearing_force_mean**2, (radial**2).mean(axis=1), **close
    )
    for name, values in (("link_force_peak", np.abs(links)), ("bearing_force_peak", radial)):
        assert np.all(result[name] >= values.max(axis=1) * (1 - 1e-7))
    assert np.all(result.link_force_peak_to_peak >= np.ptp(links, axis=1) * (1 - 1e-7))
    spectrum = 2 * np.abs(np.fft.rfft(force)) / force.shape[1]
    place = np.round(result.line_order.values * cycles).astype(int)
    np.testing.assert_allclose(result.mesh_force_line, spectrum[:, place], atol=1e-7 * spectrum.max())
    if build is with_shafts:
        np.testing.assert_allclose(
            result.mesh_force_order, spectrum[:, cycles * np.arange(1, 13)], atol=1e-7 * spectrum.max()
        )


def test_without_shaft_lines_the_extremes_are_reached(case: Any) -> None:
    system = linked(case, [case.line(TONE, [3e-6, 2e-6j], push=40)])
    result = sweep(system, SweepOptions(relative_speed=[1.7], tolerance=FINE)).isel(speed=0)
    found = periodic(system, relative_speed=1.7, samples=4096, tolerance=FINE)
    links = link_record(system, found.displacement, 1 / (1.7 * 137), 1.7)
    # a parabola through three of 128 samples misses a peak of 20 harmonics by some 1e-4 of the fourth derivative
    np.testing.assert_allclose(result.mesh_force_peak_to_peak, np.ptp(found.force, axis=1), rtol=1e-4)
    np.testing.assert_allclose(result.dynamic_factor, found.force.max(axis=1) / found.force.mean(axis=1), rtol=1e-4)
    np.testing.assert_allclose(result.link_force_peak_to_peak, np.ptp(links, axis=1), rtol=1e-4)
    np.testing.assert_allclose(result.link_force_peak, np.abs(links).max(axis=1), rtol=1e-4)
    radial = np.hypot(links[[0, 2]], links[[1, 3]]).max(axis=1)
    np.testing.assert_allclose(result.bearing_force_peak, radial, rtol=1e-4)
    assert np.all(result.mesh_force_peak_to_peak <= 2 * result.mesh_force_order.sum("order") * (1 + 1e-4))


@pytest.mark.parametrize("build", [with_shafts, with_two_tones])
def test_one_speed_equals_a_sweep_there(case: Any, build: Callable[[Any], System]) -> None:
    system = build(case)
    alone = steady(system, SteadyOptions(relative_speed=1.3))
    result = sweep(system, SweepOptions(relative_speed=[1.3], tolerance=1e-8)).isel(speed=0)
    names = ["link_force_mean", "link_force_rms", "link_force_peak", "link_force_peak_to_peak"]
    for name in [*names, "bearing_force_mean", "bearing_force_rms", "bearing_force_peak", "dynamic_factor"]:
        np.testing.assert_array_equal(alone[name], result[name])
    # the harmonics of the first tone are a part of all that moves; of 137 Hz and 3/7 of it a combination stands still
    still = 1e-12 if build is with_shafts else 1e-6
    np.testing.assert_allclose(alone.link_force_harmonic[:, 0].real, alone.link_force_mean, rtol=still)
    part = np.sqrt((np.abs(alone.link_force_harmonic[:, 1:].values) ** 2).sum(axis=1) / 2)
    assert np.all(part <= alone.link_force_rms * (1 + 1e-12))
    theta = alone.mesh_phase.values
    wave = np.exp(2j * np.pi * np.outer(alone.harmonic, theta))
    np.testing.assert_allclose(
        alone.link_force, (alone.link_force_harmonic.values @ wave).real, atol=1e-9 * float(alone.link_force_peak.max())
    )


def test_samples_make_the_same_signal() -> None:
    """Parseval, and what a time-domain solver would hand over."""
    rng = np.random.default_rng(3)
    for count in (31, 65):  # of an even number the last order is a square or nothing
        waves = rng.normal(size=(4, 5, count))
        signal = signal_of_samples(waves, TONE)
        # rounding of a transform of some tens of samples
        np.testing.assert_allclose(mean(signal), waves.mean(axis=2), atol=1e-14)
        np.testing.assert_allclose(mean_square(signal), waves.var(axis=2), rtol=1e-13)
    theta = np.arange(64) / 64
    tone = signal_of_samples((3 + 2 * np.cos(2 * np.pi * 5 * theta + 1))[None, None], TONE)
    lines = line_harmonics(tone, [5 * TONE, 4 * TONE, TONE / 2])[0, :, 0]
    np.testing.assert_allclose(np.abs(lines), [2, 0, 0], atol=1e-14)
    slope = mean_square(tone, derivative=1)[0, 0] / (2 * np.pi * 5 * 137) ** 2
    assert slope == pytest.approx(2.0, rel=1e-13)  # 2^2 / 2


def around(mean: Array, lines: NDArray[np.complex128], *, tones: int = 1) -> Signal:
    """Two rows: constant values (2,) and shaft lines (2, S) that no mesh order changes."""
    points = np.vstack([np.zeros((1, tones), np.int64), np.eye(tones, dtype=np.int64)])
    alone = np.eye(1, tones + 1)[0]  # order 0 of all tones
    every = signal_of_samples(np.zeros((1, 1, 3)), TONE).line_frequencies
    return Signal(
        orders=Spectrum(amplitude=mean[:, None, None, None] * alone + 0j, points=points, mirrored=True),
        lines=Spectrum(amplitude=lines[:, None, :, None] * alone, points=points, mirrored=False),
        line_frequencies=every,
    )


@pytest.mark.parametrize("tones", [1, 2])
def test_a_rotating_force_is_as_long_as_its_radius(tones: int) -> None:
    """x and y of a force that turns do not peak together: hypot of both amplitudes is sqrt(2) of it."""
    turning = np.array([[1.0], [-1j]])
    pair = np.array([[0, 1]])
    (alone,) = ranges(around(np.zeros(2), turning, tones=tones), pair).length[:, 0]
    assert alone == pytest.approx(1.0, rel=1e-9)
    (beside,) = ranges(around(np.array([3.0, 4.0]), turning, tones=tones), pair).length[:, 0]
    # three steps from a direction 4 degrees away; of several tones a parabola through directions 7.5 degrees apart
    assert beside == pytest.approx(6.0, rel=1e-7 if tones == 1 else 1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_the_largest_length_is_that_of_all_phases(seed: int) -> None:
    """Two elliptic lines about a mean force, against every pair of 400 phases."""
    rng = np.random.default_rng(seed)
    mean_force = rng.normal(size=2)
    lines = rng.normal(size=(2, 2)) + 1j * rng.normal(size=(2, 2))
    turns = np.exp(2j * np.pi * np.arange(400) / 400)
    one, other = (np.real(np.outer(line, turns)) for line in lines.T)
    every = mean_force[:, None, None] + one[:, :, None] + other[:, None, :]
    (found,) = ranges(around(mean_force, lines), np.array([[0, 1]])).length[:, 0]
    # phases a 400th of a turn apart miss at most 1 - cos(pi / 400) = 3e-5
    assert found == pytest.approx(np.hypot(*every).max(), rel=1e-4)


def test_of_several_mesh_frequencies_the_largest_is_called_a_bound(case: Any) -> None:
    for build, bound in ((with_shafts, False), (with_two_tones, True)):
        system = build(case)
        for result, tables in (
            (steady(system, SteadyOptions()), steady_tables),
            (sweep(system, SweepOptions(relative_speed=[1.0, 1.3])), sweep_tables),
        ):
            words = str([list(table.columns) for table in tables(result)])
            assert ("largest, a bound [N]" in words) is bound
            assert str(result.bearing_force_peak.attrs["long_name"]).startswith("bound") is bound


def test_an_integration_fills_the_same_table(case: Any) -> None:
    """What a solver in time hands over: samples of one cycle, integrated from the state at its beginning."""
    system, speed, count = linked(case, [case.line(TONE, [3e-6, 2e-6j], push=40)]), 1.3, 129
    found = periodic(system, relative_speed=speed, samples=count, tolerance=1e-11)
    period = 1 / (137 * speed)
    velocity = derived(found.displacement, period, 1)
    times = np.arange(count + 1) * period / count
    q, force = case.motion(system, speed).integrate(times, found.displacement[:, 0], velocity[:, 0], rtol=1e-10)
    table = empty_table(response(system), 2, orders=12, shafts=False)
    measures = sweep_measures(
        table.layout,
        speed=np.array([speed]),
        force=signal_of_samples(force[:, None, :-1], TONE),
        motion=signal_of_samples(q[:, None, :-1], TONE),
        links=signal_of_samples(link_record(system, q[:, :-1], period, speed)[:, None], TONE),
    )
    for name in measures.keys() & table.values.keys():
        table.values[name][..., 1] = measures[name][..., 0]
    expected = sweep(system, SweepOptions(relative_speed=[speed], tolerance=1e-11))
    for name, values in table.values.items():
        assert np.isnan(values[..., 0]).all()
        if name != "residual":
            wanted = expected[name].values[..., 0]
            # rtol 1e-10 leaves some 1e-8 of the signal, twice derived 1e-5 of it
            np.testing.assert_allclose(values[..., 1], wanted, atol=1e-5 * np.abs(wanted).max(), err_msg=name)
    status = np.array(["", "ok"], dtype=object)
    speeds = np.array([np.nan, speed])
    result = sweep_dataset(replace(table, status=status), response(system), speeds, SweepOptions(), [])
    assert set(result.variables) == set(expected.variables)


def test_no_excitation_no_dynamic_factor(case: Any) -> None:
    still = case.pair(swing=0.0, lines=())
    result = sweep(still, SweepOptions(relative_speed=[0.5, 1.0, 2.0]))
    # nothing moves: only the rounding of the mean is left
    np.testing.assert_allclose(result.dynamic_factor, 1.0, rtol=1e-12)
    for name in ("mesh_force_rms", "mesh_force_peak_to_peak", "link_force_rms", "acceleration_rms"):
        assert float(np.abs(result[name]).max()) < 1e-9


def test_a_mesh_that_transmits_nothing_has_no_dynamic_factor() -> None:
    mean, groups = np.array([2.0, 0.0, -1.0, 1.0]), [np.array([i]) for i in range(4)]
    factor = dynamic_factor(np.array([3.0, 3.0, 3.0, np.nan]), mean, groups, 0.0)
    np.testing.assert_array_equal(factor, [1.5, np.nan, np.nan, np.nan])


def test_a_preload_is_part_of_a_link_force(case: Any) -> None:
    plain = linked(case, [case.line(TONE, [3e-6, 2e-6j])])
    held = replace(plain, links=replace(plain.links, preload=np.array([0.0, 50.0, 0.0, 0.0])))
    more = (
        sweep(held, SweepOptions(relative_speed=[1.0])).link_force_mean
        - sweep(plain, SweepOptions(relative_speed=[1.0])).link_force_mean
    )
    # the difference of forces of 1e3 N
    np.testing.assert_allclose(more.values[:, 0], [0, 50, 0, 0], atol=1e-9)


def test_the_table_stays_small(case: Any) -> None:
    """Whatever number of lines there is, those told are few; the table is some numbers a row and speed."""
    many = linked(case, [case.line(Fraction(137 * i, 977), [1e-6, 1e-6j], cause=f"d{i}") for i in range(1, 21)])
    result = sweep(many, SweepOptions(relative_speed=[1.0, 2.0]))
    assert result.sizes["line"] == 20
    assert "d3 -1 mesh" in sweep(with_shafts_of(case, 3), SweepOptions(relative_speed=[1.0])).line.values
    assert result.mesh_force_line.nbytes == 2 * 20 * 2 * 8
    many_tones = sweep(with_two_tones(case), SweepOptions(relative_speed=[1.0], orders=100))
    assert many_tones.sizes["line"] <= 64


def with_shafts_of(case: Any, count: int) -> System:
    return linked(case, [case.line(Fraction(137 * i, 977), [1e-6, 1e-6j], cause=f"d{i}") for i in range(1, count + 1)])


def test_a_blank_table_is_nan(case: Any) -> None:
    system = with_shafts(case)
    table = empty_table(response(system), 3, orders=4, shafts=True)
    assert table.values["mesh_force_order"].shape == (2, 4, 3)
    assert all(np.isnan(values).all() for values in table.values.values())


def test_everything_goes_through_files(case: Any, tmp_path: Path) -> None:
    result = sweep(with_shafts(case), SweepOptions(relative_speed=[0.5, 1.0, np.nan]))
    xr.testing.assert_identical(load_result(save_result(result, tmp_path / "sweep.nc")), result)
    again = load_result(save_result(result, tmp_path / "sweep.json"))
    for name in ("mesh_force_order", "mesh_force_line", "bearing_force_peak", "line_order"):
        np.testing.assert_array_equal(again[name], result[name])
    assert list(again.bearing.values) == ["main/a/support", "main/b/support"]
    assert np.isnan(result.dynamic_factor.values[:, 2]).all()


@pytest.mark.parametrize("orders", [0, 101])
def test_orders_out_of_range_are_refused(orders: int) -> None:
    with pytest.raises(ModelError, match="1 to 100"):
        epicyclic.sweep("dong2019", relative_speed=[1.0], orders=orders)


def test_lateral_rows(case: Any) -> None:
    pair = case.pair()
    names = ("a/x", "a/y", "b/radial", "b/tangential")
    links = replace(pair.links, name=names, link=("a", "a", "b", "b"))
    np.testing.assert_array_equal(lateral_pairs(replace(pair, links=links)), [[0, 1], [2, 3]])
    alone = replace(links, name=("a/x", "a/z", "b/y", "b/rz"))
    assert lateral_pairs(replace(pair, links=alone)).shape == (0, 2)
