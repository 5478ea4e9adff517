"""Jobs of many blocks: the same store and the same results bit for bit, whoever computes and whatever stops it."""

from __future__ import annotations

import errno
import os
import shutil
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import psutil
import pytest

from epicyclic.engine import dask_workers as room
from epicyclic.engine.block_store import BlockJob, block_store, hash_of, run_blocks
from epicyclic.engine.dask_workers import mend
from epicyclic.engine.plan import Counted
from epicyclic.errors import ModelError

pytest.importorskip("zarr")
pytest.importorskip("distributed")

from distributed.core import Status

Blocks = list[tuple[int, dict[str, np.ndarray]]]


def job(
    count: int = 12, *, seed: int = 1, seconds: float = 0.0, fails: tuple[int, ...] = (), log: Path | None = None
) -> BlockJob:
    """Random numbers of every kind; written inside a function, so that workers get the code itself."""

    def compute(block: int) -> dict[str, np.ndarray]:
        import time

        import numpy as np

        if log is not None:
            with log.open("a") as file:
                file.write(f"{block}\n")
        time.sleep(seconds)
        if block in fails:
            raise ArithmeticError(f"block {block}")
        draws = np.random.default_rng([seed, block])
        return {
            "histogram": draws.integers(0, 100, (2, 50)),
            "sums": draws.random((3, 2)),
            "zeros": np.zeros(4),
            "number": np.asarray(block, np.int32),
            "nothing": np.zeros((0, 3)),
            # from no chunk to three
            "text": draws.integers(0, 255, block * 12000, np.uint8),
        }

    return BlockJob(
        verb="test", identity={"seed": seed, "table": np.arange(3.0)}, count=count, compute=compute, ragged=("text",)
    )


def results(given: BlockJob, **options: Any) -> Blocks:
    with closing(run_blocks(given, **options)) as blocks:
        return list(blocks)


def same(first: Blocks, second: Blocks) -> bool:
    """Whether numbers, names, types, shapes and bits of two runs agree."""

    def bits(blocks: Blocks) -> list[Any]:
        return [
            (number, {name: (str(a.dtype), a.shape, a.tobytes()) for name, a in map_.items()})
            for number, map_ in blocks
        ]

    return bits(first) == bits(second)


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Blocks, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("undisturbed") / "store"
    return results(job(), store=folder), files(folder)


def words_of(process: psutil.Process) -> str:
    """Command line of a process; none of one that has ended and that another test has not waited for."""
    try:
        return " ".join(process.cmdline())
    except (psutil.ZombieProcess, psutil.NoSuchProcess):
        return ""


@pytest.mark.parametrize(("kind", "shape"), [(np.float64, (4,)), (np.float32, (3,)), (np.float32, (4,))])
def test_a_block_of_another_type_or_shape_is_refused(kind: type, shape: tuple[int, ...], tmp_path: Path) -> None:
    def compute(block: int) -> dict[str, np.ndarray]:
        return {"sums": np.zeros(shape, kind) if block else np.zeros(3)}

    given = BlockJob(verb="test", identity={}, count=2, compute=compute)
    with pytest.raises(ValueError, match=r"^sums: .* after float64 \(3,\)$"):
        results(given, store=tmp_path / "store", workers=1)


def test_a_store_gives_back_every_bit(tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    log, shares = tmp_path / "log", list[float]()
    assert [number for number, _ in undisturbed[0]] == list(range(12))
    assert same(results(job(log=log), store=tmp_path / "store", progress=shares.append), undisturbed[0])
    assert files(tmp_path / "store") == undisturbed[1]
    assert shares == [k / 12 for k in range(13)]
    last = shares[-1]
    assert isinstance(last, Counted)
    assert (last.done, last.of) == (12, 12)
    assert same(results(job(log=log), store=tmp_path / "store", resume=True), undisturbed[0])
    assert sorted(map(int, log.read_text().split())) == list(range(12))  # each computed once


def test_memory_alone_gives_the_same(undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    assert same(results(job()), undisturbed[0])


@pytest.mark.parametrize("left", [0, 1, 7])
def test_what_is_left_early_goes_on(tmp_path: Path, left: int, undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    log, folder = tmp_path / "log", tmp_path / "store"
    with closing(run_blocks(job(log=log), store=folder)) as blocks:
        for _ in range(left):
            next(blocks)
    folder.mkdir(exist_ok=True)
    (folder / f"zarr.{'0af' * 10}12.partial").write_bytes(b"half")  # of a writer that was killed
    if left:
        (folder / "sums" / f"c.7.{'0af' * 10}12.partial").write_bytes(b"half")
    assert same(results(job(log=log), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]
    assert len(log.read_text().split()) == 12


def test_a_block_without_its_commit_counts_for_nothing(
    tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]
) -> None:
    folder = tmp_path / "store"
    results(job(), store=folder)
    (folder / "done" / "c.5").unlink()
    (folder / "sums" / "c.5.0.0").write_bytes(b"of a kill")
    assert same(results(job(), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]


@pytest.mark.parametrize("name", ["sums/c.3.0.0", "zeros/c.3.0", "text/c.8.1", "text_length/c.3", "histogram/c.3.0.0"])
@pytest.mark.parametrize("gone", [True, False])
def test_a_damaged_block_is_computed_again(
    tmp_path: Path, name: str, gone: bool, undisturbed: tuple[Blocks, dict[str, bytes]]
) -> None:
    log, folder = tmp_path / "log", tmp_path / "store"
    shutil.copytree(_written(tmp_path / "first", undisturbed[1]), folder)
    raw = bytearray((folder / name).read_bytes())
    raw[len(raw) // 2] ^= 1
    if gone:
        (folder / name).unlink()
    else:
        (folder / name).write_bytes(raw)
    assert same(results(job(log=log), store=folder, resume=True), undisturbed[0])
    assert log.read_text().split() == [name.split(".")[1]]
    assert files(folder) == undisturbed[1]


def _written(folder: Path, content: dict[str, bytes]) -> Path:
    for name, raw in content.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(raw)
    return folder


def test_the_store_of_another_job_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "store"
    results(job(), store=folder)
    before = files(folder)
    with pytest.raises(ModelError, match=r"seed = 2: .* has other options \(seed\); allowed: seed = 1") as caught:
        results(job(seed=2), store=folder, resume=True)
    assert caught.value.path == str(folder)
    with pytest.raises(ModelError, match=r"blocks = 13: .*has other options \(blocks\); allowed: blocks = 12"):
        results(job(13), store=folder, resume=True)
    with pytest.raises(ModelError, match="an interrupted run lies there; allowed: resume"):
        results(job(), store=folder)
    assert files(folder) == before
    other = tmp_path / "pictures"
    other.mkdir()
    (other / "cat.partial").write_bytes(b"cat")
    with pytest.raises(ModelError, match="is no folder of a run; allowed: a new or empty folder"):
        results(job(), store=other)
    assert (other / "cat.partial").is_file()
    with pytest.raises(ModelError, match="needs the store"):
        results(job(), resume=True)
    assert hash_of(job()) != hash_of(job(seed=2))
    assert hash_of(job()) == hash_of(job(log=folder))


def test_one_client_at_a_time_has_a_store(tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    folder = tmp_path / "store"
    with closing(run_blocks(job(), store=folder)) as blocks:
        next(blocks)
        with pytest.raises(ModelError, match="another run writes there"):
            results(job(), store=folder, resume=True)
    assert same(results(job(), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]


@pytest.mark.parametrize("writes", [37, 39, 41, 43])
def test_a_full_disk_is_said_and_gone_on_from(
    writes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, undisturbed: tuple[Blocks, dict[str, bytes]]
) -> None:
    import zarr.storage._local as local

    folder, put, left = tmp_path / "store", local._put, [writes]

    def full(path: Path, value: Any, exclusive: bool = False) -> int:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return put(path, value, exclusive)

    monkeypatch.setattr(local, "_put", full)
    with pytest.raises(ModelError, match="cannot be written: No space left on device") as caught:
        results(job(), store=folder)
    assert caught.value.path == str(folder)
    with block_store(folder, identity=job().whole_identity, count=12, resume=True, ragged=("text",)) as kept:
        assert 0 < kept.done.sum() < 12
        assert all(kept.read(block) is not None for block in map(int, np.flatnonzero(kept.done)))
    monkeypatch.undo()
    assert same(results(job(), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]


def test_a_block_that_fails_leaves_the_others_in_the_store(
    tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]
) -> None:
    folder = tmp_path / "store"
    with pytest.raises(ArithmeticError, match="block 0"):
        results(job(seconds=0.05, fails=(0,)), store=folder, workers=2)
    # the others were at work, or waited for their turn
    assert sorted(path.name for path in (folder / "done").glob("c.*")) == sorted(f"c.{k}" for k in range(1, 12))
    assert same(results(job(), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]


def workers_of_this_process() -> list[psutil.Process]:
    """Processes of the local cluster that compute."""
    below = psutil.Process().children(recursive=True)
    return [process for process in below if "spawn_main" in words_of(process)]


def test_workers_may_be_killed(tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    folder, killed = tmp_path / "store", 0
    with closing(run_blocks(job(seconds=0.1), store=folder, workers=2)) as blocks:
        found = []
        for number, arrays in blocks:
            found.append((number, arrays))
            # both at once, and again while they start
            for _ in range({2: 1, 5: 2}.get(number, 0)):
                for worker in workers_of_this_process():
                    with suppress(psutil.NoSuchProcess):
                        worker.kill()
                    killed += 1
                time.sleep(0.25)
    assert killed >= 4
    assert same(found, undisturbed[0])
    assert files(folder) == undisturbed[1]
    assert not workers_of_this_process()


def test_a_worker_whose_nanny_gave_up_is_replaced() -> None:
    class Cluster:
        asked = 0

        def __init__(self) -> None:
            kinds = (Status.running, Status.failed, Status.closed, Status.starting)
            self.workers = {number: SimpleNamespace(status=status) for number, status in enumerate(kinds)}

        def scale(self, workers: int) -> None:
            self.asked = workers

    cluster = Cluster()
    mend(cluster, 4)
    assert list(cluster.workers) == [0, 3]
    assert cluster.asked == 4


def test_a_cluster_that_does_not_start_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "_START", "raise OSError('no process may be started here')")
    with (
        pytest.raises(ModelError, match="does not start: OSError: no process may be started here; allowed: no workers"),
        room.local_cluster(1),
    ):
        pass


def test_a_scheduler_may_be_killed(tmp_path: Path, undisturbed: tuple[Blocks, dict[str, bytes]]) -> None:
    folder = tmp_path / "store"
    with closing(run_blocks(job(seconds=0.05), store=folder, workers=1)) as blocks:
        next(blocks)
        (cluster,) = [p for p in psutil.Process().children() if "dask_workers" in words_of(p)]
        cluster.kill()
        with pytest.raises(ModelError, match=r"connection to the scheduler is lost; allowed: .*resume goes on"):
            list(blocks)
    assert same(results(job(), store=folder, resume=True), undisturbed[0])
    assert files(folder) == undisturbed[1]


def test_an_unreachable_scheduler_is_told_within_ten_seconds() -> None:
    with socket.create_server(("127.0.0.1", 0)) as deaf:  # takes connections and says nothing
        addresses = ["tcp://127.0.0.1:9", f"tcp://127.0.0.1:{deaf.getsockname()[1]}", "ftp://x", ""]

        def refused(address: str) -> ModelError:
            with pytest.raises(ModelError, match="no scheduler answers there") as caught:
                results(job(), scheduler=address)
            return caught.value

        start = time.monotonic()
        with ThreadPoolExecutor(len(addresses)) as pool:
            errors = list(pool.map(refused, addresses))
    assert time.monotonic() - start < 10
    assert [(error.path, error.given) for error in errors] == [("scheduler", address) for address in addresses]


def test_workers_and_a_scheduler_exclude_each_other() -> None:
    with pytest.raises(ModelError, match="workers, scheduler"):
        results(job(), workers=2, scheduler="tcp://127.0.0.1:8786")


@pytest.mark.parametrize(
    ("package", "options", "path"),
    [("zarr", {"store": "s"}, "store"), ("distributed", {"workers": 2}, "workers")],
)
def test_a_missing_package_is_named_with_its_cure(
    package: str, options: dict[str, Any], path: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import sys

    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ModelError, match=r"not installed .*pip install 'epicyclic\[scale\]'") as caught:
        results(job(), **options)
    assert caught.value.path == path
    assert not list(tmp_path.iterdir())
    assert len(results(job(2))) == 2  # without them in one process
