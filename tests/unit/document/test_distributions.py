"""Distributions: draws, moments and scaling against scipy.stats; their texts."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import stats

from epicyclic.document.deviations import (
    EXAMPLES,
    Distribution,
    StandardGrade,
    distribution_pattern,
    form_texts,
    read_distribution,
)
from epicyclic.errors import ModelError

U = np.linspace(0, 1, 1003)[1:-1]
TAILS = np.array([1e-12, 1e-9, 1e-6, 1 - 1e-6, 1 - 1e-9, 1 - 1e-12])
PLACES = st.floats(-1e3, 1e3)
SPREADS = st.floats(1e-3, 1e3)
SHARES = st.floats(1e-9, 1 - 1e-9)


def made(kind: str, *values: float) -> Distribution:
    return Distribution(kind=kind, values=values, text=kind)


def drawn(read: Distribution, u: object) -> np.ndarray:
    return read.quantile(np.asarray(u, float)[..., None])


def of_scipy(kind: str, values: tuple[float, ...]) -> stats.rv_continuous:
    """The same distribution of another package."""
    match kind:
        case "normal":
            return stats.norm(*values)
        case "uniform":
            return stats.uniform(values[0], values[1] - values[0])
        case "triangular":
            low, mode, high = values
            return stats.triang((mode - low) / (high - low), low, high - low)
        case _:
            mean, deviation, low, high = values
            return stats.truncnorm((low - mean) / deviation, (high - mean) / deviation, mean, deviation)


CASES = [
    ("normal", (3.0, 0.2)),
    ("normal", (0.0, 12e-6)),
    ("uniform", (-5e-6, 8e-6)),
    ("triangular", (-1.0, 0.5, 4.0)),
    ("triangular", (0.0, 0.0, 1.0)),
    ("triangular", (0.0, 1.0, 1.0)),
    ("truncated", (0.0, 12e-6, -20e-6, 30e-6)),
    ("truncated", (1.0, 1.0, 2.0, 3.0)),
    ("truncated", (1.0, 1.0, 4.0, 9.0)),  # its upper tail
    ("truncated", (1.0, 1.0, -7.0, -2.5)),  # its lower tail
    ("truncated", (0.0, 1.0, -50.0, 50.0)),
    ("truncated", (0.0, 1.0, 0.3, 0.305)),  # so narrow that it is even
]


@pytest.mark.parametrize(("kind", "values"), CASES)
def test_draws_and_moments_are_those_of_scipy(kind: str, values: tuple[float, ...]) -> None:
    read, other = made(kind, *values), of_scipy(kind, values)
    size = other.std()
    for u in (U, TAILS):
        assert_allclose(drawn(read, u), other.ppf(u), rtol=1e-9, atol=1e-7 * size)
    assert read.mean == pytest.approx(other.mean(), abs=1e-5 * size)
    assert read.std == pytest.approx(size, rel=1e-4)


@given(mean=PLACES, deviation=SPREADS, a=st.floats(-4, 4), width=st.floats(0.05, 8), u=SHARES)
def test_a_truncated_draw_lies_within_and_its_share_is_u(
    mean: float, deviation: float, a: float, width: float, u: float
) -> None:
    low, high = mean + a * deviation, mean + (a + width) * deviation
    x = float(drawn(made("truncated", mean, deviation, low, high), u))
    assert low <= x <= high
    normal = stats.norm(mean, deviation)
    share = (normal.cdf(x) - normal.cdf(low)) / (normal.cdf(high) - normal.cdf(low))
    assert share == pytest.approx(u, abs=1e-9 + 1e-11 * abs(mean) / deviation)


@given(
    kind=st.sampled_from(["normal", "uniform", "triangular", "truncated", "rayleigh", "disc"]),
    a=PLACES,
    b=SPREADS,
    c=st.floats(0, 1),
    factor=st.floats(0, 4),
    u=st.tuples(SHARES, SHARES),
)
def test_a_scaled_draw_is_the_same_draw_further_from_the_mean(
    kind: str, a: float, b: float, c: float, factor: float, u: tuple[float, float]
) -> None:
    values = {
        "normal": (a, b),
        "uniform": (a, a + b),
        "triangular": (a, a + c * b, a + b),
        "truncated": (a, b, a - c * b, a + 2 * b),
        "rayleigh": (b,),
        "disc": (b,),
    }[kind]
    read = made(kind, *values)
    at = np.array(u[: read.dimensions])
    scaled = read.scaled(factor)
    near = 1e-9 * (abs(a) + b) * max(factor, 1)
    assert abs(scaled.mean - read.mean) <= near
    assert scaled.std == pytest.approx(factor * read.std, rel=1e-4, abs=near)
    assert abs(scaled.quantile(at) - (read.mean + factor * (read.quantile(at) - read.mean))) <= 10 * near


@pytest.mark.parametrize(("kind", "size"), [("rayleigh", 5e-6), ("disc", 10e-6)])
def test_vectors_have_their_radius_and_an_even_phase(kind: str, size: float) -> None:
    read = made(kind, size)
    assert (read.dimensions, read.mean) == (2, 0j)
    x, weight = np.polynomial.legendre.leggauss(40)
    u, weight = (x + 1) / 2, weight / 2
    z = read.quantile(np.stack(np.meshgrid(u, u, indexing="ij"), axis=-1))
    both = weight[:, None] * weight
    assert abs((both * z).sum()) < 1e-12 * size
    # components of equal size that know nothing of each other: E z^2 = 0, E |z|^2 = 2 std^2
    assert abs((both * z**2).sum()) < 1e-10 * size**2
    assert (both * abs(z) ** 2).sum() == pytest.approx(2 * read.std**2, rel=1e-2 if kind == "rayleigh" else 1e-12)
    radius = abs(read.quantile(np.stack([U, np.full(U.shape, 0.3)], axis=-1)))
    if kind == "rayleigh":
        assert_allclose(radius, stats.rayleigh(scale=size).ppf(U), rtol=1e-12)
    else:
        assert_allclose((radius / (size / 2)) ** 2, U, rtol=1e-12)  # the share of the area within
    assert_allclose(np.angle(z[0]) % (2 * math.pi), 2 * math.pi * u, rtol=1e-12)


@pytest.mark.parametrize(
    ("kind", "values", "point"),
    [
        ("normal", (2.0, 0.0), 2.0),
        ("uniform", (2.0, 2.0), 2.0),
        ("triangular", (2.0, 2.0, 2.0), 2.0),
        ("truncated", (2.0, 0.0, 1.0, 3.0), 2.0),
        ("truncated", (5.0, 1.0, 2.0, 2.0), 2.0),
        ("rayleigh", (0.0,), 0.0),
        ("disc", (0.0,), 0.0),
    ],
)
def test_without_spread_every_draw_is_the_mean(kind: str, values: tuple[float, ...], point: float) -> None:
    read = made(kind, *values)
    u = np.random.default_rng(1).uniform(size=(50, read.dimensions))
    assert_allclose(read.quantile(u), point)
    assert (read.mean, read.std) == (point, 0)


def test_the_shape_of_draws_is_that_of_the_uniform_numbers() -> None:
    assert made("normal", 0.0, 1.0).quantile(np.full((4, 3, 1), 0.5)).shape == (4, 3)
    assert made("disc", 1.0).quantile(np.full((4, 3, 2), 0.5)).shape == (4, 3)
    with pytest.raises(ValueError, match="2 uniform numbers"):
        made("disc", 1.0).quantile(np.full((4, 1), 0.5))
    for factor in (-1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="factor"):
            made("disc", 1.0).scaled(factor)


@pytest.mark.parametrize("text", EXAMPLES[:6])
def test_the_ends_are_those_of_the_inverse(text: str) -> None:
    """The inverse at 0 and 1, as far as it is finite there; a vector has none."""
    read = parsed(text, vector=text.startswith(("rayleigh", "disc")))
    assert isinstance(read, Distribution)
    inverse = drawn(read, [0.0, 1.0]) if read.dimensions == 1 else np.zeros(0)
    assert_allclose(read.ends, [end for end in inverse if np.isfinite(end)])


# texts ---------------------------------------------------------------------------------------------------------------


def parsed(text: object, *, vector: bool = False) -> Distribution | StandardGrade:
    return read_distribution(text, lambda part: float(part.split()[0]), vector=vector, where="tolerance.x")


def test_every_example_and_form_fits_the_pattern_of_the_schema() -> None:
    pattern = re.compile(distribution_pattern())
    assert len(form_texts()) == 6
    for text in EXAMPLES:
        assert pattern.search(text), text
        found = parsed(text, vector=text.startswith(("rayleigh", "disc", "grade")))
        assert found.text == text
    assert pattern.search("normal(20 N/(mm um), 1 N/(mm um))")
    for text in ("normal(0)", "normal(0, 1, 2)", "disk(3 um)", "3 mm", "grade(5)", "normal(a, b)"):
        assert not pattern.search(text), text


def test_the_width_of_a_grade_is_shared_to_both_sides() -> None:
    grade = parsed("grade( IT 7 , 2.5 sigma )")
    assert isinstance(grade, StandardGrade)
    assert (grade.standard, grade.grade, grade.sigmas) == ("ISO 286-1", 7, 2.5)
    number, vector = (grade.distribution(50e-6, vector=vector) for vector in (False, True))
    assert (number.kind, vector.kind) == ("normal", "rayleigh")
    assert (number.mean, number.std, vector.std) == pytest.approx((0, 10e-6, 10e-6))


@pytest.mark.parametrize(
    ("text", "vector", "problem"),
    [
        ("truncated(0, 1, 2)", False, "3 values of 4"),
        ("truncated(0, -1, 2, 3)", False, "deviation is below zero"),
        ("truncated(0, 1, 3, 2)", False, "wrong order"),
        ("truncated(0, 1, 20, 30)", False, "leave nothing"),
        ("truncated(0, 0, 1, 2)", False, "leave nothing"),
        ("triangular(0, 3, 2)", False, "wrong order"),
        ("triangular(2, 1, 3)", False, "wrong order"),
        ("rayleigh(-1)", True, "deviation is below zero"),
        ("disc(-1)", True, "diameter is below zero"),
        ("disc(1)", False, "of a vector"),
        ("normal(0, 1)", True, "of a number"),
        ("grade(IT6)", True, "not a grade known here"),
        ("grade(IT6, 3)", True, "standard deviations"),
        ("grade(IT6, 0 sigma)", True, "standard deviations"),
        ("grade(IT6, 11 sigma)", True, "standard deviations"),
        ("grade(ISO 1328-1:1995 5, 3 sigma)", True, "edition 1995"),
        ("grade(DIN 3962 5, 3 sigma)", True, "not a grade known here"),
        ("normal(0, 1", False, "not a distribution"),
        ("x" * 200_000, False, "not a distribution"),
        (math.nan, False, "not a distribution"),
        (True, False, "not a distribution"),
        (None, False, "not a distribution"),
    ],
)
def test_other_texts_are_refused(text: object, vector: bool, problem: str) -> None:
    with pytest.raises(ModelError) as error:
        parsed(text, vector=vector)
    assert problem in error.value.problem
    assert error.value.path == "tolerance.x"
    assert error.value.allowed
    assert len(str(error.value)) < 1000
