"""A sample of the damaged REXS files of `rexs_mutations`, which reads 10 000 of each encoding when run as a script."""

from __future__ import annotations

import random
import time
from collections import Counter
from collections.abc import Callable, Mapping

import pytest
from rexs_mutations import _JSON, _XML, _ZIP, ENCODINGS, SECONDS, Fault, damaged, good_files, tried

Damage = Callable[[random.Random, bytes], bytes]
KINDS: Mapping[str, Mapping[str, Damage]] = {"xml": _XML, "json": _JSON, "zip": _ZIP}
HEAVY = {"many", "nested", "bomb"}  # of long files: one of each


@pytest.fixture(scope="module")
def good() -> list[bytes]:
    return good_files()[:1]


def test_good_files_are_read(good: list[bytes]) -> None:
    assert [tried(one) for one in good] == ["read"]


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_damaged_files_are_read_or_refused(encoding: str, good: list[bytes]) -> None:
    came: Counter[str] = Counter()
    for name, damage in KINDS[encoding].items():
        for seed in range(1 if name in HEAVY else 4):
            raw = damage(random.Random(f"{encoding} {name} {seed}"), good[0])
            begun = time.process_time()
            came[tried(raw).partition(":")[0]] += 1
            assert time.process_time() - begun < SECONDS, (name, seed)
    assert came["refused"] > came["read"] > 0


def test_the_same_seed_is_the_same_damage(good: list[bytes]) -> None:
    for encoding in ENCODINGS:
        assert damaged(good, encoding, 5) == damaged(good, encoding, 5)


def test_a_fault_is_seen(monkeypatch: pytest.MonkeyPatch, good: list[bytes]) -> None:
    monkeypatch.setattr("rexs_mutations.read_rexs", lambda raw: dict[str, object]()["no such key"])
    with pytest.raises(Fault, match="KeyError"):
        tried(good[0])
