"""The blocks of a job in their order, computed wherever there is a worker, those of a store only once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import ModelError
from ...results.block_store import BlockStore, block_store, job_hash
from ...results.counted import Counted
from .versions import versions

__all__ = ["BlockJob", "hash_of", "run_blocks"]

Arrays = dict[str, np.ndarray]
Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockJob:
    """A job of independent blocks.

    verb : that asks.  identity : says which job it is: model, options, size of a block, seed; texts, numbers, arrays.
    count : of blocks.
    compute : number of a block -> its arrays of numbers, a function of the number alone; picklable (`functools.partial`
        of a function of a module).  Names, types and shapes are those of every block, but for `ragged`.
    ragged : names of arrays (n,) whose length varies.
    """

    verb: str
    identity: Mapping[str, object]
    count: int
    compute: Callable[[int], Arrays]
    ragged: tuple[str, ...] = ()

    @property
    def whole_identity(self) -> dict[str, object]:
        """The identity with all that the bits of a block depend on, but the kind of CPU."""
        return {"verb": self.verb, **self.identity, "versions": versions()}


def hash_of(job: BlockJob) -> str:
    """SHA-256 that names a job: two stores of one hash, made on one kind of CPU, are equal bit for bit."""
    return job_hash({**job.whole_identity, "blocks": job.count})


def run_blocks(
    job: BlockJob,
    *,
    store: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Generator[tuple[int, Arrays], None, None]:
    """Number and arrays of every block, in order; in bounded memory, however many there are.

    Whatever stops the iteration, blocks that have arrived are kept in the store.  Close the iterator where it is left
    early (`contextlib.closing`), so that the store is free again.

    Parameters
    ----------
    store : folder of a Zarr store that keeps every block; None: nothing is kept.
    resume : whether blocks that lie in the store are wanted; they are read, not computed.
    workers : local processes; None: this process.  scheduler : address of a Dask scheduler instead, tcp://HOST:8786.
    progress : called with the share done (`Counted`).

    Raises
    ------
    ModelError : a store that is another job's, is in use, or cannot be written; a scheduler that is not reached; a
        package that is not installed.  Whatever a block raises, after those at work are kept.
    """
    if workers is not None and scheduler is not None:
        raise ModelError("one excludes the other", path="workers, scheduler", given=scheduler, allowed="one of them")
    if resume and store is None:
        raise ModelError("needs the store of the job that was stopped", path="resume", allowed="store")
    with ExitStack() as stack:
        kept: BlockStore | None = None
        if store is not None:
            opened = block_store(store, identity=job.whole_identity, count=job.count, resume=resume, ragged=job.ragged)
            kept = stack.enter_context(opened)
        done = np.zeros(job.count, dtype=bool) if kept is None else kept.done.copy()
        arrivals = stack.enter_context(closing(_computed(job, np.flatnonzero(~done).tolist(), workers, scheduler)))
        yield from _in_order(job, done, kept, arrivals, progress)


def _computed(
    job: BlockJob, places: Sequence[int], workers: int | None, scheduler: str | None
) -> Generator[tuple[int, Arrays], None, None]:
    """Blocks at the places as they arrive."""
    if workers is None and scheduler is None:
        for place in places:
            yield place, job.compute(place)
    elif places:
        from .dask_engine import computed

        yield from computed(job.compute, places, versions=versions(), workers=workers, scheduler=scheduler)


def _in_order(
    job: BlockJob,
    done: np.ndarray,
    kept: BlockStore | None,
    arrivals: Iterator[tuple[int, Arrays]],
    progress: Progress | None,
) -> Iterator[tuple[int, Arrays]]:
    """All blocks in order: those of the store, and those that arrive, each kept as soon as it does."""
    waiting: dict[int, Arrays] = {}
    count = int(done.sum())
    if progress is not None:
        progress(Counted(count, job.count))
    for block in range(job.count):
        if done[block] and kept is not None:
            yield block, _read(job, kept, block)
            continue
        while block not in waiting:
            place, arrays = next(arrivals)
            waiting[place] = arrays
            if kept is not None:
                kept.write(place, arrays)
            count += 1
            if progress is not None:
                progress(Counted(count, job.count))
        yield block, waiting.pop(block)


def _read(job: BlockJob, kept: BlockStore, block: int) -> Arrays:
    """A block of the store; computed again where a power cut or a disk has damaged it."""
    found = kept.read(block)
    if found is None:
        found = job.compute(block)
        kept.write(block, found)
    return found
