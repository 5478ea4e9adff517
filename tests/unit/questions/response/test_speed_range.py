"""Default speeds of a sweep: about operation with the resonances in it, and to the modes on request."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.system import System


@cache
def ren() -> System:
    return epicyclic.assemble(epicyclic.load("ren2021"))


def test_a_sweep_is_about_operation_and_meets_the_resonances() -> None:
    result = epicyclic.sweep(ren(), points=160)
    speed = result.speed.values
    assert speed.size == 160
    assert (np.diff(speed) > 0).all()
    assert (speed[0], speed[-1]) == (pytest.approx(0.05), pytest.approx(1.3))
    assert 1.0 in speed
    assert json.loads(result.attrs["options"])["speed_range"] == "operation"
    crossings = epicyclic.modes(ren()).resonance_speed.values
    assert np.abs(speed[:, None] - crossings).min(axis=0).max() < 1e-9
    # between 5 and 130 % no gap is wider than three spacings of as many even speeds
    assert np.diff(speed).max() < 3 * 1.25 / 159


def test_half_power_speeds_resolve_a_peak() -> None:
    """Largest of the order over the sweep: as on a grid fifty times finer about the resonance."""
    modes, sweep = epicyclic.modes(ren()), epicyclic.sweep(ren())
    at = int(np.argmax(modes.resonance_amplitude.values))
    order, speed = int(modes.resonance_order.values[at]), float(modes.resonance_speed.values[at])
    fine = epicyclic.sweep(ren(), relative_speed=np.linspace(0.95 * speed, 1.05 * speed, 101))
    near = np.abs(sweep.speed.values - speed) < 0.05 * speed
    largest = float(sweep.mesh_force_order.sel(order=order).values[:, near].max())
    assert largest == pytest.approx(float(fine.mesh_force_order.sel(order=order).max()), rel=0.03)


def test_the_range_to_the_modes_is_asked_for() -> None:
    result = epicyclic.sweep(ren(), range="modes", points=5)
    natural = epicyclic.modes(ren()).frequency.values
    tone = float(ren().tones[0])
    np.testing.assert_allclose(result.mesh_frequency.values, np.linspace(0.2 * tone, 1.2 * natural.max(), 5))
    assert json.loads(result.attrs["options"])["speed_range"] == "modes"


@pytest.mark.parametrize("points", [1, 2, 3, 7, 26, 51])
def test_as_many_speeds_as_asked_for(points: int) -> None:
    speed = epicyclic.sweep(ren(), points=points).speed.values
    assert speed.size == points == np.unique(speed).size
    assert 1.0 in speed


def test_a_missing_end_is_that_of_the_range() -> None:
    tone = float(ren().tones[0])
    above = epicyclic.sweep(ren(), start="50 %", points=3).speed.values
    np.testing.assert_allclose(above, [0.5, 0.9, 1.3])
    np.testing.assert_allclose(epicyclic.sweep(ren(), stop="80 %", points=2).speed.values, [0.05, 0.8])
    modes = epicyclic.sweep(ren(), start="50 %", points=2, range="modes")
    assert float(modes.mesh_frequency.values[-1]) > 40 * tone
    # beyond operation: as far as the modes go
    assert epicyclic.sweep(ren(), start="200 %", points=2).mesh_frequency.values[-1] > 40 * tone


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"range": "wide"}, "'operation' or 'modes'"),
        ({"range": "modes", "relative_speed": [1.0]}, "^range = modes"),
        ({"points": 3, "mesh_frequency": [20.0]}, "points"),
        ({"range": "modes", "start": 10.0, "stop": 20.0}, "range"),
    ],
)
def test_ranges_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        epicyclic.sweep(ren(), **options)


def test_contact_loss_has_the_same_range() -> None:
    linear = epicyclic.sweep(ren(), points=4)
    found = epicyclic.sweep(ren(), points=4, contact_loss=True, unstable="ignore", shaft_orders=False)
    np.testing.assert_array_equal(found.speed.values, linear.speed.values)
    assert json.loads(found.attrs["options"])["speed_range"] == "operation"


def test_speeds_are_named_for_what_they_are() -> None:
    result = epicyclic.sweep(ren(), points=1)
    assert result.speed.attrs == {"units": "1", "long_name": "speed per operating speed"}
    ranked = epicyclic.sensitivity("ren2021", paths=["damping.modal", "stages.main.sun.support.radial"])
    assert ranked.path.attrs["long_name"] == "path of the number in the model file"
    assert epicyclic.check("ren2021").speed.attrs["long_name"] == "absolute speed, counter-clockwise positive"
