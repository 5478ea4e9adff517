"""Datasets keep units, provenance and every value through JSON and netCDF."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from epicyclic.errors import ModelError
from epicyclic.results.dataset import dataset, load_result, save_result, to_json
from epicyclic.results.variables import VARIABLES


@pytest.fixture
def result() -> xr.Dataset:
    return dataset(
        {
            "frequency": ("mode", [0.0, 12.5]),
            "shape": (("dof", "mode"), np.array([[1 + 2j, 0.5], [0.0, -1j]])),
            "mode_kind": ("mode", ["rotational", "planet"]),
            "contact_lost": ("mesh", [True, False]),
        },
        {"dof": ["a/x", "a/rz"], "mesh": ["m1", "m2"]},
        verb="modes",
        options={"damped": True},
        provenance={"title": "a train"},
        warnings=["a warning"],
    )


def test_units_names_and_provenance(result: xr.Dataset) -> None:
    assert result["frequency"].attrs == {"units": "Hz", "long_name": "natural frequency"}
    assert json.loads(result.attrs["warnings"]) == ["a warning"]
    assert json.loads(result.attrs["options"]) == {"damped": True}
    assert result.attrs["title"] == "a train"
    assert result.attrs["version"]


def test_a_variable_without_a_meaning_is_refused() -> None:
    with pytest.raises(KeyError, match="nonsense"):
        dataset({"nonsense": ("x", [1.0])}, verb="modes")
    assert all(name and unit is not None for unit, name in VARIABLES.values())


def test_netcdf_round_trip_is_identical(result: xr.Dataset, tmp_path: Path) -> None:
    path = save_result(result, tmp_path / "result.nc")
    assert not list(tmp_path.glob("*.part"))
    again = load_result(path)
    xr.testing.assert_identical(again.sortby("mode"), result.sortby("mode"))
    assert again["contact_lost"].dtype == bool


def test_json_reads_back_as_a_dataset(result: xr.Dataset) -> None:
    again = xr.Dataset.from_dict(json.loads(to_json(result)))
    assert again["shape"].dims == ("dof", "mode", "part")
    assert again["shape"].values[..., 0] + 1j * again["shape"].values[..., 1] == pytest.approx(result["shape"].values)
    assert again["frequency"].attrs == result["frequency"].attrs


def test_files_that_cannot_be_read_or_written(result: xr.Dataset, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such file"):
        load_result(tmp_path / "absent.nc")
    (tmp_path / "text.nc").write_text("not netCDF", encoding="utf-8")
    with pytest.raises(ModelError, match="not a result file"):
        load_result(tmp_path / "text.nc")
    with pytest.raises(ModelError, match="cannot be written"):
        save_result(result, tmp_path / "no" / "folder" / "result.nc")


@pytest.mark.parametrize("name", ["modes.csv", "modes", "modes.html", "modes.h5", "modes.NC.txt"])
def test_a_suffix_that_is_no_result_file_is_refused(result: xr.Dataset, tmp_path: Path, name: str) -> None:
    with pytest.raises(ModelError, match=r"allowed: \.nc or \.json") as error:
        save_result(result, tmp_path / name)
    assert name in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_json_file_reopens_equal(result: xr.Dataset, tmp_path: Path) -> None:
    path = save_result(result, tmp_path / "result.JSON")
    assert json.loads(path.read_text(encoding="utf-8")) == json.loads(to_json(result))
    xr.testing.assert_identical(load_result(path), result)
    (tmp_path / "wrong.json").write_text('{"a": 1}', encoding="utf-8")
    with pytest.raises(ModelError, match="not a result file"):
        load_result(tmp_path / "wrong.json")
