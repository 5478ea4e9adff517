"""What a run costs: refusals that name the memory or the time it would take, and the share of it that is done.

Depends on nothing heavy: every command imports it.
"""

from __future__ import annotations

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
