"""What a person hands over: arguments of functions, and files.

Arguments of what is called from Python are checked against its annotations before any work.  Files are read whole:
regular files up to a size, never a device, a pipe or a folder, nor the output.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from functools import cache, wraps
from inspect import Parameter, signature
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Annotated, Any, BinaryIO, ForwardRef, Literal, TypeVar, Union, cast, get_args, get_origin

from .errors import ModelError

Run = TypeVar("Run", bound=Callable[..., Any])


class _ByName(type):
    """A class of a heavy room, known by its name: an instance of it is there only where the room is imported."""

    def __instancecheck__(cls, value: object) -> bool:
        return any(base.__name__ == cls.__name__ for base in type(value).__mro__)


_Train, _System, _Dataset = _ByName("Train", (), {}), _ByName("System", (), {}), _ByName("Dataset", (), {})
_Numbers = float | Sequence[float]
# names in annotations that stand as texts
_NAMES: dict[str, Any] = {
    **{"Any": Any, "Callable": Callable, "Literal": Literal, "Mapping": Mapping, "Path": Path, "Sequence": Sequence},
    **{
        "Train": _Train,
        "System": _System,
        "Number": float | str,
        "ArrayLike": _Numbers,
        "Overrides": Mapping[str, Any],
    },
    **{name: _ByName(name, (), {}) for name in ("History", "Transfer", "Window")},
    "Source": str | Path | Mapping[str, Any] | _Train | _System,
    "NDArray": {float: _ByName("ndarray", (), {})},
    "np": SimpleNamespace(float64=float),
    "xr": SimpleNamespace(Dataset=_Dataset),
    "go": SimpleNamespace(Figure=_ByName("Figure", (), {})),
    "Datasets": Mapping[str, _Dataset],  # type: ignore[valid-type]
    "Each": Callable[..., Any],
}
_WORDS = {
    **{
        Any: "a value",
        object: "a value",
        NoneType: "None",
        bool: "True or False",
        int: "a whole number",
        float: "a number",
    },
    **{str: "a text", Path: "a path", bytes: "bytes", Mapping: "a mapping", Callable: "a function"},
}


def checked(function: Run) -> Run:
    """Let a function refuse arguments of other types than its annotations say, before any work.

    Raises
    ------
    ModelError : such an argument, by its name; of the function.
    """

    @wraps(function)
    def called(*arguments: Any, **options: Any) -> Any:
        check_arguments(function, arguments, options)
        return function(*arguments, **options)

    return cast(Run, called)


def check_arguments(function: Callable[..., Any], arguments: Sequence[Any], options: Mapping[str, Any]) -> None:
    """Refuse arguments of other types than the annotations of a function say.

    A float is any real number, also one of NumPy, but no fraction, an int a whole one, neither is a truth value; a
    sequence is whatever has a length and is counted through, but no text and no mapping.

    Raises
    ------
    ModelError : such an argument, by its name.  Arguments that are missing or unknown are left to Python.
    """
    places, further, kinds = _kinds(function)
    given = [*zip(places, arguments, strict=False), *((further, value) for value in arguments[len(places) :])]
    for name, value in (*given, *options.items()):
        if name in kinds and not _fits(value, kinds[name]):
            words, text = " or ".join(dict.fromkeys(_words(kinds[name]))), isinstance(value, str)
            kind = kinds[name]
            members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
            chosen = text and any(get_origin(one) is Literal for one in members)
            problem = "not one of them" if chosen else "of a wrong type"
            raise ModelError(problem, path=name, given=repr(value) if text else value, allowed=words)


@cache
def _kinds(function: Callable[..., Any]) -> tuple[tuple[str, ...], str, dict[str, Any]]:
    """Names of arguments that have a place, that of further ones, and annotations by name."""
    parameters = signature(function).parameters.values()
    places = tuple(one.name for one in parameters if one.kind is Parameter.POSITIONAL_OR_KEYWORD)
    further = next((one.name for one in parameters if one.kind is Parameter.VAR_POSITIONAL), "")
    return places, further, {one.name: _evaluated(function.__annotations__[one.name]) for one in parameters}


def _evaluated(annotation: Any) -> Any:
    """An annotation as an object, without what is annotated to it."""
    if get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if isinstance(annotation, ForwardRef):
        annotation = annotation.__forward_arg__
    return eval(annotation, dict(_NAMES)) if isinstance(annotation, str) else annotation


def _fits(value: Any, kind: Any) -> bool:
    """Whether a value is of a kind."""
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        value = value.item()  # a number of an array
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return any(_fits(value, one) for one in inner)
    if origin is Literal:
        return isinstance(value, str) and value in inner
    if origin in (Sequence, tuple):
        long = origin is Sequence or (_is_sequence(value) and len(value) == len(inner))
        return _is_sequence(value) and long and all(_fits(one, inner[0]) for one in value)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(
            _fits(key, inner[0]) and _fits(one, inner[1]) for key, one in value.items()
        )
    if kind in (int, float):
        return isinstance(value, Integral if kind is int else Real) and not isinstance(value, bool | Fraction)
    if kind is Any:
        return True
    return isinstance(value, {None: NoneType, Path: PathLike}.get(kind, origin or kind))


def _is_sequence(value: Any) -> bool:
    """Whether a value has a length and is counted through."""
    return not isinstance(value, str | bytes | Mapping) and hasattr(value, "__len__") and hasattr(value, "__getitem__")


def _words(kind: Any) -> Iterator[str]:
    """What a kind is called."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        for one in inner:
            yield from _words(one)
    elif origin is Literal:
        yield from map(repr, inner)
    elif origin in (Sequence, tuple):
        one = " or ".join(_words(inner[0]))
        yield f"({', '.join([one] * len(inner))})" if origin is tuple else f"a sequence [{one}, ...]"
    elif origin is Mapping:
        yield f"a mapping of {_WORDS[inner[0]]} to {' or '.join(_words(inner[1]))}"
    else:
        yield _WORDS.get(NoneType if kind is None else origin or kind, f"a {getattr(kind, '__name__', kind)}")


_TOO_LARGE = "too large"
# Bytes that are read at once.
_PIECE = 1 << 20
# files that the block of `outputs_apart` has read and will write; None outside of one
_USED: ContextVar[tuple[list[Path], list[Path]] | None] = ContextVar("used", default=None)


@contextmanager
def outputs_apart() -> Iterator[None]:
    """In the block no file is source and output, whatever it is called: the second use of it is refused."""
    token = _USED.set(([], []))
    try:
        yield
    finally:
        _USED.reset(token)


def as_input(file: str | Path) -> None:
    """Count a file among the sources.

    Raises
    ------
    ModelError : it is an output of the same block of `outputs_apart`.
    """
    if used := _USED.get():
        used[0].append(Path(file))
        for output in used[1]:
            _require_apart(Path(file), output)


def as_output(file: Path) -> None:
    """Count a file among the outputs, before the work.

    Raises
    ------
    ModelError : it has been read in the same block of `outputs_apart`.
    """
    if used := _USED.get():
        used[1].append(file)
        for source in used[0]:
            _require_apart(source, file)


def _require_apart(source: Path, output: Path) -> None:
    try:
        same = os.path.samefile(source, output)  # links are followed, and two names of one file are the same
    except (OSError, ValueError):  # one is not there, or a zero byte in the name
        return
    if same:
        problem = f"is {source}, which is read"
        raise ModelError(problem, path="--output", given=str(output), allowed="another file")


def read_bytes(file: str | Path, *, most: int, path: str = "", given: str = "", allowed: str = "") -> bytes:
    """The bytes of a regular file.

    Parameters
    ----------
    file : the file.  most : bytes it may have.
    path : where it is named, for an error; the file itself where empty.  given : how it is named there.
    allowed : what may stand there.

    Raises
    ------
    ModelError : no such file, no regular file (a device or a pipe may never end), too large, it cannot be read, or it
        is the output (`outputs_apart`).
    """

    as_input(file)
    raw, problem = b"", ""
    try:
        # asked before it is opened: opening a pipe waits, opening a device may do something
        problem = _unfit(os.stat(file), most)
        if not problem:
            with open(file, "rb") as opened:
                problem = _unfit(os.fstat(opened.fileno()), most)
                raw = b"" if problem else _read(opened, most)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        problem = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    if len(raw) > most:
        problem = _TOO_LARGE
    if problem:
        raise _refused(problem, given or file, path, f"at most {most} bytes" if problem == _TOO_LARGE else allowed)
    return raw


def _read(opened: BinaryIO, most: int) -> bytes:
    """At most one byte more than may be: a file of the system says no size, another may grow.

    In pieces: `read` of a number sets that many bytes aside first, which a limit of memory may refuse.
    """
    raw = bytearray()
    while len(raw) <= most and (piece := opened.read(min(_PIECE, most + 1 - len(raw)))):
        raw += piece
    return bytes(raw)


def _unfit(found: os.stat_result, most: int) -> str:
    """What is wrong with a file before it is read; nothing where it may be."""
    if stat.S_ISDIR(found.st_mode):
        return "cannot be read: is a folder"
    if not stat.S_ISREG(found.st_mode):
        return "cannot be read: is no regular file"
    return _TOO_LARGE if found.st_size > most else ""


def _refused(problem: str, file: str | Path, path: str, allowed: str) -> ModelError:
    if path:
        return ModelError(problem, path=path, given=str(file), allowed=allowed)
    return ModelError(problem, path=str(file), allowed=allowed)


def read_text(file: str | Path, *, most: int, path: str = "", given: str = "", allowed: str = "") -> str:
    """The text of a regular file in UTF-8, with or without byte order mark; parameters as of `read_bytes`.

    Raises
    ------
    ModelError : as of `read_bytes`, or no UTF-8.
    """
    raw = read_bytes(file, most=most, path=path, given=given, allowed=allowed)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise _refused(f"is not a text file (UTF-8), line {line}", given or file, path, allowed) from None
