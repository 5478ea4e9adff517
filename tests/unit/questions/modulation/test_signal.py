"""The signal over time, written out from the response without its lines, against the lines; and what scales them."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from epicyclic.questions.modulation import ModulationOptions
from epicyclic.questions.modulation.modulation import modulation
from epicyclic.questions.modulation.spectrum import Window, tabulated_transfer
from epicyclic.questions.response.measures import periodic
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

from .conftest import every_line

Array = NDArray[np.float64]
Make = Callable[..., System]
RUN_OUTS = {"deviations.sun.run_out": "20 um", "deviations.planet.run_out": "[20, 5, 0] um"}
SAMPLES = 256  # of a mesh cycle: twice more than the highest order


def turns_of(system: System, body: str) -> Fraction:
    return dict(zip(system.dofs.bodies, system.body_turns, strict=True))[body]


def record(system: System, cycles: int, speed: float = 1.0) -> tuple[Array, Array, Array]:
    """Times, mesh forces and coordinates over so many mesh cycles, from the envelopes of `periodic`."""
    solved = periodic(system, samples=SAMPLES, relative_speed=speed)
    tone = float(solved.tone) * speed
    time = np.arange(cycles * SAMPLES) / (SAMPLES * tone)
    phase = np.arange(time.size) % SAMPLES
    force, moved = solved.force[:, phase].copy(), solved.displacement[:, phase].copy()
    for line in solved.lines:
        turn = np.exp(2j * np.pi * speed * float(line.frequency) * time)
        force += (line.force[:, phase] * turn).real
        moved += (line.displacement[:, phase] * turn).real
    return time, force, moved


def bins(result: xr.Dataset, duration: float, count: int) -> NDArray[np.complex128]:
    """The lines as an FFT over that duration would have them."""
    found = np.zeros(count // 2 + 1, complex)
    cycles = result.line_frequency.values * duration
    place = cycles.round().astype(int)
    assert cycles == pytest.approx(place, abs=1e-6)  # whole numbers of cycles: a super-period
    assert place.max() < count // 2
    np.add.at(found, place, result.signal_amplitude.values)
    return found


def lopsided(phi: Array) -> Array:
    return np.asarray(0.6 + 0.3 * np.cos(phi) + 0.2 * np.sin(phi) - 0.1 * np.sin(2 * phi))


@pytest.mark.parametrize(
    ("window", "gain", "speed"),
    [
        ("cos4", lambda phi: np.cos(phi / 2) ** 4, 1.0),
        (Window(name="series", coefficients=np.array([0.6, 0.15 - 0.1j, 0.05j])), lopsided, 0.37),
    ],
)
def test_lines_are_the_fft_of_the_passing_forces(
    system_of: Make, window: str | Window, gain: Callable[[Array], Array], speed: float
) -> None:
    system = system_of("even, in phase", RUN_OUTS)
    result = modulation(system, ModulationOptions(window=window, sensor=0.9, floor=0.0, relative_speed=speed))
    cycles = 3 * 96  # three turns of the carrier: the planets, 36 teeth, are then as at the start
    time, force, _ = record(system, cycles, speed)
    ring = [i for i, internal in enumerate(system.meshes.internal) if internal]
    carrier = 2 * np.pi * float(turns_of(system, "main/carrier")) * speed
    signal = np.zeros(time.size)
    for row in ring:
        away = system.meshes.direction[row] + carrier * time - 0.9
        signal += gain(away) * (force[row] - force[row].mean())
    fft = np.fft.rfft(signal - signal.mean()) * 2 / signal.size
    lines = bins(result, cycles / (float(system.tones[0]) * speed), signal.size)
    # two sums of the same solution; rounding only
    assert np.abs(fft - lines).max() < 1e-9 * np.abs(lines).max()
    # Parseval
    assert np.mean((signal - signal.mean()) ** 2) == pytest.approx((np.abs(lines) ** 2).sum() / 2, rel=1e-9)


def test_the_mean_load_passes_where_asked_for(system_of: Make) -> None:
    system = system_of("even, in sequence")
    result = modulation(system, ModulationOptions(window="hann", floor=0.0, mean_load=True))
    mean = result.isel(line=result.family.values == "mean load passing")
    ring = float(
        np.mean(
            [force.mean() for force, inner in zip(periodic(system).force, system.meshes.internal, strict=True) if inner]
        )
    )
    (at_n,) = np.abs(mean.signal_amplitude.values[mean.carrier_order.values.round(9) == 4])
    # four Hann windows over a quarter turn add up to 1 with c_N = c_0 / 2, c_0 = 1/8: no swing at N, one at N only each
    assert at_n == pytest.approx(2 * 4 * (1 / 16) * ring, rel=1e-3)
    assert "mean load passing" not in set(modulation(system, ModulationOptions()).family.values)


@pytest.mark.parametrize("direction", ["radial", "tangential"])
def test_the_ring_is_felt_as_seen_from_the_housing(system_of: Make, direction: Literal["radial", "tangential"]) -> None:
    system = system_of("even, in phase", RUN_OUTS)
    angle, cycles, names = 0.6, 3 * 96, list(system.dofs.names)
    result = modulation(system, ModulationOptions(sensor=angle, direction=direction, floor=0.0, window="constant"))
    time, _, moved = record(system, cycles)
    x, y = (moved[names.index(f"main/ring/{axis}")] for axis in "xy")
    rz = names.index("main/ring/rz")
    b = angle - 2 * np.pi * float(turns_of(system, "main/carrier")) * time
    sensor_motion = x * np.cos(b) + y * np.sin(b)
    if direction == "tangential":
        sensor_motion = -x * np.sin(b) + y * np.cos(b) + system.dofs.radius[rz] * moved[rz]
    duration = cycles / float(system.tones[0])
    fft = np.fft.rfft(sensor_motion) * 2 / sensor_motion.size
    fft *= -((2 * np.pi * np.arange(fft.size) / duration) ** 2)
    lines = np.zeros(fft.size, complex)
    place = (result.line_frequency.values * duration).round().astype(int)
    np.add.at(lines, place, result.sensor_acceleration.values)
    # w^2 raises the rounding of the FFT at the top of the spectrum; 40 mesh orders hold what moves
    assert np.abs(fft - lines)[: 40 * cycles].max() < 1e-9 * np.abs(lines).max()
    assert np.abs(lines[40 * cycles :]).max() < 1e-3 * np.abs(lines).max()


def test_the_sensor_angle_turns_phases(system_of: Make) -> None:
    system = system_of("even, in phase", RUN_OUTS)
    first, second = (
        modulation(system, ModulationOptions(window="cos4", sensor=angle, floor=1e-6)) for angle in (0.0, 1.3)
    )
    assert list(first.line.values) == list(second.line.values)
    for label, a, b in zip(
        first.line.values, first.signal_amplitude.values, second.signal_amplitude.values, strict=True
    ):
        words = str(label).split()
        at = words.index("carrier") if "carrier" in words else None
        k = 0 if at is None else int(words[at - 2]) * (-1 if at > 2 and words[at - 3] == "-" else 1)
        assert b == pytest.approx(
            a * np.exp(-1.3j * k), rel=1e-9, abs=1e-12 * np.abs(first.signal_amplitude.values).max()
        )


def test_a_constant_window_is_the_plain_sum(system_of: Make) -> None:
    system = system_of("even, in sequence")
    result = modulation(system, ModulationOptions(window="constant", floor=0.0, turns=1))
    _, force, _ = record(system, 95)
    total = sum(force[row] for row, inner in enumerate(system.meshes.internal) if inner)
    fft = np.fft.rfft(total - total.mean()) * 2 / total.size
    lines = bins(result, 95 / float(system.tones[0]), total.size)
    assert np.abs(fft - lines).max() < 1e-9 * np.abs(lines).max()
    strong = result.isel(line=np.abs(result.signal_amplitude.values) > 1e-8 * np.abs(lines).max())
    # 95 teeth, 4 planets: only every fourth mesh order is left of four forces in sequence
    assert all(round(order) % 4 == 0 for order in strong.mesh_order.values)
    assert set(strong.family.values) == {"mesh"}


def test_the_signal_is_the_sum_of_its_lines(system_of: Make) -> None:
    result = modulation(system_of("even, in phase", RUN_OUTS), ModulationOptions(window="cos4", turns=3))
    time = result.sample_time.values
    turn = np.exp(2j * np.pi * np.outer(time[::97], result.line_frequency.values))
    assert result.signal.values[::97] == pytest.approx(
        (turn @ result.signal_amplitude.values).real,
        abs=1e-10 * np.abs(result.signal.values).max(),  # phases of 1e4 rad, rounded
    )
    # three turns of the carrier are the common period of sun, planets and carrier: Parseval of what is kept
    assert Fraction(result.attrs["common_period"]) == 3 / turns_of(system_of("even, in phase"), "main/carrier")
    power = (np.abs(result.signal_amplitude.values) ** 2).sum() / 2
    assert np.mean(result.signal.values**2) == pytest.approx(power, rel=1e-9)
    assert 1 - 1e-4 < result.attrs["power_kept"] <= 1


def test_halves_of_a_herringbone_ring_add_up() -> None:
    system = assemble(load("ren2021"))
    left, right, both = (
        modulation(system, ModulationOptions(body=body, floor=0.0, sensor=0.4))
        for body in ("main/ring/left", "main/ring/right", "main/ring")
    )
    total: dict[str, complex] = {}
    for part in (left, right):
        for text, value in zip(part.exact_frequency.values, part.signal_amplitude.values, strict=True):
            total[text] = total.get(text, 0) + value
    largest = float(np.abs(both.signal_amplitude).max())
    for text, value in zip(both.exact_frequency.values, both.signal_amplitude.values, strict=True):
        assert abs(total[text] - value) < 1e-12 * largest
    assert float(np.abs(left.signal_amplitude).max()) == pytest.approx(largest / 2, rel=0.2)


def test_transfer_paths(system_of: Make) -> None:
    system = system_of("even, in phase")
    plain = every_line("even, in phase")
    twice = modulation(system, ModulationOptions(floor=0.0, transfer=tabulated_transfer([0, 1e6], [2, 2], math.pi / 2)))
    assert twice.signal_amplitude.values == pytest.approx(2j * plain.signal_amplitude.values, rel=1e-12)
    assert twice.signal.attrs["units"] == "N"
    moved = modulation(
        system, ModulationOptions(floor=0.0, transfer=tabulated_transfer([0, 1e6], [3e-3, 3e-3], unit="m/s2/N"))
    )
    same = dict(zip(plain.exact_frequency.values, plain.signal_amplitude.values, strict=True))
    expected = [3e-3 * same.get(text, 0) for text in moved.exact_frequency.values] + moved.sensor_acceleration.values
    assert moved.signal_amplitude.values == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert moved.signal.attrs["units"] == moved.signal_amplitude.attrs["units"] == "m/s2"
    narrow = modulation(system, ModulationOptions(transfer=tabulated_transfer([300, 500], [1, 1])))
    assert narrow.line_frequency.values.min() >= 300
    assert narrow.line_frequency.values.max() <= 500
    assert "transfer path is given from 300 to 500 Hz" in narrow.attrs["warnings"]


def test_a_phase_over_half_a_turn_is_unwrapped() -> None:
    path = tabulated_transfer([0, 100, 200], [1, 1, 1], np.radians([0, 170, -20]))
    assert np.angle(path.at(np.array([150.0])), deg=True)[0] == pytest.approx(255 - 360)
    assert path.at(np.array([201.0]))[0] == 0


@pytest.mark.parametrize(
    "columns",
    [
        ([1.0], [1.0], 0.0),
        ([1.0, 1.0], [1.0, 1.0], 0.0),
        ([-1.0, 1.0], [1.0, 1.0], 0.0),
        ([0.0, 1.0], [1.0, -1.0], 0.0),
        ([0.0, 1.0], [1.0, math.nan], 0.0),
        ([0.0, 1.0, 2.0], [1.0, 1.0], 0.0),
        ([0.0, 1.0], [1.0, 1.0], [0.0, 0.0, 0.0]),
    ],
)
def test_transfer_paths_that_are_none(columns: tuple[Any, Any, Any]) -> None:
    with pytest.raises(ValueError, match="transfer"):
        tabulated_transfer(*columns)


def test_a_sensor_over_both_halves_feels_their_mean() -> None:
    system = assemble(load("ren2021"))
    left, right, both = (
        modulation(system, ModulationOptions(body=body, floor=0.0, window="constant")).sensor_acceleration.values
        for body in ("main/ring/left", "main/ring/right", "main/ring")
    )
    assert both == pytest.approx((left + right) / 2, abs=1e-12 * np.abs(both).max())
