"""A 56-degree-of-freedom double-helical planetary set with known dynamic mesh forces."""

from __future__ import annotations

import numpy as np
import pytest

from epicyclic.questions.modes.eigen import mean_modes
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.response.steady import sweep
from epicyclic.system.system import System

# mesh frequency [Hz]: RMS of the dynamic mesh force of meshes 0 and 1 [N]
REFERENCE = {600: (316.448, 382.234), 1646: (4019.837, 6745.458), 3500: (511.594, 643.363)}
TONE = 1000


def test_its_modes_span_the_known_range(bench56: System) -> None:
    frequency = np.sqrt(mean_modes(bench56)[0]) / (2 * np.pi)
    assert frequency[0] == pytest.approx(183, abs=0.6)  # printed to 1 Hz
    assert frequency[-1] == pytest.approx(5743, abs=0.6)


@pytest.mark.parametrize("frequency", REFERENCE)
def test_dynamic_mesh_forces(bench56: System, frequency: int) -> None:
    found = periodic(bench56, relative_speed=frequency / TONE)
    # the reference is printed to 1e-6 and known to 1e-5
    np.testing.assert_allclose(found.force[:2].std(axis=1), REFERENCE[frequency], rtol=1e-5)


def test_a_sweep_at_its_own_tolerance(bench56: System) -> None:
    result = sweep(bench56, SweepOptions(mesh_frequency=list(REFERENCE)))
    np.testing.assert_allclose(result.mesh_force_rms[:2].T, list(REFERENCE.values()), rtol=2e-5)
