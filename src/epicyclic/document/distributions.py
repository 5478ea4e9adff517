"""Distributions of a toleranced number or vector: their text, moments, and draws by the inverse distribution."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .units import NUMBER

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FORMS: dict[str, tuple[str, ...]] = {
    "normal": ("mean", "deviation"),
    "uniform": ("low", "high"),
    "truncated": ("mean", "deviation", "low", "high"),
    "triangular": ("low", "mode", "high"),
    "rayleigh": ("deviation",),
    "disc": ("diameter",),
}
"""Names of the values of each distribution, in their order."""

VECTORS = ("rayleigh", "disc")
"""Distributions of a vector across the axis, with a uniform phase."""

PHASES = ("random", "marked")
"""Phases of assembly of what turns with a planet."""

EXAMPLES = (
    "normal(0, 12 um)",
    "uniform(-5 um, 5 um)",
    "truncated(0, 12 um, -20 um, 20 um)",
    "triangular(-5 um, 0, 10 um)",
    "rayleigh(5 um)",
    "disc(10 um)",
    "grade(ISO 1328-1:2013 5, 3 sigma)",
    "grade(IT6, 3 sigma)",
)
"""One text of each form, for editors."""

_GRADES = '"grade(ISO 1328-1:2013 5, 3 sigma)" or "grade(IT6, 3 sigma)"'
_MOST_CHARACTERS = 300  # four values of a unit text each; longer ones are slips, and cost time to take apart
_CALL = re.compile(r"\s*([A-Za-z_]+)\s*\((.*)\)\s*", re.DOTALL)
_STANDARD = re.compile(r"ISO\s*1328-1\s*:\s*([0-9]{4})\s+([0-9]{1,3})|IT\s*([0-9]{1,3})")
_SIGMAS = re.compile(r"((?:[0-9]{1,3}(?:\.[0-9]{0,6})?|\.[0-9]{1,6}))\s*sigma")
_EDITION = "2013"
_SIGMA_RANGE = (0.5, 10.0)  # of a process: below 0.5 sigma a limit is no limit, beyond 10 it is a slip
# share of the normal distribution that its limits must leave: of less, the draws would be those of its far tail, which
# nobody measures (1e-6 is beyond 4.9 sigma)
_LEAST_SHARE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """Distribution of one number, or of a vector across the axis.

    kind : normal, uniform, truncated, triangular; of vectors rayleigh (each component normal) and disc (uniform in a
        disc).  values : as `FORMS` names them [SI].  text : as written in the file.
    """

    kind: str
    values: tuple[float, ...]
    text: str

    @property
    def dimensions(self) -> int:
        """Uniform numbers that one draw takes: 1, of a vector 2 (radius, phase)."""
        return 2 if self.kind in VECTORS else 1

    @property
    def mean(self) -> float | complex:
        """Mean [SI]; 0j of a vector."""
        if self.kind == "normal":
            return self.values[0]
        if self.kind == "truncated":
            return _truncated_moments(*self.values)[0]
        return 0j if self.kind in VECTORS else sum(self.values) / len(self.values)

    @property
    def std(self) -> float:
        """Standard deviation [SI]; of a vector that of each component."""
        match self.kind:
            case "normal":
                return self.values[1]
            case "uniform":
                return (self.values[1] - self.values[0]) / math.sqrt(12)
            case "truncated":
                return _truncated_moments(*self.values)[1]
            case "triangular":
                low, mode, high = self.values
                return math.sqrt(((high - low) ** 2 - (mode - low) * (high - mode)) / 18)
            case "rayleigh":
                return self.values[0]
            case _:
                return self.values[0] / 4

    def quantile(self, u: NDArray[np.float64]) -> NDArray[Any]:
        """Return draws by the inverse of the distribution function.

        u : uniform numbers in (0, 1), (..., dimensions).  Returns (...,) [SI], complex x + i y of a vector: its radius
        by inversion, its phase 2 pi times the second number.  Raises ValueError for another last dimension.
        """
        import numpy as np

        u = np.asarray(u, float)
        if u.shape[-1:] != (self.dimensions,):
            raise ValueError(f"{self.text} takes {self.dimensions} uniform numbers a draw, not {u.shape}")
        first = u[..., 0]
        if self.kind in VECTORS:
            (size,) = self.values
            radius = size * np.sqrt(-2 * np.log1p(-first)) if self.kind == "rayleigh" else size / 2 * np.sqrt(first)
            return np.asarray(radius * np.exp(2j * math.pi * u[..., 1]))
        if self.kind == "uniform":
            low, high = self.values
            return np.asarray(low + first * (high - low))
        if self.kind == "triangular":
            return _triangular(first, *self.values)
        if self.kind == "truncated":
            return _truncated(first, *self.values)
        from scipy.special import ndtri

        return np.asarray(self.values[0] + self.values[1] * ndtri(first))

    def scaled(self, factor: float) -> Distribution:
        """Return the same distribution with its spread times a factor >= 0 about its mean; the text stays as written.

        Raises ValueError for a factor below zero or not finite.
        """
        if not (math.isfinite(factor) and factor >= 0):
            raise ValueError(f"a factor of a spread is finite and not below zero, not {factor}")
        if self.kind in VECTORS:
            return replace(self, values=(self.values[0] * factor,))
        mean = self.mean
        assert isinstance(mean, float)
        # x -> mean + factor (x - mean), of every value that is a place; a deviation is a length
        names = FORMS[self.kind]
        moved = tuple(
            value * factor if name == "deviation" else mean + factor * (value - mean)
            for name, value in zip(names, self.values, strict=True)
        )
        return replace(self, values=moved)


@dataclass(frozen=True, slots=True, kw_only=True)
class StandardGrade:
    """A grade of a standard, whose width follows from the size it applies to.

    standard : "ISO 1328-1:2013" or "ISO 286-1".  grade : its number.  sigmas : the width is that many standard
    deviations to either side.  text : as written in the file.
    """

    standard: str
    grade: int
    sigmas: float
    text: str

    def distribution(self, width: float, *, vector: bool) -> Distribution:
        """Return the normal distribution within +- width/2 [SI], of a vector that of each of its components."""
        deviation = width / 2 / self.sigmas
        if vector:
            return Distribution(kind="rayleigh", values=(deviation,), text=self.text)
        return Distribution(kind="normal", values=(0.0, deviation), text=self.text)


def read_distribution(
    text: object, value: Callable[[str], float], *, vector: bool, where: str
) -> Distribution | StandardGrade:
    """Return the distribution that a text states.

    value : SI number of the text of one value; raises ModelError.  vector : that of a vector across the axis.
    where : path of the text.  Raises ModelError.
    """
    found = _CALL.fullmatch(text) if isinstance(text, str) and len(text) <= _MOST_CHARACTERS else None
    if found is None or not isinstance(text, str):
        raise ModelError("not a distribution", path=where, given=text, allowed=_ANY)
    kind, parts = found[1], [part.strip() for part in found[2].split(",")]
    if kind == "grade":
        return _grade(text, parts, where)
    names = FORMS.get(kind)
    if names is None:
        raise ModelError(f"not a distribution: no '{kind[:40]}'", path=where, given=text, allowed=_ANY)
    allowed = f"{_of(vector=vector)}, {_GRADES}"
    if vector != (kind in VECTORS):
        problem = "the distribution of a number, where a vector stands" if vector else "the distribution of a vector"
        more = "" if vector else "; a vector is the table of x and y: run_out, bearing_run_out, position, tilt"
        raise ModelError(problem, path=where, given=text, allowed=allowed + more)
    if len(parts) != len(names):
        problem = f"not a distribution: {len(parts)} value{'s' * (len(parts) != 1)} of {len(names)}"
        raise ModelError(problem, path=where, given=text, allowed=allowed)
    read = Distribution(kind=kind, values=tuple(value(part) for part in parts), text=text)
    _check(read, where)
    return read


def form_texts() -> tuple[str, ...]:
    """Return the forms of all distributions, with the names of their values."""
    return tuple(f"{kind}({', '.join(names)})" for kind, names in FORMS.items())


def distribution_pattern() -> str:
    """Return the pattern of the text of a distribution, for the JSON Schema; units are checked where it is read."""
    number = rf"\s*{NUMBER}[^(),]{{0,40}}(?:\([^(),]{{1,20}}\)\s*)?"
    calls = [rf"{kind}\s*\({','.join([number] * len(names))}\)" for kind, names in FORMS.items()]
    standard = r"(?:ISO\s*1328-1\s*:\s*2013\s+[0-9]{1,2}|IT\s*[0-9]{1,2})"
    grade = rf"grade\s*\(\s*{standard}\s*,\s*[0-9.]{{1,9}}\s*sigma\s*\)"
    return rf"^\s*(?:{'|'.join([*calls, grade])})\s*$"


def _of(*, vector: bool) -> str:
    """Return the forms of a number or of a vector, in words."""
    return ", ".join(f'"{kind}({", ".join(names)})"' for kind, names in FORMS.items() if (kind in VECTORS) == vector)


_ANY = f"of a number {_of(vector=False)}; of a vector {_of(vector=True)}; of a length {_GRADES}"


def _grade(text: str, parts: list[str], where: str) -> StandardGrade:
    """Return the grade that a text states. Raises ModelError."""
    standard = _STANDARD.fullmatch(parts[0])
    sigmas = _SIGMAS.fullmatch(parts[1]) if len(parts) == 2 else None
    if standard is None or len(parts) != 2:
        raise ModelError("not a grade known here", path=where, given=text, allowed=_GRADES)
    if standard[1] is not None and standard[1] != _EDITION:
        raise ModelError(f"edition {standard[1]} is not known", path=where, given=text, allowed=_GRADES)
    low, high = _SIGMA_RANGE
    if sigmas is None or not low <= float(sigmas[1]) <= high:
        allowed = f"{low:g} to {high:g} sigma, as in {_GRADES}"
        problem = "its limits in standard deviations are missing, or no such number"
        raise ModelError(problem, path=where, given=text, allowed=allowed)
    name, number = ("ISO 1328-1:2013", standard[2]) if standard[1] else ("ISO 286-1", standard[3])
    return StandardGrade(standard=name, grade=int(number), sigmas=float(sigmas[1]), text=text)


def _check(read: Distribution, where: str) -> None:
    """Raise ModelError for a spread below zero, ends in the wrong order, limits that leave nothing."""
    names = FORMS[read.kind]
    values = dict(zip(names, read.values, strict=True))
    form = f"{read.kind}({', '.join(names)})"

    def wrong(problem: str, allowed: str) -> ModelError:
        return ModelError(problem, path=where, given=read.text, allowed=f"{form} with {allowed}")

    for name in ("deviation", "diameter"):
        if values.get(name, 0.0) < 0:
            raise wrong(f"a {name} below zero", f"{name} >= 0")
    if read.kind == "uniform" and values["high"] < values["low"]:
        raise wrong("its ends are in the wrong order", "high >= low")
    if read.kind == "triangular" and not values["low"] <= values["mode"] <= values["high"]:
        raise wrong("its values are in the wrong order", "low <= mode <= high")
    if read.kind == "truncated":
        if values["high"] < values["low"]:
            raise wrong("its limits are in the wrong order", "high >= low")
        if _share(*read.values) < _LEAST_SHARE and values["high"] > values["low"]:
            raise wrong("its limits leave nothing of the distribution", "limits that hold more than 1e-6 of it")


# truncated normal and triangular distribution ------------------------------------------------------------------------


def _share(mean: float, deviation: float, low: float, high: float) -> float:
    """Return the share of a normal distribution between two limits."""
    if deviation == 0:
        return float(low <= mean <= high)
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if a > 0:  # in the upper tail by symmetry, where differences of numbers near 1 would cancel
        a, b = -b, -a
    return _normal_cdf(b) - _normal_cdf(a)


def _normal_cdf(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2))


def _is_point(deviation: float, low: float, high: float) -> bool:
    return deviation == 0 or high == low


def _truncated_moments(mean: float, deviation: float, low: float, high: float) -> tuple[float, float]:
    """Return mean and standard deviation of a truncated normal distribution.

    The closed form cancels where the truncation is narrow. Below a hundredth of a deviation the density is a straight
    line to 1e-5, whose moments are those of the even one, with the mean moved by its slope.
    """
    if _is_point(deviation, low, high):
        return min(max(mean, low), high), 0.0
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if b - a < 1e-2:
        middle = (a + b) / 2
        return mean + deviation * middle * (1 - (b - a) ** 2 / 12), (high - low) / math.sqrt(12)
    share = _share(mean, deviation, low, high)
    pa, pb = (math.exp(-x * x / 2) / math.sqrt(2 * math.pi) for x in (a, b))
    first = (pa - pb) / share
    second = 1 + (a * pa - b * pb) / share - first**2
    return mean + deviation * first, deviation * math.sqrt(max(second, 0.0))


def _truncated(u: NDArray[np.float64], mean: float, deviation: float, low: float, high: float) -> NDArray[np.float64]:
    """Return draws of a truncated normal distribution [SI]; each end is inverted from the tail it is nearer to."""
    import numpy as np
    from scipy.special import ndtr, ndtri

    if _is_point(deviation, low, high):
        return np.full(u.shape, min(max(mean, low), high))
    a, b = (low - mean) / deviation, (high - mean) / deviation
    below = ndtr(a) + u * (ndtr(b) - ndtr(a))
    above = ndtr(-b) + (1 - u) * (ndtr(-a) - ndtr(-b))
    # a normal distribution function near 1 has lost the digits that its complement still has
    with np.errstate(divide="ignore"):
        drawn = np.where(below <= 0.5, ndtri(below), -ndtri(above))
    clipped: NDArray[np.float64] = np.clip(mean + deviation * drawn, low, high)
    return clipped


def _triangular(u: NDArray[np.float64], low: float, mode: float, high: float) -> NDArray[np.float64]:
    """Return draws of a triangular distribution [SI]."""
    import numpy as np

    if high == low:
        return np.full(u.shape, low)
    turn = (mode - low) / (high - low)
    rising = low + np.sqrt(u * (high - low) * (mode - low))
    falling = high - np.sqrt((1 - u) * (high - low) * (high - mode))
    return np.where(u < turn, rising, falling)
