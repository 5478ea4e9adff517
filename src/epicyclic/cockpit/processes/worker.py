"""Processes of the cockpit, and the live one: for all pages of a server, warm, one frame at a time, in turns.

They are started anew (spawn), in a group of their own, with one thread of linear algebra.  Their pipe is driven by two
threads: the event loop neither waits for a full pipe nor for an answer.
"""

from __future__ import annotations

import asyncio
import atexit
import itertools
import multiprocessing
import os
import queue
import signal
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from ...engine.workers import BLAS_THREADS, die_with_parent, keep_freed_memory, starting
from ...errors import ModelError
from ..state.frames import PageFrame, Request, failed_frame, pack


class Channel:
    """Messages of a process as calls in the event loop, and messages to it.

    arrived : called in the event loop with each message.  ended : called there once, when the process has closed its
        end.
    """

    def __init__(
        self, connection: Connection, *, arrived: Callable[[Any], None], ended: Callable[[], None] | None = None
    ) -> None:
        self._connection = connection
        self._loop = asyncio.get_running_loop()
        self._arrived, self._ended = arrived, ended
        self._out: queue.SimpleQueue[Any] = queue.SimpleQueue()
        threading.Thread(target=self._receive, daemon=True).start()
        threading.Thread(target=self._send, daemon=True).start()

    def send(self, message: Any) -> None:
        """Send a message, later where the pipe is full."""
        self._out.put(message)

    def close(self) -> None:
        """Send what waits, and close."""
        self._ended = None
        self._out.put(None)

    def _send(self) -> None:
        while (message := self._out.get()) is not None:
            try:
                self._connection.send(message)
            except Exception:  # the process is gone, which the other thread tells, or nobody can pickle that
                self._tell_end()
                break
        # the other thread still reads until the process closes its end

    def _receive(self) -> None:
        while True:
            try:
                message = self._connection.recv()
            except Exception:  # closed, or a message that nobody can read
                break
            self._call(self._arrived, message)
        self._connection.close()
        self._out.put(None)
        self._tell_end()

    def _tell_end(self) -> None:
        ended, self._ended = self._ended, None
        if ended is not None:
            self._call(ended)

    def _call(self, function: Callable[..., None], *arguments: Any) -> None:
        with suppress(RuntimeError):  # the loop is closed: nobody listens any more
            self._loop.call_soon_threadsafe(function, *arguments)


_CONTEXT = multiprocessing.get_context("spawn")
# The environment and the name of the main module are changed while a process starts.
_STARTING = threading.Lock()
# [s] after which the next process is started to wait: its imports take a second of a core that the first one needs.
_REFILL = 2.0

Started = tuple[SpawnProcess, Connection]
_started: weakref.WeakSet[SpawnProcess] = weakref.WeakSet()


@atexit.register
def _kill_all() -> None:
    """End what still runs when this process ends, which would wait for it else."""
    for process in list(_started):
        if process.is_alive():
            kill_group(process)


def spawned(function: Callable[..., None], *arguments: Any) -> Started:
    """A process that runs function(connection, *arguments), and this end of its pipe; Ctrl-C does not reach it.

    function : of a module, so that it can be pickled.
    """
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_begin, args=(function, theirs, *arguments), daemon=False)
    with _STARTING:
        before = {name: os.environ.get(name) for name in BLAS_THREADS}
        os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
        try:
            with starting("spawn"):  # Ctrl-C stays blocked until `_begin` ignores it: imports take half a second
                process.start()
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value
    theirs.close()
    _started.add(process)
    return process, ours


def kill_group(process: SpawnProcess) -> None:
    """Kill a process and those it has started."""
    if process.pid is None:
        return
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
    with suppress(OSError, ValueError):
        process.kill()


def waiting(connection: Connection) -> None:
    """What a process does that waits for its work: it imports, then runs function(connection, *arguments) once."""
    import_module("...verbs.record", __package__)
    import_module("..computing.compute", __package__)  # a second, and what nearly every job needs
    try:
        function, arguments = connection.recv()
    except (EOFError, OSError):
        return  # nobody needed it
    function(connection, *arguments)


# Processes beside the live one, of all pages together: jobs that run, and the one that waits.
_MOST_PROCESSES = 3
# Those of them that a person has started: short work that a window waits for has a place that no long job takes.
_MOST_JOBS = 2


class JobQueue:
    """The jobs of all pages of a server in the order in which they came; those whose turn it is have a process.

    freed : called where a process has ended and no job waits for its place.
    """

    def __init__(self) -> None:
        self.freed: Callable[[], None] = lambda: None
        self._running: dict[object, bool] = {}
        self._waiting: dict[object, tuple[bool, Callable[[], None]]] = {}

    @property
    def full(self) -> bool:
        return len(self._running) >= _MOST_PROCESSES

    def join(self, job: object, begin: Callable[[], None], *, short: bool) -> None:
        """Call `begin` as soon as it is the turn of a job, perhaps now.  short : a window waits for it."""
        self._waiting[job] = short, begin
        self._pump()

    def leave(self, job: object) -> None:
        """A job waits no more, or its process has ended."""
        self._waiting.pop(job, None)
        if self._running.pop(job, None) is not None:
            self._pump()
            self.freed()

    def stop(self) -> None:
        """Begin nothing more: the server ends."""
        self.freed = self._pump = lambda: None  # type: ignore[method-assign]

    def _pump(self) -> None:
        for job, (short, begin) in list(self._waiting.items()):
            jobs = sum(not running for running in self._running.values())
            if not self.full and (short or jobs < _MOST_JOBS):
                del self._waiting[job]
                self._running[job] = short
                begin()


class Spare:
    """One process that waits with its imports done, so that a job starts at once; a next one after each that is taken.

    The work is sent to it: ``(function, arguments)``.  queue : of the jobs that take the other places.
    """

    def __init__(self, queue: JobQueue | None = None) -> None:
        self._queue = queue or JobQueue()
        self._queue.freed = self._later
        self._process: Started | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._filling: asyncio.Task[None] | None = None
        self._stopped = False

    def fill(self) -> None:
        """Start a process where none waits and there is a place for it.  Needs a running event loop."""
        self._timer = None
        is_needed = self._process is None and not self._stopped and not self._queue.full
        if is_needed and (self._filling is None or self._filling.done()):
            self._filling = asyncio.get_running_loop().create_task(self._fill())

    async def _fill(self) -> None:
        try:
            started = await asyncio.to_thread(spawned, waiting)
        except OSError:
            return  # the next job says so
        if self._stopped or self._process is not None:
            await _end(started)
        else:
            self._process = started

    async def take(self) -> Started:
        """The process that waits, or a new one; its work is still to be sent. Raises OSError where none can start."""
        if self._filling is not None:
            await asyncio.wait({self._filling})
        started, self._process = self._process, None
        self._later()
        if started is not None and started[0].is_alive():
            return started
        return await asyncio.to_thread(spawned, waiting)

    def _later(self) -> None:
        """Start the next one in a while."""
        if self._timer is None and not self._stopped and self._process is None:
            self._timer = asyncio.get_running_loop().call_later(_REFILL, self.fill)

    async def stop(self) -> None:
        """End the process that waits."""
        self._stopped = True
        if self._timer is not None:
            self._timer.cancel()
        if self._filling is not None:
            await asyncio.wait({self._filling})
        started, self._process = self._process, None
        if started is not None:
            await _end(started)


async def _end(started: Started) -> None:
    process, connection = started
    connection.close()
    kill_group(process)
    await asyncio.to_thread(process.join)


def _begin(function: Callable[..., None], connection: Connection, *arguments: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if hasattr(os, "setpgid"):
        with suppress(OSError):
            os.setpgid(0, 0)
    threading.Thread(target=die_with_parent, daemon=True).start()
    keep_freed_memory()
    warnings.simplefilter("ignore")  # nobody reads the terminal; results carry their warnings
    # xarray would load dask.array with its first variable, as `cli.output` says; no work of the page is Dask's
    sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    function(connection, *arguments)


# the live process -----------------------------------------------------------------------------------------------------

# [s] that one frame may take: the slowest, a sweep with shaft orders of a train of several stages, takes some 20 s on a
# slow machine; what takes longer would keep every page waiting.
_LONGEST = 120.0
# Deaths in a row without a frame between them, after which the process is not started again for the same request.
_MOST_DEATHS = 2
# Starts in a row that end before the process is warm, after which pages are told; a next request tries again.
_MOST_STARTS = 3
# [s] that a frame may go on to be computed for a page that is closed, before its process is started anew.
_GONE = 4.0

# compute(request, stop=asked, early=sent), as `computing.compute.compute`
Compute = Callable[..., Iterator[PageFrame]]


@dataclass(slots=True, eq=False)
class _Task:
    """A request that the process works at.  hurried : it was told that somebody waits for something newer."""

    number: int
    request: Request
    hurried: bool = False


@dataclass(slots=True, eq=False)
class Client:
    """What a page waits for, and what of it runs.  deliver : called with each packed frame.

    idle : called when nothing of it is left.  early : called with packed frames ahead of the one at work.
    """

    deliver: Callable[[bytes], None]
    idle: Callable[[], None]
    early: Callable[[bytes], None] = lambda _: None
    waiting: Request | None = None
    task: _Task | None = None
    deaths: int = 0


@dataclass(slots=True, eq=False)
class Worker:
    """Frames for all clients from one process: each frame is finished and shown; then the next client has its turn.

    Of one client the newest request counts: it begins when the live frame at work is done, any other is given up, and
    the rest of what ran before is dropped.
    target : what the process runs; None: `serve`.  queue : of the jobs of all clients.
    spare : of jobs; None: each starts a process of its own.
    """

    target: Callable[[Connection], None] | None = None
    spare: Spare | None = None
    queue: JobQueue = field(default_factory=JobQueue)
    clients: list[Client] = field(default_factory=list)
    ready: asyncio.Event = field(default_factory=asyncio.Event)
    _process: SpawnProcess | None = None
    _channel: Channel | None = None
    _busy: Client | None = None
    _timer: asyncio.TimerHandle | None = None
    _numbers: Iterator[int] = field(default_factory=itertools.count)
    _starts: int = 0

    def start(self) -> None:
        """Start the process; it says by itself when it is warm.  Needs a running event loop."""
        if self._process is not None:
            return
        self._starts += 1
        self._process, connection = spawned(self.target or serve)
        channel = Channel(connection, arrived=self._arrived, ended=lambda: self._died(channel))
        self._channel = channel

    def join(self, client: Client) -> None:
        self.clients.append(client)

    def leave(self, client: Client) -> None:
        """Forget a client; what it runs is dropped after the frame at work."""
        client.waiting = None
        if client in self.clients:
            self.clients.remove(client)
        if self._busy is client:
            if client.task is not None and client.task.request.kind != "levers":  # these end soon by themselves
                asyncio.get_running_loop().call_later(_GONE, self._gone, client, client.task)
        elif client.task is not None:
            self._send(("drop", client.task.number))
            client.task = None

    def ask(self, client: Client, request: Request) -> None:
        """Have a request computed next; it takes the place of one that waits."""
        client.waiting = request
        if self._process is None:
            self._starts = 0
            self.start()
        task = client.task
        if self._busy is client and task is not None and task.request.kind == "full" and not task.hurried:
            task.hurried = True
            self._send(("hurry", task.number))
        self._pump()

    async def stop(self) -> None:
        """End the process at once."""
        process, self._process = self._process, None
        self._quiet()
        if self._channel is not None:
            self._channel.close()
            self._channel = None
        if process is not None:
            kill_group(process)
            await asyncio.to_thread(process.join)
        self.ready.clear()
        if self.spare is not None:
            await self.spare.stop()

    def _pump(self) -> None:
        """Have the process compute the next frame, of the client whose turn it is."""
        if self._busy is not None or not self.ready.is_set():
            return
        asking = (client for client in self.clients if client.waiting is not None or client.task is not None)
        client = next(asking, None)
        if client is None:
            return
        self.clients.remove(client)
        self.clients.append(client)
        self._busy = client
        if client.waiting is not None:
            if client.task is not None:
                self._send(("drop", client.task.number))
            client.task = _Task(next(self._numbers), client.waiting)
            client.waiting = None
            self._send(("run", client.task.number, client.task.request))
        elif client.task is not None:
            self._send(("next", client.task.number))
        self._timer = asyncio.get_running_loop().call_later(_LONGEST, self._too_long)

    def _arrived(self, message: tuple[str, int, Any]) -> None:
        kind, number, data = message
        if kind == "ready":
            self._starts = 0
            self.ready.set()
            self._pump()
            if self.spare is not None:
                self.spare.fill()
            return
        client = self._busy
        if client is None or client.task is None or client.task.number != number:
            return
        if kind == "early":
            client.early(data)
            return
        self._quiet()
        client.deaths = 0
        left = client not in self.clients
        if kind == "end" or left:
            if left and kind != "end":
                self._send(("drop", number))
            client.task = None
        if data is not None and not left:
            client.deliver(data)
        if client.task is None and client.waiting is None and not left:
            client.idle()
        self._pump()

    def _died(self, channel: Channel) -> None:
        """Start the process again; what was lost is asked for once more, then said to fail."""
        if channel is not self._channel:
            return  # stopped meanwhile
        process, self._process, self._channel = self._process, None, None
        if process is not None:
            kill_group(process)
            process.join(0.01)
        self.ready.clear()
        busy = self._busy
        self._quiet()
        given_up = self._starts >= _MOST_STARTS
        for client in list(self.clients):
            task, client.task = client.task, None
            if client.waiting is not None:
                client.deaths = 0  # what is newer has not been tried
            elif task is not None:
                client.deaths += client is busy
                client.waiting = task.request
            if client.waiting is not None and (given_up or client.deaths >= _MOST_DEATHS):
                request, client.waiting, client.deaths = client.waiting, None, 0
                how = "cannot be started" if given_up else "ended by itself twice"
                _fail(client, request, f"the computing process {how}")
        if not given_up:
            self.start()

    def _gone(self, client: Client, task: _Task | None) -> None:
        """Stop computing for a page that is closed."""
        if self._busy is client and client.task is task and self._process is not None:
            kill_group(self._process)

    def _too_long(self) -> None:
        client = self._busy
        if client is not None and client.task is not None:
            client.deaths = _MOST_DEATHS  # the same again would take as long
            _fail(client, client.task.request, f"takes longer than {_LONGEST:g} s")
            client.task = None
        if self._process is not None:
            kill_group(self._process)

    def _quiet(self) -> None:
        self._busy = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _send(self, message: object) -> None:
        if self._channel is not None:
            self._channel.send(message)


def _fail(client: Client, request: Request, why: str) -> None:
    client.deliver(pack(failed_frame(request.rev, ModelError(why, path="model"))))
    if client.waiting is None:
        client.idle()


def serve(connection: Connection) -> None:
    """What the process does: frames of several requests, one when it is asked for."""
    from ..computing.compute import compute, warm_up

    warm_up()
    serve_with(connection, compute)


def serve_with(connection: Connection, compute: Compute) -> None:
    """The same with another function that computes."""
    connection.send(("ready", 0, None))
    running: dict[int, tuple[Request, Iterator[PageFrame]]] = {}
    while True:
        try:
            kind, number, *rest = connection.recv()
        except (EOFError, OSError):
            return
        if kind == "drop":
            running.pop(number, None)
        elif kind in ("run", "next"):
            if kind == "run":
                stop = _hurry(connection, number, running)
                running[number] = (rest[0], iter(compute(rest[0], stop=stop, early=_sent(connection, number))))
            data = _next_frame(*running[number]) if number in running else None
            last = data is None or running[number][0].kind != "full"
            if last:
                running.pop(number, None)
            connection.send(("end" if last else "frame", number, data))


def _sent(connection: Connection, number: int) -> Callable[[PageFrame], None]:
    """Sends a frame ahead of the one that the task of this number is at."""
    return lambda frame: connection.send(("early", number, pack(frame)))


def _hurry(
    connection: Connection, number: int, running: dict[int, tuple[Request, Iterator[PageFrame]]]
) -> Callable[[], bool]:
    """Whether the task of this number is to be given up; others are dropped meanwhile."""

    def asked() -> bool:
        try:
            while connection.poll():
                kind, other = connection.recv()
                if kind == "drop":
                    running.pop(other, None)
                elif other == number:
                    return True
        except (EOFError, OSError):
            return True  # nobody is there
        return False

    return asked


def _next_frame(request: Request, frames: Iterator[PageFrame]) -> bytes | None:
    """The next frame, packed; None after the last one.  A fault of ours becomes a frame too: nobody sees a terminal."""
    try:
        frame = next(frames, None)
        return None if frame is None else pack(frame)
    except Exception as error:
        return pack(failed_frame(request.rev, error))


_shared: list[Worker] = []


def start_worker() -> Worker:
    """The worker of this server, started when first asked for.  Needs a running event loop."""
    if not _shared:
        queue = JobQueue()
        _shared.append(Worker(spare=Spare(queue), queue=queue))
    _shared[0].start()
    return _shared[0]


async def stop_worker() -> None:
    """End the worker of this server."""
    while _shared:
        await _shared.pop().stop()
