"""Small Systems written by hand: a mass on one flank, and a torsional pair of gears with all that a mesh can do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.system.link_laws import Law, LawGroup
from epicyclic.system.system import Dofs, FarFlanks, Line, LinkRows, MeshRows, System

Array = NDArray[np.float64]
TONE = Fraction(100)


def system_of(
    M: Array,
    K: Array,
    rows: Array,
    stiffness: Array,
    *,
    force: Array,
    variation: NDArray[np.complex128] | None = None,
    lines: tuple[Line, ...] = (),
    backlash: float = np.inf,
    **more: Any,
) -> System:
    """A System of one body per coordinate; rows (n, m)."""
    n, m = rows.shape
    far = None
    wave = np.zeros((m, 1), complex) if variation is None else variation
    if np.isfinite(backlash):
        far = FarFlanks(mesh=np.arange(m), B=-rows, variation=wave)
    values: dict[str, Any] = {
        "C": np.zeros((n, n)),
        "G": np.zeros((n, n)),
        "Kg": np.zeros((n, n)),
        "Cskew": np.zeros((n, n)),
        "damping": np.zeros(m),
    } | more
    damping = values.pop("damping")
    return System(
        dofs=Dofs(
            names=tuple(f"main/{i}/x" for i in range(n)),
            body=tuple(f"main/{i}" for i in range(n)),
            direction=("x",) * n,
            radius=np.ones(n),
            bodies=tuple(f"main/{i}" for i in range(n)),
            expand=np.zeros((6 * n, n)),
        ),
        M=M,
        K=K,
        meshes=MeshRows(
            name=tuple(f"main/a-b/{j + 1}" for j in range(m)),
            pair=("a-b",) * m,
            stage=("main",) * m,
            branch=tuple(range(1, m + 1)),
            side=("",) * m,
            B=rows,
            stiffness=stiffness,
            variation=wave,
            tone=np.zeros(m, np.int64),
            damping=damping,
            backlash=np.full(m, backlash),
            cos_base_helix=np.ones(m),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((n, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=force,
        tones=(TONE,),
        lines=lines,
        far=far,
        **values,
    )


def _mass(*, force: float, backlash: float = np.inf) -> System:
    """1 kg on a flank of 1e6 N/m: pressed where x > 0."""
    one = np.ones((1, 1))
    return system_of(one, 0 * one, one, np.array([1e6]), force=np.array([force]), backlash=backlash)


def _rich(*, damped: bool = True, swing: float = 0.3, load: float = 300.0, groups: bool = False) -> System:
    """Three masses in a row with two meshes, gyroscopic and skew terms, errors, line forces, a far flank, a spline."""
    rows = np.array([[1.0, 0.0], [-0.8, 0.9], [0.1, -1.0]])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.4], [0.0, -0.4, 0.0]])
    wave = (swing * np.array([[1.0, 0.3j], [np.exp(2j), 0.2]])).astype(complex)
    force = np.zeros((3, 3), complex)
    force[0, 0], force[1, 1], force[2, 2] = 20.0, 10j, 5.0 - 5j
    lines = (
        Line(
            frequency=TONE,
            gap=np.array([8e-6, 3e-6j]),
            link_gap=np.zeros(0, complex),
            force=force,
            far_gap=np.array([2e-6, -3e-6j]),
            group_gap=np.array([1e-6, 2e-6j]) if groups else np.zeros(0, complex),
            ramp_force=np.array([1.0, 0.5j, 0.0]),
        ),
        Line(frequency=TONE * 3 / 7, gap=np.array([2e-6, 0j]), link_gap=np.zeros(0, complex), force=0 * force),
    )
    laws: tuple[LawGroup, ...] = ()
    if groups:
        law = Law(stiffness=2e6, clearance=4e-6, friction=6.0)
        rolling = Law(stiffness=3e6, clearance=1e-6, exponent=1.5, load=200.0)
        laws = tuple(
            LawGroup(
                name=f"main/{i}/support",
                kind="support",
                rows=(f"main/{i}/support/x",),
                B=np.eye(3)[:, [i]],
                law=one,
                damping=np.zeros(1),
                lag=1e-4,
            )
            for i, one in ((0, law), (2, rolling))
        )
    return system_of(
        np.diag([1.0, 2.0, 1.5]),
        np.diag([4e5, 2e5, 3e5]),
        rows,
        np.array([1.5e6, 2e6]),
        force=np.array([load, 0.0, -load]),
        variation=wave,
        lines=lines,
        backlash=6e-5,
        C=np.diag([40.0, 10.0, 20.0]) * damped,
        G=30 * turn,
        Kg=-2e4 * np.eye(3),
        Cskew=(1e3 * damped) * turn,
        damping=np.array([60.0, 90.0]) * damped,
        zeta=0.02 if damped else None,
        euler=15 * turn,
        groups=laws,
    )


@dataclass(frozen=True)
class Made:
    """Builders shared by the tests of motion in time."""

    mass: Callable[..., System]
    rich: Callable[..., System]
    system: Callable[..., System]


@pytest.fixture(scope="session")
def made() -> Made:
    return Made(mass=_mass, rich=_rich, system=system_of)
