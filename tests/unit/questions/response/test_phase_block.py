"""The preconditioner by phases of the tone of links that pass: at slow speeds it is the inverse of the balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.unit.bodies.test_passing_links import FLANGE, STAGE

from epicyclic import assemble, load
from epicyclic.questions.response.balance import Batch, _Balance, _blocks, gmres
from epicyclic.questions.response.phase_block import phase_block
from epicyclic.questions.response.response import Response, response

ARM = {
    "stages.main.ring.support.bolts": None,
    "bodies.arm": {
        "mass": "40 kg",
        "inertia": "2 kg m^2",
        "tilt_inertia": "1 kg m^2",
        "support": {"radial": "2e7 N/m", "rz": "2e6 N m/rad", "tilt": "2e6 N m/rad", "z": "1e8 N/m"},
    },
    "couplings.bolted": {
        "between": ["main.ring", "arm"],
        "bolts": {**FLANGE, "count": 6, "radius": "175 mm", "radial": "2e9 N/m", "tangential": "1e9 N/m"},
    },
    "operation.held": ["ring", "arm"],
}


@pytest.fixture(scope="module")
def ready() -> Response:
    """A ring on stiff bolts before a soft arm."""
    return response(assemble(load(STAGE, ARM)))


@pytest.mark.parametrize("shifted", [False, True])
def test_the_balance_of_a_slow_tone_is_solved_in_a_few_products(ready: Response, shifted: bool) -> None:
    """Of a load in the middle of the lines; D^-1 alone, of the mean stiffness, stalls."""
    made = ready.kernel((4, 30, 24), shifted=shifted)
    points, n = made.lattice.points, ready.modal.squared.size
    frequency = 1e-3 * (points @ ready.omega + (0.4 * ready.omega[1] if shifted else 0.0))
    batch = Batch(
        frequency=frequency[None],
        truncated_frequency=np.zeros((1, len(made.truncated))),
        frame=np.full(1, 1e-3),
        error=np.zeros((len(ready.system.meshes.name), 1, len(points)), complex),
        force=np.zeros((1, len(points), n), complex),
    )
    right = np.random.default_rng(1).normal(size=(1, 2, len(points), n))
    right[:, :, np.abs(points).sum(axis=1) > 2] = right[..., ready.modal.rigid] = 0.0
    if not shifted:
        right[:, 1, 0] = 0.0  # the mean is real
    step, rows = _Balance(ready.system, ready.modal, made, batch, right, 1e-6).preconditioned()
    block, target = phase_block(ready.system, ready.modal, made, frequency, 1e-3), 1e-6 * np.linalg.norm(step, axis=1)
    _, left, calls = gmres(lambda x: rows(block(x)), step, target=target)
    _, worse, more = gmres(rows, step, target=target)
    assert left <= target
    assert calls <= 20
    assert worse > target or more > 3 * calls


def test_it_follows_the_resonant_block_where_links_pass_alone(ready: Response) -> None:
    for system, count in ((ready.system, 3), (replace(ready.system, passing=None), 1)):
        made = response(system)
        kernel = made.kernel((*(4, 4)[: len(made.lines.tones)], 0), shifted=False)
        points = kernel.lattice.points
        batch = Batch(
            frequency=(points @ made.omega)[None],
            truncated_frequency=np.zeros((1, len(kernel.truncated))),
            frame=np.ones(1),
            error=np.zeros((len(system.meshes.name), 1, len(points)), complex),
            force=np.zeros((1, len(points), len(system.force)), complex),
        )
        right = np.zeros((1, 2, len(points), len(system.force)))
        assert len(list(_blocks(_Balance(system, made.modal, kernel, batch, right, 1e-6), 0))) == count
