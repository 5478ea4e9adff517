"""Lin & Parker 1999, planar planetary sets: natural frequencies and kinds of modes, from the ready drives.

The table is the paper's, to the digits printed; recomputed independently the N = 4 column is up to 4e-4 away from the
print (727.27 and 1091.2 Hz stand as 727.0 and 1091.0), the others within 7e-5.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from epicyclic.questions.modes.modal import modal
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load

ROTATIONAL = {
    3: [0, 1475.7, 1930.3, 2658.3, 7462.8, 11775.3],
    4: [0, 1536.6, 1970.6, 2625.7, 7773.6, 13071.1],
    5: [0, 1567.4, 2006.1, 2614.8, 8065.4, 14253.1],
}
TRANSLATIONAL = {
    3: [743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9],
    4: [727.0, 1091.0, 1892.8, 2342.5, 7189.9, 10437.6],
    5: [710.0, 1072.0, 1888.1, 2425.3, 7382.4, 11172.3],
}
PLANET = [1808.2, 5963.8, 6981.7]
TOLERANCE = {3: 1e-4, 4: 4e-4, 5: 1e-4}  # rounding of the print, see above


@pytest.mark.parametrize("planets", [3, 4, 5])
def test_all_natural_frequencies(planets: int) -> None:
    result = modal(assemble(load(f"lin1999-n{planets}")))
    expected = sorted([*ROTATIONAL[planets], *(2 * TRANSLATIONAL[planets]), *((planets - 3) * PLANET)])
    assert result.sizes["mode"] == 3 * (planets + 3)
    assert result["frequency"].values == pytest.approx(expected, rel=TOLERANCE[planets], abs=1e-6)


@pytest.mark.parametrize("planets", [4, 5, 6, 7, 8])
def test_kinds_and_multiplicities(planets: int) -> None:
    """6 simple rotational, 6 double translational, 3 planet modes N - 3 fold [lin1999]."""
    result = modal(assemble(load("lin1999-n4", overrides={"stages.main.planets": planets})))
    pairs = zip(result["mode_kind"].values.tolist(), result["multiplicity"].values.tolist(), strict=True)
    expected = {("rotational", 1): 6, ("translational", 2): 12, ("planet", planets - 3): 3 * (planets - 3)}
    assert Counter(pairs) == expected
    planet = result["frequency"].values[result["mode_kind"].values == "planet"]
    # planet modes do not move the central members, so they do not depend on the number of planets
    assert planet == pytest.approx(np.repeat(PLANET, planets - 3), rel=1e-4)


def test_uneven_spacing_has_no_kinds() -> None:
    result = modal(assemble(load("lin1999-n3", overrides={"stages.main.planet_angles": "[0, 100, 230] deg"})))
    assert set(result["mode_kind"].values.tolist()) == {"mixed"}


def test_planet_modes_leave_the_central_members_at_rest() -> None:
    result = modal(assemble(load("lin1999-n5")))
    planet = result["mode_kind"] == "planet"
    central = [name for name in result["body"].values.tolist() if "planet" not in name]
    # rounding of the eigenvectors of a well separated eigenspace
    assert float(np.abs(result["full_shape"].sel(body=central).where(planet, drop=True)).max()) < 1e-9
    rotational = (result["mode_kind"] == "rotational") & (result["frequency"] > 1.0)
    lateral = result["full_shape"].sel(body=central, direction=["x", "y"]).where(rotational, drop=True)
    assert float(np.abs(lateral).max()) < 1e-9
