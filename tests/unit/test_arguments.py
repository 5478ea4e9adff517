"""Misuse from Python is told at the border, by the name of the argument."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.user_input import checked
from epicyclic.verbs.record import verbs

FUNCTIONS = [
    getattr(epicyclic, name) for name in epicyclic.__all__ if name not in ("System", "Train") and name[0].islower()
]


class Foreign:
    """Of no kind that any argument has."""


def of_each() -> list[Any]:
    """Every argument of every function, but those that take anything."""
    free = {("compare", "sources"), ("vary", "quantity")}
    return [
        pytest.param(function, name, id=f"{function.__name__}-{name}")
        for function in FUNCTIONS
        for name in signature(function).parameters
        if (function.__name__, name) not in free
    ]


@pytest.mark.parametrize(("function", "name"), of_each())
def test_an_argument_of_a_wrong_type_is_named(function: Callable[..., Any], name: str) -> None:
    parameter = signature(function).parameters[name]
    several = parameter.kind is Parameter.VAR_POSITIONAL
    arguments = ("energy", Foreign()) if several else ()
    options = {} if several else {name: Foreign()}
    with pytest.raises(ModelError, match=f"^{name} = .*of a wrong type; allowed: "):
        function(*arguments, **options)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: epicyclic.modes("lin1999-n4", relative_speed=None), "relative_speed"),  # type: ignore[arg-type]
        (lambda: epicyclic.assemble("base.toml"), "train"),  # type: ignore[arg-type]
        (lambda: epicyclic.contact("lin1999-n4", mesh=5), "mesh"),  # type: ignore[arg-type]
        (lambda: epicyclic.campbell("lin1999-n4", relative_speeds=5), "relative_speeds"),  # type: ignore[arg-type]
        (lambda: epicyclic.campbell("lin1999-n4", relative_speeds=["1"]), "relative_speeds"),  # type: ignore[list-item]
        (lambda: epicyclic.modes("lin1999-n4", damped="no"), "damped"),  # type: ignore[arg-type]
        (lambda: epicyclic.sharing("lin1999-n4", cycles=2.5), "cycles"),  # type: ignore[arg-type]
        (lambda: epicyclic.sharing("lin1999-n4", cycles=True), "cycles"),
        (lambda: epicyclic.load("lin1999-n4", overrides=["a=1"]), "overrides"),  # type: ignore[arg-type]
        (lambda: epicyclic.static(epicyclic.modes), "source"),  # type: ignore[arg-type]
        (lambda: epicyclic.modes("lin1999-n4", relative_speed=Fraction(1, 2)), "relative_speed"),  # type: ignore[arg-type]
        (lambda: epicyclic.modes("lin1999-n4", overrides={1: "1 kg"}), "overrides"),  # type: ignore[dict-item]
        (
            lambda: epicyclic.modes("lin1999-n4", overrides={"stages.main.sun.mass": np.ones(2)}),
            "stages.main.sun.mass",
        ),
        (lambda: epicyclic.sweep("ren2021", mesh_frequency=np.ones((2, 2))), "mesh_frequency"),
        (lambda: epicyclic.sweep("ren2021", relative_speed=["1"]), "relative_speed"),
        (lambda: epicyclic.transient("ren2021", initial=np.array(["rest"])), "initial"),
        (lambda: epicyclic.vary("lin1999-n4", {"stages.main.sun.mass": 5}), "path_values"),  # type: ignore[dict-item]
        (lambda: epicyclic.write_report("page.html", {"modes": 5}), "datasets"),  # type: ignore[dict-item]
        (lambda: epicyclic.write_report("page.html", {}, figures={"modes": 5}), "figures"),
        (
            lambda: epicyclic.differential(teeth="21/39/99", speed={"sun": None, "ring": 1.0}),  # type: ignore[dict-item]
            "speed",
        ),
    ],
)
def test_misuse_is_named(call: Callable[[], object], name: str) -> None:
    with pytest.raises(ModelError) as error:
        call()
    assert error.value.path == name


def test_a_text_is_told_from_a_number_and_a_word_from_a_type() -> None:
    sharing: Callable[..., Any] = epicyclic.sharing
    for options, said in (
        ({"cycles": "3"}, "cycles = '3': of a wrong type; allowed: a whole number or None"),
        ({"method": "stedy"}, "method = 'stedy': not one of them; allowed: 'steady' or"),
        ({"method": 3}, "method = 3: of a wrong type; allowed: 'steady' or"),
    ):
        with pytest.raises(ModelError, match=f"^{said}"):
            sharing("lin1999-n4", **options)


def test_numbers_of_arrays_and_sequences_of_all_kinds_are_taken() -> None:
    @checked
    def taken(count: int, *, size: float = 0.0, many: list[float] | None = None, file: str | Path = "") -> int:
        return count

    take: Callable[..., Any] = taken
    assert take(np.int64(2), size=np.float32(1.0)) == 2
    assert take(np.array(2), size=xr.DataArray(1.0)) == 2
    with pytest.raises(ModelError, match="count"):
        take(np.array([1, 2]))
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    kinds: list[Any] = [[0.5, 1], (0.5, 1.0), np.array([0.5, 1.0]), xr.DataArray([0.5, 1.0]), range(1, 3)]
    for speeds in kinds:
        assert epicyclic.campbell(system, relative_speeds=speeds).sizes["relative_speed"] == 2


def test_arguments_that_are_missing_or_unknown_are_left_to_python() -> None:
    with pytest.raises(TypeError, match="source"):
        epicyclic.modes()  # type: ignore[call-arg]
    for verb in verbs().values():
        with pytest.raises(TypeError, match="no_such_keyword"):
            verb.run("lin1999-n4", no_such_keyword=1)


def test_a_keyword_that_is_spelt_nearly_right_is_named() -> None:
    sweep: Callable[..., Any] = epicyclic.sweep
    with pytest.raises(TypeError, match="'pointz'; did you mean 'points'"):
        sweep("ren2021", pointz=3)


@pytest.mark.parametrize(
    ("verb", "options", "said"),
    [
        (epicyclic.sweep, {"mesh_frequency": [np.nan, 100.0]}, "mesh_frequency = nan"),
        (epicyclic.stability, {"mesh_frequency": np.array([100.0, np.inf])}, "mesh_frequency = inf"),
        (epicyclic.contact, {"mesh": "sun-planet", "torque": "-850 N m"}, "torque = -850 N m"),
        (
            epicyclic.contact,
            {"mesh": "sun-planet", "torque": 1e12},
            "torque = 1000000000000.0: out of range; allowed: 0 to 1e\\+09",
        ),
    ],
)
def test_numbers_that_nothing_can_be_computed_of_are_refused(
    verb: Callable[..., Any], options: dict[str, Any], said: str
) -> None:
    with pytest.raises(ModelError, match=f"^{said}"):
        verb("ren2021", **options)
