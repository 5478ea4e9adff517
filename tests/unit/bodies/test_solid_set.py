"""A whole set beside solid finite elements of CalculiX: frequencies, load sharing and the ring at its contacts.

The numbers of CalculiX are kept; where it is installed one set is solved anew.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import reduced_ring
import solid_set

from epicyclic import sharing

SOLID = json.loads(solid_set.KEPT.read_text())
PAGE = (solid_set.ROOT / "docs" / "theory" / "elastic-bodies.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("rim", solid_set.RIMS)
@pytest.mark.parametrize("count", solid_set.PLANETS)
def test_thin_rings_hold_the_limits_but_where_said(count: int, rim: str) -> None:
    of = f"{count} planets, {rim} rim"
    for model, train in solid_set.trains(solid_set.RIMS[rim], None).items():
        found = solid_set.same_by(train, count)
        assert solid_set.missed(found, SOLID[of], model) == set(solid_set.MISSED.get(model, {})), model
        assert solid_set.row(of, model, found, SOLID[of]) in PAGE


def test_load_sharing_of_the_comparison_is_that_of_the_verb() -> None:
    train = solid_set.trains(solid_set.RIMS["thin"], None)["stretched"](4, solid_set.with_error(4))
    verb = sharing(train, method="static", samples=4).load_sharing.sel(definition="mean-load")
    force = solid_set.at_rest(train)["force"]
    for group in ("sun-planet", "planet-ring"):
        own = [float(verb.sel(mesh=name)) for name in force if f"/{group}/" in name]
        assert max(own) == pytest.approx(solid_set.k_gamma(force, group), rel=1e-9)


def test_kept_numbers_are_in_equilibrium() -> None:
    """Torque of the meshes about the sun; on each planet both meshes are equal; without an error all are."""
    for of, solid in SOLID.items():
        for case in solid.get("static", ()):
            force = np.array(list(case["force"].values())).reshape(-1, 2)
            np.testing.assert_allclose(force[:, 0], force[:, 1], rtol=3e-5, err_msg=of)
            assert force[:, 0].sum() * 38.71e-3 == pytest.approx(solid_set.TORQUE, rel=3e-5)
        if "static" in solid:
            assert np.ptp(list(solid["static"][0]["force"].values())) < 1.0
            assert np.ptp(list(solid["static"][1]["force"].values())) > 100.0


def test_calculix_and_the_reduced_ring(tmp_path: Path) -> None:
    """Solved anew as kept; matrices of the same ring hold the limits."""
    if shutil.which("ccx") is None:
        pytest.skip("solid elements need CalculiX: apt install calculix-ccx")
    of, rim = "4 planets, thin rim", solid_set.RIMS["thin"]
    found = solid_set.solved_set(tmp_path, 4, "thin")
    np.testing.assert_allclose(found["frequency"], SOLID[of]["frequency"], rtol=1e-5)
    for one, kept in zip(found["static"], SOLID[of]["static"], strict=True):
        np.testing.assert_allclose(list(one["force"].values()), list(kept["force"].values()), rtol=1e-4)
        np.testing.assert_allclose(one["deflection"], kept["deflection"], rtol=1e-5)
    matrices = reduced_ring.solved(tmp_path, mesh=rim.mesh)
    reduced = solid_set.same_by(solid_set.trains(rim, matrices)["reduced"], 4)
    assert not solid_set.missed(reduced, SOLID[of], "reduced")
    case, rest = SOLID[of]["static"][1], reduced["static"][1]
    assert solid_set.off_deflection(rest, case) < 1e-5
    assert solid_set.off_sharing(rest, case) < 2e-5
