"""Sensitivities by paths of a model file against differences of the whole answer, from the file on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.studies.parameters import parameter_at

Array = NDArray[np.float64]
# Both sides are differences: five-point ones of the answer with a step of 1e-3 leave some 1e-12 of truncation and, of
# forces solved to 1e-11, 1e-8 of rounding.
AGREE = 1e-6


def difference(answer: Callable[[float], Array], value: float) -> Array:
    """Derivative by the five-point formula."""
    h = 2e-4 * value
    near, far = (answer(value + k * h) - answer(value - k * h) for k in (1, 2))
    return np.asarray((8 * near - far) / (12 * h))


def frequencies(drive: Any, path: str) -> Callable[[float], Array]:
    parameter = parameter_at(epicyclic.load(drive), path)
    return lambda value: np.asarray(epicyclic.modes(drive, overrides=parameter.at(value)).frequency.values)


def forces(drive: Any, path: str, relative_speed: float) -> Callable[[float], Array]:
    parameter = parameter_at(epicyclic.load(drive), path)

    def answer(value: float) -> Array:
        swept = epicyclic.sweep(drive, overrides=parameter.at(value), relative_speed=[relative_speed], tolerance=1e-11)
        return np.asarray(swept.mesh_force_rms.values[:, 0])

    return answer


def close(found: Array, wanted: Array) -> None:
    assert np.abs(found - wanted).max() <= AGREE * np.abs(wanted).max()


@pytest.mark.parametrize(
    ("drive", "path"),
    [
        ("lin1999-n4", "stages.main.sun.support.radial"),
        ("lin1999-n4", "stages.main.meshes.sun-planet.pressure_angle"),
        ("lin1999-n5", "stages.main.planet.mass"),
        ("ren2021", "stages.main.pressure_angle"),
        ("ren2021", "stages.main.helix_angle"),
        ("ren2021", "stages.main.face_width"),
        ("xu2020", "stages.main.planet.bore"),
        ("xu2020", "stages.main.sun.neck.torsional_rigidity"),
        ("encased-differential", "couplings.g1-f1.rz"),
        ("encased-differential", "stages.encased.meshes.planet-ring.stiffness"),
    ],
)
def test_frequencies(drive: str, path: str) -> None:
    found = epicyclic.sensitivity(drive, paths=[path])
    elastic = found.frequency.values > 0
    wanted = difference(frequencies(drive, path), float(found.parameter_value[0]))
    close(found.derivative.values[0, elastic], wanted[elastic])


@pytest.mark.parametrize(
    ("drive", "path", "speed"),
    [
        ("ren2021", "stages.main.planet.bearing.radial", 1.0),
        ("ren2021", "stages.main.pressure_angle", 1.0),
        ("ren2021", "stages.main.module", 3.3),
        ("ren2021", "damping.modal", 3.3),
        ("ren2021", "deviations.main.sun.run_out.amplitude", 1.0),
        ("ren2021", "operation.torque.main.sun", 1.0),
        ("ren2021", "operation.speed.main.sun", 1.0),
        ("ren2021", "stages.main.carrier.inertia", 3.3),
        ("ren2021", "stages.main.meshes.sun-planet.stiffness", 3.3),
        ("xu2020", "stages.main.planet.bearing.radial", 2.0),
        ("xu2020", "operation.power.main.carrier", 2.0),
        ("xu2020", "operation.speed.main.carrier", 2.0),
    ],
)
def test_forces(drive: str, path: str, speed: float) -> None:
    found = epicyclic.sensitivity(drive, of="force", paths=[path], relative_speed=speed)
    close(found.derivative.values[0], difference(forces(drive, path, speed), float(found.parameter_value[0])))
