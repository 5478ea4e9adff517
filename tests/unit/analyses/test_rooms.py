"""The rooms of the analyses import each other in one direction, as their package says."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import epicyclic.analyses

ROOT = Path(next(iter(epicyclic.analyses.__path__)))


def imports() -> dict[str, set[str]]:
    """Rooms of the analyses that each imports, inside functions and for types too."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in ROOT.glob("*/*.py"):
        text = path.read_text(encoding="utf-8")
        found[path.parent.name] |= set(re.findall(r"from \.\.(\w+)\.\w+ import", text)) - {path.parent.name}
    return found


def test_no_room_of_the_analyses_imports_back() -> None:
    waiting = imports()
    assert waiting["modes"] == set()
    assert "steady" in waiting["sharing"]
    while waiting:
        ready = {room for room, wanted in waiting.items() if not wanted & waiting.keys()}
        assert ready, f"rooms that import each other: {sorted(waiting)}"
        waiting = {room: wanted for room, wanted in waiting.items() if room not in ready}
