"""`[tolerance]`: distributions of the quantity that stands at the path."""

from __future__ import annotations

import pytest

from epicyclic.errors import ModelError
from epicyclic.model.document import Document, read

RUN_OUT = "deviations.main.sun.run_out.amplitude"


def toleranced(path: str, text: object, version: int = 2) -> Document:
    return read("ren2021", {"tolerance": {path: text}, "format": version})


@pytest.mark.parametrize(
    ("path", "text"),
    [
        (RUN_OUT, "normal(0, 12 um)"),
        (RUN_OUT, "normal(20 um, 0 um)"),
        (RUN_OUT, "normal( -20um , 0.012 mm )"),
        (RUN_OUT, "uniform(-5 um, 5 um)"),
        (RUN_OUT, "uniform(0, 0)"),
        ("deviations.main.planet.position.y", "normal(0, 12 um)"),  # not given, but could be
        ("deviations.main.meshes.sun-planet.profile.amplitude", "normal(0, 12 um)"),
        ("stages.main.sun.support.radial", "normal(1e9 N/m, 1e8 N/m)"),
        ("stages.main.sun.inertia", "normal(663 kg, 3 kg)"),
        ("stages.main.sun.inertia", "normal(90 kg m^2, 3 kg m^2)"),
        ("stages.main.meshes.sun-planet.stiffness", "normal(20 N/(mm um), 1 N/(mm um))"),
        ("stages.main.sun.profile_shift", "normal(0.1, 0.01)"),
        ("damping.modal", "uniform(1 %, 3 %)"),
    ],
)
def test_taken(path: str, text: str) -> None:
    assert text in toleranced(path, text).model.tolerance.values()


@pytest.mark.parametrize(
    ("path", "text", "problem", "allowed"),
    [
        (RUN_OUT, "normal(0, -12 um)", "a deviation below zero", "deviation >= 0"),
        (RUN_OUT, "uniform(5 um, -5 um)", "wrong order", "high >= low"),
        (RUN_OUT, "normal(0, 12 kg)", "another kind of quantity", "length (m, mm, um)"),
        (RUN_OUT, "normal(20 kg, 12 um)", "another kind of quantity", "length (m, mm, um)"),
        (RUN_OUT, "normal(0, 12)", 'without a unit: "12 um"?', "length"),
        (RUN_OUT, "normal(0, inf)", "must be finite", "length"),
        (RUN_OUT, "normal(0, wide)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(0)", "not a distribution", "uniform(low, high)"),
        (RUN_OUT, "triangle(0, 1 um)", "not a distribution", "uniform(low, high)"),
        (RUN_OUT, 12, "not a distribution", "uniform(low, high)"),
        ("stages.main.sun.inertia", "normal(663 kg, 3 kg m^2)", "mixes kinds", "kg m^2 or kg"),
        ("stages.main.sun.profile_shift", "normal(0.1 mm, 0.01)", "another kind", "number"),
        ("deviations.main.sun.position.q", "normal(0, 1 um)", "no such path", "a path a number can stand at"),
        ("stages.main.sun.hand", "normal(0, 1 um)", "no such path", "a path a number can stand at"),
    ],
)
def test_refused_with_its_path(path: str, text: object, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        toleranced(path, text)
    assert error.value.path.startswith("tolerance.")
    assert problem in str(error.value)
    assert allowed in error.value.allowed
    assert str(text) in str(error.value)


def test_a_number_without_a_unit_is_told_in_format_1() -> None:
    (warning,) = toleranced(RUN_OUT, "normal(0, 1e-5)", version=1).warnings
    assert warning.startswith(f"tolerance.{RUN_OUT} = normal(0, 1e-5): 1e-5 has no unit, read in m")


def test_an_error_of_a_mesh_has_its_tolerance() -> None:
    path = "deviations.main.meshes.sun-planet.errors.mine"
    error = {"turns_with": "sun", "amplitude": "20 um", "phase": "[0, 120, 240] deg"}
    spreads = {f"{path}.amplitude": "normal(20 um, 5 um)", f"{path}.phase": "uniform(0 deg, 360 deg)"}
    document = read("ren2021", {"deviations.meshes.sun-planet.errors.mine": error, "tolerance": spreads})
    assert dict(document.model.tolerance) == spreads
