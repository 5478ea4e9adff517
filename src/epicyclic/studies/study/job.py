"""The job file of a study: verb, model, options, and what varies, checked and turned into points."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...input_files import read_text
from ...model.bare_numbers import typed
from ...model.distributions import Distribution
from ...model.document import Document, read, ready_drives
from ...model.names import nearest
from ...model.tables import dotted_line
from ...resolve import load
from ...resolve.tolerances import tolerances_of
from ...warning_codes import CodedText, coded
from ..tolerance.sampling import Sampler, SamplingPlan, scramble_uniforms
from .axes import OPTIONS, Variation, axis_of, drawn, is_range

__all__ = ["StudyJob", "read_job"]

_KEYS = ("verb", "model", "options", "overrides", "keep", "seed", "grid", "list", "random", "sobol")
_MAX_BYTES = 4_000_000
_MOST_POINTS = 1_000_000
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
