"""The door of linear analyses: tangents of flanks in place of their laws, and what the warning of a pair says."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicHermiteSpline

import epicyclic
from epicyclic.questions.modes.eigen import eigen
from epicyclic.questions.response.response import response
from epicyclic.questions.transient.equation import motion
from epicyclic.statics.tangent import flank_warnings, linear
from epicyclic.system.flank_laws import LawRows, TabulatedLaw
from epicyclic.system.gaps import flanks
from epicyclic.system.system import System
from epicyclic.teeth.mesh_stiffness import evaluate_series
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
PAIRS = tuple(f"stages.main.meshes.{pair}" for pair in ("sun-planet", "planet-ring"))
CONTACT = {f"{pair}.stiffness": "contact" for pair in PAIRS}
LOAD = 4e3


@pytest.fixture(scope="module")
def tabulated() -> System:
    return epicyclic.assemble(load("ren2021", overrides=CONTACT))


def straight(system: System, rows: ArrayLike, touch: Array, **changes: Any) -> System:
    """The system with one straight table a row through the operating point of the tangent, from touch (S,) [m]."""
    index = np.asarray(rows, np.int64)
    meet = LOAD / float(system.meshes.stiffness[index[0]])
    slope = LOAD / (meet - touch)
    law = TabulatedLaw(
        tone=system.meshes.tone[index],
        lead=np.zeros(index.size),
        sense=np.ones(index.size),
        force=LOAD * np.arange(3.0),
        gap=touch[:, None] + LOAD * np.arange(3.0) / slope[:, None],
        slope=np.repeat(slope[:, None], 3, axis=1),
        **{"load": np.full(index.size, LOAD), **changes},
    )
    return replace(system, meshes=replace(system.meshes, laws=(*system.meshes.laws, LawRows(law=law, rows=index))))


@pytest.mark.parametrize("touch", [-1.2e-6, 1.2e-6])
def test_the_numbers_of_a_straight_table_by_hand(build: Any, touch: float) -> None:
    """f = F (delta - t) / (F / k - t), so that at delta = F / 2k the tangent is F / 2 and f = F (d - t) / (2 d - t)."""
    plain = build.planar(N=3).system()
    system = straight(plain, np.arange(3), np.full(4, touch))
    (text,) = flank_warnings(system)
    half = LOAD / (2 * float(plain.meshes.stiffness[0]))
    error = 0.5 * (2 * half - touch) / (half - touch) - 1
    assert text.startswith(f"{plain.meshes.pair[0]}: tangent at 4 kN in place of the law of its gaps:")
    assert f"teeth touch 1.2 µm {'after' if touch > 0 else 'before'} the tangent does" in text
    assert f"its force is {abs(error) * 100:.2g} % {'above' if touch > 0 else 'below'} that of the law" in text
    assert (error > 0) == (touch > 0)


def test_the_worst_of_the_mesh_cycle_with_its_sign(build: Any) -> None:
    system = straight(build.planar(N=3).system(), np.arange(3), np.array([0.3e-6, 0.0, -0.9e-6, 0.0]))
    (text,) = flank_warnings(system)
    assert "0.9 µm before" in text
    assert "% below" in text


def test_a_load_that_is_not_known_and_a_law_open_at_half_the_load(build: Any) -> None:
    plain = build.planar(N=3).system()
    (text,) = flank_warnings(straight(plain, np.arange(3), np.full(4, 1e-6), load=np.full(3, np.nan)))
    assert text.endswith(
        "in place of the law of its gaps: teeth touch 1 µm after the tangent does (worst of the mesh cycle) "
        "[law-linearised]"
    )
    meet = LOAD / float(plain.meshes.stiffness[0])
    (text,) = flank_warnings(straight(plain, np.arange(3), np.full(4, 0.6 * meet)))
    assert "where the tangent gives half of that load, the law gives no force" in text


def test_a_pair_speaks_once_for_rows_of_several_laws(build: Any) -> None:
    plain = build.planar(N=3).system()
    several = straight(straight(plain, np.arange(1), np.full(4, 0.2e-6)), np.array([1, 2]), np.full(4, 0.7e-6))
    (text,) = flank_warnings(several)
    assert "0.7 µm after" in text
    both = straight(several, np.arange(3, 6), np.full(4, 0.1e-6))
    assert [text.split(":")[0] for text in flank_warnings(both)] == list(dict.fromkeys(plain.meshes.pair))


def test_the_numbers_of_a_drive_by_another_route(tabulated: System) -> None:
    """Table of the pair itself, between its loads by SciPy's cubic of Hermite, at the phases of the table."""
    train = load("ren2021", overrides=CONTACT)
    for pair, text in zip(PAIRS, flank_warnings(tabulated), strict=True):
        first, least = 0.0, 0.0
        for mesh in train.meshes:
            table = mesh.table
            if mesh.pair != pair or table is None:
                continue
            sigma = np.arange(len(table.gap)) / len(table.gap)
            stiffness = table.stiffness * evaluate_series(table.variation, sigma)
            for gap, slope, k in zip(table.gap, table.slope, stiffness, strict=True):
                force = float(CubicHermiteSpline(gap, table.force, slope)(table.load / 2 / k))
                first, least = min(first, gap[0]), min(least, table.load / 2 / force - 1)
        found = re.search(r"tangent at (\S+) kN.* touch (\S+) µm before.* (\S+) % below", text)
        assert found is not None
        assert float(found[1]) == pytest.approx(train.meshes[0].table.load / 1e3, rel=1e-3)  # type: ignore[union-attr]
        # two digits, and 64 phases beside 50
        assert float(found[2]) == pytest.approx(-first * 1e6, rel=0.05)
        assert float(found[3]) == pytest.approx(-least * 100, rel=0.05)


def test_slices_and_far_flanks_do_not_speak_for_themselves(tabulated: System) -> None:
    """Slices share one table and its load; a far flank is behind the backlash in either model."""
    for key, value in (("slices", 3), ("backlash", "0.2 mm")):
        system = epicyclic.assemble(load("ren2021", overrides={**CONTACT, f"{PAIRS[0]}.{key}": value}))
        assert list(flank_warnings(system)) == list(flank_warnings(tabulated))
    assert system.far_flanks.laws
    assert not linear(system).far_flanks.laws
    assert flanks(linear(system)).parametric


def test_the_door_leaves_numbers_and_speaks_once(tabulated: System) -> None:
    through = linear(tabulated)
    assert through.warnings == (*tabulated.warnings, *flank_warnings(tabulated))
    assert len(through.warnings) == len(tabulated.warnings) + 2
    assert not through.meshes.laws
    assert linear(through) is through
    for name in ("K", "C", "M", "force"):
        assert getattr(through, name) is getattr(tabulated, name)
    for name in ("B", "stiffness", "variation", "damping"):
        assert getattr(through.meshes, name) is getattr(tabulated.meshes, name)
    assert through.lines is tabulated.lines
    assert response(tabulated).system.warnings == through.warnings
    np.testing.assert_array_equal(eigen(through).omega_squared, eigen(tabulated).omega_squared)


def test_who_asks_the_laws_keeps_them_without_a_warning(tabulated: System) -> None:
    assert linear(tabulated, asks_laws=True) is tabulated
    kept = response(tabulated, asks_laws=True).system
    assert kept.meshes.laws
    assert kept.warnings == tabulated.warnings
    assert not motion(tabulated).warnings
    assert motion(tabulated, contact="linear").system.warnings == linear(tabulated).warnings


def test_a_link_with_a_law_beside_a_table_has_its_own_warning() -> None:
    overrides = {**CONTACT, "stages.main.sun.support.radial": "1e9 N/m", "stages.main.sun.support.clearance": "1 um"}
    system = epicyclic.assemble(load("ren2021", overrides=overrides))
    kept, through = linear(system, asks_laws=True), linear(system)
    assert kept.meshes.laws
    assert not kept.groups
    assert kept.warnings == system.warnings
    said = through.warnings[len(system.warnings) :]
    assert said[:-1] == tuple(flank_warnings(system))
    assert said[-1].startswith("linearised: main/sun/support: play pressed at the mean load")
    np.testing.assert_array_equal(kept.K, through.K)


def test_a_straight_table_keeps_the_names_and_forces_of_a_linear_link() -> None:
    """A radial table of one slope is the linear link: rows x and y, in steady vibration and in static equilibrium."""
    table = {"deflection": "[0, 1, 2] mm", "force": "[0, 1, 2] MN"}
    key = "stages.main.planet.bearing.radial"
    given, plain = (epicyclic.steady("ren2021", overrides={key: value}, samples=8) for value in (table, "1e9 N/m"))
    assert sorted(given.link_row.values) == sorted(plain.link_row.values)
    same = given.link_force.sel(link_row=plain.link_row)
    size = float(np.abs(plain.link_force).max())
    np.testing.assert_allclose(same, plain.link_force, atol=1e-9 * size)
    assert given.link_force.attrs["units"] == "N, N m for rx ry rz"


def test_friction_with_a_memory_sticks_for_every_analysis_of_vibration() -> None:
    support = {"radial": "1e9 N/m", "clearance": "1 um", "friction": {"force": "60 N", "law": "coulomb"}}
    system = epicyclic.assemble(load("ren2021", overrides={"stages.main.sun.support": support}))
    for asks_laws in (False, True):
        (text,) = linear(system, asks_laws=asks_laws).warnings[len(system.warnings) :]
        assert text.startswith("linearised: main/sun/support: coulomb spline sticks in small vibration")


@pytest.mark.parametrize("name", ["ren2021", "xu2020", "lin1999-n3"])
def test_a_train_without_tables_has_no_laws_and_goes_through_as_it_is(name: str) -> None:
    system = epicyclic.assemble(load(name))
    assert system.meshes.laws == ()
    assert system.far_flanks.laws == ()
    assert linear(system) is system
    assert linear(system, asks_laws=True) is system


def test_the_load_of_a_row_is_its_share_of_that_of_the_table() -> None:
    train = load("ren2021", overrides={**CONTACT, f"{PAIRS[0]}.slices": 4, f"{PAIRS[0]}.backlash": "0.2 mm"})
    system = epicyclic.assemble(train)
    given = flanks(system)
    load_of = np.full(len(given.mesh), np.nan)
    for part in given.laws:
        load_of[part.rows] = part.law.load
        np.testing.assert_array_equal(part.law.rows([0]).load, part.law.load[:1])
    share = np.where(np.array(system.meshes.slice) > 0, 4, 1)[given.mesh]
    table = train.meshes[0].table
    assert table is not None
    np.testing.assert_allclose(load_of * share, table.load, rtol=1e-12)
