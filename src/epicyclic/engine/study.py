"""A verb over many points of a model, in one labelled Dataset.

The points of a study, computed in blocks: each one's result, or why it has none, as plain bytes.

Results of many points as one Dataset: joined on their labels, with nothing where a point has no such label.
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
from .plain import plain_bytes, plain_value
from .run_folder import Counted
from .study_job import OPTIONS, StudyJob, Variation, read_job

Evaluate = Callable[[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]], xr.Dataset]
"""Model, overrides and options of one point -> its result; a function of a module."""
Row = Mapping[str, Any]


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
    points = plain_value(block["points"].tobytes())
    return [{**point, "result": _dataset(point["result"])} for point in points]


def _point(evaluate: Evaluate, model: Mapping[str, Any], options: Row, row: Row, keep: Sequence[str]) -> dict[str, Any]:
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
        **{"status": status, "reason": reason, "warnings": json.loads(result.attrs.get("warnings", "[]"))},
        **{"names": [str(name) for name in result.data_vars], "kind": str(result.attrs.get("verb", ""))},
        "result": _plain(result, keep),
    }


def _plain(result: xr.Dataset, keep: Sequence[str]) -> dict[str, Any]:
    """A result as plain data: name -> dims, values, attributes, whether it is a coordinate."""
    if keep:
        result = result[[name for name in keep if name in result.data_vars]]
    return {
        str(name): [
            [str(dim) for dim in variable.dims],
            np.asarray(variable.values),
            {key: str(variable.attrs[key]) for key in ("units", "long_name") if key in variable.attrs},
            name in result.coords,
        ]
        for name, variable in result.variables.items()
    }


def _dataset(plain: Mapping[str, Any] | None) -> xr.Dataset | None:
    """The result of such data."""
    if plain is None:
        return None
    variables = {name: (dims, values, attrs) for name, (dims, values, attrs, _) in plain.items()}
    return xr.Dataset(
        {name: one for name, one in variables.items() if not plain[name][3]},
        coords={name: one for name, one in variables.items() if plain[name][3]},
    )


MOST_NUMBERS = 200_000_000
"""Numbers of a result, as many as a run may hold."""


def stacked(results: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """Results along the new first dimension `point`.

    Labels of texts and whole numbers are joined: a point has nan, or an empty text, at those that it does not have.
    Coordinates of floating point, or with a label twice, that are not the same at every point are no labels to join
    on: they become a variable NAME_of_point, and the dimension counts.

    Raises
    ------
    ModelError : too many numbers.
    """
    places = [place for place, one in enumerate(results) if one is not None]
    found = [one for one in results if one is not None]
    if not found:
        return xr.Dataset(coords={"point": np.arange(len(results))})
    most = len(results) * max(sum(variable.size for variable in one.variables.values()) for one in found)
    if most > MOST_NUMBERS:
        allowed = f'keep = ["NAME", ...] with the variables that are wanted; at most {MOST_NUMBERS} numbers'
        raise ModelError("too many numbers to be held in one result", path="keep", given=most, allowed=allowed)
    coordinates = {name for one in found for name in one.coords if name not in one.dims}
    labelled = _with_labels([one.reset_coords() for one in found])
    fills = _fills(labelled)
    whole = xr.concat(
        labelled,
        dim=pd.Index(places, name="point"),
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value=fills,
        combine_attrs="override",
    ).reindex(point=np.arange(len(results)), fill_value=fills)
    whole = whole.assign({name: _numbers(whole[name]) for name in whole.data_vars})
    return whole.set_coords([name for name in coordinates if name in whole]).transpose("point", ...)


def _with_labels(found: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Results whose dimensions all have labels that can be joined."""
    made = list(found)
    for dim in dict.fromkeys(dim for one in found for dim in one.dims):
        having = [one for one in found if dim in one.dims]
        indexes = [one.get_index(dim) for one in having]
        if all(index.equals(indexes[0]) for index in indexes[1:]) and len(having) == len(found):
            continue
        kinds = {index.dtype.kind for index in indexes}
        counts = "f" in kinds or "c" in kinds or not all(index.is_unique for index in indexes)
        made = [_counted(one, dim) if counts or dim not in one.coords else one for one in made]
    return made


def _counted(one: xr.Dataset, dim: Hashable) -> xr.Dataset:
    """A result whose dimension counts, its labels, if any, as a variable beside it."""
    if dim not in one.dims:
        return one
    counted = one.drop_vars(str(dim), errors="ignore").assign_coords({dim: np.arange(one.sizes[dim])})
    return (
        counted.assign({f"{dim}_of_point": ((dim,), one[dim].values, one[dim].attrs)}) if dim in one.coords else counted
    )


def _fills(found: Sequence[xr.Dataset]) -> dict[Hashable, Any]:
    """What stands where a point has nothing, by the kind of the variable: an empty text, else nan."""
    kinds = {name: variable.dtype.kind for one in found for name, variable in one.variables.items()}
    fills: dict[Hashable, Any] = {}
    for name, kind in kinds.items():
        fills[name] = "" if kind in "OU" else complex(np.nan, np.nan) if kind == "c" else np.nan
    return fills


def _numbers(variable: xr.DataArray) -> xr.DataArray:
    """A variable that is an array of texts or of numbers: truth values beside nan are numbers."""
    if variable.dtype.kind != "O" or any(isinstance(value, str) for value in variable.values.ravel()):
        return variable
    return variable.astype(float)


def unfolded(whole: xr.Dataset, dims: Sequence[str], shape: Sequence[int]) -> xr.Dataset:
    """The dimension `point` of all points as the dimensions of a study, the last one first."""

    def variable(one: xr.DataArray) -> tuple[tuple[Hashable, ...], Any, Mapping[Any, Any]]:
        if "point" not in one.dims:
            return one.dims, one.values, one.attrs
        return (*dims, *one.dims[1:]), one.values.reshape(*shape, *one.shape[1:]), one.attrs

    coords = {name: variable(one) for name, one in whole.coords.items() if name != "point"}
    return xr.Dataset({name: variable(one) for name, one in whole.data_vars.items()}, coords=coords)


# Blocks of a study at most: each is a few files of a store and a task of a scheduler.  A study of fewer points has one
# point a block, so that nothing more than the points at work is lost.
_MOST_BLOCKS = 4096
# Different warnings of the points that are told, the most frequent first.
_WARNINGS = 20


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
    asked = read_job(job, verbs)
    rows = list(asked.rows())
    size = -(-len(rows) // _MOST_BLOCKS)
    blocks = BlockJob(
        verb="study",
        identity={
            **{"of": asked.verb, "model": json.dumps(asked.model, sort_keys=True), "options": asked.options},
            **{"keep": asked.keep, "points": json.dumps(rows, default=str), "size": size},
        },
        count=-(-len(rows) // size),
        compute=partial(computed_block, evaluate(asked.verb), asked.model, asked.options, rows, size, asked.keep),
        ragged=("points",),
    )
    told = None if progress is None else _by_points(progress, len(rows), size)
    points: list[dict[str, Any]] = []
    with closing(
        run_blocks(blocks, store=store, resume=resume, workers=workers, scheduler=scheduler, progress=told)
    ) as arriving:
        for _, arrays in arriving:
            new = points_of(arrays)
            _require_kept(asked, new)
            points += new
    return _result(asked, points, hash_of(blocks))


def _by_points(progress: Callable[[float], None], count: int, size: int) -> Callable[[float], None]:
    """Progress of points from that of blocks."""

    def told(share: float) -> None:
        assert isinstance(share, Counted)
        progress(Counted(min(share.done * size, count), count))

    return told


def _require_kept(asked: StudyJob, points: Sequence[Mapping[str, Any]]) -> None:
    """Refuse to keep what the verb does not give, at the first point that has a result."""
    names = next((point["names"] for point in points if point["result"] is not None), None)
    missing = [name for name in asked.keep if names is not None and name not in names]
    if missing and names is not None:
        problem = f"{asked.verb} gives no such variable"
        raise ModelError(problem, path="keep", given=missing[0], allowed=", ".join(names))


def _result(asked: StudyJob, points: Sequence[Mapping[str, Any]], hashed: str) -> xr.Dataset:
    """The Dataset of all points."""
    status = np.array([point["status"] for point in points], dtype=object)
    reason = np.array([point["reason"] for point in points], dtype=object)
    failed = int(np.sum(status != "ok"))
    if failed == len(points):
        raise ModelError(f"every point fails, the first with: {reason[0]}")
    whole = unfolded(stacked([point["result"] for point in points]), asked.dims, asked.shape)
    counts = Counter(text for point in points for text in set(point["warnings"]))
    first = next((str(text) for text, state in zip(reason, status, strict=True) if state != "ok"), "")
    said = [
        *asked.warnings,
        *(
            [coded("points-failed", f"{failed} of {len(points)} points failed, the first with: {first}")]
            if failed
            else []
        ),
    ]
    for text, number in counts.most_common(_WARNINGS):
        said.append(text if number == len(points) - failed else placed(f"at {number} of {len(points)} points", text))
    if len(counts) > _WARNINGS:
        said.append(coded("more-warnings", f"{len(counts) - _WARNINGS} more warnings of single points"))
    result = dataset(
        {"status": (asked.dims, status.reshape(asked.shape)), "reason": (asked.dims, reason.reshape(asked.shape))},
        coords={"point": np.arange(asked.points)} if asked.points else {},
        verb="study",
        options={"verb": asked.verb, "options": asked.options, "overrides": asked.overrides, "seed": asked.seed},
        provenance=_provenance(asked),
        warnings=said,
    )
    axes = {axis.path: _coordinate(axis, axis.path) for axis in asked.grid}
    axes |= {axis.path: _coordinate(axis, "point") for axis in asked.along}
    kind = next(point["kind"] for point in points if point["kind"])
    attributes = {"studied": kind, "points": prod(asked.shape), "failed": failed, "job": hashed, "machine": machine()}
    return (
        whole.assign_coords(result.coords)
        .assign_coords(axes)
        .assign(result.data_vars)
        .assign_attrs(result.attrs | attributes)
    )


def _coordinate(axis: Variation, dim: str) -> xr.Variable:
    """Values of a path as a coordinate."""
    words = "option of the verb" if axis.path.startswith("options.") else "value in the model file"
    return xr.Variable((dim,), axis.labels, {"units": axis.unit, "long_name": f"{axis.path}, {words}"})


def _provenance(asked: StudyJob) -> dict[str, str]:
    """Attributes that say which model it is; of the model without what varies."""
    model = asked.model
    return {
        "title": str(model.get("title", "")),
        "doi": str(model.get("doi", "")),
        "model": json.dumps(model, default=str),
        "assumed": json.dumps(model.get("assumed", {})),
    }
