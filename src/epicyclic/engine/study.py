"""A verb over many points of a model, in one labelled Dataset.

Points are computed in blocks: each one's result, or why it has none, as plain bytes.  Results are joined on their
labels, with nothing where a point has no such label.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import closing
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset
from ..warning_codes import coded, placed
from .block_store import BlockJob, hash_of, machine, run_blocks
from .plain_data import plain_bytes, plain_value
from .plan import MOST_NUMBERS, Counted
from .source import OPTIONS, StudyJob, read_job

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
    evaluate: Evaluate,
    model: Mapping[str, Any],
    options: Row,
    rows: Sequence[Row],
    size: int,
    keep: Sequence[str],
    block: int,
) -> dict[str, np.ndarray]:
    """Block of a job: the results of `size` points as bytes.

    Parameters
    ----------
    options : of every point.  rows : path -> value of each point.  keep : variables, () for all.
    """
    points = [_point(evaluate, model, options, row, keep) for row in rows[block * size : (block + 1) * size]]
    return {"points": np.frombuffer(plain_bytes(points), np.uint8)}


def points_of(block: Mapping[str, np.ndarray]) -> list[dict[str, Any]]:
    """Points of a block: status, reason, warnings and result (None of a point that failed), names of all variables."""
    points: list[dict[str, Any]] = plain_value(block["points"].tobytes())
    return points


def _point(evaluate: Evaluate, model: Mapping[str, Any], options: Row, row: Row, keep: Sequence[str]) -> dict[str, Any]:
    """Result of one point, or why it has none."""
    overrides = {path: value for path, value in row.items() if not path.startswith(OPTIONS)}
    options = dict(options) | {
        path.removeprefix(OPTIONS).replace("-", "_"): value for path, value in row.items() if path.startswith(OPTIONS)
    }
    status, reason = "ok", ""
    try:
        result = evaluate(model, overrides, options)
    except ModelError as error:
        status, reason = "wrong input", str(error)
    except ConvergenceError as error:
        status, reason = "no convergence", str(error)
    except MemoryError:
        raise
    except Exception as error:  # one point of many must not end the others
        status, reason = "fault", f"{type(error).__name__}: {error}"
    if status != "ok":
        return {"status": status, "reason": reason, "warnings": [], "names": [], "kind": "", "result": None}
    return {
        "status": status,
        "reason": reason,
        "warnings": json.loads(result.attrs.get("warnings", "[]")),
        "names": [str(name) for name in result.data_vars],
        "kind": str(result.attrs.get("verb", "")),
        "result": _as_kept(result, keep),
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


# --- one Dataset of all ----------------------------------------------------------------------------------------------


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


def unfolded(whole: xr.Dataset, dims: Sequence[str], shape: Sequence[int]) -> xr.Dataset:
    """The dimension `point` of all points as the dimensions of a study, the last one first."""

    def unfold(array: xr.DataArray) -> tuple[tuple[Hashable, ...], Any, Mapping[Any, Any]]:
        if "point" not in array.dims:
            return array.dims, array.values, array.attrs
        return (*dims, *array.dims[1:]), array.values.reshape(*shape, *array.shape[1:]), array.attrs

    coords = {name: unfold(array) for name, array in whole.coords.items() if name != "point"}
    return xr.Dataset({name: unfold(array) for name, array in whole.data_vars.items()}, coords=coords)


# --- the study -------------------------------------------------------------------------------------------------------


def run_study(
    job: str | Path | Mapping[str, Any],
    evaluate: Callable[[str], Evaluate],
    verbs: Mapping[str, Sequence[str]],
    *,
    store: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Results of a verb at every point of a job.

    Parameters
    ----------
    job : a TOML file, or its tables.  evaluate : name of a verb -> what computes a point.
    verbs : name -> options of every verb.  Others as of `run_blocks`.

    Returns
    -------
    Dataset : the variables of the verb, before their own dimensions one for each path of the grid, and `point`;
        status and reason of every point.

    Raises
    ------
    ModelError : the job is wrong, or fails at every point; as of `run_blocks`.
    """
    study = read_job(job, verbs)
    rows = list(study.rows())
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
        compute=partial(computed_block, evaluate(study.verb), study.model, study.options, rows, size, study.keep),
        ragged=("points",),
    )

    def by_points(share: float) -> None:
        """Progress of points from that of blocks."""
        assert isinstance(share, Counted)
        assert progress is not None
        progress(Counted(min(share.done * size, len(rows)), len(rows)))

    points: list[dict[str, Any]] = []
    told = None if progress is None else by_points
    with closing(
        run_blocks(blocks, store=store, resume=resume, workers=workers, scheduler=scheduler, progress=told)
    ) as arriving:
        for _, arrays in arriving:
            arrived = points_of(arrays)
            # what the verb does not give cannot be kept: seen at the first point that has a result
            names = next((point["names"] for point in arrived if point["result"] is not None), study.keep)
            if missing := [name for name in study.keep if name not in names]:
                problem = f"{study.verb} gives no such variable"
                raise ModelError(problem, path="keep", given=missing[0], allowed=", ".join(names))
            points += arrived
    return _result(study, points, hash_of(blocks))


def _result(study: StudyJob, points: Sequence[Mapping[str, Any]], hashed: str) -> xr.Dataset:
    """The Dataset of all points."""
    status = np.array([point["status"] for point in points], dtype=object)
    reason = np.array([point["reason"] for point in points], dtype=object)
    failed = int(np.sum(status != "ok"))
    if failed == len(points):
        raise ModelError(f"every point fails, the first with: {reason[0]}")
    whole = unfolded(stacked([point["result"] for point in points]), study.dims, study.shape)
    said = list(study.warnings)
    if failed:
        first = reason[status != "ok"][0]
        said.append(coded("points-failed", f"{failed} of {len(points)} points failed, the first with: {first}"))
    counts = Counter(text for point in points for text in dict.fromkeys(point["warnings"]))
    for text, number in counts.most_common(_WARNINGS):
        said.append(text if number == len(points) - failed else placed(f"at {number} of {len(points)} points", text))
    if len(counts) > _WARNINGS:
        said.append(coded("more-warnings", f"{len(counts) - _WARNINGS} more warnings of single points"))
    model = study.model  # without what varies
    result = dataset(
        {"status": (study.dims, status.reshape(study.shape)), "reason": (study.dims, reason.reshape(study.shape))},
        coords={"point": np.arange(study.points)} if study.points else {},
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
    axes: dict[str, xr.Variable] = {}
    dims = [*((axis, axis.path) for axis in study.grid), *((axis, "point") for axis in study.along)]
    for axis, dim in dims:
        of = "option of the verb" if axis.path.startswith(OPTIONS) else "value in the model file"
        axes[axis.path] = xr.Variable((dim,), axis.labels, {"units": axis.unit, "long_name": f"{axis.path}, {of}"})
    kind = next(point["kind"] for point in points if point["kind"])
    attributes = {"studied": kind, "points": prod(study.shape), "failed": failed, "job": hashed, "machine": machine()}
    return (
        whole.assign_coords(result.coords)
        .assign_coords(axes)
        .assign(result.data_vars)
        .assign_attrs(result.attrs | attributes)
    )
