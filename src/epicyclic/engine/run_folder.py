"""What a run has done so far, in a folder: whatever stops it, the same command goes on from there to the same bits.

`run.json` is the record of the run: verb, versions, model, options.  Results stand in numbered segments, `000000.kept`,
..., which hold whatever is plain data (`plain_data`).  Every file is written aside and renamed, so that none is ever
partly there, and bears a digest.  One run at a time has the folder.  A store of blocks (`block_store`) is such a folder
whose parts are those of Zarr.

Numbers of a model, modes and projected rows among them, are rounded as BLAS and its number of threads have it.  A run
that is taken up again has them from its folder; those it is asked for must agree up to such rounding.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, is_dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from ..errors import ModelError
from ..results.files import package_version, write_text
from ..user_input import read_text
from .plain_data import Refer, Restore, read_plain, write_plain

try:
    import fcntl
except ImportError:  # not on Windows: there two runs of one folder are not kept apart
    fcntl = None  # type: ignore[assignment]

Model = TypeVar("Model")
Value = TypeVar("Value")
Values = NDArray[Any]

BLOCKS = "done/c.*"
"""Files of a store of blocks that say which are done."""
_RECORD, _NUMBERS = "run.json", "model.numbers"
# Names of the segments; other files in the folder are the user's.
_SEGMENTS = "[0-9][0-9][0-9][0-9][0-9][0-9].kept"
# Temporary files of a writer of ours, and of one of Zarr.
_LEFT_OVER = re.compile(r"\..*\.part|.*\.[0-9a-f]{32}\.partial")
# Bytes of the record: of a store it holds the model.
_MAX_RECORD = 50_000_000
# Texts and lists of a record that stand in it as they are; longer ones by their digest.
_MAX_TEXT = 200
# Options that a refusal names with their values.
_NAMED = 4
# Seconds between two segments: what a kill takes at most, beside the points at work.  So many times that between two
# that hold what replaces itself, which may be larger than the results: what a direction of a sweep goes on from.
_EVERY, _LATEST = 1.0, 20
# A folder that another run removes between making and locking is made again.
_TRIES = 5
# Numbers of one System made twice differ by rounding, 1e-13 of the largest of their array; other models differ by more.
_SAME = 1e-9
# What a result says about its model, and no number of the equation.
_TEXTS = ("provenance", "warnings", "causes")


# --- which run it is -------------------------------------------------------------------------------------------------


def versions() -> dict[str, str]:
    """Versions of the packages that the bits of a result depend on."""
    return {"epicyclic": package_version(), "numpy": np.__version__, "scipy": scipy.__version__}


def plain_identity(value: Any) -> Any:
    """What says which run it is, as JSON: long texts and arrays by their digest.

    Parameters
    ----------
    value : mappings, sequences, texts, numbers, arrays.
    """
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        return "sha256 " + hashlib.sha256(f"{array.dtype}{array.shape}".encode() + array.tobytes()).hexdigest()
    if isinstance(value, Mapping):
        return {str(key): plain_identity(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        plain = [plain_identity(entry) for entry in value]
        return plain if len(json.dumps(plain)) <= _MAX_TEXT else _digest(json.dumps(plain, sort_keys=True))
    if isinstance(value, np.generic):
        return plain_identity(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float):
        return value
    text = str(value)
    return text if len(text) <= _MAX_TEXT else _digest(text)


def _digest(text: str) -> str:
    return "sha256 " + hashlib.sha256(text.encode()).hexdigest()


def _require_same(folder: Path, record: Mapping[str, Any]) -> None:
    """Refuse the folder of another run.

    Raises
    ------
    ModelError : the record there is that of another verb, version, model or of other options, which are named.
    """
    try:
        known = dict(_flat(json.loads(read_text(folder / _RECORD, most=_MAX_RECORD))))
        known["verb"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ModelError("not a run that can be continued", path=str(folder / _RECORD)) from error
    wanted = dict(_flat(record))
    names = [name for name in {**wanted, **known} if wanted.get(name) != known.get(name)]
    parts = [part for part in ("verb", "version", "model") if any(name.startswith(part) for name in names)]
    options = [name for name in names if not name.startswith(("verb", "version", "model"))]
    words = [f"another {part}" for part in parts] + ([f"other options ({', '.join(options)})"] if options else [])
    if words:
        raise _another_run(folder, words, given=_shown(wanted, names), known=_shown(known, names))


def _flat(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Path and value of every entry of a record, of options without this word."""
    if isinstance(value, Mapping) and value:
        for name, entry in value.items():
            yield from _flat(entry, f"{path}.{name}" if path not in ("", "options") else str(name))
    else:
        yield path, value


def _shown(values: Mapping[str, Any], names: Sequence[str]) -> str:
    """Names and values of the first of them, but for digests, which say nothing."""
    texts = {name: str(values.get(name, "(nothing)")) for name in names[:_NAMED]}
    short = {name: text if len(text) <= 24 else f"{text[:21]}..." for name, text in texts.items()}
    return ", ".join(f"{name} = {text}" for name, text in short.items() if not text.startswith("sha256 "))


def _another_run(folder: Path, words: Sequence[str], *, given: str = "", known: str = "") -> ModelError:
    """The refusal of another run's folder; given, known : what differs, as it is asked for and as it lies there."""
    return ModelError(
        f"the run that lies there has {' and '.join(words)}",
        path=str(folder),
        allowed=f"{known or 'the command it was begun with'}, or delete the folder",
        **({"given": given} if given else {}),
    )


# --- a folder of one run at a time -----------------------------------------------------------------------------------


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """A folder, made if need be, that no other run may lock while the block runs; a run that is killed lets go of it.

    Raises
    ------
    ModelError : another run has it, or it cannot be made or opened.
    """
    handle = _locked(folder)
    try:
        yield
    finally:
        if handle is not None:
            with suppress(OSError):
                fcntl.flock(handle, fcntl.LOCK_UN)  # also that of forked workers, which have the handle too
            with suppress(OSError):
                os.close(handle)


def _locked(folder: Path) -> int | None:
    """Handle of the folder, whose lock goes with it; None where there are no locks."""
    for _ in range(_TRIES):
        try:
            folder.mkdir(exist_ok=True)
            if fcntl is None:
                return None
            handle = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        except FileExistsError:
            raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder") from None
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(handle), os.stat(folder)):
                return handle
        except OSError:
            pass  # another run has it, or it is gone by now
        os.close(handle)
    raise ModelError("another run writes there", path=str(folder), allowed="another output, or wait for its end")


def is_left_over(path: Path) -> bool:
    """Whether a file is the temporary one of a killed writer; asked of a locked folder, where no writer is alive."""
    return _LEFT_OVER.fullmatch(path.name) is not None


# --- numbers of a model ----------------------------------------------------------------------------------------------


def _leaves(value: object, path: str = "") -> Iterator[tuple[str, Values | float | None, object]]:
    """Path, number or array, and what is no number, of all parts of frozen data: dataclasses and tuples."""
    if isinstance(value, np.ndarray | float):
        yield path, value, None
    elif is_dataclass(value) and not isinstance(value, type):
        yield path, None, type(value).__name__
        for name in _numbered(value):
            yield from _leaves(getattr(value, name), f"{path}.{name}")
    elif isinstance(value, tuple):
        yield path, None, len(value)
        names = getattr(value, "_fields", range(len(value)))
        for name, entry in zip(names, value, strict=True):
            yield from _leaves(entry, f"{path}.{name}")
    elif isinstance(value, str | int | None):
        yield path, None, value
    else:
        yield path, None, str(value)


def _with_leaves(value: Any, kept: Mapping[str, Values], path: str = "") -> Any:
    """The same data with the numbers of `_leaves` put in."""
    if isinstance(value, np.ndarray):
        return kept[path]
    if isinstance(value, float):
        return type(value)(kept[path])
    if is_dataclass(value) and not isinstance(value, type):
        numbered = {name: getattr(value, name) for name in _numbered(value)}
        return replace(value, **{name: _with_leaves(leaf, kept, f"{path}.{name}") for name, leaf in numbered.items()})
    if isinstance(value, tuple):
        names = getattr(value, "_fields", range(len(value)))
        entries = [_with_leaves(entry, kept, f"{path}.{name}") for name, entry in zip(names, value, strict=True)]
        return type(value)(*entries) if hasattr(value, "_fields") else tuple(entries)
    return value


def _numbered(value: Any) -> list[str]:
    """Fields of a dataclass that may hold numbers of the equation."""
    return [field.name for field in fields(value) if field.name not in _TEXTS]


def structure(model: object) -> str:
    """Digest of the names and the structure of frozen data such as a System, without rounded numbers."""
    digest = hashlib.sha256()
    for path, number, other in _leaves(model):
        shape = np.shape(number) if number is not None else other
        digest.update(f"{path} {shape}\n".encode())
    return f"sha256 {digest.hexdigest()}"


def with_numbers(model: Model, kept: Mapping[str, Values], *, compared: str, folder: Path) -> Model:
    """Frozen data with kept numbers in place of its own; itself where all are the same, bit by bit.

    Parameters
    ----------
    compared : path of the part whose numbers must agree up to rounding; of the others the shapes must.

    Raises
    ------
    ModelError : a number is missing or another one.
    """
    bits = True
    for name, leaf, _ in _leaves(model):
        if leaf is None:
            continue
        number, other = np.asarray(leaf), kept.get(name)
        if other is None or not _alike(number, other, values=name.startswith(f".{compared}")):
            raise _another_run(folder, [f"another model: {name.lstrip('.')} differs"])
        bits = bits and number.tobytes() == other.tobytes()
    return model if bits else _with_leaves(model, kept)


def _alike(number: Values, other: Values, *, values: bool) -> bool:
    """Whether two arrays are of one form; values : and differ by rounding alone."""
    if (number.shape, number.dtype) != (other.shape, other.dtype):
        return False
    if not values:
        return True
    if number.dtype.kind not in "fc":
        return np.array_equal(number, other)
    size = float(np.abs(number[np.isfinite(number)]).max(initial=0.0))
    return np.allclose(other, number, rtol=0.0, atol=_SAME * size, equal_nan=True)


# --- the run ---------------------------------------------------------------------------------------------------------


def segment_path(folder: Path, number: int) -> Path:
    """The file of a numbered segment."""
    return folder / f"{number:06d}.kept"


def begun(folder: Path) -> bool:
    """Whether a run has left anything in a folder or in those of its parts."""
    return any(folder.glob(BLOCKS)) or any(folder.rglob(_SEGMENTS))


@contextmanager
def open_folder(folder: Path, record: Mapping[str, object], *, resume: bool) -> Iterator[None]:
    """The folder of a run, made or taken up again, which no other run may have while the block runs.

    Parameters
    ----------
    record : says which run it is, with its verb: mappings, texts, numbers, arrays.
    resume : whether what lies there is wanted.

    Raises
    ------
    ModelError : another run has it; what lies there is not asked for, or is of another run; or the folder cannot be
        written.
    """
    about, question = folder / _RECORD, plain_identity(record)
    with locked_folder(folder):
        if about.is_file() and (resume or begun(folder)):
            if not resume:
                problem = "an interrupted run lies there"
                raise ModelError(problem, path=str(folder), allowed="resume, or delete the folder")
            _require_same(folder, question)
        elif not about.is_file() and not all(map(is_left_over, folder.iterdir())):
            raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
        else:
            try:
                (folder / _NUMBERS).unlink(missing_ok=True)  # of a run that has not come to its first segment
                write_text(about, json.dumps(question))
            except OSError as error:
                raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
        yield


@dataclass(slots=True, kw_only=True, eq=False)
class RunFolder:
    """Results kept in an open folder; without one nothing is.

    known : results that lay there, by part and place.  pending : new ones, (part, place, result).
    latest : what replaces itself, by name, not yet written.
    refer, restore : as of `write_plain`, set before the first use.
    segments : number of segments, -1 before they are read.  written : when the last one was [s].
    replaced : when the last one with what replaces itself was [s].
    """

    folder: Path | None = None
    known: dict[str, dict[Any, Any]] = field(default_factory=dict)
    pending: list[tuple[str, int | str, Any]] = field(default_factory=list)
    latest: dict[str, Any] = field(default_factory=dict)
    refer: Refer | None = None
    restore: Restore | None = None
    segments: int = -1
    written: float = field(default_factory=time.monotonic)
    replaced: float = field(default_factory=time.monotonic)

    def read(self) -> None:
        """Read all segments, once.

        Raises
        ------
        ModelError : one is missing, or cannot be read.
        """
        if self.segments >= 0 or self.folder is None:
            return
        number = len(list(self.folder.glob(_SEGMENTS)))
        for path in (segment_path(self.folder, i) for i in range(number)):
            if not path.is_file():
                raise ModelError("not a run that can be continued: a segment is missing", path=str(path))
            for name, place, result in read_plain(path, restore=self.restore):
                self.known.setdefault(name, {})[place] = result
        self.segments = number  # only now: a segment that cannot be read must not be written over

    def part(self, name: str, keys: Sequence[str] | None = None) -> KeptPart:
        """The results of one part of the run."""
        return KeptPart(of=self, name=name, keys=keys)

    def made(self, name: str, make: Callable[[], Value]) -> Value:
        """The value that has been kept under a name; where none has, it is made, and kept at once."""
        part = self.part(name)
        if 0 in part.known:
            kept: Value = part.known[0]
            return kept
        value = make()
        part.add(0, value)
        self.write()
        return value

    def value(self, name: str) -> Any:
        """What has been kept by `keep_value`, None where nothing has."""
        return self.part(name).known.get(0)

    def keep_value(self, name: str, value: object) -> None:
        """Keep a value in place of the one before; written now and then with a result that comes after it."""
        if self.folder is not None:
            self.latest[name] = value

    def add(self, name: str, place: int | str, result: object) -> None:
        """Keep the result of a place or key of a part."""
        if self.folder is not None:
            self.pending.append((name, place, result))
            now = time.monotonic()
            if now - self.written >= _EVERY:
                self.write(latest=now - self.replaced >= _LATEST * _EVERY)

    def write(self, *, latest: bool = True) -> None:
        """Write what is pending; latest : with what replaces itself."""
        self.read()
        entries = [*self.pending, *((name, 0, value) for name, value in self.latest.items() if latest)]
        if self.folder is not None and entries:
            write_plain(segment_path(self.folder, self.segments), entries, refer=self.refer)
            self.segments, self.pending, self.latest = self.segments + 1, [], {} if latest else self.latest
        self.written = time.monotonic()
        self.replaced = self.written if latest else self.replaced


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeptPart:
    """The results of one part of the run by place, or by key where places are not the same in every run.

    keys : of the places, None where each is its own.
    """

    of: RunFolder
    name: str
    keys: Sequence[str] | None = None

    @property
    def known(self) -> Mapping[int, Any]:
        """Results that a run before has left, by place."""
        self.of.read()
        known: Mapping[Any, Any] = self.of.known.get(self.name, {})
        if self.keys is None:
            return known
        return {place: known[key] for place, key in enumerate(self.keys) if key in known}

    def add(self, place: int, result: object) -> None:
        """Keep a result."""
        self.of.add(self.name, place if self.keys is None else self.keys[place], result)


@contextmanager
def run_folder(
    folder: str | Path | None,
    model: Model,
    *,
    verb: str,
    options: Mapping[str, object],
    resume: bool,
    compared: str = "",
) -> Iterator[tuple[Model, RunFolder]]:
    """The model a run works with, and what keeps its results: nothing without a folder.  All is written at the end.

    Parameters
    ----------
    model : frozen data, such as a System, or a text.  options : those of the run: texts, numbers, arrays.
    compared : dotted path of the part of the model that says which it is; all of it where empty.
    resume : whether what lies there is wanted.

    Raises
    ------
    ModelError : a run is to go on without a folder; as of `open_folder`; a number of the model is another one; a file
        cannot be read or written.
    """
    if folder is None and resume:
        raise ModelError("needs the file of the run that was stopped", path="resume", allowed="-o FILE.nc, or folder")
    if folder is None:
        yield model, RunFolder()
        return
    path = Path(folder)
    part = attrgetter(compared)(model) if compared else model
    record = {"verb": verb, "versions": versions(), "model": structure(part), "options": options}
    with open_folder(path, record, resume=resume):
        numbers = path / _NUMBERS
        if numbers.is_file():
            kept = read_plain(numbers, what="the numbers")
            model = with_numbers(model, kept, compared=compared, folder=path)
        elif begun(path):
            raise ModelError("not a run that can be continued", path=str(numbers))
        else:
            numbered = {name: np.asarray(number) for name, number, _ in _leaves(model) if number is not None}
            write_plain(numbers, numbered)
        results = RunFolder(folder=path)
        try:
            yield model, results
        finally:
            results.write()


def remove_folder(folder: Path, *, with_results: bool = True) -> None:
    """Delete the folder of a run that is whole, and those of its parts.

    Any other folder stays, and so does one that another run has, or in which something else lies.

    Parameters
    ----------
    with_results : else only what has nothing to go on from goes, also where it is not said yet which run it is.
    """
    if not folder.is_dir():
        return
    with suppress(ModelError, OSError), locked_folder(folder):
        known = (folder / _RECORD).is_file()
        if (with_results and not known) or (not with_results and begun(folder)):
            return
        if known:
            for part in folder.iterdir():
                if not part.is_symlink():
                    remove_folder(part, with_results=with_results)
        # the last first: a kill between leaves segments without a gap; the record at last
        results = sorted(folder.glob(_SEGMENTS), reverse=True)
        own = [folder / _NUMBERS, folder / _RECORD] if known else []
        for path in (*results, *filter(is_left_over, folder.iterdir()), *own):
            path.unlink(missing_ok=True)
        folder.rmdir()
