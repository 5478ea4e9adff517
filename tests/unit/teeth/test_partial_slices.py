"""Parts of slices: what a part of the face feels, the positive compliance, and no saw in the mesh stiffness."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from epicyclic.teeth.compliance import face_coupling
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.teeth.segments import CELLS, between_parts, face_parts, part_weights

Build = Callable[..., ContactPair]


def test_the_mean_over_a_part_of_a_parabola() -> None:
    count = 12
    edge = np.arange(count + 1.0)
    means = np.diff(edge**3 / 3 - 2 * edge**2) - 5.0  # of x^2 - 4 x - 5
    # away from the ends, where the slope of a tooth vanishes and that of a parabola does not
    start, end = np.array([1.3, 2.0, 3.25, 6.5, 4.999999]), np.array([9.8, 3.0, 3.5, 6.5 + 1e-12, 5.000001])
    found = part_weights(0.5 * (start + end), end - start, count) @ means
    exact = ((end**3 - start**3) / 3 - 2 * (end**2 - start**2)) / (end - start) - 5.0
    exact[3] = 6.5**2 - 4 * 6.5 - 5.0  # the difference quotient of a point would round
    assert found == pytest.approx(exact, rel=1e-6, abs=1e-8)
    assert part_weights(np.array([5.5, 7.0]), np.array([1.0, 2.0]), count).tolist() == [
        [float(i == 5) for i in range(count)],
        [0.5 * (i in (6, 7)) for i in range(count)],
    ]


def test_parts_of_the_face_couple_as_those_cut_finely() -> None:
    """Parts of 20 and of 40 cells, beside the same parts as whole cells of a division of 320."""
    width, decay = 40e-3, 6e-3

    def coupling(count: int) -> np.ndarray:
        middle = ((np.arange(count) + 0.5) / count - 0.5) * width
        return face_coupling(middle, width, decay, np.full(count, width / count))

    start, end = np.array([0.0, 7.375, 12.0, 7.625]), np.array([0.25, 8.0, 12.125, 11.5])

    def parts(count: int) -> np.ndarray:
        times = count / 20
        weight = part_weights(0.5 * times * (start + end), times * (end - start), count)
        result: np.ndarray = weight @ coupling(count) @ weight.T
        return result

    found, exact = parts(20), parts(320)
    # what stays is the cusp of a load within its own cell, a third of a decay length wide
    assert np.abs(found - exact).max() < 0.1 * exact.max()
    apart = np.ix_([0, 2], [1, 3])
    # cells of a third of a decay length; where an end of the face is near, its slope does not vanish
    assert found[apart] == pytest.approx(exact[apart], rel=2e-2)
    assert parts(40)[apart] == pytest.approx(exact[apart], rel=5e-3)
    assert np.linalg.eigvalsh(found).min() > 0


def matrices(coupling: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Coupling between parts of weights (n, C) as a product of matrices."""
    result: np.ndarray = weight @ coupling @ weight.T
    return result


def test_parts_couple_as_by_the_whole_product() -> None:
    """Whole slices, cut ones and none, beside W C W' of the dense weights of all parts."""
    slices, random = 6, np.random.default_rng(3)
    cells = slices * CELLS
    full = random.normal(size=(cells, cells))
    coupling = full @ full.T
    place = np.array([[0, 1, 2, 2, 5], [1, 2, 3, 4, 5], [5, 0, 3, 4, 1]])
    start, end = np.zeros(place.shape), np.full(place.shape, float(CELLS))
    start[0, 0], end[0, 3], end[2, 0], start[2, 3] = 1.25, 0.5, 3.999, 2.0
    end[2, 4] = 0.0  # padding
    middle, length = CELLS * place + 0.5 * (start + end), end - start
    found = list(between_parts(coupling, face_parts(slices, place, middle, length)))
    for t in range(3):
        there = length[t] > 0
        weight = part_weights(middle[t, there], length[t, there], cells)
        assert found[t][np.ix_(there, there)] == pytest.approx(matrices(coupling, weight), rel=1e-12, abs=1e-12)


def test_slices_leave_no_saw_in_the_stiffness(pair_of: Build) -> None:
    """With a whole overlap ratio a slice passes an end of the path K times in a mesh cycle: order K is the saw."""
    plane = pair_of(helix=15.0).plane
    width = 1 / abs(plane.per_pitch)
    phases = np.arange(160) / 160

    def order_20(slices: int) -> complex:
        tangent = loaded_contact(pair_of(helix=15.0, width=width, slices=slices), [8e3], phases).tangent[0]
        return complex(2 * np.fft.rfft(tangent)[20] / tangent.sum())

    # the order itself is 1.4e-4 of the mean; slices coupled as whole ones added 5e-4
    assert abs(order_20(20) - order_20(80)) < 4e-5
