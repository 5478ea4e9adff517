"""What a run will be: the sampling plan of a tolerance study, and the memory and the time that a run would take.

A piece has `PIECE` rows whatever the number of samples, because the bits of a matrix product change with its rows.
Long scrambles fill a piece each; short ones share it.  A scramble is drawn from its own number alone, so that neither
order nor history of the pieces matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError

MOST_NUMBERS = 200_000_000
"""Numbers that a result or a run may hold at once: 1.6 GB."""
# Unit of a time in words, its seconds, and the time from which the next one is taken [s].
_UNITS = (("s", 1.0, 120.0), ("min", 60.0, 7200.0), ("h", 3600.0, 172_800.0), ("days", 86_400.0, 63_072_000.0))
_YEARS = ("years", 31_536_000.0)


def require_memory(numbers: float, *, path: str, given: object, allowed: str) -> None:
    """Refuse what would hold more numbers [8 bytes] than `MOST_NUMBERS`.

    Raises
    ------
    ModelError : it would; names the memory.
    """
    if numbers > MOST_NUMBERS:
        size = f"{8e-9 * numbers:.3g} GB, of {8e-9 * MOST_NUMBERS:.3g} GB that a run may take"
        raise ModelError(f"would need some {size}", path=path, given=given, allowed=allowed)


def require_time(seconds: float, most: float, *, path: str, given: object, allowed: str) -> None:
    """Refuse what would take more than `most` seconds.

    Raises
    ------
    ModelError : it would; names the time.
    """
    if seconds > most:
        raise ModelError(
            f"would take some {_words(seconds)}, of {_words(most)} that a run may take",
            path=path,
            given=given,
            allowed=allowed,
        )


def _words(seconds: float) -> str:
    """A time in words."""
    unit, size = next(((unit, size) for unit, size, below in _UNITS if seconds < below), _YEARS)
    return f"{seconds / size:.3g} {unit}"


class Counted(float):
    """Share done, 0..1, with the counts it comes from: whoever shows it can tell a rate.

    done, of : parts done, and all of them.
    """

    done: int
    of: int

    def __new__(cls, done: int, of: int) -> Counted:
        share = super().__new__(cls, done / of if of else 1.0)
        share.done, share.of = done, of
        return share


Array = NDArray[np.float64]
Sampler = Literal["sobol", "random"]

PIECE = 2**13
"""Rows of a piece: products and the sums over them stay in the cache, and a call of Python costs little beside them."""

# Scrambles at least: Student's t of 15 degrees of freedom is 2.13, hardly wider than the normal's 1.96.
_SCRAMBLES = 16
# Rows of a scramble at least: below, its quantiles say nothing.
_ROWS = 16
# Pieces of a block, and blocks that there are at least before one holds several: a piece takes some 0.06 s, and a task
# of Dask should take 0.5 s; so many blocks still keep workers busy and lose little when one is lost.
_BLOCK, _BLOCKS = 8, 16
# Dimensions for which scipy has direction numbers.
_MOST_DIMENSIONS = 21_201
# Resolution of scipy's Sobol sequence [bits]; half a step of it is added, because at 0 a normal has no quantile.
_SOBOL_BITS = 30
# Half a step of random doubles, in the place of 0.
_LEAST_RANDOM = 0.5**54


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplingPlan:
    """How so many samples are drawn.

    samples : number of samples, a power of two.  scrambles : independent scrambles.  rows : samples of each.
    pieces : pieces of `PIECE` rows.  blocks : of pieces that are computed and kept together.
    """

    samples: int
    scrambles: int
    rows: int
    seed: int
    sampler: Sampler

    @property
    def together(self) -> int:
        """Scrambles of one piece."""
        return min(self.scrambles, PIECE // self.rows)

    @property
    def pieces(self) -> int:
        """Number of pieces."""
        return self.scrambles // self.together

    @property
    def pieces_of_block(self) -> int:
        """Pieces of one block: a power of two, 1 while there are few."""
        return max(1, min(_BLOCK, self.pieces // _BLOCKS))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.pieces // self.pieces_of_block


def sampling_plan(samples: int, *, seed: int = 1, sampler: Sampler = "sobol") -> SamplingPlan:
    """Plan of at least so many samples, rounded up to a power of two."""
    rounded = max(_SCRAMBLES * _ROWS, 1 << (samples - 1).bit_length())
    scrambles = max(_SCRAMBLES, rounded // PIECE)
    return SamplingPlan(samples=rounded, scrambles=scrambles, rows=rounded // scrambles, seed=seed, sampler=sampler)


def piece_uniforms(plan: SamplingPlan, piece: int, dimensions: int) -> Array:
    """Uniforms of one piece, (PIECE, dimensions) in (0, 1): its scrambles one behind the other, then medians."""
    first = piece * plan.together
    u = np.full((PIECE, dimensions), 0.5)
    for position in range(plan.together):
        rows = slice(position * plan.rows, (position + 1) * plan.rows)
        u[rows] = scramble_uniforms(plan, first + position, dimensions)
    return u


def all_uniforms(plan: SamplingPlan, dimensions: int) -> Array:
    """Uniforms of all scrambles one behind the other, (samples, dimensions) in (0, 1)."""
    return np.concatenate([scramble_uniforms(plan, scramble, dimensions) for scramble in range(plan.scrambles)])


def scramble_uniforms(plan: SamplingPlan, scramble: int, dimensions: int) -> Array:
    """Uniforms of one scramble, (rows, dimensions) in (0, 1).

    Raises
    ------
    ModelError : more dimensions than the Sobol sequence has.
    """
    generator = np.random.default_rng(np.random.SeedSequence(plan.seed, spawn_key=(scramble,)))
    if plan.sampler == "random":
        return np.asarray(np.maximum(generator.random((plan.rows, dimensions)), _LEAST_RANDOM))
    if dimensions > _MOST_DIMENSIONS:
        allowed = f"at most {_MOST_DIMENSIONS} of sobol, or random"
        raise ModelError("too many numbers vary", path="sampler", given=dimensions, allowed=allowed)
    from scipy.stats import qmc  # only here: half a second

    drawn = qmc.Sobol(dimensions, scramble=True, bits=_SOBOL_BITS, seed=generator).random(plan.rows)
    return np.asarray(drawn + 0.5**_SOBOL_BITS / 2)


def sample_number(plan: SamplingPlan, piece: int) -> NDArray[np.int64]:
    """Number of every sample of a piece, (samples of the piece,), from 0: scramble * rows + row."""
    count = plan.together * plan.rows
    return piece * count + np.arange(count, dtype=np.int64)
