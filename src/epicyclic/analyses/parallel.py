"""Independent points of one analysis on several cores: worker processes, started where the work left pays for them.

Every point is computed by one function of its own item alone, in the same environment in this process and in a
worker, so a result has the same bits for any number of processes.

Workers are forked on Linux; they inherit the arrays.  Elsewhere they are started anew; they then import the module of
the function, but not the script that runs, which needs no guard.  Workers die with the process that started them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import ModuleType
from typing import Any, TypeVar

from ..errors import ModelError

__all__ = ["each", "processes"]

Item = TypeVar("Item")
Result = TypeVar("Result")

# Seconds of work left from which workers pay: their start takes 0.03 s forked and some 1.5 s of imports started anew.
_WORTH = {"fork": 0.3, "spawn": 5.0}
# Windows waits for at most 63 handles.
_MOST = 60
# Variables that set the threads of the libraries of linear algebra, which read them when they are loaded.
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "OMP_NUM_THREADS")

# The function of the points in a worker, None in a process that is none.
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
    return max(1, min(_cores() // _linear_algebra_threads(), _MOST))


def _cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _linear_algebra_threads() -> int:
    """Threads of one process in linear algebra, as the environment says; else it takes all cores."""
    told = (os.environ.get(name, "") for name in _THREADS)
    return next((int(count) for count in told if count.isdigit() and int(count)), _cores())


def each(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    arrived: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """work(item) of every item, in the order of the items.

    Points are computed here until it is known how long they take; the rest goes to workers where that pays.

    Parameters
    ----------
    work : a function of a module, or `functools.partial` of one; pickled where workers are not forked, like the items
        and always the results.  arrived : called here with the place and the result of every item, as they arrive.

    Raises
    ------
    Whatever `work` or `arrived` raises; the other items are then given up, and so they are on Ctrl-C.
    """
    results: dict[int, Result] = {}

    def keep(place: int, result: Result) -> None:
        results[place] = result
        if arrived is not None:
            arrived(place, result)

    most, method = processes(), "fork" if sys.platform == "linux" else "spawn"
    start = time.perf_counter()
    for place, item in enumerate(items):
        left = len(items) - place
        spent = time.perf_counter() - start
        if place and most > 1 and left > 1 and spent / place * left > _WORTH[method]:
            try:
                _by_workers(work, items, range(place, len(items)), keep, count=min(most, left), method=method)
            except (BrokenProcessPool, OSError, NotImplementedError):
                # no process may be started here, or one was killed: this process does what is left
                for missing in sorted(set(range(len(items))) - results.keys()):
                    keep(missing, work(items[missing]))
            break
        keep(place, work(item))
    return [results[place] for place in range(len(items))]


def _by_workers(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    places: range,
    keep: Callable[[int, Result], None],
    *,
    count: int,
    method: str,
) -> None:
    """Compute the items at `places` by `count` workers; `keep` takes place and result of each as it arrives."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        count, mp_context=multiprocessing.get_context(method), initializer=_become_worker, initargs=(work,)
    )
    try:
        with _starting(method):
            waiting = {pool.submit(_compute, items[place]): place for place in places}
        for future in as_completed(waiting):
            keep(waiting[future], future.result())
    except BaseException:
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _become_worker(work: Callable[[Any], Any]) -> None:
    """Make this process a worker: Ctrl-C is for the process that started it, with which it dies."""
    global _work
    _work = work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a thread of the process forked may have held the lock of a stream, which nothing would give back here
    sys.stdout = sys.stderr = open(os.devnull, "w")
    threading.Thread(target=_die_with_parent, daemon=True).start()


def _die_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _compute(item: Any) -> Any:
    """Result of one item in a worker."""
    assert _work is not None
    return _work(item)


@contextmanager
def _starting(method: str) -> Iterator[None]:
    """Start workers: without the script that runs, and with Ctrl-C held back until all of them stand.

    Processes started anew would run the script again, of which they need nothing.  Held back, Ctrl-C meets no process
    half started, and workers inherit that.
    """
    main = sys.modules["__main__"]
    if method == "spawn":
        sys.modules["__main__"] = ModuleType("__main__")
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
    try:
        with warnings.catch_warnings():
            # Python warns of forks beside other threads; a worker only computes, and takes no lock of theirs
            warnings.filterwarnings("ignore", ".*fork", DeprecationWarning)
            yield
    finally:
        sys.modules["__main__"] = main
        if held is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)
