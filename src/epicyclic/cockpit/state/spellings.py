"""What the keys of a model text stand for: a key with a shorthand for one or several places of the document."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...document.schema import Names, collect
from ...document.shorthand import expand
from ...document.tables import PlainTable, nested
from ...errors import ModelError

__all__ = ["Keys", "Spelling", "at_path", "keyed", "spelling_of"]

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
        found = {self.key_of.get(place) for place in places}
        key = next(iter(found)) if len(found) == 1 else None
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


def at_path(table: Any, path: Keys) -> Any:
    """The value at a path of nested tables, None where there is none."""
    for key in path:
        if not isinstance(table, Mapping) or key not in table:
            return None
        table = table[key]
    return table


def _places(keys: Keys, value: object, names: Names) -> frozenset[Keys]:
    """Places of one key; the key itself where its value is of a wrong form, which validation names."""
    try:
        return frozenset(found for found, _ in keyed(expand(nested(keys, value), names)))
    except (ModelError, AttributeError, TypeError):
        return frozenset((keys,))
