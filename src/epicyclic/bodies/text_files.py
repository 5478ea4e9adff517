"""Matrices and nodes as finite-element programs write them in text: NASTRAN punch, Abaqus .mtx, CalculiX.

A matrix is its terms (m, 5): node, direction, node, direction, value.  Where no pair of places has both of its terms,
one triangle was written.  Directions are 1 to 6, and 0 of a scalar point, which is a mode.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy import sparse

from .reduced_body import MAX_DENSE, MAX_DOFS, Array, Index, refused

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
