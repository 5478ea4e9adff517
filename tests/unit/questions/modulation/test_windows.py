"""Windows as Fourier series against the functions they stand for."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from epicyclic.errors import ModelError
from epicyclic.questions.modulation.spectrum import Window, named_window, tabulated_window

Array = NDArray[np.float64]


def hann(width: float) -> Callable[[float], float]:
    return lambda phi: math.cos(math.pi * phi / width) ** 2 if abs(phi) < width / 2 else 0.0


def gaussian(sigma: float) -> Callable[[float], float]:
    return lambda phi: sum(math.exp(-(((phi + 2 * math.pi * turn) / sigma) ** 2) / 2) for turn in range(-4, 5))


@pytest.mark.parametrize(
    ("window", "shape", "breaks"),
    [
        (named_window("hann", planets=3), hann(2 * math.pi / 3), (math.pi / 3,)),
        (named_window("hann", planets=1), hann(2 * math.pi), ()),
        (named_window("hann", planets=4, width=2.0), hann(2.0), (1.0,)),
        (named_window("gaussian", planets=4), gaussian(math.pi / 8), ()),
        (named_window("gaussian", planets=4, width=1.3), gaussian(1.3), ()),
        (named_window("cos2", planets=4), lambda phi: math.cos(phi / 2) ** 2, ()),
        (named_window("cos8", planets=4), lambda phi: math.cos(phi / 2) ** 8, ()),
        (named_window("constant", planets=4), lambda phi: 1.0, ()),
        (tabulated_window([-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]), lambda phi: max(0.0, 1 - abs(phi)), (0.0, 1.0)),
    ],
    ids=lambda value: value.name if isinstance(value, Window) else "",
)
def test_coefficients_are_the_integrals(
    window: Window, shape: Callable[[float], float], breaks: tuple[float, ...]
) -> None:
    points = sorted({*breaks, *(-b for b in breaks)}) or None
    for k, coefficient in enumerate(window.coefficients[:7]):
        # quad is asked for 1e-10 of a function of size 1
        part, _ = quad(lambda phi, k=k: shape(phi) * math.cos(k * phi), -math.pi, math.pi, points=points, limit=200)
        assert coefficient == pytest.approx(part / (2 * math.pi), abs=1e-9)


def test_a_whole_hann_is_cos2() -> None:
    wide = named_window("hann", planets=5, width=2 * math.pi)
    assert wide.coefficients[:2] == pytest.approx(named_window("cos2", planets=5).coefficients, abs=1e-15)
    assert np.abs(wide.coefficients[2:]).max(initial=0.0) < 1e-15


@pytest.mark.parametrize("word", ["hann", "gaussian", "cos2", "cos6", "constant"])
def test_the_gain_under_the_sensor_is_one(word: str) -> None:
    window = named_window(word, planets=3)
    # what a cut series lacks at the top: harmonics fall as k^-3 and are cut at 1e-4 of the RMS
    assert window.at(0.0) == pytest.approx(1.0, abs=2e-3)
    assert window.remainder <= 1e-4


def test_a_cut_window_keeps_its_power() -> None:
    table = tabulated_window([-0.3, -0.29, 0.29, 0.3], [0.0, 1.0, 1.0, 0.0])  # nearly a box: slow to converge
    power = float(abs(table.coefficients[0]) ** 2 + 2 * (np.abs(table.coefficients[1:]) ** 2).sum())
    exact = (2 * 0.29 + 2 * 0.01 / 3) / (2 * math.pi)
    assert 1e-3 < table.remainder < 0.1
    # the remainder is counted to harmonic 4096; what is left beyond falls as k^-4
    assert power == pytest.approx(exact * (1 - table.remainder**2), rel=1e-6)


def test_a_table_passes_through_its_points() -> None:
    angle, gain = np.radians([-150.0, -20.0, 5.0, 90.0]), np.array([0.2, 0.5, 1.0, 0.4])
    window = tabulated_window(angle, gain)
    assert window.at(angle) == pytest.approx(gain, abs=5e-3)  # corners converge as 1/K
    assert tabulated_window([0.4], [0.7]).at([0.0, 1.0, 3.0]) == pytest.approx(0.7, abs=1e-15)


def test_a_window_is_its_fourier_series() -> None:
    window = Window(name="series", coefficients=np.array([0.5, 0.15 - 0.05j, 0.1j]))
    phi = np.linspace(0, 6, 11)
    wanted = 0.5 + 0.3 * np.cos(phi) + 0.1 * np.sin(phi) - 0.2 * np.sin(2 * phi)
    assert window.at(phi) == pytest.approx(wanted, abs=1e-14)
    assert np.sum(window.sides[:, None] * np.exp(1j * np.outer(np.arange(-2, 3), phi)), axis=0) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("make", "path"),
    [
        (lambda: named_window("boxcar", planets=3), "window"),
        (lambda: named_window("cos3", planets=3), "window"),
        (lambda: named_window("cos0", planets=3), "window"),
        (lambda: named_window("hann", planets=3, width=7.0), "width"),
        (lambda: named_window("hann", planets=3, width=float("nan")), "width"),
        (lambda: named_window("cos2", planets=3, width=1.0), "width"),
        (lambda: tabulated_window([], []), "window"),
        (lambda: tabulated_window([0.0, 1.0], [1.0]), "window"),
        (lambda: tabulated_window([0.0, 1.0], [1.0, -0.1]), "window"),
        (lambda: tabulated_window([0.0, 1.0], [0.0, 0.0]), "window"),
        (lambda: tabulated_window([0.0, 1.0], [1.0, math.nan]), "window"),
        (lambda: tabulated_window([1.0, 0.0], [1.0, 1.0]), "window"),
        (lambda: tabulated_window([0.0, 7.0], [1.0, 1.0]), "window"),
    ],
)
def test_windows_that_are_none(make: Callable[[], Window], path: str) -> None:
    with pytest.raises(ModelError, match=path):
        make()
