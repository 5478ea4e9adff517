"""A pair of gears with two meshes, and the equation of motion integrated straight from the System."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from epicyclic.system.system import Dofs, Line, LinkRows, MeshRows, System

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
RADII = (0.04, 0.06)
TONE = Fraction(137)
_SKEW = np.kron(np.diag([1.0, 2.0]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
_PLANE = np.diag([1.0, 1.0, 0.0, 1.0, 1.0, 0.0])


def _line(frequency: Fraction, gap: list[complex], *, push: complex = 0.0, cause: str = "stages.main.a") -> Line:
    force = np.zeros((3, 6), complex)
    force[0, 0], force[1, 4], force[2, 1] = push, 0.3j * push, 0.5 * push
    return Line(
        frequency=frequency, gap=np.array(gap, complex), link_gap=np.zeros(4, complex), force=force, causes=(cause,)
    )


def _pair(
    *,
    free: bool = True,
    zeta: float | None = 0.03,
    mesh_damping: float = 200.0,
    turning: float = 1.0,
    swing: float = 0.2,
    lines: tuple[Line, ...] | None = None,
) -> System:
    """Gears a and b in their plane; `free`: nothing holds their rotation but the torques."""
    ra, rb = RADII
    angles = np.array([0.35, 0.6])
    B = np.array([[np.cos(t), np.sin(t), ra, -np.cos(t), -np.sin(t), rb] for t in angles]).T
    stiffness = np.array([3e6, 4e6])
    shares = np.array([[1.0, 0.4j, 0.2], [np.exp(2j), 0.4j * np.exp(4j), 0.2 * np.exp(6j)]])
    supports = np.array([2e6, 3e6, 4e6, 2.5e6])
    links = np.eye(6)[:, [0, 1, 3, 4]]
    K = (links * supports) @ links.T + np.diag([0, 0, 0, 0, 0, 0 if free else 4e6 * rb**2])
    damper = 60.0 * np.outer(links[:, 0] - links[:, 2], links[:, 0] - links[:, 2])
    if lines is None:
        lines = (_line(Fraction(0), [2e-6, -1e-6]), _line(TONE, [3e-6, 2e-6j], push=40), _line(2 * TONE, [1e-6j, 1e-6]))
    return System(
        dofs=Dofs(
            names=tuple(f"main/{body}/{d}" for body in "ab" for d in ("x", "y", "rz")),
            body=("main/a",) * 3 + ("main/b",) * 3,
            direction=("x", "y", "rz") * 2,
            radius=np.array([1, 1, ra, 1, 1, rb]),
            bodies=("main/a", "main/b"),
            expand=np.zeros((12, 6)),
        ),
        M=np.diag([1.0, 1.0, 0.6 * ra**2, 2.0, 2.0, 0.6 * 2 * rb**2]),
        C=damper,
        G=turning * 120.0 * _SKEW,
        K=K,
        Kg=-turning * 4e4 * _PLANE,
        Cskew=turning * 3e3 * _SKEW,
        meshes=MeshRows(
            name=("main/a-b/1", "main/a-b/2"),
            pair=("stages.main.meshes.a-b",) * 2,
            stage=("main",) * 2,
            branch=(1, 2),
            side=("", ""),
            B=B,
            stiffness=stiffness,
            variation=(swing * shares).astype(complex),
            tone=np.zeros(2, np.int64),
            damping=np.full(2, mesh_damping),
            backlash=np.full(2, np.inf),
            cos_base_helix=np.ones(2),
        ),
        links=LinkRows(
            name=tuple(f"main/{body}/support/{d}" for body in "ab" for d in "xy"),
            link=("main/a/support",) * 2 + ("main/b/support",) * 2,
            B=links,
            stiffness=supports,
            damping=np.zeros(4),
        ),
        force=np.array([50.0, -30.0, 400.0 * ra, 0.0, 20.0, 400.0 * rb]),
        tones=(TONE,),
        lines=tuple(sorted(lines, key=lambda line: line.frequency)),
        zeta=zeta,
    )


def _damping(system: System) -> Array:
    """C with the modal ratio written out in physical coordinates, without mesh dampers."""
    M, K = system.M, system.mean_stiffness
    root = np.sqrt(np.diag(M))
    squared, vectors = np.linalg.eigh(K / np.outer(root, root))
    rates = 2 * (system.zeta or 0.0) * np.sqrt(np.where(squared > 1e-6 * squared[-1], squared, 0.0))
    modal = (vectors * rates) @ vectors.T * np.outer(root, root)
    return np.asarray(system.C + modal)


@dataclass(frozen=True)
class Motion:
    """M q'' = ... of a System at relative speed s, term by term."""

    system: System
    speed: float

    @cached_property
    def waves(self) -> tuple[ComplexArray, ComplexArray]:
        """Exponents i w of the mesh stiffness (m, orders) and of the lines (L,) [1/s]."""
        meshes, turn = self.system.meshes, 2j * np.pi * self.speed
        orders = np.arange(1, meshes.variation.shape[1] + 1)
        tones = np.array([float(self.system.tones[i]) for i in meshes.tone])
        return turn * np.outer(tones, orders), turn * np.array([float(line.frequency) for line in self.system.lines])

    @cached_property
    def amplitudes(self) -> tuple[Array, Array]:
        """Of the lines: gaps (L, m) [m] and forces (L, n) [N]."""
        lines, power = self.system.lines, self.speed ** np.arange(3)
        gap = np.array([line.gap for line in lines]).reshape(len(lines), -1)
        return gap, np.array([power @ line.force for line in lines]).reshape(len(lines), -1)

    def laws(self, t: float) -> tuple[Array, Array, Array, Array]:
        """Mesh stiffness, e, e' (m,) and the right side (n,)."""
        meshes, (meshing, turning), (gap, push) = self.system.meshes, self.waves, self.amplitudes
        k = meshes.stiffness * (1 + (meshes.variation * np.exp(meshing * t)).sum(axis=1).real)
        phase = np.exp(turning * t)
        return k, (phase @ gap).real, ((turning * phase) @ gap).real, self.system.force + (phase @ push).real

    def mesh_force(self, t: float, q: Array, v: Array) -> Array:
        return self.pressed(self.laws(t), q, v)

    def pressed(self, laws: tuple[Array, Array, Array, Array], q: Array, v: Array) -> Array:
        k, e, rate, _ = laws
        B = self.system.meshes.B
        return np.asarray(k * (B.T @ q - e) + self.system.meshes.damping * (B.T @ v - rate))

    def integrate(self, times: Array, q: Array, v: Array, *, rtol: float) -> tuple[Array, Array]:
        """Coordinates (n, T) and mesh forces (m, T) at `times` from a state at times[0]."""
        system, s, n = self.system, self.speed, q.size
        rest = system.K + s**2 * system.Kg + s * system.Cskew
        rates = _damping(system) + s * system.G
        inverse = np.linalg.inv(system.M)

        def slope(t: float, state: Array) -> Array:
            x, u = state[:n], state[n:]
            laws = self.laws(t)
            push = laws[3] - rates @ u - rest @ x - system.meshes.B @ self.pressed(laws, x, u)
            return np.concatenate([u, inverse @ push])

        found = solve_ivp(
            slope,
            (times[0], times[-1]),
            np.concatenate([q, v]),
            method="DOP853",
            t_eval=times,
            rtol=rtol,
            atol=rtol * 1e-6,
        )
        forces = [self.mesh_force(t, x[:n], x[n:]) for t, x in zip(times, found.y.T, strict=True)]
        return found.y[:n], np.array(forces).T


@dataclass(frozen=True)
class Case:
    """Builders shared by the tests of the periodic response and of its derivatives."""

    pair: Callable[..., System]
    line: Callable[..., Line]
    damping: Callable[[System], Array]
    motion: type[Motion]


@pytest.fixture(scope="session")
def case() -> Case:
    return Case(pair=_pair, line=_line, damping=_damping, motion=Motion)
