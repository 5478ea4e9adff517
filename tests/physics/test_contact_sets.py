"""Bearings of contacts over five rows: radial laws as their special case, routes to one answer, a rotor by hand.

Contacts are written out here from their geometry; references are formulas of this file, `scipy` and other routes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

import epicyclic
from epicyclic.questions.contact_loss.branch_set import mesh_force
from epicyclic.questions.contact_loss.continuation import solve
from epicyclic.questions.contact_loss.problem import flank_force, gap_forces, prolonged
from epicyclic.questions.contact_loss.solutions import (
    Refinement,
    Solution,
    floquet_multipliers,
    load_continuation,
    solution,
    with_stability,
)
from epicyclic.questions.contact_loss.sweep_direction import initial_state
from epicyclic.questions.response.response import response
from epicyclic.questions.transient.equation import constant, motion
from epicyclic.questions.transient.integrators import integrate, steps_for
from epicyclic.questions.transient.transient import flank_force as record_force
from epicyclic.statics.tangent import linear
from epicyclic.system.system import System
from epicyclic.train.train import Body, ContactSet, Frame, Link, Train

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def geometry(count: int, angle: float, radius: float, offset: float, sides: tuple[int, ...]) -> Array:
    """Normals (E, 5) of rows of contacts at a radius and `offset` from the middle of the bearing [m], side by side.

    Each row pushes outwards at the contact angle [rad], towards its side.
    """
    phi, rows = 2 * np.pi * np.arange(count) / count, []
    for side in sides:
        radial, axial, z = np.cos(angle), side * np.sin(angle), -side * offset
        lever = radius * axial - z * radial  # of the normal about the middle
        columns = radial * np.cos(phi), radial * np.sin(phi), axial + 0 * phi, lever * np.sin(phi), -lever * np.cos(phi)
        rows.append(np.stack(columns, axis=1))
    return np.concatenate(rows)


def contact_set(normals: Array, *, gap: float, coefficient: float, exponent: float, load: float = 3e4) -> ContactSet:
    return ContactSet(
        normals=tuple(map(tuple, normals.tolist())),
        gap=(gap,) * len(normals),
        coefficient=(coefficient,) * len(normals),
        exponent=exponent,
        load=load,
    )


def on_bearings(train: Train, **values: Any) -> System:
    """The train with values of all planet bearings, mesh orders alone."""
    links = tuple(replace(link, **values) if link.kind == "bearing" else link for link in train.links)
    system = epicyclic.assemble(replace(train, links=links))
    whole = {order * system.tones[0] for order in range(64)}
    return replace(system, lines=tuple(line for line in system.lines if line.frequency in whole))


# --- radial contacts --------------------------------------------------------------------------------------------------

ROLLER, ROLLERS, STIFFNESS = 10 / 9, 240, 1.2e7
RIGID = (np.inf, np.inf, np.inf, 0.0)


@lru_cache(maxsize=4)
def radial(kind: str) -> System:
    """ren2021 on rollers, rigid in z and tilt: radial contacts, inclined ones, or the radial law of their integral."""
    train = epicyclic.load("ren2021")
    if kind == "law":
        mean = np.mean(np.cos((np.arange(100_000) + 0.5) / 100_000 * np.pi - np.pi / 2) ** (ROLLER + 1))
        C, load = STIFFNESS * ROLLERS / 2 * mean, 1e4
        k = ROLLER * C ** (1 / ROLLER) * load ** ((ROLLER - 1) / ROLLER)
        return on_bearings(train, stiffness=(k, k, *RIGID), exponent=ROLLER, load=load)
    angle = 0.0 if kind == "radial" else 0.4
    normals = geometry(ROLLERS, angle, 0.03, 0.0, (1,))
    if kind == "radial":
        normals[:, 2:] = 0.0
    c = STIFFNESS / np.cos(angle) ** (ROLLER + 1)
    contacts = contact_set(normals, gap=0.0, coefficient=c, exponent=ROLLER)
    return on_bearings(train, stiffness=(1e9, 1e9, *RIGID), contacts=contacts)


def balance(system: System, speed: float) -> Solution:
    refinement = Refinement(ready=response(system))
    start = load_continuation(refinement, speed, harmonics=16)
    assert start.converged
    at = solution(refinement, start.state.y, speed, balance=refinement.problem(16), harmonics=16)
    assert at is not None
    return with_stability(refinement, at)


def steady_force(system: System, at: Solution) -> Array:
    """Mesh forces of the balance, (N, w) [N]."""
    return np.asarray(mesh_force(system, flank_force(at.balance, at.state)))


def integrated_force(system: System, at: Solution, speed: float, *, cycles: int = 3) -> Array:
    """Mesh forces (64, w) [N] of Runge-Kutta steps over the last of a few cycles from the state of the balance."""
    moving, period = motion(system, program=constant(speed)), 1 / (speed * float(system.tones[0]))
    assert moving.compiled
    steps = -(-steps_for(moving, period) // 64) * 64
    states = integrate(moving, initial_state(at), stop=cycles * period, steps=cycles * steps, keep=steps // 64)[0]
    times = period * np.arange(len(states)) / 64
    return np.asarray(mesh_force(system, record_force(moving, times[-64:], states[-64:]).T))


@pytest.mark.parametrize("kind", ["radial", "inclined"])
def test_radial_contacts_are_the_radial_law(kind: str) -> None:
    """Forces at rest, of the balance and in time to 1e-4 of those of the law; its tangents are 10 times off."""
    system, law = radial(kind), radial("law")
    assert {group.law.kind for group in system.groups} == {"contact set"}
    assert {len(group.rows) for group in system.groups} == {2}
    static, of_law = (epicyclic.static(one, cycles=1, samples=32) for one in (system, law))
    np.testing.assert_allclose(static.mesh_force, of_law.mesh_force, atol=1e-4 * float(of_law.mesh_force.max()))
    np.testing.assert_allclose(static.group_force, of_law.group_force, rtol=1e-4)
    np.testing.assert_allclose(static.group_stretch, of_law.group_stretch, rtol=1e-4)
    speed = 200.0 / float(system.tones[0])
    at, other = balance(system, speed), balance(law, speed)
    rms = steady_force(law, other).std(axis=0)
    np.testing.assert_allclose(steady_force(system, at).std(axis=0), rms, rtol=1e-4)
    tangents = linear(law)
    assert np.abs(steady_force(tangents, balance(tangents, speed)).std(axis=0) / rms - 1).max() > 1e-3
    assert at.stability is not None
    assert other.stability is not None
    np.testing.assert_allclose(abs(at.stability.multiplier), abs(other.stability.multiplier), rtol=1e-4)
    run = integrated_force(system, at, speed)
    np.testing.assert_allclose(run, integrated_force(law, at, speed), atol=1e-4 * float(run.max()))


# --- a helical set ----------------------------------------------------------------------------------------------------

HELICAL = {
    "format": 2,
    "title": "a helical set",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "helix_angle": "15 deg",
            "face_width": "40 mm",
            "sun": {
                "teeth": 23,
                "mass": 3.0,
                "inertia": 4e-3,
                "tilt_inertia": 3e-3,
                "support": {"radial": 2e7, "z": 1e8, "tilt": 1e5},
            },
            "planet": {
                "teeth": 25,
                "mass": 3.0,
                "inertia": 4e-3,
                "tilt_inertia": 3e-3,
                "bearing": {"radial": 2e8, "z": 1e8, "tilt": 1e5},
            },
            "ring": {"teeth": 73, "mass": 10.0, "inertia": 0.2, "support": {"radial": 1e9}},
            "carrier": {
                "mass": 20.0,
                "inertia": 0.2,
                "tilt_inertia": 0.1,
                "support": {"radial": 1e9, "z": 1e9, "tilt": 1e7},
            },
            "meshes": {
                "sun-planet": {"stiffness": 9e8, "variation": {"cosine": [0.3], "sine": [0.1]}, "slices": 1},
                "planet-ring": {"stiffness": 9e8, "variation": {"cosine": [0.3], "sine": [0.1]}, "slices": 1},
            },
        }
    },
    "deviations": {
        "planet.position.y": "[40, 0, 0] um",
        "meshes.sun-planet.profile": "20 um",
        "meshes.planet-ring.profile": "20 um",
    },
    "operation": {"held": ["ring"], "speed": {"sun": "600 rpm"}, "torque": {"sun": "300 N m"}},
}
BALLS = {"gap": 20e-6, "coefficient": 2e8, "exponent": 1.5}


@lru_cache(maxsize=1)
def helical() -> System:
    """Planets on two rows of balls of 30 deg face to face: they carry the couple of the helix and their mesh forces."""
    normals = geometry(48, np.radians(30), 0.03, 0.015, (1, -1))
    return on_bearings(epicyclic.load(HELICAL), contacts=contact_set(normals, **BALLS))


def test_static_is_the_least_energy() -> None:
    """At the start of the record; the energy of meshes, links and contacts is written out here."""
    system = helical()
    normals = geometry(48, np.radians(30), 0.03, 0.015, (1, -1))
    approach = np.concatenate([normals @ group.B.T for group in system.groups])
    contact = np.concatenate([normals @ group_gap for group_gap in np.split(_standing_gap(system), 3)]) + BALLS["gap"]
    meshes = system.meshes
    gap = sum((line.gap.real for line in system.lines), np.zeros(meshes.stiffness.size))
    stiffness = meshes.stiffness * (1 + meshes.variation.sum(axis=1).real)
    load = system.force + sum(line.force[0].real for line in system.lines)
    scale = 1 / np.sqrt(np.diag(system.mean_stiffness + 1e-3 * np.eye(len(load))))
    p, c = BALLS["exponent"], BALLS["coefficient"]

    def energy(x: Array) -> tuple[float, Array]:
        q = scale * x
        teeth, balls = np.maximum(meshes.B.T @ q - gap, 0), np.maximum(approach @ q - contact, 0)
        value = q @ system.K @ q / 2 + stiffness @ teeth**2 / 2 + c * np.sum(balls ** (p + 1)) / (p + 1) - load @ q
        slope = system.K @ q + meshes.B @ (stiffness * teeth) + c * balls**p @ approach - load
        return float(value), scale * slope

    def curvature(x: Array) -> Array:
        q = scale * x
        closed, balls = meshes.B.T @ q > gap, np.maximum(approach @ q - contact, 0)
        H = (
            system.K
            + (meshes.B * (stiffness * closed)) @ meshes.B.T
            + (approach.T * (p * c * balls ** (p - 1))) @ approach
        )
        return np.asarray(scale[:, None] * H * scale)

    found = minimize(
        energy, np.zeros(len(load)), jac=True, hess=curvature, method="trust-exact", options={"gtol": 1e-9}
    )
    q = scale * found.x
    least = mesh_force(system, (stiffness * np.maximum(meshes.B.T @ q - gap, 0))[None])[0]
    balls = np.maximum(approach @ q - contact, 0).reshape(3, -1)
    force = np.linalg.norm((c * balls**p) @ normals[:, :3], axis=1)
    static = epicyclic.static(system, cycles=1, samples=32)
    np.testing.assert_allclose(static.mesh_force.values[:, 0], least, rtol=1e-6)
    np.testing.assert_allclose(static.group_force.values[:, 0], force, rtol=1e-6)
    # the couple of the helix and the play count: with radial contacts alone the forces are others
    assert balls.any(axis=0).any()
    assert np.ptp(force) > 0.05 * force.mean()
    assert (balls > 0).any(axis=1).all()
    assert 0.2 < np.mean(balls > 0) < 0.8


def _standing_gap(system: System) -> Array:
    """Errors of the rows of groups at the start, (R,) [m, rad]."""
    return np.asarray(sum((line.group_gap.real for line in system.lines if line.group_gap.size), np.zeros(15)))


def test_balance_at_a_thousandth_of_the_speed_is_static() -> None:
    """To 1e-6 of the largest force; with the tangents at the mean load it is 100 times off."""
    system = replace(helical(), zeta=1e-3)  # what is damped at that speed is 3e-8
    static = epicyclic.static(system, cycles=1, samples=101)
    mesh, group = _slow(system)
    largest = static.mesh_force.values.max()
    assert np.abs(mesh - static.mesh_force.values.T).max() < 1e-6 * largest
    of_groups = static.group_force.values
    assert np.abs(system.laws.rows.size(group).T - of_groups).max() < 1e-6 * of_groups.max()
    assert np.ptp(of_groups, axis=1).max() > 0.05 * largest
    assert np.abs(_slow(linear(system))[0] - static.mesh_force.values.T).max() > 1e-4 * largest


def _slow(system: System) -> tuple[Array, Array]:
    """Forces of meshes (N, w) and of rows of groups (N, R) [N, N m] of the balance at a thousandth of the speed."""
    refinement = Refinement(ready=response(system))
    given = refinement.problem(50, samples=101)
    start = load_continuation(refinement, 1e-3, harmonics=16)
    found = solve(given, prolonged(refinement.problem(16), given, start.state.y), 1e-3, tolerance=1e-10)
    assert found.converged
    force = gap_forces(given, found.state)
    return np.asarray(mesh_force(system, flank_force(given, found.state))), force[:, given.rows.count :]


@pytest.mark.parametrize("speed", [2.0, 4.0])
def test_balance_is_the_motion_in_time(speed: float) -> None:
    """RMS to 1e-4; with the tangents at the mean load it is 10 times off."""
    system = helical()
    at = balance(system, speed)
    assert at.stable
    rms = integrated_force(system, at, speed).std(axis=0)
    np.testing.assert_allclose(steady_force(system, at).std(axis=0), rms, rtol=1e-4)
    tangents = linear(system)
    assert np.abs(steady_force(tangents, balance(tangents, speed)).std(axis=0) / rms - 1).max() > 1e-3


def test_multipliers_are_those_of_disturbed_motions() -> None:
    """All to 1e-4, by differences of states a period after a disturbance; with mean tangents they are 10 times off."""
    system, speed, n = helical(), 2.0, len(helical().force)
    found = []
    for one in (system, linear(system)):
        at = balance(one, speed)
        found.append(floquet_multipliers(Refinement(ready=response(one)), at, steps=384))
    at, moving = balance(system, speed), motion(system, program=constant(speed))
    period = 1 / (speed * float(system.tones[0]))
    steps = 2 * steps_for(moving, period)
    size = np.repeat([1e-10, 1e-6], n)  # [m, rad], [m/s, rad/s]

    def after(disturbance: Array) -> Array:
        start = initial_state(at) + (size * disturbance).reshape(2, n)
        end = integrate(moving, start, stop=period, steps=steps, keep=steps)[0][-1]
        return np.asarray(end.ravel() / size)

    flow = np.stack([(after(unit) - after(-unit)) / 2 for unit in np.eye(2 * n)], axis=1)
    reference = np.linalg.eigvals(flow.astype(complex))
    assert _apart(found[0], reference) < 1e-4
    assert _apart(found[1], reference) > 1e-3


def _apart(one: ComplexArray, other: ComplexArray) -> float:
    """Largest distance of a multiplier of either set (k,), (l,) from the nearest of the other set."""
    far = np.abs(one[:, None] - other)
    return float(max(far.min(axis=1).max(), far.min(axis=0).max()))


def test_compiled_steps_are_those_of_numpy() -> None:
    """With a damper per tangent too; states of a cycle to rounding."""
    system = helical()
    system = replace(system, groups=tuple(replace(group, lag=1e-6) for group in system.groups))
    moving = motion(system, program=constant(1.0))
    assert moving.compiled
    rng, n = np.random.default_rng(1), len(system.force)
    start = np.stack([1e-5 * rng.normal(size=n), 1e-3 * rng.normal(size=n)])
    period = 1 / float(system.tones[0])
    steps = -(-steps_for(moving, period) // 8) * 8
    compiled, slow = (
        integrate(replace(moving, compiled=on), start, stop=period, steps=steps, keep=steps // 8)[0]
        for on in (True, False)
    )
    assert np.all(np.abs(compiled - slow) <= 1e-9 * np.abs(slow).max(axis=(0, 2), keepdims=True))


# --- a rotor ----------------------------------------------------------------------------------------------------------


def test_a_rotor_on_two_preloaded_bearings() -> None:
    """Natural frequencies of a rigid rotor between two rows of balls at +-b, pressed together by an axial preload.

    With the slope k of each of E balls, lever l = R sin a + b cos a of its normal about the middle of the rotor:
    m w^2 = E k cos^2 a laterally, 2 E k sin^2 a axially, and J w^2 = E k l^2 in tilt.
    """
    E, angle, R, b, preload, mass, inertia = 32, np.radians(25), 0.04, 0.1, 15e-6, 20.0, 0.15
    name = "rotor"
    links = tuple(
        Link(
            name=f"{name}/support/{number}",
            path="rotor",
            kind="support",
            first=name,
            second=None,
            station=-side * b,
            stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 0.0),
            contacts=contact_set(
                geometry(E, angle, R, 0.0, (side,)), gap=-preload, coefficient=1e9, exponent=1.5, load=1e3
            ),
        )
        for number, side in enumerate((1, -1))
    )
    rotor = Body(
        name=name, member="rotor", kind="body", frame="housing", reference_radius=0.1,
        mass=mass, inertia=0.2, tilt_inertia=inertia,
    )  # fmt: skip
    train = epicyclic.load(HELICAL)  # beside a train: there is none without meshes
    train = replace(
        train,
        frames=(*train.frames, Frame(name="housing")),
        bodies=(*train.bodies, rotor),
        links=(*train.links, *links),
    )
    k, lever = 1.5 * 1e9 * preload**0.5, R * np.sin(angle) + b * np.cos(angle)
    lateral, axial = E * k * np.cos(angle) ** 2 / mass, 2 * E * k * np.sin(angle) ** 2 / mass
    tilt = E * k * lever**2 / inertia
    expected = np.sqrt([lateral, lateral, axial, tilt, tilt]) / (2 * np.pi)
    modes = epicyclic.modes(epicyclic.assemble(train))
    moving = np.abs(modes.shape.sel(dof=[f"{name}/{d}" for d in ("x", "y", "z", "rx", "ry")])).max("dof") > 1e-6
    found = modes.frequency.values[moving.values]
    np.testing.assert_allclose(np.sort(found), np.sort(expected), rtol=1e-9)
