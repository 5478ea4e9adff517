"""Numbers as they are written: read apart, changed, written back as a file takes them."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from epicyclic.document.document import read
from epicyclic.document.tables import value_text
from epicyclic.document.units import written
from epicyclic.questions.studies.sensitivity import parameter_at


@pytest.mark.parametrize(
    ("before", "values", "after"),
    [
        ("3 mm", (4.5,), "4.5 mm"),
        (3.0, (4.5,), 4.5),
        ("[1, 2] um", (1.0, 4.5), "[1.0, 4.5] um"),
        ([1.0, 2.0], (1.0, 4.5), [1.0, 4.5]),
        (["1 um", "2 um"], (1.0, 4.5), "[1.0, 4.5] um"),
    ],
)
def test_numbers_of_numpy_are_written_as_numbers(before: object, values: tuple[float, ...], after: object) -> None:
    number = written(before)
    assert number is not None
    for given in (values, tuple(np.array(values))):
        text = number.text(given)
        assert text == after
        assert "np.float64" not in repr(text)


def test_an_override_from_an_array_is_a_model_file_again() -> None:
    import epicyclic

    train = epicyclic.load("ren2021")
    path = "stages.main.sun.mass"
    parameter = parameter_at(train, path)
    for value in np.linspace(0.9, 1.1, 2) * parameter.value:
        document = read("ren2021", parameter.at(value))
        again = tomllib.loads(f"a = {value_text(document.data)}")["a"]
        assert again["stages"]["main"]["sun"]["mass"] == f"{float(value)!r} kg"
        assert read(again).model.stages["main"].members["sun"].mass == float(value)


def test_scalars_of_numpy_are_toml() -> None:
    table = {
        "a": np.float64(1.5),
        "b": np.int64(3),
        "c": np.bool_(True),
        "d": [np.float64(2.5)],
        "e": {"f": np.str_("x")},
    }
    assert tomllib.loads(f"a = {value_text(table)}")["a"] == {"a": 1.5, "b": 3, "c": True, "d": [2.5], "e": {"f": "x"}}
