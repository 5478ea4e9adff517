"""Half of a tolerance as the model file writes it."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ...document.written_numbers import written
from ...teeth.grades import FLANK_GRADES, SIZE_GRADES
from ...train.train import Train
from .paths import in_short

__all__ = ["halved_text", "halved_tolerance"]

_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*", re.DOTALL)
_GRADE = re.compile(r"(.*?(?:IT|:\d{4}\s+))(\d+)(\s*,.*)", re.DOTALL)
# Grades finer that halve a tolerance: of ISO 1328-1 exactly (a step is the root of 2), of ISO 286-1 nearly.
_FINER = 2


def halved_text(text: str) -> str | None:
    """A distribution with half its spread about the same mean, a grade two steps finer; None where there is none, as
    below the finest grade of a standard."""
    call = _CALL.fullmatch(text)
    if call is None:
        return None
    name, inside = call[1], call[2]
    if name == "grade":
        grade = _GRADE.fullmatch(inside)
        if grade is None:
            return None
        finer, known = int(grade[2]) - _FINER, SIZE_GRADES if grade[1].endswith("IT") else FLANK_GRADES
        return f"grade({grade[1]}{finer}{grade[3]})" if finer in known else None
    parts = [part.strip() for part in inside.split(",")]
    numbers = [one for one in map(written, parts) if one is not None]
    if not numbers or len(numbers) < len(parts):
        return None
    if name in ("disc", "rayleigh"):
        return f"{name}({_scaled(parts[0], 0.5)})"
    if name == "normal":
        return f"normal({parts[0]}, {_scaled(parts[1], 0.5)})"
    if name == "uniform" and numbers[0].unit == numbers[-1].unit:
        low, high = numbers[0].values[0], numbers[-1].values[0]
        inner = ((3 * low + high) / 4, (low + 3 * high) / 4)
        return f"uniform({', '.join(f'{end:.6g} {numbers[0].unit}'.rstrip() for end in inner)})"
    if name == "truncated":
        return f"truncated({parts[0]}, {_scaled(parts[1], 0.5)}, {parts[2]}, {parts[3]})"
    return None


def _scaled(text: str, factor: float) -> str:
    number = written(text)
    if number is None:
        return text
    value = f"{factor * number.values[0]:.6g}"
    return f"{value} {number.unit}" if number.unit else value


def halved_tolerance(train: Train, entry: str) -> dict[str, object]:
    """Override that halves an entry of `[tolerance]`; empty where its form has no half.

    entry : path of the entry, with `` common`` or `` own`` behind it where the result tells them apart.
    """
    table = train.document.get("tolerance")
    if not isinstance(table, Mapping):
        return {}
    path, _, part = entry.partition(" ")
    value = table.get(path)
    where = f'tolerance."{in_short(train, path)}"'
    if isinstance(value, str):
        half = halved_text(value)
        return {} if half is None else {where: half}
    if isinstance(value, Mapping):
        parts = (part,) if part else ("own", "common")
        halves = {key: halved_text(one) for key in parts if isinstance(one := value.get(key), str)}
        changed = {**value, **{key: half for key, half in halves.items() if half is not None}}
        return {} if changed == dict(value) else {where: changed}
    return {}
