"""Files of a body: its own, by arrays, .npz or .mat; and the matrices and nodes of finite-element programs, in text.

Read are NASTRAN punch, Abaqus .mtx and CalculiX.  A matrix is its terms (m, 5): node, direction, node, direction,
value. Where no pair of places has both of its terms, one triangle was written.  Directions are 1 to 6, and 0 of a
scalar point, which is a mode.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse
from scipy.io import loadmat, whosmat

from ..errors import ModelError
from ..user_input import read_bytes, read_text
from .reduced_body import (
    MATRICES,
    MAX_BYTES,
    MAX_DENSE,
    MAX_DOFS,
    UNIT_WORDS,
    Array,
    BodyFacts,
    Index,
    Matrix,
    ReducedBody,
    checked,
    in_si,
    refused,
)

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


# text of finite-element programs --------------------------------------------------------------------------------------

_DENSE = 0.3  # share of a matrix that is not zero

Places = dict[int, tuple[float, ...]]

# --- NASTRAN ---------------------------------------------------------------------------------------------------------


def punch(text: str, where: str) -> tuple[dict[str, Array], Places]:
    """Terms of the matrices and places of the nodes of DMIG, GRID and SPOINT cards in small, large or free fields.

    Square and symmetric matrices are read; rectangular ones, as loads, and all other cards are passed over.

    Raises
    ------
    ModelError : at `where`, line and card: a complex matrix, another coordinate system, no number.
    """
    terms, places, passed, scalars = dict[str, list[tuple[float, ...]]](), Places(), set[str](), set[int]()
    for line, card, fields in _cards(text):
        fields += [""] * 8  # a large card of one line has four
        at, name = f"line {line}, {card}", fields[0].upper()
        if card == "GRID":
            _add_place(places, _whole(fields[0], where, at), [_real(one, where, at) for one in fields[2:5]], where, at)
            if {fields[1], fields[5]} - {"", "0"}:
                raise refused(where, at, "another coordinate system", "0 or blank", given=fields[1] or fields[5])
        elif card == "SPOINT":
            numbers = [_whole(one, where, at) for one in fields if one not in ("", "THRU")]
            if "THRU" in fields and numbers:
                numbers = list(range(numbers[0], min(numbers[-1], numbers[0] + MAX_DOFS) + 1))
            scalars |= set(numbers)
        elif fields[1] == "0":
            if fields[3] not in ("", "1", "2"):
                raise refused(where, at, "a complex matrix", "1 or 2, real", given=f"type {fields[3]}")
            terms.setdefault(name, [])
            passed |= {name} if fields[2] not in ("1", "6") else set()
        elif name not in terms:
            raise refused(where, at, "a column before the header of its matrix", "the header first", given=name)
        elif name not in passed:
            column = _whole(fields[1], where, at), _whole(fields[2] or "0", where, at)
            for i in range(4, len(fields) - 2, 4):
                if fields[i]:
                    row = _whole(fields[i], where, at), _whole(fields[i + 1] or "0", where, at)
                    terms[name].append((*row, *column, _real(fields[i + 2], where, at)))
    found = {name: np.array(rows, float).reshape(-1, 5) for name, rows in terms.items() if name not in passed}
    for values in found.values():
        values[:, [1, 3]] *= ~np.isin(values[:, [0, 2]], list(scalars))
    return found, places


def chosen(matrices: Mapping[str, Array], letter: str, where: str) -> Array | None:
    """The matrix whose name begins with a letter: K stiffness, M mass, B damping; K4 is none.

    Raises
    ------
    ModelError : several.
    """
    names = [name for name in matrices if name.startswith(letter) and not name.startswith("K4")]
    if len(names) > 1:
        raise refused(where, letter, "several matrices", f"one that begins with {letter}", given=", ".join(names))
    return matrices[names[0]] if names else None


def _cards(text: str) -> Iterator[tuple[int, str, list[str]]]:
    """Line, name and fields of the cards that are read, with those of their continuations."""
    card: tuple[int, str, list[str]] | None = None
    for number, line in enumerate([*text.splitlines(), "ENDDATA"], 1):
        line = line.partition("$")[0].expandtabs(8).rstrip()
        if not line:
            continue
        head, fields = _fields(line)
        name = head.rstrip("*").upper()
        if name and name[0] not in "+*":
            if card:
                yield card
            card = (number, name, fields) if name in ("DMIG", "GRID", "SPOINT") else None
        elif card:
            card[2].extend(fields)


def _fields(line: str) -> tuple[str, list[str]]:
    """The first field of a line, and its eight or, of large ones, four fields."""
    if "," in line:
        head, *fields = (one.strip() for one in line.split(","))
        count = 4 if "*" in head else 8
        return head, (fields + [""] * count)[:count]
    head = line[:8].strip()
    width = 16 if "*" in head else 8
    return head, [line[i : i + width].strip() for i in range(8, 72, width)]


def _real(text: str, where: str, at: str) -> float:
    """A number of NASTRAN: 1.5, 1.5E+3, 1.5D+3 or 1.5+3; blank is 0."""
    plain = text.upper().replace("D", "E") or "0"
    try:
        return float(plain if "E" in plain else re.sub(r"(?<=[\d.])([+-])", r"E\1", plain))
    except ValueError:
        raise refused(where, at, "no number", "a number", given=text) from None


def _whole(text: str, where: str, at: str) -> int:
    if not re.fullmatch(r"\d{1,15}", text):
        raise refused(where, at, "no number of a node or direction", "a whole number", given=text)
    return int(text)


# --- Abaqus, CalculiX ------------------------------------------------------------------------------------------------


def matrix_text(text: str, where: str) -> Array:
    """Terms of an Abaqus .mtx of *MATRIX OUTPUT, FORMAT=MATRIX INPUT: "node, direction, node, direction, value"."""
    return _table(text, 5, where, "lines of node, direction, node, direction, value")


def storage_text(text: str, where: str, dofs: str, dofs_where: str) -> Array:
    """Terms of a CalculiX .sti or .mas of SOLVER=MATRIXSTORAGE, "row column value", with its .dof, "node.direction"."""
    if wrong := re.search(r"^(?!\s*\d{1,15}\.\d\s*$).*\S.*$", dofs, re.MULTILINE):
        raise refused(dofs_where, "rows", "no place of a row", "node.direction", given=wrong[0].strip())
    place = np.array([one.split(".") for one in dofs.split()], float).reshape(-1, 2)
    *index, values = _table(text, 3, where, "lines of row, column, value").T
    rows = np.stack(index)
    if not np.all((rows >= 1) & (rows <= len(place)) & (rows == np.floor(rows))):
        raise refused(where, "rows", "no row or column", f"1 to {len(place)}, the lines of {dofs_where}")
    row, column = rows.astype(np.int64) - 1
    return np.column_stack([place[row], place[column], values])


def _table(text: str, columns: int, where: str, allowed: str) -> Array:
    """Numbers (m, columns) of lines, separated by commas or blanks; lines that begin with * are comments."""
    try:
        if not text.strip():
            raise ValueError("empty")
        values = np.loadtxt(io.StringIO(text.replace(",", " ")), comments="*", ndmin=2)
    except ValueError as error:
        raise refused(where, "lines", f"not such a table: {error}", allowed) from None
    if values.shape[1] != columns:
        raise refused(where, "lines", "not such a table", allowed, given=f"{values.shape[1]} columns")
    return np.asarray(values, float)


def nodes_text(text: str, where: str) -> Places:
    """Places of nodes: GRID cards, *NODE of an Abaqus or CalculiX input file, or lines of number, x, y, z.

    Raises
    ------
    ModelError : a node twice, axes of its own (*TRANSFORM, *SYSTEM, a moved *INSTANCE), what is no such text.
    """
    if re.search(r"^GRID\b", text, re.MULTILINE | re.IGNORECASE):
        return punch(text, where)[1]
    if not re.search(r"^\*NODE\b", text, re.MULTILINE | re.IGNORECASE):
        rows = _table(text, 4, where, "GRID cards, *NODE or lines of number, x, y, z").tolist()
        text = "\n".join(["*NODE", *(f"{node:.15g}, {x!r}, {y!r}, {z!r}" for node, x, y, z in rows)])
    places, keyword = Places(), ""
    for number, line in enumerate(text.splitlines(), 1):
        at = f"line {number}"
        if line.startswith("*") and not line.startswith("**"):
            keyword, *options = line.upper().replace(" ", "").split(",")
            if keyword in ("*TRANSFORM", "*SYSTEM") or (keyword == "*NODE" and {"SYSTEM=C", "SYSTEM=S"} & set(options)):
                raise refused(where, at, "axes of its own", "nodes and directions in x, y, z", given=line)
        elif keyword == "*INSTANCE" and line.strip() and line[0] != "*":
            raise refused(where, at, "a moved instance", "nodes where they stand in the assembly", given=line)
        elif keyword == "*NODE" and line.strip() and line[0] != "*":
            cells = [cell.strip() for cell in f"{line},,,".split(",")]
            place = [_real(cell, where, at) for cell in cells[1:4]]
            _add_place(places, _whole(cells[0], where, at), place, where, at)
    return places


def _add_place(places: Places, node: int, place: list[float], where: str, at: str) -> None:
    if node in places:
        raise refused(where, at, "a node twice", "each node once", given=node)
    places[node] = tuple(place)


# --- terms to matrices -----------------------------------------------------------------------------------------------


def assembled(terms: Mapping[str, Array], where: str) -> tuple[dict[str, Any], Index, Index]:
    """Sparse matrices (n, n) of terms, and node and direction of each coordinate, by node and direction.

    Raises
    ------
    ModelError : a direction above 6, a term twice.
    """
    place = {name: _numbered(one, where, name) for name, one in terms.items()}
    known, rows = np.unique(np.concatenate([one.ravel() for one in place.values()]), return_inverse=True)
    found, start, count = {}, 0, len(known)
    for name, one in place.items():
        row, column = rows.ravel()[start : start + one.size].reshape(one.shape).T
        value, start = terms[name][:, 4], start + one.size
        key, other, off = row * count + column, column * count + row, row != column
        if len(np.unique(key)) < len(key):
            raise refused(where, name, "a term twice", "each term once")
        if not np.isin(key[off], other[off]).any():
            row, column = np.concatenate([row, column[off]]), np.concatenate([column, row[off]])
            value = np.concatenate([value, value[off]])
        found[name] = sparse.csr_array((value, (row, column)), shape=(count, count))
    if count <= MAX_DENSE and all(one.nnz > _DENSE * count**2 for one in found.values()):
        found = {name: one.toarray() for name, one in found.items()}
    return found, known // 7, known % 7


def _numbered(terms: Array, where: str, name: str) -> Index:
    """One number (m, 2) for node and direction of rows and columns."""
    node, direction = terms[:, [0, 2]], terms[:, [1, 3]]
    whole = np.all(terms[:, :4] == np.round(terms[:, :4])) and np.abs(node).max(initial=0) < 2**50
    if not whole or not np.all((direction >= 0) & (direction <= 6)):
        raise refused(where, name, "no node and direction", "whole numbers; directions 1 to 6, 0 of a mode")
    return (node * 7 + direction).astype(np.int64)


# a body of files ------------------------------------------------------------------------------------------------------

_NATIVE, _PUNCH = (".npz", ".mat"), (".pch", ".bdf", ".dmig", ".nas", ".dat")
_STORAGE = (".sti", ".mas", ".dof", ".inp")
_KEYS, _LETTERS = {"stiffness": "K", "mass": "M", "damping": "C"}, {"K": "K", "M": "M", "C": "B"}
_FILES = ".npz, .mat, .pch, .bdf, .dmig, .nas or .dat (DMIG), .sti (CalculiX), or a table: stiffness, mass, nodes"

Source = str | Path | Mapping[str, str | Path]


def read_body(
    source: Source, *, units: str | None = None, mass: float | None = None, path: str = "body"
) -> tuple[ReducedBody, BodyFacts]:
    """A body in SI, checked, and what the checks found.

    source : one file where the format has all: .npz or .mat; a NASTRAN punch with GRID cards; a .sti of CalculiX with
        .mas, .dof and .inp of the same name beside it.  Else a table of files: stiffness, mass and nodes, and damping
        where there is any: .mtx or DMIG, and nodes as .inp, GRID cards or lines of number, x, y, z.
    units : "kg m s" or "t mm s", of the texts; native files state their own.
    mass : what is expected [kg], in place of what the file says.
    path : where the source is named, for errors.

    Raises
    ------
    ModelError : at `path`, files that are not there or no such file; at the file and its key, what a check refuses.
    """
    body = _of_table(source, units, path) if isinstance(source, Mapping) else _of_file(Path(source), units, path)
    where = str(source["stiffness"] if isinstance(source, Mapping) else source)
    return checked(body if mass is None else replace(body, mass=mass), where)


def _of_file(file: Path, units: str | None, path: str) -> ReducedBody:
    kind = file.suffix.lower()
    if kind in _NATIVE:
        raw = read_bytes(file, most=MAX_BYTES, path=path, given=str(file), allowed=_FILES)
        body = native_body(raw, str(file))
        if units not in (None, body.units):
            raise ModelError("not the units of the file", path=f"{path}.units", given=units, allowed=body.units)
        return body
    if kind in _PUNCH:
        matrices, places = punch(_text(file, path), str(file))
        terms = {name: chosen(matrices, letter, str(file)) for name, letter in _LETTERS.items()}
        return _body(terms, places, str(file), units, path)
    if kind == _STORAGE[0]:
        files = [file.with_suffix(one) for one in _STORAGE]
        stiffness, mass, dofs, nodes = ((_text(one, path), str(one)) for one in files)
        terms = {"K": storage_text(*stiffness, *dofs), "M": storage_text(*mass, *dofs)}
        return _body(terms, nodes_text(*nodes), str(file), units, path)
    raise ModelError("no file of a body", path=path, given=str(file), allowed=_FILES)


def _text(file: str | Path, path: str) -> str:
    return read_text(file, most=MAX_BYTES, path=path, given=str(file), allowed="a text file")


def _of_table(files: Mapping[str, str | Path], units: str | None, path: str) -> ReducedBody:
    for key in {"stiffness", "mass", "nodes"} - files.keys():
        raise ModelError("missing", path=f"{path}.{key}", allowed="a file")
    for key in files.keys() - {*_KEYS, "nodes"}:
        raise ModelError("unknown key", path=f"{path}.{key}", allowed="stiffness, mass, damping, nodes")
    terms = dict[str, Array | None]()
    for key, name in _KEYS.items():
        if key in files:
            file, text = str(files[key]), _text(files[key], f"{path}.{key}")
            if Path(file).suffix.lower() in _PUNCH:
                matrices, _ = punch(text, file)
                terms[name] = (
                    next(iter(matrices.values())) if len(matrices) == 1 else chosen(matrices, _LETTERS[name], file)
                )
            else:
                terms[name] = matrix_text(text, file)
    places = nodes_text(_text(files["nodes"], f"{path}.nodes"), str(files["nodes"]))
    return _body(terms, places, str(files["stiffness"]), units, path)


def _body(given: Mapping[str, Array | None], places: Places, file: str, units: str | None, path: str) -> ReducedBody:
    """A body of terms; of the nodes those that have a coordinate."""
    if units is None:
        raise ModelError("missing, and never guessed", path=f"{path}.units", allowed=UNIT_WORDS)
    terms = {name: one for name, one in given.items() if one is not None}
    for name in ("K", "M"):
        if name not in terms:
            raise refused(file, name, "no such matrix", f"a matrix whose name begins with {name}")
    matrices, node, direction = assembled(terms, file)
    used = np.unique(node[direction > 0]).tolist()
    for one in used:
        if one not in places:
            raise refused(file, "K", "a node without place", "nodes that the file of nodes lists", given=one)
    xyz = np.array([places[one] for one in used], float).reshape(-1, 3)
    ids = np.array(used, np.int64)
    body = ReducedBody(
        **matrices, node_id=ids, node_xyz=xyz, dof_node=node, dof_dir=direction, source=file, units=units
    )
    return in_si(body, path)
