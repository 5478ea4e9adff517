"""The levers of a model as plain tables, as a process sends them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from typing import Any

__all__ = ["levers_at"]


def levers_at(source: Any, overrides: Mapping[str, object]) -> tuple[Mapping[str, Any], ...]:
    """Levers of `answers.levers.levers_of`. Raises ModelError where the model cannot be read."""
    from ..answers.levers import levers_of

    found = levers_of(source, overrides)
    return tuple(asdict(one) if is_dataclass(one) and not isinstance(one, type) else one for one in found)
