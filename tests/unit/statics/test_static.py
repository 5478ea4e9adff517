"""Static equilibrium: closed forms of load sharing, lost contact, the energy minimum from any start."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance, compliance_of, equilibrium
from epicyclic.statics.record import hunting_cycles, turn_fraction
from epicyclic.statics.static import static
from epicyclic.system.system import Line, System

Array = NDArray[np.float64]
TORQUE = 300.0


def floating_sun(build: Any, n: int, gap: Array, *, torque: float = TORQUE) -> System:
    """Ring and carrier rigid, sun free in x and y, planets turning on rigid pins; errors `gap` (n,) in sun meshes."""
    system: System = build.planar(N=n, lateral=(0.0, 1e8, 1e8, 1e8)).system()
    columns = [0, 1, 2, *(9 + 3 * i + 2 for i in range(n))]
    T = np.eye(len(system.M))[:, columns]
    names = tuple(system.dofs.names[i] for i in columns)
    small: System = build.reduced(system, T, names, system.dofs.radius[columns])
    force = np.zeros(len(columns))
    force[2] = torque
    return replace(small, force=force, lines=(constant(small, np.concatenate([gap, np.zeros(n)])),))


def constant(system: System, gap: Array, frequency: Fraction = Fraction(0)) -> Line:
    return Line(
        frequency=frequency,
        gap=gap.astype(complex),
        link_gap=np.zeros(len(system.links.name), complex),
        force=np.zeros((3, len(system.force)), complex),
    )


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_floating_sun_closed_form(build: Any, n: int) -> None:
    """F_i = T/(n r) + k e [delta_i1 - (1 + 2 cos(2 pi (i-1)/n))/n]: one pin with error e, path stiffness k."""
    e = 3e-6
    system = floating_sun(build, n, -e * (np.arange(n) == 0))
    result = static(system, StaticOptions(samples=1))
    i = np.arange(n)
    k = 1 / (1 / 5e8 + 1 / 5e8)
    expected = TORQUE / (n * 0.07742 / 2) + k * e * ((i == 0) - (1 + 2 * np.cos(2 * np.pi * i / n)) / n)
    force = result.mesh_force.values[:, 0]
    # one linear solve, condition 1e3
    np.testing.assert_allclose(force[:n], expected, rtol=1e-10)
    np.testing.assert_allclose(force[n:], expected, rtol=1e-10)  # each planet is in balance
    if n == 3:
        np.testing.assert_allclose(force, force[0], rtol=1e-12)


def star(build: Any, support: float = 1e2, torque: float = 1000.0, gap: float = 1e-3) -> System:
    """Five-branch star drive: carrier rigid, sun and ring floating on weak supports, star 4 with a large gap."""
    system: System = build.planar(
        N=5, lateral=(support, support, 1e8, 1e8), torsion=(0.0, 0.0, 0.0), mesh=(1e9, 1e9)
    ).system()
    columns = [0, 1, 2, 3, 4, 5, *(9 + 3 * i + 2 for i in range(5))]
    T = np.eye(len(system.M))[:, columns]
    names = tuple(system.dofs.names[i] for i in columns)
    small: System = build.reduced(system, T, names, system.dofs.radius[columns])
    force = np.zeros(len(columns))
    force[2] = torque
    free = compliance_of(small).free[:, 0]
    force[5] = -force[2] * free[2] / free[5]
    return replace(small, force=force, lines=(constant(small, gap * (np.arange(10) == 3)),))


def test_lost_contact_limit_of_the_star(build: Any) -> None:
    """dong2019: one of five stars open, supports -> 0: shares (5 -+ sqrt 5)/4, whatever error and torque."""
    result = static(star(build), StaticOptions(samples=1))
    force = result.mesh_force.values[:5, 0]
    expected = [(5 - 5**0.5) / 4, (5 - 5**0.5) / 4, (5 + 5**0.5) / 4, 0.0, (5 + 5**0.5) / 4]
    # the limit is approached with support/mesh stiffness times gap/deflection, 1e-7 times 40
    np.testing.assert_allclose(5 * force / force.sum(), expected, atol=1e-5)
    assert result.contact_lost.values.tolist() == [False, False, False, True, False] * 2
    assert any("meshes open" in text for text in json.loads(result.attrs["warnings"]))


def _random_case(build: Any, rng: np.random.Generator) -> tuple[System, Array, Array]:
    N = int(rng.integers(3, 8))
    soft = 10 ** rng.uniform(6, 9, size=4)
    soft[0] *= rng.integers(0, 2)
    system: System = build.planar(N=N, lateral=tuple(soft)).system()
    free = compliance_of(system).free[:, 0]
    force = np.zeros(len(system.M))
    force[2] = TORQUE
    force[8] = -TORQUE * free[2] / free[8]
    gap = rng.normal(size=(4, 2 * N)) * 10 ** rng.uniform(-6, -4)
    return system, np.tile(force, (4, 1)), gap


def test_least_energy_from_any_start(build: Any) -> None:
    """150 cases, four errors each, from random starts: <= 11 steps, one answer, and it is the minimum."""
    rng = np.random.default_rng(3)
    worst = 0
    for _ in range(150):
        system, force, gap = _random_case(build, rng)
        flexible = compliance_of(system)
        k = system.meshes.stiffness * rng.uniform(0.7, 1.3, size=gap.shape)
        start = rng.normal(size=gap.shape) * 10 ** rng.uniform(-6, -4)
        plain = equilibrium(flexible, stiffness=k, gap=gap, force=force)
        found = equilibrium(flexible, stiffness=k, gap=gap, force=force, start=start)
        worst = max(worst, int(found.iterations.max()))
        scale = np.abs(plain.mesh_force).max()
        # 1e-10 of the largest term k w, which exceeds the forces where supports are soft
        np.testing.assert_allclose(found.mesh_force, plain.mesh_force, atol=1e-7 * scale)
        # the energy is convex: equilibrium and the law at that place prove the minimum
        slope = plain.displacement @ system.K - force + plain.mesh_force @ system.meshes.B.T
        assert np.abs(slope).max() < 1e-7 * np.abs(force).max()
        law = k * np.maximum(plain.displacement @ system.meshes.B - gap, 0)
        np.testing.assert_allclose(plain.mesh_force, law, atol=1e-7 * scale)
    assert worst <= 11


def test_some_random_cases_open(build: Any) -> None:
    rng = np.random.default_rng(3)
    opened = 0
    for _ in range(30):
        system, force, gap = _random_case(build, rng)
        flexible = compliance_of(system)
        state = equilibrium(flexible, stiffness=np.tile(system.meshes.stiffness, (4, 1)), gap=gap, force=force)
        opened += int(np.any(state.mesh_force == 0))
    assert 5 <= opened <= 25  # the test above covers both


def test_record_follows_stiffness_and_lines(build: Any) -> None:
    """Each instant equals a static solve with that instant's stiffness and error put in by hand."""
    n = 4
    tone, slow = Fraction(50), Fraction(50, 3)
    system = floating_sun(build, n, np.zeros(n))
    rng = np.random.default_rng(5)
    amplitude = 2e-6 * (rng.normal(size=2 * n) + 1j * rng.normal(size=2 * n))
    line = replace(constant(system, np.zeros(2 * n), slow), gap=np.asarray(amplitude, complex))
    variation = 0.2 * np.exp(2j * np.pi * rng.random(size=(2 * n, 2)))
    system = replace(system, tones=(tone,), lines=(line,), meshes=replace(system.meshes, variation=variation))
    result = static(system, StaticOptions(samples=8))
    assert result.sizes["time"] == 3 * 8  # the hunting period
    for j in (0, 5, 13, 23):
        t = float(result.time.values[j])
        waves = np.exp(2j * np.pi * float(tone) * t * np.arange(1, 3))
        stiffness = system.meshes.stiffness * (1 + (variation @ waves).real)
        frozen = replace(
            system,
            meshes=replace(system.meshes, stiffness=stiffness, variation=np.zeros((2 * n, 0), complex)),
            lines=(constant(system, (amplitude * np.exp(2j * np.pi * float(slow) * t)).real),),
        )
        alone = static(frozen, StaticOptions(cycles=1, samples=1))
        # two linear solves, condition 1e3
        np.testing.assert_allclose(result.mesh_force.values[:, j], alone.mesh_force.values[:, 0], rtol=1e-9)
        np.testing.assert_allclose(
            result.displacement.values[:, j], alone.displacement.values[:, 0], rtol=1e-7, atol=1e-15
        )


def test_supports_carry_the_load(build: Any) -> None:
    """A sideways force on the sun comes back from the supports of all central bodies together."""
    system: System = build.planar(N=3).system()
    push = np.zeros((3, len(system.force)), complex)
    push[0, 1] = -500.0
    force = np.zeros(len(system.force))
    free = compliance_of(system).free[:, 0]
    force[2], force[8] = TORQUE, -TORQUE * free[2] / free[8]
    push[2, 0] = 1e6  # grows with speed squared: inertia, does not count here
    line = replace(constant(system, np.zeros(6)), force=push)
    result = static(replace(system, force=force, lines=(line,)), StaticOptions(samples=1))
    rows = [f"main/{body}/support/y" for body in ("sun", "ring", "carrier")]
    total = result.link_force.sel(link_row=rows).sum().item()
    np.testing.assert_allclose(total, -500.0, rtol=1e-9)  # sum of three forces of the same size
    sideways = [row.replace("/y", "/x") for row in rows]
    assert abs(result.link_force.sel(link_row=sideways).sum().item()) < 1e-6


def test_link_error_is_taken_off_the_link_force(build: Any) -> None:
    system: System = build.planar(N=3).system()
    e = 1e-5
    gap = np.zeros(len(system.links.name), complex)
    gap[system.links.name.index("main/sun/support/x")] = e
    free = compliance_of(system).free[:, 0]
    force = np.zeros(len(system.force))
    force[2], force[8] = 3000.0, -3000.0 * free[2] / free[8]
    push = np.zeros((3, len(force)), complex)
    push[0] = system.links.B @ (system.links.stiffness * gap)
    line = replace(constant(system, np.zeros(6)), link_gap=gap, force=push)
    result = static(replace(system, force=force, lines=(line,)), StaticOptions(samples=1))
    plain = static(replace(system, force=force), StaticOptions(samples=1))
    moved = result.displacement.sel(dof="main/sun/x").item() - plain.displacement.sel(dof="main/sun/x").item()
    got = result.link_force.sel(link_row="main/sun/support/x").item()
    before = plain.link_force.sel(link_row="main/sun/support/x").item()
    np.testing.assert_allclose(got - before, 1e8 * (moved - e), rtol=1e-7)  # a difference of displacements


def test_positions_without_support_are_said(build: Any) -> None:
    n = 3
    assert json.loads(static(floating_sun(build, n, np.zeros(n)), StaticOptions(samples=1)).attrs["warnings"]) == []
    system = star(build, support=0.0, gap=0.0)
    (text,) = json.loads(static(system, StaticOptions(samples=1)).attrs["warnings"])
    assert "main/sun" in text
    assert "main/ring" in text
    assert "not unique" in text


def test_bad_loads_are_refused(build: Any) -> None:
    system: System = build.planar(N=3).system()
    force = np.zeros(len(system.force))
    force[2] = TORQUE
    with pytest.raises(ModelError, match="does not balance"):
        static(replace(system, force=force), StaticOptions())
    n = 3
    with pytest.raises(ModelError, match="nothing holds"):
        static(floating_sun(build, n, np.zeros(n), torque=-TORQUE), StaticOptions())
    with pytest.raises(ModelError, match="samples"):
        epicyclic.static(floating_sun(build, n, np.zeros(n)), samples=0)
    with pytest.raises(ModelError, match="cycles"):
        epicyclic.static(floating_sun(build, n, np.zeros(n)), cycles=-3)


def test_giving_up_is_an_error(build: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.statics.equilibrium._STEPS", 1)
    system = star(build)
    flexible = compliance_of(system)
    gap = system.lines[0].gap.real[None]
    with pytest.raises(ConvergenceError, match="1 of 1 instants"):
        equilibrium(flexible, stiffness=system.meshes.stiffness[None], gap=gap, force=system.force[None])


def test_progress_and_chunks(build: Any) -> None:
    done: list[float] = []
    result = static(floating_sun(build, 3, np.zeros(3)), StaticOptions(cycles=3, samples=1000), progress=done.append)
    assert len(done) == 2  # chunks of 2048 instants
    assert done[-1] == 1.0
    assert np.ptp(result.mesh_force.values) < 1e-9 * TORQUE


@given(st.integers(-(10**12), 10**12), st.integers(1, 10**12), st.integers(0, 10**6))
@example(333_333_333_333, 999_999_999_989, 12_345)  # a denominator beyond exact products: the rounded form
@example(22, 71, 12_345)
def test_turns_are_exact(p: int, q: int, index: int) -> None:
    ratio = Fraction(p, q)
    exact = float(ratio * index % 1)
    found = float(turn_fraction(ratio, np.array([index]))[0])
    # float64 fallback for huge denominators: index times eps
    distance = abs(found - exact)
    assert min(distance, 1 - distance) <= (1e-15 if ratio.denominator < 2**31 else 1e-9)


def test_hunting_period_of_three_tooth_numbers() -> None:
    """ren2021: sun 23, planet 17, ring 57 mesh cycles."""
    assert hunting_cycles([Fraction(1, 23), Fraction(-2, 17), Fraction(1, 57), Fraction(3)]) == 22287
    assert hunting_cycles([]) == 1


@pytest.mark.parametrize("support", [1e3, 1.0, 1e-3, 1e-9])
def test_a_soft_support_beside_stiff_meshes_takes_the_load(support: float) -> None:
    """Two bodies with a mesh of 1e9 N/m, one of them held; its deflection is that of the whole load."""
    found = compliance(np.array([[np.sqrt(support)], [0.0]]), np.array([[1.0], [-1.0]]), np.array([1e9]))
    assert found.free.shape[1] == 0
    assert (found.inverse @ [3.0, 2.0])[0] * support == pytest.approx(5.0, rel=1e-13)


def test_no_support_leaves_a_motion_free() -> None:
    found = compliance(np.zeros((2, 0)), np.array([[1.0], [-1.0]]), np.array([1e9]))
    assert found.free.shape[1] == 1
    assert np.abs(found.free[:, 0]) == pytest.approx([0.5**0.5] * 2, rel=1e-12)


def test_the_period_of_several_mesh_frequencies_is_no_hunting_period() -> None:
    """Two stages: 220 cycles of the first mesh are whole cycles of the other; errors and weight add shaft orders."""
    plain = {"deviations": None, "operation.gravity": None}
    for verb in (epicyclic.static, epicyclic.sharing):
        told = json.loads(verb("encased-differential", overrides=plain, cycles=2, samples=4).attrs["warnings"])
        short = (
            "record of 2 mesh cycles is shorter than the common period of the mesh frequencies of 220; --cycles takes"
        )
        assert any(text.startswith(short) for text in told), told
    told = json.loads(epicyclic.static("encased-differential", cycles=2, samples=4).attrs["warnings"])
    assert any("common period of the mesh frequencies and shaft orders of" in text for text in told)


def test_a_damping_ratio_of_meshes_without_inertia_leaves_statics_alone(
    torsional_set: Callable[..., dict[str, Any]],
) -> None:
    """No effective mass, no damper; what needs dampers asks for the inertia."""
    data = deepcopy(torsional_set(modal=0.03))
    data["damping"] = {"mesh": 0.05}
    with_inertia = epicyclic.assemble(epicyclic.load(data))
    del data["stages"]["main"]["sun"]["inertia"]
    system = epicyclic.assemble(epicyclic.load(data))
    assert system.missing_inertia == ("stages.main.sun.inertia",)
    assert (with_inertia.meshes.damping > 0).all()
    assert (system.meshes.damping == 0).all()
    mesh_force = static(system, StaticOptions()).mesh_force.values
    np.testing.assert_allclose(mesh_force, static(with_inertia, StaticOptions()).mesh_force.values, rtol=1e-9)
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.inertia: not given"):
        epicyclic.modes(system)
