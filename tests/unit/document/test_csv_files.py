"""One form of CSV file, whatever names it: pitch deviations, forces over deflection, torques, windows of a sensor."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from epicyclic.document.document import at_files, read
from epicyclic.errors import ModelError
from epicyclic.questions.modulation.verbs import read_window
from epicyclic.questions.transient.verbs import read_history

MODEL = """\
format = 2
title = "a pair"
[stages.main]
module = "4 mm"
face_width = "20 mm"
pinion = { teeth = 3 }
wheel = { teeth = 5 }
"""
ROWS = ((0.0, 0.0), (5.0, 1.0), (10.0, 3.0))


def model(path: Path, more: str) -> Path:
    found = path.with_name("model.toml")
    found.write_text(MODEL + more, encoding="utf-8")
    return found


def pitch(path: Path) -> list[float]:
    document = read(model(path, f'[deviations]\npinion.pitch = "{path.name}"\n'))
    (values,) = document.model.deviations.members["main.pinion"].pitch or ((),)
    return [value * 1e6 for value in values]


def forces(path: Path) -> list[float]:
    document = read(model(path, f'[stages.main.meshes.pinion-wheel]\nstiffness = {{ file = "{path.name}" }}\n'))
    table = document.model.stages["main"].meshes["pinion-wheel"].stiffness
    return list(table.curves[0][1])  # type: ignore[union-attr]


def torques(path: Path) -> list[float]:
    return list(read_history(path).torque["sun"])


def gains(path: Path) -> list[float]:
    angles = np.radians([first for first, _ in ROWS])
    return list(np.round(read_window(path).at(angles), 2))


KINDS = [
    (pitch, "tooth, pitch [um]"),
    (forces, "deflection [um], force [N]"),
    (torques, "time [s], sun [N m]"),
    (gains, "angle [deg], gain [1]"),
]


def text_of(heading: str, separator: str) -> str:
    lines = ["\ufeff  # measured on Monday; twice", "", heading, *(f"{a:g} , {b:g}" for a, b in ROWS[:2]), " # a pause"]
    return "\r\n".join([*lines, f"{ROWS[2][0]:g},{ROWS[2][1]:g}", ""]).replace(",", separator)


@pytest.mark.parametrize("separator", [",", ";"])
@pytest.mark.parametrize(("values", "heading"), KINDS)
def test_one_form_of_files(tmp_path: Path, values: Callable[[Path], list[float]], heading: str, separator: str) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(text_of(heading, separator).encode("utf-8"))
    assert values(path) == pytest.approx([second for _, second in ROWS], abs=0.05)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("5, 1_0", "line 3.*not a finite number"),
        ("5, inf", "line 3.*not a finite number"),
        ("5, 1e400", "line 3.*not a finite number"),
        ("5, 1 0", "line 3.*not a finite number"),
        ("5, ", "line 3.*no value"),
        ("5", "line 3.*another number of columns"),
        ("5, 1, 2", "line 3.*another number of columns"),
    ],
)
@pytest.mark.parametrize(("values", "heading"), KINDS)
def test_rows_that_are_none(
    tmp_path: Path, values: Callable[[Path], list[float]], heading: str, row: str, said: str
) -> None:
    path = tmp_path / "table.csv"
    path.write_text(f"{heading}\n0, 0\n{row}\n10, 3\n", encoding="utf-8")
    with pytest.raises(ModelError, match=f"table.csv.*{said}"):
        values(path)


@pytest.mark.parametrize(("values", "heading"), KINDS)
def test_a_decimal_comma_is_refused(tmp_path: Path, values: Callable[[Path], list[float]], heading: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(f"{heading}\n0,0\n5,1,5\n".replace(", ", "; ").replace("0,0", "0;0").replace("5,1", "5;1"))
    with pytest.raises(ModelError, match="a decimal point"):
        values(path)


def test_a_stage_named_reduced_is_no_table_of_matrices() -> None:
    """Its files are those of forces; those of a member and of a body are of matrices."""
    matrices = {"reduced": "k.npz"}
    given: dict[str, object] = {
        "stages": {"reduced": {"sun": {"support": {"file": "x.csv"}, **matrices}}},
        "bodies": {"reduced": {"reduced": {"stiffness": "k.mtx", "units": "t mm s"}}},
    }

    def named(name: str, path: str) -> str:
        return f"{path}: {name}"

    found = at_files(
        given, forces=lambda _, path: {"read": path}, torques=lambda table, _: table, pitches=named, bodies=named
    )
    assert found["stages"]["reduced"]["sun"] == {
        "support": {"read": "stages.reduced.sun.support"},
        "reduced": "stages.reduced.sun.reduced: k.npz",
    }
    of_body = {"stiffness": "bodies.reduced.reduced.stiffness: k.mtx", "units": "t mm s"}
    assert found["bodies"]["reduced"]["reduced"] == of_body
