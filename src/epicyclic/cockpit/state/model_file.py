"""The model file of a state: its text, the overrides written in and its comments kept; and its fields: keys that it has
or may have, by table, from the schema of the model file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit
from tomlkit.exceptions import TOMLKitError

from ...document.document import read
from ...document.overrides import layer_of, parse_setting, replace_alternatives, stepwise
from ...document.schema import collect
from ...document.tables import PlainTable, keyed, merge, split_path, union, value_at
from ...document.validation import MEMBER_KEYS
from ...document.writer import commented_text
from ...errors import ModelError
from ...terms import ANY, Explanation, Schema, children, explained_paths, forms_of, schema
from .state import Keys, PageState, Spelling, request_of, tables_of, text_spelling, typed_text

# Rounds of writing what still differs from the aim: the first writes the overrides, the second what follows from them
# (masses after teeth, reasons of values that are not assumed any more); the commented writer stands behind.
_ROUNDS = 4
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
    if (edited := _edited(state, aim)) is not None:
        return edited
    head = (f"{state.name} with {len(state.overrides)} values changed; written anew, so without its comments.",)
    return commented_text(aim, head=head)


def written_value(state: PageState, path: str) -> object:
    """The value at a path as it is written, a text with its unit: of an override, else of the file; None: nowhere.

    Raises
    ------
    ModelError : the text is no TOML.
    """
    if (override := overriding(state, path)) is not None:
        return override[1]
    keys = split_path(path, path=path)
    stated = value_at(tables_of(state.base, state.name), keys)
    return stated if stated is not None else value_at(_plain_document(state.base, state.name), keys)


def overriding(state: PageState, path: str) -> tuple[str, object] | None:
    """The newest override of a path, above it or of its place in another spelling, and what it states there."""
    keys = split_path(path, path=path)
    for other, value in reversed(list(state.overrides.items())):
        others = split_path(other, path=other)
        if keys[: len(others)] == others:
            stated = value if others == keys else value_at(value, keys[len(others) :])
            if stated is not None or value is None:
                return other, stated
        elif others[0] == keys[0] and _places(state.base, state.name, other) == _places(state.base, state.name, path):
            return other, value
    return None


def assumed_reason(state: PageState, path: str, assumed: Mapping[str, str]) -> str:
    """Why a value is assumed, "" where it is not or was set.  assumed : reasons of the train, by full path."""
    places = _places(state.base, state.name, path)
    set_with_reason = any(
        not places.isdisjoint(_places(state.base, state.name, ".".join(split_path(key, path=key)[1:])))
        for key in state.overrides
        if key.startswith("assumed.")
    )
    if overriding(state, path) is not None and not set_with_reason:
        return ""
    full = [".".join(place) + "." for place in places]
    over = (
        reason for at, reason in assumed.items() if any(f.startswith(f"{at}.") or f"{at}.".startswith(f) for f in full)
    )
    return next(over, "")


@lru_cache(maxsize=4096)
def _places(base: str, name: str, path: str) -> frozenset[Keys]:
    """Places of the document that a number at a path of a model text gives."""
    return text_spelling(base, name).places_of(split_path(path, path=path), 0.0)


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
            _put(document, Spelling(document.unwrap()).same(keys, value) or keys, value)
        written = tomlkit.dumps(document)
        tables_of(written)
    except _WRONG as error:
        raise ModelError(f"the changes cannot be written into the text: {error}", path=state.name) from None
    return written


def _edited(state: PageState, aim: PlainTable) -> str | None:
    """The text with values changed in place until it reads as the aim; None where it does not come to that."""
    with suppress(*_WRONG):  # what an editor cannot do: the document is written anew
        document = tomlkit.parse(state.base)
        # the overrides whose places the text does not give are written as they are spelled; the others follow
        spelling = text_spelling(state.base, state.name)
        for path, value in state.overrides.items():
            keys = split_path(path, path=path)
            if value is not None and spelling.places_of(keys, value).isdisjoint(spelling.key_of):
                _put(document, _shortened(document, keys), value)
        for _ in range(_ROUNDS):
            written = tomlkit.dumps(document)
            reading = _document(replace(state, base=written, overrides={}))
            if reading == aim:
                return written
            _approach(document, tables_of(written), reading, aim)
    return None


def _approach(document: Any, tables: PlainTable, reading: PlainTable, aim: PlainTable) -> None:
    """Change what differs from the aim, each key where the text has it."""
    spelling, now, wanted = Spelling(tables), dict(keyed(reading)), dict(keyed(aim))
    differing = [place for place in (now | wanted) if now.get(place) != wanted.get(place)]
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
        values = {place: wanted.get(place) for place in sorted(spelling.places[keys])}
        first, *others = values.values()
        if any(other != first for other in others):  # a shorthand of which a part changes: its parts, with their values
            _put(document, keys, None)
            for place, value in values.items():
                if value is not None:
                    _put(document, (*keys[:-1], place[-1]), value)
        elif first is None:
            removed.append(keys)
        else:
            _put(document, keys, first)
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
    else:
        table[last] = value  # the comment behind the old one stays


# fields ---------------------------------------------------------------------------------------------------------------

# The version of the format, which nobody sets by hand; tables that say why, not what; tables whose keys are texts of
# distributions, which no path names.
_LEFT_OUT = ("format", "assumed", "tolerance.cost", "tolerance.correlation")
_SIDES = ("left", "right")  # of a member; a side has none
# Tables by member, or by stage and member where there are several stages.
_BY_MEMBER = (("deviations",), ("operation", "speed"), ("operation", "torque"), ("operation", "power"))
# Tables within tables that a search goes into at most: members, their links, laws of these.
_DEEPEST = 8
# ... and into those that the model does not state: seven hundred fields in all, in some milliseconds
_UNSTATED = 4


class Field(NamedTuple):
    """One key.  path : as `--set` takes it.  text : its value as it is typed; "" where the model does not state it.

    choices : words that may stand there, where nothing else may.
    """

    path: str
    key: str
    text: str = ""
    choices: tuple[str, ...] = ()


class FieldGroup(NamedTuple):
    """One table.  tables : keys of the tables within it; `stated` those that the model has."""

    path: str
    fields: tuple[Field, ...]
    tables: tuple[str, ...]
    stated: frozenset[str]


# the model as it is ---------------------------------------------------------------------------------------------------


def current_tables(state: PageState) -> PlainTable:
    """Tables of the model as they are written, with what was set laid over them; keys with points are tables.

    An override that the file does not take is left out: the failed state says so.
    """
    tables = _unfolded(tables_of(state.base, state.name))
    for step in stepwise(state.overrides):
        for path, value in step.items():
            with suppress(ModelError):
                layer = layer_of({path: value}, tables)
                tables = merge(replace_alternatives(tables, layer), layer)
    return tables


def _unfolded(table: Mapping[str, Any]) -> PlainTable:
    """Tables in which a key `a.b`, in quotes, is a table `a` with `b`."""
    tables: PlainTable = {}
    for key, value in table.items():
        inner: Any = _unfolded(value) if isinstance(value, Mapping) else value
        for word in reversed(key.split(".")):
            inner = {word: inner}
        try:
            tables = union(tables, inner, "")
        except ModelError:
            tables |= inner
    return tables


# the schema -----------------------------------------------------------------------------------------------------------


def _is_leaf(node: Schema) -> bool:
    """Whether a value that is no table may stand there."""
    return any(
        form.get("type") in ("string", "number", "integer", "boolean", "array") or "enum" in form or "const" in form
        for form in forms_of(node)
    )


def _choices(node: Schema) -> tuple[str, ...]:
    """Words that may stand there, where nothing but words and truth values may."""
    words: dict[str, None] = {}
    for form in forms_of(node):
        if form.get("type") == "boolean":
            words |= {"true": None, "false": None}
        elif "enum" in form and all(isinstance(word, str) for word in form["enum"]):
            words |= dict.fromkeys(form["enum"])
        elif "const" in form and isinstance(form["const"], str):
            words[form["const"]] = None
        elif form.get("type") is not None or "enum" in form:
            return ()
    return tuple(words)


# groups and fields ----------------------------------------------------------------------------------------------------


def group_at(tables: Mapping[str, Any], path: str = "") -> FieldGroup:
    """Fields and tables of the table at a path; nothing where the schema has no such table.

    tables : of `current_tables`.
    """
    words = tuple(path.split(".")) if path else ()
    entries = dict(children(schema()))
    for key in words:
        entries = dict(children(entries.get(key) or entries.get(ANY, {})))
    table = value_at(tables, words)
    values = table if isinstance(table, Mapping) else {}
    if len(words) >= 3 and words[0] == "stages":
        # a member and each of its sides have the keys of the member's kind
        kind = collect(tables).stages.get(words[1], {}).get(words[2])
        if kind in MEMBER_KEYS and set(words[3:]) <= set(_SIDES):
            entries = {key: entry for key, entry in entries.items() if key in MEMBER_KEYS[kind]}
    if named := entries.pop(ANY, None):
        entries |= {name: named for name in (*values, *_names_of(tables, words)) if name not in entries}
    fields, inner = [], []
    for key, entry in entries.items():
        where = f"{path}.{key}" if path else key
        if where in _LEFT_OUT or (key in _SIDES and set(words) & set(_SIDES)):
            continue
        # a member that the stage does not have is a topology of another kind: the text, not a field
        if len(words) == 2 and words[0] == "stages" and _is_member(entry) and key not in values:
            continue
        value = values.get(key)
        if any(children(entry)) and (isinstance(value, Mapping) or not _is_leaf(entry)):
            inner.append(key)
        elif _is_leaf(entry):
            text = "" if value is None else typed_text(where, value)
            fields.append(Field(path=where, key=key, text=text, choices=_choices(entry)))
    order = {key: number for number, key in enumerate(values)}
    inner.sort(key=lambda key: order.get(key, len(order)))
    fields.sort(key=lambda field: not field.text)
    stated = frozenset(key for key in inner if key in values)
    return FieldGroup(path=path, fields=tuple(fields), tables=tuple(inner), stated=stated)


def field_at(tables: Mapping[str, Any], path: str) -> Field:
    """One field by its path, as the model has it now."""
    value = value_at(tables, path.split("."))
    text = "" if value is None or isinstance(value, Mapping) else typed_text(path, value)
    return Field(path=path, key=path.rpartition(".")[2], text=text)


def file_value(state: PageState, path: str) -> object:
    """What the file itself states at a path; None where it states nothing."""
    return value_at(_unfolded(tables_of(state.base, state.name)), path.split("."))


def _is_member(node: Schema) -> bool:
    return "$ref" in node and str(node["$ref"]).rpartition("/")[2] in ("Member", "NamedMember")


def _names_of(tables: Mapping[str, Any], words: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the user's that a table may have although the file does not state them there: members of the stage."""
    stages = collect(tables).stages
    if words in _BY_MEMBER:
        return tuple(next(iter(stages.values())) if len(stages) == 1 else stages)
    if len(stages) > 1 and words and words[0] in ("deviations", "operation"):
        return tuple(stages.get(words[-1], ()))
    return ()


def all_fields(tables: Mapping[str, Any], path: str = "", deep: int = 0) -> Iterator[Field]:
    """Fields of the table at a path and of the tables within it that the model has, or could have below its own."""
    group = group_at(tables, path)
    yield from group.fields
    for key in group.tables:
        if deep < (_DEEPEST if key in group.stated else _UNSTATED):
            yield from all_fields(tables, f"{path}.{key}" if path else key, deep + 1)


@lru_cache(maxsize=4096)
def explanation_of(path: str) -> Explanation | None:
    """Meaning, unit, default and what is allowed of a field; None where the schema says nothing of it."""
    # of a side the same holds as of the whole
    spellings = (
        path,
        path.removeprefix("tolerance."),
        ".".join(word for word in path.split(".") if word not in _SIDES),
    )
    return next((found[0] for spelling in spellings if (found := explained_paths(spelling))), None)


# values ---------------------------------------------------------------------------------------------------------------


def typed_value(path: str, text: str) -> object:
    """The value of what was typed, as `--set` reads it; None, which removes the key, where nothing was.

    Raises
    ------
    ModelError : no path.
    """
    split_path(path, path=path)
    return parse_setting(f"{path}={text}")[1]
