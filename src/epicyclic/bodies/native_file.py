"""The native file of a body: arrays by name, as .npz or .mat."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import sparse
from scipy.io import loadmat, whosmat

from ..errors import ModelError
from .reduced_body import MATRICES, MAX_BYTES, Matrix, ReducedBody, in_si, refused

_FORMAT, _MAX_ROOM, _TOO_LARGE = 1, 2 * MAX_BYTES, f"needs more than {2 * MAX_BYTES} bytes in memory"
_PARTS = ("data", "indices", "indptr")  # of a sparse matrix, in rows
# arrays of the file and their shapes: -1 any length, 0 as many as coordinates
_SHAPES: dict[str, tuple[int, ...]] = {
    **{"node_id": (-1,), "node_xyz": (-1, 3), "dof_node": (0,), "dof_dir": (0,)},
    **{"shape_node": (-1,), "shape_dir": (-1,), "shape": (-1, 0), "mass": (), "centre": (3,), "inertia": (3, 3)},
}
_NAMES = {"format", "units", "source", *MATRICES, *_SHAPES, *(f"{m}_{part}" for m in MATRICES for part in _PARTS)}


def native_bytes(body: ReducedBody) -> bytes:
    """The content of the native file .npz of a body, in kg m s; `native_body` reads the same bits."""
    content: dict[str, Any] = {"format": _FORMAT, "units": "kg m s", "source": body.source}
    for name in MATRICES:
        matrix = getattr(body, name)
        if sparse.issparse(matrix):
            content |= {f"{name}_{part}": getattr(matrix, part) for part in _PARTS}
        elif matrix is not None:
            content[name] = matrix
    content |= {name: getattr(body, name) for name in _SHAPES if getattr(body, name) is not None}
    with io.BytesIO() as file:
        np.savez_compressed(file, **content)
        return file.getvalue()


def native_body(raw: bytes, where: str) -> ReducedBody:
    """The body that a native file holds, in SI, not yet checked.

    raw : content of a .npz (without pickled objects) or .mat file of version 5.  where : its name, for errors.

    Raises
    ------
    ModelError : no such file, a name or a size that does not fit, no units.
    """
    values = _content(raw, where)
    for name in values.keys() - _NAMES:
        raise refused(where, name, "unknown name", ", ".join(sorted(_NAMES)))
    for name in ("node_id", "node_xyz", "dof_node", "dof_dir", "M", "K"):
        if name not in values and f"{name}_data" not in values:
            raise refused(where, name, "missing", f"an array{', or its parts as of csr_array' if name in 'MK' else ''}")
    single = {name: one.item() for name, one in values.items() if not sparse.issparse(one) and one.size == 1}
    if single.get("format") != _FORMAT:
        raise refused(where, "format", "not the format of a body", str(_FORMAT))
    count = values["dof_node"].size
    given: dict[str, Any] = {name: str(single.get(name, "")) for name in ("units", "source")}
    given |= {name: _array(values, name, shape, count, where) for name, shape in _SHAPES.items() if name in values}
    given |= {name: _matrix(values, name, count, where) for name in MATRICES}
    return in_si(ReducedBody(**given), where)


def _content(raw: bytes, where: str) -> Mapping[str, Any]:
    """Arrays by name; what they would need in memory is asked first."""
    try:
        if raw[:2] != b"PK":
            dense = (shape for _, shape, kind in whosmat(io.BytesIO(raw)) if kind != "sparse")
            if sum(8 * math.prod(shape) for shape in dense) > _MAX_ROOM:
                raise ValueError(_TOO_LARGE)
            return {name: one for name, one in loadmat(io.BytesIO(raw)).items() if not name.startswith("__")}
        with zipfile.ZipFile(io.BytesIO(raw)) as packed:
            if sum(entry.file_size for entry in packed.infolist()) > _MAX_ROOM:
                raise ValueError(_TOO_LARGE)
        with np.load(io.BytesIO(raw), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # whatever a damaged file makes of a reader
        allowed = "a body as .npz, or as .mat of version 5 (-v6, -v7)"
        raise ModelError(f"cannot be read: {error}", path=where, allowed=allowed) from None


def _numbers(values: Mapping[str, Any], name: str, where: str) -> Any:
    """Real numbers, whole ones where they count nodes and directions."""
    value = values[name]
    if value.dtype.kind not in "fiu":
        raise refused(where, name, "no real numbers", "real numbers")
    if not name.endswith(("_node", "_dir", "_id", "_indices", "_indptr")):
        return value.astype(float)
    if np.any(value != np.round(value)) or np.any(np.abs(value) > 2**53):
        raise refused(where, name, "no whole numbers", "numbers of nodes and directions")
    return value.astype(np.int64)


def _array(values: Mapping[str, Any], name: str, shape: tuple[int, ...], count: int, where: str) -> Any:
    """An array of a shape; MATLAB has vectors and numbers as rows or columns of a matrix."""
    value, want = _numbers(values, name, where), tuple(count if one == 0 else one for one in shape)
    if value.ndim != len(want) and value.size == max(value.shape, default=1):
        value = value.reshape(-1) if want else value.reshape(())
    if value.ndim != len(want) or any(one not in (-1, have) for one, have in zip(want, value.shape, strict=True)):
        words = ", ".join("any" if one < 0 else str(one) for one in want)
        raise refused(where, name, "of another shape", f"({words})", given=value.shape)
    return value if want else float(value)


def _matrix(values: Mapping[str, Any], name: str, count: int, where: str) -> Matrix:
    """A matrix (count, count), dense or sparse; None where there is none."""
    parts = [f"{name}_{part}" for part in _PARTS]
    if name in values and not sparse.issparse(values[name]):
        return _array(values, name, (0, 0), count, where)
    if name not in values and not values.keys() & set(parts):
        return None
    try:
        if name in values:
            given = _numbers(values, name, where)
        else:
            held = tuple(_array(values, part, (-1,), count, where) for part in parts)
            given = sparse.csr_array(held, shape=(count, count))
        # of a matrix that ends with no entry scipy checks no more
        if np.any(np.diff(given.indptr) < 0):
            raise ValueError("index pointers go back")
        given.check_format(full_check=True)
        matrix = sparse.csr_array(given, shape=(count, count))
    except (KeyError, ValueError, TypeError) as error:
        raise refused(where, name, f"no sparse matrix: {error}", f"({count}, {count}), rows as of csr_array") from None
    matrix.sort_indices()
    if not matrix.has_canonical_format:
        raise refused(where, name, "has an entry twice", "each entry once")
    return matrix
