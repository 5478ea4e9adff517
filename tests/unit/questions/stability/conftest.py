"""Small systems with varying stiffness, and the monodromy of any System integrated in its physical coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from epicyclic.system.system import Dofs, LinkRows, MeshRows, System

Array = NDArray[np.float64]


def _system(
    M: ArrayLike,
    K: ArrayLike,
    B: ArrayLike,
    k: ArrayLike,
    variation: ArrayLike,
    *,
    tones: tuple[Fraction, ...] = (Fraction(1),),
    tone: ArrayLike | None = None,
    damping: ArrayLike | None = None,
    zeta: float | None = None,
    **matrices: ArrayLike,
) -> System:
    """A System of given matrices; B (n, m), variation (m, L); C, G, Kg, Cskew where given."""
    mass, rows = np.asarray(M, float), np.asarray(B, float)
    n, m = rows.shape
    square: dict[str, Any] = {
        name: np.asarray(matrices.get(name, np.zeros((n, n))), float) for name in ("C", "G", "Kg", "Cskew")
    }
    return System(
        dofs=Dofs(
            names=tuple(f"body/{i}" for i in range(n)),
            body=("body",) * n,
            direction=("x",) * n,
            radius=np.ones(n),
            bodies=("body",),
            expand=np.zeros((6, n)),
        ),
        M=mass,
        K=np.asarray(K, float),
        meshes=MeshRows(
            name=tuple(f"main/a-b/{i + 1}" for i in range(m)),
            pair=("a-b",) * m,
            stage=tuple(f"stage{i}" for i in (np.zeros(m, int) if tone is None else np.asarray(tone))),
            branch=tuple(range(1, m + 1)),
            side=("",) * m,
            B=rows,
            stiffness=np.asarray(k, float),
            variation=np.asarray(variation, complex),
            tone=np.zeros(m, np.int64) if tone is None else np.asarray(tone, np.int64),
            damping=np.zeros(m) if damping is None else np.asarray(damping, float),
            backlash=np.full(m, np.inf),
            cos_base_helix=np.ones(m),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((n, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.zeros(n),
        tones=tones,
        zeta=zeta,
        **square,
    )


def _rates(system: System) -> Array:
    """C with the modal ratio written out in physical coordinates, mesh dampers included."""
    M, K, B = system.M, system.mean_stiffness, system.meshes.B
    root = np.linalg.cholesky(M)
    inverse = np.linalg.inv(root)
    squared, vectors = np.linalg.eigh(inverse @ K @ inverse.T)
    rates = 2 * (system.zeta or 0.0) * np.sqrt(np.where(squared > 1e-9 * squared[-1], squared, 0.0))
    modal = root @ (vectors * rates) @ vectors.T @ root.T
    return np.asarray(system.C + modal + (B * system.meshes.damping) @ B.T)


def _stiffness(system: System, speed: float) -> Callable[[float], Array]:
    meshes = system.meshes
    orders = np.arange(1, meshes.variation.shape[1] + 1)
    tones = np.array([float(system.tones[i]) for i in meshes.tone])

    def at(t: float) -> Array:
        wave = np.exp(2j * np.pi * speed * t * np.outer(tones, orders))
        return np.asarray(meshes.stiffness * (1 + (meshes.variation * wave).sum(axis=1).real))

    return at


def _monodromy(
    system: System,
    speed: float,
    period: float,
    *,
    start: Array | None = None,
    first: float = 0.0,
    rtol: float = 1e-10,
    stiffness: Callable[[float], Array] | None = None,
) -> Array:
    """States (q, q') one period after `first` from states (2n, columns), of the identity where none are given."""
    n = len(system.M)
    K = system.K + speed**2 * system.Kg + speed * system.Cskew
    C, B = _rates(system) + speed * system.G, system.meshes.B
    solve, law = np.linalg.inv(system.M), stiffness or _stiffness(system, speed)
    begin = np.eye(2 * n) if start is None else start

    def slope(t: float, state: Array) -> Array:
        z = state.reshape(2 * n, -1)
        push = K @ z[:n] + C @ z[n:] + (B * law(t)) @ (B.T @ z[:n])
        return np.concatenate([z[n:], -solve @ push]).ravel()

    found = solve_ivp(
        slope,
        (first, first + period),
        begin.ravel(),
        method="DOP853",
        rtol=rtol,
        atol=rtol * 1e-3,
        t_eval=[first + period],
    )
    return np.asarray(found.y[:, -1].reshape(2 * n, -1))


def _apart(one: NDArray[Any], other: NDArray[Any]) -> float:
    """Largest distance of two sets of multipliers, matched as well as can be."""
    from scipy.optimize import linear_sum_assignment

    distance = np.abs(np.asarray(one)[:, None] - np.asarray(other)[None])
    return float(distance[linear_sum_assignment(distance)].max())


def _two(swing: float, *, zeta: float | None = None, G: float = 0.0, cross: float = 1.0) -> System:
    """Two coordinates of w = 2 pi and 2 pi 2.3, joined by one mesh whose stiffness swings once a cycle."""
    omega = 2 * np.pi * np.array([1.0, 2.3])
    row = np.array([[1.0], [cross]])
    k = 0.2 * omega[0] ** 2
    K = np.diag(omega**2) - k * row @ row.T
    return _system(np.eye(2), K, row, [k], [[swing]], zeta=zeta, G=G * np.array([[0.0, -1.0], [1.0, 0.0]]))


@dataclass(frozen=True)
class Case:
    """Builders shared by the tests of stability."""

    system: Callable[..., System] = _system
    two: Callable[..., System] = _two
    rates: Callable[[System], Array] = _rates
    stiffness: Callable[[System, float], Callable[[float], Array]] = _stiffness
    monodromy: Callable[..., Array] = _monodromy
    apart: Callable[..., float] = _apart


@pytest.fixture(scope="session")
def case() -> Case:
    return Case()
