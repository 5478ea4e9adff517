"""A job of many blocks that is disturbed in every way, then resumed: its store must equal the undisturbed one.

python benchmarks/cluster.py [--blocks 96] [--kills 20]

Workers are killed, the scheduler, the client; Ctrl-C; a disk that fills up (a small tmpfs, where one may be mounted);
two clients on one store.  At the end rates and sizes, for docs/how-to/scale.md.
"""

from __future__ import annotations

import argparse
import filecmp
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import psutil

from epicyclic.engine.block_store import BlockJob, run_blocks
from epicyclic.errors import ModelError

ROWS, COLUMNS, RESULTS = 8192, 41, 32
# seconds a block is held up, so that a run lasts long enough to be disturbed
HELD = 0.25


def block(number: int, held: float = HELD) -> dict[str, np.ndarray]:
    """A block like that of `tolerance`: normal samples, a product, histograms, sums, the worst samples."""
    time.sleep(held)
    draws = np.random.default_rng(np.random.SeedSequence(1, spawn_key=(number,)))
    columns = np.random.default_rng(0).standard_normal((COLUMNS, RESULTS))
    response = draws.standard_normal((ROWS, COLUMNS)) @ columns
    largest = response.max(axis=1)
    worst = np.argsort(-largest, kind="stable")[:8]
    edges = np.linspace(-40.0, 40.0, 1001)
    return {
        "histogram": np.array([np.histogram(one, edges)[0] for one in response.T]),
        "sums": np.array([response.sum(axis=0), (response**2).sum(axis=0)]),
        "worst": worst,
        "worst_value": largest[worst],
    }


def job(blocks: int, held: float = HELD) -> BlockJob:
    from functools import partial

    return BlockJob(verb="cluster", identity={"seed": 1}, count=blocks, compute=partial(block, held=held))


def client(store: str, blocks: int, resume: bool, workers: int | None, scheduler: str | None) -> None:
    """One run, in a process of its own; every block once and in order."""
    seen = []
    try:
        with closing(
            run_blocks(job(blocks), store=store, resume=resume, workers=workers, scheduler=scheduler)
        ) as arriving:
            for number, _ in arriving:
                seen.append(number)
    except ModelError as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:
        sys.exit(130)
    assert seen == list(range(blocks)), seen


class Bench:
    """Runs of one job in one folder."""

    def __init__(self, folder: Path, blocks: int) -> None:
        self.folder, self.blocks = folder, blocks

    def start(self, store: Path, *options: str) -> subprocess.Popen[str]:
        command = [sys.executable, __file__, "--blocks", str(self.blocks), "--client", str(store), *options]
        return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)

    def done(self, store: Path) -> int:
        return len(list((store / "done").glob("c.*")))

    def wait(self, store: Path, blocks: int, process: subprocess.Popen[str]) -> None:
        while self.done(store) < blocks and process.poll() is None:
            time.sleep(0.02)

    def finish(self, store: Path, *options: str) -> float:
        """Seconds of the run that goes on to the end."""
        start = time.perf_counter()
        process = self.start(store, "--resume", *options)
        _, told = process.communicate()
        assert process.returncode == 0, told
        return time.perf_counter() - start

    def equal(self, store: Path) -> bool:
        """Whether a store is the undisturbed one, file by file."""
        first = self.folder / "undisturbed"
        names = {path.relative_to(first) for path in first.rglob("*") if path.is_file()}
        others = {path.relative_to(store) for path in store.rglob("*") if path.is_file()}
        return names == others and all(filecmp.cmp(first / name, store / name, shallow=False) for name in names)

    def say(self, name: str, store: Path, words: str) -> None:
        same = self.equal(store)
        print(f"{name:<22} {words}; store equal bit for bit: {same}", flush=True)
        assert same


def computing(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """Worker processes of a client's local cluster."""
    with suppress(psutil.NoSuchProcess):
        below = psutil.Process(process.pid).children(recursive=True)
        return [one for one in below if one.is_running() and "spawn_main" in " ".join(one.cmdline())]
    return []


def undisturbed(bench: Bench) -> None:
    start = time.perf_counter()
    process = bench.start(bench.folder / "undisturbed")
    _, told = process.communicate()
    assert process.returncode == 0, told
    print(f"{'one process':<22} {bench.blocks} blocks in {time.perf_counter() - start:.1f} s", flush=True)


def two_workers(bench: Bench) -> None:
    seconds = bench.finish(bench.folder / "workers", "--workers", "2")
    bench.say("two workers", bench.folder / "workers", f"{seconds:.1f} s with the start of the cluster")


def kill_workers(bench: Bench, kills: int) -> None:
    store, choose = bench.folder / "killed", random.Random(1)
    process = bench.start(store, "--workers", "2")
    bench.wait(store, 2, process)
    killed, start = 0, time.perf_counter()
    while killed < kills and process.poll() is None:
        workers = computing(process)
        if workers:
            with suppress(psutil.NoSuchProcess):
                choose.choice(workers).send_signal(signal.SIGKILL)
                killed += 1
        time.sleep(choose.uniform(0.2, 1.2))
    _, told = process.communicate()
    assert process.returncode == 0, told
    words = f"{killed} kills, the run ends by itself after {time.perf_counter() - start:.1f} s"
    bench.say("kill -9 of workers", store, words)
    assert killed == kills


def kill_scheduler(bench: Bench) -> None:
    store, address = bench.folder / "scheduler", "tcp://127.0.0.1:18786"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nworkers", "2", "--nthreads", "1"]

    def cluster() -> list[subprocess.Popen[bytes]]:
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return [
            subprocess.Popen([*dask, "--host", "127.0.0.1", "--port", "18786", "--no-dashboard"], **quiet),  # type: ignore[call-overload]
            subprocess.Popen([*worker, "--no-dashboard", "--local-directory", str(bench.folder)], **quiet),  # type: ignore[call-overload]
        ]

    started = cluster()
    try:
        time.sleep(3.0)
        process = bench.start(store, "--scheduler", address)
        bench.wait(store, bench.blocks // 3, process)
        started[0].kill()
        start = time.perf_counter()
        _, told = process.communicate()
        lost, left = time.perf_counter() - start, bench.done(store)
        assert process.returncode not in (0, None)
        for one in started:
            one.terminate()
            one.wait()
        started = cluster()
        time.sleep(3.0)
        bench.finish(store, "--scheduler", address)
    finally:
        for one in started:
            one.terminate()
            one.wait()
    words = f"{left} of {bench.blocks} kept, told after {lost:.1f} s ({told.strip()[:60]}...)"
    bench.say("kill -9 of scheduler", store, words)


def kill_client(bench: Bench) -> None:
    store = bench.folder / "client"
    process = bench.start(store, "--workers", "2")
    bench.wait(store, bench.blocks // 3, process)
    workers = computing(process)
    process.kill()
    process.communicate()
    gone, alive = psutil.wait_procs(workers, timeout=15)
    assert not alive, "workers outlive their client"
    left = bench.done(store)
    bench.finish(store, "--workers", "2")
    bench.say("kill -9 of client", store, f"{left} of {bench.blocks} kept, {len(gone)} workers ended")


def interrupt(bench: Bench) -> None:
    for options in ((), ("--workers", "2")):
        store = bench.folder / f"interrupted{len(options)}"
        process = bench.start(store, *options)
        bench.wait(store, bench.blocks // 3, process)
        start = time.perf_counter()
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate()
        seconds, left = time.perf_counter() - start, bench.done(store)
        assert process.returncode == 130, told
        bench.finish(store, *options)
        words = f"{left} of {bench.blocks} kept, ended after {seconds:.1f} s, {len(told.splitlines())} lines on stderr"
        bench.say(f"Ctrl-C {' '.join(options)}", store, words)


def full_disk(bench: Bench) -> None:
    disk = bench.folder / "disk"
    disk.mkdir()
    size = sum(path.stat().st_size for path in (bench.folder / "undisturbed").rglob("*") if path.is_file())
    # a page a file
    pages = sum(-(-path.stat().st_size // 4096) for path in (bench.folder / "undisturbed").rglob("*") if path.is_file())
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={pages * 4096 // 2}", "tmpfs", disk], check=False)
    if mounted.returncode:
        print("full disk              not tried: no tmpfs may be mounted here", flush=True)
        return
    try:
        store = disk / "store"
        process = bench.start(store, "--workers", "2")
        _, told = process.communicate()
        left = bench.done(store)
        assert process.returncode == 1, told
        assert "cannot be written: No space left on device" in told, told
        subprocess.run(["mount", "-o", f"remount,size={4 * pages * 4096}", disk], check=True)
        bench.finish(store)
        words = f"{left} of {bench.blocks} kept on half of {size / 1e3:.0f} kB ({told.strip()[-75:]})"
        bench.say("full disk", store, words)
    finally:
        subprocess.run(["umount", disk], check=True)


def two_clients(bench: Bench) -> None:
    store = bench.folder / "both"
    both = [bench.start(store), bench.start(store, "--workers", "2")]
    told = [process.communicate()[1] for process in both]
    codes = sorted(process.returncode for process in both)
    assert codes == [0, 1], told
    assert "another run writes there" in "".join(told)
    bench.say("two clients", store, "one refused, the other ends")


def rates(bench: Bench) -> None:
    """Blocks a second without work, and what a block takes on disk."""

    def rate(count: int, run: Callable[[list[float]], None]) -> float:
        stamps = list[float]()
        run(stamps)
        return (count - count // 4 - 1) / (stamps[-1] - stamps[count // 4])

    def nothing(number: int) -> dict[str, np.ndarray]:
        import numpy as np

        return {"number": np.asarray(number)}

    empty = BlockJob(verb="empty", identity={}, count=4000, compute=nothing)

    def tasks(stamps: list[float]) -> None:
        with closing(run_blocks(empty, workers=2)) as arriving:
            stamps += [time.perf_counter() for _ in arriving]

    def writes(stamps: list[float]) -> None:
        with closing(run_blocks(job(200, held=0.0), store=bench.folder / "writes")) as arriving:
            stamps += [time.perf_counter() for _ in arriving]

    def computes(stamps: list[float]) -> None:
        with closing(run_blocks(job(200, held=0.0))) as arriving:
            stamps += [time.perf_counter() for _ in arriving]

    print(f"empty blocks, 2 workers: {rate(4000, tasks):.0f} a second", flush=True)
    alone, kept = rate(200, computes), rate(200, writes)
    print(f"a block is computed in {1e3 / alone:.1f} ms; kept in the store in {1e3 / kept - 1e3 / alone:.1f} ms more")
    files = [path for path in (bench.folder / "writes").rglob("c.*") if path.is_file()]
    size = sum(path.stat().st_size for path in files)
    print(f"a block of {ROWS} samples, {RESULTS} histograms: {len(files) / 200:.0f} files, {size / 200:.0f} bytes")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=96)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--client", help=argparse.SUPPRESS)
    parser.add_argument("--resume", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--workers", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--scheduler", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.client:
        client(given.client, given.blocks, given.resume, given.workers, given.scheduler)
        return
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), given.blocks)
        undisturbed(bench)
        two_workers(bench)
        kill_workers(bench, given.kills)
        kill_scheduler(bench)
        kill_client(bench)
        interrupt(bench)
        full_disk(bench)
        two_clients(bench)
        rates(bench)


if __name__ == "__main__":
    main()
