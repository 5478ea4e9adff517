"""What a run that goes on elsewhere needs to come to the same bits: every number of its equation, on disk.

Modes, projected rows and the start are rounded as BLAS and its number of threads have it.  A run that is taken up again
has them from its folder; the numbers of the System it is asked for must agree with the kept ones up to such rounding.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from .plain import read_plain, write_plain

__all__ = ["read_numbers", "structure", "with_numbers", "write_numbers"]

T = TypeVar("T")
Values = NDArray[Any]

# Numbers of one System made twice differ by rounding, 1e-13 of the largest of their array; other models differ by more.
_SAME = 1e-9
# What a result says about its model, and no number of the equation.
_TEXTS = ("provenance", "warnings", "causes")


def _leaves(value: object, path: str = "") -> Iterator[tuple[str, Values | float | None, object]]:
    """Path, number or array, and what is no number, of all parts of frozen data: dataclasses and tuples."""
    if isinstance(value, np.ndarray | float):
        yield path, value, None
    elif is_dataclass(value) and not isinstance(value, type):
        yield path, None, type(value).__name__
        for field in fields(value):
            if field.name not in _TEXTS:
                yield from _leaves(getattr(value, field.name), f"{path}.{field.name}")
    elif isinstance(value, tuple):
        yield path, None, len(value)
        names = getattr(value, "_fields", range(len(value)))
        for name, part in zip(names, value, strict=True):
            yield from _leaves(part, f"{path}.{name}")
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
        parts = {
            field.name: _with_leaves(getattr(value, field.name), kept, f"{path}.{field.name}")
            for field in fields(value)
            if field.name not in _TEXTS
        }
        return replace(value, **parts)
    if isinstance(value, tuple):
        names = getattr(value, "_fields", range(len(value)))
        found = [_with_leaves(part, kept, f"{path}.{name}") for name, part in zip(names, value, strict=True)]
        return type(value)(*found) if hasattr(value, "_fields") else tuple(found)
    return value


def structure(model: object) -> str:
    """Digest of the names and the structure of frozen data such as a System, without rounded numbers."""
    digest = hashlib.sha256()
    for path, number, other in _leaves(model):
        shape = np.shape(number) if number is not None else other
        digest.update(f"{path} {shape}\n".encode())
    return digest.hexdigest()


def write_numbers(path: Path, given: object) -> None:
    """Write all numbers of frozen data, the file whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_plain(path, {name: np.asarray(number) for name, number, _ in _leaves(given) if number is not None})


def read_numbers(path: Path) -> dict[str, Values]:
    """The numbers of a file that `write_numbers` has written.

    Raises
    ------
    ModelError : it cannot be read, or is damaged.
    """
    found: dict[str, Values] = read_plain(path, what="the numbers")
    return found


def with_numbers(given: T, kept: Mapping[str, Values], *, compared: str, path: Path) -> T:
    """Data with kept numbers in place of its own; itself where all are the same, bit by bit.

    Parameters
    ----------
    compared : path of the part whose numbers must agree up to rounding; of the others the shapes must.
    path : the file, for messages.

    Raises
    ------
    ModelError : a number is missing or another one.
    """
    bits = True
    for name, number, _ in _leaves(given):
        if number is None:
            continue
        other, own = kept.get(name), np.asarray(number)
        same = other is not None and other.shape == own.shape and other.dtype == own.dtype
        if same and other is not None and name.startswith(compared):
            same = _alike(own, other)
        if not same:
            raise ModelError(
                f"the run that lies there has another model: {name.lstrip('.')} differs",
                path=str(path.parent),
                allowed="the command it was begun with, or delete the folder",
            )
        bits = bits and other is not None and own.tobytes() == other.tobytes()
    result: T = given if bits else _with_leaves(given, kept)
    return result


def _alike(own: Values, other: Values) -> bool:
    """Whether two arrays differ by rounding alone."""
    if own.dtype.kind not in "fc":
        return np.array_equal(own, other)
    finite = np.isfinite(own)
    size = float(np.abs(own[finite]).max(initial=0.0))
    near = bool(np.all(np.abs(own[finite] - other[finite]) <= _SAME * size))
    return near and np.array_equal(own[~finite], other[~finite], equal_nan=True)
