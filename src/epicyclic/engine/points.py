"""Points of a study: axes of labelled changes, what a function or verb gives at each point, one Dataset of all results.

An axis is a named list of labelled changes of the model: values of a path, several paths that vary together, variants,
cases.  Axes are crossed.  A point that fails says why, and the others go on.  Results are joined on their labels, with
nothing where a point has no such label.  Points of a verb are computed in blocks: each one's result, or why it has
none, as plain bytes.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Generator, Hashable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import count, product
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset
from ..warning_codes import CodedText, coded, placed
from .block_store import Arrays, BlockJob, hash_of, machine, run_blocks
from .plain_data import plain_bytes, plain_value
from .plan import MOST_NUMBERS, Counted
from .source import OPTIONS, StudyAxis, StudyJob, merged, read_job
from .workers import each

Point = TypeVar("Point")
Result = TypeVar("Result")
Next = TypeVar("Next")
Changes = dict[str, Any]
"""Path -> value of one point."""

_FAILING = (ModelError, ConvergenceError)


def crossed(axes: Sequence[StudyAxis]) -> list[Changes]:
    """Changes of every point of axes that are crossed, the place on the last axis first."""
    return [merged(changes) for changes in product(*(axis.changes for axis in axes))]


# --- what a function gives -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outcome(Generic[Result]):
    """What a function gives at a point, or the error for which it gives nothing."""

    value: Result | None = None
    error: Exception | None = None

    @property
    def status(self) -> str:
        """Kind of outcome in words."""
        if self.error is None:
            return "ok"
        kinds = {"wrong input": ModelError, "no convergence": ConvergenceError}
        return next((words for words, kind in kinds.items() if isinstance(self.error, kind)), "fault")

    @property
    def reason(self) -> str:
        """Message of the error, empty without one."""
        if self.error is None:
            return ""
        return f"{type(self.error).__name__}: {self.error}" if self.status == "fault" else str(self.error)

    @property
    def problem(self) -> str:
        """The same without the place of what is wrong."""
        return self.error.problem if isinstance(self.error, ModelError) else self.reason

    def then(self, work: Callable[[Result], Next]) -> Outcome[Next]:
        """What a function gives of the value; the same error where there is none."""
        return Outcome(error=self.error) if self.value is None else attempt(work, self.value)


def attempt(
    work: Callable[[Point], Result], point: Point, *, failing: tuple[type[Exception], ...] = _FAILING
) -> Outcome[Result]:
    """What a function gives at a point; failing : errors that are of this point alone."""
    try:
        return Outcome(value=work(point))
    except MemoryError:
        raise
    except failing as error:
        return Outcome(error=error)


def outcomes(
    work: Callable[[Point], Result],
    points: Sequence[Point],
    *,
    workers: bool = True,
    long: bool = False,
    failing: tuple[type[Exception], ...] = _FAILING,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome[Result]]:
    """What a function gives at every point, in the order of the points.

    Parameters
    ----------
    work, workers, long : as of `each`.  failing : as of `attempt`.  progress : called with the share done, 0..1.
    """
    done = count(1)

    def arrived(_: int, __: Outcome[Result]) -> None:
        if progress is not None:
            progress(next(done) / len(points))

    return each(partial(attempt, work, failing=failing), points, arrived=arrived, workers=workers, long=long)


def failures(reasons: Sequence[str], what: str = "points") -> list[CodedText]:
    """Warning of points that fail; reasons : of all points, empty where there is a result."""
    failed = [reason for reason in reasons if reason]
    text = f"{len(failed)} of {len(reasons)} {what} failed, the first with: {''.join(failed[:1])}"
    return [coded("points-failed", text)] if failed else []


def numbers(found: Sequence[Outcome[float]], shape: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.object_]]:
    """Numbers of all points, nan where one fails, and "ok" or why, in a shape."""
    values = np.array([np.nan if outcome.value is None else outcome.value for outcome in found], dtype=float)
    status = np.array([outcome.reason or outcome.status for outcome in found], dtype=object)
    return values.reshape(shape), status.reshape(shape)


# --- one Dataset of all ----------------------------------------------------------------------------------------------


def along(axes: Sequence[StudyAxis], results: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """Results of all points of some axes, as of `crossed`, with a dimension and the labels of each axis.

    Raises
    ------
    ModelError : too many numbers.
    """
    whole, dims = stacked(results), [axis.name for axis in axes]
    shape = [len(axis.changes) for axis in axes]

    def unfolded(array: xr.DataArray) -> tuple[Sequence[Hashable], Any, Mapping[Any, Any]]:
        if "point" not in array.dims:
            return array.dims, array.values, array.attrs
        return (*dims, *array.dims[1:]), array.values.reshape(*shape, *array.shape[1:]), array.attrs

    coords = {name: unfolded(array) for name, array in whole.coords.items() if name != "point"}
    labels = {name: (axis.name, *label) for axis in axes for name, label in axis.labels.items()}
    return xr.Dataset({name: unfolded(array) for name, array in whole.data_vars.items()}, coords={**coords, **labels})


def stacked(results: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """Results along the new first dimension `point`.

    Labels of texts and whole numbers are joined: a point has nan, or an empty text, at those that it does not have.
    Coordinates of floating point, or with a label twice, that are not the same at every point are no labels to join
    on: they become a variable NAME_of_point, and the dimension counts.

    Raises
    ------
    ModelError : too many numbers.
    """
    indices = [index for index, result in enumerate(results) if result is not None]
    computed = [result for result in results if result is not None]
    if not computed:
        return xr.Dataset(coords={"point": np.arange(len(results))})
    most = len(results) * max(sum(variable.size for variable in result.variables.values()) for result in computed)
    if most > MOST_NUMBERS:
        allowed = f'keep = ["NAME", ...] with the variables that are wanted; at most {MOST_NUMBERS} numbers'
        raise ModelError("too many numbers to be held in one result", path="keep", given=most, allowed=allowed)
    coordinates = {name for result in computed for name in result.coords if name not in result.dims}
    labelled = _with_labels([result.reset_coords() for result in computed])
    # what stands where a point has nothing, by the kind of the variable: an empty text, else nan
    kinds = {name: variable.dtype.kind for result in labelled for name, variable in result.variables.items()}
    fills: dict[Hashable, Any] = {}
    for name, kind in kinds.items():
        fills[name] = "" if kind in "OU" else complex(np.nan, np.nan) if kind == "c" else np.nan
    whole = xr.concat(
        labelled,
        dim=pd.Index(indices, name="point"),
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value=fills,
        combine_attrs="override",
    ).reindex(point=np.arange(len(results)), fill_value=fills)
    whole = whole.assign({name: _numbers(whole[name]) for name in whole.data_vars})
    return whole.set_coords([name for name in coordinates if name in whole]).transpose("point", ...)


def columns(whole: xr.Dataset) -> dict[str, tuple[tuple[str, ...], NDArray[Any]]]:
    """Dims and values of all variables, as `dataset` takes them."""
    return {str(name): (tuple(map(str, array.dims)), array.values) for name, array in whole.data_vars.items()}


def _with_labels(results: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Results whose dimensions all have labels that can be joined."""
    labelled = list(results)
    for dim in dict.fromkeys(dim for result in results for dim in result.dims):
        indexes = [result.get_index(dim) for result in results if dim in result.dims]
        if all(index.equals(indexes[0]) for index in indexes[1:]) and len(indexes) == len(results):
            continue
        kinds = {index.dtype.kind for index in indexes}
        counts = "f" in kinds or "c" in kinds or not all(index.is_unique for index in indexes)
        labelled = [
            _counted(result, dim) if dim in result.dims and (counts or dim not in result.coords) else result
            for result in labelled
        ]
    return labelled


def _counted(result: xr.Dataset, dim: Hashable) -> xr.Dataset:
    """A result whose dimension counts, its labels, if any, as a variable beside it."""
    counted = result.drop_vars(str(dim), errors="ignore").assign_coords({dim: np.arange(result.sizes[dim])})
    if dim not in result.coords:
        return counted
    return counted.assign({f"{dim}_of_point": ((dim,), result[dim].values, result[dim].attrs)})


def _numbers(variable: xr.DataArray) -> xr.DataArray:
    """A variable that is an array of texts or of numbers: truth values beside nan are numbers."""
    if variable.dtype.kind != "O" or any(isinstance(value, str) for value in variable.values.ravel()):
        return variable
    return variable.astype(float)


Evaluate = Callable[[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]], xr.Dataset]
"""Model, overrides and options of one point -> its result; a function of a module."""
Row = Mapping[str, Any]
"""Path -> value of one point."""

# Blocks of a study at most: each is a few files of a store and a task of a scheduler.  A study of fewer points has one
# point a block, so that nothing more than the points at work is lost.
_MOST_BLOCKS = 4096
# Different warnings of the points that are told, the most frequent first.
_WARNINGS = 20


# --- points ----------------------------------------------------------------------------------------------------------


def computed_block(
    evaluate: Evaluate, study: StudyJob, rows: Sequence[Row], size: int, block: int
) -> dict[str, np.ndarray]:
    """Block of a job: the results of `size` points as bytes; rows : path -> value of each point."""
    points = [_point(evaluate, study, row) for row in rows[block * size : (block + 1) * size]]
    return {"points": np.frombuffer(plain_bytes(points), np.uint8)}


def _point(evaluate: Evaluate, study: StudyJob, row: Row) -> dict[str, Any]:
    """Of one point: status, reason, warnings and result (None where it failed), names of all variables."""
    overrides = {path: value for path, value in row.items() if not path.startswith(OPTIONS)}
    options = dict(study.options) | {
        path.removeprefix(OPTIONS).replace("-", "_"): value for path, value in row.items() if path.startswith(OPTIONS)
    }
    # one point of many must not end the others, whatever its error
    outcome = attempt(partial(evaluate, study.model, overrides), options, failing=(Exception,))
    told, result = {"status": outcome.status, "reason": outcome.reason}, outcome.value
    if result is None:
        return {**told, "warnings": [], "names": [], "kind": "", "result": None}
    return {
        **told,
        "warnings": json.loads(result.attrs.get("warnings", "[]")),
        "names": [str(name) for name in result.data_vars],
        "kind": str(result.attrs.get("verb", "")),
        "result": _as_kept(result, study.keep),
    }


def _as_kept(result: xr.Dataset, keep: Sequence[str]) -> xr.Dataset:
    """The variables of a result that are kept, with units and long names alone of what is said of them."""
    if keep:
        result = result[[name for name in keep if name in result.data_vars]]
    trimmed = result.drop_attrs()
    for name, variable in trimmed.variables.items():
        said = result[name].attrs
        variable.attrs = {key: str(said[key]) for key in ("units", "long_name") if key in said}
    return trimmed


# --- the study -------------------------------------------------------------------------------------------------------


def run_study(
    job: str | Path | Mapping[str, Any],
    evaluate: Callable[[str], Evaluate],
    verbs: Mapping[str, Sequence[str]],
    *,
    run: Callable[..., Generator[tuple[int, Arrays], None, None]] = run_blocks,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Results of a verb at every point of a job.

    Parameters
    ----------
    job : a TOML file, or its tables.  evaluate : name of a verb -> what computes a point.
    verbs : name -> options of every verb.  run : `run_blocks` with store and workers.  progress : as of it.

    Returns
    -------
    Dataset : the variables of the verb, before their own dimensions one for each path of the grid, and `point`;
        status and reason of every point.

    Raises
    ------
    ModelError : the job is wrong, or fails at every point; as of `run_blocks`.
    """
    study = read_job(job, verbs)
    rows = crossed(study.axes)
    size = -(-len(rows) // _MOST_BLOCKS)
    blocks = BlockJob(
        verb="study",
        identity={
            "of": study.verb,
            "model": json.dumps(study.model, sort_keys=True),
            "options": study.options,
            "keep": study.keep,
            "points": json.dumps(rows, default=str),
            "size": size,
        },
        count=-(-len(rows) // size),
        compute=partial(computed_block, evaluate(study.verb), study, rows, size),
        ragged=("points",),
    )

    def told(share: float) -> None:
        """Progress of points from that of blocks."""
        if progress is not None and isinstance(share, Counted):
            progress(Counted(min(share.done * size, len(rows)), len(rows)))

    points: list[dict[str, Any]] = []
    with closing(run(blocks, progress=told)) as arriving:
        for _, arrays in arriving:
            arrived: list[dict[str, Any]] = plain_value(arrays["points"].tobytes())
            # what the verb does not give cannot be kept: seen at the first point that has a result
            names = next((point["names"] for point in arrived if point["result"] is not None), study.keep)
            if missing := [name for name in study.keep if name not in names]:
                problem = f"{study.verb} gives no such variable"
                raise ModelError(problem, path="keep", given=missing[0], allowed=", ".join(names))
            points += arrived
    return _result(study, points, hash_of(blocks))


def _result(study: StudyJob, points: Sequence[Mapping[str, Any]], hashed: str) -> xr.Dataset:
    """The Dataset of all points."""
    reasons = [point["reason"] for point in points]
    failed = len(points) - reasons.count("")
    if failed == len(points):
        raise ModelError(f"every point fails, the first with: {reasons[0]}")
    whole = along(study.axes, [point["result"] for point in points])
    dims, shape = [axis.name for axis in study.axes], [len(axis.changes) for axis in study.axes]
    said = [*study.warnings, *failures(reasons)]
    counts = Counter(text for point in points for text in dict.fromkeys(point["warnings"]))
    for text, number in counts.most_common(_WARNINGS):
        said.append(text if number == len(points) - failed else placed(f"at {number} of {len(points)} points", text))
    if len(counts) > _WARNINGS:
        said.append(coded("more-warnings", f"{len(counts) - _WARNINGS} more warnings of single points"))
    model = study.model  # without what varies
    told = {name: [point[name] for point in points] for name in ("status", "reason")}
    result = dataset(
        {name: (dims, np.array(texts, dtype=object).reshape(shape)) for name, texts in told.items()},
        verb="study",
        options={"verb": study.verb, "options": study.options, "overrides": study.overrides, "seed": study.seed},
        provenance={
            "title": str(model.get("title", "")),
            "doi": str(model.get("doi", "")),
            "model": json.dumps(model, default=str),
            "assumed": json.dumps(model.get("assumed", {})),
        },
        warnings=said,
    )
    kind = next(point["kind"] for point in points if point["kind"])
    attributes = {"studied": kind, "points": len(points), "failed": failed, "job": hashed, "machine": machine()}
    return whole.assign(result.data_vars).assign_attrs(result.attrs | attributes)
