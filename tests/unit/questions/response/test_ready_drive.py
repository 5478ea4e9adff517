"""The periodic response of a ready drive, shaft orders included, against integration of its equation from rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from epicyclic.questions.modes.eigen import mean_modes
from epicyclic.questions.response.measures import periodic
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load


@pytest.mark.slow
def test_integration_from_rest_joins_the_periodic_response_of_ren2021(case: Any) -> None:
    system = assemble(load("ren2021"))
    found = periodic(system)
    tone, omega = float(found.tone), np.sqrt(mean_modes(system)[0])
    # 1.2 times 10 / (zeta omega_1): e^-12 = 6e-6 of the static force is left of the transient
    first = np.ceil(12 / (0.03 * omega[omega > 0][0]) * tone) / tone
    count = found.theta.size
    times = first + np.arange(count) / (count * tone)
    still = np.zeros(system.force.size)
    force = case.motion(system, 1.0).integrate(np.concatenate([[0.0], times]), still, still, rtol=1e-6)[1][:, 1:]
    expected = found.force.copy()
    for line in found.lines:
        expected += (line.force * np.exp(2j * np.pi * float(line.frequency) * times)).real
    assert len(found.lines) == 3
    assert np.abs(force - expected).max() < 1e-4 * found.force.mean()
