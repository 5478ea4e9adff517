"""What a job does in its process: a job of the answers, a result as a file, or a function with its value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...errors import ModelError
from ..computing.frames import PageFrame

__all__ = ["FILES", "Task", "called", "task_of"]

FILES = ("nc", "json", "csv", "xlsx", "html")
"""Kinds of files of a result; html is the report of everything."""

Progress = Callable[..., None]
Result = tuple[PageFrame | None, Path | None, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Picklable work.  run(progress) -> (frame, file, value)."""

    name: str
    label: str
    function: Callable[..., Result]
    arguments: tuple[Any, ...] = ()
    keywords: Mapping[str, Any] = field(default_factory=dict)

    def run(self, progress: Progress) -> Result:
        return self.function(*self.arguments, progress=progress, **self.keywords)


def task_of(name: str, options: dict[str, Any], source: Any, overrides: dict[str, Any], rev: int, place: Path) -> Task:
    """The task of a name: a job of the answers, "html", or "call" with a function and its arguments.

    place : path without suffix of the file that it may write.

    Raises
    ------
    ModelError : no such job.
    """
    if name == "call":
        return Task(name=name, label="", function=called, arguments=(options["function"], options["arguments"]))
    if name in FILES:
        target, verb = place.with_suffix(f".{name}"), options.get("verb", "")
        label = "report" if name == "html" else f"{verb} as .{name}"
        return Task(name=name, label=label, function=_file, arguments=(name, verb, source, overrides, target))
    from ..answers.jobs import JOBS

    if name not in JOBS:
        raise ModelError("no such job", path="job", given=name, allowed=", ".join([*JOBS, *FILES]))
    arguments = (name, source, overrides, options, rev, place.with_suffix(".nc"))
    return Task(name=name, label=JOBS[name].label, function=_job, arguments=arguments)


def called(function: Callable[..., Any], arguments: tuple[Any, ...], *, progress: Progress) -> Result:
    """A function of a module with its arguments; it tells no progress."""
    return None, None, function(*arguments)


def _job(
    name: str,
    source: Any,
    overrides: Mapping[str, Any],
    options: Mapping[str, Any],
    rev: int,
    target: Path,
    *,
    progress: Progress,
) -> Result:
    from ...results.dataset import save_result
    from ..answers.jobs import JOBS

    frame, dataset = JOBS[name].run(source, overrides, options, progress)
    save_result(dataset, target)
    return PageFrame(rev=rev, kind=frame.kind, head=frame.head, arrays=frame.arrays), target, None


def _file(
    kind: str, verb: str, source: Any, overrides: Mapping[str, Any], target: Path, *, progress: Progress
) -> Result:
    """A result of a verb as a file, or the report of all of them."""
    if kind == "html":
        _report(source, overrides, target, progress)
        return None, target, None
    from inspect import signature

    from ...results.dataset import save_result, to_json
    from ...results.files import write_text
    from ...results.tables_out import save_csv, save_xlsx
    from ...verbs.record import verbs

    known = verbs()
    if verb.replace("-", "_") not in known:
        raise ModelError("no such verb", path="verb", given=verb, allowed=", ".join(known))
    run = known[verb.replace("-", "_")].run
    more = {"progress": progress} if "progress" in signature(run).parameters else {}
    result = run(source, overrides=dict(overrides), **more)
    if kind == "json":
        write_text(target, to_json(result))
    else:
        {"nc": save_result, "csv": save_csv, "xlsx": save_xlsx}[kind](result, target)
    return None, target, None


def _report(source: Any, overrides: Mapping[str, Any], target: Path, progress: Progress) -> None:
    from ...show.report import write_report
    from ...verbs.report import report_sections, run_report, side_by_side

    steps, done = len(report_sections()) + 2, 0

    def tell(_: str) -> None:
        nonlocal done
        done += 1
        progress(done, steps)

    results = run_report(source, overrides=dict(overrides), progress=tell)
    tell("figures")
    write_report(target, results, each=side_by_side)
