"""Inertia terms in a turning frame against the exact nonlinear motion, and what must stay neutral."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.system.assembly import assemble, carried_stiffness, centrifugal_stiffness, gyroscopic_matrix
from epicyclic.train.train import Displacement, Train

Array = NDArray[np.float64]


def rotation(axis: Array) -> Array:
    """Finite rotation matrix of a rotation vector."""
    angle = float(np.linalg.norm(axis))
    if angle == 0.0:
        return np.eye(3)
    k = axis / angle
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    R: Array = np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K
    return R


def test_centrifugal_potential_of_a_carried_body_by_differences() -> None:
    """V = -m Omega^2 |r|^2 / 2 plus the work of the pin's preload, which stays along the *turned* carrier's radius."""
    mass, omega, radius, psi = 2.0, 30.0, 0.4, 0.9
    K = np.zeros((12, 12))
    K += centrifugal_stiffness(np.array([0.0, mass]), np.zeros(2), np.zeros(2), np.full(2, omega), np.full(2, omega))
    carried_stiffness(K, body=1, carrier=0, angle=psi, preload=mass * omega**2, radius=radius)
    c, s = math.cos(psi), math.sin(psi)
    axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])

    def potential(q: Array) -> float:
        carrier, planet = q[:6], q[6:]
        turn = rotation(carrier[3:])
        seat = carrier[:3] + turn @ (axes @ np.array([radius, 0, 0]))
        place = axes @ (np.array([radius, 0, 0]) + planet[:3])
        centrifugal = -0.5 * mass * omega**2 * (place[0] ** 2 + place[1] ** 2)
        radial = turn @ (axes @ np.array([1.0, 0, 0]))
        # constant pull m Omega^2 r_c along the carrier's own radius on the relative displacement of planet and pin
        return float(centrifugal + mass * omega**2 * radius * radial @ (place - seat))

    step = 1e-4
    size = 12
    hessian = np.zeros((size, size))
    for i in range(size):
        for j in range(size):
            total = 0.0
            for si in (1, -1):
                for sj in (1, -1):
                    q = np.zeros(size)
                    q[i] += si * step
                    q[j] += sj * step
                    total += si * sj * potential(q)
            hessian[i, j] = total / (4 * step**2)
    scale = mass * omega**2
    assert np.abs(K).max() > 0.3 * scale
    # truncation of the differences about step^2 = 1e-8, rounding eps/step^2 = 2e-8
    assert K == pytest.approx(hessian, abs=1e-6 * scale)


def test_gyroscopic_terms_of_a_spinning_disc_by_lagrange() -> None:
    """Kinetic energy of a tilting disc in a turning frame, differentiated numerically, gives G and K of the tilts."""
    inertia, tilt, omega, spin = 0.03, 0.02, 25.0, -140.0
    one = np.array([1.0])
    G = gyroscopic_matrix(0 * one, inertia * one, tilt * one, omega * one, spin * one)[3:5, 3:5]
    K = centrifugal_stiffness(0 * one, inertia * one, tilt * one, omega * one, spin * one)[3:5, 3:5]

    def lagrangian(q: Array, v: Array) -> float:
        # Symmetric disc: spin axis n from the tilts; T = I_d |n'|^2/2 + I_p w_n^2 / 2 with w_n conserved, so use the
        # Routhian -(energy of the cyclic spin): T_d + p * (frame's part of the spin rate along n).
        n = np.array([q[1], -q[0], 1 - 0.5 * (q[0] ** 2 + q[1] ** 2)])
        rate = np.array([v[1], -v[0], -(q[0] * v[0] + q[1] * v[1])]) + np.cross([0, 0, omega], n)
        momentum = inertia * spin
        # Spin rate along n of axes tilted by the vector q: (q' + q x q'/2) . n to second order, plus the frame's turn.
        drift = -0.5 * (q[0] * v[1] - q[1] * v[0]) - 0.5 * omega * (q[0] ** 2 + q[1] ** 2)
        return float(0.5 * tilt * rate @ rate + momentum * drift)

    def second(i: int, j: int, kinds: str) -> float:
        step, total = 1e-3, 0.0
        for si in (1, -1):
            for sj in (1, -1):
                z = np.zeros(4)
                z[i + (2 if kinds[0] == "v" else 0)] += si * step
                z[j + (2 if kinds[1] == "v" else 0)] += sj * step
                total += si * sj * lagrangian(z[:2], z[2:])
        return total / (4 * step**2)

    # d/dt dL/dv - dL/dq: coefficient of v_j in equation i is L_vq[i,j] - L_qv[i,j]; of q_j it is -L_qq[i,j]
    gyro = np.array([[second(i, j, "vq") - second(i, j, "qv") for j in range(2)] for i in range(2)])
    stiff = -np.array([[second(i, j, "qq") for j in range(2)] for i in range(2)])
    scale = abs(inertia * spin * omega)
    assert pytest.approx(gyro, abs=1e-8 * scale) == G
    assert pytest.approx(stiff, abs=1e-6 * scale) == K


def test_rigid_rotation_stays_neutral_under_the_centrifugal_terms(hand_built: Callable[..., Train]) -> None:
    # equal spacing: the pulls of unequally spaced planets leave a resultant that turns with the set
    train = hand_built(
        angles=(0.0, math.pi / 2, math.pi, 3 * math.pi / 2), frame_speed=Fraction(600), sun_speed=Fraction(2500),
        planet_speed=Fraction(-900), ring_support=(1e9, 1e9, 1e9, 1e7, 1e7, 0.0),
    )  # fmt: skip
    system = assemble(train)
    turn = np.zeros(system.M.shape[0])
    for i, (body, direction) in enumerate(zip(system.dofs.body, system.dofs.direction, strict=True)):
        if direction == "rz":
            turn[i] = 1.0
        elif direction == "y" and "planet" in body:
            turn[i] = 0.12  # the pin radius
    scale = np.abs(system.Kg).max()
    assert scale > 0
    assert np.abs(system.mean_stiffness @ turn).max() < 1e-6
    # a set turned as a whole keeps its centrifugal equilibrium: rounding only
    assert np.abs(system.Kg @ turn).max() < 1e-12 * scale
    assert np.abs(system.G + system.G.T).max() == 0.0


def test_a_free_body_moves_straight_as_seen_from_the_ground() -> None:
    """x = R(-Omega t)(x0 + v t) solves M q'' + G q' + K q = 0 in the turning frame."""
    one, omega = np.array([1.0]), 7.0
    G = gyroscopic_matrix(3.0 * one, 0 * one, 0 * one, omega * one, omega * one)[:2, :2]
    K = centrifugal_stiffness(3.0 * one, 0 * one, 0 * one, omega * one, omega * one)[:2, :2]

    def path(t: float) -> Array:
        ground = np.array([0.3 + 1.1 * t, -0.2 + 0.4 * t])
        c, s = math.cos(omega * t), math.sin(omega * t)
        return np.asarray(np.array([[c, s], [-s, c]]) @ ground)

    t, h = 0.4, 1e-4
    velocity = (path(t + h) - path(t - h)) / (2 * h)
    acceleration = (path(t + h) - 2 * path(t) + path(t - h)) / h**2
    # second differences with h = 1e-4: truncation 1e-8 of 100 m/s^2, rounding 1e-8
    assert 3.0 * acceleration + G @ velocity + K @ path(t) == pytest.approx(np.zeros(2), abs=1e-4)


def test_a_damper_to_the_housing_feels_the_absolute_velocity(hand_built: Callable[..., Train]) -> None:
    train = hand_built(frame_speed=Fraction(600), sun_speed=Fraction(2500), planet_speed=Fraction(-900))
    links = tuple(
        dataclasses.replace(link, damping=(50.0, 50.0, 0.0, 3.0, 3.0, 0.0)) if link.name == "main/sun/support" else link
        for link in train.links
    )
    system = assemble(dataclasses.replace(train, links=links))
    names = list(system.dofs.names)
    omega = 2 * math.pi * 10
    for pair, c in ((("x", "y"), 50.0), (("rx", "ry"), 3.0)):
        i, j = (names.index(f"main/sun/{d}") for d in pair)
        # a point resting at (x, y) in the frame moves with Omega (-y, x) over the ground; the damper opposes that
        assert system.Cskew[i, j] == pytest.approx(-c * omega)
        assert system.Cskew[j, i] == pytest.approx(c * omega)
        assert system.C[i, i] == system.C[j, j] == c
    assert np.count_nonzero(system.Cskew) == 4
    # two bearings at one place may share the directions
    x, y, z, rx, ry, rz = next(link.stiffness for link in links if link.name == "main/sun/support")
    half = x / 2, y / 2, z / 2, rx / 2, ry / 2, rz / 2
    shared = [
        dataclasses.replace(
            link,
            name=f"main/sun/support/{name}",
            stiffness=half,
            damping=damping,
        )
        for link in links
        if link.name == "main/sun/support"
        for name, damping in (("front", (50.0, 0.0, 0.0, 3.0, 0.0, 0.0)), ("rear", (0.0, 50.0, 0.0, 0.0, 3.0, 0.0)))
    ]
    others = tuple(link for link in links if link.name != "main/sun/support")
    apart = assemble(dataclasses.replace(train, links=(*others, *shared)))
    rounding = 1e-12 * 50.0 * omega
    np.testing.assert_allclose(apart.Cskew, system.Cskew, rtol=1e-12, atol=rounding)
    of_links = apart.links.B @ apart.links.skew @ apart.links.B.T
    np.testing.assert_allclose(of_links, apart.Cskew, rtol=1e-12, atol=rounding)
    # x of the one and, a quarter turn on, x of the other: isotropic, and no row stands across either
    alone = [
        dataclasses.replace(
            link, angle=angle, stiffness=(x, 0.0, z, rx, ry, rz), damping=(50.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        )
        for link, angle in zip(shared, (0.0, math.pi / 2), strict=True)
    ]
    with pytest.raises(
        ModelError,
        match=r"x alone: a damper to the housing in a turning frame needs a connection across it; allowed: y too",
    ):
        assemble(dataclasses.replace(train, links=(*others, *alone)))


def test_a_seat_displaced_in_the_housing_moves_no_damper(hand_built: Callable[..., Train]) -> None:
    """It stands still over the ground; one that turns with the frame moves with Omega over it."""
    train = hand_built(frame_speed=Fraction(600), sun_speed=Fraction(2500), planet_speed=Fraction(-900))
    omega, c, shift = 2 * math.pi * 10, 50.0, 1e-5
    half = c / 2, c / 2, 0.0, 0.0, 0.0, 0.0
    # two bearings at one place, of which the seat of one is displaced: its damper alone knows of it
    links = (
        *(link for link in train.links if link.name != "main/sun/support"),
        *(
            dataclasses.replace(link, name=f"main/sun/support/{name}", damping=half)
            for link in train.links
            if link.name == "main/sun/support"
            for name in ("front", "rear")
        ),
    )
    for vector, turn, expected in (
        # fixed in the housing: (cos, -sin) of the turn in the frame
        (np.array([shift, 1j * shift]), Fraction(10), np.zeros(2)),
        # fixed in the frame along x: over the ground its velocity is along y
        (np.array([shift, 0.0]), Fraction(0), np.array([0.0, c / 2 * omega * shift])),
    ):
        seat = Displacement(
            path="seat", cause="position", body="main/sun", rows="seat", links=("main/sun/support/front",),
            vector=np.concatenate([vector, np.zeros(4)]), frequency=turn,
        )  # fmt: skip
        system = assemble(dataclasses.replace(train, links=links, displacements=(seat,)))
        (line,) = [line for line in system.lines if "seat" in line.causes]
        sun = [list(system.dofs.names).index(f"main/sun/{d}") for d in "xy"]
        # sense of a displaced seat: its support drags the body along
        assert line.force[1][sun] == pytest.approx(expected, abs=1e-12 * c * omega * shift)
