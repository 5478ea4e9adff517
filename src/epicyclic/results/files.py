"""Files that appear whole or not at all, the digest at the end of a result, and matrices for other programs.

HDF5 ends where its first block says; what follows is no part of it.  There the digest stands, so that any reader of
netCDF opens the file, and a damaged one is known before HDF5 parses it.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import stat
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from ..errors import ModelError
from ..user_input import as_input, checked

if TYPE_CHECKING:
    import xarray as xr


MATRIX_FILES = (".mat", ".npz")
# letters of the name that stand in that of the temporary file: 40 of four bytes each leave room below 255 bytes
_LETTERS = 40
_MARK = b"\nepicyclic result, SHA-256 of all bytes before: "
_SEAL = len(_MARK) + 64 + 1
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# place of the end of the file in the first block, by version of that block
_END_AT = {0: 40, 1: 44, 2: 28, 3: 28}
_BLOCK = 1 << 20
# deflate makes zeros 1030 times smaller at best: a file that declares more than that has lost its measure
_SWELL, _SMALL = 1100, 1_000_000
_NAME = 63  # characters of a name in MATLAB
_ATTRIBUTES = ("title", "version", "options", "warnings")


@cache
def package_version() -> str:
    """The version that is installed; "unknown" of a source tree that is not."""
    try:
        return version(__name__.partition(".")[0])
    except PackageNotFoundError:
        return "unknown"


# --- files that appear whole or not at all ---------------------------------------------------------------------------


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that takes the place of `path` when the block ends without an error.

    The content is written to a temporary file of a name of its own in the same folder, synchronised to disk, and
    renamed: two writers of one file leave the content of one of them.  A symbolic link is followed, so that its target
    is replaced.  An error or interruption in the block leaves `path` as it was and no temporary file; a writer that is
    killed leaves its temporary file ``.NAME.xxxxxxxxxxxx.part``, which no other writer ever takes.

    Parameters
    ----------
    path : the file to write.

    Raises
    ------
    ModelError : the file cannot be written; what lies there is a folder, a device, a pipe or write-protected.
    """
    try:
        target = _target(path)
        partial = _temporary(target)
        try:
            # exclusive creation: nobody else's file is opened, whatever its name
            with partial.open("xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            if target.is_file():
                partial.chmod(stat.S_IMODE(target.stat().st_mode))
            os.replace(partial, target)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error


def require_writable(path: str | Path) -> None:
    """Make sure, before the work, that a file can be written: a temporary one is made beside it and removed.

    Raises
    ------
    ModelError : as of `whole_file`.
    """
    try:
        partial = _temporary(_target(path))
        partial.open("xb").close()
        partial.unlink()
    except OSError as error:
        raise ModelError(f"cannot be written: {error.strerror or error}", path=str(path)) from error


def _target(path: str | Path) -> Path:
    """The file itself, links followed.

    Raises
    ------
    ModelError : what lies there is no file that may be replaced.  OSError : it cannot be asked.
    """
    try:
        target = Path(os.path.realpath(path))
        mode = os.lstat(target).st_mode
    except FileNotFoundError:
        return target
    except ValueError as error:  # a zero byte in the name
        raise ModelError(f"cannot be written: {error}", path=str(path)) from None
    if stat.S_ISREG(mode):
        if not os.access(target, os.W_OK):
            raise ModelError("cannot be written: is write-protected", path=str(path), allowed="a file of another name")
        return target
    what = "a folder" if stat.S_ISDIR(mode) else "a link to itself" if stat.S_ISLNK(mode) else "no regular file"
    raise ModelError(f"cannot be written: is {what}", path=str(path), allowed="a file")


def _temporary(target: Path) -> Path:
    return target.with_name(f".{target.name[:_LETTERS]}.{secrets.token_hex(6)}.part")


def write_text(path: str | Path, text: str) -> None:
    """Write a text file (UTF-8) that appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    with whole_file(path) as file:
        file.write(text.encode("utf-8"))


# --- digest at the end of a result -----------------------------------------------------------------------------------


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
            if not isinstance(opened.get(name, getlink=True), h5py.HardLink):
                raise ModelError(f"not a result file: {name} is a link")
            member = opened[name]
            if isinstance(member, h5py.Group):
                raise ModelError(f"not a result file: {name} is a group")
            if isinstance(member, h5py.Dataset) and (member.external or member.is_virtual):
                raise ModelError(f"not a result file: the data of {name} lie in another file")
            declared += int(getattr(member, "nbytes", 0))
    file.seek(0)
    if declared > max(_SMALL, _SWELL * size):
        raise ModelError(f"not a result file: it declares {declared} bytes and has {size}")


# --- results as arrays by name, for MATLAB and NumPy -----------------------------------------------------------------


@checked
def save_matrices(result: xr.Dataset, path: str | Path) -> Path:
    """Write every variable of a result as an array of its name; the file appears whole or not at all.

    ``.mat`` (level 5) is opened by MATLAB's ``load`` and `scipy.io.loadmat`: one-dimensional arrays are columns, texts
    cells.  ``.npz`` is opened by `numpy.load`, without pickle.  Names, units and dims are those of the Dataset;
    ``dims_NAME`` lists the dims of a variable; title, version, options and warnings are texts.

    Raises
    ------
    ModelError : another suffix, or the file cannot be written.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in MATRIX_FILES:
        raise ModelError("no such kind of file", path="path", given=target.name, allowed=" or ".join(MATRIX_FILES))
    import numpy as np  # heavy: every command imports this file

    arrays: dict[str, Any] = {}
    for key, variable in result.variables.items():
        name = _valid(str(key))
        values = variable.values
        arrays[name] = values.astype(str) if values.dtype.kind in "OU" else values
        if variable.ndim > 1:
            arrays[_valid(f"dims_{name}")] = np.array([str(dim) for dim in variable.dims])
    arrays |= {name: np.array(str(result.attrs.get(name, ""))) for name in _ATTRIBUTES}
    content = BytesIO()
    if kind == ".npz":
        np.savez_compressed(content, **arrays)
    else:
        from scipy.io import savemat

        for name, array in arrays.items():
            if array.dtype.kind == "U":
                arrays[name] = array.astype(object) if array.ndim else str(array)
        savemat(content, arrays, oned_as="column", do_compression=True, long_field_names=True)
    with whole_file(target) as file:
        file.write(content.getvalue())
    return target


def _valid(name: str) -> str:
    """A name as MATLAB takes it: a letter first, then letters, digits and underscores."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return (plain if plain[:1].isalpha() else f"x{plain}")[:_NAME]
