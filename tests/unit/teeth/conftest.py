"""Pairs of gears with a stand-in compliance, so that contact is tested apart from the compliance of teeth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from epicyclic.teeth import geometry
from epicyclic.teeth.compliance import columns_of_teeth
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.path_of_contact import PlaneOfAction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cantilever:
    """A tooth whose own compliance goes with the cube of the height of the load; the body couples neighbours."""

    root: float
    tip: float
    decay: float = 8e-3
    shared: float = 0.5e-12

    def _part(self, radius: ArrayLike) -> Array:
        return np.asarray((np.asarray(radius, dtype=float) - self.root) / (self.tip - self.root))

    def face_decay(self, width: float) -> float:
        return self.decay

    def bending(self, radius: ArrayLike) -> Array:
        return self.shared + 2e-12 * (1 + self._part(radius)) ** 2 + 2e-12 + 12e-12 * self._part(radius) ** 3

    def depth(self, radius: ArrayLike) -> Array:
        return 5e-3 - 2e-3 * self._part(radius)

    def body_factors(self, radius: ArrayLike, tooth: ArrayLike) -> tuple[Array, Array]:
        number = np.arange(int(np.max(tooth)) + 1)
        coupling = np.zeros((len(number) + 1, len(number) + 1))
        coupling[:-1, :-1] = 2e-12 * np.exp(-np.abs(number - number[:, None]))
        coupling[-1, -1] = self.shared
        weight = 1 + self._part(radius)[..., None]
        return np.concatenate([columns_of_teeth(weight, tooth), np.ones_like(weight)], axis=-1), coupling


def build(
    teeth_a: int = 21,
    teeth_b: int = 37,
    *,
    helix: float = 0.0,
    internal: bool = False,
    width: float = 30e-3,
    **more: Any,
) -> ContactPair:
    """A pair of module 5 mm, 20 deg, without shift, helix in degrees; `more` are fields of the pair or the plane."""
    module, alpha, beta = 5e-3, math.radians(20), math.radians(helix)
    base = [geometry.base_radius(z, module, alpha, beta) for z in (teeth_a, teeth_b)]
    tip = [geometry.tip_radius(z, module, beta, internal=ring) for z, ring in ((teeth_a, False), (teeth_b, internal))]
    pitch = geometry.base_pitch(module, alpha, beta)
    angle = geometry.transverse_pressure_angle(alpha, beta)
    limits = geometry.contact_limits(
        base[0], tip[0], base[1], tip[1], working_pressure_angle=angle, base_pitch=pitch, internal=internal
    )
    plane: dict[str, Any] = {
        "base_a": base[0],
        "base_b": base[1],
        "internal": internal,
        "pressure_angle": angle,
        "base_helix": geometry.base_helix_angle(alpha, beta),
        "base_pitch": pitch,
        "limits": limits,
        "lean": 1 if helix else 0,
        "face_a": (-width / 2, width / 2),
        "face_b": (-width / 2, width / 2),
    }
    plane |= {key: more.pop(key) for key in list(more) if key in plane}
    drawn = PlaneOfAction(**plane)
    ends = sorted(float(drawn.radius_b(limit)) for limit in limits)
    roots = float(drawn.radius_a(limits[0])) - 2e-3, (ends[1] + 2e-3 if internal else ends[0] - 2e-3)
    tips = float(drawn.radius_a(limits[1])), (ends[0] if internal else ends[1])
    return ContactPair(
        plane=drawn,
        tooth_a=more.pop("tooth_a", Cantilever(root=roots[0], tip=tips[0])),
        tooth_b=more.pop("tooth_b", Cantilever(root=roots[1], tip=tips[1])),
        teeth=(teeth_a, teeth_b),
        **more,
    )


@pytest.fixture(scope="session")
def pair_of() -> Callable[..., ContactPair]:
    return build
