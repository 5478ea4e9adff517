"""Frozen data on disk: the same bits, the same layout, one object where it was one; nothing else is read."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic.engine.plain_data import read_plain, write_plain
from epicyclic.errors import ModelError
from epicyclic.questions.contact_loss.branch_set import Measures
from epicyclic.questions.contact_loss.solutions import Stability


@dataclass(frozen=True)
class Stranger:
    number: float = 1.0


def again(path: Path, value: Any, **more: Any) -> Any:
    write_plain(path / "x.kept", value)
    return read_plain(path / "x.kept", **more)


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        3,
        -0.0,
        float("inf"),
        1e-320,
        "text with\nlines",
        1 + 2j,
        Fraction(22, 7),
        (1, [2.0, (None,)], {"a": 1, 2: "b"}),
    ],
)
def test_values_are_themselves(tmp_path: Path, value: object) -> None:
    found = again(tmp_path, value)
    assert type(found) is type(value)
    assert repr(found) == repr(value)


def test_arrays_keep_bits_and_layout(tmp_path: Path) -> None:
    values = np.random.default_rng(1).standard_normal((4, 5, 6))
    every = [
        values,
        values.transpose(2, 0, 1),
        np.asfortranarray(values),
        values[:, ::2] + 1j,
        np.array([np.nan, -0.0]),
        np.zeros((0, 3), np.int64),
        values > 0,
        np.array(["a", "ß"]),
    ]
    for one, other in zip(every, again(tmp_path, every), strict=True):
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
        assert np.argsort(one.strides).tolist() == np.argsort(other.strides).tolist()
        assert other.flags.writeable
    texts = again(tmp_path, np.array(["ok", ""], dtype=object))
    assert texts.dtype == object
    assert texts.tolist() == ["ok", ""]
    number = again(tmp_path, np.float64(0.1))
    assert type(number) is np.float64


def test_dataclasses_are_one_where_they_were_one(tmp_path: Path) -> None:
    level = np.arange(3.0)
    one = Measures(rms=level, highest=level, lowest=level, open=level, amplitude=level, flank=level)
    stability = Stability(multiplier=0.5 + 0.1j, kind="fold", steps=64, error=1e-3)
    found = again(tmp_path, [one, (one, stability)])
    assert found[0] is found[1][0]
    assert found[1][1] == stability
    np.testing.assert_array_equal(found[0].rms, level)


def test_references_to_what_is_elsewhere(tmp_path: Path) -> None:
    stranger = Stranger()
    path = tmp_path / "x.kept"
    write_plain(path, [stranger, stranger], refer=lambda value: ("one", 1) if value is stranger else None)
    found = read_plain(path, restore=lambda key: (stranger, key))
    assert found[0] is found[1]
    assert found[0] == (stranger, ("one", 1))
    with pytest.raises(ModelError, match="not a segment of a run"):
        read_plain(path)


def test_only_data_of_the_package(tmp_path: Path) -> None:
    for value in (Stranger(), object(), np.array([1, "a"], dtype=object), {1, 2}):
        with pytest.raises(TypeError):
            write_plain(tmp_path / "x.kept", value)
    assert not list(tmp_path.iterdir())
    for name in (["os", "system"], ["epicyclic.cli.main", "main"]):
        head = {"value": {"object": 0}, "objects": [{"class": name, "fields": {}}]}
        raw = json.dumps(head).encode() + b"\n"
        (tmp_path / "x.kept").write_bytes(raw + hashlib.sha256(raw).digest())
        with pytest.raises(ModelError, match="is no data"):
            read_plain(tmp_path / "x.kept")


def test_other_bytes_than_were_written_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.kept"
    write_plain(path, {"a": np.arange(4.0), "b": 3})
    raw = path.read_bytes()
    for place in range(len(raw)):
        path.write_bytes(raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :])
        with pytest.raises(ModelError, match="damaged, its bytes are others than were written; allowed: delete"):
            read_plain(path)
    for broken in (b"", raw[:-1], raw + b"0", raw[: len(raw) // 2]):
        path.write_bytes(broken)
        with pytest.raises(ModelError, match="not a segment of a run"):
            read_plain(path)
