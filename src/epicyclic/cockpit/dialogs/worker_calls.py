"""Plain functions that dialogs let a process of its own run: two states compared, a figure, a file of a job."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...document.tables import PlainTable
from ...questions.compare.compare import compare
from ...results.dataset import load_result
from ...results.tables_out import save_csv, save_xlsx
from ...show.plot import companions, figure_names, plot
from ...show.views import tables_of
from ...train.resolution import load
from ...verbs.record import verbs
from ..processes.jobs import Job

Loadable = tuple[PlainTable, Mapping[str, object]]
"""What `load` takes: source and overrides."""


def compared_states(first: Loadable, second: Loadable, names: tuple[str, str]) -> dict[str, Any]:
    """What differs between two states in the model and in its results.

    names : of the columns A and B.

    Returns
    -------
    ``rows``: texts by heading, one list a row.  ``headings``.  ``lead`` and ``notes``: what stands above and below.

    Raises
    ------
    ModelError : a state of which no train can be made.
    """
    trains = [load(source, overrides=overrides) for source, overrides in (first, second)]
    result = compare(*trains)
    result = result.assign_coords(train=[f"{names[0]}, pinned", f"{names[1]}, present"])
    (table,) = tables_of(result)
    headings = list(table.columns)
    rows = [[str(cell) for cell in row] for row in zip(*table.columns.values(), strict=True)]
    return {"headings": headings, "rows": rows, "lead": table.lead, "notes": list(table.notes)}


VERBS: tuple[str, ...] = ("check", "modes", "sharing", "static", "steady", "sweep", "stiffness", "efficiency")
"""Verbs of a train alone that take seconds; longer ones are jobs, and stand in the report."""


def figures() -> dict[str, tuple[str, ...]]:
    """Verb -> names of its figures, of `VERBS`."""
    return {verb: names for verb in VERBS if (names := figure_names(verb))}


def figure_of(model: Loadable, verb: str, name: str) -> dict[str, Any]:
    """A figure as plain JSON of plotly.

    Raises
    ------
    ModelError : the model lacks what the verb needs, or the result has nothing to draw there.
    """
    source, overrides = model
    train = load(source, overrides=overrides)
    results = [verbs()[one].run(train) for one in (verb, *companions(verb, name))]
    drawn: dict[str, Any] = json.loads(plot(name, *results).to_json(validate=False))
    return drawn


def jobs_done(jobs: Sequence[Job], rev: int) -> dict[str, Job]:
    """Name -> the newest job of the state with this number whose Dataset is there."""
    return {job.name: job for job in jobs if job.rev == rev and job.status == "done" and job.dataset_path is not None}


def job_file(path: Path, kind: str) -> bytes:
    """Content of the Dataset at a path (.nc) as a file of a kind: nc, csv or xlsx."""
    if kind != "nc":
        target = path.with_suffix(f".{kind}")
        {"csv": save_csv, "xlsx": save_xlsx}[kind](load_result(path), target)
        content = target.read_bytes()
        target.unlink()
        return content
    return path.read_bytes()
