"""Arrays of a System are read-only, since what follows from it is kept by its identity; a changed one is another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import epicyclic


def test_a_matrix_is_not_changed_in_place_and_another_system_is_computed_anew() -> None:
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    first = epicyclic.modes(system)["frequency"].values
    with pytest.raises(ValueError, match="read-only"):
        system.M[0, 0] *= 4
    for values in (system.K, system.force, system.meshes.B, system.meshes.stiffness, system.links.stiffness):
        assert not values.flags.writeable
    assert all(not line.force.flags.writeable for line in system.lines)
    heavier = replace(system, M=4 * system.M)
    elastic = first > 0
    np.testing.assert_allclose(epicyclic.modes(heavier)["frequency"].values[elastic], first[elastic] / 2, rtol=1e-9)
    np.testing.assert_array_equal(epicyclic.modes(system)["frequency"].values, first)
    stiffer = replace(system, meshes=replace(system.meshes, stiffness=2 * system.meshes.stiffness))
    shared, before = (epicyclic.sharing(one, method="static", cycles=1) for one in (stiffer, system))
    assert np.abs(shared["load_sharing"].values - before["load_sharing"].values).max() > 1e-3
