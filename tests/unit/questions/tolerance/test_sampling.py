"""Sampling of tolerances: sizes, independence of scrambles, uniforms that have a quantile."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtri

import epicyclic
from epicyclic.engine.plan import PIECE, Sampler, piece_uniforms, sample_number, sampling_plan, scramble_uniforms
from epicyclic.errors import ModelError


@pytest.mark.parametrize(
    ("asked", "samples", "scrambles", "rows", "pieces"),
    [
        (1, 256, 16, 16, 1),
        (8000, 8192, 16, 512, 1),
        (8193, 16384, 16, 1024, 2),
        (131072, 131072, 16, 8192, 16),
        (2**20, 2**20, 128, 8192, 128),
    ],
)
def test_plan(asked: int, samples: int, scrambles: int, rows: int, pieces: int) -> None:
    plan = sampling_plan(asked)
    assert (plan.samples, plan.scrambles, plan.rows, plan.pieces) == (samples, scrambles, rows, pieces)
    assert plan.pieces * plan.together * plan.rows == plan.samples


@pytest.mark.parametrize("sampler", ["sobol", "random"])
def test_a_piece_is_its_scrambles_whatever_was_drawn_before(sampler: Sampler) -> None:
    plan = sampling_plan(2**14, seed=5, sampler=sampler)
    second = piece_uniforms(plan, 1, 3)
    assert second.shape == (PIECE, 3)
    assert ((second > 0) & (second < 1)).all()
    expected = np.concatenate([scramble_uniforms(plan, scramble, 3) for scramble in range(8, 16)])
    assert np.array_equal(second, expected)
    assert not np.array_equal(second, piece_uniforms(plan, 0, 3))
    assert not np.array_equal(second, piece_uniforms(sampling_plan(2**14, seed=6, sampler=sampler), 1, 3))


def test_short_pieces_are_filled_with_medians() -> None:
    u = piece_uniforms(sampling_plan(1024), 0, 2)
    assert (u[1024:] == 0.5).all()
    assert not (u[:1024] == 0.5).any()


def test_numbers_of_samples_are_those_of_their_rows() -> None:
    plan = sampling_plan(2**14)
    number = sample_number(plan, 1)
    scramble, row = divmod(int(number[700]), plan.rows)
    assert np.array_equal(scramble_uniforms(plan, scramble, 2)[row], piece_uniforms(plan, 1, 2)[700])
    assert (sample_number(plan, 0)[0], number[-1]) == (0, plan.samples - 1)


def test_every_uniform_has_a_quantile() -> None:
    # a scrambled net has one point in each of 2^13 strata: 0 itself is met once in 2^30 / 2^13 dimensions
    plan = sampling_plan(2**17)
    for scramble in range(2):
        assert np.isfinite(ndtri(scramble_uniforms(plan, scramble, 50))).all()
    one = scramble_uniforms(plan, 0, 1)[:, 0]
    assert np.array_equal(np.sort(np.floor(one * PIECE)), np.arange(PIECE))
    assert (one * 2**31 % 2 == 1).all()  # between the steps of 2^-30


@pytest.mark.parametrize(
    ("options", "path"),
    [({"samples": 0}, "samples"), ({"samples": 10, "seed": -1}, "seed"), ({"samples": 1, "sampler": "lhs"}, "sampler")],
)
def test_bad_plans_are_refused(options: dict[str, object], path: str) -> None:
    with pytest.raises(ModelError) as error:
        epicyclic.tolerance("ren2021", **options)  # type: ignore[arg-type]
    assert error.value.path == path


def test_more_dimensions_than_sobol_has_are_refused() -> None:
    with pytest.raises(ModelError, match="too many numbers vary"):
        scramble_uniforms(sampling_plan(256), 0, 30_000)
    assert scramble_uniforms(sampling_plan(256, sampler="random"), 0, 30_000).shape == (16, 30_000)
