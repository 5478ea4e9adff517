"""Digest at the end of a result file, and what is asked of a file before a library reads it.

HDF5 ends where its first block says; what follows is no part of it.  There the digest stands, so that any reader of
netCDF opens the file, and a damaged one is known before HDF5 parses it.
"""

from __future__ import annotations

import hashlib
import os
import stat
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import ModelError
from ..input_files import as_input

__all__ = ["has_seal", "require_contained", "seal", "sealed_file"]

_MARK = b"\nepicyclic result, SHA-256 of all bytes before: "
_SEAL = len(_MARK) + 64 + 1
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# place of the end of the file in the first block, by version of that block
_END_AT = {0: 40, 1: 44, 2: 28, 3: 28}
_BLOCK = 1 << 20
# deflate makes zeros 1030 times smaller at best: a file that declares more than that has lost its measure
_SWELL, _SMALL = 1100, 1_000_000


def seal(image: bytes | memoryview) -> bytes:
    """What is to be written after the bytes of a file."""
    return _MARK + hashlib.sha256(image).hexdigest().encode() + b"\n"


def has_seal(content: bytes) -> bool:
    """Whether the bytes of a file end with a digest; `sealed_file` verifies it."""
    return content[-_SEAL:].startswith(_MARK)


@contextmanager
def sealed_file(path: str | Path) -> Iterator[BinaryIO]:
    """A result file opened for reading, its digest verified where it has one.

    Raises
    ------
    ModelError : no such file, no regular file, no HDF5; bytes are missing, or others than were written; the
        output (`outputs_apart`).
    """
    as_input(path)
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise ModelError("not a result file: no regular file", path=str(path))
        with open(path, "rb") as file:
            problem = _damage(file)
            if problem:
                raise ModelError(f"not a result file: {problem}", path=str(path))
            file.seek(0)
            yield file
    except FileNotFoundError:
        raise ModelError("no such file", path=str(path)) from None
    except ModelError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise ModelError(f"cannot be read: {error}", path=str(path)) from None


def _damage(file: BinaryIO) -> str:
    """What is wrong with the bytes of a file; nothing of a whole one."""
    head = file.read(64)
    size = os.fstat(file.fileno()).st_size
    if not head.startswith(_SIGNATURE) or len(head) < 64 or head[8] not in _END_AT:
        return "no HDF5 file"
    at = _END_AT[head[8]]
    (end,) = struct.unpack("<Q", head[at : at + 8])
    if size < end:
        return f"damaged, {end - size} bytes are missing"
    if size == end:
        return ""  # of an earlier version, or written anew by another program
    if size - end != _SEAL:
        return "damaged, its size is another than was written"
    file.seek(0)
    digest, left = hashlib.sha256(), end
    while left:
        piece = file.read(min(_BLOCK, left))
        if not piece:
            return "damaged, bytes are missing"
        digest.update(piece)
        left -= len(piece)
    if file.read() != _MARK + digest.hexdigest().encode() + b"\n":
        return "damaged, its bytes are others than were written"
    return ""


def require_contained(file: BinaryIO) -> None:
    """Make sure that all data of an HDF5 file lie in it, and that no more is declared than it can hold.

    Raises
    ------
    ModelError : a link or data in another file, or sizes beyond the file.  Whatever h5py raises on a damaged file.
    """
    import h5py

    size = os.fstat(file.fileno()).st_size
    declared = 0
    with h5py.File(file, "r") as opened:
        for name in opened:
            _require_inside(opened, name)
            declared += int(getattr(opened[name], "nbytes", 0))
    file.seek(0)
    if declared > max(_SMALL, _SWELL * size):
        raise ModelError(f"not a result file: it declares {declared} bytes and has {size}")


def _require_inside(group: Any, name: str) -> None:
    """Raise ModelError for a member of a group that is not all in its file."""
    import h5py

    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise ModelError(f"not a result file: {name} is a link")
    member = group[name]
    if isinstance(member, h5py.Group):
        raise ModelError(f"not a result file: {name} is a group")
    if isinstance(member, h5py.Dataset) and (member.external or member.is_virtual):
        raise ModelError(f"not a result file: the data of {name} lie in another file")
