"""Processes of the cockpit: started anew (spawn), in a group of their own, with one thread of linear algebra.

Their pipe is driven by two threads: the event loop neither waits for a full pipe nor for an answer.
"""

from __future__ import annotations

import asyncio
import atexit
import multiprocessing
import os
import queue
import signal
import threading
import warnings
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from ...engine.workers import BLAS_THREADS, die_with_parent, without_script


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
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:
            pass  # the loop is closed: nobody listens any more


_CONTEXT = multiprocessing.get_context("spawn")
# The environment and the name of the main module are changed while a process starts.
_STARTING = threading.Lock()
# [s] after which the next process is started to wait: its imports take a second of a core that the first one needs.
_REFILL = 2.0

# What the imports of nearly every job take a second for.
_IMPORTED = ("...results.dataset", "...verbs.record", "..computing.compute")

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
            with without_script(), _without_interrupts():
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


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Ctrl-C blocked in a process that starts meanwhile, until `_begin` ignores it: its imports take half a second."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # its own start would unblock them
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def kill_group(process: SpawnProcess) -> None:
    """Kill a process and those it has started."""
    if process.pid is None:
        return
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    with suppress(OSError, ValueError):
        process.kill()


def waiting(connection: Connection) -> None:
    """What a process does that waits for its work: it imports, then runs function(connection, *arguments) once."""
    for needed in _IMPORTED:
        import_module(needed, __package__)
    try:
        function, arguments = connection.recv()
    except (EOFError, OSError):
        return  # nobody needed it
    function(connection, *arguments)


class Spare:
    """One process that waits with its imports done, so that a job starts at once; a next one after each that is taken.

    The work is sent to it: ``(function, arguments)``.
    """

    def __init__(self) -> None:
        self._process: Started | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._filling: asyncio.Task[None] | None = None
        self._stopped = False

    def fill(self) -> None:
        """Start a process where none waits.  Needs a running event loop."""
        self._timer = None
        if self._process is None and not self._stopped and (self._filling is None or self._filling.done()):
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
        started, self._process = self._process, None
        if self._timer is None and not self._stopped:
            self._timer = asyncio.get_running_loop().call_later(_REFILL, self.fill)
        if started is not None and started[0].is_alive():
            return started
        return await asyncio.to_thread(spawned, waiting)

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
    warnings.simplefilter("ignore")  # nobody reads the terminal; results carry their warnings
    function(connection, *arguments)
