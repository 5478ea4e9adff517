"""The state of a page: a model text, what overrides change in it, and where it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...errors import ModelError
from ...model.deviations import is_file_name
from ...model.document import MAX_BYTES, decoded, file_text, parse_text, ready_drives
from ...model.tables import PlainTable, clean, split_path
from ...rexs.names import is_rexs_name
from ...studies.drives import drive_text

__all__ = [
    "State",
    "at_path",
    "from_text",
    "opened",
    "request_of",
    "tables_of",
    "uploaded",
    "with_text",
    "with_value",
    "with_values",
]

_NO_FILES = "numbers: a model of this page may name no file"
# Characters of a name in the header and of a download: longer ones push the controls away.
_MOST_NAME = 80
# Overrides of one state: what a person sets by hand, with room; a hostile link may hold more.
_MOST_OVERRIDES = 2000
# Tables whose entries may name a file of force over deflection (`model.force_files`).
_WITH_FORCES = ("stages", "bodies", "couplings")


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """What a page shows.

    name : of the header.  base : text of the model file (TOML).
    overrides : values by path, in the order in which they were set, as `load` takes them.
    drive : the ready drive whose text `base` is, if it is one.
    path : file of this machine, opened by the command line or written by save as; never from a link or an upload.
    trusted : whether the model may name files beside `path`.
    """

    name: str
    base: str
    overrides: Mapping[str, object] = field(default_factory=dict)
    drive: str | None = None
    path: Path | None = None
    trusted: bool = False


def opened(source: str | Path) -> State:
    """The state of a ready drive, a model file or a REXS file of this machine.

    Raises
    ------
    ModelError : it cannot be read; it is no TOML and no REXS file.
    """
    if isinstance(source, str) and source in ready_drives():
        return State(name=source, base=drive_text(source), drive=source)
    path = Path(source)
    if is_rexs_name(path):
        from ...rexs.import_train import read_rexs
        from ...studies.rexs_text import rexs_model_text

        return State(name=_short(path.stem), base=rexs_model_text(read_rexs(path), path.name))
    text = file_text(path)
    parse_text(text, str(path))
    return State(name=_short(path.name), base=text, path=path.absolute(), trusted=True)


def uploaded(name: str, content: bytes) -> State:
    """The state of a file that a browser sent: a model file or a REXS file, which may name no file.

    Raises
    ------
    ModelError : too large, no TOML and no REXS file, or it names a file.
    """
    short = _short(name)
    if len(content) > MAX_BYTES:
        raise ModelError("too large", path=short, given=f"{len(content)} bytes", allowed=f"at most {MAX_BYTES} bytes")
    if is_rexs_name(name):
        from ...rexs.import_train import read_rexs
        from ...studies.rexs_text import rexs_model_text

        return State(name=short, base=rexs_model_text(read_rexs(content), short))
    return from_text(short, decoded(content, short))


def from_text(name: str, text: str) -> State:
    """The state of a model text of anybody: it may name no file.

    Raises
    ------
    ModelError : no TOML, too large, or it names a file.
    """
    short = _short(name)
    if len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise ModelError("too large", path=short, allowed=f"at most {MAX_BYTES} bytes")
    state = State(name=short, base=text)
    request_of(state)
    return state


def with_value(state: State, path: str, value: object) -> State:
    """The state with one value set; None removes the key, the value of the file removes the override."""
    return with_values(state, {path: value})


def with_values(state: State, values: Mapping[str, object]) -> State:
    """The state with values set by path, the newest last.

    Raises
    ------
    ModelError : too many overrides; a value that no model file holds.
    """
    overrides = dict(state.overrides)
    base = tables_of(state.base, state.name)
    for path, value in values.items():
        overrides.pop(path, None)
        given = at_path(base, split_path(path, path=path))
        if (given is None) if value is None else given == clean(value, path):
            continue
        overrides[path] = value if value is None else clean(value, path)
    if len(overrides) > _MOST_OVERRIDES:
        raise ModelError("too many", path="overrides", given=len(overrides), allowed=f"at most {_MOST_OVERRIDES}")
    return replace(state, overrides=overrides)


def with_text(state: State, text: str) -> State:
    """The state with another model text and no overrides; it stays beside its file.

    Raises
    ------
    ModelError : no TOML, or it names a file that it may not.
    """
    changed = replace(state, base=text, overrides={}, drive=None)
    request_of(changed)
    return changed


def request_of(state: State) -> tuple[PlainTable, dict[str, object]]:
    """What `load` takes: nested tables and overrides, plain and picklable.  Names of files become whole paths.

    Raises
    ------
    ModelError : the text is no TOML; it names a file and may not.
    """
    folder = state.path.parent if state.trusted and state.path is not None else None
    tables = _placed(tables_of(state.base, state.name), folder)
    overrides = {}
    for path, value in state.overrides.items():
        nested = _nested(split_path(path, path=path), value)
        _placed(nested, folder)  # refused where it names a file and may not
        overrides[path] = at_path(_placed(nested, folder), split_path(path, path=path))
    return tables, overrides


@lru_cache(maxsize=64)
def _parsed(text: str, name: str) -> PlainTable:
    return parse_text(text, name)


def tables_of(text: str, name: str = "model") -> PlainTable:
    """The tables of a model text; they are shared, so nobody changes them.

    Raises
    ------
    ModelError : no TOML.
    """
    return _parsed(text, name)


def _placed(tables: PlainTable, folder: Path | None) -> PlainTable:
    """Tables whose names of files are whole paths.

    Raises
    ------
    ModelError : a file is named and there is no folder, or it lies outside of it.
    """
    placed = {key: _forces(value, key, folder) if key in _WITH_FORCES else value for key, value in tables.items()}
    if "deviations" in placed:
        placed["deviations"] = _pitches(placed["deviations"], "deviations", folder)
    return placed


def _forces(value: Any, path: str, folder: Path | None) -> Any:
    if not isinstance(value, Mapping):
        return value
    return {
        key: _file(one, f"{path}.{key}", folder)
        if key == "file" and isinstance(one, str)
        else _forces(one, f"{path}.{key}", folder)
        for key, one in value.items()
    }


def _pitches(value: Any, path: str, folder: Path | None) -> Any:
    if not isinstance(value, Mapping):
        return value
    found: PlainTable = {}
    for key, one in value.items():
        where = f"{path}.{key}"
        if key == "pitch" and isinstance(one, list):
            found[key] = [_file(name, where, folder) if is_file_name(name) else name for name in one]
        elif key == "pitch" and is_file_name(one):
            found[key] = _file(one, where, folder)
        else:
            found[key] = _pitches(one, where, folder)
    return found


def _file(name: str, path: str, folder: Path | None) -> str:
    if folder is None:
        raise ModelError("names a file", path=path, given=name[:_MOST_NAME], allowed=_NO_FILES)
    return str(folder / name)


def _nested(path: tuple[str, ...], value: object) -> PlainTable:
    table: Any = value
    for key in reversed(path):
        table = {key: table}
    found: PlainTable = table
    return found


def at_path(table: Any, path: tuple[str, ...]) -> Any:
    for key in path:
        if not isinstance(table, Mapping) or key not in table:
            return None
        table = table[key]
    return table


def _short(name: str) -> str:
    """A name without folders and control characters, short enough for a header."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    plain = "".join(letter for letter in last if letter.isprintable()).strip(" .")
    return plain[:_MOST_NAME] or "model"
