"""A body from the files of a finite-element program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import ModelError
from ..user_input import read_bytes, read_text
from .checks import BodyFacts, checked
from .native_file import native_body
from .reduced_body import MAX_BYTES, UNIT_WORDS, Array, ReducedBody, in_si, refused
from .text_files import Places, assembled, chosen, matrix_text, nodes_text, punch, storage_text

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
