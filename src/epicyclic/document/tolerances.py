"""`[tolerance]`: distributions of numbers and vectors of the file, prices of grades, and correlations.

The draw is the number at the path: it takes the place of what the file states there, as an override does.

`[tolerance.correlation]` names entries whose own draws are not independent, as a Gaussian copula of normal ones.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .deviations import PHASES, VECTORS, Distribution, StandardGrade, read_distribution
from .schema import Names, collect, nearest
from .schema_fields import Probe, Unit
from .tables import TOLERANCE_TABLES, PlainTable, expand, leaves, nested, one_path
from .units import KINDS, NUMBER, BareNumber, Bounds, Quantity, bare_in, kind_words, read_quantity, split_list
from .validation import quantities_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_NUMBER = re.compile(rf"\s*{NUMBER}\s*")
_VECTORS = ("run_out", "bearing_run_out", "position", "tilt")  # kinds of deviations with x and y
_TURNING = ("run_out", "bearing_run_out")  # those that turn with the planet, so that a tooth can be marked
_SHARED = ("own", "common", "phase")
_ENTRY = '"DISTRIBUTION" or { own = "DISTRIBUTION", common = "DISTRIBUTION", phase = "random" or "marked" }'
_MOST_PRICE = 1e15


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """One entry of the drawing.

    path : of the number, as an override names it; of a vector that of its table.  own : each planet, or each mesh of a
    pair, draws for itself; of a single member its only draw.  common : one draw for all planets, added.
    phase : "random", or "marked": each planet's own draw gives its magnitude, at phase 0 of the planet's own x axis.
    unit : SI unit.  count : draws of `own`, one a planet; both halves of a member and both sides of a mesh share one.
    grades : that `[tolerance.cost]` prices, in their order.
    """

    path: str
    own: Distribution | None
    common: Distribution | None
    phase: str
    unit: str
    count: int
    grades: tuple[Grade, ...] = ()

    @property
    def vector(self) -> bool:
        """Whether a vector across the axis is drawn, not a number."""
        return any(one is not None and one.kind in VECTORS for one in (self.own, self.common))


@dataclass(frozen=True, slots=True, kw_only=True)
class Grade:
    """A grade that may be bought: its text, its distribution, which takes the place of the entry's own, its price."""

    text: str
    distribution: Distribution
    price: float


Width = Callable[[str, StandardGrade, bool], float]
"""Width [SI] of a grade at a path, of a vector or not; raises ModelError where the grade has no meaning there."""


def tolerances(document: Any, width: Width | None = None) -> tuple[Tolerance, ...]:
    """Return the entries of `[tolerance]`.

    document : a Document, or its tables (`Train.document`).  width : of the grades; `train.resolution` knows the
    sizes that they apply to.  Raises ModelError as `check_tolerance`, and for a grade without `width`.
    """
    data: Mapping[str, Any] = getattr(document, "data", document)
    return _ToleranceTable(dict(data), collect(data), width, getattr(document, "toleranced", {})).entries()


def check_tolerance(data: PlainTable, names: Names) -> Mapping[str, Unit]:
    """Return what may stand at the path of each entry of `[tolerance]`. Raises ModelError for what is wrong there.

    That is a tolerance that is no distribution, whose path is not in the model or no number, whose values are of
    another quantity than what stands there or have no unit, of a spread below zero; two entries of one number; a price
    that is none, or of a path without tolerance.
    """
    if not isinstance(data.get("tolerance"), dict):
        return {}
    reading = _ToleranceTable(data, names, lambda *_: 1.0, {})  # sizes come with the resolved train
    entries = reading.entries()
    drawn: dict[str, str] = {}
    for entry in entries:
        for path in _numbers_of(entry, names):
            if (other := drawn.setdefault(path, entry.path)) != entry.path:
                problem = f"draws what {other} draws, or what stands in its place"
                allowed = "one of the two; an empty value removes an entry of the file"
                raise ModelError(problem, path=f"tolerance.{entry.path}", allowed=allowed)
    known = [entry.path for entry in entries]
    for path, table in reading.costs.items():
        if path not in known:
            problem = f"no tolerance at this path{nearest(path, known)}"
            allowed = f"one of {', '.join(known)}" if known else "a path of [tolerance]"
            raise ModelError(problem, path=f"tolerance.cost.{path}", given=_shown(table), allowed=allowed)
    return reading.units


def still_toleranced(data: PlainTable, file: PlainTable, above: PlainTable, names: Names) -> PlainTable:
    """Return a document without the tolerances of the file whose number an override has removed or made a word.

    data : the file with overrides laid over it.  above : the overrides; a tolerance that they state stays.
    """
    stated, overriding = data.get("tolerance"), above.get("tolerance")
    if not isinstance(stated, dict):
        return data
    kept = (*TOLERANCE_TABLES, *(overriding if isinstance(overriding, dict) else ()))
    gone = {path for path in stated if path not in kept and _missing(data, path) and not _missing(file, path)}
    return data | {"tolerance": _without(stated, gone, names)} if gone else data


def _without(table: PlainTable, gone: Collection[str], names: Names) -> PlainTable:
    """Return `[tolerance]` without some entries, nor their prices and correlations."""
    kept = {path: value for path, value in table.items() if path not in gone}
    for name in TOLERANCE_TABLES:
        if isinstance(inner := kept.get(name), dict):
            kept[name] = {path: value for path, value in inner.items() if path not in gone}
    if isinstance(pairs := kept.get("correlation"), dict):
        others = {
            first: {text: value for text, value in inner.items() if one_path(text, names, first) not in gone}
            for first, inner in pairs.items()
            if isinstance(inner, dict)
        }
        kept["correlation"] = {first: inner for first, inner in (pairs | others).items() if inner != {}}
    return kept


class _ToleranceTable:
    """`[tolerance]` of one document.

    width : of the grades.  units : what may stand at the path of each entry; asked for where it is not known.
    """

    def __init__(self, data: PlainTable, names: Names, width: Width | None, units: Mapping[str, Unit]) -> None:
        table = data.get("tolerance")
        self.table: PlainTable = table if isinstance(table, dict) else {}
        self.costs: PlainTable = self.table.get("cost", {})
        if not isinstance(self.costs, dict):
            raise ModelError("not a table", path="tolerance.cost", given=self.costs, allowed="[tolerance.cost]")
        self.data, self.names, self.width = data, names, width
        self.units = dict(units)

    def entries(self) -> tuple[Tolerance, ...]:
        """Return the entries in the order of the file. Raises ModelError."""
        stated = {path: value for path, value in self.table.items() if path not in TOLERANCE_TABLES}
        asked = [path for path in stated if path not in self.units]
        found = quantities_at(self.data, asked, self.names) if asked else {}
        entries = (self._entry(path, value, found.get(path)) for path, value in stated.items())
        return tuple(
            replace(one, grades=tuple(self._priced(one))) if one.path in self.costs else one for one in entries
        )

    def _priced(self, entry: Tolerance) -> Iterator[Grade]:
        """Yield the grades of one entry. Raises ModelError."""
        where = f"tolerance.cost.{entry.path}"
        table = self.costs[entry.path]
        allowed = '{ "grade(IT6, 3 sigma)" = 40, "normal(0, 8 um)" = 25 }: distributions and their prices'
        if not isinstance(table, dict) or not table:
            raise ModelError("no grades with prices", path=where, given=table, allowed=allowed)
        for text, price in table.items():
            place = f"{where}.{text[:80]}"
            read, unit = self.distribution(text, entry.path, entry.vector, place)
            if unit and unit != entry.unit:
                raise ModelError("of another quantity than its tolerance", path=place, given=text, allowed=entry.unit)
            if isinstance(price, bool) or not isinstance(price, (int, float)) or not 0 <= price <= _MOST_PRICE:
                allowed = f"a number of 0 to {_MOST_PRICE:g}, in any one currency, without a unit"
                raise ModelError("not a price", path=place, given=price, allowed=allowed)
            yield Grade(text=read.text, distribution=read, price=float(price))

    def _entry(self, path: str, value: object, found: Probe | ModelError | None) -> Tolerance:
        """Return one entry. Raises ModelError."""
        where = f"tolerance.{path}"
        texts, phase = _texts(value, where)
        if found is not None:
            self.units[path] = self._unit(path, value, found)
        unit = self.units[path]
        # a grade, which has no word of its own for a vector, is one where a vector may stand
        words = {text.strip().partition("(")[0].strip() for text in texts.values() if isinstance(text, str)}
        vector = path.startswith("deviations.") and path.rpartition(".")[2] in _VECTORS
        vector = vector and not words.isdisjoint((*VECTORS, "grade"))
        read: dict[str, Distribution] = {}
        units: dict[str, str] = {}
        for name, text in texts.items():
            place = f"{where}.{name}" if isinstance(value, dict) else where
            read[name], units[name] = self.distribution(text, path, vector, place)
        stated = {unit for unit in units.values() if unit}
        if len(stated) > 1:
            allowed = " or ".join(KINDS[kind].unit for kind in unit.kinds.split())
            raise ModelError("mixes kinds of quantity", path=where, given=str(value), allowed=f"all in {allowed}")
        if not vector and self._is_pin(path):
            # a number is the amplitude, whose phase is 0: along the radius, where a pin hardly loads its meshes
            problem = "a pin position as a number is drawn along the radius, where it loads hardly any mesh"
            allowed = (
                f'"disc(diameter)" for a zone round the pin, or {path}.y for a tangential number, .x for a radial one'
            )
            raise ModelError(problem, path=where, given=_shown(value), allowed=allowed)
        count = _count(path, self.names, self.data) if unit.many else 1
        if "common" in read and count == 1:
            problem, allowed = "a common draw of a single one", "own alone; common is of what several planets have"
            raise ModelError(problem, path=f"{where}.common", given=texts["common"], allowed=allowed)
        if phase == "marked" and not (vector and count > 1 and path.rpartition(".")[2] in _TURNING):
            allowed = f"a vector that turns with planets, {' or '.join(_TURNING)} of planets"
            raise ModelError("no tooth to mark here", path=f"{where}.phase", given=phase, allowed=allowed)
        return Tolerance(
            path=path,
            own=read.get("own"),
            common=read.get("common"),
            phase=phase,
            unit=next(iter(stated), KINDS[unit.kinds.split()[0]].unit),
            count=count,
        )

    def _is_pin(self, path: str) -> bool:
        """Whether a path is the position of a planet on a pin; that of one on a shaft turns with it."""
        segments = path.split(".")
        if segments[0] != "deviations" or segments[-1] != "position" or segments[1] not in self.names.stages:
            return False
        stage, member = segments[1:3]
        turns = "on" in self.data["stages"][stage].get(member, {})
        return self.names.stages[stage].get(member) == "planet" and not turns

    def _unit(self, path: str, value: object, probe: Probe | ModelError) -> Unit:
        """Return what may stand at the path of an entry. Raises ModelError where it is no number of the model."""
        problem, allowed = "", "a path a number can stand at, in a table that is there"
        if not isinstance(probe, Probe):
            about = f"{probe.path}: {probe.problem}" if probe.path not in ("", path) else probe.problem
            problem = f"no such path ({about})"
        elif probe.unit is None:
            problem, allowed = "a count, no number that varies", "a quantity that varies from part to part"
        elif probe.unit.lists:
            problem, allowed = "a list, no number", "a quantity that is one number, or one per planet"
        elif (missing := _missing(self.data, path)) is not None:
            problem = f"no such path ({missing})"
        else:
            return probe.unit
        raise ModelError(problem, path=f"tolerance.{path}", given=_shown(value), allowed=allowed)

    def distribution(self, text: object, path: str, vector: bool, where: str) -> tuple[Distribution, str]:
        """Return the distribution of a text, of a grade by its width, and its SI unit, "" where it names none.

        path : of the entry.  where : of the text.  Raises ModelError.
        """
        expected, units = self.units[path], set[str]()

        def value(part: str) -> float:
            number, unit = self._value(part, expected, where, text)
            if unit:
                units.add(unit)
            return number

        read = read_distribution(text, value, vector=vector, where=where)
        kinds = tuple(expected.kinds.split())
        if len(units) > 1:
            allowed = " or ".join(KINDS[kind].unit for kind in kinds)
            raise ModelError("mixes kinds of quantity", path=where, given=text, allowed=f"all in {allowed}")
        if isinstance(read, Distribution):
            _check_bounds(read, expected, where)
            return read, next(iter(units), "")
        if "length" not in kinds:
            problem = "a grade of a length, where another quantity stands"
            raise ModelError(problem, path=where, given=text, allowed=kind_words(kinds))
        if self.width is None:
            allowed = "a distribution in numbers; the size comes with the resolved train"
            raise ModelError("the size of this grade is not known", path=where, given=text, allowed=allowed)
        try:
            return read.distribution(self.width(path, read, vector), vector=vector), ""
        except ModelError as error:
            raise ModelError(error.problem, path=where, given=text, allowed=error.allowed) from None

    def _value(self, part: str, expected: Unit, where: str, text: object) -> tuple[float, str]:
        """Return one value in SI and its SI unit, no unit of zero. Raises ModelError."""
        kinds = tuple(expected.kinds.split())
        bare = float(part) if _NUMBER.fullmatch(part) else None
        try:
            if bare is not None and bare_in(bare, kinds):
                raise BareNumber(bare, kinds, expected.likely)
            read = read_quantity(part if bare is None else bare, kinds, Bounds(), listed=True)
        except ModelError as error:
            raise ModelError(error.problem, path=where, given=text, allowed=kind_words(kinds)) from None
        if isinstance(read, Quantity):
            assert isinstance(read.value, float)
            return read.value, read.unit if read.value or bare is None else ""
        assert isinstance(read, float)
        return read, KINDS[kinds[0]].unit


# one entry -----------------------------------------------------------------------------------------------------------


def _texts(value: object, where: str) -> tuple[dict[str, object], str]:
    """Return the texts of the own and the common distribution, and the phase. Raises ModelError."""
    if not isinstance(value, dict):
        return {"own": value}, "random"
    for name, inner in value.items():
        if name not in _SHARED:
            problem = f"unknown key{nearest(name, _SHARED)}"
            raise ModelError(problem, path=f"{where}.{name}", given=inner, allowed=", ".join(_SHARED))
    texts = {name: value[name] for name in ("own", "common") if name in value}
    if not texts:
        raise ModelError("says nothing", path=where, given=_shown(value), allowed=_ENTRY)
    phase = value.get("phase", "random")
    if phase not in PHASES:
        raise ModelError("no phase of assembly", path=f"{where}.phase", given=phase, allowed=" or ".join(PHASES))
    return texts, str(phase)


def _shown(value: object) -> object:
    """Return the value of an entry for a message."""
    return value if isinstance(value, str) else repr(value)


def _check_bounds(read: Distribution, bounds: Bounds, where: str) -> None:
    """Raise ModelError for a distribution whose mean, or whose end, cannot stand at its path."""
    if read.kind in VECTORS:
        return
    for value in (float(read.mean.real), *read.ends):
        if value not in bounds:
            low, high = bounds.low, bounds.high
            limits = [f"{'above' if bounds.above else 'at least'} {low:g}"] if low is not None else []
            limits += [f"{'below' if bounds.below else 'at most'} {high:g}"] if high is not None else []
            problem = f"its mean or an end, {value:.6g} in SI, cannot stand there"
            raise ModelError(problem, path=where, given=read.text, allowed=" and ".join(limits))


def _missing(data: PlainTable, path: str) -> str | None:
    """Return what of a path is not in the file and cannot come from a tolerance alone; None where nothing is missing.

    A kind of deviation, the stiffness of a mesh and a key of a table that is there need not be given. A support, a
    bearing or a torque that is not there would be a new one.
    """
    segments = path.split(".")
    here: Any = data
    for at, name in enumerate(segments):
        inner = here.get(name) if isinstance(here, dict) else None
        if inner is None:
            free = segments[0] == "deviations" or "meshes" in segments[:3]
            last = at == len(segments) - 1 and segments[0] != "operation"
            return None if free or last else f"{'.'.join(segments[: at + 1])} is not given"
        here = inner
    if isinstance(here, str) and not re.match(r"\s*(?:[\[+\-.0-9]|inf)", here):
        return f'a word stands there, "{here[:40]}"'
    if isinstance(here, dict) and set(here) & {"deflection", "force", "file"}:
        return "a table of force stands there"
    return None


def _count(path: str, names: Names, data: PlainTable) -> int:
    """Return how many planets have a number of their own at a path where each may have one."""
    segments = path.split(".")
    if segments[0] not in ("stages", "deviations") or segments[1] not in names.stages:
        return 1
    stage, name, *rest = segments[1:]
    kinds = names.stages[stage]
    members = rest[0].split("-") if name == "meshes" else [name]
    if not any(kinds.get(member) == "planet" for member in members):
        return 1
    table = data["stages"][stage]
    angles, _ = split_list(table.get("planet_angles"))
    return len(angles) if angles else max(table.get("planets", 1), 1)


# several entries -----------------------------------------------------------------------------------------------------


def _numbers_of(entry: Tolerance, names: Names) -> list[str]:
    """Return the paths of the numbers that an entry draws; of a vector, and of half a vector, one for each form."""
    found = [path for path, _ in leaves(expand(nested(tuple(entry.path.split(".")), 1.0), names))]
    table, _, last = found[0].rpartition(".")
    if entry.vector:
        return [f"{table}.x", f"{table}.y"]
    if table.rpartition(".")[2] in _VECTORS and last in ("amplitude", "phase"):
        # an amplitude stands in place of x and y
        return [f"{table}.{last}", *([f"{table}.x", f"{table}.y"] if last == "amplitude" else [])]
    return found


# correlations ---------------------------------------------------------------------------------------------------------

# smallest eigenvalue that counts as positive: rounding of a matrix of ones is 1e-15, and a direction with a thousandth
# of a deviation (1e-6 of a variance) is a dependence, to be stated by one entry instead of two
_LEAST_EIGENVALUE = 1e-6
_FORM = '"PATH" = { "OTHER PATH" = 0.5 }, numbers between -1 and 1'


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Correlations:
    """Correlation of own draws.  paths : (m,) of the entries.  matrix : (m, m), positive definite, 1 on the diagonal.

    count : draws of each entry; the first of one belongs to the first of the others, and so on (planet by planet).
    """

    paths: tuple[str, ...]
    matrix: NDArray[np.float64]
    count: int

    def applied(self, u: NDArray[np.float64], first: Mapping[str, int]) -> NDArray[np.float64]:
        """Return uniform numbers, those of the correlated entries replaced by correlated ones.

        u : (S, d) independent, in (0, 1).  first : column of the first own draw of each path.  The uniform numbers
        become normal ones, these are mixed by the Cholesky factor of the matrix, and become uniform again.
        """
        import numpy as np
        from scipy.special import ndtr, ndtri

        mixed = np.array(u, float)
        factor = np.linalg.cholesky(self.matrix)
        for planet in range(self.count):
            columns = [first[path] + planet for path in self.paths]
            mixed[:, columns] = ndtr(ndtri(mixed[:, columns]) @ factor.T)
        return mixed


def read_correlations(table: object, entries: Mapping[str, Tolerance], names: Names) -> tuple[Correlations, ...]:
    """Return the correlated groups of `[tolerance.correlation]`, each of entries that hang together.

    entries : of `[tolerance]` by path.  Raises ModelError for a path without tolerance, for a distribution other than
    normal, for entries of differing numbers of draws, and for correlations that are not positive definite.
    """
    where = "tolerance.correlation"
    if not isinstance(table, dict):
        raise ModelError("not a table", path=where, given=repr(table), allowed=_FORM)
    pairs = _pairs(table, entries, names)
    groups: list[list[str]] = []
    for pair in pairs:
        joined = [group for group in groups if set(group) & set(pair)]
        merged = list(dict.fromkeys([path for group in joined for path in group] + list(pair)))
        groups = [group for group in groups if group not in joined] + [merged]
    return tuple(_group(group, pairs, entries) for group in groups)


def _pairs(table: PlainTable, entries: Mapping[str, Tolerance], names: Names) -> dict[tuple[str, str], float]:
    """Return the correlation of each pair of paths. Raises ModelError."""
    pairs: dict[tuple[str, str], float] = {}
    for first, inner in table.items():
        where = f"tolerance.correlation.{first}"
        if not isinstance(inner, dict) or not inner:
            raise ModelError("not a table of correlations", path=where, given=repr(inner), allowed=_FORM)
        for text, value in inner.items():
            second = one_path(text, names, f"{where}.{text[:80]}")
            _check_pair(first, second, value, entries)
            if {(first, second), (second, first)} & set(pairs):
                raise ModelError("given twice", path=f"{where}.{second}", given=value, allowed="one of the two")
            pairs[first, second] = float(value)
    return pairs


def _check_pair(first: str, second: str, value: Any, entries: Mapping[str, Tolerance]) -> None:
    """Raise ModelError for one correlation that is none."""

    def wrong(problem: str, allowed: str) -> ModelError:
        return ModelError(problem, path=f"tolerance.correlation.{first}.{second}", given=value, allowed=allowed)

    for path in (first, second):
        if path not in entries:
            raise wrong(f"no tolerance at {path}{nearest(path, entries)}", f"two of {', '.join(entries)}")
        own = entries[path].own
        if own is None or own.kind != "normal":
            raise wrong(f"the own draw of {path} is not normal", "normal distributions and grades of numbers")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1 < value < 1:
        raise wrong("not a correlation", "a number between -1 and 1")
    if first == second:
        raise wrong("of an entry with itself", "two entries")
    counts = [entries[path].count for path in (first, second)]
    if counts[0] != counts[1]:
        raise wrong(f"entries of {counts[0]} and {counts[1]} draws", "entries with the same number of draws")


def _group(paths: list[str], pairs: Mapping[tuple[str, str], float], entries: Mapping[str, Tolerance]) -> Correlations:
    """Return the correlations of one group. Raises ModelError where they are not positive definite."""
    import numpy as np

    matrix = np.eye(len(paths))
    for (first, second), value in pairs.items():
        if first in paths:
            i, j = paths.index(first), paths.index(second)
            matrix[i, j] = matrix[j, i] = value
    if (least := float(np.linalg.eigvalsh(matrix)[0])) < _LEAST_EIGENVALUE:
        given = ", ".join(f"{value:g}" for pair, value in pairs.items() if pair[0] in paths)
        problem = f"the correlations of {', '.join(paths)} are not positive definite (least eigenvalue {least:.3g})"
        allowed = "correlations that some set of random numbers can have; smaller ones"
        raise ModelError(problem, path=f"tolerance.correlation.{paths[0]}", given=given, allowed=allowed)
    return Correlations(paths=tuple(paths), matrix=matrix, count=entries[paths[0]].count)
