"""Micro-geometry against the module: a tenth of it is warned of."""

from __future__ import annotations

import pytest

import epicyclic


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("tip_relief", {"amount": "4 mm", "length": "8 mm"}),
        ("crown", "4 mm"),
        ("slope", "-4 mm"),
        ("wave", {"amplitude": "4 mm", "order": 2}),
    ],
)
def test_a_large_amount_is_warned_of_with_its_path(key: str, value: object) -> None:
    warnings = epicyclic.load("ren2021", {f"stages.main.sun.flank.{key}": value}).warnings
    found = [text for text in warnings if "tenth of a module" in text]
    assert any(text.startswith(f"stages.main.sun.flank.{key}") for text in found)


def test_common_amounts_are_not() -> None:
    found = epicyclic.load("ren2021", {"stages.main.sun.flank.crown": "40 um"}).warnings
    assert not any("tenth of a module" in text for text in found)
