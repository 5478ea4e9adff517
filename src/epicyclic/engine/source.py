"""Sources of a verb or study (drive, file, dict, Train, System), loaded as far as needed; and the job file of a study.

What varies is an entry of the job file: a list of values, a range, or a distribution that is drawn from.  It becomes an
`StudyAxis`: the values that an override of the model or an option of the verb takes, place by place.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from math import prod
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..document.deviations import VECTORS, Distribution
from ..document.document import Document, read, ready_drives
from ..document.schema import collect, nearest
from ..document.tables import dotted_line, keyed
from ..document.units import KINDS, BareNumber, Bounds, Quantity, bare_in, read_quantity, typed, written
from ..document.validation import quantity_at
from ..errors import ModelError
from ..system.system import System
from ..train.resolution import load, tolerances_of
from ..train.train import Train
from ..user_input import read_text
from ..warning_codes import CodedText, coded
from .plan import Sampler, SamplingPlan, scramble_uniforms

Source = str | Path | Mapping[str, Any] | Train | System
"""Name of a ready drive, path of a model file, dict of a model, or a Train or System made from one."""
Overrides = Mapping[str, Any]
"""Path in the model file -> value in its place."""


def train_of(source: Source, *, overrides: Overrides | None = None) -> Train:
    """Resolved Train of a source; a Train is returned as it is.

    Raises
    ------
    ModelError : a wrong model, a System, or overrides of a Train.
    """
    if isinstance(source, System):
        raise ModelError("a System has no drawing left: give the model file or the Train", path="source")
    if not isinstance(source, Train):
        return load(source, overrides=overrides)
    if overrides:
        raise ModelError("overrides apply to a model file, not to a Train that is loaded already", path="overrides")
    return source


def system_of(source: Source, *, overrides: Overrides | None = None) -> System:
    """Assembled System of a source; a System is returned as it is.

    Raises
    ------
    ModelError : a wrong model, or overrides of a Train or System.
    """
    from ..system.assembly import assemble  # only here: `check` and others need no System

    if not isinstance(source, System):
        return assemble(train_of(source, overrides=overrides))
    if overrides:
        raise ModelError("overrides apply to a model file, not to a System that is assembled already", path="overrides")
    return source


@dataclass(frozen=True)
class Drive:
    """A source of a verb with its overrides, loaded as far as it is asked for, and once."""

    source: Source
    overrides: Overrides | None = None

    @cached_property
    def train(self) -> Train:
        """The resolved Train; errors as of `train_of`."""
        return train_of(self.source, overrides=self.overrides)

    @cached_property
    def system(self) -> System:
        """The assembled System; errors as of `system_of`."""
        if isinstance(self.source, System):
            return system_of(self.source, overrides=self.overrides)
        return system_of(self.train)

    def changed(self, changes: Overrides) -> Drive:
        """The same model with further overrides."""
        model = dict(self.source.document) if isinstance(self.source, Train) else self.source
        return Drive(model, {**(self.overrides or {}), **changes})

    @property
    def drawing(self) -> Train | None:
        """The Train; None where the source is assembled already."""
        return None if isinstance(self.source, System) else self.train


class Duty(NamedTuple):
    """Load cases of one drawing.

    cases : name of each -> its drive, and its share of the time [1].  document : of the model, of no case.
    """

    cases: Mapping[str, tuple[Drive, float]]
    document: Mapping[str, Any]


Entry = TypeVar("Entry")
OPTIONS = "options."
"""Begin of a path that is an option of the verb."""
_KEYS = ("verb", "model", "options", "overrides", "keep", "seed", "grid", "list", "random", "sobol")
_SAMPLERS: tuple[Sampler, ...] = ("random", "sobol")
_RANGE = {"from", "to", "points", "scale"}
_ALLOWED_RANGE = '{ from = "1e6 N/m", to = "1e8 N/m", points = 9, scale = "log" }'
_SCALES = ("linear", "log")
_MAX_BYTES = 4_000_000
# a dimension that no result could hold
_MOST_POINTS = 1_000_000
# Uniform numbers keep this far from 0 and 1, where a normal distribution is infinite; Sobol's keep half a step of 30
# bits by themselves.
_EDGE = 2.0**-33


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyAxis:
    """One dimension of a study: a named list of labelled changes.

    name : of the dimension.  changes : (P,) path -> value, laid over the model at each place; a path is one of the
    model, or `options.` and an option of the verb.  labels : coordinates along it, name -> (P,) and attributes.
    """

    name: str
    changes: tuple[Mapping[str, Any], ...]
    labels: Mapping[str, tuple[NDArray[Any], Mapping[str, str]]]

    @classmethod
    def of_path(cls, path: str, values: Sequence[Any], labels: NDArray[Any], unit: str) -> StudyAxis:
        """Values of one path.

        labels : (P,) float where all values are single numbers, else texts.  unit : of the numbers.
        """
        of = "option of the verb" if path.startswith(OPTIONS) else "value in the model file"
        label = labels, {"units": unit, "long_name": f"{path}, {of}"}
        return cls(name=path, changes=tuple({path: value} for value in values), labels={path: label})

    @classmethod
    def together(cls, name: str, axes: Sequence[StudyAxis]) -> StudyAxis:
        """Axes of one length as one, whose places are counted."""
        changes = tuple(merged(at) for at in zip(*(axis.changes for axis in axes), strict=True))
        return cls(
            name=name,
            changes=changes,
            labels=merged(({name: (np.arange(len(changes)), {})}, *(axis.labels for axis in axes))),
        )


def merged(parts: Iterable[Mapping[str, Entry]]) -> dict[str, Entry]:
    """Tables of different paths as one."""
    return {path: value for part in parts for path, value in part.items()}


class StudyJob(NamedTuple):
    """A study, ready to run.

    verb, options : of every point.  model : tables of the model, which every verb takes, overrides of the job put in.
    overrides : these, as written.  keep : names of variables that are kept, () for all.
    axes : of the grid, which are crossed, and `point`, of what varies together.  warnings : what was made of the job.
    """

    verb: str
    model: Mapping[str, Any]
    options: Mapping[str, Any]
    overrides: Mapping[str, Any]
    keep: tuple[str, ...]
    axes: tuple[StudyAxis, ...]
    seed: int
    warnings: tuple[CodedText, ...]


# --- the job ---------------------------------------------------------------------------------------------------------


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
    document = _document(table, folder)
    overrides = dict(_flat(_section(table, "overrides")))
    if written:
        overrides = {path: typed(value) for path, value in overrides.items()}
    if overrides:
        try:
            document = read(document.data, overrides)
        except ModelError as error:
            raise ModelError(f"overrides.{error}") from error
    entry = partial(_entry, document, written)
    seed = _whole(table, "seed", 1, low=0)
    grid = [_axis(entry("grid", path, value)) for path, value in _flat(_section(table, "grid"))]
    along, said = _along(table, document, entry, seed)
    _check([*grid, *along], options, overrides, verb, verbs[verb])
    axes = (*grid, *((StudyAxis.together("point", along),) if along else ()))
    _limited(prod(len(axis.changes) for axis in axes), "grid, list, random, sobol")
    keep = table.get("keep", [])
    if isinstance(keep, str) or not isinstance(keep, Sequence) or not all(isinstance(name, str) for name in keep):
        raise ModelError("not names of variables", path="keep", given=keep, allowed='["system_load_sharing"]')
    return StudyJob(
        verb=verb,
        model=dict(document.data),
        options=options,
        overrides=overrides,
        keep=tuple(keep),
        axes=axes,
        seed=seed,
        warnings=tuple(said),
    )


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
    section = table.get(key, {})
    if not isinstance(section, Mapping):
        raise ModelError("not a table", path=key, given=section, allowed=f"[{key}] with paths")
    return section


def _flat(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Path and entry of a table, whose paths may be in quotes or not; a range is one entry."""
    entries = keyed(table, ends=lambda value: not value or bool(set(value) & {"from", "to", "points"}))
    return ((".".join(map(str, keys)), value) for keys, value in entries)


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


def _document(table: Mapping[str, Any], folder: Path) -> Document:
    """The model of a job; a file that it names lies in the folder of the job."""
    model = table.get("model")
    if model is None:
        raise ModelError("missing", path="model", allowed="a ready drive, or a model file beside the job")
    if isinstance(model, str) and model in ready_drives():
        return read(model)
    if isinstance(model, str | Path):
        path = folder / model
        try:
            return read(path)
        except ModelError as error:
            if error.path != str(path):
                raise
            raise ModelError(error.problem, path="model", given=str(model), allowed=error.allowed) from None
    if isinstance(model, Mapping):
        return read(model)
    raise ModelError("not a model", path="model", given=model, allowed="a ready drive, or a model file")


def _whole(table: Mapping[str, Any], key: str, default: int, *, low: int, where: str = "") -> int:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= 2**63:
        raise ModelError("not a whole number", path=where or key, given=value, allowed=f"{low}, {low + 1}, ...")
    return value


def _along(
    table: Mapping[str, Any], document: Document, entry: Callable[[str, str, Any], _Entry], seed: int
) -> tuple[list[StudyAxis], list[CodedText]]:
    """Axes that vary together along `point`, and what was made of its length."""
    axes = [_axis(entry("list", path, value)) for path, value in _flat(_section(table, "list"))]
    said: list[CodedText] = []
    lengths = {f"list.{axis.name}": len(axis.changes) for axis in axes}
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
        # two uniform numbers of every path, the second of vectors; the same for the same seed
        plan = SamplingPlan(samples=count, scrambles=1, rows=count, seed=seed, sampler=key)
        u = np.clip(scramble_uniforms(plan, 0, 2 * len(paths)), _EDGE, 1.0 - _EDGE)
        laws = _distributions(document, key, paths)
        for index, (path, value) in enumerate(paths.items()):
            drawn, columns = entry(key, path, value), u[:, 2 * index : 2 * index + 2]
            axes += _sampled(drawn, columns, laws[path]) if path in laws else [_axis(drawn, columns[:, 0])]
    if len(set(lengths.values())) > 1:
        where, counts = ", ".join(lengths), ", ".join(map(str, lengths.values()))
        raise ModelError("vary together, point by point", path=where, given=counts, allowed="one number of points")
    return axes, said


def _limited(count: int, where: str) -> int:
    if count > _MOST_POINTS:
        raise ModelError("too many points", path=where, given=count, allowed=f"at most {_MOST_POINTS}")
    return count


def _distributions(document: Document, key: str, paths: Mapping[str, Any]) -> dict[str, Distribution]:
    """Path -> distribution of the texts, read as a `[tolerance]` of the model."""
    texts = {path: value for path, value in paths.items() if isinstance(value, str) and not path.startswith(OPTIONS)}
    if not texts:
        return {}
    try:
        tolerances = tolerances_of(load({**document.data, "tolerance": texts}))
    except ModelError as error:
        path = error.path.replace("tolerance.", f"{key}.", 1)
        given = {"given": error.given} if path != error.path else {}
        raise ModelError(error.problem, path=path, allowed=error.allowed, **given) from error
    # one draw a path: all planets take the same
    return {entry.path: entry.own for entry in tolerances if entry.own is not None}


def _check(
    axes: Sequence[StudyAxis], options: Mapping[str, Any], overrides: Overrides, verb: str, known: Sequence[str]
) -> None:
    """Refuse a study in which nothing varies, or a path twice.

    axes : of one path each.  options, overrides : of every point.  known : options of the verb.
    """
    if not axes:
        raise ModelError("nothing varies", path="grid, list, random, sobol", allowed='[grid] with "PATH" = [...]')
    paths = [axis.name for axis in axes]
    for path in paths:
        if paths.count(path) > 1 or path in overrides:
            raise ModelError("stated twice", path=path, allowed="once in the job")
        if path.startswith(OPTIONS):
            key = path.removeprefix(OPTIONS).replace("-", "_")
            _check_option(path, key, "...", verb, known)
            if key in options:
                raise ModelError("stated twice", path=path, allowed="once in the job")


# --- its entries -----------------------------------------------------------------------------------------------------


class _Entry(NamedTuple):
    """What a job says of one path, and what may stand there.

    document : the model.  written : by a person in a file, so that numbers must state their units.
    where : path in the job file.  value : list, range or text there.  kinds : of quantities, () where no number
    stands.  whole : whether it is a count.
    """

    document: Document
    written: bool
    where: str
    path: str
    value: Any
    kinds: tuple[str, ...]
    whole: bool


def _entry(document: Document, written: bool, section: str, path: str, value: object) -> _Entry:
    """The entry of a path in a section of the job."""
    kinds: tuple[str, ...] = ()
    whole = False
    if not path.startswith(OPTIONS):
        with suppress(ModelError):
            probe = quantity_at(document.data, path, collect(document.data))
            kinds, whole = probe.kinds, probe.unit is None
    where = f"{section}.{path}"
    return _Entry(document=document, written=written, where=where, path=path, value=value, kinds=kinds, whole=whole)


def _is_range(value: object) -> bool:
    """Whether a table is a range and no table of further paths."""
    return isinstance(value, Mapping) and "from" in value and set(value) <= _RANGE


def _axis(entry: _Entry, u: NDArray[np.float64] | None = None) -> StudyAxis:
    """Axis of a list of values or of a range; u : (P,) uniform numbers to draw from it, each value of a list as likely.

    Raises
    ------
    ModelError : neither; an end without a unit; a value that cannot stand at the path.
    """
    if _is_range(entry.value):
        if u is None:
            count = entry.value.get("points")
            if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= _MOST_POINTS:
                where = f"{entry.where}.points"
                raise ModelError("not a number of points", path=where, given=count, allowed=f"1 to {_MOST_POINTS}")
            u = np.linspace(0.0, 1.0, count)
        return _with_values(entry, _between(entry, u))
    if isinstance(entry.value, Sequence) and not isinstance(entry.value, str) and entry.value:
        values = list(entry.value) if u is None else [entry.value[int(number * len(entry.value))] for number in u]
        as_typed = entry.written and not entry.path.startswith(OPTIONS)
        return _with_values(entry, [typed(value) for value in values] if as_typed else values)
    problem, allowed = "not values", f'["5 um", "10 um"], or {_ALLOWED_RANGE}'
    if u is not None:
        problem, ends = "not a distribution", _ALLOWED_RANGE.replace(" points = 9,", "")
        allowed = f'"normal(0, 12 um)", {ends}, or a list to choose from'
    raise ModelError(problem, path=entry.where, given=entry.value, allowed=allowed)


def _sampled(entry: _Entry, u: NDArray[np.float64], law: Distribution) -> list[StudyAxis]:
    """Axes drawn from a distribution, two of a vector; u : (P, 2) uniform numbers, the second of vectors."""
    vector = law.kind in VECTORS
    values = np.asarray(law.quantile(u if vector else u[:, :1]))
    parts = [(f"{entry.path}.x", values.real), (f"{entry.path}.y", values.imag)] if vector else [(entry.path, values)]
    unit = KINDS[entry.kinds[0]].unit if entry.kinds else ""
    if vector and not entry.kinds:
        unit = "m"
    return [StudyAxis.of_path(path, numbers.tolist(), np.array(numbers, float), unit) for path, numbers in parts]


def _with_values(entry: _Entry, values: Sequence[Any]) -> StudyAxis:
    """Axis of values of an entry, with their labels.

    Raises
    ------
    ModelError : the first, last and middle one cannot stand at the path; a value wrong alone fails at its points.
    """
    first_error: ModelError | None = None
    probes = {str(value): value for value in (values[0], values[-1], values[len(values) // 2])}
    for value in () if entry.path.startswith(OPTIONS) else probes.values():
        try:
            read(entry.document.data, {entry.path: value})
        except ModelError as error:
            first_error = first_error or error
        else:
            first_error = None
            break
    # an error elsewhere comes of the other values of the point, which may mend it
    if first_error is not None:
        place = first_error.path
        if place.startswith(entry.path) or entry.path.startswith(place) or not place:
            raise ModelError(first_error.problem, path=entry.where, given=values[0], allowed=first_error.allowed)
    return StudyAxis.of_path(entry.path, values, *_labels(entry, values))


def _between(entry: _Entry, shares: NDArray[np.float64]) -> list[Any]:
    """Values at shares of the way from one end of a range to the other."""
    ends: Mapping[str, Any] = entry.value
    if "to" not in ends:
        raise ModelError("missing", path=f"{entry.where}.to", allowed=_ALLOWED_RANGE)
    scale = ends.get("scale", "linear")
    if scale not in _SCALES:
        raise ModelError("no such scale", path=f"{entry.where}.scale", given=scale, allowed=" or ".join(_SCALES))
    first, unit = _end(entry, "from")
    last, other_unit = _end(entry, "to")
    for end, number in (("from", first), ("to", last)):
        if not np.isfinite(number):
            where = f"{entry.where}.{end}"
            raise ModelError("no end of a range", path=where, given=ends[end], allowed="finite, or a list of values")
    if unit != other_unit:
        raise ModelError("ends of two units", path=entry.where, given=dict(ends), allowed="one unit")
    if scale == "log":
        if not (first > 0 and last > 0):
            raise ModelError("a log scale to zero or below", path=entry.where, given=dict(ends), allowed="above 0")
        points = np.exp(np.log(first) + shares * (np.log(last) - np.log(first)))
    else:
        points = first + shares * (last - first)
    # the ends are what was written, not rounded by a logarithm
    points = np.where(shares == 0.0, first, np.where(shares == 1.0, last, points))
    numbers = [float(number) for number in points]
    counts = all(isinstance(ends[end], int) for end in ("from", "to")) and all(n == round(n) for n in numbers)
    if entry.whole or counts:
        return [round(number) for number in numbers]
    return [f"{number!r} {unit}" for number in numbers] if unit and not entry.kinds else numbers


def _end(entry: _Entry, end: str) -> tuple[float, str]:
    """Number and unit of an end of a range: SI where the quantity is known, else as written."""
    value, where = entry.value[end], f"{entry.where}.{end}"
    if entry.kinds:
        return _number(entry, value, where)
    number = written(value)
    if number is None or number.many:
        raise ModelError("not a number", path=where, given=value, allowed=_ALLOWED_RANGE)
    return number.values[0], number.unit


def _number(entry: _Entry, value: Any, where: str) -> tuple[float, str]:
    """SI number and SI unit of a value."""
    if entry.written and bare_in(value, entry.kinds):
        raise ModelError(BareNumber(value, entry.kinds, None).problem, path=where, given=value)
    try:
        quantity = read_quantity(value, entry.kinds, Bounds(inf=True))
    except ModelError as error:
        raise ModelError(error.problem, path=where, given=value, allowed=error.allowed) from None
    number, unit = (
        (quantity.value, quantity.unit) if isinstance(quantity, Quantity) else (quantity, KINDS[entry.kinds[0]].unit)
    )
    assert isinstance(number, float)
    return number, unit


def _labels(entry: _Entry, values: Sequence[Any]) -> tuple[NDArray[Any], str]:
    """Labels of values: numbers with their unit where all are single numbers, else texts.

    The unit is the one in which all values, or both ends of a range, were written, else that of SI.
    """
    kinds = entry.kinds
    if kinds and not any(isinstance(value, bool) for value in values):
        with suppress(ModelError, AssertionError):
            pairs = [_number(entry, value, entry.where) for value in values]
            numbers, unit = np.array([number for number, _ in pairs]), pairs[0][1]
            if len({unit for _, unit in pairs}) == 1:
                stated = _unit_of([entry.value["from"], entry.value["to"]] if _is_range(entry.value) else entry.value)
                if not stated or stated == unit:
                    return numbers, unit
                # 15 digits: without the rounding of the conversion there and back
                size, _ = _number(entry, f"1 {stated}", entry.where)
                return np.array([float(f"{number / size:.15g}") for number in numbers]), stated
    return written_labels(values, KINDS[kinds[0]].unit if kinds else "")


def written_labels(values: Sequence[Any], unit: str = "") -> tuple[NDArray[Any], str]:
    """Labels of values as they are written: numbers where all are single ones of one unit, and that unit, else texts.

    unit : of numbers without one.
    """
    singles = [number for value in values if (number := written(value)) is not None and not number.many]
    if len(singles) == len(values) and len({number.unit for number in singles}) == 1:
        return np.array([number.values[0] for number in singles]), singles[0].unit or unit
    return np.array([_text(value) for value in values], dtype=object), ""


def _unit_of(values: Sequence[Any]) -> str:
    """The one unit of all texts of a number with a unit, empty where there is none."""
    texts = [written(value) if isinstance(value, str) else None for value in values]
    units = {text.unit if text is not None and not text.many else "" for text in texts}
    return units.pop() if len(units) == 1 else ""


def _text(value: Any) -> str:
    """A value as text: a list whose entries have one unit as a person writes it, ``[20, 0, 0] um``."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        return str(value)
    if unit := _unit_of(value):
        return f"[{', '.join(number.strip().removesuffix(unit).strip() for number in value)}] {unit}"
    return f"[{', '.join(map(str, value))}]"
