"""Blocks of a job by the workers of a Dask scheduler, as they arrive; a window of them at a time.

A scheduler runs already, or a cluster on this machine is started in a process of its own that lives until its standard
input ends.  It stands apart from the process that asks, so that Ctrl-C reaches the client alone, no script is run again
in the workers, and the cluster ends with its client, however that ends.
"""

from __future__ import annotations

import asyncio
import os
import pickle
import queue
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from logging import getLogger, root
from pathlib import Path
from tempfile import TemporaryFile
from types import FrameType
from typing import Any, cast

from ..errors import ModelError
from .block_store import INSTALL, Arrays
from .run_folder import versions

_START = f"import sys; from {__name__} import serve; serve(int(sys.argv[1]))"
# Seconds in which the processes of a cluster end by themselves; then they are killed.
_END = 2.0
# Seconds between two looks at the workers, and Dask's time after which one that has not come back is given up: its
# start takes two, several times that on a busy machine.
_LOOK_AT_CLUSTER, _LOST = 1.0, "15s"
# Deaths of workers that one block may meet: more than the twenty kills that a job must stand, few enough that a block
# that kills its workers ends within a minute or two.
_DEATHS = 30
# Seconds to reach a scheduler; Dask's own 30 are longer than a person with a wrong address waits.
_CONNECT = 8.0
# Seconds between two looks at the connection while nothing arrives, and at the number of workers.
_LOOK = 0.5
_COUNT = 2.0
# Blocks at work or waiting for an earlier one, per thread, and at least: two keep a worker busy while its result
# travels, the others let it go on while a block that was lost with its worker is computed again.
_AHEAD, _LEAST = 4, 16
# Level of a logger above all messages.
_SILENT = 60
# Times a block is given to an existing scheduler, which lets it go after four deaths of workers unless told otherwise.
_GIVEN = 8


# --- a cluster on this machine ---------------------------------------------------------------------------------------


def serve(workers: int) -> None:
    """Run a cluster of so many workers, say its address on stdout, and end with stdin."""
    import dask
    from distributed import LocalCluster

    dask.config.set(
        {"distributed.scheduler.allowed-failures": _DEATHS, "distributed.deploy.lost-worker-timeout": _LOST}
    )
    ended = threading.Event()

    def wait() -> None:
        sys.stdin.read()
        ended.set()

    async def mended() -> None:  # in the loop of the cluster
        mend(cluster, workers)

    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        worker_dashboard_address=None,
        # no limit: a worker near one would pause, and the job with it
        memory_limit=0,
        silence_logs=50,
    ) as cluster:
        sys.stdout.write(f"{cluster.scheduler_address}\n")
        sys.stdout.flush()
        threading.Thread(target=wait, daemon=True).start()
        while not ended.wait(_LOOK_AT_CLUSTER):
            cluster.sync(mended)


def mend(cluster: Any, workers: int) -> None:
    """Put new workers in place of those that are gone for good.

    A worker that is killed is started again by its nanny, but a nanny whose worker is killed while it starts gives up.
    """
    from distributed.core import Status

    for name, nanny in list(cluster.workers.items()):
        if nanny.status in (Status.closed, Status.failed):
            del cluster.workers[name]
    cluster.scale(workers)


@contextmanager
def local_cluster(workers: int) -> Iterator[str]:
    """Address of the scheduler of a new cluster on this machine, one thread a worker, which lives as the block runs.

    Raises
    ------
    ModelError : it does not start.
    """
    # the packages of this process, wherever it has found them
    paths = [str(Path(__file__).resolve().parents[3]), *(os.path.abspath(path) for path in sys.path)]
    told = TemporaryFile("w+", errors="replace")
    process = subprocess.Popen(
        [sys.executable, "-c", _START, str(workers)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=told,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "EPICYCLIC_JOBS": "1"},
        start_new_session=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        address = process.stdout.readline().strip()
        if not address:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_END)
            told.seek(0)
            lines = [line.strip() for line in told if line.strip()]
            last_line = f": {lines[-1]}" if lines else ""
            raise ModelError(
                f"the local cluster does not start{last_line}",
                path="workers",
                given=workers,
                allowed="no workers, or an address of a scheduler that runs",
            )
        yield address
    finally:
        with suppress(OSError):
            process.stdin.close()
        try:
            process.wait(_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
        told.close()


# --- blocks ----------------------------------------------------------------------------------------------------------


def computed(
    compute: Callable[[int], Arrays],
    places: Sequence[int],
    *,
    workers: int | None,
    scheduler: str | None,
) -> Iterator[tuple[int, Arrays]]:
    """Place and arrays of every block, as they arrive, of workers that have the versions of this process.

    Parameters
    ----------
    workers : of a local cluster, or scheduler : address of another.

    Raises
    ------
    ModelError : no Dask, no scheduler at the address, a connection that breaks, workers of other versions, a block that
        kills its workers.  Whatever a block raises, after the others at work have arrived.
    """
    _require_dask(workers, scheduler)
    import cloudpickle

    with ExitStack() as stack:
        address = scheduler if scheduler is not None else stack.enter_context(local_cluster(workers or 1))
        client = stack.enter_context(_client(address))
        look = stack.enter_context(_interruptible())
        for result in _Run(client, address, cloudpickle.dumps((compute, versions())), places).results(look):
            look()
            yield result


def _require_dask(workers: int | None, scheduler: str | None) -> None:
    if "dask" in sys.modules and sys.modules["dask"] is None:  # left out by the command line (`cli/output.py`)
        del sys.modules["dask"]
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        path, given = ("workers", workers) if scheduler is None else ("scheduler", scheduler)
        raise ModelError(
            f"needs dask and distributed, which are not installed ({error})",
            path=path,
            given=given,
            allowed=f"{INSTALL}, or one process",
        ) from error


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """A client of the scheduler at an address."""
    from distributed import Client

    # the loggers of Dask say nothing: what goes wrong is said by errors of our own
    names = ["distributed", *(name for name in root.manager.loggerDict if name.startswith("distributed."))]
    levels = {name: getLogger(name).level for name in names}
    try:
        for name in names:
            getLogger(name).setLevel(_SILENT)
        _require_scheduler(address)
        client = Client(address, timeout=_CONNECT, set_as_default=False)  # type: ignore[no-untyped-call]
        try:
            yield client
        finally:
            with suppress(Exception):  # the scheduler may be gone
                client.close(timeout=2)  # type: ignore[no-untyped-call]
    finally:
        for name, level in levels.items():
            getLogger(name).setLevel(level)


@contextmanager
def _interruptible() -> Iterator[Callable[[], None]]:
    """Yields a function that raises KeyboardInterrupt where Ctrl-C was pressed since the block began.

    Ctrl-C raises it at once too, but inside a destructor Python drops what is raised, and futures have one.
    """
    pressed = threading.Event()

    def press(number: int, frame: FrameType | None) -> None:
        pressed.set()
        signal.default_int_handler(number, frame)

    def look() -> None:
        if pressed.is_set():
            raise KeyboardInterrupt

    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield look
        return
    signal.signal(signal.SIGINT, press)
    try:
        yield look
    finally:
        if signal.getsignal(signal.SIGINT) is press:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _require_scheduler(address: str) -> None:
    """Make sure that a scheduler answers: a client waits for ever where another program takes its connection.

    Raises
    ------
    ModelError : none does.
    """
    from distributed.core import rpc

    answers = queue.SimpleQueue[object]()

    async def identity() -> Any:
        async with rpc(address, timeout=_CONNECT) as server:  # type: ignore[no-untyped-call]
            return await server.identity()

    def ask() -> None:
        try:
            answers.put(asyncio.run(asyncio.wait_for(identity(), _CONNECT)))
        except Exception as error:  # whatever Dask makes of an address that is none, or of another program's answer
            answers.put(error)

    threading.Thread(target=ask, daemon=True).start()
    try:
        answer = answers.get(timeout=_CONNECT + 1.0)
    except queue.Empty:
        answer = None
    if not isinstance(answer, Mapping) or answer.get("type") != "Scheduler":
        raise ModelError(
            f"no scheduler answers there within {_CONNECT:g} s",
            path="scheduler",
            given=address,
            allowed="the address that `dask scheduler` prints, tcp://HOST:8786",
        ) from (answer if isinstance(answer, Exception) else None)


class _Run:
    """One run of places: futures at work, and those that are done in an inbox."""

    def __init__(self, client: Any, address: str, work: bytes, places: Sequence[int]) -> None:
        """work : function of a place and the versions that it wants, pickled."""
        self.client, self.address = client, address
        # two clients of one scheduler have tasks of their own
        self.token = secrets.token_hex(6)
        self.work = client.submit(pickle.loads, work, key=f"epicyclic-work-{self.token}")
        self.places = places
        self.next = 0  # position of the next place to give
        self.at_work: dict[int, Any] = {}  # position -> future, in the order of positions
        self.given: dict[int, int] = {}
        self.inbox: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self.window, self.counted, self.alone = _LEAST, 0.0, False

    def results(self, look: Callable[[], None]) -> Iterator[tuple[int, Arrays]]:
        """Place and arrays, as they arrive; look : called now and then, raises where the run is to end."""
        failure: BaseException | None = None
        while self.at_work or (failure is None and self.next < len(self.places)):
            if failure is None:
                # up to a window beyond the first that is still at work
                self._count_workers()
                first = min(self.at_work, default=self.next)
                last = min(first + self.window, len(self.places))
                self._submit(range(self.next, last))
                self.next = max(self.next, last)
            # of those given anew since, an older future is none of this run
            arrived = [(position, future) for position, future in self._arrived(look) if self._is_of(position, future)]
            finished = [(position, future) for position, future in arrived if future.status == "finished"]
            for position, arrays in self._gathered(finished):
                yield self.places[position], arrays
            for position, future in arrived:
                if self._is_of(position, future):
                    failure = self._fault(position, future) or failure
        if failure is not None:
            raise failure

    def _is_of(self, position: int, future: Any) -> bool:
        """Whether a future is the one at work for a position."""
        return self.at_work.get(position) is future

    def _submit(self, positions: Sequence[int]) -> None:
        """Give the scheduler places, all in one message."""
        if not positions:
            return
        places, keys = [self.places[position] for position in positions], []
        for position, place in zip(positions, places, strict=True):
            self.given[position] = self.given.get(position, 0) + 1
            keys.append(f"epicyclic-block-{self.token}-{place}-{self.given[position]}")
        futures = self.client.map(_block, [self.work] * len(places), places, key=keys)
        for position, future in zip(positions, futures, strict=True):
            self.at_work[position] = future
            future.add_done_callback(partial(self._enter, position))

    def _enter(self, position: int, future: Any) -> None:
        self.inbox.put((position, future))

    def _count_workers(self) -> None:
        now = time.monotonic()
        if now - self.counted < _COUNT:
            return
        self.counted = now
        threads = sum(self._asked(self.client.nthreads).values())
        self.window = max(_LEAST, _AHEAD * threads)
        if not threads and not self.alone:
            getLogger("epicyclic").warning("the scheduler at %s has no workers yet: waiting for them", self.address)
        self.alone = not threads

    def _asked(self, question: Callable[..., Any], *arguments: Any) -> Any:
        """Answer of the scheduler."""
        try:
            return question(*arguments)
        except Exception as error:
            if self.client.status != "running" or isinstance(error, OSError):
                raise self._lost() from error
            raise

    def _arrived(self, look: Callable[[], None]) -> list[tuple[int, Any]]:
        """Positions and futures that are done, at least one."""
        while True:
            look()
            with suppress(queue.Empty):
                arrived = [self.inbox.get(timeout=_LOOK)]
                while not self.inbox.empty():
                    arrived.append(self.inbox.get())
                return arrived
            if self.client.status != "running":
                raise self._lost()
            self._count_workers()

    def _gathered(self, finished: list[tuple[int, Any]]) -> list[tuple[int, Arrays]]:
        """Positions and arrays of futures that are done; those whose results are lost are left at work."""
        if not finished:
            return []
        try:
            arrays = self._asked(self.client.gather, [future for _, future in finished])
        except ModelError:
            raise
        except Exception:  # a worker died with its results: each by itself, in `_fault`
            return []
        for position, _ in finished:
            del self.at_work[position]
        return [(position, block) for (position, _), block in zip(finished, arrays, strict=True)]

    def _fault(self, position: int, future: Any) -> BaseException | None:
        """What a block has raised; None where it is given anew."""
        from distributed.scheduler import KilledWorker

        if self.client.status != "running":
            raise self._lost()
        if future.status != "error":
            return self._anew(position, "the results of a block were lost again and again")
        error = self._asked(future.exception)
        if isinstance(error, KilledWorker):
            return self._anew(position, "a block has killed every worker it was given to: memory?")
        del self.at_work[position]
        if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "epicyclic":
            return self._refusal("the workers have no epicyclic", "workers with the same packages as this process")
        return cast(BaseException, error)

    def _anew(self, position: int, problem: str) -> BaseException | None:
        """Give a place again, unless that has been done too often."""
        if self.given[position] < _GIVEN:
            self._submit([position])
            return None
        del self.at_work[position]
        return self._refusal(problem, "workers that live; resume goes on")

    def _lost(self) -> ModelError:
        allowed = "a scheduler that runs; with a store, resume goes on from what is done"
        return self._refusal("the connection to the scheduler is lost", allowed)

    def _refusal(self, problem: str, allowed: str) -> ModelError:
        return ModelError(problem, path="scheduler", given=self.address, allowed=allowed)


def _block(work: tuple[Callable[[int], Arrays], Mapping[str, str]], place: int) -> Arrays:
    """A block on a worker, which computes in one thread.

    Raises
    ------
    ModelError : other versions on the worker.  Whatever the block raises.
    """
    compute, wanted = work
    installed = versions()
    if installed != wanted:
        given, allowed = (", ".join(map(" ".join, packages.items())) for packages in (installed, wanted))
        raise ModelError("the workers have other packages", path="scheduler", given=given, allowed=allowed)
    os.environ["EPICYCLIC_JOBS"] = "1"
    return compute(place)
