"""Coupled stages in tables and figures: every mesh at the mesh frequency of its own stage, labelled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.charts.over_time import spectrogram, transient_forces
from epicyclic.show.elements import Table
from epicyclic.show.series import engineering
from epicyclic.show.views import brief_of, headline_of, key_figures_of, tables_of

_GEARS = {"module": "4 mm", "face_width": "40 mm", "carrier": {"mass": "20 kg", "inertia": "0.3 kg m^2"}}
TRAIN: dict[str, Any] = {
    "format": 2,
    "title": "two torsional stages",
    "damping": {"modal": 0.1},
    "stages": {
        name: {**_GEARS, "planets": 3, "sun": {"teeth": sun}, "planet": {"teeth": 30}, "ring": {"teeth": sun + 60}}
        for name, sun in (("one", 24), ("two", 27))
    },
    "couplings": {"mid": {"between": ["one.carrier", "two.sun"], "rz": "2e6 N m/rad"}},
    "operation": {
        "held": ["one.ring", "two.ring"],
        "speed": {"one.sun": "1500 rpm"},
        "torque": {"one.sun": "500 N m"},
    },
}
# mesh frequencies: (1500 rpm - carrier) z_sun
TONES = {"one": 1500 / 60 * 24 * 84 / 108, "two": 1500 / 60 * 24 / 108 * 27 * 87 / 114}


def column(table: Table, heading: str) -> dict[str, float]:
    names = table.columns["mesh"]
    return dict(zip(names, table.columns[heading], strict=True))


@pytest.fixture(scope="module")
def moved() -> xr.Dataset:
    return epicyclic.transient(TRAIN, cycles=4, samples=16)


def test_transient_names_the_mesh_frequency_of_each_stage(moved: xr.Dataset) -> None:
    found = column(tables_of(moved)[0], "mesh frequency of its stage there [Hz]")
    for mesh, frequency in found.items():
        assert frequency == pytest.approx(TONES[mesh.split("/")[0]], rel=1e-9)
    # a result of an earlier version has that of the first mesh alone
    (old, *_) = tables_of(moved.drop_vars("mesh_tone"))
    assert list(column(old, "mesh frequency of one there [Hz]").values()) == pytest.approx([TONES["one"]] * 12)


def test_orders_of_a_spectrogram_are_those_of_its_mesh(moved: xr.Dataset) -> None:
    for mesh in ("one/sun-planet/1", "two/sun-planet/1"):
        first = next(trace for trace in spectrogram(moved, mesh).data if trace.type == "scatter")
        assert first.y[0] == pytest.approx(TONES[mesh.split("/")[0]])


def test_a_ramp_says_of_which_stage_it_is(moved: xr.Dataset) -> None:
    ramp = moved.assign_coords(mesh_frequency=("time", np.linspace(100.0, 200.0, moved.sizes["time"])))
    assert "mesh frequency of one" in [note.text for note in transient_forces(ramp).layout.annotations]


def test_sweep_names_the_mesh_frequency_of_each_stage() -> None:
    speeds = np.array([0.5, 1.0])
    swept = epicyclic.sweep(TRAIN, relative_speed=speeds)
    forces = tables_of(swept)[0]
    assert "mesh frequency of one" in forces.title
    for heading in ("at mesh frequency of its stage [Hz]", "K_v at [Hz]"):
        for mesh, frequency in column(forces, heading).items():
            assert np.isclose(frequency, speeds * TONES[mesh.split("/")[0]], rtol=1e-9).any()
    bodies = next(table for table in tables_of(swept) if "Accelerations" in table.title)
    assert "at mesh frequency of one [Hz]" in bodies.columns
    rms = swept.mesh_force_rms.transpose("mesh", "speed").values
    place, at = np.unravel_index(rms.argmax(), rms.shape)
    own = float(speeds[at]) * TONES[str(swept.mesh.values[place]).split("/")[0]]
    (words,) = [words for _, words in key_figures_of({"sweep": swept}) if "largest RMS" in words]
    assert f"{engineering(own)} Hz" in words


REVERSED: dict[str, Any] = {**TRAIN, "operation": {**TRAIN["operation"], "held": ["one.carrier", "two.ring"]}}
REVERSED["couplings"] = {"mid": {"between": ["one.ring", "two.sun"], "rz": "2e6 N m/rad"}}
SPEEDING: dict[str, Any] = {"operation": {"held": ["one.carrier", "two.ring"], "speed": {"two.carrier": "50 rpm"}}}
SPEEDING["operation"]["torque"] = {"two.carrier": "500 N m"}


@pytest.mark.parametrize(
    ("train", "ratio"),
    [
        (TRAIN, f"{(108 / 24) * (114 / 27):.6g}"),
        (REVERSED, f"{(84 / 24) * (114 / 27):.6g}, in opposite senses"),
        ({**REVERSED, **SPEEDING}, f"1 : {(84 / 24) * (114 / 27):.6g}, in opposite senses"),
    ],
)
def test_table_and_headline_say_one_ratio_with_the_senses(train: dict[str, Any], ratio: str) -> None:
    """Willis: 1 + z_ring / z_sun with the ring held, z_ring / z_sun and reversed with the carrier held."""
    result = epicyclic.check(train)
    members = next(table for table in brief_of(result) if table.title.startswith("Members"))
    ends = "two.carrier to one.sun" if ratio.startswith("1 :") else "one.sun to two.carrier"
    assert members.lead.startswith(f"Ratio {ends} {ratio} (")
    assert headline_of({"check": result}).startswith(f"Ratio {ratio}; ")


@pytest.mark.parametrize("held", ["one.ring", "one.carrier"])
def test_a_coupling_carries_what_balances_its_stage(held: str) -> None:
    """The second stage takes the torque of the coupling in at its sun: the ring held, T_ring = T_sun z_ring / z_sun.

    With the first ring held its carrier puts on the coupling T_sun (1 + z_ring / z_sun) at the speed of that part of
    the sun; with the first carrier held its ring puts -T_sun z_ring / z_sun on it.
    """
    inner, part = {"one.ring": ("one.carrier", 1 + 84 / 24), "one.carrier": ("one.ring", -84 / 24)}[held]
    train = {**TRAIN, "operation": {**TRAIN["operation"], "held": [held, "two.ring"]}}
    train["couplings"] = {"mid": {"between": [inner, "two.sun"], "rz": "2e6 N m/rad"}}
    result = epicyclic.check(train)
    (table,) = (table for table in brief_of(result) if table.title.startswith("Couplings"))
    assert (table.columns["coupling"], table.columns["from"], table.columns["to"]) == (["mid"], [inner], ["two.sun"])
    assert table.columns["torque [N m]"] == pytest.approx([500 * part], rel=1e-12)
    assert table.columns["speed [rpm]"] == pytest.approx([1500 / part], rel=1e-12)
    torque = dict(zip(result.body.values, result.torque.values, strict=True))
    assert torque["two/ring"] == pytest.approx(500 * part * 87 / 27, rel=1e-12)
    assert torque["two/carrier"] == pytest.approx(-500 * part * (1 + 87 / 27), rel=1e-12)
