"""Deviations from nominal: the tables of the file, one field a kind, and the distributions of a toleranced number.

A kind of deviation is a field of `MemberDeviationsTable` (`deviations.MEMBER.KIND`) or of `MeshDeviationsTable`
(`deviations.meshes.A-B.KIND`, of `errors` with a name behind it). The type of the field gives its form, units and
shorthand, the description is its row in docs/reference/model-file.md.
Shorthand, normalisation, checks, error messages, JSON Schema and the page read these fields. The effect of a kind on
the train stands in `train/deviations.py`, under the same key.

A distribution of a number or vector has its text, its moments, and draws by the inverse distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, get_args

from pydantic import Field, ValidationInfo

from ..errors import ModelError
from .schema_fields import ListsUnit, SchemaTable, Unit, key
from .units import NUMBER, SMALL, PerPlanet, factor, written

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Error = Annotated[PerPlanet, Unit("length", many=True, likely=SMALL)]
Angle = Annotated[PerPlanet, Unit("angle", many=True)]
PitchLists = tuple[tuple[float, ...], ...]  # [m], one list for each planet or one for all, one entry for each tooth


# displaced features --------------------------------------------------------------------------------------------------


class DisplacementTable(SchemaTable):
    """A displaced feature: amplitude and phase, or x and y; z beside either."""

    bare_key: ClassVar[str] = "amplitude"
    amplitude: Error | None = key(None, "amplitude of the displacement")
    phase: Angle | None = key(None, "phase from the x axis of `from`; default 0")
    from_: Literal["own", "stage"] = key(
        "own", "which axis the phase counts from: the body's own x axis, or the stage's", alias="from"
    )
    x: Error | None = key(None, "displacement along x (radial)")
    y: Error | None = key(None, "displacement along y (tangential)")
    z: Error | None = key(None, "displacement along z")

    def model_post_init(self, context: Any) -> None:
        """Refuse a vector without any component, or a phase without amplitude."""
        given = {name for name in ("amplitude", "phase", "x", "y", "z") if getattr(self, name) is not None}
        if "phase" in given and "amplitude" not in given:
            raise ModelError("phase without amplitude", allowed="{amplitude, phase, from} or {x, y, z}")
        if not given:
            raise ModelError("says nothing", allowed="{amplitude, phase, from} or {x, y, z}")


class TiltTable(DisplacementTable):
    """A tilt of a body's seat: amplitude and phase of the axis it tilts about, or x and y."""

    amplitude: Angle | None = key(None, "amplitude of the tilt")
    x: Angle | None = key(None, "tilt about x (radial)")
    y: Angle | None = key(None, "tilt about y (tangential)")
    z: Angle | None = key(None, "tilt about z")


class UnbalanceTable(SchemaTable):
    """Mass times eccentricity."""

    bare_key: ClassVar[str] = "amount"
    amount: Annotated[PerPlanet, Unit("unbalance", many=True)] = key(..., "mass times eccentricity")
    phase: Angle | None = key(None, "phase from the body's own x axis; default 0")


# pitch deviations ----------------------------------------------------------------------------------------------------


class PitchUnit(ListsUnit):
    """Annotation of lists of pitch deviations, or of the name of a file that holds one."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> PitchLists:
        """Return the lists [m], one for each planet or one for all."""
        return tuple(tuple(row) for row in self.rows(value, info))

    def forms(self, kind: str) -> list[dict[str, Any]]:
        """Return the schemas of one list, and of the name of a file."""
        return [*super().forms(kind), {"type": "string", "pattern": r"\.[A-Za-z0-9]+$"}]


def check_pitch(path: str, pitch: PitchLists, teeth: int | None, planets: int) -> None:
    """Raise ModelError unless there is one deviation for each tooth, in one list or one for each planet."""
    if teeth is None:
        raise ModelError("has no teeth", path=path, allowed="a gear")
    if len(pitch) not in (1, max(planets, 1)):
        raise ModelError(f"{len(pitch)} lists", path=path, allowed=f"one list, or one for each of {planets} planets")
    for entries in pitch:
        if len(entries) != teeth:
            raise ModelError(f"{len(entries)} values", path=path, allowed=f"one for each of {teeth} teeth")


# the kinds -----------------------------------------------------------------------------------------------------------


class MemberDeviationsTable(SchemaTable):
    """Deviations of one member, one side of it, or one body."""

    run_out: DisplacementTable | None = key(None, "run-out; turns with the member")
    bearing_run_out: DisplacementTable | None = key(None, "run-out of its bearing seat; turns with the member")
    position: DisplacementTable | None = key(None, "pin position error; stands still in what carries the member")
    tilt: TiltTable | None = key(None, "misalignment; stands still in what carries the member")
    pitch: Annotated[PitchLists | None, PitchUnit("length", low=-1, high=1, lists=True, likely=SMALL)] = key(
        None,
        "measured cumulative pitch deviations, one per tooth, positive = material missing; one list, or one per "
        "planet; or the name of a CSV file",
    )
    unbalance: UnbalanceTable | None = key(None, "unbalance; turns with the member")


class ProfileErrorTable(SchemaTable):
    """Profile error, a cosine of the mesh phase."""

    bare_key: ClassVar[str] = "amplitude"
    amplitude: Error = key(..., "amplitude, along the tooth normal")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "order: multiple of the mesh frequency")
    phase: Annotated[PerPlanet | str, Unit("angle", many=True, words=("identical", "random"))] = key(
        "identical", "identical teeth, random, or given angles"
    )
    seed: Annotated[int, Field(ge=0)] | None = key(None, "seed of random phases")


class TurningErrorTable(SchemaTable):
    """Error of a mesh that turns with a member: a cosine of the angle of the member.

    The meshes of one member may so show its error each with its own amplitude, phase and sense, as published equations
    state it.
    """

    turns_with: str = key(..., "a gear of the mesh, or the carrier of the stage")
    amplitude: Error = key(..., "amplitude of the error")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "waves in one turn of the member; default 1")
    phase: Angle | None = key(None, "of the wave where the x axis of the member points as `from` says; default 0")
    from_: Literal["pitch-point", "normal"] = key(
        "pitch-point",
        "from where the member's x axis counts: towards the pitch point, or along the tooth force on the member",
        alias="from",
    )
    direction: Literal["normal", "transverse"] = key("normal", "along the tooth normal or the base tangent")
    sense: Literal["opens", "closes"] = key("opens", "what a positive value does to the gap")
    flanks: Literal["loaded", "both"] = key("loaded", "on the loaded flank, or on the far one too, from its own normal")


class MeshDeviationsTable(SchemaTable):
    """Deviations of one mesh or one side of it."""

    profile: ProfileErrorTable | None = key(None, "profile error, a harmonic of the mesh frequency")
    gap: Error | None = key(None, "error of the tooth thickness, positive opens the gap")
    errors: dict[str, TurningErrorTable] = key(
        {}, "errors [m] of this pair that turn with a member, by names of your own"
    )


class DeviationsTable(SchemaTable):
    """Deviations by full path: members `main.sun`, `main.sun.right`, `g1`; meshes `main.meshes.sun-planet[.left]`."""

    members: dict[str, MemberDeviationsTable] = key({}, "by member path")
    meshes: dict[str, MeshDeviationsTable] = key({}, "by mesh path")


Deviations = type[MemberDeviationsTable] | type[MeshDeviationsTable]


def bare_keys(table: Deviations) -> dict[str, str]:
    """Key that a bare number or text stands for, by kind: ``run_out = "20 um"`` is ``run_out.amplitude``."""
    forms = {
        name: next((form for form in get_args(field.annotation) if hasattr(form, "bare_key")), None)
        for name, field in table.model_fields.items()
    }
    return {name: form.bare_key for name, form in forms.items() if form is not None}


# distributions --------------------------------------------------------------------------------------------------------


class Form(NamedTuple):
    """A distribution: names of its values in their order, what it is in words, an example, moments and inverse.

    Of the values `LENGTHS` are not below zero and scale with the spread; the others are places.
    mean, std : of the values [SI]; of a vector those of each component.  ends : least and largest value, () where there
        are none, and of a vector.
    inverse : of the distribution function, of uniform numbers (..,) and the values; of a vector that of its radius.
    vector : whether it is one across the axis, with a uniform phase.
    """

    names: tuple[str, ...]
    words: str
    example: str
    mean: Callable[..., float]
    std: Callable[..., float]
    inverse: Callable[..., Any]
    ends: Callable[..., tuple[float, ...]] = lambda *_: ()
    vector: bool = False


LENGTHS = ("deviation", "diameter")
"""Names of values of a distribution that are lengths, not places."""

PHASES = ("random", "marked")
"""Phases of assembly of what turns with a planet."""

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

    kind : key of `FORMS`.  values : as named there [SI].  text : as written in the file.
    """

    kind: str
    values: tuple[float, ...]
    text: str

    @property
    def form(self) -> Form:
        """What is known of its kind."""
        return FORMS[self.kind]

    @property
    def dimensions(self) -> int:
        """Uniform numbers that one draw takes: 1, of a vector 2 (radius, phase)."""
        return 2 if self.form.vector else 1

    @property
    def mean(self) -> float | complex:
        """Mean [SI]; 0j of a vector."""
        return 0j if self.form.vector else self.form.mean(*self.values)

    @property
    def std(self) -> float:
        """Standard deviation [SI]; of a vector that of each component."""
        return self.form.std(*self.values)

    @property
    def ends(self) -> tuple[float, ...]:
        """Least and largest value [SI] of a number, as far as there are."""
        return self.form.ends(*self.values)

    def quantile(self, u: NDArray[np.float64]) -> NDArray[Any]:
        """Return draws by the inverse of the distribution function.

        u : uniform numbers in (0, 1), (..., dimensions).  Returns (...,) [SI], complex x + i y of a vector: its radius
        by inversion, its phase 2 pi times the second number.  Raises ValueError for another last dimension.
        """
        import numpy as np

        u = np.asarray(u, float)
        if u.shape[-1:] != (self.dimensions,):
            raise ValueError(f"{self.text} takes {self.dimensions} uniform numbers a draw, not {u.shape}")
        drawn = self.form.inverse(u[..., 0], *self.values)
        return np.asarray(drawn * np.exp(2j * math.pi * u[..., 1]) if self.form.vector else drawn)

    def scaled(self, factor: float) -> Distribution:
        """Return the same distribution with its spread times a factor >= 0 about its mean; the text stays as written.

        Raises ValueError for a factor below zero or not finite.
        """
        if not (math.isfinite(factor) and factor >= 0):
            raise ValueError(f"a factor of a spread is finite and not below zero, not {factor}")
        mean = self.mean.real
        # x -> mean + factor (x - mean), of every value that is a place
        moved = tuple(
            value * factor if name in LENGTHS else mean + factor * (value - mean)
            for name, value in zip(self.form.names, self.values, strict=True)
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
        kind, values = ("rayleigh", (deviation,)) if vector else ("normal", (0.0, deviation))
        return Distribution(kind=kind, values=values, text=self.text)


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
    if (form := FORMS.get(kind)) is None:
        raise ModelError(f"not a distribution: no '{kind[:40]}'", path=where, given=text, allowed=_ANY)
    allowed = f"{_of(vector=vector)}, {_GRADES}"
    if vector != form.vector:
        problem = "the distribution of a number, where a vector stands" if vector else "the distribution of a vector"
        more = "" if vector else "; a vector is the table of x and y: run_out, bearing_run_out, position, tilt"
        raise ModelError(problem, path=where, given=text, allowed=allowed + more)
    if len(parts) != len(form.names):
        problem = f"not a distribution: {len(parts)} value{'s' * (len(parts) != 1)} of {len(form.names)}"
        raise ModelError(problem, path=where, given=text, allowed=allowed)
    read = Distribution(kind=kind, values=tuple(value(part) for part in parts), text=text)
    _check(read, where)
    return read


def narrowed_text(text: str, share: float) -> str | None:
    """Return the text of a distribution with its spread times a share about its mean, see `Distribution.scaled`.

    Values that stay do so as they are written.  None of a grade, and of what is no distribution.
    """
    found = _CALL.fullmatch(text)
    kind, parts = (found[1], [part.strip() for part in found[2].split(",")]) if found else ("", [])
    numbers = [number for number in map(written, parts) if number is not None]
    if kind not in FORMS or len(numbers) != len(FORMS[kind].names):
        return None
    unit = next((number.unit for number in numbers if number.unit), "")
    ratios = [1.0 if number.unit in ("", unit) else factor(number.unit, unit) for number in numbers]
    values = tuple(number.values[0] * (ratio or math.nan) for number, ratio in zip(numbers, ratios, strict=True))
    narrow = Distribution(kind=kind, values=values, text=text).scaled(share).values
    kept = zip(parts, values, narrow, strict=True)
    return f"{kind}({', '.join(part if new == old else f'{new:.6g} {unit}'.rstrip() for part, old, new in kept)})"


def form_texts() -> tuple[str, ...]:
    """Return the forms of all distributions, with the names of their values."""
    return tuple(f"{kind}({', '.join(form.names)})" for kind, form in FORMS.items())


def distribution_pattern() -> str:
    """Return the pattern of the text of a distribution, for the JSON Schema; units are checked where it is read."""
    number = rf"\s*{NUMBER}[^(),]{{0,40}}(?:\([^(),]{{1,20}}\)\s*)?"
    calls = [rf"{kind}\s*\({','.join([number] * len(form.names))}\)" for kind, form in FORMS.items()]
    standard = r"(?:ISO\s*1328-1\s*:\s*2013\s+[0-9]{1,2}|IT\s*[0-9]{1,2})"
    grade = rf"grade\s*\(\s*{standard}\s*,\s*[0-9.]{{1,9}}\s*sigma\s*\)"
    return rf"^\s*(?:{'|'.join([*calls, grade])})\s*$"


def _of(*, vector: bool) -> str:
    """Return the forms of a number or of a vector, in words."""
    return ", ".join(f'"{kind}({", ".join(one.names)})"' for kind, one in FORMS.items() if one.vector == vector)


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
    names = read.form.names
    values = dict(zip(names, read.values, strict=True))

    def wrong(problem: str, allowed: str) -> ModelError:
        return ModelError(
            problem, path=where, given=read.text, allowed=f"{read.kind}({', '.join(names)}) with {allowed}"
        )

    for name in LENGTHS:
        if values.get(name, 0.0) < 0:
            raise wrong(f"its {name} is below zero", f"{name} >= 0")
    order = [name for name in ("low", "mode", "high") if name in values]
    if (places := [values[name] for name in order]) != sorted(places):
        raise wrong("its values are in the wrong order", " <= ".join(order))
    if read.kind == "truncated" and values["high"] > values["low"] and _share(*read.values) < _LEAST_SHARE:
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


def _truncated_moments(mean: float, deviation: float, low: float, high: float) -> tuple[float, float]:
    """Return mean and standard deviation of a truncated normal distribution.

    The closed form cancels where the truncation is narrow. Below a hundredth of a deviation the density is a straight
    line to 1e-5, whose moments are those of the even one, with the mean moved by its slope.
    """
    if deviation == 0 or high == low:
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

    if deviation == 0 or high == low:
        return np.full(u.shape, min(max(mean, low), high))
    a, b = (low - mean) / deviation, (high - mean) / deviation
    below = ndtr(a) + u * (ndtr(b) - ndtr(a))
    above = ndtr(-b) + (1 - u) * (ndtr(-a) - ndtr(-b))
    # a normal distribution function near 1 has lost the digits that its complement still has
    with np.errstate(divide="ignore"):
        drawn = np.where(below <= 0.5, ndtri(below), -ndtri(above))
    return np.asarray(np.clip(mean + deviation * drawn, low, high))


def _triangular(u: NDArray[np.float64], low: float, mode: float, high: float) -> NDArray[np.float64]:
    """Return draws of a triangular distribution [SI]."""
    import numpy as np

    if high == low:
        return np.full(u.shape, low)
    turn = (mode - low) / (high - low)
    rising = low + np.sqrt(u * (high - low) * (mode - low))
    falling = high - np.sqrt((1 - u) * (high - low) * (high - mode))
    return np.where(u < turn, rising, falling)


def _normal(u: NDArray[np.float64], mean: float, deviation: float) -> NDArray[np.float64]:
    """Return draws of a normal distribution [SI]."""
    from scipy.special import ndtri

    drawn: NDArray[np.float64] = mean + deviation * ndtri(u)
    return drawn


def _rayleigh(u: NDArray[np.float64], deviation: float) -> NDArray[np.float64]:
    """Return radii of vectors whose components are normal [SI]."""
    import numpy as np

    return np.asarray(deviation * np.sqrt(-2 * np.log1p(-u)))


# the distributions ---------------------------------------------------------------------------------------------------

FORMS: dict[str, Form] = {
    "normal": Form(
        ("mean", "deviation"),
        "distribution of a tolerance: mean, standard deviation",
        "normal(0, 12 um)",
        mean=lambda mean, _: mean,
        std=lambda _, deviation: deviation,
        inverse=_normal,
    ),
    "uniform": Form(
        ("low", "high"),
        "distribution of a tolerance: every value between two ends alike",
        "uniform(-5 um, 5 um)",
        mean=lambda low, high: (low + high) / 2,
        std=lambda low, high: (high - low) / math.sqrt(12),
        ends=lambda low, high: (low, high),
        inverse=lambda u, low, high: low + u * (high - low),
    ),
    "truncated": Form(
        ("mean", "deviation", "low", "high"),
        "normal distribution cut at two ends: mean, standard deviation, low, high",
        "truncated(0, 12 um, -20 um, 20 um)",
        mean=lambda *values: _truncated_moments(*values)[0],
        std=lambda *values: _truncated_moments(*values)[1],
        ends=lambda *values: values[2:],
        inverse=_truncated,
    ),
    "triangular": Form(
        ("low", "mode", "high"),
        "distribution of a tolerance: low, most frequent value, high",
        "triangular(-5 um, 0, 10 um)",
        mean=lambda *values: sum(values) / 3,
        std=lambda low, mode, high: math.sqrt(((high - low) ** 2 - (mode - low) * (high - mode)) / 18),
        ends=lambda low, _, high: (low, high),
        inverse=_triangular,
    ),
    "rayleigh": Form(
        ("deviation",),
        "length of a vector across the axis whose two components are normal with this standard deviation; its phase is"
        " uniform",
        "rayleigh(5 um)",
        mean=lambda _: 0.0,
        std=lambda deviation: deviation,
        inverse=_rayleigh,
        vector=True,
    ),
    "disc": Form(
        ("diameter",),
        "vector across the axis, every point within a circle of this diameter alike: a position tolerance of a drawing",
        "disc(10 um)",
        mean=lambda _: 0.0,
        std=lambda diameter: diameter / 4,
        inverse=lambda u, diameter: diameter / 2 * u**0.5,
        vector=True,
    ),
}

VECTORS = tuple(kind for kind, form in FORMS.items() if form.vector)

EXAMPLES = (*(form.example for form in FORMS.values()), "grade(ISO 1328-1:2013 5, 3 sigma)", "grade(IT6, 3 sigma)")
"""One text of each form, for editors."""

_ANY = f"of a number {_of(vector=False)}; of a vector {_of(vector=True)}; of a length {_GRADES}"
