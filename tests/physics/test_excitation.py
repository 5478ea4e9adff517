"""Displaced features, loads and gravity as lines: signs, frames, and rigid supports as the limit of stiff ones."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.system.assembly import assemble
from epicyclic.system.system import Line, System
from epicyclic.train.train import Damping, Displacement, Load, Train

INF = float("inf")
Maker = Callable[..., Train]
SPEEDS: dict[str, Any] = {
    "frame_speed": Fraction(300),
    "sun_speed": Fraction(1200),
    "planet_speed": Fraction(-700),
}


def rotating(amplitude: float, phase: float) -> NDArray[np.complex128]:
    return np.asarray(amplitude * np.exp(1j * phase) * np.array([1, -1j, 0, 0, 0, 0]), complex)


def run_out(body: str, relative: Fraction, phase: float = 0.4) -> Displacement:
    vector = rotating(1e-5, phase)
    path = f"{body}.run_out"
    return Displacement(path=path, cause="run_out", body=body, rows="mesh", vector=vector, frequency=relative / 60)


def turning_lines(system: System) -> list[Line]:
    """Lines without the constant one, the centrifugal load of planets on a carrier that turns."""
    return [line for line in system.lines if line.frequency]


def gap_at(line: Line, time: float) -> NDArray[np.float64]:
    gap: NDArray[np.float64] = (line.gap * np.exp(2j * math.pi * float(line.frequency) * time)).real
    return gap


@pytest.mark.parametrize("mirror", [1, -1])
def test_run_outs_project_on_the_mesh_normal(hand_built: Maker, mirror: int) -> None:
    """e = -n . E: written out in [ren2021, eq. 11-16 corrected], opposite sign because its e presses."""
    speeds = {key: mirror * value for key, value in SPEEDS.items()}
    train = hand_built(flank=mirror, stations=(0.0,), angles=(0.0, 1.7, 4.0), **speeds)
    for body, member in (("main/sun", "sun"), ("main/planet/2", "planet")):
        relative = speeds[f"{member}_speed"] - speeds["frame_speed"]
        system = assemble(dataclasses.replace(train, displacements=(run_out(body, relative),)))
        (line,) = turning_lines(system)
        assert line.frequency == abs(relative) / 60
        assert line.causes == (f"{body}.run_out",)
        for time in (0.0, 0.0123, 0.03):
            theta = 2 * math.pi * float(relative) / 60 * time + 0.4
            for e, mesh in zip(gap_at(line, time), train.meshes, strict=True):
                a, c = mesh.pressure_angle, math.cos(mesh.base_helix)
                if body == "main/sun" and mesh.a == body:
                    expected = -1e-5 * c * mirror * math.sin(theta - mesh.direction + mirror * a)
                elif mesh.b == body:
                    expected = 1e-5 * c * mirror * math.sin(theta + mirror * a)
                elif mesh.a == body:
                    expected = 1e-5 * c * mirror * math.sin(theta - mirror * a)
                else:
                    expected = 0.0
                # amplitudes of 1e-5 m: rounding
                assert e == pytest.approx(expected, abs=1e-19)


def response(system: System, line: Line) -> NDArray[np.complex128]:
    """Mesh gap amplitudes on the mean system at the line's own frequency."""
    w = 2 * math.pi * float(line.frequency)
    B = system.meshes.B
    Z = system.mean_stiffness + system.Kg + system.Cskew - w**2 * system.M + 1j * w * (system.C + system.G)
    x = np.linalg.solve(Z, line.force.sum(axis=0) + B @ (system.meshes.stiffness * line.gap))
    result: NDArray[np.complex128] = B.T @ x - line.gap
    return result


@pytest.mark.parametrize(
    ("body", "rows", "link"),
    [
        ("main/sun", "own", "main/sun/support"),
        ("main/sun", "seat", "main/sun/support"),
        ("main/planet/2", "own", "main/planet/2/bearing"),
        ("main/planet/2", "seat", "main/planet/2/bearing"),
        ("main/carrier", "own", "main/planet/2/bearing"),
    ],
)
def test_a_rigid_connection_is_the_limit_of_a_stiff_one(
    hand_built: Maker, body: str, rows: Literal["own", "seat"], link: str
) -> None:
    """The eliminated body moves with its displaced seat: q = T p + s, with the inertia of s on the right side."""
    stiff = 1e14
    results = []
    for k in (stiff, INF):
        train = hand_built(support=(k, k, 2e8, 1e6, 1e6, 0.0), pin=(k, k, 3e8, 2e6, 2e6, 0.0), **SPEEDS)
        item = Displacement(
            path="d", cause="position", body=body, rows=rows, links=(link,), vector=rotating(1e-5, 0.3),
            frequency=Fraction(90),
        )  # fmt: skip
        system = assemble(dataclasses.replace(train, displacements=(item,)))
        results.append(response(system, *turning_lines(system)))
    assert np.abs(results[1]).max() > 1e-6
    # k_mesh / k = 5e-6 of a deflection, and 1e-16 * k / k_mesh of rounding in the stiff system
    assert results[0] == pytest.approx(results[1], abs=1e-4 * np.abs(results[1]).max())


def test_seats_of_two_rigid_connections_do_not_part(hand_built: Maker) -> None:
    train = hand_built(support=(INF, INF, 2e8, 1e6, 1e6, 0.0), **SPEEDS)
    support = next(link for link in train.links if link.name == "main/sun/support")
    rear = dataclasses.replace(support, name="main/sun/support/rear")
    item = Displacement(
        path="d", cause="position", body="main/sun", rows="seat", links=(support.name,), vector=rotating(1e-5, 0.3),
        frequency=Fraction(90),
    )  # fmt: skip
    both = dataclasses.replace(item, links=(support.name, rear.name))
    train = dataclasses.replace(train, links=(*train.links, rear))
    assert turning_lines(assemble(dataclasses.replace(train, displacements=(both,))))
    with pytest.raises(ModelError, match=r"^d: rigid connections do not admit this displacement"):
        assemble(dataclasses.replace(train, displacements=(item,)))


def test_own_and_seat_displace_in_opposite_senses(hand_built: Maker) -> None:
    """A bore moved by E carries the body along; a journal moved by E on its body pushes the body back."""
    train = hand_built(support=(INF, INF, 2e8, 1e6, 1e6, 0.0))
    shift = np.array([1e-5, 2e-5, 0, 0, 0, 0], complex)
    gaps = {}
    for rows in ("own", "seat"):
        item = Displacement(
            path="d", cause="position", body="main/sun", rows=rows, links=("main/sun/support",), vector=shift,
            frequency=Fraction(0),
        )  # fmt: skip
        (line,) = assemble(dataclasses.replace(train, displacements=(item,))).lines
        gaps[rows] = line.gap.real
    sun = [i for i, mesh in enumerate(train.meshes) if mesh.a == "main/sun"]
    normal = np.array([math.cos(0.3) * math.sin(train.meshes[sun[0]].pressure_angle)])
    # the sun stands at +E: it presses branch 1 (e = x) more, so the gap constant is -n . E
    radial = normal[0] * 1e-5 + math.cos(0.3) * math.cos(train.meshes[sun[0]].pressure_angle) * 2e-5
    assert gaps["seat"][sun[0]] == pytest.approx(-radial, rel=1e-12)
    assert gaps["own"] == pytest.approx(-gaps["seat"], abs=1e-20)


def test_gravity_turns_backwards_in_the_carrier_frame(hand_built: Maker) -> None:
    train = dataclasses.replace(hand_built(angles=(0.0, 2.0, 4.0), **SPEEDS), gravity=(0.0, -9.81, 0.0))
    system = assemble(train)
    centrifugal, line = system.lines
    assert centrifugal.causes == ("stages.main.planet.mass",)
    assert line.frequency == Fraction(5)
    omega = 2 * math.pi * 5
    for time in (0.0, 0.01, 0.07):
        force = (line.force[0] * np.exp(1j * omega * time)).real
        by_name = dict(zip(system.dofs.names, force, strict=True))
        angle = omega * time
        assert by_name["main/sun/x"] == pytest.approx(-9.81 * 2.0 * math.sin(angle), abs=1e-12)
        assert by_name["main/sun/y"] == pytest.approx(-9.81 * 2.0 * math.cos(angle), abs=1e-12)
        assert by_name["main/planet/2/x"] == pytest.approx(-9.81 * 2.0 * math.sin(angle + 2.0), abs=1e-12)
        assert by_name["main/planet/2/y"] == pytest.approx(-9.81 * 2.0 * math.cos(angle + 2.0), abs=1e-12)


def test_centrifugal_load_is_outward_on_carried_bodies_alone(hand_built: Maker) -> None:
    """m Omega^2 r_c along x, the radius of the pin, with the square of the speed; none where the carrier stands."""
    train = hand_built(angles=(0.0, 2.0, 4.0), **SPEEDS)
    system = assemble(train)
    (line,) = system.lines
    assert line.frequency == 0
    assert not line.force[:2].any()
    planet = next(body for body in train.bodies if body.name == "main/planet/2")
    outward = planet.mass * (2 * math.pi * 5) ** 2 * math.hypot(*planet.centre)
    for name, value in zip(system.dofs.names, line.force[2].real, strict=True):
        expected = outward if "planet" in name and name.endswith("/x") else 0.0
        assert value == pytest.approx(expected, rel=1e-12, abs=1e-9), name
    assert not assemble(hand_built(angles=(0.0, 2.0, 4.0))).lines


def test_loads_fixed_in_space_and_turning_with_a_member(hand_built: Maker) -> None:
    train = hand_built(**SPEEDS)
    fixed = Load(
        path="loads.rotor", body="main/sun", force=(10.0, 0.0, 3.0), moment=(0.0, 0.0, 0.0), station=0.5, turns=False
    )
    turning = dataclasses.replace(fixed, path="loads.unbalance", turns=True)
    system = assemble(dataclasses.replace(train, loads=(fixed,)))
    lines = {line.frequency: line for line in system.lines}
    assert set(lines) == {Fraction(0), Fraction(5)}
    names = list(system.dofs.names)
    z, x, ry = names.index("main/sun/z"), names.index("main/sun/x"), names.index("main/sun/ry")
    assert lines[Fraction(0)].force[0][z] == 3.0
    assert lines[Fraction(5)].force[0][x].real == pytest.approx(10.0)
    # a force along x at station 0.5 m turns the body about +y
    assert lines[Fraction(5)].force[0][ry].real == pytest.approx(5.0)
    # a tenth of a carrier turn later the frame sees the load 36 deg behind
    later = (lines[Fraction(5)].force[0] * np.exp(2j * math.pi * 0.1)).real
    assert later[names.index("main/sun/y")] == pytest.approx(-10 * math.sin(0.2 * math.pi))
    # along y it turns the body about -x
    sideways = assemble(dataclasses.replace(train, loads=(dataclasses.replace(fixed, force=(0.0, 10.0, 0.0)),)))
    assert turning_lines(sideways)[0].force[0][names.index("main/sun/rx")].real == pytest.approx(-5.0)
    system = assemble(dataclasses.replace(train, loads=(turning,)))
    spinning = {line.frequency: line for line in system.lines}
    assert set(spinning) == {Fraction(0), Fraction(900, 60)}
    # it runs ahead of the frame
    later = (spinning[Fraction(15)].force[0] * np.exp(2j * math.pi * 0.1)).real
    assert later[names.index("main/sun/y")] == pytest.approx(10 * math.sin(0.2 * math.pi))


def test_lines_of_one_frequency_add_as_complex_numbers(hand_built: Maker) -> None:
    train = hand_built(**SPEEDS)
    relative = SPEEDS["sun_speed"] - SPEEDS["frame_speed"]
    twice = (run_out("main/sun", relative, 0.0), run_out("main/sun", relative, math.pi))
    system = assemble(dataclasses.replace(train, displacements=twice))
    (line,) = turning_lines(system)
    assert np.abs(line.gap).max() < 1e-20


@pytest.mark.parametrize("sense", [1, -1])
def test_stiffness_follows_the_place_of_the_contact(hand_built: Maker, sense: int) -> None:
    """k(t) = k(sigma) with sigma = D (f t + gamma): an unsymmetric series tells the sense and the lead."""
    series = np.array([0.1 - 0.07j, 0.03 + 0.02j])
    train = hand_built(stations=(0.0,))
    first = dataclasses.replace(train.meshes[0], variation=series, lead=Fraction(1, 5), sense=sense)
    system = assemble(dataclasses.replace(train, meshes=(first, *train.meshes[1:])))
    order = np.array([1, 2])
    for phase in (0.0, 0.3, 0.9):
        sigma = sense * (phase + 0.2)
        expected = (series * np.exp(2j * np.pi * order * sigma)).real.sum()
        actual = (system.meshes.variation[0] * np.exp(2j * np.pi * order * phase)).real.sum()
        assert actual == pytest.approx(expected, abs=1e-15)
    assert not system.meshes.variation[1:].any()


def test_mesh_damping_ratio_is_that_of_the_two_gears_alone(hand_built: Maker) -> None:
    """c = 2 zeta sqrt(k m): with the mesh as the only spring of the pair, its mode has the ratio zeta."""
    train = hand_built(angles=(0.0,), helix=0.0, stations=(0.0,), pin=(INF, INF, INF, INF, INF, 0.0),
                       support=(INF, INF, INF, INF, INF, 0.0), ring_support=(INF,) * 6)  # fmt: skip
    links = tuple(
        dataclasses.replace(link, stiffness=(INF,) * 6) if "carrier" in link.name else link for link in train.links
    )
    pair = dataclasses.replace(train, links=links, meshes=train.meshes[:1], damping=Damping(mesh=0.04))
    system = assemble(pair)
    assert system.M.shape == (2, 2)
    value, shape = np.linalg.eig(np.linalg.solve(system.M, system.mean_stiffness))
    phi = shape[:, np.argmax(value)]
    omega = math.sqrt(value.max())
    C = (system.meshes.B * system.meshes.damping) @ system.meshes.B.T
    ratio = phi @ C @ phi / (2 * omega * (phi @ system.M @ phi))
    assert ratio == pytest.approx(0.04, rel=1e-12)
