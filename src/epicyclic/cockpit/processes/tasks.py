"""What a process of a page does: a job of the answers, the report, or a function that a window waits for.

Tasks and functions are picklable; heavy rooms are imported where they are used, in that process.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...document.tables import PlainTable
from ...errors import ModelError
from ..state.frames import PageFrame

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[..., None]
Result = tuple[PageFrame | None, Path | None, Any]
"""Frame for the page, file, and another value, those that there are."""
Loadable = tuple[PlainTable, Mapping[str, object]]
"""What `load` takes: source and overrides."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Picklable work: function(*arguments, progress=progress)."""

    name: str
    label: str
    function: Callable[..., Result]
    arguments: tuple[Any, ...] = ()


def task_of(name: str, options: Mapping[str, Any], model: Loadable, rev: int, stem: Path) -> Task:
    """The task of a name: a job of the answers, "html" for the report, or "call" with a function and its arguments.

    stem : path without suffix of the file that it may write.

    Raises
    ------
    ModelError : no such job.
    """
    if name == "call":
        return Task(name=name, label="", function=_called, arguments=(options["function"], options["arguments"]))
    if name == "html":
        return Task(name=name, label="report", function=_report, arguments=(model, stem.with_suffix(".html")))
    from ..answers.jobs import JOBS

    if name not in JOBS:
        raise ModelError("no such job", path="job", given=name, allowed=", ".join([*JOBS, "html"]))
    arguments = (name, model, options, rev, stem.with_suffix(".nc"))
    return Task(name=name, label=JOBS[name].label, function=_job, arguments=arguments)


def _called(function: Callable[..., Any], arguments: tuple[Any, ...], *, progress: Progress) -> Result:
    return None, None, function(*arguments)


def _job(
    name: str, model: Loadable, options: Mapping[str, Any], rev: int, target: Path, *, progress: Progress
) -> Result:
    from ...results.dataset import save_result
    from ..answers.jobs import JOBS

    frame, dataset = JOBS[name].run(*model, options, progress)
    save_result(dataset, target)
    return replace(frame, rev=rev), target, None


def _report(model: Loadable, target: Path, *, progress: Progress) -> Result:
    """The report of everything as a file."""
    from ...show.report import write_report
    from ...verbs.report import report_sections, run_report, side_by_side

    steps, done = len(report_sections()) + 2, 0

    def tell(_: str) -> None:
        nonlocal done
        done += 1
        progress(done, steps)

    source, overrides = model
    results = run_report(source, overrides=dict(overrides), progress=tell)
    tell("figures")
    write_report(target, results, each=side_by_side)
    return None, target, None


# functions that the page waits for ------------------------------------------------------------------------------------


def levers_at(source: PlainTable, overrides: Mapping[str, object]) -> tuple[Mapping[str, Any], ...]:
    """Levers of a model file as tables, whatever overrides move: a page that is opened again has the same ones.  Where
    the file alone is no model, those of the file with its overrides.

    Raises
    ------
    ModelError : the model cannot be read.
    """
    from ..answers.levers import levers_of

    try:
        levers = levers_of(source, {})
    except ModelError:
        levers = levers_of(source, overrides)
    return tuple(asdict(lever) for lever in levers)


def verb_file(model: Loadable, verb: str, kind: str, folder: Path) -> bytes:
    """Result of a verb as the content of a file of a kind: nc, csv or xlsx; folder : for what is written meanwhile."""
    from ...verbs.record import verbs

    source, overrides = model
    return _content(verbs()[verb].run(source, overrides=dict(overrides)), kind, folder)


def job_file(path: Path, kind: str) -> bytes:
    """Content of the Dataset at a path (.nc) as a file of a kind: nc, csv or xlsx."""
    from ...results.dataset import load_result

    return path.read_bytes() if kind == "nc" else _content(load_result(path), kind, path.parent)


def _content(result: xr.Dataset, kind: str, folder: Path) -> bytes:
    from ...results.dataset import save_result
    from ...results.tables_out import save_csv, save_xlsx

    with tempfile.TemporaryDirectory(dir=folder) as inner:
        target = Path(inner) / f"result.{kind}"
        {"nc": save_result, "csv": save_csv, "xlsx": save_xlsx}[kind](result, target)
        return target.read_bytes()


def figure_of(model: Loadable, verb: str, name: str) -> dict[str, Any]:
    """A figure as plain JSON of plotly.

    Raises
    ------
    ModelError : the model lacks what the verb needs, or the result has nothing to draw there.
    """
    from ...show.plot import companions, plot
    from ...train.resolution import load
    from ...verbs.record import verbs

    source, overrides = model
    train = load(source, overrides=overrides)
    results = [verbs()[needed].run(train) for needed in (verb, *companions(verb, name))]
    figure: dict[str, Any] = json.loads(plot(name, *results).to_json(validate=False))
    return figure


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
    from ...questions.studies.compare import compare
    from ...show.views import tables_of
    from ...train.resolution import load

    trains = [load(source, overrides=overrides) for source, overrides in (first, second)]
    result = compare(*trains)
    result = result.assign_coords(train=[f"{names[0]}, pinned", f"{names[1]}, present"])
    (table,) = tables_of(result)
    rows = [[str(cell) for cell in row] for row in zip(*table.columns.values(), strict=True)]
    return {"headings": list(table.columns), "rows": rows, "lead": table.lead, "notes": list(table.notes)}
