"""Long work of one page: a process for each job, with progress, time left, and an end on request.

A task is a job of the answers, the report, or a function that a window waits for.  Tasks and functions are picklable;
heavy rooms are imported where they are used, in that process.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ...document.tables import PlainTable
from ...errors import ModelError
from ..state.frames import PageFrame, pack, unpack
from ..state.state import Origin, PageState, request_of, with_values
from .worker import Channel, JobQueue, Spare, kill_group, spawned, waiting

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[..., None]
Result = tuple[PageFrame | None, Path | None, Any]
"""Frame for the page, file, and another value, those that there are."""
Loadable = tuple[PlainTable, Mapping[str, object]]
"""What `load` takes: source and overrides."""


Task = Callable[..., Result]
"""Picklable work, called with ``progress=progress``."""


def task_of(name: str, options: Mapping[str, Any], model: Loadable, rev: int, stem: Path) -> tuple[str, Task]:
    """Label and task of a name: a job of the answers, "html" for the report, or "call" with a function and its
    arguments.

    stem : path without suffix of the file that it may write.

    Raises
    ------
    ModelError : no such job.
    """
    if name == "call":
        return "", partial(_called, options["function"], options["arguments"])
    if name == "html":
        return "report", partial(_report, model, stem.with_suffix(".html"))
    from ..computing.job_kinds import JOBS

    if name not in JOBS:
        raise ModelError("no such job", path="job", given=name, allowed=", ".join([*JOBS, "html"]))
    return JOBS[name].label, partial(_job, name, model, options, rev, stem.with_suffix(".nc"))


def _called(function: Callable[..., Any], arguments: tuple[Any, ...], *, progress: Progress) -> Result:
    return None, None, function(*arguments)


def _job(
    name: str, model: Loadable, options: Mapping[str, Any], rev: int, target: Path, *, progress: Progress
) -> Result:
    from ...results.dataset import save_result
    from ..computing.job_kinds import JOBS

    frame, dataset = JOBS[name].run(*model, options, progress)
    save_result(dataset, target)
    return replace(frame, rev=rev), target, None


def _report(model: Loadable, target: Path, *, progress: Progress) -> Result:
    """The report of everything as a file."""
    from ...engine.workers import each
    from ...show.report import write_report
    from ...verbs.record import report_sections, run_report

    steps, done = len(report_sections()) + 2, 0

    def tell(_: str) -> None:
        nonlocal done
        done += 1
        progress(done, steps)

    source, overrides = model
    results = run_report(source, overrides=dict(overrides), progress=tell)
    tell("figures")
    write_report(target, results, each=partial(each, pickled=False))
    return None, target, None


# functions that the page waits for ------------------------------------------------------------------------------------


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

    with tempfile.TemporaryDirectory(dir=folder) as inner:
        return save_result(result, Path(inner) / f"result.{kind}").read_bytes()


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


# jobs -----------------------------------------------------------------------------------------------------------------

# Priority of a job below the live process (nice): a slider answers while jobs take all cores.
_NICE = 10
# Jobs of a page that are kept with their results, the oldest ended ones forgotten first.
_MOST_KEPT = 24
# [s] that a job may take to end politely before its process is killed, and between two looks whether it has ended.
_POLITE, _LOOK = 1.0, 0.05
# Share done below which the time left is not told: the first parts say little of the rest.
_TELLING = 0.02
# Share done of what is still at work.
_NOT_DONE = 0.99

Status = Literal["waits", "runs", "done", "cancelled", "failed"]


@dataclass(slots=True, eq=False)
class Job:
    """One job.  rev : newest state it belongs to.  model : what that is computed of.  progress : 0..1.

    origin : model file of the state, as of `PageState`; None where it is of none.
    state, options : that it was started with.
    place : 0 of its own state; of one that changes what it knows of, which of ``kept`` of its frame that is, from 1.
    remaining : [s], None where it is not known yet.
    message : why it failed.  died : whether its process ended without a word.
    frame, packed : its result for the page.  value : another result.
    dataset_path : file of its Dataset, or the file it was asked for, in a folder that goes with the page.
    """

    id: int
    name: str
    label: str
    rev: int
    progress: float = 0.0
    remaining: float | None = None
    status: Status = "waits"
    message: str = ""
    died: bool = False
    frame: PageFrame | None = None
    packed: bytes | None = None
    dataset_path: Path | None = None
    value: Any = None
    error: ModelError | None = None
    hidden: bool = False
    model: object = None
    origin: Origin | None = None
    state: PageState | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    place: int = 0
    seconds: float = 0.0
    _task: Task | None = None
    _process: SpawnProcess | None = None
    _channel: Channel | None = None
    _begun: float = 0.0
    _over: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def ended(self) -> bool:
        return self.status in ("done", "cancelled", "failed")

    @property
    def head(self) -> Mapping[str, Any]:
        """What is said of its result in its state, or in another in which that stands: ``job`` and ``answers``."""
        head = {} if self.frame is None else self.frame.head
        if not self.place:
            return head
        kept = head["kept"][self.place - 1]
        return {**head, **kept, "job": {**head["job"], **kept["job"]}}

    def place_of(self, model: object) -> int | None:
        """Its place where a model is that of a state in which its result stands, else None."""
        if self.model == model:
            return 0
        kept = self.frame.head.get("kept", ()) if self.frame is not None and self.state is not None else ()
        for place, change in enumerate(kept, start=1):
            with suppress(ModelError):
                if self.state is not None and request_of(with_values(self.state, change["overrides"])) == model:
                    return place
        return None

    async def wait(self) -> None:
        """Wait until it has ended."""
        await self._over.wait()


def jobs_done(jobs: Sequence[Job], rev: int) -> dict[str, Job]:
    """Name -> the newest job of the state with this number whose Dataset is there."""
    return {job.name: job for job in jobs if job.rev == rev and job.status == "done" and job.dataset_path is not None}


def newest_of(jobs: Sequence[Job], rev: int, origin: object) -> dict[str, Job]:
    """Name -> the job that says most of the state with this number: one that runs or has ended for it; else one of
    another state of the same model file that runs, or the newest that was done or whose process died.  What was
    refused or cancelled of another state says nothing of this one."""
    newest: dict[str, Job] = {}

    def says(job: Job) -> tuple[bool, bool]:
        return not job.ended, job.rev == rev

    for job in jobs:
        if job.rev != rev and (job.origin != origin or (job.status in ("failed", "cancelled") and not job.died)):
            continue
        if job.name not in newest or says(job) >= says(newest[job.name]):
            newest[job.name] = job
    return newest


class Jobs:
    """The jobs of a page, oldest first.

    changed : called in the event loop after each change.  spare : of processes that wait; None: each starts its own.
    queue : of the jobs of all pages.
    """

    def __init__(self, changed: Callable[[Job], None], spare: Spare | None = None) -> None:
        self.all: list[Job] = []
        self.spare = spare
        self.queue = JobQueue()
        self._changed = changed
        self._numbers = itertools.count(1)
        self._folder: Path | None = None
        self._closed = False
        self._starting: set[asyncio.Task[None]] = set()
        self._ending: dict[SpawnProcess, Job] = {}

    @property
    def folder(self) -> Path:
        """A folder of this page alone (mode 0700), which goes with it."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="epicyclic-"))
        return self._folder

    def visible(self) -> list[Job]:
        """Those a person has started."""
        return [job for job in self.all if not job.hidden]

    def begin(
        self,
        name: str,
        options: Mapping[str, Any],
        *,
        model: Loadable,
        rev: int,
        origin: Origin | None = None,
        hidden: bool = False,
    ) -> Job:
        """Start a job of that name, or have it wait for its turn.

        Raises
        ------
        ModelError : no such job.
        """
        if self._closed:
            raise ModelError("the page is closed", path="job", given=name)
        number = next(self._numbers)
        label, task = task_of(name, dict(options), model, rev, self.folder / f"job-{number}")
        job = Job(id=number, name=name, label=label, rev=rev, hidden=hidden, model=model, origin=origin, _task=task)
        job.options = dict(options)
        self.all.append(job)
        ended = [job for job in self.all if job.ended]
        for old in ended[: max(0, len(self.all) - _MOST_KEPT)]:
            self.forget(old)
        self._changed(job)
        self.queue.join(job, partial(self._start, job), short=hidden)
        return job

    def forget(self, job: Job) -> None:
        """Drop a job that has ended, with its file."""
        if job in self.all:
            self.all.remove(job)
        if job.dataset_path is not None:
            job.dataset_path.unlink(missing_ok=True)

    def cancel(self, job: Job) -> None:
        """Ask a job to end; its process is killed where it does not."""
        if job._channel is not None:
            job._channel.send("cancel")
            asyncio.get_running_loop().call_later(_POLITE, self._kill, job)
        elif not job.ended:
            self._end(job, "cancelled")

    def cancel_all(self, why: str) -> None:
        """Ask all that run or wait to end, and say why."""
        for job in self.all:
            if not job.ended:
                job.message = why
                self.cancel(job)

    async def close(self) -> None:
        """Kill all, and remove their files."""
        self._closed = True
        for job in self.all:
            if not job.ended:
                self._end(job, "cancelled")
        if self._starting:
            await asyncio.wait(set(self._starting))
        for process in tuple(self._ending):  # one may end meanwhile
            kill_group(process)
        for process, job in tuple(self._ending.items()):  # one may end meanwhile
            await asyncio.to_thread(process.join)
            self.queue.leave(job)
        self._ending.clear()
        if self._folder is not None:
            await asyncio.to_thread(shutil.rmtree, self._folder, True)

    def _start(self, job: Job) -> None:
        """It is the turn of a job."""
        job.status, job._begun = "runs", time.monotonic()
        starting = asyncio.get_running_loop().create_task(self._launch(job))
        self._starting.add(starting)
        starting.add_done_callback(self._starting.discard)
        self._changed(job)

    async def _launch(self, job: Job) -> None:
        try:
            if self.spare is not None:
                process, connection = await self.spare.take()
            else:
                process, connection = await asyncio.to_thread(spawned, waiting)
        except OSError as error:
            job.message = f"no process can be started: {error}"
            self.queue.leave(job)
            self._end(job, "failed")
            return
        if job.ended:  # cancelled meanwhile
            connection.close()
            self._let_end(process, job, 0.0)
            return
        job._process = process
        arrived, ended = partial(self._arrived, job), partial(self._died, job)
        job._channel = Channel(connection, arrived=arrived, ended=ended)
        job._channel.send((work, (job.name, job._task, 0 if job.hidden else _NICE)))

    def _arrived(self, job: Job, message: tuple[str, Any]) -> None:
        if job.ended:
            return
        kind, content = message
        if kind == "progress":
            spent = time.monotonic() - job._begun
            job.progress = max(job.progress, min(_NOT_DONE, float(content)))
            job.remaining = spent * (1 / job.progress - 1) if job.progress > _TELLING else None
            self._changed(job)
        elif kind == "done":
            job.packed, job.dataset_path, job.value = content
            job.frame = None if job.packed is None else unpack(job.packed)
            self._number(job, job.rev)
            job.progress = 1.0
            self._end(job, "done")
        elif kind == "failed":
            job.message, job.error = str(content), content
            self._end(job, "failed")
        else:
            self._end(job, "cancelled")

    def _number(self, job: Job, rev: int) -> None:
        """The state of this number is the one that a job belongs to."""
        job.rev = rev
        if job.frame is not None and job.frame.rev != rev:
            job.frame = replace(job.frame, rev=rev)
            job.packed = pack(job.frame)

    def follow(self, model: object, rev: int) -> None:
        """The page shows a state with a new number: jobs whose result stands in it belong to it."""
        for job in self.visible():
            if (place := job.place_of(model)) is not None:
                job.place = place
                self._number(job, rev)

    def _died(self, job: Job) -> None:
        if not job.ended:
            code = None if job._process is None else _exit_code(job._process)
            killed = f"was killed (signal {-code})" if code is not None and code < 0 else "ended by itself"
            job.message, job.died = f"its process {killed} at {100 * job.progress:.0f} %", True
            self._end(job, "failed")

    def _kill(self, job: Job) -> None:
        if not job.ended and job._process is not None:
            kill_group(job._process)
            self._end(job, "cancelled")

    def _end(self, job: Job, status: Status) -> None:
        job.status, job.remaining = status, None
        job.seconds = time.monotonic() - job._begun if job._begun else 0.0
        if job._channel is not None:
            job._channel.close()
        if job._process is not None:
            process, job._process = job._process, None
            self._let_end(process, job, 0.0 if status == "cancelled" else _POLITE)
        elif not job._begun:  # it has waited
            self.queue.leave(job)
        job._task, job._channel = None, None
        job._over.set()
        self._changed(job)

    def _let_end(self, process: SpawnProcess, job: Job, seconds: float) -> None:
        """Have a process end by itself for so long, then kill it and take its exit status: no zombie stays.  Its place
        is free when it has ended."""
        self._ending[process] = job
        end = time.monotonic() + seconds

        def look() -> None:
            if process not in self._ending:
                return
            if time.monotonic() >= end or wait([process.sentinel], 0):
                kill_group(process)  # and what it has started
                if _exit_code(process) is not None:
                    del self._ending[process]
                    self.queue.leave(job)
                    return
            asyncio.get_running_loop().call_later(_LOOK, look)

        look()


def _exit_code(process: SpawnProcess) -> int | None:
    """Exit status of a process, negative of a signal; None while it runs."""
    process.join(timeout=0.005)
    return process.exitcode


def work(connection: Connection, name: str, task: Task, nice: int = 0) -> None:
    """What the process of a job does: run the task, tell its progress, send its result or its error."""
    last = 0.0
    if nice and hasattr(os, "nice"):
        os.nice(nice)

    def progress(*done: float) -> None:
        nonlocal last
        while connection.poll():
            if connection.recv() == "cancel":
                raise _Stopped
        now = time.monotonic()
        if now - last > 0.1:
            last = now
            # a share, or points done of points
            share = done[0] if len(done) == 1 else done[0] / max(1.0, done[1])
            connection.send(("progress", float(share)))

    try:
        progress(0.0)
        frame, path, value = task(progress=progress)
        connection.send(("done", (None if frame is None else pack(frame), path, value)))
    except _Stopped:
        connection.send(("cancelled", None))
    except ModelError as error:
        connection.send(("failed", error))
    except Exception as error:
        connection.send(("failed", ModelError(f"{type(error).__name__}: {error}", path=name)))
    with suppress(OSError, EOFError):
        connection.close()


class _Stopped(BaseException):
    """Raised in the progress of a job that is to end; no handler of errors takes it for one."""
