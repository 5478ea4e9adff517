"""Mesh stiffness by loaded contact: the table, its interpolation, and trains that use it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.flank_laws import TabulatedAt, TabulatedLaw
from epicyclic.teeth.form import Flank, Relief
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import _slopes, contact_table, loaded_contact
from epicyclic.teeth.mesh_stiffness import evaluate_series
from epicyclic.train.resolution import load

LOAD = 6e3
RELIEF = Flank(tip_relief=Relief(amount=12e-6, length=2e-3, shape="parabolic"), crown=6e-6)
CONTACT = {f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")}


@pytest.fixture(scope="module")
def pair(pair_of: Callable[..., ContactPair]) -> ContactPair:
    return pair_of(helix=18.0, flank_a=RELIEF, flank_b=Flank(crown=3e-6), slices=20)


def curves(pair: ContactPair, sigma: Any, samples: int = 50) -> tuple[Any, TabulatedAt]:
    table = contact_table(pair, LOAD, samples=samples)
    law = TabulatedLaw(
        tone=np.zeros(1, np.int64),
        lead=np.zeros(1),
        sense=np.ones(1),
        force=table.force,
        gap=table.gap,
        slope=table.slope,
        load=np.full(1, np.nan),
    )
    return table, law.at(np.asarray(sigma, dtype=float)[:, None])


def test_the_linear_model_has_tangent_and_transmission_error_of_the_load(pair: ContactPair) -> None:
    sigma = np.arange(50) / 50
    table = contact_table(pair, LOAD)
    found = loaded_contact(pair, [LOAD], sigma)
    assert table.stiffness == pytest.approx(found.tangent.mean(axis=1)[0], rel=1e-12)
    assert LOAD in table.force
    stiffness = table.stiffness * evaluate_series(table.variation, sigma)
    waves = np.exp(2j * np.pi * np.outer(sigma, np.arange(len(table.error))))
    approach = LOAD / stiffness + (waves @ table.error).real
    # 12 of 25 orders; the tangent turns sharply where lines come and go
    ripple = np.ptp(found.approach)
    np.testing.assert_allclose(approach, found.approach[0], atol=0.02 * ripple)
    np.testing.assert_allclose(stiffness, found.tangent[0], rtol=0.03)
    assert np.sqrt(np.mean((stiffness / found.tangent[0] - 1) ** 2)) < 0.01


@pytest.mark.parametrize(("samples", "error"), [(50, 6e-3), (200, 2e-3)])
def test_between_loads_and_phases_the_table_is_the_pair(pair: ContactPair, samples: int, error: float) -> None:
    """Worst where a line leaves the path within a cell of phases: the law has a bend there, the cubic has not."""
    sigma = np.array([0.013, 0.25, 0.507, 0.891])
    loads = LOAD * np.array([0.004, 0.05, 0.3, 0.77, 1.4, 2.6])
    table, law = curves(pair, sigma, samples)
    found = loaded_contact(pair, loads, sigma)
    linear = (np.exp(2j * np.pi * np.outer(sigma, np.arange(len(table.error)))) @ table.error).real
    for force, approach, tangent in zip(loads, found.approach, found.tangent, strict=True):
        value, slope = law.evaluate((approach - linear)[:, None])
        np.testing.assert_allclose(value[:, 0], force, atol=error * LOAD)
        if force > 0.2 * LOAD:
            np.testing.assert_allclose(slope[:, 0], tangent, rtol=0.03)


def test_the_law_rises_and_its_derivative_is_its_slope(pair: ContactPair) -> None:
    sigma = np.linspace(0, 1, 37)
    table, law = curves(pair, sigma)
    way = np.random.default_rng(1).uniform(table.gap.min() - 5e-6, table.gap.max() + 10e-6, (37, 2000))
    way.sort(axis=1)

    def at(x: Any) -> tuple[Any, Any]:
        pairs = [law.evaluate(column[:, None]) for column in x.T]
        return np.array([force[:, 0] for force, _ in pairs]).T, np.array([slope[:, 0] for _, slope in pairs]).T

    force, slope = at(way)
    step = 1e-11
    middle = (at(way + step)[0] - at(way - step)[0]) / (2 * step)
    assert (force[:, 0] == 0).all()
    assert force.max() > 2.5 * LOAD
    assert (np.diff(force, axis=1) >= 0).all()
    # the slope changes over 50 nm at first touch, 2e-4 of that is the step
    np.testing.assert_allclose(middle, slope, atol=1e-3 * slope.max())
    # periodic and continuous over the phase
    again = curves(pair, sigma + 1.0)[1]
    np.testing.assert_allclose(again.gap, law.gap, atol=1e-18)


def test_no_load_to_take_it_at(pair: ContactPair) -> None:
    with pytest.raises(ModelError, match="mesh force"):
        contact_table(pair, 0.0)


def test_static_follows_the_table_as_full_contact_does() -> None:
    """Three ways to one state: rows with tables, and segments of every flank in the train's equilibrium."""
    train = load("ren2021", overrides=CONTACT)
    rows = epicyclic.static(train, cycles=1, samples=8)
    full = epicyclic.contact(train, samples=8, loads=[0.3])
    now = full.sel(torque_factor=1.0)
    np.testing.assert_allclose(rows.mesh_force, now.mesh_force, rtol=5e-4)  # 50 phases, 20 slices either way
    np.testing.assert_allclose(rows.displacement, now.displacement, atol=1e-3 * np.abs(now.displacement).max())
    light = {**CONTACT, "operation.torque.sun": "30 kN m"}
    # the table of the heavier operation, at a third of its torque
    from dataclasses import replace

    system = epicyclic.assemble(train)
    again = epicyclic.static(replace(system, force=0.3 * system.force), cycles=1, samples=8)
    np.testing.assert_allclose(again.mesh_force, full.mesh_force.sel(torque_factor=0.3), rtol=5e-3)
    own = load("ren2021", overrides=light).meshes[0]
    assert own.stiffness < train.meshes[0].stiffness  # Hertz stiffens


def test_linear_verbs_take_tangent_and_error_of_the_operating_load() -> None:
    train = load("ren2021", overrides=CONTACT)
    mesh = train.meshes[0]
    assert mesh.table is not None
    assert mesh.stiffness == mesh.table.stiffness
    assert 0.8 < mesh.stiffness / load("ren2021").meshes[0].stiffness < 1.25  # beside ISO 6336
    errors = [error for error in train.mesh_errors if error.mesh == mesh.name and error.cause == "contact"]
    assert len(errors) == 13
    slow = epicyclic.steady(train, relative_speed=0.01)
    rows = epicyclic.static(train, cycles=1, samples=64)
    # far below any mode the linear response is the static state; run-outs are apart in it
    assert float(slow.mesh_force.mean()) == pytest.approx(float(rows.mesh_force.mean()), rel=1e-4)
    assert np.isfinite(epicyclic.modes(train).frequency).all()


def test_errors_of_a_mesh_come_with_its_phase() -> None:
    """The lines of the System, put together over time, are the series of the table at the place of the contact."""
    system = epicyclic.assemble(load("xu2020", overrides=CONTACT))
    train = load("xu2020", overrides=CONTACT)
    time = np.arange(40) / 40
    total = np.zeros((len(train.meshes), time.size))
    for line in system.lines:
        cycles = float(line.frequency / system.tones[0]) * time
        total += (line.gap[:, None] * np.exp(2j * np.pi * cycles)).real
    leads = {float(mesh.lead) for mesh in train.meshes}
    assert len(leads) > 2
    for mesh, error in zip(train.meshes, total, strict=True):
        assert mesh.table is not None
        sigma = mesh.sense * (time + float(mesh.lead))
        waves = np.exp(2j * np.pi * np.outer(sigma, np.arange(len(mesh.table.error))))
        np.testing.assert_allclose(error, (waves @ mesh.table.error).real, atol=1e-12)  # of micrometres


def test_slices_share_the_table() -> None:
    sliced = {**CONTACT, "stages.main.meshes.sun-planet.slices": 3}
    whole = epicyclic.static(load("ren2021", overrides=CONTACT), cycles=1, samples=8)
    cut = epicyclic.static(load("ren2021", overrides=sliced), cycles=1, samples=8)
    # no body of this train tilts: three thirds are the whole
    np.testing.assert_allclose(cut.mesh_force, whole.mesh_force, rtol=1e-8)


def test_needs_face_width_and_contact() -> None:
    with pytest.raises(ModelError, match="face_width"):
        load("lin1999-n3", overrides={"stages.main.meshes.sun-planet.stiffness": "contact"})
    given = load("ren2021", overrides={**CONTACT, "stages.main.meshes.sun-planet.variation": "none"})
    assert given.meshes[0].table is None
    assert not given.meshes[0].variation.size
    assert not any(error.cause == "contact" and "sun" in error.mesh for error in given.mesh_errors)


def test_slopes_never_let_the_table_fall() -> None:
    """Tangents far above three times the secants on either side of a point."""
    gap, force = np.array([[0.0, 1.0, 5.0, 6.0]]), np.array([0.0, 4.0, 5.0, 9.0])
    for tangent in (0.5, 50.0):
        slope = _slopes(gap, force, np.full((1, 3), tangent))
        curve = CubicHermiteSpline(gap[0], force, slope[0])
        assert (np.diff(curve(np.linspace(0.0, 6.0, 601))) >= 0).all()
