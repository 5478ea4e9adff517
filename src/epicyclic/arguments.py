"""Arguments of what a person calls from Python, checked against its annotations before any work."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, wraps
from inspect import Parameter, signature
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Annotated, Any, ForwardRef, Literal, TypeVar, Union, cast, get_args, get_origin

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
            words = " or ".join(dict.fromkeys(_words(kinds[name])))
            raise ModelError("of a wrong type", path=name, given=value, allowed=words)


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
