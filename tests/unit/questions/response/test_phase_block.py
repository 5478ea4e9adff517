"""The preconditioner by phases of the tone of links that pass: at slow speeds it is the inverse of the balance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.unit.bodies.test_passing_links import FLANGE, STAGE

from epicyclic import assemble, load
from epicyclic.questions.response.balance import Batch, _Balance, _block, gmres, phase_block, resonant_block
from epicyclic.questions.response.response import Response, _further, response
from epicyclic.system.system import Array

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


def balance_of(ready: Response, harmonics: tuple[int, ...], speed: float, *, shifted: bool = False) -> _Balance:
    """The balance at a relative speed of a load in the middle of the lines."""
    made = ready.kernel(harmonics, shifted=shifted)
    points, n = made.lattice.points, ready.modal.squared.size
    batch = Batch(
        frequency=speed * (points @ ready.omega + (0.4 * ready.omega[1] if shifted else 0.0))[None],
        truncated_frequency=np.zeros((1, len(made.truncated))),
        frame=np.full(1, speed),
        error=np.zeros((len(ready.system.meshes.name), 1, len(points)), complex),
        force=np.zeros((1, len(points), n), complex),
    )
    right = np.random.default_rng(1).normal(size=(1, 2, len(points), n))
    right[:, :, np.abs(points).sum(axis=1) > 2] = right[..., ready.modal.rigid] = 0.0
    if not shifted:
        right[:, 1, 0] = 0.0  # the mean is real
    return _Balance(ready.system, ready.modal, made, batch, right, 1e-6)


def products(balance: _Balance, block: Callable[[Array], Array]) -> float:
    """Products of GMRES with a preconditioner to 1e-6; inf where it stalls."""
    step, rows = balance.preconditioned()
    target = 1e-6 * np.linalg.norm(step, axis=1)
    _, left, calls = gmres(lambda x: rows(block(x)), step, target=target)
    return calls if left <= target else np.inf


@pytest.mark.parametrize("shifted", [False, True])
def test_the_balance_of_a_slow_tone_is_solved_in_a_few_products(ready: Response, shifted: bool) -> None:
    """Of a load in the middle of the lines; D^-1 alone, of the mean stiffness, stalls."""
    balance = balance_of(ready, (4, 30, 24), 1e-3, shifted=shifted)
    phases = phase_block(ready.system, ready.modal, balance.kernel, balance.batch.frequency[0], 1e-3)
    taken = products(balance, phases)
    assert taken <= 20
    assert products(balance, np.asarray) > 3 * taken


def test_phases_and_the_resonant_block_in_a_row_take_fewer_products_than_either(ready: Response) -> None:
    """At the operating speed, where the frequencies along a line differ."""
    balance = balance_of(ready, (4, 12, 8), 1.0)
    system, modal, made, frequency = ready.system, ready.modal, balance.kernel, balance.batch.frequency[0]
    both, _ = _block(balance, 0, balance.preconditioned()[1])
    resonant = resonant_block(system, modal, made, frequency)
    assert resonant is not None
    phases = phase_block(system, modal, made, frequency, 1.0)
    taken = products(balance, both)
    assert 3 * taken < min(products(balance, resonant), products(balance, phases))
    assert taken < products(balance, lambda x: phases(x) + resonant(x))  # side by side they solve some of it twice


@pytest.mark.parametrize(("cross", "beyond", "more"), [(50, 50, 0), (50, 98, 8), (90, 98, 8), (98, 98, 0)])
def test_combinations_go_on_where_the_truncation_would_be_refused(cross: int, beyond: int, more: int) -> None:
    residual, limit = np.array([[0.0, 0.0, 7e-4]]), np.array([[1600, 1600, 34]])
    assert _further(residual, (90, 60, cross), limit, 1e-8, beyond).tolist() == [[0, 0, more]]
    assert _further(residual / 100, (90, 60, cross), limit, 1e-8, beyond).tolist() == [[0, 0, 0]]
