"""The job file of a study: verb, model, options, and what varies, checked and turned into points.

What a study varies: an entry of its job file to values that overrides or options of a verb take.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..document.distributions import VECTORS, Distribution
from ..document.document import Document, read, ready_drives
from ..document.schema import collect, nearest
from ..document.tables import dotted_line
from ..document.units import KINDS, Bounds, Quantity, read_quantity
from ..document.validation import quantity_at
from ..document.written_numbers import Probe, bare_in, likely_text, typed
from ..errors import ModelError
from ..input_files import read_text
from ..train.resolution import load
from ..train.tolerances import tolerances_of
from ..warning_codes import CodedText, coded
from .sampling import Sampler, SamplingPlan, scramble_uniforms

OPTIONS = "options."
"""Begin of a path that is an option of the verb."""
_RANGE = {"from", "to", "points", "scale"}
_ALLOWED_RANGE = '{ from = "1e6 N/m", to = "1e8 N/m", points = 9, scale = "log" }'
_SCALES = ("linear", "log")
# a dimension that no result could hold
_MOST_POINTS = 1_000_000
_TEXT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-zµμ°%].*?)?\s*")
# Uniform numbers keep this far from 0 and 1, where a normal distribution is infinite: half a step of Sobol's 32 bits.
_EDGE = 2.0**-33


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """One path of a job and its values.

    path : override path, or `options.` and an option of the verb.  values : in the order of the points.
    labels : (P,) float where all values are single numbers, else texts.  unit : of the numbers, as written, else SI.
    """

    path: str
    values: tuple[Any, ...]
    labels: NDArray[Any]
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Where an entry stands, and what may stand there.

    where : path in the job file.  kinds : of quantities, () where no number stands.  written : by a person in a file.
    """

    where: str
    path: str
    kinds: tuple[str, ...]
    whole: bool
    written: bool


def quantity_kinds(document: Document, path: str, folder: Path | None) -> tuple[tuple[str, ...], bool]:
    """Kinds of quantity that may stand at a path of a model, () where none may, and whether it is a count."""
    if path.startswith(OPTIONS):
        return (), False
    try:
        probe = quantity_at(document.data, path, collect(document.data), folder)
    except ModelError:
        return (), False
    assert isinstance(probe, Probe)
    return probe.kinds, bool(getattr(probe, "whole", False))


def is_range(value: object) -> bool:
    """Whether a table is a range and no table of further paths."""
    return isinstance(value, Mapping) and "from" in value and set(value) <= _RANGE


def axis_of(document: Document, folder: Path | None, where: str, path: str, given: object, written: bool) -> Variation:
    """Variation of a list of values, or of a range.

    Parameters
    ----------
    folder : of the model.  where : path in the job file, for errors.  written : numbers there must state their units.

    Raises
    ------
    ModelError : neither; an end without a unit; a value that cannot stand at the path.
    """
    kinds, whole = quantity_kinds(document, path, folder)
    place = _Place(where=where, path=path, kinds=kinds, whole=whole, written=written)
    if is_range(given):
        assert isinstance(given, Mapping)
        values = _range(place, given)
    elif isinstance(given, Sequence) and not isinstance(given, str) and given:
        values = [typed(value) if written and not path.startswith(OPTIONS) else value for value in given]
    else:
        raise ModelError("not values", path=where, given=given, allowed=f'["5 um", "10 um"], or {_ALLOWED_RANGE}')
    _check_values(document, place, values)
    labels, unit = _labels(place, values, given)
    return Variation(path=path, values=tuple(values), labels=labels, unit=unit)


def _range(place: _Place, given: Mapping[str, Any]) -> list[Any]:
    """Values of a range."""
    count = given.get("points")
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= _MOST_POINTS:
        where = f"{place.where}.points"
        raise ModelError("not a number of points", path=where, given=count, allowed=f"1 to {_MOST_POINTS}")
    shares = np.linspace(0.0, 1.0, count)
    return _between(place, given, shares)


def _between(place: _Place, given: Mapping[str, Any], shares: NDArray[np.float64]) -> list[Any]:
    """Values at shares of the way from one end of a range to the other."""
    if "to" not in given:
        raise ModelError("missing", path=f"{place.where}.to", allowed=_ALLOWED_RANGE)
    scale = given.get("scale", "linear")
    if scale not in _SCALES:
        raise ModelError("no such scale", path=f"{place.where}.scale", given=scale, allowed=" or ".join(_SCALES))
    first, unit = _end(place, "from", given["from"])
    last, other = _end(place, "to", given["to"])
    for end, number in (("from", first), ("to", last)):
        if not np.isfinite(number):
            where = f"{place.where}.{end}"
            raise ModelError("no end of a range", path=where, given=given[end], allowed="finite, or a list of values")
    if unit != other:
        raise ModelError("ends of two units", path=place.where, given=dict(given), allowed="one unit")
    if scale == "log":
        if not (first > 0 and last > 0):
            raise ModelError("a log scale to zero or below", path=place.where, given=dict(given), allowed="above 0")
        numbers = np.exp(np.log(first) + shares * (np.log(last) - np.log(first)))
    else:
        numbers = first + shares * (last - first)
    # the ends are what was written, not rounded by a logarithm
    numbers = np.where(shares == 0.0, first, np.where(shares == 1.0, last, numbers))
    found = [float(number) for number in numbers]
    counts = all(isinstance(given[end], int) for end in ("from", "to")) and all(one == round(one) for one in found)
    if place.whole or counts:
        return [round(number) for number in found]
    return [f"{number!r} {unit}" for number in found] if unit and not place.kinds else found


def _end(place: _Place, end: str, value: Any) -> tuple[float, str]:
    """Number and unit of an end of a range: SI where the quantity is known, else as written."""
    where = f"{place.where}.{end}"
    if place.kinds:
        return _number(place, value, where)
    found = _TEXT.fullmatch(value) if isinstance(value, str) else None
    if found is not None:
        return float(found[1]), found[2] or ""
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ModelError("not a number", path=where, given=value, allowed=_ALLOWED_RANGE)
    return float(value), ""


def _number(place: _Place, value: Any, where: str) -> tuple[float, str]:
    """SI number and SI unit of a value."""
    if place.written and bare_in(value, place.kinds):
        likely = likely_text(value, place.kinds, None)
        raise ModelError(f'a number without a unit: "{likely}"?', path=where, given=value)
    try:
        found = read_quantity(value, place.kinds, Bounds(inf=True))
    except ModelError as error:
        raise ModelError(error.problem, path=where, given=value, allowed=error.allowed) from None
    number, unit = (found.value, found.unit) if isinstance(found, Quantity) else (found, KINDS[place.kinds[0]].unit)
    assert isinstance(number, float)
    return number, unit


def _check_values(document: Document, place: _Place, values: Sequence[Any]) -> None:
    """Refuse a path at which none of the values can stand; a value that is wrong alone fails at its points."""
    if place.path.startswith(OPTIONS):
        return
    error: ModelError | None = None
    for value in dict.fromkeys(map(str, (values[0], values[-1], values[len(values) // 2]))):
        one = next(found for found in values if str(found) == value)
        try:
            read(document.data, {place.path: one})
            return
        except ModelError as found:
            error = error or found
    assert error is not None
    # an error elsewhere comes of the other values of the point, which may mend it
    if error.path.startswith(place.path) or place.path.startswith(error.path) or not error.path:
        raise ModelError(error.problem, path=place.where, given=values[0], allowed=error.allowed)


def _labels(place: _Place, values: Sequence[Any], given: Any) -> tuple[NDArray[Any], str]:
    """Labels of values: numbers with their unit where all are single numbers, else texts.

    The unit is the one in which all values, or both ends of a range, were written, else that of SI.
    """
    if place.kinds and not any(isinstance(value, bool) for value in values):
        with suppress(ModelError, AssertionError):
            numbers = [_number(place, value, place.where) for value in values]
            if len({unit for _, unit in numbers}) == 1:
                return _as_written(place, np.array([number for number, _ in numbers]), numbers[0][1], given)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        unit = KINDS[place.kinds[0]].unit if place.kinds else ""
        return np.array([float(value) for value in values]), unit
    if not place.kinds and (unit := _unit_of(values)):
        return np.array([float(found[1]) for value in values if (found := _TEXT.fullmatch(value))]), unit
    return np.array([_text(value) for value in values], dtype=object), ""


def _as_written(place: _Place, numbers: NDArray[np.float64], unit: str, given: Any) -> tuple[NDArray[np.float64], str]:
    """SI numbers in the unit of all that is given, without the rounding of the conversion there and back."""
    written = _unit_of([given["from"], given["to"]] if is_range(given) else given)
    if not written or written == unit:
        return numbers, unit
    size, _ = _number(place, f"1 {written}", place.where)
    return np.array([float(f"{number / size:.15g}") for number in numbers]), written


def _unit_of(values: Sequence[Any]) -> str:
    """The one unit of all texts of a number with a unit, empty where there is none."""
    found = [_TEXT.fullmatch(value) if isinstance(value, str) else None for value in values]
    units = {one[2] if one else None for one in found}
    return (units.pop() or "") if len(units) == 1 else ""


def _text(value: Any) -> str:
    """A value as text: a list whose entries have one unit as a person writes it, ``[20, 0, 0] um``."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        return str(value)
    if unit := _unit_of(value):
        return f"[{', '.join(found[1] for one in value if (found := _TEXT.fullmatch(one)))}] {unit}"
    return f"[{', '.join(map(str, value))}]"


def drawn(
    document: Document,
    folder: Path | None,
    where: str,
    path: str,
    given: object,
    u: NDArray[np.float64],
    written: bool,
    distribution: Distribution | None,
) -> list[Variation]:
    """Axes of draws: of a distribution (two of a vector), of a range, or of a list each value of which is as likely.

    Parameters
    ----------
    u : (P, 2) uniform numbers; the second is of vectors.  distribution : that the text is.  Others as of `axis_of`.

    Raises
    ------
    ModelError : none of these.
    """
    u = np.clip(u, _EDGE, 1.0 - _EDGE)
    kinds, whole = quantity_kinds(document, path, folder)
    place = _Place(where=where, path=path, kinds=kinds, whole=whole, written=written)
    if distribution is not None:
        vector = distribution.kind in VECTORS
        values = np.asarray(distribution.quantile(u if vector else u[:, :1]))
        parts = [(f"{path}.x", values.real), (f"{path}.y", values.imag)] if vector else [(path, values)]
        unit = "m" if vector and not kinds else KINDS[kinds[0]].unit if kinds else ""
        return [
            Variation(path=name, values=tuple(map(float, numbers)), labels=np.array(numbers, float), unit=unit)
            for name, numbers in parts
        ]
    if is_range(given):
        assert isinstance(given, Mapping)
        found = _between(place, given, u[:, 0])
    elif isinstance(given, Sequence) and not isinstance(given, str) and given:
        found = [given[int(number * len(given))] for number in u[:, 0]]
        found = [typed(value) if written and not path.startswith(OPTIONS) else value for value in found]
    else:
        allowed = f'"normal(0, 12 um)", {_ALLOWED_RANGE.replace(" points = 9,", "")}, or a list to choose from'
        raise ModelError("not a distribution", path=where, given=given, allowed=allowed)
    _check_values(document, place, found)
    labels, unit = _labels(place, found, given)
    return [Variation(path=path, values=tuple(found), labels=labels, unit=unit)]


_KEYS = ("verb", "model", "options", "overrides", "keep", "seed", "grid", "list", "random", "sobol")
_MAX_BYTES = 4_000_000
# of one path: a text of distribution like that of `[tolerance]`
_SAMPLERS: tuple[Sampler, ...] = ("random", "sobol")


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyJob:
    """A study, ready to run.

    verb, options : of every point.  model : tables of the model, which every verb takes, overrides of the job put in.
    overrides : these, as written.
    keep : names of variables that are kept, () for all.
    grid : axes that are crossed, a dimension each.  along : axes that vary together along `point`.
    points : length of `point`, 0 without.  warnings : what was made of the job.
    """

    verb: str
    model: Mapping[str, Any]
    options: Mapping[str, Any]
    overrides: Mapping[str, Any]
    keep: tuple[str, ...]
    grid: tuple[Variation, ...]
    along: tuple[Variation, ...]
    points: int
    seed: int
    warnings: tuple[CodedText, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each dimension of the study."""
        return (*(len(axis.values) for axis in self.grid), *((self.points,) if self.points else ()))

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of these dimensions."""
        return (*(axis.path for axis in self.grid), *(("point",) if self.points else ()))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Path -> value of every point, the last dimension first."""
        for places in product(*(range(size) for size in self.shape)):
            row = {axis.path: axis.values[place] for axis, place in zip(self.grid, places, strict=False)}
            yield row | {axis.path: axis.values[places[-1]] for axis in self.along}


def read_job(job: str | Path | Mapping[str, Any], verbs: Mapping[str, Sequence[str]]) -> StudyJob:
    """Read the job of a study.

    Parameters
    ----------
    job : a TOML file, or its tables.  verbs : name -> options of every verb.

    Raises
    ------
    ModelError : whatever is wrong, with the path in the job, what is given and what is allowed.
    """
    written = not isinstance(job, Mapping)
    table, folder = (dict(job), Path()) if isinstance(job, Mapping) else (_table(Path(job)), Path(job).parent)
    for key in table:
        if key not in _KEYS:
            raise ModelError(f"no such key{nearest(key, _KEYS)}", path=key, given=table[key], allowed=", ".join(_KEYS))
    verb, options = _verb(table, verbs)
    document, model_folder = _document(table, folder)
    overrides = dict(_flat(_section(table, "overrides")))
    if written:
        overrides = {path: typed(value) for path, value in overrides.items()}
    document = _with_overrides(document, overrides)
    seed = _whole(table, "seed", 1, low=0)
    grid = [
        axis_of(document, model_folder, f"grid.{path}", path, given, written)
        for path, given in _flat(_section(table, "grid"))
    ]
    along, points, said = _along(table, document, model_folder, written, seed)
    found = StudyJob(
        verb=verb,
        model=_portable(document, model_folder),
        options=options,
        overrides=overrides,
        keep=_kept(table),
        grid=tuple(grid),
        along=tuple(along),
        points=points,
        seed=seed,
        warnings=tuple(said),
    )
    _check(found, verbs[verb])
    return found


def _table(path: Path) -> dict[str, Any]:
    """Tables of a job file."""
    text = read_text(path, most=_MAX_BYTES, allowed="a job of a study (.toml)")
    if (line := dotted_line(text)) is not None:
        raise ModelError(f"nested too deeply (line {line})", path=str(path), allowed="tables a few levels deep")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ModelError(f"not TOML: {error}", path=str(path), allowed="a job of a study (.toml)") from None


def _section(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = table.get(key, {})
    if not isinstance(found, Mapping):
        raise ModelError("not a table", path=key, given=found, allowed=f"[{key}] with paths")
    return found


def _flat(table: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Path and entry of a table, whose paths may be in quotes or not."""
    for name, value in table.items():
        where = f"{path}.{name}" if path else str(name)
        if isinstance(value, Mapping) and value and not is_range(value) and not set(value) & {"from", "to", "points"}:
            yield from _flat(value, where)
        else:
            yield where, value


def _verb(table: Mapping[str, Any], verbs: Mapping[str, Sequence[str]]) -> tuple[str, dict[str, Any]]:
    """Verb and its options."""
    verb = table.get("verb")
    if not isinstance(verb, str) or verb.replace("-", "_") not in verbs:
        words = "missing" if verb is None else f"no such verb{nearest(verb, verbs)}"
        given = {} if verb is None else {"given": verb}
        raise ModelError(words, path="verb", allowed=", ".join(verbs), **given)
    name = verb.replace("-", "_")
    options = {key.replace("-", "_"): value for key, value in _section(table, "options").items()}
    for key, value in options.items():
        _check_option(f"options.{key}", key, value, name, verbs[name])
    return name, options


def _check_option(where: str, key: str, value: object, verb: str, known: Sequence[str]) -> None:
    if key not in known:
        problem = f"no option of {verb}{nearest(key, known)}"
        raise ModelError(problem, path=where, given=value, allowed=", ".join(known) or "none: it has no options")


def _document(table: Mapping[str, Any], folder: Path) -> tuple[Document, Path | None]:
    """The model of a job, and the folder it is in."""
    model = table.get("model")
    if model is None:
        raise ModelError("missing", path="model", allowed="a ready drive, or a model file beside the job")
    if isinstance(model, str) and model in ready_drives():
        return read(model), None
    if isinstance(model, str | Path):
        path = folder / model
        try:
            return read(path), path.parent
        except ModelError as error:
            if error.path != str(path):
                raise
            raise ModelError(error.problem, path="model", given=str(model), allowed=error.allowed) from None
    if isinstance(model, Mapping):
        return read(model), None
    raise ModelError("not a model", path="model", given=model, allowed="a ready drive, or a model file")


def _with_overrides(document: Document, overrides: Mapping[str, Any]) -> Document:
    """The model with the overrides of all points; those say their place in the job."""
    try:
        return document if not overrides else read(document.data, overrides)
    except ModelError as error:
        raise ModelError(f"overrides.{error}") from error


def _portable(document: Document, folder: Path | None) -> dict[str, Any]:
    """Tables of a model that mean the same wherever they are read: files of pitch deviations by their whole paths."""

    def moved(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: moved(one) for name, one in value.items()}
        if isinstance(value, list):
            return [moved(one) for one in value]
        if isinstance(value, str) and value.lower().endswith(".csv") and ((folder or Path()) / value).is_file():
            return str(((folder or Path()) / value).absolute())
        return value

    tables = dict(document.data)
    if "deviations" in tables:
        tables["deviations"] = moved(tables["deviations"])
    return tables


def _whole(table: Mapping[str, Any], key: str, default: int, *, low: int, where: str = "") -> int:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= 2**63:
        raise ModelError("not a whole number", path=where or key, given=value, allowed=f"{low}, {low + 1}, ...")
    return value


def _kept(table: Mapping[str, Any]) -> tuple[str, ...]:
    keep = table.get("keep", [])
    if isinstance(keep, str) or not isinstance(keep, Sequence) or not all(isinstance(name, str) for name in keep):
        raise ModelError("not names of variables", path="keep", given=keep, allowed='["system_load_sharing"]')
    return tuple(keep)


def _along(
    table: Mapping[str, Any], document: Document, folder: Path | None, written: bool, seed: int
) -> tuple[list[Variation], int, list[CodedText]]:
    """Axes that vary together along `point`, their length, and what was made of it."""
    axes = [
        axis_of(document, folder, f"list.{path}", path, given, written)
        for path, given in _flat(_section(table, "list"))
    ]
    said: list[CodedText] = []
    lengths = {f"list.{axis.path}": len(axis.values) for axis in axes}
    for key in _SAMPLERS:
        section = _section(table, key)
        if not section:
            continue
        count = _whole(section, "points", 0, low=1, where=f"{key}.points")
        if key == "sobol" and count & (count - 1):
            rounded = 1 << count.bit_length()
            said.append(coded("points-rounded", f"sobol.points = {count}: rounded up to {rounded}, a power of two"))
            count = rounded
        lengths[f"{key}.points"] = _limited(count, f"{key}.points")
        paths = dict(_flat({name: value for name, value in section.items() if name != "points"}))
        if not paths:
            raise ModelError("nothing varies", path=key, allowed='a path = "normal(0, 12 um)"')
        u = _uniform(key, count, 2 * len(paths), seed)
        laws = _distributions(document, key, paths)
        for place, (path, given) in enumerate(paths.items()):
            draws = u[:, 2 * place : 2 * place + 2]
            axes += drawn(document, folder, f"{key}.{path}", path, given, draws, written, laws.get(path))
    if len(set(lengths.values())) > 1:
        where, words = ", ".join(lengths), ", ".join(map(str, lengths.values()))
        raise ModelError("vary together, point by point", path=where, given=words, allowed="one number of points")
    return axes, next(iter(lengths.values()), 0), said


def _limited(count: int, where: str) -> int:
    if count > _MOST_POINTS:
        raise ModelError("too many points", path=where, given=count, allowed=f"at most {_MOST_POINTS}")
    return count


def _uniform(sampler: Sampler, count: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """(count, dimensions) uniform numbers, the same for the same seed; two of a path, the second of vectors."""
    plan = SamplingPlan(samples=count, scrambles=1, rows=count, seed=seed, sampler=sampler)
    return scramble_uniforms(plan, 0, dimensions)


def _distributions(document: Document, key: str, paths: Mapping[str, Any]) -> dict[str, Distribution]:
    """Path -> distribution of the texts, read as a `[tolerance]` of the model."""
    texts = {path: value for path, value in paths.items() if isinstance(value, str) and not path.startswith(OPTIONS)}
    if not texts:
        return {}
    try:
        train = load({**document.data, "tolerance": texts})
        found = tolerances_of(train)
    except ModelError as error:
        path = error.path.replace("tolerance.", f"{key}.", 1)
        given = {"given": error.given} if path != error.path else {}
        raise ModelError(error.problem, path=path, allowed=error.allowed, **given) from error
    # one draw a path: all planets take the same
    return {entry.path: entry.own for entry in found if entry.own is not None}


def _check(job: StudyJob, known: Sequence[str]) -> None:
    """Refuse a study without points, with too many, or in which a path varies twice."""
    axes = [*job.grid, *job.along]
    if not axes:
        raise ModelError("nothing varies", path="grid, list, random, sobol", allowed='[grid] with "PATH" = [...]')
    paths = [axis.path for axis in axes]
    for path in paths:
        if paths.count(path) > 1 or path in job.overrides:
            raise ModelError("stated twice", path=path, allowed="once in the job")
        if path.startswith(OPTIONS):
            key = path.removeprefix(OPTIONS).replace("-", "_")
            _check_option(path, key, "...", job.verb, known)
            if key in job.options:
                raise ModelError("stated twice", path=path, allowed="once in the job")
    _limited(prod(job.shape), "grid, list, random, sobol")
