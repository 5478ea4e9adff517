"""Broken files: one message each that names path, value and what is allowed, and never another exception."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from epicyclic.document.document import read
from epicyclic.errors import ModelError


def written(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "model.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def check_message(error: ModelError, case: Any) -> None:
    message = str(error)
    for part in (case.path, case.given, case.allowed):
        assert part in message, f"{part!r} not in {message!r}"
    assert "\n" not in message
    assert "members." not in message, "a table of the schema, not of the file"


def test_base_is_read_and_resolved(base_text: str) -> None:
    from epicyclic.train.resolution import load

    assert load(tomllib.loads(base_text)).planets == {"main": 3}


def test_reading_refuses(read_case: Any, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as error:
        read(written(tmp_path, read_case.text))
    check_message(error.value, read_case)


def test_resolving_refuses(resolve_case: Any, tmp_path: Path) -> None:
    from epicyclic.train.resolution import load

    path = written(tmp_path, resolve_case.text)
    read(path)  # the document itself is well formed
    with pytest.raises(ModelError) as error:
        load(path)
    check_message(error.value, resolve_case)


def test_no_text_at_all(raw: bytes, word: str, tmp_path: Path) -> None:
    path = written(tmp_path, raw)
    with pytest.raises(ModelError) as error:
        read(path)
    assert word in str(error.value)
    assert "model.toml" in str(error.value)
