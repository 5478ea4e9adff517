"""Sources: what a verb or study takes, read as far as it has not been read.

A source is the name of a ready drive, a path of a model file, a dict, or what has been loaded or assembled already.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..assemble import assemble
from ..errors import ModelError
from ..resolve import load
from ..system.system import System
from ..train.train import Train

__all__ = ["Overrides", "Source", "system_of", "train_of"]

Source = str | Path | Mapping[str, Any] | Train | System
Overrides = Mapping[str, Any]


def train_of(source: Source, *, overrides: Overrides | None = None) -> Train:
    """Load a source unless it is a Train already.

    Raises
    ------
    ModelError : the model is wrong, or overrides are given with what is loaded already.
    """

    if isinstance(source, System):
        raise ModelError("a System has no drawing left: give the model file or the Train", path="source")
    if not isinstance(source, Train):
        return load(source, overrides=overrides)
    if overrides:
        raise ModelError("overrides apply to a model file, not to a Train that is loaded already", path="overrides")
    return source


def system_of(source: Source, *, overrides: Overrides | None = None) -> System:
    """Load and assemble a source, as far as that has not been done.

    Raises
    ------
    ModelError : the model is wrong, or overrides are given with what is loaded already.
    """

    if not isinstance(source, System):
        return assemble(train_of(source, overrides=overrides))
    if overrides:
        raise ModelError("overrides apply to a model file, not to a System that is assembled already", path="overrides")
    return source
