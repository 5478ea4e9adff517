"""What tests of the import share: the small unit read, its stage, the lines told of a component."""

from __future__ import annotations

from typing import Any

from epicyclic.rexs.import_train import RexsImport, read_rexs
from epicyclic.rexs.stages import Entry

__all__ = ["imported", "lines", "stage_of", "value_of"]


def imported(draft: Any, **options: Any) -> RexsImport:
    return read_rexs(draft.xml().encode(), **options)


def stage_of(found: RexsImport, name: str = "main") -> Any:
    return found.document["stages"][name]  # type: ignore[index]


def lines(entries: tuple[Entry, ...], component: int | None) -> str:
    return "; ".join(f"{e.attribute}: {e.path} {e.text}" for e in entries if e.component == component)


def value_of(text: str) -> float:
    return float(text.split()[0])
