"""What travels between the computing process, the page and its drawings: requests, and frames of results.

uint32 little-endian   bytes of the JSON
JSON, UTF-8            {"rev", "kind", "head", "arrays": [[name, [shape], offset in float32], ...]}, padded with
                       spaces so that the numbers begin at a multiple of four bytes
float32 little-endian  the arrays one behind the other
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...document.tables import PlainTable
from ...errors import ModelError

Numbers = NDArray[np.float32]
_LENGTH = struct.Struct("<I")


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What is asked of the computing process; picklable.

    rev : number of the state, counted by the session.  kind : ``live``: one frame; ``full``: all frames of a state.
    source, overrides : what `load` takes.  relative_speed : speed per operating speed that is shown [1].
    compiled : solve by numba; None: where that is installed and loaded, see `compute.compiler_ready`.
    """

    rev: int
    kind: Literal["live", "full"]
    source: PlainTable | Path
    overrides: Mapping[str, object] = field(default_factory=dict)
    relative_speed: float = 1.0
    compiled: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PageFrame:
    """One message of results.

    rev : of the state it belongs to.  kind : live, sweep, sharing, errors, job or failed.
    head : texts, labels and numbers, as JSON has them.  arrays : by name.
    """

    rev: int
    kind: str
    head: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, Numbers] = field(default_factory=dict)


def failed_frame(rev: int, error: Exception) -> PageFrame:
    """The frame of what cannot be computed: ``message``, ``path``, ``given`` and ``allowed`` of the head, all texts."""
    head = {"message": str(error), "path": "", "given": "", "allowed": ""}
    if isinstance(error, ModelError):
        head |= {"message": error.problem, "path": error.path, "allowed": error.allowed}
        # an error whose path has no value gives a bare object there
        head["given"] = "" if type(error.given) is object else str(error.given)[:200]
    return PageFrame(rev=rev, kind="failed", head=head)


def pack(frame: PageFrame) -> bytes:
    """A frame as bytes; numbers of the head that are not finite become null.

    Raises
    ------
    TypeError : something in the head is no JSON.
    """
    table, parts, offset = [], [], 0
    for name, array in frame.arrays.items():
        numbers = np.ascontiguousarray(array, dtype="<f4")
        table.append([name, list(np.shape(array)), offset])
        parts.append(numbers.tobytes())
        offset += numbers.size
    content = {"rev": frame.rev, "kind": frame.kind, "head": _plain(frame.head), "arrays": table}
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([_LENGTH.pack(len(text)), text, *parts])


def unpack(data: bytes) -> PageFrame:
    """The frame of `pack`.

    Raises
    ------
    ValueError : the bytes are no frame.
    """
    try:
        (length,) = _LENGTH.unpack_from(data)
        content = json.loads(data[4 : 4 + length].decode())
        numbers = np.frombuffer(data, dtype="<f4", offset=4 + length)
        arrays = {
            str(name): numbers[start : start + math.prod(shape)].reshape(shape).astype(np.float32)
            for name, shape, start in content["arrays"]
        }
        return PageFrame(rev=int(content["rev"]), kind=str(content["kind"]), head=content["head"], arrays=arrays)
    except (struct.error, KeyError, TypeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a frame: {error}") from error


def _plain(value: object) -> Any:
    """A value as JSON has it: numpy's numbers and arrays as numbers and lists, nan and infinity as null."""
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, int):
        return value
    raise TypeError(f"{type(value).__name__} in the head of a frame")
