"""The model text of a state: the file with the overrides written in, its comments kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from ...document.document import read
from ...document.tables import PlainTable, split_path, value_at
from ...document.writer import commented_text
from ...errors import ModelError
from .state import Keys, PageState, keyed, request_of, spelling_of, tables_of

# Rounds of writing what still differs from the aim: the first writes the overrides, the second what follows from them
# (masses after teeth, reasons of values that are not assumed any more); the commented writer stands behind.
_ROUNDS = 4
_ABSENT = object()
_WRONG = (ModelError, TOMLKitError, ValueError, TypeError, KeyError, AttributeError)


def text_of(state: PageState, folder: Path | None = None) -> str:
    """The model text that gives the same train as the file with its overrides.

    Comments and order stay as they are where the text that is edited reads back as the same document; else the
    document is written anew, without comments.

    folder : where the text will lie; names of files are written whole where they lie beside another one.

    Raises
    ------
    ModelError : the text is no TOML, or an override cannot be written into it.
    """
    state = _moved(state, folder)
    if not state.overrides:
        return state.base
    try:
        aim = _document(state)
    except ModelError:
        # what is wrong is the model's; its text can be shown, mended and saved all the same
        return _laid_over(state)
    edited = _edited(state, aim)
    if edited is not None:
        return edited
    head = (f"{state.name} with {len(state.overrides)} values changed; written anew, so without its comments.",)
    return commented_text(aim, head=head)


def written_value(state: PageState, path: str) -> object:
    """The value at a path as it is written, a text with its unit: of an override, else of the file; None: nowhere.

    Raises
    ------
    ModelError : the text is no TOML.
    """
    keys = split_path(path, path=path)
    for other, value in reversed(list(state.overrides.items())):
        above = split_path(other, path=other)
        if keys[: len(above)] == above:
            stated = value if above == keys else value_at(value, keys[len(above) :])
            if stated is not None or value is None:
                return stated
    stated = value_at(tables_of(state.base, state.name), keys)
    return stated if stated is not None else value_at(_plain_document(state.base, state.name), keys)


@lru_cache(maxsize=16)
def _plain_document(base: str, name: str) -> PlainTable:
    """The document of a file with its shorthands expanded; files that it names are not read."""
    try:
        return read(tables_of(base, name)).data
    except ModelError:
        return {}


def _document(state: PageState) -> PlainTable:
    return read(*request_of(state)).data


def _laid_over(state: PageState) -> str:
    """The text with the overrides in it, whatever they give.

    Raises
    ------
    ModelError : an override stands where the text has something else than a table.
    """
    try:
        document = tomlkit.parse(state.base)
        for path, value in state.overrides.items():
            keys = split_path(path, path=path)
            _put(document, spelling_of(document.unwrap()).same(keys, value) or keys, value)
        written = tomlkit.dumps(document)
        tables_of(written)
    except _WRONG as error:
        raise ModelError(f"the changes cannot be written into the text: {error}", path=state.name) from None
    return written


def _edited(state: PageState, aim: PlainTable) -> str | None:
    """The text with values changed in place until it reads as the aim; None where it does not come to that."""
    try:
        document = tomlkit.parse(state.base)
        _add_new(document, state)
        for _ in range(_ROUNDS):
            written = tomlkit.dumps(document)
            reading = _document(replace(state, base=written, overrides={}))
            if reading == aim:
                return written
            _approach(document, tables_of(written), reading, aim)
    except _WRONG:
        pass  # what an editor cannot do: the document is written anew
    return None


def _add_new(document: Any, state: PageState) -> None:
    """Write the overrides whose places the text does not give, as they are spelled; the others follow."""
    spelling = spelling_of(tables_of(state.base, state.name))
    for path, value in state.overrides.items():
        keys = split_path(path, path=path)
        if value is not None and spelling.places_of(keys, value).isdisjoint(spelling.key_of):
            _put(document, _shortened(document, keys), value)


def _approach(document: Any, tables: PlainTable, reading: PlainTable, aim: PlainTable) -> None:
    """Change what differs from the aim, each key where the text has it."""
    spelling, now, wanted = spelling_of(tables), dict(keyed(reading)), dict(keyed(aim))
    differing = [place for place in (now | wanted) if now.get(place, _ABSENT) != wanted.get(place, _ABSENT)]
    keys_done: set[Keys] = set()
    removed: list[Keys] = []
    for place in differing:
        keys = spelling.key_of.get(place)
        if keys is None:
            if place in wanted:
                _put(document, _shortened(document, place), wanted[place])
            continue
        if keys in keys_done:
            continue
        keys_done.add(keys)
        values = {place: wanted.get(place, _ABSENT) for place in sorted(spelling.places[keys])}
        first, *others = values.values()
        if first is _ABSENT and all(other is _ABSENT for other in others):
            removed.append(keys)
        elif all(other is not _ABSENT and other == first for other in others):
            _put(document, keys, first)
        else:  # a shorthand of which a part changes: its parts, each with its value
            _put(document, keys, None)
            for place, value in values.items():
                if value is not _ABSENT:
                    _put(document, (*keys[:-1], place[-1]), value)
    for keys in removed:
        _put(document, keys, None)


def _moved(state: PageState, folder: Path | None) -> PageState:
    """The state with its text for another folder: the names of files whole."""
    if folder is None or not state.trusted or state.path is None or folder == state.path.parent:
        return state
    stated, placed = dict(keyed(tables_of(state.base, state.name))), dict(keyed(request_of(state)[0]))
    changed = [(keys, value) for keys, value in placed.items() if stated.get(keys) != value]
    if not changed:
        return state
    document = tomlkit.parse(state.base)
    for keys, value in changed:
        _put(document, keys, value)
    return replace(state, base=tomlkit.dumps(document))


def _shortened(document: Any, keys: Keys) -> Keys:
    """A new key as the text spells its neighbours: without the stage, or a path as one key."""
    if keys[0] in ("assumed", "tolerance") and len(keys) > 2 and keys[1] not in ("cost", "correlation"):
        return (keys[0], ".".join(keys[1:]))
    short = (keys[0], *keys[2:])
    without_stage = keys[0] in ("deviations", "operation") and len(keys) > 2
    if without_stage and value_at(document, keys[:2]) is None and value_at(document, short[:2]) is not None:
        return short
    return keys


def _put(table: Any, path: Keys, value: object) -> None:
    """Set a value in the document, or remove it; tables on the way are made, emptied ones go."""
    *above, last = path
    parents = [table]
    for key in above:
        if key not in table:
            if value is None:
                return
            # only a table of the first level may have a heading: one below dotted keys would end the table around them
            table[key] = tomlkit.table() if len(parents) == 1 else tomlkit.inline_table()
        table = table[key]
        parents.append(table)
    if value is None:
        if last in table:
            del table[last]
        for parent, key in zip(reversed(parents[:-1]), reversed(above), strict=True):
            if len(parent[key]):
                break
            del parent[key]
    elif last not in table or not _replaced(table, last, value):
        table[last] = value


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
