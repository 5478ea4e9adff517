"""A verb over many points of a model, in one labelled Dataset."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...errors import ModelError
from ...results.counted import Counted
from ...results.dataset import dataset
from ...warning_codes import coded, placed
from ..blocks.run import BlockJob, hash_of, run_blocks
from ..blocks.versions import machine
from .axes import Variation
from .job import StudyJob, read_job
from .points import Evaluate, computed_block, points_of
from .stacking import stacked, unfolded

__all__ = ["run_study"]

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
