"""Log of a resolution: every resolved value with its origin, every warning; and comparison of numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from ..errors import ModelError
from ..train.train import Derived
from ..warning_codes import CodedText

__all__ = ["NAN", "Number", "ResolutionLog", "per_branch", "same", "turns_of"]

Number = Fraction | float
NAN = float("nan")
EXACT_ANGLE = 1e-12  # [turns] an angle this near to a fraction of few digits is that fraction


@dataclass(slots=True, kw_only=True)
class ResolutionLog:
    """Collects resolved values, in order, and warnings.

    assumed : path -> reason, of the file.  overridden : full paths that overrides set.
    """

    assumed: Mapping[str, str]
    overridden: frozenset[str] = frozenset()
    values: dict[str, Derived] = field(default_factory=dict)
    warnings: list[CodedText] = field(default_factory=list)

    def note(self, path: str, value: object, unit: str = "", origin: str = "given") -> None:
        """Record one value; `given` becomes `set` by an override of the path, `assumed` by the file's `assumed`."""
        self.values[path] = Derived(path=path, value=value, unit=unit, origin=self.origin(path, origin))

    def origin(self, path: str, origin: str = "given") -> str:
        """Where a value at this path comes from."""
        if origin != "given":
            return origin
        if any(path == p or path.startswith(f"{p}.") for p in self.overridden):
            return "set"
        return "assumed" if path in self.assumed else "given"

    def warn(self, text: CodedText) -> None:
        """Record a warning once."""
        if text not in self.warnings:
            self.warnings.append(text)


def per_branch(value: float | Sequence[float] | None, count: int, path: str) -> tuple[float, ...]:
    """One value per branch, (count,); a single value holds for all, None is 0.

    Raises
    ------
    ModelError : a list of another length.
    """
    if value is None:
        return (0.0,) * count
    if isinstance(value, (int, float)):
        return (float(value),) * count
    if len(value) != count:
        where = f"one value, or {count}, one per planet" if count > 1 else "one value: it is no planet"
        raise ModelError(f"has {len(value)} values", path=path, given=list(value), allowed=where)
    return tuple(float(entry) for entry in value)


def same(a: float, b: float, tolerance: float = 1e-9) -> bool:
    """Whether two values are equal to a relative tolerance [1]: one value computed twice."""
    return math.isclose(a, b, rel_tol=tolerance, abs_tol=1e-15)


def turns_of(angle: float) -> Number:
    """An angle [rad] in turns, as a Fraction where it is a round number of degrees."""
    turns = angle / math.tau
    exact = Fraction(turns * 360).limit_denominator(10**6) / 360
    return exact if abs(float(exact) - turns) < EXACT_ANGLE else turns
