"""Load histories from files: what is read, and every way one can be wrong, with its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from openpyxl import Workbook

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.rating import SpectrumOptions
from epicyclic.questions.rating.load_spectrum import LoadHistory, read_load_history

HEAD = "time [s], torque [kN m], speed [rpm]\n"
BINS = "torque [kN m], speed [rpm], duration [h]\n"


def read(folder: Path, text: str, **options: Any) -> LoadHistory:
    path = folder / "history.csv"
    path.write_text(text, encoding="utf-8")
    return read_load_history(path, SpectrumOptions(**options))


@pytest.mark.parametrize(
    "heading", [HEAD, "Time (s), Torque(kN m), SPEED (rpm)\n", "time [s];torque [kN m];speed [rpm]\n"]
)
def test_a_history_in_time_is_read(tmp_path: Path, heading: str) -> None:
    rows = "# logged\n0,1.5,30\n1,-2,-60\n\n3,4,0\n".replace(",", ";" if ";" in heading else ",")
    history = read(tmp_path, heading + rows)
    assert history.in_time
    assert history.torque.tolist() == [1500.0, -2000.0, 4000.0]
    np.testing.assert_allclose(history.speed, np.array([30.0, -60.0, 0.0]) * np.pi / 30, rtol=1e-15)
    assert history.duration.tolist() == [0.5, 1.5, 1.0]  # half of the time to each neighbour


def test_columns_are_chosen_by_name(tmp_path: Path) -> None:
    text = "t [min], Md [N m], torque [kN m], n [rad/s]\n0,7,1,2\n1,8,1,2\n"
    history = read(tmp_path, text, time="t", torque="md", speed="n")
    assert history.torque.tolist() == [7.0, 8.0]
    assert history.duration.tolist() == [30.0, 30.0]


def test_a_table_of_bins_is_read(tmp_path: Path) -> None:
    history = read(tmp_path, BINS + "100,12,800\n-50,12,200\n")
    assert not history.in_time
    assert history.duration.tolist() == [800 * 3600.0, 200 * 3600.0]
    for unit, shares in (("[%]", "80, 20"), ("[1]", "0.8, 0.2"), ("", "0.8, 0.2")):
        first, second = shares.split(", ")
        text = f"torque [kN m], speed [rpm], share {unit}\n100,12,{first}\n-50,12,{second}\n"
        np.testing.assert_allclose(read(tmp_path, text, life=3600e3).duration, history.duration, rtol=1e-14)


def test_a_life_repeats_the_history(tmp_path: Path) -> None:
    history = read(tmp_path, HEAD + "0,1,1\n2,1,1\n", life=10.0)
    assert history.repeats == 5.0
    assert history.duration.tolist() == [5.0, 5.0]


def test_an_excel_table_is_read(tmp_path: Path) -> None:
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    for row in (
        ["# logged"],
        [None],
        ["time (s)", "torque [kN m]", "speed [rpm]"],
        [0, 1.5, 30],
        [1, -2, -60],
        [3, 4, 0],
    ):
        sheet.append(row)
    sheet["F4"].number_format = "0.00"  # a cell beside the table, without anything in it
    sheet["F5"] = "brake"  # and a note
    book.save(path := tmp_path / "history.xlsx")
    history = read_load_history(path, SpectrumOptions())
    assert history.torque.tolist() == [1500.0, -2000.0, 4000.0]
    assert history.duration.tolist() == [0.5, 1.5, 1.0]
    sheet["B5"] = None
    book.save(path)
    with pytest.raises(ModelError, match=r"history\.xlsx, line 5 = \(nothing\): no value of torque"):
        read_load_history(path, SpectrumOptions())
    rows = Workbook(write_only=True)  # which says no size of the sheet: its rows are as long as they are
    other = rows.create_sheet()
    for line in ("time [s]|torque [kN m]|speed [rpm]", "0|1.5|30|note", "1|-2", "3|4|0"):
        other.append(line.split("|"))
    rows.save(path)
    with pytest.raises(ModelError, match=r"history\.xlsx, line 3 = \(nothing\): no value of speed"):
        read_load_history(path, SpectrumOptions())
    path.write_bytes(b"PK\x03\x04 no workbook")
    with pytest.raises(ModelError, match=r"history\.xlsx: no Excel table.*allowed: time \[s\], torque"):
        read_load_history(path, SpectrumOptions())


def test_a_formula_counts_as_the_value_saved_with_it(tmp_path: Path) -> None:
    book = Workbook()
    assert book.active is not None
    for row in (["time [s]", "torque [N m]", "speed [rpm]"], [0, 1.5, 30], [1, 2, 30]):
        book.active.append(row)
    book.save(plain := tmp_path / "plain.xlsx")
    path = tmp_path / "formula.xlsx"
    with ZipFile(plain) as source, ZipFile(path, "w") as target:
        for name in source.namelist():
            text = source.read(name)
            if name.endswith("sheet1.xml"):
                assert b"<v>1.5</v>" in text
                text = text.replace(b"<v>1.5</v>", b"<f>3/2</f><v>1.5</v>")
            target.writestr(name, text)
    assert read_load_history(path, SpectrumOptions()).torque.tolist() == [1.5, 2.0]


def test_columns_of_python_are_a_history() -> None:
    columns = {"time [s]": np.array([0.0, 1.0, 3.0]), "torque [N m]": [1, 2, 3], "speed [rpm]": (1, 1, 1)}
    assert read_load_history(columns, SpectrumOptions()).duration.tolist() == [0.5, 1.5, 1.0]
    with pytest.raises(ModelError, match="source, line 2 = nan: torque is not a finite number"):
        read_load_history({**columns, "torque [N m]": [1, np.nan, 3]}, SpectrumOptions())
    with pytest.raises(ModelError, match="columns of several lengths"):
        read_load_history({**columns, "torque [N m]": [1, 2]}, SpectrumOptions())
    with pytest.raises(ModelError, match=r"source = .*no history"):
        epicyclic.spectrum(epicyclic.load("ren2021"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "holds no line"),
        (HEAD, "too few rows"),
        (HEAD + "0,1,1\n", "too few rows = 1|= 1: too few rows"),
        ("time [s], torque, speed [rpm]\n0,1,1\n1,1,1\n", "line 1 = torque: a column needs a name and a unit"),
        ("time, torque [N m], speed [rpm]\n0,1,1\n1,1,1\n", "line 1 = time: a column needs a name and a unit"),
        ("time [s], torque [N], speed [rpm]\n0,1,1\n1,1,1\n", "line 1 = torque \\[N\\]: not a unit of torque.*kN m"),
        ("time [s], torque [N m], speed [Hz]\n0,1,1\n1,1,1\n", "not a unit of speed.*rpm"),
        ("time [s], speed [rpm]\n0,1\n1,1\n", "line 1 = time \\[s\\], speed \\[rpm\\]: not one column 'torque'"),
        ("torque [N m], speed [rpm]\n0,1\n1,1\n", "not one column of time or weight"),
        ("time [s], torque [N m], torque [N m], speed [rpm]\n0,1,1,1\n1,1,1,1\n", "not one column 'torque'"),
        ("time [s], torque [N m], speed [rpm], hours [h]\n0,1,1,1\n1,1,1,1\n", "not one column of time or weight"),
        (HEAD + "0,1,1\n1,,1\n2,1,1\n", "line 3 = \\(nothing\\): no value of torque.*a number in every column"),
        (HEAD + "0,1,1\n1,nan,1\n2,1,1\n", "line 3 = nan: torque is not a finite number"),
        (HEAD + "0,1,1\n1,1,-\n2,1,1\n", "line 3 = -: speed is not a finite number"),
        (HEAD + "0,1,1\n1,1\n2,1,1\n", "line 3 = 2: another number of columns"),
        (HEAD + "# a gap\n0,1,1\n1,1,1\n1,1,1\n", "line 5 = 1.0: times must rise.*more than 1 s"),
        (HEAD + "0,1,1\n1,1,1\n0.5,1,1\n", "line 4 = 0.5: times must rise"),
        (HEAD + "0,1,1\n1,1,1\n2,1,1\n13,1,1\n", "line 5 = 11 s: a gap in time.*at most 10 s"),
        (HEAD + "0,1,1\n20,1,1\n21,1,1\n22,1,1\n", "line 3 = 20 s: a gap in time"),
        (HEAD + "0,1e11,1\n1,1,1\n", "line 2 = 1e11: torque is out of range"),
        (BINS + "1,1,3\n1,1,-2\n", "line 3 = -2.*duration is negative"),
        (BINS + "1,1,0\n", "lasts no time"),
        ("torque [N m], speed [rpm], hours\n1,1,3\n", "line 1 = hours: a column needs a name and a unit"),
        ("torque [N m], speed [rpm], share [%]\n1,1,60\n1,1,30\n", "share does not sum to 1.*100 %"),
        ("torque [N m], speed [rpm], share [%]\n1,1,60\n1,1,40\n", "^life: is missing"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        read(tmp_path, text)


def test_a_longer_gap_may_be_allowed(tmp_path: Path) -> None:
    assert read(tmp_path, HEAD + "0,1,1\n1,1,1\n2,1,1\n13,1,1\n", gap=11.0).duration.sum() == 13.0


def test_a_column_that_is_asked_for_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"line 1 = .*: not one column 'Mt'"):
        read(tmp_path, HEAD + "0,1,1\n1,1,1\n", torque="Mt")
