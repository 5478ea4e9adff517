"""Frames whose speed changes: a free body moves straight on in space, whatever the frame does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.transient.equation import motion, phase_at, program
from epicyclic.questions.transient.integrators import at_equilibrium, integrate
from epicyclic.questions.transient.scenario import Scenario, scenario_motion
from epicyclic.system.assembly import (
    centrifugal_stiffness,
    euler_matrix,
    gyroscopic_matrix,
    mass_diagonal,
    spin_up_load,
)
from epicyclic.system.system import Dofs, LinkRows, MeshRows, System

Array = NDArray[np.float64]
MASS, AXIAL, DIAMETRAL = 3.0, 0.02, 0.013
FRAME, SPIN = 40.0, -75.0  # rad/s at s = 1
RAMP = program([0.0, 0.1, 0.3], [0.3, 1.2, 0.5])
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def free_body(frame: float = FRAME, spin: float = SPIN) -> System:
    body = [np.array([value]) for value in (MASS, AXIAL, DIAMETRAL, frame, spin)]
    none = np.zeros((6, 6))
    return System(
        dofs=Dofs(
            names=tuple(f"body/{d}" for d in DIRECTIONS), body=("body",) * 6, direction=DIRECTIONS,
            radius=np.ones(6), bodies=("body",), expand=np.eye(6),
        ),
        M=np.diag(mass_diagonal(*body[:3]).ravel()),
        C=none, K=none, Cskew=none,
        G=gyroscopic_matrix(*body),
        Kg=centrifugal_stiffness(*body),
        euler=euler_matrix(*body),
        spin_up=spin_up_load(body[0], body[1], body[3], body[4], np.zeros((1, 2))),
        meshes=MeshRows(
            name=(), pair=(), stage=(), branch=(), side=(), B=np.zeros((6, 0)), stiffness=np.zeros(0),
            variation=np.zeros((0, 1), complex), tone=np.zeros(0, np.int64), damping=np.zeros(0), backlash=np.zeros(0),
            cos_base_helix=np.zeros(0),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((6, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.zeros(6),
    )  # fmt: skip


def travel(system: System, state: Array, times: Array) -> Array:
    held = np.zeros(6)
    held[5] = -system.spin_up[5]  # what drives it gives the torque of its own inertia
    moving = motion(system, program=RAMP, spin=held)
    steps = 400 * (times.size - 1)
    return integrate(moving, state, start=times[0], stop=times[-1], steps=steps, keep=400)[0]


def test_a_free_body_moves_straight_on() -> None:
    times = np.linspace(0, 0.3, 16)
    turned = np.exp(-1j * FRAME * phase_at(RAMP, times))
    place, speed = 2e-3 - 1e-3j, 0.01 + 0.02j
    start = np.zeros((2, 6))
    first = speed - 1j * FRAME * 0.3 * place
    start[:, 0], start[:, 1] = (place.real, first.real), (place.imag, first.imag)
    found = travel(free_body(), start, times)
    known = (place + speed * times) * turned
    # 6000 steps over 10 rad of the frame: rounding and (10 / 6000)^4
    np.testing.assert_allclose(found[:, 0, 0] + 1j * found[:, 0, 1], known, rtol=1e-7)


def test_a_free_spinning_body_keeps_its_angular_momentum() -> None:
    """I_d Theta' - i I_p w Theta is constant in space while the torque along z only spins the body."""
    times = np.linspace(0, 0.3, 16)
    tilt, rate = 1e-3 + 2e-3j, 0.05 - 0.02j  # Theta = rx + i ry in space, and its rate
    phase = phase_at(RAMP, times)
    start = np.zeros((2, 6))
    first = rate - 1j * FRAME * 0.3 * tilt
    start[:, 3], start[:, 4] = (tilt.real, first.real), (tilt.imag, first.imag)
    found = travel(free_body(), start, times)
    theta = (found[:, 0, 3] + 1j * found[:, 0, 4]) * np.exp(1j * FRAME * phase)
    frame = FRAME * np.interp(times, RAMP.time, RAMP.speed)
    rates = (found[:, 1, 3] + 1j * found[:, 1, 4]) * np.exp(1j * FRAME * phase) + 1j * frame * theta
    spin = SPIN * np.interp(times, RAMP.time, RAMP.speed)
    momentum = DIAMETRAL * rates - 1j * AXIAL * spin * theta
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-7)
    assert np.abs(theta / theta[0] - 1).max() > 0.5  # it moves


def test_the_frame_of_a_spinning_body_does_not_matter() -> None:
    """Seen from two frames, of which one stands: the same motion in space."""
    times = np.linspace(0, 0.3, 16)
    tilt, rate = 1e-3 + 2e-3j, 0.05 - 0.02j
    found = []
    for frame in (0.0, FRAME):
        start = np.zeros((2, 6))
        first = rate - 1j * frame * 0.3 * tilt
        start[:, 3], start[:, 4] = (tilt.real, first.real), (tilt.imag, first.imag)
        states = travel(free_body(frame), start, times)
        found.append((states[:, 0, 3] + 1j * states[:, 0, 4]) * np.exp(1j * frame * phase_at(RAMP, times)))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-7)


def planar(**more: Any) -> System:
    """A planar set with soft bearings, nothing damped, no errors, constant meshes; the ring held."""
    links = {"support": {"radial": 2e8}}
    document = {
        "format": 2,
        "title": "a planar set",
        "stages": {
            "main": {
                "planets": 3,
                "module": 0.004,
                "sun": {"teeth": 24, "mass": 2.0, "inertia": 0.002, **links},
                "planet": {"teeth": 24, "mass": 1.5, "inertia": 0.003, "bearing": {"radial": 2e8}},
                "ring": {"teeth": 72, "mass": 5.0, "inertia": 0.5, **links},
                "carrier": {"mass": 6.0, "inertia": 0.05, **links},
                "meshes": {"sun-planet": {"stiffness": 3e8}, "planet-ring": {"stiffness": 4e8}},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": 200.0}, "torque": {"sun": 300.0}},
    } | more
    return epicyclic.assemble(epicyclic.load(document))


@pytest.mark.parametrize("carrier_torque", [False, True])
def test_a_planar_train_spun_up_carries_the_torque_of_its_inertia(carrier_torque: bool) -> None:
    """Mesh forces under acceleration less those at speed: closed form but for centrifugal motion."""
    system = planar()
    if carrier_torque:  # power the other way: the carrier drives
        system = planar(operation={"held": ["ring"], "speed": {"sun": 200.0}, "torque": {"sun": -300.0}})
    tone, duration, rise = float(system.tones[0]), 0.05, 4.0
    found = epicyclic.transient(system, mesh_frequency=(0.8 * tone, tone), duration=duration, decimate=8)
    steady = epicyclic.transient(system, mesh_frequency=0.8 * tone, cycles=1)
    radius = 0.048 * np.cos(np.radians(20))
    sun, carrier, planet = 200.0, 50.0, -100.0
    inertia = 0.05 + 3 * 1.5 * 0.096**2
    twice = 0.002 * sun**2 + inertia * carrier**2 + 3 * 0.003 * planet**2
    # the ring mesh carries what the sun mesh does, and the turning of the planet; where the carrier drives, the sun
    # has its own inertia left on the tooth, which its load of the other sign adds to
    if carrier_torque:
        first, second = 0.002 * sun * rise / (3 * radius), (0.002 * sun / 3 - 0.003 * planet) * rise / radius
    else:
        first = (twice / sun - 0.002 * sun) * rise / (3 * radius)
        second = first + 0.003 * planet * rise / radius
    for pair, extra in (("sun-planet", first), ("planet-ring", second)):
        name = f"main/{pair}/1"
        start = float(found.mesh_force.sel(mesh=name)[0] - steady.mesh_force.sel(mesh=name)[0])
        # planets press outward by 1e-6 m: their inertia about the axis is that of a radius 1e-5 larger
        assert start == pytest.approx(extra, rel=1e-3)
        drift = found.mesh_force.sel(mesh=name).values - float(found.mesh_force.sel(mesh=name)[0])
        assert np.abs(drift).max() < 0.1 * abs(extra)  # it stays: only s^2 changes the centrifugal load


def test_an_unbalance_lags_its_acceleration() -> None:
    """m e d2/dt2 exp(i theta) = m e (i w' - w^2) exp(i theta): the force of the line and its part per s'."""
    deviations = {"sun": {"unbalance": {"amount": 0.02, "phase": 0.3}}}
    system = planar(deviations=deviations)
    (line,) = (line for line in system.lines if line.causes == ("deviations.main.sun.unbalance",))
    x, y = (system.dofs.names.index(f"main/sun/{d}") for d in "xy")
    spin, relative = 200.0, 150.0  # rad/s, in space and in the frame of the carrier
    assert float(line.frequency) == pytest.approx(relative / (2 * np.pi), rel=1e-12)
    turned = np.exp(1j * relative * np.array([0.0, 0.01, 0.017]))
    force, ramp = ((part[x] * turned).real + 1j * (part[y] * turned).real for part in (line.force[2], line.ramp_force))
    np.testing.assert_allclose(force, 0.02 * spin**2 * turned * np.exp(0.3j), rtol=1e-12)
    np.testing.assert_allclose(ramp, -0.02j * spin * turned * np.exp(0.3j), rtol=1e-12)


def test_a_displaced_rigid_seat_is_the_limit_of_a_stiff_one() -> None:
    """Bearings that run out on a ramp: if rigid, inertia of the planets joins the right side, if stiff, it follows."""
    forces = []
    for radial in (float("inf"), 1e12):
        system = planar_with_bearing(radial)
        tone = float(system.tones[0])
        scenario = Scenario(duration=0.06, speed=(0.5, 1.0))
        start = at_equilibrium(scenario_motion(system, scenario, contact="linear", step=1e-5))
        for line in system.lines:  # planets on stiff bearings begin as they go on, with the rate of the run-out
            rate = -(2j * np.pi * float(line.frequency) * 0.5 * line.link_gap).real
            for name, value in zip(system.links.name, rate, strict=True):
                start[1, system.dofs.names.index(name.replace("/bearing", ""))] += value
        found = epicyclic.transient(
            system, mesh_frequency=(0.5 * tone, tone), duration=0.06, contact="linear", initial=start, decimate=8
        )
        forces.append(found.mesh_force.values[:, 276:])  # dampers of the meshes have settled the start
    moved = np.ptp(forces[0], axis=1).max()
    assert moved > 5.0
    # the bearings give by 4e7 / 1e12 of what the teeth do, and go on ringing from the start, undamped
    assert np.abs(forces[1] - forces[0]).max() < 2e-3 * moved


def planar_with_bearing(radial: float) -> System:
    document = {
        "format": 2,
        "title": "a set whose planet bearings run out",
        "stages": {
            "main": {
                "planets": 3,
                "module": 0.004,
                "sun": {"teeth": 24, "mass": 2.0, "inertia": 0.002},
                "planet": {"teeth": 24, "mass": 40.0, "inertia": 0.003, "bearing": {"radial": radial}},
                "ring": {"teeth": 72, "mass": 5.0, "inertia": 0.5},
                "carrier": {"mass": 6.0, "inertia": 0.05},
                "meshes": {
                    "sun-planet": {"stiffness": 3e7, "damping": 2e4},
                    "planet-ring": {"stiffness": 4e7, "damping": 2e4},
                },
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": 600.0}, "torque": {"sun": 300.0}},
        "deviations": {"planet": {"bearing_run_out": {"amplitude": 2e-5, "phase": 0.4}}},
    }
    return epicyclic.assemble(epicyclic.load(document))
