"""The analysis over speed: kinds, periods of several meshes, what is refused, what fails alone."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modes.eigen import modal_form
from epicyclic.questions.stability.stability import floquet_scan, instability_kind, parametric_system, stability
from epicyclic.results.dataset import load_result, save_result
from epicyclic.system.system import System


def test_kinds() -> None:
    assert instability_kind(np.array([0.9, -0.99j])) == "stable"
    assert instability_kind(np.array([1.0 + 1e-9, 0.5])) == "stable"  # undamped: on the circle to rounding
    assert instability_kind(np.array([1.2, 0.5])) == "divergence"
    assert instability_kind(np.array([-1.2, 0.5])) == "period doubling"
    assert instability_kind(np.array([1.2j, -1.2j])) == "quasi-periodic"
    assert instability_kind(np.zeros(0, complex)) == "stable"


def test_kinds_over_speed(case: Any) -> None:
    system = case.two(0.9)
    omega = np.sqrt(modal_form(system).squared) / (2 * np.pi)
    found = stability(system, mesh_frequency=[2 * omega[0], omega.sum(), 1.5])
    assert found.instability.values.tolist() == ["period doubling", "quasi-periodic", "stable"]
    assert found.stable.values.tolist() == [False, False, True]
    assert found.taking_part.values.tolist() == ["2 f1 = f", "f1 + f2 = f", ""]
    assert (found.growth_rate.values[:2] > 0).all()
    np.testing.assert_allclose(
        found.growth_rate, np.log(found.largest_multiplier) * found.mesh_frequency.values, rtol=1e-12
    )
    assert found.growth_rate.attrs["units"] == "1/s"


def test_without_variation_and_without_damping(case: Any) -> None:
    damped = stability(case.two(0.0, zeta=0.02), mesh_frequency=[0.7, 3.3])
    assert damped.stable.all()
    assert (damped.growth_rate < 0).all()
    assert damped.sizes["resonance"] == 0
    # the slowest decay is that of the first mode whatever the speed
    assert float(np.ptp(damped.growth_rate.values)) < 1e-9
    marginal = stability(case.two(0.0), mesh_frequency=[0.7, 3.3])
    assert marginal.stable.all()
    np.testing.assert_allclose(marginal.largest_multiplier, 1.0, atol=1e-9)


def test_factors_are_those_of_the_system(case: Any) -> None:
    system = replace(case.two(0.4, zeta=0.01), C=np.diag([0.1, 0.2]))
    system = replace(system, meshes=replace(system.meshes, damping=np.array([0.3])))
    other = replace(
        system,
        C=2 * system.C,
        zeta=0.02,
        meshes=replace(system.meshes, damping=np.array([0.6]), variation=np.array([[0.8 + 0j]])),
    )
    one = stability(system, mesh_frequency=[1.0, 3.3], variation=2.0, damping=2.0)
    two = stability(other, mesh_frequency=[1.0, 3.3])
    np.testing.assert_allclose(one.floquet_multiplier, two.floquet_multiplier, rtol=1e-12)


def _two_tones(case: Any, second: Fraction) -> Any:
    omega = 2 * np.pi * np.array([1.0, 2.3])
    rows, k = np.array([[1.0, 0.4], [0.7, -1.0]]), 0.2 * omega[0] ** 2 * np.ones(2)
    K = np.diag(omega**2) - (rows * k) @ rows.T
    swings = np.array([[0.6], [0.5]])
    return case.system(np.eye(2), K, rows, k, swings, tones=(Fraction(1), second), tone=[0, 1], zeta=0.02)


def test_common_period_of_several_mesh_frequencies(case: Any) -> None:
    system = _two_tones(case, Fraction(2, 3))
    found = stability(system, mesh_frequency=[1.4])
    reference = np.linalg.eigvals(case.monodromy(system, 1.4, 3 / 1.4))
    assert case.apart(found.floquet_multiplier.values[0], reference) < 1e-5  # 72 steps of fourth order
    assert float(found.growth_rate[0]) == pytest.approx(np.log(np.abs(reference).max()) * 1.4 / 3, abs=1e-6)
    assert "3 cycles" in found.attrs["options"]
    # of a mesh that does not vary the tone does not count
    still = replace(system, meshes=replace(system.meshes, variation=np.array([[0.6 + 0j], [0j]])))
    assert parametric_system(still).cycles == 1


def test_a_common_period_that_is_too_long_is_told(case: Any) -> None:
    found = stability(_two_tones(case, Fraction(1009, 1013)), mesh_frequency=[1.4, 3.3])
    assert (found.status.values == "ok").all()
    assert "2 of 2 speeds: the common period of all meshes is too long" in found.attrs["warnings"]
    assert found.sizes["resonance"] > 0  # the prediction has the combinations


def test_a_bad_speed_fails_alone(case: Any) -> None:
    found = stability(case.two(0.4, zeta=0.01), mesh_frequency=[1.0, np.nan, -2.0, 0.0, 3.3])
    assert [str(status) for status in found.status.values].count("ok") == 2
    assert np.isfinite(found.growth_rate.values[[0, 4]]).all()
    assert np.isnan(found.growth_rate.values[1:4]).all()
    assert "above zero" in str(found.status.values[1])


def test_what_is_refused(case: Any) -> None:
    system = case.two(0.4)
    with pytest.raises(ModelError, match="not both"):
        stability(system, mesh_frequency=[1.0], relative_speed=[1.0])
    with pytest.raises(ModelError, match="frame_speed"):
        epicyclic.stability(system, frame_speed="fast")  # type: ignore[arg-type]
    for name in ("variation", "damping"):
        with pytest.raises(ModelError, match=name):
            stability(system, **{name: -1.0})  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="mesh frequency above zero"):
        stability(replace(system, tones=()))
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.mass"):
        stability(replace(system, missing_inertia=("stages.main.sun.mass",)))


def test_default_speeds_and_progress(case: Any) -> None:
    seen: list[tuple[int, int]] = []
    found = stability(case.two(0.4, zeta=0.01), progress=lambda done, of: seen.append((done, of)))
    assert found.sizes["speed"] == 200
    assert seen[-1] == (200, 200)
    relative = stability(case.two(0.4, zeta=0.01), relative_speed=[0.5, 1.0])
    assert relative.mesh_frequency.values.tolist() == [0.5, 1.0]


def test_saved_and_reopened(case: Any, tmp_path: Path) -> None:
    found = stability(case.two(0.4, zeta=0.01), mesh_frequency=[1.0, 3.3])
    again = load_result(save_result(found, tmp_path / "stability.nc"))
    np.testing.assert_array_equal(again.floquet_multiplier, found.floquet_multiplier)
    assert again.instability.values.tolist() == found.instability.values.tolist()


def test_the_free_rotation_of_a_drive_is_no_instability() -> None:
    found = epicyclic.stability("xu2020", mesh_frequency=[100.0, 900.0])
    assert found.stable.all()
    # the free rotation is there, and apart: the last two multipliers are 1
    np.testing.assert_allclose(found.floquet_multiplier.values[:, -2:], 1.0, atol=1e-9)
    assert (found.largest_multiplier < 0.999).all()


@pytest.mark.parametrize(("frequency", "damping"), [(3500.0, 1.0), (4310.0, 0.3)])
def test_a_56_degree_of_freedom_set_against_integration(
    case: Any, bench56: System, frequency: float, damping: float
) -> None:
    ready = parametric_system(bench56, damping=damping)
    found = floquet_scan(ready, np.array([frequency]))
    reference = np.linalg.eigvals(case.monodromy(ready.system, frequency / 1000, 1 / frequency, rtol=1e-7))
    assert case.apart(found.multipliers[0], reference) < 1e-5  # 48 steps; 3e-6 at a lower speed
    assert found.largest[0] == pytest.approx(np.abs(reference).max(), abs=2e-7)
    assert bool(found.largest[0] > 1) is (damping < 1)


def test_a_range_in_shaft_speed() -> None:
    found = epicyclic.stability("ren2021", start="50 %", stop="200 rpm", points=2)
    # the sun turns at 100 rpm in operation, its mesh frequency there is 27.3125 Hz
    assert found.mesh_frequency.values == pytest.approx([27.3125 / 2, 2 * 27.3125], rel=1e-12)


def test_mesh_frequencies_without_a_short_common_period_are_judged_alone(two_stages: dict[str, Any]) -> None:
    """The largest growth rate is that of the mesh frequency that grows fastest with the other stiffnesses constant."""
    spur: dict[str, Any] = {"stages.low.helix_angle": 0, "stages.high.helix_angle": 0, "damping.modal": 0.0005}
    spur |= {f"stages.high.{member}.teeth": z for member, z in (("sun", 23), ("planet", 31), ("ring", 85))}
    assert parametric_system(epicyclic.assemble(epicyclic.load(two_stages, spur))).cycles == 56
    whole = epicyclic.stability(two_stages, overrides=spur, mesh_frequency=[55.29, 73.56])
    assert (whole.status.values == "ok").all()
    assert "2 of 2 speeds: the common period of all meshes is too long" in whole.attrs["warnings"]
    growth = []
    for stage in ("low", "high"):
        without = {f"stages.{stage}.meshes.{pair}.variation": "none" for pair in ("sun-planet", "planet-ring")}
        one = epicyclic.stability(two_stages, overrides=spur | without, mesh_frequency=whole.mesh_frequency.values)
        assert "judged alone" not in one.attrs["warnings"]
        growth.append(one.growth_rate.values)
    np.testing.assert_allclose(whole.growth_rate, np.max(growth, axis=0), rtol=1e-3)
    assert np.argmax(growth, axis=0).tolist() == [1, 0]  # either may grow fastest
    assert growth[0][1] > 0 > growth[1][1]
