"""Sums that share work: mesh rows of one gap, lines of one frequency, tones of one waveform."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import epicyclic
from epicyclic.questions.response.lattice import line_frequencies, product, truncated_product
from epicyclic.questions.response.response import Response, respond, response
from epicyclic.questions.response.spectra import Spectrum, torus_waveform


def ready_of(name: str) -> Response:
    return response(epicyclic.assemble(epicyclic.load(name)))


@pytest.mark.parametrize(("name", "distinct"), [("encased-differential", 16), ("ren2021", 12), ("xu2020", 16)])
@pytest.mark.parametrize("shifted", [False, True])
def test_rows_of_one_gap_add_their_forces(name: str, distinct: int, shifted: bool) -> None:
    """Sides of a plane herringbone mesh have one gap; of one with tilt each has its own."""
    ready = ready_of(name)
    kernel = ready.kernel((12,) * len(ready.lines.tones) + (6,), shifted=shifted)
    B, rng = ready.system.meshes.B, np.random.default_rng(0)
    assert len(kernel.distinct) == distinct
    for j, row in enumerate(B.T):
        owners = [i for i in kernel.distinct if np.array_equal(B[:, i], row)]
        assert len(owners) == 1 and (j not in kernel.distinct or owners == [j])  # noqa: PT018
    motion = rng.standard_normal((len(B), 3 * 2 * len(kernel.lattice.points)))
    gap = (B.T @ motion).reshape(B.shape[1], 3, -1)
    apart = B @ product(kernel, gap).reshape(B.shape[1], -1)
    together = B[:, kernel.distinct] @ product(kernel, gap[kernel.distinct], joined=True).reshape(distinct, -1)
    assert np.abs(apart - together).max() < 1e-12 * np.abs(apart).max()


@pytest.mark.parametrize("shifted", [False, True])
def test_slices_along_a_face_are_three_rows(shifted: bool) -> None:
    """The gap of a slice of rigid gears is linear along the face, so that b b^T has three terms: 1, z and z^2."""
    ready, rng = ready_of("ren2021"), np.random.default_rng(2)
    meshes = ready.system.meshes
    along = np.linspace(-0.1, 0.1, meshes.B.shape[1])
    B = np.outer(meshes.B[:, 0], np.ones_like(along)) + np.outer(rng.standard_normal(len(meshes.B)), along)
    sliced = replace(ready, system=replace(ready.system, meshes=replace(meshes, B=B)), kernels={})
    kernel = sliced.kernel((12, 0), shifted=shifted)
    gap = (B.T @ rng.standard_normal((len(B), 6 * len(kernel.lattice.points)))).reshape(len(along), 3, -1)
    apart = B @ product(kernel, gap).reshape(len(along), -1)
    together = B[:, kernel.distinct] @ product(kernel, gap[kernel.distinct], joined=True).reshape(3, -1)
    assert np.abs(apart - together).max() < 1e-12 * np.abs(apart).max()


def test_meshes_of_two_tones_are_not_joined() -> None:
    ready = ready_of("encased-differential")
    meshes = ready.system.meshes
    twice = replace(meshes, B=np.repeat(meshes.B[:, :1], meshes.B.shape[1], axis=1))
    made = replace(ready, system=replace(ready.system, meshes=twice), kernels={}).kernel((12, 12, 6), shifted=False)
    assert [axis.meshes.tolist() for axis in made.joined] in ([[0], [1]], [[1], [0]])
    assert len(made.distinct) == 2


@pytest.mark.parametrize(("name", "speeds"), [("encased-differential", (0.3, 0.7)), ("ren2021", (0.3, 1.0, 18.0))])
def test_truncated_forces_are_made_once(name: str, speeds: tuple[float, ...]) -> None:
    """The force at truncated harmonics that a solution carries is the one that its gap gives.

    So it is where some speeds of a part are done and others go on with more harmonics.
    """
    ready = ready_of(name)
    blocks = list(respond(ready, np.array(speeds), tolerance=1e-6))
    assert len(blocks) > 1
    for block in blocks:
        for solved, shifted in ((block.mesh, False), (block.shaft, True)):
            if solved is not None:
                assert solved.truncated_force is not None
                again = truncated_product(ready.kernel(block.truncation, shifted=shifted), solved.gap)
                assert np.abs(solved.truncated_force - again).max() <= 1e-12 * np.abs(again).max()
    assert name != "encased-differential" or all(block.shaft is not None for block in blocks)


def test_amplitudes_of_one_frequency_are_one_line() -> None:
    steps = np.array([3, -1, 0, 7, 1, -3, 2, -3], dtype=object)
    lines, rng = line_frequencies(steps, 1), np.random.default_rng(1)
    values = rng.standard_normal((2, 3, 8)) + 1j * rng.standard_normal((2, 3, 8))
    weight = rng.uniform(size=5)
    exact = np.zeros((2, 3, 5), complex)
    for i, step in enumerate(steps):
        exact[..., [0, 1, 2, 3, 7].index(abs(step))] += values[..., i].conj() if step < 0 else values[..., i]
    assert lines.coincident
    assert lines.merged(values) == pytest.approx(exact, rel=1e-14)
    assert lines.power(values, weight) == pytest.approx((np.abs(exact) ** 2) @ weight, rel=1e-14)
    alone = line_frequencies(steps[:4], 1)
    assert not alone.coincident
    assert alone.power(values[..., :4], weight[:4]) == pytest.approx(
        (np.abs(alone.merged(values[..., :4])) ** 2) @ weight[:4], rel=1e-14
    )


@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("tones", [2, 3])
def test_values_over_the_phases_are_the_sum_of_all_harmonics(tones: int, mirrored: bool) -> None:
    rng = np.random.default_rng(tones)
    reach = np.stack(np.meshgrid(*[np.arange(-3, 4)] * tones, indexing="ij"), axis=-1).reshape(-1, tones)
    kept = (np.count_nonzero(reach, axis=1) == 1) | (np.abs(reach).sum(axis=1) <= 4)
    leads = reach @ 10 ** np.arange(tones) >= 0
    points = reach[kept & leads] if mirrored else reach[kept]
    amplitude = rng.standard_normal((2, 1, 2, len(points))) + 1j * rng.standard_normal((2, 1, 2, len(points)))
    counts = [9, 11, 8][:tones]
    found = torus_waveform(Spectrum(amplitude=amplitude, points=points, mirrored=mirrored), counts, 4)
    phases = np.meshgrid(*(np.arange(count) / count for count in counts), indexing="ij")
    exact = amplitude @ np.exp(2j * np.pi * np.tensordot(points, np.array(phases), axes=1)).reshape(len(points), -1)
    exact = exact.reshape(found.shape)
    assert found == pytest.approx(exact.real if mirrored else exact, abs=1e-12)
