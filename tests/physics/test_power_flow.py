"""Power flow of whole trains against forces and velocities at points of contact, and against textbook splits."""

from __future__ import annotations

import cmath
import math
from typing import Any

import pytest

import epicyclic
from epicyclic.train.train import Train

ROUNDED = 1e-10  # relative to the input power: sums of a few numbers from trigonometry
GEARS = {
    "sun": {"teeth": 24},
    "planet": {"teeth": 30, "bore": "60 mm"},
    "ring": {"teeth": 84, "rim": "25 mm"},
    "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
}
STAGE = {"planets": 3, "module": "4 mm", "face_width": "50 mm", "helix_angle": "12 deg"}
STEPPED = {
    "sun": {"teeth": 24},
    "first": {"kind": "planet", "teeth": 40, "bore": "40 mm"},
    "second": {"kind": "planet", "teeth": 24, "on": "first", "clocking": "fit", "station": "60 mm", "bore": "40 mm"},
    "third": {"kind": "planet", "teeth": 20, "on": "second", "clocking": "fit", "station": "120 mm", "bore": "40 mm"},
    "ring": {"teeth": 88, "rim": "25 mm", "station": "60 mm"},
    "far": {"kind": "ring", "teeth": 84, "rim": "25 mm", "station": "120 mm"},
    "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
    "meshes": {"sun-first": {}, "second-ring": {}, "third-far": {}},
}
MESHED = {
    "sun": {"teeth": 24},
    "p": {"kind": "planet", "teeth": 20, "bore": "20 mm"},
    "d": {"kind": "planet", "teeth": 18, "bore": "20 mm"},
    "ring": {"teeth": 84, "rim": "30 mm"},
    "carrier": {"mass": "10 kg", "inertia": "0.3 kg m^2"},
    "meshes": {"sun-p": {}, "p-d": {}, "d-ring": {}},
}


def train_of(stage: dict[str, Any], **operation: Any) -> Train:
    return epicyclic.load({"format": 2, "title": "t", "stages": {"main": {**STAGE, **stage}}, "operation": operation})


SUN = {"speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}}
TRAINS = {
    "planetary": lambda: train_of(GEARS, held=["ring"], **SUN),
    "star": lambda: train_of(GEARS, held=["carrier"], **SUN),
    "two inputs": lambda: train_of(GEARS, speed={"sun": "1500 rpm", "carrier": "-200 rpm"}, torque={"sun": "800 N m"}),
    "stepped": lambda: train_of(
        STEPPED,
        held=["ring"],
        speed={"sun": "900 rpm"},
        torque={"sun": "300 N m", "carrier": "-100 N m", "far": "balance"},
    ),
    "meshed": lambda: train_of(MESHED, held=["ring"], **SUN),
    "meshed, carrier held": lambda: train_of(MESHED, held=["carrier"], **SUN),
    "encased": lambda: epicyclic.load("encased-differential"),
    "stepped stars": lambda: epicyclic.load("dong2019"),
}


def at_contacts(train: Train, along: float) -> dict[str, tuple[float, float]]:
    """Power of every pair at points a part of the radius `along` the line of action, as gear a and gear b see it [W].

    The tooth force has the torque of the pair about the axis of b.  Both gears move as rigid bodies; they slide on each
    other across the normal alone, so that their velocities along the force agree.
    """
    kinematics = train.kinematics
    speed, torque = kinematics.speed, kinematics.mesh_torque
    assert speed is not None
    assert torque is not None
    bodies, frames = {body.name: body for body in train.bodies}, {frame.name: frame for frame in train.frames}
    found: dict[str, tuple[float, float]] = {}
    for mesh in train.meshes:
        e = cmath.exp(1j * mesh.direction)
        normal = (math.sin(mesh.pressure_angle) + 1j * mesh.flank * math.cos(mesh.pressure_angle)) * e
        at = complex(*bodies[mesh.a].centre) + mesh.radius_a * (e + along * normal)
        arm = ((at - complex(*bodies[mesh.b].centre)).conjugate() * normal).imag
        force = torque[mesh.pair] / arm * normal
        carrier = frames[mesh.stage.split("/")[0]].carrier
        turning = 0.0 if carrier is None else float(speed[carrier]) * math.tau / 60
        both = []
        for body in (bodies[mesh.a], bodies[mesh.b]):
            centre, own = complex(*body.centre), float(speed[body.member]) * math.tau / 60
            velocity = 1j * turning * centre + 1j * own * (at - centre)
            both.append((velocity.conjugate() * force).real)
        found.setdefault(mesh.pair, (both[0], both[1]))
    return found


def watts_in(train: Train) -> float:
    assert train.kinematics.power is not None
    return sum(value for value in train.kinematics.power.values() if value > 0)


# the printed places of the stepped stars do not fit their working radii: no one point of contact
@pytest.mark.parametrize("name", sorted(TRAINS.keys() - {"stepped stars"}))
def test_power_of_a_mesh_is_that_of_its_force_at_any_point_of_contact(name: str) -> None:
    train = TRAINS[name]()
    paths = {path.path: path for path in train.power_paths}
    for along in (0.0, 0.2):
        for pair, both in at_contacts(train, along).items():
            assert both == pytest.approx([paths[pair].power] * 2, abs=ROUNDED * watts_in(train))


@pytest.mark.parametrize("name", TRAINS)
def test_every_member_passes_on_what_it_takes(name: str) -> None:
    train = TRAINS[name]()
    assert train.kinematics.power is not None
    rest = dict(train.kinematics.power)
    for path in train.power_paths:
        rest[path.second] += path.power
        rest[path.first] -= path.power
    assert rest == pytest.approx(dict.fromkeys(rest, 0.0), abs=ROUNDED * watts_in(train))


@pytest.mark.parametrize("name", TRAINS)
def test_nothing_circulates_in_trains_without_a_closed_way(name: str) -> None:
    train = TRAINS[name]()
    assert not any(path.circulating for path in train.power_paths)
    assert not any("circulates" in text for text in epicyclic.check(train).attrs["warnings"])


def shares(name: str) -> dict[str, float]:
    train = TRAINS[name]()
    return {path.path.removeprefix("stages.main."): path.power / watts_in(train) for path in train.power_paths}


def test_splits_by_hand() -> None:
    held = shares("planetary")
    assert held == pytest.approx(
        {"meshes.sun-planet": 1.0, "meshes.planet-ring": 0.0, "planet.bearing": 1.0}, abs=ROUNDED
    )
    star = shares("star")
    assert star == pytest.approx(
        {"meshes.sun-planet": 1.0, "meshes.planet-ring": 1.0, "planet.bearing": 0.0}, abs=ROUNDED
    )
    # torques 24 : 84 : -108 of sun, ring and carrier; the ring turns at (-108 * 200 - 24 * 1500) / 84 rpm
    sun, carrier = 24 * 1500, 108 * 200
    assert shares("two inputs") == pytest.approx(
        {
            "meshes.sun-planet": sun / (sun + carrier),
            "meshes.planet-ring": 1.0,
            "planet.bearing": -carrier / (sun + carrier),
        },
        abs=ROUNDED,
    )
    # the shaft brings to the free ring what leaves there; the held ring takes nothing
    stepped = shares("stepped")
    assert stepped["meshes.second-ring"] == pytest.approx(0, abs=ROUNDED)
    assert stepped["meshes.sun-first"] == pytest.approx(1, abs=ROUNDED)


def test_rolling_power_is_that_of_the_star_drive_with_the_same_torque() -> None:
    """By Willis: in the frame of the carrier the sun turns at w_s - w_c, and both meshes carry the same power."""
    train = TRAINS["planetary"]()
    rolling = [path.rolling for path in train.power_paths if "meshes" in path.path]
    relative = 1500 * (1 - 24 / 108) * math.tau / 60
    assert rolling == pytest.approx([800 * relative] * 2, rel=1e-12)  # rounding
