"""The levers of a model as plain tables, as a process sends them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ...errors import ModelError

__all__ = ["levers_at"]


def levers_at(source: Any, overrides: Mapping[str, object]) -> tuple[Mapping[str, Any], ...]:
    """Levers of `answers.levers.levers_of` of a model file, whatever overrides move: a page that is opened again has
    the same ones.  Where the file alone is no model, those of the file with its overrides.

    Raises
    ------
    ModelError : the model cannot be read.
    """
    from ..answers.levers import levers_of

    try:
        found = levers_of(source, {})
    except ModelError:
        found = levers_of(source, overrides)
    return tuple(asdict(one) for one in found)
