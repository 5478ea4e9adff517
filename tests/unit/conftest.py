"""Model files in few lines, and systems written row by row, that tests of several rooms share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest
import typer.main
from tests.unit.planar_set import Builders

Tables = dict[str, Any]


@pytest.fixture(scope="session", autouse=True)
def one_program() -> Iterator[None]:
    """The commands are built once, not for every command line that a test runs in this process: that takes 40 ms."""
    once = cache(typer.main.get_command)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("typer.main.get_command", "typer.testing._get_command"):
            patch.setattr(name, once)
        yield


def _torsional(*, modal: float, sun_planet: Tables | None = None, planet_ring: Tables | None = None) -> Tables:
    """A planetary set that only turns, quick to solve: its meshes in N/m, with more keys if need be."""
    return {
        "format": 2,
        "title": "a torsional set",
        "damping": {"modal": modal},
        "stages": {
            "main": {
                "planets": 3,
                "module": 0.004,
                "sun": {"teeth": 24, "inertia": 0.002},
                "planet": {"teeth": 24, "mass": 1.5, "inertia": 0.003},
                "ring": {"teeth": 72, "inertia": 0.5},
                "carrier": {"inertia": 0.05},
                "meshes": {
                    "sun-planet": {"stiffness": 3e8, **(sun_planet or {})},
                    "planet-ring": {"stiffness": 4e8, **(planet_ring or {})},
                },
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": 100.0}, "torque": {"sun": 300.0}},
    }


def _helical_stage() -> Tables:
    """A helical planetary stage with all that the linear verbs and the stiffness of its teeth ask for."""
    return {
        "planets": 3,
        "module": "4 mm",
        "helix_angle": "12 deg",
        "face_width": "50 mm",
        "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
        "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
        "ring": {"teeth": 84, "rim": "25 mm"},
        "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
    }


@pytest.fixture(scope="session")
def torsional_set() -> Callable[..., Tables]:
    return _torsional


@pytest.fixture(scope="session")
def one_stage() -> Tables:
    """One helical stage that its carrier drives."""
    return {
        "format": 2,
        "title": "One stage",
        "damping": {"modal": 0.03},
        "stages": {"main": _helical_stage()},
        "operation": {"held": ["ring"], "speed": {"carrier": "100 rpm"}, "torque": {"carrier": "800 N m"}},
    }


@pytest.fixture(scope="session")
def two_stages() -> Tables:
    """Two such stages in a row, the sun of the low one on the carrier of the high one."""
    return {
        "format": 2,
        "title": "Two equal stages",
        "damping": {"modal": 0.03},
        "stages": {"low": _helical_stage(), "high": _helical_stage()},
        "couplings": {"shaft": {"between": ["low.sun", "high.carrier"], "rz": "1e6 N m/rad"}},
        "operation": {
            "held": ["low.ring", "high.ring"],
            "speed": {"low.carrier": "100 rpm"},
            "torque": {"low.carrier": "800 N m"},
        },
    }


@pytest.fixture(scope="session")
def build() -> Builders:
    return Builders()
