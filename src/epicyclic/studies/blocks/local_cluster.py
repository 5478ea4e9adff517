"""A Dask cluster on this machine, in a process of its own that lives until its standard input ends.

It stands apart from the process that asks, so that Ctrl-C reaches the client alone, no script is run again in the
workers, and the cluster ends with its client, however that ends.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

from ...errors import ModelError

__all__ = ["local_cluster", "mend", "serve"]

_START = f"import sys; from {__name__} import serve; serve(int(sys.argv[1]))"
# Seconds in which the processes of a cluster end by themselves; then they are killed.
_END = 2.0
# Seconds between two looks at the workers, and Dask's time after which one that has not come back is given up: its
# start takes two, several times that on a busy machine.
_LOOK, _LOST = 1.0, "15s"
# Deaths of workers that one block may meet: more than the twenty kills that a job must stand, few enough that a block
# that kills its workers ends within a minute or two.
_DEATHS = 30


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
        while not ended.wait(_LOOK):
            cluster.sync(_mended, cluster, workers)


def mend(cluster: Any, workers: int) -> None:
    """Put new workers in place of those that are gone for good.

    A worker that is killed is started again by its nanny, but a nanny whose worker is killed while it starts gives up.
    """
    from distributed.core import Status

    for name, nanny in list(cluster.workers.items()):
        if nanny.status in (Status.closed, Status.failed):
            del cluster.workers[name]
    cluster.scale(workers)


async def _mended(cluster: Any, workers: int) -> None:
    """The same, in the loop of the cluster."""
    mend(cluster, workers)


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
            raise ModelError(
                f"the local cluster does not start{_last_line(told)}",
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


def _last_line(told: IO[str]) -> str:
    """What a process has said last, in a message; "" where it said nothing."""
    told.seek(0)
    lines = [line.strip() for line in told if line.strip()]
    return f": {lines[-1]}" if lines else ""
