"""Active sets of many samples: which sets are found, where their equations are singular or not solved."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic import load
from epicyclic.questions.tolerance.tolerance_map import ToleranceMap, tolerance_map
from epicyclic.statics.sample_loads import net_forces

Array = NDArray[np.float64]


def four_planets() -> ToleranceMap:
    """A spur set of four planets with a floating sun; pins are out of place along their path."""
    stage: dict[str, Any] = {
        "planets": 4,
        "module": "4 mm",
        "face_width": "40 mm",
        "sun": {"teeth": 24, "support": {"radial": "0 N/m"}},
        "planet": {"teeth": 24, "bearing": {"radial": "4e8 N/m"}},
        "ring": {"teeth": 72},
        "carrier": {},
        "meshes": {"sun-planet": {"stiffness": "9.206e8 N/m"}, "planet-ring": {"stiffness": "1.2634e9 N/m"}},
    }
    model: dict[str, Any] = {
        "format": 2,
        "title": "floating sun",
        "damping": {"modal": 0.03},
        "stages": {"main": stage},
        "operation": {"held": ["ring"], "speed": {"sun": "1000 rpm"}, "torque": {"sun": "1 kN m"}},
        "tolerance": {"deviations.main.planet.position.y": "normal(0 um, 60 um)"},
    }
    return tolerance_map(load(model))


@pytest.mark.parametrize(("torque", "off"), [(1.0, 1e-6), (1e-4, 1e-11)])
@pytest.mark.parametrize("own", [False, True])
def test_a_set_whose_equations_are_not_solved_is_not_found(
    own: bool, torque: float, off: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A solution off by a millionth balances no body to 1e-9 of the load; stiffnesses are of each sample, or of all.

    Gaps of 60 um beside a load of 0.1 N m count by the forces that they miss, not by their own size.
    """
    drawn = four_planets()
    u = np.random.default_rng(4).random((25, len(drawn.dimension_entry)))
    opened = drawn.evaluate(u).open
    given, factors = drawn.load_map, drawn.factors(u[opened], [1.0])[0]
    closed = given.stretch.values(factors, torque)[0]
    rows = np.arange(given.mesh_count)
    asked = (rows, np.tile(given.flexible.stiffness[rows], (len(closed), 1))) if own else ()
    assert len(closed) > 3
    assert net_forces(given, closed, *asked)[1].all()
    solve = np.linalg.solve
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: solve(a, b) * (1 + off))
    assert not net_forces(given, closed, *asked)[1].any()


def test_branches_that_hang_free_by_a_hair_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of four planets are open by 1e-11 to 1e-9 of the stretch of the others; their gaps are not unique.

    Both flanks of an open planet leave it free to turn, so that the equations of its gaps are singular: a kernel adds
    what rounding makes of that motion, here a tenth of a millimetre.
    """
    drawn = four_planets()
    given, planet = drawn.load_map, np.arange(drawn.load_map.mesh_count) % 4
    whole, opens = given.stretch.still + given.stretch.torque, planet % 2 == 1
    closed = np.where(opens, -np.geomspace(1e-11, 1e-9, 40)[:, None], 2) * whole[: planet.size]
    closed = np.concatenate([closed, np.tile(whole[planet.size :], (40, 1))], axis=1)
    solve = np.linalg.solve

    def turned(matrix: Array, right: Array) -> Array:
        _, size, motion = np.linalg.svd(matrix)
        free = np.where(size[..., None] < 1e-13 * size.max(), motion, 0.0).sum(axis=-2)
        added: Array = solve(matrix, right) + 1e-4 * free[..., None]
        return added

    monkeypatch.setattr(np.linalg, "solve", turned)
    net, found = net_forces(given, closed)
    assert found.all()
    np.testing.assert_allclose(net[:, opens] / net.max(), 0, atol=1e-9)
