"""Long work of one page: a process for each job, with progress, time left, and an end on request."""

from __future__ import annotations

import asyncio
import itertools
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any, Literal

from ...errors import ModelError
from ..state.frames import PageFrame, pack, unpack
from ..state.state import Origin
from .spawned import Channel, Spare, kill_group, spawned, waiting
from .tasks import Loadable, Task, task_of

# Jobs that run at once: the machine has live work too.
_MOST_AT_ONCE = 2
# Short work that a person waits for, beside them: levers of a model, a comparison, a file.
_MOST_HIDDEN = 2
# Priority of a job below the live process (nice): a slider answers while jobs take all cores.
_NICE = 10
# Jobs of a page that are kept with their results, the oldest ended ones forgotten first.
_MOST_KEPT = 24
# [s] that a job may take to end politely before its process is killed.
_POLITE = 1.0
# Share done below which the time left is not told: the first parts say little of the rest.
_TELLING = 0.02

Status = Literal["waits", "runs", "done", "cancelled", "failed"]


@dataclass(slots=True, eq=False)
class Job:
    """One job.  rev : newest state it belongs to.  model : what that is computed of.  progress : 0..1.

    origin : model file of the state, as of `PageState`; None where it is of none.
    remaining : [s], None where it is not known yet.
    message : why it failed.  frame, packed : its result for the page.  value : another result.
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
    frame: PageFrame | None = None
    packed: bytes | None = None
    dataset_path: Path | None = None
    value: Any = None
    error: ModelError | None = None
    hidden: bool = False
    model: object = None
    origin: Origin | None = None
    seconds: float = 0.0
    _task: Task | None = None
    _process: SpawnProcess | None = None
    _channel: Channel | None = None
    _begun: float = 0.0
    _over: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def ended(self) -> bool:
        return self.status in ("done", "cancelled", "failed")

    async def wait(self) -> None:
        """Wait until it has ended."""
        await self._over.wait()


def jobs_done(jobs: Sequence[Job], rev: int) -> dict[str, Job]:
    """Name -> the newest job of the state with this number whose Dataset is there."""
    return {job.name: job for job in jobs if job.rev == rev and job.status == "done" and job.dataset_path is not None}


def newest_of(jobs: Sequence[Job], rev: int, origin: object) -> dict[str, Job]:
    """Name -> the job that says most of the state with this number: one that runs or has ended for it; else one of
    another state of the same model file that runs, or the newest that was done.  What was refused or cancelled of
    another state says nothing of this one."""
    newest: dict[str, Job] = {}

    def says(job: Job) -> tuple[bool, bool]:
        return not job.ended, job.rev == rev

    for job in jobs:
        if job.rev != rev and (job.origin != origin or job.status in ("failed", "cancelled")):
            continue
        if job.name not in newest or says(job) >= says(newest[job.name]):
            newest[job.name] = job
    return newest


class Jobs:
    """The jobs of a page, oldest first.

    changed : called in the event loop after each change.  spare : of processes that wait; None: each starts its own.
    """

    def __init__(self, changed: Callable[[Job], None], spare: Spare | None = None) -> None:
        self.all: list[Job] = []
        self.spare = spare
        self._changed = changed
        self._numbers = itertools.count(1)
        self._folder: Path | None = None
        self._closed = False
        self._starting: set[asyncio.Task[None]] = set()
        self._ending: set[SpawnProcess] = set()

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
        task = task_of(name, dict(options), model, rev, self.folder / f"job-{number}")
        job = Job(
            id=number, name=name, label=task.label, rev=rev, hidden=hidden, model=model, origin=origin, _task=task
        )
        self.all.append(job)
        ended = [job for job in self.all if job.ended]
        for old in ended[: max(0, len(self.all) - _MOST_KEPT)]:
            self.forget(old)
        self._changed(job)
        self._pump()
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
        for process in tuple(self._ending):  # one may end meanwhile
            await asyncio.to_thread(process.join)
        self._ending.clear()
        if self._folder is not None:
            await asyncio.to_thread(shutil.rmtree, self._folder, True)

    def _pump(self) -> None:
        for hidden, most in ((False, _MOST_AT_ONCE), (True, _MOST_HIDDEN)):
            alike = [job for job in self.all if job.hidden is hidden]
            running = sum(job.status == "runs" for job in alike)
            for job in [job for job in alike if job.status == "waits"][: max(0, most - running)]:
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
            self._end(job, "failed")
            return
        if job.ended:  # cancelled meanwhile
            connection.close()
            self._let_end(process, 0.0)
            return
        job._process = process
        job._channel = Channel(
            connection,
            arrived=lambda message: self._arrived(job, message),
            ended=lambda: self._died(job),
        )
        job._channel.send((work, (job._task, 0 if job.hidden else _NICE)))

    def _arrived(self, job: Job, message: tuple[str, Any]) -> None:
        if job.ended:
            return
        kind, content = message
        if kind == "progress":
            spent = time.monotonic() - job._begun
            job.progress = max(job.progress, min(1.0, float(content)))
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
        """The page shows a state with a new number: jobs of the same model belong to it."""
        for job in self.visible():
            if job.model == model:
                self._number(job, rev)

    def _died(self, job: Job) -> None:
        if not job.ended:
            job.message = "its process ended by itself"
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
            self._let_end(process, 0.0 if status == "cancelled" else _POLITE)
        job._task, job._channel = None, None
        job._over.set()
        self._changed(job)
        if not self._closed:
            self._pump()

    def _let_end(self, process: SpawnProcess, seconds: float) -> None:
        """Have a process end by itself for so long, then kill it and take its exit status: no zombie stays."""
        self._ending.add(process)
        asyncio.get_running_loop().call_later(seconds, self._reap, process)

    def _reap(self, process: SpawnProcess) -> None:
        if process in self._ending:
            kill_group(process)
            process.join(timeout=0.005)
            if process.exitcode is None:
                asyncio.get_running_loop().call_later(0.1, self._reap, process)
            else:
                self._ending.discard(process)


def work(connection: Connection, task: Task, nice: int = 0) -> None:
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
        frame, path, value = task.function(*task.arguments, progress=progress)
        connection.send(("done", (None if frame is None else pack(frame), path, value)))
    except _Stopped:
        connection.send(("cancelled", None))
    except ModelError as error:
        connection.send(("failed", error))
    except Exception as error:
        connection.send(("failed", ModelError(f"{type(error).__name__}: {error}", path=task.name)))
    with suppress(OSError, EOFError):
        connection.close()


class _Stopped(BaseException):
    """Raised in the progress of a job that is to end; no handler of errors takes it for one."""
