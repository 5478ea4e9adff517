"""TOML writing: reading gives the same tables back."""

from __future__ import annotations

import tomllib
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from epicyclic.document.tables import to_toml

SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=12),
)
KEYS = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=3)),
    max_leaves=12,
)


@given(st.dictionaries(KEYS, VALUES, max_size=5))
def test_round_trip(table: dict[str, Any]) -> None:
    assert tomllib.loads(to_toml(table)) == table


def test_layout() -> None:
    table = {"a": 1, "b": {"c": {"x": 1.5}, "d": "e"}, "f": {"g": {"h": {}}}}
    assert to_toml(table) == 'a = 1\n\n[b]\nc = { x = 1.5 }\nd = "e"\n\n[f.g.h]\n'
