"""Torque histories from CSV files: what is read, and every way a file can be wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.transient.verbs import read_history


def written(folder: Path, text: str) -> Path:
    path = folder / "torque.csv"
    path.write_bytes(text.encode("utf-8") if not text.startswith("\x00") else b"time [s], \xff\xfe")
    return path


@pytest.mark.parametrize("separator", [",", ";"])
def test_a_history_is_read(tmp_path: Path, separator: str) -> None:
    lines = [
        "\ufeff# measured on the brake",
        "",
        "time [ms], sun [kN m] ,main.carrier [N m]",
        "0,1,-4e3",
        "#",
        "2.5,1.5,-6000",
    ]
    text = "\r\n".join(lines).replace(",", separator)
    path = written(tmp_path, text)
    history = read_history(path)
    assert history.time.tolist() == [0.0, 0.0025]
    torque = {name: values.tolist() for name, values in history.torque.items()}
    assert torque == {"sun": [1000.0, 1500.0], "main.carrier": [-4000.0, -6000.0]}
    assert history.where == [f"{path}, line 4", f"{path}, line 6"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "torque.csv: holds no line"),
        ("# nothing\n\n", "holds no line"),
        ("\x00", "is not a text file"),
        ("time [s], sun\n0,1\n1,2\n", "line 1 = sun: a column needs a name and a unit"),
        ("0,1\n1,2\n", "line 1 = 0: a column needs a name and a unit"),
        ("sun [N m], carrier [N m]\n0,1\n1,2\n", "needs a column of time"),
        ("time [s]\n0\n1\n", "needs a column of time and one of a member"),
        ("time [s], sun [N m], sun [N m]\n0,1,1\n1,2,2\n", "stands in two columns"),
        ("time [m], sun [N m]\n0,1\n1,2\n", "line 1 = time \\[m\\]: not a unit of time"),
        ("time [s], sun [N]\n0,1\n1,2\n", "not a unit of torque"),
        ("time [s], sun [N m]\n0,1\n", "too few rows"),
        ("time [s], sun [N m]\n0,1\n\n1,\n2,3\n", "line 4 = \\(nothing\\): no value of sun"),
        ("time [s], sun [N m]\n0,1\n1,nan\n", "line 3 = nan: sun is not a finite number"),
        ("time [s], sun [N m]\n0,1\ninf,2\n", "time is not a finite number"),
        ("time [s], sun [N m]\n0,1\n1,x\n", "line 3 = x: sun is not a finite number"),
        ("time [s], sun [N m]\n0,1\n1,2,3\n", "line 3 = 3: another number of columns"),
        ("time [s], sun [N m]\n0,1\n1\n", "another number of columns"),
        ("time [s], sun [N m]\n0,1\n2,2\n2,3\n", "line 4 = 2.0: times must rise"),
        ("time [s], sun [N m]\n# a hole\n0,1\n2,2\n1,3\n", "line 5 = 1.0: times must rise"),
    ],
)
def test_a_wrong_history(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        read_history(written(tmp_path, text))


def test_no_such_file(tmp_path: Path) -> None:
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(ModelError, match="cannot be read"):
            read_history(path)


def test_a_file_drives_a_run(tmp_path: Path) -> None:
    path = written(tmp_path, "time [s], sun [kN m]\n0, 100\n0.1, 100\n0.2, 150\n0.4, 150\n")
    found = epicyclic.transient("ren2021", torque=path, decimate=4)
    force = found.mesh_force.sum("mesh").values
    last = found.time.values > 0.35
    np.testing.assert_allclose(
        force[last].mean() / force[found.time.values < 0.1].mean(), 1.5, rtol=0.02
    )  # it vibrates
    wrong = written(tmp_path, "time [s], sun [N m], carrier [N m]\n0,1,2\n1,2,3\n")
    with pytest.raises(ModelError, match=r"torque.csv, line 2 = .*do not balance"):
        epicyclic.transient("ren2021", torque=wrong)
