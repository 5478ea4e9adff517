"""Where a sensor may sit: rings that stand, housings, stages; star drives; and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modulation import ModulationOptions
from epicyclic.questions.modulation.modulation import modulation
from epicyclic.questions.modulation.spectrum import sensor_position
from epicyclic.questions.response import SteadyOptions
from epicyclic.questions.response.steady import steady
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

from .conftest import document, every_line

Make = Callable[..., System]


@pytest.fixture(scope="module")
def star() -> System:
    """The same gears with the carrier held: the ring turns."""
    changes = {"operation.held": ["carrier"], "stages.main.ring.support.rz": None, "deviations.ring.run_out": "10 um"}
    return assemble(load(document("even, in sequence"), overrides=changes))


def test_no_ring_that_turns(star: System) -> None:
    with pytest.raises(ModelError, match=r"main/ring turns at .* rpm") as error:
        modulation(star, ModulationOptions())
    assert "main/carrier, housing" in str(error.value)


@pytest.mark.parametrize("body", ["housing", "main/carrier"])
def test_planets_that_do_not_pass_do_not_modulate(star: System, body: str) -> None:
    result = modulation(star, ModulationOptions(body=body, window="cos2", sensor=0.8, floor=1e-9))
    assert result.attrs["carrier_frequency"] == 0
    assert "carrier" not in "".join(map(str, result.line.values))
    assert np.isnan(result.passage.values).all()
    forces = steady(star, SteadyOptions()).mesh_force_harmonic
    ring = forces.values[["planet-ring" in str(name) for name in forces.mesh.values]]
    gains = np.cos((2 * np.pi * np.arange(4) / 4 - 0.8) / 2) ** 2
    mesh = {
        round(o): a
        for o, a in zip(result.mesh_order.values, result.signal_amplitude.values, strict=True)
        if abs(o - round(o)) < 1e-9
    }
    largest = max(map(abs, mesh.values()))
    for order in (1, 2, 3, 4):
        assert mesh.get(order, 0) == pytest.approx(gains @ ring[:, order], rel=1e-9, abs=1e-9 * largest)
    assert "ring run-out" in set(result.family.values)


def test_teeth_follow_from_frequencies(system_of: Make, star: System) -> None:
    held = sensor_position(system_of("even, in sequence"), stage=None, body=None, angle=0.0)
    assert held.teeth == -95  # seen from the carrier the ring's teeth come clockwise
    assert set(held.others) == {-95, 21}
    assert held.even
    assert sensor_position(star, stage=None, body="housing", angle=0.0).teeth == -95
    assert not sensor_position(system_of("uneven, in phase"), stage=None, body=None, angle=0.0).even
    # evenly spaced, but the sun's teeth are out of step: such a train cannot be assembled
    assert not sensor_position(assemble(load("ren2021")), stage=None, body=None, angle=0.0).even


def test_the_stage_whose_ring_stands_is_taken() -> None:
    place = sensor_position(assemble(load("xu2020")), stage=None, body=None, angle=0.0)
    assert place.stage == "main"
    assert len(place.bodies) == 2  # both halves of the ring
    assert len(place.meshes) == 8


def test_a_differential_is_heard_on_the_housing() -> None:
    system = assemble(load("encased-differential"))
    place = sensor_position(system, stage="differential", body="housing", angle=0.0)
    assert (place.turn, len(place.meshes)) == (system.stage_turns["differential"], 6)
    with pytest.raises(ModelError, match="differential/ring turns"):
        sensor_position(system, stage="differential", body=None, angle=0.0)


def test_the_sun_mesh_is_heard_through_the_planet(system_of: Make) -> None:
    system = system_of("even, in phase")
    without, half, more = (
        every_line("even, in phase"),
        *(modulation(system, ModulationOptions(through_planet=share, floor=0.0)) for share in (0.5, 1.0)),
    )
    a, b, c = (
        dict(zip(r.exact_frequency.values, r.signal_amplitude.values, strict=True)) for r in (without, half, more)
    )
    largest = max(map(abs, c.values()))
    assert max(abs(2 * b[text] - a.get(text, 0) - c[text]) for text in set(b) & set(c)) < 1e-12 * largest
    assert max(abs(c[text] - a.get(text, 0)) for text in c) > 0.01 * largest


@pytest.mark.parametrize(
    ("options", "path"),
    [
        ({"stage": "nosuch"}, "stage"),
        ({"body": "main/planet/1"}, "body"),
        ({"body": "main/sun"}, "body"),
        ({"body": "gearbox"}, "body"),
        ({"sensor": float("nan")}, "sensor"),
        ({"direction": "up"}, "direction"),
        ({"window": "boxcar"}, "window"),
        ({"through_planet": -1.0}, "through_planet"),
        ({"radius": 0.0}, "radius"),
        ({"floor": 1.0}, "floor"),
        ({"floor": float("nan")}, "floor"),
        ({"turns": 0}, "turns"),
        ({"samples": 10}, "samples"),
        ({"turns": 10**6}, "samples"),
        ({"relative_speed": 0.0}, "relative_speed"),
    ],
)
def test_bad_input_is_named(system_of: Make, options: dict[str, Any], path: str) -> None:
    with pytest.raises(ModelError, match=rf"^{path}\b"):
        epicyclic.modulation(system_of("even, in phase"), **options)


def test_a_train_without_speeds_or_rings() -> None:
    with pytest.raises(ModelError, match=r"operation\.speed"):
        modulation(assemble(load("lin1999-n4")), ModulationOptions())
    pair = {
        "format": 2,
        "title": "no ring",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 1,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": 24, "bore": "20 mm"},
                "planet": {"teeth": 30, "bore": "60 mm"},
                "carrier": {"mass": "10 kg", "inertia": "0.1 kg m^2"},
            }
        },
        "operation": {"held": ["carrier"], "speed": {"sun": "1200 rpm"}},
    }
    with pytest.raises(ModelError, match="no ring"):
        modulation(assemble(load(pair)), ModulationOptions())
