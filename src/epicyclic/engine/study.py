"""A verb over many points of a model, in one labelled Dataset.

Points are computed in blocks: each one's result, or why it has none, as plain bytes.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..errors import ModelError
from ..results.dataset import dataset
from ..warning_codes import coded, placed
from .block_store import Arrays, BlockJob, hash_of, machine, run_blocks
from .plain_data import plain_bytes, plain_value
from .plan import Counted
from .points import along, attempt, crossed, failures
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
