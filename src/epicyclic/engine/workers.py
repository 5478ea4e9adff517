"""Independent points, or runs, of one analysis on several cores: worker processes, started where they pay.

Every point is computed by one function of its own item alone, and a run by one generator, in the same environment in
this process and in a worker, so a result has the same bits for any number of processes.

Workers are forked on Linux; they inherit the arrays.  Elsewhere they are started anew; they then import the module of
the function, but not the script that runs, which needs no guard.  Workers die with the process that started them.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import queue
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ModelError

if TYPE_CHECKING:
    from .run_folder import KeptPart, RunFolder

Item = TypeVar("Item")
Result = TypeVar("Result")

# Seconds of work left from which workers pay: their start takes 0.03 s forked and some 1.5 s of imports started anew.
_WORTH = {"fork": 0.3, "spawn": 5.0}
# Windows waits for at most 63 handles.
_MOST = 60
# Places that a worker has at a time: one at work and the next, so that it need not wait for this process.
_AHEAD = 2
# Seconds without a result of a worker after which those that have come are written.
_IDLE = 1.0
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "OMP_NUM_THREADS")
"""Variables that set the threads of the libraries of linear algebra, which read them when they are loaded."""


# Parameters of mallopt (malloc.h of the GNU C library): memory that may stay free, size from which an array is mapped
# by itself [bytes].
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3
_KEPT_FREE, _MAPPED = 2**28, 2**26

# What a worker computes, None in a process that is none.
_work: Callable[[Any], Any] | None = None


def processes() -> int:
    """Processes that may compute at once.

    The variable EPICYCLIC_JOBS of the environment, else the cores this process may use, divided by the threads that
    linear algebra takes of each (OPENBLAS_NUM_THREADS and its like, which the command line sets to 1): one process
    where these are not limited.  One in a worker, and wherever no process may be started.

    Raises
    ------
    ModelError : EPICYCLIC_JOBS is no whole number above 0.
    """
    wanted = os.environ.get("EPICYCLIC_JOBS", "").strip()
    if wanted and not (wanted.isascii() and wanted.isdigit() and int(wanted)):
        raise ModelError("not a number of processes", path="EPICYCLIC_JOBS", given=wanted, allowed="1, 2, 3, ...")
    if _work is not None or multiprocessing.current_process().daemon:
        return 1
    if wanted:
        return min(int(wanted), _MOST)
    cores = _cores()
    settings = (os.environ.get(name, "") for name in BLAS_THREADS)
    threads = next((int(count) for count in settings if count.isdigit() and int(count)), cores)
    return max(1, min(cores // threads, _MOST))


def _cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    arrived: Callable[[int, Result], None] | None = None,
    kept: KeptPart | None = None,
    meanwhile: Callable[[], object] | None = None,
    workers: bool = True,
    pickled: bool = True,
    long: bool = False,
) -> list[Result]:
    """work(item) of every item, in the order of the items.

    Points are computed here until it is known how long they take; the rest goes to workers where that pays.

    Parameters
    ----------
    work : a function of a module, or `functools.partial` of one; pickled where workers are not forked, like the items
        and always the results.  arrived : called here with the place and the result of every item, as they arrive.
    kept : takes every new result; those that a run before has left there arrive first and are not computed again.
    meanwhile : called once here while workers compute, such as an import that results need; not where none are tried.
    workers : whether there may be any.  pickled : whether `work` can be; else there are some where they are forked.
    long : whether every item is known to take so long that workers pay from the first on.

    Raises
    ------
    Whatever `work` or `arrived` raises; the other items are then given up, and so they are on Ctrl-C.
    """
    results: dict[int, Result] = {}

    def enter(place: int, result: Result) -> None:
        results[place] = result
        if arrived is not None:
            arrived(place, result)

    def keep(place: int, result: Result) -> None:
        if kept is not None:
            kept.add(place, result)
        enter(place, result)

    def at_ease() -> None:
        """What this raises is raised again where it is needed."""
        if meanwhile is not None:
            with suppress(Exception):
                meanwhile()

    if kept is not None:
        for place, result in sorted(kept.known.items()):
            enter(place, result)
    method = "fork" if sys.platform == "linux" else "spawn"
    most = processes() if workers and (pickled or method == "fork") else 1
    start, places = time.perf_counter(), [place for place in range(len(items)) if place not in results]
    for done, place in enumerate(places):
        left = len(places) - done
        spent = time.perf_counter() - start
        if most > 1 and left > 1 and (long or (done and spent / done * left > _WORTH[method])):
            count, folder = min(most, left), None if kept is None else kept.of
            with _workers(
                partial(_alone, work), items, places[done:], keep, folder, count=count, method=method
            ) as take:
                # beside this thread, which gives the workers their next places
                beside = threading.Thread(target=at_ease, daemon=True)
                beside.start()
                take()
                beside.join()
            # none may be started here, or one may have been killed: this process does what is left
            for missing in sorted(set(range(len(items))) - results.keys()):
                keep(missing, work(items[missing]))
            break
        keep(place, work(items[place]))
    return [results[place] for place in range(len(items))]


def _alone(work: Callable[[Item], Result], item: Item) -> tuple[Result]:
    """A point as a run of one result."""
    return (work(item),)


def runs(
    work: Callable[[Item], Iterable[Result]],
    items: Sequence[Item],
    *,
    arrived: Callable[[int, Result], None],
    long: bool = False,
    kept: RunFolder | None = None,
) -> None:
    """Results of runs, each of which computes its points in turn: a run in one process, several at once.

    The first run is computed here.  Others get workers of their own as soon as it has taken so long that they pay.

    Parameters
    ----------
    work : as of `each`, gives the results of a run in turn; in a worker it does not see what other runs have changed.
    arrived : called here with the place of the run and a result, as they arrive; those of one run in their order.
    long : whether every run is known to take so long that workers pay from the start.
    kept : in which `arrived` keeps the results.

    Raises
    ------
    Whatever `work` or `arrived` raises; the other runs are then given up, and so they are on Ctrl-C.
    """
    method, begin = "fork" if sys.platform == "linux" else "spawn", time.perf_counter()
    others, elsewhere, seen = range(1, min(processes(), len(items))), range(0), [0] * len(items)

    def keep(place: int, result: Result) -> None:
        seen[place] += 1
        arrived(place, result)

    def take(*, wait: bool = True) -> set[int]:
        """Nothing comes as long as there are no workers."""
        return set()

    with ExitStack() as stack:
        for place, item in enumerate(items):
            if place in elsewhere:
                continue
            for result in work(item):
                keep(place, result)
                if place == 0 and elsewhere != others and (long or time.perf_counter() - begin > _WORTH[method]):
                    elsewhere = others
                    started = _workers(work, items, others, keep, kept, count=len(others), method=method)
                    take = stack.enter_context(started)
                take(wait=False)
        for place in sorted(set(elsewhere) - take()):
            # a worker was killed: this process does what is left
            for number, result in enumerate(work(items[place])):
                if number >= seen[place]:
                    keep(place, result)


@contextmanager
def _workers(
    work: Callable[[Item], Iterable[Result]],
    items: Sequence[Item],
    places: Iterable[int],
    keep: Callable[[int, Result], None],
    kept: RunFolder | None,
    *,
    count: int,
    method: str,
) -> Iterator[Callable[..., set[int]]]:
    """Workers, as many as may be started, at the items at `places`: each has the next one as soon as it has ended one.

    Yields a function by which `keep` takes place and result of all that has come, those of an item in their order, and
    with ``wait`` of all that comes.  It gives the places that are whole: those of a worker that was killed are not.
    Workers hold nothing that this process waits for, so that they can be ended at any instant.

    kept : in which `keep` keeps the results; while none comes, what has come is written.
    """
    inbox, workers = queue.SimpleQueue[tuple[int, Any]](), list[tuple[BaseProcess, Connection]]()
    context: Any = multiprocessing.get_context(method)
    waiting, whole = iter(places), set[int]()
    at_work = [0] * count  # places of each

    def receive(number: int, connection: Connection) -> None:
        """Bring what a worker sends to the inbox, so that it need not wait until this process is free for it."""
        with suppress(EOFError, OSError):
            while True:
                inbox.put((number, connection.recv()))
        inbox.put((number, None))

    def give(number: int) -> None:
        """Send a worker the next place, if any."""
        place = next(waiting, None)
        if place is not None:
            with suppress(OSError):  # the end of a worker that was killed comes through the inbox
                workers[number][1].send(place)
            at_work[number] += 1

    def take(*, wait: bool = True) -> set[int]:
        while any(at_work) and (wait or not inbox.empty()):
            try:
                number, message = inbox.get(timeout=_IDLE)
            except queue.Empty:
                if kept is not None:
                    kept.write()
                continue
            if message is None:
                at_work[number] = 0
                continue
            place, more, content = message
            if more:
                keep(place, content)
            elif content is not None:
                raise content
            else:
                whole.add(place)
                at_work[number] -= 1
                give(number)
        return whole

    try:
        with suppress(OSError, NotImplementedError), starting(method):
            for _ in range(count):
                here, there = context.Pipe()
                worker = context.Process(target=_serve, args=(work, items, there), daemon=True)
                try:
                    worker.start()
                finally:
                    there.close()
                workers.append((worker, here))
        for number, (_, connection) in enumerate(workers):
            threading.Thread(target=receive, args=(number, connection), daemon=True).start()
        for number in [*range(len(workers))] * _AHEAD:
            give(number)
        yield take
    finally:
        for worker, _ in workers:
            worker.terminate()
        for worker, _ in workers:
            worker.join()


def _serve(work: Callable[[Any], Iterable[Any]], items: Sequence[Any], connection: Connection) -> None:
    """A worker: of every item whose place it is sent the results, then the end or what it has raised."""
    _become_worker(work)
    while True:
        place, failed = connection.recv(), None
        try:
            for result in work(items[place]):
                connection.send((place, True, result))
        except Exception as error:
            failed = error
        connection.send((place, False, failed))


def _become_worker(work: Callable[[Any], Any]) -> None:
    """Make this process a worker: Ctrl-C is for the process that started it, with which it dies."""
    global _work
    _work = work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a thread of the process forked may have held the lock of a stream, which nothing would give back here
    sys.stdout = sys.stderr = open(os.devnull, "w")
    threading.Thread(target=die_with_parent, daemon=True).start()


def die_with_parent() -> None:
    """End this process when the one that started it ends, and its group where it leads one; for a thread of its own."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    parent.join()
    if hasattr(os, "killpg") and os.getpgid(0) == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(1)


@contextmanager
def _without_script() -> Iterator[None]:
    """Start processes anew without the script that runs: they would run it again, of which they need nothing."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def starting(method: str) -> Iterator[None]:
    """Start processes, forked or anew: these without the script that runs, and with Ctrl-C held back until all stand.

    Held back, Ctrl-C meets no process half started, and workers inherit that.
    """
    if method == "spawn" and hasattr(signal, "pthread_sigmask"):
        # its start lets Ctrl-C in again, so it comes before Ctrl-C is held back
        from multiprocessing import resource_tracker

        resource_tracker.ensure_running()
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
    try:
        with _without_script() if method == "spawn" else warnings.catch_warnings():
            if method == "fork":
                # Python warns of forks beside other threads; a worker only computes, and takes no lock of theirs
                warnings.filterwarnings("ignore", ".*fork", DeprecationWarning)
            yield
    finally:
        if held is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)


@contextmanager
def one_thread() -> Iterator[str]:
    """Let linear algebra take one thread in the block, where threadpoolctl is installed; the command line sets the
    environment.

    Yields the number of threads as far as it is known: ``1``, a number of the environment, or ``unknown``.
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        yield next((os.environ[name] for name in BLAS_THREADS if os.environ.get(name, "").isdigit()), "unknown")
        return
    with threadpool_limits(limits=1, user_api="blas"):
        yield "1"


def keep_freed_memory() -> None:
    """Let the C library of Linux keep what arrays free: pages that are asked for anew take longer than to be filled.

    For a process of our own, whose forked workers inherit it; a sampling of tolerances takes a fifth less.
    """
    if sys.platform != "linux":
        return
    with suppress(OSError, AttributeError):  # a C library without mallopt
        library = ctypes.CDLL(None)
        library.mallopt(_M_TRIM_THRESHOLD, _KEPT_FREE)
        library.mallopt(_M_MMAP_THRESHOLD, _MAPPED)


def import_results() -> None:
    """Import what a result is made and shown with: a quarter of a second, in which this process has nothing to do."""
    from ..results import dataset  # noqa: F401
