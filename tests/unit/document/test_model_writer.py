"""A model written as a file: units at every number, and the same bits when it is read again."""

from __future__ import annotations

import struct
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import epicyclic
from epicyclic.document.document import read
from epicyclic.document.units import KINDS, Bounds, read_quantity
from epicyclic.document.writer import model_text, quantity_text
from epicyclic.train.resolution import resolved_document

MODEL: dict[str, Any] = {
    "format": 2,
    "title": "built in Python",
    "stages": {
        "main": {
            "planets": 3,
            "module": 0.004,
            "face_width": 0.04,
            "pressure_angle": 20 * 0.017453292519943295,
            "helix_angle": 0.3,
            "sun": {"teeth": 24, "support": {"x": 1e8, "y": "2e8 N/m", "z": 0, "rz": float("inf")}, "mass": 12},
            "planet": {"teeth": 30, "bearing": {"x": [1e8, 2e8, 3e8], "damping": 500.0}},
            "ring": {"teeth": 84, "rim": 0.025, "support": {"rz": 1e8}},
            "carrier": {"mass": 40.5, "inertia": 0.5},
            "meshes": {"sun-planet": {"stiffness": {"deflection": [0, 1e-5], "force": [[0, 4e3], [0, 5e3]]}}},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": 157.0}, "torque": {"sun": 800}, "gravity": True},
    "deviations": {"planet": {"run_out": 15e-6}, "sun": {"pitch": [i * 1e-7 for i in range(24)]}},
}


def test_every_number_gets_a_unit_and_keeps_its_bits(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text(model_text(MODEL), encoding="utf-8")
    assert "format = 2" in path.read_text(encoding="utf-8")
    again = read(path)  # refuses a number without a unit
    assert again.warnings == ()
    assert again.model == read(MODEL).model


def test_the_units_are_those_of_drawings() -> None:
    table = tomllib.loads(model_text(MODEL))
    stage = table["stages"]["main"]
    assert (stage["module"], stage["face_width"], stage["pressure_angle"]) == ("4 mm", "40 mm", "20 deg")
    assert stage["helix_angle"] == "0.3 rad"
    assert stage["sun"]["support"] == {"x": "1e8 N/m", "y": "2e8 N/m", "z": 0, "rz": "inf"}
    assert stage["sun"]["mass"] == "12 kg"
    assert stage["planet"]["bearing"]["x"] == "[1e8, 2e8, 3e8] N/m"
    assert stage["meshes"]["sun-planet"]["stiffness"]["force"] == ["[0, 4000] N", "[0, 5000] N"]
    assert table["deviations"]["main"]["planet"]["run_out"] == {"amplitude": "15 um"}


@settings(deadline=None)  # pint is imported by the first
@given(
    st.floats(-1e4, 1e4).filter(lambda x: not 0 < abs(x) < 1e-60),
    st.sampled_from([kind for kind in KINDS if KINDS[kind].unit]),
)
def test_any_number_keeps_its_bits(number: float, kind: str) -> None:
    read = read_quantity(quantity_text(number, kind), (kind,), Bounds(), listed=True)
    assert struct.pack("d", read) == struct.pack("d", number)


@pytest.mark.parametrize("drive", ["ren2021", "xu2020", "dong2019", "encased-differential"])
def test_a_resolved_drive_is_a_file(drive: str, tmp_path: Path) -> None:
    train = epicyclic.load(drive)
    path = tmp_path / "resolved.toml"
    path.write_text(model_text(resolved_document(train)), encoding="utf-8")
    again = read(path)
    assert again.model == read(resolved_document(train)).model
