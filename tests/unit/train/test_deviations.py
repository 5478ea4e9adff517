"""Deviations: vectors in own axes, exact signed frequencies, what each enters."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from epicyclic.document.document import read
from epicyclic.train.deviations import misaligned_bodies
from epicyclic.train.resolution import load
from epicyclic.train.train import Displacement

MODELS = Path(__file__).parent / "models"
CARRIER = Fraction(115, 4) / 60  # turns per second of ren2021's carrier, 28.75 rpm


def place(item: Displacement, time: float) -> complex:
    """x + i y of a displacement at a time."""
    vector = (item.vector * np.exp(2j * math.pi * float(item.frequency) * time)).real
    return complex(vector[0], vector[1])


def test_run_out_turns_with_the_member_in_its_frame() -> None:
    train = load("ren2021")
    frequency = {item.body: item.frequency for item in train.displacements if item.cause == "run_out"}
    assert frequency["main/sun"] == Fraction(100, 60) - CARRIER
    assert frequency["main/planet/2"] == Fraction(-1150, 17) / 60 - CARRIER  # w_p = -67.6 rpm
    assert frequency["main/ring/left"] == -CARRIER
    assert frequency["main/carrier"] == 0


def test_amplitude_and_phase_are_a_vector_in_own_axes() -> None:
    train = load("ren2021", {"deviations.planet.run_out": {"amplitude": "20 um", "phase": "30 deg"}})
    item = next(d for d in train.displacements if d.body == "main/planet/2")
    assert place(item, 0.0) == pytest.approx(20e-6 * cmath.exp(1j * math.radians(30)), rel=1e-14)
    quarter = 0.25 / float(item.frequency)  # negative frequency: a negative time turns it by +90 deg
    assert place(item, quarter) == pytest.approx(20e-6 * cmath.exp(1j * math.radians(120)), rel=1e-12)


def test_phase_from_the_stage_is_turned_into_own_axes() -> None:
    deviation = {"amplitude": "20 um", "phase": "30 deg", "from": "stage"}
    train = load("ren2021", {"deviations.planet.run_out": deviation})
    item = next(d for d in train.displacements if d.body == "main/planet/2")
    assert place(item, 0.0) == pytest.approx(20e-6 * cmath.exp(1j * math.radians(30 - 120)), rel=1e-14)


def test_run_out_enters_meshes_and_of_a_carrier_its_pins() -> None:
    train = load("ren2021")
    rows = {item.body: (item.rows, item.links) for item in train.displacements}
    assert rows["main/sun"] == ("mesh", ())
    assert rows["main/carrier"] == ("own", tuple(f"main/planet/{i}/bearing" for i in (1, 2, 3)))


def test_pin_position_stands_in_the_carrier_and_a_seat_in_the_housing() -> None:
    overrides = {"deviations.planet.position": {"x": "[1, 2, 3] um", "y": "5 um"}, "deviations.sun.position": "7 um"}
    train = load("ren2021", overrides)
    found = {item.body: item for item in train.displacements if item.cause == "position"}
    assert found["main/planet/2"].frequency == 0
    assert found["main/planet/2"].rows == "seat"
    assert found["main/planet/2"].links == ("main/planet/2/bearing",)
    assert place(found["main/planet/2"], 1.0) == 2e-6 + 5e-6j
    assert found["main/sun"].frequency == -CARRIER  # the housing turns backwards in the carrier's frame
    assert place(found["main/sun"], 1.0) == pytest.approx(
        7e-6 * cmath.exp(-2j * math.pi * float(CARRIER)), rel=1e-12
    )  # rounding of one exponential


def test_axial_part_stands_still_where_the_rest_turns() -> None:
    train = load("ren2021", {"deviations.sun.position": {"x": "1 um", "z": "2 um"}})
    parts = [(item.frequency, item.vector[2]) for item in train.displacements if item.cause == "position"]
    assert parts == [(-CARRIER, 0), (0, 2e-6)]


def test_tilt_uses_the_last_three_columns() -> None:
    train = load("ren2021", {"deviations.planet.tilt": {"x": "1e-3 rad", "y": "2e-3 rad"}})
    item = next(d for d in train.displacements if d.cause == "tilt")
    assert item.vector.tolist() == [0, 0, 0, 1e-3, 2e-3, 0]
    assert item.rows == "seat"


def test_a_side_of_its_own() -> None:
    train = load("ren2021", {"deviations.ring.left.run_out": "5 um"})
    size = {item.body: abs(item.vector[0]) for item in train.displacements if "ring" in item.body}
    assert size == {"main/ring/left": 5e-6, "main/ring/right": pytest.approx(20e-6)}


def test_a_tilt_of_one_side_leaves_the_other_straight() -> None:
    bodies = load("ren2021").bodies
    for path, askew in (("ring.left", {"main/ring/left"}), ("ring", {"main/ring/left", "main/ring/right"})):
        model = read("ren2021", {f"deviations.{path}.tilt": {"x": "1e-3 rad"}}).model
        assert misaligned_bodies(model, bodies) == askew


def test_bearing_run_out_turns_with_the_shaft_in_its_bearing() -> None:
    train = load(MODELS / "dong.toml")
    items = [item for item in train.displacements if item.cause == "bearing_run_out"]
    assert len(items) == 5
    assert items[0].links == ("main/star1/1/bearing",)
    assert items[0].frequency == Fraction(-6800 * 24, 22) / 60
    assert [abs(d.vector[0]) for d in train.displacements if d.cause == "run_out"] == pytest.approx(
        [6e-6, 6e-6, 6e-6, 25e-6, 6e-6]
    )


def test_seat_of_a_stepped_gear_turns_with_the_shaft_that_carries_it() -> None:
    deviations = {"deviations.star2.position": "3 um", "deviations.star1.position": "4 um"}
    items = [d for d in load(MODELS / "dong.toml", deviations).displacements if d.cause == "position"]
    found = {item.body: (item.links, item.frequency) for item in items}
    turns = Fraction(-6800 * 24, 22) / 60
    assert found["main/star2/3"] == (("main/star2/3/shaft",), turns)
    assert found["main/star1/3"] == (("main/star1/3/bearing",), Fraction(0))
    held = deviations | {"stages.main.star2.bearing.radial": "1e9 N/m"}
    items = [d for d in load(MODELS / "dong.toml", held).displacements if d.body == "main/star2/3"]
    assert [(d.links, d.frequency) for d in items] == [(("main/star2/3/bearing",), Fraction(0))]


def test_profile_follows_the_mesh_phase() -> None:
    train = load("ren2021", {"deviations.meshes.sun-planet.profile": {"amplitude": "8 um", "order": 2}})
    errors = {e.mesh: e for e in train.mesh_errors}
    second = errors["main/sun-planet/2/left"]
    assert second.frequency == 2 * Fraction(437, 16)
    assert second.amplitude == pytest.approx(8e-6 * cmath.exp(2j * math.pi * 2 / 3), rel=1e-14)


def test_random_phases_are_drawn_per_planet_and_repeat() -> None:
    train, again = load(MODELS / "encased.toml"), load(MODELS / "encased.toml")
    drawn = {e.mesh: e.amplitude for e in train.mesh_errors if "planet-ring" in e.mesh}
    assert drawn == {e.mesh: e.amplitude for e in again.mesh_errors if "planet-ring" in e.mesh}
    assert drawn["differential/planet-ring/1/left"] == drawn["differential/planet-ring/1/right"]
    assert len(set(drawn.values())) == 3
    assert all(abs(value) == pytest.approx(8e-6) for value in drawn.values())


def test_gap_is_constant_and_only_where_it_is() -> None:
    train = load(MODELS / "dong.toml")
    gaps = [(e.mesh, e.amplitude, e.frequency) for e in train.mesh_errors if e.cause == "gap"]
    assert gaps == [("main/sun-star1/4", complex(2e-6), Fraction(0))]


def test_pitch_deviations_meet_each_mesh_in_turn() -> None:
    deviations = [0.0] * 23
    deviations[5] = 30e-6
    train = load("ren2021", {"deviations.sun.pitch": deviations})
    lines = [e for e in train.mesh_errors if e.mesh == "main/sun-planet/2/left" and e.cause == "pitch"]

    def error(time: float) -> float:
        return sum((e.amplitude * cmath.exp(2j * math.pi * float(e.frequency) * time)).real for e in lines)

    # Tooth 6 stands at 5/23 turns; planet 2 at 1/3; the sun turns at 71.25 rpm in the carrier's frame.
    passes = (1 / 3 - 5 / 23) / float(Fraction(100, 60) - CARRIER)
    # the series stops below the mesh frequency: a hat of 30 um over +-1 tooth keeps most of its peak
    assert error(passes) == pytest.approx(30e-6, rel=0.15)
    turn = 1 / float(Fraction(100, 60) - CARRIER)
    assert abs(error(passes + turn / 2)) < 2e-6


def test_unbalance_turns_with_the_body_at_its_absolute_speed() -> None:
    train = load("ren2021", {"deviations.sun.unbalance": {"amount": "2 kg m", "phase": "90 deg"}})
    load_ = next(item for item in train.loads if item.speed_squared)
    assert load_.force == pytest.approx((2 * (100 * math.pi / 30) ** 2, 0.0, 0.0), rel=1e-14)
    assert (load_.turns, load_.body) == (True, "main/sun")
    assert load_.phase == pytest.approx(math.pi / 2)


def test_loads_are_halved_on_a_split_member() -> None:
    force = {"on": "main.ring", "force": {"x": "10 kN"}, "moment": {"z": "1 kN m"}}
    train = load("ren2021", {"loads": {"push": force}})
    assert [(item.body, item.force[0], item.moment[2]) for item in train.loads] == [
        ("main/ring/left", 5e3, 500.0),
        ("main/ring/right", 5e3, 500.0),
    ]
    one = load("ren2021", {"loads": {"push": {**force, "on": "main.ring.left", "at": "0.1 m"}}})
    assert [(item.force[0], round(item.station, 15)) for item in one.loads] == [(1e4, 0.1)]  # a sum of stations


@pytest.mark.parametrize(
    ("overrides", "warned"),
    [
        ({"deviations.sun.position.z": "1 mm"}, "position has no effect: no support or bearing holds main.sun in z"),
        ({"deviations.sun.position.z": "1 mm", "stages.main.sun.left.support.z": 1e6}, ""),
        ({"deviations.sun.right.position.z": "1 mm", "stages.main.sun.left.support.z": 1e6}, "right.position has no"),
        ({"deviations.sun.position.z": "1 mm", "stages.main.sun.support.z": "inf"}, ""),
        ({"deviations.sun.position": "1 mm", "stages.main.sun.support.radial": 0}, "holds main.sun in x and y"),
        ({"deviations.sun.run_out": "1 mm", "stages.main.sun.support.radial": 0}, ""),
    ],
)
def test_a_displaced_seat_that_nothing_sits_in_is_warned_of(overrides: dict[str, object], warned: str) -> None:
    """A half counts as held where the other half is, unless its own seat is meant."""
    warnings = load("xu2020", overrides).warnings
    assert len(warnings) == (1 if warned else 0)
    assert warned in " ".join(warnings)
