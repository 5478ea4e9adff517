"""Figures of motion over time, from a made-up ramp whose spectrum is known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from epicyclic.show.charts.over_time import spectrogram, transient_forces
from epicyclic.show.report import report
from epicyclic.show.series import ramps


def run(first: float, last: float) -> xr.Dataset:
    """Two meshes over 4 s: the mesh frequency, three times as strong in the second, and a band at 300 Hz."""
    time = np.arange(8001) / 2000
    frequency = np.linspace(first, last, time.size)
    phase = 2 * np.pi * np.cumsum(frequency) / 2000
    wave = 1e3 * np.cos(phase) + 100 * np.cos(2 * np.pi * 300 * time)
    force = np.stack([5e3 + wave, 5e3 + 3 * wave])
    extremes = {
        "mesh_force_minimum": ("mesh", force.min(axis=1)),
        "mesh_force_peak": ("mesh", force.max(axis=1)),
        "mesh_force_peak_time": ("mesh", time[force.argmax(axis=1)]),
        "contact_lost": ("mesh", np.zeros(2, dtype=bool)),
        "status": ((), "ok"),
    }
    return xr.Dataset(
        {"mesh_force": (("mesh", "time"), force), **extremes},
        {"mesh": ["main/sun-planet/1", "main/planet-ring/1"], "time": time, "mesh_frequency": ("time", frequency)},
        {"verb": "transient", "title": "a ramp", "warnings": "[]"},
    )


def test_forces_over_time() -> None:
    drawn = transient_forces(run(50, 200))
    assert [text.text for text in drawn.layout.annotations[:3]] == ["sun-planet", "planet-ring", "mesh frequency"]
    assert drawn.layout.yaxis.title.text == "force [kN]"
    assert drawn.layout.xaxis3.title.text == "time [s]"
    assert max(drawn.data[1].y) == pytest.approx(5 + 3.3, abs=0.02)  # peaks survive the thinning
    assert len(drawn.data[1].x) <= 3100
    assert sum(trace.showlegend is not False for trace in drawn.data) == 1
    steady = transient_forces(run(100, 100))
    assert len(steady.data) == 2
    assert ramps(run(50, 200))
    assert not ramps(run(100, 100))


def test_the_spectrogram_shows_orders_and_bands() -> None:
    drawn = spectrogram(run(50, 200))
    heat = drawn.data[0]
    level, time, frequency = np.array(heat.z, float), np.array(heat.x), np.array(heat.y)
    assert "planet-ring" in drawn.layout.title.text  # the stronger of the two
    ridge = frequency[level.argmax(axis=0)]
    np.testing.assert_allclose(ridge, 50 + 150 * time / 4, atol=2 * (frequency[1] - frequency[0]))
    band = level[np.abs(frequency - 300).argmin()]
    assert 10 ** (np.median(band) / 20) == pytest.approx(0.3, rel=0.1)  # 3 x 100 N in kN
    assert frequency.max() <= 1000  # what the samples resolve
    assert "sun-planet" in spectrogram(run(50, 200), "main/sun-planet/1").layout.title.text


def test_a_report_of_a_run() -> None:
    page = report({"transient": run(50, 200)})
    assert "Motion over time" in page
    assert "figure-spectrogram" in page
    assert "figure-spectrogram" not in report({"transient": run(100, 100)})
