"""A small train with backlash: two gears on one shaft, each in mesh; one or two mesh frequencies, and run-outs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.system.system import Dofs, FarFlanks, Line, LinkRows, MeshRows, System

Array = NDArray[np.float64]
TONE = Fraction(1000)
LOAD, BACKLASH = 600.0, 60e-6


def _line(frequency: Fraction, gap: Sequence[complex]) -> Line:
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
    second = TONE if ratio is None else TONE * ratio
    tone = np.array([0, 0 if ratio is None else 1])
    stiffness = np.array([2.0e8, 1.6e8])
    variation = (swing * np.array([[1.0, 0.3j, 0.1], [np.exp(1j), 0.3, 0.1j]])).astype(np.complex128)
    lines = {TONE: [3e-6, 0.0 if ratio is not None else 2e-6j]}
    if ratio is not None:
        lines[second] = [0.0, 2e-6j]
    waves = [_line(frequency, gap) for frequency, gap in lines.items()]
    waves += [_line(TONE * part, [size, 0.5j * size]) for part, size in slow]
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
        tones=(TONE,) if ratio is None else (TONE, second),
        lines=tuple(sorted(waves, key=lambda line: line.frequency)),
        zeta=0.05,
        far=FarFlanks(mesh=np.arange(2), B=-B, variation=variation),
    )


@pytest.fixture(scope="session")
def train() -> Callable[..., System]:
    return _train
