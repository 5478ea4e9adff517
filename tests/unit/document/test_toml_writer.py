"""TOML writing: reading gives the same tables back."""

from __future__ import annotations

import tomllib
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from epicyclic.document.tables import value_text
from epicyclic.document.writer import model_text

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
    assert tomllib.loads(f"a = {value_text(table)}")["a"] == table


def test_layout() -> None:
    table = {"title": "t", "stages": {"s": {"sun": {"mass": 1.5, "flank": {}}, "meshes": {}}}}
    assert model_text(table) == (
        'format = 2\ntitle  = "t"\n\n[stages.s]\nmeshes = {}\n\n[stages.s.sun]\nmass  = "1.5 kg"\nflank = {}\n'
    )
