"""Ripple of torque and motion: closed forms of a two-mass train, SciPy's integration, energy, and other routes."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from epicyclic import sharing, static, steady, sweep, transient
from epicyclic.questions.response.measures import periodic
from epicyclic.statics.tangent import linear
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

# a pair of spur gears on fixed axes: two masses and the spring of the mesh
TEETH, MODULE, J = (20, 40), 3e-3, (2e-3, 3e-2)
R = tuple(z * MODULE / 2 * math.cos(math.radians(20)) for z in TEETH)
K, C = 2e7, 800.0
MOBILITY = R[0] ** 2 / J[0] + R[1] ** 2 / J[1]
NATURAL = math.sqrt(K * MOBILITY) / (2 * math.pi)
ENGINE = 12.0  # speed of the pinion [rev/s]

EXAMPLE = Path(__file__).parents[2] / "examples/models/engine-planetary.toml"


def pair(ripple: Any, *, torque: float = 100.0, speed: float = ENGINE, backlash: bool = False) -> dict[str, Any]:
    """The model of the pair with a ripple by member."""
    mesh = {"stiffness": f"{K} N/m", "damping": f"{C} N s/m", **({"backlash": "40 um"} if backlash else {})}
    members = {
        name: {"teeth": z, "inertia": f"{inertia} kg m^2", "mass": "1 kg"}
        for name, z, inertia in zip(("pinion", "wheel"), TEETH, J, strict=True)
    }
    return {
        "format": 2,
        "title": "pair",
        "stages": {"s": {"module": "3 mm", "face_width": "20 mm", "meshes": {"pinion-wheel": mesh}, **members}},
        "operation": {
            "speed": {"pinion": f"{speed} rev/s"},
            "torque": {"pinion": f"{torque} N m", "wheel": "balance"},
            "ripple": ripple,
        },
    }


def transfer(frequency: float) -> complex:
    """Mesh force per torque of the pinion [1/m] at a frequency [Hz], of two masses in closed form."""
    omega = 2 * math.pi * frequency
    spring = K + 1j * omega * C
    return R[0] / J[0] * spring / (MOBILITY * spring - omega**2)


@pytest.mark.parametrize("of_natural", [0.4, 1.0, 1.9])
@pytest.mark.parametrize("sense", [1, -1])
def test_two_masses_in_closed_form(of_natural: float, sense: int) -> None:
    """Amplitude and phase of the mesh force below, at and above the resonance, turning either way."""
    order, phase = Fraction(13, 2), 0.7
    speed = of_natural * NATURAL / float(order)
    ripple = {"pinion": [{"order": "13/2", "torque": "20 N m", "phase": f"{phase} rad"}]}
    result = steady(pair(ripple, speed=sense * speed))
    at = abs(float(result.line_frequency.item()))
    assert at == pytest.approx(of_natural * NATURAL, rel=1e-6)
    expected = 20.0 * np.exp(1j * phase * sense) * transfer(at)
    found = result.line_force.values[0, 0]
    assert np.abs(found - expected).max() < 1e-6 * abs(expected)
    assert result.mesh_force_bound.item() == pytest.approx(100 / R[0] + abs(expected), rel=1e-6)


def test_the_sweep_follows_the_order() -> None:
    """Over the speed the ripple keeps its order: the line of a sweep is the closed form at every speed."""
    ripple = {"pinion": [{"order": "13/2", "torque": "20 N m"}]}
    speeds = np.array([0.3, 0.7, 1.0, 1.6])
    result = sweep(pair(ripple, speed=NATURAL / 6.5), relative_speed=speeds)
    expected = np.array([20.0 * abs(transfer(value * NATURAL)) for value in speeds])
    assert result.mesh_force_line.values[0, 0] == pytest.approx(expected, rel=1e-6)
    assert result.mesh_force_peak.values[0] == pytest.approx(100 / R[0] + expected, rel=1e-6)


def test_energy_of_a_cycle_balances() -> None:
    """The mean power of the ripple is what the damper of the mesh dissipates."""
    system = assemble(load(pair({"pinion": [{"order": "13/2", "torque": "20 N m", "phase": "30 deg"}]}, speed=70.0)))
    (line,) = periodic(system).lines
    omega = 2 * math.pi * float(line.frequency)
    moved = line.displacement[:, 0]
    power = 0.5 * (20.0 * np.exp(1j * math.pi / 6) * np.conj(1j * omega * moved[rz(system, "s/pinion")])).real
    stretch = system.meshes.B[:, 0] @ moved
    assert power == pytest.approx(0.5 * C * omega**2 * abs(stretch) ** 2, rel=1e-9)
    assert power > 1.0


def rz(system: System, body: str) -> int:
    """Index of the rotation of a body."""
    return system.dofs.names.index(f"{body}/rz")


SHAFTED: dict[str, Any] = {
    "format": 2,
    "title": "engine, planetary set, machine",
    "damping": {"mass": "2 1/s", "stiffness": "2e-5 s"},
    "stages": {
        "main": {
            "planets": 3,
            "module": "2.5 mm",
            "face_width": "30 mm",
            "sun": {"teeth": 26},
            "planet": {"teeth": 25, "bearing": {"radial": "3e8 N/m"}},
            "ring": {"teeth": 76, "rim": "15 mm"},
            "carrier": {"mass": "6 kg", "inertia": "0.025 kg m^2"},
        }
    },
    "bodies": {"engine": {"inertia": "0.12 kg m^2"}, "machine": {"inertia": "4 kg m^2"}},
    "couplings": {
        "damper": {"between": ["engine", "main.sun"], "rz": "3000 N m/rad"},
        "output": {"between": ["main.carrier", "machine"], "rz": "6e4 N m/rad"},
    },
    "operation": {
        "held": ["ring"],
        "speed": {"engine": "1500 rpm"},
        "torque": {"engine": "120 N m", "machine": "balance"},
    },
}


NO_VARIATION = {f"stages.main.meshes.{name}.variation": "none" for name in ("sun-planet", "planet-ring")}


def shafted(ripple: Any, **changes: Any) -> System:
    """The System of the train between two machines with a ripple by member."""
    return assemble(load(SHAFTED, {**changes, "operation.ripple": ripple}))


def test_a_prescribed_motion_is_that_of_its_reaction_torque() -> None:
    """The reaction of a prescribed angle, on the train in which it is free, makes the same motion."""
    order, angle = 2, 1e-3 * np.exp(0.4j)
    prescribed = {"engine": [{"order": order, "angle": "1 mrad", "phase": "0.4 rad"}]}
    driven = shafted(prescribed, **NO_VARIATION)
    assert "engine/rz" not in driven.dofs.names
    (line,) = (line for line in periodic(driven).lines if line.frequency == 50)
    free = shafted({"engine": [{"order": 2, "torque": "1 N m"}]}, **NO_VARIATION)
    motion = np.zeros(len(free.dofs.names), complex)
    for name, value in zip(driven.dofs.names, line.displacement[:, 0], strict=True):
        motion[free.dofs.names.index(name)] = value
    engine = free.dofs.names.index("engine/rz")
    motion[engine] = angle
    omega = 2 * math.pi * 50
    dynamic = free.mean_stiffness + free.Kg + 1j * omega * (free.mean_damping + free.G) - omega**2 * free.M
    left = dynamic @ motion
    assert np.abs(np.delete(left, engine)).max() < 1e-6 * abs(left[engine])
    torque = {"torque": f"{float(abs(left[engine]))!r} N m", "phase": f"{float(np.angle(left[engine]))!r} rad"}
    (again,) = periodic(shafted({"engine": [{"order": 2, **torque}]}, **NO_VARIATION)).lines
    assert np.abs(again.displacement[:, 0] - motion).max() < 1e-6 * np.abs(motion).max()


def test_an_imposed_speed_is_its_angle() -> None:
    """A speed v cos(w t) at f is the angle v / (2 pi f) cos(w t - 90 deg)."""
    speed = f"{2 * math.pi * 50 * 1e-3!r} rad/s"
    a = shafted({"engine": [{"order": 2, "speed": speed}]}).lines
    b = shafted({"engine": [{"order": 2, "angle": "1 mrad", "phase": "-90 deg"}]}).lines
    for one, other in zip(a, b, strict=True):
        assert one.frequency == other.frequency
        assert one.force == pytest.approx(other.force, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("fixed", [{"torque": "20 N m"}, {"angle": "1 mrad"}])
def test_what_follows_the_speed_stays_at_other_speeds_beside_a_fixed_frequency(fixed: dict[str, str]) -> None:
    """Without the ripple whose frequency stays where it is, the lines are those beside one of another frequency."""
    model = pair({"pinion": [{"frequency": f"{ENGINE} Hz", **fixed}], "wheel": [{"order": 1, "torque": "2 N m"}]})
    model["deviations"] = {"s": {"pinion": {"run_out": "10 um"}}}
    whole = assemble(load(model))
    apart = assemble(load(model, {"operation.ripple.pinion": [{"frequency": "99 Hz", **fixed}]}))
    assert (len(whole.lines), len(apart.lines), len(whole.scaling.lines)) == (2, 3, 2)
    for one, other in zip(whole.scaling.lines, apart.scaling.lines, strict=True):
        assert (one.frequency, one.causes) == (other.frequency, other.causes)
        for part in ("gap", "force", "ripple"):
            values = getattr(other, part)
            assert getattr(one, part) == pytest.approx(values, rel=1e-12, abs=1e-15 * np.abs(values).max(initial=0))


def test_what_follows_the_speed_has_the_tangents_of_the_linear_system() -> None:
    """Beside links with a law the lines without the fixed frequency are those of the same train with another one."""
    engine = {
        "stages.main.planet.bearing.clearance": "2 um",
        "deviations.main.planet.run_out": "10 um",
        "case": "loaded",
    }
    ripples = ([{"frequency": f"{hz} Hz", "torque": "20 N m"}] for hz in (41, 43))
    first, other = (
        linear(assemble(load(EXAMPLE, {**engine, "operation.ripple": {"engine": one}}))).scaling for one in ripples
    )
    assert first.groups == ()
    assert [line.link_gap.shape for line in first.lines] == [first.links.stiffness.shape] * len(first.lines) != []
    for one, expected in zip(first.lines, other.lines, strict=True):
        assert one.frequency == expected.frequency
        assert one.link_gap == pytest.approx(expected.link_gap, rel=1e-9, abs=1e-15)


def test_a_table_is_the_sum_of_its_components() -> None:
    """Torques over two turns, of orders 1/2, 2 and 11, become their exact orders, amplitudes and phases."""
    parts = {Fraction(1, 2): (7.0, 0.3), Fraction(2): (30.0, -1.1), Fraction(11): (4.0, 2.0)}
    angles = np.arange(0, 720, 15.0)
    turn = np.radians(angles)
    torques = 120 + sum(a * np.cos(float(order) * turn + phase) for order, (a, phase) in parts.items())
    table = {"angles": f"{angles.tolist()} deg", "torques": f"{torques.tolist()} N m"}
    listed = [
        {"order": str(order), "torque": f"{a} N m", "phase": f"{phase} rad"} for order, (a, phase) in parts.items()
    ]
    by_table, by_order = (
        {line.frequency: line.ripple for line in shafted({"engine": one}).lines if line.ripple.any()}
        for one in ([table], listed)
    )
    assert set(by_table) == set(by_order) == {25 * order for order in parts}
    for frequency, force in by_order.items():
        assert np.abs(by_table[frequency] - force).max() < 1e-9


def test_the_turn_of_another_shaft_counts() -> None:
    """An order of the machine's turn has the frequency of that shaft, exactly."""
    system = shafted({"engine": [{"order": "1/2", "torque": "1 N m", "of": "machine"}]})
    assert [line.frequency for line in system.lines if line.ripple.any()] == [Fraction(25) * 26 / 102 / 2]


def test_statics_is_the_slow_limit_of_the_dynamics() -> None:
    """Slow ripple is balanced by inertia alone: static forces are those of the dynamic response far below all modes."""
    ripple = {"engine": [{"order": "1/25", "torque": "30 N m"}]}
    changes = {"operation.ripple": ripple, "damping.mass": None, **NO_VARIATION}
    slow = sharing(SHAFTED, overrides=changes, method="static", turns=25, of="engine")
    record = static(SHAFTED, overrides=changes, turns=25, of="engine", samples=16)
    (line,) = (line for line in periodic(shafted(ripple, **changes)).lines if line.frequency == 1)
    amplitude = np.abs(line.force[:, 0])
    for result in (slow, record):
        swing = np.ptp(result.mesh_force.transpose("mesh", ...).values.reshape(6, -1), axis=1) / 2
        assert swing == pytest.approx(amplitude, rel=2e-3)
    inertia = 4 + 0.12 * (102 / 26) ** 2
    at_output = 30 * (102 / 26) * 4 / inertia  # the rest turns the engine; gears and carrier have a hundredth
    assert np.ptp(record.link_force.sel(link_row="output/rz").values) / 2 == pytest.approx(at_output, rel=0.02)


def test_sharing_sees_the_ripple() -> None:
    """The largest mesh force of load sharing rises by the force of the ripple in the steady response."""
    ripple = {"operation.ripple": {"engine": [{"order": 2, "torque": "30 N m"}]}}
    still, moving = sharing(SHAFTED, cycles=2), sharing(SHAFTED, cycles=2, overrides=ripple)
    response = steady(SHAFTED, overrides=ripple)
    rise = moving.mesh_force_bound.values - still.mesh_force_bound.values
    assert rise == pytest.approx(response.line_amplitude.values[:, 0], rel=0.05)
    assert rise.min() > 50


def test_motion_in_time_settles_to_the_steady_response() -> None:
    """Of linear contact the last turns of a run swing as the steady response: mesh forces and torque of a coupling."""
    changes: dict[str, Any] = {"operation.ripple": {"engine": [{"order": 2, "torque": "60 N m"}]}}
    changes |= {"damping.modal": "10 %"}
    changes |= {"damping.mass": None, "damping.stiffness": None, **NO_VARIATION}
    response = steady(SHAFTED, overrides=changes)
    run = transient(SHAFTED, overrides=changes, contact="linear", duration=0.6, samples=16)
    late = run.mesh_force.values[:, run.time.values > 0.48]
    bound = response.mesh_force_bound.values  # over all phases, of which a run of six ripples meets some
    assert np.all((late.max(axis=1) < 1.005 * bound) & (late.max(axis=1) > 0.85 * bound))
    assert late.std(axis=1) == pytest.approx(response.mesh_force_rms.values, rel=0.01)
    rows = [str(name) for name in response.link_row.values if str(name).endswith("rz")]
    assert rows == ["damper/rz", "output/rz"]
    expected = response.link_force_factor.sel(link_row=rows).values
    assert run.link_force_factor.sel(link_row=rows).values == pytest.approx(expected, rel=0.01)
    assert expected[0] == pytest.approx(response.link_force_peak.sel(link_row="damper/rz").item() / 120, rel=1e-6)


def unilateral(system: System, time: float, samples: int) -> np.ndarray[Any, Any]:
    """Mesh force (T,) [N] of the pair over the last part of a time [s], by SciPy, with flanks that only press."""
    B, backlash = system.meshes.B[:, 0], float(system.meshes.backlash[0])
    (line,) = (line for line in system.lines if line.frequency)
    omega, inverse = 2 * math.pi * float(line.frequency), np.linalg.inv(system.M)

    def force(stretch: float, rate: float) -> float:
        near = K * stretch + C * rate if stretch > 0 else 0.0
        return near + (K * (stretch + backlash) + C * rate if stretch < -backlash else 0.0)

    def motion(t: float, state: Any) -> Any:
        q, v = state[:2], state[2:]
        load = system.force + (line.force[0] * np.exp(1j * omega * t)).real
        return np.concatenate([v, inverse @ (load - B * force(B @ q, B @ v))])

    start = np.concatenate([np.linalg.pinv(np.outer(B, B) * K) @ system.force, np.zeros(2)])
    times = np.linspace(0.75 * time, time, samples)
    found = solve_ivp(motion, (0, time), start, method="RK45", rtol=1e-7, atol=1e-10, max_step=1e-4, t_eval=times)
    return np.array([force(B @ y[:2], B @ y[2:]) for y in found.y.T])


@pytest.mark.parametrize(("of_natural", "torus"), [(0.7, True), (0.4, False)])
def test_rattle_is_that_of_an_independent_integration(of_natural: float, torus: bool) -> None:
    """Where teeth part and hammer on both flanks, contact loss and the run in time have the forces of SciPy's route.

    At the second speed no torus is solved, and the steady motion is followed in time.
    """
    ripple = {"pinion": [{"order": "13/2", "torque": "20 N m"}]}
    model = pair(ripple, torque=10, speed=of_natural * NATURAL / 6.5, backlash=True)
    system = assemble(load(model))
    assert (len(system.dofs.names), system.far_flanks.B[:, 0].tolist()) == (2, (-system.meshes.B[:, 0]).tolist())
    force = unilateral(system, 0.2, 20001)
    result = steady(model, contact_loss=True)
    assert ("followed in time" in result.status.item()) is not torus
    assert result.mesh_force_bound.item() == pytest.approx(force.max(), rel=0.015)
    assert result.mesh_force_minimum.item() == pytest.approx(force.min(), rel=0.015)
    assert result.mesh_force_rms.item() == pytest.approx(force.std(), rel=0.015)
    assert result.open_share.item() == pytest.approx(np.mean(force == 0), abs=0.03)
    assert result.far_share.item() == pytest.approx(np.mean(force < 0), abs=0.03)
    assert "[teeth-rattle]" in result.attrs["warnings"]
    assert torus or "[contact-lost]" in result.attrs["warnings"]  # of the run in time
    tone = float(system.tones[0])
    swept = sweep(model, contact_loss=True, mesh_frequency=[0.5 * tone, tone]).isel(direction=0, mesh=0, speed=1)
    assert swept.status == ("ok" if torus else "teeth rattle, followed in time")
    assert torus or "teeth rattle at 4 points" in swept.attrs["warnings"]
    assert swept.mesh_force_peak.item() == pytest.approx(force.max(), rel=0.015)
    assert swept.mesh_force_minimum.item() == pytest.approx(force.min(), rel=0.015)
    assert swept.mesh_force_rms.item() == pytest.approx(force.std(), rel=0.015)
    run = transient(model, duration=0.2, samples=64)
    late = run.mesh_force.values[0, run.time.values > 0.15]
    assert late.max() == pytest.approx(force.max(), rel=0.02)
    assert late.std() == pytest.approx(force.std(), rel=0.02)
