"""Convergence with the number of harmonics: as fast as the smoothness of the stiffness allows."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from epicyclic.questions.modes.eigen import Modal, modal_form
from epicyclic.questions.response.balance import Batch, solve
from epicyclic.questions.response.lattice import kernel
from epicyclic.system.system import Dofs, LinkRows, MeshRows, System

LENGTH = 600


def rectangular() -> System:
    """One gear on a mesh whose stiffness jumps twice a cycle: harmonics fall as 1/l."""
    orders = np.arange(1, LENGTH + 1)
    return System(
        dofs=Dofs(
            names=("gear/rz",), body=("gear",), direction=("rz",), radius=np.ones(1), bodies=(), expand=np.zeros((0, 1))
        ),
        M=np.eye(1),
        C=np.eye(1) * 0.1,
        G=np.zeros((1, 1)),
        K=np.zeros((1, 1)),
        Kg=np.zeros((1, 1)),
        Cskew=np.zeros((1, 1)),
        meshes=MeshRows(
            name=("mesh",),
            pair=("mesh",),
            stage=("main",),
            branch=(0,),
            side=("",),
            B=np.eye(1),
            stiffness=np.ones(1),
            variation=0.6 * np.sin(np.pi * 0.37 * orders)[None] / (np.pi * orders) * np.ones((1, 1), complex),
            tone=np.zeros(1, np.int64),
            damping=np.zeros(1),
            backlash=np.full(1, np.inf),
            cos_base_helix=np.ones(1),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((1, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.ones(1),
        tones=(Fraction(1),),
    )


def harmonics(system: System, modal: Modal, count: int) -> NDArray[np.complex128]:
    force = np.zeros((1, count + 1, 1), complex)
    force[:, 0] = system.force
    rows = Batch(
        frequency=0.55 * np.arange(count + 1.0)[None],
        truncated_frequency=0.55 * np.arange(count + 1.0, count + LENGTH + 1)[None],
        frame=np.ones(1),
        error=np.zeros((1, 1, count + 1), complex),
        force=force,
    )
    made = kernel(system.varying, np.zeros(1, np.int64), (count,), 0, mirrored=True)
    y = solve(system, modal, made, rows, tolerance=1e-12).y[0, :, :, 0]
    return np.asarray(y[0] + 1j * y[1])


def test_displacement_converges_with_order_five_halves_for_a_stiffness_that_jumps() -> None:
    # forces fall as 1/h, displacements as 1/h^3, and the norm of the tail beyond H as H^(-5/2)
    system = rectangular()
    modal = modal_form(system)
    exact = harmonics(system, modal, 500)
    counts = np.array([8, 16, 32, 64, 128])
    errors = []
    for count in counts:
        padded = np.zeros_like(exact)
        padded[: count + 1] = harmonics(system, modal, int(count))
        errors.append(np.linalg.norm(padded - exact))
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert abs(slope + 2.5) < 0.2
