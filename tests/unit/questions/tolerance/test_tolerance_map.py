"""The map from tolerances to load sharing: closed forms, full static solves, refusals."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm

import epicyclic
from epicyclic import load
from epicyclic.errors import ModelError
from epicyclic.questions.sharing import SharingOptions
from epicyclic.questions.sharing.sharing import sharing
from epicyclic.questions.tolerance.tolerance_map import SAMPLES, ToleranceMap, tolerance_map
from epicyclic.show.console import warnings_of
from epicyclic.statics import load_map, sample_loads
from epicyclic.statics.record import excitation
from epicyclic.statics.sample_loads import SampleLoads, mean_loads, net_forces
from epicyclic.statics.static import held_train, settled
from epicyclic.system.assembly import assemble
from epicyclic.system.gaps import net_force
from epicyclic.system.system import System
from epicyclic.train.new_train import new_train

Array = NDArray[np.float64]

ALPHA = math.radians(20)
BASE = 0.5 * 4e-3 * math.cos(ALPHA)  # base radius per tooth [m]
K_SUN, K_RING, K_PIN = 9.206e8, 1.2634e9, 4e8
SIGMA = 20e-6
PATH = 1 / (1 / K_SUN + 1 / K_RING + 4 * math.cos(ALPHA) ** 2 / K_PIN)
PIN = {"deviations.main.planet.position.y": "normal(0 um, 20 um)"}


def spur(n: int, tolerance: dict[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    """A spur set of n planets whose sun floats, ring and carrier without freedom but turning."""
    teeth = (24, 24, 72) if n <= 5 else (72, 24, 120)
    return {
        "format": 2,
        "title": "floating sun",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": n,
                "module": "4 mm",
                "face_width": "40 mm",
                "sun": {"teeth": teeth[0], "support": {"radial": "0 N/m"}},
                "planet": {"teeth": teeth[1], "bearing": {"radial": f"{K_PIN} N/m"}},
                "ring": {"teeth": teeth[2]},
                "carrier": {},
                "meshes": {"sun-planet": {"stiffness": f"{K_SUN} N/m"}, "planet-ring": {"stiffness": f"{K_RING} N/m"}},
            }
        },
        "operation": {"held": ["ring"], "torque": {"sun": "800 N m"}},
        "tolerance": PIN if tolerance is None else tolerance,
        **more,
    }


def mean_force(n: int) -> float:
    """F_0 of a mesh [N]."""
    return 800 / (n * BASE * (24 if n <= 5 else 72))


def of_pins(given: ToleranceMap, errors: Any) -> SampleLoads:
    """Load sharing at given pin errors (S, n) [m], normal ones inverted at a spread of their size."""
    sigma = np.abs(errors).max()
    return given.evaluate(norm.cdf(np.atleast_2d(errors) / sigma), scale=[sigma / SIGMA])


def one_pin(n: int, size: float) -> Array:
    errors = np.zeros(n)
    errors[0] = size
    return errors


# closed forms of a floating sun ---------------------------------------------------------------------------------------


def test_the_check_case_of_four_planets() -> None:
    found = of_pins(tolerance_map(load(spur(4))), one_pin(4, SIGMA))
    gap = 2 * math.cos(ALPHA) * SIGMA
    expected = 1 + PATH * gap / mean_force(4) / 4
    assert expected == pytest.approx(1.19791, abs=5e-6)  # its base radius is 45.1 mm, not 45.105
    np.testing.assert_allclose(found.k, expected, rtol=1e-9)
    # pins opposite to each other carry more, their neighbours less; the ring mesh of a planet as much as its sun mesh
    np.testing.assert_allclose(found.load[0, 0], np.tile(1 + (expected - 1) * np.array([-1, 1, -1, 1]), 2), rtol=1e-9)


@pytest.mark.parametrize(
    ("n", "full_ahead", "full_behind"),
    [(3, 1, 1), (4, 2, 2), (5, math.sqrt(5), 1 + 0.8090170), (6, 3, 5 / 3), (7, None, None)],
)
def test_slopes_and_saturation_of_one_pin(n: int, full_ahead: float | None, full_behind: float | None) -> None:
    ahead, behind = 1 - 3 / n, (1 + 2 * math.cos(2 * math.pi / n)) / n
    given = tolerance_map(load(spur(n)))
    small = 1e-6
    X = PATH * 2 * math.cos(ALPHA) * small / mean_force(n)
    found, far = (of_pins(given, [one_pin(n, -size), one_pin(n, size)]) for size in (small, 3e-4))
    slopes = (found.k[:, 0, 0] - 1) / X
    np.testing.assert_allclose(np.sort(slopes), np.sort([ahead, behind]), rtol=2e-4, atol=1e-9)
    if full_ahead is not None and full_behind is not None:
        np.testing.assert_allclose(np.sort(far.k[:, 0, 0]), np.sort([full_ahead, full_behind]), rtol=1e-6, atol=1e-9)
        assert not found.open.any()
        assert (far.open == (n > 3)).all()  # of three planets nothing opens
    assert not found.failed.any()
    assert not far.failed.any()


@pytest.mark.parametrize(
    ("n", "mean", "sd", "quantiles"),
    [
        (4, 0.399, 0.302, (0.337, 0.980, 1.288)),
        (5, 0.741, 0.391, (0.694, 1.456, 1.816)),
        (6, 0.924, 0.417, (0.877, 1.682, 2.071)),
    ],
)
def test_gaussian_pins(n: int, mean: float, sd: float, quantiles: tuple[float, ...]) -> None:
    size = mean_force(n) / PATH / (2 * math.cos(ALPHA))  # sigma of a unit X
    given = tolerance_map(load(spur(n, {"deviations.main.planet.position.y": f"normal(0 um, {size * 1e6!r} um)"})))
    u = np.random.default_rng(7).random((2 * SAMPLES, n))
    found = given.evaluate(u, method="linear").k[:, 0, 0] - 1
    # four standard errors of 16384 samples
    assert found.mean() == pytest.approx(mean, abs=4 * sd / 128 + 5e-4)
    assert found.std() == pytest.approx(sd, rel=0.04)
    np.testing.assert_allclose(np.quantile(found, (0.5, 0.95, 0.99)), quantiles, rtol=0.05)
    # the same samples by the projection of the gaps
    psi = 2 * np.pi * np.arange(n) / n
    D = np.array([np.ones(n), np.cos(psi), np.sin(psi)])
    X = norm.ppf(u)
    exact = (X @ (np.eye(n) - np.linalg.pinv(D) @ D)).max(axis=1)
    low = -(X @ (np.eye(n) - np.linalg.pinv(D) @ D)).min(axis=1)
    assert min(np.abs(found - exact).max(), np.abs(found - low).max()) < 1e-9


def test_separation_of_four_planets() -> None:
    given = tolerance_map(load(spur(4)))
    x = 1.5
    size = x * mean_force(4) / PATH / (2 * math.cos(ALPHA)) / SIGMA
    u = np.random.default_rng(3).random((2 * SAMPLES, 4))
    found = given.evaluate(u, scale=[size])
    expected = 2 * norm.cdf(-2 / x)
    opened = (found.least[:, :4] <= 0).any(axis=1)
    np.testing.assert_array_equal(opened, found.open)
    assert opened.mean() == pytest.approx(expected, abs=4 * math.sqrt(expected / (2 * SAMPLES)))


def test_a_fixed_sun_has_the_slope_of_one_branch() -> None:
    model = spur(4)
    del model["stages"]["main"]["sun"]["support"]
    found = of_pins(tolerance_map(load(model)), [one_pin(4, 1e-6), one_pin(4, -1e-6)])
    X = PATH * 2 * math.cos(ALPHA) * 1e-6 / mean_force(4)
    assert found.k[:, 0, 0].max() == pytest.approx(1 + X * (1 - 1 / 4), rel=1e-9)


@pytest.mark.parametrize("phase", ["marked", "random"])
def test_equal_run_outs_of_planets_at_one_phase_are_shared(phase: str) -> None:
    """Equal planets placed alike, and a sun that floats: its run-out is followed without force."""
    tolerance = {
        "deviations.main.sun.run_out": "rayleigh(10 um)",
        "deviations.main.planet.run_out": {"own": "rayleigh(10 um)", "phase": phase},
    }
    turning = {"held": ["ring"], "torque": {"sun": "800 N m"}, "speed": {"sun": "1500 rpm"}}
    given = tolerance_map(load(spur(4, tolerance, operation=turning)))
    u = np.random.default_rng(2).random((50, 10))
    u[:, 2:] = np.tile(u[:, 2:4], 4)
    if phase == "marked":
        u[:, 3::2] = np.random.default_rng(3).random((50, 4))[:, : u[:, 3::2].shape[1]]
        u[:, 1] = 0.3
    np.testing.assert_allclose(given.evaluate(u).k, 1, rtol=1e-9)
    u[:, 2] *= 0.5
    assert given.evaluate(u).k[:, 1].max() > 1.001


# against full static solves -------------------------------------------------------------------------------------------

REN = {
    "deviations.main.sun.run_out": "rayleigh(15 um)",
    "deviations.main.planet.run_out": "rayleigh(15 um)",
    "deviations.main.planet.bearing_run_out": {"own": "rayleigh(4 um)", "common": "disc(10 um)"},
    "deviations.main.ring.run_out": "rayleigh(20 um)",
    "deviations.main.planet.position.y": "normal(2 um, 30 um)",
    "deviations.main.planet.position.x": "uniform(-20 um, 20 um)",
    "deviations.main.carrier.run_out": "rayleigh(8 um)",
    "deviations.main.meshes.sun-planet.gap": "normal(0 um, 10 um)",
    "operation.torque.main.sun": "normal(100 kN m, 5 kN m)",
    "stages.main.planet.bearing.radial": "normal(1e9 N/m, 5e7 N/m)",
    "stages.main.sun.support.radial": "truncated(1e9 N/m, 2e8 N/m, 3e8 N/m, 2e9 N/m)",
}


def ren(**torque: str) -> dict[str, Any]:
    """The ready drive with tolerances of every kind."""
    model = dict(load("ren2021", overrides={f"operation.torque.{k}": v for k, v in torque.items()}).document)
    tolerance = dict(REN)
    if torque:
        tolerance["operation.torque.main.sun"] = f"normal({torque['main.sun']}, 0.1 kN m)"
    model["tolerance"] = tolerance
    return model


def even(system: System) -> System:
    """The same with the mean mesh stiffness, without lines at mesh orders."""
    lines = tuple(line for line in system.lines if line.frequency not in system.tones)
    meshes = replace(system.meshes, variation=np.zeros_like(system.meshes.variation))
    return replace(system, meshes=meshes, lines=lines)


def forces_at(system: System, index: NDArray[np.int64]) -> Array:
    """Net forces (T, m) [N] of the full static solution at instants index / (64 tone)."""
    here = excitation(system, system.tones[0], index, 64)
    state = settled(held_train(system), here)
    far = system.far_flanks.mesh[: state.far_force.shape[1]]
    return net_force(np.hstack([state.mesh_force, state.far_force]), far)


@pytest.mark.parametrize(("torque", "count", "tolerance"), [("100 kN m", 12, 1e-9), ("3 kN m", 12, 1e-6)])
def test_samples_of_ren2021_are_full_static_solutions(torque: str, count: int, tolerance: float) -> None:
    model = ren(**{"main.sun": torque})
    given = tolerance_map(load(model))
    u = np.random.default_rng(11).random((count, len(given.dimension_entry)))
    factors, stiffness = given.factors(u, [1.0] * len(given.entries))
    still, turning = given.load_map.stretch.values(factors)
    index = np.array([0, 3917, 70_011, 1_000_003])
    values = given.evaluate(u)
    opened, bare = 0, {name: value for name, value in model.items() if name not in ("tolerance", "assumed")}
    for sample in range(count):
        system = even(assemble(load(bare, overrides=given.overrides(u[sample]))))
        time = index / 64 / float(system.tones[0])
        unit = np.exp(2j * np.pi * np.multiply.outer(time, [float(f) for f in given.load_map.stretch.frequency]))
        closed = still[sample] + (unit @ turning[:, sample]).real
        own = np.tile(stiffness[sample], (len(index), 1))
        net, found = net_forces(given.load_map, closed, given.rows, own)
        expected = forces_at(system, index)
        assert found.all()
        np.testing.assert_allclose(net, expected, rtol=tolerance, atol=tolerance * np.abs(expected).max())
        opened += bool((expected <= 0).any())
        assert values.open[sample] or not (expected <= 0).any()
        # bounds of all phases hold those at any
        shares = 3 * expected[:, :3:2] / expected[:, [0, 2, 4]].sum(axis=1, keepdims=True)
        assert values.k[sample, 1, 0] >= shares.max() * (1 - 1e-9)
    assert (opened > count // 4) == (torque == "3 kN m")


@pytest.mark.parametrize(("n", "backlash"), [(4, None), (5, None), (3, "8 um"), (5, "8 um")])
def test_open_teeth_and_far_flanks_at_standstill(n: int, backlash: str | None) -> None:
    tolerance = {
        "deviations.main.planet.position.y": "normal(0 um, 60 um)",
        "deviations.main.meshes.sun-planet.gap": "normal(0 um, 30 um)",
    }
    model = spur(n, tolerance)
    for mesh in model["stages"]["main"]["meshes"].values():
        mesh |= {} if backlash is None else {"backlash": backlash}
    given = tolerance_map(load(model))
    u = np.random.default_rng(n).random((25, 2 * n))
    found = given.evaluate(u)
    assert not found.failed.any()
    del model["tolerance"]
    pushed = 0
    for sample in range(0, len(u), 2):
        full = epicyclic.static(model, overrides=given.overrides(u[sample]))
        force = full.mesh_force.values.reshape(2, n, -1)[:, :, 0]
        share = n * force / force.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(found.load[sample, 0], share.ravel(), rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(found.least[sample], force.ravel(), atol=1e-6 * np.abs(force).max())
        lost = bool((force <= 0).any())
        assert found.open[sample] == lost or (backlash is not None and not lost)  # tight: both flanks press
        pushed += bool((force < 0).any())
    assert found.open.sum() > 10
    assert (pushed > 0) == (backlash is not None)


LAWFUL = {
    "sun": {"teeth": 24, "support": {"radial": "1e8 N/m", "clearance": "8 um"}},
    "ring": {"teeth": 72, "support": {"radial": "2e8 N/m", "clearance": "15 um"}},
}


def test_links_with_play_are_asked_at_every_sample() -> None:
    tolerance = {**PIN, "operation.torque.main.sun": "normal(800 N m, 50 N m)"}
    tolerance["stages.main.meshes.sun-planet.stiffness"] = "normal(9.206e8 N/m, 5e7 N/m)"
    model = spur(4, tolerance)
    model["stages"]["main"] |= LAWFUL
    given = tolerance_map(load(model))
    u = np.random.default_rng(9).random((12, len(given.dimension_entry)))
    found, tangents = given.evaluate(u), given.evaluate(u, method="linear")
    assert not found.failed.any()
    del model["tolerance"]
    for sample in range(len(u)):
        force = epicyclic.static(model, overrides=given.overrides(u[sample])).mesh_force.values.reshape(2, 4, -1)
        share = 4 * force[:, :, 0] / force[:, :, 0].sum(axis=1, keepdims=True)
        np.testing.assert_allclose(found.load[sample, 0], share.ravel(), rtol=1e-6)
    assert np.abs(found.k - tangents.k).max() > 1e-3


def test_what_laws_do_not_allow_is_refused() -> None:
    model = spur(4, {**PIN, "stages.main.planet.bearing.radial": "normal(4e8 N/m, 1e7 N/m)"})
    model["stages"]["main"] |= LAWFUL
    given = tolerance_map(load(model))
    u = np.full((1, len(given.dimension_entry)), 0.4)
    with pytest.raises(ModelError, match="another has play") as raised:
        given.evaluate(u)
    assert raised.value.allowed == "linear"
    assert np.isfinite(given.evaluate(u, method="linear").k).all()
    curved = {"radial": "1e8 N/m", "clearance": "8 um", "exponent": 1.2, "load": "500 N"}
    model["stages"]["main"]["sun"] = {"teeth": 24, "support": curved}
    model["tolerance"] = {**PIN, "stages.main.sun.support.exponent": "normal(1.2, 0.01)"}
    with pytest.raises(ModelError, match="more than torques and stiffnesses"):
        tolerance_map(load(model))


def test_tables_are_asked_by_method_static_alone() -> None:
    model = spur(4, {"deviations.main.planet.position.y": "normal(0 um, 3 um)"})
    for mesh in model["stages"]["main"]["meshes"].values():
        mesh["stiffness"] = "contact"
    given = tolerance_map(load(model))
    assert any("tangent" in warning for warning in given.warnings)
    u = np.full((1, 4), 0.5)
    u[0, 0] = 0.9
    tangent, asked = given.evaluate(u), given.evaluate(u, method="static")
    assert 1.01 < tangent.k[0, 0, 0] < 1.5
    # a table grows stiffer with the load: near its tangent, and not on it
    assert asked.k[0, 0, 0] == pytest.approx(tangent.k[0, 0, 0], rel=0.05)
    assert abs(asked.k[0, 0, 0] - tangent.k[0, 0, 0]) > 1e-5
    full = epicyclic.sharing(
        {k: v for k, v in model.items() if k != "tolerance"},
        overrides=given.overrides(u[0]),
        method="static",
        samples=16,
    )
    force = full.mesh_force_mean.values.reshape(2, 4)
    np.testing.assert_allclose(asked.load[0, 0], (4 * force / force.sum(axis=1, keepdims=True)).ravel(), rtol=1e-6)


def test_a_drawn_torque_leaves_the_gaps_of_tabulated_meshes() -> None:
    """Without a speed the mean of a table is a line at rest, which would follow the torque."""
    model = spur(4, {**PIN, "operation.torque.main.sun": "normal(800 N m, 50 N m)"})
    for mesh in model["stages"]["main"]["meshes"].values():
        mesh["stiffness"] = "contact"
    (moved,) = tolerance_map(load(model)).moved
    assert moved.column >= 0
    assert not moved.slope.any()


@pytest.mark.parametrize("torque", ["100 kN m", "3 kN m"])
def test_overrides_reproduce_a_sample(torque: str) -> None:
    model = ren(**{"main.sun": torque})
    given = tolerance_map(load(model))
    u = np.random.default_rng(5).random((2, len(given.dimension_entry)))
    values = given.evaluate(u, dense=True)  # as of one train
    system = assemble(load(model, overrides=given.overrides(u[1])))
    found = sharing(system, SharingOptions(method="static", cycles=1, samples=9)).load_sharing
    by_hand = found.sel(definition=["mean-load", "mean-load-turning"]).values
    np.testing.assert_allclose(by_hand, values.load[1], rtol=1e-9, atol=1e-9)


def test_closed_contact_solved_phase_by_phase_is_the_same() -> None:
    given = tolerance_map(load(ren()))
    u = np.random.default_rng(6).random((8, len(given.dimension_entry)))
    whole, each = given.evaluate(u), given.evaluate(u, method="static")
    assert not whole.open.any()
    np.testing.assert_allclose(each.k, whole.k, rtol=1e-12)
    np.testing.assert_allclose(each.least, whole.least, rtol=1e-12)


def test_a_piece_has_the_same_bits_whatever_else_is_evaluated() -> None:
    given = tolerance_map(load(ren()))
    u = np.random.default_rng(5).random((SAMPLES + 7, len(given.dimension_entry)))
    whole, first = given.evaluate(u), given.evaluate(u[:SAMPLES])
    alone = pickle.loads(pickle.dumps(given)).evaluate(u[SAMPLES:])
    np.testing.assert_array_equal(whole.k[:SAMPLES], first.k)
    np.testing.assert_array_equal(whole.k[SAMPLES:], alone.k)
    np.testing.assert_array_equal(whole.least[SAMPLES:], alone.least)


def test_scale_and_torque_and_other_entries() -> None:
    given = tolerance_map(load(spur(4)))
    u = np.random.default_rng(5).random((20, 4))
    one, two = (given.evaluate(u, scale=[s], method="linear").k[:, 0, 0] - 1 for s in (1, 2))
    np.testing.assert_allclose(two, 2 * one, rtol=1e-9)
    half = given.evaluate(u, torque=0.5, method="linear").k[:, 0, 0] - 1
    np.testing.assert_allclose(half, 2 * one, rtol=1e-9)
    wide = tolerance_map(load(spur(4, {"deviations.main.planet.position.y": "normal(0 um, 40 um)"})))
    other = given.with_entries(wide.entries).evaluate(u, method="linear").k[:, 0, 0] - 1
    np.testing.assert_allclose(other, 2 * one, rtol=1e-9)
    with pytest.raises(ModelError, match="method = 'guess'"):
        epicyclic.tolerance("ren2021", method="guess")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("u", "scale", "path"),
    [
        (np.full(4, 0.4), None, "u"),
        (np.full((3, 3), 0.4), None, "u"),
        (np.full((3, 5), 0.4), None, "u"),
        (np.zeros((0, 5)), None, "u"),
        (np.array([[0.4, 0.4, 0.4, 0.0]]), None, "u"),
        (np.array([[0.4, 0.4, 0.4, 1.0]]), None, "u"),
        (np.array([[0.4, 0.4, 0.4, math.nan]]), None, "u"),
        (np.full((3, 4), 0.4), [-1.0], "scale"),
        (np.full((3, 4), 0.4), [1.0, 1.0], "scale"),
    ],
)
def test_numbers_that_no_map_takes_are_refused(u: Array, scale: list[float] | None, path: str) -> None:
    with pytest.raises(ModelError) as raised:
        tolerance_map(load(spur(4))).evaluate(u, scale=scale)
    assert raised.value.path == path


@pytest.mark.parametrize(
    ("path", "text", "problem"),
    [
        ("stages.main.planet.mass", "normal(5 kg, 1 kg)", "more than torques and stiffnesses"),
        ("stages.main.face_width", "normal(40 mm, 0.1 mm)", "more than torques and stiffnesses"),
        ("damping.modal", "normal(0.03, 0.001)", "neither a torque nor a stiffness"),
    ],
)
def test_what_has_no_columns_is_refused(path: str, text: str, problem: str) -> None:
    model = spur(4, {path: text})
    model["stages"]["main"]["planet"]["mass"] = "5 kg"
    model["stages"]["main"]["planet"]["inertia"] = "4 kg"
    with pytest.raises(ModelError, match=problem) as raised:
        tolerance_map(load(model))
    assert raised.value.path == f"tolerance.{path}"


def test_no_tolerance_and_no_load_are_refused() -> None:
    model = spur(4)
    del model["tolerance"]
    with pytest.raises(ModelError, match="no tolerance"):
        tolerance_map(load(model))
    with pytest.raises(ModelError, match="no mesh carries any"):
        tolerance_map(load(spur(4, operation={"held": ["ring"]})))


def test_a_stiffness_below_zero_fails_alone() -> None:
    model = spur(4, {**PIN, "stages.main.planet.bearing.radial": "normal(4e8 N/m, 1e8 N/m)"})
    given = tolerance_map(load(model))
    u = np.full((3, 8), 0.6)
    u[1, 4] = 1e-6
    found = given.evaluate(u)
    assert found.failed.tolist() == [False, True, False]
    assert np.isnan(found.k[1]).all()
    assert np.isfinite(found.k[[0, 2]]).all()


# every kind of deviation ----------------------------------------------------------------------------------------------

KINDS = {
    "deviations.main.planet.position.y": {"own": "normal(0 um, 20 um)", "common": "uniform(-5 um, 5 um)"},
    "deviations.main.planet.position.z": "normal(0 um, 40 um)",
    "deviations.main.planet.run_out.amplitude": "uniform(0 um, 20 um)",
    "deviations.main.sun.position": "disc(40 um)",
    "deviations.main.sun.bearing_run_out.phase": "uniform(0 deg, 360 deg)",
    "deviations.main.ring.left.run_out": "rayleigh(30 um)",
    "deviations.main.ring.run_out.x": "normal(5 um, 10 um)",
    "deviations.main.planet.tilt": "rayleigh(0.0001 rad)",
    "deviations.main.meshes.sun-planet.errors.wobble.amplitude": "normal(10 um, 5 um)",
    "deviations.main.meshes.planet-ring.left.gap": "normal(0 um, 8 um)",
    "deviations.main.meshes.planet-ring.profile.amplitude": "normal(0 um, 8 um)",
    "deviations.main.sun.unbalance.amount": "normal(0 kg m, 0.1 kg m)",
}


def kinds() -> dict[str, Any]:
    model = dict(load("ren2021").document)
    model["tolerance"], model["assumed"] = KINDS, {}
    model["deviations"] = {
        "main": {
            "sun": {"bearing_run_out": {"amplitude": "25 um", "phase": "10 deg", "from": "stage"}},
            "planet": {
                "position": {"x": "[5, -10, 20] um", "y": "0 um", "from": "stage"},
                "run_out": {"amplitude": "0 um", "phase": "[0, 90, 30] deg"},
            },
            "meshes": {
                "sun-planet": {
                    "errors": {
                        "wobble": {
                            "turns_with": "planet",
                            "amplitude": "0 um",
                            "phase": "[10, 20, 40] deg",
                            "order": 2,
                        },
                        "fixed": {"turns_with": "carrier", "amplitude": "[10, 0, -5] um"},
                    }
                }
            },
        }
    }
    return model


def test_every_kind_of_deviation() -> None:
    model = kinds()
    given = tolerance_map(load(model))
    quiet = [warning for warning in given.warnings if "has no effect" in warning]
    assert len(quiet) == 2
    assert any("profile" in text and "mesh orders" in text for text in quiet)
    assert any("unbalance" in text and "speed" in text for text in quiet)
    u = np.random.default_rng(8).random((3, len(given.dimension_entry)))
    found = given.evaluate(u, dense=True)  # as of one train
    bare = {name: value for name, value in model.items() if name not in ("tolerance", "assumed")}
    for sample in range(len(u)):
        alone = mean_loads(assemble(load(bare, overrides=given.overrides(u[sample]))))
        # a mesh that is open carries 0 by rounding of the mean load, which is 1
        np.testing.assert_allclose(found.load[sample], alone, rtol=1e-12, atol=1e-12)
    # each entry has a part in it but these two and the phase of what turns alone at its frequency
    idle = ("profile", "unbalance", "bearing_run_out.phase")
    middle = np.full((1, u.shape[1]), 0.3)
    before = given.evaluate(middle).load
    for entry, path in enumerate(KINDS):
        other = middle.copy()
        other[:, given.dimension_entry == entry] = 0.7 - 0.2 * np.arange((given.dimension_entry == entry).sum()) % 3 / 3
        changed = np.abs(given.evaluate(other).load - before).max()
        assert (changed > 1e-7) != any(name in path for name in idle), path


def test_the_numbers_of_a_sample() -> None:
    given = tolerance_map(load(kinds()))
    assert np.bincount(given.dimension_entry).tolist() == [4, 3, 3, 2, 1, 2, 1, 6, 3, 3, 3, 1]
    u = np.random.default_rng(8).random(len(given.dimension_entry))
    found = given.overrides(u)

    def numbers(path: str) -> list[float]:
        return list(json.loads("[" + str(found[path]).partition("m")[0].strip("[] ") + "]"))

    y = 20e-6 * norm.ppf(u[:3]) + 1e-5 * (u[3] - 0.5)
    np.testing.assert_allclose(numbers("deviations.main.planet.position.y"), y, rtol=1e-12)
    radius, angle = 20e-6 * math.sqrt(u[10]), 2 * math.pi * u[11]
    np.testing.assert_allclose(numbers("deviations.main.sun.position.x"), radius * math.cos(angle), rtol=1e-12)
    np.testing.assert_allclose(numbers("deviations.main.sun.position.y"), radius * math.sin(angle), rtol=1e-12)
    half = given.overrides(u, scale=[0.5] * len(given.entries))
    assert str(half["deviations.main.sun.position.x"]).startswith(repr(radius * math.cos(angle) / 2)[:12])


def test_correlated_pins_move_together() -> None:
    tolerance = {
        "deviations.main.planet.position.y": "normal(0 um, 10 um)",
        "deviations.main.meshes.sun-planet.gap": "normal(0 um, 10 um)",
        "correlation": {"deviations.main.planet.position.y": {"deviations.main.meshes.sun-planet.gap": 0.8}},
    }
    given = tolerance_map(load(spur(4, tolerance)))
    u = np.random.default_rng(1).random(8)
    z = norm.ppf(u)
    gap = str(given.overrides(u)["deviations.main.meshes.sun-planet.gap"])
    expected = 1e-5 * (0.8 * z[:4] + 0.6 * z[4:])
    np.testing.assert_allclose(json.loads(gap.removesuffix(" m")), expected, rtol=1e-9)


def scattered(count: int, dimensions: int) -> Array:
    """Points (count, d) in [0, 1) in steps of irrational length, which need no search for a lattice."""
    root = np.roots([1, *[0] * (dimensions - 1), -1, -1])
    root = root[np.abs(root.imag) < 1e-9].real.max()
    return np.asarray(np.outer(np.arange(count), root ** -np.arange(1.0, dimensions + 1)) % 1.0)


def test_the_search_for_the_largest_while_turning_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against 14 400 slow phases of open contact; of few phases without a search the shortfall is said."""
    run_outs = {f"deviations.main.{member}.run_out": "disc(20 um)" for member in ("sun", "planet", "ring", "carrier")}
    turning = {"held": ["ring"], "torque": {"sun": "800 N m"}, "speed": {"sun": "1500 rpm"}}
    model = spur(5, {"deviations.main.planet.position.y": "normal(0 um, 20 um)", **run_outs}, operation=turning)
    given = tolerance_map(load(model))
    u = np.random.default_rng(5).random((6, len(given.dimension_entry)))
    with monkeypatch.context() as brute:
        brute.setattr(sample_loads, "_DENSE_PHASES", 14_400)
        brute.setattr(load_map, "_lattice", scattered)
        reference = given.evaluate(u, dense=True)
    assert reference.open.sum() > 1
    np.testing.assert_allclose(given.evaluate(u).k[:, 1], reference.k[:, 1], rtol=1e-4)
    np.testing.assert_allclose(given.evaluate(u, dense=True).k[:, 1], reference.k[:, 1], rtol=1e-5)
    assert float(epicyclic.tolerance(model, samples=256, effects="none").turning_shortfall) < 1e-4
    monkeypatch.setattr(sample_loads, "_ROUNDS", 0)
    monkeypatch.setattr(sample_loads, "_PHASES", 8)
    found = epicyclic.tolerance(model, samples=256, effects="none")
    assert float(found.turning_shortfall) > 1e-3
    assert any("turning-searched" in text for text in warnings_of(found))
    # of other samples of the same train: of the order of what they rise by
    rise = np.nanmax(reference.k[:, 1] / given.evaluate(u).k[:, 1]) - 1
    assert float(found.turning_shortfall) > 0.5 * rise


def test_mean_and_largest_of_wide_open_contact_are_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run-outs of four shafts of 60 um at 40 N m, by which most teeth part most of the time: 20 000 slow phases."""
    model = dict(
        new_train(
            kind="planetary", teeth="28/26/80", planets=4, module="4 mm", torque="40 N m", speed="1500 rpm"
        ).document
    )
    del model["assumed"]
    run_outs = {f"deviations.{member}.run_out": "disc(60 um)" for member in ("sun", "planet", "ring", "carrier")}
    model["tolerance"] = {"deviations.planet.position.y": "normal(0 um, 10 um)", **run_outs}
    given = tolerance_map(load(model))
    u = np.random.default_rng(1).random((8, len(given.dimension_entry)))
    found = given.evaluate(u)
    with monkeypatch.context() as brute:
        brute.setattr(sample_loads, "_DENSE_PHASES", 20_000)
        brute.setattr(load_map, "_lattice", scattered)
        reference = given.evaluate(u, dense=True)
    assert found.open.sum() > 6
    np.testing.assert_allclose(found.load[:, 0], reference.load[:, 0], rtol=0, atol=5e-3)
    assert np.nanmax(reference.k[:, 1] / found.k[:, 1]) < 1.01
    monkeypatch.setattr(sample_loads, "_PHASES", 144)
    assert np.abs(given.evaluate(u).load[:, 0] - reference.load[:, 0]).max() > 1e-2  # what this test is about
