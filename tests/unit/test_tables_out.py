"""CSV and workbook of a result, reopened by other programs, equal the Dataset to the bit; texts stay texts."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

from epicyclic.errors import ModelError
from epicyclic.results import dataset
from epicyclic.results.dataset import cells_of, save_csv, save_result, save_xlsx

FORMULAS = ["=cmd()", "+1", "-1x", "@sum", "\tx", "\rx", "'quoted", 'a "b", c\nd', "", "ordinary"]


@pytest.fixture
def odd() -> xr.Dataset:
    """All kinds of numbers and texts: 17 digits, nan, infinity, complex, truth values, times, empty dims."""
    values = np.random.default_rng(3).standard_normal((3, 2, 10)) * 10.0 ** np.arange(-150, 150, 30)
    values[0, 0, :4] = np.nan, np.inf, -np.inf, -0.0
    return xr.Dataset(
        {
            "force": (("speed", "mesh", "sample"), values, {"units": "N", "long_name": "mesh force"}),
            "turned": (("sample", "mesh"), values[1].T, {"units": "m"}),
            "shape": ("mesh", np.array([complex(0.1 + 0.2, np.inf), complex(np.nan, -0.1 - 0.2)])),
            "lost": ("mesh", [True, False]),
            "count": ((), 2**62 + 1),
            "place": ("row", np.array(FORMULAS, dtype=object)),
            "when": ("mesh", np.array(["2026-01-02T03:04:05", "NaT"], dtype="datetime64[ns]")),
            "nothing": ("none", np.zeros(0)),
        },
        {"mesh": ["=a/1", "b"], "speed": [0.1, 1 / 3, 1e300]},
        {
            "title": "=cmd()",
            "verb": "steady",
            "options": "{}",
            "warnings": json.dumps(["=one", "two"]),
            "model": "x" * 9,
        },
    )


def unquoted(text: str) -> str:
    return text.removeprefix("'")


def rows_of(table: pd.DataFrame, name: str) -> pd.DataFrame:
    return table[table["variable"] == name]


def read_csv(path: Path, **options: Any) -> pd.DataFrame:
    exact = {} if pd.__version__ >= "3" else {"float_precision": "round_trip"}
    return pd.read_csv(path, low_memory=False, **exact, **options)


def same_bits(found: Any, expected: Any) -> None:
    one, other = (np.asarray(values, dtype=np.float64).ravel() for values in (found, expected))
    number = ~np.isnan(other)
    assert np.array_equal(np.isnan(one), ~number)
    assert np.array_equal(one[number].view(np.int64), other[number].view(np.int64))


def test_csv_opens_with_one_call_and_holds_every_bit(odd: xr.Dataset, tmp_path: Path) -> None:
    table = read_csv(save_csv(odd, tmp_path / "odd.csv"))
    assert list(table.columns) == [
        *("variable", "type", "unit", *odd.sizes),
        *("value", "imaginary", "text"),
    ]
    assert len(table) == sum(one.size for one in odd.variables.values()) + len(odd.attrs)
    same_bits(rows_of(table, "force")["value"], odd["force"])
    assert set(rows_of(table, "force")["unit"]) == {"N"}
    shape = rows_of(table, "shape")
    same_bits(shape["value"], odd["shape"].values.real)
    same_bits(shape["imaginary"], odd["shape"].values.imag)
    assert rows_of(table, "lost")["value"].tolist() == [1, 0]
    assert pd.to_datetime(rows_of(table, "when")["text"]).tolist()[0] == pd.Timestamp("2026-01-02T03:04:05")
    assert len(rows_of(table, "nothing")) == 0
    # every value stands at its labels, whatever the order of its dims
    turned = rows_of(table, "turned")
    for _, row in turned.iterrows():
        mesh, sample = unquoted(row["mesh"]), int(row["sample"])
        assert odd["turned"].sel(mesh=mesh).isel(sample=sample).item() == row["value"]
    same_bits(rows_of(table, "force")["speed"][::20], odd["speed"])


def test_csv_texts_are_neutral_and_come_back(odd: xr.Dataset, tmp_path: Path) -> None:
    path = save_csv(odd, tmp_path / "odd.csv")
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    cells = [cell for line in lines for key, cell in line.items() if key not in ("value", "imaginary")]
    assert [cell for cell in cells if cell.startswith(("=", "+", "-", "@", "\t", "\r"))] == []
    assert [unquoted(line["text"]) for line in lines if line["variable"] == "place"] == FORMULAS
    (title,) = (line for line in lines if line["type"] == "attribute" and line["variable"] == "title")
    assert title["text"] == "'=cmd()"
    (count,) = (line for line in lines if line["variable"] == "count")
    assert int(count["value"]) == 2**62 + 1


def cells(path: Path, sheet: str) -> list[list[Any]]:
    return [[cell.value for cell in row] for row in openpyxl.load_workbook(path)[sheet].iter_rows()]


def test_workbook_holds_every_bit(odd: xr.Dataset, tmp_path: Path) -> None:
    path = save_xlsx(odd, tmp_path / "odd.xlsx")
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["about", "numbers", "mesh", "row", "none", "mesh x sample", "speed x mesh x sample"]
    assert {sheet.freeze_panes for sheet in book} >= {"A2", "D2"}
    table = pd.read_excel(path, sheet_name=(table_name := "speed x mesh x sample"))
    assert list(table.columns) == ["speed", "mesh", "sample", "force [N]"]
    # pandas makes whole numbers of floats that have none behind the point: minus zero is compared below
    assert np.array_equal(table["force [N]"].astype(float), odd["force"].values.ravel(), equal_nan=True)
    same_bits([np.nan if row[3] is None else float(row[3]) for row in cells(path, table_name)[1:]], odd["force"])
    same_bits(table["speed"][::20], odd["speed"])
    turned = pd.read_excel(path, sheet_name="mesh x sample")
    same_bits(turned["turned [m]"].astype(float), odd["turned"].transpose("mesh", "sample"))
    meshes = pd.read_excel(path, sheet_name="mesh")
    same_bits(meshes["shape real"].astype(float), odd["shape"].values.real)
    same_bits(meshes["shape imaginary"].astype(float), odd["shape"].values.imag)
    assert meshes["lost"].tolist() == [True, False]
    assert cells(path, "numbers")[1][0] == 2**62 + 1
    assert cells(path, "none") == [["none", "nothing"]]


def test_workbook_has_no_formula(odd: xr.Dataset, tmp_path: Path) -> None:
    path = save_xlsx(odd, tmp_path / "odd.xlsx")
    every = [cell for sheet in openpyxl.load_workbook(path) for row in sheet.iter_rows() for cell in row]
    assert {cell.data_type for cell in every} <= {"s", "inlineStr", "n", "b"}
    texts = [row[1] for row in cells(path, "row")[1:]]
    assert texts == [text.replace("\r", "\\x0d") or None for text in FORMULAS]
    about = {row[0]: row[1] for row in cells(path, "about")}
    assert about["title"] == "=cmd()"
    assert about["warnings"] == "=one"
    (named,) = (cell for cell in every if cell.value == "=cmd()" and cell.parent.title == "row")
    assert named.quotePrefix


def test_a_workbook_says_what_it_is(odd: xr.Dataset, tmp_path: Path) -> None:
    about = cells(save_xlsx(odd, tmp_path / "odd.xlsx"), "about")
    assert ["force", "speed x mesh x sample", "N", "float", "mesh force"] in about
    assert [row[1] for row in about if row[0] == "verb"] == ["steady"]


def test_limits_of_a_workbook(odd: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dataset, "_ROWS", 26)
    monkeypatch.setattr(dataset, "_COLUMNS", 4)
    path = save_xlsx(odd, tmp_path / "odd.xlsx")
    parts = [name for name in openpyxl.load_workbook(path).sheetnames if name.startswith("speed x")]
    assert parts == ["speed x mesh x sample", "speed x mesh x sample 2", "speed x mesh x sample 3"]
    whole = pd.concat([pd.read_excel(path, sheet_name=name) for name in parts])
    assert np.array_equal(whole["force [N]"].astype(float), odd["force"].values.ravel(), equal_nan=True)
    monkeypatch.setattr(dataset, "CELLS_OF_XLSX", cells_of(odd) - 1)
    with pytest.raises(ModelError, match="too many"):
        save_xlsx(odd, tmp_path / "many.xlsx")
    monkeypatch.undo()
    with pytest.raises(ModelError, match="too long"):
        save_xlsx(odd.assign(place=("row", ["x" * 40_000] * 10)), tmp_path / "long.xlsx")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["odd.xlsx"]


def test_long_names_of_sheets_are_shortened_by_words_and_told_in_full(tmp_path: Path) -> None:
    planet, carrier = "stages.main.planet.bearing.radial", "stages.main.carrier.support.radial"
    long = [f"stages.main.planet.bearing.{'very_' * 6}long_key{end}" for end in "ab"]
    groups = {"force": (planet,), "moment": (carrier,), "lost": (planet, "mesh"), "stress": tuple(long)}
    result = xr.Dataset({name: (dims, np.zeros([2] * len(dims))) for name, dims in groups.items()})
    path = save_xlsx(result, tmp_path / "long.xlsx")
    names = openpyxl.load_workbook(path).sheetnames
    assert names == ["about", "radial", "radial 2", "radial x mesh", "very_very_ver~ x very_very_ver~"]
    about = cells(path, "about")
    first = next(place for place, row in enumerate(about) if row[0] == "sheet")
    told = {row[0]: row[1] for row in about[first + 1 : first + 5]}
    assert told == {name: " x ".join(dims) for name, dims in zip(names[1:], groups.values(), strict=True)}
    assert [list(cells(path, name)[0][:-1]) for name in names[1:]] == [list(dims) for dims in groups.values()]


def test_names_of_sheets(tmp_path: Path) -> None:
    long = "a/b:" * 12
    sizes = {f"{long}{i}": (f"{long}{i}", [1.0]) for i in range(2)}
    many = xr.Dataset({f"v{i}": (f"{long}{i}", [2.0]) for i in range(2)}, sizes).assign(history=("History", [1.0]))
    names = openpyxl.load_workbook(save_xlsx(many, tmp_path / "x.xlsx")).sheetnames
    assert all(len(name) <= 31 and not set(name) & set("[]:*?/\\") for name in names)
    assert len({name.lower() for name in names}) == len(names) == 4
    assert "History" not in names


def test_cells_are_counted(odd: xr.Dataset, tmp_path: Path) -> None:
    book = openpyxl.load_workbook(save_xlsx(odd, tmp_path / "odd.xlsx"))
    counted = sum((sheet.max_row - 1) * sheet.max_column for sheet in book if sheet.title != "about")
    assert cells_of(odd) == counted


def test_save_result_takes_both(odd: xr.Dataset, tmp_path: Path) -> None:
    assert (save_result(odd, tmp_path / "a.CSV")).read_bytes() == save_csv(odd, tmp_path / "b.csv").read_bytes()
    assert openpyxl.load_workbook(save_result(odd, tmp_path / "a.xlsx")).sheetnames[0] == "about"
