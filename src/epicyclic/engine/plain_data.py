"""Frozen data as plain numbers in one file, and back to the same bits: no pickle, nothing that runs when it is read.

A file is a line of JSON, which says how the parts hang together, the numbers of all arrays behind it, and at the end
the SHA-256 of all bytes before.  Dataclasses of this package are known by their names; an object that stands in several
places is one object again.  A Dataset is its variables and attributes.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ModelError
from ..results.files import whole_file
from ..user_input import read_bytes

Refer = Callable[[object], Any]
"""Says of an object how it is to be found again, in plain data, or None where it is to be written."""
Restore = Callable[[Any], object]
"""The object of which `Refer` has said so."""

_PACKAGE = __name__.partition(".")[0]
# Kinds of arrays whose bytes are numbers or texts.
_KINDS = "fciubU"
_DIGEST = hashlib.sha256().digest_size
# bytes: a run may hold 1.6 GB of numbers
_MAX_BYTES = 4_000_000_000


class _Writer:
    """What is written so far: objects, once each, and bytes of arrays."""

    def __init__(self, refer: Refer | None) -> None:
        self.refer = refer
        self.objects = list[Any]()
        self.numbers = dict[int, int]()  # id -> number of an object
        self.alive = list[object]()
        self.blobs, self.size = list[bytes](), 0

    def tree(self, value: Any) -> Any:
        """A value as JSON has it."""
        if isinstance(value, np.ndarray | np.generic):
            return self._array(value)
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, complex):
            return {"complex": [value.real, value.imag]}
        if isinstance(value, Fraction):
            return {"fraction": [value.numerator, value.denominator]}
        if isinstance(value, list):
            return [self.tree(entry) for entry in value]
        if isinstance(value, dict):
            return {"dict": [[self.tree(key), self.tree(entry)] for key, entry in value.items()]}
        if isinstance(value, tuple) and not hasattr(value, "_fields"):
            return {"tuple": [self.tree(entry) for entry in value]}
        if type(value).__module__.partition(".")[0] == "xarray":  # not imported here: half a second
            variables = {
                name: (name in value.coords, one.dims, one.values, dict(one.attrs))
                for name, one in value.variables.items()
            }
            return {"dataset": self.tree((variables, dict(value.attrs)))}
        return self._object(value)

    def _array(self, value: Any) -> dict[str, Any]:
        array = np.asarray(value)
        if array.dtype.kind == "O":
            texts = array.ravel().tolist()
            if not all(isinstance(text, str) for text in texts):
                raise TypeError(f"an array of {array.dtype} that holds more than texts")
            return {"texts": texts, "shape": array.shape}
        if array.dtype.kind not in _KINDS:
            raise TypeError(f"an array of {array.dtype}")
        # sums depend on how the axes lie in memory
        axes = sorted(range(array.ndim), key=lambda axis: -abs(array.strides[axis]))
        data = np.ascontiguousarray(array.transpose(axes)).tobytes()
        tree = {"array": array.dtype.str, "shape": array.shape, "axes": axes, "at": self.size}
        if not isinstance(value, np.ndarray):
            tree["scalar"] = True
        self.blobs.append(data)
        self.size += len(data)
        return tree

    def _object(self, value: Any) -> dict[str, Any]:
        if id(value) in self.numbers:
            return {"object": self.numbers[id(value)]}
        known = None if self.refer is None else self.refer(value)
        kind = type(value)
        names = [field.name for field in fields(kind)] if is_dataclass(kind) else list(getattr(kind, "_fields", ()))
        if known is None and (not names or kind.__module__.partition(".")[0] != _PACKAGE):
            raise TypeError(f"{kind.__module__}.{kind.__qualname__} is no plain data")
        number = self.numbers[id(value)] = len(self.objects)
        self.alive.append(value)  # so that no other object gets its id
        self.objects.append(None)
        if known is not None:
            self.objects[number] = {"known": self.tree(known)}
        else:
            tree = {name: self.tree(getattr(value, name)) for name in names}
            self.objects[number] = {"class": [kind.__module__, kind.__qualname__], "fields": tree}
        return {"object": number}


class _Reader:
    """Objects read so far."""

    def __init__(self, objects: list[Any], blob: bytes, restore: Restore | None) -> None:
        self.objects, self.blob, self.restore = objects, blob, restore
        self.made = dict[int, Any]()

    def value(self, tree: Any) -> Any:
        """What `_Writer.tree` has been given."""
        if isinstance(tree, list):
            return [self.value(entry) for entry in tree]
        if not isinstance(tree, dict):
            return tree
        if "array" in tree:
            return self._array(tree)
        if "texts" in tree:
            return np.array(tree["texts"], dtype=object).reshape(tree["shape"])
        if "object" in tree:
            return self._object(tree["object"])
        if "tuple" in tree:
            return tuple(self.value(entry) for entry in tree["tuple"])
        if "dict" in tree:
            return {self.value(key): self.value(entry) for key, entry in tree["dict"]}
        if "complex" in tree:
            return complex(*tree["complex"])
        if "dataset" in tree:
            import xarray as xr

            variables, attrs = self.value(tree["dataset"])
            labels = {name: one[1:] for name, one in variables.items() if one[0]}
            return xr.Dataset({name: one[1:] for name, one in variables.items() if not one[0]}, labels, attrs)
        return Fraction(*tree["fraction"])

    def _array(self, tree: dict[str, Any]) -> Any:
        kind, axes = np.dtype(tree["array"]), tree["axes"]
        if kind.kind not in _KINDS:
            raise ValueError(f"an array of {kind}")
        shape = [tree["shape"][axis] for axis in axes]
        flat = np.frombuffer(self.blob, kind, int(np.prod(shape, dtype=np.int64)), tree["at"])
        array = flat.reshape(shape).copy().transpose(np.argsort(axes).astype(int))
        return array[()] if tree.get("scalar") else array

    def _object(self, number: int) -> Any:
        if number in self.made:
            return self.made[number]
        tree = self.objects[number]
        if "known" in tree:
            if self.restore is None:
                raise ValueError("an object that is not here")
            self.made[number] = self.restore(self.value(tree["known"]))
            return self.made[number]
        module, name = tree["class"]
        if module.partition(".")[0] != _PACKAGE:
            raise ValueError(f"{module}.{name} is no data of {_PACKAGE}")
        kind = getattr(import_module(module), name)
        if not (is_dataclass(kind) or hasattr(kind, "_fields")):
            raise ValueError(f"{module}.{name} is no data")
        self.made[number] = kind(**{field: self.value(entry) for field, entry in tree["fields"].items()})
        return self.made[number]


def plain_bytes(value: object) -> bytes:
    """Numbers, texts, arrays, and lists, tuples, dicts and dataclasses of them in bytes; the same for the same value.

    Raises
    ------
    TypeError : a value is none of these.
    """
    return b"".join(_pieces(value, None))


def plain_value(raw: bytes, restore: Restore | None = None) -> Any:
    """What `plain_bytes` has been given; restore : as of `read_plain`.

    Raises
    ------
    ValueError, KeyError, TypeError : other bytes.
    """
    head, _, blob = raw.partition(b"\n")
    parts = json.loads(head)
    return _Reader(parts["objects"], blob, restore).value(parts["value"])


def _pieces(value: object, refer: Refer | None) -> Iterator[bytes]:
    """The bytes of a value: a line of JSON, then its arrays."""
    writer = _Writer(refer)
    tree = writer.tree(value)
    yield json.dumps({"value": tree, "objects": writer.objects}).encode("utf-8")
    yield b"\n"
    yield from writer.blobs


def write_plain(path: Path, value: object, *, refer: Refer | None = None) -> None:
    """Write numbers, texts, arrays, and lists, tuples, dicts and dataclasses of them; whole or not at all.

    Parameters
    ----------
    refer : of objects that are found again elsewhere.

    Raises
    ------
    TypeError : a value is none of these.  ModelError : the file cannot be written.
    """
    digest = hashlib.sha256()
    with whole_file(path) as file:
        for piece in _pieces(value, refer):
            digest.update(piece)
            file.write(piece)
        file.write(digest.digest())


def read_plain(path: Path, *, restore: Restore | None = None, what: str = "a segment") -> Any:
    """What `write_plain` has written, to the same bits and the same layout of every array.

    Parameters
    ----------
    restore : gives the objects that the writer has referred to.  what : of a run the file holds, for an error.

    Raises
    ------
    ModelError : the file cannot be read, or its bytes are others than were written.
    """
    raw = memoryview(read_bytes(path, most=_MAX_BYTES))
    written, digest = raw[:-_DIGEST], raw[-_DIGEST:]
    if hashlib.sha256(written).digest() != digest:
        damaged = f"not {what} of a run: damaged, its bytes are others than were written"
        rest = "delete it and the segments after it, or the folder" if what == "a segment" else "delete the folder"
        raise ModelError(damaged, path=str(path), allowed=rest)
    try:
        return plain_value(bytes(written), restore)
    except Exception as error:  # whole, but written by another program
        raise ModelError(f"not {what} of a run: {error}", path=str(path)) from error
