"""Sensors of the model file against closed forms of the ring, kinematics by hand, and routes of their own."""

from __future__ import annotations

import tomllib
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic import assemble, load, modulation, plot, static, steady, sweep, transient
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError
from epicyclic.show.elements import sensor_tables
from epicyclic.system.system import Array, System
from epicyclic.train.resolution import resolved_document

TEXT = """
format = 2
title = "Stage with sensors"
damping.modal = 0.03

[stages.main]
planets = 3
module = "4 mm"
meshes.sun-planet = { stiffness = "3e8 N/m", variation = { cosine = [0.1] } }
meshes.planet-ring = { stiffness = "3e8 N/m", variation = { cosine = [0.1, 0.03] } }
sun = { teeth = 27, mass = "6 kg", inertia = "0.01 kg m^2", support.radial = "2e7 N/m" }
planet = { teeth = 24, mass = "4 kg", inertia = "0.006 kg m^2", bearing.radial = "4e8 N/m" }
carrier = { mass = "30 kg", inertia = "0.5 kg m^2", support.radial = "5e8 N/m" }

[stages.main.ring]
teeth = 75
mass = "20 kg"
inertia = "0.6 kg m^2"
support = { radial = "5e8 N/m", rz = "1e8 N m/rad" }
elastic = { radius = "165 mm", bending = "20 kN m^2", modes = 12 }

[bodies.load]
inertia = "5 kg m^2"

[couplings.shaft]
between = ["main.carrier", "load"]
rz = "2e5 N m/rad"

[operation]
held = ["ring"]
speed.sun = "900 rpm"
torque.sun = "500 N m"
torque.load = "balance"

[sensors]
gauge = { kind = "strain", on = "ring", angle = "50 deg", radius = "172 mm" }
out = { kind = "acceleration", on = "ring", angle = "50 deg", radius = "172 mm" }
along = { kind = "acceleration", on = "ring", angle = "50 deg", radius = "172 mm", direction = "tangential" }
turn = { kind = "angle", on = "ring" }
sun = { kind = "torque", on = "sun" }
ring = { kind = "torque", on = "ring" }
carrier = { kind = "torque", on = "carrier" }
shaft = { kind = "torque", link = "shaft" }
"""
TABLES: dict[str, Any] = tomllib.loads(TEXT)
CARRIER = Fraction(900 * 27, 102 * 60)  # [Hz]
MESH = 75 * CARRIER
BEND = "stages.main.ring.elastic"


@pytest.fixture(scope="module")
def system() -> System:
    """The stage."""
    return assemble(load(TABLES))


@pytest.fixture(scope="module")
def response(system: System) -> xr.Dataset:
    """Its steady response."""
    return steady(system)


def waves(result: xr.Dataset, sensor: str, time: Array) -> Array:
    """The lines of a sensor over time (T,) [s]."""
    amplitude = result.sensor_amplitude.sel(sensor=sensor).values
    return np.asarray((np.exp(2j * np.pi * np.outer(time, result.sensor_line_frequency.values)) @ amplitude).real)


def lines(result: xr.Dataset, sensor: str, least: float = 0.0) -> dict[Fraction, complex]:
    """Lines of a sensor by their exact frequency [Hz]."""
    pairs = zip(result.sensor_line.values, result.sensor_amplitude.sel(sensor=sensor).values, strict=True)
    return {Fraction(text): value for text, value in pairs if abs(value) > least}


# --- strain against the ring under N equal loads ---------------------------------------------------------------------


def passing_strain(modes: int, **more: Any) -> tuple[Array, Array, dict[str, float]]:
    """Strain of a gauge as three planets of constant force pass it, its angle from the load behind, and the loads."""
    still = {f"stages.main.meshes.{pair}.variation": "none" for pair in ("sun-planet", "planet-ring")}
    table = {"radius": "165 mm", "bending": "20 kN m^2", "modes": modes, **more}
    train = load(
        TABLES, {**still, BEND: None, "sensors": None} | {BEND: table, "sensors.gauge": TABLES["sensors"]["gauge"]}
    )
    result = static(train, turns=1, of="main.carrier", samples=360)
    mesh = next(one for one in train.meshes if one.internal)
    force = float(result.mesh_force.sel(mesh=mesh.name).mean())
    turned = np.radians(50) - 2 * np.pi * float(CARRIER) * result.time.values
    angle, alpha = np.mod(turned - mesh.direction, 2 * np.pi / 3), mesh.pressure_angle
    loads = {"radial": force * np.sin(alpha), "tangential": mesh.flank * force * np.cos(alpha), "at": mesh.radius_b}
    return result.sensor_signal.sel(sensor="gauge").values, angle, loads


R, EI, OUT = 0.165, 20e3, 0.172


def closed_form(angle: Array, *, radial: float, tangential: float, at: float) -> Array:
    """Strain of an inextensible ring under N loads at a radius, balanced by uniform shear, at angles behind a load.

    By sums over n = N, 2 N, ..: cos(n d)/(n^2 - 1) -> 1/2 - a cos x/(2 sin a), x = a - d, a = pi/N, which is Roark's
    W R/2 (1/a - cos x/sin a) of the moment; its derivative for n sin(n d)/(n^2 - 1); (pi - N d)/2 N for sin(n d)/n.
    """
    a = np.pi / 3
    cosine, sine = 0.5 - a * np.cos(a - angle) / (2 * np.sin(a)), a * np.sin(a - angle) / (2 * np.sin(a))
    saw = (a - angle) / 2
    moment = radial * cosine + tangential * (sine - saw) - tangential * (at - R) / R * saw
    return np.asarray((OUT - R) * R**2 / (OUT * np.pi * EI) * 3 * moment)


def order_sum(angle: Array, modes: int, *, radial: float, tangential: float, at: float) -> Array:
    """The same from the orders up to `modes`."""
    moment = np.zeros_like(angle)
    for n in range(3, modes + 1, 3):
        moment += radial * np.cos(n * angle) / (n**2 - 1) + tangential * np.sin(n * angle) / (n * (n**2 - 1))
        moment -= tangential * (at - R) / (n * R) * np.sin(n * angle)
    return (OUT - R) * R**2 / (OUT * np.pi * EI) * 3 * moment


def test_the_strain_of_passing_planets_is_that_of_a_ring_under_equal_loads() -> None:
    """Every order to rounding; half-way between loads what is left out falls as 1/N^2 towards the closed form."""
    left = []
    for modes in (12, 24, 48):
        strain, angle, loads = passing_strain(modes)
        np.testing.assert_allclose(strain, order_sum(angle, modes, **loads), rtol=0, atol=1e-9 * np.abs(strain).max())
        middle = int(np.abs(angle - np.pi / 3).argmin())
        exact = closed_form(angle, **loads)
        left.append(abs(strain[middle] / exact[middle] - 1))
    assert left[0] < 0.03
    assert left[1] < 0.3 * left[0]
    assert left[2] < 0.3 * left[1]
    # with the orders left out by their formula the closed form itself
    rest = order_sum(angle, 30_000, **loads) - order_sum(angle, 48, **loads)
    between = np.abs(angle - np.pi / 3) < 0.9
    np.testing.assert_allclose((strain + rest)[between], exact[between], rtol=0, atol=1e-4 * np.abs(exact).max())


def test_a_ring_that_stretches_has_the_strain_of_its_mean_tension() -> None:
    """N loads W stretch the ring by N W R/(2 pi E A): over a turn nothing else has a mean; no warning then."""
    strain, _, loads = passing_strain(6, axial="2e8 N")
    assert strain.mean() == pytest.approx(3 * loads["radial"] * R / (2 * np.pi * 2e8 * OUT), rel=1e-6)
    codes = [str(text).rpartition("[")[2] for text in load(TABLES, {f"{BEND}.axial": "2e8 N"}).warnings]
    assert "strain-without-stretch]" not in codes
    assert any("strain-without-stretch" in text for text in load(TABLES).warnings)


# --- lines, accelerations, torques -----------------------------------------------------------------------------------


def test_lines_are_exactly_those_of_passing_planets(response: xr.Dataset) -> None:
    """l f_mesh + k f_carrier, k the orders of the ring that three alike planets make; a ring order shifts both ways."""
    most = 7 * MESH / 2
    orders = [k for k in range(-12, 13) if k and k % 3 == 0]
    expected = {abs(mesh * MESH + k * CARRIER) for mesh in range(4) for k in orders}
    assert {f for f in lines(response, "gauge") if f < most} == expected
    # a run-out of the sun passes planet i with the phase -psi_i: of the waves about the ring those n = 3 j - 1 answer
    run_out = steady(TABLES, overrides={"deviations.sun.run_out": "20 um"})
    sun = Fraction(900, 60) - CARRIER
    further = {abs(sun + k * CARRIER) for k in range(-12, 13) if k % 3 == 1 and abs(k) > 1}
    assert {f for f in lines(run_out, "gauge") if f < MESH / 3} == further | {f for f in expected if f < MESH / 3}


@pytest.mark.parametrize(("member", "centre"), [("ring", 0.0), ("carrier", 0.0), ("planet", 0.102)])
@pytest.mark.parametrize("direction", ["radial", "tangential"])
def test_the_acceleration_of_a_rigid_body_is_that_of_its_point_in_the_housing(
    member: str, centre: float, direction: str
) -> None:
    """z = exp(i W t) (r_c + u) + r exp(i (w t + theta + phi)), twice derived by hand and to the first order.

    At seven tenths of the speed.
    """
    at = {"kind": "acceleration", "on": member, "angle": "20 deg", "radius": "80 mm", "direction": direction}
    changes = {"stages.main.planets": None, BEND: None, "sensors": None}
    uneven = {"stages.main.planet_angles": "[0, 110, 250] deg", "sensors.here": at}
    train = load(TABLES, {**changes, **uneven})
    result = steady(train, relative_speed=0.7)
    W = 0.7 * 2 * np.pi * float(CARRIER)
    turns = {"ring": 0.0, "carrier": W, "planet": W * (1 - 75 / 24)}
    w, theta, r = turns[member], np.radians(20), 0.08
    time = np.linspace(0, 12 / float(CARRIER), 4001)
    harmonic = result.displacement_harmonic
    body = f"main/{member}" + ("/1" if member == "planet" else "")
    omega = 0.7 * 2 * np.pi * float(MESH) * np.arange(harmonic.sizes["harmonic"])

    def motion(dof: str, derivative: int) -> Array:
        name = f"{body}/{dof}"
        if name not in harmonic.dof.values:
            return np.zeros_like(time)
        scale = next(b for b in train.bodies if b.name == body).reference_radius if dof == "rz" else 1.0
        amplitude = (1j * omega) ** derivative * harmonic.sel(dof=name).values / scale
        return np.asarray((np.exp(1j * np.outer(time, omega)) @ amplitude).real)

    u, phi = ([motion("x", d) + 1j * motion("y", d) for d in range(3)], [motion("rz", d) for d in range(3)])
    frame, arm = np.exp(1j * W * time), np.exp(1j * (w * time + theta))
    first = frame * (u[2] + 2j * W * u[1] - W**2 * u[0]) + r * arm * (1j * phi[2] - 2 * w * phi[1] - 1j * w**2 * phi[0])
    nominal = -(W**2) * centre * frame - w**2 * r * arm
    seen = (first - 1j * phi[0] * nominal) / arm
    name = "here/1" if member == "planet" else "here"
    expected = seen.real if direction == "radial" else seen.imag
    np.testing.assert_allclose(waves(result, name, time), expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_the_axial_acceleration_of_a_planet_that_tilts() -> None:
    """z + r (rx sin - ry cos) at the material angle, and the tilt in w^2 r and W^2 r_c, by hand."""
    at = {
        "kind": "acceleration",
        "on": "planet",
        "angle": "20 deg",
        "radius": "40 mm",
        "z": "5 mm",
        "direction": "axial",
    }
    tilting: dict[str, Any] = {"stages.main.helix_angle": "12 deg", "stages.main.face_width": "40 mm"}
    tilting |= {"stages.main.planet.bearing": {"radial": "4e8 N/m", "z": "2e8 N/m", "tilt": "2e5 N m/rad"}}
    tilting |= {"stages.main.planet.tilt_inertia": "0.004 kg m^2", BEND: None, "sensors": None}
    result = steady(load(TABLES, tilting | {"sensors.here": at}))
    W, r = 2 * np.pi * float(CARRIER), 0.04
    w, centre, harmonic = W * (1 - 75 / 24), 0.102 / np.cos(np.radians(12)), result.displacement_harmonic
    count = 8192
    time = np.arange(count) / count * 8 / float(CARRIER)
    omega = 2 * np.pi * float(MESH) * np.arange(harmonic.sizes["harmonic"])
    kept = omega * 8 / float(CARRIER) / 2 / np.pi < count / 2 - 40
    z, rx, ry = (
        (np.exp(1j * np.outer(time, omega[kept])) @ harmonic.sel(dof=f"main/planet/1/{dof}").values[kept]).real
        for dof in ("z", "rx", "ry")
    )
    psi, chi = (w - W) * time + np.radians(20), -(w - W) * time - np.radians(20)
    moved = z + r * (rx * np.sin(psi) - ry * np.cos(psi))
    spectrum = np.fft.rfft(moved) * -((2 * np.pi * np.fft.rfftfreq(count, time[1])) ** 2)
    # nominal acceleration in the axes of the material, and the axis of the sensor e_z + theta x e_z
    a = -(w**2) * r - W**2 * centre * np.exp(1j * chi)
    theta = (rx + 1j * ry) * np.exp(-1j * psi)
    expected = np.fft.irfft(spectrum, count) + a.real * theta.imag - a.imag * theta.real
    seen = waves(result.where(result.sensor_line_frequency < float(MESH) * (kept.sum() - 0.5), 0.0), "here/1", time)
    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_the_acceleration_of_a_ring_that_turns_and_bends() -> None:
    """Of a held carrier: w, v and the turn of the section of every order by hand, which tilts the sensor in w^2 r."""
    star: dict[str, Any] = {
        "operation.held": ["carrier"],
        "operation.torque.load": None,
        "operation.torque.ring": "balance",
    }
    star |= {"couplings": None, "bodies": None, "sensors": None, "stages.main.ring.support.rz": 0}
    at = {"kind": "acceleration", "on": "ring", "angle": "20 deg", "radius": "172 mm", "direction": "tangential"}
    train = load(TABLES, star | {"sensors.here": at})
    result, r = steady(train), 0.172
    turn = -Fraction(900 * 27, 75 * 60)
    w, harmonic, count = 2 * np.pi * float(turn), result.displacement_harmonic, 16384
    time = np.arange(count) / count / float(abs(turn))
    omega = abs(w) * 75 * np.arange(harmonic.sizes["harmonic"])
    radius = next(one.reference_radius for one in train.bodies if one.kind == "ring")

    def motion(dof: str) -> Array:
        return np.asarray((np.exp(1j * np.outer(time, omega)) @ harmonic.sel(dof=f"main/ring/{dof}").values).real)

    psi, tilt = w * time + np.radians(20), motion("rz") / radius
    out = motion("x") * np.cos(psi) + motion("y") * np.sin(psi)
    along = motion("y") * np.cos(psi) - motion("x") * np.sin(psi) + r * tilt
    for n in range(2, 13):
        cosine, sine = motion(f"a{n}"), motion(f"b{n}")
        v = (sine * np.cos(n * psi) - cosine * np.sin(n * psi)) / n
        section = (1 - n**2) * v / R
        out, along = out + cosine * np.cos(n * psi) + sine * np.sin(n * psi), along + v + (r - R) * section
        tilt = tilt + section
    wave = np.fft.fft(out + 1j * along)
    rate = 2j * np.pi * np.fft.fftfreq(count, time[1])
    moved = np.fft.ifft(wave * (rate**2 + 2j * w * rate - w**2)) - 1j * tilt * -(w**2) * r
    np.testing.assert_allclose(waves(result, "here", time), moved.imag, rtol=0, atol=1e-7 * np.abs(moved).max())
    slope = w**2 * r * np.std(tilt)
    assert slope > 1e-5 * np.abs(moved).max()


def test_a_rigid_ring_has_the_acceleration_that_modulation_gives(system: System) -> None:
    """Its own route, from the mean motion of the bodies under the sensor."""
    uneven = {BEND: None, "stages.main.planets": None, "stages.main.planet_angles": "[0, 110, 250] deg"}
    at = {"sensors.gauge": None, "sensors.tilted": TABLES["sensors"]["out"]}
    train = load(TABLES, {**uneven, **at})
    known = lines(steady(train), "along")
    beside = modulation(train, sensor="50 deg", direction="tangential", radius="172 mm", floor=0.0, window="constant")
    for text, value in zip(beside.exact_frequency.values, beside.sensor_acceleration.values, strict=True):
        size = max(map(abs, known.values()))
        assert abs(known.get(Fraction(text), 0.0) - value) < 2e-9 * size


def test_torques_add_up_and_those_of_links_are_their_forces(system: System, response: xr.Dataset) -> None:
    """Teeth do no work in a turn of the whole train, so sun, ring and carrier balance in every line."""
    mean = dict(zip(response.sensor.values, response.sensor_mean.values, strict=True))
    assert mean["sun"] == pytest.approx(500, rel=1e-8)
    assert mean["ring"] == pytest.approx(500 * 75 / 27, rel=1e-8)
    assert mean["shaft"] == pytest.approx(500 * 102 / 27, rel=1e-8)
    total = response.sensor_amplitude.sel(sensor=["sun", "ring", "carrier"])
    assert np.abs(total.sum("sensor")).max() < 1e-8 * np.abs(total).max()
    phase = np.arange(20_000) / 20_000 / float(CARRIER)
    for sensor, rms in zip(response.sensor.values, response.sensor_rms.values, strict=True):
        assert np.std(waves(response, sensor, phase)) == pytest.approx(rms, rel=1e-9)
    row = response.link_force_harmonic.sel(link_row="shaft/rz").values
    known = lines(response, "shaft")
    np.testing.assert_allclose([known[h * MESH] for h in range(4)], row[:4], rtol=1e-12)


# --- static, steady, sweep and transient -----------------------------------------------------------------------------


def test_static_is_steady_at_a_thousandth_of_the_speed(system: System) -> None:
    """Over a turn of the carrier; accelerations are none of a train that turns slowly."""
    still, slow = static(system, turns=1, of="main.carrier", samples=720), steady(system, relative_speed=1e-3)
    assert set(still.sensor.values) == {"gauge", "turn", "sun", "ring", "carrier", "shaft"}
    for sensor in still.sensor.values:
        wave = still.sensor_signal.sel(sensor=sensor).values
        same = waves(slow, sensor, still.time.values * 1e3)
        np.testing.assert_allclose(wave, same, rtol=0, atol=1e-5 * np.abs(wave).max())


def test_transient_is_steady_from_the_steady_state_on(system: System, response: xr.Dataset) -> None:
    """Accelerations are those of the equation of motion there, lines here."""
    omega = 2 * np.pi * float(MESH) * response.harmonic.values
    amplitude = response.displacement_harmonic.values / system.dofs.radius[:, None]
    state = np.stack([amplitude.sum(axis=1), (1j * omega * amplitude).sum(axis=1)]).real
    run = transient(system, initial=state, cycles=4, contact="linear", samples=64)
    for sensor in run.sensor.values:
        wave, same = run.sensor_signal.sel(sensor=sensor).values, waves(response, sensor, run.time.values)
        np.testing.assert_allclose(wave, same, rtol=0, atol=1e-4 * np.abs(same - same.mean()).max(), err_msg=sensor)


def test_a_sweep_has_the_numbers_of_single_speeds(system: System) -> None:
    """RMS and mean; the order gathers its sidebands."""
    both, one = sweep(system, relative_speed=[0.8, 1.1]), steady(system, relative_speed=1.1)
    np.testing.assert_allclose(both.sensor_rms.values[:, 1], one.sensor_rms.values, rtol=1e-3)
    np.testing.assert_allclose(both.sensor_mean.values[:, 1], one.sensor_mean.values, rtol=1e-6, atol=1e-9)
    near = [abs(value) for f, value in lines(one, "out").items() if round(f / MESH) == 3]
    assert both.sensor_order.sel(sensor="out", order=3).values[1] == pytest.approx(np.hypot.reduce(near), rel=1e-3)
    with pytest.raises(KeyError):
        sweep(assemble(load(TABLES, {"sensors": None})), relative_speed=[1.0])["sensor_rms"]


# --- modulation, views -----------------------------------------------------------------------------------------------


def test_modulation_of_a_sensor_is_its_motion_and_says_how_far_the_window_is(
    system: System, response: xr.Dataset
) -> None:
    """Lines of `steady`; the window's are fitted by least squares of their sizes."""
    for sensor, speed, beside in (("gauge", 1.0, response), ("along", 0.8, steady(system, relative_speed=0.8))):
        result = modulation(system, sensor=sensor, floor=0.0, mean_load=True, relative_speed=speed)
        known = {f: value for f, value in lines(beside, sensor).items() if f}
        found = {
            Fraction(f): v for f, v in zip(result.exact_frequency.values, result.signal_amplitude.values, strict=True)
        }
        size = max(map(abs, known.values()))
        assert all(abs(found[f] - value) < 1e-9 * size for f, value in known.items())
        assert all(abs(value) < 2e-9 * size for f, value in found.items() if f not in known)
        a, b = np.abs(result.signal_amplitude.values), np.abs(result.window_amplitude.values)
        assert a @ b == pytest.approx(b @ b)
        assert float(result.window_difference) == pytest.approx(np.sqrt(1 - (a @ b) ** 2 / (a @ a) / (b @ b)))
    assert result.signal_amplitude.attrs["units"] == "m/s2"
    assert "window_difference" not in modulation(system, sensor="50 deg")
    with pytest.raises(ModelError, match=r"sensor = sun: no such sensor of strain.*gauge, out, along"):
        modulation(system, sensor="sun")
    with pytest.raises(ModelError, match=r"sensor = gag: .*or a sensor of the model: gauge"):
        modulation(system, sensor="gag")
    with pytest.raises(ModelError, match="body = main/ring: is that of the sensor gauge"):
        modulation(system, sensor="gauge", body="main/ring")


def test_tables_and_figures_show_every_sensor_in_its_unit(system: System, response: xr.Dataset) -> None:
    """Strain in millionths; a panel a unit."""
    for result in (response, sweep(system, relative_speed=[0.5, 1.0])):
        (table,) = sensor_tables(result)
        assert table.columns["sensor"] == list(result.sensor.values)
        assert table.columns["unit"] == ["µm/m", "m/s²", "m/s²", "µrad", *["N m"] * 4]
        drawn = plot("sensors", result)
        assert {trace.name for trace in drawn.data if trace.name} == set(result.sensor.values)
    (table,) = sensor_tables(response)
    assert table.columns["RMS of what varies"][0] == pytest.approx(1e6 * float(response.sensor_rms[0]))


# --- the model file --------------------------------------------------------------------------------------------------


def test_a_member_of_several_bodies_has_a_sensor_on_each(system: System) -> None:
    """With the branch behind the name; the radius is that of the body, and a written file has the same sensors."""
    train = load(TABLES, {"sensors.pin": {"kind": "angle", "on": "planet"}, "sensors.out.radius": None})
    assert [one.name for one in train.sensors if one.kind == "angle"] == ["turn", "pin/1", "pin/2", "pin/3"]
    high = {"kind": "acceleration", "on": "load", "z": "10 mm"}
    places = load(TABLES, {"bodies.load.station": "0.2 m", "sensors.high": high}).sensors
    placed = next(one for one in places if one.name == "high")
    assert placed.z == pytest.approx(0.01)
    assert placed.radius == 0
    ring = next(body for body in train.bodies if body.kind == "ring")
    assert next(one for one in train.sensors if one.name == "out").radius == ring.reference_radius
    again = load(tomllib.loads(model_text(resolved_document(train))))
    assert again.sensors == train.sensors


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"on": "rng"}, r"sensors.gauge.on = rng: no such member; did you mean 'ring'\?"),
        (
            {"on": "sun"},
            "sensors.gauge.on = main.sun: main/sun is rigid: it has no strain; allowed: a ring with elastic",
        ),
        (
            {"on": None, "kind": "angle", "angle": None, "radius": None},
            "sensors.gauge.*sits on nothing; allowed: a member",
        ),
        ({"kind": "angle"}, "angle is no key of a sensor of angle; allowed: kind, on"),
        (
            {"radius": None},
            "sensors.gauge.radius: the outer radius of the ring is not known; allowed: a radius, or rim",
        ),
        (
            {"on": "load", "kind": "torque", "angle": None, "radius": None},
            "sensors.gauge.on = load: no teeth on it, nor on what it carries; allowed: a gear or carrier",
        ),
        ({"kind": "pressure"}, "sensors.gauge.kind = pressure"),
        ({"angle": "5 mm"}, "sensors.gauge.angle = 5 mm"),
    ],
)
def test_wrong_sensors_are_refused_with_what_is_allowed(changes: dict[str, Any], message: str) -> None:
    """Path, what was given, what is allowed."""
    with pytest.raises(ModelError, match=message):
        load(TABLES, {f"sensors.gauge.{key}": value for key, value in changes.items()})


@pytest.mark.parametrize(
    ("link", "message"),
    [
        ("shafts", "sensors.shaft.link = shafts: no such link; allowed: .*shaft"),
        ("main.sun.support", "sensors.shaft.link = main.sun.support: the link is free about z"),
    ],
)
def test_a_torque_is_of_a_link_that_twists(link: str, message: str) -> None:
    """Else no spring tells it."""
    with pytest.raises(ModelError, match=message):
        load(TABLES, {"sensors.shaft.link": link})


def test_what_is_no_place_of_a_sensor_is_refused() -> None:
    ring = {"stages.main.ring.rim": "14 mm", "stages.main.ring.elastic": True}
    for keys, words in (
        ({"kind": "strain", "on": "ring", "radius": "10 mm"}, "sensors.a.radius = .*: not on the ring"),
        ({"kind": "strain", "on": "ring", "radius": "10 m"}, "sensors.a.radius = .*: not on the ring"),
        ({"kind": "angle", "on": "ring.left"}, "sensors.a.on = main.ring.left: no such body"),
    ):
        with pytest.raises(ModelError, match=words):
            load("industrial-stage", ring | {"sensors.a": keys})


def test_accelerometer_along_an_axis_that_is_held_reads_nothing() -> None:
    sensors = {"sensors.a": {"kind": "acceleration", "on": "sun", "direction": "axial"}}
    train = load("industrial-stage", sensors)
    found = steady(train)
    assert found.sensor_rms.values.tolist() == [0.0]


def test_modulation_on_a_ring_that_turns_names_the_sensor() -> None:
    star = TEXT.replace('held = ["ring"]', 'held = ["carrier"]').replace(
        'torque.load = "balance"', 'torque.ring = "balance"'
    )
    star = star.replace(', rz = "1e8 N m/rad" }', ', rz = "0 N m/rad" }')
    with pytest.raises(ModelError, match=r"sensor = gauge: main/ring turns at .*: no sensor stands still on it"):
        modulation(load(tomllib.loads(star)), sensor="gauge")


# --- forces of bolts -------------------------------------------------------------------------------------------------

BOLTS: dict[str, Any] = {
    "stages.main.ring.support": {
        "radial": "0 N/m",
        "rz": "0 N m/rad",
        "bolts": {"count": 10, "radius": "172 mm", "radial": "4e7 N/m", "tangential": "6e7 N/m", "z": "2e7 N/m"},
    },
    f"{BEND}.modes": 4,
    "stages.main.ring.tilt_inertia": "0.3 kg m^2",
    "sensors": {
        f"{d}": {"kind": "force", "link": "main.ring.support.bolts", "direction": d} for d in ("radial", "tangential")
    },
}


def test_forces_of_bolts_that_stand_are_those_of_their_links() -> None:
    """Nothing turns past the bolts where the train stands: each sensor has the spring force of its link."""
    still = {"operation.speed": {"sun": "0 rpm"}, "operation.torque": {"sun": "500 N m", "load": "balance"}}
    result = static(load(TABLES, BOLTS | still), samples=4)
    for direction, part in (("radial", "x"), ("tangential", "y")):
        for number in range(1, 11):
            signal = result.sensor_signal.sel(sensor=f"{direction}/{number}").values
            link = result.link_force.sel(link_row=f"main/ring/support/bolts/{number}/{part}").values
            assert np.abs(signal).max() > 1.0
            np.testing.assert_allclose(np.abs(signal), np.abs(link), rtol=1e-9)


def test_bolts_that_planets_pass_hold_the_ring() -> None:
    """Over the tone their forces balance the ring: no resultant, and the torque of the planets in the mean."""
    train = load(TABLES, BOLTS | {f"{BEND}.modes": 6})  # a tone of 10 bolts: 10 < 2 x 6
    result = steady(train)
    time = np.linspace(0.0, 0.2, 41)
    out, along = (
        np.array([waves(result, f"{direction}/{number}", time) for number in range(1, 11)])
        for direction in ("radial", "tangential")
    )
    mean = result.sensor_mean.sel(sensor=[f"tangential/{n}" for n in range(1, 11)]).values
    assert 0.172 * mean.sum() == pytest.approx(-500 * 75 / 27, rel=1e-6)
    np.testing.assert_allclose(mean, mean[0], rtol=1e-6)
    assert np.ptp(out[0]) > 0.2 * np.abs(out).max()
    # what planets of constant force make reaches bolt 2 a tenth of a turn of the carrier later than bolt 1
    first, second = (lines(result, f"radial/{number}") for number in (1, 2))
    passing = [f for f in first if 0 < f < MESH / 2 and (f / CARRIER) % 3 == 0]
    assert len(passing) > 3
    for f in passing:
        later = first[f] * np.exp(-2j * np.pi * float(f / CARRIER) / 10)
        assert second[f] == pytest.approx(later, rel=1e-6, abs=1e-6 * np.abs(out).max())
    beside = modulation(train, sensor="radial/1", floor=0.0)
    found = dict(zip(map(Fraction, beside.exact_frequency.values), beside.signal_amplitude.values, strict=True))
    assert all(found[f] == pytest.approx(first[f], rel=1e-6) for f in passing)
    assert np.abs(along).max() > abs(mean[0])


@pytest.mark.parametrize(
    ("table", "more", "message"),
    [
        ({"link": "main.ring.support"}, {}, "no such bolts in the housing"),
        ({"link": "main.ring.support.bolts.11"}, {}, r"bolts\.1 to \.10"),
        ({"link": "main.ring.support.bolts", "direction": "axial"}, {"axial": "inf"}, "no linear axial spring"),
        (
            {"link": "main.ring.support.bolts"},
            {"deviations.ring.position.x": "20 um"},
            "the seat of the bolts is displaced",
        ),
        ({"on": "ring"}, {}, "on is no key of a sensor of force"),
        ({}, {}, "sits on nothing"),
    ],
)
def test_forces_of_no_bolts_are_refused(table: dict[str, Any], more: dict[str, Any], message: str) -> None:
    still: dict[str, Any] = {"operation.speed": {"sun": "0 rpm"}, "operation.torque.load": "balance"}
    of_bolts = BOLTS | still | {"sensors": {"bolt": {"kind": "force", **table}}}
    if "axial" in more:
        support = BOLTS["stages.main.ring.support"]
        of_bolts["stages.main.ring.support"] = support | {"bolts": support["bolts"] | {"z": more["axial"]}}
    else:
        of_bolts |= more
    with pytest.raises(ModelError, match=message) as error:
        load(TABLES, of_bolts)
    assert error.value.path.startswith("sensors.bolt")


def test_a_sensor_of_force_stands_where_its_bolt_does() -> None:
    """Bolt 3 of ten: 72 deg, on the pitch circle, out of the middle of the ring."""
    support = BOLTS["stages.main.ring.support"] | {"at": "20 mm"}
    table = {"bolt": {"kind": "force", "link": "main.ring.support.bolts.3", "direction": "tangential"}}
    train = load(TABLES, BOLTS | {"stages.main.ring.support": support, "sensors": table})
    (bolt,) = [sensor for sensor in train.sensors if sensor.kind == "force"]
    assert (bolt.angle, bolt.radius, bolt.z) == pytest.approx((np.radians(72), 0.172, 0.02))
    assert (bolt.stiffness, bolt.link) == (6e7, "main/ring/support/bolts/3")


def test_bolts_to_another_body_have_no_sensor() -> None:
    arm = {"mass": "40 kg", "inertia": "2 kg m^2", "tilt_inertia": "1 kg m^2", "support": {"radial": "2e8 N/m"}}
    joined = {
        "stages.main.ring.support": BOLTS["stages.main.ring.support"] | {"to": "arm"},
        "bodies.arm": arm,
        "operation.held": ["ring", "arm"],
    }
    table = {"bolt": {"kind": "force", "link": "main.ring.support.bolts"}}
    with pytest.raises(ModelError, match=r"sensors.bolt.link = .*: the bolts join arm; allowed: bolts in the housing"):
        load(TABLES, BOLTS | joined | {"sensors": table})
