"""Nonsense never raises anything but ModelError."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from epicyclic.document.document import read
from epicyclic.errors import ModelError

GOOD = [p.read_text() for p in sorted((Path(__file__).parent / "good").glob("*.toml"))]
FAST = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

WORDS = st.sampled_from(
    [
        "sun",
        "main.sun",
        "balance",
        "fit",
        "random",
        "3 mm",
        "[1, 2] um",
        "1 kg",
        "inf",
        "nan",
        "",
        ".",
        "-1 Hz",
        "iso6336",
    ]
)
VALUES = st.recursive(
    st.one_of(st.booleans(), st.integers(), st.floats(), WORDS, st.text(max_size=5), st.none()),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from(
                ["x", "radial", "amplitude", "phase", "sun", "left", "meshes", "kind", "sun-planet", "a", ""]
            ),
            inner,
            max_size=3,
        ),
    ),
    max_leaves=6,
)


def paths(table: dict[str, Any], before: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for name, value in table.items():
        found.append((*before, name))
        if isinstance(value, dict):
            found += paths(value, (*before, name))
    return found


def replaced(table: dict[str, Any], path: tuple[str, ...], value: object) -> dict[str, Any]:
    if len(path) == 1:
        return {**table, path[0]: value}
    return {**table, path[0]: replaced(table[path[0]], path[1:], value)}


def assert_read_or_refused(source: Any, overrides: Any = None) -> bool:
    """Read; only ModelError may be raised, and what is read is finite."""
    try:
        document = read(source, overrides)
    except ModelError:
        return False
    assert not any(isinstance(v, float) and math.isnan(v) for v in document.data.values())
    return True


@given(st.binary(max_size=300))
@FAST
def test_random_bytes(tmp_path_factory: Any, raw: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "random.toml"
    path.write_bytes(raw)
    assert not assert_read_or_refused(path)


@given(st.sampled_from(GOOD), st.data())
@FAST
def test_text_with_a_piece_replaced(tmp_path_factory: Any, text: str, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(start + 30, len(text))))
    piece = data.draw(st.one_of(st.just(""), st.text(max_size=8), WORDS))
    path = tmp_path_factory.getbasetemp() / "mutated.toml"
    path.write_text(text[:start] + piece + text[end:], encoding="utf-8", errors="replace")
    assert_read_or_refused(path)


@given(st.sampled_from([tomllib.loads(text) for text in GOOD]), st.data())
@FAST
def test_value_replaced_by_nonsense(table: dict[str, Any], data: st.DataObject) -> None:
    path = data.draw(st.sampled_from(paths(table)))
    assert_read_or_refused(replaced(table, path, data.draw(VALUES)))


@given(st.sampled_from([tomllib.loads(text) for text in GOOD]), st.data())
@FAST
def test_override_with_nonsense(table: dict[str, Any], data: st.DataObject) -> None:
    known = data.draw(st.sampled_from(paths(table)))
    more = data.draw(st.lists(st.sampled_from(["x", "radial", "left", "sun", "run_out", "", "a b"]), max_size=2))
    assert_read_or_refused(table, {".".join((*known, *more)): data.draw(VALUES)})
