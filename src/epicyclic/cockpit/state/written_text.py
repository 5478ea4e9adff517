"""The model text of a state: the file with the overrides written in, its comments kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from ...errors import ModelError
from ...model.commented_writer import commented_text
from ...model.document import read
from ...model.tables import PlainTable, split_path
from .state import State, at_path, request_of, tables_of

__all__ = ["text_of", "value_at"]

# Rounds of writing what still differs from the aim: the first writes the overrides, the second what follows from them,
# such as masses after teeth; a third has never been needed, and the commented writer stands behind.
_ROUNDS = 3
# Tables whose keys are themselves paths of the document.
_OF_PATHS = ("assumed", "tolerance")


def text_of(state: State) -> str:
    """The model text that gives the same train as the file with its overrides.

    Comments and order stay as they are where the text that is edited reads back as the same document; else the
    document is written anew, without comments.

    Raises
    ------
    ModelError : the text is no TOML, or an override cannot be written into it.
    """
    if not state.overrides:
        return state.base
    tables, overrides = request_of(state)
    try:
        aim = read(tables, overrides).data
    except ModelError:
        # what is wrong is the model's; its text can be shown, mended and saved all the same
        edited = _edited(state.base, overrides, None)
        if edited is None:
            raise
        return edited
    edited = _edited(state.base, overrides, aim)
    if edited is not None:
        return edited
    head = (f"{state.name} with {len(overrides)} values changed; written anew, so without its comments.",)
    return commented_text(aim, head=head)


def _edited(text: str, overrides: Mapping[str, object], aim: PlainTable | None) -> str | None:
    """The text with values changed in place until it reads as the aim; None where it does not come to that.

    aim : None: the overrides are written in and nothing is compared.
    """
    try:
        document = tomlkit.parse(text)
        for path, value in overrides.items():
            _put(document, split_path(path, path=path), value)
        for _ in range(_ROUNDS):
            written = tomlkit.dumps(document)
            if aim is None:
                return written
            found = read(tables_of(written)).data
            if found == aim:
                return written
            for keys, wanted in _differences(found, aim):
                _put(document, keys, wanted)
    except (ModelError, TOMLKitError, ValueError, TypeError, KeyError, AttributeError):
        return None  # spelled in another way, or two spellings in one: the document is written anew
    return None


def _differences(found: PlainTable, aim: PlainTable) -> Iterator[tuple[tuple[str, ...], object]]:
    """Paths whose value is another one in the aim, with that; None where it has none."""
    own, wanted = dict(_keyed(found)), dict(_keyed(aim))
    for path in own.keys() - wanted.keys():
        yield path, None
    for path, value in wanted.items():
        if own.get(path, _ABSENT) != value:
            yield path, value


_ABSENT = object()


def _keyed(table: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from _keyed(value, (*path, key))
        else:
            yield (*path, key), value


def _put(table: Any, path: tuple[str, ...], value: object) -> None:
    """Set a value in the document, or remove it; tables on the way are made."""
    *above, last = _spelled(table, path)
    for key in above:
        if key not in table:
            if value is None:
                return
            table[key] = tomlkit.table()
        table = table[key]
    if value is None:
        if last in table:
            del table[last]
        return
    if last not in table or not _replaced(table, last, value):
        table[last] = value


def _spelled(table: Any, path: tuple[str, ...]) -> tuple[str, ...]:
    """The path as the text spells it: without the stage where the member stands directly in its table."""
    if len(path) == 2 and path[0] in _OF_PATHS:
        first, _, rest = path[1].partition(".")
        shorter = f"{first}.{rest.partition('.')[2]}"
        known = table.get(path[0], {})
        return (path[0], shorter) if path[1] not in known and shorter in known else path
    short = (path[0], *path[2:])
    if len(path) < 3 or at_path(table, path[:2]) is not None or at_path(table, short[:2]) is None:
        return path
    return short


def _replaced(table: Any, key: str, value: object) -> bool:
    """Whether a value took the place of another one, whose comment stays behind it."""
    old = table[key]
    trivia = getattr(old, "trivia", None)
    if trivia is None or isinstance(old, Mapping) or isinstance(value, Mapping):
        return False
    new = tomlkit.item(value)
    new.trivia.indent, new.trivia.comment_ws = trivia.indent, trivia.comment_ws
    new.trivia.comment, new.trivia.trail = trivia.comment, trivia.trail
    table[key] = new
    return True


def value_at(state: State, path: str) -> object:
    """The value at a path as it is written, a text with its unit: of an override, else of the file; None: nowhere.

    Raises
    ------
    ModelError : the text is no TOML.
    """
    if path in state.overrides:
        return state.overrides[path]
    keys = split_path(path, path=path)
    found = at_path(tables_of(state.base, state.name), keys)
    return found if found is not None else at_path(_data(state), keys)


@lru_cache(maxsize=16)
def _data_of(base: str, name: str) -> PlainTable:
    try:
        return read(tables_of(base, name)).data
    except ModelError:
        return {}


def _data(state: State) -> PlainTable:
    """The document of the file with its shorthands expanded."""
    return _data_of(state.base, state.name)
