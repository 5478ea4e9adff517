"""Samples of stiffness: every sample is what a train built afresh gives."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from epicyclic.analyses.samples import stiffness as room
from epicyclic.analyses.samples.stiffness import stiffness_samples
from epicyclic.analyses.steady.sweep import sweep
from epicyclic.errors import ModelError
from epicyclic.resolve import load
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System

SPEED = 1.3
# Damping given per connection, so that a train built afresh has the same dampers.
TRAIN: dict[str, object] = {
    "damping.modal": None,
    "stages.main.sun.support.damping": "3e5 N s/m",
    "stages.main.planet.bearing.damping": "2e5 N s/m",
    "stages.main.carrier.support.damping": "3e5 N s/m",
    "stages.main.meshes.sun-planet.damping": "1e5 N s/m",
    "stages.main.meshes.planet-ring.damping": "1e5 N s/m",
    "stages.main.meshes.sun-planet.stiffness": "2.8e9 N/m",
    "deviations.sun.position.x": "10 um",
}


@pytest.fixture(scope="module")
def system(case: Any) -> System:
    """Mesh and shaft orders, errors of links, all terms; dampers of links and meshes."""
    lines = tuple(
        replace(case.line(frequency, gap, push=push), link_gap=np.array(link, complex))
        for frequency, gap, push, link in (
            (Fraction(0), [2e-6, -1e-6], 0, [1e-6, 0, 0, 3e-6]),
            (Fraction(274, 7), [5e-6, 4e-6j], 60, [0, 4e-6j, 0, 0]),
            (Fraction(137), [3e-6, 2e-6j], 40, [0, 0, 2e-6, 0]),
            (137 - Fraction(274, 7), [1e-6, 2e-6], 0, [3e-6, 0, 0, 0]),
        )
    )
    made: System = case.pair(lines=lines, zeta=None, mesh_damping=600.0)
    return made


def changed(system: System, mesh: Any, link: Any) -> System:
    """The train with other stiffnesses, errors of its links pushing through them."""
    added = (link - 1) * system.links.stiffness
    push = system.links.B * added
    return replace(
        system,
        K=system.K + push @ system.links.B.T,
        meshes=replace(system.meshes, stiffness=mesh * system.meshes.stiffness),
        lines=tuple(
            replace(line, force=line.force + np.stack([push @ line.link_gap, 0 * push[:, 0], 0 * push[:, 0]]))
            for line in system.lines
        ),
    )


def draw(shape: tuple[int, int], seed: int) -> Any:
    return np.random.default_rng(seed).uniform(0.6, 1.5, shape)


def test_every_sample_is_a_full_solution_of_its_own(system: System) -> None:
    mesh, link = draw((4, 2), 1), draw((4, 4), 2)
    found = {
        measure: stiffness_samples(
            system,
            mesh,
            links=system.links.name,
            link=link,
            relative_speed=SPEED,
            tolerance=1e-10,
            measure=measure,
        )
        for measure in ("rms", "peak", "minimum")
    }
    for i in range(4):
        full = sweep(changed(system, mesh[i], link[i]), relative_speed=[SPEED], tolerance=1e-11)
        size = float(full.mesh_force_peak.max())
        # a residual of 1e-10, at most 1/(2 zeta) < 50 times that in the response
        np.testing.assert_allclose(found["rms"].values[:, i], full.mesh_force_rms.values[:, 0], rtol=1e-8)
        # a parabola between 128 or more phases, of other harmonics kept: (2 pi 8 / 128)^4 / 384 = 6e-5 of the part of
        # the eighth harmonic, which is less than a tenth
        np.testing.assert_allclose(found["peak"].values[:, i], full.mesh_force_peak[:, 0], atol=1e-5 * size)
        np.testing.assert_allclose(found["minimum"].values[:, i], full.mesh_force_minimum[:, 0], atol=1e-5 * size)
    assert found["rms"].residual.max() <= 30e-10


def test_a_sample_is_the_model_file_with_other_values() -> None:
    nominal = assemble(load("ren2021", TRAIN))
    other = TRAIN | {
        "stages.main.meshes.sun-planet.stiffness": "3.22e9 N/m",
        "stages.main.sun.support.radial": "0.8e9 N/m",
    }
    mesh = [[1.15 if "sun-planet" in name else 1.0 for name in nominal.meshes.name]]
    found = stiffness_samples(
        nominal,
        mesh,
        links=["main/sun/support/x", "main/sun/support/y"],
        link=[[0.8, 0.8]],
        tolerance=1e-9,
        shaft_orders=False,
    )
    full = sweep(assemble(load("ren2021", other)), relative_speed=[1.0], tolerance=1e-10, shaft_orders=False)
    np.testing.assert_allclose(found.values[:, 0], full.mesh_force_rms.values[:, 0], rtol=1e-8)
    same = sweep(nominal, relative_speed=[1.0], tolerance=1e-10, shaft_orders=False)
    assert np.abs(same.mesh_force_rms.values[:, 0] / found.values[:, 0] - 1).max() > 1e-2


def test_factors_of_one_change_nothing_and_a_link_is_all_its_rows(system: System) -> None:
    nominal = sweep(system, relative_speed=[SPEED], tolerance=1e-10).mesh_force_rms.values[:, 0]
    np.testing.assert_allclose(
        stiffness_samples(system, np.ones((1, 2)), relative_speed=SPEED, tolerance=1e-10).values[:, 0],
        nominal,
        rtol=1e-8,
    )
    whole = stiffness_samples(system, links=["main/a/support"], link=[[0.7]], relative_speed=SPEED)
    names = ["main/a/support/x", "main/a/support/y"]
    rows = stiffness_samples(system, links=names, link=[[0.7, 0.7]], relative_speed=SPEED)
    np.testing.assert_array_equal(whole.values, rows.values)


def test_chunks_change_nothing_and_a_call_twice_is_the_same(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = draw((23, 2), 5)
    once = stiffness_samples(system, mesh, relative_speed=SPEED)
    np.testing.assert_array_equal(once.values, stiffness_samples(system, mesh, relative_speed=SPEED).values)
    monkeypatch.setattr(room, "_BATCH", 200)
    pieces = stiffness_samples(system, mesh, relative_speed=SPEED)
    # a sample goes on while another of its batch does: both are solved to 1e-6 of the dynamic part
    np.testing.assert_allclose(pieces.values, once.values, rtol=1e-5)


def test_samples_that_iterate_long_are_eliminated(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = draw((3, 2), 6)
    once = stiffness_samples(system, mesh, relative_speed=SPEED, tolerance=1e-11)
    monkeypatch.setattr(room, "_FEW", 1)
    monkeypatch.setattr(room, "_MANY", 2)
    monkeypatch.setattr(room, "gmres", lambda apply, right, **_: (0 * right, np.linalg.norm(right, axis=1), 0))
    direct = stiffness_samples(system, mesh, relative_speed=SPEED, tolerance=1e-11)
    # a residual of 1e-11, at most 50 times that in the response
    np.testing.assert_allclose(direct.values, once.values, rtol=1e-9)
    assert direct.residual.max() < 1e-10


def test_a_sample_without_an_answer_is_nan_and_harms_no_other(system: System) -> None:
    mesh = np.array([[1.1, 0.9], [1e300, 1e300], [1.0, 0.0]])
    found = stiffness_samples(system, mesh, relative_speed=SPEED, tolerance=1e-9)
    assert np.isnan(found.values[:, 1]).all()
    alone = stiffness_samples(system, mesh[[0, 2]], relative_speed=SPEED, tolerance=1e-9)
    np.testing.assert_allclose(found.values[:, [0, 2]], alone.values, rtol=1e-7, atol=1e-12)
    # without stiffness the damper is left, and its force
    bare = sweep(changed(system, np.array([1.0, 0.0]), np.ones(4)), relative_speed=[SPEED], tolerance=1e-10)
    np.testing.assert_allclose(found.values[:, 2], bare.mesh_force_rms.values[:, 0], rtol=1e-7)


def test_bad_input_is_named(system: System) -> None:
    with pytest.raises(ModelError, match=r"mesh.*\(3, 2\)"):
        stiffness_samples(system, np.ones((3, 3)))
    with pytest.raises(ModelError, match=r"link.*\(3, 1\)"):
        stiffness_samples(system, np.ones((3, 2)), links=["main/a/support"], link=np.ones((2, 1)))
    with pytest.raises(ModelError, match="finite factors"):
        stiffness_samples(system, [[1.0, -0.1]])
    with pytest.raises(ModelError, match=r"sun.*main/a/support, main/b/support"):
        stiffness_samples(system, links=["sun"], link=[[1.0]])
    with pytest.raises(ModelError, match="named twice"):
        stiffness_samples(system, links=["main/a/support", "main/a/support/x"], link=[[1.0, 1.0]])
    unknown: Any = "mode"
    with pytest.raises(ModelError, match="rms, peak, minimum, mean"):
        stiffness_samples(system, [[1.0, 1.0]], measure=unknown)
    with pytest.raises(ModelError, match="relative_speed"):
        stiffness_samples(system, [[1.0, 1.0]], relative_speed=0.0)
