"""Forces of bearings, supports and couplings: in balance with the motion of every body, static where all is slow."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.modes.eigen import mean_modes
from epicyclic.questions.response import SteadyOptions
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.spectra import force_signal, link_signal, motion_signal
from epicyclic.questions.response.steady import steady
from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.static import static
from epicyclic.statics.tangent import linear
from epicyclic.system.link_laws import Law, LawGroup
from epicyclic.system.system import System
from epicyclic.train.train import Train

SPUR: dict[str, Any] = {"stages.main.helix_angle": "0 deg", "stages.main.carrier.support.radial": "5e8 N/m"}


def outward_loads(system: System, train: Train) -> NDArray[np.float64]:
    """m Omega^2 r_c along the radius of every body that a carrier carries, (n,) [N]."""
    load = np.zeros((len(train.bodies), 6))
    frames = train.kinematics.frame_speed or {}
    for row, body in zip(load, train.bodies, strict=True):
        if body.carried_by is not None:
            row[0] = body.mass * (math.pi / 30 * float(frames[body.frame])) ** 2 * math.hypot(*body.centre)
    return load.ravel() @ system.dofs.expand


def unbalanced(system: System, train: Train, speed: float) -> tuple[float, float]:
    """Largest left over of M q'' + ... = sum of mesh, link and external forces at any frequency [N], and largest force.

    The external force is the torque and the centrifugal load: errors enter through the link and mesh forces.
    """
    ready = response(system)
    block = next(respond(ready, np.array([speed]), tolerance=1e-11))
    links, meshes = system.links, system.meshes
    squared, shapes = mean_modes(system)
    modal = system.M @ (shapes * (2 * (system.zeta or 0.0) * np.sqrt(squared))) @ shapes.T @ system.M
    rates = system.C - (links.B * links.damping) @ links.B.T + modal + speed * system.G
    turned = links.B @ links.skew @ links.B.T if links.skew.size else 0.0
    springs = speed**2 * system.Kg + speed * (system.Cskew - turned)
    signals = motion_signal(ready, block), force_signal(ready, block), link_signal(ready, block)
    left, largest = 0.0, 0.0
    centrifugal = outward_loads(system, train)
    for kind in ("orders", "lines")[: 1 if block.shaft is None else 2]:
        q, force, held = (getattr(signal, kind).amplitude[:, 0] for signal in signals)
        J = q.shape[2]
        omega = speed * ready.frequency(block.truncation, shifted=kind == "lines")[0]
        pushed = np.tensordot(meshes.B, force[..., :J], axes=1)
        pulled = np.tensordot(links.B, held, axes=1)
        total = -(omega**2) * np.tensordot(system.M, q, axes=1) + 1j * omega * np.tensordot(rates, q, axes=1)
        total = total + np.tensordot(springs, q, axes=1) + pushed + pulled
        if kind == "orders":
            total[:, 0, 0] -= system.force + speed**2 * centrifugal
        left = max(left, float(np.abs(total / system.dofs.radius[:, None, None]).max()))
        largest = max(largest, float(np.abs(pulled / system.dofs.radius[:, None, None]).max()))
    return left, largest


@pytest.mark.parametrize("drive", ["ren2021", "xu2020", "damped"])
@pytest.mark.parametrize("speed", [1.0, 12.0])
def test_forces_on_every_body_balance_its_acceleration(drive: str, speed: float) -> None:
    """Run-outs at shaft orders, profile errors, a turning frame; `damped`: a damper to the housing in that frame."""
    train = epicyclic.load("ren2021" if drive == "damped" else drive)
    system = epicyclic.assemble(train)
    if drive == "damped":
        system = damped_support(system)
    left, largest = unbalanced(system, train, speed)
    # residual 1e-11 of the response, which forces of stiff modes in balance may multiply
    assert left < 1e-8 * largest


def damped_support(system: System) -> System:
    """A damper in the sun's support, in a frame that turns."""
    links = system.links
    x, y = (links.name.index(f"main/sun/support/{d}") for d in "xy")
    damping, skew = links.damping.copy(), np.zeros((len(links.name),) * 2)
    damping[[x, y]] = 2e5
    skew[y, x], skew[x, y] = 4e5, -4e5
    return replace(
        system,
        links=replace(links, damping=damping, skew=skew),
        C=system.C + (links.B * damping) @ links.B.T,
        Cskew=links.B @ skew @ links.B.T,
    )


def test_the_assembly_holds_the_part_of_the_turning_frame_in_dampers() -> None:
    damping = {"stages.main.sun.support.damping": {"x": "0.1 MN s/m", "y": "0.1 MN s/m"}}
    train = epicyclic.load("ren2021", overrides=damping)
    system = epicyclic.assemble(train)
    links = system.links
    assert links.skew.any()
    np.testing.assert_array_equal(links.skew, -links.skew.T)
    np.testing.assert_allclose(links.B @ links.skew @ links.B.T, system.Cskew, atol=1e-9 * np.abs(system.Cskew).max())
    left, largest = unbalanced(system, train, 3.0)
    assert left < 1e-8 * largest


def test_slow_is_static(case: Any) -> None:
    """At a speed near zero the links carry what they carry at rest, errors of their own included."""
    pair = case.pair(turning=0.0, mesh_damping=0.0, lines=(case.line(Fraction(0), [2e-6, -1e-6]),))
    gap = np.array([2e-6, 1e-6, 0.0, -3e-6])
    line = pair.lines[0]
    force = line.force.copy()
    force[0] += pair.links.B @ (pair.links.stiffness * gap)
    force[1:] = 0.0
    slow = replace(pair, C=np.zeros((6, 6)), lines=(replace(line, link_gap=gap.astype(complex), force=force),))
    moving = steady(slow, SteadyOptions(relative_speed=1e-4, samples=32))
    resting = static(slow, StaticOptions(cycles=1, samples=32))
    size = float(np.abs(resting.link_force).max())
    # inertia and damping of 0.01 Hz beside 100 Hz: 1e-4 of the damping ratio
    np.testing.assert_allclose(moving.link_force, resting.link_force, atol=1e-5 * size)
    np.testing.assert_allclose(moving.link_force_harmonic[:, 0].real, resting.link_force.mean("time"), atol=1e-5 * size)


def test_a_law_keeps_its_force_at_the_mean_load(case: Any) -> None:
    """The tangent's row carries at rest what the bearing with play does."""
    pair = case.pair(turning=0.0, swing=0.0, lines=())
    links, rows = pair.links, [0, 1]
    law = Law(stiffness=2e6, clearance=2e-5)
    group = LawGroup(
        name="main/a/support",
        kind="support",
        rows=links.name[:2],
        B=links.B[:, rows],
        law=law,
        damping=np.zeros(2),
    )
    kept = replace(
        links,
        name=links.name[2:],
        link=links.link[2:],
        B=links.B[:, 2:],
        stiffness=links.stiffness[2:],
        damping=links.damping[2:],
    )
    K = pair.K - (links.B[:, rows] * links.stiffness[rows]) @ links.B[:, rows].T
    system = replace(pair, K=K, links=kept, groups=(group,))
    flexible = compliance_of(system)
    state = equilibrium(
        flexible,
        stiffness=system.meshes.stiffness[None],
        gap=np.zeros((1, len(flexible.stiffness))),
        force=system.force[None],
        laws=system.laws,
    )
    expected = float(np.hypot(*state.group_force[0]))
    result = steady(system, SteadyOptions())
    names = list(result.link_row.values)
    radial, across = names.index("main/a/support/radial"), names.index("main/a/support/tangential")
    assert expected > 100.0
    # the equilibrium is found to 1e-10 or so of its forces
    np.testing.assert_allclose(result.link_force[radial], expected, rtol=1e-6)
    np.testing.assert_allclose(result.link_force[across], 0.0, atol=1e-6 * expected)
    np.testing.assert_allclose(result.bearing_force_mean.sel(bearing="main/a/support"), expected, rtol=1e-6)
    assert linear(system).links.preload.any()


def test_the_weight_on_a_support_stands_still_in_the_housing(one_stage: dict[str, Any]) -> None:
    """It turns in the carrier's frame, forwards or backwards, but loads the bearing as a constant force."""
    for speed in (300, -300):
        given = {"operation.gravity": True, "operation.speed.carrier": f"{speed} rpm", "operation.torque": None}
        found = steady(epicyclic.assemble(epicyclic.load(one_stage, SPUR | given)), SteadyOptions())
        mean, rms = (found[f"bearing_force_{name}"].sel(bearing="main/carrier/support") for name in ("mean", "rms"))
        # the ring stands on its own; sun and planets hang between the carrier and the ring's teeth
        assert float(mean) > 9.81 * 40
        # what varies with the mesh stiffness is left
        assert float(rms) < 1e-2 * float(mean)
        rows = [list(found.link_row.values).index(f"main/carrier/support/{one}") for one in "xy"]
        np.testing.assert_allclose(found.link_force_rms[rows], float(mean) / np.sqrt(2), rtol=1e-2)


@pytest.mark.parametrize("speed", [1.0, 3.0])
def test_a_planet_bearing_holds_the_centrifugal_load_of_its_planet(one_stage: dict[str, Any], speed: float) -> None:
    """T / (N r_c) along the pin's path and m Omega^2 r_c along its radius, with the square of the speed."""
    given = {"operation.speed.carrier": "900 rpm", "operation.torque.carrier": "600 N m"}
    train = epicyclic.load(one_stage, SPUR | given)
    planet = next(body for body in train.bodies if body.name == "main/planet/1")
    radius, omega = math.hypot(*planet.centre), speed * 900 * math.pi / 30
    found = steady(epicyclic.assemble(train), SteadyOptions(relative_speed=speed))
    # exact but for the change of the mesh stiffness beside the mean
    np.testing.assert_allclose(
        found.bearing_force_mean.sel(bearing="main/planet/1/bearing"),
        math.hypot(600 / (3 * radius), planet.mass * omega**2 * radius),
        rtol=1e-3,
    )
