"""Derivatives of mesh forces against differences of the solution, and the adjoint operator against its definition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.questions.response import SweepOptions, balance
from epicyclic.questions.response.lattice import product, truncated_product
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.response.response import Block, Response, _block, response
from epicyclic.questions.response.steady import sweep
from epicyclic.questions.studies.adjoint import (
    SystemNumbers,
    adjoint_form,
    adjoint_parts,
    combined,
    harmonic_weights,
    measure,
    numbers,
    truncated_product_adjoint,
)
from epicyclic.questions.studies.gradient import basis_of, force_derivatives, gradient
from epicyclic.system.system import System

Array = NDArray[np.float64]
SPEED = 1.3


def system_of(case: Any, *, free: bool = False, tones: int = 1, shaft: bool = True) -> System:
    """The pair of gears with everything a System may have: one or two mesh frequencies, shaft lines that meet."""
    fast, slow = Fraction(137), Fraction(137 * 3, 7)
    lines = [case.line(Fraction(0), [2e-6, -1e-6], push=5), case.line(fast, [3e-6, 2e-6j], push=40)]
    lines.append(case.line(slow if tones == 2 else 2 * fast, [2e-6, 4e-6j], push=30))
    if shaft:  # the second is the first's image about the mesh frequency: one group, one of them conjugate
        lines.append(case.line(Fraction(137, 14), [4e-6, 3e-6j], push=20))
        lines.append(case.line(fast - Fraction(137, 14), [1e-6j, 2e-6], push=10))
    pair: System = case.pair(free=free, lines=tuple(lines))
    if tones == 1:
        return pair
    return replace(pair, tones=(slow, fast), meshes=replace(pair.meshes, tone=np.array([1, 0])))


def moved(system: System, change: SystemNumbers, h: float) -> System:
    """The System with its numbers moved; frequencies, all alike, by a factor."""
    meshes = replace(
        system.meshes,
        B=system.meshes.B + h * change.B,
        stiffness=system.meshes.stiffness + h * change.stiffness,
        variation=system.meshes.variation + h * change.variation,
        damping=system.meshes.damping + h * change.damping,
    )
    factor = Fraction(1 + (h * change.tones[0] / float(system.tones[0]) if change.tones.any() else 0.0))
    lines = [
        replace(
            line,
            frequency=line.frequency * factor,
            gap=line.gap + h * change.line_gap[r],
            force=line.force + h * change.line_force[r],
        )
        for r, line in enumerate(system.lines)
    ]
    arrays = {name: getattr(system, name) + h * getattr(change, name) for name in ("M", "C", "G", "K", "Kg", "Cskew")}
    return replace(
        system,
        meshes=meshes,
        lines=tuple(lines),
        tones=tuple(tone * factor for tone in system.tones),
        force=system.force + h * change.force,
        zeta=(system.zeta or 0.0) + h * float(change.zeta),
        **arrays,
    )


def rms(system: System) -> Array:
    found = sweep(system, SweepOptions(relative_speed=[SPEED], tolerance=1e-11))
    return np.asarray(found.mesh_force_rms.values[:, 0])


def _moved_rms(system: System, change: SystemNumbers, h: float) -> Array:
    return rms(moved(system, change, h))


def difference(answer: Callable[[float], Array], h: float = 1e-4) -> Array:
    """Five-point derivative at 0 of a function of a relative step."""
    near, far = (answer(k * h) - answer(-k * h) for k in (1, 2))
    return np.asarray((8 * near - far) / (12 * h))


def zero_change(system: System) -> SystemNumbers:
    """No change: a derivative to which single entries are given."""
    return combined([0.0], [numbers(system)])


def one(system: System, name: str) -> SystemNumbers:
    """A change of one kind of number, of about its own size; matrices keep their symmetry."""
    draw = np.random.default_rng(5)
    blank = zero_change(system)
    n, m = system.meshes.B.shape
    shapes = {"B": system.meshes.B, "stiffness": system.meshes.stiffness, "damping": system.meshes.damping}
    if name in ("G", "Cskew"):
        raw = draw.normal(size=(n, n))
        return blank._replace(**{name: (raw - raw.T) * np.abs(getattr(system, name)).max()})
    if name in ("M", "C", "K", "Kg"):
        root = np.sqrt(np.abs(np.diag(getattr(system, name))))
        raw = 0.3 * draw.normal(size=(n, n)) * np.outer(root, root)
        return blank._replace(**{name: raw + raw.T})
    if name in shapes:
        return blank._replace(**{name: 0.3 * draw.normal(size=shapes[name].shape) * np.abs(shapes[name]).max()})
    if name == "variation":
        swing = 0.1 * (draw.normal(size=(m, 3)) + 1j * draw.normal(size=(m, 3)))
        return blank._replace(variation=np.array(swing, complex))
    if name == "line_gap":
        return blank._replace(line_gap=np.array(1e-6 * (draw.normal(size=(len(system.lines), m)) + 0.5j), complex))
    if name == "line_force":
        push = 20.0 * (draw.normal(size=(len(system.lines), 3, n)) + 0.5j)
        return blank._replace(line_force=np.array(push, complex))
    if name == "speed":
        tones = np.array([float(tone) for tone in system.tones])
        lines = np.array([float(line.frequency) for line in system.lines])
        return blank._replace(tones=tones, line_frequency=lines)
    if name == "zeta":
        return blank._replace(zeta=np.array(0.03))
    assert name == "force"
    return blank._replace(force=np.asarray(30.0 * draw.normal(size=n)))


NAMES = ("M", "C", "G", "K", "Kg", "Cskew", "B", "stiffness", "damping", "variation", "line_gap", "line_force")


COMBINED = ("B", "variation", "line_gap", "speed")  # of several mesh frequencies, those with code of their own


@pytest.mark.parametrize(
    ("name", "tones"), [*((name, 1) for name in (*NAMES, "speed", "zeta", "force")), *((name, 2) for name in COMBINED)]
)
def test_every_number_against_differences(case: Any, name: str, tones: int) -> None:
    system = system_of(case, tones=tones)
    change = one(system, name)
    found = force_derivatives(system, [change], relative_speed=SPEED, tolerance=1e-11)
    wanted = difference(partial(_moved_rms, system, change))
    # the difference leaves (1e-4)^4 of truncation and 1e-12 / 1e-4 of rounding: 1e-7 of the derivative
    off = np.abs(found.derivative[0, :, 0] - wanted).max()
    assert off <= 1e-7 * np.abs(wanted).max() + 1e-9 * np.abs(found.value).max()


def test_free_gears_turn_freely_and_modal_damping_follows(case: Any) -> None:
    """A rigid mode, and modal damping alone, whose matrix moves with K and M."""
    system = replace(system_of(case, free=True), C=np.zeros((6, 6)))
    b = system.links.B[:, 1]
    lateral = np.outer(b, b) * 2e6
    changes = [zero_change(system)._replace(K=lateral), one(system, "M"), one(system, "stiffness")]
    found = force_derivatives(system, changes, relative_speed=SPEED, tolerance=1e-11)
    assert not found.constrained.any()
    for change, mine in zip(changes, found.derivative[:, :, 0], strict=True):
        wanted = difference(partial(_moved_rms, system, change))
        assert np.abs(mine - wanted).max() <= 1e-7 * np.abs(wanted).max()  # as above


def test_a_spring_on_a_free_motion_has_no_derivative(case: Any) -> None:
    system = system_of(case, free=True)
    turn = np.zeros(6)
    turn[5] = 1.0
    found = force_derivatives(system, [zero_change(system)._replace(K=np.outer(turn, turn) * 1e3)])
    assert found.constrained.tolist() == [True]
    assert np.isnan(found.derivative).all()


def test_amplitude_of_one_order(case: Any) -> None:
    system = system_of(case)
    change = one(system, "stiffness")

    def amplitude(h: float) -> Array:
        found = periodic(moved(system, change, h), relative_speed=SPEED, tolerance=1e-12)
        return np.asarray(2 * np.abs(np.fft.fft(found.force)[:, 2]) / found.theta.size)

    found = force_derivatives(system, [change], relative_speed=SPEED, harmonic=2, tolerance=1e-11)
    assert found.value[:, 0] == pytest.approx(amplitude(0.0), rel=1e-9)  # both solved to 1e-11
    assert found.derivative[0, :, 0] == pytest.approx(difference(amplitude), rel=1e-6)  # five-point, see above


@pytest.mark.parametrize("name", ["stiffness", "variation", "B", "K"])
def test_forces_on_truncated_harmonics_count(case: Any, name: str) -> None:
    """With three harmonics kept the forces on dropped ones are large, and the derivative is that of all of them."""
    system = system_of(case)
    change = one(system, name)

    def solved(h: float) -> tuple[Response, Block, Array]:
        ready = response(moved(system, change, h))
        block = _block(ready, np.zeros(1, np.int64), np.array([SPEED]), truncation=(3, 0), tolerance=1e-13, before=None)
        return ready, block, measure(ready, block, harmonic=None).square[:, 0]

    ready, block, _ = solved(0.0)
    assert block.residual[0] > 0.01
    parts = adjoint_parts(
        ready,
        adjoint_form(ready.modal),
        block,
        measure(ready, block, harmonic=None),
        meshes=np.arange(2),
        tolerance=1e-13,
    )
    basis = basis_of(ready)
    ((_, both),) = parts
    found = gradient(ready, basis, block, both).along(ready, basis, change)[:, 0]
    wanted = difference(lambda h: solved(h)[2])
    assert np.abs(found - wanted).max() <= 1e-8 * np.abs(wanted).max()  # five-point, and 1e-13 / 1e-4 of the solution


def blocks(case: Any) -> list[tuple[Response, Any, bool]]:
    found = []
    for tones in (1, 2):
        ready = response(system_of(case, tones=tones))
        truncation = (9, 0) if tones == 1 else (8, 7, 6)
        found += [(ready, ready.kernel(truncation, shifted=shifted), shifted) for shifted in (False, True)]
    return found


def test_operator_and_its_adjoint(case: Any) -> None:
    """<A x, y> = <x, A* y> in the energy of the modes and the power of the rows, and the same of dropped rows."""
    draw = np.random.default_rng(2)
    for ready, kernel, shifted in blocks(case):
        modal, J, n, P = ready.modal, len(kernel.lattice.points), 6, 3
        frequency = draw.uniform(200, 3000, (P, J))
        if not shifted:
            frequency[:, ~kernel.lattice.points.any(axis=1)] = 0.0
        rows = balance.Batch(
            frequency=frequency,
            truncated_frequency=np.zeros((P, len(kernel.truncated))),
            frame=np.array([0.4, 1.0, 2.2]),
            error=np.zeros((2, P, J), complex),
            force=np.zeros((P, J, n), complex),
        )
        x, y = draw.normal(size=(2, P, 2, J, n))
        if not shifted:
            x[:, 1, 0], y[:, 1, 0] = 0.0, 0.0  # the mean is real
        weight = harmonic_weights(kernel)[:, None] / np.where(modal.rigid, 1.0, modal.squared)
        forward = _operator(modal, kernel, rows, x)
        backward = _operator(adjoint_form(modal), kernel, rows, y)
        left, right = (forward * weight * y).sum(axis=(1, 2, 3)), (x * weight * backward).sum(axis=(1, 2, 3))
        size = np.abs(forward * weight * y).sum(axis=(1, 2, 3))
        assert np.abs(left - right).max() <= 1e-12 * size.max()  # rounding of some thousand terms
        gap, force = draw.normal(size=(2, P, 2 * J)), draw.normal(size=(2, P, 2 * len(kernel.truncated)))
        if not shifted:
            gap[:, :, J] = 0.0
        reached = (truncated_product(kernel, gap) * force).sum(axis=2)
        assert (gap * truncated_product_adjoint(kernel, force)).sum(axis=2) == pytest.approx(reached, rel=1e-11)
        scaled = product(kernel, gap)
        assert scaled.shape == gap.shape


def _operator(modal: Any, kernel: Any, rows: balance.Batch, y: Array) -> Array:
    """D y and all that is off the diagonal."""
    w = rows.frequency[:, None, :, None]
    turned = np.stack([-y[:, 1], y[:, 0]], axis=1)
    diagonal = (modal.squared - w**2) * y + w * modal.damping * turned
    return np.asarray(diagonal + balance._coupling(modal, kernel, rows)(y))


def test_refused_input(case: Any) -> None:
    undamped = replace(case.pair(zeta=None, mesh_damping=0.0), C=np.zeros((6, 6)))
    with pytest.raises(ModelError, match="no damping"):
        force_derivatives(undamped, [])
    with pytest.raises(ModelError, match="above zero"):
        force_derivatives(system_of(case), [], relative_speed=[1.0, 0.0])
    system = system_of(case)
    parts = zero_change(system)._replace(line_frequency=np.array([0, 1.0, 0, 0, 0]))
    with pytest.raises(ModelError, match="part when it changes"):
        force_derivatives(system, [parts])
