"""Numbers out of Datasets: labels, reductions, arithmetic, units.  Expected values are worked out by hand."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic.audits.audit import Measured, converted, evaluate
from epicyclic.audits.audit_file import Value
from epicyclic.errors import ModelError

RESULT = xr.Dataset(
    {
        "force": (("mesh", "time"), np.array([[3.0, -7.0, 4.0], [2.0, 1.0, 6.0]]), {"units": "N"}),
        "kind": ("mesh", np.array(["sun", "ring"])),
        "branch": ("mesh", np.array([1, 2])),
        "tone": ("time", np.array([10.0, 20.0, 30.0]), {"units": "Hz"}),
        "mixed": ("mesh", np.array([1.0, 2.0]), {"units": "N/m, N m/rad for rx"}),
        "inertia": ((), np.array(2.0), {"units": "kg m2"}),
        "turn": ((), np.array(60.0), {"units": "rpm"}),
        "wave": ("time", np.array([3 + 4j, 1j, 0]), {"units": "N"}),
        "lost": ("mesh", np.array([False, True])),
    },
    coords={"mesh": ["a/sun/1", "a/ring/1"], "time": np.array([0.0, 0.1, 0.2])},
    attrs={"warnings": json.dumps(["cannot be assembled", "contact is lost"])},
)


def number(**keys: Any) -> Measured:
    keys = {"run": "r", **keys} if "take" in keys else keys
    return evaluate(Value.model_validate(keys), lambda _: RESULT)


def one(**keys: Any) -> float:
    (value,) = number(**keys).values
    return float(value)


SUN = {"where": {"mesh": "*/sun/*"}}
EVERY = {"take": "force"}


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"reduce": "max"}, 6),
        ({"reduce": "min"}, -7),
        ({"reduce": "mean"}, 1.5),
        ({"reduce": "sum"}, 9),
        ({"reduce": "range"}, 13),
        ({"reduce": "ratio"}, -6 / 7),
        ({"reduce": "largest"}, 7),
        ({"reduce": "count"}, 6),
        ({"reduce": "first"}, 3),
        ({"reduce": "last"}, 6),
        ({"reduce": "rms"}, math.sqrt((9 + 49 + 16 + 4 + 1 + 36) / 6)),
        ({"reduce": ["mean time", "max"]}, 3),
        ({"reduce": ["max mesh", "min"]}, 1),
        ({"reduce": "argmax", "read": "tone"}, 30),
        ({"reduce": "argmin", "read": "tone"}, 20),
        ({"reduce": "argmin", "read": "branch"}, 1),
        ({**SUN, "pick": 1}, -7),
        ({**SUN, "pick": -1}, 4),
        ({"where": {"kind": "ring"}, "reduce": "max"}, 6),
        ({"where": {"branch": 2}, "reduce": "min"}, 1),
        ({"where": {"branch": [1, 2], "time": 0.1}, "reduce": "sum"}, -6),
        ({"where": {"lost": True}, "reduce": "sum"}, 9),
        ({**SUN, "nearest": {"time": 0.17}}, 4),
        ({**SUN, "between": {"tone": [15, 30]}, "reduce": "sum"}, -3),
        ({**SUN, "pick": 0, "scale": 2, "offset": 1}, 7),
        ({**SUN, "pick": 1, "absolute": True}, 7),
        ({**SUN, "pick": 0, "unit": "kN", "offset": 1}, 1.003),
    ],
)
def test_selection_and_reduction(keys: dict[str, Any], expected: float) -> None:
    assert one(**EVERY, **keys) == pytest.approx(expected, rel=1e-14)


def test_complex_values_are_taken_by_magnitude() -> None:
    assert one(take="wave", pick=0) == 5


def test_warnings_are_counted() -> None:
    keys = {"take": "warnings", "reduce": "count"}
    assert one(**keys) == 2
    assert one(**keys, where={"warnings": "*assembled*"}) == 1
    assert one(**keys, where={"warnings": "*thin rim*"}) == 0  # none of this kind is an answer, not an error


def test_any_entry_of_a_list() -> None:
    keys = {"run": "r", "take": "branch", "where": {"mesh": ["a/ring/*", "a/sun/1"]}, "reduce": "each"}
    texts = RESULT.assign_coords(mesh=np.array(["a/sun/1", "a/ring/1"], dtype=object))  # as verbs label them
    for result in (RESULT, texts):
        runs = {"r": result}
        assert evaluate(Value.model_validate(keys), runs.__getitem__).values.tolist() == [1, 2]


def test_several_numbers() -> None:
    assert number(**EVERY, **SUN, pick=[2, 0], reduce="each").values.tolist() == [4, 3]


@pytest.mark.parametrize(
    ("keys", "expected", "unit"),
    [
        ({"difference": [{"value": 3, "unit": "m"}, {"value": 20, "unit": "cm"}]}, 2.8, "m"),
        ({"ratio": [{"value": 3, "unit": "m"}, {"value": 50, "unit": "cm"}]}, 6, "1"),
        ({"product": [{"value": 3, "unit": "N"}, {"value": 50, "unit": "cm"}]}, 1.5, "N m"),
        ({"sum": [{"value": 1}, {"value": 2}, {"value": 4}]}, 7, "1"),
        ({"greatest": [{"value": 1}, {"value": 4}, {"value": 2}]}, 4, "1"),
        ({"least": [{"value": 2}, {"value": 1}, {"value": 4}]}, 1, "1"),
        ({"value": 3, "unit": "kN", "scale": "0.5 m"}, 1500, "N m"),
        ({"take": "mixed", "pick": 1, "unit": "N/m"}, 2e-6, "N/um"),
        ({"take": "inertia"}, 2e6, "kg mm^2"),
        ({"take": "turn"}, 2 * math.pi, "rad/s"),
        ({"value": 12, "unit": "%"}, 0.12, "1"),
        ({"ratio": [{"difference": [{"value": 5}, {"value": 2}]}, {"value": 2}], "offset": 1}, 2.5, "1"),
    ],
)
def test_arithmetic_and_units(keys: dict[str, Any], expected: float, unit: str) -> None:
    (value,) = converted(number(**keys), unit).values
    # one or two roundings in the factor of the unit
    assert value == pytest.approx(expected, rel=1e-14)


WRONG = [
    ({"take": "forces"}, "no such variable"),
    ({**EVERY}, "not one number is left"),
    ({**EVERY, "reduce": "max place"}, "no such dimension"),
    ({**EVERY, "where": {"mesh": "*planet*"}}, "nothing is left"),
    ({**EVERY, "where": {"branch": 7}}, "nothing is left"),
    ({**EVERY, "where": {"gear": "x"}}, "no such variable"),
    ({**EVERY, "where": {"force": 3}}, "has not one dimension"),
    ({**EVERY, "pick": 0}, "cannot pick"),
    ({**EVERY, **SUN, "pick": 3}, "cannot pick"),
    ({"take": "tone", "reduce": "argmax", "read": "force"}, "a dimension of its own"),
    ({"value": 1, "scale": "two metres"}, "not a number with a unit"),
    ({"difference": [{"value": 1, "unit": "m"}, {"value": 1, "unit": "N"}]}, "cannot become"),
]


@pytest.mark.parametrize(("keys", "says"), WRONG, ids=[says for _, says in WRONG])
def test_what_cannot_be_taken(keys: dict[str, Any], says: str) -> None:
    with pytest.raises(ModelError, match=says):
        number(**keys)


@pytest.mark.parametrize(("old", "new"), [("Hz", "rad/s"), ("rpm", "Hz"), ("rad/s", "1/s")])
def test_revolutions_are_not_taken_for_radians(old: str, new: str) -> None:
    with pytest.raises(ModelError, match="revolutions or radians"):
        converted(Measured(values=np.ones(1), unit=old), new)
