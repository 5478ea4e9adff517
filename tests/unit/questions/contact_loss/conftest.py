"""Systems with flanks that part, and their equation of motion written out, nothing of the package's solvers in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np
import pytest
from known import bench56, with_backlash
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from epicyclic.system.system import Dofs, FarFlanks, Line, LinkRows, MeshRows, System

Array = NDArray[np.float64]
TONE = 1000
# the small train: mesh frequency [Hz], load [N], backlash [m]
TRAIN_TONE = Fraction(1000)
LOAD, BACKLASH = 600.0, 60e-6


def _single(
    *,
    stiffness: float = 2e8,
    natural: float = 1000.0,
    zeta: float | None = 0.03,
    variation: tuple[complex, ...] = (),
    error: Mapping[int, complex] | None = None,
    push: Mapping[int, complex] | None = None,
    load: float = 2000.0,
    backlash: float = np.inf,
) -> System:
    """One gear pair along its line of action: M u'' + C u' + f(u - e) = load + push, f of both flanks."""
    B, swing = np.ones((1, 1)), np.array([variation], complex).reshape(1, -1)
    error, push = error or {}, push or {}
    far = np.isfinite(backlash)

    def line(order: int) -> Line:
        gap = np.array([error.get(order, 0.0)], complex)
        force = np.zeros((3, 1), complex)
        force[0, 0] = push.get(order, 0.0)
        return Line(
            frequency=Fraction(TONE * order),
            gap=gap,
            link_gap=np.zeros(0, complex),
            force=force,
            causes=("pair",),
            far_gap=-gap if far else np.zeros(0, complex),
        )

    return System(
        dofs=Dofs(
            names=("pair/rz",),
            body=("pair",),
            direction=("rz",),
            radius=np.ones(1),
            bodies=("pair",),
            expand=np.zeros((6, 1)),
        ),
        M=np.array([[stiffness / (2 * np.pi * natural) ** 2]]),
        C=np.zeros((1, 1)),
        G=np.zeros((1, 1)),
        K=np.zeros((1, 1)),
        Kg=np.zeros((1, 1)),
        Cskew=np.zeros((1, 1)),
        meshes=MeshRows(
            name=("main/pair",),
            pair=("pair",),
            stage=("main",),
            branch=(0,),
            side=("",),
            B=B,
            stiffness=np.array([stiffness]),
            variation=swing,
            tone=np.zeros(1, np.int64),
            damping=np.zeros(1),
            backlash=np.array([backlash]),
            cos_base_helix=np.ones(1),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((1, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.array([load]),
        tones=(Fraction(TONE),),
        lines=tuple(line(order) for order in sorted({*error, *push})),
        zeta=zeta,
        far=FarFlanks(mesh=np.array([0]), B=-B, variation=swing) if far else None,
    )


def _coupled(*, tones: int = 1, drag: float = 100.0, load: float = 60.0, far: bool = True) -> System:
    """Two meshes on six coordinates, every term of the equation there, far flanks with rows of their own."""
    random, n, m = np.random.default_rng(5), 6, 2
    B, F = random.standard_normal((n, m)), random.standard_normal((n, m))
    skew = random.standard_normal((n, n))
    damper, root = random.standard_normal((n, 2)), random.standard_normal((n, n))
    swing = np.zeros((m, 3), complex)
    swing.real, swing.imag = 0.15 * random.standard_normal((2, m, 3)) / np.arange(1, 4)
    own = (Fraction(137), Fraction(59))[:tones]
    turn = random.standard_normal((n, n))

    def line(tone: int, order: int) -> Line:
        mine = np.arange(m) % tones == tone
        gap = np.where(mine, 2e-5 * (random.standard_normal(m) + 1j * random.standard_normal(m)), 0)
        force = random.standard_normal((3, n)) * np.array([[3.0], [2.0], [1.0]]) + 0j
        return Line(
            frequency=order * own[tone],
            gap=gap,
            link_gap=np.zeros(0, complex),
            force=force,
            far_gap=np.where(mine, 1e-5 * random.standard_normal(m), 0) + 0j if far else np.zeros(0, complex),
        )

    return System(
        dofs=Dofs(
            names=tuple(f"body/{i}" for i in range(n)),
            body=("body",) * n,
            direction=("x",) * n,
            radius=np.ones(n),
            bodies=("body",),
            expand=np.zeros((6, n)),
        ),
        M=np.diag(random.uniform(0.5, 2.0, n)),
        C=40.0 * damper @ damper.T,
        G=60.0 * (skew - skew.T),
        K=2e5 * (root @ root.T + np.eye(n)),
        Kg=-200.0 * np.diag(random.uniform(0.5, 1.0, n)),
        Cskew=50.0 * (turn - turn.T),
        meshes=MeshRows(
            name=("main/a", "main/b"),
            pair=("pair",) * m,
            stage=("main",) * m,
            branch=(0,) * m,
            side=("",) * m,
            B=B,
            stiffness=np.array([8e5, 6e5]),
            variation=swing,
            tone=np.arange(m) % tones,
            damping=np.array([drag, 0.5 * drag]),
            backlash=np.array([4e-5, 6e-5]) if far else np.full(m, np.inf),
            cos_base_helix=np.ones(m),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((n, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=load * B.sum(axis=1),
        tones=own,
        lines=tuple(line(tone, order) for tone in range(tones) for order in (1, 2)),
        zeta=0.02,
        far=FarFlanks(mesh=np.arange(m), B=F, variation=swing[::-1]) if far else None,
    )


def _bench(scale: float = 0.35, backlash: float = 1e-4) -> System:
    """The set of 56 coordinates with backlash on both sides, its far flanks opposite to the loaded ones.

    Its torque of 2000 N m, 20 kN on each half of the sun, times `scale`.
    """
    try:
        system = bench56()
    except FileNotFoundError as error:
        pytest.skip(str(error))
    return with_backlash(system, backlash=backlash, load=scale)


@dataclass(frozen=True, eq=False)
class _Equation:
    """M q'' + (C + s G) q' + (K + s Cskew + s^2 Kg) q + sum of flanks = F(t) of a System with one tone."""

    system: System
    speed: float

    @cached_property
    def waves(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
        """Of the L lines: exponents i w (L,) [1/s], gaps of flanks (L, m + c) [m] and forces (L, n) [N]."""
        lines, power = self.system.lines, self.speed ** np.arange(3)
        turn = 2j * np.pi * self.speed * np.array([float(line.frequency) for line in lines])
        gap = np.array([self.system.flank_gaps(line) for line in lines], complex)
        push = np.array([power @ line.force for line in lines], complex)
        flanks = len(self.system.meshes.name) + self.system.far_flanks.mesh.size
        return turn, gap.reshape(-1, flanks), push.reshape(-1, len(self.system.force))

    def flanks(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Forces of the loaded and of the far flanks, (m,) and (c,)."""
        s, meshes, far, s_ = self.system, self.system.meshes, self.system.far_flanks, self.speed
        tone = 2 * np.pi * float(s.tones[0]) * s_
        orders = np.arange(1, meshes.variation.shape[1] + 1)
        wave = np.exp(1j * tone * t * orders)
        k = meshes.stiffness * (1 + (meshes.variation @ wave).real)
        k_far = meshes.stiffness[far.mesh] * (1 + (far.variation @ wave).real)
        e, rate = self._error(t)
        gap, fast = meshes.B.T @ q - e[: len(k)], meshes.B.T @ v - rate[: len(k)]
        gap_far = far.B.T @ q - meshes.backlash[far.mesh] - e[len(k) :]
        fast_far = far.B.T @ v - rate[len(k) :]
        loaded = np.where(gap > 0, k * gap + meshes.damping * fast, 0.0)
        return loaded, np.where(gap_far > 0, k_far * gap_far + meshes.damping[far.mesh] * fast_far, 0.0)

    def _error(self, t: float) -> tuple[Array, Array]:
        turn, gap, _ = self.waves
        phase = np.exp(turn * t)
        return (phase @ gap).real, ((turn * phase) @ gap).real

    def push(self, t: float) -> Array:
        """External force, (n,)."""
        turn, _, push = self.waves
        return np.asarray(self.system.force + (np.exp(turn * t) @ push).real)

    def slope(self) -> Callable[[float, Array], Array]:
        system, s, n = self.system, self.speed, len(self.system.force)
        inverse, C = np.linalg.inv(system.M), self.dampers()
        rest = system.K + s * system.Cskew + s**2 * system.Kg
        rate = C + s * system.G
        near, far = system.meshes.B, system.far_flanks.B

        def run(t: float, z: Array) -> Array:
            q, v = z[:n], z[n:]
            loaded, other = self.flanks(t, q, v)
            return np.concatenate([v, inverse @ (self.push(t) - rate @ v - rest @ q - near @ loaded - far @ other)])

        return run

    def dampers(self) -> Array:
        """C with modal damping of the mean system written out."""
        system = self.system
        if system.zeta is None:
            return system.C
        from scipy.linalg import eigh

        squared, shapes = eigh(system.mean_stiffness, system.M)
        back = system.M @ shapes
        return np.asarray(system.C + (back * (2 * system.zeta * np.sqrt(np.abs(squared)))) @ back.T)

    def run(self, start: Array, cycles: float, *, samples: int = 0, rtol: float = 1e-8, atol: float = 1e-13) -> Array:
        """States over so many mesh cycles from a start (2n,), at the end or at equal steps: (2n, samples)."""
        stop = cycles / (float(self.system.tones[0]) * self.speed)
        times = np.linspace(0, stop, samples, endpoint=False) if samples else [stop]
        found = solve_ivp(self.slope(), (0, stop), start, method="DOP853", t_eval=times, rtol=rtol, atol=atol)
        result: Array = found.y
        return result

    def force(self, states: Array) -> Array:
        """Mesh force of states (2n, N) over one mesh cycle, (m, N): far flanks negative."""
        n = len(self.system.force)
        times = np.arange(states.shape[1]) / states.shape[1] / (float(self.system.tones[0]) * self.speed)
        rows = []
        for t, z in zip(times, states.T, strict=True):
            loaded, other = self.flanks(float(t), z[:n], z[n:])
            np.subtract.at(loaded, self.system.far_flanks.mesh, other)
            rows.append(loaded)
        return np.array(rows).T


@dataclass(frozen=True, slots=True)
class Builders:
    """What the tests build with."""

    single: Callable[..., System] = _single
    coupled: Callable[..., System] = _coupled
    bench: Callable[..., System] = _bench
    equation: type[_Equation] = _Equation
    replace: Callable[..., System] = replace


@pytest.fixture(scope="session")
def made() -> Builders:
    return Builders()


def _run_out(frequency: Fraction, gap: Sequence[complex]) -> Line:
    values = np.array(gap, complex)
    return Line(
        frequency=frequency,
        gap=values,
        link_gap=np.zeros(0, complex),
        force=np.zeros((3, 5), complex),
        causes=(f"run-out at {frequency}",),
        far_gap=-values,
    )


def _train(
    *,
    ratio: Fraction | None = None,
    slow: Sequence[tuple[Fraction, complex]] = (),
    swing: float = 0.25,
    mesh_damping: float = 0.0,
    load: float = LOAD,
    backlash: float = BACKLASH,
) -> System:
    """Rotations a, c and a shaft b with x, y, rotation; turning as a whole is free.

    ratio : second mesh frequency per first, one for both where None.
    slow : (frequency per mesh frequency, error [m] of the first mesh; the second has half of it, turned).
    """
    B = np.array([[1.0, 0.0], [0.94, 0.34], [0.34, -0.94], [1.0, -0.8], [0.0, 1.0]])
    second = TRAIN_TONE if ratio is None else TRAIN_TONE * ratio
    tone = np.array([0, 0 if ratio is None else 1])
    stiffness = np.array([2.0e8, 1.6e8])
    variation = (swing * np.array([[1.0, 0.3j, 0.1], [np.exp(1j), 0.3, 0.1j]])).astype(np.complex128)
    lines = {TRAIN_TONE: [3e-6, 0.0 if ratio is not None else 2e-6j]}
    if ratio is not None:
        lines[second] = [0.0, 2e-6j]
    waves = [_run_out(frequency, gap) for frequency, gap in lines.items()]
    waves += [_run_out(TRAIN_TONE * part, [size, 0.5j * size]) for part, size in slow]
    return System(
        dofs=Dofs(
            names=("main/a/rz", "main/b/x", "main/b/y", "main/b/rz", "main/c/rz"),
            body=("main/a", "main/b", "main/b", "main/b", "main/c"),
            direction=("rz", "x", "y", "rz", "rz"),
            radius=np.ones(5),
            bodies=("main/a", "main/b", "main/c"),
            expand=np.zeros((18, 5)),
        ),
        M=np.diag([2.0, 3.0, 3.0, 2.5, 4.0]),
        C=np.zeros((5, 5)),
        G=np.zeros((5, 5)),
        K=np.diag([0.0, 1.5e8, 1.2e8, 0.0, 0.0]),
        Kg=np.zeros((5, 5)),
        Cskew=np.zeros((5, 5)),
        meshes=MeshRows(
            name=("main/a-b", "main/b-c"),
            pair=("a-b", "b-c"),
            stage=("main", "other"),
            branch=(0, 0),
            side=("", ""),
            B=B,
            stiffness=stiffness,
            variation=variation,
            tone=tone,
            damping=np.full(2, mesh_damping),
            backlash=np.full(2, backlash),
            cos_base_helix=np.ones(2),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((5, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        # force along rz of a and c that the turning motion (1, -1, -0.8) balances
        force=load * np.array([1.0, 0.0, 0.0, 0.0, 1.25]),
        tones=(TRAIN_TONE,) if ratio is None else (TRAIN_TONE, second),
        lines=tuple(sorted(waves, key=lambda line: line.frequency)),
        zeta=0.05,
        far=FarFlanks(mesh=np.arange(2), B=-B, variation=variation),
    )


@pytest.fixture(scope="session")
def train() -> Callable[..., System]:
    return _train
