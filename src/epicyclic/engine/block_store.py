"""Jobs of independent blocks: the order in which they are computed, and the Zarr store that keeps what is done.

A job says what its blocks are; `run_blocks` gives them in their order, computed wherever there is a worker, those of a
store only once.

A store is the folder of a run (`run_folder`: its record, its lock, its refusals) whose parts are those of a Zarr group:
an array a result with one block a chunk, and the array `done`.  Atomic is each file, not a block of several arrays, so
the chunk of `done`, written last, is the commit: a block without it counts for nothing.  Every chunk bears a crc32c.
Nothing is synchronised to disk: after a power cut a block may be damaged, which its checksum tells, and is computed
again.

Bytes depend on the results alone, not on the order or the number of attempts, so two stores of one job are equal.
"""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from .plan import Counted
from .run_folder import BLOCKS, is_left_over, open_folder, plain_identity, versions

Arrays = dict[str, NDArray[Any]]

_DONE, INSTALL = "done", "pip install 'epicyclic[scale]'"
_KINDS = "fciub"
# Elements of a chunk of a row whose length varies: a few kB compressed, and one file of most results.
_PIECE = 65536
# Row of varying length: as good as endless.  Only the chunks that are written exist.
_ENDLESS = 2**40
# A chunk of zeros is a file like any other, so that one that is missing is seen.  Not part of the store: said anew.
_EVERY_CHUNK = {"write_empty_chunks": True}


# --- the job ---------------------------------------------------------------------------------------------------------


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
    identity = plain_identity({**job.whole_identity, "blocks": job.count})
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()


def run_blocks(
    job: BlockJob,
    *,
    store: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
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
            opening = block_store(store, identity=job.whole_identity, count=job.count, resume=resume, ragged=job.ragged)
            kept = stack.enter_context(opening)
        done = np.zeros(job.count, dtype=bool) if kept is None else kept.done.copy()
        arrivals = stack.enter_context(closing(_computed(job, np.flatnonzero(~done).tolist(), workers, scheduler)))
        waiting: dict[int, Arrays] = {}
        count = int(done.sum())
        if progress is not None:
            progress(Counted(count, job.count))
        for block in range(job.count):
            if kept is not None and done[block]:
                arrays = kept.read(block)
                if arrays is None:
                    # damaged by a power cut or a disk
                    arrays = job.compute(block)
                    kept.write(block, arrays)
                yield block, arrays
                continue
            while block not in waiting:
                number, arrays = next(arrivals)
                waiting[number] = arrays
                if kept is not None:
                    kept.write(number, arrays)
                count += 1
                if progress is not None:
                    progress(Counted(count, job.count))
            yield block, waiting.pop(block)


def _computed(
    job: BlockJob, blocks: Sequence[int], workers: int | None, scheduler: str | None
) -> Generator[tuple[int, Arrays], None, None]:
    """Number and arrays of blocks, as they arrive."""
    if workers is None and scheduler is None:
        for block in blocks:
            yield block, job.compute(block)
    elif blocks:
        from .dask_workers import computed

        yield from computed(job.compute, blocks, workers=workers, scheduler=scheduler)


# --- which job it is -------------------------------------------------------------------------------------------------


def machine() -> str:
    """Kind of CPU that this process computes on: between kinds results may differ in their last bits."""
    name = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            name = next((line.partition(":")[2].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    return f"{platform.machine()} {name or platform.processor()}".strip()


# --- the store -------------------------------------------------------------------------------------------------------


@dataclass(slots=True, kw_only=True, eq=False)
class BlockStore:
    """The blocks of one job in an open store.

    count : of blocks.  done : (count,) which are there.  ragged : names of arrays (n,) whose length varies.
    """

    folder: Path
    count: int
    done: NDArray[np.bool_]
    ragged: tuple[str, ...]
    group: Any
    arrays: dict[str, Any] = field(default_factory=dict)

    def read(self, block: int) -> Arrays | None:
        """Results of a block that is done; None where its files are damaged or gone."""
        try:
            return {name: self._read(name, block) for name in self._names()}
        except Exception:  # whatever a codec meets in a damaged file
            return None

    def write(self, block: int, results: Mapping[str, NDArray[Any]]) -> None:
        """Keep the results of a block: all of it, or nothing that counts.

        Raises
        ------
        ModelError : the store cannot be written.  ValueError : results unlike those of the blocks before.
        """
        arrays = {name: np.asarray(values) for name, values in results.items()}
        try:
            if len(self.arrays) == 1:
                self._lay_out(arrays)
            self._require_alike(arrays)
            for name, values in arrays.items():
                if name in self.ragged:
                    self._write_row(name, block, values)
                else:
                    self.arrays[name][block] = values
            self.arrays[_DONE][block] = 1
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(self.folder)) from error
        self.done[block] = True

    def _names(self) -> list[str]:
        lengths = {_length(name) for name in self.ragged}
        return [name for name in self.arrays if name != _DONE and name not in lengths]

    def _lay_out(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Make the arrays for results like these; the attributes name them first."""
        layout = {}
        for name, values in arrays.items():
            if name == _DONE or values.dtype.kind not in _KINDS or (name in self.ragged and values.ndim != 1):
                raise ValueError(f"{name}: an array of {values.dtype} {values.shape} cannot be kept")
            layout[name] = [values.dtype.str, None if name in self.ragged else list(values.shape)]
        self.group.attrs["layout"] = layout
        self.open_arrays(layout)

    def open_arrays(self, layout: Mapping[str, Any]) -> None:
        """Open the arrays, or make those that are not there."""
        self.arrays[_DONE] = self._array(_DONE, "|u1", (), ())
        for name, (kind, shape) in layout.items():
            if name in self.ragged:
                self.arrays[name] = self._array(name, kind, (_ENDLESS,), (_PIECE,))
                self.arrays[_length(name)] = self._array(_length(name), "<i8", (), ())
            else:
                self.arrays[name] = self._array(name, kind, shape, shape)

    def _array(self, name: str, kind: str, shape: Sequence[int], chunk: Sequence[int]) -> Any:
        from zarr.codecs import Crc32cCodec, ZstdCodec

        if (self.folder / name / "zarr.json").is_file():
            return self.group[name].with_config(_EVERY_CHUNK)
        return self.group.create_array(
            name,
            shape=(self.count, *shape),
            chunks=(1, *(max(1, size) for size in chunk)),
            dtype=np.dtype(kind),
            # one file a chunk in one folder: no folder a block
            chunk_key_encoding={"name": "default", "separator": "."},
            compressors=[ZstdCodec(level=1), Crc32cCodec()],
            fill_value=0,
            config=_EVERY_CHUNK,
        )

    def _require_alike(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        if sorted(arrays) != sorted(self._names()):
            raise ValueError(f"a block with {sorted(arrays)} after blocks with {sorted(self._names())}")
        for name, values in arrays.items():
            kept = self.arrays[name]
            shape = values.shape if name in self.ragged else kept.shape[1:]
            if values.dtype != kept.dtype or values.shape != shape:
                raise ValueError(f"{name}: {values.dtype} {values.shape} after {kept.dtype} {kept.shape[1:]}")

    def _write_row(self, name: str, block: int, values: NDArray[Any]) -> None:
        """Write a row of its own length in whole chunks, filled up with zeros."""
        padded = np.zeros(-(-values.size // _PIECE) * _PIECE, values.dtype)
        padded[: values.size] = values
        if padded.size:
            self.arrays[name][block, : padded.size] = padded
        self.arrays[_length(name)][block] = values.size

    def _read(self, name: str, block: int) -> NDArray[Any]:
        kept = self.arrays[name]
        if name in self.ragged:
            self._require_chunks(_length(name), [(block,)])
            length = int(self.arrays[_length(name)][block])
            self._require_chunks(name, [(block, piece) for piece in range(-(-length // _PIECE))])
            return np.asarray(kept[block, :length])
        if kept.size:
            self._require_chunks(name, [(block, *(0 for _ in kept.shape[1:]))])
        return np.asarray(kept[block])

    def _require_chunks(self, name: str, places: Sequence[tuple[int, ...]]) -> None:
        """Refuse chunks without a file, which Zarr reads as zeros."""
        for place in places:
            key = self.arrays[name].metadata.encode_chunk_key(place)
            if not (self.folder / name / key).is_file():
                raise FileNotFoundError(key)


def _length(name: str) -> str:
    """Array of the lengths of rows."""
    return f"{name}_length"


@contextmanager
def block_store(
    folder: str | Path, *, identity: Mapping[str, Any], count: int, resume: bool, ragged: Sequence[str] = ()
) -> Iterator[BlockStore]:
    """The store of a job, made or taken up again, which no other job may have while the block runs.

    Parameters
    ----------
    identity : says which job it is: mappings, texts, numbers, arrays.  count : of blocks.
    resume : whether what lies there is wanted.  ragged : names of arrays (n,) whose length varies from block to block.

    Raises
    ------
    ModelError : no zarr; another job has the store or wrote it; what lies there is not asked for; it cannot be written.
    """
    _require_zarr(folder)
    path = Path(folder)
    with open_folder(path, {**identity, "blocks": count}, resume=resume):
        try:
            # no writer of Zarr is alive in a locked folder: what lies there is of one that was killed
            for partial in filter(is_left_over, path.rglob("*.partial")):
                partial.unlink()
            # committed is a block with a chunk of `done`, whose only value is not its fill value; names are listed,
            # since reading a hundred thousand chunks takes a minute
            done = np.zeros(count, dtype=bool)
            for committed in path.glob(BLOCKS):
                number = committed.name.partition(".")[2]
                if number.isdigit() and int(number) < count:
                    done[int(number)] = True
            group = _group(path, anew=not done.any())
            store = BlockStore(folder=path, count=count, done=done, ragged=tuple(ragged), group=group)
            store.open_arrays(store.group.attrs.get("layout", {}))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error
        yield store


def _require_zarr(folder: object) -> None:
    try:
        import zarr
    except ImportError as error:
        problem, allowed = f"a store needs zarr, which is not installed ({error})", f"{INSTALL}, or no store"
        raise ModelError(problem, path="store", given=str(folder), allowed=allowed) from error
    release = tuple(int(part) for part in zarr.__version__.split(".")[:3] if part.isdigit())
    if release < (3, 1, 3):
        # earlier ones do not write a file whole or not at all
        raise ModelError("needs zarr 3.1.3 or newer", path="store", given=f"zarr {zarr.__version__}", allowed=INSTALL)


def _group(path: Path, *, anew: bool) -> Any:
    """The group of a store; anew : without the arrays of a job that had come to no block.

    Raises
    ------
    ModelError : what lies there is no group of a store.
    """
    import zarr

    try:
        group = zarr.open_group(path, mode="a" if anew else "r+")
        if anew:
            for array in path.glob("*/zarr.json"):
                del group[array.parent.name]
            group.attrs.put({})
    except OSError:
        raise
    except Exception as error:  # whatever zarr meets in a file that is no group's
        raise ModelError("not a run that can be continued", path=str(path)) from error
    return group
