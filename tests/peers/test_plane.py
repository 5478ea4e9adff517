"""Stiffness of spur pairs against finite elements of both gears, solved by CalculiX (Debian: calculix-ccx)."""

from __future__ import annotations

import shutil
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        shutil.which("ccx") is None, reason="the finite elements need CalculiX: apt install calculix-ccx"
    ),
]

# teeth, module [mm], pressure angle [deg], internal, load per face width [N/m]: the meshed planets of yue2014 (43 N m),
# and sun, planet and ring of lin1999
PAIRS = {
    "19/20": ((19, 20), 4.0, 25.0, False, 124860.0),
    "27/35": ((27, 35), 3.25, 20.0, False, 200e3),
    "35/99 ring": ((35, 99), 3.25, 20.0, True, 200e3),
}
# The issue asks for 10 %.  Both routes share the outline and nothing else; they were found 0.1 to 1.5 % apart (the mesh
# is converged to 0.03 %): the beam is 3 to 5 % softer and Weber's contact 7 % stiffer than the elements have them.
NEAR = 0.03


def single_and_double(low: float, high: float) -> tuple[float, float]:
    """Places of one pair alone, half way, and of two pairs, half way."""
    ratio = high - low
    return low + 0.5 * ratio, low + 0.5 * (ratio - 1)


@pytest.mark.parametrize("name", PAIRS)
def test_pair_stiffness(plane: ModuleType, name: str) -> None:
    teeth, module, angle, internal, load = PAIRS[name]
    mesh = plane.spur_pair(teeth, module * 1e-3, angle, internal=internal)
    for sigma, pairs in zip(single_and_double(*mesh.limits), (np.array([0]), np.array([0, 1])), strict=True):
        found = plane.elements(mesh, sigma, load, pairs=pairs)
        theirs, shares = plane.by_elements(found, load)
        ours, loads = plane.by_energy(mesh, sigma, load, pairs=pairs)
        assert load / ours == pytest.approx(load / theirs, rel=NEAR)
        np.testing.assert_allclose(loads, shares, rtol=NEAR)
        if len(pairs) == 2 and not internal:
            # what the coupling of the two through the bodies is worth: without it they are a sixth too stiff
            alone = replace(found, compliance=np.diag(np.diag(found.compliance)))
            assert theirs / plane.by_elements(alone, load)[0] > 1.15
