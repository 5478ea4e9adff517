"""Datasets keep units, provenance and every value through JSON and netCDF."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from epicyclic.errors import ModelError
from epicyclic.results.dataset import dataset, load_result, save_result, to_json
from epicyclic.results.variables import VARIABLES
from epicyclic.warning_codes import coded


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
        warnings=[coded("no-damping", "a warning")],
    )


def test_units_names_and_provenance(result: xr.Dataset) -> None:
    assert result["frequency"].attrs == {"units": "Hz", "long_name": "natural frequency"}
    assert json.loads(result.attrs["warnings"]) == ["a warning [no-damping]"]
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


def _no_json(name: str) -> None:
    raise AssertionError(name)


def test_json_has_no_nan_and_no_infinity(result: xr.Dataset, tmp_path: Path) -> None:
    odd = result.assign(
        frequency=("mode", [np.nan, -np.inf]),
        power_loss=((), np.nan),
        shape=(("dof", "mode"), np.array([[complex(np.nan, np.inf), 0.5], [0.0, -1j]])),
        mode_kind=("mode", np.array(["nan", "Infinity"])),
    ).assign_attrs(estimated_error=np.nan, most=np.inf, warnings='["1 of \\"Infinity\\", NaN"]')
    text = to_json(odd)
    assert json.loads(text, parse_constant=_no_json)["data_vars"]["frequency"]["data"] == [None, -np.inf]
    again = load_result(save_result(odd, tmp_path / "odd.json"))
    xr.testing.assert_identical(again, load_result(save_result(odd, tmp_path / "odd.nc")))
    assert again["frequency"].dtype == np.float64
    assert (again.attrs["most"], again.attrs["warnings"]) == (np.inf, odd.attrs["warnings"])
    save_result(again, tmp_path / "again.nc")


def test_json_laid_out_anew_and_of_an_earlier_version_is_read(result: xr.Dataset, tmp_path: Path) -> None:
    odd = result.assign(frequency=("mode", [np.nan, np.inf]))
    path = save_result(odd, tmp_path / "odd.json")
    table = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps(table, indent=1).replace("Infinity", "1e999"), encoding="utf-8")
    xr.testing.assert_identical(load_result(path)["frequency"], odd["frequency"])
    table.pop("sha256")
    table["data_vars"]["frequency"]["data"][0] = np.nan
    former = json.dumps(table)  # NaN and Infinity, as they were written
    digest = hashlib.sha256(former.encode()).hexdigest()
    path.write_text(f'{former[:-1]}, "sha256": "{digest}"}}', encoding="utf-8")
    xr.testing.assert_identical(load_result(path)["frequency"], odd["frequency"])


def test_files_that_cannot_be_read_or_written(result: xr.Dataset, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such file"):
        load_result(tmp_path / "absent.nc")
    (tmp_path / "text.nc").write_text("not netCDF", encoding="utf-8")
    with pytest.raises(ModelError, match="not a result file"):
        load_result(tmp_path / "text.nc")
    with pytest.raises(ModelError, match="cannot be written"):
        save_result(result, tmp_path / "no" / "folder" / "result.nc")


@pytest.mark.parametrize("name", ["modes.txt", "modes", "modes.html", "modes.h5", "modes.NC.txt"])
def test_a_suffix_that_is_no_result_file_is_refused(result: xr.Dataset, tmp_path: Path, name: str) -> None:
    with pytest.raises(ModelError, match=r"allowed: \.nc or \.json or \.csv or \.xlsx") as error:
        save_result(result, tmp_path / name)
    assert name in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_json_file_without_lines_reopens(tmp_path: Path) -> None:
    """An empty dimension in the middle: nested lists do not tell those behind it."""
    table = {"mesh": 2, "line": 0, "part": 3}
    save_result(xr.Dataset({"line_force": (tuple(table), np.zeros(tuple(table.values())))}), tmp_path / "result.json")
    assert load_result(tmp_path / "result.json").line_force.shape == (2, 0, 3)


def test_a_json_file_reopens_equal(result: xr.Dataset, tmp_path: Path) -> None:
    path = save_result(result, tmp_path / "result.JSON")
    assert json.loads(path.read_text(encoding="utf-8")) == json.loads(to_json(result))
    xr.testing.assert_identical(load_result(path), result)
    (tmp_path / "wrong.json").write_text('{"a": 1}', encoding="utf-8")
    with pytest.raises(ModelError, match="not a result file"):
        load_result(tmp_path / "wrong.json")
