"""Torsional planetary sets: slaved planets against Kahraman's closed form, random parameters."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.system.assembly import assemble
from epicyclic.train.train import Train

INF = float("inf")
RIGID = (INF, INF, INF, INF, INF, 0.0)
HELD = (INF, INF, INF, INF, INF, INF)


def closed_form(n: int, ms: float, mp: float, mc: float, k1: float, k2: float) -> list[float]:
    """Squared natural frequencies, ring held [kahraman1994]; k1 ring-planet, k2 sun-planet."""
    L1 = mp * mc * ms
    L2 = -(n * k2 * mp * mc + (k1 + k2) * mc * ms + n * (k1 + k2) * mp * ms)
    L3 = n * k1 * k2 * (n * mp + mc + 4 * ms)
    root = math.sqrt(L2**2 - 4 * L1 * L3)
    return sorted([0.0, *[(k1 + k2) / mp] * (n - 1), (-L2 - root) / (2 * L1), (-L2 + root) / (2 * L1)])


positive = st.floats(0.2, 5.0)


@settings(max_examples=60, deadline=None)
@given(
    n=st.integers(2, 8), sun=positive, planet=positive, carrier=positive, mass=positive, k1=positive, k2=positive,
    base_sun=st.floats(0.03, 0.055),
)  # fmt: skip
def test_slaved_planets_give_the_closed_form(
    hand_built: Callable[..., Train],
    n: int, sun: float, planet: float, carrier: float, mass: float, k1: float, k2: float, base_sun: float,
) -> None:  # fmt: skip
    a, base_planet = 0.12, 0.05
    reach = base_sun + base_planet  # = a cos(alpha)
    train = hand_built(
        angles=tuple(2 * math.pi * i / n for i in range(n)), helix=0.0, stations=(0.0,), pin_radius=a,
        base_sun=base_sun, base_planet=base_planet, alpha_sun=math.acos(reach / a), support=RIGID, ring_support=HELD,
        pin=RIGID, stiffness_sun=k2 * 1e8, stiffness_ring=k1 * 1e8, sun_inertia=0.01 * sun,
        carrier_inertia=carrier, planet_mass=mass,
    )  # fmt: skip
    system = assemble(train)
    assert set(system.dofs.direction) == {"rz"}
    values = np.linalg.eigvals(np.linalg.solve(system.M, system.mean_stiffness))
    expected = closed_form(
        n, 0.01 * sun / base_sun**2, 0.01 / base_planet**2, (carrier + n * mass * a**2) / reach**2, k1 * 1e8, k2 * 1e8
    )
    # relative to the largest root: 1e-10 is rounding of an eigenvalue problem of a dozen coordinates
    assert np.sort(values.real) == pytest.approx(expected, abs=1e-10 * expected[-1])
