"""Sources of a verb or study: ready drive, model file, dict, Train or System, loaded and assembled as far as needed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import ModelError
from ..system.system import System
from ..train.resolution import load
from ..train.train import Train

Source = str | Path | Mapping[str, Any] | Train | System
"""Name of a ready drive, path of a model file, dict of a model, or a Train or System made from one."""
Overrides = Mapping[str, Any]
"""Path in the model file -> value in its place."""


def train_of(source: Source, *, overrides: Overrides | None = None) -> Train:
    """Resolved Train of a source; a Train is returned as it is.

    Raises
    ------
    ModelError : a wrong model, a System, or overrides of a Train.
    """
    if isinstance(source, System):
        raise ModelError("a System has no drawing left: give the model file or the Train", path="source")
    if not isinstance(source, Train):
        return load(source, overrides=overrides)
    if overrides:
        raise ModelError("overrides apply to a model file, not to a Train that is loaded already", path="overrides")
    return source


def system_of(source: Source, *, overrides: Overrides | None = None) -> System:
    """Assembled System of a source; a System is returned as it is.

    Raises
    ------
    ModelError : a wrong model, or overrides of a Train or System.
    """
    from ..system.assembly import assemble  # only here: `check` and others need no System

    if not isinstance(source, System):
        return assemble(train_of(source, overrides=overrides))
    if overrides:
        raise ModelError("overrides apply to a model file, not to a System that is assembled already", path="overrides")
    return source
