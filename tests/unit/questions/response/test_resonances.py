"""Table of resonances of `modes`: speeds, energy and forces against independent routes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modes.campbell import mesh_crossings
from epicyclic.system.system import System


@pytest.fixture(scope="module")
def ren() -> System:
    return epicyclic.assemble(epicyclic.load("ren2021"))


@pytest.fixture(scope="module")
def two(two_stages: dict[str, Any]) -> System:
    return epicyclic.assemble(epicyclic.load(two_stages))


def crossings_by_hand(result: xr.Dataset, tones: Mapping[str, float]) -> list[tuple[float, str, int, float]]:
    """(speed, stage, order, frequency) of every pair, by loops over the frequencies as they are printed."""
    found = []
    frequency = [round(float(one), 6) for one in result.frequency.values if one > 1e-6]
    for natural in dict.fromkeys(frequency):
        for stage, tone in tones.items():
            for order in range(1, 13):
                speed = natural / (order * tone)
                if 0.05 <= speed <= 1.3:
                    found.append((speed, stage, order, natural))
    places = list(tones)  # crossings of two stages at one speed stand in the order of the stages
    return sorted(found, key=lambda one: (round(one[0], 9), places.index(one[1]), one[2]))


@pytest.mark.parametrize("name", ["ren", "two"])
def test_every_crossing_is_found_at_its_speed(name: str, request: pytest.FixtureRequest) -> None:
    made: System = request.getfixturevalue(name)
    stages = dict(zip(made.meshes.stage, made.meshes.tone.tolist(), strict=True))
    result = epicyclic.modes(made)
    expected = crossings_by_hand(result, {stage: float(made.tones[tone]) for stage, tone in stages.items()})
    found = [
        tuple(one)
        for one in zip(
            *(result[f"resonance_{name}"].values.tolist() for name in ("speed", "stage", "order", "frequency")),
            strict=True,
        )
    ]
    assert len(expected) > 20
    assert [one[1:3] for one in found] == [one[1:3] for one in expected]
    np.testing.assert_allclose([one[0] for one in found], [one[0] for one in expected], rtol=1e-6)
    np.testing.assert_allclose([one[3] for one in found], [one[3] for one in expected], rtol=1e-6)


def test_repeated_frequencies_count_once_and_rigid_ones_not() -> None:
    found = mesh_crossings(np.array([0.0, 50.0, 50.0, 80.0]), [100.0], orders=1)
    assert found.mode.tolist() == [1, 3]
    assert found.count.tolist() == [2, 1]
    assert found.relative_speed.tolist() == [0.5, 0.8]


def test_a_band_keeps_what_lies_within_it(ren: System) -> None:
    every, near = epicyclic.modes(ren), epicyclic.modes(ren, band="10 %")
    inside = np.abs(every.resonance_speed.values - 1) <= 0.1
    assert 0 < inside.sum() < inside.size
    np.testing.assert_array_equal(near.resonance_speed.values, every.resonance_speed.values[inside])
    # speeds of one block share their truncation, 3e-5 of the dynamic force of 1.4 kN
    np.testing.assert_allclose(near.resonance_amplitude.values, every.resonance_amplitude.values[inside], atol=0.05)
    assert near.resonance_near.values.all()
    assert every.resonance_near.values.tolist() == (np.abs(every.resonance_speed.values - 1) <= 0.2).tolist()
    xr.testing.assert_identical(epicyclic.modes(ren, band=0.1), near)
    wide = epicyclic.modes(ren, band=0.5).resonance_speed.values
    assert (wide.min() > 0.5, wide.max() < 1.5, wide.max() > 1.4) == (True, True, True)


@pytest.mark.parametrize("band", ["wide", "-5 %", 0.0, float("nan")])
def test_no_band(ren: System, band: Any) -> None:
    with pytest.raises(ModelError, match="band"):
        epicyclic.modes(ren, band=band)


def test_energy_sits_where_the_motion_strains(ren: System) -> None:
    result = epicyclic.modes(ren)
    np.testing.assert_allclose(result.strain_energy_share.values[:, 1:].sum(axis=0), 1, rtol=1e-12)
    np.testing.assert_allclose(result.kinetic_energy_share.values.sum(axis=0), 1, rtol=1e-12)
    # by hand: energies of the rows from the eigenvectors of K and M, all modes of one frequency together
    K = ren.K + (ren.meshes.B * ren.meshes.stiffness) @ ren.meshes.B.T
    squared, shapes = scipy.linalg.eigh(K, ren.M)
    for at in range(0, result.sizes["resonance"], 7):
        hertz = float(result.resonance_frequency.values[at])
        # M-orthonormal: shares of a space do not hang on its basis
        own = shapes[:, np.abs(np.sqrt(np.abs(squared)) / (2 * np.pi) - hertz) < 1e-4 * hertz]
        assert own.shape[1] == result.resonance_multiplicity.values[at]
        energy: dict[str, float] = {}
        for rows, names in ((ren.meshes, ren.meshes.name), (ren.links, ren.links.link)):
            for name, stiffness, row in zip(names, rows.stiffness, (rows.B.T @ own), strict=True):
                key = "/".join(part for part in name.split("/") if not part.isdigit() and part not in ("left", "right"))
                energy[key] = energy.get(key, 0.0) + (stiffness * np.sum(row**2) if np.isfinite(stiffness) else 0.0)
        most = max(energy, key=lambda key: energy[key])
        assert result.resonance_connection.values[at] == most
        share = energy[most] / sum(energy.values())
        assert float(result.resonance_connection_share.values[at]) == pytest.approx(share, rel=1e-6)


def test_forces_are_those_of_a_sweep_at_the_speed(ren: System) -> None:
    result = epicyclic.modes(ren)
    at = int(np.argmax(result.resonance_amplitude.values))
    one = epicyclic.sweep(ren, relative_speed=[float(result.resonance_speed.values[at])])
    order = one.mesh_force_order.sel(order=int(result.resonance_order.values[at]))
    assert float(result.resonance_amplitude.values[at]) == pytest.approx(float(order.max()), rel=1e-6)
    assert float(result.resonance_dynamic_factor.values[at]) == pytest.approx(float(one.dynamic_factor.max()), rel=1e-6)
    # of equal branches the first is named
    named = one.dynamic_factor.sel(mesh=str(result.resonance_mesh.values[at])).item()
    assert named == pytest.approx(float(one.dynamic_factor.max()), rel=1e-4)


def test_one_stage_at_a_time_gives_the_amplitudes_of_both_together(two: System) -> None:
    result = epicyclic.modes(two)
    assert "one stage at a time" in result.attrs["resonance_note"]
    above = np.where(result.resonance_speed.values > 0.5, result.resonance_amplitude.values, 0.0)
    stages = np.array(two.meshes.stage)
    at = int(np.argmax(above))
    both = epicyclic.sweep(two, relative_speed=[float(result.resonance_speed.values[at])])
    own = np.array([name.split("/")[0] == result.resonance_stage.values[at] for name in both.mesh.values])
    order = both.mesh_force_order.sel(order=int(result.resonance_order.values[at])).values[own]
    # what the other stage's varying stiffness adds is of second order in the variation
    assert float(result.resonance_amplitude.values[at]) == pytest.approx(float(order.max()), rel=2e-3)
    assert set(stages) == set(result.resonance_stage.values)


def test_without_damping_there_are_no_forces_and_without_speed_no_table(ren: System) -> None:
    from dataclasses import replace

    undamped = epicyclic.modes(replace(ren, zeta=None))
    assert undamped.sizes["resonance"] > 20
    assert np.isnan(undamped.resonance_amplitude.values).all()
    assert "damping" in undamped.attrs["resonance_note"]
    assert "resonance" not in epicyclic.modes("lin1999-n4").sizes


def test_teeth_that_the_linear_model_pulls_are_named(one_stage: dict[str, Any]) -> None:
    """At as many resonances as a sweep over their speeds finds tensile mesh forces."""
    model = epicyclic.load(one_stage, {"stages.main.helix_angle": "0 deg", "operation.speed.carrier": "333 rpm"})
    found = epicyclic.modes(model)
    swept = epicyclic.sweep(model, relative_speed=np.unique(found.resonance_speed.values))
    pulled = swept.speed.values[(swept.mesh_force_minimum < 0).any("mesh").values]
    count = int(np.isin(found.resonance_speed.values, pulled).sum())
    assert 0 < count < found.sizes["resonance"]
    note = f"At {count} of {found.sizes['resonance']} speeds the linear model pulls on teeth that would part"
    assert note in found.attrs["resonance_note"]
    loaded = epicyclic.load(one_stage, {"operation.torque.carrier": "80 kN m"})
    assert "pulls" not in epicyclic.modes(loaded).attrs["resonance_note"]


def test_the_force_of_a_mode_is_per_the_mean_force_of_a_mesh() -> None:
    source = epicyclic.load("ren2021", {"operation.speed.sun": "900 rpm", "damping.modal": 0.01})
    found = epicyclic.modes(source)
    ratio, own = found["resonance_force_ratio"].values, found["resonance_own_force"].values
    at = int(np.nanargmax(ratio))
    speed = float(found["resonance_speed"].values[at])
    swept = epicyclic.sweep(source, relative_speed=[speed])
    mean = np.abs(swept["mesh_force_mean"].values[:, 0])
    assert float(np.abs(swept["mesh_force_peak"].values[:, 0]).min()) > 1.05 * mean.max()
    assert own[at] / mean.max() * (1 - 1e-4) <= ratio[at] <= own[at] / mean.min() * (1 + 1e-4)
