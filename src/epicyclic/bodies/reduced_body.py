"""A body by matrices: what it is, its rigid motions, and the native file (.npz, .mat).

A body has coordinates q.  A coordinate is the displacement or rotation of a node, or a mode without place.  Body axes
have z along the axis of the gear; nodes stand where they are undeformed.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.io import loadmat, whosmat

from ..errors import ModelError

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Matrix: TypeAlias = Any  # an Array, a csr_array of scipy, or None where there is none

# of the masses [kg] and lengths [m] of a file
UNITS = {"kg m s": (1.0, 1.0), "t mm s": (1e3, 1e-3)}
MAX_BYTES, MAX_DENSE, MAX_DOFS = 1 << 29, 3000, 200_000
_FORMAT, UNIT_WORDS = 1, ", ".join(f'"{one}"' for one in UNITS)
_MATRICES = ("M", "K", "C", "G1", "KG1", "D")
_PARTS = ("data", "indices", "indptr")  # of a sparse matrix, in rows
# arrays of the file and their shapes: -1 any length, 0 as many as coordinates
_SHAPES: dict[str, tuple[int, ...]] = {
    **{"node_id": (-1,), "node_xyz": (-1, 3), "dof_node": (0,), "dof_dir": (0,)},
    **{"shape_node": (-1,), "shape_dir": (-1,), "shape": (-1, 0), "mass": (), "centre": (3,), "inertia": (3, 3)},
}
_NAMES = {"format", "units", "source", *_MATRICES, *_SHAPES, *(f"{m}_{part}" for m in _MATRICES for part in _PARTS)}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReducedBody:
    """A body in n coordinates, SI: M q'' + (C + s G1) q' + (K + s^2 KG1) q = forces, s its speed [rad/s].

    M, K : (n, n), symmetric; dense, or sparse where a whole mesh is meant.
    C, G1, KG1 : (n, n) damping, gyroscopic terms per rad/s, stiffness per (rad/s)^2.
    D : (n, n) derivative along the angle of an axisymmetric body: its pattern turned back by psi is exp(psi D) q.
    node_id : (k,); node_xyz : (k, 3) [m].
    dof_node, dof_dir : (n,) node and direction of each coordinate: 1 to 3 x, y, z [m], 4 to 6 about them [rad], 0 a
        mode, whose mass is 1.
    shape_node, shape_dir, shape : (r,), (r,), (r, n) motion of nodes that are no coordinates.
    mass [kg], centre (3,) [m], inertia (3, 3) about it [kg m^2] : what is expected.
    units : of the file that was read.
    """

    M: Matrix
    K: Matrix
    C: Matrix = None
    G1: Matrix = None
    KG1: Matrix = None
    D: Array | None = None
    node_id: Index
    node_xyz: Array
    dof_node: Index
    dof_dir: Index
    shape_node: Index | None = None
    shape_dir: Index | None = None
    shape: Array | None = None
    mass: float | None = None
    centre: Array | None = None
    inertia: Array | None = None
    source: str = ""
    units: str = "kg m s"

    @property
    def modal(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are modes."""
        return np.equal(self.dof_dir, 0)

    def places(self, nodes: Index) -> Array:
        """(m, 3) coordinates of nodes [m]; KeyError of one that is not there."""
        at = {int(node): i for i, node in enumerate(self.node_id)}
        return self.node_xyz[[at[int(node)] for node in nodes]].reshape(-1, 3)


def rigid_rows(places: Array, directions: Index, point: Array | None = None) -> Array:
    """Rows (m, 6): what directions 1 to 6 at places (m, 3) [m] see of the motion x y z, rx ry rz of a point (3,)."""
    x, y, z = (places - (0.0 if point is None else point)).T
    zero, row = np.zeros_like(x), np.arange(len(places))
    cross = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)  # rotation to displacement
    block = np.tile(np.eye(6), (len(places), 1, 1))
    block[:, :3, 3:] = cross
    return block[row, directions - 1]


def rigid_motion(body: ReducedBody) -> Array:
    """Motions (n, 6) of the coordinates as the body moves rigidly: x y z, rx ry rz about the origin.

    Modes follow from the stiffness, which is not strained, and from the shape of nodes.
    """
    modal = body.modal
    motion = np.zeros((len(modal), 6))
    motion[~modal] = rigid_rows(body.places(body.dof_node[~modal]), body.dof_dir[~modal])
    if not modal.any():
        return motion
    own = body.K[modal]
    own = own.toarray() if sparse.issparse(own) else own
    size = np.abs(own).max(initial=0.0) or 1.0
    strained, wanted = own[:, modal] / size, -own @ motion / size
    if body.shape is not None and body.shape_node is not None and body.shape_dir is not None:
        seen = rigid_rows(body.places(body.shape_node), body.shape_dir) - body.shape @ motion
        strained, wanted = np.vstack([strained, body.shape[:, modal]]), np.vstack([wanted, seen])
    motion[modal] = np.linalg.lstsq(strained, wanted, rcond=None)[0]
    return motion


def refused(where: str, name: str, problem: str, allowed: str, **given: object) -> ModelError:
    """What is wrong with something in a file."""
    return ModelError(problem, path=f"{where}: {name}", allowed=allowed, **given)


# --- units -----------------------------------------------------------------------------------------------------------


def in_si(body: ReducedBody, where: str) -> ReducedBody:
    """A body whose matrices, places and mass are in `body.units`, in SI.

    Raises
    ------
    ModelError : units that are not known, at `where`: units.
    """
    if body.units not in UNITS:
        raise refused(where, "units", "not known, and never guessed", UNIT_WORDS, given=body.units)
    mass, length = UNITS[body.units]
    if (mass, length) == (1.0, 1.0):
        return body
    energy = mass * length**2
    size = np.array([energy**0.5, *[length] * 3, *[1.0] * 3])  # of a coordinate, by its direction
    own = size[body.dof_dir]
    found: dict[str, Any] = {name: _scaled(getattr(body, name), energy / own, 1 / own) for name in _MATRICES[:-1]}
    if body.shape is not None:
        found["shape"] = _scaled(body.shape, size[body.shape_dir], 1 / own)
    found |= {"D": _scaled(body.D, own, 1 / own), "node_xyz": body.node_xyz * length}
    for name, factor in (("mass", mass), ("centre", length), ("inertia", energy)):
        value = getattr(body, name)
        found[name] = None if value is None else value * factor
    return replace(body, **found)


def _scaled(matrix: Matrix | None, rows: Array, columns: Array) -> Matrix | None:
    if matrix is None or not sparse.issparse(matrix):
        return None if matrix is None else matrix * np.outer(rows, columns)
    return (sparse.diags_array(rows) @ matrix @ sparse.diags_array(columns)).tocsr()


# --- the native file -------------------------------------------------------------------------------------------------


def native_bytes(body: ReducedBody) -> bytes:
    """The content of the native file .npz of a body, in kg m s; `native_body` reads the same bits."""
    content: dict[str, Any] = {"format": _FORMAT, "units": "kg m s", "source": body.source}
    for name in _MATRICES:
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
    given: dict[str, Any] = {
        name: values[name].item() if name in values and values[name].size == 1 else None
        for name in ("format", "units", "source")
    }
    if given.pop("format") != _FORMAT:
        raise refused(where, "format", "not the format of a body", str(_FORMAT))
    given = {name: str(one or "") for name, one in given.items()}
    for name in ("node_id", "node_xyz", "dof_node", "dof_dir"):
        if name not in values:
            raise refused(where, name, "missing", "an array")
    count = values["dof_node"].size
    given |= {name: _array(values, name, shape, count, where) for name, shape in _SHAPES.items() if name in values}
    given |= {name: _matrix(values, name, count, where) for name in _MATRICES}
    for name in ("M", "K"):
        if given[name] is None:
            raise refused(where, name, "missing", f"{name}, or {name}_data, {name}_indices and {name}_indptr")
    return in_si(ReducedBody(**given), where)


def _content(raw: bytes, where: str) -> Mapping[str, Any]:
    """Arrays by name; what they would need in memory is asked first."""
    try:
        if raw[:2] == b"PK":
            with zipfile.ZipFile(io.BytesIO(raw)) as packed:
                _require_room(sum(entry.file_size for entry in packed.infolist()), where)
            with np.load(io.BytesIO(raw), allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        dense = (shape for _, shape, kind in whosmat(io.BytesIO(raw)) if kind != "sparse")
        _require_room(sum(8 * math.prod(shape) for shape in dense), where)
        return {name: one for name, one in loadmat(io.BytesIO(raw)).items() if not name.startswith("__")}
    except ModelError:
        raise
    except Exception as error:  # whatever a damaged file makes of a reader
        raise ModelError(f"cannot be read: {error}", path=where, allowed="a body as .npz or .mat (version 5)") from None


def _require_room(size: int, where: str) -> None:
    if size > 2 * MAX_BYTES:
        raise ModelError("too large", path=where, given=f"{size} bytes", allowed=f"{2 * MAX_BYTES} bytes in memory")


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


def _matrix(values: Mapping[str, Any], name: str, count: int, where: str) -> Matrix | None:
    """A matrix (count, count), dense or sparse; None where there is none."""
    parts = [f"{name}_{part}" for part in _PARTS]
    if name in values and not sparse.issparse(values[name]):
        return _array(values, name, (0, 0), count, where)
    if name not in values and not values.keys() & set(parts):
        return None
    try:
        given = values[name] if name in values else tuple(_array(values, part, (-1,), count, where) for part in parts)
        matrix = sparse.csr_array(given, shape=(count, count), dtype=float)
        matrix.check_format(full_check=True)
    except (KeyError, ValueError, TypeError) as error:
        raise refused(where, name, f"no sparse matrix: {error}", f"({count}, {count}), rows as of csr_array") from None
    matrix.sort_indices()
    if not matrix.has_canonical_format:
        raise refused(where, name, "has an entry twice", "each entry once")
    return matrix
