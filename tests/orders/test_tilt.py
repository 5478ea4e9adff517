"""Tilt as an extra freedom: with stiffer and stiffer bearings the face load goes to that of bodies that cannot tilt."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic

STIFFNESS = np.array([1e8, 1e9, 1e10, 1e11])  # above what the teeth put against a tilt, some 1e5 N m/rad


def train(member: str, tilt: float | None) -> dict[str, Any]:
    """A helical star set in five slices, its carrier bent by a moment; one member tilts with `tilt` [N m/rad]."""
    links = {name: {"radial": 3e8, "z": 1e8} for name in ("sun", "planet", "ring", "carrier")}
    if tilt is not None:
        links[member]["tilt"] = tilt
    return {
        "format": 2,
        "title": "a helical set",
        "stages": {
            "main": {
                "planets": 3,
                "module": 0.004,
                "helix_angle": math.radians(15),
                "face_width": 0.05,
                "sun": {"teeth": 22, "support": links["sun"]},
                "planet": {"teeth": 23, "bearing": links["planet"]},
                "ring": {"teeth": 68, "rim": 0.03, "support": links["ring"]},
                "carrier": {"mass": 20.0, "inertia": 0.2, "support": links["carrier"]},
                "meshes": {pair: {"slices": 5, "stiffness": 1e9} for pair in ("sun-planet", "planet-ring")},
            }
        },
        "operation": {"held": ["carrier"], "speed": {"sun": 100.0}, "torque": {"sun": 1000.0}},
        "loads": {"bend": {"on": "carrier", "moment": {"x": 300.0, "y": 100.0}}},
    }


def slices(document: dict[str, Any]) -> NDArray[np.float64]:
    return np.asarray(epicyclic.static(document, cycles=1).slice_force.values)


@pytest.mark.parametrize("member", ["planet", "carrier"])
def test_rigid_tilt_is_the_limit_of_stiff_tilt(member: str) -> None:
    limit = slices(train(member, None))
    np.testing.assert_allclose(limit.reshape(6, 5, -1), limit.reshape(6, 5, -1)[:, :1].repeat(5, axis=1), rtol=1e-9)
    gone = [np.abs(slices(train(member, k)) - limit).max() / limit.max() for k in STIFFNESS]
    slope = np.polyfit(np.log(STIFFNESS), np.log(gone), 1)[0]
    assert abs(slope + 1) < 0.2
    assert gone[0] > 1e-4  # there is something to see: rounding is 1e-12


@pytest.mark.parametrize("member", ["planet", "carrier"])
def test_soft_tilt_makes_the_face_load_uneven(member: str) -> None:
    factors = [epicyclic.static(train(member, k), cycles=1).face_load_factor.values.max() for k in (1e5, 1e6, 1e7, 1e9)]
    assert all(a > b for a, b in pairwise(factors))
    assert factors[0] > 1.05
