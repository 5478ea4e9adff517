"""What a run has done so far, in a folder: whatever stops it, the same command goes on from there to the same bits.

`run.json` says which run it is.  Results of independent points stand in numbered segments, `000000.kept`, ..., and what
replaces itself in files of its own.  Every file is written aside and renamed, so that none is ever partly there, and
bears a digest.  One run at a time has the folder.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..errors import ModelError
from ..input_files import read_text
from .files import package_version, write_text
from .kept_numbers import read_numbers, structure, with_numbers, write_numbers
from .locked_folder import is_left_over, locked_folder
from .plain import Refer, Restore, read_plain, write_plain

__all__ = [
    "MODEL_FILE",
    "KeptPart",
    "RunFolder",
    "begun",
    "open_folder",
    "remove_folder",
    "remove_without_results",
    "run_folder",
    "segment_path",
]

Model = TypeVar("Model")

MODEL_FILE = "model.numbers"
"""Numbers that a run has begun with."""
_ABOUT = "run.json"
# Endings of files with results.
_RESULTS = (".kept", ".latest", ".nc", ".json")
# Names of all files a run writes, with those of its sections and of a search; others in the folder are the user's.
_SEGMENTS = "[0-9][0-9][0-9][0-9][0-9][0-9].kept"
_OWN = ("*.latest", "*.kept.nc", "search.json", _SEGMENTS)
# Bytes of run.json, which says every option in a few letters.
_MAX_ABOUT = 1_000_000
# Seconds between two segments: what a power cut takes at most, beside the points at work.
_EVERY = 1.0


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
    with locked_folder(folder):
        _begin(folder, verb, model, options, resume=resume)
        yield


def _begin(folder: Path, verb: str, model: object, options: Mapping[str, object], *, resume: bool) -> None:
    """Say in a locked folder which run it is, or make sure that it is the one that lies there."""
    about = folder / _ABOUT
    question = {
        "verb": verb,
        "version": package_version(),
        "model": structure(model),
        "options": {name: _digest(value) for name, value in options.items()},
    }
    if about.is_file() and (resume or begun(folder)):
        if not resume:
            raise ModelError("an interrupted run lies there", path=str(folder), allowed="resume, or delete the folder")
        _require_same(about, question)
    elif not about.is_file() and not all(map(is_left_over, folder.iterdir())):
        raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
    else:
        try:
            (folder / MODEL_FILE).unlink(missing_ok=True)  # of a run that has not come to its first segment
            write_text(about, json.dumps(question))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error


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
    own = question["options"]
    others = [name for name in {**own, **options} if own.get(name) != options.get(name)]
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
    latest : what replaces itself, by name, not yet written.  refer, restore : as of `plain`, set before the first use.
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
        self.segments = 0
        while (path := segment_path(self.folder, self.segments)).is_file():
            for name, place, result in read_plain(path, restore=self.restore):
                self.known.setdefault(name, {})[place] = result
            self.segments += 1

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
        found: Mapping[Any, Any] = self.of.known.get(self.name, {})
        if self.keys is None:
            return found
        return {place: found[key] for place, key in enumerate(self.keys) if key in found}

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

    Numbers of a model are rounded as BLAS and its number of threads have it.  A run that is taken up again has them
    from its folder; those it is asked for must agree up to such rounding.

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
    place = Path(folder)
    with open_folder(place, verb=verb, model=model, options=options, resume=resume):
        numbers = place / MODEL_FILE
        if numbers.is_file():
            model = with_numbers(model, read_numbers(numbers), compared="", path=numbers)
        else:
            write_numbers(numbers, model)
        kept = RunFolder(folder=place)
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
        for part in folder.iterdir():
            if part.is_dir() and not part.is_symlink():
                remove_folder(part)
        own = [path for pattern in _OWN for path in sorted(folder.glob(pattern), reverse=True)]
        # a kill between leaves segments without a gap
        _remove(folder, own)


def remove_without_results(folder: Path) -> None:
    """Delete the folder of a run, and those of its parts, that have nothing to go on from; any other stays."""
    if not (folder / _ABOUT).is_file():
        if folder.is_dir():  # stopped before it was said which run it is
            with suppress(ModelError, OSError), locked_folder(folder):
                for path in filter(is_left_over, folder.iterdir()):
                    path.unlink()
                folder.rmdir()
        return
    with suppress(ModelError, OSError), locked_folder(folder):
        if not begun(folder):
            for part in folder.iterdir():
                if part.is_dir() and not part.is_symlink():
                    remove_without_results(part)
            _remove(folder, [])


def _remove(folder: Path, own: Sequence[Path]) -> None:
    """Delete files of a locked folder, then what says which run it is, and the folder where nothing else lies in it."""
    left = [path for path in folder.iterdir() if is_left_over(path)]
    for path in (*own, *left, folder / MODEL_FILE, folder / _ABOUT):
        path.unlink(missing_ok=True)
    folder.rmdir()
