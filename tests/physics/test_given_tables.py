"""Tables of force over deflection against the laws that they are tables of, in the analyses."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.system.flank_laws import TabulatedLaw
from epicyclic.system.system import System

Array = NDArray[np.float64]
ROOT = Path(__file__).parents[2]
PAIRS = ("sun-planet", "planet-ring")
BASE: dict[str, Any] = {
    "format": 2,
    "title": "a set with a pin out of place",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "helix_angle": "12 deg",
            "sun": {"teeth": 22, "support": {"radial": "2e8 N/m", "z": "1e8 N/m", "tilt": "1e6 N m/rad"}},
            "planet": {"teeth": 23, "bearing": {"radial": "4e8 N/m", "z": "1e8 N/m"}},
            "ring": {"teeth": 68, "rim": "25 mm", "support": {"radial": "1e9 N/m"}},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2", "support": {"radial": "3e8 N/m"}},
            "meshes": {pair: {"stiffness": "6e8 N/m", "slices": 1} for pair in PAIRS},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
    "deviations": {"planet": {"run_out": "15 um", "position": {"y": "[40, 0, 0] um"}}},
}
X = np.array([0.0, 4, 10, 30]) * 1e-6


def system(changes: dict[str, Any] | None = None, base: dict[str, Any] = BASE) -> System:
    return epicyclic.assemble(epicyclic.load(deepcopy(base), changes or {}))


def meshes(key: str, value: Any) -> dict[str, Any]:
    return {f"stages.main.meshes.{pair}.{key}": value for pair in PAIRS}


def table(deflection: Array, force: Array) -> dict[str, Any]:
    return {"deflection": deflection.tolist(), "force": force.tolist()}


def differ(one: xr.Dataset, other: xr.Dataset, name: str) -> float:
    return float(np.abs(one[name] - other[name]).max() / np.abs(other[name]).max())


STRAIGHT = meshes("stiffness", table(X, 6e8 * X))


def test_a_straight_table_of_a_mesh_is_its_stiffness() -> None:
    tabulated, linear = system(STRAIGHT), system()
    assert [type(part.law) for part in tabulated.meshes.laws] == [TabulatedLaw] * 2
    np.testing.assert_allclose(tabulated.meshes.stiffness, linear.meshes.stiffness, rtol=1e-14)
    assert not tabulated.meshes.variation.any()
    assert [line.frequency for line in tabulated.lines] == [line.frequency for line in linear.lines]
    assert not epicyclic.load(BASE, STRAIGHT).mesh_errors
    one, other = epicyclic.static(tabulated, cycles=2), epicyclic.static(linear, cycles=2)
    assert differ(one, other, "mesh_force") < 1e-11
    assert differ(one, other, "displacement") < 1e-9
    mine, theirs = epicyclic.steady(tabulated), epicyclic.steady(linear)
    assert differ(mine, theirs, "mesh_force") < 1e-9


def test_a_straight_table_of_a_mesh_in_a_transient() -> None:
    one, other = (epicyclic.transient(s, duration=0.02) for s in (system(STRAIGHT), system()))
    assert differ(one, other, "mesh_force") < 1e-7


@pytest.mark.parametrize("changes", [meshes("slices", 3), meshes("direction", "transverse"), meshes("backlash", 3e-5)])
def test_slices_directions_and_far_flanks_of_a_straight_table(changes: dict[str, Any]) -> None:
    one, other = epicyclic.static(system({**STRAIGHT, **changes})), epicyclic.static(system(changes))
    assert differ(one, other, "mesh_force") < 1e-11
    if "face_load_factor" in other:
        assert differ(one, other, "face_load_factor") < 1e-11
        assert float(other.face_load_factor.max()) > 1.01  # the slices differ


def test_a_far_flank_of_fewer_orders_than_another_mesh() -> None:
    """Backlash at the mesh of fewer orders alone: the rows of both flanks have the orders of all."""
    changes = {
        "stages.main.meshes.sun-planet.variation": {"cosine": [0.1], "sine": [0.05]},
        "stages.main.meshes.sun-planet.backlash": "0.1 mm",
        "stages.main.meshes.planet-ring.variation": "contact-lines",
    }
    found = system(changes)
    assert found.meshes.variation.shape == (6, 12)
    assert found.far_flanks.variation.shape == (3, 12)
    assert epicyclic.static(found, cycles=1).mesh_force.shape[0] == 6


SIGMA = np.arange(48) / 48
VALUES = 1 + 0.15 * np.cos(2 * np.pi * SIGMA) + 0.08 * np.sin(4 * np.pi * SIGMA)
OVER_PHASES = meshes("stiffness", {"deflection": X.tolist(), "force": [(6e8 * v * X).tolist() for v in VALUES]})
VARYING = meshes("variation", {"values": VALUES.tolist()})


def test_a_table_over_phases_is_a_stiffness_that_varies() -> None:
    """Every branch at its own phase, in its own sense."""
    tabulated, linear = system(OVER_PHASES), system(VARYING)
    L = tabulated.meshes.variation.shape[1]
    np.testing.assert_allclose(tabulated.meshes.variation, linear.meshes.variation[:, :L], atol=1e-12)
    one, other = epicyclic.static(tabulated, cycles=2), epicyclic.static(linear, cycles=2)
    varies = float((other.mesh_force.max("time") - other.mesh_force.min("time")).max() / other.mesh_force.max())
    assert differ(one, other, "mesh_force") < 1e-3 * varies  # cubics between 48 phases, or a series
    reversed_ = replace(
        tabulated.meshes,
        laws=tuple(
            replace(part, law=replace(part.law, sense=-part.law.sense))  # type: ignore[type-var, attr-defined]
            for part in tabulated.meshes.laws
        ),
    )
    wrong = epicyclic.static(replace(tabulated, meshes=reversed_), cycles=2)
    assert differ(wrong, other, "mesh_force") > 0.05 * varies  # the phases count


def test_a_table_over_phases_where_contact_is_lost() -> None:
    alike = {"deviations": None}
    options: Any = {"contact_loss": True, "start": "1800 Hz", "stop": "2100 Hz", "points": 4}
    one, other = (epicyclic.sweep(system({**changes, **alike}), **options) for changes in (OVER_PHASES, VARYING))
    assert float(other.contact_open.max()) > 0.1
    for name in ("mesh_force_rms", "mesh_force_minimum"):
        np.testing.assert_allclose(one[name], other[name], atol=3e-4 * float(other[name].max()))
    np.testing.assert_allclose(one.contact_open, other.contact_open, atol=0.005)  # one sample of 256


def test_the_table_of_loaded_contact_put_back_gives_its_forces() -> None:
    base = deepcopy(BASE)
    stage = base["stages"]["main"]
    stage |= {"helix_angle": "0 deg", "flank": {"tip_relief": {"amount": "10 um", "length": "2 mm"}}}
    base["operation"]["torque"]["sun"] = "1600 N m"
    stage["sun"]["support"]["radial"] = stage["carrier"]["support"]["radial"] = "1e9 N/m"
    base["deviations"]["planet"]["position"]["y"] = "[80, 0, 0] um"
    contact = epicyclic.load(base, meshes("stiffness", "contact"))
    given = {}
    for pair in PAIRS:
        own = next(mesh.table for mesh in contact.meshes if mesh.pair.endswith(pair))
        assert own is not None
        given[f"stages.main.meshes.{pair}.stiffness"] = table(own.approach, own.force)
    exact, again = epicyclic.assemble(contact), system(given, base)
    one, other = epicyclic.static(again), epicyclic.static(exact)
    assert differ(one, other, "mesh_force") < 3e-4
    tangent = epicyclic.static(replace(exact, meshes=replace(exact.meshes, laws=())))
    assert differ(tangent, other, "mesh_force") > 2e-3  # the tangents alone do not


def test_the_operating_load_is_of_the_operation_else_stated_else_the_middle() -> None:
    bent = {"deflection": X.tolist(), "force": (2e13 * X**2 + 2e8 * X).tolist()}
    path = "stages.main.meshes.sun-planet.stiffness"
    train = epicyclic.load(BASE, {path: bent})
    mesh = train.meshes[0]
    assert mesh.table is not None
    lever = mesh.radius_b * np.cos(mesh.pressure_angle) * np.cos(mesh.base_helix)
    passed = train.kinematics.mesh_torque[mesh.pair] / 3  # type: ignore[index]
    assert mesh.table.load == pytest.approx(abs(passed) / lever, rel=1e-12)
    stated = epicyclic.load(BASE, {path: {**bent, "load": "2 kN"}})
    still = epicyclic.load(BASE, {path: bent, "operation.torque.sun": None})
    for one, load, origin in (
        (train, None, "operation"),
        (stated, 2e3, "set"),
        (still, 12e3, "half of the last force"),
    ):
        note = next(value for value in one.values if value.path == f"{path}.load")
        assert note.origin == origin
        assert load is None or (note.value, one.meshes[0].table.load) == pytest.approx((load, load))  # type: ignore[union-attr]
    assert stated.meshes[0].stiffness < train.meshes[0].stiffness
    beyond = epicyclic.load(BASE, {path: {"deflection": X.tolist(), "force": (1e8 * X).tolist()}})
    assert [text for text in beyond.warnings if "lies behind the last force of the table, 3000 N" in text]


def test_a_variation_beside_a_table_is_refused() -> None:
    changes = {**STRAIGHT, "stages.main.meshes.sun-planet.variation": "contact-lines"}
    with pytest.raises(epicyclic.ModelError, match=r"sun-planet\.variation = contact-lines: stands beside a table"):
        epicyclic.load(BASE, changes)


# links ----------------------------------------------------------------------------------------------------------------


def test_straight_tables_of_links_are_their_stiffness() -> None:
    rad = np.array([0, 1e-4, 1e-3])
    numbers = {
        "stages.main.sun.support.radial": "2e8 N/m",
        "stages.main.sun.support.tilt": "1e6 N m/rad",
        "stages.main.sun.support.rz": "1e4 N/m",
        "stages.main.planet.bearing.radial": "4e8 N/m",
        "stages.main.planet.bearing.z": "1e8 N/m",
    }
    tables = {
        "stages.main.sun.support.radial": table(X, 2e8 * X),
        "stages.main.sun.support.tilt": table(rad, 1e6 * rad),
        "stages.main.sun.support.rz": {"deflection": "[0, 30] um", "force": "[0, 0.3] N"},
        "stages.main.planet.bearing.radial": table(X, 4e8 * X),
        "stages.main.planet.bearing.z": table(X, 1e8 * X),
    }
    tabulated, linear = system(tables), system(numbers)
    assert [group.name for group in tabulated.groups][:3] == [
        f"main/sun/support/{part}" for part in ("radial", "tilt", "rz")
    ]
    one, other = epicyclic.static(tabulated), epicyclic.static(linear)
    assert differ(one, other, "mesh_force") < 1e-9
    assert differ(one, other, "displacement") < 1e-8
    frequencies = [epicyclic.modes(s).frequency.values for s in (tabulated, linear)]
    np.testing.assert_allclose(frequencies[0], frequencies[1], rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
    ("law", "points", "accuracy"),
    [
        ({"clearance": "20 um", "radial": "4e8 N/m"}, [0, 20, 60], 1e-9),
        ({"exponent": 10 / 9, "load": "3 kN", "radial": "4e8 N/m"}, (np.linspace(0, 1, 40) ** 2 * 60).tolist(), 1e-4),
    ],
    ids=["play", "rolling"],
)
def test_tables_sampled_from_a_law_are_that_law(law: dict[str, Any], points: list[float], accuracy: float) -> None:
    path = "stages.main.planet.bearing"
    formula = system({f"{path}.{key}": value for key, value in law.items()})
    rho = np.array(points) * 1e-6
    (profile, _), *_ = formula.laws.profiles
    force = profile.parts(np.repeat(rho[:, None], 3, axis=1))[0][:, 0]
    one, other = epicyclic.static(system({f"{path}.radial": table(rho, force)})), epicyclic.static(formula)
    linear = epicyclic.static(system({f"{path}.radial": table(X, 4e8 * X)}))
    for name in ("mesh_force", "group_force", "group_stretch"):
        assert differ(one, other, name) < accuracy
    assert differ(linear, other, "group_stretch") > 100 * accuracy


def test_a_bearing_in_two_plates_has_half_of_the_force_in_each() -> None:
    train = epicyclic.load(
        BASE,
        {
            "stages.main.carrier.split": True,
            "stages.main.carrier.neck": {},
            "stages.main.planet.bearing.radial": table(X, 4e8 * X),
        },
    )
    halves = [link for link in train.links if link.name.startswith("main/planet/1/bearing")]
    assert [link.name[-5:] for link in halves] == ["/left", "right"]
    for link in halves:
        assert dict(link.curves)[0].force == tuple((2e8 * X).tolist())
        assert link.stiffness[:2] == pytest.approx((2e8, 2e8), rel=1e-12)


def test_static_says_by_how_much_a_link_passes_the_end_of_its_table() -> None:
    short = table(X / 30, 4e8 * X / 30)  # up to 400 N
    result = epicyclic.static(system({"stages.main.planet.bearing.radial": short}))
    ratio = float(result.group_force.max()) / 400
    texts = [text for text in json.loads(result.attrs["warnings"]) if "times the last force of its table" in text]
    assert [text.split(":")[0] for text in texts] == [f"main/planet/{i}/bearing" for i in (1, 2, 3)]
    assert f"forces reach {ratio:.4g} times the last force of its table, 400 N;" in "".join(texts)
    whole = epicyclic.static(system({"stages.main.planet.bearing.radial": table(2 * X, 8e8 * X)}))
    assert "its table" not in whole.attrs["warnings"]


def test_results_hold_the_numbers_of_a_table() -> None:
    result = epicyclic.static(system({"stages.main.sun.support.radial": table(X, 2e8 * X)}))
    law = json.loads(result.attrs["laws"])["main/sun/support"]
    assert law["deflection"] == X.tolist()
    assert law["kind"] == "table"
    stage = json.loads(result.attrs["model"])["stages"]["main"]
    assert stage["sun"]["support"]["x"] == table(X, 2e8 * X)


def test_the_example_of_the_page_runs() -> None:
    """docs/theory/laws.md, Tables of your own: its lines are those of the files, its figures those of the analyses."""
    folder, page = ROOT / "examples" / "tables", (ROOT / "docs" / "theory" / "laws.md").read_text(encoding="utf-8")
    files = (folder / "reducer.toml").read_text() + (folder / "sun-planet.csv").read_text()
    section = page.partition("## Tables of your own")[2]
    shown = [line.strip() for line in section.splitlines() if line.startswith("    ") and "..." not in line]
    assert len(shown) == 8
    assert all(line in files for line in shown)
    train = epicyclic.load(folder / "reducer.toml")
    mesh = train.meshes[0]
    assert mesh.table is not None
    assert f"{mesh.table.load / 1e3:.2f} kN and\n{mesh.stiffness / 1e8:.2f}e8 N/m" in section
    tangents = epicyclic.assemble(train)
    bearing = next(text for text in epicyclic.modes(tangents).attrs["warnings"].split('"') if "planet/1" in text)
    assert f"{float(bearing.split('along it ')[1].split()[0]) / 1e8:.2f}e8 N/m along the load" in section
    sun = slice(0, 3)
    assert not epicyclic.static(tangents).contact_lost.values[sun].any()
    swept = epicyclic.sweep(tangents, start="200 Hz", stop="1500 Hz", points=5)
    assert np.isfinite(swept.mesh_force_rms.values).all()
