"""Paths of overrides as a person writes them, and values of the model file changed by a factor."""

from __future__ import annotations

from collections.abc import Mapping

from ...document.tables import leaves
from ...document.written_numbers import written
from ...train.train import Train

__all__ = ["in_short", "leaves_below", "scaled"]

# Tables whose second key may be left out where the train has one stage.
_STAGED = ("deviations", "operation.speed", "operation.torque", "operation.power")


def in_short(train: Train, path: str, document: Mapping[str, object] | None = None) -> str:
    """A full path as the model file writes it of one stage: without its name, ``run_out`` for ``run_out.amplitude``.

    One value must have one path, or two overrides of it would contradict each other.
    """
    document = dict(leaves(dict(train.document))) if document is None else document
    head, _, last = path.rpartition(".")
    if last == "amplitude" and [p for p in document if p.startswith(f"{head}.")] == [path]:
        path = head
    if len(train.planets) == 1:
        (stage,) = train.planets
        for table in _STAGED:
            if path.startswith(f"{table}.{stage}."):
                return f"{table}.{path.removeprefix(f'{table}.{stage}.')}"
    return path


def leaves_below(train: Train, path: str) -> dict[str, object]:
    """Full path -> value of everything at a path or below it, which may leave out the name of the stage."""
    document = dict(leaves(dict(train.document)))
    for full in (path, *(_with_stage(path, stage) for stage in train.planets)):
        found = {p: value for p, value in document.items() if p == full or p.startswith(f"{full}.")}
        if found:
            return found
    return {}


def _with_stage(path: str, stage: str) -> str:
    table = next((one for one in _STAGED if path.startswith(f"{one}.")), "")
    return f"{table}.{stage}.{path.removeprefix(f'{table}.')}" if table else path


def scaled(train: Train, path: str, factor: float) -> dict[str, object]:
    """Overrides that multiply every number at a path and below it, but for phases; empty where there is none."""
    found: dict[str, object] = {}
    document = dict(leaves(dict(train.document)))
    for leaf, value in leaves_below(train, path).items():
        number = written(value)
        if number is not None and not number.whole and leaf.rpartition(".")[2] != "phase" and any(number.values):
            short = in_short(train, leaf, document)
            found[short] = number.text(tuple(float(f"{factor * one:.6g}") for one in number.values))
    return found
