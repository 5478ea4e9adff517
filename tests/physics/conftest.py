"""A planetary set written by hand as a Train, so that rows and matrices are tested without the file layer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import pytest

from epicyclic.train.kinematics import Kinematics
from epicyclic.train.train import Body, Frame, Link, Mesh, Train

INF = float("inf")


@dataclass(frozen=True, kw_only=True)
class Set:
    """What a hand-written planetary set is made of; SI."""

    angles: tuple[float, ...] = (0.0, 2 * math.pi / 3, 4 * math.pi / 3)
    flank: int = 1
    hand: int = 1
    helix: float = 0.3  # base helix
    alpha_sun: float = 0.38
    pin_radius: float = 0.12
    base_sun: float = 0.05
    base_planet: float = 0.06
    stations: tuple[float, ...] = (0.02,)
    frame_speed: Fraction = Fraction(0)  # rev/min of the carrier
    sun_speed: Fraction = Fraction(0)
    planet_speed: Fraction = Fraction(0)
    torque: float = 100.0
    support: tuple[float, ...] = (1e8, 1e8, 2e8, 1e6, 1e6, 0.0)
    ring_support: tuple[float, ...] = (1e9, 1e9, 1e9, 1e7, 1e7, 1e7)
    pin: tuple[float, ...] = (1e8, 1e8, 3e8, 2e6, 2e6, 0.0)
    stiffness_sun: float = 4e8
    stiffness_ring: float = 5e8
    carrier_inertia: float = 0.5
    sun_inertia: float = 0.01
    planet_mass: float = 2.0
    pin_station: float = 0.0


def build(data: Set) -> Train:
    """A sun, a ring, a carrier and one planet per angle; every mesh with its own consistent working angle."""
    a = data.pin_radius
    alpha_s = math.acos((data.base_sun + data.base_planet) / a)
    base_ring = data.base_planet + a * math.cos(data.alpha_sun)
    alpha_r = data.alpha_sun
    names = [f"main/planet/{i + 1}" for i in range(len(data.angles))]
    mass: dict[str, Any] = {"mass": 2.0, "inertia": 0.01, "tilt_inertia": 0.006}
    sun_mass = {**mass, "inertia": data.sun_inertia}
    planet_mass = {**mass, "mass": data.planet_mass}
    bodies = [
        Body(name="main/sun", member="main.sun", kind="sun", frame="main", reference_radius=data.base_sun, **sun_mass),
        Body(name="main/ring", member="main.ring", kind="ring", frame="main", reference_radius=base_ring, **mass),
        Body(
            name="main/carrier", member="main.carrier", kind="carrier", frame="main", reference_radius=a,
            mass=5.0, inertia=data.carrier_inertia, tilt_inertia=0.3,
        ),
    ]  # fmt: skip
    links = [
        Link(
            name="main/sun/support", path="sun", kind="support", first="main/sun", second=None,
            stiffness=data.support,
        ),
        Link(
            name="main/ring/support", path="ring", kind="support", first="main/ring", second=None,
            stiffness=data.ring_support,
        ),
        Link(
            name="main/carrier/support", path="carrier", kind="support", first="main/carrier", second=None,
            stiffness=data.support,
        ),
    ]  # fmt: skip
    meshes = []
    for i, (name, psi) in enumerate(zip(names, data.angles, strict=True)):
        centre = (a * math.cos(psi), a * math.sin(psi))
        bodies.append(
            Body(
                name=name, member="main.planet", kind="planet", frame="main", carried_by="main/carrier", branch=i + 1,
                centre=centre, angle=psi, reference_radius=data.base_planet, **planet_mass,
            )
        )  # fmt: skip
        links.append(
            Link(
                name=f"{name}/bearing", path="planet", kind="bearing", first="main/carrier", second=name,
                centre=centre, angle=psi, station=data.pin_station, stiffness=data.pin,
            )
        )  # fmt: skip
        for zeta in data.stations:
            common: dict[str, Any] = {"stage": "main", "branch": i + 1, "side": None, "direction": psi, "station": zeta}
            hand = data.hand if zeta >= 0 else -data.hand
            meshes.append(
                Mesh(
                    name=f"main/sun-planet/{i + 1}/{zeta}", pair="sp", a="main/sun", b=name, internal=False,
                    pressure_angle=alpha_s, base_helix=data.helix, hand=hand, flank=data.flank,
                    radius_a=data.base_sun / math.cos(alpha_s), radius_b=data.base_planet / math.cos(alpha_s),
                    stiffness=data.stiffness_sun, **common,
                )
            )  # fmt: skip
            meshes.append(
                Mesh(
                    name=f"main/planet-ring/{i + 1}/{zeta}", pair="pr", a=name, b="main/ring", internal=True,
                    pressure_angle=alpha_r, base_helix=data.helix, hand=-hand, flank=-data.flank,
                    radius_a=data.base_planet / math.cos(alpha_r), radius_b=base_ring / math.cos(alpha_r),
                    stiffness=data.stiffness_ring, **common,
                )
            )  # fmt: skip
    speeds = {
        "main.sun": data.sun_speed,
        "main.planet": data.planet_speed,
        "main.carrier": data.frame_speed,
        "main.ring": Fraction(0),
    }
    carrier_torque = -data.flank * data.torque * (1 + base_ring / data.base_sun)
    return Train(
        title="test",
        frames=(Frame(name="main", carrier="main.carrier"),),
        bodies=tuple(bodies),
        meshes=tuple(meshes),
        links=tuple(links),
        kinematics=Kinematics(
            freedoms=("main.sun",),
            ratio={},
            speed=speeds,
            frame_speed={"main": data.frame_speed},
            mesh_frequency={"main": Fraction(100)},
        ),
        planets={"main": len(data.angles)},
        torques={"main/sun": data.flank * data.torque, "main/carrier": carrier_torque},
    )


@pytest.fixture(scope="session")
def hand_built() -> Callable[..., Train]:
    """Factory: hand_built(angles=..., flank=...) -> Train."""

    def make(**changes: object) -> Train:
        return build(Set(**changes))  # type: ignore[arg-type]

    return make
