"""The state of a page: a model text, what overrides change in it, and where it came from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...document.document import MAX_BYTES, decoded, drive_text, file_text, is_file_name, parse_text, ready_drives
from ...document.schema import Names, collect
from ...document.tables import PlainTable, clean, expand, nested, split_path, value_at
from ...errors import ModelError
from ...rexs.file import is_rexs_name

Keys = tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spelling:
    """The keys of a model text.

    names : of its stages, members and bodies.  written : value by key, as the text has them.
    places : of each key, where in the document it stands.  key_of : the key that gives a place.
    """

    names: Names
    written: Mapping[Keys, object]
    places: Mapping[Keys, frozenset[Keys]]
    key_of: Mapping[Keys, Keys]

    def places_of(self, keys: Keys, value: object) -> frozenset[Keys]:
        """Places of the document that a key with that value gives."""
        return _places(keys, value, self.names)

    def same(self, keys: Keys, value: object) -> Keys | None:
        """The key of the text that gives exactly the places of this one; None where there is none."""
        places = self.places_of(keys, value)
        keys_of_places = {self.key_of.get(place) for place in places}
        key = next(iter(keys_of_places)) if len(keys_of_places) == 1 else None
        return key if key is not None and self.places[key] == places else None


def spelling_of(tables: PlainTable) -> Spelling:
    """The spelling of the tables of a model text."""
    names = collect(tables)
    written = dict(keyed(tables))
    places = {keys: _places(keys, value, names) for keys, value in written.items()}
    key_of = {place: keys for keys, several in places.items() for place in several}
    return Spelling(names=names, written=written, places=places, key_of=key_of)


def keyed(table: Mapping[str, Any], above: Keys = ()) -> Iterator[tuple[Keys, object]]:
    """Keys and values of everything that is no table, and of empty tables."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from keyed(value, (*above, key))
        else:
            yield (*above, key), value


def _places(keys: Keys, value: object, names: Names) -> frozenset[Keys]:
    """Places of one key; the key itself where its value is of a wrong form, which validation names."""
    try:
        return frozenset(found for found, _ in keyed(expand(nested(keys, value), names)))
    except (ModelError, AttributeError, TypeError):
        return frozenset((keys,))


_NO_FILES = "numbers: a model of this page may name no file"
# Characters of a name in the header and of a download: longer ones push the controls away.
_MOST_NAME = 80
# Overrides of one state: what a person sets by hand, with room; a hostile link may hold more.
_MOST_OVERRIDES = 2000
# Speeds per operating speed that a page shows: no sweep of the package goes beyond.
_SPEEDS = (1e-3, 100.0)
# Tables whose entries may name a file of force over deflection (`document.document`).
_WITH_FORCES = ("stages", "bodies", "couplings")


Origin = tuple[Path | None, str | None, str]
"""Model file by what it is of: path, ready drive and name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState:
    """What a page shows.

    name : of the header.  base : text of the model file (TOML).
    overrides : values by path, in the order in which they were set, as `load` takes them.
    drive : the ready drive whose text `base` is, if it is one.
    path : file of this machine, opened by the command line or written by save as; never from a link or an upload.
    trusted : whether the model may name files beside `path`.
    relative_speed : speed that is shown, per operating speed [1]; the model stays as it is.
    """

    name: str
    base: str
    overrides: Mapping[str, object] = field(default_factory=dict)
    drive: str | None = None
    path: Path | None = None
    trusted: bool = False
    relative_speed: float = 1.0

    @property
    def origin(self) -> Origin:
        """Model file that it is of: path, ready drive and name."""
        return self.path, self.drive, self.name


def opened(source: str | Path) -> PageState:
    """The state of a ready drive, a model file or a REXS file of this machine.

    Raises
    ------
    ModelError : it cannot be read; it is no TOML and no REXS file.
    """
    if isinstance(source, str) and source in ready_drives():
        return PageState(name=source, base=drive_text(source), drive=source)
    path = Path(source)
    if is_rexs_name(path):
        return PageState(name=_short(path.stem), base=_rexs_text(path, path.name))
    text = file_text(path)
    parse_text(text, str(path))
    return PageState(name=_short(path.name), base=text, path=path.absolute(), trusted=True)


def _rexs_text(source: Path | bytes, name: str) -> str:
    from ...rexs.import_train import read_rexs
    from ...rexs_export.model_text import rexs_model_text

    return rexs_model_text(read_rexs(source), name)


def uploaded(name: str, content: bytes) -> PageState:
    """The state of a file that a browser sent: a model file or a REXS file, which may name no file.

    Raises
    ------
    ModelError : too large, no TOML and no REXS file, or it names a file.
    """
    short = _short(name)
    if len(content) > MAX_BYTES:
        raise ModelError("too large", path=short, given=f"{len(content)} bytes", allowed=f"at most {MAX_BYTES} bytes")
    if is_rexs_name(name):
        return PageState(name=short, base=_rexs_text(content, short))
    return from_text(short, decoded(content, short))


def from_text(name: str, text: str) -> PageState:
    """The state of a model text of anybody: it may name no file.

    Raises
    ------
    ModelError : no TOML, too large, or it names a file.
    """
    short = _short(name)
    if len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise ModelError("too large", path=short, allowed=f"at most {MAX_BYTES} bytes")
    state = PageState(name=short, base=text)
    request_of(state)
    return state


def with_value(state: PageState, path: str, value: object) -> PageState:
    """The state with one value set; None removes the key, the value of the file removes the override."""
    return with_values(state, {path: value})


def with_values(state: PageState, values: Mapping[str, object]) -> PageState:
    """The state with values set by path, the newest last; an override of the same places in another spelling goes.

    Raises
    ------
    ModelError : too many overrides; a value that no model file holds.
    """
    overrides = dict(state.overrides)
    for path, value in values.items():
        keys = split_path(path, path=path)
        _set(overrides, path, keys, value if value is None else clean(value, path), _spelling(state.base, state.name))
    if len(overrides) > _MOST_OVERRIDES:
        raise ModelError("too many", path="overrides", given=len(overrides), allowed=f"at most {_MOST_OVERRIDES}")
    return replace(state, overrides=overrides)


def _set(overrides: dict[str, object], path: str, keys: Keys, value: object, spelling: Spelling) -> None:
    """Lay one value over others: it takes the place of what stood there, above it and below it."""
    places, removed_above = spelling.places_of(keys, value), False
    for other, given in list(overrides.items()):
        others = split_path(other, path=other)
        above = others == keys[: len(others)] and others != keys
        if above and value is not None and isinstance(given, Mapping):
            overrides[other] = _with(given, keys[len(others) :], value)
            return
        removed_above |= above and given is None
        below = others[: len(keys)] == keys and not (
            isinstance(value, Mapping) and value_at(value, others[len(keys) :]) is None
        )
        if others == keys or below or spelling.places_of(others, given) == places:
            del overrides[other]
    key = spelling.same(keys, value)
    in_file = key is not None or any(stated[: len(keys)] == keys for stated in spelling.written)
    if removed_above:
        if value is not None:
            overrides[path] = value
    elif in_file if value is None else key is None or spelling.written[key] != value:
        overrides[path] = value


def _with(table: Mapping[str, object], keys: Keys, value: object) -> dict[str, object]:
    """A table with a value set in it."""
    first, *rest = keys
    below = table.get(first)
    inner = _with(below if isinstance(below, Mapping) else {}, tuple(rest), value) if rest else value
    return {**table, first: inner}


@lru_cache(maxsize=16)
def _spelling(text: str, name: str) -> Spelling:
    return spelling_of(tables_of(text, name))


def with_text(state: PageState, text: str) -> PageState:
    """The state with another model text and no overrides; it stays beside its file.

    Raises
    ------
    ModelError : no TOML, or it names a file that it may not.
    """
    changed = replace(state, base=text, overrides={}, drive=None)
    request_of(changed)
    return changed


def at_speed(state: PageState, relative_speed: float) -> PageState:
    """The state shown at another speed, per operating speed, kept within what any analysis goes to."""
    least, most = _SPEEDS
    return replace(state, relative_speed=min(max(float(relative_speed), least), most))


def request_of(state: PageState) -> tuple[PlainTable, dict[str, object]]:
    """What `load` takes: nested tables and overrides, plain and picklable.  Names of files become whole paths.

    Raises
    ------
    ModelError : the text is no TOML; it names a file and may not.
    """
    folder = state.path.parent if state.trusted and state.path is not None else None
    tables = _placed(tables_of(state.base, state.name), folder)
    overrides = {}
    for path, value in state.overrides.items():
        keys = split_path(path, path=path)
        # refused here where it names a file and may not
        overrides[path] = value_at(_placed(nested(keys, value), folder), keys)
    return tables, overrides


@lru_cache(maxsize=64)
def tables_of(text: str, name: str = "model") -> PlainTable:
    """The tables of a model text; they are shared, so nobody changes them.

    Raises
    ------
    ModelError : no TOML.
    """
    return parse_text(text, name)


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
    placed = {}
    for key, entry in value.items():
        where = f"{path}.{key}"
        named = key == "file" and isinstance(entry, str)
        placed[key] = _file(entry, where, folder) if named else _forces(entry, where, folder)
    return placed


def _pitches(value: Any, path: str, folder: Path | None) -> Any:
    if not isinstance(value, Mapping):
        return value
    placed: PlainTable = {}
    for key, entry in value.items():
        where = f"{path}.{key}"
        if key == "pitch" and isinstance(entry, list):
            placed[key] = [_file(name, where, folder) if is_file_name(name) else name for name in entry]
        elif key == "pitch" and is_file_name(entry):
            placed[key] = _file(entry, where, folder)
        else:
            placed[key] = _pitches(entry, where, folder)
    return placed


def _file(name: str, path: str, folder: Path | None) -> str:
    if folder is None:
        raise ModelError("names a file", path=path, given=name[:_MOST_NAME], allowed=_NO_FILES)
    return str(folder / name)


def _short(name: str) -> str:
    """A name without folders and control characters, short enough for a header."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    plain = "".join(letter for letter in last if letter.isprintable()).strip(" .")
    return plain[:_MOST_NAME] or "model"
