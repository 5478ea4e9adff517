"""Invariants of a star drive: five stepped stars in the housing, floating sun and ring, errors of every kind.

The drive is dong2019; nothing here rests on its source's numbers.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance_of, require_balance
from epicyclic.statics.static import static
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
Table = dict[str, Any]

N = 5
K_W, K_R = 1.78e7, 9.31e6
SUN_SPEED = 6800 / 60 * math.tau
TORQUE = 220e3 / SUN_SPEED
UM = 1e-6


def drive(deviations: Table | None = None, **changes: Any) -> System:
    """The ready drive with other deviations, and changes by path ('__' for points)."""
    overrides: Table = {"deviations": None, **{f"deviations.{k}": v for k, v in (deviations or {}).items()}}
    return assemble(load("dong2019", overrides | {path.replace("__", "."): value for path, value in changes.items()}))


def supports(sun: Any = K_W, ring: Any = K_R) -> Table:
    return {"stages__main__sun__support__radial": sun, "stages__main__ring__support__radial": ring}


def torque_of(value: float) -> Table:
    return {"operation__torque__sun": value}


def amplitude(um: float = 6.0, phase: Any = 0.0, start: str = "own") -> Table:
    """A vector error; phase [deg], one or five."""
    return {"amplitude": um * UM, "phase": f"{np.asarray(phase, float).tolist()} deg", "from": start}


def J(system: System, cycles: int = 1, samples: int = 1) -> Array:
    """Shares of the sun meshes (N, T), the same at the ring."""
    force = static(system, StaticOptions(cycles=cycles, samples=samples))["mesh_force"].values.reshape(2, N, -1)
    assert np.min(force) >= 0
    both = N * force / force.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(both[0], both[1], atol=1e-9)  # rounding of mesh by support stiffness
    return np.asarray(both[0])


def test_equal_gaps_change_nothing() -> None:
    np.testing.assert_allclose(
        J(drive({"meshes.sun-star1.gap": "5 um", "meshes.star2-ring.gap": "9 um"})), 1, atol=1e-9
    )
    # the same error in the same place of every star, seen from its own radial line
    table = {"star1.run_out": amplitude(phase=77), "star2.run_out": amplitude(phase=5), "star1.position": amplitude()}
    np.testing.assert_allclose(J(drive(table), cycles=24), 1, atol=1e-9)


@pytest.mark.parametrize(("sun", "ring"), [(0.0, "inf"), ("inf", 0.0), (0.0, K_R), (K_W, 0.0)])
def test_one_free_member_takes_the_first_harmonic(sun: Any, ring: Any) -> None:
    table = {"sun.run_out": "6 um", "ring.position": "9 um", "star1.position": amplitude(20, start="stage")}
    np.testing.assert_allclose(J(drive(table, **supports(sun, ring)), cycles=24), 1, atol=1e-7)


def test_free_sun_moves_by_its_error() -> None:
    result = static(drive({"sun.run_out": amplitude(6, 30)}, **supports(0.0)), StaticOptions(cycles=24, samples=1))
    place = (
        result["displacement"].sel(dof="main/sun/x").values + 1j * result["displacement"].sel(dof="main/sun/y").values
    )
    expected = -6 * UM * np.exp(1j * (SUN_SPEED * result["time"].values + math.radians(30)))
    np.testing.assert_allclose(place, expected, atol=1e-12)
    np.testing.assert_allclose(result["displacement"].sel(dof=["main/ring/x", "main/ring/y"]), 0, atol=1e-12)


def test_linear_in_errors_and_inverse_in_torque() -> None:
    """While closed and elastic: superposition, and J - 1 ~ 1/T."""
    one, two = {"sun.run_out": amplitude(6, 10)}, {"ring.position": amplitude(9, 200), "star2.run_out": "4 um"}
    first, second = (J(drive(table), cycles=48) - 1 for table in (one, two))
    both = J(drive(one | two), cycles=48) - 1
    np.testing.assert_allclose(both, first + second, atol=1e-9)
    twice = J(drive({"sun.run_out": amplitude(12, 10)}), cycles=48) - 1
    np.testing.assert_allclose(twice, 2 * first, atol=1e-9)
    for torque in (100.0, 1e4):
        here = J(drive(one, **torque_of(torque)), cycles=48) - 1
        np.testing.assert_allclose(here * torque, first * TORQUE, atol=1e-9 * 1e4)


def test_turning_error_gives_every_star_the_same_largest() -> None:
    for table in ({"sun.run_out": "6 um"}, {"sun.bearing_run_out": "6 um"}):
        largest = J(drive(table), cycles=24, samples=5).max(axis=1)  # 120 instants a turn: every star's angle is met
        np.testing.assert_allclose(largest, largest[0], rtol=1e-10)


def test_standing_error_against_its_amplitude() -> None:
    """The largest of five stars lies between cos 36 deg = 0.809 and 1 of what a turning error of that size gives."""
    alpha = math.atan(math.tan(math.radians(20)) / math.cos(math.radians(10)))  # transverse pressure angle of the sun
    towards = 90 - math.degrees(alpha)  # force on star 1
    # 3600 instants a turn: 1 - cos(pi/3600) off the top
    size = J(drive({"sun.run_out": "6 um"}), cycles=24, samples=150).max() - 1
    ratio = [(J(drive({"sun.position": amplitude(6, towards + x)})).max() - 1) / size for x in range(0, 73, 6)]
    assert ratio[0] == pytest.approx(1, abs=1e-6)
    assert ratio[6] == pytest.approx(math.cos(math.pi / 5), abs=1e-6) == min(ratio)
    assert ratio[12] == pytest.approx(1, abs=1e-6)


def test_maxwell() -> None:
    """dF_i/de_j is symmetric, for both meshes of all branches, and an equal gap in all does nothing: rank N - 1."""
    columns = []
    torque = 1e4
    once = StaticOptions(cycles=1, samples=1)
    for pair, branch in itertools.product(("sun-star1", "star2-ring"), range(N)):
        gap = [0.1 * (i == branch) for i in range(N)]
        found = static(
            drive({f"meshes.{pair}.gap": f"{gap} um"}, **torque_of(torque)), StaticOptions(cycles=1, samples=1)
        )
        columns.append(found["mesh_force"].values[:, 0])
    none = static(drive(**torque_of(torque)), once)["mesh_force"].values[:, 0]
    L = (np.array(columns) - none) / 0.1e-6
    np.testing.assert_allclose(L, L.T, atol=1e-7 * np.abs(L).max())
    size = np.linalg.svd(L, compute_uv=False)
    assert np.sum(size > 1e-6 * size[0]) == N - 1


def test_stiff_star_bearings_are_rigid_ones() -> None:
    """What is left falls as 1/K."""
    table = {"sun.run_out": "6 um", "star1.position": amplitude(2, start="stage"), "ring.position": "6 um"}
    rigid = J(drive(table), cycles=24)
    off = [
        np.abs(J(drive(table, stages__main__star1__bearing__radial=k), cycles=24) - rigid).max() for k in (1e11, 1e12)
    ]
    assert off[0] / off[1] == pytest.approx(10, rel=0.05)  # next order: meshes per bearing, 2e10/1e11 over ten
    assert off[1] < 1e-5


def test_soft_star_bearings_even_out_the_stars() -> None:
    """Errors of single stars, second harmonic, are relieved by star bearings only."""
    rng = np.random.default_rng(3)
    table = {"star1.run_out": amplitude(phase=rng.uniform(0, 360, N).round(3))}
    found = [J(drive(table, stages__main__star1__bearing__radial=k), cycles=264).max() for k in (1e9, 1e8, 3e7)]
    assert found[0] > found[1] > found[2]
    assert found[0] > 1.1
    assert found[2] < 1.02


def test_gear_off_its_shaft_is_eccentric() -> None:
    """The seat of star gear II is on the shaft of star gear I and turns with it."""
    error = amplitude(0.003, [3, 10, 50, 2, 200], "stage")
    seat, eccentric = (J(drive({f"star2.{cause}": error}), cycles=24) for cause in ("position", "run_out"))
    np.testing.assert_allclose(seat, eccentric, atol=1e-10)
    assert np.ptp(seat[0]) > 1e-3


def test_relabelled_stars() -> None:
    rng = np.random.default_rng(5)
    run_out, gap = rng.uniform(0, 0.003, N).round(6), rng.uniform(0, 0.003, N).round(6)
    for shift in (1, 3):
        turned = {
            "star1.run_out": f"{np.roll(run_out, shift).tolist()} um",
            "meshes.star2-ring.gap": f"{np.roll(gap, shift).tolist()} um",
            "sun.position": amplitude(6, 72 * shift),
        }
        plain = {
            "star1.run_out": f"{run_out.tolist()} um",
            "meshes.star2-ring.gap": f"{gap.tolist()} um",
            "sun.position": amplitude(6, 0),
        }
        np.testing.assert_allclose(J(drive(turned), 22), np.roll(J(drive(plain), 22), shift, axis=0), atol=1e-9)


def test_a_displaced_support_works_on_no_free_motion() -> None:
    """The drive turns freely; a force on the support of the sun alone does no work on that, nor on its rounding."""
    system = drive()
    free = compliance_of(system).free
    assert free.shape[1] == 1
    moved = [name for name, part in zip(system.dofs.names, free[:, 0], strict=True) if part]
    assert len(moved) == 2 + N
    assert all(name.endswith("/rz") for name in moved)
    force = np.zeros((1, len(system.dofs.names)))
    force[0, system.dofs.names.index("main/sun/x")] = 100.0
    require_balance(free, force, system)
