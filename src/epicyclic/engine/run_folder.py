"""What a run has done so far, in a folder: whatever stops it, the same command goes on from there to the same bits.

`run.json` says which run it is.  Results of independent points stand in numbered segments, `000000.kept`, ..., and what
replaces itself in files of its own.  Every file is written aside and renamed, so that none is ever partly there, and
bears a digest.  One run at a time has the folder.

Numbers of a model, modes and projected rows among them, are rounded as BLAS and its number of threads have it.  A run
that is taken up again has them from its folder; those it is asked for must agree up to such rounding.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
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
Values = NDArray[Any]

MODEL_FILE = "model.numbers"
"""Numbers that a run has begun with."""
_ABOUT = "run.json"
# Endings of files with results.
_RESULTS = (".kept", ".latest", ".nc", ".json")
# Names of all files a run writes, with those of its sections and of a search; others in the folder are the user's.
_RUN_FILES = ("*.latest", "*.kept.nc", "search.json", "[0-9][0-9][0-9][0-9][0-9][0-9].kept")
# Bytes of run.json, which says every option in a few letters.
_MAX_ABOUT = 1_000_000
# Seconds between two segments: what a power cut takes at most, beside the points at work.
_EVERY = 1.0
# A folder that another run removes between making and locking is made again.
_TRIES = 5
# Numbers of one System made twice differ by rounding, 1e-13 of the largest of their array; other models differ by more.
_SAME = 1e-9
# What a result says about its model, and no number of the equation.
_TEXTS = ("provenance", "warnings", "causes")


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
        except BlockingIOError:
            os.close(handle)
            break
        except OSError:
            pass
        os.close(handle)
    raise ModelError("another run writes there", path=str(folder), allowed="another output, or wait for its end")


def _is_left_over(path: Path) -> bool:
    """Whether a file is the temporary one of a killed writer; asked of a locked folder, where no writer is alive."""
    return path.name.startswith(".") and path.name.endswith(".part")


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
    return digest.hexdigest()


def write_numbers(path: Path, model: object) -> None:
    """Write all numbers of frozen data, the file whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_plain(path, {name: np.asarray(number) for name, number, _ in _leaves(model) if number is not None})


def read_numbers(path: Path) -> dict[str, Values]:
    """The numbers of a file that `write_numbers` has written.

    Raises
    ------
    ModelError : it cannot be read, or is damaged.
    """
    numbers: dict[str, Values] = read_plain(path, what="the numbers")
    return numbers


def with_numbers(model: Model, kept: Mapping[str, Values], *, compared: str, path: Path) -> Model:
    """Frozen data with kept numbers in place of its own; itself where all are the same, bit by bit.

    Parameters
    ----------
    compared : path of the part whose numbers must agree up to rounding; of the others the shapes must.
    path : the file, for messages.

    Raises
    ------
    ModelError : a number is missing or another one.
    """
    bits = True
    for name, leaf, _ in _leaves(model):
        if leaf is None:
            continue
        number, other = np.asarray(leaf), kept.get(name)
        same = other is not None and other.shape == number.shape and other.dtype == number.dtype
        if same and other is not None and name.startswith(compared):
            same = _alike(number, other)
        if not same:
            raise ModelError(
                f"the run that lies there has another model: {name.lstrip('.')} differs",
                path=str(path.parent),
                allowed="the command it was begun with, or delete the folder",
            )
        bits = bits and other is not None and number.tobytes() == other.tobytes()
    result: Model = model if bits else _with_leaves(model, kept)
    return result


def _alike(number: Values, other: Values) -> bool:
    """Whether two arrays differ by rounding alone."""
    if number.dtype.kind not in "fc":
        return np.array_equal(number, other)
    finite = np.isfinite(number)
    size = float(np.abs(number[finite]).max(initial=0.0))
    near = bool(np.all(np.abs(number[finite] - other[finite]) <= _SAME * size))
    return near and np.array_equal(number[~finite], other[~finite], equal_nan=True)


# --- the run ---------------------------------------------------------------------------------------------------------


def segment_path(folder: Path, number: int) -> Path:
    """The file of a numbered segment."""
    return folder / f"{number:06d}.kept"


def begun(folder: Path) -> bool:
    """Whether a run has left anything in a folder or in those of its parts."""
    return any(path.suffix in _RESULTS and path.name != _ABOUT for path in folder.rglob("*.*"))


@contextmanager
def open_folder(
    folder: Path, *, verb: str, model: object, options: Mapping[str, object], resume: bool
) -> Iterator[None]:
    """The folder of a run, made or taken up again, which no other run may have while the block runs.

    Parameters
    ----------
    model : texts, numbers and frozen data of them that say which model it is, compared without rounded numbers.
    options : those of the run: texts, numbers, arrays.  resume : whether what lies there is wanted.

    Raises
    ------
    ModelError : another run has it; what lies there is not asked for, or is of another run; or the folder cannot be
        written.
    """
    about = folder / _ABOUT
    question = {
        "verb": verb,
        "version": package_version(),
        "model": structure(model),
        "options": {name: _digest(value) for name, value in options.items()},
    }
    with locked_folder(folder):
        if about.is_file() and (resume or begun(folder)):
            if not resume:
                problem = "an interrupted run lies there"
                raise ModelError(problem, path=str(folder), allowed="resume, or delete the folder")
            _require_same(about, question)
        elif not about.is_file() and not all(map(_is_left_over, folder.iterdir())):
            raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
        else:
            try:
                (folder / MODEL_FILE).unlink(missing_ok=True)  # of a run that has not come to its first segment
                write_text(about, json.dumps(question))
            except OSError as error:
                raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
        yield


def _require_same(about: Path, question: Mapping[str, Any]) -> None:
    """Refuse the folder of another run.

    Raises
    ------
    ModelError : it is that of another verb, version, model or of other options, which are named.
    """
    try:
        known = json.loads(read_text(about, most=_MAX_ABOUT))
        options = dict(known["options"])
        differs = [name for name in ("verb", "version", "model") if known[name] != question[name]]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ModelError("not a run that can be continued", path=str(about)) from error
    wanted = question["options"]
    others = [name for name in {**wanted, **options} if wanted.get(name) != options.get(name)]
    words = [f"another {name}" for name in differs] + ([f"other options ({', '.join(others)})"] if others else [])
    if words:
        raise ModelError(
            f"the run that lies there has {' and '.join(words)}",
            path=str(about.parent),
            allowed="the command it was begun with, or delete the folder",
        )


def _digest(value: object) -> str:
    """A value of an option in few letters."""
    if isinstance(value, np.ndarray):
        values = np.ascontiguousarray(value)
        return hashlib.sha256(f"{values.dtype}{values.shape}".encode() + values.tobytes()).hexdigest()
    text = json.dumps(value, default=str)
    return text if len(text) <= 80 else hashlib.sha256(text.encode()).hexdigest()


@dataclass(slots=True, kw_only=True, eq=False)
class RunFolder:
    """Results kept in an open folder.

    known : results that lay there, by part and place.  pending : new ones, (part, place, result).
    latest : what replaces itself, by name, not yet written.
    refer, restore : as of `write_plain`, set before the first use.
    segments : number of segments, -1 before they are read.  written : when the last one was [s].
    """

    folder: Path
    known: dict[str, dict[Any, Any]] = field(default_factory=dict)
    pending: list[tuple[str, int | str, Any]] = field(default_factory=list)
    latest: dict[str, Any] = field(default_factory=dict)
    refer: Refer | None = None
    restore: Restore | None = None
    segments: int = -1
    written: float = field(default_factory=time.monotonic)

    def read(self) -> None:
        """Read all segments, once.

        Raises
        ------
        ModelError : one cannot be read.
        """
        if self.segments >= 0:
            return
        number = 0
        while (path := segment_path(self.folder, number)).is_file():
            for name, place, result in read_plain(path, restore=self.restore):
                self.known.setdefault(name, {})[place] = result
            number += 1
        self.segments = number  # only now: a segment that cannot be read must not be written over

    def part(self, name: str, keys: Sequence[str] | None = None) -> KeptPart:
        """The results of one part of the run."""
        return KeptPart(of=self, name=name, keys=keys)

    def value(self, name: str) -> Any:
        """What has been kept under a name, None where nothing has.

        Raises
        ------
        ModelError : it cannot be read.
        """
        path = self.folder / f"{name}.latest"
        return read_plain(path, restore=self.restore) if path.is_file() else None

    def keep_value(self, name: str, value: object) -> None:
        """Keep a value in place of the one before; written after all results that came before it."""
        self.latest[name] = value
        self._write_in_time()

    def add(self, name: str, place: int | str, result: object) -> None:
        """Keep the result of a place or key of a part."""
        self.pending.append((name, place, result))
        self._write_in_time()

    def write(self) -> None:
        """Write what is pending."""
        self.read()
        if self.pending:
            write_plain(segment_path(self.folder, self.segments), self.pending, refer=self.refer)
            self.segments, self.pending = self.segments + 1, []
        for name in list(self.latest):
            write_plain(self.folder / f"{name}.latest", self.latest[name], refer=self.refer)
            del self.latest[name]
        self.written = time.monotonic()

    def _write_in_time(self) -> None:
        if time.monotonic() - self.written >= _EVERY:
            self.write()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeptPart:
    """The results of one part of a run by place, or by key where places are not the same in every run.

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
) -> Iterator[tuple[Model, RunFolder | None]]:
    """The model a run works with, and where it keeps its results: None without a folder.  All is written at the end.

    Parameters
    ----------
    model : frozen data, such as a System.  Others as of `open_folder`.

    Raises
    ------
    ModelError : as of `open_folder`; a number of the model is another one; a file cannot be read or written.
    """
    if folder is None:
        yield model, None
        return
    path = Path(folder)
    with open_folder(path, verb=verb, model=model, options=options, resume=resume):
        numbers = path / MODEL_FILE
        if numbers.is_file():
            model = with_numbers(model, read_numbers(numbers), compared="", path=numbers)
        else:
            write_numbers(numbers, model)
        kept = RunFolder(folder=path)
        try:
            yield model, kept
        finally:
            kept.write()


def remove_folder(folder: Path) -> None:
    """Delete the folder of a run that is whole, and those of its parts.

    Any other folder stays, and so does one that another run has, or in which something else lies.
    """
    if not (folder / _ABOUT).is_file():
        return
    with suppress(ModelError, OSError), locked_folder(folder):
        for part in _parts(folder):
            remove_folder(part)
        # the last first: a kill between leaves segments without a gap
        _remove(folder, [path for pattern in _RUN_FILES for path in sorted(folder.glob(pattern), reverse=True)])


def remove_without_results(folder: Path) -> None:
    """Delete the folder of a run, and those of its parts, that have nothing to go on from; any other stays."""
    if not (folder / _ABOUT).is_file():
        if folder.is_dir():  # stopped before it was said which run it is
            with suppress(ModelError, OSError), locked_folder(folder):
                for path in filter(_is_left_over, folder.iterdir()):
                    path.unlink()
                folder.rmdir()
        return
    with suppress(ModelError, OSError), locked_folder(folder):
        if not begun(folder):
            for part in _parts(folder):
                remove_without_results(part)
            _remove(folder, [])


def _parts(folder: Path) -> list[Path]:
    """Folders of the parts of a run."""
    return [path for path in folder.iterdir() if path.is_dir() and not path.is_symlink()]


def _remove(folder: Path, results: Sequence[Path]) -> None:
    """Delete files of a locked folder, then what says which run it is, and the folder where nothing else lies in it."""
    left = [path for path in folder.iterdir() if _is_left_over(path)]
    for path in (*results, *left, folder / MODEL_FILE, folder / _ABOUT):
        path.unlink(missing_ok=True)
    folder.rmdir()
