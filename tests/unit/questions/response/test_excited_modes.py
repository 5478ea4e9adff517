"""Which resonances are ones: the mode's own part of the response, against the phases of the meshes and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.linalg import eigh

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modes.views import modes_findings, modes_key_figures
from epicyclic.questions.response.sweep_table import with_resonances
from epicyclic.system.system import System

N = 5


def _model(sun: int, planet: int, ring: int) -> dict[str, Any]:
    """Five planets evenly spaced, nothing that breaks the symmetry; sun + ring = 130 teeth."""
    bearing = {"support": {"radial": "3e8 N/m"}}
    return {
        "format": 2,
        "title": "five planets",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                **{"planets": N, "module": "4 mm", "face_width": "60 mm"},
                "sun": {"teeth": sun, "support": {"radial": "1e8 N/m"}},
                "planet": {"teeth": planet, "bearing": {"radial": "6e8 N/m"}},
                "ring": {"teeth": ring, "rim": "6 mm", "addendum": 0.9, "support": {"radial": "3e9 N/m"}},
                "carrier": {"mass": "22.8 kg", "inertia": "0.4 kg m^2", **bearing},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "power": {"sun": "1 MW"}},
    }


def kind_by_phases(order: int, sun: int) -> str:
    """[parker2004]: order l drives rotational modes where l z_s mod N = 0, translational where 1 or N - 1."""
    return {0: "rotational", 1: "translational", N - 1: "translational"}.get(order * sun % N, "planet")


@pytest.fixture(scope="module", params=[30, 31])
def found(request: pytest.FixtureRequest) -> tuple[int, System, xr.Dataset]:
    sun: int = request.param
    system = epicyclic.assemble(epicyclic.load(_model(sun, {30: 35, 31: 34}[sun], 130 - sun)))
    return sun, system, epicyclic.modes(system, band="1000..2600 Hz")


def test_an_order_excites_the_kind_that_the_phases_of_the_meshes_leave(found: tuple[int, System, xr.Dataset]) -> None:
    sun, _, result = found
    kind, order = result.resonance_kind.values, result.resonance_order.values
    assert 1000 <= result.resonance_frequency.values.min() <= result.resonance_frequency.values.max() <= 2600
    expected = np.array([kind_by_phases(int(one), sun) for one in order])
    assert set(kind) == {"rotational", "translational", "planet"}
    other = kind != expected
    assert 10 < other.sum() < other.size
    assert result.resonance_share.values[other].max() < 1e-9
    assert (result.resonance_excited.values[other] == "no").all()
    excited = result.resonance_excited.values == "yes"
    assert set(kind[excited]) == set(expected[kind == expected])
    assert excited[~other].mean() > 0.9
    # the order shakes the train at the natural frequency of those modes too, with the force of others
    assert result.resonance_amplitude.values[other].max() > 100 > 1e-3 > result.resonance_own_force.values[other].max()


def test_the_part_of_a_mode_is_its_modal_coordinate(found: tuple[int, System, xr.Dataset]) -> None:
    _, system, result = found
    at = int(np.argmax(result.resonance_own_force.values))
    order, meshes = int(result.resonance_order.values[at]), system.meshes
    one = epicyclic.steady(system, relative_speed=float(result.resonance_speed.values[at]))
    q = one.displacement_harmonic.values[:, order] / system.dofs.radius
    squared, shapes = eigh(system.K + (meshes.B * meshes.stiffness) @ meshes.B.T, system.M)
    hertz = np.sqrt(np.abs(squared)) / (2 * np.pi)
    own = np.abs(hertz / result.resonance_frequency.values[at] - 1) < 1e-5
    assert own.sum() == result.resonance_multiplicity.values[at]
    eta = shapes.T @ system.M @ q
    share = np.sum(np.abs(eta[own]) ** 2) / np.sum(np.abs(eta) ** 2)
    assert float(result.resonance_share.values[at]) == pytest.approx(share, rel=1e-3)
    assert 0.5 < share < 1
    force = np.abs(meshes.stiffness * (meshes.B.T @ (shapes[:, own] @ eta[own]))).max()
    assert float(result.resonance_own_force.values[at]) == pytest.approx(force, rel=1e-3)


def test_tables_and_headline_rank_by_what_the_mode_makes(found: tuple[int, System, xr.Dataset]) -> None:
    _, _, result = found
    near = result.resonance_near.values & (result.resonance_excited.values == "yes")
    strongest = int(np.flatnonzero(near)[result.resonance_own_force.values[near].argmax()])
    words = [text for _, text in modes_key_figures(result) if "strongest" in text]
    hertz = float(result.resonance_frequency.values[strongest])
    assert words
    assert f"{int(result.resonance_order.values[strongest])}x mesh" in words[0]
    assert f"{hertz:.4g}" in words[0].replace("\u202f", "") or f"{hertz:.5g}" in words[0]
    counted = modes_findings(result, {})[0].text
    met = int(result.resonance_near.values.sum())
    assert counted.startswith(f"{near.sum()} resonance")
    assert f"({met - near.sum()} more where the order does not excite the mode)" in counted


def test_the_force_of_a_mode_is_that_per_mean_of_its_own_mesh() -> None:
    """With unequal planet loads the largest ratio is not the largest force per largest mean."""
    result = epicyclic.modes("ren2021")
    known = result.resonance_force_ratio.values > 0
    mean = np.abs(epicyclic.sweep("ren2021", points=3).mesh_force_mean.values)
    own, ratio = result.resonance_own_force.values[known], result.resonance_force_ratio.values[known]
    assert mean.max() > 1.05 * mean.min() > 0
    assert np.all(ratio >= own / mean.max() * (1 - 1e-9))
    assert np.all(ratio <= own / mean.min() * (1 + 1e-9))
    assert (ratio > 1.01 * own / mean.max()).sum() > 3


@pytest.mark.parametrize("band", ["6000..500 Hz", "500..6000", "..", "1 Hz..x"])
def test_no_band_in_hertz(found: tuple[int, System, xr.Dataset], band: str) -> None:
    with pytest.raises(ModelError, match="band"):
        epicyclic.modes(found[1], band=band)


@pytest.mark.parametrize("band", [0.0, -0.1, np.nan, np.inf])
def test_a_band_without_width_is_refused(band: float) -> None:
    train = epicyclic.load("ren2021")
    with pytest.raises(ModelError, match=r"^band = .*: not a share of the operating speed"):
        with_resonances(epicyclic.modes(train), epicyclic.assemble(train), band=band)
