"""Planetary sets that differ in teeth and planet angles only, so that theory says which sidebands are there."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest
import xarray as xr

from epicyclic.questions.modulation import ModulationOptions
from epicyclic.questions.modulation.modulation import modulation
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

# sun, planet, ring; planets, or steps of 1/(z_s + z_r) turn at which each can be assembled
GROUPS: dict[str, tuple[tuple[int, int, int], int | tuple[int, ...]]] = {
    "even, in phase": ((24, 36, 96), 3),
    "even, in sequence": ((21, 37, 95), 4),
    "uneven, in phase": ((24, 36, 96), (0, 35, 80)),
    "uneven, in opposite phase": ((21, 37, 95), (0, 30, 58, 88)),
    "uneven, in any phase": ((21, 37, 95), (0, 39, 77)),
}


def document(group: str) -> dict[str, Any]:
    """A model file: ring held, sun drives, everything floats on springs."""
    (sun, planet, ring), places = GROUPS[group]
    spread: dict[str, Any] = (
        {"planets": places}
        if isinstance(places, int)
        else {"planet_angles": f"[{', '.join(repr(360 * place / (sun + ring)) for place in places)}] deg"}
    )
    return {
        "format": 2,
        "title": group,
        "damping": {"modal": 0.04},
        "stages": {
            "main": {
                **spread,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": sun, "bore": "20 mm", "support": {"radial": "5e7 N/m"}},
                "planet": {"teeth": planet, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": ring, "rim": "25 mm", "support": {"radial": "6e8 N/m", "rz": "8e8 N/m"}},
                "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2", "support": {"radial": "5e8 N/m"}},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "1200 rpm"}, "torque": {"sun": "800 N m"}},
        "deviations": {"meshes": {"sun-planet": {"profile": "5 um"}, "planet-ring": {"profile": "4 um"}}},
    }


@cache
def _built(group: str, changes: tuple[tuple[str, Any], ...]) -> System:
    plain = {path: list(value) if isinstance(value, tuple) else value for path, value in changes}
    return assemble(load(document(group), overrides=plain))


@pytest.fixture(scope="session")
def system_of() -> Callable[..., System]:
    """Factory: system_of("even, in phase", {"deviations.sun.run_out": "10 um"}) -> System."""

    def make(group: str, changes: dict[str, Any] | None = None) -> System:
        return _built(group, tuple((changes or {}).items()))

    return make


@cache
def every_line(group: str) -> xr.Dataset:
    """All lines of a group without deviations, the least too, with the options that `modulation` takes by itself."""
    return modulation(_built(group, ()), ModulationOptions(floor=0.0))
