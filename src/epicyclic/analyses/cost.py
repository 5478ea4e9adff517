"""What a run may cost: refusals that name the memory or the time it would take."""

from __future__ import annotations

from ..errors import ModelError

__all__ = ["MOST_NUMBERS", "require_memory", "require_time"]

# Numbers that a result or a run may hold at once: 1.6 GB.
MOST_NUMBERS = 200_000_000

_UNITS = (("s", 120.0), ("min", 7200.0), ("h", 172_800.0), ("days", 63_072_000.0))
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "days": 86_400.0, "years": 31_536_000.0}


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
    unit = next((unit for unit, below in _UNITS if seconds < below), "years")
    return f"{seconds / _SECONDS[unit]:.3g} {unit}"
